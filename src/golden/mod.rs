//! Golden pictures: what a renderer drew once, was looked at, and must draw again. For any project: nothing here knows
//! how pictures are made.
//!
//! * [`Golden`] is one line in a test: a folder of pictures, compared by name.
//! * The command `overcoat golden` compares folders ([`walk`], [`check`]), writes a page that shows where pictures differ
//!   ([`report`]) and takes new ones ([`accept`]). It compares by [`metrics`], from equality to FLIP, against
//!   [`thresholds`] by file name.
//! * [`GoldenFolder`] holds goldens that describe themselves, as this crate's own do: `<name>.toml` says what is drawn
//!   and, in one sentence, what would be wrong if it changed, and holds the hash of the linear frame; `<name>.png` shows it.
//!
//! Accepting never passes the same run: [`Golden`] with `UPDATE_GOLDENS=1` and [`DescribedGolden::accept`] record the
//! present picture and give an error all the same. Whoever accepts a golden has looked at it, and runs the tests again.
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
mod assertion;
pub mod check;
mod compare;
pub mod compress;
pub mod decode;
mod folder;
pub mod junit;
pub mod metrics;
pub mod motion;
mod picture;
pub mod report;
pub mod thresholds;
pub mod walk;

pub use assertion::Golden;
pub use compare::{Comparison, PixelDifference};
pub use folder::{DescribedGolden, GoldenFolder};
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
    /// A picture is not as expected.
    #[error("{summary}{}\n    actual:   {}\nlook at them with `overcoat golden report`; record with UPDATE_GOLDENS=1 or `overcoat golden accept`",
        match expected { Some(path) => format!("\n    expected: {}", path.display()), None => String::new() }, actual.display())]
    Differs {
        /// The name of the picture, and in what it differs.
        summary: String,
        /// The expected picture, if there is one.
        expected: Option<PathBuf>,
        /// The actual picture, which was written for looking at.
        actual: PathBuf,
    },
    /// A picture was recorded, or would have been if it had changed. Not a success: look at it, then run again.
    #[error("{} {}, then run the tests again without UPDATE_GOLDENS", path.display(),
        if *changed { "was recorded: look at it" } else { "is as it was recorded" })]
    Recorded {
        /// The expected picture.
        path: PathBuf,
        /// True if it was written, false if it was the same before.
        changed: bool,
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
