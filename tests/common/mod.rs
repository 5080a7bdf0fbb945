//! From a golden's description to a frame, for the tests that go through all of them.

pub mod files;
pub mod images;
pub mod scenes;
pub mod shapes;
pub mod stage;

use overcoat::description::{CameraDescription, Description, Machine, Materials};
use overcoat::frame::DisplayOptions;
use overcoat::golden::{DescribedGolden, GoldenFolder};
use overcoat::jobs::Jobs;
use overcoat::limits::Limits;
use overcoat::render::{Ground, Quality, RenderOptions};
use overcoat::scene::{Camera, Scene};
use std::path::{Path, PathBuf};

/// Folder of the goldens.
pub fn folder() -> PathBuf {
    let package = Path::new(env!("CARGO_MANIFEST_DIR"));
    let repository = package.ancestors().find(|folder| folder.join("Cargo.lock").is_file());
    repository.expect("the tests are those of a package of this repository").join("golden")
}

/// All goldens, or why they cannot be read.
pub fn goldens() -> Result<Vec<DescribedGolden>, String> {
    GoldenFolder::open(&folder()).map(|f| f.goldens().to_vec()).map_err(|e| e.to_string())
}

/// Contents and settings of a golden.
pub struct Shot {
    pub scene: Scene,
    pub camera: Camera,
    pub options: RenderOptions,
    #[allow(dead_code, reason = "only tests that make pictures read it")]
    pub display: DisplayOptions,
}

impl Shot {
    /// Builds or loads the scene that a golden describes. The keys are those of scene files;
    /// `model = "builtin:<name>"` names a scene of `tests/common/scenes`, whose own camera and environment count
    /// where the description gives none.
    pub fn load(golden: &DescribedGolden, machine: Machine, jobs: &Jobs) -> Result<Self, String> {
        let mut file = Description::from_toml(golden.description()).map_err(|e| e.to_string())?;
        // So that another default changes no golden; scenes of several models name them in their materials.
        let of_materials =
            file.model.as_ref().is_some_and(|model| model.as_os_str() == "builtin:mixed-models");
        if file.shading.is_none() && !of_materials {
            return Err("a golden names its shading model: shading = \"...\"".to_owned());
        }
        // Likewise: goldens are drafts without ground where they say nothing of either.
        file.quality.get_or_insert(Quality::Draft);
        file.ground.get_or_insert(Ground::None);
        let limits = Limits::default();
        let model = file.model.as_ref().and_then(|model| model.to_str()).unwrap_or_default().to_owned();
        let Some(name) = model.strip_prefix("builtin:") else {
            file.resolve_paths(&folder());
            let picture = file.picture(machine, &limits, jobs).map_err(|e| e.to_string())?;
            // Bundled models ask only for supported features: a warning is a mistake here.
            if let Some(warning) = picture.warnings.first() {
                return Err(format!("{model}: {warning}"));
            }
            return Ok(Self {
                scene: picture.scene,
                camera: picture.camera,
                options: picture.options,
                display: picture.display,
            });
        };
        let (mut scene, mut camera) = scenes::build(name)?.map_err(|e| e.to_string())?;
        let (options, display) = file.options(machine, &limits).map_err(|e| e.to_string())?;
        let materials = Materials::load(&file, &limits, jobs).map_err(|e| e.to_string())?;
        materials.assign(&mut scene, &limits).map_err(|e| e.to_string())?;
        if file.env.is_some() {
            file.light(&mut scene, &limits, jobs).map_err(|e| e.to_string())?;
        } else {
            for (number, light) in file.lights_to_add.iter().enumerate() {
                light.add_to(&mut scene, number).map_err(|e| e.to_string())?;
            }
            let mut environment = scene.environment().clone();
            environment.rotation_degrees = file.env_rotation_degrees.unwrap_or(environment.rotation_degrees);
            environment.intensity = file.env_intensity.unwrap_or(environment.intensity);
            scene.set_environment(environment).map_err(|e| e.to_string())?;
        }
        if file.camera != CameraDescription::default() {
            camera = file.camera(&scene, &options).map_err(|e| e.to_string())?;
        }
        Ok(Self { scene, camera, options, display })
    }
}

/// Names of the built-in scenes.
#[allow(dead_code, reason = "not every test asks for them")]
pub fn scene_names() -> Vec<&'static str> {
    scenes::SCENES.iter().flat_map(|group| group.iter().map(|(name, _)| *name)).collect()
}
