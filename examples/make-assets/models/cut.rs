//! Cuts a smooth surface along curves into regions that are then set in, set out or coloured.
//!
//! A surface is first split along every curve, so that each triangle lies in one region. Regions then move by their
//! own offset, walls join what came apart, and the outer rim of every step is rounded off by one strip whose normals
//! lean over the edge. The result is closed wherever the surface was.

use std::collections::{BTreeMap, BTreeSet};

use glam::DVec3;

use super::mesh::{Mesh, Vertex};

/// Vertices this close to a curve count as on it, metres.
const ON_CURVE: f64 = 2e-4;
/// Vertices closer to a curve than this share of an edge move onto it.
const SNAP: f64 = 0.4;
/// Share of the rim's own normal in the normal at its edge; the rest leans out.
const RIM_UPRIGHT: f64 = 0.35;

/// Signed distance of a point of the surface from a curve on it.
///
/// Metres along the surface near the curve, negative inside; further away only the sign counts.
pub type Curve = Box<dyn Fn(DVec3, DVec3) -> f64>;

/// Turns a distance in a plane of projection into one along the surface.
///
/// `gradient` is the unit gradient of `value` in space. The surface crosses the curve's cylinder at an angle, and a
/// gap of one width needs more of the distance where the surface falls away.
pub fn along_surface(value: f64, gradient: DVec3, normal: DVec3) -> f64 {
    let tangential = (gradient - normal * gradient.dot(normal)).length();
    if tangential < 0.25 { value * 4.0 } else { value / tangential }
}

/// Cut of a surface: changes the part inside or along a curve.
pub struct Cut {
    /// Curve that the cut follows.
    pub curve: Curve,
    /// Half width of the strip along the curve that becomes region `gap`; 0 for none.
    pub half_width: f64,
    /// Width of the rounded rim.
    pub rim: f64,
    /// Longest edge allowed near the curve; longer ones are halved first, so that small shapes are met.
    pub detail: f64,
    /// Region of the strip.
    pub gap: usize,
    /// Region of the inside; `None` leaves it as it is.
    pub inside: Option<usize>,
}

/// Displacement of a region's triangles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Offset {
    /// Inwards along the normals, metres; negative moves out.
    In(f64),
    /// Onto a plane of constant coordinate: (axis, value).
    Flat(usize, f64),
    /// None: the region is left out, and its walls lead down to the offset depth.
    Open(f64),
}

/// Geometry of one region.
#[derive(Clone, Copy, Debug)]
pub struct Region {
    /// Its place.
    pub offset: Offset,
    /// Index of the mesh that its triangles go to.
    pub output: usize,
    /// Index of the mesh of the walls that lead from it down into deeper regions.
    pub walls: usize,
    /// Distance over which its edges round down towards deeper regions; 0 for sharp edges.
    pub rounding: f64,
    /// An [`Offset::Open`] region whose depth is this region's thickness: gives it a back and outer edges.
    pub back: Option<usize>,
}

/// Splits and regroups `surface`; returns one mesh per output. Vertices keep their texture coordinates.
pub fn cut(mut surface: Mesh, cuts: &[Cut], regions: &[Region], outputs: usize) -> Vec<Mesh> {
    let mut pinned = vec![false; surface.vertices.len()];
    for cut in cuts {
        let (width, rim) = (cut.half_width, cut.rim);
        let mut levels = vec![-width, width];
        if rim > 0.0 {
            levels.push(width + rim);
            // Surfaces inside of their own region are lower, and their edge is hidden.
            if cut.inside.is_none() {
                levels.push(-width - rim);
            }
        }
        levels.dedup();
        for _ in 0..4 {
            surface = halved(&surface, &cut.curve, cut.detail, width + rim);
            pinned.resize(surface.vertices.len(), false);
        }
        for level in levels {
            snap(&mut surface, &cut.curve, level, &mut pinned);
            surface = split(&surface, &cut.curve, level);
            pinned.resize(surface.vertices.len(), true);
        }
    }
    let labels: Vec<usize> = surface.triangles.iter().map(|t| label(&surface, *t, cuts)).collect();
    assemble(&surface, &labels, regions, outputs)
}

