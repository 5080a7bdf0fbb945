//! Scenes of shapes: what is covered, what is in front, which side is seen.

use super::Entry;
use crate::common::shapes::{cube, gutter, letter, noise, repeat_uv, sphere, square, surface, torus};
use crate::common::stage::{Built, Stage, at, flat_view, look, metal, plastic, turned, unlit};
use overcoat::scene::{AlphaMode, Camera, Material, MeshData, PrimitiveKind, Projection, Transform};
use overcoat_core::math::double;
use std::f64::consts::TAU;

pub const SCENES: &[Entry] = &[
    ("primitives", primitives),
    ("fill-rule", fill_rule),
    ("fill-rule-blend", fill_rule_blend),
    ("shared-edges", shared_edges),
    ("tiny-triangles", tiny_triangles),
    ("near-plane", near_plane),
    ("inside-out", inside_out),
    ("large-coordinates", large_coordinates),
    ("small-coordinates", small_coordinates),
    ("depth-ties", depth_ties),
    ("interpenetration", interpenetration),
    ("mirrored-instances", mirrored_instances),
    ("double-sided", double_sided),
    ("flat-normals", flat_normals),
    ("zero-normals", zero_normals),
    ("orthographic", orthographic),
    ("many-instances", many_instances),
    ("empty", empty),
    ("points-and-lines", points_and_lines),
];

/// Sphere, cube, torus and half a cylinder.
fn primitives() -> Built {
    let mut s = Stage::new()?;
    s.key_light(1.5)?;
    let red = s.material(plastic(0.7, 0.1, 0.08, 0.3))?;
    let gold = s.material(metal(1.0, 0.72, 0.3, 0.25))?;
    let blue = s.material(plastic(0.08, 0.2, 0.6, 0.6))?;
    let grey = s.material(plastic(0.5, 0.5, 0.5, 0.5).with(|m| m.double_sided = true))?;
    let (ball, ring, block, sheet) =
        (s.mesh(sphere(48))?, s.mesh(torus(0.35, 48))?, s.mesh(cube())?, s.mesh(gutter(24))?);
    s.place(ball, red, at([-1.1, 1.0, 0.0], 0.9)?)?;
    s.place(ring, gold, turned([1.1, 1.0, 0.0], [1.0, 0.0, 0.0], [0.5, 0.866], 0.75)?)?;
    s.place(block, blue, turned([-1.1, -1.1, 0.0], [0.6, 0.8, 0.0], [0.38, 0.925], 0.62)?)?;
    s.place(sheet, grey, turned([1.1, -1.1, 0.0], [0.0, 1.0, 0.0], [0.45, 0.893], 0.75)?)?;
    s.seen(look([0.0, 0.6, 7.5], [0.0, -0.05, 0.0], 34.0))
}

/// Slivers around a common vertex on the left; on the right a grid whose edges run exactly through pixel centres
/// and samples. Every triangle has its own colour; together they cover the view once.
fn torture_mesh() -> (MeshData, MeshData) {
    let mut fan = MeshData::default().with(|d| d.positions = vec![[-0.5, 0.013, 0.0]]);
    const SLIVERS: u32 = 97;
    // Far enough out to cover the left half of the view; the right half lies in front of the rest.
    for k in 0..SLIVERS {
        let (sin, cos) = double::sin_cos(TAU * f64::from(k) / f64::from(SLIVERS));
        fan.positions.push([(-0.5 + 2.0 * cos) as f32, (0.013 + 2.0 * sin) as f32, 0.0]);
    }
    fan.triangles = (0..SLIVERS).map(|k| [0, 1 + k, 1 + (k + 1) % SLIVERS]).collect();
    let mut grid = surface(16, 32, |u, v| ([u, 1.0 - 2.0 * v, 0.5], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]));
    // Alternate diagonals.
    for (k, pair) in grid.triangles.chunks_mut(2).enumerate() {
        if k % 2 == 1 {
            let [a, d, c] = pair[0];
            let b = pair[1][2];
            pair.copy_from_slice(&[[a, d, b], [b, d, c]]);
        }
    }
    (colored(&fan), colored(&grid))
}

