//! Polygons to triangles.
/// Point-in-triangle tests that one file may spend on concave polygons: two seconds. What exceeds it is cut as a fan.
const BUDGET: u64 = 1 << 29;

/// Cuts polygons into triangles: convex ones as a fan around their first corner, concave ones by clipping ears
/// (G. Meisters, *Polygons have ears*, 1975) in the coordinate plane that they face most. A polygon of n corners
/// always becomes n - 2 triangles with its own orientation, degenerate and self-intersecting ones included.
#[derive(Debug)]
pub(super) struct Triangulator {
    budget: u64,
    /// Concave polygons that were cut as fans because the work would have been too much.
    pub(super) given_up: u64,
    points: Vec<[f64; 2]>,
    ring: Vec<Node>,
    /// Corners with a turn to the right, and their places.
    reflex: Vec<(usize, [f64; 2])>,
}

/// A corner that is left, and its neighbours.
#[derive(Clone, Copy, Debug)]
struct Node {
    point: [f64; 2],
    previous: usize,
    next: usize,
}

impl Default for Triangulator {
    fn default() -> Self {
        Self { budget: BUDGET, given_up: 0, points: Vec::new(), ring: Vec::new(), reflex: Vec::new() }
    }
}

impl Triangulator {
    /// Calls `emit` with the corners of the triangles of a polygon, all at finite positions.
    pub(super) fn triangulate<T: Copy>(
        &mut self,
        polygon: &[T],
        position: impl Fn(T) -> [f32; 3],
        mut emit: impl FnMut([T; 3]),
    ) {
        match *polygon {
            [] | [_] | [_, _] => {}
            [a, b, c] => emit([a, b, c]),
            [first, ref others @ .., last] => {
                if self.project(polygon, first, last, position) {
                    let after = others.iter().skip(1).chain([&last]);
                    others.iter().zip(after).for_each(|(&b, &c)| emit([first, b, c]));
                } else {
                    self.clip_ears(polygon, emit);
                }
            }
        }
    }

    /// Fills `points` with the polygon seen so that it runs counter-clockwise; true if it is convex or has no area.
    fn project<T: Copy>(
        &mut self,
        polygon: &[T],
        first: T,
        last: T,
        position: impl Fn(T) -> [f32; 3],
    ) -> bool {
        let origin = position(first).map(f64::from);
        let relative = |corner: T| {
            let p = position(corner);
            [f64::from(p[0]) - origin[0], f64::from(p[1]) - origin[1], f64::from(p[2]) - origin[2]]
        };
        // Newell's normal, twice the area long.
        let mut normal = [0.0_f64; 3];
        let mut before = relative(last);
        for &corner in polygon {
            let p = relative(corner);
            normal[0] += before[1] * p[2] - before[2] * p[1];
            normal[1] += before[2] * p[0] - before[0] * p[2];
            normal[2] += before[0] * p[1] - before[1] * p[0];
            before = p;
        }
        let [x, y, z] = normal.map(f64::abs);
        let (axis, facing) = if x > y && x > z {
            (Axis::X, normal[0])
        } else if y > z {
            (Axis::Y, normal[1])
        } else {
            (Axis::Z, normal[2])
        };
        if facing == 0.0 {
            return true;
        }
        let seen = |corner: T| {
            let [x, y, z] = relative(corner);
            let [u, v] = match axis {
                Axis::X => [y, z],
                Axis::Y => [z, x],
                Axis::Z => [x, y],
            };
            if facing > 0.0 { [u, v] } else { [v, u] }
        };
        self.points.clear();
        self.points.extend(polygon.iter().map(|&corner| seen(corner)));
        // Convex: no turn to the right, and not more than one turn around (the edges change their side once).
        let mut sides = 0_u32;
        let mut before = seen(last);
        let mut side = None;
        let after = self.points.iter().skip(1).chain(self.points.first());
        for (&p, &q) in self.points.iter().zip(after) {
            if turn(before, p, q) < 0.0 {
                return false;
            }
            let up = q[1] > p[1] || q[1] == p[1] && q[0] < p[0];
            sides = sides.saturating_add(u32::from(side.is_some_and(|s| s != up)));
            side = Some(up);
            before = p;
        }
        sides <= 2
    }

