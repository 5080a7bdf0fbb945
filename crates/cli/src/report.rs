//! Reports of the commands beside the picture: warnings, JSON, times and memory.

use super::camera_report::CameraReport;
use super::failure::{Failure, one_line};
use overcoat_core::jobs::Jobs;
use overcoat_render::Visibility;
use overcoat_scene::{Axis, Orientation, Scene, ShadingModel};
use serde::Serialize;
use serde::ser::{SerializeMap, Serializer};
use std::fmt::Display;
use std::fs::File;
use std::io::{Read, Seek, Write};
use std::sync::OnceLock;
use std::time::{Duration, Instant};

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
        if !self.quiet {
            let _ = writeln!(std::io::stderr(), "{}", one_line(&message.to_string()));
        }
    }

    /// One line on standard error.
    pub fn warning(self, message: impl Display) {
        if !self.quiet {
            // There is nobody to tell if standard error is closed.
            let _ = writeln!(std::io::stderr(), "warning: {}", one_line(&message.to_string()));
        }
    }
}

/// A line about a model that stands on another axis than is usual in files of its format, where nobody has said which is up.
pub(super) fn note_of_up(orientation: Orientation) -> Option<String> {
    let usual = if orientation.up == Axis::PositiveY { Axis::PositiveZ } else { Axis::PositiveY };
    let [up, usual] = [orientation.up, usual].map(Axis::name);
    let note = || {
        format!(
            "{up} of the file is up by the shape of the model; --up {usual} has it as usual in its format"
        )
    };
    orientation.up_is_by_shape.then(note)
}

/// Writes to standard output.
///
/// # Errors
/// [`Failure`] if it cannot be written. A reader that has seen enough and closed the pipe is no failure.
pub fn print(text: &str) -> Result<(), Failure> {
    let mut out = std::io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(Failure::failed(format!("standard output cannot be written: {e}")))
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

/// Which program made a picture.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Versions {
    /// Version of this package.
    pub overcoat: &'static str,
    /// Processor architecture and operating system.
    pub target: &'static str,
}

impl Default for Versions {
    fn default() -> Self {
        Self {
            overcoat: env!("CARGO_PKG_VERSION"),
            target: match (std::env::consts::ARCH, std::env::consts::OS) {
                ("x86_64", "linux") => "x86_64-linux",
                ("aarch64", "linux") => "aarch64-linux",
                ("x86_64", "macos") => "x86_64-macos",
                ("aarch64", "macos") => "aarch64-macos",
                ("x86_64", "windows") => "x86_64-windows",
                _ => "other",
            },
        }
    }
}

/// Milliseconds by stage, in the order of the stages.
#[derive(Clone, Debug, Default)]
pub struct Stages(Vec<(&'static str, Duration)>);

impl Stages {
    /// Runs one stage and notes how long it took.
    pub fn time<T>(&mut self, name: &'static str, work: impl FnOnce() -> T) -> T {
        let start = Instant::now();
        let result = work();
        self.add(name, start.elapsed());
        result
    }

    /// Notes how long a stage took; parts of it add up.
    pub fn add(&mut self, name: &'static str, time: Duration) {
        match self.0.iter_mut().find(|(known, _)| *known == name) {
            Some((_, sum)) => *sum += time,
            None => self.0.push((name, time)),
        }
    }
}

impl Serialize for Stages {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(self.0.len()))?;
        for (name, time) in &self.0 {
            map.serialize_entry(name, &milliseconds(*time))?;
        }
        map.end()
    }
}

/// Milliseconds, rounded to microseconds.
#[must_use]
pub fn milliseconds(time: Duration) -> f64 {
    (time.as_secs_f64() * 1e6).round() / 1e3
}

/// File in which the system says how much memory this process has, opened before a sandbox closes the way to it.
static STATUS: OnceLock<File> = OnceLock::new();

/// Keeps open what [`peak_rss_bytes`] reads.
pub fn keep_status_open() {
    if let Ok(file) = File::open("/proc/self/status") {
        // A second time changes nothing.
        let _ = STATUS.set(file);
    }
}

