//! Messages of the commands beside the picture, and the report on a movie.

use super::error_format;
use super::failure::Failure;
use overcoat_core::jobs::Jobs;
use overcoat_load::Warning;
use overcoat_worker::camera_report::CameraReport;
use overcoat_worker::codes::{self, Code};
use overcoat_worker::report::{UpReport, Versions, VisibilityReport};
use serde::Serialize;
use std::fmt::Display;
use std::io::Write;

/// Prints warnings to standard error, one line each.
#[derive(Clone, Copy, Debug)]
pub struct Reporter {
    /// Print nothing.
    pub quiet: bool,
}

impl Reporter {
    /// A warning if the system gave fewer threads than were wanted.
    pub fn threads(self, jobs: &Jobs) {
        if jobs.missing() > 0 {
            let (threads, missing) = (jobs.threads(), jobs.missing());
            let wanted = threads + missing;
            self.warning(format_args!(
                "of {wanted} threads {missing} could not be started; the work is done by {threads}"
            ));
        }
    }

    /// One line on standard error that is no warning.
    pub fn note(self, message: impl Display) {
        self.note_of(codes::PROGRAM, message);
    }

    /// One line of another code.
    pub fn note_of(self, code: Code, message: impl Display) {
        if !self.quiet {
            error_format::note(code, &message);
        }
    }

    /// One line on standard error about what was asked for, or the machine.
    pub fn warning(self, message: impl Display) {
        self.tell(&Warning::new(message.to_string()).with_code(codes::PROGRAM.name));
    }

    /// One line on standard error.
    pub fn tell(self, warning: &Warning) {
        if !self.quiet {
            error_format::warning(warning);
        }
    }
}

/// Writes to standard output.
///
/// # Errors
/// [`Failure`] if it cannot be written. A reader that has seen enough and closed the pipe is no failure.
pub fn print(text: &str) -> Result<(), Failure> {
    let mut out = std::io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => {
            let message = format!("standard output cannot be written: {e}");
            Err(Failure::failed(message).with_code(codes::UNWRITABLE))
        }
        _ => Ok(()),
    }
}

/// Writes one JSON value and a line break to standard output.
///
/// # Errors
/// As [`print`].
pub fn print_json(value: &impl Serialize) -> Result<(), Failure> {
    let text = serde_json::to_string_pretty(value).map_err(Failure::failed)?;
    print(&(text + "\n"))
}

/// Report of `--json` on a moving picture. Fields are only ever added.
#[derive(Debug, Serialize)]
pub struct MovieReport {
    pub frames: u32,
    pub frames_a_second: f64,
    /// XXH3-128 of the frames' hashes, equal on every machine.
    pub frames_hash: String,
    pub bytes: u64,
    pub width: u32,
    pub(super) height: u32,
    pub samples: u32,
    pub visibility: VisibilityReport,
    /// As `--ground` takes it.
    pub ground: String,
    pub ground_reflection: f32,
    pub shading_rate: u32,
    pub shade_everywhere: bool,
    pub shading: &'static str,
    /// Stops of all frames.
    pub exposure: f32,
    #[serde(flatten)]
    pub(super) up: UpReport,
    /// Camera of the first frame.
    pub camera: Option<CameraReport>,
    pub peak_rss_bytes: Option<u64>,
    pub warnings: Vec<String>,
    pub versions: Versions,
}

impl MovieReport {
    /// Prints it.
    ///
    /// # Errors
    /// As [`print`].
    pub fn print(&self) -> Result<(), Failure> {
        print_json(self)
    }
}
