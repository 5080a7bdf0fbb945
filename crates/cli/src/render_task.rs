//! Common work of the commands that draw models: from their options to scenes that are ready for the renderer.

use super::args::DrawArgs;
use super::embedded::Embedded;
use super::failure::Failure;
use super::input::{self, ModelSource};
use super::progress::Progress;
use super::report::{self, Reporter, Stages};
use overcoat_core::frame::{Clipping, Frame};
use overcoat_core::frame::{DisplayImage, DisplayOptions};
use overcoat_core::jobs::Jobs;
use overcoat_core::limits::Limits;
use overcoat_description::{Description, EnvironmentChoice, Machine, Materials, Setting};
use overcoat_image::output::OutputFormat;
use overcoat_load::{Loaded, Warning};
use overcoat_render::{Background, RenderOptions, RenderStats, Rendered, RenderedImage, Renderer};
use overcoat_scene::{Camera, Orientation, Scene};
use std::fmt::Display;
use std::path::PathBuf;

impl DrawArgs {
    /// The scene file, if there is one, with the options laid over it and the first of the models in place of its own.
    ///
    /// # Errors
    /// [`Failure`] if the scene file is wrong, or no model is named anywhere.
    pub(super) fn describe(&self, models: &[PathBuf]) -> Result<Description, Failure> {
        let mut description = match (&self.described, &self.scene) {
            (Some(described), _) => (**described).clone(),
            (None, Some(path)) => Description::open(path)?,
            (None, None) => Description::default(),
        };
        if let Some(model) = models.first() {
            description.model = Some(model.clone());
        }
        if let (None, Some(scene)) = (&description.model, &self.scene) {
            return Err(Failure::failed("names no model, and neither does the command line").at(scene));
        }
        self.apply(&mut description);
        Ok(description)
    }
}

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
    pub(super) fn recycle(self, renderer: &mut Renderer) {
        match self {
            Self::Frame(frame) => renderer.recycle(frame),
            Self::Image(image) => renderer.recycle_image(image),
        }
    }
}

/// A picture and what there is to say of it.
pub(super) struct RenderedPicture {
    pub(super) pixels: Pixels,
    /// [`Frame::is_tinted`].
    pub(super) tinted: bool,
    /// White and black pixels, if the scene has lights and the picture is for a screen.
    pub(super) clipping: Clipping,
    /// Stops, where the picture is for a screen.
    pub(super) exposure: f32,
    pub(super) stats: RenderStats,
}

/// One command's work: everything that can be found out and can be wrong before a model is read.
#[derive(Debug)]
pub(super) struct RenderTask {
    pub(super) reporter: Reporter,
    pub(super) progress: Progress,
    /// True if a report goes to standard output.
    pub(super) json: bool,
    /// True if a picture may show nothing.
    pub(super) allow_empty: bool,
    /// When the picture of the file itself is shown.
    pub(super) embedded: Embedded,
    pub(super) limits: Limits,
    /// Description of the picture.
    pub(super) description: Description,
    /// The first model.
    pub(super) source: ModelSource,
    /// The others.
    pub(super) more: Vec<ModelSource>,
    /// All files that pictures are made of, and that must not be overwritten by them.
    pub(super) inputs: Vec<PathBuf>,
    pub(super) options: RenderOptions,
    pub(super) display: DisplayOptions,
}

impl RenderTask {
    /// Checks what [`DrawArgs::describe`] has made of these options and models.
    ///
    /// # Errors
    /// [`Failure`] naming what is wrong.
    pub(super) fn new(
        args: &DrawArgs,
        description: Description,
        models: &[PathBuf],
    ) -> Result<Self, Failure> {
        let progress = Progress::new(args.report.quiet);
        let limits = args.input.limits.limits();
        let paths = if models.is_empty() { description.model.as_slice() } else { models };
        let animation = description.animation_choice()?;
        let source = |path: &PathBuf| {
            let mut source = input::source(&args.input, path)?;
            source.options.animation.clone_from(&animation);
            source.options.up = description.up;
            Ok(source)
        };
        let mut sources = paths.iter().map(source).collect::<Result<Vec<_>, Failure>>()?.into_iter();
        let source = sources.next().ok_or_else(|| Failure::usage("no model is given"))?;
        let more: Vec<ModelSource> = sources.collect();
        let (options, display) =
            description.options(args.machine.machine(), &limits).map_err(|error| match more.len() {
                0 => error.at(&source.path),
                // It is about none of them.
                _ => error,
            })?;
        let mut inputs = paths.to_vec();
        inputs.extend(args.scene.clone());
        if let Some(EnvironmentChoice::File(file)) = &description.env {
            inputs.push(file.clone());
        }
        let materials = description.material_choices();
        inputs.extend(materials.filter_map(|choice| Some(choice.source.file()?.to_owned())));
        let (reporter, json) = (Reporter { quiet: args.report.quiet }, args.report.json);
        let allow_empty = args.allow_empty;
        Ok(Self {
            reporter,
            progress,
            json,
            allow_empty,
            embedded: Embedded::Never,
            limits,
            description,
            source,
            more,
            inputs,
            options,
            display,
        })
    }

