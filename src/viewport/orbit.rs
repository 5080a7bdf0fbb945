//! A camera that goes around a point, for a mouse or a finger.

use overcoat_core::math::double::sin_cos;
use overcoat_scene::{Camera, Framing, Projection, Scene};

/// Sine of the steepest view: a little less than straight down, where "up" would be lost.
const STEEPEST: f64 = 0.9998;
/// Distances from the point, in those that it began with.
const NEAREST: f64 = 1e-4;
const FARTHEST: f64 = 1e4;

/// Looks at a point from around it; +Y stays up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Orbit {
    target: [f64; 3],
    /// From the point to the camera, of unit length.
    back: [f64; 3],
    distance: f64,
    first_distance: f64,
    projection: Projection,
    /// Part of the distance before which nothing is drawn.
    near: f64,
    /// Camera that it was made of, bit for bit, until it moves.
    exact: Option<Camera>,
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

impl Orbit {
    /// Around a scene, which fills a picture of that aspect (width over height), from where it shows most.
    #[must_use]
    pub fn around(scene: &Scene, aspect: f32) -> Self {
        Self::from_camera(&Framing::automatic(scene).with_aspect(aspect).camera(scene))
    }

    /// From where a camera is, around what it looks at. Until it moves it is that camera; then +Y is up.
    #[must_use]
    pub fn from_camera(camera: &Camera) -> Self {
        let target = camera.target.map(f64::from);
        let away: [f64; 3] = std::array::from_fn(|k| f64::from(camera.eye[k]) - target[k]);
        let length = dot(away, away).sqrt();
        let (back, distance) =
            if length > 0.0 { (away.map(|v| v / length), length) } else { ([0.0, 0.0, 1.0], 1.0) };
        let orbit = Self {
            target,
            back,
            distance,
            first_distance: distance,
            projection: camera.projection,
            near: (f64::from(camera.near) / distance).min(1e-3),
            exact: None,
        };
        Self { exact: Some(*camera), ..orbit.with_height(back[1]) }
    }

    /// The camera.
    #[must_use]
    pub fn camera(&self) -> Camera {
        if let Some(exact) = self.exact {
            return exact;
        }
        let eye: [f64; 3] = std::array::from_fn(|k| self.target[k] + self.back[k] * self.distance);
        let projection = match self.projection {
            Projection::Orthographic { height } => Projection::Orthographic {
                height: (f64::from(height) * self.distance / self.first_distance) as f32,
            },
            perspective => perspective,
        };
        let near = (self.distance * self.near) as f32;
        Camera::new(
            eye.map(|v| v as f32),
            self.target.map(|v| v as f32),
            [0.0, 1.0, 0.0],
            projection,
            if near > Camera::MIN_NEAR { near } else { Camera::MIN_NEAR },
        )
    }

    /// Goes around by angles in radians: to the right, so that the scene turns to the left, and up. Up and down it stops a
    /// little before the poles.
    pub fn turn(&mut self, right: f64, up: f64) {
        if !(right.is_finite() && up.is_finite()) {
            return;
        }
        self.exact = None;
        // Angles beyond a turn say nothing more.
        let (sin, cos) = sin_cos(right % std::f64::consts::TAU);
        let [x, y, z] = self.back;
        self.back = [x * cos + z * sin, y, z * cos - x * sin];
        // A quarter turn reaches either pole from anywhere.
        let (sin, cos) = sin_cos(up.clamp(-std::f64::consts::PI, std::f64::consts::PI));
        let level = (1.0 - y * y).max(0.0).sqrt();
        let height = y * cos + level * sin;
        // Over the pole, the way along the ground would turn around.
        let passes = level * cos - y * sin <= 0.0;
        let pole = if up > 0.0 { STEEPEST } else { -STEEPEST };
        *self = self.with_height(if passes { pole } else { height });
    }

    /// Moves camera and point along the picture, by parts of its height: to the right and up.
    pub fn pan(&mut self, right: f64, up: f64) {
        if !(right.is_finite() && up.is_finite()) {
            return;
        }
        let height = match self.projection {
            Projection::Perspective { fov_y } => {
                2.0 * self.distance * overcoat_core::math::tan_half(f64::from(fov_y))
            }
            Projection::Intrinsics(own) => self.distance * f64::from(own.height) / own.fy,
            Projection::Orthographic { height } => f64::from(height) * self.distance / self.first_distance,
        };
        let [x, y, z] = self.back;
        let level = (x * x + z * z).sqrt();
        let (across, above) = ([z / level, 0.0, -x / level], [-x * y / level, level, -z * y / level]);
        let moved: [f64; 3] =
            std::array::from_fn(|k| self.target[k] + (across[k] * right + above[k] * up) * height);
        self.set_target(moved);
    }

