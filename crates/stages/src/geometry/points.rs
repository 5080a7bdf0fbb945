//! Points as discs, made anew wherever one is asked for: a cloud of millions takes no memory but for the tiles' lists.
//!
//! A point has a radius and a normal in the world. What is seen of its disc is, to first order about its centre, an
//! ellipse: the covariance of the disc, `r^2 (1 - n n^T)`, is taken through the projection (Zwicker et al. 2001, "Surface
//! Splatting"), and a least size in pixels is added to it, so that neither distant points nor discs that are seen from
//! their edge fall between the samples. Depth follows the disc's plane, as far as the least size leaves it one.
//!
//! Points of a size in pixels, and those without a normal, are circles that face the viewer.

use super::chunk::{Chunk, screen};
use super::{DrawView, View};
use crate::raster::{Disc, GUARD_BAND, Spread};
use crate::tile::TileGrid;
use overcoat_scene::{Mesh, Transform};

/// Largest radius in pixels, if [`NEAREST`] allows it: it bounds the work that one point can be.
const LARGEST: f32 = 128.0;

/// Largest radius as a part of the distance: what is closer would lie around the viewer.
const NEAREST: f32 = 0.25;

/// Distance by which the rim of a disc lies behind its plane, as a part of the radius: as far as that of a ball no
/// larger than it does. See [`Disc::sag`].
const SAG: f32 = 0.5;

/// View of the points of one draw.
#[derive(Clone, Copy, Debug)]
pub struct PointView {
    view: DrawView,
    /// Normals to the camera's frame: right, down, forward.
    normal: [[f32; 3]; 3],
    /// Pixels per unit of x / distance, or of x.
    focal: f32,
    /// Pixels per unit of y in those of x, and its inverse.
    stretch: [f32; 2],
    /// Principal point, to the right of and below the viewport's centre, in pixels.
    principal: [f32; 2],
    /// Factor by which the draw scales lengths.
    scale: f32,
    /// Radius of all points in pixels, where it is given.
    radius: Option<f32>,
    /// Least radius of others in pixels.
    least: f32,
}

impl PointView {
    /// Points of one draw: `size` pixels wide, or as wide as the mesh's [`Surfels`](overcoat_scene::Surfels) say.
    #[must_use]
    pub fn new(view: &View, mesh: &Mesh, transform: &Transform, size: Option<f32>) -> Self {
        let [right, up, back] = view.axes;
        let matrix = transform.normal_matrix().map(|row| row.map(f64::from));
        let row = |axis: [f64; 3], sign: f64| {
            let mut out = [0.0; 3];
            for (c, v) in out.iter_mut().enumerate() {
                let along = axis[0] * matrix[0][c] + axis[1] * matrix[1][c] + axis[2] * matrix[2][c];
                *v = (along * sign) as f32;
            }
            out
        };
        Self {
            view: view.of_draw(transform),
            normal: [row(right, 1.0), row(up, -1.0), row(back, -1.0)],
            focal: view.scale[0] as f32,
            stretch: [view.scale[1] / view.scale[0], view.scale[0] / view.scale[1]].map(|v| v as f32),
            principal: view.principal.map(|v| v as f32),
            scale: transform.uniform_scale() as f32,
            radius: size.map(|size| 0.5 * size),
            least: mesh.surfels().map_or(0.0, |surfels| surfels.least_radius),
        }
    }

    /// Disc on the screen for a point of the mesh; `None` before the near plane and far beside the picture.
    #[must_use]
    pub fn disc(&self, mesh: &Mesh, point: usize) -> Option<Disc> {
        let vertex = mesh.point(point);
        let place = self.view.clip_vertex(*mesh.positions().get(vertex as usize)?);
        let guard = GUARD_BAND as f32;
        let bound = if self.view.perspective { guard * place.w } else { guard };
        // Written so that a NaN is outside.
        if !(place.w >= self.view.near && place.x.abs() <= bound && place.y.abs() <= bound) {
            return None;
        }
        let screen = place.project(self.view.perspective);
        // Slopes of the ray to the point, and pixels per unit of length there.
        let (u, v, pixels) = if self.view.perspective {
            let slope = 1.0 / (place.w * self.focal);
            let [cx, cy] = self.principal;
            let (x, y) = (place.x - cx * place.w, (place.y - cy * place.w) * self.stretch[1]);
            (x * slope, y * slope, self.focal / place.w)
        } else {
            (0.0, 0.0, self.focal)
        };
        let normal = self.normal(mesh, vertex);
        let back_facing = normal.is_some_and(|[x, y, z]| x * u + y * v + z > 0.0);
        let (radius, least) = match self.radius {
            Some(radius) => (0.0, radius),
            None => {
                let of_mesh = mesh.surfels().and_then(|surfels| surfels.radii.get(vertex as usize));
                (of_mesh.copied().unwrap_or(0.0) * self.scale * pixels, self.least)
            }
        };
        let largest = if self.view.perspective { NEAREST * self.focal } else { LARGEST };
        let largest = if largest < LARGEST { largest } else { LARGEST };
        let radius = if radius < largest { radius } else { largest };
        let (square, least) = (radius * radius, least * least);
        // The change of depth along the view at this point, for a pixel.
        let depth = if self.view.perspective { screen.depth / self.focal } else { 1.0 / self.focal };
        let sag = SAG * radius * depth;
        // Lengths down are those across times this.
        let [stretch, _] = self.stretch;
        let spread = match normal {
            None => Spread {
                screen: [square + least, 0.0, square * (stretch * stretch) + least],
                depth: [0.0; 2],
                sag,
            },
            Some([x, y, z]) => {
                // The projection of the normal, for one pixel a unit.
                let (p, q) = (x - z * u, y - z * v);
                let depth = square * depth;
                Spread {
                    screen: [
                        square * (1.0 + u * u - p * p) + least,
                        square * (u * v - p * q) * stretch,
                        square * (1.0 + v * v - q * q) * (stretch * stretch) + least,
                    ],
                    depth: [depth * (u + p * z), depth * (v + q * z) * stretch],
                    sag,
                }
            }
        };
        Disc::new([screen.x, screen.y], screen.depth, &spread, vertex, back_facing)
    }

