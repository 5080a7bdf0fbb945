//! One pair of files compared, or a folder of them.

use super::GoldenError;
use super::metrics::exact::unmatched_planes;
use super::metrics::{Measured, Metrics, measure};
use super::thresholds::{Thresholds, pixels_differ, short};
use super::walk::{Pair, dotted, extension};
use overcoat_core::files::read_file;
use overcoat_core::limits::Limits;
use overcoat_image::decode::{DecodeError, DecodedPicture, FrameTime, SampleKind};
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Outcome of a comparison, from good to bad.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
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
    NoExpected,
    /// There is an expected picture and no actual one.
    NoActual,
    /// There is a table of the threshold file and no picture for it (strict checks).
    Unused,
    /// Something cannot be read or compared.
    Failed,
}

impl Verdict {
    /// True if nobody has to do anything.
    #[must_use]
    pub fn is_good(self) -> bool {
        matches!(self, Self::Equal | Self::Within)
    }

    /// All of them.
    pub const ALL: &[Self] = &[
        Self::Equal,
        Self::Within,
        Self::Differs,
        Self::Oversized,
        Self::NoExpected,
        Self::NoActual,
        Self::Unused,
        Self::Failed,
    ];

    /// True if there are two pictures that could be compared.
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
            Self::NoExpected => "no expected picture",
            Self::NoActual => "no actual picture",
            Self::Unused => "unused thresholds",
            Self::Failed => "failed",
        }
    }
}

/// Result of comparing the pictures of one name.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct FileResult {
    /// Path below the folders, with `/` between its parts.
    pub name: String,
    /// Outcome of the comparison.
    pub verdict: Verdict,
    /// Reasons for the verdict, a sentence each; for pictures that pass, what is worth knowing.
    pub reasons: Vec<String>,
    /// The measures, where both pictures could be read and have the same size; of moving pictures those of the frame that
    /// differs most.
    pub metrics: Option<Metrics>,
}

impl FileResult {
    /// A result without measures.
    #[must_use]
    pub fn new(name: &str, verdict: Verdict, reason: impl Into<String>) -> Self {
        Self { name: name.to_owned(), verdict, reasons: vec![reason.into()], metrics: None }
    }
}

/// Bad results order before good ones, then by what a person sees, then by the largest difference, then by name.
#[must_use]
pub fn badness_order(a: &FileResult, b: &FileResult) -> std::cmp::Ordering {
    let key = |r: &FileResult| {
        let m = r.metrics.as_ref();
        // What has no measures because the sizes differ is worse than what has.
        m.map_or((f64::INFINITY, 0.0), |m| (m.flip_mean, m.exact.max_abs))
    };
    let ((flip_a, abs_a), (flip_b, abs_b)) = (key(a), key(b));
    (!b.verdict.is_good())
        .cmp(&!a.verdict.is_good())
        .then(b.verdict.is_compared().cmp(&a.verdict.is_compared()).reverse())
        .then(flip_b.total_cmp(&flip_a))
        .then(abs_b.total_cmp(&abs_a))
        .then_with(|| a.name.cmp(&b.name))
}

/// A result with what it was made of, for reports.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Compared {
    /// The result.
    pub result: FileResult,
    /// The expected file and what it holds, if it can be read.
    pub expected: Option<(Vec<u8>, DecodedPicture)>,
    /// The actual file and what it holds, if it can be read.
    pub actual: Option<(Vec<u8>, DecodedPicture)>,
    /// The frame of moving pictures that the measures are of, from 0; 0 for still ones.
    pub frame: usize,
    /// The measures with the map of FLIP, as far as both can be compared.
    pub measured: Option<Measured>,
}

/// A file that was read and decoded, or why that failed; without bytes for a picture that is no file.
pub(super) type Side = Result<(Vec<u8>, DecodedPicture), DecodeError>;

/// Reads and decodes one side of a comparison.
pub(super) fn read_side(path: &Path, limits: &Limits) -> Side {
    decode_side(read_file(path, limits)?, limits)
}

