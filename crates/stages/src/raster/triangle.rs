//! A triangle on the screen, ready to be rasterized.

use super::Disc;
use overcoat_scene::MAX_VERTICES;

/// One triangle after projection, snapping and culling: 64 bytes, a cache line. It has all that rasterizing and shading ask
/// of a triangle, since in dense meshes each is somewhere else in memory.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(64))]
pub struct Triangle {
    /// Sub-pixel positions relative to the viewport's centre, in the order of positive area (clockwise on the screen).
    pub x: [i32; 3],
    /// See `x`; +y down.
    pub y: [i32; 3],
    /// Depth at the vertices, greater is nearer: 1 / distance for perspective, -distance for orthographic views.
    pub depth: [f32; 3],
    /// Change of depth per sub-pixel.
    pub depth_gradient: [f32; 2],
    /// Its vertices in the mesh, in the mesh's order; those of the whole triangle if it is a clipped piece. The highest bits
    /// are what [`FLAG`] marks: [`BACK_FACING`], [`SWAPPED`] and [`CLIPPED`].
    vertices: [u32; 3],
    /// Coverage of a small triangle, in four parts of sixteen bits (see [`SmallLanes`](super::SmallLanes)); 0 if it is
    /// not small, or not known to be.
    pub small_samples: u64,
}

const _: () = assert!(size_of::<Triangle>() == 64);

/// The bit of a vertex's number that is none: meshes have fewer vertices.
const FLAG: u32 = 1 << 31;
const _: () = assert!(MAX_VERTICES <= FLAG as usize);

/// The vertices whose bit says that the triangle is seen from behind, that vertices 1 and 2 are in the opposite order of
/// the mesh's, and that it is a clipped piece.
const BACK_FACING: usize = 0;
const SWAPPED: usize = 1;
const CLIPPED: usize = 2;

impl Triangle {
    /// Sets up a triangle from snapped vertices in the mesh's order; `None` if it has no area. `front_is_clockwise`
    /// says which order of vertices on the screen is the front, `vertices` are its vertices in the mesh.
    #[inline(always)]
    #[must_use]
    pub fn new(
        [a, b, c]: [(i32, i32, f32); 3],
        vertices: [u32; 3],
        front_is_clockwise: bool,
    ) -> Option<Self> {
        let area = i64::from(b.0 - a.0) * i64::from(c.1 - a.1) - i64::from(c.0 - a.0) * i64::from(b.1 - a.1);
        if area == 0 {
            return None;
        }
        let swapped = area < 0;
        let (b, c) = if swapped { (c, b) } else { (b, c) };
        let (x, y, depth) = ([a.0, b.0, c.0], [a.1, b.1, c.1], [a.2, b.2, c.2]);
        let (x1, y1, z1) = ((x[1] - x[0]) as f32, (y[1] - y[0]) as f32, depth[1] - depth[0]);
        let (x2, y2, z2) = ((x[2] - x[0]) as f32, (y[2] - y[0]) as f32, depth[2] - depth[0]);
        let inverse_area = 1.0 / area.unsigned_abs() as f32;
        let mut triangle = Self {
            x,
            y,
            depth,
            depth_gradient: [(z1 * y2 - z2 * y1) * inverse_area, (z2 * x1 - z1 * x2) * inverse_area],
            vertices,
            small_samples: 0,
        };
        triangle.vertices[BACK_FACING] |= if swapped == front_is_clockwise { FLAG } else { 0 };
        triangle.vertices[SWAPPED] |= if swapped { FLAG } else { 0 };
        Some(triangle)
    }

    /// A triangle around a disc, on its plane, with the disc's vertex at each corner: what shading asks of it.
    #[inline(always)]
    #[must_use]
    pub fn around(disc: &Disc) -> Self {
        let [x, y] = disc.reach;
        let (left, top) = (-x, -y);
        let (right, bottom) = (3 * x, 3 * y);
        // Of a disc that is close and seen from its edge a corner could come to lie behind the viewer.
        let least = if disc.depth > 0.0 { 0.125 * disc.depth } else { f32::NEG_INFINITY };
        let depth = |dx: i32, dy: i32| {
            let [gx, gy] = disc.depth_gradient;
            let depth = disc.depth + dx as f32 * gx + dy as f32 * gy;
            if depth > least { depth } else { least }
        };
        let mut vertices = [disc.vertex; 3];
        vertices[BACK_FACING] |= if disc.back_facing { FLAG } else { 0 };
        Self {
            x: [disc.x + left, disc.x + right, disc.x + left],
            y: [disc.y + top, disc.y + top, disc.y + bottom],
            depth: [depth(left, top), depth(right, top), depth(left, bottom)],
            depth_gradient: disc.depth_gradient,
            vertices,
            small_samples: 0,
        }
    }

    /// The same as a piece that clipping left.
    #[inline(always)]
    #[must_use]
    pub fn clipped(mut self) -> Self {
        self.vertices[CLIPPED] |= FLAG;
        self
    }

    /// Its vertices in the mesh, in the mesh's order; those of the whole triangle if it is a clipped piece.
    #[inline(always)]
    #[must_use]
    pub fn vertices(&self) -> [u32; 3] {
        let [a, b, c] = self.vertices;
        [a & !FLAG, b & !FLAG, c & !FLAG]
    }

    /// Seen from behind.
    #[inline(always)]
    #[must_use]
    pub fn is_back_facing(&self) -> bool {
        self.vertices[BACK_FACING] & FLAG != 0
    }

    /// Vertices 1 and 2 are in the opposite order of the mesh's.
    #[inline(always)]
    #[must_use]
    pub fn is_swapped(&self) -> bool {
        self.vertices[SWAPPED] & FLAG != 0
    }

    /// True for a piece that clipping left of a larger triangle.
    #[inline(always)]
    #[must_use]
    pub fn is_clipped(&self) -> bool {
        self.vertices[CLIPPED] & FLAG != 0
    }

    /// Smallest and largest x and y: `[min x, min y, max x, max y]` in sub-pixels.
    #[inline(always)]
    #[must_use]
    pub fn bounds(&self) -> [i32; 4] {
        let Self { x, y, .. } = self;
        [
            x[0].min(x[1]).min(x[2]),
            y[0].min(y[1]).min(y[2]),
            x[0].max(x[1]).max(x[2]),
            y[0].max(y[1]).max(y[2]),
        ]
    }

    /// Depth at a point relative to vertex 0, in sub-pixels: the operations of the lanes, in their order.
    #[inline(always)]
    #[must_use]
    pub fn depth_at(&self, [x, y]: [f32; 2]) -> f32 {
        let [smallest, largest] = self.depth_range();
        let depth = self.depth[0] + x * self.depth_gradient[0] + y * self.depth_gradient[1];
        let depth = if depth > smallest { depth } else { smallest };
        if depth < largest { depth } else { largest }
    }

    /// Smallest and largest depth of the vertices. Interpolated depths are clamped to it, so that slivers whose
    /// gradient is dominated by rounding never leave it.
    #[inline(always)]
    #[must_use]
    pub fn depth_range(&self) -> [f32; 2] {
        let [a, b, c] = self.depth;
        let low = |p: f32, q: f32| if p < q { p } else { q };
        let high = |p: f32, q: f32| if p > q { p } else { q };
        [low(low(a, b), c), high(high(a, b), c)]
    }
}
