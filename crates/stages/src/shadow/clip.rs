//! Triangles cut off where a map that is seen from a point begins.

/// A corner of a triangle on a map.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Corner {
    /// Coordinates by the map's rows: the last is the distance along the map's axis.
    pub place: [f32; 3],
    /// Texture coordinates of a triangle with holes.
    pub uv: [f32; 2],
    /// Factor of alpha there.
    pub alpha: f32,
}

impl Corner {
    /// The place between this one, which is seen, and one that is not, at a distance along the axis. Neighbours have the same
    /// places on a shared edge: it is always walked from the end that is seen.
    fn towards(&self, other: &Self, distance: f32) -> Self {
        let t = (self.place[2] - distance) / (self.place[2] - other.place[2]);
        let mix = |a: f32, b: f32| a + (b - a) * t;
        let [x, y, _] = std::array::from_fn(|k| mix(self.place[k], other.place[k]));
        Self {
            place: [x, y, distance],
            uv: std::array::from_fn(|k| mix(self.uv[k], other.uv[k])),
            alpha: mix(self.alpha, other.alpha),
        }
    }
}

/// Part of a triangle that lies at a distance along the axis or further: none, one or two triangles.
pub(super) fn clipped(corners: [Corner; 3], distance: f32) -> impl Iterator<Item = [Corner; 3]> {
    let mut outline = [Corner::default(); 4];
    let mut count = 0;
    let mut add = |corner: Corner| {
        outline[count] = corner;
        count += 1;
    };
    let is_seen = |corner: &Corner| corner.place[2] >= distance;
    for k in 0..3 {
        let (corner, next) = (corners[k], corners[(k + 1) % 3]);
        if is_seen(&corner) {
            add(corner);
        }
        match (is_seen(&corner), is_seen(&next)) {
            (true, false) => add(corner.towards(&next, distance)),
            (false, true) => add(next.towards(&corner, distance)),
            _ => {}
        }
    }
    (2..count).map(move |k| [outline[0], outline[k - 1], outline[k]])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn corner(x: f32, distance: f32) -> Corner {
        Corner { place: [x, x * x, distance], uv: [x, 1.0 - x], alpha: x }
    }

    /// Twice the area on the plane of the first and the last coordinate.
    fn area(triangle: &[Corner; 3]) -> f32 {
        let [a, b, c] = triangle.map(|corner| [corner.place[0], corner.place[2]]);
        (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1])
    }

    #[test]
    fn what_is_cut_off_is_what_lies_before() {
        // Corners at distances 0 and 2 of a triangle of width 2: half of its height is cut off at 1.
        let up = [corner(0.0, 0.0), corner(2.0, 0.0), corner(1.0, 2.0)];
        let down = [corner(0.0, 2.0), corner(2.0, 2.0), corner(1.0, 0.0)];
        for (triangle, share) in [(up, 0.25), (down, 0.75)] {
            for turn in 0..3 {
                let turned = [triangle[turn], triangle[(turn + 1) % 3], triangle[(turn + 2) % 3]];
                let whole = area(&turned);
                let parts: Vec<_> = clipped(turned, 1.0).collect();
                let sum: f32 = parts.iter().map(area).sum();
                assert!((sum / whole - share).abs() < 1e-6, "{sum} of {whole}");
                for corner in parts.iter().flatten() {
                    assert!(corner.place[2] >= 1.0 && (corner.uv[0] - corner.alpha).abs() < 1e-6);
                    assert!((corner.place[0] - corner.uv[0]).abs() < 1e-6);
                }
            }
            assert_eq!(clipped(triangle, 3.0).count(), 0);
            assert_eq!(clipped(triangle, -1.0).collect::<Vec<_>>(), [triangle]);
        }
    }

    #[test]
    fn neighbours_are_cut_at_the_same_place() {
        let (a, b) = (corner(0.3, 0.1), corner(0.7, 1.9));
        let of = |triangle| -> Vec<[f32; 3]> {
            clipped(triangle, 0.77).flatten().map(|corner| corner.place).filter(|p| p[2] == 0.77).collect()
        };
        let (one, other) = (of([a, b, corner(5.0, 3.0)]), of([b, a, corner(-5.0, 3.0)]));
        assert!(one.iter().any(|place| other.contains(place)));
    }
}
