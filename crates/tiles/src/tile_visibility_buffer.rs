//! The visibility buffer of a tile: which opaque or masked triangle each sample of a tile sees, and the fragments that this comes to.

use super::pass::{FrameContext, Pass, Tile};
use super::shading_rate::is_finer;
use super::tile_pass::TileCost;
use super::tile_triangles::{Discs, TileTriangles};
use super::work::Spent;
use overcoat_core::math::lanes::{LANES, Lanes, Mask};
use overcoat_core::reuse::reserve_like;
use overcoat_scene::AlphaMode;
use overcoat_stages::gbuffer::{Batch, Fragment, extract_fragments, split_fragments};
use overcoat_stages::geometry::Chunk;
use overcoat_stages::raster::{Disc, TileOrigin, VisibilityBuffer};
use overcoat_stages::shade::alpha_passes;
use overcoat_stages::tile::Run;
use prefetch_index::prefetch_index;

/// Number of triangles by which prefetching runs ahead: in a dense mesh those of a tile are not in the cache.
const TRIANGLES_AHEAD: usize = 8;

/// Visibility of the samples of a tile, and the triangles that are yet to be blended.
#[derive(Debug, Default)]
pub struct TileVisibilityBuffer {
    /// Depth and identity of every sample.
    pub samples: VisibilityBuffer,
    /// Chunk of each identity, and which of its triangles or points.
    pub identities: Vec<(u32, u32)>,
    /// Discs of the points that are seen.
    pub discs: Discs,
    /// Identities of blended and transmissive triangles: of the tile, and after them of its parts.
    pub blended: Vec<u32>,
    /// Fragments before they are split.
    whole: Vec<Fragment>,
    /// For each identity, if its fragments are split, once that is known.
    finer: Vec<Option<bool>>,
    /// Number of small triangles.
    small: u64,
}

impl TileVisibilityBuffer {
    /// Nothing is seen in a tile.
    fn clear(&mut self, [width, height]: [u32; 2], frame: &FrameContext<'_>) {
        self.identities.clear();
        self.discs.clear();
        self.small = 0;
        self.samples.clear(width as usize, height as usize, frame.pattern.len(), frame.least_depth);
    }

    /// The next identity: a triangle or point of a chunk.
    #[inline(always)]
    fn identify(&mut self, chunk: u32, index: u32) -> u32 {
        let identity = self.identities.len() as u32;
        self.identities.push((chunk, index));
        identity
    }

    /// The triangles of all identities.
    #[inline(always)]
    pub fn triangles<'a>(&'a self, frame: &FrameContext<'a>) -> TileTriangles<'a> {
        TileTriangles { chunks: frame.chunks, identities: &self.identities, discs: &self.discs }
    }

    /// Takes as much memory as `other` has.
    pub fn reserve_like(&mut self, other: &Self) {
        self.samples.reserve_like(&other.samples);
        reserve_like(&mut self.identities, &other.identities);
        self.discs.reserve_like(&other.discs);
        reserve_like(&mut self.blended, &other.blended);
        reserve_like(&mut self.whole, &other.whole);
        reserve_like(&mut self.finer, &other.finer);
    }
}

/// Draws opaque and masked triangles. Lists blended ones for later. False if a limit stops it.
#[inline(always)]
pub fn draw_triangles<L: Lanes>(
    l: L,
    pass: &Pass<'_>,
    tile: &Tile<'_>,
    seen: &mut TileVisibilityBuffer,
    cost: &mut TileCost,
) -> bool {
    let frame = pass.frame;
    seen.clear(tile.size, frame);
    for (number, run) in tile.runs.iter().enumerate() {
        if let Some(next) = tile.runs.get(number + 1) {
            prefetch_run(&frame.chunks[next.chunk as usize], next);
        }
        let Some(mode) = pass.alpha_mode(frame.state(run)) else { continue };
        let masked = if frame.chunks[run.chunk as usize].points {
            seen.discs.wanted = true;
            draw_points(l, frame, tile.origin, run, mode, seen)
        } else {
            draw_run(l, frame, tile.origin, run, mode, seen)
        };
        let visited = seen.samples.take_visited();
        cost.blocks += visited;
        cost.shading += masked;
        if !pass.work.spend(Spent::Blocks, visited)
            || (masked > 0 && !pass.work.spend(Spent::Shading, masked))
        {
            return false;
        }
    }
    true
}

/// Lists the fragments that the samples see, in the order in which they are summed.
#[inline(always)]
pub fn list_fragments<L: Lanes>(
    l: L,
    frame: &FrameContext<'_>,
    [width, height]: [u32; 2],
    seen: &mut TileVisibilityBuffer,
    fragments: &mut Vec<Fragment>,
) {
    let source = seen.triangles(frame);
    let merge = match frame.merge {
        Some(least_squared_cosine) if seen.small > 1 => {
            Some((&source, frame.shade.draws, least_squared_cosine))
        }
        _ => None,
    };
    extract_fragments(l, &seen.samples, width, height, frame.pattern.len(), merge, fragments);
    let TileVisibilityBuffer { identities, discs, .. } = seen;
    discs.list(frame, identities, fragments);
    if frame.pattern.rate() > 1 {
        let source = TileTriangles { chunks: frame.chunks, identities, discs };
        seen.finer.clear();
        seen.finer.resize(identities.len(), None);
        let finer = |identity: u32| {
            let known = &mut seen.finer[identity as usize];
            *known.get_or_insert_with(|| is_finer(frame, &source, identity))
        };
        split_fragments(frame.pattern, finer, fragments, &mut seen.whole);
    }
}

