//! Meshes made by formula. Tangents follow u; v runs down, so that bitangents (w = 1) point up in the picture.

use overcoat::scene::MeshData;
use overcoat_core::math::double;
use std::f64::consts::{PI, TAU};

/// A point of a surface: position, normal, tangent.
pub type Point = ([f64; 3], [f64; 3], [f64; 3]);

/// A surface over the unit square of texture coordinates in `nu * nv` cells of two triangles.
pub fn surface(nu: u32, nv: u32, f: impl Fn(f64, f64) -> Point) -> MeshData {
    let mut mesh = MeshData::default();
    for j in 0..=nv {
        for i in 0..=nu {
            let [u, v] = [f64::from(i) / f64::from(nu), f64::from(j) / f64::from(nv)];
            let (position, normal, [x, y, z]) = f(u, v);
            mesh.positions.push(position.map(|c| c as f32));
            mesh.normals.push(normal.map(|c| c as f32));
            mesh.tangents.push([x as f32, y as f32, z as f32, 1.0]);
            mesh.uvs[0].push([u as f32, v as f32]);
        }
    }
    for j in 0..nv {
        for i in 0..nu {
            let a = j * (nu + 1) + i;
            let (b, c, d) = (a + 1, a + nu + 2, a + nu + 1);
            mesh.triangles.extend([[a, d, c], [a, c, b]]);
        }
    }
    mesh
}

/// Sphere of radius 1, texture upright as seen from outside.
pub fn sphere(segments: u32) -> MeshData {
    surface(segments, segments / 2, |u, v| {
        let (sin_phi, cos_phi) = double::sin_cos(TAU * u);
        let (sin_theta, cos_theta) = double::sin_cos(PI * v);
        let p = [sin_theta * sin_phi, cos_theta, sin_theta * cos_phi];
        (p, p, [cos_phi, 0.0, -sin_phi])
    })
}

/// Torus around +Y: ring of radius 1, tube of the given radius.
pub fn torus(tube: f64, segments: u32) -> MeshData {
    surface(segments, segments / 2, |u, v| {
        let (sin_phi, cos_phi) = double::sin_cos(TAU * u);
        let (sin_theta, cos_theta) = double::sin_cos(-TAU * v);
        let ring = 1.0 + tube * cos_theta;
        (
            [ring * sin_phi, tube * sin_theta, ring * cos_phi],
            [cos_theta * sin_phi, sin_theta, cos_theta * cos_phi],
            [cos_phi, 0.0, -sin_phi],
        )
    })
}

/// Square of side 2 that faces +Z, texture upright.
pub fn square(cells: u32) -> MeshData {
    surface(cells, cells, |u, v| ([2.0 * u - 1.0, 1.0 - 2.0 * v, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]))
}

/// Square of side 2 that faces +Y.
pub fn ground(cells: u32) -> MeshData {
    surface(cells, cells, |u, v| ([2.0 * u - 1.0, 0.0, 2.0 * v - 1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]))
}

/// Open half of a cylinder of radius 1 and height 2 around Y, bulging towards +Z.
pub fn gutter(segments: u32) -> MeshData {
    surface(segments, 1, |u, v| {
        let (sin, cos) = double::sin_cos(PI * (u - 0.5));
        ([sin, 1.0 - 2.0 * v, cos], [sin, 0.0, cos], [cos, 0.0, -sin])
    })
}

/// Cube of side 2, six separate faces, texture upright on each.
pub fn cube() -> MeshData {
    const FACES: [[[f64; 3]; 2]; 6] = [
        [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0]],
        [[1.0, 0.0, 0.0], [0.0, 0.0, -1.0]],
        [[0.0, 0.0, -1.0], [-1.0, 0.0, 0.0]],
        [[-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]],
        [[0.0, 1.0, 0.0], [1.0, 0.0, 0.0]],
        [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0]],
    ];
    let mut all = MeshData::default();
    for [n, t] in FACES {
        let b = [n[1] * t[2] - n[2] * t[1], n[2] * t[0] - n[0] * t[2], n[0] * t[1] - n[1] * t[0]];
        append(
            &mut all,
            &surface(1, 1, |u, v| {
                (std::array::from_fn(|k| n[k] + t[k] * (2.0 * u - 1.0) + b[k] * (1.0 - 2.0 * v)), n, t)
            }),
        );
    }
    all
}

/// A letter L in the XY plane facing +Z: has neither mirror nor turn symmetry.
pub fn letter() -> MeshData {
    let outline = [[-0.6, -1.0], [0.6, -1.0], [0.6, -0.6], [-0.2, -0.6], [-0.2, 1.0], [-0.6, 1.0]];
    let mut mesh = MeshData::new(
        outline.iter().map(|&[x, y]| [x, y, 0.0]).collect(),
        vec![[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]],
    );
    mesh.normals = vec![[0.0, 0.0, 1.0]; 6];
    mesh.tangents = vec![[1.0, 0.0, 0.0, 1.0]; 6];
    mesh.uvs[0] = outline.iter().map(|&[x, y]| [0.5 + 0.5 * x, 0.5 - 0.5 * y]).collect();
    mesh
}

/// Puts a mesh with the same attributes behind another.
pub fn append(to: &mut MeshData, from: &MeshData) {
    let first = to.positions.len() as u32;
    to.positions.extend_from_slice(&from.positions);
    to.normals.extend_from_slice(&from.normals);
    to.tangents.extend_from_slice(&from.tangents);
    to.colors.extend_from_slice(&from.colors);
    for (a, b) in to.uvs.iter_mut().zip(&from.uvs) {
        a.extend_from_slice(b);
    }
    to.triangles.extend(from.triangles.iter().map(|t| t.map(|v| v + first)));
}

/// Multiplies the texture coordinates of set 0.
pub fn repeat_uv(mut mesh: MeshData, times: f32) -> MeshData {
    for v in mesh.uvs[0].as_flattened_mut() {
        *v *= times;
    }
    mesh
}

/// A number from 0 to 1 for each integer, without pattern.
pub fn noise(k: u32) -> f32 {
    let mut h = k.wrapping_mul(0x9e37_79b9) ^ 0x85eb_ca6b;
    h = (h ^ (h >> 16)).wrapping_mul(0x7feb_352d);
    h = (h ^ (h >> 15)).wrapping_mul(0x846c_a68b);
    ((h ^ (h >> 16)) >> 8) as f32 / 16_777_216.0
}
