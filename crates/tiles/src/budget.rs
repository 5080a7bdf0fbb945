//! Budget of the working memory of one frame.

use overcoat_core::limits::{LimitExceeded, Limits};
use overcoat_scene::{PrimitiveKind, Scene};
use overcoat_stages::geometry::{Chunk, ScreenVertex};
use overcoat_stages::splat::ScreenSplat;
use overcoat_stages::tile::TileGrid;
use std::sync::atomic::{AtomicU64, Ordering};

/// An instance: its matrices, a chunk, and the smallest lists.
const BYTES_PER_INSTANCE: u64 = 1024;

/// A point: its radius and normal, with what finding them takes for a while.
const BYTES_PER_POINT: u64 = 20;

/// A tile's reference to a triangle: as it is found, sorted, and the run that it may be alone in.
const BYTES_PER_REFERENCE: u64 = 24;

/// A splat: as it is projected, and twice in the order of all.
const BYTES_PER_SPLAT: u64 = size_of::<ScreenSplat>() as u64 + 16;

/// A tile's reference to a splat, and its part of the lists of runs.
const BYTES_PER_SPLAT_REFERENCE: u64 = 8;

/// Bytes that a frame takes so far, on all threads. Whether the sum exceeds the limit does not depend on the order of what
/// is added, nor on the tiles that the user chooses; once it does, the rest is skipped and there is no picture.
pub struct FrameBudget {
    spent: AtomicU64,
    limit: u64,
    /// The tiles of the picture if the user chooses none.
    grid: TileGrid,
}

impl FrameBudget {
    /// Charges what is known before anything is made: instances, their vertices, points and splats.
    ///
    /// # Errors
    /// [`LimitExceeded`] if that is more than is allowed.
    pub fn new(scene: &Scene, limits: &Limits, grid: TileGrid) -> Result<Self, LimitExceeded> {
        let vertex = ScreenVertex::BYTES as u64;
        let bytes = scene.instances().iter().fold(0_u64, |sum, instance| {
            let mesh = &scene.meshes()[instance.mesh.index()];
            let own = match mesh.kind() {
                PrimitiveKind::Triangles => mesh.positions().len() as u64 * vertex,
                PrimitiveKind::Lines => 0,
                PrimitiveKind::Points => mesh.positions().len() as u64 * BYTES_PER_POINT,
            };
            sum.saturating_add(own + BYTES_PER_INSTANCE)
        });
        let bytes = bytes.saturating_add(scene.splat_count().saturating_mul(BYTES_PER_SPLAT));
        let budget = Self { spent: AtomicU64::new(bytes), limit: limits.frame_bytes, grid };
        budget.check()?;
        Ok(budget)
    }

    /// Counts the references of those tiles alone that touch a box of pixels: [`TileGrid::listed_within`].
    pub fn list_within(&mut self, pixels: [u32; 4]) {
        self.grid = self.grid.listed_within(pixels);
    }

    /// True if nothing more may be added.
    pub fn is_spent(&self) -> bool {
        self.spent.load(Ordering::Relaxed) > self.limit
    }

    /// The tiles of the picture if the user chooses none: those whose references count.
    pub fn grid(&self) -> &TileGrid {
        &self.grid
    }

    /// Number of references to triangles that the tiles of `grid` may add: beyond that, those of the default tiles are
    /// too many as well.
    pub fn references(&self, grid: &TileGrid) -> u64 {
        let ratio = u64::from((self.grid.side() / grid.side()).max(1));
        let remaining = self.limit.saturating_sub(self.spent.load(Ordering::Relaxed));
        (remaining / BYTES_PER_REFERENCE).saturating_mul(ratio * ratio)
    }

    /// Adds a chunk that is set up for the tiles of `grid`. What is counted are the references of the default tiles.
    pub fn charge(&self, chunk: &Chunk, grid: &TileGrid) {
        let bytes = size_of_val(chunk.triangles.as_slice()) + size_of_val(chunk.pieces.as_slice());
        let pairs = if chunk.points {
            chunk.point_pairs
        } else if *grid == self.grid {
            chunk.bins.len() as u64
        } else {
            chunk.pairs_on(&self.grid)
        };
        self.spent.fetch_add(bytes as u64 + pairs * BYTES_PER_REFERENCE, Ordering::Relaxed);
    }

    /// Side of the default tiles in pixels.
    pub fn side(&self) -> u32 {
        self.grid.side()
    }

    /// Adds so many references of the default tiles to splats, which are not made yet; false if they are too many.
    pub fn charge_splat_references(&self, count: u64) -> bool {
        let bytes = count.saturating_mul(BYTES_PER_SPLAT_REFERENCE);
        self.spent.fetch_add(bytes, Ordering::Relaxed).saturating_add(bytes) <= self.limit
    }

    /// An error once too much was charged.
    pub fn check(&self) -> Result<(), LimitExceeded> {
        // How far the sum got depends on timing; that it is beyond the limit does not.
        if self.is_spent() {
            return Err(LimitExceeded::beyond("memory of one frame", self.limit, "frame_bytes"));
        }
        Ok(())
    }
}
