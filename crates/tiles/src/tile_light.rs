//! Light that reaches the opaque surfaces of a tile past others and from them: found once for each surface of a pixel.
//!
//! What depth maps and rays say changes slowly from pixel to pixel, and costs more than shading. So it is not found for each of
//! the parts that a fragment may be [split](overcoat_stages::gbuffer::split_fragments) into, but once for all, as if it were whole; and
//! what the few rays of one pixel have found is added to what those of its neighbours have (`light_pool.rs`).

use super::light_pool::{Pool, Receiver};
use super::pass::Pass;
use super::shading_order::ShadingOrder;
use super::tile_shading::ShadingInput;
use overcoat_core::math::lanes::{LANES, Lanes};
use overcoat_core::reuse::reserve_like;
use overcoat_stages::gbuffer::layout::{self, SurfacePlanes};
use overcoat_stages::gbuffer::{Batch, Fragment};
use overcoat_stages::shade::{
    Effect, Found, Senders, SurfacePlace, SurfaceReading, TraceScratch, TracedLight, store_face,
    store_surface,
};

/// Rows that are kept of each receiver: those that depth maps and rays fill.
const KEPT: std::ops::Range<usize> = layout::DIFFUSE_SEEN.first..layout::BACKDROP_COLOR.first;

/// So many hits are shaded at once: enough that most of sixteen have one material, and no more memory than a tile takes.
const HITS_AT_ONCE: usize = 1 << 13;

/// What is found of a tile, in memory that is kept.
#[derive(Debug, Default)]
pub struct TileLight {
    /// The fragments as they were before they were split, in the order of the list.
    whole: Vec<Fragment>,
    /// For each fragment, the place of its whole.
    whole_of: Vec<u32>,
    /// The planes of each whole fragment.
    rows: Vec<[f32; KEPT.end - KEPT.start]>,
    found: Vec<Found>,
    receivers: Vec<Receiver>,
    /// Those that are found, in the order in which they are, and the materials of them: each with the end of its stretch.
    order: Vec<u32>,
    stretches: Vec<(u32, usize)>,
    pool: Pool,
    trace: TraceScratch,
}

impl TileLight {
    /// Takes as much memory as `other` has.
    pub fn reserve_like(&mut self, other: &Self) {
        reserve_like(&mut self.whole, &other.whole);
        reserve_like(&mut self.whole_of, &other.whole_of);
        reserve_like(&mut self.rows, &other.rows);
        reserve_like(&mut self.found, &other.found);
        reserve_like(&mut self.receivers, &other.receivers);
        reserve_like(&mut self.order, &other.order);
        reserve_like(&mut self.stretches, &other.stretches);
        self.pool.reserve_like(&other.pool);
    }

    /// Finds the light of the opaque fragments of a tile. False if a limit stops it.
    #[inline(always)]
    pub fn find<L: Lanes>(
        &mut self,
        l: L,
        pass: &Pass<'_>,
        traced: &TracedLight<'_>,
        input: &ShadingInput<'_>,
        order: &ShadingOrder,
        (batch, planes): (&mut Batch, &mut SurfacePlanes),
    ) -> bool {
        self.list(&input.fragments[..input.opaque]);
        self.list_receivers(pass, order, input.opaque);
        let mut place = SurfacePlace::none(l);
        let mut listed = 0;
        for stretch in 0..self.stretches.len() {
            let (number, end) = self.stretches[stretch];
            let material = &pass.frame.shade.materials[number as usize];
            let reading = SurfaceReading::of(&pass.frame.shade, material, false);
            for first in (listed..end).step_by(LANES) {
                if pass.work.is_stopped() {
                    // The next picture has other fragments.
                    self.trace.forget();
                    return false;
                }
                let places = first..end.min(first + LANES);
                let memory = (&mut *batch, &mut place, &mut *planes);
                self.send(l, (pass, traced), input, (number, &reading), places, memory);
                if self.trace.waiting() >= HITS_AT_ONCE {
                    traced.shade_hits(l, &pass.frame.shade, &mut self.trace, &mut self.found);
                }
            }
            listed = end;
        }
        traced.shade_hits(l, &pass.frame.shade, &mut self.trace, &mut self.found);
        self.store(l, pass, input, planes);
        true
    }

    /// Lists whole fragments.
    fn list(&mut self, fragments: &[Fragment]) {
        self.whole.clear();
        self.whole_of.clear();
        for fragment in fragments {
            match self.whole.last_mut() {
                Some(last) if (last.pixel, last.triangle) == (fragment.pixel, fragment.triangle) => {
                    last.mask |= fragment.mask;
                }
                _ => self.whole.push(*fragment),
            }
            self.whole_of.push(self.whole.len() as u32 - 1);
        }
        self.rows.resize(self.whole.len(), [0.0; KEPT.end - KEPT.start]);
        self.receivers.clear();
        self.receivers.resize(self.whole.len(), Receiver::default());
        self.found.clear();
        self.found.resize(self.whole.len(), Found::default());
    }

