//! Scenes that change: a world of the library, whose names are numbers here. `overcoat.Scene` and its handles are made of them in
//! `python/overcoat/_scene.py`.
//!
//! Pictures are drawn of the scene as it is when they begin: of a copy, which shares meshes and textures with the world and is made
//! once for each state. So the lock is held only with the interpreter, as in [`crate::pool`], and nobody waits for a picture who
//! changes something.

use crate::arithmetic::DefaultArithmetic;
use crate::arrays::transform;
use crate::builder::MeshArrays;
use crate::errors::{self, Kind};
use crate::model::Model;
use crate::options::{GivenRequest, Request, limits, loading, read};
use crate::orbit::Orbit;
use crate::renderer::{Renderer, format_of};
use crate::world_materials::{clay, lay, make};
use numpy::PyReadonlyArray2;
use overcoat::Scene;
use overcoat::jobs::Jobs;
use overcoat::load::{AnimatedModel, Context, Loaded, NoResolver, Warning};
use overcoat::scene::{EnvironmentSource, Light, Transform};
use overcoat::world::{
    self, InstanceHandle, LightHandle, MaterialHandle, MeshHandle, ModelHandle, WorldError,
};
use pyo3::prelude::*;
use pyo3::pybacked::PyBackedBytes;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// See the module.
#[pyclass(frozen, module = "overcoat._overcoat")]
#[derive(Debug, Default)]
pub(crate) struct World(Mutex<Kept>);

#[derive(Debug, Default)]
struct Kept {
    world: world::World,
    /// The scene as it is, until it changes.
    shown: Option<Py<Model>>,
}

/// A matrix of 16 numbers by rows.
type Matrix = [[f64; 4]; 4];

fn matrix(transform: &Transform) -> Matrix {
    let [first, second, third] = *transform.rows();
    [first, second, third, [0.0, 0.0, 0.0, 1.0]]
}

fn messages(warnings: Vec<Warning>) -> Vec<String> {
    warnings.into_iter().map(|warning| warning.message).collect()
}

impl World {
    fn lock(&self) -> MutexGuard<'_, Kept> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn look<T>(&self, f: impl FnOnce(&world::World) -> Result<T, WorldError>) -> PyResult<T> {
        let done = f(&self.lock().world);
        done.map_err(|e| errors::world(&e))
    }

    fn change<T>(&self, f: impl FnOnce(&mut world::World) -> Result<T, WorldError>) -> PyResult<T> {
        let _arithmetic = DefaultArithmetic::new();
        let done = {
            let mut kept = self.lock();
            // What is refused may have changed something all the same.
            kept.shown = None;
            f(&mut kept.world)
        };
        // Exceptions are objects of Python, whose making may run anything: not under the lock.
        done.map_err(|e| errors::world(&e))
    }

    /// The name of a draw of a scene that [`World::model`] has given, if nothing has changed since.
    pub(crate) fn instance_in(&self, model: &Py<Model>, number: usize) -> Option<u64> {
        let kept = self.lock();
        let is_same = kept.shown.as_ref().is_some_and(|shown| shown.is(model));
        kept.world.instance(number).filter(|_| is_same).map(InstanceHandle::to_bits)
    }

    /// A light that a description as JSON has.
    fn light_of(&self, json: &str) -> PyResult<Light> {
        let description = read(json)?;
        let mut scene = Scene::new();
        scene.set_origin(self.lock().world.scene().origin());
        for light in &description.lights_to_add {
            light.add_to(&mut scene, 0).map_err(|error| {
                let message = error.to_string();
                let message = message.strip_prefix("light 0: ").unwrap_or(&message);
                Kind::Option.error(format_args!("light: {message}"))
            })?;
        }
        scene.lights().first().copied().ok_or_else(|| Kind::Option.error("light: there is none"))
    }

    fn mesh_of(
        py: Python<'_>,
        arrays: MeshArrays<'_>,
        kind: &str,
        crease: Option<f32>,
        tangents_of: Option<usize>,
    ) -> PyResult<overcoat::scene::Mesh> {
        arrays.mesh(py, kind, crease, tangents_of)
    }
}

