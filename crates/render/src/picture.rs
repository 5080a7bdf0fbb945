//! One picture: the stages in their order.

use super::environment::{EnvironmentCache, foreseen};
use super::passes::{PassMemory, check_limits, work_of};
use super::pick::LastPicture;
use super::rendered::RenderStats;
use super::setup::{GeometryMemory, SetUp, unknown_clouds};
use super::textures::TextureMemory;
use super::tiles::Found;
use overcoat_core::built::{AreaLights, CarPaint, Environments, Shadows, Splats};
use overcoat_core::dispatch_available;
use overcoat_core::frame::{Clipping, Developer, DisplayImage, DisplayOptions, Frame, Target};
use overcoat_core::jobs::Jobs;
use overcoat_core::limits::{LimitExceeded, Limits};
use overcoat_core::reuse::emptied;
use overcoat_scene::{Camera, Environment, EnvironmentSource, Material, Scene, Texture};
use overcoat_stages::gbuffer::Draw;
use overcoat_stages::geometry::View;
use overcoat_stages::light::{AreaLight, EnvironmentLight, PrefilteredEnvironment};
use overcoat_stages::raster::SamplePattern;
use overcoat_stages::shade::{ShadeContext, ShadingCost, ViewRays};
use overcoat_stages::tile::{TileBins, TileGrid};
use overcoat_tiles::bands::Planes;
use overcoat_tiles::budget::FrameBudget;
use overcoat_tiles::cancel::Cancellation;
use overcoat_tiles::crew::{Crew, arithmetic_is_default};
use overcoat_tiles::effects::EffectMemory;
use overcoat_tiles::ground_light::GroundLight;
use overcoat_tiles::ground_pixels::GroundView;
use overcoat_tiles::lamps::LightMemory;
use overcoat_tiles::light_filter::MARGIN;
use overcoat_tiles::mirror::{MirrorMemory, camera_of_mirror, options_of_mirror};
use overcoat_tiles::options::{Background, RenderError, RenderOptions};
use overcoat_tiles::pass::FrameContext;
use overcoat_tiles::shading_rate::Finer;
use overcoat_tiles::splats::SplatMemory;
use overcoat_tiles::tile_pass::default_tile_size;
use overcoat_tiles::trace::{self, StageHashes};
use overcoat_tiles::work::{Spent, Work, WorkDone};
use std::borrow::Cow;
use std::time::Duration;

/// What is asked for.
#[derive(Clone, Copy)]
pub(super) struct Request<'a> {
    pub jobs: &'a Jobs,
    pub scene: &'a Scene,
    pub camera: &'a Camera,
    pub options: &'a RenderOptions,
    /// For a screen; else a frame.
    pub display: Option<&'a DisplayOptions>,
    /// Who may stop it.
    pub cancellation: Option<&'a Cancellation>,
}

/// One picture, as a frame or for a screen: the planes of what is not wanted are empty.
pub(super) struct Drawn {
    pub frame: Frame,
    pub image: DisplayImage,
    pub tinted: bool,
    pub clipping: Clipping,
    pub exposure: f32,
    pub stats: RenderStats,
}

/// What is kept from one picture to the next.
#[derive(Debug, Default)]
pub(super) struct Memory {
    pub pattern: Option<SamplePattern>,
    pub environments: EnvironmentCache,
    pub lights: LightMemory,
    costs: Vec<ShadingCost>,
    finer: Vec<Finer>,
    /// Empty between pictures.
    pub draws: Vec<Draw<'static>>,
    pub geometry: GeometryMemory,
    pub bins: TileBins,
    pub textures: TextureMemory,
    splats: SplatMemory,
    ground: GroundLight,
    mirror: MirrorMemory,
    pub passes: PassMemory,
    pub work_done: WorkDone,
    /// What [`Memory::geometry`] and [`Memory::bins`] are of, if they are whole.
    pub last: Option<LastPicture>,
}

/// Outcome of an attempt at a picture.
#[allow(
    clippy::large_enum_variant,
    reason = "there is one at a time, and a box would be an allocation for each picture"
)]
enum Attempt {
    /// The picture.
    Done(Drawn),
    /// Some textures cannot be decoded: the scene without them, which is to be drawn.
    LostTextures(Scene),
    /// Levels of the environment were read that nobody foresaw: they are known now.
    MoreLight,
    /// A limit was passed with tiles of a size that was asked for: those of the default say which limit.
    DefaultTiles,
}

impl Request<'_> {
    /// `Ok` if nobody has stopped it.
    pub(super) fn go_on(&self) -> Result<(), RenderError> {
        match self.cancellation {
            Some(cancellation) if cancellation.is_cancelled() => Err(RenderError::Cancelled),
            _ => Ok(()),
        }
    }
}

