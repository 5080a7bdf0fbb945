//! Models that arguments name.

use super::args::InputArgs;
use super::converters;
use super::failure::Failure;
use overcoat_core::suggest::{nearest_name, suggestion};
use overcoat_description::is_standard_input;
use overcoat_load::{Format, LoadOptions, TextureLoading};
use overcoat_worker::model_source::ModelSource;
use std::path::Path;

/// A model with what the options of the command line say about it.
///
/// # Errors
/// [`Failure`] if they name an unknown format.
pub fn source(args: &InputArgs, path: &Path) -> Result<ModelSource, Failure> {
    // Faults of textures are reported once they are drawn.
    let textures = TextureLoading::ByNeed;
    let options = LoadOptions::default().with_variant(args.variant.clone()).with_textures(textures);
    let options = options.with_up(args.up()).with_plate(args.plate());
    let conversion = converters::of(path)?;
    Ok(ModelSource { path: path.to_owned(), format: format(args, path)?, options, conversion })
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
