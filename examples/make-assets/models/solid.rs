//! Boxes with rounded edges.

use glam::{DVec2, DVec3};

use super::angle;
use super::mesh::{Mesh, Vertex};

/// A box of half sizes `half` about the origin with edges rounded by `radius` in `steps` strips per eighth of a turn.
///
/// Each face has its own texture coordinates, in metres.
pub fn rounded_box(half: DVec3, radius: f64, steps: u32) -> Mesh {
    let mut mesh = Mesh::default();
    for axis in 0..3 {
        for side in [-1.0, 1.0] {
            mesh.append(&face(half, radius, steps, axis, side));
        }
    }
    mesh
}

/// One face with its half of the rounded edges.
fn face(half: DVec3, radius: f64, steps: u32, axis: usize, side: f64) -> Mesh {
    let (right, down) = ((axis + 1) % 3, (axis + 2) % 3);
    let inner = half - DVec3::splat(radius);
    // Offsets from the inner box whose directions from it are evenly spaced up to 45 degrees.
    let offsets: Vec<f64> = (0..=steps)
        .map(|i| {
            let turns = 0.125 * f64::from(i) / f64::from(steps);
            if i == steps { radius } else { radius * (angle::sin(turns) / angle::cos(turns)) }
        })
        .collect();
    let positions = |limit: f64| -> Vec<f64> {
        let low = offsets.iter().rev().map(|o| -limit - o);
        low.chain(offsets.iter().map(|o| limit + o)).collect()
    };
    let (rights, downs) = (positions(inner[right]), positions(inner[down]));
    let mut mesh = Mesh::grid(downs.len(), rights.len(), |row, column| {
        let mut outer = DVec3::ZERO;
        outer[axis] = side * half[axis];
        outer[right] = rights[column];
        outer[down] = downs[row];
        let nearest = outer.clamp(-inner, inner);
        let normal = (outer - nearest).normalize();
        Vertex {
            position: nearest + normal * radius,
            normal,
            uv: DVec2::new(outer[right] * side, outer[down]),
        }
    });
    if side > 0.0 {
        for triangle in &mut mesh.triangles {
            triangle.swap(1, 2);
        }
    }
    mesh
}
