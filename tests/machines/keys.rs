//! The keys of material files with values that they take, from the library's own list of them.

use super::dice::Dice;
use super::recipe::{KeyValue, TextureUse};
use overcoat::load::{MaterialKey, material_keys};
use std::sync::LazyLock;

/// Type of a key's value.
#[derive(Clone, Debug)]
pub enum Takes {
    Switch,
    Number { low: f32, high: f32 },
    Triple { low: f32, high: f32 },
    BaseColor,
    Film,
    Name(Vec<String>),
    Texture { channel: bool },
}

/// All keys but those that are about the file.
pub static KEYS: LazyLock<Vec<(&'static str, Takes)>> = LazyLock::new(|| {
    let about_the_file = |key: &MaterialKey| matches!(key.name, "description" | "over");
    material_keys().filter(|key| !about_the_file(key)).map(|key| (key.name, takes(&key))).collect()
});

/// Reads what the list says for people.
fn takes(key: &MaterialKey) -> Takes {
    let range = |text: &str| -> Option<(f32, f32)> {
        let text = text.split(',').next()?;
        let (low, high) = text.split_once(" to ")?;
        Some((low.trim().parse().ok()?, high.trim().parse().ok()?))
    };
    let text = key.takes.as_str();
    if text == "true or false" {
        Takes::Switch
    } else if text == "texture" {
        Takes::Texture { channel: key.about.contains("(channel ") }
    } else if text.starts_with("nanometres") {
        Takes::Film
    } else if text.starts_with("[r, g, b] or [r, g, b, a]") {
        Takes::BaseColor
    } else if let Some((low, high)) = text.strip_prefix("[r, g, b], ").and_then(range) {
        Takes::Triple { low, high }
    } else if let Some((low, high)) = range(text) {
        Takes::Number { low, high }
    } else {
        Takes::Name(text.split(", ").map(str::to_owned).collect())
    }
}

/// Which numbers of a range to choose.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Choice {
    /// Everyday numbers.
    Usual,
    /// Everyday numbers, the ends of the range and, where it is wide, large ones.
    Any,
}

fn number(dice: &mut Dice, low: f32, high: f32, choice: Choice) -> f32 {
    let least = |wanted: f32| if wanted < high { wanted } else { high };
    let kind = if choice == Choice::Any { dice.below(12) } else { 12 };
    match kind {
        0 => low,
        1 => high,
        2 => dice.between(low, high),
        3 | 4 => dice.between(low, least(low + 50.0)),
        _ if low < -1.0 => dice.between(-1.5, 1.5),
        _ => dice.between(low, least(low + 1.5)),
    }
}

/// A value that a key takes; none for textures where there is none.
pub fn value(
    dice: &mut Dice,
    takes: &Takes,
    texture: Option<TextureUse>,
    choice: Choice,
) -> Option<KeyValue> {
    let list = |values: &[f32]| {
        let numbers: Vec<String> = values.iter().map(|v| format!("{v:?}")).collect();
        format!("[{}]", numbers.join(", "))
    };
    Some(KeyValue::Text(match takes {
        Takes::Switch => dice.percent(50).to_string(),
        Takes::Number { low, high } => format!("{:?}", number(dice, *low, *high, choice)),
        Takes::Triple { low, high } => {
            let values: [f32; 3] = std::array::from_fn(|_| number(dice, *low, *high, choice));
            list(&values)
        }
        Takes::BaseColor => match dice.below(3) {
            0 => format!("\"#{:06x}\"", dice.below(1 << 24)),
            1 => list(&dice.triple(0.0, 1.0)),
            _ => {
                let [r, g, b] = dice.triple(0.0, 1.0);
                list(&[r, g, b, dice.between(0.0, 1.0)])
            }
        },
        Takes::Film => {
            let least = dice.between(0.0, 800.0);
            list(&[least, least + dice.between(-100.0, 800.0).max(-least)])
        }
        Takes::Name(names) => format!("\"{}\"", dice.pick(names)),
        Takes::Texture { channel } => {
            let mut used = texture?;
            used.channel = (*channel && dice.percent(60)).then(|| dice.below(4) as u8);
            return Some(KeyValue::Texture(used));
        }
    }))
}

/// Leaves out keys that cannot stand side by side, or not without another.
pub fn settle(keys: &mut Vec<(&'static str, KeyValue)>, specular_workflow: bool) {
    let specular: &[&str] = &["specular_f0", "glossiness", "specular_glossiness_texture"];
    let metallic: &[&str] =
        &["metallic", "metallic_texture", "metallic_roughness_texture", "roughness_texture"];
    let other_workflow = if specular_workflow { metallic } else { specular };
    keys.retain(|(name, _)| !other_workflow.contains(name));
    let without = |keys: &mut Vec<(&'static str, KeyValue)>, unless: bool, names: &[&str]| {
        if !unless {
            keys.retain(|(name, _)| !names.contains(name));
        }
    };
    let has = |keys: &[(&'static str, KeyValue)], wanted: &str| keys.iter().any(|(name, _)| *name == wanted);
    let both = has(keys, "metallic_roughness_texture");
    without(keys, !both, &["metallic_texture", "roughness_texture"]);
    let glossiness = has(keys, "glossiness");
    without(keys, !glossiness, &["roughness"]);
    for (scale, texture) in [("normal_scale", "normal_texture"), ("coat_normal_scale", "coat_normal_texture")]
    {
        let there = has(keys, texture);
        without(keys, there, &[scale]);
    }
    let mode = keys.iter().find(|(name, _)| *name == "alpha_mode").map(|(_, value)| value.clone());
    let mask = mode.is_none_or(|mode| mode == KeyValue::Text("\"mask\"".to_owned()));
    without(keys, mask, &["alpha_cutoff"]);
    // These two are read together and have to lie alike.
    let find = |keys: &[(&'static str, KeyValue)], wanted: &str| {
        keys.iter().find_map(|(name, value)| match value {
            KeyValue::Texture(used) if *name == wanted => Some(used.clone()),
            _ => None,
        })
    };
    if let (Some(metallic), Some(roughness)) =
        (find(keys, "metallic_texture"), find(keys, "roughness_texture"))
    {
        let alike = TextureUse { texture: roughness.texture, channel: roughness.channel, ..metallic };
        for (name, value) in keys {
            if *name == "roughness_texture" {
                *value = KeyValue::Texture(alike.clone());
            }
        }
    }
}
