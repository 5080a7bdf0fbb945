//! Evidence of the axis that is up: features of a body in a pose.

use super::rest::{Body, Contact, Point, Triangle, doubled_normal, length};

/// Number of features of a pose.
pub(super) const FEATURES: usize = 52;

/// Features of a pose, in the order of [`Evidence::pose`], without a unit: lengths by sides of the box, areas by the surface.
pub(super) type Features = [f64; FEATURES];

/// Features of a floor below: share of the footprint that is contact, and depth of the centre of mass in that.
pub(super) const CONTACT_BELOW: [usize; 2] = [31, 32];

/// Features of the floor of the file, the plane through zero.
const OF_FLOOR: std::ops::Range<usize> = 43..49;

/// Cosines of the angle with an axis from which on a triangle lies flat across it, leans towards it, and hangs over.
const IS_FLAT: f64 = 0.95;
const LEANS: f64 = 0.4;
const HANGS: f64 = 0.7;

/// Cosine of the angle with an axis from which on an edge runs along it.
const RUNS_ALONG: f64 = 0.995;

/// Parts of a side of the box at its ends, in which a flat face closes the body, and between which it is a shelf.
const CLOSING: f64 = 0.03;
const SHELF: f64 = 0.1;

/// Distance from zero along an axis, in sizes of the body, from which on the plane through zero is no floor: such files have
/// coordinates of a map, or of a part of something else.
const FAR: f64 = 2.0;

/// Surface that faces one end of an axis, in shares of all.
#[derive(Clone, Copy, Debug, Default)]
struct Side {
    /// Flat across the axis.
    flat: f64,
    /// At a slope.
    slant: f64,
    /// Flat, away from both ends.
    shelf: f64,
    /// Flat, at the end.
    closing: f64,
    /// Facing the end, above what touches a floor there.
    hang: f64,
    /// Flat on a floor at the end.
    base: f64,
}

/// Axis of a body in a direction.
#[derive(Clone, Copy, Debug)]
struct Directed {
    axis: usize,
    is_positive: bool,
}

/// Measures of a body along all axes.
#[derive(Debug)]
pub(super) struct Evidence<'a> {
    body: &'a Body<'a>,
    /// Sum of the normals, by the area, turned outwards.
    mean: Point,
    /// Variance of the surface along each axis, in squared sides.
    variance: Point,
    /// Share of the length of edges that runs along each axis.
    edges: Point,
    /// Surface towards the lower and the upper end of each axis.
    sides: [[Side; 2]; 3],
    /// Contacts with a floor at both ends of Y and of Z.
    contacts: [[Contact; 2]; 2],
    /// Direction in which textures are upright.
    rise: Point,
}

impl<'a> Evidence<'a> {
    /// Measures of a body whose textures are upright in the direction `rise`.
    pub(super) fn new(body: &'a Body<'a>, rise: &Rise) -> Self {
        let (area, sign) = (body.doubled_area, if body.is_inside_out { -1.0 } else { 1.0 });
        let mut sides = [[Side::default(); 2]; 3];
        let (mut squares, mut edges, mut length_of_edges) = ([0.0; 3], [0.0; 3], 0.0);
        let layers: Point = std::array::from_fn(|axis| body.thickness_of_contact(axis) / body.side(axis));
        let per_side: Point = std::array::from_fn(|axis| 1.0 / body.side(axis));
        for triangle in body.triangles {
            let normal = doubled_normal(triangle);
            let own = length(&normal);
            let [a, b, c] = triangle;
            for (p, q) in [(a, b), (b, c), (c, a)] {
                let edge: Point = std::array::from_fn(|k| q[k] - p[k]);
                let along = length(&edge);
                length_of_edges += along;
                for k in 0..3 {
                    edges[k] += if edge[k].abs() > RUNS_ALONG * along { along } else { 0.0 };
                }
            }
            if own <= 0.0 {
                continue;
            }
            let share = own / area;
            for axis in 0..3 {
                let [x, y, z] = [a, b, c].map(|p| (p[axis] - body.center[axis]) * per_side[axis]);
                squares[axis] += share * (x * x + y * y + z * z + x * y + y * z + z * x) / 6.0;
                let towards = sign * normal[axis];
                let end = usize::from(towards > 0.0);
                // Middle of the triangle, from the end that it faces.
                let middle = (x + y + z) / 3.0 + (body.center[axis] - body.min[axis]) * per_side[axis];
                let from_end = if end == 1 { 1.0 - middle } else { middle };
                add(&mut sides[axis][end], share, towards.abs() / own, from_end, from_end <= layers[axis]);
            }
        }
        Self {
            body,
            mean: body.doubled_normals.map(|v| sign * v / area),
            variance: squares,
            edges: edges.map(|v| v / length_of_edges),
            sides,
            contacts: [1, 2].map(|axis| {
                let footprint = body.footprint(axis);
                [false, true].map(|is_upper| body.contact(axis, is_upper, footprint))
            }),
            rise: rise.0.map(|v| v / area),
        }
    }

