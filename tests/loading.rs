//! Files to scenes: formats, materials, hostile files.
//!
//! One binary of many files, each a promise: linking takes longer than most of them run.

mod assets;
mod attacks;
#[allow(dead_code, reason = "other tests use the rest")]
mod common;
mod formats;
mod fuzz_corpus;
mod gltf;
mod materials;
