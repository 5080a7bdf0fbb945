//! The values of options: how each is written and what it means.

use super::names::around_last_equals;
use clap::builder::{OsStringValueParser, PossibleValue, TypedValueParser};
use clap::{Arg, Command};
use overcoat_core::frame::Aov;
use overcoat_core::math::lanes::SimdLevel;
use overcoat_description::{MaterialChoice, MaterialSource, one_of};
pub use overcoat_description::{background, position, seconds, size};
use overcoat_image::output::OutputFormat;
use overcoat_load::BuiltinMaterial;
use overcoat_scene::ShadingModel;
pub use overcoat_worker::limit_values::{LIMIT_NAMES, bytes, limit, limits, memory, set_limit};
use overcoat_worker::picture_format::PictureFormat;
use std::ffi::OsStr;
use std::fmt::Display;
use std::path::PathBuf;
use std::str::FromStr;

/// A shading model by name.
pub fn shading(text: &str) -> Result<ShadingModel, String> {
    ShadingModel::from_name(text)
        .ok_or_else(|| one_of(text, ShadingModel::ALL.iter().map(|model| model.name())))
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

/// [`material`] of arguments that need not be text; a shell completes the names of the built-in ones.
#[derive(Clone)]
pub struct MaterialParser;

impl TypedValueParser for MaterialParser {
    type Value = MaterialChoice;

    fn parse_ref(
        &self,
        command: &Command,
        arg: Option<&Arg>,
        value: &OsStr,
    ) -> Result<MaterialChoice, clap::Error> {
        OsStringValueParser::new().try_map(material).parse_ref(command, arg, value)
    }

    fn possible_values(&self) -> Option<Box<dyn Iterator<Item = PossibleValue> + '_>> {
        let names = BuiltinMaterial::all().iter().map(|material| PossibleValue::new(material.name));
        Some(Box::new(names))
    }
}

/// A file by its path or its `file:` URI.
pub fn file_or_uri() -> impl TypedValueParser<Value = PathBuf> {
    OsStringValueParser::new().try_map(|text| super::file_uri::file_or_uri(&text))
}

/// A format of picture files by one of its extensions.
pub fn output_format(text: &str) -> Result<OutputFormat, String> {
    OutputFormat::from_extension(text)
        .ok_or_else(|| one_of(text, OutputFormat::ALL.iter().copied().map(OutputFormat::extension)))
}

/// A format of picture files by one of its extensions, or one that a terminal shows by its name.
pub fn picture_format(text: &str) -> Result<PictureFormat, String> {
    let known = PictureFormat::from_name(text);
    known.ok_or_else(|| one_of(text, PictureFormat::all().map(PictureFormat::name)))
}

/// A plane of the G-buffer by name.
pub fn aov(text: &str) -> Result<Aov, String> {
    Aov::from_name(text).ok_or_else(|| one_of(text, Aov::ALL.iter().copied().map(Aov::name)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_list_of_names_knows_which_was_meant() {
        for (message, meant) in [
            (aov("nromal").unwrap_err(), "normal"),
            (picture_format("sixl").unwrap_err(), "sixel"),
            (background("whitee").unwrap_err(), "white"),
            (background("transparant").unwrap_err(), "transparent"),
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
}
