//! Triangles of one chunk: gather, cull, clip, set up, bin.

use super::clip::clip;
use super::{DrawView, ScreenVertex, ScreenVertexSlice};
use crate::raster::{OutlineLanes, SUBPIXELS, SamplePattern, TileOrigin, Triangle};
use crate::tile::{ChunkBins, TileGrid};
use overcoat_core::each;
use overcoat_core::math::lanes::{Int, LANES, Lanes, Mask, Scalar};
use overcoat_scene::Mesh;
use std::ops::Range;

/// Triangles of a chunk, whatever the number of threads.
pub const TRIANGLES_PER_CHUNK: usize = 4096;

/// Input from which one chunk is made.
#[derive(Clone, Copy, Debug)]
pub struct ChunkJob<'a> {
    /// The mesh of the draw.
    pub mesh: &'a Mesh,
    /// Its vertices on the screen.
    pub vertices: ScreenVertexSlice<'a>,
    /// The draw's view.
    pub view: &'a DrawView,
    /// Drop triangles that are seen from behind.
    pub cull_back_faces: bool,
    /// The draw's transform mirrors: fronts are clockwise in object space.
    pub mirrored: bool,
    /// Stop soon after this many (tile, triangle) pairs: the picture is too much work and will not be finished.
    pub max_bins: usize,
}

/// The screen triangles of one chunk and the tiles that may see them.
#[derive(Clone, Debug, Default)]
pub struct Chunk {
    /// Number of the draw that the chunk belongs to.
    pub draw: u32,
    /// Range of the draw's triangles, lines or points that it holds.
    pub range: Range<usize>,
    /// True for points, of which nothing is kept but what the tiles may see.
    pub points: bool,
    /// Number of points that some tile may see.
    pub kept: u32,
    /// Number of (tile, point) pairs on the grid that work is counted by.
    pub point_pairs: u64,
    /// Screen triangles, in the order of the mesh.
    pub triangles: Vec<Triangle>,
    /// The clipped pieces among them, in the same order.
    pub pieces: Vec<ClippedPiece>,
    /// The tiles that may see each triangle.
    pub bins: ChunkBins,
}

/// Piece that clipping left of a triangle: a triangle itself, some of whose vertices are not the mesh's.
#[derive(Clone, Copy, Debug)]
pub struct ClippedPiece {
    /// Its number among the triangles of the chunk.
    pub number: u32,
    /// Barycentric coordinates of its vertices in the whole triangle.
    pub barycentrics: [[f32; 2]; 3],
}

impl Chunk {
    /// Forgets what it was filled with.
    pub(super) fn clear(&mut self) {
        self.triangles.clear();
        self.pieces.clear();
        self.bins.clear();
        (self.kept, self.point_pairs) = (0, 0);
    }

    /// For a clipped piece, the barycentric coordinates of its vertices in the whole triangle.
    #[inline(always)]
    #[must_use]
    pub fn clip(&self, number: u32) -> Option<&[[f32; 2]; 3]> {
        if self.triangles[number as usize].is_clipped() { self.find_piece(number) } else { None }
    }

    /// Number of (tile, triangle) pairs on a grid.
    #[must_use]
    pub fn pairs_on(&self, grid: &TileGrid) -> u64 {
        let mut bins = ChunkBins::default();
        let of = |triangle: &Triangle| {
            bins.clear();
            bin(&mut bins, triangle, 0, grid);
            bins.len() as u64
        };
        self.triangles.iter().map(of).sum()
    }

    #[cold]
    fn find_piece(&self, number: u32) -> Option<&[[f32; 2]; 3]> {
        let found = self.pieces.binary_search_by_key(&number, |piece| piece.number).ok()?;
        Some(&self.pieces[found].barycentrics)
    }
}

/// Fills a chunk from its range of a draw's triangles.
#[inline(always)]
pub fn process_chunk<L: Lanes>(
    l: L,
    chunk: &mut Chunk,
    job: &ChunkJob<'_>,
    grid: &TileGrid,
    pattern: &SamplePattern,
) {
    chunk.clear();
    let triangles = &job.mesh.triangles()[chunk.range.clone()];
    for sixteen in triangles.chunks(LANES) {
        // Of the last few, lanes beyond the end repeat the last triangle.
        let last = sixteen.len() - 1;
        let corners = each!(corner => l.unzip(each!(k =>
            job.vertices.places[sixteen[k.min(last)][corner] as usize])));
        let in_use = (2_u32 << last) - 1;
        let found = cull(l, corners, in_use as u16, job, grid, pattern);
        let mut left = found.lanes;
        while left != 0 {
            let k = left.trailing_zeros() as usize % LANES;
            left &= left - 1;
            if chunk.bins.len() > job.max_bins {
                return;
            }
            let indices = sixteen[k.min(last)];
            let corners = each!(v in indices => job.vertices.get(v));
            if found.outside >> k & 1 == 1 {
                process_clipped(chunk, job, indices, grid, pattern);
            } else if let Some(triangle) = found.triangle(k, corners, indices, job, grid) {
                emit(chunk, triangle, grid);
            }
        }
    }
    chunk.bins.sort();
}