/// Gives every triangle vertices and a colour of its own.
fn colored(mesh: &MeshData) -> MeshData {
    let mut out = MeshData::default();
    for (k, t) in mesh.triangles.iter().enumerate() {
        let color = [0, 1, 2].map(|c| 0.15 + 0.85 * noise(3 * k as u32 + c));
        for &v in t {
            out.positions.push(mesh.positions[v as usize]);
            out.colors.push([color[0], color[1], color[2], 1.0]);
        }
        let first = 3 * k as u32;
        out.triangles.push([first, first + 1, first + 2]);
    }
    out
}

fn torture(material: Material) -> Built {
    let mut s = Stage::dark()?;
    let material = s.material(material)?;
    let (fan, grid) = torture_mesh();
    let (fan, grid) = (s.mesh(fan)?, s.mesh(grid)?);
    s.place(grid, material, Transform::IDENTITY)?;
    s.place(fan, material, Transform::IDENTITY)?;
    s.seen(flat_view())
}

fn fill_rule() -> Built {
    torture(unlit(1.0, 1.0, 1.0))
}

/// The same, half transparent and the grid alone: where two triangles cover one sample, it is too bright, where
/// none does, too dark.
fn fill_rule_blend() -> Built {
    let mut s = Stage::dark()?;
    let white = unlit(1.0, 1.0, 1.0).with(|m| {
        m.base_color = [1.0, 1.0, 1.0, 0.5];
        m.alpha_mode = AlphaMode::Blend;
    });
    let material = s.material(white)?;
    let (fan, mut grid) = torture_mesh();
    grid.colors.clear();
    let mut fan = fan;
    fan.colors.clear();
    let (fan, grid) = (s.mesh(fan)?, s.mesh(grid)?);
    s.place(grid, material, at([-0.97, 0.0, 0.0], 0.9)?)?;
    s.place(fan, material, at([0.7, 0.0, 0.0], 0.2)?)?;
    s.seen(flat_view())
}

/// A sphere of which every triangle has its own vertices, seen through by nothing: over transparency a crack would
/// show as a pixel that is not opaque.
fn shared_edges() -> Built {
    let mut s = Stage::dark()?;
    let material = s.material(unlit(1.0, 1.0, 1.0).with(|m| m.double_sided = true))?;
    let mesh = s.mesh(colored(&sphere(40)))?;
    let transform = Transform::from_parts([0.0; 3], [0.2, 0.3, 0.1, 0.9], [1.0, 1.3, 0.9])?;
    s.place(mesh, material, transform)?;
    s.seen(look([0.3, 0.2, 4.0], [0.0; 3], 40.0))
}

/// 65 thousand triangles on a few thousand pixels.
fn tiny_triangles() -> Built {
    let mut s = Stage::new()?;
    let material = s.material(plastic(0.2, 0.5, 0.25, 0.35))?;
    let mesh = s.mesh(surface(256, 128, |u, v| {
        // Ripples, so that neighbouring triangles differ.
        let (sin_phi, cos_phi) = double::sin_cos(TAU * u);
        let (sin_theta, cos_theta) = double::sin_cos(0.5 * TAU * v);
        let r = 1.0 + 0.03 * double::sin(24.0 * TAU * u) * sin_theta;
        let n = [sin_theta * sin_phi, cos_theta, sin_theta * cos_phi];
        (n.map(|c| c * r), n, [cos_phi, 0.0, -sin_phi])
    }))?;
    s.place(mesh, material, Transform::IDENTITY)?;
    s.seen(look([0.0, 0.5, 4.5], [0.0; 3], 30.0))
}

