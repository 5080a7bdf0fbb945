//! Picking: the surface that a pixel shows, from what the rasterizer has kept of the last picture.
//!
//! It is asked where the samples of the picture are, that nearest to the middle first: of triangles that lie between samples nothing
//! is kept.

use super::picture::{Memory, Request, environment_light, shade_context, tile_grid};
use super::setup::SetUp;
use overcoat_core::dispatch_baseline;
use overcoat_core::math::lanes::Mask;
use overcoat_core::reuse::emptied;
use overcoat_scene::{AlphaMode, Camera, EnvironmentSource, PrimitiveKind, Revision, Scene};
use overcoat_stages::gbuffer::{Batch, Draw, SourceTriangle, TriangleSource};
use overcoat_stages::geometry::{Chunk, View};
use overcoat_stages::light::Levels;
use overcoat_stages::raster::{Disc, SUBPIXELS, SamplePattern, TileOrigin, Triangle};
use overcoat_stages::shade::{ShadeContext, alpha_passes};
use overcoat_stages::tile::{TileBins, TileGrid};
use overcoat_tiles::draws::{self, DrawState};
use overcoat_tiles::edges::Edges;
use overcoat_tiles::options::RenderError;
use overcoat_tiles::timed_pool::TimedPool;

/// Least opacity of what is found: half a step of 8 bits.
const LEAST_OPACITY: f32 = 0.5 / 255.0;

/// Surface that a pixel shows.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Hit {
    /// Number of the draw in [`Scene::instances`].
    pub instance: usize,
    /// Number of the triangle, line or point in its mesh: an index of
    /// [`Mesh::triangles`](overcoat_scene::Mesh::triangles), or of [`Mesh::positions`](overcoat_scene::Mesh::positions)
    /// if it is made of points without these.
    pub primitive: usize,
    /// Its vertices in the mesh; of a line the first two, of a point the first count.
    pub vertices: [u32; 3],
    /// Weights of the vertices where it is seen, 0 to 1, of sum 1, perspective-correct.
    pub barycentric: [f32; 3],
    /// Distance along the view direction in metres, as [`Aov::Depth`](overcoat_core::frame::Aov::Depth).
    pub depth: f32,
    /// Position of that point in world space, in metres.
    pub position: [f64; 3],
    /// Seen from behind.
    pub back_facing: bool,
}

/// Identity of the picture whose geometry the rasterizer has kept.
#[derive(Clone, Debug)]
pub(super) struct LastPicture {
    scene: Revision,
    camera: Camera,
    size: [u32; 2],
    samples: u32,
    widths: (f32, Option<f32>),
    edges: (Option<Edges>, f32),
    grid: TileGrid,
    /// Number of chunks.
    count: usize,
}

impl LastPicture {
    pub(super) fn new(request: &Request<'_>, grid: TileGrid, count: usize) -> Self {
        let &Request { scene, camera, options, .. } = request;
        let size = [options.width, options.height];
        let widths = (options.line_width, options.point_size);
        let edges = (options.edges, options.edge_width_in_pixels());
        let samples = options.samples;
        Self { scene: scene.revision(), camera: *camera, size, samples, widths, edges, grid, count }
    }

    /// True if the kept triangles are those of the picture that is asked for, and are listed in the pixel's tile.
    fn serves(&self, request: &Request<'_>, pixel: [u32; 2]) -> bool {
        let own = Self::new(request, self.grid, self.count);
        let alike = (own.scene, own.camera, own.size, own.samples, own.widths, own.edges)
            == (self.scene, self.camera, self.size, self.samples, self.widths, self.edges);
        alike && self.grid.lists(pixel)
    }
}

