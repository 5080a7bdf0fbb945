//! Wheels and brakes. The axle is the z axis, outwards positive.

use glam::{DMat3, DVec2, DVec3};

use super::super::angle;
use super::super::cut::{Cut, Offset, Region, cut};
use super::super::mesh::{Mesh, Vertex};
use super::super::outline::stroke_distance;
use super::super::revolve::{revolve, rounded};
use super::super::solid::rounded_box;
use super::super::sweep::{Ends, Station, section, sweep};
use super::materials::Stuff;

/// Half the width of the tyre.
pub const HALF_WIDTH: f64 = 0.135;
/// Radius where tyre and rim meet.
const BEAD: f64 = 0.247;
/// Twin spokes.
const SPOKES: u32 = 5;

/// From the y axis of a surface of revolution to the axle.
fn axle(mesh: Mesh) -> Mesh {
    mesh.transformed(DMat3::from_cols(DVec3::X, DVec3::Z, DVec3::NEG_Y))
}

/// Turns a closed profile of (radius, distance outwards, corner radius).
fn turned(corners: &[(f64, f64, f64)], sides: u32) -> Mesh {
    let corners: Vec<_> = corners.iter().map(|&(r, y, round)| (DVec2::new(r, y), round)).collect();
    axle(revolve(&rounded(&corners, 2), sides))
}

/// Tyre and rim of one wheel.
pub fn wheel(radius: f64) -> Vec<(usize, Mesh)> {
    let mut parts = vec![(Stuff::Rubber as usize, tyre(radius)), (Stuff::Rim as usize, barrel())];
    parts.push((Stuff::Rim as usize, spokes()));
    let cap = turned(&[(0.0, 0.083, 0.0), (0.030, 0.083, 0.0), (0.030, 0.096, 0.004), (0.0, 0.099, 0.0)], 20);
    parts.push((Stuff::Chrome as usize, cap));
    for i in 0..SPOKES {
        let place = angle::unit((f64::from(i) + 0.5) / f64::from(SPOKES)) * 0.047;
        let nut =
            turned(&[(0.0, 0.078, 0.0), (0.0085, 0.078, 0.0), (0.0085, 0.092, 0.002), (0.0, 0.093, 0.0)], 6);
        parts.push((Stuff::Steel as usize, nut.translated(place.extend(0.0))));
    }
    parts
}

/// A tyre with rounded shoulders and four grooves.
fn tyre(radius: f64) -> Mesh {
    let w = HALF_WIDTH;
    let mut corners = vec![
        (BEAD - 0.004, 0.0, 0.0),
        (BEAD - 0.004, -w + 0.022, 0.0),
        (BEAD + 0.006, -w + 0.010, 0.006),
        (BEAD + 0.035, -w, 0.03),
        (radius - 0.022, -w + 0.004, 0.03),
        (radius - 0.004, -w + 0.026, 0.02),
    ];
    for groove in [-0.04, 0.04] {
        let (half, depth) = (0.0055, 0.007);
        corners.extend([
            (radius, groove - half, 0.0),
            (radius - depth, groove - half * 0.7, 0.0),
            (radius - depth, groove + half * 0.7, 0.0),
            (radius, groove + half, 0.0),
        ]);
    }
    corners.extend([
        (radius - 0.004, w - 0.026, 0.02),
        (radius - 0.022, w - 0.004, 0.03),
        (BEAD + 0.050, w + 0.001, 0.006),
        (BEAD + 0.047, w - 0.002, 0.002),
        (BEAD + 0.030, w - 0.003, 0.02),
        (BEAD + 0.006, w - 0.012, 0.006),
        (BEAD - 0.004, w - 0.022, 0.0),
        (BEAD - 0.004, 0.0, 0.0),
    ]);
    turned(&corners, 36)
}

/// The barrel of the rim with its outer lip.
fn barrel() -> Mesh {
    turned(
        &[
            (BEAD, 0.0, 0.0),
            (BEAD, 0.112, 0.0),
            (BEAD + 0.010, 0.118, 0.003),
            (BEAD + 0.011, 0.127, 0.003),
            (BEAD - 0.003, 0.129, 0.004),
            (BEAD - 0.012, 0.108, 0.01),
            (BEAD - 0.022, 0.075, 0.02),
            (BEAD - 0.028, -0.10, 0.01),
            (BEAD, -0.112, 0.0),
            (BEAD, 0.0, 0.0),
        ],
        36,
    )
}

