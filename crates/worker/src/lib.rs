//! Pictures as work: a description and a model become encoded files with a report and warnings, or a [`failure::Failure`]
//! that is one line and an exit code.
//!
//! [`picture_task::PictureTask`] is one such piece of work, which the command line does in its own process. [`run`] makes this process
//! a worker: it draws one model after another for a parent that must not parse any, as batches and the service do, gives up
//! every right first, and gets all files from the parent over [`protocol`].

pub mod annotation_report;
pub mod camera_report;
pub mod codes;
pub mod companion;
mod contents;
pub mod converters;
mod coverage_check;
pub mod diagnosis;
mod drawing;
pub mod failure;
mod files;
pub mod limit_values;
pub mod losses;
pub mod memory_bound;
pub mod message;
pub mod model_facts;
pub mod model_source;
pub mod picture_format;
pub mod picture_task;
mod pipe;
pub mod protocol;
pub mod render_report;
pub mod report;
pub mod resources;
mod rights;
pub mod signals;
pub mod turning;
pub mod turntable;

pub use contents::Contents;

use drawing::Drawing;
use failure::Failure;
use limit_values::set_limit;
use overcoat_core::limits::Limits;
use overcoat_description::Description;
use overcoat_render::Renderer;
use pipe::Pipe;
use protocol::{FromWorker, Start, ToWorker};
use serde_json::Value;
use std::io::Write;
use std::process::ExitCode;

/// Serves the parent at the other end of the standard streams until it has no more work.
#[must_use]
pub fn run() -> ExitCode {
    signals::listen();
    match serve(&Pipe::standard()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            let _ = writeln!(std::io::stderr(), "overcoat worker: {failure}");
            ExitCode::from(failure.exit_code())
        }
    }
}

fn serve(pipe: &Pipe) -> Result<(), Failure> {
    let Some((ToWorker::Start(start), _)) = pipe.receive()? else {
        return Err(Failure::usage("a worker is started by its parent: overcoat batch, overcoat serve"));
    };
    let common = description_of(&start.description)?;
    rights::give_up(&start, &common)?;
    let mut drawing = Drawing {
        pipe,
        limits: limits_of(&start)?,
        renderer: Renderer::new(start.threads.max(1).into()),
        start: *start,
        setting: None,
    };
    pipe.send(&FromWorker::Ready, &[])?;
    while let Some((message, bytes)) = pipe.receive()? {
        let done = match message {
            ToWorker::Work(work) => drawing.draw(&work, &bytes),
            ToWorker::Inspect { name, converter, warnings } => {
                drawing.inspect(&name, &bytes, (converter, &warnings))
            }
            _ => return Err(Failure::usage("the parent says what was not asked for")),
        };
        let end = match done {
            Ok(()) => FromWorker::Done,
            Err(failure) => FromWorker::Failed { failure: (&failure).into() },
        };
        pipe.send(&end, &[])?;
    }
    Ok(())
}

/// Description in a scene file in JSON; the default for null.
fn description_of(json: &Value) -> Result<Description, Failure> {
    match json {
        Value::Null => Ok(Description::default()),
        json => Ok(Description::from_json(&json.to_string())?),
    }
}

fn limits_of(start: &Start) -> Result<Limits, Failure> {
    let mut limits = Limits::default();
    for (name, value) in &start.limits {
        set_limit(&mut limits, name, *value).map_err(Failure::usage)?;
    }
    Ok(limits)
}
