//! Triangles so small that one vector holds every sample that they may cover: most triangles of dense meshes.

use super::{SUBPIXELS, SamplePattern, TileOrigin, Triangle};
use crate::math::lanes::{Float, Int, Lanes, Mask};

/// The edge functions of a small triangle, and the places of samples that may lie in it.
///
/// * With one sample a pixel, a box below four pixels: at most 4 x 4 samples.
/// * With several, a box below one pixel: it touches at most 2 x 2 pixels, and of the places that a sample has in them
///   at most one lies in the box.
///
/// Either way sixteen lanes say exactly what is covered, in 32 bits and without a walk over blocks. The fill rule is that
/// of [`EdgeFunctions`](super::EdgeFunctions), of which these are the values.
#[derive(Clone, Copy, Debug)]
pub struct SmallTriangle {
    /// What the places are counted from, relative to the origin, in sub-pixels: with one sample a pixel the first sample
    /// that is not left of or above the box, else the corner of the box's first pixel.
    corner: [i32; 2],
    /// With one sample a pixel, the columns and rows of samples in the box; else the box's first column and row relative
    /// to `corner`.
    extent: [i32; 2],
    /// For each edge, A, B and the constant at `corner`, biased by the fill rule.
    edges: [[i32; 3]; 3],
}

impl SmallTriangle {
    /// The edges of a triangle with vertices in the order of positive area; `None` if its box is too large. `origin` is
    /// the corner of some pixel, no farther than the guard band.
    #[inline(always)]
    #[must_use]
    pub fn new(
        x: [i32; 3],
        y: [i32; 3],
        bounds: [i32; 4],
        origin: TileOrigin,
        pattern: &SamplePattern,
    ) -> Option<Self> {
        let single = pattern.single();
        let side = if single.is_some() { 4 * SUBPIXELS } else { SUBPIXELS };
        if bounds[2] - bounds[0] >= side || bounds[3] - bounds[1] >= side {
            return None;
        }
        let low = [bounds[0] - origin.x, bounds[1] - origin.y];
        let (corner, extent) = match single {
            Some(offset) => {
                let high = [bounds[2] - origin.x, bounds[3] - origin.y];
                let first = |k: usize| {
                    let above = low[k] - offset[k] + SUBPIXELS - 1;
                    (above & !(SUBPIXELS - 1)) + offset[k]
                };
                let corner = [first(0), first(1)];
                let count = |k: usize| (high[k] - corner[k] + SUBPIXELS) >> super::SUBPIXEL_BITS;
                (corner, [count(0), count(1)])
            }
            None => {
                let corner = [low[0] & !(SUBPIXELS - 1), low[1] & !(SUBPIXELS - 1)];
                (corner, [low[0] - corner[0], low[1] - corner[1]])
            }
        };
        let mut edges = [[0; 3]; 3];
        for k in 0..3 {
            let next = if k == 2 { 0 } else { k + 1 };
            let (a, b) = (y[k] - y[next], x[next] - x[k]);
            let bias = if a > 0 || (a == 0 && b > 0) { 0 } else { -1 };
            // Below 2^10 * 2^11 * 2.
            let (to_x, to_y) = (corner[0] + origin.x - x[k], corner[1] + origin.y - y[k]);
            edges[k] = [a, b, a * to_x + b * to_y + bias];
        }
        Some(Self { corner, extent, edges })
    }

    /// The places of samples relative to the origin in sub-pixels, and which of them are covered. Lanes are samples, or
    /// pixels where a pixel has one sample.
    #[inline(always)]
    #[must_use]
    pub fn samples<L: Lanes>(&self, l: L, pattern: &SamplePattern) -> ([L::I; 2], L::M) {
        let (x, y) = if pattern.single().is_some() {
            let lane = l.lane_indices();
            ((lane & 3).shl(super::SUBPIXEL_BITS), lane.shr(2).shl(super::SUBPIXEL_BITS))
        } else {
            let [x, y] = pattern.offset_lanes();
            (self.place(l, l.load_i(x), 0), self.place(l, l.load_i(y), 1))
        };
        let [e, f, g] = self.edges;
        let e = x * e[0] + y * e[1] + e[2];
        let f = x * f[0] + y * f[1] + f[2];
        let g = x * g[0] + y * g[1] + g[2];
        let inside = (e | f | g).non_negative() & l.mask(pattern.lane_mask());
        ([x + self.corner[0], y + self.corner[1]], inside)
    }

    /// Of a sample's two places along an axis, the one that is not before the box.
    #[inline(always)]
    fn place<L: Lanes>(&self, l: L, offset: L::I, axis: usize) -> L::I {
        let before = offset.lt(l.splat_i(self.extent[axis]));
        before.select_i(offset + SUBPIXELS, offset)
    }

    /// With one sample a pixel: true if no sample lies in the box.
    #[inline(always)]
    fn is_between_samples(&self) -> bool {
        self.extent[0] <= 0 || self.extent[1] <= 0
    }

    /// With one sample a pixel: the place of the only sample in the box, and whether it is covered; `None` if there are
    /// several.
    #[inline(always)]
    #[must_use]
    pub fn only_sample(&self, pattern: &SamplePattern) -> Option<([i32; 2], bool)> {
        if pattern.single().is_none() || self.extent[0] > 1 || self.extent[1] > 1 {
            return None;
        }
        let [e, f, g] = self.edges;
        Some((self.corner, !self.is_between_samples() && (e[2] | f[2] | g[2]) >= 0))
    }

    /// True if it covers no sample.
    #[inline(always)]
    #[must_use]
    pub fn misses_all_samples<L: Lanes>(&self, l: L, pattern: &SamplePattern) -> bool {
        if pattern.single().is_some() && self.is_between_samples() {
            return true;
        }
        match self.only_sample(pattern) {
            Some((_, covered)) => !covered,
            None => !self.samples(l, pattern).1.any(),
        }
    }
}

/// Depth of points relative to a triangle's vertex 0, in sub-pixels: the operations of the lanes of a block, in their
/// order, so that it does not show which path a triangle took.
#[inline(always)]
pub(super) fn depth_at<F: Float>(triangle: &Triangle, [x, y]: [F; 2]) -> F {
    let [smallest, largest] = triangle.depth_range();
    let depth = x * triangle.depth_gradient[0] + triangle.depth[0] + y * triangle.depth_gradient[1];
    depth.at_least(smallest).at_most(largest)
}
