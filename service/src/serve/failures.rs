//! Memory of failures: what has failed is not tried again at once, for a time that doubles with every further failure.
//!
//! A model that takes the whole deadline, or a source that does not answer, would else cost the same again for every request that
//! asks for it, and clients ask again.

use super::error::{Kind, Problem};
use std::collections::HashMap;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Failures that are remembered at most; beyond, the one that would be forgotten first goes.
const MOST: usize = 4096;

/// Longest time without another attempt.
const LONGEST: Duration = Duration::from_secs(600);

/// Failures by the name of the work.
#[derive(Debug)]
pub struct Failures {
    /// Time without another attempt after the first failure; none is remembered if it is zero.
    first: Duration,
    known: Mutex<HashMap<String, Failure>>,
}

#[derive(Debug)]
struct Failure {
    problem: Problem,
    /// Time of the next attempt.
    until: Instant,
    /// Time from the last failure to then.
    pause: Duration,
}

impl Failures {
    /// None yet.
    #[must_use]
    pub fn new(first: Duration) -> Self {
        Self { first, known: Mutex::default() }
    }

    fn lock(&self) -> MutexGuard<'_, HashMap<String, Failure>> {
        self.known.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The failure of this work, if it is too early for another attempt, with the seconds that are left.
    #[must_use]
    pub fn of(&self, name: &str, now: Instant) -> Option<Problem> {
        let known = self.lock();
        let failure = known.get(name).filter(|failure| now < failure.until)?;
        let seconds = failure.until.duration_since(now).as_secs_f64().ceil() as u64;
        Some(failure.problem.clone().retry_after(seconds.max(1)))
    }

    /// Takes note of the outcome of work. Failures that say nothing of the work (a full queue, a worker that was killed from outside)
    /// are not remembered.
    pub fn note(&self, name: &str, problem: Option<&Problem>, now: Instant) {
        if self.first.is_zero() {
            return;
        }
        let mut known = self.lock();
        let Some(problem) = problem else {
            known.remove(name);
            return;
        };
        if !is_of_work(problem) {
            return;
        }
        // Long after the last failure it counts as the first.
        let last = known.get(name).filter(|last| now < last.until + last.pause);
        let pause = last.map_or(self.first, |last| (last.pause * 2).min(LONGEST.max(self.first)));
        if known.len() >= MOST && !known.contains_key(name) {
            let next = known.iter().min_by_key(|(_, failure)| failure.until).map(|(name, _)| name.clone());
            next.and_then(|name| known.remove(&name));
        }
        known.insert(name.to_owned(), Failure { problem: problem.clone(), until: now + pause, pause });
    }

    /// Number of failures that are remembered, over or not.
    #[must_use]
    pub fn count(&self) -> usize {
        self.lock().len()
    }

    /// Forgets all. Returns their number.
    pub fn forget(&self) -> usize {
        std::mem::take(&mut *self.lock()).len()
    }
}

/// True for failures that the same work would have again.
fn is_of_work(problem: &Problem) -> bool {
    let kinds = [
        Kind::Model,
        Kind::Limit,
        Kind::Memory,
        Kind::Worker,
        Kind::Timeout,
        Kind::NotFound,
        Kind::TooLarge,
        Kind::SourceFailed,
        Kind::SourceTimeout,
    ];
    kinds.contains(&problem.kind) && !problem.was_killed
}

#[cfg(test)]
mod tests {
    use super::*;

    fn seconds(count: u64) -> Duration {
        Duration::from_secs(count)
    }

    #[test]
    fn pauses_double_and_end() {
        let failures = Failures::new(seconds(5));
        let problem = Problem::new(Kind::Timeout, "too long");
        let begun = Instant::now();
        assert!(failures.of("a", begun).is_none());
        let mut now = begun;
        for pause in [5, 10, 20, 40, 80, 160, 320, 600, 600] {
            failures.note("a", Some(&problem), now);
            let known = failures.of("a", now).unwrap();
            assert_eq!((known.kind, known.retry_after), (Kind::Timeout, Some(pause)));
            assert!(failures.of("b", now).is_none());
            now += seconds(pause);
            assert!(failures.of("a", now).is_none());
        }
        // After as long again, it is the first failure once more.
        now += seconds(601);
        failures.note("a", Some(&problem), now);
        assert_eq!(failures.of("a", now).unwrap().retry_after, Some(5));
        // Success ends the memory.
        failures.note("a", None, now);
        assert!(failures.of("a", now).is_none());
    }

    #[test]
    fn what_says_nothing_of_the_work_is_not_remembered() {
        let failures = Failures::new(seconds(5));
        let now = Instant::now();
        let killed = Problem { was_killed: true, ..Problem::new(Kind::Worker, "killed") };
        for problem in [Problem::new(Kind::QueueFull, ""), Problem::new(Kind::Stopping, ""), killed] {
            failures.note("a", Some(&problem), now);
            assert!(failures.of("a", now).is_none(), "{problem:?}");
        }
        let none = Failures::new(Duration::ZERO);
        none.note("a", Some(&Problem::new(Kind::Model, "")), now);
        assert!(none.of("a", now).is_none());
    }

    #[test]
    fn memory_is_bounded_and_can_be_emptied() {
        let failures = Failures::new(seconds(5));
        let (problem, now) = (Problem::new(Kind::Model, ""), Instant::now());
        for k in 0..MOST as u64 + 10 {
            failures.note(&k.to_string(), Some(&problem), now + Duration::from_millis(k));
        }
        let last = now + Duration::from_millis(MOST as u64);
        assert!(failures.of("0", last).is_none() && failures.of("10", last).is_some());
        assert_eq!(failures.forget(), MOST);
        assert!(failures.of("10", last).is_none());
    }
}