    /// Cuts the polygon that `points` shows. All that `None` could come of is a link that leads nowhere, and there is
    /// none.
    fn clip_ears<T: Copy>(&mut self, polygon: &[T], mut emit: impl FnMut([T; 3])) -> Option<()> {
        let last = self.points.len().checked_sub(1)?;
        let links = std::iter::once(last).chain(0..last).zip((1..=last).chain([0]));
        let node = |(&point, (previous, next))| Node { point, previous, next };
        self.ring.clear();
        self.ring.extend(self.points.iter().zip(links).map(node));
        self.reflex.clear();
        for (k, &point) in self.points.iter().enumerate() {
            if turn_at(&self.ring, k)? < 0.0 {
                self.reflex.push((k, point));
            }
        }
        let mut left = polygon.len();
        let mut corner = 0;
        'ears: while left > 3 {
            let corners = left;
            // After a round without a true ear one without area will do, and after another one any corner.
            for round in 0..3 {
                for _ in 0..corners {
                    let work = (self.reflex.len() as u64).saturating_add(1);
                    let Some(budget) = self.budget.checked_sub(work) else {
                        self.given_up = self.given_up.saturating_add(1);
                        break 'ears;
                    };
                    self.budget = budget;
                    let Node { previous: before, next: after, .. } = *self.ring.get(corner)?;
                    let area = turn_at(&self.ring, corner)?;
                    let accepted = match round {
                        0 => area > 0.0 && self.is_empty(corner)?,
                        1 => area >= 0.0 && self.is_empty(corner)?,
                        _ => true,
                    };
                    if !accepted {
                        corner = after;
                        continue;
                    }
                    emit([*polygon.get(before)?, *polygon.get(corner)?, *polygon.get(after)?]);
                    self.ring.get_mut(before)?.next = after;
                    self.ring.get_mut(after)?.previous = before;
                    // Clipping makes angles smaller: corners can leave the list, and none enters.
                    let ring = &self.ring;
                    self.reflex.retain(|&(k, _)| {
                        let near = k == before || k == after;
                        let turns = || turn_at(ring, k).is_some_and(|turn| turn >= 0.0);
                        k != corner && !(near && turns())
                    });
                    left = left.saturating_sub(1);
                    // Skipping one corner gives better shaped triangles than a fan.
                    corner = self.ring.get(after)?.next;
                    continue 'ears;
                }
            }
        }
        // The rest is a triangle, or a fan if the budget has run out.
        let first = *polygon.get(corner)?;
        let mut b = self.ring.get(corner)?.next;
        for _ in 2..left {
            let c = self.ring.get(b)?.next;
            emit([first, *polygon.get(b)?, *polygon.get(c)?]);
            b = c;
        }
        Some(())
    }

    /// True if no other corner lies within the triangle of a corner and its neighbours. Only reflex ones can; those at a
    /// corner's own place do not count (a hole is connected by an edge that is walked twice).
    fn is_empty(&self, corner: usize) -> Option<bool> {
        let [p, q, r] = around(&self.ring, corner)?;
        Some(self.reflex.iter().all(|&(_, s)| {
            s == p || s == q || s == r || turn(p, q, s) < 0.0 || turn(q, r, s) < 0.0 || turn(r, p, s) < 0.0
        }))
    }
}

/// The axis that a polygon faces most.
#[derive(Clone, Copy)]
enum Axis {
    X,
    Y,
    Z,
}

/// A corner between its neighbours.
fn around(ring: &[Node], corner: usize) -> Option<[[f64; 2]; 3]> {
    let node = ring.get(corner)?;
    Some([ring.get(node.previous)?.point, node.point, ring.get(node.next)?.point])
}

fn turn_at(ring: &[Node], corner: usize) -> Option<f64> {
    around(ring, corner).map(|[p, q, r]| turn(p, q, r))
}

