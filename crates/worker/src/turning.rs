//! A model once around: the camera of each picture, and the light that stays while the model turns.

use overcoat_core::math::double::sin_cos;
use overcoat_description::{Description, DescriptionError};
use overcoat_render::RenderOptions;
use overcoat_scene::{Camera, Environment, Fit, Light, LightKind, Scene, SceneError, Transform};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// Directions from which a model is fitted into the picture at most: the camera would have to be farther away by less than
/// a thousandth for others.
const DIRECTIONS: u32 = 72;

/// Choice between the two that can turn around the vertical axis, counter-clockwise seen from above.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Turn {
    /// The model with its lights.
    #[default]
    Model,
    /// The camera.
    Camera,
}

/// A turn around what a scene shows, picture after picture.
#[derive(Debug)]
pub struct Turning {
    frames: u32,
    turn: Turn,
    center: [f64; 3],
    /// Camera of the first picture.
    camera: Camera,
    environment: Environment,
    lights: Vec<Light>,
    /// Number of the lights that are the model's.
    own_lights: usize,
}

impl Turning {
    /// Finds what lies in the middle, and a camera that shows all of the model from every side, unless one is described.
    ///
    /// # Errors
    /// [`DescriptionError`] if there is no such camera, or it spans no view.
    pub fn new(
        description: &Description,
        scene: &Scene,
        options: &RenderOptions,
        frames: u32,
        turn: impl Into<Turn>,
    ) -> Result<Self, DescriptionError> {
        let lights = scene.lights().to_vec();
        // Lights of the scene file come after those of the model.
        let own_lights = lights.len() - description.lights_to_add.len();
        let bounds = scene.shown_bounds();
        let center = if bounds.is_empty() { [0.0; 3] } else { bounds.center() };
        let camera = match description.framing(scene, options) {
            None => description.camera(scene, options)?,
            Some(framing) => {
                let mut fit = Fit::new(framing);
                let directions = frames.min(DIRECTIONS);
                for k in 0..directions {
                    let by = turned(center, TAU * f64::from(k) / f64::from(directions))?;
                    fit.include_moved(scene, &by);
                }
                description.fitted(fit.camera())?
            }
        };
        Ok(Self {
            frames,
            turn: turn.into(),
            center,
            camera,
            environment: scene.environment().clone(),
            lights,
            own_lights,
        })
    }

    /// Turns the scene's light as picture `k` needs it, and returns the camera.
    ///
    /// # Errors
    /// [`SceneError`] if a light leaves the range of coordinates.
    pub fn pose(&self, k: u32, scene: &mut Scene) -> Result<Camera, SceneError> {
        let angle = TAU * f64::from(k) / f64::from(self.frames);
        match self.turn {
            Turn::Camera => Ok(orbit(&self.camera, self.center, angle)),
            // All that stays while the model turns goes around it the other way.
            Turn::Model => {
                turn_light(scene, &self.environment, &self.lights, self.own_lights, self.center, -angle)?;
                Ok(orbit(&self.camera, self.center, -angle))
            }
        }
    }
}

/// A turn about the vertical axis through a point.
fn turned(center: [f64; 3], angle: f64) -> Result<Transform, SceneError> {
    let (sin, cos) = sin_cos(angle);
    let [x, _, z] = center;
    Transform::from_rows([
        [cos, 0.0, sin, x - cos * x - sin * z],
        [0.0, 1.0, 0.0, 0.0],
        [-sin, 0.0, cos, z + sin * x - cos * z],
    ])
}

/// A vector turned about the vertical axis.
fn turn(v: [f32; 3], about: [f64; 3], (sin, cos): (f64, f64)) -> [f32; 3] {
    let [x, z] = [f64::from(v[0]) - about[0], f64::from(v[2]) - about[2]];
    [(about[0] + cos * x + sin * z) as f32, v[1], (about[2] - sin * x + cos * z) as f32]
}

/// The camera turned about the vertical axis through a point.
#[must_use]
pub fn orbit(camera: &Camera, center: [f64; 3], angle: f64) -> Camera {
    let turning = sin_cos(angle);
    let center = if center.iter().all(|v| v.is_finite()) { center } else { [0.0; 3] };
    let [eye, target] = [camera.eye, camera.target].map(|place| turn(place, center, turning));
    Camera::new(eye, target, turn(camera.up, [0.0; 3], turning), camera.projection, camera.near)
}

/// Turns the environment and the lights that are not the model's.
fn turn_light(
    scene: &mut Scene,
    environment: &Environment,
    lights: &[Light],
    own: usize,
    center: [f64; 3],
    angle: f64,
) -> Result<(), SceneError> {
    let rotation_degrees = environment.rotation_degrees + angle.to_degrees() as f32;
    scene.set_environment(environment.clone().with(|e| e.rotation_degrees = rotation_degrees))?;
    scene.clear_lights();
    let turning = sin_cos(angle);
    for (k, light) in lights.iter().enumerate() {
        let light = if k < own { *light } else { turned_light(light, center, turning) };
        scene.add_light(light)?;
    }
    Ok(())
}

fn turned_light(light: &Light, center: [f64; 3], turning: (f64, f64)) -> Light {
    let point = |p: &mut [f32; 3]| *p = turn(*p, center, turning);
    let vector = |v: &mut [f32; 3]| *v = turn(*v, [0.0; 3], turning);
    let mut light = *light;
    match &mut light.kind {
        LightKind::Directional { direction } => vector(direction),
        LightKind::Point { position, .. } => point(position),
        LightKind::Spot { position, direction, .. } => {
            point(position);
            vector(direction);
        }
        LightKind::Rect { position, half_width, half_height, .. } => {
            point(position);
            vector(half_width);
            vector(half_height);
        }
        LightKind::Tube { ends, .. } => ends.iter_mut().for_each(point),
    }
    light
}

#[cfg(test)]
mod tests {
    use super::*;
    use overcoat_scene::Projection;

    fn camera() -> Camera {
        Camera::new(
            [3.0, 2.0, 5.0],
            [1.0, 0.5, 0.0],
            [0.0, 1.0, 0.0],
            Projection::Perspective { fov_y: 0.5 },
            0.1,
        )
    }

    #[test]
    fn the_camera_keeps_its_distance() {
        let camera = camera();
        let quarter = orbit(&camera, [1.0, 0.0, 1.0], std::f64::consts::FRAC_PI_2);
        assert_eq!(quarter.eye, [5.0, 2.0, -1.0]);
        assert_eq!(orbit(&camera, [1.0, 0.0, 1.0], 0.0), camera);
    }

    #[test]
    fn models_turn_as_cameras_do() {
        let center = [1.0, 7.0, 1.0];
        let by = turned(center, 1.1).unwrap();
        let camera = camera();
        let moved = by.point(camera.eye.map(f64::from));
        let eye = orbit(&camera, center, 1.1).eye;
        assert!(moved.iter().zip(eye).all(|(a, b)| (a - f64::from(b)).abs() < 1e-5), "{moved:?} {eye:?}");
        let light = Light::new(LightKind::Spot {
            position: camera.eye,
            direction: [0.0, 0.0, 1.0],
            range: None,
            inner_cone_cosine: 1.0,
            outer_cone_cosine: 0.5,
        });
        let LightKind::Spot { position, direction, .. } =
            turned_light(&light, center, sin_cos(std::f64::consts::FRAC_PI_2)).kind
        else {
            panic!("another kind")
        };
        assert_eq!(position, [5.0, 2.0, -1.0]);
        assert!((direction[0] - 1.0).abs() < 1e-6 && direction[2].abs() < 1e-6);
    }
}
