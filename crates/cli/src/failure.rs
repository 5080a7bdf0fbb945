//! Failures of commands.

use overcoat_lab::lab::LabError;
pub(crate) use overcoat_worker::failure::{Failure, file_name, one_line};

/// Exit code 2: numbers of the command line that cannot be measured; as [`Failure::render`] where a picture fails.
#[must_use]
pub(crate) fn lab(error: &LabError) -> Failure {
    match error {
        LabError::Render(error) => Failure::render(error),
        other => Failure::usage(other),
    }
}
