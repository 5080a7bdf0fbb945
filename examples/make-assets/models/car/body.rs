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
    /// How far the shoulder lies behind the centre line.
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
    Section { x: 2.17, sweep: 0.42,
        top: [(0.500, 0.0), (0.500, 0.20), (0.500, 0.40), (0.500, 0.55), (0.500, 0.66), (0.505, 0.76), (0.490, 0.84)],
        side: [(0.430, 0.875), (0.355, 0.885), (0.27, 0.885), (0.19, 0.875), (0.14, 0.86)] },
    Section { x: 2.08, sweep: 0.37,
        top: [(0.555, 0.0), (0.555, 0.21), (0.555, 0.42), (0.555, 0.57), (0.560, 0.68), (0.570, 0.79), (0.545, 0.87)],
        side: [(0.470, 0.895), (0.380, 0.905), (0.28, 0.905), (0.19, 0.895), (0.13, 0.875)] },
    Section { x: 1.85, sweep: 0.26,
        top: [(0.625, 0.0), (0.625, 0.22), (0.625, 0.43), (0.625, 0.58), (0.635, 0.70), (0.665, 0.82), (0.620, 0.905)],
        side: [(0.530, 0.925), (0.420, 0.935), (0.30, 0.935), (0.19, 0.920), (0.125, 0.89)] },
    Section { x: 1.58, sweep: 0.14,
        top: [(0.685, 0.0), (0.685, 0.22), (0.682, 0.44), (0.682, 0.59), (0.705, 0.715), (0.755, 0.835), (0.700, 0.93)],
        side: [(0.590, 0.950), (0.470, 0.955), (0.33, 0.955), (0.20, 0.935), (0.125, 0.90)] },
    Section { x: 1.30, sweep: 0.05,
        top: [(0.735, 0.0), (0.735, 0.22), (0.730, 0.44), (0.725, 0.59), (0.750, 0.72), (0.810, 0.84), (0.745, 0.945)],
        side: [(0.630, 0.962), (0.500, 0.965), (0.35, 0.960), (0.20, 0.940), (0.125, 0.90)] },
    Section { x: 1.05, sweep: 0.0,
        top: [(0.775, 0.0), (0.772, 0.22), (0.765, 0.44), (0.755, 0.60), (0.765, 0.715), (0.815, 0.835), (0.755, 0.94)],
        side: [(0.640, 0.957), (0.500, 0.955), (0.35, 0.945), (0.20, 0.930), (0.125, 0.89)] },
    Section { x: 0.85, sweep: 0.0,
        top: [(0.820, 0.0), (0.815, 0.23), (0.800, 0.45), (0.780, 0.62), (0.775, 0.71), (0.805, 0.82), (0.755, 0.925)],
        side: [(0.645, 0.943), (0.500, 0.935), (0.35, 0.920), (0.20, 0.915), (0.125, 0.88)] },
    Section { x: 0.55, sweep: 0.0,
        top: [(0.955, 0.0), (0.950, 0.23), (0.925, 0.44), (0.875, 0.585), (0.800, 0.71), (0.795, 0.81), (0.755, 0.91)],
        side: [(0.650, 0.930), (0.500, 0.915), (0.35, 0.895), (0.20, 0.905), (0.125, 0.875)] },
    Section { x: 0.20, sweep: 0.0,
        top: [(1.105, 0.0), (1.100, 0.22), (1.075, 0.42), (1.010, 0.56), (0.825, 0.71), (0.805, 0.80), (0.765, 0.90)],
        side: [(0.655, 0.920), (0.500, 0.900), (0.35, 0.880), (0.20, 0.905), (0.125, 0.875)] },
    Section { x: -0.15, sweep: 0.0,
        top: [(1.190, 0.0), (1.185, 0.22), (1.160, 0.41), (1.090, 0.545), (0.850, 0.715), (0.820, 0.80), (0.775, 0.90)],
        side: [(0.660, 0.920), (0.500, 0.895), (0.35, 0.875), (0.20, 0.905), (0.125, 0.875)] },
    Section { x: -0.50, sweep: 0.0,
        top: [(1.190, 0.0), (1.185, 0.21), (1.160, 0.40), (1.090, 0.535), (0.875, 0.72), (0.840, 0.81), (0.790, 0.905)],
        side: [(0.670, 0.925), (0.510, 0.905), (0.355, 0.885), (0.20, 0.910), (0.125, 0.88)] },
    Section { x: -0.85, sweep: 0.0,
        top: [(1.135, 0.0), (1.130, 0.20), (1.110, 0.385), (1.050, 0.52), (0.895, 0.71), (0.870, 0.825), (0.810, 0.925)],
        side: [(0.685, 0.945), (0.520, 0.930), (0.36, 0.910), (0.20, 0.920), (0.125, 0.885)] },
    Section { x: -1.15, sweep: 0.0,
        top: [(1.060, 0.0), (1.055, 0.19), (1.035, 0.37), (0.990, 0.50), (0.905, 0.70), (0.900, 0.84), (0.830, 0.945)],
        side: [(0.700, 0.965), (0.530, 0.960), (0.36, 0.940), (0.20, 0.930), (0.125, 0.89)] },
    Section { x: -1.45, sweep: 0.0,
        top: [(0.985, 0.0), (0.980, 0.19), (0.967, 0.37), (0.940, 0.50), (0.903, 0.70), (0.910, 0.845), (0.840, 0.955)],
        side: [(0.710, 0.975), (0.530, 0.975), (0.36, 0.960), (0.20, 0.935), (0.125, 0.89)] },
    Section { x: -1.75, sweep: -0.02,
        top: [(0.930, 0.0), (0.929, 0.20), (0.922, 0.38), (0.912, 0.52), (0.897, 0.70), (0.900, 0.835), (0.835, 0.94)],
        side: [(0.700, 0.960), (0.530, 0.965), (0.37, 0.950), (0.22, 0.925), (0.15, 0.88)] },
    Section { x: -2.00, sweep: -0.08,
        top: [(0.905, 0.0), (0.905, 0.20), (0.903, 0.40), (0.900, 0.54), (0.895, 0.69), (0.888, 0.81), (0.820, 0.90)],
        side: [(0.690, 0.925), (0.530, 0.930), (0.38, 0.915), (0.25, 0.890), (0.19, 0.86)] },
    Section { x: -2.14, sweep: -0.16,
        top: [(0.912, 0.0), (0.912, 0.20), (0.910, 0.40), (0.905, 0.54), (0.893, 0.68), (0.872, 0.785), (0.800, 0.86)],
        side: [(0.680, 0.885), (0.540, 0.890), (0.40, 0.875), (0.28, 0.850), (0.22, 0.82)] },
];

