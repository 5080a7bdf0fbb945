//! Drawing tile by tile: options and limits, what is prepared for all tiles, and a pass over one of them, from its bins to its
//! pixels ([`tile_pass::render_tile`]), generic over lanes. The packages `overcoat-tiles-sse2`, `-avx2` and `-avx512` are
//! that pass compiled for an instruction set each, so that they build beside each other; `overcoat-render` puts the passes of a
//! picture in order.

pub mod aov;
pub mod budget;
pub mod center_place;
pub mod clock;
pub mod draws;
pub mod edges;
pub mod effects;
pub mod ground;
pub mod ground_lamps;
pub mod ground_light;
mod ground_part;
pub mod ground_pixels;
pub mod lamps;
pub mod light_filter;
pub mod light_pool;
pub mod mirror;
pub mod occlusion;
pub mod options;
pub mod pass;
pub mod quality;
mod reach;
pub mod relief;
mod resolve;
mod shading_order;
pub mod shading_rate;
mod splat_layers;
mod splat_tile;
pub mod splats;
pub mod strips;
mod tile_blending;
mod tile_light;
pub mod tile_pass;
mod tile_shading;
mod tile_store;
mod tile_triangles;
mod tile_visibility_buffer;
pub mod timed_pool;
pub mod trace;
mod traced_scene;
pub mod work;

/// The one function of a package for an instruction set: [`tile_pass::render_tile`] compiled for it. The words are the macro of
/// `overcoat_core` that says whether it is compiled in, the function that finds its lanes, and its [level](overcoat_core::math::lanes::SimdLevel).
#[macro_export]
macro_rules! render_tile_on {
    ($with:ident, $lanes:ident, $level:ident) => {
        /// [`overcoat_tiles::tile_pass::render_tile`] on this instruction set.
        ///
        /// # Panics
        /// If it is not compiled in or the machine lacks it: `SimdLevel::is_available` is asked first.
        #[allow(unused_variables, reason = "where it is not compiled in")]
        pub fn render_tile(
            pass: &$crate::pass::Pass<'_>,
            tile: &$crate::pass::Tile<'_>,
            scratch: &mut $crate::tile_pass::TileScratch,
            rows: &mut $crate::strips::TileRows<'_>,
            job: &mut $crate::tile_pass::TileJob,
        ) {
            overcoat_core::$with! {
                use overcoat_core::math::lanes::{Lanes, SimdLevel, $lanes};
                if let Some(lanes) = $lanes(SimdLevel::$level) {
                    return lanes.run(
                        #[inline(always)]
                        || $crate::tile_pass::render_tile(lanes, pass, tile, scratch, rows, job),
                    );
                }
            }
            unreachable!("the instruction set was checked before")
        }
    };
}
