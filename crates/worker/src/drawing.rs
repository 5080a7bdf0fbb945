//! The pictures of one model.

use crate::annotation_report::annotations;
use crate::contents::Contents;
use crate::description_of;
use crate::diagnosis::Diagnosis;
use crate::failure::Failure;
use crate::files::AskedFiles;
use crate::losses::{left_out, limited, losses, texture_losses};
use crate::model_facts::ModelFacts;
use crate::model_source::ModelSource;
use crate::picture_format::PictureFormat;
use crate::picture_task::{PictureTask, Pixels, RenderedPicture};
use crate::pipe::Pipe;
use crate::protocol::{FromWorker, PictureRequest, Start, ToWorker, Told, Turntable, Work};
use crate::render_report::{self, RenderReport};
use crate::report::Stages;
use crate::resources::peak_rss_bytes;
use crate::turntable;
use overcoat_core::frame::{Aov, DisplayOptions, Meter};
use overcoat_core::limits::Limits;
use overcoat_description::{Description, Machine, Setting};
use overcoat_image::output::{
    DEFAULT_JPEG_QUALITY, MovieFormat, OutputFormat, OutputOptions, encode, encode_aov_png, encode_image,
};
use overcoat_load::{Context, LoadOptions, Loaded, TextureLoading, Warning, load_named_bytes};
use overcoat_render::Renderer;
use overcoat_scene::Scene;
use serde_json::Value;
use std::path::Path;
use std::time::Instant;
use xxhash_rust::xxh3::xxh3_128;

/// State that a worker keeps from one model to the next.
pub(crate) struct Drawing<'a> {
    pub(crate) pipe: &'a Pipe,
    pub(crate) start: Start,
    pub(crate) limits: Limits,
    pub(crate) renderer: Renderer,
    /// Materials and environment of the last picture, and what asked for them: scenes that share it share the filtered environment.
    pub(crate) setting: Option<(Description, Setting)>,
}

/// A picture that can be begun.
struct Planned {
    description: Description,
    options: LoadOptions,
    format: PlannedFormat,
    aovs: Vec<Aov>,
}

/// Format of the file of a picture.
#[derive(Clone, Copy)]
enum PlannedFormat {
    Still(OutputFormat),
    Turn(MovieFormat, Turntable),
}

/// A model in its setting.
pub(crate) struct Dressed {
    /// The picture that it was made for, without what cameras and screens see of it.
    of: Description,
    pub(crate) scene: Scene,
    pub(crate) warnings: Vec<Warning>,
}

