//! Convex hull of points in a plane.

/// A point of the plane.
pub(super) type Point = [f64; 2];

/// Number of points from which on those are left out that lie inside the farthest ones, before all are sorted.
const FEW: usize = 32;

/// Stride of the points whose hull is found first; no multiple of the corners of a triangle.
const STRIDE: usize = 31;

/// Convex polygon around points, counter-clockwise and without corners on its edges.
#[derive(Debug, Default)]
pub(super) struct ConvexHull(Vec<Point>);

impl ConvexHull {
    /// The hull of finite points, by Andrew's monotone chain. It has less than three corners if they lie on a line.
    pub(super) fn around(mut points: Vec<Point>) -> Self {
        if points.len() > FEW {
            let inner = Self::around(extremes(&points));
            points.retain(|p| !inner.holds(*p));
        }
        points.sort_unstable_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
        points.dedup();
        if points.len() < 3 {
            return Self(points);
        }
        let mut corners = Vec::new();
        half(&mut corners, points.iter());
        half(&mut corners, points.iter().rev());
        Self(corners)
    }

    /// The hull of many finite points, of which those inside the farthest of a few are not collected.
    pub(super) fn around_many(points: impl Iterator<Item = Point> + Clone) -> Self {
        let few: Vec<_> = points.clone().step_by(STRIDE).collect();
        let inner = Self::around(extremes(&few));
        Self::around(points.filter(|p| !inner.holds(*p)).collect())
    }

    /// Edges, each from one corner to the next.
    fn edges(&self) -> impl Iterator<Item = [Point; 2]> {
        let next = self.0.iter().skip(1).chain(self.0.first());
        self.0.iter().zip(next).map(|(a, b)| [*a, *b])
    }

    /// True inside, and not on an edge.
    fn holds(&self, p: Point) -> bool {
        let is_left =
            |[a, b]: [Point; 2]| (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]) > 0.0;
        self.0.len() > 2 && self.edges().all(is_left)
    }

    /// Area.
    pub(super) fn area(&self) -> f64 {
        0.5 * self.edges().map(|[a, b]| a[0] * b[1] - a[1] * b[0]).sum::<f64>()
    }

    /// Distance of a point to the nearest of the lines along the edges, negative outside; minus infinity if the hull has
    /// no area.
    pub(super) fn depth(&self, p: Point) -> f64 {
        if self.0.len() < 3 {
            return f64::NEG_INFINITY;
        }
        self.edges().fold(f64::INFINITY, |least, [a, b]| {
            let [x, y] = [b[0] - a[0], b[1] - a[1]];
            let depth = (x * (p[1] - a[1]) - y * (p[0] - a[0])) / (x * x + y * y).sqrt();
            if depth < least { depth } else { least }
        })
    }
}

/// The farthest points along the axes and the diagonals.
fn extremes(points: &[Point]) -> Vec<Point> {
    const DIRECTIONS: [Point; 8] = [
        [1.0, 0.0],
        [1.0, 1.0],
        [0.0, 1.0],
        [-1.0, 1.0],
        [-1.0, 0.0],
        [-1.0, -1.0],
        [0.0, -1.0],
        [1.0, -1.0],
    ];
    let mut farthest = [(f64::NEG_INFINITY, [0.0; 2]); 8];
    for p in points {
        for (far, d) in farthest.iter_mut().zip(DIRECTIONS) {
            let along = d[0] * p[0] + d[1] * p[1];
            if along > far.0 {
                *far = (along, *p);
            }
        }
    }
    farthest.iter().map(|(_, p)| *p).collect()
}

/// Adds one side of the hull of sorted points, without its last corner.
fn half<'a>(corners: &mut Vec<Point>, points: impl Iterator<Item = &'a Point>) {
    let first = corners.len();
    for &q in points {
        while let Some(&[a, b]) = corners[first..].last_chunk() {
            if (b[0] - a[0]) * (q[1] - a[1]) - (b[1] - a[1]) * (q[0] - a[0]) > 0.0 {
                break;
            }
            corners.pop();
        }
        corners.push(q);
    }
    corners.pop();
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn squares_have_four_corners() {
        let grid = (0..25).map(|k| [f64::from(k % 5), f64::from(k / 5)]).collect();
        let hull = ConvexHull::around(grid);
        assert_eq!(hull.0, [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]]);
        assert_eq!(hull.area(), 16.0);
        assert_eq!(
            (hull.depth([1.0, 2.0]), hull.depth([2.0, 5.5]), hull.depth([4.0, 2.0])),
            (1.0, -1.5, 0.0)
        );
    }

    /// Points that are left out before are no corners.
    #[test]
    fn many_points_have_the_hull_of_their_outermost() {
        let mut state = 1_u32;
        let mut next = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(state >> 8) / f64::from(1 << 23) - 1.0
        };
        let disc: Vec<Point> = std::iter::repeat_with(|| [next(), next()])
            .filter(|[x, y]| x * x + y * y < 1.0)
            .take(5000)
            .collect();
        let hull = ConvexHull::around(disc.clone());
        assert!((3.0..std::f64::consts::PI).contains(&hull.area()) && hull.0.len() > 20, "{hull:?}");
        for p in &disc {
            assert!(hull.depth(*p) >= -1e-12, "{p:?}");
        }
        assert_eq!(ConvexHull::around_many(disc.iter().copied()).0, hull.0);
        let mut sorted = disc;
        sorted.sort_by(|a, b| a[0].total_cmp(&b[0]));
        let mut corners = Vec::new();
        half(&mut corners, sorted.iter());
        half(&mut corners, sorted.iter().rev());
        assert_eq!(hull.0, corners);
    }

    #[test]
    fn lines_and_points_hold_nothing() {
        for points in [vec![], vec![[1.0, 1.0]; 99], (0..99).map(|k| [f64::from(k); 2]).collect()] {
            let hull = ConvexHull::around(points);
            assert_eq!((hull.area(), hull.depth([1.0, 1.0])), (0.0, f64::NEG_INFINITY));
        }
    }
}
