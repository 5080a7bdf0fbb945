//! Vertices to the screen, sixteen at a time.

use super::DrawView;
use crate::raster::{GUARD_BAND, SUBPIXELS};
use overcoat_core::math::lanes::{Float, LANES, Lanes, Mask};
use std::ops::Range;

/// Vertices that one job transforms.
pub const VERTICES_PER_CHUNK: usize = 8192;

/// A vertex on the screen.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ScreenVertex {
    /// Sub-pixels right of the viewport's centre, or [`ScreenVertex::OUTSIDE`].
    pub x: i32,
    /// Sub-pixels below the centre.
    pub y: i32,
    /// Greater is nearer: 1 / distance, or -distance in an orthographic view.
    pub depth: f32,
}

/// Vertices on the screen, part by part: most triangles are culled by the places of their vertices alone.
#[derive(Clone, Debug, Default)]
pub struct ScreenVertices {
    /// x and y of each, see [`ScreenVertex`].
    pub places: Vec<[i32; 2]>,
    /// Depth of each.
    pub depths: Vec<f32>,
}

/// Some of [`ScreenVertices`].
#[derive(Clone, Copy, Debug)]
pub struct ScreenVertexSlice<'a> {
    /// x and y of each.
    pub places: &'a [[i32; 2]],
    /// Depth of each.
    pub depths: &'a [f32],
}

impl ScreenVertices {
    /// Makes the list as long as that, with any vertices.
    pub fn resize(&mut self, count: usize) {
        self.places.resize(count, [0; 2]);
        self.depths.resize(count, 0.0);
    }

    /// Vertices from one number up to another.
    ///
    /// # Panics
    /// If there are fewer.
    #[must_use]
    pub fn slice(&self, range: Range<usize>) -> ScreenVertexSlice<'_> {
        ScreenVertexSlice { places: &self.places[range.clone()], depths: &self.depths[range] }
    }
}

impl FromIterator<ScreenVertex> for ScreenVertices {
    fn from_iter<T: IntoIterator<Item = ScreenVertex>>(vertices: T) -> Self {
        let (places, depths) = vertices.into_iter().map(|v| ([v.x, v.y], v.depth)).unzip();
        Self { places, depths }
    }
}

impl ScreenVertexSlice<'_> {
    /// One vertex.
    #[inline(always)]
    pub(super) fn get(&self, number: u32) -> ScreenVertex {
        let [x, y] = self.places[number as usize];
        ScreenVertex { x, y, depth: self.depths[number as usize] }
    }
}

impl ScreenVertex {
    /// Bytes that a vertex takes in the list.
    pub const BYTES: usize = size_of::<[i32; 2]>() + size_of::<f32>();

    /// Marks a vertex before the near plane or beyond the guard band: its triangles have to be clipped.
    pub const OUTSIDE: i32 = i32::MIN;
}

/// Homogeneous screen coordinates: x and y in pixels (times w), w the distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ClipVertex {
    pub x: f32,
    pub y: f32,
    pub w: f32,
}

impl DrawView {
    /// The homogeneous screen coordinates of one position: the operations of the lanes, in their order, so that a
    /// clipped triangle meets its unclipped neighbours in every bit.
    pub(super) fn clip_vertex(&self, p: [f32; 3]) -> ClipVertex {
        let row = |r: &[f32; 4]| ((p[0] * r[0] + p[1] * r[1]) + p[2] * r[2]) + r[3];
        ClipVertex { x: row(&self.x), y: row(&self.y), w: row(&self.distance) }
    }
}

impl ClipVertex {
    /// Snaps to the screen. Only for vertices within the near plane and the guard band.
    pub(super) fn project(&self, perspective: bool) -> ScreenVertex {
        let (inverse, depth) = if perspective { (1.0 / self.w, 1.0 / self.w) } else { (1.0, -self.w) };
        let snap = |v: f32| {
            let limit = (GUARD_BAND * SUBPIXELS) as f32;
            let s = v * inverse * SUBPIXELS as f32 + 0.5;
            let s = s.floor();
            (if s > -limit { if s < limit { s } else { limit } } else { -limit }) as i32
        };
        ScreenVertex { x: snap(self.x), y: snap(self.y), depth }
    }
}

/// Transforms positions of a mesh to as many places and depths.
#[inline(always)]
pub fn transform_vertices<L: Lanes>(
    l: L,
    view: &DrawView,
    positions: &[[f32; 3]],
    places: &mut [[i32; 2]],
    depths: &mut [f32],
) {
    let (sixteens, rest) = positions.as_chunks::<LANES>();
    let (own_places, rest_of_places) = places.as_chunks_mut::<LANES>();
    let (own_depths, rest_of_depths) = depths.as_chunks_mut::<LANES>();
    for ((positions, places), depths) in sixteens.iter().zip(own_places).zip(own_depths) {
        (*places, *depths) = transform_sixteen(l, view, positions);
    }
    if !rest.is_empty() {
        let mut positions = [[0.0; 3]; LANES];
        positions[..rest.len()].copy_from_slice(rest);
        let (places, depths) = transform_sixteen(l, view, &positions);
        rest_of_places.copy_from_slice(&places[..rest_of_places.len()]);
        rest_of_depths.copy_from_slice(&depths[..rest_of_depths.len()]);
    }
}

#[inline(always)]
fn transform_sixteen<L: Lanes>(
    l: L,
    view: &DrawView,
    positions: &[[f32; 3]; LANES],
) -> ([[i32; 2]; LANES], [f32; LANES]) {
    let position = l.load_triples(positions);
    let (x, y, w) = (row(&view.x, &position), row(&view.y, &position), row(&view.distance, &position));
    let (inverse, depth) = if view.perspective {
        let inverse = w.recip();
        (inverse, inverse)
    } else {
        (l.splat(1.0), -w)
    };
    // The tests of the clipper, operation by operation: a vertex is outside for all its triangles or for none.
    let guard = GUARD_BAND as f32;
    let bound = if view.perspective { w * guard } else { l.splat(guard) };
    let zero = l.zero();
    let inside = w.ge(l.splat(view.near))
        & (bound - x).ge(zero)
        & (bound + x).ge(zero)
        & (bound - y).ge(zero)
        & (bound + y).ge(zero);
    let x = inside.select_i(snap(x * inverse), l.splat_i(ScreenVertex::OUTSIDE));
    (l.zip(x, snap(y * inverse)), depth.to_array())
}

/// A row of the view's matrix times a position.
#[inline(always)]
fn row<F: Float>(r: &[f32; 4], p: &[F; 3]) -> F {
    ((p[0] * r[0] + p[1] * r[1]) + p[2] * r[2]) + r[3]
}

/// Pixels to the nearest sub-pixel within the guard band.
#[inline(always)]
fn snap<F: Float>(pixels: F) -> F::I {
    let limit = (GUARD_BAND * SUBPIXELS) as f32;
    (pixels * SUBPIXELS as f32 + 0.5).floor().clamp_to(-limit, limit).to_int()
}
