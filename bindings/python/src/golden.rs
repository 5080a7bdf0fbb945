//! Goldens: pictures against those that were accepted.

use crate::errors::{self, Kind};
use crate::image::Image;
use numpy::{PyReadonlyArray3, PyUntypedArrayMethods};
use overcoat::Limits;
use overcoat::decode::DecodedPicture;
use overcoat::frame::DisplayImage;
use overcoat::golden::check::compare_all_frames;
use overcoat::golden::thresholds::{ThresholdFile, Thresholds};
use overcoat::golden::{Golden, GoldenError};
use pyo3::prelude::*;
use pyo3::pybacked::PyBackedBytes;
use pyo3::types::PyDict;
use std::path::PathBuf;

/// Picture that a test has drawn.
#[derive(FromPyObject)]
pub(crate) enum Actual<'py> {
    Image(PyRef<'py, Image>),
    /// (H, W, 4) bytes.
    Pixels(PyReadonlyArray3<'py, u8>),
    /// Bytes of a picture file.
    File(PyBackedBytes),
}

/// An array as a picture.
fn picture(array: &PyReadonlyArray3<'_, u8>) -> PyResult<DisplayImage> {
    let shape = array.shape();
    let [height, width, 4] = *shape else {
        return Err(Kind::Mesh.error(format_args!("picture: expected shape (H, W, 4), found {shape:?}")));
    };
    let values = array.as_slice().map_err(|error| Kind::Mesh.error(format_args!("picture: {error}")))?;
    let (pixels, _) = values.as_chunks::<4>();
    let side = |n: usize| u32::try_from(n).map_err(|_| Kind::Mesh.error("picture: it is too large"));
    Ok(DisplayImage { width: side(width)?, height: side(height)?, pixels: pixels.to_vec() })
}

/// Thresholds of the text of a threshold file.
fn thresholds(text: &str) -> PyResult<Thresholds> {
    let file = ThresholdFile::parse(text);
    match file.problems().first() {
        None => Ok(file.of("", &Thresholds::default())),
        Some(problem) => Err(Kind::Option.error(format_args!("thresholds: {}", problem.message))),
    }
}

/// Holds a picture against `folder/name`, or records it. A name of a file has its extension.
#[pyfunction]
pub(crate) fn golden_check(
    py: Python<'_>,
    folder: PathBuf,
    name: &str,
    actual: Actual<'_>,
    failures: Option<PathBuf>,
    update: bool,
    thresholds_text: &str,
) -> PyResult<()> {
    let mut golden = Golden::new(folder).updating(update).thresholds(thresholds(thresholds_text)?);
    if let Some(failures) = failures {
        golden = golden.failures_in(failures);
    }
    let checked: Result<(), GoldenError> = match &actual {
        Actual::Image(image) => {
            let shown = image.shown(py);
            py.detach(|| golden.check(name, shown))
        }
        Actual::Pixels(array) => {
            let picture = picture(array)?;
            py.detach(|| golden.check(name, &picture))
        }
        Actual::File(bytes) => py.detach(|| golden.check_file(name, bytes)),
    };
    checked.map_err(|e| errors::golden(&e))
}

/// How much two pictures differ: a dict of the measures that the command `overcoat golden check --json` prints.
#[pyfunction]
pub(crate) fn golden_compare<'py>(
    py: Python<'py>,
    expected: Actual<'py>,
    actual: Actual<'py>,
    thresholds_text: &str,
) -> PyResult<Bound<'py, PyDict>> {
    let decoded = |of: &Actual<'_>| -> PyResult<DecodedPicture> {
        Ok(match of {
            Actual::Image(image) => DecodedPicture::from(image.shown(py)),
            Actual::Pixels(array) => DecodedPicture::from(&picture(array)?),
            Actual::File(bytes) => py
                .detach(|| DecodedPicture::from_bytes(bytes, &Limits::default()))
                .map_err(|e| errors::golden(&e.into()))?,
        })
    };
    let (expected, actual, thresholds) =
        (decoded(&expected)?, decoded(&actual)?, thresholds(thresholds_text)?);
    let (result, ..) = py.detach(|| compare_all_frames("picture", &expected, &actual, &thresholds));
    let out = PyDict::new(py);
    out.set_item("verdict", result.verdict.name())?;
    out.set_item("ok", result.verdict.is_good())?;
    out.set_item("reasons", &result.reasons)?;
    if let Some(metrics) = &result.metrics {
        out.set_item("pixels", metrics.exact.pixels)?;
        out.set_item("max_abs", metrics.exact.max_abs)?;
        out.set_item("psnr", metrics.psnr)?;
        out.set_item("ssim", metrics.ssim)?;
        out.set_item("flip_mean", metrics.flip_mean)?;
        out.set_item("flip_max", metrics.flip_max)?;
    }
    Ok(out)
}
