//! Lights: punctual ones in the units of KHR_lights_punctual, rectangles and tubes by their luminance.

use super::changeable::changeable;
use super::error::{unit, within};
use super::{SceneError, Transform};

/// Least and largest extent of an area light in metres: squares and products of edges stay far from the limits of f32.
const MIN_EXTENT: f32 = 1e-6;
const MAX_EXTENT: f32 = 1e6;

/// Checks the length of an edge.
fn extent(what: &'static str, edge: &[f32; 3]) -> Result<(), SceneError> {
    within(what, edge, -MAX_EXTENT, MAX_EXTENT)?;
    let length = (edge[0] * edge[0] + edge[1] * edge[1] + edge[2] * edge[2]).sqrt();
    within(what, &[length], MIN_EXTENT, MAX_EXTENT)
}

/// Kind and placement of a light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightKind {
    /// Infinitely far away; intensity is illuminance in lux at a surface that faces it.
    Directional {
        /// Direction in which the light travels; of any length but zero, [`super::Scene::add_light`] makes it a unit
        /// vector.
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
        /// Axis, in which the light travels; of any length but zero, [`super::Scene::add_light`] makes it a unit vector.
        direction: [f32; 3],
        /// Distance in metres at which it has faded out; infinite if `None`.
        range: Option<f32>,
        /// Cosine of the half angle inside which it is full.
        inner_cone_cosine: f32,
        /// Cosine of the half angle outside which it is dark; below the inner cosine.
        outer_cone_cosine: f32,
    },
    /// A rectangle that shines from its front, equally in all directions; intensity is luminance in candela per square
    /// metre. It is not seen itself.
    Rect {
        /// World-space centre in metres.
        position: [f32; 3],
        /// From the centre to the middle of its right edge, in metres.
        half_width: [f32; 3],
        /// From the centre to the middle of its upper edge, in metres. The front faces along half width x half height:
        /// who looks at it sees right on the right and up above.
        half_height: [f32; 3],
        /// Shines from its back as well.
        two_sided: bool,
    },
    /// A thin tube with round cross-section and dark ends; intensity is luminance in candela per square metre. It is
    /// not seen itself.
    Tube {
        /// World-space ends of its axis in metres.
        ends: [[f32; 3]; 2],
        /// Radius in metres; small against its distance from the surfaces that it lights.
        radius: f32,
    },
}

/// Integration of specular reflections of area lights.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum AreaLightMethod {
    /// By linearly transformed cosines, as engines do: off by 2 percent of a GGX lobe seen from above and by 15 percent at
    /// N.V = 0.3.
    #[default]
    LinearlyTransformedCosines,
    /// Over the facets of the lobe, several times slower: within 1 percent of the integral for perceptual roughness of
    /// 0.2 and more seen at N.V of 0.3 and more.
    Facets,
}

impl AreaLightMethod {
    /// All of them.
    pub const ALL: &'static [Self] = &[Self::LinearlyTransformedCosines, Self::Facets];

    /// Name as `--area-lights` takes it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::LinearlyTransformedCosines => "ltc",
            Self::Facets => "facets",
        }
    }

    /// The method of that name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|method| method.name() == name)
    }
}

/// A light.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Light {
    /// Kind and placement.
    pub kind: LightKind,
    /// Linear colour that multiplies the intensity.
    pub color: [f32; 3],
    /// Lux, candela or candela per square metre, 0 to 1e9.
    pub intensity: f32,
    /// Surfaces are at least as rough as this under it (alpha, the square of perceptual roughness, 0 to 1), so that a
    /// light without extent has a highlight with one: Unity's `minRoughness`. StackLit reads it where the material says
    /// so, [`super::StackLitOptions::honor_light_minimum_roughness`].
    pub minimum_roughness: f32,
}

impl Light {
    /// A white light of intensity 1.
    #[must_use]
    pub fn new(kind: LightKind) -> Self {
        Self { kind, color: [1.0; 3], intensity: 1.0, minimum_roughness: 0.0 }
    }

    /// A white sun: light that travels in a direction of any length but zero, of an illuminance in lux.
    #[must_use]
    pub fn directional(direction: [f32; 3], lux: f32) -> Self {
        Self { intensity: lux, ..Self::new(LightKind::Directional { direction }) }
    }

    /// A white bulb without range at a world-space position in metres, of a luminous intensity in candela.
    #[must_use]
    pub fn point(position: [f32; 3], candela: f32) -> Self {
        Self { intensity: candela, ..Self::new(LightKind::Point { position, range: None }) }
    }
}

