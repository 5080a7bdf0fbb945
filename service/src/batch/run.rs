//! The work of a batch: model after model, each picture once.

use super::items::{Item, Wanted};
use super::report::{ErrorKind, Previous, Record, RecordError, Report, Status, WrittenFile};
use super::since::has_changed;
use super::watch::Watch;
use crate::files::{Files, Needed};
use crate::key::{Keys, hash_of};
use crate::place::{Place, PlaceFiles};
use crate::pool::{DrawnPicture, Meter, PictureFile, Pool};
use bytes::Bytes;
use overcoat_worker::protocol::{Missing, Work};
use serde_json::Value;
use std::collections::{HashMap, HashSet};
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::SystemTime;
use tokio::sync::watch;

/// State that all models of a batch share.
pub struct Batch {
    /// Workers that draw.
    pub pool: Pool,
    /// Workers that draw verified pictures again, a new process each time.
    pub other: Pool,
    /// Content keys of pictures.
    pub keys: Keys,
    /// Output place of the pictures.
    pub to: Place,
    /// Report of this run.
    pub report: Report,
    /// Records of an earlier run.
    pub previous: Previous,
    /// Bytes of a model or a file of one, at most.
    pub largest_input: u64,
    /// Share of the pictures that is drawn again for verification, 0 to 1.
    pub verify: f64,
    /// Models that have not changed since then are not drawn.
    pub since: Option<SystemTime>,
    /// State for those who watch.
    pub watch: Arc<Watch>,
    /// State of this run.
    pub ledger: Ledger,
}

/// State of a run: content keys, references of models and names that are in use.
#[derive(Debug, Default)]
pub struct Ledger {
    /// Pictures by their content keys: those that are being drawn, and those that are there.
    made: Mutex<HashMap<String, watch::Receiver<Option<Outcome>>>>,
    /// The files that models refer to, by the hash of the model and the place where the first of them is looked for.
    refers: Mutex<HashMap<String, Vec<(String, bool)>>>,
    /// Names of pictures, so that none is written twice.
    names: Mutex<HashSet<[u8; 16]>>,
    /// Counts.
    pub tally: Arc<Tally>,
}

/// Counts of pictures by outcome.
#[derive(Debug, Default)]
pub struct Tally {
    /// Rendered.
    pub drawn: AtomicU64,
    /// Copied.
    pub copied: AtomicU64,
    /// There already.
    pub kept: AtomicU64,
    /// Left out, since their models have not changed.
    pub unchanged: AtomicU64,
    /// Not made.
    pub failed: AtomicU64,
    /// Failures that are no fault of the model's.
    pub of_surroundings: AtomicU64,
    /// Drawn twice.
    pub verified: AtomicU64,
    /// Drawn twice, and not the same.
    pub differ: AtomicU64,
    /// With a warning.
    pub warned: AtomicU64,
}

/// Result for a content key.
type Outcome = Result<Record, RecordError>;

/// Decision about a picture.
enum Plan {
    /// It is there.
    Keep(Box<Record>),
    /// This run makes it elsewhere.
    Copy(watch::Receiver<Option<Outcome>>),
    /// It is drawn here.
    Draw(watch::Sender<Option<Outcome>>),
}

impl Batch {
    /// Does all pictures of a model, and reports each.
    ///
    /// # Errors
    /// One line, if the report cannot be written: the batch ends then.
    pub async fn item(&self, item: &Item) -> Result<(), String> {
        if let Some(since) = self.since {
            let modified = match item.modified {
                None => item.place.modified(&item.name).await,
                known => known,
            };
            if !has_changed(modified, since) {
                self.ledger.tally.unchanged.fetch_add(item.pictures.len() as u64, Relaxed);
                return Ok(());
            }
        }
        let (pictures, doubled): (Vec<&Wanted>, Vec<&Wanted>) =
            item.pictures.iter().partition(|wanted| self.ledger.takes_name(&wanted.out));
        for wanted in doubled {
            let message = "another picture of this batch has this name".to_owned();
            self.fail(item, wanted, RecordError { kind: ErrorKind::Usage, message, limit: None })?;
        }
        let model = match item.place.read(&item.name, self.largest_input).await {
            Ok(model) => model,
            Err(missing) => {
                let error = read_error(&missing, self.largest_input);
                return pictures.iter().try_for_each(|wanted| self.fail(item, wanted, error.clone()));
            }
        };
        let job =
            Job { item, hash: hash_of(&model), model, files: PlaceFiles::of_model(&item.place, &item.name) };
        let rest = self.known(&job, pictures).await?;
        if rest.is_empty() { Ok(()) } else { self.drawn(&job, rest).await }
    }

