//! Feature edges of meshes as lines: which of them, how wide, and how far before the surfaces that they lie on.

use super::chunk::Chunk;
use super::lines::{Bar, process_line};
use super::{ChunkJob, DrawView, View};
use crate::tile::TileGrid;
use overcoat_scene::{EdgeGroup, EdgeLines, Transform};

/// Steepest surface, in depth over distance on the screen, whose half of a line is not hidden in it: that of a face that leans away
/// from the viewer by 76 degrees.
const SLOPE: f32 = 4.0;

/// Extents of groups of edges in pixels, in widths of a line, up to which none is drawn and from which on they are drawn in full.
const SMALL: [f32; 2] = [4.0, 10.0];

/// Parts of a surface that lines cover from which on they are drawn thinner, and not at all: those of 1.2 pixels up to 15
/// pixels apart, and up to 6.
const DENSE: [f32; 2] = [0.08, 0.2];

/// Width in pixels below which a line is left out.
const LEAST_WIDTH: f32 = 0.12;

/// View of the feature edges of a draw.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EdgeView {
    /// Width of lines in pixels.
    width: f32,
    /// Pixels per unit of world space along a row: of x / distance in perspective, of x in orthographic views.
    scale: f32,
    /// Factor of the transform for lengths.
    unit: f32,
    /// Viewpoint in object space, homogeneous: the eye, or the direction to a viewer far away.
    viewpoint: [f64; 4],
}

impl EdgeView {
    /// The view of a draw's edges as lines of so many pixels.
    #[must_use]
    pub fn new(view: &View, transform: &Transform, width: f32) -> Self {
        let place = if view.perspective { view.eye } else { view.axes[2] };
        let w = f64::from(u8::from(view.perspective));
        Self {
            width,
            scale: view.scale[0] as f32,
            unit: transform.uniform_scale() as f32,
            viewpoint: to_object(transform, place, w),
        }
    }

    /// Pixels per unit of object space in the middle of a group.
    fn pixels_at(&self, group: &EdgeGroup, view: &DrawView) -> f32 {
        let [x, y, z] = group.center;
        let [a, b, c, d] = view.distance;
        let distance = x * a + y * b + z * c + d;
        // Groups beside the eye are large.
        let near = if distance > view.near { distance } else { view.near };
        self.unit * self.scale / if view.perspective { near } else { 1.0 }
    }

    /// Width of a line in pixels, of a group and a density at which a unit has so many pixels; 0 for none.
    fn width_of(&self, group: &EdgeGroup, density: f32, pixels: f32) -> f32 {
        let size = ramp(group.extent * pixels / self.width, SMALL);
        let width = self.width * size * (1.0 - ramp(density * self.width / pixels, DENSE));
        if width > LEAST_WIDTH { width } else { 0.0 }
    }

    /// True if a face is seen from behind or not at all, of which a point and the normal are given.
    fn is_behind(&self, point: [f32; 3], normal: [f32; 3]) -> bool {
        let [x, y, z, w] = self.viewpoint;
        let to = [x - f64::from(point[0]) * w, y - f64::from(point[1]) * w, z - f64::from(point[2]) * w];
        to[0] * f64::from(normal[0]) + to[1] * f64::from(normal[1]) + to[2] * f64::from(normal[2]) <= 0.0
    }
}

/// A place (`w` 1) or a direction (`w` 0) of world space in object space; a direction of any length. 0 if the transform flattens.
fn to_object(transform: &Transform, place: [f64; 3], w: f64) -> [f64; 4] {
    let rows = transform.rows();
    let [p, q, r] = rows.map(|[x, y, z, _]| [x, y, z]);
    let cross = |a: [f64; 3], b: [f64; 3]| {
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    };
    let columns = [cross(q, r), cross(r, p), cross(p, q)];
    let determinant = transform.determinant();
    let by: [f64; 3] = std::array::from_fn(|k| place[k] - rows[k][3] * w);
    let of = |axis: usize| {
        (columns[0][axis] * by[0] + columns[1][axis] * by[1] + columns[2][axis] * by[2]) / determinant
    };
    if determinant == 0.0 { [0.0; 4] } else { [of(0), of(1), of(2), w] }
}

/// 0 up to the first of the bounds, 1 from the second on.
fn ramp(value: f32, [from, to]: [f32; 2]) -> f32 {
    let part = (value - from) / (to - from);
    if part > 1.0 {
        1.0
    } else if part > 0.0 {
        part
    } else {
        0.0
    }
}