    /// The unit normal of a vertex in the camera's frame.
    #[inline(always)]
    fn normal(&self, mesh: &Mesh, vertex: u32) -> Option<[f32; 3]> {
        let n = mesh.shading_normals().get(vertex as usize)?;
        let mut out = [0.0; 3];
        for (r, v) in self.normal.iter().zip(&mut out) {
            *v = n[0] * r[0] + n[1] * r[1] + n[2] * r[2];
        }
        let square = out[0] * out[0] + out[1] * out[1] + out[2] * out[2];
        if !(square > 0.0 && square < f32::INFINITY) {
            return None;
        }
        let inverse = 1.0 / square.sqrt();
        Some(out.map(|v| v * inverse))
    }
}

/// Bins the points of a chunk: which tiles of the first grid may see them. Pairs are counted on the second.
pub fn process_points(
    chunk: &mut Chunk,
    view: &PointView,
    mesh: &Mesh,
    [grid, counted]: [&TileGrid; 2],
    max_bins: usize,
) {
    chunk.clear();
    let [left, top, right, bottom] = screen(grid);
    for (number, point) in chunk.range.clone().enumerate() {
        let Some(disc) = view.disc(mesh, point) else { continue };
        let bounds = disc.bounds();
        if bounds[0] >= right || bounds[1] >= bottom || bounds[2] < left || bounds[3] < top {
            continue;
        }
        if chunk.bins.len() > max_bins {
            return;
        }
        chunk.kept += 1;
        let [left, top, right, bottom] = counted.tiles_of_box(bounds);
        chunk.point_pairs += u64::from(right.saturating_sub(left)) * u64::from(bottom.saturating_sub(top));
        let [first_column, first_row, end_column, end_row] = grid.tiles_of_box(bounds);
        for row in first_row..end_row {
            for column in first_column..end_column {
                chunk.bins.push(row * grid.columns() + column, number as u32);
            }
        }
    }
    chunk.bins.sort();
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::raster::SUBPIXELS;
    use overcoat_scene::{Camera, MeshData, PrimitiveKind, Projection, Surfels};

    fn camera(projection: Projection) -> Camera {
        Camera::new([0.0, 0.0, 10.0], [0.0; 3], [0.0, 1.0, 0.0], projection, 1.0)
    }

    fn seen(normal: [f32; 3], radius: f32, projection: Projection, size: Option<f32>) -> Option<Disc> {
        let mesh = Mesh::new(MeshData::default().with(|d| {
            d.positions = vec![[0.0; 3]];
            d.normals = vec![normal];
            d.kind = PrimitiveKind::Points;
        }))
        .unwrap();
        mesh.set_surfels(Surfels { radii: vec![radius], normals: Vec::new(), least_radius: 0.0 });
        let view = View::new(&camera(projection), 200, 200).unwrap();
        PointView::new(&view, &mesh, &Transform::IDENTITY, size).disc(&mesh, 0)
    }

    #[test]
    fn a_disc_is_as_large_as_its_radius_and_as_foreshortened_as_its_normal() {
        let orthographic = Projection::Orthographic { height: 2.0 };
        let wide = |disc: Disc| disc.reach.map(|v| f64::from(v) / f64::from(SUBPIXELS));
        let face = wide(seen([0.0, 0.0, 2.0], 0.1, orthographic, None).unwrap());
        assert!((face[0] - 10.0).abs() < 0.01 && (face[1] - 10.0).abs() < 0.01, "{face:?}");
        let leaning = seen([0.8, 0.0, 0.6], 0.1, orthographic, None).unwrap();
        let [x, y] = wide(leaning);
        assert!((x - 6.0).abs() < 0.01 && (y - 10.0).abs() < 0.01, "{x} {y}");
        // Depth falls by 4/3 of the way to the right: a pixel is 0.01.
        let slope = leaning.depth_gradient[0] * SUBPIXELS as f32;
        assert!((slope + 0.01 * 4.0 / 3.0).abs() < 1e-5, "{slope}");
        assert!(!leaning.back_facing && seen([0.0, 0.0, -1.0], 0.1, orthographic, None).unwrap().back_facing);
        // A size in pixels faces the viewer.
        let marker = seen([0.8, 0.0, 0.6], 0.1, orthographic, Some(8.0)).unwrap();
        assert_eq!((marker.reach, marker.depth_gradient), ([1025; 2], [0.0; 2]));
    }

    #[test]
    fn large_discs_are_bounded_and_those_from_the_edge_need_a_least_size() {
        let perspective = Projection::Perspective { fov_y: 1.0 };
        let close = seen([0.0, 0.0, 1.0], 1e6, perspective, None).unwrap();
        assert!(close.reach[0] < 47 * SUBPIXELS && close.depth_range()[0] > 0.0, "{close:?}");
        assert_eq!(seen([1.0, 0.0, 0.0], 0.1, Projection::Orthographic { height: 2.0 }, None), None);
    }
}