    /// Does what can be done without a worker: where it is known to which files a model refers, its pictures have names. Returns
    /// the others.
    async fn known<'a>(&self, job: &Job<'_>, pictures: Vec<&'a Wanted>) -> Result<Vec<&'a Wanted>, String> {
        let before = pictures.iter().find_map(|wanted| {
            let record = self.previous.picture(&wanted.out)?;
            (record.model_hash.as_ref() == Some(&job.hash)).then(|| names_of(&record.needed))
        });
        let Some(names) = self.ledger.refers_to(&job.hash).or(before) else { return Ok(pictures) };
        let Ok(needed) = self.read_needed(job, &names).await else { return Ok(pictures) };
        let (mut rest, mut copies) = (Vec::new(), Vec::new());
        for wanted in pictures {
            let key = self.keys.of(&job.hash, &job.item.name, &needed, &wanted.request);
            if let Some(record) = self.is_there(wanted, &key).await {
                self.ledger.knows(&key, &record);
                self.keep();
            } else if let Some(made) = self.ledger.made_elsewhere(&key) {
                copies.push((wanted, made));
            } else {
                rest.push(wanted);
            }
        }
        for (wanted, made) in copies {
            self.copy(job, wanted, made).await?;
        }
        Ok(rest)
    }

    /// Lets a worker load the model, and draws those of the pictures that nobody else does.
    async fn drawn(&self, job: &Job<'_>, pictures: Vec<&Wanted>) -> Result<(), String> {
        let requests = pictures.iter().map(|wanted| wanted.request.clone()).collect();
        let work = Work {
            name: job.item.name.clone(),
            pictures: requests,
            facts: true,
            waits: true,
            ..Work::default()
        };
        let fail_all = |error: RecordError| {
            pictures.iter().try_for_each(|wanted| self.fail(job.item, wanted, error.clone()))
        };
        let meter = Meter::default();
        let loaded = match self.pool.load(&work, &job.model, &job.files, &meter).await {
            Ok(loaded) => loaded,
            Err(error) => return fail_all(error.into()),
        };
        let needed = loaded.needed.clone();
        self.ledger.learn(&job.hash, names_of(&needed));
        let mut plans = Vec::new();
        for wanted in &pictures {
            let key = self.keys.of(&job.hash, &job.item.name, &needed, &wanted.request);
            let plan = match self.is_there(wanted, &key).await {
                Some(record) => Plan::Keep(Box::new(record)),
                None => self.ledger.claim(&key),
            };
            plans.push((key, plan));
        }
        let draws =
            |(number, (_, plan)): (usize, &(String, Plan))| matches!(plan, Plan::Draw(_)).then_some(number);
        let numbers: Vec<usize> = plans.iter().enumerate().filter_map(draws).collect();
        // With nothing to draw the worker is free all the same.
        let outcome = loaded.draw(&numbers).await;
        let (mut drawn, error) = match outcome {
            Ok((drawn, _)) => (drawn.into_iter().collect::<HashMap<_, _>>(), None),
            Err(error) => (HashMap::new(), Some(RecordError::from(error))),
        };
        let mut copies = Vec::new();
        for (number, (wanted, (key, plan))) in pictures.iter().zip(plans).enumerate() {
            let done = match plan {
                Plan::Keep(record) => {
                    self.ledger.knows(&key, &record);
                    self.keep();
                    continue;
                }
                Plan::Copy(made) => {
                    copies.push((wanted, made));
                    continue;
                }
                Plan::Draw(done) => done,
            };
            let record = Record { key: Some(key), needed: needed.clone(), ..job.record(wanted) };
            let result = match (drawn.remove(&number), &error) {
                (Some(Ok(picture)), _) => self.finish(job, wanted, record, picture).await,
                (Some(Err(failure)), _) => Err(failure.into()),
                (None, Some(error)) => Err(error.clone()),
                (None, None) => Err(RecordError {
                    kind: ErrorKind::Died,
                    message: "the worker has not drawn it".to_owned(),
                    limit: None,
                }),
            };
            match &result {
                Ok(record) => self.add(record)?,
                Err(error) => self.fail(job.item, wanted, error.clone())?,
            }
            // The receivers may have gone.
            let _ = done.send(Some(result));
        }
        for (wanted, made) in copies {
            self.copy(job, wanted, made).await?;
        }
        Ok(())
    }

