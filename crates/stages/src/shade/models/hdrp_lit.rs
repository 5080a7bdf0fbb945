//! Unity HDRP Lit on surface fragments.

use super::super::model::{Model, Source};
use super::super::{Reflectance, Surface};
use super::hdrp_film_thickness;
use crate::light::LightSample;
use overcoat_core::math::lanes::{Float, Lanes};
use overcoat_core::math::vec3::{V3, Vec3};
use overcoat_scene::Material;
use overcoat_shading::brdf::tables;
use overcoat_shading::coat::hdrp_lit::{
    self, Anisotropy, DirectLighting, EnvironmentQuery, Iridescence, Occlusion, SurfaceData,
};

/// Least roughness (alpha) of lights without extent, with which polished surfaces still show a highlight.
const LEAST_LIGHT_ROUGHNESS: f32 = 1.0 / 1024.0;

/// Perceptual roughness of the coat (`CLEAR_COAT_PERCEPTUAL_ROUGHNESS`).
const COAT_PERCEPTUAL_ROUGHNESS: f32 = 0.1;

/// HDRP Lit.
#[derive(Clone, Copy)]
pub(in super::super) struct HdrpLit;

/// Lights are composed with the environment (`PostEvaluateBSDF`), area lights by themselves.
pub(in super::super) struct Sum<L: Lanes> {
    lamps: DirectLighting<L>,
    radiance: V3<L>,
}

impl Model for HdrpLit {
    type Layers<L: Lanes> = hdrp_lit::Surface<L>;
    type Sum<L: Lanes> = Sum<L>;
    const LIGHTS_FIRST: bool = true;

    fn cost(self) -> [u64; 4] {
        [51, 76, 4, 5]
    }

    #[inline(always)]
    fn layers<L: Lanes>(self, l: L, material: &Material, surface: &Surface<L>) -> Self::Layers<L> {
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
                .then_some(Anisotropy { strength: surface.lobes.anisotropy, tangent: surface.tangent }),
            iridescence: (lobes.iridescence.mask.factor > 0.0).then_some(Iridescence {
                mask: surface.lobes.iridescence,
                thickness: hdrp_film_thickness(surface),
            }),
            coat_mask: (material.coat > 0.0).then_some(surface.coat),
            transmittance: None,
        };
        hdrp_lit::surface(l, tables::unity_fgd(), &data, surface.normal, surface.view)
    }

    #[inline(always)]
    fn begin<L: Lanes>(self, l: L, _: &Self::Layers<L>, _: &Surface<L>) -> Sum<L> {
        Sum { lamps: DirectLighting::none(l), radiance: Vec3::zero(l) }
    }

    #[inline(always)]
    fn direct<L: Lanes>(self, l: L, layers: &Self::Layers<L>, light: &LightSample<L>, sum: Sum<L>) -> Sum<L> {
        let roughness = l.splat(LEAST_LIGHT_ROUGHNESS);
        let lit = hdrp_lit::direct(l, layers, light.direction, light.irradiance, roughness);
        Sum { lamps: sum.lamps.plus(lit), ..sum }
    }

    #[inline(always)]
    fn indirect<L: Lanes>(
        self,
        l: L,
        layers: &Self::Layers<L>,
        source: &Source<'_, L>,
        sum: Sum<L>,
    ) -> Sum<L> {
        let (surface, far) = (source.surface, source.is_environment());
        let reflected = hdrp_lit::environment(
            l,
            layers,
            #[inline(always)]
            |query: EnvironmentQuery<L>| {
                // The environment is mirrored as it is, area lights by the coat's roughness (`ltcTransformCoat`).
                let p = query.perceptual_roughness;
                let perceptual_roughness = if far { p } else { p.at_least(COAT_PERCEPTUAL_ROUGHNESS) };
                source.radiance(l, EnvironmentQuery { perceptual_roughness, ..query })
            },
        );
        let mut baked = source.irradiance_over_pi(l, surface.normal);
        if let (Some(coat), false) = (&layers.pre.coat, far) {
            // `EvaluateBSDF_Rect` dims diffuse light under the coat, which baked light is not.
            baked *= coat.ibl_f.one_minus();
        }
        let emissive = if far { surface.emissive } else { Vec3::zero(l) };
        let lamps = if far { sum.lamps } else { DirectLighting::none(l) };
        let smoothness = surface.roughness.one_minus();
        let occlusion = Occlusion::of_material(l, layers, smoothness, source.occlusion(l));
        let out = hdrp_lit::compose(l, layers, &lamps, reflected, baked, emissive, &occlusion);
        let composed = out.diffuse + out.specular;
        Sum { radiance: sum.radiance + composed, ..sum }
    }

    #[inline(always)]
    fn finish<L: Lanes>(self, _: L, _: &Self::Layers<L>, _: &Surface<L>, sum: Sum<L>) -> V3<L> {
        sum.radiance
    }
}
