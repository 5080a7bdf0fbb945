//! Filament's models on surface fragments: standard, cloth, and the document of 2018.

use super::super::incident::{Surroundings, add_lights};
use super::super::{ShadeContext, Surface};
use super::MetallicBase;
use crate::brdf::tables;
use crate::coat::filament::standard::{Anisotropy, Coat, EnvironmentQuery, Sheen, SurfaceData};
use crate::coat::filament::{Quality, cloth, standard};
use crate::coat::filament_2018::{self, Attenuation};
use crate::gbuffer::layout::SurfacePlanes;
use crate::light::LightSample;
use crate::math::lanes::Lanes;
use crate::math::vec3::{self, V3};
use crate::scene::{Material, ShadingModel};

/// The radiance of sixteen fragments.
#[inline(never)]
pub(in super::super) fn shade<L: Lanes>(
    l: L,
    context: &ShadeContext<'_>,
    model: ShadingModel,
    material: &Material,
    planes: &SurfacePlanes,
) -> V3<L> {
    l.run(
        #[inline(always)]
        || {
            let surface = Surface::load(l, material, true, planes);
            match model {
                ShadingModel::FilamentCloth => cloth_radiance(l, context, material, &surface),
                ShadingModel::Filament2018 => radiance_2018(l, context, material, &surface),
                // The quality is a value: one copy of the kernel for both.
                _ => {
                    let mobile = model == ShadingModel::FilamentMobile;
                    let quality = if mobile { Quality::Mobile } else { Quality::Desktop };
                    standard_radiance(l, context, quality, material, &surface)
                }
            }
        },
    )
}

#[inline(always)]
fn standard_radiance<L: Lanes>(
    l: L,
    context: &ShadeContext<'_>,
    quality: Quality,
    material: &Material,
    surface: &Surface<L>,
) -> V3<L> {
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
            normal: material.has_normal_maps().then_some(surface.coat_normal),
            ior_change: true,
            roughens_base: true,
        }),
        anisotropy: (lobes.anisotropy.strength != 0.0).then_some(Anisotropy {
            strength: surface.lobes.anisotropy,
            direction: surface.tangent,
            geometric_normal: surface.vertex_normal,
        }),
        sheen: (lobes.sheen.color.factor != [0.0; 3]).then_some(Sheen {
            color: surface.lobes.sheen_color,
            perceptual_roughness: surface.lobes.sheen_roughness,
        }),
    };
    let table = tables::filament_dfg();
    let layers = standard::surface_with_table(l, quality, &data, surface.normal, surface.view, table);
    let mut radiance = surface.emissive;
    for &source in Surroundings::of(context) {
        let reflected = standard::indirect(
            l,
            &layers,
            source.irradiance_over_pi(l, context, surface, surface.normal),
            #[inline(always)]
            |query: EnvironmentQuery<L>| source.radiance(l, context, material, surface, query),
            source.occlusion(l, surface),
        );
        radiance = vec3::add(l, radiance, reflected);
    }
    add_lights(
        l,
        context,
        surface,
        radiance,
        #[inline(always)]
        |sample: LightSample<L>| {
            standard::direct(l, &layers, sample.direction, sample.irradiance, l.splat(1.0))
        },
    )
}

/// The cloth model reads base colour, sheen colour and the base's roughness.
#[inline(always)]
fn cloth_radiance<L: Lanes>(
    l: L,
    context: &ShadeContext<'_>,
    material: &Material,
    surface: &Surface<L>,
) -> V3<L> {
    let scatters = material.lobes.subsurface.mask.factor > 0.0;
    let subsurface =
        vec3::scale(l, vec3::splat(l, material.lobes.subsurface.transmission), surface.lobes.subsurface);
    let data = cloth::SurfaceData {
        base_color: surface.base_color,
        sheen_color: surface.lobes.sheen_color,
        perceptual_roughness: surface.roughness,
        subsurface_color: scatters.then_some(subsurface),
    };
    let (quality, table) = (Quality::Desktop, tables::filament_dfg());
    let layers = cloth::surface_with_table(l, quality, &data, surface.normal, surface.view, table);
    let mut radiance = surface.emissive;
    for &source in Surroundings::of(context) {
        let reflected = cloth::indirect(
            l,
            &layers,
            source.irradiance_over_pi(l, context, surface, surface.normal),
            #[inline(always)]
            |query: EnvironmentQuery<L>| source.radiance(l, context, material, surface, query),
            source.occlusion(l, surface),
        );
        radiance = vec3::add(l, radiance, reflected);
    }
    add_lights(
        l,
        context,
        surface,
        radiance,
        #[inline(always)]
        |sample: LightSample<L>| cloth::direct(l, &layers, sample.direction, sample.irradiance, l.splat(1.0)),
    )
}

#[inline(always)]
fn radiance_2018<L: Lanes>(
    l: L,
    context: &ShadeContext<'_>,
    material: &Material,
    surface: &Surface<L>,
) -> V3<L> {
    let base = MetallicBase::new(l, surface);
    let attenuation = if material.options.filament_2018_single_attenuation {
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
    let mut radiance = surface.emissive;
    for &source in Surroundings::of(context) {
        let reflected = filament_2018::indirect(
            l,
            &layers,
            dfg,
            source.irradiance_over_pi(l, context, surface, surface.normal),
            #[inline(always)]
            |query: EnvironmentQuery<L>| source.radiance(l, context, material, surface, query),
            source.occlusion(l, surface),
        );
        radiance = vec3::add(l, radiance, reflected);
    }
    add_lights(
        l,
        context,
        surface,
        radiance,
        #[inline(always)]
        |sample: LightSample<L>| {
            filament_2018::direct(l, &layers, sample.direction, sample.irradiance, l.splat(1.0))
        },
    )
}
