//! Memory of the last requests, for those who ask what is slow, what fails and why.

use super::trace::Line;
use std::collections::VecDeque;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Failures that are kept.
const FAILURES: usize = 50;
/// Requests among which the slowest are looked for.
const REQUESTS: usize = 1000;
/// Slow requests that are told.
const SLOWEST: usize = 20;

/// The last requests and the last failures; older ones are forgotten.
#[derive(Debug, Default)]
pub struct Recent(Mutex<Lines>);

#[derive(Debug, Default)]
struct Lines {
    /// Requests for pictures and descriptions that had an answer other than a failure.
    answered: VecDeque<Line>,
    failures: VecDeque<Line>,
}

impl Recent {
    fn lock(&self) -> MutexGuard<'_, Lines> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Keeps a request, if it is about a model or has failed. Those of paths that nothing is at would push out all others.
    pub fn note(&self, line: Line) {
        if line.route == "other" {
            return;
        }
        let mut lines = self.lock();
        let (kept, most) = match line.error {
            Some(_) => (&mut lines.failures, FAILURES),
            None if line.source.is_some() => (&mut lines.answered, REQUESTS),
            None => return,
        };
        if kept.len() >= most {
            kept.pop_front();
        }
        kept.push_back(line);
    }

    /// The last failures, newest first.
    #[must_use]
    pub fn failures(&self) -> Vec<Line> {
        self.lock().failures.iter().rev().cloned().collect()
    }

    /// The slowest of the last requests that have not failed, slowest first.
    #[must_use]
    pub fn slowest(&self) -> Vec<Line> {
        let mut all: Vec<Line> = self.lock().answered.iter().cloned().collect();
        // Newer ones first among equals.
        all.reverse();
        all.sort_by(|a, b| b.total_ms.total_cmp(&a.total_ms));
        all.truncate(SLOWEST);
        all
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn memory_is_bounded() {
        let recent = Recent::default();
        for k in 0..3000 {
            let id = k.to_string();
            let source = Some("upload".to_owned());
            // 2 of 3 are slow: 1999 is the slowest of all, and older than the last thousand.
            let total_ms = f64::from(if k < 2000 { 10_000 + k } else { k });
            recent.note(Line { id: id.clone(), source: source.clone(), total_ms, ..Line::default() });
            recent.note(Line { id: id.clone(), error: Some("model"), ..Line::default() });
            recent.note(Line { id: id.clone(), total_ms: 1e9, ..Line::default() });
            recent.note(Line { id, route: "other", error: Some("not_found"), ..Line::default() });
        }
        let ids = |lines: Vec<Line>| lines.into_iter().map(|line| line.id).collect::<Vec<_>>();
        let expected = |count: usize| (0..count).map(|k| (2999 - k).to_string()).collect::<Vec<_>>();
        assert_eq!(ids(recent.failures()), expected(FAILURES));
        assert_eq!(ids(recent.slowest()), expected(SLOWEST));
        let lines = recent.lock();
        assert_eq!((lines.answered.len(), lines.failures.len()), (REQUESTS, FAILURES));
    }
}