#[pymethods]
impl World {
    #[new]
    fn new() -> Self {
        Self::default()
    }

    /// The scene as it is now, which does not change with this one.
    pub(crate) fn model(&self, py: Python<'_>) -> PyResult<Py<Model>> {
        let scene = {
            let kept = self.lock();
            if let Some(shown) = &kept.shown {
                return Ok(shown.clone_ref(py));
            }
            kept.world.scene().clone()
        };
        let model = Py::new(py, Model::lit(scene))?;
        self.lock().shown = Some(model.clone_ref(py));
        Ok(model)
    }

    /// Adds a model that has been loaded, with materials laid over it. Returns what is doubtful about these, too.
    fn add_model(
        &self,
        py: Python<'_>,
        renderer: &Bound<'_, Renderer>,
        model: &Bound<'_, Model>,
        request: GivenRequest<'_>,
        matrix: PyReadonlyArray2<'_, f64>,
    ) -> PyResult<(u64, Vec<String>)> {
        let (transform, request) = (transform(&matrix)?, Request::new(request)?);
        let scene = &model.get().scene;
        let (scene, warnings) = renderer.get().pool.with(py, |renderer| -> PyResult<_> {
            let mut scene = Scene::clone(scene);
            let warnings = lay(&mut scene, &request, renderer.jobs())?;
            Ok((scene, warnings))
        })??;
        let handle = self.change(|world| world.add_model(&Loaded::from(scene), transform))?;
        Ok((handle.to_bits(), warnings))
    }

    /// Adds a model with the animation that the description chooses, at its time. Returns what is lost, too.
    #[allow(clippy::too_many_arguments)]
    fn add_animated_model(
        &self,
        py: Python<'_>,
        renderer: &Bound<'_, Renderer>,
        path: Option<PathBuf>,
        bytes: Option<PyBackedBytes>,
        format: Option<&str>,
        description: &str,
        given_limits: BTreeMap<String, u64>,
        matrix: PyReadonlyArray2<'_, f64>,
    ) -> PyResult<(u64, Vec<String>)> {
        let (transform, options) = (transform(&matrix)?, loading(description)?);
        let time = options.animation.as_ref().map_or(0.0, |animation| animation.time);
        let limits = limits(&given_limits)?;
        let format = format.map(format_of).transpose()?;
        let source = renderer.get().pool.with(py, |renderer| match &path {
            Some(path) => AnimatedModel::open(path, &options, &limits, renderer.jobs()),
            None => {
                let context = Context { resolver: &NoResolver, limits: &limits, jobs: renderer.jobs() };
                AnimatedModel::from_bytes(bytes.as_deref().unwrap_or_default(), format, &options, &context)
            }
        })?;
        let source = source.map_err(|e| errors::load(&e, path.as_deref()))?;
        let jobs = Jobs::new(1);
        let (handle, mut warnings) =
            self.change(|world| world.add_animated_model(source, transform, &jobs))?;
        if time > 0.0 {
            warnings = self.change(|world| world.set_pose(handle, time, &jobs))?;
        }
        Ok((handle.to_bits(), messages(warnings)))
    }

    fn set_pose(&self, model: u64, seconds: f64) -> PyResult<Vec<String>> {
        let handle = ModelHandle::from_bits(model);
        if self.look(|world| world.animation_length(handle))?.is_none() {
            return Err(Kind::Option.error("pose: the model was added without an animation"));
        }
        if !(seconds >= 0.0 && seconds.is_finite()) {
            return Err(Kind::Option.error(format_args!("pose: {seconds}: expected seconds, at least 0")));
        }
        Ok(messages(self.change(|world| world.set_pose(handle, seconds, &Jobs::new(1)))?))
    }

    fn animation_length(&self, model: u64) -> PyResult<Option<f64>> {
        self.look(|world| world.animation_length(ModelHandle::from_bits(model)))
    }

    fn remove_model(&self, model: u64) -> PyResult<()> {
        self.change(|world| world.remove_model(ModelHandle::from_bits(model)))
    }

