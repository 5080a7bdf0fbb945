//! Ordered parallel map and for-each over fixed chunks. The only module that knows the thread pool.
//!
//! **Invariant:** results come back in the order of their inputs, and chunk borders never depend on the number of
//! threads. Whatever is computed with this module is the same for one thread as for sixty-four.

use std::sync::Mutex;

/// A pool of worker threads.
pub struct Jobs {
    /// `None`: everything runs on the calling thread.
    pool: Option<rayon::ThreadPool>,
    threads: usize,
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
    /// A pool of `threads` workers; 0 stands for one per processor. Falls back to the calling thread where the
    /// system gives no threads.
    #[must_use]
    pub fn new(threads: usize) -> Self {
        let wanted = match threads {
            0 => std::thread::available_parallelism().map_or(1, usize::from),
            n => n.min(1024),
        };
        if wanted == 1 {
            return Self { pool: None, threads: 1 };
        }
        match rayon::ThreadPoolBuilder::new()
            .num_threads(wanted)
            .thread_name(|k| format!("overcoat-{k}"))
            .build()
        {
            Ok(pool) => Self { pool: Some(pool), threads: wanted },
            Err(_) => Self { pool: None, threads: 1 },
        }
    }

    /// Number of workers, at least 1.
    #[must_use]
    pub fn threads(&self) -> usize {
        self.threads
    }

    /// `f(0), f(1), ... f(count - 1)` in that order, computed in parallel.
    pub fn map<T: Send>(&self, count: usize, f: impl Fn(usize) -> T + Sync) -> Vec<T> {
        if self.pool.is_none() || count < 2 {
            return (0..count).map(f).collect();
        }
        let mut results: Vec<Option<T>> = Vec::new();
        results.resize_with(count, || None);
        self.for_each_mut(&mut results, |k, result| *result = Some(f(k)));
        results.into_iter().flatten().collect()
    }

    /// `f` of every item in their order, computed in parallel.
    pub fn map_each<'a, I: Sync, T: Send>(&self, items: &'a [I], f: impl Fn(&'a I) -> T + Sync) -> Vec<T> {
        if self.pool.is_none() || items.len() < 2 {
            return items.iter().map(f).collect();
        }
        let mut results: Vec<Option<T>> = Vec::new();
        results.resize_with(items.len(), || None);
        let pairs = items.iter().zip(&mut results);
        self.share(items.len(), pairs, &|_, (item, result): (&'a I, &mut Option<T>)| *result = Some(f(item)));
        results.into_iter().flatten().collect()
    }

    /// Runs `f` on one of the workers, where the other methods begin at once: from any other thread, each of them hands
    /// its work over, sleeps and is woken.
    ///
    /// Handing over takes a place in the pool's queue, which allocates a block of 63 places at a time: about 1.5 KB for
    /// every 63 calls. Nothing else here takes memory, but for the results of [`Jobs::map`], [`Jobs::map_each`] and
    /// [`Jobs::on_every_worker`].
    pub fn on_worker<T: Send>(&self, f: impl FnOnce() -> T + Send) -> T {
        match &self.pool {
            Some(pool) => pool.install(f),
            None => f(),
        }
    }

    /// `f()` once on every worker, for questions about the threads themselves.
    pub fn on_every_worker<T: Send>(&self, f: impl Fn() -> T + Sync) -> Vec<T> {
        match &self.pool {
            Some(pool) => pool.broadcast(|_| f()),
            None => vec![f()],
        }
    }

    /// Calls `f(k, &mut items[k])` for every item, in parallel.
    pub fn for_each_mut<T: Send>(&self, items: &mut [T], f: impl Fn(usize, &mut T) + Sync) {
        let count = items.len();
        self.share(count, items.iter_mut(), &f);
    }

    /// Calls `f(k, chunk)` for every run of `size` items (the last may be shorter), in parallel. `size` of 0 counts
    /// as 1.
    pub fn for_each_chunk_mut<T: Send>(
        &self,
        items: &mut [T],
        size: usize,
        f: impl Fn(usize, &mut [T]) + Sync,
    ) {
        let chunks = items.chunks_mut(size.max(1));
        self.share(chunks.len(), chunks, &f);
    }

    /// Calls `f(scratch, k, &mut items[k])` for every item, in parallel, where each call has one of the `scratch`
    /// values to itself. Which one it gets depends on timing, so `f` must not let it show in its result. There is one
    /// for each worker; they stay for the next call.
    pub fn for_each_with_scratch<T: Send, S: Send + Default>(
        &self,
        scratch: &mut Vec<S>,
        items: &mut [T],
        f: impl Fn(&mut S, usize, &mut T) + Sync,
    ) {
        if scratch.len() < self.threads {
            scratch.resize_with(self.threads, S::default);
        }
        let free = Mutex::new(std::mem::take(scratch));
        let count = items.len();
        self.share(count, items.iter_mut(), &|k, item| {
            let mut own = lock(&free).pop().unwrap_or_default();
            f(&mut own, k, item);
            lock(&free).push(own);
        });
        *scratch = free.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner);
    }

    /// Calls `f(k, item)` for each of `count` items, in parallel: whoever is free takes the next one.
    fn share<I: Send>(
        &self,
        count: usize,
        items: impl Iterator<Item = I> + Send,
        f: &(impl Fn(usize, I) + Sync + ?Sized),
    ) {
        match &self.pool {
            Some(pool) if count > 1 => {
                let next = Mutex::new(items.enumerate());
                let work = || {
                    while let Some((k, item)) = take(&next) {
                        f(k, item);
                    }
                };
                install(pool, count.min(self.threads), &work);
            }
            _ => items.enumerate().for_each(|(k, item)| f(k, item)),
        }
    }
}

/// The next item; the lock is free again when this comes back.
fn take<T>(items: &Mutex<impl Iterator<Item = T>>) -> Option<T> {
    lock(items).next()
}

/// Runs `work` so many times, on as many workers of the pool as are free. Not generic: the pool's machinery is compiled
/// once, not for every loop of the program.
fn install(pool: &rayon::ThreadPool, count: usize, work: &(dyn Fn() + Sync)) {
    pool.install(|| on_workers(count, work));
}

fn on_workers(count: usize, work: &(dyn Fn() + Sync)) {
    if count < 2 {
        return work();
    }
    let half = count / 2;
    rayon::join(|| on_workers(count - half, work), || on_workers(half, work));
}

/// The guarded value, also after a worker has panicked: the panic itself is passed on by the pool.
fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
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
            let (mut scratch, mut items) = (Vec::<u64>::new(), [0_usize; 50]);
            jobs.for_each_with_scratch(&mut scratch, &mut items, |sum, k, item| {
                *sum += 1;
                *item = k;
            });
            assert_eq!((scratch.len(), scratch.iter().sum::<u64>()), (threads, 50));
            assert!(items.iter().enumerate().all(|(k, &item)| item == k));
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
