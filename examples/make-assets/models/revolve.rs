//! Surfaces of revolution about the y axis, from profiles with rounded corners.

use glam::{DVec2, DVec3};

use super::angle;
use super::mesh::{Mesh, Vertex};

/// Neighbouring segments of a profile closer in direction than this cosine share a normal.
const SMOOTH_COSINE: f64 = 0.8;

/// Rounds the inner corners of a polyline of (point, radius) by circular arcs of `steps` chords each.
///
/// A radius too large for its segments is cut down to what fits.
pub fn rounded(corners: &[(DVec2, f64)], steps: u32) -> Vec<DVec2> {
    let mut points = Vec::new();
    for (i, &(corner, radius)) in corners.iter().enumerate() {
        if i == 0 || i + 1 == corners.len() || radius <= 0.0 {
            points.push(corner);
            continue;
        }
        let (back, ahead) = (corners[i - 1].0 - corner, corners[i + 1].0 - corner);
        let half = 0.5 * (back.normalize() + ahead.normalize()).length();
        // `half` is the cosine of half the corner's inner angle; a straight corner has nothing to round.
        if half < 1e-6 {
            points.push(corner);
            continue;
        }
        let sine = (1.0 - half * half).sqrt();
        let limit = 0.49 * if back.length() < ahead.length() { back.length() } else { ahead.length() };
        let wanted = radius * half / sine;
        let setback = if wanted < limit { wanted } else { limit };
        let radius = setback * sine / half;
        let (first, last) = (corner + back.normalize() * setback, corner + ahead.normalize() * setback);
        let centre = corner + (back.normalize() + ahead.normalize()).normalize() * (radius / sine);
        for step in 0..=steps {
            // Chords of equal parameter, pushed out to the circle: even enough for short arcs.
            let t = f64::from(step) / f64::from(steps);
            let chord = first.lerp(last, t) - centre;
            points.push(centre + chord.normalize() * radius);
        }
    }
    points
}

/// Turns a profile of (radius, height) about the y axis in `sides` steps.
///
/// Going up along the profile, the outside lies to the right (at larger radii). u runs once around, v along the
/// profile in metres.
pub fn revolve(profile: &[DVec2], sides: u32) -> Mesh {
    let mut points = profile.to_vec();
    points.dedup();
    let segments: Vec<DVec2> = points.windows(2).map(|pair| (pair[1] - pair[0]).normalize()).collect();
    let mut mesh = Mesh::default();
    let mut row = |point: DVec2, tangent: DVec2, along: f64| {
        for column in 0..=sides {
            let direction = angle::unit(f64::from(column % sides) / f64::from(sides));
            let turned = |v: DVec2| DVec3::new(v.x * direction.y, v.y, v.x * direction.x);
            mesh.push(Vertex {
                position: turned(point),
                normal: turned(DVec2::new(tangent.y, -tangent.x)).normalize_or_zero(),
                uv: DVec2::new(f64::from(column) / f64::from(sides), -along),
            });
        }
        mesh.vertices.len() as u32 - sides - 1
    };
    let mut along = 0.0;
    let mut strips = Vec::new();
    let mut low = row(points[0], segments[0], along);
    for (i, segment) in segments.iter().enumerate() {
        along += points[i].distance(points[i + 1]);
        match segments.get(i + 1) {
            Some(next) if next.dot(*segment) > SMOOTH_COSINE => {
                let high = row(points[i + 1], (*next + *segment).normalize(), along);
                strips.push((low, high));
                low = high;
            }
            next => {
                strips.push((low, row(points[i + 1], *segment, along)));
                if let Some(next) = next {
                    low = row(points[i + 1], *next, along);
                }
            }
        }
    }
    for (low, high) in strips {
        for column in 0..sides {
            mesh.quad(high + column, low + column, low + column + 1, high + column + 1);
        }
    }
    mesh
}
