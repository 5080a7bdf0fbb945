//! Materials in the terms of glTF, for every shading model to read in its own way.

use super::changeable::changeable;
use super::error::within;
use super::lobes::Lobes;
use super::model::ShadingModel;
use super::model_options::ModelOptions;
use super::parameters::{check, slots};
use super::{SceneError, TextureId};

/// Workflow in which base colour and reflectance are given.
#[derive(Clone, Debug, PartialEq)]
pub enum Workflow {
    /// glTF's default.
    MetallicRoughness {
        /// 0 dielectric to 1 metal.
        metallic: f32,
        /// Perceptual roughness, 0 to 1.
        roughness: f32,
        /// Linear data: roughness in green, metallic in blue; multiplies the factors.
        texture: Option<TextureRef>,
    },
    /// KHR_materials_pbrSpecularGlossiness; also Unity's specular workflow.
    SpecularGlossiness {
        /// Linear F0 colour, 0 to 1.
        specular: [f32; 3],
        /// 1 - perceptual roughness, 0 to 1.
        glossiness: f32,
        /// sRGB specular colour, glossiness in alpha; multiplies the factors.
        texture: Option<TextureRef>,
    },
}

/// Treatment of a surface's alpha.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AlphaMode {
    /// Alpha is ignored.
    Opaque,
    /// Present where alpha is at least the cutoff, absent elsewhere.
    Mask {
        /// Threshold; above 1 nothing is present.
        cutoff: f32,
    },
    /// Blended over the surfaces behind it.
    Blend,
}

/// `uv' = rotate(rotation) * (uv * scale) + offset`, KHR_texture_transform.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UvTransform {
    /// Row-major 2x3: `uv' = rows * (u, v, 1)`.
    pub rows: [[f32; 3]; 2],
}

impl UvTransform {
    /// Leaves coordinates as they are.
    pub const IDENTITY: Self = Self { rows: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]] };
}

/// A use of a texture by a material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TextureRef {
    /// Which texture.
    pub texture: TextureId,
    /// Which set of texture coordinates: 0 or 1. A mesh without that set reads (0, 0).
    pub uv_set: u8,
    /// Applied to the coordinates.
    pub transform: UvTransform,
}

impl TextureRef {
    /// Checks that it is one of so many textures, and its coordinates.
    pub(super) fn check(&self, textures: usize) -> Result<(), SceneError> {
        if self.texture.index() >= textures {
            return Err(SceneError::NoSuch { what: "texture", index: self.texture.0 });
        }
        if self.uv_set > 1 {
            return Err(SceneError::OutOfRange { what: "texture coordinate set", limit: 1.0 });
        }
        within("texture transform", self.transform.rows.as_flattened(), -1e9, 1e9)
    }
}

/// A tangent-space normal map, +Y up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NormalTexture {
    /// Linear data: (x, y, z) * 0.5 + 0.5.
    pub texture: TextureRef,
    /// Multiplies x and y.
    pub scale: f32,
}

/// A surface material. All colours are linear Rec. 709.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Material {
    /// Name in the file, for messages.
    pub name: String,
    /// Base (or diffuse) colour and alpha, 0 to 1.
    pub base_color: [f32; 4],
    /// sRGB colour and linear alpha; multiplies [`Material::base_color`].
    pub base_color_texture: Option<TextureRef>,
    /// Reflectance and roughness of the base.
    pub workflow: Workflow,
    /// Index of refraction of the dielectric base, 1 to 1000 (or 0, which stands for a reflectance of 1 as in
    /// KHR_materials_ior). glTF's default is 1.5.
    pub ior: f32,
    /// KHR_materials_specular: strength of the dielectric reflection, 0 to 1.
    pub specular: f32,
    /// Linear data, strength in alpha.
    pub specular_texture: Option<TextureRef>,
    /// KHR_materials_specular: linear colour of the dielectric F0.
    pub specular_color: [f32; 3],
    /// sRGB, multiplies [`Material::specular_color`].
    pub specular_color_texture: Option<TextureRef>,
    /// Tangent-space normals of the base.
    pub normal_texture: Option<NormalTexture>,
    /// Linear data, ambient occlusion in red.
    pub occlusion_texture: Option<TextureRef>,
    /// Strength of the occlusion, 0 to 1.
    pub occlusion_strength: f32,
    /// Emitted radiance, linear, already multiplied by KHR_materials_emissive_strength.
    pub emissive: [f32; 3],
    /// sRGB, multiplies [`Material::emissive`].
    pub emissive_texture: Option<TextureRef>,
    /// Clear coat mask, 0 to 1 (KHR_materials_clearcoat's factor).
    pub coat: f32,
    /// Linear data, mask in red.
    pub coat_texture: Option<TextureRef>,
    /// Perceptual roughness of the coat, 0 to 1.
    pub coat_roughness: f32,
    /// Linear data, roughness in green.
    pub coat_roughness_texture: Option<TextureRef>,
    /// Tangent-space normals of the coat; without it the coat is smooth.
    pub coat_normal_texture: Option<NormalTexture>,
    /// Opaque, cut out or blended.
    pub alpha_mode: AlphaMode,
    /// Drawn from both sides.
    pub double_sided: bool,
    /// Base colour as it is, without any light (KHR_materials_unlit).
    pub unlit: bool,
    /// Creases are drawn as lines where the picture's options leave that open: true for the clay of parts.
    pub has_edges: bool,
    /// Sheen, anisotropy, iridescence, the coat's medium, a second lobe, subsurface, transmission.
    pub lobes: Lobes,
    /// The formulas that shade it; those of the picture if `None`.
    pub model: Option<ShadingModel>,
    /// Switches of those formulas.
    pub options: ModelOptions,
}

