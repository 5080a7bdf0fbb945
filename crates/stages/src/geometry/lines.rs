//! Lines as triangles: bars that face the viewer, of a width in pixels.
//!
//! Each is cut where the near plane and the guard band cut it, and becomes two triangles on the screen whose corners are
//! the line's own vertices: attributes, depth, coverage and blending need to know nothing of lines. Bars end where their
//! lines do, without joints.

use super::chunk::{Chunk, ClippedPiece, emit, screen};
use super::vertex::ClipVertex;
use super::{ChunkJob, ScreenVertex};
use crate::raster::{GUARD_BAND, Triangle};
use crate::tile::TileGrid;

/// Appearance of a line on the screen.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bar {
    /// Half of its width in pixels.
    pub radius: f32,
    /// Pixels by which it is longer at each end.
    pub cap: f32,
    /// Shift towards the viewer, in pixels as large as those at its place.
    pub shift: f32,
    /// Pixels per unit: of x / distance in perspective, of x in orthographic views.
    pub scale: f32,
}

/// Fills a chunk from its range of a draw's lines, `width` pixels wide.
pub fn process_lines(chunk: &mut Chunk, job: &ChunkJob<'_>, width: f32, grid: &TileGrid) {
    chunk.clear();
    let bar = Bar { radius: 0.5 * width, cap: 0.0, shift: 0.0, scale: 1.0 };
    for &[a, b, _] in &job.mesh.triangles()[chunk.range.clone()] {
        if chunk.bins.len() > job.max_bins {
            return;
        }
        process_line(chunk, job, [a, b], &bar, grid);
    }
    chunk.bins.sort();
}

/// Adds the two triangles of one line.
pub(super) fn process_line(
    chunk: &mut Chunk,
    job: &ChunkJob<'_>,
    [a, b]: [u32; 2],
    bar: &Bar,
    grid: &TileGrid,
) {
    let ends = [a, b].map(|v| job.view.clip_vertex(job.mesh.positions()[v as usize]));
    let Some([from, to]) = cut(ends, job.view.near, job.view.perspective) else { return };
    let between = |t: f32| {
        // The ends themselves, in every bit.
        match t {
            0.0 => ends[0],
            1.0 => ends[1],
            _ => mix(&ends[0], &ends[1], t),
        }
    };
    let seen = |t: f32| {
        let place = between(t);
        let inverse = if job.view.perspective { 1.0 / place.w } else { 1.0 };
        (place.x * inverse, place.y * inverse, bar.depth(&place, inverse, job.view.perspective))
    };
    let (p, q) = (seen(from), seen(to));
    let (dx, dy) = (q.0 - p.0, q.1 - p.1);
    let length = (dx * dx + dy * dy).sqrt();
    if !(length > 0.0 && length < f32::INFINITY) {
        return;
    }
    let across = [-dy / length * bar.radius, dx / length * bar.radius];
    let along = [dx / length * bar.cap, dy / length * bar.cap];
    let beside = |(x, y, depth): (f32, f32, f32), side: f32, end: f32| {
        // Snapped as vertices are.
        let (x, y) = (x + across[0] * side + along[0] * end, y + across[1] * side + along[1] * end);
        let ScreenVertex { x, y, .. } = ClipVertex { x, y, w: 1.0 }.project(false);
        (x, y, depth)
    };
    let corners = [beside(p, 1.0, -1.0), beside(q, 1.0, 1.0), beside(q, -1.0, 1.0), beside(p, -1.0, -1.0)];
    // Each with its place between the vertices, of which the second is the other one.
    let whole = from == 0.0 && to == 1.0;
    let mut half = |corners: [(i32, i32, f32); 3], vertices: [u32; 3], weights: [f32; 3]| {
        // Counter-clockwise from the viewer, whatever the transform does.
        let Some(triangle) = Triangle::new(corners, vertices, false) else { return };
        let bounds = triangle.bounds();
        let [left, top, right, bottom] = screen(grid);
        if bounds[0] >= right || bounds[1] >= bottom || bounds[2] < left || bounds[3] < top {
            return;
        }
        if whole {
            emit(chunk, triangle, grid);
        } else {
            let number = chunk.triangles.len() as u32;
            chunk.pieces.push(ClippedPiece { number, barycentrics: weights.map(|t| [t, 0.0]) });
            emit(chunk, triangle.clipped(), grid);
        }
    };
    half([corners[0], corners[1], corners[2]], [a, b, b], [from, to, to]);
    half([corners[0], corners[2], corners[3]], [a, b, a], [from, to, from]);
}

