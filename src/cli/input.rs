//! Reads models from files and from standard input.

use super::failure::Failure;
use super::picture::is_standard_stream;
use super::shim::{Format, load_bytes, load_file};
use crate::jobs::Jobs;
use crate::limits::{LimitExceeded, Limits};
use crate::load::{Context, Loaded, NoResolver};
use std::io::Read;
use std::path::PathBuf;

/// Where a model comes from.
#[derive(Clone, Debug)]
pub struct ModelSource {
    /// A file; `-` stands for standard input.
    pub path: PathBuf,
    /// Its format; found by content and name if absent.
    pub format: Option<Format>,
}

/// A format by the name that `--format` takes.
///
/// # Errors
/// [`Failure`] with the names that exist.
pub fn format(name: Option<&str>) -> Result<Option<Format>, Failure> {
    name.map(|name| {
        Format::from_name(name).ok_or_else(|| {
            Failure::usage(format!("unknown format '{name}'; known are gltf, glb, obj, stl and ply"))
        })
    })
    .transpose()
}

/// Loads a model.
///
/// # Errors
/// [`Failure`] naming the file and the reason.
pub fn load(source: &ModelSource, limits: &Limits, jobs: &Jobs) -> Result<Loaded, Failure> {
    let path = &source.path;
    let loaded = if is_standard_stream(path) {
        let bytes = read_standard_input(limits).map_err(|failure| failure.at(path))?;
        // What comes through a pipe has no folder, so it may not refer to files.
        load_bytes(&bytes, source.format, &Context { resolver: &NoResolver, limits, jobs })
    } else {
        load_file(path, limits, jobs)
    };
    loaded.map_err(|e| Failure::load(&e).at(path))
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
        return Err(Failure::limit(&LimitExceeded {
            what: "input".to_owned(),
            asked,
            limit: limits.input_bytes,
            field: "input_bytes",
        }));
    }
    if bytes.is_empty() {
        return Err(Failure::failed("no data"));
    }
    Ok(bytes)
}
