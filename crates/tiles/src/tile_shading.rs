//! The fragments of a tile, from the triangles that they belong to, to their radiance.

use super::aov::AovBatch;
use super::pass::{FrameContext, Pass, Tile};
use super::reach::CELL;
use super::resolve::{TilePixels, Transmitted, whole_pixel};
use super::shading_order::ShadingOrder;
use super::tile_light::TileLight;
use super::tile_pass::TileJob;
use super::tile_triangles::TileTriangles;
use super::trace::FragmentHashes;
use super::work::Spent;
use overcoat_core::each;
use overcoat_core::math::lanes::{LANES, Lanes};
use overcoat_core::math::vec3::{V3, Vec3};
use overcoat_core::reuse::reserve_like;
use overcoat_scene::{Material, ShadingModel};
use overcoat_stages::gbuffer::layout::{self, SurfacePlanes};
use overcoat_stages::gbuffer::{Batch, Fragment};
use overcoat_stages::shade::{
    Effects, ShadeContext, SurfacePlace, SurfaceReading, TraceScratch, ask_for_textures, pass_through, shade,
    store_face, store_lit, store_surface, store_transmission,
};

/// Input for shading the fragments of a tile, or of a part of it.
pub struct ShadingInput<'a> {
    pub tile: &'a Tile<'a>,
    /// With the lights that reach the tile.
    pub context: &'a ShadeContext<'a>,
    pub triangles: TileTriangles<'a>,
    pub fragments: &'a [Fragment],
    /// The first that is not shaded yet.
    pub start: usize,
    /// Number of opaque fragments: the first in the list.
    pub opaque: usize,
    /// The material of all triangles, if it is one.
    pub one_material: Option<u32>,
    /// The mask of fragments that are their pixel, unless something is blended.
    pub whole: Option<u16>,
}

/// Shading result of a fragment.
#[derive(Clone, Copy, Debug, Default)]
pub struct ShadedFragment {
    /// Radiance, not multiplied by opacity, but for transmissive surfaces.
    pub radiance: [f32; 3],
    /// Opacity.
    pub alpha: f32,
    /// Depth as the rasterizer compares it.
    pub depth: f32,
}

/// Shading results of the fragments of a tile, in the order of the fragments.
#[derive(Debug, Default)]
pub struct Shaded {
    /// Each; those that are their pixel are not here but in the pixels.
    pub fragments: Vec<ShadedFragment>,
    /// Transmission of each, where the tile has transmissive ones; else none.
    pub transmitted: Vec<Option<Transmitted>>,
}

impl Shaded {
    /// Makes room for all fragments, of which those before `start` are there.
    pub fn resize(&mut self, input: &ShadingInput<'_>) {
        // Not cleared: what the resolve reads is written by the shading.
        self.fragments.resize(input.fragments.len(), ShadedFragment::default());
        if input.tile.transmissive {
            self.transmitted.truncate(input.start);
            self.transmitted.resize(input.fragments.len(), None);
        }
    }

    /// Takes as much memory as `other` has.
    pub fn reserve_like(&mut self, other: &Self) {
        reserve_like(&mut self.fragments, &other.fragments);
        reserve_like(&mut self.transmitted, &other.transmitted);
    }
}

/// Working memory of the shading.
#[derive(Debug, Default)]
pub struct ShadingScratch {
    order: ShadingOrder,
    /// The fragments that are being shaded, and those that are next.
    batches: [Batch; 2],
    /// The G-buffer of those that are being shaded.
    planes: SurfacePlanes,
    trace: TraceScratch,
    light: TileLight,
}

impl ShadingScratch {
    /// Takes as much memory as `other` has.
    pub fn reserve_like(&mut self, other: &Self) {
        self.order.reserve_like(&other.order);
        self.light.reserve_like(&other.light);
    }
}

/// State that batches of one material have in common.
struct OneMaterial<'a> {
    /// Its place in the scene.
    number: u32,
    material: &'a Material,
    model: ShadingModel,
    reading: SurfaceReading<'a>,
}

impl<'a> OneMaterial<'a> {
    #[inline(always)]
    fn new(frame: &FrameContext<'a>, number: u32, shows_lobes: bool) -> Self {
        let material = &frame.shade.materials[number as usize];
        let model = material.shading(frame.shade.model);
        let reading = SurfaceReading::of(&frame.shade, material, model.reads_lobes() || shows_lobes);
        Self { number, material, model, reading }
    }
}

