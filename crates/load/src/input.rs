//! Files that a user names: regular ones, and pipes such as `<(zcat m.gz)` and `/dev/stdin`, which have no folder.

use super::packed::{self, Unpacked};
use super::{DirectoryResolver, LoadError, NoResolver, Resolver, Warning};
use overcoat_core::files::{open_regular, read_opened, read_stream};
use overcoat_core::limits::Limits;
use std::fs::{File, Metadata};
use std::path::Path;

/// A file that is open, or all that came through a pipe.
pub(super) enum Input {
    /// A regular file.
    File(File),
    /// The content of a pipe.
    Bytes(Vec<u8>),
}

impl Input {
    /// Opens a file. A pipe that is open already (`/dev/stdin`, `/dev/fd/63`) is read to its end. One that has a name of its own
    /// is refused: whoever put it there may never write to it.
    ///
    /// # Errors
    /// [`LoadError::Io`] if it is missing, a folder, a device or cannot be read; [`LoadError::Limit`] if it has more
    /// than [`Limits::input_bytes`].
    pub(super) fn open(path: &Path, limits: &Limits) -> Result<Self, LoadError> {
        let metadata = std::fs::metadata(path)?;
        if is_pipe(&metadata) && is_numbered(path) {
            return Ok(Self::Bytes(read_stream(File::open(path)?, limits)?));
        }
        Ok(Self::File(open_regular(path, &metadata, limits)?))
    }

    /// All of it.
    pub(super) fn read(self, limits: &Limits) -> Result<Vec<u8>, LoadError> {
        match self {
            Self::File(file) => Ok(read_opened(file, limits)?),
            Self::Bytes(bytes) => Ok(bytes),
        }
    }
}

/// Bytes from which on a file may be one that is not read as a whole.
const LARGE: u64 = 1 << 16;

/// A regular file of some size, whatever the limits say, to be read in parts.
///
/// # Errors
/// [`LoadError::Io`] if it cannot be opened.
pub(super) fn open_large(path: &Path) -> Result<Option<File>, LoadError> {
    let is_large = |metadata: &Metadata| metadata.is_file() && metadata.len() >= LARGE;
    let large = std::fs::metadata(path).is_ok_and(|metadata| is_large(&metadata));
    Ok(if large { Some(File::open(path)?) } else { None })
}

/// The content of a file that a user names, unpacked, and what was wrong with how it was packed.
///
/// # Errors
/// As opening, reading and unpacking it.
pub fn read_input(path: &Path, limits: &Limits) -> Result<(Vec<u8>, Option<Warning>), LoadError> {
    let bytes = Input::open(path, limits)?.read(limits)?;
    Ok(match packed::unpack(&bytes, limits)? {
        Some(Unpacked { bytes, warning }) => (bytes, warning),
        None => (bytes, None),
    })
}

/// The way to the files beside one that a user names: none beside a pipe or a file that is known by its number only.
pub fn resolver_beside(path: &Path) -> Box<dyn Resolver> {
    if has_folder(path) { Box::new(DirectoryResolver::of_model(path)) } else { Box::new(NoResolver) }
}

/// True unless a file is a pipe or an open file by its number.
pub fn has_folder(path: &Path) -> bool {
    !is_numbered(path) && !std::fs::metadata(path).is_ok_and(|metadata| is_pipe(&metadata))
}

/// True for a file that is open already, by its number.
fn is_numbered(path: &Path) -> bool {
    cfg!(unix) && ["/dev/fd", "/proc/self/fd", "/dev/stdin"].iter().any(|folder| path.starts_with(folder))
}

fn is_pipe(metadata: &Metadata) -> bool {
    #[cfg(unix)]
    return std::os::unix::fs::FileTypeExt::is_fifo(&metadata.file_type());
    #[cfg(not(unix))]
    {
        let _ = metadata;
        false
    }
}
