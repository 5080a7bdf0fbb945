//! The options of each command, beside the groups that it shares with others.

use super::formats::model_files;
use super::groups::{
    DrawArgs, EncodingArgs, InputArgs, MachineArgs, ModelArgs, PictureEncodingArgs, ReportArgs, ThreadArgs,
    models,
};
use super::options::{Lighting, Options, Posing};
use crate::value_parsers;
use clap::Args;
use overcoat_core::frame::Aov;
use overcoat_scene::ShadingModel;
use std::path::PathBuf;

/// `overcoat render`
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  overcoat render car.glb
  overcoat render car.glb -o car.png --size 1920x1080 --view 1,0.3,1 --background white
  overcoat render car.glb -o car.exr --env sky.hdr --env-rotation 90 --aov depth,normal
  overcoat render part.stl -o part.png --view front --ortho --samples 16
  overcoat render --scene car.json -o car.png
  overcoat render fox.glb -o fox.png --animation Walk --time 0.4
  curl -s https://example.com/car.glb | overcoat render - -o - > car.png
  overcoat render car.glb -o - --output-format sixel

Exit codes: 0 done, 1 failed, 2 wrong usage, 3 limit exceeded")]
pub struct RenderArgs {
    /// Picture to write (.png, .webp, .jpg, .exr or .hdr), or - for standard output [default: the model's name with .png, in
    /// this folder]
    ///
    /// Under the default name, a file that was not made this way is replaced with --force only.
    #[arg(short, long, value_name = "OUT")]
    pub output: Option<PathBuf>,
    /// Nobody has named the picture
    #[arg(skip)]
    pub is_unnamed: bool,

    /// Replace whatever has the default name of the picture
    #[arg(long, conflicts_with = "output")]
    pub force: bool,

    #[command(flatten)]
    pub encoding: PictureEncodingArgs,

    /// Also write planes of the G-buffer: layers of an .exr, files beside others (OUT.depth.png)
    ///
    /// Comma-separated: depth, position, normal, camera-normal, coat-normal, tangent, base-color, roughness, metallic,
    /// specular-color, occlusion, emissive, coat, coat-thickness, coat-color, sheen-color, sheen-roughness, anisotropy,
    /// iridescence, second-lobe, subsurface, specular-occlusion, bent-normal, material-id, object-id, instance-id, uv, coverage,
    /// visibility (share of the environment's light that arrives), shadow (share of that of lights), ground (opacity of the
    /// floor). Identities are 16-bit grey .png files, 0 where nothing is; --json has their names and boxes.
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = value_parsers::aov)]
    pub aov: Vec<Aov>,

    /// Show the picture that the file carries of itself (3MF, G-code, Blender), scaled, in place of rendering its model
    #[arg(long, conflicts_with_all = ["aov", "stage_hashes"])]
    pub embedded: bool,

    /// Add to --json a hash of what each stage handed to the next: where two machines differ, the first that differs
    /// names the stage to look into
    #[arg(long, requires = "json")]
    pub stage_hashes: bool,

    #[command(flatten)]
    pub animation: Options<Posing>,
    #[command(flatten)]
    pub model: ModelArgs,
}

/// `overcoat diagnose`
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  overcoat diagnose car.glb
  overcoat diagnose car.glb --json --eye 0,1,4 --exposure 2

Options are those of render, and decisions too; the picture is drawn with at most 256 pixels a side. Options that mend \
something go in place of others that place the camera.

Exit codes: 0 done, 1 failed, 2 wrong usage, 3 limit exceeded, 5 something is wrong (--strict)")]
pub struct DiagnoseArgs {
    /// End with exit code 5 if there is more than notes to say
    #[arg(long)]
    pub strict: bool,

    #[command(flatten)]
    pub animation: Options<Posing>,
    #[command(flatten)]
    pub model: ModelArgs,
}

/// What moving pictures have in common.
#[derive(Debug, Args)]
pub struct MovieArgs {
    /// Output file: .gif (256 colours a frame), .png or .apng (animated PNG), .webp (lossless), a .png, .webp or .jpg with #
    /// in its name for a numbered picture each frame (out-####.png), or - for standard output (animated PNG, or with
    /// --output-format webp)
    #[arg(short, long, value_name = "OUT")]
    pub output: PathBuf,

    #[command(flatten)]
    pub encoding: EncodingArgs,

    /// Frames a second, 0.1 to 1000
    #[arg(long, value_name = "N", value_parser = value_parsers::within::<f64>(0.1, 1000.0),
          allow_negative_numbers = true, default_value = "24")]
    pub fps: f64,

    /// Size limit of the file in bytes (suffixes k, M, Ki, Mi): frames are drawn smaller until it fits, with a warning
    #[arg(long, value_name = "N", value_parser = value_parsers::bytes)]
    pub max_bytes: Option<u64>,
}

/// `overcoat turntable`
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  overcoat turntable car.glb -o car.png
  overcoat turntable car.glb -o car.gif --max-bytes 5M
  overcoat turntable car.glb -o car.webp --seconds 4 --fps 30 --background white
  overcoat turntable car.glb -o car-####.png --frames 36 --turn camera

