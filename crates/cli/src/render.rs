//! `overcoat render`: one model, one picture.

use super::args::{DrawArgs, RenderArgs};
use super::embedded::{self, Embedded};
use super::failure::{Failure, file_name};
use super::output_file::{OutputFile, is_standard_output};
use super::render_task::RenderTask;
use super::report;
use super::terminal_size;
use overcoat_core::frame::Meter;
use overcoat_description::{BackgroundChoice, Description};
use overcoat_image::output::TerminalFormat;
use overcoat_load::Loaded;
use overcoat_render::Ground;
use overcoat_scene::Scene;
use overcoat_worker::annotation_report::annotations;
use overcoat_worker::losses::{left_out, limited, losses, texture_losses};
use overcoat_worker::picture_format::PictureFormat;
use overcoat_worker::picture_task::{Pixels, RenderedPicture};
use overcoat_worker::render_report::{RenderReport, Told};
use overcoat_worker::report::Stages;
use std::collections::BTreeMap;
use std::time::Instant;

/// Renders one model to one picture.
///
/// # Errors
/// [`Failure`]; nothing is written then.
pub fn run(args: &RenderArgs) -> Result<(), Failure> {
    let start = Instant::now();
    let (draw, models) = (&args.model.draw, args.model.input.as_slice());
    let mut description = draw.describe(models)?;
    args.animation.apply(&mut description);
    let Some(output) = &args.output else { return Err(Failure::usage("-o OUT says where the picture goes")) };
    if let Some(format) = args.encoding.output_format.and_then(PictureFormat::terminal) {
        suit_terminal(&mut description, format, is_standard_output(output));
    }
    let mut task = RenderTask::new(draw, description, models)?;
    let target = OutputFile::new(output, &args.encoding, &args.aov, &task.inputs, task.json)?;
    let target = if args.is_unnamed { target.marked() } else { target };
    if let PictureFormat::File(format) = target.format() {
        task.behind_for(format);
    }
    if args.embedded {
        task.embedded = Embedded::Always;
    }
    task.picture.options.aovs.clone_from(&args.aov);
    task.picture.options.aovs.dedup();
    task.picture.options.stage_hashes = args.stage_hashes;
    if target.format().is_linear() {
        let display_only = [
            (draw.options.has("tone-map"), "--tone-map"),
            (draw.options.has("exposure"), "--exposure"),
            (task.picture.display.background.is_some(), "a background colour"),
        ];
        for (_, option) in display_only.into_iter().filter(|(given, _)| *given) {
            let message = format!("{option} has no effect on a linear picture (.{})", target.format());
            task.reporter.warning(message);
        }
    }
    let reporter = task.reporter;
    carry_out(task, draw, &target, start)?;
    if args.is_unnamed {
        reporter.note(format_args!("wrote {}", output.display()));
    }
    Ok(())
}

/// Settles what nobody has asked for: a picture that fits the terminal, if it is `sent` to one, and no shadow that would be
/// there or not where it should be soft.
fn suit_terminal(description: &mut Description, format: TerminalFormat, sent: bool) {
    if description.size.is_none() && sent {
        description.size = terminal_size::side(format).map(|side| [side; 2]);
    }
    let is_open = matches!(description.background, None | Some(BackgroundChoice::Transparent));
    if is_open && !format.has_opacity() {
        description.ground.get_or_insert(Ground::None);
    }
}

/// True if there is nothing in a scene that could be seen from somewhere.
fn has_nothing(scene: &Scene) -> bool {
    scene.instances().is_empty() && scene.splat_instances().is_empty()
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
    if task.embedded == Embedded::Always {
        return embedded::show(&mut task, target);
    }
    task.progress.stage(format!("loading {}", file_name(&task.picture.source.path)));
    let mut stages = Stages::default();
    let mut renderer = draw.renderer();
    let loaded = task.picture.load(renderer.jobs(), &mut stages);
    let why = match &loaded {
        Ok(loaded) if has_nothing(&loaded.scene) => Some("there is no model in it".to_owned()),
        // A model beyond the limits could be drawn with others.
        Err(failure) if failure.exit_code() == 1 => Some(failure.to_string()),
        _ => None,
    };
    if let Some(why) = why
        && embedded::show_instead(&mut task, target, &why)?
    {
        return Ok(());
    }
    let Loaded { scene, mut warnings, .. } = loaded?;
    let source = &task.picture.source;
    let camera = task.picture.camera(source, &scene)?;
    task.progress.stage(format!("rendering {} triangles", scene.triangle_count()));
    // The report names the frame's bits; nothing else needs more than the screen's.
    let for_screen = target.takes_image() && !task.json;
    let RenderedPicture { pixels, tinted, clipping, exposure, stats } =
        task.picture.render_picture(source, &mut renderer, &scene, &camera, for_screen)?;
    for &(name, time) in stats.stages() {
        stages.add(name, time);
    }
    let shading = task.picture.options.shading;
    let display = task.picture.display_of(&scene);
    warnings.extend(texture_losses(&scene, &warnings));
    warnings.extend(match target.format() {
        format if format.is_linear() => left_out(&scene, shading).collect(),
        _ => losses(&scene, shading, (&display, exposure), tinted, clipping),
    });
    warnings.extend(limited(&stats));
    match task.picture.check_coverage(source, &scene, &camera, &stats) {
        Ok(warning) => warnings.extend(warning),
        Err(failure) => {
            task.finish(&warnings);
            return Err(failure);
        }
    }

    // The metered exposure holds: nobody asks again.
    let display = display.with_exposure(exposure).with_meter(Meter::Never);

    task.progress.stage("encoding");
    let encoded = stages.time("encode", || target.encode(&pixels, &display))?;
    // It may go to the terminal on which the progress is.
    task.progress.finish();
    stages.time("write", || encoded.write())?;
    let mut ids = BTreeMap::new();
    if let (Pixels::Frame(frame), true) = (&pixels, task.json) {
        let options = &task.picture.options;
        ids = annotations(&mut renderer, &scene, &camera, options, frame, (&mut stages, &mut warnings))?;
    }
    task.finish(&warnings);
    task.note_up(scene.orientation());
    let Pixels::Frame(frame) = pixels else { return Ok(()) };
    if !task.json {
        return Ok(());
    }
    let frame_hash = stages.time("hash", || frame.frame_hash());
    let told = Told {
        task: &task.picture,
        scene: &scene,
        camera: &camera,
        stats: &stats,
        format: target.format(),
        frame_hash,
        encoded: encoded.digest(),
        exposure,
        threads: renderer.jobs().threads(),
        ids,
    };
    report::print_json(&RenderReport::new(&told, stages, start.elapsed(), warnings))
}
