//! Procedural meshes, for scenes built by hand.
//!
//! Each is centred at the origin, with unit normals that point outwards, triangles that are counter-clockwise seen from
//! outside, and unit tangents that follow u, so that normal maps fit. The texture is upright and not mirrored for who looks
//! from outside: u runs to the right, v down. The bits are the same on every machine.
//!
//! ```
//! # mod overcoat { pub use {overcoat_scene as scene, overcoat_scene::Scene}; }
//! use overcoat::scene::{Instance, Material, Transform, primitives};
//! use overcoat::Scene;
//!
//! # fn main() -> Result<(), overcoat::scene::SceneError> {
//! let mut scene = Scene::new();
//! let mesh = scene.add_mesh(primitives::sphere(0.5, 64)?)?;
//! let material = scene.add_material(Material::default())?;
//! let transform = Transform::translation([0.0, 0.5, 0.0])?;
//! scene.add_instance(Instance::new(mesh, material, transform))?;
//! # Ok(())
//! # }
//! ```

use super::error::within;
use super::{MAX_COORDINATE, Mesh, MeshData, SceneError};
use overcoat_core::math::double::sin_cos;
use std::f64::consts::{PI, TAU};

/// Segments of a circle at most.
pub const MAX_SEGMENTS: u32 = 1024;

/// Least length of a side or a radius in metres.
const MIN_SIZE: f32 = 1e-15;

/// Largest windings of a knot.
const MAX_WINDINGS: u32 = 64;

/// A ball of a radius in metres, with its poles at +Y and -Y.
///
/// `segments`, 3 to [`MAX_SEGMENTS`], go once around, and half as many from pole to pole. The texture lies around it as a
/// map around a globe: the middle faces +Z, its first row is at +Y, its left and right border meet at -Z.
///
/// # Errors
/// [`SceneError::NotFinite`] and [`SceneError::OutOfRange`].
pub fn sphere(radius: f32, segments: u32) -> Result<Mesh, SceneError> {
    check_sizes("radius of the sphere", &[radius])?;
    check_segments(segments)?;
    let radius = f64::from(radius);
    let (columns, rows) = (segments, segments.div_ceil(2));
    let mut mesh = Builder::default();
    let mut vertex = |u: f64, angle: f64, v: f64, [sin_v, cos_v]: [f64; 2]| {
        let (sin, cos) = sin_cos(angle);
        let normal = [sin_v * sin, cos_v, sin_v * cos];
        mesh.vertex(normal.map(|c| c * radius), normal, [cos, 0.0, -sin], [u, v]);
    };
    let (wide, high) = (f64::from(columns), f64::from(rows));
    // Of the texture's first and last row each triangle at a pole has its own place.
    let pole = |vertex: &mut dyn FnMut(f64, f64, f64, [f64; 2]), v: f64, cos: f64| {
        for i in 0..columns {
            let u = (f64::from(i) + 0.5) / wide;
            vertex(u, TAU * (u - 0.5), v, [0.0, cos]);
        }
    };
    pole(&mut vertex, 0.0, 1.0);
    for j in 1..rows {
        let v = f64::from(j) / high;
        let (sin, cos) = sin_cos(PI * v);
        for i in 0..=columns {
            // Both ends of the row are one place, to the last bit.
            let angle = TAU * (f64::from(i % columns) / wide - 0.5);
            vertex(f64::from(i) / wide, angle, v, [sin, cos]);
        }
    }
    pole(&mut vertex, 1.0, -1.0);
    let last = columns + (rows - 2) * (columns + 1);
    let south = last + columns + 1;
    mesh.data.triangles.extend((0..columns).map(|i| [i, columns + i, columns + i + 1]));
    mesh.cells(columns, columns, rows - 2);
    mesh.data.triangles.extend((0..columns).map(|i| [last + i, south + i, last + i + 1]));
    mesh.finish()
}

