//! One picture as a piece of work: from a description to a scene that is ready, and to pixels.

use crate::failure::Failure;
use crate::model_source::{self, ModelSource};
use crate::report::Stages;
use overcoat_core::frame::{Clipping, Frame};
use overcoat_core::frame::{DisplayImage, DisplayOptions};
use overcoat_core::jobs::Jobs;
use overcoat_core::limits::Limits;
use overcoat_description::{Description, Machine, Materials, Setting};
use overcoat_image::output::OutputFormat;
use overcoat_load::Loaded;
use overcoat_render::{Background, RenderOptions, RenderStats, Rendered, RenderedImage, Renderer};
use overcoat_scene::{Camera, Scene};

/// The pixels of a picture.
#[derive(Clone, Debug)]
pub enum Pixels {
    /// Linear light.
    Frame(Frame),
    /// For a screen.
    Image(DisplayImage),
}

impl Pixels {
    /// Gives the memory back, for the next picture.
    pub fn recycle(self, renderer: &mut Renderer) {
        match self {
            Self::Frame(frame) => renderer.recycle(frame),
            Self::Image(image) => renderer.recycle_image(image),
        }
    }
}

/// A picture and what there is to say of it.
pub struct RenderedPicture {
    /// The picture.
    pub pixels: Pixels,
    /// [`Frame::is_tinted`].
    pub tinted: bool,
    /// White and black pixels, if the scene has lights and the picture is for a screen.
    pub clipping: Clipping,
    /// Stops, where the picture is for a screen.
    pub exposure: f32,
    /// Counts and times of the renderer.
    pub stats: RenderStats,
}

/// Work of one picture: everything that can be found out and can be wrong before a model is read.
#[derive(Debug)]
pub struct PictureTask {
    /// True if the picture may show nothing.
    pub allow_empty: bool,
    /// Limits of the model and the picture.
    pub limits: Limits,
    /// Description of the picture.
    pub description: Description,
    /// The model.
    pub source: ModelSource,
    /// Options of the renderer, as the description has them.
    pub options: RenderOptions,
    /// The way to 8 bits, as the description has it.
    pub display: DisplayOptions,
}

impl PictureTask {
    /// Checks a description.
    ///
    /// # Errors
    /// [`Failure`] naming what is wrong.
    pub fn new(
        description: Description,
        source: ModelSource,
        machine: Machine,
        limits: &Limits,
    ) -> Result<Self, Failure> {
        let (options, display) = description.options(machine, limits)?;
        Ok(Self { allow_empty: false, limits: limits.clone(), description, source, options, display })
    }

    /// Puts white behind the picture if its format has no transparency, and nothing else is to be there. Returns what a user
    /// who has asked for transparency is to be told.
    #[must_use]
    pub fn behind_for(&mut self, format: OutputFormat) -> Option<String> {
        (format == OutputFormat::Jpeg).then(|| self.put_behind("JPEG has no transparency")).flatten()
    }

    /// Puts white behind the picture for this reason, unless something else is to be there. Returns what a user who has asked for
    /// transparency is to be told.
    #[must_use]
    pub fn put_behind(&mut self, reason: &str) -> Option<String> {
        if self.display.background.is_some() || self.options.background == Background::Environment {
            return None;
        }
        self.display.background = Some([255; 3]);
        self.description.background.is_some().then(|| format!("{reason}: white is behind the picture"))
    }

    /// Materials and environment, which are the same for all models.
    ///
    /// # Errors
    /// [`Failure`] naming the file and the reason.
    pub fn setting(&self, jobs: &Jobs) -> Result<Setting, Failure> {
        Ok(Setting::load(&self.description, &self.limits, jobs)?)
    }

