//! `overcoat completions` and `overcoat man`: what packages bring along beside a program, made of the definition of its
//! arguments.

use super::args::{Cli, CompletionsArgs, ManArgs};
use super::failure::Failure;
use super::output_file::{Encoded, check_writable};
use super::report;
use clap::{Command, CommandFactory};
use clap_mangen::Man;
use std::path::{Path, PathBuf};

/// Prints the script of a shell.
///
/// # Errors
/// [`Failure`] if standard output cannot be written.
pub fn completions(args: &CompletionsArgs) -> Result<(), Failure> {
    completions_of("overcoat", &Cli::command(), args)
}

/// The same for the program that has this name and these arguments.
///
/// # Errors
/// As [`completions`].
pub fn completions_of(program: &'static str, all: &Command, args: &CompletionsArgs) -> Result<(), Failure> {
    let mut script = Vec::new();
    let mut command = for_users(program, all);
    clap_complete::generate(args.shell, &mut command, program, &mut script);
    report::print(&String::from_utf8(script).map_err(Failure::failed)?)
}

/// Prints the page of the program, or writes those of all commands.
///
/// # Errors
/// [`Failure`]; nothing is written then.
pub fn man(args: &ManArgs) -> Result<(), Failure> {
    man_of(Cli::command(), args)
}

/// The same for the program that has these arguments.
///
/// # Errors
/// As [`man`].
pub fn man_of(all: Command, args: &ManArgs) -> Result<(), Failure> {
    let mut command = all.disable_help_subcommand(true);
    command.build();
    let Some(folder) = &args.dir else {
        let page = String::from_utf8(page(&Man::new(command))?).map_err(Failure::failed)?;
        return report::print(&page);
    };
    let mut pages = Vec::new();
    add_pages(&command, folder, &mut pages)?;
    for (path, _) in &pages {
        check_writable(path)?;
    }
    Encoded::of_files(pages).write()
}

/// The program's arguments without the commands that are hidden, which completion would offer.
fn for_users(program: &'static str, all: &Command) -> Command {
    let shown = all.get_subcommands().filter(|below| !below.is_hide_set());
    let bare = Command::new(program).version(env!("CARGO_PKG_VERSION"));
    bare.args(all.get_arguments()).subcommands(shown)
}

/// Adds the page of a command and of those below it.
fn add_pages(command: &Command, folder: &Path, pages: &mut Vec<(PathBuf, Vec<u8>)>) -> Result<(), Failure> {
    let man = Man::new(command.clone());
    pages.push((folder.join(man.get_filename()), page(&man)?));
    let below = command.get_subcommands().filter(|below| !below.is_hide_set());
    below.into_iter().try_for_each(|below| add_pages(below, folder, pages))
}

/// A page in the language of manuals.
fn page(man: &Man) -> Result<Vec<u8>, Failure> {
    let mut page = Vec::new();
    man.render(&mut page).map_err(Failure::failed)?;
    Ok(page)
}
