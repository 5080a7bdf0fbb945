//! Groups of options that commands have in common, each defined once.

use crate::environment_cache::keep_environments;
use crate::picture_format::PictureFormat;
use crate::report::Reporter;
use crate::value_parsers;
use clap::Args;
use overcoat_core::color::ToneCurve;
use overcoat_core::jobs::MAX_THREADS;
use overcoat_core::limits::Limits;
use overcoat_core::math::lanes::SimdLevel;
use overcoat_description::{
    BackgroundChoice, Description, EnvironmentChoice, ExposureChoice, Machine, MaterialChoice, ViewDirection,
};
use overcoat_image::output::OutputFormat;
use overcoat_render::{Ground, Quality, Renderer};
use overcoat_scene::Axis;
use overcoat_scene::{AreaLightMethod, ShadingModel};
use std::ffi::OsString;
use std::path::PathBuf;

/// What `--shading` is.
const SHADING: &str = "Formulas that shade every surface [default: what each material names, else standard]";

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
    /// Model file (.glb, .gltf, .obj, .stl, .ply, .3mf; also in gzip or Zstandard), a pipe, or - for standard input
    #[arg(value_name = "IN", required_unless_present = "scene", help_heading = None::<&str>)]
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
    pub camera: CameraArgs,
    #[command(flatten)]
    pub light: LightArgs,
    #[command(flatten)]
    pub picture: PictureArgs,
    #[command(flatten)]
    pub display: DisplayArgs,
    #[command(flatten)]
    pub machine: MachineArgs,
    #[command(flatten)]
    pub input: InputArgs,
    #[command(flatten)]
    pub report: ReportArgs,
}

/// Which pose of the model is drawn.
#[derive(Debug, Args)]
#[command(next_help_heading = "Animation")]
pub struct AnimationArgs {
    /// Animation of the model file (glTF), by name or by number from 0 [default: none, the pose of the file]
    #[arg(long, value_name = "NAME|INDEX")]
    pub animation: Option<String>,

    /// Seconds in the animation; beyond its end it stays as it is there [default: 0]
    #[arg(long, value_name = "SECONDS", value_parser = value_parsers::seconds, allow_negative_numbers = true)]
    pub time: Option<f64>,

    /// Begin the animation again after its end
    #[arg(long = "loop")]
    pub repeat: bool,
}

/// Camera options.
#[derive(Debug, Default, Args)]
#[command(next_help_heading = "Camera")]
pub struct CameraArgs {
    /// Direction from which the model is framed: three-quarter, front, back, left, right, top, bottom, or x,y,z from
    /// the model towards the camera [default: three-quarter, or another one from the front and above that shows twice as much]
    #[arg(long, value_name = "VIEW", value_parser = value_parsers::view, allow_hyphen_values = true,
          conflicts_with_all = ["eye", "camera"])]
    pub view: Option<ViewDirection>,

    /// Camera of the model file, by name or by number from 0
    #[arg(long, value_name = "NAME|INDEX", conflicts_with = "eye")]
    pub camera: Option<String>,

    /// Position of the camera in metres, in the scene: the upright model, +Y is up
    #[arg(long, value_name = "X,Y,Z", value_parser = value_parsers::position, allow_hyphen_values = true)]
    pub eye: Option<[f64; 3]>,

    /// What the camera looks at [default: the middle of the model]
    #[arg(long, value_name = "X,Y,Z", value_parser = value_parsers::position,
          allow_hyphen_values = true, requires = "eye")]
    pub target: Option<[f64; 3]>,

    /// Which way is up in the picture; the model stays as it is (--up turns it) [default: 0,1,0]
    #[arg(long, value_name = "X,Y,Z", value_parser = value_parsers::direction, allow_hyphen_values = true,
          conflicts_with = "camera")]
    pub camera_up: Option<[f32; 3]>,

    /// Nothing nearer to the camera than this many metres is drawn [default: by the distance]
    #[arg(long, value_name = "DISTANCE", value_parser = value_parsers::not_negative, allow_negative_numbers = true,
          conflicts_with = "camera")]
    pub near: Option<f32>,

    /// Vertical field of view in degrees, 0.1 to 179 [default: 30]
    #[arg(long, value_name = "DEGREES", value_parser = value_parsers::within::<f32>(0.1, 179.0),
          allow_negative_numbers = true, conflicts_with_all = ["camera", "ortho"])]
    pub fov: Option<f32>,

    /// Parallel projection, HEIGHT metres from the top of the picture to its bottom [default: fits the model]
    #[arg(long, value_name = "HEIGHT", value_parser = value_parsers::not_negative, num_args = 0..=1, require_equals = true,
          default_missing_value = "0", conflicts_with = "camera")]
    pub ortho: Option<f32>,
}

