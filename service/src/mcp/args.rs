//! The options of `overcoat mcp`.

use crate::batch::args::bytes;
use clap::Args;
use overcoat_cli::args::{DrawArgs, EncodingArgs};
use overcoat_cli::value_parsers;
use std::path::PathBuf;

/// `overcoat mcp`
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  overcoat mcp
  overcoat mcp --root models/ --quality draft --size 512

Started by a program that speaks the Model Context Protocol, with this line as its command. Tools: render, views, info,
compare_models, compare_pictures, materials.")]
pub struct McpArgs {
    /// Folder whose files may be read, and pictures of which may be saved in it with --write
    #[arg(long, value_name = "DIR", default_value = ".", help_heading = None::<&str>)]
    pub root: PathBuf,

    /// Let tools save pictures below the root; a file that is there already is kept
    #[arg(long, help_heading = None::<&str>)]
    pub write: bool,

    /// Processes that draw, each with --threads threads (1 unless given)
    #[arg(long, value_name = "N", default_value = "2", value_parser = value_parsers::within::<usize>(1, 4096),
          help_heading = "Workers")]
    pub workers: usize,

    /// Memory of a worker's data; suffixes as of --limit
    #[arg(long, value_name = "BYTES", default_value = "2Gi", value_parser = bytes, help_heading = "Workers")]
    pub memory: u64,

    /// Seconds of processor time, of all threads, after which the work on one model is stopped
    #[arg(long, value_name = "SECONDS", default_value = "60", value_parser = value_parsers::within::<f64>(0.01, 1e6),
          help_heading = "Workers")]
    pub deadline: f64,

    /// Seconds of the wall after which it is stopped, whatever it waits for [default: ten times --deadline]
    #[arg(long, value_name = "SECONDS", value_parser = value_parsers::within::<f64>(0.01, 1e7), help_heading = "Workers")]
    pub wall_deadline: Option<f64>,

    /// Leave workers the rights that they do not need (Linux takes them otherwise)
    #[arg(long, help_heading = "Workers")]
    pub no_sandbox: bool,

    #[command(flatten)]
    pub encoding: EncodingArgs,
    #[command(flatten)]
    pub draw: DrawArgs,
}
