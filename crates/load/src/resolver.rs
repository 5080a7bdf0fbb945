//! The only way from a model to another file.
use super::names::are_alike;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::Read;
use std::path::{Component, Path, PathBuf};

/// Reason why a reference does not resolve.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ResolveError {
    /// The model was loaded from bytes alone.
    #[error("'{0}' cannot be read: this model may not refer to other files")]
    NotAllowed(String),
    /// It points out of the model's folder.
    #[error("'{0}' leads out of the model's folder")]
    Outside(String),
    /// It does not exist or cannot be read.
    #[error("'{name}' cannot be read: {reason}")]
    Unreadable {
        /// The reference as written.
        name: String,
        /// Message of the operating system.
        reason: String,
    },
    /// It is larger than allowed.
    #[error("'{name}' has more than {limit} bytes (input_bytes)")]
    TooLarge {
        /// The reference as written.
        name: String,
        /// The limit in bytes.
        limit: u64,
    },
}

/// Reads what a model refers to by a relative path.
pub trait Resolver: Sync {
    /// The bytes behind `name`, a path relative to the model with `/` or `\` between its parts, already
    /// percent-decoded; at most `limit` bytes.
    ///
    /// # Errors
    /// [`ResolveError`], naming the reference.
    fn read(&self, name: &str, limit: u64) -> Result<Vec<u8>, ResolveError>;

    /// The bytes behind a name that differs from `name` only in the case of letters, or in what is not UTF-8 in it, and that
    /// name as it can be shown. `None` if there is none, or more files than can be looked through.
    fn read_alike(&self, _name: &str, _limit: u64) -> Option<(String, Result<Vec<u8>, ResolveError>)> {
        None
    }

    /// The name of the model's own file, where it has one.
    fn model_name(&self) -> Option<&str> {
        None
    }
}

/// Resolves nothing: for models that come as bytes.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoResolver;

impl Resolver for NoResolver {
    fn read(&self, name: &str, _limit: u64) -> Result<Vec<u8>, ResolveError> {
        Err(ResolveError::NotAllowed(name.to_owned()))
    }
}

/// Resolves to byte strings by their exact name.
#[derive(Clone, Debug, Default)]
pub struct MemoryResolver {
    /// The files by name.
    pub files: BTreeMap<String, Vec<u8>>,
}

impl Resolver for MemoryResolver {
    fn read(&self, name: &str, limit: u64) -> Result<Vec<u8>, ResolveError> {
        let bytes = self.files.get(name).ok_or_else(|| ResolveError::Unreadable {
            name: name.to_owned(),
            reason: "no such file".to_owned(),
        })?;
        if bytes.len() as u64 > limit {
            return Err(ResolveError::TooLarge { name: name.to_owned(), limit });
        }
        Ok(bytes.clone())
    }

    fn read_alike(&self, name: &str, limit: u64) -> Option<(String, Result<Vec<u8>, ResolveError>)> {
        let found = self.files.keys().find(|file| are_alike(file, name))?;
        Some((found.clone(), self.read(found, limit)))
    }
}

/// Most names of a folder that are looked through.
const MOST_NAMES: usize = 1 << 14;

/// Resolves to the files of one folder and its subfolders. Absolute paths, `..` beyond the folder and symbolic links
/// that lead out of it are refused.
#[derive(Clone, Debug)]
pub struct DirectoryResolver {
    root: PathBuf,
    model: Option<String>,
}

impl DirectoryResolver {
    /// For the files in and below `root`.
    #[must_use]
    pub fn new(root: impl Into<PathBuf>) -> Self {
        Self { root: root.into(), model: None }
    }

    /// For the files in and below the folder of a model.
    #[must_use]
    pub fn of_model(path: &Path) -> Self {
        let model = path.file_name().map(|name| name.to_string_lossy().into_owned());
        Self { root: path.parent().unwrap_or(Path::new("")).into(), model }
    }

