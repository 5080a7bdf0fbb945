//! The table of options, for programs that take them: each is found by its name, says what it is and sets itself.

use super::Description;
use super::argument::Argument;
use super::camera::CameraDescription;
use super::keys::{CAMERA, Key, SCENE};
use serde_json::Value as Json;
use std::borrow::Cow;
use std::ffi::OsStr;

/// An option of a [`Description`].
#[derive(Clone, Copy)]
pub struct DescriptionOption(Table);

#[derive(Clone, Copy)]
enum Table {
    Scene(&'static Key<Description>),
    Camera(&'static Key<CameraDescription>),
}

/// The same field of either table.
macro_rules! of {
    ($option:expr, $key:ident => $value:expr) => {
        match $option.0 {
            Table::Scene($key) => $value,
            Table::Camera($key) => $value,
        }
    };
}

impl DescriptionOption {
    /// All options, those of the camera last.
    pub fn all() -> impl Iterator<Item = Self> + Clone {
        let scene = SCENE.iter().map(|key| Self(Table::Scene(key)));
        scene.chain(CAMERA.iter().map(|key| Self(Table::Camera(key))))
    }

    /// Its key in scene files.
    #[must_use]
    pub fn key(self) -> &'static str {
        of!(self, key => key.name)
    }

    /// True if its key stands in the table `camera`.
    #[must_use]
    pub fn is_of_camera(self) -> bool {
        matches!(self.0, Table::Camera(_))
    }

    /// Its name in requests to a service, if they may set it: its key; `camera_up` and `pose_convention` for those of the
    /// camera.
    #[must_use]
    pub fn request_name(self) -> Option<&'static str> {
        let name = match (self.is_of_camera(), self.key()) {
            (true, "up") => "camera_up",
            (true, "convention") => "pose_convention",
            (_, key) => key,
        };
        of!(self, key => key.in_requests).then_some(name)
    }

    /// Its argument of the command line, if there is one.
    #[must_use]
    pub fn argument(self) -> Option<Argument> {
        of!(self, key => key.argument)
    }

    /// Its meaning, range and default in one line.
    #[must_use]
    pub fn help(self) -> Cow<'static, str> {
        of!(self, key => match key.argument.and_then(|argument| argument.help) {
            Some(help) => key.sentence_of(help),
            None => key.sentence(),
        })
    }

    /// Its values, or those that have names.
    #[must_use]
    pub fn names(self) -> Vec<&'static str> {
        of!(self, key => (key.names)())
    }

    /// Sets it to an argument of the command line.
    ///
    /// # Errors
    /// A message that names the expected form.
    pub fn set(self, description: &mut Description, argument: &OsStr) -> Result<(), String> {
        match self.0 {
            Table::Scene(key) => (key.set_argument)(description, argument),
            Table::Camera(key) => (key.set_argument)(&mut description.camera, argument),
        }
    }

    /// The text of a query as a value of a scene file. Its range is checked where the scene file is read.
    ///
    /// # Errors
    /// The expected form as a noun: `a number`.
    pub fn query(self, text: &str) -> Result<Json, String> {
        of!(self, key => (key.query)(text))
    }
}

impl std::fmt::Debug for DescriptionOption {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let table = if self.is_of_camera() { "camera." } else { "" };
        write!(f, "{table}{}", self.key())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each argument has a name of its own, and the arguments that it names exist.
    #[test]
    fn arguments_fit_together() {
        let arguments: Vec<Argument> =
            DescriptionOption::all().filter_map(DescriptionOption::argument).collect();
        for (k, argument) in arguments.iter().enumerate() {
            let named = |long: &str| arguments.iter().position(|other| other.long == long);
            assert_eq!(named(argument.long), Some(k), "{}", argument.long);
            for other in argument.conflicts.iter().chain(&argument.requires) {
                assert!(named(other).is_some(), "{}: {other}", argument.long);
            }
        }
    }

    /// Every value that a shell completes is read.
    #[test]
    fn values_with_names_are_read() {
        for option in DescriptionOption::all().filter(|option| option.argument().is_some()) {
            for name in option.names() {
                let set = option.set(&mut Description::default(), OsStr::new(name));
                assert_eq!(set, Ok(()), "{option:?} {name}");
            }
        }
    }

    #[test]
    fn a_misspelt_value_is_recognised() {
        for (long, text, meant) in [
            ("view", "fornt", "front"),
            ("tone-map", "netral", "neutral"),
            ("background", "whitee", "white"),
            ("ground", "shadw", "shadow"),
            ("area-lights", "facet", "facets"),
            ("quality", "gud", "good"),
            ("shading", "filamant", "filament"),
        ] {
            let is_it = |option: &DescriptionOption| option.argument().is_some_and(|a| a.long == long);
            let option = DescriptionOption::all().find(is_it).unwrap();
            let message = option.set(&mut Description::default(), OsStr::new(text)).unwrap_err();
            assert!(message.ends_with(&format!("did you mean '{meant}'?")), "{message}");
        }
    }

    /// Requests name each option once, and none that names files.
    #[test]
    fn requests_name_no_files() {
        let names: Vec<&str> = DescriptionOption::all().filter_map(DescriptionOption::request_name).collect();
        for (k, name) in names.iter().enumerate() {
            assert!(!["model", "env", "material", "materials"].contains(name), "{name}");
            assert_eq!(names.iter().position(|other| other == name), Some(k), "{name}");
        }
    }
}