    /// Features of the pose with +Y up, and of the one with +Z up.
    pub(super) fn poses(&self) -> [Features; 2] {
        let directed = |axis, is_positive| Directed { axis, is_positive };
        let poses = [
            self.pose(directed(1, true), directed(2, true)),
            self.pose(directed(2, true), directed(1, false)),
        ];
        let Body { min, max, size, .. } = self.body;
        let is_far = min.iter().zip(max).any(|(min, max)| *min > FAR * size || -max > FAR * size);
        if is_far { poses.map(|pose| without_floor(&pose)) } else { poses }
    }

    /// Features of the pose with one direction up, and another one in front.
    fn pose(&self, up: Directed, front: Directed) -> Features {
        const ACROSS: usize = 0;
        let body = self.body;
        let [height, depth, width] = [up.axis, front.axis, ACROSS].map(|axis| body.side(axis));
        let middle =
            |axis: usize| clamped(0.5 * (body.min[axis] + body.max[axis]).abs() / body.size, 0.0, 1.0);
        let lean =
            |axis: usize| (body.center[axis] - 0.5 * (body.min[axis] + body.max[axis])).abs() / body.size;
        let [[low, high], [back, face]] = [up, front].map(|d| self.ends(d));
        let [under, over, behind, ahead] =
            [(up, false), (up, true), (front, false), (front, true)].map(|(d, far)| self.touch(d, far));
        let of_center = |d: Directed| (d.of(body.center[d.axis]) - d.low(body)) / body.side(d.axis);
        let sloped = |toward: Side, away: Side| [toward.flat, away.flat, toward.slant, away.slant];
        let flat = |toward: Side, away: Side| [toward.shelf, away.shelf];
        let closed = |toward: Side, away: Side| [toward.closing, away.closing];
        let [u, f] = [sloped(high, low), sloped(face, back)];
        let [shelf_u, shelf_f] = [flat(high, low), flat(face, back)];
        let [closed_u, closed_f] = [closed(high, low), closed(face, back)];
        let above = of_center(up) * height;
        [
            // Proportions.
            height / (height + depth),
            height / (height + width),
            depth / (depth + width),
            // Centre of mass in the box, and off its middle.
            of_center(up),
            of_center(front),
            lean(front.axis),
            lean(ACROSS),
            // Side that open surfaces show.
            up.of(self.mean[up.axis]),
            front.of(self.mean[front.axis]),
            self.mean[ACROSS].abs(),
            // Slopes: floors and ceilings, roofs, shelves, tops and bottoms, overhangs.
            u[0],
            u[1],
            u[2],
            u[3],
            f[0],
            f[1],
            f[2],
            f[3],
            shelf_u[0],
            shelf_u[1],
            shelf_f[0],
            shelf_f[1],
            closed_u[0],
            closed_u[1],
            closed_f[0],
            closed_f[1],
            low.hang,
            back.hang,
            // Edges across, upwards and to the front.
            self.edges[ACROSS],
            self.edges[up.axis],
            self.edges[front.axis],
            // Floors on which the body could rest: share of the footprint and depth of the centre of mass.
            clamped(under.share, 0.0, 1.0),
            clamped(under.depth, -0.5, 0.5),
            clamped(over.share, 0.0, 1.0),
            clamped(over.depth, -0.5, 0.5),
            clamped(behind.share, 0.0, 1.0),
            clamped(behind.depth, -0.5, 0.5),
            clamped(ahead.share, 0.0, 1.0),
            clamped(ahead.depth, -0.5, 0.5),
            // Base, and the angle by which it is tipped over.
            clamped(low.base / under.footprint * 0.5 * self.body.doubled_area, 0.0, 2.0),
            clamped(clamped(under.depth, -0.5, 0.5) * under.footprint.sqrt() / above, -3.0, 3.0),
            // Textures.
            up.of(self.rise[up.axis]),
            front.of(self.rise[front.axis]),
            // The floor of the file.
            clamped(up.low(body) / height, -1.5, 1.0),
            clamped(front.low(body) / depth, -1.5, 1.0),
            clamped(front.low(body) / depth + 1.0, -1.0, 1.5),
            middle(front.axis),
            middle(up.axis),
            middle(ACROSS),
            // Spread of the surface.
            self.variance[up.axis],
            self.variance[front.axis],
            self.variance[ACROSS],
        ]
    }

