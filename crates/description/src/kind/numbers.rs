//! Numbers, switches, sizes.

use super::Kind;
use crate::options::ExposureChoice;
use crate::value::Value;
use serde_json::{Value as Json, json};
use std::ops::RangeInclusive;

/// Stops of [`Exposure`].
const STOPS: RangeInclusive<f32> = -64.0..=64.0;

/// A number, whole where it is written so.
fn json_number(text: &str) -> Option<Json> {
    let whole = text.parse::<u64>().ok().map(Json::from);
    whole.or_else(|| text.parse::<f64>().ok().and_then(serde_json::Number::from_f64).map(Json::from))
}

fn query_number(text: &str) -> Result<Json, String> {
    json_number(text).ok_or_else(|| "a number".to_owned())
}

/// Three numbers with commas between them.
pub(super) fn query_vector(text: &str) -> Result<Json, String> {
    let numbers: Option<Vec<Json>> = text.split(',').map(|text| json_number(text.trim())).collect();
    numbers.filter(|all| all.len() == 3).map(Json::from).ok_or_else(|| "three numbers with commas".to_owned())
}

/// A double, with an error for what JSON cannot hold.
pub(super) fn write_double(number: f64) -> Result<Json, String> {
    if number.is_finite() { Ok(json!(number)) } else { Err(format!("{number} is no number")) }
}

/// With as few digits as tell it from its neighbours.
pub(super) fn write_float(number: f32) -> Result<Json, String> {
    let short = number.to_string().parse::<f64>().ok().filter(|v| *v as f32 == number);
    write_double(short.unwrap_or(f64::from(number)))
}

/// A number that is finite.
///
/// # Errors
/// A message that names the expected form.
fn finite(text: &str) -> Result<f32, String> {
    text.parse::<f32>().ok().filter(|v| v.is_finite()).ok_or_else(|| "expected a number".to_owned())
}

/// A number of single precision, from `low` to `high`, which are allowed as well: `f32::MIN` and `f32::MAX` stand for no bound.
pub(crate) struct Number {
    pub(crate) unit: &'static str,
    pub(crate) low: f32,
    pub(crate) high: f32,
}

impl Number {
    /// Any number.
    pub(crate) const fn any(unit: &'static str) -> Self {
        Self { unit, low: f32::MIN, high: f32::MAX }
    }

    /// A number that is not negative.
    pub(crate) const fn positive(unit: &'static str) -> Self {
        Self { unit, low: 0.0, high: f32::MAX }
    }

    /// A number with bounds.
    pub(crate) const fn within(unit: &'static str, low: f32, high: f32) -> Self {
        Self { unit, low, high }
    }

    fn expected(&self) -> String {
        let Self { unit, low, high } = self;
        match (*low, *high) {
            (f32::MIN, _) => format!("a number ({unit})"),
            (_, f32::MAX) => format!("a number from {low} ({unit})"),
            _ => format!("a number from {low} to {high} ({unit})"),
        }
    }
}

impl Kind for Number {
    type Value = f32;

    fn parse(&self, text: &str) -> Result<f32, String> {
        let Self { low, high, .. } = self;
        finite(text).ok().filter(|v| (*low..=*high).contains(v)).ok_or_else(|| match (*low, *high) {
            (f32::MIN, _) => "expected a number".to_owned(),
            (_, f32::MAX) => format!("expected a number, at least {low}"),
            _ => format!("expected {low} to {high}"),
        })
    }

    fn read(&self, value: &Value<'_>) -> Result<f32, String> {
        let number = value.node.number().map(|v| v as f32).filter(|v| (self.low..=self.high).contains(v));
        number.ok_or_else(|| value.expected(self.expected()))
    }

    fn write(&self, value: &f32) -> Result<Json, String> {
        write_float(*value)
    }

    fn schema(&self) -> Json {
        let mut number = json!({"type": "number"});
        // As it is written: 0.1 and not the double nearest to the float.
        let bound = |v: f32| v.to_string().parse::<f64>().unwrap_or_default();
        if self.low > f32::MIN {
            number["minimum"] = json!(bound(self.low));
        }
        if self.high < f32::MAX {
            number["maximum"] = json!(bound(self.high));
        }
        number
    }

    fn query(&self, text: &str) -> Result<Json, String> {
        query_number(text)
    }

    fn range(&self) -> Option<String> {
        (self.low > f32::MIN && self.high < f32::MAX).then(|| format!("{} to {}", self.low, self.high))
    }
}

/// Seconds: a finite number that is not negative.
///
/// # Errors
/// A message that names the expected form.
pub fn seconds(text: &str) -> Result<f64, String> {
    let number = text.parse::<f64>().ok().filter(|v| v.is_finite() && *v >= 0.0);
    number.ok_or_else(|| "expected seconds, at least 0".to_owned())
}