    /// Writes a picture, drawn a second time first if it is among those that are verified.
    async fn finish(
        &self,
        job: &Job<'_>,
        wanted: &Wanted,
        mut record: Record,
        picture: DrawnPicture,
    ) -> Outcome {
        let DrawnPicture { files, told } = picture;
        if self.is_verified(record.key.as_deref().unwrap_or_default()) {
            self.draw_again(job, wanted, &files).await?;
            record.verified = true;
            self.ledger.tally.verified.fetch_add(1, Relaxed);
        }
        record.status = Status::Drawn;
        record.size = Some([told.width, told.height]);
        record.warnings = told.warnings;
        record.stages_ms = told.stages_ms;
        record.facts = told.facts;
        let mut all = Vec::new();
        if let Some(report) = told.report {
            let text = serde_json::to_vec_pretty(&sidecar(report)).unwrap_or_default();
            all.push((format!("{}.json", wanted.out), "application/json".to_owned(), text));
        }
        for PictureFile { plane, media_type, bytes } in files {
            all.push((name_of_file(&wanted.out, plane.as_deref()), media_type, bytes));
        }
        for (name, media_type, bytes) in all {
            record.files.push(self.write(&name, &media_type, bytes.into()).await?);
        }
        Ok(record)
    }

    async fn write(&self, name: &str, media_type: &str, bytes: Bytes) -> Result<WrittenFile, RecordError> {
        let file = WrittenFile { name: name.to_owned(), bytes: bytes.len() as u64, hash: hash_of(&bytes) };
        let written = self.to.write(name, bytes, media_type).await;
        written.map_err(|message| RecordError { kind: ErrorKind::Write, message, limit: None })?;
        Ok(file)
    }

    /// Copies the files of a picture that was made under another name, when it is there.
    async fn copy(
        &self,
        job: &Job<'_>,
        wanted: &Wanted,
        mut made: watch::Receiver<Option<Outcome>>,
    ) -> Result<(), String> {
        let outcome = match made.wait_for(Option::is_some).await {
            Ok(outcome) => outcome.clone(),
            Err(_) => None,
        };
        let Some(Ok(source)) = outcome else {
            let gone = RecordError {
                kind: ErrorKind::Died,
                message: "the same picture was not finished under its other name".to_owned(),
                limit: None,
            };
            return self.fail(job.item, wanted, outcome.and_then(Result::err).unwrap_or(gone));
        };
        let mut record = Record {
            status: Status::Copied,
            key: source.key.clone(),
            needed: source.needed.clone(),
            size: source.size,
            facts: source.facts.clone(),
            warnings: source.warnings.clone(),
            ..job.record(wanted)
        };
        for file in &source.files {
            let end = file.name.strip_prefix(stem(&source.out)).unwrap_or(&file.name);
            let name = if file.name == source.out {
                wanted.out.clone()
            } else {
                format!("{}{end}", stem(&wanted.out))
            };
            let read = self.to.read(&file.name, file.bytes).await;
            let copied = match read {
                Ok(bytes) => self.write(&name, media_type(&name), bytes).await,
                Err(missing) => Err(read_error(&missing, file.bytes)),
            };
            match copied {
                Ok(file) => record.files.push(file),
                Err(error) => return self.fail(job.item, wanted, error),
            }
        }
        self.add(&record)
    }

