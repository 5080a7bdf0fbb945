//! Triangles so small that one vector holds every sample that they may cover: most triangles of dense meshes.

use super::{SUBPIXELS, SamplePattern, TileOrigin, Triangle};
use crate::each;
use crate::math::lanes::{Int, Lanes, Mask};

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
            edges[k] = edge(x, y, k, corner, origin);
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
        let values: [L::I; 3] = each!(edge in self.edges => x * edge[0] + y * edge[1] + edge[2]);
        let inside = all_inside(values) & l.mask(pattern.lane_mask());
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

/// A triangle that touches few pixels of several samples: pixel by pixel, lanes are samples.
#[derive(Clone, Copy, Debug)]
pub struct FewPixels<L: Lanes> {
    /// Corner of the first pixel relative to the origin, in sub-pixels.
    corner: [i32; 2],
    /// Columns and rows of pixels.
    count: [i32; 2],
    /// For each edge, its change per pixel to the right and down, and its values at the samples of the first pixel.
    steps: [[i32; 2]; 3],
    values: [L::I; 3],
}

impl<L: Lanes> FewPixels<L> {
    /// The pixels of a triangle whose box is below three pixels; `None` if it is not.
    #[inline(always)]
    #[must_use]
    pub fn new(l: L, triangle: &Triangle, origin: TileOrigin, pattern: &SamplePattern) -> Option<Self> {
        const SIDE: i32 = 3 * SUBPIXELS;
        let bounds = triangle.bounds();
        if bounds[2] - bounds[0] >= SIDE || bounds[3] - bounds[1] >= SIDE || pattern.single().is_some() {
            return None;
        }
        let corner = [(bounds[0] - origin.x) & !(SUBPIXELS - 1), (bounds[1] - origin.y) & !(SUBPIXELS - 1)];
        let count = [
            ((bounds[2] - origin.x - corner[0]) >> super::SUBPIXEL_BITS) + 1,
            ((bounds[3] - origin.y - corner[1]) >> super::SUBPIXEL_BITS) + 1,
        ];
        let [x, y] = pattern.offset_lanes();
        let (x, y) = (l.load_i(x), l.load_i(y));
        let (mut steps, mut values) = ([[0; 2]; 3], [x; 3]);
        for k in 0..3 {
            let [a, b, c] = edge(triangle.x, triangle.y, k, corner, origin);
            steps[k] = [a * SUBPIXELS, b * SUBPIXELS];
            values[k] = x * a + y * b + c;
        }
        Some(Self { corner, count, steps, values })
    }

    /// Calls `f` with the corner of each pixel of which samples are covered, relative to the origin in sub-pixels, and
    /// those samples.
    #[inline(always)]
    pub fn for_each(&self, l: L, pattern: &SamplePattern, mut f: impl FnMut([i32; 2], u16)) {
        let samples = l.mask(pattern.lane_mask());
        for row in 0..self.count[1] {
            for column in 0..self.count[0] {
                let values: [L::I; 3] =
                    each!(k => self.values[k] + (self.steps[k][0] * column + self.steps[k][1] * row));
                let inside = (all_inside(values) & samples).bits();
                if inside != 0 {
                    f([self.corner[0] + column * SUBPIXELS, self.corner[1] + row * SUBPIXELS], inside);
                }
            }
        }
    }
}

/// The lanes in which the values of all edges are on the inner side.
#[inline(always)]
fn all_inside<I: Int>([e, f, g]: [I; 3]) -> I::M {
    (e | f | g).non_negative()
}

/// A, B and the constant at `corner` of edge k, biased by the fill rule.
#[inline(always)]
fn edge(x: [i32; 3], y: [i32; 3], k: usize, corner: [i32; 2], origin: TileOrigin) -> [i32; 3] {
    let next = if k == 2 { 0 } else { k + 1 };
    let (a, b) = (y[k] - y[next], x[next] - x[k]);
    let bias = if a > 0 || (a == 0 && b > 0) { 0 } else { -1 };
    // Below 2^10 * 2^11 * 2.
    let (to_x, to_y) = (corner[0] + origin.x - x[k], corner[1] + origin.y - y[k]);
    [a, b, a * to_x + b * to_y + bias]
}