    /// The work of one picture of a model that is loaded by others, without a word to a terminal.
    ///
    /// # Errors
    /// [`Failure`] naming what is wrong.
    pub(super) fn quiet(
        description: Description,
        source: ModelSource,
        limits: &Limits,
    ) -> Result<Self, Failure> {
        let (options, display) = description.options(Machine::default(), limits)?;
        Ok(Self {
            reporter: Reporter { quiet: true },
            progress: Progress::new(true),
            json: false,
            allow_empty: false,
            embedded: Embedded::Never,
            limits: limits.clone(),
            description,
            source,
            more: Vec::new(),
            inputs: Vec::new(),
            options,
            display,
        })
    }

    /// Puts white behind the picture if its format has no transparency, and nothing else is to be there.
    pub(super) fn behind_for(&mut self, format: OutputFormat) {
        if format == OutputFormat::Jpeg {
            self.put_behind("JPEG has no transparency");
        }
    }

    /// Puts white behind the picture for this reason, unless something else is to be there.
    pub(super) fn put_behind(&mut self, reason: &str) {
        if self.display.background.is_some() {
            return;
        }
        if self.options.background == Background::Environment {
            return;
        }
        self.display.background = Some([255; 3]);
        if self.description.background.is_some() {
            self.reporter.warning(format_args!("{reason}: white is behind the picture"));
        }
    }

    /// All models.
    pub(super) fn sources(&self) -> impl Iterator<Item = &ModelSource> {
        std::iter::once(&self.source).chain(&self.more)
    }

    /// Materials and environment, which are the same for all models.
    ///
    /// # Errors
    /// [`Failure`] naming the file and the reason.
    pub(super) fn setting(&self, jobs: &Jobs) -> Result<Setting, Failure> {
        Ok(Setting::load(&self.description, &self.limits, jobs)?)
    }

    /// Loads the first model and puts it into its setting.
    ///
    /// # Errors
    /// [`Failure`] naming the file and the reason.
    pub(super) fn load(&self, jobs: &Jobs, stages: &mut Stages) -> Result<Loaded, Failure> {
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
    pub(super) fn load_into(
        &self,
        setting: &Setting,
        source: &ModelSource,
        jobs: &Jobs,
        stages: &mut Stages,
    ) -> Result<Loaded, Failure> {
        let mut loaded = stages.time("load", || input::load(source, &self.limits, jobs))?;
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
    pub(super) fn camera(&self, source: &ModelSource, scene: &Scene) -> Result<Camera, Failure> {
        Ok(self.description.camera(scene, &self.options).map_err(|error| error.at(&source.path))?)
    }

    /// The way to 8 bits for a model's scene.
    pub(super) fn display_of(&self, scene: &Scene) -> DisplayOptions {
        self.description.display_of(scene, &self.display)
    }

    /// Renders a model's scene.
    ///
    /// # Errors
    /// [`Failure`] naming the model and the reason.
    pub(super) fn render(
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
    pub(super) fn render_picture(
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
    pub(super) fn clipping(&self, scene: &Scene, frame: &Frame) -> Clipping {
        if scene.lights().is_empty() {
            return Clipping::default();
        }
        DisplayImage::new(frame, &self.display_of(scene).metered(frame)).clipping(frame)
    }

    /// Ends the work: no more progress, then the warnings.
    pub(super) fn finish(&mut self, warnings: &[Warning]) {
        self.progress.finish();
        warnings.iter().for_each(|warning| self.reporter.warning(warning));
    }

    /// Says so if a model stands on another axis than is usual in files of its format.
    pub(super) fn note_up(&self, orientation: Orientation) {
        if let Some(note) = report::note_of_up(orientation) {
            self.reporter.note(note);
        }
    }

    /// A warning that is about one of several models.
    pub(super) fn warn_of(&self, name: &str, warning: impl Display) {
        self.reporter.warning(format_args!("{name}: {warning}"));
    }
}
