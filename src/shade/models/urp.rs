//! Unity URP on surface fragments. Its BRDF leaves out the division by pi, so lights come as E / pi and the environment's
//! diffuse light as irradiance / pi.

use super::super::incident::{Surroundings, add_lights};
use super::super::{Reflectance, ShadeContext, Surface};
use super::has_coat_normal;
use crate::coat::EnvironmentQuery;
use crate::coat::urp::{self, UrpVersion};
use crate::gbuffer::layout::SurfacePlanes;
use crate::light::LightSample;
use crate::math::lanes::{Float, Lanes};
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
    // Versions of one engine are values: a copy of the kernel for each would be that many times the code.
    let version = match model {
        ShadingModel::UrpMobile => UrpVersion::Mobile,
        ShadingModel::Urp17 => UrpVersion::Newest,
        _ => UrpVersion::Desktop,
    };
    l.run(
        #[inline(always)]
        || radiance(l, context, material, &Surface::load(l, material, false, planes), version),
    )
}

#[inline(always)]
fn radiance<L: Lanes>(
    l: L,
    context: &ShadeContext<'_>,
    material: &Material,
    surface: &Surface<L>,
    version: UrpVersion,
) -> V3<L> {
    let reflectance = match surface.reflectance {
        Reflectance::Metallic { metallic, dielectric } => {
            urp::Reflectance::Metallic { metallic, dielectric_f0: dielectric.weighted_f0(l) }
        }
        Reflectance::Specular { f0 } => urp::Reflectance::Specular { color: f0 },
    };
    let coat = (material.coat > 0.0).then_some(urp::Coat {
        mask: surface.coat,
        smoothness: surface.coat_roughness.one_minus(),
        normal: has_coat_normal(material).then_some(surface.coat_normal),
    });
    let data = urp::SurfaceData {
        albedo: surface.base_color,
        reflectance,
        smoothness: surface.roughness.one_minus(),
        coat,
    };
    let layers = urp::surface(l, version, &data, surface.normal, surface.view);
    let mut radiance = [l.zero(); 3];
    for &source in Surroundings::of(context) {
        let reflected = urp::indirect(
            l,
            &layers,
            source.irradiance_over_pi(l, context, surface, surface.normal),
            #[inline(always)]
            |query: EnvironmentQuery<L>| source.radiance(l, context, material, surface, query),
            source.occlusion(l, surface),
        );
        radiance = vec3::add(l, radiance, reflected);
    }
    radiance = add_lights(
        l,
        context,
        surface,
        radiance,
        #[inline(always)]
        |sample: LightSample<L>| {
            let color = vec3::scale(l, sample.irradiance, l.splat(std::f32::consts::FRAC_1_PI));
            urp::direct(l, &layers, sample.direction, color, l.splat(1.0))
        },
    );
    vec3::add(l, radiance, surface.emissive)
}
