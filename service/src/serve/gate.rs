//! Admission to the workers: so many at a time, so many waiting by turns of their clients, and the rest is told to come again.

use super::error::{Kind, Problem};
use super::fair::{Client, Fair, Flow, Priority};
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;
use tokio::sync::{oneshot, watch};

/// The queue before the workers.
#[derive(Debug)]
pub struct Gate {
    shared: Arc<Shared>,
    queue: usize,
    patience: Duration,
    /// True when waiting requests are to be sent away.
    closed: watch::Sender<bool>,
    /// Number of finished works.
    works: AtomicU64,
    micros: AtomicU64,
}

#[derive(Debug)]
struct Shared {
    workers: usize,
    state: Mutex<State>,
}

#[derive(Debug, Default)]
struct State {
    fair: Fair<oneshot::Sender<()>>,
    working: usize,
}

/// Facts of a request that its turn depends on.
#[derive(Clone, Debug)]
pub struct Order {
    /// Client that has sent it.
    pub client: Client,
    /// Priority in the queue.
    pub priority: Priority,
    /// Price in units.
    pub price: u64,
    /// Workers that its client may have at a time.
    pub workers: usize,
}

/// A place in the queue.
#[derive(Debug)]
pub struct Place {
    shared: Arc<Shared>,
    flow: Flow,
    id: u64,
    granted: oneshot::Receiver<()>,
    is_taken: bool,
}

/// A worker's time.
#[derive(Debug)]
pub struct Turn {
    shared: Arc<Shared>,
    client: Client,
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Gives free workers to those whose turn it is.
    fn hand_out(&self, state: &mut State) {
        while state.working < self.workers
            && let Some((client, granted)) = state.fair.next()
        {
            // One who has gone has no place any more.
            if granted.send(()).is_ok() {
                state.working += 1;
            } else {
                state.fair.release(&client);
            }
        }
    }

    fn release(&self, client: &Client) {
        let mut state = self.lock();
        state.working = state.working.saturating_sub(1);
        state.fair.release(client);
        self.hand_out(&mut state);
    }
}

impl Drop for Turn {
    fn drop(&mut self) {
        self.shared.release(&self.client);
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        if self.is_taken {
            return;
        }
        self.granted.close();
        // A worker that was given in this moment is given back.
        if self.granted.try_recv().is_ok() {
            self.shared.release(&self.flow.client);
        } else {
            drop(self.shared.lock().fair.remove(&self.flow, self.id));
        }
    }
}

impl Gate {
    /// For so many workers, with so many places to wait.
    #[must_use]
    pub fn new(workers: usize, queue: usize, patience: Duration) -> Self {
        Self {
            shared: Arc::new(Shared { workers, state: Mutex::default() }),
            queue,
            patience,
            closed: watch::Sender::new(false),
            works: AtomicU64::new(0),
            micros: AtomicU64::new(0),
        }
    }

    /// Requests that have a worker, and requests that wait for one.
    #[must_use]
    pub fn load(&self) -> (usize, usize) {
        let state = self.shared.lock();
        (state.working, state.fair.waiting())
    }

    /// Takes a place, that of another client if there is none and that one has more of them.
    ///
    /// # Errors
    /// [`Kind::QueueFull`] if there is none.
    pub fn enter(&self, order: &Order) -> Result<Place, Problem> {
        let flow = Flow { client: order.client.clone(), priority: order.priority };
        let (send, granted) = oneshot::channel();
        let mut state = self.shared.lock();
        let id = state.fair.push(&flow, order.price, order.workers, send);
        self.shared.hand_out(&mut state);
        if state.fair.waiting() > self.queue && state.fair.push_out(&order.client).is_none() {
            drop(state.fair.remove(&flow, id));
            return Err(self.full());
        }
        drop(state);
        Ok(Place { shared: Arc::clone(&self.shared), flow, id, granted, is_taken: false })
    }

    fn full(&self) -> Problem {
        Problem::new(Kind::QueueFull, format!("{} requests wait already", self.queue))
            .limited("queue", "start the service with --queue N")
            .retry_after(self.seconds())
    }

    /// Estimate of the time until all waiting requests have been served.
    fn seconds(&self) -> u64 {
        let mean = self.micros.load(Relaxed).checked_div(self.works.load(Relaxed)).unwrap_or(0);
        let workers = self.shared.workers;
        let capacity = (workers + self.queue) as u64;
        (mean.saturating_mul(capacity) / workers.max(1) as u64 / 1_000_000).clamp(1, 60)
    }

    /// Waits for a turn, by turns of the clients.
    ///
    /// # Errors
    /// [`Kind::Busy`] if it takes too long, [`Kind::QueueFull`] if another client has taken the place, [`Kind::Stopping`].
    pub async fn turn(&self, mut place: Place) -> Result<Turn, Problem> {
        let mut closed = self.closed.subscribe();
        tokio::select! {
            biased;
            granted = &mut place.granted => match granted {
                Ok(()) => {
                    place.is_taken = true;
                    Ok(Turn { shared: Arc::clone(&place.shared), client: place.flow.client.clone() })
                }
                Err(_) => Err(self.full()),
            },
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

    fn order(name: &str) -> Order {
        Order { client: Client::Holder(name.into()), priority: Priority::Normal, price: 1, workers: 9 }
    }

    #[tokio::test]
    async fn the_queue_has_an_end() {
        let gate = Gate::new(1, 1, Duration::from_millis(20));
        let (first, second) = (gate.enter(&order("a")).unwrap(), gate.enter(&order("a")).unwrap());
        let full = gate.enter(&order("a")).unwrap_err();
        assert_eq!((full.kind, full.retry_after), (Kind::QueueFull, Some(1)));
        let turn = gate.turn(first).await.unwrap();
        assert_eq!(gate.load(), (1, 1));
        assert_eq!(gate.turn(second).await.unwrap_err().kind, Kind::Busy);
        assert_eq!(gate.load(), (1, 0));
        let third = gate.enter(&order("a")).unwrap();
        gate.close();
        assert_eq!(gate.turn(third).await.unwrap_err().kind, Kind::Stopping);
        drop(turn);
        assert_eq!(gate.load(), (0, 0));
        // A place that is given up with its worker gives it to the next.
        let (first, second) = (gate.enter(&order("a")).unwrap(), gate.enter(&order("a")).unwrap());
        assert_eq!(gate.load(), (1, 1));
        drop(first);
        assert_eq!(gate.load(), (1, 0));
        assert!(gate.turn(second).await.is_ok());
        assert_eq!(gate.load(), (0, 0));
    }

    #[tokio::test]
    async fn a_full_queue_has_a_place_for_another_client() {
        let gate = Gate::new(1, 2, Duration::from_secs(100));
        let mut greedy: Vec<Place> = (0..3).map(|_| gate.enter(&order("greedy")).unwrap()).collect();
        let turn = gate.turn(greedy.remove(0)).await.unwrap();
        let other = gate.enter(&order("other")).unwrap();
        // The newest of the greedy one has lost its place.
        assert_eq!(gate.turn(greedy.remove(1)).await.unwrap_err().kind, Kind::QueueFull);
        assert_eq!(gate.enter(&order("greedy")).unwrap_err().kind, Kind::QueueFull);
        assert_eq!(gate.enter(&order("other")).unwrap_err().kind, Kind::QueueFull);
        drop(turn);
        let turn = gate.turn(greedy.remove(0)).await.unwrap();
        assert_eq!(gate.load(), (1, 1));
        drop(turn);
        assert!(gate.turn(other).await.is_ok());
    }
}