/// Light options.
#[derive(Debug, Default, Args)]
#[command(next_help_heading = "Light")]
pub struct LightArgs {
    /// Equirectangular picture (.hdr, .exr) that lights the scene, studio for the built-in one, or none
    /// [default: studio]
    #[arg(long, value_name = "FILE|studio|none")]
    pub env: Option<OsString>,

    /// Turn the environment about the vertical axis, counter-clockwise seen from above [default: 0]
    #[arg(long, value_name = "DEGREES", value_parser = value_parsers::finite, allow_negative_numbers = true)]
    pub env_rotation: Option<f32>,

    /// Multiply the light of the environment [default: 1]
    #[arg(long, value_name = "FACTOR", value_parser = value_parsers::not_negative, allow_negative_numbers = true)]
    pub env_intensity: Option<f32>,

    /// Leave out the lights of the model file
    #[arg(long)]
    pub no_lights: bool,
}

/// Options that change the linear picture.
#[derive(Debug, Default, Args)]
#[command(next_help_heading = "Picture")]
pub struct PictureArgs {
    /// Width and height in pixels; one number makes a square [default: 512x512]
    #[arg(long, value_name = "WxH", value_parser = value_parsers::size, allow_hyphen_values = true)]
    pub size: Option<[u64; 2]>,

    /// Samples a pixel for smooth edges: 1, 4, 8 or 16 [default: 8]
    #[arg(long, value_name = "N", value_parser = value_parsers::samples, allow_negative_numbers = true)]
    pub samples: Option<u32>,

    /// What the picture is worth: draft (no light is blocked), fast (shadows of the environment), good (and light from other
    /// surfaces by rays) or best [default: fast; of bench draft]
    ///
    /// Sets --maps, --map-size, --rays and --shading-rate: draft 0, 256, 0, 1; fast 64, 128, 0, 1; good 64, 256, 4, 4; best
    /// 128, 512, 16, 4.
    #[arg(long, value_name = "TIER", value_parser = value_parsers::quality)]
    pub quality: Option<Quality>,

    /// Directions that the environment's light comes from, each with a depth map of the scene, 0 to 256 [default: by the
    /// tier]
    #[arg(long, value_name = "N", value_parser = value_parsers::within::<u32>(0, 256), allow_negative_numbers = true)]
    pub maps: Option<u32>,

    /// Texels along a side of a depth map, 32 to 2048 [default: by the tier]
    #[arg(long, value_name = "N", value_parser = value_parsers::within::<u32>(32, 2048), allow_negative_numbers = true)]
    pub map_size: Option<u32>,

    /// Rays that each lobe sends for the light of other surfaces, 0 to 256 [default: by the tier]
    #[arg(long, value_name = "N", value_parser = value_parsers::within::<u32>(0, 256), allow_negative_numbers = true)]
    pub rays: Option<u32>,

    /// Shadings a pixel where one would show (sharp highlights on curved surfaces, alpha masks, shining normal maps,
    /// textures without mip levels): 1, 4, 8, 9 or 16, and at least as many samples [default: 1]
    #[arg(long, value_name = "N", value_parser = value_parsers::shading_rate, allow_negative_numbers = true)]
    pub shading_rate: Option<u32>,

    /// Shade every surface as often as --shading-rate says
    #[arg(long)]
    pub shade_everywhere: bool,

    /// What is seen of a floor under the model: none, shadow (that of the model, which darkens what is behind it), #rrggbb or a
    /// colour name (a matt floor that fades) [default: shadow; of bench and without maps none]
    ///
    /// The floor lies at the lowest point of the model and is seen from above. The environment and all lights shine on it past the
    /// model, by the depth maps of --maps, or by those of --quality fast if there are none. It fades before
    /// the border of the picture, where automatic cameras leave some room for it. Unless one is asked for, there is none where
    /// nothing blocks light (in --quality draft, with --maps 0) and in bench.
    #[arg(long, value_name = "SHADOW|COLOR", value_parser = value_parsers::ground)]
    pub ground: Option<Ground>,

