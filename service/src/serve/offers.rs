//! Offers of an operator: `presets.toml`, with names for sets of options, and what requests may ask for beside them.

use super::error::{Kind, Problem};
use super::fair::Priority;
use super::options::size;
use super::path::options_of_preset;
use overcoat_description::DescriptionOption;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::Path;
use toml::{Table, Value};

/// Bytes of the file at most.
const LARGEST: u64 = 1 << 20;
/// Options of requests that are no keys of scene files.
const OWN_OPTIONS: [&str; 9] =
    ["aov", "dpr", "env", "format", "fps", "jpeg_quality", "material", "size", "turntable"];

/// A set of options under a name.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Preset {
    /// Options with their values, as requests have them.
    pub pairs: Vec<(String, String)>,
    /// Priority of requests for it; that of their client if absent.
    pub priority: Option<Priority>,
}

/// Options that requests may use beside presets.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Offers {
    /// Nothing but presets is offered.
    only: bool,
    /// Options with their values; all of them if there is no such table.
    allow: Option<BTreeMap<String, Values>>,
}

/// Values of an option.
#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(untagged, expecting = "expected true, a list of values, or { min = N, max = N }")]
enum Values {
    All(bool),
    List(Vec<Value>),
    Range(Range),
}

#[derive(Clone, Copy, Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
struct Range {
    min: f64,
    max: f64,
}

/// The file.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    #[serde(default)]
    only: bool,
    #[serde(default)]
    preset: BTreeMap<String, Choice>,
    allow: Option<BTreeMap<String, Values>>,
}

/// A preset, as paths have its options or as a table.
#[derive(Debug, Deserialize)]
#[serde(untagged, expecting = "expected a text such as \"size:256/view:front\", or a table of options")]
enum Choice {
    Text(String),
    Table(Table),
}

/// Reads a file of presets and offers.
///
/// # Errors
/// One line that names the file, and the key that is wrong.
pub fn read(path: &Path) -> Result<(BTreeMap<String, Preset>, Offers), String> {
    let text = read_text(path, LARGEST)?;
    parse(&text).map_err(|reason| format!("{}: {reason}", path.display()))
}

/// Text of a file that the operator writes.
///
/// # Errors
/// One line that names the file.
pub fn read_text(path: &Path, largest: u64) -> Result<String, String> {
    let bytes = read_bytes(path, largest)?;
    String::from_utf8(bytes).map_err(|_| format!("{}: the text is not UTF-8", path.display()))
}

/// Content of a file that the operator names.
///
/// # Errors
/// One line that names the file.
pub fn read_bytes(path: &Path, largest: u64) -> Result<Vec<u8>, String> {
    let about = |reason: String| format!("{}: {reason}", path.display());
    let size = std::fs::metadata(path).map_err(|e| about(e.to_string()))?.len();
    if size > largest {
        return Err(about(format!("{size} bytes exceed {largest}")));
    }
    std::fs::read(path).map_err(|e| about(e.to_string()))
}

/// Message of an error in a file, with its line.
#[must_use]
pub fn told(error: &toml::de::Error, text: &str) -> String {
    let before = error.span().and_then(|span| text.get(..span.start));
    let line = before.map_or(1, |before| before.matches('\n').count() + 1);
    format!("line {line}: {}", error.message().lines().collect::<Vec<_>>().join(" "))
}

fn parse(text: &str) -> Result<(BTreeMap<String, Preset>, Offers), String> {
    let File { only, preset, allow } = toml::from_str(text).map_err(|e| told(&e, text))?;
    let mut presets = BTreeMap::new();
    for (name, choice) in preset {
        let preset = choice.preset().map_err(|reason| format!("preset.{name}: {reason}"))?;
        check_name(&name).map_err(|reason| format!("preset.{name}: {reason}"))?;
        presets.insert(name, preset);
    }
    if only && presets.is_empty() {
        return Err("only: there are no presets".to_owned());
    }
    if only && allow.is_some() {
        return Err("only: nothing but presets is offered, and there is a table allow".to_owned());
    }
    for (key, values) in allow.iter().flatten() {
        check_values(key, values).map_err(|reason| format!("allow.{key}: {reason}"))?;
    }
    Ok((presets, Offers { only, allow }))
}

/// Checks the name of a preset, which stands in paths.
///
/// # Errors
/// One line.
pub fn check_name(name: &str) -> Result<(), String> {
    let plain = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
    // A path has the word between options and source.
    let fits = !name.is_empty() && name.len() <= 64 && name.chars().all(plain) && name != "plain";
    fits.then_some(()).ok_or_else(|| "expected a name of 1 to 64 letters, digits, _ and -".to_owned())
}

