//! A queue that is fair by client: deficit round robin by price (Shreedhar and Varghese, "Efficient Fair Queuing Using Deficit Round-Robin",
//! 1996), in which a priority is a larger share of a round. In a full queue the client that has most in it gives way.

use serde::Deserialize;
use std::collections::{BTreeMap, VecDeque};
use std::net::IpAddr;
use std::sync::Arc;

/// Price of a cheap request at most, in units: a picture of 512 x 512 in `fast`, or of 256 x 256 in `good`.
pub const CHEAP: u64 = 32;

/// Sender of requests.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Client {
    /// Holder of a key, by name.
    Holder(Arc<str>),
    /// Address: of IPv4, or the network of 64 bits that IPv6 gives to one site.
    Address(IpAddr),
    /// Peer on a socket of this machine.
    Local,
}

impl Client {
    /// Client at an address, if it has one.
    #[must_use]
    pub fn of(address: Option<IpAddr>) -> Self {
        match address.map(|address| address.to_canonical()) {
            None => Self::Local,
            Some(IpAddr::V6(address)) => {
                let network = u128::from(address) & !u128::from(u64::MAX);
                Self::Address(IpAddr::V6(network.into()))
            }
            Some(address) => Self::Address(address),
        }
    }
}

/// Share of a client among all that wait.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Eq, PartialOrd, Ord)]
#[serde(rename_all = "lowercase")]
pub enum Priority {
    /// A quarter of the usual share.
    Low,
    /// The usual share.
    #[default]
    Normal,
    /// Four times the usual share.
    High,
}

impl Priority {
    /// Units that a round adds.
    fn quantum(self) -> u64 {
        match self {
            Self::Low => 1,
            Self::Normal => 4,
            Self::High => 16,
        }
    }
}

/// Requests that wait in the order in which they came.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Flow {
    /// Client that has sent them.
    pub client: Client,
    /// Their priority.
    pub priority: Priority,
}

/// Everything that waits, and the workers that clients have.
#[derive(Debug)]
pub struct Fair<T> {
    flows: BTreeMap<Flow, Queue<T>>,
    /// Flows that wait; the front has its turn.
    round: VecDeque<Flow>,
    working: BTreeMap<Client, Workers>,
    waiting: usize,
    last: u64,
}

/// Workers that a client has.
#[derive(Clone, Copy, Debug, Default)]
struct Workers {
    all: usize,
    /// Workers with requests that are not cheap.
    dear: usize,
}

/// A request that is given a worker.
#[derive(Debug)]
pub struct Next<T> {
    /// Client that has sent it.
    pub client: Client,
    /// True if it is not cheap.
    pub is_dear: bool,
    /// Value that was put into the queue.
    pub value: T,
}

#[derive(Debug)]
struct Queue<T> {
    items: VecDeque<Item<T>>,
    /// Units that it may spend.
    deficit: u64,
    /// True before its turn has begun: the units of this round are still to come.
    is_fresh: bool,
}

#[derive(Debug)]
struct Item<T> {
    id: u64,
    price: u64,
    /// Workers that its client may have at a time.
    workers: usize,
    value: T,
}

impl<T> Default for Fair<T> {
    fn default() -> Self {
        let (flows, working) = (BTreeMap::new(), BTreeMap::new());
        Self { flows, round: VecDeque::new(), working, waiting: 0, last: 0 }
    }
}

impl<T> Fair<T> {
    /// Number of requests that wait.
    #[must_use]
    pub fn waiting(&self) -> usize {
        self.waiting
    }

    /// Puts a request at the end of its flow. Returns its number.
    pub fn push(&mut self, flow: &Flow, price: u64, workers: usize, value: T) -> u64 {
        self.last += 1;
        let queue = self.flows.entry(flow.clone()).or_insert_with(|| {
            self.round.push_back(flow.clone());
            Queue { items: VecDeque::new(), deficit: 0, is_fresh: true }
        });
        queue.items.push_back(Item { id: self.last, price, workers: workers.max(1), value });
        self.waiting += 1;
        self.last
    }

