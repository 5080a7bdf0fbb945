//! Punctual lights in the units of KHR_lights_punctual.

use super::SceneError;
use super::error::{finite, within};

/// What kind of light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightKind {
    /// Infinitely far away; intensity is illuminance in lux at a surface that faces it.
    Directional {
        /// Unit vector in which the light travels.
        direction: [f32; 3],
    },
    /// A point; intensity is luminous intensity in candela.
    Point {
        /// World-space position in metres.
        position: [f32; 3],
        /// Distance in metres at which it has faded out; infinite if `None`.
        range: Option<f32>,
    },
    /// A cone; intensity is luminous intensity in candela on its axis.
    Spot {
        /// World-space position in metres.
        position: [f32; 3],
        /// Unit vector of the axis, in which the light travels.
        direction: [f32; 3],
        /// Distance in metres at which it has faded out; infinite if `None`.
        range: Option<f32>,
        /// Cosine of the half angle inside which it is full.
        inner_cone_cosine: f32,
        /// Cosine of the half angle outside which it is dark; below the inner cosine.
        outer_cone_cosine: f32,
    },
}

/// A light without extent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// Kind and placement.
    pub kind: LightKind,
    /// Linear colour that multiplies the intensity.
    pub color: [f32; 3],
    /// Lux or candela, 0 to 1e9.
    pub intensity: f32,
}

impl Light {
    /// Checks that numbers are finite, directions of unit length and cones in order.
    pub(crate) fn validate(&self) -> Result<(), SceneError> {
        within("light colour", &self.color, 0.0, 1e6)?;
        within("light intensity", &[self.intensity], 0.0, 1e9)?;
        let unit = |d: &[f32; 3]| {
            finite("light direction", d)?;
            let square = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
            within("length of the light direction", &[square], 0.99, 1.01)
        };
        let position_range = |p: &[f32; 3], range: &Option<f32>| {
            within("light position", p, -super::MAX_COORDINATE, super::MAX_COORDINATE)?;
            range.map_or(Ok(()), |r| within("light range", &[r], f32::MIN_POSITIVE, f32::MAX))
        };
        match &self.kind {
            LightKind::Directional { direction } => unit(direction),
            LightKind::Point { position, range } => position_range(position, range),
            LightKind::Spot { position, direction, range, inner_cone_cosine, outer_cone_cosine } => {
                unit(direction)?;
                position_range(position, range)?;
                within("inner cone cosine", &[*inner_cone_cosine], -1.0, 1.0)?;
                within("outer cone cosine", &[*outer_cone_cosine], -1.0, *inner_cone_cosine)
            }
        }
    }
}
