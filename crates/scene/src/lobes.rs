//! Parameters of materials beyond base, coat and emission, with textures, in groups by lobe.
//!
//! Every group's default is "none of it", and costs nothing.

use super::changeable::changeable;
use super::material::{NormalTexture, TextureRef};
use super::paint::{CoatSurface, Flakes};
use super::transmission::Transmission;

/// Declares a group: of each parameter its type, and its default, which together are "none of it".
macro_rules! group {
    ($(#[$doc:meta])* $name:ident { $($(#[$field_doc:meta])* $field:ident: $type:ty = $default:expr,)* }) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq)]
        #[non_exhaustive]
        pub struct $name {
            $($(#[$field_doc])* pub $field: $type,)*
        }

        impl Default for $name {
            fn default() -> Self {
                Self { $($field: $default,)* }
            }
        }

        $crate::changeable::changeable!($name);
    };
}
pub(super) use group;

changeable!(Anisotropy, Lobes, Sheen);

/// A number, and a channel of a texture that multiplies it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ScalarParameter {
    /// The number.
    pub factor: f32,
    /// Linear data.
    pub texture: Option<TextureRef>,
    /// Which of the texture's channels: 0 red to 3 alpha.
    pub channel: u8,
}

impl From<f32> for ScalarParameter {
    fn from(factor: f32) -> Self {
        Self { factor, texture: None, channel: 0 }
    }
}

/// A linear colour, and an sRGB texture that multiplies it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ColorParameter {
    /// The colour.
    pub factor: [f32; 3],
    /// sRGB.
    pub texture: Option<TextureRef>,
}

impl From<[f32; 3]> for ColorParameter {
    fn from(factor: [f32; 3]) -> Self {
        Self { factor, texture: None }
    }
}

/// Fibres at grazing angles: KHR_materials_sheen. Velvet and cloth models take their fibres from here as well.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Sheen {
    /// Reflectance, 0 to 1; black is no sheen.
    pub color: ColorParameter,
    /// Perceptual roughness, 0 to 1.
    pub roughness: ScalarParameter,
}

/// Highlights that are longer one way: KHR_materials_anisotropy.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Anisotropy {
    /// -1 to 1: 0 round; above, rougher along the tangent. glTF's are 0 to 1.
    pub strength: f32,
    /// Turns the tangent towards the bitangent, in radians.
    pub rotation: f32,
    /// Linear data: direction in red and green (0.5 is 0), strength in blue.
    pub texture: Option<TextureRef>,
}

group! {
    /// A thin film: KHR_materials_iridescence.
    Iridescence {
        /// 0 none to 1 full; the texture's red by glTF.
        mask: ScalarParameter = ScalarParameter::default(),
        /// Index of refraction of the film, 1 to 5. HDRP ties it to the thickness and does not read it.
        ior: f32 = 1.3,
        /// Thickness in nanometres where the texture is 0 and where it is 1 (or there is none). HDRP takes 3000 nm as 1.
        thickness: [f32; 2] = [100.0, 400.0],
        /// Linear data, thickness in green.
        thickness_texture: Option<TextureRef> = None,
        /// StackLit under a coat: share of the film's total internal reflection of light on its way out that is made
        /// up for, 0 to 1 (`_IridescenceCoatFixupTIR`).
        coat_fixup_tir: f32 = 0.0,
        /// Upper limit of that compensation, 0 to 1 (`_IridescenceCoatFixupTIRClamp`).
        coat_fixup_tir_clamp: f32 = 0.0,
    }
}

