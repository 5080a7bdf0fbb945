//! The referee of shading models ([`truth`]), and the error of each model against it ([`lab`]). Applications use the package
//! `overcoat`.

pub mod lab;
pub mod truth;
