//! The only way from a model to another file.
use std::collections::BTreeMap;
use std::fs::File;
use std::io::Read;
use std::path::{Component, Path, PathBuf};

/// Why a reference does not resolve.
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
        /// What the system says.
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
}

/// Resolves to the files of one folder and its subfolders. Absolute paths, `..` beyond the folder and symbolic links
/// that lead out of it are refused.
#[derive(Clone, Debug)]
pub struct DirectoryResolver {
    root: PathBuf,
}

impl DirectoryResolver {
    /// For the files in and below `root`.
    #[must_use]
    pub fn new(root: impl Into<PathBuf>) -> Self {
        Self { root: root.into() }
    }
}

impl Resolver for DirectoryResolver {
    fn read(&self, name: &str, limit: u64) -> Result<Vec<u8>, ResolveError> {
        let outside = || ResolveError::Outside(name.to_owned());
        let unreadable =
            |e: std::io::Error| ResolveError::Unreadable { name: name.to_owned(), reason: e.to_string() };
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
        let root = root.canonicalize().map_err(unreadable)?;
        // Symbolic links are followed here, and judged by where they end.
        let path = root.join(relative).canonicalize().map_err(unreadable)?;
        if !path.starts_with(&root) {
            return Err(outside());
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
}
