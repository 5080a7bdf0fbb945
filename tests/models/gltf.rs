//! Physics of `overcoat::coat::gltf`.
