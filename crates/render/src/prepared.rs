//! The frame that tiles are drawn of: lights, triangles, splats and costs, prepared stage by stage in memory that is kept.

use super::attempt::Attempt;
use super::picture::{Request, shade_context, tile_grid};
use super::setup::{GeometryMemory, SetUp};
use overcoat_core::limits::LimitExceeded;
use overcoat_stages::gbuffer::Draw;
use overcoat_stages::light::{EnvironmentLight, PrefilteredEnvironment};
use overcoat_stages::shade::ShadingCost;
use overcoat_stages::tile::{TileBins, TileGrid};
use overcoat_tiles::effects::EffectMemory;
use overcoat_tiles::ground_light::GroundLight;
use overcoat_tiles::ground_pixels::GroundView;
use overcoat_tiles::lamps::LightMemory;
use overcoat_tiles::light_filter::MARGIN;
use overcoat_tiles::mirror::MirrorMemory;
use overcoat_tiles::occlusion::LightLimit;
use overcoat_tiles::options::{Background, RenderOptions};
use overcoat_tiles::pass::FrameContext;
use overcoat_tiles::shading_rate::Finer;
use overcoat_tiles::splats::SplatMemory;
use overcoat_tiles::trace::{self, StageHashes};

/// Memory of what all tiles of a frame read, kept from one picture to the next.
#[derive(Debug, Default)]
pub(super) struct FrameMemory {
    pub lights: LightMemory,
    pub geometry: GeometryMemory,
    pub bins: TileBins,
    splats: SplatMemory,
    pub ground: GroundLight,
    pub mirror: MirrorMemory,
    costs: Vec<ShadingCost>,
    finer: Vec<Finer>,
}

/// The tiles of a frame and the triangles that are listed for them.
#[derive(Clone, Copy)]
pub(super) struct Listed {
    pub grid: TileGrid,
    /// Columns and rows of the tiles that are drawn, and the ends.
    pub drawn: [u32; 4],
    /// Number of chunks of triangles.
    pub chunks: usize,
}

impl FrameMemory {
    /// Finds where the lights shine and what is in their way.
    pub(super) fn prepare_lights(
        &mut self,
        attempt: &Attempt<'_>,
        effects: &mut EffectMemory,
        environment: &EnvironmentLight<'_>,
    ) -> Result<(), LightLimit> {
        let &Attempt { request: &Request { scene, options, .. }, view, ref pool, .. } = attempt;
        self.lights.list(scene, view);
        effects.before(pool, scene, environment, options)?;
        self.lights.find_shadows(pool, scene, effects.occlusion(), options).map_err(LightLimit::Maps)?;
        let maps = effects.maps_of_ground().filter(|_| options.ground.is_seen());
        self.ground.prepare(pool, (scene, view), maps, (environment, &self.lights), options);
        Ok(())
    }

