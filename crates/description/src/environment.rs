//! Light from afar.

use super::Description;
use super::error::DescriptionError;
use super::input::{is_standard_input, read_standard_input};
use super::name::file_name;
use overcoat_core::jobs::Jobs;
use overcoat_core::limits::Limits;
use overcoat_load::{
    Context, LoadError, NamedEnvironment, NoResolver, Warning, load_environment, load_environment_file,
};
use overcoat_scene::{Environment, EnvironmentSource};
use std::ffi::OsStr;
use std::path::PathBuf;
use std::sync::Arc;

/// Source of the light from afar: value of a scene file's `env` and of the option `--env`.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum EnvironmentChoice {
    /// One that belongs to the program.
    Named(NamedEnvironment),
    /// An equirectangular picture.
    File(PathBuf),
}

/// Environment that holds unless another is named.
const DEFAULT: EnvironmentChoice = EnvironmentChoice::Named(NamedEnvironment::Studio);

impl EnvironmentChoice {
    /// A name of [`NamedEnvironment`] or a path.
    #[must_use]
    pub fn new(text: impl AsRef<OsStr>) -> Self {
        let text = text.as_ref();
        match text.to_str().and_then(NamedEnvironment::named) {
            Some(named) => Self::Named(named),
            None => Self::File(PathBuf::from(text)),
        }
    }
}

impl Description {
    /// The environment, read from its file if it has one, and what is doubtful about it. Scenes that share it share its
    /// filtered form.
    ///
    /// # Errors
    /// [`DescriptionError`] naming the environment's file and the reason.
    pub fn environment(
        &self,
        limits: &Limits,
        jobs: &Jobs,
    ) -> Result<(Environment, Vec<Warning>), DescriptionError> {
        let mut warnings = Vec::new();
        let source = match self.env.as_ref().unwrap_or(&DEFAULT) {
            EnvironmentChoice::Named(named) => named.source(),
            EnvironmentChoice::File(path) => {
                let about = |error: DescriptionError| error.at(path);
                let loaded = if is_standard_input(path) {
                    let bytes = read_standard_input(limits).map_err(about)?;
                    load_environment(&bytes, &Context { resolver: &NoResolver, limits, jobs })
                } else {
                    load_environment_file(path, limits, jobs)
                };
                let loaded = loaded.map_err(|e| about(e.into()))?;
                let named = |w: &Warning| w.clone().of(&file_name(path));
                warnings.extend(loaded.warnings.iter().map(named));
                EnvironmentSource::Image(Arc::new(loaded.image))
            }
        };
        Ok((self.turned(source), warnings))
    }

    /// [`Description::environment`], with the file from the context's resolver instead of the file system.
    ///
    /// # Errors
    /// As there.
    pub fn environment_from(
        &self,
        context: &Context<'_>,
    ) -> Result<(Environment, Vec<Warning>), DescriptionError> {
        let (source, warnings) = match self.env.as_ref().unwrap_or(&DEFAULT) {
            EnvironmentChoice::Named(named) => (named.source(), Vec::new()),
            EnvironmentChoice::File(path) => {
                let about = |error: LoadError| DescriptionError::from(error).at(path);
                let name = path.to_string_lossy();
                let bytes = context.resolver.read(&name, context.limits.input_bytes);
                let bytes = bytes.map_err(|e| about(e.into()))?;
                let loaded = load_environment(&bytes, context).map_err(about)?;
                let named = |w: &Warning| w.clone().of(&file_name(path));
                let warnings = loaded.warnings.iter().map(named).collect();
                (EnvironmentSource::Image(Arc::new(loaded.image)), warnings)
            }
        };
        Ok((self.turned(source), warnings))
    }

    /// Light from afar as described, of whatever picture.
    fn turned(&self, source: EnvironmentSource) -> Environment {
        Environment::default().with(|e| {
            e.source = source;
            e.rotation_degrees = self.env_rotation_degrees.unwrap_or(0.0);
            e.intensity = self.env_intensity.unwrap_or(1.0);
        })
    }
}
