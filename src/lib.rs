//! overcoat renders meshes to pictures on machines that have only a processor: no GPU, no display, no driver, no
//! network; and gives the same bytes on every machine.

pub mod brdf;
pub mod coat;
pub mod color;
pub mod frame;
pub mod gbuffer;
pub mod geometry;
pub mod golden;
pub mod jobs;
pub mod light;
pub mod limits;
pub mod load;
pub mod math;
pub mod output;
pub mod raster;
pub mod render;
pub mod scene;
pub mod shade;
pub mod tile;

#[cfg(feature = "cli")]
pub mod cli;
