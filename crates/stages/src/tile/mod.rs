//! The picture cut into tiles, and which triangles each tile may see.

mod bins;
mod grid;

pub use bins::{ChunkBins, Run, TileBins};
pub use grid::TileGrid;
