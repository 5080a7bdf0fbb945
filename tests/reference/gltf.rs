//! The Khronos renderer: `gltf_khronos_*`.

use super::table::Adapter;

pub const ADAPTERS: &[Adapter] = &[];
