//! The options of `overcoat thumbnail`.

use super::formats::model_files;
use super::groups::{LimitArgs, MACHINE, ReportArgs, ThreadArgs};
use crate::thumbnail_limits::{MEMORY_DEFAULT, explained};
use crate::value_parsers;
use clap::Args;
use std::path::PathBuf;

/// What `--threads` is where each takes of a bounded memory.
const THREADS: &str = "Worker threads, 0 to 256; 0 stands for one per processor, at most 4";

/// `overcoat thumbnail`
#[derive(Debug, Args)]
#[command(mut_arg("threads", |threads| threads.help(THREADS)), after_long_help = explained(), after_help = "Examples:
  overcoat thumbnail part.stl part.png
  overcoat thumbnail --size 512 file:///home/me/my%20car.glb car.png")]
pub struct ThumbnailArgs {
    /// Model file (also in gzip or Zstandard) or its file:// URI, or - for standard input
    #[arg(value_name = "IN", value_parser = value_parsers::file_or_uri(),
          long_help = model_files("Model file", ", also in gzip or Zstandard; or its file:// URI, or - for standard input"))]
    pub input: PathBuf,

    /// PNG to write, whatever its name, or - for standard output
    #[arg(value_name = "OUT")]
    pub output: PathBuf,

    /// Width and height in pixels, 1 to 1024
    #[arg(short, long, value_name = "N", value_parser = value_parsers::within::<u16>(1, 1024),
          allow_negative_numbers = true, default_value_t = 256)]
    pub size: u16,

    /// Bytes of memory that the process may take (Linux), at least 64Mi; suffixes as for --limit
    #[arg(long, value_name = "BYTES", value_parser = value_parsers::memory, default_value = MEMORY_DEFAULT,
          help_heading = "Input")]
    pub memory: u64,

    /// Keep all rights; otherwise as many are given up as this system can take away, and a warning says what it cannot
    #[arg(long, conflicts_with = "sandbox", help_heading = MACHINE)]
    pub no_sandbox: bool,

    #[command(flatten)]
    pub workers: ThreadArgs,
    #[command(flatten, next_help_heading = "Input")]
    pub limits: LimitArgs,
    #[command(flatten)]
    pub report: ReportArgs,
}
