//! What lies between surfaces and light: depth maps from many directions.
//!
//! Every map looks along one direction at the whole of the scene, so it knows nothing of the camera: a turntable makes them
//! once. What blocks light is a list of triangles in world space ([`Blockers`]); a map holds, for each of its texels, how far
//! towards the light the outermost of them reaches ([`DepthMap`]). Where few directions stand for light from all around, what lies
//! far from its blockers is asked for softly (`soft.rs`).

mod blockers;
mod depth_map;
mod draw;
mod of_scene;
mod soft;
#[cfg(test)]
mod tests;

pub use blockers::{Blockers, Cutout, Masked};
pub use depth_map::{DepthMap, DepthMaps};

pub static TUNE: std::sync::OnceLock<Vec<f32>> = std::sync::OnceLock::new();
pub fn tune(k: usize) -> f32 {
    TUNE.get_or_init(|| std::env::var("TUNE").unwrap_or_default().split(',').filter_map(|v| v.parse().ok()).collect()).get(k).copied().unwrap_or([1.0, 1.0, 1.0, 0.5, 2.0, 0.05][k])
}
