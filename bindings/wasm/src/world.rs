//! A scene that is kept: a world of the library, whose names are whole numbers (`BigInt`) in JavaScript. `Scene` and its handles
//! are made of them in `js/scene.js`.

use crate::arrays::{MeshArrays, transform};
use crate::files::Files;
use crate::model::about;
use crate::picture::Picture;
use crate::world_materials::{clay, made};
use crate::{about_options, limits, of_description, of_world, planes, sentence};
use js_sys::Array;
use overcoat::description::{Description, Machine, Materials};
use overcoat::frame::DisplayOptions;
use overcoat::load::{AnimatedModel, Loaded, Warning, load_bytes_with};
use overcoat::scene::{Camera, Environment, Light};
use overcoat::world::{InstanceHandle, LightHandle, MaterialHandle, MeshHandle, ModelHandle};
use overcoat::{Limits, RenderOptions, Renderer, Scene};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use wasm_bindgen::JsValue;
use wasm_bindgen::prelude::wasm_bindgen;

type Done<T> = Result<T, JsValue>;

/// Subject of a warning.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum About {
    Model(ModelHandle),
    Pose(ModelHandle),
    Material(MaterialHandle),
    Environment,
}

/// A scene whose parts have names.
#[wasm_bindgen]
pub struct World {
    world: overcoat::world::World,
    limits: Limits,
    renderer: Renderer,
    /// Features that pictures of it lack.
    warnings: BTreeMap<About, Vec<Warning>>,
    /// The last view, with its description, while nothing has changed: framing visits every triangle.
    view: Option<(String, View)>,
}

/// Camera and options of a picture.
#[derive(Clone)]
struct View {
    description: Description,
    options: RenderOptions,
    display: DisplayOptions,
    camera: Camera,
}

#[wasm_bindgen]
impl World {
    /// An empty one under the studio. `limits` is a JSON object.
    ///
    /// # Errors
    /// If a limit is unknown.
    #[wasm_bindgen(constructor)]
    pub fn new(limits: &str) -> Done<Self> {
        let limits = limits::read(limits).map_err(about_options)?;
        Ok(Self {
            world: overcoat::world::World::new(),
            limits,
            renderer: Renderer::new(1),
            warnings: BTreeMap::new(),
            view: None,
        })
    }

    /// Adds a model file as a description (JSON) says that has keys of loading and materials. Returns [`World::parts`] of it, with
    /// what it is.
    ///
    /// # Errors
    /// If the description, the model, one of the files or the matrix is wrong.
    pub fn add_model(
        &mut self,
        bytes: &[u8],
        description: &str,
        matrix: &[f64],
        names: Vec<String>,
        contents: &Array,
    ) -> Done<String> {
        self.view = None;
        let place = transform(matrix)?;
        let description = Description::from_json(description).map_err(about_options)?;
        let options = description.load_options().map_err(of_description)?;
        let files = Files::new(names, contents)?;
        let context = files.context(&self.limits, self.renderer.jobs());
        let jobs = self.renderer.jobs();
        let (model, info) = if let Some(animation) = &options.animation {
            let source = AnimatedModel::from_bytes(bytes, None, &options, &context).map_err(sentence)?;
            let posed = source.at(animation.time, jobs).map_err(sentence)?;
            let info = about(&posed.scene, &posed.warnings);
            let (model, _) = self.world.add_animated_model(source, place, jobs).map_err(of_world)?;
            let warnings = self.world.set_pose(model, animation.time, jobs).map_err(of_world)?;
            self.warnings.insert(About::Pose(model), warnings);
            (model, info)
        } else {
            let mut loaded = load_bytes_with(bytes, None, &options, &context).map_err(sentence)?;
            let materials = Materials::load_from(&description, &context).map_err(of_description)?;
            materials.assign(&mut loaded.scene, &self.limits).map_err(of_description)?;
            let mut warnings = std::mem::take(&mut loaded.warnings);
            warnings.extend(materials.warnings());
            let info = about(&loaded.scene, &warnings);
            let model = self.world.add_model(&Loaded::from(loaded.scene), place).map_err(of_world)?;
            self.warnings.insert(About::Model(model), warnings);
            (model, info)
        };
        self.parts(model, Some(info))
    }

    /// Brings a model to a time of its animation. Returns [`World::parts`], of which there may be more.
    ///
    /// # Errors
    /// If the time is none, or the model has no animation or is not there.
    pub fn set_pose(&mut self, model: u64, seconds: f64) -> Done<String> {
        self.view = None;
        let handle = ModelHandle::from_bits(model);
        if self.world.animation_length(handle).map_err(of_world)?.is_none() {
            return Err(about_options("pose: the model was added without an animation"));
        }
        if !(seconds >= 0.0 && seconds.is_finite()) {
            return Err(about_options(format!("pose: expected seconds from 0 on, found {seconds}")));
        }
        let warnings = self.world.set_pose(handle, seconds, self.renderer.jobs()).map_err(of_world)?;
        self.warnings.insert(About::Pose(handle), warnings);
        self.parts(handle, None)
    }

