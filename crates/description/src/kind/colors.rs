//! Colours, by name or digits.

use super::Kind;
use super::names::hint;
use super::vectors::{list_schema, read_floats, write_floats};
use crate::options::BackgroundChoice;
use crate::value::Value;
use overcoat_core::color::{hex_color, srgb::srgb8_to_linear};
use overcoat_render::Ground;
use serde_json::{Value as Json, json};

/// Pattern of colours, as [`hex_color`] takes them without alpha.
pub(crate) const HEX_COLOR: &str = "^#?([0-9A-Fa-f]{3}|[0-9A-Fa-f]{6})$";

/// Colours by name: the sixteen of HTML and a few that pictures of products want.
const COLORS: [(&str, [u8; 3]); 20] = [
    ("black", [0, 0, 0]),
    ("silver", [192, 192, 192]),
    ("gray", [128, 128, 128]),
    ("grey", [128, 128, 128]),
    ("white", [255, 255, 255]),
    ("maroon", [128, 0, 0]),
    ("red", [255, 0, 0]),
    ("purple", [128, 0, 128]),
    ("fuchsia", [255, 0, 255]),
    ("magenta", [255, 0, 255]),
    ("green", [0, 128, 0]),
    ("lime", [0, 255, 0]),
    ("olive", [128, 128, 0]),
    ("yellow", [255, 255, 0]),
    ("navy", [0, 0, 128]),
    ("blue", [0, 0, 255]),
    ("teal", [0, 128, 128]),
    ("aqua", [0, 255, 255]),
    ("cyan", [0, 255, 255]),
    ("orange", [255, 165, 0]),
];

/// A colour by name or digits, without alpha.
fn color(lower: &str) -> Option<[u8; 3]> {
    if let Some((_, color)) = COLORS.iter().find(|(name, _)| *name == lower) {
        return Some(*color);
    }
    match hex_color(lower) {
        Some((color, None)) => Some(color),
        _ => None,
    }
}