/// How far the rows of the front and the rear face lie ahead of their top edges.
const FRONT: [f64; SIDE] = [0.035, 0.045, 0.045, 0.04, 0.02];
const REAR: [f64; SIDE] = [0.0, -0.03, -0.03, 0.03, 0.09];

/// A place in the cage: station from the nose, row down the side (0 on top), column from the centre line.
type Node = (usize, usize, usize);

/// The cage of both halves.
fn cage() -> Cage {
    let sections = interpolated();
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

/// The sections with one more between each two, by Catmull-Rom interpolation.
fn interpolated() -> Vec<Section> {
    let at = |i: usize| &SECTIONS[i.min(SECTIONS.len() - 1)];
    let mut sections = Vec::new();
    for i in 0..SECTIONS.len() {
        let blend = |weights: [f64; 4]| {
            let four = [at(i.saturating_sub(1)), at(i), at(i + 1), at(i + 2)];
            let mix = |value: &dyn Fn(&Section) -> f64| {
                four.iter().zip(weights).map(|(section, weight)| value(section) * weight).sum::<f64>()
            };
            Section {
                x: mix(&|s| s.x),
                sweep: mix(&|s| s.sweep),
                top: std::array::from_fn(|k| (mix(&|s| s.top[k].0), mix(&|s| s.top[k].1))),
                side: std::array::from_fn(|k| (mix(&|s| s.side[k].0), mix(&|s| s.side[k].1))),
            }
        };
        sections.push(blend([0.0, 1.0, 0.0, 0.0]));
        if i + 1 < SECTIONS.len() {
            sections.push(blend([-0.0625, 0.5625, 0.5625, -0.0625]));
        }
    }
    sections
}

/// Where a node lies.
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

/// Texture coordinates in metres by one skewed projection, nowhere degenerate on this body and without seams.
pub fn texture_place(p: DVec3) -> DVec2 {
    DVec2::new(p.x * (1.0 - 0.35 * p.y), p.z.abs() - p.y)
}
