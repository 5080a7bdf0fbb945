//! Lights.

use super::{COAT_F0, CoatSurface, LEAST_ROUGHNESS, MEAN_SCHLICK_WEIGHT, Surface, Terms, color};
use crate::brdf::microfacet::{
    distribution_ggx, distribution_ggx_anisotropic, schlick_weight, visibility_smith,
    visibility_smith_anisotropic,
};
use crate::brdf::sheen::{LEAST_SINE_SQUARED, distribution_charlie, visibility_neubelt};
use crate::coat::glsl::half_vector;
use overcoat_core::math::lanes::{Float, Lanes};
use overcoat_core::math::vec3::{V3, Vec3};
use std::f32::consts::FRAC_1_PI;

/// Least denominator of the visibility.
const LEAST_SMITH: f32 = 1e-6;

/// No distribution exceeds this, so that nothing overflows; the sharpest peak is 8e4.
const LARGEST_DISTRIBUTION: f32 = 1e6;

/// D V of GGX.
#[inline(always)]
fn ggx<L: Lanes>(l: L, n_dot_l: L::F, n_dot_v: L::F, n_dot_h: L::F, roughness: L::F) -> L::F {
    let alpha = roughness.at_least(LEAST_ROUGHNESS).squared();
    let alpha2 = alpha * alpha;
    visibility_smith(l, n_dot_l, n_dot_v, alpha2, LEAST_SMITH) * distribution_ggx(l, n_dot_h, alpha2)
}

/// D V of the base, isotropic or not.
#[inline(always)]
fn base_lobe<L: Lanes>(l: L, surface: &Surface<L>, light: V3<L>, half: V3<L>, n_dot_l: L::F) -> L::F {
    let n_dot_h = surface.normal.dot(half).saturate();
    let Some(anisotropy) = &surface.anisotropy else {
        return ggx(l, n_dot_l, surface.n_dot_v, n_dot_h, surface.roughness);
    };
    let (t, b) = (anisotropy.tangent, anisotropy.bitangent);
    let half = Vec3::new(t.dot(half), b.dot(half), n_dot_h);
    let light = Vec3::new(t.dot(light), b.dot(light), n_dot_l);
    let view = Vec3::new(t.dot(surface.view), b.dot(surface.view), surface.n_dot_v);
    let d = distribution_ggx_anisotropic(l, half, anisotropy.alpha, 0.0).at_most(LARGEST_DISTRIBUTION);
    visibility_smith_anisotropic(l, light, view, anisotropy.alpha, LEAST_SMITH) * d
}

/// Transmittance of the coat for light from outside over its mean for light from everywhere, which the darkening of the
/// Lambertian lobe contains.
#[inline(always)]
fn entering<L: Lanes>(l: L, n_dot_l: L::F) -> L::F {
    const MEAN: f32 = (1.0 - COAT_F0) * (1.0 - MEAN_SCHLICK_WEIGHT);
    schlick_weight(l, n_dot_l).one_minus() * ((1.0 - COAT_F0) / MEAN)
}

/// One light: the radiance that the fragments reflect.
///
/// `direction` is the unit vector to the light, `light_color` its irradiance at normal incidence, with distance, cone and
/// shadow applied.
#[inline(always)]
pub fn direct<L: Lanes>(l: L, surface: &Surface<L>, direction: V3<L>, light_color: V3<L>) -> V3<L> {
    let n_dot_l = surface.normal.dot(direction).saturate();
    let (half, v_dot_h) = half_vector(l, direction, surface.view, surface.normal);
    let weight = schlick_weight(l, v_dot_h);
    let irradiance = light_color * n_dot_l;
    let fresnel = surface.reflectance.normal + surface.reflectance.grazing * weight;
    let lobe = fresnel * base_lobe(l, surface, direction, half, n_dot_l);
    let diffuse = match &surface.coat {
        Some(CoatSurface { normal, darkening: Some(darkening), .. }) => {
            let passes = entering(l, normal.dot(direction).saturate());
            surface.diffuse * ((passes - 1.0) * *darkening + 1.0)
        }
        _ => surface.diffuse,
    };
    let base = irradiance * (diffuse * FRAC_1_PI + lobe);
    let sheen = match &surface.sheen {
        Some(sheen) => {
            let n_dot_h = surface.normal.dot(half).saturate();
            let d = distribution_charlie(l, n_dot_h, sheen.roughness.squared(), LEAST_SINE_SQUARED);
            let v = visibility_neubelt(l, n_dot_l, surface.n_dot_v, 0.0).saturate();
            irradiance * (sheen.color * (d * v * sheen.scale))
        }
        None => Vec3::zero(l),
    };
    let coat = match &surface.coat {
        Some(coat) => {
            let n_dot_l = coat.normal.dot(direction).saturate();
            let lobe = ggx(l, n_dot_l, coat.n_dot_v, coat.normal.dot(half).saturate(), coat.roughness);
            let fresnel = coat.reflectance.normal + coat.reflectance.grazing * weight;
            light_color * fresnel * (lobe * n_dot_l)
        }
        None => Vec3::zero(l),
    };
    color(l, surface, &Terms { base, sheen, coat })
}
