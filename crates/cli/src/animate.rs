//! `overcoat animate`: an animation of a model, from beginning to end.

use super::args::AnimateArgs;
use super::failure::{Failure, file_name};
use super::movie_frames::{MovieFrames, frame_count};
use super::movie_output::MovieOutput;
use super::render_task::RenderTask;
use overcoat_core::jobs::Jobs;
use overcoat_load::{AnimatedModel, Warning};
use overcoat_scene::{Bounds, Camera, Fit, Scene};
use overcoat_worker::model_source::open_animated;

/// Renders an animation.
///
/// # Errors
/// [`Failure`]; nothing is written then.
pub fn run(args: &AnimateArgs) -> Result<(), Failure> {
    let (draw, models) = (&args.model.draw, args.model.input.as_slice());
    let mut description = draw.describe(models)?;
    if args.animation.is_some() {
        description.animation.clone_from(&args.animation);
    }
    // The first one of the file; what time it is, the frames say.
    description.animation.get_or_insert_with(|| "0".to_owned());
    (description.time, description.repeat) = (None, None);
    let mut task = RenderTask::new(draw, description, models)?;
    let movie = &args.movie;
    let target = MovieOutput::new(&movie.output, &movie.encoding, &task.inputs, task.json)?;
    target.put_behind(&mut task);

    task.progress.stage(format!("loading {}", file_name(&task.picture.source.path)));
    let mut renderer = draw.renderer();
    let setting = task.picture.setting(renderer.jobs())?;
    let mut poses = Poses {
        model: open_animated(&task.picture.source, &task.picture.limits, renderer.jobs())?,
        from: args.from,
        frames_a_second: args.movie.fps,
        warnings: Vec::new(),
    };
    let length = poses.model.length().unwrap_or(0.0);
    let to = args.to.unwrap_or(length);
    if to < args.from {
        return Err(Failure::usage(format!(
            "nothing to play from second {} to second {to} (the animation has {length})",
            args.from
        ))
        .at(&task.picture.source.path));
    }
    let frames = frame_count(to - args.from, args.movie.fps);
    let mut movie = MovieFrames::new(task, target, &args.movie, frames)?;
    let (camera, ground_under) = steady(movie.task(), frames, &mut poses, renderer.jobs())?;
    movie.put_ground_under(ground_under);
    while let Some(k) = movie.next_frame()? {
        let task = movie.task();
        let mut scene = poses.at(k, task, renderer.jobs())?;
        setting
            .apply(&task.picture.description, &mut scene, &task.picture.limits)
            .map_err(|error| error.at(&task.picture.source.path))?;
        let eye = match camera {
            Some(camera) => camera,
            None => task.picture.camera(&task.picture.source, &scene)?,
        };
        movie.render_frame(k, &mut renderer, &scene, &eye)?;
    }
    let mut warnings = poses.warnings;
    warnings.extend(setting.warnings);
    movie.finish(warnings)
}

/// The model at the times of the frames.
struct Poses {
    model: AnimatedModel,
    /// Second of the first frame.
    from: f64,
    frames_a_second: f64,
    /// Warnings of all poses so far.
    warnings: Vec<Warning>,
}

impl Poses {
    /// The scene of frame `k`.
    fn at(&mut self, k: u32, task: &RenderTask, jobs: &Jobs) -> Result<Scene, Failure> {
        let time = self.from + f64::from(k) / self.frames_a_second;
        let loaded =
            self.model.at(time, jobs).map_err(|e| Failure::load(&e).at(&task.picture.source.path))?;
        for warning in loaded.warnings {
            // Most are those of the file, which come with every frame.
            if !self.warnings.contains(&warning) {
                self.warnings.push(warning);
            }
        }
        Ok(loaded.scene)
    }
}

/// One camera for all frames, unless the file's own moves, and the box that one floor lies under, if there is one: what leaves
/// the ground must not take it along.
fn steady(
    task: &RenderTask,
    frames: u32,
    poses: &mut Poses,
    jobs: &Jobs,
) -> Result<(Option<Camera>, Option<Bounds>), Failure> {
    let description = &task.picture.description;
    let first = poses.at(0, task, jobs)?;
    let mut fit = description.framing(&first, &task.picture.options).map(Fit::new);
    let mut bounds = task.picture.options.ground.is_seen().then(|| first.tight_bounds());
    if let Some(fit) = &mut fit {
        fit.include(&first);
    }
    for k in 1..if fit.is_some() || bounds.is_some() { frames } else { 0 } {
        task.progress.step("fitting the picture", k, frames);
        let pose = poses.at(k, task, jobs)?;
        if let Some(fit) = &mut fit {
            fit.include(&pose);
        }
        bounds = bounds.map(|bounds| bounds.union(&pose.tight_bounds()));
    }
    let camera = match fit {
        Some(fit) => {
            Some(description.fitted(fit.camera()).map_err(|error| error.at(&task.picture.source.path))?)
        }
        None if description.camera.from_model.is_some() => None,
        // A place without a target looks at the middle of the first frame.
        None => Some(task.picture.camera(&task.picture.source, &first)?),
    };
    Ok((camera, bounds))
}
