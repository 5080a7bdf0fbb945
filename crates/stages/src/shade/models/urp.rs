//! Unity URP on surface fragments. Its BRDF leaves out the division by pi, so lights come as E / pi and the environment's
//! diffuse light as irradiance / pi.

use super::super::model::{AdditiveModel, Source};
use super::super::{Reflectance, Surface};
use super::has_coat_normal;
use crate::light::LightSample;
use overcoat_core::math::lanes::{Float, Lanes};
use overcoat_core::math::vec3::V3;
use overcoat_scene::Material;
use overcoat_shading::coat::urp::{self, UrpVersion};
use std::f32::consts::FRAC_1_PI;

/// A version of URP.
#[derive(Clone, Copy)]
pub(in super::super) struct Urp(pub(in super::super) UrpVersion);

impl AdditiveModel for Urp {
    type Layers<L: Lanes> = urp::Surface<L>;
    const READS_LOBES: bool = false;
    /// As in `UniversalFragmentPBR`.
    const EMISSION_LAST: bool = true;

    fn cost(self) -> [u64; 4] {
        [34, 43, 3, 3]
    }

    #[inline(always)]
    fn layers<L: Lanes>(self, l: L, material: &Material, surface: &Surface<L>) -> urp::Surface<L> {
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
        urp::surface(l, self.0, &data, surface.normal, surface.view)
    }

    #[inline(always)]
    fn direct<L: Lanes>(self, l: L, layers: &urp::Surface<L>, light: &LightSample<L>) -> V3<L> {
        let color = light.irradiance * FRAC_1_PI;
        urp::direct(l, layers, light.direction, color)
    }

    #[inline(always)]
    fn indirect<L: Lanes>(self, l: L, layers: &urp::Surface<L>, source: &Source<'_, L>) -> V3<L> {
        urp::indirect(
            l,
            layers,
            source.irradiance_over_pi(l, source.surface.normal),
            source.radiance_lookup(l),
            source.occlusion(l),
        )
    }
}
