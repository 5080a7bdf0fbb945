//! Feature edges of meshes: creases, where two faces meet at an angle, and boundaries, where a face ends.
//!
//! Vertices are welded by position first, since soups of triangles and meshes whose normals are split have several at one place.
//! Faces count by their own normals. An edge of more than two faces is a crease unless all of them lie in one plane. Faces without
//! area, and slivers whose normal is nothing but rounding, are left out.
//!
//! Edges that hang together are one group. Picture by picture, groups that are small on the screen ([`EdgeGroup`]) and edges that are
//! dense there ([`EdgeLines::densities`]) are drawn thinner or not at all.
//!
//! Parts are told from scans, figures and terrain by their angles ([`FeatureEdges::is_of_part`]).
//!
//! Everything is a function of positions and triangles alone, in linear time but for the sort of the edges of one vertex.

mod density;
mod groups;
mod part;
mod weld;

pub use groups::EdgeGroup;

use super::{Mesh, MeshData, PrimitiveKind};
use density::densities;
use groups::group;
use overcoat_core::jobs::Jobs;
use part::Angles;
pub(super) use part::may_be_part;
use weld::weld;

/// Angle between the normals of two faces, in degrees, beyond which they meet at a crease. Chamfers of 45 degrees and the edges
/// of hexagons and octagons are sharp; cylinders of twelve sides (30 degrees) and balls of sixteen, whose diagonal neighbours
/// differ by 32, are round. Normals that loaders generate are smooth up to the same angle.
pub const CREASE_ANGLE: f32 = 40.0;

/// Cosine of [`CREASE_ANGLE`].
const CREASE_COSINE: f32 = 0.766_044_44;

/// Height of a face in terms of the mesh's largest coordinate below which its normal is rounding: 32 steps of numbers there.
const SLIVER: f64 = 4e-6;

/// Colour of the vertices of lines, which multiplies that of the material.
const LINE: [f32; 4] = [0.09, 0.09, 0.09, 1.0];

/// Faces whose normals one job computes.
const CHUNK: usize = 1 << 14;

/// Feature edges of a mesh, as lines.
#[derive(Clone, Debug)]
pub struct FeatureEdges {
    /// Creases.
    pub creases: EdgeLines,
    /// Edges of one face.
    pub boundary: EdgeLines,
    /// The mesh is a part: most faces are plane or turn by small angles, and the others meet at clear creases.
    pub is_of_part: bool,
}

/// Edges of one kind.
#[derive(Clone, Debug)]
pub struct EdgeLines {
    /// The lines.
    pub mesh: Mesh,
    /// Lines side by side on a unit of length around each line, beyond two on 1/16 of the mesh, and no less than the mean of its group.
    pub densities: Vec<f32>,
    /// The group of each line.
    pub group_of: Vec<u32>,
    /// The groups.
    pub groups: Vec<EdgeGroup>,
    /// Normals of the two faces of each line if the mesh is closed and its faces agree on what is outside: lines of which both
    /// are seen from behind are hidden. Empty if it is not.
    pub normals: Vec<[[f32; 3]; 2]>,
}

/// An edge that is drawn: its welded ends and the two first of its faces.
#[derive(Clone, Copy, Debug)]
struct Edge {
    ends: [u32; 2],
    faces: [u32; 2],
}

/// Side of a face: the end with the larger number, the face, and whether it runs from the lower to the larger.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
struct Side {
    to: u32,
    face: u32,
    forwards: bool,
}

/// Bytes that [`find_edges`] takes for a while.
#[must_use]
pub fn edge_bytes(mesh: &Mesh) -> u64 {
    let (faces, vertices) = (mesh.triangles().len() as u64, mesh.positions().len() as u64);
    // Normals, sides; buckets, order and numbers of vertices.
    faces.saturating_mul(12 + 3 * size_of::<Side>() as u64 + 12).saturating_add(vertices.saturating_mul(20))
}

