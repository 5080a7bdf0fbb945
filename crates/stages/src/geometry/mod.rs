//! Scene to screen: transform, clip, cull, snap, bin.
//!
//! Each draw is cut into chunks of a fixed number of triangles, lines or points. A chunk is worked on by one thread, from positions to
//! binned screen triangles; its result depends on nothing but the draw.

mod chunk;
mod clip;
mod edges;
mod lines;
mod points;
mod vertex;
mod view;

pub use chunk::{Chunk, ChunkJob, ClippedPiece, TRIANGLES_PER_CHUNK, process_chunk};
pub use edges::{EdgeView, process_edges};
pub use lines::process_lines;
pub use points::{PointView, process_points};
pub use vertex::{ScreenVertex, ScreenVertexSlice, ScreenVertices, VERTICES_PER_CHUNK, transform_vertices};
pub use view::{DrawView, View};
