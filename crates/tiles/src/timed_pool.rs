//! The loops of one picture on all threads: timed, and every thread that takes part looked at.

use super::clock::Moment;
use overcoat_core::jobs::{Jobs, Scratch};
use overcoat_core::math::arithmetic_is_default;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// Runs the loops of one picture and writes down how long they take. The times are only for the user to read: no result
/// depends on them.
pub struct TimedPool<'a> {
    /// Worker threads.
    pub jobs: &'a Jobs,
    /// Some thread's processor state is not the default.
    foreign: AtomicBool,
    /// Start of the stage.
    last: Moment,
    /// Time in loops.
    parallel: Duration,
}

impl<'a> TimedPool<'a> {
    /// Starts the clock.
    pub fn new(jobs: &'a Jobs) -> Self {
        let foreign = AtomicBool::new(!arithmetic_is_default());
        Self { jobs, foreign, last: Moment::now(), parallel: Duration::ZERO }
    }

    /// Time since the last stage ended; begins the next.
    pub fn lap(&mut self) -> Duration {
        let now = Moment::now();
        let time = now.since(self.last);
        self.last = now;
        time
    }

    /// Time that the loops took so far.
    pub fn parallel(&self) -> Duration {
        self.parallel
    }

    /// True if the processor state of every thread that took part so far is the default.
    pub fn arithmetic_is_default(&self) -> bool {
        !self.foreign.load(Ordering::Relaxed)
    }

    /// As [`Jobs::for_each_mut`].
    pub fn for_each_mut<T: Send>(&mut self, items: &mut [T], f: impl Fn(usize, &mut T) + Sync) {
        let (start, foreign) = (Moment::now(), &self.foreign);
        self.jobs.for_each_mut(items, |k, item| {
            look_at_this_thread(foreign);
            f(k, item);
        });
        self.parallel += start.elapsed();
    }

    /// As [`Jobs::for_each_with_scratch`].
    pub fn for_each_with_scratch<T: Send, S: Send + Default>(
        &mut self,
        scratch: &mut Scratch<S>,
        items: &mut [T],
        f: impl Fn(&mut S, usize, &mut T) + Sync,
    ) {
        let (start, foreign) = (Moment::now(), &self.foreign);
        self.jobs.for_each_with_scratch(scratch, items, |scratch, k, item| {
            look_at_this_thread(foreign);
            f(scratch, k, item);
        });
        self.parallel += start.elapsed();
    }
}

fn look_at_this_thread(foreign: &AtomicBool) {
    if !arithmetic_is_default() {
        foreign.store(true, Ordering::Relaxed);
    }
}
