//! The splats of a picture: projected, sorted, and given to the tiles.

use super::budget::FrameBudget;
use super::timed_pool::TimedPool;
use overcoat_core::built::Splats;
use overcoat_scene::{Scene, SplatCloud, SplatColorSpace, SplatOrder};
use overcoat_stages::geometry::View;
use overcoat_stages::splat::{CloudView, ScreenSplat, sort_by_distance};
use overcoat_stages::tile::{ChunkBins, Run, TileBins, TileGrid};
use std::ops::Range;

/// Splats of one cloud that are projected in one go; a power of two.
const SPLATS_PER_CHUNK: usize = 4096;

/// Bits of a splat's number that count within its chunk.
const CHUNK_BITS: u32 = SPLATS_PER_CHUNK.trailing_zeros();

/// Neighbours in the order of distance that are given to tiles in one go: so many that a list of tiles weighs little.
const SPLATS_PER_BIN: usize = 1 << 14;

/// Memory that is kept from one picture to the next.
#[derive(Debug, Default)]
pub struct SplatMemory {
    chunks: Vec<SplatChunk>,
    /// Bits of the distance, and the number: that of the chunk and that in the chunk.
    order: Vec<u64>,
    spare: Vec<u64>,
    bins: Vec<SplatBin>,
    tiles: TileBins,
}

/// Some splats of one instance.
#[derive(Debug, Default)]
struct SplatChunk {
    instance: usize,
    range: Range<usize>,
    /// Splats that are seen.
    splats: Vec<ScreenSplat>,
}

/// Some splats that follow each other in the order of distance.
#[derive(Debug, Default)]
struct SplatBin {
    range: Range<usize>,
    bins: ChunkBins,
}

/// The splats of a picture.
#[derive(Clone, Copy)]
pub struct SplatScene<'a> {
    memory: &'a SplatMemory,
    /// Colours are blended, and come, as linear light.
    pub is_linear: bool,
    /// Distances are from the camera and not along the view direction.
    pub by_distance: bool,
    /// The camera has a perspective.
    pub perspective: bool,
    /// Pixels at a distance of 1.
    pub focal: [f32; 2],
    /// Principal point, to the right of and below the middle, in pixels.
    principal: [f32; 2],
}

impl SplatMemory {
    /// Projects, sorts and bins all splats of a scene. Once the budget is spent the rest is left out, and there will be no
    /// picture.
    pub fn prepare(
        &mut self,
        pool: &mut TimedPool<'_>,
        scene: &Scene,
        view: &View,
        grid: &TileGrid,
        budget: &FrameBudget,
    ) {
        if !Splats::IS_BUILT {
            return;
        }
        let order = if by_distance(scene, view) { SplatOrder::Distance } else { SplatOrder::Depth };
        let space = if is_linear(scene) { SplatColorSpace::Linear } else { SplatColorSpace::Srgb };
        let mut count = 0;
        for (instance, cloud) in clouds(scene).enumerate() {
            for start in (0..cloud.len()).step_by(SPLATS_PER_CHUNK) {
                if count == self.chunks.len() {
                    self.chunks.push(SplatChunk::default());
                }
                self.chunks[count].instance = instance;
                self.chunks[count].range = start..cloud.len().min(start + SPLATS_PER_CHUNK);
                count += 1;
            }
        }
        self.chunks.truncate(count);
        pool.for_each_mut(&mut self.chunks, |_, chunk| {
            chunk.splats.clear();
            if budget.is_spent() {
                return;
            }
            let instance = &scene.splat_instances()[chunk.instance];
            let cloud = &scene.splats()[instance.cloud.index()];
            let cloud = CloudView::new(cloud, &instance.transform, instance.object, view, order, space);
            chunk.splats.extend(chunk.range.clone().filter_map(|index| cloud.project(index)));
        });
        self.sort();
        self.bin(pool, grid, budget);
    }