The model is loaded once; the camera's distance fits it from all sides. The first frame follows the last.")]
pub struct TurntableArgs {
    #[command(flatten)]
    pub movie: MovieArgs,

    /// Frames of the turn [default: as many as --seconds and --fps make]
    #[arg(long, value_name = "N", value_parser = value_parsers::within::<u32>(1, u32::MAX),
          allow_negative_numbers = true, conflicts_with = "seconds")]
    pub frames: Option<u32>,

    /// Seconds of the turn [default: 3]
    #[arg(long, value_name = "SECONDS", value_parser = value_parsers::seconds, allow_negative_numbers = true)]
    pub seconds: Option<f64>,

    /// What turns: model, under light that stays, or camera, around a model that stays
    #[arg(long, value_name = "WHAT", default_value = "model")]
    pub turn: Turn,

    #[command(flatten)]
    pub animation: Options<Posing>,
    #[command(flatten)]
    pub model: ModelArgs,
}

/// What turns around the vertical axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Turn {
    /// The model with its lights, counter-clockwise seen from above.
    Model,
    /// The camera, counter-clockwise seen from above.
    Camera,
}

impl From<Turn> for overcoat_worker::turning::Turn {
    fn from(turn: Turn) -> Self {
        match turn {
            Turn::Model => Self::Model,
            Turn::Camera => Self::Camera,
        }
    }
}

/// `overcoat animate`
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  overcoat animate fox.glb -o fox.png --animation Walk
  overcoat animate fox.glb -o fox.webp --animation Run --fps 30 --background white
  overcoat animate fox.glb -o fox-####.png --from 0.2 --to 0.5

The file is read once; a camera that is not given fits all frames and stays. overcoat info lists the animations.")]
pub struct AnimateArgs {
    #[command(flatten)]
    pub movie: MovieArgs,

    /// Animation of the model file, by name or by number from 0 [default: that of the scene file, else 0]
    #[arg(long, value_name = "NAME|INDEX")]
    pub animation: Option<String>,

    /// Second of the first frame
    #[arg(long, value_name = "SECONDS", value_parser = value_parsers::seconds, allow_negative_numbers = true,
          default_value = "0")]
    pub from: f64,

    /// Second before which the last frame is [default: the end of the animation]
    #[arg(long, value_name = "SECONDS", value_parser = value_parsers::seconds, allow_negative_numbers = true)]
    pub to: Option<f64>,

    #[command(flatten)]
    pub model: ModelArgs,
}

/// `overcoat info`
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  overcoat info car.glb\n  overcoat info car.glb --json")]
pub struct InfoArgs {
    /// Model file, or - for standard input
    #[arg(value_name = "IN", long_help = model_files("Model file", ", or - for standard input"))]
    pub input: PathBuf,

    /// Fail if anything of the file cannot be read: whatever would be a warning
    #[arg(long)]
    pub strict: bool,

    #[command(flatten)]
    pub workers: ThreadArgs,
    #[command(flatten)]
    pub input_options: InputArgs,
    #[command(flatten)]
    pub report: ReportArgs,
}

/// `overcoat formats`
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  overcoat formats
  overcoat formats --json")]
pub struct FormatsArgs {
    /// Print them as JSON to standard output, with media types and extensions
    #[arg(long)]
    pub json: bool,
}

/// What contact sheets have in common.
#[derive(Debug, Default, Args)]
pub struct CellArgs {
    /// Cells in a row [default: as many as make the sheet about square]
    #[arg(long, value_name = "N", value_parser = value_parsers::within::<u32>(1, 1000), allow_negative_numbers = true,
          requires = "output")]
    pub columns: Option<u32>,

    #[command(flatten)]
    pub encoding: EncodingArgs,
}

/// What `--size` is where each model is a cell of a sheet.
const CELL_SIZE: &str = "Width and height of a cell in pixels; one number makes a square [default: 256x256]";

