//! Thin long triangles into depth maps, sixteen at a time: a fan of fifty thousand has as many boxes of thousands of texels, and
//! a texel's centre in one of four.
//!
//! Along its longer side, a sliver is a line that is less than a texel wide. Only centres beside that line are looked at; which
//! of them are covered is asked as of all other triangles (`draw.rs`), so that no texel depends on the way it was found.

use super::draw::{depth_inside, keep_outermost, weights};
use overcoat_core::each;
use overcoat_core::math::lanes::{Float, Lanes, Mask};

/// Texels that a sliver is wide at most, measured across its longer side along a row or a column.
const WIDEST: f32 = 1.0;

/// Texels beside the line within which rounding may put a centre on a sliver, or its edge on a centre: coordinates below
/// [`FURTHEST`] are right to 2^-10, the line to 2^-8, and the products that decide to 2^-8.
const ROUNDING: f32 = 1.0 / 32.0;

/// Largest coordinate, in texels, of triangles that are drawn as slivers.
const FURTHEST: f32 = 16384.0;

/// Sixteen triangles as lines along the axis that they are longer in.
pub(super) struct Slivers<L: Lanes> {
    /// Mask of the triangles that are slivers.
    pub which: L::M,
    /// Mask of the triangles that are longer in rows than in columns.
    tall: L::M,
    /// First and last step along the longer axis.
    first: L::F,
    end: L::F,
    /// A point of the line: along the axis, and across.
    start: [L::F; 2],
    slope: L::F,
    /// Half the width that is looked at.
    reach: L::F,
    /// First and last texel across.
    across: [L::F; 2],
}

impl<L: Lanes> Slivers<L> {
    /// Finds slivers among triangles whose texels lie from `first` to `end` (columns, rows).
    #[inline(always)]
    pub(super) fn find(l: L, [x, y]: &[[L::F; 3]; 2], first: [L::F; 2], end: [L::F; 2]) -> Self {
        let [width, height] = each!(c in [x, y] => c[0].max(c[1]).max(c[2]) - c[0].min(c[1]).min(c[2]));
        let tall = width.le(height);
        let along: [L::F; 3] = each!(k => tall.select(y[k], x[k]));
        let across: [L::F; 3] = each!(k => tall.select(x[k], y[k]));
        let length = tall.select(height, width);
        // The line runs from the corner where the axis begins to the one where it ends.
        let low = along[0].min(along[1]).min(along[2]);
        let high = along[0].max(along[1]).max(along[2]);
        let [from, to] = each!(end in [low, high] => {
            along[0].eq(end).select(across[0], along[1].eq(end).select(across[1], across[2]))
        });
        let double_area = (x[1] - x[0]) * (y[2] - y[0]) - (x[2] - x[0]) * (y[1] - y[0]);
        let wide = double_area.abs() / length;
        let largest = each!(c in [x, y] => c[0].abs().max(c[1].abs()).max(c[2].abs()));
        let is_near = largest[0].max(largest[1]).lt(l.splat(FURTHEST));
        Self {
            which: wide.lt(l.splat(WIDEST)) & is_near,
            tall,
            first: tall.select(first[1], first[0]),
            end: tall.select(end[1], end[0]),
            start: [low, from],
            slope: (to - from) / length,
            reach: wide + ROUNDING,
            across: [tall.select(first[0], first[1]), tall.select(end[0], end[1])],
        }
    }

