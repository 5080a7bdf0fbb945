//! Renderers that wait for work. Each has worker threads of its own, so that several threads of Python can draw at once.
//!
//! **Forks.** The child of a fork has no thread but the one that forked: a pool of the parent would never answer. So every list
//! belongs to the process that it was made in, and another process begins with an empty one; what the parent had is leaked
//! there, since taking it down would wait for threads that do not exist. The lock is held only while the interpreter is, and a
//! fork is made by a thread that holds it: no child ever finds the lock taken.

use crate::arithmetic::DefaultArithmetic;
use crate::signals::interruptible;
use overcoat::Renderer;
use overcoat::frame::Frame;
use overcoat::render::Cancellation;
use pyo3::prelude::*;
use std::mem;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Renderers and frames that are kept at most: more threads than this seldom draw at the same time.
const KEPT: usize = 4;

/// Pixels of frames that are kept: larger ones are seldom drawn one after the other, and hold 28 bytes a pixel.
const KEPT_PIXELS: usize = 1 << 21;

/// See the module.
#[derive(Debug)]
pub(crate) struct Pool {
    pub(crate) threads: usize,
    idle: Mutex<Idle>,
}

#[derive(Debug)]
struct Idle {
    /// The process that they belong to.
    process: u32,
    renderers: Vec<Renderer>,
    /// Whose memory the next pictures take.
    frames: Vec<Frame>,
}

impl Idle {
    fn new() -> Self {
        Self { process: std::process::id(), renderers: Vec::new(), frames: Vec::new() }
    }
}

impl Drop for Idle {
    fn drop(&mut self) {
        if self.process != std::process::id() {
            mem::forget(mem::take(&mut self.renderers));
        }
    }
}

impl Pool {
    /// `threads` workers for each renderer; 0 for one per processor.
    pub(crate) fn new(threads: usize) -> Self {
        Self { threads, idle: Mutex::new(Idle::new()) }
    }

    /// Calls `f` with a renderer, without the interpreter, in default arithmetic. Ctrl-C stops the picture that it draws.
    ///
    /// # Errors
    /// Exceptions of handlers of signals, such as `KeyboardInterrupt`.
    pub(crate) fn with<T: Send>(
        &self,
        py: Python<'_>,
        f: impl FnOnce(&mut Renderer) -> T + Send,
    ) -> PyResult<T> {
        let (kept, frame) = {
            let mut idle = self.lock();
            (idle.renderers.pop(), idle.frames.pop())
        };
        let threads = self.threads;
        let cancellation = Cancellation::new();
        let ((renderer, result), raised) = interruptible(py, &cancellation, || {
            let _arithmetic = DefaultArithmetic::new();
            let mut renderer = kept.unwrap_or_else(|| Renderer::new(threads));
            if let Some(frame) = frame {
                renderer.recycle(frame);
            }
            renderer.cancel_by(Some(cancellation.clone()));
            let result = f(&mut renderer);
            renderer.cancel_by(None);
            (renderer, result)
        });
        let mut idle = self.lock();
        if idle.renderers.len() < KEPT {
            idle.renderers.push(renderer);
        }
        drop(idle);
        raised.map_or(Ok(result), Err)
    }

    /// Takes back the memory of a picture that nobody looks at any more. Only with the interpreter.
    pub(crate) fn recycle(&self, frame: Frame) {
        let mut idle = self.lock();
        if idle.frames.len() < KEPT && frame.pixels.len() <= KEPT_PIXELS {
            idle.frames.push(frame);
        }
    }

    /// Locked list of what is idle in this process. A forked process begins with an empty one.
    fn lock(&self) -> MutexGuard<'_, Idle> {
        let mut idle = self.idle.lock().unwrap_or_else(PoisonError::into_inner);
        if idle.process != std::process::id() {
            // The old list leaks its renderers as it is dropped.
            *idle = Idle::new();
        }
        idle
    }
}