/// Finds the feature edges of a mesh of triangles; of others there are none.
#[must_use]
pub fn find_edges(mesh: &Mesh, jobs: &Jobs) -> FeatureEdges {
    let faces = if mesh.kind() == PrimitiveKind::Triangles { mesh.triangles() } else { &[] };
    let welded = weld(mesh.positions());
    let normals = face_normals(mesh, faces, jobs);
    let corners: Vec<[u32; 3]> = faces.iter().map(|face| face.map(|v| welded.numbers[v as usize])).collect();
    let sides = sides_by_vertex(&corners, &normals, welded.first.len());

    let place = |end: u32| mesh.positions()[welded.first[end as usize] as usize];
    let (mut creases, mut boundary) = (Vec::new(), Vec::new());
    let (mut closed, mut angles) = (true, Angles::default());
    for (from, range) in sides.starts.windows(2).enumerate() {
        let own = &sides.list[range[0] as usize..range[1] as usize];
        for sides in own.chunk_by(|a, b| a.to == b.to) {
            let first = sides[0];
            let faces = [first.face, sides.get(1).unwrap_or(&first).face];
            let edge = Edge { ends: [from as u32, first.to], faces };
            match sides {
                [_] => boundary.push(edge),
                _ if is_crease(sides, &normals) => creases.push(edge),
                _ => {}
            }
            angles.add(cosine(sides, &normals), distance(place(edge.ends[0]), place(edge.ends[1])));
            closed &= matches!(sides, [a, b] if a.forwards != b.forwards);
        }
    }
    let normals = if closed { Some(&normals[..]) } else { None };
    let lines = |edges: Vec<Edge>| lines_of(edges, place, welded.first.len(), normals);
    FeatureEdges { creases: lines(creases), boundary: lines(boundary), is_of_part: angles.are_of_part() }
}

/// Cosine of the angle between the normals of the faces at an edge if there are two. Of two that run the same way one is inside out.
fn cosine(sides: &[Side], normals: &[[f32; 3]]) -> Option<f32> {
    let [a, b] = sides else { return None };
    let cosine = dot(a, b, normals);
    Some(if a.forwards == b.forwards { -cosine } else { cosine })
}

fn distance(a: [f32; 3], b: [f32; 3]) -> f64 {
    let along = |axis: usize| f64::from(b[axis]) - f64::from(a[axis]);
    (along(0) * along(0) + along(1) * along(1) + along(2) * along(2)).sqrt()
}

/// Cosine of the angle between the normals of two faces.
fn dot(a: &Side, b: &Side, normals: &[[f32; 3]]) -> f32 {
    let ([a, b, c], [x, y, z]) = (normals[a.face as usize], normals[b.face as usize]);
    a * x + b * y + c * z
}

/// True if the faces at an edge do not lie in one plane.
fn is_crease(sides: &[Side], normals: &[[f32; 3]]) -> bool {
    match cosine(sides, normals) {
        Some(cosine) => cosine < CREASE_COSINE,
        None => sides.iter().any(|side| dot(&sides[0], side, normals).abs() < CREASE_COSINE),
    }
}

/// Largest coordinate of a mesh.
fn size_of_mesh(mesh: &Mesh) -> f64 {
    let bounds = mesh.bounds();
    let larger = |size: f64, v: f64| if v.abs() > size && v.abs() < f64::INFINITY { v.abs() } else { size };
    bounds.min.iter().chain(&bounds.max).copied().fold(0.0, larger)
}

/// Unit normals of the faces; 0 for those without area and for slivers.
fn face_normals(mesh: &Mesh, faces: &[[u32; 3]], jobs: &Jobs) -> Vec<[f32; 3]> {
    let least = size_of_mesh(mesh) * SLIVER;
    let mut normals = vec![[0.0_f32; 3]; faces.len()];
    let mut parts: Vec<_> = normals.chunks_mut(CHUNK).zip(faces.chunks(CHUNK)).collect();
    jobs.for_each_mut(&mut parts, |_, (normals, faces)| {
        for (normal, face) in normals.iter_mut().zip(*faces) {
            *normal = face_normal(face.map(|v| mesh.positions()[v as usize]), least);
        }
    });
    normals
}

