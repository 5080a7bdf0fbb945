//! `overcoat render`: one model, one picture.

use super::args::{InputArgs, MachineArgs, RenderArgs};
use super::failure::{Failure, file_name};
use super::input::{self, ModelSource};
use super::materials::Materials;
use super::picture::Machine;
use super::progress::Progress;
use super::report::{self, Reporter, Stages, Versions};
use super::scene_file::{EnvironmentChoice, SceneFile};
use super::target::Target;
use crate::load::Warning;
use crate::output::OutputFormat;
use crate::render::{RenderStats, Renderer};
use crate::scene::{Scene, ShadingModel};
use serde::{Serialize, Serializer};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// What `--json` prints. Fields are only ever added.
#[derive(Debug, Serialize)]
struct Report<'a> {
    frame_hash: String,
    width: u32,
    height: u32,
    samples: u32,
    shading: &'a str,
    simd: &'a str,
    threads: usize,
    triangles: u64,
    triangles_rasterized: u64,
    fragments: u64,
    #[serde(skip_serializing_if = "Option::is_none")]
    stage_hashes: Option<StageHashesReport>,
    stages_ms: Stages,
    total_ms: f64,
    peak_rss_bytes: Option<u64>,
    warnings: Vec<String>,
    versions: Versions,
}

/// Stages and their hashes, as an object of hexadecimal numbers in the order of the stages.
#[derive(Debug)]
struct StageHashesReport {
    stages: Vec<(&'static str, u128)>,
}

impl Serialize for StageHashesReport {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.stages.iter().map(|(name, hash)| (name, format!("{hash:032x}"))))
    }
}

/// Renders one model to one picture.
///
/// # Errors
/// [`Failure`]; nothing is written then.
pub fn run(args: &RenderArgs) -> Result<(), Failure> {
    let start = Instant::now();
    let reporter = Reporter { quiet: args.report.quiet };
    let progress = Progress::new(args.report.quiet);
    let limits = args.input_options.limits();
    let mut stages = Stages::default();

    // Everything that can be wrong without reading the model.
    let mut description = describe(args.scene.scene.as_deref(), args.input.as_deref())?;
    args.animation.apply(&mut description);
    args.camera.apply(&mut description);
    args.light.apply(&mut description);
    args.picture.apply(&mut description);
    args.display.apply(&mut description);
    let source = model_source(&description, &args.input_options)?;
    let about_model = |failure: Failure| failure.at(&source.path);
    let inputs = input_paths(&description, args.scene.scene.as_deref(), &source.path);
    let inputs: Vec<&Path> = inputs.iter().map(AsRef::as_ref).collect();
    let target = Target::new(&args.output, args.output_format.as_deref(), &args.aov, &inputs)?;
    if target.is_standard_output() && args.report.json {
        return Err(Failure::usage("--json and the picture cannot both go to standard output"));
    }
    let (mut options, display) = description.options(machine(&args.machine), &limits).map_err(about_model)?;
    options.aovs.clone_from(&args.aov);
    options.aovs.dedup();
    options.stage_hashes = args.stage_hashes;
    if target.format() != OutputFormat::Png {
        let display_only = [
            (args.display.tone_map.is_some(), "--tone-map"),
            (args.display.exposure.is_some(), "--exposure"),
            (display.background.is_some(), "a background colour"),
        ];
        for (_, option) in display_only.into_iter().filter(|(given, _)| *given) {
            reporter.warning(format!("{option} has no effect on a linear picture (.{})", target.format()));
        }
    }

    progress.stage(format!("loading {}", file_name(&source.path)));
    let mut renderer = Renderer::new(usize::from(args.machine.threads));
    let materials =
        stages.time("load_materials", || Materials::load(&description, &limits, renderer.jobs()))?;
    let loaded = stages.time("load", || input::load(&source, &limits, renderer.jobs()))?;
    let (mut scene, mut warnings) = (loaded.scene, loaded.warnings);
    stages.time("load_materials", || materials.assign(&mut scene, &limits)).map_err(about_model)?;
    warnings
        .extend(stages.time("load_environment", || description.light(&mut scene, &limits, renderer.jobs()))?);
    let camera = description.camera(&scene, &options).map_err(about_model)?;

    progress.stage(format!("rendering {} triangles", scene.triangle_count()));
    let rendered =
        renderer.render(&scene, &camera, &options).map_err(|e| about_model(Failure::render(&e)))?;
    for &(name, time) in &rendered.stats.stages {
        stages.add(name, time);
    }
    warnings.extend(left_out(&scene, options.shading));
    warnings.extend(nothing_to_see(&scene, &rendered.stats));

    progress.stage("encoding");
    let encoded = stages.time("encode", || target.encode(&rendered.frame, &display))?;
    stages.time("write", || encoded.write())?;
    drop(progress);
    for warning in &warnings {
        reporter.warning(warning);
    }
    if !args.report.json {
        return Ok(());
    }
    let frame_hash = stages.time("hash", || rendered.frame.frame_hash());
    report::print_json(&Report {
        frame_hash,
        width: options.width,
        height: options.height,
        samples: options.samples,
        shading: report::shading_name(options.shading, &scene),
        simd: options.simd.name(),
        threads: renderer.jobs().threads(),
        triangles: rendered.stats.triangles,
        triangles_rasterized: rendered.stats.triangles_rasterized,
        fragments: rendered.stats.fragments,
        stage_hashes: rendered.stats.stage_hashes.map(|hashes| StageHashesReport {
            stages: hashes.stages().into_iter().chain([("encode", encoded.digest())]).collect(),
        }),
        stages_ms: stages,
        total_ms: report::milliseconds(start.elapsed()),
        peak_rss_bytes: report::peak_rss_bytes(),
        warnings: warnings.into_iter().map(|w| w.message).collect(),
        versions: Versions::default(),
    })
}

