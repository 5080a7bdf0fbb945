//! The pass over a tile, compiled for AVX2: a package of its own, so that it builds beside those of other instruction sets.

#![cfg(target_arch = "x86_64")]

overcoat_tiles::render_tile_on!(with_avx2, avx2, Avx2);
