//! Corners of occluders, and a sphere around all of them.

use super::repeated::Repeated;
use overcoat_core::jobs::Jobs;
use std::ops::Range;

/// Corners that are looked at by one thread.
const POSITIONS_PER_JOB: usize = 1 << 16;

/// The corners of a triangle, if they exist and are finite.
pub(super) fn corners_of(positions: &[[f32; 3]], triangle: &[u32; 3]) -> Option<[[f32; 3]; 3]> {
    let mut corners = [[0.0; 3]; 3];
    for (corner, number) in corners.iter_mut().zip(triangle) {
        *corner = *positions.get(*number as usize)?;
    }
    corners.as_flattened().iter().all(|c| c.is_finite()).then_some(corners)
}

/// Points that one thread looks at.
pub(super) enum Part<'a> {
    Listed(&'a [[f32; 3]]),
    /// Vertices of a mesh, counted over all of its places.
    Repeated(&'a Repeated, Range<usize>),
}

/// Points, many at a time.
pub(super) fn parts_of(positions: &[[f32; 3]]) -> Vec<Part<'_>> {
    positions.chunks(POSITIONS_PER_JOB).map(Part::Listed).collect()
}

impl<'a> Part<'a> {
    /// Adds the vertices of a mesh at all of its places.
    pub(super) fn add_repeated(repeated: &'a Repeated, parts: &mut Vec<Self>) {
        let count = repeated.vertices();
        let starts = (0..count).step_by(POSITIONS_PER_JOB);
        parts.extend(starts.map(|first| {
            Self::Repeated(repeated, first..count.min(first.saturating_add(POSITIONS_PER_JOB)))
        }));
    }

    /// Visits the points.
    fn for_each(&self, f: impl FnMut([f32; 3])) {
        match self {
            Self::Listed(positions) => positions.iter().copied().for_each(f),
            Self::Repeated(repeated, numbers) => repeated.positions(numbers.clone()).for_each(f),
        }
    }
}

/// A sphere around all points that are finite: its centre is the middle of the box around them; `None` if there are none.
pub(super) fn bounding_sphere(parts: &[Part<'_>], jobs: &Jobs) -> Option<([f32; 3], f32)> {
    let mut bounds = [[f32::INFINITY; 3], [f32::NEG_INFINITY; 3]];
    for part in jobs.map_each(parts, box_around) {
        for k in 0..3 {
            bounds[0][k] = smaller(part[0][k], bounds[0][k]);
            bounds[1][k] = larger(part[1][k], bounds[1][k]);
        }
    }
    let [low, high] = bounds;
    if (0..3).any(|k| low[k] > high[k]) {
        return None;
    }
    let centre = std::array::from_fn(|k| low[k] * 0.5 + high[k] * 0.5);
    let squares = jobs.map_each(parts, |part| furthest(part, centre));
    let square = squares.into_iter().fold(0.0, |most, square| if square > most { square } else { most });
    Some((centre, square.sqrt() as f32))
}

/// [`bounding_sphere`], large enough for maps of it: a single point is as large as a number can tell, and no scale is infinite.
pub(super) fn mapped_sphere(parts: &[Part<'_>], jobs: &Jobs) -> Option<([f32; 3], f32)> {
    let (centre, radius) = bounding_sphere(parts, jobs)?;
    let least = centre.iter().fold(1e-30, |m, c| if c.abs() * 1e-6 > m { c.abs() * 1e-6 } else { m });
    Some((centre, larger(radius, least)))
}

/// The least and the largest finite coordinates of points.
fn box_around(part: &Part<'_>) -> [[f32; 3]; 2] {
    let mut bounds = [[f32::INFINITY; 3], [f32::NEG_INFINITY; 3]];
    part.for_each(|position| {
        if position.iter().all(|c| c.is_finite()) {
            for k in 0..3 {
                bounds[0][k] = smaller(position[k], bounds[0][k]);
                bounds[1][k] = larger(position[k], bounds[1][k]);
            }
        }
    });
    bounds
}

/// The square of the largest finite distance of points from a centre.
fn furthest(part: &Part<'_>, centre: [f32; 3]) -> f64 {
    let mut most = 0.0;
    part.for_each(|position| {
        let [x, y, z]: [f64; 3] = std::array::from_fn(|k| f64::from(position[k]) - f64::from(centre[k]));
        let square = x * x + y * y + z * z;
        most = if square > most && square.is_finite() { square } else { most };
    });
    most
}

/// The smaller of two numbers.
pub(super) fn smaller(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// The larger of two numbers.
pub(super) fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}
