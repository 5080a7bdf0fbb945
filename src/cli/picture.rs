//! From the description of a picture to what the renderer takes.

use super::failure::{Failure, file_name};
use super::input::{self, ModelSource};
use super::materials::Materials;
use super::report::Stages;
use super::scene_file::{EnvironmentChoice, SceneCamera, SceneFile};
use super::values::{BackgroundChoice, ExposureChoice};
use crate::color::ToneCurve;
use crate::jobs::Jobs;
use crate::limits::Limits;
use crate::load::{
    Context, LoadOptions, Loaded, NoResolver, Warning, load_environment, load_environment_file, nearest_name,
    suggestion,
};
use crate::math::lanes::SimdLevel;
use crate::output::DisplayOptions;
use crate::render::{Background, RenderOptions};
use crate::scene::{Camera, Environment, EnvironmentSource, Framing, Projection, Scene};
use std::path::Path;
use std::sync::Arc;

/// Vertical field of view where none is given, in degrees: a short telephoto lens.
const DEFAULT_FOV_Y_DEGREES: f32 = 30.0;

/// Everything that the renderer and the encoder need for one picture.
#[derive(Clone, Debug)]
pub struct Picture {
    /// What is seen.
    pub scene: Scene,
    /// From where.
    pub camera: Camera,
    /// The renderer's options.
    pub options: RenderOptions,
    /// The way to 8 bits.
    pub display: DisplayOptions,
    /// What the model file asks for and the picture will not show.
    pub warnings: Vec<Warning>,
}

/// What a picture needs from the machine and not from its description. Changes nothing in it.
#[derive(Clone, Copy, Debug)]
pub struct Machine {
    /// Instruction set.
    pub simd: SimdLevel,
    /// Side of a tile in pixels.
    pub tile_size: Option<u32>,
}

impl Default for Machine {
    fn default() -> Self {
        Self { simd: SimdLevel::best(), tile_size: None }
    }
}

/// What is the same for all models and poses that one description shows.
#[derive(Debug)]
pub struct Setting {
    materials: Materials,
    /// Scenes that share it share its filtered form.
    environment: Environment,
    /// What is doubtful about the scene file, the materials and the environment.
    pub warnings: Vec<Warning>,
}

impl Setting {
    /// Reads the materials and the environment of a description.
    ///
    /// # Errors
    /// [`Failure`] naming the file and the reason.
    pub fn load(
        description: &SceneFile,
        limits: &Limits,
        jobs: &Jobs,
        stages: &mut Stages,
    ) -> Result<Self, Failure> {
        let materials = stages.time("load_materials", || Materials::load(description, limits, jobs))?;
        let (environment, of_environment) =
            stages.time("load_environment", || description.environment(limits, jobs))?;
        let mut warnings = description.warnings.clone();
        warnings.extend(materials.warnings());
        warnings.extend(of_environment);
        Ok(Self { materials, environment, warnings })
    }

    /// Lays the materials over a model and lights it as described.
    ///
    /// # Errors
    /// [`Failure`] if the model has no material of a name that is asked for, or a light is wrong.
    pub fn apply(&self, description: &SceneFile, scene: &mut Scene, limits: &Limits) -> Result<(), Failure> {
        self.materials.assign(scene, limits)?;
        description.light_by(scene, self.environment.clone())
    }
}

impl SceneFile {
    /// Loads what the description names and makes everything ready for the renderer.
    ///
    /// # Errors
    /// [`Failure`] naming the file and the reason.
    pub fn picture(&self, machine: Machine, limits: &Limits, jobs: &Jobs) -> Result<Picture, Failure> {
        let model = self.model.as_deref().ok_or_else(|| Failure::failed("no model is given"))?;
        let (options, display) = self.options(machine, limits).map_err(|failure| failure.at(model))?;
        let source = ModelSource {
            path: model.to_owned(),
            format: None,
            options: LoadOptions {
                animation: self.animation_choice()?,
                up: self.up,
                ..LoadOptions::default()
            },
        };
        let setting = Setting::load(self, limits, jobs, &mut Stages::default())?;
        let Loaded { mut scene, mut warnings } = input::load(&source, limits, jobs)?;
        setting.apply(self, &mut scene, limits).map_err(|failure| failure.at(model))?;
        warnings.extend(setting.warnings);
        let camera = self.camera(&scene, &options).map_err(|failure| failure.at(model))?;
        let display = self.display_of(&scene, &display);
        Ok(Picture { scene, camera, options, display, warnings })
    }

