//! The skin of the car's body: a control cage of 17 sections, subdivided.
//!
//! Here x points forward, y up and z to the right; the origin lies on the ground between the axles. Metres.

use std::collections::BTreeMap;

use glam::{DVec2, DVec3};

use super::super::mesh::Mesh;
use super::super::subdivide::Cage;

/// Control points of one section, right half.
struct Section {
    /// Place of the centre line.
    x: f64,
    /// Distance of the shoulder behind the centre line, in metres.
    sweep: f64,
    /// (y, z) over the top: centre line, inner, middle, roof rail, belt line, fender crest, shoulder.
    top: [(f64, f64); TOP],
    /// (y, z) down the side: below the shoulder, waist, lower door, sill, floor.
    side: [(f64, f64); SIDE],
}

const TOP: usize = 7;
const SIDE: usize = 5;

/// From the nose to the tail.
#[rustfmt::skip]
const SECTIONS: [Section; 17] = [
    Section { x: 2.17, sweep: 0.44,
        top: [(0.428, 0.0), (0.429, 0.20), (0.432, 0.40), (0.435, 0.55), (0.438, 0.66), (0.440, 0.76), (0.430, 0.84)],
        side: [(0.375, 0.875), (0.32, 0.885), (0.25, 0.885), (0.19, 0.875), (0.14, 0.86)] },
    Section { x: 2.08, sweep: 0.38,
        top: [(0.500, 0.0), (0.501, 0.21), (0.505, 0.42), (0.510, 0.57), (0.520, 0.68), (0.530, 0.79), (0.500, 0.87)],
        side: [(0.435, 0.895), (0.360, 0.905), (0.275, 0.905), (0.19, 0.895), (0.13, 0.875)] },
    Section { x: 1.85, sweep: 0.27,
        top: [(0.590, 0.0), (0.590, 0.22), (0.592, 0.43), (0.600, 0.58), (0.620, 0.70), (0.648, 0.82), (0.600, 0.905)],
        side: [(0.515, 0.925), (0.415, 0.935), (0.30, 0.935), (0.19, 0.920), (0.125, 0.89)] },
    Section { x: 1.58, sweep: 0.15,
        top: [(0.662, 0.0), (0.661, 0.22), (0.662, 0.44), (0.672, 0.59), (0.712, 0.715), (0.755, 0.835), (0.695, 0.93)],
        side: [(0.585, 0.950), (0.468, 0.957), (0.33, 0.957), (0.20, 0.935), (0.125, 0.90)] },
    Section { x: 1.30, sweep: 0.05,
        top: [(0.722, 0.0), (0.720, 0.22), (0.720, 0.44), (0.728, 0.59), (0.768, 0.72), (0.822, 0.84), (0.750, 0.945)],
        side: [(0.630, 0.964), (0.500, 0.967), (0.35, 0.962), (0.20, 0.940), (0.125, 0.90)] },
    Section { x: 1.05, sweep: 0.0,
        top: [(0.770, 0.0), (0.767, 0.22), (0.760, 0.44), (0.750, 0.60), (0.763, 0.715), (0.823, 0.835), (0.760, 0.942)],
        side: [(0.640, 0.957), (0.500, 0.952), (0.35, 0.940), (0.20, 0.930), (0.125, 0.89)] },
    Section { x: 0.85, sweep: 0.0,
        top: [(0.820, 0.0), (0.815, 0.23), (0.800, 0.45), (0.780, 0.62), (0.775, 0.71), (0.810, 0.82), (0.760, 0.928)],
        side: [(0.645, 0.943), (0.500, 0.928), (0.35, 0.908), (0.20, 0.920), (0.125, 0.88)] },
    Section { x: 0.55, sweep: 0.0,
        top: [(0.955, 0.0), (0.950, 0.23), (0.925, 0.44), (0.875, 0.585), (0.800, 0.71), (0.800, 0.81), (0.760, 0.913)],
        side: [(0.650, 0.932), (0.500, 0.905), (0.35, 0.875), (0.20, 0.915), (0.125, 0.875)] },
    Section { x: 0.20, sweep: 0.0,
        top: [(1.105, 0.0), (1.100, 0.22), (1.075, 0.42), (1.010, 0.56), (0.825, 0.71), (0.808, 0.80), (0.768, 0.904)],
        side: [(0.655, 0.924), (0.500, 0.890), (0.35, 0.858), (0.20, 0.915), (0.125, 0.875)] },
    Section { x: -0.15, sweep: 0.0,
        top: [(1.190, 0.0), (1.185, 0.22), (1.160, 0.41), (1.090, 0.545), (0.850, 0.715), (0.822, 0.80), (0.778, 0.905)],
        side: [(0.660, 0.926), (0.500, 0.888), (0.35, 0.855), (0.20, 0.915), (0.125, 0.875)] },
    Section { x: -0.50, sweep: 0.0,
        top: [(1.190, 0.0), (1.185, 0.21), (1.160, 0.40), (1.090, 0.535), (0.875, 0.72), (0.843, 0.81), (0.795, 0.912)],
        side: [(0.675, 0.934), (0.510, 0.902), (0.355, 0.870), (0.20, 0.918), (0.125, 0.88)] },
    Section { x: -0.85, sweep: 0.0,
        top: [(1.135, 0.0), (1.130, 0.20), (1.110, 0.385), (1.050, 0.52), (0.895, 0.71), (0.877, 0.825), (0.815, 0.932)],
        side: [(0.690, 0.955), (0.525, 0.935), (0.36, 0.905), (0.20, 0.925), (0.125, 0.885)] },
    Section { x: -1.15, sweep: 0.0,
        top: [(1.060, 0.0), (1.055, 0.19), (1.035, 0.37), (0.990, 0.50), (0.905, 0.70), (0.912, 0.84), (0.835, 0.952)],
        side: [(0.705, 0.975), (0.535, 0.968), (0.36, 0.940), (0.20, 0.930), (0.125, 0.89)] },
    Section { x: -1.45, sweep: 0.0,
        top: [(0.980, 0.0), (0.975, 0.19), (0.962, 0.37), (0.935, 0.50), (0.900, 0.70), (0.920, 0.845), (0.840, 0.960)],
        side: [(0.710, 0.982), (0.535, 0.980), (0.36, 0.960), (0.20, 0.935), (0.125, 0.89)] },
    Section { x: -1.75, sweep: -0.05,
        top: [(0.915, 0.0), (0.914, 0.20), (0.907, 0.38), (0.897, 0.52), (0.888, 0.70), (0.895, 0.830), (0.825, 0.94)],
        side: [(0.700, 0.960), (0.535, 0.965), (0.37, 0.950), (0.22, 0.925), (0.15, 0.88)] },
    Section { x: -2.00, sweep: -0.15,
        top: [(0.885, 0.0), (0.885, 0.20), (0.883, 0.40), (0.880, 0.54), (0.876, 0.69), (0.868, 0.80), (0.800, 0.89)],
        side: [(0.685, 0.912), (0.535, 0.920), (0.39, 0.905), (0.25, 0.880), (0.18, 0.85)] },
    Section { x: -2.15, sweep: -0.28,
        top: [(0.900, 0.0), (0.900, 0.20), (0.897, 0.40), (0.891, 0.54), (0.876, 0.68), (0.853, 0.78), (0.788, 0.85)],
        side: [(0.700, 0.870), (0.555, 0.880), (0.42, 0.870), (0.28, 0.845), (0.20, 0.82)] },
];

