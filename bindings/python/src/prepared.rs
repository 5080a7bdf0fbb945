//! Scenes that are lit and dressed as asked, kept for the next picture of the same model.

use crate::environment::Environment as GivenEnvironment;
use crate::errors;
use crate::material::InlineMaterial;
use crate::model::Model;
use crate::options::Request;
use overcoat::description::{Description, EnvironmentChoice, Materials, Setting};
use overcoat::jobs::Jobs;
use overcoat::load::Warning;
use overcoat::scene::{Environment, EnvironmentSource};
use overcoat::{Limits, Scene};
use pyo3::prelude::*;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::SystemTime;

/// Scenes and environments that are kept at most.
const KEPT: usize = 8;

/// A scene that is ready for every camera, and what is doubtful about how it was made so.
#[derive(Debug)]
pub(crate) struct Prepared {
    pub(crate) scene: Arc<Scene>,
    pub(crate) warnings: Vec<String>,
}

/// Key of a prepared scene: requests with equal keys share it.
#[derive(Clone, Debug, PartialEq)]
struct Key {
    model: u64,
    /// Only what changes a scene.
    description: Description,
    materials: Vec<InlineMaterial>,
    /// By identity, as the renderer keeps their filtered form.
    environment: Option<Identity>,
    limits: Limits,
    files: Vec<Stamp>,
}

/// An environment that is the same object.
#[derive(Clone, Debug)]
struct Identity(GivenEnvironment);

impl PartialEq for Identity {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0.image, &other.0.image)
    }
}

/// A file as it was when it was read: one that changes is read again.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Stamp {
    path: PathBuf,
    state: Option<(u64, SystemTime)>,
}

impl Stamp {
    fn new(path: &Path) -> Self {
        let state = std::fs::metadata(path).ok().and_then(|m| Some((m.len(), m.modified().ok()?)));
        Self { path: path.to_owned(), state }
    }
}

/// An environment that was read from a file.
#[derive(Clone, Debug)]
struct Read {
    stamp: Stamp,
    limits: Limits,
    environment: Environment,
    warnings: Vec<Warning>,
}

/// Scenes and environments that a renderer keeps. Its lock is held only with the interpreter, see [`crate::pool`].
#[derive(Debug, Default)]
pub(crate) struct Cache(Mutex<Kept>);

#[derive(Debug, Default)]
struct Kept {
    scenes: Vec<(Key, Arc<Prepared>)>,
    environments: Vec<Read>,
}

impl Cache {
    /// The scene of a model, if it was prepared like this before.
    pub(crate) fn find(&self, model: &Model, request: &Request) -> Plan {
        let key = Key::new(model, request);
        if model.is_lit && key.changes_nothing() {
            let scene = Arc::clone(&model.scene);
            return Plan::Done(Arc::new(Prepared { scene, warnings: Vec::new() }));
        }
        let mut kept = self.lock();
        let found = kept.scenes.iter().position(|(other, _)| *other == key);
        if let Some(place) = found {
            let entry = kept.scenes.remove(place);
            let scene = Arc::clone(&entry.1);
            kept.scenes.push(entry);
            return Plan::Done(scene);
        }
        let read = match &request.description.env {
            Some(EnvironmentChoice::File(path)) => {
                let stamp = Stamp::new(path);
                kept.environments.iter().find(|r| r.stamp == stamp && r.limits == request.limits).cloned()
            }
            _ => None,
        };
        Plan::Prepare(Box::new(Preparation { key, read }))
    }

    /// Keeps what was prepared, and forgets what was not used for longest.
    pub(crate) fn keep(&self, made: Made) {
        let mut kept = self.lock();
        if let Some(read) = made.read {
            kept.environments.retain(|other| other.stamp.path != read.stamp.path);
            kept.environments.push(read);
            let surplus = kept.environments.len().saturating_sub(KEPT);
            kept.environments.drain(..surplus);
        }
        if let Some(key) = made.key {
            kept.scenes.push((key, made.scene));
            let surplus = kept.scenes.len().saturating_sub(KEPT);
            kept.scenes.drain(..surplus);
        }
    }

