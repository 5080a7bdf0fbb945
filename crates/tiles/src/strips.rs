//! The planes of a picture in strips, one a row of tiles, cut into tiles when a thread comes to them.

use overcoat_core::frame::Target;
use overcoat_core::jobs::lock;
use overcoat_core::reuse::{emptied, reserve_like};
use overcoat_stages::tile::TileGrid;
use std::sync::Mutex;

/// Planes of the whole picture that tiles write their pixels to, each empty where it is not wanted.
#[derive(Debug, Default)]
pub struct Planes {
    /// Linear light, premultiplied.
    pub linear: Vec<[f32; 4]>,
    /// Share of the light from behind the picture that comes through.
    pub transmittance: Vec<[f32; 3]>,
    /// Display codes.
    pub display: Vec<[u8; 4]>,
    /// Planes that hold nothing yet.
    pub blank: Blank,
}

/// Planes that are new memory, all zero, because no tile has been drawn into them yet.
#[derive(Clone, Copy, Debug, Default)]
pub struct Blank {
    /// Linear light.
    pub linear: bool,
    /// Display codes.
    pub display: bool,
}

impl Planes {
    /// Adds linear pixels, and their transmittance if something may tint it, in the memory of those that are `kept` if that is
    /// large enough.
    pub fn add_light(&mut self, kept: &mut Self, count: usize, tints: bool) {
        (self.linear, self.blank.linear) = plane(&mut kept.linear, count, [0.0; 4]);
        if tints {
            (self.transmittance, _) = plane(&mut kept.transmittance, count, [0.0; 3]);
        }
    }

    /// Adds pixels of a screen, likewise.
    pub fn add_display(&mut self, kept: &mut Self, count: usize) {
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
pub struct TileRows<'a> {
    /// One slice of the frame's pixels for each row, or none.
    pub linear: Vec<&'a mut [[f32; 4]]>,
    /// One slice of the frame's transmittance for each row, or none.
    pub transmittance: Vec<&'a mut [[f32; 3]]>,
    /// One slice of the screen's pixels for each row, or none.
    pub display: Vec<&'a mut [[u8; 4]]>,
    /// Rows of a target, as far as it holds those of the tile, and of these no more than it holds; or none.
    pub target: Vec<&'a mut [u8]>,
    /// Columns and rows of the tile before what the target holds.
    pub before_target: [usize; 2],
    /// Rows that hold nothing yet.
    pub blank: Blank,
}

impl TileRows<'_> {
    /// None, with the memory for as many.
    pub fn emptied<'b>(self) -> TileRows<'b> {
        TileRows {
            linear: emptied(self.linear),
            transmittance: emptied(self.transmittance),
            display: emptied(self.display),
            target: emptied(self.target),
            before_target: [0; 2],
            blank: Blank::default(),
        }
    }

    /// Takes as much memory as `other` has.
    pub fn reserve_like(&mut self, other: &Self) {
        reserve_like(&mut self.linear, &other.linear);
        reserve_like(&mut self.transmittance, &other.transmittance);
        reserve_like(&mut self.display, &other.display);
        reserve_like(&mut self.target, &other.target);
    }
}

/// The strips of a picture: all rows of tiles.
///
/// A picture of 1024 x 1024 has 16,384 rows of tiles. Cut one after the other before the tiles are drawn they would take a
/// twentieth of the time of an empty picture, on one thread while the others wait; and a loop of their own on all threads
/// would have to wait for the last.
#[derive(Debug, Default)]
pub struct Strips<'a> {
    rows: Vec<Mutex<Strip<'a>>>,
    /// First column and row of the picture that a target holds, and the ends.
    region: [u32; 4],
    blank: Blank,
}

/// One strip: a row of tiles.
#[derive(Debug, Default)]
struct Strip<'a> {
    linear: Part<'a, [f32; 4]>,
    transmittance: Part<'a, [f32; 3]>,
    display: Part<'a, [u8; 4]>,
    /// Rows of a target, from the first that the target holds on, and the same cut at the borders of tiles, row by row.
    target: Vec<&'a mut [u8]>,
    target_pieces: Vec<&'a mut [u8]>,
}

