//! Surface shaders of MaterialX and the keys of material files that their inputs become.
//!
//! Sources: MaterialX 1.39.5, `libraries/bxdf/open_pbr_surface.mtlx` (OpenPBR 1.1.1), `standard_surface.mtlx` (1.0.1),
//! `gltf_pbr.mtlx` (2.0.1), `usd_preview_surface.mtlx` (2.6): names, defaults and units.

use overcoat_scene::ShadingModel;

/// A surface shader.
pub(super) struct Shader {
    /// Category of its node.
    pub(super) category: &'static str,
    /// Model whose formulas are its own, where there is one.
    pub(super) model: Option<ShadingModel>,
    /// `coat_darkening` where the shader has no input for it.
    pub(super) coat_darkening: Option<f32>,
    pub(super) rows: &'static [Row],
    pub(super) opacity: &'static str,
    pub(super) normal: &'static str,
    pub(super) coat_normal: &'static str,
    /// Colour and depth of light that passes, and the switch of thin walls; empty without.
    pub(super) transmission: [&'static str; 3],
    /// Weight and colour of the subsurface; empty without.
    pub(super) subsurface: [&'static str; 2],
}

/// An input and its key.
pub(super) struct Row {
    pub(super) input: &'static str,
    pub(super) default: &'static [f32],
    pub(super) key: &'static str,
    /// Key of the texture that multiplies it; empty if it takes none.
    pub(super) texture: &'static str,
    /// Factor from the input's unit to the key's.
    pub(super) unit: f32,
    /// Input that multiplies it and has no key of its own, with its default.
    pub(super) weight: Option<(&'static str, f32)>,
}

const fn row(input: &'static str, default: &'static [f32], key: &'static str, texture: &'static str) -> Row {
    Row { input, default, key, texture, unit: 1.0, weight: None }
}

impl Row {
    const fn in_units(self, unit: f32) -> Self {
        Self { unit, ..self }
    }

    /// Key that switches the lobe on which this one is a part of.
    pub(super) fn lobe(&self) -> Option<&'static str> {
        match self.key {
            "sheen_roughness" => Some("sheen_color"),
            "iridescence_ior" | "iridescence_thickness" => Some("iridescence"),
            key if key.starts_with("coat_") => Some("coat"),
            _ => None,
        }
    }

    const fn times(self, weight: &'static str, default: f32) -> Self {
        Self { weight: Some((weight, default)), ..self }
    }
}

const WHITE: &[f32] = &[1.0; 3];
const BLACK: &[f32] = &[0.0; 3];
const NONE: &[f32] = &[0.0];
const ALL: &[f32] = &[1.0];

/// Nanometres in a micrometre.
const NANOMETRES: f32 = 1e3;

/// Degrees of a whole turn.
const TURN: f32 = 360.0;

const DEGREES: f32 = 180.0 / std::f32::consts::PI;

/// All shaders, the first of them also written.
pub(super) static SHADERS: [Shader; 4] = [
    Shader {
        category: "open_pbr_surface",
        model: Some(ShadingModel::OpenPbr),
        coat_darkening: None,
        rows: &[
            row("base_color", &[0.8; 3], "base_color", "base_color_texture").times("base_weight", 1.0),
            row("base_metalness", NONE, "metallic", "metallic_texture"),
            row("specular_weight", ALL, "specular", "specular_texture"),
            row("specular_color", WHITE, "specular_color", "specular_color_texture"),
            row("specular_roughness", &[0.3], "roughness", "roughness_texture"),
            row("specular_ior", &[1.5], "ior", ""),
            row("specular_roughness_anisotropy", NONE, "anisotropy", ""),
            row("transmission_weight", NONE, "transmission", "transmission_texture"),
            row("fuzz_color", WHITE, "sheen_color", "sheen_color_texture").times("fuzz_weight", 0.0),
            row("fuzz_roughness", &[0.5], "sheen_roughness", "sheen_roughness_texture"),
            row("coat_weight", NONE, "coat", "coat_texture"),
            row("coat_color", WHITE, "coat_color", "coat_color_texture"),
            row("coat_roughness", NONE, "coat_roughness", "coat_roughness_texture"),
            row("coat_roughness_anisotropy", NONE, "coat_anisotropy", ""),
            row("coat_ior", &[1.6], "coat_ior", ""),
            row("coat_darkening", ALL, "coat_darkening", ""),
            row("thin_film_weight", NONE, "iridescence", "iridescence_texture"),
            row("thin_film_ior", &[1.4], "iridescence_ior", ""),
            row("thin_film_thickness", &[0.5], "iridescence_thickness", "").in_units(NANOMETRES),
            row("emission_color", WHITE, "emissive", "emissive_texture").times("emission_luminance", 0.0),
        ],
        opacity: "geometry_opacity",
        normal: "geometry_normal",
        coat_normal: "geometry_coat_normal",
        transmission: ["transmission_color", "transmission_depth", "geometry_thin_walled"],
        subsurface: ["subsurface_weight", "subsurface_color"],
    },
    Shader {
        category: "standard_surface",
        model: None,
        // Without coat_affect_color the coat returns nothing to its base.
        coat_darkening: Some(0.0),
        rows: &[
            row("base_color", &[0.8; 3], "base_color", "base_color_texture").times("base", 1.0),
            row("metalness", NONE, "metallic", "metallic_texture"),
            row("specular", ALL, "specular", "specular_texture"),
            row("specular_color", WHITE, "specular_color", "specular_color_texture"),
            row("specular_roughness", &[0.2], "roughness", "roughness_texture"),
            row("specular_IOR", &[1.5], "ior", ""),
            row("specular_anisotropy", NONE, "anisotropy", ""),
            row("specular_rotation", NONE, "anisotropy_rotation", "").in_units(TURN),
            row("transmission", NONE, "transmission", "transmission_texture"),
            row("sheen_color", WHITE, "sheen_color", "sheen_color_texture").times("sheen", 0.0),
            row("sheen_roughness", &[0.3], "sheen_roughness", "sheen_roughness_texture"),
            row("coat", NONE, "coat", "coat_texture"),
            row("coat_color", WHITE, "coat_color", "coat_color_texture"),
            row("coat_roughness", &[0.1], "coat_roughness", "coat_roughness_texture"),
            row("coat_anisotropy", NONE, "coat_anisotropy", ""),
            row("coat_IOR", &[1.5], "coat_ior", ""),
            row("thin_film_IOR", &[1.5], "iridescence_ior", ""),
            row("thin_film_thickness", NONE, "iridescence_thickness", ""),
            row("emission_color", WHITE, "emissive", "emissive_texture").times("emission", 0.0),
        ],
        opacity: "opacity",
        normal: "normal",
        coat_normal: "coat_normal",
        transmission: ["transmission_color", "transmission_depth", "thin_walled"],
        subsurface: ["subsurface", "subsurface_color"],
    },
    Shader {
        category: "gltf_pbr",
        model: None,
        coat_darkening: Some(0.0),
        rows: &[
            row("base_color", WHITE, "base_color", "base_color_texture"),
            row("metallic", ALL, "metallic", "metallic_texture"),
            row("roughness", ALL, "roughness", "roughness_texture"),
            row("occlusion", ALL, "occlusion_strength", "occlusion_texture"),
            row("transmission", NONE, "transmission", "transmission_texture"),
            row("specular", ALL, "specular", "specular_texture"),
            row("specular_color", WHITE, "specular_color", "specular_color_texture"),
            row("ior", &[1.5], "ior", ""),
            row("iridescence", NONE, "iridescence", "iridescence_texture"),
            row("iridescence_ior", &[1.3], "iridescence_ior", ""),
            row("iridescence_thickness", &[100.0], "iridescence_thickness", ""),
            row("sheen_color", BLACK, "sheen_color", "sheen_color_texture"),
            row("sheen_roughness", NONE, "sheen_roughness", "sheen_roughness_texture"),
            row("clearcoat", NONE, "coat", "coat_texture"),
            row("clearcoat_roughness", NONE, "coat_roughness", "coat_roughness_texture"),
            row("emissive", BLACK, "emissive", "emissive_texture").times("emissive_strength", 1.0),
            row("thickness", NONE, "thickness", "thickness_texture"),
            row("attenuation_distance", NONE, "attenuation_distance", ""),
            row("attenuation_color", WHITE, "attenuation_color", ""),
            row("anisotropy_strength", NONE, "anisotropy", ""),
            row("anisotropy_rotation", NONE, "anisotropy_rotation", "").in_units(DEGREES),
            row("dispersion", NONE, "dispersion", ""),
            row("alpha_cutoff", &[0.5], "alpha_cutoff", ""),
        ],
        opacity: "alpha",
        normal: "normal",
        coat_normal: "clearcoat_normal",
        transmission: [""; 3],
        subsurface: [""; 2],
    },
    Shader {
        category: "UsdPreviewSurface",
        model: None,
        coat_darkening: Some(0.0),
        rows: &[
            row("diffuseColor", &[0.18; 3], "base_color", "base_color_texture"),
            row("emissiveColor", BLACK, "emissive", "emissive_texture"),
            row("specularColor", BLACK, "specular_f0", ""),
            row("metallic", NONE, "metallic", "metallic_texture"),
            row("roughness", &[0.5], "roughness", "roughness_texture"),
            row("clearcoat", NONE, "coat", "coat_texture"),
            row("clearcoatRoughness", &[0.01], "coat_roughness", "coat_roughness_texture"),
            row("ior", &[1.5], "ior", ""),
            row("occlusion", ALL, "occlusion_strength", "occlusion_texture"),
            row("opacityThreshold", NONE, "alpha_cutoff", ""),
        ],
        opacity: "opacity",
        normal: "normal",
        coat_normal: "",
        transmission: [""; 3],
        subsurface: [""; 2],
    },
];
