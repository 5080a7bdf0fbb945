//! Meshes that stand at several places, kept once: a tree in the space of each mesh, below a tree of the places.
//!
//! Boxes are asked in the space of the mesh, triangles where they are: their corners are brought there by the arithmetic that
//! lists of all triangles are made by, so that every hit has the bits that it has there, whichever meshes are kept once.

use super::build::Bounds;
use super::intersect::{Ray, RayBoxes};
use super::{Hierarchy, Leaf, Tree};
use overcoat_core::each;
use overcoat_core::jobs::Jobs;
use overcoat_core::math::lanes::{LANES, Lanes};
use overcoat_scene::Transform;

/// Largest number of units of one space in another: beyond that, rounding in the space of the mesh says too little.
const LARGEST: f64 = 1e15;

/// Largest product of the norms of a transform and of its inverse.
const CONDITION: f64 = 1e6;

/// Share of the largest coordinates that boxes are made larger by in the space of a mesh: for the corners' rounding in the world,
/// and for that of the ray and of the slabs' distances in the space of the mesh.
const MARGIN: f64 = 1.0 / (1 << 19) as f64;

/// A mesh, and the places where it stands.
#[derive(Clone, Debug)]
pub struct Shared {
    /// Triangles in the mesh's own space.
    pub triangles: Vec<[[f32; 3]; 3]>,
    /// Places that can be [shared](can_be_shared), each with the number of its first triangle.
    pub places: Vec<(Transform, u32)>,
}

/// A place of a mesh.
#[derive(Clone, Debug)]
pub(super) struct Place {
    rows: [[f64; 4]; 3],
    /// From the world to the space of the mesh.
    inverse: [[f64; 4]; 3],
    /// Number of the first triangle.
    pub first: u32,
    /// Number of the mesh.
    pub mesh: usize,
    /// Length by which boxes are made larger along each axis.
    margin: [f32; 3],
}

/// True if a mesh can be kept once for this place and others.
#[must_use]
pub fn can_be_shared(place: &Transform) -> bool {
    inverse(place.rows()).is_some()
}

impl Hierarchy {
    /// Builds it over triangles in world space, whose numbers `number_of` says from their order, and over shared meshes. Numbers
    /// grow with the order.
    #[must_use]
    pub fn with_shared(
        triangles: &[[[f32; 3]; 3]],
        number_of: impl Fn(u32) -> u32,
        shared: &[Shared],
        jobs: &Jobs,
    ) -> Self {
        let mut hierarchy = Self::new(triangles, jobs);
        hierarchy.once.renumber(number_of);
        let mut boxes = Vec::new();
        let mut everything = Bounds::NOTHING;
        triangles.iter().for_each(|triangle| everything.add(&Bounds::of(triangle)));
        for (mesh, Shared { triangles, places }) in shared.iter().enumerate() {
            let mut own = Bounds::NOTHING;
            triangles.iter().for_each(|triangle| own.add(&Bounds::of(triangle)));
            hierarchy.meshes.push(Tree::new(triangles, jobs));
            for (transform, first) in places {
                let Some(place) = Place::new(transform, *first, mesh) else { continue };
                boxes.push(place.around(&own));
                hierarchy.places.push(place);
            }
        }
        boxes.iter().for_each(|place| everything.add(place));
        for place in &mut hierarchy.places {
            let own = hierarchy.meshes[place.mesh].largest();
            place.find_margin(f64::from(everything.largest()), f64::from(own));
        }
        hierarchy.top = Tree::of_boxes(&boxes, jobs);
        hierarchy
    }
}

impl Tree {
    /// The largest coordinate of its boxes.
    fn largest(&self) -> f32 {
        let Some(root) = self.nodes.first() else { return 0.0 };
        let of = |k: usize| Bounds { low: each!(c => root.low[c][k]), high: each!(c => root.high[c][k]) };
        let mut all = Bounds::NOTHING;
        (0..LANES).for_each(|k| all.add(&of(k)));
        all.largest()
    }
}

impl Place {
    fn new(transform: &Transform, first: u32, mesh: usize) -> Option<Self> {
        let rows = *transform.rows();
        Some(Self { rows, inverse: inverse(&rows)?, first, mesh, margin: [0.0; 3] })
    }

