//! The planes of a picture by rows of tiles, cut into tiles when a thread comes to them.

use crate::jobs::lock;
use crate::reuse::{emptied, reserve_like};
use crate::tile::TileGrid;
use std::sync::Mutex;

/// Where tiles write their pixels: planes of the whole picture, each empty where it is not wanted.
#[derive(Debug, Default)]
pub(super) struct Planes {
    pub linear: Vec<[f32; 4]>,
    pub transmittance: Vec<[f32; 3]>,
    pub display: Vec<[u8; 4]>,
    pub blank: Blank,
}

/// Planes that are new memory, all zero, because no tile has been drawn into them yet.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Blank {
    pub linear: bool,
    pub display: bool,
}

impl Planes {
    /// Adds linear pixels, and their transmittance if something may tint it, in the memory of those that are `kept` if that is
    /// large enough.
    pub(super) fn add_light(&mut self, kept: &mut Self, count: usize, tints: bool) {
        (self.linear, self.blank.linear) = plane(&mut kept.linear, count, [0.0; 4]);
        if tints {
            (self.transmittance, _) = plane(&mut kept.transmittance, count, [0.0; 3]);
        }
    }

    /// Adds pixels of a screen, likewise.
    pub(super) fn add_display(&mut self, kept: &mut Self, count: usize) {
        (self.display, self.blank.display) = plane(&mut kept.display, count, [0; 4]);
    }
}

/// A plane of a picture, of which tiles write all; and whether it is zero now. It is `kept` if that is large enough, or new
/// memory that the system clears, page by page when a tile first writes to it.
fn plane<T: Copy>(kept: &mut Vec<T>, count: usize, zero: T) -> (Vec<T>, bool) {
    let mut plane = std::mem::take(kept);
    if plane.capacity() < count {
        return (vec![zero; count], true);
    }
    plane.resize(count, zero);
    (plane, false)
}

/// The rows of one tile.
#[derive(Debug, Default)]
pub(super) struct TileRows<'a> {
    /// One slice of the frame's pixels for each row, or none.
    pub linear: Vec<&'a mut [[f32; 4]]>,
    /// As many of the frame's transmittance, or none.
    pub transmittance: Vec<&'a mut [[f32; 3]]>,
    /// As many of the screen's pixels, or none.
    pub display: Vec<&'a mut [[u8; 4]]>,
    pub blank: Blank,
}

impl TileRows<'_> {
    /// None, with the memory for as many.
    pub(super) fn emptied<'b>(self) -> TileRows<'b> {
        TileRows {
            linear: emptied(self.linear),
            transmittance: emptied(self.transmittance),
            display: emptied(self.display),
            blank: Blank::default(),
        }
    }

    /// Takes as much memory as `other` has.
    pub(super) fn reserve_like(&mut self, other: &Self) {
        reserve_like(&mut self.linear, &other.linear);
        reserve_like(&mut self.transmittance, &other.transmittance);
        reserve_like(&mut self.display, &other.display);
    }
}

/// All rows of tiles.
///
/// A picture of 1024 x 1024 has 16,384 rows of tiles. Cut one after the other before the tiles are drawn they would take a
/// twentieth of the time of an empty picture, on one thread while the others wait; and a loop of their own on all threads
/// would have to wait for the last.
#[derive(Debug, Default)]
pub(super) struct Bands<'a> {
    rows: Vec<Mutex<Band<'a>>>,
    blank: Blank,
}

/// One row of tiles.
#[derive(Debug, Default)]
struct Band<'a> {
    linear: Part<'a, [f32; 4]>,
    transmittance: Part<'a, [f32; 3]>,
    display: Part<'a, [u8; 4]>,
}

/// What one row of tiles has of one plane.
#[derive(Debug)]
struct Part<'a, T> {
    /// Not cut yet.
    pixels: &'a mut [T],
    /// The rows of its tiles, tile by tile, from top to bottom in each; empty once they are taken.
    pieces: Vec<&'a mut [T]>,
}

impl<T> Default for Part<'_, T> {
    fn default() -> Self {
        Self { pixels: &mut [], pieces: Vec::new() }
    }
}

impl<'a> Bands<'a> {
    /// The rows of tiles of these planes.
    pub(super) fn of(planes: &'a mut Planes, grid: &TileGrid, memory: &mut Bands<'static>) -> Self {
        let mut bands = std::mem::take(memory).emptied();
        bands.blank = planes.blank;
        bands.rows.resize_with(grid.rows() as usize, Mutex::default);
        let pixels = grid.width() as usize * grid.side() as usize;
        let mut linear = planes.linear.chunks_mut(pixels);
        let mut transmittance = planes.transmittance.chunks_mut(pixels);
        let mut display = planes.display.chunks_mut(pixels);
        for band in &bands.rows {
            let mut band = lock(band);
            // Nothing where none are wanted.
            band.linear.pixels = linear.next().unwrap_or_default();
            band.transmittance.pixels = transmittance.next().unwrap_or_default();
            band.display.pixels = display.next().unwrap_or_default();
        }
        bands
    }