/// Distances of the rows of the front and the rear face ahead of their top edges, in metres.
const FRONT: [f64; SIDE] = [0.035, 0.045, 0.045, 0.04, 0.02];
const REAR: [f64; SIDE] = [0.055, 0.04, -0.015, 0.0, 0.06];

/// A place in the cage: station from the nose, row down the side (0 on top), column from the centre line.
type Node = (usize, usize, usize);

/// The cage of both halves.
fn cage() -> Cage {
    let sections = sharpened();
    let last = sections.len() - 1;
    let mut nodes: BTreeMap<(Node, bool), u32> = BTreeMap::new();
    let mut cage = Cage::default();
    let mut node = |cage: &mut Cage, place: Node, mirror: bool| {
        let mirror = mirror && place.2 > 0;
        *nodes.entry((place, mirror)).or_insert_with(|| {
            let mut point = control_point(&sections, place);
            point.z *= if mirror { -1.0 } else { 1.0 };
            cage.points.push(point);
            cage.points.len() as u32 - 1
        })
    };
    let mut quad = |places: [Node; 4]| {
        for mirror in [false, true] {
            let mut corners = places.map(|p| node(&mut cage, p, mirror));
            if !mirror {
                corners.reverse();
            }
            cage.quads.push(corners);
        }
    };
    let edge = TOP - 1;
    for i in 0..last {
        for k in 0..edge {
            quad([(i, 0, k), (i, 0, k + 1), (i + 1, 0, k + 1), (i + 1, 0, k)]);
        }
        for j in 0..SIDE {
            quad([(i, j, edge), (i, j + 1, edge), (i + 1, j + 1, edge), (i + 1, j, edge)]);
        }
    }
    for k in 0..edge {
        for j in 0..SIDE {
            quad([(0, j, k), (0, j + 1, k), (0, j + 1, k + 1), (0, j, k + 1)]);
            quad([(last, j, k), (last, j, k + 1), (last, j + 1, k + 1), (last, j + 1, k)]);
        }
    }
    cage
}

