//! A new model each frame, from its file to its pixels, as a warm program that makes thumbnails does it.

use super::report::{Measurement, Model, Times};
use crate::cli::args::BenchArgs;
use crate::cli::failure::{Failure, file_name};
use crate::cli::input::{self, ModelSource};
use crate::cli::materials::Materials;
use crate::cli::picture::is_standard_stream;
use crate::cli::progress::Progress;
use crate::cli::render::{describe, machine, model_source};
use crate::cli::report::{self, Reporter};
use crate::cli::scene_file::SceneFile;
use crate::limits::Limits;
use crate::load::Warning;
use crate::output::{ExrPrecision, OutputFormat, OutputOptions, encode};
use crate::render::{RenderOptions, Rendered, Renderer};
use crate::scene::Environment;
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// Measures frames that load a model each. What does not depend on the model (environment, materials, the renderer) is
/// made once, before the first.
///
/// # Errors
/// [`Failure`] if a model cannot be loaded or rendered.
pub(super) fn run(args: &BenchArgs) -> Result<(), Failure> {
    let reporter = Reporter { quiet: args.report.quiet };
    let progress = Progress::new(args.report.quiet);
    let limits = args.input_options.limits();
    let mut description = describe(args.scene.scene.as_deref(), args.inputs.first().map(AsRef::as_ref))?;
    args.apply(&mut description);
    let paths: Vec<PathBuf> = match args.inputs.as_slice() {
        [] => description.model.iter().cloned().collect(),
        inputs => inputs.to_vec(),
    };
    let mut sources = Vec::new();
    for path in paths {
        if is_standard_stream(&path) {
            return Err(Failure::usage("standard input can be read only once; a model each frame is a file"));
        }
        description.model = Some(path);
        sources.push(model_source(&description, &args.input_options)?);
    }
    let (options, display) = description.options(machine(&args.machine), &limits)?;

    progress.stage("loading");
    let mut renderer = Renderer::new(usize::from(args.machine.threads));
    let materials = Materials::load(&description, &limits, renderer.jobs())?;
    let (environment, warnings) = description.environment(&limits, renderer.jobs())?;
    warnings.iter().for_each(|warning| reporter.warning(warning));
    let output = OutputOptions { display, exr_precision: ExrPrecision::default() };
    let service = Service {
        description: &description,
        materials,
        environment,
        limits: &limits,
        options: &options,
        png: args.png.then_some(&output),
    };

    // The first pass fills caches and grows buffers.
    for (k, source) in sources.iter().enumerate() {
        progress.stage(format!("warming up: {} of {}", k + 1, sources.len()));
        let (_, made) = service.picture(source, &mut renderer)?;
        for warning in &made.warnings {
            reporter.warning(format_args!("{}: {warning}", file_name(&source.path)));
        }
        renderer.recycle(made.rendered.frame);
    }
    let mut measurement = Measurement::default();
    let mut walls = vec![Vec::new(); sources.len()];
    let mut shading = None;
    let rounds = args.rounds.unwrap_or(1);
    for round in 1..=rounds {
        for (k, source) in sources.iter().enumerate() {
            progress.stage(format!("round {round} of {rounds}: {} of {}", k + 1, sources.len()));
            let before = report::processor_time();
            let (wall, made) = service.picture(source, &mut renderer)?;
            measurement.add_frame(wall, [before, report::processor_time()]);
            measurement.add_stage("load", made.load);
            measurement.add_stage("prepare", made.prepare);
            measurement.add_rendered(&made.rendered);
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
                    triangles: made.rendered.stats.triangles,
                    fragments: made.rendered.stats.fragments,
                    frame_ms: Times::new(&mut walls[k]),
                    frame_hash: made.rendered.frame.frame_hash(),
                });
            }
            renderer.recycle(made.rendered.frame);
        }
    }
    drop(progress);
    measurement.print(args, &options, shading.unwrap_or_default(), renderer.jobs().threads())
}

/// What is kept from one model to the next, beside the renderer.
struct Service<'a> {
    description: &'a SceneFile,
    materials: Materials,
    environment: Environment,
    limits: &'a Limits,
    options: &'a RenderOptions,
    /// How pictures are encoded, if they are.
    png: Option<&'a OutputOptions>,
}

/// One model's picture, and the wall time of what the renderer does not measure.
struct Made {
    rendered: Rendered,
    warnings: Vec<Warning>,
    shading: &'static str,
    /// Reading the file.
    load: Duration,
    /// Materials, lights, environment and camera.
    prepare: Duration,
    /// Linear light to the bytes of a PNG file.
    encode: Option<Duration>,
    /// Giving back the scene's memory.
    release: Duration,
}

impl Service<'_> {
    /// From a file to a frame and, if it is asked for, a PNG in memory. Returns how long all of it took.
    fn picture(&self, source: &ModelSource, renderer: &mut Renderer) -> Result<(Duration, Made), Failure> {
        let about = |failure: Failure| failure.at(&source.path);
        let start = Instant::now();
        let loaded = input::load(source, self.limits, renderer.jobs())?;
        let load = start.elapsed();

        let (mut scene, warnings) = (loaded.scene, loaded.warnings);
        self.materials.assign(&mut scene, self.limits).map_err(about)?;
        self.description.light_by(&mut scene, self.environment.clone()).map_err(about)?;
        let camera = self.description.camera(&scene, self.options).map_err(about)?;
        let shading = report::shading_name(self.options.shading, &scene);
        let prepare = start.elapsed() - load;

        let rendered =
            renderer.render(&scene, &camera, self.options).map_err(|e| about(Failure::render(&e)))?;
        let mut encoding = None;
        if let Some(options) = self.png {
            let begin = Instant::now();
            let bytes =
                encode(&rendered.frame, OutputFormat::Png, options).map_err(|e| about(Failure::failed(e)))?;
            // The compiler must not find out that nobody reads them.
            std::hint::black_box(&bytes);
            drop(bytes);
            encoding = Some(begin.elapsed());
        }
        let end = Instant::now();
        drop(scene);
        let release = end.elapsed();
        Ok((start.elapsed(), Made { rendered, warnings, shading, load, prepare, encode: encoding, release }))
    }
}