group! {
    /// Medium of the coat. glTF's coat has index 1.5 and no colour.
    CoatMedium {
        /// Index of refraction, 1 to 3. HDRP Lit, URP, Filament, three.js and glTF have 1.5 whatever is written here.
        ior: f32 = 1.5,
        /// Thickness in units of length, 0 or more (StackLit, Babylon.js).
        thickness: ScalarParameter = ScalarParameter::default(),
        /// Extinction of red, green and blue per unit of length, 0 or more (StackLit, Babylon.js).
        extinction: [f32; 3] = [1.0; 3],
        /// Transmittance of the coat at normal incidence, linear, 0 to 1 (OpenPBR, Babylon.js).
        color: ColorParameter = ColorParameter::from([1.0; 3]),
        /// Share of the darkening by inner reflection that is applied, 0 to 1 (OpenPBR, the standard model). Loaders
        /// set 0 where a file's format has no such coat.
        darkening: f32 = 1.0,
        /// As [`Anisotropy::strength`], of the coat, 0 to 1 (OpenPBR).
        anisotropy: f32 = 0.0,
    }
}

group! {
    /// StackLit's second lobe of the base, given directly or as haze around the first. The default is none and no haze, the rest as
    /// in Unity's shader graph.
    SecondLobe {
        /// Perceptual roughness of lobe B, 0 to 1.
        roughness: ScalarParameter = ScalarParameter::from(0.5),
        /// As [`Anisotropy::strength`], of lobe B, -1 to 1.
        anisotropy: f32 = 0.0,
        /// Share of lobe B, 0 to 1.
        mix: ScalarParameter = ScalarParameter::default(),
        /// Strength of the haze, 0 to 1: with haze, roughness, anisotropy and mix of lobe B follow from it.
        haziness: ScalarParameter = ScalarParameter::default(),
        /// Width of the haze, 0 or more.
        haze_extent: f32 = 3.0,
        /// Most F0 that haze may give a dielectric, 0 to 1.
        haze_max_dielectric_f0: f32 = 0.25,
    }
}

group! {
    /// Light in and through the base: HDRP's diffusion profile as StackLit reads it. Light is not spread over the
    /// surface; the rest is the profile's F0, its texturing mode and transmission.
    Subsurface {
        /// 0 none to 1 full.
        mask: ScalarParameter = ScalarParameter::default(),
        /// Colour of the scattering distance: the larger, the farther red, green and blue go (mm).
        scattering_distance: [f32; 3] = [1.0, 0.4, 0.25],
        /// Colour of transmitted light, 0 to 1; black transmits nothing.
        transmission: [f32; 3] = [0.0; 3],
        /// Thickness in millimetres that light crosses, 0 or more.
        thickness: ScalarParameter = ScalarParameter::from(1.0),
        /// Index of refraction of the profile, 1 to 2.
        ior: f32 = 1.4,
        /// Albedo is applied after scattering only, instead of half before and half after.
        post_scatter: bool = false,
    }
}

group! {
    /// Occlusion of reflections beyond ambient occlusion. Which of it is read, if any, is decided by
    /// [`super::StackLitOptions::specular_occlusion`].
    ReflectionOcclusion {
        /// Visibility of reflections, 0 none to 1 all, for [`super::SpecularOcclusionMethod::Custom`].
        specular: ScalarParameter = ScalarParameter::from(1.0),
        /// Tangent-space mean of the directions that are not occluded, for the cones; the base's normal if `None`.
        bent_normal: Option<NormalTexture> = None,
    }
}

/// All groups of one material.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Lobes {
    /// Fibres.
    pub sheen: Sheen,
    /// Long highlights.
    pub anisotropy: Anisotropy,
    /// Thin film.
    pub iridescence: Iridescence,
    /// Medium of the coat.
    pub coat: CoatMedium,
    /// Second lobe or haze.
    pub second: SecondLobe,
    /// Subsurface scattering and transmission.
    pub subsurface: Subsurface,
    /// Light that passes through.
    pub transmission: Transmission,
    /// Occlusion of reflections.
    pub occlusion: ReflectionOcclusion,
    /// Flakes in the base.
    pub flakes: Flakes,
    /// Orange peel, scratches and swirl marks of the coat.
    pub coat_surface: CoatSurface,
}
