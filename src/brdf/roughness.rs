//! Roughness in its parametrisations, and the level of a prefiltered environment that belongs to it.

use crate::math::lanes::{Float, Lanes};

/// Last level of a prefiltered environment chain (`UNITY_SPECCUBE_LOD_STEPS`).
pub const LAST_MIP: f32 = 6.0;

/// Variance of the slopes of a GGX surface with roughness (alpha) a: 2 / a^2 - 2. Infinite for 0 (and
/// understood by [`variance_to_roughness`]); the inverse is exact up to rounding. Unity core/CommonMaterial,
/// where it is the Blinn-Phong exponent that stands for the lobe.
#[inline(always)]
pub fn roughness_to_variance<L: Lanes>(l: L, roughness: L::F) -> L::F {
    l.splat(2.0) / (roughness * roughness) - 2.0
}

/// Roughness (alpha) of a variance as [`roughness_to_variance`] gives it: sqrt(2 / (v + 2)).
#[inline(always)]
pub fn variance_to_roughness<L: Lanes>(l: L, variance: L::F) -> L::F {
    (l.splat(2.0) / (variance + 2.0)).sqrt()
}

/// Level of detail, 0 to [`LAST_MIP`], for a perceptual roughness p of 0 to 1: 6 p (1.7 - 0.7 p). Unity
/// core/ImageBasedLighting, `PerceptualRoughnessToMipmapLevel`.
#[inline(always)]
pub fn mip_of_perceptual_roughness<L: Lanes>(l: L, p: L::F) -> L::F {
    p * (l.splat(1.7) - p * 0.7) * LAST_MIP
}

/// The perceptual roughness that a level of the chain is filtered for: the inverse of
/// [`mip_of_perceptual_roughness`], 0 to 1 for levels of 0 to [`LAST_MIP`].
#[must_use]
pub fn perceptual_roughness_of_mip(level: f32) -> f32 {
    let t = f64::from(level) / f64::from(LAST_MIP);
    let root = 2.89 - 2.8 * t;
    let p = (1.7 - if root > 0.0 { root.sqrt() } else { 0.0 }) / 1.4;
    if p > 1.0 {
        1.0
    } else if p > 0.0 {
        p as f32
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::lanes::Scalar;

    #[test]
    fn levels_and_roughness_are_inverse_to_each_other() {
        for k in 0..=600 {
            let level = k as f32 / 100.0;
            let p = perceptual_roughness_of_mip(level);
            let back = mip_of_perceptual_roughness(Scalar, Scalar.splat(p)).to_array()[0];
            assert!((back - level).abs() < 2e-6, "{level} -> {p} -> {back}");
        }
        assert_eq!(perceptual_roughness_of_mip(0.0), 0.0);
        assert_eq!(perceptual_roughness_of_mip(LAST_MIP), 1.0);
    }

    #[test]
    fn variance_returns_the_roughness_it_came_from() {
        for k in 0..=100 {
            let a = k as f32 / 100.0;
            let variance = roughness_to_variance(Scalar, Scalar.splat(a));
            let back = variance_to_roughness(Scalar, variance).to_array()[0];
            assert!((back - a).abs() <= 1e-6, "{a} {back}");
        }
    }
}
