//! Cache of pictures. Entries are checked when they are read: damaged ones are dropped and made anew. A cache that is
//! full, read-only or gone costs time and nothing else.

use super::disk::Disk;
use super::metrics::Metrics;
use crate::place::{Place, is_url};
use bytes::Bytes;
use overcoat_worker::protocol::Missing;
use serde::{Deserialize, Serialize};
use std::collections::{HashMap, VecDeque};
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};

/// Bytes of an entry at most.
const LARGEST: u64 = 1 << 31;
/// Models whose files are remembered in memory.
const REMEMBERED: usize = 1 << 16;
/// Bytes of a hash.
const HASH: usize = 32;

/// A picture and its metadata.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Picture {
    /// Content key.
    pub key: String,
    /// Media type.
    pub media_type: String,
    /// Pixels.
    pub width: u32,
    /// Pixels.
    pub height: u32,
    /// Losses in the picture, a line each.
    pub warnings: Vec<String>,
    /// Milliseconds by stage, of one that was just drawn.
    #[serde(skip)]
    pub stages: Vec<(String, f64)>,
    /// Content of its file.
    #[serde(skip)]
    pub bytes: Bytes,
}

/// The names of the files that a model refers to, and whether they were looked for by another spelling.
pub type Names = Vec<(String, bool)>;

/// Pictures by their content keys, and the names that models refer to.
#[derive(Debug)]
pub struct Cache {
    store: Option<Store>,
    names: Mutex<Remembered>,
    metrics: Arc<Metrics>,
}

#[derive(Debug)]
enum Store {
    Disk(Arc<Disk>),
    Place(Place),
}

/// References of models in memory, without a store; the oldest are forgotten first.
#[derive(Debug, Default)]
struct Remembered {
    names: HashMap<String, Arc<Names>>,
    order: VecDeque<String>,
}

impl Cache {
    /// In a folder, under the prefix of an object store, or nowhere.
    ///
    /// # Errors
    /// One line.
    pub fn new(place: Option<&str>, most: u64, metrics: Arc<Metrics>) -> Result<Self, String> {
        let store = match place {
            None => None,
            Some(url) if is_url(url) && !url.starts_with("file:") => Some(Store::Place(Place::new(url)?)),
            Some(path) => {
                let Place::Folder(path) = Place::new(path)? else { return Err(format!("{path}: no folder")) };
                Some(Store::Disk(Arc::new(Disk::open(&path, most))))
            }
        };
        Ok(Self { store, names: Mutex::default(), metrics })
    }

    /// Bytes and entries of a cache in a folder.
    #[must_use]
    pub fn size(&self) -> Option<(u64, usize)> {
        match &self.store {
            Some(Store::Disk(disk)) => Some(disk.size()),
            _ => None,
        }
    }

    /// A picture.
    pub async fn picture(&self, key: &str) -> Option<Picture> {
        let found = self.picture_of(key).await;
        if self.store.is_some() {
            self.metrics.cache(if found.is_some() { "hit" } else { "miss" });
        }
        found
    }

    async fn picture_of(&self, key: &str) -> Option<Picture> {
        let bytes = self.read(&format!("{key}.picture")).await?;
        let (length, rest) = bytes.split_first_chunk::<4>()?;
        let length = usize::try_from(u32::from_le_bytes(*length)).ok()?;
        let picture: Picture = serde_json::from_slice(rest.get(..length)?).ok()?;
        // An entry of another name is none of this one.
        (picture.key == key).then(|| Picture { bytes: bytes.slice(4 + length..), ..picture })
    }

    /// Keeps a picture.
    pub async fn keep(&self, picture: &Picture) {
        if self.store.is_none() {
            return;
        }
        let head = serde_json::to_vec(picture).unwrap_or_default();
        let mut entry = Vec::with_capacity(4 + head.len() + picture.bytes.len());
        entry.extend((head.len() as u32).to_le_bytes());
        entry.extend(head);
        entry.extend_from_slice(&picture.bytes);
        self.write(&format!("{}.picture", picture.key), entry).await;
    }

    /// The names that a model refers to, by the name of the request.
    pub async fn names(&self, of: &str) -> Option<Arc<Names>> {
        let known = self.remembered().names.get(of).cloned();
        if known.is_some() {
            return known;
        }
        let bytes = self.read(&format!("{of}.names")).await?;
        let names: Arc<Names> = Arc::new(serde_json::from_slice(&bytes).ok()?);
        self.remembered().learn(of, Arc::clone(&names));
        Some(names)
    }

    /// Remembers the names that a model refers to.
    pub async fn learn(&self, of: &str, names: Names) {
        if self.remembered().names.get(of).is_some_and(|known| **known == names) {
            return;
        }
        let text = serde_json::to_vec(&names).unwrap_or_default();
        self.remembered().learn(of, Arc::new(names));
        self.write(&format!("{of}.names"), text).await;
    }

