//! The simple models: material ball, torus knot, vase, cloth, cube and text plate.

use glam::{DMat3, DVec2, DVec3};

use super::angle;
use super::cloth;
use super::cut::{Cut, Offset, Region, cut};
use super::letters;
use super::mesh::{Mesh, Vertex};
use super::model::{Material, Model};
use super::revolve::{revolve, rounded};
use super::solid::rounded_box;
use super::sweep::{Ends, Station, section, sweep};

/// A profile from (radius, height, corner radius).
fn profile(corners: &[(f64, f64, f64)], steps: u32) -> Vec<DVec2> {
    let corners: Vec<_> = corners.iter().map(|&(r, y, round)| (DVec2::new(r, y), round)).collect();
    rounded(&corners, steps)
}

/// A rotation about the x axis.
fn about_x(turns: f64) -> DMat3 {
    let direction = angle::unit(turns);
    DMat3::from_cols(
        DVec3::X,
        DVec3::new(0.0, direction.x, direction.y),
        DVec3::new(0.0, -direction.y, direction.x),
    )
}

/// A coated ball with a groove and a window onto an inner ball, on a stand.
pub fn material_ball() -> Model {
    const RADIUS: f64 = 0.5;
    let on_ball = |turns: f64, radius: f64| angle::unit(turns) * radius;
    let mut shell: Vec<DVec2> = Vec::new();
    // From the bottom up to the groove, down its walls, and on to the window's rim.
    let arc = |shell: &mut Vec<DVec2>, from: f64, to: f64| {
        const STEPS: u32 = 28;
        for step in 0..=STEPS {
            shell.push(on_ball(from + (to - from) * f64::from(step) / f64::from(STEPS), RADIUS));
        }
    };
    let notch = |turns: f64| (on_ball(turns, RADIUS), on_ball(turns, RADIUS - 0.03));
    arc(&mut shell, -0.25, -0.016);
    let (low, high) = (notch(-0.012), notch(-0.002));
    let edge = |a: f64, b: f64, r: f64| on_ball(a + b, RADIUS - r);
    shell.extend([edge(-0.016, 0.0025, 0.003), low.1, high.1, edge(0.002, -0.0025, 0.003)]);
    arc(&mut shell, 0.002, 0.128);
    let rim = [(0.1295, 0.001), (0.1308, 0.004), (0.1315, 0.009), (0.1315, 0.05), (0.1315, 0.085)];
    shell.extend(rim.map(|(turns, depth)| on_ball(turns, RADIUS - depth)));
    // The bowl's bottom lies hidden inside the core and closes the shell.
    let bottom = shell[shell.len() - 1].y;
    shell.push(DVec2::new(0.0, bottom));
    shell[0].x = 0.0;
    let mut core: Vec<DVec2> =
        (0..=32).map(|step| on_ball(-0.25 + 0.5 * f64::from(step) / 32.0, RADIUS * 0.86)).collect();
    core[0].x = 0.0;
    core[32].x = 0.0;
    let tilt = about_x(0.125);
    let centre = DVec3::new(0.0, 0.66, 0.0);
    let placed = |mesh: Mesh| mesh.transformed(tilt).translated(centre);
    let stand = revolve(
        &profile(
            &[
                (0.0, 0.0, 0.0),
                (0.47, 0.0, 0.02),
                (0.47, 0.07, 0.025),
                (0.33, 0.10, 0.03),
                (0.27, 0.215, 0.03),
                (0.0, 0.235, 0.0),
            ],
            6,
        ),
        72,
    );
    let ring = revolve(
        &profile(
            &[
                (0.30, 0.09, 0.0),
                (0.415, 0.06, 0.01),
                (0.425, 0.10, 0.012),
                (0.36, 0.115, 0.01),
                (0.30, 0.11, 0.0),
                (0.30, 0.09, 0.0),
            ],
            4,
        ),
        72,
    );
    let flakes = Material {
        normal_map: Some("flakes-normal"),
        normal_scale: 0.6,
        ..Material::plain("paint", [0.55, 0.02, 0.03], 0.6, 0.38).coated(0.03)
    };
    let brushed = Material {
        roughness_map: Some("brushed-roughness"),
        ..Material::plain("brushed", [0.75, 0.72, 0.68], 1.0, 1.0)
    };
    Model::single(
        "material-ball",
        vec![
            flakes,
            Material::plain("core", [0.04, 0.045, 0.05], 0.0, 0.22).coated(0.03),
            Material::plain("stand", [0.06, 0.06, 0.065], 0.0, 0.5),
            brushed,
        ],
        vec![
            (0, placed(revolve(&shell, 96)).mapped(|v| v.uv * DVec2::new(12.0, 4.0))),
            (1, placed(revolve(&core, 64))),
            (2, stand),
            (3, ring.mapped(|v| v.uv * DVec2::new(3.0, 4.0))),
        ],
    )
}

