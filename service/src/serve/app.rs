//! State that all requests share.

use super::args::ServeArgs;
use super::body::Bodies;
use super::cache::{Cache, Picture};
use super::error::Problem;
use super::failures::Failures;
use super::fair::{Client, Priority};
use super::flight::Flights;
use super::gate::{Gate, Order};
use super::metrics::Metrics;
use super::offers::Preset;
use super::options::Rules;
use super::path::options_of_preset;
use super::recent::Recent;
use super::sign::Signer;
use super::source::Sources;
use super::trace::Trace;
use crate::common::Common;
use crate::key::Keys;
use crate::pool::{Pool, PoolOptions, TimeLimits};
use overcoat_cli::worker::protocol::Start;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64};
use std::time::Duration;

/// Bytes of a picture that a worker may hand over.
const LARGEST_PICTURE: u64 = 1 << 30;

/// Result for a picture that several requests may wait for.
pub type Outcome = Result<(Arc<Picture>, &'static str), Problem>;

/// The service.
#[derive(Debug)]
pub struct App {
    /// Its options.
    pub args: ServeArgs,
    /// Options that requests may use, and their limits.
    pub rules: Rules,
    /// Workers that draw.
    pub pool: Pool,
    /// Content keys of pictures.
    pub keys: Keys,
    /// Queue of requests before the workers.
    pub gate: Gate,
    /// Pictures that are being drawn.
    pub flights: Flights<Outcome>,
    /// Work and sources that failed a short while ago.
    pub failures: Failures,
    /// Requests of a short while ago.
    pub recent: Arc<Recent>,
    /// Pictures that were drawn.
    pub cache: Cache,
    /// Counters and histograms.
    pub metrics: Arc<Metrics>,
    /// Check of the signatures of paths.
    pub signer: Signer,
    /// Sources of the models of paths.
    pub sources: Arc<Sources>,
    /// Limits of request bodies.
    pub bodies: Bodies,
    /// Workers have shown that they can draw.
    pub ready: AtomicBool,
    /// No more requests are taken.
    pub stopping: AtomicBool,
    /// Requests so far.
    pub count: AtomicU64,
}

impl App {
    /// The service by its options.
    ///
    /// # Errors
    /// One line.
    pub fn new(args: ServeArgs) -> Result<Self, String> {
        let mut args = args;
        // The first thread of a worker is its only one, unless more are asked for.
        args.draw.machine.workers.threads = args.draw.machine.workers.threads.max(1);
        let common = Common::new(&args.draw)?;
        let rules = rules(&args, &common.start)?;
        let metrics = Arc::new(Metrics::default());
        let seconds = Duration::from_secs_f64;
        let sources =
            Sources::new(args.local.as_deref(), &args.allow_source, &args.allow_network, args.max_body)?;
        Ok(Self {
            rules,
            pool: Pool::new(pool_options(&args, &common.start)?),
            keys: common.keys,
            gate: Gate::new(args.workers(), args.queue, seconds(args.queue_seconds)),
            flights: Flights::default(),
            failures: Failures::new(seconds(args.failure_seconds)),
            recent: Arc::default(),
            cache: Cache::new(args.cache.as_deref(), args.cache_bytes, Arc::clone(&metrics))
                .map_err(|e| format!("--cache {e}"))?,
            metrics,
            signer: Signer::new(&args.key, &args.salt, args.allow_unsigned)?,
            sources: Arc::new(sources),
            bodies: Bodies::new(args.max_body, seconds(args.body_seconds), args.body_rate, args.body_memory),
            ready: AtomicBool::new(false),
            stopping: AtomicBool::new(false),
            count: AtomicU64::new(0),
            args,
        })
    }

    /// The turn of a request that costs so much.
    #[must_use]
    pub fn order(&self, trace: &Trace, price: u64, priority: Option<Priority>) -> Order {
        Order {
            client: Client::of(trace.client()),
            priority: priority.unwrap_or_default(),
            price,
            workers: self.args.client_workers.unwrap_or(usize::MAX),
        }
    }
}

fn rules(args: &ServeArgs, start: &Start) -> Result<Rules, String> {
    let mut rules = Rules::new(&start.description, args.draw.input.limits.limits(), &args.encoding);
    (rules.max_size, rules.max_price) = (args.max_size, args.max_price);
    if let Some(path) = &args.presets {
        rules.add_file(path).map_err(|e| format!("--presets {e}"))?;
    }
    for text in &args.preset {
        let about = |reason: String| format!("--preset {text}: {reason}");
        let (name, options) =
            text.split_once('=').ok_or_else(|| about("expected NAME=OPTIONS".to_owned()))?;
        let pairs = options_of_preset(options).map_err(about)?;
        rules.add_preset(name.trim(), Preset { pairs, priority: None }).map_err(about)?;
    }
    Ok(rules)
}

fn pool_options(args: &ServeArgs, start: &Start) -> Result<PoolOptions, String> {
    let program = std::env::current_exe().map_err(|e| format!("this program's own file: {e}"))?;
    let start = Start { memory: Some(args.memory), sandbox: !args.no_sandbox, ..start.clone() };
    Ok(PoolOptions {
        program,
        start,
        workers: args.workers(),
        time: TimeLimits::new(args.deadline, args.wall_deadline),
        works_of_one: args.models_of_worker,
        most_output: LARGEST_PICTURE,
    })
}
