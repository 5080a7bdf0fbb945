//! `overcoat animate`: an animation of a model, from beginning to end.

use super::args::AnimateArgs;
use super::failure::{Failure, file_name};
use super::input;
use super::materials::Materials;
use super::movie::{Movie, MovieTarget};
use super::progress::Progress;
use super::render::{describe, input_paths, left_out, machine, model_source, nothing_to_see};
use super::report::{self, MovieReport, Reporter};
use super::turntable::frame_count;
use crate::limits::Limits;
use crate::load::Warning;
use crate::render::Renderer;
use crate::scene::{Camera, Fit, Scene};

/// Renders an animation.
///
/// # Errors
/// [`Failure`]; nothing is written then.
pub fn run(args: &AnimateArgs) -> Result<(), Failure> {
    let reporter = Reporter { quiet: args.report.quiet };
    let progress = Progress::new(args.report.quiet);
    let limits = args.input_options.limits();
    let mut description = describe(args.scene.scene.as_deref(), args.input.as_deref())?;
    if args.animation.is_some() {
        description.animation.clone_from(&args.animation);
    }
    // The first one of the file; what time it is, the frames say.
    description.animation.get_or_insert_with(|| "0".to_owned());
    (description.time, description.repeat) = (None, None);
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
    let (options, display) = description.options(machine(&args.machine), &limits).map_err(about)?;

    progress.stage(format!("loading {}", file_name(&source.path)));
    let mut renderer = Renderer::new(usize::from(args.machine.threads));
    let materials = Materials::load(&description, &limits, renderer.jobs())?;
    let model = input::open_animated(&source, &limits, renderer.jobs())?;
    let (environment, mut warnings) = description.environment(&limits, renderer.jobs())?;

    let length = model.length().unwrap_or(0.0);
    let to = args.to.unwrap_or(length);
    if to < args.from {
        return Err(about(Failure::usage(format!(
            "nothing to play from second {} to second {to} (the animation has {length})",
            args.from
        ))));
    }
    let frames = frame_count(to - args.from, args.fps);
    Limits::check(|| "animation".to_owned(), frames.into(), limits.frames, "frames")
        .map_err(|e| about(Failure::limit(&e)))?;
    target.check(frames as usize, &inputs)?;
    let time = |k: u32| args.from + f64::from(k) / args.fps;
    let pose = |k: u32, renderer: &Renderer, warnings: &mut Vec<Warning>| -> Result<Scene, Failure> {
        let loaded = model.at(time(k), renderer.jobs()).map_err(|e| about(Failure::load(&e)))?;
        for warning in loaded.warnings {
            // Most are those of the file, which come with every frame.
            if !warnings.contains(&warning) {
                warnings.push(warning);
            }
        }
        Ok(loaded.scene)
    };

    // One camera for all frames, unless the file's own moves.
    let mut camera: Option<Camera> = None;
    let first = pose(0, &renderer, &mut warnings)?;
    if let Some(framing) = description.framing(&first, &options) {
        let mut fit = Fit::new(framing);
        fit.include(&first);
        for k in 1..frames {
            progress.step("fitting the picture", k, frames);
            fit.include(&pose(k, &renderer, &mut warnings)?);
        }
        camera = Some(description.fitted(fit.camera()).map_err(about)?);
    } else if description.camera.from_model.is_none() {
        // A place without a target looks at the middle of the first frame.
        camera = Some(description.camera(&first, &options).map_err(about)?);
    }
    drop(first);

    let mut movie = Movie::new(&target, &display, &limits);
    let mut empty = None;
    let mut shading = "";
    for k in 0..frames {
        progress.step(format!("frame {} of {frames}", k + 1), k, frames);
        let mut scene = pose(k, &renderer, &mut warnings)?;
        materials.assign(&mut scene, &limits).map_err(about)?;
        description.light_by(&mut scene, environment.clone()).map_err(about)?;
        let eye = match camera {
            Some(camera) => camera,
            None => description.camera(&scene, &options).map_err(about)?,
        };
        let rendered = renderer.render(&scene, &eye, &options).map_err(|e| about(Failure::render(&e)))?;
        movie.push(&rendered.frame)?;
        // One frame that shows something is enough.
        let nothing = nothing_to_see(&scene, &rendered.stats);
        empty = if k == 0 { nothing } else { empty.and(nothing) };
        if k == 0 {
            warnings.extend(left_out(&scene, options.shading));
            shading = report::shading_name(options.shading, &scene);
        }
        renderer.recycle(rendered.frame);
    }
    warnings.extend(empty);

    progress.stage("encoding");
    let (encoded, frames_hash) = movie.finish(args.fps)?;
    encoded.write()?;
    drop(progress);
    warnings.iter().for_each(|warning| reporter.warning(warning));
    if !args.report.json {
        return Ok(());
    }
    MovieReport::new(frames, args.fps, frames_hash, encoded.size(), &options, shading, &warnings).print()
}
