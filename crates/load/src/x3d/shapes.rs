//! Boxes, spheres, cones, cylinders, fields of heights and extrusions.

use super::FORMAT;
use super::faces::{Places, Polygons, Values, build};
use super::node::Node;
use super::reading::Nodes;
use crate::mesh_formats::check_mesh;
use crate::warnings::Warnings;
use crate::{Context, LoadError};
use overcoat_core::math::double::sin_cos;
use overcoat_scene::MeshData;
use std::f64::consts::{PI, TAU};

/// Segments around an axis, and from pole to pole of a sphere.
const AROUND: u32 = 48;
const ROWS: u32 = 24;

/// A point of a profile: radius and height, its normal in the same way, and its v from below.
type Point = ([f64; 2], [f64; 2], f64);

#[derive(Default)]
struct Shape {
    data: MeshData,
}

impl Shape {
    fn vertex(&mut self, position: [f64; 3], normal: [f64; 3], [u, v]: [f64; 2]) {
        self.data.positions.push(position.map(|v| v as f32));
        self.data.normals.push(normal.map(|v| v as f32));
        let [set, _] = &mut self.data.uvs;
        set.push([u as f32, 1.0 - v as f32]);
    }

    fn triangle(&mut self, first: u32, corners: [u32; 3]) {
        self.data.triangles.push(corners.map(|k| first.saturating_add(k)));
    }

    /// Turns two points about the axis, from the back on counter-clockwise as seen from above.
    fn band(&mut self, low: Point, high: Point) {
        let first = self.data.positions.len() as u32;
        for k in 0..=AROUND {
            let u = f64::from(k) / f64::from(AROUND);
            let (sin, cos) = sin_cos(TAU * u);
            for ([radius, height], [outward, up], v) in [low, high] {
                self.vertex(
                    [-radius * sin, height, -radius * cos],
                    [-outward * sin, up, -outward * cos],
                    [u, v],
                );
            }
        }
        for k in 0..AROUND {
            let k = k.saturating_mul(2);
            let [b, c, d] = [1, 2, 3].map(|step: u32| k.saturating_add(step));
            // One triangle is left at a point in which they meet.
            if low.0[0] > 0.0 {
                self.triangle(first, [k, c, d]);
            }
            if high.0[0] > 0.0 {
                self.triangle(first, [k, d, b]);
            }
        }
    }

    fn disc(&mut self, radius: f64, height: f64, up: f64) {
        let first = self.data.positions.len() as u32;
        self.vertex([0.0, height, 0.0], [0.0, up, 0.0], [0.5, 0.5]);
        for k in 0..=AROUND {
            let (sin, cos) = sin_cos(TAU * f64::from(k) / f64::from(AROUND));
            let uv = [0.5 + 0.5 * sin, 0.5 + 0.5 * cos];
            self.vertex([radius * sin, height, -up * radius * cos], [0.0, up, 0.0], uv);
        }
        for k in 0..AROUND {
            let (a, b) = (k.saturating_add(1), k.saturating_add(2));
            self.triangle(first, [0, b, a]);
        }
    }

    /// Adds the faces of a box that are there.
    fn cuboid(&mut self, [x, y, z]: [f64; 3], is_there: impl Fn(&str) -> bool) {
        // Normal, and the ways right and up as one sees it from outside.
        const FACES: [(&str, [[f64; 3]; 3]); 6] = [
            ("front", [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]),
            ("back", [[0.0, 0.0, -1.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]),
            ("right", [[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]]),
            ("left", [[-1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]]),
            ("top", [[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]]),
            ("bottom", [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]),
        ];
        for (_, [normal, right, up]) in FACES.iter().filter(|(name, _)| is_there(name)) {
            let first = self.data.positions.len() as u32;
            for [u, v] in [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]] {
                let ([nx, ny, nz], [rx, ry, rz], [ux, uy, uz]) = (*normal, *right, *up);
                let (r, w) = (2.0 * u - 1.0, 2.0 * v - 1.0);
                let position =
                    [x * (nx + r * rx + w * ux), y * (ny + r * ry + w * uy), z * (nz + r * rz + w * uz)];
                self.vertex(position, *normal, [u, v]);
            }
            self.triangle(first, [0, 1, 2]);
            self.triangle(first, [0, 2, 3]);
        }
    }
}

