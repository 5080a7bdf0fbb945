//! `overcoat sheet`: many models on one labelled contact sheet.

use super::args::SheetArgs;
use super::failure::{Failure, file_name};
use super::input::{self, ModelSource};
use super::label::{Sheet, fit, wrap};
use super::materials::Materials;
use super::picture::{Machine, is_standard_stream};
use super::progress::Progress;
use super::render::{left_out, machine, nothing_to_see};
use super::report::{self, Reporter, Versions};
use super::scene_file::SceneFile;
use super::target::{Encoded, Target};
use crate::limits::Limits;
use crate::output::{DisplayImage, OutputFormat, encode_png_rgb};
use crate::render::Renderer;
use crate::scene::Scene;
use serde::Serialize;
use std::path::Path;

/// Side of a cell's picture in pixels where none is given.
pub(super) const DEFAULT_CELL: u64 = 256;
/// Pixels between cells.
const GAP: u32 = 8;
/// Pixels below a picture for two lines of text.
const LABEL: u32 = 36;
/// Pixels of one grid unit of the font.
const UNIT: f32 = 1.4;

pub(super) const PAPER: [u8; 3] = [246, 246, 246];
/// Neither black nor white, so that models of both stand out.
const CELL: [u8; 3] = [214, 215, 218];
const INK: [u8; 3] = [32, 32, 32];
const FAINT: [u8; 3] = [112, 112, 112];
const ALARM: [u8; 3] = [176, 32, 32];

/// One model on the sheet.
enum Cell {
    /// It was rendered.
    Picture { image: DisplayImage, triangles: u64 },
    /// It was not.
    Failed(Failure),
}

/// What `--json` prints. Fields are only ever added.
#[derive(Debug, Serialize)]
struct Report {
    width: u32,
    height: u32,
    cells: Vec<CellReport>,
    peak_rss_bytes: Option<u64>,
    versions: Versions,
}

#[derive(Debug, Default, Serialize)]
struct CellReport {
    file: String,
    frame_hash: Option<String>,
    triangles: Option<u64>,
    error: Option<String>,
    warnings: Vec<String>,
}

/// Where things are on the sheet, in pixels.
pub(super) struct Layout {
    columns: u32,
    cell: [u32; 2],
    /// Width and height of the sheet.
    pub(super) size: [u32; 2],
}

