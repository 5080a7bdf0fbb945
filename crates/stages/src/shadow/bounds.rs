//! Corners of occluders, and a sphere around all of them.

use overcoat_core::jobs::Jobs;

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

/// A sphere around all points that are finite: its centre is the middle of the box around them; `None` if there are none.
pub(super) fn bounding_sphere(positions: &[[f32; 3]], jobs: &Jobs) -> Option<([f32; 3], f32)> {
    let mut bounds = [[f32::INFINITY; 3], [f32::NEG_INFINITY; 3]];
    for part in for_each_part(positions, jobs, box_around) {
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
    let squares = for_each_part(positions, jobs, |positions| furthest(positions, centre));
    let square = squares.into_iter().fold(0.0, |most, square| if square > most { square } else { most });
    Some((centre, square.sqrt() as f32))
}

/// [`bounding_sphere`], large enough for maps of it: a single point is as large as a number can tell, and no scale is infinite.
pub(super) fn mapped_sphere(positions: &[[f32; 3]], jobs: &Jobs) -> Option<([f32; 3], f32)> {
    let (centre, radius) = bounding_sphere(positions, jobs)?;
    let least = centre.iter().fold(1e-30, |m, c| if c.abs() * 1e-6 > m { c.abs() * 1e-6 } else { m });
    Some((centre, larger(radius, least)))
}

/// `f` of the positions, many at a time.
fn for_each_part<T: Send>(
    positions: &[[f32; 3]],
    jobs: &Jobs,
    f: impl Fn(&[[f32; 3]]) -> T + Sync,
) -> Vec<T> {
    let parts: Vec<_> = positions.chunks(POSITIONS_PER_JOB).collect();
    jobs.map_each(&parts, |part| f(part))
}

/// The least and the largest finite coordinates of points.
fn box_around(positions: &[[f32; 3]]) -> [[f32; 3]; 2] {
    let mut bounds = [[f32::INFINITY; 3], [f32::NEG_INFINITY; 3]];
    for position in positions.iter().filter(|position| position.iter().all(|c| c.is_finite())) {
        for k in 0..3 {
            bounds[0][k] = smaller(position[k], bounds[0][k]);
            bounds[1][k] = larger(position[k], bounds[1][k]);
        }
    }
    bounds
}

/// The square of the largest finite distance of points from a centre.
fn furthest(positions: &[[f32; 3]], centre: [f32; 3]) -> f64 {
    positions.iter().fold(0.0, |most, position| {
        let [x, y, z]: [f64; 3] = std::array::from_fn(|k| f64::from(position[k]) - f64::from(centre[k]));
        let square = x * x + y * y + z * z;
        if square > most && square.is_finite() { square } else { most }
    })
}

/// The smaller of two numbers.
pub(super) fn smaller(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// The larger of two numbers.
pub(super) fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}
