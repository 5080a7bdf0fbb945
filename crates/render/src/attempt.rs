//! One attempt at a picture: its stages in their order.
//!
//! It ends without a picture where tiles have read what was not there: a texture that cannot be decoded, a level of the environment
//! that is not filtered. Then the next attempt knows of it.

use super::environment::foreseen;
use super::passes::{PassMemory, check_limits, work_of};
use super::pick::LastPicture;
use super::picture::{Drawn, Memory, Request, environment_light};
use super::rendered::{RenderStats, StageTimes};
use super::textures::TextureMemory;
use super::tiles::Found;
use overcoat_core::frame::Target;
use overcoat_core::limits::LimitExceeded;
use overcoat_scene::{EnvironmentSource, Scene};
use overcoat_stages::gbuffer::Draw;
use overcoat_stages::geometry::View;
use overcoat_stages::light::{Levels, PrefilteredEnvironment};
use overcoat_stages::raster::SamplePattern;
use overcoat_tiles::budget::FrameBudget;
use overcoat_tiles::edges::left_out;
use overcoat_tiles::occlusion::LightLimit;
use overcoat_tiles::options::RenderError;
use overcoat_tiles::pass::FrameContext;
use overcoat_tiles::strips::Planes;
use overcoat_tiles::timed_pool::TimedPool;
use overcoat_tiles::trace::{self, StageHashes};
use overcoat_tiles::work::{SHADING, Spent, Work};

/// Units of shading (about a nanosecond) for sixteen triangles or texels of a depth map, if it is as large as that of the best tier.
const UNITS_OF_MAPS: u64 = 100;

/// State that the stages of an attempt share.
pub(super) struct Attempt<'a> {
    pub request: &'a Request<'a>,
    pub pattern: &'a SamplePattern,
    pub view: &'a View,
    /// Pixels that a target holds, if not all are drawn: left, top, width and height.
    pub region: Option<[u32; 4]>,
    /// Memory that is left to the frame.
    pub budget: FrameBudget,
    pub pool: TimedPool<'a>,
    pub times: StageTimes,
    /// Cost of the picture that the floor mirrors, if it mirrors any.
    pub mirrored: Option<&'a RenderStats>,
}

/// End of an attempt without a picture.
pub(super) enum Stop {
    /// There will be none.
    Error(RenderError),
    /// Some textures cannot be decoded: the scene without them, which is to be drawn.
    LostTextures(Box<Scene>),
    /// The scene is one of enclosed spaces, for which rays are asked for.
    Indoors,
    /// Levels of the environment were read that nobody foresaw: they are known now.
    MoreLight,
    /// Finding blocked light passes a limit: less of it may not.
    Light(Less, LimitExceeded),
    /// A limit was passed with tiles of a size that was asked for: those of the default say which limit.
    DefaultTiles,
}

/// Blocked light that is to be left out.
#[derive(Clone, Copy, Debug)]
pub(super) enum Less {
    /// Depth maps: fewer or smaller ones.
    Maps,
    /// Rays: so many are left.
    Rays(u32),
    /// Anything.
    Any,
}

impl From<LightLimit> for Stop {
    fn from(limit: LightLimit) -> Self {
        match limit {
            LightLimit::Maps(limit) => Self::Light(Less::Maps, limit),
            LightLimit::Rays(limit) => Self::Light(Less::Rays(0), limit),
        }
    }
}

impl From<RenderError> for Stop {
    fn from(error: RenderError) -> Self {
        Self::Error(error)
    }
}

impl From<LimitExceeded> for Stop {
    fn from(error: LimitExceeded) -> Self {
        Self::Error(error.into())
    }
}

/// Outcome of the passes over all tiles.
struct DrawnTiles<'a> {
    planes: Planes,
    found: Found,
    work: Work<'a>,
}