/// Renders many models to one sheet.
///
/// # Errors
/// [`Failure`] if the sheet cannot be made, and also, after it is written, if a model failed.
pub fn run(args: &SheetArgs) -> Result<(), Failure> {
    let reporter = Reporter { quiet: args.report.quiet };
    let progress = Progress::new(args.report.quiet);
    let limits = args.input_options.limits();
    let machine = machine(&args.machine);

    let inputs: Vec<&Path> = args.inputs.iter().map(AsRef::as_ref).collect();
    let target = Target::new(&args.output, None, &[], &inputs)?;
    if target.format() != OutputFormat::Png {
        return Err(Failure::usage("a contact sheet is a .png").at(&args.output));
    }
    if target.is_standard_output() && args.report.json {
        return Err(Failure::usage("--json and the sheet cannot both go to standard output"));
    }
    let mut description = SceneFile { size: Some([DEFAULT_CELL; 2]), ..SceneFile::default() };
    args.camera.apply(&mut description);
    args.light.apply(&mut description);
    args.picture.apply(&mut description);
    args.display.apply(&mut description);
    let (options, _) = description.options(machine, &limits)?;
    let layout = Layout::new(args.inputs.len(), args.columns, [options.width, options.height], &limits)?;

    let mut renderer = Renderer::new(usize::from(args.machine.threads));
    // Environment and materials are the same for all cells; they are loaded once.
    let materials = Materials::load(&description, &limits, renderer.jobs())?;
    let mut surroundings = Scene::new();
    for warning in description.light(&mut surroundings, &limits, renderer.jobs())? {
        reporter.warning(warning);
    }

    let [width, height] = layout.size;
    let mut sheet = Sheet::new(width, height, PAPER).ok_or_else(|| {
        Failure::failed(format!("a sheet of {width} x {height} pixels does not fit into memory"))
    })?;
    let mut reports = Vec::new();
    let mut failed = 0;
    for (k, path) in args.inputs.iter().enumerate() {
        progress.stage(format!("{} of {}: {}", k + 1, args.inputs.len(), file_name(path)));
        let mut report = CellReport { file: file_name(path), ..CellReport::default() };
        description.model = Some(path.clone());
        let source = input::source(&args.input_options, path);
        let cell = source
            .and_then(|source| {
                render_cell(
                    &description,
                    &materials,
                    &source,
                    &surroundings,
                    machine,
                    &limits,
                    &mut renderer,
                    &mut report,
                )
            })
            .unwrap_or_else(Cell::Failed);
        for warning in &report.warnings {
            reporter.warning(format_args!("{}: {warning}", report.file));
        }
        if let Cell::Failed(failure) = &cell {
            failed += 1;
            reporter.warning(failure);
            report.error = Some(failure.to_string());
        }
        layout.draw(&mut sheet, k, path, &cell);
        reports.push(report);
    }

    progress.stage("encoding");
    let bytes = encode_png_rgb(width, height, &sheet.into_rgb(), true)
        .map_err(|e| Failure::failed(e).at(&args.output))?;
    Encoded::new(args.output.clone(), bytes).write()?;
    drop(progress);
    if args.report.json {
        let peak_rss_bytes = report::peak_rss_bytes();
        report::print_json(&Report {
            width,
            height,
            cells: reports,
            peak_rss_bytes,
            versions: Versions::default(),
        })?;
    }
    if failed > 0 {
        return Err(
            Failure::failed(format!("{failed} of {} models failed", args.inputs.len())).at(&args.output)
        );
    }
    Ok(())
}

/// Renders one model as the description says.
fn render_cell(
    description: &SceneFile,
    materials: &Materials,
    source: &ModelSource,
    surroundings: &Scene,
    machine: Machine,
    limits: &Limits,
    renderer: &mut Renderer,
    report: &mut CellReport,
) -> Result<Cell, Failure> {
    let (options, display) = description.options(machine, limits)?;
    let loaded = input::load(source, limits, renderer.jobs())?;
    let mut scene = loaded.scene;
    if description.lights == Some(false) {
        scene.clear_lights();
    }
    let about = |failure: Failure| failure.at(&source.path);
    materials.assign(&mut scene, limits).map_err(about)?;
    scene.set_environment(surroundings.environment().clone()).map_err(|e| about(Failure::scene(&e)))?;
    let camera = description.camera(&scene, &options).map_err(about)?;
    let rendered = renderer.render(&scene, &camera, &options).map_err(|e| about(Failure::render(&e)))?;
    report.warnings = loaded.warnings.iter().map(ToString::to_string).collect();
    report.warnings.extend(left_out(&scene, options.shading).map(|w| w.to_string()));
    report.warnings.extend(nothing_to_see(&scene, &rendered.stats).map(|w| w.to_string()));
    report.frame_hash = Some(rendered.frame.frame_hash());
    report.triangles = Some(rendered.stats.triangles);
    let image = DisplayImage::new(&rendered.frame, &display);
    Ok(Cell::Picture { image, triangles: rendered.stats.triangles })
}