/// Decodes one side of a comparison.
pub(super) fn decode_side(bytes: Vec<u8>, limits: &Limits) -> Side {
    let picture = DecodedPicture::from_bytes(&bytes, limits)?;
    Ok((bytes, picture))
}

/// Compares the two files of a name. `strict` also looks at how the expected file is stored.
#[must_use]
pub fn compare(pair: &Pair, thresholds: &Thresholds, strict: bool, limits: &Limits) -> Compared {
    if pair.unread && pair.problem.is_none() {
        let result = unread_result(pair);
        return Compared { result, expected: None, actual: None, frame: 0, measured: None };
    }
    let read = |path: &Option<PathBuf>| path.as_deref().map(|path| read_side(path, limits));
    let sides = [read(&pair.expected), read(&pair.actual)];
    compare_sides(&pair.name, sides, pair.problem.clone(), thresholds, strict, limits)
}

/// Result for files that differ and are not read, with the reason.
fn unread_result(pair: &Pair) -> FileResult {
    let files = match dotted(&extension(&pair.relative)) {
        none if none.is_empty() => "files without extension".to_owned(),
        extension => format!("{extension} files"),
    };
    let (verdict, how) = match (&pair.expected, &pair.actual) {
        (Some(_), Some(_)) => (Verdict::Differs, "the bytes differ"),
        (Some(_), None) => (Verdict::NoActual, "no actual file"),
        (None, _) => (Verdict::NoExpected, "no expected file"),
    };
    FileResult::new(&pair.name, verdict, format!("{how} ({files} are not read, so that nothing is measured)"))
}

/// Compares an expected and an actual picture, where there are such and they could be read. All comparisons come here.
pub(super) fn compare_sides(
    name: &str,
    [expected, actual]: [Option<Side>; 2],
    problem: Option<String>,
    thresholds: &Thresholds,
    strict: bool,
    limits: &Limits,
) -> Compared {
    let mut failures = Vec::new();
    let mut there = |side: Option<Side>, what: &str| {
        side?.map_err(|e| failures.push(format!("{what} picture: {e}"))).ok()
    };
    let expected = there(expected, "expected");
    let actual = there(actual, "actual");
    failures.extend(problem);

    let (mut measured, mut frame) = (None, 0);
    let result = if !failures.is_empty() {
        FileResult { name: name.to_owned(), verdict: Verdict::Failed, reasons: failures, metrics: None }
    } else {
        match (&expected, &actual) {
            (Some((stored, e)), Some((_, a))) => {
                let mut result;
                (result, measured, frame) = compare_all_frames(name, e, a, thresholds);
                if strict && let Some(reason) = oversize(stored, e, thresholds, limits) {
                    result.reasons.push(reason);
                    if result.verdict.is_good() {
                        result.verdict = Verdict::Oversized;
                    }
                }
                result
            }
            (Some(_), None) => FileResult::new(name, Verdict::NoActual, Verdict::NoActual.name()),
            (None, _) => FileResult::new(name, Verdict::NoExpected, Verdict::NoExpected.name()),
        }
    };
    Compared { result, expected, actual, frame, measured }
}

/// Frames whose differences are told one by one.
const TOLD: usize = 3;

