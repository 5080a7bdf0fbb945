//! A process that draws one model after another, for a parent that must not parse any: what the program for batches and for the
//! service starts. It gives up every right first, and gets all files from the parent.

mod drawing;
mod files;
mod pipe;
pub mod protocol;
mod rights;

use super::failure::Failure;
use super::limit_values::set_limit;
use super::signals;
use drawing::Drawing;
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
            ToWorker::Inspect { name } => drawing.inspect(&name, &bytes),
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
