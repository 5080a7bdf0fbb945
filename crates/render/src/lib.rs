//! The renderer: scene and options in, frame out. The only place that knows the order of the stages: those of a picture are in
//! `attempt.rs`, those of a tile in `tile_pass.rs`.
//!
//! **Memory.** Every list of a picture is kept for the next: a picture like the last one takes no new memory, see
//! [`Renderer::recycle`].

mod annotate;
mod attempt;
mod builder;
mod centered;
mod environment;
mod flow;
#[cfg(test)]
mod glass_tests;
#[cfg(test)]
mod ground_tests;
#[cfg(test)]
mod light_limits_tests;
#[cfg(test)]
mod mirror_tests;
mod passes;
mod pick;
mod picture;
mod prepared;
mod projected_box;
mod relief;
#[cfg(test)]
mod relief_tests;
mod rendered;
mod setup;
mod textures;
mod tiles;
mod traced_rows;
mod unseen;

pub use annotate::{Annotation, names_of_ids};
pub use builder::RendererBuilder;
pub use environment::EnvironmentStore;
pub use flow::optical_flow;
pub use overcoat_core::jobs::Cancellation;
pub use overcoat_tiles::clock::Moment;
pub use overcoat_tiles::edges::Edges;
pub use overcoat_tiles::ground::Ground;
pub use overcoat_tiles::options::{Background, RenderError, RenderOptions};
pub use overcoat_tiles::quality::{Quality, Visibility};
pub use overcoat_tiles::trace::StageHashes;
pub use overcoat_tiles::work::WorkDone;
pub use pick::Hit;
pub use rendered::{ReducedLight, RenderStats, Rendered, RenderedImage, RenderedInto};
pub use unseen::Unseen;

