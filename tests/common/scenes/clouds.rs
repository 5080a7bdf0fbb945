//! Clouds of points and bundles of lines: sizes, orientation, light, blending, and what their files say of them.

use super::Entry;
use crate::common::files::load;
use crate::common::shapes::{noise, sphere};
use crate::common::stage::{Built, Stage, at, flat_view, look, plastic, unlit};
use overcoat::load::{Format, LoadOptions, MemoryResolver};
use overcoat::scene::{AlphaMode, MeshData, PrimitiveKind, Transform};
use overcoat_core::math::double;
use std::f64::consts::TAU;
use std::fmt::Write as _;

pub const SCENES: &[Entry] = &[
    ("point-clouds", point_clouds),
    ("point-clouds-near", point_clouds_near),
    ("point-files", point_files),
    ("lines-with-normals", lines_with_normals),
];

/// Points at random on the unit ball: as little like a lattice as scans are.
fn on_ball(count: u32) -> Vec<[f32; 3]> {
    let point = |k: u32| {
        let (sin, cos) = double::sin_cos(TAU * f64::from(noise(2 * k)));
        let y = 2.0 * f64::from(noise(2 * k + 1)) - 1.0;
        let r = (1.0 - y * y).sqrt();
        [(r * cos) as f32, y as f32, (r * sin) as f32]
    };
    (0..count).map(point).collect()
}

/// A square of side 2 in z = 0, a lattice.
fn on_square(side: u32) -> Vec<[f32; 3]> {
    let along = |k: u32| 2.0 * (k as f32 + 0.5) / side as f32 - 1.0;
    (0..side * side).map(|k| [along(k % side), along(k / side), 0.0]).collect()
}

fn points(positions: Vec<[f32; 3]>) -> MeshData {
    MeshData::default().with(|d| {
        d.positions = positions;
        d.kind = PrimitiveKind::Points;
    })
}

/// Colours from places.
fn colored(mut data: MeshData, alpha: f32) -> MeshData {
    let color = |p: &[f32; 3]| [0.5 + 0.4 * p[0], 0.5 + 0.4 * p[1], 0.5 - 0.4 * p[0], alpha];
    data.colors = data.positions.iter().map(color).collect();
    data
}

/// Upper row, balls of points: with normals; without, coloured; without, few of them. Lower row: a lattice that leans away, a
/// blended ball before a solid one, of which a mask leaves one half, and the corners of a cube as markers.
fn point_clouds() -> Built {
    let mut s = Stage::new()?;
    s.key_light(2.0)?;
    let grey = s.material(plastic(0.55, 0.55, 0.55, 0.5))?;
    let white = s.material(plastic(1.0, 1.0, 1.0, 0.6))?;
    let ball = |count| points(on_ball(count));
    let with_normals = s.mesh(ball(4000).with(|d| d.normals = on_ball(4000)))?;
    s.place(with_normals, grey, at([-1.3, 0.7, 0.0], 0.55)?)?;
    let without = s.mesh(colored(ball(4000), 1.0))?;
    s.place(without, white, at([0.0, 0.7, 0.0], 0.55)?)?;
    let few = s.mesh(ball(400))?;
    s.place(few, grey, at([1.3, 0.7, 0.0], 0.55)?)?;
    let leaning = s.mesh(points(on_square(30)))?;
    let turn = Transform::from_parts([-1.3, -0.7, 0.0], [0.643, 0.0, 0.0, 0.766], [0.55; 3])?;
    s.place(leaning, grey, turn)?;
    let veil = s.material(plastic(1.0, 1.0, 1.0, 0.6).with(|m| m.alpha_mode = AlphaMode::Blend))?;
    let faint = s.mesh(colored(ball(600), 0.3))?;
    s.place(faint, veil, at([0.0, -0.7, 0.6], 0.5)?)?;
    let holes =
        s.material(plastic(0.9, 0.5, 0.1, 0.6).with(|m| m.alpha_mode = AlphaMode::Mask { cutoff: 0.5 }))?;
    let mut half = ball(2000);
    half.colors = half.positions.iter().map(|p| [1.0, 1.0, 1.0, 0.5 - 0.4 * p[0]]).collect();
    let half = s.mesh(half)?;
    s.place(half, holes, at([0.0, -0.7, -0.2], 0.4)?)?;
    let corners = (0..8_u8).map(|k| [k & 1, k >> 1 & 1, k >> 2].map(|v| 2.0 * f32::from(v) - 1.0)).collect();
    let corners = s.mesh(points(corners))?;
    let red = s.material(unlit(0.9, 0.1, 0.05))?;
    let turn = Transform::from_parts([1.3, -0.7, 0.0], [0.19, 0.32, 0.06, 0.926], [0.4; 3])?;
    s.place(corners, red, turn)?;
    s.seen(look([0.0, 0.0, 8.0], [0.0; 3], 20.0))
}

