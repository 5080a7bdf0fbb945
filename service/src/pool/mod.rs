//! Workers: processes that draw, a fixed number of them, each replaced when it has served, died, hung or grown too large.

mod budget;
mod conversions;
mod meter;
mod process;

pub use budget::{TimeLimit, TimeLimits};
pub use meter::Meter;
pub use process::Death;

use crate::files::{Files, Needed};
use budget::TimeBudget;
use conversions::{Conversions, Made};
use overcoat_worker::converters::Registry;
use overcoat_worker::protocol::{FailureReport, FromWorker, Start, ToWorker, Told, Work};
use process::Process;
use std::path::PathBuf;
use std::sync::PoisonError;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
use std::sync::{Arc, Mutex};
use tokio::sync::{Semaphore, SemaphorePermit};

/// Start and limits of workers.
#[derive(Clone, Debug)]
pub struct PoolOptions {
    /// The program that is a worker when its first argument is `worker`.
    pub program: PathBuf,
    /// First message to every worker.
    pub start: Start,
    /// Number of workers, at least 1.
    pub workers: usize,
    /// Number of further workers, which end with their work.
    pub spare: usize,
    /// Time limits of the work on one model.
    pub time: TimeLimits,
    /// Models that a worker draws before it is replaced by a new one, at least 1.
    pub works_of_one: u32,
    /// Bytes of a file that a worker may hand over.
    pub most_output: u64,
    /// Converters of formats that workers do not read.
    pub converters: Arc<Registry>,
}

impl PoolOptions {
    /// Processes that draw at a time, at most.
    fn processes(&self) -> usize {
        self.workers.max(1) + self.spare
    }
}

/// Reason why work was not done.
#[derive(Clone, Debug, thiserror::Error)]
pub enum WorkError {
    /// The worker says so: the model is wrong, or beyond a limit.
    #[error("{}", .0.message)]
    Failed(FailureReport),
    /// It took longer than is allowed, and was killed.
    #[error("took longer than {0} and was stopped")]
    TimedOut(TimeLimit),
    /// The worker ended.
    #[error("{0}")]
    Died(Death),
    /// No worker can be started.
    #[error("no worker can be started: {0}")]
    NoWorker(String),
}

/// A file of a picture.
#[derive(Clone, Debug)]
pub struct PictureFile {
    /// The plane that it holds; none of the picture itself.
    pub plane: Option<String>,
    /// Media type.
    pub media_type: String,
    /// Content.
    pub bytes: Vec<u8>,
}

/// A picture: its files and their metadata.
#[derive(Clone, Debug)]
pub struct DrawnPicture {
    /// Its own file is the last.
    pub files: Vec<PictureFile>,
    /// Metadata of the picture.
    pub told: Told,
}

/// Pictures by their numbers, each drawn or refused.
pub type Pictures = Vec<(usize, Result<DrawnPicture, FailureReport>)>;

/// Counts of events in the life of workers.
#[derive(Debug, Default)]
pub struct Counters {
    /// Processes that were started.
    pub started: AtomicU64,
    /// Processes that ended by themselves or by a limit of the system.
    pub died: AtomicU64,
    /// Processes that were killed because they took too long.
    pub timed_out: AtomicU64,
}

/// The workers.
#[derive(Debug)]
pub struct Pool {
    options: PoolOptions,
    permits: Semaphore,
    conversions: Conversions,
    idle: Mutex<Vec<Process>>,
    /// Counts so far.
    pub counters: Counters,
}

impl Pool {
    /// Workers are started when there is work for them.
    #[must_use]
    pub fn new(options: PoolOptions) -> Self {
        let permits = Semaphore::new(options.processes());
        let conversions = Conversions::new(&options);
        Self { options, permits, conversions, idle: Mutex::default(), counters: Counters::default() }
    }

    /// Start and limits of its workers.
    #[must_use]
    pub fn options(&self) -> &PoolOptions {
        &self.options
    }

    /// Number of workers that have work now.
    #[must_use]
    pub fn busy(&self) -> usize {
        self.options.processes().saturating_sub(self.permits.available_permits())
    }

