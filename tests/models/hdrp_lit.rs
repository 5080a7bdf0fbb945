//! Physics of `overcoat::coat::hdrp_lit`.
