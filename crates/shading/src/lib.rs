//! Shading models as formulas over lanes: the terms of reflection ([`brdf`]), and the models of engines with their coats
//! ([`coat`]). They take lookups as parameters and know no scene. Applications use the package `overcoat`.

pub mod brdf;
pub mod coat;
