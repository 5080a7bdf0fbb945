//! What glTF calls the parameters of materials: where each number and texture stands in the JSON. Reading a material and
//! animating it (KHR_animation_pointer) go by this one table.

use super::model::{
    Clearcoat, ClearcoatColor, ClearcoatDarkening, ClearcoatExtensions, Coat, DiffuseTransmission,
    Iridescence, Material, MaterialExtensions, MetallicRoughness, OneNumber, Sheen, Specular,
    SpecularGlossiness, TextureInfo,
};
use overcoat_scene as scene;
use overcoat_scene::parameters::{self as p, Parameter, Range};

/// A property of materials.
#[derive(Debug)]
pub(super) enum Property {
    /// One to four numbers.
    Number(Number),
    /// A texture.
    Texture(Texture),
    /// What is not read.
    Unread(Unread),
}

/// Numbers in a material of the file.
#[derive(Debug)]
pub(super) struct Number {
    /// JSON pointer from the material.
    pub(super) path: &'static str,
    pub(super) goal: Goal,
    /// What the specification takes.
    pub(super) range: Range,
    pub(super) width: usize,
    /// True of indices of refraction where 0 stands for a reflectance of 1, as if they were infinite.
    zero_is_infinite: bool,
    read: fn(&Material) -> Option<[f32; 4]>,
}

