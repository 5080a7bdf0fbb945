//! Equal requests at the same time are one piece of work.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use tokio::sync::watch;

/// Work that is under way, by name.
#[derive(Debug)]
pub struct Flights<T> {
    under_way: Arc<Mutex<HashMap<String, watch::Receiver<Option<T>>>>>,
}

impl<T> Default for Flights<T> {
    fn default() -> Self {
        Self { under_way: Arc::default() }
    }
}

/// One's part in a piece of work.
pub enum Part<T> {
    /// To do it.
    Lead(Lead<T>, Wait<T>),
    /// To wait for it.
    Follow(Wait<T>),
}

/// The duty to do the work. If it is dropped, the others learn that there is no result.
pub struct Lead<T> {
    name: String,
    result: watch::Sender<Option<T>>,
    flights: Flights<T>,
}

/// Receiver of the result.
pub struct Wait<T>(watch::Receiver<Option<T>>);

impl<T: Clone> Flights<T> {
    fn lock(&self) -> MutexGuard<'_, HashMap<String, watch::Receiver<Option<T>>>> {
        self.under_way.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Takes part in work.
    #[must_use]
    pub fn join(&self, name: &str) -> Part<T> {
        let mut under_way = self.lock();
        if let Some(result) = under_way.get(name) {
            return Part::Follow(Wait(result.clone()));
        }
        let (send, receive) = watch::channel(None);
        // The receiver of the table is not counted among those who wait.
        under_way.insert(name.to_owned(), receive.clone());
        let flights = Self { under_way: Arc::clone(&self.under_way) };
        Part::Lead(Lead { name: name.to_owned(), result: send, flights }, Wait(receive))
    }
}

impl<T> Lead<T> {
    /// True if anybody still waits for the result. If not, nobody will: the work is no longer under way.
    #[must_use]
    pub fn is_wanted(&self) -> bool {
        let mut under_way = self.flights.under_way.lock().unwrap_or_else(PoisonError::into_inner);
        let wanted = self.result.receiver_count() > 1;
        if !wanted {
            under_way.remove(&self.name);
        }
        wanted
    }

    /// Tells the result. Later followers have it, too, until the returned value is dropped.
    #[must_use]
    pub fn tell(self, result: T) -> Self {
        self.result.send_replace(Some(result));
        self
    }
}

impl<T> Drop for Lead<T> {
    fn drop(&mut self) {
        let mut under_way = self.flights.under_way.lock().unwrap_or_else(PoisonError::into_inner);
        // Another may have begun the same anew.
        if under_way.get(&self.name).is_some_and(|known| known.same_channel(&self.result.subscribe())) {
            under_way.remove(&self.name);
        }
    }
}

impl<T: Clone> Wait<T> {
    /// Waits for the result; `None` if the work was given up.
    pub async fn result(mut self) -> Option<T> {
        let result = self.0.wait_for(Option::is_some).await.ok()?;
        result.clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test]
    async fn work_is_done_once_for_all() {
        let flights = Flights::<u32>::default();
        let Part::Lead(lead, first) = flights.join("a") else { panic!("somebody else has it") };
        let Part::Follow(second) = flights.join("a") else { panic!("done twice") };
        assert!(matches!(flights.join("b"), Part::Lead(..)));
        assert!(lead.is_wanted());
        let landed = lead.tell(7);
        let Part::Follow(third) = flights.join("a") else { panic!("done twice") };
        assert_eq!(third.result().await, Some(7));
        drop(landed);
        assert_eq!((first.result().await, second.result().await), (Some(7), Some(7)));
        assert!(matches!(flights.join("a"), Part::Lead(..)));
    }

    #[tokio::test]
    async fn work_that_nobody_wants_is_given_up() {
        let flights = Flights::<u32>::default();
        let Part::Lead(lead, wait) = flights.join("a") else { panic!("somebody else has it") };
        drop(wait);
        assert!(!lead.is_wanted());
        let Part::Lead(again, wait) = flights.join("a") else { panic!("it is still there") };
        drop(lead);
        assert!(matches!(flights.join("a"), Part::Follow(_)), "the first has taken the second's place away");
        drop(again);
        assert_eq!(wait.result().await, None);
    }
}
