//! Actual pictures become expected ones.

use super::GoldenError;
use super::check::compare;
#[cfg(feature = "compress")]
use super::compress::{Effort, compress_png};
use super::thresholds::Thresholds;
use super::walk::Pair;
use overcoat_core::files::read_file;
use overcoat_core::limits::Limits;
use overcoat_image::decode::DecodedPicture;
use overcoat_image::output::{OutputError, write_atomically};
use std::path::{Path, PathBuf};

/// Outcome of accepting a picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Accepted {
    /// The file that is stored already is the one that would be written.
    Unchanged,
    /// The expected file is written.
    Written {
        /// The file.
        path: PathBuf,
        /// Its new content.
        bytes: Vec<u8>,
        /// Bytes of the file before, if there was one.
        before: Option<usize>,
    },
}

/// Finds out what is to be stored for a pair, without storing it. With `only_bad`, pictures that pass stay as they are
/// unless they are stored larger than they must be.
///
/// # Errors
/// [`GoldenError`] if there is no actual picture that can be read.
pub fn prepare(
    pair: &Pair,
    expected_folder: &Path,
    thresholds: &Thresholds,
    only_bad: bool,
    limits: &Limits,
) -> Result<Accepted, GoldenError> {
    if let Some(problem) = &pair.problem {
        return Err(GoldenError::NotFollowed(problem.clone()));
    }
    let Some(actual) = &pair.actual else {
        // An expected picture that nobody makes any more: not for this command to judge.
        return if only_bad { Ok(Accepted::Unchanged) } else { Err(GoldenError::NoActual) };
    };
    if only_bad && pair.expected.is_some() && compare(pair, thresholds, true, limits).result.verdict.is_good()
    {
        return Ok(Accepted::Unchanged);
    }
    let bytes = read_file(actual, limits)?;
    let small = if pair.unread { bytes } else { checked(bytes, limits)? };
    let path = pair.expected.clone().unwrap_or_else(|| expected_folder.join(&pair.relative));
    let stored = pair.expected.as_deref().and_then(|path| read_file(path, limits).ok());
    if stored.as_ref() == Some(&small) {
        return Ok(Accepted::Unchanged);
    }
    Ok(Accepted::Written { path, bytes: small, before: stored.map(|stored| stored.len()) })
}

/// A file that holds the same picture, in fewer bytes if that is possible.
fn checked(bytes: Vec<u8>, limits: &Limits) -> Result<Vec<u8>, GoldenError> {
    let picture = DecodedPicture::from_bytes(&bytes, limits)?;
    let small = compressed(bytes, limits)?;
    // Codes are no NaN, so that equality of numbers is equality of bits.
    if !picture.kind.is_linear() && DecodedPicture::from_bytes(&small, limits)? != picture {
        return Err(GoldenError::CompressionChanged);
    }
    Ok(small)
}

/// A still PNG file as small as it gets; other files as they are.
#[cfg(feature = "compress")]
fn compressed(bytes: Vec<u8>, limits: &Limits) -> Result<Vec<u8>, GoldenError> {
    if !bytes.starts_with(b"\x89PNG") {
        return Ok(bytes);
    }
    match compress_png(&bytes, Effort::Strongest, limits) {
        Err(GoldenError::Animated) => Ok(bytes),
        done => done,
    }
}

/// Files as they are.
#[cfg(not(feature = "compress"))]
fn compressed(bytes: Vec<u8>, _: &Limits) -> Result<Vec<u8>, GoldenError> {
    Ok(bytes)
}

/// Writes what [`prepare`] found, and removes an actual `x.new.png` that has become `x.png`.
///
/// # Errors
/// [`GoldenError::Write`].
pub fn store(accepted: &Accepted, pair: &Pair) -> Result<(), GoldenError> {
    if let Accepted::Written { path, bytes, .. } = accepted {
        if let Some(folder) = path.parent() {
            std::fs::create_dir_all(folder)
                .map_err(|source| OutputError::Write { path: folder.to_owned(), source })?;
        }
        write_atomically(path, bytes)?;
    }
    if pair.is_new
        && let Some(actual) = &pair.actual
    {
        // It has been accepted; that it still lies there is untidy and no failure.
        let _ = std::fs::remove_file(actual);
    }
    Ok(())
}