/// Prefetches the first triangles of a run. Changes no result.
#[inline(always)]
fn prefetch_run(chunk: &Chunk, run: &Run) {
    for &first in chunk.bins.triangles(run).iter().take(TRIANGLES_AHEAD) {
        prefetch_index(&chunk.triangles, first as usize);
    }
}

/// Draws the triangles of a run. Returns what their masks cost, in units of [`ShadingCost`](overcoat_stages::shade::ShadingCost).
#[inline(always)]
fn draw_run<L: Lanes>(
    l: L,
    frame: &FrameContext<'_>,
    origin: TileOrigin,
    run: &Run,
    mode: AlphaMode,
    seen: &mut TileVisibilityBuffer,
) -> u64 {
    let chunk = &frame.chunks[run.chunk as usize];
    let listed = chunk.bins.triangles(run);
    let mut masked = 0;
    for (place, &index) in listed.iter().enumerate() {
        if let Some(&later) = listed.get(place + TRIANGLES_AHEAD) {
            prefetch_index(&chunk.triangles, later as usize);
        }
        let identity = seen.identify(run.chunk, index);
        let triangle = &chunk.triangles[index as usize];
        seen.small += u64::from(triangle.small_samples != 0);
        match mode {
            AlphaMode::Opaque => seen.samples.draw(l, triangle, identity, origin, frame.pattern, None),
            AlphaMode::Blend => seen.blended.push(identity),
            AlphaMode::Mask { cutoff } => {
                let TileVisibilityBuffer { samples, identities, discs, .. } = &mut *seen;
                let source = TileTriangles { chunks: frame.chunks, identities, discs };
                let number = frame.shade.draws[chunk.draw as usize].material as usize;
                let (material, own) =
                    (&frame.shade.materials[number], LANES as u64 * frame.costs[number].mask);
                // A call through a pointer leaves the instruction set: `run` enters it again.
                let mut keep = |column, row, sample, _covered| {
                    masked += own;
                    l.run(
                        #[inline(always)]
                        || {
                            let pattern = frame.pattern;
                            let batch =
                                Batch::of_block(identity, &source, origin, column, row, sample, pattern);
                            alpha_passes(l, &frame.shade, material, cutoff, &batch).bits()
                        },
                    )
                };
                samples.draw(l, triangle, identity, origin, frame.pattern, Some(&mut keep));
            }
        }
    }
    masked
}

/// Draws the points of a run that are opaque or pass their mask. Lists blended ones for later. Returns what their masks cost,
/// in units of [`ShadingCost`](overcoat_stages::shade::ShadingCost): as if each were read once in every block that the point touches, so
/// that it does not depend on the tiles.
#[inline(never)]
fn draw_points<L: Lanes>(
    l: L,
    frame: &FrameContext<'_>,
    origin: TileOrigin,
    run: &Run,
    mode: AlphaMode,
    seen: &mut TileVisibilityBuffer,
) -> u64 {
    // A function of its own: the one that draws opaque triangles is large enough.
    l.run(
        #[inline(always)]
        || {
            let chunk = &frame.chunks[run.chunk as usize];
            let draw = &frame.shade.draws[chunk.draw as usize];
            let own = frame.costs[draw.material as usize].mask;
            let mut masked = 0;
            let listed = chunk.bins.triangles(run);
            for (place, &index) in listed.iter().enumerate() {
                if let Some(&later) = listed.get(place + TRIANGLES_AHEAD) {
                    let vertex = draw.mesh.point(chunk.range.start + later as usize) as usize;
                    prefetch_index(draw.mesh.positions(), vertex);
                    prefetch_index(draw.mesh.shading_normals(), vertex);
                }
                let identity = seen.identify(run.chunk, index);
                if mode == AlphaMode::Blend {
                    seen.blended.push(identity);
                    continue;
                }
                let Some(disc) = frame.disc(chunk, index) else { continue };
                if let AlphaMode::Mask { cutoff } = mode {
                    masked += LANES as u64 * own * seen.samples.blocks_of_disc(&disc, origin);
                    if !passes_mask(l, frame, origin, identity, &disc, cutoff, seen) {
                        continue;
                    }
                }
                seen.samples.draw_disc(l, &disc, identity, origin, frame.pattern);
            }
            masked
        },
    )
}

/// True if a point passes its mask: attributes are the same all over it.
#[inline(never)]
fn passes_mask<L: Lanes>(
    l: L,
    frame: &FrameContext<'_>,
    origin: TileOrigin,
    identity: u32,
    disc: &Disc,
    cutoff: f32,
    seen: &mut TileVisibilityBuffer,
) -> bool {
    l.run(
        #[inline(always)]
        || {
            seen.discs.add(identity, disc);
            let source = seen.triangles(frame);
            let batch = Batch::of_block(identity, &source, origin, 0, 0, 0, frame.pattern);
            let material = frame.shade.draws[source.draw(identity) as usize].material;
            let material = &frame.shade.materials[material as usize];
            let passes = alpha_passes(l, &frame.shade, material, cutoff, &batch).bits() & 1 != 0;
            // Listed again if it is seen.
            seen.discs.remove_last(identity);
            passes
        },
    )
}
