//! One pair of files compared, or a folder of them.

use super::compress::{CompressError, Effort, compress_png};
use super::decode::{DecodeError, DecodedPicture, SampleKind};
use super::metrics::exact::unmatched_planes;
use super::metrics::{Measured, MetricError, Metrics, measure};
use super::thresholds::{DEFAULT_MAX_BYTES, Thresholds, short};
use super::walk::Pair;
use crate::limits::Limits;
use crate::load::{LoadError, read_file};
use serde::Serialize;
use std::path::PathBuf;

/// A stored PNG may be larger by this factor than what the strongest compression makes of it.
const OVERSIZE: f64 = 1.1;
/// Files below this size are not worth a word.
const OVERSIZE_FROM: usize = 1024;

/// How a comparison came out, from good to bad.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Verdict {
    /// Every sample is the same.
    Equal,
    /// They differ, and no more than the thresholds allow.
    Within,
    /// They differ by more than the thresholds allow, or in size or depth.
    Differs,
    /// The stored file is larger than it must be (strict checks).
    Oversized,
    /// There is an actual picture and no expected one.
    Missing,
    /// There is an expected picture, or an entry of the threshold file, and nothing actual for it.
    Dead,
    /// Something cannot be read or compared.
    Failed,
}

impl Verdict {
    /// True if nobody has to do anything.
    #[must_use]
    pub fn is_good(self) -> bool {
        matches!(self, Self::Equal | Self::Within)
    }

    /// True if the pictures could be compared: the others say that something is missing.
    #[must_use]
    pub fn is_compared(self) -> bool {
        self <= Self::Oversized
    }

    /// The word in tables.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Equal => "equal",
            Self::Within => "within",
            Self::Differs => "differs",
            Self::Oversized => "oversized",
            Self::Missing => "missing",
            Self::Dead => "dead",
            Self::Failed => "failed",
        }
    }
}

/// What came of one name.
#[derive(Clone, Debug, PartialEq)]
pub struct FileResult {
    /// Path below the folders, with `/` between its parts.
    pub name: String,
    /// How it came out.
    pub verdict: Verdict,
    /// Why, a sentence each; for pictures that pass, what is worth knowing.
    pub reasons: Vec<String>,
    /// The measures, where both pictures could be read and have the same size.
    pub metrics: Option<Metrics>,
}

impl FileResult {
    /// A result without measures.
    #[must_use]
    pub fn new(name: &str, verdict: Verdict, reason: impl Into<String>) -> Self {
        Self { name: name.to_owned(), verdict, reasons: vec![reason.into()], metrics: None }
    }

    /// Bad results order before good ones, then by what a person sees, then by the largest difference, then by name.
    #[must_use]
    pub fn badness_order(&self, other: &Self) -> std::cmp::Ordering {
        let key = |r: &Self| {
            let m = r.metrics.as_ref();
            // What has no measures because the sizes differ is worse than what has.
            m.map_or((f64::INFINITY, 0.0), |m| (m.flip_mean, m.exact.max_abs))
        };
        let ((flip_a, abs_a), (flip_b, abs_b)) = (key(self), key(other));
        (!other.verdict.is_good())
            .cmp(&!self.verdict.is_good())
            .then(other.verdict.is_compared().cmp(&self.verdict.is_compared()).reverse())
            .then(flip_b.total_cmp(&flip_a))
            .then(abs_b.total_cmp(&abs_a))
            .then_with(|| self.name.cmp(&other.name))
    }
}

/// A result with what it was made of, for reports.
#[derive(Clone, Debug)]
pub struct Compared {
    /// The result.
    pub result: FileResult,
    /// The expected file and what it holds, if it can be read.
    pub expected: Option<(Vec<u8>, DecodedPicture)>,
    /// The actual file and what it holds, if it can be read.
    pub actual: Option<(Vec<u8>, DecodedPicture)>,
    /// The measures with the map of FLIP, as far as both can be compared.
    pub measured: Option<Measured>,
}

/// Compares the two files of a name. `strict` also looks at how the expected file is stored.
#[must_use]
pub fn compare(pair: &Pair, thresholds: &Thresholds, strict: bool, limits: &Limits) -> Compared {
    let read = |path: &Option<PathBuf>| path.as_deref().map(|path| read_file(path, limits));
    let files = [read(&pair.expected), read(&pair.actual)];
    compare_files(&pair.name, files, pair.problem.clone(), thresholds, strict, limits)
}

