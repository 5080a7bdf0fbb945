//! Reads models from files and from standard input.

use super::args::InputArgs;
use super::failure::Failure;
use overcoat_core::jobs::Jobs;
use overcoat_core::limits::Limits;
use overcoat_core::suggest::{nearest_name, suggestion};
use overcoat_description::{is_standard_input, read_standard_input};
use overcoat_load::{
    AnimatedModel, Context, Format, LoadOptions, Loaded, NoResolver, TextureLoading, load_bytes_with_format,
    load_file_with_format,
};
use std::path::{Path, PathBuf};

/// Source of a model.
#[derive(Clone, Debug)]
pub struct ModelSource {
    /// A file; `-` stands for standard input.
    pub path: PathBuf,
    /// Its format; found by content and name if absent.
    pub format: Option<Format>,
    /// Choices among the contents of the file.
    pub options: LoadOptions,
}

/// A model with what the options of the command line say about it.
///
/// # Errors
/// [`Failure`] if they name an unknown format.
pub fn source(args: &InputArgs, path: &Path) -> Result<ModelSource, Failure> {
    // Faults of textures are reported once they are drawn.
    let textures = TextureLoading::ByNeed;
    let options =
        LoadOptions::default().with_variant(args.variant.clone()).with_up(args.up()).with_textures(textures);
    Ok(ModelSource { path: path.to_owned(), format: format(args, path)?, options })
}

/// The format that `--format` names, which is for standard input.
///
/// # Errors
/// [`Failure`] with the names that exist, or if the format of a file is given.
fn format(args: &InputArgs, path: &Path) -> Result<Option<Format>, Failure> {
    let Some(name) = args.format.as_deref() else { return Ok(None) };
    let format = Format::from_name(name).ok_or_else(|| {
        let names: Vec<&str> = Format::ALL.iter().copied().map(Format::extension).collect();
        let hint = suggestion(nearest_name(name, names.iter().copied()));
        Failure::usage(format!("unknown format '{name}'; known are {}{hint}", names.join(", ")))
    })?;
    if is_standard_input(path) {
        Ok(Some(format))
    } else {
        Err(Failure::usage("--format is for standard input; files are recognised by themselves").at(path))
    }
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
    let opened = if is_standard_input(&source.path) {
        let bytes = read_standard_input(limits).map_err(|e| about(e.into()))?;
        let context = Context { resolver: &NoResolver, limits, jobs };
        AnimatedModel::from_bytes(&bytes, source.format, &source.options, &context)
    } else {
        AnimatedModel::open(&source.path, &source.options, limits, jobs)
    };
    opened.map_err(|e| about(Failure::load(&e)))
}