/// Up to sixteen fragments that are shaded.
struct ShadedBatch<'a> {
    of: &'a OneMaterial<'a>,
    batch: &'a Batch,
    planes: &'a SurfacePlanes,
    /// Their places in the list of the tile.
    indices: &'a [u32],
}

/// Shades the fragments of the input, sixteen of one material at a time: into the pixels those that are whole ones, the others
/// into `out`, which has room for all. False if a limit stops it.
#[inline(always)]
pub fn shade_fragments<L: Lanes>(
    l: L,
    pass: &Pass<'_>,
    input: &ShadingInput<'_>,
    scratch: &mut ShadingScratch,
    out: &mut Shaded,
    pixels: &mut TilePixels,
    job: &mut TileJob,
) -> bool {
    let &ShadingInput { context, ref triangles, fragments, .. } = input;
    let (frame, origin) = (pass.frame, input.tile.origin);
    let ShadingScratch { order, batches, planes, trace, light } = scratch;
    let [mut batch, mut following] = batches.each_mut();

    // List the fragments in their order of shading, and count what that takes before it is done.
    find_order(frame, input, order, job.aovs.is_wanted());
    let units = if pass.probes() { 0 } else { opaque_shading(frame, input, order) };
    job.cost.shading += units;
    if !pass.work.spend(Spent::Shading, units) {
        return false;
    }
    if pass.gives_feedback() {
        give_feedback(l, pass, input, order, batch, job.aovs.wants_lobes());
    }
    let traced = &pass.effects.traced;
    if pass.traces() {
        let memory = (&mut *batch, planes);
        return match traced {
            Some(traced) => light.send_all(l, (pass, traced), input, order, memory, &mut job.traced),
            None => true,
        };
    }
    if pass.only_counts() {
        return true;
    }

    // Find the light that reaches opaque surfaces past others, once for the parts of each.
    let found_first = traced.is_some() && input.start == 0;
    if let Some(traced) = traced
        && found_first
    {
        light.find(l, (pass, traced), input, order, planes);
    }

    let mut place = SurfacePlace::none(l);
    let mut listed = 0;
    for &(number, end) in &order.stretches {
        let indices = &order.indices[listed..end];
        let is_found = found_first && indices.iter().all(|index| (*index as usize) < input.opaque);
        listed = end;
        let of = OneMaterial::new(frame, number, job.aovs.wants_lobes());
        let part = |k: usize| indices.chunks(LANES).nth(k);

        // Gather the first sixteen of the material, and find where they read its textures.
        if let Some(first) = part(0) {
            batch.gather(fragments, first, triangles, origin, frame.pattern);
            place.find(l, context, &of.reading, batch);
        }
        for (number, indices) in indices.chunks(LANES).enumerate() {
            if pass.work.is_stopped() {
                return false;
            }

            // Gather the next, and ask for the triangles of those after them.
            let next = part(number + 1);
            if let Some(next) = next {
                following.gather(fragments, next, triangles, origin, frame.pattern);
                following.vertices.prefetch(frame.shade.draws);
            }
            for &index in part(number + 2).unwrap_or_default() {
                triangles.prefetch(fragments[index as usize].triangle);
            }

            // Fill the G-buffer: the surface, and what of the light it lets through.
            store_surface(l, context, &of.reading, batch, &mut place, planes);
            if of.material.transmits() {
                store_transmission(l, context, of.material, batch, &place, planes);
            }
            if pass.effects.occlusion.is_some() {
                store_face(l, context, batch, &place, planes);
                store_lit(l, context, of.material, batch, &place, planes);
            }

            // Find where the next read their textures: what these read is read.
            if next.is_some() {
                place.find(l, context, &of.reading, following);
            }

            // Fill what the rest of the picture has to do with them, and shade them, unless only the surface is wanted.
            let only_describes = pass.only_describes();
            if is_found {
                light.load(indices, planes);
                Effects { occlusion: None, ..pass.effects }.fill(l, context, of.material, planes);
            } else if !only_describes {
                pass.effects.fill(l, context, of.material, planes);
                if let Some(traced) = traced {
                    let pixels = batch
                        .fragments
                        .map(|f| [input.tile.corner[0] + f.column(), input.tile.corner[1] + f.row()]);
                    // What is hit may lie where lights shine that do not reach the tile.
                    traced.fill(l, &frame.shade, of.material, (indices.len(), &pixels), planes, trace);
                }
            }
            let radiance = if only_describes {
                Vec3::splat(l, [0.0; 3])
            } else {
                let radiance = shade(l, context, of.model, of.material, planes);
                let radiance = match frame.relief {
                    Some(relief) => {
                        let (corner, opaque) = (input.tile.corner, input.opaque);
                        let factors = relief.factors(corner, batch, frame.shade.draws, indices, opaque);
                        radiance * l.load(&factors)
                    }
                    None => radiance,
                };
                if of.material.transmits() {
                    add_transmitted(l, context, &of, planes, indices, radiance, out)
                } else {
                    radiance
                }
            };

            // Hand them on: to the pixels or the resolve, to hashes and to planes for users.
            let done = ShadedBatch { of: &of, batch, planes, indices };
            hand_on(input, &done, radiance.to_arrays(), out, pixels);
            describe(pass, input, &done, &out.fragments, job);
            std::mem::swap(&mut batch, &mut following);
        }
    }
    true
}

