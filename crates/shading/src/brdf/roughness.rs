//! Roughness in its parametrisations, and the level of a prefiltered environment that belongs to it.

use overcoat_core::math;
use overcoat_core::math::lanes::{Float, Lanes};

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

/// Least roughness (alpha) that HDRP shades lights without extent with.
pub const MIN_ANALYTICAL_ROUGHNESS: f32 = 1.0 / 1024.0;

/// Least divisor where a ratio of roughnesses is formed.
const LEAST_ROUGHNESS_SUM: f32 = 1e-4;

/// Power between roughness and the share that [`roughness_to_linear_variance`] maps to a variance, and its
/// inverse, rounded as the original's are.
const LINEAR_VARIANCE_POWER: f32 = 1.1;
const LINEAR_VARIANCE_ROOT: f32 = 1.0 / 1.1;

/// Roughness (alpha) raised to [`MIN_ANALYTICAL_ROUGHNESS`], below which highlights of point lights are
/// narrower than anything that can be sampled. Unity core/CommonMaterial,
/// `ClampRoughnessForAnalyticalLights`.
#[inline(always)]
pub fn clamp_roughness_for_analytical_lights<L: Lanes>(_: L, roughness: L::F) -> L::F {
    roughness.at_least(MIN_ANALYTICAL_ROUGHNESS)
}

/// Roughness along tangent and bitangent, a (1 + k) and a (1 - k), for roughness (alpha) a and anisotropy k
/// of -1 to 1. Unity core/CommonMaterial, `ConvertAnisotropyToRoughness` (which takes the perceptual
/// roughness).
#[inline(always)]
pub fn anisotropic_roughness<L: Lanes>(_: L, roughness: L::F, anisotropy: L::F) -> [L::F; 2] {
    [roughness * (anisotropy + 1.0), roughness * anisotropy.one_minus()]
}

/// The anisotropy of two roughnesses: (t - b) / max(t + b, 1e-4). Unity core/CommonMaterial,
/// `ConvertRoughnessToAnisotropy`.
#[inline(always)]
pub fn anisotropy_of_roughness<L: Lanes>(_: L, along_tangent: L::F, along_bitangent: L::F) -> L::F {
    (along_tangent - along_bitangent) / (along_tangent + along_bitangent).at_least(LEAST_ROUGHNESS_SUM)
}

/// The isotropic roughness of one along the tangent, t / (1 + k), for anisotropy k > -1. Unity
/// core/CommonMaterial, `ConvertRoughnessTAndAnisotropyToRoughness`.
#[inline(always)]
pub fn roughness_of_anisotropic<L: Lanes>(_: L, along_tangent: L::F, anisotropy: L::F) -> L::F {
    along_tangent / (anisotropy + 1.0)
}

/// The anisotropy that keeps the stretch of a lobe when its perceptual roughness changes from `old` to `new`:
/// k old / (new + 2 `FLT_MIN`), which is 0 where both are 0. Not limited to -1 to 1. Unity StackLit,
/// `GetModifiedAnisotropy`.
#[inline(always)]
pub fn modified_anisotropy<L: Lanes>(_: L, anisotropy: L::F, old: L::F, new: L::F) -> L::F {
    anisotropy * (old / (new + 2.0 * f32::MIN_POSITIVE))
}

/// Variance of a GGX lobe of roughness (alpha) a, such that variances of layers add: with q = a^1.1, q / (1 -
/// q), for a of 0 to 0.9999 (clamped). Belcour, "Efficient Rendering of Layered Materials using an Atomic
/// Decomposition with Statistical Operators", 2018; Unity StackLit, `RoughnessToLinearVariance`.
#[inline(always)]
pub fn roughness_to_linear_variance<L: Lanes>(l: L, roughness: L::F) -> L::F {
    let share = math::pow(l, roughness.clamp_to(0.0, 0.9999), l.splat(LINEAR_VARIANCE_POWER));
    share / share.one_minus()
}

/// Roughness (alpha) of a variance, the inverse of [`roughness_to_linear_variance`]; negative variances and
/// NaN count as 0, infinite ones give 1 (where the original divides infinity by itself). Unity StackLit, `LinearVarianceToRoughness`.
#[inline(always)]
pub fn linear_variance_to_roughness<L: Lanes>(l: L, variance: L::F) -> L::F {
    let variance = variance.clamp_to(0.0, 1e30);
    math::pow(l, variance / (variance + 1.0), l.splat(LINEAR_VARIANCE_ROOT))
}

/// Perceptual roughness of the GGX lobe nearest to a Beckmann lobe: GGX's alpha is half of Beckmann's. Unity
/// core/CommonMaterial, `PerceptualRoughnessBeckmannToGGX`.
#[inline(always)]
pub fn perceptual_roughness_beckmann_to_ggx<L: Lanes>(_: L, p: L::F) -> L::F {
    p * std::f32::consts::FRAC_1_SQRT_2
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
    use overcoat_core::math::lanes::Scalar;

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

    #[test]
    fn linear_variance_returns_the_roughness_it_came_from() {
        for k in 0..=100 {
            let a = k as f32 / 101.0;
            let variance = roughness_to_linear_variance(Scalar, Scalar.splat(a));
            let back = linear_variance_to_roughness(Scalar, variance).to_array()[0];
            assert!((back - a).abs() <= 1e-6, "{a} {back}");
        }
        let of = |v: f32| linear_variance_to_roughness(Scalar, Scalar.splat(v)).to_array()[0];
        assert_eq!((of(-1.0), of(f32::NAN), of(f32::INFINITY)), (0.0, 0.0, 1.0));
    }

    #[test]
    fn anisotropy_and_two_roughnesses_are_one() {
        for (a, k) in [(0.5, 0.3), (0.1, -0.9), (1.0, 1.0), (0.01, 0.0)] {
            let [t, b] = anisotropic_roughness(Scalar, Scalar.splat(a), Scalar.splat(k));
            let found = anisotropy_of_roughness(Scalar, t, b).to_array()[0];
            let isotropic = roughness_of_anisotropic(Scalar, t, Scalar.splat(k)).to_array()[0];
            assert!((found - k).abs() < 1e-6 && (isotropic - a).abs() < 1e-6, "{a} {k}: {isotropic} {found}");
        }
        let stays = modified_anisotropy(Scalar, Scalar.splat(0.7), Scalar.zero(), Scalar.zero());
        assert_eq!(stays.to_array()[0], 0.0);
    }
}
