//! The keys of material files: one table says what each takes, where it goes and what it means.

use crate::scene::{
    AlphaMode, DualNormalFix, Material, NormalTexture, OcclusionCone, ScalarParameter, ShadingModel,
    SpecularOcclusionMethod, TextureRef, Workflow,
};

/// Most that a scene takes of emitted radiance.
const MAX_FACTOR: f32 = 1e6;

/// A key of material files.
#[derive(Debug)]
pub(super) struct Key {
    /// As written; keys of the table `[options]` with that in front: `options.three_r119`.
    pub(super) name: &'static str,
    /// What it takes and where that goes.
    pub(super) kind: Kind,
    /// One line of documentation.
    pub(super) about: &'static str,
}

/// What a key takes.
#[derive(Debug)]
pub(super) enum Kind {
    /// A line of text about the file.
    Description,
    /// Whether the file is laid over the model's own material.
    Over,
    /// A number within a range; 0 as well if `or_zero`.
    Number { low: f32, high: f32, or_zero: bool, get: fn(&Material) -> f32, set: fn(&mut Material, f32) },
    /// Three numbers.
    Triple { low: f32, high: f32, get: fn(&Material) -> [f32; 3], set: fn(&mut Material, [f32; 3]) },
    /// Three numbers or an sRGB colour.
    Color { high: f32, get: fn(&Material) -> [f32; 3], set: fn(&mut Material, [f32; 3]) },
    /// Three or four numbers or an sRGB colour with or without alpha.
    BaseColor,
    /// A number of nanometres or two.
    FilmThickness,
    /// `true` or `false`.
    Switch { get: fn(&Material) -> bool, set: fn(&mut Material, bool) },
    /// One of a few names.
    Name {
        names: fn() -> Vec<&'static str>,
        get: fn(&Material) -> &'static str,
        set: fn(&mut Material, &str),
    },
    /// A texture; where it stands alone and the number that it multiplies is 0, that becomes 1.
    Texture { slot: Slot, factor: Option<&'static str> },
}

/// A place for a texture.
#[derive(Clone, Copy, Debug)]
pub(super) enum Slot {
    /// sRGB, with alpha.
    BaseColor,
    /// sRGB.
    Color(fn(&mut Material) -> &mut Option<TextureRef>),
    /// Linear data whose channels have meanings of their own.
    Data(fn(&mut Material) -> &mut Option<TextureRef>),
    /// Linear data of one channel: the one that the renderer reads, and the place.
    Channel(u8, fn(&mut Material) -> &mut Option<TextureRef>),
    /// Linear data of one channel that the material names: the default, and the place.
    Scalar(u8, fn(&mut Material) -> &mut ScalarParameter),
    /// Tangent-space normals.
    Normal(fn(&mut Material) -> &mut Option<NormalTexture>),
    /// Roughness in green and metallic in blue.
    MetallicRoughness,
    /// Metallic alone.
    Metallic,
    /// Roughness alone.
    Roughness,
}

impl Key {
    /// The key of that name.
    pub(super) fn named(name: &str) -> Option<&'static Self> {
        KEYS.iter().find(|key| key.name == name)
    }

    /// The value of a material as a file would give it; `None` for keys that have none.
    fn text(&self, material: &Material) -> Option<String> {
        let list = |values: &[f32]| {
            let numbers: Vec<String> = values.iter().map(|v| format!("{v:?}")).collect();
            format!("[{}]", numbers.join(", "))
        };
        match &self.kind {
            Kind::Description => None,
            Kind::Over => Some("false".to_owned()),
            Kind::Number { get, .. } => Some(format!("{:?}", get(material))),
            Kind::Triple { get, .. } | Kind::Color { get, .. } => Some(list(&get(material))),
            Kind::BaseColor => Some(list(&material.base_color)),
            Kind::FilmThickness => Some(list(&material.lobes.iridescence.thickness)),
            Kind::Switch { get, .. } => Some(get(material).to_string()),
            Kind::Name { get, .. } => {
                Some(get(material)).filter(|n| !n.is_empty()).map(|n| format!("\"{n}\""))
            }
            Kind::Texture { .. } => Some("false".to_owned()),
        }
    }

