//! Headlights and tail lights.

use glam::{DMat3, DVec2, DVec3};

use super::super::cut::{Cut, Offset, Region, cut};
use super::super::mesh::Mesh;
use super::super::revolve::{revolve, rounded};
use super::super::sweep::{Ends, Station, section, sweep};
use super::body;
use super::materials::Stuff;
use super::panels;
use super::probe::{Place, Probe};

/// Parts with their materials.
type Parts = Vec<(usize, Mesh)>;

/// The right headlight: projectors, a light guide and the cover.
pub fn headlight(probe: &Probe) -> Parts {
    let mut parts = Parts::new();
    for (x, z, radius) in
        [(1.915, 0.672, 0.020), (1.858, 0.722, 0.022), (1.795, 0.766, 0.020), (1.728, 0.806, 0.017)]
    {
        let place = probe.top(x, z);
        parts.extend(projector(place.inside(0.048), radius));
    }
    let guide: Vec<Place> =
        [(1.955, 0.640), (1.920, 0.692), (1.865, 0.742), (1.795, 0.788), (1.72, 0.826), (1.655, 0.853)]
            .iter()
            .map(|&(x, z)| probe.top(x, z))
            .collect();
    parts.push((Stuff::Lamp as usize, strip(&smooth(&guide), 0.014, 0.005, 0.004)));
    parts.push((Stuff::Cover as usize, cover()));
    parts
}

/// A lens in a bright ring that looks ahead.
fn projector(centre: DVec3, radius: f64) -> Parts {
    let ahead = DVec3::new(0.92, 0.16, 0.28).normalize();
    let across = ahead.cross(DVec3::Y).normalize();
    let map = DMat3::from_cols(across, ahead, across.cross(ahead));
    let turned = |corners: &[(f64, f64, f64)], sides| {
        let corners: Vec<_> = corners
            .iter()
            .map(|&(r, y, round)| (DVec2::new(r * radius, y * radius), round * radius))
            .collect();
        revolve(&rounded(&corners, 1), sides).transformed(map).translated(centre)
    };
    let ring = turned(
        &[
            (0.8, -0.6, 0.0),
            (1.2, -0.6, 0.1),
            (1.2, 0.5, 0.1),
            (1.08, 0.75, 0.1),
            (0.92, 0.5, 0.05),
            (0.8, 0.1, 0.0),
            (0.8, -0.6, 0.0),
        ],
        16,
    );
    let lens = turned(
        &[(0.0, -0.4, 0.0), (0.86, -0.4, 0.1), (0.86, 0.25, 0.5), (0.45, 0.62, 0.6), (0.0, 0.66, 0.0)],
        16,
    );
    vec![(Stuff::Chrome as usize, ring), (Stuff::Lamp as usize, lens)]
}

/// The skin over the lamp, as a thin clear shell.
fn cover() -> Mesh {
    let cuts =
        [Cut { curve: panels::headlight(), half_width: 0.0, detail: 1.0, rim: 0.0, gap: 0, inside: Some(1) }];
    let region = |offset, back| Region { offset, output: 0, walls: 0, rounding: 0.0, back };
    let regions = [region(Offset::Open(0.006), None), region(Offset::In(0.0035), Some(0))];
    cut(body::right_half(), &cuts, &regions, 1).remove(0).compact()
}

/// More places between places, by Catmull-Rom interpolation.
pub fn smooth(places: &[Place]) -> Vec<Place> {
    const STEPS: usize = 3;
    let at = |i: usize| places[i.min(places.len() - 1)];
    let mut out = Vec::new();
    for i in 0..places.len() - 1 {
        for step in 0..STEPS {
            let t = step as f64 / STEPS as f64;
            let mix = |f: fn(Place) -> DVec3| {
                let [a, b, c, d] = [at(i.saturating_sub(1)), at(i), at(i + 1), at(i + 2)].map(f);
                b + (c - a) * (0.5 * t)
                    + (a * 2.0 - b * 5.0 + c * 4.0 - d) * (0.5 * t * t)
                    + ((b - c) * 3.0 + d - a) * (0.5 * t * t * t)
            };
            out.push(Place { position: mix(|p| p.position), normal: mix(|p| p.normal).normalize() });
        }
    }
    out.push(at(places.len() - 1));
    out
}

/// A bar along places, `depth` below the skin: half height across, half thickness along the normal.
pub fn strip(places: &[Place], depth: f64, half_height: f64, half_thickness: f64) -> Mesh {
    let last = places.len() - 1;
    let stations: Vec<Station> = (0..=last)
        .map(|i| {
            let forward = places[(i + 1).min(last)].position - places[i.saturating_sub(1)].position;
            let across = places[i].normal.cross(forward).normalize();
            let up = forward.cross(across).normalize();
            Station { centre: places[i].inside(depth), across: across * half_height, up: up * half_thickness }
        })
        .collect();
    sweep(&stations, &section(6, 0.45), Ends::Capped)
}

/// Both tail lights and the bar between them, right across the rear.
pub fn tail_lights(probe: &Probe) -> Parts {
    let line = |y: f64, from: f64, to: f64, count: u32| -> Vec<Place> {
        (0..=count).map(|i| probe.rear(from + (to - from) * f64::from(i) / f64::from(count), y)).collect()
    };
    let mut parts =
        vec![(Stuff::TailLight as usize, strip(&line(0.765, -0.74, 0.74, 32), 0.010, 0.013, 0.010))];
    for side in [-1.0, 1.0] {
        let lower = line(0.722, 0.42 * side, 0.735 * side, 8);
        parts.push((Stuff::TailLight as usize, strip(&lower, 0.010, 0.010, 0.010)));
    }
    parts
}
