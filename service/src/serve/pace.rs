//! Pace of a connection: since when it waits for its client, and when that has been too long.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;
use tokio::sync::Notify;
use tokio::time::{Instant, sleep_until};

/// Time limits of a connection.
#[derive(Clone, Copy, Debug)]
pub struct Patience {
    /// Time for the head of a request, and for a new connection until then.
    pub head: Duration,
    /// Time between an answer and the next request.
    pub idle: Duration,
    /// Time in which nothing more of an answer is taken.
    pub answer: Duration,
    /// Bytes a second that an answer must be taken with on average, beside that time.
    pub rate: u64,
}

/// Reasons why a connection was closed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Closed {
    /// The head of a request did not come.
    Head,
    /// No next request came.
    Idle,
    /// An answer was not taken.
    Answer,
    /// Others need its place.
    Full,
    /// Its client has too many.
    Client,
}

impl Closed {
    /// Its name in logs and metrics.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Head => "head",
            Self::Idle => "idle",
            Self::Answer => "answer",
            Self::Full => "full",
            Self::Client => "client",
        }
    }
}

/// Pace of one connection.
#[derive(Debug)]
pub struct Pace {
    patience: Patience,
    now: Mutex<Now>,
    changed: Notify,
}

#[derive(Debug)]
struct Now {
    /// Something of a head has come, or it is the first.
    is_head: bool,
    /// Bytes of the head have come.
    has_begun: bool,
    since: Instant,
    /// Requests without an answer.
    requests: usize,
    answers: Vec<Answer>,
    last: u64,
    closed: Option<Closed>,
}

/// An answer that is being sent.
#[derive(Debug)]
struct Answer {
    id: u64,
    begun: Instant,
    /// Time of the last part.
    last: Instant,
    bytes: u64,
}

/// A request that has no answer yet.
#[derive(Debug)]
pub struct Request(Arc<Pace>);

/// An answer until its last byte is handed over.
#[derive(Debug)]
pub struct Sending {
    pace: Arc<Pace>,
    id: u64,
}

impl Now {
    fn is_waiting(&self) -> bool {
        self.requests == 0 && self.answers.is_empty()
    }

    fn wait(&mut self) {
        if self.is_waiting() {
            (self.is_head, self.has_begun, self.since) = (false, false, Instant::now());
        }
    }

    /// When it has been too long, and the reason.
    fn end(&self, patience: &Patience) -> Option<(Instant, Closed)> {
        if let Some(reason) = self.closed {
            return Some((self.since, reason));
        }
        let of_answers = self.answers.iter().map(|answer| {
            let earned = Duration::from_secs_f64(answer.bytes as f64 / patience.rate.max(1) as f64);
            let stands_still = answer.last + patience.answer;
            (answer.begun + patience.answer).checked_add(earned).unwrap_or(stands_still).min(stands_still)
        });
        if let Some(end) = of_answers.min() {
            return Some((end, Closed::Answer));
        }
        match self.is_head {
            _ if self.requests > 0 => None,
            true => Some((self.since + patience.head, Closed::Head)),
            false => Some((self.since + patience.idle, Closed::Idle)),
        }
    }
}

impl Pace {
    /// Pace of a new connection.
    #[must_use]
    pub fn new(patience: Patience) -> Self {
        let now = Now {
            is_head: true,
            has_begun: false,
            since: Instant::now(),
            requests: 0,
            answers: Vec::new(),
            last: 0,
            closed: None,
        };
        Self { patience, now: Mutex::new(now), changed: Notify::new() }
    }

    fn now(&self) -> MutexGuard<'_, Now> {
        self.now.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn change(&self, change: impl FnOnce(&mut Now)) {
        change(&mut self.now());
        self.changed.notify_one();
    }

    /// Bytes have come. Those that come while nothing is under way begin a head.
    pub fn read(&self) {
        let mut now = self.now();
        if now.is_waiting() && !now.has_begun {
            now.has_begun = true;
            // The time of a first head begins with its connection.
            if !now.is_head {
                (now.is_head, now.since) = (true, Instant::now());
                drop(now);
                self.changed.notify_one();
            }
        }
    }

    /// A request has come.
    #[must_use]
    pub fn request(self: &Arc<Self>) -> Request {
        self.change(|now| now.requests += 1);
        Request(Arc::clone(self))
    }

