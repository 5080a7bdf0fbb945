//! The keys of scene files that requests may set, and how their texts are read.

use super::error::{Kind, Problem};
use serde_json::Value;

/// How the text of a key becomes its value.
#[derive(Clone, Copy)]
pub enum Form {
    /// A number.
    Number,
    /// `true` or `false`.
    Switch,
    /// As it is.
    Text,
    /// A number where it is one.
    Either,
    /// Numbers with commas.
    Position,
    /// As a scene file has it.
    Json,
}

/// Keys of scene files that requests may set. Those that name files are none of them.
pub const KEYS: &[(&str, Form)] = &[
    ("animation", Form::Text),
    ("anisotropy", Form::Number),
    ("area_lights", Form::Text),
    ("background", Form::Text),
    ("env_intensity", Form::Number),
    ("env_rotation_deg", Form::Number),
    ("exposure", Form::Either),
    ("ground", Form::Text),
    ("ground_reflection", Form::Number),
    ("light", Form::Json),
    ("lights", Form::Switch),
    ("line_width", Form::Number),
    ("loop", Form::Switch),
    ("map_size", Form::Number),
    ("maps", Form::Number),
    ("merge_angle_deg", Form::Number),
    ("point_size", Form::Number),
    ("quality", Form::Text),
    ("rays", Form::Number),
    ("samples", Form::Number),
    ("shade_everywhere", Form::Switch),
    ("shading", Form::Text),
    ("shading_rate", Form::Number),
    ("specular_antialiasing", Form::Switch),
    ("time", Form::Number),
    ("tone_mapping", Form::Text),
    ("up", Form::Text),
];

/// Keys of the camera, by their names in requests.
pub const CAMERA: &[(&str, &str, Form)] = &[
    ("view", "view", Form::Text),
    ("camera", "camera", Form::Text),
    ("eye", "eye", Form::Position),
    ("target", "target", Form::Position),
    ("camera_up", "up", Form::Position),
    ("fov_y_deg", "fov_y_deg", Form::Number),
    ("near", "near", Form::Number),
    ("ortho_height", "ortho_height", Form::Number),
];

fn wrong(message: String) -> Problem {
    Problem::new(Kind::Options, message)
}

/// A size: one number for a square, or two with x or a colon.
///
/// # Errors
/// [`Kind::Options`].
pub fn size(text: &str) -> Result<[u64; 2], Problem> {
    let (width, height) = text.split_once(['x', ':']).unwrap_or((text, text));
    let sides = width.parse().ok().zip(height.parse().ok());
    let (width, height) =
        sides.ok_or_else(|| wrong(format!("size: expected N or WIDTHxHEIGHT in pixels, got '{text}'")))?;
    Ok([width, height])
}

/// The value of a key.
///
/// # Errors
/// [`Kind::Options`] with what the key takes.
pub fn value(key: &str, text: &str, form: Form) -> Result<Value, Problem> {
    let number = |text: &str| {
        let whole = text.parse::<u64>().ok().map(Value::from);
        whole.or_else(|| text.parse::<f64>().ok().and_then(serde_json::Number::from_f64).map(Value::from))
    };
    let expected = |what: &str| wrong(format!("{key}: expected {what}, got '{text}'"));
    match form {
        Form::Text => Ok(text.into()),
        Form::Number => number(text).ok_or_else(|| expected("a number")),
        Form::Either => Ok(number(text).unwrap_or_else(|| text.into())),
        Form::Switch => match text {
            "true" | "1" => Ok(true.into()),
            "false" | "0" => Ok(false.into()),
            _ => Err(expected("true or false")),
        },
        Form::Position => {
            let numbers: Option<Vec<Value>> = text.split(',').map(|text| number(text.trim())).collect();
            numbers
                .filter(|all| all.len() == 3)
                .map(Value::from)
                .ok_or_else(|| expected("three numbers with commas"))
        }
        Form::Json => serde_json::from_str(text).map_err(|e| expected(&format!("JSON ({e})"))),
    }
}
