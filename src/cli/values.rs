//! The values of options: how each is written and what it means.

pub use super::limit_values::{LIMIT_NAMES, limit, limits, set_limit};
use super::materials::{MaterialChoice, MaterialSource};
use super::names::around_last_equals;
use crate::color::{ToneCurve, hex_color};
use crate::frame::Aov;
use crate::load::{nearest_name, suggestion};
use crate::math::lanes::SimdLevel;
use crate::output::OutputFormat;
use crate::render::{AreaLightMethod, ShadingModel};
use crate::scene::Axis;
use clap::builder::{OsStringValueParser, TypedValueParser};
use std::ffi::OsStr;
use std::fmt::Display;
use std::str::FromStr;

/// What `--background` and a scene file's `background` say.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BackgroundChoice {
    /// Alpha 0 where no surface is.
    Transparent,
    /// The environment.
    Environment,
    /// An sRGB colour, put behind the picture after the tone curve.
    Color([u8; 3]),
}

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

/// `transparent`, `env`, a colour name, `#rgb` or `#rrggbb`, both without `#` as well.
pub fn background(text: &str) -> Result<BackgroundChoice, String> {
    let lower = text.to_ascii_lowercase();
    match lower.as_str() {
        "transparent" => return Ok(BackgroundChoice::Transparent),
        "env" | "environment" => return Ok(BackgroundChoice::Environment),
        _ => {}
    }
    if let Some((_, color)) = COLORS.iter().find(|(name, _)| *name == lower) {
        return Ok(BackgroundChoice::Color(*color));
    }
    match hex_color(&lower) {
        Some((color, None)) => Ok(BackgroundChoice::Color(color)),
        _ => {
            let names = || ["transparent", "env"].into_iter().chain(COLORS.iter().map(|(name, _)| *name));
            Err(format!(
                "neither #rrggbb nor one of {}{}",
                names().collect::<Vec<_>>().join(", "),
                suggestion(nearest_name(&lower, names()))
            ))
        }
    }
}

/// `expected one of` the names, and the one that may have been meant.
fn one_of<'a>(text: &str, names: impl Iterator<Item = &'a str> + Clone) -> String {
    let hint = suggestion(nearest_name(text, names.clone()));
    format!("expected one of {}{hint}", names.collect::<Vec<_>>().join(", "))
}

/// What `--exposure` and a scene file's `exposure` say.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ExposureChoice {
    /// Stops, -64 to 64.
    Stops(f32),
    /// Metered.
    Auto,
}

/// Stops, or `auto`.
pub fn exposure(text: &str) -> Result<ExposureChoice, String> {
    match text {
        "auto" => Ok(ExposureChoice::Auto),
        stops => {
            let stops = within(-64.0, 64.0)(stops).map_err(|e| format!("{e} stops, or auto"))?;
            Ok(ExposureChoice::Stops(stops))
        }
    }
}

/// `WxH` or `N` for a square. Zero and sizes beyond the limits are refused later, with the file's name.
pub fn size(text: &str) -> Result<[u64; 2], String> {
    let number = |t: &str| t.parse::<u64>().map_err(|_| "expected WxH or N, in pixels".to_owned());
    match text.split_once(['x', 'X']) {
        Some((w, h)) => Ok([number(w)?, number(h)?]),
        None => number(text).map(|n| [n, n]),
    }
}

/// `x,y,z`.
pub fn vector(text: &str) -> Result<[f32; 3], String> {
    three(text, |v: &f32| v.is_finite())
}

/// A place, `x,y,z`: of double precision, for models far from zero.
pub fn position(text: &str) -> Result<[f64; 3], String> {
    three(text, |v: &f64| v.abs() <= f64::from(f32::MAX))
}

fn three<T: FromStr>(text: &str, passes: impl Fn(&T) -> bool) -> Result<[T; 3], String> {
    let parts: Vec<T> = text
        .split(',')
        .map(|t| t.trim().parse::<T>().ok().filter(&passes))
        .collect::<Option<_>>()
        .unwrap_or_default();
    <[T; 3]>::try_from(parts).map_err(|_| "expected three numbers x,y,z".to_owned())
}