    /// Adds a mesh: three numbers a position, three vertices a triangle, three numbers a normal, two a texture coordinate, four a
    /// colour (linear, straight alpha). Without indices each three vertices are a triangle. Without normals smooth ones are found,
    /// with edges where faces meet at more than `crease_deg`, if it is above 0. `kind` is `triangles`, `lines` (two vertices each) or
    /// `points` (one).
    ///
    /// # Errors
    /// If the arrays do not go together.
    #[allow(clippy::too_many_arguments, reason = "one for each array")]
    pub fn add_mesh(
        &mut self,
        positions: Vec<f32>,
        indices: Option<Vec<u32>>,
        normals: Option<Vec<f32>>,
        uvs: Option<Vec<f32>>,
        colors: Option<Vec<f32>>,
        crease_deg: f32,
        kind: &str,
    ) -> Done<u64> {
        self.view = None;
        let arrays = MeshArrays { positions, indices, normals, uvs, colors };
        let mesh = arrays.mesh(kind, crease_deg, &self.limits)?;
        Ok(self.world.add_mesh(mesh).map_err(of_world)?.to_bits())
    }

    /// Puts another mesh in the place of one.
    ///
    /// # Errors
    /// As [`World::add_mesh`]; if the mesh is not there.
    #[allow(clippy::too_many_arguments, reason = "one for each array")]
    pub fn set_mesh(
        &mut self,
        mesh: u64,
        positions: Vec<f32>,
        indices: Option<Vec<u32>>,
        normals: Option<Vec<f32>>,
        uvs: Option<Vec<f32>>,
        colors: Option<Vec<f32>>,
        crease_deg: f32,
        kind: &str,
    ) -> Done<()> {
        self.view = None;
        let arrays = MeshArrays { positions, indices, normals, uvs, colors };
        let with = arrays.mesh(kind, crease_deg, &self.limits)?;
        self.world.set_mesh(MeshHandle::from_bits(mesh), with).map_err(of_world)
    }

    /// Adds a material: JSON of a name, of the keys of a material file, or null for clay.
    ///
    /// # Errors
    /// If the material or one of its textures is wrong.
    pub fn add_material(&mut self, source: &str, names: Vec<String>, contents: &Array) -> Done<u64> {
        self.view = None;
        let files = Files::new(names, contents)?;
        let context = files.context(&self.limits, self.renderer.jobs());
        let (made, warnings) = made(source, clay(), self.world.scene(), (&context, &files.pictures))?;
        let handle = self.world.add_textured_material(made).map_err(of_world)?;
        self.warnings.insert(About::Material(handle), warnings);
        Ok(handle.to_bits())
    }

    /// Puts another material in the place of one.
    ///
    /// # Errors
    /// As [`World::add_material`]; if the material is not there.
    pub fn set_material(
        &mut self,
        material: u64,
        source: &str,
        names: Vec<String>,
        contents: &Array,
    ) -> Done<()> {
        self.view = None;
        let handle = MaterialHandle::from_bits(material);
        let over = self.world.material(handle).map_err(of_world)?.clone();
        let files = Files::new(names, contents)?;
        let context = files.context(&self.limits, self.renderer.jobs());
        let (made, warnings) = made(source, over, self.world.scene(), (&context, &files.pictures))?;
        self.world.set_textured_material(handle, made).map_err(of_world)?;
        self.warnings.insert(About::Material(handle), warnings);
        Ok(())
    }

    /// Places a mesh.
    ///
    /// # Errors
    /// If the matrix is wrong, or the mesh or the material is not there.
    pub fn add_instance(&mut self, mesh: u64, material: u64, matrix: &[f64]) -> Done<u64> {
        self.view = None;
        let (mesh, material) = (MeshHandle::from_bits(mesh), MaterialHandle::from_bits(material));
        Ok(self.world.add_instance(mesh, material, transform(matrix)?).map_err(of_world)?.to_bits())
    }

    /// Makes an instance one of another mesh.
    ///
    /// # Errors
    /// If one of them is not there.
    pub fn set_instance_mesh(&mut self, instance: u64, mesh: u64) -> Done<()> {
        self.view = None;
        let (instance, mesh) = (InstanceHandle::from_bits(instance), MeshHandle::from_bits(mesh));
        self.world.set_instance_mesh(instance, mesh).map_err(of_world)
    }

