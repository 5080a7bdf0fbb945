//! Poses of cameras as matrices, in the conventions of the field.

use super::{Camera, Projection, SceneError};
use glam::DVec3;

/// Largest deviation of an axis' length from 1, and of the cosine between two axes from 0.
const TOLERANCE: f64 = 1e-4;
/// Distance of a target from the eye, in the eye's largest coordinate or metres: single precision keeps the direction to
/// 1e-7.
const TO_TARGET: f64 = 8.0;

/// Meaning of a 4 x 4 matrix as the pose of a camera.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PoseConvention {
    /// World to camera, the extrinsics `[R t; 0 1]` of OpenCV, COLMAP and the BOP data sets: a point of the world times the
    /// matrix is one of the camera, with +X right, +Y down and +Z forward.
    OpenCv,
    /// Camera to world, the pose of pyrender, glTF, Blender and NeRF data sets: a point of the camera, with +X right, +Y up
    /// and -Z forward, times the matrix is one of the world. The last column is the camera's position.
    OpenGl,
}

/// Position and axes of a camera in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Position in metres.
    pub position: [f64; 3],
    /// Right, up and back (towards the viewer), of unit length and perpendicular.
    pub axes: [[f64; 3]; 3],
}

impl PoseConvention {
    /// All conventions.
    pub const ALL: &[Self] = &[Self::OpenCv, Self::OpenGl];

    /// Its name: `opencv` or `opengl`.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::OpenCv => "opencv",
            Self::OpenGl => "opengl",
        }
    }
}

impl std::fmt::Display for PoseConvention {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

impl Pose {
    /// The pose that a matrix, row by row, is in a convention. Lengths of axes within 1e-4 of 1 and cosines between them within
    /// 1e-4 of 0 count as rounding, and are made exact.
    ///
    /// # Errors
    /// [`SceneError::Pose`] of a matrix that is not finite, not one of motions, scaled, sheared or mirrored.
    pub fn from_matrix(matrix: [[f64; 4]; 4], convention: PoseConvention) -> Result<Self, SceneError> {
        let wrong = |reason: String| Err(SceneError::Pose { reason });
        for (row, column) in (0..4).flat_map(|row| (0..4).map(move |column| (row, column))) {
            let value = matrix[row][column];
            if !value.is_finite() {
                return wrong(format!("element [{row}][{column}] is {value}, expected a finite number"));
            }
        }
        let [.., last] = matrix;
        if last != [0.0, 0.0, 0.0, 1.0] {
            return wrong(format!("its last row is {last:?}, expected [0, 0, 0, 1]"));
        }
        let [x, y, z, t]: [DVec3; 4] =
            std::array::from_fn(|c| DVec3::new(matrix[0][c], matrix[1][c], matrix[2][c]));
        for (name, axis) in [("x", x), ("y", y), ("z", z)] {
            let length = axis.dot(axis).sqrt();
            if (length - 1.0).abs() > TOLERANCE {
                return wrong(format!(
                    "it scales: column {name} of its rotation has a length of {length}, expected 1 (within 0.0001)"
                ));
            }
        }
        for (name, cosine) in [("x and y", x.dot(y)), ("y and z", y.dot(z)), ("z and x", z.dot(x))] {
            if cosine.abs() > TOLERANCE {
                return wrong(format!(
                    "it shears: columns {name} of its rotation have a cosine of {cosine}, expected 0 (within 0.0001)"
                ));
            }
        }
        let determinant = x.dot(y.cross(z));
        if determinant < 0.0 {
            return wrong("it mirrors: the determinant of its rotation is -1, expected 1".to_owned());
        }
        let (position, [right, up, back]) = match convention {
            PoseConvention::OpenGl => (t, [x, y, z]),
            PoseConvention::OpenCv => {
                let row = |r: usize| DVec3::new(matrix[r][0], matrix[r][1], matrix[r][2]);
                // The point that the matrix takes to zero, by Cramer's rule.
                let solve = |a: DVec3, b: DVec3| -t.dot(a.cross(b)) / determinant;
                (DVec3::new(solve(y, z), solve(z, x), solve(x, y)), [row(0), -row(1), -row(2)])
            }
        };
        // The view direction counts most, then up.
        let unit = |v: DVec3| v / v.dot(v).sqrt();
        let back = unit(back);
        let right = unit(if up.cross(back).dot(right) > 0.0 { up.cross(back) } else { right });
        let axes = [right, back.cross(right), back].map(|axis| axis.to_array());
        Ok(Self { position: position.to_array(), axes })
    }

