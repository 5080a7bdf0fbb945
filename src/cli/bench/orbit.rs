//! Warm frames of one model with an orbiting camera.

use super::report::Measurement;
use crate::cli::args::BenchArgs;
use crate::cli::failure::Failure;
use crate::cli::input;
use crate::cli::materials::Materials;
use crate::cli::progress::Progress;
use crate::cli::render::{describe, machine, model_source};
use crate::cli::report::{self, Reporter};
use crate::math::double::sin_cos;
use crate::render::Renderer;
use crate::scene::Camera;
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

/// The camera turned about the vertical axis through a point.
fn orbit(camera: &Camera, center: [f64; 3], angle: f64) -> Camera {
    let (sin, cos) = sin_cos(angle);
    let center = if center.iter().all(|v| v.is_finite()) { center } else { [0.0; 3] };
    let turn = |p: [f32; 3], about: [f64; 3]| {
        let [x, z] = [f64::from(p[0]) - about[0], f64::from(p[2]) - about[2]];
        [(about[0] + cos * x + sin * z) as f32, p[1], (about[2] - sin * x + cos * z) as f32]
    };
    Camera {
        eye: turn(camera.eye, center),
        target: turn(camera.target, center),
        up: turn(camera.up, [0.0; 3]),
        ..*camera
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Projection;

    #[test]
    fn the_camera_keeps_its_distance() {
        let camera = Camera {
            eye: [3.0, 2.0, 5.0],
            target: [1.0, 0.5, 0.0],
            up: [0.0, 1.0, 0.0],
            projection: Projection::Perspective { fov_y: 0.5 },
            near: 0.1,
        };
        let quarter = orbit(&camera, [1.0, 0.0, 1.0], std::f64::consts::FRAC_PI_2);
        assert_eq!(quarter.eye, [5.0, 2.0, -1.0]);
        assert_eq!(orbit(&camera, [1.0, 0.0, 1.0], 0.0), camera);
    }
}
