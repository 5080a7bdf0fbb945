//! The renderer: scene and options in, frame out. The only place that knows the order of the stages.
//!
//! **Memory.** Every list of a picture is kept for the next: a picture like the last one takes no new memory, see
//! [`Renderer::recycle`].

mod aov;
mod bands;
mod budget;
mod builder;
mod crew;
mod draws;
mod environment;
mod options;
mod reach;
mod resolve;
mod shading_order;
mod splat_layers;
mod splat_tile;
mod splats;
mod tile_pass;
mod tile_shading;
mod tiles;
mod trace;
mod unseen;
mod work;

pub use builder::RendererBuilder;
pub use options::{Background, RenderError, RenderOptions, RenderStats, Rendered, RenderedImage};
pub use trace::StageHashes;
pub use unseen::Unseen;
pub use work::WorkDone;

use crate::frame::{Clipping, Developer, DisplayImage, DisplayOptions, Frame};
use crate::gbuffer::Draw;
use crate::geometry::{
    Chunk, ChunkJob, DrawView, ScreenVertices, TRIANGLES_PER_CHUNK, VERTICES_PER_CHUNK, View,
    estimate_surfels, process_chunk, process_lines, process_points, transform_vertices,
};
use crate::jobs::Jobs;
use crate::light::{AreaLight, EnvironmentLight, PrefilteredEnvironment, PunctualLight};
use crate::limits::Limits;
use crate::raster::SamplePattern;
use crate::reuse::emptied;
use crate::scene::{Camera, Mesh, PrimitiveKind, Scene};
use crate::shade::{Backdrop, ShadeContext, ShadingCost, ViewRays};
use crate::tile::{TileBins, TileGrid};
use crate::{dispatch, dispatch_available};
use bands::Planes;
use budget::FrameBudget;
use builder::Fixed;
use crew::{Crew, arithmetic_is_default};
use draws::DrawState;
use environment::EnvironmentCache;
use reach::Reach;
use splats::SplatMemory;
use std::sync::Arc;
use std::time::Duration;
use tile_pass::Pass;
use tiles::{TileMemory, count_tiles, render_tiles};
use work::{Spent, Work};

/// Chunks that are kept after a picture that needs fewer: a quarter of a million triangles, some 25 MB.
const SPARE_CHUNKS: usize = 64;

/// Renders scenes, keeping threads, buffers and filtered environments from one picture to the next.
#[derive(Debug, Default)]
pub struct Renderer {
    jobs: Jobs,
    fixed: Fixed,
    memory: Memory,
}

/// What is kept from one picture to the next.
#[derive(Debug, Default)]
struct Memory {
    pattern: Option<SamplePattern>,
    environments: EnvironmentCache,
    lights: Vec<PunctualLight>,
    area_lights: Vec<AreaLight>,
    reach: Reach,
    costs: Vec<ShadingCost>,
    states: Vec<DrawState>,
    /// Empty between pictures.
    draws: Vec<Draw<'static>>,
    vertices: ScreenVertices,
    /// Empty between pictures.
    vertex_jobs: Vec<VertexJob<'static>>,
    /// Those of the picture, and spare ones.
    chunks: Vec<Chunk>,
    bins: TileBins,
    splats: SplatMemory,
    tiles: TileMemory,
    backdrop: Backdrop,
    /// Those of pictures that were given back.
    planes: Planes,
    work_done: WorkDone,
}

/// One picture, as a frame or for a screen: the planes of what is not wanted are empty.
struct Taken {
    frame: Frame,
    image: DisplayImage,
    tinted: bool,
    clipping: Clipping,
    exposure: f32,
    stats: RenderStats,
}

/// Vertices of one draw that are transformed in one go.
#[derive(Debug)]
struct VertexJob<'a> {
    view: &'a DrawView,
    positions: &'a [[f32; 3]],
    places: &'a mut [[i32; 2]],
    depths: &'a mut [f32],
}

