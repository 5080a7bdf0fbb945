//! Shading models against tables of the original functions' results.
//!
//! The rows go through the same lane functions as the shading pass, sixteen a vector, at every instruction
//! set of this machine, which must agree in every bit. `OVERCOAT_REFERENCE=FOLDER` scores the tables found
//! anywhere below that folder instead of the copies in `tests/reference`; `-- --nocapture` shows the scores, and
//! `OVERCOAT_REFERENCE_ONLY=NAME` scores only tables whose name contains NAME.
//!
//! A model joins by a line in the `ADAPTERS` of its file, and its file by a line in [`ADAPTERS`] here.

mod babylon;
mod filament;
mod gltf;
mod hdrp_lit;
mod helpers;
mod helpers_layers;
mod openpbr;
mod stacklit;
mod stub;
pub mod table;
mod three;
mod urp;
mod velvet;

use std::path::{Path, PathBuf};
use table::{Adapter, Table};

/// The models, each with its tables.
const ADAPTERS: &[&[Adapter]] = &[
    urp::ADAPTERS,
    helpers::ADAPTERS,
    helpers_layers::ADAPTERS,
    hdrp_lit::ADAPTERS,
    stacklit::ADAPTERS,
    filament::ADAPTERS,
    three::ADAPTERS,
    gltf::ADAPTERS,
    velvet::ADAPTERS,
    openpbr::ADAPTERS,
    babylon::ADAPTERS,
];

fn adapter_of(table: &str) -> Option<&'static Adapter> {
    ADAPTERS.iter().copied().flatten().find(|a| a.table == table)
}

/// Share of the cells of a column that must be within the narrow tolerance.
const PASS_RATE: f64 = 0.995;

/// A cell: what was found, and the original in single and double precision.
struct Cell {
    row: f64,
    found: f64,
    single: f64,
    double: f64,
}

impl Cell {
    fn error(&self) -> f64 {
        // Equal infinities differ by nothing; a NaN never agrees.
        if self.found == self.single { 0.0 } else { (self.found - self.single).abs() }
    }
    fn narrow(&self) -> f64 {
        1e-6 + 5e-5 * self.single.abs() + 16.0 * (self.single - self.double).abs()
    }
    fn wide(&self) -> f64 {
        0.02 * self.single.abs().max(1e-3) + 16.0 * (self.single - self.double).abs()
    }
    fn within(&self, tolerance: f64) -> bool {
        self.error() <= tolerance
    }
    /// Error in units of the narrow tolerance; infinite for NaN.
    fn excess(&self) -> f64 {
        let ratio = self.error() / self.narrow();
        if ratio.is_nan() { f64::INFINITY } else { ratio }
    }
}

/// Every output of every row, in the order of [`Table::batches`].
fn evaluate(adapter: &Adapter, table: &Table) -> Result<Vec<(String, Vec<f32>)>, String> {
    let mut columns: Vec<(String, Vec<f32>)> = Vec::new();
    for batch in table.batches(adapter.uniform)? {
        for (name, values) in (adapter.run)(&batch).columns {
            if !columns.iter().any(|(n, _)| *n == name) {
                columns.push((name.clone(), vec![f32::NAN; table.rows]));
            }
            if let Some((_, column)) = columns.iter_mut().find(|(n, _)| *n == name) {
                for (&row, value) in batch.rows.iter().zip(values) {
                    column[row] = value;
                }
            }
        }
    }
    Ok(columns)
}

/// The score of one column.
#[derive(Debug, PartialEq)]
struct Score {
    passed: bool,
    line: String,
}

/// Applies the pass rule to every column of a table.
fn score(adapter: &Adapter, path: &Path) -> Result<Vec<Score>, String> {
    let table = Table::read(path)?;
    let twin = table.twin()?;
    let found = evaluate(adapter, &table)?;
    let (numbers, hazard) = (table.column("row")?, table.column("hazard")?);
    let mut scores = Vec::new();
    let outputs: Vec<&String> = table.names.iter().filter(|n| n.starts_with("out_")).collect();
    if outputs.is_empty() {
        return Err(format!("{}: no outputs", path.display()));
    }
    for name in outputs {
        if let Some((_, reason)) =
            adapter.skipped.iter().find(|(column, _)| name.strip_prefix("out_") == Some(column))
        {
            println!("skip {} {name}: {reason}", adapter.table);
            continue;
        }
        let (single, double) = (table.column(name)?, twin.column(name)?);
        let Some((_, values)) = found.iter().find(|(n, _)| name.strip_prefix("out_") == Some(n)) else {
            scores.push(Score { passed: false, line: format!("{} {name}: not evaluated", adapter.table) });
            continue;
        };
        let cells: Vec<Cell> = (0..table.rows)
            .filter(|&row| hazard[row] == 0.0)
            .map(|row| Cell {
                row: numbers[row],
                found: f64::from(values[row]),
                single: f64::from(single[row] as f32),
                double: double[row],
            })
            .collect();
        let Some(worst) = cells.iter().max_by(|a, b| a.excess().total_cmp(&b.excess())) else {
            scores.push(Score { passed: false, line: format!("{} {name}: no row to score", adapter.table) });
            continue;
        };
        let rate = cells.iter().filter(|c| c.within(c.narrow())).count() as f64 / cells.len() as f64;
        let outside = cells.iter().filter(|c| !c.within(c.wide())).count();
        let passed = rate >= PASS_RATE && outside == 0;
        let line = format!(
            "{:24} {name:32} {:4} rows {:7.3} % {outside:2} outside, worst row {:4}: {:e}, not {:e} ({:.2} of tolerance)",
            adapter.table,
            cells.len(),
            rate * 100.0,
            worst.row,
            worst.found,
            worst.single,
            worst.excess(),
        );
        scores.push(Score { passed, line });
    }
    Ok(scores)
}