    /// How much of the model the floor mirrors, 0 to 1 [default: 0]
    ///
    /// The mirrored model is a second picture, with everything that the first has, and costs as much. It fades with the floor.
    #[arg(long, value_name = "PART", value_parser = value_parsers::within::<f32>(0.0, 1.0),
          allow_negative_numbers = true)]
    pub ground_reflection: Option<f32>,

    /// Formulas that shade every surface [default: what each material names, else standard]
    #[arg(long, value_name = "MODEL", value_parser = value_parsers::shading, long_help = models(SHADING))]
    pub shading: Option<ShadingModel>,

    /// Make the model of a material: a .toml file or the name of a built-in one, for every mesh or for the
    /// materials of one name in the model; may be repeated, later ones lie over earlier ones
    #[arg(long = "material", value_name = "[NAME=]FILE|BUILT-IN", value_parser = value_parsers::material_parser())]
    pub materials: Vec<MaterialChoice>,

    /// How reflections of rectangles and tubes are integrated: ltc, as engines do, or facets, slower and within 1 percent
    /// [default: ltc]
    #[arg(long, value_name = "METHOD", value_parser = value_parsers::area_lights)]
    pub area_lights: Option<AreaLightMethod>,

    /// Largest anisotropy of texture filtering, 1 to 16 [default: 8]
    #[arg(long, value_name = "N", value_parser = value_parsers::within::<u32>(1, 16), allow_negative_numbers = true)]
    pub anisotropy: Option<u32>,

    /// Let roughness grow where normals vary within a pixel, against flickering highlights: Filament's way in its models,
    /// Tokuyoshi's and Kaplanyan's of 2019 in others, and for what normal maps lose as they shrink; those of three.js always
    /// have their own
    #[arg(long)]
    pub specular_antialiasing: bool,

    /// Shade triangles smaller than two pixels as one where their normals differ by less than this many degrees, 0 to 45:
    /// faster on dense meshes, with less smoothing of sharp reflections [default: 0]
    #[arg(long, value_name = "DEGREES", value_parser = value_parsers::within::<f32>(0.0, 45.0),
          allow_negative_numbers = true)]
    pub merge_angle: Option<f32>,

    /// Width of lines in pixels, 0.1 to 64 [default: 1.5]
    #[arg(long, value_name = "PIXELS", value_parser = value_parsers::within::<f32>(0.1, 64.0),
          allow_negative_numbers = true)]
    pub line_width: Option<f32>,

    /// Diameter of points in pixels, 0.1 to 64 [default: by the distances between them, at least about a pixel; 3 if they are
    /// far apart]
    #[arg(long, value_name = "PIXELS", value_parser = value_parsers::within::<f32>(0.1, 64.0),
          allow_negative_numbers = true)]
    pub point_size: Option<f32>,
}

/// Options of the way from linear light to 8 bits.
#[derive(Debug, Default, Args)]
#[command(next_help_heading = "Display")]
pub struct DisplayArgs {
    /// What is behind the model: transparent, env, #rrggbb (the # may be left out) or a colour name
    /// [default: transparent, of .jpg white]
    #[arg(long, value_name = "COLOR", value_parser = value_parsers::background)]
    pub background: Option<BackgroundChoice>,

    /// Tone curve of 8-bit pictures: none (or linear), neutral, aces, agx [default: neutral]
    #[arg(long, value_name = "CURVE", value_parser = value_parsers::tone_curve)]
    pub tone_map: Option<ToneCurve>,

    /// Exposure of 8-bit pictures in stops, -64 to 64: +1 doubles the light; auto meters the object [default: 0]
    ///
    /// auto makes one tenth of the object brighter than 0.7 (linear), by -24 to 24 stops: its 90th percentile of luminance is
    /// what is metered, of the first frame in moving pictures.
    #[arg(long, value_name = "STOPS|auto", value_parser = value_parsers::exposure, allow_negative_numbers = true)]
    pub exposure: Option<ExposureChoice>,
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
    /// Format of a model from standard input: gltf, glb, obj, stl, ply or 3mf [default: by its content]
    #[arg(long, value_name = "FORMAT")]
    pub format: Option<String>,

