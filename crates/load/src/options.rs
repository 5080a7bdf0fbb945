//! Choices among the contents of a file: what is loaded where it offers several things.
use super::{Format, LoadError};
use overcoat_scene::{Axis, Orientation};

/// Choices among what a file offers. The default is what the file shows by itself.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct LoadOptions {
    /// Material variant of a glTF file (KHR_materials_variants), by its name or, where none is called so, by its number
    /// from 0. Default: the materials that the primitives name themselves.
    pub variant: Option<String>,
    /// Animation of a glTF file. Default: none, which is the pose in which the file stores its nodes.
    pub animation: Option<AnimationChoice>,
    /// Axis of the model file that is up. The model with its lights and cameras is turned, without a loss, so that this
    /// axis is +Y of the scene and its [`Axis::front`] +Z. Default: that of
    /// [`Format::orientation`](super::Format::orientation); for OBJ, PLY and STL, which leave it to custom, the other one of +Y
    /// and +Z if the model evidently stands on it ([`Orientation::up_is_by_shape`]).
    pub up: Option<Axis>,
    /// Plate of a 3MF project, from 1, that is built alone. Default: all of them, side by side.
    pub plate: Option<u32>,
    /// Time at which the images of textures are decoded. Default: while the file is loaded.
    pub textures: TextureLoading,
}

/// Time at which the images of textures are decoded.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum TextureLoading {
    /// While the file is loaded: whatever is wrong with them is among the warnings of loading.
    #[default]
    Whole,
    /// On demand, when a picture reads them, and as finely as it does: the pictures are the same, and those of which a
    /// few are drawn take a part of the time and of the memory. Faults of images are found then, and listed by
    /// [`Scene::texture_losses`]. Images of which a loader makes others (OBJ's opacity, heights, metallic and roughness) are decoded
    /// as with [`TextureLoading::Whole`].
    ///
    /// [`Scene::texture_losses`]: crate::Scene::texture_losses
    ByNeed,
}

impl LoadOptions {
    /// Options with another [`LoadOptions::textures`].
    #[must_use]
    pub fn with_textures(self, textures: TextureLoading) -> Self {
        Self { textures, ..self }
    }

    /// Options with another [`LoadOptions::variant`].
    #[must_use]
    pub fn with_variant(self, variant: impl Into<Option<String>>) -> Self {
        Self { variant: variant.into(), ..self }
    }

    /// Options with another [`LoadOptions::animation`].
    #[must_use]
    pub fn with_animation(self, animation: impl Into<Option<AnimationChoice>>) -> Self {
        Self { animation: animation.into(), ..self }
    }

    /// Options with another [`LoadOptions::plate`].
    #[must_use]
    pub fn with_plate(self, plate: impl Into<Option<u32>>) -> Self {
        Self { plate: plate.into(), ..self }
    }

    /// Options with another [`LoadOptions::up`].
    #[must_use]
    pub fn with_up(self, up: impl Into<Option<Axis>>) -> Self {
        Self { up: up.into(), ..self }
    }
}

/// An animation, and a time in it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct AnimationChoice {
    /// Its name or, where none is called so, its number from 0.
    pub name: String,
    /// Seconds. Before the first key frame and after the last, that one's values hold.
    pub time: f64,
    /// After the last key frame the animation begins again at second 0.
    pub repeat: bool,
}

impl LoadOptions {
    /// The orientation of a file of a format with this one.
    pub(super) fn orientation(&self, of_format: Orientation) -> Orientation {
        Orientation { up: self.up.unwrap_or(of_format.up), ..of_format }
    }

    /// For files of a format without plates, which are all but 3MF.
    ///
    /// # Errors
    /// [`LoadError::NoSuch`] if one is chosen.
    pub(super) fn refuse_plate(&self, format: Option<Format>) -> Result<(), LoadError> {
        match self.plate {
            Some(number) if format != Some(Format::ThreeMf) => {
                Err(LoadError::no_such(format!("there is no plate {number}: files of this format have none")))
            }
            _ => Ok(()),
        }
    }

    /// For formats without variants and animations.
    ///
    /// # Errors
    /// [`LoadError::NoSuch`] if one is chosen.
    pub(super) fn refuse(&self) -> Result<(), LoadError> {
        let chosen = [
            ("material variant", self.variant.as_deref()),
            ("animation", self.animation.as_ref().map(|animation| animation.name.as_str())),
        ];
        match chosen.into_iter().find_map(|(what, name)| Some((what, name?))) {
            Some((what, name)) => {
                let shown: String = name.escape_debug().take(64).collect();
                let message = format!("there is no {what} '{shown}': files of this format have none");
                Err(LoadError::no_such(message))
            }
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formats_without_choices_refuse_one() {
        LoadOptions::default().refuse().unwrap();
        let error = LoadOptions { variant: Some("a\nb".into()), ..LoadOptions::default() }
            .refuse()
            .unwrap_err()
            .to_string();
        assert!(error.starts_with("there is no material variant 'a\\nb'"), "{error}");
        let animation = AnimationChoice { name: "Walk".to_owned(), ..AnimationChoice::default() };
        let error =
            LoadOptions { animation: Some(animation), ..LoadOptions::default() }.refuse().unwrap_err();
        assert!(error.to_string().starts_with("there is no animation 'Walk'"), "{error}");
        let second = LoadOptions::default().with_plate(2);
        second.refuse_plate(Some(Format::ThreeMf)).unwrap();
        for format in [Some(Format::Stl), Some(Format::Glb), None] {
            let error = second.refuse_plate(format).unwrap_err();
            assert_eq!(error.to_string(), "there is no plate 2: files of this format have none");
            LoadOptions::default().refuse_plate(format).unwrap();
        }
    }
}
