//! Up to sixteen fragments of one material, their triangles gathered into lanes.

use super::Fragment;
use crate::each;
use crate::math::lanes::{Float, LANES, Lanes};
use crate::raster::{SamplePattern, TileOrigin, Triangle};
use crate::scene::Mesh;
use std::ops::Range;

/// One draw as the G-buffer sees it.
#[derive(Clone, Copy, Debug)]
pub struct Draw<'a> {
    /// The mesh.
    pub mesh: &'a Mesh,
    /// Index of the material in the scene.
    pub material: u32,
    /// Number of the object.
    pub object: u32,
    /// Object to world space for normals; keeps lengths where the transform scales uniformly.
    pub normal_matrix: [[f32; 3]; 3],
    /// Object to world space for tangents; likewise.
    pub tangent_matrix: [[f32; 3]; 3],
    /// -1 where the transform mirrors, else 1: the sign of bitangents.
    pub handedness: f32,
    /// By how much the transform scales lengths.
    pub scale: f32,
}

/// What a tile's identities stand for.
pub trait TriangleSource {
    /// The screen triangle, its draw, and the barycentric coordinates of its vertices if it is a clipped piece.
    fn triangle(&self, identity: u32) -> (&Triangle, u32, Option<&[[f32; 2]; 3]>);
}

/// Vertex indices and draw of each lane, in the order of the mesh.
#[derive(Clone, Copy, Debug)]
pub struct VertexLanes {
    /// Vertices of each lane's triangle.
    pub vertices: [[u32; 3]; LANES],
    /// Draw of each lane.
    pub draws: [u32; LANES],
    /// All lanes have the draw of lane 0.
    pub one_draw: bool,
    /// All lanes have the triangle of lane 0.
    pub one_triangle: bool,
}

/// The screen triangles of sixteen fragments as structure of arrays.
#[derive(Clone, Debug)]
pub struct Batch {
    /// Number of fragments, 1 to 16; the lanes above repeat the last.
    pub len: usize,
    /// The fragments.
    pub fragments: [Fragment; LANES],
    /// Vertices and draws.
    pub vertices: VertexLanes,
    /// Lanes that see the back of their triangle, by bits.
    pub back_facing: u16,
    /// Lanes whose vertices are in the opposite order of the mesh's, by bits.
    pub reversed: u16,
    /// Column and row of each pixel's corner in the tile, in sub-pixels.
    pub(super) pixel: [[i32; LANES]; 2],
    /// Centroid of the covered samples relative to that corner, in sub-pixels; of all samples, if not `partial`.
    pub(super) centroid: [[f32; LANES]; 2],
    pub(super) whole_centroid: [f32; 2],
    /// Some lane's pixel is not covered by all of its samples.
    pub(super) partial: bool,
    /// The tile's corner relative to the viewport's centre, in sub-pixels.
    pub(super) origin: [i32; 2],
    /// Vertices on the screen, relative to the viewport's centre, in sub-pixels.
    pub(super) x: [[i32; LANES]; 3],
    pub(super) y: [[i32; LANES]; 3],
    pub(super) depth: [[f32; LANES]; 3],
    /// Some lane is a clipped piece.
    pub(super) any_clipped: bool,
    /// Barycentric coordinates of the screen triangle's vertices in the mesh's triangle.
    pub(super) corners: [[[f32; LANES]; 2]; 3],
}

/// The corners of a triangle that was not clipped: its own.
const WHOLE: [[[f32; LANES]; 2]; 3] =
    [[[0.0; LANES], [0.0; LANES]], [[1.0; LANES], [0.0; LANES]], [[0.0; LANES], [1.0; LANES]]];

impl Default for Batch {
    fn default() -> Self {
        let none = Fragment { triangle: 0, pixel: 0, mask: 0 };
        Self {
            len: 0,
            fragments: [none; LANES],
            vertices: VertexLanes {
                vertices: [[0; 3]; LANES],
                draws: [0; LANES],
                one_draw: true,
                one_triangle: true,
            },
            back_facing: 0,
            reversed: 0,
            pixel: [[0; LANES]; 2],
            centroid: [[0.0; LANES]; 2],
            whole_centroid: [0.0; 2],
            partial: false,
            origin: [0; 2],
            x: [[0; LANES]; 3],
            y: [[0; LANES]; 3],
            depth: [[0.0; LANES]; 3],
            any_clipped: false,
            corners: WHOLE,
        }
    }
}

