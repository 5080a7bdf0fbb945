//! The two streams between a worker and its parent.

use crate::failure::Failure;
use crate::protocol::{self, FromWorker, ToWorker};
use std::io::{self, BufReader, Stdin, Stdout, StdoutLock};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Standard input and output. One question at a time: threads that load textures share it.
pub(crate) struct Pipe {
    streams: Mutex<Streams>,
}

struct Streams {
    from: BufReader<Stdin>,
    to: Stdout,
}

impl Pipe {
    pub(crate) fn standard() -> Self {
        Self { streams: Mutex::new(Streams { from: BufReader::new(io::stdin()), to: io::stdout() }) }
    }

    fn lock(&self) -> MutexGuard<'_, Streams> {
        self.streams.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The next message; `None` when the parent has no more.
    ///
    /// # Errors
    /// [`Failure`] if the parent is gone in the middle of one.
    pub(crate) fn receive(&self) -> Result<Option<(ToWorker, Vec<u8>)>, Failure> {
        protocol::receive(&mut self.lock().from).map_err(lost)
    }

    /// Says something.
    ///
    /// # Errors
    /// [`Failure`] if the parent is gone.
    pub(crate) fn send(&self, message: &FromWorker, following: &[u8]) -> Result<(), Failure> {
        let mut out: StdoutLock<'_> = self.lock().to.lock();
        protocol::send(&mut out, message, following).map_err(lost)
    }

    /// Says something, and waits for the answer.
    pub(crate) fn ask(&self, message: &FromWorker) -> io::Result<Option<(ToWorker, Vec<u8>)>> {
        let mut streams = self.lock();
        protocol::send(&mut streams.to, message, &[])?;
        protocol::receive(&mut streams.from)
    }
}

fn lost(error: io::Error) -> Failure {
    Failure::failed(format!("the worker's parent is gone: {error}"))
}
