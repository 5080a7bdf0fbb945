//! A folder of bounded size: the least recently used files go first.

use super::cache::path_in;
use std::collections::{BTreeMap, HashMap};
use std::fs;
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::SystemTime;

/// Beginning of the names of files that are not whole yet.
const UNFINISHED: &str = "unfinished-";

/// The folder.
#[derive(Debug)]
pub struct Disk {
    root: PathBuf,
    most: u64,
    ledger: Mutex<Ledger>,
    count: AtomicU64,
}

/// Entries in the order of their last use. Clocks may jump; numbers do not.
#[derive(Debug, Default)]
struct Ledger {
    entries: HashMap<String, (u64, u64)>,
    order: BTreeMap<u64, String>,
    bytes: u64,
    next: u64,
}

impl Disk {
    /// A folder, which need not be there yet.
    #[must_use]
    pub fn open(root: &Path, most: u64) -> Self {
        let mut found = Vec::new();
        for folder in fs::read_dir(root).into_iter().flatten().flatten() {
            for entry in fs::read_dir(folder.path()).into_iter().flatten().flatten() {
                let (Ok(name), Ok(metadata)) = (entry.file_name().into_string(), entry.metadata()) else {
                    continue;
                };
                if name.starts_with(UNFINISHED) {
                    remove_old(&entry.path(), &metadata);
                } else if metadata.is_file() {
                    found.push((metadata.modified().unwrap_or(SystemTime::UNIX_EPOCH), name, metadata.len()));
                }
            }
        }
        found.sort();
        let disk = Self { root: root.to_owned(), most, ledger: Mutex::default(), count: AtomicU64::new(0) };
        let evicted = {
            let mut ledger = disk.lock();
            found.into_iter().for_each(|(_, name, bytes)| ledger.touch(&name, bytes));
            ledger.evict(most)
        };
        disk.delete(&evicted);
        disk
    }

    fn lock(&self) -> MutexGuard<'_, Ledger> {
        self.ledger.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Bytes and entries.
    #[must_use]
    pub fn size(&self) -> (u64, usize) {
        let ledger = self.lock();
        (ledger.bytes, ledger.entries.len())
    }

    /// An entry. Those that another process wrote are found, too.
    #[must_use]
    pub fn read(&self, name: &str) -> Option<Vec<u8>> {
        let path = path_in(&self.root, name);
        let Ok(bytes) = fs::read(&path) else {
            self.lock().forget(name);
            return None;
        };
        self.lock().touch(name, bytes.len() as u64);
        // So that the next process knows the order. Where that cannot be written, it does not.
        if let Ok(file) = fs::File::options().append(true).open(&path) {
            let _ = file.set_modified(SystemTime::now());
        }
        Some(bytes)
    }

    /// Writes an entry, whole or not at all, and makes room for it.
    ///
    /// # Errors
    /// Errors of the system.
    pub fn write(&self, name: &str, bytes: &[u8]) -> io::Result<()> {
        let size = bytes.len() as u64;
        if size > self.most {
            return Err(io::Error::other("the entry is larger than the cache may be"));
        }
        let evicted = self.lock().evict(self.most - size);
        self.delete(&evicted);
        let path = path_in(&self.root, name);
        let mut written = self.put(&path, bytes);
        if written.as_ref().is_err_and(|e| e.kind() == ErrorKind::StorageFull) {
            // Others fill the disk: old entries are worth less than the one asked for now.
            let less = self.lock().bytes.saturating_sub(size.max(1 << 20) * 4);
            let evicted = self.lock().evict(less);
            self.delete(&evicted);
            written = self.put(&path, bytes);
        }
        written?;
        self.lock().touch(name, size);
        Ok(())
    }

    fn put(&self, path: &Path, bytes: &[u8]) -> io::Result<()> {
        let folder = path.parent().unwrap_or(&self.root);
        fs::create_dir_all(folder)?;
        let number = self.count.fetch_add(1, Relaxed);
        let unfinished = folder.join(format!("{UNFINISHED}{}-{number}", std::process::id()));
        let written = fs::File::create(&unfinished)
            .and_then(|mut file| file.write_all(bytes))
            .and_then(|()| fs::rename(&unfinished, path));
        if written.is_err() {
            let _ = fs::remove_file(&unfinished);
        }
        written
    }

    /// Drops an entry.
    pub fn remove(&self, name: &str) {
        self.lock().forget(name);
        self.delete(&[name.to_owned()]);
    }

    fn delete(&self, names: &[String]) {
        for name in names {
            // It may be gone, or there to stay.
            let _ = fs::remove_file(path_in(&self.root, name));
        }
    }
}

impl Ledger {
    fn touch(&mut self, name: &str, bytes: u64) {
        self.forget(name);
        self.next += 1;
        self.entries.insert(name.to_owned(), (self.next, bytes));
        self.order.insert(self.next, name.to_owned());
        self.bytes += bytes;
    }

    fn forget(&mut self, name: &str) {
        if let Some((number, bytes)) = self.entries.remove(name) {
            self.order.remove(&number);
            self.bytes -= bytes;
        }
    }

    /// Forgets the oldest entries until so many bytes are left.
    fn evict(&mut self, most: u64) -> Vec<String> {
        let mut evicted = Vec::new();
        while self.bytes > most {
            let Some((_, name)) = self.order.first_key_value() else { break };
            let name = name.clone();
            self.forget(&name);
            evicted.push(name);
        }
        evicted
    }
}

/// Removes an unfinished file that another process left behind; those still being written are younger.
fn remove_old(path: &Path, metadata: &fs::Metadata) {
    let age = metadata.modified().ok().and_then(|time| time.elapsed().ok());
    if age.is_some_and(|age| age.as_secs() > 600) {
        let _ = fs::remove_file(path);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_oldest_goes_first() {
        let folder = tempfile::tempdir().unwrap();
        let disk = Disk::open(folder.path(), 100);
        for name in ["aa", "bb", "cc"] {
            disk.write(name, &[0; 30]).unwrap();
        }
        assert_eq!(disk.size(), (90, 3));
        assert!(disk.read("aa").is_some());
        disk.write("dd", &[0; 30]).unwrap();
        assert!(disk.read("bb").is_none() && disk.read("aa").is_some() && disk.read("dd").is_some());
        assert_eq!(disk.size(), (90, 3));
        disk.write("aa", &[0; 10]).unwrap();
        assert_eq!(disk.size(), (70, 3));
        assert!(disk.write("ee", &[0; 101]).is_err());
        assert_eq!(disk.size(), (70, 3));
        drop(disk);
        // A smaller one makes room at once.
        assert_eq!(Disk::open(folder.path(), 45).size(), (40, 2));
        assert!(Disk::open(&folder.path().join("none"), 45).write("aa", &[0; 9]).is_ok());
    }
}
