//! From a description to what the renderer takes.

use super::Description;
use super::error::DescriptionError;
use super::input::{is_standard_input, read_standard_input};
use super::materials::Materials;
use super::options::Machine;
use overcoat_core::frame::DisplayOptions;
use overcoat_core::jobs::Jobs;
use overcoat_core::limits::Limits;
use overcoat_load::{Context, LoadOptions, Loaded, NoResolver, Warning, load_bytes_with, load_file_with};
use overcoat_render::RenderOptions;
use overcoat_scene::{Camera, Environment, Scene};
use std::path::Path;

/// Everything that the renderer and the encoder need for one picture.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Picture {
    /// The scene.
    pub scene: Scene,
    /// From where.
    pub camera: Camera,
    /// The renderer's options.
    pub options: RenderOptions,
    /// The way to 8 bits.
    pub display: DisplayOptions,
    /// Warnings about content of the model's file that the picture will not show.
    pub warnings: Vec<Warning>,
}

/// Materials and environment of a description, for all models and poses that it shows.
#[derive(Debug)]
#[non_exhaustive]
pub struct Setting {
    materials: Materials,
    /// Scenes that share it share its filtered form.
    environment: Environment,
    /// Warnings about the scene file, the materials and the environment.
    pub warnings: Vec<Warning>,
}

impl Setting {
    /// Reads the materials and the environment of a description.
    ///
    /// # Errors
    /// [`DescriptionError`] naming the file and the reason.
    pub fn load(description: &Description, limits: &Limits, jobs: &Jobs) -> Result<Self, DescriptionError> {
        let materials = Materials::load(description, limits, jobs)?;
        let environment = description.environment(limits, jobs)?;
        Ok(Self::new(description, materials, environment))
    }

    /// [`Setting::load`], with every file from the context's resolver instead of the file system.
    ///
    /// # Errors
    /// As there.
    pub fn load_from(description: &Description, context: &Context<'_>) -> Result<Self, DescriptionError> {
        let materials = Materials::load_from(description, context)?;
        let environment = description.environment_from(context)?;
        Ok(Self::new(description, materials, environment))
    }

    /// Puts together what has been read: the materials, and what [`Description::environment`] returns.
    #[must_use]
    pub fn new(
        description: &Description,
        materials: Materials,
        (environment, of_environment): (Environment, Vec<Warning>),
    ) -> Self {
        let mut warnings = description.warnings.clone();
        warnings.extend(materials.warnings());
        warnings.extend(of_environment);
        Self { materials, environment, warnings }
    }

    /// Lays the materials over a model and lights it as described.
    ///
    /// # Errors
    /// [`DescriptionError`] if the model has no material of a name that is asked for, or a light is wrong.
    pub fn apply(
        &self,
        description: &Description,
        scene: &mut Scene,
        limits: &Limits,
    ) -> Result<(), DescriptionError> {
        self.materials.assign(scene, limits)?;
        description.light_by(scene, self.environment.clone())
    }
}

impl Description {
    /// Loads what the description names and makes everything ready for the renderer. `-` stands for standard input in the
    /// place of a model or an environment.
    ///
    /// # Errors
    /// [`DescriptionError`] naming the file and the reason.
    pub fn picture(
        &self,
        machine: Machine,
        limits: &Limits,
        jobs: &Jobs,
    ) -> Result<Picture, DescriptionError> {
        let model = self.model.as_deref().ok_or_else(|| DescriptionError::invalid("no model is given"))?;
        let about = |error: DescriptionError| error.at(model);
        // What can be wrong with the description is found before a file is read.
        let options = self.options(machine, limits).map_err(about)?;
        let load_options = self.load_options()?;
        let setting = Setting::load(self, limits, jobs)?;
        let loaded = load_model(model, &load_options, limits, jobs).map_err(about)?;
        self.finish(loaded, setting, options, limits).map_err(about)
    }

    /// Makes a scene that is loaded, or built by hand, ready for the renderer: lays the materials over it, lights it,
    /// finds the camera. What [`Description::load_options`] say has been done or is left out.
    ///
    /// # Errors
    /// [`DescriptionError`] naming the reason, and the file of a material or of the environment.
    pub fn picture_of(
        &self,
        loaded: Loaded,
        machine: Machine,
        limits: &Limits,
        jobs: &Jobs,
    ) -> Result<Picture, DescriptionError> {
        let options = self.options(machine, limits)?;
        let setting = Setting::load(self, limits, jobs)?;
        self.finish(loaded, setting, options, limits)
    }

    /// Options of loading its model.
    ///
    /// # Errors
    /// [`DescriptionError`] if there is a time and no animation, or a time that is none.
    pub fn load_options(&self) -> Result<LoadOptions, DescriptionError> {
        let options = LoadOptions::default().with_animation(self.animation_choice()?);
        Ok(options.with_up(self.up).with_plate(self.plate))
    }

    /// Puts the parts of a picture together.
    fn finish(
        &self,
        loaded: Loaded,
        setting: Setting,
        (options, display): (RenderOptions, DisplayOptions),
        limits: &Limits,
    ) -> Result<Picture, DescriptionError> {
        let Loaded { mut scene, mut warnings, .. } = loaded;
        setting.apply(self, &mut scene, limits)?;
        warnings.extend(setting.warnings);
        let camera = self.camera(&scene, &options)?;
        let display = self.display_of(&scene, &display);
        Ok(Picture { scene, camera, options, display, warnings })
    }
}

/// A model from its file or from standard input.
fn load_model(
    path: &Path,
    options: &LoadOptions,
    limits: &Limits,
    jobs: &Jobs,
) -> Result<Loaded, DescriptionError> {
    if is_standard_input(path) {
        let bytes = read_standard_input(limits)?;
        // What comes through a pipe has no folder, so it may not refer to files.
        let context = Context { resolver: &NoResolver, limits, jobs };
        return Ok(load_bytes_with(&bytes, None, options, &context)?);
    }
    Ok(load_file_with(path, options, limits, jobs)?)
}
