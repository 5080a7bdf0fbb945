//! Errors of reading picture files.

use overcoat_core::files::ReadError;
use overcoat_core::limits::LimitExceeded;

/// Error of reading a picture file. The message does not name the file.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum DecodeError {
    /// The file cannot be read.
    #[error("cannot be read: {0}")]
    Io(#[from] std::io::Error),
    /// It is of no known format.
    #[error("{0}")]
    UnknownFormat(String),
    /// It is damaged or breaks the rules of its format.
    #[error("{format}: {message}")]
    Malformed {
        /// Name of the format.
        format: &'static str,
        /// Description of the damage.
        message: String,
    },
    /// It has something that is not read.
    #[error("{format}: {message}")]
    Unsupported {
        /// Name of the format.
        format: &'static str,
        /// The feature.
        message: String,
    },
    /// It asks for more than the limits allow.
    #[error(transparent)]
    Limit(#[from] LimitExceeded),
}

impl From<ReadError> for DecodeError {
    fn from(error: ReadError) -> Self {
        match error {
            ReadError::Io(error) => Self::Io(error),
            ReadError::Limit(error) => Self::Limit(error),
        }
    }
}

impl DecodeError {
    pub(crate) fn malformed(format: &'static str, message: impl Into<String>) -> Self {
        Self::Malformed { format, message: one_line(message.into()) }
    }

    pub(crate) fn unsupported(format: &'static str, message: impl Into<String>) -> Self {
        Self::Unsupported { format, message: one_line(message.into()) }
    }
}

/// A message that names what a file contains, with control characters replaced: it is printed on one line.
pub fn one_line(message: String) -> String {
    if message.chars().any(char::is_control) {
        message.chars().map(|c| if c.is_control() { char::REPLACEMENT_CHARACTER } else { c }).collect()
    } else {
        message
    }
}

/// Text of a file as it may appear in a message: printable, quoted.
pub fn in_quotes(text: &str) -> String {
    format!("'{}'", one_line(text.to_owned()).trim())
}

/// The beginning of a token of a file, as [`in_quotes`].
pub(super) fn quoted(token: &[u8]) -> String {
    in_quotes(&String::from_utf8_lossy(token.get(..64).unwrap_or(token)))
}
