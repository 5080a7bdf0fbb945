//! The stages between a scene and radiance: [`geometry`] fills tiles, [`raster`] finds which sample sees which triangle,
//! [`gbuffer`] makes surface fragments of them, [`shade`] evaluates them under [`light`] and [`shadow`]. The package
//! `overcoat-render` puts them in order; applications use the package `overcoat`.

pub mod bvh;
pub mod gbuffer;
pub mod geometry;
pub mod light;
pub mod raster;
pub mod shade;
pub mod shadow;
pub mod splat;
pub mod tile;
