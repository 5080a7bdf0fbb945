//! The ground: what of a floor under the model is seen.
//!
//! What reaches the floor is found once for a scene, in a picture of the floor from above (`ground_light.rs`), from the same
//! depth maps that surfaces are shaded with; frames that share the scene share it. The tiles look it up where they see the floor,
//! between the surfaces and what is behind them (`ground_pixels.rs`), and add the light of a few lamps, whose shadows are too
//! sharp for it (`ground_lamps.rs`).

use super::options::RenderOptions;
use overcoat_scene::{Footing, Scene};

/// Place of the floor of a picture.
pub fn footing_of(scene: &Scene, options: &RenderOptions) -> Option<Footing> {
    options.ground_under.map_or_else(|| scene.footing(), |all| Footing::under(&all))
}

/// Floor at the lowest point of the model along +Y, seen from above.
///
/// It is lit by the environment and by all lights, past the opaque and the alpha-masked triangles of the model (`Visibility`
/// says how well; without maps the floor has those of [`Quality::Fast`] for itself). In darkness there is no shadow. All of it
/// is there within half of the diagonal of the box around the model, about the place below its middle; from there to twice as
/// far, where nothing is left, it fades, and near the border of the picture
/// (`RenderOptions::ground_edge`). Its opacity is the plane
/// [`Aov::Ground`](overcoat_core::frame::Aov::Ground); it is no part of what
/// `RenderStats::covered` counts.
///
/// [`Quality::Fast`]: crate::quality::Quality::Fast
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Ground {
    /// No floor.
    #[default]
    None,
    /// The shadow of the model, as black whose opacity is the part of the light (by luminance) that does not arrive.
    Shadow,
    /// A matt floor of this colour, sRGB.
    Color([u8; 3]),
}

impl Ground {
    /// True if anything is seen of it.
    #[must_use]
    pub const fn is_seen(self) -> bool {
        !matches!(self, Self::None)
    }
}
