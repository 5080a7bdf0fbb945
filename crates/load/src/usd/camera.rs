//! Cameras (UsdGeomCamera): apertures and focal lengths in tenths of a scene's unit, as those of real cameras are in millimetres where
//! that is a centimetre.

use super::compose::Composed;
use overcoat_core::math::double::atan2;
use overcoat_scene::{Camera, MAX_COORDINATE, Projection, Transform};

/// Smallest and largest vertical field of view in radians.
const FIELD: (f64, f64) = (1e-3, std::f64::consts::PI - 1e-3);

/// The camera of a prim; `None` if it is scaled to nothing. Offsets of its aperture have no effect.
pub(super) fn read(prim: &Composed, transform: &Transform) -> Option<Camera> {
    let number =
        |name: &str, default: f64| prim.number(name).filter(|v| v.is_finite() && *v > 0.0).unwrap_or(default);
    let scale = transform.uniform_scale();
    let aperture = number("verticalAperture", 15.2908);
    let projection = if prim.text("projection").as_deref() == Some("orthographic") {
        Projection::Orthographic { height: (aperture / 10.0 * scale) as f32 }
    } else {
        let fov = 2.0 * atan2(0.5 * aperture, number("focalLength", 50.0));
        Projection::Perspective { fov_y: fov.clamp(FIELD.0, FIELD.1) as f32 }
    };
    let range = prim.value("clippingRange").and_then(|v| v.tuple::<2>()).unwrap_or([1.0, 1e6]);
    let near = (range[0] * scale).clamp(f64::from(Camera::MIN_NEAR), f64::from(MAX_COORDINATE)) as f32;
    let eye = transform.point([0.0; 3]);
    let ([dx, dy, dz], up) =
        (unit(transform.direction([0.0, 0.0, -1.0]))?, unit(transform.direction([0.0, 1.0, 0.0]))?);
    // Far from the origin, a target one metre away would be rounded onto the eye.
    let distance = eye.iter().fold(1.0_f64, |d, v| if v.abs() > d { v.abs() } else { d });
    let [x, y, z] = eye;
    let target = [x + distance * dx, y + distance * dy, z + distance * dz];
    let narrow = |v: [f64; 3]| v.map(|v| v as f32);
    Some(Camera::new(narrow(eye), narrow(target), narrow(up), projection, near))
}

/// A vector of unit length, unless it has none.
fn unit(v: [f64; 3]) -> Option<[f64; 3]> {
    let [x, y, z] = v;
    let length = (x * x + y * y + z * z).sqrt();
    (length > 1e-150 && length.is_finite()).then(|| v.map(|v| v / length))
}