/// The mesh of a shape that is told by numbers; `None` for other nodes.
pub(super) fn read(node: &Node) -> Option<MeshData> {
    let mut shape = Shape::default();
    match node.kind.as_str() {
        "Box" => {
            let half = node.fixed("size", [2.0; 3]).map(|side| side / 2.0);
            shape.cuboid(half, |face| node.flag(face, true));
        }
        "Sphere" => {
            let radius = node.number("radius", 1.0);
            let point = |row: u32| -> Point {
                let v = f64::from(row) / f64::from(ROWS);
                let (sin, cos) = sin_cos(PI * v);
                // At the poles, the radius is zero.
                let sin = if row == 0 || row == ROWS { 0.0 } else { sin };
                ([radius * sin, -radius * cos], [sin, -cos], v)
            };
            (0..ROWS).for_each(|row| shape.band(point(row), point(row.saturating_add(1))));
        }
        "Cylinder" => {
            let (radius, half) = (node.number("radius", 1.0), node.number("height", 2.0) / 2.0);
            if node.flag("side", true) {
                shape.band(([radius, -half], [1.0, 0.0], 0.0), ([radius, half], [1.0, 0.0], 1.0));
            }
            if node.flag("top", true) {
                shape.disc(radius, half, 1.0);
            }
            if node.flag("bottom", true) {
                shape.disc(radius, -half, -1.0);
            }
        }
        "Cone" => {
            let (radius, height) = (node.number("bottomRadius", 1.0), node.number("height", 2.0));
            let length = (radius * radius + height * height).sqrt();
            let normal = if length > 0.0 { [height / length, radius / length] } else { [1.0, 0.0] };
            if node.flag("side", true) {
                shape.band(([radius, -height / 2.0], normal, 0.0), ([0.0, height / 2.0], normal, 1.0));
            }
            if node.flag("bottom", true) {
                shape.disc(radius, -height / 2.0, -1.0);
            }
        }
        _ => return None,
    }
    Some(shape.data)
}

/// The mesh of a field of heights.
pub(super) fn elevation(
    node: &Node,
    nodes: &Nodes,
    context: &Context<'_>,
    warnings: &mut Warnings,
) -> Result<Option<MeshData>, LoadError> {
    let side = |name: &str| node.integers(name).first().and_then(|&v| u32::try_from(v).ok()).unwrap_or(0);
    let (columns, rows) = (side("xDimension"), side("zDimension"));
    let heights = node.rows::<1>("height");
    let count = u64::from(columns).saturating_mul(rows.into());
    if count > heights.len() as u64 || columns < 2 || rows < 2 {
        warnings.add(|| {
            format!(
                "{FORMAT}: an ElevationGrid of {columns} x {rows} with {} heights is left out",
                heights.len()
            )
        });
        return Ok(None);
    }
    check_mesh(context, count.saturating_mul(2), count)?;
    let spacing = [node.number("xSpacing", 1.0), node.number("zSpacing", 1.0)];
    let mut values = Values::read(node, nodes);
    values.positions.clear();
    let own_uvs = values.uvs.is_empty();
    let mut heights = heights.iter();
    for j in 0..rows {
        for i in 0..columns {
            let [height] = heights.next().copied().unwrap_or_default();
            let [x, z] = [f64::from(i) * spacing[0], f64::from(j) * spacing[1]];
            values.positions.push([x as f32, height, z as f32]);
            if own_uvs {
                let part = |k: u32, all: u32| k as f32 / all.saturating_sub(1) as f32;
                values.uvs.push([part(i, columns), 1.0 - part(j, rows)]);
            }
        }
    }
    let mut polygons = Polygons::default();
    grid(&mut polygons, columns, rows);
    let places = ["normalPerVertex", "colorPerVertex", ""].map(|per| Places::new(node, "", per));
    build(node, &values, &polygons, &places, context, warnings).map(Some)
}

