//! Light that reaches the opaque surfaces of a tile past others and from them: found once for each surface of a pixel.
//!
//! What depth maps and rays say changes slowly from pixel to pixel, and costs more than shading. So it is not found for each of
//! the parts that a fragment may be [split](overcoat_stages::gbuffer::split_fragments) into, but once for all, as if it were whole. The
//! rays of wide lobes are sent once for the surfaces of a block of pixels that are alike, and what they have found is added to what those
//! of other blocks have, in other tiles too: rays are sent in a run of their own before tiles are shaded.

use super::light_filter::{LightFilter, LightWindow};
use super::light_pool::{Groups, KEPT, Kept, NONE, Receiver, TracedTile};
use super::pass::{PROBED, Pass};
use super::shading_order::ShadingOrder;
use super::tile_shading::ShadingInput;
use super::work::Spent;
use overcoat_core::math::lanes::{LANES, Lanes};
use overcoat_core::reuse::reserve_like;
use overcoat_stages::gbuffer::layout::{self, SurfacePlanes};
use overcoat_stages::gbuffer::{Batch, Fragment};
use overcoat_stages::shade::{
    Effect, Found, Senders, SurfacePlace, SurfaceReading, TraceScratch, TracedLight, store_face,
    store_surface,
};

/// Number of hits that are shaded at once: enough that most of sixteen have one material, and no more memory than a
/// tile takes.
const HITS_AT_ONCE: usize = 1 << 13;

/// Rays that are sent at once.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Sends {
    /// All of the first surface of each block, those into narrow lobes of all others.
    First,
    /// Rays into wide lobes of the surfaces that none before them is like.
    Rest,
}

/// Traced light of a tile, in memory that is kept.
#[derive(Debug, Default)]
pub struct TileLight {
    /// The fragments as they were before they were split, in the order of the list.
    whole: Vec<Fragment>,
    /// For each fragment, the place of its whole.
    whole_of: Vec<u32>,
    /// The planes of each whole fragment, once they are filled.
    rows: Vec<Kept>,
    /// Light of the receivers of one pixel and group, where their first is.
    pooled: Vec<Found>,
    /// Receivers that send the rays of wide lobes once groups are known.
    left: Vec<u32>,
    is_left: Vec<bool>,
    /// For each receiver the place of what it takes.
    pooled_at: Vec<u32>,
    /// Fragments whose light is found, in the order in which it is, and the materials of them: each with the end of its
    /// stretch.
    order: Vec<u32>,
    stretches: Vec<(u32, usize)>,
    groups: Groups,
    window: LightWindow,
    trace: TraceScratch,
}

impl TileLight {
    /// Takes as much memory as `other` has.
    pub fn reserve_like(&mut self, other: &Self) {
        reserve_like(&mut self.whole, &other.whole);
        reserve_like(&mut self.whole_of, &other.whole_of);
        reserve_like(&mut self.rows, &other.rows);
        reserve_like(&mut self.pooled, &other.pooled);
        reserve_like(&mut self.left, &other.left);
        reserve_like(&mut self.is_left, &other.is_left);
        reserve_like(&mut self.pooled_at, &other.pooled_at);
        reserve_like(&mut self.order, &other.order);
        reserve_like(&mut self.stretches, &other.stretches);
        self.groups.reserve_like(&other.groups);
        self.window.reserve_like(&other.window);
    }

