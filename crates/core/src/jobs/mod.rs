//! Ordered parallel map and for-each over fixed chunks. The only module that knows the thread pool.
//!
//! **Invariant:** results come back in the order of their inputs, and chunk borders never depend on the number of
//! threads. Whatever is computed with this module is the same for one thread as for sixty-four.

mod cancel;
mod parts;
mod pool;
mod scratch;

pub use cancel::Cancellation;
#[doc(hidden)]
pub use scratch::Scratch;

use parts::{Parts, part_size};
use pool::{Pool, divide};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Workers of one pool at most. More would take longer to start than most pictures take.
pub const MAX_THREADS: usize = 256;

/// A pool of worker threads.
pub struct Jobs {
    /// `None`: everything runs on the calling thread.
    pool: Option<Pool>,
    threads: usize,
    /// As many as there should be.
    wanted: usize,
    /// Stops the work that asks for it.
    cancellation: Option<Cancellation>,
}

impl std::fmt::Debug for Jobs {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Jobs").field("threads", &self.threads).finish()
    }
}

impl Default for Jobs {
    fn default() -> Self {
        Self::new(0)
    }
}

impl Jobs {
    /// A pool of `threads` workers, at most [`MAX_THREADS`]; 0 stands for one per processor. Where the system does not
    /// give so many, half of them, and so on down to the calling thread: [`Jobs::missing`] tells. Without the feature `threads`
    /// of the crate there is the calling thread alone.
    #[must_use]
    pub fn new(threads: usize) -> Self {
        let wanted = match threads {
            0 => std::thread::available_parallelism().map_or(1, usize::from),
            n => n,
        };
        let wanted = if cfg!(feature = "threads") { wanted.min(MAX_THREADS) } else { 1 };
        let mut threads = wanted;
        while threads > 1 {
            if let Some(pool) = Pool::new(threads) {
                return Self { pool: Some(pool), threads, wanted, cancellation: None };
            }
            threads /= 2;
        }
        Self { pool: None, threads: 1, wanted, cancellation: None }
    }

    /// Lets somebody stop the work that follows; `None`: nobody. Loops run to their end all the same: work that can be left
    /// unfinished asks [`Jobs::is_cancelled`].
    #[doc(hidden)]
    pub fn cancel_by(&mut self, cancellation: Option<Cancellation>) {
        self.cancellation = cancellation;
    }

    /// Stops the work, if somebody can.
    #[doc(hidden)]
    #[must_use]
    pub fn cancellation(&self) -> Option<&Cancellation> {
        self.cancellation.as_ref()
    }

    /// True once the work is stopped.
    #[doc(hidden)]
    #[must_use]
    pub fn is_cancelled(&self) -> bool {
        self.cancellation.as_ref().is_some_and(Cancellation::is_cancelled)
    }

    /// Workers that were wanted and that the system did not give.
    #[must_use]
    pub fn missing(&self) -> usize {
        self.wanted - self.threads
    }

    /// Number of workers, at least 1.
    #[must_use]
    pub fn threads(&self) -> usize {
        self.threads
    }

    /// `f(0), f(1), ... f(count - 1)` in that order, computed in parallel.
    #[doc(hidden)]
    pub fn map<T: Send>(&self, count: usize, f: impl Fn(usize) -> T + Sync) -> Vec<T> {
        let mut results: Vec<Option<T>> = Vec::new();
        results.resize_with(count, || None);
        self.for_each_mut(&mut results, |k, result| *result = Some(f(k)));
        results.into_iter().flatten().collect()
    }

    /// `f` of every item in their order, computed in parallel.
    #[doc(hidden)]
    pub fn map_each<'a, I: Sync, T: Send>(&self, items: &'a [I], f: impl Fn(&'a I) -> T + Sync) -> Vec<T> {
        let mut results: Vec<Option<T>> = Vec::new();
        results.resize_with(items.len(), || None);
        let size = part_size(items.len());
        let parts = items.chunks(size).zip(results.chunks_mut(size));
        let parts = Parts::new(size, parts.map(|(items, results)| items.iter().zip(results)));
        self.on_workers(items.len(), &|worker| {
            parts.take_all(worker, self.threads, |_, (item, result)| *result = Some(f(item)));
        });
        results.into_iter().flatten().collect()
    }

    /// Runs `f` on one of the workers, where the other methods begin at once: from any other thread, each of them hands
    /// its work over, sleeps and is woken.
    ///
    /// Handing over takes a place in the pool's queue, which allocates a block of 63 places at a time: about 1.5 KB for
    /// every 63 calls. Nothing else here takes memory, but for the results of [`Jobs::map`], [`Jobs::map_each`] and
    /// [`Jobs::on_every_worker`].
    #[doc(hidden)]
    pub fn on_worker<T: Send>(&self, f: impl FnOnce() -> T + Send) -> T {
        match &self.pool {
            Some(pool) => pool.install(f),
            None => f(),
        }
    }

    /// `f()` once on every worker, for questions about the threads themselves.
    #[doc(hidden)]
    pub fn on_every_worker<T: Send>(&self, f: impl Fn() -> T + Sync) -> Vec<T> {
        match &self.pool {
            Some(pool) => pool.broadcast(f),
            None => vec![f()],
        }
    }

    /// Calls `f(k, &mut items[k])` for every item, in parallel.
    #[doc(hidden)]
    pub fn for_each_mut<T: Send>(&self, items: &mut [T], f: impl Fn(usize, &mut T) + Sync) {
        let (count, size) = (items.len(), part_size(items.len()));
        let parts = Parts::new(size, items.chunks_mut(size).map(<[T]>::iter_mut));
        self.on_workers(count, &|worker| parts.take_all(worker, self.threads, &f));
    }

