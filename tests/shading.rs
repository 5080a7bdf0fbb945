//! Pictures of the shading models.
//!
//! One binary of many files, each a promise: linking takes longer than most of them run.

#[allow(dead_code, reason = "other tests use the rest")]
mod common;
mod errata;
mod lambert;
mod paint;
mod reference_scene;
