//! The model of the house on surface fragments.

use super::super::Surface;
use super::super::model::{AdditiveModel, Source};
use super::{LayersAbove, MetallicBase, stretched};
use crate::light::LightSample;
use overcoat_core::math::lanes::Lanes;
use overcoat_core::math::vec3::V3;
use overcoat_scene::Material;
use overcoat_shading::brdf::tables;
use overcoat_shading::coat::standard::{self, Anisotropy, Environment, SurfaceData, Tables};

/// The standard model.
#[derive(Clone, Copy)]
pub(in super::super) struct Standard;

impl AdditiveModel for Standard {
    type Layers<L: Lanes> = standard::Surface<L>;

    fn cost(self) -> [u64; 4] {
        [82, 290, 5, 10]
    }

    #[inline(always)]
    fn layers<L: Lanes>(self, l: L, material: &Material, surface: &Surface<L>) -> Self::Layers<L> {
        let base = MetallicBase::new(l, surface);
        let layers = LayersAbove::new(l, material, surface);
        let (strength, tangent, _) = stretched(l, surface);
        let data = SurfaceData {
            color: base.color,
            metallic: base.metallic,
            roughness: surface.roughness,
            dielectric_f0: base.weighted_f0(),
            dielectric_f90: base.weight,
            coat: layers.coat,
            coat_color: (material.lobes.coat.color.factor != [1.0; 3]).then_some(surface.lobes.coat_color),
            coat_darkening: (material.lobes.coat.darkening != 0.0)
                .then(|| l.splat(material.lobes.coat.darkening)),
            trapped_roughness: surface.trapped_roughness,
            sheen: layers.sheen,
            iridescence: layers.iridescence,
            anisotropy: (material.lobes.anisotropy.strength != 0.0)
                .then_some(Anisotropy { strength, tangent }),
        };
        let tables = Tables { ggx: tables::ggx_albedo(), cloth: tables::filament_dfg() };
        standard::surface(l, &data, surface.normal, surface.view, tables)
    }

    #[inline(always)]
    fn emission<L: Lanes>(self, l: L, layers: &Self::Layers<L>, surface: &Surface<L>) -> V3<L> {
        layers.above_coat(l, surface.emissive)
    }

    #[inline(always)]
    fn direct<L: Lanes>(self, l: L, layers: &Self::Layers<L>, light: &LightSample<L>) -> V3<L> {
        standard::direct(l, layers, light.direction, light.irradiance)
    }

    #[inline(always)]
    fn indirect<L: Lanes>(self, l: L, layers: &Self::Layers<L>, source: &Source<'_, L>) -> V3<L> {
        let kind = if source.is_environment() { Environment::Distant } else { Environment::Near };
        let irradiance_over_pi = source.irradiance_over_pi(l, source.surface.normal);
        let radiance = source.radiance_lookup(l);
        standard::indirect(l, layers, kind, irradiance_over_pi, radiance, source.occlusion(l))
    }
}
