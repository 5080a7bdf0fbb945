//! Physics of the shading models.
//!
//! One binary of many files, each a promise: linking takes longer than most of them run.

mod energy;
mod models;
