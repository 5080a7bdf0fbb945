//! Models at any time of an animation.
use super::gltf::{Purpose, Rig};
use super::{Claim, Context, Format, LoadError, LoadOptions, Loaded, Model, Warning};
use overcoat_core::jobs::Jobs;
use overcoat_core::limits::Limits;
use std::path::Path;

/// An animation that a file has.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct AnimationInfo {
    /// Its name; may be empty.
    pub name: String,
    /// Seconds to the last key frame, if the file tells.
    pub length: Option<f64>,
    /// Number of properties that it animates.
    pub channels: usize,
}

/// A model file that has been read once and gives its scene at any time of one animation. Textures and everything that
/// does not move are shared between the scenes.
pub struct AnimatedModel {
    model: Model,
    format: Option<Format>,
    repeat: bool,
}

impl std::fmt::Debug for AnimatedModel {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let length = self.length();
        f.debug_struct("AnimatedModel").field("format", &self.format).field("length", &length).finish()
    }
}

impl AnimatedModel {
    /// Reads a file as [`load_file_with`](super::load_file_with) does.
    ///
    /// # Errors
    /// As there.
    pub fn open(path: &Path, options: &LoadOptions, limits: &Limits, jobs: &Jobs) -> Result<Self, LoadError> {
        let (model, format) = super::read_path(path, options, Purpose::Contents, limits, jobs)?;
        Ok(Self { model, format, repeat: repeats(options) })
    }

    /// Reads a file in memory as [`load_bytes_with`](super::load_bytes_with) does.
    ///
    /// # Errors
    /// As there.
    pub fn from_bytes(
        bytes: &[u8],
        format: Option<Format>,
        options: &LoadOptions,
        context: &Context<'_>,
    ) -> Result<Self, LoadError> {
        let claim = Claim { said: format, named: None };
        let (model, format) = super::read_bytes(bytes, claim, options, Purpose::Contents, context)?;
        Ok(Self { model, format, repeat: repeats(options) })
    }

    /// [`AnimatedModel::from_bytes`] of a file whose name says what its content does not.
    pub fn from_named_bytes(
        bytes: &[u8],
        name: &Path,
        options: &LoadOptions,
        context: &Context<'_>,
    ) -> Result<Self, LoadError> {
        let claim = Claim { said: None, named: super::format_of_name(name) };
        let (model, format) = super::read_bytes(bytes, claim, options, Purpose::Contents, context)?;
        Ok(Self { model, format, repeat: repeats(options) })
    }

    /// Adds to what was lost on the way to the file that was read.
    #[must_use]
    pub fn with_warning(mut self, warning: Warning) -> Self {
        self.model.warn(warning);
        self
    }

    /// The format that the file was found to have.
    #[must_use]
    pub fn format(&self) -> Option<Format> {
        self.format
    }

    /// All animations of the file, in its order.
    #[must_use]
    pub fn animations(&self) -> &[AnimationInfo] {
        self.rig().map_or(&[], Rig::animations)
    }

    /// Names of all material variants of the file, in its order; they may be empty.
    pub fn variants(&self) -> impl Iterator<Item = &str> {
        self.rig().into_iter().flat_map(Rig::variants)
    }

    /// Seconds to the last key frame of the animation that was chosen; `None` if none was.
    #[must_use]
    pub fn length(&self) -> Option<f64> {
        self.rig().and_then(Rig::length)
    }

    /// The scene at a time, in seconds, of the animation that was chosen; the same scene each time if none was. The
    /// warnings are those of reading the file and those of this pose.
    ///
    /// # Errors
    /// [`LoadError::Scene`] naming what cannot be part of a scene.
    pub fn at(&self, time: f64, jobs: &Jobs) -> Result<Loaded, LoadError> {
        match &self.model {
            Model::Still(loaded) => Ok((**loaded).clone()),
            Model::Rig(rig) => rig.at(time, self.repeat, jobs),
        }
    }

    fn rig(&self) -> Option<&Rig> {
        match &self.model {
            Model::Still(_) => None,
            Model::Rig(rig) => Some(rig),
        }
    }
}

fn repeats(options: &LoadOptions) -> bool {
    options.animation.as_ref().is_some_and(|animation| animation.repeat)
}