/// Requests the textures that the fragments of the input read.
#[inline(never)]
fn give_feedback<L: Lanes>(
    l: L,
    pass: &Pass<'_>,
    input: &ShadingInput<'_>,
    order: &ShadingOrder,
    batch: &mut Batch,
    shows_lobes: bool,
) {
    let (frame, origin) = (pass.frame, input.tile.origin);
    let mut listed = 0;
    for &(number, end) in &order.stretches {
        let of = OneMaterial::new(frame, number, shows_lobes);
        if !of.material.textures().any(|read| frame.shade.textures[read.texture.index()].bands().is_some()) {
            listed = end;
            continue;
        }
        for indices in order.indices[listed..end].chunks(LANES) {
            batch.gather(input.fragments, indices, &input.triangles, origin, frame.pattern);
            ask_for_textures(l, input.context, &of.reading, batch);
        }
        listed = end;
    }
}

/// Orders the fragments for shading.
#[inline(always)]
fn find_order(frame: &FrameContext<'_>, input: &ShadingInput<'_>, order: &mut ShadingOrder, as_listed: bool) {
    let triangles = &input.triangles;
    let material_of = |identity: usize| frame.shade.draws[triangles.draw(identity as u32) as usize].material;
    let count = triangles.identities.len();
    // Planes for users are summed as fragments are shaded: in an order that does not depend on the tiles.
    order.find(input.fragments, input.start, count, input.one_material, &material_of, as_listed);
}

/// Adds what passes through surfaces to their radiance, and writes down what they leave of what is behind them.
#[inline(always)]
fn add_transmitted<L: Lanes>(
    l: L,
    context: &ShadeContext<'_>,
    of: &OneMaterial<'_>,
    planes: &SurfacePlanes,
    indices: &[u32],
    radiance: V3<L>,
    out: &mut Shaded,
) -> V3<L> {
    let passed = pass_through(l, context, of.material, planes, radiance);
    if of.material.is_transmissive() && !out.transmitted.is_empty() {
        let open = passed.open.to_arrays();
        let keep = passed.keep.to_arrays();
        for (k, &index) in indices.iter().enumerate() {
            out.transmitted[index as usize] =
                Some(Transmitted { open: each!(c => open[c][k]), keep: each!(c => keep[c][k]) });
        }
    }
    passed.radiance
}

/// Writes the radiance of whole pixels to where they are, and that of other fragments to their list.
#[inline(always)]
fn hand_on(
    input: &ShadingInput<'_>,
    done: &ShadedBatch<'_>,
    radiance: [[f32; LANES]; 3],
    out: &mut Shaded,
    pixels: &mut TilePixels,
) {
    let alpha = &done.planes.rows[layout::ALPHA.first];
    let depth = &done.planes.rows[layout::DEPTH.first];
    for (k, &index) in done.indices.iter().enumerate() {
        let radiance = [radiance[0][k], radiance[1][k], radiance[2][k]];
        let fragment = &done.batch.fragments[k];
        if Some(fragment.mask) == input.whole {
            let pixel = pixels.index(fragment);
            pixels.linear[pixel] = whole_pixel(radiance);
        } else {
            out.fragments[index as usize] = ShadedFragment { radiance, alpha: alpha[k], depth: depth[k] };
        }
    }
}

