//! Up axis and front of a model file.

use crate::{Camera, Light, LightKind};
use std::ops::Sub;

/// An axis of a model file's coordinates.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Axis {
    /// Along +X.
    PositiveX,
    /// Along -X.
    NegativeX,
    /// Along +Y.
    #[default]
    PositiveY,
    /// Along -Y.
    NegativeY,
    /// Along +Z.
    PositiveZ,
    /// Along -Z.
    NegativeZ,
}

impl Axis {
    /// All of them.
    pub const ALL: &[Self] = &[
        Self::PositiveX,
        Self::NegativeX,
        Self::PositiveY,
        Self::NegativeY,
        Self::PositiveZ,
        Self::NegativeZ,
    ];

    /// Its name: a sign and a letter.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::PositiveX => "+x",
            Self::NegativeX => "-x",
            Self::PositiveY => "+y",
            Self::NegativeY => "-y",
            Self::PositiveZ => "+z",
            Self::NegativeZ => "-z",
        }
    }

    /// The axis of that name, in any case; without a sign it is positive.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        let same = |axis: &Self| {
            let unsigned = axis.name().strip_prefix('+');
            name.eq_ignore_ascii_case(axis.name()) || unsigned.is_some_and(|u| name.eq_ignore_ascii_case(u))
        };
        Self::ALL.iter().copied().find(same)
    }

    /// Direction that models face in a file in which this axis is up: +Z as in glTF, or, where Z is up, -Y as in
    /// slicers and modellers (+Y if the model stands on its head there).
    #[must_use]
    pub fn front(self) -> Self {
        match self {
            Self::PositiveZ => Self::NegativeY,
            Self::NegativeZ => Self::PositiveY,
            _ => Self::PositiveZ,
        }
    }

    /// The other direction along it.
    fn opposite(self) -> Self {
        match self {
            Self::PositiveX => Self::NegativeX,
            Self::NegativeX => Self::PositiveX,
            Self::PositiveY => Self::NegativeY,
            Self::NegativeY => Self::PositiveY,
            Self::PositiveZ => Self::NegativeZ,
            Self::NegativeZ => Self::PositiveZ,
        }
    }

    /// Coordinates of a file in which this axis is up, in a scene: the axis becomes +Y, its [`Axis::front`] +Z. An exchange
    /// of coordinates and signs, so that no bit of a number is lost.
    fn upright<T: Copy + Zero + Sub<Output = T>>(self, [x, y, z]: [T; 3]) -> [T; 3] {
        // Without -0.
        let negative = |v: T| T::ZERO - v;
        match self {
            Self::PositiveX => [negative(y), x, z],
            Self::NegativeX => [y, negative(x), z],
            Self::PositiveY => [x, y, z],
            Self::NegativeY => [negative(x), negative(y), z],
            Self::PositiveZ => [x, z, negative(y)],
            Self::NegativeZ => [x, negative(z), y],
        }
    }
}

/// A number that is 0.
pub(crate) trait Zero {
    const ZERO: Self;
}

impl Zero for f32 {
    const ZERO: Self = 0.0;
}

impl Zero for f64 {
    const ZERO: Self = 0.0;
}

/// Axes of a model file in a [`Scene`](crate::Scene), where +Y is up and models face +Z.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Orientation {
    /// Axis of the file that is up.
    pub up: Axis,
    /// True if the file's format defines the direction that models face. Where it does not (OBJ, PLY), an automatic
    /// view looks for a head: see [`Framing::automatic`](crate::Framing::automatic).
    pub front_is_known: bool,
    /// True for a file whose model faces away from [`Axis::front`], as avatars of VRM 0 do: it is turned by half a turn.
    pub is_turned: bool,
    /// True if `up` is not the usual axis of the file's format, but the one on which the model stands by its shape:
    /// [`Scene::up_by_shape`](crate::Scene::up_by_shape).
    pub up_is_by_shape: bool,
}

impl Default for Orientation {
    /// Orientation of glTF, and of scenes that no file describes.
    fn default() -> Self {
        Self { up: Axis::PositiveY, front_is_known: true, is_turned: false, up_is_by_shape: false }
    }
}

impl Orientation {
    /// Direction in the file in which the model faces.
    #[must_use]
    pub fn front(self) -> Axis {
        let front = self.up.front();
        if self.is_turned { front.opposite() } else { front }
    }

    /// Coordinates of the file in a scene: what is up becomes +Y and the front +Z. An exchange of coordinates and signs, so
    /// that no bit of a number is lost.
    pub(crate) fn upright<T: Copy + Zero + Sub<Output = T>>(self, point: [T; 3]) -> [T; 3] {
        let [x, y, z] = self.up.upright(point);
        // Without -0.
        if self.is_turned { [T::ZERO - x, y, T::ZERO - z] } else { [x, y, z] }
    }
}

/// The camera, in a scene of a file whose axes lie so.
pub(crate) fn upright_camera(camera: &Camera, file: Orientation) -> Camera {
    Camera {
        eye: file.upright(camera.eye),
        target: file.upright(camera.target),
        up: file.upright(camera.up),
        ..*camera
    }
}

/// The light, in a scene of a file whose axes lie so.
pub(crate) fn upright_light(light: &Light, file: Orientation) -> Light {
    let turn = |v: &mut [f32; 3]| *v = file.upright(*v);
    let mut light = *light;
    match &mut light.kind {
        LightKind::Directional { direction } => turn(direction),
        LightKind::Point { position, .. } => turn(position),
        LightKind::Spot { position, direction, .. } => {
            turn(position);
            turn(direction);
        }
        LightKind::Rect { position, half_width, half_height, .. } => {
            turn(position);
            turn(half_width);
            turn(half_height);
        }
        LightKind::Tube { ends, .. } => ends.iter_mut().for_each(turn),
    }
    light
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_lead_back() {
        for &axis in Axis::ALL {
            assert_eq!(Axis::from_name(axis.name()), Some(axis));
        }
        assert_eq!(Axis::from_name("z"), Some(Axis::PositiveZ));
        assert_eq!(Axis::from_name("-X"), Some(Axis::NegativeX));
        for bad in ["", "+", "-", "w", "++x", "0,1,0", "+-x", "xy"] {
            assert_eq!(Axis::from_name(bad), None, "{bad}");
        }
    }

    /// Up is up, the front is in front, and nothing is mirrored.
    #[test]
    fn models_are_turned_and_not_mirrored() {
        let unit = |axis: Axis| {
            let (sign, letter) = axis.name().split_at(1);
            let mut v = [0.0_f64; 3];
            v[["x", "y", "z"].iter().position(|l| *l == letter).unwrap()] =
                if sign == "-" { -1.0 } else { 1.0 };
            v
        };
        let files = Axis::ALL.iter().flat_map(|&up| {
            [false, true].map(|is_turned| Orientation { up, is_turned, ..Orientation::default() })
        });
        for file in files {
            assert_eq!(file.upright(unit(file.up)), [0.0, 1.0, 0.0], "{file:?}");
            assert_eq!(file.upright(unit(file.front())), [0.0, 0.0, 1.0], "{file:?}");
            let [a, b, c] =
                [Axis::PositiveX, Axis::PositiveY, Axis::PositiveZ].map(|k| file.upright(unit(k)));
            let cross = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
            assert_eq!(cross, c, "{file:?}");
            assert!(file.upright([0.0_f64; 3]).iter().all(|v| v.to_bits() == 0), "{file:?}");
        }
    }
}
