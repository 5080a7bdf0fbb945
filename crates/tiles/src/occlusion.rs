//! Occluders of a scene, whatever the camera: depth maps from the directions of its environment, and the triangles that
//! rays are traced through. Kept for as long as neither changes: the frames of a turntable share them.

use super::options::RenderOptions;
use super::quality::{Quality, Visibility};
use super::timed_pool::TimedPool;
use overcoat_core::built::Shadows;
use overcoat_core::limits::{LimitExceeded, Limits};
use overcoat_scene::{Mesh, Revision, Scene, Transform};
use overcoat_stages::bvh::Hierarchy;
use overcoat_stages::light::EnvironmentLight;
use overcoat_stages::shade::{DistantLight, Emitters, LightOcclusion, LobeSamples, TracedLight};
use overcoat_stages::shadow::{self, Blockers, DepthMaps, TintMaps, Tinted};

/// Lengths below this part of a scene's size mean nothing: rays start so far off their surface.
const EPSILON: f32 = 3e-6;

/// Bytes that a triangle takes for rays: its corners, and its share of the hierarchy while that is built.
const BYTES_PER_TRIANGLE: u64 = 200;

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

/// Triangles that rays are traced through.
#[derive(Debug, Default)]
struct TracedScene {
    /// Corners of all triangles, in world space.
    corners: Vec<[[f32; 3]; 3]>,
    /// Draws with triangles among them, and the first triangle of each.
    draws: Vec<(u32, u32)>,
    hierarchy: Hierarchy,
    /// Distance by which rays start off their surface.
    epsilon: f32,
}