    /// Calls `f(k, chunk)` for every run of `size` items (the last may be shorter), in parallel. `size` of 0 counts
    /// as 1.
    #[doc(hidden)]
    pub fn for_each_chunk_mut<T: Send>(
        &self,
        items: &mut [T],
        size: usize,
        f: impl Fn(usize, &mut [T]) + Sync,
    ) {
        let size = size.max(1);
        let count = items.len().div_ceil(size);
        let chunks = part_size(count);
        let parts = items.chunks_mut(chunks.saturating_mul(size));
        let parts = Parts::new(chunks, parts.map(|part| part.chunks_mut(size)));
        self.on_workers(count, &|worker| parts.take_all(worker, self.threads, &f));
    }

    /// Calls `f(own, k, &mut items[k])` for every item, in parallel, where `own` is of `scratch`, and no other call has
    /// it at that time. Which one it gets depends on timing, so `f` must not let it show in its result. There is one for
    /// each worker; they stay for the next call.
    #[doc(hidden)]
    pub fn for_each_with_scratch<T: Send, S: Send + Default>(
        &self,
        scratch: &mut Scratch<S>,
        items: &mut [T],
        f: impl Fn(&mut S, usize, &mut T) + Sync,
    ) {
        scratch.provide(self.threads);
        let (count, size) = (items.len(), part_size(items.len()));
        let parts = Parts::new(size, items.chunks_mut(size).map(<[T]>::iter_mut));
        self.on_workers(count, &|worker| {
            scratch.with(worker, |own| parts.take_all(worker, self.threads, |k, item| f(own, k, item)));
        });
    }

    /// Calls `work` with the number of the worker that it is on: on one of them if there is only one item, otherwise on
    /// as many as are free. Not generic: the pool's machinery is compiled once, not for every loop of the program.
    fn on_workers(&self, items: usize, work: &(dyn Fn(usize) + Sync)) {
        match &self.pool {
            Some(pool) if items > 1 => {
                let work = || work(pool.this_thread());
                pool.install(|| divide(items.min(self.threads), &work));
            }
            _ => work(0),
        }
    }
}

/// The guarded value, also after a worker has panicked: the panic itself is passed on by the pool.
pub fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn map_keeps_the_order_for_any_number_of_threads() {
        let expected: Vec<usize> = (0..1000).map(|k| k * k).collect();
        for threads in [1, 2, 3, 7] {
            assert_eq!(Jobs::new(threads).map(1000, |k| k * k), expected);
            let items: Vec<usize> = (0..1000).collect();
            assert_eq!(Jobs::new(threads).map_each(&items, |k| k * k), expected);
        }
    }

    #[test]
    fn work_of_a_worker_is_done_in_order_too() {
        for threads in [1, 3] {
            let jobs = Jobs::new(threads);
            let inside = jobs.on_worker(|| jobs.map(100, |k| k + 1));
            assert_eq!(inside, (1..=100).collect::<Vec<_>>());
            let (mut scratch, mut items) = (Scratch::<u64>::default(), [0_usize; 50]);
            jobs.for_each_with_scratch(&mut scratch, &mut items, |sum, k, item| {
                *sum += 1;
                *item = k;
            });
            assert_eq!(scratch.iter_mut().count(), threads);
            assert_eq!(scratch.iter_mut().map(|count| *count).sum::<u64>(), 50);
            assert!(items.iter().enumerate().all(|(k, &item)| item == k));
        }
    }

    #[test]
    fn every_item_is_visited_once_by_any_number_of_threads() {
        for threads in [1, 2, 5, 16, 40] {
            let jobs = Jobs::new(threads);
            for count in [0, 1, 2, 15, 16, 17, 100] {
                let mut visits = vec![Vec::new(); count];
                jobs.for_each_mut(&mut visits, |k, visits| visits.push(k));
                assert!(visits.iter().enumerate().all(|(k, visits)| *visits == [k]), "{threads}, {count}");
            }
        }
    }

    /// A worker that waits for an inner loop may be given more of the outer one, whose memory it holds already.
    #[test]
    fn loops_within_loops_come_to_their_end() {
        let jobs = Jobs::new(4);
        let mut scratch = Scratch::<Vec<usize>>::default();
        for _ in 0..50 {
            let mut items = [0; 40];
            jobs.for_each_with_scratch(&mut scratch, &mut items, |own, k, item| {
                own.clear();
                own.extend(jobs.map(20, |n| n * k));
                *item = own.iter().sum();
            });
            assert!(items.iter().enumerate().all(|(k, &item)| item == 190 * k));
        }
    }

    #[test]
    fn what_a_panic_left_half_done_is_not_used_again() {
        for threads in [1, 2] {
            let jobs = Jobs::new(threads);
            let mut scratch = Scratch::<bool>::default();
            let mut begin = |panics: bool| {
                let mut items = [0; 8];
                jobs.for_each_with_scratch(&mut scratch, &mut items, |is_half_done, k, _| {
                    assert!(!std::mem::replace(is_half_done, true));
                    assert!(!(panics && k == 3), "halfway");
                    *is_half_done = false;
                });
            };
            let caught = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| begin(true)));
            assert!(caught.is_err());
            begin(false);
        }
    }

    #[test]
    fn every_chunk_is_visited_once() {
        let mut items = vec![0; 1001];
        Jobs::new(3)
            .for_each_chunk_mut(&mut items, 64, |k, chunk| chunk.iter_mut().for_each(|i| *i += k + 1));
        assert!(items.iter().enumerate().all(|(k, &i)| i == k / 64 + 1));
    }
}
