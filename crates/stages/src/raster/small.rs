//! Triangles so small that a few samples decide whether they are seen: most triangles of dense meshes.

use super::{SUBPIXEL_BITS, SUBPIXELS, SamplePattern, TileOrigin, Triangle};
use overcoat_core::each;
use overcoat_core::math::lanes::{Int, LANES, Lanes, Mask};

/// Sides of a box, in sub-pixels, below which products of differences fit the lanes: 128 pixels.
const EXACT: i32 = 1 << 15;

/// The outlines of sixteen triangles, one a lane: most triangles of dense meshes get no further than this.
///
/// A triangle is *small* if few places of samples can lie in its box:
///
/// * With one sample a pixel, a box below four pixels: at most 4 x 4 places.
/// * With several, a box below two pixels: at most 2 x 2 places for each sample.
///
/// Either way 64 bits say exactly what is covered, by the fill rule of [`EdgeFunctions`](super::EdgeFunctions).
/// [`SmallSamples`] are their places.
#[derive(Clone, Copy, Debug)]
pub struct OutlineLanes<L: Lanes> {
    /// Vertices in the order of positive area.
    x: [L::I; 3],
    y: [L::I; 3],
    /// As [`Triangle::bounds`].
    pub bounds: [L::I; 4],
    /// As [`Triangle::is_swapped`].
    pub swapped: L::M,
    /// Triangles below 128 pixels. Of others only the bounds hold.
    pub exact: L::M,
    /// Triangles that have an area.
    pub has_area: L::M,
}

impl<L: Lanes> OutlineLanes<L> {
    /// The outlines of snapped vertices (x and y of each) in the mesh's order.
    #[inline(always)]
    #[must_use]
    pub fn new(l: L, [[ax, ay], [bx, by], [cx, cy]]: [[L::I; 2]; 3]) -> Self {
        let bounds = [ax.min(bx).min(cx), ay.min(by).min(cy), ax.max(bx).max(cx), ay.max(by).max(cy)];
        let side = l.splat_i(EXACT);
        let exact = (bounds[2] - bounds[0]).lt(side) & (bounds[3] - bounds[1]).lt(side);
        // Below 2^15 * 2^15 * 2.
        let area = (bx - ax) * (cy - ay) - (cx - ax) * (by - ay);
        let swapped = area.lt(l.splat_i(0));
        Self {
            x: [ax, swapped.select_i(cx, bx), swapped.select_i(bx, cx)],
            y: [ay, swapped.select_i(cy, by), swapped.select_i(by, cy)],
            bounds,
            swapped,
            exact,
            has_area: !area.eq(l.splat_i(0)),
        }
    }

    /// The small ones among the triangles of `of`, which must be exact, and the samples that each covers: none of others.
    /// `origin` is the corner of some pixel, no farther than the guard band.
    #[inline(always)]
    #[must_use]
    pub fn small(&self, l: L, of: L::M, origin: TileOrigin, pattern: &SamplePattern) -> SmallLanes<L> {
        let none = l.splat_i(0);
        let side = l.splat_i(small_side(pattern));
        let [left, top, right, bottom] = self.bounds;
        let which = of & (right - left).lt(side) & (bottom - top).lt(side);
        if !which.any() {
            return SmallLanes { which, covered: [none; 4] };
        }
        let low = [left - origin.x, top - origin.y];
        let high = [right - origin.x, bottom - origin.y];
        let covered = match pattern.single() {
            Some(offset) => [self.covered_pixels(l, which, low, high, offset, origin), none, none, none],
            None => self.covered_samples(l, which, low, high, pattern, origin),
        };
        SmallLanes { which, covered }
    }

    /// With one sample a pixel: row by row of the places in the box.
    #[inline(always)]
    fn covered_pixels(
        &self,
        l: L,
        small: L::M,
        low: [L::I; 2],
        high: [L::I; 2],
        offset: [i32; 2],
        origin: TileOrigin,
    ) -> L::I {
        let none = l.splat_i(0);
        let mut covered = none;
        let first: [L::I; 2] = each!(k => first_place(low[k], offset[k]));
        let count: [L::I; 2] = each!(k => (high[k] - first[k] + SUBPIXELS).shr(SUBPIXEL_BITS));
        let edges = self.edges(l, first, origin);
        for row in 0..4 {
            let in_row = small & l.splat_i(row).lt(count[1]);
            if !in_row.any() {
                break;
            }
            for column in 0..4 {
                let here = in_row & l.splat_i(column).lt(count[0]);
                if !here.any() {
                    break;
                }
                let values: [L::I; 3] = each!(edge in edges =>
                    edge[2] + edge[0] * (column * SUBPIXELS) + edge[1] * (row * SUBPIXELS));
                let inside = here & all_inside(values);
                covered = covered | inside.select_i(l.splat_i(1 << (4 * row + column)), none);
            }
        }
        covered
    }

