//! The keys of material files: those of the scene's parameters, and what files have beside them.

use overcoat_scene::parameters::{self, Access, MAX_FACTOR, PARAMETERS, Parameter, Range, ReadBy};
use overcoat_scene::{Material, ShadingModel};
use std::sync::LazyLock;

/// A key of material files.
#[derive(Clone, Debug)]
pub(super) struct Key {
    /// As written; keys of the table `[options]` with that in front: `options.three.r119`.
    pub(super) name: &'static str,
    /// Type of the value and its destination.
    pub(super) kind: Kind,
    /// One line of documentation.
    pub(super) about: &'static str,
    /// In which unit, if in any.
    unit: &'static str,
    read_by: Vec<ShadingModel>,
}

/// Type of a key's value.
#[derive(Clone, Copy, Debug)]
pub(super) enum Kind {
    /// A line of text about the file.
    Description,
    /// True if the file is laid over the model's own material.
    Over,
    /// A value of the material. A texture that stands alone, where the number that it multiplies is 0, makes that 1.
    Value(parameters::Kind),
    /// A texture of one channel of the texture that holds metallic and roughness: the channel, and the number that it
    /// multiplies.
    Part(u8, &'static Parameter),
}

/// Keys in front of the parameters.
const FIRST: [Key; 2] = [
    key("description", Kind::Description, "One line about the material."),
    key("over", Kind::Over, "Lay the keys given over the model's own material, instead of replacing it."),
];

/// Keys between the parameters, each behind the one of the name beside it.
const BETWEEN: [(&str, Key); 3] = [
    (
        "metallic_roughness_texture",
        key("metallic_texture", Kind::Part(2, &parameters::METALLIC), "Multiplies metallic (channel b)."),
    ),
    (
        "metallic_roughness_texture",
        key("roughness_texture", Kind::Part(1, &parameters::ROUGHNESS), "Multiplies roughness (channel g)."),
    ),
    (
        "emissive",
        key(
            "emissive_strength",
            Kind::Value(parameters::Kind::Number(
                EMISSION,
                Access {
                    get: |_| 1.0,
                    set: |m, strength| {
                        // An imported material may have as much as a scene takes already.
                        let product =
                            |e: f32| if e * strength < MAX_FACTOR { e * strength } else { MAX_FACTOR };
                        m.emissive = m.emissive.map(product);
                    },
                },
            )),
            "Multiplies emissive.",
        ),
    ),
];

/// Colour and strength each, so that their product is one that a scene takes.
const EMISSION: Range = Range::new(0.0, 1e3);

const fn key(name: &'static str, kind: Kind, about: &'static str) -> Key {
    Key { name, kind, about, unit: "", read_by: Vec::new() }
}

/// Key of a parameter. Some are written otherwise than scenes hold them, as angles in degrees.
fn written(parameter: &'static Parameter) -> Key {
    use parameters::Kind::{Color, Number};
    let (kind, unit) = match (parameter.name, parameter.kind) {
        ("emissive", Color(_, access)) => (Color(EMISSION, access), parameter.unit),
        ("anisotropy_rotation", _) => {
            let access = Access {
                get: |m: &Material| m.lobes.anisotropy.rotation.to_degrees(),
                set: |m: &mut Material, degrees: f32| m.lobes.anisotropy.rotation = degrees.to_radians(),
            };
            (Number(Range::new(-3600.0, 3600.0), access), "degrees")
        }
        // TOML has an infinity, but who would look for it here.
        ("attenuation_distance", _) => {
            let access = Access {
                get: |m: &Material| {
                    let distance = m.lobes.transmission.attenuation_distance;
                    if distance.is_finite() { distance } else { 0.0 }
                },
                set: |m: &mut Material, value: f32| {
                    m.lobes.transmission.attenuation_distance =
                        if value > 0.0 { value } else { f32::INFINITY };
                },
            };
            (Number(Range { low: 1e-6, high: 1e9, or: Some(0.0) }, access), parameter.unit)
        }
        (_, kind) => (kind, parameter.unit),
    };
    let read_by = if matches!(parameter.read_by, ReadBy::All) { Vec::new() } else { parameter.models() };
    Key { name: parameter.name, kind: Kind::Value(kind), about: parameter.about, unit, read_by }
}

/// All keys. Values are applied in this order: a texture follows what decides how it is read.
pub(super) static KEYS: LazyLock<Vec<Key>> = LazyLock::new(|| {
    let mut keys = FIRST.to_vec();
    for parameter in PARAMETERS {
        keys.push(written(parameter));
        keys.extend(
            BETWEEN.iter().filter(|(behind, _)| *behind == parameter.name).map(|(_, key)| key.clone()),
        );
    }
    keys
});

impl Key {
    /// The key of that name.
    pub(super) fn named(name: &str) -> Option<&'static Self> {
        KEYS.iter().find(|key| key.name == name)
    }

