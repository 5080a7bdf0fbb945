//! `overcoat lab --paint`: a paint in the numbers of the trade.

use super::LabArgs;
use crate::failure::{self, Failure};
use crate::progress::Progress;
use crate::report;
use crate::translate::{read, scene_of};
use overcoat_core::limits::Limits;
use overcoat_description::MaterialSource;
use overcoat_lab::lab::{Bench, LabError, PaintMeasure};
use overcoat_render::Renderer;
use overcoat_scene::{Scene, ShadingModel};
use overcoat_worker::report::Versions;
use serde::Serialize;
use std::fmt::Write;

/// Report of `--paint --json`. Fields are only ever added.
#[derive(Debug, Serialize)]
struct PaintReport {
    paint: String,
    models: Vec<PaintEntry>,
    warnings: Vec<String>,
    versions: Versions,
}

#[derive(Debug, Serialize)]
struct PaintEntry {
    model: &'static str,
    colors: Vec<ColorEntry>,
    flop_index: Option<f64>,
    sparkle: Vec<SparkleEntry>,
    graininess: f64,
}

#[derive(Debug, Serialize)]
struct ColorEntry {
    aspecular_deg: f64,
    reflectance: [f64; 3],
    lab: [f64; 3],
    chroma: f64,
    hue_deg: f64,
}

#[derive(Debug, Serialize)]
struct SparkleEntry {
    light_deg: f64,
    area: f64,
    intensity: f64,
    grade: f64,
}

/// Measures a paint under its own model or those that are named, and prints it.
///
/// # Errors
/// [`Failure`] if the material cannot be read or drawn.
pub(super) fn run(
    args: &LabArgs,
    source: &MaterialSource,
    bench: &mut Bench,
    progress: Progress,
) -> Result<(), Failure> {
    let limits = Limits::default();
    let (file, _) = read(source, &limits, &Renderer::new(1))?;
    let scene = scene_of(&file, &limits)?;
    let own = [file.model().unwrap_or_default()];
    let models: &[ShadingModel] = if args.models.is_empty() { &own } else { &args.models };
    let mut found = Vec::new();
    for (k, &model) in models.iter().enumerate() {
        progress.step("models".to_owned(), k as u32, models.len() as u32);
        found.push((model, measure(bench, &scene, model).map_err(|e| failure::lab(&e))?));
    }
    drop(progress);
    let name = match source {
        MaterialSource::Builtin(name) => (*name).to_owned(),
        MaterialSource::File(path) => path.file_name().unwrap_or_default().to_string_lossy().into_owned(),
    };
    if args.report.json {
        let warnings = file.warnings().map(|warning| warning.to_string()).collect();
        let models = found.iter().map(|(model, measure)| entry(*model, measure)).collect();
        return report::print_json(&PaintReport {
            paint: name,
            models,
            warnings,
            versions: Versions::default(),
        });
    }
    let texts: Vec<String> = found.iter().map(|(model, measure)| text(&name, *model, measure)).collect();
    report::print(&texts.join("\n"))
}

fn measure(bench: &mut Bench, scene: &Scene, model: ShadingModel) -> Result<PaintMeasure, LabError> {
    PaintMeasure::of(bench, &scene.materials()[0], scene.textures(), model)
}

fn entry(model: ShadingModel, measure: &PaintMeasure) -> PaintEntry {
    PaintEntry {
        model: model.name(),
        colors: measure
            .colors
            .iter()
            .map(|color| ColorEntry {
                aspecular_deg: color.aspecular,
                reflectance: color.reflectance,
                lab: color.lab,
                chroma: color.chroma(),
                hue_deg: color.hue(),
            })
            .collect(),
        flop_index: measure.flop_index(),
        sparkle: measure
            .sparkle
            .iter()
            .map(|s| SparkleEntry {
                light_deg: s.light,
                area: s.area,
                intensity: s.intensity,
                grade: s.grade(),
            })
            .collect(),
        graininess: measure.graininess,
    }
}

/// Tables to read.
fn text(name: &str, model: ShadingModel, measure: &PaintMeasure) -> String {
    // Writing to a string cannot fail.
    let mut text = format!("{name} under {}\n\n{:>9}", model.name(), "aspecular");
    for name in ["L*", "a*", "b*", "C*", "h"] {
        let _ = write!(text, "  {name:>7}");
    }
    text.push('\n');
    for color in &measure.colors {
        let [lightness, a, b] = color.lab;
        let _ = writeln!(
            text,
            "{:>9}  {lightness:>7.2}  {a:>7.2}  {b:>7.2}  {:>7.2}  {:>7.1}",
            color.aspecular,
            color.chroma(),
            color.hue()
        );
    }
    let flop =
        measure.flop_index().map_or_else(|| "none: it is no darker at 110".to_owned(), |f| format!("{f:.2}"));
    let _ = writeln!(text, "\nflop index  {flop}\ngraininess  {:.2} %", 100.0 * measure.graininess);
    let _ = writeln!(text, "\n{:>9}  {:>9}  {:>9}  {:>7}", "lamp at", "sparkle", "intensity", "grade");
    for sparkle in &measure.sparkle {
        let area = format!("{:.2} %", 100.0 * sparkle.area);
        let _ = writeln!(
            text,
            "{:>9}  {area:>9}  {:>9.2}  {:>7.2}",
            sparkle.light,
            sparkle.intensity,
            sparkle.grade()
        );
    }
    text
}