/// A message with all names, and the one that may have been meant.
fn no_color(text: &str, names: &[&'static str]) -> String {
    let hint = hint(text, names.iter().copied());
    format!("neither #rrggbb nor one of {}{hint}", names.join(", "))
}

fn with_colors(own: [&'static str; 2]) -> Vec<&'static str> {
    own.into_iter().chain(COLORS.iter().map(|(name, _)| *name)).collect()
}

fn names_or_digits(names: &[&str]) -> Json {
    json!({"anyOf": [{"enum": names}, {"type": "string", "pattern": HEX_COLOR}]})
}

fn digits([r, g, b]: [u8; 3]) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

/// `transparent`, `env`, a colour name, `#rgb` or `#rrggbb`, both without `#` as well.
///
/// # Errors
/// The names that there are.
pub fn background(text: &str) -> Result<BackgroundChoice, String> {
    let lower = text.to_ascii_lowercase();
    match lower.as_str() {
        "transparent" => Ok(BackgroundChoice::Transparent),
        "env" | "environment" => Ok(BackgroundChoice::Environment),
        _ => color(&lower)
            .map(BackgroundChoice::Color)
            .ok_or_else(|| no_color(&lower, &BackgroundColor.names())),
    }
}

/// The background: transparent, the environment or a colour.
pub(crate) struct BackgroundColor;

impl Kind for BackgroundColor {
    type Value = BackgroundChoice;

    fn parse(&self, text: &str) -> Result<BackgroundChoice, String> {
        background(text)
    }

    fn read(&self, value: &Value<'_>) -> Result<BackgroundChoice, String> {
        value.parsed("a colour, transparent or env", background)
    }

    fn write(&self, value: &BackgroundChoice) -> Result<Json, String> {
        Ok(match value {
            BackgroundChoice::Transparent => json!("transparent"),
            BackgroundChoice::Environment => json!("env"),
            BackgroundChoice::Color(color) => json!(digits(*color)),
        })
    }

    fn schema(&self) -> Json {
        names_or_digits(&self.names())
    }

    fn names(&self) -> Vec<&'static str> {
        with_colors(["transparent", "env"])
    }
}

/// `none`, `shadow`, a colour name, `#rgb` or `#rrggbb`, both without `#` as well.
///
/// # Errors
/// The names that there are.
pub fn ground(text: &str) -> Result<Ground, String> {
    let lower = text.to_ascii_lowercase();
    match lower.as_str() {
        "none" => Ok(Ground::None),
        "shadow" => Ok(Ground::Shadow),
        _ => color(&lower).map(Ground::Color).ok_or_else(|| no_color(&lower, &FloorColor.names())),
    }
}

/// A floor as it is written: `none`, `shadow` or `#rrggbb`.
pub fn ground_name(ground: Ground) -> String {
    match ground {
        Ground::None => "none".to_owned(),
        Ground::Shadow => "shadow".to_owned(),
        Ground::Color(color) => digits(color),
    }
}

/// The floor: none, the shadow on it alone, or a colour.
pub(crate) struct FloorColor;

impl Kind for FloorColor {
    type Value = Ground;

    fn parse(&self, text: &str) -> Result<Ground, String> {
        ground(text)
    }

    fn read(&self, value: &Value<'_>) -> Result<Ground, String> {
        value.parsed("none, shadow or a colour", ground)
    }

    fn write(&self, value: &Ground) -> Result<Json, String> {
        Ok(json!(ground_name(*value)))
    }

    fn schema(&self) -> Json {
        names_or_digits(&self.names())
    }

    fn names(&self) -> Vec<&'static str> {
        with_colors(["none", "shadow"])
    }
}

/// Linear red, green and blue, or an sRGB colour `#rrggbb`.
pub(crate) struct LinearColor;

impl Kind for LinearColor {
    type Value = [f32; 3];

    fn parse(&self, text: &str) -> Result<[f32; 3], String> {
        match hex_color(text) {
            Some((color, None)) => Ok(color.map(srgb8_to_linear)),
            _ => Err("expected a colour #rrggbb".to_owned()),
        }
    }

    fn read(&self, value: &Value<'_>) -> Result<[f32; 3], String> {
        match value.node.text() {
            None => read_floats(value, "red, green and blue"),
            Some(text) => {
                self.parse(&text).map_err(|_| value.expected("a list of 3 numbers or a colour #rrggbb"))
            }
        }
    }

    fn write(&self, value: &[f32; 3]) -> Result<Json, String> {
        write_floats(value)
    }

    fn schema(&self) -> Json {
        json!({"anyOf": [list_schema(3), {"type": "string", "pattern": HEX_COLOR}]})
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use overcoat_core::suggest::suggestion;

    #[test]
    fn the_beginning_of_a_name_is_enough_to_suggest_it() {
        for (text, name) in [("trans", "transparent"), ("Transp", "transparent"), ("whit", "white")] {
            let message = background(text).unwrap_err();
            assert!(message.ends_with(&suggestion(Some(name))), "{message}");
        }
    }

    #[test]
    fn backgrounds() {
        assert_eq!(background("transparent"), Ok(BackgroundChoice::Transparent));
        assert_eq!(background("env"), Ok(BackgroundChoice::Environment));
        assert_eq!(background("White"), Ok(BackgroundChoice::Color([255; 3])));
        assert_eq!(background("#0f8"), Ok(BackgroundChoice::Color([0, 255, 136])));
        assert_eq!(background("#0A141e"), Ok(BackgroundChoice::Color([10, 20, 30])));
        assert_eq!(background("ff8800"), Ok(BackgroundChoice::Color([255, 136, 0])));
        for bad in ["", "#", "#12", "#12345", "#gggggg", "#1234567", "whitish", "é", "#éé", "ff880033"] {
            assert!(background(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn grounds() {
        assert_eq!((ground("none"), ground("Shadow")), (Ok(Ground::None), Ok(Ground::Shadow)));
        assert_eq!(
            (ground("white"), ground("#0a141e")),
            (Ok(Ground::Color([255; 3])), Ok(Ground::Color([10, 20, 30])))
        );
        assert!(ground("shadwo").unwrap_err().ends_with("did you mean 'shadow'?"));
        for bad in ["", "#", "env", "transparent", "#12345", "ff880033"] {
            assert!(ground(bad).is_err(), "{bad}");
        }
    }
}
