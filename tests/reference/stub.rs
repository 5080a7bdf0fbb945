//! The environment that the tables' originals read in place of a prefiltered cube map.

use overcoat_core::math::lanes::{Float, Lanes};
use overcoat_core::math::vec3::{V3, Vec3};

/// Radiance in a direction (of any length) for a perceptual roughness; see the README of the tables.
#[inline(always)]
pub fn environment<L: Lanes>(l: L, direction: V3<L>, perceptual_roughness: L::F) -> V3<L> {
    let d = direction.normalize();
    let p = perceptual_roughness;
    let u = d.y * 0.5 + 0.5;
    let sky = (p * 0.5).one_minus() * u * u;
    let (ground, lobe) = (p + 1.0, p.one_minus() * 0.25);
    let (sky_color, ground_color) = (Vec3::splat(l, [1.0, 0.8, 0.6]), Vec3::splat(l, [0.1, 0.2, 0.3]));
    sky_color * sky + ground_color * ground + d * d * lobe
}
