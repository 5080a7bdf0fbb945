//! One tile from triangles to pixels.

use super::aov::TileAovs;
use super::draws::DrawState;
use super::resolve::{Behind, whole_pixel};
use super::trace::FragmentHashes;
use crate::each;
use crate::gbuffer::layout::{self, SurfacePlanes};
use crate::gbuffer::{Batch, Fragment, TriangleSource, extract_fragments, push_masked_fragments};
use crate::geometry::Chunk;
use crate::limits::{LimitExceeded, Limits};
use crate::math::lanes::{Float, LANES, Lanes, Mask};
use crate::raster::{NOT_CLIPPED, SamplePattern, TileOrigin, Triangle, Visibility};
use crate::reuse::reserve_like;
use crate::scene::AlphaMode;
use crate::shade::{Backdrop, ShadeContext, alpha_passes, hold_back, pass_through, shade, store_surface};
use crate::tile::{Run, TileGrid};
use std::sync::atomic::{AtomicU64, Ordering};

/// What all tiles of a frame share.
pub(super) struct Pass<'a> {
    pub grid: TileGrid,
    pub pattern: &'a SamplePattern,
    pub chunks: &'a [Chunk],
    pub states: &'a [DrawState],
    pub shade: ShadeContext<'a>,
    pub show_environment: bool,
    /// What refracting surfaces see behind them; `None` while it is being drawn: without blended and transmissive
    /// surfaces.
    pub backdrop: Option<&'a Backdrop>,
    /// The tiles' pixels hold the backdrop already: where no surface is blended or transmissive, they stay.
    pub redraws: bool,
    /// Least square of the cosine between the normals of small triangles that are shaded as one, if any are.
    pub merge: Option<f32>,
    pub work: Work,
}

/// Work done so far, by all tiles, and how much is allowed. Whether the sum exceeds a limit does not depend on the
/// order of the tiles; once it does, the rest is skipped and there is no picture.
pub(super) struct Work {
    pub blocks: AtomicU64,
    pub max_blocks: u64,
    pub blended: AtomicU64,
    pub max_blended: u64,
}

impl Work {
    pub(super) fn new(limits: &Limits) -> Self {
        Self {
            blocks: AtomicU64::new(0),
            max_blocks: limits.blocks,
            blended: AtomicU64::new(0),
            max_blended: limits.blend_entries,
        }
    }

    /// Adds to a sum; true if it is still within its limit.
    fn spend(sum: &AtomicU64, amount: u64, limit: u64) -> bool {
        sum.fetch_add(amount, Ordering::Relaxed).saturating_add(amount) <= limit
    }

    /// The first limit that was exceeded.
    pub(super) fn check(&self) -> Result<(), LimitExceeded> {
        let check = |what: &str, sum: &AtomicU64, limit: u64, field| {
            // How far the sum got depends on timing; that it is beyond the limit does not.
            let asked = sum.load(Ordering::Relaxed).min(limit.saturating_add(1));
            Limits::check(|| what.to_owned(), asked, limit, field)
        };
        check("blocks drawn", &self.blocks, self.max_blocks, "blocks")?;
        check("blended fragments", &self.blended, self.max_blended, "blend_entries")
    }
}

/// Working memory of one thread, kept from tile to tile and from frame to frame.
#[derive(Debug, Default)]
pub(super) struct TileScratch {
    visibility: Visibility,
    /// Chunk and triangle of each identity.
    identities: Vec<(u32, u32)>,
    /// Identities of blended and transmissive triangles.
    blended: Vec<u32>,
    /// What each fragment keeps of the colour and opacity behind it, where the tile has transmissive ones.
    kept: Vec<Option<[f32; 4]>>,
    /// The environment behind each pixel of such tiles, where it shows.
    environment: Vec<[f32; 4]>,
    fragments: Vec<Fragment>,
    /// Where a tile has several materials: material and index of each fragment, sorted.
    order: Vec<u64>,
    shaded: Vec<ShadedFragment>,
    /// The fragments that are being shaded.
    batch: Batch,
    /// Their G-buffer.
    surface: SurfacePlanes,
    resolve: super::resolve::ResolveScratch,
}