    /// The renderer's options and the way to 8 bits. Sizes beyond the limits end here, before any work.
    ///
    /// # Errors
    /// [`Failure`] naming the option.
    pub fn options(
        &self,
        machine: Machine,
        limits: &Limits,
    ) -> Result<(RenderOptions, DisplayOptions), Failure> {
        let defaults = RenderOptions::default();
        let [width, height] = self.size.unwrap_or([u64::from(defaults.width), u64::from(defaults.height)]);
        if width == 0 || height == 0 {
            return Err(Failure::usage(format!("size {width}x{height}: a picture has at least one pixel")));
        }
        let asked = if width > height { width } else { height };
        let what = || format!("size {width}x{height}");
        Limits::check(what, asked, u64::from(limits.output_side), "output_side")
            .and_then(|()| {
                Limits::check(what, width.saturating_mul(height), limits.output_pixels, "output_pixels")
            })
            .map_err(|e| Failure::limit(&e))?;
        let (exposure, meter) = match self.exposure {
            Some(ExposureChoice::Stops(stops)) => (stops, false),
            Some(ExposureChoice::Auto) => (0.0, true),
            None => (0.0, false),
        };
        if !(-64.0..=64.0).contains(&exposure) {
            return Err(Failure::usage(format!("exposure {exposure}: expected -64 to 64 stops")));
        }
        let (background, color) = match self.background.unwrap_or(BackgroundChoice::Transparent) {
            BackgroundChoice::Transparent => (Background::Transparent, None),
            BackgroundChoice::Environment => (Background::Environment, None),
            BackgroundChoice::Color(color) => (Background::Transparent, Some(color)),
        };
        let options = RenderOptions {
            // Within output_side, which is a u32.
            width: width as u32,
            height: height as u32,
            samples: self.samples.unwrap_or(defaults.samples),
            tile_size: machine.tile_size,
            simd: machine.simd,
            shading: self.shading,
            background,
            anisotropy: self.anisotropy.unwrap_or(defaults.anisotropy),
            area_lights: self.area_lights.unwrap_or_default(),
            merge_angle: self.merge_angle_degrees.unwrap_or(defaults.merge_angle),
            line_width: self.line_width.unwrap_or(defaults.line_width),
            point_size: self.point_size,
            aovs: Vec::new(),
            stage_hashes: false,
            limits: limits.clone(),
        };
        let display = DisplayOptions {
            tone_curve: self.tone_curve.unwrap_or_default(),
            exposure,
            meter,
            background: color,
            simd: machine.simd,
        };
        Ok((options, display))
    }

    /// The way to 8 bits for one scene: colours of splats are what a screen is to show, so without a tone curve unless one
    /// is asked for or there is anything else in the picture.
    #[must_use]
    pub fn display_of(&self, scene: &Scene, display: &DisplayOptions) -> DisplayOptions {
        let mut display = display.clone();
        if self.tone_curve.is_none() && scene.is_display_referred() {
            display.tone_curve = ToneCurve::None;
        }
        display
    }

    /// Puts environment and lights into the scene and takes out lights that are not wanted. Returns what is doubtful
    /// about the environment.
    ///
    /// # Errors
    /// [`Failure`] naming the environment's file and the reason.
    pub fn light(&self, scene: &mut Scene, limits: &Limits, jobs: &Jobs) -> Result<Vec<Warning>, Failure> {
        let (environment, warnings) = self.environment(limits, jobs)?;
        self.light_by(scene, environment)?;
        Ok(warnings)
    }

    /// The environment, read from its file if it has one, and what is doubtful about it. Scenes that share it share its
    /// filtered form.
    ///
    /// # Errors
    /// [`Failure`] naming the environment's file and the reason.
    pub fn environment(&self, limits: &Limits, jobs: &Jobs) -> Result<(Environment, Vec<Warning>), Failure> {
        let mut warnings = Vec::new();
        let source = match self.env.as_ref().unwrap_or(&EnvironmentChoice::Studio) {
            EnvironmentChoice::Studio => EnvironmentSource::Studio,
            EnvironmentChoice::None => EnvironmentSource::None,
            EnvironmentChoice::File(path) => {
                let about = |failure: Failure| failure.at(path);
                let loaded = if is_standard_input(path) {
                    let bytes = input::read_standard_input(limits).map_err(about)?;
                    load_environment(&bytes, &Context { resolver: &NoResolver, limits, jobs })
                } else {
                    load_environment_file(path, limits, jobs)
                };
                let loaded = loaded.map_err(|e| about(Failure::load(&e)))?;
                let named = |w: &Warning| Warning::new(format!("{}: {w}", file_name(path)));
                warnings.extend(loaded.warnings.iter().map(named));
                EnvironmentSource::Image(Arc::new(loaded.image))
            }
        };
        let environment = Environment {
            source,
            rotation_degrees: self.env_rotation_degrees.unwrap_or(0.0),
            intensity: self.env_intensity.unwrap_or(1.0),
        };
        Ok((environment, warnings))
    }

    /// Puts an environment and the description's lights into the scene and takes out lights that are not wanted.
    ///
    /// # Errors
    /// [`Failure`] naming the light.
    pub fn light_by(&self, scene: &mut Scene, environment: Environment) -> Result<(), Failure> {
        if self.lights == Some(false) {
            scene.clear_lights();
        }
        for (number, light) in self.lights_to_add.iter().enumerate() {
            light.add_to(scene, number)?;
        }
        scene.set_environment(environment).map_err(|e| Failure::scene(&e))
    }

