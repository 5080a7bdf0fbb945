//! Warm frames of one model with an orbiting camera.

use super::report::{Hash, Measurement};
use crate::args::BenchArgs;
use crate::failure::Failure;
use crate::render_task::RenderTask;
use overcoat_load::Loaded;
use overcoat_render::Renderer;
use overcoat_worker::report::Stages;
use overcoat_worker::resources;
use overcoat_worker::turning::orbit;
use std::time::Instant;

/// Measures frames.
///
/// # Errors
/// [`Failure`] if the model cannot be loaded or rendered.
pub(super) fn run(args: &BenchArgs) -> Result<(), Failure> {
    let mut task = RenderTask::new(&args.draw, super::describe(args)?, &args.inputs)?;
    task.progress.stage("loading");
    let mut renderer = args.draw.renderer();
    let Loaded { scene, mut warnings, .. } = task.picture.load(renderer.jobs(), &mut Stages::default())?;
    let camera = task.picture.camera(&task.picture.source, &scene)?;
    let center = scene.bounds().center();
    let render = |renderer: &mut Renderer, angle: f64| {
        let camera = orbit(&camera, center, angle);
        let start = Instant::now();
        let taken =
            task.picture.render_picture(&task.picture.source, renderer, &scene, &camera, args.image)?;
        Ok::<_, Failure>((start.elapsed(), taken))
    };

    // The first frame fills caches and grows buffers.
    let first = render(&mut renderer, 0.0)?.1;
    let coverage = task.picture.check_coverage(&task.picture.source, &scene, &camera, &first.stats)?;
    warnings.extend(coverage);
    first.pixels.recycle(&mut renderer);
    task.progress.stage(format!("{} frames", args.frames));
    let mut measurement = Measurement::default();
    for k in 0..args.frames {
        let before = resources::processor_time();
        let (wall, taken) =
            render(&mut renderer, f64::from(k) * std::f64::consts::TAU / f64::from(args.frames))?;
        measurement.add_frame(wall, [before, resources::processor_time()]);
        measurement.add_picture(&taken.stats, &Hash::new(&taken.pixels));
        taken.pixels.recycle(&mut renderer);
    }
    task.finish(&warnings);
    measurement.warnings.extend(warnings.iter().map(ToString::to_string));
    let shading = overcoat_worker::report::shading_name(task.picture.options.shading, &scene);
    measurement.print(task.json, &task.picture.options, shading, renderer.jobs().threads())
}
