//! Folders and object stores, read and written alike.

use crate::files::{Boxed, Files, Found, no_such_file};
use bytes::Bytes;
use futures_util::{StreamExt, TryStreamExt};
use object_store::path::Path as ObjectPath;
use object_store::{Attribute, Attributes, GetOptions, ObjectStore, ObjectStoreExt, PutOptions, PutPayload};
use overcoat::output::write_atomically;
use overcoat_worker::protocol::Missing;
use std::fmt;
use std::path::{Component, Path, PathBuf};
use std::sync::Arc;
use std::time::SystemTime;
use url::Url;

/// Place of models or pictures.
#[derive(Clone)]
pub enum Place {
    /// A folder of this machine.
    Folder(PathBuf),
    /// Objects under a prefix of an object store.
    Store(Arc<dyn ObjectStore>, ObjectPath, Url),
}

impl fmt::Debug for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Folder(path) => write!(f, "{}", path.display()),
            Self::Store(_, _, url) => write!(f, "{url}"),
        }
    }
}

/// A file below a place.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Listed {
    /// Path below the place.
    pub name: String,
    /// Time of its last change, where it is told.
    pub modified: Option<SystemTime>,
}

/// True if a text is meant as a URL and not as a path.
#[must_use]
pub fn is_url(text: &str) -> bool {
    let scheme = text.split_once("://").map(|(scheme, _)| scheme);
    scheme.is_some_and(|s| s.len() > 1 && s.bytes().all(|b| b.is_ascii_alphanumeric() || b"+-.".contains(&b)))
}

impl Place {
    /// A folder by its path, or a prefix by its URL. Credentials and end points come from the environment, by the names that the
    /// tools of each store have (`AWS_ACCESS_KEY_ID`, `AWS_ENDPOINT`, `GOOGLE_SERVICE_ACCOUNT`, `AZURE_STORAGE_ACCOUNT_NAME`, ...).
    ///
    /// # Errors
    /// One line.
    pub fn new(text: &str) -> Result<Self, String> {
        if !is_url(text) {
            return Ok(Self::Folder(PathBuf::from(text)));
        }
        let url = Url::parse(text).map_err(|e| format!("{text}: {e}"))?;
        if url.scheme() == "file" {
            let path = url.to_file_path().map_err(|()| format!("{text}: no path of this machine"))?;
            return Ok(Self::Folder(path));
        }
        let options = std::env::vars_os()
            .filter_map(|(name, value)| Some((name.into_string().ok()?, value.into_string().ok()?)))
            .map(|(name, value)| (name.to_ascii_lowercase(), value))
            // Whoever writes http:// means it.
            .chain((url.scheme() == "http").then(|| ("allow_http".to_owned(), "true".to_owned())));
        let (store, prefix) =
            object_store::parse_url_opts(&url, options).map_err(|e| format!("{text}: {}", reason_of(&e)))?;
        Ok(Self::Store(store.into(), prefix, url))
    }

    /// All files below it, in the order of their names.
    ///
    /// # Errors
    /// One line.
    pub async fn list(&self) -> Result<Vec<Listed>, String> {
        match self {
            Self::Folder(root) => {
                let root = root.clone();
                let listed = tokio::task::spawn_blocking(move || list_folder(&root)).await;
                listed.map_err(|e| e.to_string())?
            }
            Self::Store(store, prefix, url) => {
                let about = |e: object_store::Error| format!("{url}: {}", reason_of(&e));
                let metas: Vec<_> = store.list(Some(prefix)).try_collect().await.map_err(about)?;
                let below = |location: &ObjectPath| {
                    let parts = location.prefix_match(prefix)?;
                    Some(parts.map(|part| part.as_ref().to_owned()).collect::<Vec<_>>().join("/"))
                };
                let listed = |meta: &object_store::ObjectMeta| {
                    let name = below(&meta.location)?;
                    Some(Listed { name, modified: Some(meta.last_modified.into()) })
                };
                let mut files: Vec<Listed> = metas.iter().filter_map(listed).collect();
                files.sort_by(|a, b| a.name.cmp(&b.name));
                Ok(files)
            }
        }
    }

    /// A file below it, of at most `limit` bytes.
    ///
    /// # Errors
    /// [`Missing`].
    pub async fn read(&self, name: &str, limit: u64) -> Result<Bytes, Missing> {
        match self {
            Self::Folder(root) => {
                let path = root.join(name);
                let read = tokio::task::spawn_blocking(move || read_file(&path, limit)).await;
                read.map_err(|e| unreadable(&e))?.map(Bytes::from)
            }
            Self::Store(store, prefix, _) => {
                let location = object_at(prefix, name).ok_or(Missing::Outside)?;
                read_object(store.as_ref(), &location, limit).await
            }
        }
    }

    /// Bytes of a file below it; `None` if it is not there.
    pub async fn size(&self, name: &str) -> Option<u64> {
        match self {
            Self::Folder(root) => {
                let metadata = tokio::fs::metadata(root.join(name)).await.ok()?;
                metadata.is_file().then_some(metadata.len())
            }
            Self::Store(store, prefix, _) => {
                store.head(&object_at(prefix, name)?).await.ok().map(|meta| meta.size)
            }
        }
    }