    /// Comes closer by a factor: 2 is half the distance.
    pub fn zoom(&mut self, factor: f64) {
        if factor > 0.0 && factor.is_finite() {
            let [least, most] = [NEAREST, FARTHEST].map(|times| times * self.first_distance);
            self.distance = (self.distance / factor).clamp(least, most);
            self.exact = None;
        }
    }

    /// The point that it goes around.
    #[must_use]
    pub fn target(&self) -> [f64; 3] {
        self.target
    }

    /// Goes around another point, in world space; the view moves with it.
    pub fn set_target(&mut self, target: [f64; 3]) {
        if target.iter().all(|v| v.abs() < 1e15) {
            (self.target, self.exact) = (target, None);
        }
    }

    /// Orbit with the camera at another height over the point, in distances, as far as that is allowed.
    fn with_height(self, height: f64) -> Self {
        let y = height.clamp(-STEEPEST, STEEPEST);
        let [x, _, z] = self.back;
        let level = (x * x + z * z).sqrt();
        let ([x, z], level) = if level > 0.0 { ([x, z], level) } else { ([0.0, 1.0], 1.0) };
        let to = (1.0 - y * y).sqrt() / level;
        Self { back: [x * to, y, z * to], ..self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn orbit() -> Orbit {
        let camera = Camera::look_at([0.0, 0.0, 4.0], [0.0; 3], [0.0, 1.0, 0.0]).unwrap();
        Orbit::from_camera(&camera)
    }

    fn near(a: [f32; 3], b: [f32; 3]) {
        assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-3), "{a:?} is not {b:?}");
    }

    #[test]
    fn until_it_moves_it_is_the_camera_that_it_was_made_of() {
        let camera = Camera::look_at([0.1, 7.3, 4.7], [0.3, 0.2, 0.1], [0.0, 1.0, 0.1]).unwrap();
        let mut orbit = Orbit::from_camera(&camera);
        assert_eq!(orbit.camera(), camera);
        orbit.turn(0.0, 0.0);
        near(orbit.camera().eye, camera.eye);
        assert_eq!(orbit.camera().up, [0.0, 1.0, 0.0]);
    }

    #[test]
    fn it_goes_to_the_right_and_up() {
        let mut right = orbit();
        right.turn(std::f64::consts::FRAC_PI_2, 0.0);
        near(right.camera().eye, [4.0, 0.0, 0.0]);
        let mut up = orbit();
        up.turn(0.0, std::f64::consts::FRAC_PI_6);
        near(up.camera().eye, [0.0, 2.0, 3.4641]);
        for by in [3.0, -3.0, 100.0] {
            let mut beyond = orbit();
            (0..4).for_each(|_| beyond.turn(0.1, by));
            let camera = beyond.camera();
            assert!((camera.eye[1] - 4.0 * by.signum() as f32 * STEEPEST as f32).abs() < 1e-3);
            assert!(camera.axes().is_ok());
            beyond.turn(0.0, -0.5 * by.signum());
            assert!(beyond.camera().eye[1].abs() < 3.9, "and back");
        }
    }

    #[test]
    fn what_is_panned_stays_under_the_pointer() {
        // Half of the picture's height at the point is 4 tan 15 degrees.
        let mut moved = orbit();
        moved.pan(0.5, -0.5);
        near(moved.camera().target, [1.0718, -1.0718, 0.0]);
        near(moved.camera().eye, [1.0718, -1.0718, 4.0]);
        moved.zoom(2.0);
        near(moved.camera().eye, [1.0718, -1.0718, 2.0]);
    }

    #[test]
    fn parallel_views_zoom_too_and_nonsense_changes_nothing() {
        let camera = Camera::look_at([0.0, 9.0, 0.0], [0.0; 3], [0.0, 0.0, -1.0]).unwrap();
        let mut plan = Orbit::from_camera(&camera.orthographic(3.0).unwrap());
        assert!(plan.camera().axes().is_ok());
        plan.zoom(1.5);
        assert_eq!(plan.camera().projection, Projection::Orthographic { height: 2.0 });
        let before = plan;
        plan.turn(f64::NAN, 0.0);
        plan.pan(f64::INFINITY, 0.0);
        plan.zoom(-1.0);
        plan.zoom(f64::INFINITY);
        plan.set_target([f64::NAN; 3]);
        assert_eq!(plan, before);
        plan.zoom(1e300);
        let camera = plan.camera();
        assert!(camera.axes().is_ok() && camera.near >= Camera::MIN_NEAR);
    }
}
