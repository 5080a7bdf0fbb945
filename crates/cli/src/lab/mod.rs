//! `overcoat lab`: coats of engines beside a random walk through their layers, as tables and plots; paints in numbers; and measured
//! BRDFs beside materials.

mod args;
mod measured;
mod paint;
mod plot;

pub(super) use args::DEFAULT_MODELS;
pub use args::LabArgs;

use super::output_file::{Encoded, check_file, is_standard_output};
use super::progress::Progress;
use super::report::{self, Reporter};
use crate::failure::{self, Failure};
use overcoat_lab::lab::{
    Base, Bench, CONFIDENCE_95, Row, Slice, Specimen, StandardErrors, Summary, luminance,
};
use overcoat_scene::ShadingModel;
use overcoat_worker::report::Versions;
use serde::Serialize;
use std::error::Error;
use std::fmt::Write;
use std::path::Path;

/// Report of `--json` on a slice. Fields are only ever added.
#[derive(Debug, Serialize)]
struct Report {
    over: &'static str,
    base: &'static str,
    /// Absent where nothing beneath the coat has an index of its own.
    #[serde(skip_serializing_if = "Option::is_none")]
    base_ior: Option<f64>,
    rows: Vec<Entry>,
    warnings: Vec<String>,
    versions: Versions,
}

#[derive(Debug, Serialize)]
struct Entry {
    value: f64,
    truth: [f64; 3],
    standard_error: [f64; 3],
    truth_coat: [f64; 3],
    models: Vec<Shown>,
}

#[derive(Debug, Serialize)]
struct Shown {
    model: &'static str,
    radiance: [f64; 3],
}

/// Report of `--summary --json`. Fields are only ever added.
#[derive(Debug, Serialize)]
struct SummaryReport {
    base: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    base_ior: Option<f64>,
    cases: usize,
    noise: f64,
    models: Vec<SummaryEntry>,
    versions: Versions,
}

#[derive(Debug, Serialize)]
struct SummaryEntry {
    model: &'static str,
    bias: f64,
    white: f64,
    direct: f64,
    worst: f64,
    /// Half widths of intervals of 95 percent confidence, by the noise of the walks.
    by_walks: Intervals,
    /// The same by the choice of specimens, where that is a sample.
    #[serde(skip_serializing_if = "Option::is_none")]
    by_specimens: Option<Intervals>,
}

#[derive(Debug, Serialize)]
struct Intervals {
    bias: f64,
    white: f64,
    direct: f64,
}

impl From<StandardErrors> for Intervals {
    fn from(errors: StandardErrors) -> Self {
        let [bias, white, direct] =
            [errors.bias, errors.white, errors.direct].map(|error| CONFIDENCE_95 * error);
        Self { bias, white, direct }
    }
}

/// Output form of a slice.
#[derive(Clone, Copy, PartialEq)]
enum Form {
    Read,
    Csv,
    Svg,
}

/// Measures a slice or the grid, and writes or prints it.
///
/// # Errors
/// [`Failure`] if a number is out of its range or the output cannot be written.
pub fn run(args: &LabArgs) -> Result<(), Failure> {
    let mut bench = Bench::new(args.workers.count());
    Reporter { quiet: args.report.quiet }.threads(bench.jobs());
    let progress = Progress::new(args.report.quiet);
    if let Some(choice) = &args.paint {
        return paint::run(args, &choice.source, &mut bench, progress);
    }
    if let Some(path) = &args.measured {
        return measured::run(args, path, &mut bench, progress);
    }
    args.check()?;
    if args.summary {
        return summary(args, &mut bench, progress);
    }
    let form = form(args.output.as_deref())?;
    if args.by.is_some() && form != Form::Svg {
        return Err(Failure::usage("--by makes a map of errors: name an .svg with -o"));
    }
    let slice = args.slice();
    let (done, of) = (|name: &str, done, of| progress.step(name.to_owned(), done, of), args.steps);
    let text = match (args.by, form) {
        (Some(by), _) => {
            let outer = Slice { over: by, range: by.range(), ..slice.clone() };
            let mut maps = Vec::new();
            for (k, value) in outer.values().into_iter().enumerate() {
                done("rows of the map", k as u32, of);
                let inner = slice.varied(by, value).map_err(|e| failure::lab(&e))?;
                maps.push((value, inner.measure(&mut bench, |_| {}).map_err(|e| failure::lab(&e))?));
            }
            plot::errors(&slice, by, &maps)
        }
        (None, form) => {
            let rows = slice.measure(&mut bench, |k| done(slice.over.name(), k as u32, of));
            let rows = rows.map_err(|e| failure::lab(&e))?;
            if args.report.json {
                drop(progress);
                return report::print_json(&json(&slice, rows));
            }
            match form {
                Form::Svg => plot::slice(&slice, &rows),
                Form::Csv => Ok(csv(&slice, &rows)),
                Form::Read => Ok(table(&slice, &rows)),
            }
        }
    };
    drop(progress);
    put(args, text)
}

/// Writes a table or a plot, or prints it.
fn put(args: &LabArgs, text: Result<String, Box<dyn Error>>) -> Result<(), Failure> {
    let text = text.map_err(|error| Failure::failed(format!("the plot cannot be drawn: {error}")))?;
    match &args.output {
        Some(path) if !is_standard_output(path) => Encoded::new(path.clone(), text.into_bytes()).write(),
        _ => report::print(&text),
    }
}

/// By the name of the output.
fn form(output: Option<&Path>) -> Result<Form, Failure> {
    let Some(path) = output else { return Ok(Form::Read) };
    if is_standard_output(path) {
        return Ok(Form::Csv);
    }
    check_file(path, &[])?;
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default();
    match extension.to_ascii_lowercase().as_str() {
        "csv" => Ok(Form::Csv),
        "svg" => Ok(Form::Svg),
        _ => Err(Failure::usage(format!("{} is neither .svg nor .csv", path.display()))),
    }
}

