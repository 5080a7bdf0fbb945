//! Options of poses and of moving pictures.

use super::args::{
    CameraArgs, DisplayArgs, InputArgs, LightArgs, MachineArgs, PictureArgs, ReportArgs, SceneArgs,
    override_with,
};
use super::scene_file::SceneFile;
use super::values;
use clap::Args;
use std::path::PathBuf;

/// Which pose of the model is drawn.
#[derive(Debug, Args)]
#[command(next_help_heading = "Animation")]
pub struct AnimationArgs {
    /// Animation of the model file (glTF), by name or by number from 0 [default: none, the pose of the file]
    #[arg(long, value_name = "NAME|INDEX")]
    pub animation: Option<String>,

    /// Seconds in the animation; beyond its end it stays as it is there [default: 0]
    #[arg(long, value_name = "SECONDS", value_parser = values::seconds)]
    pub time: Option<f64>,

    /// Begin the animation again after its end
    #[arg(long = "loop")]
    pub repeat: bool,
}

/// `overcoat turntable`
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  overcoat turntable car.glb -o car.png
  overcoat turntable car.glb -o car.webp --seconds 4 --fps 30 --background white
  overcoat turntable car.glb -o car-####.png --frames 36 --turn camera

The model is loaded once; the camera's distance fits it from all sides. The first frame follows the last.")]
pub struct TurntableArgs {
    /// Model file (.glb, .gltf, .obj, .stl, .ply), or - for standard input
    #[arg(value_name = "IN", required_unless_present = "scene")]
    pub input: Option<PathBuf>,

    /// What to write: .png or .apng (animated PNG), .webp (lossless), a .png with # in its name for a numbered picture
    /// each frame (out-####.png), or - for an animated PNG on standard output
    #[arg(short, long, value_name = "OUT")]
    pub output: PathBuf,

    /// Frames of the turn [default: as many as --seconds and --fps make]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..), conflicts_with = "seconds")]
    pub frames: Option<u32>,

    /// Seconds of the turn [default: 3]
    #[arg(long, value_name = "SECONDS", value_parser = values::seconds)]
    pub seconds: Option<f64>,

    /// Frames a second
    #[arg(long, value_name = "N", value_parser = values::frame_rate, default_value = "24")]
    pub fps: f64,

    /// What turns: model, under light that stays, or camera, around a model that stays
    #[arg(long, value_name = "WHAT", default_value = "model")]
    pub turn: Turn,

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

/// What turns around the vertical axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Turn {
    /// The model with its lights, counter-clockwise seen from above.
    Model,
    /// The camera, counter-clockwise seen from above.
    Camera,
}

/// `overcoat animate`
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  overcoat animate fox.glb -o fox.png --animation Walk
  overcoat animate fox.glb -o fox.webp --animation Run --fps 30 --background white
  overcoat animate fox.glb -o fox-####.png --from 0.2 --to 0.5

The file is read once; a camera that is not given fits all frames and stays. overcoat info lists the animations.")]
pub struct AnimateArgs {
    /// Model file (.glb, .gltf, .obj, .stl, .ply), or - for standard input
    #[arg(value_name = "IN", required_unless_present = "scene")]
    pub input: Option<PathBuf>,

    /// What to write: .png or .apng (animated PNG), .webp (lossless), a .png with # in its name for a numbered picture
    /// each frame (out-####.png), or - for an animated PNG on standard output
    #[arg(short, long, value_name = "OUT")]
    pub output: PathBuf,

    /// Animation of the model file, by name or by number from 0 [default: that of the scene file, else 0]
    #[arg(long, value_name = "NAME|INDEX")]
    pub animation: Option<String>,

    /// Frames a second
    #[arg(long, value_name = "N", value_parser = values::frame_rate, default_value = "24")]
    pub fps: f64,

    /// Second of the first frame
    #[arg(long, value_name = "SECONDS", value_parser = values::seconds, default_value = "0")]
    pub from: f64,

    /// Second before which the last frame is [default: the end of the animation]
    #[arg(long, value_name = "SECONDS", value_parser = values::seconds)]
    pub to: Option<f64>,

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

impl AnimationArgs {
    /// Lays the options over a scene file. Another animation begins at its own time.
    pub fn apply(&self, scene: &mut SceneFile) {
        if self.animation.is_some() {
            scene.animation.clone_from(&self.animation);
            scene.time = None;
        }
        override_with(&mut scene.time, self.time);
        override_with(&mut scene.repeat, self.repeat.then_some(true));
    }
}