impl Bar {
    /// Depth of a place, shifted; `inverse` of its distance.
    fn depth(&self, place: &ClipVertex, inverse: f32, perspective: bool) -> f32 {
        if self.shift == 0.0 {
            return if perspective { inverse } else { -place.w };
        }
        let shift = self.shift / self.scale;
        // A pixel is as many times larger as it is farther away.
        if perspective { inverse / (1.0 - if shift < 0.5 { shift } else { 0.5 }) } else { shift - place.w }
    }
}

/// The part of a line beyond the near plane and within the guard band, by its places between the ends.
fn cut([a, b]: [ClipVertex; 2], near: f32, perspective: bool) -> Option<[f32; 2]> {
    let guard = GUARD_BAND as f32;
    let bound = |v: &ClipVertex| if perspective { guard * v.w } else { guard };
    let planes: [&dyn Fn(&ClipVertex) -> f32; 5] =
        [&|v| v.w - near, &|v| bound(v) - v.x, &|v| bound(v) + v.x, &|v| bound(v) - v.y, &|v| bound(v) + v.y];
    let [mut from, mut to] = [0.0_f32, 1.0];
    for plane in planes {
        let (before, after) = (plane(&a), plane(&b));
        match (before >= 0.0, after >= 0.0) {
            (true, true) => {}
            (false, false) => return None,
            (inside, _) => {
                let t = before / (before - after);
                if inside {
                    to = if t < to { t } else { to };
                } else {
                    from = if t > from { t } else { from };
                }
            }
        }
    }
    (from < to).then_some([from, to])
}

fn mix(a: &ClipVertex, b: &ClipVertex, t: f32) -> ClipVertex {
    let mix = |a: f32, b: f32| a + (b - a) * t;
    ClipVertex { x: mix(a.x, b.x), y: mix(a.y, b.y), w: mix(a.w, b.w) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{ScreenVertices, View};
    use overcoat_scene::{Camera, Mesh, MeshData, PrimitiveKind, Projection, Transform};

    fn chunk_of(positions: Vec<[f32; 3]>, lines: Vec<[u32; 3]>) -> Chunk {
        let mesh = Mesh::new(MeshData::default().with(|d| {
            d.positions = positions;
            d.triangles = lines;
            d.kind = PrimitiveKind::Lines;
        }))
        .unwrap();
        let projection = Projection::Perspective { fov_y: 1.0 };
        let camera = Camera::new([0.0, 0.0, 10.0], [0.0; 3], [0.0, 1.0, 0.0], projection, 1.0);
        let view = View::new(&camera, 200, 100).unwrap();
        let none = ScreenVertices::default();
        let job = ChunkJob {
            mesh: &mesh,
            vertices: none.slice(0..0),
            view: &view.of_draw(&Transform::IDENTITY),
            cull_back_faces: true,
            mirrored: false,
            max_bins: usize::MAX,
        };
        let mut chunk = Chunk { range: 0..mesh.triangles().len(), ..Chunk::default() };
        process_lines(&mut chunk, &job, 4.0, &TileGrid::new(200, 100, 32));
        chunk
    }

    #[test]
    fn lines_are_bars_of_their_width_and_the_vertices_of_their_ends() {
        let chunk = chunk_of(vec![[0.0; 3], [1.0, 0.0, 0.0]], vec![[0, 1, 1]]);
        assert_eq!(
            chunk.triangles.iter().map(Triangle::vertices).collect::<Vec<_>>(),
            [[0, 1, 1], [0, 1, 0]]
        );
        assert!(chunk.pieces.is_empty() && chunk.triangles.iter().all(|t| !t.is_back_facing()));
        let [left, top, _, bottom] = chunk.triangles[0].bounds();
        assert_eq!([left, top, bottom], [0, -512, 512]);
    }

    #[test]
    fn what_is_before_the_near_plane_is_cut_off() {
        let positions = vec![[0.0, 0.0, 10.5], [0.0, 0.0, -10.0], [0.5, 0.0, 0.0]];
        // Of the three only the first has a length on the screen.
        let chunk = chunk_of(positions, vec![[0, 2, 2], [2, 2, 2], [0, 0, 0]]);
        assert_eq!(chunk.triangles.len(), 2);
        // A seventh of the way from a distance of -0.5 to 10.
        let seventh = chunk.pieces[0].barycentrics[0][0];
        assert!((seventh - 1.0 / 7.0).abs() < 1e-6, "{seventh}");
        assert!(chunk.triangles.iter().all(|t| t.depth.iter().all(|&d| d > 0.0 && d <= 1.000_001)));
    }
}
