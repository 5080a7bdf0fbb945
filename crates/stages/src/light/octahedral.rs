//! The octahedral map: the sphere of directions unfolded onto a square.
//!
//! A direction is projected onto the octahedron |x| + |y| + |z| = 1, whose upper half lies over the square
//! |x| + |z| <= 1 and whose lower half is folded out into the corners (Engelhardt and Dachsbacher 2008, "Octahedron
//! environment maps"). No table, no face selection: sixteen directions cost some twenty instructions.
//!
//! Samples sit on the corners of a grid of `size` x `size`, size = 2^k + 1: the first and the last column hold the
//! same directions mirrored, so bilinear interpolation between samples is continuous over the whole sphere without
//! a border, and every second sample of a level is a sample of the next.

use overcoat_core::math::lanes::{Float, Int, LANES, Lanes, Mask, Scalar};
use overcoat_core::math::vec3::{V3, Vec3};

/// `magnitude` with the sign of `sign`; `magnitude` is not negative.
#[inline(always)]
fn with_sign<L: Lanes>(_: L, magnitude: L::F, sign: L::F) -> L::F {
    (magnitude.bits() | (sign.bits() & i32::MIN)).float_from_bits()
}

/// Octahedral coordinates of a direction of any length, both in -1 to 1. The centre is +Y, the edges' midpoints are +-X
/// and +-Z, the corners -Y. The zero vector maps to the centre; a NaN stays one.
#[inline(always)]
pub(crate) fn encode<L: Lanes>(l: L, direction: V3<L>) -> [L::F; 2] {
    let Vec3 { x, y, z } = direction;
    let scale = (x.abs() + y.abs() + z.abs()).at_least(f32::MIN_POSITIVE).recip();
    let (x, z) = (x * scale, z * scale);
    let lower = y.lt(l.zero());
    let folded_x = with_sign(l, z.abs().one_minus().at_least(0.0), x);
    let folded_z = with_sign(l, x.abs().one_minus().at_least(0.0), z);
    [lower.select(folded_x, x), lower.select(folded_z, z)]
}

/// The point of the octahedron over the square's point (`u`, `v`), both in -1 to 1: the direction, not of unit
/// length.
#[inline(always)]
pub(crate) fn decode<L: Lanes>(l: L, u: L::F, v: L::F) -> V3<L> {
    let y = u.abs().one_minus() - v.abs();
    let fold = (-y).at_least(0.0);
    let x = u - with_sign(l, fold, u);
    let z = v - with_sign(l, fold, v);
    Vec3::new(x, y, z)
}

/// Octahedral coordinates of sixteen samples of a grid, in row-major order from `first` on. Samples past the end repeat
/// the last one.
#[inline(always)]
pub(crate) fn positions<L: Lanes>(l: L, size: usize, first: usize) -> (L::F, L::F) {
    let mut u = [0.0; LANES];
    let mut v = [0.0; LANES];
    let step = 2.0 / (size - 1) as f32;
    for k in 0..LANES {
        let index = (first + k).min(size * size - 1);
        u[k] = (index % size) as f32 * step - 1.0;
        v[k] = (index / size) as f32 * step - 1.0;
    }
    (l.load(&u), l.load(&v))
}

/// The unit direction at a point of the square and the solid angle per area there, up to a constant: 1 / r^3 of the
/// octahedron's point.
#[inline(always)]
pub(crate) fn directions<L: Lanes>(l: L, u: L::F, v: L::F) -> (V3<L>, L::F) {
    let point = decode(l, u, v);
    let inverse = point.dot(point).sqrt().recip();
    (point * inverse, inverse * inverse * inverse)
}

/// The unit direction of one sample of a grid.
pub(crate) fn direction(size: usize, index: usize) -> [f32; 3] {
    let (u, v) = positions(Scalar, size, index);
    directions(Scalar, u, v).0.lane(0)
}