    /// The folder, and the path in it that a name stands for.
    fn place(&self, name: &str) -> Result<(PathBuf, PathBuf), ResolveError> {
        let outside = || ResolveError::Outside(name.to_owned());
        // Windows tools write backslashes; a drive letter or a scheme is never relative.
        let portable = name.replace('\\', "/");
        if portable.contains(':') || portable.contains('\0') {
            return Err(outside());
        }
        let mut relative = PathBuf::new();
        for part in Path::new(&portable).components() {
            match part {
                Component::Normal(p) => relative.push(p),
                Component::CurDir => {}
                Component::ParentDir => {
                    if !relative.pop() {
                        return Err(outside());
                    }
                }
                Component::RootDir | Component::Prefix(_) => return Err(outside()),
            }
        }
        let root = if self.root.as_os_str().is_empty() { Path::new(".") } else { &self.root };
        let root = root.canonicalize().map_err(|e| unreadable(name, &e))?;
        Ok((root, relative))
    }
}

fn unreadable(name: &str, error: &std::io::Error) -> ResolveError {
    ResolveError::Unreadable { name: name.to_owned(), reason: error.to_string() }
}

/// Reads a file that lies in the folder `root`, by whatever path.
fn read_within(root: &Path, relative: &Path, name: &str, limit: u64) -> Result<Vec<u8>, ResolveError> {
    let unreadable = |e: std::io::Error| unreadable(name, &e);
    // Symbolic links are followed here, and judged by where they end.
    let path = root.join(relative).canonicalize().map_err(unreadable)?;
    if !path.starts_with(root) {
        return Err(ResolveError::Outside(name.to_owned()));
    }
    let metadata = path.metadata().map_err(unreadable)?;
    if !metadata.is_file() {
        return Err(ResolveError::Unreadable {
            name: name.to_owned(),
            reason: "not a regular file".to_owned(),
        });
    }
    if metadata.len() > limit {
        return Err(ResolveError::TooLarge { name: name.to_owned(), limit });
    }
    // A vector that grows by itself takes up to twice what it holds.
    let size = usize::try_from(metadata.len()).unwrap_or(0);
    let mut bytes = Vec::with_capacity(size.saturating_add(1));
    File::open(&path)
        .and_then(|file| file.take(limit.saturating_add(1)).read_to_end(&mut bytes))
        .map_err(unreadable)?;
    if bytes.len() as u64 > limit {
        return Err(ResolveError::TooLarge { name: name.to_owned(), limit });
    }
    Ok(bytes)
}

impl Resolver for DirectoryResolver {
    fn read(&self, name: &str, limit: u64) -> Result<Vec<u8>, ResolveError> {
        let (root, relative) = self.place(name)?;
        read_within(&root, &relative, name, limit)
    }

    fn read_alike(&self, name: &str, limit: u64) -> Option<(String, Result<Vec<u8>, ResolveError>)> {
        let (root, wanted) = self.place(name).ok()?;
        let mut relative = PathBuf::new();
        for part in wanted.components() {
            // Folders that lead out of the root are not listed either.
            let folder =
                root.join(&relative).canonicalize().ok().filter(|folder| folder.starts_with(&root))?;
            let part = part.as_os_str();
            if folder.join(part).exists() {
                relative.push(part);
                continue;
            }
            let part = part.to_string_lossy();
            let mut best = None;
            for (count, entry) in std::fs::read_dir(folder).ok()?.enumerate() {
                if count >= MOST_NAMES {
                    return None;
                }
                let found = entry.ok()?.file_name();
                // Folders are listed in no order.
                if are_alike(&found.to_string_lossy(), &part)
                    && best.as_ref().is_none_or(|best| found < *best)
                {
                    best = Some(found);
                }
            }
            relative.push(best?);
        }
        let shown = relative.to_string_lossy().replace('\\', "/");
        let bytes = read_within(&root, &relative, &shown, limit);
        Some((shown, bytes))
    }

    fn model_name(&self) -> Option<&str> {
        self.model.as_deref()
    }
}