impl TileScratch {
    /// Takes as much memory as `other` has.
    fn reserve_like(&mut self, other: &Self) {
        self.visibility.reserve_like(&other.visibility);
        reserve_like(&mut self.identities, &other.identities);
        reserve_like(&mut self.blended, &other.blended);
        reserve_like(&mut self.kept, &other.kept);
        reserve_like(&mut self.environment, &other.environment);
        reserve_like(&mut self.fragments, &other.fragments);
        reserve_like(&mut self.order, &other.order);
        reserve_like(&mut self.shaded, &other.shaded);
        reserve_like(&mut self.resolve.blended, &other.resolve.blended);
        reserve_like(&mut self.resolve.behind, &other.resolve.behind);
    }

    /// Gives all the memory of the largest: which tiles a value gets depends on timing, and the next picture's tiles
    /// shall fit into any.
    pub(super) fn level(all: &mut [Self]) {
        if let [first, others @ ..] = all {
            others.iter().for_each(|other| first.reserve_like(other));
            others.iter_mut().for_each(|other| other.reserve_like(first));
        }
    }
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

/// Work of one tile.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct TileCost {
    /// Number of fragments.
    pub fragments: u64,
    /// Blocks that its triangles were drawn into.
    pub blocks: u64,
}

/// The rows of one tile, and what the tile adds to the frame.
#[derive(Debug)]
pub(super) struct TileJob<'r, 'a> {
    /// One slice of pixels for each of its rows.
    pub rows: &'r mut [&'a mut [[f32; 4]]],
    /// Planes of the G-buffer that were asked for.
    pub aovs: TileAovs,
    /// What the tile took; before it is drawn again, what it took then.
    pub cost: TileCost,
    /// Hashes of the fragments, if they were asked for.
    pub hashes: Option<FragmentHashes>,
}

/// Chunks and a tile's identities.
struct TileTriangles<'a> {
    chunks: &'a [Chunk],
    identities: &'a [(u32, u32)],
}

impl TriangleSource for TileTriangles<'_> {
    #[inline(always)]
    fn triangle(&self, identity: u32) -> (&Triangle, u32, Option<&[[f32; 2]; 3]>) {
        let (chunk, index) = self.identities[identity as usize];
        let chunk = &self.chunks[chunk as usize];
        let triangle = &chunk.triangles[index as usize];
        let clip = (triangle.clip != NOT_CLIPPED).then(|| &chunk.clip_barycentrics[triangle.clip as usize]);
        (triangle, chunk.draw, clip)
    }
}

/// Renders one tile.
#[inline(always)]
pub(super) fn render_tile<L: Lanes>(
    l: L,
    pass: &Pass<'_>,
    tile: usize,
    runs: &[Run],
    scratch: &mut TileScratch,
    job: &mut TileJob<'_, '_>,
) {
    let [left, top, width, height] = pass.grid.pixels(tile);
    let origin = pass.grid.origin(tile);
    let state = |run: &Run| &pass.states[pass.chunks[run.chunk as usize].draw as usize];
    let transmissive = pass.backdrop.is_some() && runs.iter().any(|run| state(run).transmissive);
    if pass.redraws
        && job.hashes.is_none()
        && !job.aovs.is_wanted()
        && !transmissive
        && !runs.iter().any(|run| state(run).alpha_mode == AlphaMode::Blend)
    {
        // Counted as if it were: what a limit lets through must not depend on the tiles.
        Work::spend(&pass.work.blocks, job.cost.blocks, pass.work.max_blocks);
        return;
    }
    job.cost = TileCost::default();
    scratch.fragments.clear();
    scratch.kept.clear();
    scratch.environment.clear();
    for row in job.rows.iter_mut() {
        row.fill([0.0; 4]);
    }
    if !runs.is_empty() {
        job.cost.blocks = draw_triangles(l, pass, origin, [width, height], runs, scratch);
    }
    let one_material = one_material(pass, runs);
    let opaque = scratch.fragments.len();
    if !scratch.blended.is_empty() && !runs.is_empty() {
        draw_blended(l, pass, origin, [width, height], scratch);
    }
    // Without blending, a fragment that covers its pixel is the pixel: these are written when they are shaded.
    let blends = opaque < scratch.fragments.len();
    let whole = if blends || job.hashes.is_some() { None } else { Some(pass.pattern.full_mask()) };
    if transmissive {
        scratch.kept.resize(scratch.fragments.len(), None);
        if pass.show_environment {
            super::resolve::environment_behind(
                l,
                &pass.shade,
                origin,
                [width, height],
                &mut scratch.environment,
            );
        }
    }
    if !scratch.fragments.is_empty() {
        shade_fragments(l, pass, origin, [left, top], one_material, whole, scratch, opaque, job);
    }
    let behind = Behind { kept: &scratch.kept, environment: &scratch.environment, width: width as usize };
    super::resolve::resolve_tile(
        pass.pattern.len(),
        whole,
        &scratch.fragments,
        &scratch.shaded,
        opaque,
        &behind,
        &mut scratch.resolve,
        job.rows,
    );
    if pass.show_environment {
        super::resolve::composite_environment(l, &pass.shade, origin, job.rows);
    }
    job.cost.fragments = scratch.fragments.len() as u64;
}