impl Drawing<'_> {
    /// Loads a model and draws what is asked for.
    pub(crate) fn draw(&mut self, work: &Work, bytes: &[u8]) -> Result<(), Failure> {
        let planned: Vec<Result<Planned, Failure>> =
            work.pictures.iter().map(|request| self.plan(request)).collect();
        let mut wanted: Vec<usize> = (0..planned.len()).collect();
        let mut stages = Stages::default();
        // If the plans of all pictures have failed, the model is not read.
        let Some(first) = planned.iter().find_map(|plan| plan.as_ref().ok()) else {
            return wanted.iter().try_for_each(|&k| self.tell_failure(k, &planned[k]));
        };
        let mut dressed = Some(self.load(work, bytes, first, &mut stages)?);
        if work.waits {
            match self.pipe.ask(&FromWorker::Loaded) {
                Ok(Some((ToWorker::Draw { pictures }, _))) => wanted = pictures,
                _ => return Err(Failure::failed("the parent does not say what to draw")),
            }
        }
        for k in wanted {
            let Some(Ok(plan)) = planned.get(k) else {
                self.tell_failure(k, planned.get(k).unwrap_or(&Err(Failure::usage("no such picture"))))?;
                continue;
            };
            let drawn = match dressed.take().filter(|dressed| dressed.of == scene_part(&plan.description)) {
                Some(dressed) => Ok(dressed),
                None => self.load(work, bytes, plan, &mut stages),
            }
            .and_then(|mut model| {
                let request = &work.pictures[k];
                let drawn = match plan.format {
                    _ if request.diagnose => self.diagnose(k, &work.name, plan, &mut model),
                    PlannedFormat::Still(format) => {
                        self.draw_one((k, request, format), work, plan, &model, &mut stages)
                    }
                    PlannedFormat::Turn(format, turntable) => {
                        let Planned { description, options, .. } = plan;
                        let turn = turntable::Plan { description, options, format, turntable };
                        // Its light has turned.
                        return self.draw_turn(k, work, &turn, &mut model, &mut stages);
                    }
                };
                dressed = Some(model);
                drawn
            });
            if let Err(failure) = drawn {
                self.pipe.send(&FromWorker::PictureFailed { picture: k, failure: (&failure).into() }, &[])?;
            }
            stages = Stages::default();
        }
        Ok(())
    }

    /// Loads a model and tells what is in it.
    pub(crate) fn inspect(
        &mut self,
        name: &str,
        bytes: &[u8],
        converted: (Option<String>, &[String]),
    ) -> Result<(), Failure> {
        let jobs = self.renderer.jobs();
        let files = AskedFiles { pipe: self.pipe, model: name };
        let context = Context { resolver: &files, limits: &self.limits, jobs };
        let options = LoadOptions::default().with_variant(self.start.variant.clone());
        let contents = Contents::json_of_bytes(bytes, Path::new(name), converted, &options, &context)?;
        self.pipe.send(&FromWorker::Contents, &contents)
    }

    fn tell_failure(&self, picture: usize, plan: &Result<Planned, Failure>) -> Result<(), Failure> {
        let Err(failure) = plan else { return Ok(()) };
        self.pipe.send(&FromWorker::PictureFailed { picture, failure: failure.into() }, &[])
    }

    /// Finds out what can be wrong with a request.
    fn plan(&self, request: &PictureRequest) -> Result<Planned, Failure> {
        let description = self.describe(request)?;
        let options = description.load_options()?.with_textures(TextureLoading::ByNeed);
        let options = options.with_variant(self.start.variant.clone());
        description.options(Machine::default(), &self.limits)?;
        let format = match &request.turntable {
            Some(turn) => PlannedFormat::Turn(turntable::format_of(&request.format, turn)?, *turn),
            None => {
                PlannedFormat::Still(OutputFormat::from_extension(&request.format).ok_or_else(|| {
                    Failure::usage(format!("'{}' is no format of pictures", request.format))
                })?)
            }
        };
        if request.jpeg_quality.is_some_and(|quality| !(1..=100).contains(&quality)) {
            return Err(Failure::usage("jpeg_quality: expected 1 to 100"));
        }
        let plane = |name: &String| {
            let found = Aov::ALL.iter().copied().find(|aov| aov.name() == name);
            found.ok_or_else(|| Failure::usage(format!("'{name}' is no plane of pictures")))
        };
        let aovs = request.aovs.iter().map(plane).collect::<Result<_, _>>()?;
        Ok(Planned { description, options, format, aovs })
    }

    /// The keys of a request laid over those of all pictures.
    fn describe(&self, request: &PictureRequest) -> Result<Description, Failure> {
        if request.keys.contains_key("model") {
            return Err(Failure::usage("model: a picture is of the model that it is asked of"));
        }
        let mut all = match &self.start.description {
            Value::Object(common) => common.clone(),
            _ => serde_json::Map::new(),
        };
        all.extend(request.keys.clone());
        if let Some(env) = request.keys.get("env").and_then(Value::as_str)
            && let Some(path) = self.start.environments.get(env)
        {
            all.insert("env".to_owned(), path.to_string_lossy().into());
        }
        let description = description_of(&Value::Object(all));
        // It comes from whoever asks, not from a file.
        description.map_err(|failure| match failure.exit_code() {
            1 => Failure::usage(failure),
            _ => failure,
        })
    }

    /// Loads the model as a picture shows it.
    fn load(
        &mut self,
        work: &Work,
        bytes: &[u8],
        plan: &Planned,
        stages: &mut Stages,
    ) -> Result<Dressed, Failure> {
        let path = Path::new(&work.name);
        let jobs = self.renderer.jobs();
        let files = AskedFiles { pipe: self.pipe, model: &work.name };
        let context = Context { resolver: &files, limits: &self.limits, jobs };
        let loaded = stages.time("load", || load_named_bytes(bytes, path, &plan.options, &context));
        let of_converter = |failure: Failure| match &work.converter {
            Some(name) => failure.of_converter(name),
            None => failure,
        };
        let Loaded { mut scene, mut warnings, .. } =
            loaded.map_err(|e| of_converter(Failure::load(&e)).at(path))?;
        warnings.extend(work.warnings.iter().map(Warning::new));
        let of = scene_part(&plan.description);
        let limits = &self.limits;
        let asked = setting_part(&of);
        if self.setting.as_ref().is_none_or(|(known, _)| *known != asked) {
            let setting = stages.time("load_environment", || Setting::load(&asked, limits, jobs))?;
            self.setting = Some((asked, setting));
        }
        if let Some((_, setting)) = &self.setting {
            setting.apply(&plan.description, &mut scene, limits).map_err(|error| error.at(path))?;
            warnings.extend(setting.warnings.iter().cloned());
        }
        Ok(Dressed { of, scene, warnings })
    }

    /// Looks for faults of a picture and tells them.
    fn diagnose(
        &mut self,
        number: usize,
        name: &str,
        plan: &Planned,
        model: &mut Dressed,
    ) -> Result<(), Failure> {
        let source =
            ModelSource { path: name.into(), format: None, options: plan.options.clone(), conversion: None };
        let task = PictureTask::new(plan.description.clone(), source, Machine::default(), &self.limits)?;
        let Dressed { scene, warnings, .. } = model;
        let diagnosis = Diagnosis::new(&task, &task.source, &mut self.renderer, scene, warnings.clone())?;
        let told = Told {
            width: task.options.width,
            height: task.options.height,
            facts: None,
            peak_rss_bytes: peak_rss_bytes(),
            report: Some(serde_json::to_value(diagnosis).map_err(Failure::failed)?),
            warnings: Vec::new(),
            stages_ms: Value::Null,
        };
        self.pipe.send(&FromWorker::Picture { picture: number, told: Box::new(told) }, &[])
    }

    /// Draws a picture and hands it over.
    fn draw_one(
        &mut self,
        (number, request, format): (usize, &PictureRequest, OutputFormat),
        work: &Work,
        plan: &Planned,
        model: &Dressed,
        stages: &mut Stages,
    ) -> Result<(), Failure> {
        let start = Instant::now();
        let aovs = &plan.aovs;
        let source = ModelSource {
            path: (&work.name).into(),
            format: None,
            options: plan.options.clone(),
            conversion: None,
        };
        let mut task = PictureTask::new(plan.description.clone(), source, Machine::default(), &self.limits)?;
        task.allow_empty = self.start.allow_empty;
        let behind = task.behind_for(format);
        task.options.aovs.clone_from(aovs);
        let (scene, source) = (&model.scene, &task.source);
        let camera = task.camera(source, scene)?;
        let for_screen = !format.is_linear() && aovs.is_empty() && !request.report;
        let RenderedPicture { pixels, tinted, clipping, exposure, stats } =
            task.render_picture(source, &mut self.renderer, scene, &camera, for_screen)?;
        stats.stages().iter().for_each(|&(name, time)| stages.add(name, time));
        let display = task.display_of(scene);
        let shading = task.options.shading;
        let mut warnings = model.warnings.clone();
        warnings.extend(behind.map(Warning::new));
        warnings.extend(texture_losses(scene, &warnings));
        warnings.extend(match format.is_linear() {
            true => left_out(scene, shading).collect(),
            false => losses(scene, shading, (&display, exposure), tinted, clipping),
        });
        warnings.extend(limited(&stats));
        warnings.extend(task.check_coverage(source, scene, &camera, &stats)?);
        let display = display.with_exposure(exposure).with_meter(Meter::Never);
        let begun = Instant::now();
        let (files, encoded) = encode_files(&pixels, format, aovs, request.jpeg_quality, &display)?;
        stages.add("encode", begun.elapsed());
        let report = match &pixels {
            Pixels::Frame(frame) if request.report => {
                let ids = annotations(
                    &mut self.renderer,
                    scene,
                    &camera,
                    &task.options,
                    frame,
                    (stages, &mut warnings),
                )?;
                let told = render_report::Told {
                    task: &task,
                    scene,
                    camera: &camera,
                    stats: &stats,
                    format: PictureFormat::File(format),
                    frame_hash: frame.frame_hash(),
                    encoded,
                    exposure,
                    threads: self.renderer.jobs().threads(),
                    ids,
                };
                let report = RenderReport::new(&told, stages.clone(), start.elapsed(), warnings.clone());
                Some(serde_json::to_value(report).map_err(Failure::failed)?)
            }
            _ => None,
        };
        let told = Told {
            width: task.options.width,
            height: task.options.height,
            warnings: warnings.into_iter().map(|warning| warning.message).collect(),
            stages_ms: serde_json::to_value(&*stages).map_err(Failure::failed)?,
            facts: work.facts.then(|| ModelFacts::new(scene, &pixels, &display)),
            peak_rss_bytes: peak_rss_bytes(),
            report,
        };
        pixels.recycle(&mut self.renderer);
        for (plane, media_type, bytes) in files {
            let file = FromWorker::File { picture: number, plane, media_type: media_type.to_owned() };
            self.pipe.send(&file, &bytes)?;
        }
        self.pipe.send(&FromWorker::Picture { picture: number, told: Box::new(told) }, &[])
    }
}

