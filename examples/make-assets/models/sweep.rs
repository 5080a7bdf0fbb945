//! A cross-section carried along a path.

use glam::{DVec2, DVec3};

use super::angle;
use super::mesh::{Mesh, Vertex};

/// A point of a path with the frame of its cross-section.
#[derive(Clone, Copy, Debug)]
pub struct Station {
    /// Centre of the section.
    pub centre: DVec3,
    /// Direction of the section's first coordinate, times its scale.
    pub across: DVec3,
    /// Direction of the section's second coordinate, times its scale; `across` x `up` points forward along the path.
    pub up: DVec3,
}

/// Treatment of the ends of a path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ends {
    /// The last station joins the first.
    Joined,
    /// Flat caps.
    Capped,
}

/// An ellipse or superellipse of `sides` points: squareness 1 is round, towards 0 square.
pub fn section(sides: u32, squareness: f64) -> Vec<DVec2> {
    (0..sides)
        .map(|i| {
            let round = angle::unit(f64::from(i) / f64::from(sides));
            let (x, y) = (round.x.abs(), round.y.abs());
            let square = round / if x > y { x } else { y };
            square.lerp(round, squareness)
        })
        .collect()
}

/// Sweeps a closed convex section, counter-clockwise, along the stations.
pub fn sweep(stations: &[Station], section: &[DVec2], ends: Ends) -> Mesh {
    let count = section.len();
    let rows = stations.len() + usize::from(ends == Ends::Joined);
    let place = |row: usize, column: usize| {
        let station = &stations[row % stations.len()];
        let point = section[column % count];
        station.centre + station.across * point.x + station.up * point.y
    };
    let mut along = vec![0.0; rows];
    for row in 1..rows {
        let step = stations[row % stations.len()].centre - stations[row - 1].centre;
        along[row] = along[row - 1] + step.length();
    }
    let mut mesh = Mesh::grid(rows, count + 1, |row, column| {
        let here = row % stations.len();
        let (before, after) = match ends {
            Ends::Joined => ((here + stations.len() - 1) % stations.len(), (here + 1) % stations.len()),
            Ends::Capped => (here.saturating_sub(1), (here + 1).min(stations.len() - 1)),
        };
        let forward = place(after, column) - place(before, column);
        let around = place(here, column + 1) - place(here, column + count - 1);
        Vertex {
            position: place(here, column),
            normal: around.cross(forward).normalize_or_zero(),
            uv: DVec2::new(column as f64 / count as f64, along[row]),
        }
    });
    // Rows of the grid run forward, so its outside is seen with columns to the left.
    for triangle in &mut mesh.triangles {
        triangle.swap(1, 2);
    }
    if ends == Ends::Capped {
        cap(&mut mesh, &stations[0], section, -1.0);
        cap(&mut mesh, &stations[stations.len() - 1], section, 1.0);
    }
    mesh
}

/// A fan over a section, facing forward (`side` = 1) or backward (-1).
fn cap(mesh: &mut Mesh, station: &Station, section: &[DVec2], side: f64) {
    let normal = station.across.cross(station.up) * side;
    let first = mesh.vertices.len() as u32;
    for point in section {
        let position = station.centre + station.across * point.x + station.up * point.y;
        mesh.push(Vertex { uv: *point, ..Vertex::new(position, normal) });
    }
    for i in 1..section.len() as u32 - 1 {
        let (a, b) = if side > 0.0 { (i, i + 1) } else { (i + 1, i) };
        mesh.triangles.push([first, first + a, first + b]);
    }
}
