//! The report of a batch: a line of JSON for each picture, as soon as it is there.

use crate::files::Needed;
use crate::pool::WorkError;
use overcoat_worker::model_facts::ModelFacts;
use overcoat_worker::protocol::{FailureClass, FailureReport};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, HashMap};
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{BufRead, BufReader, Seek, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

/// Record of a picture in the report. Fields are only ever added.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// Path of the file below the output place.
    pub out: String,
    /// The model.
    pub model: String,
    /// Outcome for the picture.
    pub status: Status,
    /// Content key: hash of all inputs of the picture.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub key: Option<String>,
    /// BLAKE3 of the model's file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub model_hash: Option<String>,
    /// Files that the model refers to.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub needed: Vec<Needed>,
    /// All files of the picture, its own last.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub files: Vec<WrittenFile>,
    /// Pixels.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub size: Option<[u32; 2]>,
    /// Milliseconds by stage, of pictures that were drawn.
    #[serde(default, skip_serializing_if = "serde_json::Value::is_null")]
    pub stages_ms: serde_json::Value,
    /// Counts, size and colours of the model.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub facts: Option<ModelFacts>,
    /// Losses in the picture, a line each.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub warnings: Vec<String>,
    /// It was drawn twice, with the same bytes.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub verified: bool,
    /// Reason why there is no picture.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub error: Option<RecordError>,
}

impl Record {
    /// Time of all stages to a microsecond, of pictures that were drawn.
    #[must_use]
    pub fn milliseconds(&self) -> Option<f64> {
        let sum: f64 = self.stages_ms.as_object()?.values().filter_map(serde_json::Value::as_f64).sum();
        Some((sum * 1000.0).round() / 1000.0)
    }
}

/// A file that was written.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct WrittenFile {
    /// Path below the output place.
    pub name: String,
    /// Length in bytes.
    pub bytes: u64,
    /// BLAKE3 of its content.
    pub hash: String,
}

/// Outcome for a picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Status {
    /// Rendered.
    Drawn,
    /// Another has the same content key: its files were copied.
    Copied,
    /// It was there already.
    Kept,
    /// There is none.
    #[default]
    Failed,
}

impl Status {
    /// Name in reports.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Drawn => "drawn",
            Self::Copied => "copied",
            Self::Kept => "kept",
            Self::Failed => "failed",
        }
    }
}

/// Reason why there is no picture.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct RecordError {
    /// Kind of the reason.
    pub kind: ErrorKind,
    /// One line.
    pub message: String,
    /// The limit that was passed, as `--limit` names it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub limit: Option<String>,
}

/// Kinds of reasons.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ErrorKind {
    /// The model cannot be read from where it is.
    Read,
    /// The model is wrong.
    Failed,
    /// The request is contradictory or invalid.
    Usage,
    /// A limit of the renderer.
    Limit,
    /// The worker's memory.
    Memory,
    /// The worker's time.
    Timeout,
    /// The worker ended.
    Died,
    /// No worker could be started.
    NoWorker,
    /// The picture cannot be written.
    Write,
    /// Drawn twice it was two pictures.
    Differs,
}

impl ErrorKind {
    /// Name in reports.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Read => "read",
            Self::Failed => "failed",
            Self::Usage => "usage",
            Self::Limit => "limit",
            Self::Memory => "memory",
            Self::Timeout => "timeout",
            Self::Died => "died",
            Self::NoWorker => "no_worker",
            Self::Write => "write",
            Self::Differs => "differs",
        }
    }

    /// True if the environment is at fault and not the model, so that another try may do better: a store, a disk,
    /// workers that cannot be started.
    #[must_use]
    pub const fn is_of_surroundings(self) -> bool {
        matches!(self, Self::Read | Self::Write | Self::NoWorker)
    }
}

impl From<FailureReport> for RecordError {
    fn from(FailureReport { class, message, limit }: FailureReport) -> Self {
        let kind = match class {
            FailureClass::Failed => ErrorKind::Failed,
            FailureClass::Usage => ErrorKind::Usage,
            FailureClass::Limit => ErrorKind::Limit,
        };
        Self { kind, message, limit }
    }
}

impl From<WorkError> for RecordError {
    fn from(error: WorkError) -> Self {
        let message = error.to_string();
        let kind = match error {
            WorkError::Failed(failure) => return failure.into(),
            WorkError::TimedOut(_) => ErrorKind::Timeout,
            WorkError::Died(death) if death.of_memory => ErrorKind::Memory,
            WorkError::Died(_) => ErrorKind::Died,
            WorkError::NoWorker(_) => ErrorKind::NoWorker,
        };
        Self { kind, message, limit: None }
    }
}

/// The file that records are added to.
#[derive(Debug)]
pub struct Report {
    path: PathBuf,
    file: Mutex<File>,
}

impl Report {
    /// Opens a report: an empty one, or, to go on, the one that is there, with its records.
    ///
    /// # Errors
    /// One line.
    pub fn open(path: &Path, go_on: bool) -> Result<(Self, Previous), String> {
        let about = |e: std::io::Error| format!("{}: {e}", path.display());
        if let Some(folder) = path.parent() {
            std::fs::create_dir_all(folder).map_err(about)?;
        }
        let mut file = OpenOptions::new()
            .read(true)
            .write(true)
            .create(true)
            // Not before it is this process's own.
            .truncate(false)
            .open(path)
            .map_err(about)?;
        wait_for_others(&file, path).map_err(about)?;
        if !go_on {
            file.set_len(0).map_err(about)?;
        }
        let previous = Previous::read(&mut file).map_err(about)?;
        Ok((Self { path: path.to_owned(), file: Mutex::new(file) }, previous))
    }

