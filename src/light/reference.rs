//! The analytic environment of the reference tables, so that rendered pictures can be compared with their rows.

use crate::each;
use crate::math::lanes::{Float, Lanes};
use crate::math::vec3::{self, V3};

/// Radiance from a direction of any length, filtered for a perceptual roughness p: with the unit direction d and
/// `u = (1 + d.y) / 2`, `(1, 0.8, 0.6) (1 - p / 2) u^2 + (0.1, 0.2, 0.3) (1 + p) + (d.x^2, d.y^2, d.z^2) (1 - p) / 4`.
#[inline(always)]
pub(super) fn radiance<L: Lanes>(l: L, direction: V3<L>, perceptual_roughness: L::F) -> V3<L> {
    const SKY: [f32; 3] = [1.0, 0.8, 0.6];
    const GROUND: [f32; 3] = [0.1, 0.2, 0.3];
    let d = vec3::normalize(l, direction);
    let u = d[1] * 0.5 + 0.5;
    let p = perceptual_roughness;
    each!(k => (p * 0.5).one_minus() * SKY[k] * u * u + (p + 1.0) * GROUND[k] + p.one_minus() * 0.25 * d[k] * d[k])
}
