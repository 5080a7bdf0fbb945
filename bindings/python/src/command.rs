//! The command line, in the process of Python.

use crate::arithmetic::DefaultArithmetic;
use pyo3::prelude::*;
use std::ffi::OsString;

/// Runs the command line with these arguments, of which the first is the program's name, and returns its exit code.
#[pyfunction]
pub(crate) fn run_command(py: Python<'_>, arguments: Vec<OsString>) -> u8 {
    py.detach(|| {
        let _arithmetic = DefaultArithmetic::new();
        overcoat_cli::run_arguments(arguments)
    })
}
