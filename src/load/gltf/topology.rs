//! How vertices form points, lines and triangles: the `mode` of a primitive.

use crate::scene::PrimitiveKind;

/// How vertices form points, lines or triangles.
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

    /// What they are.
    pub(super) fn kind(self) -> PrimitiveKind {
        match self {
            Self::List | Self::Strip | Self::Fan => PrimitiveKind::Triangles,
            Self::Points => PrimitiveKind::Points,
            Self::Lines | Self::LineLoop | Self::LineStrip => PrimitiveKind::Lines,
        }
    }

    /// How many triangles, lines or points so many vertices form.
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

    /// How many vertices form so many of them, at least one.
    pub(super) fn vertices(self, count: usize) -> usize {
        match self {
            Self::List => 3 * count,
            Self::Strip | Self::Fan => count + 2,
            Self::Points | Self::LineLoop => count,
            Self::Lines => 2 * count,
            Self::LineStrip => count + 1,
        }
    }
}

/// `count` triangles, lines or points of anything but a list of triangles, with the winding of section 3.7.2.1 of the
/// specification.
pub(super) fn connect(topology: Topology, count: usize, vertex: impl Fn(usize) -> u32) -> Vec<[u32; 3]> {
    let triangle = |k: usize| match topology {
        Topology::Fan => [vertex(k + 1), vertex(k + 2), vertex(0)],
        Topology::Points => [vertex(k); 3],
        Topology::Lines => [vertex(2 * k), vertex(2 * k + 1), vertex(2 * k + 1)],
        Topology::LineStrip => [vertex(k), vertex(k + 1), vertex(k + 1)],
        Topology::LineLoop => {
            let next = vertex(if k + 1 < count { k + 1 } else { 0 });
            [vertex(k), next, next]
        }
        _ => [vertex(k), vertex(k + 1 + k % 2), vertex(k + 2 - k % 2)],
    };
    (0..count).map(triangle).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strips_and_fans_keep_their_winding() {
        let own = |k: usize| k as u32;
        assert_eq!(connect(Topology::Strip, 3, own), [[0, 1, 2], [1, 3, 2], [2, 3, 4]]);
        assert_eq!(connect(Topology::Fan, 2, own), [[1, 2, 0], [2, 3, 0]]);
        assert_eq!(connect(Topology::Points, 2, own), [[0; 3], [1; 3]]);
        assert_eq!(connect(Topology::Lines, 2, own), [[0, 1, 1], [2, 3, 3]]);
        assert_eq!(connect(Topology::LineStrip, 2, own), [[0, 1, 1], [1, 2, 2]]);
        assert_eq!(connect(Topology::LineLoop, 3, own), [[0, 1, 1], [1, 2, 2], [2, 0, 0]]);
        for mode in 0..7 {
            let topology = Topology::of_mode(mode).unwrap();
            assert_eq!(topology.triangles(topology.vertices(5) as u64), 5, "{topology:?}");
            assert_eq!(topology.triangles(0), 0);
        }
        assert_eq!(Topology::of_mode(7), None);
        assert_eq!([5, 6].map(|n| Topology::Strip.triangles(n)), [3, 4]);
        assert_eq!([0, 1, 2].map(|n| Topology::Fan.triangles(n)), [0, 0, 0]);
        assert_eq!([2, 3, 7].map(|n| Topology::List.triangles(n)), [0, 1, 2]);
    }
}