    /// Makes an instance one of another material.
    ///
    /// # Errors
    /// If one of them is not there.
    pub fn set_instance_material(&mut self, instance: u64, material: u64) -> Done<()> {
        self.view = None;
        let (instance, material) = (InstanceHandle::from_bits(instance), MaterialHandle::from_bits(material));
        self.world.set_instance_material(instance, material).map_err(of_world)
    }

    /// Moves an instance or a model: sixteen numbers, column by column.
    ///
    /// # Errors
    /// If the matrix is wrong, or what is to move is not there.
    pub fn set_transform(&mut self, kind: &str, handle: u64, matrix: &[f64]) -> Done<()> {
        self.view = None;
        let place = transform(matrix)?;
        let done = match kind {
            "model" => self.world.set_model_transform(ModelHandle::from_bits(handle), place),
            _ => self.world.set_transform(InstanceHandle::from_bits(handle), place),
        };
        done.map_err(of_world)
    }

    /// Transform of an instance or a model.
    ///
    /// # Errors
    /// If it is not there.
    pub fn transform(&self, kind: &str, handle: u64) -> Done<Vec<f64>> {
        let place = match kind {
            "model" => self.world.model_transform(ModelHandle::from_bits(handle)),
            _ => self.world.transform(InstanceHandle::from_bits(handle)),
        };
        let [x, y, z] = *place.map_err(of_world)?.rows();
        Ok((0..4).flat_map(|k| [x[k], y[k], z[k], if k == 3 { 1.0 } else { 0.0 }]).collect())
    }

    /// Hides an instance or a model, or shows it again.
    ///
    /// # Errors
    /// If it is not there.
    pub fn set_visible(&mut self, kind: &str, handle: u64, visible: bool) -> Done<()> {
        self.view = None;
        let done = match kind {
            "model" => self.world.set_model_visible(ModelHandle::from_bits(handle), visible),
            _ => self.world.set_visible(InstanceHandle::from_bits(handle), visible),
        };
        done.map_err(of_world)
    }

    /// Adds a light: JSON with the keys of scene files.
    ///
    /// # Errors
    /// If one of them is wrong.
    pub fn add_light(&mut self, json: &str) -> Done<u64> {
        self.view = None;
        let light = self.light(json)?;
        Ok(self.world.add_light(light).map_err(of_world)?.to_bits())
    }

    /// Puts another light in the place of one.
    ///
    /// # Errors
    /// As [`World::add_light`]; if the light is not there.
    pub fn set_light(&mut self, light: u64, json: &str) -> Done<()> {
        self.view = None;
        let with = self.light(json)?;
        self.world.set_light(LightHandle::from_bits(light), with).map_err(of_world)
    }

    /// The environment of a description (JSON). What is not in it stays as it is.
    ///
    /// # Errors
    /// If the description or the picture is wrong.
    pub fn set_environment(&mut self, description: &str, names: Vec<String>, contents: &Array) -> Done<()> {
        self.view = None;
        let description = Description::from_json(description).map_err(about_options)?;
        let own = self.world.scene().environment().clone();
        let files = Files::new(names, contents)?;
        let mut warnings = None;
        let source = if description.env.is_some() {
            let context = files.context(&self.limits, self.renderer.jobs());
            let (environment, found) = description.environment_from(&context).map_err(of_description)?;
            warnings = Some(found);
            environment.source
        } else {
            own.source
        };
        let environment = Environment::default().with(|e| {
            e.source = source;
            e.rotation_degrees = description.env_rotation_degrees.unwrap_or(own.rotation_degrees);
            e.intensity = description.env_intensity.unwrap_or(own.intensity);
        });
        self.world.set_environment(environment).map_err(of_world)?;
        if let Some(warnings) = warnings {
            self.warnings.insert(About::Environment, warnings);
        }
        Ok(())
    }

    /// Removes what is named.
    ///
    /// # Errors
    /// If it is not there, or something needs it.
    pub fn remove(&mut self, kind: &str, handle: u64) -> Done<()> {
        self.view = None;
        let world = &mut self.world;
        match kind {
            "model" => {
                let model = ModelHandle::from_bits(handle);
                world.remove_model(model).map_err(of_world)?;
                self.warnings.remove(&About::Model(model));
                self.warnings.remove(&About::Pose(model));
            }
            "instance" => world.remove_instance(InstanceHandle::from_bits(handle)).map_err(of_world)?,
            "mesh" => world.remove_mesh(MeshHandle::from_bits(handle)).map_err(of_world)?,
            "light" => world.remove_light(LightHandle::from_bits(handle)).map_err(of_world)?,
            _ => world.remove_material(MaterialHandle::from_bits(handle)).map_err(of_world)?,
        }
        self.warnings.retain(|about, _| !matches!(about, About::Material(m) if world.material(*m).is_err()));
        Ok(())
    }