/// Adds a batch to the planes for users and to the hashes of its stages, where they are wanted.
#[inline(always)]
fn describe(
    pass: &Pass<'_>,
    input: &ShadingInput<'_>,
    done: &ShadedBatch<'_>,
    shaded: &[ShadedFragment],
    job: &mut TileJob,
) {
    let (frame, has_maps) = (pass.frame, pass.effects.occlusion.is_some());
    let &ShadedBatch { of, batch, planes, indices } = done;
    if let Some(hashes) = &mut job.hashes {
        add_hashes(hashes, input, done, shaded, has_maps);
    }
    if job.aovs.is_wanted() {
        let (material, unlit, draws) = (of.number, of.material.unlit, frame.shade.draws);
        let (opaque, samples) = (input.opaque, frame.pattern.len());
        let (rays, origin) = (&frame.shade.rays, input.tile.origin);
        job.aovs.add(&AovBatch {
            batch,
            planes,
            material,
            unlit,
            draws,
            indices,
            opaque,
            samples,
            rays,
            origin,
        });
    }
}

/// Adds a batch to the hashes: samples, surface, what shading made of it.
#[inline(never)]
fn add_hashes(
    hashes: &mut FragmentHashes,
    input: &ShadingInput<'_>,
    done: &ShadedBatch<'_>,
    shaded: &[ShadedFragment],
    has_maps: bool,
) {
    let corner = input.tile.corner;
    let rows = if done.of.model.reads_lobes() { layout::SURFACE } else { layout::CORE };
    for (lane, &index) in done.indices.iter().enumerate() {
        let fragment = &input.fragments[index as usize];
        // Of points, the number among those of their chunk, likewise.
        let (chunk, triangle) = input.triangles.identities[fragment.triangle as usize];
        let key = [corner[0] + fragment.column(), corner[1] + fragment.row(), chunk, triangle];
        hashes.add_samples(key, fragment.mask);
        hashes.add_surface(key, done.planes, rows.clone(), lane);
        if has_maps && !done.of.material.unlit {
            hashes.add_visibility(key, done.planes, done.of.material.coat > 0.0, lane);
        }
        hashes.add_shaded(key, &shaded[index as usize]);
    }
}

/// Cost of shading the opaque fragments, unless they are shaded already: blended ones are counted where they are
/// listed. Sixteen lanes cost as much with fewer fragments, so where a cell has several materials, each but the first
/// counts as a batch more: as many as there can be, whatever tiles the cells lie in.
fn opaque_shading(frame: &FrameContext<'_>, input: &ShadingInput<'_>, order: &ShadingOrder) -> u64 {
    if input.start >= input.opaque {
        return 0;
    }
    let FrameContext { costs, reach, .. } = frame;
    let [left, top] = input.tile.corner;
    let lights = |fragment: &Fragment| reach.count(left + fragment.column(), top + fragment.row());
    let everywhere = reach.everywhere();
    // Rays are sent once for all parts of a fragment that is split, and not by the sixteen.
    let begins = |index: usize| {
        let before = index.checked_sub(1).map(|before| &input.fragments[before]);
        let own = &input.fragments[index];
        before.is_none_or(|before| (before.pixel, before.triangle) != (own.pixel, own.triangle))
    };
    if let (Some(material), true) = (input.one_material, reach.is_uniform()) {
        let own = &costs[material as usize];
        let wholes = if own.receiving > 0 { (0..input.opaque).filter(|k| begins(*k)).count() } else { 0 };
        let each = own.fragment + everywhere * own.light;
        return input.opaque as u64 * each + wholes as u64 * own.receiving;
    }
    let (mut units, mut listed, mut known) = (0, 0, 0_u16);
    for &(number, end) in &order.stretches {
        let own = &costs[number as usize];
        let (mut cells, mut count, mut lit, mut wholes) = (0_u16, 0, 0, 0);
        for &index in &order.indices[listed..end] {
            // Blended ones are counted when they are listed.
            if (index as usize) < input.opaque {
                let fragment = &input.fragments[index as usize];
                cells |= 1 << (fragment.row() / CELL * 4 + fragment.column() / CELL);
                count += 1;
                wholes += u64::from(begins(index as usize));
                lit += if reach.is_uniform() { everywhere } else { lights(fragment) };
            }
        }
        listed = end;
        let more = LANES as u64 * u64::from((cells & known).count_ones());
        known |= cells;
        units += (count + more) * own.fragment + (lit + more * everywhere) * own.light;
        units += wholes * own.receiving;
    }
    units
}
