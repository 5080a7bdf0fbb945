//! Settings that all pictures of a batch or a service share: from options to the first message to workers.

use crate::key::Keys;
use crate::pool::TimeLimits;
use clap::Args;
use overcoat::description::{Description, EnvironmentChoice, MaterialChoice};
use overcoat_cli::args::DrawArgs;
use overcoat_cli::value_parsers;
use overcoat_worker::converters::{Registry, places};
use overcoat_worker::protocol::Start;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Bytes of a file that all pictures have in common, at most.
const LARGEST_FILE: u64 = 1 << 30;

/// Limits of workers that draw models one by one, in a batch and for tools.
// Help, and no markup.
#[allow(missing_docs)]
#[derive(Debug, Args)]
pub struct WorkerLimitArgs {
    /// Memory of a worker's data; suffixes as of --limit
    #[arg(long, value_name = "BYTES", default_value = "2Gi", value_parser = bytes, help_heading = "Workers")]
    pub memory: u64,

    /// Seconds of processor time, of all threads, after which the work on one model is stopped (of the wall where the system does not
    /// tell, on others than Linux)
    #[arg(long, value_name = "SECONDS", default_value = "60", value_parser = value_parsers::within::<f64>(0.01, 1e6),
          help_heading = "Workers")]
    pub deadline: f64,

    /// Seconds of the wall after which it is stopped, whatever it waits for [default: ten times --deadline]
    #[arg(long, value_name = "SECONDS", value_parser = value_parsers::within::<f64>(0.01, 1e7), help_heading = "Workers")]
    pub wall_deadline: Option<f64>,

    /// Leave workers the rights that they do not need (Linux takes them otherwise)
    #[arg(long, help_heading = "Workers")]
    pub no_sandbox: bool,
}

impl WorkerLimitArgs {
    /// The first message to a worker with these limits.
    #[must_use]
    pub fn start(&self, start: &Start) -> Start {
        Start { memory: Some(self.memory), sandbox: !self.no_sandbox, ..start.clone() }
    }

    /// Time limits of the work on one model.
    #[must_use]
    pub fn time(&self) -> TimeLimits {
        TimeLimits::new(self.deadline, self.wall_deadline)
    }
}

/// Programs that make GLB of formats that are not read here.
// Help, and no markup.
#[allow(missing_docs)]
#[derive(Debug, Default, Args)]
pub struct ConverterArgs {
    /// File that registers converters, programs that make GLB of other formats (TOML), or none
    #[arg(long, value_name = "FILE", help_heading = "Input")]
    pub converters: Option<PathBuf>,

    /// Run converters where there is no sandbox for them, too: they can do all that this program can then
    #[arg(long, help_heading = "Input")]
    pub allow_unsandboxed_converters: bool,
}

impl ConverterArgs {
    /// The converters of the file that is named, and of no other: what is installed on a machine is not yet offered to clients.
    ///
    /// # Errors
    /// One line that names the file.
    pub fn named(&self) -> Result<Arc<Registry>, String> {
        let registry = self.converters.as_deref().map(places::named).transpose()?.unwrap_or_default();
        Ok(self.settled(registry))
    }

    /// The converters of the file that is named, or of the usual places.
    ///
    /// # Errors
    /// One line that names the file.
    pub fn usual(&self) -> Result<Arc<Registry>, String> {
        Ok(self.settled(places::find(self.converters.as_deref())?))
    }

    fn settled(&self, mut registry: Registry) -> Arc<Registry> {
        if self.allow_unsandboxed_converters {
            registry.allow_unsandboxed();
        }
        Arc::new(registry)
    }
}

/// A number of bytes with a suffix.
///
/// # Errors
/// One line.
pub fn bytes(text: &str) -> Result<u64, String> {
    // The same suffixes as those of limits, of which this is one that takes any number.
    value_parsers::limit(&format!("input_bytes={text}")).map(|(_, bytes)| bytes)
}

/// First message to workers, and content keys of pictures made with it.
#[derive(Clone, Debug)]
pub struct Common {
    /// First message to a worker.
    pub start: Start,
    /// Content keys of pictures.
    pub keys: Keys,
    /// Converters of formats that are not read here.
    pub converters: Arc<Registry>,
}

impl Common {
    /// Settings from the options that `overcoat render` has, too. The files that they name are read once, for the
    /// keys.
    ///
    /// # Errors
    /// One line.
    pub fn new(draw: &DrawArgs, converters: Arc<Registry>) -> Result<Self, String> {
        let mut description = match &draw.scene {
            Some(path) => Description::open(path).map_err(|e| e.to_string())?,
            None => Description::default(),
        };
        description.model = None;
        draw.apply(&mut description);
        name_materials(&mut description);
        let here = std::env::current_dir().map_err(|e| format!("the current folder: {e}"))?;
        description.resolve_paths(&here);
        let limits = draw.input.limits.limits();
        // Errors in the options are found now, and not by every model.
        description.options(draw.machine.machine(), &limits).map_err(|e| e.to_string())?;
        description.load_options().map_err(|e| e.to_string())?;
        let files = files_of(&description)?;
        let start = Start {
            description: serde_json::to_value(&description).map_err(|e| e.to_string())?,
            variant: draw.input.variant.clone(),
            limits: draw.input.limits.limits.clone(),
            allow_empty: draw.allow_empty,
            threads: draw.machine.workers.threads.max(1),
            sandbox: true,
            memory: None,
            environments: BTreeMap::new(),
        };
        let keys = Keys::new(&start, &files, converters.key());
        Ok(Self { keys, start, converters })
    }
}

/// A scene file has one material for all, and others by name: the last of each.
fn name_materials(description: &mut Description) {
    for MaterialChoice { name, source } in std::mem::take(&mut description.more_materials) {
        match name {
            Some(name) => drop(description.materials.insert(name, source)),
            None => {
                description.materials.clear();
                description.material = Some(source);
            }
        }
    }
}

/// The files that a description names, as it names them, with their contents.
fn files_of(description: &Description) -> Result<Vec<(String, Vec<u8>)>, String> {
    let mut paths: Vec<PathBuf> = Vec::new();
    if let Some(EnvironmentChoice::File(path)) = &description.env {
        paths.push(path.clone());
    }
    paths.extend(description.material_choices().filter_map(|choice| Some(choice.source.file()?.to_owned())));
    paths.iter().map(|path| Ok((path.to_string_lossy().into_owned(), read(path)?))).collect()
}

/// Content of a file that all pictures have in common.
///
/// # Errors
/// One line that names the file.
pub fn read(path: &Path) -> Result<Vec<u8>, String> {
    let about = |reason: String| format!("{}: {reason}", path.display());
    let size = std::fs::metadata(path).map_err(|e| about(e.to_string()))?.len();
    if size > LARGEST_FILE {
        return Err(about(format!("{size} bytes exceed {LARGEST_FILE}")));
    }
    std::fs::read(path).map_err(|e| about(e.to_string()))
}
