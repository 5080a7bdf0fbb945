//! What shading models are an approximation of ([`truth`]), and how far each is from it ([`lab`]). Applications use the package
//! `overcoat`.

pub mod lab;
pub mod truth;
