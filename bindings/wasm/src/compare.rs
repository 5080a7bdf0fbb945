//! Two pictures held against each other, by the rules of `overcoat golden`.

use crate::{about_options, limits, sentence};
use overcoat::decode::DecodedPicture;
use overcoat::golden::check::compare_all_frames;
use overcoat::golden::thresholds::{ThresholdFile, Thresholds};
use serde_json::json;
use wasm_bindgen::JsValue;
use wasm_bindgen::prelude::wasm_bindgen;

/// Compares two picture files. `thresholds` is the text of a `thresholds.toml`, or empty: then every pixel must be equal.
/// Returns a JSON object: whether that is good, the verdict, the reasons, and the measures.
///
/// # Errors
/// If a file is no picture, or the thresholds are wrong.
#[wasm_bindgen]
pub fn compare(
    name: &str,
    expected: &[u8],
    actual: &[u8],
    thresholds: &str,
    limits: &str,
) -> Result<String, JsValue> {
    let limits = limits::read(limits).map_err(about_options)?;
    let decode = |side: &str, bytes: &[u8]| {
        DecodedPicture::from_bytes(bytes, &limits).map_err(|e| sentence(format!("{name}, {side}: {e}")))
    };
    let (expected, actual) = (decode("expected", expected)?, decode("actual", actual)?);
    let rules = ThresholdFile::parse(thresholds);
    if let Some(problem) = rules.problems().first() {
        return Err(about_options(format!("thresholds, line {}: {}", problem.line, problem.message)));
    }
    let thresholds = rules.of(name, &Thresholds::default());
    let (result, _, _) = compare_all_frames(name, &expected, &actual, &thresholds);
    let metrics = result.metrics.as_ref().map(|m| {
        // JSON has no infinity: two equal pictures have no ratio of signal to noise.
        let psnr = Some(m.psnr).filter(|v| v.is_finite());
        json!({
            "max_abs": m.exact.max_abs,
            "pixels": m.exact.pixels,
            "psnr": psnr,
            "ssim": m.ssim,
            "flip_mean": m.flip_mean,
            "flip_max": m.flip_max,
        })
    });
    let found = json!({
        "good": result.verdict.is_good(),
        "verdict": result.verdict.name(),
        "reasons": result.reasons,
        "metrics": metrics,
    });
    Ok(found.to_string())
}
