//! Options of a picture: a scene description as JSON, limits, and what a description cannot hold.

use crate::environment::Environment;
use crate::errors::{self, Kind};
use crate::material::{GivenMaterial, InlineMaterial};
use crate::orbit::Orbit;
use overcoat::color::srgb::SRGB8_TO_LINEAR;
use overcoat::description::{Description, DescriptionError, Machine};
use overcoat::frame::Aov;
use overcoat::load::{Format, LoadOptions};
use overcoat::output::write_atomically;
use overcoat::scene::Camera;
use overcoat::{Limits, description};
use overcoat_worker::limit_values::set_limit;
use pyo3::prelude::*;
use std::collections::BTreeMap;
use std::path::PathBuf;

/// The JSON schema of scene files: the only list of options.
#[pyfunction]
pub(crate) fn scene_schema() -> String {
    description::scene_schema()
}

/// Names of planes of the G-buffer, and how many channels each has.
#[pyfunction]
pub(crate) fn aov_names() -> Vec<(&'static str, usize)> {
    Aov::ALL.iter().map(|aov| (aov.name(), aov.channels())).collect()
}

/// Extensions of the files of models that are read, without the dot.
#[pyfunction]
pub(crate) fn model_extensions() -> Vec<&'static str> {
    Format::ALL.iter().flat_map(|format| format.file_format().extensions).copied().collect()
}

/// A scene file as JSON, with the paths in it as seen from the current folder.
#[pyfunction]
pub(crate) fn read_description(path: PathBuf) -> PyResult<String> {
    let description = Description::open(&path).map_err(|e| errors::description(&e))?;
    serde_json::to_string(&description).map_err(|e| Kind::Option.error(e))
}

/// Linear values of the codes of sRGB, 0 to 255.
#[pyfunction]
pub(crate) fn srgb_table() -> Vec<f32> {
    SRGB8_TO_LINEAR.to_vec()
}

/// Writes a file whole or not at all.
#[pyfunction]
pub(crate) fn write_file(path: PathBuf, bytes: &[u8]) -> PyResult<()> {
    write_atomically(&path, bytes).map_err(|e| errors::output(&e))
}

/// Request for one picture.
pub(crate) struct Request {
    pub(crate) description: Description,
    pub(crate) limits: Limits,
    pub(crate) environment: Option<Environment>,
    /// Materials that are given as dicts, by the name of the material that they take the place of; `None` for all.
    pub(crate) materials: Vec<InlineMaterial>,
    pub(crate) aovs: Vec<Aov>,
    /// In the place of the description's.
    pub(crate) orbit: Option<Camera>,
}

/// Request as Python gives it: `description` and each of `materials` are JSON.
#[derive(FromPyObject)]
pub(crate) struct GivenRequest<'py> {
    #[pyo3(item)]
    description: String,
    #[pyo3(item)]
    limits: BTreeMap<String, u64>,
    #[pyo3(item)]
    environment: Option<PyRef<'py, Environment>>,
    #[pyo3(item)]
    materials: Vec<GivenMaterial>,
    #[pyo3(item)]
    aov: Vec<String>,
    #[pyo3(item)]
    orbit: Option<PyRef<'py, Orbit>>,
}

/// Checks options without a model: their names, types and ranges, and that the picture is not too large.
#[pyfunction]
pub(crate) fn check_request(request: GivenRequest<'_>) -> PyResult<()> {
    let Request { description, limits, .. } = Request::new(request)?;
    description.options(Machine::default(), &limits).map(|_| ()).map_err(|e| errors::description(&e))
}

impl Request {
    /// Checks what Python has given.
    pub(crate) fn new(given: GivenRequest<'_>) -> PyResult<Self> {
        let description = read(&given.description)?;
        let aovs = given.aov.iter().map(|name| aov(name)).collect::<PyResult<Vec<Aov>>>()?;
        Ok(Self {
            description,
            limits: limits(&given.limits)?,
            environment: given.environment.map(|environment| environment.clone()),
            materials: given.materials.into_iter().map(InlineMaterial::new).collect(),
            aovs,
            orbit: given.orbit.map(|orbit| orbit.camera()),
        })
    }
}

/// A scene file that Python has written, in one line that nobody has seen.
pub(crate) fn read(json: &str) -> PyResult<Description> {
    Description::from_json(json).map_err(|error| match error {
        DescriptionError::Invalid(message) => {
            Kind::Option.error(message.strip_prefix("line 1: ").unwrap_or(&message))
        }
        error => errors::description(&error),
    })
}

/// Options of loading, from a description as JSON.
pub(crate) fn loading(json: &str) -> PyResult<LoadOptions> {
    read(json)?.load_options().map_err(|e| errors::description(&e))
}

/// The default limits with some of them changed.
pub(crate) fn limits(given: &BTreeMap<String, u64>) -> PyResult<Limits> {
    let mut limits = Limits::default();
    for (name, value) in given {
        set_limit(&mut limits, name, *value).map_err(|message| Kind::Option.error(message))?;
    }
    Ok(limits)
}

/// A plane by its name.
pub(crate) fn aov(name: &str) -> PyResult<Aov> {
    Aov::from_name(name).ok_or_else(|| {
        let known: Vec<&str> = Aov::ALL.iter().map(|aov| aov.name()).collect();
        Kind::Option
            .error(format_args!("aov '{name}': there is no such plane; known are {}", known.join(", ")))
    })
}