/// A box whose edges along x, y and z have these lengths in metres, with sharp edges.
///
/// Each face has the whole texture: on the four sides up is +Y, on the top -Z, on the bottom +Z.
///
/// # Errors
/// [`SceneError::NotFinite`] and [`SceneError::OutOfRange`].
pub fn cuboid(size: [f32; 3]) -> Result<Mesh, SceneError> {
    /// Outwards, and to the right for who looks at it.
    const FACES: [[[f64; 3]; 2]; 6] = [
        [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0]],
        [[1.0, 0.0, 0.0], [0.0, 0.0, -1.0]],
        [[0.0, 0.0, -1.0], [-1.0, 0.0, 0.0]],
        [[-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]],
        [[0.0, 1.0, 0.0], [1.0, 0.0, 0.0]],
        [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0]],
    ];
    check_sizes("side of the box", &size)?;
    let half = size.map(|side| 0.5 * f64::from(side));
    let mut mesh = Builder::default();
    for [normal, right] in FACES {
        mesh.quad(normal, right, half);
    }
    mesh.finish()
}

/// A rectangle in the plane y = 0 that faces +Y, as a floor does: `size` is its extent along x and z in metres. As a wall that
/// faces +Z it stands after [`Transform::rotation`](super::Transform::rotation) by 90 degrees about +X.
///
/// It has the texture once: u runs along +X, v along +Z.
///
/// # Errors
/// [`SceneError::NotFinite`] and [`SceneError::OutOfRange`].
pub fn plane(size: [f32; 2]) -> Result<Mesh, SceneError> {
    check_sizes("side of the plane", &size)?;
    let [x, z] = size.map(|side| 0.5 * f64::from(side));
    let mut mesh = Builder::default();
    mesh.quad([0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [x, 0.0, z]);
    mesh.finish()
}

/// A tube along a torus knot: its middle winds on a torus of radius `radius` around the z axis whose ring is half as thick,
/// `windings[0]` times around the axis while it goes `windings[1]` times through the hole. `[2, 3]` is the trefoil. It reaches
/// 1.5 `radius` + `tube` far in x and y, 0.5 `radius` + `tube` in z, all in metres.
///
/// The windings, 1 to 64, have no common divisor. `segments`, each 3 to [`MAX_SEGMENTS`], go along the knot and around the
/// tube: `[256, 32]` is smooth for the trefoil. The texture lies around it once: u runs along the knot, v around the tube;
/// its borders meet. A tube that is thicker than its windings are apart goes through itself.
///
/// # Errors
/// [`SceneError::NotFinite`] and [`SceneError::OutOfRange`].
pub fn torus_knot(
    windings: [u32; 2],
    radius: f32,
    tube: f32,
    segments: [u32; 2],
) -> Result<Mesh, SceneError> {
    check_sizes("radius of the knot", &[radius])?;
    check_sizes("radius of the tube", &[tube])?;
    let [p, q] = windings.map(|w| w as f32);
    within("windings of the knot", &[p, q], 1.0, MAX_WINDINGS as f32)?;
    let divisor = greatest_common_divisor(windings);
    within("common divisor of the windings", &[divisor as f32], 1.0, 1.0)?;
    for count in segments {
        check_segments(count)?;
    }
    let [columns, rows] = segments;
    let (along, around) = (f64::from(columns), f64::from(rows));
    let tube = f64::from(tube);
    let sections: Vec<Section> = (0..columns)
        .map(|i| Section::new(windings.map(f64::from), f64::from(radius), TAU * f64::from(i) / along))
        .collect();
    let mut mesh = Builder::default();
    for j in 0..=rows {
        // Both ends are one place, to the last bit.
        let turn = sin_cos(TAU * f64::from(j % rows) / around);
        for i in 0..=columns {
            let section = &sections[(i % columns) as usize];
            let (position, normal, tangent) = section.point(tube, turn);
            mesh.vertex(position, normal, tangent, [f64::from(i) / along, f64::from(j) / around]);
        }
    }
    mesh.cells(0, columns, rows);
    mesh.finish()
}

/// A point along a knot: the curve lies on a torus, whose normal is one axis of the tube's cross-section.
struct Section {
    center: [f64; 3],
    /// Along the curve, away from the torus, and their cross product.
    axes: [[f64; 3]; 3],
    /// Length of the curve's derivative.
    speed: f64,
    /// The derivative of the torus's normal, along the curve and along the third axis.
    turning: [f64; 2],
    /// The curve's second derivative along the third axis.
    bending: f64,
}

impl Section {
    /// The point at an angle that goes once from 0 to 2 pi along the curve.
    fn new([p, q]: [f64; 2], radius: f64, t: f64) -> Self {
        let ((sp, cp), (sq, cq)) = (sin_cos(p * t), sin_cos(q * t));
        let r = 0.5 * radius;
        // Distance from the axis, and its derivatives.
        let (w, w1, w2) = (radius + r * cq, -r * q * sq, -r * q * q * cq);
        let center = [w * cp, w * sp, r * sq];
        let first = [w1 * cp - w * p * sp, w1 * sp + w * p * cp, r * q * cq];
        let second = [
            w2 * cp - 2.0 * w1 * p * sp - w * p * p * cp,
            w2 * sp + 2.0 * w1 * p * cp - w * p * p * sp,
            -r * q * q * sq,
        ];
        let out = [cq * cp, cq * sp, sq];
        let out_turns = [-q * sq * cp - p * cq * sp, -q * sq * sp + p * cq * cp, q * cq];
        let speed = dot(first, first).sqrt();
        let ahead = first.map(|c| c / speed);
        let side = cross(ahead, out);
        Self {
            center,
            axes: [ahead, out, side],
            speed,
            turning: [dot(out_turns, ahead), dot(out_turns, side)],
            bending: dot(second, side) / speed,
        }
    }

    /// Position, normal and tangent at sine and cosine of the angle around the tube. The tangent is the derivative along the
    /// curve: cross-sections lean and turn on the way.
    fn point(&self, tube: f64, (sin, cos): (f64, f64)) -> ([f64; 3], [f64; 3], [f64; 3]) {
        let [ahead, out, side] = self.axes;
        let mix = |a: f64, b: f64, c: f64| std::array::from_fn(|k| a * ahead[k] + b * out[k] + c * side[k]);
        let normal: [f64; 3] = mix(0.0, cos, sin);
        let position = std::array::from_fn(|k| self.center[k] + tube * normal[k]);
        let forward = self.speed + tube * (cos * self.turning[0] - sin * self.bending);
        let round = tube * self.turning[1];
        let tangent = mix(forward, -sin * round, cos * round);
        let length = dot(tangent, tangent).sqrt();
        // Where the tube is as thick as the curve is bent, nothing goes on along it.
        let tangent = if length > 0.0 { tangent.map(|c| c / length) } else { ahead };
        (position, normal, tangent)
    }
}

/// Attributes, rounded once.
#[derive(Default)]
struct Builder {
    data: MeshData,
}

impl Builder {
    fn vertex(&mut self, position: [f64; 3], normal: [f64; 3], [x, y, z]: [f64; 3], uv: [f64; 2]) {
        self.data.positions.push(position.map(|c| c as f32));
        self.data.normals.push(normal.map(|c| c as f32));
        self.data.tangents.push([x as f32, y as f32, z as f32, 1.0]);
        self.data.uvs[0].push(uv.map(|c| c as f32));
    }

    /// Two triangles for each cell of a grid of vertices that begins at `first`, one column more than it has cells.
    fn cells(&mut self, first: u32, columns: u32, rows: u32) {
        for j in 0..rows {
            for i in 0..columns {
                let a = first + j * (columns + 1) + i;
                let (b, c, d) = (a + 1, a + columns + 2, a + columns + 1);
                self.data.triangles.extend([[a, d, c], [a, c, b]]);
            }
        }
    }

    /// A face of a box with these half sides.
    fn quad(&mut self, normal: [f64; 3], right: [f64; 3], half: [f64; 3]) {
        let up = cross(normal, right);
        let first = self.data.positions.len() as u32;
        for [u, v] in [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]] {
            let at = |k: usize| (normal[k] + right[k] * (2.0 * u - 1.0) + up[k] * (1.0 - 2.0 * v)) * half[k];
            self.vertex(std::array::from_fn(at), normal, right, [u, v]);
        }
        self.cells(first, 1, 1);
    }

    fn finish(self) -> Result<Mesh, SceneError> {
        Mesh::new(self.data)
    }
}