/// Share of a grid cell that belongs to the sample in column `x` of row `y`: the edges are shared by two samples
/// and the corners by four.
pub(crate) fn cell_share(size: usize, x: usize, y: usize) -> f32 {
    let edge = |k: usize| if k == 0 || k == size - 1 { 0.5 } else { 1.0 };
    edge(x) * edge(y)
}

/// The sample at a column and row up to one grid step outside, seen over the fold: the same direction inside.
pub(crate) fn wrap(size: usize, x: isize, y: isize) -> usize {
    let last = size as isize - 1;
    let (mut x, mut y) = (x, y);
    if x < 0 || x > last {
        x = if x < 0 { -x } else { 2 * last - x };
        y = last - y;
    }
    if y < 0 || y > last {
        y = if y < 0 { -y } else { 2 * last - y };
        x = last - x;
    }
    (y * last + y + x) as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    fn encode_one(d: [f32; 3]) -> [f32; 2] {
        encode(Scalar, Vec3::splat(Scalar, d)).map(|c| c.to_array()[0])
    }

    fn decode_one(u: f32, v: f32) -> [f32; 3] {
        directions(Scalar, Scalar.splat(u), Scalar.splat(v)).0.lane(0)
    }

    #[test]
    fn axes_lie_where_the_map_says() {
        assert_eq!(encode_one([0.0, 2.0, 0.0]), [0.0, 0.0]);
        assert_eq!(encode_one([3.0, 0.0, 0.0]), [1.0, 0.0]);
        assert_eq!(encode_one([-1.0, 0.0, 0.0]), [-1.0, 0.0]);
        assert_eq!(encode_one([0.0, 0.0, 0.5]), [0.0, 1.0]);
        assert_eq!(encode_one([0.0, 0.0, -1.0]), [0.0, -1.0]);
        assert_eq!(encode_one([0.0, -1.0, 0.0]).map(f32::abs), [1.0, 1.0]);
    }

    #[test]
    fn decoding_undoes_encoding() {
        // k = 0 would be a corner, where -Y has four places.
        for k in 1..20_000_u32 {
            let hash = |m: u32| (k.wrapping_mul(m) >> 8) as f32 / 8_388_608.0 - 1.0;
            let (u, v) = (hash(2_654_435_761), hash(2_246_822_519));
            let [u2, v2] = encode_one(decode_one(u, v));
            assert!((u - u2).abs() < 1e-6 && (v - v2).abs() < 1e-6, "{u} {v} -> {u2} {v2}");
        }
    }

    #[test]
    fn samples_outside_are_the_same_directions_inside() {
        let size = 9;
        let step = 2.0 / (size - 1) as f32;
        // The border itself is mirrored; the sample beyond it has the direction of the sample before it.
        for k in 0..size {
            let t = k as f32 * step - 1.0;
            for (a, b) in [([-1.0, t], [-1.0, -t]), ([t, 1.0], [-t, 1.0])] {
                let (a, b) = (decode_one(a[0], a[1]), decode_one(b[0], b[1]));
                assert!((0..3).all(|c| (a[c] - b[c]).abs() < 1e-6), "{a:?} {b:?}");
            }
        }
        assert_eq!(wrap(size, -1, 3), 5 * size + 1);
        assert_eq!(wrap(size, 9, 3), 5 * size + 7);
        assert_eq!(wrap(size, 2, -1), size + 6);
        assert_eq!(wrap(size, -1, -1), 7 * size + 7);
        assert_eq!(wrap(size, 4, 4), 4 * size + 4);
    }

    #[test]
    fn solid_angles_add_up_to_the_sphere() {
        let size = 65;
        let mut sum = 0.0_f64;
        for index in 0..size * size {
            let (u, v) = positions(Scalar, size, index);
            let (_, density) = directions(Scalar, u, v);
            let share = cell_share(size, index % size, index / size);
            sum += f64::from(density.to_array()[0] * share);
        }
        let cell = 2.0 / (size - 1) as f64;
        let error = sum * cell * cell / (4.0 * std::f64::consts::PI) - 1.0;
        assert!(error.abs() < 2e-3, "{error}");
    }
}
