//! Cameras: viewpoint, projection and clipping distances.

use super::error::{finite, unit, within};
use super::{Intrinsics, MAX_COORDINATE, PoseConvention, SceneError, Transform};
use glam::DVec3;

/// Projection of the view onto the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// Perspective projection of a pinhole camera.
    Perspective {
        /// Vertical field of view in radians, above 0 and below pi.
        fov_y: f32,
    },
    /// A parallel projection.
    Orthographic {
        /// Height of the view in metres, above 0.
        height: f32,
    },
    /// Perspective projection of a calibrated pinhole camera: focal lengths and principal point in pixels. Pictures have the
    /// shape of the one that these are for.
    Intrinsics(Intrinsics),
}

/// Matrices of a camera and of the picture that it takes, for programs that compute with them.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct CameraMatrices {
    /// True of a pinhole; false of a parallel projection.
    pub perspective: bool,
    /// Width of the picture in pixels.
    pub width: u32,
    /// Height of the picture in pixels.
    pub height: u32,
    /// Matrix K, row by row, of [`Intrinsics`]: pixels for a point of the camera (X right, Y down) at a distance Z of 1. Of a
    /// parallel projection, for a point at any distance: `u = K[0][0] X + K[0][2]`.
    pub k: [[f64; 3]; 3],
    /// World to camera: [`PoseConvention::OpenCv`].
    pub world_to_camera: [[f64; 4]; 4],
    /// Camera to world: [`PoseConvention::OpenGl`].
    pub camera_to_world: [[f64; 4]; 4],
    /// Distance of the near plane in metres.
    pub near: f32,
    /// Distance of the far limit in metres; infinity without one.
    pub far: f32,
}

/// A camera in world space: +Y up, metres.
///
/// ```
/// # mod overcoat { pub use overcoat_scene as scene; }
/// use overcoat::scene::Camera;
///
/// # fn main() -> Result<(), overcoat::scene::SceneError> {
/// // From the right, the front and above, with 35 degrees from the lower to the upper border.
/// let camera = Camera::look_at([3.0, 2.0, 4.0], [0.0; 3], [0.0, 1.0, 0.0])?.perspective(35_f32.to_radians())?;
/// // The plan of it: from above, two metres high, -Z at the upper border.
/// let plan = Camera::look_at([0.0, 5.0, 0.0], [0.0; 3], [0.0, 0.0, -1.0])?.orthographic(2.0)?;
/// # assert_eq!((camera.up, plan.up), ([0.0, 1.0, 0.0], [0.0, 0.0, -1.0]));
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Camera {
    /// Position of the viewer in world space, metres.
    pub eye: [f32; 3],
    /// Point in the centre of the picture, in world space, metres; with [`Projection::Intrinsics`] at the principal point.
    pub target: [f32; 3],
    /// Up vector, of any length above 1e-30; need not be perpendicular to the view.
    pub up: [f32; 3],
    /// Right, up and back of the view, of unit length and perpendicular within 1e-6, in place of the directions that follow from
    /// eye, target and up: cameras by a [`Pose`](super::Pose) keep its double precision.
    pub orientation: Option<[[f64; 3]; 3]>,
    /// Perspective or orthographic.
    pub projection: Projection,
    /// Near plane: distance in metres along the view direction before which nothing is drawn, at least 1e-18.
    pub near: f32,
    /// Far plane: distance in metres along the view direction beyond which no surface is drawn, above
    /// [`Camera::near`]; infinity for no limit. The floor and the environment are not surfaces of the scene: they
    /// stay.
    pub far: f32,
}

impl Camera {
    /// Smallest distance of the near plane in metres.
    pub const MIN_NEAR: f32 = 1e-18;

    /// A camera of these numbers, which are those of its fields, without a far limit. They are checked when it is used: see [`Camera::validate`].
    #[must_use]
    pub fn new(eye: [f32; 3], target: [f32; 3], up: [f32; 3], projection: Projection, near: f32) -> Self {
        Self { eye, target, up, orientation: None, projection, near, far: f32::INFINITY }
    }

    /// A camera at `eye` with `target` in the centre of its picture, both in metres. `up` may have any length but zero and
    /// need not be perpendicular to the view.
    ///
    /// It is a pinhole with the field of view of [`super::Framing`], 30 degrees, and draws nothing nearer than a thousandth of
    /// the distance to the target: see [`Camera::perspective`], [`Camera::orthographic`] and [`Camera::near_from`].
    ///
    /// # Errors
    /// [`SceneError::NotFinite`] and [`SceneError::OutOfRange`] of a number; [`SceneError::NoLength`] if `up` is zero;
    /// [`SceneError::DegenerateCamera`] if eye and target coincide or up points along the view.
    pub fn look_at(eye: [f32; 3], target: [f32; 3], up: [f32; 3]) -> Result<Self, SceneError> {
        let projection = Projection::Perspective { fov_y: std::f32::consts::FRAC_PI_6 };
        Self::new(eye, target, unit("camera up", up)?, projection, Self::usual_near(eye, target)).checked()
    }