impl OcclusionMemory {
    /// Finds what blocks the light of an environment in a scene, unless it is known.
    pub fn prepare(
        &mut self,
        pool: &TimedPool<'_>,
        scene: &Scene,
        environment: &EnvironmentLight<'_>,
        options: &RenderOptions,
    ) -> Result<(), LimitExceeded> {
        let asked = &asked_for(options);
        self.is_on = options.visibility.is_on();
        if !Shadows::IS_BUILT || !asked.is_on() {
            return Ok(());
        }
        let limits = &options.limits;
        self.list_blockers(pool, scene, limits)?;
        let lights = distant_lights(environment, asked.maps);
        if self.lights != lights || self.size != asked.map_size {
            self.draw_maps(pool, lights, asked.map_size, options)?;
        }
        if self.samples.len() != asked.rays as usize {
            self.samples = LobeSamples::new(asked.rays);
        }
        // The same triangles may be those of other draws.
        if asked.rays > 0 && self.traced.draws != numbered(scene) {
            self.traced = TracedScene::default();
            self.traced.build(pool, scene, limits)?;
        }
        if asked.rays > 0 {
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
        if blockers != self.blockers {
            self.moved += 1;
            (self.blockers, self.traced, self.size) = (blockers, TracedScene::default(), 0);
        }
        if tinted != self.tinted {
            self.moved += 1;
            (self.tinted, self.size) = (tinted, 0);
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
        self.size = 0;
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

    /// Occluders and tinted surfaces, if they were asked for, and their number among all that there were.
    pub fn occluders(&self, options: &RenderOptions) -> Option<(&Blockers, &Tinted, u64)> {
        asked_for(options).is_on().then_some((&self.blockers, &self.tinted, self.moved))
    }

    /// Scene that rays are traced in; `None` without rays.
    pub fn traced(&self) -> Option<TracedLight<'_>> {
        let occlusion = self.maps()?;
        let TracedScene { corners, draws, hierarchy, epsilon } = &self.traced;
        (!self.samples.is_empty() && !hierarchy.is_empty()).then_some(TracedLight {
            hierarchy,
            corners,
            draws,
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
        _ => Quality::Fast.visibility().with_rays(0),
    }
}

/// The directions that an environment's light comes from.
fn distant_lights(environment: &EnvironmentLight<'_>, count: u32) -> Vec<DistantLight> {
    let found = environment.light_directions(count as usize);
    let parts = found.directions.iter().zip(&found.fluxes).zip(&found.solid_angles);
    parts
        .map(|((direction, flux), solid_angle)| DistantLight {
            direction: *direction,
            flux: *flux,
            solid_angle: *solid_angle,
        })
        .collect()
}

/// The draws whose triangles rays can hit: number, mesh, place.
fn blocking(scene: &Scene) -> impl Iterator<Item = (u32, &Mesh, &Transform)> {
    shadow::blocking_draws(scene)
        .map(|(draw, instance, _)| (draw, &scene.meshes()[instance.mesh.index()], &instance.transform))
}

/// Their numbers, and the first triangle of each.
fn numbered(scene: &Scene) -> Vec<(u32, u32)> {
    let mut first = 0;
    let next = |(draw, mesh, _): (u32, &Mesh, &Transform)| {
        let own = first;
        first += mesh.triangles().len() as u32;
        (draw, own)
    };
    blocking(scene).map(next).collect()
}

impl TracedScene {
    /// Lists the triangles of opaque and alpha-masked surfaces, and builds their hierarchy.
    fn build(&mut self, pool: &TimedPool<'_>, scene: &Scene, limits: &Limits) -> Result<(), LimitExceeded> {
        let what = || "triangles that rays can hit".to_owned();
        let count: u64 = blocking(scene).map(|(_, mesh, _)| mesh.triangles().len() as u64).sum();
        Limits::check(what, count.saturating_mul(BYTES_PER_TRIANGLE), limits.frame_bytes, "frame_bytes")?;
        Limits::check(what, count, Hierarchy::MAX_TRIANGLES as u64, "triangles")?;
        self.corners.reserve_exact(count as usize);
        let mut largest = 0.0_f32;
        let mut positions: Vec<[f32; 3]> = Vec::new();
        self.draws = numbered(scene);
        for (_, mesh, transform) in blocking(scene) {
            positions.clear();
            positions
                .extend(mesh.positions().iter().map(|p| transform.point(p.map(f64::from)).map(|c| c as f32)));
            let corners = mesh.triangles().iter().map(|triangle| triangle.map(|v| positions[v as usize]));
            self.corners.extend(corners);
        }
        for c in self.corners.as_flattened().as_flattened() {
            largest = if c.abs() > largest { c.abs() } else { largest };
        }
        self.epsilon = largest * EPSILON;
        self.hierarchy = Hierarchy::new(&self.corners, pool.jobs);
        Ok(())
    }

    /// Lists the triangles that shine, by materials as they are now.
    fn list_emitters(&self, scene: &Scene, emitters: &mut Emitters) {
        emitters.clear(scene.materials().len());
        let shining = || {
            let ends = self.draws.iter().skip(1).map(|(_, first)| *first).chain([self.corners.len() as u32]);
            let ranges = self.draws.iter().zip(ends).map(|((_, first), end)| *first as usize..end as usize);
            let draws = shadow::blocking_draws(scene).zip(ranges);
            draws.filter_map(|((_, instance, _), range)| {
                let number = instance.material.index();
                let material = &scene.materials()[number];
                Emitters::shines(material).then(|| (instance, number, material, &self.corners[range]))
            })
        };
        for (_, number, _, triangles) in shining() {
            triangles.iter().for_each(|triangle| emitters.count(triangle, number));
        }
        let [x, y, z] = scene.bounds().size();
        emitters.choose((2.0 * (x * y + y * z + z * x)) as f32);
        for (instance, number, material, triangles) in shining() {
            let mirrored = instance.transform.determinant() < 0.0;
            for &[a, b, c] in triangles {
                let corners = if mirrored { [a, c, b] } else { [a, b, c] };
                if !emitters.add(&corners, number, material) {
                    return;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use overcoat_core::jobs::Jobs;
    use overcoat_scene::primitives;

    /// The limit counts enough for the corners, the boxes that they are sorted by, and the hierarchy, whatever the
    /// triangles are like.
    #[test]
    fn triangles_take_no_more_than_is_counted() {
        let mut state = 1_u32;
        let mut number = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32 / (1 << 24) as f32
        };
        let mut soup = |size: f32| -> Vec<[[f32; 3]; 3]> {
            let corner = |centre: [f32; 3], by: [f32; 3]| std::array::from_fn(|k| centre[k] + size * by[k]);
            let mut point = || std::array::from_fn(|_| number());
            let mut triangle = || {
                let centre = point();
                [(); 3].map(|()| corner(centre, point()))
            };
            (0..20_000).map(|_| triangle()).collect()
        };
        let sphere = primitives::sphere(1.0, 128).unwrap();
        let corners = |t: &[u32; 3]| t.map(|v| sphere.positions()[v as usize]);
        let shapes = [
            ("sphere", sphere.triangles().iter().map(corners).collect()),
            ("small", soup(0.001)),
            ("large", soup(1.0)),
            ("alike", vec![[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]; 20_000]),
        ];
        let jobs = Jobs::new(2);
        for (name, triangles) in shapes {
            let count = triangles.len() as u64;
            let bytes = Hierarchy::new(&triangles, &jobs).bytes() as u64;
            let own = size_of_val(&triangles[0]) as u64;
            let sorted = 28;
            let all = bytes / count + own + sorted;
            assert!(all <= BYTES_PER_TRIANGLE, "{name}: {all} bytes for each of {count} triangles");
            assert!(all > BYTES_PER_TRIANGLE / 4, "{name}: {all} bytes for each of {count} triangles");
        }
    }
}