/// All tables below a folder in the order of their paths: CSV files with inputs and outputs, without the
/// twins.
fn tables_below(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder).into_iter().flatten().flatten() {
            let path = entry.path();
            if path.is_dir() {
                if path.file_name().is_some_and(|n| n != "f64") {
                    folders.push(path);
                }
            } else if path.extension().is_some_and(|e| e == "csv") {
                found.push(path);
            }
        }
    }
    found.sort();
    found.retain(|path| {
        let names = Table::header(path);
        let has = |prefix: &str| names.iter().any(|n| n.starts_with(prefix));
        // Look-up tables have inputs and outputs too, but no numbered rows.
        has("in_") && has("out_") && names.iter().any(|n| n == "row")
    });
    found
}

#[test]
fn every_model_passes_its_tables() {
    let own = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")).join("tests/reference");
    let elsewhere = std::env::var_os("OVERCOAT_REFERENCE").map(PathBuf::from);
    let folder = elsewhere.as_ref().unwrap_or(&own);
    let only = std::env::var("OVERCOAT_REFERENCE_ONLY").ok();
    let paths = tables_below(folder);
    let mut failures = Vec::new();
    let mut scored = Vec::new();
    for path in &paths {
        let stem = path.file_stem().unwrap_or_default().to_string_lossy();
        if only.as_ref().is_some_and(|only| !stem.contains(only.as_str())) {
            continue;
        }
        let Some(adapter) = adapter_of(&stem) else {
            println!("NOT IMPLEMENTED {stem} ({})", path.display());
            continue;
        };
        match score(adapter, path) {
            Ok(scores) => {
                for score in scores {
                    println!("{} {}", if score.passed { "pass" } else { "FAIL" }, score.line);
                    if !score.passed {
                        failures.push(score.line);
                    }
                }
            }
            Err(problem) => failures.push(problem),
        }
        scored.push(adapter.table);
    }
    assert!(!scored.is_empty(), "no table of an implemented model below {}", folder.display());
    if elsewhere.is_none() && only.is_none() {
        for adapter in ADAPTERS.iter().copied().flatten() {
            assert!(scored.contains(&adapter.table), "the copy of {} is missing", adapter.table);
        }
    }
    assert!(failures.is_empty(), "{} failures:\n{}", failures.len(), failures.join("\n"));
}

/// The pass rule itself: what it lets through, and that it can fail.
#[test]
fn the_pass_rule_tells_good_from_bad() {
    let cell = |found: f64, double: f64| Cell { row: 0.0, found, single: 1.0, double };
    assert!(cell(1.0 + 5e-5, 1.0).within(cell(1.0, 1.0).narrow()));
    assert!(!cell(1.0 + 6e-5, 1.0).within(cell(1.0, 1.0).narrow()));
    assert!(cell(1.0 + 6e-5, 1.000_001).within(cell(1.0, 1.000_001).narrow()));
    assert!(cell(1.019, 1.0).within(cell(1.0, 1.0).wide()));
    assert!(!cell(1.021, 1.0).within(cell(1.0, 1.0).wide()));
    let nan = cell(f64::NAN, 1.0);
    assert!(!nan.within(nan.wide()) && nan.excess() == f64::INFINITY);
}

/// A folder without tables, a table without its twin and a wrong number are failures, not silence.
#[test]
fn missing_and_wrong_tables_fail() {
    let scratch = tempfile::tempdir().expect("a scratch folder");
    assert!(tables_below(scratch.path()).is_empty());
    let own = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")).join("tests/reference/unity");
    let text = std::fs::read_to_string(own.join("urp_gi.csv")).expect("the copy");
    let copy = scratch.path().join("urp_gi.csv");
    std::fs::write(&copy, &text).expect("writable");
    let adapter = adapter_of("urp_gi").expect("known");
    assert!(score(adapter, &copy).is_err_and(|e| e.contains("f64")));

    std::fs::create_dir(scratch.path().join("f64")).expect("writable");
    std::fs::copy(own.join("f64/urp_gi.csv"), scratch.path().join("f64/urp_gi.csv")).expect("writable");
    assert_eq!(tables_below(scratch.path()), std::slice::from_ref(&copy));
    let failed = |path: &Path| {
        let scores = score(adapter, path).expect("readable");
        assert_eq!(scores.len(), 9);
        scores.iter().filter(|s| !s.passed).count()
    };
    assert_eq!(failed(&copy), 0);

    // Swapping two outputs, in the twin as well, makes their columns fail.
    let swapped = |text: &str| text.replacen("out_gi_x,out_gi_y", "out_gi_y,out_gi_x", 1);
    let twin = std::fs::read_to_string(own.join("f64/urp_gi.csv")).expect("the copy");
    std::fs::write(&copy, swapped(&text)).expect("writable");
    std::fs::write(scratch.path().join("f64/urp_gi.csv"), swapped(&twin)).expect("writable");
    assert_eq!(failed(&copy), 2);

    // Nothing but hazards.
    let all_hazards: Vec<String> = text
        .lines()
        .map(|line| match line.strip_suffix(",0") {
            Some(start) => format!("{start},1"),
            None => line.to_owned(),
        })
        .collect();
    std::fs::write(&copy, all_hazards.join("\n")).expect("writable");
    assert_eq!(failed(&copy), 9);
}
