//! Surfaces of nodes with coordinates: polygons, with normals, colours and coordinates of textures by corner, vertex or face.

use super::FORMAT;
use super::node::Node;
use super::reading::Nodes;
use crate::mesh_formats::{check_mesh, drawable};
use crate::polygon::Triangulator;
use crate::splitting::Variants;
use crate::warnings::{Warnings, counted};
use crate::{Context, LoadError};
use overcoat_core::color::srgb::srgb_to_linear;
use overcoat_scene::MeshData;
use std::rc::Rc;

/// Stands for no value.
const NONE: u32 = u32::MAX;
/// Copies of a vertex that are searched for one with equal values before another is made: bounds the work.
const SEARCHED: usize = 16;

/// Nodes of surfaces that refer to coordinates.
const KINDS: [&str; 9] = [
    "IndexedFaceSet",
    "IndexedQuadSet",
    "IndexedTriangleFanSet",
    "IndexedTriangleSet",
    "IndexedTriangleStripSet",
    "QuadSet",
    "TriangleFanSet",
    "TriangleSet",
    "TriangleStripSet",
];

/// Values that faces refer to.
#[derive(Debug, Default)]
pub(super) struct Values {
    pub(super) positions: Vec<[f32; 3]>,
    pub(super) normals: Vec<[f32; 3]>,
    pub(super) colors: Vec<[f32; 4]>,
    pub(super) uvs: Vec<[f32; 2]>,
}

/// Polygons: corners as a vertex and a place in the list of indices, and how many each has.
#[derive(Debug, Default)]
pub(super) struct Polygons {
    pub(super) corners: Vec<(u32, u32)>,
    pub(super) sizes: Vec<u32>,
}

impl Polygons {
    pub(super) fn push(&mut self, corners: &[(u32, u32)]) {
        self.corners.extend_from_slice(corners);
        self.sizes.push(corners.len() as u32);
    }

    /// Lists that end with -1.
    pub(super) fn lists(indices: &[i64]) -> Self {
        let mut out = Self::default();
        let mut size = 0_u32;
        for (&index, place) in indices.iter().zip(0_u32..) {
            if index < 0 {
                out.sizes.push(size);
                size = 0;
            } else {
                out.corners.push((u32::try_from(index).unwrap_or(NONE), place));
                size = size.saturating_add(1);
            }
        }
        if size > 0 {
            out.sizes.push(size);
        }
        out
    }

    /// Each polygon.
    pub(super) fn iter(&self) -> impl Iterator<Item = &[(u32, u32)]> {
        let mut rest = self.corners.as_slice();
        self.sizes.iter().map_while(move |&size| {
            let (own, after) = rest.split_at_checked(size as usize)?;
            rest = after;
            Some(own)
        })
    }

    /// The polygons of a node.
    fn of(node: &Node, vertices: usize) -> Option<Self> {
        let kind = node.kind.as_str();
        if !KINDS.contains(&kind) {
            return None;
        }
        let name = if kind == "IndexedFaceSet" { "coordIndex" } else { "index" };
        let indices = if kind.starts_with("Indexed") {
            node.integers(name)
        } else {
            // Sets without a list have the vertices in their order.
            let count = |name: &str| node.integers(name).into_iter().map(|v| u32::try_from(v).unwrap_or(0));
            let counts: Vec<u32> = match kind {
                "TriangleStripSet" => count("stripCount").collect(),
                "TriangleFanSet" => count("fanCount").collect(),
                _ => vec![u32::try_from(vertices).ok()?],
            };
            let mut list = Vec::new();
            let mut next = 0_i64;
            for count in counts {
                let left = (vertices as i64).saturating_sub(next).max(0);
                let count = i64::from(count).min(left);
                list.extend(next..next.saturating_add(count));
                list.push(-1);
                next = next.saturating_add(count);
            }
            list
        };
        let lists = Self::lists(&indices);
        if kind == "IndexedFaceSet" {
            return Some(lists);
        }
        let mut out = Self::default();
        for list in lists.iter() {
            match kind {
                "IndexedTriangleSet" | "TriangleSet" => {
                    list.chunks_exact(3).for_each(|triangle| out.push(triangle));
                }
                "IndexedQuadSet" | "QuadSet" => list.chunks_exact(4).for_each(|quad| out.push(quad)),
                "IndexedTriangleStripSet" | "TriangleStripSet" => {
                    for (k, window) in list.windows(3).enumerate() {
                        if let &[a, b, c] = window {
                            out.push(&if k % 2 == 0 { [a, b, c] } else { [b, a, c] });
                        }
                    }
                }
                "IndexedTriangleFanSet" | "TriangleFanSet" => {
                    let Some((&first, others)) = list.split_first() else { continue };
                    for pair in others.windows(2) {
                        if let &[b, c] = pair {
                            out.push(&[first, b, c]);
                        }
                    }
                }
                _ => {}
            }
        }
        Some(out)
    }
}

