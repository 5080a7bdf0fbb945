//! What a user can ask of a picture.

use crate::frame::{Aov, Frame};
use crate::limits::{LimitExceeded, Limits};
use crate::math::lanes::SimdLevel;
use crate::scene::SceneError;
use std::time::Duration;

/// Which engine's formulas shade the surfaces.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum ShadingModel {
    /// Unity URP 13.0 Complex Lit on desktop platforms.
    #[default]
    UrpDesktop,
    /// Unity URP 13.0 Complex Lit where `SHADER_API_MOBILE` is defined.
    UrpMobile,
    /// Unity URP 17 (Unity 6), which has no such split.
    Urp17,
}

impl ShadingModel {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::UrpDesktop, Self::UrpMobile, Self::Urp17];

    /// Name as `--shading` takes it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::UrpDesktop => "urp-desktop",
            Self::UrpMobile => "urp-mobile",
            Self::Urp17 => "urp17",
        }
    }

    /// The model of that name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|model| model.name() == name)
    }
}

/// What is seen where no surface is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Background {
    /// Nothing: alpha 0.
    #[default]
    Transparent,
    /// The environment.
    Environment,
}

/// Options of one picture.
#[derive(Clone, Debug, PartialEq)]
pub struct RenderOptions {
    /// Width in pixels, 1 to [`Limits::output_side`].
    pub width: u32,
    /// Height in pixels, 1 to [`Limits::output_side`].
    pub height: u32,
    /// Coverage samples a pixel: 1, 4, 8 or 16.
    pub samples: u32,
    /// Side of a tile in pixels: 16, 32 or 64; `None` chooses by the number of samples. Never changes the picture.
    pub tile_size: Option<u32>,
    /// Instruction set. Never changes the picture.
    pub simd: SimdLevel,
    /// Formulas that shade the surfaces.
    pub shading: ShadingModel,
    /// What is seen where no surface is.
    pub background: Background,
    /// Largest number of texture probes along a stretched footprint: 1 (trilinear) to 16.
    pub anisotropy: u32,
    /// G-buffer planes to keep.
    pub aovs: Vec<Aov>,
    /// Bounds on the work.
    pub limits: Limits,
}

impl Default for RenderOptions {
    fn default() -> Self {
        Self {
            width: 512,
            height: 512,
            samples: 8,
            tile_size: None,
            simd: SimdLevel::best(),
            shading: ShadingModel::default(),
            background: Background::default(),
            anisotropy: 8,
            aovs: Vec::new(),
            limits: Limits::default(),
        }
    }
}

/// Why there is no picture.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RenderError {
    /// An option lies outside its range.
    #[error("{option}: {value} is not {allowed}")]
    Option {
        /// The option.
        option: &'static str,
        /// Its value.
        value: String,
        /// What it may be.
        allowed: &'static str,
    },
    /// The camera is not usable.
    #[error("camera: {0}")]
    Camera(#[from] SceneError),
    /// The picture costs more than allowed.
    #[error(transparent)]
    Limit(#[from] LimitExceeded),
}

/// A picture and what it took.
#[derive(Clone, Debug)]
pub struct Rendered {
    /// The picture.
    pub frame: Frame,
    /// What it took.
    pub stats: RenderStats,
}

/// Counts and times of one picture.
#[derive(Clone, Debug, Default)]
pub struct RenderStats {
    /// Triangles that went in, every instance counted.
    pub triangles: u64,
    /// Triangles that reached the rasterizer after clipping and culling.
    pub triangles_rasterized: u64,
    /// Surface fragments that were shaded.
    pub fragments: u64,
    /// Wall time of each stage, in the order of the stages.
    pub stages: Vec<(&'static str, Duration)>,
}