    /// The splats of the scene and the view that were prepared last.
    pub fn of(&self, scene: &Scene, view: &View) -> SplatScene<'_> {
        SplatScene {
            memory: self,
            is_linear: Splats::IS_BUILT && is_linear(scene),
            by_distance: Splats::IS_BUILT && by_distance(scene, view),
            perspective: view.perspective,
            focal: view.scale.map(|v| v as f32),
            principal: view.principal.map(|v| v as f32),
        }
    }

    fn sort(&mut self) {
        self.order.clear();
        for (number, chunk) in self.chunks.iter().enumerate() {
            let first = (number as u64) << CHUNK_BITS;
            let numbered = (first..).zip(&chunk.splats);
            self.order
                .extend(numbered.map(|(number, splat)| u64::from(splat.distance.to_bits()) << 32 | number));
        }
        sort_by_distance(&mut self.order, &mut self.spare);
    }

    fn bin(&mut self, pool: &mut TimedPool<'_>, grid: &TileGrid, budget: &FrameBudget) {
        let (chunks, order) = (&self.chunks, &self.order);
        self.bins.resize_with(order.len().div_ceil(SPLATS_PER_BIN), SplatBin::default);
        for (number, bin) in self.bins.iter_mut().enumerate() {
            let start = number * SPLATS_PER_BIN;
            bin.range = start..order.len().min(start + SPLATS_PER_BIN);
        }
        let columns = grid.columns();
        let tiles = |splat: &ScreenSplat, side: u32| {
            let [left, top, right, bottom] = splat.pixel_box();
            [left / side, top / side, (right - 1) / side + 1, (bottom - 1) / side + 1]
        };
        pool.for_each_mut(&mut self.bins, |_, bin| {
            let numbers = &order[bin.range.clone()];
            let splats = || numbers.iter().map(|&item| (item as u32, splat_of(chunks, item as u32)));
            let references = splats().map(|(_, splat)| {
                let [left, top, right, bottom] = tiles(splat, budget.side());
                u64::from(right - left) * u64::from(bottom - top)
            });
            bin.bins.clear();
            if !budget.charge_splat_references(references.sum()) {
                return;
            }
            bin.bins.collect(grid.len(), |each| {
                for (number, splat) in splats() {
                    let [left, top, right, bottom] = tiles(splat, grid.side());
                    for row in top..bottom {
                        for column in left..right {
                            each(row * columns + column, number);
                        }
                    }
                }
            });
        });
        self.tiles.build(grid.len(), self.bins.iter().map(|bin| &bin.bins));
    }
}

/// The clouds of a scene, one for each instance.
fn clouds(scene: &Scene) -> impl Iterator<Item = &SplatCloud> {
    scene.splat_instances().iter().map(|instance| &scene.splats()[instance.cloud.index()])
}

/// True if splats are sorted by their distance from the camera: one order for all clouds.
fn by_distance(scene: &Scene, view: &View) -> bool {
    view.perspective && clouds(scene).all(|cloud| cloud.order() == SplatOrder::Distance)
}

/// True if splats are blended as linear light: one way for all clouds.
fn is_linear(scene: &Scene) -> bool {
    clouds(scene).all(|cloud| cloud.color_space() == SplatColorSpace::Linear)
}

/// The splat of that number.
#[inline(always)]
fn splat_of(chunks: &[SplatChunk], number: u32) -> &ScreenSplat {
    &chunks[number as usize >> CHUNK_BITS].splats[number as usize & (SPLATS_PER_CHUNK - 1)]
}

impl<'a> SplatScene<'a> {
    /// Number of splats that may be seen.
    pub fn count(&self) -> usize {
        self.memory.order.len()
    }

    /// All of them, the nearest first.
    pub fn in_order(&self) -> impl Iterator<Item = &'a ScreenSplat> + use<'a> {
        let memory = self.memory;
        memory.order.iter().map(|&item| splat_of(&memory.chunks, item as u32))
    }

    /// Runs of a tile's splats, the nearest first.
    pub fn runs(&self, tile: usize) -> &'a [Run] {
        if !Splats::IS_BUILT || self.memory.order.is_empty() { &[] } else { self.memory.tiles.runs(tile) }
    }

    /// The numbers of one part.
    pub fn numbers(&self, run: &Run) -> &'a [u32] {
        self.memory.bins[run.chunk as usize].bins.triangles(run)
    }

    /// The splat of a number.
    #[inline(always)]
    pub fn splat(&self, number: u32) -> &'a ScreenSplat {
        splat_of(&self.memory.chunks, number)
    }

    /// Prefetches a splat. Changes no result.
    #[inline(always)]
    pub fn prefetch(&self, number: u32) {
        let splats = &self.memory.chunks[number as usize >> CHUNK_BITS].splats;
        prefetch_index::prefetch_index(splats, number as usize & (SPLATS_PER_CHUNK - 1));
    }

    /// Length of the ray through a place on the screen, in pixels from the middle, to a distance of 1 along the view
    /// direction; 1 where distances are along that direction.
    #[inline(always)]
    fn ray(&self, [x, y]: [f32; 2]) -> f32 {
        if self.by_distance {
            let ([fx, fy], [cx, cy]) = (self.focal, self.principal);
            let (x, y) = ((x - cx) / fx, (y - cy) / fy);
            (x * x + y * y + 1.0).sqrt()
        } else {
            1.0
        }
    }

    /// The depth of a splat at a place on the screen, to be compared with those of surfaces.
    #[inline(always)]
    pub fn depth(&self, splat: &ScreenSplat, place: [f32; 2]) -> f32 {
        if self.perspective { self.ray(place) / splat.distance } else { -splat.distance }
    }

    /// Distance of a splat along the view direction.
    pub fn distance(&self, splat: &ScreenSplat) -> f32 {
        splat.distance / self.ray(splat.center)
    }
}