/// Compares what an expected and an actual file hold, where there are such files and they could be read.
pub(super) fn compare_files(
    name: &str,
    files: [Option<Result<Vec<u8>, LoadError>>; 2],
    problem: Option<String>,
    thresholds: &Thresholds,
    strict: bool,
    limits: &Limits,
) -> Compared {
    let mut failures = Vec::new();
    let mut decode = |file: Option<Result<Vec<u8>, LoadError>>, what: &str| {
        let decoded = file?.map_err(DecodeError::from).and_then(|bytes| {
            let picture = DecodedPicture::from_bytes(&bytes, limits)?;
            Ok((bytes, picture))
        });
        decoded.map_err(|e| failures.push(format!("{what} picture: {e}"))).ok()
    };
    let [expected, actual] = files;
    let expected = decode(expected, "expected");
    let actual = decode(actual, "actual");
    failures.extend(problem);

    let mut measured = None;
    let result = if !failures.is_empty() {
        FileResult { name: name.to_owned(), verdict: Verdict::Failed, reasons: failures, metrics: None }
    } else {
        match (&expected, &actual) {
            (Some((stored, e)), Some((_, a))) => {
                let (mut result, m) = compare_pictures(name, e, a, thresholds);
                measured = m;
                if strict && let Some(reason) = oversize(stored, thresholds, limits) {
                    result.reasons.push(reason);
                    if result.verdict.is_good() {
                        result.verdict = Verdict::Oversized;
                    }
                }
                result
            }
            (Some(_), None) => FileResult::new(name, Verdict::Dead, "no actual picture"),
            (None, _) => FileResult::new(name, Verdict::Missing, "no expected picture"),
        }
    };
    Compared { result, expected, actual, measured }
}

/// Compares two pictures by their thresholds.
#[must_use]
pub fn compare_pictures(
    name: &str,
    expected: &DecodedPicture,
    actual: &DecodedPicture,
    thresholds: &Thresholds,
) -> (FileResult, Option<Measured>) {
    let measured = match measure(expected, actual, &thresholds.metrics) {
        Ok(measured) => measured,
        Err(error) => {
            let verdict = match error {
                MetricError::Size { .. } => Verdict::Differs,
                MetricError::Transfer => Verdict::Failed,
            };
            return (FileResult::new(name, verdict, error.to_string()), None);
        }
    };
    let mut reasons = Vec::new();
    if expected.kind != actual.kind {
        reasons.push(depth_reason(expected.kind, actual.kind));
    }
    let (lost, added) = unmatched_planes(expected, actual);
    for (names, what) in [(lost, "is missing"), (added, "is not expected")] {
        reasons.extend(names.iter().map(|name| format!("channel {name} {what}")));
    }
    reasons.extend(thresholds.violations(&measured.metrics));
    let verdict = if !reasons.is_empty() {
        Verdict::Differs
    } else if measured.metrics.exact.pixels > 0 {
        let exact = &measured.metrics.exact;
        reasons.push(format!("{} pixels differ by up to {}", exact.pixels, short(exact.max_abs)));
        Verdict::Within
    } else {
        Verdict::Equal
    };
    let metrics = Some(measured.metrics.clone());
    (FileResult { name: name.to_owned(), verdict, reasons, metrics }, Some(measured))
}

fn depth_reason(expected: SampleKind, actual: SampleKind) -> String {
    format!("expected {expected} a channel, actual {actual}")
}

/// Why a stored file is larger than it must be.
fn oversize(stored: &[u8], thresholds: &Thresholds, limits: &Limits) -> Option<String> {
    let most = thresholds.max_bytes.unwrap_or(DEFAULT_MAX_BYTES);
    if stored.len() as u64 > most {
        return Some(format!("{} bytes are stored, {most} are allowed (max_bytes)", stored.len()));
    }
    if stored.len() < OVERSIZE_FROM || !stored.starts_with(b"\x89PNG") {
        return None;
    }
    let small = |effort| match compress_png(stored, effort, limits) {
        Ok(bytes) => Some(bytes.len()),
        Err(CompressError::Animated | CompressError::Decode(_)) => None,
    };
    let quick = small(Effort::Quick)?;
    let too_large = |best: usize| stored.len() as f64 > OVERSIZE * best as f64;
    // Zopfli takes seconds, and gains less than the margin: it is only asked about files that the quick search beats.
    let best = if too_large(quick) || stored.len() <= quick { quick } else { small(Effort::Strongest)? };
    too_large(best).then(|| {
        format!("{} bytes are stored, {best} would do: accept it again to compress it", stored.len())
    })
}
