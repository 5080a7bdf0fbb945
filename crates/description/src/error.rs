//! Why a description does not become a picture.

use super::name::{file_name, one_line};
use overcoat_core::limits::LimitExceeded;
use overcoat_load::{AssignError, LoadError, MaterialError};
use overcoat_scene::SceneError;
use std::fmt::Display;
use std::path::{Path, PathBuf};

/// Error in a description, or in a file that it names. A message is one line without control characters.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum DescriptionError {
    /// A scene file that is no such file: the line, the key, what was expected and what is there. Or something that is not
    /// there: a model, a camera, a light as it is described.
    #[error("{0}")]
    Invalid(String),
    /// A number that is out of its range.
    #[error("{0}")]
    OutOfRange(String),
    /// `time` or `loop` without `animation`.
    #[error("a time without an animation")]
    TimeWithoutAnimation,
    /// A parallel projection from a given `eye`, which nothing can be fitted to.
    #[error("a parallel projection from a given eye needs a height (ortho_height)")]
    NoHeight,
    /// It would cost more than [`Limits`](crate::Limits) allow.
    #[error(transparent)]
    Limit(#[from] LimitExceeded),
    /// A model, an environment or a scene file that cannot be read.
    #[error(transparent)]
    Load(#[from] LoadError),
    /// A material file that cannot be read.
    #[error(transparent)]
    Material(#[from] MaterialError),
    /// A material that cannot be laid over the model.
    #[error(transparent)]
    Assign(#[from] AssignError),
    /// A camera, a light or an environment that no scene can have.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// Any of these, and the file that it is about.
    #[error("{}: {error}", file_name(file))]
    At {
        /// The file.
        file: PathBuf,
        /// Its error.
        error: Box<DescriptionError>,
    },
}

impl DescriptionError {
    /// [`DescriptionError::Invalid`].
    pub(super) fn invalid(message: impl Display) -> Self {
        Self::Invalid(one_line(&message.to_string()))
    }

    /// [`DescriptionError::OutOfRange`].
    pub(super) fn out_of_range(message: impl Display) -> Self {
        Self::OutOfRange(one_line(&message.to_string()))
    }

    /// The same with the file that it is about in front.
    #[must_use]
    pub fn at(self, file: &Path) -> Self {
        Self::At { file: file.to_owned(), error: Box::new(self) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_stay_on_one_line_without_control_characters() {
        let error = DescriptionError::invalid("bad name 'a\nb\u{1b}[31m'\n").at(Path::new("x\r.glb"));
        let text = error.to_string();
        assert!(text.starts_with("x .glb: bad name 'a b"), "{text}");
        assert!(text.chars().all(|c| !c.is_control()), "{text:?}");
    }
}
