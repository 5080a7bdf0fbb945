//! From the G-buffer to the terms of each engine's model, one file a model, and what its lights mean.
//!
//! Each file holds one function that is compiled once for each instruction set. Lights come as irradiance E at normal
//! incidence, the environment as radiance and as irradiance over pi; a white Lambert surface that E falls on shows
//! E / pi in every model.

pub(super) mod filament;
pub(super) mod gltf;
pub(super) mod hdrp_lit;
pub(super) mod openpbr;
pub(super) mod stacklit;
pub(super) mod three;
pub(super) mod urp;
pub(super) mod velvet;

use super::{Reflectance, Surface};
use crate::each;
use crate::math::lanes::{Float, Lanes};
use crate::math::vec3::{self, V3};
use crate::scene::Material;

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
                color: vec3::scale(l, surface.base_color, vec3::max_component(l, f0).one_minus()),
                metallic: l.zero(),
                f0,
                weight: l.splat(1.0),
                f0_of_ior: 1.0,
                specular_color: f0,
            },
        }
    }

    /// F0 with its weight.
    #[inline(always)]
    fn weighted_f0(&self) -> V3<L> {
        each!(c in self.f0 => c * self.weight)
    }
}

/// Strength (0 to 1), tangent and bitangent of the anisotropy for models that know highlights along the tangent only:
/// those across it are turned by a right angle.
#[inline(always)]
fn stretched<L: Lanes>(l: L, surface: &Surface<L>) -> (L::F, V3<L>, V3<L>) {
    let across = surface.lobes.anisotropy.lt(l.zero());
    let tangent = vec3::select(l, across, surface.bitangent, surface.tangent);
    let bitangent = vec3::select(l, across, vec3::neg(l, surface.tangent), surface.bitangent);
    (surface.lobes.anisotropy.abs(), tangent, bitangent)
}

/// True if coat and base have normals of their own.
fn has_coat_normal(material: &Material) -> bool {
    material.coat_normal_texture != material.normal_texture
}

/// What HDRP takes as thickness of a film, 0 to 1, from nanometres: 1 stands for 3 micrometres.
#[inline(always)]
fn hdrp_film_thickness<L: Lanes>(surface: &Surface<L>) -> L::F {
    (surface.lobes.iridescence_thickness * (1.0 / 3000.0)).saturate()
}