/// The (2, 3) torus knot, in coated carbon.
pub fn torus_knot() -> Model {
    const STEPS: u32 = 180;
    let point = |turns: f64| {
        let (around, twist) = (angle::unit(2.0 * turns), angle::unit(3.0 * turns));
        let radius = 0.62 + 0.28 * twist.x;
        DVec3::new(radius * around.x, 0.28 * twist.y, radius * around.y)
    };
    let stations: Vec<Station> = (0..STEPS)
        .map(|i| {
            let turns = f64::from(i) / f64::from(STEPS);
            let centre = point(turns);
            let forward = (point(turns + 1e-4) - point(turns - 1e-4)).normalize();
            // The direction away from the torus's core circle is periodic and never along the path.
            let around = angle::unit(2.0 * turns);
            let away = centre - DVec3::new(around.x, 0.0, around.y) * 0.62;
            let up = (away - forward * away.dot(forward)).normalize();
            Station { centre, across: up.cross(forward) * 0.13, up: up * 0.13 }
        })
        .collect();
    let tube = sweep(&stations, &section(28, 1.0), Ends::Joined)
        .mapped(|v| v.uv * DVec2::new(2.0, 2.4))
        .transformed(about_x(0.25))
        .translated(DVec3::new(0.0, 1.04, 0.0));
    let carbon = Material {
        color_map: Some("carbon-color"),
        normal_map: Some("carbon-normal"),
        ..Material::plain("carbon", [1.0, 1.0, 1.0], 0.2, 0.45).coated(0.03)
    };
    Model::single("torus-knot", vec![carbon], vec![(0, tube)])
}

/// A glazed vase with a wall, inside and outside.
pub fn vase() -> Model {
    // (height, radius) of the outside; a cubic through them.
    const OUTSIDE: [(f64, f64); 9] = [
        (0.03, 0.165),
        (0.10, 0.215),
        (0.22, 0.262),
        (0.36, 0.270),
        (0.50, 0.225),
        (0.62, 0.150),
        (0.72, 0.105),
        (0.80, 0.108),
        (0.87, 0.150),
    ];
    const WALL: f64 = 0.014;
    let curve: Vec<DVec2> = (0..(OUTSIDE.len() - 1) * 6 + 1)
        .map(|i| {
            let at = |k: usize| {
                let (y, r) = OUTSIDE[k.min(OUTSIDE.len() - 1)];
                DVec2::new(r, y)
            };
            let (k, t) = (i / 6, (i % 6) as f64 / 6.0);
            let [a, b, c, d] = [at(k.saturating_sub(1)), at(k), at(k + 1), at(k + 2)];
            b + (c - a) * (0.5 * t)
                + (a * 2.0 - b * 5.0 + c * 4.0 - d) * (0.5 * t * t)
                + ((b - c) * 3.0 + d - a) * (0.5 * t * t * t)
        })
        .collect();
    let foot = profile(
        &[
            (0.0, 0.012, 0.0),
            (0.115, 0.012, 0.0),
            (0.13, 0.0, 0.004),
            (0.155, 0.0, 0.008),
            (0.165, 0.03, 0.0),
        ],
        4,
    );
    let lip = curve[curve.len() - 1];
    let mut glazed = curve.clone();
    let normal_at = |i: usize| {
        let last = curve.len() - 1;
        let along = curve[(i + 1).min(last)] - curve[i.saturating_sub(1)];
        DVec2::new(along.y, -along.x).normalize()
    };
    let inside: Vec<DVec2> = (1..curve.len()).rev().map(|i| curve[i] - normal_at(i) * WALL).collect();
    // A half circle over the lip.
    let (across, upward) = (normal_at(curve.len() - 1), (inside[0] - lip).perp().normalize() * -1.0);
    for step in 1..8 {
        let direction = angle::unit(0.5 * f64::from(step) / 8.0);
        let middle = lip - across * (0.5 * WALL);
        glazed.push(middle + (across * direction.x + upward * direction.y) * (0.5 * WALL));
    }
    glazed.extend(inside);
    glazed.push(DVec2::new(0.0, 0.035));
    let glaze = Material {
        normal_map: Some("scratches-normal"),
        normal_scale: 0.12,
        ..Material::plain("glaze", [0.02, 0.16, 0.22], 0.0, 0.5).coated(0.05)
    };
    let bare = Material::plain("clay", [0.42, 0.2, 0.11], 0.0, 0.85);
    Model::single(
        "vase",
        vec![glaze, bare],
        vec![(0, revolve(&glazed, 72).mapped(|v| v.uv * DVec2::new(3.0, 2.0))), (1, revolve(&foot, 72))],
    )
}

/// A cloth over a ball.
pub fn cloth() -> Model {
    let (centre, radius) = cloth::BALL;
    let mut arc: Vec<DVec2> =
        (0..=24).map(|i| angle::unit(-0.25 + 0.5 * f64::from(i) / 24.0) * radius).collect();
    arc[0].x = 0.0;
    arc[24].x = 0.0;
    let checked =
        Material { color_map: Some("checker"), ..Material::plain("cloth", [0.75, 0.22, 0.12], 0.0, 0.9) };
    Model::single(
        "draped-cloth",
        vec![checked, Material::plain("ball", [0.5, 0.5, 0.5], 0.0, 0.4)],
        vec![(0, cloth::draped()), (1, revolve(&arc, 48).translated(centre))],
    )
}