impl Memory {
    /// Draws a picture, on a worker: a frame, or one for a screen.
    pub(super) fn draw(&mut self, request: &Request<'_>) -> Result<Drawn, RenderError> {
        self.draw_into(request, None)
    }

    /// Draws a picture for a screen, or the part of it that a target holds, into the target alone.
    pub(super) fn draw_into(
        &mut self,
        request: &Request<'_>,
        mut target: Option<(&mut Target<'_>, [u32; 4])>,
    ) -> Result<Drawn, RenderError> {
        let mut without_lost = None;
        let mut options = Cow::Borrowed(request.options);
        loop {
            let scene = without_lost.as_ref().unwrap_or(request.scene);
            let request = Request { scene, options: &options, ..*request };
            let target = target.as_mut().map(|(target, region)| (&mut **target, *region));
            match self.attempt(&request, target)? {
                Attempt::Done(drawn) => return Ok(drawn),
                Attempt::LostTextures(rest) => without_lost = Some(rest),
                Attempt::MoreLight => {}
                Attempt::DefaultTiles => options.to_mut().tile_size = None,
            }
        }
    }

    /// Draws a picture, or says what it has to be drawn again with.
    fn attempt(
        &mut self,
        request: &Request<'_>,
        mut target: Option<(&mut Target<'_>, [u32; 4])>,
    ) -> Result<Attempt, RenderError> {
        let &Request { jobs, scene, options, .. } = request;
        self.last = None;
        // Refuse what is out of range or too much, before anything is made.
        let (pattern, view, mut budget) = self.check(request)?;
        request.go_on()?;
        let mirrored = self.draw_mirrored(request)?;
        self.last = None;
        let mut crew = Crew::new(jobs);

        // Decode the textures that decide about what is seen, if they are decoded by need.
        let mut textures = std::mem::take(&mut self.textures);
        let mut unsurveyed = textures.begin(request);
        if let Some(rest) = scene.without_lost_textures() {
            return Ok(Attempt::LostTextures(rest));
        }
        let mut textures_time = crew.lap();

        // Filter the environment, and find where the lights shine and what is in their way.
        let levels = foreseen(scene, options);
        let filtered = self.environments.get(&scene.environment().source, levels, jobs, options.simd);
        let environment = environment_light(scene, &filtered);
        self.prepare_lights(&crew, request, &view, &environment)?;
        let environment_time = crew.lap();
        request.go_on()?;

        // Bring the vertices to the screen.
        let mut draws = emptied(std::mem::take(&mut self.draws));
        self.geometry.place_vertices(&mut crew, scene, &view, options, &mut draws);
        let vertices_time = crew.lap();

        // Set up triangles and splats, and list them for the tiles.
        let region = target.as_ref().map(|(_, region)| *region);
        let (grid, drawn) = self.listed_grid(options, region, &mut budget);
        let to = SetUp { grid: &grid, pattern: &pattern, budget: &budget };
        let count = self.geometry.set_up_triangles(&mut crew, &draws, &to, options);
        let splats = self.splats.prepare(&mut crew, scene, &view, &grid, &budget);
        budget.check()?;
        let GeometryMemory { states, vertices, chunks, .. } = &self.geometry;
        let chunks = &chunks[..count];
        self.bins.build(grid.len(), chunks.iter().map(|c| &c.bins));
        let triangles_time = crew.lap();

        let hashes = options.stage_hashes.then(|| {
            let geometry = trace::geometry(vertices, chunks, states, &draws, splats.in_order());
            let light = (&self.passes.effects, &self.lights, &self.ground);
            let mirror = mirrored.as_ref().map(|_| &self.mirror);
            hashes_before_tiles(request, StageHashes::before_tiles(scene, &filtered, geometry), light, mirror)
        });

        // Say what all tiles share.
        let emitter_rays = self.passes.effects.emitter_rays();
        let shade =
            shade_context(request, scene.textures(), &view, &draws, &environment, &self.lights, emitter_rays);
        self.costs.clear();
        self.costs.extend(scene.materials().iter().map(|material| ShadingCost::of(material, &shade)));
        Finer::list(scene.materials(), scene.textures(), options, &mut self.finer);
        let show_environment = options.background == Background::Environment;
        let mirror = mirrored.as_ref().map(|_| self.mirror.of(options.ground_reflection));
        let ground = GroundView::new(&self.ground, options, &view, mirror);
        let mut tiles_time = Duration::ZERO;
        let (frame, work, planes, found) = loop {
            let frame = FrameContext {
                grid,
                pattern: &pattern,
                chunks,
                bins: &self.bins,
                states,
                splats,
                shade: ShadeContext { textures: textures.of(scene), ..shade },
                costs: &self.costs,
                reach: &self.lights.reach,
                show_environment,
                ground,
                tints: !show_environment && states.iter().any(|state| state.transmissive),
                merge: merge_cosine(options.merge_angle),
                finer: &self.finer,
                drawn,
            };

            // Decode the textures that it reads, if they are decoded by need.
            if std::mem::take(&mut unsurveyed) {
                self.passes.survey(&mut crew, &frame, request);
                let survey_time = crew.lap();
                textures.fetch(jobs, scene);
                textures_time += crew.lap();
                tiles_time += survey_time;
                if let Some(rest) = scene.without_lost_textures() {
                    return Ok(Attempt::LostTextures(rest));
                }
                continue;
            }

            // Draw the tiles; again if they read what is not there.
            let work = work_of(&frame, request);
            let reborrowed = target.as_mut().map(|(target, region)| (&mut **target, *region));
            let (planes, found) = self.passes.draw(&mut crew, &frame, &work, request, reborrowed);
            let dark = filtered.misses_any_of(filtered.lacking());
            if !(textures.lacks() || dark) || work.is_stopped() {
                break (frame, work, planes, found);
            }
            tiles_time += crew.lap();
            self.passes.planes = planes;
            if dark {
                self.textures = textures;
                return Ok(Attempt::MoreLight);
            }
            textures.fetch(jobs, scene);
            textures_time += crew.lap();
            if let Some(rest) = scene.without_lost_textures() {
                return Ok(Attempt::LostTextures(rest));
            }
        };
        self.work_done = work.done();
        request.go_on()?;
        if work.is_stopped() {
            // Which limit is named must not depend on the tiles, nor on the threads: the first that one would pass is.
            if grid.side() != budget.grid().side() {
                return Ok(Attempt::DefaultTiles);
            }
            check_limits(&frame, request)?;
        }
        if !crew.arithmetic_is_default() {
            return Err(RenderError::FloatingPointMode);
        }

        // Make the picture of their pixels.
        let mut drawn = Drawn::new(planes, found.clipping, request);
        tiles_time += crew.lap();
        let times = [textures_time, environment_time, vertices_time, triangles_time, tiles_time];
        drawn.stats = stats(scene, &frame, &work, &found, times, crew.parallel());
        if let Some(mirrored) = &mirrored {
            drawn.stats.add_cost(mirrored);
        }
        drawn.stats.stage_hashes =
            hashes.zip(found.hashes).map(|(hashes, found)| hashes.finish(&found, &drawn.frame));
        (drawn.frame.aovs, drawn.tinted) = (found.aovs, found.tinted);
        self.draws = emptied(draws);
        textures.end();
        self.textures = textures;
        self.pattern = Some(pattern);
        self.last = Some(LastPicture::new(request, grid, count));
        Ok(Attempt::Done(drawn))
    }

    /// Finds where the lights shine and what is in their way.
    fn prepare_lights(
        &mut self,
        crew: &Crew<'_>,
        request: &Request<'_>,
        view: &View,
        environment: &EnvironmentLight<'_>,
    ) -> Result<(), RenderError> {
        let &Request { scene, options, .. } = request;
        self.lights.list(scene, view);
        self.passes.effects.before(crew, scene, environment, options)?;
        self.lights.find_shadows(crew, scene, self.passes.effects.visibility(), options)?;
        let maps = self.passes.effects.maps_of_ground().filter(|_| options.ground.is_seen());
        self.ground.prepare(crew, scene, maps, (environment, &self.lights), options);
        Ok(())
    }

    /// The tiles for which triangles are listed, and columns and rows of those that are drawn: all, or where a region is.
    fn listed_grid(
        &self,
        options: &RenderOptions,
        region: Option<[u32; 4]>,
        budget: &mut FrameBudget,
    ) -> (TileGrid, [u32; 4]) {
        let grid = tile_grid(options, options.tile_size);
        let Some(region) = region else { return (grid, [0, 0, grid.columns(), grid.rows()]) };
        let drawn = grid.tiles_of_pixels(region);
        // Refracting surfaces may show any other part of the picture.
        if self.geometry.states.iter().any(|state| state.refracts) {
            return (grid, drawn);
        }
        // What the rays of pixels beside it have found shows in it.
        let margin = if options.visibility.rays > 0 { MARGIN as u32 } else { 0 };
        let [left, top, right, bottom] = region;
        let [right, bottom] = [(right, options.width), (bottom, options.height)]
            .map(|(end, side)| end.saturating_add(margin).min(side));
        let region = [left.saturating_sub(margin), top.saturating_sub(margin), right, bottom];
        budget.list_within(region);
        (grid.listed_within(region), drawn)
    }

    /// Draws what the floor mirrors, if it mirrors anything. Returns what that took.
    fn draw_mirrored(&mut self, request: &Request<'_>) -> Result<Option<RenderStats>, RenderError> {
        let &Request { scene, camera, options, .. } = request;
        let Some(camera) = camera_of_mirror(scene, camera, options) else { return Ok(None) };
        let options = options_of_mirror(options);
        // Each of the two pictures finds its own memory again, and the first what it knows of the floor.
        self.swap_with_mirror();
        let drawn = self.draw(&Request { camera: &camera, options: &options, display: None, ..*request });
        self.swap_with_mirror();
        let Drawn { frame, stats, .. } = drawn?;
        self.mirror.keep(frame);
        Ok(Some(stats))
    }

    fn swap_with_mirror(&mut self) {
        std::mem::swap(&mut self.passes.planes, &mut self.mirror.planes);
        std::mem::swap(&mut self.ground, &mut self.mirror.light);
        std::mem::swap(&mut self.textures.surveyed, &mut self.mirror.surveyed);
    }

    /// Holds options, camera, scene and threads against what is allowed. Returns the pattern of the samples, the view, and what
    /// is left for the picture's memory.
    pub(super) fn check(
        &mut self,
        request: &Request<'_>,
    ) -> Result<(SamplePattern, View, FrameBudget), RenderError> {
        let &Request { jobs, scene, camera, options, .. } = request;
        let pattern = options.validate(self.pattern.take())?;
        camera.validate()?;
        check_parts(scene, options)?;
        check_scene(scene, &options.limits)?;
        let budget = FrameBudget::new(scene, &options.limits, tile_grid(options, None))?;
        let view = View::new(camera, options.width, options.height)?;
        // What is filtered now, or found of points, is used for many pictures.
        let filters = self.environments.would_filter(&scene.environment().source, foreseen(scene, options));
        let finds = unknown_clouds(scene).next().is_some();
        if (filters || finds) && jobs.on_every_worker(arithmetic_is_default).contains(&false) {
            return Err(RenderError::FloatingPointMode);
        }
        Ok((pattern, view, budget))
    }
}

impl Drawn {
    /// Makes a frame of its planes, and a picture for a screen if one is asked for that must be metered first.
    fn new(planes: Planes, clipping: Clipping, request: &Request<'_>) -> Self {
        let &Request { options, display, .. } = request;
        let (width, height) = (options.width, options.height);
        let Planes { linear: pixels, transmittance, display: screen, .. } = planes;
        let mut drawn = Self {
            frame: Frame { width, height, pixels, transmittance, aovs: Vec::new() },
            image: DisplayImage { width, height, pixels: screen },
            tinted: false,
            clipping,
            exposure: display.map_or(0.0, |display| display.exposure),
            stats: RenderStats::default(),
        };
        if let Some(display) = display.filter(|display| display.meter) {
            let metered = display.metered(&drawn.frame);
            let developer = Developer::new(&metered);
            let (light, open) = (&drawn.frame.pixels, &drawn.frame.transmittance);
            dispatch_available!(options.simd, l => developer.develop(l, light, open, &mut drawn.image.pixels));
            drawn.exposure = metered.exposure;
            drawn.clipping = drawn.image.clipping(&drawn.frame);
        }
        drawn
    }
}

/// `Ok` if all that a picture needs is compiled in.
fn check_parts(scene: &Scene, options: &RenderOptions) -> Result<(), RenderError> {
    let has_areas = || scene.lights().iter().any(|light| AreaLight::new(light).is_some());
    let has_paint = || scene.materials().iter().any(Material::is_painted);
    let has_picture = || matches!(scene.environment().source, EnvironmentSource::Image(_));
    let parts = [
        (Shadows::IS_BUILT || !options.visibility.is_on(), "quality beyond draft", "shadows"),
        (Shadows::IS_BUILT || !options.ground.is_seen(), "ground", "shadows"),
        (AreaLights::IS_BUILT || !has_areas(), "lights with an extent", "area-lights"),
        (CarPaint::IS_BUILT || !has_paint(), "car paint", "car-paint"),
        (Splats::IS_BUILT || scene.splat_count() == 0, "splats", "splats"),
        (Environments::IS_BUILT || !has_picture(), "an environment of a picture", "environments"),
    ];
    match parts.into_iter().find(|(is_there, ..)| !is_there) {
        Some((_, part, feature)) => Err(RenderError::built_without(part, feature)),
        None => Ok(()),
    }
}

/// `Ok` if a scene is not larger than allowed.
fn check_scene(scene: &Scene, limits: &Limits) -> Result<(), LimitExceeded> {
    let check = |asked, limit, field| Limits::check(|| "scene".to_owned(), asked, limit, field);
    check(scene.triangle_count(), limits.triangles, "triangles")?;
    // They have numbers of 32 bits.
    check(scene.splat_count(), limits.vertices.min(1 << 31), "vertices")?;
    check(scene.lights().len() as u64, limits.lights, "lights")
}

/// The tiles of a picture, of that side or the default one.
pub(super) fn tile_grid(options: &RenderOptions, side: Option<u32>) -> TileGrid {
    let side = side.unwrap_or_else(|| default_tile_size(options.samples));
    TileGrid::new(options.width, options.height, side)
}

/// The filtered environment as a scene turns and dims it.
pub(super) fn environment_light<'a>(
    scene: &Scene,
    filtered: &'a PrefilteredEnvironment,
) -> EnvironmentLight<'a> {
    let Environment { rotation_degrees, intensity, .. } = *scene.environment();
    EnvironmentLight::new(filtered, rotation_degrees, intensity)
}

