//! Pictures and their cost: the renderer through the public interface.
//!
//! One binary of many files, each a promise: linking takes longer than most of them run.

mod area_lights;
mod by_need;
mod clear_rays;
#[allow(dead_code, reason = "other tests use the rest")]
mod common;
mod data_sets;
mod defaults;
mod dense_mesh;
mod edges;
mod far_limit;
mod fill_rule;
mod intrinsics;
mod lamp_shadows;
mod limits;
mod renderer;
mod setting;
mod shading_rate;
mod specular_antialiasing;
mod splats;
mod targets;
mod tinted_shadows;
mod transmission;
mod visibility;
mod world;