/// `overcoat sheet`
#[derive(Debug, Args)]
#[command(mut_arg("size", |size| size.help(CELL_SIZE)), after_help = "Example:
  overcoat sheet models/*.glb -o sheet.png --size 256 --columns 6

A model that fails, or shows nothing, gets a cell with the reason. The sheet is written all the same, and the exit code is
1.")]
pub struct SheetArgs {
    /// Model files, or - for standard input
    #[arg(value_name = "IN", required = true, long_help = model_files("Model files", ", or - for standard input"))]
    pub inputs: Vec<PathBuf>,

    /// Contact sheet to write (.png, .webp or .jpg), or - for standard output
    #[arg(short, long, value_name = "OUT")]
    pub output: PathBuf,

    #[command(flatten)]
    pub cells: CellArgs,
    #[command(flatten)]
    pub draw: DrawArgs,
}

/// `overcoat compare-models`
#[derive(Debug, Args)]
#[command(
    mut_arg("size", |size| size.help(CELL_SIZE)),
    // A mistake that is explained, not an option.
    mut_arg("shading", |shading| shading.hide(true)),
    after_help = "Example:
  overcoat compare-models car.glb -o models.png --models urp17,stacklit,filament,three

Below each picture is its difference to that of --against, four times as strong: black where both \
                  agree."
)]
pub struct CompareModelsArgs {
    /// Labelled sheet to write (.png, .webp or .jpg), or - for standard output
    #[arg(short, long, value_name = "OUT")]
    pub output: PathBuf,

    /// Shading models to show, comma-separated [default: all]
    #[arg(
        long,
        value_name = "LIST",
        value_delimiter = ',',
        value_parser = value_parsers::shading,
        long_help = models("Shading models to show, comma-separated [default: all]")
    )]
    pub models: Vec<ShadingModel>,

    /// Shading model that the others are compared with
    #[arg(long, value_name = "MODEL", value_parser = value_parsers::shading, default_value = "standard")]
    pub against: ShadingModel,

    #[command(flatten)]
    pub cells: CellArgs,
    #[command(flatten)]
    pub model: ModelArgs,
}

/// `overcoat diff`
#[derive(Debug, Args)]
#[command(mut_arg("size", |size| size.help("Width and height of each picture in pixels; one number makes a square [default: 512x512]")),
          after_help = "Examples:
  overcoat diff old.glb new.glb -o diff.png
  overcoat diff old.glb new.glb -o diff.png --exit-code --json --view front --shading three

One camera shows both whole; exposure and floor are those of the first. Left, what was; in the middle, what is; right, the \
difference of what a screen shows, four times as strong: black where both agree.

Exit codes: 0 done, 1 failed, 2 wrong usage, 3 limit exceeded, 4 the pictures differ (--exit-code)")]
pub struct DiffArgs {
    /// Model file as it was, and as it is
    #[arg(value_names = ["BEFORE", "AFTER"], num_args = 2, required = true,
          long_help = model_files("Model file as it was, and as it is", ""))]
    pub models: Vec<PathBuf>,

    /// Labelled sheet to write (.png, .webp or .jpg), or - for standard output
    #[arg(short, long, value_name = "OUT")]
    pub output: PathBuf,

    /// End with exit code 4 if the pictures differ in a bit of their linear light
    #[arg(long)]
    pub exit_code: bool,

    #[command(flatten)]
    pub cells: CellArgs,
    #[command(flatten)]
    pub draw: DrawArgs,
}

/// `overcoat bench`
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  overcoat bench car.glb --frames 100 --size 1920x1080 --samples 4
  overcoat bench a.glb b.glb c.glb --rounds 5 --png

One model: loading, the environment and one frame come first and are not counted. Several models, or \
--rounds or --png: each frame loads the next model, renders it and lets it go; the environment, the \
materials of --material and the renderer stay, and one pass over all models comes first and is not \
counted. Times are wall-clock milliseconds; processor time is user and system time of the whole process \
over the counted frames.")]
pub struct BenchArgs {
    /// Model files, or - for standard input; of several, a new one each frame
    #[arg(value_name = "IN", required_unless_present = "scene",
          long_help = model_files("Model files", ", or - for standard input; of several, a new one each frame"))]
    pub inputs: Vec<PathBuf>,

    /// Frames that are counted, evenly spaced over one turn of the camera
    #[arg(long, value_name = "N", value_parser = value_parsers::within::<u32>(1, 1_000_000),
          allow_negative_numbers = true, default_value_t = 60)]
    pub frames: u32,

    /// A new model each frame: passes over all models that are counted [default: 1]
    #[arg(long, value_name = "N", value_parser = value_parsers::within::<u32>(1, 1_000_000),
          allow_negative_numbers = true, conflicts_with = "frames")]
    pub rounds: Option<u32>,

    /// Make pictures of 8 bits, as for PNG, in place of frames of linear light
    #[arg(long)]
    pub image: bool,

    /// A new model each frame: also encode each picture as a PNG in memory (implies --image)
    #[arg(long, conflicts_with = "frames")]
    pub png: bool,

    #[command(flatten)]
    pub draw: DrawArgs,
}

/// `overcoat materials`
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  overcoat materials
  overcoat materials candy-red > mine.toml
  overcoat materials --keys
  overcoat materials -o materials.png --size 192

A file that is printed names its textures by their paths in assets/materials of the sources.")]
pub struct MaterialsArgs {
    /// Print the file of this one, to start from
    #[arg(value_name = "NAME", conflicts_with_all = ["output", "keys"])]
    pub name: Option<String>,

    /// Contact sheet to write (.png, .webp or .jpg), or - for standard output
    #[arg(short, long, value_name = "OUT")]
    pub output: Option<PathBuf>,

    /// List the keys of material files instead, with what they take and their defaults
    #[arg(long, conflicts_with = "output")]
    pub keys: bool,

    #[arg(long, value_name = "WxH", value_parser = value_parsers::size, allow_hyphen_values = true, requires = "output",
          help = CELL_SIZE)]
    pub size: Option<[u64; 2]>,

    #[command(flatten)]
    pub cells: CellArgs,
    #[command(flatten)]
    pub light: Options<Lighting>,
    #[command(flatten)]
    pub machine: MachineArgs,
    #[command(flatten)]
    pub report: ReportArgs,
}
