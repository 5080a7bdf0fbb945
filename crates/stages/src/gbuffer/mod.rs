//! From visibility to surfaces: one fragment per pixel and triangle, its attributes and their derivatives.
//!
//! Fragments live tile by tile in small structure-of-arrays batches that stay in the first-level cache; a full-screen
//! G-buffer exists only where a user asks for its planes.

mod batch;
mod fragments;
mod interpolate;
mod merge;
mod split;

pub mod layout;
pub mod texture;

pub use batch::{Batch, Draw, SourceTriangle, TriangleSource, VertexLanes};
pub use fragments::{Fragment, extract_fragments, push_masked_fragments};
pub use interpolate::{Location, locate};
pub use split::split_fragments;
