//! Levels of quality: the work that a picture is worth.

use overcoat_core::built::Shadows;
use overcoat_core::math::lanes::LANES;

/// Larger side in pixels from which on a picture of [`Quality::Fast`] has the largest and most maps.
const WIDE: u32 = 512;

/// Pixels for each texel of a map along a side, where the scene fills the picture.
const PIXELS_PER_TEXEL: u32 = 4;

/// Rays that a lobe sends in enclosed spaces in a picture of [`Quality::Fast`].
const INDOOR_RAYS: u32 = 1;

/// Settings for the light that other surfaces block and send back.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub struct Visibility {
    /// Directions that the environment's light is taken to come from, each with a depth map of the scene: 0 (nothing is
    /// blocked) to [`Visibility::MOST_MAPS`].
    pub maps: u32,
    /// Texels along a side of a depth map, [`Visibility::SMALLEST_MAP`] to [`Visibility::LARGEST_MAP`].
    pub map_size: u32,
    /// Rays that each lobe of a surface of a pixel sends for the light of other surfaces, 0 to [`Visibility::MOST_RAYS`]; fewer
    /// where it is narrow or shows little. Those of neighbouring pixels count together where these are alike, and below 32 the rays
    /// of wide lobes are sent once for the alike surfaces of four pixels. With 0 that light
    /// is estimated from the maps. Of no effect without maps.
    pub rays: u32,
    /// Rays in place of none for scenes of enclosed spaces (rooms, boxes, caves), 0 to [`Visibility::MOST_RAYS`]: few directions reach into
    /// these, so that maps show each of them as a facet, and most of their light comes from walls and lamps.
    pub indoor_rays: u32,
}

impl Visibility {
    /// Nothing is blocked.
    pub const NONE: Self = Self { maps: 0, map_size: 256, rays: 0, indoor_rays: 0 };
    /// Largest number of maps.
    pub const MOST_MAPS: u32 = 256;
    /// Smallest side of a map.
    pub const SMALLEST_MAP: u32 = 32;
    /// Largest side of a map.
    pub const LARGEST_MAP: u32 = 2048;
    /// Largest number of rays.
    pub const MOST_RAYS: u32 = 256;

    /// This many maps, texels along a side of each, and rays, indoors as well.
    #[must_use]
    pub const fn new(maps: u32, map_size: u32, rays: u32) -> Self {
        Self { maps, map_size, rays, indoor_rays: 0 }
    }

    /// The same with another number of maps.
    #[must_use]
    pub const fn with_maps(self, maps: u32) -> Self {
        Self { maps, ..self }
    }

    /// The same with maps of another size.
    #[must_use]
    pub const fn with_map_size(self, map_size: u32) -> Self {
        Self { map_size, ..self }
    }

    /// The same with another number of rays.
    #[must_use]
    pub const fn with_rays(self, rays: u32) -> Self {
        Self { rays, ..self }
    }

    /// The same with another number of rays indoors.
    #[must_use]
    pub const fn with_indoor_rays(self, indoor_rays: u32) -> Self {
        Self { indoor_rays, ..self }
    }

    /// The same for a scene of enclosed spaces.
    #[must_use]
    pub const fn indoors(self) -> Self {
        let rays = if self.rays > 0 { self.rays } else { self.indoor_rays };
        Self { rays, indoor_rays: 0, ..self }
    }

    /// True if blocked light is found.
    #[must_use]
    pub const fn is_on(&self) -> bool {
        self.maps > 0
    }

    /// The next with less expensive maps, and as many rays: as few and as small as in [`Quality::Good`], then as in
    /// [`Quality::Fast`], then 16 of 64 x 64 texels, then none, without rays either. `None` if this is [`Visibility::NONE`] already.
    #[must_use]
    pub fn with_less_maps(self) -> Option<Self> {
        let steps = [(64, 256), (64, 128), (16, 64)];
        let fewer = |(maps, size): (u32, u32)| Self {
            maps: self.maps.min(maps),
            map_size: self.map_size.min(size),
            ..self
        };
        let next = steps.into_iter().map(fewer).find(|fewer| *fewer != self);
        self.is_on().then(|| next.unwrap_or(Self::NONE))
    }

    /// The next less expensive one: without rays, then with few small maps (a sixteenth of the work and the memory of
    /// [`Quality::Fast`]), then none. `None` if this is [`Visibility::NONE`] already.
    #[must_use]
    pub fn reduced(self) -> Option<Self> {
        let few = Self::new(self.maps.min(16), self.map_size.min(64), 0);
        match self {
            Self { maps: 0, .. } => None,
            Self { rays: 1.., .. } => Some(self.with_rays(0)),
            _ if few != self => Some(few),
            _ => Some(Self::NONE),
        }
    }
}

impl Default for Visibility {
    fn default() -> Self {
        Self::NONE
    }
}

/// Names for settings that go together.
///
/// The default is [`Quality::Fast`]; [`Quality::Draft`] in programs without the feature `shadows`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Quality {
    /// Nothing is blocked.
    Draft,
    /// Shadows of the environment from small depth maps; other surfaces send back what the fragment itself would.
    Fast,
    /// Larger maps, few rays for the light of other surfaces, and four shadings a pixel where one would show.
    Good,
    /// The same with more maps and rays.
    Best,
}

