//! Diffuse reflectance: Lambert, Disney, and the wrapped cosine of transmitted light.

use super::fresnel::schlick;
use overcoat_core::math::lanes::{Float, Lanes};
use std::f32::consts::FRAC_1_PI;

/// Lambert's reflectance per unit of albedo, 1 / pi per steradian.
pub const LAMBERT: f32 = FRAC_1_PI;

/// sin 15 degrees: wrap of transmitted light in Unity (core/BSDF and hd/Material,
/// `TRANSMISSION_WRAP_LIGHT` = cos(pi/2 - pi/12)).
pub const TRANSMISSION_WRAP_LIGHT: f32 = 0.258_819_04;

/// Disney diffuse times pi, per unit of albedo (Burley, SIGGRAPH 2012), scaled by 1 / 1.03571 so that no roughness
/// reflects more than comes in. Unity core/BSDF, `DisneyDiffuseNoPI`.
///
/// `l_dot_v` is the cosine between light and view, `perceptual_roughness` 0 to 1.
#[inline(always)]
pub fn disney_no_pi<L: Lanes>(
    l: L,
    n_dot_v: L::F,
    n_dot_l: L::F,
    l_dot_v: L::F,
    perceptual_roughness: L::F,
) -> L::F {
    let grazing = (perceptual_roughness + perceptual_roughness * l_dot_v) + 0.5;
    let one = l.splat(1.0);
    let light = schlick(l, one, grazing, n_dot_l);
    let view = schlick(l, one, grazing, n_dot_v);
    (light * view) * (1.0 / 1.03571)
}

/// Disney diffuse per steradian and unit of albedo, `DisneyDiffuse`; see [`disney_no_pi`].
#[inline(always)]
pub fn disney<L: Lanes>(
    l: L,
    n_dot_v: L::F,
    n_dot_l: L::F,
    l_dot_v: L::F,
    perceptual_roughness: L::F,
) -> L::F {
    disney_no_pi(l, n_dot_v, n_dot_l, l_dot_v, perceptual_roughness) * FRAC_1_PI
}

/// A cosine that reaches around the terminator by `wrap`, energy-conserving:
/// sat((x + w) / (1 + w)^2). Unity core/CommonLighting, `ComputeWrappedDiffuseLighting`.
#[inline(always)]
pub fn wrapped_cosine<L: Lanes>(_: L, cosine: L::F, wrap: f32) -> L::F {
    ((cosine + wrap) / ((1.0 + wrap) * (1.0 + wrap))).saturate()
}