impl Default for Material {
    /// A white, fully rough dielectric without textures.
    fn default() -> Self {
        Self {
            name: String::new(),
            base_color: [1.0; 4],
            base_color_texture: None,
            workflow: Workflow::MetallicRoughness { metallic: 0.0, roughness: 1.0, texture: None },
            ior: 1.5,
            specular: 1.0,
            specular_texture: None,
            specular_color: [1.0; 3],
            specular_color_texture: None,
            normal_texture: None,
            occlusion_texture: None,
            occlusion_strength: 1.0,
            emissive: [0.0; 3],
            emissive_texture: None,
            coat: 0.0,
            coat_texture: None,
            coat_roughness: 0.0,
            coat_roughness_texture: None,
            coat_normal_texture: None,
            alpha_mode: AlphaMode::Opaque,
            double_sided: false,
            unlit: false,
            has_edges: false,
            lobes: Lobes::default(),
            model: None,
            options: ModelOptions::default(),
        }
    }
}

impl Material {
    /// Every texture that the material uses.
    pub fn textures(&self) -> impl Iterator<Item = &TextureRef> {
        slots().filter_map(|(_, slot)| slot.get(self))
    }

    /// The same with replacements of the textures that it reads.
    #[must_use]
    pub fn with_textures(mut self, other: impl Fn(TextureId) -> TextureId) -> Self {
        for (_, slot) in slots() {
            if let Some(reference) = slot.get_mut(&mut self) {
                reference.texture = other(reference.texture);
            }
        }
        self
    }

    /// Sets of texture coordinates that its textures read: true for each of the two in use.
    #[must_use]
    pub fn uv_sets(&self) -> [bool; 2] {
        let mut sets = [false; 2];
        for texture in self.textures() {
            sets[usize::from(texture.uv_set & 1)] = true;
        }
        sets
    }

    /// The formulas that shade it: those chosen for the whole picture, else those that it names, else the default.
    #[must_use]
    pub fn shading(&self, chosen: Option<ShadingModel>) -> ShadingModel {
        chosen.or(self.model).unwrap_or_default()
    }

    /// F0 of the index of refraction, ((n - 1) / (n + 1))^2: exactly 0.04 for 1.5, the constant of Unity's
    /// `kDielectricSpec`, and 1 where the index is 0.
    #[must_use]
    pub fn dielectric_f0(&self) -> f32 {
        if self.ior == 1.5 {
            0.04
        } else if self.ior == 0.0 {
            1.0
        } else {
            let r = (self.ior - 1.0) / (self.ior + 1.0);
            r * r
        }
    }

    /// True if light passes straight through the surface: it is drawn after all others, and surfaces behind it show
    /// through.
    #[must_use]
    pub fn is_transmissive(&self) -> bool {
        !self.unlit && self.lobes.transmission.factor.factor > 0.0
    }

    /// True if surfaces behind it are seen refracted or blurred, and not just dimmed.
    #[must_use]
    pub fn refracts(&self) -> bool {
        let smooth = match self.workflow {
            Workflow::MetallicRoughness { roughness, .. } => roughness == 0.0,
            Workflow::SpecularGlossiness { glossiness, texture, .. } => {
                glossiness == 1.0 && texture.is_none()
            }
        };
        self.is_transmissive() && (self.lobes.transmission.has_volume() || !smooth)
    }

    /// True if light leaves the surface on the side where it did not come from, straight or in all directions.
    #[must_use]
    pub fn transmits(&self) -> bool {
        !self.unlit
            && (self.lobes.transmission.factor.factor > 0.0 || self.lobes.transmission.diffuse.factor > 0.0)
    }

    /// True if some texture perturbs normals.
    #[must_use]
    pub fn has_normal_maps(&self) -> bool {
        self.normal_texture.is_some() || self.coat_normal_texture.is_some()
    }

    /// True if some highlight is longer one way.
    #[must_use]
    pub fn is_anisotropic(&self) -> bool {
        self.lobes.anisotropy.strength != 0.0
            || self.lobes.coat.anisotropy != 0.0
            || self.lobes.second.anisotropy != 0.0
    }

    /// True if normals are perturbed or highlights are longer one way, so that the mesh needs tangents.
    #[must_use]
    pub fn needs_tangents(&self) -> bool {
        self.has_normal_maps() || self.is_anisotropic() || self.lobes.occlusion.bent_normal.is_some()
    }

    /// Checks every factor against its documented range, and that textures exist.
    pub(crate) fn validate(&self, textures: usize) -> Result<(), SceneError> {
        check(self, textures)
    }
}

changeable!(Material);
