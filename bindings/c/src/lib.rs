//! overcoat for C and C++.
//!
//! The interface is `include/overcoat.h`, which is made of these sources: their documentation is that of the header. Nothing is
//! drawn here: every function turns arguments into those of the library, calls it, and turns what comes back.
//!
//! No panic leaves a function ([`context::run`]), and no pointer of a caller is looked at but in `raw.rs`.

mod camera;
mod context;
mod encode;
mod instances;
mod material_files;
mod material_values;
mod materials;
mod meshes;
mod picture;
mod planes;
mod raw;
mod status;
mod world;

pub use camera::*;
pub use context::*;
pub use encode::*;
pub use instances::*;
pub use material_files::*;
pub use material_values::*;
pub use materials::*;
pub use meshes::*;
pub use picture::*;
pub use planes::*;
pub use status::overcoat_status;
pub use world::*;