    /// Sets up triangles and splats, whose vertices are on the screen, and lists them for the tiles.
    pub(super) fn list_primitives(
        &mut self,
        attempt: &mut Attempt<'_>,
        draws: &[Draw<'_>],
    ) -> Result<Listed, LimitExceeded> {
        let (grid, drawn) = self.listed_grid(attempt);
        let Attempt {
            request: &Request { scene, options, .. }, pattern, view, ref budget, ref mut pool, ..
        } = *attempt;
        let to = SetUp { grid: &grid, pattern, budget };
        let chunks = self.geometry.set_up_triangles(pool, draws, &to, options);
        if pool.jobs.is_cancelled() {
            // Chunks may be those of another picture.
            return Ok(Listed { grid, drawn, chunks: 0 });
        }
        self.splats.prepare(pool, scene, view, &grid, budget);
        budget.check()?;
        self.bins.build(grid.len(), self.geometry.chunks[..chunks].iter().map(|chunk| &chunk.bins));
        Ok(Listed { grid, drawn, chunks })
    }

    /// The tiles for which triangles are listed, and columns and rows of those that are drawn: all, or where a region is.
    fn listed_grid(&self, attempt: &mut Attempt<'_>) -> (TileGrid, [u32; 4]) {
        let options = attempt.request.options;
        let grid = tile_grid(options, options.tile_size);
        let Some(region) = attempt.region else { return (grid, [0, 0, grid.columns(), grid.rows()]) };
        let drawn = grid.tiles_of_pixels(region);
        // Refracting surfaces may show any other part of the picture.
        if self.geometry.states.iter().any(|state| state.refracts) {
            return (grid, drawn);
        }
        let region = with_margin(region, options);
        attempt.budget.list_within(region);
        (grid.listed_within(region), drawn)
    }

    /// The frame of all that was prepared, with what fragments of each material cost.
    pub(super) fn frame<'f>(
        &'f mut self,
        attempt: &Attempt<'f>,
        &Listed { grid, drawn, chunks }: &Listed,
        draws: &'f [Draw<'f>],
        environment: &'f EnvironmentLight<'f>,
        emitter_rays: u32,
    ) -> FrameContext<'f> {
        let &Attempt { request, view, pattern, mirrored, .. } = attempt;
        let &Request { scene, options, .. } = request;
        let Self { lights, geometry, bins, splats, ground, mirror, costs, finer } = self;
        let textures = scene.textures();
        let shade = shade_context(request, textures, view, draws, environment, lights, emitter_rays);
        costs.clear();
        costs.extend(scene.materials().iter().map(|material| ShadingCost::of(material, &shade)));
        Finer::list(scene.materials(), textures, options, finer);
        let show_environment = options.background == Background::Environment;
        let mirror = mirrored.map(|_| mirror.of(options.ground_reflection));
        FrameContext {
            grid,
            pattern,
            least_depth: view.least_depth(),
            chunks: &geometry.chunks[..chunks],
            bins,
            states: &geometry.states,
            splats: splats.of(scene, view),
            shade,
            costs,
            reach: &lights.reach,
            show_environment,
            ground: GroundView::new(ground, lights, options, view, mirror),
            relief: request.relief,
            tints: !show_environment && geometry.states.iter().any(|state| state.transmissive),
            merge: merge_cosine(options.merge_angle),
            finer,
            drawn,
        }
    }

    /// Hashes of all stages before the tiles.
    pub(super) fn hashes(
        &self,
        attempt: &Attempt<'_>,
        listed: &Listed,
        draws: &[Draw<'_>],
        filtered: &PrefilteredEnvironment,
        effects: &EffectMemory,
    ) -> StageHashes {
        let Request { scene, options, .. } = attempt.request;
        let GeometryMemory { states, vertices, chunks, .. } = &self.geometry;
        let splats = self.splats.of(scene, attempt.view);
        let geometry = trace::geometry(vertices, &chunks[..listed.chunks], states, draws, splats.in_order());
        let mut hashes = trace::before_tiles(scene, filtered, geometry);
        let has_ground = options.ground.is_seen();
        (hashes.depth_maps, hashes.hierarchy) = effects.hashes(has_ground);
        let lights = &self.lights;
        let lamps = if has_ground { lights.shadows_of_ground() } else { lights.shadows() };
        hashes.lamp_maps = lamps.map_or(0, |lamps| trace::lamp_maps(&lamps));
        let light = has_ground.then(|| self.ground.texels());
        hashes.ground = light.filter(|texels| !texels.is_empty()).map_or(0, trace::ground);
        if attempt.mirrored.is_some() {
            hashes.ground = self.mirror.of(1.0).hashed_with(hashes.ground);
        }
        hashes
    }
}

/// The square of the cosine of an angle in degrees; `None` for 0.
fn merge_cosine(degrees: f32) -> Option<f32> {
    let (_, cosine) =
        overcoat_core::math::double::sin_cos(f64::from(degrees) * (std::f64::consts::PI / 180.0));
    (degrees > 0.0).then_some((cosine * cosine) as f32)
}

/// The region with the pixels around it whose rays show in it, within the picture.
fn with_margin([left, top, right, bottom]: [u32; 4], options: &RenderOptions) -> [u32; 4] {
    let margin = if options.visibility.rays > 0 { MARGIN as u32 } else { 0 };
    let [right, bottom] = [(right, options.width), (bottom, options.height)]
        .map(|(end, side)| end.saturating_add(margin).min(side));
    [left.saturating_sub(margin), top.saturating_sub(margin), right, bottom]
}
