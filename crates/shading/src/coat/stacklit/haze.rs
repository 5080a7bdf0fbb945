//! Hazy gloss: two lobes from the haziness that artists set.
//!
//! Barla, Pacanowski and Vangorp, "A Composite BRDF Model for Hazy Gloss", 2018: a narrow core and a wide halo
//! whose weights follow from the ratio of their peaks, so that haziness looks alike on all materials.

use crate::brdf::roughness::{MIN_ANALYTICAL_ROUGHNESS, anisotropy_of_roughness, roughness_of_anisotropic};
use overcoat_core::each;
use overcoat_core::math::lanes::{Float, Lanes, Mask};
use overcoat_core::math::vec3::{V3, Vec3};

/// Below this the base reflects nothing that could be hazy (`FLT_EPS` of Unity's shaders, 2^-24).
const EPSILON: f32 = 5.960_464_5e-8;

/// Haze as artists set it.
#[derive(Clone, Copy)]
pub struct Haze<L: Lanes> {
    /// Strength of the halo, 0 to 1.
    pub haziness: L::F,
    /// Width of the halo beyond the core, in roots of the core's roughness, 0 and more (3 by default).
    pub extent: L::F,
    /// Anisotropy of the halo, -1 to 1.
    pub extent_anisotropy: L::F,
    /// Greatest F0 of the sum of both lobes, per channel.
    pub max_f0: V3<L>,
}

/// The lobes that result.
#[derive(Clone, Copy)]
pub struct HazyLobes<L: Lanes> {
    /// F0 of both lobes together.
    pub fresnel0: V3<L>,
    /// Share of lobe B.
    pub lobe_mix: L::F,
    /// Lobe B: anisotropy, perceptual roughness, roughness along tangent and bitangent.
    pub anisotropy_b: L::F,
    /// See `anisotropy_b`.
    pub perceptual_roughness_b: L::F,
    /// See `anisotropy_b`.
    pub roughness_b: [L::F; 2],
}

/// `HazeMapping` of Unity StackLit: the halo beside the core lobe of roughness (alpha) `roughness_a` along
/// tangent and bitangent and of F0 `fresnel0`. `before` is returned with a lobe share of 0 in lanes that
/// reflect nothing.
///
/// The discriminant and the divisors are guarded where rounding makes them negative or 0: the original's NaN
/// there would be dropped by a later clamp.
#[inline(always)]
pub fn haze_mapping<L: Lanes>(
    l: L,
    fresnel0: V3<L>,
    roughness_a: [L::F; 2],
    haze: &Haze<L>,
    before: &HazyLobes<L>,
) -> HazyLobes<L> {
    /// Weight of haze in the perceptual space that the paper found.
    const W: f32 = 10.0;
    let one = l.splat(1.0);
    let strongest = fresnel0.max_component();
    let reflects = strongest.gt(l.splat(EPSILON));
    let rm = reflects.select(strongest, one);

    let core: [L::F; 2] = each!(a in roughness_a => a.at_least(MIN_ANALYTICAL_ROUGHNESS));
    let core_product = core[0] * core[1];
    let core_root = core_product.sqrt();
    let k = haze.extent_anisotropy;
    let wide = [
        (core[0] + haze.extent * (k + 1.0) * core_root).saturate(),
        (core[1] + haze.extent * k.one_minus() * core_root).saturate(),
    ];
    // Ratio of the lobes' peaks, 0 to 1.
    let peak = core_product / (wide[0] * wide[1]);

    let wp = peak * W;
    let b = (rm * (1.0 - W) + wp) * 2.0;
    let divisor = (b - 1.0) * 2.0;
    let singular = divisor.abs().le(l.splat(EPSILON));
    let at_singularity = {
        let offset = rm - (-wp + 0.5) / (1.0 - W);
        (wp * 2.0 - 1.0 - (wp * wp * 4.0 - wp * 4.0 + one) * offset) / (2.0 * (W - 1.0))
    };
    let elsewhere = {
        let discriminant = b * b - (b - 1.0) * 4.0 * rm;
        (b - discriminant.at_least(0.0).sqrt()) / singular.select(one, divisor)
    };
    let u = singular.select(at_singularity, elsewhere);

    let cross = u.one_minus() * 2.0 * u * W;
    let haze_part = cross * haze.haziness / (u.one_minus().squared() + cross + u * u);
    let total = rm + peak.one_minus() * haze_part;
    let scaled = fresnel0 / rm * total;
    let fresnel0 = Vec3::select(reflects, scaled.min(haze.max_f0), fresnel0);
    let anisotropy = anisotropy_of_roughness(l, wide[0], wide[1]);
    let p = roughness_of_anisotropic(l, wide[0], anisotropy).sqrt();
    HazyLobes {
        fresnel0,
        lobe_mix: reflects.select(haze_part / total, l.zero()),
        anisotropy_b: reflects.select(anisotropy, before.anisotropy_b),
        perceptual_roughness_b: reflects.select(p, before.perceptual_roughness_b),
        roughness_b: each!(c => reflects.select(wide[c], before.roughness_b[c])),
    }
}
