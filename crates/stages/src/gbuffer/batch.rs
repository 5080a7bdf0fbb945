//! Up to sixteen fragments of one material, their triangles gathered into lanes.

use super::Fragment;
use crate::raster::{SamplePattern, TileOrigin, Triangle};
use overcoat_core::each;
use overcoat_core::math::lanes::{Float, LANES, Lanes};
use overcoat_core::math::vec3::{V3, Vec3};
use overcoat_core::vec3;
use overcoat_scene::{EdgeLines, Mesh};
use prefetch_index::prefetch_index;
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
    /// Number of the instance among those of the scene.
    pub instance: u32,
    /// Object to world space for positions, row by row.
    pub position_matrix: [[f32; 4]; 3],
    /// Object to world space for normals; keeps lengths where the transform scales uniformly.
    pub normal_matrix: [[f32; 3]; 3],
    /// Object to world space for tangents; likewise.
    pub tangent_matrix: [[f32; 3]; 3],
    /// -1 where the transform mirrors, else 1: the sign of bitangents.
    pub handedness: f32,
    /// Factor by which the transform scales lengths.
    pub scale: f32,
    /// For each set of texture coordinates: true if the material reads textures by it.
    pub uv_sets: [bool; 2],
    /// Feature edges whose lines the mesh has, if it is no mesh of the scene.
    pub edges: Option<&'a EdgeLines>,
}

/// Lookup of triangles by a tile's identities.
pub trait TriangleSource {
    /// The triangle of an identity.
    fn triangle(&self, identity: u32) -> SourceTriangle<'_>;
}

/// A triangle on the screen, and what it is a part of.
#[derive(Clone, Copy, Debug)]
pub struct SourceTriangle<'a> {
    /// On the screen.
    pub screen: &'a Triangle,
    /// Number of its draw.
    pub draw: u32,
    /// The barycentric coordinates of its vertices in the whole triangle, if it is a clipped piece.
    pub clip: Option<&'a [[f32; 2]; 3]>,
}