    /// Lists those of which light is found, in the order of shading.
    fn list_receivers(&mut self, pass: &Pass<'_>, order: &ShadingOrder, opaque: usize) {
        let Self { whole_of, order: out, stretches, .. } = self;
        out.clear();
        stretches.clear();
        let mut listed = 0;
        for &(number, end) in &order.stretches {
            let indices = &order.indices[listed..end];
            listed = end;
            if pass.frame.shade.materials[number as usize].unlit {
                continue;
            }
            let mut last = None;
            for whole in indices
                .iter()
                .filter_map(|index| whole_of.get(*index as usize).filter(|_| (*index as usize) < opaque))
            {
                if last != Some(*whole) {
                    out.push(*whole);
                }
                last = Some(*whole);
            }
            stretches.push((number, out.len()));
        }
    }

    /// Looks up the depth maps for up to sixteen receivers of a material, and sends their rays.
    #[inline(always)]
    fn send<L: Lanes>(
        &mut self,
        l: L,
        (pass, traced): (&Pass<'_>, &TracedLight<'_>),
        input: &ShadingInput<'_>,
        (number, reading): (u32, &SurfaceReading<'_>),
        places: std::ops::Range<usize>,
        (batch, place, planes): (&mut Batch, &mut SurfacePlace<L>, &mut SurfacePlanes),
    ) {
        let (frame, tile) = (pass.frame, input.tile);
        let (context, material) = (&frame.shade, reading.material);
        let Self { whole, rows, found, receivers, order, trace, .. } = self;
        let places = &order[places];
        batch.gather(whole, places, &input.triangles, tile.origin, frame.pattern);
        place.find(l, context, reading, batch);
        store_surface(l, context, reading, batch, place, planes);
        store_face(l, context, batch, place, planes);
        traced.occlusion.fill(l, context, material, planes);
        let pixels = batch.fragments.map(|f| [tile.corner[0] + f.column(), tile.corner[1] + f.row()]);
        traced.send(l, context, material, &Senders { places, pixels: &pixels }, planes, (trace, found));
        for (lane, &place) in places.iter().enumerate() {
            for (kept, row) in rows[place as usize].iter_mut().zip(&planes.rows[KEPT]) {
                *kept = row[lane];
            }
            receivers[place as usize] = Receiver::new(number, planes, lane);
        }
    }

    /// Adds up what neighbours have found, and keeps what it comes to.
    #[inline(always)]
    fn store<L: Lanes>(
        &mut self,
        l: L,
        pass: &Pass<'_>,
        input: &ShadingInput<'_>,
        planes: &mut SurfacePlanes,
    ) {
        let Self { whole, rows, found, receivers, order, stretches, pool, .. } = self;
        pool.add_up(whole, receivers, found, input.tile.size);
        let mut listed = 0;
        for &(number, end) in &*stretches {
            let material = &pass.frame.shade.materials[number as usize];
            for places in order[listed..end].chunks(LANES) {
                let mut pooled = [Found::default(); LANES];
                for (lane, &place) in places.iter().enumerate() {
                    for (row, kept) in planes.rows[KEPT].iter_mut().zip(&rows[place as usize]) {
                        row[lane] = *kept;
                    }
                    let receiver = &receivers[place as usize];
                    planes.rows[layout::ROUGHNESS.first][lane] = receiver.roughness[0];
                    planes.rows[layout::COAT_ROUGHNESS.first][lane] = receiver.roughness[1];
                    pooled[lane] = pool.sum(place, &found[place as usize]);
                }
                Found::store(l, material, &pooled, planes);
                for (lane, &place) in places.iter().enumerate() {
                    for (kept, row) in rows[place as usize].iter_mut().zip(&planes.rows[KEPT]) {
                        *kept = row[lane];
                    }
                }
            }
            listed = end;
        }
    }

    /// Writes what was found of up to sixteen fragments into their planes.
    #[inline(always)]
    pub fn load(&self, indices: &[u32], planes: &mut SurfacePlanes) {
        for (lane, index) in indices.iter().enumerate() {
            let kept = &self.rows[self.whole_of[*index as usize] as usize];
            for (row, kept) in planes.rows[KEPT].iter_mut().zip(kept) {
                row[lane] = *kept;
            }
        }
    }
}
