//! `overcoat turntable`: a model once around.

use super::args::{Turn, TurntableArgs};
use super::failure::{Failure, file_name};
use super::input;
use super::materials::Materials;
use super::movie::{Movie, MovieTarget};
use super::progress::Progress;
use super::render::{describe, input_paths, left_out, machine, model_source, nothing_to_see};
use super::report::{self, MovieReport, Reporter};
use crate::limits::Limits;
use crate::math::double::sin_cos;
use crate::render::Renderer;
use crate::scene::{Camera, Environment, Fit, Light, LightKind, Scene, Transform};
use std::f64::consts::TAU;

/// Directions from which a model is fitted into the picture at most: the camera would have to be farther away by less than
/// a thousandth for others.
const DIRECTIONS: u32 = 72;

/// Renders one turn.
///
/// # Errors
/// [`Failure`]; nothing is written then.
pub fn run(args: &TurntableArgs) -> Result<(), Failure> {
    let reporter = Reporter { quiet: args.report.quiet };
    let progress = Progress::new(args.report.quiet);
    let limits = args.input_options.limits();
    let mut description = describe(args.scene.scene.as_deref(), args.input.as_deref())?;
    args.animation.apply(&mut description);
    args.camera.apply(&mut description);
    args.light.apply(&mut description);
    args.picture.apply(&mut description);
    args.display.apply(&mut description);
    let source = model_source(&description, &args.input_options)?;
    let about = |failure: Failure| failure.at(&source.path);
    let paths = input_paths(&description, args.scene.scene.as_deref(), &source.path);
    let inputs: Vec<&std::path::Path> = paths.iter().map(AsRef::as_ref).collect();
    let target = MovieTarget::new(&args.output, &inputs)?;
    if target.is_standard_output() && args.report.json {
        return Err(Failure::usage("--json and the picture cannot both go to standard output"));
    }
    let frames = match args.frames {
        Some(frames) => frames,
        None => frame_count(args.seconds.unwrap_or(3.0), args.fps),
    };
    Limits::check(|| "turntable".to_owned(), frames.into(), limits.frames, "frames")
        .map_err(|e| Failure::limit(&e))?;
    target.check(frames as usize, &inputs)?;
    let (options, display) = description.options(machine(&args.machine), &limits).map_err(about)?;

    progress.stage(format!("loading {}", file_name(&source.path)));
    let mut renderer = Renderer::new(usize::from(args.machine.threads));
    let materials = Materials::load(&description, &limits, renderer.jobs())?;
    let loaded = input::load(&source, &limits, renderer.jobs())?;
    let (mut scene, mut warnings) = (loaded.scene, loaded.warnings);
    materials.assign(&mut scene, &limits).map_err(about)?;
    let (environment, doubtful) = description.environment(&limits, renderer.jobs())?;
    warnings.extend(doubtful);
    let own_lights = if description.lights == Some(false) { 0 } else { scene.lights().len() };
    description.light_by(&mut scene, environment.clone()).map_err(about)?;
    let lights = scene.lights().to_vec();

    let bounds = scene.bounds();
    let center = if bounds.is_empty() { [0.0; 3] } else { bounds.center() };
    let camera = match description.framing(&scene, &options) {
        None => description.camera(&scene, &options),
        Some(framing) => {
            let mut fit = Fit::new(framing);
            let directions = frames.min(DIRECTIONS);
            for k in 0..directions {
                let by = turned(center, TAU * f64::from(k) / f64::from(directions));
                by.map(|by| fit.include_moved(&scene, &by)).map_err(|e| about(Failure::scene(&e)))?;
            }
            description.fitted(fit.camera())
        }
    }
    .map_err(about)?;

    let mut movie = Movie::new(&target, &display, &limits);
    let mut empty = None;
    for k in 0..frames {
        progress.step(format!("frame {} of {frames}", k + 1), k, frames);
        let angle = TAU * f64::from(k) / f64::from(frames);
        let eye = match args.turn {
            Turn::Camera => orbit(&camera, center, angle),
            // What stays while the model turns goes around it the other way.
            Turn::Model => {
                turn_light(&mut scene, &environment, &lights, own_lights, center, -angle).map_err(about)?;
                orbit(&camera, center, -angle)
            }
        };
        let rendered = renderer.render(&scene, &eye, &options).map_err(|e| about(Failure::render(&e)))?;
        movie.push(&rendered.frame)?;
        // One frame that shows something is enough.
        let nothing = nothing_to_see(&scene, &rendered.stats);
        empty = if k == 0 { nothing } else { empty.and(nothing) };
        renderer.recycle(rendered.frame);
    }
    warnings.extend(left_out(&scene, options.shading));
    warnings.extend(empty);

    progress.stage("encoding");
    let (encoded, frames_hash) = movie.finish(args.fps)?;
    encoded.write()?;
    drop(progress);
    warnings.iter().for_each(|warning| reporter.warning(warning));
    if !args.report.json {
        return Ok(());
    }
    let shading = report::shading_name(options.shading, &scene);
    MovieReport::new(frames, args.fps, frames_hash, encoded.size(), &options, shading, &warnings).print()
}