    /// Material variant of the model (glTF), by name or by number from 0 [default: the model's own materials]
    #[arg(long, value_name = "NAME|INDEX")]
    pub variant: Option<String>,

    /// Which axis of the model file is up: +x, -x, +y, -y, +z or -z; the model is turned upright, with its lights and
    /// cameras [default: +y for glTF, OBJ and PLY, +z for STL and 3MF]
    ///
    /// Its front is then +Z of the file, as in glTF; -Y where +z is up, as in slicers and Blender, +Y where -z is.
    #[arg(long, value_name = "AXIS", value_parser = value_parsers::axis, allow_hyphen_values = true)]
    pub up: Option<Axis>,

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
        self.camera.apply(scene);
        self.light.apply(scene);
        self.picture.apply(scene);
        self.display.apply(scene);
        override_with(&mut scene.up, self.input.up);
    }
}

impl AnimationArgs {
    /// Lays the options over a scene file. Another animation begins at its own time.
    pub fn apply(&self, scene: &mut Description) {
        if self.animation.is_some() {
            scene.animation.clone_from(&self.animation);
            scene.time = None;
        }
        override_with(&mut scene.time, self.time);
        override_with(&mut scene.repeat, self.repeat.then_some(true));
    }
}

impl CameraArgs {
    /// Lays the options over a scene file's camera. Choosing a place for the camera in one way drops the other ways.
    pub fn apply(&self, scene: &mut Description) {
        let camera = &mut scene.camera;
        if self.eye.is_some() || self.view.is_some() || self.camera.is_some() {
            camera.eye = self.eye;
            camera.view = self.view;
            camera.from_model.clone_from(&self.camera);
            (camera.target, camera.up, camera.near) = (None, None, None);
        }
        override_with(&mut camera.target, self.target);
        override_with(&mut camera.up, self.camera_up);
        override_with(&mut camera.near, self.near);
        if self.fov.is_some() {
            camera.fov_y_degrees = self.fov;
            camera.orthographic_height = None;
        }
        override_with(&mut camera.orthographic_height, self.ortho);
    }
}

impl LightArgs {
    /// Lays the options over a scene file.
    pub fn apply(&self, scene: &mut Description) {
        override_with(&mut scene.env, self.env.as_deref().map(EnvironmentChoice::new));
        override_with(&mut scene.env_rotation_degrees, self.env_rotation);
        override_with(&mut scene.env_intensity, self.env_intensity);
        override_with(&mut scene.lights, self.no_lights.then_some(false));
    }
}

impl PictureArgs {
    /// Lays the options over a scene file.
    pub fn apply(&self, scene: &mut Description) {
        override_with(&mut scene.size, self.size);
        override_with(&mut scene.samples, self.samples);
        override_with(&mut scene.quality, self.quality);
        override_with(&mut scene.maps, self.maps);
        override_with(&mut scene.map_size, self.map_size);
        override_with(&mut scene.rays, self.rays);
        override_with(&mut scene.shading_rate, self.shading_rate);
        override_with(&mut scene.shade_everywhere, self.shade_everywhere.then_some(true));
        override_with(&mut scene.ground, self.ground);
        override_with(&mut scene.ground_reflection, self.ground_reflection);
        override_with(&mut scene.shading, self.shading);
        scene.more_materials.extend_from_slice(&self.materials);
        override_with(&mut scene.anisotropy, self.anisotropy);
        let antialiasing = self.specular_antialiasing.then_some(true);
        override_with(&mut scene.specular_antialiasing, antialiasing);
        override_with(&mut scene.area_lights, self.area_lights);
        override_with(&mut scene.merge_angle_degrees, self.merge_angle);
        override_with(&mut scene.line_width, self.line_width);
        override_with(&mut scene.point_size, self.point_size);
    }
}

impl DisplayArgs {
    /// Lays the options over a scene file.
    pub fn apply(&self, scene: &mut Description) {
        override_with(&mut scene.background, self.background);
        override_with(&mut scene.tone_curve, self.tone_map);
        override_with(&mut scene.exposure, self.exposure);
    }
}

/// Replaces a value by one that was given.
fn override_with<T>(value: &mut Option<T>, given: Option<T>) {
    if given.is_some() {
        *value = given;
    }
}
