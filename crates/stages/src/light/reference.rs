//! The analytic environment of the reference tables, so that rendered pictures can be compared with their rows.

use overcoat_core::math::lanes::{Float, Lanes};
use overcoat_core::math::vec3::{V3, Vec3};

/// Radiance from a direction of any length, filtered for a perceptual roughness p: with the unit direction d and
/// `u = (1 + d.y) / 2`, `(1, 0.8, 0.6) (1 - p / 2) u^2 + (0.1, 0.2, 0.3) (1 + p) + (d.x^2, d.y^2, d.z^2) (1 - p) / 4`.
#[inline(always)]
pub(super) fn radiance<L: Lanes>(l: L, direction: V3<L>, perceptual_roughness: L::F) -> V3<L> {
    let sky = Vec3::splat(l, [1.0, 0.8, 0.6]);
    let ground = Vec3::splat(l, [0.1, 0.2, 0.3]);
    let d = direction.normalize();
    let u = d.y * 0.5 + 0.5;
    let p = perceptual_roughness;
    sky * (p * 0.5).one_minus() * u * u + ground * (p + 1.0) + d * (p.one_minus() * 0.25) * d
}