fn json(slice: &Slice, rows: Vec<Row>) -> Report {
    let entry = |row: Row| Entry {
        value: row.value,
        truth: row.truth,
        standard_error: row.error,
        truth_coat: row.coat,
        models: names(&slice.models)
            .zip(&row.models)
            .map(|(model, radiance)| Shown { model, radiance: *radiance })
            .collect(),
    };
    Report {
        over: slice.over.name(),
        base: if slice.specimen.metal { "metal" } else { slice.specimen.base.name() },
        base_ior: has_index(&slice.specimen).then_some(slice.specimen.base_ior),
        rows: rows.into_iter().map(entry).collect(),
        warnings: Vec::new(),
        versions: Versions::default(),
    }
}

/// True if what is beneath the coat has an index of its own.
fn has_index(specimen: &Specimen) -> bool {
    !specimen.metal && specimen.base.has_index()
}

fn names(models: &[ShadingModel]) -> impl Iterator<Item = &'static str> {
    models.iter().map(|model| model.name())
}

/// All channels.
fn csv(slice: &Slice, rows: &[Row]) -> String {
    let mut text = slice.over.name().to_owned();
    for name in ["truth", "error", "truth_coat"].into_iter().chain(names(&slice.models)) {
        ["r", "g", "b"].iter().for_each(|channel| {
            let _ = write!(text, ",{name}_{channel}");
        });
    }
    text.push('\n');
    for row in rows {
        // Writing to a string cannot fail.
        let _ = write!(text, "{}", row.value);
        for c in [&row.truth, &row.error, &row.coat].into_iter().chain(&row.models).flatten() {
            let _ = write!(text, ",{c}");
        }
        text.push('\n');
    }
    text
}

/// Luminance, and by how much each model is off.
fn table(slice: &Slice, rows: &[Row]) -> String {
    let width = names(&slice.models).map(str::len).max().unwrap_or(0).max(9);
    let mut text = format!("{:>15}  {:>7}  {:>7}", slice.over.name(), "truth", "+-");
    names(&slice.models).for_each(|name| {
        let _ = write!(text, "  {name:>width$}");
    });
    text.push('\n');
    for row in rows {
        let truth = luminance(row.truth);
        let _ = write!(text, "{:>15.3}  {truth:>7.4}  {:>7.4}", row.value, luminance(row.error));
        for shown in &row.models {
            let off = 100.0 * (luminance(*shown) / truth - 1.0);
            let _ = write!(
                text,
                "  {:>width$}",
                if truth > 0.0 { format!("{off:+.1} %") } else { "-".to_owned() }
            );
        }
        text.push('\n');
    }
    text
}

fn summary(args: &LabArgs, bench: &mut Bench, progress: Progress) -> Result<(), Failure> {
    let mut specimens = args.random.map_or_else(|| Summary::specimens(args.all), Summary::random);
    let Specimen { base, base_ior, .. } = args.specimen.specimen();
    for specimen in &mut specimens {
        (specimen.base, specimen.base_ior) = (base, base_ior);
    }
    let samples = args.samples();
    let done = |done, of| progress.step("specimens", done as u32, of as u32);
    let found =
        Summary::measure(bench, &args.models(), &specimens, &samples, done).map_err(|e| failure::lab(&e))?;
    drop(progress);
    if args.report.json {
        let entry = |e: &overcoat_lab::lab::ModelError| SummaryEntry {
            model: e.model.name(),
            bias: e.bias,
            white: e.white,
            direct: e.direct,
            worst: e.worst.0,
            by_walks: e.by_walks.into(),
            by_specimens: args.random.map(|_| e.by_specimens.into()),
        };
        let models = found.errors.iter().map(entry).collect();
        let Summary { cases, noise, .. } = found;
        return report::print_json(&SummaryReport {
            base: base.name(),
            base_ior: base.has_index().then_some(base_ior),
            cases,
            noise,
            models,
            versions: Versions::default(),
        });
    }
    let mut text = String::from(
        "| model | white light, mean error | with sign | largest | direct light |\n| --- | ---: | ---: | ---: | ---: |\n",
    );
    for error in &found.errors {
        let errors = if args.random.is_some() { error.by_specimens } else { error.by_walks };
        let interval = Intervals::from(errors);
        let [white, bias, worst, direct] =
            [error.white, error.bias, error.worst.0, error.direct].map(|x| 100.0 * x);
        let [of_white, of_bias, of_direct] =
            [interval.white, interval.bias, interval.direct].map(|x| 100.0 * x);
        let name = error.model.name();
        let _ = writeln!(
            text,
            "| {name} | {white:.1} ± {of_white:.2} % | {bias:+.1} ± {of_bias:.2} % | {worst:+.0} % | {direct:.1} ± {of_direct:.2} % |"
        );
    }
    let chance = if args.random.is_some() { "choice of coats" } else { "noise of the walks" };
    let noise = 100.0 * found.noise;
    let plastic = described(base, base_ior);
    let _ = writeln!(
        text,
        "\n{} cases; plastic: {plastic}; standard error of the referee {noise:.2} %; ± intervals of 95 % by the {chance}",
        found.cases
    );
    report::print(&text)
}

/// A base in words.
fn described(base: Base, base_ior: f64) -> String {
    match base {
        Base::Interface => format!("interface of index {base_ior}"),
        Base::Seen => format!("interface of index {base_ior}, color as seen without coat"),
        base => base.name().to_owned(),
    }
}
