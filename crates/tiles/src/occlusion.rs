//! Occluders of a scene, whatever the camera: depth maps from the directions of its environment, and the triangles that
//! rays are traced through. Kept for as long as neither changes: the frames of a turntable share them.

use super::options::RenderOptions;
use super::quality::{Quality, Visibility};
use super::timed_pool::TimedPool;
use super::traced_scene::TracedScene;
use overcoat_core::built::Shadows;
use overcoat_core::limits::{LimitExceeded, Limits};
use overcoat_scene::{Revision, Scene};
use overcoat_stages::light::{EnvironmentLight, LightDirections};
use overcoat_stages::shade::{
    ClearSurfaces, DistantLight, Emitters, LightOcclusion, LobeSamples, TracedLight,
};
use overcoat_stages::shadow::{Blockers, DepthMaps, TintMaps, Tinted};

/// Share of what is seen of a scene from some side, from which on it counts as enclosed. The Cornell box has .50, an open tin .33, a
/// bucket .32; of 242 public models the next have .22, a vase and a tent.
const ENCLOSED: f32 = 0.25;

/// Triangles of a scene for which rays are sent indoors, at most: beyond, building their hierarchy would take most of the time.
const MOST_INDOORS: u64 = 1 << 18;

/// Maps that are remembered to pass a limit.
const MOST_REFUSED: usize = 8;

/// Occlusion of the last scene.
#[derive(Debug, Default)]
pub struct OcclusionMemory {
    lights: Vec<DistantLight>,
    blockers: Blockers,
    tinted: Tinted,
    size: u32,
    maps: DepthMaps,
    /// The maps show enclosed spaces, once that was asked.
    is_enclosed: Option<bool>,
    tints: TintMaps,
    traced: TracedScene,
    samples: LobeSamples,
    emitters: Emitters,
    /// Surfaces are shaded with it.
    is_on: bool,
    /// Number of times that maps were made.
    made: u64,
    /// Number of times that the occluders changed.
    moved: u64,
    /// Directions and sizes of maps of these blockers that pass a limit: the next frame need not find out again.
    refused: Vec<(Vec<DistantLight>, u32, LimitExceeded)>,
    /// Scene that these occluders belong to, and the limits that they were listed within: of the same scene they need
    /// not be listed again.
    of_scene: Option<(Revision, Limits)>,
}

/// A limit that finding blocked light would pass.
#[derive(Debug)]
pub enum LightLimit {
    /// By maps, or what they are drawn of.
    Maps(LimitExceeded),
    /// By what rays are traced through.
    Rays(LimitExceeded),
}

impl OcclusionMemory {
    /// Finds what blocks the light of an environment in a scene, unless it is known.
    pub fn prepare(
        &mut self,
        pool: &TimedPool<'_>,
        scene: &Scene,
        environment: &EnvironmentLight<'_>,
        options: &RenderOptions,
    ) -> Result<(), LightLimit> {
        let asked = &asked_for(options);
        self.is_on = options.visibility.is_on();
        if !Shadows::IS_BUILT || !asked.is_on() {
            return Ok(());
        }
        let limits = &options.limits;
        self.list_blockers(pool, scene, limits).map_err(LightLimit::Maps)?;
        if pool.jobs.is_cancelled() {
            return Ok(());
        }
        let found = environment.light_directions(asked.maps as usize);
        // Rays look up from where they come even where nothing shines from afar: surfaces and lamps light each other.
        let is_needed = asked.rays > 0 || found.fluxes.iter().any(|flux| *flux != [0.0; 3]);
        let lights = distant_lights(environment, &found).filter(move |_| is_needed);
        if self.size != asked.map_size || !lights.clone().eq(self.lights.iter().copied()) {
            self.draw_maps(pool, lights.collect(), asked.map_size, options).map_err(LightLimit::Maps)?;
        }
        if self.samples.len() != asked.rays as usize {
            self.samples = LobeSamples::new(asked.rays);
        }
        // The same triangles may be those of other draws.
        if asked.rays > 0 && !self.traced.is_of(scene, limits) && !pool.jobs.is_cancelled() {
            self.traced = TracedScene::default();
            self.traced = TracedScene::of(scene, limits, pool.jobs).map_err(LightLimit::Rays)?;
            if pool.jobs.is_cancelled() {
                // Unfinished.
                self.traced = TracedScene::default();
            }
        }
        if asked.rays > 0 && !pool.jobs.is_cancelled() {
            self.traced.list_emitters(scene, &mut self.emitters);
        }
        Ok(())
    }

    /// Lists what blocks light, unless that is known.
    fn list_blockers(
        &mut self,
        pool: &TimedPool<'_>,
        scene: &Scene,
        limits: &Limits,
    ) -> Result<(), LimitExceeded> {
        let of_scene = (scene.revision(), limits.clone());
        if self.of_scene.as_ref() == Some(&of_scene) {
            return Ok(());
        }
        self.of_scene = None;
        self.refused.clear();
        let blockers = Blockers::of_scene(scene, limits, pool.jobs)?;
        let tinted = Tinted::of_scene(scene, limits)?;
        if pool.jobs.is_cancelled() {
            // Unfinished: what is known stays that of no scene.
            return Ok(());
        }
        if blockers != self.blockers {
            self.moved += 1;
            (self.blockers, self.traced, self.size) = (blockers, TracedScene::default(), 0);
        }
        if tinted != self.tinted {
            self.moved += 1;
            (self.tinted, self.traced, self.size) = (tinted, TracedScene::default(), 0);
        }
        self.of_scene = Some(of_scene);
        Ok(())
    }