/// Seconds in an animation.
pub(crate) struct Seconds;

impl Kind for Seconds {
    type Value = f64;

    fn parse(&self, text: &str) -> Result<f64, String> {
        seconds(text)
    }

    fn read(&self, value: &Value<'_>) -> Result<f64, String> {
        let number = value.node.number().filter(|v| *v >= 0.0);
        number.ok_or_else(|| value.expected("a number of seconds, at least 0"))
    }

    fn write(&self, value: &f64) -> Result<Json, String> {
        write_double(*value)
    }

    fn schema(&self) -> Json {
        json!({"type": "number", "minimum": 0})
    }

    fn query(&self, text: &str) -> Result<Json, String> {
        query_number(text)
    }
}

/// A whole number from one to another.
pub(crate) struct Whole(pub(crate) RangeInclusive<u32>);

impl Kind for Whole {
    type Value = u32;

    fn parse(&self, text: &str) -> Result<u32, String> {
        let number = text.parse().ok().filter(|v| self.0.contains(v));
        number.ok_or_else(|| format!("expected {} to {}", self.0.start(), self.0.end()))
    }

    fn read(&self, value: &Value<'_>) -> Result<u32, String> {
        let number = value.node.whole().and_then(|v| u32::try_from(v).ok());
        number.filter(|v| self.0.contains(v)).ok_or_else(|| {
            value.expected(format_args!("a whole number from {} to {}", self.0.start(), self.0.end()))
        })
    }

    fn write(&self, value: &u32) -> Result<Json, String> {
        Ok(json!(value))
    }

    fn schema(&self) -> Json {
        json!({"type": "integer", "minimum": self.0.start(), "maximum": self.0.end()})
    }

    fn query(&self, text: &str) -> Result<Json, String> {
        query_number(text)
    }

    fn range(&self) -> Option<String> {
        Some(format!("{} to {}", self.0.start(), self.0.end()))
    }
}

/// One of a few whole numbers.
pub(crate) struct OneOf(pub(crate) &'static [&'static str]);

impl OneOf {
    fn list(&self) -> String {
        match self.0 {
            [first @ .., last] => format!("{} or {last}", first.join(", ")),
            [] => String::new(),
        }
    }
}

impl Kind for OneOf {
    type Value = u32;

    fn parse(&self, text: &str) -> Result<u32, String> {
        let known = self.0.contains(&text).then(|| text.parse().ok()).flatten();
        known.ok_or_else(|| format!("expected {}", self.list()))
    }

    fn read(&self, value: &Value<'_>) -> Result<u32, String> {
        let number = value.node.whole().and_then(|number| self.parse(&number.to_string()).ok());
        number.ok_or_else(|| value.expected(self.list()))
    }

    fn write(&self, value: &u32) -> Result<Json, String> {
        Ok(json!(value))
    }

    fn schema(&self) -> Json {
        json!({"enum": self.0.iter().filter_map(|text| text.parse::<u32>().ok()).collect::<Vec<_>>()})
    }

    fn query(&self, text: &str) -> Result<Json, String> {
        query_number(text)
    }

    fn names(&self) -> Vec<&'static str> {
        self.0.to_vec()
    }

    fn range(&self) -> Option<String> {
        Some(self.list())
    }
}

/// True or false.
pub(crate) struct Switch;

impl Kind for Switch {
    type Value = bool;

    fn parse(&self, text: &str) -> Result<bool, String> {
        match text {
            "true" | "1" => Ok(true),
            "false" | "0" => Ok(false),
            _ => Err("expected true or false".to_owned()),
        }
    }

    fn read(&self, value: &Value<'_>) -> Result<bool, String> {
        value.node.switch().ok_or_else(|| value.expected("true or false"))
    }

    fn write(&self, value: &bool) -> Result<Json, String> {
        Ok(json!(value))
    }

    fn schema(&self) -> Json {
        json!({"type": "boolean"})
    }

    fn query(&self, text: &str) -> Result<Json, String> {
        self.parse(text).map(Json::from).map_err(|_| "true or false".to_owned())
    }

    fn names(&self) -> Vec<&'static str> {
        vec!["true", "false"]
    }
}

/// Stops, or `auto`.
///
/// # Errors
/// A message that names the expected form.
pub(crate) fn exposure(text: &str) -> Result<ExposureChoice, String> {
    match text {
        "auto" => Ok(ExposureChoice::Auto),
        stops => finite(stops)
            .ok()
            .filter(|v| STOPS.contains(v))
            .map(ExposureChoice::Stops)
            .ok_or_else(|| "expected -64 to 64 stops, or auto".to_owned()),
    }
}

