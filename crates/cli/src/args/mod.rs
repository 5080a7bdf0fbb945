//! The command line: every option, its help and its default.

// Groups that are flattened into others cannot have a comment; a test looks for options without one.
#[allow(missing_docs)]
mod commands;
mod formats;
#[allow(missing_docs)]
mod groups;
#[allow(missing_docs)]
mod install;
mod options;
#[allow(missing_docs)]
mod thumbnail;

pub use commands::{
    AnimateArgs, BenchArgs, CellArgs, CompareModelsArgs, DiagnoseArgs, DiffArgs, FormatsArgs, InfoArgs,
    MaterialsArgs, MovieArgs, RenderArgs, SheetArgs, Turn, TurntableArgs,
};
pub use groups::{
    DrawArgs, EncodingArgs, InputArgs, LimitArgs, MachineArgs, ModelArgs, PictureEncodingArgs, ReportArgs,
    ThreadArgs,
};
pub use install::{CompletionsArgs, ManArgs};
pub use options::Options;
pub use thumbnail::ThumbnailArgs;

use super::attempt::AttemptArgs;
use super::conformance::ConformanceArgs;
use super::error_format::ErrorFormat;
use super::golden::GoldenArgs;
use super::guide_command::GuideArgs;
use super::hand_over::ServiceArgs;
use super::lab::LabArgs;
use super::translate::TranslateArgs;
use clap::{Parser, Subcommand};
use std::path::PathBuf;

/// Renders 3D models to pictures on machines that have only a processor; the same bytes on every machine.
#[derive(Debug, Parser)]
#[command(
    name = "overcoat",
    version,
    max_term_width = 100,
    arg_required_else_help = true,
    after_help = "Example:
  overcoat car.glb
  overcoat render --help

