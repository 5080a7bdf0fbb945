//! Thresholds for the differences between pictures: a TOML file of limits by file name.
//!
//! ```toml
//! # For every file: no more than two codes of 255 in any channel, but for 20 pixels.
//! max_abs = 2
//! pixels = 20
//!
//! ["cars/*.exr"]            # later tables win over earlier ones, key by key
//! flip_mean = 0.01
//!
//! ["cars/red.exr"]
//! flip_mean = 0.02
//! start_exposure = -2
//! ```
//!
//! A file for which no limit is given must be equal. As soon as one is given, those that are given decide, all of them.
//!
//! `preset = "gpu"` stands for limits that go together, see [`Preset`]. It takes the place of those that earlier tables give; keys
//! of its own table and later ones win over what it stands for.

use super::metrics::{MetricSettings, Metrics};
pub use super::preset::Preset;
use overcoat_core::color::hex_color;
use overcoat_core::suggest::nearest_name;
use overcoat_image::decode::SampleKind;
use std::fmt::Write as _;
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeString, DeTable, DeValue};

/// Limits that one file has to meet.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Thresholds {
    /// Limits for `max_abs` and `pixels` where those are not given.
    pub preset: Option<Preset>,
    /// Largest difference of a channel that does not count: codes (0 to 255, or 65535), or linear light.
    pub max_abs: Option<f64>,
    /// Pixels that may differ by more than `max_abs` (0 if that is not given).
    pub pixels: Option<u64>,
    /// Least peak signal-to-noise ratio in dB.
    pub psnr: Option<f64>,
    /// Least structural similarity, up to 1.
    pub ssim: Option<f64>,
    /// Largest mean of the FLIP map, 0 to 1.
    pub flip_mean: Option<f64>,
    /// Largest value in the FLIP map, 0 to 1.
    pub flip_max: Option<f64>,
    /// Largest size of an expected file in bytes that a strict check accepts; any size where `None`.
    pub max_bytes: Option<u64>,
    /// Settings of the measures.
    pub metrics: MetricSettings,
}

impl Thresholds {
    /// The same with another [`Thresholds::preset`].
    #[must_use]
    pub fn with_preset(self, preset: Option<Preset>) -> Self {
        Self { preset, ..self }
    }

    /// The same with another [`Thresholds::max_abs`].
    #[must_use]
    pub fn with_max_abs(self, max_abs: Option<f64>) -> Self {
        Self { max_abs, ..self }
    }

    /// The same with another [`Thresholds::pixels`].
    #[must_use]
    pub fn with_pixels(self, pixels: Option<u64>) -> Self {
        Self { pixels, ..self }
    }

    /// The same with another [`Thresholds::psnr`].
    #[must_use]
    pub fn with_psnr(self, psnr: Option<f64>) -> Self {
        Self { psnr, ..self }
    }

    /// The same with another [`Thresholds::ssim`].
    #[must_use]
    pub fn with_ssim(self, ssim: Option<f64>) -> Self {
        Self { ssim, ..self }
    }

    /// The same with another [`Thresholds::flip_mean`].
    #[must_use]
    pub fn with_flip_mean(self, flip_mean: Option<f64>) -> Self {
        Self { flip_mean, ..self }
    }

    /// The same with another [`Thresholds::flip_max`].
    #[must_use]
    pub fn with_flip_max(self, flip_max: Option<f64>) -> Self {
        Self { flip_max, ..self }
    }

    /// The same with another [`Thresholds::max_bytes`].
    #[must_use]
    pub fn with_max_bytes(self, max_bytes: Option<u64>) -> Self {
        Self { max_bytes, ..self }
    }

    /// The same with another [`Thresholds::metrics`].
    #[must_use]
    pub fn with_metrics(self, metrics: MetricSettings) -> Self {
        Self { metrics, ..self }
    }
}