    fn model_transform(&self, model: u64) -> PyResult<Matrix> {
        self.look(|world| Ok(matrix(&world.model_transform(ModelHandle::from_bits(model))?)))
    }

    fn set_model_transform(&self, model: u64, matrix: PyReadonlyArray2<'_, f64>) -> PyResult<()> {
        let transform = transform(&matrix)?;
        self.change(|world| world.set_model_transform(ModelHandle::from_bits(model), transform))
    }

    fn model_visible(&self, model: u64) -> PyResult<bool> {
        self.look(|world| world.model_visible(ModelHandle::from_bits(model)))
    }

    fn set_model_visible(&self, model: u64, visible: bool) -> PyResult<()> {
        self.change(|world| world.set_model_visible(ModelHandle::from_bits(model), visible))
    }

    fn model_instances(&self, model: u64) -> PyResult<Vec<u64>> {
        let all = self.look(|world| world.model_instances(ModelHandle::from_bits(model)))?;
        let world = &self.lock().world;
        // Those that were removed by themselves are still among the names.
        let is_there = |instance: &InstanceHandle| world.visible(*instance).is_ok();
        Ok(all.into_iter().filter(is_there).map(InstanceHandle::to_bits).collect())
    }

    fn model_materials(&self, model: u64) -> PyResult<Vec<u64>> {
        let all = self.look(|world| world.model_materials(ModelHandle::from_bits(model)))?;
        let world = &self.lock().world;
        let is_there = |material: &MaterialHandle| world.material(*material).is_ok();
        Ok(all.into_iter().filter(is_there).map(MaterialHandle::to_bits).collect())
    }

    fn model_lights(&self, model: u64) -> PyResult<Vec<u64>> {
        let all = self.look(|world| world.model_lights(ModelHandle::from_bits(model)))?;
        let world = &self.lock().world;
        let is_there = |light: &LightHandle| world.light(*light).is_ok();
        Ok(all.into_iter().filter(is_there).map(LightHandle::to_bits).collect())
    }

    fn model_cameras(&self, model: u64) -> PyResult<Vec<(String, Orbit)>> {
        self.look(|world| {
            let cameras = world.model_cameras(ModelHandle::from_bits(model))?;
            let orbit = |camera| Orbit::from_camera(&camera, world.scene());
            Ok(cameras.into_iter().map(|(name, camera)| (name, orbit(camera))).collect())
        })
    }

    /// A mesh of arrays, see `SceneBuilder.add_mesh`.
    #[pyo3(signature = (positions, indices, normals=None, uv=None, colors=None, kind="triangles", crease_degrees=None, tangents_of=None))]
    #[allow(clippy::too_many_arguments)]
    fn add_mesh(
        &self,
        py: Python<'_>,
        positions: PyReadonlyArray2<'_, f32>,
        indices: PyReadonlyArray2<'_, u32>,
        normals: Option<PyReadonlyArray2<'_, f32>>,
        uv: Option<PyReadonlyArray2<'_, f32>>,
        colors: Option<PyReadonlyArray2<'_, f32>>,
        kind: &str,
        crease_degrees: Option<f32>,
        tangents_of: Option<usize>,
    ) -> PyResult<u64> {
        let arrays = MeshArrays { positions, indices, normals, uv, colors };
        let mesh = Self::mesh_of(py, arrays, kind, crease_degrees, tangents_of)?;
        Ok(self.change(|world| world.add_mesh(mesh))?.to_bits())
    }

    /// Puts another mesh in the place of one.
    #[pyo3(signature = (mesh, positions, indices, normals=None, uv=None, colors=None, kind="triangles", crease_degrees=None, tangents_of=None))]
    #[allow(clippy::too_many_arguments)]
    fn set_mesh(
        &self,
        py: Python<'_>,
        mesh: u64,
        positions: PyReadonlyArray2<'_, f32>,
        indices: PyReadonlyArray2<'_, u32>,
        normals: Option<PyReadonlyArray2<'_, f32>>,
        uv: Option<PyReadonlyArray2<'_, f32>>,
        colors: Option<PyReadonlyArray2<'_, f32>>,
        kind: &str,
        crease_degrees: Option<f32>,
        tangents_of: Option<usize>,
    ) -> PyResult<()> {
        let arrays = MeshArrays { positions, indices, normals, uv, colors };
        let with = Self::mesh_of(py, arrays, kind, crease_degrees, tangents_of)?;
        self.change(|world| world.set_mesh(MeshHandle::from_bits(mesh), with))
    }

