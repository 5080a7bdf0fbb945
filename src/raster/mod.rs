//! Triangles to visibility: which triangle each sample of a tile sees. Integers only, but for depth.
//!
//! Screen positions are fixed-point with 8 sub-pixel bits, relative to the centre of the viewport, +x right, +y
//! down. The guard band keeps them within ±2^14 pixels, so differences stay below 2^23 sub-pixels and every
//! edge function inside a tile of up to 64 pixels fits an `i32`.
//!
//! **Invariant:** each sample inside a mesh of triangles that share edges is covered exactly once; nothing depends
//! on tile size, instruction set or the order of work beyond the order of the triangles.

mod edges;
mod samples;
mod small;
mod triangle;
mod visibility;

pub use edges::{EdgeFunctions, TileOrigin};
pub use samples::{SamplePattern, SampleSums};
pub use small::{FewPixels, OutlineLanes, SmallLanes, SmallSamples};
pub use triangle::Triangle;
pub use visibility::{NO_TRIANGLE, Visibility};

/// Sub-pixel bits of a screen position.
pub const SUBPIXEL_BITS: u32 = 8;
/// Sub-pixels of a pixel.
pub const SUBPIXELS: i32 = 1 << SUBPIXEL_BITS;
/// Largest distance of a position from the viewport's centre, in pixels.
pub const GUARD_BAND: i32 = 1 << 14;
/// Pixels of a block's side: one block is one vector.
pub const BLOCK: usize = 4;
