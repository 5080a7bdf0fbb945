//! Triangle meshes under construction: vertices with normals and texture coordinates, counter-clockwise triangles.

use glam::{DMat3, DVec2, DVec3};

/// A corner of triangles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vertex {
    /// Metres.
    pub position: DVec3,
    /// Unit length.
    pub normal: DVec3,
    /// Texture coordinates, v downwards as in glTF.
    pub uv: DVec2,
}

impl Vertex {
    /// A vertex without texture coordinates.
    pub fn new(position: DVec3, normal: DVec3) -> Self {
        Self { position, normal: normal.normalize_or_zero(), uv: DVec2::ZERO }
    }
}

/// Triangles over shared vertices.
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    /// The corners.
    pub vertices: Vec<Vertex>,
    /// Counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
}

impl Mesh {
    /// Adds a vertex and returns its index.
    pub fn push(&mut self, vertex: Vertex) -> u32 {
        self.vertices.push(vertex);
        self.vertices.len() as u32 - 1
    }

    /// Adds two triangles for the quad a, b, c, d, split along its shorter diagonal; collapsed halves are left out.
    pub fn quad(&mut self, a: u32, b: u32, c: u32, d: u32) {
        let at = |i: u32| self.vertices[i as usize].position;
        let halves = if at(a).distance_squared(at(c)) <= at(b).distance_squared(at(d)) {
            [[a, b, c], [a, c, d]]
        } else {
            [[a, b, d], [b, c, d]]
        };
        for [i, j, k] in halves {
            if at(i) != at(j) && at(j) != at(k) && at(k) != at(i) {
                self.triangles.push([i, j, k]);
            }
        }
    }

    /// A grid of `rows` x `columns` vertices; rows run downwards and columns to the right seen from outside.
    pub fn grid(rows: usize, columns: usize, vertex: impl Fn(usize, usize) -> Vertex) -> Self {
        let mut mesh = Self::default();
        for row in 0..rows {
            for column in 0..columns {
                mesh.push(vertex(row, column));
            }
        }
        let at = |row: usize, column: usize| (row * columns + column) as u32;
        for row in 1..rows {
            for column in 1..columns {
                mesh.quad(at(row - 1, column - 1), at(row, column - 1), at(row, column), at(row - 1, column));
            }
        }
        mesh
    }

    /// Adds all of `other`.
    pub fn append(&mut self, other: &Self) {
        let first = self.vertices.len() as u32;
        self.vertices.extend_from_slice(&other.vertices);
        self.triangles.extend(other.triangles.iter().map(|t| t.map(|i| i + first)));
    }

    /// Moves every vertex.
    pub fn translated(mut self, by: DVec3) -> Self {
        for vertex in &mut self.vertices {
            vertex.position += by;
        }
        self
    }

    /// Applies a linear map; normals go with its cofactors, and a reflection turns the triangles over.
    pub fn transformed(mut self, map: DMat3) -> Self {
        let cofactors = DMat3::from_cols(
            map.y_axis.cross(map.z_axis),
            map.z_axis.cross(map.x_axis),
            map.x_axis.cross(map.y_axis),
        );
        let reflects = map.determinant() < 0.0;
        let side = if reflects { -1.0 } else { 1.0 };
        for vertex in &mut self.vertices {
            vertex.position = map * vertex.position;
            vertex.normal = (cofactors * vertex.normal * side).normalize_or_zero();
        }
        if reflects {
            for triangle in &mut self.triangles {
                triangle.swap(1, 2);
            }
        }
        self
    }

    /// The mirror image at the plane z = 0.
    pub fn mirrored(&self) -> Self {
        self.clone().transformed(DMat3::from_diagonal(DVec3::new(1.0, 1.0, -1.0)))
    }

    /// This mesh and its mirror image at the plane z = 0.
    pub fn with_mirror(mut self) -> Self {
        let other = self.mirrored();
        self.append(&other);
        self
    }

    /// Replaces texture coordinates.
    pub fn mapped(mut self, uv: impl Fn(&Vertex) -> DVec2) -> Self {
        for vertex in &mut self.vertices {
            vertex.uv = uv(vertex);
        }
        self
    }

    /// Without the vertices that no triangle uses.
    pub fn compact(self) -> Self {
        let mut new = vec![u32::MAX; self.vertices.len()];
        let mut mesh = Self::default();
        for triangle in &self.triangles {
            let corners = triangle.map(|i| {
                if new[i as usize] == u32::MAX {
                    new[i as usize] = mesh.push(self.vertices[i as usize]);
                }
                new[i as usize]
            });
            mesh.triangles.push(corners);
        }
        mesh
    }
}

/// The bits of a point, with one zero, for exact comparison.
pub fn key(point: DVec3) -> [u64; 3] {
    (point + DVec3::ZERO).to_array().map(f64::to_bits)
}
