//! Vectors as the models written in GLSL use them, with a direction where the originals leave it undefined.

use overcoat_core::math::lanes::{Float, Lanes};
use overcoat_core::math::vec3::{V3, Vec3};

/// GLSL's `mix`: a (1 - t) + b t.
#[inline(always)]
pub(super) fn mix<L: Lanes>(_: L, a: V3<L>, b: V3<L>, t: L::F) -> V3<L> {
    let rest = t.one_minus();
    a * rest + b * t
}

/// The same of numbers: exactly a at 0 and b at 1.
#[inline(always)]
pub(super) fn mix_number<L: Lanes>(_: L, a: L::F, b: L::F, t: L::F) -> L::F {
    a * t.one_minus() + b * t
}

/// `v` / |v|, divided as in GLSL (a product with the reciprocal moves sharp highlights by more than they are wide), or
/// `otherwise` where it has no direction (so that no lookup is ever asked for none).
#[inline(always)]
pub(super) fn normalize_or<L: Lanes>(l: L, v: V3<L>, otherwise: V3<L>) -> V3<L> {
    let has_direction = v.dot(v).gt(l.splat(1e-30));
    Vec3::select(has_direction, v.divide_by_length(), otherwise)
}

/// The unit half vector, and its cosine with the view. Where light and view oppose each other it does not exist (and
/// the original is undefined); the normal stands for it.
#[inline(always)]
pub(super) fn half_vector<L: Lanes>(l: L, light: V3<L>, view: V3<L>, normal: V3<L>) -> (V3<L>, L::F) {
    let half = normalize_or(l, light + view, normal);
    (half, view.dot(half).saturate())
}