    /// Draws a picture in a new process and compares its bytes with those of the first drawing.
    async fn draw_again(
        &self,
        job: &Job<'_>,
        wanted: &Wanted,
        files: &[PictureFile],
    ) -> Result<(), RecordError> {
        let pictures = vec![wanted.request.clone()];
        let work = Work { name: job.item.name.clone(), pictures, waits: true, ..Work::default() };
        let meter = Meter::default();
        let loaded = self.other.load(&work, &job.model, &job.files, &meter).await?;
        let (drawn, _) = loaded.draw(&[0]).await?;
        let again = drawn.into_iter().next().and_then(|(_, picture)| picture.ok());
        let same = again.is_some_and(|again| {
            again.files.iter().map(|file| &file.bytes).eq(files.iter().map(|file| &file.bytes))
        });
        if same {
            return Ok(());
        }
        self.ledger.tally.differ.fetch_add(1, Relaxed);
        let message = "drawn again by another process it is another picture".to_owned();
        Err(RecordError { kind: ErrorKind::Differs, message, limit: None })
    }

    /// Which pictures are verified follows from their keys, so that it is the same in each run.
    fn is_verified(&self, key: &str) -> bool {
        let start = key.get(..8).and_then(|start| u32::from_str_radix(start, 16).ok());
        start.is_some_and(|start| f64::from(start) < self.verify * f64::from(u32::MAX))
    }

    /// Record of an earlier run for a picture, if its content key is the same and its files are there.
    async fn is_there(&self, wanted: &Wanted, key: &str) -> Option<Record> {
        let record = self.previous.picture(&wanted.out)?;
        if record.key.as_deref() != Some(key) || record.files.is_empty() {
            return None;
        }
        for file in &record.files {
            if self.to.size(&file.name).await != Some(file.bytes) {
                return None;
            }
        }
        Some(Record { status: Status::Kept, ..record.clone() })
    }

    /// Reads the files that a model refers to.
    async fn read_needed(&self, job: &Job<'_>, names: &[(String, bool)]) -> Result<Vec<Needed>, Missing> {
        let mut needed = Vec::with_capacity(names.len());
        for (name, alike) in names {
            needed.push(match job.files.read(name, self.largest_input, *alike).await {
                Ok(found) => Needed::found(name, *alike, &found.bytes),
                Err(Missing::TooLarge) => return Err(Missing::TooLarge),
                Err(_) => Needed::missing(name, *alike),
            });
        }
        Ok(needed)
    }

    fn keep(&self) {
        self.ledger.tally.kept.fetch_add(1, Relaxed);
    }

    fn add(&self, record: &Record) -> Result<(), String> {
        let tally = &self.ledger.tally;
        match record.status {
            Status::Drawn => &tally.drawn,
            Status::Copied => &tally.copied,
            Status::Kept => &tally.kept,
            Status::Failed => &tally.failed,
        }
        .fetch_add(1, Relaxed);
        if record.error.as_ref().is_some_and(|error| error.kind.is_of_surroundings()) {
            tally.of_surroundings.fetch_add(1, Relaxed);
        }
        if !record.warnings.is_empty() {
            tally.warned.fetch_add(1, Relaxed);
        }
        self.watch.note(record);
        self.report.add(record)
    }

    fn fail(&self, item: &Item, wanted: &Wanted, error: RecordError) -> Result<(), String> {
        let (out, model) = (wanted.out.clone(), item.shown.clone());
        self.add(&Record { out, model, status: Status::Failed, error: Some(error), ..Record::default() })
    }
}

/// A model that has been read.
struct Job<'a> {
    item: &'a Item,
    hash: String,
    model: Bytes,
    files: PlaceFiles,
}

