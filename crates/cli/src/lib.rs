//! The `overcoat` command: arguments in, library calls out.
//!
//! A picture is described by a [`Description`](overcoat_description::Description), whether it comes from a file, from options
//! or from both; each command is a module that lays its options over it, carries it out and reports. Errors are one line on standard error and an exit code.

mod animate;
pub mod args;
pub mod attempt;
mod ball;
mod bench;
mod compare;
pub mod conformance;
mod contact;
mod converters;
mod default_command;
mod default_output;
mod diagnose;
mod diff;
mod embedded;
mod environment_cache;
pub mod error_format;
mod failure;
mod file_uri;
mod formats_command;
pub mod golden;
mod guide_command;
mod hand_over;
mod info;
pub mod input;
pub mod install;
pub mod lab;
mod label;
mod materials_command;
mod movie_frames;
mod movie_output;
mod names;
mod output_file;
mod progress;
mod render;
mod render_task;
mod report;
mod sandbox;
mod sheet;
mod short_help;
mod terminal_size;
mod thumbnail;
pub mod thumbnail_limits;
pub mod translate;
pub mod turntable;
pub mod value_parsers;

use args::{Cli, Command};
use clap::error::{ContextKind, ContextValue, ErrorKind};
use failure::{Failure, one_line};
use overcoat_core::limits::Limits;
use overcoat_core::suggest::suggestion;
use overcoat_worker::converters::launch;
use report::Reporter;
use std::ffi::OsString;
use std::process::ExitCode;

/// Runs the command line of this process.
#[must_use]
pub fn run() -> ExitCode {
    ExitCode::from(run_arguments(std::env::args_os()))
}

/// Runs a command line, of which the first argument is the program's name, in a process that is given up to it: rights may
/// be given up, and signals are listened to. Returns the exit code.
#[must_use]
pub fn run_arguments(arguments: impl IntoIterator<Item = impl Into<OsString> + Clone>) -> u8 {
    let arguments: Vec<OsString> = arguments.into_iter().map(Into::into).collect();
    // It becomes another program, before anything of this one is set up.
    if let Some((_, [command, rest @ ..])) = arguments.split_first()
        && command == launch::COMMAND
    {
        return launch::launch(rest);
    }
    overcoat_worker::signals::listen();
    error_format::speak(error_format::asked(&arguments));
    let done = match short_help::parse(default_command::completed(arguments)) {
        Ok(mut cli) => {
            let memory = Limits::check_memory(|| "start".to_owned(), 0).map_err(|e| Failure::limit(&e));
            let settled = memory.and_then(|()| settle(&mut cli));
            settled.and_then(|()| confine(&mut cli)).and_then(|()| dispatch(&cli))
        }
        Err(error) => match error.kind() {
            ErrorKind::DisplayHelp
            | ErrorKind::DisplayVersion
            | ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand => {
                let _ = error.print();
                // Bare `overcoat` shows its help and has still not been used as intended.
                return error.exit_code() as u8;
            }
            _ => Err(usage(&error)),
        },
    };
    match done {
        Ok(()) => 0,
        Err(failure) => {
            if !failure.is_silent() {
                error_format::failure(&failure);
            }
            failure.exit_code()
        }
    }
}

/// Settles what depends on files that are there, before rights are given up.
fn settle(cli: &mut Cli) -> Result<(), Failure> {
    converters::choose(cli.converters.as_deref(), cli.allow_unsandboxed_converters)?;
    if let Command::Render(args) = &mut cli.command {
        default_output::settle(args)?;
    }
    let is_confined = matches!(&cli.command, Command::Thumbnail(args) if !args.no_sandbox);
    // A thumbnail's process has a bound on its memory, too, which is not the converter's.
    if cli.sandbox || is_confined { converters::go_ahead(&cli.command) } else { Ok(()) }
}

/// Gives up rights, if that is wanted; for thumbnails, unless it is not.
fn confine(cli: &mut Cli) -> Result<(), Failure> {
    if let Command::Thumbnail(args) = &mut cli.command {
        thumbnail::prepare(args);
        if !cli.sandbox && !args.no_sandbox {
            let reporter = Reporter { quiet: args.report.quiet };
            for missing in sandbox::enter_as_far_as_possible(&mut cli.command) {
                reporter.warning(format_args!("not everything is given up: {missing}"));
            }
        }
    }
    // Another program does these, in workers that have sandboxes of their own.
    let is_handed_over = matches!(cli.command, Command::Batch(_) | Command::Serve(_) | Command::Mcp(_));
    if cli.sandbox && !is_handed_over { sandbox::enter(&mut cli.command) } else { Ok(()) }
}

/// Carries out one command.
fn dispatch(cli: &Cli) -> Result<(), Failure> {
    match &cli.command {
        Command::Render(args) => render::run(args),
        Command::Thumbnail(args) => thumbnail::run(args),
        Command::Turntable(args) => turntable::run(args),
        Command::Animate(args) => animate::run(args),
        Command::Info(args) => info::run(args),
        Command::Diagnose(args) => diagnose::run(args),
        Command::Sheet(args) => sheet::run(args),
        Command::Bench(args) => bench::run(args),
        Command::CompareModels(args) => compare::run(args),
        Command::Diff(args) => diff::run(args),
        Command::Materials(args) => materials_command::run(args),
        Command::Guide(args) => guide_command::run(args),
        Command::Formats(args) => formats_command::run(args),
        Command::Lab(args) => lab::run(args),
        Command::Translate(args) => translate::run(args),
        Command::Conformance(args) => conformance::run(args),
        Command::Golden(args) => golden::run(args),
        Command::Completions(args) => install::completions(args),
        Command::Man(args) => install::man(args),
        Command::Batch(args) => hand_over::run("batch", args, cli),
        Command::Serve(args) => hand_over::run("serve", args, cli),
        Command::Mcp(args) => hand_over::run("mcp", args, cli),
        Command::Attempt(args) => attempt::run(args),
    }
}

/// The parser's message on one line: what is wrong and where help is.
#[must_use]
pub fn usage(error: &clap::Error) -> Failure {
    let text = error.to_string();
    let text = text.strip_prefix("error: ").unwrap_or(&text);
    // Paragraphs after the first are the usage and a hint that is repeated here in short.
    let what = text.split("\n\n").next().unwrap_or(text);
    let what: Vec<&str> = what.lines().map(str::trim).collect();
    let kinds = [ContextKind::SuggestedArg, ContextKind::SuggestedSubcommand, ContextKind::SuggestedValue];
    let names = |kind| match error.get(kind) {
        Some(ContextValue::String(name)) => vec![name.clone()],
        Some(ContextValue::Strings(names)) => names.clone(),
        _ => Vec::new(),
    };
    let candidates: Vec<String> = kinds.into_iter().flat_map(names).collect();
    let nearest = suggestion(candidates.first().map(String::as_str));
    Failure::usage(format!("{}{nearest} (see --help)", one_line(&what.join(" ")))).with_candidates(candidates)
}
