//! Splitter, skirts, diffuser, exhausts, grille, mirrors, number plate and wipers.

use glam::{DMat3, DVec2, DVec3};

use super::super::angle;
use super::super::cut::{Cut, Offset, Region, cut};
use super::super::letters;
use super::super::mesh::{Mesh, Vertex};
use super::super::revolve::{revolve, rounded};
use super::super::solid::rounded_box;
use super::super::sweep::{Ends, Station, section, sweep};
use super::lights::{smooth, strip};
use super::materials::Stuff;
use super::probe::{Place, Probe};

/// Parts with their materials.
type Parts = Vec<(usize, Mesh)>;

/// Everything, both halves.
pub fn all(probe: &Probe) -> Parts {
    let mut parts = Parts::new();
    let mut both = |(stuff, mesh): (Stuff, Mesh)| parts.push((stuff as usize, mesh.with_mirror()));
    both((Stuff::Carbon, skirt()));
    for (stuff, mesh) in mirror(probe) {
        both((stuff, mesh));
    }
    for z in [0.16, 0.33, 0.50] {
        let fin = rounded_box(DVec3::new(0.15, 0.05, 0.005), 0.004, 1);
        both((
            Stuff::Carbon,
            fin.mapped(|v| DVec2::new(v.position.x, v.position.y) * 14.0)
                .translated(DVec3::new(-1.95, 0.195, z)),
        ));
    }
    for z in [0.085, 0.205] {
        let end = probe.rear(z, 0.36).position + DVec3::new(0.005, 0.0, 0.0);
        for (stuff, mesh) in exhaust(end) {
            both((stuff, mesh));
        }
    }
    let handle: Vec<Place> =
        (0..=5).map(|i| probe.side(-0.25 - 0.04 * f64::from(i), 0.735 + 0.002 * f64::from(i))).collect();
    both((Stuff::Chrome, strip(&handle, -0.006, 0.009, 0.009)));
    for y in [0.225, 0.27, 0.315] {
        let side: Vec<Place> = (0..=6).map(|i| probe.front(0.60 + 0.04 * f64::from(i), y)).collect();
        both((Stuff::Housing, strip(&side, 0.03, 0.006, 0.016)));
    }
    for y in [0.215, 0.25, 0.285, 0.32] {
        let bar: Vec<Place> = (-9..=9).map(|i| probe.front(0.06 * f64::from(i), y)).collect();
        parts.push((Stuff::Housing as usize, strip(&bar, 0.03, 0.006, 0.016)));
    }
    parts.push((Stuff::Carbon as usize, splitter(probe)));
    parts.extend(number_plate(probe));
    parts.extend(wipers(probe));
    parts
}

/// A blade under the nose, along its outline.
fn splitter(probe: &Probe) -> Mesh {
    let places: Vec<Place> = (-16..=16)
        .map(|i| {
            let z = 0.80 * f64::from(i) / 16.0;
            probe.front(z, 0.145)
        })
        .collect();
    let last = places.len() - 1;
    let stations: Vec<Station> = (0..=last)
        .map(|i| {
            let along = places[(i + 1).min(last)].position - places[i.saturating_sub(1)].position;
            let out = along.cross(DVec3::NEG_Y).normalize();
            let mut centre = places[i].position;
            centre.y = 0.130;
            let end = f64::from(i as u32) / last as f64 * 2.0 - 1.0;
            let reach = 0.058 - 0.035 * end * end * end * end;
            Station { centre: centre + out * -0.03, across: out * -reach, up: DVec3::NEG_Y * -0.009 }
        })
        .collect();
    outward(sweep(&stations, &section(8, 0.5), Ends::Capped)).mapped(from_above)
}

/// Turns a sweep over if its path ran against its frames.
fn outward(mut mesh: Mesh) -> Mesh {
    let volume: f64 = mesh
        .triangles
        .iter()
        .map(|t| {
            let [a, b, c] = t.map(|i| mesh.vertices[i as usize].position);
            a.dot(b.cross(c))
        })
        .sum();
    if volume < 0.0 {
        for triangle in &mut mesh.triangles {
            triangle.swap(1, 2);
        }
        for vertex in &mut mesh.vertices {
            vertex.normal = -vertex.normal;
        }
    }
    mesh
}

/// Texture coordinates of flat parts.
fn from_above(vertex: &Vertex) -> DVec2 {
    DVec2::new(vertex.position.x, vertex.position.z) * 14.0
}

/// A blade along the sill.
fn skirt() -> Mesh {
    let stations: Vec<Station> = (0..=14)
        .map(|i| {
            let t = f64::from(i) / 14.0;
            let x = 0.865 - 1.72 * t;
            let bow = 4.0 * t * (1.0 - t);
            Station {
                centre: DVec3::new(x, 0.118, 0.885 - 0.012 * bow + 0.03 * t * t),
                across: DVec3::Z * 0.05,
                up: DVec3::Y * 0.010,
            }
        })
        .collect();
    outward(sweep(&stations, &section(8, 0.5), Ends::Capped)).mapped(from_above)
}

/// An exhaust pipe that ends at `end`.
fn exhaust(end: DVec3) -> Vec<(Stuff, Mesh)> {
    let turned = |corners: &[(f64, f64, f64)]| {
        let corners: Vec<_> = corners.iter().map(|&(r, y, round)| (DVec2::new(r, y), round)).collect();
        let backwards = DMat3::from_cols(DVec3::Y, DVec3::NEG_X, DVec3::Z);
        revolve(&rounded(&corners, 1), 20).transformed(backwards).translated(end)
    };
    vec![
        (
            Stuff::Chrome,
            turned(&[
                (0.043, -0.15, 0.0),
                (0.052, -0.15, 0.0),
                (0.052, 0.03, 0.004),
                (0.046, 0.032, 0.003),
                (0.043, -0.02, 0.0),
                (0.043, -0.15, 0.0),
            ]),
        ),
        (
            Stuff::Trim,
            turned(&[(0.0, -0.10, 0.0), (0.044, -0.10, 0.0), (0.044, -0.06, 0.0), (0.0, -0.06, 0.0)]),
        ),
    ]
}

