//! Three numbers, as directions (z is the normal of the stack, up) and as channels.

use overcoat_core::math::double::sin_cos;

/// A direction of length 1.
pub(super) type Vector = [f64; 3];
/// Red, green and blue, or whatever the caller's three channels are.
pub(super) type Channels = [f64; 3];

pub(super) fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(super) fn negated(a: Vector) -> Vector {
    [-a[0], -a[1], -a[2]]
}

/// On the other side of the plane of the interface.
pub(super) fn mirrored(a: Vector) -> Vector {
    [a[0], a[1], -a[2]]
}

pub(super) fn normalized(a: Vector) -> Vector {
    scaled(a, 1.0 / dot(a, a).sqrt())
}

pub(super) fn scaled(a: [f64; 3], s: f64) -> [f64; 3] {
    [a[0] * s, a[1] * s, a[2] * s]
}

pub(super) fn product(a: Channels, b: Channels) -> Channels {
    [a[0] * b[0], a[1] * b[1], a[2] * b[2]]
}

pub(super) fn plus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

/// 1 - a
pub(super) fn complement(a: Channels) -> Channels {
    [1.0 - a[0], 1.0 - a[1], 1.0 - a[2]]
}

pub(super) fn total(a: Channels) -> f64 {
    a[0] + a[1] + a[2]
}

pub(super) fn mean(a: Channels) -> f64 {
    total(a) / 3.0
}

pub(super) fn largest(a: Channels) -> f64 {
    let larger = if a[0] > a[1] { a[0] } else { a[1] };
    if larger > a[2] { larger } else { a[2] }
}

/// x, or 0 where rounding has made it negative.
pub(super) fn positive(x: f64) -> f64 {
    if x > 0.0 { x } else { 0.0 }
}

/// The mirror image of i about m.
pub(super) fn reflected(i: Vector, m: Vector) -> Vector {
    let twice = 2.0 * dot(i, m);
    normalized([twice * m[0] - i[0], twice * m[1] - i[1], twice * m[2] - i[2]])
}

/// i beyond a facet of normal m whose other side has the relative index eta; the cosine there is given.
pub(super) fn refracted(i: Vector, m: Vector, eta: f64, cosine_beyond: f64) -> Vector {
    let along = dot(i, m) / eta - cosine_beyond;
    normalized([along * m[0] - i[0] / eta, along * m[1] - i[1] / eta, along * m[2] - i[2] / eta])
}

/// A point of the unit disc, evenly.
pub(super) fn disc(u: f64, v: f64) -> [f64; 2] {
    let radius = u.sqrt();
    let (s, c) = sin_cos(std::f64::consts::TAU * v);
    [radius * c, radius * s]
}

/// The direction at a cosine to `axis`, turned about it by `turn` of a whole turn.
pub(super) fn around(axis: Vector, cosine: f64, turn: f64) -> Vector {
    let sine = positive(1.0 - cosine * cosine).sqrt();
    let (s, c) = sin_cos(std::f64::consts::TAU * turn);
    // Duff et al. 2017, "Building an Orthonormal Basis, Revisited".
    let sign = if axis[2] >= 0.0 { 1.0 } else { -1.0 };
    let a = -1.0 / (sign + axis[2]);
    let b = axis[0] * axis[1] * a;
    let x = [1.0 + sign * axis[0] * axis[0] * a, sign * b, -sign * axis[0]];
    let y = [b, sign + axis[1] * axis[1] * a, -axis[1]];
    let at = |k: usize| sine * (c * x[k] + s * y[k]) + cosine * axis[k];
    normalized([at(0), at(1), at(2)])
}
