//! Golden pictures: what a renderer drew once, was looked at, and must draw again.
//!
//! A golden is two files beside each other: `<name>.toml` describes the picture, says in one sentence what would be
//! wrong if it changed, and holds the hash of the linear frame; `<name>.png` shows it. A test renders the
//! description and calls [`Golden::check`]. Where the hash or a pixel differs, the error names a picture
//! (expected, difference, actual) and a list of the pixels that differ, written for whoever has to find out why.
//!
//! [`Golden::accept`] records the present picture and **always returns an error**: whoever accepts a golden has
//! looked at it, and runs the tests again.
//!
//! Nothing here knows how pictures are made: a test of any renderer can use it.
//!
//! ```no_run
//! use overcoat::golden::{GoldenFolder, Picture};
//!
//! # fn render(_: &str) -> (String, Picture) { unimplemented!() }
//! let folder = GoldenFolder::open("golden".as_ref())?;
//! for golden in folder.goldens() {
//!     let (frame_hash, picture) = render(golden.description());
//!     if std::env::var_os("UPDATE_GOLDENS").is_some_and(|v| v == "1") {
//!         return Err(golden.accept(&frame_hash, &picture));
//!     }
//!     golden.check(&frame_hash, &picture, "target/golden-failures".as_ref())?;
//! }
//! # Ok::<(), overcoat::golden::GoldenError>(())
//! ```

pub mod accept;
pub mod check;
mod compare;
pub mod compress;
pub mod decode;
mod folder;
pub mod junit;
pub mod metrics;
mod picture;
pub mod report;
pub mod thresholds;
pub mod walk;

pub use compare::{Comparison, PixelDifference};
pub use folder::{Golden, GoldenFolder};
pub use picture::Picture;

use std::path::PathBuf;

/// Why a golden is not met.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum GoldenError {
    /// A file could not be read or written.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// A file is not what it should be.
    #[error("{}: {reason}", path.display())]
    Malformed {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        reason: String,
    },
    /// One of the two files is missing.
    #[error("{}: missing beside {}", missing.display(), present.display())]
    Unpaired {
        /// The file that is there.
        present: PathBuf,
        /// The file that is not.
        missing: PathBuf,
    },
    /// The picture is another one.
    #[error("{name} changed: {summary}. If it did, this would be wrong: {why}\n  see {} and {}", triptych.display(), report.display())]
    Mismatch {
        /// The golden.
        name: String,
        /// What its description says would be wrong.
        why: String,
        /// Hashes, number of pixels, largest difference.
        summary: String,
        /// Expected, difference and actual picture side by side.
        triptych: PathBuf,
        /// Every pixel that differs.
        report: PathBuf,
    },
    /// The picture was recorded. Not a success: look at it, then run again.
    #[error("{name} recorded as {hash}: look at {}, then run the tests again", picture.display())]
    Accepted {
        /// The golden.
        name: String,
        /// The new hash.
        hash: String,
        /// The new picture.
        picture: PathBuf,
    },
}
