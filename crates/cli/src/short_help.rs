//! `-h` on one screen: the options that people use, in a few words each, and where the rest is.

use super::args::Cli;
use clap::error::Error;
use clap::{Arg, Command, CommandFactory, FromArgMatches};
use std::ffi::OsString;

/// Options of drawing that `-h` lists; those that a command has for itself are listed beside them.
const USUAL: [&str; 21] = [
    "input",
    "inputs",
    "models",
    "model",
    "output",
    "frames",
    "seconds",
    "turn",
    "fps",
    "against",
    "columns",
    "size",
    "view",
    "env",
    "quality",
    "samples",
    "shading",
    "materials",
    "ground",
    "background",
    "force",
];

/// Lines of help that fit a screen.
const SCREEN: usize = 40;

/// Characters of the help of an option that may stay as they are.
const SHORT: usize = 70;

/// Reads a command line.
///
/// # Errors
/// [`Error`] of clap, as of [`clap::Parser::try_parse_from`].
pub(super) fn parse(arguments: Vec<OsString>) -> Result<Cli, Error> {
    let mut command =
        if arguments.iter().any(|argument| argument == "-h") { short() } else { Cli::command() };
    let mut matches = command.try_get_matches_from_mut(arguments)?;
    Cli::from_arg_matches_mut(&mut matches).map_err(|error| error.format(&mut command))
}

/// The program's arguments with the help of `-h`.
fn short() -> Command {
    let mut built = Cli::command();
    built.build();
    let is_long = |below: &mut Command| below.render_help().to_string().lines().count() > SCREEN;
    let mut all = Cli::command();
    for below in built.get_subcommands_mut() {
        if is_long(below) {
            all = all.mut_subcommand(below.get_name(), shortened);
        }
    }
    all.mut_args(|argument| argument.hide(true))
}

/// A command whose `-h` fits a screen.
fn shortened(command: Command) -> Command {
    let draws = command.get_arguments().any(|argument| argument.get_id() == "quality");
    let rest =
        format!("All options with their defaults, and examples: overcoat {} --help", command.get_name());
    let command = command.mut_args(|argument| {
        let is_usual = !draws || USUAL.contains(&argument.get_id().as_str());
        // Options that modify another one are listed by --help alone.
        let help = argument.get_help().map(ToString::to_string).unwrap_or_default();
        if is_usual && !help.starts_with("With --") { in_few_words(argument) } else { argument.hide(true) }
    });
    command.after_help(rest)
}

/// An option without heading and default, and with the beginning of its help where that is long.
fn in_few_words(argument: Arg) -> Arg {
    let help = argument.get_help().map(ToString::to_string).unwrap_or_default();
    let ends = [": ", "; ", " (", " [", ", or "].map(|end| help.find(end));
    let end = if help.len() > SHORT { ends.into_iter().flatten().min() } else { None };
    let short = help.get(..end.unwrap_or(help.len())).unwrap_or(&help).to_owned();
    let has_value = argument.get_action().takes_values();
    argument.help(short).help_heading(None::<&str>).hide_default_value(has_value)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn help(arguments: &[&str]) -> String {
        let arguments = arguments.iter().map(OsString::from).collect();
        parse(arguments).unwrap_err().to_string()
    }

    /// Help of the program and of each command fits a screen of 40 lines; `--help` has it all.
    #[test]
    fn short_help_fits_a_screen() {
        for below in Cli::command().get_subcommands().filter(|below| !below.is_disable_help_flag_set()) {
            let short = help(&["overcoat", below.get_name(), "-h"]);
            assert!(short.lines().count() <= 40, "{}: {short}", below.get_name());
        }
        let short = help(&["overcoat", "-h"]);
        assert!(short.lines().count() <= 40, "{short}");
    }

    #[test]
    fn short_help_has_the_usual_options_and_says_where_the_others_are() {
        let (short, long) = (help(&["overcoat", "render", "-h"]), help(&["overcoat", "render", "--help"]));
        for option in [
            "--output",
            "--size",
            "--view",
            "--env",
            "--quality",
            "--material",
            "--background",
            "render --help",
        ] {
            assert!(short.contains(option), "{option} {short}");
        }
        assert!(!short.contains("--merge-angle"), "{short}");
        assert!(
            long.contains("--merge-angle") && long.contains("Examples:") && long.contains("--sandbox"),
            "{long}"
        );
    }
}