    /// True if a head has begun that is not whole.
    #[must_use]
    pub fn has_half_a_head(&self) -> bool {
        let now = self.now();
        now.is_waiting() && now.has_begun
    }

    /// Time since which it waits for its client to ask something.
    #[must_use]
    pub fn waits_since(&self) -> Option<Instant> {
        let now = self.now();
        now.is_waiting().then_some(now.since)
    }

    /// True if it was told to close.
    #[must_use]
    pub fn is_closing(&self) -> bool {
        self.now().closed.is_some()
    }

    /// Tells it to close.
    pub fn close(&self, reason: Closed) {
        self.change(|now| now.closed = Some(reason));
    }

    /// Waits until its client has been waited for too long, or until it is told to close.
    pub async fn overdue(&self) -> Closed {
        loop {
            let end = self.now().end(&self.patience);
            match end {
                Some((end, reason)) if end <= Instant::now() => return reason,
                Some((end, _)) => tokio::select! {
                    () = sleep_until(end) => {}
                    () = self.changed.notified() => {}
                },
                None => self.changed.notified().await,
            }
        }
    }
}

impl Request {
    /// Its answer is there.
    #[must_use]
    pub fn answer(self) -> Sending {
        let pace = Arc::clone(&self.0);
        let mut id = 0;
        pace.change(|now| {
            now.last += 1;
            id = now.last;
            let begun = Instant::now();
            now.answers.push(Answer { id, begun, last: begun, bytes: 0 });
        });
        drop(self);
        Sending { pace, id }
    }
}

impl Drop for Request {
    fn drop(&mut self) {
        self.0.change(|now| {
            now.requests -= 1;
            now.wait();
        });
    }
}

impl Sending {
    /// So many bytes were taken.
    pub fn took(&self, bytes: usize) {
        let mut now = self.pace.now();
        if let Some(answer) = now.answers.iter_mut().find(|answer| answer.id == self.id) {
            // Its end is later now, which is seen when the former end has come.
            (answer.bytes, answer.last) = (answer.bytes + bytes as u64, Instant::now());
        }
    }
}

impl Drop for Sending {
    fn drop(&mut self) {
        self.pace.change(|now| {
            now.answers.retain(|answer| answer.id != self.id);
            now.wait();
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LONG: Duration = Duration::from_secs(1000);
    const SHORT: Duration = Duration::from_millis(20);

    fn pace(patience: Patience) -> Arc<Pace> {
        Arc::new(Pace::new(patience))
    }

    #[tokio::test]
    async fn each_wait_has_its_limit() {
        let long = Patience { head: LONG, idle: LONG, answer: LONG, rate: 1 };
        let connection = pace(Patience { head: SHORT, ..long });
        assert_eq!(connection.overdue().await, Closed::Head);
        let connection = pace(Patience { idle: SHORT, ..long });
        drop(connection.request().answer());
        assert_eq!(connection.overdue().await, Closed::Idle);
        // The next head has the time of heads.
        let connection = pace(Patience { idle: SHORT, head: LONG, ..long });
        drop(connection.request().answer());
        connection.read();
        assert!(connection.has_half_a_head());
        assert!(tokio::time::timeout(2 * SHORT, connection.overdue()).await.is_err());
        // While a request is under way nothing is waited for but the service.
        let connection = pace(Patience { head: SHORT, idle: SHORT, answer: SHORT, rate: 1 });
        let request = connection.request();
        assert!(tokio::time::timeout(2 * SHORT, connection.overdue()).await.is_err());
        let _sending = request.answer();
        assert_eq!(connection.overdue().await, Closed::Answer);
    }

    #[tokio::test]
    async fn an_answer_earns_time_by_its_bytes_and_ends_where_it_stands_still() {
        let patience = Patience { head: LONG, idle: LONG, answer: SHORT, rate: 1 };
        let connection = pace(patience);
        let sending = connection.request().answer();
        sending.took(1 << 40);
        assert_eq!(connection.overdue().await, Closed::Answer);
        // One that crawls.
        let connection = pace(Patience { answer: SHORT, rate: u64::MAX, ..patience });
        let sending = connection.request().answer();
        let crawl = async {
            loop {
                tokio::time::sleep(SHORT / 10).await;
                sending.took(1);
            }
        };
        let reason = tokio::select! { reason = connection.overdue() => reason, () = crawl => Closed::Idle };
        assert_eq!(reason, Closed::Answer);
    }
}