impl Thresholds {
    /// The same limits for pictures of this kind, without a preset.
    pub(super) fn resolved(&self, kind: SampleKind) -> Self {
        let Some((max_abs, pixels)) = self.preset.and_then(|preset| preset.limits(kind)) else {
            return Self { preset: None, ..self.clone() };
        };
        Self {
            preset: None,
            max_abs: self.max_abs.or(Some(max_abs)),
            pixels: self.pixels.or(Some(pixels)),
            ..self.clone()
        }
    }

    /// Takes a preset in place of all limits so far.
    fn start_with(&mut self, preset: Preset) {
        let (max_bytes, metrics) = (self.max_bytes, self.metrics.clone());
        *self = Self { preset: Some(preset), max_bytes, metrics, ..Self::default() };
    }

    /// True if nothing but equality will do.
    #[must_use]
    pub fn is_exact(&self) -> bool {
        self.preset != Some(Preset::Gpu)
            && self.max_abs.is_none()
            && self.pixels.is_none()
            && self.psnr.is_none()
            && self.ssim.is_none()
            && self.flip_mean.is_none()
            && self.flip_max.is_none()
    }

    /// Violations of the limits, one sentence each; none if the file passes.
    #[must_use]
    pub fn violations(&self, metrics: &Metrics) -> Vec<String> {
        let mut out = Vec::new();
        let exact = &metrics.exact;
        if self.is_exact() {
            if exact.pixels > 0 {
                out.push(format!("{} by up to {}", pixels_differ(exact.pixels), short(exact.max_abs)));
            }
            return out;
        }
        if self.max_abs.is_some() || self.pixels.is_some() {
            let (tolerance, most) = (self.max_abs.unwrap_or(0.0), self.pixels.unwrap_or(0));
            let above = exact.pixels_above(tolerance);
            if above > most {
                let mut text = pixels_differ(above);
                if tolerance > 0.0 {
                    let _ = write!(text, " by more than {}", short(tolerance));
                }
                let _ = write!(text, " (up to {}; {most} allowed)", short(exact.max_abs));
                out.push(text);
            }
        }
        let mut at_least = |name: &str, value: f64, limit: Option<f64>| {
            if let Some(limit) = limit
                && (value.is_nan() || value < limit)
            {
                out.push(format!("{name} is {}, at least {} is asked for", short(value), short(limit)));
            }
        };
        at_least("psnr", metrics.psnr, self.psnr);
        at_least("ssim", metrics.ssim, self.ssim);
        let mut at_most = |name: &str, value: f64, limit: Option<f64>| {
            if let Some(limit) = limit
                && (value.is_nan() || value > limit)
            {
                out.push(format!("{name} is {}, at most {} is allowed", short(value), short(limit)));
            }
        };
        at_most("flip_mean", metrics.flip_mean, self.flip_mean);
        at_most("flip_max", metrics.flip_max, self.flip_max);
        out
    }
}

pub(super) fn pixels_differ(count: u64) -> String {
    if count == 1 { "1 pixel differs".to_owned() } else { format!("{count} pixels differ") }
}

