//! Programs that turn files of other formats into GLB: a door for what no reader here draws.
//!
//! Only the operator registers them ([`config`]); no model, no folder of models and no request can. A converter is run without a
//! shell, in a sandbox that shows it one file ([`launch`]), within bounds (`run.rs`), and what it writes is read like any GLB of a
//! stranger. The process that draws never parses the original.

pub mod config;
pub mod launch;
pub mod places;
mod run;

use crate::failure::Failure;
use overcoat_core::limits::Limits;
use overcoat_load::{Format, Warning};
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Picture size that converters are told where none is known: of inspections, and of models that are drawn at several sizes.
pub const USUAL_PIXELS: u32 = 1024;

/// Bytes at the beginning of a file by which it may be recognised, at most.
pub const LONGEST_MAGIC: usize = 64;

/// A registered converter.
#[derive(Clone, Debug, PartialEq)]
pub struct Converter {
    /// Name in the configuration and in messages.
    pub name: String,
    /// Name of its format for people.
    pub about: String,
    /// Media type of its files.
    pub mime_type: String,
    /// Extensions of its files, in lower case and without the dot; at least one.
    pub extensions: Vec<String>,
    /// First bytes of its files.
    pub magic: Vec<Vec<u8>>,
    /// Program and arguments with `{input}`, `{output}`, `{pixels}` and `{scratch}` in them.
    pub command: Vec<String>,
    /// Files and folders that the program needs beside those of the system, to read and to run.
    pub read: Vec<PathBuf>,
    /// It gets a private folder to write into, which is removed when it has ended.
    pub scratch: bool,
    /// It may start other processes; bounds of memory and processor time are those of each.
    pub processes: bool,
    /// It may run where there is no sandbox.
    pub unsandboxed: bool,
    /// Picture size in pixels that it is told always, whatever the picture's is.
    pub pixels: Option<u32>,
    /// Seconds of processor time.
    pub cpu_seconds: u64,
    /// Seconds of the wall.
    pub wall_seconds: u64,
    /// Bytes of memory.
    pub memory: u64,
    /// Bytes of what it writes.
    pub output_bytes: u64,
    /// Text that changes the content keys of pictures, for another version of the program.
    pub version: String,
}

impl Converter {
    /// True if one of the arguments has this in braces.
    fn uses(&self, placeholder: &str) -> bool {
        self.command.iter().any(|argument| argument.contains(placeholder))
    }
}

/// The converters of a configuration, the first of an extension before others.
#[derive(Clone, Debug, Default)]
pub struct Registry {
    converters: Vec<Arc<Converter>>,
}

impl Registry {
    /// All of them, in their order.
    #[must_use]
    pub fn all(&self) -> &[Arc<Converter>] {
        &self.converters
    }

    /// Adds converters after those that are there.
    pub fn add(&mut self, converters: impl IntoIterator<Item = Converter>) {
        self.converters.extend(converters.into_iter().map(Arc::new));
    }

    /// Lets all run where there is no sandbox.
    pub fn allow_unsandboxed(&mut self) {
        for converter in &mut self.converters {
            Arc::make_mut(converter).unsandboxed = true;
        }
    }

    /// The converter of files of this name. A format that is read here needs none.
    #[must_use]
    pub fn of_name(&self, name: &Path) -> Option<&Arc<Converter>> {
        let extension = name.extension()?.to_str()?.to_ascii_lowercase();
        let has = |converter: &&Arc<Converter>| converter.extensions.contains(&extension);
        if Format::from_extension(&extension).is_some() { None } else { self.converters.iter().find(has) }
    }

    /// The converter of a file with this name and these first bytes.
    #[must_use]
    pub fn of_bytes(&self, name: &Path, head: &[u8]) -> Option<&Arc<Converter>> {
        let extension = name.extension().and_then(|extension| extension.to_str());
        if extension.is_some_and(|extension| Format::from_extension(extension).is_some()) {
            return None;
        }
        let begins =
            |converter: &&Arc<Converter>| converter.magic.iter().any(|magic| head.starts_with(magic));
        self.of_name(name).or_else(|| self.converters.iter().find(begins))
    }

    /// The converter of a file, of which no more than the first bytes are read, and those only if its name says nothing.
    #[must_use]
    pub fn of_file(&self, path: &Path) -> Option<&Arc<Converter>> {
        if self.converters.is_empty() || !std::fs::metadata(path).is_ok_and(|metadata| metadata.is_file()) {
            return None;
        }
        self.of_name(path).or_else(|| {
            let mut head = Vec::new();
            File::open(path).ok()?.take(LONGEST_MAGIC as u64).read_to_end(&mut head).ok()?;
            self.of_bytes(path, &head)
        })
    }

    /// Text that changes with whatever may change what the converters make; empty without any.
    #[must_use]
    pub fn key(&self) -> String {
        let of = |converter: &Arc<Converter>| {
            let Converter { name, extensions, magic, command, pixels, version, .. } = &**converter;
            format!("{name:?} {extensions:?} {magic:?} {command:?} {pixels:?} {version:?}\n")
        };
        self.converters.iter().map(of).collect()
    }
}

/// File that a converter is given.
#[derive(Clone, Copy, Debug)]
pub enum Original<'a> {
    /// A file of the system.
    File(&'a Path),
    /// Bytes in memory: they are laid into a private file for the converter.
    Bytes(&'a [u8]),
}

/// Result of a converter.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Converted {
    /// GLB, by its first bytes.
    pub glb: Vec<u8>,
    /// Lines that it has written to standard error with `warning:` in front.
    pub warnings: Vec<Warning>,
}

/// Lets a converter make GLB of a file, for a picture whose longer side has this many pixels.
///
/// # Errors
/// [`Failure`] of one line that names the converter: exit code 3 beyond a bound, else 1.
pub fn convert(
    converter: &Converter,
    original: Original<'_>,
    pixels: u32,
    limits: &Limits,
) -> Result<Converted, Failure> {
    run::run(converter, original, converter.pixels.unwrap_or(pixels), limits)
        .map_err(|failure| failure.of_converter(&converter.name))
}

/// A model that a converter makes readable.
#[derive(Clone, Debug)]
pub struct Conversion {
    /// The converter.
    pub converter: Arc<Converter>,
    /// Longer side of the picture in pixels.
    pub pixels: u32,
    /// Its result, if it was run already, before rights were given up.
    pub ahead: Option<Arc<Result<Converted, Failure>>>,
}

impl Conversion {
    /// GLB of a file.
    ///
    /// # Errors
    /// As [`convert`].
    pub fn of(&self, path: &Path, limits: &Limits) -> Result<Converted, Failure> {
        match &self.ahead {
            Some(made) => (**made).clone(),
            None => convert(&self.converter, Original::File(path), self.pixels, limits),
        }
    }
}