impl Renderer {
    /// A renderer with `threads` workers; 0 stands for one per processor, and more than [`crate::jobs::MAX_THREADS`] for so
    /// many.
    #[must_use]
    pub fn new(threads: usize) -> Self {
        Self { jobs: Jobs::new(threads), fixed: Fixed::default(), memory: Memory::default() }
    }

    /// For a renderer with other settings than those of [`Renderer::new`].
    pub fn builder() -> RendererBuilder {
        RendererBuilder::default()
    }

    /// The worker threads, for loaders to share.
    #[must_use]
    pub fn jobs(&self) -> &Jobs {
        &self.jobs
    }

    /// The work that was counted for the last picture whose tiles were begun, whether it was finished or not: how far beyond a
    /// limit the threads got depends on timing.
    #[must_use]
    pub fn work_done(&self) -> WorkDone {
        self.memory.work_done
    }

    /// Lights the following pictures by an environment that is filtered already, in place of the scene's picture; its
    /// rotation and intensity stay the scene's. `None` goes back to the scene's own.
    #[doc(hidden)]
    pub fn use_environment(&mut self, environment: Option<Arc<PrefilteredEnvironment>>) {
        self.memory.environments.given = environment;
    }

    /// Gives back a frame that is not needed any more: the next picture takes its memory in place of new memory, which
    /// the system would have to clear.
    ///
    /// If every frame is given back, a picture like an earlier one allocates nothing, but for one block of about 1.5 KB
    /// in the queue of the worker threads every 63 pictures, if there are several. G-buffer planes and
    /// [`RenderOptions::stage_hashes`] take new memory each time.
    pub fn recycle(&mut self, frame: Frame) {
        self.memory.planes.linear = frame.pixels;
        self.memory.planes.transmittance = frame.transmittance;
    }

    /// As [`Renderer::recycle`], with a picture for a screen.
    pub fn recycle_image(&mut self, image: DisplayImage) {
        self.memory.planes.display = image.pixels;
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
        let Taken { frame, stats, .. } = self.take(scene, camera, options, None)?;
        Ok(Rendered { frame, stats })
    }

    /// Takes one picture for a screen: the pixels that [`DisplayImage::new`] makes of [`Renderer::render`]'s frame, every
    /// byte of them, without the frame. Tiles go to 8 bits while they are in the cache, and a picture takes four bytes a
    /// pixel in place of twenty; with surfaces that refract what is behind them, or [`RenderOptions::stage_hashes`], the
    /// frame is made all the same.
    ///
    /// # Errors
    /// As [`Renderer::render`].
    pub fn render_image(
        &mut self,
        scene: &Scene,
        camera: &Camera,
        options: &RenderOptions,
        display: &DisplayOptions,
    ) -> Result<RenderedImage, RenderError> {
        let Taken { frame, image, tinted, clipping, exposure, stats } =
            self.take(scene, camera, options, Some(display))?;
        let aovs = frame.aovs;
        if !frame.pixels.is_empty() {
            self.memory.planes.linear = frame.pixels;
            self.memory.planes.transmittance = frame.transmittance;
        }
        Ok(RenderedImage { image, aovs, tinted, clipping, exposure, stats })
    }

    fn take(
        &mut self,
        scene: &Scene,
        camera: &Camera,
        options: &RenderOptions,
        display: Option<&DisplayOptions>,
    ) -> Result<Taken, RenderError> {
        if !arithmetic_is_default() {
            return Err(RenderError::FloatingPointMode);
        }
        let Self { jobs, fixed, memory } = self;
        let options = fixed.among(options);
        // All of it on a worker, so that work is handed over once and not in every loop.
        jobs.on_worker(|| memory.take(jobs, scene, camera, &options, display))
    }
}

