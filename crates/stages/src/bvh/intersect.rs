//! Rays on their way through a hierarchy.

use super::places::Place;
use super::{Child, Hierarchy, Leaf, Node, Tree};
use overcoat_core::each;
use overcoat_core::math::lanes::{Float, LANES, Lanes, Mask};

/// A ray, or a part of one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Origin, from which distances are measured.
    pub origin: [f32; 3],
    /// Direction, of any length but zero: its length is the unit of distances.
    pub direction: [f32; 3],
    /// Distance before which nothing is hit.
    pub near: f32,
    /// Distance from which on nothing is hit; may be infinite.
    pub far: f32,
}

/// Visits that bringing a ray to a place counts as, or a leaf.
const PLACED: u64 = 6;

/// Intersection of a ray with a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// In lengths of the ray's direction.
    pub distance: f32,
    /// Number of the triangle.
    pub triangle: u32,
    /// Weights of the triangle's second and third corners.
    pub barycentrics: [f32; 2],
}

/// Memory of one thread for the way through a hierarchy, kept from ray to ray.
#[derive(Clone, Debug, Default)]
pub struct Traversal {
    /// Nodes and leaves that are still to be visited, each with the distance at which the ray enters it.
    todo: Vec<(f32, Child)>,
    /// Nodes of the tree of places and places, likewise.
    places: Vec<(f32, Child)>,
    /// Nodes and leaves that were visited since it was asked last.
    visited: u64,
}

impl Traversal {
    /// Number of nodes and leaves visited since the last call, those of meshes that are kept once several times: a measure of work that
    /// depends on nothing but rays and triangles.
    pub fn take_visited(&mut self) -> u64 {
        std::mem::take(&mut self.visited)
    }
}

/// A ray in lanes, with what boxes ask of it.
#[derive(Clone, Copy)]
pub(super) struct RayBoxes<L: Lanes> {
    /// Origins for the sides where it enters boxes, and where it leaves them: apart by the margin of the boxes.
    origins: [[L::F; 3]; 2],
    inverse: [L::F; 3],
    near: L::F,
    /// The ray goes down along this axis: it enters boxes at their upper sides.
    down: [bool; 3],
}

/// A ray in lanes, with what triangles ask of it.
struct RayLanes<L: Lanes> {
    origin: [L::F; 3],
    near: L::F,
    /// The axis along which it goes furthest comes last.
    axes: [usize; 3],
    /// Shear of the first two coordinates for each unit of the third, and the inverse of the direction's third
    /// coordinate: sheared and scaled by these, the ray is the third axis.
    shear: [L::F; 3],
}

impl<L: Lanes> RayBoxes<L> {
    /// A ray of that origin and direction, for boxes that are to be larger by a margin.
    #[inline(always)]
    pub(super) fn new(
        l: L,
        (origin, direction): ([f32; 3], [f32; 3]),
        near: f32,
        margin: Option<[f32; 3]>,
    ) -> Self {
        // Instead of an infinite number: 0 times that would be none. What this shifts is far below rounding.
        const LEAST: f32 = 1e-30;
        let inverse = each!(d in direction => 1.0 / if d < LEAST && d > -LEAST { LEAST } else { d });
        let down: [bool; 3] = each!(v in inverse => v < 0.0);
        let mut origins = [origin; 2];
        if let Some(margin) = margin {
            for k in 0..3 {
                let by = if down[k] { -margin[k] } else { margin[k] };
                origins[0][k] += by;
                origins[1][k] -= by;
            }
        }
        Self {
            origins: each!(origin in origins => each!(v in origin => l.splat(v))),
            inverse: each!(v in inverse => l.splat(v)),
            near: l.splat(near),
            down,
        }
    }

    /// Distances at which boxes are entered, and which of them are, before `far`.
    #[inline(always)]
    fn enters(&self, l: L, node: &Node, far: f32) -> (L::F, L::M) {
        let mut enter = self.near;
        let mut leave = l.splat(far);
        for k in 0..3 {
            let (first, last) =
                if self.down[k] { (&node.high[k], &node.low[k]) } else { (&node.low[k], &node.high[k]) };
            enter = enter.max((l.load(first) - self.origins[0][k]) * self.inverse[k]);
            leave = leave.min((l.load(last) - self.origins[1][k]) * self.inverse[k]);
        }
        (enter, enter.le(leave))
    }
}

