//! Cuts the skin into panels, windows, lamps and openings.

use std::collections::BTreeMap;

use glam::{DVec2, DVec3};

use super::super::cut::{Curve, Cut, Offset, Region, along_surface, cut};
use super::super::mesh::{Mesh, Vertex, key};
use super::super::outline::Outline;
use super::body;
use super::materials::{COUNT, Stuff};

/// Wheels: (x of the axle, tyre radius, radius of the arch).
pub const FRONT_WHEEL: (f64, f64, f64) = (1.30, 0.345, 0.375);
/// As [`FRONT_WHEEL`].
pub const REAR_WHEEL: (f64, f64, f64) = (-1.30, 0.355, 0.388);

/// Longest edges near small, middling and large outlines.
const FINE: f64 = 0.026;
const MEDIUM: f64 = 0.035;
const COARSE: f64 = 0.12;
/// Width of the rounded rim of every panel.
const RIM: f64 = 0.005;

/// Regions of the skin. What no cut claims is paint, region 0.
#[derive(Clone, Copy)]
enum Part {
    #[allow(dead_code, reason = "the region that everything starts in")]
    Paint,
    Gap,
    Glass,
    Seal,
    Well,
    Grille,
    Lamp,
    TailPanel,
    Carbon,
    Intake,
}

/// In the order of [`Part`].
fn regions() -> Vec<Region> {
    let region = |offset, output: Stuff| Region {
        offset,
        output: output as usize,
        walls: Stuff::Void as usize,
        rounding: if matches!(output, Stuff::Paint | Stuff::Carbon) { 0.002 } else { 0.0 },
        back: None,
    };
    vec![
        region(Offset::In(0.0), Stuff::Paint),
        region(Offset::In(0.014), Stuff::Void),
        region(Offset::In(0.003), Stuff::Glass),
        region(Offset::In(0.006), Stuff::Trim),
        region(Offset::Flat(2, 0.665), Stuff::Void),
        region(Offset::In(0.12), Stuff::Void),
        region(Offset::In(0.055), Stuff::Housing),
        region(Offset::In(0.02), Stuff::Void),
        region(Offset::In(0.004), Stuff::Carbon),
        region(Offset::In(0.10), Stuff::Void),
    ]
}

/// Direction in which a curve is projected onto the skin.
#[derive(Clone, Copy)]
enum View {
    /// (x, y), where z is larger than a bound.
    Side(f64),
    /// (x, z), where y is larger than a bound.
    Top(f64),
    /// (z, y), where x is larger than a bound.
    Front(f64),
    /// (z, y), where x is smaller than a bound.
    Rear(f64),
}

/// A curve on the skin.
fn projected(outline: Outline, view: View) -> Curve {
    Box::new(move |p: DVec3, normal: DVec3| {
        let (point, seen) = match view {
            View::Side(bound) => (DVec2::new(p.x, p.y), p.z > bound),
            View::Top(bound) => (DVec2::new(p.x, p.z), p.y > bound),
            View::Front(bound) => (DVec2::new(p.z, p.y), p.x > bound),
            View::Rear(bound) => (DVec2::new(p.z, p.y), p.x < bound),
        };
        let distance = outline.distance(point);
        let g = distance.gradient;
        let gradient = match view {
            View::Side(_) => DVec3::new(g.x, g.y, 0.0),
            View::Top(_) => DVec3::new(g.x, 0.0, g.y),
            View::Front(_) | View::Rear(_) => DVec3::new(0.0, g.y, g.x),
        };
        let value = along_surface(distance.value, gradient, normal);
        if seen { value } else { value.abs() + 1.0 }
    })
}

/// A wheel arch: round above the axle, straight below.
fn arch((x, axle, radius): (f64, f64, f64)) -> Curve {
    Box::new(move |p: DVec3, normal: DVec3| {
        let offset = DVec2::new(p.x - x, if p.y > axle { p.y - axle } else { 0.0 });
        let g = offset.normalize_or_zero();
        let value = along_surface(offset.length() - radius, DVec3::new(g.x, g.y, 0.0), normal);
        if p.z > 0.72 { value } else { value.abs() + 1.0 }
    })
}

/// The line below which the body is carbon: along the sill, higher across the rear.
fn carbon_edge() -> Curve {
    Box::new(|p: DVec3, normal: DVec3| {
        let rear = ((-1.72 - p.x) / 0.12).clamp(0.0, 1.0);
        let height = 0.172 + 0.248 * rear * rear * (3.0 - 2.0 * rear);
        along_surface(p.y - height, DVec3::Y, normal)
    })
}