    /// The value of a material as a file would give it; `None` for keys that have none.
    fn text(&self, material: &Material) -> Option<String> {
        use parameters::Kind::{Color, ColorAndAlpha, Name, Number, Pair, Switch, Texture, Triple};
        let list = |values: &[f32]| {
            let numbers: Vec<String> = values.iter().map(|v| format!("{v:?}")).collect();
            format!("[{}]", numbers.join(", "))
        };
        match self.kind {
            Kind::Description => None,
            Kind::Over => Some("false".to_owned()),
            Kind::Value(Texture(slot)) => Some(slot.get(material).is_some().to_string()),
            Kind::Part(..) => Self::named("metallic_roughness_texture")?.text(material),
            Kind::Value(Number(_, access)) => Some(format!("{:?}", (access.get)(material))),
            Kind::Value(Pair(_, access)) => Some(list(&(access.get)(material))),
            Kind::Value(Triple(_, access) | Color(_, access)) => Some(list(&(access.get)(material))),
            Kind::Value(ColorAndAlpha(_, access)) => Some(list(&(access.get)(material))),
            Kind::Value(Switch(access)) => Some((access.get)(material).to_string()),
            Kind::Value(Name { get, .. }) => {
                Some(get(material)).filter(|n| !n.is_empty()).map(|n| format!("\"{n}\""))
            }
        }
    }

    /// Kind of the value.
    fn value_kind(&self) -> MaterialValueKind {
        use parameters::Kind::{Color, ColorAndAlpha, Name, Number, Pair, Switch, Texture, Triple};
        match self.kind {
            Kind::Description => MaterialValueKind::Text,
            Kind::Over | Kind::Value(Switch(_)) => MaterialValueKind::Switch,
            Kind::Value(Number(..)) => MaterialValueKind::Number,
            Kind::Value(Pair(..)) => MaterialValueKind::Pair,
            Kind::Value(Triple(..)) => MaterialValueKind::Triple,
            Kind::Value(Color(..)) => MaterialValueKind::Color,
            Kind::Value(ColorAndAlpha(..)) => MaterialValueKind::ColorAndAlpha,
            Kind::Value(Name { names, .. }) => MaterialValueKind::Name(names()),
            Kind::Part(..) | Kind::Value(Texture(_)) => MaterialValueKind::Texture,
        }
    }

    /// Description of the value: type, range and unit.
    fn takes(&self) -> String {
        use parameters::Kind::{Color, ColorAndAlpha, Name, Number, Pair, Switch, Texture, Triple};
        let unit = if self.unit.is_empty() { String::new() } else { format!(", in {}", self.unit) };
        match self.kind {
            Kind::Description => "text".to_owned(),
            Kind::Over | Kind::Value(Switch(_)) => "true or false".to_owned(),
            Kind::Value(Number(Range { low, high, or }, _)) => {
                let or = or.map_or_else(String::new, |or| format!(", or {or}"));
                format!("{low} to {high}{or}{unit}")
            }
            Kind::Value(Pair(Range { low, high, .. }, _)) => {
                format!("{}, {low} to {high}, or [min, max]", self.unit)
            }
            Kind::Value(Triple(Range { low, high, .. }, _)) => format!("[r, g, b], {low} to {high}{unit}"),
            Kind::Value(Color(Range { low, high, .. }, _)) => {
                format!("[r, g, b], {low} to {high}, or \"#rrggbb\"")
            }
            Kind::Value(ColorAndAlpha(Range { low, high, .. }, _)) => {
                format!("[r, g, b] or [r, g, b, a], {low} to {high}, or \"#rrggbb\" or \"#rrggbbaa\"")
            }
            Kind::Value(Name { names, .. }) => names().join(", "),
            Kind::Part(..) | Kind::Value(Texture(_)) => "texture".to_owned(),
        }
    }
}

/// Kind of a value in material files.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum MaterialValueKind {
    /// A line of text.
    Text,
    /// `true` or `false`.
    Switch,
    /// A number.
    Number,
    /// Two numbers, or one for the second.
    Pair,
    /// Three numbers, of red, green and blue.
    Triple,
    /// Three linear numbers, or `"#rrggbb"` in sRGB.
    Color,
    /// Three or four linear numbers, or `"#rrggbb"` or `"#rrggbbaa"` in sRGB.
    ColorAndAlpha,
    /// One of these names.
    Name(Vec<&'static str>),
    /// A path, a table with `file` among its keys, or `false` for none.
    Texture,
}

/// A key of material files, for people.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MaterialKey {
    /// As written; keys of the table `[options]` with that in front: `options.three.r119`.
    pub name: &'static str,
    /// Kind of the value.
    pub kind: MaterialValueKind,
    /// Description of the value: type, range and unit.
    pub takes: String,
    /// The value where it is absent, in TOML; `None` for keys without one.
    pub default: Option<String>,
    /// One line about it.
    pub about: &'static str,
    /// The models that read it; none if it is for all.
    pub read_by: Vec<ShadingModel>,
}

/// The value of a material by the name of a key, as TOML and JSON have it: a number, a list of them, a name in quotes, `true` or
/// `false`; of textures, `true` if there is one. Units are those of the key, and `emissive_strength` is 1, since `emissive` has it in it.
/// `None` if no key has that name, or the key has no value.
#[must_use]
pub fn material_value(material: &Material, name: &str) -> Option<String> {
    Key::named(name)?.text(material)
}

/// All keys of material files, in the order of the documentation.
pub fn material_keys() -> impl Iterator<Item = MaterialKey> {
    let default = Material::default();
    KEYS.iter().map(move |key| MaterialKey {
        name: key.name,
        kind: key.value_kind(),
        takes: key.takes(),
        default: key.text(&default),
        about: key.about,
        read_by: key.read_by.clone(),
    })
}
