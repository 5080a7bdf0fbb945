//! Physics of every shading model: energy, reciprocity, limit cases, and no NaN anywhere. One file a model.

mod babylon;
mod draws;
mod filament;
mod gltf;
mod hdrp_lit;
mod one_lane;
mod openpbr;
mod stacklit;
mod stacklit_d;
mod standard;
mod three;
mod urp;
mod velvet;
