//! Errors of the library as exceptions of `overcoat._errors`: by kind, with the library's own sentence.

use overcoat::description::DescriptionError;
use overcoat::golden::GoldenError;
use overcoat::limits::LimitExceeded;
use overcoat::load::{AssignError, LoadError, MaterialError};
use overcoat::output::OutputError;
use overcoat::render::RenderError;
use overcoat::scene::SceneError;
use overcoat::world::WorldError;
use pyo3::exceptions::PyOSError;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::PyModule;
use std::fmt::Display;
use std::io;
use std::path::Path;

/// Which exception of `overcoat._errors`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    Load,
    Option,
    Mesh,
    Render,
    Output,
    Golden,
    Mismatch,
    Handle,
    Cancelled,
}

impl Kind {
    fn class(self) -> &'static str {
        match self {
            Self::Load => "LoadError",
            Self::Option => "OptionError",
            Self::Mesh => "MeshError",
            Self::Render => "RenderError",
            Self::Output => "OutputError",
            Self::Golden => "GoldenError",
            Self::Mismatch => "Mismatch",
            Self::Handle => "HandleError",
            Self::Cancelled => "Cancelled",
        }
    }

    /// The exception with a message.
    pub(crate) fn error(self, message: impl Display) -> PyErr {
        raise(self.class(), (message.to_string(),))
    }
}

/// An exception of the Python half.
fn raise<A>(class: &str, arguments: A) -> PyErr
where
    A: for<'py> pyo3::call::PyCallArgs<'py>,
{
    static MODULE: PyOnceLock<Py<PyModule>> = PyOnceLock::new();
    Python::attach(|py| {
        let made = MODULE
            .get_or_try_init(py, || PyModule::import(py, "overcoat._errors").map(Bound::unbind))
            .and_then(|module| module.bind(py).getattr(class)?.call1(arguments));
        match made {
            Ok(exception) => PyErr::from_value(exception),
            Err(error) => error,
        }
    })
}

/// A limit, with its name and how much it allows.
pub(crate) fn limit(error: &LimitExceeded, message: impl Display) -> PyErr {
    raise("LimitError", (message.to_string(), error.field, error.limit, error.asked))
}

/// An error of the system, as the `OSError` that Python has for it: `FileNotFoundError` and the like.
pub(crate) fn system(error: &io::Error, path: Option<&Path>, message: &str) -> PyErr {
    let Some(code) = error.raw_os_error() else { return PyOSError::new_err(message.to_owned()) };
    // "No such file or directory (os error 2)"
    let text = error.to_string();
    let text = text.split(" (os error").next().unwrap_or(&text).to_owned();
    match path {
        Some(path) => PyOSError::new_err((code, text, path.as_os_str().to_owned())),
        None => PyOSError::new_err((code, text)),
    }
}

/// Exception for an error in a model or an environment.
pub(crate) fn load(error: &LoadError, path: Option<&Path>) -> PyErr {
    let message = about(error, path);
    match error {
        LoadError::Io(source) => system(source, path, &message),
        LoadError::Limit(exceeded) => limit(exceeded, message),
        LoadError::NoSuch(_) => Kind::Option.error(message),
        _ => Kind::Load.error(message),
    }
}

/// Exception for an error in a description.
pub(crate) fn description(error: &DescriptionError) -> PyErr {
    description_at(error, None, &error.to_string())
}

fn description_at(error: &DescriptionError, file: Option<&Path>, message: &str) -> PyErr {
    match error {
        DescriptionError::At { file, error } => description_at(error, Some(file), message),
        DescriptionError::Limit(exceeded) => limit(exceeded, message),
        DescriptionError::Load(LoadError::Io(source)) => system(source, file, message),
        DescriptionError::Load(LoadError::Limit(exceeded)) => limit(exceeded, message),
        DescriptionError::Load(_) => Kind::Load.error(message),
        DescriptionError::Material(error) if error.is_limit() => material_limit(error, message),
        DescriptionError::Material(_) => Kind::Load.error(message),
        DescriptionError::Assign(AssignError::Limit(exceeded)) => limit(exceeded, message),
        _ => Kind::Option.error(message),
    }
}

/// Exception for an error in a material that is given as a dict.
pub(crate) fn material(error: &MaterialError, message: &str) -> PyErr {
    if error.is_limit() { material_limit(error, message) } else { Kind::Option.error(message) }
}

fn material_limit(error: &MaterialError, message: &str) -> PyErr {
    raise("LimitError", (message.to_owned(), error.limit().unwrap_or_default(), None::<u64>, None::<u64>))
}

/// Exception for an error in laying a material over a model.
pub(crate) fn assign(error: &AssignError) -> PyErr {
    match error {
        AssignError::Limit(exceeded) => limit(exceeded, error),
        _ => Kind::Option.error(error),
    }
}

/// Exception for an error in arrays that become part of a scene.
pub(crate) fn scene(what: &str, error: &SceneError) -> PyErr {
    Kind::Mesh.error(format_args!("{what}: {error}"))
}

/// Exception for an error in the contents of a scene that changes.
pub(crate) fn world(error: &WorldError) -> PyErr {
    match error {
        WorldError::Gone { .. } | WorldError::Foreign { .. } | WorldError::InUse { .. } => {
            Kind::Handle.error(error)
        }
        WorldError::Load(source) => load(source, None),
        _ => Kind::Mesh.error(error),
    }
}

/// Exception for an error in rendering a picture.
pub(crate) fn render(error: &RenderError) -> PyErr {
    match error {
        RenderError::Limit(exceeded) => limit(exceeded, error),
        RenderError::Option { .. } | RenderError::Camera(_) => Kind::Option.error(error),
        RenderError::Cancelled => Kind::Cancelled.error("the picture was cancelled"),
        _ => Kind::Render.error(error),
    }
}

/// Exception for an error in writing a file.
pub(crate) fn output(error: &OutputError) -> PyErr {
    match error {
        OutputError::Write { path, source } => system(source, Some(path), &error.to_string()),
        OutputError::UnknownExtension { .. } => Kind::Option.error(error),
        _ => Kind::Output.error(error),
    }
}

/// Exception for an error in comparing with a golden.
pub(crate) fn golden(error: &GoldenError) -> PyErr {
    match error {
        GoldenError::Differs { .. } | GoldenError::Recorded { .. } | GoldenError::Size { .. } => {
            Kind::Mismatch.error(error)
        }
        GoldenError::Io { path, source } => system(source, Some(path), &error.to_string()),
        GoldenError::Limit(exceeded) => limit(exceeded, error),
        GoldenError::Write(source) => output(source),
        _ => Kind::Golden.error(error),
    }
}

/// A message with the file that it is about in front.
fn about(error: &LoadError, path: Option<&Path>) -> String {
    match path.and_then(Path::file_name) {
        Some(name) => format!("{}: {error}", name.to_string_lossy()),
        None => error.to_string(),
    }
}
