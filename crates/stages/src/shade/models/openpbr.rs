//! OpenPBR on surface fragments.

use super::super::model::{AdditiveModel, Source};
use super::super::{Reflectance, Surface};
use super::{has_coat_normal, stretched};
use crate::light::LightSample;
use overcoat_core::math::lanes::{Float, Lanes, Mask};
use overcoat_core::math::vec3::V3;
use overcoat_scene::Material;
use overcoat_shading::brdf::tables;
use overcoat_shading::coat::openpbr::{self, AlbedoSource, Coat, SurfaceData};

/// Largest index of refraction of the base.
const LARGEST_IOR: f32 = 3.0;

/// OpenPBR 1.1.
#[derive(Clone, Copy)]
pub(in super::super) struct OpenPbr;

impl AdditiveModel for OpenPbr {
    type Layers<L: Lanes> = openpbr::Surface<L>;

    fn cost(self) -> [u64; 4] {
        [73, 77, 15, 15]
    }

    #[inline(always)]
    fn layers<L: Lanes>(self, l: L, material: &Material, surface: &Surface<L>) -> Self::Layers<L> {
        let (metalness, specular_weight, specular_color, ior) = reflectance(l, material, surface);
        let (given, values) = (&material.lobes, &surface.lobes);
        let (strength, tangent, _) = stretched(l, surface);
        let data = SurfaceData {
            base_weight: l.splat(1.0),
            base_color: surface.base_color.at_most(1.0),
            metalness,
            specular_weight,
            specular_color,
            roughness: surface.roughness,
            anisotropy: strength,
            ior,
            coat: (material.coat > 0.0).then_some(Coat {
                weight: surface.coat,
                color: values.coat_color,
                roughness: surface.coat_roughness,
                anisotropy: l.splat(given.coat.anisotropy),
                ior: l.splat(given.coat.ior),
                darkening: l.splat(given.coat.darkening),
                normal: has_coat_normal(material).then_some(surface.coat_normal),
            }),
            invert_ratio: true,
            single_scattering: material.options.openpbr.single_scattering,
            trapped_roughness: surface.trapped_roughness,
        };
        let albedos = AlbedoSource::Table(tables::ggx_albedo());
        openpbr::surface(l, &data, surface.normal, tangent, surface.view, albedos)
    }

    #[inline(always)]
    fn direct<L: Lanes>(self, l: L, layers: &Self::Layers<L>, light: &LightSample<L>) -> V3<L> {
        openpbr::direct(l, layers, light.direction, light.irradiance)
    }

    #[inline(always)]
    fn indirect<L: Lanes>(self, l: L, layers: &Self::Layers<L>, source: &Source<'_, L>) -> V3<L> {
        openpbr::indirect(
            l,
            layers,
            source.irradiance_over_pi(l, source.surface.normal),
            source.radiance_lookup(l),
            source.occlusion(l),
        )
    }
}

/// Metalness, specular weight, specular colour and index of refraction. The specular workflow becomes a dielectric with
/// the index of the largest channel of F0.
#[inline(always)]
fn reflectance<L: Lanes>(l: L, material: &Material, surface: &Surface<L>) -> (L::F, L::F, V3<L>, L::F) {
    match surface.reflectance {
        Reflectance::Metallic { metallic, dielectric } => {
            let ior =
                if material.ior == 0.0 || material.ior > LARGEST_IOR { LARGEST_IOR } else { material.ior };
            let color = dielectric.color.at_most(1.0);
            (metallic, dielectric.weight, color, l.splat(ior))
        }
        Reflectance::Specular { f0 } => {
            let largest = f0.max_component();
            let root = largest.clamp_to(0.0, 0.25).sqrt();
            let ior = (root + 1.0) / root.one_minus();
            let black = largest.eq(l.zero());
            let divisor = black.select(l.splat(1.0), largest);
            (l.zero(), l.splat(1.0), f0 / divisor, ior)
        }
    }
}
