//! Working memory of each worker.

use std::sync::{Mutex, PoisonError, TryLockError};

/// One value for each worker, kept from loop to loop: what a worker wrote last is still in its cache.
#[derive(Debug)]
pub struct Scratch<S>(Vec<OwnLines<Mutex<S>>>);

/// Shares no cache line with anything else, nor one that processors fetch along with another.
#[derive(Debug, Default)]
#[repr(align(128))]
struct OwnLines<T>(T);

impl<S> Default for Scratch<S> {
    fn default() -> Self {
        Self(Vec::new())
    }
}

impl<S: Default> Scratch<S> {
    /// Makes sure that there is one for each of `workers` workers.
    pub(super) fn provide(&mut self, workers: usize) {
        if self.0.len() < workers {
            self.0.resize_with(workers, OwnLines::default);
        }
    }

    /// Calls `f` with the worker's own value, or with a new one where that is in use: by a call on the same worker that
    /// waits for this one.
    pub(super) fn with(&self, worker: usize, f: impl FnOnce(&mut S)) {
        let mut guard;
        let mut spare;
        let own = &self.0[worker].0;
        let own = match own.try_lock() {
            Ok(held) => {
                guard = held;
                &mut *guard
            }
            // What a panic left half done is of no use. The panic itself is passed on by the pool.
            Err(TryLockError::Poisoned(left)) => {
                own.clear_poison();
                guard = left.into_inner();
                *guard = S::default();
                &mut *guard
            }
            Err(TryLockError::WouldBlock) => {
                spare = S::default();
                &mut spare
            }
        };
        f(own);
    }

    /// The values of all workers.
    pub fn iter_mut(&mut self) -> impl Iterator<Item = &mut S> {
        self.0.iter_mut().map(|own| own.0.get_mut().unwrap_or_else(PoisonError::into_inner))
    }
}
