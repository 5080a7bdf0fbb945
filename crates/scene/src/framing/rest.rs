//! Poses in which a body rests: its contact with a floor, its centre of mass and its symmetry.

use super::convex_hull::ConvexHull;
use super::evidence::{Evidence, Rise};

/// Coordinates of a point.
pub(super) type Point = [f64; 3];

/// Corners of a triangle.
pub(super) type Triangle = [Point; 3];

/// Thickness of what counts as touching the floor, in sizes of the body, and at most in four of its heights.
const CONTACT: f64 = 0.02;

/// Distance from zero of a bottom that lies on the floor of its file, in heights.
const ON_FLOOR: f64 = 0.02;

/// Height or depth of a plate, in sizes of the body.
const PLATE: f64 = 0.3;

/// Depth of the centre of mass in the contact, in sides of a square as large as the footprint, at which a body stands.
const STANDS: f64 = 0.02;

/// Depth of the centre of mass at which it stands firmly, in the same unit.
const STANDS_FIRMLY: f64 = 0.1;

/// Share of the footprint that is contact below a body that stands firmly.
const FIRM: f64 = 0.5;

/// Share of the footprint that is contact below a plate.
const FULL: f64 = 0.8;

/// Share of the surface without a counterpart in the mirror, in a body that is alike on both sides.
const ALIKE: f64 = 0.08;

/// Cells of the grid for symmetry, along each axis; odd, so that the middle has one of its own.
const CELLS: usize = 25;

/// Samples on triangles for symmetry, at most and about.
const SAMPLES: usize = 1 << 20;

/// A body of triangles.
#[derive(Debug)]
pub(super) struct Body<'a> {
    pub(super) triangles: &'a [Triangle],
    pub(super) min: Point,
    pub(super) max: Point,
    /// Centre of mass of the surface.
    pub(super) center: Point,
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

impl Contact {
    /// True if the body stands firmly on it.
    pub(super) fn is_firm(self) -> bool {
        self.depth > STANDS_FIRMLY && self.share > FIRM
    }
}

impl<'a> Body<'a> {
    /// A body in a box. `None` if a number is not finite, or the box or the surface is flat.
    pub(super) fn new(triangles: &'a [Triangle], [min, max]: [Point; 2]) -> Option<Self> {
        let (mut center, mut area) = ([0.0; 3], 0.0);
        for triangle in triangles {
            let own = length(&doubled_normal(triangle));
            area += own;
            for k in 0..3 {
                center[k] += own * (triangle[0][k] + triangle[1][k] + triangle[2][k]);
            }
        }
        let center = center.map(|v| v / (3.0 * area));
        let sides: [f64; 3] = std::array::from_fn(|k| max[k] - min[k]);
        let is_solid = area > 0.0 && sides.iter().all(|side| *side > 0.0 && side.is_finite());
        let size = sides.iter().fold(0.0, |size, side| if *side > size { *side } else { size });
        (is_solid && center.iter().all(|v| v.is_finite())).then_some(Self {
            triangles,
            min,
            max,
            center,
            size,
        })
    }

    /// True if the evidence is strong that the axis `other` (0 to 2) is up, and not the `usual` one, where `rise` is what
    /// the textures say.
    ///
    /// Plates that stand on an edge, or lie on their face, stay as they are. Others are turned by one of two rules, if the
    /// odds of all [`Evidence`] are not against it, or by those odds alone if they are high. The rules: the file has a floor,
    /// and the body stands on the plane through zero across the other axis, while that across the usual one cuts it; or it
    /// would fall over in the usual pose. The contacts and the grid for symmetry are computed once, and only where they can
    /// decide.
    pub(super) fn stands_on_other(&self, other: usize, usual: usize, rise: &Rise) -> bool {
        if self.is_thin(other) && !self.is_thin(usual) {
            return false;
        }
        let evidence = Evidence::new(self, [other, usual], rise);
        if evidence.most() <= 0.0 {
            return false;
        }
        let contacts = [other, usual].map(|axis| self.contact(axis));
        let on_usual = contacts[1];
        if self.is_thin(usual) && !self.is_thin(other) && on_usual.depth > STANDS && on_usual.share > FULL {
            return false;
        }
        let evidence = evidence.with_contacts(contacts);
        if evidence.most() <= 0.0 {
            return false;
        }
        let is_on_floor = self.is_on_floor(other) && self.crosses_floor(usual) && contacts[0].depth > STANDS;
        let falls = self.falls([other, usual], contacts);
        if !is_on_floor && !falls && !evidence.can_be_enough() {
            return false;
        }
        let grid = self.grid();
        let [along, across] = [other, usual].map(|axis| self.asymmetry(axis, &grid));
        let odds = evidence.odds([along, across]);
        // Mirrors are upright, so that a body is less alike along its height. One that is alike, and rests in either pose,
        // has no top.
        let has_top = along >= 0.5 * across && (along > ALIKE || on_usual.depth < STANDS);
        odds > 0.0 && (is_on_floor && has_top || falls) || along > ALIKE && evidence.is_enough(odds)
    }

