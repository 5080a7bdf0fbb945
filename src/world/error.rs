//! Errors of a world.

use overcoat_load::LoadError;
use overcoat_scene::SceneError;

/// Reason why a world is not changed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum WorldError {
    /// The name is of something that has been removed, or of nothing.
    #[error("the {what} is not there: it has been removed, or never was")]
    Gone {
        /// Kind of element.
        what: &'static str,
    },
    /// The name is of something in another world.
    #[error("the {what} is one of another world")]
    Foreign {
        /// Kind of element.
        what: &'static str,
    },
    /// It cannot be removed because something else needs it.
    #[error("the {what} is in use, by {by} {number}")]
    InUse {
        /// Kind of element.
        what: &'static str,
        /// Kind of what needs it.
        by: &'static str,
        /// Number of that among its kind.
        number: usize,
    },
    /// There is no name left for another.
    #[error("too many of one kind: {what}")]
    TooMany {
        /// Kind of element.
        what: &'static str,
    },
    /// The scene refuses what is added to it.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// A pose cannot be made of a file.
    #[error(transparent)]
    Load(#[from] LoadError),
}
