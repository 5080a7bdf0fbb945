//! Converters that the operator has registered, for files that no reader here draws.
//!
//! The configuration is read once a file needs it. Rights that are given up before files are read (`--sandbox`, thumbnails) would
//! close the way to any other program, so the files of such a command are converted before.

use super::args::Command;
use super::failure::Failure;
use super::sandbox::Files;
use super::thumbnail_limits::within_thumbnail_limits;
use overcoat_core::limits::Limits;
use overcoat_description::{Description, is_standard_input};
use overcoat_load::{Format, inner_extension};
use overcoat_render::RenderOptions;
use overcoat_worker::converters::{self, Conversion, Converted, Original, Registry, USUAL_PIXELS, places};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

/// Options of the command line. Of the process, as the command line is.
static CHOICE: OnceLock<(Option<PathBuf>, bool)> = OnceLock::new();

/// Registry of the configuration, or what is wrong with it.
static REGISTRY: OnceLock<Result<Registry, String>> = OnceLock::new();

/// Result of a converter for a file.
type Made = Arc<Result<Converted, Failure>>;

/// Results from before rights were given up.
static AHEAD: Mutex<BTreeMap<PathBuf, Made>> = Mutex::new(BTreeMap::new());

/// Settles which configuration counts.
///
/// # Errors
/// [`Failure`] if one is named and something is wrong with it.
pub(super) fn choose(file: Option<&Path>, allow_unsandboxed: bool) -> Result<(), Failure> {
    // A second command line of one process has no other.
    let _ = CHOICE.set((file.map(Path::to_owned), allow_unsandboxed));
    if file.is_some() { registry().map(drop) } else { Ok(()) }
}

/// All that are registered.
///
/// # Errors
/// [`Failure`] if something is wrong in the configuration.
pub(super) fn registry() -> Result<&'static Registry, Failure> {
    let read = || {
        let (file, allow_unsandboxed) = CHOICE.get().cloned().unwrap_or_default();
        let mut registry = places::find(file.as_deref())?;
        if allow_unsandboxed {
            registry.allow_unsandboxed();
        }
        Ok(registry)
    };
    REGISTRY.get_or_init(read).as_ref().map_err(Failure::failed)
}

/// The conversion that a file needs, if it needs one.
///
/// # Errors
/// [`Failure`] if something is wrong in the configuration.
pub(super) fn of(path: &Path) -> Result<Option<Conversion>, Failure> {
    let is_known =
        inner_extension(path).is_some_and(|extension| Format::from_extension(&extension).is_some());
    if is_standard_input(path) || is_known {
        return Ok(None);
    }
    let Some(converter) = registry()?.of_file(path) else { return Ok(None) };
    let ahead = AHEAD.lock().unwrap_or_else(PoisonError::into_inner).get(path).cloned();
    Ok(Some(Conversion { converter: converter.clone(), pixels: USUAL_PIXELS, ahead }))
}

/// Converts the files of a command that is about to give up its rights.
///
/// # Errors
/// [`Failure`] if something is wrong in the configuration; what is wrong with a file is told when it is read.
pub(super) fn go_ahead(command: &Command) -> Result<(), Failure> {
    let Some((pixels, limits)) = wanted(command) else { return Ok(()) };
    let files = Files::of(command);
    for path in files.models {
        let Some(conversion) = of(path)? else { continue };
        if files.draw.is_some_and(|draw| draw.scene.is_some()) {
            let message =
                "with --sandbox a converter is not run for a scene file's picture: give its keys as options";
            return Err(Failure::usage(message).at(path));
        }
        let made = converters::convert(&conversion.converter, Original::File(path), pixels, &limits);
        AHEAD.lock().unwrap_or_else(PoisonError::into_inner).insert(path.clone(), Arc::new(made));
    }
    Ok(())
}

/// Longer side of a command's pictures, and its limits; `None` if it reads no models.
fn wanted(command: &Command) -> Option<(u32, Limits)> {
    let usual = RenderOptions::default();
    let default = match command {
        Command::Thumbnail(args) => {
            return Some((args.size.into(), within_thumbnail_limits(&args.limits).limits()));
        }
        Command::Info(args) => return Some((USUAL_PIXELS, args.input_options.limits.limits())),
        Command::Render(args) if args.embedded => return None,
        Command::Sheet(_) | Command::CompareModels(_) => super::contact::DEFAULT_CELL,
        Command::Diff(_) => super::diff::DEFAULT_SIDE,
        _ => [usual.width.into(), usual.height.into()],
    };
    let draw = Files::of(command).draw?;
    let mut description = Description::default();
    draw.apply(&mut description);
    let [width, height] = description.size.unwrap_or(default);
    Some((u32::try_from(width.max(height)).unwrap_or(u32::MAX), draw.input.limits.limits()))
}
