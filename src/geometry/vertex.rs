//! Vertices to the screen, sixteen at a time.

use super::DrawView;
use crate::math::lanes::{Float, Int, LANES, Lanes, Mask};
use crate::raster::GUARD_BAND;

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

impl ScreenVertex {
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
            let limit = (GUARD_BAND * 256) as f32;
            let s = v * inverse * 256.0 + 0.5;
            let s = s.floor();
            (if s > -limit { if s < limit { s } else { limit } } else { -limit }) as i32
        };
        ScreenVertex { x: snap(self.x), y: snap(self.y), depth }
    }
}

/// Transforms up to `out.len()` positions of a mesh.
#[inline(always)]
pub fn transform_vertices<L: Lanes>(l: L, view: &DrawView, positions: &[[f32; 3]], out: &mut [ScreenVertex]) {
    for (positions, out) in positions.chunks(LANES).zip(out.chunks_mut(LANES)) {
        let mut coordinates = [[0.0; LANES]; 3];
        for (k, p) in positions.iter().enumerate() {
            coordinates[0][k] = p[0];
            coordinates[1][k] = p[1];
            coordinates[2][k] = p[2];
        }
        let [x, y, z] = [l.load(&coordinates[0]), l.load(&coordinates[1]), l.load(&coordinates[2])];
        let position = [x, y, z];
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
        let xs = inside.select_i(snap(x * inverse), l.splat_i(ScreenVertex::OUTSIDE)).to_array();
        let ys = snap(y * inverse).to_array();
        let depth = depth.to_array();
        for (k, out) in out.iter_mut().enumerate() {
            *out = ScreenVertex { x: xs[k], y: ys[k], depth: depth[k] };
        }
    }
}

/// A row of the view's matrix times a position.
#[inline(always)]
fn row<F: Float>(r: &[f32; 4], p: &[F; 3]) -> F {
    ((p[0] * r[0] + p[1] * r[1]) + p[2] * r[2]) + r[3]
}

/// Pixels to the nearest sub-pixel within the guard band.
#[inline(always)]
fn snap<F: Float>(pixels: F) -> F::I {
    let limit = (GUARD_BAND * 256) as f32;
    (pixels * 256.0 + 0.5).floor().clamp_to(-limit, limit).to_int()
}
