//! Materials that are given as dicts: the text of a material file, with pictures of arrays.

use crate::errors;
use crate::kept::Texels;
use overcoat::jobs::Jobs;
use overcoat::load::{Context, DirectoryResolver, GivenPictures, MaterialFile};
use overcoat::{Limits, Scene};
use pyo3::prelude::*;
use std::sync::Arc;

/// A material with the keys of material files.
#[derive(Clone, Debug)]
pub(crate) struct InlineMaterial {
    /// Name of the material that it replaces; `None` for all.
    pub(crate) name: Option<String>,
    pub(crate) json: String,
    /// Pictures of arrays by the names that stand for them in the JSON.
    pub(crate) pictures: GivenPictures,
}

/// A material as Python gives it: name, JSON, and pictures by the names that stand for them.
pub(crate) type GivenMaterial = (Option<String>, String, Vec<(String, Py<Texels>)>);

impl PartialEq for InlineMaterial {
    /// Pictures by identity: `overcoat._kept` has one for each array.
    fn eq(&self, other: &Self) -> bool {
        let pictures = || self.pictures.iter().zip(&other.pictures);
        (&self.name, &self.json, self.pictures.len()) == (&other.name, &other.json, other.pictures.len())
            && pictures().all(|(own, theirs)| own.0 == theirs.0 && Arc::ptr_eq(own.1, theirs.1))
    }
}

impl InlineMaterial {
    pub(crate) fn new((name, json, pictures): GivenMaterial) -> Self {
        let image = |(name, texels): (String, Py<Texels>)| (name, Arc::clone(&texels.get().image));
        Self { name, json, pictures: pictures.into_iter().map(image).collect() }
    }

    /// Lays it over a scene. Its files are read from the current folder and the folders in it.
    pub(crate) fn assign(&self, scene: &mut Scene, limits: &Limits, jobs: &Jobs) -> PyResult<()> {
        let resolver = DirectoryResolver::new(".");
        let context = Context { resolver: &resolver, limits, jobs };
        let file = MaterialFile::from_text(&self.json, &self.pictures, &context).map_err(|error| {
            let key = error.key.as_deref().map_or_else(String::new, |key| format!("{key}: "));
            errors::material(&error, &format!("material: {key}{}", error.reason))
        })?;
        file.assign(scene, self.name.as_deref(), limits).map_err(|error| errors::assign(&error))
    }
}
