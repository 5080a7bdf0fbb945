//! Triangles of one chunk: gather, cull, clip, set up, bin.

use super::clip::clip;
use super::{DrawView, ScreenVertex};
use crate::each;
use crate::math::lanes::{Lanes, Scalar};
use crate::raster::{NOT_CLIPPED, Outline, SamplePattern, SmallTriangle, TileOrigin, Triangle};
use crate::scene::Mesh;
use crate::tile::{ChunkBins, TileGrid};
use std::ops::Range;

/// Triangles of a chunk, whatever the number of threads.
pub const TRIANGLES_PER_CHUNK: usize = 4096;

/// What one chunk is made from.
#[derive(Clone, Copy, Debug)]
pub struct ChunkJob<'a> {
    /// The mesh of the draw.
    pub mesh: &'a Mesh,
    /// Its vertices on the screen.
    pub vertices: &'a [ScreenVertex],
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
    /// Which draw the chunk belongs to.
    pub draw: u32,
    /// Which of the draw's triangles it holds.
    pub range: Range<usize>,
    /// Screen triangles, in the order of the mesh.
    pub triangles: Vec<Triangle>,
    /// For clipped pieces, the barycentric coordinates of their vertices in the whole triangle.
    pub clip_barycentrics: Vec<[[f32; 2]; 3]>,
    /// The tiles that may see each triangle.
    pub bins: ChunkBins,
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
    chunk.triangles.clear();
    chunk.clip_barycentrics.clear();
    chunk.bins.clear();
    // The screen's y points down: fronts, counter-clockwise in object space, have negative area there.
    let front_is_clockwise = job.mirrored;
    let screen = [
        -(grid.width() as i32) * 128,
        -(grid.height() as i32) * 128,
        grid.width() as i32 * 128,
        grid.height() as i32 * 128,
    ];
    for (indices, primitive) in
        job.mesh.triangles()[chunk.range.clone()].iter().zip(chunk.range.start as u32..)
    {
        if chunk.bins.len() > job.max_bins {
            break;
        }
        let [a, b, c] = each!(v in *indices => job.vertices[v as usize]);
        if a.x == ScreenVertex::OUTSIDE || b.x == ScreenVertex::OUTSIDE || c.x == ScreenVertex::OUTSIDE {
            process_clipped(chunk, job, *indices, primitive, front_is_clockwise, &screen, grid, pattern);
            continue;
        }
        let corners = [(a.x, a.y, a.depth), (b.x, b.y, b.depth), (c.x, c.y, c.depth)];
        let Some(outline) = Outline::new(corners) else { continue };
        let Some(bounds) = visible_bounds(l, &outline, job, &screen, pattern) else { continue };
        let triangle = outline.triangle(corners, primitive, NOT_CLIPPED, front_is_clockwise);
        emit(chunk, triangle, bounds, grid);
    }
    chunk.bins.sort();
}

/// Clips one triangle and emits the pieces of its fan.
#[cold]
fn process_clipped(
    chunk: &mut Chunk,
    job: &ChunkJob<'_>,
    indices: [u32; 3],
    primitive: u32,
    front_is_clockwise: bool,
    screen: &[i32; 4],
    grid: &TileGrid,
    pattern: &SamplePattern,
) {
    let positions = indices.map(|v| job.view.clip_vertex(job.mesh.positions()[v as usize]));
    let polygon = clip(positions, job.view.near, job.view.perspective);
    let [first, rest @ ..] = polygon.vertices() else { return };
    for pair in rest.windows(2) {
        let piece = [*first, pair[0], pair[1]];
        let corners = piece.map(|v| {
            let s = v.position.project(job.view.perspective);
            (s.x, s.y, s.depth)
        });
        let clip = chunk.clip_barycentrics.len() as u32;
        let Some(outline) = Outline::new(corners) else { continue };
        // Rare enough for the lanes of every processor.
        let Some(bounds) = visible_bounds(Scalar, &outline, job, screen, pattern) else { continue };
        let triangle = outline.triangle(corners, primitive, clip, front_is_clockwise);
        emit(chunk, triangle, bounds, grid);
        chunk.clip_barycentrics.push(piece.map(|v| v.barycentric));
    }
}

/// The box of a triangle that faces the right way and may hit a sample.
#[inline(always)]
fn visible_bounds<L: Lanes>(
    l: L,
    outline: &Outline,
    job: &ChunkJob<'_>,
    screen: &[i32; 4],
    pattern: &SamplePattern,
) -> Option<[i32; 4]> {
    // The screen's y points down: fronts, counter-clockwise in object space, have negative area there.
    if job.cull_back_faces && outline.swapped == job.mirrored {
        return None;
    }
    let bounds = outline.bounds();
    // Samples on the right and lower border belong to pixels beyond it. Tiles may reach further than the picture, so
    // they must not decide what is kept.
    if bounds[0] >= screen[2] || bounds[1] >= screen[3] || bounds[2] < screen[0] || bounds[3] < screen[1] {
        return None;
    }
    let corner = TileOrigin { x: screen[0], y: screen[1] };
    match SmallTriangle::new(outline.x, outline.y, bounds, corner, pattern) {
        Some(small) if small.misses_all_samples(l, pattern) => None,
        _ => Some(bounds),
    }
}

/// Keeps a triangle and bins it.
#[inline(always)]
fn emit(chunk: &mut Chunk, triangle: Triangle, bounds: [i32; 4], grid: &TileGrid) {
    let number = chunk.triangles.len() as u32;
    let [first_column, first_row, end_column, end_row] = grid.tiles_of_box(bounds);
    let columns = grid.columns();
    if end_column - first_column <= 2 && end_row - first_row <= 2 {
        for row in first_row..end_row {
            for column in first_column..end_column {
                chunk.bins.push(row * columns + column, number);
            }
        }
    } else {
        bin_large(&mut chunk.bins, &triangle, number, [first_column, first_row, end_column, end_row], grid);
    }
    chunk.triangles.push(triangle);
}

/// Bins a triangle that spans many tiles, leaving out those that lie beyond one of its edges.
#[cold]
fn bin_large(bins: &mut ChunkBins, triangle: &Triangle, number: u32, tiles: [u32; 4], grid: &TileGrid) {
    let side = i64::from(grid.side()) * 256;
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
    use crate::geometry::View;
    use crate::scene::{Camera, MeshData, Projection, Transform};

    /// What is kept of a triangle whose left corner, or upper one, is that many sub-pixels before the border.
    fn kept(side: u32, before: i32, below: bool) -> usize {
        let (width, height) = (32, 43);
        let grid = TileGrid::new(width, height, side);
        let near = |n: u32| n as i32 * 128 - before;
        let (x, y) = if below { (0, near(height)) } else { (near(width), 0) };
        let vertices: Vec<ScreenVertex> = [(x, y), (x + 600, y + 300), (x + 300, y + 900)]
            .map(|(x, y)| ScreenVertex { x, y, depth: 0.5 })
            .into();
        let data = MeshData {
            positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
            triangles: vec![[0, 1, 2]],
            ..MeshData::default()
        };
        let camera = Camera {
            eye: [0.0, 0.0, 1.0],
            target: [0.0; 3],
            up: [0.0, 1.0, 0.0],
            projection: Projection::Orthographic { height: 1.0 },
            near: 0.1,
        };
        let view = View::new(&camera, width, height).expect("valid");
        let mut chunk = Chunk { range: 0..1, ..Chunk::default() };
        let job = ChunkJob {
            mesh: &Mesh::new(data).expect("valid"),
            vertices: &vertices,
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
