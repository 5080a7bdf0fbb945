//! All tiles, each into its own rows of the picture.

use super::aov::TileAovs;
use super::bands::{Bands, Planes, TileRows};
use super::crew::Crew;
use super::options::RenderOptions;
use super::tile_pass::{self, Pass, TileCost, TileJob, TileScratch};
use super::trace::FragmentHashes;
use crate::dispatch_available;
use crate::frame::{AovPlane, Clipping};
use crate::jobs::Scratch;
use crate::tile::{TileBins, TileGrid};

/// Working memory of all tiles, kept from frame to frame.
#[derive(Debug, Default)]
pub(super) struct TileMemory {
    scratch: Scratch<TileScratch>,
    /// Empty between frames.
    bands: Bands<'static>,
    /// Empty between frames.
    tiles: Vec<TileJob>,
    /// What each tile of the last pass took.
    costs: Vec<TileCost>,
}

/// What the tiles find beside the picture.
pub(super) struct Found {
    /// Number of fragments.
    pub fragments: u64,
    /// Number of pixels in which something of the scene shows.
    pub covered: u64,
    /// The G-buffer planes that were asked for.
    pub aovs: Vec<AovPlane>,
    /// Something tints what is behind the picture.
    pub tinted: bool,
    /// How much of it is white or black, if that is counted.
    pub clipping: Clipping,
    /// The hashes, if they were asked for.
    pub hashes: Option<FragmentHashes>,
}

/// Renders all tiles.
pub(super) fn render_tiles(
    crew: &mut Crew<'_>,
    pass: &Pass<'_>,
    bins: &TileBins,
    memory: &mut TileMemory,
    planes: &mut Planes,
    options: &RenderOptions,
) -> Found {
    let grid = &pass.grid;
    let bands = Bands::of(planes, grid, &mut memory.bands);
    let mut tiles = std::mem::take(&mut memory.tiles);
    tiles.extend((0..grid.len()).map(|tile| {
        let [_, _, width, height] = grid.pixels(tile);
        TileJob {
            aovs: TileAovs::new(&options.aovs, width as usize, height as usize),
            tinted: false,
            clipping: Clipping::default(),
            cost: memory.costs.get(tile).copied().filter(|_| pass.redraws).unwrap_or_default(),
            hashes: options.stage_hashes.then(FragmentHashes::default),
        }
    }));
    crew.for_each_with_scratch(&mut memory.scratch, &mut tiles, |scratch, tile, job| {
        let runs = bins.runs(tile);
        let mut rows = std::mem::take(&mut scratch.rows).emptied();
        bands.take(grid, tile, &mut rows);
        dispatch_available!(
            options.simd,
            l => tile_pass::render_tile(l, pass, tile, runs, scratch, &mut rows, job)
        );
        scratch.rows = rows.emptied();
    });
    TileScratch::level(&mut memory.scratch);
    memory.costs.clear();
    memory.costs.extend(tiles.iter().map(|t| t.cost));
    let fragments = tiles.iter().map(|t| t.cost.fragments).sum();
    let covered = tiles.iter().map(|t| t.cost.covered).sum();
    let tinted = tiles.iter().any(|t| t.tinted);
    let clipping = tiles.iter().fold(Clipping::default(), |sum, t| sum.plus(t.clipping));
    let hashes = options.stage_hashes.then(|| {
        let mut sum = FragmentHashes::default();
        tiles.iter().filter_map(|t| t.hashes.as_ref()).for_each(|hashes| sum.add(hashes));
        sum
    });
    let aovs = join_planes(grid, &mut tiles, options);
    tiles.clear();
    memory.tiles = tiles;
    memory.bands = bands.emptied();
    Found { fragments, covered, aovs, tinted, clipping, hashes }
}

/// Counts the work of all tiles in their order, on one thread and without shading anything, until a limit stops it: the sums
/// then say which one is passed first. `costs` is what each tile took in the pass before, and then in this one.
pub(super) fn count_tiles(
    pass: &Pass<'_>,
    bins: &TileBins,
    costs: &mut Vec<TileCost>,
    options: &RenderOptions,
) {
    let grid = &pass.grid;
    costs.resize(grid.len(), TileCost::default());
    let mut scratch = TileScratch::default();
    for (tile, cost) in costs.iter_mut().enumerate() {
        if pass.work.is_stopped() {
            return;
        }
        let mut job = TileJob {
            aovs: TileAovs::default(),
            tinted: false,
            clipping: Clipping::default(),
            cost: *cost,
            hashes: None,
        };
        let (scratch, job, rows) = (&mut scratch, &mut job, &mut TileRows::default());
        dispatch_available!(
            options.simd,
            l => tile_pass::render_tile(l, pass, tile, bins.runs(tile), scratch, rows, job)
        );
        *cost = job.cost;
    }
}

/// The G-buffer planes of all tiles as planes of the picture.
fn join_planes(grid: &TileGrid, tiles: &mut Vec<TileJob>, options: &RenderOptions) -> Vec<AovPlane> {
    let [width, height] = [grid.width() as usize, grid.height() as usize];
    let mut planes: Vec<AovPlane> = options
        .aovs
        .iter()
        .map(|&aov| AovPlane { aov, data: vec![0.0; aov.channels() * width * height] })
        .collect();
    if planes.is_empty() {
        return planes;
    }
    for (tile, job) in tiles.drain(..).enumerate() {
        let [x, y, tile_width, _] = grid.pixels(tile).map(|v| v as usize);
        for (plane, part) in planes.iter_mut().zip(job.aovs.finish()) {
            let channels = plane.aov.channels();
            for (row, values) in part.chunks(tile_width * channels).enumerate() {
                let at = ((y + row) * width + x) * channels;
                plane.data[at..at + values.len()].copy_from_slice(values);
            }
        }
    }
    planes
}
