//! The command line: every option, its help and its default.

use super::golden::GoldenArgs;
use super::materials::MaterialChoice;
pub use super::motion_args::{AnimateArgs, AnimationArgs, Turn, TurntableArgs};
use super::scene_file::{EnvironmentChoice, SceneFile};
use super::values::{self, BackgroundChoice, ViewDirection};
use crate::color::ToneCurve;
use crate::frame::Aov;
use crate::limits::Limits;
use crate::math::lanes::SimdLevel;
use crate::render::{AreaLightMethod, ShadingModel};
use clap::{Args, Parser, Subcommand};
use std::path::PathBuf;

/// Renders 3D models to pictures on machines that have only a processor; the same bytes on every machine.
#[derive(Debug, Parser)]
#[command(
    name = "overcoat",
    version,
    max_term_width = 100,
    arg_required_else_help = true,
    after_help = "Example:\n  overcoat render car.glb -o car.png\n  overcoat render --help"
)]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,

    /// Before any file is read, give up every right that the work does not need: other files, network, programs (Linux)
    ///
    /// Landlock leaves the folders of the inputs to read and the folder of the output to write; seccomp leaves memory,
    /// threads and open files. An error on systems without them (Linux 5.13 on x86-64 or 64-bit ARM has them).
    #[arg(long, global = true, help_heading = "Machine (these never change the picture)")]
    pub sandbox: bool,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Render one model to a picture
    Render(Box<RenderArgs>),
    /// Turn a model once around: an animated PNG or WebP, or numbered pictures
    Turntable(Box<TurntableArgs>),
    /// Play an animation of a model: an animated PNG or WebP, or numbered pictures
    Animate(Box<AnimateArgs>),
    /// Print what a model file contains
    Info(InfoArgs),
    /// Render many models to one labelled contact sheet
    Sheet(Box<SheetArgs>),
    /// Measure frames of one model with an orbiting camera, or of a new model each
    Bench(Box<BenchArgs>),
    /// Render one model with every engine's shading model, side by side
    CompareModels(Box<CompareModelsArgs>),
    /// List the built-in materials, print one, or show all on a contact sheet
    Materials(Box<MaterialsArgs>),
    /// Compare pictures of any renderer with expected ones; report, accept
    Golden(Box<GoldenArgs>),
    /// Try what a program that was taken over would try, to see that --sandbox holds on this machine
    #[command(hide = true)]
    Attempt(AttemptArgs),
}

const EXIT_CODES: &str = "Exit codes: 0 done, 1 failed, 2 wrong usage, 3 limit exceeded";

/// `overcoat render`
#[derive(Debug, Args)]
#[command(after_help = const_format_render())]
pub struct RenderArgs {
    /// Model file (.glb, .gltf, .obj, .stl, .ply), or - for standard input
    #[arg(value_name = "IN", required_unless_present = "scene")]
    pub input: Option<PathBuf>,

    /// Picture to write (.png, .exr or .hdr), or - for standard output
    #[arg(short, long, value_name = "OUT")]
    pub output: PathBuf,

    /// Format of the picture: png, exr or hdr [default: by the name of OUT; png for -]
    #[arg(long, value_name = "FORMAT")]
    pub output_format: Option<String>,

    /// Also write planes of the G-buffer: layers of an .exr, files beside a .png (OUT.depth.png)
    ///
    /// Comma-separated: depth, position, normal, coat-normal, tangent, base-color, roughness, metallic, specular-color,
    /// occlusion, emissive, coat, coat-thickness, coat-color, sheen-color, sheen-roughness, anisotropy, iridescence,
    /// second-lobe, subsurface, specular-occlusion, bent-normal, material-id, object-id, uv, coverage.
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = values::aov)]
    pub aov: Vec<Aov>,

    /// Add to --json a hash of what each stage handed to the next: where two machines differ, the first that differs
    /// names the stage to look into
    #[arg(long, requires = "json")]
    pub stage_hashes: bool,

    #[command(flatten)]
    #[allow(missing_docs)]
    pub scene: SceneArgs,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub animation: AnimationArgs,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub camera: CameraArgs,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub light: LightArgs,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub picture: PictureArgs,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub display: DisplayArgs,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub machine: MachineArgs,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub input_options: InputArgs,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub report: ReportArgs,
}