/// A number with at most five significant digits.
pub(super) fn short(value: f64) -> String {
    if !value.is_finite() || value == 0.0 {
        return if value.is_nan() { "not a number".to_owned() } else { format!("{value}") };
    }
    let magnitude = value.abs();
    if !(1e-4..1e7).contains(&magnitude) {
        return format!("{value:.3e}");
    }
    let mut decimals = 4;
    let mut bound = 10.0;
    while decimals > 0 && magnitude >= bound {
        decimals -= 1;
        bound *= 10.0;
    }
    if magnitude < 0.1 {
        decimals += 2;
    }
    let text = format!("{value:.decimals$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

/// Something that is wrong with a threshold file.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct ThresholdProblem {
    /// The line, from 1.
    pub line: usize,
    /// Description of the problem.
    pub message: String,
}

/// A table of a threshold file.
#[derive(Clone, Debug, PartialEq)]
struct Rule {
    /// The names that it is for; `None` for the keys before the first table, which are for all.
    pattern: Option<String>,
    line: usize,
    settings: Vec<(&'static Key, Value)>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Value {
    Number(f64),
    Colour([u8; 3]),
    Preset(Preset),
}

/// A threshold file. What is wrong in it is kept beside what is right, so that one misspelled key does not keep a folder
/// from being compared.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ThresholdFile {
    rules: Vec<Rule>,
    problems: Vec<ThresholdProblem>,
}

/// The numbers that a key takes, in words and as a test.
type NumberRange = (&'static str, fn(f64) -> bool);

/// Kinds of values of keys.
enum Takes {
    Number(NumberRange),
    Colour,
    Preset,
}

/// A key with what it takes.
struct Key {
    name: &'static str,
    takes: Takes,
    set: fn(&mut Thresholds, Value),
}

impl PartialEq for Key {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

impl std::fmt::Debug for Key {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name)
    }
}

impl Value {
    fn number(self) -> f64 {
        if let Self::Number(v) = self { v } else { 0.0 }
    }
}

fn is_count(v: f64) -> bool {
    v >= 0.0 && v == v.floor() && v <= 9_007_199_254_740_992.0
}

fn is_share(v: f64) -> bool {
    (0.0..=1.0).contains(&v)
}

fn is_exposure(v: f64) -> bool {
    v.abs() <= 128.0
}

static KEYS: [Key; 12] = [
    Key {
        name: "preset",
        takes: Takes::Preset,
        set: |t, v| {
            if let Value::Preset(preset) = v {
                t.start_with(preset);
            }
        },
    },
    Key {
        name: "max_abs",
        takes: Takes::Number(("a number from 0", |v| v >= 0.0)),
        set: |t, v| t.max_abs = Some(v.number()),
    },
    Key {
        name: "pixels",
        takes: Takes::Number(("a whole number from 0", is_count)),
        set: |t, v| t.pixels = Some(v.number() as u64),
    },
    Key {
        name: "psnr",
        takes: Takes::Number(("a number of decibels from 0", |v| v >= 0.0)),
        set: |t, v| t.psnr = Some(v.number()),
    },
    Key {
        name: "ssim",
        takes: Takes::Number(("a number from -1 to 1", |v| (-1.0..=1.0).contains(&v))),
        set: |t, v| t.ssim = Some(v.number()),
    },
    Key {
        name: "flip_mean",
        takes: Takes::Number(("a number from 0 to 1", is_share)),
        set: |t, v| t.flip_mean = Some(v.number()),
    },
    Key {
        name: "flip_max",
        takes: Takes::Number(("a number from 0 to 1", is_share)),
        set: |t, v| t.flip_max = Some(v.number()),
    },
    Key {
        name: "pixels_per_degree",
        takes: Takes::Number(("a number from 1 to 1000", |v| (1.0..=1000.0).contains(&v))),
        set: |t, v| t.metrics.pixels_per_degree = v.number() as f32,
    },
    Key {
        name: "start_exposure",
        takes: Takes::Number(("a number of stops from -128 to 128", is_exposure)),
        set: |t, v| t.metrics.start_exposure = Some(v.number() as f32),
    },
    Key {
        name: "stop_exposure",
        takes: Takes::Number(("a number of stops from -128 to 128", is_exposure)),
        set: |t, v| t.metrics.stop_exposure = Some(v.number() as f32),
    },
    Key {
        name: "background",
        takes: Takes::Colour,
        set: |t, v| {
            if let Value::Colour(colour) = v {
                t.metrics.background = colour;
            }
        },
    },
    Key {
        name: "max_bytes",
        takes: Takes::Number(("a whole number from 0", is_count)),
        set: |t, v| t.max_bytes = Some(v.number() as u64),
    },
];

impl ThresholdFile {
    /// Reads the text of a threshold file. What is wrong is found in [`Self::problems`].
    #[must_use]
    pub fn parse(text: &str) -> Self {
        let mut out = Self::default();
        let line = |span: &Range<usize>| {
            let before = text.as_bytes().get(..span.start).unwrap_or(text.as_bytes());
            1 + before.iter().filter(|&&b| b == b'\n').count()
        };
        let table = match DeTable::parse(text) {
            Ok(table) => table,
            Err(error) => {
                let at = error.span().map_or(1, |span| line(&span));
                out.problem(at, error.message().lines().collect::<Vec<_>>().join(" "));
                return out;
            }
        };
        let mut common = Rule { pattern: None, line: 1, settings: Vec::new() };
        let mut tables = Vec::new();
        for (name, value) in in_order(table.get_ref()) {
            let at = line(&name.span());
            let Some(entries) = value.get_ref().as_table() else {
                common.settings.extend(out.setting(name.get_ref(), at, value.get_ref()));
                continue;
            };
            let mut rule = Rule { pattern: Some(name.get_ref().to_string()), line: at, settings: Vec::new() };
            for (key, value) in in_order(entries) {
                rule.settings.extend(out.setting(key.get_ref(), line(&key.span()), value.get_ref()));
            }
            tables.push(rule);
        }
        out.rules.push(common);
        out.rules.extend(tables);
        out
    }

    /// Problems of the file, in the order of its lines.
    #[must_use]
    pub fn problems(&self) -> &[ThresholdProblem] {
        &self.problems
    }

    /// Limits for the file of this name; `/` stands between folders.
    #[must_use]
    pub fn of(&self, name: &str, otherwise: &Thresholds) -> Thresholds {
        let mut out = otherwise.clone();
        for rule in &self.rules {
            if rule.pattern.as_ref().is_none_or(|pattern| matches(pattern, name)) {
                // Keys win over the preset beside them wherever it stands.
                for presets in [true, false] {
                    for (key, value) in &rule.settings {
                        if matches!(value, Value::Preset(_)) == presets {
                            (key.set)(&mut out, *value);
                        }
                    }
                }
            }
        }
        out
    }

    /// The tables that are for none of these names: their lines and patterns.
    #[must_use]
    pub fn unused<'a>(&self, names: impl Iterator<Item = &'a str> + Clone) -> Vec<(usize, &str)> {
        self.rules
            .iter()
            .filter_map(|rule| {
                let pattern = rule.pattern.as_deref()?;
                let used = names.clone().any(|name| matches(pattern, name));
                (!used).then_some((rule.line, pattern))
            })
            .collect()
    }

    fn problem(&mut self, line: usize, message: String) {
        self.problems.push(ThresholdProblem { line, message });
    }

    /// One key with its value; what is wrong with it becomes a problem.
    fn setting(&mut self, name: &str, line: usize, value: &DeValue<'_>) -> Option<(&'static Key, Value)> {
        let Some(key) = KEYS.iter().find(|key| key.name == name) else {
            let nearest = nearest_name(name, KEYS.iter().map(|key| key.name));
            let hint = match nearest {
                Some(nearest) => format!("; did you mean '{nearest}'?"),
                None => {
                    let names: Vec<&str> = KEYS.iter().map(|key| key.name).collect();
                    format!("; known are {}", names.join(", "))
                }
            };
            self.problem(line, format!("unknown key '{name}'{hint}"));
            return None;
        };
        let found = match key.takes {
            Takes::Number((_, is_valid)) => number(value).filter(|&v| is_valid(v)).map(Value::Number),
            Takes::Colour => value.as_str().and_then(colour).map(Value::Colour),
            Takes::Preset => value.as_str().and_then(Preset::from_name).map(Value::Preset),
        };
        if found.is_none() {
            let what = match key.takes {
                Takes::Number((range, _)) => range.to_owned(),
                Takes::Colour => "a colour such as \"#808080\"".to_owned(),
                Takes::Preset => {
                    Preset::ALL.iter().map(|p| format!("\"{}\"", p.name())).collect::<Vec<_>>().join(" or ")
                }
            };
            self.problem(line, format!("{name} takes {what}"));
        }
        found.map(|value| (key, value))
    }
}