    /// Surface towards the beginning and the end of a direction.
    fn ends(&self, d: Directed) -> [Side; 2] {
        let [low, high] = self.sides[d.axis];
        if d.is_positive { [low, high] } else { [high, low] }
    }

    /// Contact at the beginning of a direction, or at its end, `far`.
    fn touch(&self, d: Directed, far: bool) -> Contact {
        self.contacts[d.axis - 1][usize::from(far == d.is_positive)]
    }
}

impl Directed {
    /// A coordinate in this direction.
    fn of(self, v: f64) -> f64 {
        if self.is_positive { v } else { -v }
    }

    /// Coordinate in this direction where a body begins.
    fn low(self, body: &Body<'_>) -> f64 {
        if self.is_positive { body.min[self.axis] } else { -body.max[self.axis] }
    }
}

/// The same pose with the floor of the file in the middle of the body, where it tells nothing.
pub(super) fn without_floor(features: &Features) -> Features {
    let mut features = *features;
    features[OF_FLOOR].copy_from_slice(&[-0.5, -0.5, 0.5, 0.0, 0.0, 0.0]);
    features
}

/// Adds a triangle to the surface that faces an end: its share, the cosine of its slope, its distance from the end by the side
/// of the box, and whether it is within the layer that touches a floor there.
fn add(side: &mut Side, share: f64, cosine: f64, from_end: f64, is_in_layer: bool) {
    if cosine > IS_FLAT {
        side.flat += share;
        side.shelf += if from_end > SHELF && from_end < 1.0 - SHELF { share } else { 0.0 };
        side.closing += if from_end < CLOSING { share } else { 0.0 };
        side.base += if is_in_layer { share } else { 0.0 };
    } else if cosine > LEANS {
        side.slant += share;
    }
    if cosine > HANGS && !is_in_layer {
        side.hang += share;
    }
}

/// A number within bounds; what is none is the lower one.
fn clamped(v: f64, low: f64, high: f64) -> f64 {
    if v > low { if v < high { v } else { high } } else { low }
}

/// Sum over triangles of the unit vectors in which their textures are upright, times their doubled areas.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Rise(Point);

impl Rise {
    /// Adds a triangle with the texture coordinates of its corners, of which the second runs down.
    pub(super) fn add(&mut self, triangle: &Triangle, [p, q, r]: [[f64; 2]; 3]) {
        let [a, b, c] = triangle;
        let [u, v]: [Point; 2] = [b, c].map(|p| std::array::from_fn(|k| p[k] - a[k]));
        let [du, dv] = [[q[0] - p[0], r[0] - p[0]], [q[1] - p[1], r[1] - p[1]]];
        let determinant = du[0] * dv[1] - du[1] * dv[0];
        // The derivative of the position by the second coordinate, but for its length.
        let down: Point = std::array::from_fn(|k| (du[0] * v[k] - du[1] * u[k]) * determinant);
        let (size, weight) = (length(&down), length(&doubled_normal(triangle)));
        if size > 0.0 && size.is_finite() {
            for k in 0..3 {
                self.0[k] -= weight * (down[k] / size);
            }
        }
    }
}
