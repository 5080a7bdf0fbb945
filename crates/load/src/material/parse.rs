//! The text of a material file as a list of settings.

use super::error::{MaterialError, MaterialErrorReason};
use super::keys::{KEYS, Key, Kind};
use super::texture::TextureUse;
use crate::gltf::transform_of;
use overcoat_core::color::{hex_color, srgb::srgb_to_linear};
use overcoat_core::suggest::{nearest_name, same_name};
use overcoat_scene::parameters::{Holds, Kind as Of, Range};
use overcoat_scene::{Filter, Sampler, UvTransform, Wrap};
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// A key and its value.
#[derive(Debug)]
pub(super) struct Setting {
    pub(super) key: &'static Key,
    pub(super) line: usize,
    /// Spelling of the key in the file, if it differs from the name.
    pub(super) spelt: Option<String>,
    pub(super) value: Value,
}

/// Value of a key.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Value {
    Text(String),
    Number(f32),
    Triple([f32; 3]),
    /// Alpha only if it is given.
    ColorAndAlpha([f32; 3], Option<f32>),
    Pair([f32; 2]),
    Switch(bool),
    /// `None` takes the texture away.
    Texture(Option<Box<TextureUse>>),
}

/// Keys of a texture's table.
const TEXTURE_KEYS: [&str; 8] =
    ["file", "channel", "uv_set", "scale", "offset", "rotation", "wrap", "filter"];

/// Keys that cannot stand side by side.
const CONFLICTS: [(&[&str], &[&str], &str); 3] = [
    (
        &["specular_f0", "glossiness", "specular_glossiness_texture"],
        &["metallic", "metallic_texture", "metallic_roughness_texture", "roughness_texture"],
        "a base is given by metallic and roughness or by F0 and glossiness",
    ),
    (&["glossiness"], &["roughness"], "one is 1 less the other"),
    (&["metallic_roughness_texture"], &["metallic_texture", "roughness_texture"], "it holds both"),
];

/// Parses a file. Settings come in the order of the table of keys.
///
/// # Errors
/// [`MaterialError`] of the first line that is wrong.
pub(super) fn parse(text: &str) -> Result<Vec<Setting>, MaterialError> {
    let place = Place { text };
    let table = DeTable::parse(text).map_err(|e| MaterialError {
        line: e.span().map(|span| place.line(&span)),
        key: None,
        reason: MaterialErrorReason::Syntax(e.message().lines().collect::<Vec<_>>().join(" ")),
    })?;
    let mut settings = Vec::new();
    for (name, value) in in_order(table.get_ref()) {
        let line = place.line(&name.span());
        if name.get_ref() == "options" {
            let Some(options) = value.get_ref().as_table() else {
                return Err(wrong_type(line, "options", "a table", value.get_ref()));
            };
            for (name, value) in in_order(options) {
                let line = place.line(&name.span());
                settings.push(place.setting(&format!("options.{}", name.get_ref()), line, value)?);
            }
        } else {
            settings.push(place.setting(name.get_ref(), line, value)?);
        }
    }
    settings.sort_by_key(|s| KEYS.iter().position(|key| key.name == s.key.name));
    check(&settings)?;
    Ok(settings)
}

/// Combinations that make no sense.
fn check(settings: &[Setting]) -> Result<(), MaterialError> {
    let find = |name: &str| settings.iter().find(|s| s.key.name == name);
    let error = |setting: &Setting, reason| MaterialError {
        line: Some(setting.line),
        key: Some(setting.key.name.to_owned()),
        reason,
    };
    for (k, setting) in settings.iter().enumerate() {
        // In two spellings; TOML itself refuses what is given twice in one.
        if settings.iter().take(k).any(|earlier| earlier.key.name == setting.key.name) {
            let why = "the same key in another spelling";
            return Err(error(setting, MaterialErrorReason::Conflict { other: setting.key.name, why }));
        }
    }
    for (these, those, why) in CONFLICTS {
        let (Some(this), Some(that)) =
            (these.iter().find_map(|n| find(n)), those.iter().find_map(|n| find(n)))
        else {
            continue;
        };
        return Err(error(that, MaterialErrorReason::Conflict { other: this.key.name, why }));
    }
    if let (Some(mode), Some(cutoff)) = (find("alpha_mode"), find("alpha_cutoff"))
        && mode.value != Value::Text("mask".to_owned())
    {
        let why = "a cutoff is for alpha_mode \"mask\"";
        return Err(error(cutoff, MaterialErrorReason::Conflict { other: "alpha_mode", why }));
    }
    let over = find("over").is_some_and(|s| s.value == Value::Switch(true));
    for (scale, texture) in [("normal_scale", "normal_texture"), ("coat_normal_scale", "coat_normal_texture")]
    {
        if let (Some(scale), None, false) = (find(scale), find(texture), over) {
            return Err(error(scale, MaterialErrorReason::Needs { other: texture }));
        }
    }
    let textures = |name: &str| match find(name).map(|s| (s, &s.value)) {
        Some((setting, Value::Texture(Some(texture)))) => Some((setting, texture)),
        _ => None,
    };
    if let (Some((_, metallic)), Some((setting, roughness))) =
        (textures("metallic_texture"), textures("roughness_texture"))
        && !metallic.lies_like(roughness)
    {
        let why =
            "both are read together, so their uv_set, scale, offset, rotation, wrap and filter must be equal";
        return Err(error(setting, MaterialErrorReason::Conflict { other: "metallic_texture", why }));
    }
    Ok(())
}

