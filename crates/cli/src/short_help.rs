//! `-h` on one screen: the options that people use, and where the rest is.

use super::args::Cli;
use clap::error::Error;
use clap::{Command, CommandFactory, FromArgMatches};
use std::ffi::OsString;

/// Options that `-h` lists of commands that draw models.
const USUAL: [&str; 17] = [
    "input",
    "inputs",
    "models",
    "model",
    "output",
    "frames",
    "seconds",
    "turn",
    "fps",
    "animation",
    "size",
    "view",
    "env",
    "shading",
    "quality",
    "background",
    "materials",
];

/// Options of a command that are too many for one screen.
const MANY: usize = 24;

/// Reads a command line.
///
/// # Errors
/// [`Error`] of clap, as of [`clap::Parser::try_parse_from`].
pub(super) fn parse(arguments: Vec<OsString>) -> Result<Cli, Error> {
    let mut command = command();
    let mut matches = command.try_get_matches_from_mut(arguments)?;
    Cli::from_arg_matches_mut(&mut matches).map_err(|error| error.format(&mut command))
}

/// The program's arguments, with the help of `-h` cut to a screen.
fn command() -> Command {
    let mut all = Cli::command();
    let names: Vec<String> = all.get_subcommands().map(|below| below.get_name().to_owned()).collect();
    for name in names {
        all = all.mut_subcommand(name, shortened);
    }
    all
}

/// A command whose `-h` lists the usual options alone, if it has many.
fn shortened(command: Command) -> Command {
    let arguments = command.get_arguments();
    if arguments.count() < MANY {
        return command;
    }
    let is_usual = |id: &str| USUAL.contains(&id);
    let command = command.mut_args(|argument| {
        let id = argument.get_id().as_str();
        if is_usual(id) { argument } else { argument.hide_short_help(true) }
    });
    let rest = format!("All options, and examples: overcoat {} --help", command.get_name());
    match command.get_after_help().cloned() {
        Some(examples) => command.after_long_help(examples).after_help(rest),
        None => command.after_help(rest),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Help of the program and of each command fits a screen of 40 lines; `--help` has it all.
    #[test]
    fn short_help_fits_a_screen() {
        let mut all = command();
        all.build();
        let help = all.render_help().to_string();
        assert!(help.lines().count() <= 40, "{help}");
        for below in all.get_subcommands_mut() {
            let help = below.render_help().to_string();
            assert!(help.lines().count() <= 40, "{}: {help}", below.get_name());
        }
        let render = all.find_subcommand_mut("render").unwrap();
        let (short, long) = (render.render_help().to_string(), render.render_long_help().to_string());
        for option in ["--output", "--size", "--view", "--env", "--quality", "--material", "--background"] {
            assert!(short.contains(option), "{option} {short}");
        }
        assert!(long.contains("--merge-angle") && long.contains("Examples:"), "{long}");
        assert!(short.contains("overcoat render --help"), "{short}");
    }
}