/// Clips one triangle and emits the pieces of its fan.
#[cold]
fn process_clipped(
    chunk: &mut Chunk,
    job: &ChunkJob<'_>,
    indices: [u32; 3],
    grid: &TileGrid,
    pattern: &SamplePattern,
) {
    let positions = indices.map(|v| job.view.clip_vertex(job.mesh.positions()[v as usize]));
    let polygon = clip(positions, job.view.near, job.view.perspective);
    let [first, rest @ ..] = polygon.vertices() else { return };
    for pair in rest.windows(2) {
        let piece = [*first, pair[0], pair[1]];
        let corners = piece.map(|v| v.position.project(job.view.perspective));
        // Rare enough for the lanes of every processor, fifteen of them empty.
        let lanes = corners.map(|v| [Scalar.splat_i(v.x), Scalar.splat_i(v.y)]);
        let found = cull(Scalar, lanes, 1, job, grid, pattern);
        if found.lanes == 0 {
            continue;
        }
        if let Some(triangle) = found.triangle(0, corners, indices, job, grid) {
            let number = chunk.triangles.len() as u32;
            chunk.pieces.push(ClippedPiece { number, barycentrics: piece.map(|v| v.barycentric) });
            emit(chunk, triangle.clipped(), grid);
        }
    }
}

/// Result of culling sixteen triangles.
struct Survivors {
    /// Bits of the triangles that may be seen.
    lanes: u16,
    /// Bits of the triangles that have to be clipped first.
    outside: u16,
    /// Bits of the triangles that are too large for the lanes and are yet to be tested one by one.
    large: u16,
    /// Coverage of small triangles, see [`Triangle::small_samples`].
    small_samples: [[i32; LANES]; 4],
}

/// Drops triangles that are seen from behind, lie beside the picture or miss all samples.
#[inline(always)]
fn cull<L: Lanes>(
    l: L,
    corners: [[L::I; 2]; 3],
    in_use: u16,
    job: &ChunkJob<'_>,
    grid: &TileGrid,
    pattern: &SamplePattern,
) -> Survivors {
    let mark = l.splat_i(ScreenVertex::OUTSIDE);
    let outside = corners[0][0].eq(mark) | corners[1][0].eq(mark) | corners[2][0].eq(mark);
    let in_use = l.mask(in_use);
    let outline = OutlineLanes::new(l, corners);
    let known = in_use & outline.exact & !outside;
    let mut seen = known & outline.has_area;
    if job.cull_back_faces {
        // The screen's y points down: fronts, counter-clockwise in object space, have negative area there.
        seen = seen & if job.mirrored { !outline.swapped } else { outline.swapped };
    }
    let [left, top, right, bottom] = screen(grid);
    seen = seen
        & outline.bounds[0].lt(l.splat_i(right))
        & outline.bounds[1].lt(l.splat_i(bottom))
        & !outline.bounds[2].lt(l.splat_i(left))
        & !outline.bounds[3].lt(l.splat_i(top));
    let small = outline.small(l, seen, TileOrigin { x: left, y: top }, pattern);
    Survivors {
        lanes: ((seen & !small.misses(l)) | (in_use & !known)).bits(),
        outside: outside.bits(),
        large: (!outline.exact).bits(),
        small_samples: small.to_arrays(),
    }
}

impl Survivors {
    /// Sets up the triangle of a lane in which it may be seen.
    #[inline(always)]
    fn triangle(
        &self,
        lane: usize,
        corners: [ScreenVertex; 3],
        vertices: [u32; 3],
        job: &ChunkJob<'_>,
        grid: &TileGrid,
    ) -> Option<Triangle> {
        let corners = each!(v in corners => (v.x, v.y, v.depth));
        let mut triangle = Triangle::new(corners, vertices, job.mirrored)?;
        if self.large >> lane & 1 == 1 {
            let bounds = triangle.bounds();
            let [left, top, right, bottom] = screen(grid);
            let beside = bounds[0] >= right || bounds[1] >= bottom || bounds[2] < left || bounds[3] < top;
            if beside || (job.cull_back_faces && triangle.is_back_facing()) {
                return None;
            }
        }
        let [a, b, c, d] = each!(part in self.small_samples => part[lane] as u64);
        triangle.small_samples = a | b << 16 | c << 32 | d << 48;
        Some(triangle)
    }
}