/// The sections moved apart so that the subdivided surface, a cubic B-spline along the car, comes close to them.
fn sharpened() -> Vec<Section> {
    // All of the correction would interpolate and show every unevenness of the numbers.
    const SHARE: f64 = 0.6;
    let last = SECTIONS.len() - 1;
    (0..=last)
        .map(|i| {
            let (before, own, after) =
                (&SECTIONS[i.saturating_sub(1)], &SECTIONS[i], &SECTIONS[(i + 1).min(last)]);
            let mix = |value: &dyn Fn(&Section) -> f64| {
                let smoothed = (value(before) + 4.0 * value(own) + value(after)) / 6.0;
                if i == 0 || i == last { value(own) } else { value(own) + SHARE * (value(own) - smoothed) }
            };
            Section {
                x: own.x,
                sweep: mix(&|s| s.sweep),
                top: std::array::from_fn(|k| (mix(&|s| s.top[k].0), mix(&|s| s.top[k].1))),
                side: std::array::from_fn(|k| (mix(&|s| s.side[k].0), mix(&|s| s.side[k].1))),
            }
        })
        .collect()
}

/// Position of a node of the control cage.
fn control_point(sections: &[Section], (station, row, column): Node) -> DVec3 {
    let section = &sections[station];
    let (shoulder, place) = (section.top[TOP - 1].1, section.top[column]);
    let across = place.1 / shoulder;
    // Blunt in the middle, turning fast at the corners.
    let bend = 0.5 * across * across * (1.0 + across * across);
    let (y, z, ahead) = match row.checked_sub(1) {
        None => (place.0, place.1, 0.0),
        Some(row) => {
            let (y, z) = section.side[row];
            let ahead = match station {
                0 => FRONT[row],
                _ if station + 1 == sections.len() => REAR[row],
                _ => 0.0,
            };
            (y, z * across, ahead)
        }
    };
    DVec3::new(section.x - section.sweep * bend + ahead, y, z)
}

/// The right half of the skin, open at the centre line and at the floor.
pub fn right_half() -> Mesh {
    let mut mesh = cage().refined().refined().limit(|centre| centre.z > 0.0, texture_place);
    for vertex in &mut mesh.vertices {
        if vertex.position.z.abs() < 1e-6 {
            vertex.position.z = 0.0;
            vertex.normal.z = 0.0;
            vertex.normal = vertex.normal.normalize_or_zero();
        }
    }
    mesh
}

/// Texture coordinates, 8 to the metre, by one skewed projection, nowhere degenerate on this body and without seams.
pub fn texture_place(p: DVec3) -> DVec2 {
    DVec2::new(p.x * (1.0 - 0.35 * p.y), p.z.abs() - p.y) * 8.0
}
