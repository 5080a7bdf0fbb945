//! The fragments of a tile from the triangles that they belong to, to their radiance.

use super::reach::CELL;
use super::resolve::{Transmitted, whole_pixel};
use super::shading_order::ShadingOrder;
use super::tile_pass::{Pass, TileJob, TileScratch};
use super::work::Spent;
use crate::each;
use crate::gbuffer::{Fragment, SourceTriangle, TriangleSource, layout};
use crate::geometry::Chunk;
use crate::math::lanes::{LANES, Lanes};
use crate::raster::{Disc, TileOrigin, Triangle};
use crate::shade::{
    Backdrop, ShadeContext, SurfacePlace, SurfaceTextures, hold_back, pass_through, shade, store_surface,
};
use crate::tile::Run;
use prefetch_index::prefetch_index;

/// What the parts of a tile have in common.
pub(super) struct TileShading<'a> {
    /// With the lights that reach the tile.
    pub shade: &'a ShadeContext<'a>,
    pub origin: TileOrigin,
    /// Left and top pixel.
    pub corner: [u32; 2],
    /// The material of all triangles, if it is one.
    pub one_material: Option<u32>,
    /// The mask of fragments that are their pixel, unless something is blended.
    pub whole: Option<u16>,
    /// Number of opaque fragments: the first in the list.
    pub opaque: usize,
    /// Something is transmissive.
    pub transmissive: bool,
}

/// What the shading pass makes of a fragment.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ShadedFragment {
    /// Radiance, not multiplied by opacity, but for transmissive surfaces.
    pub radiance: [f32; 3],
    /// Opacity.
    pub alpha: f32,
    /// Depth as the rasterizer compares it.
    pub depth: f32,
}

/// Chunks and a tile's identities.
pub(super) struct TileTriangles<'a> {
    pub chunks: &'a [Chunk],
    /// Chunk of each, and which of its triangles or points.
    pub identities: &'a [(u32, u32)],
    /// The discs of points that are seen, as triangles around them; and which is that of an identity.
    pub discs: &'a Discs,
}

/// Points of a tile that some sample sees.
#[derive(Debug, Default)]
pub(super) struct Discs {
    pub triangles: Vec<Triangle>,
    /// For each identity, its place in the list or [`Discs::NONE`].
    pub places: Vec<u32>,
    /// The tile has points.
    pub wanted: bool,
}

impl Discs {
    /// In place of a disc's place: it has not been listed.
    pub(super) const NONE: u32 = u32::MAX;

    /// Forgets all.
    pub(super) fn clear(&mut self) {
        self.triangles.clear();
        self.places.clear();
        self.wanted = false;
    }

    /// Lists the disc of an identity.
    pub(super) fn add(&mut self, identity: u32, disc: &Disc) {
        let identity = identity as usize;
        if self.places.len() <= identity {
            self.places.resize(identity + 1, Self::NONE);
        }
        self.places[identity] = self.triangles.len() as u32;
        self.triangles.push(Triangle::around(disc));
    }

    /// Lists the discs of the points among fragments.
    pub(super) fn list(&mut self, pass: &Pass<'_>, identities: &[(u32, u32)], fragments: &[Fragment]) {
        for fragment in if self.wanted { fragments } else { &[] } {
            let (chunk, index) = identities[fragment.triangle as usize];
            let known = self.places.get(fragment.triangle as usize).is_some_and(|place| *place != Self::NONE);
            if known || !pass.chunks[chunk as usize].points {
                continue;
            }
            if let Some(disc) = pass.disc(&pass.chunks[chunk as usize], index) {
                self.add(fragment.triangle, &disc);
            }
        }
    }
}

impl Pass<'_> {
    /// The disc of a point of a chunk.
    #[inline(always)]
    pub(super) fn disc(&self, chunk: &Chunk, index: u32) -> Option<Disc> {
        let points = self.states[chunk.draw as usize].points.as_ref()?;
        points.disc(self.shade.draws[chunk.draw as usize].mesh, chunk.range.start + index as usize)
    }
}

