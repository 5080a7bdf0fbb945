//! The environment.

use super::{EnvironmentQuery, SheenSurface, Surface, Terms, color, dielectric_and_metal};
use crate::brdf::microfacet::schlick_weight;
use crate::coat::glsl::{mix, normalize_or};
use crate::coat::look_up;
use overcoat_core::math::lanes::{Float, Lanes, Mask};
use overcoat_core::math::vec3::{V3, Vec3};
use overcoat_core::vec3;
use std::f32::consts::FRAC_1_PI;

/// Lookups of base, coat and sheen in the prefiltered environment.
#[derive(Clone, Copy)]
pub struct EnvironmentQueries<L: Lanes> {
    /// The first `count` are in use: base, coat and sheen in this order without gaps.
    pub queries: [EnvironmentQuery<L>; 3],
    /// Number of lookups in use, 1 to 3.
    pub count: usize,
    /// Index of the sheen's lookup, if there is one.
    pub sheen: usize,
}

/// The mirrored view.
#[inline(always)]
fn query<L: Lanes>(_: L, view: V3<L>, normal: V3<L>, roughness: L::F) -> EnvironmentQuery<L> {
    EnvironmentQuery { direction: (-view).reflect(normal), perceptual_roughness: roughness }
}

/// Environment lookup of the sheen.
#[inline(always)]
pub(super) fn sheen_query<L: Lanes>(
    l: L,
    surface: &Surface<L>,
    sheen: &SheenSurface<L>,
) -> EnvironmentQuery<L> {
    query(l, surface.view, surface.normal, sheen.roughness)
}

/// Environment lookups of base, coat and sheen.
#[inline(always)]
pub fn environment_queries<L: Lanes>(l: L, surface: &Surface<L>) -> EnvironmentQueries<L> {
    let mut normal = surface.normal;
    if let Some(anisotropy) = &surface.anisotropy {
        // `getIBLRadianceAnisotropy`. The first vector is not of unit length, as in the original.
        let b = anisotropy.bitangent;
        let across = b.cross(surface.view).cross(b);
        let bend = (anisotropy.strength * surface.roughness.one_minus()).one_minus();
        let bend2 = bend * bend;
        normal = normalize_or(l, mix(l, across, normal, bend2 * bend2), normal);
    }
    let base = query(l, surface.view, normal, surface.roughness);
    let mut all = EnvironmentQueries { queries: [base; 3], count: 1, sheen: 1 };
    if let Some(coat) = &surface.coat {
        all.queries[1] = query(l, surface.view, coat.normal, coat.roughness);
        (all.count, all.sheen) = (2, 2);
    }
    if let Some(sheen) = &surface.sheen {
        all.queries[all.sheen] = sheen_query(l, surface, sheen);
        all.count += 1;
    }
    all
}

/// Light of the environment at the fragments.
#[derive(Clone, Copy)]
pub struct Environment<L: Lanes> {
    /// Irradiance at the base normal.
    pub irradiance: V3<L>,
    /// Radiance for the base.
    pub radiance: V3<L>,
    /// Radiance for the coat; of no effect where there is none.
    pub coat_radiance: V3<L>,
    /// Radiance for the sheen; of no effect where there is none.
    pub sheen_radiance: V3<L>,
}

/// `getIBLGGXFresnel`: reflectance for prefiltered radiance (`ggx`: scale and bias of [`super::Tables::brdf`]), with
/// the light of further bounces between the microfacets. Fdez-Aguera, "A Multiple-Scattering Microfacet Model for
/// Real-Time Image-based Lighting" (JCGT 2019).
#[inline(always)]
pub fn ibl_ggx_fresnel<L: Lanes>(
    l: L,
    [scale, bias]: [L::F; 2],
    n_dot_v: L::F,
    roughness: L::F,
    f0: V3<L>,
    specular_weight: L::F,
) -> V3<L> {
    let weight = schlick_weight(l, n_dot_v);
    let smooth = roughness.one_minus();
    let missing = (scale + bias).one_minus();
    let fresnel = f0 + (Vec3::uniform(smooth).max(f0) - f0) * weight;
    let single = (fresnel * scale + bias) * specular_weight;
    let mean = (f0 + f0.one_minus() / 21.0) * specular_weight;
    let divisor = (mean * missing).one_minus();
    // Only where the tables say that nothing is reflected once.
    let divisor = vec3!(d in divisor => d.eq(l.zero()).select(l.splat(1.0), d));
    single + single * missing * mean / divisor
}

/// Environment light by lobe, and the Fresnel reflectances.
#[derive(Clone, Copy)]
pub struct Indirect<L: Lanes> {
    /// The lobes.
    pub terms: Terms<L>,
    /// Fresnel reflectance of the dielectric.
    pub dielectric_fresnel: V3<L>,
    /// Fresnel reflectance of the metal.
    pub metal_fresnel: V3<L>,
}

/// Environment light that each lobe reflects.
#[inline(always)]
pub fn indirect_terms<L: Lanes>(l: L, surface: &Surface<L>, environment: &Environment<L>) -> Indirect<L> {
    let one = l.splat(1.0);
    let diffuse = environment.irradiance * FRAC_1_PI * surface.base_color;
    let specular = environment.radiance;
    let (ggx, n_dot_v, roughness) = (surface.ggx, surface.n_dot_v, surface.roughness);
    let dielectric_fresnel =
        ibl_ggx_fresnel(l, ggx, n_dot_v, roughness, surface.f0_dielectric, surface.specular_weight);
    let metal_fresnel = ibl_ggx_fresnel(l, ggx, n_dot_v, roughness, surface.base_color, one);
    let [dielectric, metal] =
        dielectric_and_metal(l, surface, [diffuse, specular], [dielectric_fresnel, metal_fresnel]);
    let (sheen, sheen_scaling) = match &surface.sheen {
        Some(sheen) => {
            let reflected = environment.sheen_radiance * (sheen.color * sheen.charlie);
            (reflected, sheen.scaling)
        }
        None => (Vec3::zero(l), one),
    };
    let coat = environment.coat_radiance;
    let terms = Terms { diffuse, specular, metal, dielectric, sheen, sheen_scaling, coat };
    Indirect { terms, dielectric_fresnel, metal_fresnel }
}

/// The radiance that the fragments reflect of the environment.
///
/// `irradiance` is that of the environment at a unit normal, `environment` its prefiltered radiance, asked once, and
/// once more for a coat, `sheen` the same prefiltered for cloth; `occlusion` 0 (hidden) to 1.
#[inline(always)]
pub fn indirect<L: Lanes>(
    l: L,
    surface: &Surface<L>,
    irradiance: impl FnOnce(V3<L>) -> V3<L>,
    environment: impl FnMut(EnvironmentQuery<L>) -> V3<L>,
    sheen: impl FnOnce(EnvironmentQuery<L>) -> V3<L>,
    occlusion: L::F,
) -> V3<L> {
    let all = environment_queries(l, surface);
    // The sheen's is the last.
    let radiance = look_up(l, &all.queries, all.sheen, environment);
    let sheen_radiance = if surface.sheen.is_some() { sheen(all.queries[all.sheen]) } else { Vec3::zero(l) };
    let environment = Environment {
        irradiance: irradiance(surface.normal),
        radiance: radiance[0],
        coat_radiance: radiance[1],
        sheen_radiance,
    };
    let indirect = indirect_terms(l, surface, &environment);
    color(l, surface, &indirect.terms) * occlusion
}
