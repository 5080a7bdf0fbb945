//! Filtered environments, kept from one picture to the next.
//!
//! Of a picture only those levels are filtered that the scene's materials are expected to look up ([`foreseen`]). What is looked
//! up beyond that is remembered, filtered, and the picture drawn again: no picture shows what was foreseen.

use overcoat_core::built::Environments;
use overcoat_core::jobs::Jobs;
use overcoat_core::math::lanes::SimdLevel;
use overcoat_scene::{EnvironmentSource, EquirectImage, Material, Scene, ShadingModel, Workflow};
use overcoat_shading::coat::standard::roughness_of_lookups;
use overcoat_stages::light::{LIGHT_DIRECTIONS, Levels, PrefilteredEnvironment, SHEEN};
use overcoat_stages::shade::NormalFilter;
use overcoat_tiles::occlusion::asked_for;
use overcoat_tiles::options::{Background, RenderOptions};
use std::sync::Arc;

/// The environment that was used last.
#[derive(Debug, Default)]
pub(super) struct EnvironmentCache {
    picture: Option<(Arc<EquirectImage>, Arc<PrefilteredEnvironment>)>,
    dark: Option<Arc<PrefilteredEnvironment>>,
    /// Store that keeps filtered pictures beyond this renderer.
    pub(super) store: Option<Arc<dyn EnvironmentStore>>,
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

    /// Darkness.
    fn dark(&mut self) -> Arc<PrefilteredEnvironment> {
        Arc::clone(self.dark.get_or_insert_with(|| Arc::new(PrefilteredEnvironment::black())))
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
            EnvironmentSource::Studio => PrefilteredEnvironment::studio_of(levels),
            // Pictures without the part have been refused.
            EnvironmentSource::Image(_) if !Environments::IS_BUILT => self.dark(),
            EnvironmentSource::None => self.dark(),
            EnvironmentSource::Image(picture) => {
                let kept = self.picture.take().filter(|(key, _)| Arc::ptr_eq(key, picture));
                let mut filtered = match (kept, &self.store) {
                    (Some((_, filtered)), _) => filtered,
                    (None, Some(store)) => Arc::new(stored(store.as_ref(), picture, jobs, level)),
                    (None, None) => Arc::new(PrefilteredEnvironment::by_need(picture, jobs, level)),
                };
                let levels = levels.with(filtered.lacking());
                if filtered.misses_any_of(levels) {
                    Arc::make_mut(&mut filtered).filter(levels, jobs, level);
                }
                if jobs.is_cancelled() {
                    // It may be unfinished, and no picture is made with it.
                    return filtered;
                }
                self.picture = Some((Arc::clone(picture), Arc::clone(&filtered)));
                filtered
            }
        }
    }
}

/// Keeps filtered environments beyond a renderer, for [`Renderer::set_environment_store`](super::Renderer::set_environment_store):
/// `cache::EnvironmentFolder` is one. What is got has to be what was put for equal pixels by
/// the same version of this crate; bytes that no filter has made are taken for none.
pub trait EnvironmentStore: std::fmt::Debug + Send + Sync {
    /// The filtered form of a picture, if it is there and whole.
    fn get(&self, picture: &EquirectImage) -> Option<Vec<u8>>;
    /// Keeps the filtered form of a picture: some megabytes. Where that fails the picture is drawn all the same.
    fn put(&self, picture: &EquirectImage, filtered: &[u8]);
}

/// A picture with all its levels, from a store if it is there.
fn stored(
    store: &dyn EnvironmentStore,
    picture: &Arc<EquirectImage>,
    jobs: &Jobs,
    level: SimdLevel,
) -> PrefilteredEnvironment {
    let found = store.get(picture).and_then(|bytes| PrefilteredEnvironment::from_bytes(&bytes).ok());
    if let Some(found) = found.and_then(|found| found.of_picture(picture)) {
        return found;
    }
    let filtered = PrefilteredEnvironment::new(picture, jobs, level);
    if !jobs.is_cancelled() {
        store.put(picture, &filtered.to_bytes());
    }
    filtered
}

/// Pixels of a picture up to which it pays to draw it once more rather than to filter what no lookup may need: all levels of a
/// picture of 1024 x 512 pixels take about as long as a quarter of a million pixels.
const FEW: u64 = 1 << 18;

/// The levels that a picture is expected to look up: those between the smoothest and the roughest lobes that its materials have
/// by their factors. None of darkness.
pub(super) fn foreseen(scene: &Scene, options: &RenderOptions) -> Levels {
    let source = &scene.environment().source;
    let pixels = u64::from(options.width) * u64::from(options.height);
    // Rays see other surfaces by roughnesses of their own, and the mirror of the studio is its picture.
    let is_whole = options.visibility.rays > 0 || options.stage_hashes || pixels > FEW;
    match source {
        EnvironmentSource::None => return Levels::NONE,
        _ if is_whole => return Levels::ALL,
        EnvironmentSource::Studio if options.background == Background::Environment => return Levels::ALL,
        _ => {}
    }
    let maps = asked_for(options).maps;
    let are_made = matches!(source, EnvironmentSource::Studio)
        && PrefilteredEnvironment::has_studio_directions(maps as usize);
    let begin = if maps == 0 || are_made { Levels::NONE } else { LIGHT_DIRECTIONS };
    let mut levels = begin;
    for material in scene.materials() {
        levels = levels.with(of_material(material, options));
        if levels == Levels::ALL {
            break;
        }
    }
    levels
}