/// What the shading knows of the picture as a whole.
pub(super) fn shade_context<'a>(
    request: &Request<'a>,
    textures: &'a [Texture],
    view: &View,
    draws: &'a [Draw<'a>],
    environment: &'a EnvironmentLight<'a>,
    lights: &'a LightMemory,
    emitter_rays: u32,
) -> ShadeContext<'a> {
    let &Request { scene, options, .. } = request;
    ShadeContext {
        draws,
        materials: scene.materials(),
        textures,
        rays: view_rays(view),
        environment,
        lights: &lights.punctual,
        area_lights: &lights.areas,
        model: options.shading,
        area_light_method: options.area_lights,
        anisotropy: options.anisotropy,
        maps: options.visibility.maps,
        lamps: lights.shadows(),
        lobe_rays: options.visibility.rays,
        emitter_rays,
        specular_antialiasing: options.specular_antialiasing,
    }
}

/// Adds what is prepared of the light, and what the floor shows of it, to the hashes of the stages before.
fn hashes_before_tiles(
    request: &Request<'_>,
    mut hashes: StageHashes,
    (effects, lights, ground): (&EffectMemory, &LightMemory, &GroundLight),
    mirror: Option<&MirrorMemory>,
) -> StageHashes {
    let has_ground = request.options.ground.is_seen();
    (hashes.depth_maps, hashes.hierarchy) = effects.hashes(has_ground);
    let lamps = if has_ground { lights.shadows_of_ground() } else { lights.shadows() };
    hashes.lamp_maps = lamps.map_or(0, |lamps| trace::lamp_maps(&lamps));
    let light = has_ground.then(|| ground.texels());
    hashes.ground = light.filter(|texels| !texels.is_empty()).map_or(0, trace::ground);
    if let Some(mirror) = mirror {
        hashes.ground = mirror.of(1.0).hashed_with(hashes.ground);
    }
    hashes
}

