//! Values that are written as text, in scene files and as options: how each is spelt and what it means.

use super::camera::ViewDirection;
use super::options::BackgroundChoice;
use overcoat_core::color::{ToneCurve, hex_color};
use overcoat_core::suggest::{nearest_name, suggestion};
use overcoat_render::{Ground, Quality};
use overcoat_scene::Axis;
use overcoat_scene::{AreaLightMethod, ShadingModel};
use std::str::FromStr;

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

/// What a background may be called.
pub(super) fn background_names() -> impl Iterator<Item = &'static str> + Clone {
    ["transparent", "env"].into_iter().chain(COLORS.iter().map(|(name, _)| *name))
}

/// `transparent`, `env`, a colour name, `#rgb` or `#rrggbb`, both without `#` as well.
pub fn background(text: &str) -> Result<BackgroundChoice, String> {
    let lower = text.to_ascii_lowercase();
    match lower.as_str() {
        "transparent" => return Ok(BackgroundChoice::Transparent),
        "env" | "environment" => return Ok(BackgroundChoice::Environment),
        _ => {}
    }
    color(&lower).map(BackgroundChoice::Color).ok_or_else(|| no_color(&lower, background_names()))
}

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

/// What could have been written, and what may have been meant.
fn no_color(text: &str, names: impl Iterator<Item = &'static str> + Clone) -> String {
    format!(
        "neither #rrggbb nor one of {}{}",
        names.clone().collect::<Vec<_>>().join(", "),
        suggestion(nearest_name(text, names))
    )
}

/// What a floor may be called.
pub(super) fn ground_names() -> impl Iterator<Item = &'static str> + Clone {
    ["none", "shadow"].into_iter().chain(COLORS.iter().map(|(name, _)| *name))
}

/// A floor as it is written.
pub fn ground_name(ground: Ground) -> String {
    match ground {
        Ground::None => "none".to_owned(),
        Ground::Shadow => "shadow".to_owned(),
        Ground::Color([r, g, b]) => format!("#{r:02x}{g:02x}{b:02x}"),
    }
}

/// `none`, `shadow`, a colour name, `#rgb` or `#rrggbb`, both without `#` as well.
///
/// # Errors
/// What was expected.
pub fn ground(text: &str) -> Result<Ground, String> {
    let lower = text.to_ascii_lowercase();
    match lower.as_str() {
        "none" => return Ok(Ground::None),
        "shadow" => return Ok(Ground::Shadow),
        _ => {}
    }
    color(&lower).map(Ground::Color).ok_or_else(|| no_color(&lower, ground_names()))
}

/// `expected one of` the names, and the one that may have been meant.
pub fn one_of<'a>(text: &str, names: impl Iterator<Item = &'a str> + Clone) -> String {
    let hint = suggestion(nearest_name(text, names.clone()));
    format!("expected one of {}{hint}", names.collect::<Vec<_>>().join(", "))
}

/// `x,y,z`.
pub fn vector(text: &str) -> Result<[f32; 3], String> {
    three(text, |v: &f32| v.is_finite())
}

/// Three values with commas between them, each of which passes.
pub fn three<T: FromStr>(text: &str, passes: impl Fn(&T) -> bool) -> Result<[T; 3], String> {
    let parts: Vec<T> = text
        .split(',')
        .map(|t| t.trim().parse::<T>().ok().filter(&passes))
        .collect::<Option<_>>()
        .unwrap_or_default();
    <[T; 3]>::try_from(parts).map_err(|_| "expected three numbers x,y,z".to_owned())
}

/// An axis of the model file: `+z`, `-x`, `y`.
pub fn axis(text: &str) -> Result<Axis, String> {
    Axis::from_name(text).ok_or_else(|| match vector(text) {
        Ok(_) => "expected an axis of the model, +x, -x, +y, -y, +z or -z; --camera-up (in scene files camera.up) takes \
                  a direction for the camera"
            .to_owned(),
        Err(_) => "expected +x, -x, +y, -y, +z or -z".to_owned(),
    })
}

/// Samples a pixel.
pub fn samples(text: &str) -> Result<u32, String> {
    match text {
        "1" => Ok(1),
        "4" => Ok(4),
        "8" => Ok(8),
        "16" => Ok(16),
        _ => Err("expected 1, 4, 8 or 16".to_owned()),
    }
}

/// Shadings a pixel.
pub fn shading_rate(text: &str) -> Result<u32, String> {
    match text {
        "9" => Ok(9),
        _ => samples(text).map_err(|_| "expected 1, 4, 8, 9 or 16".to_owned()),
    }
}