    /// Adds a record, whole.
    ///
    /// # Errors
    /// One line.
    pub fn add(&self, record: &Record) -> Result<(), String> {
        let mut line = serde_json::to_vec(record).map_err(|e| e.to_string())?;
        line.push(b'\n');
        let mut file = self.file.lock().unwrap_or_else(PoisonError::into_inner);
        file.write_all(&line).map_err(|e| format!("{}: {e}", self.path.display()))
    }
}

/// The last record of each picture of a report, by the names of the pictures.
///
/// # Errors
/// One line.
pub fn last_records(path: &Path) -> Result<Vec<Record>, String> {
    let about = |e: std::io::Error| format!("{}: {e}", path.display());
    let mut pictures = BTreeMap::new();
    for line in BufReader::new(File::open(path).map_err(about)?).split(b'\n') {
        if let Ok(record) = serde_json::from_slice::<Record>(&line.map_err(about)?) {
            pictures.insert(record.out.clone(), record);
        }
    }
    Ok(pictures.into_values().collect())
}

/// Waits until no other process adds to a report. One whose parent was killed may still be at work on the same: what it makes is
/// kept, and not made twice.
fn wait_for_others(file: &File, path: &Path) -> std::io::Result<()> {
    match file.try_lock() {
        Ok(()) => Ok(()),
        Err(TryLockError::WouldBlock) => {
            eprintln!("{}: waits for another process that adds to it", path.display());
            file.lock()
        }
        // File systems without locks have no other process either, as far as anybody can tell.
        Err(TryLockError::Error(e)) if e.kind() == std::io::ErrorKind::Unsupported => Ok(()),
        Err(TryLockError::Error(e)) => Err(e),
    }
}

/// Records of an earlier report, the last of each picture.
#[derive(Debug, Default)]
pub struct Previous {
    pictures: HashMap<String, Record>,
}

impl Previous {
    /// The pictures that are there. A last line that was cut is taken away: its picture is made again.
    fn read(file: &mut File) -> std::io::Result<Self> {
        let mut pictures = HashMap::new();
        let mut whole = 0;
        let mut lines = BufReader::new(&mut *file);
        let mut line = Vec::new();
        while lines.read_until(b'\n', &mut line)? > 0 && line.ends_with(b"\n") {
            whole += line.len() as u64;
            if let Ok(record) = serde_json::from_slice::<Record>(&line) {
                pictures.insert(record.out.clone(), record);
            }
            line.clear();
        }
        file.set_len(whole)?;
        file.seek(std::io::SeekFrom::End(0))?;
        pictures.retain(|_, record| record.status != Status::Failed);
        Ok(Self { pictures })
    }

    /// Record of a picture in the earlier report, if it has one.
    #[must_use]
    pub fn picture(&self, out: &str) -> Option<&Record> {
        self.pictures.get(out)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_those_of_the_report() {
        for status in [Status::Drawn, Status::Copied, Status::Kept, Status::Failed] {
            assert_eq!(serde_json::json!(status), status.name());
        }
        for kind in [
            ErrorKind::Read,
            ErrorKind::Failed,
            ErrorKind::Usage,
            ErrorKind::Limit,
            ErrorKind::Memory,
            ErrorKind::Timeout,
            ErrorKind::Died,
            ErrorKind::NoWorker,
            ErrorKind::Write,
            ErrorKind::Differs,
        ] {
            assert_eq!(serde_json::json!(kind), kind.name());
        }
    }

    #[test]
    fn a_report_goes_on_where_it_was_cut() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a/report.jsonl");
        let record = |out: &str, status: Status| Record { out: out.to_owned(), status, ..Record::default() };
        let (report, _) = Report::open(&path, true).unwrap();
        for (out, status) in
            [("a", Status::Drawn), ("b", Status::Failed), ("c", Status::Drawn), ("c", Status::Failed)]
        {
            report.add(&record(out, status)).unwrap();
        }
        drop(report);
        let mut text = std::fs::read(&path).unwrap();
        let whole = text.len();
        text.extend(b"{\"out\": \"d\", \"sta");
        std::fs::write(&path, &text).unwrap();
        let (report, previous) = Report::open(&path, true).unwrap();
        assert!(previous.picture("a").is_some());
        assert!(["b", "c", "d"].iter().all(|out| previous.picture(out).is_none()));
        assert_eq!(std::fs::metadata(&path).unwrap().len(), whole as u64);
        report.add(&record("d", Status::Drawn)).unwrap();
        drop(report);
        let last: Vec<(String, Status)> =
            last_records(&path).unwrap().into_iter().map(|record| (record.out, record.status)).collect();
        let expected =
            [("a", Status::Drawn), ("b", Status::Failed), ("c", Status::Failed), ("d", Status::Drawn)];
        assert_eq!(last, expected.map(|(out, status)| (out.to_owned(), status)));
        let (_, previous) = Report::open(&path, true).unwrap();
        assert!(previous.picture("d").is_some());
        let (_, previous) = Report::open(&path, false).unwrap();
        assert!(previous.picture("a").is_none());
    }
}