    /// A box around the corners of triangles in a box of the mesh, where they are.
    fn around(&self, own: &Bounds) -> Bounds {
        let mut bounds = Bounds::NOTHING;
        for k in 0..3 {
            let [mut low, mut high] = [self.rows[k][3]; 2];
            let mut most = 0.0;
            for c in 0..3 {
                let [a, b] = [own.low[c], own.high[c]].map(|v| self.rows[k][c] * f64::from(v));
                low += if a < b { a } else { b };
                high += if a < b { b } else { a };
                most += if a.abs() > b.abs() { a.abs() } else { b.abs() };
            }
            // Enough for what corners are rounded by.
            let rounding = (most + self.rows[k][3].abs()) / f64::from(1 << 22);
            bounds.low[k] = (low - rounding) as f32;
            bounds.high[k] = (high + rounding) as f32;
        }
        bounds
    }

    /// Finds the margin, from the largest coordinates in the world and in the space of the mesh.
    fn find_margin(&mut self, world: f64, own: f64) {
        self.margin = each!(k => {
            let [x, y, z, _] = self.inverse[k].map(f64::abs);
            let margin = MARGIN * (own + 2.0 * world * ((x + y) + z));
            if margin < 1e30 { margin as f32 } else { 1e30 }
        });
    }

    /// A ray as the boxes of the mesh are asked for it. Distances stay.
    #[inline(always)]
    pub(super) fn boxes<L: Lanes>(&self, l: L, ray: &Ray) -> RayBoxes<L> {
        let [origin, direction]: [[f64; 3]; 2] =
            each!(v in [ray.origin, ray.direction] => each!(c in v => f64::from(c)));
        let turned = |row: &[f64; 4], v: &[f64; 3]| row[0] * v[0] + row[1] * v[1] + row[2] * v[2];
        let origin = each!(k => (turned(&self.inverse[k], &origin) + self.inverse[k][3]) as f32);
        let direction = each!(k => turned(&self.inverse[k], &direction) as f32);
        RayBoxes::new(l, (origin, direction), ray.near, Some(self.margin))
    }

    /// Triangles of the mesh where they are: with the corners that [`Transform::point`] says.
    #[inline(always)]
    pub(super) fn leaf(&self, leaf: &Leaf) -> Leaf {
        let mut placed = Leaf { corners: [[[0.0; LANES]; 3]; 3], triangles: leaf.triangles };
        for (to, [x, y, z]) in placed.corners.iter_mut().zip(&leaf.corners) {
            for (to, row) in to.iter_mut().zip(&self.rows) {
                for k in 0..LANES {
                    let [x, y, z] = [x[k], y[k], z[k]].map(f64::from);
                    to[k] = (row[0] * x + row[1] * y + row[2] * z + row[3]) as f32;
                }
            }
        }
        placed
    }
}

/// The inverse of an affine map, if it is one that numbers can tell.
fn inverse(rows: &[[f64; 4]; 3]) -> Option<[[f64; 4]; 3]> {
    let [a, b, c] = rows.map(|[x, y, z, _]| [x, y, z]);
    let cross = |a: [f64; 3], b: [f64; 3]| {
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    };
    let cofactors = [cross(b, c), cross(c, a), cross(a, b)];
    let determinant = (a[0] * cofactors[0][0] + a[1] * cofactors[0][1]) + a[2] * cofactors[0][2];
    let mut inverse = [[0.0; 4]; 3];
    for (k, row) in inverse.iter_mut().enumerate() {
        for c in 0..3 {
            row[c] = cofactors[c][k] / determinant;
        }
        row[3] = -((row[0] * rows[0][3] + row[1] * rows[1][3]) + row[2] * rows[2][3]);
    }
    let norm = |rows: &[[f64; 4]; 3]| {
        let sums = rows.map(|[x, y, z, _]| (x.abs() + y.abs()) + z.abs());
        sums.into_iter().fold(0.0, |most, sum| if sum > most { sum } else { most })
    };
    let all = rows.iter().chain(&inverse).flatten();
    let is_moderate = all.into_iter().all(|v| v.abs() < LARGEST);
    (is_moderate && norm(rows) * norm(&inverse) < CONDITION).then_some(inverse)
}
