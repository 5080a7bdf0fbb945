//! Physics of `overcoat::coat::three`.
