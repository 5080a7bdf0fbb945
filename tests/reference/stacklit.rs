//! Unity HDRP StackLit: `stacklit_*` and `stacklit17_convert`.

use super::table::Adapter;

pub const ADAPTERS: &[Adapter] = &[];