/// What a picture took: `times` of its stages, and how long it was in loops on all threads.
fn stats(
    scene: &Scene,
    frame: &FrameContext<'_>,
    work: &Work,
    found: &Found,
    times: [Duration; 5],
    parallel: Duration,
) -> RenderStats {
    let [textures, environment, vertices, triangles, tiles] = times;
    let chunks = frame.chunks.iter();
    RenderStats {
        triangles: scene.triangle_count(),
        triangles_rasterized: chunks.map(|c| c.triangles.len() as u64 + u64::from(c.kept)).sum(),
        splats: scene.splat_count(),
        splats_drawn: frame.splats.count() as u64,
        fragments: found.fragments,
        shading: work.sum(Spent::Shading),
        covered: found.covered,
        stages: [
            ("textures", textures),
            ("environment", environment),
            ("vertices", vertices),
            ("triangles", triangles),
            ("tiles", tiles),
        ],
        serial: times.iter().sum::<Duration>().saturating_sub(parallel),
        stage_hashes: None,
    }
}

/// The square of the cosine of an angle in degrees; `None` for 0.
fn merge_cosine(degrees: f32) -> Option<f32> {
    let (_, cosine) =
        overcoat_core::math::double::sin_cos(f64::from(degrees) * (std::f64::consts::PI / 180.0));
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