/// What a number becomes.
#[derive(Clone, Copy, Debug)]
pub(super) enum Goal {
    /// The parameter.
    Whole(&'static Parameter),
    /// One of the parameter's numbers.
    Part(&'static Parameter, usize),
    /// Emitted radiance, before its strength.
    Emission,
    /// What multiplies it.
    EmissionStrength,
}

/// A member that has no parameter.
#[derive(Debug)]
pub(super) struct Unread {
    path: &'static str,
    /// What is drawn instead.
    pub(super) instead: &'static str,
    /// True if the file has it, and it would show.
    pub(super) matters: fn(&Material) -> bool,
}

/// A texture in a material of the file.
#[derive(Debug)]
pub(super) struct Texture {
    /// JSON pointer from the material.
    pub(super) path: &'static str,
    pub(super) parameter: &'static Parameter,
    /// The channel that is read, where a material says which.
    pub(super) channel: u8,
    pub(super) read: fn(&Material) -> Option<&TextureInfo>,
}

const fn number(
    path: &'static str,
    parameter: &'static Parameter,
    read: fn(&Material) -> Option<[f32; 4]>,
) -> Property {
    let (range, width) = (parameter.range(), parameter.width());
    Property::Number(Number {
        path,
        goal: Goal::Whole(parameter),
        range,
        width,
        zero_is_infinite: false,
        read,
    })
}

const fn coat_ior(path: &'static str, read: fn(&Material) -> Option<[f32; 4]>) -> Property {
    let (goal, range) = (Goal::Whole(&p::COAT_IOR), p::COAT_IOR.range());
    Property::Number(Number { path, goal, range, width: 1, zero_is_infinite: true, read })
}

const fn unread(path: &'static str, instead: &'static str, matters: fn(&Material) -> bool) -> Property {
    Property::Unread(Unread { path, instead, matters })
}

const fn part(
    path: &'static str,
    parameter: &'static Parameter,
    place: usize,
    read: fn(&Material) -> Option<[f32; 4]>,
) -> Property {
    Property::Number(Number {
        path,
        goal: Goal::Part(parameter, place),
        range: parameter.range(),
        width: 1,
        zero_is_infinite: false,
        read,
    })
}

const fn texture(
    path: &'static str,
    parameter: &'static Parameter,
    read: fn(&Material) -> Option<&TextureInfo>,
) -> Property {
    channel(path, parameter, 0, read)
}

const fn channel(
    path: &'static str,
    parameter: &'static Parameter,
    channel: u8,
    read: fn(&Material) -> Option<&TextureInfo>,
) -> Property {
    Property::Texture(Texture { path, parameter, channel, read })
}

/// The objects of a material.
fn base(m: &Material) -> Option<&MetallicRoughness> {
    m.pbr_metallic_roughness.as_deref()
}

fn extensions(m: &Material) -> Option<&MaterialExtensions> {
    m.extensions.as_deref()
}

fn glossy(m: &Material) -> Option<&SpecularGlossiness> {
    extensions(m)?.specular_glossiness.as_ref()
}

fn specular(m: &Material) -> Option<&Specular> {
    extensions(m)?.specular.as_ref()
}

fn coat(m: &Material) -> Option<&Coat> {
    extensions(m)?.coat.as_deref()
}

fn clearcoat(m: &Material) -> Option<&Clearcoat> {
    extensions(m)?.clearcoat.as_ref()
}

fn clearcoat_extensions(m: &Material) -> Option<&ClearcoatExtensions> {
    clearcoat(m)?.extensions.as_deref()
}

fn color(m: &Material) -> Option<&ClearcoatColor> {
    clearcoat_extensions(m)?.color.as_ref()
}

fn ext_color(m: &Material) -> Option<&ClearcoatColor> {
    clearcoat_extensions(m)?.ext_color.as_ref()
}

fn darkening(m: &Material) -> Option<&ClearcoatDarkening> {
    clearcoat_extensions(m)?.darkening.as_ref()
}

fn ext_darkening(m: &Material) -> Option<&ClearcoatDarkening> {
    clearcoat_extensions(m)?.ext_darkening.as_ref()
}

/// True if a coat has anisotropy.
fn is_stretched(coat: &Coat) -> bool {
    coat.coat_factor.unwrap_or(0.0) > 0.0 && coat.coat_anisotropy_strength.unwrap_or(0.0) > 0.0
}

fn sheen(m: &Material) -> Option<&Sheen> {
    extensions(m)?.sheen.as_deref()
}

fn film(m: &Material) -> Option<&Iridescence> {
    extensions(m)?.iridescence.as_deref()
}

fn diffuse(m: &Material) -> Option<&DiffuseTransmission> {
    extensions(m)?.diffuse_transmission.as_deref()
}

/// As many numbers as there are.
fn one(value: Option<f32>) -> Option<[f32; 4]> {
    value.map(|v| [v, 0.0, 0.0, 0.0])
}

fn three(value: Option<[f32; 3]>) -> Option<[f32; 4]> {
    value.map(|[r, g, b]| [r, g, b, 0.0])
}

/// All that is read of materials, in the order in which it is.
pub(super) static PROPERTIES: &[Property] = &[
    number("alphaCutoff", &p::ALPHA_CUTOFF, |m| one(m.alpha_cutoff)),
    number("pbrMetallicRoughness/baseColorFactor", &p::BASE_COLOR, |m| base(m)?.base_color_factor),
    texture("pbrMetallicRoughness/baseColorTexture", &p::BASE_COLOR_TEXTURE, |m| {
        base(m)?.base_color_texture.as_ref()
    }),
    number("pbrMetallicRoughness/metallicFactor", &p::METALLIC, |m| one(base(m)?.metallic_factor)),
    number("pbrMetallicRoughness/roughnessFactor", &p::ROUGHNESS, |m| one(base(m)?.roughness_factor)),
    texture("pbrMetallicRoughness/metallicRoughnessTexture", &p::METALLIC_ROUGHNESS_TEXTURE, |m| {
        base(m)?.metallic_roughness_texture.as_ref()
    }),
    number("extensions/KHR_materials_pbrSpecularGlossiness/diffuseFactor", &p::BASE_COLOR, |m| {
        glossy(m)?.diffuse_factor
    }),
    texture("extensions/KHR_materials_pbrSpecularGlossiness/diffuseTexture", &p::BASE_COLOR_TEXTURE, |m| {
        glossy(m)?.diffuse_texture.as_ref()
    }),
    number("extensions/KHR_materials_pbrSpecularGlossiness/specularFactor", &p::SPECULAR_F0, |m| {
        three(glossy(m)?.specular_factor)
    }),
    number("extensions/KHR_materials_pbrSpecularGlossiness/glossinessFactor", &p::GLOSSINESS, |m| {
        one(glossy(m)?.glossiness_factor)
    }),
    texture(
        "extensions/KHR_materials_pbrSpecularGlossiness/specularGlossinessTexture",
        &p::SPECULAR_GLOSSINESS_TEXTURE,
        |m| glossy(m)?.specular_glossiness_texture.as_ref(),
    ),
    texture("normalTexture", &p::NORMAL_TEXTURE, |m| m.normal_texture.as_deref()),
    number("normalTexture/scale", &p::NORMAL_SCALE, |m| one(m.normal_texture.as_ref()?.scale)),
    texture("occlusionTexture", &p::OCCLUSION_TEXTURE, |m| m.occlusion_texture.as_deref()),
    number("occlusionTexture/strength", &p::OCCLUSION_STRENGTH, |m| {
        one(m.occlusion_texture.as_ref()?.strength)
    }),
    Property::Number(Number {
        path: "emissiveFactor",
        goal: Goal::Emission,
        range: Range::UNIT,
        width: 3,
        zero_is_infinite: false,
        read: |m| three(m.emissive_factor.as_deref().copied()),
    }),
    texture("emissiveTexture", &p::EMISSIVE_TEXTURE, |m| m.emissive_texture.as_deref()),
    Property::Number(Number {
        path: "extensions/KHR_materials_emissive_strength/emissiveStrength",
        goal: Goal::EmissionStrength,
        range: Range::FACTOR,
        width: 1,
        zero_is_infinite: false,
        read: |m| one(extensions(m)?.emissive_strength.as_ref()?.emissive_strength),
    }),
    number("extensions/KHR_materials_ior/ior", &p::IOR, |m| one(extensions(m)?.ior.as_ref()?.ior)),
    number("extensions/KHR_materials_specular/specularFactor", &p::SPECULAR, |m| {
        one(specular(m)?.specular_factor)
    }),
    texture("extensions/KHR_materials_specular/specularTexture", &p::SPECULAR_TEXTURE, |m| {
        specular(m)?.specular_texture.as_ref()
    }),
    number("extensions/KHR_materials_specular/specularColorFactor", &p::SPECULAR_COLOR, |m| {
        three(specular(m)?.specular_color_factor)
    }),
    texture("extensions/KHR_materials_specular/specularColorTexture", &p::SPECULAR_COLOR_TEXTURE, |m| {
        specular(m)?.specular_color_texture.as_ref()
    }),
    number("extensions/KHR_materials_clearcoat/clearcoatFactor", &p::COAT, |m| {
        one(clearcoat(m)?.clearcoat_factor)
    }),
    texture("extensions/KHR_materials_clearcoat/clearcoatTexture", &p::COAT_TEXTURE, |m| {
        clearcoat(m)?.clearcoat_texture.as_ref()
    }),
    number("extensions/KHR_materials_clearcoat/clearcoatRoughnessFactor", &p::COAT_ROUGHNESS, |m| {
        one(clearcoat(m)?.clearcoat_roughness_factor)
    }),
    texture(
        "extensions/KHR_materials_clearcoat/clearcoatRoughnessTexture",
        &p::COAT_ROUGHNESS_TEXTURE,
        |m| clearcoat(m)?.clearcoat_roughness_texture.as_ref(),
    ),
    texture("extensions/KHR_materials_clearcoat/clearcoatNormalTexture", &p::COAT_NORMAL_TEXTURE, |m| {
        clearcoat(m)?.clearcoat_normal_texture.as_ref()
    }),
    number("extensions/KHR_materials_clearcoat/clearcoatNormalTexture/scale", &p::COAT_NORMAL_SCALE, |m| {
        one(clearcoat(m)?.clearcoat_normal_texture.as_ref()?.scale)
    }),
    coat_ior("extensions/KHR_materials_clearcoat/extensions/KHR_materials_clearcoat_ior/clearcoatIor", |m| {
        one(clearcoat_extensions(m)?.ior.as_ref()?.clearcoat_ior)
    }),
    number(
        "extensions/KHR_materials_clearcoat/extensions/EXT_materials_clearcoat_color/clearcoatColorFactor",
        &p::COAT_COLOR,
        |m| three(ext_color(m)?.clearcoat_color_factor),
    ),
    texture(
        "extensions/KHR_materials_clearcoat/extensions/EXT_materials_clearcoat_color/clearcoatColorTexture",
        &p::COAT_COLOR_TEXTURE,
        |m| ext_color(m)?.clearcoat_color_texture.as_ref(),
    ),
    number(
        "extensions/KHR_materials_clearcoat/extensions/KHR_materials_clearcoat_color/clearcoatColorFactor",
        &p::COAT_COLOR,
        |m| three(color(m)?.clearcoat_color_factor),
    ),
    texture(
        "extensions/KHR_materials_clearcoat/extensions/KHR_materials_clearcoat_color/clearcoatColorTexture",
        &p::COAT_COLOR_TEXTURE,
        |m| color(m)?.clearcoat_color_texture.as_ref(),
    ),
    number(
        "extensions/KHR_materials_clearcoat/extensions/EXT_materials_clearcoat_darkening/clearcoatDarkeningFactor",
        &p::COAT_DARKENING,
        |m| one(ext_darkening(m)?.clearcoat_darkening_factor.map(OneNumber::get)),
    ),
    unread(
        "extensions/KHR_materials_clearcoat/extensions/EXT_materials_clearcoat_darkening/clearcoatDarkeningTexture",
        "the factor alone holds",
        |m| ext_darkening(m).is_some_and(|d| d.clearcoat_darkening_texture.is_some()),
    ),
    number(
        "extensions/KHR_materials_clearcoat/extensions/KHR_materials_clearcoat_darkening/clearcoatDarkeningFactor",
        &p::COAT_DARKENING,
        |m| one(darkening(m)?.clearcoat_darkening_factor.map(OneNumber::get)),
    ),
    unread(
        "extensions/KHR_materials_clearcoat/extensions/KHR_materials_clearcoat_darkening/clearcoatDarkeningTexture",
        "the factor alone holds",
        |m| darkening(m).is_some_and(|d| d.clearcoat_darkening_texture.is_some()),
    ),
    // The draft multiplies what is beneath by colour and darkening wherever the coat is, even with a weight of 0, of which it
    // also says that there is no coat. Here the weight is that of all of the coat, as every model has it.
    number("extensions/KHR_materials_coat/coatFactor", &p::COAT, |m| one(coat(m)?.coat_factor)),
    texture("extensions/KHR_materials_coat/coatTexture", &p::COAT_TEXTURE, |m| {
        coat(m)?.coat_texture.as_ref()
    }),
    number("extensions/KHR_materials_coat/coatRoughnessFactor", &p::COAT_ROUGHNESS, |m| {
        one(coat(m)?.coat_roughness_factor)
    }),
    texture("extensions/KHR_materials_coat/coatRoughnessTexture", &p::COAT_ROUGHNESS_TEXTURE, |m| {
        coat(m)?.coat_roughness_texture.as_ref()
    }),
    texture("extensions/KHR_materials_coat/coatNormalTexture", &p::COAT_NORMAL_TEXTURE, |m| {
        coat(m)?.coat_normal_texture.as_ref()
    }),
    number("extensions/KHR_materials_coat/coatNormalTexture/scale", &p::COAT_NORMAL_SCALE, |m| {
        one(coat(m)?.coat_normal_texture.as_ref()?.scale)
    }),
    coat_ior("extensions/KHR_materials_coat/coatIor", |m| one(coat(m)?.coat_ior)),
    number("extensions/KHR_materials_coat/coatColorFactor", &p::COAT_COLOR, |m| {
        three(coat(m)?.coat_color_factor)
    }),
    texture("extensions/KHR_materials_coat/coatColorTexture", &p::COAT_COLOR_TEXTURE, |m| {
        coat(m)?.coat_color_texture.as_ref()
    }),
    number("extensions/KHR_materials_coat/coatDarkeningFactor", &p::COAT_DARKENING, |m| {
        one(coat(m)?.coat_darkening_factor)
    }),
    number("extensions/KHR_materials_coat/coatAnisotropyStrength", &p::COAT_ANISOTROPY, |m| {
        one(coat(m)?.coat_anisotropy_strength)
    }),
    unread(
        "extensions/KHR_materials_coat/coatAnisotropyRotation",
        "the coat is stretched along the tangent of the base",
        |m| coat(m).is_some_and(|c| is_stretched(c) && c.coat_anisotropy_rotation.unwrap_or(0.0) != 0.0),
    ),
    unread(
        "extensions/KHR_materials_coat/coatAnisotropyTexture",
        "the coat is stretched along the tangent of the base",
        |m| coat(m).is_some_and(|c| is_stretched(c) && c.coat_anisotropy_texture.is_some()),
    ),
    number("extensions/KHR_materials_sheen/sheenColorFactor", &p::SHEEN_COLOR, |m| {
        three(sheen(m)?.sheen_color_factor)
    }),
    texture("extensions/KHR_materials_sheen/sheenColorTexture", &p::SHEEN_COLOR_TEXTURE, |m| {
        sheen(m)?.sheen_color_texture.as_ref()
    }),
    number("extensions/KHR_materials_sheen/sheenRoughnessFactor", &p::SHEEN_ROUGHNESS, |m| {
        one(sheen(m)?.sheen_roughness_factor)
    }),
    channel("extensions/KHR_materials_sheen/sheenRoughnessTexture", &p::SHEEN_ROUGHNESS_TEXTURE, 3, |m| {
        sheen(m)?.sheen_roughness_texture.as_ref()
    }),
    Property::Number(Number {
        path: "extensions/KHR_materials_anisotropy/anisotropyStrength",
        goal: Goal::Whole(&p::ANISOTROPY),
        range: Range::UNIT,
        width: 1,
        zero_is_infinite: false,
        read: |m| one(extensions(m)?.anisotropy.as_ref()?.anisotropy_strength),
    }),
    number("extensions/KHR_materials_anisotropy/anisotropyRotation", &p::ANISOTROPY_ROTATION, |m| {
        one(extensions(m)?.anisotropy.as_ref()?.anisotropy_rotation)
    }),
    texture("extensions/KHR_materials_anisotropy/anisotropyTexture", &p::ANISOTROPY_TEXTURE, |m| {
        extensions(m)?.anisotropy.as_ref()?.anisotropy_texture.as_ref()
    }),
    number("extensions/KHR_materials_iridescence/iridescenceFactor", &p::IRIDESCENCE, |m| {
        one(film(m)?.iridescence_factor)
    }),
    channel("extensions/KHR_materials_iridescence/iridescenceTexture", &p::IRIDESCENCE_TEXTURE, 0, |m| {
        film(m)?.iridescence_texture.as_ref()
    }),
    number("extensions/KHR_materials_iridescence/iridescenceIor", &p::IRIDESCENCE_IOR, |m| {
        one(film(m)?.iridescence_ior)
    }),
    part(
        "extensions/KHR_materials_iridescence/iridescenceThicknessMinimum",
        &p::IRIDESCENCE_THICKNESS,
        0,
        |m| one(film(m)?.iridescence_thickness_minimum),
    ),
    part(
        "extensions/KHR_materials_iridescence/iridescenceThicknessMaximum",
        &p::IRIDESCENCE_THICKNESS,
        1,
        |m| one(film(m)?.iridescence_thickness_maximum),
    ),
    texture(
        "extensions/KHR_materials_iridescence/iridescenceThicknessTexture",
        &p::IRIDESCENCE_THICKNESS_TEXTURE,
        |m| film(m)?.iridescence_thickness_texture.as_ref(),
    ),
    number("extensions/KHR_materials_transmission/transmissionFactor", &p::TRANSMISSION, |m| {
        one(extensions(m)?.transmission.as_ref()?.transmission_factor)
    }),
    channel("extensions/KHR_materials_transmission/transmissionTexture", &p::TRANSMISSION_TEXTURE, 0, |m| {
        extensions(m)?.transmission.as_ref()?.transmission_texture.as_ref()
    }),
    number(
        "extensions/KHR_materials_diffuse_transmission/diffuseTransmissionFactor",
        &p::DIFFUSE_TRANSMISSION,
        |m| one(diffuse(m)?.diffuse_transmission_factor),
    ),
    channel(
        "extensions/KHR_materials_diffuse_transmission/diffuseTransmissionTexture",
        &p::DIFFUSE_TRANSMISSION_TEXTURE,
        3,
        |m| diffuse(m)?.diffuse_transmission_texture.as_ref(),
    ),
    number(
        "extensions/KHR_materials_diffuse_transmission/diffuseTransmissionColorFactor",
        &p::DIFFUSE_TRANSMISSION_COLOR,
        |m| three(diffuse(m)?.diffuse_transmission_color_factor),
    ),
    texture(
        "extensions/KHR_materials_diffuse_transmission/diffuseTransmissionColorTexture",
        &p::DIFFUSE_TRANSMISSION_COLOR_TEXTURE,
        |m| diffuse(m)?.diffuse_transmission_color_texture.as_ref(),
    ),
    number("extensions/KHR_materials_volume/thicknessFactor", &p::THICKNESS, |m| {
        one(extensions(m)?.volume.as_ref()?.thickness_factor)
    }),
    channel("extensions/KHR_materials_volume/thicknessTexture", &p::THICKNESS_TEXTURE, 1, |m| {
        extensions(m)?.volume.as_ref()?.thickness_texture.as_ref()
    }),
    number("extensions/KHR_materials_volume/attenuationColor", &p::ATTENUATION_COLOR, |m| {
        three(extensions(m)?.volume.as_ref()?.attenuation_color)
    }),
    number("extensions/KHR_materials_volume/attenuationDistance", &p::ATTENUATION_DISTANCE, |m| {
        one(extensions(m)?.volume.as_ref()?.attenuation_distance)
    }),
    number("extensions/KHR_materials_dispersion/dispersion", &p::DISPERSION, |m| {
        one(extensions(m)?.dispersion.as_ref()?.dispersion)
    }),
];

impl Property {
    pub(super) fn path(&self) -> &'static str {
        match self {
            Self::Number(number) => number.path,
            Self::Texture(texture) => texture.path,
            Self::Unread(unread) => unread.path,
        }
    }

    /// What messages call it: the last name of its path, with the texture that it belongs to.
    pub(super) fn label(&self) -> String {
        let mut names = self.path().rsplit('/');
        let last = names.next().unwrap_or_default();
        match names.next() {
            Some(parent) if parent.ends_with("Texture") => format!("{parent}.{last}"),
            _ => last.to_owned(),
        }
    }

    /// False where the material has another property in its place. Where one is given in both workflows, that of the
    /// extension is drawn, and the other is the substitute, of which nothing is read; likewise the coats.
    pub(super) fn applies(&self, given: &Material) -> bool {
        let of = |object: &str| self.path().starts_with(object);
        if of("pbrMetallicRoughness/") {
            glossy(given).is_none()
        } else if of("extensions/KHR_materials_pbrSpecularGlossiness/") {
            glossy(given).is_some()
        } else if of("extensions/KHR_materials_clearcoat/") {
            coat(given).is_none()
        } else {
            true
        }
    }
}

impl Number {
    /// The numbers that the file gives, if it does.
    pub(super) fn read(&self, given: &Material) -> Option<[f32; 4]> {
        (self.read)(given)
    }

