//! Rays against triangles: a hierarchy of boxes, sixteen children wide.
//!
//! Every node has up to sixteen children and every leaf up to sixteen triangles, so one ray meets all of them in one pass of
//! vector arithmetic, whatever direction its neighbours go in. Binary trees are built by the surface area heuristic
//! (MacDonald and Booth 1990) in bins (Wald 2007) and then opened into wide ones (Wald, Benthin and Boulos 2008, "Getting rid
//! of packets").
//!
//! **Invariant:** what a ray hits does not depend on the number of threads nor on the instruction set: the nearest, of equally
//! near triangles the one with the lowest number. A ray through an edge or a vertex that triangles share, bit by bit the same
//! corner in each, hits at least one of them.

mod build;
mod intersect;
#[cfg(test)]
mod tests;

pub use intersect::{Hit, Ray, Traversal};

use overcoat_core::math::lanes::LANES;

/// Triangles in world space, and the boxes around them.
#[derive(Clone, Debug, Default)]
pub struct Hierarchy {
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

impl Hierarchy {
    /// Triangles that one can hold.
    pub const MAX_TRIANGLES: usize = 1 << 27;

    /// Number of nodes and leaves.
    #[must_use]
    pub fn len(&self) -> usize {
        self.nodes.len() + self.leaves.len()
    }

    /// True if no ray hits anything.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }

    /// Numbers of the triangles in the leaves, sixteen a leaf, [`u32::MAX`] for those that are missing.
    pub fn triangles(&self) -> impl Iterator<Item = u32> + '_ {
        self.leaves.iter().flat_map(|leaf| leaf.triangles)
    }

    /// Bytes that nodes and leaves take.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.nodes.len() * size_of::<Node>() + self.leaves.len() * size_of::<Leaf>()
    }
}