/// Entries of a table as they stand in the file.
fn in_order<'a, 'i>(
    table: &'a DeTable<'i>,
) -> Vec<(&'a Spanned<toml::de::DeString<'i>>, &'a Spanned<DeValue<'i>>)> {
    let mut entries: Vec<_> = table.iter().collect();
    entries.sort_by_key(|(name, _)| name.span().start);
    entries
}

/// Finds lines in the text.
struct Place<'a> {
    text: &'a str,
}

impl Place<'_> {
    fn line(&self, span: &std::ops::Range<usize>) -> usize {
        let before = self.text.as_bytes().get(..span.start).unwrap_or(self.text.as_bytes());
        before.iter().filter(|&&b| b == b'\n').count().saturating_add(1)
    }

    /// One key and its value.
    fn setting(
        &self,
        name: &str,
        line: usize,
        value: &Spanned<DeValue<'_>>,
    ) -> Result<Setting, MaterialError> {
        let valid = || KEYS.iter().map(|key| key.name);
        let other_spelling = || same_name(name, valid()).and_then(Key::named);
        let Some(key) = Key::named(name).or_else(other_spelling) else {
            let nearest = nearest_name(name, valid());
            return Err(unknown_key(line, name, nearest, valid().collect()));
        };
        let value = self.value(key, line, value.get_ref())?;
        Ok(Setting { key, line, spelt: (key.name != name).then(|| short(name)), value })
    }

    fn value(&self, key: &'static Key, line: usize, value: &DeValue<'_>) -> Result<Value, MaterialError> {
        let name = key.name;
        match &key.kind {
            Kind::Description => match value {
                DeValue::String(text) => Ok(Value::Text(text.clone().into_owned())),
                other => Err(wrong_type(line, name, "text", other)),
            },
            Kind::Over | Kind::Value(Of::Switch(_)) => match value {
                DeValue::Boolean(value) => Ok(Value::Switch(*value)),
                other => Err(wrong_type(line, name, "true or false", other)),
            },
            Kind::Value(Of::Number(range, _)) => {
                let zero = range.or == Some(0.0) && is_zero(value);
                let range = if zero { Range { low: 0.0, ..*range } } else { *range };
                number(line, name, value, range.low, range.high, "a number").map(Value::Number)
            }
            Kind::Value(Of::Triple(range, _)) => {
                triple(line, name, value, range.low, range.high, "three numbers [r, g, b]").map(Value::Triple)
            }
            Kind::Value(Of::Color(range, _)) => match value {
                DeValue::String(text) => match hex(text) {
                    Some((color, None)) => Ok(Value::Triple(color)),
                    _ => Err(wrong_type(line, name, "[r, g, b] or \"#rrggbb\"", value)),
                },
                other => triple(line, name, other, range.low, range.high, "[r, g, b] or \"#rrggbb\"")
                    .map(Value::Triple),
            },
            Kind::Value(Of::ColorAndAlpha(range, _)) => color_and_alpha(line, name, value, *range),
            Kind::Value(Of::Pair(range, _)) => film(line, name, value, *range),
            Kind::Value(Of::Name { names, .. }) => {
                self.name(line, name, value, &names()).map(|n| Value::Text(n.to_owned()))
            }
            // One channel of the picture is read, which the file may choose.
            Kind::Part(..) => self.texture(line, name, value, true),
            Kind::Value(Of::Texture(slot)) => {
                self.texture(line, name, value, matches!(slot.holds, Holds::Channel(_)))
            }
        }
    }

    /// One of a few names.
    fn name(
        &self,
        line: usize,
        key: &str,
        value: &DeValue<'_>,
        names: &[&'static str],
    ) -> Result<&'static str, MaterialError> {
        let DeValue::String(text) = value else {
            return Err(wrong_type(line, key, "a name in quotation marks", value));
        };
        names.iter().copied().find(|name| *name == text.as_ref()).ok_or_else(|| MaterialError {
            line: Some(line),
            key: Some(key.to_owned()),
            reason: MaterialErrorReason::UnknownName {
                value: short(text),
                nearest: nearest_name(text, names.iter().copied()),
                valid: names.to_vec(),
            },
        })
    }

    /// A path, a table or `false`.
    fn texture(
        &self,
        line: usize,
        name: &'static str,
        value: &DeValue<'_>,
        takes_channel: bool,
    ) -> Result<Value, MaterialError> {
        let mut texture = TextureUse {
            file: String::new(),
            channel: None,
            uv_set: 0,
            transform: UvTransform::IDENTITY,
            sampler: Sampler::default(),
        };
        let table = match value {
            DeValue::Boolean(false) => return Ok(Value::Texture(None)),
            DeValue::String(file) => {
                texture.file = file.clone().into_owned();
                return Ok(Value::Texture(Some(Box::new(texture))));
            }
            DeValue::Table(table) => table,
            other => {
                return Err(wrong_type(line, name, "a path, { file = \"...\" } or false", other));
            }
        };
        let (mut scale, mut offset, mut rotation) = ([1.0_f32; 2], [0.0_f32; 2], 0.0_f32);
        for (part, value) in in_order(table) {
            let line = self.line(&part.span());
            let value = value.get_ref();
            let key = format!("{name}.{}", part.get_ref());
            match part.get_ref().as_ref() {
                "file" => match value {
                    DeValue::String(file) => texture.file = file.clone().into_owned(),
                    other => return Err(wrong_type(line, &key, "a path", other)),
                },
                "channel" => {
                    if !takes_channel {
                        let valid = TEXTURE_KEYS.iter().copied().filter(|k| *k != "channel").collect();
                        return Err(unknown_key(line, &key, None, valid));
                    }
                    let names = ["r", "g", "b", "a"];
                    let channel = self.name(line, &key, value, &names)?;
                    texture.channel = names.iter().position(|n| *n == channel).map(|k| k as u8);
                }
                "uv_set" => {
                    let set = number(line, &key, value, 0.0, 1.0, "0 or 1")?;
                    if set != 0.0 && set != 1.0 {
                        return Err(wrong_type(line, &key, "0 or 1", value));
                    }
                    texture.uv_set = u8::from(set == 1.0);
                }
                "scale" => scale = pair(line, &key, value, -1e4, 1e4)?,
                "offset" => offset = pair(line, &key, value, -1e4, 1e4)?,
                "rotation" => rotation = number(line, &key, value, -3600.0, 3600.0, "degrees")?,
                "wrap" => {
                    let names = ["repeat", "mirror", "clamp"];
                    let wrap = |value: &DeValue<'_>| {
                        Ok(match self.name(line, &key, value, &names)? {
                            "mirror" => Wrap::MirroredRepeat,
                            "clamp" => Wrap::ClampToEdge,
                            _ => Wrap::Repeat,
                        })
                    };
                    let [u, v] = match value.as_array().map(|list| &list[..]) {
                        Some([u, v]) => [u.get_ref(), v.get_ref()],
                        _ => [value, value],
                    };
                    (texture.sampler.wrap_u, texture.sampler.wrap_v) = (wrap(u)?, wrap(v)?);
                }
                "filter" => {
                    let linear = self.name(line, &key, value, &["linear", "nearest"])? == "linear";
                    let filter = if linear { Filter::Linear } else { Filter::Nearest };
                    (texture.sampler.magnification, texture.sampler.minification) = (filter, filter);
                }
                other => {
                    let nearest = nearest_name(other, TEXTURE_KEYS);
                    return Err(unknown_key(line, &key, nearest, TEXTURE_KEYS.to_vec()));
                }
            }
        }
        if texture.file.is_empty() {
            let key = Some(name.to_owned());
            return Err(MaterialError {
                line: Some(line),
                key,
                reason: MaterialErrorReason::Needs { other: "file" },
            });
        }
        // As the file says it, in degrees.
        let radians = f64::from(rotation) * (std::f64::consts::PI / 180.0);
        // The numbers above are far from the largest that a scene takes.
        texture.transform = transform_of(offset.map(f64::from), radians, scale.map(f64::from))
            .unwrap_or(UvTransform::IDENTITY);
        Ok(Value::Texture(Some(Box::new(texture))))
    }
}

