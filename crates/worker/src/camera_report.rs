//! The camera that a picture was taken with, as `--json` tells it.

use overcoat_render::RenderOptions;
use overcoat_scene::{Camera, CameraMatrices, Projection, Scene};
use serde::Serialize;

/// Options that make the same picture again: `--eye`, `--target`, `--camera-up`, `--near`, and `--fov`, `--ortho=HEIGHT` or
/// `--intrinsics`. In the coordinates of the scene, the upright model.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct CameraReport {
    eye: [f64; 3],
    target: [f64; 3],
    up: [f32; 3],
    projection: &'static str,
    /// Vertical field of view, of perspective cameras without intrinsics.
    fov_y_degrees: Option<f32>,
    /// Height of the view in metres, of orthographic cameras.
    height: Option<f32>,
    /// Distance in metres before which nothing is drawn.
    near: f32,
    /// Distance in metres beyond which no surface is drawn, if there is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    far: Option<f32>,
    /// Matrices, of the picture that is `size` pixels large.
    #[serde(flatten)]
    matrices: Option<MatricesReport>,
}

/// Matrices of a camera, row by row: [`CameraMatrices`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
struct MatricesReport {
    size: [u32; 2],
    k: [[f64; 3]; 3],
    pose: PoseReport,
}

/// Pose by convention.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
struct PoseReport {
    /// World to camera.
    opencv: [[f64; 4]; 4],
    /// Camera to world.
    opengl: [[f64; 4]; 4],
}

impl From<CameraMatrices> for MatricesReport {
    fn from(of: CameraMatrices) -> Self {
        let pose = PoseReport { opencv: of.world_to_camera, opengl: of.camera_to_world };
        Self { size: [of.width, of.height], k: of.k, pose }
    }
}

impl CameraReport {
    /// Report on a camera and a picture of these options. The scene's origin is added to eye and target.
    pub fn new(camera: &Camera, scene: &Scene, options: &RenderOptions) -> Self {
        let &Camera { eye, target, up, projection, near, far, .. } = camera;
        let origin = scene.origin();
        let [eye, target] = [eye, target].map(|p| std::array::from_fn(|k| f64::from(p[k]) + origin[k]));
        let (projection, fov_y_degrees, height) = match projection {
            Projection::Perspective { fov_y } => ("perspective", Some(degrees(fov_y)), None),
            Projection::Intrinsics(_) => ("perspective", None, None),
            Projection::Orthographic { height } => ("orthographic", None, Some(height)),
        };
        let far = far.is_finite().then_some(far);
        // A camera that has taken a picture has matrices.
        let matrices = camera.matrices(origin, options.width, options.height).ok().map(MatricesReport::from);
        Self { eye, target, up, projection, fov_y_degrees, height, near, far, matrices }
    }
}

/// Degrees that are this angle when they are made radians again. Where there are none (of some angles of files), the nearest.
fn degrees(radians: f32) -> f32 {
    let nearest = radians.to_degrees();
    let around = (-4..=4_i32).map(|steps| f32::from_bits(nearest.to_bits().saturating_add_signed(steps)));
    let mut same = around.filter(|degrees| degrees.to_radians() == radians);
    // The shortest to write, which is what somebody has asked for.
    let first = same.next();
    same.chain(first).min_by_key(|degrees| degrees.to_string().len()).unwrap_or(nearest)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn degrees_come_back() {
        for tenths in 1..1790 {
            let given = tenths as f32 / 10.0;
            assert_eq!(degrees(given.to_radians()), given);
        }
        assert_eq!(degrees(std::f32::consts::FRAC_PI_6), 30.0);
    }
}