    /// Time of the last change of a file below it, where it is told.
    pub async fn modified(&self, name: &str) -> Option<SystemTime> {
        match self {
            Self::Folder(root) => tokio::fs::metadata(root.join(name)).await.ok()?.modified().ok(),
            Self::Store(store, prefix, _) => {
                Some(store.head(&object_at(prefix, name)?).await.ok()?.last_modified.into())
            }
        }
    }

    /// Writes a file below it, whole or not at all.
    ///
    /// # Errors
    /// One line.
    pub async fn write(&self, name: &str, bytes: Bytes, media_type: &str) -> Result<(), String> {
        match self {
            Self::Folder(root) => {
                let path = root.join(name);
                let write = move || {
                    if let Some(folder) = path.parent() {
                        let about = |e: std::io::Error| format!("{}: {e}", folder.display());
                        std::fs::create_dir_all(folder).map_err(about)?;
                    }
                    write_atomically(&path, &bytes).map_err(|e| e.to_string())
                };
                tokio::task::spawn_blocking(write).await.map_err(|e| e.to_string())?
            }
            Self::Store(store, prefix, url) => {
                let location = object_at(prefix, name).ok_or_else(|| format!("{url}: no name: {name}"))?;
                let mut attributes = Attributes::new();
                attributes.insert(Attribute::ContentType, media_type.to_owned().into());
                let options = PutOptions { attributes, ..PutOptions::default() };
                let put = store.put_opts(&location, PutPayload::from(bytes), options).await;
                put.map(drop).map_err(|e| format!("{location}: {}", reason_of(&e)))
            }
        }
    }
}

/// An object below a prefix; `None` of a name that leads out of it.
fn object_at(prefix: &ObjectPath, name: &str) -> Option<ObjectPath> {
    let mut location = prefix.clone();
    let mut depth = 0_u32;
    for part in name.split('/') {
        match part {
            "" | "." => {}
            ".." => {
                depth = depth.checked_sub(1)?;
                let mut parts: Vec<_> = location.parts().collect();
                parts.pop();
                location = ObjectPath::from_iter(parts);
            }
            part => {
                depth += 1;
                location = location.join(part);
            }
        }
    }
    Some(location)
}

/// An object of at most `limit` bytes.
async fn read_object(store: &dyn ObjectStore, location: &ObjectPath, limit: u64) -> Result<Bytes, Missing> {
    let got = store.get_opts(location, GetOptions::default()).await;
    let got = got.map_err(|e| match e {
        object_store::Error::NotFound { .. } => no_such_file(),
        e => Missing::Unreadable { reason: reason_of(&e) },
    })?;
    if got.meta.size > limit {
        return Err(Missing::TooLarge);
    }
    // The announced size may be wrong.
    let mut bytes = Vec::new();
    let mut stream = got.into_stream();
    while let Some(part) = stream.next().await {
        let part = part.map_err(|e| Missing::Unreadable { reason: reason_of(&e) })?;
        if bytes.len() as u64 + part.len() as u64 > limit {
            return Err(Missing::TooLarge);
        }
        bytes.extend_from_slice(&part);
    }
    Ok(bytes.into())
}

/// Names of a folder's files, in order. Links to folders are not followed.
fn list_folder(root: &Path) -> Result<Vec<Listed>, String> {
    let mut files = Vec::new();
    let mut folders = vec![root.to_owned()];
    while let Some(folder) = folders.pop() {
        let about = |e: std::io::Error| format!("{}: {e}", folder.display());
        for entry in std::fs::read_dir(&folder).map_err(about)? {
            let entry = entry.map_err(about)?;
            let (path, kind) = (entry.path(), entry.file_type().map_err(about)?);
            if kind.is_dir() {
                folders.push(path);
            } else if let Ok(metadata) = path.metadata()
                && metadata.is_file()
                && let Ok(below) = path.strip_prefix(root)
            {
                let parts = below.components().filter_map(|part| match part {
                    Component::Normal(part) => part.to_str(),
                    _ => None,
                });
                let parts: Vec<&str> = parts.collect();
                // A name that is no text is met as one that does not exist.
                files.push(Listed { name: parts.join("/"), modified: metadata.modified().ok() });
            }
        }
    }
    files.sort_by(|a: &Listed, b| a.name.cmp(&b.name));
    Ok(files)
}

fn read_file(path: &Path, limit: u64) -> Result<Vec<u8>, Missing> {
    use std::io::Read;
    let file = std::fs::File::open(path).map_err(|e| unreadable(&e))?;
    let metadata = file.metadata().map_err(|e| unreadable(&e))?;
    if !metadata.is_file() {
        return Err(Missing::Unreadable { reason: "not a regular file".to_owned() });
    }
    if metadata.len() > limit {
        return Err(Missing::TooLarge);
    }
    let mut bytes = Vec::with_capacity(usize::try_from(metadata.len()).unwrap_or(0) + 1);
    file.take(limit.saturating_add(1)).read_to_end(&mut bytes).map_err(|e| unreadable(&e))?;
    if bytes.len() as u64 > limit { Err(Missing::TooLarge) } else { Ok(bytes) }
}