/// `x,y,z`, of any length but zero.
pub fn direction(text: &str) -> Result<[f32; 3], String> {
    let given = vector(text).ok().filter(|v| *v != [0.0; 3]);
    given.ok_or_else(|| "expected a direction x,y,z other than 0,0,0".to_owned())
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

/// A number that is finite.
pub fn finite(text: &str) -> Result<f32, String> {
    text.parse::<f32>().ok().filter(|v| v.is_finite()).ok_or_else(|| "expected a number".to_owned())
}

/// A finite number that is not negative.
pub fn not_negative(text: &str) -> Result<f32, String> {
    finite(text).ok().filter(|&v| v >= 0.0).ok_or_else(|| "expected a number, at least 0".to_owned())
}

/// Seconds: a finite number that is not negative.
pub fn seconds(text: &str) -> Result<f64, String> {
    let number = text.parse::<f64>().ok().filter(|v| v.is_finite() && *v >= 0.0);
    number.ok_or_else(|| "expected seconds, at least 0".to_owned())
}

/// A number between two others, which are allowed as well.
pub fn within<T>(low: T, high: T) -> impl Fn(&str) -> Result<T, String> + Clone
where
    T: FromStr + PartialOrd + Display + Copy,
{
    move |text| {
        let number = text.parse::<T>().ok().filter(|v| (low..=high).contains(v));
        number.ok_or_else(|| format!("expected {low} to {high}"))
    }
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

/// Side of a tile.
pub fn tile(text: &str) -> Result<u32, String> {
    match text {
        "16" => Ok(16),
        "32" => Ok(32),
        "64" => Ok(64),
        _ => Err("expected 16, 32 or 64".to_owned()),
    }
}

/// An instruction set that this machine has; `auto` is the fastest of them.
pub fn simd(text: &str) -> Result<SimdLevel, String> {
    if text == "auto" {
        return Ok(SimdLevel::best());
    }
    let level = text.parse::<SimdLevel>().map_err(|e| e.to_string())?;
    if level.is_available() {
        return Ok(level);
    }
    let names: Vec<&str> = SimdLevel::available().map(SimdLevel::name).collect();
    Err(format!("this machine lacks {level}; it has {}", names.join(", ")))
}

/// A shading model by name.
pub fn shading(text: &str) -> Result<ShadingModel, String> {
    ShadingModel::from_name(text).ok_or_else(|| {
        let names: Vec<&str> = ShadingModel::ALL.into_iter().map(ShadingModel::name).collect();
        let nearest = nearest_name(text, names.iter().copied());
        format!("expected one of {}{}", names.join(", "), suggestion(nearest))
    })
}

/// `FILE`, `NAME=FILE` or the same with the name of a built-in material. A file's name ends in `.toml` or has a slash.
pub fn material(text: impl AsRef<OsStr>) -> Result<MaterialChoice, String> {
    let text = text.as_ref();
    // The name is that of a model's material, which may have any character; that of the file is up to the user.
    let (name, source) = match around_last_equals(text) {
        Some((name, source)) => (Some(name.to_string_lossy().into_owned()), source),
        None => (None, text.to_owned()),
    };
    if name.as_deref() == Some("") {
        return Err("expected NAME=FILE".to_owned());
    }
    MaterialSource::of(&source).map(|source| MaterialChoice { name, source })
}

/// [`material`] of arguments that need not be text.
pub fn material_parser() -> impl TypedValueParser<Value = MaterialChoice> {
    OsStringValueParser::new().try_map(material)
}

/// A tone curve by name; `linear` is another word for `none`.
pub fn tone_curve(text: &str) -> Result<ToneCurve, String> {
    let name = if text == "linear" { "none" } else { text };
    ToneCurve::from_name(name)
        .ok_or_else(|| one_of(text, ToneCurve::ALL.into_iter().map(ToneCurve::name).chain(["linear"])))
}

/// A format of picture files by one of its extensions.
pub fn output_format(text: &str) -> Result<OutputFormat, String> {
    OutputFormat::from_extension(text)
        .ok_or_else(|| one_of(text, OutputFormat::ALL.into_iter().map(OutputFormat::extension)))
}

/// How area lights are integrated, by name.
pub fn area_lights(text: &str) -> Result<AreaLightMethod, String> {
    AreaLightMethod::from_name(text).ok_or_else(|| one_of(text, ["ltc", "facets"].into_iter()))
}

/// A plane of the G-buffer by name.
pub fn aov(text: &str) -> Result<Aov, String> {
    Aov::from_name(text).ok_or_else(|| one_of(text, Aov::ALL.into_iter().map(Aov::name)))
}

/// Where the camera of the auto-framing stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ViewDirection {
    /// From the model towards the camera.
    pub direction: [f32; 3],
    /// Which way is up.
    pub up: [f32; 3],
}

/// Views by name. glTF models face +Z; left and right are those of someone who looks at the front.
const VIEWS: [(&str, ViewDirection); 7] = [
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
    fn a_misspelt_model_is_recognised() {
        assert_eq!(shading("urp17"), Ok(ShadingModel::Urp17));
        let message = shading("stack-lit").unwrap_err();
        assert!(message.contains("openpbr") && message.ends_with("did you mean 'stacklit'?"), "{message}");
        assert!(!shading("phong").unwrap_err().contains("did you mean"));
    }

    #[test]
    fn every_list_of_names_knows_which_was_meant() {
        for (message, meant) in [
            (view("fornt").unwrap_err(), "front"),
            (tone_curve("netral").unwrap_err(), "neutral"),
            (aov("nromal").unwrap_err(), "normal"),
            (background("whitee").unwrap_err(), "white"),
            (background("transparant").unwrap_err(), "transparent"),
            (area_lights("facet").unwrap_err(), "facets"),
            (limit("triangle=1").unwrap_err(), "triangles"),
            (shading("filamant").unwrap_err(), "filament"),
            (material("velvit").unwrap_err(), "velvet"),
        ] {
            assert!(message.ends_with(&format!("did you mean '{meant}'?")), "{message}");
        }
    }

    #[test]
    fn materials() {
        let file = |path: &str| MaterialSource::File(path.into());
        assert_eq!(material("a/b"), Ok(MaterialChoice { name: None, source: file("a/b") }));
        let named = MaterialChoice { name: Some("body=1".to_owned()), source: file("x.TOML") };
        assert_eq!(material("body=1=x.TOML"), Ok(named));
        let red = MaterialChoice { name: None, source: MaterialSource::Builtin("candy-red") };
        assert_eq!(material("candy-red"), Ok(red));
        let message = material("candy-rod").unwrap_err();
        assert!(message.contains("velvet") && message.ends_with("did you mean 'candy-red'?"), "{message}");
        for bad in ["", "=", "=a.toml", "body="] {
            assert!(material(bad).is_err(), "{bad}");
        }
    }

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
    fn vectors() {
        assert_eq!(vector("-1, 2.5,3e2"), Ok([-1.0, 2.5, 300.0]));
        for bad in ["", "1,2", "1,2,3,4", "nan,0,0", "inf,0,0", "a,b,c"] {
            assert!(vector(bad).is_err(), "{bad}");
        }
        assert_eq!(direction("0,-1,0"), Ok([0.0, -1.0, 0.0]));
        assert!(direction("0,-0,0").is_err());
    }

    #[test]
    fn exposures() {
        assert_eq!(exposure("auto"), Ok(ExposureChoice::Auto));
        assert_eq!(exposure("-1.5"), Ok(ExposureChoice::Stops(-1.5)));
        assert_eq!(exposure("65"), Err("expected -64 to 64 stops, or auto".to_owned()));
        assert!(exposure("automatic").is_err());
    }

    #[test]
    fn axes() {
        assert_eq!((axis("+z"), axis("X")), (Ok(Axis::PositiveZ), Ok(Axis::PositiveX)));
        assert!(axis("0,0,1").unwrap_err().contains("--camera-up"));
        assert!(!axis("up").unwrap_err().contains("--camera-up"));
    }

    #[test]
    fn numbers_within_bounds() {
        assert_eq!((within(0.1, 179.0)("179"), within(1_u32, 16)("1")), (Ok(179.0), Ok(1)));
        for bad in ["0", "179.5", "nan", "inf", "", "x"] {
            assert_eq!(within(0.1, 179.0)(bad), Err("expected 0.1 to 179".to_owned()), "{bad}");
        }
        assert_eq!(within(0_u16, 1024)("-1"), Err("expected 0 to 1024".to_owned()));
    }

    #[test]
    fn views_are_usable_cameras() {
        for name in VIEWS.map(|(name, _)| name).into_iter().chain(["0,1,0", "1,2,3"]) {
            let view = view(name).unwrap();
            let camera = crate::scene::Camera {
                eye: view.direction,
                target: [0.0; 3],
                up: view.up,
                projection: crate::scene::Projection::Perspective { fov_y: 1.0 },
                near: 0.1,
            };
            assert!(camera.axes().is_ok(), "{name}");
        }
        assert!(view("0,0,0").is_err());
        assert!(view("sideways").is_err());
    }
}