    /// Waits for a worker and lets it load a model, whose files come from `files`; `meter` learns the time that it takes.
    ///
    /// # Errors
    /// [`WorkError`].
    pub async fn load<'a>(
        &'a self,
        work: &Work,
        model: &[u8],
        files: &'a dyn Files,
        meter: &'a Meter,
    ) -> Result<Loaded<'a>, WorkError> {
        self.load_within(self.options.time, work, model, files, meter).await
    }

    /// [`Self::load`] with time limits of its own.
    ///
    /// # Errors
    /// [`WorkError`].
    pub async fn load_within<'a>(
        &'a self,
        time: TimeLimits,
        work: &Work,
        model: &[u8],
        files: &'a dyn Files,
        meter: &'a Meter,
    ) -> Result<Loaded<'a>, WorkError> {
        let made = self.converted(&work.name, model).await?;
        let mut loaded = self.begin(time, files, meter).await?;
        let mut work = Work { waits: true, ..work.clone() };
        let model = made.as_ref().map_or(model, |made| &made.glb);
        if let Some(made) = &made {
            (work.converter, work.warnings) = (Some(made.converter.clone()), made.warnings.clone());
        }
        loaded.send(&ToWorker::Work(work), model).await?;
        match loaded.next().await? {
            (FromWorker::Loaded, _) => Ok(loaded),
            (FromWorker::Failed { failure }, _) => {
                loaded.reuse();
                Err(WorkError::Failed(failure))
            }
            // The request is wrong in all pictures, whatever the model is.
            (FromWorker::PictureFailed { failure, .. }, _) => {
                loaded.settle().await;
                Err(WorkError::Failed(failure))
            }
            _ => Err(loaded.give_up("says what was not asked for").await),
        }
    }

    /// Waits for a worker and lets it describe a model: the JSON of `overcoat info --json`.
    ///
    /// # Errors
    /// [`WorkError`].
    pub async fn inspect(
        &self,
        name: &str,
        model: &[u8],
        files: &dyn Files,
        meter: &Meter,
    ) -> Result<Vec<u8>, WorkError> {
        let made = self.converted(name, model).await?;
        let mut inspected = self.begin(self.options.time, files, meter).await?;
        let name = name.to_owned();
        let (converter, warnings, glb) = match &made {
            Some(made) => (Some(made.converter.clone()), made.warnings.clone(), &made.glb[..]),
            None => (None, Vec::new(), model),
        };
        inspected.send(&ToWorker::Inspect { name, converter, warnings }, glb).await?;
        let mut contents = None;
        loop {
            match (inspected.next().await?, &contents) {
                ((FromWorker::Contents, bytes), None) => contents = Some(bytes),
                ((FromWorker::Done, _), Some(_)) => {
                    inspected.reuse();
                    return Ok(contents.unwrap_or_default());
                }
                ((FromWorker::Failed { failure }, _), _) => {
                    inspected.reuse();
                    return Err(WorkError::Failed(failure));
                }
                _ => return Err(inspected.give_up("says what was not asked for").await),
            }
        }
    }

    /// GLB of a model that needs a converter, which has one look at its name and its first bytes.
    async fn converted(&self, name: &str, model: &[u8]) -> Result<Option<Made>, WorkError> {
        self.conversions.of(name, model).await.map_err(|failure| WorkError::Failed((&failure).into()))
    }

    /// Waits for a worker.
    async fn begin<'a>(
        &'a self,
        time: TimeLimits,
        files: &'a dyn Files,
        meter: &'a Meter,
    ) -> Result<Loaded<'a>, WorkError> {
        // It is never closed.
        let permit = self.permits.acquire().await.map_err(|e| WorkError::NoWorker(e.to_string()))?;
        let budget = TimeBudget::new(time);
        let process = self.process(&budget).await?;
        let budget = budget.of_process(process.id());
        meter.begin(process.id());
        let process = Some(process);
        Ok(Loaded { pool: self, process, files, needed: Vec::new(), budget, meter, _permit: permit })
    }

    /// An idle worker, or a new one.
    async fn process(&self, budget: &TimeBudget) -> Result<Process, WorkError> {
        while let Some(mut process) = self.pop_idle() {
            if process.is_alive() {
                return Ok(process);
            }
        }
        self.counters.started.fetch_add(1, Relaxed);
        match budget.wait(Process::start(&self.options)).await {
            Ok(Ok(process)) => Ok(process),
            Ok(Err(reason)) => Err(WorkError::NoWorker(reason)),
            Err(limit) => Err(WorkError::TimedOut(limit)),
        }
    }

    fn pop_idle(&self) -> Option<Process> {
        self.idle.lock().unwrap_or_else(PoisonError::into_inner).pop()
    }

    /// Ends all workers that have no work, and waits until they have ended.
    pub async fn finish(&self) {
        while let Some(process) = self.pop_idle() {
            process.kill().await;
        }
    }

    /// Ends all workers that have no work.
    pub fn end_idle(&self) {
        self.idle.lock().unwrap_or_else(PoisonError::into_inner).clear();
    }
}

/// A worker that has loaded a model. If it is dropped before its end, the worker is killed.
pub struct Loaded<'a> {
    pool: &'a Pool,
    process: Option<Process>,
    files: &'a dyn Files,
    /// The files that the model refers to, in the order in which they were asked for.
    pub needed: Vec<Needed>,
    budget: TimeBudget,
    meter: &'a Meter,
    _permit: SemaphorePermit<'a>,
}