impl Batch {
    /// Gathers the fragments of a list, 1 to 16, in place of what was there. Scalar loads only, so one copy serves every
    /// instruction set.
    #[inline(never)]
    pub fn gather(
        &mut self,
        fragments: &[Fragment],
        source: &impl TriangleSource,
        draws: &[Draw<'_>],
        origin: TileOrigin,
        pattern: &SamplePattern,
    ) {
        self.len = fragments.len().min(LANES);
        (self.back_facing, self.reversed) = (0, 0);
        (self.vertices.one_draw, self.vertices.one_triangle) = (true, true);
        if self.any_clipped {
            self.any_clipped = false;
            self.corners = WHOLE;
        }
        let full = pattern.full_mask();
        (self.origin, self.whole_centroid) = ([origin.x, origin.y], pattern.centroid(full));
        let Some(&last) = fragments.last() else { return };
        let (own, repeated) = self.fragments.split_at_mut(self.len);
        own.copy_from_slice(&fragments[..self.len]);
        repeated.fill(last);
        let mut missing = 0;
        for (k, fragment) in self.fragments.iter().enumerate() {
            self.pixel[0][k] = fragment.column() as i32 * 256;
            self.pixel[1][k] = fragment.row() as i32 * 256;
            missing |= fragment.mask ^ full;
        }
        self.partial = missing != 0;
        if self.partial {
            for k in 0..LANES {
                [self.centroid[0][k], self.centroid[1][k]] = pattern.centroid(self.fragments[k].mask);
            }
        }
        // Neighbours often see the same triangle.
        let mut first = 0;
        while first < LANES {
            let identity = self.fragments[first].triangle;
            let mut end = first + 1;
            while end < LANES && self.fragments[end].triangle == identity {
                end += 1;
            }
            let (triangle, draw, clip) = source.triangle(identity);
            self.gather_triangle(first..end, triangle, draw, clip, draws);
            self.vertices.one_triangle = first == 0;
            first = end;
        }
    }

    /// One sample of each of the sixteen pixels of a block, all of one triangle: for alpha masks, before fragments
    /// exist. `column` and `row` are the block's first pixel in the tile. Samples may lie outside the triangle.
    #[inline(always)]
    pub fn of_block(
        identity: u32,
        source: &impl TriangleSource,
        draws: &[Draw<'_>],
        origin: TileOrigin,
        column: i32,
        row: i32,
        sample: usize,
        pattern: &SamplePattern,
    ) -> Self {
        let fragment =
            Fragment { triangle: identity, pixel: Fragment::pixel_at(column as u32, row as u32), mask: 1 };
        let mut batch = Self::default();
        batch.gather(&[fragment], source, draws, origin, pattern);
        batch.len = LANES;
        batch.partial = true;
        for k in 0..LANES {
            batch.pixel[0][k] += (k % 4) as i32 * 256;
            batch.pixel[1][k] += (k / 4) as i32 * 256;
            for axis in 0..2 {
                batch.centroid[axis][k] = pattern.offsets()[sample][axis] as f32;
            }
        }
        batch
    }

    /// The triangle of a run of lanes.
    #[inline(always)]
    fn gather_triangle(
        &mut self,
        lanes: Range<usize>,
        triangle: &Triangle,
        draw: u32,
        clip: Option<&[[f32; 2]; 3]>,
        draws: &[Draw<'_>],
    ) {
        let [a, b, c] = draws[draw as usize].mesh.triangles()[triangle.primitive as usize];
        // Attributes are taken in the order of the screen triangle, but clipped pieces know their place in the
        // mesh's own order.
        let swapped = triangle.swapped && clip.is_none();
        let vertices = if swapped { [a, c, b] } else { [a, b, c] };
        let bits = (((1_u32 << lanes.len()) - 1) << lanes.start) as u16;
        self.reversed |= if swapped { bits } else { 0 };
        self.back_facing |= if triangle.back_facing { bits } else { 0 };
        if lanes.len() == LANES {
            // A loop of known length for each plane.
            for v in 0..3 {
                self.x[v].fill(triangle.x[v]);
                self.y[v].fill(triangle.y[v]);
                self.depth[v].fill(triangle.depth[v]);
            }
            self.vertices.vertices.fill(vertices);
            self.vertices.draws.fill(draw);
        } else {
            // One loop for all planes: most runs are short.
            for k in lanes.start..lanes.end.min(LANES) {
                for v in 0..3 {
                    self.x[v][k] = triangle.x[v];
                    self.y[v][k] = triangle.y[v];
                    self.depth[v][k] = triangle.depth[v];
                }
                self.vertices.vertices[k] = vertices;
                self.vertices.draws[k] = draw;
            }
        }
        self.vertices.one_draw &= draw == self.vertices.draws[0];
        if let Some(piece) = clip {
            self.any_clipped = true;
            let order = if triangle.swapped { [0, 2, 1] } else { [0, 1, 2] };
            for v in 0..3 {
                for axis in 0..2 {
                    self.corners[v][axis][lanes.clone()].fill(piece[order[v]][axis]);
                }
            }
        }
    }

    /// The lanes that hold a fragment of their own, by bits.
    #[inline(always)]
    #[must_use]
    pub fn active(&self) -> u16 {
        ((1_u32 << self.len) - 1) as u16
    }
}

impl VertexLanes {
    /// A vertex attribute at the three vertices of each lane's triangle; `default` where the mesh has none.
    #[inline(always)]
    pub fn attribute<'a, L: Lanes, const N: usize>(
        &self,
        l: L,
        draws: &[Draw<'a>],
        default: [f32; N],
        of: fn(&'a Mesh) -> &'a [[f32; N]],
    ) -> [[L::F; N]; 3] {
        if self.one_triangle {
            let slice = of(draws[self.draws[0] as usize].mesh);
            return each!(vertex in self.vertices[0] => {
                let value = *slice.get(vertex as usize).unwrap_or(&default);
                each!(n => l.splat(value[n]))
            });
        }
        let mut planes = [[[0.0; LANES]; N]; 3];
        self.gather_attribute(draws, default, of, &mut planes);
        each!(vertex in planes => {
            each!(plane in vertex => l.load(&plane))
        })
    }

    /// Scalar loads only, so one copy serves every instruction set.
    #[inline(never)]
    fn gather_attribute<'a, const N: usize>(
        &self,
        draws: &[Draw<'a>],
        default: [f32; N],
        of: fn(&'a Mesh) -> &'a [[f32; N]],
        planes: &mut [[[f32; LANES]; N]; 3],
    ) {
        let mut slice = of(draws[self.draws[0] as usize].mesh);
        for k in 0..LANES {
            if !self.one_draw {
                slice = of(draws[self.draws[k] as usize].mesh);
            }
            for v in 0..3 {
                let value = slice.get(self.vertices[k][v] as usize).unwrap_or(&default);
                for n in 0..N {
                    planes[v][n][k] = value[n];
                }
            }
        }
    }

    /// A number of each lane's draw.
    #[inline(always)]
    pub fn number<L: Lanes>(&self, l: L, draws: &[Draw<'_>], of: impl Fn(&Draw<'_>) -> f32) -> L::F {
        if self.one_draw {
            return l.splat(of(&draws[self.draws[0] as usize]));
        }
        l.load(&each!(d in self.draws => of(&draws[d as usize])))
    }

    /// A matrix of each lane's draw, applied to a vector.
    #[inline(always)]
    pub fn transform<L: Lanes>(
        &self,
        l: L,
        draws: &[Draw<'_>],
        of: fn(&Draw<'_>) -> [[f32; 3]; 3],
        v: [L::F; 3],
    ) -> [L::F; 3] {
        if self.one_draw {
            let m = of(&draws[self.draws[0] as usize]);
            return each!(r in m => v[0] * r[0] + v[1] * r[1] + v[2] * r[2]);
        }
        let mut planes = [[[0.0; LANES]; 3]; 3];
        self.gather_matrix(draws, of, &mut planes);
        each!(r in planes => v[0] * l.load(&r[0]) + v[1] * l.load(&r[1]) + v[2] * l.load(&r[2]))
    }

    #[inline(never)]
    fn gather_matrix(
        &self,
        draws: &[Draw<'_>],
        of: fn(&Draw<'_>) -> [[f32; 3]; 3],
        planes: &mut [[[f32; LANES]; 3]; 3],
    ) {
        for k in 0..LANES {
            let m = of(&draws[self.draws[k] as usize]);
            for r in 0..3 {
                for c in 0..3 {
                    planes[r][c][k] = m[r][c];
                }
            }
        }
    }
}

/// `a0 + b1 (a1 - a0) + b2 (a2 - a0)` for each component.
#[inline(always)]
pub(super) fn interpolate<F: Float, const N: usize>(vertices: &[[F; N]; 3], b: &[F; 2]) -> [F; N] {
    each!(n => {
        let at_0 = vertices[0][n];
        at_0 + b[0] * (vertices[1][n] - at_0) + b[1] * (vertices[2][n] - at_0)
    })
}
