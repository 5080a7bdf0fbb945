//! A square of cloth that falls over a ball on a floor: position-based dynamics (Müller et al. 2007).

use glam::{DVec2, DVec3};

use super::mesh::{Mesh, Vertex};

/// Points a side.
const SIDE: usize = 65;
/// Metres a side.
const WIDTH: f64 = 2.6;
/// Steps of simulated time, and constraint passes in each.
const STEPS: u32 = 260;
const PASSES: u32 = 12;
/// Seconds of a step, and the share of velocity that a step keeps.
const STEP: f64 = 1.0 / 60.0;
const KEEP: f64 = 0.985;

/// The obstacle: a ball.
pub const BALL: (DVec3, f64) = (DVec3::new(0.0, 0.62, 0.0), 0.6);
/// Half the thickness of the cloth, also its distance from what it lies on.
const SKIN: f64 = 0.012;

/// The cloth at rest, a closed sheet with two sides.
pub fn draped() -> Mesh {
    let points = fall();
    let normals = normals(&points);
    let at = |row: usize, column: usize| row * SIDE + column;
    let uv = |row: usize, column: usize| DVec2::new(column as f64, row as f64) / (SIDE - 1) as f64 * 4.0;
    let side = |sign: f64| {
        Mesh::grid(SIDE, SIDE, |row, column| {
            let normal = normals[at(row, column)];
            Vertex {
                position: points[at(row, column)] + normal * (SKIN * 0.5 * sign),
                normal: normal * sign,
                uv: uv(row, column),
            }
        })
    };
    let mut mesh = side(1.0);
    let mut below = side(-1.0);
    for triangle in &mut below.triangles {
        triangle.swap(1, 2);
    }
    mesh.append(&below);
    mesh.append(&hem(&mesh));
    mesh
}

/// The narrow strip that closes the rim.
fn hem(sheet: &Mesh) -> Mesh {
    let last = SIDE - 1;
    // Counter-clockwise around the sheet seen from above.
    let mut rim: Vec<usize> = (0..last).map(|i| i * SIDE).collect();
    rim.extend((0..last).map(|i| last * SIDE + i));
    rim.extend((0..last).map(|i| (last - i) * SIDE + last));
    rim.extend((0..last).map(|i| last - i));
    let count = rim.len();
    Mesh::grid(2, count + 1, |row, column| {
        let vertex = sheet.vertices[rim[column % count] + row * SIDE * SIDE];
        let [before, after] = [column + count - 1, column + 1].map(|i| sheet.vertices[rim[i % count]]);
        let normal = (after.position - before.position)
            .cross(sheet.vertices[rim[column % count]].normal)
            .normalize_or_zero();
        Vertex { normal, ..vertex }
    })
}

/// Area-weighted normals of the grid.
fn normals(points: &[DVec3]) -> Vec<DVec3> {
    let at = |row: usize, column: usize| points[row.min(SIDE - 1) * SIDE + column.min(SIDE - 1)];
    (0..SIDE * SIDE)
        .map(|i| {
            let (row, column) = (i / SIDE, i % SIDE);
            let right = at(row, column + 1) - at(row, column.saturating_sub(1));
            let down = at(row + 1, column) - at(row.saturating_sub(1), column);
            down.cross(right).normalize_or_zero()
        })
        .collect()
}

/// Lets the cloth fall and settle.
fn fall() -> Vec<DVec3> {
    let spacing = WIDTH / (SIDE - 1) as f64;
    let mut points: Vec<DVec3> = (0..SIDE * SIDE)
        .map(|i| {
            let (row, column) = ((i / SIDE) as f64, (i % SIDE) as f64);
            // A little off centre and turned, so that no two folds are alike.
            let (x, z) = (column * spacing - 0.5 * WIDTH, row * spacing - 0.5 * WIDTH);
            DVec3::new(x * 0.96 - z * 0.28 + 0.03, 1.27, z * 0.96 + x * 0.28 - 0.02)
        })
        .collect();
    let links = links(spacing);
    let mut velocities = vec![DVec3::ZERO; points.len()];
    for _ in 0..STEPS {
        let before = points.clone();
        for (point, velocity) in points.iter_mut().zip(&mut velocities) {
            velocity.y -= 9.81 * STEP;
            *point += *velocity * STEP;
        }
        for _ in 0..PASSES {
            for &(a, b, length, stiffness) in &links {
                let offset = points[b] - points[a];
                let now = offset.length();
                let push = offset * (0.5 * stiffness * (now - length) / now);
                points[a] += push;
                points[b] -= push;
            }
            for (point, before) in points.iter_mut().zip(&before) {
                collide(point, *before);
            }
        }
        for ((velocity, point), before) in velocities.iter_mut().zip(&points).zip(&before) {
            *velocity = (*point - *before) * (KEEP / STEP);
        }
    }
    points
}

/// Pairs with rest lengths and stiffness: along the threads, across them (shear) and over two (bending).
fn links(spacing: f64) -> Vec<(usize, usize, f64, f64)> {
    let mut links = Vec::new();
    for row in 0..SIDE {
        for column in 0..SIDE {
            for (down, right, stiffness) in
                [(0, 1, 1.0), (1, 0, 1.0), (1, 1, 0.3), (1, -1, 0.3), (0, 2, 0.12), (2, 0, 0.12)]
            {
                let (r, c) = (row as i64 + down, column as i64 + right);
                if (0..SIDE as i64).contains(&r) && (0..SIDE as i64).contains(&c) {
                    let length = spacing * ((down * down + right * right) as f64).sqrt();
                    links.push((row * SIDE + column, r as usize * SIDE + c as usize, length, stiffness));
                }
            }
        }
    }
    links
}

/// Pushes a point out of the ball and the floor, with friction.
fn collide(point: &mut DVec3, before: DVec3) {
    let (centre, radius) = BALL;
    let offset = *point - centre;
    let distance = offset.length();
    if distance < radius + SKIN {
        *point = centre + offset * ((radius + SKIN) / distance);
        *point = point.lerp(before, 0.25);
    }
    if point.y < SKIN {
        point.y = SKIN;
        *point = point.lerp(DVec3::new(before.x, SKIN, before.z), 0.3);
    }
}
