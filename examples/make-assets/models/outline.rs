//! Closed curves in a plane with signed distances, for cutting panels, windows and letters out of a surface.

use glam::DVec2;

/// A closed polygon, possibly a densely sampled curve.
#[derive(Clone, Debug)]
pub struct Outline {
    points: Vec<DVec2>,
    low: DVec2,
    high: DVec2,
}

/// A signed distance with its direction of growth.
#[derive(Clone, Copy, Debug)]
pub struct Distance {
    /// Negative inside.
    pub value: f64,
    /// Unit gradient.
    pub gradient: DVec2,
}

impl Outline {
    /// The polygon through `points`, in either direction.
    pub fn polygon(points: Vec<DVec2>) -> Self {
        let (mut low, mut high) = (points[0], points[0]);
        for point in &points {
            (low, high) = (low.min(*point), high.max(*point));
        }
        Self { points, low, high }
    }

    /// A polygon whose corners (point, radius) are rounded by quadratic curves that start `radius` from the corner.
    pub fn rounded(corners: &[(f64, f64, f64)]) -> Self {
        const STEPS: u32 = 8;
        let count = corners.len();
        let at = |i: usize| DVec2::new(corners[i % count].0, corners[i % count].1);
        let mut points = Vec::new();
        for i in 0..count {
            let (before, corner, after) = (at(i + count - 1), at(i), at(i + 1));
            let fit = |other: DVec2| {
                let (wanted, most) = (corners[i].2, 0.5 * corner.distance(other));
                corner + (other - corner).normalize() * if wanted < most { wanted } else { most }
            };
            let (first, last) = (fit(before), fit(after));
            for step in 0..=STEPS {
                let t = f64::from(step) / f64::from(STEPS);
                points.push(first.lerp(corner, t).lerp(corner.lerp(last, t), t));
            }
        }
        points.dedup();
        Self::polygon(points)
    }

    /// A smooth closed curve through `points` (centripetal tangents are not needed for well spaced points: uniform
    /// Catmull-Rom).
    pub fn through(points: &[(f64, f64)]) -> Self {
        const STEPS: u32 = 8;
        let count = points.len();
        let at = |i: usize| DVec2::new(points[i % count].0, points[i % count].1);
        let mut curve = Vec::new();
        for i in 0..count {
            let [a, b, c, d] = [at(i + count - 1), at(i), at(i + 1), at(i + 2)];
            for step in 0..STEPS {
                let t = f64::from(step) / f64::from(STEPS);
                curve.push(
                    b + (c - a) * (0.5 * t)
                        + (a * 2.0 - b * 5.0 + c * 4.0 - d) * (0.5 * t * t)
                        + ((b - c) * 3.0 + d - a) * (0.5 * t * t * t),
                );
            }
        }
        Self::polygon(curve)
    }

    /// Signed distance of `point`; far from the curve an upper bound of the right sign.
    pub fn distance(&self, point: DVec2) -> Distance {
        const FAR: f64 = 0.3;
        let clamped = point.clamp(self.low, self.high);
        let away = point - clamped;
        if away.length() > FAR {
            return Distance { value: away.length(), gradient: away.normalize() };
        }
        let mut nearest = self.points[0];
        let mut inside = false;
        for (i, &b) in self.points.iter().enumerate() {
            let a = self.points[(i + self.points.len() - 1) % self.points.len()];
            let edge = b - a;
            let t = ((point - a).dot(edge) / edge.length_squared()).clamp(0.0, 1.0);
            let candidate = a + edge * t;
            if candidate.distance_squared(point) < nearest.distance_squared(point) {
                nearest = candidate;
            }
            if (a.y > point.y) != (b.y > point.y)
                && point.x < a.x + (point.y - a.y) / (b.y - a.y) * (b.x - a.x)
            {
                inside = !inside;
            }
        }
        let offset = point - nearest;
        let length = offset.length();
        let gradient = if length > 1e-9 { offset / length } else { DVec2::ZERO };
        if inside {
            Distance { value: -length, gradient: -gradient }
        } else {
            Distance { value: length, gradient }
        }
    }
}

/// Signed distance to a stroke: a polyline of half width `half`, with round ends.
pub fn stroke_distance(points: &[DVec2], half: f64, point: DVec2) -> Distance {
    let mut best = Distance { value: f64::MAX, gradient: DVec2::ZERO };
    for pair in points.windows(2) {
        let edge = pair[1] - pair[0];
        let t = ((point - pair[0]).dot(edge) / edge.length_squared()).clamp(0.0, 1.0);
        let offset = point - (pair[0] + edge * t);
        let value = offset.length() - half;
        if value < best.value {
            best = Distance { value, gradient: offset.normalize_or_zero() };
        }
    }
    best
}