/// `overcoat attempt`
#[derive(Debug, Args)]
pub struct AttemptArgs {
    /// What to try
    #[arg(value_name = "WHAT", value_enum)]
    pub what: Attempt,

    /// The file that is read, written or removed, or the program that is run
    #[arg(value_name = "PATH")]
    pub path: Option<PathBuf>,

    /// Stands for the folder of a model
    #[arg(long, value_name = "FOLDER")]
    pub input: Option<PathBuf>,

    /// Stands for the folder of a picture
    #[arg(long, value_name = "FOLDER")]
    pub output: Option<PathBuf>,
}

/// What a program that was taken over would try.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Attempt {
    /// Read a file.
    Read,
    /// List a folder.
    List,
    /// Make a file.
    Write,
    /// Empty a file that may be read.
    Truncate,
    /// Remove a file.
    Remove,
    /// Give a file another name, beside it.
    Link,
    /// Speak to a server.
    Connect,
    /// Be a server.
    Listen,
    /// Send a datagram.
    Send,
    /// Open a socket of this machine.
    Local,
    /// Become another program.
    Execute,
    /// Start another program.
    Spawn,
    /// Start a thread and read a file in it.
    Thread,
}

/// The examples below `overcoat render --help`.
fn const_format_render() -> String {
    format!(
        "Examples:
  overcoat render car.glb -o car.png
  overcoat render car.glb -o car.png --size 1920x1080 --view 1,0.3,1 --background white
  overcoat render car.glb -o car.exr --env sky.hdr --env-rotation 90 --aov depth,normal
  overcoat render part.stl -o part.png --view front --ortho --samples 16
  overcoat render --scene car.json -o car.png
  overcoat render fox.glb -o fox.png --animation Walk --time 0.4
  curl -s https://example.com/car.glb | overcoat render - -o - > car.png

{EXIT_CODES}"
    )
}

/// Where the description of the picture comes from.
#[derive(Debug, Args)]
pub struct SceneArgs {
    /// Read model, environment, camera, size and the rest from a JSON or TOML file; options override it
    #[arg(long, value_name = "FILE")]
    pub scene: Option<PathBuf>,
}

/// Camera options.
#[derive(Debug, Args)]
#[command(next_help_heading = "Camera")]
pub struct CameraArgs {
    /// Direction from which the model is framed: three-quarter, front, back, left, right, top, bottom, or x,y,z from
    /// the model towards the camera [default: three-quarter, or another one if that shows a flat model edge-on]
    #[arg(long, value_name = "VIEW", value_parser = values::view, allow_hyphen_values = true,
          conflicts_with_all = ["eye", "camera"])]
    pub view: Option<ViewDirection>,

    /// Camera of the model file, by name or by number from 0
    #[arg(long, value_name = "NAME|INDEX", conflicts_with = "eye")]
    pub camera: Option<String>,

    /// Position of the camera in metres; +Y is up
    #[arg(long, value_name = "X,Y,Z", value_parser = values::vector, allow_hyphen_values = true)]
    pub eye: Option<[f32; 3]>,

    /// What the camera looks at [default: the middle of the model]
    #[arg(long, value_name = "X,Y,Z", value_parser = values::vector, allow_hyphen_values = true, requires = "eye")]
    pub target: Option<[f32; 3]>,

    /// Which way is up [default: 0,1,0]
    #[arg(long, value_name = "X,Y,Z", value_parser = values::vector, allow_hyphen_values = true,
          conflicts_with = "camera")]
    pub up: Option<[f32; 3]>,

    /// Vertical field of view in degrees [default: 30]
    #[arg(long, value_name = "DEGREES", value_parser = values::field_of_view, conflicts_with_all = ["camera", "ortho"])]
    pub fov: Option<f32>,

    /// Parallel projection, HEIGHT metres from the top of the picture to its bottom [default: fits the model]
    #[arg(long, value_name = "HEIGHT", value_parser = values::not_negative, num_args = 0..=1, require_equals = true,
          default_missing_value = "0", conflicts_with = "camera")]
    pub ortho: Option<f32>,
}

