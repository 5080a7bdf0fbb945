//! Formulas of the shading models: against tables of the engines, against physics and against the referee.
//!
//! One binary of many files, each a promise: linking takes longer than most of them run.

#[allow(dead_code, reason = "other tests use the rest")]
mod common;
mod energy;
mod errata;
mod lab;
mod lambert;
mod models;
mod paint;
mod reference;
mod reference_scene;
mod tables;
mod truth;