impl TileTriangles<'_> {
    /// Asks the processor for the triangle of an identity. Changes no result.
    #[inline(always)]
    fn prefetch(&self, identity: u32) {
        let (chunk, index) = self.identities[identity as usize];
        prefetch_index(&self.chunks[chunk as usize].triangles, index as usize);
    }
}

impl TriangleSource for TileTriangles<'_> {
    #[inline(always)]
    fn triangle(&self, identity: u32) -> SourceTriangle<'_> {
        let (chunk, index) = self.identities[identity as usize];
        let chunk = &self.chunks[chunk as usize];
        if chunk.points {
            let place = self.discs.places[identity as usize];
            return SourceTriangle {
                screen: &self.discs.triangles[place as usize],
                draw: chunk.draw,
                clip: None,
            };
        }
        let screen = &chunk.triangles[index as usize];
        SourceTriangle { screen, draw: chunk.draw, clip: chunk.clip(index) }
    }
}

/// The material of all triangles of a tile, if it is one.
pub(super) fn one_material(pass: &Pass<'_>, runs: &[Run]) -> Option<u32> {
    let of = |run: &Run| pass.shade.draws[pass.chunks[run.chunk as usize].draw as usize].material;
    let first = of(runs.first()?);
    runs.iter().all(|run| of(run) == first).then_some(first)
}

/// Shades the fragments from `start` on, sixteen of one material at a time: those with the mask `whole` into their pixels,
/// the others into `scratch.shaded` in the order of the fragments. False if a limit stops it.
#[inline(always)]
pub(super) fn shade_fragments<L: Lanes>(
    l: L,
    pass: &Pass<'_>,
    of_tile: &TileShading<'_>,
    start: usize,
    scratch: &mut TileScratch,
    job: &mut TileJob,
) -> bool {
    let &TileShading { shade: context, origin, corner, one_material, whole, opaque, .. } = of_tile;
    let TileJob { aovs, hashes, cost, .. } = job;
    let TileScratch { identities, discs, fragments, order, shaded, batches, surface, kept, pixels, .. } =
        scratch;
    let [mut batch, mut following] = batches.each_mut();
    let fragments = &*fragments;
    let draws = pass.shade.draws;
    let source = TileTriangles { chunks: pass.chunks, identities, discs };
    // Resized but not cleared: what the resolve reads is written below.
    shaded.resize(fragments.len(), ShadedFragment::default());
    let material_of = |identity: usize| {
        let (chunk, _) = identities[identity];
        draws[pass.chunks[chunk as usize].draw as usize].material
    };
    // Planes of the G-buffer are summed as fragments are shaded: in an order that does not depend on the tiles.
    order.find(fragments, start, identities.len(), one_material, &material_of, aovs.is_wanted());
    if start < opaque {
        let units = opaque_shading(pass, of_tile, fragments, order);
        cost.shading += units;
        if !pass.work.spend(Spent::Shading, units) {
            return false;
        }
    }
    if pass.only_counts {
        return true;
    }
    let mut surface_place = SurfacePlace::none(l);
    let mut listed = 0;
    for &(number, end) in &order.stretches {
        let stretch = &order.indices[listed..end];
        listed = end;
        let material = &pass.shade.materials[number as usize];
        let model = material.shading(pass.shade.model);
        let lobes = model.reads_lobes() || aovs.wants_lobes();
        let textures = SurfaceTextures::of(material, context.textures);
        // What the next fragments read is asked for while these are shaded, and the triangles of those after them.
        let part = |k: usize| stretch.chunks(LANES).nth(k);
        if let Some(first) = part(0) {
            batch.gather(fragments, first, &source, origin, pass.pattern);
            surface_place.find(l, context, &textures, batch);
        }
        for (place, indices) in stretch.chunks(LANES).enumerate() {
            if pass.work.is_stopped() {
                return false;
            }
            if let Some(next) = part(place + 1) {
                following.gather(fragments, next, &source, origin, pass.pattern);
                following.vertices.prefetch(draws);
            }
            for &index in part(place + 2).unwrap_or_default() {
                source.prefetch(fragments[index as usize].triangle);
            }
            store_surface(l, context, material, &textures, batch, &mut surface_place, lobes, surface);
            let alpha = surface.rows[layout::ALPHA.first];
            let held = if material.transmits() {
                Some(hold_back(l, context, material, batch, &surface_place, surface))
            } else {
                None
            };
            // The texels of the next: this one's are read.
            if part(place + 1).is_some() {
                surface_place.find(l, context, &textures, following);
            }
            let mut radiance = shade(l, context, model, material, surface);
            if let Some(held) = &held {
                let no_backdrop = Backdrop::default();
                let backdrop = pass.backdrop.unwrap_or(&no_backdrop);
                let passed = pass_through(l, context, backdrop, material, surface, held, radiance);
                if material.is_transmissive() && !kept.is_empty() {
                    let open = passed.open.to_arrays();
                    let keep = passed.keep.to_arrays();
                    for (k, &index) in indices.iter().enumerate() {
                        kept[index as usize] =
                            Some(Transmitted { open: each!(c => open[c][k]), keep: each!(c => keep[c][k]) });
                    }
                }
                radiance = passed.radiance;
            }
            let radiance = radiance.to_arrays();
            let depth = &surface.rows[layout::DEPTH.first];
            for (k, &index) in indices.iter().enumerate() {
                let radiance = [radiance[0][k], radiance[1][k], radiance[2][k]];
                let fragment = &batch.fragments[k];
                if Some(fragment.mask) == whole {
                    let pixel = pixels.index(fragment);
                    pixels.linear[pixel] = whole_pixel(radiance);
                } else {
                    shaded[index as usize] = ShadedFragment { radiance, alpha: alpha[k], depth: depth[k] };
                }
            }
            if let Some(hashes) = hashes {
                for (lane, &index) in indices.iter().enumerate() {
                    let fragment = &fragments[index as usize];
                    // Of points, the number among those of their chunk, likewise.
                    let (chunk, triangle) = identities[fragment.triangle as usize];
                    let key = [corner[0] + fragment.column(), corner[1] + fragment.row(), chunk, triangle];
                    let rows = if model.reads_lobes() { 0..layout::ROWS } else { layout::CORE };
                    hashes.add_samples(key, fragment.mask);
                    hashes.add_surface(key, surface, rows, lane);
                    hashes.add_shaded(key, &shaded[index as usize]);
                }
            }
            if aovs.is_wanted() {
                aovs.add(batch, surface, number, draws, indices, opaque, pass.pattern.len());
            }
            std::mem::swap(&mut batch, &mut following);
        }
    }
    true
}