/// The picture's borders in sub-pixels: left, top, and the ends. Samples on the right and lower border belong to pixels
/// beyond it. Tiles may reach further than the picture, so they must not decide what is kept.
#[inline(always)]
pub(super) fn screen(grid: &TileGrid) -> [i32; 4] {
    let [width, height] = [grid.width(), grid.height()].map(|side| side as i32 * (SUBPIXELS / 2));
    [-width, -height, width, height]
}

/// Keeps a triangle and bins it.
#[inline(always)]
pub(super) fn emit(chunk: &mut Chunk, triangle: Triangle, grid: &TileGrid) {
    bin(&mut chunk.bins, &triangle, chunk.triangles.len() as u32, grid);
    chunk.triangles.push(triangle);
}

/// Bins a triangle.
#[inline(always)]
fn bin(bins: &mut ChunkBins, triangle: &Triangle, number: u32, grid: &TileGrid) {
    let [first_column, first_row, end_column, end_row] = grid.tiles_of_box(triangle.bounds());
    let columns = grid.columns();
    if end_column - first_column <= 2 && end_row - first_row <= 2 {
        for row in first_row..end_row {
            for column in first_column..end_column {
                bins.push(row * columns + column, number);
            }
        }
    } else {
        bin_large(bins, triangle, number, [first_column, first_row, end_column, end_row], grid);
    }
}

/// Bins a triangle that spans many tiles, leaving out those that lie beyond one of its edges.
#[cold]
fn bin_large(bins: &mut ChunkBins, triangle: &Triangle, number: u32, tiles: [u32; 4], grid: &TileGrid) {
    let side = i64::from(grid.side()) * i64::from(SUBPIXELS);
    for row in tiles[1]..tiles[3] {
        for column in tiles[0]..tiles[2] {
            let tile = row * grid.columns() + column;
            let origin = grid.origin(tile as usize);
            let misses = (0..3).any(|k| {
                let next = if k == 2 { 0 } else { k + 1 };
                let a = i64::from(triangle.y[k] - triangle.y[next]);
                let b = i64::from(triangle.x[next] - triangle.x[k]);
                let at_corner =
                    a * i64::from(origin.x - triangle.x[k]) + b * i64::from(origin.y - triangle.y[k]);
                // The edge function at the tile's most favourable corner.
                at_corner + a.max(0) * side + b.max(0) * side < 0
            });
            if !misses {
                bins.push(tile, number);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{ScreenVertices, View};
    use overcoat_scene::{Camera, MeshData, Projection, Transform};

    /// Number of triangles that are kept, 0 or 1, of one whose left corner, or upper one, is `before` sub-pixels before
    /// the border.
    fn kept(side: u32, before: i32, below: bool) -> usize {
        let (width, height) = (32, 43);
        let grid = TileGrid::new(width, height, side);
        let near = |n: u32| n as i32 * (SUBPIXELS / 2) - before;
        let (x, y) = if below { (0, near(height)) } else { (near(width), 0) };
        let vertices: ScreenVertices = [(x, y), (x + 600, y + 300), (x + 300, y + 900)]
            .map(|(x, y)| ScreenVertex { x, y, depth: 0.5 })
            .into_iter()
            .collect();
        let data = MeshData::default().with(|d| {
            d.positions = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
            d.triangles = vec![[0, 1, 2]];
        });
        let camera = Camera::new(
            [0.0, 0.0, 1.0],
            [0.0; 3],
            [0.0, 1.0, 0.0],
            Projection::Orthographic { height: 1.0 },
            0.1,
        );
        let view = View::new(&camera, width, height).expect("valid");
        let mut chunk = Chunk { range: 0..1, ..Chunk::default() };
        let job = ChunkJob {
            mesh: &Mesh::new(data).expect("valid"),
            vertices: vertices.slice(0..3),
            view: &view.of_draw(&Transform::IDENTITY),
            cull_back_faces: false,
            mirrored: false,
            max_bins: usize::MAX,
        };
        process_chunk(Scalar, &mut chunk, &job, &grid, &SamplePattern::new(1).expect("valid"));
        chunk.triangles.len()
    }

    #[test]
    fn what_touches_the_picture_from_outside_is_dropped_by_tiles_of_every_size() {
        for side in [16, 32, 64] {
            for below in [false, true] {
                assert_eq!(kept(side, 0, below), 0, "tiles of {side}, below: {below}");
                assert_eq!(kept(side, 200, below), 1, "tiles of {side}, below: {below}");
            }
        }
    }
}