/// Twice the signed area of a triangle: positive for a turn to the left at `b`.
fn turn(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (c[1] - b[1]) - (b[1] - a[1]) * (c[0] - b[0])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cut(points: &[[f32; 3]]) -> Vec<[usize; 3]> {
        let mut triangles = Vec::new();
        let polygon: Vec<usize> = (0..points.len()).collect();
        Triangulator::default().triangulate(&polygon, |k| points[k], |t| triangles.push(t));
        triangles
    }

    /// Signed areas of the triangles in the xy plane.
    fn areas(points: &[[f32; 3]], triangles: &[[usize; 3]]) -> Vec<f64> {
        let at = |k: usize| [f64::from(points[k][0]), f64::from(points[k][1])];
        triangles.iter().map(|&[a, b, c]| turn(at(a), at(b), at(c)) / 2.0).collect()
    }

    fn flat(points: &[[f32; 2]]) -> Vec<[f32; 3]> {
        points.iter().map(|p| [p[0], p[1], 0.0]).collect()
    }

    #[test]
    fn convex_polygons_are_fans() {
        assert_eq!(cut(&flat(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])), [[0, 1, 2], [0, 2, 3]]);
        let octagon =
            [[0.0, 1.0], [0.0, 2.0], [1.0, 3.0], [2.0, 3.0], [3.0, 2.0], [3.0, 1.0], [2.0, 0.0], [1.0, 0.0]];
        assert_eq!(cut(&flat(&octagon)).len(), 6);
        assert!(cut(&flat(&octagon)).iter().all(|t| t[0] == 0));
    }

    #[test]
    fn concave_polygons_keep_their_area_without_overlap() {
        let shapes: [(&[[f32; 2]], f64); 4] = [
            // An arrow head whose fan from corner 0 would leave it.
            (&[[0.0, 0.0], [2.0, -1.0], [0.5, 0.0], [2.0, 1.0]], 0.5),
            // An L, with a corner in the middle of a side.
            (&[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]], 3.0),
            // A comb.
            (
                &[
                    [0.0, 0.0],
                    [5.0, 0.0],
                    [5.0, 3.0],
                    [4.0, 3.0],
                    [4.0, 1.0],
                    [3.0, 1.0],
                    [3.0, 3.0],
                    [2.0, 3.0],
                    [2.0, 1.0],
                    [1.0, 1.0],
                    [1.0, 3.0],
                    [0.0, 3.0],
                ],
                11.0,
            ),
            // A square with a square hole, connected by an edge walked twice.
            (
                &[
                    [0.0, 0.0],
                    [4.0, 0.0],
                    [4.0, 4.0],
                    [0.0, 4.0],
                    [0.0, 0.0],
                    [1.0, 1.0],
                    [1.0, 3.0],
                    [3.0, 3.0],
                    [3.0, 1.0],
                    [1.0, 1.0],
                ],
                12.0,
            ),
        ];
        for (shape, area) in shapes {
            for turned in 0..shape.len() {
                let mut points = flat(shape);
                points.rotate_left(turned);
                let triangles = cut(&points);
                assert_eq!(triangles.len(), points.len() - 2);
                let areas = areas(&points, &triangles);
                assert!(areas.iter().all(|&a| a >= 0.0), "{areas:?} of {points:?}");
                assert_eq!(areas.iter().sum::<f64>(), area, "{points:?}");
                // Seen from behind, and in other planes, it is the same polygon.
                points.reverse();
                assert_eq!(cut(&points).len(), points.len() - 2);
                let upright: Vec<_> = points.iter().map(|p| [p[1], 7.0, p[0]]).collect();
                let signed: Vec<f64> = cut(&upright)
                    .iter()
                    .map(|t| t.map(|k| [upright[k][0], upright[k][2]].map(f64::from)))
                    .map(|[a, b, c]| -turn(a, b, c) / 2.0)
                    .collect();
                assert!(signed.iter().all(|&a| a >= 0.0) || signed.iter().all(|&a| a <= 0.0));
                assert_eq!(signed.iter().sum::<f64>().abs(), area);
            }
        }
    }

    #[test]
    fn bad_polygons_still_give_their_number_of_triangles() {
        let bow = flat(&[[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0], [-1.0, 0.5]]);
        let star: Vec<[f32; 3]> = flat(&[[0.0, 3.0], [1.8, -2.4], [-2.9, 0.9], [2.9, 0.9], [-1.8, -2.4]]);
        for points in [bow, star, vec![[1.0; 3]; 9], flat(&[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [1.0, 0.0]])]
        {
            assert_eq!(cut(&points).len(), points.len() - 2);
        }
        assert!(cut(&[[0.0; 3]; 2]).is_empty());
    }

    #[test]
    fn the_budget_bounds_the_work_but_not_the_result() {
        let mut small = Triangulator { budget: 10, ..Triangulator::default() };
        let comb: Vec<[f32; 3]> =
            (0..1000).map(|k| [k as f32, (k % 2) as f32 * 3.0, 0.0]).chain([[500.0, -9.0, 0.0]]).collect();
        let mut count = 0;
        small.triangulate(&comb, |corner| corner, |_| count += 1);
        assert_eq!(count, comb.len() - 2);
        assert_eq!(small.given_up, 1);
    }
}
