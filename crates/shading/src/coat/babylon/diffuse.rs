//! The diffuse lobes: `diffuseBRDF_Burley`, `diffuseBRDF_EON`.

use super::EPSILON;
use overcoat_core::math::lanes::{Float, Lanes, Mask};
use overcoat_core::math::vec3::V3;
use std::f32::consts::{FRAC_1_PI, PI};

/// 1/2 - 2/(3 pi).
const EON_1: f32 = 0.5 - 2.0 / (3.0 * PI);

/// 2/3 - 28/(15 pi).
const EON_2: f32 = 2.0 / 3.0 - 28.0 / (15.0 * PI);

/// (1 - cosine)^5, at least that of [`EPSILON`].
#[inline(always)]
fn burley_weight<L: Lanes>(_: L, cosine: L::F) -> L::F {
    let x = cosine.one_minus().clamp_to(EPSILON, 1.0);
    let x2 = x * x;
    x2 * x2 * x
}

/// Burley, "Physically Based Shading at Disney" (2012), section 5.3, 1/sr for a white surface.
#[inline(always)]
pub(super) fn burley<L: Lanes>(l: L, n_dot_l: L::F, n_dot_v: L::F, v_dot_h: L::F, roughness: L::F) -> L::F {
    let retro = v_dot_h * v_dot_h * roughness * 2.0 + 0.5 - 1.0;
    let one = l.splat(1.0);
    (one + retro * burley_weight(l, n_dot_v)) * (one + retro * burley_weight(l, n_dot_l)) * FRAC_1_PI
}

/// 1 - `E_FON_approx` / rho: share of light at this cosine that Fujii's Oren-Nayar loses on a white surface, at least
/// [`EPSILON`].
#[inline(always)]
fn eon_loss<L: Lanes>(_: L, cosine: L::F, sigma: L::F, scale: L::F) -> L::F {
    let x = cosine.one_minus();
    let x2 = x * x;
    let g = x * 0.057_108_53 + x2 * 0.491_881_87 + (x * -0.332_181_44 + x2 * 0.071_442_995) * x2;
    ((sigma * g + 1.0) * scale).one_minus().at_least(EPSILON)
}

/// Portsmouth, Kutz and Hill, "EON: A Practical Energy-Preserving Rough Diffuse BRDF" (2024), 1/sr, divided by the
/// albedo, which is held at 0.1 to 1. Lambert for a roughness of 0, up to 1e-7.
#[inline(always)]
pub(super) fn eon<L: Lanes>(
    l: L,
    albedo: V3<L>,
    n_dot_l: L::F,
    n_dot_v: L::F,
    l_dot_v: L::F,
    sigma: L::F,
) -> V3<L> {
    let scale = (sigma * EON_1 + 1.0).recip();
    let s = l_dot_v - n_dot_l * n_dot_v;
    let s = s.gt(l.zero()).select(s / n_dot_l.max(n_dot_v), s);
    let lobe = scale * (sigma * s + 1.0) * FRAC_1_PI;
    let mean = scale * (sigma * EON_2 + 1.0);
    let losses = eon_loss(l, n_dot_v, sigma, scale) * eon_loss(l, n_dot_l, sigma, scale);
    let shape = losses / mean.one_minus().at_least(EPSILON) * FRAC_1_PI;
    let rho = albedo.clamp_to(0.1, 1.0);
    let bounced = rho * mean / (rho * mean.one_minus()).one_minus();
    bounced * shape + lobe
}
