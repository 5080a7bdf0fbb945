//! Stopping a picture from another thread.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Stops pictures that are being drawn, from whatever thread: `Renderer::cancel_by`. Copies are of one
/// and the same; each picture that is to be stopped on its own has one of its own.
///
/// A picture that is stopped ends with `RenderError::Cancelled`: before the next sixteen fragments that each thread would
/// shade, the next of a depth map's runs of triangles, of an environment's texels, of the floor's rows. Unfinished maps are not kept.
#[derive(Clone, Debug, Default)]
pub struct Cancellation(Arc<AtomicBool>);

impl Cancellation {
    /// One that nobody has used.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Stops what is drawn and whatever is begun with it. There is no way back.
    pub fn cancel(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// True once it has been used.
    #[must_use]
    pub fn is_cancelled(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}
