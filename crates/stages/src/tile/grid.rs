//! Grid of tiles over the picture.

use crate::raster::{SUBPIXEL_BITS, SUBPIXELS, TileOrigin};

/// A picture cut into square tiles, row by row from the top left; the last of a row or column may be smaller.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TileGrid {
    width: u32,
    height: u32,
    side: u32,
    columns: u32,
    rows: u32,
    /// First column and row, and the ends, of the tiles that triangles are listed for.
    listed: [u32; 4],
}

impl TileGrid {
    /// A picture of `width` x `height` pixels in tiles of `side` pixels (16, 32 or 64).
    #[must_use]
    pub fn new(width: u32, height: u32, side: u32) -> Self {
        let side = side.max(1);
        let (columns, rows) = (width.div_ceil(side), height.div_ceil(side));
        Self { width, height, side, columns, rows, listed: [0, 0, columns, rows] }
    }
    /// The same tiles, of which triangles are listed for those alone that touch a box of pixels (`[left, top, end column, end
    /// row]`).
    #[must_use]
    pub fn listed_within(self, pixels: [u32; 4]) -> Self {
        Self { listed: self.tiles_of_pixels(pixels), ..self }
    }
    /// Columns and rows of the tiles that a box of pixels touches, half open, as the box is.
    #[must_use]
    pub fn tiles_of_pixels(&self, [left, top, right, bottom]: [u32; 4]) -> [u32; 4] {
        let end = |pixel: u32, tiles: u32| pixel.div_ceil(self.side).min(tiles);
        [left / self.side, top / self.side, end(right, self.columns), end(bottom, self.rows)]
    }
    /// Width of the picture in pixels.
    #[must_use]
    pub fn width(&self) -> u32 {
        self.width
    }
    /// Number of pixels of the picture.
    #[must_use]
    pub fn pixel_count(&self) -> usize {
        self.width as usize * self.height as usize
    }
    /// Height of the picture in pixels.
    #[must_use]
    pub fn height(&self) -> u32 {
        self.height
    }
    /// Side of a tile in pixels.
    #[must_use]
    pub fn side(&self) -> u32 {
        self.side
    }
    /// Tiles in a row.
    #[must_use]
    pub fn columns(&self) -> u32 {
        self.columns
    }
    /// Rows of tiles.
    #[must_use]
    pub fn rows(&self) -> u32 {
        self.rows
    }
    /// The tile that a pixel of the picture lies in.
    #[must_use]
    pub fn tile_of(&self, [x, y]: [u32; 2]) -> usize {
        (y / self.side) as usize * self.columns as usize + (x / self.side) as usize
    }
    /// True if triangles are listed for the tile that a pixel lies in.
    #[must_use]
    pub fn lists(&self, [x, y]: [u32; 2]) -> bool {
        let [left, top, right, bottom] = self.listed;
        (left..right).contains(&(x / self.side)) && (top..bottom).contains(&(y / self.side))
    }
    /// Number of tiles.
    #[must_use]
    pub fn len(&self) -> usize {
        self.columns() as usize * self.rows() as usize
    }
    /// True for a picture without pixels.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
    /// First column, first row, width and height of a tile in pixels.
    #[must_use]
    pub fn pixels(&self, tile: usize) -> [u32; 4] {
        let columns = self.columns() as usize;
        let (x, y) = ((tile % columns) as u32 * self.side, (tile / columns) as u32 * self.side);
        [x, y, self.side.min(self.width - x), self.side.min(self.height - y)]
    }
    /// A tile's corner in sub-pixels relative to the viewport's centre.
    #[must_use]
    pub fn origin(&self, tile: usize) -> TileOrigin {
        let [x, y, ..] = self.pixels(tile);
        TileOrigin {
            x: x as i32 * SUBPIXELS - self.width as i32 * (SUBPIXELS / 2),
            y: y as i32 * SUBPIXELS - self.height as i32 * (SUBPIXELS / 2),
        }
    }
    /// Columns and rows of the tiles that a box of sub-pixels (`[min x, min y, max x, max y]`, relative to the centre)
    /// touches, half open: `[first column, first row, end column, end row]`; only those that triangles are listed for.
    #[inline(always)]
    #[must_use]
    pub fn tiles_of_box(&self, bounds: [i32; 4]) -> [u32; 4] {
        let shift = SUBPIXEL_BITS + self.side.trailing_zeros();
        let half = [self.width, self.height].map(|side| side as i32 * (SUBPIXELS / 2));
        let [left, top, right, bottom] = self.listed;
        let first = |v: i32, k: usize, least: u32| (((v + half[k]) >> shift).max(0) as u32).max(least);
        let end = |v: i32, k: usize, n: u32| ((((v + half[k]) >> shift) + 1).max(0) as u32).min(n);
        let [first_column, first_row] = [first(bounds[0], 0, left), first(bounds[1], 1, top)];
        let [end_column, end_row] = [end(bounds[2], 0, right), end(bounds[3], 1, bottom)];
        [first_column, first_row, end_column.max(first_column), end_row.max(first_row)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boxes_list_the_tiles_that_they_touch_and_that_are_asked_for() {
        let grid = TileGrid::new(100, 70, 32);
        let all = |grid: &TileGrid| {
            grid.tiles_of_box([-50 * SUBPIXELS, -35 * SUBPIXELS, 50 * SUBPIXELS, 35 * SUBPIXELS])
        };
        assert_eq!(all(&grid), [0, 0, 4, 3]);
        let part = grid.listed_within([33, 10, 64, 33]);
        assert_eq!(
            (all(&part), part.lists([32, 0]), part.lists([31, 0]), part.lists([64, 63])),
            ([1, 0, 2, 2], true, false, false)
        );
        // Beside it nothing, and no negative number of tiles.
        for beside in [[-40, -30, -30, -20], [40, 30, 45, 33], [-40, 30, -30, 33]] {
            let [left, top, right, bottom] = part.tiles_of_box(beside.map(|pixels| pixels * SUBPIXELS));
            assert!(right >= left && bottom >= top && (right == left || bottom == top), "{beside:?}");
        }
        assert_eq!((grid.tile_of([99, 69]), grid.tile_of([32, 31])), (11, 1));
        assert_eq!(grid.tiles_of_pixels([0, 0, 1, 1]), [0, 0, 1, 1]);
        assert_eq!(grid.tiles_of_pixels([31, 32, 33, 65]), [0, 1, 2, 3]);
    }
}