impl Memory {
    /// Takes a picture, on a worker: a frame, or one for a screen.
    fn take(
        &mut self,
        jobs: &Jobs,
        scene: &Scene,
        camera: &Camera,
        options: &RenderOptions,
        display: Option<&DisplayOptions>,
    ) -> Result<Taken, RenderError> {
        let pattern = options.validate(self.pattern.take())?;
        camera.validate()?;
        let triangles = scene.triangle_count();
        let check = |what: &str, asked, limit, field| Limits::check(|| what.to_owned(), asked, limit, field);
        check("scene", triangles, options.limits.triangles, "triangles")?;
        // They have numbers of 32 bits.
        check("scene", scene.splat_count(), options.limits.vertices.min(1 << 31), "vertices")?;
        check("scene", scene.lights().len() as u64, options.limits.lights, "lights")?;
        let default_side = tile_pass::default_tile_size(options.samples);
        let default_grid = TileGrid::new(options.width, options.height, default_side);
        let budget = FrameBudget::new(scene, &options.limits, default_grid)?;
        let mut crew = Crew::new(jobs);

        let view = View::new(camera, options.width, options.height)?;
        let side = options.tile_size.unwrap_or(default_side);
        let grid = TileGrid::new(options.width, options.height, side);
        let surroundings = scene.environment();
        // What is filtered now, or found of points, is used for many pictures.
        let filters = self.environments.would_filter(&surroundings.source);
        let finds = unknown_clouds(scene).next().is_some();
        if (filters || finds) && jobs.on_every_worker(arithmetic_is_default).contains(&false) {
            return Err(RenderError::FloatingPointMode);
        }
        let filtered = self.environments.get(&surroundings.source, jobs, options.simd);
        let environment =
            EnvironmentLight::new(&filtered, surroundings.rotation_degrees, surroundings.intensity);
        self.lights.clear();
        self.lights.extend(scene.lights().iter().filter_map(PunctualLight::new));
        self.area_lights.clear();
        self.area_lights.extend(scene.lights().iter().filter_map(AreaLight::new));
        let environment_time = crew.lap();

        for mesh in unknown_clouds(scene) {
            mesh.set_surfels(estimate_surfels(mesh, jobs));
        }
        let mut draws = emptied(std::mem::take(&mut self.draws));
        self.states.clear();
        let vertex_count = draws::prepare(scene, &view, options.point_size, &mut self.states, &mut draws);
        self.transform(&mut crew, &draws, vertex_count, options);
        let vertices_time = crew.lap();
        let chunks = self.set_up_triangles(&mut crew, &draws, &grid, &pattern, options, &budget);
        let splats = self.splats.prepare(&mut crew, scene, &view, &grid, &budget);
        budget.check()?;
        let chunks = &self.chunks[..chunks];
        self.bins.build(grid.len(), chunks.iter().map(|c| &c.bins));
        let rasterized = chunks.iter().map(|c| c.triangles.len() as u64 + u64::from(c.kept)).sum();
        let triangles_time = crew.lap();

        let hashes = options.stage_hashes.then(|| StageHashes {
            scene: trace::scene(scene),
            environment: trace::environment(&filtered),
            geometry: trace::geometry(&self.vertices, chunks, &self.states, &draws, splats.in_order()),
            ..StageHashes::default()
        });
        self.reach.find(&self.lights, &view);
        let shade = ShadeContext {
            draws: &draws,
            materials: scene.materials(),
            textures: scene.textures(),
            rays: view_rays(&view),
            environment: &environment,
            lights: &self.lights,
            area_lights: &self.area_lights,
            model: options.shading,
            area_light_method: options.area_lights,
            anisotropy: options.anisotropy,
        };
        self.costs.clear();
        self.costs.extend(scene.materials().iter().map(|material| ShadingCost::of(material, &shade)));
        let count = options.width as usize * options.height as usize;
        let work = Work::new(&options.limits, count as u64);
        let mut pass = Pass {
            grid,
            pattern: &pattern,
            chunks,
            states: &self.states,
            shade,
            work: &work,
            costs: &self.costs,
            reach: &self.reach,
            only_counts: false,
            splats,
            merge: merge_cosine(options.merge_angle),
            show_environment: options.background == Background::Environment,
            backdrop: None,
            blank: [false; 2],
            redraws: false,
            tints: options.background != Background::Environment
                && self.states.iter().any(|state| state.transmissive),
            developer: display.filter(|display| !display.meter).map(Developer::new),
            meters: !scene.lights().is_empty(),
        };
        let refracts = self.states.iter().any(|state| state.refracts);
        // Of the linear light nothing is kept but what is seen through surfaces that refract, and what is metered.
        let meter = display.filter(|display| display.meter);
        let keeps_light = display.is_none() || refracts || options.stage_hashes || meter.is_some();
        let mut planes = Planes::default();
        if keeps_light {
            (planes.linear, pass.blank[0]) = plane(&mut self.planes.linear, count, [0.0; 4]);
        }
        if keeps_light && pass.tints {
            (planes.transmittance, _) = plane(&mut self.planes.transmittance, count, [0.0; 3]);
        }
        let mut fragments = 0;
        if refracts {
            let plain = RenderOptions { aovs: Vec::new(), stage_hashes: false, ..options.clone() };
            fragments =
                render_tiles(&mut crew, &pass, &self.bins, &mut self.tiles, &mut planes, &plain).fragments;
            blur_backdrop(&mut crew, &mut self.backdrop, options, &planes.linear);
            (pass.blank[0], pass.redraws) = (false, true);
        }
        if display.is_some() {
            (planes.display, pass.blank[1]) = plane(&mut self.planes.display, count, [0; 4]);
        }
        pass.backdrop = Some(&self.backdrop);
        let found = render_tiles(&mut crew, &pass, &self.bins, &mut self.tiles, &mut planes, options);
        fragments += found.fragments;
        self.work_done = work.done();
        if work.is_stopped() {
            if side != default_side {
                // Which limit is named must not depend on the tiles.
                let options = RenderOptions { tile_size: None, ..options.clone() };
                return self.take(jobs, scene, camera, &options, display);
            }
            // Nor on the threads: the first that one would pass is.
            let work = Work::new(&options.limits, count as u64);
            (pass.work, pass.only_counts, pass.redraws) = (&work, true, false);
            let mut costs = Vec::new();
            if refracts {
                pass.backdrop = None;
                count_tiles(&pass, &self.bins, &mut costs, options);
                (pass.backdrop, pass.redraws) = (Some(&self.backdrop), true);
            }
            count_tiles(&pass, &self.bins, &mut costs, options);
            work.check()?;
        }
        if !crew.arithmetic_is_default() {
            return Err(RenderError::FloatingPointMode);
        }
        let (width, height) = (options.width, options.height);
        let Planes { linear: pixels, transmittance, display: screen } = planes;
        let frame = Frame { width, height, pixels, transmittance, aovs: found.aovs };
        let mut image = DisplayImage { width, height, pixels: screen };
        let (mut clipping, mut exposure) = (found.clipping, display.map_or(0.0, |display| display.exposure));
        if let Some(display) = meter {
            let metered = display.metered(&frame);
            let developer = Developer::new(&metered);
            let (light, open) = (&frame.pixels, &frame.transmittance);
            dispatch!(options.simd, l => developer.develop(l, light, open, &mut image.pixels));
            exposure = metered.exposure;
            clipping = image.clipping(&frame);
        }
        self.draws = emptied(draws);
        self.pattern = Some(pattern);
        let tiles_time = crew.lap();
        let stages = [
            ("environment", environment_time),
            ("vertices", vertices_time),
            ("triangles", triangles_time),
            ("tiles", tiles_time),
        ];
        let stats = RenderStats {
            triangles,
            triangles_rasterized: rasterized,
            splats: scene.splat_count(),
            splats_drawn: splats.len() as u64,
            fragments,
            shading: work.sum(Spent::Shading),
            covered: found.covered,
            stages,
            serial: stages.iter().map(|(_, time)| *time).sum::<Duration>().saturating_sub(crew.parallel()),
            stage_hashes: hashes.zip(found.hashes).map(|(hashes, found)| hashes.finish(&found, &frame)),
        };
        Ok(Taken { frame, image, tinted: found.tinted, clipping, exposure, stats })
    }

