//! All tiles, each into its own rows of the frame.

use super::aov::TileAovs;
use super::crew::Crew;
use super::options::RenderOptions;
use super::tile_pass::{self, Pass, TileCost, TileJob, TileScratch};
use super::trace::FragmentHashes;
use crate::dispatch_available;
use crate::frame::AovPlane;
use crate::jobs::Scratch;
use crate::reuse::emptied;
use crate::tile::{TileBins, TileGrid};

/// Working memory of all tiles, kept from frame to frame.
#[derive(Debug, Default)]
pub(super) struct TileMemory {
    scratch: Scratch<TileScratch>,
    /// Empty between frames.
    linear: Vec<&'static mut [[f32; 4]]>,
    /// Empty between frames.
    transmittance: Vec<&'static mut [[f32; 3]]>,
    /// Empty between frames.
    display: Vec<&'static mut [[u8; 4]]>,
    /// Empty between frames.
    tiles: Vec<TileJob<'static, 'static>>,
    /// What each tile of the last pass took.
    costs: Vec<TileCost>,
}

/// Where tiles write their pixels: planes of the whole picture, each empty where it is not wanted.
#[derive(Debug, Default)]
pub(super) struct Planes {
    pub linear: Vec<[f32; 4]>,
    pub transmittance: Vec<[f32; 3]>,
    pub display: Vec<[u8; 4]>,
}

/// What the tiles find beside the picture.
pub(super) struct Found {
    /// Number of fragments.
    pub fragments: u64,
    /// The G-buffer planes that were asked for.
    pub aovs: Vec<AovPlane>,
    /// Something tints what is behind the picture.
    pub tinted: bool,
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
    let mut linear = emptied(std::mem::take(&mut memory.linear));
    let mut transmittance = emptied(std::mem::take(&mut memory.transmittance));
    let mut display = emptied(std::mem::take(&mut memory.display));
    split(grid, &mut planes.linear, &mut linear);
    split(grid, &mut planes.transmittance, &mut transmittance);
    split(grid, &mut planes.display, &mut display);
    let mut rest = (&mut linear[..], &mut transmittance[..], &mut display[..]);
    let mut tiles: Vec<TileJob<'_, '_>> = emptied(std::mem::take(&mut memory.tiles));
    tiles.extend((0..grid.len()).map(|tile| {
        let [_, _, width, height] = grid.pixels(tile);
        let rows = ..height as usize;
        TileJob {
            // None where none are wanted.
            linear: rest.0.split_off_mut(rows).unwrap_or_default(),
            transmittance: rest.1.split_off_mut(rows).unwrap_or_default(),
            display: rest.2.split_off_mut(rows).unwrap_or_default(),
            aovs: TileAovs::new(&options.aovs, width as usize, height as usize),
            tinted: false,
            cost: memory.costs.get(tile).copied().filter(|_| pass.redraws).unwrap_or_default(),
            hashes: options.stage_hashes.then(FragmentHashes::default),
        }
    }));
    crew.for_each_with_scratch(&mut memory.scratch, &mut tiles, |scratch, tile, job| {
        let runs = bins.runs(tile);
        dispatch_available!(
            options.simd,
            l => tile_pass::render_tile(l, pass, tile, runs, scratch, job)
        );
    });
    TileScratch::level(&mut memory.scratch);
    memory.costs.clear();
    memory.costs.extend(tiles.iter().map(|t| t.cost));
    let fragments = tiles.iter().map(|t| t.cost.fragments).sum();
    let tinted = tiles.iter().any(|t| t.tinted);
    let hashes = options.stage_hashes.then(|| {
        let mut sum = FragmentHashes::default();
        tiles.iter().filter_map(|t| t.hashes.as_ref()).for_each(|hashes| sum.add(hashes));
        sum
    });
    let aovs = join_planes(grid, &mut tiles, options);
    memory.tiles = emptied(tiles);
    memory.linear = emptied(linear);
    memory.transmittance = emptied(transmittance);
    memory.display = emptied(display);
    Found { fragments, aovs, tinted, hashes }
}

/// The pieces of all rows that lie in one tile, tile by tile, from top to bottom in each. None of no pixels.
fn split<'a, T>(grid: &TileGrid, pixels: &'a mut [T], rows: &mut Vec<&'a mut [T]>) {
    if pixels.is_empty() {
        return;
    }
    let (width, side, columns) = (grid.width() as usize, grid.side() as usize, grid.columns() as usize);
    rows.resize_with(columns * grid.height() as usize, Default::default);
    for (band, pixels) in pixels.chunks_mut(width * side).enumerate() {
        let height = pixels.len() / width;
        let first = band * side * columns;
        for (y, row) in pixels.chunks_mut(width).enumerate() {
            for (column, piece) in row.chunks_mut(side).enumerate() {
                rows[first + column * height + y] = piece;
            }
        }
    }
}

/// The G-buffer planes of all tiles as planes of the picture.
fn join_planes(grid: &TileGrid, tiles: &mut Vec<TileJob<'_, '_>>, options: &RenderOptions) -> Vec<AovPlane> {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_tile_gets_its_own_pixels() {
        for (width, height, side) in [(1, 1, 16), (40, 33, 16), (64, 64, 64), (65, 31, 32)] {
            let grid = TileGrid::new(width, height, side);
            let place = |k: u32| [(k % width) as f32, (k / width) as f32, 0.0, 0.0];
            let mut pixels: Vec<[f32; 4]> = (0..width * height).map(place).collect();
            let mut rows = Vec::new();
            split(&grid, &mut pixels, &mut rows);
            let mut rows = rows.into_iter();
            for tile in 0..grid.len() {
                let [left, top, tile_width, tile_height] = grid.pixels(tile);
                for y in top..top + tile_height {
                    let expected: Vec<_> = (left..left + tile_width).map(|x| place(y * width + x)).collect();
                    assert_eq!(rows.next().unwrap(), expected.as_slice(), "{width} x {height}, tile {tile}");
                }
            }
            assert!(rows.next().is_none());
        }
    }
}