/// Halves the edges longer than `longest` that the curve's neighbourhood of `reach` may meet.
fn halved(surface: &Mesh, curve: &Curve, longest: f64, reach: f64) -> Mesh {
    let mut out = Mesh { vertices: surface.vertices.clone(), triangles: Vec::new() };
    let mut middles: BTreeMap<(u32, u32), Option<u32>> = BTreeMap::new();
    let values: Vec<f64> = surface.vertices.iter().map(|v| curve(v.position, v.normal).abs()).collect();
    for triangle in &surface.triangles {
        let middle = [0, 1, 2].map(|corner| {
            let (a, b) = (triangle[corner], triangle[(corner + 1) % 3]);
            *middles.entry(if a < b { (a, b) } else { (b, a) }).or_insert_with(|| {
                let (va, vb) = (surface.vertices[a as usize], surface.vertices[b as usize]);
                let length = va.position.distance(vb.position);
                let near =
                    values[a as usize] < 0.5 * length + reach || values[b as usize] < 0.5 * length + reach;
                (length > longest && near).then(|| out.push(middle(va, vb)))
            })
        });
        let [a, b, c] = *triangle;
        match middle {
            [None, None, None] => out.triangles.push([a, b, c]),
            [Some(d), Some(e), Some(f)] => {
                out.triangles.extend([[a, d, f], [d, b, e], [f, e, c], [d, e, f]]);
            }
            // Turned so that the first edge is halved and, with two, the second as well.
            [Some(d), None, None] => out.triangles.extend([[a, d, c], [d, b, c]]),
            [None, Some(d), None] => out.triangles.extend([[b, d, a], [d, c, a]]),
            [None, None, Some(d)] => out.triangles.extend([[c, d, b], [d, a, b]]),
            [Some(d), Some(e), None] => two_halved(&mut out, [a, b, c], d, e),
            [None, Some(d), Some(e)] => two_halved(&mut out, [b, c, a], d, e),
            [Some(e), None, Some(d)] => two_halved(&mut out, [c, a, b], d, e),
        }
    }
    out
}

/// The triangles of a, b, c with middles `d` of a-b and `e` of b-c.
fn two_halved(out: &mut Mesh, [a, b, c]: [u32; 3], d: u32, e: u32) {
    out.triangles.push([d, b, e]);
    out.quad(a, d, e, c);
}

/// The middle of an edge, raised to the arc that its normals suggest.
fn middle(a: Vertex, b: Vertex) -> Vertex {
    let edge = b.position - a.position;
    let normal = (a.normal + b.normal).normalize_or_zero();
    let rise = (b.normal - a.normal).dot(edge) / 8.0;
    Vertex { position: (a.position + b.position) * 0.5 + normal * rise, normal, uv: (a.uv + b.uv) * 0.5 }
}

/// Moves vertices that lie close to a level set onto it, along one of their edges, so that splitting leaves few
/// slivers. Pinned vertices, which lie on earlier curves, and those of the surface's own boundary stay.
fn snap(surface: &mut Mesh, curve: &Curve, level: f64, pinned: &mut [bool]) {
    let values: Vec<f64> = surface.vertices.iter().map(|v| curve(v.position, v.normal) - level).collect();
    let mut edges: BTreeMap<(u32, u32), u32> = BTreeMap::new();
    for triangle in &surface.triangles {
        for corner in 0..3 {
            let (a, b) = (triangle[corner], triangle[(corner + 1) % 3]);
            *edges.entry(if a < b { (a, b) } else { (b, a) }).or_default() += 1;
        }
    }
    let mut fixed = pinned.to_vec();
    for (&(a, b), _) in edges.iter().filter(|(_, sides)| **sides == 1) {
        fixed[a as usize] = true;
        fixed[b as usize] = true;
    }
    let mut nearest: BTreeMap<u32, (f64, Vertex)> = BTreeMap::new();
    for &(a, b) in edges.keys() {
        let (at_a, at_b) = (values[a as usize], values[b as usize]);
        if at_a * at_b >= 0.0 {
            continue;
        }
        let t = at_a / (at_a - at_b);
        let close = if t < 0.5 { a } else { b };
        let share = if t < 0.5 { t } else { 1.0 - t };
        if share > SNAP || fixed[close as usize] {
            continue;
        }
        if nearest.get(&close).is_none_or(|(best, _)| share < *best) {
            nearest.insert(close, (share, crossing(surface, curve, level, (a, b), &values)));
        }
    }
    let mut around: BTreeMap<u32, Vec<[u32; 3]>> = BTreeMap::new();
    for triangle in &surface.triangles {
        for v in triangle.iter().filter(|v| nearest.contains_key(v)) {
            around.entry(*v).or_default().push(*triangle);
        }
    }
    for (vertex, (_, place)) in nearest {
        let old = surface.vertices[vertex as usize];
        let faces = |surface: &Mesh| -> Vec<DVec3> {
            let corner = |i: u32| surface.vertices[i as usize].position;
            around[&vertex]
                .iter()
                .map(|&[a, b, c]| (corner(b) - corner(a)).cross(corner(c) - corner(a)))
                .collect()
        };
        let before = faces(surface);
        surface.vertices[vertex as usize] = place;
        // A move that would fold or flatten a triangle is taken back.
        let sound = |(a, b): (&DVec3, &DVec3)| {
            a.dot(*b) > 0.15 * a.length_squared() && a.dot(*b) > 0.9 * a.length() * b.length()
        };
        if before.iter().zip(&faces(surface)).all(sound) {
            pinned[vertex as usize] = true;
        } else {
            surface.vertices[vertex as usize] = old;
        }
    }
    for (pin, value) in pinned.iter_mut().zip(&values) {
        *pin |= value.abs() < ON_CURVE;
    }
}

