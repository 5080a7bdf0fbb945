//! `overcoat lab --measured`: a measured BRDF over the angle of view or light, beside materials.

use super::{Form, LabArgs, form, plot, put};
use crate::failure::{self, Failure};
use crate::progress::Progress;
use crate::report::{self, Reporter};
use crate::translate::{measured, read, scene_of};
use overcoat_core::limits::Limits;
use overcoat_lab::lab::{Bench, Light, Quantity, Row, Slice, luminance};
use overcoat_render::Renderer;
use overcoat_scene::{Material, ShadingModel};
use overcoat_worker::report::Versions;
use serde::Serialize;
use std::fmt::Write;
use std::path::Path;

/// Report of `--measured --json`. Fields are only ever added.
#[derive(Debug, Serialize)]
struct Report {
    format: &'static str,
    over: &'static str,
    rows: Vec<Entry>,
    warnings: Vec<String>,
    versions: Versions,
}

#[derive(Debug, Serialize)]
struct Entry {
    value: f64,
    /// Radiance, absent where nothing was measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    measured: Option<[f64; 3]>,
    /// Radiance of each material.
    materials: Vec<[f64; 3]>,
}

/// Measures the slice and writes or prints it.
///
/// # Errors
/// [`Failure`] if a file cannot be read, or something varies that a measurement does not have.
pub(super) fn run(args: &LabArgs, path: &Path, bench: &mut Bench, progress: Progress) -> Result<(), Failure> {
    if !matches!(args.over, Quantity::View | Quantity::Light) {
        return Err(Failure::usage("a measured BRDF varies over view or light: --over has one of them"));
    }
    let form = form(args.output.as_deref())?;
    let limits = Limits::default();
    let (brdf, mut warnings) = measured::read(path, &limits)?;
    let mut materials: Vec<(Material, ShadingModel)> = Vec::new();
    for choice in &args.material {
        let (file, _) = read(&choice.source, &limits, &Renderer::new(1))?;
        warnings.extend(file.warnings().map(|warning| warning.to_string()));
        let material = overcoat_lab::lab::untextured(&scene_of(&file, &limits)?.materials()[0]);
        materials.push((material, file.model().unwrap_or_default()));
    }
    let mut slice = args.slice();
    slice.models = materials.iter().map(|(_, model)| *model).collect();
    let mut rows = Vec::new();
    for (k, value) in slice.values().into_iter().enumerate() {
        progress.step(slice.over.name().to_owned(), k as u32, args.steps);
        let (view, light) = match slice.over {
            Quantity::Light => (slice.view, Light::Direct(value)),
            _ => (value, slice.light),
        };
        let measured = brdf.radiance(view, light).map_err(|e| failure::lab(&e))?;
        let shown = materials.iter().map(|(m, model)| bench.material_radiance(m, *model, view, light));
        let shown = shown.collect::<Result<Vec<_>, _>>().map_err(|e| failure::lab(&e))?;
        rows.push(Entry { value, measured, materials: shown });
    }
    drop(progress);
    let reporter = Reporter { quiet: args.report.quiet };
    warnings.iter().for_each(|warning| reporter.warning(warning));
    if args.report.json {
        let (format, over) = (brdf.format(), slice.over.name());
        return report::print_json(&Report { format, over, rows, warnings, versions: Versions::default() });
    }
    let text = match form {
        Form::Svg => {
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            let view = format!("{name}; view {} degrees", slice.view);
            let caption = if slice.over == Quantity::Light { view } else { name.into_owned() };
            let known = rows.into_iter().filter_map(|row| {
                let (value, models) = (row.value, row.materials);
                row.measured.map(|truth| Row { value, models, truth, error: [0.0; 3], coat: [0.0; 3] })
            });
            plot::named_slice(&caption, "measured", &slice, &known.collect::<Vec<_>>())
        }
        Form::Csv => Ok(csv(&slice, &rows)),
        Form::Read => Ok(table(&slice, &rows)),
    };
    put(args, text)
}

/// All channels; none where nothing was measured.
fn csv(slice: &Slice, rows: &[Entry]) -> String {
    let mut text = slice.over.name().to_owned();
    for name in ["measured"].into_iter().chain(super::names(&slice.models)) {
        // Writing to a string cannot fail.
        let _ = write!(text, ",{name}_r,{name}_g,{name}_b");
    }
    text.push('\n');
    for row in rows {
        text += &row.value.to_string();
        text += &row.measured.map_or_else(|| ",,,".to_owned(), |c| c.map(|c| format!(",{c}")).concat());
        row.materials.iter().flatten().for_each(|c| text += &format!(",{c}"));
        text.push('\n');
    }
    text
}

/// Luminance, and by how much each material is off.
fn table(slice: &Slice, rows: &[Entry]) -> String {
    let width = super::names(&slice.models).map(str::len).max().unwrap_or(0).max(9);
    let mut text = format!("{:>15}  {:>9}", slice.over.name(), "measured");
    super::names(&slice.models).for_each(|name| text += &format!("  {name:>width$}"));
    text.push('\n');
    for row in rows {
        let measured = row.measured.map(luminance);
        let shown = measured.map_or_else(|| "-".to_owned(), |y| format!("{y:.4}"));
        text += &format!("{:>15.3}  {shown:>9}", row.value);
        for radiance in &row.materials {
            let off = measured.filter(|y| *y > 0.0).map(|y| 100.0 * (luminance(*radiance) / y - 1.0));
            let off = off.map_or_else(|| "-".to_owned(), |off| format!("{off:+.1} %"));
            text += &format!("  {off:>width$}");
        }
        text.push('\n');
    }
    text
}