/// Visibility of opaque and masked triangles, and their fragments. Leaves blended triangles for later. Returns the number
/// of blocks that were drawn into.
#[inline(always)]
fn draw_triangles<L: Lanes>(
    l: L,
    pass: &Pass<'_>,
    origin: TileOrigin,
    [width, height]: [u32; 2],
    runs: &[Run],
    scratch: &mut TileScratch,
) -> u64 {
    let mut blocks = 0;
    scratch.identities.clear();
    scratch.blended.clear();
    let samples = pass.pattern.len();
    scratch.visibility.clear(width as usize, height as usize, samples);
    for run in runs {
        let chunk = &pass.chunks[run.chunk as usize];
        let state = &pass.states[chunk.draw as usize];
        let mode = if state.transmissive { AlphaMode::Blend } else { state.alpha_mode };
        if mode == AlphaMode::Blend && pass.backdrop.is_none() {
            continue;
        }
        for &index in chunk.bins.triangles(run) {
            let identity = scratch.identities.len() as u32;
            scratch.identities.push((run.chunk, index));
            let triangle = &chunk.triangles[index as usize];
            match mode {
                AlphaMode::Opaque => {
                    scratch.visibility.draw(l, triangle, identity, origin, pass.pattern, None);
                }
                AlphaMode::Blend => scratch.blended.push(identity),
                AlphaMode::Mask { cutoff } => {
                    let source = TileTriangles { chunks: pass.chunks, identities: &scratch.identities };
                    let draws = pass.shade.draws;
                    let material = &pass.shade.materials[draws[chunk.draw as usize].material as usize];
                    // A call through a pointer leaves the instruction set: `run` enters it again.
                    let mut keep = |column, row, sample, _covered| {
                        l.run(
                            #[inline(always)]
                            || {
                                let batch = Batch::of_block(
                                    identity,
                                    &source,
                                    draws,
                                    origin,
                                    column,
                                    row,
                                    sample,
                                    pass.pattern,
                                );
                                alpha_passes(l, &pass.shade, material, cutoff, &batch).bits()
                            },
                        )
                    };
                    scratch.visibility.draw(l, triangle, identity, origin, pass.pattern, Some(&mut keep));
                }
            }
        }
        let visited = scratch.visibility.take_visited();
        blocks += visited;
        if !Work::spend(&pass.work.blocks, visited, pass.work.max_blocks) {
            scratch.blended.clear();
            return blocks;
        }
    }
    let source = TileTriangles { chunks: pass.chunks, identities: &scratch.identities };
    let merge = match pass.merge {
        Some(least_squared_cosine) => Some((&source, pass.shade.draws, least_squared_cosine)),
        None => None,
    };
    extract_fragments(&scratch.visibility, width, height, samples, merge, &mut scratch.fragments);
    blocks
}

/// Fragments of blended triangles, in front of everything opaque.
#[inline(always)]
fn draw_blended<L: Lanes>(
    l: L,
    pass: &Pass<'_>,
    origin: TileOrigin,
    [width, height]: [u32; 2],
    scratch: &mut TileScratch,
) {
    let TileScratch { visibility, identities, blended, fragments, .. } = scratch;
    for &identity in blended.iter() {
        let (chunk, index) = identities[identity as usize];
        let triangle = &pass.chunks[chunk as usize].triangles[index as usize];
        let before = fragments.len();
        visibility.visit_visible(
            l,
            triangle,
            origin,
            pass.pattern,
            #[inline(always)]
            |column, row, masks| {
                push_masked_fragments(identity, column, row, masks, width, height, fragments);
            },
        );
        let added = (fragments.len() - before) as u64;
        if !Work::spend(&pass.work.blended, added, pass.work.max_blended) {
            return;
        }
    }
}

/// The material of all triangles of a tile, if it is one.
fn one_material(pass: &Pass<'_>, runs: &[Run]) -> Option<u32> {
    let of = |run: &Run| pass.shade.draws[pass.chunks[run.chunk as usize].draw as usize].material;
    let first = of(runs.first()?);
    runs.iter().all(|run| of(run) == first).then_some(first)
}

