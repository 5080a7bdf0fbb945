//! Common work of the commands that draw models: from their options to pieces of work.

use super::args::DrawArgs;
use super::embedded::Embedded;
use super::failure::Failure;
use super::input;
use super::progress::Progress;
use super::report::Reporter;
use overcoat_description::{Description, EnvironmentChoice};
use overcoat_image::output::OutputFormat;
use overcoat_load::Warning;
use overcoat_scene::Orientation;
use overcoat_worker::codes;
use overcoat_worker::model_source::ModelSource;
use overcoat_worker::picture_task::PictureTask;
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

/// One command's work: its picture, and how it talks of it.
#[derive(Debug)]
pub(super) struct RenderTask {
    pub(super) reporter: Reporter,
    pub(super) progress: Progress,
    /// True if a report goes to standard output.
    pub(super) json: bool,
    /// When the picture of the file itself is shown.
    pub(super) embedded: Embedded,
    /// The picture, of the first model.
    pub(super) picture: PictureTask,
    /// The other models.
    pub(super) more: Vec<ModelSource>,
    /// All files that pictures are made of, and that must not be overwritten by them.
    pub(super) inputs: Vec<PathBuf>,
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
        let mut more: Vec<ModelSource> = sources.collect();
        let mut inputs = paths.to_vec();
        inputs.extend(args.scene.clone());
        if let Some(EnvironmentChoice::File(file)) = &description.env {
            inputs.push(file.clone());
        }
        let materials = description.material_choices();
        inputs.extend(materials.filter_map(|choice| Some(choice.source.file()?.to_owned())));
        let (machine, path) = (args.machine.machine(), source.path.clone());
        let picture =
            PictureTask::new(description, source, machine, &limits).map_err(|failure| match more.len() {
                0 => failure.at(&path),
                // It is about none of them.
                _ => failure,
            })?;
        let mut picture = PictureTask { allow_empty: args.allow_empty, ..picture };
        let pixels = picture.options.width.max(picture.options.height);
        for conversion in
            [&mut picture.source].into_iter().chain(&mut more).filter_map(|s| s.conversion.as_mut())
        {
            conversion.pixels = pixels;
        }
        let (reporter, json) = (Reporter { quiet: args.report.quiet }, args.report.json);
        Ok(Self { reporter, progress, json, embedded: Embedded::Never, picture, more, inputs })
    }

    /// Puts white behind the picture if its format has no transparency, and nothing else is to be there.
    pub(super) fn behind_for(&mut self, format: OutputFormat) {
        let told = self.picture.behind_for(format);
        told.iter().for_each(|told| self.reporter.warning(told));
    }

    /// Puts white behind the picture for this reason, unless something else is to be there.
    pub(super) fn put_behind(&mut self, reason: &str) {
        let told = self.picture.put_behind(reason);
        told.iter().for_each(|told| self.reporter.warning(told));
    }

    /// All models.
    pub(super) fn sources(&self) -> impl Iterator<Item = &ModelSource> {
        std::iter::once(&self.picture.source).chain(&self.more)
    }

    /// Ends the work: no more progress, then the warnings.
    pub(super) fn finish(&mut self, warnings: &[Warning]) {
        self.progress.finish();
        warnings.iter().for_each(|warning| self.reporter.tell(warning));
    }

    /// Says so if a model stands on another axis than is usual in files of its format.
    pub(super) fn note_up(&self, orientation: Orientation) {
        if let Some(note) = overcoat_worker::report::note_of_up(orientation) {
            self.reporter.note_of(codes::UP_BY_SHAPE, note);
        }
    }

    /// A warning that is about one of several models.
    pub(super) fn warn_of(&self, name: &str, warning: impl Display) {
        self.reporter.warning(format_args!("{name}: {warning}"));
    }
}
