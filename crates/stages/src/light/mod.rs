//! Light: environments prepared for lookups, punctual lights, and lights with an extent.

mod area;
mod chain;
mod charlie;
mod directions;
mod environment;
mod equirect;
mod file;
mod harmonics;
mod octahedral;
mod packed;
mod prefilter;
mod punctual;
mod reference;
mod studio;
mod texel;

#[cfg(test)]
mod tests;

pub use area::{AreaLight, AreaShape};
pub use chain::Levels;
pub use charlie::SHEEN;
pub use directions::LIGHT_DIRECTIONS;
pub use directions::LightDirections;
pub use environment::{EnvironmentLight, PrefilteredEnvironment};
pub use file::EnvironmentFileError;
pub use punctual::{LightSample, PunctualLight};
pub use studio::Studio;

/// Luminance of linear Rec. 709.
pub const LUMINANCE: [f32; 3] = [0.2126, 0.7152, 0.0722];

use overcoat_core::math::lanes::Lanes;
use overcoat_core::math::vec3::V3;

/// Radiance from infinitely far away, as a function of direction.
pub trait DistantRadiance {
    /// Linear Rec. 709 radiance that arrives from `direction` (away from the scene, any length but zero); finite and
    /// not negative.
    fn radiance<L: Lanes>(&self, l: L, direction: V3<L>) -> V3<L>;
}
