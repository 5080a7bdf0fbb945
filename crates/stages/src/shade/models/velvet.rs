//! Velvet on surface fragments: fibres from the sheen of the material, over its base.

use super::super::Surface;
use super::super::model::{AdditiveModel, Source};
use super::MetallicBase;
use crate::light::LightSample;
use overcoat_core::math::lanes::{Float, Lanes};
use overcoat_core::math::vec3::V3;
use overcoat_scene::Material;
use overcoat_shading::brdf::tables;
use overcoat_shading::brdf::velvet::VelvetAlbedo;
use overcoat_shading::coat::velvet::{self, Specular, SurfaceData};

/// Velvet over Lambert. The GGX lobe is left out where a dielectric states that it reflects nothing (specular 0).
#[derive(Clone, Copy)]
pub(in super::super) struct Velvet;

impl AdditiveModel for Velvet {
    type Layers<L: Lanes> = velvet::Surface<'static, L>;

    fn cost(self) -> [u64; 4] {
        [61, 64, 13, 13]
    }

    #[inline(always)]
    fn layers<L: Lanes>(self, l: L, material: &Material, surface: &Surface<L>) -> Self::Layers<L> {
        let base = MetallicBase::new(l, surface);
        let dielectric = base.weighted_f0();
        let data = SurfaceData {
            base_color: base.color * base.metallic.one_minus(),
            velvet_color: surface.lobes.sheen_color,
            velvet_roughness: surface.lobes.sheen_roughness.squared(),
            specular: (material.specular > 0.0).then_some(Specular {
                f0: dielectric.lerp(base.color, base.metallic),
                perceptual_roughness: surface.roughness,
                anisotropy: surface.lobes.anisotropy,
                direction: surface.tangent,
            }),
        };
        let (albedo, dfg) = (VelvetAlbedo::shared(), tables::filament_dfg());
        velvet::surface(l, &data, surface.normal, surface.view, albedo, dfg)
    }

    #[inline(always)]
    fn direct<L: Lanes>(self, l: L, layers: &Self::Layers<L>, light: &LightSample<L>) -> V3<L> {
        velvet::direct(l, layers, light.direction, light.irradiance)
    }

    #[inline(always)]
    fn indirect<L: Lanes>(self, l: L, layers: &Self::Layers<L>, source: &Source<'_, L>) -> V3<L> {
        velvet::indirect(
            l,
            layers,
            source.irradiance_over_pi(l, source.surface.normal),
            source.radiance_lookup(l),
            source.occlusion(l),
        )
    }
}