impl Job<'_> {
    fn record(&self, wanted: &Wanted) -> Record {
        Record {
            out: wanted.out.clone(),
            model: self.item.shown.clone(),
            model_hash: Some(self.hash.clone()),
            ..Record::default()
        }
    }
}

impl Ledger {
    /// Takes a name for a picture; false if it is taken.
    fn takes_name(&self, out: &str) -> bool {
        let mut start = [0; 16];
        start.copy_from_slice(&blake3::hash(out.as_bytes()).as_bytes()[..16]);
        lock(&self.names).insert(start)
    }

    /// Decides about a picture that is not there: the first with a content key draws it, the others copy.
    fn claim(&self, key: &str) -> Plan {
        let mut made = lock(&self.made);
        if let Some(other) = made.get(key) {
            return Plan::Copy(other.clone());
        }
        let (send, receive) = watch::channel(None);
        made.insert(key.to_owned(), receive);
        Plan::Draw(send)
    }

    fn made_elsewhere(&self, key: &str) -> Option<watch::Receiver<Option<Outcome>>> {
        lock(&self.made).get(key).cloned()
    }

    /// A picture of an earlier run can be copied, too.
    fn knows(&self, key: &str, record: &Record) {
        let (_, receive) = watch::channel(Some(Ok(record.clone())));
        lock(&self.made).entry(key.to_owned()).or_insert(receive);
    }

    fn refers_to(&self, model: &str) -> Option<Vec<(String, bool)>> {
        lock(&self.refers).get(model).cloned()
    }

    fn learn(&self, model: &str, names: Vec<(String, bool)>) {
        lock(&self.refers).entry(model.to_owned()).or_insert(names);
    }
}

fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

fn names_of(needed: &[Needed]) -> Vec<(String, bool)> {
    needed.iter().map(|file| (file.name.clone(), file.alike)).collect()
}

fn read_error(missing: &Missing, limit: u64) -> RecordError {
    let (kind, message, name) = match missing {
        Missing::TooLarge => {
            let message = format!("more than {limit} bytes; --limit input_bytes=N raises it");
            (ErrorKind::Limit, message, Some("input_bytes".to_owned()))
        }
        Missing::Outside => (ErrorKind::Read, "leads out of its folder".to_owned(), None),
        Missing::NotAllowed => (ErrorKind::Read, "may not be read".to_owned(), None),
        Missing::Unreadable { reason } => (ErrorKind::Read, reason.clone(), None),
    };
    RecordError { kind, message, limit: name }
}

/// The name of a picture without its extension.
fn stem(out: &str) -> &str {
    match out.rsplit_once('.') {
        Some((stem, extension)) if !extension.contains('/') && !stem.is_empty() => stem,
        _ => out,
    }
}

/// The name of a file of a picture, as `overcoat render` names them.
fn name_of_file(out: &str, plane: Option<&str>) -> String {
    plane.map_or_else(|| out.to_owned(), |plane| format!("{}.{plane}.png", stem(out)))
}

fn media_type(name: &str) -> &'static str {
    let extension = name.rsplit_once('.').map_or("", |(_, extension)| extension);
    match overcoat::output::OutputFormat::from_extension(extension) {
        Some(format) => format.file_format().mime_type,
        None if extension == "json" => "application/json",
        None => "application/octet-stream",
    }
}

/// The reproducible part of a report: without times, memory, threads and instruction set.
fn sidecar(mut report: Value) -> Value {
    if let Value::Object(report) = &mut report {
        for times in ["stages_ms", "total_ms", "peak_rss_bytes", "threads", "simd"] {
            report.remove(times);
        }
    }
    report
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn planes_are_named_as_by_the_program() {
        assert_eq!(name_of_file("a/b.glb.png", Some("depth")), "a/b.glb.depth.png");
        assert_eq!(name_of_file("a.b/c", Some("depth")), "a.b/c.depth.png");
        assert_eq!(name_of_file("a.exr", None), "a.exr");
    }
}
