//! How much work a picture is worth.

/// What blocks the light of the environment, and what is known of light that comes back from other surfaces.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub struct Visibility {
    /// Directions that the environment's light is taken to come from, each with a depth map of the scene: 0 (nothing is
    /// blocked) to 256.
    pub maps: u32,
    /// Texels along a side of a depth map, 16 to 2048.
    pub map_size: u32,
    /// Rays that each lobe of a fragment sends for the light of other surfaces, 0 to 256; 0 estimates it from the maps. Needs
    /// maps.
    pub rays: u32,
}

impl Visibility {
    /// Nothing is blocked.
    pub const NONE: Self = Self { maps: 0, map_size: 16, rays: 0 };

    /// This many maps and rays.
    #[must_use]
    pub const fn new(maps: u32, map_size: u32, rays: u32) -> Self {
        Self { maps, map_size, rays }
    }

    /// Whether anything is found of what blocks light.
    #[must_use]
    pub const fn is_on(&self) -> bool {
        self.maps > 0
    }
}