/// Place of a value, by lists of indices as IndexedFaceSet has them.
pub(super) struct Places {
    indices: Vec<i64>,
    per_vertex: bool,
}

impl Places {
    pub(super) fn new(node: &Node, indices: &str, per_vertex: &str) -> Self {
        Self { indices: node.integers(indices), per_vertex: node.flag(per_vertex, true) }
    }

    /// The place for a corner of a face.
    fn of(&self, (vertex, place): (u32, u32), face: u32) -> u32 {
        let (own, listed) = if self.per_vertex { (vertex, place) } else { (face, face) };
        if self.indices.is_empty() {
            return own;
        }
        let found = self.indices.get(listed as usize).and_then(|&index| u32::try_from(index).ok());
        found.unwrap_or(NONE)
    }
}

/// Linear colours of a node `Color` or `ColorRGBA`.
pub(super) fn colors(node: &Node) -> Vec<[f32; 4]> {
    if node.kind == "ColorRGBA" {
        let rows = node.rows::<4>("color");
        return rows.into_iter().map(|[r, g, b, a]| [linear(r), linear(g), linear(b), unit(a)]).collect();
    }
    opaque(node, "color")
}

fn unit(v: f32) -> f32 {
    if v > 0.0 { if v < 1.0 { v } else { 1.0 } } else { 0.0 }
}

fn linear(v: f32) -> f32 {
    srgb_to_linear(unit(v))
}

/// Linear colours of a field.
pub(super) fn opaque(node: &Node, field: &str) -> Vec<[f32; 4]> {
    let rows = node.rows::<3>(field);
    rows.into_iter().map(|[r, g, b]| [linear(r), linear(g), linear(b), 1.0]).collect()
}

impl Values {
    /// Values in the nodes within one.
    pub(super) fn read(node: &Node, nodes: &Nodes) -> Self {
        let mut values = Self::default();
        for (field, child) in &node.children {
            let Some(child) = nodes.get(*child) else { continue };
            if field == super::first::COLORS {
                values.colors = super::first::colors(&child);
            } else {
                values.take(&child, nodes);
            }
        }
        values
    }

    fn take(&mut self, child: &Rc<Node>, nodes: &Nodes) {
        match child.kind.as_str() {
            "Coordinate" | "CoordinateDouble" | "Coordinate3" => self.positions = child.rows("point"),
            "Normal" => self.normals = child.rows("vector"),
            "Color" | "ColorRGBA" => self.colors = colors(child),
            // Counted from the lower edge of pictures.
            "TextureCoordinate" | "TextureCoordinate2" => {
                self.uvs = child.rows::<2>("point").into_iter().map(|[u, v]| [u, 1.0 - v]).collect();
            }
            "MultiTextureCoordinate" => {
                let first = child.children.iter().find_map(|(_, child)| nodes.get(*child));
                if let Some(first) = first.filter(|first| first.kind == "TextureCoordinate") {
                    self.take(&first, nodes);
                }
            }
            _ => {}
        }
    }
}

/// The surface of a node that refers to coordinates; `None` for other nodes.
pub(super) fn read(
    node: &Node,
    nodes: &Nodes,
    context: &Context<'_>,
    warnings: &mut Warnings,
) -> Result<Option<MeshData>, LoadError> {
    let values = Values::read(node, nodes);
    let Some(polygons) = Polygons::of(node, values.positions.len()) else { return Ok(None) };
    let is_listed = node.kind == "IndexedFaceSet";
    let name = |name: &'static str| if is_listed { name } else { "" };
    let places = [
        Places::new(node, name("normalIndex"), "normalPerVertex"),
        Places::new(node, name("colorIndex"), "colorPerVertex"),
        Places::new(node, name("texCoordIndex"), ""),
    ];
    build(node, &values, &polygons, &places, context, warnings).map(Some)
}

