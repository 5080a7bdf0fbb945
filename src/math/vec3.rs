//! Vectors of three lane numbers, with a fixed order of operations.

use super::lanes::{Float, Lanes, Mask};

/// Three numbers a lane: a point, a direction or a linear colour.
pub type V3<L> = [<L as Lanes>::F; 3];

/// The same vector in every lane.
#[inline(always)]
pub fn splat<L: Lanes>(l: L, v: [f32; 3]) -> V3<L> {
    [l.splat(v[0]), l.splat(v[1]), l.splat(v[2])]
}

/// `f` of every component. Mark the closure `#[inline(always)]`.
///
/// Not `array::map`: the standard library's is compiled for the least instruction set and called, which makes
/// lane arithmetic inside several times slower.
#[inline(always)]
pub fn map<L: Lanes>(_: L, v: V3<L>, f: impl Fn(L::F) -> L::F) -> V3<L> {
    [f(v[0]), f(v[1]), f(v[2])]
}

/// `[f(0), f(1), f(2)]`. Mark the closure `#[inline(always)]`; see [`map`].
#[inline(always)]
pub fn from_fn<L: Lanes>(_: L, f: impl Fn(usize) -> L::F) -> V3<L> {
    [f(0), f(1), f(2)]
}

/// `a + b`.
#[inline(always)]
pub fn add<L: Lanes>(_: L, a: V3<L>, b: V3<L>) -> V3<L> {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

/// `a - b`.
#[inline(always)]
pub fn sub<L: Lanes>(_: L, a: V3<L>, b: V3<L>) -> V3<L> {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// The product of components, as of colours.
#[inline(always)]
pub fn mul<L: Lanes>(_: L, a: V3<L>, b: V3<L>) -> V3<L> {
    [a[0] * b[0], a[1] * b[1], a[2] * b[2]]
}

/// `v * s`.
#[inline(always)]
pub fn scale<L: Lanes>(_: L, v: V3<L>, s: L::F) -> V3<L> {
    [v[0] * s, v[1] * s, v[2] * s]
}

/// `-v`.
#[inline(always)]
pub fn neg<L: Lanes>(_: L, v: V3<L>) -> V3<L> {
    [-v[0], -v[1], -v[2]]
}

/// `a + t * (b - a)`.
#[inline(always)]
pub fn lerp<L: Lanes>(_: L, a: V3<L>, b: V3<L>, t: L::F) -> V3<L> {
    [a[0].lerp(b[0], t), a[1].lerp(b[1], t), a[2].lerp(b[2], t)]
}

/// `(x x' + y y') + z z'`, in this order.
#[inline(always)]
pub fn dot<L: Lanes>(_: L, a: V3<L>, b: V3<L>) -> L::F {
    (a[0] * b[0] + a[1] * b[1]) + a[2] * b[2]
}

/// Right-handed cross product.
#[inline(always)]
pub fn cross<L: Lanes>(_: L, a: V3<L>, b: V3<L>) -> V3<L> {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Euclidean length.
#[inline(always)]
pub fn length<L: Lanes>(l: L, v: V3<L>) -> L::F {
    dot(l, v, v).sqrt()
}

/// `v` at length 1; a vector whose squared length is below the smallest normal number (1.2e-38) shrinks
/// towards zero instead, and zero stays zero. Components beyond 1.8e19 overflow.
///
/// The rule of Unity's `SafeNormalize`: v / sqrt(max(`FLT_MIN`, v.v)).
#[inline(always)]
pub fn normalize<L: Lanes>(l: L, v: V3<L>) -> V3<L> {
    let inverse = dot(l, v, v).at_least(f32::MIN_POSITIVE).sqrt().recip();
    scale(l, v, inverse)
}

/// [`normalize`] by three divisions, as GLSL defines it: v / length(v), components rounded once less. Half vectors of
/// models whose original is GLSL need the bits, because 1 - (N.H)^2 magnifies the last one near the mirror direction.
#[inline(always)]
pub fn divide_by_length<L: Lanes>(l: L, v: V3<L>) -> V3<L> {
    let length = dot(l, v, v).at_least(f32::MIN_POSITIVE).sqrt();
    [v[0] / length, v[1] / length, v[2] / length]
}

/// The incident direction i mirrored at the plane with normal n: i - 2 (n.i) n, both pointing as in HLSL
/// `reflect` (i towards the surface, the result away from it).
#[inline(always)]
pub fn reflect<L: Lanes>(l: L, i: V3<L>, n: V3<L>) -> V3<L> {
    let twice = dot(l, i, n) * 2.0;
    sub(l, i, scale(l, n, twice))
}

/// `yes` where the mask is true, `no` elsewhere.
#[inline(always)]
pub fn select<L: Lanes>(_: L, condition: L::M, yes: V3<L>, no: V3<L>) -> V3<L> {
    [condition.select(yes[0], no[0]), condition.select(yes[1], no[1]), condition.select(yes[2], no[2])]
}

/// The largest component.
#[inline(always)]
pub fn max_component<L: Lanes>(_: L, v: V3<L>) -> L::F {
    v[0].max(v[1]).max(v[2])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::lanes::Scalar;

    fn first(v: V3<Scalar>) -> [f32; 3] {
        v.map(|c| c.to_array()[0])
    }
    fn v(x: f32, y: f32, z: f32) -> V3<Scalar> {
        splat(Scalar, [x, y, z])
    }

    #[test]
    fn axes_are_right_handed() {
        assert_eq!(first(cross(Scalar, v(1.0, 0.0, 0.0), v(0.0, 1.0, 0.0))), [0.0, 0.0, 1.0]);
        assert_eq!(first(cross(Scalar, v(2.0, 3.0, 5.0), v(7.0, 11.0, 13.0))), [-16.0, 9.0, 1.0]);
    }

    #[test]
    fn normalize_keeps_zero_and_reaches_one() {
        assert_eq!(first(normalize(Scalar, v(0.0, 0.0, 0.0))), [0.0; 3]);
        assert_eq!(first(normalize(Scalar, v(3e-19, 0.0, 4e-19))), [0.6, 0.0, 0.8]);
        assert_eq!(first(normalize(Scalar, v(0.0, -7.0, 0.0))), [0.0, -1.0, 0.0]);
        assert_eq!(first(divide_by_length(Scalar, v(0.0, 0.0, 0.0))), [0.0; 3]);
        assert_eq!(first(divide_by_length(Scalar, v(0.0, 3.0, -4.0))), [0.0, 3.0 / 5.0, -4.0 / 5.0]);
        let tiny = first(normalize(Scalar, v(1e-25, 0.0, 0.0)));
        assert!(tiny[0] > 0.0 && tiny[0] < 1.0);
    }

    #[test]
    fn reflection_mirrors_at_the_plane() {
        assert_eq!(first(reflect(Scalar, v(0.6, 0.0, -0.8), v(0.0, 0.0, 1.0))), [0.6, 0.0, 0.8]);
    }

    #[test]
    fn dot_adds_x_and_y_before_z() {
        // 1e8 - 1e8 + 1 in this order is 1; in another it is 0.
        let sum = dot(Scalar, v(1e8, -1e8, 1.0), v(1.0, 1.0, 1.0)).to_array()[0];
        assert_eq!(sum, 1.0);
        assert_eq!(dot(Scalar, v(1.0, 1e8, -1e8), v(1.0, 1.0, 1.0)).to_array()[0], 0.0);
    }
}