    /// Draws it as a description (JSON) says, with the planes of these names beside the pixels.
    ///
    /// # Errors
    /// If the description is wrong, or a limit is exceeded.
    pub fn render(&mut self, description: &str, names: Vec<String>) -> Done<Picture> {
        let planes = planes(&names)?;
        let View { description, options, display, camera } = self.view(description)?;
        let options = options.with_aovs(planes);
        let rendered = self.renderer.render(self.world.scene(), &camera, &options).map_err(sentence)?;
        let warnings = description.warnings.iter().chain(self.warnings.values().flatten()).cloned();
        let light = rendered.stats.reduced_light.as_ref().map(|light| Warning::new(light.to_string()));
        let warnings = warnings.chain(light).collect();
        Ok(Picture::new(rendered, &display, warnings))
    }

    /// The surface in a pixel of the picture that [`World::render`] draws: a JSON object with its instance, model and material as
    /// text, nothing where there is nothing.
    ///
    /// # Errors
    /// As there; if the pixel is not in the picture.
    pub fn pick(&mut self, description: &str, x: u32, y: u32) -> Done<Option<String>> {
        let View { options, camera, .. } = self.view(description)?;
        let scene = self.world.scene();
        let hit = self.renderer.pick(scene, &camera, &options, [x, y]).map_err(about_options)?;
        let Some((hit, instance)) = hit.and_then(|hit| Some((hit, self.world.instance(hit.instance)?)))
        else {
            return Ok(None);
        };
        let model = self.world.model_of(instance).map_err(of_world)?;
        let material = self.world.instance_material(instance).map_err(of_world)?;
        let origin = scene.origin();
        let position: [f64; 3] = std::array::from_fn(|k| hit.position[k] + origin[k]);
        let found = json!({
            "instance": text(instance.to_bits()),
            "model": model.map(|model| text(model.to_bits())),
            "material": text(material.to_bits()),
            "triangle": hit.primitive,
            "vertices": hit.vertices,
            "barycentric": hit.barycentric,
            "depth": hit.depth,
            "position": position,
            "back_facing": hit.back_facing,
        });
        Ok(Some(found.to_string()))
    }
}

/// A name in JSON, whose numbers have 53 bits in JavaScript.
fn text(bits: u64) -> String {
    bits.to_string()
}

impl World {
    /// View of the world by a description (JSON).
    fn view(&mut self, json: &str) -> Done<View> {
        if let Some((of, view)) = &self.view
            && of == json
        {
            return Ok(view.clone());
        }
        let description = Description::from_json(json).map_err(about_options)?;
        let (options, display) =
            description.options(Machine::default(), &self.limits).map_err(of_description)?;
        let scene = self.world.scene();
        let camera = description.camera(scene, &options).map_err(of_description)?;
        let display = description.display_of(scene, &display);
        let view = View { description, options, display, camera };
        self.view = Some((json.to_owned(), view.clone()));
        Ok(view)
    }

    /// A model and what is in it, as a JSON object: names as text, materials with what they are called in the file.
    fn parts(&self, model: ModelHandle, info: Option<Value>) -> Done<String> {
        let world = &self.world;
        let instances = world.model_instances(model).map_err(of_world)?;
        // Those that were removed by themselves are still among the names.
        let instances = instances.into_iter().filter(|instance| world.visible(*instance).is_ok());
        let instances: Vec<String> = instances.map(|instance| text(instance.to_bits())).collect();
        let materials = world.model_materials(model).map_err(of_world)?.into_iter();
        let named = |material: MaterialHandle| {
            let name = world.material(material).ok()?.name.clone();
            Some((text(material.to_bits()), name))
        };
        let materials: Vec<(String, String)> = materials.filter_map(named).collect();
        let lights = world.model_lights(model).map_err(of_world)?.into_iter();
        let lights = lights.filter(|light| world.light(*light).is_ok());
        let lights: Vec<String> = lights.map(|light| text(light.to_bits())).collect();
        let duration = world.animation_length(model).map_err(of_world)?;
        let model = text(model.to_bits());
        let found = json!({
            "model": model,
            "instances": instances,
            "materials": materials,
            "lights": lights,
            "duration": duration,
            "info": info,
        });
        Ok(found.to_string())
    }

    /// A light that is described.
    fn light(&self, json: &str) -> Done<Light> {
        let description =
            Description::from_json(&format!(r#"{{"light":[{json}]}}"#)).map_err(about_options)?;
        let mut scene = Scene::new();
        scene.set_origin(self.world.scene().origin());
        for light in &description.lights_to_add {
            light.add_to(&mut scene, 0).map_err(about_options)?;
        }
        scene.lights().first().copied().ok_or_else(|| about_options("light: there is none"))
    }
}