    fn lock(&self) -> MutexGuard<'_, Kept> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Work that is left to do for a scene.
pub(crate) enum Plan {
    Done(Arc<Prepared>),
    Prepare(Box<Preparation>),
}

/// A scene to be prepared.
pub(crate) struct Preparation {
    key: Key,
    read: Option<Read>,
}

/// A scene that was prepared, for [`Cache::keep`].
pub(crate) struct Made {
    key: Option<Key>,
    read: Option<Read>,
    pub(crate) scene: Arc<Prepared>,
}

impl Made {
    /// Not to be found again: the model is gone after this picture.
    pub(crate) fn once(self) -> Self {
        Self { key: None, ..self }
    }
}

impl Key {
    /// The scene stays as it is.
    fn changes_nothing(&self) -> bool {
        self.description == Description::default() && self.materials.is_empty() && self.environment.is_none()
    }

    fn new(model: &Model, request: &Request) -> Self {
        let Description {
            env,
            env_rotation_degrees,
            env_intensity,
            lights,
            lights_to_add,
            material,
            materials,
            ..
        } = request.description.clone();
        let description = Description {
            env,
            env_rotation_degrees,
            env_intensity,
            lights,
            lights_to_add,
            material,
            materials,
            ..Description::default()
        };
        let environment = match &description.env {
            Some(EnvironmentChoice::File(path)) => Some(path.clone()),
            _ => None,
        };
        let materials = description.material_choices();
        let files = materials.filter_map(|choice| Some(choice.source.file()?.to_owned())).chain(environment);
        Self {
            model: model.id,
            files: files.map(|path| Stamp::new(&path)).collect(),
            description,
            materials: request.materials.clone(),
            environment: request.environment.clone().map(Identity),
            limits: request.limits.clone(),
        }
    }
}

impl Preparation {
    /// Lights a copy of the model's scene and lays materials over it.
    pub(crate) fn carry_out(self, model: &Model, request: &Request, jobs: &Jobs) -> PyResult<Made> {
        let Self { key, read } = self;
        let Request { description, limits, .. } = request;
        let failed = |error| errors::description(&error);
        let materials = Materials::load(description, limits, jobs).map_err(failed)?;
        let (environment, of_environment) = match (&request.environment, &read) {
            (Some(given), _) => {
                let source = EnvironmentSource::Image(Arc::clone(&given.image));
                (described(description, source), Vec::new())
            }
            (None, Some(read)) => {
                (described(description, read.environment.source.clone()), read.warnings.clone())
            }
            (None, None) if model.is_lit && description.env.is_none() => {
                let own = model.scene.environment();
                let rotation_degrees = description.env_rotation_degrees.unwrap_or(own.rotation_degrees);
                let intensity = description.env_intensity.unwrap_or(own.intensity);
                (
                    own.clone().with(|e| {
                        e.rotation_degrees = rotation_degrees;
                        e.intensity = intensity;
                    }),
                    Vec::new(),
                )
            }
            (None, None) => description.environment(limits, jobs).map_err(failed)?,
        };
        let read = match (&description.env, &request.environment) {
            (Some(EnvironmentChoice::File(path)), None) => Some(Read {
                stamp: Stamp::new(path),
                limits: limits.clone(),
                environment: environment.clone(),
                warnings: of_environment.clone(),
            }),
            _ => None,
        };
        let setting = Setting::new(description, materials, (environment, of_environment));
        let mut scene = Scene::clone(&model.scene);
        setting.apply(description, &mut scene, limits).map_err(failed)?;
        for material in &request.materials {
            material.assign(&mut scene, limits, jobs)?;
        }
        let warnings = setting.warnings.into_iter().map(|warning| warning.message).collect();
        Ok(Made { key: Some(key), read, scene: Arc::new(Prepared { scene: Arc::new(scene), warnings }) })
    }
}

/// An environment as a description turns and dims it.
fn described(description: &Description, source: EnvironmentSource) -> Environment {
    Environment::default().with(|e| {
        e.source = source;
        e.rotation_degrees = description.env_rotation_degrees.unwrap_or(0.0);
        e.intensity = description.env_intensity.unwrap_or(1.0);
    })
}
