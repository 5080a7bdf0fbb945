//! Occlusion between surfaces and light: depth maps from many directions.
//!
//! Every map looks along one direction at the whole of the scene, so it knows nothing of the camera: a turntable makes them
//! once. What blocks light is a list of triangles in world space ([`Blockers`]); a map holds, for each of its texels, how far
//! towards the light the outermost of them reaches ([`DepthMap`]). Where a direction stands for light from around it, what lies
//! below everything has soft shadows (`pyramid.rs`).
//! Lamps have maps of their own, seen along a direction or from a point ([`LampMaps`]). Glass and blended surfaces block nothing:
//! they tint what passes ([`Tinted`], [`TintMaps`], [`LampTints`]).

mod blockers;
mod bounds;
mod clip;
mod depth_map;
mod disc;
mod draw;
mod enclosure;
mod facing;
mod lamp_filter;
mod lamp_maps;
mod of_scene;
mod pyramid;
mod repeated;
mod slab;
mod sliver;
#[cfg(test)]
mod tests;
mod tint_body;
mod tint_map;
mod tint_maps;
mod tinted;

pub use blockers::{Blockers, Cutout, Masked};
pub use depth_map::{DepthMap, DepthMaps};
pub use lamp_filter::Receiver;
pub use lamp_maps::{LampMaps, LampPlace, LampSource};
pub use of_scene::{Blocking, blocking_draws};
pub use pyramid::Pyramids;
pub use repeated::Repeated;
pub use tint_maps::{LampTints, TintMaps};
pub use tinted::{Tinted, textures_of_tint, tints};
