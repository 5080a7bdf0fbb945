//! Admission to the workers: so many at a time, so many waiting by turns of their clients, and the rest is told to come again, at once
//! where it would wait in vain.

use super::error::{Kind, Problem};
use super::fair::{Client, Fair, Flow, Next, Priority};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;
use tokio::sync::{oneshot, watch};

/// Finished works from which the time of a unit is known well enough to refuse by it.
const KNOWN: u32 = 16;
/// Finished works after which older ones count half.
const MOST_KNOWN: u32 = 256;

/// The queue before the workers.
#[derive(Debug)]
pub struct Gate {
    shared: Arc<Shared>,
    queue: usize,
    patience: Duration,
    /// True when waiting requests are to be sent away.
    closed: watch::Sender<bool>,
}

#[derive(Debug)]
struct Shared {
    workers: usize,
    /// Further workers, for cheap requests while dear ones of other clients are under way.
    spare: usize,
    state: Mutex<State>,
}

#[derive(Debug, Default)]
struct State {
    fair: Fair<oneshot::Sender<bool>>,
    working: usize,
    pace: Pace,
}

/// Time that workers took for what they did, the older the less.
#[derive(Debug, Default)]
struct Pace {
    works: u32,
    units: u64,
    micros: u64,
}

impl Pace {
    fn note(&mut self, price: u64, time: Duration) {
        if self.works >= MOST_KNOWN {
            (self.works, self.units, self.micros) = (self.works / 2, self.units / 2, self.micros / 2);
        }
        self.works += 1;
        self.units = self.units.saturating_add(price);
        self.micros = self.micros.saturating_add(time.as_micros() as u64);
    }

    /// Time that so many workers take for units.
    fn of(&self, units: u64, workers: usize) -> Duration {
        let units = u128::from(units).saturating_mul(u128::from(self.micros));
        let micros = units / u128::from(self.units.max(1)) / workers.max(1) as u128;
        Duration::from_micros(u64::try_from(micros).unwrap_or(u64::MAX))
    }
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
    granted: oneshot::Receiver<bool>,
    is_taken: bool,
}

/// A worker's time.
#[derive(Debug)]
pub struct Turn {
    shared: Arc<Shared>,
    client: Client,
    is_dear: bool,
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Gives free workers to those whose turn it is.
    fn hand_out(&self, state: &mut State) {
        while let Some(Next { client, is_dear, value: granted }) = self.next(state) {
            // One who has gone has no place any more.
            if granted.send(is_dear).is_ok() {
                state.working += 1;
            } else {
                state.fair.release(&client, is_dear);
            }
        }
    }

    /// The request that a worker is free for.
    fn next(&self, state: &mut State) -> Option<Next<oneshot::Sender<bool>>> {
        if state.working < self.workers {
            return state.fair.next();
        }
        let has_spare = state.working < self.workers + self.spare;
        has_spare.then(|| state.fair.next_cheap()).flatten()
    }

    fn release(&self, client: &Client, is_dear: bool) {
        let mut state = self.lock();
        state.working = state.working.saturating_sub(1);
        state.fair.release(client, is_dear);
        self.hand_out(&mut state);
    }
}

impl Drop for Turn {
    fn drop(&mut self) {
        self.shared.release(&self.client, self.is_dear);
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        if self.is_taken {
            return;
        }
        self.granted.close();
        // A worker that was given in this moment is given back.
        if let Ok(is_dear) = self.granted.try_recv() {
            self.shared.release(&self.flow.client, is_dear);
        } else {
            drop(self.shared.lock().fair.remove(&self.flow, self.id));
        }
    }
}

impl Gate {
    /// For so many workers, and so many spare ones for cheap requests while dear ones of other clients are under way, with so many places
    /// to wait.
    #[must_use]
    pub fn new(workers: usize, spare: usize, queue: usize, patience: Duration) -> Self {
        let shared = Arc::new(Shared { workers, spare, state: Mutex::default() });
        Self { shared, queue, patience, closed: watch::Sender::new(false) }
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
    /// [`Kind::QueueFull`] if there is none, [`Kind::Busy`] if the requests before it take longer than it may wait.
    pub fn enter(&self, order: &Order) -> Result<Place, Problem> {
        let flow = Flow { client: order.client.clone(), priority: order.priority };
        let (granted, receive) = oneshot::channel();
        let mut state = self.shared.lock();
        self.check_wait(&state, &flow, order)?;
        let id = state.fair.push(&flow, order.price, order.workers, granted);
        self.shared.hand_out(&mut state);
        if state.fair.waiting() > self.queue && state.fair.push_out(&order.client).is_none() {
            drop(state.fair.remove(&flow, id));
            return Err(self.full(&state));
        }
        drop(state);
        let shared = Arc::clone(&self.shared);
        Ok(Place { shared, flow, id, granted: receive, is_taken: false })
    }

    /// Refuses a request at once that would be sent away later, having waited as long as it may.
    fn check_wait(&self, state: &State, flow: &Flow, order: &Order) -> Result<(), Problem> {
        if state.pace.works < KNOWN {
            return Ok(());
        }
        let workers = self.shared.workers.min(order.workers);
        let wait = state.pace.of(state.fair.units_before(flow, order.price), workers);
        if wait <= self.patience {
            return Ok(());
        }
        let (wait, most) = (wait.as_secs_f64(), self.patience.as_secs_f64());
        let message =
            format!("the requests before it take about {wait:.0} s, and none waits longer than {most} s");
        let retry = (wait - most).ceil() as u64;
        Err(Problem::new(Kind::Busy, message)
            .limited("queue_seconds", "start the service with --queue-seconds SECONDS")
            .retry_after(retry.clamp(1, 60)))
    }

    fn full(&self, state: &State) -> Problem {
        Problem::new(Kind::QueueFull, format!("{} requests wait already", self.queue))
            .limited("queue", "start the service with --queue N")
            .retry_after(self.seconds(state))
    }

    /// Estimate of the time until all waiting requests have been served.
    fn seconds(&self, state: &State) -> u64 {
        state.pace.of(state.fair.units(), self.shared.workers).as_secs().clamp(1, 60)
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
                Ok(is_dear) => {
                    place.is_taken = true;
                    let (shared, client) = (Arc::clone(&place.shared), place.flow.client.clone());
                    Ok(Turn { shared, client, is_dear })
                }
                Err(_) => Err(self.full(&self.shared.lock())),
            },
            _ = closed.wait_for(|closed| *closed) => Err(Problem::new(Kind::Stopping, "the service stops")),
            () = tokio::time::sleep(self.patience) => {
                let message = format!("no worker was free within {} s", self.patience.as_secs_f64());
                Err(Problem::new(Kind::Busy, message)
                    .limited("queue_seconds", "start the service with --queue-seconds SECONDS")
                    .retry_after(self.seconds(&self.shared.lock())))
            }
        }
    }

    /// Records the duration of a work of this price.
    pub fn note(&self, price: u64, time: Duration) {
        self.shared.lock().pace.note(price, time);
    }

    /// Sends away the waiting requests.
    pub fn close(&self) {
        self.closed.send_replace(true);
    }
}

