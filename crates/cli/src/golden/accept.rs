//! `overcoat golden accept`: actual pictures become expected ones.

use super::AcceptArgs;
use super::session::Session;
use crate::failure::{Failure, one_line};
use crate::report::{Reporter, print, print_json};
use overcoat_golden::accept::{Accepted, prepare, store};
use overcoat_golden::thresholds::matches;
use overcoat_worker::report::Versions;
use serde::Serialize;
use std::fmt::Write as _;

/// Report of `--json`. Fields are only ever added.
#[derive(Serialize)]
struct Report<'a> {
    dry_run: bool,
    /// Pictures that were written, or would have been.
    accepted: usize,
    unchanged: usize,
    files: Vec<FileReport<'a>>,
    errors: &'a [String],
    warnings: Vec<String>,
    versions: Versions,
}

#[derive(Serialize)]
struct FileReport<'a> {
    name: &'a str,
    accepted: bool,
    bytes: Option<usize>,
    bytes_before: Option<usize>,
    error: Option<String>,
}

/// Prepares everything, then writes.
///
/// # Errors
/// [`Failure`] if a picture could not be accepted; the others are.
pub(super) fn run(args: &AcceptArgs) -> Result<(), Failure> {
    let session = Session::open(&args.folders)?;
    let chosen = |name: &str| args.all || args.names.iter().any(|pattern| matches(pattern, name));
    let results = session.map("compressing", |pair| {
        if !chosen(&pair.name) {
            return None;
        }
        let thresholds = session.thresholds(&pair.name);
        let prepared = prepare(pair, &session.folders.expected, &thresholds, args.all, &session.limits);
        let done = prepared.and_then(|accepted| {
            if !args.dry_run {
                store(&accepted, pair)?;
            }
            Ok(accepted)
        });
        Some((pair.name.clone(), done))
    });

    let mut out = String::new();
    let mut files = Vec::new();
    let mut failures = Vec::new();
    let (mut accepted, mut unchanged) = (0, 0);
    for (name, result) in results.iter().flatten() {
        let mut file = FileReport { name, accepted: false, bytes: None, bytes_before: None, error: None };
        match result {
            Ok(Accepted::Unchanged) => unchanged += 1,
            Ok(Accepted::Written { bytes, before, .. }) => {
                accepted += 1;
                file.accepted = !args.dry_run;
                (file.bytes, file.bytes_before) = (Some(bytes.len()), *before);
                let word = if args.dry_run { "would accept" } else { "accepted" };
                let _ = write!(out, "{word} {}: {} bytes", one_line(name), bytes.len());
                let _ = match before {
                    Some(before) => writeln!(out, ", was {before}"),
                    None => writeln!(out, ", new"),
                };
            }
            Err(error) => {
                file.error = Some(error.to_string());
                failures.push(format!("{name}: {error}"));
            }
        }
        files.push(file);
    }
    let unknown = args
        .names
        .iter()
        .filter(|pattern| !session.folders.pairs.iter().any(|pair| matches(pattern, &pair.name)));
    failures.extend(unknown.map(|pattern| format!("{pattern}: no picture of that name")));
    let word = if args.dry_run { "to accept" } else { "accepted" };
    let _ = writeln!(out, "{accepted} {word}, {unchanged} as they were");
    let warnings = session.warnings();
    if args.json {
        let (dry_run, versions) = (args.dry_run, Versions::default());
        print_json(&Report { dry_run, accepted, unchanged, files, errors: &failures, warnings, versions })?;
    } else if !args.folders.quiet {
        for warning in warnings {
            let _ = writeln!(out, "{}", one_line(&warning));
        }
        print(&out)?;
    }
    let reporter = Reporter { quiet: false };
    failures.iter().for_each(|failure| reporter.warning(failure));
    match failures.len() {
        0 => Ok(()),
        count => Err(Failure::failed(format!("{count} could not be accepted"))),
    }
}