impl Memory {
    /// Finds what a pixel shows.
    pub(super) fn pick(
        &mut self,
        request: &Request<'_>,
        pixel: [u32; 2],
    ) -> Result<Option<Hit>, RenderError> {
        let &Request { jobs, scene, options, .. } = request;
        let (pattern, view, budget) = self.check(request)?;
        if pixel[0] >= options.width || pixel[1] >= options.height {
            let value = format!("{}, {} of {} x {}", pixel[0], pixel[1], options.width, options.height);
            return Err(RenderError::Option { option: "pixel", value, allowed: "in the picture" });
        }
        let mut draws = emptied(std::mem::take(&mut self.draws));
        if self.last.as_ref().is_some_and(|last| last.serves(request, pixel)) {
            self.prepared.geometry.states.clear();
            draws::prepare(scene, &view, options, &mut self.prepared.geometry.states, &mut draws);
        } else {
            self.last = None;
            let mut pool = TimedPool::new(jobs);
            self.prepared.geometry.place_vertices(&mut pool, scene, &view, options, &mut draws);
            // All of it, for whoever asks next.
            let grid = tile_grid(options, options.tile_size);
            let to = SetUp { grid: &grid, pattern: &pattern, budget: &budget };
            let count = self.prepared.geometry.set_up_triangles(&mut pool, &draws, &to, options);
            budget.check()?;
            self.prepared
                .bins
                .build(grid.len(), self.prepared.geometry.chunks[..count].iter().map(|c| &c.bins));
            self.last = Some(LastPicture::new(request, grid, count));
        }
        self.textures.begin_picking(request);
        // Opacity does not ask for light.
        let dark = self.environments.get(&EnvironmentSource::None, Levels::NONE, jobs, options.simd);
        let environment = environment_light(scene, &dark);
        let found = self.last.as_ref().and_then(|last| {
            let kept = Kept {
                chunks: &self.prepared.geometry.chunks[..last.count],
                bins: &self.prepared.bins,
                states: &self.prepared.geometry.states,
                draws: &draws,
                grid: &last.grid,
                view: &view,
                pattern: &pattern,
            };
            let (textures, lights) = (self.textures.of(scene), &self.prepared.lights);
            let shade = shade_context(request, textures, &view, &draws, &environment, lights, 0);
            kept.nearest(scene, &shade, pixel)
        });
        self.draws = emptied(draws);
        self.textures.end();
        self.pattern = Some(pattern);
        Ok(found)
    }
}

/// Geometry that the rasterizer has kept.
struct Kept<'a> {
    chunks: &'a [Chunk],
    bins: &'a TileBins,
    states: &'a [DrawState],
    draws: &'a [Draw<'a>],
    grid: &'a TileGrid,
    view: &'a View,
    pattern: &'a SamplePattern,
}

/// A triangle or point at a sample, before its opacity is known.
struct Candidate<'a> {
    depth: f32,
    chunk: &'a Chunk,
    index: u32,
    /// Disc of a point; `None` for others.
    disc: Option<Disc>,
}

/// One triangle, whatever its identity.
struct One<'a>(SourceTriangle<'a>);

impl TriangleSource for One<'_> {
    fn triangle(&self, _: u32) -> SourceTriangle<'_> {
        self.0
    }
}

