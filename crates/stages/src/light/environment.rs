//! Light from afar: what surrounds the scene, prepared for lookups.

use super::chain::{Chain, IRRADIANCE, Levels, MAX_CELLS, MIN_CELLS};
use super::charlie::CharlieMaps;
use super::directions::KEPT;
use super::equirect;
use super::prefilter::{self, Grid, Pyramid};
use super::{DistantRadiance, LightDirections};
use overcoat_core::built::Environments;
use overcoat_core::jobs::Jobs;
use overcoat_core::math;
use overcoat_core::math::lanes::{Lanes, SimdLevel};
use overcoat_core::math::vec3::{V3, Vec3};
use overcoat_scene::EquirectImage;
use std::borrow::Cow;
use std::sync::{Arc, OnceLock};

/// An environment that is ready to light surfaces: its mirror image, its reflections in twelve roughnesses
/// and its diffuse irradiance. It knows neither rotation nor intensity, see [`EnvironmentLight`].
#[derive(Clone)]
pub struct PrefilteredEnvironment {
    pub(super) chain: Chain,
    /// The original, where there is one, for visible backgrounds.
    pub(super) picture: Option<Arc<EquirectImage>>,
    pub(super) found: Found,
    /// Maps of the sheen lobe, filtered when they are first asked for.
    charlie: OnceLock<CharlieMaps>,
    /// Directions that stand for it, of the numbers that were asked for first.
    pub(super) directions: [OnceLock<(usize, LightDirections)>; KEPT],
    /// Directions that were made beforehand, as bytes.
    pub(super) made_directions: &'static [u8],
    /// Copies that missing levels are filtered from.
    unfiltered: Option<Arc<Pyramid>>,
}

/// Source of the light that surfaces look up around them.
#[derive(Clone, Copy)]
pub(super) enum Found {
    /// The maps of the chain.
    Maps,
    /// Nothing: the maps hold zeros, and need not be read.
    Darkness,
    /// The formula of the reference tables, and this irradiance over pi for every normal.
    Reference([f32; 3]),
}

impl std::fmt::Debug for PrefilteredEnvironment {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("PrefilteredEnvironment")
            .field("size", &self.chain.size(0))
            .field("picture", &self.picture)
            .finish_non_exhaustive()
    }
}

impl PrefilteredEnvironment {
    /// All texels of the filtered maps, for a hash of them.
    pub fn texels(&self) -> &[u32] {
        self.chain.texels()
    }

    /// Filters a picture. The result depends on the picture alone, not on the number of threads nor the
    /// instruction set.
    ///
    /// Its mirror level has half as many samples across as the picture is wide, up to 1025.
    #[must_use]
    pub fn new(picture: &Arc<EquirectImage>, jobs: &Jobs, level: SimdLevel) -> Self {
        let mut environment = Self::by_need(picture, jobs, level);
        environment.filter(Levels::ALL, jobs, level);
        environment
    }

    /// The same without its rough levels: [`PrefilteredEnvironment::filter`] adds those that somebody needs.
    pub fn by_need(picture: &Arc<EquirectImage>, jobs: &Jobs, level: SimdLevel) -> Self {
        // What is finer than the map would alias; four lookups a sample reach every pixel of a picture of 2048.
        let small = equirect::reduced(picture, LARGEST[0], LARGEST[1]);
        let source = small.as_ref().unwrap_or(picture);
        let size = mirror_size(picture);
        let mut environment = Self::from_grid(Grid::paint(source, size, 2, jobs, level), jobs, level);
        environment.picture = Some(Arc::clone(picture));
        environment
    }

    /// Takes maps for those of a picture, if they have the size that it gives them.
    pub fn of_picture(mut self, picture: &Arc<EquirectImage>) -> Option<Self> {
        self.picture = Some(Arc::clone(picture));
        (self.chain.size(0) == mirror_size(picture)).then_some(self)
    }

