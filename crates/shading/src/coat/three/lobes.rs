//! Lobes that all versions of three.js share.

use crate::brdf::microfacet::{distribution_ggx, visibility_smith};
use crate::coat::glsl::{mix, normalize_or};
use overcoat_core::math::lanes::{Float, Lanes, Mask};
use overcoat_core::math::vec3::V3;
use overcoat_core::math::{exp2, pow};
use overcoat_core::vec3;

/// `EPSILON`: least denominator of the visibility.
pub(in crate::coat) const EPSILON: f32 = 1e-6;

/// Mean of (1 - u)^5 over the hemisphere, 1 / 21, as three.js writes it.
const MEAN_SCHLICK_WEIGHT: f32 = 0.047619;

/// `pow4`.
#[inline(always)]
pub(in crate::coat) fn pow4<L: Lanes>(_: L, x: L::F) -> L::F {
    let x2 = x * x;
    x2 * x2
}

/// D V of GGX for one layer. `roughness` is perceptual and above 0.04, so nothing vanishes.
#[inline(always)]
pub(in crate::coat) fn ggx<L: Lanes>(
    l: L,
    n_dot_l: L::F,
    n_dot_v: L::F,
    n_dot_h: L::F,
    roughness: L::F,
) -> L::F {
    let alpha = roughness * roughness;
    let alpha2 = alpha * alpha;
    visibility_smith(l, n_dot_l, n_dot_v, alpha2, EPSILON) * distribution_ggx(l, n_dot_h, alpha2)
}

/// `computeMultiscattering`, without Fresnel: the part of light that leaves after more than one bounce between
/// microfacets, for the light that leaves after one, the mean over F0 and A + B of the lookup. Fdez-Aguera, "A
/// Multiple-Scattering Microfacet Model for Real-Time Image-based Lighting" (JCGT 2019).
///
/// The divisor is 0 only for an F0 beyond 1, which a thin film has; a small number stands for it there.
#[inline(always)]
pub(in crate::coat) fn multiple_scattering<L: Lanes>(l: L, single: V3<L>, f0: V3<L>, sum: L::F) -> V3<L> {
    let missing = sum.one_minus();
    let mean = f0 + f0.one_minus() * MEAN_SCHLICK_WEIGHT;
    let divisor = (mean * missing).one_minus();
    let divisor = vec3!(d in divisor => d.eq(l.zero()).select(l.splat(EPSILON), d));
    single * mean / divisor * missing
}

/// `getIBLRadiance`: the direction to ask, for the view mirrored at `normal`, bent by `bend` towards it.
#[inline(always)]
pub(in crate::coat) fn bent_reflection<L: Lanes>(l: L, view: V3<L>, normal: V3<L>, bend: L::F) -> V3<L> {
    let mirrored = (-view).reflect(normal);
    normalize_or(l, mix(l, mirrored, normal, bend), normal)
}

/// `computeSpecularOcclusion`: specular occlusion of a surface whose ambient occlusion is `occlusion`. Lagarde and de
/// Rousiers, "Moving Frostbite to PBR" (2014). Exactly 1 for 1.
#[inline(always)]
pub(in crate::coat) fn specular_occlusion<L: Lanes>(
    l: L,
    n_dot_v: L::F,
    occlusion: L::F,
    roughness: L::F,
) -> L::F {
    (pow(l, n_dot_v + occlusion, exp2(l, roughness * -16.0 - 1.0)) - 1.0 + occlusion).saturate()
}