    /// Loads the first model and puts it into its setting.
    ///
    /// # Errors
    /// [`Failure`] naming the file and the reason.
    pub fn load(&self, jobs: &Jobs, stages: &mut Stages) -> Result<Loaded, Failure> {
        let materials =
            stages.time("load_materials", || Materials::load(&self.description, &self.limits, jobs))?;
        let environment =
            stages.time("load_environment", || self.description.environment(&self.limits, jobs))?;
        let setting = Setting::new(&self.description, materials, environment);
        self.load_into(&setting, &self.source, jobs, stages)
    }

    /// Loads a model and puts it into its setting. The warnings are those of the model and of the setting.
    ///
    /// # Errors
    /// [`Failure`] naming the file and the reason.
    pub fn load_into(
        &self,
        setting: &Setting,
        source: &ModelSource,
        jobs: &Jobs,
        stages: &mut Stages,
    ) -> Result<Loaded, Failure> {
        let mut loaded = stages.time("load", || model_source::load(source, &self.limits, jobs))?;
        let dressed = stages
            .time("load_materials", || setting.apply(&self.description, &mut loaded.scene, &self.limits));
        dressed.map_err(|error| error.at(&source.path))?;
        loaded.warnings.extend(setting.warnings.iter().cloned());
        Ok(loaded)
    }

    /// The camera for a model's scene.
    ///
    /// # Errors
    /// [`Failure`] if there is no such camera or it spans no view.
    pub fn camera(&self, source: &ModelSource, scene: &Scene) -> Result<Camera, Failure> {
        Ok(self.description.camera(scene, &self.options).map_err(|error| error.at(&source.path))?)
    }

    /// The way to 8 bits for a model's scene.
    pub fn display_of(&self, scene: &Scene) -> DisplayOptions {
        self.description.display_of(scene, &self.display)
    }

    /// Renders a model's scene.
    ///
    /// # Errors
    /// [`Failure`] naming the model and the reason.
    pub fn render(
        &self,
        source: &ModelSource,
        renderer: &mut Renderer,
        scene: &Scene,
        camera: &Camera,
    ) -> Result<Rendered, Failure> {
        let rendered = renderer.render(scene, camera, &self.options);
        rendered.map_err(|e| Failure::render(&e).at(&source.path))
    }

    /// Renders a model's scene: of linear light, or, which is less work, for a screen.
    ///
    /// # Errors
    /// [`Failure`] naming the model and the reason.
    pub fn render_picture(
        &self,
        source: &ModelSource,
        renderer: &mut Renderer,
        scene: &Scene,
        camera: &Camera,
        for_screen: bool,
    ) -> Result<RenderedPicture, Failure> {
        // The picture and what is encoded of it.
        let pixels = u64::from(self.options.width) * u64::from(self.options.height);
        let bytes = pixels * if for_screen { 8 } else { 24 };
        Limits::check_memory(|| format!("a picture of {pixels} pixels"), bytes)
            .map_err(|e| Failure::limit(&e).at(&source.path))?;
        if !for_screen {
            let Rendered { frame, stats, .. } = self.render(source, renderer, scene, camera)?;
            let tinted = frame.is_tinted();
            let exposure = self.display.metered(&frame).exposure;
            let clipping = self.clipping(scene, &frame);
            return Ok(RenderedPicture { pixels: Pixels::Frame(frame), tinted, clipping, exposure, stats });
        }
        let RenderedImage { image, tinted, clipping, exposure, stats, .. } = renderer
            .render_image(scene, camera, &self.options, &self.display_of(scene))
            .map_err(|e| Failure::render(&e).at(&source.path))?;
        Ok(RenderedPicture { pixels: Pixels::Image(image), tinted, clipping, exposure, stats })
    }

    /// Counts of a frame's pixels that are white or black on a screen; zero where the scene has no lights.
    pub fn clipping(&self, scene: &Scene, frame: &Frame) -> Clipping {
        if scene.lights().is_empty() {
            return Clipping::default();
        }
        DisplayImage::new(frame, &self.display_of(scene).metered(frame)).clipping(frame)
    }
}
