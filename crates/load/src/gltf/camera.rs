//! Cameras in world space.

use super::list::label;
use super::model;
use crate::budget::Budget;
use crate::warnings::Warnings;
use overcoat_core::limits::LimitExceeded;
use overcoat_scene::{Camera, MAX_COORDINATE, Projection, Scene, Transform};

/// Smallest and largest vertical field of view in radians.
const FIELD: (f64, f64) = (1e-3, std::f64::consts::PI - 1e-3);

/// Charges the copy of a camera that a node makes, with its name.
///
/// # Errors
/// [`LimitExceeded`] naming the camera.
pub(super) fn charge(camera: &model::Camera, index: usize, budget: &mut Budget) -> Result<(), LimitExceeded> {
    const BYTES: usize = size_of::<Camera>() + size_of::<String>();
    let size = camera.name.as_ref().map_or(0, String::len).saturating_add(BYTES);
    budget.charge(|| name(camera, index), size as u64, 1)
}

/// Adds a camera that stands at `transform` and looks along its -Z. One that cannot see anything is left out with a
/// warning.
pub(super) fn add(
    scene: &mut Scene,
    camera: &model::Camera,
    index: usize,
    transform: &Transform,
    warnings: &mut Warnings,
) {
    let (projection, near) = match (&camera.perspective, &camera.orthographic) {
        (Some(p), _) => {
            let fov_y = p.yfov.clamp(FIELD.0, FIELD.1) as f32;
            (Projection::Perspective { fov_y }, p.znear)
        }
        (None, Some(o)) => (Projection::Orthographic { height: (2.0 * o.ymag.abs()) as f32 }, o.znear),
        (None, None) => {
            warnings.add(|| format!("{} has no projection and is left out", name(camera, index)));
            return;
        }
    };
    let eye = transform.point([0.0; 3]);
    let (Some(forward), Some(up)) =
        (unit(transform.direction([0.0, 0.0, -1.0])), unit(transform.direction([0.0, 1.0, 0.0])))
    else {
        warnings.add(|| format!("{} is scaled to nothing and is left out", name(camera, index)));
        return;
    };
    // Far from the origin, a target one metre away would be rounded onto the eye.
    let distance = eye.iter().fold(1.0_f64, |d, v| if v.abs() > d { v.abs() } else { d });
    let ([x, y, z], [dx, dy, dz]) = (eye, forward);
    let own_name = camera.name.clone().unwrap_or_default();
    let result = scene.add_named_camera(
        own_name,
        Camera::new(
            eye.map(|v| v as f32),
            [x + distance * dx, y + distance * dy, z + distance * dz].map(|v| v as f32),
            up.map(|v| v as f32),
            projection,
            near.clamp(f64::from(Camera::MIN_NEAR), f64::from(MAX_COORDINATE)) as f32,
        ),
    );
    if let Err(error) = result {
        warnings.add(|| format!("{} is left out: {error}", name(camera, index)));
    }
}

fn name(camera: &model::Camera, index: usize) -> String {
    label::<model::Camera>(index, camera.name.as_deref())
}

/// A vector of unit length, unless it has none.
pub(super) fn unit(v: [f64; 3]) -> Option<[f64; 3]> {
    let length = (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
    (length > 1e-150 && length.is_finite()).then(|| v.map(|v| v / length))
}
