//! Light on the balls: one lamp, or an environment that is smooth enough to be the same however a renderer filters it.

use super::view::dot;
use overcoat_core::math::double::sin_cos;
use std::f64::consts::{PI, TAU};

/// Towards the lamp: it is to the right, above and before the ball.
pub const LAMP: [f64; 3] = [2.0 / 3.0, 1.0 / 3.0, 2.0 / 3.0];

/// Irradiance of the lamp at normal incidence: a white Lambert surface shows it as 1.
pub const IRRADIANCE: f64 = PI;

/// The gradient's radiance in the middle, and the slope along each axis: x to red, y to green, z to blue.
pub const GRADIENT: [f64; 2] = [0.5, 0.4];

/// Towards the middle of the soft box: to the left, above and before the ball.
pub const BOX: [f64; 3] = [-0.6, 0.64, 0.48];

/// Cosines from [`BOX`] at which the soft box ends and from which it is whole.
pub const BOX_RANGE: [f64; 2] = [0.7, 0.82];

/// Radiance of the whole soft box.
pub const BOX_RADIANCE: f64 = 3.0;

/// Size of the maps.
pub const MAP_WIDTH: usize = 512;
/// Rows of an environment of the pack.
pub const MAP_HEIGHT: usize = 256;

/// The light of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sky {
    /// Radiance 1 from everywhere.
    White,
    /// A colour for each axis, which tells where a map's axes are.
    Gradient,
    /// One round soft box in darkness.
    Box,
    /// One lamp in darkness.
    Lamp,
}

impl Sky {
    /// Skies that the pack writes as environment maps.
    pub const MAPS: [Self; 3] = [Self::White, Self::Gradient, Self::Box];

    /// Name of the map; of the lamp there is none.
    pub fn name(self) -> &'static str {
        match self {
            Self::White => "white",
            Self::Gradient => "gradient",
            Self::Box => "box",
            Self::Lamp => "lamp",
        }
    }

    /// Radiance from a direction of length 1. The lamp has none: it is a direction alone.
    pub fn radiance(self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        match self {
            Self::White => [1.0; 3],
            Self::Gradient => [x, y, z].map(|c| GRADIENT[0] + GRADIENT[1] * c),
            Self::Box => {
                let [ends, whole] = BOX_RANGE;
                let t = ((dot([x, y, z], BOX) - ends) / (whole - ends)).clamp(0.0, 1.0);
                [BOX_RADIANCE * t * t * (3.0 - 2.0 * t); 3]
            }
            Self::Lamp => [0.0; 3],
        }
    }

    /// The map, row by row from +Y: of a direction, the column is `atan2(z, x) / 2 pi + 0.5` of the width and the row
    /// `acos(y) / pi` of the height.
    pub fn map(self) -> Vec<[f32; 3]> {
        let (width, height) = (MAP_WIDTH, MAP_HEIGHT);
        let mut pixels = Vec::with_capacity(width * height);
        for row in 0..height {
            let (sin, cos) = sin_cos(PI * (row as f64 + 0.5) / height as f64);
            for column in 0..width {
                let (s, c) = sin_cos(TAU * ((column as f64 + 0.5) / width as f64 - 0.5));
                pixels.push(self.radiance([sin * c, cos, sin * s]).map(|v| v as f32));
            }
        }
        pixels
    }
}
