//! Physics of `overcoat::coat::stacklit`.
