//! The renderer: scene and options in, frame out. The only place that knows the order of the stages: those of a picture are in
//! `picture.rs`, those of a tile in `tile_pass.rs`.
//!
//! **Memory.** Every list of a picture is kept for the next: a picture like the last one takes no new memory, see
//! [`Renderer::recycle`].

mod aov;
mod bands;
mod budget;
mod builder;
mod clock;
mod crew;
mod draws;
mod effects;
mod environment;
mod ground;
mod ground_light;
mod ground_pixels;
#[cfg(test)]
mod ground_tests;
mod lamps;
mod light_pool;
mod mirror;
#[cfg(test)]
mod mirror_tests;
mod options;
mod pass;
mod passes;
mod picture;
mod quality;
mod reach;
mod resolve;
mod setup;
mod shading_order;
mod shading_rate;
mod splat_layers;
mod splat_tile;
mod splats;
mod tile_blending;
mod tile_light;
mod tile_pass;
mod tile_shading;
mod tile_store;
mod tile_triangles;
mod tile_visibility;
mod tiles;
mod trace;
mod unseen;
mod visibility;
mod work;

pub use builder::RendererBuilder;
pub use ground::Ground;
pub use options::{Background, RenderError, RenderOptions, RenderStats, Rendered, RenderedImage};
pub use quality::{Quality, Visibility};
pub use trace::StageHashes;
pub use unseen::Unseen;
pub use work::WorkDone;

use crate::frame::{DisplayImage, DisplayOptions, Frame};
use crate::jobs::Jobs;
use crate::light::PrefilteredEnvironment;
use crate::scene::{Camera, Scene};
use builder::Fixed;
use crew::arithmetic_is_default;
use picture::{Drawn, Memory, Request};
use std::sync::Arc;

/// Renders scenes, keeping threads, buffers and filtered environments from one picture to the next.
#[derive(Debug, Default)]
pub struct Renderer {
    jobs: Jobs,
    fixed: Fixed,
    memory: Memory,
}

impl Renderer {
    /// A renderer with `threads` workers; 0 stands for one per processor, and more than [`crate::jobs::MAX_THREADS`] for so
    /// many.
    #[must_use]
    pub fn new(threads: usize) -> Self {
        Self { jobs: Jobs::new(threads), fixed: Fixed::default(), memory: Memory::default() }
    }

    /// For a renderer with other settings than those of [`Renderer::new`].
    pub fn builder() -> RendererBuilder {
        RendererBuilder::default()
    }

    /// The worker threads, for loaders to share.
    #[must_use]
    pub fn jobs(&self) -> &Jobs {
        &self.jobs
    }

    /// The work that was counted for the last picture whose tiles were begun, whether it was finished or not: how far beyond a
    /// limit the threads got depends on timing.
    #[must_use]
    pub fn work_done(&self) -> WorkDone {
        self.memory.work_done
    }

    /// Lights the following pictures by an environment that is filtered already, in place of the scene's picture; its
    /// rotation and intensity stay the scene's. `None` goes back to the scene's own.
    #[doc(hidden)]
    pub fn use_environment(&mut self, environment: Option<Arc<PrefilteredEnvironment>>) {
        self.memory.environments.given = environment;
    }

    /// Gives back a frame that is not needed any more: the next picture takes its memory in place of new memory, which
    /// the system would have to clear.
    ///
    /// If every frame is given back, a picture like an earlier one allocates nothing, but for one block of about 1.5 KB
    /// in the queue of the worker threads every 63 pictures, if there are several. G-buffer planes and
    /// [`RenderOptions::stage_hashes`] take new memory each time.
    pub fn recycle(&mut self, frame: Frame) {
        self.memory.passes.planes.linear = frame.pixels;
        self.memory.passes.planes.transmittance = frame.transmittance;
    }

    /// As [`Renderer::recycle`], with a picture for a screen.
    pub fn recycle_image(&mut self, image: DisplayImage) {
        self.memory.passes.planes.display = image.pixels;
    }

    /// Draws one picture.
    ///
    /// # Errors
    /// [`RenderError`] if an option is out of range, the camera spans no view, or a limit is exceeded.
    pub fn render(
        &mut self,
        scene: &Scene,
        camera: &Camera,
        options: &RenderOptions,
    ) -> Result<Rendered, RenderError> {
        let Drawn { frame, stats, .. } = self.draw(scene, camera, options, None)?;
        Ok(Rendered { frame, stats })
    }

    /// Draws one picture for a screen: the pixels that [`DisplayImage::new`] makes of [`Renderer::render`]'s frame, every
    /// byte of them, without the frame. Tiles go to 8 bits while they are in the cache, and a picture takes four bytes a
    /// pixel in place of twenty; with surfaces that refract what is behind them, or [`RenderOptions::stage_hashes`], the
    /// frame is made all the same.
    ///
    /// # Errors
    /// As [`Renderer::render`].
    pub fn render_image(
        &mut self,
        scene: &Scene,
        camera: &Camera,
        options: &RenderOptions,
        display: &DisplayOptions,
    ) -> Result<RenderedImage, RenderError> {
        let Drawn { frame, image, tinted, clipping, exposure, stats } =
            self.draw(scene, camera, options, Some(display))?;
        let aovs = frame.aovs;
        if !frame.pixels.is_empty() {
            self.memory.passes.planes.linear = frame.pixels;
            self.memory.passes.planes.transmittance = frame.transmittance;
        }
        Ok(RenderedImage { image, aovs, tinted, clipping, exposure, stats })
    }

    /// Draws a picture, as a frame or for a screen.
    fn draw(
        &mut self,
        scene: &Scene,
        camera: &Camera,
        options: &RenderOptions,
        display: Option<&DisplayOptions>,
    ) -> Result<Drawn, RenderError> {
        if !arithmetic_is_default() {
            return Err(RenderError::FloatingPointMode);
        }
        let Self { jobs, fixed, memory } = self;
        let options = fixed.among(options);
        // All of it on a worker, so that work is handed over once and not in every loop.
        jobs.on_worker(|| memory.draw(&Request { jobs, scene, camera, options: &options, display }))
    }
}
