//! `overcoat thumbnail`: a small picture of a file that nobody has opened yet.

use super::args::{DrawArgs, InputArgs, MachineArgs, ReportArgs, ThreadArgs, ThumbnailArgs};
use super::embedded::Embedded;
use super::failure::Failure;
use super::output_file::OutputFile;
use super::render;
use super::render_task::RenderTask;
use super::thumbnail_limits::within_thumbnail_limits;
use overcoat_image::output::OutputFormat;
use overcoat_worker::memory_bound::bound_memory;
use std::slice::from_ref;
use std::time::Instant;

/// Threads where nobody says how many. A file manager asks for several pictures at once; and each thread takes of the memory
/// that the process may have.
const MOST_THREADS: usize = 4;

/// Limits memory and settles the number of threads, before rights are given up: afterwards no limit can be set, and
/// nobody says how many processors there are.
pub(super) fn prepare(args: &mut ThumbnailArgs) {
    // If the system refuses, the bound stays as it was.
    let _ = bound_memory(args.memory);
    if args.workers.threads == 0 {
        let processors = std::thread::available_parallelism();
        args.workers.threads = processors.map_or(1, |n| n.get().min(MOST_THREADS) as u16);
    }
}

/// Renders one model to a small PNG.
///
/// # Errors
/// [`Failure`]; nothing is written then.
pub fn run(args: &ThumbnailArgs) -> Result<(), Failure> {
    let start = Instant::now();
    let draw = draw_args(args);
    let models = from_ref(&args.input);
    let mut description = draw.describe(models)?;
    description.size = Some([args.size.into(); 2]);
    let mut task = RenderTask::new(&draw, description, models)?;
    task.embedded = Embedded::WithoutModel;
    let target = OutputFile::of_format(&args.output, OutputFormat::Png, &task.inputs, task.json)?;
    render::carry_out(task, &draw, &target, start).map_err(|failure| failure.with_memory_option("--memory"))
}

/// The options of drawing: as few as there are, within the limits of thumbnails.
fn draw_args(args: &ThumbnailArgs) -> DrawArgs {
    let workers = ThreadArgs { threads: args.workers.threads };
    let report = ReportArgs { json: args.report.json, quiet: args.report.quiet };
    DrawArgs {
        machine: MachineArgs { workers, ..MachineArgs::default() },
        input: InputArgs { limits: within_thumbnail_limits(&args.limits), ..InputArgs::default() },
        report,
        ..DrawArgs::default()
    }
}
