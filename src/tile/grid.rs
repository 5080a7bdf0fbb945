//! Where the tiles are.

use crate::raster::{SUBPIXEL_BITS, SUBPIXELS, TileOrigin};

/// Sub-pixels of half a pixel.
const HALF_PIXEL: i32 = SUBPIXELS / 2;

/// A picture cut into square tiles, row by row from the top left; the last of a row or column may be smaller.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TileGrid {
    width: u32,
    height: u32,
    side: u32,
    columns: u32,
    rows: u32,
}

impl TileGrid {
    /// A picture of `width` x `height` pixels in tiles of `side` pixels (16, 32 or 64).
    #[must_use]
    pub fn new(width: u32, height: u32, side: u32) -> Self {
        let side = side.max(1);
        Self { width, height, side, columns: width.div_ceil(side), rows: height.div_ceil(side) }
    }
    /// Width of the picture in pixels.
    #[must_use]
    pub fn width(&self) -> u32 {
        self.width
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
            x: x as i32 * SUBPIXELS - self.width as i32 * HALF_PIXEL,
            y: y as i32 * SUBPIXELS - self.height as i32 * HALF_PIXEL,
        }
    }
    /// Columns and rows of the tiles that a box of sub-pixels (`[min x, min y, max x, max y]`, relative to the centre)
    /// touches, half open: `[first column, first row, end column, end row]`.
    #[inline(always)]
    #[must_use]
    pub fn tiles_of_box(&self, bounds: [i32; 4]) -> [u32; 4] {
        let shift = SUBPIXEL_BITS + self.side.trailing_zeros();
        let half = [self.width as i32 * HALF_PIXEL, self.height as i32 * HALF_PIXEL];
        let first = |v: i32, k: usize| ((v + half[k]) >> shift).max(0) as u32;
        let end = |v: i32, k: usize, n: u32| ((((v + half[k]) >> shift) + 1).max(0) as u32).min(n);
        [
            first(bounds[0], 0),
            first(bounds[1], 1),
            end(bounds[2], 0, self.columns()),
            end(bounds[3], 1, self.rows()),
        ]
    }
}