/// Splits every triangle that the level set of `curve` crosses.
pub fn split(surface: &Mesh, curve: &Curve, level: f64) -> Mesh {
    let mut out = Mesh { vertices: surface.vertices.clone(), triangles: Vec::new() };
    let values: Vec<f64> = surface
        .vertices
        .iter()
        .map(|v| {
            let value = curve(v.position, v.normal) - level;
            if value.abs() < ON_CURVE { 0.0 } else { value }
        })
        .collect();
    let mut crossings: BTreeMap<(u32, u32), u32> = BTreeMap::new();
    for triangle in &surface.triangles {
        if triangle.iter().all(|v| values[*v as usize] == 0.0) {
            out.triangles.push(*triangle);
            continue;
        }
        let mut polygon: [Vec<u32>; 2] = [Vec::new(), Vec::new()];
        for corner in 0..3 {
            let (a, b) = (triangle[corner], triangle[(corner + 1) % 3]);
            let (at_a, at_b) = (values[a as usize], values[b as usize]);
            if at_a <= 0.0 {
                polygon[0].push(a);
            }
            if at_a >= 0.0 {
                polygon[1].push(a);
            }
            if at_a * at_b < 0.0 {
                let edge = if a < b { (a, b) } else { (b, a) };
                let middle = *crossings
                    .entry(edge)
                    .or_insert_with(|| out.push(crossing(surface, curve, level, edge, &values)));
                polygon[0].push(middle);
                polygon[1].push(middle);
            }
        }
        for corners in &polygon {
            match corners[..] {
                [a, b, c] => out.triangles.push([a, b, c]),
                [a, b, c, d] => out.quad(a, b, c, d),
                _ => {}
            }
        }
    }
    out
}

/// The vertex where an edge meets a level, by regula falsi.
fn crossing(surface: &Mesh, curve: &Curve, level: f64, edge: (u32, u32), values: &[f64]) -> Vertex {
    let (a, b) = (surface.vertices[edge.0 as usize], surface.vertices[edge.1 as usize]);
    let between = |t: f64| Vertex {
        position: a.position.lerp(b.position, t),
        normal: a.normal.lerp(b.normal, t).normalize_or_zero(),
        uv: a.uv.lerp(b.uv, t),
    };
    let (mut low, mut high) = ((0.0, values[edge.0 as usize]), (1.0, values[edge.1 as usize]));
    let mut best = between(0.5);
    for _ in 0..6 {
        let t = low.0 - low.1 * (high.0 - low.0) / (high.1 - low.1);
        best = between(t);
        let value = curve(best.position, best.normal) - level;
        if value.abs() < 1e-7 {
            break;
        }
        if (value < 0.0) == (low.1 < 0.0) {
            low = (t, value);
        } else {
            high = (t, value);
        }
    }
    best
}

/// The region of a triangle: the last cut that claims it.
fn label(surface: &Mesh, triangle: [u32; 3], cuts: &[Cut]) -> usize {
    let mut centre = DVec3::ZERO;
    let mut normal = DVec3::ZERO;
    for i in triangle {
        centre += surface.vertices[i as usize].position / 3.0;
        normal += surface.vertices[i as usize].normal;
    }
    let normal = normal.normalize_or_zero();
    let mut region = 0;
    for cut in cuts {
        let value = (cut.curve)(centre, normal);
        if cut.half_width > 0.0 && value.abs() < cut.half_width {
            region = cut.gap;
        } else if value < 0.0 {
            region = cut.inside.unwrap_or(region);
        }
    }
    region
}

