//! `--error-format`: lines on standard error, for people or for programs.

use super::failure::{Failure, one_line};
use overcoat_load::Warning;
use overcoat_worker::codes::{Code, Severity};
use overcoat_worker::message::WarningJson;
use std::ffi::OsString;
use std::fmt::Display;
use std::io::Write;
use std::sync::atomic::{AtomicBool, Ordering};

/// Form of errors, warnings and notes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum ErrorFormat {
    /// A line of text.
    #[default]
    Human,
    /// A JSON object on a line.
    Json,
}

/// True if lines are JSON. Of the process, as standard error is: whatever speaks there keeps to one form.
static IS_JSON: AtomicBool = AtomicBool::new(false);

/// The form that a command line asks for, also one that cannot be parsed.
pub(super) fn asked(arguments: &[OsString]) -> ErrorFormat {
    let before = arguments.iter().take_while(|argument| *argument != "--");
    let after = before.clone().skip(1);
    let apart = before.clone().zip(after).any(|(name, value)| name == "--error-format" && value == "json");
    let is_json = apart || before.clone().any(|argument| argument == "--error-format=json");
    if is_json { ErrorFormat::Json } else { ErrorFormat::Human }
}

/// Settles the form of all lines from here on.
pub(super) fn speak(format: ErrorFormat) {
    IS_JSON.store(format == ErrorFormat::Json, Ordering::Relaxed);
}

/// Tells of a failure.
pub(super) fn failure(failure: &Failure) {
    match is_json() {
        true => json(&failure.json()),
        false => line(format_args!("overcoat: {failure}")),
    }
}

/// Tells of something that a picture lacks.
pub(super) fn warning(warning: &Warning) {
    match is_json() {
        true => json(&WarningJson::from(warning)),
        false => line(format_args!("warning: {}", one_line(&warning.message))),
    }
}

/// Tells something else, of this code.
pub(super) fn note(code: Code, message: &impl Display) {
    let message = one_line(&message.to_string());
    match is_json() {
        true => {
            json(&WarningJson { level: Severity::Note, code: code.name, message: &message, remedy: None })
        }
        false => line(message),
    }
}

fn is_json() -> bool {
    IS_JSON.load(Ordering::Relaxed)
}

fn json(value: &impl serde::Serialize) {
    // A text of names and numbers is always JSON.
    line(serde_json::to_string(value).unwrap_or_default());
}

fn line(text: impl Display) {
    // There is nobody to tell if standard error is closed.
    let _ = writeln!(std::io::stderr(), "{text}");
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_form_is_known_before_the_command_line_is_parsed() {
        for (line, format) in [
            ("overcoat --error-format json rendr", ErrorFormat::Json),
            ("overcoat rendr --error-format=json", ErrorFormat::Json),
            ("overcoat rendr --error-format human", ErrorFormat::Human),
            ("overcoat rendr -- --error-format=json", ErrorFormat::Human),
            ("overcoat --error-format", ErrorFormat::Human),
            ("overcoat", ErrorFormat::Human),
        ] {
            let arguments: Vec<OsString> = line.split(' ').map(OsString::from).collect();
            assert_eq!(asked(&arguments), format, "{line}");
        }
    }
}
