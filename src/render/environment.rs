//! Filtered environments, kept from one picture to the next.
//!
//! Of a picture only those levels are filtered that the scene's materials are expected to look up ([`foreseen`]). What is looked
//! up beyond that is remembered, filtered, and the picture drawn again: no picture shows what was foreseen.

use super::options::RenderOptions;
use crate::jobs::Jobs;
use crate::light::{LIGHT_DIRECTIONS, Levels, PrefilteredEnvironment, SHEEN};
use crate::math::lanes::SimdLevel;
use crate::scene::{EnvironmentSource, EquirectImage, Material, Scene, Workflow};
use std::sync::Arc;

/// The environment that was used last.
#[derive(Debug, Default)]
pub(super) struct EnvironmentCache {
    picture: Option<(Arc<EquirectImage>, Arc<PrefilteredEnvironment>)>,
    dark: Option<Arc<PrefilteredEnvironment>>,
    /// Used whatever the scene says.
    pub(super) given: Option<Arc<PrefilteredEnvironment>>,
}

impl EnvironmentCache {
    /// True if [`EnvironmentCache::get`] would filter a picture.
    pub(super) fn would_filter(&self, source: &EnvironmentSource, levels: Levels) -> bool {
        let EnvironmentSource::Image(picture) = source else { return false };
        self.given.is_none()
            && !self.picture.as_ref().is_some_and(|(key, filtered)| {
                Arc::ptr_eq(key, picture) && !filtered.misses_any_of(levels.with(filtered.lacking()))
            })
    }

    /// The filtered form of a source, with these levels at least and those that were lacking the last time; a picture is
    /// filtered once for as long as the scenes share it.
    pub(super) fn get(
        &mut self,
        source: &EnvironmentSource,
        levels: Levels,
        jobs: &Jobs,
        level: SimdLevel,
    ) -> Arc<PrefilteredEnvironment> {
        if let Some(given) = &self.given {
            return Arc::clone(given);
        }
        match source {
            EnvironmentSource::Studio => PrefilteredEnvironment::studio(),
            EnvironmentSource::None => {
                Arc::clone(self.dark.get_or_insert_with(|| Arc::new(PrefilteredEnvironment::black())))
            }
            EnvironmentSource::Image(picture) => {
                let kept = self.picture.take().filter(|(key, _)| Arc::ptr_eq(key, picture));
                let mut filtered = match kept {
                    Some((_, filtered)) => filtered,
                    None => Arc::new(PrefilteredEnvironment::by_need(picture, jobs, level)),
                };
                let levels = levels.with(filtered.lacking());
                if filtered.misses_any_of(levels) {
                    Arc::make_mut(&mut filtered).filter(levels, jobs, level);
                }
                self.picture = Some((Arc::clone(picture), Arc::clone(&filtered)));
                filtered
            }
        }
    }
}

/// Pixels of a picture up to which it pays to draw it once more rather than to filter what no lookup may need: all levels of a
/// picture of 1024 x 512 pixels take about as long as a quarter of a million pixels.
const FEW: u64 = 1 << 18;

/// The levels that a picture is expected to look up: those between the smoothest and the roughest lobes that its materials have
/// by their factors.
pub(super) fn foreseen(scene: &Scene, options: &RenderOptions) -> Levels {
    let pixels = u64::from(options.width) * u64::from(options.height);
    // Rays see other surfaces by roughnesses of their own.
    if options.visibility.rays > 0 || options.stage_hashes || pixels > FEW {
        return Levels::ALL;
    }
    let blocked = options.visibility.maps > 0 || options.ground.is_seen();
    let begin = if blocked { LIGHT_DIRECTIONS } else { Levels::NONE };
    let filters_normals = options.specular_antialiasing;
    scene.materials().iter().map(|material| of_material(material, filters_normals)).fold(begin, Levels::with)
}

/// Those of one material, of any model.
fn of_material(material: &Material, filters_normals: bool) -> Levels {
    if material.unlit {
        return Levels::NONE;
    }
    // A texture scales the factor, to anything below it.
    let range = |factor: f32, textured: bool| {
        let most = if filters_normals { 1.0 } else { factor };
        (if textured { 0.0 } else { factor }, most)
    };
    let base = match &material.workflow {
        Workflow::MetallicRoughness { roughness, texture, .. } => range(*roughness, texture.is_some()),
        Workflow::SpecularGlossiness { glossiness, texture, .. } => match texture {
            Some(_) => (1.0 - glossiness, 1.0),
            None => range(1.0 - glossiness, false),
        },
    };
    let mut levels = Levels::for_roughness(base.0, base.1);
    if material.coat > 0.0 {
        let coat = range(material.coat_roughness, material.coat_roughness_texture.is_some());
        levels = levels.with(Levels::for_roughness(coat.0, coat.1));
        // Seen through a rough coat, the base looks rougher (OpenPBR: the fourth powers add up).
        let fourth = |x: f32| (x * x) * (x * x);
        let through = (fourth(base.1) + 2.0 * fourth(coat.1)).sqrt().sqrt();
        levels = levels.with(Levels::for_roughness(base.0, if through < 1.0 { through } else { 1.0 }));
    }
    let lobes = &material.lobes;
    if lobes.sheen.color.factor != [0.0; 3] {
        let sheen = range(lobes.sheen.roughness.factor, lobes.sheen.roughness.texture.is_some());
        levels = levels.with(SHEEN).with(Levels::for_roughness(sheen.0, sheen.1));
    }
    if lobes.second.mix.factor > 0.0 {
        let second = range(lobes.second.roughness.factor, lobes.second.roughness.texture.is_some());
        levels = levels.with(Levels::for_roughness(second.0, second.1));
    }
    levels
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::Quality;
    use crate::scene::{EquirectImage, Instance, Transform, primitives};

    #[test]
    fn of_a_rough_surface_few_levels_are_filtered() {
        let pixels = (0..64 * 32).map(|k| [(k % 7) as f32, 1.0, (k % 5) as f32]).collect();
        let picture = Arc::new(EquirectImage::new(64, 32, pixels).unwrap());
        let source = EnvironmentSource::Image(picture);
        let jobs = Jobs::new(1);
        let (mut scene, mut options) = (Scene::new(), RenderOptions::default().with_quality(Quality::Fast));
        (options.width, options.height) = (64, 64);
        let material = scene.add_material(Material::default()).unwrap();
        let mesh = scene.add_mesh(primitives::sphere(1.0, 16).unwrap()).unwrap();
        scene.add_instance(Instance { mesh, material, transform: Transform::IDENTITY, object: 0 }).unwrap();
        let levels = foreseen(&scene, &options);
        assert_eq!(levels, LIGHT_DIRECTIONS.with(Levels::for_roughness(1.0, 1.0)));
        let mut cache = EnvironmentCache::default();
        assert!(cache.would_filter(&source, levels));
        let first = cache.get(&source, levels, &jobs, SimdLevel::best());
        assert!(!first.misses_any_of(levels) && first.misses_any_of(Levels::for_roughness(0.5, 0.5)));
        assert!(!cache.would_filter(&source, levels));
        // The same as long as nothing is lacking; then the same texels and more.
        assert!(Arc::ptr_eq(&first, &cache.get(&source, levels, &jobs, SimdLevel::best())));
        options.stage_hashes = true;
        assert_eq!(foreseen(&scene, &options), Levels::ALL);
        assert!(cache.would_filter(&source, Levels::ALL));
        let all = cache.get(&source, Levels::ALL, &jobs, SimdLevel::best());
        assert!(!all.misses_any_of(Levels::ALL) && !cache.would_filter(&source, Levels::ALL));
    }
}