/// A number of a threshold file.
fn number(value: &DeValue<'_>) -> Option<f64> {
    match value {
        DeValue::Integer(v) => i64::from_str_radix(v.as_str(), v.radix()).ok().map(|v| v as f64),
        DeValue::Float(v) => v.as_str().parse().ok(),
        _ => None,
    }
}

/// A colour written as `#rrggbb`, without `#` as well.
#[must_use]
pub fn colour(text: &str) -> Option<[u8; 3]> {
    match hex_color(text)? {
        (colour, None) => Some(colour),
        (_, Some(_)) => None,
    }
}

/// Entries of a table as they stand in the file.
fn in_order<'a, 'i>(table: &'a DeTable<'i>) -> Vec<(&'a Spanned<DeString<'i>>, &'a Spanned<DeValue<'i>>)> {
    let mut entries: Vec<_> = table.iter().collect();
    entries.sort_by_key(|(name, _)| name.span().start);
    entries
}

/// True if a pattern is for a name: `?` is one character and `*` any number of them, both without `/`; `**` is any
/// number with `/`.
#[must_use]
pub fn matches(pattern: &str, name: &str) -> bool {
    let pattern: Vec<char> = pattern.chars().collect();
    let name: Vec<char> = name.chars().collect();
    // reached[k]: the pattern so far matches the first k characters.
    let mut reached = vec![false; name.len() + 1];
    reached[0] = true;
    let mut at = 0;
    while at < pattern.len() {
        let c = pattern[at];
        let deep = c == '*' && pattern.get(at + 1) == Some(&'*');
        at += 1 + usize::from(deep);
        let mut next = vec![false; name.len() + 1];
        for k in 0..=name.len() {
            next[k] = if c == '*' {
                reached[k] || (k > 0 && next[k - 1] && (deep || name[k - 1] != '/'))
            } else {
                k > 0 && reached[k - 1] && (name[k - 1] == c || (c == '?' && name[k - 1] != '/'))
            };
        }
        reached = next;
    }
    reached[name.len()]
}

