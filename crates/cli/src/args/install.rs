//! The options of what packages bring along beside the program.

use clap::Args;
use clap_complete::Shell;
use std::path::PathBuf;

/// `overcoat completions`
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  overcoat completions bash > ~/.local/share/bash-completion/completions/overcoat
  overcoat completions fish > ~/.config/fish/completions/overcoat.fish
  overcoat completions zsh > ~/.zfunc/_overcoat")]
pub struct CompletionsArgs {
    /// The shell that reads it
    #[arg(value_name = "SHELL")]
    pub shell: Shell,
}

/// `overcoat man`
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  overcoat man | man -l -
  overcoat man --dir ~/.local/share/man/man1")]
pub struct ManArgs {
    /// Write overcoat.1 and a page for each command, as overcoat-render.1, into this folder, which has to be there
    #[arg(long, value_name = "DIR")]
    pub dir: Option<PathBuf>,
}
