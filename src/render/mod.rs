//! The renderer: scene and options in, frame out. The only place that knows the order of the stages.

mod aov;
mod draws;
mod environment;
mod options;
mod resolve;
mod tile_pass;
mod trace;

pub use crate::scene::{AreaLightMethod, ShadingModel};
pub use options::{Background, RenderError, RenderOptions, RenderStats, Rendered};
pub use trace::StageHashes;

use crate::frame::{AovPlane, Frame};
use crate::geometry::{
    Chunk, ChunkJob, ScreenVertex, TRIANGLES_PER_CHUNK, VERTICES_PER_CHUNK, View, process_chunk,
    transform_vertices,
};
use crate::jobs::Jobs;
use crate::light::{AreaLight, EnvironmentLight, PrefilteredEnvironment, PunctualLight};
use crate::limits::Limits;
use crate::raster::SamplePattern;
use crate::scene::{Camera, Scene};
use crate::shade::{ShadeContext, ViewRays};
use crate::tile::{TileBins, TileGrid};
use crate::{dispatch, dispatch_available};
use aov::TileAovs;
use draws::DrawState;
use environment::EnvironmentCache;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};
use tile_pass::{Pass, TileJob, TileScratch, Work};
use trace::FragmentHashes;

/// Renders scenes, keeping threads, buffers and filtered environments from one picture to the next.
#[derive(Debug, Default)]
pub struct Renderer {
    jobs: Jobs,
    vertices: Vec<ScreenVertex>,
    chunks: Vec<Chunk>,
    bins: TileBins,
    scratch: Vec<TileScratch>,
    environments: EnvironmentCache,
    /// Pixels of a frame that was given back.
    pixels: Vec<[f32; 4]>,
}

impl Renderer {
    /// A renderer with `threads` workers; 0 stands for one per processor.
    #[must_use]
    pub fn new(threads: usize) -> Self {
        Self { jobs: Jobs::new(threads), ..Self::default() }
    }

    /// The worker threads, for loaders to share.
    #[must_use]
    pub fn jobs(&self) -> &Jobs {
        &self.jobs
    }

    /// Lights the following pictures by an environment that is filtered already, in place of the scene's picture; its
    /// rotation and intensity stay the scene's. `None` goes back to the scene's own.
    pub fn use_environment(&mut self, environment: Option<Arc<PrefilteredEnvironment>>) {
        self.environments.given = environment;
    }

    /// Gives back a frame that is not needed any more: the next picture takes its memory in place of new memory, which
    /// the system would have to clear.
    pub fn recycle(&mut self, frame: Frame) {
        self.pixels = frame.pixels;
    }

    /// Takes one picture.
    ///
    /// # Errors
    /// [`RenderError`] if an option is out of range, the camera spans no view, or a limit is exceeded.
    pub fn render(
        &mut self,
        scene: &Scene,
        camera: &Camera,
        options: &RenderOptions,
    ) -> Result<Rendered, RenderError> {
        let pattern = options.validate()?;
        if !arithmetic_is_default() || self.jobs.on_every_worker(arithmetic_is_default).contains(&false) {
            return Err(RenderError::FloatingPointMode);
        }
        camera.validate()?;
        let mut stats = RenderStats { triangles: scene.triangle_count(), ..RenderStats::default() };
        let check = |what: &str, asked, limit, field| Limits::check(|| what.to_owned(), asked, limit, field);
        check("scene", stats.triangles, options.limits.triangles, "triangles")?;
        let mut clock = Clock::start();

        let view = View::new(camera, options.width, options.height)?;
        let side = options.tile_size.unwrap_or_else(|| tile_pass::default_tile_size(options.samples));
        let grid = TileGrid::new(options.width, options.height, side);
        let surroundings = scene.environment();
        let filtered = self.environments.get(&surroundings.source, &self.jobs, options.simd);
        let environment =
            EnvironmentLight::new(&filtered, surroundings.rotation_degrees, surroundings.intensity);
        let lights: Vec<PunctualLight> = scene.lights().iter().filter_map(PunctualLight::new).collect();
        let area_lights: Vec<AreaLight> = scene.lights().iter().filter_map(AreaLight::new).collect();
        clock.lap("environment");

        let (states, draws, vertex_count) = draws::prepare(scene, &view);
        self.transform(&states, &draws, vertex_count, options);
        clock.lap("vertices");
        let bin_limit = tile_pass::bin_limit(&options.limits);
        let binned = self.set_up_triangles(&states, &draws, &grid, &pattern, options, bin_limit);
        check("triangles of tiles", binned.min(bin_limit + 1), bin_limit, "blocks")?;
        self.bins.build(grid.len(), self.chunks.iter().map(|c| &c.bins));
        let rasterized = self.chunks.iter().map(|c| c.triangles.len() as u64).sum();
        clock.lap("triangles");

        let hashes = options.stage_hashes.then(|| StageHashes {
            scene: trace::scene(scene),
            environment: trace::environment(&filtered),
            geometry: trace::geometry(&self.vertices, &self.chunks),
            ..StageHashes::default()
        });
        let pass = Pass {
            grid,
            pattern: &pattern,
            chunks: &self.chunks,
            states: &states,
            shade: ShadeContext {
                draws: &draws,
                materials: scene.materials(),
                textures: scene.textures(),
                rays: view_rays(&view),
                environment: &environment,
                lights: &lights,
                area_lights: &area_lights,
                model: options.shading,
                area_light_method: options.area_lights,
                anisotropy: options.anisotropy,
            },
            work: Work::new(&options.limits),
            merge: merge_cosine(options.merge_angle),
            show_environment: options.background == Background::Environment,
        };
        // Every tile writes all of its pixels.
        let mut pixels = std::mem::take(&mut self.pixels);
        pixels.resize(options.width as usize * options.height as usize, [0.0; 4]);
        let mut frame = Frame { width: options.width, height: options.height, pixels, aovs: Vec::new() };
        let (fragments, planes, found) =
            render_tiles(&self.jobs, &pass, &self.bins, &mut self.scratch, &mut frame, options);
        pass.work.check()?;
        check("frame", fragments, options.limits.fragments, "fragments")?;
        frame.aovs = planes;
        clock.lap("tiles");
        stats.triangles_rasterized = rasterized;
        stats.fragments = fragments;
        stats.stages = clock.laps;
        stats.stage_hashes = hashes.zip(found).map(|(hashes, found)| hashes.finish(&found, &frame));
        Ok(Rendered { frame, stats })
    }