impl Kept<'_> {
    fn nearest(&self, scene: &Scene, shade: &ShadeContext<'_>, pixel: [u32; 2]) -> Option<Hit> {
        let tile = self.grid.tile_of(pixel);
        let origin = self.grid.origin(tile);
        let [left, top, ..] = self.grid.pixels(tile);
        let in_tile = [pixel[0] - left, pixel[1] - top];
        let offsets = self.pattern.offsets();
        let mut samples: Vec<usize> = (0..offsets.len()).collect();
        let from_middle = |sample: &usize| {
            let [x, y] = offsets[*sample].map(|v| v - SUBPIXELS / 2);
            x * x + y * y
        };
        samples.sort_by_key(from_middle);
        samples.into_iter().find_map(|sample| {
            let [x, y] = offsets[sample];
            let place = |corner: i32, pixel: u32, offset: i32| corner + pixel as i32 * SUBPIXELS + offset;
            let at = [place(origin.x, in_tile[0], x), place(origin.y, in_tile[1], y)];
            let mut candidates = self.candidates(tile, at);
            // The nearest first; of those at the same depth the first that was drawn, as in the picture.
            candidates.sort_by(|a, b| b.depth.total_cmp(&a.depth));
            let is_seen =
                |candidate: &&Candidate<'_>| self.is_seen(shade, candidate, origin, in_tile, sample);
            Some(self.hit(scene, candidates.iter().find(is_seen)?, at))
        })
    }

    /// All triangles and points of a tile that cover a place, in the order of drawing: surfaces, and not their edges.
    fn candidates(&self, tile: usize, at: [i32; 2]) -> Vec<Candidate<'_>> {
        let mut out = Vec::new();
        for run in self.bins.runs(tile) {
            let chunk = &self.chunks[run.chunk as usize];
            if self.draws[chunk.draw as usize].edges.is_some() {
                continue;
            }
            for &index in chunk.bins.triangles(run) {
                let (disc, depth) = if chunk.points {
                    let Some(disc) = self.disc(chunk, index) else { continue };
                    (Some(disc), depth_of_disc(&disc, at))
                } else {
                    (None, depth_of_triangle(&chunk.triangles[index as usize], at))
                };
                out.extend(depth.map(|depth| Candidate { depth, chunk, index, disc }));
            }
        }
        out
    }

    fn disc(&self, chunk: &Chunk, index: u32) -> Option<Disc> {
        let points = self.states[chunk.draw as usize].points.as_ref()?;
        points.disc(self.draws[chunk.draw as usize].mesh, chunk.range.start + index as usize)
    }

    /// True if something of it shows at a sample of the pixel.
    fn is_seen(
        &self,
        shade: &ShadeContext<'_>,
        candidate: &Candidate<'_>,
        origin: TileOrigin,
        [column, row]: [u32; 2],
        sample: usize,
    ) -> bool {
        let number = candidate.chunk.draw;
        let cutoff = match self.states[number as usize].alpha_mode {
            AlphaMode::Opaque => return true,
            AlphaMode::Mask { cutoff } => cutoff,
            AlphaMode::Blend => LEAST_OPACITY,
        };
        let around = candidate.disc.as_ref().map(Triangle::around);
        let screen = around.as_ref().unwrap_or_else(|| &candidate.chunk.triangles[candidate.index as usize]);
        let clip = if candidate.disc.is_some() { None } else { candidate.chunk.clip(candidate.index) };
        let source = One(SourceTriangle { screen, draw: number, clip });
        let material = &shade.materials[self.draws[number as usize].material as usize];
        let (block, place) = ([column & !3, row & !3].map(|v| v as i32), (column & 3) + 4 * (row & 3));
        dispatch_baseline!(l => {
            let batch = Batch::of_block(0, &source, origin, block[0], block[1], sample, self.pattern);
            alpha_passes(l, shade, material, cutoff, &batch).bits() >> place & 1 == 1
        })
    }

    fn hit(&self, scene: &Scene, candidate: &Candidate<'_>, at: [i32; 2]) -> Hit {
        let &Candidate { depth, chunk, index, ref disc } = candidate;
        let instance = chunk.draw as usize;
        let mesh = self.draws[instance].mesh;
        let (barycentric, depth, vertices, back_facing) = match disc {
            Some(disc) => ([1.0, 0.0, 0.0], f64::from(depth), [disc.vertex; 3], disc.back_facing),
            None => {
                let triangle = &chunk.triangles[index as usize];
                let (weights, depth) = weights(triangle, chunk.clip(index), at, self.view.perspective);
                (weights, depth, triangle.vertices(), triangle.is_back_facing())
            }
        };
        let primitive = match disc {
            Some(_) => chunk.range.start + index as usize,
            None => {
                chunk.range.start + place_among(&mesh.triangles()[chunk.range.clone()], vertices, mesh.kind())
            }
        };
        let corner = |k: usize| mesh.positions()[vertices[k] as usize].map(f64::from);
        let (a, b, c) = (corner(0), corner(1), corner(2));
        let [u, v, w] = barycentric;
        let own = std::array::from_fn(|k| u * a[k] + v * b[k] + w * c[k]);
        Hit {
            instance,
            primitive,
            vertices,
            barycentric: barycentric.map(|weight| weight as f32),
            depth: if self.view.perspective { (1.0 / depth) as f32 } else { -depth as f32 },
            position: scene.instances()[instance].transform.point(own),
            back_facing,
        }
    }
}