impl<L: Lanes> RayLanes<L> {
    #[inline(always)]
    fn new(l: L, ray: &Ray) -> Self {
        let [x, y, z] = each!(d in ray.direction => d.abs());
        let axes = if x >= y && x >= z {
            [1, 2, 0]
        } else if y >= z {
            [2, 0, 1]
        } else {
            [0, 1, 2]
        };
        let [first, second, along] = each!(axis in axes => ray.direction[axis]);
        Self {
            origin: each!(v in ray.origin => l.splat(v)),
            near: l.splat(ray.near),
            axes,
            shear: [l.splat(first / along), l.splat(second / along), l.splat(1.0 / along)],
        }
    }

    /// Distances and weights of the second and third corners where triangles are hit, and which of them are; from both sides.
    ///
    /// Woop, Benthin and Wald 2013, "Watertight ray/triangle intersection", without the second try in double precision: a
    /// product that is larger is never rounded to one that is smaller, so the sign of an edge is right or 0, for all triangles
    /// that share its corners, and 0 counts as inside of all of them.
    #[inline(always)]
    fn hits(&self, l: L, leaf: &Leaf) -> (L::F, [L::F; 2], L::M) {
        let [a, b, c] = each!(corner in [&leaf.corners[0], &leaf.corners[1], &leaf.corners[2]] => {
            let [x, y, z]: [L::F; 3] = each!(axis in self.axes => l.load(&corner[axis]) - self.origin[axis]);
            [x - self.shear[0] * z, y - self.shear[1] * z, z * self.shear[2]]
        });
        let u = c[0] * b[1] - c[1] * b[0];
        let v = a[0] * c[1] - a[1] * c[0];
        let w = b[0] * a[1] - b[1] * a[0];
        let zero = l.zero();
        let inside = (u.ge(zero) & v.ge(zero) & w.ge(zero)) | (u.le(zero) & v.le(zero) & w.le(zero));
        let sum = (u + v) + w;
        let inverse = sum.recip();
        let (v, w) = (v * inverse, w * inverse);
        let distance = (u * inverse * a[2] + v * b[2]) + w * c[2];
        // Not of triangles without area, nor of those that the ray lies in: there the sum is 0.
        (distance, [v, w], inside & !sum.eq(zero) & distance.gt(self.near))
    }
}

impl Hierarchy {
    /// The nearest triangle that a ray hits and `accept` does not refuse (alpha masks); of equally near ones that with the
    /// lowest number.
    #[inline(always)]
    pub fn nearest<L: Lanes>(
        &self,
        l: L,
        ray: &Ray,
        traversal: &mut Traversal,
        mut accept: impl FnMut(&Hit) -> bool,
    ) -> Option<Hit> {
        let mut nearest: Option<Hit> = None;
        self.visit(
            l,
            ray,
            traversal,
            #[inline(always)]
            |hit, far| {
                let tie = |other: &Hit| hit.distance == other.distance && hit.triangle > other.triangle;
                if !nearest.as_ref().is_some_and(tie) && accept(&hit) {
                    nearest = Some(hit);
                    *far = hit.distance;
                }
                true
            },
        );
        nearest
    }

    /// True if a ray hits any triangle that `accept` does not refuse.
    #[inline(always)]
    pub fn is_blocked<L: Lanes>(
        &self,
        l: L,
        ray: &Ray,
        traversal: &mut Traversal,
        mut accept: impl FnMut(&Hit) -> bool,
    ) -> bool {
        let mut blocked = false;
        self.visit(
            l,
            ray,
            traversal,
            #[inline(always)]
            |hit, _| {
                blocked = accept(&hit);
                !blocked
            },
        );
        blocked
    }

