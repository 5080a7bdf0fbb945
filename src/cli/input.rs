//! Reads models from files and from standard input.

use super::args::InputArgs;
use super::failure::Failure;
use super::picture::is_standard_stream;
use crate::jobs::Jobs;
use crate::limits::{LimitExceeded, Limits};
use crate::load::{
    AnimatedModel, Context, Format, LoadOptions, Loaded, NoResolver, load_bytes_with, load_file_with_format,
    nearest_name, suggestion,
};
use std::io::Read;
use std::path::{Path, PathBuf};

/// Where a model comes from.
#[derive(Clone, Debug)]
pub struct ModelSource {
    /// A file; `-` stands for standard input.
    pub path: PathBuf,
    /// Its format; found by content and name if absent.
    pub format: Option<Format>,
    /// What of it is loaded.
    pub options: LoadOptions,
}

/// A model with what the options of the command line say about it.
///
/// # Errors
/// [`Failure`] if they name an unknown format.
pub fn source(args: &InputArgs, path: &Path) -> Result<ModelSource, Failure> {
    let options = LoadOptions { variant: args.variant.clone(), ..LoadOptions::default() };
    Ok(ModelSource { path: path.to_owned(), format: format(args, path)?, options })
}

/// The format that `--format` names, which is for standard input.
///
/// # Errors
/// [`Failure`] with the names that exist, or if the format of a file is given.
fn format(args: &InputArgs, path: &Path) -> Result<Option<Format>, Failure> {
    let Some(name) = args.format.as_deref() else { return Ok(None) };
    let format = Format::from_name(name).ok_or_else(|| {
        let names: Vec<&str> = Format::ALL.into_iter().map(Format::extension).collect();
        let hint = suggestion(nearest_name(name, names.iter().copied()));
        Failure::usage(format!("unknown format '{name}'; known are {}{hint}", names.join(", ")))
    })?;
    if is_standard_stream(path) {
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
    if is_standard_stream(&source.path) {
        let bytes = read_standard_input(limits).map_err(about)?;
        let format = source.format.or_else(|| Format::detect(&bytes));
        // What comes through a pipe has no folder, so it may not refer to files.
        let context = Context { resolver: &NoResolver, limits, jobs };
        let loaded = load_bytes_with(&bytes, format, &source.options, &context)
            .map_err(|e| about(Failure::load(&e)))?;
        return Ok((loaded, format));
    }
    load_file_with_format(&source.path, &source.options, limits, jobs).map_err(|e| about(Failure::load(&e)))
}

/// Reads a model whose scene is needed at several times, and the list of its animations.
///
/// # Errors
/// As [`load`].
pub fn open_animated(source: &ModelSource, limits: &Limits, jobs: &Jobs) -> Result<AnimatedModel, Failure> {
    let about = |failure: Failure| failure.at(&source.path);
    let opened = if is_standard_stream(&source.path) {
        let bytes = read_standard_input(limits).map_err(about)?;
        let context = Context { resolver: &NoResolver, limits, jobs };
        AnimatedModel::from_bytes(&bytes, source.format, &source.options, &context)
    } else {
        AnimatedModel::open(&source.path, &source.options, limits, jobs)
    };
    opened.map_err(|e| about(Failure::load(&e)))
}

/// All of standard input, at most [`Limits::input_bytes`] of it.
fn read_standard_input(limits: &Limits) -> Result<Vec<u8>, Failure> {
    let mut bytes = Vec::new();
    std::io::stdin()
        .lock()
        .take(limits.input_bytes.saturating_add(1))
        .read_to_end(&mut bytes)
        .map_err(|e| Failure::failed(format!("cannot be read: {e}")))?;
    let asked = bytes.len() as u64;
    if asked > limits.input_bytes {
        // How much more there is, nobody knows.
        return Err(Failure::limit(&LimitExceeded::beyond("input", limits.input_bytes, "input_bytes")));
    }
    if bytes.is_empty() {
        return Err(Failure::failed("no data"));
    }
    Ok(bytes)
}
