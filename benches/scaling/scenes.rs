//! Scenes by formula.

use overcoat::scene::{
    Camera, Framing, Instance, Light, LightKind, Material, Mesh, MeshData, Projection, Scene, Transform,
    Workflow,
};
use overcoat_core::math::double;
use std::f64::consts::{PI, TAU};

/// A torus knot of about that many triangles in a coat of paint, in the built-in studio.
pub fn knot(triangles: u32) -> Scene {
    // Sixteen times as many steps along the tube as around it make cells about square.
    let around = (f64::from(triangles) / 32.0).sqrt().round().max(3.0) as u32;
    painted(surface(16 * around, around, |u, v| {
        let center = |t: f64| {
            let (sin3, cos3) = double::sin_cos(3.0 * t);
            let (sin2, cos2) = double::sin_cos(2.0 * t);
            let ring = 2.0 + cos3;
            [ring * cos2, sin3, ring * sin2]
        };
        let t = TAU * u;
        let (here, next) = (center(t), center(t + 1e-4));
        let along = unit(std::array::from_fn(|k| next[k] - here[k]));
        let side = unit(cross(along, [0.3, 1.0, 0.2]));
        let up = cross(side, along);
        let (sin, cos) = double::sin_cos(TAU * v);
        let normal = std::array::from_fn(|k| cos * side[k] + sin * up[k]);
        (std::array::from_fn(|k| here[k] + 0.55 * normal[k]), normal)
    }))
}

/// A ball of radius 1 of about that many triangles, likewise.
pub fn ball(triangles: u32) -> Scene {
    let rings = (f64::from(triangles) / 4.0).sqrt().round().max(3.0) as u32;
    painted(surface(2 * rings, rings, |u, v| {
        let (sin_phi, cos_phi) = double::sin_cos(-TAU * u);
        let (sin_theta, cos_theta) = double::sin_cos(PI * v);
        let p = [sin_theta * cos_phi, cos_theta, sin_theta * sin_phi];
        (p, p)
    }))
}

/// Adds that many point lights on a spiral around a model of radius 1. Together they are as bright as one.
pub fn add_lights(scene: &mut Scene, count: u32) {
    for k in 0..count {
        let height = 1.0 - 2.0 * (f64::from(k) + 0.5) / f64::from(count);
        let (sin, cos) = double::sin_cos(2.4 * f64::from(k));
        let ring = (1.0 - height * height).sqrt();
        let position = [3.0 * ring * cos, 3.0 * height, 3.0 * ring * sin].map(|v| v as f32);
        let kind = LightKind::Point { position, range: None };
        scene
            .add_light(Light::new(kind).with(|l| l.intensity = 20.0 / count as f32))
            .expect("its numbers are in range");
    }
}

/// The default view.
pub fn framed(scene: &Scene) -> Camera {
    Framing::default().camera(scene)
}

/// A parallel view along -Z of that many units from top to bottom.
pub fn parallel(height: f32) -> Camera {
    Camera::new([0.0, 0.0, 4.0], [0.0; 3], [0.0, 1.0, 0.0], Projection::Orthographic { height }, 0.01)
}

fn painted(data: MeshData) -> Scene {
    let mut scene = Scene::new();
    let material = Material::default().with(|m| {
        m.base_color = [0.7, 0.05, 0.03, 1.0];
        m.workflow = Workflow::MetallicRoughness { metallic: 0.3, roughness: 0.4, texture: None };
        m.coat = 1.0;
        m.coat_roughness = 0.05;
    });
    let mesh = scene.add_mesh(Mesh::new(data).expect("indices are in range")).expect("one mesh");
    let material = scene.add_material(material).expect("factors are in range");
    scene.add_instance(Instance::new(mesh, material, Transform::IDENTITY)).expect("mesh and material exist");
    scene
}

/// A surface over the unit square in `columns` x `rows` cells of two triangles: positions and normals.
fn surface(columns: u32, rows: u32, f: impl Fn(f64, f64) -> ([f64; 3], [f64; 3])) -> MeshData {
    let mut data = MeshData::default();
    for j in 0..=rows {
        for i in 0..=columns {
            let (position, normal) = f(f64::from(i) / f64::from(columns), f64::from(j) / f64::from(rows));
            data.positions.push(position.map(|c| c as f32));
            data.normals.push(normal.map(|c| c as f32));
        }
    }
    for j in 0..rows {
        for i in 0..columns {
            let a = j * (columns + 1) + i;
            let b = a + columns + 1;
            data.triangles.extend([[a, b, b + 1], [a, b + 1, a + 1]]);
        }
    }
    data
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn unit(v: [f64; 3]) -> [f64; 3] {
    let length = (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
    v.map(|c| c / length)
}
