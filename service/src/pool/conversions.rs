//! Converters of formats that workers do not read: processes beside the workers, as many at a time.

use super::PoolOptions;
use overcoat_core::limits::Limits;
use overcoat_worker::converters::{self, Converted, Original, Registry, USUAL_PIXELS};
use overcoat_worker::failure::Failure;
use overcoat_worker::limit_values;
use std::path::Path;
use std::sync::Arc;
use tokio::sync::Semaphore;

/// Converters and their bounds.
#[derive(Debug)]
pub(super) struct Conversions {
    registry: Arc<Registry>,
    limits: Limits,
    permits: Arc<Semaphore>,
}

/// Result of a converter for a model.
pub(super) struct Made {
    /// Name of the converter.
    pub(super) converter: String,
    /// The model.
    pub(super) glb: Vec<u8>,
    /// Remarks of the converter.
    pub(super) warnings: Vec<String>,
}

impl Conversions {
    pub(super) fn new(options: &PoolOptions) -> Self {
        let permits = Arc::new(Semaphore::new(options.workers.max(1)));
        let limits = limit_values::limits(&options.start.limits);
        Self { registry: Arc::clone(&options.converters), limits, permits }
    }

    /// GLB of a model, if it needs a converter. Whoever asked may be gone meanwhile; the converter then runs to its end, and
    /// keeps its place till then.
    pub(super) async fn of(&self, name: &str, model: &[u8]) -> Result<Option<Made>, Failure> {
        let path = Path::new(name);
        let head = model.get(..converters::LONGEST_MAGIC).unwrap_or(model);
        let Some(converter) = self.registry.of_bytes(path, head).cloned() else { return Ok(None) };
        let permit = Arc::clone(&self.permits).acquire_owned().await.map_err(Failure::failed)?;
        let (bytes, limits, own) = (model.to_vec(), self.limits.clone(), Arc::clone(&converter));
        let converting = tokio::task::spawn_blocking(move || {
            let _permit = permit;
            converters::convert(&own, Original::Bytes(&bytes), USUAL_PIXELS, &limits)
        });
        let made = converting.await.map_err(Failure::failed)?.map_err(|failure| failure.at(path))?;
        let Converted { glb, warnings } = made;
        let warnings = warnings.into_iter().map(|warning| warning.message).collect();
        Ok(Some(Made { converter: converter.name.clone(), glb, warnings }))
    }
}
