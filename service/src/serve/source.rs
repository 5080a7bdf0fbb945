//! Sources of the models of paths: a folder, object stores, HTTP; those alone that the service allows.

use super::address::Network;
use super::allowed::Allowed;
use super::error::{Kind, Problem};
use super::fetch::Fetcher;
use crate::files::{Boxed, Files, FolderFiles, Found};
use crate::place::{Place, PlaceFiles};
use bytes::Bytes;
use overcoat_worker::protocol::Missing;
use std::path::{Component, Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
use url::Url;

/// Files of one model that are asked for over HTTP: no model makes this service ask another one without end.
const MOST_FILES: u64 = 256;

/// The sources that a service allows.
#[derive(Debug)]
pub struct Sources {
    local: Option<PathBuf>,
    allowed: Vec<Allowed>,
    fetcher: Fetcher,
    /// Bytes of a model with all its files.
    limit: u64,
}

/// A model, and where its files come from.
pub struct Source {
    /// The name of its file.
    pub name: String,
    /// Content of the file.
    pub model: Bytes,
    /// The files beside it.
    pub files: Arc<dyn Files>,
}

impl Sources {
    /// Sources from the options.
    ///
    /// # Errors
    /// One line.
    pub fn new(
        local: Option<&Path>,
        allowed: &[String],
        networks: &[String],
        limit: u64,
    ) -> Result<Self, String> {
        let networks =
            networks.iter().map(|text| Network::new(text).map_err(|e| format!("--allow-network {e}")));
        let fetcher = Fetcher::new(networks.collect::<Result<_, _>>()?);
        let allowed =
            allowed.iter().map(|text| Allowed::new("--allow-source", text)).collect::<Result<_, _>>()?;
        let local = match local {
            Some(path) => Some(path.canonicalize().map_err(|e| format!("--local {}: {e}", path.display()))?),
            None => None,
        };
        Ok(Self { local, allowed, fetcher, limit })
    }

    /// Reads a model.
    ///
    /// # Errors
    /// [`Problem`].
    pub async fn open(self: &Arc<Self>, source: &str) -> Result<Source, Problem> {
        if let Some(path) = source.strip_prefix("local://") {
            return self.open_local(path).await;
        }
        let url = Url::parse(source)
            .map_err(|e| Problem::new(Kind::Options, format!("the source is no URL: {e}")))?;
        let name = file_name(url.path());
        let left = Arc::new(AtomicU64::new(self.limit));
        if matches!(url.scheme(), "http" | "https") {
            let model = self.fetch(&url, &left, self.limit).await?;
            let files =
                Arc::new(HttpFiles { sources: Arc::clone(self), model: url, left, count: AtomicU64::new(0) });
            return Ok(Source { name, model, files });
        }
        let (place, below) = self.place(&url)?;
        let model = place.read(&below, self.limit).await.map_err(|missing| self.problem(missing))?;
        take(&left, model.len() as u64)?;
        let files = Counted { files: Box::new(PlaceFiles::of_model(place, &below)), left };
        Ok(Source { name, model, files: Arc::new(files) })
    }

    async fn open_local(&self, path: &str) -> Result<Source, Problem> {
        let refused =
            || Problem::new(Kind::Source, "local sources are not allowed here; --local DIR allows them");
        let root = self.local.as_ref().ok_or_else(refused)?;
        let path = Path::new(path.trim_start_matches('/'));
        let outside = || Problem::new(Kind::Source, "the source lies outside of the folder of local sources");
        if !path.components().all(|part| matches!(part, Component::Normal(_) | Component::CurDir)) {
            return Err(outside());
        }
        let not_there = |_| Problem::new(Kind::NotFound, "the source is not there");
        // Links that lead out of the folder are followed by nobody.
        let path = tokio::fs::canonicalize(root.join(path)).await.map_err(not_there)?;
        if !path.starts_with(root) {
            return Err(outside());
        }
        // A name as it is: the path of the request was decoded, and a percent sign that is left belongs to the file.
        let file = path.file_name().unwrap_or_default().to_string_lossy();
        let name = plain(&file);
        let folder = Place::Folder(path.parent().unwrap_or(root).to_owned());
        let model = folder.read(&file, self.limit).await.map_err(|missing| self.problem(missing))?;
        let left = Arc::new(AtomicU64::new(self.limit));
        take(&left, model.len() as u64)?;
        let files = Counted { files: Box::new(FolderFiles::of_model(&path)), left };
        Ok(Source { name, model, files: Arc::new(files) })
    }

    /// The place of an object, and its name there.
    fn place(&self, url: &Url) -> Result<(&Place, String), Problem> {
        let found =
            self.allowed.iter().find_map(|allowed| Some((allowed.place.as_ref()?, allowed.below(url)?)));
        let (place, below) = found.ok_or_else(refused)?;
        let below = percent_encoding::percent_decode_str(&below).decode_utf8();
        let below = below.map_err(|_| Problem::new(Kind::Options, "the source is not UTF-8"))?;
        Ok((place, below.into_owned()))
    }

    fn allows(&self, url: &Url) -> Result<(), Problem> {
        let is_http = matches!(url.scheme(), "http" | "https");
        let allowed = is_http && self.allowed.iter().any(|allowed| allowed.below(url).is_some());
        allowed.then_some(()).ok_or_else(refused)
    }

    async fn fetch(&self, url: &Url, left: &AtomicU64, limit: u64) -> Result<Bytes, Problem> {
        let limit = limit.min(left.load(Relaxed));
        let bytes = self.fetcher.get(url, limit, |url| self.allows(url)).await?;
        take(left, bytes.len() as u64)?;
        Ok(bytes)
    }

    fn problem(&self, missing: Missing) -> Problem {
        match missing {
            Missing::TooLarge => super::body::too_large(self.limit, "source"),
            Missing::Outside | Missing::NotAllowed => refused(),
            Missing::Unreadable { reason } if reason.contains("o such file") => {
                Problem::new(Kind::NotFound, "the source is not there")
            }
            Missing::Unreadable { reason } => {
                Problem::new(Kind::SourceFailed, format!("the source: {reason}"))
            }
        }
    }
}

fn refused() -> Problem {
    Problem::new(Kind::Source, "the source is not allowed here; --allow-source URL allows it")
}

/// Takes bytes from what a model with its files may have.
fn take(left: &AtomicU64, bytes: u64) -> Result<(), Problem> {
    let taken = left.fetch_update(Relaxed, Relaxed, |left| left.checked_sub(bytes));
    taken.map(drop).map_err(|left| super::body::too_large(left, "source"))
}

fn file_name(path: &str) -> String {
    let name = path.rsplit('/').next().unwrap_or_default();
    plain(&percent_encoding::percent_decode_str(name).decode_utf8_lossy())
}

fn plain(name: &str) -> String {
    name.chars().filter(|c| !c.is_control() && *c != '/').collect()
}

/// Files of a place, bounded together.
struct Counted {
    files: Box<dyn Files>,
    left: Arc<AtomicU64>,
}

impl Files for Counted {
    fn read<'a>(&'a self, name: &'a str, limit: u64, alike: bool) -> Boxed<'a, Result<Found, Missing>> {
        Box::pin(async move {
            let found = self.files.read(name, limit.min(self.left.load(Relaxed)), alike).await?;
            take(&self.left, found.bytes.len() as u64).map_err(|_| Missing::TooLarge)?;
            Ok(found)
        })
    }
}

/// Files in and below the folder of a model that came over HTTP.
struct HttpFiles {
    sources: Arc<Sources>,
    model: Url,
    left: Arc<AtomicU64>,
    /// Files that were asked for.
    count: AtomicU64,
}

impl Files for HttpFiles {
    fn read<'a>(&'a self, name: &'a str, limit: u64, alike: bool) -> Boxed<'a, Result<Found, Missing>> {
        Box::pin(async move {
            if alike {
                return Err(crate::files::no_such_file());
            }
            let url = beside(&self.model, name).ok_or(Missing::Outside)?;
            if self.count.fetch_add(1, Relaxed) >= MOST_FILES {
                return Err(Missing::Unreadable {
                    reason: format!("a model has {MOST_FILES} files at most here"),
                });
            }
            let bytes = self.sources.fetch(&url, &self.left, limit).await;
            let bytes = bytes.map_err(|problem| match problem.kind {
                Kind::TooLarge => Missing::TooLarge,
                Kind::Source => Missing::NotAllowed,
                _ => Missing::Unreadable { reason: problem.message },
            })?;
            Ok(Found { name: None, bytes })
        })
    }
}

/// The URL of a file in or below the folder of a model.
fn beside(model: &Url, name: &str) -> Option<Url> {
    let name = name.replace('\\', "/");
    if name.starts_with('/') || name.contains([':', '?', '#', '\0']) {
        return None;
    }
    let folder = model.join(".").ok()?;
    let mut url = model.clone();
    url.set_query(None);
    {
        let mut parts = url.path_segments_mut().ok()?;
        parts.pop();
        for part in name.split('/').filter(|part| !matches!(*part, "" | ".")) {
            // Each part is encoded, so that none of them is a step.
            if part == ".." {
                return None;
            }
            parts.push(part);
        }
    }
    url.path().starts_with(folder.path()).then_some(url)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_stay_beside_their_model() {
        let model = Url::parse("https://a.org/m/x.gltf?v=1").unwrap();
        let of = |name| beside(&model, name).map(|url| url.to_string());
        assert_eq!(of("t/a b.png").unwrap(), "https://a.org/m/t/a%20b.png");
        assert_eq!(of("./x.bin").unwrap(), "https://a.org/m/x.bin");
        for outside in ["../x", "/x", "https://b.org/x", "t/../../x", "..\\x", "a?b", "//b.org/x"] {
            assert_eq!(of(outside), None, "{outside}");
        }
        assert_eq!(of("%2e%2e/x").unwrap(), "https://a.org/m/%252e%252e/x");
    }
}
