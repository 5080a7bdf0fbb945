//! Environment of a scene: its light from afar.

use super::SceneError;
use super::changeable::changeable;
use super::error::within;
use std::sync::Arc;

/// An equirectangular picture of radiance. Row 0 is +Y; the centre looks to +X and u = 0.75 to +Z:
/// `u = atan2(z, x) / 2 pi + 0.5`, `v = acos(y) / pi`.
#[derive(Clone, PartialEq)]
pub struct EquirectImage {
    width: u32,
    height: u32,
    pixels: Vec<[f32; 3]>,
}

impl std::fmt::Debug for EquirectImage {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "EquirectImage({} x {})", self.width, self.height)
    }
}

impl EquirectImage {
    /// Largest radiance that is kept; brighter texels (a sun in an HDR file) are clamped to it.
    pub const MAX_RADIANCE: f32 = 1e6;

    /// Takes linear Rec. 709 radiance, row by row. Values that are negative or not finite become 0, values above
    /// [`EquirectImage::MAX_RADIANCE`] that.
    ///
    /// # Errors
    /// [`SceneError::ImageSize`] if a side is zero or the number of pixels does not fit.
    pub fn new(width: u32, height: u32, mut pixels: Vec<[f32; 3]>) -> Result<Self, SceneError> {
        if width == 0 || height == 0 || pixels.len() as u64 != u64::from(width) * u64::from(height) {
            return Err(SceneError::ImageSize { width, height, len: pixels.len() });
        }
        for v in pixels.as_flattened_mut() {
            *v = if *v > 0.0 { if *v < Self::MAX_RADIANCE { *v } else { Self::MAX_RADIANCE } } else { 0.0 };
        }
        Ok(Self { width, height, pixels })
    }
    /// Width in pixels.
    #[must_use]
    pub fn width(&self) -> u32 {
        self.width
    }
    /// Height in pixels.
    #[must_use]
    pub fn height(&self) -> u32 {
        self.height
    }
    /// Linear radiance, row by row from +Y.
    #[must_use]
    pub fn pixels(&self) -> &[[f32; 3]] {
        &self.pixels
    }
}

/// Source of the light from afar.
#[derive(Clone, Debug, Default)]
pub enum EnvironmentSource {
    /// The built-in studio.
    #[default]
    Studio,
    /// A picture.
    Image(Arc<EquirectImage>),
    /// Darkness: punctual lights and emission only.
    None,
}

/// The environment of a scene.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Environment {
    /// Its picture.
    pub source: EnvironmentSource,
    /// Turns it by this angle about +Y, in degrees, counter-clockwise seen from above.
    pub rotation_degrees: f32,
    /// Multiplies its radiance, 0 to 1e6.
    pub intensity: f32,
    /// It came with the model, as dome lights of USD do: descriptions that name no other keep it, and where it overexposes, pictures
    /// are metered as under lights of the model.
    pub of_model: bool,
}

impl Default for Environment {
    fn default() -> Self {
        Self { source: EnvironmentSource::default(), rotation_degrees: 0.0, intensity: 1.0, of_model: false }
    }
}

impl Environment {
    /// Checks that numbers are finite and in range.
    pub(crate) fn validate(&self) -> Result<(), SceneError> {
        within("environment rotation", &[self.rotation_degrees], -1e6, 1e6)?;
        within("environment intensity", &[self.intensity], 0.0, 1e6)
    }
}

changeable!(Environment);
