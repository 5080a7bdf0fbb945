//! The options of `overcoat batch`.

use crate::common::{ConverterArgs, WorkerLimitArgs};
use clap::Args;
use overcoat::frame::Aov;
use overcoat_cli::args::{DrawArgs, EncodingArgs};
use overcoat_cli::value_parsers;
use std::net::SocketAddr;
use std::path::PathBuf;

/// `overcoat batch`
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  overcoat batch models/ -o pictures/
  overcoat batch models/ -o pictures/ --sizes 128,512 --views front,three-quarter --resume
  overcoat batch list.jsonl -o pictures/ --output-format webp --verify 0.001
  overcoat batch s3://bucket/models -o s3://bucket/pictures --report report.jsonl --shard auto/64

A manifest has a model a row: {\"model\": \"a.glb\", \"out\": \"a.png\", \"size\": 256, \"view\": \"front\"}, or a CSV file with such
columns. Every key of a scene file is one of a row; \"pictures\": [{...}, {...}] makes several of one model.

Exit codes: 0 done, 1 some pictures were not made (the report says why; 0 with --allow-failures), 2 wrong usage, 4 pictures differ
(--verify)")]
pub struct BatchArgs {
    /// A folder of models, one model, a manifest (.jsonl, .csv; - for JSON lines from standard input), or the URL of a prefix (s3://, gs://,
    /// az://, http://, https://, file://)
    #[arg(value_name = "IN", help_heading = None::<&str>)]
    pub input: String,

    /// Folder or URL of a prefix that the pictures go to
    #[arg(short, long, value_name = "OUT", help_heading = None::<&str>)]
    pub output: String,

    /// Sides of square pictures, with commas: each model is drawn in each size
    #[arg(long, value_name = "N,...", value_delimiter = ',', conflicts_with = "size",
          value_parser = value_parsers::within::<u32>(1, 32768), help_heading = "Batch")]
    pub sizes: Vec<u32>,

    /// Views, with commas: three-quarter, front, back, left, right, top, bottom; each model is drawn from each
    #[arg(long, value_name = "VIEW,...", value_delimiter = ',', conflicts_with_all = ["view", "eye", "camera"],
          help_heading = "Batch")]
    pub views: Vec<String>,

    /// File of presets (TOML), as of the service: names for sets of options; columns and keys "preset" of a manifest name some of them
    #[arg(long, value_name = "FILE", help_heading = "Batch")]
    pub presets: Option<PathBuf>,

    /// Presets of that file, with commas: each model is drawn by each; a row's own options go before theirs
    #[arg(long, value_name = "NAME,...", value_delimiter = ',', requires = "presets", conflicts_with_all = ["sizes", "views"],
          help_heading = "Batch")]
    pub preset: Vec<String>,

    /// Write OUT.json beside each picture: what overcoat render --json tells, without times
    #[arg(long, help_heading = "Batch")]
    pub sidecars: bool,

    /// Also write planes of the G-buffer, as overcoat render does
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = value_parsers::aov, help_heading = "Batch")]
    pub aov: Vec<Aov>,

    /// Where a line of JSON is written for each picture; {shard} in it stands for INDEX-of-COUNT [default: report.jsonl beside the
    /// pictures]
    #[arg(long, value_name = "FILE", help_heading = "Batch")]
    pub report: Option<PathBuf>,

    /// At the end, write the report as a table, a row for each picture: names, hashes, sizes, counts, extents, colours, warnings, errors
    /// (.parquet, .csv)
    #[arg(long, value_name = "FILE", help_heading = "Batch")]
    pub catalogue: Option<PathBuf>,

    /// Leave out models that have not changed since: a date (2026-11-01, 2026-11-01T12:00:00Z), a duration before now (36h, 7days), or a
    /// file, whose own time counts. Of a model the file itself is looked at, not those that it refers to
    #[arg(long, value_name = "WHEN", help_heading = "Batch")]
    pub changed_since: Option<String>,

    /// Show the progress at this address as a page (/status.json for programs), as 127.0.0.1:8090
    #[arg(long, value_name = "ADDRESS:PORT", help_heading = "Batch")]
    pub status: Option<SocketAddr>,

    /// Go on with the report that is there: pictures that were made of the same are kept
    #[arg(long, help_heading = "Batch")]
    pub resume: bool,

    /// Exit code 0, too, where models have no picture for reasons of their own (damaged, too large, too slow), which the report
    /// says. What cannot be read or written, or has no worker, still makes it 1
    #[arg(long, help_heading = "Batch")]
    pub allow_failures: bool,

    /// Do one part of several, chosen by the models' names: INDEX/COUNT from 0, or auto or auto/COUNT for what a job of Kubernetes,
    /// AWS Batch or SLURM says of itself
    #[arg(long, value_name = "INDEX/COUNT", help_heading = "Batch")]
    pub shard: Option<String>,

    /// Draw this part of the pictures again in another process, 0 to 1, and fail those whose bytes differ
    #[arg(long, value_name = "PART", default_value = "0", value_parser = value_parsers::within::<f64>(0.0, 1.0),
          help_heading = "Batch")]
    pub verify: f64,

    /// Processes that draw, each with --threads threads (1 unless given) [default: one for each processor]
    #[arg(long, value_name = "N", value_parser = value_parsers::within::<usize>(1, 4096), help_heading = "Workers")]
    pub workers: Option<usize>,

    /// Models that one worker draws before another takes its place
    #[arg(long, value_name = "N", default_value = "200", value_parser = value_parsers::within::<u32>(1, u32::MAX),
          help_heading = "Workers")]
    pub models_of_worker: u32,

    #[command(flatten)]
    pub limits: WorkerLimitArgs,
    #[command(flatten)]
    pub converters: ConverterArgs,
    #[command(flatten)]
    pub encoding: EncodingArgs,
    #[command(flatten)]
    pub draw: DrawArgs,
}

impl BatchArgs {
    /// Processes that draw.
    #[must_use]
    pub fn workers(&self) -> usize {
        let processors = || std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
        self.workers.unwrap_or_else(processors)
    }
}