/// Floor, walls and bars that pass through the near plane and behind the camera.
fn near_plane() -> Built {
    let mut s = Stage::new()?;
    let grey = s.material(plastic(0.45, 0.45, 0.42, 0.7).with(|m| m.double_sided = true))?;
    let orange = s.material(plastic(0.8, 0.35, 0.05, 0.4))?;
    let (panel, block) = (s.mesh(square(3))?, s.mesh(cube())?);
    s.place(panel, grey, turned([0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [-0.707, 0.707], 40.0)?)?;
    for x in [-2.0, 2.0] {
        // Bars along the view, from far behind the camera to far in front of it.
        let scale = Transform::from_parts([x, -0.4, 0.0], [0.0, 0.0, 0.0, 1.0], [0.2, 0.2, 30.0])?;
        s.place(block, orange, scale)?;
    }
    // A tilted cube that the near plane cuts open.
    s.place(block, orange, turned([0.45, 0.3, 0.35], [0.6, 0.64, 0.48], [0.35, 0.937], 0.6)?)?;
    let mut camera = look([0.0, 0.2, 1.2], [0.0, 0.0, -2.0], 70.0);
    camera.near = 0.3;
    s.seen(camera)
}

/// The camera in the hole of a torus and inside a sphere: triangles in front, beside and behind it.
fn inside_out() -> Built {
    let mut s = Stage::new()?;
    let inner = s.material(plastic(0.6, 0.3, 0.5, 0.5))?;
    let outer = s.material(unlit(0.1, 0.25, 0.3).with(|m| m.double_sided = true))?;
    let (ring, ball) = (s.mesh(torus(0.4, 40))?, s.mesh(sphere(16))?);
    s.place(ring, inner, turned([0.0, 0.1, 0.0], [1.0, 0.0, 0.0], [0.1, 0.995], 1.0)?)?;
    s.place(ball, outer, at([0.0; 3], 50.0)?)?;
    s.seen(look([0.4, 0.15, 0.15], [-0.3, 0.2, -1.0], 110.0))
}

/// A million metres from the origin.
fn large_coordinates() -> Built {
    let mut s = Stage::new()?;
    let (red, gold) = (s.material(plastic(0.7, 0.1, 0.08, 0.3))?, s.material(metal(1.0, 0.72, 0.3, 0.25))?);
    let (ball, ring) = (s.mesh(sphere(48))?, s.mesh(torus(0.3, 48))?);
    let place = [1_000_000.0, -2_000_000.0, 500_000.0];
    s.place(ball, red, at(place, 1000.0)?)?;
    s.place(ring, gold, turned(place, [0.8, 0.0, 0.6], [0.3, 0.954], 1500.0)?)?;
    s.seen(look([1_000_000.0, -1_998_000.0, 507_000.0], place.map(|v| v as f32), 32.0))
}

/// A millionth of a metre in size.
fn small_coordinates() -> Built {
    let mut s = Stage::new()?;
    let (red, gold) = (s.material(plastic(0.7, 0.1, 0.08, 0.3))?, s.material(metal(1.0, 0.72, 0.3, 0.25))?);
    let (ball, ring) = (s.mesh(sphere(48))?, s.mesh(torus(0.3, 48))?);
    s.place(ball, red, at([0.0; 3], 1e-6)?)?;
    s.place(ring, gold, turned([0.0; 3], [0.8, 0.0, 0.6], [0.3, 0.954], 1.5e-6)?)?;
    let mut camera = look([0.0, 2e-6, 7e-6], [0.0; 3], 32.0);
    camera.near = 1e-6;
    s.seen(camera)
}

/// Squares of one depth and different meshes above, one tilted mesh drawn twice below: the earlier draw is seen.
/// Left: red before green; right: green before red.
fn depth_ties() -> Built {
    let mut s = Stage::dark()?;
    let (red, green) = (s.material(unlit(0.8, 0.1, 0.1))?, s.material(unlit(0.1, 0.7, 0.1))?);
    let (whole, cut) = (s.mesh(square(1))?, s.mesh(square(7))?);
    for (x, first, second) in [(-0.55, red, green), (0.55, green, red)] {
        s.place(whole, first, at([x, 0.6, 0.0], 0.35)?)?;
        s.place(cut, second, at([x, 0.4, 0.0], 0.35)?)?;
        for material in [first, second] {
            s.place(cut, material, turned([x, -0.5, 0.0], [0.6, 0.8, 0.0], [0.3, 0.954], 0.4)?)?;
        }
    }
    s.seen(look([0.0, 0.0, 4.0], [0.0; 3], 32.0))
}

/// Tori and a cube that pass through each other: the line where they meet.
fn interpenetration() -> Built {
    let mut s = Stage::new()?;
    let (ring, block) = (s.mesh(torus(0.3, 48))?, s.mesh(cube())?);
    let colors = [[0.7, 0.1, 0.08], [0.1, 0.5, 0.15], [0.1, 0.15, 0.6]];
    let axes = [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.6, 0.0, 0.8]];
    for ([r, g, b], axis) in colors.into_iter().zip(axes) {
        let material = s.material(plastic(r, g, b, 0.4))?;
        s.place(ring, material, turned([0.0; 3], axis, [0.55, 0.835], 1.0)?)?;
    }
    let grey = s.material(plastic(0.6, 0.6, 0.6, 0.5))?;
    s.place(block, grey, turned([0.0; 3], [0.6, 0.8, 0.0], [0.3, 0.954], 0.75)?)?;
    s.seen(look([0.0, 1.5, 5.0], [0.0; 3], 32.0))
}

