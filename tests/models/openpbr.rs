//! Physics of `overcoat::coat::openpbr`.
