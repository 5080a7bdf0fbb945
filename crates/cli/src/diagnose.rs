//! `overcoat diagnose`: faults of a picture, and the options that mend them.

use super::args::DiagnoseArgs;
use super::failure::{Failure, file_name};
use super::render_task::RenderTask;
use super::report;
use overcoat_load::Loaded;
use overcoat_worker::diagnosis::Diagnosis;
use overcoat_worker::report::Stages;

/// Prints what of a picture is wrong.
///
/// # Errors
/// [`Failure`] if there is no such picture, or something is wrong with it and nothing may be.
pub fn run(args: &DiagnoseArgs) -> Result<(), Failure> {
    let (draw, models) = (&args.model.draw, args.model.input.as_slice());
    let mut description = draw.describe(models)?;
    args.animation.apply(&mut description);
    let mut task = RenderTask::new(draw, description, models)?;
    let source = &task.picture.source;
    task.progress.stage(format!("loading {}", file_name(&source.path)));
    let mut renderer = draw.renderer();
    let Loaded { mut scene, warnings, .. } = task.picture.load(renderer.jobs(), &mut Stages::default())?;
    task.progress.stage("looking for faults");
    let diagnosis = Diagnosis::new(&task.picture, source, &mut renderer, &mut scene, warnings)?;
    task.progress.finish();
    if task.json {
        report::print_json(&diagnosis)?;
    } else {
        report::print(&diagnosis.text())?;
    }
    match diagnosis.faults().count() {
        0 => Ok(()),
        _ if !args.strict => Ok(()),
        1 => Err(Failure::findings("something is wrong with the picture (--strict)").at(&source.path)),
        count => {
            let message = format!("{count} things are wrong with the picture (--strict)");
            Err(Failure::findings(message).at(&source.path))
        }
    }
}
