//! Warm frames of one model with an orbiting camera.

use super::report::Measurement;
use crate::cli::args::BenchArgs;
use crate::cli::failure::Failure;
use crate::cli::input;
use crate::cli::materials::Materials;
use crate::cli::progress::Progress;
use crate::cli::render::{describe, machine, model_source};
use crate::cli::report::{self, Reporter};
use crate::cli::turntable::orbit;
use crate::render::Renderer;
use std::time::Instant;

/// Measures frames.
///
/// # Errors
/// [`Failure`] if the model cannot be loaded or rendered.
pub(super) fn run(args: &BenchArgs) -> Result<(), Failure> {
    let reporter = Reporter { quiet: args.report.quiet };
    let progress = Progress::new(args.report.quiet);
    let limits = args.input_options.limits();
    let mut description = describe(args.scene.scene.as_deref(), args.inputs.first().map(AsRef::as_ref))?;
    args.apply(&mut description);
    let source = model_source(&description, &args.input_options)?;
    let about = |failure: Failure| failure.at(&source.path);
    let (options, _) = description.options(machine(&args.machine), &limits).map_err(about)?;

    progress.stage("loading");
    let mut renderer = Renderer::new(usize::from(args.machine.threads));
    let materials = Materials::load(&description, &limits, renderer.jobs())?;
    let loaded = input::load(&source, &limits, renderer.jobs())?;
    let mut scene = loaded.scene;
    materials.assign(&mut scene, &limits).map_err(about)?;
    for warning in description.light(&mut scene, &limits, renderer.jobs())? {
        reporter.warning(warning);
    }
    let camera = description.camera(&scene, &options).map_err(about)?;
    let center = scene.bounds().center();
    let render = |renderer: &mut Renderer, angle: f64| {
        let camera = orbit(&camera, center, angle);
        let start = Instant::now();
        let rendered = renderer.render(&scene, &camera, &options).map_err(|e| about(Failure::render(&e)))?;
        Ok::<_, Failure>((start.elapsed(), rendered))
    };

    // The first frame fills caches and grows buffers.
    let first = render(&mut renderer, 0.0)?.1;
    renderer.recycle(first.frame);
    progress.stage(format!("{} frames", args.frames));
    let mut measurement = Measurement::default();
    for k in 0..args.frames {
        let before = report::processor_time();
        let (wall, rendered) =
            render(&mut renderer, f64::from(k) * std::f64::consts::TAU / f64::from(args.frames))?;
        measurement.add_frame(wall, [before, report::processor_time()]);
        measurement.add_rendered(&rendered);
        renderer.recycle(rendered.frame);
    }
    drop(progress);
    for warning in &loaded.warnings {
        reporter.warning(warning);
    }
    let shading = report::shading_name(options.shading, &scene);
    measurement.print(args, &options, shading, renderer.jobs().threads())
}