#[cfg(test)]
mod tests {
    use super::super::metrics::measure;
    use super::*;
    use overcoat_image::decode::{DecodedPicture, SampleKind};

    #[test]
    fn later_tables_win_key_by_key() {
        let file = ThresholdFile::parse(
            "max_abs = 2\n[\"cars/*.exr\"]\nflip_mean = 0.01\npixels = 5\n[\"cars/red.exr\"]\nflip_mean = 0.25\n\
             background = \"#ff8000\"\n[\"**.png\"]\nssim = 0.5\n",
        );
        assert_eq!(file.problems(), []);
        let of = |name: &str| file.of(name, &Thresholds::default());
        assert_eq!(of("cars/blue.exr").flip_mean, Some(0.01));
        let red = of("cars/red.exr");
        assert_eq!((red.flip_mean, red.pixels, red.max_abs), (Some(0.25), Some(5), Some(2.0)));
        assert_eq!(red.metrics.background, [255, 128, 0]);
        assert_eq!(of("cars/deep/red.exr").flip_mean, None);
        assert_eq!(of("a/b/c.png").ssim, Some(0.5));
        let names = ["cars/blue.exr", "x.png"];
        assert_eq!(file.unused(names.iter().copied()), [(5, "cars/red.exr")]);
        assert!(ThresholdFile::parse("").of("x", &Thresholds::default()).is_exact());
    }