    /// Takes the request whose turn it is, of a client that may have another worker, and gives it the worker.
    pub fn next(&mut self) -> Option<Next<T>> {
        self.skip_idle_rounds()?;
        loop {
            let flow = self.round.front()?.clone();
            let is_ready = self.is_ready(&flow);
            let queue = self.flows.get_mut(&flow)?;
            if is_ready {
                if std::mem::take(&mut queue.is_fresh) {
                    queue.deficit = queue.deficit.saturating_add(flow.priority.quantum());
                }
                if queue.items.front()?.price <= queue.deficit {
                    return self.take_first(&flow);
                }
            }
            queue.is_fresh = true;
            self.round.rotate_left(1);
        }
    }

    /// Takes the first cheap request, in the order of turns, of a client that has no dear one under way and may have another worker, if
    /// others have dear ones under way; gives it a worker.
    pub fn next_cheap(&mut self) -> Option<Next<T>> {
        if self.working.values().all(|workers| workers.dear == 0) {
            return None;
        }
        let is_cheap = |flow: &&Flow| {
            let first = self.flows.get(flow).and_then(|queue| queue.items.front());
            let has_dear = self.working.get(&flow.client).is_some_and(|workers| workers.dear > 0);
            first.is_some_and(|item| item.price <= CHEAP) && !has_dear && self.is_ready(flow)
        };
        let flow = self.round.iter().find(is_cheap)?.clone();
        self.take_first(&flow)
    }

    fn take_first(&mut self, flow: &Flow) -> Option<Next<T>> {
        let queue = self.flows.get_mut(flow)?;
        let item = queue.items.pop_front()?;
        queue.deficit = queue.deficit.saturating_sub(item.price);
        self.waiting -= 1;
        self.forget_empty(flow);
        let (client, is_dear) = (flow.client.clone(), item.price > CHEAP);
        let workers = self.working.entry(client.clone()).or_default();
        workers.all += 1;
        workers.dear += usize::from(is_dear);
        Some(Next { client, is_dear, value: item.value })
    }

    /// Adds the units of as many rounds as pass before one in which a request has its turn; `None` if none is ready at all.
    fn skip_idle_rounds(&mut self) -> Option<()> {
        let rounds = |flow: &Flow, queue: &Queue<T>| {
            let price = queue.items.front().map_or(0, |item| item.price);
            price.saturating_sub(queue.deficit).div_ceil(flow.priority.quantum())
        };
        let ready: Vec<Flow> = self.round.iter().filter(|flow| self.is_ready(flow)).cloned().collect();
        let idle = ready.iter().filter_map(|flow| Some(rounds(flow, self.flows.get(flow)?))).min()?;
        for flow in ready {
            let queue = self.flows.get_mut(&flow)?;
            let units = flow.priority.quantum().saturating_mul(idle.saturating_sub(1));
            queue.deficit = queue.deficit.saturating_add(units);
        }
        Some(())
    }

    /// Units that are served before a new request of this price in this flow: those that wait in the flow, and of every other flow as
    /// many as its share of the rounds that these and the request take.
    #[must_use]
    pub fn units_before(&self, flow: &Flow, price: u64) -> u64 {
        let units =
            |queue: &Queue<T>| queue.items.iter().fold(0_u64, |sum, item| sum.saturating_add(item.price));
        let own = self.flows.get(flow).map_or(0, units);
        let rounds = own.saturating_add(price).div_ceil(flow.priority.quantum());
        let others = self.flows.iter().filter(|(other, _)| *other != flow);
        others.fold(own, |sum, (other, queue)| {
            let share = rounds.saturating_mul(other.priority.quantum());
            sum.saturating_add(share.min(units(queue)))
        })
    }

    /// Units of all that wait.
    #[must_use]
    pub fn units(&self) -> u64 {
        let items = self.flows.values().flat_map(|queue| &queue.items);
        items.fold(0, |sum, item| sum.saturating_add(item.price))
    }

    fn is_ready(&self, flow: &Flow) -> bool {
        let working = self.working.get(&flow.client).map_or(0, |workers| workers.all);
        let first = self.flows.get(flow).and_then(|queue| queue.items.front());
        first.is_some_and(|item| working < item.workers)
    }

