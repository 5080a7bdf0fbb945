//! Pictures of others within limits ([`decode`]), and frames as files ([`output`]). Applications use the package `overcoat`.

pub mod decode;
pub mod output;