    /// Draws the maps of the blockers.
    fn draw_maps(
        &mut self,
        pool: &TimedPool<'_>,
        lights: Vec<DistantLight>,
        size: u32,
        options: &RenderOptions,
    ) -> Result<(), LimitExceeded> {
        let mut refused = self.refused.iter();
        if let Some((_, _, limit)) = refused.find(|(of, side, _)| *side == size && *of == lights) {
            return Err(limit.clone());
        }
        let directions: Vec<_> = lights.iter().map(|light| light.direction).collect();
        (self.size, self.is_enclosed) = (0, None);
        self.made += 1;
        let (limits, jobs, simd, side) = (&options.limits, pool.jobs, options.simd, size as usize);
        let drawn =
            DepthMaps::within(limits, &self.blockers, &directions, side, jobs, simd).and_then(|maps| {
                Ok((maps, TintMaps::within(limits, &self.tinted, &directions, side, jobs, simd)?))
            });
        match drawn {
            Ok((maps, tints)) => {
                (self.maps, self.tints, self.lights, self.size) = (maps, tints, lights, size);
                Ok(())
            }
            // Unfinished, and no limit's fault.
            Err(limit) if jobs.is_cancelled() => Err(limit),
            Err(limit) => {
                // An environment that turns has ever other directions.
                if self.refused.len() == MOST_REFUSED {
                    self.refused.clear();
                }
                self.refused.push((lights, size, limit.clone()));
                Err(limit)
            }
        }
    }

    /// Occlusion by depth maps; `None` if nothing blocks light.
    pub fn maps(&self) -> Option<LightOcclusion<'_>> {
        self.maps_of_ground().map(|(maps, _)| maps).filter(|_| self.is_on)
    }

    /// Occlusion by depth maps, whether surfaces are shaded with it or not, and the number of times that maps were made
    /// until then.
    pub fn maps_of_ground(&self) -> Option<(LightOcclusion<'_>, u64)> {
        let built = Shadows::BUILT?;
        let Self { lights, maps, tints, .. } = self;
        Some((LightOcclusion { lights, maps, tints, built }, self.made))
    }

    /// True if the options ask for rays indoors, and the scene is one of enclosed spaces.
    pub fn calls_for_rays(&mut self, scene: &Scene, options: &RenderOptions) -> bool {
        let Visibility { maps: 1.., rays: 0, indoor_rays: 1.., .. } = options.visibility else {
            return false;
        };
        if scene.triangle_count() > MOST_INDOORS {
            return false;
        }
        let Self { maps, lights, is_enclosed, .. } = self;
        *is_enclosed.get_or_insert_with(|| {
            let solid_angles: Vec<f32> = lights.iter().map(|light| light.solid_angle).collect();
            maps.enclosed_share(&solid_angles) >= ENCLOSED
        })
    }

    /// Occluders and tinted surfaces, if they were asked for, and their number among all that there were.
    pub fn occluders(&self, options: &RenderOptions) -> Option<(&Blockers, &Tinted, u64)> {
        asked_for(options).is_on().then_some((&self.blockers, &self.tinted, self.moved))
    }

    /// Sixteens of triangles and texels that drawing the maps has looked at.
    pub fn work(&self) -> u64 {
        self.maps.work()
    }

    /// Scene that rays are traced in; `None` without rays.
    pub fn traced(&self) -> Option<TracedLight<'_>> {
        let occlusion = self.maps()?;
        let TracedScene { corners, draws, hierarchy, epsilon, clear, clear_corners, clear_draws } =
            &self.traced;
        let clear = ClearSurfaces { hierarchy: clear, corners: clear_corners, draws: clear_draws };
        (!self.samples.is_empty() && !hierarchy.is_empty()).then_some(TracedLight {
            hierarchy,
            corners,
            draws,
            clear,
            samples: &self.samples,
            epsilon: *epsilon,
            emitters: &self.emitters,
            occlusion,
        })
    }
}

/// Visibility that a picture needs: a floor has maps of its own where surfaces have none.
pub fn asked_for(options: &RenderOptions) -> Visibility {
    match options.visibility {
        asked if asked.is_on() || !options.ground.is_seen() => asked,
        _ => Quality::Fast.visibility_of([options.width, options.height]).with_rays(0),
    }
}

/// The directions that an environment's light comes from, of those that were found in its own frame.
fn distant_lights<'a>(
    environment: &'a EnvironmentLight<'_>,
    found: &'a LightDirections,
) -> impl Iterator<Item = DistantLight> + Clone + 'a {
    let parts = found.directions.iter().zip(&found.fluxes).zip(&found.solid_angles);
    parts.map(|((direction, flux), solid_angle)| DistantLight {
        direction: environment.turned(*direction),
        flux: *flux,
        solid_angle: *solid_angle,
    })
}
