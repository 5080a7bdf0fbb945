//! One picture: what is asked for, what is kept for the next, and attempts until one of them succeeds.

use super::attempt::{Attempt, Less, Stop};
use super::centered;
use super::environment::{EnvironmentCache, foreseen};
use super::passes::PassMemory;
use super::pick::LastPicture;
use super::prepared::FrameMemory;
use super::rendered::{ReducedLight, RenderStats, StageTimes};
use super::setup::unknown_clouds;
use super::textures::TextureMemory;
use overcoat_core::built::{AreaLights, CarPaint, Environments, Shadows, Splats};
use overcoat_core::dispatch_available;
use overcoat_core::frame::{Clipping, Developer, DisplayImage, DisplayOptions, Frame, Meter, Target};
use overcoat_core::jobs::Jobs;
use overcoat_core::limits::{LimitExceeded, Limits};
use overcoat_core::math::arithmetic_is_default;
use overcoat_core::reuse::emptied;
use overcoat_scene::{Camera, Environment, EnvironmentSource, Material, Scene, Texture};
use overcoat_stages::gbuffer::Draw;
use overcoat_stages::geometry::View;
use overcoat_stages::light::{AreaLight, EnvironmentLight, PrefilteredEnvironment};
use overcoat_stages::raster::SamplePattern;
use overcoat_stages::shade::ShadeContext;
use overcoat_stages::tile::TileGrid;
use overcoat_tiles::budget::FrameBudget;
use overcoat_tiles::lamps::LightMemory;
use overcoat_tiles::mirror::{camera_of_mirror, options_of_mirror};
use overcoat_tiles::options::{RenderError, RenderOptions};
use overcoat_tiles::relief::Relief;
use overcoat_tiles::strips::Planes;
use overcoat_tiles::tile_pass::default_tile_size;
use overcoat_tiles::timed_pool::TimedPool;
use overcoat_tiles::work::WorkDone;
use std::borrow::Cow;

/// Request for one picture.
#[derive(Clone, Copy)]
pub(super) struct Request<'a> {
    pub jobs: &'a Jobs,
    pub scene: &'a Scene,
    pub camera: &'a Camera,
    pub options: &'a RenderOptions,
    /// For a screen; else a frame.
    pub display: Option<&'a DisplayOptions>,
    /// Handle by which the caller may stop it.
    /// The number of rays was chosen to be within limits.
    pub rays_fit: bool,
    /// Factors of the light of surfaces, once they are found.
    pub relief: Option<&'a Relief>,
    /// Nothing of the picture is wanted but planes of the G-buffer.
    pub only_planes: bool,
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

/// Memory that is kept from one picture to the next.
#[derive(Debug, Default)]
pub(super) struct Memory {
    pub pattern: Option<SamplePattern>,
    pub environments: EnvironmentCache,
    /// Empty between pictures.
    pub draws: Vec<Draw<'static>>,
    pub prepared: FrameMemory,
    pub textures: TextureMemory,
    pub passes: PassMemory,
    pub work_done: WorkDone,
    /// The picture whose geometry and bins are in [`Memory::prepared`], if they are whole.
    pub last: Option<LastPicture>,
}

impl Request<'_> {
    /// `Ok` if nobody has stopped it.
    pub(super) fn go_on(&self) -> Result<(), RenderError> {
        if self.jobs.is_cancelled() { Err(RenderError::Cancelled) } else { Ok(()) }
    }
}

impl Memory {
    /// Draws a picture, on a worker: a frame, or one for a screen.
    pub(super) fn draw(&mut self, request: &Request<'_>) -> Result<Drawn, RenderError> {
        match centered::parts(request.scene, request.options) {
            Some([centered, others]) => self.draw_with_centers(request, &centered, &others),
            None => self.draw_into(request, None),
        }
    }

