//! The environment: `RE_IndirectDiffuse_Physical` and `RE_IndirectSpecular_Physical`.

use super::lobes::{bent_reflection, multiple_scattering, pow4, specular_occlusion};
use super::{COAT_F0, EnvironmentQuery, Surface, Terms, outgoing_light};
use crate::coat::glsl::{mix, normalize_or};
use crate::coat::look_up;
use overcoat_core::math::lanes::{Float, Lanes, Mask};
use overcoat_core::math::vec3::{V3, Vec3};
use std::f32::consts::FRAC_1_PI;

/// Light of the surroundings at the fragments.
#[derive(Clone, Copy)]
pub struct Indirect<L: Lanes> {
    /// Irradiance of ambient lights and light probes, which reach the Lambert part and the sheen.
    pub ambient: V3<L>,
    /// Irradiance of the environment at the base normal.
    pub irradiance: V3<L>,
    /// Radiance for the first of [`environment_queries`].
    pub radiance: V3<L>,
    /// Radiance for the second; of no effect where there is no coat.
    pub coat_radiance: V3<L>,
}

/// `getIBLRadiance`: the mirrored view, turned towards the normal by the fourth power of the perceptual roughness.
#[inline(always)]
fn query<L: Lanes>(l: L, view: V3<L>, normal: V3<L>, roughness: L::F) -> EnvironmentQuery<L> {
    EnvironmentQuery {
        direction: bent_reflection(l, view, normal, pow4(l, roughness)),
        perceptual_roughness: roughness,
    }
}

/// Lookups of base and coat in the prefiltered environment, and the count of those in use: 2 with a coat, else 1.
#[inline(always)]
pub fn environment_queries<L: Lanes>(l: L, surface: &Surface<L>) -> ([EnvironmentQuery<L>; 2], usize) {
    let mut normal = surface.normal;
    if let Some(anisotropy) = &surface.anisotropy {
        // `getIBLAnisotropyRadiance`.
        let b = anisotropy.bitangent;
        let across = b.cross(surface.view).cross(b);
        let bent = normalize_or(l, across, normal);
        let towards = pow4(l, (anisotropy.strength * surface.roughness.one_minus()).one_minus());
        normal = normalize_or(l, mix(l, bent, normal, towards), normal);
    }
    let base = query(l, surface.view, normal, surface.roughness);
    match &surface.coat {
        Some(coat) => ([base, query(l, surface.view, coat.normal, coat.roughness)], 2),
        None => ([base, base], 1),
    }
}

/// `computeMultiscattering`: light that leaves after one bounce, and after more.
#[inline(always)]
fn scattering<L: Lanes>(
    l: L,
    surface: &Surface<L>,
    f0: V3<L>,
    film_f0: Option<(V3<L>, L::F)>,
) -> (V3<L>, V3<L>) {
    let f0 = match film_f0 {
        Some((film_f0, factor)) => mix(l, f0, film_f0, factor),
        None => f0,
    };
    let [scale, bias] = surface.dfg;
    let single = f0 * scale + surface.specular_f90 * bias;
    (single, multiple_scattering(l, single, f0, scale + bias))
}

/// Light of the surroundings that each lobe reflects.
#[inline(always)]
pub fn indirect_terms<L: Lanes>(l: L, surface: &Surface<L>, light: &Indirect<L>) -> Terms<L> {
    let (film_dielectric, film_metallic) = match &surface.film {
        Some(film) => (Some((film.f0_dielectric, film.factor)), Some((film.f0_metallic, film.factor))),
        None => (None, None),
    };
    let (single_d, multi_d) = scattering(l, surface, surface.specular_color, film_dielectric);
    let (single_m, multi_m) = scattering(l, surface, surface.diffuse_color, film_metallic);
    let single = mix(l, single_d, single_m, surface.metalness);
    let multi = mix(l, multi_d, multi_m, surface.metalness);

    let cosine_weighted = light.irradiance * FRAC_1_PI;
    let ambient = light.ambient * FRAC_1_PI;
    let specular = light.radiance * single + multi * cosine_weighted;
    let through = (single_d + multi_d).one_minus();
    let diffuse = surface.diffuse_contribution * through * (cosine_weighted + ambient);
    let mut terms = Terms { diffuse, specular, sheen: Vec3::zero(l), coat: Vec3::zero(l) };
    if let Some(sheen) = &surface.sheen {
        let beneath = (sheen.largest * sheen.albedo).one_minus();
        terms.sheen = (cosine_weighted + ambient) * sheen.color * sheen.albedo;
        terms.specular = specular * beneath;
        terms.diffuse = diffuse * beneath;
    }
    if let Some(coat) = &surface.coat {
        let reflectance = coat.dfg[0] * COAT_F0 + coat.dfg[1];
        terms.coat = light.coat_radiance * reflectance;
    }
    terms
}

/// `aomap_fragment`: the terms where ambient occlusion (0 hidden to 1) takes its share. 1 changes no bit.
#[inline(always)]
pub fn ambient_occlusion<L: Lanes>(
    l: L,
    surface: &Surface<L>,
    terms: &Terms<L>,
    occlusion: L::F,
) -> Terms<L> {
    if occlusion.eq(l.splat(1.0)).all() {
        return *terms;
    }
    let reflected = specular_occlusion(l, surface.n_dot_v, occlusion, surface.roughness);
    Terms {
        diffuse: terms.diffuse * occlusion,
        specular: terms.specular * reflected,
        sheen: terms.sheen * occlusion,
        coat: terms.coat * occlusion,
    }
}

/// The radiance that the fragments reflect of the surroundings, which are the environment alone: no ambient light.
///
/// `irradiance` is that of the environment at a unit normal, `environment` its prefiltered radiance, asked once, or twice
/// with a coat; `occlusion` 0 (hidden) to 1.
#[inline(always)]
pub fn indirect<L: Lanes>(
    l: L,
    surface: &Surface<L>,
    irradiance: impl FnOnce(V3<L>) -> V3<L>,
    environment: impl FnMut(EnvironmentQuery<L>) -> V3<L>,
    occlusion: L::F,
) -> V3<L> {
    let (queries, count) = environment_queries(l, surface);
    let [radiance, coat_radiance] = look_up(l, &queries, count, environment);
    let light =
        Indirect { ambient: Vec3::zero(l), irradiance: irradiance(surface.normal), radiance, coat_radiance };
    let terms = indirect_terms(l, surface, &light);
    outgoing_light(l, surface, &ambient_occlusion(l, surface, &terms, occlusion))
}
