//! `overcoat turntable`: a model once around.

use super::args::TurntableArgs;
use super::failure::{Failure, file_name};
use super::movie_frames::{MovieFrames, frame_count};
use super::movie_output::MovieOutput;
use super::render_task::RenderTask;
use overcoat_load::Loaded;
use overcoat_worker::picture_task::PictureTask;
use overcoat_worker::report::Stages;
pub use overcoat_worker::turning::Turning;

/// Renders one turn.
///
/// # Errors
/// [`Failure`]; nothing is written then.
pub fn run(args: &TurntableArgs) -> Result<(), Failure> {
    let (draw, models) = (&args.model.draw, args.model.input.as_slice());
    let mut description = draw.describe(models)?;
    args.animation.apply(&mut description);
    let mut task = RenderTask::new(draw, description, models)?;
    let movie = &args.movie;
    let target = MovieOutput::new(&movie.output, &movie.encoding, &task.inputs, task.json)?;
    target.put_behind(&mut task);
    let seconds = args.seconds.unwrap_or(3.0);
    let frames = args.frames.unwrap_or_else(|| frame_count(seconds, args.movie.fps));
    let mut movie = MovieFrames::new(task, target, &args.movie, frames)?;

    let RenderTask { progress, picture, .. } = movie.task();
    let PictureTask { source, description, options, .. } = picture;
    let about = |failure: Failure| failure.at(&source.path);
    progress.stage(format!("loading {}", file_name(&source.path)));
    let mut renderer = draw.renderer();
    let Loaded { mut scene, warnings, .. } = picture.load(renderer.jobs(), &mut Stages::default())?;
    let turning =
        Turning::new(description, &scene, options, frames, args.turn).map_err(|e| about(Failure::from(e)))?;
    while let Some(k) = movie.next_frame()? {
        let eye = turning
            .pose(k, &mut scene)
            .map_err(|e| Failure::scene(&e).at(&movie.task().picture.source.path))?;
        movie.render_frame(k, &mut renderer, &scene, &eye)?;
    }
    movie.finish(warnings)
}
