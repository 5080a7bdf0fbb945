//! Camera of a description: placed, of the model's file, or framing the model.

use super::Description;
use super::error::DescriptionError;
use overcoat_core::suggest::{nearest_name, suggestion};
use overcoat_render::{Ground, RenderOptions};
use overcoat_scene::{Camera, Framing, Projection, Scene};

/// Vertical field of view where none is given, in degrees: a short telephoto lens.
const DEFAULT_FOV_Y_DEGREES: f32 = 30.0;

/// The camera of a [`Description`]. Without `eye` the model is framed automatically, seen along `view`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CameraDescription {
    /// World-space position in metres.
    pub eye: Option<[f64; 3]>,
    /// World-space point in the centre of the picture. The middle of the model if absent.
    pub target: Option<[f64; 3]>,
    /// Which way is up in the picture. +Y if absent.
    pub up: Option<[f32; 3]>,
    /// Vertical field of view in degrees.
    pub fov_y_degrees: Option<f32>,
    /// Nothing nearer than this distance in metres is drawn.
    pub near: Option<f32>,
    /// No surface farther than this distance in metres is drawn.
    pub far: Option<f32>,
    /// Parallel projection that shows this many metres from top to bottom; 0 fits the model.
    pub orthographic_height: Option<f32>,
    /// Direction from which an automatic camera looks: a name such as `front`, or `x,y,z`.
    pub view: Option<ViewDirection>,
    /// A camera of the model file, by its name or number.
    pub from_model: Option<String>,
}

/// Direction from which an automatic camera looks at the model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ViewDirection {
    /// From the model towards the camera.
    pub direction: [f32; 3],
    /// Which way is up.
    pub up: [f32; 3],
}

impl Description {
    /// The camera: the one that is described, one of the file, or one that frames the model.
    ///
    /// # Errors
    /// [`DescriptionError`] if there is no such camera or it spans no view.
    pub fn camera(&self, scene: &Scene, options: &RenderOptions) -> Result<Camera, DescriptionError> {
        match self.framing(scene, options) {
            Some(framing) => self.fitted(framing.camera(scene)),
            None => self.placed_camera(scene),
        }
    }

    /// The automatic framing of the model, unless the description or the file has one.
    #[must_use]
    pub fn framing(&self, scene: &Scene, options: &RenderOptions) -> Option<Framing> {
        let description = &self.camera;
        if description.from_model.is_some() || description.eye.is_some() {
            return None;
        }
        // Which view shows something is looked for only where none is given.
        let defaults =
            if description.view.is_some() { Framing::default() } else { Framing::automatic(scene) };
        let mut framing = defaults.with_aspect(options.width as f32 / options.height as f32);
        framing.direction = description.view.map_or(defaults.direction, |v| v.direction);
        framing.up = description.up.or(description.view.map(|v| v.up)).unwrap_or(defaults.up);
        framing.fov_y = description.fov_y_degrees.map_or(defaults.fov_y, f32::to_radians);
        framing.orthographic = description.orthographic_height.is_some();
        framing.margin = Framing::MARGIN;
        if shows_ground(scene, &framing, options) {
            framing.margin = Framing::MARGIN_OVER_FLOOR;
        }
        Some(framing)
    }

    /// A camera that fits the model, with what the description says of it.
    ///
    /// # Errors
    /// [`DescriptionError`] if it spans no view.
    pub fn fitted(&self, mut camera: Camera) -> Result<Camera, DescriptionError> {
        if let Some(height) = self.camera.orthographic_height.filter(|&h| h > 0.0) {
            camera.projection = Projection::Orthographic { height };
        }
        if let Some(near) = self.camera.near {
            camera.near = near;
        }
        camera.far = self.camera.far.unwrap_or(camera.far);
        camera.validate()?;
        Ok(camera)
    }

    /// The camera that is described, or one of the file.
    fn placed_camera(&self, scene: &Scene) -> Result<Camera, DescriptionError> {
        let camera = match &self.camera {
            CameraDescription { from_model: Some(name), .. } => camera_of_model(scene, name)?,
            described => explicit_camera(described, described.eye.unwrap_or_default(), scene)?,
        };
        camera.validate()?;
        Ok(camera)
    }
}

/// True if anything of the floor can be in a picture: it is seen from above, and a shadow needs something that casts it.
fn shows_ground(scene: &Scene, framing: &Framing, options: &RenderOptions) -> bool {
    let Framing { direction: [_, height, _], orthographic, .. } = *framing;
    let from_above = height > 0.0 || height == 0.0 && !orthographic;
    let is_there = match options.ground {
        Ground::None => false,
        Ground::Shadow => scene.blocks_light(),
        Ground::Color(_) => true,
    };
    from_above && is_there
}

/// A camera of the file, by name first, then by number.
fn camera_of_model(scene: &Scene, name: &str) -> Result<Camera, DescriptionError> {
    let by_name = scene.camera_names().iter().position(|n| n == name);
    let index = by_name.or_else(|| name.parse().ok());
    if let Some(camera) = index.and_then(|k| scene.cameras().get(k)) {
        return Ok(*camera);
    }
    let known: Vec<String> =
        scene.camera_names().iter().enumerate().map(|(k, n)| format!("{k} '{n}'")).collect();
    let known = if known.is_empty() { "none".to_owned() } else { known.join(", ") };
    let hint = suggestion(nearest_name(name, scene.camera_names().iter().map(String::as_str)));
    Err(DescriptionError::invalid(format!("there is no camera '{name}'; the file has {known}{hint}")))
}

/// A camera at a given place.
fn explicit_camera(
    description: &CameraDescription,
    eye: [f64; 3],
    scene: &Scene,
) -> Result<Camera, DescriptionError> {
    let eye = scene.position_of(eye);
    let bounds = scene.bounds();
    let center = if bounds.is_empty() { [0.0; 3] } else { bounds.center().map(|v| v as f32) };
    let target = description.target.map_or(center, |target| scene.position_of(target));
    let projection = match description.orthographic_height {
        Some(height) if height > 0.0 => Projection::Orthographic { height },
        Some(_) => return Err(DescriptionError::NoHeight),
        None => Projection::Perspective {
            fov_y: description.fov_y_degrees.unwrap_or(DEFAULT_FOV_Y_DEGREES).to_radians(),
        },
    };
    let near = match description.near {
        Some(near) if near > Camera::MIN_NEAR => near,
        Some(_) => Camera::MIN_NEAR,
        None => Camera::usual_near(eye, target),
    };
    let mut camera = Camera::new(eye, target, description.up.unwrap_or([0.0, 1.0, 0.0]), projection, near);
    camera.far = description.far.unwrap_or(camera.far);
    Ok(camera)
}