/// Depth of a triangle at a place that it covers, its border included.
fn depth_of_triangle(triangle: &Triangle, [px, py]: [i32; 2]) -> Option<f32> {
    let Triangle { x, y, .. } = triangle;
    let inside = (0..3).all(|k| {
        let next = (k + 1) % 3;
        let (ex, ey) = (i64::from(x[next] - x[k]), i64::from(y[next] - y[k]));
        ex * i64::from(py - y[k]) - ey * i64::from(px - x[k]) >= 0
    });
    inside.then(|| triangle.depth_at([(px - x[0]) as f32, (py - y[0]) as f32]))
}

/// Depth of a disc at a place that it covers.
fn depth_of_disc(disc: &Disc, [px, py]: [i32; 2]) -> Option<f32> {
    let (dx, dy) = ((px - disc.x) as f32, (py - disc.y) as f32);
    let [a, b, c] = disc.conic;
    let form = a * dx * dx + b * dx * dy + c * dy * dy;
    let [gx, gy] = disc.depth_gradient;
    (form <= 1.0).then_some(disc.depth + dx * gx + dy * gy - form * disc.sag)
}

/// Weights of the mesh's vertices at a place on the screen, and depth there: 1 / distance for perspective, -distance for
/// orthographic views.
fn weights(
    triangle: &Triangle,
    clip: Option<&[[f32; 2]; 3]>,
    [px, py]: [i32; 2],
    perspective: bool,
) -> ([f64; 3], f64) {
    let Triangle { x, y, depth, .. } = triangle;
    let to = |k: usize| [f64::from(x[k] - x[0]), f64::from(y[k] - y[0])];
    let ([x1, y1], [x2, y2]) = (to(1), to(2));
    let (x, y) = (f64::from(px - x[0]), f64::from(py - y[0]));
    let area = x1 * y2 - x2 * y1;
    let (w1, w2) = ((x * y2 - y * x2) / area, (y * x1 - x * y1) / area);
    let mut weights = [1.0 - w1 - w2, w1, w2];
    let depth = weights[0] * f64::from(depth[0]) + w1 * f64::from(depth[1]) + w2 * f64::from(depth[2]);
    if perspective {
        for (weight, own) in weights.iter_mut().zip(triangle.depth) {
            *weight *= f64::from(own) / depth;
        }
    }
    if triangle.is_swapped() {
        weights.swap(1, 2);
    }
    if let Some(piece) = clip {
        // Of the piece's corners, in the order of the mesh, to those of the whole triangle.
        let of = |axis: usize| (0..3).map(|k| weights[k] * f64::from(piece[k][axis])).sum();
        let (u, v): (f64, f64) = (of(0), of(1));
        weights = [1.0 - u - v, u, v];
    }
    (weights, depth)
}

/// Index of the triangle or line of a chunk that has these vertices.
fn place_among(triangles: &[[u32; 3]], vertices: [u32; 3], kind: PrimitiveKind) -> usize {
    let corners = if kind == PrimitiveKind::Lines { 2 } else { 3 };
    triangles.iter().position(|own| own[..corners] == vertices[..corners]).unwrap_or_default()
}