/// Light options.
#[derive(Debug, Args)]
#[command(next_help_heading = "Light")]
pub struct LightArgs {
    /// Equirectangular picture (.hdr, .exr) that lights the scene, studio for the built-in one, or none
    /// [default: studio]
    #[arg(long, value_name = "FILE|studio|none")]
    pub env: Option<String>,

    /// Turn the environment about the vertical axis, counter-clockwise seen from above [default: 0]
    #[arg(long, value_name = "DEGREES", value_parser = values::finite, allow_hyphen_values = true)]
    pub env_rotation: Option<f32>,

    /// Multiply the light of the environment [default: 1]
    #[arg(long, value_name = "FACTOR", value_parser = values::finite, allow_hyphen_values = true)]
    pub env_intensity: Option<f32>,

    /// Leave out the lights of the model file
    #[arg(long)]
    pub no_lights: bool,
}

/// Options that change the linear picture.
#[derive(Debug, Args)]
#[command(next_help_heading = "Picture")]
pub struct PictureArgs {
    /// Width and height in pixels; one number makes a square [default: 512x512]
    #[arg(long, value_name = "WxH", value_parser = values::size, allow_hyphen_values = true)]
    pub size: Option<[u64; 2]>,

    /// Samples a pixel for smooth edges: 1, 4, 8 or 16 [default: 8]
    #[arg(long, value_name = "N", value_parser = values::samples)]
    pub samples: Option<u32>,

    /// Formulas that shade every surface [default: what each material names, else gltf]
    ///
    /// urp-desktop, urp-mobile (Unity URP 13), urp17 (Unity 6), hdrp-lit, stacklit (Unity HDRP), filament,
    /// filament-mobile, filament-cloth, filament-2018, three, three-legacy, gltf (Khronos), gltf-sampled
    /// (the same by sixteen lookups a lobe), openpbr, velvet.
    #[arg(long, value_name = "MODEL", value_parser = values::shading)]
    pub shading: Option<ShadingModel>,

    /// Make the model of a material: a .toml file or the name of a built-in one, for every mesh or for the
    /// materials of one name in the model; may be repeated, later ones lie over earlier ones
    #[arg(long = "material", value_name = "[NAME=]FILE|BUILT-IN", value_parser = values::material)]
    pub materials: Vec<MaterialChoice>,

    /// How reflections of rectangles and tubes are integrated: ltc, as engines do, or facets, slower and within 1 percent
    /// [default: ltc]
    #[arg(long, value_name = "METHOD", value_parser = values::area_lights)]
    pub area_lights: Option<AreaLightMethod>,

    /// Largest anisotropy of texture filtering, 1 to 16 [default: 8]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=16))]
    pub anisotropy: Option<u32>,

    /// Shade triangles smaller than a pixel as one where their normals differ by less than this many degrees, 0 to 45:
    /// faster on dense meshes, with less smoothing of sharp reflections [default: 0]
    #[arg(long, value_name = "DEGREES")]
    pub merge_angle: Option<f32>,

    /// Width of lines in pixels, 0.1 to 64 [default: 1.5]
    #[arg(long, value_name = "PIXELS")]
    pub line_width: Option<f32>,

    /// Size of points in pixels, 0.1 to 64 [default: 3]
    #[arg(long, value_name = "PIXELS")]
    pub point_size: Option<f32>,
}

/// Options of the way from linear light to 8 bits.
#[derive(Debug, Args)]
#[command(next_help_heading = "Display")]
pub struct DisplayArgs {
    /// What is behind the model: transparent, env, #rrggbb or a colour name [default: transparent]
    #[arg(long, value_name = "COLOR", value_parser = values::background)]
    pub background: Option<BackgroundChoice>,