/// A shading model by name.
pub fn shading(text: &str) -> Result<ShadingModel, String> {
    ShadingModel::from_name(text).ok_or_else(|| {
        let names: Vec<&str> = ShadingModel::ALL.iter().copied().map(ShadingModel::name).collect();
        let nearest = nearest_name(text, names.iter().copied());
        format!("expected one of {}{}", names.join(", "), suggestion(nearest))
    })
}

/// What a tone curve may be called.
pub(super) fn tone_curve_names() -> impl Iterator<Item = &'static str> + Clone {
    ToneCurve::ALL.iter().copied().map(ToneCurve::name).chain(["linear"])
}

/// A tone curve by name; `linear` is another word for `none`.
pub fn tone_curve(text: &str) -> Result<ToneCurve, String> {
    let name = if text == "linear" { "none" } else { text };
    ToneCurve::from_name(name).ok_or_else(|| one_of(text, tone_curve_names()))
}

/// How area lights are integrated, by name.
pub fn area_lights(text: &str) -> Result<AreaLightMethod, String> {
    AreaLightMethod::from_name(text).ok_or_else(|| one_of(text, ["ltc", "facets"].into_iter()))
}

/// What a picture is worth.
///
/// # Errors
/// What was expected.
pub fn quality(text: &str) -> Result<Quality, String> {
    Quality::from_name(text).ok_or_else(|| one_of(text, Quality::ALL.iter().map(|quality| quality.name())))
}

/// Views by name. glTF models face +Z; left and right are those of someone who looks at the front.
pub(super) const VIEWS: [(&str, ViewDirection); 7] = [
    ("three-quarter", ViewDirection { direction: [0.62, 0.42, 1.0], up: [0.0, 1.0, 0.0] }),
    ("front", ViewDirection { direction: [0.0, 0.0, 1.0], up: [0.0, 1.0, 0.0] }),
    ("back", ViewDirection { direction: [0.0, 0.0, -1.0], up: [0.0, 1.0, 0.0] }),
    ("left", ViewDirection { direction: [-1.0, 0.0, 0.0], up: [0.0, 1.0, 0.0] }),
    ("right", ViewDirection { direction: [1.0, 0.0, 0.0], up: [0.0, 1.0, 0.0] }),
    ("top", ViewDirection { direction: [0.0, 1.0, 0.0], up: [0.0, 0.0, -1.0] }),
    ("bottom", ViewDirection { direction: [0.0, -1.0, 0.0], up: [0.0, 0.0, 1.0] }),
];

/// A view by name, or a direction `x,y,z` from the model towards the camera.
pub fn view(text: &str) -> Result<ViewDirection, String> {
    if let Some((_, view)) = VIEWS.iter().find(|(name, _)| *name == text) {
        return Ok(*view);
    }
    match vector(text) {
        Ok(direction) if direction != [0.0; 3] => {
            // Looking straight down or up, the vertical axis cannot be up.
            let up =
                if direction[0] == 0.0 && direction[2] == 0.0 { [0.0, 0.0, -1.0] } else { [0.0, 1.0, 0.0] };
            Ok(ViewDirection { direction, up })
        }
        _ => {
            let names = VIEWS.iter().map(|(name, _)| *name);
            let hint = suggestion(nearest_name(text, names.clone()));
            let names = names.collect::<Vec<_>>().join(", ");
            Err(format!("expected a direction x,y,z or one of {names}{hint}"))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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

    #[test]
    fn a_misspelt_model_is_recognised() {
        assert_eq!(shading("urp17"), Ok(ShadingModel::Urp17));
        let message = shading("stack-lit").unwrap_err();
        assert!(message.contains("openpbr") && message.ends_with("did you mean 'stacklit'?"), "{message}");
        assert!(!shading("phong").unwrap_err().contains("did you mean"));
    }

    #[test]
    fn axes() {
        assert_eq!((axis("+z"), axis("X")), (Ok(Axis::PositiveZ), Ok(Axis::PositiveX)));
        assert!(axis("0,0,1").unwrap_err().contains("--camera-up"));
        assert!(!axis("up").unwrap_err().contains("--camera-up"));
    }

    #[test]
    fn views_are_usable_cameras() {
        for name in VIEWS.map(|(name, _)| name).into_iter().chain(["0,1,0", "1,2,3"]) {
            let view = view(name).unwrap();
            let camera = overcoat_scene::Camera::new(
                view.direction,
                [0.0; 3],
                view.up,
                overcoat_scene::Projection::Perspective { fov_y: 1.0 },
                0.1,
            );
            assert!(camera.axes().is_ok(), "{name}");
        }
        assert!(view("0,0,0").is_err());
        assert!(view("sideways").is_err());
    }
}
