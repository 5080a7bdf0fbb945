//! Switches of the models, which engines set when a shader is compiled, and not by textures.

use super::changeable::changeable;

/// The switches of each model that has some. Those of other models than the one that shades mean nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct ModelOptions {
    /// HDRP's StackLit.
    pub stacklit: StackLitOptions,
    /// Filament's standard model.
    pub filament: FilamentOptions,
    /// Filament's models of 2018.
    pub filament_2018: Filament2018Options,
    /// three.js, older composition.
    pub three: ThreeOptions,
    /// glTF's sample renderer.
    pub gltf: GltfOptions,
    /// OpenPBR.
    pub openpbr: OpenPbrOptions,
    /// Babylon.js.
    pub babylon: BabylonOptions,
}

/// Switches of StackLit.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct StackLitOptions {
    /// The layers are added up for every light, from its half vector (`VLAYERED_RECOMPUTE_PERLIGHT`).
    pub recompute_per_light: bool,
    /// The base sees light and viewer refracted (`VLAYERED_USE_REFRACTED_ANGLES_FOR_BASE`).
    pub refracted_angles: bool,
    /// The cosine at the coat with two normals.
    pub dual_normal_fix: DualNormalFix,
    /// A light's own least roughness instead of 1/1024 (`_STACK_LIT_HONORS_LIGHT_MIN_ROUGHNESS`).
    pub honor_light_minimum_roughness: bool,
    /// Occlusion of reflections.
    pub specular_occlusion: SpecularOcclusionMethod,
    /// The cone of visible directions, where occlusion goes by cones.
    pub occlusion_cone: OcclusionCone,
    /// The light that is lost between microfacets stays lost (`STACK_LIT_USE_GGX_ENERGY_COMPENSATION` off).
    pub no_energy_compensation: bool,
    /// Specular workflow: the base colour is not dimmed by the specular colour.
    pub no_specular_energy_conservation: bool,
    /// The newest text of the conversion instead of 13.0's.
    pub newest: bool,
}

/// Switches of Filament's standard model.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct FilamentOptions {
    /// F0 of the base becomes that of its interface with the coat, as in materials that are made in the engine; those that
    /// its loader makes of glTF files leave it (`clearCoatIorChange`).
    pub coat_ior_change: bool,
}

/// Switches of Filament's models of 2018.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Filament2018Options {
    /// The later document's attenuation instead of the one of its code, which darkens the base's specular twice.
    pub single_attenuation: bool,
}

/// Switches of three.js' older composition.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct ThreeOptions {
    /// r119 instead of r131.
    pub r119: bool,
}

/// Switches of glTF's sample renderer.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct GltfOptions {
    /// The coat's F0 is 0.04, as KHR_materials_clearcoat has it, instead of that of the base's index of refraction, as the
    /// Sample Renderer computes it. They differ where KHR_materials_ior is not 1.5.
    pub fixed_coat_f0: bool,
    /// `gltf-sampled`: light that is lost between microfacets stays lost, as in the appendix of glTF.
    pub single_scattering: bool,
}

/// Switches of OpenPBR.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct OpenPbrOptions {
    /// Light that is lost between microfacets stays lost.
    pub single_scattering: bool,
}

/// Switches of Babylon.js.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct BabylonOptions {
    /// F0 of the base becomes that of its interface with the coat, as in materials that are made in the engine; from glTF
    /// files it stays.
    pub remap_f0: bool,
}

/// `ALL`, `name` and `from_name` for an enum of choices that files name.
macro_rules! named {
    ($of:ident { $($variant:ident $name:literal),+ $(,)? }) => {
        impl $of {
            /// All of them.
            pub const ALL: &'static [Self] = &[$(Self::$variant),+];

            /// Name as files have it.
            #[must_use]
            pub fn name(self) -> &'static str {
                match self {
                    $(Self::$variant => $name),+
                }
            }

            /// The choice of that name.
            #[must_use]
            pub fn from_name(name: &str) -> Option<Self> {
                Self::ALL.iter().copied().find(|choice| choice.name() == name)
            }
        }
    };
}

/// Cosine with the view that StackLit uses for the coat where coat and base have normals of their own
/// (`_VLAYERED_DUAL_NORMALS_TOP_FIX_*`).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum DualNormalFix {
    /// The smaller of |coat normal . V| and geometric normal . V; Unity's default.
    #[default]
    Flip,
    /// The geometric normal's cosine.
    Geometric,
    /// The coat normal's cosine as it is.
    None,
}

named!(DualNormalFix { Flip "flip", Geometric "geometric", None "none" });

/// Source of StackLit's occlusion of reflections.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum SpecularOcclusionMethod {
    /// No occlusion.
    Off,
    /// From ambient occlusion, view angle and roughness (Lagarde and de Rousiers 2014).
    #[default]
    FromAmbientOcclusion,
    /// The intersection of the cone of visible directions, about the bent normal, with the cone of the lobe.
    ConeCone,
    /// The same with the bent normal of strongly occluded points turned towards the geometric normal.
    ConeConeTilted,
    /// The material's own value: [`super::ReflectionOcclusion::specular`].
    Custom,
}

named!(SpecularOcclusionMethod { Off "off", FromAmbientOcclusion "from-ambient-occlusion", ConeCone "cone-cone", ConeConeTilted "cone-cone-tilted", Custom "custom" });

/// Weighting of the ambient occlusion when it was baked, for the cone of visible directions
/// (`BENT_VISIBILITY_FROM_AO_*`).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum OcclusionCone {
    /// Every direction of the hemisphere alike.
    Uniform,
    /// By the cosine with the cone's axis.
    #[default]
    Cosine,
    /// By the cosine with the normal, from which the axis deviates.
    CosineWithBentCorrection,
}

named!(OcclusionCone { Uniform "uniform", Cosine "cosine", CosineWithBentCorrection "cosine-with-bent-correction" });

changeable!(
    BabylonOptions,
    FilamentOptions,
    GltfOptions,
    ModelOptions,
    OpenPbrOptions,
    StackLitOptions,
    ThreeOptions
);
