//! StackLit repaired on surface fragments.

use super::super::Surface;
use super::super::model::{AdditiveModel, Source};
use super::{MetallicBase, stretched};
use crate::light::LightSample;
use overcoat_core::math::lanes::Lanes;
use overcoat_core::math::vec3::{V3, Vec3};
use overcoat_scene::Material;
use overcoat_shading::brdf::tables;
use overcoat_shading::coat::stacklit_d::{self, Anisotropy, Coat, SurfaceData};

/// StackLit repaired.
#[derive(Clone, Copy)]
pub(in super::super) struct StackLitD;

impl AdditiveModel for StackLitD {
    type Layers<L: Lanes> = stacklit_d::Surface<L>;

    fn cost(self) -> [u64; 4] {
        [50, 85, 6, 15]
    }

    #[inline(always)]
    fn layers<L: Lanes>(self, l: L, material: &Material, surface: &Surface<L>) -> Self::Layers<L> {
        let base = MetallicBase::new(l, surface);
        let given = &material.lobes;
        let (strength, tangent, _) = stretched(l, surface);
        let absorbs = given.coat.thickness.factor > 0.0 && given.coat.extinction != [0.0; 3];
        let brushed = given.anisotropy.strength != 0.0;
        let brushed_coat = material.coat > 0.0 && given.coat.anisotropy != 0.0;
        let data = SurfaceData {
            color: base.color.at_most(1.0),
            metallic: base.metallic,
            roughness: surface.roughness,
            dielectric_f0: base.weighted_f0(),
            dielectric_f90: base.weight,
            coat: (material.coat > 0.0).then_some(Coat {
                mask: surface.coat,
                roughness: surface.coat_roughness,
                ior: l.splat(given.coat.ior),
                depth: absorbs
                    .then_some(Vec3::splat(l, given.coat.extinction) * surface.lobes.coat_thickness),
                normal: surface.coat_normal,
            }),
            trapped_roughness: surface.trapped_roughness,
            anisotropy: (brushed || brushed_coat).then_some(Anisotropy {
                base: strength,
                coat: l.splat(given.coat.anisotropy),
                tangent,
            }),
        };
        stacklit_d::surface(l, &data, surface.normal, surface.view, tables::ggx_albedo())
    }

    #[inline(always)]
    fn emission<L: Lanes>(self, l: L, layers: &Self::Layers<L>, surface: &Surface<L>) -> V3<L> {
        surface.emissive * layers.coat_transmittance(l)
    }

    #[inline(always)]
    fn direct<L: Lanes>(self, l: L, layers: &Self::Layers<L>, light: &LightSample<L>) -> V3<L> {
        stacklit_d::direct(l, layers, light.direction, light.irradiance, tables::ggx_albedo())
    }

    #[inline(always)]
    fn indirect<L: Lanes>(self, l: L, layers: &Self::Layers<L>, source: &Source<'_, L>) -> V3<L> {
        let irradiance_over_pi = source.irradiance_over_pi(l, source.surface.normal);
        stacklit_d::indirect(l, layers, irradiance_over_pi, source.radiance_lookup(l), source.occlusion(l))
    }
}
