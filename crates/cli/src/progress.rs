//! A spinner or a bar on standard error for work that takes long, when someone is watching.

use indicatif::{ProgressBar, ProgressStyle};
use std::io::IsTerminal;
use std::sync::mpsc::{self, RecvTimeoutError, Sender};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Work that is done sooner shows nothing.
const PATIENCE: Duration = Duration::from_millis(500);

/// Shows what is being done from half a second on, and cleans up after itself when dropped.
#[derive(Debug)]
pub struct Progress {
    watcher: Option<(Sender<Stage>, JoinHandle<()>)>,
}

/// Stage of the work, as it is shown.
#[derive(Debug, Default)]
struct Stage {
    message: String,
    /// Number of parts that are done, and of all parts, if that is known.
    part: Option<(u32, u32)>,
}

impl Progress {
    /// Starts the clock. Nothing is ever shown if `quiet` or if standard error is no terminal.
    #[must_use]
    pub fn new(quiet: bool) -> Self {
        if quiet || !std::io::stderr().is_terminal() {
            return Self { watcher: None };
        }
        let (sender, receiver) = mpsc::channel::<Stage>();
        let watch = move || {
            let start = Instant::now();
            let mut stage = Stage::default();
            let mut bar: Option<ProgressBar> = None;
            loop {
                let wait = if bar.is_some() {
                    Duration::from_millis(100)
                } else {
                    PATIENCE.saturating_sub(start.elapsed())
                };
                match receiver.recv_timeout(wait) {
                    Ok(next) => stage = next,
                    Err(RecvTimeoutError::Timeout) => {}
                    Err(RecvTimeoutError::Disconnected) => break,
                }
                if start.elapsed() >= PATIENCE {
                    let bar = bar.get_or_insert_with(ProgressBar::new_spinner);
                    let template = match stage.part {
                        Some((done, of)) => {
                            bar.set_length(of.into());
                            bar.set_position(done.into());
                            "{bar:40} {msg} {elapsed}"
                        }
                        None => "{spinner} {msg} {elapsed}",
                    };
                    let style = ProgressStyle::with_template(template);
                    bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_spinner()));
                    bar.set_message(stage.message.clone());
                    bar.tick();
                }
            }
            if let Some(bar) = bar {
                bar.finish_and_clear();
            }
        };
        // Without a thread there is no spinner; the work goes on.
        let watcher = std::thread::Builder::new().name("progress".to_owned()).spawn(watch);
        Self { watcher: watcher.ok().map(|thread| (sender, thread)) }
    }

    /// Says what is being done now.
    pub fn stage(&self, message: impl Into<String>) {
        self.send(Stage { message: message.into(), part: None });
    }

    /// Says what is being done now, and how many of equal parts are done.
    pub fn step(&self, message: impl Into<String>, done: u32, of: u32) {
        self.send(Stage { message: message.into(), part: Some((done, of)) });
    }

    /// Shows nothing from now on.
    pub fn finish(&mut self) {
        if let Some((sender, thread)) = self.watcher.take() {
            drop(sender);
            let _ = thread.join();
        }
    }

    fn send(&self, stage: Stage) {
        if let Some((sender, _)) = &self.watcher {
            let _ = sender.send(stage);
        }
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.finish();
    }
}