/// Share of one plane that belongs to one row of tiles.
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

impl<'a> Strips<'a> {
    /// The rows of tiles of these planes, and of a part of the picture that a target holds.
    pub fn of(
        planes: &'a mut Planes,
        target: Option<(&'a mut Target<'_>, [u32; 4])>,
        grid: &TileGrid,
        memory: &mut Strips<'static>,
    ) -> Self {
        let mut strips = std::mem::take(memory).emptied();
        strips.blank = planes.blank;
        // Those of larger pictures stay, with their memory.
        if strips.rows.len() < grid.rows() as usize {
            strips.rows.resize_with(grid.rows() as usize, Mutex::default);
        }
        let pixels = grid.width() as usize * grid.side() as usize;
        let mut linear = planes.linear.chunks_mut(pixels);
        let mut transmittance = planes.transmittance.chunks_mut(pixels);
        let mut display = planes.display.chunks_mut(pixels);
        for strip in &strips.rows {
            let mut strip = lock(strip);
            // Nothing where none are wanted.
            strip.linear.pixels = linear.next().unwrap_or_default();
            strip.transmittance.pixels = transmittance.next().unwrap_or_default();
            strip.display.pixels = display.next().unwrap_or_default();
        }
        if let Some((target, region)) = target {
            strips.region = region;
            for (y, row) in (region[1]..).zip(target.rows(region)) {
                lock(&strips.rows[(y / grid.side()) as usize]).target.push(row);
            }
        }
        strips
    }

    /// Adds the rows of a tile, which has them from then on: a second time, they are empty.
    pub fn take(&self, grid: &TileGrid, tile: usize, rows: &mut TileRows<'a>) {
        let columns = grid.columns() as usize;
        let mut strip = lock(&self.rows[tile / columns]);
        strip.linear.take(grid, tile % columns, &mut rows.linear);
        strip.transmittance.take(grid, tile % columns, &mut rows.transmittance);
        strip.display.take(grid, tile % columns, &mut rows.display);
        rows.before_target = strip.take_target(grid, tile, self.region, &mut rows.target);
        rows.blank = self.blank;
    }

    /// None, with the memory for as many.
    pub fn emptied<'b>(self) -> Strips<'b> {
        let emptied = |strip: Mutex<Strip<'a>>| {
            let Strip { linear, transmittance, display, target, target_pieces } =
                std::mem::take(&mut *lock(&strip));
            let (linear, transmittance) = (linear.emptied(), transmittance.emptied());
            let (target, target_pieces) = (emptied(target), emptied(target_pieces));
            Mutex::new(Strip { linear, transmittance, display: display.emptied(), target, target_pieces })
        };
        let rows = self.rows.into_iter().map(emptied).collect();
        Strips { rows, region: [0; 4], blank: Blank::default() }
    }
}

impl<'a> Strip<'a> {
    /// Moves the part of a tile's rows that a target holds to `rows`. Returns the number of columns and rows of the
    /// tile before that.
    fn take_target(
        &mut self,
        grid: &TileGrid,
        tile: usize,
        region: [u32; 4],
        rows: &mut Vec<&'a mut [u8]>,
    ) -> [usize; 2] {
        if !self.target.is_empty() {
            self.cut_target(grid, region);
        }
        let [first, top, end, _] = grid.tiles_of_pixels(region);
        let column = tile as u32 % grid.columns();
        let [left, above, ..] = grid.pixels(tile);
        if self.target_pieces.is_empty()
            || !(first..end).contains(&column)
            || tile as u32 / grid.columns() < top
        {
            return [0; 2];
        }
        let (column, columns) = ((column - first) as usize, (end - first) as usize);
        rows.extend(self.target_pieces.iter_mut().skip(column).step_by(columns).map(std::mem::take));
        [region[0].saturating_sub(left) as usize, region[1].saturating_sub(above) as usize]
    }

