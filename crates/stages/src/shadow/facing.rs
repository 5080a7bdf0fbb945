//! Sides that triangles show a direction: on a map that is seen along one, triangles that block light from one side and show it
//! the other need not be brought to the map, and neighbours mostly show the same.

use super::depth_map::DepthMap;
use super::draw::THINNEST;
use super::slab::Sixteen;
use overcoat_core::each;
use overcoat_core::math::lanes::{Float, LANES, Lanes, Mask};

/// Doubt about a side, in [`THINNEST`]: the map finds the sides of triangles that are nearly as thin by corners that were rounded.
const DOUBT: f32 = 2.0;

/// Sides of sixteen triangles.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(super) struct Facing {
    /// Cross products of the two edges from the first corner.
    normals: [[f32; LANES]; 3],
    /// Bound of the sum of these edges' lengths.
    lengths: [f32; LANES],
}

impl Default for Facing {
    fn default() -> Self {
        Self { normals: [[0.0; LANES]; 3], lengths: [0.0; LANES] }
    }
}

/// A direction that sides are shown to.
#[derive(Clone, Copy)]
pub(super) struct Viewed {
    /// Turns normals into twice the area on the map, positive where fronts are seen.
    area: [f32; 3],
    /// Turns lengths into the area that leaves no doubt.
    doubt: f32,
}

impl Facing {
    /// Sides of triangles with these corners.
    #[inline(always)]
    pub(super) fn of(Sixteen(c): &Sixteen) -> Self {
        let mut of = Self::default();
        let [mut a, mut b] = [[[0.0; LANES]; 3]; 2];
        for axis in 0..3 {
            for k in 0..LANES {
                a[axis][k] = c[3 + axis][k] - c[axis][k];
                b[axis][k] = c[6 + axis][k] - c[axis][k];
                of.lengths[k] += a[axis][k].abs() + b[axis][k].abs();
            }
        }
        for (axis, normals) in of.normals.iter_mut().enumerate() {
            let [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
            for (k, normal) in normals.iter_mut().enumerate() {
                *normal = a[u][k] * b[v][k] - a[v][k] * b[u][k];
            }
        }
        of
    }

    /// True if all of them show a direction their back beyond doubt, or nothing at all.
    #[inline(always)]
    pub(super) fn all_show_back<L: Lanes>(&self, l: L, viewed: &Viewed) -> bool {
        let [x, y, z]: [L::F; 3] = each!(normals in self.normals => l.load(&normals));
        let area = (x * viewed.area[0] + y * viewed.area[1]) + z * viewed.area[2];
        area.le(l.load(&self.lengths) * -viewed.doubt).all()
    }
}

/// [`Facing::all_show_back`]; false where it is not known.
#[inline(always)]
pub(super) fn all_show_back<L: Lanes>(l: L, facing: Option<&Facing>, viewed: Option<&Viewed>) -> bool {
    match (facing, viewed) {
        (Some(facing), Some(viewed)) => facing.all_show_back(l, viewed),
        _ => false,
    }
}

impl Viewed {
    /// The direction that a map looks along; `None` of one that is seen from a point.
    pub(super) fn by(frame: &DepthMap) -> Option<Self> {
        let [x, y, _] = frame.rows;
        let cross = |u: usize, v: usize| (x[u] * y[v] - x[v] * y[u]) * frame.front;
        let length = |row: [f32; 4]| (row[0].abs() + row[1].abs()) + row[2].abs();
        (frame.near == 0.0).then(|| Self {
            area: [cross(1, 2), cross(2, 0), cross(0, 1)],
            doubt: (length(x) + length(y)) * (THINNEST * DOUBT),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::draw::{Sides, draw_solid};
    use super::*;
    use overcoat_core::math::lanes::Scalar;

    /// Triangles that show their back draw nothing.
    #[test]
    fn backs_would_draw_nothing() {
        const SIZE: usize = 96;
        let mut state = 3_u32;
        let mut number = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32 / (1 << 23) as f32 - 1.0
        };
        let (mut backs, mut fronts) = (0, 0);
        for turn in 0..2000 {
            let towards = [number(), number(), number()];
            let length = towards.iter().map(|c| c * c).sum::<f32>().sqrt();
            let frame = DepthMap::new(towards.map(|c| c / length), [0.0; 3], 2.0, SIZE);
            // Neighbours of one normal, some of them seen nearly from the side.
            let [u, v] = [(); 2].map(|()| [number(), number(), number()]);
            let size = [0.01, 0.2, 1.0][turn % 3];
            let mut sixteen = Sixteen([[0.0; LANES]; 9]);
            for k in 0..LANES - turn % 2 {
                let first = [number() * 0.5, number() * 0.5, number() * 0.5];
                for axis in 0..3 {
                    sixteen.0[axis][k] = first[axis];
                    sixteen.0[3 + axis][k] = first[axis] + u[axis] * size;
                    sixteen.0[6 + axis][k] = first[axis] + (v[axis] + number() * 0.1) * size;
                }
            }
            let mut map = vec![0; SIZE * SIZE];
            draw_solid(Scalar, &frame, (&sixteen, Sides::Front), SIZE, &mut map);
            let is_empty = map.iter().all(|texel| *texel == 0);
            let viewed = Viewed::by(&frame).expect("a direction");
            if Facing::of(&sixteen).all_show_back(Scalar, &viewed) {
                assert!(is_empty, "turn {turn}");
                backs += 1;
            } else {
                fronts += 1;
            }
        }
        assert!(backs > 600 && fronts > 600, "{backs} and {fronts}");
    }
}
