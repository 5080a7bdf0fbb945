//! Geometry: from the draws of a scene to triangles on the screen, listed for the tiles.

use overcoat_core::reuse::emptied;
use overcoat_core::{dispatch, dispatch_available};
use overcoat_scene::{Mesh, PrimitiveKind, Scene, estimate_surfels, find_edges};
use overcoat_stages::gbuffer::Draw;
use overcoat_stages::geometry::{
    Chunk, ChunkJob, DrawView, ScreenVertices, TRIANGLES_PER_CHUNK, VERTICES_PER_CHUNK, View, process_chunk,
    process_edges, process_lines, process_points, transform_vertices,
};
use overcoat_stages::raster::SamplePattern;
use overcoat_stages::tile::TileGrid;
use overcoat_tiles::budget::FrameBudget;
use overcoat_tiles::draws::{self, DrawState};
use overcoat_tiles::edges::wanted;
use overcoat_tiles::options::RenderOptions;
use overcoat_tiles::timed_pool::TimedPool;

/// Chunks that are kept after a picture that needs fewer: a quarter of a million triangles, some 25 MB.
const SPARE_CHUNKS: usize = 64;

/// Draws on the screen, in memory that is kept from one picture to the next.
#[derive(Debug, Default)]
pub(super) struct GeometryMemory {
    pub states: Vec<DrawState>,
    pub vertices: ScreenVertices,
    /// Empty between pictures.
    vertex_jobs: Vec<VertexJob<'static>>,
    /// Chunks of the picture, and spare ones.
    pub chunks: Vec<Chunk>,
}

/// Vertices of one draw that are transformed in one go.
#[derive(Debug)]
struct VertexJob<'a> {
    view: &'a DrawView,
    positions: &'a [[f32; 3]],
    places: &'a mut [[i32; 2]],
    depths: &'a mut [f32],
}

/// Targets that triangles are set up for: grid, sample pattern and memory budget.
#[derive(Clone, Copy)]
pub(super) struct SetUp<'a> {
    pub grid: &'a TileGrid,
    pub pattern: &'a SamplePattern,
    pub budget: &'a FrameBudget,
}

impl GeometryMemory {
    /// Prepares the draws of a scene, in a list that is empty, and brings all their vertices to the screen, until the work is
    /// cancelled.
    pub(super) fn place_vertices<'a>(
        &mut self,
        pool: &mut TimedPool<'_>,
        scene: &'a Scene,
        view: &View,
        options: &RenderOptions,
        draws: &mut Vec<Draw<'a>>,
    ) {
        for mesh in unknown_clouds(scene) {
            mesh.set_surfels(estimate_surfels(mesh, pool.jobs));
        }
        for (_, instance, _) in wanted(scene, options) {
            let mesh = &scene.meshes()[instance.mesh.index()];
            if mesh.feature_edges().is_none() {
                mesh.set_feature_edges(find_edges(mesh, pool.jobs));
            }
        }
        self.states.clear();
        let count = draws::prepare(scene, view, options, &mut self.states, draws);
        // Every one is written below.
        self.vertices.resize(count);
        let mut work = emptied(std::mem::take(&mut self.vertex_jobs));
        let (mut places, mut depths) = (&mut self.vertices.places[..], &mut self.vertices.depths[..]);
        for (state, draw) in self.states.iter().zip(&*draws).filter(|(state, _)| !state.vertices.is_empty()) {
            for positions in draw.mesh.positions().chunks(VERTICES_PER_CHUNK) {
                let (own_places, own_depths);
                (own_places, places) = places.split_at_mut(positions.len());
                (own_depths, depths) = depths.split_at_mut(positions.len());
                work.push(VertexJob { view: &state.view, positions, places: own_places, depths: own_depths });
            }
        }
        let jobs = pool.jobs;
        pool.for_each_mut(&mut work, |_, VertexJob { view, positions, places, depths }| {
            if jobs.is_cancelled() {
                return;
            }
            dispatch!(options.simd, l => transform_vertices(l, view, positions, places, depths));
        });
        self.vertex_jobs = emptied(work);
    }

    /// All triangles of all draws to chunks of screen triangles, binned. Chunks never straddle draws. Returns the number of
    /// chunks. Once the budget is spent or the work cancelled the rest is left out, and there will be no picture.
    pub(super) fn set_up_triangles(
        &mut self,
        pool: &mut TimedPool<'_>,
        draws: &[Draw<'_>],
        to: &SetUp<'_>,
        options: &RenderOptions,
    ) -> usize {
        let count = self.cut_into_chunks(draws);
        let &SetUp { grid, pattern, budget } = to;
        let (vertices, states) = (&self.vertices, &self.states);
        let jobs = pool.jobs;
        pool.for_each_mut(&mut self.chunks[..count], |_, chunk| {
            if budget.is_spent() || jobs.is_cancelled() {
                return;
            }
            let state = &states[chunk.draw as usize];
            let Draw { mesh, edges, .. } = draws[chunk.draw as usize];
            let max_bins = usize::try_from(budget.references(grid)).unwrap_or(usize::MAX);
            let job = ChunkJob {
                mesh,
                vertices: vertices.slice(state.vertices.clone()),
                view: &state.view,
                cull_back_faces: state.cull_back_faces,
                mirrored: state.mirrored,
                max_bins,
            };
            if let (Some(edges), Some(view)) = (edges, &state.edges) {
                process_edges(chunk, &job, edges, view, grid);
                return budget.charge(chunk, grid);
            }
            match (mesh.kind(), &state.points) {
                (PrimitiveKind::Points, Some(points)) => {
                    process_points(chunk, points, mesh, [grid, budget.grid()], max_bins)
                }
                (PrimitiveKind::Lines, _) => process_lines(chunk, &job, options.line_width, grid),
                _ => dispatch_available!(options.simd, l => process_chunk(l, chunk, &job, grid, pattern)),
            }
            budget.charge(chunk, grid);
        });
        count
    }

    /// Cuts the triangles, lines or points of each draw into chunks. Returns their number.
    fn cut_into_chunks(&mut self, draws: &[Draw<'_>]) -> usize {
        let mut count = 0;
        for (number, draw) in draws.iter().enumerate() {
            let primitives = draw.mesh.primitive_count();
            for start in (0..primitives).step_by(TRIANGLES_PER_CHUNK) {
                if count == self.chunks.len() {
                    self.chunks.push(Chunk::default());
                }
                let chunk = &mut self.chunks[count];
                chunk.draw = number as u32;
                chunk.range = start..primitives.min(start + TRIANGLES_PER_CHUNK);
                chunk.points = draw.mesh.kind() == PrimitiveKind::Points;
                count += 1;
            }
        }
        self.chunks.truncate(count.max(SPARE_CHUNKS));
        count
    }
}

/// Meshes of points of which it is not known yet what they are drawn as. One that is drawn often is listed once: what is
/// found shows while the list is walked.
pub(super) fn unknown_clouds(scene: &Scene) -> impl Iterator<Item = &Mesh> {
    let meshes = scene.instances().iter().map(|instance| &scene.meshes()[instance.mesh.index()]);
    meshes.filter(|mesh| mesh.kind() == PrimitiveKind::Points && mesh.surfels().is_none())
}