    /// Sends the rays of the opaque fragments of a tile, into what is kept of it. False if a limit stops it.
    #[inline(always)]
    pub fn send_all<L: Lanes>(
        &mut self,
        l: L,
        (pass, traced): (&Pass<'_>, &TracedLight<'_>),
        input: &ShadingInput<'_>,
        order: &ShadingOrder,
        (batch, planes): (&mut Batch, &mut SurfacePlanes),
        out: &mut TracedTile,
    ) -> bool {
        // Rays of earlier pictures cost this one nothing.
        self.trace.forget();
        self.list(&input.fragments[..input.opaque]);
        out.start(self.whole.len(), input.tile.size, traced.samples.block());
        self.list_receivers(pass, order, input);
        let mut place = SurfacePlace::none(l);
        for sends in [Sends::First, Sends::Rest] {
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
                    let of = (number, &reading, sends);
                    self.send(l, (pass, traced), input, of, places, (memory, &mut *out));
                    if self.trace.waiting() >= HITS_AT_ONCE {
                        traced.shade_hits(l, &pass.frame.shade, &mut self.trace, &mut out.found);
                    }
                }
                listed = end;
            }
            if pass.probes() {
                return true;
            }
            if sends == Sends::First {
                out.group(&self.whole, &mut self.groups, &mut self.left);
                self.keep_left();
            }
        }
        traced.shade_hits(l, &pass.frame.shade, &mut self.trace, &mut out.found);
        out.add_up();
        true
    }

    /// Keeps of the listed receivers those that are left to send.
    fn keep_left(&mut self) {
        let Self { order, stretches, left, is_left, whole, .. } = self;
        is_left.clear();
        is_left.resize(whole.len(), false);
        left.iter().for_each(|number| is_left[*number as usize] = true);
        let (mut listed, mut kept) = (0, 0);
        for (_, end) in stretches {
            for place in listed..*end {
                let number = order[place];
                if is_left[number as usize] {
                    order[kept] = number;
                    kept += 1;
                }
            }
            listed = std::mem::replace(end, kept);
        }
        order.truncate(kept);
    }

    /// Finds the light of the opaque fragments of a tile, of what the rays of it and its neighbours have found.
    #[inline(always)]
    pub fn find<L: Lanes>(
        &mut self,
        l: L,
        (pass, traced): (&Pass<'_>, &TracedLight<'_>),
        input: &ShadingInput<'_>,
        order: &ShadingOrder,
        planes: &mut SurfacePlanes,
    ) {
        self.list(&input.fragments[..input.opaque]);
        self.list_receivers(pass, order, input);
        let (tile, around) = (input.tile, pass.traced_tiles);
        let Some(own) = around.and_then(|around| around.tile(around.grid.tile_of(tile.corner))) else {
            return;
        };
        let Self { whole, rows, pooled, pooled_at, window, .. } = self;
        rows.clear();
        rows.extend_from_slice(&own.rows);
        pooled.clear();
        pooled.resize(own.receivers.len(), Found::default());
        pooled_at.clear();
        pooled_at.extend(0..own.receivers.len() as u32);
        if own.leaders.iter().any(|leader| *leader != NONE) {
            let block = traced.samples.block();
            around.into_iter().for_each(|around| window.fill(around, tile.corner, tile.size, block));
            let filter = LightFilter::new(window, traced.samples.period(), block);
            let mut first = 0;
            for (number, (receiver, fragment)) in own.receivers.iter().zip(&*whole).enumerate() {
                if whole[first].pixel != fragment.pixel {
                    first = number;
                }
                let leader = own.leaders[number];
                let Some(group) = own.sums.get(leader as usize) else { continue };
                if let Some(same) = (first..number).find(|other| own.leaders[*other] == leader) {
                    pooled_at[number] = same as u32;
                    continue;
                }
                let at = [fragment.column(), fragment.row()];
                pooled[number] = l.run(
                    #[inline(always)]
                    || filter.taken(l, receiver, at, (&own.found[number], group)),
                );
            }
        }
        self.store(l, pass, own, planes);
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
    }

    /// Lists those of which light is found, in the order of shading.
    fn list_receivers(&mut self, pass: &Pass<'_>, order: &ShadingOrder, input: &ShadingInput<'_>) {
        let Self { whole: all, whole_of, order: out, stretches, .. } = self;
        let (opaque, [left, top]) = (input.opaque, input.tile.corner);
        let sends = |fragment: &Fragment| pass.sends_from([left + fragment.column(), top + fragment.row()]);
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
                if last != Some(*whole) && sends(&all[*whole as usize]) {
                    out.push(*whole);
                }
                last = Some(*whole);
            }
            stretches.push((number, out.len()));
        }
    }

    /// Looks up the depth maps for up to sixteen receivers of a material, if that is not done, and sends their rays.
    #[inline(always)]
    fn send<L: Lanes>(
        &mut self,
        l: L,
        (pass, traced): (&Pass<'_>, &TracedLight<'_>),
        input: &ShadingInput<'_>,
        (number, reading, sends): (u32, &SurfaceReading<'_>, Sends),
        places: std::ops::Range<usize>,
        ((batch, place, planes), out): (
            (&mut Batch, &mut SurfacePlace<L>, &mut SurfacePlanes),
            &mut TracedTile,
        ),
    ) {
        let (frame, tile) = (pass.frame, input.tile);
        let (context, material) = (&frame.shade, reading.material);
        let Self { whole, order, trace, .. } = self;
        let places = &order[places];
        batch.gather(whole, places, &input.triangles, tile.origin, frame.pattern);
        place.find(l, context, reading, batch);
        store_surface(l, context, reading, batch, place, planes);
        store_face(l, context, batch, place, planes);
        let pixels = batch.fragments.map(|f| [tile.corner[0] + f.column(), tile.corner[1] + f.row()]);
        let mut senders = Senders { places, pixels: &pixels, wide: 0, narrow: u16::MAX };
        if sends == Sends::Rest {
            for (lane, &place) in places.iter().enumerate() {
                for (row, kept) in planes.rows[KEPT].iter_mut().zip(&out.rows[place as usize]) {
                    row[lane] = *kept;
                }
            }
            (senders.wide, senders.narrow) = (u16::MAX, 0);
            traced.send(l, context, material, &senders, planes, (trace, &mut out.found));
            return;
        }
        traced.occlusion.fill(l, context, material, planes);
        if pass.probes() {
            // Each pixel sends rays into narrow lobes, about two of four into wide ones.
            let pixels = u64::from(PROBED * PROBED);
            let block = u64::from(traced.samples.block());
            for (wide, narrow, stands_for) in [(0, u16::MAX, pixels), (u16::MAX, 0, pixels / block)] {
                (senders.wide, senders.narrow) = (wide, narrow);
                traced.send(l, context, material, &senders, planes, (trace, &mut out.found));
                let units = trace.take_cost(traced.hierarchy, frame.costs).saturating_mul(stands_for);
                pass.work.spend(Spent::Shading, units);
            }
            return;
        }
        for (lane, &place) in places.iter().enumerate() {
            senders.wide |= u16::from(out.is_first(whole, place as usize)) << lane;
        }
        let wants = traced.send(l, context, material, &senders, planes, (trace, &mut out.found));
        for (lane, &place) in places.iter().enumerate() {
            for (kept, row) in out.rows[place as usize].iter_mut().zip(&planes.rows[KEPT]) {
                *kept = row[lane];
            }
            out.receivers[place as usize] = Receiver::new(number, planes, lane, &wants);
        }
    }

    /// Keeps what all that was found comes to.
    #[inline(always)]
    fn store<L: Lanes>(&mut self, l: L, pass: &Pass<'_>, own: &TracedTile, planes: &mut SurfacePlanes) {
        let Self { rows, pooled: sums, pooled_at, order, stretches, .. } = self;
        let mut listed = 0;
        for &(number, end) in &*stretches {
            let material = &pass.frame.shade.materials[number as usize];
            for places in order[listed..end].chunks(LANES) {
                let mut pooled = [Found::default(); LANES];
                for (lane, &place) in places.iter().enumerate() {
                    for (row, kept) in planes.rows[KEPT].iter_mut().zip(&rows[place as usize]) {
                        row[lane] = *kept;
                    }
                    let receiver = &own.receivers[place as usize];
                    planes.rows[layout::ROUGHNESS.first][lane] = receiver.roughness[0];
                    planes.rows[layout::COAT_ROUGHNESS.first][lane] = receiver.roughness[1];
                    pooled[lane] = own.pooled(place as usize, &sums[pooled_at[place as usize] as usize]);
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
