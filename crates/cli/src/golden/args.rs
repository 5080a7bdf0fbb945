//! The command line of `overcoat golden`.

use crate::args::{LimitArgs, ThreadArgs};
use crate::value_parsers;
use clap::{Args, Subcommand};
use overcoat_description::one_of;
use overcoat_golden::thresholds::{self, Preset};
use std::path::PathBuf;

/// `overcoat golden`
#[derive(Debug, Args)]
#[command(
    arg_required_else_help = true,
    after_help = "Examples:
  overcoat golden check tests/golden out
  overcoat golden report tests/golden out -o report.html
  overcoat golden accept tests/golden out car.png

Pictures are .png and .apng (8 and 16 bits), .webp, .gif, .jpg, .bmp, .tga, .tif (8 and 16 bits, float), .ppm and its like, \
.qoi, .exr (half and float, every channel) and .hdr, in folders and the folders in them, paired by name. Of animated PNG, \
WebP and GIF every frame is compared, and how long it is shown. Files of other formats have to be the same in every byte. \
Which renderer made them does not matter."
)]
pub struct GoldenArgs {
    /// What to do.
    #[command(subcommand)]
    pub command: GoldenCommand,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub enum GoldenCommand {
    /// Compare two folders of pictures, or two pictures
    Check(CheckArgs),
    /// Compare and write one HTML page that shows where pictures differ
    Report(ReportArgs),
    /// Take actual pictures as expected ones, PNG compressed without loss
    Accept(AcceptArgs),
}

const EXIT_CODES: &str = "Exit codes: 0 equal within thresholds; 4 something differs, or is there on one side only; \
     1 something could not be read or compared (this wins over 4); 2 wrong usage; 3 limit exceeded";

const THRESHOLDS: &str =
    "Without thresholds pictures must be equal in every sample. A threshold file is TOML:

  preset = \"gpu\"       # max_abs = 3 codes of 255 (0.012 of linear light), pixels = 12; or \"exact\"

or with limits of one's own, which win over a preset:

  max_abs = 2          # for all files: codes of 255 (or 65535), linear light in .exr and .hdr
  pixels = 20          # so many may differ by more than max_abs

  [\"cars/*.exr\"]       # later tables win; * ends at /, ** does not
  flip_mean = 0.01     # also: flip_max, psnr (at least, dB), ssim (at least)
  start_exposure = -2  # also: stop_exposure, pixels_per_degree, max_bytes, background = \"#808080\"";

/// What is compared, and how.
#[derive(Debug, Args)]
pub struct FolderArgs {
    /// Folder of the expected pictures, or one picture
    #[arg(value_name = "EXPECTED")]
    pub expected: PathBuf,

    /// Folder of the actual pictures, or one picture; x.new.png stands for x.png
    #[arg(value_name = "ACTUAL")]
    pub actual: PathBuf,

    /// How much pictures may differ [default: thresholds.toml in EXPECTED, if it is there]
    #[arg(long, value_name = "FILE")]
    pub thresholds: Option<PathBuf>,

    /// Limits where the threshold file says nothing: exact is equality; gpu allows 3 codes of 255 everywhere,
    /// and 12 pixels that differ by more [default: exact]
    #[arg(long, value_name = "NAME", value_parser = preset)]
    pub preset: Option<Preset>,

    /// Pixels in one degree of the observer's view, 1 to 1000, for FLIP [default: 67.02, 3840 pixels on 0.7 m seen from 0.7 m]
    #[arg(long, value_name = "N", value_parser = value_parsers::within::<f32>(1.0, 1000.0),
          allow_negative_numbers = true)]
    pub pixels_per_degree: Option<f32>,

    /// What is behind translucent pixels for PSNR, SSIM and FLIP, an sRGB colour, #808080 if not given
    #[arg(long, value_name = "COLOR", value_parser = background)]
    pub background: Option<[u8; 3]>,

    #[command(flatten)]
    pub workers: ThreadArgs,
    #[command(flatten)]
    pub limits: LimitArgs,

    /// Print no table and no progress
    #[arg(short, long)]
    pub quiet: bool,
}

/// Where results go beside the table.
#[derive(Debug, Args)]
#[command(next_help_heading = "Results")]
pub struct ResultArgs {
    /// Also complain of expected pictures that are stored larger than they must be (larger than a fresh render, and than
    /// accept would store them), and of thresholds that are for no picture
    #[arg(long)]
    pub strict: bool,

    /// Write the results as JSON to a file, or without one (or with -) to standard output in place of the table
    #[arg(long, value_name = "FILE", num_args = 0..=1, default_missing_value = "-")]
    pub json: Option<PathBuf>,

    /// Write the results as JUnit XML, or - for standard output in place of the table
    #[arg(long, value_name = "FILE")]
    pub junit: Option<PathBuf>,
}

/// `overcoat golden check`
#[derive(Debug, Args)]
#[command(after_help = format!("Example:
  overcoat golden check tests/golden out --strict --json result.json

{THRESHOLDS}

{EXIT_CODES}"))]
pub struct CheckArgs {
    #[command(flatten)]
    pub folders: FolderArgs,
    #[command(flatten)]
    pub results: ResultArgs,
}

/// `overcoat golden report`
#[derive(Debug, Args)]
#[command(after_help = format!("Example:
  overcoat golden report tests/golden out -o report.html

The page needs no network and no other file. It is also written when all is well.

{EXIT_CODES}"))]
pub struct ReportArgs {
    #[command(flatten)]
    pub folders: FolderArgs,

    /// Page to write (.html), or - for standard output
    #[arg(short, long, value_name = "OUT")]
    pub output: PathBuf,

    /// Also show pictures that are equal in every sample, which are only listed otherwise
    #[arg(long)]
    pub include_equal: bool,

    #[command(flatten)]
    pub results: ResultArgs,
}

/// `overcoat golden accept`
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  overcoat golden accept tests/golden out car.png 'wheels/*.exr'
  overcoat golden accept tests/golden out --all --dry-run

PNG files are compressed as far as they go; every pixel, its depth and the chunks that say what it means \
(sRGB, gAMA, cHRM, iCCP, cICP) stay. Other files are copied. Actual pictures called x.new.png are removed \
once they are accepted.

Exit codes: 0 done, 1 something could not be accepted, 2 wrong usage, 3 limit exceeded")]
pub struct AcceptArgs {
    #[command(flatten)]
    pub folders: FolderArgs,

    /// Names of pictures below the folders, with * and ** as in threshold files
    #[arg(value_name = "NAME", required_unless_present = "all", conflicts_with = "all")]
    pub names: Vec<String>,

    /// Every picture that does not pass, and those that are stored larger than they must be
    #[arg(long)]
    pub all: bool,

    /// Only say what would be done
    #[arg(long)]
    pub dry_run: bool,

    /// Print what was done as JSON to standard output
    #[arg(long)]
    pub json: bool,
}

/// A preset by name.
fn preset(text: &str) -> Result<Preset, String> {
    Preset::from_name(text).ok_or_else(|| one_of(text, Preset::ALL.iter().map(|preset| preset.name())))
}

fn background(text: &str) -> Result<[u8; 3], String> {
    thresholds::colour(text)
        .ok_or_else(|| "expected a colour such as #808080 (the # may be left out)".to_owned())
}