/// The scene file, if there is one, with the model of the command line, if there is one.
pub(super) fn describe(scene: Option<&Path>, input: Option<&Path>) -> Result<SceneFile, Failure> {
    let mut description = match scene {
        Some(path) => SceneFile::open(path)?,
        None => SceneFile::default(),
    };
    if let Some(input) = input {
        description.model = Some(input.to_owned());
    }
    match (&description.model, scene) {
        (None, Some(scene)) => {
            Err(Failure::failed("names no model, and neither does the command line").at(scene))
        }
        _ => Ok(description),
    }
}

/// Where the described model comes from.
pub(super) fn model_source(description: &SceneFile, args: &InputArgs) -> Result<ModelSource, Failure> {
    let path = description.model.clone().unwrap_or_else(|| PathBuf::from("-"));
    let mut source = input::source(args, &path)?;
    source.options.animation = description.animation_choice()?;
    Ok(source)
}

/// All files that a picture is made of and that must not be overwritten by it.
pub(super) fn input_paths(description: &SceneFile, scene: Option<&Path>, model: &Path) -> Vec<PathBuf> {
    let mut inputs = vec![model.to_owned()];
    inputs.extend(scene.map(Path::to_owned));
    if let Some(EnvironmentChoice::File(file)) = &description.env {
        inputs.push(file.clone());
    }
    inputs
        .extend(description.material_choices().filter_map(|choice| choice.source.file().map(Path::to_owned)));
    inputs
}

/// What the picture needs from the machine.
pub(super) fn machine(args: &MachineArgs) -> Machine {
    Machine { simd: args.simd, tile_size: args.tile }
}

/// What materials have and the formulas that shade them do not know: one line for each model.
pub(super) fn left_out(scene: &Scene, chosen: Option<ShadingModel>) -> impl Iterator<Item = Warning> {
    ShadingModel::ALL.into_iter().filter_map(move |model| {
        let mut names: Vec<&str> = Vec::new();
        for material in scene.materials() {
            if material.shading(chosen) == model && !material.unlit {
                names.extend(model.leaves_out(material));
            }
        }
        names.sort_unstable();
        names.dedup();
        let list = names.join(", ");
        (!names.is_empty()).then(|| Warning::new(format!("{} has no {list}: left out", model.name())))
    })
}

/// Why a picture is empty, where it is.
pub(super) fn nothing_to_see(scene: &Scene, stats: &RenderStats) -> Option<Warning> {
    if scene.triangle_count() == 0 {
        Some(Warning::new("nothing to draw: the model has no triangles"))
    } else if stats.fragments == 0 {
        Some(Warning::new("nothing to see: no triangle of the model is in the picture"))
    } else {
        None
    }
}