impl Choice {
    fn preset(self) -> Result<Preset, String> {
        let mut table = match self {
            Self::Text(text) => return Ok(Preset { pairs: options_of_preset(&text)?, priority: None }),
            Self::Table(table) => table,
        };
        let priority = match table.remove("priority") {
            None => None,
            Some(value) => {
                Some(Priority::deserialize(value).map_err(|e| format!("priority: {}", e.message()))?)
            }
        };
        let pairs = table.iter().map(|(key, value)| Ok((key.clone(), text_of(key, value)?)));
        Ok(Preset { pairs: pairs.collect::<Result<_, String>>()?, priority })
    }
}

/// A value as a query has it.
fn text_of(key: &str, value: &Value) -> Result<String, String> {
    Ok(match value {
        Value::String(text) => text.clone(),
        Value::Integer(number) => number.to_string(),
        Value::Float(number) => number.to_string(),
        Value::Boolean(is) => is.to_string(),
        Value::Array(all) if !all.iter().any(|value| matches!(value, Value::Array(_) | Value::Table(_))) => {
            let texts = all.iter().map(|value| text_of(key, value)).collect::<Result<Vec<_>, _>>()?;
            texts.join(if key == "size" { "x" } else { "," })
        }
        Value::Array(_) | Value::Table(_) => {
            serde_json::to_string(value).map_err(|e| format!("{key}: {e}"))?
        }
        Value::Datetime(_) => return Err(format!("{key}: cannot be {}", value.type_str())),
    })
}

fn check_values(key: &str, values: &Values) -> Result<(), String> {
    if matches!(key, "width" | "height") {
        return Err("size has the values of both sides".to_owned());
    }
    let is_option = OWN_OPTIONS.contains(&key)
        || DescriptionOption::all().any(|option| option.request_name() == Some(key));
    if !is_option {
        return Err("there is no such option of requests".to_owned());
    }
    match values {
        Values::All(true) => Ok(()),
        Values::All(false) => Err("what is not in the table is not offered: leave it out".to_owned()),
        Values::List(all) if all.is_empty() => Err("the list is empty".to_owned()),
        Values::List(all) => all.iter().try_for_each(|value| text_of(key, value).map(drop)),
        Values::Range(Range { min, max }) if max < min || !(max - min).is_finite() => {
            Err(format!("the range from {min} to {max} is empty"))
        }
        Values::Range(_) => Ok(()),
    }
}

impl Values {
    fn have(&self, key: &str, text: &str) -> bool {
        let number = |text: &str| text.trim().parse::<f64>().ok();
        match self {
            Self::All(all) => *all,
            Self::List(all) => all.iter().filter_map(|value| text_of(key, value).ok()).any(|own| {
                let equal_numbers = number(&own).zip(number(text)).is_some_and(|(own, given)| own == given);
                let sides = |text: &str| size(text).ok().filter(|_| key == "size");
                own == text || equal_numbers || sides(&own).is_some_and(|own| sides(text) == Some(own))
            }),
            Self::Range(Range { min, max }) => {
                let within = |number: f64| (*min..=*max).contains(&number);
                match size(text) {
                    Ok(sides) if key == "size" => sides.iter().all(|side| within(*side as f64)),
                    _ => number(text).is_some_and(within),
                }
            }
        }
    }

    fn told(&self, key: &str) -> String {
        match self {
            Self::All(_) => "any".to_owned(),
            Self::List(all) => {
                all.iter().filter_map(|value| text_of(key, value).ok()).collect::<Vec<_>>().join(", ")
            }
            Self::Range(Range { min, max }) => format!("{min} to {max}"),
        }
    }
}

impl Offers {
    /// True if nothing but presets is offered.
    #[must_use]
    pub fn presets_only(&self) -> bool {
        self.only
    }

