//! Arithmetic as the renderer needs it, in processes where others have changed it: see `overcoat_float_mode`.

pub(crate) use overcoat_float_mode::DefaultArithmetic;
use pyo3::pyfunction;

/// True if this thread rounds to nearest and keeps subnormal numbers.
#[pyfunction]
pub(crate) fn arithmetic_is_default() -> bool {
    overcoat_float_mode::is_default()
}
