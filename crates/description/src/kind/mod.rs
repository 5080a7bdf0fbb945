//! Kinds of values that options take. A kind says once how its values are spelt as arguments of the command line, read from and
//! written to scene files, taken from queries, and described in the schema; [`keys`](super::keys) gives each option one.

mod colors;
mod matrices;
mod names;
mod numbers;
mod sources;
mod vectors;

#[cfg(test)]
pub(crate) use colors::HEX_COLOR;
pub(crate) use colors::{BackgroundColor, FloorColor, LinearColor};
pub use colors::{background, ground_name};
pub(crate) use matrices::{MatrixK, Pixels, PoseMatrix};
pub use names::one_of;
pub(crate) use names::{Axes, Names, Views};
pub(crate) use numbers::Number;
pub(crate) use numbers::{Exposure, OneOf, Seconds, Size, Switch, Whole};
pub use numbers::{seconds, size};
pub(crate) use sources::{EnvironmentSource, Material, ModelPart, Path, Text};
pub use vectors::position;
pub(crate) use vectors::{Direction, Extent, Position, Vector};

use super::value::Value;
use serde_json::Value as Json;
use std::ffi::OsStr;

/// A kind of value.
pub(crate) trait Kind {
    /// The type that its values have in a [`Description`](super::Description).
    type Value;

    /// Reads an argument of the command line, or says what was expected.
    fn parse(&self, text: &str) -> Result<Self::Value, String>;

    /// Reads an argument that need not be text: paths of files.
    fn parse_os(&self, text: &OsStr) -> Result<Self::Value, String> {
        self.parse(text.to_str().ok_or("expected text in UTF-8")?)
    }

    /// Reads a value of a scene file. The message names its line and key.
    fn read(&self, value: &Value<'_>) -> Result<Self::Value, String>;

    /// Writes a value of a scene file.
    fn write(&self, value: &Self::Value) -> Result<Json, String>;

    /// JSON schema of its values in scene files.
    fn schema(&self) -> Json;

    /// The text of a query as a value of a scene file, or what was expected.
    fn query(&self, text: &str) -> Result<Json, String> {
        Ok(text.into())
    }

    /// All values, or those that have names: what a shell completes.
    fn names(&self) -> Vec<&'static str> {
        Vec::new()
    }

    /// Bounds in words where both are there: `0 to 256`.
    fn range(&self) -> Option<String> {
        None
    }
}
