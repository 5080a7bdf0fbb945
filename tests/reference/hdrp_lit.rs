//! Unity HDRP Lit: `hdrp_lit_coat`.

use super::table::Adapter;

pub const ADAPTERS: &[Adapter] = &[];
