//! Metrics in the text format of Prometheus.

use super::process::Process;
use crate::pool::Counters;
use prometheus_client::encoding::text::encode;
use prometheus_client::encoding::{EncodeLabelSet, LabelSetEncoder};
use prometheus_client::metrics::counter::Counter;
use prometheus_client::metrics::family::Family;
use prometheus_client::metrics::gauge::Gauge;
use prometheus_client::metrics::histogram::{Histogram, exponential_buckets};
use prometheus_client::registry::Registry;
use std::fmt;
use std::sync::Mutex;
use std::sync::PoisonError;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
use std::time::Duration;

/// Labels that are known when they are written: names and their values.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
struct Labels(Vec<(&'static str, String)>);

impl EncodeLabelSet for Labels {
    fn encode(&self, encoder: &mut LabelSetEncoder<'_>) -> fmt::Result {
        self.0.iter().map(|(name, value)| (*name, value.as_str())).collect::<Vec<_>>().encode(encoder)
    }
}

fn one(name: &'static str, value: &str) -> Labels {
    Labels(vec![(name, value.to_owned())])
}

/// A histogram of seconds, from a millisecond to a minute.
fn seconds() -> Histogram {
    Histogram::new(exponential_buckets(0.001, 2.0, 17))
}

type Histograms = Family<Labels, Histogram, fn() -> Histogram>;

/// Counters, gauges and histograms that are updated at the events.
#[derive(Debug)]
pub struct Metrics {
    registry: Mutex<Registry>,
    requests: Family<Labels, Counter>,
    refusals: Family<Labels, Counter>,
    durations: Histograms,
    stages: Histograms,
    cache: Family<Labels, Counter>,
    cache_bytes: Gauge,
    cache_entries: Gauge,
    connections: Gauge,
    closed: Family<Labels, Counter>,
    working: Gauge,
    waiting: Gauge,
    started: Counter,
    died: Counter,
    timed_out: Counter,
    remembered: Counter,
    worked: Counter<f64, AtomicU64>,
    units: Counter,
    bundled: Counter,
    jobs: Family<Labels, Counter>,
    spooled: Gauge,
    clock_jumps: Counter,
    keys_failures: Counter,
}

impl Default for Metrics {
    fn default() -> Self {
        let mut metrics = Self {
            registry: Mutex::default(),
            requests: Family::default(),
            refusals: Family::default(),
            durations: Family::new_with_constructor(seconds),
            stages: Family::new_with_constructor(seconds),
            cache: Family::default(),
            cache_bytes: Gauge::default(),
            cache_entries: Gauge::default(),
            connections: Gauge::default(),
            closed: Family::default(),
            working: Gauge::default(),
            waiting: Gauge::default(),
            started: Counter::default(),
            died: Counter::default(),
            timed_out: Counter::default(),
            remembered: Counter::default(),
            worked: Counter::default(),
            units: Counter::default(),
            bundled: Counter::default(),
            jobs: Family::default(),
            spooled: Gauge::default(),
            clock_jumps: Counter::default(),
            keys_failures: Counter::default(),
        };
        metrics.register();
        // There before the first request, so that who scales by the queue has a number for a service that nobody asks.
        drop(metrics.stages.get_or_create(&one("stage", "queue")));
        metrics
    }
}

impl Metrics {
    fn register(&mut self) {
        let all = self.registry.get_mut().unwrap_or_else(PoisonError::into_inner);
        all.register_collector(Box::new(Process));
        let registry = all.sub_registry_with_prefix("overcoat");
        registry.register("requests", "Requests by route and status", self.requests.clone());
        registry.register(
            "refusals",
            "Answers that are no pictures, by the kind of their error",
            self.refusals.clone(),
        );
        registry.register(
            "request_seconds",
            "Time from the head of a request to the head of its answer",
            self.durations.clone(),
        );
        registry.register(
            "render_seconds",
            "Time of workers by stage; queue is the wait for one",
            self.stages.clone(),
        );
        registry.register(
            "cache",
            "What happened to the cache: hit, miss, write, damaged, errors",
            self.cache.clone(),
        );
        registry.register("cache_bytes", "Bytes of the cache in a folder", self.cache_bytes.clone());
        registry.register("cache_entries", "Entries of the cache in a folder", self.cache_entries.clone());
        registry.register("connections", "Open connections", self.connections.clone());
        registry.register(
            "connections_closed",
            "Connections that were closed: head, idle and answer took too long, full and client are of bounds",
            self.closed.clone(),
        );
        registry.register("workers_busy", "Requests that have a worker", self.working.clone());
        registry.register("queue_length", "Requests that wait for a worker", self.waiting.clone());
        registry.register("workers_started", "Workers that were started", self.started.clone());
        registry.register(
            "workers_died",
            "Workers that ended by themselves or by the system",
            self.died.clone(),
        );
        registry.register(
            "workers_timed_out",
            "Workers that were ended because they took too long",
            self.timed_out.clone(),
        );
        registry.register("units", "Price of the work that workers were given", self.units.clone());
        registry.register(
            "bundled_pictures",
            "Pictures that went into answers with several of them",
            self.bundled.clone(),
        );
        registry.register(
            "jobs",
            "What happened to jobs: accepted, drawn, delivered, retried, given_up",
            self.jobs.clone(),
        );
        registry.register("jobs_spooled", "Jobs that are in the spool", self.spooled.clone());
        registry.register(
            "clock_jumps",
            "Times that the clock of the system was found to have jumped back",
            self.clock_jumps.clone(),
        );
        registry.register(
            "keys_failures",
            "Times that the file of keys could not be read again",
            self.keys_failures.clone(),
        );
        registry.register("worker_cpu_seconds", "Processor time of workers", self.worked.clone());
        registry.register(
            "failures_remembered",
            "Requests that a failure of a short while ago has answered",
            self.remembered.clone(),
        );
    }

    /// Workers have spent processor time.
    pub fn worked(&self, time: Option<Duration>) {
        self.worked.inc_by(time.unwrap_or_default().as_secs_f64());
    }

    /// The clock of the system has jumped back.
    pub fn clock_jumped(&self) {
        self.clock_jumps.inc();
    }

    /// The file of keys cannot be read again.
    pub fn keys_failed(&self) {
        self.keys_failures.inc();
    }

    /// Work of so many units has a worker.
    pub fn units(&self, price: u64) {
        self.units.inc_by(price);
    }

    /// Something happened to a job.
    pub fn job(&self, what: &'static str) {
        self.jobs.get_or_create(&one("event", what)).inc();
    }

    /// So many jobs are in the spool.
    pub fn spooled(&self, jobs: usize) {
        self.spooled.set(jobs as i64);
    }

    /// A picture went into an answer with several of them.
    pub fn bundled(&self) {
        self.bundled.inc();
    }

    /// A failure of a short while ago has answered a request.
    pub fn remembered(&self) {
        self.remembered.inc();
    }

    /// A request has its answer.
    pub fn request(&self, route: &'static str, status: u16, time: Duration) {
        let labels = Labels(vec![("route", route.to_owned()), ("status", status.to_string())]);
        self.requests.get_or_create(&labels).inc();
        self.durations.get_or_create(&one("route", route)).observe(time.as_secs_f64());
    }

    /// A request has no picture.
    pub fn refusal(&self, kind: &'static str) {
        self.refusals.get_or_create(&one("kind", kind)).inc();
    }

    /// A stage took so many milliseconds.
    pub fn stage(&self, stage: &str, milliseconds: f64) {
        self.stages.get_or_create(&one("stage", stage)).observe(milliseconds / 1000.0);
    }

    /// Something happened to the cache.
    pub fn cache(&self, what: &'static str) {
        self.cache.get_or_create(&one("event", what)).inc();
    }

    /// A connection is there, or gone.
    pub fn connection(&self, there: bool) {
        if there {
            self.connections.inc()
        } else {
            self.connections.dec()
        };
    }

    /// A connection was closed for a reason.
    pub fn closed(&self, reason: &'static str) {
        self.closed.get_or_create(&one("reason", reason)).inc();
    }

    /// All metrics as text, with the counts of pool, gate and cache.
    #[must_use]
    pub fn text(
        &self,
        counters: &Counters,
        (working, waiting): (usize, usize),
        cache: Option<(u64, usize)>,
    ) -> String {
        self.working.set(working as i64);
        self.waiting.set(waiting as i64);
        if let Some((bytes, entries)) = cache {
            self.cache_bytes.set(bytes as i64);
            self.cache_entries.set(entries as i64);
        }
        let mut text = String::new();
        // One at a time, so that a counter is not raised twice for the same.
        let registry = self.registry.lock().unwrap_or_else(PoisonError::into_inner);
        for (own, count) in [
            (&self.started, &counters.started),
            (&self.died, &counters.died),
            (&self.timed_out, &counters.timed_out),
        ] {
            own.inc_by(count.load(Relaxed).saturating_sub(own.get()));
        }
        // Writing to a string cannot fail.
        let _ = encode(&mut text, &registry);
        text
    }
}
