//! The table. A row is a name, the name in messages, the range, the place, and a sentence about it.

use super::{Access, Holds, Kind, MAX_FACTOR, Parameter, Place, Range, Slot};
use crate::Flakes;
use crate::material::{AlphaMode, Material, TextureRef, Workflow};
use crate::model::{Feature as F, ShadingModel};
use crate::model_options::{DualNormalFix, OcclusionCone, SpecularOcclusionMethod};

/// Lengths in metres of the structures of paint.
const PAINT_SIZE: Range = Range::new(Flakes::LEAST_SIZE, MAX_FACTOR);

const STACKLIT: &[ShadingModel] = &[ShadingModel::StackLit];

/// A number: name, label, range, place, sentence.
macro_rules! number {
    ($name:literal, $label:literal, $range:expr, $m:ident => $place:expr, $about:literal) => {
        Parameter::new(
            $name,
            $label,
            Kind::Number($range, Access { get: |$m| $place, set: |$m, value| $place = value }),
            $about,
        )
    };
}

macro_rules! triple {
    ($name:literal, $label:literal, $range:expr, $m:ident => $place:expr, $about:literal) => {
        Parameter::new(
            $name,
            $label,
            Kind::Triple($range, Access { get: |$m| $place, set: |$m, value| $place = value }),
            $about,
        )
    };
}

macro_rules! color {
    ($name:literal, $label:literal, $range:expr, $m:ident => $place:expr, $about:literal) => {
        Parameter::new(
            $name,
            $label,
            Kind::Color($range, Access { get: |$m| $place, set: |$m, value| $place = value }),
            $about,
        )
    };
}

macro_rules! switch {
    ($name:literal, $m:ident => $place:expr, $about:literal) => {
        Parameter::new(
            $name,
            $name,
            Kind::Switch(Access { get: |$m| $place, set: |$m, value| $place = value }),
            $about,
        )
    };
}

/// One of a few choices that have names.
macro_rules! choice {
    ($name:literal, $of:ident, $m:ident => $place:expr, $about:literal) => {
        Parameter::new(
            $name,
            $name,
            Kind::Name {
                names: || $of::ALL.iter().map(|choice| choice.name()).collect(),
                get: |$m| $place.name(),
                set: |$m, name| {
                    if let Some(choice) = $of::from_name(name) {
                        $place = choice;
                    }
                },
            },
            $about,
        )
    };
}

/// A texture: name, meaning of its channels, parameter that it multiplies, kind of place and place, sentence.
macro_rules! texture {
    ($name:literal, $holds:expr, $factor:expr, $place:ident $m:ident => $at:expr, $about:literal) => {
        texture!($name, $holds, $factor, Place::$place(|$m| &$at, |$m| &mut $at), $about)
    };
    ($name:literal, $holds:expr, $factor:expr, $place:expr, $about:literal) => {
        Parameter::new(
            $name,
            $name,
            Kind::Texture(Slot { holds: $holds, factor: $factor, place: $place }),
            $about,
        )
    };
}

