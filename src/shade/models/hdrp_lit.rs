//! Unity HDRP Lit on surface fragments.

use super::super::incident::reflected_radiance;
use super::super::{Reflectance, ShadeContext, Surface};
use super::hdrp_film_thickness;
use crate::brdf::tables;
use crate::coat::hdrp_lit::{
    self, Anisotropy, DirectLighting, EnvironmentQuery, Iridescence, Occlusion, SurfaceData,
};
use crate::gbuffer::layout::SurfacePlanes;
use crate::math::lanes::{Float, Lanes};
use crate::math::vec3::{self, V3};
use crate::scene::Material;

/// Least roughness (alpha) of lights without extent, with which polished surfaces still show a highlight.
const LEAST_LIGHT_ROUGHNESS: f32 = 1.0 / 1024.0;

/// The radiance of sixteen fragments.
#[inline(never)]
pub(in super::super) fn shade<L: Lanes>(
    l: L,
    context: &ShadeContext<'_>,
    material: &Material,
    planes: &SurfacePlanes,
) -> V3<L> {
    l.run(
        #[inline(always)]
        || radiance(l, context, material, &Surface::load(l, material, true, planes)),
    )
}

#[inline(always)]
fn radiance<L: Lanes>(l: L, context: &ShadeContext<'_>, material: &Material, surface: &Surface<L>) -> V3<L> {
    let reflectance = match surface.reflectance {
        Reflectance::Metallic { metallic, dielectric } => {
            hdrp_lit::Reflectance::Metallic { metallic, dielectric_f0: dielectric.weighted_f0(l) }
        }
        Reflectance::Specular { f0 } => hdrp_lit::Reflectance::Specular { color: f0 },
    };
    let lobes = &material.lobes;
    let smoothness = surface.roughness.one_minus();
    let data = SurfaceData {
        base_color: surface.base_color,
        reflectance,
        perceptual_smoothness: smoothness,
        anisotropy: (lobes.anisotropy.strength != 0.0)
            .then_some(Anisotropy { amount: surface.lobes.anisotropy, tangent: surface.tangent }),
        iridescence: (lobes.iridescence.mask.factor > 0.0).then_some(Iridescence {
            mask: surface.lobes.iridescence,
            thickness: hdrp_film_thickness(surface),
        }),
        coat_mask: (material.coat > 0.0).then_some(surface.coat),
        transmittance: None,
    };
    let layers = hdrp_lit::surface(l, tables::unity_fgd(), &data, surface.normal, surface.view);
    let environment = hdrp_lit::environment(
        l,
        &layers,
        #[inline(always)]
        |query: EnvironmentQuery<L>| {
            reflected_radiance(l, context, material, surface, query.direction, query.perceptual_roughness)
        },
    );
    let mut lamps = DirectLighting::none(l);
    for light in context.lights {
        let sample = light.sample(l, surface.position);
        let lit = hdrp_lit::direct(
            l,
            &layers,
            sample.direction,
            sample.irradiance,
            l.splat(LEAST_LIGHT_ROUGHNESS),
        );
        lamps = lamps.plus(l, lit);
    }
    let baked_gi = context.environment.irradiance_over_pi(l, surface.normal);
    let occlusion = Occlusion::of_material(l, &layers, smoothness, surface.occlusion);
    let out =
        hdrp_lit::compose(l, &layers, &lamps, environment, baked_gi, surface.emissive, &occlusion);
    vec3::add(l, out.diffuse, out.specular)
}