/// Compares two pictures, or every frame of two moving ones with its time: all must be within the thresholds. Returns also
/// the measures of the frame that differs most, and which that is.
#[must_use]
pub fn compare_all_frames(
    name: &str,
    expected: &DecodedPicture,
    actual: &DecodedPicture,
    thresholds: &Thresholds,
) -> (FileResult, Option<Measured>, usize) {
    let (e, a) = match (&expected.motion, &actual.motion) {
        (None, None) => {
            let (result, measured) = compare_pictures(name, expected, actual, thresholds);
            return (result, measured, 0);
        }
        (Some(e), Some(a)) => (e, a),
        _ => {
            let reason = format!("expected {}, actual {}", expected.what_it_is(), actual.what_it_is());
            return (FileResult::new(name, Verdict::Differs, reason), None, 0);
        }
    };
    let mut reasons = Vec::new();
    if e.frames.len() != a.frames.len() {
        reasons.push(format!("expected {} frames, actual {}", e.frames.len(), a.frames.len()));
    }
    if e.plays != a.plays {
        reasons.push(format!("expected to play {}, actual {}", e.how_often(), a.how_often()));
    }
    let time =
        |time: Option<FrameTime>| time.map_or("outside of the animation".to_owned(), |t| t.to_string());
    let other_times: Vec<(usize, String)> = e
        .frames
        .iter()
        .zip(&a.frames)
        .enumerate()
        .filter(|(_, (e, a))| e.time != a.time)
        .map(|(k, (e, a))| (k, format!("expected {}, actual {}", time(e.time), time(a.time))))
        .collect();
    tell(&mut reasons, e.frames.len(), other_times);
    let mut other_pictures = Vec::new();
    let mut within = Vec::new();
    let mut worst: Option<(FileResult, Option<Measured>, usize)> = None;
    for k in 0..e.frames.len().min(a.frames.len()) {
        let (result, measured) = compare_pictures(name, &expected.frame(k), &actual.frame(k), thresholds);
        if measured.is_none() {
            // They have different sizes, as all others.
            return (result, None, k);
        }
        match result.verdict {
            Verdict::Equal => {}
            Verdict::Within => within.push((k, result.reasons.join("; "))),
            _ => other_pictures.push((k, result.reasons.join("; "))),
        }
        if worst.as_ref().is_none_or(|(most, ..)| badness_order(&result, most).is_lt()) {
            worst = Some((result, measured, k));
        }
    }
    tell(&mut reasons, e.frames.len(), other_pictures);
    let verdict = match (reasons.is_empty(), within.is_empty()) {
        (false, _) => Verdict::Differs,
        (true, false) => Verdict::Within,
        (true, true) => Verdict::Equal,
    };
    if verdict == Verdict::Within {
        tell(&mut reasons, e.frames.len(), within);
    }
    let (metrics, measured, frame) = worst.map_or((None, None, 0), |(r, m, k)| (r.metrics, m, k));
    (FileResult { name: name.to_owned(), verdict, reasons, metrics }, measured, frame)
}

/// Adds the reason of the first of the frames, and the number of further ones.
fn tell(reasons: &mut Vec<String>, of: usize, frames: Vec<(usize, String)>) {
    let more = frames.len().saturating_sub(TOLD);
    for (k, reason) in frames.into_iter().take(TOLD) {
        reasons.push(format!("frame {} of {of}: {reason}", k + 1));
    }
    if more > 0 {
        reasons.push(format!("and so on: {more} more frames"));
    }
}

/// Compares two still pictures by their thresholds.
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
                GoldenError::Size { .. } => Verdict::Differs,
                _ => Verdict::Failed,
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
    reasons.extend(thresholds.resolved(expected.kind).violations(&measured.metrics));
    let verdict = if !reasons.is_empty() {
        Verdict::Differs
    } else if measured.metrics.exact.pixels > 0 {
        let exact = &measured.metrics.exact;
        reasons.push(format!("{} by up to {}", pixels_differ(exact.pixels), short(exact.max_abs)));
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

/// Reason that a stored file is larger than it may be, or, with the feature `compress`, than it must be.
#[cfg_attr(not(feature = "compress"), allow(unused_variables))]
fn oversize(
    stored: &[u8],
    picture: &DecodedPicture,
    thresholds: &Thresholds,
    limits: &Limits,
) -> Option<String> {
    if let Some(most) = thresholds.max_bytes
        && stored.len() as u64 > most
    {
        return Some(format!("{} bytes are stored, {most} are allowed (max_bytes)", stored.len()));
    }
    #[cfg(feature = "compress")]
    return super::compress::oversize(stored, picture, limits);
    #[cfg(not(feature = "compress"))]
    None
}
