//! Physics of `overcoat::coat::filament`.