    /// Adds the rows of a tile, which has them from then on: a second time, they are empty.
    pub(super) fn take(&self, grid: &TileGrid, tile: usize, rows: &mut TileRows<'a>) {
        let columns = grid.columns() as usize;
        let mut band = lock(&self.rows[tile / columns]);
        band.linear.take(grid, tile % columns, &mut rows.linear);
        band.transmittance.take(grid, tile % columns, &mut rows.transmittance);
        band.display.take(grid, tile % columns, &mut rows.display);
        rows.blank = self.blank;
    }

    /// None, with the memory for as many.
    pub(super) fn emptied<'b>(self) -> Bands<'b> {
        let emptied = |band: Mutex<Band<'a>>| {
            let Band { linear, transmittance, display } = std::mem::take(&mut *lock(&band));
            let (linear, transmittance) = (linear.emptied(), transmittance.emptied());
            Mutex::new(Band { linear, transmittance, display: display.emptied() })
        };
        Bands { rows: self.rows.into_iter().map(emptied).collect(), blank: Blank::default() }
    }
}

impl<'a, T> Part<'a, T> {
    /// Moves the rows of a tile to `rows`.
    fn take(&mut self, grid: &TileGrid, column: usize, rows: &mut Vec<&'a mut [T]>) {
        if !self.pixels.is_empty() {
            self.cut(grid);
        }
        let height = self.pieces.len() / grid.columns() as usize;
        rows.extend(self.pieces[column * height..][..height].iter_mut().map(std::mem::take));
    }

    /// Cuts the pixels into the rows of tiles.
    fn cut(&mut self, grid: &TileGrid) {
        let (width, side, columns) = (grid.width() as usize, grid.side() as usize, grid.columns() as usize);
        let pixels = std::mem::take(&mut self.pixels);
        let height = pixels.len() / width;
        self.pieces.resize_with(columns * height, Default::default);
        for (y, row) in pixels.chunks_mut(width).enumerate() {
            for (column, piece) in row.chunks_mut(side).enumerate() {
                self.pieces[column * height + y] = piece;
            }
        }
    }

    fn emptied<'b>(self) -> Part<'b, T> {
        Part { pixels: &mut [], pieces: emptied(self.pieces) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_tile_gets_its_own_pixels() {
        let mut memory = Bands::default();
        for (width, height, side) in [(1, 1, 16), (40, 33, 16), (64, 64, 64), (65, 31, 32)] {
            let grid = TileGrid::new(width, height, side);
            let place = |k: u32| [(k % width) as f32, (k / width) as f32, 0.0, 0.0];
            let linear = (0..width * height).map(place).collect();
            let mut planes = Planes { linear, ..Planes::default() };
            let bands = Bands::of(&mut planes, &grid, &mut memory);
            // From the last to the first: no thread knows which tiles others have taken.
            for tile in (0..grid.len()).rev() {
                let mut rows = TileRows::default();
                bands.take(&grid, tile, &mut rows);
                let [left, top, tile_width, tile_height] = grid.pixels(tile);
                let expected: Vec<Vec<[f32; 4]>> = (top..top + tile_height)
                    .map(|y| (left..left + tile_width).map(|x| place(y * width + x)).collect())
                    .collect();
                assert_eq!(rows.linear, expected, "{width} x {height}, tile {tile}");
                assert!(rows.transmittance.is_empty() && rows.display.is_empty());
            }
            memory = bands.emptied();
        }
    }

    #[test]
    fn memory_stays_from_picture_to_picture() {
        let grid = TileGrid::new(100, 40, 32);
        let mut planes = Planes { display: vec![[0; 4]; 4000], ..Planes::default() };
        let mut memory = Bands::default();
        let mut places = Vec::new();
        for _ in 0..2 {
            let bands = Bands::of(&mut planes, &grid, &mut memory);
            bands.take(&grid, 0, &mut TileRows::default());
            memory = bands.emptied();
            let first = memory.rows[0].get_mut().unwrap();
            assert!(first.display.pieces.is_empty() && first.display.pieces.capacity() >= 4 * 32);
            places.push((
                memory.rows.as_ptr() as usize,
                memory.rows[0].get_mut().unwrap().display.pieces.as_ptr() as usize,
            ));
        }
        assert_eq!(places[0], places[1]);
    }
}
