//! Triangles and discs to visibility: which of them each sample of a tile sees. Integers only, but for depth and for what a
//! disc covers.
//!
//! Screen positions are fixed-point with 8 sub-pixel bits, relative to the centre of the viewport, +x right, +y
//! down. The guard band keeps them within ±2^14 pixels, so differences stay below 2^23 sub-pixels and every
//! edge function inside a tile of up to 64 pixels fits an `i32`.
//!
//! **Invariant:** each sample inside a mesh of triangles that share edges is covered exactly once; nothing depends
//! on tile size, instruction set or the order of work beyond the order of the triangles.

mod disc;
mod edges;
mod samples;
mod small;
mod triangle;
mod visibility_buffer;

pub use disc::{Disc, Spread};
pub use edges::{EdgeFunctions, TileOrigin};
pub use samples::{SamplePattern, SampleSums};
pub use small::{FewPixels, OutlineLanes, SmallLanes, SmallSamples};
pub use triangle::Triangle;
pub use visibility_buffer::{NO_TRIANGLE, VisibilityBuffer};

/// Sub-pixel bits of a screen position.
pub const SUBPIXEL_BITS: u32 = 8;
/// Sub-pixels of a pixel.
pub const SUBPIXELS: i32 = 1 << SUBPIXEL_BITS;
/// Largest distance of a position from the viewport's centre, in pixels.
pub const GUARD_BAND: i32 = 1 << 14;
/// Pixels of a block's side: one block is one vector.
pub const BLOCK: usize = 4;

/// Columns and rows of pixels in a tile that a box of sub-pixels touches, half open: `[first column, first row, end column,
/// end row]`, within `0..width` and `0..height`; empty if it misses.
#[inline(always)]
fn pixel_box(bounds: [i32; 4], origin: TileOrigin, width: i32, height: i32) -> [i32; 4] {
    let [min_x, min_y, max_x, max_y] = bounds;
    [
        ((min_x - origin.x) >> SUBPIXEL_BITS).max(0),
        ((min_y - origin.y) >> SUBPIXEL_BITS).max(0),
        (((max_x - origin.x) + SUBPIXELS) >> SUBPIXEL_BITS).min(width),
        (((max_y - origin.y) + SUBPIXELS) >> SUBPIXEL_BITS).min(height),
    ]
}