    /// Tone curve of 8-bit pictures: none (or linear), neutral, aces, agx [default: neutral]
    #[arg(long, value_name = "CURVE", value_parser = values::tone_curve)]
    pub tone_map: Option<ToneCurve>,

    /// Exposure of 8-bit pictures in stops: +1 doubles the light [default: 0]
    #[arg(long, value_name = "STOPS", value_parser = values::finite, allow_hyphen_values = true)]
    pub exposure: Option<f32>,
}

/// Options that never change the picture.
#[derive(Debug, Args)]
#[command(next_help_heading = "Machine (these never change the picture)")]
pub struct MachineArgs {
    /// Worker threads; 0 stands for one per processor
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = clap::value_parser!(u16).range(0..=1024))]
    pub threads: u16,

    /// Side of a tile in pixels: 16, 32 or 64 [default: by the number of samples]
    #[arg(long, value_name = "N", value_parser = values::tile)]
    pub tile: Option<u32>,

    /// Instruction set: auto, sse2, avx2, avx512, neon or (where it is compiled in) scalar; one that is not there is an
    /// error
    #[arg(long, value_name = "LEVEL", default_value = "auto", value_parser = values::simd)]
    pub simd: SimdLevel,
}

/// Options of reading files.
#[derive(Debug, Args)]
#[command(next_help_heading = "Input")]
pub struct InputArgs {
    /// Format of the model: gltf, glb, obj, stl or ply [default: by content and name]
    #[arg(long, value_name = "FORMAT")]
    pub format: Option<String>,

    /// Material variant of the model (glTF), by name or by number from 0 [default: the model's own materials]
    #[arg(long, value_name = "NAME|INDEX")]
    pub variant: Option<String>,

    /// Change a bound on what a file may ask for, e.g. triangles=10M; may be repeated
    ///
    /// Suffixes k, M, G are powers of 1000, Ki, Mi, Gi powers of 1024. Exceeding a limit is exit code 3.
    #[arg(long = "limit", value_name = "NAME=VALUE", value_parser = values::limit)]
    pub limits: Vec<(String, u64)>,
}

/// Options of what is printed.
#[derive(Debug, Args)]
#[command(next_help_heading = "Report")]
pub struct ReportArgs {
    /// Print hash, times and counts as JSON to standard output
    #[arg(long)]
    pub json: bool,

    /// Print no warnings and no progress
    #[arg(short, long)]
    pub quiet: bool,
}

/// `overcoat info`
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  overcoat info car.glb\n  overcoat info car.glb --json")]
pub struct InfoArgs {
    /// Model file (.glb, .gltf, .obj, .stl, .ply), or - for standard input
    #[arg(value_name = "IN")]
    pub input: PathBuf,

    #[command(flatten)]
    #[allow(missing_docs)]
    pub input_options: InputArgs,

    /// Worker threads; 0 stands for one per processor
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = clap::value_parser!(u16).range(0..=1024))]
    pub threads: u16,

    #[command(flatten)]
    #[allow(missing_docs)]
    pub report: ReportArgs,
}