    /// The camera: the one that is described, one of the file, or one that frames the model.
    ///
    /// # Errors
    /// [`Failure`] if there is no such camera or it spans no view.
    pub fn camera(&self, scene: &Scene, options: &RenderOptions) -> Result<Camera, Failure> {
        match self.framing(scene, options) {
            Some(framing) => self.fitted(framing.camera(scene)),
            None => self.placed_camera(scene),
        }
    }

    /// How a camera is found that fits the model, unless the description or the file has one.
    #[must_use]
    pub fn framing(&self, scene: &Scene, options: &RenderOptions) -> Option<Framing> {
        let description = &self.camera;
        if description.from_model.is_some() || description.eye.is_some() {
            return None;
        }
        // Which view shows something is looked for only where none is given.
        let defaults =
            if description.view.is_some() { Framing::default() } else { Framing::automatic(scene) };
        Some(Framing {
            direction: description.view.map_or(defaults.direction, |v| v.direction),
            up: description.up.or(description.view.map(|v| v.up)).unwrap_or(defaults.up),
            fov_y: description.fov_y_degrees.map_or(defaults.fov_y, f32::to_radians),
            orthographic: description.orthographic_height.is_some(),
            aspect: options.width as f32 / options.height as f32,
            margin: defaults.margin,
        })
    }

    /// A camera that fits the model, with what the description says of it.
    ///
    /// # Errors
    /// [`Failure`] if it spans no view.
    pub fn fitted(&self, mut camera: Camera) -> Result<Camera, Failure> {
        if let Some(height) = self.camera.orthographic_height.filter(|&h| h > 0.0) {
            camera.projection = Projection::Orthographic { height };
        }
        if let Some(near) = self.camera.near {
            camera.near = near;
        }
        camera.validate().map_err(|e| Failure::scene(&e))?;
        Ok(camera)
    }

    /// The camera that is described, or one of the file.
    fn placed_camera(&self, scene: &Scene) -> Result<Camera, Failure> {
        let camera = match &self.camera {
            SceneCamera { from_model: Some(name), .. } => camera_of_model(scene, name)?,
            described => explicit_camera(described, described.eye.unwrap_or_default(), scene)?,
        };
        camera.validate().map_err(|e| Failure::scene(&e))?;
        Ok(camera)
    }
}

/// A camera of the file, by name first, then by number.
fn camera_of_model(scene: &Scene, name: &str) -> Result<Camera, Failure> {
    let by_name = scene.camera_names().iter().position(|n| n == name);
    let index = by_name.or_else(|| name.parse().ok());
    if let Some(camera) = index.and_then(|k| scene.cameras().get(k)) {
        return Ok(*camera);
    }
    let known: Vec<String> =
        scene.camera_names().iter().enumerate().map(|(k, n)| format!("{k} '{n}'")).collect();
    let known = if known.is_empty() { "none".to_owned() } else { known.join(", ") };
    let hint = suggestion(nearest_name(name, scene.camera_names().iter().map(String::as_str)));
    Err(Failure::failed(format!("there is no camera '{name}'; the file has {known}{hint}")))
}

/// A camera at a given place.
fn explicit_camera(description: &SceneCamera, eye: [f64; 3], scene: &Scene) -> Result<Camera, Failure> {
    let eye = scene.position_of(eye);
    let bounds = scene.bounds();
    let center = if bounds.is_empty() { [0.0; 3] } else { bounds.center().map(|v| v as f32) };
    let target = description.target.map_or(center, |target| scene.position_of(target));
    let projection = match description.orthographic_height {
        Some(height) if height > 0.0 => Projection::Orthographic { height },
        Some(_) => return Err(Failure::usage("--ortho with --eye needs a height: --ortho=HEIGHT")),
        None => Projection::Perspective {
            fov_y: description.fov_y_degrees.unwrap_or(DEFAULT_FOV_Y_DEGREES).to_radians(),
        },
    };
    let distance: f64 =
        (0..3).map(|k| f64::from(eye[k]) - f64::from(target[k])).map(|d| d * d).sum::<f64>().sqrt();
    let near = description.near.unwrap_or((distance * 1e-3) as f32);
    let near = if near > Camera::MIN_NEAR { near } else { Camera::MIN_NEAR };
    Ok(Camera { eye, target, up: description.up.unwrap_or([0.0, 1.0, 0.0]), projection, near })
}

/// A path that stands for standard input. What comes from there has no folder, whatever it is.
#[must_use]
pub fn is_standard_input(path: &Path) -> bool {
    let names = ["/dev/stdin", "/dev/fd/0", "/proc/self/fd/0"];
    is_standard_stream(path) || (cfg!(unix) && names.iter().any(|name| path == Path::new(name)))
}

/// A path that stands for standard input or output.
#[must_use]
pub fn is_standard_stream(path: &Path) -> bool {
    path.as_os_str() == "-"
}