    /// Takes back the worker of a client's request, dear or cheap.
    pub fn release(&mut self, client: &Client, is_dear: bool) {
        if let Some(workers) = self.working.get_mut(client) {
            workers.all = workers.all.saturating_sub(1);
            workers.dear = workers.dear.saturating_sub(usize::from(is_dear));
            if workers.all == 0 {
                self.working.remove(client);
            }
        }
    }

    /// Takes a request out of the queue, if it waits.
    pub fn remove(&mut self, flow: &Flow, id: u64) -> Option<T> {
        let items = &mut self.flows.get_mut(flow)?.items;
        let at = items.iter().position(|item| item.id == id)?;
        let item = items.remove(at)?;
        self.waiting -= 1;
        self.forget_empty(flow);
        Some(item.value)
    }

    /// Takes the newest request of the client that has most in the queue, if that is more than this one has.
    pub fn push_out(&mut self, newcomer: &Client) -> Option<T> {
        let mut counts: BTreeMap<&Client, usize> = BTreeMap::new();
        for (flow, queue) in &self.flows {
            *counts.entry(&flow.client).or_default() += queue.items.len();
        }
        let own = counts.get(newcomer).copied().unwrap_or(0);
        let (client, most) = counts.into_iter().max_by_key(|(_, count)| *count)?;
        if most <= own {
            return None;
        }
        // The first of its flows has the lowest priority.
        let flow = self.flows.keys().find(|flow| flow.client == *client)?.clone();
        let item = self.flows.get_mut(&flow)?.items.pop_back()?;
        self.waiting -= 1;
        self.forget_empty(&flow);
        Some(item.value)
    }