fn unreadable(error: &impl ToString) -> Missing {
    Missing::Unreadable { reason: error.to_string() }
}

/// One-line reason of an error, for a person.
pub(crate) fn reason_of(error: &dyn std::error::Error) -> String {
    // Why a client cannot be built is only told further down.
    let mut below = Some(error);
    while let Some(error) = below {
        if error.to_string().contains("No CA certificates") {
            return "this system has no root certificates: SSL_CERT_FILE names a file of them".to_owned();
        }
        below = error.source();
    }
    in_short(&error.to_string())
}

/// Stores tell whole pages, with the request and its duration in front.
fn in_short(text: &str) -> String {
    if text.contains("NoSuchBucket") || text.contains("ContainerNotFound") {
        return "there is no such bucket".to_owned();
    }
    let line = text.lines().next().unwrap_or_default();
    let what = line.rsplit_once(" - ").map_or(line, |(_, what)| what);
    let what = what.split_once(": <").map_or(what, |(what, _)| what);
    what.trim_end_matches([':', ' ']).chars().take(300).collect()
}

/// Files beside a model in a place.
#[derive(Clone, Debug)]
pub struct PlaceFiles {
    place: Place,
    /// Folder of the model, with a slash at its end, or empty.
    folder: String,
}

impl PlaceFiles {
    /// Files in and below the folder of a model.
    #[must_use]
    pub fn of_model(place: &Place, model: &str) -> Self {
        let folder = model.rsplit_once('/').map_or(String::new(), |(folder, _)| format!("{folder}/"));
        Self { place: place.clone(), folder }
    }
}

impl Files for PlaceFiles {
    fn read<'a>(&'a self, name: &'a str, limit: u64, alike: bool) -> Boxed<'a, Result<Found, Missing>> {
        Box::pin(async move {
            // Stores are not searched for other spellings.
            if alike {
                return Err(no_such_file());
            }
            let name = name.replace('\\', "/");
            if name.starts_with('/') || name.contains(':') || name.contains('\0') || leads_out(&name) {
                return Err(Missing::Outside);
            }
            let bytes = self.place.read(&format!("{}{name}", self.folder), limit).await?;
            Ok(Found { name: None, bytes })
        })
    }
}

/// True if a relative path leads out of its base.
fn leads_out(name: &str) -> bool {
    let mut depth = 0_i64;
    name.split('/').any(|part| {
        depth += match part {
            "" | "." => 0,
            ".." => -1,
            _ => 1,
        };
        depth < 0
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn urls_are_told_from_paths() {
        for text in ["s3://a/b", "https://x", "file:///a", "az://c"] {
            assert!(is_url(text), "{text}");
        }
        for text in ["a/b", "c:/x", "c://x", "://x", "a b://c"] {
            assert!(!is_url(text), "{text}");
        }
    }

    #[test]
    fn errors_of_stores_are_told_in_short() {
        let text = "Generic S3 error: Error performing GET http://127.0.0.1:1/m?list-type=2 in 13.28ms - Server returned \
                    non-2xx status code: 403 Forbidden: <?xml version=\"1.0\"?>\n<Error>";
        assert_eq!(in_short(text), "Server returned non-2xx status code: 403 Forbidden");
        assert_eq!(in_short("x 404\n<Code>NoSuchBucket</Code>"), "there is no such bucket");
    }

    #[test]
    fn names_stay_below_their_prefix() {
        let prefix = ObjectPath::from("a/b");
        assert_eq!(object_at(&prefix, "c/../d/./e").unwrap().as_ref(), "a/b/d/e");
        assert_eq!(object_at(&prefix, "../e"), None);
        assert_eq!(object_at(&prefix, "c/../../e"), None);
        assert!(leads_out("../x") && leads_out("a/../../x") && !leads_out("a/../x"));
    }

    #[tokio::test]
    async fn folders_are_listed_read_and_written() {
        let folder = tempfile::tempdir().unwrap();
        let place = Place::new(folder.path().to_str().unwrap()).unwrap();
        place.write("b/c.png", Bytes::from_static(b"123"), "image/png").await.unwrap();
        place.write("a.png", Bytes::from_static(b"1"), "image/png").await.unwrap();
        let names: Vec<String> = place.list().await.unwrap().into_iter().map(|file| file.name).collect();
        assert_eq!(names, ["a.png", "b/c.png"]);
        assert_eq!(place.size("b/c.png").await, Some(3));
        assert_eq!(place.size("b").await, None);
        assert_eq!(&place.read("b/c.png", 3).await.unwrap()[..], b"123");
        assert_eq!(place.read("b/c.png", 2).await, Err(Missing::TooLarge));
        assert!(matches!(place.read("d", 2).await, Err(Missing::Unreadable { .. })));
        let files = PlaceFiles::of_model(&place, "b/model.gltf");
        assert_eq!(&files.read("c.png", 9, false).await.unwrap().bytes[..], b"123");
        assert_eq!(files.read("../a.png", 9, false).await.unwrap_err(), Missing::Outside);
    }
}
