//! All tiles, each into its own rows of the picture.

use super::traced_rows::TracedRows;
use overcoat_core::frame::{Aov, AovPlane, Clipping, Target};
use overcoat_core::jobs::Scratch;
use overcoat_core::math::lanes::SimdLevel;
use overcoat_stages::tile::TileGrid;
use overcoat_tiles::aov::TileAovs;
use overcoat_tiles::light_pool::TracedTile;
use overcoat_tiles::pass::{Pass, Tile};
use overcoat_tiles::strips::{Blank, Planes, Strips, TileRows};
use overcoat_tiles::tile_pass::{TileCost, TileJob, TileScratch};
use overcoat_tiles::timed_pool::TimedPool;
use overcoat_tiles::trace::FragmentHashes;

/// Working memory of all tiles, kept from frame to frame.
#[derive(Debug, Default)]
pub(super) struct TileMemory {
    scratch: Scratch<TileScratch>,
    /// Empty between frames.
    strips: Strips<'static>,
    /// Empty between frames.
    tiles: Vec<TileJob>,
    /// Cost of each tile in the last pass.
    costs: Vec<TileCost>,
    /// Findings of the rays of some of the tiles.
    traced: TracedRows,
    /// Fragments of the frame, as far as they are counted before they are drawn.
    pub counted: u64,
}

/// Results of the tiles beside the picture.
#[derive(Default)]
pub(super) struct Found {
    /// Number of fragments.
    pub fragments: u64,
    /// Number of pixels in which something of the scene shows.
    pub covered: u64,
    /// The G-buffer planes that were asked for.
    pub aovs: Vec<AovPlane>,
    /// Something tints what is behind the picture.
    pub tinted: bool,
    /// Number of white and black pixels, if they are counted.
    pub clipping: Clipping,
    /// The hashes, if they were asked for.
    pub hashes: Option<FragmentHashes>,
}

/// [`overcoat_tiles::tile_pass::render_tile`] at an instruction set. The one place that chooses it: each further one would be another
/// copy of all that tiles go through, for every instruction set. On x86-64 each is a package of its own, which build beside
/// each other.
#[inline(never)]
pub(super) fn render_tile(
    simd: SimdLevel,
    pass: &Pass<'_>,
    tile: &Tile<'_>,
    scratch: &mut TileScratch,
    rows: &mut TileRows<'_>,
    job: &mut TileJob,
) {
    match simd {
        #[cfg(target_arch = "x86_64")]
        SimdLevel::Sse2 => overcoat_tiles_sse2::render_tile(pass, tile, scratch, rows, job),
        #[cfg(all(target_arch = "x86_64", feature = "wide-lanes"))]
        SimdLevel::Avx2 => overcoat_tiles_avx2::render_tile(pass, tile, scratch, rows, job),
        #[cfg(all(target_arch = "x86_64", feature = "wide-lanes"))]
        SimdLevel::Avx512 => overcoat_tiles_avx512::render_tile(pass, tile, scratch, rows, job),
        simd => overcoat_core::dispatch_elsewhere!(simd, l => {
            overcoat_tiles::tile_pass::render_tile(l, pass, tile, scratch, rows, job)
        }),
    }
}