/// Fills a chunk from its range of the feature edges of a draw.
pub fn process_edges(
    chunk: &mut Chunk,
    job: &ChunkJob<'_>,
    edges: &EdgeLines,
    view: &EdgeView,
    grid: &TileGrid,
) {
    chunk.clear();
    let mut last = (u32::MAX, 0.0);
    for number in chunk.range.clone() {
        if chunk.bins.len() > job.max_bins {
            return;
        }
        let ([a, b, _], group) = (job.mesh.triangles()[number], edges.group_of[number]);
        if group != last.0 {
            last = (group, view.pixels_at(&edges.groups[group as usize], job.view));
        }
        let width = view.width_of(&edges.groups[group as usize], edges.densities[number], last.1);
        let point = job.mesh.positions()[a as usize];
        let hidden = edges
            .normals
            .get(number)
            .is_some_and(|faces| faces.iter().all(|&normal| view.is_behind(point, normal)));
        if width > 0.0 && !hidden {
            let radius = 0.5 * width;
            let bar = Bar { radius, cap: radius, shift: radius * SLOPE, scale: view.scale };
            process_line(chunk, job, [a, b], &bar, grid);
        }
    }
    chunk.bins.sort();
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::ScreenVertices;
    use overcoat_core::jobs::Jobs;
    use overcoat_scene::{Camera, Mesh, MeshData, find_edges, primitives};

    /// Numbers of the lines that are drawn of a mesh in a picture of 200 x 200 pixels, and the widths that they may have.
    fn drawn(mesh: &Mesh, camera: &Camera, width: f32) -> Vec<[u32; 2]> {
        let edges = find_edges(mesh, &Jobs::new(1)).creases;
        let view = View::new(camera, 200, 200).unwrap();
        let draw = view.of_draw(&Transform::IDENTITY);
        let (none, lines) = (ScreenVertices::default(), &edges.mesh);
        let job = ChunkJob {
            mesh: lines,
            vertices: none.slice(0..0),
            view: &draw,
            cull_back_faces: false,
            mirrored: false,
            max_bins: usize::MAX,
        };
        let mut chunk = Chunk { range: 0..lines.triangles().len(), ..Chunk::default() };
        let own = EdgeView::new(&view, &Transform::IDENTITY, width);
        process_edges(&mut chunk, &job, &edges, &own, &TileGrid::new(200, 200, 32));
        // Two triangles each.
        chunk
            .triangles
            .iter()
            .step_by(2)
            .map(|triangle| [triangle.vertices()[0], triangle.vertices()[1]])
            .collect()
    }

    fn cameras(eye: [f32; 3]) -> [Camera; 2] {
        let pinhole = Camera::look_at(eye, [0.0; 3], [0.0, 1.0, 0.0]).unwrap();
        [pinhole, pinhole.orthographic(3.0).unwrap()]
    }

    #[test]
    fn of_a_solid_the_lines_between_faces_seen_from_behind_are_left_out() {
        let cube = Mesh::new(primitives::cuboid([1.0; 3]).unwrap().data().clone()).unwrap();
        for camera in cameras([3.0, 2.0, 4.0]) {
            assert_eq!(drawn(&cube, &camera, 1.0).len(), 9);
        }
        // One face only; a camera far away sees no other.
        let [_, parallel] = cameras([0.0, 0.0, 4.0]);
        assert_eq!(drawn(&cube, &parallel, 1.0).len(), 4);
        // Without its first face the inside is seen.
        let mut open = cube.data().clone();
        open.triangles.drain(..2);
        let lines = drawn(&Mesh::new(open).unwrap(), &cameras([3.0, 2.0, 4.0])[0], 1.0);
        assert_eq!(lines.len(), 8);
    }

    #[test]
    fn what_is_small_or_dense_has_no_lines() {
        let cube = |size: f32| Mesh::new(primitives::cuboid([size; 3]).unwrap().data().clone()).unwrap();
        let [_, camera] = cameras([3.0, 2.0, 4.0]);
        // 0.05 of 3 metres in 200 pixels are 3.3 pixels.
        assert_eq!(drawn(&cube(0.05), &camera, 1.0), Vec::<[u32; 2]>::new());
        assert_eq!(drawn(&cube(0.3), &camera, 1.0).len(), 9);
        let fins = |count: u32| {
            let mut data = MeshData::default();
            for k in 0..count {
                let fin = primitives::cuboid([0.5 / count as f32, 1.0, 1.0]).unwrap();
                let first = data.positions.len() as u32;
                let shift = k as f32 / count as f32;
                data.positions.extend(fin.positions().iter().map(|&[x, y, z]| [x + shift, y, z]));
                data.triangles.extend(fin.triangles().iter().map(|face| face.map(|v| v + first)));
            }
            Mesh::new(data).unwrap()
        };
        assert_eq!(drawn(&fins(2), &camera, 1.0).len(), 18);
        assert_eq!(drawn(&fins(40), &camera, 1.0).len(), 0);
    }

    #[test]
    fn viewpoints_are_found_in_object_space() {
        let turned = Transform::rotation([0.3, 0.5, 0.7], 1.0).unwrap();
        let transform = Transform::translation([5.0, -2.0, 1.0]).unwrap().after(&turned).unwrap();
        let place = transform.point([0.3, 0.4, 0.5]);
        let [x, y, z, w] = to_object(&transform, place, 1.0);
        assert!([x - 0.3, y - 0.4, z - 0.5].iter().all(|v| v.abs() < 1e-12) && w == 1.0);
        let flat = Transform::from_rows([[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0; 4]]).unwrap();
        assert_eq!(to_object(&flat, place, 1.0), [0.0; 4]);
    }
}