    /// The camera, moved by a transform; distances are scaled as lengths are.
    ///
    /// # Errors
    /// [`SceneError`] if it then spans no view, or a number of it is not finite or out of its range.
    pub fn transformed(&self, by: &Transform) -> Result<Self, SceneError> {
        let point = |p: [f32; 3]| by.point(p.map(f64::from)).map(|c| c as f32);
        let scale = by.uniform_scale();
        let length = |l: f32| (f64::from(l) * scale) as f32;
        let projection = match self.projection {
            Projection::Orthographic { height } => Projection::Orthographic { height: length(height) },
            perspective @ (Projection::Perspective { .. } | Projection::Intrinsics(_)) => perspective,
        };
        Self {
            eye: point(self.eye),
            target: point(self.target),
            up: unit("camera up", by.direction(self.up.map(f64::from)).map(|c| c as f32))?,
            orientation: None,
            projection,
            near: length(self.near),
            far: length(self.far),
        }
        .checked()
    }

    /// Default distance of the near plane: a thousandth of the distance from eye to target.
    pub fn usual_near(eye: [f32; 3], target: [f32; 3]) -> f32 {
        let [x, y, z] = [0, 1, 2].map(|k| f64::from(eye[k]) - f64::from(target[k]));
        let near = (1e-3 * (x * x + y * y + z * z).sqrt()) as f32;
        if near > Self::MIN_NEAR { near } else { Self::MIN_NEAR }
    }

    /// The same camera as a pinhole with a vertical field of view in radians, 0.001 to pi - 0.001.
    ///
    /// # Errors
    /// As [`Camera::validate`].
    pub fn perspective(self, fov_y: f32) -> Result<Self, SceneError> {
        Self { projection: Projection::Perspective { fov_y }, ..self }.checked()
    }

    /// The same camera with a parallel projection whose picture is `height` metres high, 1e-15 to 1e18.
    ///
    /// # Errors
    /// As [`Camera::validate`].
    pub fn orthographic(self, height: f32) -> Result<Self, SceneError> {
        Self { projection: Projection::Orthographic { height }, ..self }.checked()
    }

    /// The same camera with intrinsics.
    ///
    /// # Errors
    /// As [`Camera::validate`].
    pub fn intrinsics(self, intrinsics: Intrinsics) -> Result<Self, SceneError> {
        Self { projection: Projection::Intrinsics(intrinsics), ..self }.checked()
    }

    /// The same camera that draws nothing nearer than a distance in metres along the view, [`Camera::MIN_NEAR`] to 1e18.
    ///
    /// # Errors
    /// As [`Camera::validate`].
    pub fn near_from(self, near: f32) -> Result<Self, SceneError> {
        Self { near, ..self }.checked()
    }

    /// The same camera that draws nothing farther than a distance in metres along the view, above [`Camera::near`].
    ///
    /// # Errors
    /// As [`Camera::validate`].
    pub fn far_to(self, far: f32) -> Result<Self, SceneError> {
        Self { far, ..self }.checked()
    }

    fn checked(self) -> Result<Self, SceneError> {
        self.validate()?;
        Ok(self)
    }

