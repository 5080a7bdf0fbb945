//! Filament: `filament_*` and `filament2018`.

use super::table::Adapter;

pub const ADAPTERS: &[Adapter] = &[];
