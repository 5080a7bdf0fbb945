//! Errors and warnings of loading a file.
use overcoat_core::files::ReadError;
use overcoat_core::limits::LimitExceeded;
use overcoat_image::decode::{DecodeError, one_line};
use overcoat_scene::SceneError;
use std::fmt;

/// Something a file asks for that its picture will not show.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Warning {
    /// One line that names the element and what happens instead.
    pub message: String,
    /// Kind of it for programs, a name that stays: [`Warning::FILE`] unless it says more.
    pub code: &'static str,
    /// Options of the command line that mend it, if there are any: `--exposure auto`.
    pub remedy: Option<String>,
}

impl Warning {
    /// Code of what a file asks for and is not drawn.
    pub const FILE: &'static str = "file";

    /// Code of a texture that a model is drawn without.
    pub const TEXTURE: &'static str = "texture";

    /// A warning with this text, of the code [`Warning::FILE`].
    pub fn new(message: impl Into<String>) -> Self {
        Self { message: one_line(message.into()), code: Self::FILE, remedy: None }
    }

    /// Changes the code.
    #[must_use]
    pub fn with_code(self, code: &'static str) -> Self {
        Self { code, ..self }
    }

    /// Adds options that mend it.
    #[must_use]
    pub fn with_remedy(self, remedy: impl Into<String>) -> Self {
        Self { remedy: Some(one_line(remedy.into())), ..self }
    }

    /// Puts the name of an element before the message.
    #[must_use]
    pub fn of(self, name: &str) -> Self {
        Self { message: one_line(format!("{name}: {}", self.message)), ..self }
    }
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

/// Error of loading a file. The message names the element; callers that opened the file put its name before it.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LoadError {
    /// The file cannot be read.
    #[error("cannot be read: {0}")]
    Io(#[from] std::io::Error),
    /// The file is of no known format.
    #[error("{0}")]
    UnknownFormat(String),
    /// The file is damaged or breaks the rules of its format.
    #[error("{format}: {message}")]
    Malformed {
        /// Name of the format.
        format: &'static str,
        /// The element and what is wrong with it.
        message: String,
    },
    /// The file requires something that this version cannot draw.
    #[error("{format}: {message}")]
    Unsupported {
        /// Name of the format.
        format: &'static str,
        /// The feature, and the element that requires it.
        message: String,
    },
    /// A file that it refers to cannot be had, and it cannot be drawn without.
    #[error("{0}")]
    Resolve(#[from] super::ResolveError),
    /// It asks for more than the limits allow.
    #[error(transparent)]
    Limit(#[from] LimitExceeded),
    /// It does not have what [`LoadOptions`](super::LoadOptions) choose.
    #[error("{0}")]
    NoSuch(String),
    /// The scene refuses an element of the file.
    #[error("{element}: {source}")]
    Scene {
        /// The element of the file.
        element: String,
        /// The reason of the refusal.
        source: SceneError,
    },
}

impl From<ReadError> for LoadError {
    fn from(error: ReadError) -> Self {
        match error {
            ReadError::Io(error) => Self::Io(error),
            ReadError::Limit(error) => Self::Limit(error),
        }
    }
}

impl From<DecodeError> for LoadError {
    fn from(error: DecodeError) -> Self {
        match error {
            DecodeError::Io(error) => Self::Io(error),
            DecodeError::UnknownFormat(message) => Self::UnknownFormat(message),
            DecodeError::Malformed { format, message } => Self::Malformed { format, message },
            DecodeError::Unsupported { format, message } => Self::Unsupported { format, message },
            DecodeError::Limit(error) => Self::Limit(error),
            other => Self::Malformed { format: "picture", message: other.to_string() },
        }
    }
}

impl LoadError {
    /// A damaged file.
    pub fn malformed(format: &'static str, message: impl Into<String>) -> Self {
        Self::Malformed { format, message: one_line(message.into()) }
    }
    /// A feature that is not there.
    pub fn unsupported(format: &'static str, message: impl Into<String>) -> Self {
        Self::Unsupported { format, message: one_line(message.into()) }
    }
    /// True if it is about one element of a file, so that the rest of it can be drawn: limits are about all of it.
    pub(super) fn is_partial(&self) -> bool {
        !matches!(self, Self::Limit(_) | Self::Resolve(super::ResolveError::TooLarge { .. }))
    }
    /// The reason without the name of the format.
    pub(super) fn reason(&self) -> String {
        match self {
            Self::Malformed { message, .. } | Self::Unsupported { message, .. } => message.clone(),
            other => other.to_string(),
        }
    }
    /// A choice that the file does not offer.
    pub fn no_such(message: impl Into<String>) -> Self {
        Self::NoSuch(one_line(message.into()))
    }
    /// A refusal by the scene, with the element that caused it.
    pub fn scene(element: impl Into<String>) -> impl FnOnce(SceneError) -> Self {
        let element = one_line(element.into());
        move |source| Self::Scene { element, source }
    }
}
