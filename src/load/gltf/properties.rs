//! What glTF calls the parameters of materials: where each number and texture stands in the JSON. Reading a material and
//! animating it (KHR_animation_pointer) go by this one table.

use super::model::{
    Clearcoat, DiffuseTransmission, Iridescence, Material, MaterialExtensions, MetallicRoughness, Sheen,
    Specular, SpecularGlossiness, TextureInfo,
};
use crate::scene;
use crate::scene::parameters::{self as p, Parameter, Range};

/// A property of materials.
#[derive(Debug)]
pub(super) enum Property {
    /// One to four numbers.
    Number(Number),
    /// A texture.
    Texture(Texture),
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
    Property::Number(Number { path, goal: Goal::Whole(parameter), range, width, read })
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

fn clearcoat(m: &Material) -> Option<&Clearcoat> {
    extensions(m)?.clearcoat.as_ref()
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
        read: |m| three(m.emissive_factor.as_deref().copied()),
    }),
    texture("emissiveTexture", &p::EMISSIVE_TEXTURE, |m| m.emissive_texture.as_deref()),
    Property::Number(Number {
        path: "extensions/KHR_materials_emissive_strength/emissiveStrength",
        goal: Goal::EmissionStrength,
        range: Range::FACTOR,
        width: 1,
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
    /// extension is drawn, and the other is the substitute, of which nothing is read.
    pub(super) fn applies(&self, given: &Material) -> bool {
        let of = |object: &str| self.path().starts_with(object);
        if of("pbrMetallicRoughness/") {
            glossy(given).is_none()
        } else if of("extensions/KHR_materials_pbrSpecularGlossiness/") {
            glossy(given).is_some()
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
        self.range.clamp(value)
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
    use crate::scene::parameters::Kind;
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
