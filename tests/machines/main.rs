//! Small scenes that touch every stage: the same hashes on every machine.
//!
//! [`leaks`] renders random ones in every way that must not matter; [`machines`] compares curated ones with recorded
//! hashes, here and on other machines, and so what the [`referee`] says.

mod coverage;
mod curated;
mod dice;
mod examine;
mod files;
mod forms;
mod gltf;
mod invent;
mod keys;
mod leaks;
mod machines;
mod pictures;
mod plain;
mod recipe;
mod record;
mod referee;
mod shot;
mod shrink;

#[path = "../common/mod.rs"]
#[allow(dead_code, reason = "other tests use the rest")]
mod common;

use common::files::package;
use common::shapes;
