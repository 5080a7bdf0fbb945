//! Errors in material files. They are written by hand, so the messages help to mend them.

use crate::ResolveError;
use overcoat_core::limits::LimitExceeded;
use overcoat_core::suggest::suggestion;
use overcoat_scene::SceneError;
use std::fmt;

/// Error in a material file: the place and the reason. Callers that opened the file put its name before the message.
#[derive(Clone, Debug, PartialEq)]
pub struct MaterialError {
    /// Line of the file, from 1; `None` if the file as a whole is meant.
    pub line: Option<usize>,
    /// The key, with those of the tables around it: `coat_texture.channel`.
    pub key: Option<String>,
    /// The reason.
    pub reason: MaterialErrorReason,
}

/// Reason why a material file is refused.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum MaterialErrorReason {
    /// The file cannot be read.
    Unreadable(String),
    /// It has more bytes than a material file may have, or `limits` allow.
    TooLarge {
        /// Most bytes that it may have.
        limit: u64,
    },
    /// It is not TOML.
    Syntax(String),
    /// There is no such key.
    UnknownKey {
        /// The key that is meant, perhaps.
        nearest: Option<&'static str>,
        /// All keys that there are.
        valid: Vec<&'static str>,
    },
    /// A value that is one of a few names is none of them.
    UnknownName {
        /// As written.
        value: String,
        /// The name that is meant, perhaps.
        nearest: Option<&'static str>,
        /// All names that there are.
        valid: Vec<&'static str>,
    },
    /// A number lies outside its range.
    OutOfRange {
        /// As written.
        value: String,
        /// The least that it may be.
        low: f32,
        /// The most that it may be.
        high: f32,
    },
    /// A value is of another kind than the key takes.
    WrongType {
        /// Value that the key takes.
        expected: &'static str,
        /// Value that was found.
        found: String,
    },
    /// Two keys contradict each other.
    Conflict {
        /// The other key.
        other: &'static str,
        /// Reason why both cannot be.
        why: &'static str,
    },
    /// The key means nothing without another one.
    Needs {
        /// The other key.
        other: &'static str,
    },
    /// A texture cannot be read.
    Texture(ResolveError),
    /// A texture is no picture that can be used: its name and why.
    Picture {
        /// The file as written.
        name: String,
        /// The reason why it is refused.
        why: String,
    },
    /// It asks for more than the limits allow.
    Limit(LimitExceeded),
    /// The scene refuses the material.
    Scene(SceneError),
}

impl fmt::Display for MaterialError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(line) = self.line {
            write!(f, "line {line}: ")?;
        }
        match (&self.key, &self.reason) {
            (Some(key), MaterialErrorReason::UnknownKey { .. }) => write!(f, "unknown key '{key}'")?,
            (Some(key), _) => write!(f, "{key}: ")?,
            (None, _) => {}
        }
        self.reason.fmt(f)
    }
}

impl fmt::Display for MaterialErrorReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unreadable(why) => write!(f, "cannot be read: {why}"),
            Self::TooLarge { limit } => write!(f, "too large for a material file: more than {limit} bytes"),
            Self::Syntax(message) => f.write_str(message),
            Self::UnknownKey { nearest, valid } => {
                write!(f, "{} (valid are {})", suggestion(*nearest), valid.join(", "))
            }
            Self::UnknownName { value, nearest, valid } => {
                write!(f, "'{value}' is not known{} (valid are {})", suggestion(*nearest), valid.join(", "))
            }
            Self::OutOfRange { value, low, high } => {
                write!(f, "{value} is out of range, {low} to {high}")
            }
            Self::WrongType { expected, found } => write!(f, "expected {expected}, found {found}"),
            Self::Conflict { other, why } => write!(f, "cannot stand beside {other}: {why}"),
            Self::Needs { other } => write!(f, "needs {other} as well"),
            Self::Texture(ResolveError::Outside(name)) => {
                write!(f, "'{name}' leads out of the material file's folder")
            }
            Self::Texture(ResolveError::NotAllowed(name)) => {
                write!(f, "'{name}' cannot be read: this material may not refer to other files")
            }
            Self::Texture(error) => error.fmt(f),
            Self::Picture { name, why } => write!(f, "'{name}': {why}"),
            Self::Limit(error) => error.fmt(f),
            Self::Scene(error) => error.fmt(f),
        }
    }
}

impl std::error::Error for MaterialError {}

impl MaterialError {
    /// About the file as a whole.
    pub(super) fn whole(reason: MaterialErrorReason) -> Self {
        Self { line: None, key: None, reason }
    }

    /// True if a limit stopped the loader.
    #[must_use]
    pub fn is_limit(&self) -> bool {
        matches!(
            self.reason,
            MaterialErrorReason::Limit(_)
                | MaterialErrorReason::TooLarge { .. }
                | MaterialErrorReason::Texture(ResolveError::TooLarge { .. })
        )
    }
}

impl MaterialError {
    /// The field of [`Limits`](overcoat_core::limits::Limits) that stopped the loader, if raising it helps.
    #[must_use]
    pub fn limit(&self) -> Option<&'static str> {
        match &self.reason {
            MaterialErrorReason::Limit(exceeded) => Some(exceeded.field),
            MaterialErrorReason::TooLarge { limit } if *limit >= super::MAX_BYTES => None,
            MaterialErrorReason::TooLarge { .. }
            | MaterialErrorReason::Texture(ResolveError::TooLarge { .. }) => Some("input_bytes"),
            _ => None,
        }
    }
}

/// Error of laying a material over a scene.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum AssignError {
    /// No material of the model has that name.
    #[error("the model has no material '{name}'{}; {}", suggestion(nearest.as_deref()), has(names))]
    NoSuchMaterial {
        /// The name that was asked for.
        name: String,
        /// The name that is meant, perhaps.
        nearest: Option<String>,
        /// The names that there are, each once.
        names: Vec<String>,
    },
    /// It takes more than the limits allow.
    #[error(transparent)]
    Limit(#[from] LimitExceeded),
    /// The scene refuses it.
    #[error(transparent)]
    Scene(#[from] SceneError),
}

/// Names that a message lists; those of the rest are in `overcoat info`.
const LISTED: usize = 40;

/// `it has 'a', 'b'`.
fn has(names: &[String]) -> String {
    if names.is_empty() {
        return "none of its materials has a name".to_owned();
    }
    let listed: Vec<String> = names.iter().take(LISTED).map(|name| format!("'{name}'")).collect();
    let more = names.iter().skip(LISTED).len();
    let more = if more > 0 { format!(" and {more} more") } else { String::new() };
    format!("it has {}{more}", listed.join(", "))
}
