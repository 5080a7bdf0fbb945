//! Groups of options that commands have in common, each defined once.

use super::formats::{extensions, model_files};
use super::options::{Drawing, Options, Reading};
use crate::environment_cache::keep_environments;
use crate::report::Reporter;
use crate::value_parsers;
use clap::Args;
use overcoat_core::jobs::MAX_THREADS;
use overcoat_core::limits::Limits;
use overcoat_core::math::lanes::SimdLevel;
use overcoat_description::{Description, Machine, MaterialChoice};
use overcoat_image::output::OutputFormat;
use overcoat_render::Renderer;
use overcoat_scene::Axis;
use overcoat_scene::ShadingModel;
use overcoat_worker::picture_format::PictureFormat;
use std::path::PathBuf;

/// Help of an option that takes shading models: what it is, and all of them.
pub(super) fn models(what: &str) -> String {
    let named = |model: ShadingModel| format!("{} ({})", model.name(), model.version());
    let names: Vec<String> = ShadingModel::ALL.iter().copied().map(named).collect();
    format!("{what}\n\n{}.", names.join(", "))
}

/// Heading of the options that never change the picture.
pub const MACHINE: &str = "Machine (these never change the picture)";

/// How the picture becomes a file.
#[derive(Debug, Default, Args)]
pub struct EncodingArgs {
    /// Format of the file: png, webp (lossless), jpg, exr or hdr [default: by the name of OUT; png for -]
    ///
    /// Sheets and moving pictures are for screens: not exr, not hdr.
    #[arg(long, value_name = "FORMAT", value_parser = value_parsers::output_format)]
    pub output_format: Option<OutputFormat>,

    /// Quality of .jpg, 1 to 100 [default: 90]
    #[arg(long, value_name = "N", value_parser = value_parsers::within::<u8>(1, 100), allow_negative_numbers = true)]
    pub jpeg_quality: Option<u8>,
}

/// How the picture becomes a file, or what a terminal shows.
#[derive(Debug, Default, Args)]
pub struct PictureEncodingArgs {
    /// Format of the file: png, webp (lossless), jpg, exr or hdr; or kitty, sixel or blocks, which a terminal shows
    /// [default: by the name of OUT; png for -]
    ///
    /// kitty is the graphics protocol of that terminal and others, sixel graphics as of the VT340, blocks half blocks in 24-bit
    /// colours for any other. Written to a terminal, they fit it unless --size says otherwise; a file takes them under any name
    /// that is of no other format. Where less than half of a pixel is covered, sixel and blocks leave it out; they have no shadow on the
    /// floor unless --ground or a --background asks for it.
    #[arg(long, value_name = "FORMAT", value_parser = value_parsers::picture_format)]
    pub output_format: Option<PictureFormat>,

    /// Quality of .jpg, 1 to 100 [default: 90]
    #[arg(long, value_name = "N", value_parser = value_parsers::within::<u8>(1, 100), allow_negative_numbers = true)]
    pub jpeg_quality: Option<u8>,
}

impl From<&EncodingArgs> for PictureEncodingArgs {
    fn from(args: &EncodingArgs) -> Self {
        Self { output_format: args.output_format.map(PictureFormat::File), jpeg_quality: args.jpeg_quality }
    }
}

/// One model, and how it is drawn.
#[derive(Debug, Args)]
pub struct ModelArgs {
    /// Model file (also in gzip or Zstandard), a pipe, or - for standard input
    #[arg(value_name = "IN", required_unless_present = "scene", help_heading = None::<&str>,
          long_help = model_files("Model file", ", also in gzip or Zstandard; a pipe, or - for standard input"))]
    pub input: Option<PathBuf>,

    #[command(flatten)]
    pub draw: DrawArgs,
}

/// What every command takes that draws models.
#[derive(Debug, Default, Args)]
pub struct DrawArgs {
    /// Read model, environment, camera, size and the rest from a JSON or TOML file; options override it
    #[arg(long, value_name = "FILE", help_heading = None::<&str>)]
    pub scene: Option<PathBuf>,
    /// What is in that file, if it has been read already
    #[arg(skip)]
    pub described: Option<Box<Description>>,

    /// Write a picture that shows nothing of the model, too: that is a warning then and not an error
    #[arg(long, help_heading = None::<&str>)]
    pub allow_empty: bool,

    #[command(flatten)]
    pub options: Options<Drawing>,

    /// Make the model of a material: a .toml file or the name of a built-in one, for every mesh or for the
    /// materials of one name in the model; may be repeated, later ones lie over earlier ones
    #[arg(long = "material", value_name = "[NAME=]FILE|BUILT-IN", value_parser = value_parsers::MaterialParser,
          hide_possible_values = true, help_heading = "Picture")]
    pub materials: Vec<MaterialChoice>,

    #[command(flatten)]
    pub machine: MachineArgs,
    #[command(flatten)]
    pub input: InputArgs,
    #[command(flatten)]
    pub report: ReportArgs,
}

/// How many threads work.
#[derive(Debug, Default, Args)]
pub struct ThreadArgs {
    /// Worker threads, 0 to 256; 0 stands for one per processor
    #[arg(long, value_name = "N", value_parser = value_parsers::within::<u16>(0, MAX_THREADS as u16),
          allow_negative_numbers = true, default_value_t = 0, help_heading = MACHINE)]
    pub threads: u16,
}