/// `overcoat sheet`
#[derive(Debug, Args)]
#[command(after_help = "Example:
  overcoat sheet models/*.glb -o sheet.png --size 256 --columns 6

A model that fails gets a cell with the reason, and the exit code is 1.")]
pub struct SheetArgs {
    /// Model files
    #[arg(value_name = "IN", required = true)]
    pub inputs: Vec<PathBuf>,

    /// Contact sheet to write (.png), or - for standard output
    #[arg(short, long, value_name = "OUT")]
    pub output: PathBuf,

    /// Cells in a row [default: as many as make the sheet about square]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub columns: Option<u32>,

    #[command(flatten)]
    #[allow(missing_docs)]
    pub camera: CameraArgs,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub light: LightArgs,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub picture: PictureArgs,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub display: DisplayArgs,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub machine: MachineArgs,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub input_options: InputArgs,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub report: ReportArgs,
}

/// `overcoat compare-models`
#[derive(Debug, Args)]
#[command(after_help = "Example:
  overcoat compare-models car.glb -o models.png --against gltf --models urp17,hdrp-lit,stacklit,filament,three,gltf

Below each picture is its difference to that of --against, four times as strong: black where both agree.")]
pub struct CompareModelsArgs {
    /// Model file (.glb, .gltf, .obj, .stl, .ply), or - for standard input
    #[arg(value_name = "IN", required_unless_present = "scene")]
    pub input: Option<PathBuf>,

    /// Labelled sheet to write (.png), or - for standard output
    #[arg(short, long, value_name = "OUT")]
    pub output: PathBuf,

    /// Shading models to show, comma-separated [default: all]
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = values::shading)]
    pub models: Vec<ShadingModel>,

    /// Shading model that the others are compared with
    #[arg(long, value_name = "MODEL", value_parser = values::shading, default_value = "gltf")]
    pub against: ShadingModel,

    /// Cells in a row [default: as many as make the sheet about square]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub columns: Option<u32>,

    #[command(flatten)]
    #[allow(missing_docs)]
    pub scene: SceneArgs,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub camera: CameraArgs,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub light: LightArgs,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub picture: PictureArgs,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub display: DisplayArgs,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub machine: MachineArgs,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub input_options: InputArgs,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub report: ReportArgs,
}

/// `overcoat bench`
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  overcoat bench car.glb --frames 100 --size 1920x1080 --samples 4
  overcoat bench a.glb b.glb c.glb --rounds 5 --png

One model: loading, the environment and one frame come first and are not counted. Several models, or --rounds or
--png: each frame loads the next model, renders it and lets it go; the environment, the materials of --material and the
renderer stay, and one pass over all models comes first and is not counted. Times are wall-clock milliseconds;
processor time is user and system time of the whole process over the counted frames.")]
pub struct BenchArgs {
    /// Model files (.glb, .gltf, .obj, .stl, .ply), or - for standard input; of several, a new one each frame
    #[arg(value_name = "IN", required_unless_present = "scene")]
    pub inputs: Vec<PathBuf>,

    /// Frames that are counted, evenly spaced over one turn of the camera
    #[arg(long, value_name = "N", default_value_t = 60, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub frames: u32,

    /// A new model each frame: passes over all models that are counted [default: 1]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1_000_000), conflicts_with = "frames")]
    pub rounds: Option<u32>,

    /// A new model each frame: also encode each picture as a PNG in memory
    #[arg(long, conflicts_with = "frames")]
    pub png: bool,

    #[command(flatten)]
    #[allow(missing_docs)]
    pub scene: SceneArgs,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub camera: CameraArgs,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub light: LightArgs,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub picture: PictureArgs,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub display: DisplayArgs,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub machine: MachineArgs,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub input_options: InputArgs,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub report: ReportArgs,
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

    /// Contact sheet to write (.png), or - for standard output
    #[arg(short, long, value_name = "OUT")]
    pub output: Option<PathBuf>,

    /// List the keys of material files instead, with what they take and their defaults
    #[arg(long, conflicts_with = "output")]
    pub keys: bool,

    /// Width and height of a cell in pixels [default: 256]
    #[arg(long, value_name = "WxH", value_parser = values::size, requires = "output")]
    pub size: Option<[u64; 2]>,

    /// Cells in a row [default: as many as make the sheet about square]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1000), requires = "output")]
    pub columns: Option<u32>,

    #[command(flatten)]
    #[allow(missing_docs)]
    pub light: LightArgs,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub machine: MachineArgs,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub report: ReportArgs,
}

impl InputArgs {
    /// The limits, with what the options change.
    #[must_use]
    pub fn limits(&self) -> Limits {
        values::limits(&self.limits)
    }
}

impl BenchArgs {
    /// Lays the options of the picture over a scene file.
    pub fn apply(&self, scene: &mut SceneFile) {
        self.camera.apply(scene);
        self.light.apply(scene);
        self.picture.apply(scene);
        self.display.apply(scene);
    }
}

impl CameraArgs {
    /// Lays the options over a scene file's camera. Choosing a place for the camera in one way drops the other ways.
    pub fn apply(&self, scene: &mut SceneFile) {
        let camera = &mut scene.camera;
        if self.eye.is_some() || self.view.is_some() || self.camera.is_some() {
            camera.eye = self.eye;
            camera.view = self.view;
            camera.from_model.clone_from(&self.camera);
            (camera.target, camera.up, camera.near) = (None, None, None);
        }
        override_with(&mut camera.target, self.target);
        override_with(&mut camera.up, self.up);
        if self.fov.is_some() {
            camera.fov_y_degrees = self.fov;
            camera.orthographic_height = None;
        }
        override_with(&mut camera.orthographic_height, self.ortho);
    }
}

impl LightArgs {
    /// Lays the options over a scene file.
    pub fn apply(&self, scene: &mut SceneFile) {
        override_with(&mut scene.env, self.env.as_deref().map(EnvironmentChoice::new));
        override_with(&mut scene.env_rotation_degrees, self.env_rotation);
        override_with(&mut scene.env_intensity, self.env_intensity);
        override_with(&mut scene.lights, self.no_lights.then_some(false));
    }
}

impl PictureArgs {
    /// Lays the options over a scene file.
    pub fn apply(&self, scene: &mut SceneFile) {
        override_with(&mut scene.size, self.size);
        override_with(&mut scene.samples, self.samples);
        override_with(&mut scene.shading, self.shading);
        scene.more_materials.extend_from_slice(&self.materials);
        override_with(&mut scene.anisotropy, self.anisotropy);
        override_with(&mut scene.area_lights, self.area_lights);
        override_with(&mut scene.merge_angle_degrees, self.merge_angle);
        override_with(&mut scene.line_width, self.line_width);
        override_with(&mut scene.point_size, self.point_size);
    }
}

impl DisplayArgs {
    /// Lays the options over a scene file.
    pub fn apply(&self, scene: &mut SceneFile) {
        override_with(&mut scene.background, self.background);
        override_with(&mut scene.tone_curve, self.tone_map);
        override_with(&mut scene.exposure, self.exposure);
    }
}

/// Replaces a value by one that was given.
pub(super) fn override_with<T>(value: &mut Option<T>, given: Option<T>) {
    if given.is_some() {
        *value = given;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_definition_is_consistent() {
        Cli::command().debug_assert();
    }

    #[test]
    fn options_override_the_scene_file() {
        let Command::Render(args) = Cli::parse_from([
            "overcoat",
            "render",
            "x.glb",
            "-o",
            "x.png",
            "--size",
            "64",
            "--view",
            "front",
            "--env",
            "none",
            "--exposure",
            "-1.5",
            "--tone-map",
            "linear",
        ])
        .command
        else {
            panic!("not a render")
        };
        let mut scene = SceneFile::from_json(
            r#"{"size": [1, 2], "camera": {"eye": [1, 2, 3], "fovYDeg": 20, "near": 1}, "samples": 4}"#,
        )
        .unwrap();
        args.camera.apply(&mut scene);
        args.light.apply(&mut scene);
        args.picture.apply(&mut scene);
        args.display.apply(&mut scene);
        assert_eq!(scene.size, Some([64, 64]));
        assert_eq!(scene.samples, Some(4));
        assert_eq!((scene.camera.eye, scene.camera.near), (None, None));
        assert_eq!(scene.camera.fov_y_degrees, Some(20.0));
        assert_eq!(scene.env, Some(EnvironmentChoice::None));
        assert_eq!(scene.exposure, Some(-1.5));
        assert_eq!(scene.tone_curve, Some(ToneCurve::None));
    }
}
