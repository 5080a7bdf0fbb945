//! Edge functions and the fill rule.

use super::{SUBPIXEL_BITS, SUBPIXELS, SamplePattern, Triangle};

/// Largest magnitude of a tile-relative edge constant: beyond it the sign is settled for the whole tile.
const CLAMP: i64 = 1 << 30;

/// Place of a tile: its top left pixel's corner in sub-pixels relative to the viewport's centre.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TileOrigin {
    /// Sub-pixels right of the centre.
    pub x: i32,
    /// Sub-pixels below the centre.
    pub y: i32,
}

/// The three edge functions of a triangle relative to a tile.
///
/// `E(p) = A x + B y + C` in exact integers is positive inside. A sample on an edge belongs to the triangle if the
/// edge is a left edge (A > 0) or a top edge (A = 0, B > 0), as in Direct3D and Vulkan; other edges are biased by -1,
/// so that inside is `E >= 0` for all. With p = pixel * 256 + offset, the pixel's part is a multiple of 256, and the
/// sign of E is that of `A column + B row + floor(constant / 256)`, which fits an `i32` inside a tile.
#[derive(Clone, Copy, Debug)]
pub struct EdgeFunctions {
    /// Change per pixel to the right.
    pub a: [i32; 3],
    /// Change per pixel down.
    pub b: [i32; 3],
    /// For each sample, the three constants at the tile's first pixel.
    pub constants: [[i32; 3]; 16],
    /// Largest constant over the samples.
    pub largest: [i32; 3],
    /// Smallest constant over the samples.
    pub smallest: [i32; 3],
}

impl EdgeFunctions {
    /// Sets up the edges of a triangle for a tile of at most 64 x 64 pixels.
    #[inline(always)]
    #[must_use]
    pub fn new(triangle: &Triangle, origin: TileOrigin, pattern: &SamplePattern) -> Self {
        let mut edges = Self {
            a: [0; 3],
            b: [0; 3],
            constants: [[0; 3]; 16],
            largest: [i32::MIN; 3],
            smallest: [i32::MAX; 3],
        };
        for k in 0..3 {
            let next = if k == 2 { 0 } else { k + 1 };
            let a = triangle.y[k] - triangle.y[next];
            let b = triangle.x[next] - triangle.x[k];
            let bias = if a > 0 || (a == 0 && b > 0) { 0 } else { -1 };
            let at_origin = i64::from(a) * i64::from(origin.x - triangle.x[k])
                + i64::from(b) * i64::from(origin.y - triangle.y[k])
                + bias;
            edges.a[k] = a;
            edges.b[k] = b;
            for (constants, offset) in edges.constants.iter_mut().zip(pattern.offsets()) {
                // The sample's offset comes in before the shift: the floor is exact for each sample.
                let exact =
                    at_origin + i64::from(a) * i64::from(offset[0]) + i64::from(b) * i64::from(offset[1]);
                let c = (exact >> SUBPIXEL_BITS).clamp(-CLAMP, CLAMP) as i32;
                constants[k] = c;
                edges.largest[k] = edges.largest[k].max(c);
                edges.smallest[k] = edges.smallest[k].min(c);
            }
        }
        edges
    }

    /// Columns and rows of pixels in the tile that the triangle's box touches, half open:
    /// `[first column, first row, end column, end row]`, within `0..width` and `0..height`; empty if it misses.
    #[inline(always)]
    #[must_use]
    pub fn pixel_box(triangle: &Triangle, origin: TileOrigin, width: i32, height: i32) -> [i32; 4] {
        let [min_x, min_y, max_x, max_y] = triangle.bounds();
        [
            ((min_x - origin.x) >> SUBPIXEL_BITS).max(0),
            ((min_y - origin.y) >> SUBPIXEL_BITS).max(0),
            (((max_x - origin.x) + SUBPIXELS) >> SUBPIXEL_BITS).min(width),
            (((max_y - origin.y) + SUBPIXELS) >> SUBPIXEL_BITS).min(height),
        ]
    }
}
