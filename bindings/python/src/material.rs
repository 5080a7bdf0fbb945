//! Materials that are given as dicts: the text of a material file, written here.

use crate::errors::{self, Kind};
use overcoat::jobs::Jobs;
use overcoat::load::{Context, DirectoryResolver, MaterialFile};
use overcoat::{Limits, Scene};
use pyo3::prelude::*;

/// A material with the keys of material files.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct InlineMaterial {
    /// Name of the material that it replaces; `None` for all.
    pub(crate) name: Option<String>,
    pub(crate) json: String,
}

impl InlineMaterial {
    /// Lays it over a scene. Its textures are read from the current folder and the folders in it.
    pub(crate) fn assign(&self, scene: &mut Scene, limits: &Limits, jobs: &Jobs) -> PyResult<()> {
        let wrong = |message: String| Kind::Option.error(format_args!("material: {message}"));
        let table: toml::Table =
            serde_json::from_str(&self.json).map_err(|error| wrong(error.to_string()))?;
        let text = toml::to_string(&table).map_err(|error| wrong(error.to_string()))?;
        let resolver = DirectoryResolver::new(".");
        let context = Context { resolver: &resolver, limits, jobs };
        let file = MaterialFile::from_bytes(text.as_bytes(), &context).map_err(|error| {
            // Lines are those of a text that nobody has seen.
            let key = error.key.as_deref().map_or_else(String::new, |key| format!("{key}: "));
            errors::material(&error, &format!("material: {key}{}", error.reason))
        })?;
        file.assign(scene, self.name.as_deref(), limits).map_err(|error| errors::assign(&error))
    }
}