/// A shut line around a panel.
fn seam(outline: Outline, view: View) -> Cut {
    Cut {
        curve: projected(outline, view),
        half_width: 0.0035,
        detail: COARSE,
        rim: RIM,
        gap: Part::Gap as usize,
        inside: None,
    }
}

/// A window in its seal.
fn window(outline: Outline, view: View) -> Cut {
    Cut {
        curve: projected(outline, view),
        half_width: 0.011,
        detail: 0.07,
        rim: RIM,
        gap: Part::Seal as usize,
        inside: Some(Part::Glass as usize),
    }
}

/// A region with a sharp border.
fn opening(curve: Curve, part: Part) -> Cut {
    Cut {
        curve,
        half_width: 0.0,
        detail: MEDIUM,
        rim: RIM,
        gap: Part::Gap as usize,
        inside: Some(part as usize),
    }
}

/// A curve that is symmetrical about the centre line, from its right half (first coordinate z, or second for tops).
fn symmetric(half: &[(f64, f64)], radius: f64, across_first: bool) -> Outline {
    let mut points = half.to_vec();
    let off_centre = half.iter().rev().filter(|&&(a, b)| if across_first { a } else { b } != 0.0);
    points.extend(off_centre.map(|&(a, b)| if across_first { (-a, b) } else { (a, -b) }));
    let corners: Vec<_> = points.iter().map(|&(a, b)| (a, b, radius)).collect();
    Outline::rounded(&corners)
}

/// Outline of the headlight seen from above, also used for its cover.
pub fn headlight() -> Curve {
    projected(
        Outline::through(&[
            (1.978, 0.615),
            (1.930, 0.707),
            (1.835, 0.785),
            (1.725, 0.842),
            (1.640, 0.872),
            (1.632, 0.856),
            (1.70, 0.812),
            (1.795, 0.735),
            (1.885, 0.640),
        ]),
        View::Top(0.40),
    )
}