/// As many frames as fit best, at least one.
pub(super) fn frame_count(seconds: f64, frames_a_second: f64) -> u32 {
    // Beyond u32 the conversion stops at its end, which no limit allows.
    ((seconds * frames_a_second).round() as u32).max(1)
}

/// A turn about the vertical axis through a point.
fn turned(center: [f64; 3], angle: f64) -> Result<Transform, crate::scene::SceneError> {
    let (sin, cos) = sin_cos(angle);
    let [x, _, z] = center;
    Transform::from_rows([
        [cos, 0.0, sin, x - cos * x - sin * z],
        [0.0, 1.0, 0.0, 0.0],
        [-sin, 0.0, cos, z + sin * x - cos * z],
    ])
}

/// A vector turned about the vertical axis.
fn turn(v: [f32; 3], about: [f64; 3], (sin, cos): (f64, f64)) -> [f32; 3] {
    let [x, z] = [f64::from(v[0]) - about[0], f64::from(v[2]) - about[2]];
    [(about[0] + cos * x + sin * z) as f32, v[1], (about[2] - sin * x + cos * z) as f32]
}

/// The camera turned about the vertical axis through a point.
pub(super) fn orbit(camera: &Camera, center: [f64; 3], angle: f64) -> Camera {
    let turning = sin_cos(angle);
    let center = if center.iter().all(|v| v.is_finite()) { center } else { [0.0; 3] };
    Camera {
        eye: turn(camera.eye, center, turning),
        target: turn(camera.target, center, turning),
        up: turn(camera.up, [0.0; 3], turning),
        ..*camera
    }
}

/// Turns the environment and the lights that are not the model's.
fn turn_light(
    scene: &mut Scene,
    environment: &Environment,
    lights: &[Light],
    own: usize,
    center: [f64; 3],
    angle: f64,
) -> Result<(), Failure> {
    let rotation_degrees = environment.rotation_degrees + angle.to_degrees() as f32;
    scene
        .set_environment(Environment { rotation_degrees, ..environment.clone() })
        .map_err(|e| Failure::scene(&e))?;
    scene.clear_lights();
    let turning = sin_cos(angle);
    for (k, light) in lights.iter().enumerate() {
        let light = if k < own { *light } else { turned_light(light, center, turning) };
        scene.add_light(light).map_err(|e| Failure::scene(&e))?;
    }
    Ok(())
}

fn turned_light(light: &Light, center: [f64; 3], turning: (f64, f64)) -> Light {
    let point = |p: &mut [f32; 3]| *p = turn(*p, center, turning);
    let vector = |v: &mut [f32; 3]| *v = turn(*v, [0.0; 3], turning);
    let mut light = *light;
    match &mut light.kind {
        LightKind::Directional { direction } => vector(direction),
        LightKind::Point { position, .. } => point(position),
        LightKind::Spot { position, direction, .. } => {
            point(position);
            vector(direction);
        }
        LightKind::Rect { position, half_width, half_height, .. } => {
            point(position);
            vector(half_width);
            vector(half_height);
        }
        LightKind::Tube { ends, .. } => ends.iter_mut().for_each(point),
    }
    light
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

    #[test]
    fn models_turn_as_cameras_do() {
        let center = [1.0, 7.0, 1.0];
        let by = turned(center, 1.1).unwrap();
        let camera = Camera {
            eye: [3.0, 2.0, 5.0],
            target: [1.0, 0.5, 0.0],
            up: [0.0, 1.0, 0.0],
            projection: Projection::Perspective { fov_y: 0.5 },
            near: 0.1,
        };
        let moved = by.point(camera.eye.map(f64::from));
        let eye = orbit(&camera, center, 1.1).eye;
        assert!(moved.iter().zip(eye).all(|(a, b)| (a - f64::from(b)).abs() < 1e-5), "{moved:?} {eye:?}");
        let light = Light::new(LightKind::Spot {
            position: camera.eye,
            direction: [0.0, 0.0, 1.0],
            range: None,
            inner_cone_cosine: 1.0,
            outer_cone_cosine: 0.5,
        });
        let LightKind::Spot { position, direction, .. } =
            turned_light(&light, center, sin_cos(std::f64::consts::FRAC_PI_2)).kind
        else {
            panic!("another kind")
        };
        assert_eq!(position, [5.0, 2.0, -1.0]);
        assert!((direction[0] - 1.0).abs() < 1e-6 && direction[2].abs() < 1e-6);
    }

    #[test]
    fn frames_of_a_time() {
        assert_eq!([(3.0, 24.0), (0.0, 24.0), (0.7, 30.0)].map(|(s, f)| frame_count(s, f)), [72, 1, 21]);
        assert_eq!(frame_count(1e300, 1000.0), u32::MAX);
    }
}