    /// With several samples: sample by sample the first places that are not before the box, and their neighbours.
    #[inline(always)]
    fn covered_samples(
        &self,
        l: L,
        small: L::M,
        low: [L::I; 2],
        high: [L::I; 2],
        pattern: &SamplePattern,
        origin: TileOrigin,
    ) -> [L::I; 4] {
        let none = l.splat_i(0);
        let mut covered = [none; 4];
        let corner: [L::I; 2] = each!(k => low[k] & !(SUBPIXELS - 1));
        let first: [L::I; 2] = each!(k => low[k] - corner[k]);
        let edges = self.edges(l, corner, origin);
        let beyond: [bool; 2] = each!(k => (small & !(high[k] - low[k]).lt(l.splat_i(SUBPIXELS))).any());
        for (sample, offset) in pattern.offsets().iter().enumerate() {
            let [x, y]: [L::I; 2] = each!(k => first_place(first[k], offset[k]));
            let bit = l.splat_i(1 << sample);
            let values: [L::I; 3] = each!(edge in edges => edge[0] * x + edge[1] * y + edge[2]);
            for (place, covered) in covered.iter_mut().enumerate() {
                let step = [(place & 1) as i32, (place >> 1) as i32];
                if (step[0] > 0 && !beyond[0]) || (step[1] > 0 && !beyond[1]) {
                    continue;
                }
                let there: [L::I; 3] = each!(k =>
                    values[k] + edges[k][0] * (step[0] * SUBPIXELS) + edges[k][1] * (step[1] * SUBPIXELS));
                let inside = small & all_inside(there);
                *covered = *covered | inside.select_i(bit, none);
            }
        }
        covered
    }

    /// For each edge, A, B and the constant at `corner`, biased by the fill rule. Exact for small triangles.
    #[inline(always)]
    fn edges(&self, l: L, corner: [L::I; 2], origin: TileOrigin) -> [[L::I; 3]; 3] {
        let (zero, biased) = (l.splat_i(0), l.splat_i(-1));
        let [corner_x, corner_y] = [corner[0] + origin.x, corner[1] + origin.y];
        each!(k => {
            let next = if k == 2 { 0 } else { k + 1 };
            let (a, b) = (self.y[k] - self.y[next], self.x[next] - self.x[k]);
            let owns = zero.lt(a) | (a.eq(zero) & zero.lt(b));
            // Below 2^10 * 2^11 * 2.
            let constant = a * (corner_x - self.x[k]) + b * (corner_y - self.y[k]);
            [a, b, constant + owns.select_i(zero, biased)]
        })
    }
}

/// The small ones of sixteen triangles.
#[derive(Clone, Copy, Debug)]
pub struct SmallLanes<L: Lanes> {
    /// Mask of the small ones.
    pub which: L::M,
    /// Coverage, sixteen bits in each part. With one sample a pixel: the pixels of the box, row by row, in the first
    /// part. With several: the samples of the first pixel, of its right neighbour, and of the two below.
    covered: [L::I; 4],
}

impl<L: Lanes> SmallLanes<L> {
    /// Mask of small triangles that cover no sample.
    #[inline(always)]
    #[must_use]
    pub fn misses(&self, l: L) -> L::M {
        let [a, b, c, d] = self.covered;
        self.which & (a | b | c | d).eq(l.splat_i(0))
    }

    /// Coverage of every lane, in four parts of sixteen bits. See [`Triangle::small_samples`].
    #[inline(always)]
    #[must_use]
    pub fn to_arrays(&self) -> [[i32; LANES]; 4] {
        each!(part in self.covered => part.to_array())
    }
}

/// Limit in sub-pixels below which the sides of a box are those of a small triangle.
#[inline(always)]
fn small_side(pattern: &SamplePattern) -> i32 {
    if pattern.single().is_some() { 4 * SUBPIXELS } else { 2 * SUBPIXELS }
}

/// The first place of a sample at `offset` that is not before `low`.
#[inline(always)]
fn first_place<I>(low: I, offset: i32) -> I
where
    I: std::ops::Add<i32, Output = I> + std::ops::Sub<i32, Output = I> + std::ops::BitAnd<i32, Output = I>,
{
    ((low - offset + (SUBPIXELS - 1)) & !(SUBPIXELS - 1)) + offset
}

/// The places of the samples that a small triangle covers.
#[derive(Clone, Copy, Debug)]
pub struct SmallSamples {
    /// The corner of the triangle's box, relative to the origin, in sub-pixels.
    low: [i32; 2],
    /// Bits of the samples that are left.
    left: u64,
}

impl SmallSamples {
    /// Samples of a triangle, relative to a pixel's corner; `None` if it is not known to be small.
    #[inline(always)]
    #[must_use]
    pub fn new(triangle: &Triangle, origin: TileOrigin) -> Option<Self> {
        if triangle.small_samples == 0 {
            return None;
        }
        let [left, top, ..] = triangle.bounds();
        Some(Self { low: [left - origin.x, top - origin.y], left: triangle.small_samples })
    }

    /// The next one: which sample of its pixel, and its place relative to the origin in sub-pixels.
    #[inline(always)]
    pub fn next(&mut self, pattern: &SamplePattern) -> Option<(usize, [i32; 2])> {
        if self.left == 0 {
            return None;
        }
        let bit = self.left.trailing_zeros() as usize;
        self.left &= self.left - 1;
        let (part, within) = (bit / 16, bit % 16);
        let (sample, step) = match pattern.single() {
            Some(_) => (0, [within & 3, within >> 2]),
            None => (within, [part & 1, part >> 1]),
        };
        let offset = pattern.offsets()[sample];
        Some((sample, each!(k => first_place(self.low[k], offset[k]) + step[k] as i32 * SUBPIXELS)))
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
            ((bounds[2] - origin.x - corner[0]) >> SUBPIXEL_BITS) + 1,
            ((bounds[3] - origin.y - corner[1]) >> SUBPIXEL_BITS) + 1,
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
        let samples = l.mask(pattern.full_mask());
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
