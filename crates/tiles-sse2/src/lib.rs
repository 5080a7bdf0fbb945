//! The pass over a tile, compiled for SSE2: a package of its own, so that it builds beside those of other instruction sets.

#![cfg(target_arch = "x86_64")]

use overcoat_tiles::bands::TileRows;
use overcoat_tiles::pass::{Pass, Tile};
use overcoat_tiles::tile_pass::{TileJob, TileScratch};

/// [`overcoat_tiles::tile_pass::render_tile`] on SSE2.
///
/// # Panics
/// Where SSE2 is not compiled in, and on machines without it: `SimdLevel::is_available` is asked first.
#[allow(unused_variables, reason = "where it is not compiled in")]
pub fn render_tile(
    pass: &Pass<'_>,
    tile: &Tile<'_>,
    scratch: &mut TileScratch,
    rows: &mut TileRows<'_>,
    job: &mut TileJob,
) {
    overcoat_core::with_sse2! {
        use overcoat_core::math::lanes::{Lanes, SimdLevel, sse2};
        if let Some(lanes) = sse2(SimdLevel::Sse2) {
            return lanes.run(
                #[inline(always)]
                || overcoat_tiles::tile_pass::render_tile(lanes, pass, tile, scratch, rows, job),
            );
        }
    }
    unreachable!("the instruction set was checked before")
}
