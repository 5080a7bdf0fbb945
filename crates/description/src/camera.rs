//! Camera of a description: placed, of the model's file, or framing the model.

use super::Description;
use super::error::DescriptionError;
use overcoat_core::suggest::{nearest_name, suggestion};
use overcoat_render::{Ground, RenderOptions};
use overcoat_scene::{Camera, Framing, Intrinsics, Pose, PoseConvention, Projection, Scene};

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
    /// Intrinsics `[fx, fy, cx, cy]` in pixels.
    pub k: Option<[f64; 4]>,
    /// Focal length in widths of a pixel; with the other three in place of [`CameraDescription::k`].
    pub fx: Option<f64>,
    /// Focal length in heights of a pixel.
    pub fy: Option<f64>,
    /// Principal point in pixels from the left border.
    pub cx: Option<f64>,
    /// Principal point in pixels from the upper border.
    pub cy: Option<f64>,
    /// Width and height of the picture that the intrinsics are for. Those of the picture if absent.
    pub intrinsics_size: Option<[u64; 2]>,
    /// Position and direction as a matrix, row by row.
    pub pose: Option<[[f64; 4]; 4]>,
    /// Meaning of the pose, which has none without.
    pub convention: Option<PoseConvention>,
}

/// Direction from which an automatic camera looks at the model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ViewDirection {
    /// From the model towards the camera.
    pub direction: [f32; 3],
    /// Which way is up.
    pub up: [f32; 3],
}

impl CameraDescription {
    /// `Ok` if no two of its keys contradict each other, and those that need another have it.
    ///
    /// # Errors
    /// [`DescriptionError`] naming both keys.
    fn check_keys(&self) -> Result<(), DescriptionError> {
        let four = [("fx", self.fx), ("fy", self.fy), ("cx", self.cx), ("cy", self.cy)];
        let given = four.iter().find(|(_, value)| value.is_some()).map(|(name, _)| *name);
        let missing = four.iter().find(|(_, value)| value.is_none()).map(|(name, _)| *name);
        let intrinsics = self.k.map(|_| "K").or(given);
        let pose = self.pose.map(|_| "pose");
        let of = |is_there: bool, name: &'static str| is_there.then_some(name);
        let places = [
            of(self.view.is_some(), "view"),
            of(self.from_model.is_some(), "camera"),
            of(self.eye.is_some(), "eye"),
            of(self.target.is_some(), "target"),
            of(self.up.is_some(), "up"),
        ];
        let projections = [
            of(self.fov_y_degrees.is_some(), "fov_y_deg"),
            of(self.orthographic_height.is_some(), "ortho_height"),
            of(self.from_model.is_some(), "camera"),
        ];
        let pairs = std::iter::once((self.k.map(|_| "K"), given))
            .chain(places.into_iter().map(|other| (pose, other)))
            .chain(projections.into_iter().map(|other| (intrinsics, other)));
        for pair in pairs {
            if let (Some(one), Some(other)) = pair {
                return Err(DescriptionError::invalid(format!(
                    "camera: {one} and {other} contradict each other, only one of them can be given"
                )));
            }
        }
        let needs = [
            (given, missing, "all of fx, fy, cx and cy make intrinsics"),
            (
                pose,
                of(self.convention.is_none(), "convention"),
                "opencv (world to camera) or opengl (camera to world)",
            ),
            (of(self.convention.is_some(), "convention"), of(pose.is_none(), "pose"), "which it is of"),
            (
                of(self.intrinsics_size.is_some(), "intrinsics_size"),
                of(intrinsics.is_none(), "K"),
                "or fx, fy, cx and cy",
            ),
        ];
        for (one, other, why) in needs {
            if let (Some(one), Some(other)) = (one, other) {
                return Err(DescriptionError::invalid(format!("camera: {one} needs {other}, {why}")));
            }
        }
        Ok(())
    }

    /// Intrinsics for a picture of that size, if there are any.
    ///
    /// # Errors
    /// [`DescriptionError`] naming the number that is out of its range, or both sizes if they have other shapes.
    fn intrinsics(&self, picture: [u32; 2]) -> Result<Option<Intrinsics>, DescriptionError> {
        let apart = || Some([self.fx?, self.fy?, self.cx?, self.cy?]);
        let Some(four) = self.k.or_else(apart) else { return Ok(None) };
        // Sides that are too large for their type are too large for intrinsics.
        let side = |side: u64| u32::try_from(side).unwrap_or(u32::MAX);
        let size = self.intrinsics_size.map_or(picture, |size| size.map(side));
        let intrinsics = Intrinsics::new(four, size)?;
        intrinsics.resized(picture)?;
        Ok(Some(intrinsics))
    }

