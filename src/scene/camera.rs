//! Where a picture is taken from.

use super::error::{finite, within};
use super::{MAX_COORDINATE, SceneError};
use glam::DVec3;

/// How depth becomes size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// A pinhole.
    Perspective {
        /// Vertical field of view in radians, above 0 and below pi.
        fov_y: f32,
    },
    /// A parallel projection.
    Orthographic {
        /// Height of the view in metres, above 0.
        height: f32,
    },
}

/// A camera in world space: +Y up, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Where it is.
    pub eye: [f32; 3],
    /// What is in the centre of the picture.
    pub target: [f32; 3],
    /// Which way is up; need not be perpendicular to the view.
    pub up: [f32; 3],
    /// Perspective or orthographic.
    pub projection: Projection,
    /// Distance in metres along the view direction before which nothing is drawn, at least 1e-18. There is no far
    /// limit.
    pub near: f32,
}

impl Camera {
    /// Smallest distance of the near plane in metres.
    pub const MIN_NEAR: f32 = 1e-18;

    /// The view's axes in world space: right, up and backward (towards the viewer), of unit length.
    ///
    /// # Errors
    /// [`SceneError::DegenerateCamera`] if eye and target coincide or up points along the view.
    pub fn axes(&self) -> Result<[[f64; 3]; 3], SceneError> {
        let v = |a: [f32; 3]| DVec3::from(a.map(f64::from));
        let unit = |a: DVec3| {
            let length = (a.x * a.x + a.y * a.y + a.z * a.z).sqrt();
            (length > 1e-30 && length.is_finite()).then(|| a / length).ok_or(SceneError::DegenerateCamera)
        };
        let back = unit(v(self.eye) - v(self.target))?;
        let side = unit(v(self.up))?.cross(back);
        if side.x * side.x + side.y * side.y + side.z * side.z < 1e-12 {
            return Err(SceneError::DegenerateCamera);
        }
        let right = unit(side)?;
        Ok([right.to_array(), back.cross(right).to_array(), back.to_array()])
    }

    /// Checks that the camera spans a view and its numbers are in range.
    ///
    /// # Errors
    /// [`SceneError`] naming the number that is not.
    pub fn validate(&self) -> Result<(), SceneError> {
        // A camera that sees all of the largest model stands outside of it.
        let far = 1e3 * MAX_COORDINATE;
        within("camera eye", &self.eye, -far, far)?;
        within("camera target", &self.target, -far, far)?;
        finite("camera up", &self.up)?;
        within("camera near distance", &[self.near], Self::MIN_NEAR, far)?;
        match self.projection {
            Projection::Perspective { fov_y } => {
                within("camera field of view", &[fov_y], 1e-3, std::f32::consts::PI - 1e-3)?;
            }
            Projection::Orthographic { height } => {
                within("camera view height", &[height], 1e-15, far)?;
            }
        }
        self.axes().map(|_| ())
    }
}
