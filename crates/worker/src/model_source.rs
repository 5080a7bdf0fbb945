//! Models from files and from standard input.

use crate::converters::{Conversion, Converted};
use crate::failure::Failure;
use overcoat_core::jobs::Jobs;
use overcoat_core::limits::Limits;
use overcoat_description::{is_standard_input, read_standard_input};
use overcoat_load::{
    AnimatedModel, Context, Format, LoadOptions, Loaded, NoResolver, load_bytes_with_format,
    load_file_with_format,
};
use std::path::PathBuf;

/// Source of a model.
#[derive(Clone, Debug)]
pub struct ModelSource {
    /// A file; `-` stands for standard input.
    pub path: PathBuf,
    /// Its format; found by content and name if absent.
    pub format: Option<Format>,
    /// Choices among the contents of the file.
    pub options: LoadOptions,
    /// Converter that makes the file readable, if it needs one.
    pub conversion: Option<Conversion>,
}

/// Loads a model.
///
/// # Errors
/// [`Failure`] naming the file and the reason.
pub fn load(source: &ModelSource, limits: &Limits, jobs: &Jobs) -> Result<Loaded, Failure> {
    load_with_format(source, limits, jobs).map(|(loaded, _)| loaded)
}

/// Loads a model and tells its format.
///
/// # Errors
/// As [`load`].
pub fn load_with_format(
    source: &ModelSource,
    limits: &Limits,
    jobs: &Jobs,
) -> Result<(Loaded, Option<Format>), Failure> {
    let about = |failure: Failure| failure.at(&source.path);
    if let Some(conversion) = &source.conversion {
        let Converted { glb, warnings } = conversion.of(&source.path, limits).map_err(about)?;
        // Files that it refers to are not looked for: the converter has seen one file.
        let context = Context { resolver: &NoResolver, limits, jobs };
        let loaded = load_bytes_with_format(&glb, Some(Format::Glb), &source.options, &context);
        let (mut loaded, format) =
            loaded.map_err(|e| about(Failure::load(&e).of_converter(&conversion.converter.name)))?;
        loaded.warnings.extend(warnings);
        return Ok((loaded, format));
    }
    if is_standard_input(&source.path) {
        let bytes = read_standard_input(limits).map_err(|e| about(e.into()))?;
        // A model from a pipe has no folder, so it may not refer to files.
        let context = Context { resolver: &NoResolver, limits, jobs };
        return load_bytes_with_format(&bytes, source.format, &source.options, &context)
            .map_err(|e| about(Failure::load(&e)));
    }
    load_file_with_format(&source.path, &source.options, limits, jobs).map_err(|e| about(Failure::load(&e)))
}

/// Reads a model whose scene is needed at several times, and the list of its animations.
///
/// # Errors
/// As [`load`].
pub fn open_animated(source: &ModelSource, limits: &Limits, jobs: &Jobs) -> Result<AnimatedModel, Failure> {
    let about = |failure: Failure| failure.at(&source.path);
    if let Some(conversion) = &source.conversion {
        let Converted { glb, warnings } = conversion.of(&source.path, limits).map_err(about)?;
        let context = Context { resolver: &NoResolver, limits, jobs };
        let opened = AnimatedModel::from_bytes(&glb, Some(Format::Glb), &source.options, &context);
        let opened = opened.map_err(|e| about(Failure::load(&e).of_converter(&conversion.converter.name)))?;
        return Ok(warnings.into_iter().fold(opened, AnimatedModel::with_warning));
    }
    let opened = if is_standard_input(&source.path) {
        let bytes = read_standard_input(limits).map_err(|e| about(e.into()))?;
        let context = Context { resolver: &NoResolver, limits, jobs };
        AnimatedModel::from_bytes(&bytes, source.format, &source.options, &context)
    } else {
        AnimatedModel::open(&source.path, &source.options, limits, jobs)
    };
    opened.map_err(|e| about(Failure::load(&e)))
}
