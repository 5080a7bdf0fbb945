//! Catmull-Clark subdivision of quad cages (Catmull and Clark 1978), with smooth boundary curves.

use std::collections::BTreeMap;

use glam::{DVec2, DVec3};

use super::mesh::{Mesh, Vertex};

/// A mesh of quads without attributes.
#[derive(Clone, Debug, Default)]
pub struct Cage {
    /// Control points.
    pub points: Vec<DVec3>,
    /// Counter-clockwise seen from outside.
    pub quads: Vec<[u32; 4]>,
}

/// Adjacency of a control cage.
struct Neighbours {
    /// Faces at each edge, by its sorted ends.
    edges: BTreeMap<(u32, u32), Vec<u32>>,
}

impl Neighbours {
    fn of(quads: &[[u32; 4]]) -> Self {
        let mut edges: BTreeMap<(u32, u32), Vec<u32>> = BTreeMap::new();
        for (face, quad) in quads.iter().enumerate() {
            for i in 0..4 {
                edges.entry(sorted(quad[i], quad[(i + 1) % 4])).or_default().push(face as u32);
            }
        }
        Self { edges }
    }
}

fn sorted(a: u32, b: u32) -> (u32, u32) {
    if a < b { (a, b) } else { (b, a) }
}

impl Cage {
    /// One step: every quad becomes four.
    pub fn refined(&self) -> Self {
        let neighbours = Neighbours::of(&self.quads);
        let at = |i: u32| self.points[i as usize];
        let faces: Vec<DVec3> =
            self.quads.iter().map(|q| (at(q[0]) + at(q[1]) + at(q[2]) + at(q[3])) * 0.25).collect();
        let mut points = self.moved(&neighbours, &faces);
        let first_face = points.len() as u32;
        points.extend(&faces);
        let mut middles = BTreeMap::new();
        for (&(a, b), sides) in &neighbours.edges {
            let middle = match sides[..] {
                [f, g] => (at(a) + at(b) + faces[f as usize] + faces[g as usize]) * 0.25,
                _ => (at(a) + at(b)) * 0.5,
            };
            middles.insert((a, b), points.len() as u32);
            points.push(middle);
        }
        let mut quads = Vec::new();
        for (face, quad) in self.quads.iter().enumerate() {
            for i in 0..4 {
                let after = middles[&sorted(quad[i], quad[(i + 1) % 4])];
                let before = middles[&sorted(quad[(i + 3) % 4], quad[i])];
                quads.push([quad[i], after, first_face + face as u32, before]);
            }
        }
        Self { points, quads }
    }

    /// The old points in their new places.
    fn moved(&self, neighbours: &Neighbours, faces: &[DVec3]) -> Vec<DVec3> {
        let count = self.points.len();
        let mut face_sums = vec![(DVec3::ZERO, 0.0); count];
        for (face, quad) in self.quads.iter().enumerate() {
            for &i in quad {
                face_sums[i as usize].0 += faces[face];
                face_sums[i as usize].1 += 1.0;
            }
        }
        let (edge_sums, rims) = self.edge_sums(neighbours);
        (0..count)
            .map(|i| {
                let point = self.points[i];
                let (rim, ends) = rims[i];
                if ends > 0.0 {
                    return point * 0.75 + rim * (0.25 / ends);
                }
                let n = face_sums[i].1;
                let middles = (edge_sums[i] + point * n) * (0.5 / n);
                (face_sums[i].0 / n + middles * 2.0 + point * (n - 3.0)) / n
            })
            .collect()
    }

    /// For each point the sum over its neighbours, and the sum and number of those along a boundary.
    fn edge_sums(&self, neighbours: &Neighbours) -> (Vec<DVec3>, Vec<(DVec3, f64)>) {
        let mut sums = vec![DVec3::ZERO; self.points.len()];
        let mut rims = vec![(DVec3::ZERO, 0.0); self.points.len()];
        for (&(a, b), sides) in &neighbours.edges {
            for (i, j) in [(a, b), (b, a)] {
                sums[i as usize] += self.points[j as usize];
                if sides.len() == 1 {
                    rims[i as usize].0 += self.points[j as usize];
                    rims[i as usize].1 += 1.0;
                }
            }
        }
        (sums, rims)
    }

    /// Triangles on the limit surface; `keep` chooses quads by their centre.
    pub fn limit(&self, keep: impl Fn(DVec3) -> bool, uv: impl Fn(DVec3) -> DVec2) -> Mesh {
        let neighbours = Neighbours::of(&self.quads);
        let (edge_sums, rims) = self.edge_sums(&neighbours);
        let mut corners = vec![(DVec3::ZERO, 0.0); self.points.len()];
        for quad in &self.quads {
            for i in 0..4 {
                corners[quad[i] as usize].0 += self.points[quad[(i + 2) % 4] as usize];
                corners[quad[i] as usize].1 += 1.0;
            }
        }
        let places: Vec<DVec3> = (0..self.points.len())
            .map(|i| {
                let (rim, ends) = rims[i];
                if ends > 0.0 {
                    return (self.points[i] * 4.0 + rim * (2.0 / ends)) / 6.0;
                }
                let n = corners[i].1;
                (self.points[i] * (n * n) + edge_sums[i] * 4.0 + corners[i].0) / (n * (n + 5.0))
            })
            .collect();
        let mut normals = vec![DVec3::ZERO; places.len()];
        for quad in &self.quads {
            let [a, b, c, d] = quad.map(|i| places[i as usize]);
            let face = (c - a).cross(d - b);
            for &i in quad {
                normals[i as usize] += face;
            }
        }
        let mut mesh = Mesh::default();
        let mut known: BTreeMap<u32, u32> = BTreeMap::new();
        for quad in &self.quads {
            let [a, b, c, d] = quad.map(|i| places[i as usize]);
            if !keep((a + b + c + d) * 0.25) {
                continue;
            }
            let [a, b, c, d] = quad.map(|i| {
                *known.entry(i).or_insert_with(|| {
                    let position = places[i as usize];
                    let normal = normals[i as usize].normalize_or_zero();
                    mesh.push(Vertex { position, normal, uv: uv(position) })
                })
            });
            mesh.quad(a, b, c, d);
        }
        mesh
    }
}