fn check_sizes(what: &'static str, sizes: &[f32]) -> Result<(), SceneError> {
    within(what, sizes, MIN_SIZE, MAX_COORDINATE)
}

fn check_segments(count: u32) -> Result<(), SceneError> {
    within("number of segments", &[count as f32], 3.0, MAX_SEGMENTS as f32)
}

fn greatest_common_divisor([mut a, mut b]: [u32; 2]) -> u32 {
    while b != 0 {
        (a, b) = (b, a % b);
    }
    a
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    fn wide(v: [f32; 3]) -> [f64; 3] {
        v.map(f64::from)
    }

    fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
        [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
    }

    /// All of them, closed ones first.
    fn all() -> Vec<(&'static str, Mesh)> {
        vec![
            ("sphere", sphere(2.0, 48).unwrap()),
            ("odd sphere", sphere(0.5, 7).unwrap()),
            ("least sphere", sphere(1.0, 3).unwrap()),
            ("box", cuboid([1.0, 2.0, 3.0]).unwrap()),
            ("trefoil", torus_knot([2, 3], 1.0, 0.2, [256, 32]).unwrap()),
            ("other knot", torus_knot([3, 1], 4.0, 0.3, [300, 9]).unwrap()),
            ("plane", plane([3.0, 5.0]).unwrap()),
        ]
    }

    /// Area, and volume by the divergence theorem.
    fn measure(mesh: &Mesh) -> (f64, f64) {
        mesh.triangles().iter().fold((0.0, 0.0), |(area, volume), t| {
            let [a, b, c] = t.map(|v| wide(mesh.positions()[v as usize]));
            let normal = cross(minus(b, a), minus(c, a));
            (area + 0.5 * dot(normal, normal).sqrt(), volume + dot(a, normal) / 6.0)
        })
    }

    #[test]
    fn every_edge_of_what_is_closed_has_one_neighbour() {
        for (name, mesh) in all().iter().take(6) {
            let place = |v: u32| mesh.positions()[v as usize].map(|c| (c + 0.0).to_bits());
            let mut edges = BTreeMap::new();
            for &[a, b, c] in mesh.triangles() {
                for (from, to) in [(a, b), (b, c), (c, a)] {
                    *edges.entry((place(from), place(to))).or_insert(0) += 1;
                }
            }
            for (&(from, to), &count) in &edges {
                assert_eq!((count, edges.get(&(to, from))), (1, Some(&1)), "{name}");
            }
            assert!(mesh.used_vertices().is_none(), "{name} has vertices that no triangle uses");
        }
    }

    #[test]
    fn normals_point_outwards_and_tangents_along_the_texture() {
        for (name, mesh) in all() {
            for (&normal, &[x, y, z, w]) in mesh.normals().iter().zip(mesh.tangents()) {
                let (normal, tangent) = (wide(normal), wide([x, y, z]));
                assert!((dot(normal, normal) - 1.0).abs() < 1e-6, "{name}");
                assert!((dot(tangent, tangent) - 1.0).abs() < 1e-6, "{name}");
                assert!(dot(normal, tangent).abs() < 1e-6 && w == 1.0, "{name}");
            }
            for t in mesh.triangles() {
                let t = t.map(|v| v as usize);
                let [a, b, c] = t.map(|v| wide(mesh.positions()[v]));
                let [ua, ub, uc] = t.map(|v| mesh.uvs(0)[v].map(f64::from));
                let (p, q) = (minus(b, a), minus(c, a));
                let ([pu, pv], [qu, qv]) = ([ub[0] - ua[0], ub[1] - ua[1]], [uc[0] - ua[0], uc[1] - ua[1]]);
                let area = pu * qv - pv * qu;
                // Derivatives of the position by u and v; v runs down, so the texture is not mirrored.
                assert!(area < 0.0, "{name}: {area}");
                let to_right: [f64; 3] = std::array::from_fn(|k| (p[k] * qv - q[k] * pv) / area);
                let down: [f64; 3] = std::array::from_fn(|k| (q[k] * pu - p[k] * qu) / area);
                for v in t {
                    let [x, y, z, _] = mesh.tangents()[v];
                    let (normal, tangent) = (wide(mesh.normals()[v]), wide([x, y, z]));
                    assert!(dot(cross(p, q), normal) > 0.0, "{name}");
                    let cosine = dot(to_right, tangent) / dot(to_right, to_right).sqrt();
                    // Facets of coarse balls lie away from the tangents at their corners.
                    let least = if mesh.triangles().len() < 100 { 0.4 } else { 0.97 };
                    assert!(cosine > least, "{name}: {cosine}");
                    assert!(dot(down, cross(normal, tangent)) < 0.0, "{name}");
                }
            }
        }
    }

    #[test]
    fn areas_and_volumes_are_those_of_the_formulas() {
        let near = |found: (f64, f64), area: f64, volume: f64, part: f64| {
            let fits = |found: f64, exact: f64| (found / exact - 1.0).abs() < part;
            assert!(fits(found.0, area) && fits(found.1, volume), "{found:?} {area} {volume}");
        };
        near(measure(&sphere(2.0, 256).unwrap()), 4.0 * PI * 4.0, 4.0 / 3.0 * PI * 8.0, 5e-4);
        near(measure(&cuboid([1.0, 2.0, 3.0]).unwrap()), 22.0, 6.0, 1e-12);
        assert_eq!(measure(&plane([3.0, 5.0]).unwrap()), (15.0, 0.0));
        // Pappus: a round cross-section that stands across the curve and does not meet itself.
        let length: f64 =
            (0..4096).map(|k| Section::new([2.0, 3.0], 1.0, TAU * f64::from(k) / 4096.0).speed).sum();
        let length = length * TAU / 4096.0;
        let knot = torus_knot([2, 3], 1.0, 0.2, [1024, 96]).unwrap();
        near(measure(&knot), TAU * 0.2 * length, PI * 0.04 * length, 2e-3);
    }

    #[test]
    fn textures_are_upright() {
        let at = |mesh: &Mesh, u: f32, v: f32| {
            let found = mesh.uvs(0).iter().position(|&uv| uv == [u, v]).unwrap();
            mesh.positions()[found].map(|c| (c * 1e6 + 0.5).floor() / 1e6)
        };
        let ball = sphere(1.0, 8).unwrap();
        assert_eq!(at(&ball, 0.5, 0.5), [0.0, 0.0, 1.0]);
        assert_eq!(at(&ball, 0.75, 0.5), [1.0, 0.0, 0.0]);
        assert_eq!((at(&ball, 0.0, 0.5), at(&ball, 1.0, 0.5)), ([0.0, 0.0, -1.0], [0.0, 0.0, -1.0]));
        assert!(at(&ball, 0.5, 0.25)[1] > 0.5);
        let floor = plane([2.0, 4.0]).unwrap();
        assert_eq!((at(&floor, 0.0, 0.0), at(&floor, 1.0, 1.0)), ([-1.0, 0.0, -2.0], [1.0, 0.0, 2.0]));
        // The first face looks to +Z.
        let front = cuboid([2.0; 3]).unwrap();
        assert_eq!((at(&front, 0.0, 0.0), at(&front, 1.0, 1.0)), ([-1.0, 1.0, 1.0], [1.0, -1.0, 1.0]));
    }

    #[test]
    fn what_cannot_be_made_is_an_error() {
        for bad in [0.0, -1.0, f32::NAN, f32::INFINITY, 2e15] {
            assert!(
                sphere(bad, 8).is_err() && cuboid([1.0, bad, 1.0]).is_err() && plane([1.0, bad]).is_err()
            );
            assert!(torus_knot([2, 3], bad, 0.1, [8, 8]).is_err());
            assert!(torus_knot([2, 3], 1.0, bad, [8, 8]).is_err());
        }
        for bad in [0, 2, MAX_SEGMENTS + 1, u32::MAX] {
            assert!(sphere(1.0, bad).is_err() && torus_knot([2, 3], 1.0, 0.1, [8, bad]).is_err());
        }
        for bad in [[0, 1], [2, 0], [2, 4], [65, 2]] {
            assert!(torus_knot(bad, 1.0, 0.1, [8, 8]).is_err(), "{bad:?}");
        }
        assert!(sphere(1e15, 8).is_ok() && torus_knot([64, 63], 1e-3, 1e3, [3, 3]).is_ok());
    }

    /// The same numbers on every machine.
    #[test]
    fn bits_are_those_that_were_recorded() {
        let hash = |mesh: &Mesh| {
            let data = mesh.data();
            let numbers =
                [data.positions.as_flattened(), data.normals.as_flattened(), data.tangents.as_flattened()];
            let bytes: Vec<u8> = numbers.concat().iter().flat_map(|v| v.to_le_bytes()).collect();
            xxhash_rust::xxh3::xxh3_64(&bytes)
        };
        let knot = torus_knot([2, 3], 1.0, 0.25, [256, 32]).unwrap();
        let hashes = [&sphere(1.0, 64).unwrap(), &knot].map(hash);
        assert_eq!(hashes, [9_248_168_935_566_211_622, 14_185_504_055_957_117_666]);
    }
}
