//! Results as text and as JSON.

use super::session::Session;
use crate::failure::{file_name, one_line};
use overcoat_golden::check::{FileResult, Verdict, badness_order};
use overcoat_worker::report::Versions;
use serde::Serialize;
use std::fmt::Write as _;

/// Report of `--json`. Fields are only ever added.
#[derive(Serialize)]
struct Report<'a> {
    expected: String,
    actual: String,
    strict: bool,
    files: Vec<FileReport<'a>>,
    warnings: Vec<String>,
    versions: Versions,
}

#[derive(Serialize)]
struct FileReport<'a> {
    name: &'a str,
    verdict: Verdict,
    reasons: &'a [String],
    metrics: Option<MetricsReport>,
}

#[derive(Serialize)]
struct MetricsReport {
    pixels: u64,
    /// `null` where a number stands against none.
    max_abs: Option<f64>,
    /// `null` for pictures that look equal in every bit.
    psnr: Option<f64>,
    ssim: f64,
    flip_mean: f64,
    flip_max: f64,
}

/// The results as JSON, in the order of names.
pub(super) fn to_json(session: &Session, strict: bool, results: &[FileResult]) -> String {
    let finite = |v: f64| v.is_finite().then_some(v);
    let files = results
        .iter()
        .map(|r| FileReport {
            name: &r.name,
            verdict: r.verdict,
            reasons: &r.reasons,
            metrics: r.metrics.as_ref().map(|m| MetricsReport {
                pixels: m.exact.pixels,
                max_abs: finite(m.exact.max_abs),
                psnr: finite(m.psnr),
                ssim: m.ssim,
                flip_mean: m.flip_mean,
                flip_max: m.flip_max,
            }),
        })
        .collect();
    let report = Report {
        expected: file_name(&session.folders.expected),
        actual: file_name(&session.folders.actual),
        strict,
        files,
        warnings: session.warnings(),
        versions: Versions::default(),
    };
    // Strings, numbers and lists of them always have a JSON form.
    serde_json::to_string_pretty(&report).unwrap_or_default() + "\n"
}

/// The results for people: what is not equal as a table, the worst first, a line of totals, and what was not compared.
pub(super) fn to_text(session: &Session, results: &[FileResult]) -> String {
    let mut shown: Vec<&FileResult> = results.iter().filter(|r| r.verdict != Verdict::Equal).collect();
    shown.sort_by(|a, b| badness_order(a, b));
    let mut out = String::new();
    if !shown.is_empty() {
        let width = shown.iter().map(|r| r.name.chars().count()).max().unwrap_or(0).clamp(4, 48);
        let first = shown.iter().map(|r| r.verdict.name().len()).max().unwrap_or(0).max(9);
        let _ = writeln!(
            out,
            "{:<first$}  {:<width$}  {:>8}  {:>8}  {:>7}  {:>7}  {:>7}",
            "", "file", "pixels", "max", "PSNR", "SSIM", "FLIP"
        );
        for result in shown {
            // Nothing follows a name without measures.
            let width = if result.metrics.is_some() { width } else { 0 };
            let _ = write!(out, "{:<first$}  {:<width$}", result.verdict.name(), one_line(&result.name));
            if let Some(m) = &result.metrics {
                let max = if m.exact.max_abs >= 1.0 && m.exact.max_abs == m.exact.max_abs.floor() {
                    format!("{}", m.exact.max_abs)
                } else {
                    format!("{:.5}", m.exact.max_abs)
                };
                let _ = write!(
                    out,
                    "  {:>8}  {max:>8}  {:>7.2}  {:>7.4}  {:>7.4}",
                    m.exact.pixels, m.psnr, m.ssim, m.flip_mean
                );
            }
            out.push('\n');
            // The verdict may say it all.
            for reason in result.reasons.iter().filter(|reason| *reason != result.verdict.name()) {
                let _ = writeln!(out, "{:<indent$}{}", "", one_line(reason), indent = first + 2);
            }
        }
        out.push('\n');
    }
    let files = if results.len() == 1 { "1 file".to_owned() } else { format!("{} files", results.len()) };
    let _ = writeln!(out, "{files}: {}", counts(results, Verdict::ALL));
    for warning in session.warnings() {
        let _ = writeln!(out, "{}", one_line(&warning));
    }
    out
}

/// Numbers of results with each of these verdicts, in words.
pub(super) fn counts(results: &[FileResult], verdicts: &[Verdict]) -> String {
    let counts = verdicts.iter().filter_map(|&verdict| {
        let count = results.iter().filter(|r| r.verdict == verdict).count();
        let words = match verdict {
            Verdict::NoExpected => "without expected picture",
            Verdict::NoActual => "without actual picture",
            Verdict::Unused if count == 1 => "table of thresholds unused",
            Verdict::Unused => "tables of thresholds unused",
            verdict => verdict.name(),
        };
        (count > 0).then(|| format!("{count} {words}"))
    });
    counts.collect::<Vec<_>>().join(", ")
}