impl Layout {
    /// Refuses sheets beyond the limits of a picture.
    pub(super) fn new(
        cells: usize,
        columns: Option<u32>,
        cell: [u32; 2],
        limits: &Limits,
    ) -> Result<Self, Failure> {
        let cells = u32::try_from(cells).unwrap_or(u32::MAX).max(1);
        let columns = columns.unwrap_or_else(|| {
            let full = |c: u32| u64::from(c) * u64::from(cell[0] + GAP);
            let rows = |c: u32| u64::from(cells.div_ceil(c)) * u64::from(cell[1] + GAP + LABEL);
            (1..=cells).find(|&c| full(c) * 3 >= rows(c) * 4).unwrap_or(cells)
        });
        let columns = columns.min(cells);
        let pitch = [u64::from(cell[0] + GAP), u64::from(cell[1] + GAP + LABEL)];
        let width = pitch[0] * u64::from(columns) + u64::from(GAP);
        let height = pitch[1] * u64::from(cells.div_ceil(columns)) + u64::from(GAP);
        let what = || format!("sheet of {width} x {height} pixels");
        let side = if width > height { width } else { height };
        Limits::check(what, side, u64::from(limits.output_side), "output_side")
            .and_then(|()| Limits::check(what, width * height, limits.output_pixels, "output_pixels"))
            .map_err(|e| Failure::limit(&e))?;
        // Within output_side, which is a u32.
        Ok(Self { columns, cell, size: [width as u32, height as u32] })
    }

    /// Fills the background of cell `k` and writes two lines below it. Returns its left upper corner.
    pub(super) fn label(&self, sheet: &mut Sheet, k: usize, [first, second]: [&str; 2]) -> [u32; 2] {
        let [width, height] = self.cell;
        let (column, row) = (k as u32 % self.columns, k as u32 / self.columns);
        let x = GAP + column * (width + GAP);
        let y = GAP + row * (height + GAP + LABEL);
        let (left, below) = (x as f32, (y + height) as f32);
        let room = width as f32 - 8.0;
        sheet.fill(left, y as f32, width as f32, height as f32, CELL);
        sheet.text(&fit(first, room, UNIT), left + 4.0, below + 4.0, UNIT, INK);
        sheet.text(&fit(second, room, UNIT), left + 4.0, below + 20.0, UNIT, FAINT);
        [x, y]
    }

    /// Draws one cell with its label.
    fn draw(&self, sheet: &mut Sheet, k: usize, path: &Path, cell: &Cell) {
        let name = if is_standard_stream(path) {
            file_name(path)
        } else {
            path.file_name().unwrap_or_default().to_string_lossy().into_owned()
        };
        match cell {
            Cell::Picture { image, triangles } => {
                let second = format!("{} triangles", with_separators(*triangles));
                let [x, y] = self.label(sheet, k, [&name, &second]);
                sheet.picture(x as i32, y as i32, image.width, image.height, &image.pixels);
            }
            Cell::Failed(failure) => {
                let [x, y] = self.label(sheet, k, [&name, "failed"]);
                let [width, height] = self.cell.map(|v| v as f32);
                let line_height = 11.0 * UNIT;
                let lines = (((height - 16.0) / line_height) as usize).max(1);
                // The name is below the cell.
                let text = failure.to_string();
                let reason = text.strip_prefix(&format!("{}: ", file_name(path))).unwrap_or(&text);
                for (n, line) in wrap(reason, width - 8.0, UNIT, lines).iter().enumerate() {
                    sheet.text(line, x as f32 + 4.0, y as f32 + 10.0 + n as f32 * line_height, UNIT, ALARM);
                }
            }
        }
    }
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
    fn sheets_are_a_little_wider_than_high_and_hold_every_cell() {
        for cells in 1..100 {
            let layout = Layout::new(cells, None, [256, 256], &Limits::default()).unwrap();
            let rows = (cells as u32).div_ceil(layout.columns);
            assert!(layout.columns * rows >= cells as u32);
            let [w, h] = layout.size;
            assert!(cells < 8 || (w > h / 2 && w < 3 * h), "{cells}: {w} x {h}");
        }
        let failure = Layout::new(100_000, None, [256, 256], &Limits::default()).err().unwrap();
        assert_eq!(failure.exit_code(), 3);
    }

    #[test]
    fn thousands_are_separated() {
        for (number, text) in [(0, "0"), (999, "999"), (1000, "1,000"), (1_234_567, "1,234,567")] {
            assert_eq!(with_separators(number), text);
        }
    }
}