/// The right door mirror.
fn mirror(probe: &Probe) -> Vec<(Stuff, Mesh)> {
    let base = probe.side(0.54, 0.81);
    let centre = DVec3::new(0.50, 0.905, 0.955);
    // The shell: sections across x, from its rounded nose to the open rear.
    let shape = |t: f64| (1.0 - (1.0 - t) * (1.0 - t) * (1.0 - t)).sqrt();
    let stations: Vec<Station> = (0..=9)
        .map(|i| {
            let t = f64::from(i) / 9.0;
            let round = 0.04 + 0.96 * shape(t);
            Station {
                centre: centre + DVec3::new(0.075 - 0.145 * t, 0.0, 0.0),
                across: DVec3::new(0.02, 0.012, 0.095) * round,
                up: DVec3::Y * (0.055 * round),
            }
        })
        .collect();
    let shell = outward(sweep(&stations, &section(20, 0.62), Ends::Capped));
    let rear = centre + DVec3::new(-0.0715, 0.0, 0.0);
    let glass = Station { centre: rear, across: DVec3::new(0.02, 0.012, 0.095) * 0.9, up: DVec3::Y * 0.049 };
    let behind = Station { centre: rear + DVec3::NEG_X * 0.003, ..glass };
    let glass = outward(sweep(&[glass, behind], &section(20, 0.62), Ends::Capped));
    let arm: Vec<Station> = (0..=8)
        .map(|i| {
            let t = f64::from(i) / 8.0;
            let foot = base.inside(0.01);
            let low = DVec3::new(0.50, 0.87, 0.92);
            let centre = foot.lerp(low, t);
            Station { centre, across: DVec3::X * (0.05 - 0.018 * t), up: DVec3::new(0.0, -0.007, 0.012) }
        })
        .collect();
    let arm = outward(sweep(&arm, &section(12, 0.8), Ends::Capped));
    vec![
        (Stuff::Carbon, shell.mapped(|v| DVec2::new(v.position.z, v.position.y) * 14.0)),
        (Stuff::Chrome, glass),
        (Stuff::Trim, arm),
    ]
}

/// The rear plate with the project's name.
fn number_plate(probe: &Probe) -> Parts {
    const HALF: DVec2 = DVec2::new(0.25, 0.056);
    const SIZE: f64 = 0.046;
    let strokes: Vec<Vec<DVec2>> = letters::word("overcoat")
        .iter()
        .map(|stroke| stroke.iter().map(|p| *p * SIZE - DVec2::new(0.0, 0.55 * SIZE)).collect())
        .collect();
    let face = Mesh::grid(11, 49, |row, column| {
        let p = DVec2::new(column as f64 / 24.0 - 1.0, 1.0 - row as f64 / 5.0) * HALF;
        Vertex { position: p.extend(0.0), normal: DVec3::Z, uv: DVec2::ZERO }
    });
    let cuts = [Cut {
        curve: Box::new(move |p, _| letters::distance(&strokes, 0.0062, p.truncate()).value),
        half_width: 0.0,
        detail: 1.0,
        rim: 0.0,
        gap: 0,
        inside: Some(1),
    }];
    let region = |offset, output, back| Region { offset, output, walls: output, rounding: 0.0, back };
    let regions = [
        region(Offset::In(0.0), 0, Some(2)),
        region(Offset::In(-0.002), 1, Some(2)),
        region(Offset::Open(0.001), 0, None),
    ];
    let place = probe.rear(0.0, 0.53);
    let facing = DMat3::from_cols(DVec3::Z, DVec3::Y, DVec3::NEG_X);
    let tilt = DMat3::from_cols(
        DVec3::new(angle::cos(0.02), angle::sin(0.02), 0.0),
        DVec3::new(-angle::sin(0.02), angle::cos(0.02), 0.0),
        DVec3::Z,
    );
    let centre = DVec3::new(place.position.x - 0.012, place.position.y, 0.0);
    let placed = |mesh: Mesh| mesh.transformed(tilt * facing).translated(centre);
    let mut meshes = cut(face, &cuts, &regions, 2);
    let letters = placed(meshes.remove(1));
    let white = placed(meshes.remove(0));
    let holder = rounded_box(DVec3::new(HALF.x + 0.008, HALF.y + 0.008, 0.012), 0.006, 2)
        .translated(DVec3::new(0.0, 0.0, -0.0135));
    vec![
        (Stuff::Plate as usize, white),
        (Stuff::Trim as usize, letters),
        (Stuff::Trim as usize, placed(holder)),
    ]
}

/// Wipers at the foot of the windscreen.
fn wipers(probe: &Probe) -> Parts {
    let blade = |points: &[(f64, f64)]| {
        let places: Vec<Place> = points
            .iter()
            .map(|&(x, z)| {
                let mut place = probe.top(x, z.abs());
                if z < 0.0 {
                    place.position.z = -place.position.z;
                    place.normal.z = -place.normal.z;
                }
                place
            })
            .collect();
        outward(strip(&smooth(&places), -0.012, 0.006, 0.006))
    };
    vec![
        (Stuff::Trim as usize, blade(&[(0.86, -0.02), (0.82, -0.20), (0.76, -0.38), (0.70, -0.50)])),
        (Stuff::Trim as usize, blade(&[(0.83, 0.44), (0.83, 0.28), (0.82, 0.12), (0.80, -0.02)])),
    ]
}
