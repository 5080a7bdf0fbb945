//! Physics of every shading model: energy, reciprocity, limit cases, and no NaN anywhere. What models are asked for alike is in
//! `properties.rs`, the rest in one file a model.

mod babylon;
mod draws;
mod filament;
mod gltf;
mod hdrp_lit;
mod one_lane;
mod openpbr;
mod properties;
mod stacklit;
mod stacklit_d;
mod standard;
mod three;
mod urp;
mod velvet;