    fn remove_mesh(&self, mesh: u64) -> PyResult<()> {
        self.change(|world| world.remove_mesh(MeshHandle::from_bits(mesh)))
    }

    /// A material that a request names, laid over clay.
    fn add_material(
        &self,
        py: Python<'_>,
        renderer: &Bound<'_, Renderer>,
        request: GivenRequest<'_>,
    ) -> PyResult<(u64, Vec<String>)> {
        let request = Request::new(request)?;
        let textures = self.lock().world.scene().textures().to_vec();
        let (made, warnings) =
            renderer.get().pool.with(py, |renderer| make(clay(), &textures, &request, renderer.jobs()))??;
        let handle = self.change(|world| world.add_textured_material(made))?;
        Ok((handle.to_bits(), warnings))
    }

    /// Puts a material that a request names in the place of one.
    fn set_material(
        &self,
        py: Python<'_>,
        renderer: &Bound<'_, Renderer>,
        material: u64,
        request: GivenRequest<'_>,
    ) -> PyResult<Vec<String>> {
        let (handle, request) = (MaterialHandle::from_bits(material), Request::new(request)?);
        let over = self.look(|world| world.material(handle).cloned())?;
        let textures = self.lock().world.scene().textures().to_vec();
        let (made, warnings) =
            renderer.get().pool.with(py, |renderer| make(over, &textures, &request, renderer.jobs()))??;
        self.change(|world| world.set_textured_material(handle, made))?;
        Ok(warnings)
    }

    fn material_name(&self, material: u64) -> PyResult<String> {
        self.look(|world| Ok(world.material(MaterialHandle::from_bits(material))?.name.clone()))
    }

    fn remove_material(&self, material: u64) -> PyResult<()> {
        self.change(|world| world.remove_material(MaterialHandle::from_bits(material)))
    }

    fn add_instance(&self, mesh: u64, material: u64, matrix: PyReadonlyArray2<'_, f64>) -> PyResult<u64> {
        let transform = transform(&matrix)?;
        let (mesh, material) = (MeshHandle::from_bits(mesh), MaterialHandle::from_bits(material));
        Ok(self.change(|world| world.add_instance(mesh, material, transform))?.to_bits())
    }

    fn remove_instance(&self, instance: u64) -> PyResult<()> {
        self.change(|world| world.remove_instance(InstanceHandle::from_bits(instance)))
    }

    fn transform(&self, instance: u64) -> PyResult<Matrix> {
        self.look(|world| Ok(matrix(&world.transform(InstanceHandle::from_bits(instance))?)))
    }

    fn set_transform(&self, instance: u64, matrix: PyReadonlyArray2<'_, f64>) -> PyResult<()> {
        let transform = transform(&matrix)?;
        self.change(|world| world.set_transform(InstanceHandle::from_bits(instance), transform))
    }

    fn visible(&self, instance: u64) -> PyResult<bool> {
        self.look(|world| world.visible(InstanceHandle::from_bits(instance)))
    }

    fn set_visible(&self, instance: u64, visible: bool) -> PyResult<()> {
        self.change(|world| world.set_visible(InstanceHandle::from_bits(instance), visible))
    }

    fn instance_mesh(&self, instance: u64) -> PyResult<u64> {
        self.look(|world| Ok(world.instance_mesh(InstanceHandle::from_bits(instance))?.to_bits()))
    }

    fn set_instance_mesh(&self, instance: u64, mesh: u64) -> PyResult<()> {
        let (instance, mesh) = (InstanceHandle::from_bits(instance), MeshHandle::from_bits(mesh));
        self.change(|world| world.set_instance_mesh(instance, mesh))
    }