Exit codes: 0 done, 1 failed, 2 wrong usage, 3 limit exceeded, 4 pictures differ, 5 findings"
)]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,

    /// Before any file is read, give up every right that the work does not need: other files, network, programs (Linux)
    ///
    /// Landlock leaves the folders of the inputs to read and the folder of the output to write; seccomp leaves memory,
    /// threads and open files. An error on systems without them (Linux 5.13 on x86-64 or 64-bit ARM has them).
    #[arg(long, global = true, help_heading = groups::MACHINE, display_order = 999)]
    pub sandbox: bool,

    /// File that registers converters, programs that make GLB of other formats (TOML), or none [default: those of the user and of
    /// the system]
    ///
    /// Without it, the variable OVERCOAT_CONVERTERS names the file; without that, overcoat/converters.toml of the user's
    /// configuration counts, then /etc/overcoat/converters.toml, then files of overcoat/converters.d in /etc, /usr/local/share and /usr/share.
    /// A format that is read without one is never converted.
    #[arg(long, global = true, value_name = "FILE", help_heading = "Input", display_order = 999)]
    pub converters: Option<PathBuf>,

    /// Run converters where there is no sandbox for them, too: they can do all that the user can then
    #[arg(long, global = true, help_heading = "Input", display_order = 999)]
    pub allow_unsandboxed_converters: bool,

    /// Form of errors and warnings on standard error: human, or json, an object a line
    #[arg(
        long,
        global = true,
        value_name = "FORMAT",
        value_enum,
        default_value = "human",
        hide_possible_values = true,
        help_heading = "Report",
        display_order = 999
    )]
    pub error_format: ErrorFormat,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Render one model to a picture
    Render(Box<RenderArgs>),
    /// Render one model to a small square PNG, confined, within small limits
    Thumbnail(ThumbnailArgs),
    /// Turn a model once around: a GIF, animated PNG or WebP, or numbered pictures
    Turntable(Box<TurntableArgs>),
    /// Play an animation of a model: a GIF, animated PNG or WebP, or numbered pictures
    Animate(Box<AnimateArgs>),
    /// Print what a model file contains
    Info(InfoArgs),
    /// Tell what is wrong with a picture of a model, and which option mends it
    Diagnose(Box<DiagnoseArgs>),
    /// Render many models to one labelled contact sheet
    Sheet(Box<SheetArgs>),
    /// Measure frames of one model with an orbiting camera, or of a new model each
    Bench(Box<BenchArgs>),
    /// Render one model with every engine's shading model, side by side
    CompareModels(Box<CompareModelsArgs>),
    /// Render two models from one camera, side by side with their difference
    Diff(Box<DiffArgs>),
    /// List the built-in materials, print one, or show all on a contact sheet
    Materials(Box<MaterialsArgs>),
    /// Measure how far the clear coats of engines are from physics
    Lab(Box<LabArgs>),
    /// Find parameters with which another engine draws a material alike
    Translate(Box<TranslateArgs>),
    /// Make a folder of scenes, truth and tolerances that tests renderers of clear coats
    Conformance(Box<ConformanceArgs>),
    /// Print one page for programs that call this one, or the vocabulary of its reports
    Guide(GuideArgs),
    /// List the formats of files that are read and written
    Formats(FormatsArgs),
    /// Compare pictures of any renderer with expected ones; report, accept
    Golden(Box<GoldenArgs>),
    /// Print a script that completes commands and options in a shell
    Completions(CompletionsArgs),
    /// Print the manual page, or write those of all commands into a folder
    Man(ManArgs),
    /// Render the models of a folder, a manifest or an object store
    #[command(disable_help_flag = true)]
    Batch(ServiceArgs),
    /// Render models over HTTP
    #[command(disable_help_flag = true)]
    Serve(ServiceArgs),
    /// Serve tools of the Model Context Protocol over standard streams
    #[command(disable_help_flag = true)]
    Mcp(ServiceArgs),
    /// Try what a program that was taken over would try, to see that --sandbox holds on this machine
    #[command(hide = true)]
    Attempt(AttemptArgs),
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::value_parsers::LIMIT_NAMES;
    use clap::CommandFactory;
    use overcoat_core::color::ToneCurve;
    use overcoat_core::frame::Aov;
    use overcoat_description::{Description, EnvironmentChoice, ExposureChoice};
    use overcoat_load::Format;
    use overcoat_load::NamedEnvironment;
    use overcoat_scene::ShadingModel;

    #[test]
    fn the_definition_is_consistent() {
        Cli::command().debug_assert();
    }

    #[test]
    fn every_option_has_help() {
        fn check(command: &clap::Command) {
            for argument in command.get_arguments() {
                assert!(argument.get_help().is_some(), "{} of {}", argument.get_id(), command.get_name());
            }
            command.get_subcommands().for_each(check);
        }
        check(&Cli::command());
    }

    /// What a value is parsed to is what its option takes: a difference is found out at run time only.
    #[test]
    fn every_option_can_be_read() {
        let picture = "--fov 1 --env-rotation -1 --env-intensity 1 --size 1 --samples 1 --shading-rate 1 --shade-everywhere \
                       --specular-antialiasing --anisotropy 1 --merge-angle 1 \
                       --line-width 1 --point-size 1 --exposure -1 --threads 1 --tile 16 --cache x --limit nodes=1";
        for line in [
            &format!("render x -o y --time 1 --loop --camera-up 0,1,0 --up -z {picture} --aov uv,depth"),
            "render x -o y --eye 0,0,1 --target 0,0,0 --near 0.1 --exposure auto --ortho=1 --simd auto --background red --tone-map aces",
            "render x -o y --view top --env a.hdr --shading velvet --material velvet --area-lights facets",
            "turntable x -o y --frames 1 --fps 1 --turn camera",
            "turntable x -o y --seconds 1",
            "animate x -o y --from 1 --to 2 --fps 1 --animation 0",
            "info x --threads 1 --limit nodes=1 --variant 1 --format glb --up +z",
            "sheet x -o y --columns 1 --scene z",
            "compare-models x -o y --columns 1 --models gltf,velvet --against three",
            "diff x y -o z --exit-code --columns 1",
            "bench x --frames 1",
            "bench x --rounds 1 --png",
            "materials -o y --size 1 --columns 1",
            "formats --json",
            "guide --keys",
            "formats --error-format json",
            "diagnose x --strict --json --eye 0,0,1 --animation 0",
            "translate candy-red --to three --from stacklit -o x.toml --picture y.png --force --json --quiet",
            "lab -o x.svg --over light --from -1 --to 1 --steps 2 --by coat --models three --samples 256 --view 1 --light -1",
            "lab --coat 1 --coat-roughness 1 --coat-ior 1 --thickness 1 --extinction 1,1,1 --base-roughness 1 --metal",
            "lab --summary --random 3",
            "lab --measured x.bsdf --material candy-red --over light --view 1 --steps 2 --json",
            "translate x.binary --to three -o x.toml --picture y.png --force --json --quiet",
            "conformance x --size 32 --samples 32 --seed 1 --scenes furnace,matt-lamp --models three --threads 1 --json --quiet",
            "lab --summary --all --color 1,1,1 --specular 1 --json --quiet --threads 1",
            "render x -o - --output-format webp",
            "sheet x -o y.jpg --jpeg-quality 80",
            "turntable x -o y-##.jpg --jpeg-quality 1",
            "golden check a b --json",
            "golden accept a b --all --json",
            "golden check a b --pixels-per-degree 1 --background #ffffff --threads 1 --limit nodes=1 --strict",
            "golden accept a b --all",
            "golden report a b -o y",
            "thumbnail x y --size 1 --memory 64Mi --no-sandbox --threads 1 --limit nodes=1 --json",
            "completions fish",
            "man --dir x",
        ] {
            let arguments = std::iter::once("overcoat").chain(line.split_whitespace());
            assert!(Cli::try_parse_from(arguments).is_ok(), "{line}");
        }
    }

    /// Lists in help are complete.
    #[test]
    fn help_names_every_value() {
        let help = |command: &str| {
            let mut cli = Cli::command();
            // Options of all commands are known to each once they are built.
            cli.build();
            let text = cli.find_subcommand_mut(command).unwrap().render_long_help().to_string();
            // Names may stand at the end of a sentence or of a line.
            let words = text.split(|c: char| !(c.is_ascii_alphanumeric() || "-_.".contains(c)));
            words.map(|word| word.trim_end_matches('.').to_owned()).collect::<Vec<_>>()
        };
        let shading = || ShadingModel::ALL.iter().copied().map(ShadingModel::name).map(str::to_owned);
        let extensions = || Format::ALL.iter().copied().map(|format| format!(".{}", format.extension()));
        let render = help("render");
        for name in (Aov::ALL.iter().copied().map(Aov::name).map(str::to_owned))
            .chain(shading())
            .chain(extensions())
            .chain(Format::ALL.iter().copied().map(|format| format.extension().to_owned()))
            .chain(LIMIT_NAMES.map(str::to_owned))
        {
            assert!(render.contains(&name), "render --help does not name {name}");
        }
        for command in
            ["thumbnail", "turntable", "animate", "info", "diagnose", "sheet", "bench", "compare-models"]
        {
            let words = help(command);
            assert!(extensions().all(|name| words.contains(&name)), "{command} --help lacks a format");
        }
        let compare = help("compare-models");
        assert!(shading().all(|name| compare.contains(&name)));
        assert!(!compare.contains(&"--shading".to_owned()));
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
        let mut scene = Description::from_json(
            r#"{"size": [1, 2], "camera": {"eye": [1, 2, 3], "fov_y_deg": 20, "near": 1}, "samples": 4}"#,
        )
        .unwrap();
        args.model.draw.apply(&mut scene);
        assert_eq!(scene.size, Some([64, 64]));
        assert_eq!(scene.samples, Some(4));
        assert_eq!((scene.camera.eye, scene.camera.near), (None, None));
        assert_eq!(scene.camera.fov_y_degrees, Some(20.0));
        assert_eq!(scene.env, Some(EnvironmentChoice::Named(NamedEnvironment::None)));
        assert_eq!(scene.exposure, Some(ExposureChoice::Stops(-1.5)));
        assert_eq!(scene.tone_curve, Some(ToneCurve::None));
    }
}
