//! Jobs in a folder, which survive the end of the process, however it comes.
//!
//! A job is a folder of its own: `job.json` and `body` as they came, then `result`, and `outcome.json` last, whose being there says that
//! the job is done. Files are written under other names, brought to the disk, and put into place whole.

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fs::{self, File, TryLockError};
use std::io::{self, Write};
use std::net::IpAddr;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{SystemTime, UNIX_EPOCH};

/// Beginning of the names of files and folders that are not whole yet.
const UNFINISHED: &str = "unfinished-";
const JOB: &str = "job.json";
const BODY: &str = "body";
const RESULT: &str = "result";
const OUTCOME: &str = "outcome.json";

/// A request that is done later.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Job {
    /// Its options, as a query.
    pub query: String,
    /// URL that its result is sent to.
    pub callback: String,
    /// Content-Type of its body.
    pub content_type: Option<String>,
    /// Content-Disposition of its body.
    pub disposition: Option<String>,
    /// Address of its client.
    pub client: Option<IpAddr>,
    /// Name of the holder of its key.
    pub holder: Option<String>,
}

/// Outcome of a job, beside the bytes of the picture or of the error.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Outcome {
    /// Status that the request would have been answered with.
    pub status: u16,
    /// Content-Type of its answer.
    pub content_type: String,
}

/// The folder.
#[derive(Debug)]
pub struct Spool {
    root: PathBuf,
    most_jobs: usize,
    most_bytes: u64,
    jobs: Mutex<BTreeMap<String, u64>>,
    count: AtomicU64,
    /// Two services would do each job twice.
    _lock: File,
}

impl Spool {
    /// Opens a folder, which is made if it is not there, for this process alone. Jobs that were not whole are gone.
    ///
    /// # Errors
    /// One line.
    pub fn open(root: &Path, most_jobs: usize, most_bytes: u64) -> Result<Self, String> {
        let about = |e: io::Error| format!("{}: {e}", root.display());
        fs::create_dir_all(root).map_err(about)?;
        let lock = File::create(root.join("lock")).map_err(about)?;
        lock.try_lock().map_err(|e| match e {
            TryLockError::WouldBlock => format!("{}: another service has it", root.display()),
            TryLockError::Error(e) => about(e),
        })?;
        let mut jobs = BTreeMap::new();
        for entry in fs::read_dir(root).map_err(about)?.flatten() {
            let Ok(name) = entry.file_name().into_string() else { continue };
            if name.starts_with(UNFINISHED) {
                let _ = fs::remove_dir_all(entry.path());
            } else if entry.path().join(JOB).is_file() {
                let size = entry.path().join(BODY).metadata().map_or(0, |file| file.len());
                jobs.insert(name, size);
            }
        }
        let jobs = Mutex::new(jobs);
        Ok(Self { root: root.to_owned(), most_jobs, most_bytes, jobs, count: AtomicU64::new(0), _lock: lock })
    }

    fn jobs(&self) -> MutexGuard<'_, BTreeMap<String, u64>> {
        self.jobs.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Names of all jobs, in the order in which they came.
    #[must_use]
    pub fn names(&self) -> Vec<String> {
        self.jobs().keys().cloned().collect()
    }

    /// True if there is a job of this name.
    #[must_use]
    pub fn has(&self, name: &str) -> bool {
        self.jobs().contains_key(name)
    }

    /// Keeps a job. Returns its name once it is on the disk, `None` if there is no room for it.
    ///
    /// # Errors
    /// Errors of the disk.
    pub fn add(&self, job: &Job, body: &[u8]) -> io::Result<Option<String>> {
        let name = self.name(body);
        {
            let mut jobs = self.jobs();
            let bytes: u64 = jobs.values().sum();
            if jobs.len() >= self.most_jobs || bytes + body.len() as u64 > self.most_bytes {
                return Ok(None);
            }
            jobs.insert(name.clone(), body.len() as u64);
        }
        let written = self.write_job(&name, job, body);
        if written.is_err() {
            self.jobs().remove(&name);
            let _ = fs::remove_dir_all(self.root.join(format!("{UNFINISHED}{name}")));
        }
        written.map(|()| Some(name))
    }

    fn write_job(&self, name: &str, job: &Job, body: &[u8]) -> io::Result<()> {
        let unfinished = self.root.join(format!("{UNFINISHED}{name}"));
        fs::create_dir(&unfinished)?;
        write(&unfinished.join(JOB), &serde_json::to_vec(job)?)?;
        write(&unfinished.join(BODY), body)?;
        settle(&unfinished)?;
        fs::rename(&unfinished, self.root.join(name))?;
        settle(&self.root)
    }