    /// True if the body falls over with the second of two axes up, its centre of mass not being above its contact, and stands
    /// firmly with the first.
    fn falls(&self, [other, usual]: [usize; 2], [on_other, on_usual]: [Contact; 2]) -> bool {
        !self.is_thin(other) && !self.is_on_floor(usual) && on_other.is_firm() && on_usual.depth < 0.0
    }

    /// True if the body is a plate across an axis.
    fn is_thin(&self, axis: usize) -> bool {
        self.side(axis) < PLATE * self.size
    }

    /// Side of the box along an axis.
    pub(super) fn side(&self, axis: usize) -> f64 {
        self.max[axis] - self.min[axis]
    }

    /// True if the plane through zero touches its lower end.
    fn is_on_floor(&self, axis: usize) -> bool {
        self.min[axis].abs() < ON_FLOOR * self.side(axis)
    }

    /// True if some of it is below the plane through zero.
    pub(super) fn is_below_floor(&self, axis: usize) -> bool {
        self.min[axis] < -ON_FLOOR * self.side(axis)
    }

    /// True if the plane through zero has some of it on both sides.
    fn crosses_floor(&self, axis: usize) -> bool {
        self.is_below_floor(axis) && self.max[axis] > ON_FLOOR * self.side(axis)
    }

    /// Contact with a floor across the axis, at the lower end.
    fn contact(&self, axis: usize) -> Contact {
        let [a, b] = [(axis + 1) % 3, (axis + 2) % 3];
        let flat = |p: &Point| [p[a], p[b]];
        let footprint = ConvexHull::around(self.triangles.iter().flatten().map(flat).collect()).area();
        let top = self.top_of_contact(axis);
        let mut points = Vec::new();
        for triangle in self.triangles.iter().filter(|t| t.iter().any(|p| p[axis] <= top)) {
            for (p, q) in [(0, 1), (1, 2), (2, 0)].map(|(p, q)| (&triangle[p], &triangle[q])) {
                if p[axis] <= top {
                    points.push(flat(p));
                }
                if (p[axis] <= top) != (q[axis] <= top) {
                    let share = (top - p[axis]) / (q[axis] - p[axis]);
                    points.push([a, b].map(|k| p[k] + share * (q[k] - p[k])));
                }
            }
        }
        let hull = ConvexHull::around(points);
        let depth = hull.depth(flat(&self.center)) / footprint.sqrt();
        Contact { share: hull.area() / footprint, depth, footprint }
    }

    /// Coordinate up to which the body counts as touching a floor at its lower end.
    pub(super) fn top_of_contact(&self, axis: usize) -> f64 {
        let height = 4.0 * self.side(axis);
        self.min[axis] + CONTACT * if height < self.size { height } else { self.size }
    }

    /// Share of the surface that has no counterpart in the mirror across the middle of its box, 0 to 1.
    fn asymmetry(&self, axis: usize, grid: &[f64]) -> f64 {
        let (mut sum, mut all) = (0.0, 0.0);
        for (number, surface) in grid.iter().enumerate() {
            let mut cell = [number % CELLS, number / CELLS % CELLS, number / (CELLS * CELLS)];
            cell[axis] = CELLS - 1 - cell[axis];
            all += surface;
            sum += (surface - grid[index(cell)]).abs();
        }
        sum / (2.0 * all)
    }

    /// Surface in the cells of a cube around its box.
    fn grid(&self) -> Vec<f64> {
        let most = (SAMPLES / self.triangles.len().max(1)).isqrt().clamp(1, 128);
        let mut grid = vec![0.0; CELLS * CELLS * CELLS];
        let half = CELLS / 2;
        let scale = (CELLS - 1) as f64 / self.size;
        for [a, b, c] in self.triangles {
            let [ab, ac]: [Point; 2] = [b, c].map(|p| std::array::from_fn(|k| p[k] - a[k]));
            let bc = std::array::from_fn(|k| c[k] - b[k]);
            let longest = [ab, ac, bc].iter().map(length).fold(0.0, |l, v| if v > l { v } else { l });
            // Parts of an edge, about as long as a quarter of a cell. A cast saturates.
            let parts = ((4.0 * scale * longest).ceil() as usize).clamp(1, most);
            let own = length(&doubled_normal(&[*a, *b, *c])) / (parts * parts) as f64;
            let mut add = |u: f64, v: f64| {
                grid[index(std::array::from_fn(|k| {
                    let from_middle = a[k] + u * ab[k] + v * ac[k] - 0.5 * (self.min[k] + self.max[k]);
                    // Mirror images lie in mirrored cells, on their borders too.
                    let steps = ((from_middle.abs() * scale + 0.5) as usize).min(half);
                    if from_middle < 0.0 { half - steps } else { half + steps }
                }))] += own;
            };
            for i in 0..parts {
                for j in 0..parts - i {
                    // Centres of the triangles into which it is divided, half of which are upside down.
                    let at = |k: usize, o: f64| (k as f64 + o / 3.0) / parts as f64;
                    add(at(i, 1.0), at(j, 1.0));
                    if i + j + 1 < parts {
                        add(at(i, 2.0), at(j, 2.0));
                    }
                }
            }
        }
        grid
    }
}

/// Number of a cell.
fn index([x, y, z]: [usize; 3]) -> usize {
    (z * CELLS + y) * CELLS + x
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
