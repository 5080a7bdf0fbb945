//! From files in memory to frames, by the same steps as the command.

use super::files::{Files, MATERIALS, SCENE};
use super::recipe::{EnvironmentRecipe, Recipe};
use overcoat::description::{Description, EnvironmentChoice, Machine, MaterialSource};
use overcoat::frame::DisplayOptions;
use overcoat::jobs::Jobs;
use overcoat::limits::Limits;
use overcoat::load::NamedEnvironment;
use overcoat::load::{Context, LoadOptions, MaterialFile, MemoryResolver, load_bytes_with, load_environment};
use overcoat::render::RenderOptions;
use overcoat::scene::{Camera, EnvironmentSource, EquirectImage, Scene};
use overcoat_core::math::lanes::SimdLevel;
use overcoat_stages::light::PrefilteredEnvironment;
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

/// A scene that is loaded.
pub struct Shot {
    pub scene: Scene,
    pub camera: Camera,
    pub options: RenderOptions,
    pub display: DisplayOptions,
}

impl Shot {
    /// Loads the files of a recipe. With `skies`, pictures of the environment are decoded and filtered once for all.
    pub fn load(files: &Files, recipe: &Recipe, jobs: &Jobs, skies: Option<&Skies>) -> Result<Self, String> {
        let limits = &Limits::default();
        let text = std::str::from_utf8(files.get(SCENE)?).map_err(|e| e.to_string())?;
        let mut file = Description::from_toml(text).map_err(|e| format!("{SCENE}: {e}"))?;
        let (mut options, display) = file.options(Machine::default(), limits).map_err(|e| e.to_string())?;
        options.aovs.clone_from(&recipe.aovs);
        options.stage_hashes = true;

        let model = file.model.as_ref().and_then(|path| path.to_str()).unwrap_or_default();
        let resolver = MemoryResolver { files: files.0.clone() };
        let context = Context { resolver: &resolver, limits, jobs };
        let animation = file.animation_choice().map_err(|e| e.to_string())?;
        let options_of_load = LoadOptions::default().with_animation(animation);
        let loaded = load_bytes_with(files.get(model)?, Some(recipe.container), &options_of_load, &context)
            .map_err(|e| format!("{model}: {e}"))?;
        // Recipes ask only for supported features, so a warning is a mistake of either.
        if let Some(warning) = loaded.warnings.first() {
            return Err(format!("{model}: {warning}"));
        }
        let mut scene = loaded.scene;
        let below: BTreeMap<String, Vec<u8>> = files
            .0
            .iter()
            .filter_map(|(name, bytes)| Some((name.strip_prefix(MATERIALS)?.to_owned(), bytes.clone())))
            .collect();
        let resolver = MemoryResolver { files: below };
        for choice in file.material_choices() {
            let MaterialSource::File(path) = &choice.source else { continue };
            let path = path.to_str().unwrap_or_default();
            let context = Context { resolver: &resolver, limits, jobs };
            MaterialFile::from_bytes(files.get(path)?, &context)
                .map_err(|e| format!("{path}: {e}"))?
                .assign(&mut scene, choice.name.as_deref(), limits)
                .map_err(|e| format!("{path}: {e}"))?;
        }
        let mut sky = None;
        if let Some(EnvironmentChoice::File(path)) = &file.env {
            sky = Some(match skies {
                Some(skies) => skies.get(recipe.environment, jobs)?.0,
                None => picture(files.get(path.to_str().unwrap_or_default())?, jobs)?,
            });
            file.env = Some(EnvironmentChoice::Named(NamedEnvironment::None));
        }
        file.light(&mut scene, limits, jobs).map_err(|e| e.to_string())?;
        if let Some(sky) = sky {
            let environment = scene.environment().clone().with(|e| e.source = EnvironmentSource::Image(sky));
            scene.set_environment(environment).map_err(|e| e.to_string())?;
        }
        let camera = file.camera(&scene, &options).map_err(|e| e.to_string())?;
        Ok(Self { scene, camera, options, display })
    }
}

/// Decodes an environment.
fn picture(bytes: &[u8], jobs: &Jobs) -> Result<Arc<EquirectImage>, String> {
    let resolver = MemoryResolver::default();
    let context = Context { resolver: &resolver, limits: &Limits::default(), jobs };
    load_environment(bytes, &context).map(|loaded| Arc::new(loaded.image)).map_err(|e| e.to_string())
}

/// A picture, and what filtering makes of it.
pub type Sky = (Arc<EquirectImage>, Arc<PrefilteredEnvironment>);

/// Environments that many recipes share, decoded and filtered once.
#[derive(Default)]
pub struct Skies(Mutex<BTreeMap<EnvironmentRecipe, Sky>>);

impl Skies {
    /// The picture of a recipe's environment.
    pub fn get(&self, which: EnvironmentRecipe, jobs: &Jobs) -> Result<Sky, String> {
        let mut known = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(sky) = known.get(&which) {
            return Ok(sky.clone());
        }
        let files = Files::of(&Recipe { environment: which, ..Recipe::empty() })?;
        let name = if matches!(which, EnvironmentRecipe::Hdr(_)) { "sky.hdr" } else { "sky.exr" };
        let decoded = picture(files.get(name)?, jobs)?;
        let filtered = Arc::new(PrefilteredEnvironment::new(&decoded, jobs, SimdLevel::best()));
        known.insert(which, (Arc::clone(&decoded), Arc::clone(&filtered)));
        Ok((decoded, filtered))
    }

    /// Prefiltered environment of a recipe, which a renderer takes in place of filtering it; `None` where it is not a
    /// picture.
    pub fn filtered(
        &self,
        which: EnvironmentRecipe,
        jobs: &Jobs,
    ) -> Result<Option<Arc<PrefilteredEnvironment>>, String> {
        match which {
            EnvironmentRecipe::None | EnvironmentRecipe::Studio => Ok(None),
            picture => self.get(picture, jobs).map(|(_, filtered)| Some(filtered)),
        }
    }
}