/// Draws all tiles into the planes, in a pass that draws.
pub(super) fn render_tiles(
    pool: &mut TimedPool<'_>,
    pass: &Pass<'_>,
    memory: &mut TileMemory,
    planes: &mut Planes,
    target: Option<(&mut Target<'_>, [u32; 4])>,
    simd: SimdLevel,
) -> Found {
    let grid = &pass.frame.grid;
    let wanted = pass.wanted();
    let has_maps = pass.effects.occlusion.is_some();
    let strips = Strips::of(planes, target, grid, &mut memory.strips);
    let mut tiles = std::mem::take(&mut memory.tiles);
    tiles.extend((0..grid.len()).map(|tile| {
        let [_, _, width, height] = grid.pixels(tile);
        TileJob {
            aovs: TileAovs::new(wanted.aovs, width as usize, height as usize, has_maps),
            cost: memory.costs.get(tile).copied().unwrap_or_default(),
            hashes: wanted.hashes.then(FragmentHashes::default),
            ..TileJob::default()
        }
    }));
    let at_once =
        if pass.effects.traced.is_some() { memory.traced.start(grid, memory.counted) } else { grid.rows() };
    for first in (0..grid.rows()).step_by(at_once.max(1) as usize) {
        let end = grid.rows().min(first + at_once);
        let mut pass = *pass;
        if pass.effects.traced.is_some() {
            memory.traced.trace_before(end, pool, &pass, &mut memory.scratch, simd);
            pass.traced_tiles = Some(memory.traced.known(grid));
        }
        let [start, end] = [first, end].map(|row| (row * grid.columns()) as usize);
        pool.for_each_with_scratch(&mut memory.scratch, &mut tiles[start..end], |scratch, number, job| {
            let tile = start + number;
            if !pass.draws(tile) {
                job.cost = TileCost::default();
                return;
            }
            let mut rows = std::mem::take(&mut scratch.rows).emptied();
            strips.take(grid, tile, &mut rows);
            let tile = &pass.tile(tile);
            render_tile(simd, &pass, tile, scratch, &mut rows, job);
            scratch.rows = rows.emptied();
        });
    }
    TileScratch::level(&mut memory.scratch);
    memory.strips = strips.emptied();
    planes.blank = Blank::default();
    memory.costs.clear();
    memory.costs.extend(tiles.iter().map(|t| t.cost));
    let found = Found {
        fragments: tiles.iter().map(|t| t.cost.fragments).sum(),
        covered: tiles.iter().map(|t| t.cost.covered).sum(),
        tinted: tiles.iter().any(|t| t.tinted),
        clipping: tiles.iter().fold(Clipping::default(), |sum, t| sum.plus(t.clipping)),
        hashes: wanted.hashes.then(|| {
            let mut sum = FragmentHashes::default();
            tiles.iter().filter_map(|t| t.hashes.as_ref()).for_each(|hashes| sum.add(hashes));
            sum
        }),
        aovs: join_planes(grid, &mut tiles, wanted.aovs),
    };
    tiles.clear();
    memory.tiles = tiles;
    found
}

/// A pass over all tiles that draws nothing: their fragments ask for the textures that they read, are counted, or send a few rays.
pub(super) fn feedback_tiles(
    pool: &mut TimedPool<'_>,
    pass: &Pass<'_>,
    memory: &mut TileMemory,
    simd: SimdLevel,
) {
    let mut tiles = std::mem::take(&mut memory.tiles);
    tiles.extend((0..pass.frame.grid.len()).map(|_| TileJob::default()));
    pool.for_each_with_scratch(&mut memory.scratch, &mut tiles, |scratch, tile, job| {
        if pass.draws(tile) {
            let (tile, rows) = (&pass.tile(tile), &mut TileRows::default());
            render_tile(simd, pass, tile, scratch, rows, job);
            // Nobody reads what rays have found.
            job.traced = TracedTile::default();
        }
    });
    tiles.clear();
    memory.tiles = tiles;
}

/// Counts the work of all tiles in their order, on one thread and without shading anything, until a limit stops it: the sums
/// then say which one is passed first. `costs` is what each tile took in the pass before, and then in this one.
pub(super) fn count_tiles(pass: &Pass<'_>, costs: &mut Vec<TileCost>, simd: SimdLevel) {
    let tiles = pass.frame.grid.len();
    costs.resize(tiles, TileCost::default());
    let mut scratch = TileScratch::default();
    for (tile, cost) in costs.iter_mut().enumerate() {
        if pass.work.is_stopped() {
            return;
        }
        if !pass.draws(tile) {
            continue;
        }
        let mut job = TileJob { cost: *cost, ..TileJob::default() };
        let (tile, scratch, job, rows) = (&pass.tile(tile), &mut scratch, &mut job, &mut TileRows::default());
        render_tile(simd, pass, tile, scratch, rows, job);
        *cost = job.cost;
    }
}

/// The G-buffer planes of all tiles as planes of the picture.
fn join_planes(grid: &TileGrid, tiles: &mut Vec<TileJob>, wanted: &[Aov]) -> Vec<AovPlane> {
    let [width, height] = [grid.width() as usize, grid.height() as usize];
    let mut planes: Vec<AovPlane> = wanted.iter().map(|&aov| AovPlane::empty(aov, width * height)).collect();
    if planes.is_empty() {
        return planes;
    }
    for (tile, job) in tiles.drain(..).enumerate() {
        let [x, y, tile_width, _] = grid.pixels(tile).map(|v| v as usize);
        for (plane, part) in planes.iter_mut().zip(job.aovs.finish()) {
            let channels = plane.aov.channels();
            for (row, values) in part.data.chunks(tile_width * channels).enumerate() {
                let at = ((y + row) * width + x) * channels;
                plane.data[at..at + values.len()].copy_from_slice(values);
            }
            for (row, ids) in part.ids.chunks(tile_width).enumerate() {
                let at = (y + row) * width + x;
                plane.ids[at..at + ids.len()].copy_from_slice(ids);
            }
        }
    }
    planes
}
