//! Warnings as programs read them, beside [`FailureJson`](crate::failure::FailureJson).

use crate::codes::{self, Severity};
use overcoat_load::Warning;
use serde::Serialize;

/// A warning or a note as programs read it. Fields are only ever added.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct WarningJson<'a> {
    /// Weight.
    pub level: Severity,
    /// Name of a [`codes::Code`].
    pub code: &'a str,
    /// One sentence.
    pub message: &'a str,
    /// Options that help, as the command line takes them.
    pub remedy: Option<&'a str>,
}

impl<'a> From<&'a Warning> for WarningJson<'a> {
    fn from(of: &'a Warning) -> Self {
        // There is a picture; a failure would have been told.
        let level = codes::of_name(of.code).severity.min(Severity::Warning);
        Self { level, code: of.code, message: &of.message, remedy: of.remedy.as_deref() }
    }
}
