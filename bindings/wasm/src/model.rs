//! A model that is loaded once and drawn many times.

use crate::files::Files;
use crate::picture::Picture;
use crate::{about_options, limits, sentence};
use js_sys::Array;
use overcoat::description::{Description, DescriptionError, EnvironmentChoice, Machine, Materials, Setting};
use overcoat::frame::Aov;
use overcoat::load::{LoadOptions, Loaded, Warning, load_bytes_with};
use overcoat::scene::{Environment, Scene};
use overcoat::{Limits, Renderer};
use wasm_bindgen::JsValue;
use wasm_bindgen::prelude::wasm_bindgen;

/// A model file with the files beside it, and what was made of them for the last picture.
#[wasm_bindgen]
pub struct Model {
    bytes: Vec<u8>,
    files: Files,
    limits: Limits,
    renderer: Renderer,
    loaded: Option<(LoadOptions, Loaded)>,
    /// The environment that was read last, and what it was asked for as.
    environment: Option<(Option<EnvironmentChoice>, Environment, Vec<Warning>)>,
}

#[wasm_bindgen]
impl Model {
    /// Takes over a model file. `names` and `contents` are the files that it refers to, and environments and material files
    /// that descriptions name; `limits` is a JSON object.
    ///
    /// # Errors
    /// If a name is no text, a content no `Uint8Array`, a limit unknown, or the model larger than `input_bytes`.
    #[wasm_bindgen(constructor)]
    pub fn new(bytes: Vec<u8>, names: Vec<String>, contents: &Array, limits: &str) -> Result<Self, JsValue> {
        let limits = limits::read(limits).map_err(about_options)?;
        let files = Files::new(names, contents)?;
        let renderer = Renderer::new(1);
        Ok(Self { bytes, files, limits, renderer, loaded: None, environment: None })
    }

    /// Adds a file, or replaces one.
    pub fn set_file(&mut self, name: String, content: Vec<u8>) {
        // Whether it is the one that was read, and what was loaded with it: read again, it is right either way.
        self.environment = None;
        if self.loaded.is_some() && self.files.resolver.files.contains_key(&name) {
            self.loaded = None;
        }
        self.files.resolver.files.insert(name, content);
    }

    /// Reads the model as a description (JSON) says, and tells what it is: a JSON object with its size, the middle of it, and
    /// how much there is.
    ///
    /// # Errors
    /// If the description or the model is wrong.
    pub fn info(&mut self, description: &str) -> Result<String, JsValue> {
        let description = Description::from_json(description).map_err(about_options)?;
        let loaded = self.load(&description).map_err(sentence)?;
        Ok(about(&loaded.scene, &loaded.warnings).to_string())
    }

    /// Draws what a description (JSON) says, with the planes of these names beside the pixels.
    ///
    /// # Errors
    /// If the description, the model or a file that either names is wrong, or a limit is exceeded.
    pub fn render(&mut self, description: &str, planes: Vec<String>) -> Result<Picture, JsValue> {
        let planes = crate::planes(&planes)?;
        let description = Description::from_json(description).map_err(about_options)?;
        self.draw(&description, planes).map_err(|error| match error.downcast_ref::<DescriptionError>() {
            Some(DescriptionError::Invalid(_) | DescriptionError::OutOfRange(_)) => about_options(error),
            _ => sentence(error),
        })
    }
}

impl Model {
    fn draw(
        &mut self,
        description: &Description,
        planes: Vec<Aov>,
    ) -> Result<Picture, Box<dyn std::error::Error>> {
        // What can be wrong with the description is found before a file is read.
        let (options, display) = description.options(Machine::default(), &self.limits)?;
        let Loaded { mut scene, mut warnings, .. } = self.load(description)?.clone();
        let setting = self.setting(description)?;
        setting.apply(description, &mut scene, &self.limits)?;
        warnings.extend(setting.warnings);
        let camera = description.camera(&scene, &options)?;
        let display = description.display_of(&scene, &display);
        let options = options.with_aovs(planes);
        let rendered = self.renderer.render(&scene, &camera, &options)?;
        let light = rendered.stats.reduced_light.as_ref();
        warnings.extend(light.map(|light| Warning::new(light.to_string())));
        Ok(Picture::new(rendered, &display, warnings))
    }

    /// The model, read again if it is to be read otherwise than the last time.
    fn load(&mut self, description: &Description) -> Result<&Loaded, DescriptionError> {
        let options = description.load_options()?;
        let loaded = match self.loaded.take() {
            Some((by, loaded)) if by == options => loaded,
            _ => {
                let context = self.files.context(&self.limits, self.renderer.jobs());
                load_bytes_with(&self.bytes, None, &options, &context)?
            }
        };
        Ok(&self.loaded.insert((options, loaded)).1)
    }

    /// Materials and light from afar. A picture of the surroundings is decoded once.
    fn setting(&mut self, description: &Description) -> Result<Setting, DescriptionError> {
        let context = self.files.context(&self.limits, self.renderer.jobs());
        let materials = Materials::load_from(description, &context)?;
        let (mut environment, warnings) = match self.environment.take() {
            Some((of, environment, warnings)) if of == description.env => (environment, warnings),
            _ => description.environment_from(&context)?,
        };
        environment.rotation_degrees = description.env_rotation_degrees.unwrap_or(0.0);
        environment.intensity = description.env_intensity.unwrap_or(1.0);
        self.environment = Some((description.env.clone(), environment.clone(), warnings.clone()));
        Ok(Setting::new(description, materials, (environment, warnings)))
    }
}

/// Summary of a loaded model.
pub(crate) fn about(scene: &Scene, warnings: &[Warning]) -> serde_json::Value {
    let warnings: Vec<&str> = warnings.iter().map(|warning| warning.message.as_str()).collect();
    let bounds = scene.shown_bounds();
    let materials: Vec<&str> = scene.materials().iter().map(|material| material.name.as_str()).collect();
    serde_json::json!({
        "triangles": scene.triangle_count(),
        "splats": scene.splat_count(),
        "instances": scene.instances().len(),
        "materials": materials,
        "cameras": scene.camera_names(),
        "min": bounds.min,
        "max": bounds.max,
        "warnings": warnings,
    })
}