use builder::Fixed;
use overcoat_core::frame::{AovPlane, DisplayImage, DisplayOptions, Frame, Meter, PixelFormat, Target};
use overcoat_core::jobs::Jobs;
use overcoat_core::math::arithmetic_is_default;
use overcoat_scene::{Camera, CameraMatrices, Scene, ShadingModel};
use overcoat_stages::light::PrefilteredEnvironment;
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
    /// A renderer with `threads` workers; 0 stands for one per processor, and more than [`overcoat_core::jobs::MAX_THREADS`] for so
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

    /// Work that was counted for the last picture whose tiles were begun, whether it was finished or not: the amount by
    /// which the threads exceeded a limit depends on timing.
    #[must_use]
    pub fn work_done(&self) -> WorkDone {
        self.memory.work_done
    }

    /// Keeps filtered environments of pictures beyond this renderer and finds them there again; `None`, the default, filters
    /// what is not in its memory. Pictures are the same.
    pub fn set_environment_store(&mut self, store: Option<Arc<dyn EnvironmentStore>>) {
        self.memory.environments.store = store;
    }

    /// Lights the following pictures by an environment that is filtered already, in place of the scene's picture; its
    /// rotation and intensity stay the scene's. `None` goes back to the scene's own.
    #[doc(hidden)]
    pub fn use_environment(&mut self, environment: Option<Arc<PrefilteredEnvironment>>) {
        self.memory.environments.given = environment;
    }

    /// Runs a feedback pass for lazy textures whether it pays or not: for tests.
    #[doc(hidden)]
    pub fn always_feedback(&mut self) {
        self.memory.textures.always = true;
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
        Ok(Rendered { camera: matrices(scene, camera, options)?, frame, stats })
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
        let camera = matrices(scene, camera, options)?;
        Ok(RenderedImage { image, aovs, camera, tinted, clipping, exposure, stats })
    }

    /// Draws one picture for a screen into memory of the caller, or the part of it that the [`Target`] holds: the pixels of
    /// [`Renderer::render_image`], or of [`Renderer::render`] where its format is linear, in the order of the format. Tiles are
    /// written to it as they are finished: nothing of the picture's size is kept or copied, but for surfaces that refract what
    /// is behind them, a metered exposure and [`RenderOptions::stage_hashes`].
    ///
    /// Planes of the G-buffer are not made. A part costs about as much as its pixels and the vertices of the scene do.
    ///
    /// # Errors
    /// As [`Renderer::render`]; [`RenderError::Option`] if region, stride and buffer do not fit together. After an error, the
    /// memory may hold parts of the picture.
    pub fn render_into(
        &mut self,
        scene: &Scene,
        camera: &Camera,
        options: &RenderOptions,
        display: &DisplayOptions,
        target: &mut Target<'_>,
    ) -> Result<RenderedInto, RenderError> {
        let misfit = |(option, value, allowed)| RenderError::Option { option, value, allowed };
        let region = target.fit([options.width, options.height]).map_err(misfit)?;
        let mut display = std::borrow::Cow::Borrowed(display);
        if target.format() == PixelFormat::Xrgb8 && display.background.is_none() {
            display.to_mut().background = Some([0; 3]);
        }
        let meters = display.for_lights(scene.brings_light()).meter != Meter::Never;
        if meters || options.stage_hashes {
            let drawn = self.draw(scene, camera, options, Some(&display))?;
            target.copy_from(region, &drawn.frame, &drawn.image);
            self.recycle(drawn.frame);
            self.recycle_image(drawn.image);
            let (tinted, exposure, stats) = (drawn.tinted, drawn.exposure, drawn.stats);
            return Ok(RenderedInto { camera: matrices(scene, camera, options)?, tinted, exposure, stats });
        }
        let drawn = self.with_request(scene, camera, options, Some(&display), |memory, request| {
            memory.draw_into(request, Some((target, region)))
        })?;
        let Drawn { frame, tinted, exposure, stats, .. } = drawn;
        if !frame.pixels.is_empty() {
            self.recycle(frame);
        }
        Ok(RenderedInto { camera: matrices(scene, camera, options)?, tinted, exposure, stats })
    }

    /// Draws planes of the G-buffer alone, those of [`RenderOptions::aovs`] in their order: surfaces are neither lit nor shaded, and
    /// there is no floor. Geometry and identities are those of [`Renderer::render`]; planes that depth maps know are as in
    /// [`Quality::Draft`].
    ///
    /// # Errors
    /// As [`Renderer::render`].
    pub fn render_planes(
        &mut self,
        scene: &Scene,
        camera: &Camera,
        options: &RenderOptions,
    ) -> Result<Vec<AovPlane>, RenderError> {
        let drawn = self.with_request(scene, camera, options, None, |memory, request| {
            let options = &centered::of_planes(request.options, request.options.aovs.clone());
            memory.draw(&Request { options, only_planes: true, ..*request })
        })?;
        let mut frame = drawn.frame;
        let planes = std::mem::take(&mut frame.aovs);
        if !frame.pixels.is_empty() {
            self.recycle(frame);
        }
        Ok(planes)
    }

    /// Finds what a pixel shows, counted from the upper left corner: the nearest triangle, line or point whose opacity
    /// is not 0 at the sample nearest to the middle that sees any. `None` where nothing is; splats, the floor and the
    /// environment are not found.
    ///
    /// If the last picture was of this scene, camera and size, with as many samples, what its rasterizer has kept is asked: 5 to 13
    /// microseconds (models of 23,000 to 100,000 triangles at 1280 x 720). Else vertices and triangles are brought to the screen
    /// first, for this question and those that follow. No picture is drawn.
    ///
    /// # Errors
    /// As [`Renderer::render`]; [`RenderError::Option`] for a pixel outside of the picture.
    pub fn pick(
        &mut self,
        scene: &Scene,
        camera: &Camera,
        options: &RenderOptions,
        pixel: [u32; 2],
    ) -> Result<Option<Hit>, RenderError> {
        self.with_request(scene, camera, options, None, |memory, request| memory.pick(request, pixel))
    }

    /// Lets somebody stop the pictures that follow; `None`: nobody.
    pub fn cancel_by(&mut self, cancellation: Option<Cancellation>) {
        self.jobs.cancel_by(cancellation);
    }

    /// Draws a picture, as a frame or for a screen.
    fn draw(
        &mut self,
        scene: &Scene,
        camera: &Camera,
        options: &RenderOptions,
        display: Option<&DisplayOptions>,
    ) -> Result<Drawn, RenderError> {
        self.with_request(scene, camera, options, display, |memory, request| memory.draw(request))
    }

    /// Carries out a request on a worker, so that work is handed over once and not in every loop.
    fn with_request<T: Send>(
        &mut self,
        scene: &Scene,
        camera: &Camera,
        options: &RenderOptions,
        display: Option<&DisplayOptions>,
        carry_out: impl FnOnce(&mut Memory, &Request<'_>) -> Result<T, RenderError> + Send,
    ) -> Result<T, RenderError> {
        if !arithmetic_is_default() {
            return Err(RenderError::FloatingPointMode);
        }
        check_models(scene, options)?;
        let Self { jobs, fixed, memory } = self;
        let options = fixed.among(options);
        let display = display.map(|display| display.for_lights(scene.brings_light()));
        let display = display.as_ref();
        let (rays_fit, only_planes) = (false, false);
        let request =
            Request { jobs, scene, camera, options: &options, display, rays_fit, relief: None, only_planes };
        jobs.on_worker(|| carry_out(memory, &request))
    }
}

/// Matrices of the camera of a picture.
fn matrices(scene: &Scene, camera: &Camera, options: &RenderOptions) -> Result<CameraMatrices, RenderError> {
    Ok(camera.matrices(scene.origin(), options.width, options.height)?)
}

/// `Ok` if this build has the formulas of every model that the picture is drawn by.
fn check_models(scene: &Scene, options: &RenderOptions) -> Result<(), RenderError> {
    if ShadingModel::ALL.iter().all(|model| model.is_built()) {
        return Ok(());
    }
    let materials = scene.instances().iter().map(|instance| &scene.materials()[instance.material.index()]);
    match materials.map(|material| material.shading(options.shading)).find(|model| !model.is_built()) {
        None => Ok(()),
        Some(model) => Err(RenderError::Option {
            option: "shading",
            value: model.name().to_owned(),
            allowed: "a model that was compiled in: this program was built without it",
        }),
    }
}