/// What shading the opaque fragments takes. Sixteen lanes cost as much with fewer fragments, so where a cell has several
/// materials, each but the first counts as a batch more: as many as there can be, whatever tiles the cells lie in.
fn opaque_shading(
    pass: &Pass<'_>,
    of_tile: &TileShading<'_>,
    fragments: &[Fragment],
    order: &ShadingOrder,
) -> u64 {
    let [left, top] = of_tile.corner;
    let lights = |fragment: &Fragment| pass.reach.count(left + fragment.column(), top + fragment.row());
    let everywhere = pass.reach.everywhere();
    if let (Some(material), true) = (of_tile.one_material, pass.reach.is_uniform()) {
        let own = &pass.costs[material as usize];
        return of_tile.opaque as u64 * (own.fragment + everywhere * own.light);
    }
    let (mut units, mut listed, mut known) = (0, 0, 0_u16);
    for &(number, end) in &order.stretches {
        let own = &pass.costs[number as usize];
        let (mut cells, mut count, mut lit) = (0_u16, 0, 0);
        for &index in &order.indices[listed..end] {
            // Blended ones are counted when they are listed.
            if (index as usize) < of_tile.opaque {
                let fragment = &fragments[index as usize];
                cells |= 1 << (fragment.row() / CELL * 4 + fragment.column() / CELL);
                count += 1;
                lit += if pass.reach.is_uniform() { everywhere } else { lights(fragment) };
            }
        }
        listed = end;
        let more = LANES as u64 * u64::from((cells & known).count_ones());
        known |= cells;
        units += (count + more) * own.fragment + (lit + more * everywhere) * own.light;
    }
    units
}
