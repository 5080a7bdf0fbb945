//! Physics of the shading models, and what their pictures show.
//!
//! One binary of many files, each a promise: linking takes longer than most of them run.

#[allow(dead_code, reason = "other tests use the rest")]
mod common;
mod energy;
mod errata;
mod lambert;
mod models;
mod paint;