    fn instance_material(&self, instance: u64) -> PyResult<u64> {
        self.look(|world| Ok(world.instance_material(InstanceHandle::from_bits(instance))?.to_bits()))
    }

    fn set_instance_material(&self, instance: u64, material: u64) -> PyResult<()> {
        let (instance, material) = (InstanceHandle::from_bits(instance), MaterialHandle::from_bits(material));
        self.change(|world| world.set_instance_material(instance, material))
    }

    fn model_of(&self, instance: u64) -> PyResult<Option<u64>> {
        let model = self.look(|world| world.model_of(InstanceHandle::from_bits(instance)))?;
        Ok(model.map(ModelHandle::to_bits))
    }

    /// A light of a description as JSON.
    fn add_light(&self, json: &str) -> PyResult<u64> {
        let light = self.light_of(json)?;
        Ok(self.change(|world| world.add_light(light))?.to_bits())
    }

    fn set_light(&self, light: u64, json: &str) -> PyResult<()> {
        let with = self.light_of(json)?;
        self.change(|world| world.set_light(LightHandle::from_bits(light), with))
    }

    /// Colour and intensity.
    fn light(&self, light: u64) -> PyResult<([f32; 3], f32)> {
        self.look(|world| {
            let light = world.light(LightHandle::from_bits(light))?;
            Ok((light.color, light.intensity))
        })
    }

    fn set_light_color(&self, light: u64, color: [f32; 3]) -> PyResult<()> {
        self.change(|world| {
            let handle = LightHandle::from_bits(light);
            let with = (*world.light(handle)?).with(|l| l.color = color);
            world.set_light(handle, with)
        })
    }

    fn set_light_intensity(&self, light: u64, intensity: f32) -> PyResult<()> {
        self.change(|world| {
            let handle = LightHandle::from_bits(light);
            let with = (*world.light(handle)?).with(|l| l.intensity = intensity);
            world.set_light(handle, with)
        })
    }

    fn remove_light(&self, light: u64) -> PyResult<()> {
        self.change(|world| world.remove_light(LightHandle::from_bits(light)))
    }

    /// The environment of a description; its rotation and intensity stay if it has none.
    fn set_environment(
        &self,
        py: Python<'_>,
        renderer: &Bound<'_, Renderer>,
        request: GivenRequest<'_>,
    ) -> PyResult<Vec<String>> {
        let request = Request::new(request)?;
        let Request { description, limits, .. } = &request;
        let (source, warnings) = match &request.environment {
            Some(given) => (EnvironmentSource::Image(Arc::clone(&given.image)), Vec::new()),
            None => {
                let made = renderer.get().pool.with(py, |renderer| {
                    description.environment(limits, renderer.jobs()).map_err(|e| errors::description(&e))
                });
                let (environment, warnings) = made??;
                (environment.source, warnings)
            }
        };
        self.change(|world| {
            let own = world.scene().environment().clone();
            world.set_environment(own.with(|e| (e.source, e.of_model) = (source, false)))
        })?;
        Ok(messages(warnings))
    }

    /// Rotation in degrees and intensity of the environment.
    fn environment(&self) -> (f32, f32) {
        let kept = self.lock();
        let environment = kept.world.scene().environment();
        (environment.rotation_degrees, environment.intensity)
    }

    fn turn_environment(&self, rotation_degrees: f32, intensity: f32) -> PyResult<()> {
        self.change(|world| {
            let own = world.scene().environment().clone();
            world.set_environment(own.with(|e| {
                e.rotation_degrees = rotation_degrees;
                e.intensity = intensity;
            }))
        })
    }

    fn models(&self) -> Vec<u64> {
        self.lock().world.models().map(ModelHandle::to_bits).collect()
    }

    fn instances(&self) -> Vec<u64> {
        self.lock().world.instances().map(InstanceHandle::to_bits).collect()
    }

    fn materials(&self) -> Vec<u64> {
        self.lock().world.materials().map(MaterialHandle::to_bits).collect()
    }

    fn lights(&self) -> Vec<u64> {
        self.lock().world.lights().map(LightHandle::to_bits).collect()
    }
}
