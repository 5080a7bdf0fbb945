//! Velvet on surface fragments: fibres from the sheen of the material, over its base.

use super::super::incident::{Surroundings, add_lights};
use super::super::{ShadeContext, Surface};
use super::MetallicBase;
use crate::brdf::tables;
use crate::brdf::velvet::VelvetAlbedo;
use crate::coat::EnvironmentQuery;
use crate::coat::velvet::{self, Specular, SurfaceData};
use crate::each;
use crate::gbuffer::layout::SurfacePlanes;
use crate::light::LightSample;
use crate::math::lanes::{Float, Lanes};
use crate::math::vec3::{self, V3};
use crate::scene::Material;

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

/// The GGX lobe is left out where a dielectric states that it reflects nothing (specular 0).
#[inline(always)]
fn radiance<L: Lanes>(l: L, context: &ShadeContext<'_>, material: &Material, surface: &Surface<L>) -> V3<L> {
    let base = MetallicBase::new(l, surface);
    let dielectric = base.weighted_f0();
    let data = SurfaceData {
        base_color: vec3::scale(l, base.color, base.metallic.one_minus()),
        velvet_color: surface.lobes.sheen_color,
        velvet_roughness: surface.lobes.sheen_roughness.squared(),
        specular: (material.specular > 0.0).then_some(Specular {
            f0: each!(k => dielectric[k].lerp(base.color[k], base.metallic)),
            perceptual_roughness: surface.roughness,
            anisotropy: surface.lobes.anisotropy,
            direction: surface.tangent,
        }),
    };
    let (albedo, dfg) = (VelvetAlbedo::shared(), tables::filament_dfg());
    let layers = velvet::surface(l, &data, surface.normal, surface.view, albedo, dfg);
    let mut radiance = surface.emissive;
    for &source in Surroundings::of(context) {
        let reflected = velvet::indirect(
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
            velvet::direct(l, &layers, sample.direction, sample.irradiance, l.splat(1.0))
        },
    )
}