impl Light {
    /// The light, moved by a transform. Its range, the radius of a tube and the sides of a rectangle are
    /// scaled as lengths are; its intensity stays.
    ///
    /// # Errors
    /// [`SceneError`] if a number of it would not be finite or leave its range.
    pub fn transformed(&self, by: &Transform) -> Result<Self, SceneError> {
        let point = |p: &mut [f32; 3]| *p = by.point(p.map(f64::from)).map(|c| c as f32);
        let along = |d: &mut [f32; 3]| *d = by.direction(d.map(f64::from)).map(|c| c as f32);
        let scale = by.uniform_scale();
        let length = |l: &mut f32| *l = (f64::from(*l) * scale) as f32;
        let mut light = *self;
        match &mut light.kind {
            LightKind::Directional { direction } => along(direction),
            LightKind::Point { position, range } => {
                point(position);
                range.iter_mut().for_each(length);
            }
            LightKind::Spot { position, direction, range, .. } => {
                point(position);
                along(direction);
                range.iter_mut().for_each(length);
            }
            LightKind::Rect { position, half_width, half_height, .. } => {
                point(position);
                along(half_width);
                along(half_height);
            }
            LightKind::Tube { ends, radius } => {
                ends.iter_mut().for_each(point);
                length(radius);
            }
        }
        light.checked()
    }

    /// True if it has an extent: the shading of surfaces is an integral over it.
    #[must_use]
    pub fn has_area(&self) -> bool {
        matches!(self.kind, LightKind::Rect { .. } | LightKind::Tube { .. })
    }
}

impl Light {
    /// The same light with directions of unit length, if numbers are finite and in range and cones in order.
    pub(crate) fn checked(mut self) -> Result<Self, SceneError> {
        if let LightKind::Directional { direction } | LightKind::Spot { direction, .. } = &mut self.kind {
            *direction = unit("light direction", *direction)?;
        }
        self.validate()?;
        Ok(self)
    }

    /// Checks that numbers are finite and in range and cones in order.
    fn validate(&self) -> Result<(), SceneError> {
        within("light colour", &self.color, 0.0, 1e6)?;
        within("light intensity", &[self.intensity], 0.0, 1e9)?;
        within("light's minimum roughness", &[self.minimum_roughness], 0.0, 1.0)?;
        let position_range = |p: &[f32; 3], range: &Option<f32>| {
            within("light position", p, -super::MAX_COORDINATE, super::MAX_COORDINATE)?;
            range.map_or(Ok(()), |r| within("light range", &[r], f32::MIN_POSITIVE, f32::MAX))
        };
        match &self.kind {
            LightKind::Directional { .. } => Ok(()),
            LightKind::Point { position, range } => position_range(position, range),
            LightKind::Spot { position, range, inner_cone_cosine, outer_cone_cosine, .. } => {
                position_range(position, range)?;
                within("inner cone cosine", &[*inner_cone_cosine], -1.0, 1.0)?;
                within("outer cone cosine", &[*outer_cone_cosine], -1.0, *inner_cone_cosine)
            }
            LightKind::Rect { position, half_width, half_height, .. } => {
                position_range(position, &None)?;
                extent("light's half width", half_width)?;
                extent("light's half height", half_height)
            }
            LightKind::Tube { ends, radius } => {
                position_range(&ends[0], &None)?;
                position_range(&ends[1], &None)?;
                let axis = std::array::from_fn(|k| ends[1][k] - ends[0][k]);
                extent("length of the light", &axis)?;
                within("radius of the light", &[*radius], MIN_EXTENT, MAX_EXTENT)
            }
        }
    }
}

changeable!(Light);

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Scene;

    #[test]
    fn a_scene_has_unit_directions_whatever_it_is_given() {
        let spot = |direction| {
            Light::new(LightKind::Spot {
                position: [0.0; 3],
                direction,
                range: None,
                inner_cone_cosine: 0.9,
                outer_cone_cosine: 0.8,
            })
        };
        let lights: [&dyn Fn([f32; 3]) -> Light; 2] =
            [&|direction| Light::directional(direction, 3.0), &spot];
        for light in lights {
            let mut scene = Scene::new();
            scene.add_light(light([0.0, -2.0, 0.0])).unwrap();
            assert_eq!(scene.lights(), [light([0.0, -1.0, 0.0])]);
            let error = |direction| Scene::new().add_light(light(direction)).unwrap_err();
            assert_eq!(error([0.0; 3]), SceneError::NoLength { what: "light direction" });
            assert_eq!(error([0.0, f32::NAN, 1.0]), SceneError::NotFinite { what: "light direction" });
        }
        let bulb = Light::point([1.0, 2.0, 3.0], 5.0);
        assert_eq!(bulb.checked(), Ok(bulb));
    }
}