    /// What it takes, in words.
    fn takes(&self) -> String {
        match &self.kind {
            Kind::Description => "text".to_owned(),
            Kind::Over | Kind::Switch { .. } => "true or false".to_owned(),
            Kind::Number { low, high, or_zero, .. } => {
                format!("{low} to {high}{}", if *or_zero { ", or 0" } else { "" })
            }
            Kind::Triple { low, high, .. } => format!("[r, g, b], {low} to {high}"),
            Kind::Color { high, .. } => format!("[r, g, b], 0 to {high}, or \"#rrggbb\""),
            Kind::BaseColor => {
                "[r, g, b] or [r, g, b, a], 0 to 1, or \"#rrggbb\" or \"#rrggbbaa\"".to_owned()
            }
            Kind::FilmThickness => "nanometres, 0 to 100000, or [min, max]".to_owned(),
            Kind::Name { names, .. } => names().join(", "),
            Kind::Texture { .. } => "texture".to_owned(),
        }
    }
}

/// A key of material files, for people.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MaterialKey {
    /// As written; keys of the table `[options]` with that in front: `options.three_r119`.
    pub name: &'static str,
    /// What it takes.
    pub takes: String,
    /// The value where it is absent, in TOML; `None` for keys without one.
    pub default: Option<String>,
    /// One line about it.
    pub about: &'static str,
}

/// All keys of material files, in the order of the documentation.
pub fn material_keys() -> impl Iterator<Item = MaterialKey> {
    let default = Material::default();
    KEYS.iter().map(move |key| MaterialKey {
        name: key.name,
        takes: key.takes(),
        default: key.text(&default),
        about: key.about,
    })
}

/// A key for a number: name, range, place, documentation.
macro_rules! number {
    ($name:literal, $low:literal ..= $high:literal, $m:ident => $place:expr, $about:literal) => {
        Key {
            name: $name,
            kind: Kind::Number {
                low: $low,
                high: $high,
                or_zero: false,
                get: |$m| $place,
                set: |$m, value| $place = value,
            },
            about: $about,
        }
    };
}

macro_rules! triple {
    ($name:literal, $low:literal ..= $high:literal, $m:ident => $place:expr, $about:literal) => {
        Key {
            name: $name,
            kind: Kind::Triple { low: $low, high: $high, get: |$m| $place, set: |$m, value| $place = value },
            about: $about,
        }
    };
}

macro_rules! color {
    ($name:literal, ..= $high:literal, $m:ident => $place:expr, $about:literal) => {
        Key {
            name: $name,
            kind: Kind::Color { high: $high, get: |$m| $place, set: |$m, value| $place = value },
            about: $about,
        }
    };
}

macro_rules! switch {
    ($name:literal, $m:ident => $place:expr, $about:literal) => {
        Key {
            name: $name,
            kind: Kind::Switch { get: |$m| $place, set: |$m, value| $place = value },
            about: $about,
        }
    };
}

/// A key for one of a few choices that have names.
macro_rules! choice {
    ($name:literal, $of:ident, $m:ident => $place:expr, $about:literal) => {
        Key {
            name: $name,
            kind: Kind::Name {
                names: || $of::ALL.iter().map(|choice| choice.name()).collect(),
                get: |$m| $place.name(),
                set: |$m, name| {
                    // The parser has looked the name up among them.
                    if let Some(choice) = $of::from_name(name) {
                        $place = choice;
                    }
                },
            },
            about: $about,
        }
    };
}

/// A key for a texture: name, kind of slot, place, the key that it multiplies, documentation.
macro_rules! texture {
    ($name:literal, $slot:expr, $factor:expr, $about:literal) => {
        Key { name: $name, kind: Kind::Texture { slot: $slot, factor: $factor }, about: $about }
    };
}