fn unknown_key(
    line: usize,
    key: &str,
    nearest: Option<&'static str>,
    valid: Vec<&'static str>,
) -> MaterialError {
    let reason = MaterialErrorReason::UnknownKey { nearest, valid };
    MaterialError { line: Some(line), key: Some(short(key)), reason }
}

fn wrong_type(line: usize, key: &str, expected: &'static str, found: &DeValue<'_>) -> MaterialError {
    let found = match found {
        DeValue::String(text) => format!("\"{}\"", short(text)),
        DeValue::Integer(number) => short(&number.to_string()),
        DeValue::Float(number) => short(number.as_str()),
        DeValue::Boolean(value) => value.to_string(),
        DeValue::Array(list) => format!("a list of {}", list.len()),
        other => other.type_str().to_owned(),
    };
    let reason = MaterialErrorReason::WrongType { expected, found };
    MaterialError { line: Some(line), key: Some(short(key)), reason }
}

/// Quotation of a file for messages: the first 80 characters, without control characters.
fn short(text: &str) -> String {
    let mut out: String = text.chars().take(80).map(|c| if c.is_control() { ' ' } else { c }).collect();
    if text.chars().nth(80).is_some() {
        out.push_str("...");
    }
    out
}

/// A number as written and as it is.
fn literal<'a>(value: &'a DeValue<'_>) -> Option<(&'a str, f32)> {
    match value {
        DeValue::Integer(number) => {
            // A number of another base than ten is none of a material's.
            let parsed = if number.radix() == 10 { number.as_str().parse().ok()? } else { return None };
            Some((number.as_str(), parsed))
        }
        DeValue::Float(number) => Some((number.as_str(), number.as_str().parse().ok()?)),
        _ => None,
    }
}

