//! Clipping against the near plane and the guard band, in homogeneous coordinates.
//!
//! Two triangles that share an edge must get the same point where it is clipped, whatever their vertex order and
//! even if they do not share vertices (seams, STL). So the end points of every clipped edge are ordered by the bits
//! of their coordinates before the intersection is computed: swapped end points would round differently.

use super::vertex::ClipVertex;
use crate::raster::GUARD_BAND;

/// A vertex of a clipped triangle, with its barycentric coordinates (of vertices 1 and 2) in the whole triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PolygonVertex {
    pub position: ClipVertex,
    pub barycentric: [f32; 2],
}

/// A convex polygon: three vertices plus at most one for each of the five planes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Polygon {
    vertices: [PolygonVertex; 8],
    len: usize,
}

impl Polygon {
    pub(super) fn vertices(&self) -> &[PolygonVertex] {
        &self.vertices[..self.len]
    }

    fn push(&mut self, vertex: PolygonVertex) {
        // Rounding can make a plane cut a nearly degenerate polygon more than twice; what exceeds is dropped.
        if let Some(slot) = self.vertices.get_mut(self.len) {
            *slot = vertex;
            self.len += 1;
        }
    }
}

/// Clips a triangle to distances of at least `near` and to the guard band. Empty if nothing is left.
pub(super) fn clip(triangle: [ClipVertex; 3], near: f32, perspective: bool) -> Polygon {
    let barycentrics = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
    let zero = PolygonVertex { position: ClipVertex { x: 0.0, y: 0.0, w: 0.0 }, barycentric: [0.0; 2] };
    let mut polygon = Polygon { vertices: [zero; 8], len: 0 };
    for (position, barycentric) in triangle.into_iter().zip(barycentrics) {
        polygon.push(PolygonVertex { position, barycentric });
    }
    let guard = GUARD_BAND as f32;
    let bound = |v: &ClipVertex| if perspective { guard * v.w } else { guard };
    let planes: [&dyn Fn(&ClipVertex) -> f32; 5] =
        [&|v| v.w - near, &|v| bound(v) - v.x, &|v| bound(v) + v.x, &|v| bound(v) - v.y, &|v| bound(v) + v.y];
    for plane in planes {
        polygon = clip_to_plane(&polygon, plane);
    }
    polygon
}

/// The part of a polygon where `plane` is not negative.
fn clip_to_plane(polygon: &Polygon, plane: &dyn Fn(&ClipVertex) -> f32) -> Polygon {
    let mut out = Polygon { len: 0, ..*polygon };
    for (k, a) in polygon.vertices().iter().enumerate() {
        let b = &polygon.vertices()[if k + 1 == polygon.len { 0 } else { k + 1 }];
        let (da, db) = (plane(&a.position), plane(&b.position));
        if da >= 0.0 {
            out.push(*a);
        }
        if (da >= 0.0) != (db >= 0.0) {
            out.push(intersection(a, da, b, db));
        }
    }
    out
}

/// Intersection of the edge between `a` and `b` with a plane from which they have the distances `da` and `db` of
/// opposite sign: the same bits for (a, b) and (b, a).
fn intersection(a: &PolygonVertex, da: f32, b: &PolygonVertex, db: f32) -> PolygonVertex {
    let key = |v: &PolygonVertex| [v.position.x, v.position.y, v.position.w].map(f32::to_bits);
    let (a, da, b, db) = if key(a) <= key(b) { (a, da, b, db) } else { (b, db, a, da) };
    let t = da / (da - db);
    let mix = |p: f32, q: f32| p + t * (q - p);
    PolygonVertex {
        position: ClipVertex {
            x: mix(a.position.x, b.position.x),
            y: mix(a.position.y, b.position.y),
            w: mix(a.position.w, b.position.w),
        },
        barycentric: [mix(a.barycentric[0], b.barycentric[0]), mix(a.barycentric[1], b.barycentric[1])],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbours_compute_the_same_point() {
        let mut state = 7_u32;
        let mut next = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32 / 1e4 - 800.0
        };
        for _ in 0..1000 {
            let [a, b, c, d] = std::array::from_fn(|_| ClipVertex { x: next(), y: next(), w: next() });
            let left = clip([a, b, c], 0.1, true);
            let right = clip([b, a, d], 0.1, true);
            let on_edge = |p: &Polygon, opposite_is_2: bool| -> Vec<[u32; 3]> {
                let mut found: Vec<_> = p
                    .vertices()
                    .iter()
                    .filter(|v| opposite_is_2 && v.barycentric[1] == 0.0)
                    .map(|v| [v.position.x, v.position.y, v.position.w].map(f32::to_bits))
                    .collect();
                found.sort_unstable();
                found.dedup();
                found
            };
            assert_eq!(on_edge(&left, true), on_edge(&right, true));
        }
    }

    #[test]
    fn nothing_of_a_triangle_in_front_is_lost() {
        let v = |x, y, w| ClipVertex { x, y, w };
        let whole = clip([v(0.0, 0.0, 1.0), v(5.0, 0.0, 2.0), v(0.0, 5.0, 3.0)], 0.1, true);
        assert_eq!(whole.vertices().len(), 3);
        assert_eq!(
            clip([v(0.0, 0.0, -1.0), v(5.0, 0.0, 2.0), v(0.0, 5.0, 3.0)], 0.1, true).vertices().len(),
            4
        );
        assert!(
            clip([v(0.0, 0.0, -1.0), v(5.0, 0.0, -2.0), v(0.0, 5.0, -3.0)], 0.1, true).vertices().is_empty()
        );
    }
}
