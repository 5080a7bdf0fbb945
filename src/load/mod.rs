//! Bytes to scenes. Every reference to another file goes through one [`Resolver`], every count through
//! [`Limits`]. `load` ends where `scene` begins: what comes out is valid.
//!
//! Partial loss (an extension that is not known, a texture that cannot be read) is a [`Warning`] that names what was
//! dropped; a file that cannot be drawn as meant is a [`LoadError`].

mod budget;
mod environment;
mod error;
mod gltf;
mod image;
mod normals;
mod obj;
mod plain;
mod ply;
mod polygon;
mod resolver;
mod stl;
mod tangents;
mod text;
mod vertices;
mod warnings;

pub use environment::{load as load_environment, load_file as load_environment_file};
pub use error::{LoadError, Warning};
pub use resolver::{DirectoryResolver, MemoryResolver, NoResolver, ResolveError, Resolver};

use crate::jobs::Jobs;
use crate::limits::Limits;
use crate::scene::Scene;

/// A scene and what was lost on the way.
#[derive(Clone, Debug)]
pub struct Loaded {
    /// The scene.
    pub scene: Scene,
    /// What the file asks for and the scene does not have, in the order of finding.
    pub warnings: Vec<Warning>,
}

/// What every loader works with.
#[derive(Clone, Copy)]
pub struct Context<'a> {
    /// The only way to other files.
    pub resolver: &'a dyn Resolver,
    /// Bounds on every count.
    pub limits: &'a Limits,
    /// Threads for decoding images and the like.
    pub jobs: &'a Jobs,
}
