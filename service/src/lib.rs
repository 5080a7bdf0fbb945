//! overcoat for many files: `overcoat batch` and `overcoat serve`.
//!
//! Models are parsed in worker processes alone, which have no rights, limits of memory and time, and an end that nobody else
//! notices. This process hands them bytes and takes pictures.

// Options are documented by their help.
#[allow(missing_docs)]
pub mod batch;
pub mod common;
pub mod files;
pub mod key;
pub mod place;
pub mod pool;
// As are those of the service.
#[allow(missing_docs)]
pub mod serve;