/// Shades all fragments, sixteen of one material at a time: those with the mask `whole` into their pixels, the others into
/// `scratch.shaded` in the order of the fragments.
#[inline(always)]
fn shade_fragments<L: Lanes>(
    l: L,
    pass: &Pass<'_>,
    origin: TileOrigin,
    corner: [u32; 2],
    one_material: Option<u32>,
    whole: Option<u16>,
    scratch: &mut TileScratch,
    opaque: usize,
    job: &mut TileJob<'_, '_>,
) {
    let TileJob { rows, aovs, hashes, .. } = job;
    let TileScratch { identities, fragments, order, shaded, batch, surface, kept, .. } = scratch;
    let draws = pass.shade.draws;
    let source = TileTriangles { chunks: pass.chunks, identities };
    // Resized but not cleared: what the resolve reads is written below.
    shaded.resize(fragments.len(), ShadedFragment::default());
    order.clear();
    if one_material.is_none() {
        order.extend(fragments.iter().zip(0_u64..).map(|(fragment, index)| {
            let (chunk, _) = identities[fragment.triangle as usize];
            u64::from(draws[pass.chunks[chunk as usize].draw as usize].material) << 32 | index
        }));
        if !order.is_sorted_by_key(|entry| entry >> 32) {
            order.sort_unstable();
        }
    }
    let mut start = 0;
    while start < fragments.len() {
        let (number, end) = match one_material {
            Some(number) => (number, fragments.len()),
            None => {
                let number = order[start] >> 32;
                let run = order[start..].iter().take_while(|&&entry| entry >> 32 == number).count();
                (number as u32, start + run)
            }
        };
        let run = start..end;
        start = end;
        let material = &pass.shade.materials[number as usize];
        let model = material.shading(pass.shade.model);
        let lobes = model.reads_lobes() || aovs.wants_lobes();
        for first in run.clone().step_by(LANES) {
            let len = LANES.min(run.end - first);
            let mut indices = [0; LANES];
            for (index, at) in indices.iter_mut().zip(first..first + len) {
                *index = if one_material.is_some() { at as u32 } else { order[at] as u32 };
            }
            let indices = &indices[..len];
            batch.gather(
                indices.iter().map(|&k| fragments[k as usize]),
                &source,
                draws,
                origin,
                pass.pattern,
            );
            store_surface(l, &pass.shade, material, batch, lobes, surface);
            let mut alpha = surface.rows[layout::ALPHA.first];
            let radiance = if material.transmits() {
                let held = hold_back(l, &pass.shade, material, batch, surface);
                let radiance = shade(l, &pass.shade, model, material, surface);
                let no_backdrop = Backdrop::default();
                let backdrop = pass.backdrop.unwrap_or(&no_backdrop);
                let passed = pass_through(l, &pass.shade, backdrop, material, surface, &held, radiance);
                if material.is_transmissive() && !kept.is_empty() {
                    alpha = passed.alpha.to_array();
                    let keep = each!(c in passed.keep => c.to_array());
                    for (k, &index) in indices.iter().enumerate() {
                        kept[index as usize] = Some([keep[0][k], keep[1][k], keep[2][k], keep[3][k]]);
                    }
                }
                passed.radiance
            } else {
                shade(l, &pass.shade, model, material, surface)
            };
            let radiance = each!(c in radiance => c.to_array());
            let depth = &surface.rows[layout::DEPTH.first];
            for (k, &index) in indices.iter().enumerate() {
                let radiance = [radiance[0][k], radiance[1][k], radiance[2][k]];
                let fragment = &batch.fragments[k];
                if Some(fragment.mask) == whole {
                    rows[fragment.row() as usize][fragment.column() as usize] = whole_pixel(radiance);
                } else {
                    shaded[index as usize] = ShadedFragment { radiance, alpha: alpha[k], depth: depth[k] };
                }
            }
            if let Some(hashes) = hashes {
                for (lane, &index) in indices.iter().enumerate() {
                    let fragment = &fragments[index as usize];
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
        }
    }
}

/// The side of a tile that keeps depth and identity in the second-level cache or closer.
pub(super) fn default_tile_size(samples: u32) -> u32 {
    match samples {
        1 => 64,
        4 | 8 => 32,
        _ => 16,
    }
}

/// How many (tile, triangle) pairs a frame may have: each is at least one block, and takes twelve bytes.
pub(super) fn bin_limit(limits: &Limits) -> u64 {
    limits.blocks.min(1 << 26)
}
