//! Direct light: `RE_Direct_Physical`.

use super::lobes::{EPSILON, ggx};
use super::{
    COAT_F0, SheenSurface, Surface, Terms, cosine, f_schlick, fresnel_weight, outgoing_light, sheen_albedo,
};
use crate::brdf::microfacet::{distribution_ggx_anisotropic, visibility_smith_anisotropic};
use crate::brdf::sheen::{LEAST_SINE_SQUARED, distribution_charlie, visibility_neubelt};
use crate::coat::glsl::{half_vector, mix};
use overcoat_core::math::lanes::{Float, Lanes};
use overcoat_core::math::vec3::{V3, Vec3};
use std::f32::consts::FRAC_1_PI;

/// No distribution exceeds this, so that nothing overflows; the sharpest peak is 8e4.
const LARGEST_DISTRIBUTION: f32 = 1e12;

/// `BRDF_Sheen` without its colour. The perceptual roughness is squared into Charlie's alpha; the visibility ends
/// at 1.
#[inline(always)]
fn sheen_lobe<L: Lanes>(l: L, n_dot_l: L::F, n_dot_v: L::F, n_dot_h: L::F, roughness: L::F) -> L::F {
    let d = distribution_charlie(l, n_dot_h, roughness * roughness, LEAST_SINE_SQUARED);
    d * visibility_neubelt(l, n_dot_l, n_dot_v, 0.0).saturate()
}

/// Factor on the layers beneath the sheen.
#[inline(always)]
fn beneath_sheen<L: Lanes>(l: L, sheen: &SheenSurface<L>, n_dot_l: L::F) -> L::F {
    let albedo = sheen.albedo.max(sheen_albedo(l, n_dot_l, sheen.roughness));
    (sheen.largest * albedo).one_minus()
}

/// D V of the base, isotropic or not.
#[inline(always)]
fn base_lobe<L: Lanes>(l: L, surface: &Surface<L>, light: V3<L>, half: V3<L>, n_dot_l: L::F) -> L::F {
    let n_dot_h = cosine(l, surface.normal, half);
    let Some(anisotropy) = &surface.anisotropy else {
        return ggx(l, n_dot_l, surface.n_dot_v, n_dot_h, surface.roughness);
    };
    let alpha = [anisotropy.alpha_t, surface.roughness * surface.roughness];
    let (t, b) = (anisotropy.tangent, anisotropy.bitangent);
    let in_frame = [
        Vec3::new(t.dot(half), b.dot(half), n_dot_h),
        Vec3::new(t.dot(light), b.dot(light), n_dot_l),
        Vec3::new(t.dot(surface.view), b.dot(surface.view), surface.n_dot_v),
    ];
    // A half vector at right angles to all of a degenerate frame would divide by 0.
    let d = distribution_ggx_anisotropic(l, in_frame[0], alpha, 0.0).at_most(LARGEST_DISTRIBUTION);
    visibility_smith_anisotropic(l, in_frame[1], in_frame[2], alpha, EPSILON) * d
}

/// One light: its reflection by lobe.
///
/// `direction` is the unit vector to the light, `color` its irradiance at normal incidence.
#[inline(always)]
pub fn direct_terms<L: Lanes>(l: L, surface: &Surface<L>, direction: V3<L>, color: V3<L>) -> Terms<L> {
    let n_dot_l = cosine(l, surface.normal, direction);
    let (half, v_dot_h) = half_vector(l, direction, surface.view, surface.normal);
    let weight = fresnel_weight(l, v_dot_h);
    let mut irradiance = color * n_dot_l;
    let zero = Vec3::zero(l);
    let mut terms = Terms { diffuse: zero, specular: zero, sheen: zero, coat: zero };

    if let Some(coat) = &surface.coat {
        let n_dot_l = cosine(l, coat.normal, direction);
        let lobe = ggx(l, n_dot_l, coat.n_dot_v, cosine(l, coat.normal, half), coat.roughness);
        let reflectance = (weight.one_minus() * COAT_F0 + weight) * lobe * n_dot_l;
        terms.coat = color * reflectance;
    }
    if let Some(sheen) = &surface.sheen {
        let n_dot_h = cosine(l, surface.normal, half);
        let lobe = sheen_lobe(l, n_dot_l, surface.n_dot_v, n_dot_h, sheen.roughness);
        terms.sheen = irradiance * (sheen.color * lobe);
        irradiance *= beneath_sheen(l, sheen, n_dot_l);
    }

    let lobe = base_lobe(l, surface, direction, half, n_dot_l);
    let mut fresnel = f_schlick(l, surface.specular_color_blended, surface.specular_f90, weight);
    if let Some(film) = &surface.film {
        fresnel = mix(l, fresnel, film.fresnel, film.factor);
    }
    terms.specular = irradiance * (fresnel * lobe * surface.multi_scattering_compensation);
    let dielectric = f_schlick(l, surface.specular_color, surface.specular_f90, weight);
    terms.diffuse = irradiance * (surface.diffuse_contribution * FRAC_1_PI) * dielectric.one_minus();
    terms
}

/// One light: the radiance that the fragments reflect.
///
/// `direction` is the unit vector to the light, `color` its irradiance at normal incidence, with
/// distance, cone and shadow applied.
#[inline(always)]
pub fn direct<L: Lanes>(l: L, surface: &Surface<L>, direction: V3<L>, color: V3<L>) -> V3<L> {
    let terms = direct_terms(l, surface, direction, color);
    outgoing_light(l, surface, &terms)
}