impl<'a> Attempt<'a> {
    /// Carries out the stages. `draws` is empty before.
    pub(super) fn run(
        &mut self,
        memory: &mut Memory,
        draws: &mut Vec<Draw<'a>>,
        target: Option<(&mut Target<'_>, [u32; 4])>,
    ) -> Result<Drawn, Stop> {
        let &Request { jobs, scene, options, .. } = self.request;
        let Memory { environments, prepared, textures, passes, work_done, last, .. } = memory;

        // Decode the textures that decide about what is seen, if they are decoded by need.
        let needs_feedback = textures.begin(self.request);
        check_lost(scene)?;
        self.times.textures = self.pool.lap();

        // Filter the environment, and find where the lights shine and what is in their way. Planes alone do not ask for light.
        let filtered = if self.request.only_planes {
            environments.get(&EnvironmentSource::None, Levels::NONE, jobs, options.simd)
        } else {
            let levels = foreseen(scene, options);
            environments.get(&scene.environment().source, levels, jobs, options.simd)
        };
        let environment = environment_light(scene, &filtered);
        prepared.prepare_lights(self, &mut passes.effects, &environment)?;
        if !self.request.only_planes && passes.effects.calls_for_rays(scene, options) {
            return Err(Stop::Indoors);
        }
        self.times.environment = self.pool.lap();
        self.request.go_on()?;

        // Bring the vertices to the screen.
        prepared.geometry.place_vertices(&mut self.pool, scene, self.view, options, draws);
        self.times.vertices = self.pool.lap();
        self.request.go_on()?;

        // Set up triangles and splats, and list them for the tiles.
        let listed = prepared.list_primitives(self, draws)?;
        self.times.triangles = self.pool.lap();
        self.request.go_on()?;
        let hashes =
            options.stage_hashes.then(|| prepared.hashes(self, &listed, draws, &filtered, &passes.effects));

        // Draw the tiles.
        let emitter_rays = passes.effects.emitter_rays();
        let maps = passes.effects.occlusion().work().saturating_add(prepared.lights.work());
        let frame = prepared.frame(self, &listed, draws, &environment, emitter_rays);
        if needs_feedback {
            self.decode_by_feedback(&frame, passes, textures)?;
        }
        self.fit_rays(&frame, passes, maps)?;
        let tiles = self.draw_tiles(&frame, &filtered, passes, textures, target)?;
        *work_done = tiles.work.done();

        // Make the picture of their pixels.
        let frame = frame.with_textures(textures.of(scene));
        self.check_tiles(&frame, &tiles.work)?;
        let mut drawn = self.develop(&frame, tiles, hashes);
        drawn.stats.lights_without_shadow = prepared.lights.without_shadow();
        *last = Some(LastPicture::new(self.request, listed.grid, listed.chunks));
        Ok(drawn)
    }

    /// `Ok` if the rays of the frame are within the limit of shading with all other work, as those of a few pixels tell: else
    /// the picture is drawn with fewer, and none are sent in vain.
    fn fit_rays(&mut self, frame: &FrameContext<'_>, passes: &mut PassMemory, maps: u64) -> Result<(), Stop> {
        let Request { options, rays_fit, .. } = self.request;
        let rays = options.visibility.rays;
        if *rays_fit || passes.effects.occlusion().traced().is_none() {
            return Ok(());
        }
        let work = work_of(frame, self.request);
        let counted = work.times(1);
        passes.count(&mut self.pool, frame, &counted, self.request);
        let sent = work.times(rays);
        if !counted.is_stopped() {
            passes.probe(&mut self.pool, frame, &sent, self.request);
        }
        self.request.go_on()?;
        // Passing a limit without rays ends the picture, which the tiles find out in their way.
        let base = counted.sum(Spent::Shading).saturating_add(maps.saturating_mul(UNITS_OF_MAPS));
        match work.fewer_rays(base, &sent, rays) {
            Some(fewer) if !counted.is_stopped() => {
                let limit = LimitExceeded::beyond(SHADING, options.limits.shading, "shading");
                Err(Stop::Light(Less::Rays(fewer), limit))
            }
            _ => Ok(()),
        }
    }

    /// Decodes the textures that the frame reads, as far as that can be foreseen.
    fn decode_by_feedback(
        &mut self,
        frame: &FrameContext<'_>,
        passes: &mut PassMemory,
        textures: &mut TextureMemory,
    ) -> Result<(), Stop> {
        let scene = self.request.scene;
        passes.draw_feedback(&mut self.pool, &frame.with_textures(textures.of(scene)), self.request);
        textures.fed_back = Some(scene.revision());
        self.times.tiles += self.pool.lap();
        self.fetch(textures)
    }

    /// Decodes the textures that were asked for.
    fn fetch(&mut self, textures: &mut TextureMemory) -> Result<(), Stop> {
        textures.fetch(self.request.jobs, self.request.scene);
        self.times.textures += self.pool.lap();
        check_lost(self.request.scene)
    }

    /// Draws the tiles; again if they read what is not there.
    fn draw_tiles(
        &mut self,
        frame: &FrameContext<'_>,
        filtered: &PrefilteredEnvironment,
        passes: &mut PassMemory,
        textures: &mut TextureMemory,
        mut target: Option<(&mut Target<'_>, [u32; 4])>,
    ) -> Result<DrawnTiles<'a>, Stop> {
        let request = self.request;
        loop {
            let frame = frame.with_textures(textures.of(request.scene));
            let work = work_of(&frame, request);
            let target = target.as_mut().map(|(target, region)| (&mut **target, *region));
            let (planes, found) = passes.draw(&mut self.pool, &frame, &work, request, target);
            let is_dark = filtered.misses_any_of(filtered.lacking());
            if !(textures.lacks() || is_dark) || work.is_stopped() {
                return Ok(DrawnTiles { planes, found, work });
            }
            self.times.tiles += self.pool.lap();
            passes.planes = planes;
            if is_dark {
                return Err(Stop::MoreLight);
            }
            self.fetch(textures)?;
        }
    }

    /// `Ok` if the tiles were drawn to the end, within the limits, by threads that round as they should.
    fn check_tiles(&self, frame: &FrameContext<'_>, work: &Work<'_>) -> Result<(), Stop> {
        self.request.go_on()?;
        if work.is_stopped() {
            // Which limit is named must not depend on the tiles, nor on the threads: the first that one would pass is.
            if frame.grid.side() != self.budget.grid().side() {
                return Err(Stop::DefaultTiles);
            }
            match check_limits(frame, self.request) {
                Err(limit) if limit.field == "shading" => return Err(Stop::Light(Less::Any, limit)),
                checked => checked?,
            }
        }
        if !self.pool.arithmetic_is_default() {
            return Err(RenderError::FloatingPointMode.into());
        }
        Ok(())
    }

    /// Makes the picture of what the tiles have drawn, with counts and times.
    fn develop(
        &mut self,
        frame: &FrameContext<'_>,
        tiles: DrawnTiles<'_>,
        hashes: Option<StageHashes>,
    ) -> Drawn {
        let DrawnTiles { planes, found, work } = tiles;
        let mut drawn = Drawn::new(planes, found.clipping, self.request);
        self.times.tiles += self.pool.lap();
        drawn.stats = self.stats(frame, &found, &work);
        drawn.stats.stage_hashes =
            hashes.zip(found.hashes).map(|(hashes, found)| trace::after_tiles(hashes, &found, &drawn.frame));
        (drawn.frame.aovs, drawn.tinted) = (found.aovs, found.tinted);
        drawn
    }

    /// Counts and times of the picture.
    fn stats(&self, frame: &FrameContext<'_>, found: &Found, work: &Work<'_>) -> RenderStats {
        let scene = self.request.scene;
        let chunks = frame.chunks.iter();
        let mut stats = RenderStats {
            triangles: scene.triangle_count(),
            triangles_rasterized: chunks.map(|c| c.triangles.len() as u64 + u64::from(c.kept)).sum(),
            splats: scene.splat_count(),
            splats_drawn: frame.splats.count() as u64,
            fragments: found.fragments,
            shading: work.sum(Spent::Shading),
            covered: found.covered,
            stages: self.times.named(),
            serial: self.times.sum().saturating_sub(self.pool.parallel()),
            visibility: self.request.options.visibility,
            reduced_light: None,
            lights_without_shadow: 0,
            edges_left_out: left_out(scene, self.request.options),
            stage_hashes: None,
        };
        if let Some(mirrored) = self.mirrored {
            stats.add_cost(mirrored);
        }
        stats
    }
}

/// `Ok` if all textures of a scene can be decoded, as far as that was tried.
fn check_lost(scene: &Scene) -> Result<(), Stop> {
    match scene.without_lost_textures() {
        Some(rest) => Err(Stop::LostTextures(Box::new(rest))),
        None => Ok(()),
    }
}