    /// The matrix, row by row, in a convention.
    #[must_use]
    pub fn matrix(&self, convention: PoseConvention) -> [[f64; 4]; 4] {
        let [right, up, back] = self.axes;
        let mut rows = [[0.0, 0.0, 0.0, 1.0]; 4];
        match convention {
            PoseConvention::OpenGl => {
                for (k, row) in rows.iter_mut().take(3).enumerate() {
                    *row = [right[k], up[k], back[k], self.position[k]];
                }
            }
            PoseConvention::OpenCv => {
                let axes = [right, up.map(|v| -v), back.map(|v| -v)];
                for (row, axis) in rows.iter_mut().zip(axes) {
                    let along: f64 = axis.iter().zip(self.position).map(|(a, p)| a * p).sum();
                    let [x, y, z] = axis;
                    *row = [x, y, z, -along];
                }
            }
        }
        // No zero has a sign.
        rows.map(|row| row.map(|v| v + 0.0))
    }
}

impl Camera {
    /// A camera at a pose. Its target lies on the optical axis, so far away that single precision keeps the direction for those
    /// who ask eye, target and up.
    ///
    /// # Errors
    /// As [`Camera::validate`].
    pub fn at_pose(pose: &Pose, projection: Projection, near: f32) -> Result<Self, SceneError> {
        let eye = pose.position.map(|v| v as f32);
        let [_, up, back] = pose.axes;
        let size = eye.iter().fold(1.0_f64, |most, &v| most.max(f64::from(v).abs()));
        let target = std::array::from_fn(|k| (f64::from(eye[k]) - back[k] * size * TO_TARGET) as f32);
        let mut camera = Self::new(eye, target, up.map(|v| v as f32), projection, near);
        camera.orientation = Some(pose.axes);
        camera.validate()?;
        Ok(camera)
    }

    /// The pose of the camera.
    ///
    /// # Errors
    /// [`SceneError::DegenerateCamera`] if it spans no view.
    pub fn pose(&self) -> Result<Pose, SceneError> {
        Ok(Pose { position: self.eye.map(f64::from), axes: self.axes()? })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Turned by the angle of a triangle of sides 3, 4 and 5 about +Y.
    const OPENGL: [[f64; 4]; 4] =
        [[0.8, 0.0, 0.6, 3.0], [0.0, 1.0, 0.0, 1.0], [-0.6, 0.0, 0.8, 4.0], [0.0, 0.0, 0.0, 1.0]];
    const OPENCV: [[f64; 4]; 4] =
        [[0.8, 0.0, -0.6, 0.0], [0.0, -1.0, 0.0, 1.0], [-0.6, 0.0, -0.8, 5.0], [0.0, 0.0, 0.0, 1.0]];

    fn near(a: [[f64; 4]; 4], b: [[f64; 4]; 4]) -> bool {
        a.as_flattened().iter().zip(b.as_flattened()).all(|(a, b)| (a - b).abs() < 1e-14)
    }

    #[test]
    fn each_convention_is_the_other_ones_inverse_with_two_axes_turned() {
        let poses = [(OPENGL, PoseConvention::OpenGl), (OPENCV, PoseConvention::OpenCv)]
            .map(|(matrix, convention)| Pose::from_matrix(matrix, convention).expect("a motion"));
        for pose in poses {
            assert!(near(pose.matrix(PoseConvention::OpenGl), OPENGL), "{pose:?}");
            assert!(near(pose.matrix(PoseConvention::OpenCv), OPENCV), "{pose:?}");
        }
        // A camera looks at where it is told to, and tells its pose again.
        let projection = Projection::Perspective { fov_y: 0.5 };
        let camera = Camera::at_pose(&poses[0], projection, 0.01).expect("a camera");
        assert_eq!(camera.pose(), Ok(poses[0]));
        let looked = Camera { orientation: None, ..camera }.axes().expect("a view");
        let apart =
            looked.as_flattened().iter().zip(poses[0].axes.as_flattened()).map(|(a, b)| (a - b).abs());
        assert!(apart.fold(0.0, f64::max) < 2e-7, "{looked:?}");
    }

    #[test]
    fn rounded_rotations_are_made_exact() {
        let mut matrix = OPENGL.map(|row| row.map(|v| v + 3e-6));
        matrix[3] = OPENGL[3];
        let pose = Pose::from_matrix(matrix, PoseConvention::OpenGl).expect("a motion");
        let [x, y, z] = pose.axes.map(DVec3::from);
        let off = [x.dot(x) - 1.0, y.dot(y) - 1.0, z.dot(z) - 1.0, x.dot(y), y.dot(z), z.dot(x)];
        assert!(off.iter().all(|v| v.abs() < 1e-15), "{off:?}");
    }

    #[test]
    fn what_is_no_motion_is_named() {
        let of = |change: &dyn Fn(&mut [[f64; 4]; 4])| {
            let mut matrix = OPENGL;
            change(&mut matrix);
            Pose::from_matrix(matrix, PoseConvention::OpenGl).expect_err("no motion").to_string()
        };
        assert_eq!(
            of(&|m| m[1][2] = f64::NAN),
            "camera pose: element [1][2] is NaN, expected a finite number"
        );
        assert!(of(&|m| m[3][3] = 2.0).contains("its last row is [0.0, 0.0, 0.0, 2.0]"));
        assert!(
            of(&|m| m[1][1] = 1.001).contains("it scales: column y of its rotation has a length of 1.001")
        );
        assert!(of(&|m| (m[1][0], m[0][0]) = (0.001, 0.8)).contains("it shears: columns x and y"));
        assert!(of(&|m| m[1][1] = -1.0).contains("it mirrors"));
        assert!(of(&|m| *m = [[0.0; 4]; 4]).contains("last row"));
        let broken = Some([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, f64::NAN]]);
        let camera = Camera::new(
            [0.0, 0.0, 1.0],
            [0.0; 3],
            [0.0, 1.0, 0.0],
            Projection::Orthographic { height: 1.0 },
            0.1,
        );
        assert_eq!(Camera { orientation: broken, ..camera }.validate(), Err(SceneError::DegenerateCamera));
    }
}