/// Vertex indices and draw of each lane, in the order of the mesh. Neighbours often see one triangle: most is known of the
/// first of such a run only.
#[derive(Clone, Copy, Debug)]
pub struct VertexLanes {
    /// Lanes that see another triangle than the lane before, by bits; lane 0 counts as one.
    starts: u16,
    /// Vertices of the triangle of each lane in `starts`.
    vertices: [[u32; 3]; LANES],
    /// Draw of each lane in `starts`; of every lane, if there are several.
    draws: [u32; LANES],
    /// All lanes have the draw of lane 0.
    one_draw: bool,
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
    /// The number of each pixel in the tile, see [`Fragment::pixel`].
    pub(super) pixel: [i32; LANES],
    /// Some lane's pixel is not covered by all of its samples.
    pub(super) partial: bool,
    /// If so, the covered samples, see [`SampleSums::packed`].
    pub(super) samples: [i32; LANES],
    /// If not, the centroid of all samples relative to the pixel's corner, in sub-pixels.
    pub(super) whole_centroid: [f32; 2],
    /// Some lane stands for less than a pixel.
    pub(super) finer: bool,
    /// If so, the side of the square that each stands for, in pixels.
    pub(super) sides: [f32; LANES],
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

/// Lanes, and room for the last of them to be written with three others.
const PADDED: usize = LANES + 3;

/// The corners of a triangle that was not clipped: its own.
const WHOLE: [[[f32; LANES]; 2]; 3] =
    [[[0.0; LANES], [0.0; LANES]], [[1.0; LANES], [0.0; LANES]], [[0.0; LANES], [1.0; LANES]]];

impl Default for Batch {
    fn default() -> Self {
        let none = Fragment { triangle: 0, pixel: 0, mask: 0 };
        Self {
            len: 0,
            fragments: [none; LANES],
            vertices: VertexLanes { vertices: [[0; 3]; LANES], draws: [0; LANES], one_draw: true, starts: 1 },
            back_facing: 0,
            reversed: 0,
            pixel: [0; LANES],
            partial: false,
            samples: [0; LANES],
            whole_centroid: [0.0; 2],
            finer: false,
            sides: [1.0; LANES],
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
    /// Gathers 1 to 16 fragments of a list by their indices, in place of what was there. Scalar loads only, so one copy
    /// serves every instruction set.
    #[inline(never)]
    pub fn gather(
        &mut self,
        fragments: &[Fragment],
        indices: &[u32],
        source: &impl TriangleSource,
        origin: TileOrigin,
        pattern: &SamplePattern,
    ) {
        self.len = indices.len().min(LANES);
        (self.back_facing, self.reversed) = (0, 0);
        (self.vertices.one_draw, self.vertices.starts) = (true, 0);
        if self.any_clipped {
            self.any_clipped = false;
            self.corners = WHOLE;
        }
        let full = pattern.full_mask();
        (self.origin, self.whole_centroid) = ([origin.x, origin.y], pattern.centroid(full));
        let Some(&last) = indices.last() else { return };
        let (own, repeated) = self.fragments.split_at_mut(self.len);
        for (fragment, &index) in own.iter_mut().zip(indices) {
            *fragment = fragments[index as usize];
        }
        repeated.fill(fragments[last as usize]);
        let mut missing = 0;
        for (k, fragment) in self.fragments.iter().enumerate() {
            self.pixel[k] = i32::from(fragment.pixel);
            missing |= fragment.mask ^ full;
        }
        self.partial = missing != 0;
        if self.partial {
            for (samples, fragment) in self.samples.iter_mut().zip(&self.fragments) {
                *samples = pattern.sums(fragment.mask).packed();
            }
        }
        self.finer = self.partial && pattern.rate() > 1;
        if self.finer {
            for (side, fragment) in self.sides.iter_mut().zip(&self.fragments) {
                *side = pattern.side(fragment.mask);
            }
        }
        // Neighbours often see the same triangle. All triangles are looked up before any is used: in a dense mesh each is
        // somewhere else in memory, and what is asked for together comes together.
        let mut runs = [None; LANES];
        let mut first = 0;
        while first < LANES {
            let identity = self.fragments[first].triangle;
            let mut end = first + 1;
            while end < LANES && self.fragments[end].triangle == identity {
                end += 1;
            }
            let SourceTriangle { screen, draw, clip } = source.triangle(identity);
            let [a, b, c] = screen.vertices();
            // Attributes are taken in the order of the screen triangle, but clipped pieces know their place in the
            // mesh's own order.
            let swapped = screen.is_swapped() && clip.is_none();
            self.vertices.vertices[first] = if swapped { [a, c, b] } else { [a, b, c] };
            self.vertices.draws[first] = draw;
            self.vertices.starts |= 1 << first;
            runs[first] = Some((screen, clip));
            first = end;
        }
        let mut remaining = self.vertices.starts;
        while remaining != 0 {
            let first = remaining.trailing_zeros() as usize;
            remaining &= remaining - 1;
            let end = if remaining == 0 { LANES } else { remaining.trailing_zeros() as usize };
            if let Some((triangle, clip)) = runs[first % LANES] {
                self.gather_triangle(first..end, triangle, clip);
            }
            self.vertices.one_draw &= self.vertices.draws[first % LANES] == self.vertices.draws[0];
        }
        if !self.vertices.one_draw {
            for k in 1..LANES {
                if self.vertices.starts >> k & 1 == 0 {
                    self.vertices.draws[k] = self.vertices.draws[k - 1];
                }
            }
        }
    }

    /// One sample of each of the sixteen pixels of a block, all of one triangle: for alpha masks, before fragments
    /// exist. `column` and `row` are the block's first pixel in the tile. Samples may lie outside the triangle.
    #[inline(always)]
    pub fn of_block(
        identity: u32,
        source: &impl TriangleSource,
        origin: TileOrigin,
        column: i32,
        row: i32,
        sample: usize,
        pattern: &SamplePattern,
    ) -> Self {
        let fragment =
            Fragment { triangle: identity, pixel: Fragment::pixel_at(column as u32, row as u32), mask: 1 };
        let mut batch = Self::default();
        batch.gather(&[fragment], &[0], source, origin, pattern);
        batch.len = LANES;
        batch.partial = true;
        batch.samples = [pattern.sums(1 << sample).packed(); LANES];
        if pattern.rate() > 1 {
            batch.finer = true;
            batch.sides = [pattern.group_side(); LANES];
        }
        for k in 0..LANES {
            batch.pixel[k] += i32::from(Fragment::pixel_at((k % 4) as u32, (k / 4) as u32));
        }
        batch
    }

    /// Triangles that rays hit, up to sixteen, of one material: vertices in the order of their mesh, and the draw. For what is
    /// read by barycentric weights alone; the batch has no place on the screen.
    #[inline(never)]
    pub fn of_hits(&mut self, hits: &[([u32; 3], u32)], back_facing: u16) {
        self.len = hits.len().min(LANES);
        (self.back_facing, self.reversed, self.partial, self.any_clipped) = (back_facing, 0, false, false);
        let Some(last) = self.len.checked_sub(1) else { return };
        let lanes = &mut self.vertices;
        (lanes.starts, lanes.one_draw) = (0, true);
        for k in 0..LANES {
            (lanes.vertices[k], lanes.draws[k]) = hits[k.min(last)];
            if k == 0 || (k <= last && hits[k] != hits[k - 1]) {
                lanes.starts |= 1 << k;
            }
            lanes.one_draw &= lanes.draws[k] == lanes.draws[0];
        }
    }

    /// The triangle of a run of lanes.
    #[inline(always)]
    fn gather_triangle(&mut self, lanes: Range<usize>, triangle: &Triangle, clip: Option<&[[f32; 2]; 3]>) {
        let bits = (((1_u32 << lanes.len()) - 1) << lanes.start) as u16;
        self.reversed |= if triangle.is_swapped() && clip.is_none() { bits } else { 0 };
        self.back_facing |= if triangle.is_back_facing() { bits } else { 0 };
        if lanes.len() == LANES {
            // A loop of known length for each plane.
            for v in 0..3 {
                self.x[v].fill(triangle.x[v]);
                self.y[v].fill(triangle.y[v]);
                self.depth[v].fill(triangle.depth[v]);
            }
        } else {
            // One loop for all planes: most runs are short.
            for k in lanes.start..lanes.end.min(LANES) {
                for v in 0..3 {
                    self.x[v][k] = triangle.x[v];
                    self.y[v][k] = triangle.y[v];
                    self.depth[v][k] = triangle.depth[v];
                }
            }
        }
        if let Some(piece) = clip {
            self.any_clipped = true;
            let order = if triangle.is_swapped() { [0, 2, 1] } else { [0, 1, 2] };
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
    /// The draw of a lane.
    #[inline(always)]
    #[must_use]
    pub fn draw(&self, lane: usize) -> u32 {
        self.draws[if self.one_draw { 0 } else { lane }]
    }

    /// Vertices of the triangle of a lane, in the order of the mesh.
    #[must_use]
    pub fn corners(&self, lane: usize) -> [u32; 3] {
        let begun = u32::from(self.starts) & ((2 << lane) - 1);
        let start = begun.checked_ilog2().unwrap_or(0) as usize;
        self.vertices[start % LANES]
    }

    /// The only draw, or those of all lanes.
    #[inline(always)]
    #[must_use]
    pub fn draws(&self) -> &[u32] {
        if self.one_draw { &self.draws[..1] } else { &self.draws }
    }

    /// Prefetches the attributes of the vertices: in a dense mesh they are not in the cache, and they arrive while
    /// something else is done. Changes no result.
    pub fn prefetch(&self, draws: &[Draw<'_>]) {
        let mut remaining = self.starts;
        while remaining != 0 {
            let first = remaining.trailing_zeros() as usize % LANES;
            remaining &= remaining - 1;
            let draw = &draws[self.draws[first] as usize];
            for vertex in self.vertices[first] {
                prefetch(draw.mesh.shading_normals(), vertex);
                prefetch(draw.mesh.colors(), vertex);
                for (set, is_read) in draw.uv_sets.into_iter().enumerate() {
                    if is_read {
                        prefetch(draw.mesh.uvs(set), vertex);
                        prefetch(draw.mesh.tangents(), vertex);
                    }
                }
            }
        }
    }

    /// A vertex attribute at the three vertices of each lane's triangle; `default` where the mesh has none.
    #[inline(always)]
    pub fn attribute<'a, L: Lanes, const N: usize>(
        &self,
        l: L,
        draws: &[Draw<'a>],
        default: [f32; N],
        of: fn(&'a Mesh) -> &'a [[f32; N]],
    ) -> [[L::F; N]; 3] {
        if self.starts == 1 {
            let slice = of(draws[self.draws[0] as usize].mesh);
            return each!(vertex in self.vertices[0] => {
                let value = *slice.get(vertex as usize).unwrap_or(&default);
                each!(n => l.splat(value[n]))
            });
        }
        let mut planes = [[[0.0; PADDED]; N]; 3];
        self.gather_attribute(draws, default, of, &mut planes);
        each!(vertex in planes => {
            each!(plane in vertex => l.load(plane.first_chunk().unwrap_or(&[0.0; LANES])))
        })
    }

    /// Scalar loads only, so one copy serves every instruction set.
    #[inline(never)]
    fn gather_attribute<'a, const N: usize>(
        &self,
        draws: &[Draw<'a>],
        default: [f32; N],
        of: fn(&'a Mesh) -> &'a [[f32; N]],
        planes: &mut [[[f32; PADDED]; N]; 3],
    ) {
        let mut slice = of(draws[self.draws[0] as usize].mesh);
        let mut remaining = self.starts;
        while remaining != 0 {
            let first = remaining.trailing_zeros() as usize;
            remaining &= remaining - 1;
            let end = if remaining == 0 { LANES } else { remaining.trailing_zeros() as usize };
            if !self.one_draw {
                slice = of(draws[self.draws[first] as usize].mesh);
            }
            let values: [[f32; N]; 3] =
                each!(vertex in self.vertices[first] => *slice.get(vertex as usize).unwrap_or(&default));
            // Four lanes at a time; what is too many belongs to the next triangles, or to none.
            let mut k = first;
            while k < end.min(LANES) {
                for v in 0..3 {
                    for n in 0..N {
                        if let Some(four) = planes[v][n][k..].first_chunk_mut::<4>() {
                            *four = [values[v][n]; 4];
                        }
                    }
                }
                k += 4;
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

    /// A place of each lane's draw, in world space.
    #[inline(always)]
    pub fn to_world<L: Lanes>(&self, l: L, draws: &[Draw<'_>], place: V3<L>) -> V3<L> {
        let turned = self.transform(l, draws, |d| d.position_matrix.map(|[x, y, z, _]| [x, y, z]), place);
        turned + vec3!(axis => self.number(l, draws, |draw| draw.position_matrix[axis][3]))
    }

    /// A matrix of each lane's draw, applied to a vector.
    #[inline(always)]
    pub fn transform<L: Lanes>(
        &self,
        l: L,
        draws: &[Draw<'_>],
        of: fn(&Draw<'_>) -> [[f32; 3]; 3],
        v: V3<L>,
    ) -> V3<L> {
        if self.one_draw {
            let m = of(&draws[self.draws[0] as usize]);
            return vec3!(r in Vec3::from_array(m) => v.dot(Vec3::splat(l, r)));
        }
        let mut planes = [[[0.0; LANES]; 3]; 3];
        self.gather_matrix(draws, of, &mut planes);
        vec3!(r in Vec3::from_array(planes) => v.dot(Vec3::new(l.load(&r[0]), l.load(&r[1]), l.load(&r[2]))))
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

/// Prefetches one element of an attribute, if the mesh has it.
#[inline(always)]
fn prefetch<T>(attribute: &[T], vertex: u32) {
    if (vertex as usize) < attribute.len() {
        prefetch_index(attribute, vertex as usize);
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