/// The mesh of polygons.
pub(super) fn build(
    node: &Node,
    values: &Values,
    polygons: &Polygons,
    [normals, colors, uvs]: &[Places; 3],
    context: &Context<'_>,
    warnings: &mut Warnings,
) -> Result<MeshData, LoadError> {
    check_mesh(context, polygons.corners.len() as u64, polygons.corners.len() as u64)?;
    let (is_convex, is_ccw) = (node.flag("convex", true), node.flag("ccw", true));
    let mut data = MeshData::default();
    let mut variants = Variants::new(values.positions.len(), SEARCHED);
    let mut triangulator = Triangulator::default();
    let (mut bad, mut uncolored) = (0_u64, 0_u64);
    let there = |&(v, _): &(u32, u32)| values.positions.get(v as usize).is_some_and(|&p| drawable(p));
    for (polygon, face) in polygons.iter().zip(0_u32..) {
        if polygon.len() < 3 || !polygon.iter().all(there) {
            bad = bad.saturating_add(1);
            continue;
        }
        let mut emit = |triangle: [(u32, u32); 3]| {
            let triangle = if is_ccw { triangle } else { [triangle[0], triangle[2], triangle[1]] };
            let mut numbers = [0; 3];
            for (slot, corner) in numbers.iter_mut().zip(triangle) {
                let of =
                    |places: &Places, count: usize| if count == 0 { NONE } else { places.of(corner, face) };
                let key = [
                    of(normals, values.normals.len()),
                    of(colors, values.colors.len()),
                    of(uvs, values.uvs.len()),
                ];
                let Some((number, is_new)) = variants.number(corner.0 as usize, key) else { return };
                if is_new && !push(&mut data, values, corner.0, key) {
                    uncolored = uncolored.saturating_add(1);
                }
                *slot = number;
            }
            data.triangles.push(numbers);
        };
        match *polygon {
            [first, ref others @ ..] if is_convex => {
                others.windows(2).for_each(|pair| {
                    if let &[b, c] = pair {
                        emit([first, b, c]);
                    }
                });
            }
            _ => {
                let position =
                    |(v, _): (u32, u32)| values.positions.get(v as usize).copied().unwrap_or_default();
                triangulator.triangulate(polygon, position, emit);
            }
        }
    }
    if bad > 0 {
        let faces = counted(bad, "face");
        let reason = "fewer than three corners, or vertices missing, not finite or beyond 1e15";
        warnings.add(|| format!("{FORMAT}: {faces} left out: {reason}"));
    }
    if uncolored > 0 {
        let corners = counted(uncolored, "corner");
        warnings.add(|| format!("{FORMAT}: {corners} without a colour, where others have one: drawn white"));
    }
    if triangulator.given_up > 0 {
        let polygons = counted(triangulator.given_up, "concave polygon");
        warnings.add(|| format!("{FORMAT}: {polygons} with too many corners may be drawn wrongly"));
    }
    Ok(data)
}

/// Appends a vertex with its values. False if others have colours and it has none.
fn push(data: &mut MeshData, values: &Values, vertex: u32, [normal, color, uv]: [u32; 3]) -> bool {
    data.positions.push(values.positions.get(vertex as usize).copied().unwrap_or_default());
    if !values.normals.is_empty() {
        let sign = |n: [f32; 3]| if n.iter().all(|v| v.is_finite()) { n } else { [0.0; 3] };
        data.normals.push(values.normals.get(normal as usize).copied().map_or([0.0; 3], sign));
    }
    let own = values.colors.get(color as usize);
    if !values.colors.is_empty() {
        data.colors.push(own.copied().unwrap_or([1.0; 4]));
    }
    if !values.uvs.is_empty() {
        let known = |uv: [f32; 2]| if uv.iter().all(|v| v.is_finite()) { uv } else { [0.0; 2] };
        let [set, _] = &mut data.uvs;
        set.push(values.uvs.get(uv as usize).copied().map_or([0.0; 2], known));
    }
    own.is_some() || values.colors.is_empty()
}

/// Coordinates of textures for a mesh without: the longest side of its box is as wide as the texture, the next one up
/// (ISO/IEC 14772-1, 6.23).
pub(super) fn add_uvs(data: &mut MeshData) {
    let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
    for position in &data.positions {
        for (v, (low, high)) in position.iter().zip(low.iter_mut().zip(&mut high)) {
            (*low, *high) = (low.min(*v), high.max(*v));
        }
    }
    let mut sides: Vec<(usize, f32)> =
        low.iter().zip(&high).map(|(low, high)| high - low).enumerate().collect();
    sides.sort_by(|a, b| b.1.total_cmp(&a.1));
    let [(s, size), (t, _), ..] = sides.as_slice() else { return };
    let size = if *size > 0.0 { *size } else { 1.0 };
    let at = |list: &[f32; 3], k: usize| list.get(k).copied().unwrap_or_default();
    let of = |p: &[f32; 3]| [(at(p, *s) - at(&low, *s)) / size, 1.0 - (at(p, *t) - at(&low, *t)) / size];
    data.uvs = [data.positions.iter().map(of).collect(), Vec::new()];
}