/// Stops, or `auto`.
pub(crate) struct Exposure;

impl Exposure {
    const NUMBER: Number = Number::within("stops", *STOPS.start(), *STOPS.end());
}

impl Kind for Exposure {
    type Value = ExposureChoice;

    fn parse(&self, text: &str) -> Result<ExposureChoice, String> {
        exposure(text)
    }

    fn read(&self, value: &Value<'_>) -> Result<ExposureChoice, String> {
        match value.node.text() {
            Some(text) if text == "auto" => Ok(ExposureChoice::Auto),
            Some(_) => Err(value.expected("a number of stops or 'auto'")),
            None => Self::NUMBER.read(value).map(ExposureChoice::Stops),
        }
    }

    fn write(&self, value: &ExposureChoice) -> Result<Json, String> {
        match value {
            ExposureChoice::Auto => Ok(json!("auto")),
            ExposureChoice::Stops(stops) => write_float(*stops),
        }
    }

    fn schema(&self) -> Json {
        json!({"anyOf": [Self::NUMBER.schema(), {"enum": ["auto"]}]})
    }

    fn query(&self, text: &str) -> Result<Json, String> {
        Ok(json_number(text).unwrap_or_else(|| text.into()))
    }

    fn names(&self) -> Vec<&'static str> {
        vec!["auto"]
    }
}

/// `WxH` or `N` for a square. Zero and sizes beyond the limits are refused later, with the file's name.
///
/// # Errors
/// A message that names the expected form.
pub fn size(text: &str) -> Result<[u64; 2], String> {
    let number = |t: &str| t.parse::<u64>().map_err(|_| "expected WxH or N, in pixels".to_owned());
    match text.split_once(['x', 'X']) {
        Some((w, h)) => Ok([number(w)?, number(h)?]),
        None => number(text).map(|n| [n, n]),
    }
}

/// Width and height in pixels; one number makes a square.
pub(crate) struct Size;

impl Kind for Size {
    type Value = [u64; 2];

    fn parse(&self, text: &str) -> Result<[u64; 2], String> {
        size(text)
    }

    fn read(&self, value: &Value<'_>) -> Result<[u64; 2], String> {
        if let Some(side) = value.node.whole() {
            return Ok([side; 2]);
        }
        let sides = value.node.list().and_then(|list| match &list[..] {
            [width, height] => Some([width.whole()?, height.whole()?]),
            _ => None,
        });
        sides.ok_or_else(|| value.expected("two whole numbers, width and height in pixels"))
    }

    fn write(&self, value: &[u64; 2]) -> Result<Json, String> {
        Ok(json!(value))
    }

    fn schema(&self) -> Json {
        let side = || json!({"type": "integer", "minimum": 0});
        json!({"anyOf": [side(), {"type": "array", "items": side(), "minItems": 2, "maxItems": 2}]})
    }

    fn query(&self, text: &str) -> Result<Json, String> {
        size(&text.replace(',', "x")).map(|sides| json!(sides)).map_err(|_| "WxH".to_owned())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes() {
        assert_eq!(size("640x480"), Ok([640, 480]));
        assert_eq!(size("512"), Ok([512, 512]));
        assert_eq!(size("1000000000"), Ok([1_000_000_000; 2]));
        for bad in ["", "x", "10x", "x10", "-1", "1.5", "10x10x10", "99999999999999999999"] {
            assert!(size(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn exposures() {
        assert_eq!(exposure("auto"), Ok(ExposureChoice::Auto));
        assert_eq!(exposure("-1.5"), Ok(ExposureChoice::Stops(-1.5)));
        assert_eq!(exposure("65"), Err("expected -64 to 64 stops, or auto".to_owned()));
        assert!(exposure("automatic").is_err());
    }

    #[test]
    fn numbers_within_bounds() {
        let degrees = Number::within("degrees", 0.1, 179.0);
        assert_eq!((degrees.parse("179"), Whole(1..=16).parse("1")), (Ok(179.0), Ok(1)));
        for bad in ["0", "179.5", "nan", "inf", "", "x"] {
            assert_eq!(degrees.parse(bad), Err("expected 0.1 to 179".to_owned()), "{bad}");
        }
        assert_eq!(Whole(0..=1024).parse("-1"), Err("expected 0 to 1024".to_owned()));
        assert!(Number::any("degrees").parse("inf").is_err());
    }

    #[test]
    fn a_list_of_numbers_in_words() {
        let rates = OneOf(&["1", "4", "8", "9", "16"]);
        assert_eq!((rates.parse("9"), rates.range()), (Ok(9), Some("1, 4, 8, 9 or 16".to_owned())));
        assert_eq!(rates.parse("2"), Err("expected 1, 4, 8, 9 or 16".to_owned()));
    }
}