/// A bent letter, its mirror image and its turned image: all closed, lit from the same side.
fn mirrored_instances() -> Built {
    let mut s = Stage::new()?;
    s.key_light(2.0)?;
    let blue = s.material(plastic(0.15, 0.3, 0.7, 0.3))?;
    let letter = s.mesh(letter())?;
    let ring = s.mesh(torus(0.4, 40))?;
    for (x, scale) in [(-1.5, [1.0, 1.0, 1.0]), (0.0, [-1.0, 1.0, 1.0]), (1.5, [-1.0, -1.0, 1.0])] {
        let q = [0.0, 0.0, 0.0, 1.0];
        s.place(letter, blue, Transform::from_parts([x, 0.9, 0.0], q, scale.map(|c| 0.7 * c))?)?;
        let q = [0.35, 0.2, 0.0, 0.915];
        s.place(ring, blue, Transform::from_parts([x, -0.8, 0.0], q, scale.map(|c: f64| c * 0.5))?)?;
    }
    s.seen(look([0.0, 0.0, 7.0], [0.0; 3], 38.0))
}

/// Half cylinders from outside and inside; above double-sided, below one-sided. Lit from the front left.
fn double_sided() -> Built {
    let mut s = Stage::dark()?;
    s.key_light(3.0)?;
    let two = s.material(plastic(0.6, 0.5, 0.2, 0.5).with(|m| m.double_sided = true))?;
    let one = s.material(plastic(0.2, 0.5, 0.6, 0.5))?;
    let sheet = s.mesh(gutter(32))?;
    for (y, material) in [(0.75, two), (-0.75, one)] {
        s.place(sheet, material, at([-1.2, y, 0.0], 0.65)?)?;
        s.place(sheet, material, turned([0.3, y, 0.0], [0.0, 1.0, 0.0], [0.707, 0.707], 0.65)?)?;
        s.place(sheet, material, turned([1.5, y, -0.5], [0.0, 1.0, 0.0], [1.0, 0.0], 0.65)?)?;
    }
    s.seen(look([0.0, 0.0, 7.0], [0.1, 0.0, 0.0], 36.0))
}

/// The same sphere with smooth normals and without any.
fn flat_normals() -> Built {
    let mut s = Stage::new()?;
    let material = s.material(plastic(0.5, 0.5, 0.55, 0.25))?;
    let smooth = sphere(14);
    let flat = smooth.clone().with(|d| {
        d.normals = Vec::new();
        d.tangents = Vec::new();
    });
    let (smooth, flat) = (s.mesh(smooth)?, s.mesh(flat)?);
    s.place(smooth, material, at([-1.1, 0.0, 0.0], 1.0)?)?;
    s.place(flat, material, at([1.1, 0.0, 0.0], 1.0)?)?;
    s.seen(look([0.0, 0.5, 6.5], [0.0; 3], 40.0))
}

/// A sphere with zero normals on one half: facets there, smooth elsewhere, no black.
fn zero_normals() -> Built {
    let mut s = Stage::new()?;
    let material = s.material(plastic(0.5, 0.5, 0.55, 0.25))?;
    let mut mesh = sphere(20);
    for (normal, position) in mesh.normals.iter_mut().zip(&mesh.positions) {
        if position[0] > 0.05 {
            *normal = [0.0; 3];
        }
    }
    let mesh = s.mesh(mesh)?;
    s.place(mesh, material, Transform::IDENTITY)?;
    s.seen(look([0.0, 0.5, 4.0], [0.0; 3], 34.0))
}

