//! Up to sixteen fragments of one material, their triangles gathered into lanes.

use super::Fragment;
use crate::each;
use crate::math::lanes::{Float, LANES, Lanes};
use crate::raster::{SamplePattern, TileOrigin, Triangle};
use crate::scene::Mesh;

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
    /// The tile's corner relative to vertex 0 of the last lane gathered, in sub-pixels.
    corner: [i32; 2],
    /// Centroid of the covered samples relative to vertex 0, in sub-pixels.
    pub(super) x: [f32; LANES],
    pub(super) y: [f32; LANES],
    /// The same relative to the viewport's centre, in pixels.
    pub(super) screen_x: [f32; LANES],
    pub(super) screen_y: [f32; LANES],
    /// Vertices 1 and 2 relative to vertex 0, in sub-pixels.
    pub(super) edge_x: [[f32; LANES]; 2],
    pub(super) edge_y: [[f32; LANES]; 2],
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
            corner: [0; 2],
            x: [0.0; LANES],
            y: [0.0; LANES],
            screen_x: [0.0; LANES],
            screen_y: [0.0; LANES],
            edge_x: [[0.0; LANES]; 2],
            edge_y: [[0.0; LANES]; 2],
            depth: [[0.0; LANES]; 3],
            any_clipped: false,
            corners: WHOLE,
        }
    }
}

impl Batch {
    /// Gathers up to sixteen fragments, in place of what was there. Scalar loads only, so one copy serves every
    /// instruction set.
    #[inline(never)]
    pub fn gather(
        &mut self,
        fragments: impl Iterator<Item = Fragment>,
        source: &impl TriangleSource,
        draws: &[Draw<'_>],
        origin: TileOrigin,
        pattern: &SamplePattern,
    ) {
        self.len = 0;
        (self.back_facing, self.reversed) = (0, 0);
        (self.vertices.one_draw, self.vertices.one_triangle) = (true, true);
        if self.any_clipped {
            self.any_clipped = false;
            self.corners = WHOLE;
        }
        for fragment in fragments.take(LANES) {
            let k = self.len;
            self.fragments[k] = fragment;
            self.len += 1;
            // Neighbours often see the same triangle.
            if k > 0 && fragment.triangle == self.fragments[k - 1].triangle {
                self.repeat_triangle(k);
            } else {
                self.vertices.one_triangle = k == 0;
                let (triangle, draw, clip) = source.triangle(fragment.triangle);
                self.gather_triangle(k, triangle, draw, clip, draws, origin);
            }
            self.gather_position(k, origin, pattern);
        }
        for k in self.len.max(1)..LANES {
            self.fragments[k] = self.fragments[k - 1];
            self.repeat_triangle(k);
            for plane in [&mut self.x, &mut self.y, &mut self.screen_x, &mut self.screen_y] {
                plane[k] = plane[k - 1];
            }
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
        batch.gather(std::iter::once(fragment), source, draws, origin, pattern);
        batch.len = LANES;
        for k in 0..LANES {
            // The gathered fragment was the first sample of the block's first pixel.
            let x = (k % 4) as i32 * 256 + pattern.offsets()[sample][0] - pattern.offsets()[0][0];
            let y = (k / 4) as i32 * 256 + pattern.offsets()[sample][1] - pattern.offsets()[0][1];
            batch.x[k] += x as f32;
            batch.y[k] += y as f32;
            batch.screen_x[k] += x as f32 * (1.0 / 256.0);
            batch.screen_y[k] += y as f32 * (1.0 / 256.0);
        }
        batch
    }

    /// Lane k's triangle.
    #[inline(always)]
    fn gather_triangle(
        &mut self,
        k: usize,
        triangle: &Triangle,
        draw: u32,
        clip: Option<&[[f32; 2]; 3]>,
        draws: &[Draw<'_>],
        origin: TileOrigin,
    ) {
        self.corner = [origin.x - triangle.x[0], origin.y - triangle.y[0]];
        for v in 0..2 {
            self.edge_x[v][k] = (triangle.x[v + 1] - triangle.x[0]) as f32;
            self.edge_y[v][k] = (triangle.y[v + 1] - triangle.y[0]) as f32;
        }
        for v in 0..3 {
            self.depth[v][k] = triangle.depth[v];
        }
        let [a, b, c] = draws[draw as usize].mesh.triangles()[triangle.primitive as usize];
        // Attributes are taken in the order of the screen triangle, but clipped pieces know their place in the
        // mesh's own order.
        let swapped = triangle.swapped && clip.is_none();
        self.vertices.vertices[k] = if swapped { [a, c, b] } else { [a, b, c] };
        self.reversed |= u16::from(swapped) << k;
        self.vertices.draws[k] = draw;
        self.vertices.one_draw &= draw == self.vertices.draws[0];
        self.back_facing |= u16::from(triangle.back_facing) << k;
        if let Some(piece) = clip {
            self.any_clipped = true;
            let order = if triangle.swapped { [0, 2, 1] } else { [0, 1, 2] };
            for v in 0..3 {
                for axis in 0..2 {
                    self.corners[v][axis][k] = piece[order[v]][axis];
                }
            }
        }
    }

    /// Lane k sees the triangle of the lane before it.
    #[inline(always)]
    fn repeat_triangle(&mut self, k: usize) {
        let from = k - 1;
        self.vertices.vertices[k] = self.vertices.vertices[from];
        self.vertices.draws[k] = self.vertices.draws[from];
        self.back_facing |= (self.back_facing >> from & 1) << k;
        self.reversed |= (self.reversed >> from & 1) << k;
        for plane in self.edge_x.iter_mut().chain(&mut self.edge_y).chain(&mut self.depth) {
            plane[k] = plane[from];
        }
        if self.any_clipped {
            for plane in self.corners.iter_mut().flatten() {
                plane[k] = plane[from];
            }
        }
    }

    /// The centroid of lane k's samples.
    #[inline(always)]
    fn gather_position(&mut self, k: usize, origin: TileOrigin, pattern: &SamplePattern) {
        let fragment = self.fragments[k];
        let [x, y] = pattern.centroid(fragment.mask);
        let (column, row) = (fragment.column() as i32 * 256, fragment.row() as i32 * 256);
        self.x[k] = (self.corner[0] + column) as f32 + x;
        self.y[k] = (self.corner[1] + row) as f32 + y;
        self.screen_x[k] = ((origin.x + column) as f32 + x) * (1.0 / 256.0);
        self.screen_y[k] = ((origin.y + row) as f32 + y) * (1.0 / 256.0);
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