    /// The pose, if there is one.
    ///
    /// # Errors
    /// [`DescriptionError`] of a matrix that is none.
    fn pose(&self) -> Result<Option<Pose>, DescriptionError> {
        let (Some(matrix), Some(convention)) = (self.pose, self.convention) else { return Ok(None) };
        Ok(Some(Pose::from_matrix(matrix, convention)?))
    }

    /// `Ok` if the camera of a picture of that size can be made of it.
    ///
    /// # Errors
    /// [`DescriptionError`] naming the keys that contradict each other, or the number that is wrong.
    pub(super) fn check(&self, picture: [u32; 2]) -> Result<(), DescriptionError> {
        self.check_keys()?;
        self.intrinsics(picture)?;
        self.pose()?;
        Ok(())
    }
}

impl Description {
    /// The camera: the one that is described, one of the file, or one that frames the model.
    ///
    /// # Errors
    /// [`DescriptionError`] if there is no such camera or it spans no view.
    pub fn camera(&self, scene: &Scene, options: &RenderOptions) -> Result<Camera, DescriptionError> {
        let size = [options.width, options.height];
        self.camera.check(size)?;
        match self.framing(scene, options) {
            Some(framing) => self.fitted(framing.camera(scene)),
            None => self.placed_camera(scene, size),
        }
    }

    /// The automatic framing of the model, unless the description or the file has one.
    #[must_use]
    pub fn framing(&self, scene: &Scene, options: &RenderOptions) -> Option<Framing> {
        let description = &self.camera;
        if description.from_model.is_some() || description.eye.is_some() || description.pose.is_some() {
            return None;
        }
        // Which view shows something is looked for only where none is given.
        let defaults =
            if description.view.is_some() { Framing::default() } else { Framing::automatic(scene) };
        let mut framing = defaults.with_aspect(options.width as f32 / options.height as f32);
        framing.direction = description.view.map_or(defaults.direction, |v| v.direction);
        framing.up = description.up.or(description.view.map(|v| v.up)).unwrap_or(defaults.up);
        framing.fov_y = description.fov_y_degrees.map_or(defaults.fov_y, f32::to_radians);
        // Wrong poses are no part of options.
        framing.intrinsics = description.intrinsics([options.width, options.height]).ok().flatten();
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
    fn placed_camera(&self, scene: &Scene, size: [u32; 2]) -> Result<Camera, DescriptionError> {
        let described = &self.camera;
        let camera = match (&described.from_model, described.pose()?) {
            (Some(name), _) => camera_of_model(scene, name)?,
            (None, Some(pose)) => posed_camera(described, pose, scene, size)?,
            (None, None) => explicit_camera(described, described.eye.unwrap_or_default(), scene, size)?,
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
    size: [u32; 2],
) -> Result<Camera, DescriptionError> {
    let eye = scene.position_of(eye);
    let target = description.target.map_or(center(scene), |target| scene.position_of(target));
    let projection = projection(description, size)?;
    let near = near(description, eye, target);
    let mut camera = Camera::new(eye, target, description.up.unwrap_or([0.0, 1.0, 0.0]), projection, near);
    camera.far = description.far.unwrap_or(camera.far);
    Ok(camera)
}

/// A camera at a given pose.
fn posed_camera(
    description: &CameraDescription,
    pose: Pose,
    scene: &Scene,
    size: [u32; 2],
) -> Result<Camera, DescriptionError> {
    let eye = scene.position_of(pose.position);
    let pose = Pose { position: eye.map(f64::from), ..pose };
    let near = near(description, eye, center(scene));
    let mut camera = Camera::at_pose(&pose, projection(description, size)?, near)?;
    camera.far = description.far.unwrap_or(camera.far);
    Ok(camera)
}

/// Middle of the model.
fn center(scene: &Scene) -> [f32; 3] {
    let bounds = scene.bounds();
    if bounds.is_empty() { [0.0; 3] } else { bounds.center().map(|v| v as f32) }
}

/// Near plane of a camera that is placed: by the distance, unless it is given.
fn near(description: &CameraDescription, eye: [f32; 3], target: [f32; 3]) -> f32 {
    match description.near {
        Some(near) if near > Camera::MIN_NEAR => near,
        Some(_) => Camera::MIN_NEAR,
        None => Camera::usual_near(eye, target),
    }
}

/// Projection of a camera that is placed.
fn projection(description: &CameraDescription, size: [u32; 2]) -> Result<Projection, DescriptionError> {
    if let Some(intrinsics) = description.intrinsics(size)? {
        return Ok(Projection::Intrinsics(intrinsics));
    }
    match description.orthographic_height {
        Some(height) if height > 0.0 => Ok(Projection::Orthographic { height }),
        Some(_) => Err(DescriptionError::NoHeight),
        None => {
            let degrees = description.fov_y_degrees.unwrap_or(DEFAULT_FOV_Y_DEGREES);
            Ok(Projection::Perspective { fov_y: degrees.to_radians() })
        }
    }
}
