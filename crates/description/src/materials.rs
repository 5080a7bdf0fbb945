//! Materials that a user lays over those of a model.

use super::Description;
use super::error::DescriptionError;
use super::name::file_name;
use overcoat_core::jobs::Jobs;
use overcoat_core::limits::Limits;
use overcoat_core::suggest::{nearest_name, suggestion};
use overcoat_load::{BuiltinMaterial, Context, LoadError, MaterialFile, Warning, inner_extension};
use overcoat_scene::Scene;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

/// Source of a material.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum MaterialSource {
    /// A material file.
    File(PathBuf),
    /// One that is built in, by name.
    Builtin(&'static str),
}

impl MaterialSource {
    /// A text that ends in `.toml` or `.mtlx` or has a slash is a path; everything else the name of a built-in material.
    ///
    /// # Errors
    /// One line with the names that there are.
    pub fn new(text: &str) -> Result<Self, String> {
        Self::of(OsStr::new(text))
    }

    /// [`MaterialSource::new`] of what need not be text.
    ///
    /// # Errors
    /// As there.
    pub fn of(text: &OsStr) -> Result<Self, String> {
        let is_file = matches!(inner_extension(Path::new(text)).as_deref(), Some("toml" | "mtlx"));
        if is_file || text.as_encoded_bytes().iter().any(|b| matches!(b, b'/' | b'\\')) {
            return Ok(Self::File(PathBuf::from(text)));
        }
        builtin(&text.to_string_lossy()).map(|material| Self::Builtin(material.name))
    }

    /// The path of a file.
    #[must_use]
    pub fn file(&self) -> Option<&Path> {
        match self {
            Self::File(path) => Some(path),
            Self::Builtin(_) => None,
        }
    }

    fn load(&self, limits: &Limits, jobs: &Jobs) -> Result<MaterialFile, DescriptionError> {
        let (path, loaded) = match self {
            Self::File(path) => (path.as_path(), MaterialFile::open(path, limits, jobs)),
            Self::Builtin(name) => {
                let builtin = builtin(name).map_err(DescriptionError::invalid)?;
                (Path::new(name), builtin.load(limits, jobs))
            }
        };
        loaded.map_err(|e| DescriptionError::from(e).at(path))
    }

    fn load_from(&self, context: &Context<'_>) -> Result<MaterialFile, DescriptionError> {
        let Self::File(path) = self else { return self.load(context.limits, context.jobs) };
        let name = path.to_string_lossy();
        let bytes = context.resolver.read(&name, context.limits.input_bytes);
        let bytes = bytes.map_err(|e| DescriptionError::from(LoadError::from(e)).at(path))?;
        MaterialFile::from_bytes(&bytes, context).map_err(|e| DescriptionError::from(e).at(path))
    }
}

/// A built-in material.
///
/// # Errors
/// One line with the names that there are.
pub fn builtin(name: &str) -> Result<&'static BuiltinMaterial, String> {
    BuiltinMaterial::named(name).ok_or_else(|| {
        let names: Vec<&str> = BuiltinMaterial::all().iter().map(|material| material.name).collect();
        let nearest = nearest_name(name, names.iter().copied());
        format!(
            "neither a file (.toml, .mtlx) nor a built-in material, which are {}{}",
            names.join(", "),
            suggestion(nearest)
        )
    })
}

/// A material, and which of the model's it takes the place of.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MaterialChoice {
    /// Name of the model's materials that it replaces; all if there is none.
    pub name: Option<String>,
    /// Its source.
    pub source: MaterialSource,
}

/// The materials of a description, loaded.
#[derive(Debug)]
pub struct Materials(Vec<(MaterialChoice, MaterialFile)>);

impl Materials {
    /// Reads every file that a description names.
    ///
    /// # Errors
    /// [`DescriptionError`] naming the file, the line and the key.
    pub fn load(description: &Description, limits: &Limits, jobs: &Jobs) -> Result<Self, DescriptionError> {
        let load = |choice: MaterialChoice| choice.source.load(limits, jobs).map(|file| (choice, file));
        description.material_choices().map(load).collect::<Result<_, _>>().map(Self)
    }

    /// [`Materials::load`], with files and their textures from the context's resolver instead of the file system. Textures
    /// have the names that stand in the material files.
    ///
    /// # Errors
    /// As there.
    pub fn load_from(description: &Description, context: &Context<'_>) -> Result<Self, DescriptionError> {
        let load = |choice: MaterialChoice| choice.source.load_from(context).map(|file| (choice, file));
        description.material_choices().map(load).collect::<Result<_, _>>().map(Self)
    }

    /// Warnings about the files.
    pub fn warnings(&self) -> impl Iterator<Item = Warning> {
        self.0.iter().flat_map(|(choice, file)| {
            let name = choice.source.file().map(file_name).unwrap_or_default();
            file.warnings().map(move |warning| warning.of(&name))
        })
    }

    /// Lays them over a scene, in order.
    ///
    /// # Errors
    /// [`DescriptionError`] if the model has no material of a name that is asked for.
    pub fn assign(&self, scene: &mut Scene, limits: &Limits) -> Result<(), DescriptionError> {
        self.0.iter().try_for_each(|(choice, file)| Ok(file.assign(scene, choice.name.as_deref(), limits)?))
    }
}
