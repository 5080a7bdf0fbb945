//! Physics of `overcoat::coat::velvet`.
