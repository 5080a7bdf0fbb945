//! State that all requests share.

use super::args::ServeArgs;
use super::body::Bodies;
use super::cache::{Cache, Picture};
use super::callback::Callbacks;
use super::clock::Clock;
use super::environments::Environments;
use super::error::Problem;
use super::failures::Failures;
use super::fair::{Client, Priority};
use super::fallback::Fallback;
use super::flight::Flights;
use super::gate::{Gate, Order, Place};
use super::jobs::Jobs;
use super::metrics::Metrics;
use super::offers::Preset;
use super::path::options_of_preset;
use super::quota::Quotas;
use super::recent::Recent;
use super::rights::{self, Rights};
use super::rules::{Rules, too_dear};
use super::sign::Signer;
use super::source::Sources;
use super::trace::Trace;
use crate::common::Common;
use crate::key::Keys;
use crate::pool::{Pool, PoolOptions, TimeLimits};
use overcoat_worker::converters::Registry;
use overcoat_worker::protocol::Start;
use std::sync::atomic::{AtomicBool, AtomicU64};
use std::sync::{Arc, PoisonError, RwLock};
use std::time::{Duration, Instant};

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
    /// Converters of formats that are not read here.
    pub converters: Arc<Registry>,
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
    /// Holders of keys.
    rights: RwLock<Arc<Rights>>,
    /// Units that they have spent.
    pub quotas: Quotas,
    /// Time of day.
    clock: Clock,
    /// Picture in place of errors.
    pub fallback: Option<Fallback>,
    /// Check of the signatures of paths.
    pub signer: Signer,
    /// Sources of the models of paths.
    pub sources: Arc<Sources>,
    /// Limits of request bodies.
    pub bodies: Bodies,
    /// Requests that are done later, if any are taken.
    pub jobs: Option<Jobs>,
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
        let mut common = Common::new(&args.draw, args.converters.named()?)?;
        let Environments { files, hashes } =
            Environments::new(&args.environment).map_err(|e| format!("--environment {e}"))?;
        common.start.environments = files;
        let rules = rules(&args, &common.start)?;
        let metrics = Arc::new(Metrics::default());
        let seconds = Duration::from_secs_f64;
        let sources =
            Sources::new(args.local.as_deref(), &args.allow_source, &args.allow_network, args.max_body)?;
        let signer = Signer::new(&args.key, &args.salt, args.allow_unsigned)?;
        let jobs = jobs(&args, &signer)?;
        Ok(Self {
            jobs,
            rules,
            pool: Pool::new(pool_options(&args, &common)?),
            keys: common.keys.with_environments(hashes),
            converters: common.converters,
            gate: Gate::new(args.workers(), args.spare_workers(), args.queue, seconds(args.queue_seconds)),
            flights: Flights::default(),
            failures: Failures::new(seconds(args.failure_seconds)),
            recent: Arc::default(),
            cache: Cache::new(args.cache.as_deref(), args.cache_bytes, Arc::clone(&metrics))
                .map_err(|e| format!("--cache {e}"))?,
            metrics,
            rights: RwLock::new(Arc::new(rights_of(&args)?)),
            quotas: Quotas::default(),
            clock: Clock::default(),
            fallback: args
                .fallback
                .as_deref()
                .map(Fallback::read)
                .transpose()
                .map_err(|e| format!("--fallback {e}"))?,
            signer,
            sources: Arc::new(sources),
            bodies: Bodies::new(args.max_body, seconds(args.body_seconds), args.body_rate, args.body_memory),
            ready: AtomicBool::new(false),
            stopping: AtomicBool::new(false),
            count: AtomicU64::new(0),
            args,
        })
    }

    /// The turn of a request that costs so much.
    ///
    /// # Errors
    /// [`Kind::Price`](super::error::Kind::Price) if it is too dear for its key.
    pub fn order(&self, trace: &Trace, price: u64, priority: Option<Priority>) -> Result<Order, Problem> {
        let holder = trace.holder();
        if let Some(most) = holder.and_then(|holder| holder.max_price).filter(|most| price > *most) {
            return Err(too_dear(price, most));
        }
        Ok(Order {
            client: holder.map_or_else(
                || Client::of(trace.client()),
                |holder| Client::Holder(Arc::clone(&holder.name)),
            ),
            priority: priority.or_else(|| holder?.priority).unwrap_or_default(),
            price,
            workers: holder
                .and_then(|holder| holder.workers)
                .or(self.args.client_workers)
                .unwrap_or(usize::MAX),
        })
    }

    /// Takes a place in the queue, and the units of the request from the quota of its key.
    ///
    /// # Errors
    /// [`Problem`] of the quota or of the queue, which takes no units.
    pub fn enter(&self, trace: &Trace, order: &Order) -> Result<Place, Problem> {
        if let Some(holder) = trace.holder()
            && let Some(left) = self.quotas.take(holder, order.price, Instant::now())?
        {
            trace.units_left(left);
        }
        self.gate.enter(order).inspect_err(|_| self.give_back(trace, order.price))
    }

    /// Gives back units of pictures that are not drawn.
    pub fn give_back(&self, trace: &Trace, units: u64) {
        if units > 0
            && let Some(holder) = trace.holder()
            && let Some(left) = self.quotas.give_back(holder, units)
        {
            trace.units_left(left);
        }
    }

    /// True if requests of a kind need a key.
    #[must_use]
    pub fn needs_key(&self, is_upload: bool) -> bool {
        (is_upload || self.args.bearer_for == "all") && !self.rights().is_empty()
    }

    /// Holders of keys.
    #[must_use]
    pub fn rights(&self) -> Arc<Rights> {
        Arc::clone(&self.rights.read().unwrap_or_else(PoisonError::into_inner))
    }

    /// Reads the file of keys again. Returns the number of holders.
    ///
    /// # Errors
    /// One line; those that are known stay.
    pub fn read_rights(&self) -> Result<usize, String> {
        let rights = rights_of(&self.args)?;
        let count = rights.count();
        self.quotas.keep(|name| rights.has(name));
        *self.rights.write().unwrap_or_else(PoisonError::into_inner) = Arc::new(rights);
        Ok(count)
    }

    /// Seconds since 1970, which never go back.
    #[must_use]
    pub fn seconds(&self) -> u64 {
        let (seconds, has_jumped) = self.clock.seconds();
        if has_jumped {
            self.metrics.clock_jumped();
            tracing::warn!("the clock of the system has jumped back and is not followed");
        }
        seconds
    }
}