    /// The nearest number that is taken.
    pub(super) fn clamp(&self, value: f64) -> f32 {
        if self.zero_is_infinite && value == 0.0 { self.range.high } else { self.range.clamp(value) }
    }

    /// Sets the parameter of a scene's material, if it has that; not emission, which is a product.
    pub(super) fn set(&self, material: &mut scene::Material, values: [f32; 4]) {
        match self.goal {
            Goal::Whole(parameter) if parameter.is_in(material) => parameter.set_numbers(material, values),
            Goal::Part(parameter, place) if parameter.is_in(material) => {
                let mut all = parameter.numbers(material);
                if let (Some(part), [value, ..]) = (all.get_mut(place), values) {
                    *part = value;
                }
                parameter.set_numbers(material, all);
            }
            Goal::Whole(_) | Goal::Part(..) | Goal::Emission | Goal::EmissionStrength => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use overcoat_scene::parameters::Kind;
    use std::collections::BTreeSet;

    #[test]
    fn paths_are_unique_and_textures_have_slots() {
        let paths: BTreeSet<&str> = PROPERTIES.iter().map(Property::path).collect();
        assert_eq!(paths.len(), PROPERTIES.len());
        for property in PROPERTIES {
            match property {
                Property::Texture(texture) => {
                    assert!(matches!(texture.parameter.kind, Kind::Texture(_)), "{}", texture.path);
                }
                Property::Number(number) => match number.goal {
                    Goal::Whole(parameter) => {
                        assert_eq!(number.width, parameter.width(), "{}", number.path);
                        let (narrow, wide) = (number.range, parameter.range());
                        assert!(wide.low <= narrow.low && narrow.high <= wide.high, "{}", number.path);
                    }
                    Goal::Part(parameter, place) => assert!(place < parameter.width()),
                    Goal::Emission | Goal::EmissionStrength => {}
                },
                Property::Unread(unread) => assert!(!unread.instead.is_empty()),
            }
        }
    }

    #[test]
    fn labels_say_what_stands_in_the_file() {
        let labels: Vec<String> = PROPERTIES.iter().map(Property::label).collect();
        for expected in
            ["baseColorFactor", "normalTexture", "occlusionTexture.strength", "clearcoatNormalTexture.scale"]
        {
            assert!(labels.iter().any(|label| label == expected), "{expected}");
        }
    }
}
