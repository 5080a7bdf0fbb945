//! three.js: `threejs_*`.

use super::table::Adapter;

pub const ADAPTERS: &[Adapter] = &[];
