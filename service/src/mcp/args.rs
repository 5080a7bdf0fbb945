//! The options of `overcoat mcp`.

use crate::common::{ConverterArgs, WorkerLimitArgs};
use clap::Args;
use overcoat_cli::args::{DrawArgs, EncodingArgs};
use overcoat_cli::value_parsers;
use std::path::PathBuf;

/// `overcoat mcp`
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  overcoat mcp
  overcoat mcp --root models/ --quality draft --size 512

Started by a program that speaks the Model Context Protocol, with this line as its command. Tools: render, views, diagnose,
info, compare_models, compare_pictures, materials.")]
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

    #[command(flatten)]
    pub limits: WorkerLimitArgs,
    #[command(flatten)]
    pub converters: ConverterArgs,
    #[command(flatten)]
    pub encoding: EncodingArgs,
    #[command(flatten)]
    pub draw: DrawArgs,
}