    /// All vertices of all draws to the screen.
    fn transform(
        &mut self,
        states: &[DrawState],
        draws: &[crate::gbuffer::Draw<'_>],
        count: usize,
        options: &RenderOptions,
    ) {
        self.vertices.clear();
        self.vertices.resize(count, ScreenVertex::default());
        let mut work = Vec::new();
        let mut rest = self.vertices.as_mut_slice();
        for (state, draw) in states.iter().zip(draws) {
            let positions = draw.mesh.positions();
            let (own, after) = rest.split_at_mut(positions.len());
            rest = after;
            let chunks = positions.chunks(VERTICES_PER_CHUNK).zip(own.chunks_mut(VERTICES_PER_CHUNK));
            work.extend(chunks.map(|(positions, out)| (&state.view, positions, out)));
        }
        self.jobs.for_each_mut(&mut work, |_, (view, positions, out)| {
            dispatch!(options.simd, l => transform_vertices(l, view, positions, out));
        });
    }

    /// All triangles of all draws to chunks of screen triangles, binned. Chunks never straddle draws. Returns the
    /// number of (tile, triangle) pairs; beyond `bin_limit` the rest is left out, and there will be no picture.
    fn set_up_triangles(
        &mut self,
        states: &[DrawState],
        draws: &[crate::gbuffer::Draw<'_>],
        grid: &TileGrid,
        pattern: &SamplePattern,
        options: &RenderOptions,
        bin_limit: u64,
    ) -> u64 {
        let mut count = 0;
        for (number, draw) in draws.iter().enumerate() {
            let triangles = draw.mesh.triangles().len();
            for start in (0..triangles).step_by(TRIANGLES_PER_CHUNK) {
                if count == self.chunks.len() {
                    self.chunks.push(Chunk::default());
                }
                let chunk = &mut self.chunks[count];
                chunk.draw = number as u32;
                chunk.range = start..triangles.min(start + TRIANGLES_PER_CHUNK);
                count += 1;
            }
        }
        self.chunks.truncate(count);
        let vertices = &self.vertices;
        let binned = AtomicU64::new(0);
        self.jobs.for_each_mut(&mut self.chunks, |_, chunk| {
            let state = &states[chunk.draw as usize];
            let mesh = draws[chunk.draw as usize].mesh;
            let job = ChunkJob {
                mesh,
                vertices: &vertices[state.first_vertex..state.first_vertex + mesh.positions().len()],
                view: &state.view,
                cull_back_faces: state.cull_back_faces,
                mirrored: state.mirrored,
                max_bins: usize::try_from(bin_limit.saturating_sub(binned.load(Ordering::Relaxed)))
                    .unwrap_or(usize::MAX),
            };
            dispatch_available!(options.simd, l => process_chunk(l, chunk, &job, grid, pattern));
            binned.fetch_add(chunk.bins.len() as u64, Ordering::Relaxed);
        });
        binned.into_inner()
    }
}

/// All tiles, each into its own rows of the frame. Returns the number of fragments, the G-buffer planes and the hashes
/// that were asked for.
fn render_tiles(
    jobs: &Jobs,
    pass: &Pass<'_>,
    bins: &TileBins,
    scratch: &mut Vec<TileScratch>,
    frame: &mut Frame,
    options: &RenderOptions,
) -> (u64, Vec<AovPlane>, Option<FragmentHashes>) {
    let grid = &pass.grid;
    // The rows of all tiles, tile by tile.
    let mut parts: Vec<&mut [[f32; 4]]> = Vec::with_capacity(grid.columns() as usize * frame.height as usize);
    let side = grid.side() as usize;
    for band in frame.pixels.chunks_mut(frame.width as usize * side) {
        let mut rows: Vec<_> =
            band.chunks_mut(frame.width as usize).map(|row| row.chunks_mut(side)).collect();
        for _ in 0..grid.columns() {
            parts.extend(rows.iter_mut().filter_map(Iterator::next));
        }
    }
    let mut rest = parts.as_mut_slice();
    let mut tiles: Vec<TileJob<'_, '_>> = (0..grid.len())
        .map(|tile| {
            let [_, _, width, height] = grid.pixels(tile);
            let rows;
            (rows, rest) = std::mem::take(&mut rest).split_at_mut(height as usize);
            TileJob {
                rows,
                aovs: TileAovs::new(&options.aovs, width as usize, height as usize),
                fragments: 0,
                hashes: options.stage_hashes.then(FragmentHashes::default),
            }
        })
        .collect();
    jobs.for_each_with_scratch(scratch, &mut tiles, |scratch, tile, job| {
        let runs = bins.runs(tile);
        dispatch_available!(
            options.simd,
            l => tile_pass::render_tile(l, pass, tile, runs, scratch, job)
        );
    });
    let fragments = tiles.iter().map(|t| t.fragments).sum();
    let hashes = options.stage_hashes.then(|| {
        let mut sum = FragmentHashes::default();
        tiles.iter().filter_map(|t| t.hashes.as_ref()).for_each(|hashes| sum.add(hashes));
        sum
    });
    let width = options.width as usize;
    let mut planes: Vec<AovPlane> = options
        .aovs
        .iter()
        .map(|&aov| AovPlane { aov, data: vec![0.0; aov.channels() * width * options.height as usize] })
        .collect();
    if !planes.is_empty() {
        for (tile, job) in tiles.into_iter().enumerate() {
            let [x, y, tile_width, _] = grid.pixels(tile).map(|v| v as usize);
            for (plane, part) in planes.iter_mut().zip(job.aovs.finish()) {
                let channels = plane.aov.channels();
                for (row, values) in part.chunks(tile_width * channels).enumerate() {
                    let at = ((y + row) * width + x) * channels;
                    plane.data[at..at + values.len()].copy_from_slice(values);
                }
            }
        }
    }
    (fragments, planes, hashes)
}

/// False if this thread's processor state flushes subnormal results or operands to zero, or rounds otherwise than to the
/// nearest number.
fn arithmetic_is_default() -> bool {
    let smallest = std::hint::black_box(f32::MIN_POSITIVE);
    let half = std::hint::black_box(smallest * 0.5);
    let one = std::hint::black_box(1.0_f32);
    let quarter_step = std::hint::black_box(f32::EPSILON * 0.25);
    // Upwards, the sum would be more than 1; downwards or towards zero, the difference would be less.
    let to_nearest = one + quarter_step == 1.0 && one - quarter_step == 1.0 && -one - quarter_step == -1.0;
    half > 0.0 && half * 2.0 == smallest && to_nearest
}

/// The square of the cosine of an angle in degrees; `None` for 0.
fn merge_cosine(degrees: f32) -> Option<f32> {
    let (_, cosine) = crate::math::double::sin_cos(f64::from(degrees) * (std::f64::consts::PI / 180.0));
    (degrees > 0.0).then_some((cosine * cosine) as f32)
}

/// The view's rays, rounded once.
fn view_rays(view: &View) -> ViewRays {
    let [right, up, back] = view.axes;
    let per_pixel = |axis: [f64; 3], sign: f64| axis.map(|v| (v * sign / view.scale) as f32);
    ViewRays {
        eye: view.eye.map(|v| v as f32),
        right: per_pixel(right, 1.0),
        down: per_pixel(up, -1.0),
        forward: back.map(|v| -v as f32),
        perspective: view.perspective,
    }
}

/// Writes down how long each stage takes. Only for the user to read: no result depends on it.
struct Clock {
    last: Instant,
    laps: Vec<(&'static str, Duration)>,
}

impl Clock {
    fn start() -> Self {
        Self { last: Instant::now(), laps: Vec::new() }
    }

    fn lap(&mut self, stage: &'static str) {
        let now = Instant::now();
        self.laps.push((stage, now - self.last));
        self.last = now;
    }
}