/// A cube with rounded edges: scratched lacquer faces, polished edges.
pub fn rounded_cube() -> Model {
    const HALF: f64 = 0.5;
    const RADIUS: f64 = 0.07;
    let whole = rounded_box(DVec3::splat(HALF), RADIUS, 6).translated(DVec3::new(0.0, HALF, 0.0));
    let mut faces = Mesh { vertices: whole.vertices.clone(), triangles: Vec::new() };
    let mut edges = faces.clone();
    for triangle in &whole.triangles {
        // On a flat face all three normals agree.
        let [a, b, c] = triangle.map(|i| whole.vertices[i as usize].normal);
        let flat = a.dot(b) > 0.999_999 && a.dot(c) > 0.999_999;
        if flat { &mut faces } else { &mut edges }.triangles.push(*triangle);
    }
    let lacquer = Material {
        coat_roughness_map: Some("scratches-roughness"),
        coat_normal_map: Some("scratches-normal"),
        ..Material::plain("lacquer", [0.03, 0.09, 0.3], 0.0, 0.5).coated(1.0)
    };
    let steel = Material::plain("steel", [0.78, 0.77, 0.75], 1.0, 0.18);
    Model::single("rounded-cube", vec![lacquer, steel], vec![(0, faces.compact()), (1, edges.compact())])
}

/// A brushed plate with raised letters.
pub fn text_plate() -> Model {
    const HALF: DVec2 = DVec2::new(1.5, 0.4);
    const STROKE: f64 = 0.036;
    const SIZE: f64 = 0.24;
    const BACK: f64 = -0.06;
    let strokes: Vec<Vec<DVec2>> = letters::word("overcoat")
        .iter()
        .map(|stroke| stroke.iter().map(|p| *p * SIZE - DVec2::new(0.0, 0.5 * SIZE)).collect())
        .collect();
    let (rows, columns) = (28, 104);
    let face = Mesh::grid(rows + 1, columns + 1, |row, column| {
        let u = column as f64 / columns as f64;
        let v = row as f64 / rows as f64;
        let position = DVec3::new((2.0 * u - 1.0) * HALF.x, (1.0 - 2.0 * v) * HALF.y, 0.0);
        Vertex { position, normal: DVec3::Z, uv: DVec2::new(u * 3.0, v) }
    });
    let cuts = [Cut {
        curve: Box::new(move |p, _| letters::distance(&strokes, STROKE, p.truncate()).value),
        half_width: 0.0,
        detail: 1.0,
        rim: 0.01,
        gap: 0,
        inside: Some(1),
    }];
    let regions = [
        Region { offset: Offset::In(0.0), output: 0, walls: 0, rounding: 0.004, back: None },
        Region { offset: Offset::In(-0.035), output: 1, walls: 1, rounding: 0.004, back: None },
    ];
    let mut parts = cut(face, &cuts, &regions, 2);
    parts[0].append(&backing(HALF, rows, columns, BACK));
    let upright = |mesh: Mesh| mesh.transformed(about_x(-0.03)).translated(DVec3::new(0.0, 0.42, 0.0));
    let letters = upright(parts.remove(1));
    let plate = upright(parts.remove(0));
    let brushed = Material {
        roughness_map: Some("brushed-roughness"),
        ..Material::plain("plate", [0.32, 0.33, 0.35], 1.0, 1.0)
    };
    let paint = Material::plain("letters", [0.75, 0.16, 0.02], 0.0, 0.45).coated(0.03);
    Model::single("text-plate", vec![brushed, paint], vec![(0, plate), (1, letters)])
}

/// The sides and the back of the plate; the sides share the face's vertices along its rim.
fn backing(half: DVec2, rows: usize, columns: usize, back: f64) -> Mesh {
    let mut mesh = Mesh::default();
    let u = |i: usize| (2.0 * (i as f64 / columns as f64) - 1.0) * half.x;
    let v = |i: usize| (1.0 - 2.0 * (i as f64 / rows as f64)) * half.y;
    let mut side = |points: Vec<DVec2>, normal: DVec3| {
        mesh.append(&Mesh::grid(2, points.len(), |row, i| Vertex {
            position: points[i].extend(if row == 0 { 0.0 } else { back }),
            normal,
            uv: DVec2::new(i as f64 * 0.1, row as f64 * 0.1),
        }));
    };
    side((0..=columns).map(|i| DVec2::new(u(i), -half.y)).collect(), DVec3::NEG_Y);
    side((0..=columns).rev().map(|i| DVec2::new(u(i), half.y)).collect(), DVec3::Y);
    side((0..=rows).rev().map(|i| DVec2::new(half.x, v(i))).collect(), DVec3::X);
    side((0..=rows).map(|i| DVec2::new(-half.x, v(i))).collect(), DVec3::NEG_X);
    mesh.append(&Mesh::grid(rows + 1, columns + 1, |row, column| Vertex {
        position: DVec3::new(u(columns - column), v(row), back),
        normal: DVec3::NEG_Z,
        uv: DVec2::new(column as f64 * 0.03, row as f64 * 0.03),
    }));
    mesh
}
