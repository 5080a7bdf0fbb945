//! Perspective-correct barycentric coordinates and their derivatives.

use super::Batch;
use super::batch::interpolate;
use crate::raster::{SUBPIXEL_BITS, SUBPIXELS, SampleSums};
use overcoat_core::each;
use overcoat_core::math::lanes::{Float, Int, Lanes};

/// Position of each fragment of a batch on its triangle.
#[derive(Clone, Copy)]
pub struct Location<L: Lanes> {
    /// Weights of vertices 1 and 2, perspective-correct, 0 to 1.
    pub barycentric: [L::F; 2],
    /// Their change per pixel to the right; of fragments that stand for a part of a pixel, over the side of that.
    pub barycentric_dx: [L::F; 2],
    /// Their change per pixel down, likewise.
    pub barycentric_dy: [L::F; 2],
    /// Depth: 1 / distance for perspective, -distance for orthographic views.
    pub depth: L::F,
    /// Pixels right of and below the viewport's centre.
    pub screen: [L::F; 2],
}

/// Locates the centroids of the covered samples. The centroid lies inside the triangle, so nothing is extrapolated;
/// weights are clamped to 0..1 against rounding, depth to the range of the vertices.
#[inline(always)]
pub fn locate<L: Lanes>(l: L, batch: &Batch, perspective: bool) -> Location<L> {
    // Distances in sub-pixels are integers that floats hold exactly, so it does not show where the tile begins.
    let centroid = if batch.partial {
        SampleSums::centroids(l, l.load_i(&batch.samples))
    } else {
        each!(c in batch.whole_centroid => l.splat(c))
    };
    // Column and row of the pixel, in sub-pixels.
    let pixel = l.load_i(&batch.pixel);
    let place = [(pixel & 63).shl(SUBPIXEL_BITS), pixel.shr_logical(6).shl(SUBPIXEL_BITS)];
    let corner: [L::I; 2] = each!(k => place[k] + batch.origin[k]);
    let [vx, vy] = [&batch.x, &batch.y];
    let (x0, y0) = (l.load_i(&vx[0]), l.load_i(&vy[0]));
    let x = (corner[0] - x0).to_float() + centroid[0];
    let y = (corner[1] - y0).to_float() + centroid[1];
    let screen: [L::F; 2] = each!(k => (corner[k].to_float() + centroid[k]) * (1.0 / SUBPIXELS as f32));
    let [x1, x2]: [L::F; 2] = each!(v => (l.load_i(&vx[v + 1]) - x0).to_float());
    let [y1, y2]: [L::F; 2] = each!(v => (l.load_i(&vy[v + 1]) - y0).to_float());
    let [d0, d1, d2] = [l.load(&batch.depth[0]), l.load(&batch.depth[1]), l.load(&batch.depth[2])];
    // Screen-space barycentric coordinates; the area is positive by construction of the triangle.
    let inverse_area = (x1 * y2 - x2 * y1).recip();
    let screen_1 = ((x * y2 - y * x2) * inverse_area).saturate();
    let screen_2 = ((y * x1 - x * y1) * inverse_area).saturate();
    let screen_0 = (screen_1 + screen_2).one_minus().saturate();
    // Their change per pixel.
    let per_pixel = inverse_area * SUBPIXELS as f32;
    let (s1x, s1y) = (y2 * per_pixel, -x2 * per_pixel);
    let (s2x, s2y) = (-y1 * per_pixel, x1 * per_pixel);
    let (mut b, mut dx, mut dy, depth);
    if perspective {
        // Barycentric coordinates over distance are linear on the screen.
        let (n0, n1, n2) = (screen_0 * d0, screen_1 * d1, screen_2 * d2);
        let sum = n0 + n1 + n2;
        let inverse = sum.recip();
        b = [n1 * inverse, n2 * inverse];
        let (n1x, n1y, n2x, n2y) = (s1x * d1, s1y * d1, s2x * d2, s2y * d2);
        let sum_x = n1x + n2x - (s1x + s2x) * d0;
        let sum_y = n1y + n2y - (s1y + s2y) * d0;
        dx = [(n1x - b[0] * sum_x) * inverse, (n2x - b[1] * sum_x) * inverse];
        dy = [(n1y - b[0] * sum_y) * inverse, (n2y - b[1] * sum_y) * inverse];
        depth = sum;
    } else {
        b = [screen_1, screen_2];
        dx = [s1x, s2x];
        dy = [s1y, s2y];
        depth = d0 * screen_0 + d1 * screen_1 + d2 * screen_2;
    }
    let depth = depth.max(d0.min(d1).min(d2)).min(d0.max(d1).max(d2));
    if batch.any_clipped {
        let corners = each!(v => each!(axis => l.load(&batch.corners[v][axis])));
        b = interpolate(&corners, &b);
        [dx, dy] = each!(d in [dx, dy] =>
            each!(n => d[0] * (corners[1][n] - corners[0][n]) + d[1] * (corners[2][n] - corners[0][n])));
    }
    if batch.finer {
        let side = l.load(&batch.sides);
        (dx, dy) = (each!(n => dx[n] * side), each!(n => dy[n] * side));
    }
    Location { barycentric: b, barycentric_dx: dx, barycentric_dy: dy, depth, screen }
}

impl<L: Lanes> Location<L> {
    /// A location that has no meaning yet.
    #[inline(always)]
    pub fn none(l: L) -> Self {
        let zero = [l.zero(); 2];
        Self { barycentric: zero, barycentric_dx: zero, barycentric_dy: zero, depth: l.zero(), screen: zero }
    }

    /// An attribute at the fragments.
    #[inline(always)]
    pub fn interpolate<const N: usize>(&self, vertices: &[[L::F; N]; 3]) -> [L::F; N] {
        interpolate(vertices, &self.barycentric)
    }

    /// Change of an attribute per pixel to the right and per pixel down.
    #[inline(always)]
    pub fn derivatives<const N: usize>(&self, vertices: &[[L::F; N]; 3]) -> [[L::F; N]; 2] {
        each!(d in [self.barycentric_dx, self.barycentric_dy] =>
            each!(n => d[0] * (vertices[1][n] - vertices[0][n]) + d[1] * (vertices[2][n] - vertices[0][n])))
    }
}
