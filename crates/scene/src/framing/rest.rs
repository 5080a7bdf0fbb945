//! A body at rest on a floor: its contact and its centre of mass.

use super::convex_hull::ConvexHull;
use super::evidence::{Evidence, Rise};
use super::trees;

/// Coordinates of a point.
pub(super) type Point = [f64; 3];

/// Corners of a triangle.
pub(super) type Triangle = [Point; 3];

/// Thickness of what counts as touching the floor, in sizes of the body, and at most in four of its heights.
const CONTACT: f64 = 0.02;

/// Length of the mean normal below which a surface is closed.
const CLOSED: f64 = 0.05;

/// A body of triangles.
#[derive(Debug)]
pub(super) struct Body<'a> {
    pub(super) triangles: &'a [Triangle],
    pub(super) min: Point,
    pub(super) max: Point,
    /// Centre of mass of the surface.
    pub(super) center: Point,
    /// Doubled area of the surface.
    pub(super) doubled_area: f64,
    /// Sum of the doubled normals.
    pub(super) doubled_normals: Point,
    /// True for a closed surface whose normals point inwards.
    pub(super) is_inside_out: bool,
    /// Largest side of its box.
    pub(super) size: f64,
}

/// Contact of a body with a floor.
#[derive(Clone, Copy, Debug)]
pub(super) struct Contact {
    /// Share of the footprint, 0 to 1.
    pub(super) share: f64,
    /// Depth of the centre of mass in it, negative outside, in sides of a square as large as the footprint.
    pub(super) depth: f64,
    /// Area of the footprint.
    pub(super) footprint: f64,
}

impl<'a> Body<'a> {
    /// A body in a box. `None` if a number is not finite, or the box or the surface is flat.
    pub(super) fn new(triangles: &'a [Triangle], [min, max]: [Point; 2]) -> Option<Self> {
        let (mut center, mut area, mut normals, mut volume) = ([0.0; 3], 0.0, [0.0; 3], 0.0);
        for triangle in triangles {
            let normal = doubled_normal(triangle);
            let own = length(&normal);
            area += own;
            for k in 0..3 {
                center[k] += own * (triangle[0][k] + triangle[1][k] + triangle[2][k]);
                normals[k] += normal[k];
                volume += normal[k] * (triangle[0][k] - min[k]);
            }
        }
        let center = center.map(|v| v / (3.0 * area));
        let sides: [f64; 3] = std::array::from_fn(|k| max[k] - min[k]);
        let is_solid = area > 0.0 && sides.iter().all(|side| *side > 0.0 && side.is_finite());
        // Cones between the surface and the centre.
        let volume = (0..3).fold(volume, |volume, k| volume - normals[k] * (center[k] - min[k]));
        let is_inside_out = volume < 0.0 && length(&normals) < CLOSED * area;
        let size = sides.iter().fold(0.0, |size, side| if *side > size { *side } else { size });
        (is_solid && center.iter().all(|v| v.is_finite())).then_some(Self {
            triangles,
            min,
            max,
            center,
            doubled_area: area,
            doubled_normals: normals,
            is_inside_out,
            size,
        })
    }

    /// True if the evidence is strong that not the usual axis is up, +Z if `z_is_usual` or else +Y, but the other one of both,
    /// where `rise` is what the textures say.
    pub(super) fn stands_on_other(&self, z_is_usual: bool, rise: &Rise) -> bool {
        trees::is_turned(&Evidence::new(self, rise).poses(), z_is_usual)
    }

    /// Side of the box along an axis.
    pub(super) fn side(&self, axis: usize) -> f64 {
        self.max[axis] - self.min[axis]
    }

    /// Area of its convex outline along an axis.
    pub(super) fn footprint(&self, axis: usize) -> f64 {
        let [a, b] = [(axis + 1) % 3, (axis + 2) % 3];
        ConvexHull::around_many(self.triangles.iter().flatten().map(|p| [p[a], p[b]])).area()
    }

    /// Contact with a floor across the axis, at the lower end or at the upper one, within an outline of the area `footprint`.
    pub(super) fn contact(&self, axis: usize, is_upper: bool, footprint: f64) -> Contact {
        let [a, b] = [(axis + 1) % 3, (axis + 2) % 3];
        let flat = |p: &Point| [p[a], p[b]];
        let height = |p: &Point| if is_upper { self.max[axis] - p[axis] } else { p[axis] - self.min[axis] };
        let top = self.thickness_of_contact(axis);
        let mut points = Vec::new();
        for triangle in self.triangles.iter().filter(|t| t.iter().any(|p| height(p) <= top)) {
            for (p, q) in [(0, 1), (1, 2), (2, 0)].map(|(p, q)| (&triangle[p], &triangle[q])) {
                let [low, high] = [height(p), height(q)];
                if low <= top {
                    points.push(flat(p));
                }
                if (low <= top) != (high <= top) {
                    let share = (top - low) / (high - low);
                    points.push([a, b].map(|k| p[k] + share * (q[k] - p[k])));
                }
            }
        }
        let hull = ConvexHull::around(points);
        let depth = hull.depth(flat(&self.center)) / footprint.sqrt();
        Contact { share: hull.area() / footprint, depth, footprint }
    }

    /// Height above a floor up to which the body counts as touching it.
    pub(super) fn thickness_of_contact(&self, axis: usize) -> f64 {
        let height = 4.0 * self.side(axis);
        CONTACT * if height < self.size { height } else { self.size }
    }
}

/// Length of a vector.
pub(super) fn length([x, y, z]: &Point) -> f64 {
    (x * x + y * y + z * z).sqrt()
}

/// Normal of a triangle, as long as twice its area.
pub(super) fn doubled_normal([a, b, c]: &Triangle) -> Point {
    let [u, v]: [Point; 2] = [b, c].map(|p| std::array::from_fn(|k| p[k] - a[k]));
    [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
}
