//! Moving pictures of several.

use crate::errors::{self, Kind};
use crate::image::Image;
use overcoat::output::{MovieFormat, MovieFrame, durations, encode_movie as encode};
use pyo3::prelude::*;
use pyo3::types::PyBytes;

/// An animated PNG, WebP or GIF of pictures of one size, so many a second. `format` is an extension.
#[pyfunction]
pub(crate) fn encode_movie<'py>(
    py: Python<'py>,
    images: Vec<PyRef<'py, Image>>,
    format: &str,
    per_second: f64,
) -> PyResult<Bound<'py, PyBytes>> {
    let format = MovieFormat::from_extension(format).ok_or_else(|| {
        Kind::Option
            .error(format_args!("format '{format}': moving pictures are written as png, apng, webp and gif"))
    })?;
    if !(per_second.is_finite() && (0.01..=1000.0).contains(&per_second)) {
        return Err(
            Kind::Option.error(format_args!("fps {per_second}: expected 0.01 to 1000 pictures a second"))
        );
    }
    let over_white: Vec<_>;
    let shown: Vec<_> = if format == MovieFormat::Gif {
        over_white = images.iter().map(|image| image.shown_opaque(py)).collect();
        over_white.iter().collect()
    } else {
        images.iter().map(|image| image.shown(py)).collect()
    };
    let bytes = py.detach(|| {
        let alpha = shown.iter().any(|image| !image.is_opaque());
        let frames =
            shown.iter().map(|image| MovieFrame::new(image, format, alpha)).collect::<Result<Vec<_>, _>>()?;
        encode(&frames, &durations(frames.len(), per_second))
    });
    Ok(PyBytes::new(py, &bytes.map_err(|e| errors::output(&e))?))
}
