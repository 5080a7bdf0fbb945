//! Light on surfaces: the shading models applied to surface fragments.

use super::incident::{Surroundings, sample_light};
use super::{Reflectance, ShadeContext, Surface, models};
use crate::coat::EnvironmentQuery;
use crate::coat::urp::{self, UrpVersion};
use crate::each;
use crate::gbuffer::layout::SurfacePlanes;
use crate::math::lanes::{Float, Lanes};
use crate::math::vec3::{self, V3};
use crate::scene::{Material, ShadingModel};

/// Largest radiance of a fragment; the sun's disc has 2e9 candela per square metre.
const MAX_RADIANCE: f32 = 1e12;

/// Radiance that sixteen fragments of one material send to the viewer, linear, not multiplied by opacity.
///
/// `surface` holds what [`super::store_surface`] wrote, with the lobes if the model reads them.
#[inline(always)]
pub fn shade<L: Lanes>(
    l: L,
    context: &ShadeContext<'_>,
    model: ShadingModel,
    material: &Material,
    surface: &SurfacePlanes,
) -> V3<L> {
    if material.unlit {
        return Surface::load(l, material, false, surface).base_color;
    }
    let radiance = match model {
        ShadingModel::UrpDesktop | ShadingModel::UrpMobile | ShadingModel::Urp17 => {
            // Versions of one engine are values: a copy of the kernel for each would be that many times the code.
            let version = match model {
                ShadingModel::UrpMobile => UrpVersion::Mobile,
                ShadingModel::Urp17 => UrpVersion::Newest,
                _ => UrpVersion::Desktop,
            };
            return shade_urp(l, context, material, &Surface::load(l, material, false, surface), version);
        }
        ShadingModel::HdrpLit => models::hdrp_lit::shade(l, context, material, surface),
        ShadingModel::StackLit => models::stacklit::shade(l, context, material, surface),
        ShadingModel::Filament
        | ShadingModel::FilamentMobile
        | ShadingModel::FilamentCloth
        | ShadingModel::Filament2018 => models::filament::shade(l, context, model, material, surface),
        ShadingModel::Three | ShadingModel::ThreeLegacy => {
            models::three::shade(l, context, model, material, surface)
        }
        ShadingModel::Gltf | ShadingModel::GltfSampled => {
            models::gltf::shade(l, context, model, material, surface)
        }
        ShadingModel::OpenPbr => models::openpbr::shade(l, context, material, surface),
        ShadingModel::Velvet => models::velvet::shade(l, context, material, surface),
    };
    // Thin films and sheen can make light negative in the engines, whose frame buffers cut it off; and highlights of
    // mirrors under lights without extent know no bound.
    each!(c in radiance => c.clamp_to(0.0, MAX_RADIANCE))
}

/// Unity URP. Its BRDF leaves out the division by pi, so lights come as E / pi and the environment's diffuse light
/// as irradiance / pi.
#[inline(always)]
fn shade_urp<L: Lanes>(
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
        normal: models::has_coat_normal(material).then_some(surface.coat_normal),
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
    for light in context.lights {
        let sample = sample_light(l, light, surface.position);
        let color = vec3::scale(l, sample.irradiance, l.splat(std::f32::consts::FRAC_1_PI));
        let direct = urp::direct(l, &layers, sample.direction, color, l.splat(1.0));
        radiance = vec3::add(l, radiance, direct);
    }
    vec3::add(l, radiance, surface.emissive)
}