impl Default for Quality {
    fn default() -> Self {
        if Shadows::IS_BUILT { Self::Fast } else { Self::Draft }
    }
}

impl Quality {
    /// All of them, in the order of what they take.
    pub const ALL: &'static [Self] = &[Self::Draft, Self::Fast, Self::Good, Self::Best];

    /// Name as `--quality` takes it.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Draft => "draft",
            Self::Fast => "fast",
            Self::Good => "good",
            Self::Best => "best",
        }
    }

    /// The one of that name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|quality| quality.name() == name)
    }

    /// Shadings a pixel where one would show, see `RenderOptions::shading_rate`.
    #[must_use]
    pub const fn shading_rate(self) -> u32 {
        match self {
            Self::Draft | Self::Fast => 1,
            Self::Good | Self::Best => 4,
        }
    }

    /// Precision of occlusion at this level, of a picture of any size.
    #[must_use]
    pub const fn visibility(self) -> Visibility {
        match self {
            Self::Draft => Visibility::NONE,
            Self::Fast => Visibility::new(64, WIDE / PIXELS_PER_TEXEL, 0).with_indoor_rays(INDOOR_RAYS),
            Self::Good => Visibility::new(64, 256, 4),
            Self::Best => Visibility::new(128, 512, 16),
        }
    }

    /// Precision of occlusion at this level that a picture of this width and height in pixels shows: of a small one,
    /// [`Quality::Fast`] has fewer and smaller maps, down to three quarters as many of three quarters of the size.
    #[must_use]
    pub fn visibility_of(self, [width, height]: [u32; 2]) -> Visibility {
        let whole = self.visibility();
        if self != Self::Fast {
            return whole;
        }
        let side = width.max(height).clamp(WIDE * 3 / 4, WIDE);
        Visibility {
            maps: (whole.maps * side).div_ceil(WIDE),
            map_size: (side / PIXELS_PER_TEXEL).next_multiple_of(LANES as u32),
            ..whole
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_lead_back() {
        for quality in Quality::ALL {
            assert_eq!(Quality::from_name(quality.name()), Some(*quality));
        }
        assert_eq!(Quality::from_name("ultra"), None);
    }

    /// Every tier comes down to a draft in a few steps.
    #[test]
    fn reduction_ends() {
        for quality in Quality::ALL {
            let steps: Vec<Visibility> =
                std::iter::successors(Some(quality.visibility()), |visibility| visibility.reduced())
                    .collect();
            assert!(steps.len() <= 4, "{steps:?}");
            assert!(!steps.last().unwrap().is_on(), "{steps:?}");
            let work =
                |v: &Visibility| u64::from(v.maps) * u64::from(v.map_size).pow(2) * u64::from(1 + v.rays);
            assert!(steps.windows(2).all(|pair| work(&pair[0]) > work(&pair[1])), "{steps:?}");
        }
    }

    /// Maps become fewer and smaller, and rays stay as long as there are any.
    #[test]
    fn maps_come_down_to_none() {
        let next = |visibility: &Visibility| visibility.with_less_maps();
        let steps: Vec<Visibility> = std::iter::successors(Some(Quality::Best.visibility()), next).collect();
        let rays = |(maps, size)| Visibility::new(maps, size, 16);
        let expected = [(128, 512), (64, 256), (64, 128), (16, 64)].map(rays);
        assert_eq!((&steps[..4], &steps[4..]), (&expected[..], &[Visibility::NONE][..]));
        assert_eq!(Visibility::new(8, 32, 4).with_less_maps(), Some(Visibility::NONE));
    }

    /// A smaller picture has no more of anything, one of 512 pixels or more has all.
    #[test]
    fn small_pictures_have_fewer_and_smaller_maps() {
        for quality in Quality::ALL {
            let all = quality.visibility();
            for size in [[512, 1], [1, 512], [2048, 512]] {
                assert_eq!(quality.visibility_of(size), all);
            }
            let sides: Vec<Visibility> = (1..=520).map(|side| quality.visibility_of([side, 1])).collect();
            for pair in sides.windows(2) {
                assert!(pair[0].maps <= pair[1].maps && pair[0].map_size <= pair[1].map_size);
                assert_eq!(pair[0].map_size % 16, 0);
            }
        }
        let fast = |maps, size| Visibility::new(maps, size, 0).with_indoor_rays(INDOOR_RAYS);
        assert_eq!(Quality::Fast.visibility_of([256, 256]), fast(48, 96));
        assert_eq!(Quality::Fast.visibility_of([448, 256]), fast(56, 112));
        assert_eq!(Quality::Fast.visibility_of([1, 1]), fast(48, 96));
    }

    /// A better tier has no less of anything.
    #[test]
    fn tiers_are_in_order() {
        for pair in Quality::ALL.windows(2) {
            let [worse, better] = [pair[0].visibility(), pair[1].visibility()];
            assert!(worse.maps <= better.maps && worse.rays <= better.rays);
            assert!(pair[0].shading_rate() <= pair[1].shading_rate());
            assert!(!worse.is_on() || worse.map_size <= better.map_size);
        }
    }
}