    /// Filters what is missing of these levels.
    pub fn filter(&mut self, levels: Levels, jobs: &Jobs, level: SimdLevel) {
        let Some(pyramid) = &self.unfiltered else { return };
        pyramid.filter_into(&mut self.chain, levels, jobs, level);
        // Made of levels, perhaps of such as were missing.
        self.charlie = OnceLock::new();
        self.directions = Default::default();
        self.made_directions = &[];
        if self.chain.present == Levels::ALL {
            self.unfiltered = None;
        }
    }

    /// Levels that were looked up though they are missing.
    pub fn lacking(&self) -> Levels {
        self.chain.lacking()
    }

    /// True if some of these levels are missing.
    pub fn misses_any_of(&self, levels: Levels) -> bool {
        levels.without(self.chain.present) != Levels::NONE
    }

    /// Filters radiance that is given by a formula. The mirror level gets `2^size_log2 + 1` samples across;
    /// `size_log2` counts as 5 to 10.
    #[must_use]
    pub fn from_radiance(
        source: &(impl DistantRadiance + Sync),
        size_log2: u32,
        jobs: &Jobs,
        level: SimdLevel,
    ) -> Self {
        let size = (1 << size_log2.clamp(5, 10)) + 1;
        let mut environment = Self::from_grid(Grid::paint(source, size, 4, jobs, level), jobs, level);
        environment.filter(Levels::ALL, jobs, level);
        environment
    }

    /// The mirror and the irradiance.
    fn from_grid(grid: Grid, jobs: &Jobs, level: SimdLevel) -> Self {
        let (chain, pyramid) = prefilter::begin(grid, jobs, level);
        Self { unfiltered: Some(Arc::new(pyramid)), ..Self::of_chain(chain) }
    }

    /// Environment of maps that are filtered.
    pub(super) fn of_chain(chain: Chain) -> Self {
        Self {
            chain,
            picture: None,
            found: Found::Maps,
            charlie: OnceLock::new(),
            directions: Default::default(),
            made_directions: &[],
            unfiltered: None,
        }
    }

    /// The analytic environment `E(d, p)` of the reference tables of shading models, with the same irradiance over pi
    /// for every normal. For tests of models through whole pictures.
    #[must_use]
    pub fn reference(irradiance_over_pi: [f32; 3]) -> Self {
        Self { found: Found::Reference(irradiance_over_pi), ..Self::black() }
    }

    /// Darkness.
    #[must_use]
    pub fn black() -> Self {
        Self { found: Found::Darkness, ..Self::of_chain(Chain::dark(MIN_CELLS + 1)) }
    }
}

/// Pixels across and down of a picture up to which it is filtered as it is.
const LARGEST: [u32; 2] = [2048, 1024];

/// Samples along a side of the mirror map of a picture.
fn mirror_size(picture: &EquirectImage) -> usize {
    let (width, height) = (picture.width().min(LARGEST[0]), picture.height().min(LARGEST[1]));
    (width.max(2 * height) as usize / 2).next_power_of_two().clamp(32, MAX_CELLS) + 1
}

/// An environment as one frame sees it: turned and scaled.
#[derive(Clone, Copy, Debug)]
pub struct EnvironmentLight<'a> {
    environment: &'a PrefilteredEnvironment,
    /// Cosine and sine of the rotation.
    cos: f32,
    sin: f32,
    intensity: f32,
}

impl<'a> EnvironmentLight<'a> {
    /// Turns the environment by `rotation_degrees` about +Y, counter-clockwise seen from above (three.js
    /// `environmentRotation.y`), and multiplies its radiance by `intensity`.
    #[must_use]
    pub fn new(environment: &'a PrefilteredEnvironment, rotation_degrees: f32, intensity: f32) -> Self {
        let degrees = f64::from(rotation_degrees);
        let turns = degrees / 360.0;
        let (sin, cos) = math::double::sin_cos((turns - turns.floor()) * std::f64::consts::TAU);
        Self { environment, cos: cos as f32, sin: sin as f32, intensity }
    }