/// The panels of the right half, one mesh for each [`Stuff`].
pub fn right_half() -> Vec<Mesh> {
    let door = Outline::rounded(&[
        (0.76, 0.228, 0.10),
        (0.83, 0.50, 0.25),
        (0.80, 0.74, 0.14),
        (0.55, 0.86, 0.02),
        (-0.40, 0.93, 0.02),
        (-0.60, 0.84, 0.05),
        (-0.56, 0.55, 0.3),
        (-0.42, 0.228, 0.10),
    ]);
    let side_window = Outline::rounded(&[
        (0.655, 0.828, 0.05),
        (0.42, 0.906, 0.15),
        (0.12, 1.008, 0.2),
        (-0.25, 1.055, 0.3),
        (-0.62, 1.028, 0.2),
        (-1.03, 0.937, 0.08),
        (-0.80, 0.908, 0.1),
        (-0.20, 0.875, 0.4),
    ]);
    let bonnet = symmetric(
        &[(1.95, 0.0), (1.93, 0.25), (1.84, 0.48), (1.45, 0.62), (1.05, 0.66), (0.80, 0.68), (0.80, 0.0)],
        0.12,
        false,
    );
    let vent =
        Outline::rounded(&[(1.56, 0.28, 0.02), (1.50, 0.45, 0.03), (1.44, 0.465, 0.02), (1.49, 0.29, 0.02)]);
    let windscreen = symmetric(
        &[(0.91, 0.0), (0.88, 0.30), (0.79, 0.545), (0.40, 0.505), (0.13, 0.415), (0.15, 0.0)],
        0.05,
        false,
    );
    let rear_window =
        symmetric(&[(-0.70, 0.0), (-0.70, 0.34), (-1.05, 0.36), (-1.34, 0.35), (-1.36, 0.0)], 0.10, false);
    let louvre =
        |x: f64| symmetric(&[(x, 0.0), (x, 0.33), (x - 0.045, 0.335), (x - 0.045, 0.0)], 0.05, false);
    let grille =
        symmetric(&[(0.0, 0.345), (0.42, 0.345), (0.535, 0.325), (0.47, 0.19), (0.0, 0.19)], 0.05, true);
    let side_grille =
        Outline::rounded(&[(0.60, 0.335, 0.03), (0.82, 0.35, 0.03), (0.84, 0.25, 0.03), (0.59, 0.195, 0.03)]);
    let tail_panel = symmetric(
        &[(0.0, 0.795), (0.60, 0.79), (0.775, 0.775), (0.765, 0.71), (0.60, 0.685), (0.0, 0.685)],
        0.05,
        true,
    );
    let intake = Outline::rounded(&[
        (-0.66, 0.36, 0.05),
        (-0.74, 0.66, 0.05),
        (-0.92, 0.70, 0.03),
        (-0.84, 0.45, 0.1),
    ]);
    let exhausts =
        symmetric(&[(0.0, 0.41), (0.26, 0.41), (0.31, 0.385), (0.28, 0.30), (0.0, 0.30)], 0.05, true);
    let rear_vent =
        Outline::rounded(&[(0.56, 0.52, 0.03), (0.80, 0.57, 0.03), (0.80, 0.47, 0.03), (0.60, 0.455, 0.02)]);
    let rear_bumper = Outline::rounded(&[
        (-1.74, 0.60, 0.03),
        (-1.90, 0.645, 0.05),
        (-2.4, 0.655, 0.0),
        (-2.4, 0.0, 0.0),
        (-1.5, 0.0, 0.0),
        (-1.5, 0.50, 0.0),
    ]);
    let cuts = vec![
        Cut { detail: 0.07, ..seam(bonnet, View::Top(0.40)) },
        seam(door, View::Side(0.5)),
        seam(rear_bumper, View::Side(-1.0)),
        Cut { detail: COARSE, ..opening(carbon_edge(), Part::Carbon) },
        window(windscreen, View::Top(0.7)),
        window(side_window, View::Side(0.45)),
        window(rear_window, View::Top(0.7)),
        Cut { detail: FINE, ..opening(projected(louvre(-1.44), View::Top(0.7)), Part::Intake) },
        Cut { detail: FINE, ..opening(projected(louvre(-1.53), View::Top(0.7)), Part::Intake) },
        Cut { detail: FINE, ..opening(projected(louvre(-1.62), View::Top(0.7)), Part::Intake) },
        Cut { detail: FINE, ..opening(projected(vent, View::Top(0.5)), Part::Intake) },
        Cut { detail: 0.015, ..opening(headlight(), Part::Lamp) },
        Cut { detail: COARSE, ..opening(projected(grille, View::Front(1.7)), Part::Grille) },
        opening(projected(side_grille, View::Front(1.6)), Part::Grille),
        Cut { detail: FINE, ..opening(projected(tail_panel, View::Rear(-1.9)), Part::TailPanel) },
        opening(projected(exhausts, View::Rear(-1.9)), Part::Intake),
        opening(projected(rear_vent, View::Rear(-1.8)), Part::Intake),
        opening(projected(intake, View::Side(0.5)), Part::Intake),
        Cut { detail: COARSE, ..opening(arch(FRONT_WHEEL), Part::Well) },
        Cut { detail: COARSE, ..opening(arch(REAR_WHEEL), Part::Well) },
    ];
    let mut parts = cut(body::right_half(), &cuts, &regions(), COUNT);
    let floor = floor(&parts);
    parts[Stuff::Void as usize].append(&floor);
    // A finer weave than the paint's flakes ask for.
    for vertex in &mut parts[Stuff::Carbon as usize].vertices {
        vertex.uv *= 1.75;
    }
    parts
}

/// The right half of the floor: a strip from every open edge to the centre line.
fn floor(parts: &[Mesh]) -> Mesh {
    let mut open: BTreeMap<([u64; 3], [u64; 3]), (DVec3, DVec3)> = BTreeMap::new();
    for mesh in parts {
        for triangle in &mesh.triangles {
            for corner in 0..3 {
                let [a, b] = [corner, (corner + 1) % 3].map(|c| mesh.vertices[triangle[c] as usize].position);
                if open.remove(&(key(b), key(a))).is_none() {
                    open.insert((key(a), key(b)), (a, b));
                }
            }
        }
    }
    let mut mesh = Mesh::default();
    for (a, b) in open.into_values().filter(|(a, b)| a.z != 0.0 || b.z != 0.0) {
        let centre = |p: DVec3| DVec3::new(p.x, p.y, 0.0);
        let corners = [b, a, centre(a), centre(b)].map(|p| mesh.push(Vertex::new(p, DVec3::NEG_Y)));
        mesh.quad(corners[0], corners[1], corners[2], corners[3]);
    }
    mesh
}