/// Equal cubes at different distances have the same size.
fn orthographic() -> Built {
    let mut s = Stage::new()?;
    s.key_light(1.0)?;
    let block = s.mesh(cube())?;
    for k in 0..5 {
        let material = s.material(plastic(0.2 + 0.15 * k as f32, 0.5, 0.7 - 0.15 * k as f32, 0.4))?;
        let x = f64::from(k) - 2.0;
        s.place(block, material, at([x, 0.4 * x, -2.0 * f64::from(k)], 0.4)?)?;
    }
    s.seen(Camera::new(
        [3.0, 4.0, 10.0],
        [0.0, 0.0, -4.0],
        [0.0, 1.0, 0.0],
        Projection::Orthographic { height: 8.0 },
        0.01,
    ))
}

/// 400 instances of two meshes.
fn many_instances() -> Built {
    let mut s = Stage::new()?;
    let meshes = [s.mesh(sphere(12))?, s.mesh(repeat_uv(torus(0.4, 14), 2.0))?];
    let materials = [
        s.material(plastic(0.7, 0.1, 0.08, 0.3))?,
        s.material(metal(0.9, 0.9, 0.95, 0.3))?,
        s.material(plastic(0.1, 0.3, 0.6, 0.6))?,
    ];
    for k in 0..400_u32 {
        let [x, y, z] = [0, 1, 2].map(|c| f64::from(noise(7 * k + c)) * 4.0 - 2.0);
        let q = [3, 4, 5, 6].map(|c| f64::from(noise(7 * k + c)) - 0.5);
        let transform = Transform::from_parts([x, y, z], q, [0.2; 3])?;
        s.place(meshes[(k % 2) as usize], materials[(k % 3) as usize], transform)?;
    }
    s.seen(look([0.0, 0.0, 8.0], [0.0; 3], 32.0))
}

/// Nothing but the environment.
fn empty() -> Built {
    Stage::new()?.seen(look([0.0; 3], [1.0, 0.0, 1.0], 90.0))
}

/// A coloured spiral of lines around a ball that hides half of it, a cloud of points, and a line through the near plane.
fn points_and_lines() -> Built {
    let mut s = Stage::new()?;
    let white = s.material(unlit(1.0, 1.0, 1.0))?;
    let ball = s.mesh(sphere(24))?;
    let grey = s.material(plastic(0.3, 0.3, 0.3, 0.6))?;
    s.place(ball, grey, at([0.0; 3], 0.8)?)?;
    let mut spiral = MeshData::default().with(|d| d.kind = PrimitiveKind::Lines);
    const TURNS: u32 = 200;
    for k in 0..=TURNS {
        let t = f64::from(k) / f64::from(TURNS);
        let (sin, cos) = double::sin_cos(TAU * 5.0 * t);
        spiral.positions.push([cos as f32, (2.0 * t - 1.0) as f32, sin as f32]);
        spiral.colors.push([t as f32, 0.3, 1.0 - t as f32, 1.0]);
    }
    spiral.triangles = (0..TURNS).map(|k| [k, k + 1, k + 1]).collect();
    let spiral = s.mesh(spiral)?;
    s.place(spiral, white, Transform::IDENTITY)?;
    let mut cloud = MeshData::default().with(|d| d.kind = PrimitiveKind::Points);
    for k in 0..120 {
        let place = [noise(3 * k), noise(3 * k + 1), noise(3 * k + 2)];
        cloud.positions.push(place.map(|v| 3.2 * v - 1.6));
        cloud.colors.push([place[0], place[1], 0.2, 1.0]);
    }
    cloud.triangles = (0..120).map(|k| [k; 3]).collect();
    let cloud = s.mesh(cloud)?;
    s.place(cloud, white, Transform::IDENTITY)?;
    let through = MeshData::default().with(|d| {
        d.positions = vec![[-2.0, -1.3, -1.0], [1.2, 0.6, 9.0]];
        d.triangles = vec![[0, 1, 1]];
        d.kind = PrimitiveKind::Lines;
    });
    let through = s.mesh(through)?;
    s.place(through, white, Transform::IDENTITY)?;
    s.seen(look([0.0, 1.0, 5.5], [0.0; 3], 34.0))
}
