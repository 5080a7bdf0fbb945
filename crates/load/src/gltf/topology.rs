//! Topology of primitives: the `mode` by which vertices form points, lines and triangles.

use overcoat_scene::PrimitiveKind;

/// Topology of a primitive: points, lines or triangles, and the vertices that each of them has.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Topology {
    /// Three vertices each.
    List,
    /// Each further vertex with the two before.
    Strip,
    /// Each further vertex with the one before and the first.
    Fan,
    /// Points, one vertex each.
    Points,
    /// Lines of two vertices each.
    Lines,
    /// Each further vertex with the one before, and the last with the first.
    LineLoop,
    /// Each further vertex with the one before.
    LineStrip,
}

impl Topology {
    /// The `mode` of a primitive; `None` for a number that is none.
    pub(super) fn of_mode(mode: u32) -> Option<Self> {
        let all =
            [Self::Points, Self::Lines, Self::LineLoop, Self::LineStrip, Self::List, Self::Strip, Self::Fan];
        all.get(mode as usize).copied()
    }

    /// Kind of the primitives.
    pub(super) fn kind(self) -> PrimitiveKind {
        match self {
            Self::List | Self::Strip | Self::Fan => PrimitiveKind::Triangles,
            Self::Points => PrimitiveKind::Points,
            Self::Lines | Self::LineLoop | Self::LineStrip => PrimitiveKind::Lines,
        }
    }

    /// Number of triangles, lines or points that so many vertices form.
    pub(super) fn triangles(self, vertices: u64) -> u64 {
        match self {
            Self::List => vertices / 3,
            Self::Strip | Self::Fan => vertices.saturating_sub(2),
            Self::Points => vertices,
            Self::Lines => vertices / 2,
            Self::LineLoop if vertices < 2 => 0,
            Self::LineLoop => vertices,
            Self::LineStrip => vertices.saturating_sub(1),
        }
    }

    /// Number of vertices that form `count` triangles, lines or points, of which there is at least one.
    pub(super) fn vertices(self, count: usize) -> usize {
        match self {
            Self::List => count.saturating_mul(3),
            Self::Strip | Self::Fan => count.saturating_add(2),
            Self::Points | Self::LineLoop => count,
            Self::Lines => count.saturating_mul(2),
            Self::LineStrip => count.saturating_add(1),
        }
    }
}

/// The triangles, lines or points of vertices, with the winding of section 3.7.2.1 of the specification.
pub(super) fn connect(topology: Topology, vertices: impl Iterator<Item = u32> + Clone) -> Vec<[u32; 3]> {
    let second = vertices.clone().skip(1);
    let pairs = vertices.clone().zip(second.clone());
    let line = |(a, b): (u32, u32)| [a, b, b];
    match topology {
        Topology::List => {
            let threes = pairs.zip(second.skip(1)).step_by(3);
            threes.map(|((a, b), c)| [a, b, c]).collect()
        }
        Topology::Strip => {
            let turned = [false, true].into_iter().cycle();
            let threes = pairs.zip(second.skip(1)).zip(turned);
            threes.map(|(((a, b), c), turned)| if turned { [a, c, b] } else { [a, b, c] }).collect()
        }
        Topology::Fan => {
            let others = second.clone().zip(second.skip(1));
            vertices.take(1).flat_map(|first| others.clone().map(move |(b, c)| [b, c, first])).collect()
        }
        Topology::Points => vertices.map(|v| [v; 3]).collect(),
        Topology::Lines => pairs.step_by(2).map(line).collect(),
        Topology::LineLoop => vertices.clone().zip(second.chain(vertices.take(1))).map(line).collect(),
        Topology::LineStrip => pairs.map(line).collect(),
    }
}

/// Triangles that share no vertices: 0, 1, 2; 3, 4, 5; and so on.
pub(super) fn separate(count: usize) -> Vec<[u32; 3]> {
    let mut triangles = vec![[0; 3]; count];
    for (corner, vertex) in triangles.as_flattened_mut().iter_mut().zip(0..=u32::MAX) {
        *corner = vertex;
    }
    triangles
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strips_and_fans_keep_their_winding() {
        assert_eq!(connect(Topology::Strip, 0..5), [[0, 1, 2], [1, 3, 2], [2, 3, 4]]);
        assert_eq!(connect(Topology::Fan, 0..4), [[1, 2, 0], [2, 3, 0]]);
        assert_eq!(connect(Topology::Points, 0..2), [[0; 3], [1; 3]]);
        assert_eq!(connect(Topology::Lines, 0..4), [[0, 1, 1], [2, 3, 3]]);
        assert_eq!(connect(Topology::LineStrip, 0..3), [[0, 1, 1], [1, 2, 2]]);
        assert_eq!(connect(Topology::LineLoop, 0..3), [[0, 1, 1], [1, 2, 2], [2, 0, 0]]);
        assert_eq!(connect(Topology::List, [5, 3, 4, 3, 5, 9].into_iter()), [[5, 3, 4], [3, 5, 9]]);
        assert_eq!(separate(2), [[0, 1, 2], [3, 4, 5]]);
        for mode in 0..7 {
            let topology = Topology::of_mode(mode).unwrap();
            let vertices = topology.vertices(5) as u32;
            assert_eq!(topology.triangles(vertices.into()), 5, "{topology:?}");
            assert_eq!(connect(topology, 0..vertices).len(), 5, "{topology:?}");
            assert_eq!(topology.triangles(0), 0);
        }
        assert_eq!(Topology::of_mode(7), None);
        assert_eq!([5, 6].map(|n| Topology::Strip.triangles(n)), [3, 4]);
        assert_eq!([0, 1, 2].map(|n| Topology::Fan.triangles(n)), [0, 0, 0]);
        assert_eq!([2, 3, 7].map(|n| Topology::List.triangles(n)), [0, 1, 2]);
    }
}
