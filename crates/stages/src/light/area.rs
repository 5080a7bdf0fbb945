//! Rectangles and tubes, ready for the integration over them (`overcoat_shading::brdf::linearly_transformed_cosine`).

use overcoat_core::each;
use overcoat_scene::{Light, LightKind};

/// A light with an extent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AreaLight {
    /// Colour times luminance: candela per square metre, the renderer's unit of radiance.
    pub radiance: [f32; 3],
    /// Shape and place in world space.
    pub shape: AreaShape,
}

/// The place of an [`AreaLight`] in world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AreaShape {
    /// A rectangle.
    Rect {
        /// Its corners, counter-clockwise as seen from its front.
        corners: [[f32; 3]; 4],
        /// Shines from its back as well.
        two_sided: bool,
    },
    /// A tube.
    Tube {
        /// Ends of its axis.
        ends: [[f32; 3]; 2],
        /// Radius.
        radius: f32,
    },
}

impl AreaLight {
    /// Prepares a light of a valid scene; `None` for lights without extent, see [`super::PunctualLight`].
    #[must_use]
    pub fn new(light: &Light) -> Option<Self> {
        let shape = match light.kind {
            LightKind::Rect { position, half_width, half_height, two_sided } => {
                let corner =
                    |x: f32, y: f32| each!(k => position[k] + x * half_width[k] + y * half_height[k]);
                let corners = [corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0), corner(-1.0, -1.0)];
                AreaShape::Rect { corners, two_sided }
            }
            LightKind::Tube { ends, radius } => AreaShape::Tube { ends, radius },
            LightKind::Directional { .. } | LightKind::Point { .. } | LightKind::Spot { .. } => return None,
        };
        Some(Self { radiance: each!(c in light.color => c * light.intensity), shape })
    }
}
