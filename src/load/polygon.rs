//! Polygons to triangles.

/// Point-in-triangle tests that one file may spend on concave polygons: some seconds. What exceeds it is cut as a fan.
const BUDGET: u64 = 1 << 30;

/// Cuts polygons into triangles: convex ones as a fan around their first corner, concave ones by clipping ears
/// (G. Meisters, *Polygons have ears*, 1975) in the coordinate plane that they face most. A polygon of n corners
/// always becomes n - 2 triangles with its own orientation, degenerate and self-intersecting ones included.
#[derive(Debug)]
pub(super) struct Triangulator {
    budget: u64,
    /// Concave polygons that were cut as fans because the work would have been too much.
    pub(super) given_up: u64,
    points: Vec<[f64; 2]>,
    next: Vec<u32>,
    previous: Vec<u32>,
    reflex: Vec<u32>,
}

impl Default for Triangulator {
    fn default() -> Self {
        Self {
            budget: BUDGET,
            given_up: 0,
            points: Vec::new(),
            next: Vec::new(),
            previous: Vec::new(),
            reflex: Vec::new(),
        }
    }
}

impl Triangulator {
    /// Calls `emit` with the corners, by number, of the triangles of a polygon of `n` corners at finite positions.
    pub(super) fn triangulate(
        &mut self,
        n: usize,
        position: impl Fn(usize) -> [f32; 3],
        mut emit: impl FnMut([usize; 3]),
    ) {
        if n == 3 {
            emit([0, 1, 2]);
            return;
        }
        if n < 3 {
            return;
        }
        if self.project(n, position) {
            (1..n - 1).for_each(|k| emit([0, k, k + 1]));
        } else {
            self.clip_ears(emit);
        }
    }

    /// Fills `points` with the polygon seen so that it runs counter-clockwise; true if it is convex or has no area.
    fn project(&mut self, n: usize, position: impl Fn(usize) -> [f32; 3]) -> bool {
        let origin = position(0).map(f64::from);
        let relative = |k: usize| {
            let p = position(k);
            [f64::from(p[0]) - origin[0], f64::from(p[1]) - origin[1], f64::from(p[2]) - origin[2]]
        };
        // Newell's normal, twice the area long.
        let mut normal = [0.0_f64; 3];
        let mut last = relative(n - 1);
        for k in 0..n {
            let p = relative(k);
            normal[0] += last[1] * p[2] - last[2] * p[1];
            normal[1] += last[2] * p[0] - last[0] * p[2];
            normal[2] += last[0] * p[1] - last[1] * p[0];
            last = p;
        }
        let [x, y, z] = normal.map(f64::abs);
        let axis = if x > y && x > z {
            0
        } else if y > z {
            1
        } else {
            2
        };
        if normal[axis] == 0.0 {
            return true;
        }
        let (u, v) = if normal[axis] > 0.0 {
            ((axis + 1) % 3, (axis + 2) % 3)
        } else {
            ((axis + 2) % 3, (axis + 1) % 3)
        };
        self.points.clear();
        self.points.extend((0..n).map(|k| {
            let p = relative(k);
            [p[u], p[v]]
        }));
        // Convex: no turn to the right, and not more than one turn around (the edges change their side once).
        let mut sides = 0;
        let mut before = self.points[n - 1];
        let mut side = None;
        for k in 0..n {
            let (p, q) = (self.points[k], self.points[(k + 1) % n]);
            if turn(before, p, q) < 0.0 {
                return false;
            }
            let up = q[1] > p[1] || q[1] == p[1] && q[0] < p[0];
            sides += u32::from(side.is_some_and(|s| s != up));
            side = Some(up);
            before = p;
        }
        sides <= 2
    }

    fn clip_ears(&mut self, mut emit: impl FnMut([usize; 3])) {
        let n = self.points.len();
        self.next.clear();
        self.next.extend((1..n as u32).chain([0]));
        self.previous.clear();
        self.previous.extend((0..n as u32).map(|k| (k + n as u32 - 1) % n as u32));
        self.reflex.clear();
        for k in 0..n {
            if self.turn_at(k) < 0.0 {
                self.reflex.push(k as u32);
            }
        }
        let mut left = n;
        let mut corner = 0;
        // Corners looked at since the last ear, and how small an ear may be after a round without one.
        let mut misses = 0;
        while left > 3 {
            let (before, after) = (self.previous[corner] as usize, self.next[corner] as usize);
            let work = self.reflex.len() as u64 + 1;
            if self.budget < work {
                self.given_up += 1;
                break;
            }
            self.budget -= work;
            // After a round without a true ear one without area will do, and after another one any corner.
            let area = self.turn_at(corner);
            let accepted = match misses / left {
                0 => area > 0.0 && self.is_empty(before, corner, after),
                1 => area >= 0.0 && self.is_empty(before, corner, after),
                _ => true,
            };
            if !accepted {
                misses += 1;
                corner = after;
                continue;
            }
            emit([before, corner, after]);
            self.next[before] = after as u32;
            self.previous[after] = before as u32;
            // Clipping makes angles smaller: corners can leave the list, and none enters.
            let (points, next, previous) = (&self.points, &self.next, &self.previous);
            self.reflex.retain(|&k| {
                let k = k as usize;
                let near = k == before || k == after;
                let turns = || turn(points[previous[k] as usize], points[k], points[next[k] as usize]);
                k != corner && !(near && turns() >= 0.0)
            });
            left -= 1;
            misses = 0;
            // Skipping one corner gives better shaped triangles than a fan.
            corner = self.next[after] as usize;
        }
        // What is left is a triangle, or a fan where the budget has run out.
        let mut b = self.next[corner] as usize;
        for _ in 2..left {
            let c = self.next[b] as usize;
            emit([corner, b, c]);
            b = c;
        }
    }

    fn turn_at(&self, k: usize) -> f64 {
        turn(self.points[self.previous[k] as usize], self.points[k], self.points[self.next[k] as usize])
    }

    /// True if no other corner lies within the triangle. Only reflex ones can; those at a corner's own place do not
    /// count (a hole is connected by an edge that is walked twice).
    fn is_empty(&self, a: usize, b: usize, c: usize) -> bool {
        let (p, q, r) = (self.points[a], self.points[b], self.points[c]);
        self.reflex.iter().all(|&k| {
            let s = self.points[k as usize];
            s == p || s == q || s == r || turn(p, q, s) < 0.0 || turn(q, r, s) < 0.0 || turn(r, p, s) < 0.0
        })
    }
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
        Triangulator::default().triangulate(points.len(), |k| points[k], |t| triangles.push(t));
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
        small.triangulate(comb.len(), |k| comb[k], |_| count += 1);
        assert_eq!(count, comb.len() - 2);
        assert_eq!(small.given_up, 1);
    }
}