    /// Visits hits up to `far`, which the visitor may bring nearer, until it returns false: of triangles that stand once,
    /// then of the places, the nearest first.
    #[inline(always)]
    fn visit<L: Lanes>(
        &self,
        l: L,
        ray: &Ray,
        traversal: &mut Traversal,
        mut visit: impl FnMut(Hit, &mut f32) -> bool,
    ) {
        let Traversal { todo, places, visited } = traversal;
        places.clear();
        if !self.top.nodes.is_empty() {
            places.push((ray.near, Child::node(0)));
        }
        let lanes = RayLanes::new(l, ray);
        let in_world = RayBoxes::new(l, (ray.origin, ray.direction), ray.near, None);
        let mut far = ray.far;
        let mut next: Option<(&Tree, RayBoxes<L>, Option<&Place>)> = Some((&self.once, in_world, None));
        while let Some((tree, boxes, place)) = next {
            todo.clear();
            if !tree.nodes.is_empty() {
                todo.push((ray.near, Child::node(0)));
            }
            while let Some((enter, child)) = todo.pop() {
                // At the same distance another triangle may be hit, with a lower number.
                if enter > far {
                    continue;
                }
                *visited += 1;
                if child.0 & Child::LEAF == 0 {
                    push_children(l, &tree.nodes[child.0 as usize], &boxes, far, todo);
                    continue;
                }
                let leaf = &tree.leaves[(child.0 & !Child::LEAF) as usize];
                let placed;
                let (leaf, first) = match place {
                    Some(place) => {
                        *visited += PLACED - 1;
                        placed = place.leaf(leaf);
                        (&placed, place.first)
                    }
                    None => (leaf, 0),
                };
                let (distances, [v, w], hit) = lanes.hits(l, leaf);
                let mut left = (hit & distances.le(l.splat(far))).bits();
                if left == 0 {
                    continue;
                }
                let (distances, v, w) = (distances.to_array(), v.to_array(), w.to_array());
                while left != 0 {
                    let k = left.trailing_zeros() as usize % LANES;
                    left &= left - 1;
                    let (triangle, barycentrics) = (first + leaf.triangles[k], [v[k], w[k]]);
                    let hit = Hit { distance: distances[k], triangle, barycentrics };
                    // One before it may have been nearer. What lies at the end of the ray itself is beyond it.
                    if hit.distance > far || hit.distance >= ray.far {
                        continue;
                    }
                    if !visit(hit, &mut far) {
                        return;
                    }
                }
            }
            next = self.next_place(l, ray, &in_world, far, (&mut *places, &mut *visited));
        }
    }

    /// The next place that a ray enters before `far`, with what the boxes there ask of it.
    #[inline(always)]
    fn next_place<L: Lanes>(
        &self,
        l: L,
        ray: &Ray,
        in_world: &RayBoxes<L>,
        far: f32,
        (places, visited): (&mut Vec<(f32, Child)>, &mut u64),
    ) -> Option<(&Tree, RayBoxes<L>, Option<&Place>)> {
        while let Some((enter, child)) = places.pop() {
            if enter > far {
                continue;
            }
            *visited += 1;
            if child.0 & Child::LEAF == 0 {
                push_children(l, &self.top.nodes[child.0 as usize], in_world, far, places);
                continue;
            }
            let place = &self.places[(child.0 & !Child::LEAF) as usize];
            *visited += PLACED - 1;
            return Some((&self.meshes[place.mesh], place.boxes(l, ray), Some(place)));
        }
        None
    }
}

/// Puts the children that a ray enters before `far` on the list, the nearest last.
#[inline(always)]
fn push_children<L: Lanes>(l: L, node: &Node, ray: &RayBoxes<L>, far: f32, todo: &mut Vec<(f32, Child)>) {
    let (enter, entered) = ray.enters(l, node, far);
    let mut left = entered.bits();
    if left == 0 {
        return;
    }
    let enter = enter.to_array();
    let first = todo.len();
    while left != 0 {
        let k = left.trailing_zeros() as usize % LANES;
        left &= left - 1;
        let item = (enter[k], node.children[k]);
        // Few are entered: insertion is as fast as anything.
        let mut place = todo.len();
        todo.push(item);
        while place > first && todo[place - 1].0 < item.0 {
            todo[place] = todo[place - 1];
            place -= 1;
        }
        todo[place] = item;
    }
}
