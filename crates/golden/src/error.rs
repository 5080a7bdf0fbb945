//! Errors: pictures that are not as expected, or cannot be compared, reported or accepted.

use overcoat_core::files::ReadError;
use overcoat_core::limits::LimitExceeded;
use overcoat_image::decode::DecodeError;
use overcoat_image::output::OutputError;
use std::path::PathBuf;

/// Error: a golden is not met, or cannot be compared or recorded.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum GoldenError {
    /// A file or folder could not be read or written.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// A file is not what it should be.
    #[error("{}: {reason}", path.display())]
    Malformed {
        /// The file.
        path: PathBuf,
        /// Reason, in a few words.
        reason: String,
    },
    /// One of the two files of a golden is missing.
    #[error("{}: missing beside {}", missing.display(), present.display())]
    Unpaired {
        /// The file that is there.
        present: PathBuf,
        /// The file that is not.
        missing: PathBuf,
    },
    /// One of two that are to be compared is a folder and the other a file.
    #[error("{} is a folder and {} is not", folder.display(), file.display())]
    Mixed {
        /// The folder.
        folder: PathBuf,
        /// The other.
        file: PathBuf,
    },
    /// There is more than the limits allow.
    #[error(transparent)]
    Limit(#[from] LimitExceeded),
    /// A picture cannot be read.
    #[error(transparent)]
    Picture(#[from] DecodeError),
    /// A file could not be written.
    #[error(transparent)]
    Write(#[from] OutputError),
    /// The pictures have not the same size.
    #[error("expected {} x {} pixels, actual {} x {}", expected[0], expected[1], actual[0], actual[1])]
    Size {
        /// Width and height of the expected picture.
        expected: [u32; 2],
        /// Width and height of the actual picture.
        actual: [u32; 2],
    },
    /// One holds display codes, the other linear light.
    #[error("one picture holds display codes and the other linear light")]
    Transfer,
    /// A picture is not as expected.
    #[error("{summary}{}{}{}\nlook at them with `overcoat golden report`; record with UPDATE_GOLDENS=1 or `overcoat golden accept`",
        line("    would be wrong: ", why.as_deref()), line("    expected: ", expected.as_ref().map(|path| path.display())),
        line("    actual:   ", actual.as_ref().map(|path| path.display())))]
    Differs {
        /// The name of the picture, and in what it differs.
        summary: String,
        /// Reason that the picture is tested, by the description of the golden, if it has one.
        why: Option<String>,
        /// The expected picture, if there is one.
        expected: Option<PathBuf>,
        /// The actual picture, which was written for looking at; `None` if no pixel differs.
        actual: Option<PathBuf>,
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
    /// There is no actual picture of that name.
    #[error("no actual picture")]
    NoActual,
    /// A file was not looked at: a link that leads out of its folder, or one that cannot be followed.
    #[error("{0}")]
    NotFollowed(String),
    /// An animated PNG file, whose frames are not compressed.
    #[error("animated PNG files are kept as they are")]
    Animated,
    /// Compression changed a pixel: a defect of this crate. Nothing is written.
    #[error("compression would change the picture; it is not accepted")]
    CompressionChanged,
}

impl From<ReadError> for GoldenError {
    fn from(error: ReadError) -> Self {
        Self::Picture(error.into())
    }
}

/// A further line of a message, if there is something to say.
fn line(before: &str, value: Option<impl std::fmt::Display>) -> String {
    value.map_or_else(String::new, |value| format!("\n{before}{value}"))
}