macro_rules! parameters {
    ($($(#[$doc:meta])* $id:ident = $row:expr;)*) => {
        $($(#[$doc])* #[allow(missing_docs, reason = "each has a sentence for users")] pub const $id: Parameter = $row;)*
        /// All parameters, in the order in which material files are applied: a texture follows the parameters that
        /// decide how it is read.
        pub static PARAMETERS: &[Parameter] = &[$($id),*];
    };
}

parameters! {
    MODEL = Parameter::new(
        "model",
        "model",
        Kind::Name {
            names: || ShadingModel::ALL.iter().copied().map(ShadingModel::name).collect(),
            get: |m| m.model.map_or("", ShadingModel::name),
            set: |m, name| m.model = ShadingModel::from_name(name),
        },
        "The engine whose formulas shade it; without it, the default.",
    );
    ALPHA_MODE = Parameter::new(
        "alpha_mode",
        "alpha mode",
        Kind::Name {
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
        "What alpha means: nothing, present or absent, or how much covers what is behind.",
    );
    ALPHA_CUTOFF = Parameter::new(
        "alpha_cutoff",
        "alpha cutoff",
        Kind::Number(
            Range::FACTOR,
            Access {
                get: |m| if let AlphaMode::Mask { cutoff } = m.alpha_mode { cutoff } else { 0.5 },
                set: |m, cutoff| m.alpha_mode = AlphaMode::Mask { cutoff },
            },
        ),
        "Present where alpha is at least this; makes alpha_mode \"mask\".",
    ).only(|m| matches!(m.alpha_mode, AlphaMode::Mask { .. }));
    DOUBLE_SIDED = switch!(
        "double_sided",
        m => m.double_sided,
        "Drawn from both sides; without the key, as the model has it."
    );
    UNLIT = switch!("unlit", m => m.unlit, "The base colour as it is, without any light.");

    // The base.
    BASE_COLOR = Parameter::new(
        "base_color",
        "base colour",
        Kind::ColorAndAlpha(
            Range::UNIT,
            Access { get: |m| m.base_color, set: |m, value| m.base_color = value },
        ),
        "Colour of the base, and alpha.",
    );
    BASE_COLOR_TEXTURE = texture!(
        "base_color_texture",
        Holds::ColorAndAlpha,
        Some(&BASE_COLOR),
        Texture m => m.base_color_texture,
        "Multiplies base_color; alpha in the fourth channel."
    );
    SPECULAR_F0 = Parameter::new(
        "specular_f0",
        "specular colour",
        Kind::Color(
            Range::UNIT,
            Access {
                get: |m| match m.workflow {
                    Workflow::SpecularGlossiness { specular, .. } => specular,
                    // A dielectric of index 1.5.
                    Workflow::MetallicRoughness { .. } => [0.04; 3],
                },
                set: |m, value| *specular_workflow(m).0 = value,
            },
        ),
        "F0 instead of metallic and ior (specular workflow).",
    ).only(is_specular);
    GLOSSINESS = Parameter::new(
        "glossiness",
        "glossiness",
        Kind::Number(
            Range::UNIT,
            Access {
                get: |m| match m.workflow {
                    Workflow::SpecularGlossiness { glossiness, .. } => glossiness,
                    Workflow::MetallicRoughness { roughness, .. } => 1.0 - roughness,
                },
                set: |m, value| *specular_workflow(m).1 = value,
            },
        ),
        "1 - perceptual roughness (specular workflow).",
    ).only(is_specular);
    SPECULAR_GLOSSINESS_TEXTURE = texture!(
        "specular_glossiness_texture",
        Holds::Color,
        None,
        Place::Texture(
            |m| match &m.workflow {
                Workflow::SpecularGlossiness { texture, .. } => texture,
                Workflow::MetallicRoughness { .. } => &None,
            },
            |m| specular_workflow(m).2,
        ),
        "F0 in colour, glossiness in alpha (specular workflow)."
    ).only(is_specular);
    METALLIC = Parameter::new(
        "metallic",
        "metallic",
        Kind::Number(
            Range::UNIT,
            Access {
                get: |m| match m.workflow {
                    Workflow::MetallicRoughness { metallic, .. } => metallic,
                    Workflow::SpecularGlossiness { .. } => 0.0,
                },
                set: |m, value| *metallic_workflow(m).0 = value,
            },
        ),
        "0 dielectric to 1 metal.",
    ).only(is_metallic);
    ROUGHNESS = Parameter::new(
        "roughness",
        "roughness",
        Kind::Number(
            Range::UNIT,
            Access {
                get: |m| match m.workflow {
                    Workflow::MetallicRoughness { roughness, .. } => roughness,
                    Workflow::SpecularGlossiness { glossiness, .. } => 1.0 - glossiness,
                },
                set: |m, value| match &mut m.workflow {
                    Workflow::MetallicRoughness { roughness, .. } => *roughness = value,
                    Workflow::SpecularGlossiness { glossiness, .. } => *glossiness = 1.0 - value,
                },
            },
        ),
        "Perceptual roughness of the base.",
    ).only(is_metallic);
    METALLIC_ROUGHNESS_TEXTURE = texture!(
        "metallic_roughness_texture",
        Holds::Data,
        Some(&METALLIC),
        Place::Texture(
            |m| match &m.workflow {
                Workflow::MetallicRoughness { texture, .. } => texture,
                Workflow::SpecularGlossiness { .. } => &None,
            },
            |m| metallic_workflow(m).2,
        ),
        "glTF's: roughness in green, metallic in blue."
    ).only(is_metallic);
    IOR = number!(
        "ior",
        "index of refraction",
        Range { low: 1.0, high: 1000.0, or: Some(0.0) },
        m => m.ior,
        "Index of refraction of the dielectric base; 0 reflects everything."
    );
    SPECULAR = number!(
        "specular",
        "specular",
        Range::UNIT,
        m => m.specular,
        "Strength of the dielectric reflection."
    );
    SPECULAR_TEXTURE = texture!(
        "specular_texture",
        Holds::Channel(3),
        Some(&SPECULAR),
        Texture m => m.specular_texture,
        "Multiplies specular (channel r; glTF's maps have it in a)."
    );
    SPECULAR_COLOR = color!(
        "specular_color",
        "specular colour",
        Range::FACTOR,
        m => m.specular_color,
        "Colour of the dielectric F0."
    );
    SPECULAR_COLOR_TEXTURE = texture!(
        "specular_color_texture",
        Holds::Color,
        Some(&SPECULAR_COLOR),
        Texture m => m.specular_color_texture,
        "Multiplies specular_color."
    );
    NORMAL_TEXTURE = texture!(
        "normal_texture",
        Holds::Normals,
        None,
        Normal m => m.normal_texture,
        "Normals of the base, +Y up."
    );
    NORMAL_SCALE = Parameter::new(
        "normal_scale",
        "normal scale",
        Kind::Number(
            Range::new(-1e4, 1e4),
            Access {
                get: |m| m.normal_texture.map_or(1.0, |n| n.scale),
                set: |m, value| {
                    if let Some(normal) = &mut m.normal_texture {
                        normal.scale = value;
                    }
                },
            },
        ),
        "Multiplies x and y of normal_texture.",
    ).only(|m| m.normal_texture.is_some());
    OCCLUSION_TEXTURE = texture!(
        "occlusion_texture",
        Holds::Channel(0),
        Some(&OCCLUSION_STRENGTH),
        Texture m => m.occlusion_texture,
        "Ambient occlusion (channel r)."
    );
    OCCLUSION_STRENGTH = number!(
        "occlusion_strength",
        "occlusion strength",
        Range::UNIT,
        m => m.occlusion_strength,
        "How much of the occlusion applies."
    );
    EMISSIVE = color!("emissive", "emissive", Range::FACTOR, m => m.emissive, "Emitted radiance.");
    EMISSIVE_TEXTURE = texture!(
        "emissive_texture",
        Holds::Color,
        Some(&EMISSIVE),
        Texture m => m.emissive_texture,
        "Multiplies emissive."
    );

    // The clear coat.
    COAT = number!("coat", "clear coat mask", Range::UNIT, m => m.coat, "Clear coat mask.").knowing(F::Coat);
    COAT_TEXTURE = texture!(
        "coat_texture",
        Holds::Channel(0),
        Some(&COAT),
        Texture m => m.coat_texture,
        "Multiplies coat (channel r)."
    ).knowing(F::Coat);
    COAT_ROUGHNESS = number!(
        "coat_roughness",
        "clear coat roughness",
        Range::UNIT,
        m => m.coat_roughness,
        "Perceptual roughness of the coat."
    ).knowing(F::Coat);
    COAT_ROUGHNESS_TEXTURE = texture!(
        "coat_roughness_texture",
        Holds::Channel(1),
        Some(&COAT_ROUGHNESS),
        Texture m => m.coat_roughness_texture,
        "Multiplies coat_roughness (channel g)."
    ).knowing(F::Coat);
    COAT_NORMAL_TEXTURE = texture!(
        "coat_normal_texture",
        Holds::Normals,
        None,
        Normal m => m.coat_normal_texture,
        "Normals of the coat; without it the coat is smooth."
    ).knowing(F::CoatNormal);
    COAT_NORMAL_SCALE = Parameter::new(
        "coat_normal_scale",
        "normal scale",
        Kind::Number(
            NORMAL_SCALE.range(),
            Access {
                get: |m| m.coat_normal_texture.map_or(1.0, |n| n.scale),
                set: |m, value| {
                    if let Some(normal) = &mut m.coat_normal_texture {
                        normal.scale = value;
                    }
                },
            },
        ),
        "Multiplies x and y of coat_normal_texture.",
    ).knowing(F::CoatNormal).only(|m| m.coat_normal_texture.is_some());
    COAT_IOR = number!(
        "coat_ior",
        "clear coat index of refraction",
        Range::new(1.0, 3.0),
        m => m.lobes.coat.ior,
        "Index of refraction of the coat."
    ).knowing(F::CoatIor);
    COAT_THICKNESS = number!(
        "coat_thickness",
        "clear coat thickness",
        Range::FACTOR,
        m => m.lobes.coat.thickness.factor,
        "Thickness of the coat, in the length that coat_extinction is given for."
    ).knowing(F::CoatAbsorption);
    COAT_THICKNESS_TEXTURE = texture!(
        "coat_thickness_texture",
        Holds::Channel(0),
        Some(&COAT_THICKNESS),
        Scalar m => m.lobes.coat.thickness,
        "Multiplies coat_thickness (channel r)."
    ).knowing(F::CoatAbsorption);
    COAT_EXTINCTION = triple!(
        "coat_extinction",
        "clear coat extinction",
        Range::FACTOR,
        m => m.lobes.coat.extinction,
        "Extinction of red, green and blue in the coat per length."
    ).knowing(F::CoatAbsorption);
    COAT_COLOR = color!(
        "coat_color",
        "clear coat colour",
        Range::UNIT,
        m => m.lobes.coat.color.factor,
        "What the coat lets through, seen from above."
    ).knowing(F::CoatColor);
    COAT_COLOR_TEXTURE = texture!(
        "coat_color_texture",
        Holds::Color,
        Some(&COAT_COLOR),
        Texture m => m.lobes.coat.color.texture,
        "Multiplies coat_color."
    ).knowing(F::CoatColor);
    COAT_DARKENING = number!(
        "coat_darkening",
        "clear coat darkening",
        Range::UNIT,
        m => m.lobes.coat.darkening,
        "How much inner reflection darkens the base."
    ).knowing(F::CoatDarkening);
    COAT_ANISOTROPY = number!(
        "coat_anisotropy",
        "clear coat anisotropy",
        Range::UNIT,
        m => m.lobes.coat.anisotropy,
        "Anisotropy of the coat."
    ).knowing(F::CoatAnisotropy);

    COAT_PEEL = number!(
        "coat_peel",
        "orange peel",
        Range::UNIT,
        m => m.lobes.coat_surface.peel,
        "Orange peel of the coat: root mean square of its slopes; .005 is good, .03 bad."
    ).knowing(F::CoatNormal);
    COAT_PEEL_SIZE = number!(
        "coat_peel_size",
        "size of orange peel",
        PAINT_SIZE,
        m => m.lobes.coat_surface.peel_size,
        "Length of the waves of the orange peel."
    ).unit("metres").knowing(F::CoatNormal);
    COAT_SCRATCHES = number!(
        "coat_scratches",
        "scratches",
        Range::UNIT,
        m => m.lobes.coat_surface.scratches,
        "Share of the coat that scratches cover; .01 is many."
    ).knowing(F::CoatNormal);
    COAT_SCRATCH_LENGTH = number!(
        "coat_scratch_length",
        "length of scratches",
        PAINT_SIZE,
        m => m.lobes.coat_surface.scratch_length,
        "Length of a scratch."
    ).unit("metres").knowing(F::CoatNormal);
    COAT_SWIRL = number!(
        "coat_swirl",
        "swirl marks",
        Range::UNIT,
        m => m.lobes.coat_surface.swirl,
        "Share of the coat that swirl marks cover, seen in rings about lights; .05 is a car that brushes have washed."
    ).knowing(F::CoatNormal);
    COAT_SWIRL_SIZE = number!(
        "coat_swirl_size",
        "size of swirl marks",
        PAINT_SIZE,
        m => m.lobes.coat_surface.swirl_size,
        "Length of a swirl mark."
    ).unit("metres").knowing(F::CoatNormal);

    // Flakes in the base.
    FLAKES = number!(
        "flakes",
        "share of flakes",
        Range::UNIT,
        m => m.lobes.flakes.share,
        "Share of the base that flakes of metal or mica cover."
    );
    FLAKE_COLOR = color!(
        "flake_color",
        "colour of flakes",
        Range::UNIT,
        m => m.lobes.flakes.color,
        "Reflectance of a flake at normal incidence, beneath its film if it has one."
    );
    FLAKE_SIZE = number!(
        "flake_size",
        "size of flakes",
        PAINT_SIZE,
        m => m.lobes.flakes.size,
        "Diameter of a flake."
    ).unit("metres");
    FLAKE_SPREAD = number!(
        "flake_spread",
        "spread of flakes",
        Range::UNIT,
        m => m.lobes.flakes.spread,
        "How far flakes lie from flat: perceptual roughness of what smooth ones are together."
    );
    FLAKE_ROUGHNESS = number!(
        "flake_roughness",
        "roughness of flakes",
        Range::UNIT,
        m => m.lobes.flakes.roughness,
        "Perceptual roughness of each flake."
    );
    FLAKE_FILM_THICKNESS = number!(
        "flake_film_thickness",
        "thickness of the flakes' film",
        Range::new(0.0, 1e5),
        m => m.lobes.flakes.film_thickness,
        "Thickness of a film on the flakes (pearl); 0 is none."
    ).unit("nanometres");
    FLAKE_FILM_IOR = number!(
        "flake_film_ior",
        "index of refraction of the flakes' film",
        Range::new(1.5, 5.0),
        m => m.lobes.flakes.film_ior,
        "Index of refraction of the film, in paint of 1.5."
    );
    FLAKE_TRANSPARENCY = number!(
        "flake_transparency",
        "transparency of flakes",
        Range::UNIT,
        m => m.lobes.flakes.transparency,
        "How much of what flakes do not reflect reaches the base: 0 for metal, 1 for mica."
    );

    // Further lobes.
    ANISOTROPY = number!(
        "anisotropy",
        "anisotropy",
        Range::SIGNED,
        m => m.lobes.anisotropy.strength,
        "0 round; above, rougher along the tangent."
    ).knowing(F::Anisotropy);
    ANISOTROPY_ROTATION = number!(
        "anisotropy_rotation",
        "anisotropy rotation",
        Range::new(-1e4, 1e4),
        m => m.lobes.anisotropy.rotation,
        "Turns the tangent towards the bitangent."
    ).unit("radians").knowing(F::Anisotropy);
    ANISOTROPY_TEXTURE = texture!(
        "anisotropy_texture",
        Holds::Data,
        Some(&ANISOTROPY),
        Texture m => m.lobes.anisotropy.texture,
        "glTF's: direction in red and green, strength in blue."
    ).knowing(F::Anisotropy);
    SHEEN_COLOR = color!(
        "sheen_color",
        "sheen colour",
        Range::UNIT,
        m => m.lobes.sheen.color.factor,
        "Reflectance of fibres at grazing angles."
    ).knowing(F::Sheen);
    SHEEN_COLOR_TEXTURE = texture!(
        "sheen_color_texture",
        Holds::Color,
        Some(&SHEEN_COLOR),
        Texture m => m.lobes.sheen.color.texture,
        "Multiplies sheen_color."
    ).knowing(F::Sheen);
    SHEEN_ROUGHNESS = number!(
        "sheen_roughness",
        "sheen roughness",
        Range::UNIT,
        m => m.lobes.sheen.roughness.factor,
        "Perceptual roughness of the fibres."
    ).knowing(F::Sheen);
    SHEEN_ROUGHNESS_TEXTURE = texture!(
        "sheen_roughness_texture",
        Holds::Channel(0),
        Some(&SHEEN_ROUGHNESS),
        Scalar m => m.lobes.sheen.roughness,
        "Multiplies sheen_roughness (channel r; glTF's maps have it in a)."
    ).knowing(F::Sheen);
    IRIDESCENCE = number!(
        "iridescence",
        "iridescence mask",
        Range::UNIT,
        m => m.lobes.iridescence.mask.factor,
        "Mask of a thin film."
    ).knowing(F::Iridescence);
    IRIDESCENCE_TEXTURE = texture!(
        "iridescence_texture",
        Holds::Channel(0),
        Some(&IRIDESCENCE),
        Scalar m => m.lobes.iridescence.mask,
        "Multiplies iridescence (channel r)."
    ).knowing(F::Iridescence);
    IRIDESCENCE_IOR = number!(
        "iridescence_ior",
        "iridescence index of refraction",
        Range::new(1.0, 5.0),
        m => m.lobes.iridescence.ior,
        "Index of refraction of the film."
    ).knowing(F::Iridescence);
    IRIDESCENCE_THICKNESS = Parameter::new(
        "iridescence_thickness",
        "iridescence thickness",
        Kind::Pair(
            Range::new(0.0, 1e5),
            Access {
                get: |m| m.lobes.iridescence.thickness,
                set: |m, value| m.lobes.iridescence.thickness = value,
            },
        ),
        "Where the texture is 1 or there is none; of two numbers the first is where it is 0.",
    ).unit("nanometres").knowing(F::Iridescence);
    IRIDESCENCE_THICKNESS_TEXTURE = texture!(
        "iridescence_thickness_texture",
        Holds::Channel(1),
        None,
        Texture m => m.lobes.iridescence.thickness_texture,
        "From the least to the largest thickness (channel g)."
    ).knowing(F::Iridescence);
    IRIDESCENCE_COAT_FIXUP_TIR = number!(
        "iridescence_coat_fixup_tir",
        "iridescence fix-up",
        Range::UNIT,
        m => m.lobes.iridescence.coat_fixup_tir,
        "How much of the film's total reflection under a coat is made up for."
    ).of(STACKLIT);
    IRIDESCENCE_COAT_FIXUP_TIR_CLAMP = number!(
        "iridescence_coat_fixup_tir_clamp",
        "iridescence fix-up clamp",
        Range::UNIT,
        m => m.lobes.iridescence.coat_fixup_tir_clamp,
        "How far that may go."
    ).of(STACKLIT);
    SECOND_ROUGHNESS = number!(
        "second_roughness",
        "second lobe's roughness",
        Range::UNIT,
        m => m.lobes.second.roughness.factor,
        "Perceptual roughness of the second lobe."
    ).knowing(F::SecondLobe);
    SECOND_ROUGHNESS_TEXTURE = texture!(
        "second_roughness_texture",
        Holds::Channel(1),
        Some(&SECOND_ROUGHNESS),
        Scalar m => m.lobes.second.roughness,
        "Multiplies second_roughness (channel g)."
    ).knowing(F::SecondLobe);
    SECOND_ANISOTROPY = number!(
        "second_anisotropy",
        "second lobe's anisotropy",
        Range::SIGNED,
        m => m.lobes.second.anisotropy,
        "Anisotropy of the second lobe."
    ).knowing(F::SecondLobe);
    LOBE_MIX = number!(
        "lobe_mix",
        "lobe mix",
        Range::UNIT,
        m => m.lobes.second.mix.factor,
        "Share of the second lobe."
    ).knowing(F::SecondLobe);
    LOBE_MIX_TEXTURE = texture!(
        "lobe_mix_texture",
        Holds::Channel(0),
        Some(&LOBE_MIX),
        Scalar m => m.lobes.second.mix,
        "Multiplies lobe_mix (channel r)."
    ).knowing(F::SecondLobe);
    HAZINESS = number!(
        "haziness",
        "haziness",
        Range::UNIT,
        m => m.lobes.second.haziness.factor,
        "Haze around the highlight, in place of the second lobe's numbers."
    ).knowing(F::SecondLobe);
    HAZINESS_TEXTURE = texture!(
        "haziness_texture",
        Holds::Channel(0),
        Some(&HAZINESS),
        Scalar m => m.lobes.second.haziness,
        "Multiplies haziness (channel r)."
    ).knowing(F::SecondLobe);
    HAZE_EXTENT = number!(
        "haze_extent",
        "haze extent",
        Range::new(0.0, 1e3),
        m => m.lobes.second.haze_extent,
        "How far haze extends."
    ).knowing(F::SecondLobe);
    HAZE_MAX_DIELECTRIC_F0 = number!(
        "haze_max_dielectric_f0",
        "haze's largest dielectric F0",
        Range::UNIT,
        m => m.lobes.second.haze_max_dielectric_f0,
        "Most F0 that haze may give a dielectric."
    ).knowing(F::SecondLobe);
    SUBSURFACE = number!(
        "subsurface",
        "subsurface mask",
        Range::UNIT,
        m => m.lobes.subsurface.mask.factor,
        "Mask of light in and through the base."
    ).of(STACKLIT);
    SUBSURFACE_TEXTURE = texture!(
        "subsurface_texture",
        Holds::Channel(0),
        Some(&SUBSURFACE),
        Scalar m => m.lobes.subsurface.mask,
        "Multiplies subsurface (channel r)."
    ).of(STACKLIT);
    SCATTERING_DISTANCE = triple!(
        "scattering_distance",
        "scattering distance",
        Range::new(1e-3, MAX_FACTOR),
        m => m.lobes.subsurface.scattering_distance,
        "How far red, green and blue go."
    ).unit("millimetres").of(STACKLIT);
    SUBSURFACE_TRANSMISSION = color!(
        "subsurface_transmission",
        "transmission",
        Range::UNIT,
        m => m.lobes.subsurface.transmission,
        "Colour of light that the subsurface lets through."
    ).knowing(F::Subsurface);
    SUBSURFACE_THICKNESS = number!(
        "subsurface_thickness",
        "subsurface thickness",
        Range::FACTOR,
        m => m.lobes.subsurface.thickness.factor,
        "Thickness that this light crosses."
    ).unit("millimetres").of(STACKLIT);
    SUBSURFACE_THICKNESS_TEXTURE = texture!(
        "subsurface_thickness_texture",
        Holds::Channel(0),
        Some(&SUBSURFACE_THICKNESS),
        Scalar m => m.lobes.subsurface.thickness,
        "Multiplies subsurface_thickness (channel r)."
    ).of(STACKLIT);
    SUBSURFACE_IOR = number!(
        "subsurface_ior",
        "subsurface index of refraction",
        Range::new(1.0, 2.0),
        m => m.lobes.subsurface.ior,
        "Index of refraction of what light goes through."
    ).of(STACKLIT);
    SUBSURFACE_POST_SCATTER = switch!(
        "subsurface_post_scatter",
        m => m.lobes.subsurface.post_scatter,
        "The base colour applies after scattering only, instead of half before and half after."
    ).of(STACKLIT);

    // Light that passes through, in every model.
    TRANSMISSION = number!(
        "transmission",
        "transmission factor",
        Range::UNIT,
        m => m.lobes.transmission.factor.factor,
        "Share of the light that is not reflected that passes straight through; what is behind shows."
    );
    TRANSMISSION_TEXTURE = texture!(
        "transmission_texture",
        Holds::Channel(0),
        Some(&TRANSMISSION),
        Scalar m => m.lobes.transmission.factor,
        "Multiplies transmission (channel r)."
    );
    DIFFUSE_TRANSMISSION = number!(
        "diffuse_transmission",
        "diffuse transmission",
        Range::UNIT,
        m => m.lobes.transmission.diffuse.factor,
        "Share of the rest that leaves on the other side in all directions."
    );
    DIFFUSE_TRANSMISSION_TEXTURE = texture!(
        "diffuse_transmission_texture",
        Holds::Channel(0),
        Some(&DIFFUSE_TRANSMISSION),
        Scalar m => m.lobes.transmission.diffuse,
        "Multiplies diffuse_transmission (channel r; glTF's maps have it in a)."
    );
    DIFFUSE_TRANSMISSION_COLOR = color!(
        "diffuse_transmission_color",
        "diffuse transmission colour",
        Range::UNIT,
        m => m.lobes.transmission.diffuse_color.factor,
        "Colour of that diffuse light."
    );
    DIFFUSE_TRANSMISSION_COLOR_TEXTURE = texture!(
        "diffuse_transmission_color_texture",
        Holds::Color,
        Some(&DIFFUSE_TRANSMISSION_COLOR),
        Texture m => m.lobes.transmission.diffuse_color.texture,
        "Multiplies diffuse_transmission_color."
    );
    THICKNESS = number!(
        "thickness",
        "volume thickness",
        Range::FACTOR,
        m => m.lobes.transmission.thickness.factor,
        "Thickness of the volume beneath in units of the mesh; a surface with 0 is a thin wall and does not refract."
    );
    THICKNESS_TEXTURE = texture!(
        "thickness_texture",
        Holds::Channel(1),
        Some(&THICKNESS),
        Scalar m => m.lobes.transmission.thickness,
        "Multiplies thickness (channel g)."
    );
    ATTENUATION_COLOR = color!(
        "attenuation_color",
        "attenuation colour",
        Range::UNIT,
        m => m.lobes.transmission.attenuation_color,
        "What white light becomes on its way of attenuation_distance through the volume."
    );
    ATTENUATION_DISTANCE = number!(
        "attenuation_distance",
        "attenuation distance",
        Range::new(f32::MIN_POSITIVE, f32::INFINITY),
        m => m.lobes.transmission.attenuation_distance,
        "In units of the scene; with 0 nothing is absorbed."
    );
    DISPERSION = number!(
        "dispersion",
        "dispersion",
        Range::new(0.0, 1e3),
        m => m.lobes.transmission.dispersion,
        "20 over the Abbe number: how far apart the volume refracts red and blue."
    );

    // Occlusion of reflections.
    SPECULAR_OCCLUSION = number!(
        "specular_occlusion",
        "specular occlusion",
        Range::UNIT,
        m => m.lobes.occlusion.specular.factor,
        "Visibility of reflections, for options.stacklit_specular_occlusion = \"custom\"."
    ).knowing(F::ReflectionOcclusion);
    SPECULAR_OCCLUSION_TEXTURE = texture!(
        "specular_occlusion_texture",
        Holds::Channel(0),
        Some(&SPECULAR_OCCLUSION),
        Scalar m => m.lobes.occlusion.specular,
        "Multiplies specular_occlusion (channel r)."
    ).knowing(F::ReflectionOcclusion);
    BENT_NORMAL_TEXTURE = texture!(
        "bent_normal_texture",
        Holds::Normals,
        None,
        Normal m => m.lobes.occlusion.bent_normal,
        "Mean of the directions that are not occluded, for the cones of options.stacklit_specular_occlusion."
    ).knowing(F::ReflectionOcclusion);

    // Switches of the models.
    STACKLIT_RECOMPUTE_PER_LIGHT = switch!(
        "options.stacklit_recompute_per_light",
        m => m.options.stacklit.recompute_per_light,
        "The layers are added up for every light, from its half vector."
    ).of(STACKLIT);
    STACKLIT_REFRACTED_ANGLES = switch!(
        "options.stacklit_refracted_angles",
        m => m.options.stacklit.refracted_angles,
        "The base sees light and viewer refracted."
    ).of(STACKLIT);
    STACKLIT_DUAL_NORMAL_FIX = choice!(
        "options.stacklit_dual_normal_fix",
        DualNormalFix,
        m => m.options.stacklit.dual_normal_fix,
        "The cosine at the coat where coat and base have normals of their own."
    ).of(STACKLIT);
    STACKLIT_HONOR_LIGHT_MINIMUM_ROUGHNESS = switch!(
        "options.stacklit_honor_light_minimum_roughness",
        m => m.options.stacklit.honor_light_minimum_roughness,
        "A light's own least roughness."
    ).of(STACKLIT);
    STACKLIT_SPECULAR_OCCLUSION = choice!(
        "options.stacklit_specular_occlusion",
        SpecularOcclusionMethod,
        m => m.options.stacklit.specular_occlusion,
        "Where the occlusion of reflections comes from. Unity's pivot method is not offered: its table is in no public text."
    ).of(STACKLIT);
    STACKLIT_OCCLUSION_CONE = choice!(
        "options.stacklit_occlusion_cone",
        OcclusionCone,
        m => m.options.stacklit.occlusion_cone,
        "How the ambient occlusion was weighted when it was baked, for the cones."
    ).of(STACKLIT);
    STACKLIT_NO_ENERGY_COMPENSATION = switch!(
        "options.stacklit_no_energy_compensation",
        m => m.options.stacklit.no_energy_compensation,
        "Light that is lost between microfacets stays lost."
    ).of(STACKLIT);
    STACKLIT_NO_SPECULAR_ENERGY_CONSERVATION = switch!(
        "options.stacklit_no_specular_energy_conservation",
        m => m.options.stacklit.no_specular_energy_conservation,
        "In the specular workflow, the base colour is not dimmed by the specular colour."
    ).of(STACKLIT);
    STACKLIT_NEWEST = switch!(
        "options.stacklit_newest",
        m => m.options.stacklit.newest,
        "The newest text of the conversion instead of 13.0's."
    ).of(STACKLIT);
    FILAMENT_COAT_IOR_CHANGE = switch!(
        "options.filament_coat_ior_change",
        m => m.options.filament.coat_ior_change,
        "F0 of the base becomes that of its interface with the coat."
    ).of(&[ShadingModel::Filament, ShadingModel::FilamentMobile]);
    FILAMENT_2018_SINGLE_ATTENUATION = switch!(
        "options.filament_2018_single_attenuation",
        m => m.options.filament_2018.single_attenuation,
        "The later document's attenuation, which darkens the base's specular once."
    ).of(&[ShadingModel::Filament2018]);
    THREE_R119 = switch!("options.three_r119", m => m.options.three.r119, "r119 instead of r131.")
        .of(&[ShadingModel::ThreeLegacy]);
    GLTF_FIXED_COAT_F0 = switch!(
        "options.gltf_fixed_coat_f0",
        m => m.options.gltf.fixed_coat_f0,
        "The coat's F0 is 0.04 instead of that of the base's index of refraction."
    ).of(&[ShadingModel::Gltf, ShadingModel::GltfSampled]);
    GLTF_SINGLE_SCATTERING = switch!(
        "options.gltf_single_scattering",
        m => m.options.gltf.single_scattering,
        "Light that is lost between microfacets stays lost."
    ).of(&[ShadingModel::GltfSampled]);
    OPENPBR_SINGLE_SCATTERING = switch!(
        "options.openpbr_single_scattering",
        m => m.options.openpbr.single_scattering,
        "Light that is lost between microfacets stays lost."
    ).of(&[ShadingModel::OpenPbr]);
    BABYLON_REMAP_F0 = switch!(
        "options.babylon_remap_f0",
        m => m.options.babylon.remap_f0,
        "F0 of the base becomes that of its interface with the coat."
    ).of(&[ShadingModel::Babylon]);
}

fn is_specular(m: &Material) -> bool {
    matches!(m.workflow, Workflow::SpecularGlossiness { .. })
}

fn is_metallic(m: &Material) -> bool {
    matches!(m.workflow, Workflow::MetallicRoughness { .. })
}

/// Metallic, roughness and their texture, of a material that is turned to that workflow if it has the other.
fn metallic_workflow(m: &mut Material) -> (&mut f32, &mut f32, &mut Option<TextureRef>) {
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
