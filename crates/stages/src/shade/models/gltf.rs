//! The Khronos glTF Sample Renderer's material on surface fragments.

use super::super::Surface;
use super::super::model::{AdditiveModel, Source};
use super::{LayersAbove, MetallicBase, stretched};
use crate::light::LightSample;
use overcoat_core::math::lanes::Lanes;
use overcoat_core::math::vec3::V3;
use overcoat_scene::{Material, Workflow};
use overcoat_shading::brdf::table::Table;
use overcoat_shading::brdf::tables;
use overcoat_shading::coat::gltf::{self, Anisotropy, CoatF0, Scattering, SurfaceData, Tables};

/// The Sample Renderer's material.
#[derive(Clone, Copy)]
pub(in super::super) struct Gltf {
    /// The environment's reflections are summed over samples.
    pub(in super::super) sampled: bool,
}

impl AdditiveModel for Gltf {
    type Layers<L: Lanes> = (gltf::Surface<L>, &'static Table<1>);

    fn cost(self) -> [u64; 4] {
        if self.sampled { [233, 466, 5, 17] } else { [52, 107, 5, 17] }
    }

    #[inline(always)]
    fn layers<L: Lanes>(self, l: L, material: &Material, surface: &Surface<L>) -> Self::Layers<L> {
        let base = MetallicBase::new(l, surface);
        let layers = LayersAbove::new(l, material, surface);
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
            coat: layers.coat,
            sheen: layers.sheen,
            iridescence: layers.iridescence,
            // Tangent and bitangent are turned already.
            anisotropy: (material.lobes.anisotropy.strength != 0.0).then_some(Anisotropy {
                strength,
                direction: [l.splat(1.0), l.zero()],
                tangent,
                bitangent,
                geometric_normal: surface.vertex_normal,
            }),
        };
        let coat_f0 =
            if material.options.gltf.fixed_coat_f0 || ior == 0.0 { CoatF0::Fixed } else { CoatF0::BaseIor };
        let tables = Tables { brdf: tables::khronos(), sheen_albedo: tables::sheen_albedo() };
        (gltf::surface(l, coat_f0, &data, surface.normal, surface.view, tables), tables.sheen_albedo)
    }

    #[inline(always)]
    fn emission<L: Lanes>(self, l: L, (layers, _): &Self::Layers<L>, surface: &Surface<L>) -> V3<L> {
        surface.emissive * layers.coat_transmittance(l)
    }

    #[inline(always)]
    fn direct<L: Lanes>(self, l: L, layers: &Self::Layers<L>, light: &LightSample<L>) -> V3<L> {
        let (layers, sheen_albedo) = layers;
        gltf::direct(l, layers, sheen_albedo, light.direction, light.irradiance)
    }

    #[inline(always)]
    fn indirect<L: Lanes>(self, l: L, layers: &Self::Layers<L>, source: &Source<'_, L>) -> V3<L> {
        let (layers, _) = layers;
        if self.sampled && source.is_environment() {
            return sampled_environment(l, source, layers);
        }
        // What is exact of one is exact of the other.
        let source = if self.sampled { &source.by_facets() } else { source };
        let (irradiance, radiance, sheen) =
            (source.irradiance_lookup(l), source.radiance_lookup(l), source.sheen_lookup(l));
        gltf::indirect(l, layers, irradiance, radiance, sheen, source.occlusion(l))
    }
}

/// Reflection of the environment, by samples.
#[inline(never)]
fn sampled_environment<L: Lanes>(l: L, source: &Source<'_, L>, layers: &gltf::Surface<L>) -> V3<L> {
    let single = source.material.options.gltf.single_scattering;
    let scattering = if single { Scattering::Single } else { Scattering::Multiple };
    l.run(
        #[inline(always)]
        || {
            gltf::indirect_sampled(
                l,
                layers,
                scattering,
                source.irradiance_lookup(l),
                source.radiance_lookup(l),
                source.sheen_lookup(l),
                source.occlusion(l),
            )
        },
    )
}
