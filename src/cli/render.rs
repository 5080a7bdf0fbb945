//! `overcoat render`: one model, one picture.

use super::args::{DrawArgs, RenderArgs};
use super::camera_report::CameraReport;
use super::failure::{Failure, file_name};
use super::losses::{left_out, losses};
use super::output_file::OutputFile;
use super::render_task::{Pixels, RenderTask, RenderedPicture};
use super::report::{self, Stages, Versions, VisibilityReport};
use crate::description::spelling::ground_name;
use crate::frame::DisplayOptions;
use crate::load::Loaded;
use serde::{Serialize, Serializer};
use std::time::Instant;

/// What `--json` prints. Fields are only ever added.
#[derive(Debug, Serialize)]
struct Report<'a> {
    frame_hash: String,
    width: u32,
    height: u32,
    samples: u32,
    visibility: VisibilityReport,
    /// As `--ground` takes it.
    ground: String,
    shading_rate: u32,
    shade_everywhere: bool,
    shading: &'a str,
    simd: &'a str,
    threads: usize,
    /// Stops of the picture, if it is of 8 bits.
    exposure: Option<f32>,
    /// Axis of the model file that is up.
    up_axis: &'static str,
    camera: CameraReport,
    triangles: u64,
    triangles_rasterized: u64,
    splats: u64,
    splats_drawn: u64,
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
    let (draw, models) = (&args.model.draw, args.model.input.as_slice());
    let mut description = draw.describe(models)?;
    args.animation.apply(&mut description);
    let mut task = RenderTask::new(draw, description, models)?;
    let target = OutputFile::new(&args.output, &args.encoding, &args.aov, &task.inputs, task.json)?;
    task.behind_for(target.format());
    task.options.aovs.clone_from(&args.aov);
    task.options.aovs.dedup();
    task.options.stage_hashes = args.stage_hashes;
    if target.format().is_linear() {
        let display_only = [
            (draw.display.tone_map.is_some(), "--tone-map"),
            (draw.display.exposure.is_some(), "--exposure"),
            (task.display.background.is_some(), "a background colour"),
        ];
        for (_, option) in display_only.into_iter().filter(|(given, _)| *given) {
            let message = format!("{option} has no effect on a linear picture (.{})", target.format());
            task.reporter.warning(message);
        }
    }
    carry_out(task, draw, &target, start)
}

/// Loads, renders, writes and reports, once everything is known.
///
/// # Errors
/// [`Failure`]; nothing is written then.
pub(super) fn carry_out(
    mut task: RenderTask,
    draw: &DrawArgs,
    target: &OutputFile,
    start: Instant,
) -> Result<(), Failure> {
    let source = &task.source;
    task.progress.stage(format!("loading {}", file_name(&source.path)));
    let mut stages = Stages::default();
    let mut renderer = draw.renderer();
    let Loaded { scene, mut warnings, .. } = task.load(renderer.jobs(), &mut stages)?;
    let camera = task.camera(source, &scene)?;
    task.progress.stage(format!("rendering {} triangles", scene.triangle_count()));
    // The report names the frame's bits; nothing else needs more than the screen's.
    let for_screen = target.takes_image() && !task.json;
    let RenderedPicture { pixels, tinted, clipping, exposure, stats } =
        task.render_picture(source, &mut renderer, &scene, &camera, for_screen)?;
    for &(name, time) in stats.stages() {
        stages.add(name, time);
    }
    let shading = task.options.shading;
    let display = task.display_of(&scene);
    warnings.extend(match target.format() {
        format if format.is_linear() => left_out(&scene, shading).collect(),
        _ => losses(&scene, shading, &display, tinted, clipping),
    });
    match task.check_coverage(source, &scene, &camera, &stats) {
        Ok(warning) => warnings.extend(warning),
        Err(failure) => {
            task.finish(&warnings);
            return Err(failure);
        }
    }

    // What was metered holds: nobody asks again.
    let display = DisplayOptions { exposure, meter: false, ..display };

    task.progress.stage("encoding");
    let encoded = stages.time("encode", || target.encode(&pixels, &display))?;
    stages.time("write", || encoded.write())?;
    task.finish(&warnings);
    let Pixels::Frame(frame) = pixels else { return Ok(()) };
    if !task.json {
        return Ok(());
    }
    let frame_hash = stages.time("hash", || frame.frame_hash());
    let options = &task.options;
    report::print_json(&Report {
        frame_hash,
        width: options.width,
        height: options.height,
        samples: options.samples,
        visibility: VisibilityReport::new(&options.visibility),
        ground: ground_name(options.ground),
        shading_rate: options.shading_rate,
        shade_everywhere: options.shade_everywhere,
        shading: report::shading_name(options.shading, &scene),
        simd: options.simd.name(),
        threads: renderer.jobs().threads(),
        exposure: (!target.format().is_linear()).then_some(exposure),
        up_axis: scene.orientation().up.name(),
        camera: CameraReport::new(&camera, &scene),
        triangles: stats.triangles,
        triangles_rasterized: stats.triangles_rasterized,
        splats: stats.splats,
        splats_drawn: stats.splats_drawn,
        fragments: stats.fragments,
        stage_hashes: stats.stage_hashes.map(|hashes| StageHashesReport {
            stages: hashes.stages().chain([("encode", encoded.digest())]).collect(),
        }),
        stages_ms: stages,
        total_ms: report::milliseconds(start.elapsed()),
        peak_rss_bytes: report::peak_rss_bytes(),
        warnings: warnings.into_iter().map(|w| w.message).collect(),
        versions: Versions::default(),
    })
}
