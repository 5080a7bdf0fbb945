//! `overcoat sheet`: many models on one labelled contact sheet.

use super::args::SheetArgs;
use super::contact::{ContactSheet, DEFAULT_CELL};
use super::failure::{Failure, file_name};
use super::render_task::RenderTask;
use super::report;
use overcoat_core::frame::DisplayImage;
use overcoat_description::{Setting, is_standard_stream};
use overcoat_render::{RenderStats, Renderer};
use overcoat_scene::{PrimitiveKind, Scene};
use overcoat_worker::camera_report::CameraReport;
use overcoat_worker::losses::{limited, losses, texture_losses};
use overcoat_worker::model_source::ModelSource;
use overcoat_worker::report::{Stages, Versions};
use overcoat_worker::resources;
use serde::Serialize;
use std::path::Path;

/// Report of `--json`. Fields are only ever added.
#[derive(Debug, Serialize)]
struct Report {
    width: u32,
    height: u32,
    cells: Vec<CellReport>,
    peak_rss_bytes: Option<u64>,
    /// Warnings that belong to no cell in particular.
    warnings: Vec<String>,
    versions: Versions,
}

#[derive(Debug, Default, Serialize)]
struct CellReport {
    file: String,
    frame_hash: Option<String>,
    /// Stops of its picture.
    exposure: Option<f32>,
    /// Axis of the model file that is up.
    up_axis: Option<&'static str>,
    /// True if that axis was told by the model's shape, against the custom of its format.
    up_is_by_shape: Option<bool>,
    camera: Option<CameraReport>,
    triangles: Option<u64>,
    error: Option<String>,
    warnings: Vec<String>,
}

/// Renders many models to one sheet.
///
/// # Errors
/// [`Failure`] if the sheet cannot be made, and also, after it is written, if a model failed.
pub fn run(args: &SheetArgs) -> Result<(), Failure> {
    let mut description = args.draw.describe(&args.inputs)?;
    description.size.get_or_insert(DEFAULT_CELL);
    let mut task = RenderTask::new(&args.draw, description, &args.inputs)?;
    let cell = [task.picture.options.width, task.picture.options.height];
    let count = args.inputs.len();
    let mut sheet = ContactSheet::new(
        &args.output,
        &task.inputs,
        task.json,
        count,
        &args.cells,
        cell,
        &task.picture.limits,
    )?;

    let mut renderer = args.draw.renderer();
    // Environment and materials are the same for all cells; they are loaded once.
    let mut setting = task.picture.setting(renderer.jobs())?;
    let warnings: Vec<String> =
        std::mem::take(&mut setting.warnings).iter().map(ToString::to_string).collect();
    for warning in &warnings {
        task.reporter.warning(warning);
    }
    let mut reports = Vec::new();
    let mut failed = 0;
    for (k, source) in task.sources().enumerate() {
        let file = file_name(&source.path);
        task.progress.stage(format!("{} of {count}: {file}", k + 1));
        let mut report = CellReport { file, ..CellReport::default() };
        let label = label(&source.path);
        match render_cell(&task, &setting, source, &mut renderer, &mut report) {
            Ok((image, what)) => {
                sheet.add(&[&image], [&label, &what]);
            }
            Err(failure) => {
                failed += 1;
                let text = failure.to_string();
                // The name is below the cell.
                let reason = text.strip_prefix(&format!("{}: ", report.file)).unwrap_or(&text);
                sheet.add_failure(reason, [&label, "failed"]);
                task.reporter.warning(&text);
                report.error = Some(text);
            }
        }
        for warning in &report.warnings {
            task.warn_of(&report.file, warning);
        }
        reports.push(report);
    }

    task.progress.stage("encoding");
    let [width, height] = sheet.size();
    sheet.write()?;
    task.finish(&[]);
    if task.json {
        let peak_rss_bytes = resources::peak_rss_bytes();
        let versions = Versions::default();
        report::print_json(&Report { width, height, cells: reports, peak_rss_bytes, warnings, versions })?;
    }
    if failed > 0 {
        return Err(Failure::failed(format!("{failed} of {count} models failed")).at(&args.output));
    }
    Ok(())
}

/// Renders one model. Returns its picture and how many triangles, points, lines or splats it has.
fn render_cell(
    task: &RenderTask,
    setting: &Setting,
    source: &ModelSource,
    renderer: &mut Renderer,
    report: &mut CellReport,
) -> Result<(DisplayImage, String), Failure> {
    let loaded = task.picture.load_into(setting, source, renderer.jobs(), &mut Stages::default())?;
    let scene = &loaded.scene;
    let camera = task.picture.camera(source, scene)?;
    let rendered = task.picture.render(source, renderer, scene, &camera)?;
    let tinted = rendered.frame.is_tinted();
    let display = task.picture.display_of(scene);
    let clipping = task.picture.clipping(scene, &rendered.frame);
    let metered = display.metered(&rendered.frame);
    let mut losses =
        losses(scene, task.picture.options.shading, (&display, metered.exposure), tinted, clipping);
    losses.extend(limited(&rendered.stats));
    losses.extend(texture_losses(scene, &loaded.warnings));
    let display = metered;
    report.warnings = loaded.warnings.iter().chain(&losses).map(ToString::to_string).collect();
    let coverage = task.picture.check_coverage(source, scene, &camera, &rendered.stats)?;
    report.warnings.extend(coverage.map(|warning| warning.to_string()));
    report.frame_hash = Some(rendered.frame.frame_hash());
    report.exposure = Some(display.exposure);
    let orientation = scene.orientation();
    report.up_axis = Some(orientation.up.name());
    report.up_is_by_shape = Some(orientation.up_is_by_shape);
    if let Some(note) = overcoat_worker::report::note_of_up(orientation) {
        task.reporter.note(format_args!("{}: {note}", report.file));
    }
    report.camera = Some(CameraReport::new(&camera, scene, &task.picture.options));
    report.triangles = Some(rendered.stats.triangles);
    let what = content(scene, &rendered.stats);
    Ok((DisplayImage::new(&rendered.frame, &display), what))
}

/// Contents of a model in words: "1,234 triangles", or points, lines or splats if there is nothing else.
fn content(scene: &Scene, stats: &RenderStats) -> String {
    let counts = [
        (scene.count_of(PrimitiveKind::Triangles), "triangles"),
        (scene.count_of(PrimitiveKind::Points), "points"),
        (scene.count_of(PrimitiveKind::Lines), "lines"),
        (stats.splats, "splats"),
    ];
    let (count, what) = counts.into_iter().find(|(count, _)| *count > 0).unwrap_or(counts[0]);
    format!("{} {what}", with_separators(count))
}

/// Label of a cell: the name of the file without its folder.
fn label(path: &Path) -> String {
    if is_standard_stream(path) {
        return file_name(path);
    }
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

/// 1234567 as 1,234,567.
fn with_separators(number: u64) -> String {
    let digits = number.to_string();
    let mut out = String::new();
    for (k, digit) in digits.chars().enumerate() {
        if k > 0 && (digits.len() - k).is_multiple_of(3) {
            out.push(',');
        }
        out.push(digit);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thousands_are_separated() {
        for (number, text) in [(0, "0"), (999, "999"), (1000, "1,000"), (1_234_567, "1,234,567")] {
            assert_eq!(with_separators(number), text);
        }
    }
}
