//! Meshes that block light at several places, kept once.
//!
//! A copy of the triangles for each place would take more memory than all that a picture without shadows does. Corners are
//! therefore brought to their place whenever a map is drawn: exactly those that a copy would have, so that no texel depends on
//! which meshes are kept in this way.

use super::blockers::Masked;
use super::slab::List;
use overcoat_scene::{Mesh, Transform};
use std::ops::Range;

/// A mesh of one kind of triangles that stands at several places.
#[derive(Clone, Debug)]
pub struct Repeated {
    mesh: Mesh,
    /// See [`Mesh::used_vertices`].
    used: Option<Vec<bool>>,
    pub(super) list: List,
    /// Corners change their order: the places mirror what blocks light from one side.
    turned: bool,
    /// Holes of the triangles of [`List::Masked`].
    masked: Vec<Masked>,
    places: Vec<Transform>,
}

impl PartialEq for Repeated {
    fn eq(&self, other: &Self) -> bool {
        let alike = |a: &Mesh, b: &Mesh| {
            std::ptr::eq(a.positions(), b.positions())
                || (a.positions() == b.positions() && a.triangles() == b.triangles())
        };
        (self.list, self.turned) == (other.list, other.turned)
            && self.places == other.places
            && alike(&self.mesh, &other.mesh)
            && self.used == other.used
            && self.masked == other.masked
    }
}

impl Repeated {
    /// A mesh without holes at no place yet.
    pub(super) fn new(mesh: &Mesh, list: List, turned: bool) -> Self {
        let (masked, places) = (Vec::new(), Vec::new());
        Self { mesh: mesh.clone(), used: mesh.used_vertices(), list, turned, masked, places }
    }

    /// Adds the holes of each triangle.
    pub(super) fn with_holes(self, masked: Vec<Masked>) -> Self {
        Self { masked, ..self }
    }

    /// Adds a place.
    pub(super) fn add(&mut self, place: Transform) {
        self.places.push(place);
    }

    /// Number of triangles at all places.
    #[must_use]
    pub fn len(&self) -> usize {
        self.mesh.triangles().len().saturating_mul(self.places.len())
    }

    /// True if it blocks nothing.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Number of vertices at all places.
    pub(super) fn vertices(&self) -> usize {
        self.mesh.positions().len().saturating_mul(self.places.len())
    }

    /// Bytes that it takes beside the mesh, which the scene has too.
    pub(super) fn bytes(&self) -> u64 {
        Self::bytes_of(&self.mesh, self.places.len(), self.masked.len())
    }

    /// Bytes of a mesh at so many places, with so many triangles that have holes.
    pub(super) fn bytes_of(mesh: &Mesh, places: usize, masked: usize) -> u64 {
        let parts = [
            (places, size_of::<Transform>()),
            (masked, size_of::<Masked>()),
            (mesh.positions().len(), size_of::<bool>()),
        ];
        parts.iter().fold(0, |sum: u64, (n, size)| sum.saturating_add((*n as u64) * (*size as u64)))
    }

    /// The corners of a triangle, counted over all places, where they are; `None` if one of them is not finite.
    pub(super) fn corners(&self, number: usize) -> Option<[[f32; 3]; 3]> {
        let count = self.mesh.triangles().len().max(1);
        let place = self.places.get(number / count)?;
        let &[a, b, c] = self.mesh.triangles().get(number % count)?;
        let mut corners = [[0.0; 3]; 3];
        for (corner, vertex) in corners.iter_mut().zip(if self.turned { [a, c, b] } else { [a, b, c] }) {
            *corner = self.vertex(place, vertex as usize)?;
        }
        corners.as_flattened().iter().all(|c| c.is_finite()).then_some(corners)
    }

    /// The holes of a triangle, counted over all places.
    pub(super) fn masked(&self, number: usize) -> Option<&Masked> {
        self.masked.get(number % self.masked.len().max(1))
    }

    /// Vertices that triangles use, of some that are counted over all places.
    pub(super) fn positions(&self, numbers: Range<usize>) -> impl Iterator<Item = [f32; 3]> {
        let count = self.mesh.positions().len().max(1);
        numbers.filter_map(move |number| self.vertex(self.places.get(number / count)?, number % count))
    }

    /// A vertex where it is; `None` if no triangle uses it.
    fn vertex(&self, place: &Transform, vertex: usize) -> Option<[f32; 3]> {
        if self.used.as_ref().is_some_and(|used| !used.get(vertex).copied().unwrap_or(false)) {
            return None;
        }
        let position = self.mesh.positions().get(vertex)?;
        Some(place.point(position.map(f64::from)).map(|c| c as f32))
    }
}