/// Options that never change the picture.
#[derive(Debug, Args)]
#[command(next_help_heading = MACHINE)]
pub struct MachineArgs {
    #[command(flatten)]
    pub workers: ThreadArgs,

    /// Side of a tile in pixels: 16, 32 or 64 [default: by the number of samples]
    #[arg(long, value_name = "N", value_parser = value_parsers::tile, allow_negative_numbers = true)]
    pub tile: Option<u32>,

    /// Instruction set: auto, sse2, avx2, avx512, neon, simd128 or (where it is compiled in) scalar; one that is not there is an
    /// error
    #[arg(long, value_name = "LEVEL", default_value = "auto", value_parser = value_parsers::simd)]
    pub simd: SimdLevel,

    /// Keep filtered environments in this folder and find them there: environments from files then take a tenth of the time
    ///
    /// The folder is made if it is not there, and may be shared. It is kept below 256 MiB: what was written first goes first. Of
    /// what is damaged nothing is used. With --sandbox nothing is added to it.
    #[arg(long, value_name = "FOLDER")]
    pub cache: Option<PathBuf>,
}

/// Options of reading files.
#[derive(Debug, Default, Args)]
#[command(next_help_heading = "Input")]
pub struct InputArgs {
    /// Format of a model from standard input [default: by its content]
    #[arg(long, value_name = "FORMAT", long_help = format!(
        "Format of a model from standard input: {} [default: by its content]",
        extensions("").join(", ")
    ))]
    pub format: Option<String>,

    /// Material variant of the model (glTF), by name or by number from 0 [default: the model's own materials]
    #[arg(long, value_name = "NAME|INDEX")]
    pub variant: Option<String>,

    #[command(flatten)]
    pub options: Options<Reading>,

    #[command(flatten)]
    pub limits: LimitArgs,
}

/// Bounds that are changed.
#[derive(Debug, Default, Args)]
pub struct LimitArgs {
    /// Change a bound on what a file may ask for, e.g. texture_pixels=100M; may be repeated
    ///
    /// input_bytes, decoded_bytes, triangles, vertices, nodes, depth, textures, texture_pixels, total_texture_pixels,
    /// lights, output_side, output_pixels, fragments, shading, blocks, blend_entries, frame_bytes, frames. Suffixes k, M, G are
    /// powers of 1000, Ki, Mi, Gi powers of 1024. Exceeding a limit is exit code 3.
    #[arg(long = "limit", value_name = "NAME=VALUE", value_parser = value_parsers::limit)]
    pub limits: Vec<(String, u64)>,
}

/// Options of what is printed.
#[derive(Debug, Default, Args)]
#[command(next_help_heading = "Report")]
pub struct ReportArgs {
    /// Print results and warnings as JSON to standard output
    #[arg(long)]
    pub json: bool,

    /// Print no warnings and no progress
    #[arg(short, long)]
    pub quiet: bool,
}

impl DrawArgs {
    /// A renderer with as many threads as are wanted; a warning if the system does not give them.
    #[must_use]
    pub fn renderer(&self) -> Renderer {
        self.machine.renderer(self.report.quiet)
    }
}

impl MachineArgs {
    /// What the picture needs from the machine.
    #[must_use]
    pub fn machine(&self) -> Machine {
        Machine::default().with_simd(self.simd).with_tile_size(self.tile)
    }

    /// A renderer with as many threads as are wanted; a warning, unless `quiet`, if the system does not give them.
    #[must_use]
    pub fn renderer(&self, quiet: bool) -> Renderer {
        let (mut renderer, reporter) = (Renderer::new(self.workers.count()), Reporter { quiet });
        reporter.threads(renderer.jobs());
        if let Some(folder) = &self.cache {
            keep_environments(&mut renderer, folder, reporter);
        }
        renderer
    }
}

impl Default for MachineArgs {
    /// Without options.
    fn default() -> Self {
        Self { workers: ThreadArgs::default(), tile: None, simd: SimdLevel::best(), cache: None }
    }
}

impl ThreadArgs {
    /// Worker threads; 0 stands for one per processor.
    #[must_use]
    pub fn count(&self) -> usize {
        self.threads.into()
    }
}

impl LimitArgs {
    /// The limits, with what the options change.
    #[must_use]
    pub fn limits(&self) -> Limits {
        value_parsers::limits(&self.limits)
    }
}

impl DrawArgs {
    /// Lays the options over a scene file.
    pub fn apply(&self, scene: &mut Description) {
        self.options.apply(scene);
        self.input.options.apply(scene);
        scene.more_materials.extend_from_slice(&self.materials);
    }
}

impl InputArgs {
    /// The axis of the model file that is up, if one is given.
    #[must_use]
    pub fn up(&self) -> Option<Axis> {
        self.description().up
    }

    /// The plate of a 3MF project that is read alone, if one is given.
    #[must_use]
    pub fn plate(&self) -> Option<u32> {
        self.description().plate
    }

    fn description(&self) -> Description {
        let mut description = Description::default();
        self.options.apply(&mut description);
        description
    }
}