    #[test]
    fn what_is_wrong_is_named_with_its_line_and_the_rest_counts() {
        let file = ThresholdFile::parse(
            "max_asb = 3\npsnr = 30\n[\"x.png\"]\nflip-mean = 1\nssim = 2\npixels = 1.5\nxyzzy = 1\n\
             background = \"red\"\npsnr = true\n",
        );
        let messages: Vec<(usize, &str)> =
            file.problems().iter().map(|p| (p.line, p.message.as_str())).collect();
        assert_eq!(messages[0], (1, "unknown key 'max_asb'; did you mean 'max_abs'?"));
        assert_eq!(messages[1], (4, "unknown key 'flip-mean'; did you mean 'flip_mean'?"));
        assert_eq!(messages[2], (5, "ssim takes a number from -1 to 1"));
        assert_eq!(messages[3], (6, "pixels takes a whole number from 0"));
        assert!(
            messages[4].1.starts_with("unknown key 'xyzzy'; known are preset, max_abs, "),
            "{messages:?}"
        );
        assert_eq!(messages[5].0, 8);
        assert_eq!(messages[6], (9, "psnr takes a number of decibels from 0"));
        assert_eq!(file.of("x.png", &Thresholds::default()).psnr, Some(30.0));
        assert_eq!(ThresholdFile::parse("a = [\n").problems().len(), 1);
    }

    #[test]
    fn patterns() {
        for (pattern, name, expected) in [
            ("a.png", "a.png", true),
            ("a.png", "b/a.png", false),
            ("*.png", "a.png", true),
            ("*.png", "b/a.png", false),
            ("**.png", "b/a.png", true),
            ("b/**", "b/c/a.png", true),
            ("?.png", "a.png", true),
            ("?.png", "ab.png", false),
            ("*a*a*", "banana", true),
            ("*x*", "banana", false),
            ("", "", true),
            ("*", "", true),
        ] {
            assert_eq!(matches(pattern, name), expected, "{pattern} {name}");
        }
        // No pattern takes long.
        assert!(!matches(&"*a".repeat(200), &"a".repeat(199)));
    }

    #[test]
    fn limits_are_held_against_the_measures() {
        let picture = |values: &[f32]| {
            DecodedPicture::still(
                [values.len() as u32, 1],
                SampleKind::Unsigned8,
                values.iter().map(|&v| [v, v, v, 255.0]).collect(),
            )
        };
        let metrics = |actual: &[f32]| {
            measure(&picture(&[10.0, 20.0, 30.0, 40.0]), &picture(actual), &MetricSettings::default())
                .unwrap()
                .metrics
        };
        let off = metrics(&[10.0, 21.0, 33.0, 40.0]);
        let violations = |toml: &str| {
            let file = ThresholdFile::parse(toml);
            assert_eq!(file.problems(), []);
            file.of("x", &Thresholds::default()).violations(&off)
        };
        assert_eq!(violations(""), ["2 pixels differ by up to 3"]);
        assert_eq!(violations("max_abs = 3"), [""; 0]);
        assert_eq!(violations("max_abs = 2"), ["1 pixel differs by more than 2 (up to 3; 0 allowed)"]);
        assert_eq!(violations("max_abs = 2\npixels = 1"), [""; 0]);
        assert_eq!(violations("pixels = 1"), ["2 pixels differ (up to 3; 1 allowed)"]);
        assert_eq!(violations("psnr = 20"), [""; 0]);
        assert_eq!(violations("psnr = 90\nmax_abs = 3").len(), 1);
        assert_eq!(violations("ssim = 1\nflip_mean = 0\nflip_max = 0").len(), 3);
        assert_eq!(Thresholds::default().violations(&metrics(&[10.0, 20.0, 30.0, 40.0])), [""; 0]);
    }

    #[test]
    fn numbers_in_messages_are_short() {
        for (value, text) in [
            (3.0, "3"),
            (0.5, "0.5"),
            (0.012_345_6, "0.012346"),
            (37.123_456, "37.123"),
            (123_456.7, "123457"),
            (f64::INFINITY, "inf"),
            (0.0, "0"),
            (1e-9, "1.000e-9"),
        ] {
            assert_eq!(short(value), text);
        }
    }
}
