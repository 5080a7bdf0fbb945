//! Groups of edges that hang together.

use super::Edge;

/// Edges that hang together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EdgeGroup {
    /// Middle of the box around them, in object space.
    pub center: [f32; 3],
    /// Longest side of the box.
    pub extent: f32,
}

/// Sorts edges into groups. Returns the number of the group of each, and the groups.
pub(super) fn group(
    edges: &[Edge],
    place: impl Fn(u32) -> [f32; 3],
    vertices: usize,
) -> (Vec<u32>, Vec<EdgeGroup>) {
    let mut roots: Vec<u32> = (0..vertices as u32).collect();
    for edge in edges {
        let [a, b] = edge.ends.map(|end| root(&mut roots, end));
        let (low, high) = if a < b { (a, b) } else { (b, a) };
        roots[high as usize] = low;
    }
    let mut boxes: Vec<Extent> = Vec::new();
    // Numbers of the groups by their roots.
    let mut numbers = vec![u32::MAX; vertices];
    let mut group_of = |edge: &Edge| {
        let number = &mut numbers[root(&mut roots, edge.ends[0]) as usize];
        if *number == u32::MAX {
            *number = boxes.len() as u32;
            boxes.push(Extent { min: [f32::INFINITY; 3], max: [f32::NEG_INFINITY; 3] });
        }
        edge.ends.iter().for_each(|&end| boxes[*number as usize].add(place(end)));
        *number
    };
    let groups_of = edges.iter().map(&mut group_of).collect();
    (groups_of, boxes.iter().map(Extent::group).collect())
}

/// The lowest vertex of a group. Ways are halved as they are walked.
fn root(roots: &mut [u32], mut vertex: u32) -> u32 {
    while roots[vertex as usize] != vertex {
        let next = roots[roots[vertex as usize] as usize];
        roots[vertex as usize] = next;
        vertex = next;
    }
    vertex
}

/// Box of a group while it is found.
struct Extent {
    min: [f32; 3],
    max: [f32; 3],
}

impl Extent {
    fn add(&mut self, place: [f32; 3]) {
        for (axis, v) in place.into_iter().enumerate() {
            self.min[axis] = if v < self.min[axis] { v } else { self.min[axis] };
            self.max[axis] = if v > self.max[axis] { v } else { self.max[axis] };
        }
    }

    fn group(&self) -> EdgeGroup {
        let extent = (0..3).fold(0.0, |extent, axis| {
            let side = self.max[axis] - self.min[axis];
            if side > extent { side } else { extent }
        });
        let center = std::array::from_fn(|axis| 0.5 * self.min[axis] + 0.5 * self.max[axis]);
        EdgeGroup { center, extent }
    }
}
