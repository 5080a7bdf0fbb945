//! The threads of a pool: rayon's, or none at all.

#[cfg(feature = "threads")]
#[derive(Debug)]
pub(super) struct Pool(rayon::ThreadPool);

#[cfg(feature = "threads")]
impl Pool {
    /// Pool of so many threads, if the system gives them.
    pub(super) fn new(threads: usize) -> Option<Self> {
        let builder = rayon::ThreadPoolBuilder::new().num_threads(threads);
        builder.thread_name(|k| format!("overcoat-{k}")).build().ok().map(Self)
    }

    /// Runs `f` on one of the threads.
    pub(super) fn install<T: Send>(&self, f: impl FnOnce() -> T + Send) -> T {
        self.0.install(f)
    }

    /// `f()` once on every thread.
    pub(super) fn broadcast<T: Send>(&self, f: impl Fn() -> T + Sync) -> Vec<T> {
        self.0.broadcast(|_| f())
    }

    /// The number of the thread that this runs on; 0 on others.
    pub(super) fn this_thread(&self) -> usize {
        self.0.current_thread_index().unwrap_or(0)
    }
}

/// Runs `work` so many times, on as many workers as are free.
#[cfg(feature = "threads")]
pub(super) fn divide(count: usize, work: &(dyn Fn() + Sync)) {
    if count < 2 {
        return work();
    }
    let half = count / 2;
    rayon::join(|| divide(count - half, work), || divide(half, work));
}

/// There is none.
#[cfg(not(feature = "threads"))]
#[derive(Debug)]
pub(super) enum Pool {}

#[cfg(not(feature = "threads"))]
impl Pool {
    pub(super) fn new(_: usize) -> Option<Self> {
        None
    }

    pub(super) fn install<T: Send>(&self, _: impl FnOnce() -> T + Send) -> T {
        match *self {}
    }

    pub(super) fn broadcast<T: Send>(&self, _: impl Fn() -> T + Sync) -> Vec<T> {
        match *self {}
    }

    pub(super) fn this_thread(&self) -> usize {
        match *self {}
    }
}

#[cfg(not(feature = "threads"))]
pub(super) fn divide(_: usize, work: &(dyn Fn() + Sync)) {
    work();
}