    /// True if no light comes from it.
    #[must_use]
    pub fn is_dark(&self) -> bool {
        matches!(self.environment.found, Found::Darkness) || self.intensity == 0.0
    }

    /// The direction in the environment's own frame: turned back.
    #[inline(always)]
    fn turned_back<L: Lanes>(&self, _: L, direction: V3<L>) -> V3<L> {
        let Vec3 { x, y, z } = direction;
        Vec3::new(x * self.cos - z * self.sin, y, x * self.sin + z * self.cos)
    }

    /// A direction of the environment's own frame in the scene.
    #[must_use]
    pub fn turned(&self, [x, y, z]: [f32; 3]) -> [f32; 3] {
        [x * self.cos + z * self.sin, y, z * self.cos - x * self.sin]
    }

    /// [`PrefilteredEnvironment::light_directions`] in its own frame, see [`EnvironmentLight::turned`]. The fluxes are those of
    /// intensity 1.
    #[must_use]
    pub fn light_directions(&self, count: usize) -> Cow<'_, LightDirections> {
        self.environment.light_directions(count)
    }

    /// Radiance that arrives from around `direction` (away from the surface, any length), filtered for a surface of
    /// this perceptual roughness (0 to 1, GGX's alpha is its square).
    ///
    /// The level follows Unity's `PerceptualRoughnessToMipmapLevel`; because each level holds the reflection for its
    /// own roughness, other models may use it with theirs.
    #[inline(always)]
    #[must_use]
    pub fn radiance<L: Lanes>(&self, l: L, direction: V3<L>, perceptual_roughness: L::F) -> V3<L> {
        let direction = self.turned_back(l, direction);
        let rgb = match self.environment.found {
            Found::Maps => self.environment.chain.radiance(l, direction, perceptual_roughness),
            Found::Darkness => return Vec3::zero(l),
            Found::Reference(_) => super::reference::radiance(l, direction, perceptual_roughness),
        };
        rgb * self.intensity
    }

    /// Radiance that arrives from around `direction` (away from the surface, any length), filtered for the sheen of cloth of this
    /// perceptual roughness: Charlie's distribution in place of GGX. The first who asks makes its maps.
    #[inline(always)]
    #[must_use]
    pub fn charlie_radiance<L: Lanes>(&self, l: L, direction: V3<L>, perceptual_roughness: L::F) -> V3<L> {
        let direction = self.turned_back(l, direction);
        let PrefilteredEnvironment { chain, charlie, .. } = self.environment;
        let rgb = match self.environment.found {
            Found::Maps => charlie.get_or_init(|| CharlieMaps::new(l, chain)).radiance(
                l,
                direction,
                perceptual_roughness,
            ),
            Found::Darkness => return Vec3::zero(l),
            Found::Reference(_) => super::reference::radiance(l, direction, perceptual_roughness),
        };
        rgb * self.intensity
    }

    /// Irradiance on a surface with this unit normal, divided by pi: the radiance of a white Lambert surface. Never
    /// negative. Unity's `bakedGI`.
    #[inline(always)]
    #[must_use]
    pub fn irradiance_over_pi<L: Lanes>(&self, l: L, normal: V3<L>) -> V3<L> {
        let rgb = match self.environment.found {
            Found::Maps => self.environment.chain.lookup(l, IRRADIANCE, self.turned_back(l, normal)),
            Found::Darkness => return Vec3::zero(l),
            Found::Reference(irradiance_over_pi) => Vec3::splat(l, irradiance_over_pi),
        };
        rgb * self.intensity
    }

    /// The unfiltered environment in a direction of any length, as a background shows it: from the original picture
    /// where there is one.
    #[inline(always)]
    #[must_use]
    pub fn background<L: Lanes>(&self, l: L, direction: V3<L>) -> V3<L> {
        let direction = self.turned_back(l, direction);
        let rgb = match &self.environment.picture {
            Some(picture) if Environments::IS_BUILT => picture.radiance(l, direction),
            _ => self.environment.chain.lookup(l, 0, direction),
        };
        rgb * self.intensity
    }
}
