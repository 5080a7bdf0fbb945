//! Which vertices triangles use, and the boxes around them.

use crate::Bounds;

/// Vertices that are looked at as one: a box in four instructions a vertex.
pub(crate) const BLOCK: usize = 64;

/// The box around points in single precision.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Extent {
    pub low: [f32; 3],
    pub high: [f32; 3],
}

impl Extent {
    const EMPTY: Self = Self { low: [f32::INFINITY; 3], high: [f32::NEG_INFINITY; 3] };

    /// The box around points, none of which has a coordinate that is NaN.
    pub(crate) fn of(points: &[[f32; 3]]) -> Self {
        // Four points at a time are three vectors of four numbers.
        let (groups, rest) = points.as_flattened().as_chunks::<12>();
        let (mut low, mut high) = ([f32::INFINITY; 12], [f32::NEG_INFINITY; 12]);
        for group in groups {
            for k in 0..12 {
                low[k] = if group[k] < low[k] { group[k] } else { low[k] };
                high[k] = if group[k] > high[k] { group[k] } else { high[k] };
            }
        }
        let mut out = Self::EMPTY;
        // Without groups there are the infinities that the search began with.
        if !groups.is_empty() {
            for corner in [low, high].as_flattened().as_chunks::<3>().0 {
                out.include(*corner);
            }
        }
        for point in rest.as_chunks::<3>().0 {
            out.include(*point);
        }
        out
    }

    fn include(&mut self, p: [f32; 3]) {
        for k in 0..3 {
            self.low[k] = if p[k] < self.low[k] { p[k] } else { self.low[k] };
            self.high[k] = if p[k] > self.high[k] { p[k] } else { self.high[k] };
        }
    }
}

/// For each of `vertices` vertices whether a triangle uses it.
///
/// # Errors
/// The number of the first triangle with a vertex that does not exist.
pub(crate) fn used_vertices(vertices: usize, triangles: &[[u32; 3]]) -> Result<Vec<bool>, usize> {
    let mut used = vec![false; vertices];
    for (block, first) in triangles.chunks(4096).zip((0..).step_by(4096)) {
        let largest =
            block.as_flattened().iter().fold(0, |largest, &v| if v > largest { v } else { largest });
        if largest as usize >= vertices {
            let outside = |t: &[u32; 3]| t.iter().any(|&v| v as usize >= vertices);
            return Err(first + block.iter().position(outside).unwrap_or(0));
        }
        for &v in block.as_flattened() {
            if let Some(used) = used.get_mut(v as usize) {
                *used = true;
            }
        }
    }
    Ok(used)
}

/// True if all are; without an early exit within a block, so that it is compiled to vectors.
pub(crate) fn all(used: &[bool]) -> bool {
    used.chunks(1024).all(|block| block.iter().fold(true, |all, &used| all & used))
}

/// The box around points, none of which has a coordinate that is NaN.
pub(crate) fn of_all(positions: &[[f32; 3]]) -> Bounds {
    let Extent { low, high } = Extent::of(positions);
    Bounds { min: low.map(f64::from), max: high.map(f64::from) }
}

/// The box around the vertices that triangles use, as if each corner of each triangle had been included in turn.
pub(crate) fn bounds(positions: &[[f32; 3]], triangles: &[[u32; 3]], used: &[bool]) -> Bounds {
    let mut extent = Extent::EMPTY;
    for (points, used) in positions.chunks(BLOCK).zip(used.chunks(BLOCK)) {
        if all(used) {
            let own = Extent::of(points);
            extent.include(own.low);
            extent.include(own.high);
        } else {
            for (point, _) in points.iter().zip(used).filter(|(_, used)| **used) {
                extent.include(*point);
            }
        }
    }
    // Of zeros the first one counts, -0 or +0.
    for k in 0..3 {
        if extent.low[k] == 0.0 || extent.high[k] == 0.0 {
            let mut coordinates = triangles.as_flattened().iter().map(|&v| positions[v as usize][k]);
            let zero = coordinates.find(|&v| v == 0.0).unwrap_or(0.0);
            extent.low[k] = if extent.low[k] == 0.0 { zero } else { extent.low[k] };
            extent.high[k] = if extent.high[k] == 0.0 { zero } else { extent.high[k] };
        }
    }
    Bounds { min: extent.low.map(f64::from), max: extent.high.map(f64::from) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boxes_are_those_of_corner_after_corner() {
        let mut state = 7_u32;
        let mut next = |n: u32| {
            state = state.wrapping_mul(0x9e37_79b1).wrapping_add(0x85eb_ca6b);
            (state >> 8) % n
        };
        for round in 0..300 {
            let vertices = 1 + next(200);
            // Few values, zeros of both signs among them.
            let values = [-0.0, 0.0, 1.0, -2.5, 0.0, 3.0];
            let (first, count) = (next(6), 1 + next(3));
            let value = |next: &mut dyn FnMut(u32) -> u32| values[((first + next(count)) % 6) as usize];
            let positions: Vec<[f32; 3]> =
                (0..vertices).map(|_| [value(&mut next), value(&mut next), value(&mut next)]).collect();
            let triangles: Vec<[u32; 3]> = if round % 3 == 0 {
                (0..vertices).map(|k| [k, (k + 1) % vertices, vertices - 1 - k]).collect()
            } else {
                (0..next(80)).map(|_| [next(vertices), next(vertices), next(vertices)]).collect()
            };
            let used = used_vertices(positions.len(), &triangles).unwrap();
            let mut expected = Bounds::EMPTY;
            for &v in triangles.as_flattened() {
                expected.include(positions[v as usize]);
            }
            let found = bounds(&positions, &triangles, &used);
            let bits = |b: &Bounds| [b.min, b.max].map(|corner| corner.map(f64::to_bits));
            assert_eq!(bits(&found), bits(&expected), "{positions:?} {triangles:?}");
        }
    }

    #[test]
    fn the_first_triangle_outside_is_named() {
        let mut triangles = vec![[0, 1, 2]; 10_000];
        assert_eq!(used_vertices(5, &triangles), Ok(vec![true, true, true, false, false]));
        triangles[9000][1] = 5;
        triangles[9001][2] = u32::MAX;
        assert_eq!(used_vertices(5, &triangles), Err(9000));
        assert!(all(&[true; 3000]) && !all(&[&[true; 2999][..], &[false]].concat()) && all(&[]));
    }
}
