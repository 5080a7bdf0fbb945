//! Light from afar that is given as an array.

use crate::errors::Kind;
use numpy::{PyReadonlyArray3, PyUntypedArrayMethods};
use overcoat::scene::EquirectImage;
use pyo3::prelude::*;
use std::sync::Arc;

/// Light from afar: (H, W, 3) float32, linear radiance of an equirectangular picture, row 0 at the zenith, contiguous.
///
/// Kept and given to several pictures it is filtered once, where an array is each time.
#[pyclass(frozen, module = "overcoat._overcoat")]
#[derive(Clone, Debug)]
pub(crate) struct Environment {
    pub(crate) image: Arc<EquirectImage>,
}

#[pymethods]
impl Environment {
    #[new]
    fn new(radiance: PyReadonlyArray3<'_, f32>) -> PyResult<Self> {
        let shape = radiance.shape();
        let [height, width, 3] = *shape else {
            return Err(
                Kind::Mesh.error(format_args!("environment: expected shape (H, W, 3), found {shape:?}"))
            );
        };
        let size = |side: usize| u32::try_from(side).unwrap_or(u32::MAX);
        let values = radiance.as_slice().map_err(|error| Kind::Mesh.error(error))?;
        if let Some(bad) = values.iter().find(|value| !value.is_finite()) {
            return Err(
                Kind::Mesh.error(format_args!("environment: {bad} is no radiance: expected finite numbers"))
            );
        }
        let pixels = values.chunks_exact(3).map(|p| [p[0], p[1], p[2]]).collect();
        let image = EquirectImage::new(size(width), size(height), pixels)
            .map_err(|error| Kind::Mesh.error(format_args!("environment: {error}")))?;
        Ok(Self { image: Arc::new(image) })
    }

    /// (height, width) in pixels.
    #[getter]
    fn shape(&self) -> (u32, u32) {
        (self.image.height(), self.image.width())
    }
}