/// Jobs, where there is a folder for them.
fn jobs(args: &ServeArgs, signer: &Signer) -> Result<Option<Jobs>, String> {
    let patience = Duration::from_secs_f64(args.source_seconds);
    let callbacks = Callbacks::new(&args.allow_callback, &args.allow_network, patience)?;
    let Some(folder) = &args.spool else { return Ok(None) };
    if !signer.has_key() {
        return Err("--spool: results are signed, with --key and --salt".to_owned());
    }
    if args.allow_callback.is_empty() {
        return Err("--spool: no job has a callback without --allow-callback".to_owned());
    }
    let most = (args.spool_jobs, args.spool_bytes);
    Jobs::new(folder, most, callbacks).map(Some).map_err(|e| format!("--spool {e}"))
}

/// Holders of keys, of the file and of the environment.
fn rights_of(args: &ServeArgs) -> Result<Rights, String> {
    let variable = std::env::var(rights::VARIABLE).ok();
    Rights::read(args.bearer_keys.as_deref(), variable.as_deref())
}

fn rules(args: &ServeArgs, start: &Start) -> Result<Rules, String> {
    let mut rules = Rules::new(&start.description, args.draw.input.limits.limits(), &args.encoding);
    (rules.max_size, rules.max_price) = (args.max_size, args.max_price);
    rules.environments.clone_from(&start.environments);
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

fn pool_options(args: &ServeArgs, common: &Common) -> Result<PoolOptions, String> {
    let program = std::env::current_exe().map_err(|e| format!("this program's own file: {e}"))?;
    let start = Start { memory: Some(args.memory), sandbox: !args.no_sandbox, ..common.start.clone() };
    Ok(PoolOptions {
        program,
        start,
        workers: args.workers(),
        spare: args.spare_workers(),
        time: TimeLimits::new(args.deadline, args.wall_deadline),
        works_of_one: args.models_of_worker,
        most_output: LARGEST_PICTURE,
        converters: Arc::clone(&common.converters),
    })
}
