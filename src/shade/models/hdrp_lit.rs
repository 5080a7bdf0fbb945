//! Unity HDRP Lit on surface fragments.

use super::super::incident::{Surroundings, sample_light};
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

/// Perceptual roughness of the coat (`CLEAR_COAT_PERCEPTUAL_ROUGHNESS`).
const COAT_PERCEPTUAL_ROUGHNESS: f32 = 0.1;

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
    let mut lamps = DirectLighting::none(l);
    for light in context.lights {
        let sample = sample_light(l, light, surface.position);
        let lit =
            hdrp_lit::direct(l, &layers, sample.direction, sample.irradiance, l.splat(LEAST_LIGHT_ROUGHNESS));
        lamps = lamps.plus(l, lit);
    }
    let mut sum = [l.zero(); 3];
    for &source in Surroundings::of(context) {
        let far = source == Surroundings::Environment;
        let reflected = hdrp_lit::environment(
            l,
            &layers,
            #[inline(always)]
            |query: EnvironmentQuery<L>| {
                // The environment is mirrored as it is, area lights by the coat's roughness (`ltcTransformCoat`).
                let p = query.perceptual_roughness;
                let perceptual_roughness = if far { p } else { p.at_least(COAT_PERCEPTUAL_ROUGHNESS) };
                let query = EnvironmentQuery { perceptual_roughness, ..query };
                source.radiance(l, context, material, surface, query)
            },
        );
        let mut baked = source.irradiance_over_pi(l, context, surface, surface.normal);
        if let (Some(coat), false) = (&layers.pre.coat, far) {
            // `EvaluateBSDF_Rect` dims diffuse light under the coat, which baked light is not.
            baked = vec3::scale(l, baked, coat.ibl_f.one_minus());
        }
        let emissive = if far { surface.emissive } else { [l.zero(); 3] };
        let lamps = if far { lamps } else { DirectLighting::none(l) };
        let occlusion = Occlusion::of_material(l, &layers, smoothness, source.occlusion(l, surface));
        let out = hdrp_lit::compose(l, &layers, &lamps, reflected, baked, emissive, &occlusion);
        sum = vec3::add(l, sum, vec3::add(l, out.diffuse, out.specular));
    }
    sum
}
