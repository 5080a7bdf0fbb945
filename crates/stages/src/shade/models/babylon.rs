//! Babylon.js' physically based material on surface fragments.

use super::super::Surface;
use super::super::model::{AdditiveModel, Source};
use super::{MetallicBase, stretched};
use crate::light::LightSample;
use overcoat_core::math::exp;
use overcoat_core::math::lanes::Lanes;
use overcoat_core::math::vec3::{V3, Vec3};
use overcoat_core::vec3;
use overcoat_scene::{CoatMedium, Material};
use overcoat_shading::brdf::tables;
use overcoat_shading::coat::babylon::{self, Anisotropy, Coat, Options, SurfaceData, Tint};

/// Largest index of refraction that the material takes.
const LARGEST_IOR: f32 = 3.0;

/// `PBRMaterial`.
#[derive(Clone, Copy)]
pub(in super::super) struct Babylon;

impl AdditiveModel for Babylon {
    type Layers<L: Lanes> = babylon::Surface<L>;

    fn cost(self) -> [u64; 4] {
        [45, 72, 6, 10]
    }

    #[inline(always)]
    fn layers<L: Lanes>(self, l: L, material: &Material, surface: &Surface<L>) -> Self::Layers<L> {
        let base = MetallicBase::new(l, surface);
        let (ior, specular_color) = base.index_and_color(LARGEST_IOR);
        let (strength, tangent, bitangent) = stretched(l, surface);
        let data = SurfaceData {
            base_color: base.color,
            metallic: base.metallic,
            roughness: surface.roughness,
            ior: l.splat(ior),
            specular_weight: base.weight,
            specular_color,
            diffuse_roughness: l.zero(),
            normal_slope: None,
            geometric_normal: surface.vertex_normal,
            normal_mapped: material.normal_texture.is_some(),
            coat: if material.coat > 0.0 {
                Some(Coat {
                    intensity: surface.coat,
                    roughness: surface.coat_roughness,
                    ior: l.splat(material.lobes.coat.ior),
                    normal: surface.coat_normal,
                    normal_slope: None,
                    remaps_f0: material.options.babylon.remap_f0,
                    tint: tint(l, material, surface),
                })
            } else {
                None
            },
            anisotropy: (material.lobes.anisotropy.strength != 0.0).then_some(Anisotropy {
                // The tangent is turned already.
                intensity: strength,
                direction: [l.splat(1.0), l.zero()],
                tangent,
                bitangent,
            }),
        };
        let albedos = Some(tables::ggx_albedo());
        babylon::surface(l, &Options::default(), &data, surface.normal, surface.view, albedos)
    }

    #[inline(always)]
    fn direct<L: Lanes>(self, l: L, layers: &Self::Layers<L>, light: &LightSample<L>) -> V3<L> {
        // Lights have no extent here: what the engine's default adds to the roughness is 1e-5 over the distance.
        babylon::direct(l, layers, light.direction, light.irradiance, l.zero())
    }

    #[inline(always)]
    fn indirect<L: Lanes>(self, l: L, layers: &Self::Layers<L>, source: &Source<'_, L>) -> V3<L> {
        babylon::indirect(
            l,
            layers,
            #[inline(always)]
            |normal: V3<L>| source.irradiance_over_pi(l, normal),
            source.radiance_lookup(l),
            source.occlusion(l),
        )
    }
}

/// Transmittance of the coat's medium for light that crosses it once, straight, as Babylon's tint at its distance of 1.
/// The material's colour is that of crossing it twice.
#[inline(always)]
fn tint<L: Lanes>(l: L, material: &Material, surface: &Surface<L>) -> Option<Tint<L>> {
    let CoatMedium { color, thickness, extinction, .. } = &material.lobes.coat;
    let absorbs = thickness.factor > 0.0 && *extinction != [0.0; 3];
    if !absorbs && color.factor == [1.0; 3] {
        return None;
    }
    let values = &surface.lobes;
    let one = l.splat(1.0);
    let mut color = values.coat_color.sqrt();
    if absorbs {
        color *= vec3!(e in Vec3::from_array(*extinction) => exp(l, values.coat_thickness * -e));
    }
    Some(Tint { color, at_distance: one, thickness: one })
}
