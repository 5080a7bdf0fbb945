//! Rays against triangles: a hierarchy of boxes, sixteen children wide.
//!
//! Every node has up to sixteen children and every leaf up to sixteen triangles, so one ray meets all of them in one pass of
//! vector arithmetic, whatever direction its neighbours go in. Binary trees are built by the surface area heuristic
//! (MacDonald and Booth 1990) in bins (Wald 2007) and then opened into wide ones (Wald, Benthin and Boulos 2008, "Getting rid
//! of packets"). Meshes that stand at several places may be kept once: below a tree of the places (`places.rs`).
//!
//! **Invariant:** what a ray hits does not depend on the number of threads nor on the instruction set: the nearest, of equally
//! near triangles the one with the lowest number. A ray through an edge or a vertex that triangles share, bit by bit the same
//! corner in each, hits at least one of them.

mod build;
mod intersect;
mod places;
#[cfg(test)]
mod tests;

pub use intersect::{Hit, Ray, Traversal};
pub use places::{Shared, can_be_shared};

use places::Place;

use overcoat_core::math::lanes::LANES;

/// Triangles of a scene, and the boxes around them.
#[derive(Clone, Debug, Default)]
pub struct Hierarchy {
    /// Triangles that stand once, in world space.
    once: Tree,
    /// Meshes that stand at several places, in object space.
    meshes: Vec<Tree>,
    places: Vec<Place>,
    /// Boxes around the places, which its leaves are.
    top: Tree,
}

/// Triangles of one space, and the boxes around them.
#[derive(Clone, Debug, Default)]
struct Tree {
    /// The first is the root, if there is any triangle.
    nodes: Vec<Node>,
    leaves: Vec<Leaf>,
}

/// Up to sixteen boxes, and what is inside of each.
#[derive(Clone, Debug)]
#[repr(align(64))]
struct Node {
    /// x, y and z of the lower corners; infinite where there is no child.
    low: [[f32; LANES]; 3],
    /// x, y and z of the upper corners; minus infinity where there is no child.
    high: [[f32; LANES]; 3],
    children: [Child; LANES],
}

/// A node or a leaf, by its number; leaves have the highest bit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Child(u32);

impl Child {
    const LEAF: u32 = 1 << 31;

    fn leaf(number: usize) -> Self {
        Self(number as u32 | Self::LEAF)
    }

    fn node(number: usize) -> Self {
        Self(number as u32)
    }
}

/// Up to sixteen triangles. Of those that are missing all corners are one point, which no ray hits.
#[derive(Clone, Debug)]
#[repr(align(64))]
struct Leaf {
    /// x, y and z of each corner.
    corners: [[[f32; LANES]; 3]; 3],
    triangles: [u32; LANES],
}

impl Tree {
    fn bytes(&self) -> usize {
        self.nodes.len() * size_of::<Node>() + self.leaves.len() * size_of::<Leaf>()
    }
}

impl Hierarchy {
    /// Triangles that one can hold.
    pub const MAX_TRIANGLES: usize = 1 << 27;

    fn trees(&self) -> impl Iterator<Item = &Tree> {
        [&self.once, &self.top].into_iter().chain(&self.meshes)
    }

    /// Number of nodes and leaves.
    #[must_use]
    pub fn len(&self) -> usize {
        self.trees().map(|tree| tree.nodes.len() + tree.leaves.len()).sum()
    }

    /// True if no ray hits anything.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.once.nodes.is_empty() && self.top.nodes.is_empty()
    }

    /// Numbers of the triangles in the leaves, sixteen a leaf, [`u32::MAX`] for those that are missing; of meshes at several
    /// places, numbers in the mesh.
    pub fn triangles(&self) -> impl Iterator<Item = u32> + '_ {
        self.trees().flat_map(|tree| &tree.leaves).flat_map(|leaf| leaf.triangles)
    }

    /// Bytes that nodes, leaves and places take.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.trees().map(Tree::bytes).sum::<usize>() + size_of_val(self.places.as_slice())
    }
}
