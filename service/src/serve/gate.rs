//! Admission to the workers: so many at a time, so many waiting, and the rest is told to come again.

use super::error::{Kind, Problem};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
use std::time::Duration;
use tokio::sync::{OwnedSemaphorePermit, Semaphore, watch};

/// The queue before the workers.
#[derive(Debug)]
pub struct Gate {
    places: Arc<Semaphore>,
    turns: Arc<Semaphore>,
    capacity: usize,
    workers: usize,
    patience: Duration,
    /// True when waiting requests are to be sent away.
    closed: watch::Sender<bool>,
    /// Number of finished works.
    works: AtomicU64,
    micros: AtomicU64,
}

/// A place in the queue.
#[derive(Debug)]
pub struct Place(#[expect(dead_code, reason = "kept, not looked at")] OwnedSemaphorePermit);

/// A worker's time.
#[derive(Debug)]
pub struct Turn(#[expect(dead_code, reason = "kept, not looked at")] OwnedSemaphorePermit);

impl Gate {
    /// For so many workers, with so many places to wait.
    #[must_use]
    pub fn new(workers: usize, queue: usize, patience: Duration) -> Self {
        let capacity = workers + queue;
        Self {
            places: Arc::new(Semaphore::new(capacity)),
            turns: Arc::new(Semaphore::new(workers)),
            capacity,
            workers,
            patience,
            closed: watch::Sender::new(false),
            works: AtomicU64::new(0),
            micros: AtomicU64::new(0),
        }
    }

    /// Requests that have a worker, and requests that wait for one.
    #[must_use]
    pub fn load(&self) -> (usize, usize) {
        let working = self.workers - self.turns.available_permits();
        (working, (self.capacity - self.places.available_permits()).saturating_sub(working))
    }

    /// Takes a place.
    ///
    /// # Errors
    /// [`Kind::QueueFull`] if there is none.
    pub fn enter(&self) -> Result<Place, Problem> {
        let place = Arc::clone(&self.places).try_acquire_owned();
        place.map(Place).map_err(|_| {
            let waiting = self.capacity - self.workers;
            Problem::new(Kind::QueueFull, format!("{waiting} requests wait already"))
                .limited("queue", "start the service with --queue N")
                .retry_after(self.seconds())
        })
    }

    /// Estimate of the time until all waiting requests have been served.
    fn seconds(&self) -> u64 {
        let mean = self.micros.load(Relaxed).checked_div(self.works.load(Relaxed)).unwrap_or(0);
        (mean * self.capacity as u64 / self.workers.max(1) as u64 / 1_000_000).clamp(1, 60)
    }

    /// Waits for a turn, in the order of arrival.
    ///
    /// # Errors
    /// [`Kind::Busy`] if it takes too long, [`Kind::Stopping`].
    pub async fn turn(&self) -> Result<Turn, Problem> {
        let mut closed = self.closed.subscribe();
        let turn = Arc::clone(&self.turns).acquire_owned();
        tokio::select! {
            biased;
            turn = turn => turn.map(Turn).map_err(|_| Problem::new(Kind::Stopping, "the service stops")),
            _ = closed.wait_for(|closed| *closed) => Err(Problem::new(Kind::Stopping, "the service stops")),
            () = tokio::time::sleep(self.patience) => {
                let message = format!("no worker was free within {} s", self.patience.as_secs_f64());
                Err(Problem::new(Kind::Busy, message)
                    .limited("queue_seconds", "start the service with --queue-seconds SECONDS")
                    .retry_after(self.seconds()))
            }
        }
    }

    /// Records the duration of a work.
    pub fn note(&self, time: Duration) {
        self.works.fetch_add(1, Relaxed);
        self.micros.fetch_add(time.as_micros() as u64, Relaxed);
    }

    /// Sends away the waiting requests.
    pub fn close(&self) {
        self.closed.send_replace(true);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test]
    async fn the_queue_has_an_end() {
        let gate = Gate::new(1, 1, Duration::from_millis(20));
        let (first, second) = (gate.enter().unwrap(), gate.enter().unwrap());
        let full = gate.enter().unwrap_err();
        assert_eq!((full.kind, full.retry_after), (Kind::QueueFull, Some(1)));
        let turn = gate.turn().await.unwrap();
        assert_eq!(gate.load(), (1, 1));
        assert_eq!(gate.turn().await.unwrap_err().kind, Kind::Busy);
        gate.close();
        assert_eq!(gate.turn().await.unwrap_err().kind, Kind::Stopping);
        drop((turn, first));
        assert!(gate.enter().is_ok());
        drop(second);
    }
}