/// Levels that one material reads.
fn of_material(material: &Material, options: &RenderOptions) -> Levels {
    if material.unlit {
        return Levels::NONE;
    }
    let model = material.shading(options.shading);
    let round = model == ShadingModel::Standard;
    // A texture scales the factor, to anything below it.
    let lookups = |factor: f32| if round { roughness_of_lookups(factor) } else { [factor; 2] };
    let range = |factor: f32, textured: bool| {
        let [least, most] = lookups(factor);
        // Roughness grows along filtered edges.
        let edges =
            if options.visibility.is_on() { lookups(NormalFilter::roughest_edge(factor))[1] } else { 0.0 };
        let most = if options.specular_antialiasing { 1.0 } else { most.max(edges) };
        (if textured { 0.0 } else { least }, most)
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
        if material.has_scratches() || material.has_swirl() {
            // Grooves are rougher than the coat.
            let rougher = if coat.1 > 0.5 { coat.1 } else { 0.5 };
            levels = levels.with(Levels::for_roughness(coat.0, rougher));
        }
        // Seen through a rough coat, the base looks rougher (OpenPBR: the fourth powers add up).
        let fourth = |x: f32| (x * x) * (x * x);
        let mut through = (fourth(base.1) + 2.0 * fourth(coat.1)).sqrt().sqrt();
        if model == ShadingModel::StackLitD {
            // Refraction spreads its lobe, at grazing angles without end.
            through = 1.0;
        }
        levels = levels.with(Levels::for_roughness(base.0, if through < 1.0 { through } else { 1.0 }));
    }
    let lobes = &material.lobes;
    if material.has_flakes() {
        // Flakes alone, to all of them together.
        levels = levels.with(Levels::for_roughness(lobes.flakes.roughness, 1.0));
    }
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
    use crate::Quality;
    use overcoat_scene::{Environment, EquirectImage, Instance, Transform, primitives};

    #[test]
    fn of_a_rough_surface_few_levels_are_filtered() {
        let pixels = (0..64 * 32).map(|k| [(k % 7) as f32, 1.0, (k % 5) as f32]).collect();
        let picture = Arc::new(EquirectImage::new(64, 32, pixels).unwrap());
        let source = EnvironmentSource::Image(picture);
        let jobs = Jobs::new(1);
        let (mut scene, mut options) =
            (Scene::new(), RenderOptions::draft(512, 512).with_quality(Quality::Fast));
        (options.width, options.height) = (64, 64);
        let material = scene.add_material(Material::default()).unwrap();
        let mesh = scene.add_mesh(primitives::sphere(1.0, 16).unwrap()).unwrap();
        scene.add_instance(Instance::new(mesh, material, Transform::IDENTITY)).unwrap();
        let [least, most] = roughness_of_lookups(1.0);
        // The directions of the studio's light are known.
        assert_eq!(foreseen(&scene, &options), Levels::for_roughness(least, most));
        options.background = Background::Environment;
        assert_eq!(foreseen(&scene, &options), Levels::ALL);
        options.background = Background::Transparent;
        scene.set_environment(Environment::default().with(|e| e.source = source.clone())).unwrap();
        let levels = foreseen(&scene, &options);
        assert_eq!(levels, LIGHT_DIRECTIONS.with(Levels::for_roughness(least, most)));
        let mut cache = EnvironmentCache::default();
        assert!(cache.would_filter(&source, levels));
        let first = cache.get(&source, levels, &jobs, SimdLevel::best());
        assert!(!first.misses_any_of(levels) && first.misses_any_of(Levels::for_roughness(0.15, 0.15)));
        assert!(!cache.would_filter(&source, levels));
        // The same as long as nothing is lacking; then the same texels and more.
        assert!(Arc::ptr_eq(&first, &cache.get(&source, levels, &jobs, SimdLevel::best())));
        options.stage_hashes = true;
        assert_eq!(foreseen(&scene, &options), Levels::ALL);
        assert!(cache.would_filter(&source, Levels::ALL));
        let all = cache.get(&source, Levels::ALL, &jobs, SimdLevel::best());
        assert!(!all.misses_any_of(Levels::ALL) && !cache.would_filter(&source, Levels::ALL));
    }

    /// Answers with the environment of another picture, or with what nobody has made.
    #[derive(Debug)]
    struct Swapped(Vec<u8>, std::sync::atomic::AtomicUsize);

    impl EnvironmentStore for Swapped {
        fn get(&self, _: &EquirectImage) -> Option<Vec<u8>> {
            Some(self.0.clone())
        }
        fn put(&self, _: &EquirectImage, filtered: &[u8]) {
            assert!(PrefilteredEnvironment::from_bytes(filtered).is_ok());
            self.1.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
        }
    }

    #[test]
    fn what_is_stored_is_used_if_it_fits() {
        let picture = |size: u32, light: f32| {
            Arc::new(
                EquirectImage::new(2 * size, size, vec![[light; 3]; (2 * size * size) as usize]).unwrap(),
            )
        };
        let jobs = Jobs::new(1);
        let filtered = |picture| PrefilteredEnvironment::new(&picture, &jobs, SimdLevel::best());
        let (bright, large) = (filtered(picture(32, 5.0)), filtered(picture(64, 5.0)));
        for (bytes, used) in [(bright.to_bytes(), true), (large.to_bytes(), false), (vec![1, 2, 3], false)] {
            let store = Arc::new(Swapped(bytes, Default::default()));
            let mut cache = EnvironmentCache { store: Some(store.clone()), ..EnvironmentCache::default() };
            let source = EnvironmentSource::Image(picture(32, 1.0));
            let found = cache.get(&source, Levels::NONE, &jobs, SimdLevel::best());
            let expected = if used { &bright } else { &filtered(picture(32, 1.0)) };
            assert!(found.texels() == expected.texels());
            assert!(!found.misses_any_of(Levels::ALL));
            assert_eq!(store.1.load(std::sync::atomic::Ordering::Relaxed), usize::from(!used));
        }
    }
}
