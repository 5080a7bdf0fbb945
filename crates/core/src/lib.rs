//! Foundations of all packages of overcoat: arithmetic with the same bits on every machine ([`math`]), colour, frames, ordered
//! jobs, limits and names of formats. Applications use the package `overcoat`.

pub mod built;
pub mod color;
pub mod files;
pub mod formats;
pub mod frame;
pub mod jobs;
pub mod limits;
pub mod math;
pub mod reuse;
pub mod suggest;
