//! Ctrl-C while a picture is drawn: the interpreter looks for signals every few milliseconds, and what they raise stops the picture.

use overcoat::render::Cancellation;
use pyo3::prelude::*;
use std::io;
use std::sync::{Condvar, Mutex, PoisonError};
use std::time::Duration;

/// Time between two looks.
const INTERVAL: Duration = Duration::from_millis(10);

/// Stack of the thread that draws: as large as that of a main thread usually is.
const STACK: usize = 8 << 20;

/// Calls `f` without the interpreter. In the main thread, where alone Python handles signals, another thread does the work, and an
/// exception of a handler, such as `KeyboardInterrupt`, cancels it and is returned beside what came of it.
pub(crate) fn interruptible<T: Send>(
    py: Python<'_>,
    cancellation: &Cancellation,
    f: impl FnOnce() -> T + Send,
) -> (T, Option<PyErr>) {
    if !is_main_thread(py) {
        return (py.detach(f), None);
    }
    let done = Done::default();
    std::thread::scope(|scope| {
        let started = std::thread::Builder::new().stack_size(STACK).spawn_scoped(scope, || {
            let _end = End(&done);
            f()
        });
        let worker = match started {
            Ok(worker) => worker,
            Err(error) => panic_of(&error),
        };
        let mut raised = None;
        while !py.detach(|| done.wait(INTERVAL)) {
            if raised.is_none()
                && let Err(error) = py.check_signals()
            {
                cancellation.cancel();
                raised = Some(error);
            }
        }
        match py.detach(|| worker.join()) {
            Ok(result) => (result, raised),
            Err(panic) => std::panic::resume_unwind(panic),
        }
    })
}

/// Threads that cannot be started leave nothing to do, as in the renderer's own pool.
fn panic_of(error: &io::Error) -> ! {
    panic!("no thread can be started: {error}")
}

/// True in the interpreter's main thread.
fn is_main_thread(py: Python<'_>) -> bool {
    let same = || -> PyResult<bool> {
        let threading = py.import("threading")?;
        let own: u64 = threading.call_method0("get_ident")?.extract()?;
        let main: u64 = threading.call_method0("main_thread")?.getattr("ident")?.extract()?;
        Ok(own == main)
    };
    same().unwrap_or(false)
}

/// Tells one thread that another is done.
#[derive(Default)]
struct Done {
    is_done: Mutex<bool>,
    changed: Condvar,
}

impl Done {
    /// True as soon as it is done, false after that time.
    fn wait(&self, time: Duration) -> bool {
        let is_done = self.is_done.lock().unwrap_or_else(PoisonError::into_inner);
        let waited = self.changed.wait_timeout_while(is_done, time, |is_done| !*is_done);
        *waited.unwrap_or_else(PoisonError::into_inner).0
    }
}

/// Says that it is done as it is dropped, after a panic too.
struct End<'a>(&'a Done);

impl Drop for End<'_> {
    fn drop(&mut self) {
        *self.0.is_done.lock().unwrap_or_else(PoisonError::into_inner) = true;
        self.0.changed.notify_all();
    }
}