    /// Draws slivers of `x`, `y` and `z`, those of `some`, and counts the sixteens of texels that it looks at.
    #[inline(always)]
    pub(super) fn draw(&self, [x, y, z]: &[[L::F; 3]; 3], some: L::M, size: usize, map: &mut [u32]) -> u64 {
        let mut work = 0;
        let mut step = self.first;
        loop {
            let on_line = some & step.le(self.end);
            if !on_line.any() {
                return work;
            }
            work += 1;
            let middle = self.start[1] + (step - self.start[0]) * self.slope;
            let last = (middle + self.reach).min(self.across[1]);
            // The smallest integer not below.
            let mut place = (-(self.reach - middle).floor()).max(self.across[0]);
            loop {
                let present = on_line & place.le(last);
                if !present.any() {
                    break;
                }
                work += 1;
                let column = self.tall.select(place, step);
                let row = self.tall.select(step, place);
                let dx: [L::F; 3] = each!(c in *x => c - column);
                let dy: [L::F; 3] = each!(c in *y => c - row);
                let (inside, depth) = depth_inside(weights(dx, dy), z);
                keep_outermost::<L>(inside & present, [column, row], depth, size, map);
                place = place + 1.0;
            }
            step = step + 1.0;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::depth_map::DepthMap;
    use super::super::draw::{Sides, draw_solid};
    use super::super::slab::Sixteen;
    use super::*;
    use overcoat_core::math::lanes::{LANES, Scalar};

    const SIZE: usize = 96;

    /// All texels of a map that triangles cover, found one by one.
    fn one_by_one(sixteen: &Sixteen) -> Vec<u32> {
        let mut map = vec![0; SIZE * SIZE];
        let l = Scalar;
        let corners: [[<Scalar as Lanes>::F; 3]; 3] = each!(k => each!(c => l.load(&sixteen.0[3 * k + c])));
        let [a, b, c] = corners;
        let (x, y, z) = ([a[0], b[0], c[0]], [a[1], b[1], c[1]], [a[2], b[2], c[2]]);
        for row in 0..SIZE {
            for column in 0..SIZE {
                let place = [column as f32, row as f32];
                let dx: [<Scalar as Lanes>::F; 3] = each!(v in x => v - place[0]);
                let dy: [<Scalar as Lanes>::F; 3] = each!(v in y => v - place[1]);
                // Rounding puts centres beside a line on it, but none beyond its ends.
                let beside = |v: [<Scalar as Lanes>::F; 3], at: f32| {
                    let at = l.splat(at);
                    v[0].min(v[1]).min(v[2]).le(at) & v[0].max(v[1]).max(v[2]).ge(at)
                };
                let (inside, depth) = depth_inside(weights(dx, dy), &z);
                let which = inside & beside(x, place[0]) & beside(y, place[1]);
                keep_outermost::<Scalar>(which, place.map(|c| l.splat(c)), depth, SIZE, &mut map);
            }
        }
        map
    }

    /// A sliver covers the texels that it covers when all of them are looked at, with the same depths.
    #[test]
    fn no_texel_of_a_sliver_is_missed() {
        let frame = DepthMap {
            rows: [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]],
            near: 0.0,
            front: 1.0,
        };
        let mut state = 7_u32;
        let mut number = |least: f32, most: f32| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            least + (most - least) * ((state >> 8) as f32 / (1 << 24) as f32)
        };
        let mut covered = 0;
        for turn in 0..400 {
            let mut sixteen = Sixteen([[0.0; LANES]; 9]);
            // Within the map, and far over its border.
            let reach = if turn % 4 == 3 { 9000.0 } else { 60.0 };
            for lane in 0..LANES {
                let [x, y] = [(); 2].map(|()| number(0.0, SIZE as f32));
                let [dx, dy] = [(); 2].map(|()| number(-reach, reach));
                // On whole numbers too, where centres lie on edges.
                let whole = turn % 3 == 0;
                let wide = [0.0, 1e-5, 0.01, 0.5, 1.2][turn % 5];
                let part = number(0.0, 1.0);
                let corners = [
                    [x, y],
                    [x + dx, y + dy],
                    [x + part * dx + number(-wide, wide), y + part * dy + number(-wide, wide)],
                ];
                for (corner, place) in corners.iter().enumerate() {
                    let place = if whole { place.map(f32::round) } else { *place };
                    sixteen.0[3 * corner][lane] = place[0];
                    sixteen.0[3 * corner + 1][lane] = place[1];
                    sixteen.0[3 * corner + 2][lane] = number(2.0, 60_000.0);
                }
            }
            let mut found = vec![0; SIZE * SIZE];
            let work = draw_solid(Scalar, &frame, (&sixteen, Sides::Both), SIZE, &mut found);
            let expected = one_by_one(&sixteen);
            covered += expected.iter().filter(|texel| **texel != 0).count();
            assert!(found == expected, "turn {turn}");
            // Boxes of 60 x 60 texels took up to 240 sixteens each.
            assert!(turn % 5 == 4 || reach > 100.0 || work < 16 * 60, "turn {turn}: {work}");
        }
        assert!(covered > 10_000, "{covered}");
    }
}
