//! A new model each frame, from its file to its pixels, as a warm program that makes thumbnails does it.

use super::report::{Hash, Measurement, Model, Times};
use crate::args::BenchArgs;
use crate::failure::{Failure, file_name};
use crate::render_task::RenderTask;
use overcoat_description::{Setting, is_standard_input};
use overcoat_image::output::encode_png;
use overcoat_load::{Loaded, Warning, has_folder};
use overcoat_render::{RenderStats, Renderer};
use overcoat_worker::model_source::{ModelSource, load};
use overcoat_worker::picture_task::{PictureTask, Pixels, RenderedPicture};
use overcoat_worker::resources;
use std::time::{Duration, Instant};

/// Measures frames that load a model each. What does not depend on the model (environment, materials, the renderer) is
/// made once, before the first.
///
/// # Errors
/// [`Failure`] if a model cannot be loaded or rendered.
pub(super) fn run(args: &BenchArgs) -> Result<(), Failure> {
    let mut task = RenderTask::new(&args.draw, super::describe(args)?, &args.inputs)?;
    if task.sources().any(|source| is_standard_input(&source.path) || !has_folder(&source.path)) {
        return Err(Failure::usage(
            "standard input and pipes can be read only once; a model each frame is a file",
        ));
    }
    task.progress.stage("loading");
    let mut renderer = args.draw.renderer();
    let setting = task.picture.setting(renderer.jobs())?;
    let mut measurement = Measurement::default();
    setting.warnings.iter().for_each(|warning| task.reporter.tell(warning));
    measurement.warnings.extend(setting.warnings.iter().map(ToString::to_string));
    let service = Service { task: &task, setting, for_screen: args.image || args.png, png: args.png };
    let models = task.sources().count();

    // The first pass fills caches and grows buffers.
    for (k, source) in task.sources().enumerate() {
        task.progress.stage(format!("warming up: {} of {models}", k + 1));
        let (_, made) = service.picture(source, &mut renderer)?;
        for warning in &made.warnings {
            let name = file_name(&source.path);
            task.warn_of(&name, warning);
            measurement.warnings.push(format!("{name}: {warning}"));
        }
        made.pixels.recycle(&mut renderer);
    }
    let mut walls = vec![Vec::new(); models];
    let mut shading = None;
    let rounds = args.rounds.unwrap_or(1);
    for round in 1..=rounds {
        for (k, source) in task.sources().enumerate() {
            task.progress.stage(format!("round {round} of {rounds}: {} of {models}", k + 1));
            let before = resources::processor_time();
            let (wall, made) = service.picture(source, &mut renderer)?;
            measurement.add_frame(wall, [before, resources::processor_time()]);
            measurement.add_stage("load", made.load);
            measurement.add_stage("prepare", made.prepare);
            let hash = Hash::new(&made.pixels);
            measurement.add_picture(&made.stats, &hash);
            if let Some(time) = made.encode {
                measurement.add_stage("encode", time);
            }
            measurement.add_stage("release", made.release);
            walls[k].push(wall);
            shading = match shading {
                Some(name) if name != made.shading => Some("by material"),
                _ => Some(made.shading),
            };
            if round == rounds {
                measurement.models.push(Model {
                    file: file_name(&source.path),
                    triangles: made.stats.triangles,
                    fragments: made.stats.fragments,
                    frame_ms: Times::new(&mut walls[k]),
                    hash,
                });
            }
            made.pixels.recycle(&mut renderer);
        }
    }
    task.finish(&[]);
    let shading = shading.unwrap_or_default();
    measurement.print(task.json, &task.picture.options, shading, renderer.jobs().threads())
}

/// State kept from one model to the next, beside the renderer.
struct Service<'a> {
    task: &'a RenderTask,
    setting: Setting,
    /// Pictures are of 8 bits.
    for_screen: bool,
    /// They are encoded.
    png: bool,
}

/// One model's picture, and the wall time of what the renderer does not measure.
struct Made {
    pixels: Pixels,
    stats: RenderStats,
    warnings: Vec<Warning>,
    shading: &'static str,
    /// Reading the file.
    load: Duration,
    /// Materials, lights, environment and camera.
    prepare: Duration,
    /// To the bytes of a PNG file.
    encode: Option<Duration>,
    /// Giving back the scene's memory.
    release: Duration,
}

impl Service<'_> {
    /// From a file to a frame and, if it is asked for, a PNG in memory. Returns how long all of it took.
    fn picture(&self, source: &ModelSource, renderer: &mut Renderer) -> Result<(Duration, Made), Failure> {
        let PictureTask { description, options, limits, .. } = &self.task.picture;
        let about = |failure: Failure| failure.at(&source.path);
        let start = Instant::now();
        let Loaded { mut scene, mut warnings, .. } = load(source, limits, renderer.jobs())?;
        let load = start.elapsed();

        self.setting.apply(description, &mut scene, limits).map_err(|e| about(e.into()))?;
        let camera = self.task.picture.camera(source, &scene)?;
        let shading = overcoat_worker::report::shading_name(options.shading, &scene);
        let prepare = start.elapsed() - load;

        let RenderedPicture { pixels, stats, .. } =
            self.task.picture.render_picture(source, renderer, &scene, &camera, self.for_screen)?;
        if stats.covered == 0 {
            warnings.extend(self.task.picture.check_coverage(source, &scene, &camera, &stats)?);
        }
        let mut encoding = None;
        if let (true, Pixels::Image(image)) = (self.png, &pixels) {
            let begin = Instant::now();
            let bytes = encode_png(image).map_err(|e| about(Failure::failed(e)))?;
            // The compiler must not find out that nobody reads them.
            std::hint::black_box(&bytes);
            drop(bytes);
            encoding = Some(begin.elapsed());
        }
        let end = Instant::now();
        drop(scene);
        let release = end.elapsed();
        Ok((
            start.elapsed(),
            Made { pixels, stats, warnings, shading, load, prepare, encode: encoding, release },
        ))
    }
}
