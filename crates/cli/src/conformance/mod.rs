//! `overcoat conformance`: a folder with which others test their renderers of clear coats against the referee.

mod describe;
mod folder;
mod pack;
mod score;

use super::args::{ReportArgs, ThreadArgs};
use super::lab::DEFAULT_MODELS;
use super::progress::Progress;
use super::report::{self, Reporter};
use super::value_parsers;
use crate::failure::{self, Failure};
use clap::Args;
use overcoat_core::suggest::{nearest_name, suggestion};
use overcoat_lab::lab::conformance::{Engines, SCENES, Scene};
use overcoat_scene::ShadingModel;
use overcoat_worker::report::Versions;
use serde::Serialize;
use std::fmt::Write;
use std::path::PathBuf;

/// Version of the pack: the first number changes with a scene, its true mean or a rule, the second with what leaves scores comparable: more
/// scenes, less noise.
const VERSION: &str = "1.1";

/// `overcoat conformance`
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  overcoat conformance pack
  overcoat conformance quick --size 48 --samples 256 --models three

FOLDER gets scenes (glTF and JSON), environments, the referee's pictures with
their variance and tolerances, the planes of the ball, score.py, which scores
the pictures of any renderer and writes a page, and the pictures and scores of
the models here. Its README.md says how to use it; all of it is CC0. With the
defaults it takes some two minutes on two processors.")]
pub struct ConformanceArgs {
    /// Folder to make; what is there is never written over
    #[arg(value_name = "FOLDER")]
    pub folder: PathBuf,

    /// Side of the pictures in pixels, 32 to 512
    #[arg(long, value_name = "N", default_value_t = 96, value_parser = value_parsers::within::<u32>(32, 512))]
    pub size: u32,

    /// Walks of the referee for each pixel, 32 to 1048576
    #[arg(long, value_name = "N", default_value_t = 2048, value_parser = value_parsers::within::<u32>(32, 1 << 20))]
    pub samples: u32,

    /// Seed of the walks, 0 to 65535: another is another, independent truth
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = value_parsers::within::<u32>(0, 65535))]
    pub seed: u32,

    /// A second truth beside that of all bounces, in one-bounce/: light that meets a second facet of the
    /// same interface is lost, as in GGX of one bounce. Adds some four fifths to the time
    #[arg(long)]
    pub one_bounce: bool,

    /// Scenes, comma-separated [default: all]
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = scene)]
    scenes: Vec<Scene>,

    /// Shading models to score, comma-separated [default: one of each engine]
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = value_parsers::shading)]
    pub models: Vec<ShadingModel>,

    #[command(flatten)]
    #[allow(missing_docs, reason = "clap would take it for a heading of the help")]
    pub workers: ThreadArgs,
    #[command(flatten)]
    #[allow(missing_docs, reason = "clap would take it for a heading of the help")]
    pub report: ReportArgs,
}

/// Report of `--json`. Fields are only ever added.
#[derive(Debug, Serialize)]
struct Report {
    folder: String,
    pack: &'static str,
    files: usize,
    bytes: usize,
    scores: Vec<Entry>,
    warnings: Vec<String>,
    versions: Versions,
}

/// A model's score of a scene.
#[derive(Clone, Debug, Serialize)]
struct Entry {
    model: &'static str,
    scene: &'static str,
    #[serde(flatten)]
    score: score::Score,
    /// Against the truth of one bounce, where there is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    one_bounce: Option<score::Score>,
}

fn scene(name: &str) -> Result<Scene, String> {
    let known = SCENES.iter().find(|scene| scene.name == name);
    known.copied().ok_or_else(|| {
        let names = SCENES.iter().map(|scene| scene.name);
        format!("no scene of the pack{}", suggestion(nearest_name(name, names)))
    })
}

/// Makes the pack and says how the models here do.
///
/// # Errors
/// [`Failure`] if the folder is there already or cannot be written, or a model is not in this program; nothing is left then.
pub fn run(args: &ConformanceArgs) -> Result<(), Failure> {
    folder::check(&args.folder)?;
    let all = if args.models.is_empty() { DEFAULT_MODELS } else { &args.models };
    let models: Vec<ShadingModel> =
        all.iter().copied().filter(|model| !args.models.is_empty() || model.is_built()).collect();
    if let Some(model) = models.iter().find(|model| !model.is_built()) {
        return Err(Failure::usage(format!("the model {} is not in this program", model.name())));
    }
    // In the order of the list, each once, whatever the order of the option.
    let is_asked =
        |scene: &&Scene| args.scenes.is_empty() || args.scenes.iter().any(|s| s.name == scene.name);
    let scenes: Vec<Scene> = SCENES.iter().filter(is_asked).copied().collect();
    let mut engines = Engines::new(args.workers.count()).map_err(|e| failure::lab(&e))?;
    Reporter { quiet: args.report.quiet }.threads(engines.jobs());
    let progress = Progress::new(args.report.quiet);
    let request = pack::Request {
        scenes: &scenes,
        models: &models,
        size: args.size,
        samples: args.samples,
        seed: args.seed,
        one_bounce: args.one_bounce,
    };
    let (files, scores) = pack::make(&request, &mut engines, &progress)?;
    progress.stage("writing");
    folder::write(&args.folder, &files)?;
    drop(progress);
    if args.report.json {
        return report::print_json(&Report {
            folder: args.folder.display().to_string(),
            pack: VERSION,
            files: files.len(),
            bytes: files.iter().map(|(_, bytes)| bytes.len()).sum(),
            scores,
            warnings: Vec::new(),
            versions: Versions::default(),
        });
    }
    report::print(&table(&scenes, &models, &scores))
}

/// A row for each scene, a column for each model: the mean difference, with a star where it passes.
fn table(scenes: &[Scene], models: &[ShadingModel], scores: &[Entry]) -> String {
    let mut text = "| scene | noise |".to_owned();
    models.iter().for_each(|model| {
        let _ = write!(text, " {} |", model.name());
    });
    text.push_str("\n| --- | ---: |");
    models.iter().for_each(|_| text.push_str(" ---: |"));
    for scene in scenes {
        let scores: Vec<_> = scores.iter().filter(|entry| entry.scene == scene.name).collect();
        let noise = scores.first().map_or(0.0, |entry| entry.score.noise);
        let _ = write!(text, "\n| {} | {:.1} % |", scene.name, 100.0 * noise);
        for Entry { score, one_bounce, .. } in scores {
            let star = match one_bounce {
                _ if score.passes => "*",
                Some(one) if one.passes => "+",
                _ => "",
            };
            let _ = write!(text, " {:.1} %{star} |", 100.0 * score.error);
        }
    }
    text.push_str("\n\nMean difference from the referee, and what of it its noise alone makes; * passes within its tolerances");
    let ends = if scores.iter().any(|entry| entry.one_bounce.is_some()) {
        ",\n+ within those of the truth of one bounce alone.\n"
    } else {
        ".\n"
    };
    text.push_str(ends);
    text
}