/// The star of twin spokes, cut out of a dish.
fn spokes() -> Mesh {
    const RINGS: usize = 5;
    const SIDES: usize = 50;
    const OUTER: f64 = BEAD - 0.014;
    let dish = |r: f64| 0.081 + 0.022 * (r / OUTER) * (r / OUTER);
    let disc = Mesh::grid(RINGS + 1, SIDES + 1, |row, column| {
        let r = OUTER * (1.0 - row as f64 / RINGS as f64);
        let direction = angle::unit((SIDES - column) as f64 / SIDES as f64);
        let slope = 0.044 * r / (OUTER * OUTER);
        Vertex {
            position: (direction * r).extend(dish(r)),
            normal: (direction * -slope).extend(1.0).normalize(),
            uv: direction * r,
        }
    });
    let pairs: Vec<[[DVec2; 2]; 2]> = (0..SPOKES)
        .map(|i| {
            let out = angle::unit(f64::from(i) / f64::from(SPOKES) + 0.05);
            let side = out.perp();
            [-1.0, 1.0].map(|s| [out * 0.045 + side * (0.018 * s), out * 0.245 + side * (0.062 * s)])
        })
        .collect();
    let spoke = move |p: DVec3, _: DVec3| {
        let p = p.truncate();
        let r = p.length();
        let mut value = r - 0.062;
        let ring = OUTER - 0.012 - r;
        if ring < value {
            value = ring;
        }
        for stroke in pairs.iter().flatten() {
            let d = stroke_distance(stroke, 0.0125 + 0.02 * (0.2 - r).abs() * 0.5, p).value;
            if d < value {
                value = d;
            }
        }
        -value
    };
    let cuts =
        [Cut { curve: Box::new(spoke), half_width: 0.0, detail: 1.0, rim: 0.004, gap: 1, inside: Some(1) }];
    let regions = [
        Region { offset: Offset::In(0.0), output: 0, walls: 0, rounding: 0.0016, back: Some(1) },
        Region { offset: Offset::Open(0.035), output: 0, walls: 0, rounding: 0.0016, back: None },
    ];
    cut(disc, &cuts, &regions, 1).remove(0)
}

/// Disc and caliper; `side` is the direction (turns from forward, upwards) in which the caliper sits.
pub fn brake(side: f64) -> Vec<(usize, Mesh)> {
    let disc = turned(
        &[
            (0.0, 0.02, 0.0),
            (0.085, 0.02, 0.0),
            (0.095, -0.002, 0.0),
            (0.095, -0.01, 0.0),
            (0.192, -0.01, 0.0),
            (0.192, 0.022, 0.001),
            (0.100, 0.022, 0.0),
            (0.092, 0.046, 0.004),
            (0.0, 0.046, 0.0),
        ],
        32,
    );
    let stations: Vec<Station> = (0..=10)
        .map(|i| {
            let t = f64::from(i) / 10.0;
            let out = angle::unit(side + (t - 0.5) * 0.17);
            // Rounded ends.
            let end = (2.0 * t - 1.0) * (2.0 * t - 1.0);
            let scale = (1.0 - end * end * end * end * 0.45).sqrt();
            Station {
                centre: (out * 0.182).extend(0.014),
                across: (out * 0.034 * scale).extend(0.0),
                up: DVec3::Z * (-0.042 * scale),
            }
        })
        .collect();
    let caliper = sweep(&stations, &section(16, 0.35), Ends::Capped);
    let pad = rounded_box(DVec3::new(0.012, 0.03, 0.004), 0.003, 2)
        .translated((angle::unit(side) * 0.182).extend(0.057));
    vec![
        (Stuff::Steel as usize, disc.mapped(|v| DVec2::new(v.uv.x * 2.0, v.uv.y * 6.0))),
        (Stuff::Caliper as usize, caliper),
        (Stuff::Chrome as usize, pad),
    ]
}
