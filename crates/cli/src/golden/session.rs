//! Common start of all golden commands: the pairs of pictures and their thresholds.

use super::FolderArgs;
use crate::failure::{Failure, file_name};
use crate::progress::Progress;
use crate::report::Reporter;
use overcoat_core::files::read_file;
use overcoat_core::jobs::Jobs;
use overcoat_core::limits::Limits;
use overcoat_golden::GoldenError;
use overcoat_golden::check::{Compared, FileResult, Verdict, compare};
use overcoat_golden::thresholds::{ThresholdFile, Thresholds};
use overcoat_golden::walk::{FolderPair, Pair, THRESHOLDS};
use overcoat_image::decode::extensions;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};

/// The work of one command.
pub(super) struct Session {
    pub(super) folders: FolderPair,
    pub(super) limits: Limits,
    thresholds: ThresholdFile,
    /// Name of the threshold file in messages.
    thresholds_name: String,
    /// Thresholds where the threshold file has none.
    base: Thresholds,
    jobs: Jobs,
    quiet: bool,
}

impl Session {
    /// Lists the pictures and reads the thresholds.
    ///
    /// # Errors
    /// [`Failure`] if a folder or the threshold file cannot be read, or there is nothing to compare.
    pub(super) fn open(args: &FolderArgs) -> Result<Self, Failure> {
        let limits = args.limits.limits();
        let folders =
            FolderPair::open(&args.expected, &args.actual, &limits).map_err(|error| match &error {
                GoldenError::Mixed { .. } => Failure::usage(&error),
                GoldenError::Limit(limit) => Failure::limit(limit),
                _ => Failure::failed(&error),
            })?;
        if folders.pairs.is_empty() {
            // A check that compares nothing must not pass: the folder is likely the wrong one.
            let kinds: Vec<String> = extensions().map(|extension| format!(".{extension}")).collect();
            let kinds = kinds.join(", ");
            let others = folders.others_in_words().map_or_else(String::new, |others| format!("; {others}"));
            let message = format!("no picture in either folder ({kinds}){others}");
            return Err(Failure::failed(message).at(&args.expected));
        }
        let path = args.thresholds.clone().or_else(|| {
            let path = args.expected.join(THRESHOLDS);
            path.is_file().then_some(path)
        });
        let (thresholds, thresholds_name) = match &path {
            None => (ThresholdFile::default(), String::new()),
            Some(path) => (read_thresholds(path, &limits)?, file_name(path)),
        };
        let mut base = Thresholds::default().with_preset(args.preset);
        if let Some(pixels_per_degree) = args.pixels_per_degree {
            base.metrics.pixels_per_degree = pixels_per_degree;
        }
        if let Some(background) = args.background {
            base.metrics.background = background;
        }
        let jobs = Jobs::new(args.workers.count());
        Reporter { quiet: args.quiet }.threads(&jobs);
        Ok(Self { folders, limits, thresholds, thresholds_name, base, jobs, quiet: args.quiet })
    }

    /// Thresholds of a file.
    pub(super) fn thresholds(&self, name: &str) -> Thresholds {
        self.thresholds.of(name, &self.base)
    }

    /// Warnings about the folders.
    pub(super) fn warnings(&self) -> Vec<String> {
        self.folders.others_in_words().into_iter().collect()
    }

    /// Calls `f` for every pair, in parallel; results come in the order of names.
    pub(super) fn map<T: Send>(&self, what: &str, f: impl Fn(&Pair) -> T + Sync) -> Vec<T> {
        let progress = Progress::new(self.quiet);
        let (count, done) = (self.folders.pairs.len(), AtomicUsize::new(0));
        progress.stage(what);
        self.jobs.map(count, |k| {
            let result = f(&self.folders.pairs[k]);
            let done = done.fetch_add(1, Ordering::Relaxed) + 1;
            progress.stage(format!("{what}: {done} of {count}"));
            result
        })
    }

    /// Compares every pair and keeps of each comparison what `keep` makes of it, so that not all pictures are in memory.
    pub(super) fn compare<T: Send>(&self, strict: bool, keep: impl Fn(Compared) -> T + Sync) -> Vec<T> {
        self.map("comparing", |pair| keep(compare(pair, &self.thresholds(&pair.name), strict, &self.limits)))
    }

    /// Adds what is wrong with the threshold file; in strict checks also its tables that are for no picture.
    pub(super) fn with_problems(&self, mut results: Vec<FileResult>, strict: bool) -> Vec<FileResult> {
        let at = |line: usize| format!("{}:{line}", self.thresholds_name);
        for problem in self.thresholds.problems() {
            results.push(FileResult::new(&at(problem.line), Verdict::Failed, problem.message.clone()));
        }
        if strict {
            let names = self.folders.pairs.iter().map(|pair| pair.name.as_str());
            for (line, pattern) in self.thresholds.unused(names) {
                let reason = format!("thresholds for '{pattern}', and no picture of that name");
                results.push(FileResult::new(&at(line), Verdict::Unused, reason));
            }
        }
        results
    }
}

fn read_thresholds(path: &Path, limits: &Limits) -> Result<ThresholdFile, Failure> {
    let bytes = read_file(path, limits).map_err(|e| Failure::load(&e.into()).at(path))?;
    let text = String::from_utf8(bytes).map_err(|_| Failure::failed("it is not UTF-8").at(path))?;
    Ok(ThresholdFile::parse(&text))
}