fn is_zero(value: &DeValue<'_>) -> bool {
    literal(value).is_some_and(|(_, v)| v == 0.0)
}

/// A number within a range, ends included.
fn number(
    line: usize,
    key: &str,
    value: &DeValue<'_>,
    low: f32,
    high: f32,
    expected: &'static str,
) -> Result<f32, MaterialError> {
    let (text, number) = literal(value).ok_or_else(|| wrong_type(line, key, expected, value))?;
    // Neither NaN nor the infinities lie in any range.
    if number >= low && number <= high {
        // Not a negative zero.
        return Ok(number + 0.0);
    }
    let reason = MaterialErrorReason::OutOfRange { value: short(text), low, high };
    Err(MaterialError { line: Some(line), key: Some(key.to_owned()), reason })
}

/// N numbers within a range.
fn numbers<const N: usize>(
    line: usize,
    key: &str,
    value: &DeValue<'_>,
    low: f32,
    high: f32,
    expected: &'static str,
) -> Result<[f32; N], MaterialError> {
    let list = value.as_array().filter(|list| list.len() == N);
    let list = list.ok_or_else(|| wrong_type(line, key, expected, value))?;
    let mut out = [0.0; N];
    for (slot, value) in out.iter_mut().zip(list.iter()) {
        *slot = number(line, key, value.get_ref(), low, high, expected)?;
    }
    Ok(out)
}

fn triple(
    line: usize,
    key: &str,
    value: &DeValue<'_>,
    low: f32,
    high: f32,
    expected: &'static str,
) -> Result<[f32; 3], MaterialError> {
    numbers(line, key, value, low, high, expected)
}

/// Two numbers, or one for both.
fn pair(line: usize, key: &str, value: &DeValue<'_>, low: f32, high: f32) -> Result<[f32; 2], MaterialError> {
    let expected = "a number or two";
    match value {
        DeValue::Array(_) => numbers(line, key, value, low, high, expected),
        one => number(line, key, one, low, high, expected).map(|v| [v, v]),
    }
}

fn color_and_alpha(
    line: usize,
    key: &str,
    value: &DeValue<'_>,
    Range { low, high, .. }: Range,
) -> Result<Value, MaterialError> {
    let expected = "[r, g, b], [r, g, b, a], \"#rrggbb\" or \"#rrggbbaa\"";
    match value {
        DeValue::String(text) => {
            let (color, alpha) = hex(text).ok_or_else(|| wrong_type(line, key, expected, value))?;
            Ok(Value::ColorAndAlpha(color, alpha))
        }
        DeValue::Array(list) if list.len() == 4 => {
            let [r, g, b, a] = numbers(line, key, value, low, high, expected)?;
            Ok(Value::ColorAndAlpha([r, g, b], Some(a)))
        }
        other => triple(line, key, other, low, high, expected).map(|color| Value::ColorAndAlpha(color, None)),
    }
}

/// One number stands for the largest thickness; the least is then 0.
fn film(
    line: usize,
    key: &str,
    value: &DeValue<'_>,
    Range { low, high, .. }: Range,
) -> Result<Value, MaterialError> {
    let expected = "nanometres or [min, max]";
    match value {
        DeValue::Array(_) => numbers(line, key, value, low, high, expected).map(Value::Pair),
        one => number(line, key, one, low, high, expected).map(|most| Value::Pair([0.0, most])),
    }
}

/// `#rrggbb` or `#rrggbbaa`, without `#` as well: an sRGB colour in linear light, and alpha if it is there.
fn hex(text: &str) -> Option<([f32; 3], Option<f32>)> {
    let (color, alpha) = hex_color(text)?;
    Some((color.map(|v| srgb_to_linear(f32::from(v) / 255.0)), alpha.map(|a| f32::from(a) / 255.0)))
}