    /// Cuts the rows of a target at the borders of tiles.
    fn cut_target(&mut self, grid: &TileGrid, region: [u32; 4]) {
        let [first, _, end, _] = grid.tiles_of_pixels(region);
        let width = (region[2] - region[0]) as usize;
        for mut row in self.target.drain(..) {
            let pixel = row.len() / width;
            for column in first..end {
                // As far as the next tile, or the end of the region.
                let border =
                    ((column + 1) * grid.side()).min(region[2]) - (column * grid.side()).max(region[0]);
                let (piece, rest) = row.split_at_mut(border as usize * pixel);
                self.target_pieces.push(piece);
                row = rest;
            }
        }
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
    use overcoat_core::frame::PixelFormat;

    #[test]
    fn every_tile_gets_its_own_pixels() {
        let mut memory = Strips::default();
        for (width, height, side) in [(1, 1, 16), (40, 33, 16), (64, 64, 64), (65, 31, 32)] {
            let grid = TileGrid::new(width, height, side);
            let place = |k: u32| [(k % width) as f32, (k / width) as f32, 0.0, 0.0];
            let linear = (0..width * height).map(place).collect();
            let mut planes = Planes { linear, ..Planes::default() };
            let strips = Strips::of(&mut planes, None, &grid, &mut memory);
            // From the last to the first: no thread knows which tiles others have taken.
            for tile in (0..grid.len()).rev() {
                let mut rows = TileRows::default();
                strips.take(&grid, tile, &mut rows);
                let [left, top, tile_width, tile_height] = grid.pixels(tile);
                let expected: Vec<Vec<[f32; 4]>> = (top..top + tile_height)
                    .map(|y| (left..left + tile_width).map(|x| place(y * width + x)).collect())
                    .collect();
                assert_eq!(rows.linear, expected, "{width} x {height}, tile {tile}");
                assert!(rows.transmittance.is_empty() && rows.display.is_empty());
            }
            memory = strips.emptied();
        }
    }

    #[test]
    fn every_tile_gets_what_a_target_holds_of_it() {
        let grid = TileGrid::new(70, 50, 16);
        let mut memory = Strips::default();
        for region in [[0, 0, 70, 50], [5, 17, 6, 18], [16, 16, 32, 32], [15, 3, 65, 50], [69, 49, 70, 50]] {
            let [left, top, right, bottom] = region;
            let (width, height) = (right - left, bottom - top);
            let stride = width as usize * 4 + 3;
            let mut bytes = vec![7; stride * height as usize];
            let mut target = Target::new(&mut bytes, stride, PixelFormat::Rgba8);
            let (mut planes, mut count) = (Planes::default(), 0);
            let strips = Strips::of(&mut planes, Some((&mut target, region)), &grid, &mut memory);
            for tile in (0..grid.len()).rev() {
                let mut rows = TileRows::default();
                strips.take(&grid, tile, &mut rows);
                let [x, y, ..] = grid.pixels(tile);
                let [columns_before, rows_before] = rows.before_target;
                for (k, row) in rows.target.iter_mut().enumerate() {
                    for (j, pixel) in row.as_chunks_mut::<4>().0.iter_mut().enumerate() {
                        *pixel =
                            [x as u8 + (columns_before + j) as u8, y as u8 + (rows_before + k) as u8, 0, 1];
                        count += 1;
                    }
                }
            }
            memory = strips.emptied();
            assert_eq!(count, width * height, "{region:?}");
            for (y, row) in bytes.chunks(stride).enumerate() {
                let (pixels, rest) = row.split_at(stride - 3);
                for (x, pixel) in pixels.chunks(4).enumerate() {
                    assert_eq!(
                        pixel,
                        [(left as usize + x) as u8, (top as usize + y) as u8, 0, 1],
                        "{region:?}"
                    );
                }
                assert_eq!(rest, [7; 3], "between rows");
            }
        }
    }

    #[test]
    fn memory_stays_from_picture_to_picture() {
        let grid = TileGrid::new(100, 40, 32);
        let mut planes = Planes { display: vec![[0; 4]; 4000], ..Planes::default() };
        let mut memory = Strips::default();
        let mut places = Vec::new();
        for _ in 0..2 {
            let strips = Strips::of(&mut planes, None, &grid, &mut memory);
            strips.take(&grid, 0, &mut TileRows::default());
            memory = strips.emptied();
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
