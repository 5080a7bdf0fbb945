//! Processor time that workers spend on one piece of work.

use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// Processor time of a piece of work, whatever becomes of it.
#[derive(Debug, Default)]
pub struct Meter(Mutex<Spent>);

#[derive(Debug, Default)]
struct Spent {
    time: Option<Duration>,
    worker: Option<u32>,
    pictures: usize,
}

impl Meter {
    fn lock(&self) -> MutexGuard<'_, Spent> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Time of all attempts so far, in steps of a hundredth of a second; `None` before the first has ended, and where
    /// the system does not tell it (on others than Linux).
    #[must_use]
    pub fn time(&self) -> Option<Duration> {
        self.lock().time
    }

    /// Process id of the last worker that had the work.
    #[must_use]
    pub fn worker(&self) -> Option<u32> {
        self.lock().worker
    }

    /// Pictures that the last worker has ended with, drawn or failed.
    #[must_use]
    pub fn pictures(&self) -> usize {
        self.lock().pictures
    }

    pub(super) fn begin(&self, worker: Option<u32>) {
        let mut spent = self.lock();
        (spent.worker, spent.pictures) = (worker, 0);
    }

    pub(super) fn picture(&self) {
        self.lock().pictures += 1;
    }

    pub(super) fn add(&self, time: Option<Duration>) {
        let mut spent = self.lock();
        if let Some(time) = time {
            spent.time = Some(spent.time.unwrap_or_default() + time);
        }
    }
}
