//! Perspective-correct barycentric coordinates and their derivatives.

use super::Batch;
use super::batch::interpolate;
use crate::each;
use crate::math::lanes::{Float, Lanes};

/// Where on its triangle each fragment of a batch lies.
#[derive(Clone, Copy)]
pub struct Location<L: Lanes> {
    /// Weights of vertices 1 and 2, perspective-correct, 0 to 1.
    pub barycentric: [L::F; 2],
    /// Their change per pixel to the right.
    pub barycentric_dx: [L::F; 2],
    /// Their change per pixel down.
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
    let (x, y) = (l.load(&batch.x), l.load(&batch.y));
    let [x1, x2] = [l.load(&batch.edge_x[0]), l.load(&batch.edge_x[1])];
    let [y1, y2] = [l.load(&batch.edge_y[0]), l.load(&batch.edge_y[1])];
    let [d0, d1, d2] = [l.load(&batch.depth[0]), l.load(&batch.depth[1]), l.load(&batch.depth[2])];
    // Screen-space barycentric coordinates; the area is positive by construction of the triangle.
    let inverse_area = (x1 * y2 - x2 * y1).recip();
    let screen_1 = ((x * y2 - y * x2) * inverse_area).saturate();
    let screen_2 = ((y * x1 - x * y1) * inverse_area).saturate();
    let screen_0 = (screen_1 + screen_2).one_minus().saturate();
    // Their change per pixel.
    let per_pixel = inverse_area * 256.0;
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
    Location {
        barycentric: b,
        barycentric_dx: dx,
        barycentric_dy: dy,
        depth,
        screen: [l.load(&batch.screen_x), l.load(&batch.screen_y)],
    }
}

impl<L: Lanes> Location<L> {
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
