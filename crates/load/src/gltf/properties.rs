//! Names of material parameters in glTF. Reading a material and animating it (KHR_animation_pointer) go by this one
//! list, which is that of all members of `surface_objects.rs`.

use super::model::{Material, TextureInfo};
use super::surface_objects::{OBJECTS, coat, glossy};
use overcoat_scene as scene;
use overcoat_scene::parameters::{Parameter, Range};
use std::sync::LazyLock;

/// A property of materials.
#[derive(Clone, Copy, Debug)]
pub(super) enum Property {
    /// One to four numbers.
    Number(Number),
    /// A texture.
    Texture(Texture),
    /// A member that is not read.
    Unread(Unread),
}

/// Numbers in a material of the file.
#[derive(Clone, Copy, Debug)]
pub(super) struct Number {
    /// JSON pointer from the material.
    pub(super) path: &'static str,
    pub(super) goal: Goal,
    /// Range that the specification allows.
    pub(super) range: Range,
    pub(super) width: usize,
    /// True of indices of refraction where 0 stands for a reflectance of 1, as if they were infinite.
    pub(super) zero_is_infinite: bool,
    pub(super) read: fn(&Material) -> Option<[f32; 4]>,
}

/// Destination of a number.
#[derive(Clone, Copy, Debug)]
pub(super) enum Goal {
    /// The parameter.
    Whole(&'static Parameter),
    /// One of the parameter's numbers.
    Part(&'static Parameter, usize),
    /// Emitted radiance, before its strength.
    Emission,
    /// Factor of the emitted radiance.
    EmissionStrength,
}

/// A member that has no parameter.
#[derive(Clone, Copy, Debug)]
pub(super) struct Unread {
    pub(super) path: &'static str,
    /// Description of what is drawn instead, for the warning.
    pub(super) instead: &'static str,
    /// True if the file has it, and it would show.
    pub(super) matters: fn(&Material) -> bool,
}

/// A texture in a material of the file.
#[derive(Clone, Copy, Debug)]
pub(super) struct Texture {
    /// JSON pointer from the material.
    pub(super) path: &'static str,
    pub(super) parameter: &'static Parameter,
    /// The channel that is read, where a material says which.
    pub(super) channel: u8,
    pub(super) read: fn(&Material) -> Option<&TextureInfo>,
}

/// All that is read of materials, in the order in which it is.
pub(super) static PROPERTIES: LazyLock<Vec<Property>> =
    LazyLock::new(|| OBJECTS.iter().copied().flatten().copied().flatten().copied().collect());

impl Property {
    pub(super) fn path(&self) -> &'static str {
        match self {
            Self::Number(number) => number.path,
            Self::Texture(texture) => texture.path,
            Self::Unread(unread) => unread.path,
        }
    }

    /// Name in messages: the last one of its path, with the texture that it belongs to.
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
        for property in PROPERTIES.iter() {
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
