//! The Khronos glTF Sample Renderer's material on surface fragments.

use super::super::incident::{Surroundings, add_lights};
use super::super::{ShadeContext, Surface};
use super::{MetallicBase, stretched};
use crate::brdf::tables;
use crate::coat::gltf::{
    self, Anisotropy, Coat, CoatF0, EnvironmentQuery, Iridescence, Sheen, SurfaceData, Tables,
};
use crate::gbuffer::layout::SurfacePlanes;
use crate::light::LightSample;
use crate::math::lanes::Lanes;
use crate::math::vec3::{self, V3};
use crate::scene::{Material, ShadingModel, Workflow};
use std::f32::consts::PI;

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
        || radiance(l, context, model, material, &Surface::load(l, material, true, planes)),
    )
}

#[inline(always)]
fn radiance<L: Lanes>(
    l: L,
    context: &ShadeContext<'_>,
    model: ShadingModel,
    material: &Material,
    surface: &Surface<L>,
) -> V3<L> {
    let base = MetallicBase::new(l, surface);
    let (lobes, values) = (&material.lobes, &surface.lobes);
    // Index 0 makes F0 that of the specular colour.
    let ior = match material.workflow {
        Workflow::MetallicRoughness { .. } => material.ior,
        Workflow::SpecularGlossiness { .. } => 0.0,
    };
    let (strength, tangent, bitangent) = stretched(l, surface);
    let data = SurfaceData {
        base_color: base.color,
        metallic: base.metallic,
        roughness: surface.roughness,
        ior: l.splat(ior),
        specular_factor: base.weight,
        specular_color: base.specular_color,
        coat: (material.coat > 0.0).then_some(Coat {
            factor: surface.coat,
            roughness: surface.coat_roughness,
            normal: surface.coat_normal,
        }),
        sheen: (lobes.sheen.color.factor != [0.0; 3])
            .then_some(Sheen { color: values.sheen_color, roughness: values.sheen_roughness }),
        iridescence: (lobes.iridescence.mask.factor > 0.0).then_some(Iridescence {
            factor: values.iridescence,
            ior: l.splat(lobes.iridescence.ior),
            thickness: values.iridescence_thickness,
        }),
        // Tangent and bitangent are turned already.
        anisotropy: (lobes.anisotropy.strength != 0.0).then_some(Anisotropy {
            strength,
            direction: [l.splat(1.0), l.zero()],
            tangent,
            bitangent,
            geometric_normal: surface.vertex_normal,
        }),
    };
    let coat_f0 =
        if material.options.gltf_fixed_coat_f0 || ior == 0.0 { CoatF0::Fixed } else { CoatF0::BaseIor };
    let tables = Tables { brdf: tables::khronos(), sheen_albedo: tables::sheen_albedo() };
    let layers = gltf::surface(l, coat_f0, &data, surface.normal, surface.view, tables);
    let mut radiance = vec3::scale(l, surface.emissive, layers.coat_transmittance(l));
    let sampled = model == ShadingModel::GltfSampled;
    if sampled {
        radiance = vec3::add(l, radiance, sampled_environment(l, context, material, surface, &layers));
    }
    for &source in Surroundings::of(context) {
        let source = match (sampled, source) {
            (true, Surroundings::Environment) => continue,
            (true, _) => Surroundings::AreaLightsByFacets,
            (false, source) => source,
        };
        let reflected = gltf::indirect(
            l,
            &layers,
            #[inline(always)]
            |normal: V3<L>| {
                let over_pi = source.irradiance_over_pi(l, context, surface, normal);
                vec3::scale(l, over_pi, l.splat(PI))
            },
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
            gltf::direct(l, &layers, tables.sheen_albedo, sample.direction, sample.irradiance, l.splat(1.0))
        },
    )
}

/// What is reflected of the environment, by samples.
#[inline(never)]
fn sampled_environment<L: Lanes>(
    l: L,
    context: &ShadeContext<'_>,
    material: &Material,
    surface: &Surface<L>,
    layers: &gltf::Surface<L>,
) -> V3<L> {
    let source = Surroundings::Environment;
    l.run(
        #[inline(always)]
        || {
            gltf::indirect_sampled(
                l,
                layers,
                #[inline(always)]
                |normal: V3<L>| {
                    let over_pi = source.irradiance_over_pi(l, context, surface, normal);
                    vec3::scale(l, over_pi, l.splat(PI))
                },
                #[inline(always)]
                |query: EnvironmentQuery<L>| source.radiance(l, context, material, surface, query),
                surface.occlusion,
            )
        },
    )
}