    fn remembered(&self) -> std::sync::MutexGuard<'_, Remembered> {
        self.names.lock().unwrap_or_else(PoisonError::into_inner)
    }

    async fn read(&self, name: &str) -> Option<Bytes> {
        let bytes = match self.store.as_ref()? {
            Store::Disk(disk) => {
                let (disk, name) = (Arc::clone(disk), name.to_owned());
                Bytes::from(tokio::task::spawn_blocking(move || disk.read(&name)).await.ok()??)
            }
            Store::Place(place) => match place.read(&sharded(name), LARGEST).await {
                Ok(bytes) => bytes,
                Err(missing) => {
                    if !matches!(&missing, Missing::Unreadable { reason } if reason.contains("o such file")) {
                        self.metrics.cache("read_error");
                    }
                    return None;
                }
            },
        };
        let checked = (bytes.len() >= HASH && blake3::hash(&bytes[HASH..]).as_bytes()[..] == bytes[..HASH])
            .then(|| bytes.slice(HASH..));
        if checked.is_none() {
            self.metrics.cache("damaged");
            tracing::warn!(entry = name, "an entry of the cache is damaged: it is made anew");
            if let Some(Store::Disk(disk)) = &self.store {
                disk.remove(name);
            }
        }
        checked
    }

    async fn write(&self, name: &str, content: Vec<u8>) {
        let mut entry = blake3::hash(&content).as_bytes().to_vec();
        entry.extend(content);
        let written = match &self.store {
            None => return,
            Some(Store::Disk(disk)) => {
                let (disk, name) = (Arc::clone(disk), name.to_owned());
                let written = tokio::task::spawn_blocking(move || disk.write(&name, &entry)).await;
                written.map_err(|e| e.to_string()).and_then(|written| written.map_err(|e| e.to_string()))
            }
            Some(Store::Place(place)) => {
                place.write(&sharded(name), entry.into(), "application/octet-stream").await
            }
        };
        match written {
            Ok(()) => self.metrics.cache("write"),
            Err(reason) => {
                self.metrics.cache("write_error");
                tracing::warn!(reason, "the cache cannot be written: pictures are not kept");
            }
        }
    }
}

impl Remembered {
    fn learn(&mut self, of: &str, names: Arc<Names>) {
        if self.names.insert(of.to_owned(), names).is_none() {
            self.order.push_back(of.to_owned());
        }
        while self.order.len() > REMEMBERED {
            if let Some(oldest) = self.order.pop_front() {
                self.names.remove(&oldest);
            }
        }
    }
}

/// Folders of a size that people can list.
fn sharded(name: &str) -> String {
    format!("{}/{name}", name.get(..2).unwrap_or("__"))
}

/// The file of an entry in a folder.
pub(super) fn path_in(root: &Path, name: &str) -> std::path::PathBuf {
    root.join(sharded(name))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(key: &str, size: usize) -> Picture {
        Picture {
            key: key.to_owned(),
            media_type: "image/png".to_owned(),
            width: 3,
            height: 2,
            warnings: vec!["w".to_owned()],
            stages: Vec::new(),
            bytes: vec![7; size].into(),
        }
    }

    fn cache(path: &Path, most: u64) -> Cache {
        Cache::new(Some(path.to_str().unwrap()), most, Arc::default()).unwrap()
    }

    #[tokio::test]
    async fn entries_are_kept_and_checked() {
        let folder = tempfile::tempdir().unwrap();
        let cache = cache(folder.path(), 1 << 20);
        let one = picture(&"a1".repeat(32), 100);
        assert_eq!(cache.picture(&one.key).await, None);
        cache.keep(&one).await;
        assert_eq!(cache.picture(&one.key).await.as_ref(), Some(&one));
        let file = path_in(folder.path(), &format!("{}.picture", one.key));
        let mut bytes = std::fs::read(&file).unwrap();
        for at in [0, HASH + 1, bytes.len() - 1] {
            bytes[at] ^= 1;
            std::fs::write(&file, &bytes).unwrap();
            assert_eq!(cache.picture(&one.key).await, None, "{at}");
            assert!(!file.exists(), "{at}");
            bytes[at] ^= 1;
        }
        std::fs::write(&file, &bytes[..20]).unwrap();
        assert_eq!(cache.picture(&one.key).await, None);
    }

    #[tokio::test]
    async fn another_process_knows_what_was_kept() {
        let folder = tempfile::tempdir().unwrap();
        let first = cache(folder.path(), 1 << 20);
        let second = cache(folder.path(), 1 << 20);
        let one = picture(&"b2".repeat(32), 10);
        first.keep(&one).await;
        first.learn("c3", vec![("a.png".to_owned(), false)]).await;
        assert_eq!(second.picture(&one.key).await, Some(one));
        assert_eq!(*second.names("c3").await.unwrap(), [("a.png".to_owned(), false)]);
        assert_eq!(cache(folder.path(), 1 << 20).size().unwrap().1, 2);
    }

    #[tokio::test]
    async fn a_cache_that_cannot_be_written_is_done_without() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("file");
        std::fs::write(&file, b"x").unwrap();
        let cache = cache(&file, 1 << 20);
        let one = picture(&"d4".repeat(32), 10);
        cache.keep(&one).await;
        assert_eq!(cache.picture(&one.key).await, None);
        cache.learn("e5", Vec::new()).await;
        assert!(cache.names("e5").await.is_some());
    }
}