    /// Draws a picture for a screen, or the part of it that a target holds, into the target alone.
    pub(super) fn draw_into(
        &mut self,
        request: &Request<'_>,
        mut target: Option<(&mut Target<'_>, [u32; 4])>,
    ) -> Result<Drawn, RenderError> {
        let mut relief = self.find_relief(request)?;
        let mut without_lost = None;
        let mut options = Cow::Borrowed(request.options);
        let mut passed = None;
        let mut rays_fit = false;
        loop {
            let scene = without_lost.as_ref().unwrap_or(request.scene);
            let factors = relief.as_ref().map(|found| &found.factors);
            let request = Request { scene, options: &options, rays_fit, relief: factors, ..*request };
            let target = target.as_mut().map(|(target, region)| (&mut **target, *region));
            match self.attempt(&request, target) {
                Ok(mut drawn) => {
                    let light = |limit| ReducedLight { limit, visibility: options.visibility };
                    drawn.stats.reduced_light = passed.map(light).or(drawn.stats.reduced_light);
                    if let Some(found) = &relief {
                        drawn.stats.add_cost(&found.cost);
                    }
                    return Ok(drawn);
                }
                Err(Stop::Error(error)) => return Err(error),
                Err(Stop::LostTextures(rest)) => without_lost = Some(*rest),
                Err(Stop::MoreLight) => {}
                Err(Stop::Indoors) => {
                    let options = options.to_mut();
                    options.visibility = options.visibility.indoors();
                }
                Err(Stop::Light(what, limit)) => match options_with(&options, what) {
                    Some(less) => {
                        rays_fit |= matches!(what, Less::Rays(_));
                        if options.visibility.is_on() && !less.visibility.is_on() {
                            // Relief by default is that of pictures with shadows.
                            relief =
                                self.find_relief(&Request { options: &less, relief: None, ..request })?;
                        }
                        options = Cow::Owned(less);
                        passed = passed.or(Some(limit));
                    }
                    None => return Err(limit.into()),
                },
                Err(Stop::DefaultTiles) => options.to_mut().tile_size = None,
            }
        }
    }

    /// Draws a picture, or says what it has to be drawn again with.
    fn attempt(
        &mut self,
        request: &Request<'_>,
        target: Option<(&mut Target<'_>, [u32; 4])>,
    ) -> Result<Drawn, Stop> {
        // Refuse what is out of range or too much, before anything is made.
        let (pattern, view, budget) = self.check(request)?;
        request.go_on()?;
        let mirrored = self.draw_mirrored(request)?;
        self.last = None;
        let mut draws = emptied(std::mem::take(&mut self.draws));
        let mut attempt = Attempt {
            request,
            pattern: &pattern,
            view: &view,
            region: target.as_ref().map(|(_, region)| *region),
            budget,
            pool: TimedPool::new(request.jobs),
            times: StageTimes::default(),
            mirrored: mirrored.as_ref(),
        };
        let drawn = attempt.run(self, &mut draws, target);
        self.draws = emptied(draws);
        self.textures.end();
        self.pattern = Some(pattern);
        drawn
    }

    /// Draws what the floor mirrors, if it mirrors anything. Returns what that took.
    fn draw_mirrored(&mut self, request: &Request<'_>) -> Result<Option<RenderStats>, RenderError> {
        let &Request { scene, camera, options, .. } = request;
        let Some(camera) = camera_of_mirror(scene, camera, options) else { return Ok(None) };
        let options = options_of_mirror(options);
        // Each of the two pictures finds its own memory again, and the first what it knows of the floor.
        self.swap_with_mirror();
        let own = Request { camera: &camera, options: &options, display: None, relief: None, ..*request };
        let drawn = self.draw(&own);
        self.swap_with_mirror();
        let Drawn { frame, stats, .. } = drawn?;
        self.prepared.mirror.keep(frame);
        Ok(Some(stats))
    }

    fn swap_with_mirror(&mut self) {
        let FrameMemory { ground, mirror, .. } = &mut self.prepared;
        std::mem::swap(&mut self.passes.planes, &mut mirror.planes);
        std::mem::swap(ground, &mut mirror.light);
        std::mem::swap(&mut self.textures.fed_back, &mut mirror.fed_back);
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
        let levels = foreseen(scene, options);
        let filters = self.environments.would_filter(&scene.environment().source, levels);
        let finds = unknown_clouds(scene).next().is_some();
        if (filters || finds) && jobs.on_every_worker(arithmetic_is_default).contains(&false) {
            return Err(RenderError::FloatingPointMode);
        }
        Ok((pattern, view, budget))
    }
}

impl Drawn {
    /// Makes a frame of its planes, and a picture for a screen if one is asked for that must be metered first.
    pub(super) fn new(planes: Planes, clipping: Clipping, request: &Request<'_>) -> Self {
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
        if let Some(display) = display.filter(|display| display.meter != Meter::Never) {
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

/// The options with less light; `None` if there is nothing to leave out.
fn options_with(options: &RenderOptions, less: Less) -> Option<RenderOptions> {
    match less {
        Less::Maps => options.with_less_maps(),
        Less::Rays(rays) => Some(options.clone().with_visibility(options.visibility.with_rays(rays))),
        Less::Any => options.with_less_light(),
    }
}

/// `Ok` if all that a picture needs is compiled in.
fn check_parts(scene: &Scene, options: &RenderOptions) -> Result<(), RenderError> {
    let has_areas = || scene.lights().iter().any(|light| AreaLight::new(light).is_some());
    let has_paint = || scene.materials().iter().any(Material::is_painted);
    let has_picture = || matches!(scene.environment().source, EnvironmentSource::Image(_));
    let parts = [
        (Shadows::IS_BUILT || !options.visibility.is_on(), "quality beyond draft", "light"),
        (Shadows::IS_BUILT || !options.ground.is_seen(), "ground", "light"),
        (AreaLights::IS_BUILT || !has_areas(), "lights with an extent", "light"),
        (CarPaint::IS_BUILT || !has_paint(), "car paint", "effects"),
        (Splats::IS_BUILT || scene.splat_count() == 0, "splats", "effects"),
        (Environments::IS_BUILT || !has_picture(), "an environment of a picture", "light"),
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

/// Context of shading: the picture as a whole.
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
        rays: view.rays(),
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
