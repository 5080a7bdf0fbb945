//! The shading models: from the G-buffer to each engine's terms, one file an engine. [`registered!`] lists them.

mod babylon;
mod filament;
mod gltf;
mod hdrp_lit;
mod openpbr;
mod stacklit;
mod stacklit_d;
mod standard;
mod three;
mod urp;
mod velvet;

use super::model;
use super::variation::NormalFiltering;
use super::{Reflectance, ShadeContext, Surface};
use crate::gbuffer::layout::SurfacePlanes;
use overcoat_core::math::lanes::{Float, Lanes};
use overcoat_core::math::vec3::{V3, Vec3};
use overcoat_scene::{Material, ShadingModel};
use overcoat_shading::coat::filament::Quality;
use overcoat_shading::coat::gltf::{Coat, Iridescence, Sheen};
use overcoat_shading::coat::urp::UrpVersion;

/// Evaluates `$body` with `$of` as the [`Model`] that stands for a [`ShadingModel`].
macro_rules! registered {
    ($model:expr, $of:ident => $body:expr) => {
        registered!(@ $model, $of, $body,
            UrpDesktop => urp::Urp(UrpVersion::Desktop),
            UrpMobile => urp::Urp(UrpVersion::Mobile),
            Urp17 => urp::Urp(UrpVersion::Newest),
            HdrpLit => hdrp_lit::HdrpLit,
            StackLit => stacklit::StackLit,
            Filament => filament::Standard(Quality::Desktop),
            FilamentMobile => filament::Standard(Quality::Mobile),
            FilamentCloth => filament::Cloth,
            Filament2018 => filament::Standard2018,
            Three => three::Three,
            ThreeLegacy => three::ThreeLegacy,
            Gltf => gltf::Gltf { sampled: false },
            GltfSampled => gltf::Gltf { sampled: true },
            OpenPbr => openpbr::OpenPbr,
            Velvet => velvet::Velvet,
            Babylon => babylon::Babylon,
            StackLitD => stacklit_d::StackLitD,
            Standard => standard::Standard,
        )
    };
    (@ $model:expr, $of:ident, $body:expr, $($name:ident => $value:expr,)+) => {
        match $model {
            $(ShadingModel::$name if const { ShadingModel::$name.is_built() } => {
                let $of = $value;
                $body
            })+
            // None of those that the program lacks gets here: the renderer refuses them.
            _ => {
                let $of = standard::Standard;
                $body
            }
        }
    };
}

/// The radiance of sixteen fragments by the formulas of a model.
#[inline(always)]
pub(super) fn radiance<L: Lanes>(
    l: L,
    shading: ShadingModel,
    context: &ShadeContext<'_>,
    material: &Material,
    planes: &SurfacePlanes,
) -> V3<L> {
    registered!(shading, of => model::radiance(l, of, context, material, planes))
}

/// Cost of a fragment of a model: see [`Model::cost`](model::Model::cost).
pub(super) fn cost(shading: ShadingModel) -> [u64; 4] {
    registered!(shading, of => model::Model::cost(of))
}

/// Filter by which a model's roughness grows: see [`Model::normal_filtering`](model::Model::normal_filtering).
pub(super) fn normal_filtering(shading: ShadingModel) -> NormalFiltering {
    registered!(shading, of => model::Model::normal_filtering(of))
}

/// A base in the metallic workflow, whatever the material's own.
#[derive(Clone, Copy)]
struct MetallicBase<L: Lanes> {
    color: V3<L>,
    metallic: L::F,
    /// `min(f0 * specular colour, 1)`, before the weight.
    f0: V3<L>,
    /// Weight of the dielectric's reflection.
    weight: L::F,
    /// F0 of the index of refraction, and the colour that multiplies it.
    f0_of_ior: f32,
    specular_color: V3<L>,
}