    /// Checks an option of a request with its value.
    ///
    /// # Errors
    /// [`Kind::NotOffered`] that tells the values that are.
    pub fn check(&self, key: &str, text: &str) -> Result<(), Problem> {
        let refused = |message: String| Err(Problem::new(Kind::NotOffered, message));
        // Formats of pictures are those that Accept may choose, unless the operator says otherwise.
        let free = key == "format" && self.allow.as_ref().is_none_or(|allow| !allow.contains_key(key));
        match &self.allow {
            _ if free => Ok(()),
            None if self.only => refused(format!("{key}: presets alone are offered here")),
            None => Ok(()),
            Some(allow) => match allow.get(key) {
                Some(values) if values.have(key, text) => Ok(()),
                Some(values) => refused(format!("{key}: '{text}' is not offered, but {}", values.told(key))),
                None => refused(format!("{key}: this option is not offered here")),
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn presets_are_texts_or_tables() {
        let (presets, offers) = parse(
            "[preset]\nthumb = 'size:256/view:front'\n[preset.hero]\nsize = [1600, 900]\nsamples = 16\nlights = false\n\
             eye = [1, 2.5, 3]\npriority = 'low'\nlight = [{ type = 'point', intensity = 1 }]\n",
        )
        .unwrap();
        let pairs = |name: &str| {
            presets[name]
                .pairs
                .iter()
                .map(|(key, text)| format!("{key}={text}"))
                .collect::<Vec<_>>()
                .join(" ")
        };
        assert_eq!(pairs("thumb"), "size=256 view=front");
        assert_eq!(
            pairs("hero"),
            "eye=1,2.5,3 light=[{\"intensity\":1,\"type\":\"point\"}] lights=false samples=16 size=1600x900"
        );
        assert_eq!((presets["hero"].priority, presets["thumb"].priority), (Some(Priority::Low), None));
        assert_eq!(offers, Offers::default());
        assert!(offers.check("eye", "1,2,3").is_ok());
    }

    #[test]
    fn offered_values_are_taken_and_others_are_told() {
        let text = "[allow]\nsize = { min = 16, max = 512 }\nquality = ['draft', 'fast']\nsamples = [1, 4]\nview = true\n\
                    exposure = { min = -1.5, max = 1.5 }";
        let (_, offers) = parse(text).unwrap();
        for (key, text) in [
            ("size", "16"),
            ("size", "512x16"),
            ("quality", "fast"),
            ("samples", "4"),
            ("samples", "4.0"),
            ("view", "anything"),
            ("exposure", "-1.5"),
            ("format", "exr"),
        ] {
            assert!(offers.check(key, text).is_ok(), "{key}={text}");
        }
        for (key, text, what) in [
            ("size", "513", "16 to 512"),
            ("size", "64x15", "16 to 512"),
            ("size", "x", "16 to 512"),
            ("quality", "best", "draft, fast"),
            ("samples", "16", "1, 4"),
            ("exposure", "auto", "-1.5 to 1.5"),
            ("exposure", "NaN", "-1.5 to 1.5"),
            ("rays", "1", "not offered here"),
        ] {
            let problem = offers.check(key, text).unwrap_err();
            assert_eq!(problem.kind, Kind::NotOffered);
            assert!(problem.message.contains(what), "{key}={text}: {}", problem.message);
        }
        let (_, sizes) = parse("[allow]\nsize = ['64', [32, 16]]\nformat = ['webp']").unwrap();
        assert!(sizes.check("size", "64x64").is_ok() && sizes.check("size", "32:16").is_ok());
        assert!(sizes.check("size", "16x32").is_err() && sizes.check("format", "png").is_err());
        let (_, none) = parse("only = true\n[preset]\na = 'size:1'").unwrap();
        assert!(none.check("size", "1").unwrap_err().message.contains("presets alone"));
    }

    #[test]
    fn wrong_files_are_told_by_name() {
        for (text, what) in [
            ("only = true", "only: there are no presets"),
            ("only = true\n[preset]\na = ''\n[allow]\nsize = true", "only: nothing but presets"),
            ("only = 3", "line 1: "),
            ("\n[presets]\na = ''", "line 2: unknown field `presets`"),
            ("[preset]\n\na = 3", "line 3: expected a text such as"),
            ("[preset]\n'a/b' = ''", "preset.a/b: expected a name"),
            ("[preset]\nplain = ''", "preset.plain: expected a name"),
            ("[preset]\na = 'size'", "preset.a: 'size': expected NAME:VALUE"),
            ("[preset]\na = { priority = 'urgent' }", "preset.a: priority: "),
            ("[preset]\na = { size = 1979-05-27 }", "preset.a: size: cannot be datetime"),
            ("[allow]\ncolour = true", "allow.colour: there is no such option"),
            ("[allow]\nmodel = true", "allow.model: there is no such option"),
            ("[allow]\nwidth = true", "allow.width: size has"),
            ("[allow]\nsize = { min = 9, max = 8 }", "allow.size: the range from 9 to 8 is empty"),
            ("[allow]\nsize = { min = nan, max = 8 }", "allow.size: the range from NaN"),
            ("[allow]\nsize = { min = 1 }", "line 2: expected true, a list"),
            ("[allow]\nsize = []", "allow.size: the list is empty"),
            ("[allow]\nsize = false", "allow.size: what is not in the table"),
        ] {
            let error = parse(text).unwrap_err();
            assert!(error.starts_with(what), "{text}: {error}");
        }
    }
}