/// Builds the regions, their rims and the walls between them.
fn assemble(surface: &Mesh, labels: &[usize], regions: &[Region], outputs: usize) -> Vec<Mesh> {
    let mut owner: BTreeMap<(u32, u32), usize> = BTreeMap::new();
    for (triangle, &region) in surface.triangles.iter().zip(labels) {
        for corner in 0..3 {
            owner.insert((triangle[corner], triangle[(corner + 1) % 3]), region);
        }
    }
    // Along every step down, the sum of the directions that lead over the edge, by vertex and upper region.
    let mut over_edge: BTreeMap<(u32, usize), DVec3> = BTreeMap::new();
    let mut steps = Vec::new();
    for (&(a, b), &upper) in &owner {
        let Some(lower) = owner.get(&(b, a)).copied().or(regions[upper].back) else { continue };
        if depth(regions[lower].offset) <= depth(regions[upper].offset) {
            continue;
        }
        steps.push((a, b, upper, lower));
        let [va, vb] = [a, b].map(|i| surface.vertices[i as usize]);
        let out = (vb.position - va.position).cross(va.normal + vb.normal).normalize_or_zero();
        *over_edge.entry((a, upper)).or_default() += out;
        *over_edge.entry((b, upper)).or_default() += out;
    }
    let mut meshes = vec![Mesh::default(); outputs];
    let mut placed: BTreeMap<(u32, usize), u32> = BTreeMap::new();
    let mut backs: BTreeMap<(u32, usize), u32> = BTreeMap::new();
    let place = |v: u32, region: usize| -> Vertex {
        let vertex = surface.vertices[v as usize];
        let mut position = vertex.position;
        let mut normal = vertex.normal;
        match regions[region].offset {
            Offset::In(depth) | Offset::Open(depth) => position -= vertex.normal * depth,
            Offset::Flat(axis, value) => {
                position[axis] = value;
                normal = DVec3::ZERO;
                normal[axis] = if vertex.normal[axis] < 0.0 { -1.0 } else { 1.0 };
            }
        }
        if let (Some(out), true) = (over_edge.get(&(v, region)), regions[region].rounding > 0.0) {
            position -= vertex.normal * regions[region].rounding;
            normal = (vertex.normal * RIM_UPRIGHT + out.normalize_or_zero()).normalize();
        }
        Vertex { position, normal, uv: vertex.uv }
    };
    for (triangle, &region) in surface.triangles.iter().zip(labels) {
        if matches!(regions[region].offset, Offset::Open(_)) {
            continue;
        }
        let mesh = &mut meshes[regions[region].output];
        let corners =
            triangle.map(|v| *placed.entry((v, region)).or_insert_with(|| mesh.push(place(v, region))));
        mesh.triangles.push(corners);
        if let Some(back) = regions[region].back {
            let [a, b, c] = triangle.map(|v| {
                *backs.entry((v, region)).or_insert_with(|| {
                    let vertex = place(v, back);
                    mesh.push(Vertex { normal: -vertex.normal, ..vertex })
                })
            });
            mesh.triangles.push([a, c, b]);
        }
    }
    let mut around: BTreeMap<u32, BTreeSet<usize>> = BTreeMap::new();
    for (triangle, &region) in surface.triangles.iter().zip(labels) {
        for &v in triangle {
            around.entry(v).or_default().insert(region);
        }
    }
    for (a, b, upper, lower) in steps {
        let mesh = &mut meshes[regions[upper].walls];
        // A wall meets every region between its two ends, so that three regions at a point leave no crack.
        let mut chain = |v: u32| -> Vec<u32> {
            let (top, bottom) = (depth(regions[upper].offset), depth(regions[lower].offset));
            let mut between: Vec<usize> = around[&v]
                .iter()
                .copied()
                .filter(|r| depth(regions[*r].offset) > top && depth(regions[*r].offset) < bottom)
                .collect();
            between.sort_by(|a, b| depth(regions[*a].offset).total_cmp(&depth(regions[*b].offset)));
            between.insert(0, upper);
            between.push(lower);
            let normal = over_edge[&(v, upper)].normalize_or(surface.vertices[v as usize].normal);
            let wall = |region| Vertex { normal, ..place(v, region) };
            between.into_iter().map(|region| mesh.push(wall(region))).collect()
        };
        let (left, right) = (chain(a), chain(b));
        zip(mesh, &left, &right);
    }
    meshes
}

/// Joins two chains that run down side by side, seen from outside.
fn zip(mesh: &mut Mesh, left: &[u32], right: &[u32]) {
    let (mut i, mut j) = (0, 0);
    let share = |k: usize, chain: &[u32]| (k + 1) as f64 / chain.len() as f64;
    while i + 1 < left.len() || j + 1 < right.len() {
        let step_left = j + 1 == right.len() || (i + 1 < left.len() && share(i, left) <= share(j, right));
        let triangle = if step_left {
            i += 1;
            [left[i - 1], left[i], right[j]]
        } else {
            j += 1;
            [left[i], right[j], right[j - 1]]
        };
        let [a, b, c] = triangle.map(|k| mesh.vertices[k as usize].position);
        if a != b && b != c && c != a {
            mesh.triangles.push(triangle);
        }
    }
}

/// Orders regions from the outside in.
fn depth(offset: Offset) -> f64 {
    match offset {
        Offset::In(depth) | Offset::Open(depth) => depth,
        Offset::Flat(..) => 1e3,
    }
}
