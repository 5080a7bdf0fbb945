//! The files that models refer to, for workers that can reach none themselves.

use bytes::Bytes;
use overcoat::load::{DirectoryResolver, ResolveError, Resolver};
use overcoat_worker::protocol::Missing;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::future::Future;
use std::path::Path;
use std::pin::Pin;

/// A future in a box.
pub type Boxed<'a, T> = Pin<Box<dyn Future<Output = T> + Send + 'a>>;

/// A file that was found.
#[derive(Clone, Debug)]
pub struct Found {
    /// Its name, where it differs from the requested one.
    pub name: Option<String>,
    /// Content.
    pub bytes: Bytes,
}

/// Source of the files of one model.
pub trait Files: Send + Sync {
    /// The file of a name, a path relative to the model, with at most `limit` bytes. `alike`: one whose name differs in the case
    /// of letters, or in what is not UTF-8 in it.
    fn read<'a>(&'a self, name: &'a str, limit: u64, alike: bool) -> Boxed<'a, Result<Found, Missing>>;
}

/// A file that a model refers to.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Needed {
    /// As the model writes it.
    pub name: String,
    /// It was looked for by another spelling.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub alike: bool,
    /// BLAKE3 of its content; none if it could not be read.
    pub hash: Option<String>,
}

impl Needed {
    pub(crate) fn found(name: &str, alike: bool, bytes: &[u8]) -> Self {
        Self { name: name.to_owned(), alike, hash: Some(blake3::hash(bytes).to_hex().to_string()) }
    }

    pub(crate) fn missing(name: &str, alike: bool) -> Self {
        Self { name: name.to_owned(), alike, hash: None }
    }
}

/// None: for models that come alone.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoFiles;

impl Files for NoFiles {
    fn read<'a>(&'a self, _: &'a str, _: u64, _: bool) -> Boxed<'a, Result<Found, Missing>> {
        Box::pin(async { Err(Missing::NotAllowed) })
    }
}

/// Files that came with the model.
#[derive(Clone, Debug, Default)]
pub struct MemoryFiles {
    /// By their names.
    pub files: BTreeMap<String, Bytes>,
}

impl MemoryFiles {
    /// A file whose name differs in the case of letters; or the only one of its name in whatever folder, as what sends files
    /// often leaves out where they lay.
    fn alike(&self, wanted: &str) -> Option<(&String, &Bytes)> {
        let base = |name: &str| name.rsplit('/').next().unwrap_or(name).to_ascii_lowercase();
        let found = self.files.iter().find(|(other, _)| other.eq_ignore_ascii_case(wanted));
        found.or_else(|| {
            let mut named = self.files.iter().filter(|(other, _)| base(other) == base(wanted));
            named.next().filter(|_| named.next().is_none())
        })
    }
}

impl Files for MemoryFiles {
    fn read<'a>(&'a self, name: &'a str, limit: u64, alike: bool) -> Boxed<'a, Result<Found, Missing>> {
        Box::pin(async move {
            let wanted = name.replace('\\', "/");
            let wanted = wanted.trim_start_matches("./");
            let file = match self.files.get_key_value(wanted) {
                Some(file) => Some(file),
                None if alike => self.alike(wanted),
                None => None,
            };
            let (found, bytes) = file.ok_or_else(no_such_file)?;
            if bytes.len() as u64 > limit {
                return Err(Missing::TooLarge);
            }
            Ok(Found { name: (found != name).then(|| found.clone()), bytes: bytes.clone() })
        })
    }
}

/// The answer where a file is not there.
#[must_use]
pub fn no_such_file() -> Missing {
    Missing::Unreadable { reason: "no such file".to_owned() }
}

/// Files beside a model in a folder: those that the library itself would read.
#[derive(Clone, Debug)]
pub struct FolderFiles(DirectoryResolver);

impl FolderFiles {
    /// Files in and below the folder of a model.
    #[must_use]
    pub fn of_model(model: &Path) -> Self {
        Self(DirectoryResolver::of_model(model))
    }
}

impl Files for FolderFiles {
    fn read<'a>(&'a self, name: &'a str, limit: u64, alike: bool) -> Boxed<'a, Result<Found, Missing>> {
        let (resolver, name) = (self.0.clone(), name.to_owned());
        Box::pin(async move {
            let read = move || match alike {
                false => resolver.read(&name, limit).map(|bytes| (None, bytes)),
                true => match resolver.read_alike(&name, limit) {
                    Some((found, bytes)) => bytes.map(|bytes| (Some(found), bytes)),
                    None => Err(ResolveError::Unreadable { name, reason: "no such file".to_owned() }),
                },
            };
            let read = tokio::task::spawn_blocking(read).await;
            let (name, bytes) = read.map_err(|e| unreadable(&e))?.map_err(missing)?;
            Ok(Found { name, bytes: bytes.into() })
        })
    }
}

fn unreadable(error: &impl ToString) -> Missing {
    Missing::Unreadable { reason: error.to_string() }
}

fn missing(error: ResolveError) -> Missing {
    match error {
        ResolveError::NotAllowed(_) => Missing::NotAllowed,
        ResolveError::Outside(_) => Missing::Outside,
        ResolveError::TooLarge { .. } => Missing::TooLarge,
        ResolveError::Unreadable { reason, .. } => Missing::Unreadable { reason },
        other => unreadable(&other),
    }
}
