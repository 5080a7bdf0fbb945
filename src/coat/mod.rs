//! Clear-coat shading models of engines, one file (or folder) per published model.
//!
//! A model is a set of pure functions over lanes: surface parameters, directions and light in, reflected
//! radiance out. It knows no scene and looks nothing up; the environment and pre-integrated tables come as
//! parameters.

pub mod filament;
pub mod filament_2018;
mod glsl;
pub mod gltf;
pub mod hdrp_lit;
pub mod openpbr;
pub mod stacklit;
pub mod three;
pub mod three_legacy;
pub mod urp;
pub mod velvet;
