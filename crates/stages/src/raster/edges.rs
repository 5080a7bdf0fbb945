//! Edge functions and the fill rule.

use super::{SUBPIXEL_BITS, SUBPIXELS, SamplePattern, Triangle};
use overcoat_core::math::lanes::{Int, LANES, Lanes};

/// Triangles with sides below this many sub-pixels (16 pixels) are set up in 32 bits.
const SMALL: i32 = 1 << 12;

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
/// so that inside is `E >= 0` for all.
///
/// Triangles below 16 pixels keep E itself. For larger ones it would not fit an `i32`: with p = pixel * 256 + offset
/// the pixel's part is a multiple of 256, so the sign of E is that of `A column + B row + floor(constant / 256)`,
/// which does fit inside a tile.
#[derive(Clone, Copy, Debug)]
pub struct EdgeFunctions {
    /// Change per pixel to the right.
    pub a: [i32; 3],
    /// Change per pixel down.
    pub b: [i32; 3],
    /// For each edge, the constant of each sample at the tile's first pixel.
    pub constants: [[i32; LANES]; 3],
    /// At least the largest constant over the samples.
    pub largest: [i32; 3],
    /// At most the smallest constant over the samples.
    pub smallest: [i32; 3],
}

impl EdgeFunctions {
    /// Sets up the edges of a triangle for a tile of at most 64 x 64 pixels that its box touches.
    #[inline(always)]
    #[must_use]
    pub fn new<L: Lanes>(l: L, triangle: &Triangle, origin: TileOrigin, pattern: &SamplePattern) -> Self {
        let mut edges =
            Self { a: [0; 3], b: [0; 3], constants: [[0; LANES]; 3], largest: [0; 3], smallest: [0; 3] };
        let [min_x, min_y, max_x, max_y] = triangle.bounds();
        let small = max_x - min_x < SMALL && max_y - min_y < SMALL;
        for k in 0..3 {
            let next = if k == 2 { 0 } else { k + 1 };
            let a = triangle.y[k] - triangle.y[next];
            let b = triangle.x[next] - triangle.x[k];
            let bias = if a > 0 || (a == 0 && b > 0) { 0 } else { -1 };
            let (to_x, to_y) = (origin.x - triangle.x[k], origin.y - triangle.y[k]);
            if small {
                // Below 2^12 * 2^15 * 2: the vertex lies within 80 pixels of the tile's corner.
                let at_origin = a * to_x + b * to_y + bias;
                let [x, y] = pattern.offset_lanes();
                edges.constants[k] = (l.load_i(x) * a + l.load_i(y) * b + at_origin).to_array();
                edges.largest[k] = at_origin + a.max(0) * SUBPIXELS + b.max(0) * SUBPIXELS;
                edges.smallest[k] = at_origin + a.min(0) * SUBPIXELS + b.min(0) * SUBPIXELS;
                (edges.a[k], edges.b[k]) = (a * SUBPIXELS, b * SUBPIXELS);
            } else {
                edges.large_edge(
                    k,
                    [a, b],
                    i64::from(a) * i64::from(to_x) + i64::from(b) * i64::from(to_y) + i64::from(bias),
                    pattern,
                );
            }
        }
        edges
    }

    /// An edge whose values need 64 bits.
    #[inline(never)]
    fn large_edge(&mut self, k: usize, [a, b]: [i32; 2], at_origin: i64, pattern: &SamplePattern) {
        (self.a[k], self.b[k]) = (a, b);
        (self.largest[k], self.smallest[k]) = (i32::MIN, i32::MAX);
        for (constant, offset) in self.constants[k].iter_mut().zip(pattern.offsets()) {
            // The sample's offset comes in before the shift: the floor is exact for each sample.
            let exact = at_origin + i64::from(a) * i64::from(offset[0]) + i64::from(b) * i64::from(offset[1]);
            *constant = (exact >> SUBPIXEL_BITS).clamp(-CLAMP, CLAMP) as i32;
            self.largest[k] = self.largest[k].max(*constant);
            self.smallest[k] = self.smallest[k].min(*constant);
        }
    }

    /// Columns and rows of pixels in the tile that the triangle's box touches, half open:
    /// `[first column, first row, end column, end row]`, within `0..width` and `0..height`; empty if it misses.
    #[inline(always)]
    #[must_use]
    pub fn pixel_box(triangle: &Triangle, origin: TileOrigin, width: i32, height: i32) -> [i32; 4] {
        super::pixel_box(triangle.bounds(), origin, width, height)
    }
}