    /// Forgets a flow in which nothing waits, with the units that it has left.
    fn forget_empty(&mut self, flow: &Flow) {
        if self.flows.get(flow).is_some_and(|queue| queue.items.is_empty()) {
            self.flows.remove(flow);
            self.round.retain(|other| other != flow);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn flow(name: &str, priority: Priority) -> Flow {
        Flow { client: Client::Holder(name.into()), priority }
    }

    fn served(fair: &mut Fair<&'static str>, count: usize) -> String {
        (0..count)
            .map(|_| {
                let next = fair.next().unwrap();
                fair.release(&next.client, next.is_dear);
                next.value
            })
            .collect()
    }

    #[test]
    fn clients_take_turns_by_price() {
        let mut fair = Fair::default();
        let (a, b) = (flow("a", Priority::Normal), flow("b", Priority::Normal));
        (0..4).for_each(|_| {
            fair.push(&a, 8, 9, "a");
        });
        (0..8).for_each(|_| {
            fair.push(&b, 2, 9, "b");
        });
        // 4 units a round: two of b each, one of a every second.
        assert_eq!(served(&mut fair, 12), "bbabbbbabbaa");
        assert!(fair.next().is_none() && fair.waiting() == 0);
        assert!(fair.flows.is_empty() && fair.round.is_empty() && fair.working.is_empty());
    }

    #[test]
    fn priorities_are_shares() {
        let mut fair = Fair::default();
        for (name, priority) in [("l", Priority::Low), ("n", Priority::Normal), ("h", Priority::High)] {
            (0..100).for_each(|_| {
                fair.push(&flow(name, priority), 1, 9, name);
            });
        }
        let order = served(&mut fair, 84);
        let count = |name: &str| order.matches(name).count();
        assert_eq!((count("l"), count("n"), count("h")), (4, 16, 64));
    }

    #[test]
    fn dear_requests_have_their_turn_at_once_where_nobody_else_waits() {
        let mut fair = Fair::default();
        fair.push(&flow("a", Priority::Low), u64::MAX, 1, "a");
        assert_eq!(served(&mut fair, 1), "a");
    }

    #[test]
    fn clients_have_so_many_workers() {
        let mut fair = Fair::default();
        let (a, b) = (flow("a", Priority::Normal), flow("b", Priority::Normal));
        (0..3).for_each(|_| {
            fair.push(&a, 1, 2, "a");
        });
        fair.push(&b, 100, 2, "b");
        let next = |fair: &mut Fair<&'static str>| fair.next().map(|next| next.value);
        assert_eq!([next(&mut fair), next(&mut fair), next(&mut fair)], [Some("a"), Some("a"), Some("b")]);
        assert_eq!(next(&mut fair), None);
        fair.release(&a.client, false);
        assert_eq!(next(&mut fair), Some("a"));
    }

    #[test]
    fn units_before_a_request_are_those_of_its_own_flow_and_shares_of_others() {
        let mut fair = Fair::default();
        let [low, normal, high] = [Priority::Low, Priority::Normal, Priority::High].map(|p| flow("a", p));
        assert_eq!((fair.units_before(&normal, 100), fair.units()), (0, 0));
        for (flow, price, count) in [(&low, 10, 2), (&normal, 8, 3), (&high, 100, 5)] {
            (0..count).for_each(|_| {
                fair.push(flow, price, 9, "");
            });
        }
        assert_eq!(fair.units(), 20 + 24 + 500);
        // Eight rounds of 4 units: 8 of the low one's 20, 128 of the high one's 500.
        assert_eq!(fair.units_before(&normal, 8), 24 + 8 + 128);
        assert_eq!(fair.units_before(&flow("b", Priority::High), 16), 1 + 4 + 16);
        assert_eq!(fair.units_before(&flow("b", Priority::Normal), u64::MAX), 544);
    }

    #[test]
    fn cheap_requests_do_not_wait_for_dear_ones_of_others() {
        let mut fair = Fair::default();
        let [a, b, c] = ["a", "b", "c"].map(|name| flow(name, Priority::Normal));
        let cheap = |fair: &mut Fair<&'static str>| fair.next_cheap().map(|next| next.value);
        fair.push(&c, 1, 2, "1");
        assert_eq!(cheap(&mut fair), None, "no dear one is under way");
        assert_eq!(fair.next().unwrap().value, "1");
        fair.push(&a, CHEAP + 1, 9, "2");
        assert!(fair.next().unwrap().is_dear);
        for (flow, price, name) in [(&a, 1, "3"), (&b, CHEAP + 1, "4"), (&c, CHEAP, "5"), (&c, 1, "6")] {
            fair.push(flow, price, 2, name);
        }
        // Not 3, whose client has a dear one under way, nor 4, which is dear; 6 is one more than its client may have.
        assert_eq!((cheap(&mut fair), cheap(&mut fair), fair.waiting()), (Some("5"), None, 3));
        fair.release(&c.client, false);
        assert_eq!((cheap(&mut fair), cheap(&mut fair), fair.waiting()), (Some("6"), None, 2));
        fair.release(&a.client, true);
        fair.push(&c, 1, 9, "7");
        assert_eq!(cheap(&mut fair), None);
    }

    #[test]
    fn a_full_queue_loses_the_newest_of_the_longest() {
        let mut fair = Fair::default();
        let (a, b) = (flow("a", Priority::Normal), flow("b", Priority::Normal));
        for name in ["1", "2", "3"] {
            fair.push(&a, 1, 9, name);
        }
        let id = fair.push(&b, 1, 9, "4");
        assert_eq!(fair.push_out(&b.client), Some("3"));
        assert_eq!(fair.push_out(&a.client), None);
        assert_eq!((fair.remove(&b, id), fair.remove(&b, id)), (Some("4"), None));
        assert_eq!((served(&mut fair, 2).as_str(), fair.waiting()), ("12", 0));
    }

    #[test]
    fn sites_of_ipv6_are_one_client() {
        let of = |text: &str| Client::of(Some(text.parse().unwrap()));
        assert_eq!(of("2001:db8:1:2::1"), of("2001:db8:1:2:ffff::9"));
        assert_ne!(of("2001:db8:1:2::1"), of("2001:db8:1:3::1"));
        assert_eq!(of("::ffff:10.0.0.1"), of("10.0.0.1"));
        assert_ne!(of("10.0.0.2"), of("10.0.0.1"));
    }

    /// Numbers from a seed (xorshift64*).
    struct Random(u64);

    impl Random {
        fn below(&mut self, end: u64) -> u64 {
            self.0 ^= self.0 >> 12;
            self.0 ^= self.0 << 25;
            self.0 ^= self.0 >> 27;
            (self.0.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 33) % end
        }
    }

    /// A load in counted units: a worker takes as many as a request costs.
    #[derive(Clone, Copy)]
    struct Load {
        workers: usize,
        /// Workers of a client at most.
        of_client: usize,
        /// Prices of the greedy client, who always has 50 requests in the queue; none if there is no such client.
        greedy: Option<(u64, u64)>,
        /// All requests are of one client, in the order of their arrival.
        is_fair: bool,
        /// Further workers for cheap requests.
        spare: usize,
    }

    impl Load {
        /// The 99th percentile of the wait of a client that asks for a page of 12 pictures of 1 to 4 units every 192 units in the mean.
        fn wait(&self) -> u64 {
            let mut random = Random(0x6f66_6665_7273);
            let cheap = flow("cheap", Priority::Normal);
            let greedy = flow(if self.is_fair { "greedy" } else { "cheap" }, Priority::Normal);
            let mut fair: Fair<(bool, u64, u64)> = Fair::default();
            let (mut busy, mut waits): (Vec<(u64, Client, bool)>, Vec<u64>) = (Vec::new(), Vec::new());
            let mut asked = 0;
            for now in 0..200_000 {
                busy.retain(|(end, client, is_dear)| {
                    if *end <= now {
                        fair.release(client, *is_dear);
                    }
                    *end > now
                });
                if let Some((least, most)) = self.greedy {
                    while asked < 50 {
                        let price = least + random.below(most - least + 1);
                        fair.push(&greedy, price, self.of_client, (false, now, price));
                        asked += 1;
                    }
                }
                if random.below(192) == 0 {
                    for _ in 0..12 {
                        let price = 1 + random.below(4);
                        fair.push(&cheap, price, self.of_client, (true, now, price));
                    }
                }
                loop {
                    let next = match self.spare {
                        _ if busy.len() < self.workers => fair.next(),
                        spare if busy.len() < self.workers + spare => fair.next_cheap(),
                        _ => None,
                    };
                    let Some(Next { client, is_dear, value: (is_cheap, since, price) }) = next else { break };
                    // The processors are as many as the workers without the spare ones.
                    let share = (busy.len() + 1).max(self.workers);
                    busy.push((now + (price * share as u64).div_ceil(self.workers as u64), client, is_dear));
                    if is_cheap {
                        waits.push(now - since);
                    } else {
                        asked -= 1;
                    }
                }
            }
            waits.sort_unstable();
            assert!(waits.len() > 10_000, "{}", waits.len());
            waits[waits.len() * 99 / 100]
        }
    }

    /// A client who is alone waits for its own requests.
    const ALONE: Load = Load { workers: 2, of_client: 2, greedy: None, is_fair: true, spare: 0 };

    #[test]
    fn a_greedy_client_makes_a_cheap_one_wait_little() {
        for (workers, of_client, greedy) in
            [(2, 2, (1, 4)), (2, 2, (4, 16)), (2, 1, (16, 64)), (4, 2, (16, 64))]
        {
            let alone = Load { workers, of_client: workers, ..ALONE }.wait();
            let beside = Load { workers, of_client, greedy: Some(greedy), ..ALONE }.wait();
            // In the order of arrival it waits for all that the other has asked for.
            let greedy = Some(greedy);
            let in_order = Load { workers, of_client: workers, greedy, is_fair: false, spare: 0 }.wait();
            assert!(alone > 0 && beside <= 3 * alone, "{workers} workers: {beside} beside {alone}");
            assert!(2 * in_order > 3 * beside, "{workers} workers: {in_order} in order, {beside} by turns");
        }
    }

    #[test]
    fn spare_workers_keep_a_cheap_client_s_time_where_dear_requests_have_all_others() {
        for workers in [1, 2, 4] {
            let load = Load { workers, of_client: workers, greedy: Some((1000, 4000)), ..ALONE };
            let alone = Load { greedy: None, ..load }.wait();
            let without = load.wait();
            let with = Load { spare: workers, ..load }.wait();
            assert!(with <= 3 * alone && 10 * with < without, "{workers}: {alone} alone, {without}, {with}");
        }
    }
}
