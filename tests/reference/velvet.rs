//! Velvet and anisotropic GGX: `velvet_aniso`.

use super::table::Adapter;

pub const ADAPTERS: &[Adapter] = &[];
