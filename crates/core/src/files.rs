//! Regular files and streams, read within limits.

use crate::limits::{LimitExceeded, Limits};
use std::fs::{File, Metadata};
use std::io::{Error, ErrorKind, Read, Seek};
use std::path::Path;

/// Reason why a file or a stream was not read.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// Error of the operating system.
    #[error("cannot be read: {0}")]
    Io(#[from] Error),
    /// It is longer than [`Limits::input_bytes`].
    #[error(transparent)]
    Limit(#[from] LimitExceeded),
}

/// The content of a regular file, of at most `limits.input_bytes` bytes.
///
/// # Errors
/// [`ReadError::Io`] if it is missing, a folder, a device or cannot be read; [`ReadError::Limit`] if it is too long.
pub fn read_file(path: &Path, limits: &Limits) -> Result<Vec<u8>, ReadError> {
    // Asked before opening, which would wait for a writer if it were a pipe.
    let metadata = std::fs::metadata(path)?;
    read_opened(open_regular(path, &metadata, limits)?, limits)
}

/// A regular file of at most `limits.input_bytes` bytes.
///
/// # Errors
/// As [`read_file`].
pub fn open_regular(path: &Path, metadata: &Metadata, limits: &Limits) -> Result<File, ReadError> {
    if metadata.is_dir() {
        return Err(Error::new(ErrorKind::IsADirectory, "it is a folder").into());
    }
    if !metadata.is_file() {
        return Err(Error::new(ErrorKind::InvalidInput, "it is not a regular file").into());
    }
    check_size(metadata.len(), limits)?;
    Ok(File::open(path)?)
}

/// All that is in a file, from its first byte.
///
/// # Errors
/// As [`read_file`].
pub fn read_opened(mut file: File, limits: &Limits) -> Result<Vec<u8>, ReadError> {
    let size = file.metadata()?.len().min(limits.input_bytes);
    file.rewind()?;
    let mut bytes = Vec::new();
    bytes
        .try_reserve_exact(usize::try_from(size).unwrap_or(usize::MAX).saturating_add(1))
        .map_err(|_| Error::from(ErrorKind::OutOfMemory))?;
    read_up_to(file, limits, bytes)
}

/// All that comes, at most `limits.input_bytes` bytes of it.
///
/// # Errors
/// [`ReadError::Io`] if reading fails, [`ReadError::Limit`] if there is more.
pub fn read_stream(from: impl Read, limits: &Limits) -> Result<Vec<u8>, ReadError> {
    read_up_to(from, limits, Vec::new())
}

fn read_up_to(from: impl Read, limits: &Limits, mut bytes: Vec<u8>) -> Result<Vec<u8>, ReadError> {
    // It may grow while it is read.
    from.take(limits.input_bytes.saturating_add(1)).read_to_end(&mut bytes)?;
    check_size(bytes.len() as u64, limits)?;
    Ok(bytes)
}

/// Checks the size of a file against the limits.
///
/// # Errors
/// [`LimitExceeded`] naming the file.
pub fn check_size(bytes: u64, limits: &Limits) -> Result<(), LimitExceeded> {
    Limits::check(|| "bytes of the file".to_owned(), bytes, limits.input_bytes, "input_bytes")
}