    /// All vertices of all draws to the screen.
    fn transform(&mut self, crew: &mut Crew<'_>, draws: &[Draw<'_>], count: usize, options: &RenderOptions) {
        // Every one is written below.
        self.vertices.resize(count);
        let mut work = emptied(std::mem::take(&mut self.vertex_jobs));
        let (mut places, mut depths) = (&mut self.vertices.places[..], &mut self.vertices.depths[..]);
        for (state, draw) in self.states.iter().zip(draws).filter(|(state, _)| !state.vertices.is_empty()) {
            for positions in draw.mesh.positions().chunks(VERTICES_PER_CHUNK) {
                let (own_places, own_depths);
                (own_places, places) = places.split_at_mut(positions.len());
                (own_depths, depths) = depths.split_at_mut(positions.len());
                work.push(VertexJob { view: &state.view, positions, places: own_places, depths: own_depths });
            }
        }
        crew.for_each_mut(&mut work, |_, VertexJob { view, positions, places, depths }| {
            dispatch!(options.simd, l => transform_vertices(l, view, positions, places, depths));
        });
        self.vertex_jobs = emptied(work);
    }

    /// All triangles of all draws to chunks of screen triangles, binned. Chunks never straddle draws. Returns the
    /// number of chunks. Once the budget is spent the rest is left out, and there will be no picture.
    fn set_up_triangles(
        &mut self,
        crew: &mut Crew<'_>,
        draws: &[Draw<'_>],
        grid: &TileGrid,
        pattern: &SamplePattern,
        options: &RenderOptions,
        budget: &FrameBudget,
    ) -> usize {
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
        let (vertices, states) = (&self.vertices, &self.states);
        crew.for_each_mut(&mut self.chunks[..count], |_, chunk| {
            if budget.is_spent() {
                return;
            }
            let state = &states[chunk.draw as usize];
            let mesh = draws[chunk.draw as usize].mesh;
            let max_bins = usize::try_from(budget.references(grid)).unwrap_or(usize::MAX);
            let job = ChunkJob {
                mesh,
                vertices: vertices.slice(state.vertices.clone()),
                view: &state.view,
                cull_back_faces: state.cull_back_faces,
                mirrored: state.mirrored,
                max_bins,
            };
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
}

/// Meshes of points of which it is not known yet what they are drawn as. One that is drawn often is listed once: what is
/// found shows while the list is walked.
fn unknown_clouds(scene: &Scene) -> impl Iterator<Item = &Mesh> {
    let meshes = scene.instances().iter().map(|instance| &scene.meshes()[instance.mesh.index()]);
    meshes.filter(|mesh| mesh.kind() == PrimitiveKind::Points && mesh.surfels().is_none())
}

/// Takes a picture as the backdrop of refracting surfaces, with all of its blurred levels.
fn blur_backdrop(crew: &mut Crew<'_>, backdrop: &mut Backdrop, options: &RenderOptions, pixels: &[[f32; 4]]) {
    backdrop.start(options.width as usize, options.height as usize, pixels);
    while let Some((last, mut rows)) = backdrop.halve() {
        crew.for_each_mut(&mut rows, |y, row| last.halved_row(y, row));
    }
}

/// A plane of a picture, of which tiles write all; and whether it is zero now. It is `kept` if that is large enough, or new
/// memory that the system clears, page by page when a tile first writes to it.
fn plane<T: Copy>(kept: &mut Vec<T>, count: usize, zero: T) -> (Vec<T>, bool) {
    let mut plane = std::mem::take(kept);
    if plane.capacity() < count {
        return (vec![zero; count], true);
    }
    plane.resize(count, zero);
    (plane, false)
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