/// Largest resident memory of this process so far in bytes; `None` where the system does not say (Linux does).
#[must_use]
pub fn peak_rss_bytes() -> Option<u64> {
    let mut status = String::new();
    match STATUS.get() {
        // Each reading from the beginning is a new answer.
        Some(mut file) => {
            file.rewind().ok()?;
            file.read_to_string(&mut status).ok()?
        }
        None => File::open("/proc/self/status").ok()?.read_to_string(&mut status).ok()?,
    };
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()?.checked_mul(1024)
}

/// Name of the shading model of a scene, or `by material` where materials name their own.
#[must_use]
pub fn shading_name(chosen: Option<ShadingModel>, scene: &Scene) -> &'static str {
    match chosen {
        Some(model) => model.name(),
        None if scene.materials().iter().any(|material| material.model.is_some()) => "by material",
        None => ShadingModel::default().name(),
    }
}

/// Settings of visibility that were used.
#[derive(Debug, Serialize)]
pub(super) struct VisibilityReport {
    maps: u32,
    map_size: u32,
    rays: u32,
}

impl VisibilityReport {
    pub(super) fn new(&Visibility { maps, map_size, rays, .. }: &Visibility) -> Self {
        Self { maps, map_size, rays }
    }
}

/// Report of `--json` on a moving picture. Fields are only ever added.
#[derive(Debug, Serialize)]
pub(super) struct MovieReport {
    pub(super) frames: u32,
    pub(super) frames_a_second: f64,
    /// XXH3-128 of the frames' hashes, equal on every machine.
    pub(super) frames_hash: String,
    pub(super) bytes: u64,
    pub(super) width: u32,
    pub height: u32,
    pub(super) samples: u32,
    pub(super) visibility: VisibilityReport,
    /// As `--ground` takes it.
    pub(super) ground: String,
    pub(super) ground_reflection: f32,
    pub(super) shading_rate: u32,
    pub(super) shade_everywhere: bool,
    pub(super) shading: &'static str,
    /// Stops of all frames.
    pub(super) exposure: f32,
    /// Axis of the model file that is up.
    pub(super) up_axis: &'static str,
    /// True if that axis was told by the model's shape, against the custom of its format.
    pub(super) up_is_by_shape: bool,
    /// Camera of the first frame.
    pub(super) camera: Option<CameraReport>,
    pub(super) peak_rss_bytes: Option<u64>,
    pub(super) warnings: Vec<String>,
    pub(super) versions: Versions,
}

impl MovieReport {
    /// Prints it.
    ///
    /// # Errors
    /// As [`print`].
    pub(super) fn print(&self) -> Result<(), Failure> {
        print_json(self)
    }
}

/// Processor time of all threads of this process; `None` where the system does not say (Unix and Windows do).
///
/// On Linux in nanoseconds, and up to this moment for the calling thread. What `/proc/self/task` tells is no substitute: there
/// a running thread's time is as of the last tick or pause, so that a thread which works, asks, and then waits for others has
/// its own work counted as theirs.
#[must_use]
pub fn processor_time() -> Option<Duration> {
    #[cfg(any(unix, windows))]
    return cpu_time::ProcessTime::try_now().ok().map(|now| now.as_duration());
    #[cfg(not(any(unix, windows)))]
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stages_keep_their_order_and_add_up() {
        let mut stages = Stages::default();
        stages.add("raster", Duration::from_micros(1500));
        stages.add("binning", Duration::from_millis(2));
        stages.add("raster", Duration::from_millis(1));
        assert_eq!(serde_json::to_string(&stages).unwrap(), r#"{"raster":2.5,"binning":2.0}"#);
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn memory_is_at_least_what_is_touched() {
        let block = vec![1_u8; 8 << 20];
        std::hint::black_box(&block);
        assert!(peak_rss_bytes().is_some_and(|bytes| bytes > 8 << 20));
    }
}