/// Unit normal of a face; 0 if its least height is no more than `least`.
fn face_normal(corners: [[f32; 3]; 3], least: f64) -> [f32; 3] {
    let [a, b, c] = corners.map(|corner| corner.map(f64::from));
    let to = |p: [f64; 3], q: [f64; 3]| [q[0] - p[0], q[1] - p[1], q[2] - p[2]];
    let squared = |[x, y, z]: [f64; 3]| x * x + y * y + z * z;
    let (u, v, w) = (to(a, b), to(a, c), to(b, c));
    let cross = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    let length = squared(cross).sqrt();
    let longest = [u, v, w].map(squared).into_iter().fold(0.0_f64, |a, b| if b > a { b } else { a }).sqrt();
    if length > least * longest { cross.map(|v| (v / length) as f32) } else { [0.0; 3] }
}

/// Sides of faces, sorted by the lower of their ends, then by the other, then by face.
struct Sides {
    list: Vec<Side>,
    /// Start of the sides of each vertex, and the end.
    starts: Vec<u32>,
}

fn sides_by_vertex(corners: &[[u32; 3]], normals: &[[f32; 3]], vertices: usize) -> Sides {
    let sides = |face: usize| {
        let ([a, b, c], normal) = (corners[face], normals[face]);
        let whole = normal != [0.0; 3] && a != b && b != c && c != a;
        let side = move |from: u32, to: u32| {
            let (low, high) = if from < to { (from, to) } else { (to, from) };
            (low as usize, Side { to: high, face: face as u32, forwards: from < to })
        };
        [side(a, b), side(b, c), side(c, a)].into_iter().filter(move |_| whole)
    };
    let mut starts = vec![0_u32; vertices + 2];
    for (low, _) in (0..corners.len()).flat_map(sides) {
        starts[low + 2] += 1;
    }
    for k in 2..starts.len() {
        starts[k] += starts[k - 1];
    }
    let mut list = vec![Side::default(); starts.last().copied().unwrap_or_default() as usize];
    for (low, side) in (0..corners.len()).flat_map(sides) {
        list[starts[low + 1] as usize] = side;
        starts[low + 1] += 1;
    }
    starts.pop();
    for range in starts.windows(2) {
        list[range[0] as usize..range[1] as usize].sort_unstable();
    }
    Sides { list, starts }
}

/// Densities, raised to the mean of each group: rims that are dense here and there are drawn alike all around.
fn no_less_than_groups(
    mut densities: Vec<f32>,
    edges: &[Edge],
    group_of: &[u32],
    groups: usize,
    place: impl Fn(u32) -> [f32; 3],
) -> Vec<f32> {
    let mut sums = vec![[0.0_f64; 2]; groups];
    for ((edge, &density), &group) in edges.iter().zip(&densities).zip(group_of) {
        let length = distance(place(edge.ends[0]), place(edge.ends[1]));
        let sum = &mut sums[group as usize];
        *sum = [sum[0] + length, sum[1] + length * f64::from(density)];
    }
    for (density, &group) in densities.iter_mut().zip(group_of) {
        let [length, sum] = sums[group as usize];
        let mean = (sum / length) as f32;
        *density = if mean > *density { mean } else { *density };
    }
    densities
}

/// Edges as lines.
fn lines_of(
    edges: Vec<Edge>,
    place: impl Fn(u32) -> [f32; 3] + Copy,
    vertices: usize,
    normals: Option<&[[f32; 3]]>,
) -> EdgeLines {
    let (group_of, groups) = group(&edges, place, vertices);
    let densities = no_less_than_groups(densities(&edges, place), &edges, &group_of, groups.len(), place);
    let mut numbers = vec![u32::MAX; vertices];
    let mut positions = Vec::new();
    let mut number = |end: u32| {
        let number = &mut numbers[end as usize];
        if *number == u32::MAX {
            *number = positions.len() as u32;
            positions.push(place(end));
        }
        *number
    };
    let triangles: Vec<[u32; 3]> =
        edges.iter().map(|edge| edge.ends.map(&mut number)).map(|[a, b]| [a, b, b]).collect();
    let colors = vec![LINE; positions.len()];
    let data = MeshData { positions, colors, triangles, kind: PrimitiveKind::Lines, ..MeshData::default() };
    // Taken from a mesh that has been checked.
    let mesh = Mesh::new(data).unwrap_or_else(|_| Mesh::empty());
    let normals = normals
        .map(|normals| edges.iter().map(|edge| edge.faces.map(|face| normals[face as usize])).collect());
    EdgeLines { mesh, densities, group_of, groups, normals: normals.unwrap_or_default() }
}

#[cfg(test)]
mod tests;
