//! OpenPBR: `openpbr_coat`.

use super::table::Adapter;

pub const ADAPTERS: &[Adapter] = &[];
