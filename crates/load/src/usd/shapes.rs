//! Cubes, spheres, cylinders, cones, capsules and planes as polygons with texture coordinates (UsdGeomCube and others).

use super::compose::Composed;
use overcoat_core::math::double::sin_cos;
use std::f64::consts::{PI, TAU};

/// Segments around an axis.
const AROUND: u32 = 48;

/// A shape as a mesh has it.
#[derive(Debug, Default)]
pub(super) struct Shape {
    pub(super) points: Vec<[f32; 3]>,
    /// One for each point; zero where faces are flat.
    pub(super) normals: Vec<[f32; 3]>,
    pub(super) uvs: Vec<[f32; 2]>,
    pub(super) triangles: Vec<[u32; 3]>,
}

impl Shape {
    fn vertex(&mut self, point: [f64; 3], normal: [f64; 3], uv: [f64; 2]) {
        self.points.push(point.map(|v| v as f32));
        self.normals.push(normal.map(|v| v as f32));
        self.uvs.push(uv.map(|v| v as f32));
    }

    /// A rectangle around a centre with two half sides, whose cross product is the normal.
    fn rectangle(&mut self, center: [f64; 3], [a, b]: [[f64; 3]; 2], normal: [f64; 3]) {
        let first = self.points.len() as u32;
        for [u, v] in [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]] {
            let at = |k: usize| {
                let of = |list: [f64; 3]| list.get(k).copied().unwrap_or_default();
                of(center) + of(a) * (2.0 * u - 1.0) + of(b) * (2.0 * v - 1.0)
            };
            self.vertex([at(0), at(1), at(2)], normal, [u, v]);
        }
        for [a, b, c] in [[0, 1, 2], [0, 2, 3]] {
            self.triangles.push([a, b, c].map(|k: u32| first.saturating_add(k)));
        }
    }

    /// Turns a profile about +Z: points of radius and height from below to above, each with its normal in the same way.
    fn turned(profile: &[([f64; 2], [f64; 2])]) -> Self {
        let mut out = Self::default();
        let columns = AROUND.saturating_add(1);
        for (row, ([radius, height], [outward, up])) in profile.iter().enumerate() {
            for k in 0..columns {
                let u = f64::from(k) / f64::from(AROUND);
                let (sin, cos) = sin_cos(TAU * u);
                let rows = profile.len().saturating_sub(1).max(1) as f64;
                let v = row as f64 / rows;
                out.vertex(
                    [radius * cos, radius * sin, *height],
                    [outward * cos, outward * sin, *up],
                    [u, v],
                );
            }
        }
        for (row, pair) in profile.windows(2).enumerate() {
            let [([low, bottom], _), ([high, top], _)] = pair else { continue };
            // Edges between a disc and what follows are there twice.
            if low == high && bottom == top {
                continue;
            }
            for k in 0..AROUND {
                let a = (row as u32).saturating_mul(columns).saturating_add(k);
                let [b, c] = [a.saturating_add(1), a.saturating_add(columns)];
                let d = c.saturating_add(1);
                if *low > 0.0 {
                    out.triangles.push([a, b, d]);
                }
                if *high > 0.0 {
                    out.triangles.push([a, d, c]);
                }
            }
        }
        out
    }

    /// Turns the axis +Z to another.
    fn along(mut self, axis: &str) -> Self {
        for list in [&mut self.points, &mut self.normals] {
            for point in list {
                let [x, y, z] = *point;
                *point = match axis {
                    "X" => [z, x, y],
                    "Y" => [y, z, x],
                    _ => [x, y, z],
                };
            }
        }
        self
    }
}

/// A quarter or half of a circle as a profile, between two angles from below.
fn arc(radius: f64, center: f64, from: f64, to: f64) -> impl Iterator<Item = ([f64; 2], [f64; 2])> {
    const ROWS: u32 = 24;
    (0..=ROWS).map(move |k| {
        let (sin, cos) = sin_cos(from + (to - from) * f64::from(k) / f64::from(ROWS));
        // At the poles, the radius is zero.
        let wide = if sin.abs() < 1e-12 { 0.0 } else { sin };
        ([radius * wide, center - radius * cos], [wide, -cos])
    })
}

/// The shape of a prim; `None` for other types.
pub(super) fn of(prim: &Composed, type_name: &str) -> Option<Shape> {
    let number = |name: &str, default: f64| prim.number(name).unwrap_or(default);
    let axis = prim.text("axis").unwrap_or_else(|| "Z".to_owned());
    let disc = |radius: f64, height: f64, up: f64| {
        let [inner, outer] = [([0.0, height], [0.0, up]), ([radius, height], [0.0, up])];
        if up < 0.0 { [inner, outer] } else { [outer, inner] }
    };
    Some(match type_name {
        "Cube" => {
            let h = number("size", 2.0) / 2.0;
            let mut cube = Shape::default();
            for axis in ["X", "Y", "Z"] {
                for side in [1.0, -1.0] {
                    let mut face = Shape::default();
                    face.rectangle(
                        [0.0, 0.0, side * h],
                        [[h, 0.0, 0.0], [0.0, side * h, 0.0]],
                        [0.0, 0.0, side],
                    );
                    let first = cube.points.len() as u32;
                    let face = face.along(axis);
                    cube.points.extend(face.points);
                    cube.normals.extend(face.normals);
                    cube.uvs.extend(face.uvs);
                    cube.triangles.extend(face.triangles.iter().map(|t| t.map(|k| k.saturating_add(first))));
                }
            }
            cube
        }
        "Sphere" => Shape::turned(&arc(number("radius", 1.0), 0.0, 0.0, PI).collect::<Vec<_>>()),
        "Cylinder" => {
            let (radius, half) = (number("radius", 1.0), number("height", 2.0) / 2.0);
            let side = [([radius, -half], [1.0, 0.0]), ([radius, half], [1.0, 0.0])];
            let all = [disc(radius, -half, -1.0), side, disc(radius, half, 1.0)];
            Shape::turned(all.as_flattened()).along(&axis)
        }
        "Cone" => {
            let (radius, height) = (number("radius", 1.0), number("height", 2.0));
            let length = (radius * radius + height * height).sqrt();
            let normal = if length > 0.0 { [height / length, radius / length] } else { [1.0, 0.0] };
            let side = [([radius, -height / 2.0], normal), ([0.0, height / 2.0], normal)];
            let all = [disc(radius, -height / 2.0, -1.0), side];
            Shape::turned(all.as_flattened()).along(&axis)
        }
        "Capsule" => {
            let (radius, half) = (number("radius", 0.5), number("height", 1.0) / 2.0);
            let profile = arc(radius, -half, 0.0, PI / 2.0).chain(arc(radius, half, PI / 2.0, PI));
            Shape::turned(&profile.collect::<Vec<_>>()).along(&axis)
        }
        "Plane" => {
            let (w, l) = (number("width", 2.0) / 2.0, number("length", 2.0) / 2.0);
            let mut plane = Shape::default();
            plane.rectangle([0.0; 3], [[w, 0.0, 0.0], [0.0, l, 0.0]], [0.0, 0.0, 1.0]);
            plane.along(&axis)
        }
        _ => return None,
    })
}
