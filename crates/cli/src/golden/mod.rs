//! `overcoat golden`: pictures of any renderer against those that were accepted.

mod accept;
// As in `cli::args`.
#[allow(missing_docs)]
mod args;
mod session;
mod table;

pub use args::{AcceptArgs, CheckArgs, FolderArgs, GoldenArgs, GoldenCommand, ReportArgs, ResultArgs};

use super::failure::{Failure, file_name};
use super::output_file::{Encoded, check_writable};
use super::report::print;
use overcoat_description::is_standard_stream;
use overcoat_golden::check::{FileResult, Verdict};
use overcoat_golden::junit::to_junit;
use overcoat_golden::report::{ReportEntry, to_html};
use session::Session;
use std::path::Path;

/// Carries out one command.
///
/// # Errors
/// [`Failure`] if pictures differ or cannot be compared; results are written all the same.
pub fn run(args: &GoldenArgs) -> Result<(), Failure> {
    match &args.command {
        GoldenCommand::Check(args) => check(args),
        GoldenCommand::Report(args) => report(args),
        GoldenCommand::Accept(args) => accept::run(args),
    }
}

fn check(args: &CheckArgs) -> Result<(), Failure> {
    check_outputs(&args.results, None)?;
    let session = Session::open(&args.folders)?;
    let results = session.compare(args.results.strict, |compared| compared.result);
    let results = session.with_problems(results, args.results.strict);
    finish(&session, &args.results, args.folders.quiet, &results)
}

fn report(args: &ReportArgs) -> Result<(), Failure> {
    check_outputs(&args.results, Some(&args.output))?;
    let session = Session::open(&args.folders)?;
    let show_equal = args.include_equal;
    let compared = session
        .compare(args.results.strict, |compared| (ReportEntry::new(&compared, show_equal), compared.result));
    let (mut entries, results): (Vec<ReportEntry>, Vec<FileResult>) = compared.into_iter().unzip();
    let results = session.with_problems(results, args.results.strict);
    entries.extend(results[entries.len()..].iter().map(ReportEntry::without_pictures));
    let html = to_html(&file_name(&args.folders.expected), &file_name(&args.folders.actual), &entries);
    Encoded::new(args.output.clone(), html.into_bytes()).write()?;
    let quiet = args.folders.quiet || is_standard_stream(&args.output);
    finish(&session, &args.results, quiet, &results)
}

/// Finds out before the work what could not be written after it.
fn check_outputs(args: &ResultArgs, page: Option<&Path>) -> Result<(), Failure> {
    let outputs: Vec<&Path> =
        [args.json.as_deref(), args.junit.as_deref(), page].into_iter().flatten().collect();
    if outputs.iter().filter(|path| is_standard_stream(path)).count() > 1 {
        return Err(Failure::usage("only one output can go to standard output"));
    }
    outputs.iter().filter(|path| !is_standard_stream(path)).try_for_each(|path| check_writable(path))
}

/// Writes the results and says how they came out.
fn finish(session: &Session, args: &ResultArgs, quiet: bool, results: &[FileResult]) -> Result<(), Failure> {
    let mut table_wanted = !quiet;
    let mut write = |path: &Option<std::path::PathBuf>, text: &dyn Fn() -> String| match path {
        None => Ok(()),
        Some(path) if is_standard_stream(path) => {
            table_wanted = false;
            print(&text())
        }
        Some(path) => Encoded::new(path.clone(), text().into_bytes()).write(),
    };
    write(&args.json, &|| table::to_json(session, args.strict, results))?;
    write(&args.junit, &|| to_junit("golden", results))?;
    if table_wanted {
        print(&table::to_text(session, results))?;
    }
    verdict(results)
}

/// Nothing if all is well; otherwise what is not, with the exit code for it.
fn verdict(results: &[FileResult]) -> Result<(), Failure> {
    let count = |verdict: Verdict| results.iter().filter(|r| r.verdict == verdict).count();
    let bad = results.iter().filter(|r| !r.verdict.is_good()).count();
    let (failed, differ) = (count(Verdict::Failed), count(Verdict::Differs));
    let of = format!("of {}", results.len());
    if failed > 0 {
        let rest = match bad - failed {
            0 => String::new(),
            rest => format!(", {rest} are not as expected"),
        };
        return Err(Failure::failed(format!("{failed} {of} could not be compared{rest}")));
    }
    if bad == differ && bad > 0 {
        return Err(Failure::differ(format!("{bad} {of} differ")));
    }
    if bad > 0 {
        let kinds: Vec<Verdict> = Verdict::ALL.iter().copied().filter(|verdict| !verdict.is_good()).collect();
        let message = format!("{bad} {of} are not as expected: {}", table::counts(results, &kinds));
        return Err(Failure::differ(message));
    }
    Ok(())
}
