//! Files, and parts of the model file.

use super::Kind;
use crate::environment::EnvironmentChoice;
use crate::materials::MaterialSource;
use crate::value::Value;
use overcoat_load::{BuiltinMaterial, NamedEnvironment};
use serde_json::{Value as Json, json};
use std::ffi::OsStr;
use std::path::PathBuf;

fn write_path(path: &std::path::Path) -> Result<Json, String> {
    path.to_str().map(|text| json!(text)).ok_or_else(|| "the path is no text".to_owned())
}

/// Text, with words for what it is.
pub(crate) struct Text(pub(crate) &'static str);

impl Kind for Text {
    type Value = String;

    fn parse(&self, text: &str) -> Result<String, String> {
        Ok(text.to_owned())
    }

    fn read(&self, value: &Value<'_>) -> Result<String, String> {
        value.text(self.0)
    }

    fn write(&self, value: &String) -> Result<Json, String> {
        Ok(json!(value))
    }

    fn schema(&self) -> Json {
        json!({"type": "string"})
    }
}

/// The path of a file, with words for what it is.
pub(crate) struct Path(pub(crate) &'static str);

impl Kind for Path {
    type Value = PathBuf;

    fn parse(&self, text: &str) -> Result<PathBuf, String> {
        Ok(PathBuf::from(text))
    }

    fn parse_os(&self, text: &OsStr) -> Result<PathBuf, String> {
        Ok(PathBuf::from(text))
    }

    fn read(&self, value: &Value<'_>) -> Result<PathBuf, String> {
        value.text(self.0).map(PathBuf::from)
    }

    fn write(&self, value: &PathBuf) -> Result<Json, String> {
        write_path(value)
    }

    fn schema(&self) -> Json {
        json!({"type": "string"})
    }
}

/// The environment: one by its name, or the path of a picture.
pub(crate) struct EnvironmentSource;

impl Kind for EnvironmentSource {
    type Value = EnvironmentChoice;

    fn parse(&self, text: &str) -> Result<EnvironmentChoice, String> {
        Ok(EnvironmentChoice::new(text))
    }

    fn parse_os(&self, text: &OsStr) -> Result<EnvironmentChoice, String> {
        Ok(EnvironmentChoice::new(text))
    }

    fn read(&self, value: &Value<'_>) -> Result<EnvironmentChoice, String> {
        let expected = NamedEnvironment::sentence(["the path of a picture"]);
        value.text(&expected).map(EnvironmentChoice::new)
    }

    fn write(&self, value: &EnvironmentChoice) -> Result<Json, String> {
        match value {
            EnvironmentChoice::Named(named) => Ok(json!(named.name())),
            EnvironmentChoice::File(file) => write_path(file),
        }
    }

    fn schema(&self) -> Json {
        json!({"type": "string", "examples": self.names()})
    }

    fn names(&self) -> Vec<&'static str> {
        NamedEnvironment::names().collect()
    }
}

/// A material: the path of a material file, or the name of a built-in one.
pub(crate) struct Material;

impl Kind for Material {
    type Value = MaterialSource;

    fn parse(&self, text: &str) -> Result<MaterialSource, String> {
        MaterialSource::new(text)
    }

    fn parse_os(&self, text: &OsStr) -> Result<MaterialSource, String> {
        MaterialSource::of(text)
    }

    fn read(&self, value: &Value<'_>) -> Result<MaterialSource, String> {
        value.parsed("a material", MaterialSource::new)
    }

    fn write(&self, value: &MaterialSource) -> Result<Json, String> {
        match value {
            MaterialSource::File(file) => write_path(file),
            MaterialSource::Builtin(name) => Ok(json!(name)),
        }
    }

    fn schema(&self) -> Json {
        json!({"anyOf": [{"enum": self.names()}, {"type": "string", "pattern": r"[/\\]|\.toml$"}]})
    }

    fn names(&self) -> Vec<&'static str> {
        BuiltinMaterial::all().iter().map(|material| material.name).collect()
    }
}

/// The name of a part of the model file, or its number from 0; with words for what it is.
pub(crate) struct ModelPart(pub(crate) &'static str);

impl Kind for ModelPart {
    type Value = String;

    fn parse(&self, text: &str) -> Result<String, String> {
        Ok(text.to_owned())
    }

    fn read(&self, value: &Value<'_>) -> Result<String, String> {
        let number = value.node.whole().and_then(|v| u32::try_from(v).ok()).map(|v| v.to_string());
        let name = || value.node.text().map(|text| text.into_owned());
        let expected = || value.expected(format_args!("the name of {} or its number from 0", self.0));
        number.or_else(name).ok_or_else(expected)
    }

    fn write(&self, value: &String) -> Result<Json, String> {
        Ok(json!(value))
    }

    fn schema(&self) -> Json {
        json!({"anyOf": [{"type": "string"}, {"type": "integer", "minimum": 0}]})
    }
}