    /// The view's axes in world space: right, up and backward (towards the viewer), of unit length.
    ///
    /// # Errors
    /// [`SceneError::DegenerateCamera`] if eye and target coincide or up points along the view.
    pub fn axes(&self) -> Result<[[f64; 3]; 3], SceneError> {
        if let Some(axes) = self.orientation {
            return if is_rotation(axes) { Ok(axes) } else { Err(SceneError::DegenerateCamera) };
        }
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

    /// The matrix K of a picture of that size, as [`CameraMatrices::k`] has it: of every projection.
    ///
    /// # Errors
    /// [`SceneError::IntrinsicsSize`] if intrinsics are those of a picture of another shape.
    pub fn matrix_k(&self, width: u32, height: u32) -> Result<[[f64; 3]; 3], SceneError> {
        let [half_width, half_height] = [width, height].map(|side| f64::from(side) * 0.5);
        let scale = match self.projection {
            Projection::Perspective { fov_y } => {
                half_height / overcoat_core::math::tan_half(f64::from(fov_y))
            }
            Projection::Orthographic { height } => half_height / (f64::from(height) * 0.5),
            Projection::Intrinsics(intrinsics) => return Ok(intrinsics.resized([width, height])?.matrix()),
        };
        Ok([[scale, 0.0, half_width], [0.0, scale, half_height], [0.0, 0.0, 1.0]])
    }

    /// Matrices of a picture of that size, in a scene whose origin lies at `origin` of the file's coordinates
    /// ([`Scene::origin`](super::Scene::origin)).
    ///
    /// # Errors
    /// [`SceneError`] if the camera spans no view, or its intrinsics are those of a picture of another shape.
    pub fn matrices(&self, origin: [f64; 3], width: u32, height: u32) -> Result<CameraMatrices, SceneError> {
        let mut pose = self.pose()?;
        pose.position.iter_mut().zip(origin).for_each(|(v, by)| *v += by);
        Ok(CameraMatrices {
            perspective: !matches!(self.projection, Projection::Orthographic { .. }),
            width,
            height,
            k: self.matrix_k(width, height)?,
            world_to_camera: pose.matrix(PoseConvention::OpenCv),
            camera_to_world: pose.matrix(PoseConvention::OpenGl),
            near: self.near,
            far: self.far,
        })
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
        // False of NaN, too.
        let is_beyond = self.far > self.near;
        if !is_beyond {
            return Err(SceneError::OutOfRange { what: "camera far distance", limit: self.near });
        }
        match self.projection {
            Projection::Perspective { fov_y } => {
                within("camera field of view", &[fov_y], 1e-3, std::f32::consts::PI - 1e-3)?;
            }
            Projection::Orthographic { height } => {
                within("camera view height", &[height], 1e-15, far)?;
            }
            Projection::Intrinsics(intrinsics) => intrinsics.validate()?,
        }
        self.axes().map(|_| ())
    }
}

/// True of three axes of unit length, perpendicular and right-handed.
fn is_rotation(axes: [[f64; 3]; 3]) -> bool {
    let [x, y, z] = axes.map(DVec3::from);
    let off = |found: f64, expected: f64| (found - expected).abs();
    // Written so that a NaN is none.
    [
        off(x.dot(x), 1.0),
        off(y.dot(y), 1.0),
        off(z.dot(z), 1.0),
        off(x.dot(y), 0.0),
        off(z.dot(x.cross(y)), 1.0),
    ]
    .iter()
    .all(|off| *off < 1e-6)
}

#[cfg(test)]
mod tests {
    use super::*;

    const UP: [f32; 3] = [0.0, 1.0, 0.0];

    #[test]
    fn axes_are_those_of_the_view_whatever_the_length_of_up() {
        for up in [UP, [0.0, 1e-40, 0.0], [0.0, 3e38, 0.0], [0.0, 2.0, 2.0]] {
            let camera = Camera::look_at([0.0, 0.0, 5.0], [0.0; 3], up).unwrap();
            assert_eq!(camera.axes().unwrap(), [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], "{up:?}");
            assert_eq!(camera.near, 5e-3);
        }
    }

    #[test]
    fn what_spans_no_view_is_an_error_at_the_door() {
        let look = |eye, up| Camera::look_at(eye, [0.0; 3], up).unwrap_err();
        assert_eq!(look([0.0, 0.0, 1.0], [0.0; 3]), SceneError::NoLength { what: "camera up" });
        assert_eq!(look([0.0, 0.0, 1.0], [0.0, f32::NAN, 0.0]), SceneError::NotFinite { what: "camera up" });
        assert_eq!(look([f32::INFINITY, 0.0, 1.0], UP), SceneError::NotFinite { what: "camera eye" });
        assert_eq!(look([0.0; 3], UP), SceneError::DegenerateCamera);
        assert_eq!(look([0.0, 3.0, 0.0], UP), SceneError::DegenerateCamera);
    }

    #[test]
    fn projections_are_checked() {
        let camera = Camera::look_at([1.0, 2.0, 3.0], [0.0; 3], UP).unwrap();
        let wide = camera.perspective(1.5).unwrap();
        assert_eq!(wide, Camera { projection: Projection::Perspective { fov_y: 1.5 }, ..camera });
        let parallel = camera.orthographic(2.0).unwrap().near_from(0.5).unwrap();
        assert_eq!((parallel.projection, parallel.near), (Projection::Orthographic { height: 2.0 }, 0.5));
        for bad in [0.0, -1.0, 4.0, f32::NAN] {
            assert!(camera.perspective(bad).is_err(), "{bad}");
        }
        for bad in [0.0, -1.0, f32::INFINITY] {
            assert!(camera.orthographic(bad).is_err() && camera.near_from(bad).is_err(), "{bad}");
        }
    }
}
