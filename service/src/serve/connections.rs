//! Open connections: bounded together and by client. Those that wait give way to others, those of the client with most of them first.

use super::address::Network;
use super::fair::Client;
use super::pace::{Closed, Pace, Patience};
use std::collections::BTreeMap;
use std::net::IpAddr;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;
use tokio::sync::{OwnedSemaphorePermit, Semaphore};
use tokio::time::Instant;

/// Connections of one client that are always allowed where no number is given.
const FEWEST_OF_CLIENT: usize = 16;
/// Time after which a connection that waits is looked for again: those that had work may have none any more.
const AGAIN: Duration = Duration::from_millis(20);

/// Connections that one client may have where no number is given: a quarter of all.
#[must_use]
pub fn usual_of_client(all: usize) -> usize {
    (all / 4).max(FEWEST_OF_CLIENT)
}

/// All open connections of a port.
#[derive(Clone, Debug)]
pub struct Connections {
    room: Arc<Semaphore>,
    of_client: usize,
    /// Networks whose addresses are those of many clients.
    proxies: Arc<[Network]>,
    patience: Patience,
    table: Arc<Mutex<Table>>,
}

#[derive(Debug, Default)]
struct Table {
    open: BTreeMap<u64, (Client, Arc<Pace>)>,
    of_clients: BTreeMap<Client, usize>,
    last: u64,
}

/// Number of the connections of a client that wait, the longest wait among them, and whose it is.
type Waiting<'a> = (usize, Option<(Instant, &'a Arc<Pace>)>);

/// A place among the connections.
#[derive(Debug)]
pub struct Entry {
    /// Pace of the connection.
    pub pace: Arc<Pace>,
    client: Client,
    id: u64,
    table: Arc<Mutex<Table>>,
    _room: OwnedSemaphorePermit,
}

fn lock(table: &Mutex<Table>) -> MutexGuard<'_, Table> {
    table.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Drop for Entry {
    fn drop(&mut self) {
        let mut table = lock(&self.table);
        table.open.remove(&self.id);
        if let Some(count) = table.of_clients.get_mut(&self.client) {
            *count -= 1;
            if *count == 0 {
                table.of_clients.remove(&self.client);
            }
        }
    }
}

impl Connections {
    /// So many at a time, and so many of one client, unless it is one of these proxies.
    #[must_use]
    pub fn new(all: usize, of_client: usize, proxies: &[Network], patience: Patience) -> Self {
        Self {
            room: Arc::new(Semaphore::new(all.min(Semaphore::MAX_PERMITS))),
            of_client,
            proxies: proxies.into(),
            patience,
            table: Arc::default(),
        }
    }

    /// Connections that one client may have.
    #[must_use]
    pub fn of_client(&self) -> usize {
        self.of_client
    }

    /// True if a client has as many connections as it may have. Peers on a socket of this machine, and proxies, may have any number.
    #[must_use]
    pub fn is_too_many(&self, peer: Option<IpAddr>) -> bool {
        let Some(peer) = peer.map(|peer| peer.to_canonical()) else { return false };
        if self.proxies.iter().any(|network| network.contains(peer)) {
            return false;
        }
        lock(&self.table)
            .of_clients
            .get(&Client::of(Some(peer)))
            .is_some_and(|count| *count >= self.of_client)
    }

    /// Waits for a place, for which a connection that waits for its client gives way.
    pub async fn enter(&self, peer: Option<IpAddr>) -> Option<Entry> {
        let mut room = Arc::clone(&self.room).try_acquire_owned().ok();
        while room.is_none() {
            self.make_room();
            let next = tokio::time::timeout(AGAIN, Arc::clone(&self.room).acquire_owned()).await;
            // It is never closed.
            room = next.ok().map(Result::ok)?.or(room);
        }
        let mut table = lock(&self.table);
        table.last += 1;
        let (id, client, pace) = (table.last, Client::of(peer), Arc::new(Pace::new(self.patience)));
        table.open.insert(id, (client.clone(), Arc::clone(&pace)));
        *table.of_clients.entry(client.clone()).or_default() += 1;
        drop(table);
        Some(Entry { pace, client, id, table: Arc::clone(&self.table), _room: room? })
    }

    /// Closes the connection that has waited longest, of the client of whom most wait. Does nothing where one is being closed already, or
    /// none waits.
    pub fn make_room(&self) {
        let table = lock(&self.table);
        let mut waiting: BTreeMap<&Client, Waiting<'_>> = BTreeMap::new();
        for (client, pace) in table.open.values() {
            if pace.is_closing() {
                return;
            }
            let Some(since) = pace.waits_since() else { continue };
            let (count, oldest) = waiting.entry(client).or_default();
            *count += 1;
            if oldest.is_none_or(|(known, _)| since < known) {
                *oldest = Some((since, pace));
            }
        }
        let most = waiting
            .into_values()
            .max_by_key(|(count, oldest)| (*count, oldest.map(|(since, _)| std::cmp::Reverse(since))));
        if let Some((_, Some((_, pace)))) = most {
            pace.close(Closed::Full);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn patience() -> Patience {
        let seconds = Duration::from_secs(1000);
        Patience { head: seconds, idle: seconds, answer: seconds, rate: 1 }
    }

    fn address(text: &str) -> Option<IpAddr> {
        Some(text.parse().unwrap())
    }

    #[tokio::test]
    async fn clients_have_their_number_and_proxies_any() {
        let proxies = [Network::new("10.0.0.0/8").unwrap()];
        let all = Connections::new(100, 2, &proxies, patience());
        for (peer, is_bounded) in [
            (address("1.2.3.4"), true),
            (address("2a00::1"), true),
            (address("::ffff:10.0.0.1"), false),
            (None, false),
        ] {
            let mut held = Vec::new();
            for _ in 0..3 {
                held.push(all.enter(peer).await.unwrap());
            }
            assert_eq!(all.is_too_many(peer), is_bounded, "{peer:?}");
            drop(held);
            assert!(!all.is_too_many(peer), "{peer:?}");
        }
        // One site of IPv6 is one client.
        let _held = (all.enter(address("2a00::1")).await, all.enter(address("2a00::2")).await);
        assert!(all.is_too_many(address("2a00::3")));
        assert!(!all.is_too_many(address("2a00:0:0:1::3")));
        assert_eq!((usual_of_client(1024), usual_of_client(2)), (256, 16));
    }

    #[tokio::test]
    async fn who_has_most_that_wait_gives_way() {
        let all = Connections::new(4, 9, &[], patience());
        let good = all.enter(address("1.1.1.1")).await.unwrap();
        let mut greedy = Vec::new();
        for _ in 0..3 {
            greedy.push(all.enter(address("2.2.2.2")).await.unwrap());
        }
        // One with a request does not wait.
        let request = greedy[0].pace.request();
        let (next, closed) = tokio::join!(all.enter(address("3.3.3.3")), async {
            let reason = greedy[1].pace.overdue().await;
            drop(greedy.remove(1));
            reason
        });
        assert_eq!(closed, Closed::Full);
        assert!(
            next.is_some() && !good.pace.is_closing() && !greedy.iter().any(|entry| entry.pace.is_closing())
        );
        drop(request);
        // One is enough.
        all.make_room();
        all.make_room();
        assert_eq!(greedy.iter().filter(|entry| entry.pace.is_closing()).count(), 1);
    }
}