/// All keys. Values are applied in this order: a texture follows what decides how it is read.
pub(super) static KEYS: &[Key] = &[
    Key { name: "description", kind: Kind::Description, about: "One line about the material." },
    Key {
        name: "over",
        kind: Kind::Over,
        about: "Lay the keys given over the model's own material, instead of replacing it.",
    },
    Key {
        name: "model",
        kind: Kind::Name {
            names: || ShadingModel::ALL.iter().copied().map(ShadingModel::name).collect(),
            get: |m| m.model.map_or("", ShadingModel::name),
            set: |m, name| m.model = ShadingModel::from_name(name),
        },
        about: "The engine whose formulas shade it; without it, the default.",
    },
    Key {
        name: "alpha_mode",
        kind: Kind::Name {
            names: || vec!["opaque", "mask", "blend"],
            get: |m| match m.alpha_mode {
                AlphaMode::Opaque => "opaque",
                AlphaMode::Mask { .. } => "mask",
                AlphaMode::Blend => "blend",
            },
            set: |m, name| {
                m.alpha_mode = match name {
                    "mask" => AlphaMode::Mask { cutoff: 0.5 },
                    "blend" => AlphaMode::Blend,
                    _ => AlphaMode::Opaque,
                }
            },
        },
        about: "What alpha means: nothing, present or absent, or how much covers what is behind.",
    },
    Key {
        name: "alpha_cutoff",
        kind: Kind::Number {
            low: 0.0,
            high: 1e6,
            or_zero: false,
            get: |m| if let AlphaMode::Mask { cutoff } = m.alpha_mode { cutoff } else { 0.5 },
            set: |m, cutoff| m.alpha_mode = AlphaMode::Mask { cutoff },
        },
        about: "Present where alpha is at least this; makes alpha_mode \"mask\".",
    },
    switch!("double_sided", m => m.double_sided, "Drawn from both sides; without the key, as the model has it."),
    switch!("unlit", m => m.unlit, "The base colour as it is, without any light."),
    // The base.
    Key { name: "base_color", kind: Kind::BaseColor, about: "Colour of the base, and alpha." },
    texture!(
        "base_color_texture",
        Slot::BaseColor,
        Some("base_color"),
        "Multiplies base_color; alpha in the fourth channel."
    ),
    Key {
        name: "specular_f0",
        kind: Kind::Color {
            high: 1.0,
            get: |m| match m.workflow {
                Workflow::SpecularGlossiness { specular, .. } => specular,
                // A dielectric of index 1.5.
                Workflow::MetallicRoughness { .. } => [0.04; 3],
            },
            set: |m, value| *specular_workflow(m).0 = value,
        },
        about: "F0 instead of metallic and ior (specular workflow).",
    },
    Key {
        name: "glossiness",
        kind: Kind::Number {
            low: 0.0,
            high: 1.0,
            or_zero: false,
            get: |m| match m.workflow {
                Workflow::SpecularGlossiness { glossiness, .. } => glossiness,
                Workflow::MetallicRoughness { roughness, .. } => 1.0 - roughness,
            },
            set: |m, value| *specular_workflow(m).1 = value,
        },
        about: "1 - perceptual roughness (specular workflow).",
    },
    texture!(
        "specular_glossiness_texture",
        Slot::Color(|m| specular_workflow(m).2),
        None,
        "F0 in colour, glossiness in alpha (specular workflow)."
    ),
    Key {
        name: "metallic",
        kind: Kind::Number {
            low: 0.0,
            high: 1.0,
            or_zero: false,
            get: |m| match m.workflow {
                Workflow::MetallicRoughness { metallic, .. } => metallic,
                Workflow::SpecularGlossiness { .. } => 0.0,
            },
            set: |m, value| *metallic_workflow(m).0 = value,
        },
        about: "0 dielectric to 1 metal.",
    },
    Key {
        name: "roughness",
        kind: Kind::Number {
            low: 0.0,
            high: 1.0,
            or_zero: false,
            get: |m| match m.workflow {
                Workflow::MetallicRoughness { roughness, .. } => roughness,
                Workflow::SpecularGlossiness { glossiness, .. } => 1.0 - glossiness,
            },
            set: |m, value| match &mut m.workflow {
                Workflow::MetallicRoughness { roughness, .. } => *roughness = value,
                Workflow::SpecularGlossiness { glossiness, .. } => *glossiness = 1.0 - value,
            },
        },
        about: "Perceptual roughness of the base.",
    },
    texture!(
        "metallic_roughness_texture",
        Slot::MetallicRoughness,
        Some("metallic"),
        "glTF's: roughness in green, metallic in blue."
    ),
    texture!("metallic_texture", Slot::Metallic, Some("metallic"), "Multiplies metallic (channel b)."),
    texture!("roughness_texture", Slot::Roughness, Some("roughness"), "Multiplies roughness (channel g)."),
    Key {
        name: "ior",
        kind: Kind::Number {
            low: 1.0,
            high: 1000.0,
            or_zero: true,
            get: |m| m.ior,
            set: |m, value| m.ior = value,
        },
        about: "Index of refraction of the dielectric base; 0 reflects everything.",
    },
    number!("specular", 0.0..=1.0, m => m.specular, "Strength of the dielectric reflection."),
    texture!(
        "specular_texture",
        Slot::Channel(3, |m| &mut m.specular_texture),
        Some("specular"),
        "Multiplies specular (channel r; glTF's maps have it in a)."
    ),
    color!("specular_color", ..=1e6, m => m.specular_color, "Colour of the dielectric F0."),
    texture!(
        "specular_color_texture",
        Slot::Color(|m| &mut m.specular_color_texture),
        Some("specular_color"),
        "Multiplies specular_color."
    ),
    texture!("normal_texture", Slot::Normal(|m| &mut m.normal_texture), None, "Normals of the base, +Y up."),
    Key {
        name: "normal_scale",
        kind: Kind::Number {
            low: -1e4,
            high: 1e4,
            or_zero: false,
            get: |m| m.normal_texture.map_or(1.0, |n| n.scale),
            set: |m, value| {
                if let Some(normal) = &mut m.normal_texture {
                    normal.scale = value;
                }
            },
        },
        about: "Multiplies x and y of normal_texture.",
    },
    texture!(
        "occlusion_texture",
        Slot::Channel(0, |m| &mut m.occlusion_texture),
        Some("occlusion_strength"),
        "Ambient occlusion (channel r)."
    ),
    number!("occlusion_strength", 0.0..=1.0, m => m.occlusion_strength, "How much of the occlusion applies."),
    color!("emissive", ..=1e3, m => m.emissive, "Emitted radiance."),
    Key {
        name: "emissive_strength",
        kind: Kind::Number {
            low: 0.0,
            high: 1e3,
            or_zero: false,
            get: |_| 1.0,
            set: |m, strength| {
                // An imported material may have as much as a scene takes already.
                let product = |e: f32| if e * strength < MAX_FACTOR { e * strength } else { MAX_FACTOR };
                m.emissive = m.emissive.map(product);
            },
        },
        about: "Multiplies emissive.",
    },
    texture!(
        "emissive_texture",
        Slot::Color(|m| &mut m.emissive_texture),
        Some("emissive"),
        "Multiplies emissive."
    ),
    // The clear coat.
    number!("coat", 0.0..=1.0, m => m.coat, "Clear coat mask."),
    texture!(
        "coat_texture",
        Slot::Channel(0, |m| &mut m.coat_texture),
        Some("coat"),
        "Multiplies coat (channel r)."
    ),
    number!("coat_roughness", 0.0..=1.0, m => m.coat_roughness, "Perceptual roughness of the coat."),
    texture!(
        "coat_roughness_texture",
        Slot::Channel(1, |m| &mut m.coat_roughness_texture),
        Some("coat_roughness"),
        "Multiplies coat_roughness (channel g)."
    ),
    texture!(
        "coat_normal_texture",
        Slot::Normal(|m| &mut m.coat_normal_texture),
        None,
        "Normals of the coat; without it the coat is smooth."
    ),
    Key {
        name: "coat_normal_scale",
        kind: Kind::Number {
            low: -1e4,
            high: 1e4,
            or_zero: false,
            get: |m| m.coat_normal_texture.map_or(1.0, |n| n.scale),
            set: |m, value| {
                if let Some(normal) = &mut m.coat_normal_texture {
                    normal.scale = value;
                }
            },
        },
        about: "Multiplies x and y of coat_normal_texture.",
    },
    number!("coat_ior", 1.0..=3.0, m => m.lobes.coat.ior, "Index of refraction of the coat (StackLit, OpenPBR, Babylon.js)."),
    number!(
        "coat_thickness",
        0.0..=1e6,
        m => m.lobes.coat.thickness.factor,
        "Thickness of the coat, in the length that coat_extinction is given for (StackLit, Babylon.js)."
    ),
    texture!(
        "coat_thickness_texture",
        Slot::Scalar(0, |m| &mut m.lobes.coat.thickness),
        Some("coat_thickness"),
        "Multiplies coat_thickness (channel r)."
    ),
    triple!(
        "coat_extinction",
        0.0..=1e6,
        m => m.lobes.coat.extinction,
        "Extinction of red, green and blue in the coat per length (StackLit, Babylon.js)."
    ),
    color!(
        "coat_color",
        ..=1.0,
        m => m.lobes.coat.color.factor,
        "What the coat lets through, seen from above (OpenPBR, Babylon.js)."
    ),
    texture!(
        "coat_color_texture",
        Slot::Color(|m| &mut m.lobes.coat.color.texture),
        Some("coat_color"),
        "Multiplies coat_color."
    ),
    number!(
        "coat_darkening",
        0.0..=1.0,
        m => m.lobes.coat.darkening,
        "How much inner reflection darkens the base (OpenPBR)."
    ),
    number!(
        "coat_anisotropy",
        0.0..=1.0,
        m => m.lobes.coat.anisotropy,
        "Anisotropy of the coat (OpenPBR)."
    ),
    // Further lobes.
    number!(
        "anisotropy",
        -1.0..=1.0,
        m => m.lobes.anisotropy.strength,
        "0 round; above, rougher along the tangent."
    ),
    Key {
        name: "anisotropy_rotation",
        kind: Kind::Number {
            low: -3600.0,
            high: 3600.0,
            or_zero: false,
            get: |m| m.lobes.anisotropy.rotation.to_degrees(),
            set: |m, degrees| m.lobes.anisotropy.rotation = degrees.to_radians(),
        },
        about: "Turns the tangent towards the bitangent, in degrees.",
    },
    texture!(
        "anisotropy_texture",
        Slot::Data(|m| &mut m.lobes.anisotropy.texture),
        Some("anisotropy"),
        "glTF's: direction in red and green, strength in blue."
    ),
    color!("sheen_color", ..=1.0, m => m.lobes.sheen.color.factor, "Reflectance of fibres at grazing angles."),
    texture!(
        "sheen_color_texture",
        Slot::Color(|m| &mut m.lobes.sheen.color.texture),
        Some("sheen_color"),
        "Multiplies sheen_color."
    ),
    number!(
        "sheen_roughness",
        0.0..=1.0,
        m => m.lobes.sheen.roughness.factor,
        "Perceptual roughness of the fibres."
    ),
    texture!(
        "sheen_roughness_texture",
        Slot::Scalar(0, |m| &mut m.lobes.sheen.roughness),
        Some("sheen_roughness"),
        "Multiplies sheen_roughness (channel r; glTF's maps have it in a)."
    ),
    number!("iridescence", 0.0..=1.0, m => m.lobes.iridescence.mask.factor, "Mask of a thin film."),
    texture!(
        "iridescence_texture",
        Slot::Scalar(0, |m| &mut m.lobes.iridescence.mask),
        Some("iridescence"),
        "Multiplies iridescence (channel r)."
    ),
    number!("iridescence_ior", 1.0..=5.0, m => m.lobes.iridescence.ior, "Index of refraction of the film."),
    Key {
        name: "iridescence_thickness",
        kind: Kind::FilmThickness,
        about: "Where the texture is 1 or there is none; of two numbers the first is where it is 0.",
    },
    texture!(
        "iridescence_thickness_texture",
        Slot::Channel(1, |m| &mut m.lobes.iridescence.thickness_texture),
        None,
        "From the least to the largest thickness (channel g)."
    ),
    number!(
        "iridescence_coat_fixup_tir",
        0.0..=1.0,
        m => m.lobes.iridescence.coat_fixup_tir,
        "How much of the film's total reflection under a coat is made up for (StackLit)."
    ),
    number!(
        "iridescence_coat_fixup_tir_clamp",
        0.0..=1.0,
        m => m.lobes.iridescence.coat_fixup_tir_clamp,
        "How far that may go (StackLit)."
    ),
    number!(
        "second_roughness",
        0.0..=1.0,
        m => m.lobes.second.roughness.factor,
        "Perceptual roughness of the second lobe (StackLit)."
    ),
    texture!(
        "second_roughness_texture",
        Slot::Scalar(1, |m| &mut m.lobes.second.roughness),
        Some("second_roughness"),
        "Multiplies second_roughness (channel g)."
    ),
    number!(
        "second_anisotropy",
        -1.0..=1.0,
        m => m.lobes.second.anisotropy,
        "Anisotropy of the second lobe (StackLit)."
    ),
    number!("lobe_mix", 0.0..=1.0, m => m.lobes.second.mix.factor, "Share of the second lobe (StackLit)."),
    texture!(
        "lobe_mix_texture",
        Slot::Scalar(0, |m| &mut m.lobes.second.mix),
        Some("lobe_mix"),
        "Multiplies lobe_mix (channel r)."
    ),
    number!(
        "haziness",
        0.0..=1.0,
        m => m.lobes.second.haziness.factor,
        "Haze around the highlight, in place of the second lobe's numbers (StackLit)."
    ),
    texture!(
        "haziness_texture",
        Slot::Scalar(0, |m| &mut m.lobes.second.haziness),
        Some("haziness"),
        "Multiplies haziness (channel r)."
    ),
    number!("haze_extent", 0.0..=1e3, m => m.lobes.second.haze_extent, "How far haze extends (StackLit)."),
    number!(
        "haze_max_dielectric_f0",
        0.0..=1.0,
        m => m.lobes.second.haze_max_dielectric_f0,
        "Most F0 that haze may give a dielectric (StackLit)."
    ),
    number!(
        "subsurface",
        0.0..=1.0,
        m => m.lobes.subsurface.mask.factor,
        "Mask of light in and through the base (StackLit)."
    ),
    texture!(
        "subsurface_texture",
        Slot::Scalar(0, |m| &mut m.lobes.subsurface.mask),
        Some("subsurface"),
        "Multiplies subsurface (channel r)."
    ),
    triple!(
        "scattering_distance",
        1e-3..=1e6,
        m => m.lobes.subsurface.scattering_distance,
        "How far red, green and blue go, in millimetres."
    ),
    color!(
        "subsurface_transmission",
        ..=1.0,
        m => m.lobes.subsurface.transmission,
        "Colour of light that the subsurface lets through (StackLit, Filament's cloth)."
    ),
    number!(
        "subsurface_thickness",
        0.0..=1e6,
        m => m.lobes.subsurface.thickness.factor,
        "Millimetres that this light crosses."
    ),
    texture!(
        "subsurface_thickness_texture",
        Slot::Scalar(0, |m| &mut m.lobes.subsurface.thickness),
        Some("subsurface_thickness"),
        "Multiplies subsurface_thickness (channel r)."
    ),
    number!(
        "subsurface_ior",
        1.0..=2.0,
        m => m.lobes.subsurface.ior,
        "Index of refraction of what light goes through."
    ),
    switch!(
        "subsurface_post_scatter",
        m => m.lobes.subsurface.post_scatter,
        "The base colour applies after scattering only, instead of half before and half after."
    ),
    // Light that passes through, in every model.
    number!(
        "transmission",
        0.0..=1.0,
        m => m.lobes.transmission.factor.factor,
        "Share of the light that is not reflected that passes straight through; what is behind shows."
    ),
    texture!(
        "transmission_texture",
        Slot::Scalar(0, |m| &mut m.lobes.transmission.factor),
        Some("transmission"),
        "Multiplies transmission (channel r)."
    ),
    number!(
        "diffuse_transmission",
        0.0..=1.0,
        m => m.lobes.transmission.diffuse.factor,
        "Share of the rest that leaves on the other side in all directions."
    ),
    texture!(
        "diffuse_transmission_texture",
        Slot::Scalar(0, |m| &mut m.lobes.transmission.diffuse),
        Some("diffuse_transmission"),
        "Multiplies diffuse_transmission (channel r; glTF's maps have it in a)."
    ),
    color!(
        "diffuse_transmission_color",
        ..=1.0,
        m => m.lobes.transmission.diffuse_color.factor,
        "Colour of that diffuse light."
    ),
    texture!(
        "diffuse_transmission_color_texture",
        Slot::Color(|m| &mut m.lobes.transmission.diffuse_color.texture),
        Some("diffuse_transmission_color"),
        "Multiplies diffuse_transmission_color."
    ),
    number!(
        "thickness",
        0.0..=1e6,
        m => m.lobes.transmission.thickness.factor,
        "Thickness of the volume beneath in units of the mesh; a surface with 0 is a thin wall and does not refract."
    ),
    texture!(
        "thickness_texture",
        Slot::Scalar(1, |m| &mut m.lobes.transmission.thickness),
        Some("thickness"),
        "Multiplies thickness (channel g)."
    ),
    color!(
        "attenuation_color",
        ..=1.0,
        m => m.lobes.transmission.attenuation_color,
        "What white light becomes on its way of attenuation_distance through the volume."
    ),
    Key {
        name: "attenuation_distance",
        kind: Kind::Number {
            low: 1e-6,
            high: 1e9,
            or_zero: true,
            get: |m| {
                let distance = m.lobes.transmission.attenuation_distance;
                if distance.is_finite() { distance } else { 0.0 }
            },
            set: |m, value| {
                m.lobes.transmission.attenuation_distance = if value > 0.0 { value } else { f32::INFINITY };
            },
        },
        about: "In units of the scene; with 0 nothing is absorbed.",
    },
    number!(
        "dispersion",
        0.0..=1e3,
        m => m.lobes.transmission.dispersion,
        "20 over the Abbe number: how far apart the volume refracts red and blue."
    ),
    number!(
        "specular_occlusion",
        0.0..=1.0,
        m => m.lobes.occlusion.specular.factor,
        "Visibility of reflections, for options.stacklit_specular_occlusion = \"custom\"."
    ),
    texture!(
        "specular_occlusion_texture",
        Slot::Scalar(0, |m| &mut m.lobes.occlusion.specular),
        Some("specular_occlusion"),
        "Multiplies specular_occlusion (channel r)."
    ),
    texture!(
        "bent_normal_texture",
        Slot::Normal(|m| &mut m.lobes.occlusion.bent_normal),
        None,
        "Mean of the directions that are not occluded, for the cones of options.stacklit_specular_occlusion."
    ),
    // Switches of the models.
    switch!(
        "options.stacklit_recompute_per_light",
        m => m.options.stacklit_recompute_per_light,
        "The layers are added up for every light, from its half vector."
    ),
    switch!(
        "options.stacklit_refracted_angles",
        m => m.options.stacklit_refracted_angles,
        "The base sees light and viewer refracted."
    ),
    choice!(
        "options.stacklit_dual_normal_fix",
        DualNormalFix,
        m => m.options.stacklit_dual_normal_fix,
        "The cosine at the coat where coat and base have normals of their own."
    ),
    switch!(
        "options.stacklit_honor_light_minimum_roughness",
        m => m.options.stacklit_honor_light_minimum_roughness,
        "A light's own least roughness."
    ),
    choice!(
        "options.stacklit_specular_occlusion",
        SpecularOcclusionMethod,
        m => m.options.stacklit_specular_occlusion,
        "Where the occlusion of reflections comes from. Unity's pivot method is not offered: its table is in no \
                public text."
    ),
    choice!(
        "options.stacklit_occlusion_cone",
        OcclusionCone,
        m => m.options.stacklit_occlusion_cone,
        "How the ambient occlusion was weighted when it was baked, for the cones."
    ),
    switch!(
        "options.stacklit_no_energy_compensation",
        m => m.options.stacklit_no_energy_compensation,
        "Light that is lost between microfacets stays lost."
    ),
    switch!(
        "options.stacklit_no_specular_energy_conservation",
        m => m.options.stacklit_no_specular_energy_conservation,
        "In the specular workflow, the base colour is not dimmed by the specular colour."
    ),
    switch!(
        "options.stacklit_newest",
        m => m.options.stacklit_newest,
        "The newest text of the conversion instead of 13.0's."
    ),
    switch!(
        "options.filament_2018_single_attenuation",
        m => m.options.filament_2018_single_attenuation,
        "The later document's attenuation, which darkens the base's specular once."
    ),
    switch!("options.three_r119", m => m.options.three_r119, "r119 instead of r131."),
    switch!(
        "options.gltf_fixed_coat_f0",
        m => m.options.gltf_fixed_coat_f0,
        "The coat's F0 is 0.04 instead of that of the base's index of refraction."
    ),
    switch!(
        "options.babylon_remap_f0",
        m => m.options.babylon_remap_f0,
        "F0 of the base becomes that of its interface with the coat."
    ),
];

