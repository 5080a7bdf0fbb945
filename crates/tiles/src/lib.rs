//! What a picture is drawn by, tile by tile: options and limits, what is prepared for all tiles, and a pass over one of them, from its
//! bins to its pixels ([`tile_pass::render_tile`]), generic over lanes. The packages `overcoat-tiles-sse2`, `-avx2` and `-avx512` are
//! that pass compiled for an instruction set each, so that they build beside each other; `overcoat-render` puts the passes of a
//! picture in order.

pub mod aov;
pub mod bands;
pub mod budget;
pub mod cancel;
pub mod clock;
pub mod crew;
pub mod draws;
pub mod effects;
pub mod ground;
pub mod ground_light;
pub mod ground_pixels;
pub mod lamps;
mod light_pool;
pub mod mirror;
pub mod options;
pub mod pass;
pub mod quality;
mod reach;
mod resolve;
mod shading_order;
pub mod shading_rate;
mod splat_layers;
mod splat_tile;
pub mod splats;
mod tile_blending;
mod tile_light;
pub mod tile_pass;
mod tile_shading;
mod tile_store;
mod tile_triangles;
mod tile_visibility;
pub mod trace;
mod visibility;
pub mod work;