/// Quadrangles between the vertices of a grid, which face the way of rows x columns.
fn grid(polygons: &mut Polygons, columns: u32, rows: u32) {
    for j in 0..rows.saturating_sub(1) {
        for i in 0..columns.saturating_sub(1) {
            let at = |i: u32, j: u32| {
                let vertex = j.saturating_mul(columns).saturating_add(i);
                (vertex, vertex)
            };
            let (right, below) = (i.saturating_add(1), j.saturating_add(1));
            polygons.push(&[at(i, j), at(i, below), at(right, below), at(right, j)]);
        }
    }
}

/// The mesh of an extrusion.
pub(super) fn extrusion(
    node: &Node,
    context: &Context<'_>,
    warnings: &mut Warnings,
) -> Result<Option<MeshData>, LoadError> {
    let or =
        |rows: Vec<[f32; 2]>, otherwise: &[[f32; 2]]| if rows.is_empty() { otherwise.to_vec() } else { rows };
    let square = [[1.0, 1.0], [1.0, -1.0], [-1.0, -1.0], [-1.0, 1.0], [1.0, 1.0]];
    let section = or(node.rows("crossSection"), &square);
    let scales = or(node.rows("scale"), &[[1.0; 2]]);
    let spine: Vec<[f64; 3]> = match node.rows::<3>("spine") {
        rows if rows.is_empty() => vec![[0.0; 3], [0.0, 1.0, 0.0]],
        rows => rows.into_iter().map(|row| row.map(f64::from)).collect(),
    };
    let turns = node.rows::<4>("orientation");
    if spine.len() < 2 || section.len() < 2 {
        warnings.add(|| format!("{FORMAT}: an Extrusion of fewer than two points is left out"));
        return Ok(None);
    }
    let count = (spine.len() as u64).saturating_mul(section.len() as u64);
    check_mesh(context, count.saturating_mul(2), count.saturating_mul(2))?;
    let mut values = Values::default();
    for (k, (&[x, y, z], axes)) in spine.iter().zip(super::spine::axes(&spine)).enumerate() {
        let [sx, sz] = scales.get(k).or(scales.last()).copied().unwrap_or([1.0; 2]).map(f64::from);
        let turn = turns.get(k).or(turns.last()).map_or([0.0, 0.0, 1.0, 0.0], |turn| turn.map(f64::from));
        for &[a, b] in &section {
            let [px, py, pz] = super::spine::turned([f64::from(a) * sx, 0.0, f64::from(b) * sz], turn);
            let [ax, ay, az] = axes;
            let at = |k: fn([f64; 3]) -> f64| px * k(ax) + py * k(ay) + pz * k(az);
            let point = [at(|v| v[0]) + x, at(|v| v[1]) + y, at(|v| v[2]) + z];
            values.positions.push(point.map(|v| v as f32));
        }
    }
    let columns = section.len() as u32;
    let mut polygons = Polygons::default();
    // Rows go along the spine here, so that faces are to be seen from the other side than those of a field of heights.
    grid(&mut polygons, columns, spine.len() as u32);
    polygons.corners.chunks_exact_mut(4).for_each(<[_]>::reverse);
    let is_closed = section.first() == section.last();
    let end = if is_closed { columns.saturating_sub(1) } else { columns };
    let last = (spine.len() as u32).saturating_sub(1).saturating_mul(columns);
    if end > 2 && node.flag("beginCap", true) {
        polygons.push(&(0..end).rev().map(|v| (v, v)).collect::<Vec<_>>());
    }
    if end > 2 && node.flag("endCap", true) {
        polygons.push(&(0..end).map(|v| (last.saturating_add(v), v)).collect::<Vec<_>>());
    }
    let places = [(); 3].map(|()| Places::new(node, "", ""));
    build(node, &values, &polygons, &places, context, warnings).map(Some)
}