/// Metallic, roughness and their texture, of a material that is turned to that workflow if it has the other.
pub(super) fn metallic_workflow(m: &mut Material) -> (&mut f32, &mut f32, &mut Option<TextureRef>) {
    if let Workflow::SpecularGlossiness { glossiness, .. } = m.workflow {
        let roughness = 1.0 - glossiness;
        m.workflow = Workflow::MetallicRoughness { metallic: 0.0, roughness, texture: None };
    }
    match &mut m.workflow {
        Workflow::MetallicRoughness { metallic, roughness, texture } => (metallic, roughness, texture),
        // Not so any more.
        Workflow::SpecularGlossiness { specular: [r, ..], glossiness, texture } => (r, glossiness, texture),
    }
}

/// F0, glossiness and their texture, of a material that is turned to that workflow if it has the other.
fn specular_workflow(m: &mut Material) -> (&mut [f32; 3], &mut f32, &mut Option<TextureRef>) {
    if let Workflow::MetallicRoughness { roughness, .. } = m.workflow {
        let glossiness = 1.0 - roughness;
        m.workflow = Workflow::SpecularGlossiness { specular: [0.04; 3], glossiness, texture: None };
    }
    match &mut m.workflow {
        Workflow::SpecularGlossiness { specular, glossiness, texture } => (specular, glossiness, texture),
        // Not so any more.
        Workflow::MetallicRoughness { roughness, texture, .. } => (&mut m.specular_color, roughness, texture),
    }
}