/// A plain of points from before the near plane to the horizon: discs as large as they may be, and smaller than a pixel.
fn point_clouds_near() -> Built {
    let mut s = Stage::new()?;
    s.key_light(2.0)?;
    let white = s.material(plastic(1.0, 1.0, 1.0, 0.6))?;
    let plain = on_square(120).into_iter().map(|[x, y, _]| [20.0 * x, 0.0, 20.0 * y]).collect();
    let mut plain = points(plain);
    let stripe = |p: &[f32; 3]| {
        let odd = (p[0] * 0.5).floor() as i32 + (p[2] * 0.5).floor() as i32;
        if odd & 1 == 0 { [0.8, 0.7, 0.2, 1.0] } else { [0.1, 0.2, 0.5, 1.0] }
    };
    plain.colors = plain.positions.iter().map(stripe).collect();
    let plain = s.mesh(plain)?;
    s.place(plain, white, Transform::IDENTITY)?;
    s.seen(look([0.0, 1.2, 18.0], [0.0, 0.0, 6.0], 50.0))
}

/// A PLY file for each of intensity, classes and colours of 16 bits, and an OBJ file of points and lines.
fn point_files() -> Built {
    let ply = |properties: &str, value: &dyn Fn(&[f32; 3]) -> String| {
        let places = on_ball(2500);
        let mut text = format!(
            "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n\
             {properties}end_header\n",
            places.len()
        );
        for p in &places {
            let _ = writeln!(text, "{} {} {} {}", p[0], p[1], p[2], value(p));
        }
        text
    };
    let intensity = ply("property float intensity\n", &|p| format!("{}", 40.0 + 30.0 * p[1]));
    let classes = ply("property uchar classification\n", &|p| format!("{}", ((p[0] + 1.0) * 2.0) as u8));
    let colors = ply("property ushort red\nproperty ushort green\nproperty ushort blue\n", &|p| {
        let code = |v: f32| ((v * 0.5 + 0.5) * 65535.0) as u16;
        format!("{} {} {}", code(p[0]), code(p[1]), code(p[2]))
    });
    let mut obj = String::new();
    for k in 0..160 {
        let (sin, cos) = double::sin_cos(TAU * f64::from(k) / 20.0);
        let t = f64::from(k) / 160.0;
        let _ = writeln!(obj, "v {} {} {} {t} {} 0.2", 0.9 * cos, 1.8 * t - 0.9, 0.9 * sin, 1.0 - t);
    }
    obj.push('l');
    (1..=160).for_each(|k| {
        let _ = write!(obj, " {k}");
    });
    for (k, [x, y, z]) in (161..).zip(on_ball(300)) {
        let _ = write!(obj, "\nv {} {} {} 1 1 1\np {k}", 0.6 * x, 0.6 * y, 0.6 * z);
    }
    let mut s = Stage::new()?;
    s.key_light(2.0)?;
    let files = [
        (intensity.into_bytes(), Format::Ply),
        (classes.into_bytes(), Format::Ply),
        (colors.into_bytes(), Format::Ply),
        (obj.into_bytes(), Format::Obj),
    ];
    for ((bytes, format), x) in files.iter().zip([-1.5, -0.5, 0.5, 1.5]) {
        let scene = load(bytes, *format, &MemoryResolver::default(), &LoadOptions::default())?;
        s.add(&scene, at([x, 0.0, 0.0], 0.47)?)?;
    }
    let camera = flat_view();
    s.seen(camera)
}

/// Hair on a ball: lit by its normals on the left, and blended; without light on the right.
fn lines_with_normals() -> Built {
    let mut s = Stage::new()?;
    s.key_light(2.0)?;
    let skin = s.material(plastic(0.2, 0.15, 0.1, 0.7))?;
    let ball = s.mesh(sphere(24))?;
    let fur = |normals: bool| {
        let mut data = MeshData::default().with(|d| d.kind = PrimitiveKind::Lines);
        for (k, p) in (0..).zip(on_ball(1500)) {
            data.positions.extend([p, [1.2 * p[0], 1.2 * p[1] - 0.1, 1.2 * p[2]]]);
            if normals {
                data.normals.extend([p; 2]);
            }
            data.triangles.push([2 * k, 2 * k + 1, 2 * k + 1]);
        }
        data
    };
    let (lit, plain) = (s.mesh(fur(true))?, s.mesh(fur(false))?);
    let brown = s.material(plastic(0.6, 0.35, 0.15, 0.5))?;
    let flat = s.material(unlit(0.6, 0.35, 0.15))?;
    let mut veil = plastic(0.2, 0.5, 0.9, 0.5);
    (veil.alpha_mode, veil.base_color[3]) = (AlphaMode::Blend, 0.4);
    let veil = s.material(veil)?;
    for (x, mesh, material) in [(-1.1, lit, brown), (0.0, lit, veil), (1.1, plain, flat)] {
        s.place(ball, skin, at([x, 0.0, 0.0], 0.4)?)?;
        s.place(mesh, material, at([x, 0.0, 0.0], 0.4)?)?;
    }
    s.seen(look([0.0, 0.0, 8.0], [0.0; 3], 16.0))
}