/// Part of a description that changes the scene, or what is read for it. All else is the camera's, the renderer's or
/// the screen's.
fn scene_part(of: &Description) -> Description {
    Description {
        up: of.up,
        env: of.env.clone(),
        env_rotation_degrees: of.env_rotation_degrees,
        env_intensity: of.env_intensity,
        lights: of.lights,
        lights_to_add: of.lights_to_add.clone(),
        animation: of.animation.clone(),
        time: of.time,
        repeat: of.repeat,
        material: of.material.clone(),
        materials: of.materials.clone(),
        more_materials: of.more_materials.clone(),
        ..Description::default()
    }
}

/// Part of a description that is the same for all models: materials and environment.
fn setting_part(of: &Description) -> Description {
    Description {
        env: of.env.clone(),
        env_rotation_degrees: of.env_rotation_degrees,
        env_intensity: of.env_intensity,
        material: of.material.clone(),
        materials: of.materials.clone(),
        more_materials: of.more_materials.clone(),
        ..Description::default()
    }
}

/// A file: the plane that it holds, if it is none of all, its media type and its bytes.
type EncodedFile = (Option<String>, &'static str, Vec<u8>);

/// The files of a picture, its own last, and a hash of that.
fn encode_files(
    pixels: &Pixels,
    format: OutputFormat,
    aovs: &[Aov],
    jpeg_quality: Option<u8>,
    display: &DisplayOptions,
) -> Result<(Vec<EncodedFile>, u128), Failure> {
    let options = OutputOptions::default()
        .with_display(display.clone())
        .with_jpeg_quality(jpeg_quality.unwrap_or(DEFAULT_JPEG_QUALITY));
    let mut files: Vec<EncodedFile> = Vec::new();
    let bytes = match pixels {
        Pixels::Frame(frame) => {
            // They are layers of the other.
            let apart = aovs.iter().filter(|_| format != OutputFormat::Exr);
            for aov in apart {
                let bytes = encode_aov_png(frame, *aov).map_err(Failure::failed)?;
                files.push((Some(aov.name().to_owned()), OutputFormat::Png.file_format().mime_type, bytes));
            }
            encode(frame, format, &options)
        }
        Pixels::Image(image) => encode_image(image, format, &options),
    };
    let bytes = bytes.map_err(Failure::failed)?;
    let hash = xxh3_128(&bytes);
    files.push((None, format.file_format().mime_type, bytes));
    Ok((files, hash))
}
