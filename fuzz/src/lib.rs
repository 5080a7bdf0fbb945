//! Fuzz targets: see README.md beside this package.

pub mod seeds;
pub mod targets;
