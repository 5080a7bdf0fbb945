//! Evidence of the axis that is up, weighed.

use super::rest::{Body, Contact, Point, Triangle, doubled_normal, length};

/// Features of a pose.
const FEATURES: usize = 11;

/// Their weights: natural logarithms of odds for each unit, in the order of [`Evidence::new`] and
/// [`Evidence::with_contacts`].
///
/// Fitted by logistic regression (L2, C = 0.5, no intercept, features by their standard deviation) to differences between the
/// upright pose and the other one, of 636 glTF models, which are +Y up by their format, and of 173 printed parts in STL that
/// lie as they are printed, +Z up. Each stands in it as it is and turned to the other axis, with and without texture
/// coordinates, and at a quarter of the weight without the floor of the file; sources of many files count less for each.
const WEIGHTS: [f64; FEATURES] = [-2.26, -1.12, 2.24, -3.08, 1.29, 3.59, -4.67, 0.79, 0.23, 1.09, 1.05];

/// Weight of the asymmetry along the axis.
const ASYMMETRY: f64 = 1.37;

/// Features that are known without contacts.
const CHEAP: usize = 7;

/// Logarithm of the odds that turns a model by itself, 20 to 1: the custom of a format is right for most files, and a wrong
/// turn is worse than none.
const ENOUGH: f64 = 3.0;

/// Part of [`ENOUGH`] that the shape has to give, without the floor of the file: a cube or a ball has no top, wherever it lies.
const BY_SHAPE: f64 = 1.5;

/// Features of the floor of the file.
const OF_FLOOR: usize = 2;

/// Length of the mean normal from which on a body is an open sheet, as ground and banners are: it may lie or stand.
const SHEET: f64 = 0.6;

/// Length of the mean normal below which a body is closed.
const CLOSED: f64 = 0.05;

/// Cosines of the angle with the axis from which on a triangle faces down, and lies flat.
const FACES_DOWN: f64 = 0.7;
const IS_FLAT: f64 = 0.95;

/// Evidence of one axis against another.
#[derive(Debug)]
pub(super) struct Evidence {
    /// Logarithm of the odds by the features that are known.
    known: f64,
    /// The part of it that is due to the floor of the file.
    by_floor: f64,
    /// Most that others can add.
    unknown: f64,
    /// Surface that lies on the floor in either pose.
    bases: [f64; 2],
    is_sheet: bool,
}

impl Evidence {
    /// Evidence that the first of two axes is up, without contacts and symmetry.
    pub(super) fn new(body: &Body<'_>, axes: [usize; 2], rise: &Rise) -> Self {
        let (area, normal, sign) = facing(body);
        let [slopes_first, slopes_second] = axes.map(|axis| slopes(body, axis, sign));
        let of = |axis: usize, across: usize, hangs: f64| -> [f64; CHEAP] {
            let (height, bottom) = (body.side(axis), body.min[axis]);
            let lean = body.center[across] - 0.5 * (body.min[across] + body.max[across]);
            let off_floor = bottom.abs() / height;
            [
                // The floor of the file, the plane through zero: distance from it, and a body on both sides of it.
                if off_floor < 0.5 { off_floor } else { 0.5 },
                if body.is_below_floor(axis) { 1.0 } else { 0.0 },
                // The centre of mass lies low, and over the middle.
                (body.center[axis] - bottom) / height,
                lean.abs() / body.size,
                // The upper side of an open surface is there; textures are upright; few faces hang over.
                sign * normal[axis] / area,
                rise.0[axis] / area,
                hangs / area,
            ]
        };
        let first = of(axes[0], axes[1], slopes_first.hangs);
        let second = of(axes[1], axes[0], slopes_second.hangs);
        let terms: [f64; CHEAP] = std::array::from_fn(|k| WEIGHTS[k] * (first[k] - second[k]));
        let (known, by_floor) = (terms.iter().sum(), terms[..OF_FLOOR].iter().sum());
        let unknown = WEIGHTS[CHEAP..].iter().sum::<f64>() + ASYMMETRY;
        let is_sheet = axes.iter().any(|&axis| normal[axis].abs() > SHEET * area);
        Self { known, by_floor, unknown, bases: [slopes_first.base, slopes_second.base], is_sheet }
    }

    /// The same, with the contacts of both poses.
    pub(super) fn with_contacts(self, contacts: [Contact; 2]) -> Self {
        let of = |contact: Contact, base: f64| {
            [
                clamped(contact.depth, -0.5, 0.5),
                clamped(contact.share, 0.0, 1.0),
                if contact.is_firm() { 1.0 } else { 0.0 },
                clamped(base / contact.footprint, 0.0, 1.0),
            ]
        };
        let [first, second] = [0, 1].map(|k| of(contacts[k], self.bases[k]));
        let differences = first.iter().zip(second).map(|(a, b)| a - b);
        let added: f64 = WEIGHTS[CHEAP..].iter().zip(differences).map(|(weight, d)| weight * d).sum();
        Self { known: self.known + added, unknown: ASYMMETRY, ..self }
    }

    /// Most that the logarithm of the odds can be.
    pub(super) fn most(&self) -> f64 {
        self.known + self.unknown
    }

    /// True if the odds may turn the body without a rule.
    pub(super) fn can_be_enough(&self) -> bool {
        self.is_enough(self.most())
    }

    /// Logarithm of the odds, with the asymmetries along both axes: mirrors are upright, so that a body is less alike along
    /// its height.
    pub(super) fn odds(&self, [along, across]: [f64; 2]) -> f64 {
        self.known + ASYMMETRY * (along.sqrt() - across.sqrt())
    }

    /// True if odds turn the body without a rule.
    pub(super) fn is_enough(&self, odds: f64) -> bool {
        odds > ENOUGH && odds - self.by_floor > BY_SHAPE && !self.is_sheet
    }
}

/// Surface by its slope in a pose.
struct Slopes {
    /// Doubled area that faces down above the floor.
    hangs: f64,
    /// Area that lies on the floor.
    base: f64,
}

/// Doubled area, sum of the doubled normals, and -1 for a closed body that is inside out, else 1.
fn facing(body: &Body<'_>) -> (f64, Point, f64) {
    let (mut area, mut sum, mut volume) = (0.0, [0.0; 3], 0.0);
    for triangle in body.triangles {
        let normal = doubled_normal(triangle);
        area += length(&normal);
        for k in 0..3 {
            sum[k] += normal[k];
            volume += normal[k] * (triangle[0][k] - body.center[k]);
        }
    }
    let is_inside_out = volume < 0.0 && length(&sum) < CLOSED * area;
    (area, sum, if is_inside_out { -1.0 } else { 1.0 })
}

/// Slopes in the pose with an axis up.
fn slopes(body: &Body<'_>, axis: usize, sign: f64) -> Slopes {
    let top = body.top_of_contact(axis);
    let mut slopes = Slopes { hangs: 0.0, base: 0.0 };
    for triangle in body.triangles {
        let normal = doubled_normal(triangle);
        let (own, down) = (length(&normal), -sign * normal[axis]);
        if down <= FACES_DOWN * own {
            continue;
        }
        if triangle[0][axis] + triangle[1][axis] + triangle[2][axis] > 3.0 * top {
            slopes.hangs += own;
        } else if down > IS_FLAT * own {
            slopes.base += 0.5 * down;
        }
    }
    slopes
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