    /// A name that no other job has, later than those of earlier jobs as long as the clock goes forward.
    fn name(&self, body: &[u8]) -> String {
        let now = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default().as_nanos();
        let count = self.count.fetch_add(1, Relaxed);
        let mut hasher = blake3::Hasher::new();
        hasher
            .update(&now.to_le_bytes())
            .update(&count.to_le_bytes())
            .update(&std::process::id().to_le_bytes());
        let hash = hasher.update(body).finalize().to_hex();
        format!("{:014x}-{}", now / 1000, &hash[..20])
    }

    /// A job and its body.
    ///
    /// # Errors
    /// Errors of the disk.
    pub fn read(&self, name: &str) -> io::Result<(Job, Vec<u8>)> {
        let folder = self.root.join(name);
        Ok((read_json(&folder.join(JOB))?, fs::read(folder.join(BODY))?))
    }

    /// Keeps the result of a job, which is not done again then.
    ///
    /// # Errors
    /// Errors of the disk.
    pub fn finish(&self, name: &str, outcome: &Outcome, result: &[u8]) -> io::Result<()> {
        let folder = self.root.join(name);
        write(&folder.join(RESULT), result)?;
        let unfinished = folder.join(format!("{UNFINISHED}{OUTCOME}"));
        write(&unfinished, &serde_json::to_vec(outcome)?)?;
        fs::rename(unfinished, folder.join(OUTCOME))?;
        settle(&folder)
    }

    /// The result of a job, if it is done.
    ///
    /// # Errors
    /// Errors of the disk.
    pub fn result(&self, name: &str) -> io::Result<Option<(Outcome, Vec<u8>)>> {
        let folder = self.root.join(name);
        match read_json(&folder.join(OUTCOME)) {
            Ok(outcome) => Ok(Some((outcome, fs::read(folder.join(RESULT))?))),
            Err(e) if e.kind() == io::ErrorKind::NotFound => Ok(None),
            Err(e) => Err(e),
        }
    }

    /// Forgets a job.
    pub fn remove(&self, name: &str) {
        let gone = self.root.join(format!("{UNFINISHED}{name}"));
        // Under another name first: half of a job would be done again.
        if fs::rename(self.root.join(name), &gone).is_ok() {
            let _ = fs::remove_dir_all(gone);
        }
        self.jobs().remove(name);
    }
}

fn read_json<T: DeserializeOwned>(path: &Path) -> io::Result<T> {
    Ok(serde_json::from_slice(&fs::read(path)?)?)
}

/// Writes a file to the disk.
fn write(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let mut file = File::create(path)?;
    file.write_all(bytes)?;
    file.sync_all()
}

/// Brings the names in a folder to the disk.
fn settle(folder: &Path) -> io::Result<()> {
    if cfg!(unix) { File::open(folder)?.sync_all() } else { Ok(()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn job(query: &str) -> Job {
        Job {
            query: query.to_owned(),
            callback: "https://a.example/x".to_owned(),
            content_type: Some("model/stl".to_owned()),
            disposition: None,
            client: Some([127, 0, 0, 1].into()),
            holder: None,
        }
    }

    #[test]
    fn jobs_are_there_after_the_process() {
        let folder = tempfile::tempdir().unwrap();
        let root = folder.path().join("a/b");
        let spool = Spool::open(&root, 3, 100).unwrap();
        assert!(Spool::open(&root, 3, 100).unwrap_err().contains("another service"));
        let first = spool.add(&job("size=1"), b"one").unwrap().unwrap();
        let second = spool.add(&job("size=2"), b"two").unwrap().unwrap();
        let done = Outcome { status: 200, content_type: "image/png".to_owned() };
        assert_eq!(spool.result(&first).unwrap(), None);
        spool.finish(&first, &done, b"PNG").unwrap();
        drop(spool);
        // Results that were not whole are not there.
        fs::create_dir(root.join("unfinished-x")).unwrap();
        fs::write(root.join("unfinished-x").join(JOB), "{}").unwrap();
        let spool = Spool::open(&root, 3, 100).unwrap();
        assert_eq!(spool.names(), [first.clone(), second.clone()]);
        assert!(!root.join("unfinished-x").exists());
        assert_eq!(spool.read(&second).unwrap(), (job("size=2"), b"two".to_vec()));
        assert_eq!(spool.result(&first).unwrap(), Some((done, b"PNG".to_vec())));
        spool.remove(&first);
        assert!(!spool.has(&first) && !root.join(&first).exists());
    }

    #[test]
    fn there_is_room_for_so_many() {
        let folder = tempfile::tempdir().unwrap();
        let spool = Spool::open(folder.path(), 2, 10).unwrap();
        assert!(spool.add(&job(""), &[0; 11]).unwrap().is_none());
        let first = spool.add(&job(""), &[0; 6]).unwrap().unwrap();
        assert!(spool.add(&job(""), &[0; 5]).unwrap().is_none());
        assert!(spool.add(&job(""), &[0; 4]).unwrap().is_some());
        assert!(spool.add(&job(""), &[]).unwrap().is_none());
        spool.remove(&first);
        assert!(spool.add(&job(""), &[]).unwrap().is_some());
    }
}
