//! three.js on surface fragments: the physical material of today, and that of older releases.

use super::super::Surface;
use super::super::model::{AdditiveModel, Source};
use super::super::variation::{NormalFilter, NormalFiltering};
use super::{LayersAbove, MetallicBase, stretched};
use crate::light::LightSample;
use overcoat_core::math::lanes::Lanes;
use overcoat_core::math::vec3::V3;
use overcoat_scene::Material;
use overcoat_shading::brdf::tables;
use overcoat_shading::coat::three::{self, Anisotropy, SurfaceData};
use overcoat_shading::coat::three_legacy::{self, LightUnits, ThreeVersion};

/// Largest index of refraction that the material takes.
const LARGEST_IOR: f32 = 2.333;

/// The physical material of today.
#[derive(Clone, Copy)]
pub(in super::super) struct Three;

impl AdditiveModel for Three {
    type Layers<L: Lanes> = three::Surface<L>;

    fn cost(self) -> [u64; 4] {
        [45, 86, 5, 10]
    }

    fn normal_filtering(self) -> NormalFiltering {
        NormalFiltering::Always(NormalFilter::LargestChange { least: three::LEAST_ROUGHNESS })
    }

    #[inline(always)]
    fn layers<L: Lanes>(self, l: L, material: &Material, surface: &Surface<L>) -> Self::Layers<L> {
        let base = MetallicBase::new(l, surface);
        let layers = LayersAbove::new(l, material, surface);
        let (ior, specular_color) = base.index_and_color(LARGEST_IOR);
        let (strength, tangent, bitangent) = stretched(l, surface);
        let data = SurfaceData {
            color: base.color,
            metalness: base.metallic,
            roughness: surface.roughness,
            // The roughness has it already.
            geometry_roughness: l.zero(),
            ior: l.splat(ior),
            specular_intensity: base.weight,
            specular_color,
            coat: layers.coat,
            sheen: layers.sheen,
            iridescence: layers.iridescence,
            // The tangent is turned already.
            anisotropy: (material.lobes.anisotropy.strength != 0.0).then_some(Anisotropy {
                vector: [strength, l.zero()],
                tangent,
                bitangent,
            }),
        };
        three::surface(l, &data, surface.normal, surface.view, tables::three_dfg())
    }

    #[inline(always)]
    fn emission<L: Lanes>(self, l: L, layers: &Self::Layers<L>, surface: &Surface<L>) -> V3<L> {
        surface.emissive * layers.coat_transmittance(l)
    }

    #[inline(always)]
    fn direct<L: Lanes>(self, l: L, layers: &Self::Layers<L>, light: &LightSample<L>) -> V3<L> {
        three::direct(l, layers, light.direction, light.irradiance)
    }

    #[inline(always)]
    fn indirect<L: Lanes>(self, l: L, layers: &Self::Layers<L>, source: &Source<'_, L>) -> V3<L> {
        three::indirect(
            l,
            layers,
            source.irradiance_lookup(l),
            source.radiance_lookup(l),
            source.occlusion(l),
        )
    }
}

/// That of older releases.
#[derive(Clone, Copy)]
pub(in super::super) struct ThreeLegacy;

impl AdditiveModel for ThreeLegacy {
    type Layers<L: Lanes> = three_legacy::Surface<L>;

    fn cost(self) -> [u64; 4] {
        [40, 52, 4, 8]
    }

    fn normal_filtering(self) -> NormalFiltering {
        NormalFiltering::Always(NormalFilter::LargestChange { least: three_legacy::LEAST_ROUGHNESS })
    }

    #[inline(always)]
    fn layers<L: Lanes>(self, l: L, material: &Material, surface: &Surface<L>) -> Self::Layers<L> {
        let base = MetallicBase::new(l, surface);
        // F0 = 0.16 r^2; what lies beyond goes into the tint, which r119 has not.
        let share = base.f0_of_ior / 0.16;
        let (reflectivity, beyond) = if share < 1.0 { (share.sqrt(), 1.0) } else { (1.0, share) };
        let specular_tint = base.specular_color * beyond;
        let version = if material.options.three.r119 { ThreeVersion::R119 } else { ThreeVersion::R131 };
        let data = three_legacy::SurfaceData {
            color: base.color,
            metalness: base.metallic,
            roughness: surface.roughness,
            // The roughness has it already.
            geometry_roughness: l.zero(),
            reflectivity: l.splat(reflectivity),
            specular_intensity: base.weight,
            specular_tint,
            coat: LayersAbove::new(l, material, surface).coat,
            sheen: (material.lobes.sheen.color.factor != [0.0; 3]).then_some(surface.lobes.sheen_color),
        };
        three_legacy::surface(l, version, &data, surface.normal, surface.view)
    }

    #[inline(always)]
    fn direct<L: Lanes>(self, l: L, layers: &Self::Layers<L>, light: &LightSample<L>) -> V3<L> {
        three_legacy::direct(l, LightUnits::Physical, layers, light.direction, light.irradiance)
    }

    #[inline(always)]
    fn indirect<L: Lanes>(self, l: L, layers: &Self::Layers<L>, source: &Source<'_, L>) -> V3<L> {
        three_legacy::indirect(
            l,
            layers,
            source.irradiance_lookup(l),
            source.radiance_lookup(l),
            source.occlusion(l),
        )
    }
}