impl Loaded<'_> {
    /// Lets the worker draw the pictures of these numbers, none of which may be drawn twice.
    ///
    /// # Errors
    /// [`WorkError`]; nothing is known of any picture then.
    pub async fn draw(mut self, pictures: &[usize]) -> Result<(Pictures, Vec<Needed>), WorkError> {
        self.send(&ToWorker::Draw { pictures: pictures.to_vec() }, &[]).await?;
        let mut drawn = Pictures::new();
        let mut files = Vec::new();
        loop {
            match self.next().await? {
                (FromWorker::File { plane, media_type, .. }, bytes) => {
                    files.push(PictureFile { plane, media_type, bytes });
                }
                (FromWorker::Picture { picture, told }, _) => {
                    let files = std::mem::take(&mut files);
                    self.meter.picture();
                    drawn.push((picture, Ok(DrawnPicture { files, told: *told })));
                }
                (FromWorker::PictureFailed { picture, failure }, _) => {
                    files.clear();
                    self.meter.picture();
                    drawn.push((picture, Err(failure)));
                }
                (FromWorker::Done, _) => break,
                (FromWorker::Failed { failure }, _) => {
                    self.reuse();
                    return Err(WorkError::Failed(failure));
                }
                _ => return Err(self.give_up("says what was not asked for").await),
            }
        }
        let complete = drawn.len() == pictures.len() && drawn.iter().all(|(k, _)| pictures.contains(k));
        if !complete {
            return Err(self.give_up("has not drawn what was asked for").await);
        }
        let needed = std::mem::take(&mut self.needed);
        self.reuse();
        Ok((drawn, needed))
    }

    /// The next message that is not a question for a file: those are answered.
    async fn next(&mut self) -> Result<(FromWorker, Vec<u8>), WorkError> {
        loop {
            let Some(process) = &mut self.process else { return Err(gone()) };
            let most = self.pool.options.most_output;
            let (message, bytes) = match self.budget.wait(process.receive(most)).await {
                Ok(Ok(message)) => message,
                Ok(Err(_)) => return Err(self.ended().await),
                Err(limit) => return Err(self.timed_out(limit).await),
            };
            let FromWorker::Need { name, limit, alike } = message else { return Ok((message, bytes)) };
            let found = match self.budget.wait(self.files.read(&name, limit, alike)).await {
                Ok(found) => found,
                Err(limit) => return Err(self.timed_out(limit).await),
            };
            let answer = match found {
                Ok(file) => {
                    self.needed.push(Needed::found(&name, alike, &file.bytes));
                    (ToWorker::File { found: file.name }, file.bytes)
                }
                Err(missing) => {
                    self.needed.push(Needed::missing(&name, alike));
                    (ToWorker::Missing(missing), Default::default())
                }
            };
            self.send(&answer.0, &answer.1).await?;
        }
    }

    async fn send(&mut self, message: &ToWorker, following: &[u8]) -> Result<(), WorkError> {
        let Some(process) = &mut self.process else { return Err(gone()) };
        match self.budget.wait(process.send(message, following)).await {
            Ok(Ok(())) => Ok(()),
            Ok(Err(_)) => Err(self.ended().await),
            Err(limit) => Err(self.timed_out(limit).await),
        }
    }

    /// Waits for the end of work that has failed already, so that the worker can be used again.
    async fn settle(&mut self) {
        while let Ok((message, _)) = self.next().await {
            if matches!(message, FromWorker::Done | FromWorker::Failed { .. }) {
                return self.reuse();
            }
        }
    }

    /// Takes the worker from this work, which has ended.
    fn take(&mut self) -> Option<Process> {
        let process = self.process.take();
        // One that has ended by itself tells it as long as nobody has waited for its end.
        self.meter.add(process.as_ref().and_then(|_| self.budget.spent()));
        process
    }

    /// Puts the worker back, if it may serve once more.
    fn reuse(&mut self) {
        let Some(mut process) = self.take() else { return };
        process.works += 1;
        let mut idle = self.pool.idle.lock().unwrap_or_else(PoisonError::into_inner);
        let options = &self.pool.options;
        if process.works < options.works_of_one && idle.len() < options.workers.max(1) {
            idle.push(process);
        }
    }

    async fn timed_out(&mut self, limit: TimeLimit) -> WorkError {
        self.pool.counters.timed_out.fetch_add(1, Relaxed);
        if let Some(process) = self.take() {
            process.kill().await;
        }
        WorkError::TimedOut(limit)
    }

    async fn ended(&mut self) -> WorkError {
        self.pool.counters.died.fetch_add(1, Relaxed);
        match self.take() {
            Some(process) => WorkError::Died(process.end().await),
            None => gone(),
        }
    }

    /// A worker that does not keep to the protocol is none any more.
    async fn give_up(&mut self, what: &str) -> WorkError {
        self.pool.counters.died.fetch_add(1, Relaxed);
        if let Some(process) = self.take() {
            process.kill().await;
        }
        WorkError::Died(Death::new(format!("the worker {what}")))
    }
}

fn gone() -> WorkError {
    WorkError::Died(Death::new("the worker is gone".to_owned()))
}
