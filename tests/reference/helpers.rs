//! The pieces that Unity's models share: `helpers_*`.

use super::table::Adapter;

pub const ADAPTERS: &[Adapter] = &[];
