//! Arrays of numbers as attributes of meshes. What Python gives is of the right type and in one piece; what it says is checked
//! here and by the library.

use crate::errors::{self, Kind};
use numpy::{PyReadonlyArray2, PyUntypedArrayMethods};
use overcoat::scene::Transform;
use pyo3::prelude::*;

/// Rows of N numbers.
pub(crate) fn rows<T: numpy::Element + Copy, const N: usize>(
    what: &str,
    array: &PyReadonlyArray2<'_, T>,
) -> PyResult<Vec<[T; N]>> {
    let shape = array.shape();
    if shape[1] != N {
        let found = format_args!("({}, {})", shape[0], shape[1]).to_string();
        return Err(Kind::Mesh.error(format_args!("{what}: expected shape (N, {N}), found {found}")));
    }
    let values = array.as_slice().map_err(|error| Kind::Mesh.error(format_args!("{what}: {error}")))?;
    let (rows, _) = values.as_chunks::<N>();
    Ok(rows.to_vec())
}

/// The same of an array that need not be there.
pub(crate) fn optional_rows<T: numpy::Element + Copy, const N: usize>(
    what: &str,
    array: Option<PyReadonlyArray2<'_, T>>,
) -> PyResult<Vec<[T; N]>> {
    array.map_or_else(|| Ok(Vec::new()), |array| rows(what, &array))
}

/// (4, 4), object to world, in the way that columns are multiplied.
pub(crate) fn transform(matrix: &PyReadonlyArray2<'_, f64>) -> PyResult<Transform> {
    let found = rows::<f64, 4>("transform", matrix)?;
    let [first, second, third, ..] = *found.as_slice() else {
        return Err(
            Kind::Mesh.error(format_args!("transform: expected shape (4, 4), found ({}, 4)", found.len()))
        );
    };
    Transform::from_rows([first, second, third]).map_err(|e| errors::scene("transform", &e))
}
