//! Filament's models on surface fragments: standard, cloth, and the document of 2018.

use super::super::Surface;
use super::super::model::{AdditiveModel, Source};
use super::super::variation::{NormalFilter, NormalFiltering};
use super::{MetallicBase, has_coat_normal};
use crate::light::LightSample;
use overcoat_core::math::lanes::Lanes;
use overcoat_core::math::vec3::{V3, Vec3};
use overcoat_scene::Material;
use overcoat_shading::brdf::tables;
use overcoat_shading::coat::filament::standard::{Anisotropy, Coat, Sheen, SurfaceData};
use overcoat_shading::coat::filament::{Quality, cloth, standard};
use overcoat_shading::coat::filament_2018::{self, Attenuation};

/// The standard model in a quality.
#[derive(Clone, Copy)]
pub(in super::super) struct Standard(pub(in super::super) Quality);

impl AdditiveModel for Standard {
    type Layers<L: Lanes> = standard::Surface<L>;

    fn cost(self) -> [u64; 4] {
        [43, 70, 4, 7]
    }

    fn normal_filtering(self) -> NormalFiltering {
        NormalFiltering::Asked(NormalFilter::FILAMENT)
    }

    #[inline(always)]
    fn layers<L: Lanes>(self, l: L, material: &Material, surface: &Surface<L>) -> Self::Layers<L> {
        let base = MetallicBase::new(l, surface);
        let lobes = &material.lobes;
        let data = SurfaceData {
            base_color: base.color,
            metallic: base.metallic,
            perceptual_roughness: surface.roughness,
            dielectric_f0: base.weighted_f0(),
            coat: (material.coat > 0.0).then_some(Coat {
                mask: surface.coat,
                perceptual_roughness: surface.coat_roughness,
                normal: (material.has_normal_maps() || has_coat_normal(material))
                    .then_some(surface.coat_normal),
                ior_change: material.options.filament.coat_ior_change,
                roughens_base: true,
                own_sine: material.has_flakes(),
            }),
            anisotropy: (lobes.anisotropy.strength != 0.0).then_some(Anisotropy {
                strength: surface.lobes.anisotropy,
                direction: surface.tangent,
                geometric_normal: surface.vertex_normal,
            }),
            sheen: (lobes.sheen.color.factor != [0.0; 3]).then_some(Sheen {
                color: surface.lobes.sheen_color,
                roughness: surface.lobes.sheen_roughness,
            }),
        };
        let table = tables::filament_dfg();
        standard::surface_with_table(l, self.0, &data, surface.normal, surface.view, table)
    }

    #[inline(always)]
    fn direct<L: Lanes>(self, l: L, layers: &Self::Layers<L>, light: &LightSample<L>) -> V3<L> {
        standard::direct(l, layers, light.direction, light.irradiance)
    }

    #[inline(always)]
    fn indirect<L: Lanes>(self, l: L, layers: &Self::Layers<L>, source: &Source<'_, L>) -> V3<L> {
        standard::indirect(
            l,
            layers,
            source.irradiance_over_pi(l, source.surface.normal),
            source.radiance_lookup(l),
            source.occlusion(l),
        )
    }
}

/// The cloth model, which reads base colour, sheen colour and the base's roughness.
#[derive(Clone, Copy)]
pub(in super::super) struct Cloth;

impl AdditiveModel for Cloth {
    type Layers<L: Lanes> = cloth::Surface<L>;

    fn cost(self) -> [u64; 4] {
        [40, 41, 6, 6]
    }

    fn normal_filtering(self) -> NormalFiltering {
        NormalFiltering::Asked(NormalFilter::FILAMENT)
    }

    #[inline(always)]
    fn layers<L: Lanes>(self, l: L, material: &Material, surface: &Surface<L>) -> Self::Layers<L> {
        let scatters = material.lobes.subsurface.mask.factor > 0.0;
        let subsurface = Vec3::splat(l, material.lobes.subsurface.transmission) * surface.lobes.subsurface;
        let data = cloth::SurfaceData {
            base_color: surface.base_color,
            sheen_color: surface.lobes.sheen_color,
            perceptual_roughness: surface.roughness,
            subsurface_color: scatters.then_some(subsurface),
        };
        let (quality, table) = (Quality::Desktop, tables::filament_dfg());
        cloth::surface_with_table(l, quality, &data, surface.normal, surface.view, table)
    }

    #[inline(always)]
    fn direct<L: Lanes>(self, l: L, layers: &Self::Layers<L>, light: &LightSample<L>) -> V3<L> {
        cloth::direct(l, layers, light.direction, light.irradiance)
    }

    #[inline(always)]
    fn indirect<L: Lanes>(self, l: L, layers: &Self::Layers<L>, source: &Source<'_, L>) -> V3<L> {
        cloth::indirect(
            l,
            layers,
            source.irradiance_over_pi(l, source.surface.normal),
            source.radiance_lookup(l),
            source.occlusion(l),
        )
    }
}

/// The clear coat of the document of 2018.
#[derive(Clone, Copy)]
pub(in super::super) struct Standard2018;

impl AdditiveModel for Standard2018 {
    type Layers<L: Lanes> = (filament_2018::Surface<L>, V3<L>);

    const READS_LOBES: bool = false;

    fn cost(self) -> [u64; 4] {
        [40, 49, 3, 4]
    }

    #[inline(always)]
    fn layers<L: Lanes>(self, l: L, material: &Material, surface: &Surface<L>) -> Self::Layers<L> {
        let base = MetallicBase::new(l, surface);
        let attenuation = if material.options.filament_2018.single_attenuation {
            Attenuation::Later
        } else {
            Attenuation::Code
        };
        let data = filament_2018::SurfaceData {
            base_color: base.color,
            metallic: base.metallic,
            perceptual_roughness: surface.roughness,
            dielectric_f0: base.weighted_f0(),
            coat: (material.coat > 0.0).then_some(filament_2018::Coat {
                mask: surface.coat,
                perceptual_roughness: surface.coat_roughness,
                modify_f0: true,
                attenuation,
            }),
        };
        let layers = filament_2018::surface(l, &data, surface.normal, surface.view);
        let dfg = tables::filament_dfg().fetch(l, layers.n_dot_v, layers.perceptual_roughness);
        (layers, Vec3::from_array(dfg))
    }

    #[inline(always)]
    fn direct<L: Lanes>(self, l: L, layers: &Self::Layers<L>, light: &LightSample<L>) -> V3<L> {
        filament_2018::direct(l, &layers.0, light.direction, light.irradiance)
    }

    #[inline(always)]
    fn indirect<L: Lanes>(self, l: L, layers: &Self::Layers<L>, source: &Source<'_, L>) -> V3<L> {
        filament_2018::indirect(
            l,
            &layers.0,
            layers.1,
            source.irradiance_over_pi(l, source.surface.normal),
            source.radiance_lookup(l),
            source.occlusion(l),
        )
    }
}