impl<L: Lanes> MetallicBase<L> {
    /// The specular workflow becomes a dielectric of that F0 whose diffuse colour is dimmed by the largest channel of F0,
    /// as KHR_materials_pbrSpecularGlossiness has it.
    #[inline(always)]
    fn new(l: L, surface: &Surface<L>) -> Self {
        match surface.reflectance {
            Reflectance::Metallic { metallic, dielectric } => Self {
                color: surface.base_color,
                metallic,
                f0: dielectric.f0(l),
                weight: dielectric.weight,
                f0_of_ior: dielectric.f0_of_ior,
                specular_color: dielectric.color,
            },
            Reflectance::Specular { f0 } => Self {
                color: surface.base_color * f0.max_component().one_minus(),
                metallic: l.zero(),
                f0,
                weight: l.splat(1.0),
                f0_of_ior: 1.0,
                specular_color: f0,
            },
        }
    }

    /// Index of refraction, and the specular colour that goes with it: what lies beyond the largest index (other workflows,
    /// diamonds) goes into the colour.
    #[inline(always)]
    fn index_and_color(&self, largest_ior: f32) -> (f32, V3<L>) {
        let largest_f0 =
            ((largest_ior - 1.0) / (largest_ior + 1.0)) * ((largest_ior - 1.0) / (largest_ior + 1.0));
        if self.f0_of_ior <= largest_f0 {
            let root = self.f0_of_ior.sqrt();
            return ((1.0 + root) / (1.0 - root), self.specular_color);
        }
        (largest_ior, self.specular_color * (self.f0_of_ior / largest_f0))
    }

    /// F0 with its weight.
    #[inline(always)]
    fn weighted_f0(&self) -> V3<L> {
        self.f0 * self.weight
    }
}

/// Layers above a base in the terms of glTF's extensions, for models that take them as they are: `None` where the
/// material has no such layer.
#[derive(Clone, Copy)]
struct LayersAbove<L: Lanes> {
    coat: Option<Coat<L>>,
    sheen: Option<Sheen<L>>,
    iridescence: Option<Iridescence<L>>,
}

impl<L: Lanes> LayersAbove<L> {
    #[inline(always)]
    fn new(l: L, material: &Material, surface: &Surface<L>) -> Self {
        let (lobes, values) = (&material.lobes, &surface.lobes);
        Self {
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
        }
    }
}

/// Strength (0 to 1), tangent and bitangent of the anisotropy for models that know highlights along the tangent only:
/// those across it are turned by a right angle.
#[inline(always)]
fn stretched<L: Lanes>(l: L, surface: &Surface<L>) -> (L::F, V3<L>, V3<L>) {
    let across = surface.lobes.anisotropy.lt(l.zero());
    let tangent = Vec3::select(across, surface.bitangent, surface.tangent);
    let bitangent = Vec3::select(across, -surface.tangent, surface.bitangent);
    (surface.lobes.anisotropy.abs(), tangent, bitangent)
}

/// True if coat and base have normals of their own: flakes are tilted below a coat that is not.
fn has_coat_normal(material: &Material) -> bool {
    material.coat_normal_texture != material.normal_texture
        || material.has_flakes()
        || material.has_orange_peel()
        || material.has_scratches()
        || material.has_swirl()
}

/// Film thickness of HDRP, 0 to 1, from nanometres: 1 stands for 3 micrometres.
#[inline(always)]
fn hdrp_film_thickness<L: Lanes>(surface: &Surface<L>) -> L::F {
    (surface.lobes.iridescence_thickness * (1.0 / 3000.0)).saturate()
}

#[cfg(test)]
mod tests {
    use super::super::model::Model;
    use super::*;

    #[test]
    fn what_models_read_is_what_the_table_says() {
        fn reads_lobes<M: Model>(_: M) -> bool {
            M::READS_LOBES
        }
        for &model in ShadingModel::ALL {
            assert_eq!(registered!(model, of => reads_lobes(of)), model.reads_lobes(), "{model:?}");
        }
    }
}
