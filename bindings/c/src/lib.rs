//! overcoat for C and C++.
//!
//! The interface is `include/overcoat.h`, which is made of these sources: their documentation is that of the header. Nothing is
//! drawn here: every function turns arguments into those of the library, calls it, and turns what comes back.
//!
//! No panic leaves a function ([`context::run`]), and no pointer of a caller is looked at but in `raw.rs`.

mod context;
mod instances;
mod material_files;
mod materials;
mod meshes;
mod picture;
mod raw;
mod status;
mod world;

pub use context::*;
pub use instances::*;
pub use material_files::*;
pub use materials::*;
pub use meshes::*;
pub use picture::*;
pub use status::overcoat_status;
pub use world::*;