#[cfg(test)]
mod tests {
    use super::super::fair::CHEAP;
    use super::*;

    fn order(name: &str) -> Order {
        Order { client: Client::Holder(name.into()), priority: Priority::Normal, price: 1, workers: 9 }
    }

    fn dear(name: &str) -> Order {
        Order { price: CHEAP + 1, ..order(name) }
    }

    #[tokio::test]
    async fn the_queue_has_an_end() {
        let gate = Gate::new(1, 0, 1, Duration::from_millis(20));
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
        let gate = Gate::new(1, 0, 2, Duration::from_secs(100));
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
    #[tokio::test]
    async fn a_spare_worker_is_for_cheap_requests_beside_dear_ones_of_others() {
        let gate = Gate::new(2, 1, 9, Duration::from_millis(20));
        let mut turns = Vec::new();
        for _ in 0..2 {
            turns.push(gate.turn(gate.enter(&order("cheap")).unwrap()).await.unwrap());
        }
        // No dear one is under way: another soon ends.
        assert_eq!(gate.turn(gate.enter(&order("other")).unwrap()).await.unwrap_err().kind, Kind::Busy);
        turns.clear();
        for _ in 0..2 {
            turns.push(gate.turn(gate.enter(&dear("greedy")).unwrap()).await.unwrap());
        }
        for refused in [dear("other"), order("greedy")] {
            assert_eq!(gate.turn(gate.enter(&refused).unwrap()).await.unwrap_err().kind, Kind::Busy);
        }
        let spare = gate.turn(gate.enter(&order("other")).unwrap()).await.unwrap();
        assert_eq!(gate.load(), (3, 0));
        assert_eq!(gate.turn(gate.enter(&order("third")).unwrap()).await.unwrap_err().kind, Kind::Busy);
        // The end of a dear one makes room for none as long as the spare worker has its own.
        let waiting = gate.enter(&dear("greedy")).unwrap();
        drop(turns.pop());
        assert_eq!(gate.load(), (2, 1));
        drop(spare);
        assert_eq!(gate.load(), (2, 0));
        drop(waiting);
        turns.clear();
        assert_eq!(gate.load(), (0, 0));
    }

    #[tokio::test]
    async fn what_would_wait_in_vain_is_refused_at_once() {
        let gate = Gate::new(2, 0, 100, Duration::from_secs(10));
        let turns = [
            gate.turn(gate.enter(&order("a")).unwrap()).await,
            gate.turn(gate.enter(&order("a")).unwrap()).await,
        ];
        // Nothing is known of the time yet: 100 units may wait.
        let mut places = vec![gate.enter(&Order { price: 100, ..order("a") }).unwrap()];
        (0..KNOWN).for_each(|_| gate.note(10, Duration::from_secs(4)));
        // .4 s a unit, two workers: 50 units in 10 s.
        let refused = gate.enter(&order("a")).unwrap_err();
        assert_eq!((refused.kind, refused.retry_after), (Kind::Busy, Some(10)), "{}", refused.message);
        // Another client's turn comes before.
        places.push(gate.enter(&Order { price: 20, ..order("b") }).unwrap());
        places.push(gate.enter(&Order { price: 8, ..order("b") }).unwrap());
        assert_eq!(gate.enter(&Order { price: 10, ..order("b") }).unwrap_err().kind, Kind::Busy);
        // With one worker it waits twice as long.
        let slow = Order { price: 16, workers: 1, ..order("c") };
        assert_eq!(gate.enter(&slow).unwrap_err().kind, Kind::Busy);
        assert!(gate.enter(&Order { workers: 2, ..slow }).is_ok());
        drop((turns, places));
        assert_eq!(gate.load(), (0, 0));
    }
}
