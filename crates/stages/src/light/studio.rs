//! The built-in studio: the light that any model is photographed in unless a scene says otherwise.
//!
//! A room of soft boxes, painted by formula. The picture's front (the camera of the automatic framing) looks from
//! +Z and a little +X; the key light hangs at its upper left, a strip light stands at either side behind the
//! model for bright rims, a large weak panel fills from the right, and a panel overhead draws long highlights on
//! horizontal surfaces. Between them the room is dark, so that a glossy coat shows crisp shapes and not a veil. The
//! key is slightly warm, the fill slightly cool.
//!
//! `examples/make-assets` filters the painting into `assets/environment/studio.env`; that or `studio.packed`, the same in
//! fewer bytes, is part of the program.

use super::chain::Levels;
use super::directions::OF_STUDIO;
use super::{DistantRadiance, PrefilteredEnvironment};
use overcoat_core::jobs::Jobs;
use overcoat_core::math::lanes::{Float, Lanes, Mask, SimdLevel};
use overcoat_core::math::vec3::{V3, Vec3};
use std::borrow::Cow;
use std::sync::{Arc, OnceLock};

/// The prefiltered painting, see [`Studio::prefilter`].
#[cfg(feature = "fast-loading")]
fn bytes() -> Option<Cow<'static, [u8]>> {
    Some(Cow::Borrowed(overcoat_assets::environment::STUDIO))
}

/// The prefiltered painting, see [`Studio::prefilter`].
#[cfg(not(feature = "fast-loading"))]
fn bytes() -> Option<Cow<'static, [u8]>> {
    super::packed::unpack(overcoat_assets::environment::STUDIO_PACKED).map(Cow::Owned)
}

/// The sharpest level of the studio that is read for rough surfaces alone. Those before it have five sixths of the texels.
const ROUGH: usize = 3;

impl PrefilteredEnvironment {
    /// The built-in studio, unpacked once per process (about 2 ms, and without the feature `fast-loading` the time to inflate it).
    #[must_use]
    pub fn studio() -> Arc<Self> {
        static STUDIO: OnceLock<Arc<PrefilteredEnvironment>> = OnceLock::new();
        Arc::clone(STUDIO.get_or_init(|| Self::read_studio(0)))
    }

    /// The same with these levels at least, and those that were lacking before: where they are all rough, a sixth of its texels.
    #[must_use]
    pub fn studio_of(levels: Levels) -> Arc<Self> {
        static STUDIO: OnceLock<Arc<PrefilteredEnvironment>> = OnceLock::new();
        if levels.without(Levels::from_level(ROUGH)) != Levels::NONE {
            return Self::studio();
        }
        let rough = STUDIO.get_or_init(|| Self::read_studio(ROUGH));
        if rough.lacking() == Levels::NONE { Arc::clone(rough) } else { Self::studio() }
    }

    /// Reads the studio from its sharpest level that is needed on. The file is made by this crate and compared by a test; darkness
    /// stands in for what cannot happen.
    fn read_studio(sharpest: usize) -> Arc<Self> {
        let read = bytes().and_then(|bytes| Self::from_first_bytes(&bytes, sharpest).ok());
        let mut studio = read.unwrap_or_else(Self::black);
        studio.made_directions = overcoat_assets::environment::STUDIO_DIRECTIONS;
        Arc::new(studio)
    }

    /// True if directions of the studio of this number are made beforehand, for which no level is read.
    #[must_use]
    pub fn has_studio_directions(count: usize) -> bool {
        OF_STUDIO.contains(&count)
    }
}

/// The painting.
#[derive(Clone, Copy, Debug, Default)]
pub struct Studio;

impl Studio {
    /// Samples along a side of the mirror map: 2^9 + 1.
    const SIZE_LOG2: u32 = 9;

    /// Directions that stand for the studio, of the numbers that the tiers ask for: what `assets/environment/studio.directions` holds.
    #[cfg(any(test, feature = "pack"))]
    #[must_use]
    pub fn directions(studio: &PrefilteredEnvironment) -> Vec<u8> {
        OF_STUDIO.iter().flat_map(|count| studio.divided(*count).to_bytes()).collect()
    }

    /// Filters the painting into what `assets/environment/studio.env` holds.
    #[must_use]
    pub fn prefilter(jobs: &Jobs, level: SimdLevel) -> PrefilteredEnvironment {
        PrefilteredEnvironment::from_radiance(&Self, Self::SIZE_LOG2, jobs, level)
    }
}

/// A flat, evenly lit panel that faces the model, with rounded corners and a soft edge.
struct SoftBox {
    /// Unit vector towards its centre, and the unit vectors of its width and its height.
    centre: [f32; 3],
    across: [f32; 3],
    along: [f32; 3],
    /// Half width and half height at distance 1.
    half: [f32; 2],
    /// Radius of the corners and width of the edge at distance 1.
    corner: f32,
    edge: f32,
    /// Radiance in its middle, and the share of it that is left at the corners.
    radiance: [f32; 3],
    falloff: f32,
}

/// The frame of a soft box that faces the model from a direction: its centre, the vectors of its width and its height.
const fn facing(azimuth: [f32; 2], elevation: [f32; 2]) -> [[f32; 3]; 3] {
    // Sine and cosine of the angles; azimuth from +Z towards +X.
    let ([sin_a, cos_a], [sin_e, cos_e]) = (azimuth, elevation);
    [[sin_a * cos_e, sin_e, cos_a * cos_e], [cos_a, 0.0, -sin_a], [-sin_a * sin_e, cos_e, -cos_a * sin_e]]
}

const fn soft_box(
    frame: [[f32; 3]; 3],
    half: [f32; 2],
    corner: f32,
    edge: f32,
    radiance: [f32; 3],
    falloff: f32,
) -> SoftBox {
    SoftBox { centre: frame[0], across: frame[1], along: frame[2], half, corner, edge, radiance, falloff }
}

/// Sine and cosine of the angles that are needed, in degrees.
const DEG_0: [f32; 2] = [0.0, 1.0];
const DEG_10: [f32; 2] = [0.173_648_18, 0.984_807_75];
const DEG_20: [f32; 2] = [0.342_020_14, 0.939_692_6];
const DEG_40: [f32; 2] = [0.642_787_6, 0.766_044_44];
const DEG_80: [f32; 2] = [0.984_807_75, 0.173_648_18];
const DEG_MINUS_40: [f32; 2] = [-0.642_787_6, 0.766_044_44];
const DEG_95: [f32; 2] = [0.996_194_7, -0.087_155_74];
const DEG_160: [f32; 2] = [0.342_020_14, -0.939_692_6];
const DEG_MINUS_120: [f32; 2] = [-0.866_025_4, -0.5];

/// Key, fill, two rims, overhead panel.
const BOXES: [SoftBox; 5] = [
    soft_box(facing(DEG_MINUS_40, DEG_40), [0.55, 0.42], 0.06, 0.03, [5.6, 5.4, 5.05], 0.75),
    soft_box(facing(DEG_95, DEG_20), [0.5, 0.75], 0.1, 0.12, [0.7, 0.77, 0.88], 0.55),
    soft_box(facing(DEG_160, DEG_20), [0.09, 0.7], 0.05, 0.025, [6.0, 6.0, 6.1], 0.85),
    soft_box(facing(DEG_MINUS_120, DEG_10), [0.11, 0.8], 0.05, 0.025, [6.0, 5.9, 5.8], 0.85),
    soft_box(facing(DEG_0, DEG_80), [0.8, 0.34], 0.05, 0.03, [2.0, 2.0, 2.0], 0.85),
];

/// Smooth step from 0 at or below 0 to 1 at or above 1.
#[inline(always)]
fn smooth<F: Float>(x: F) -> F {
    let x = x.saturate();
    x * x * (x * -2.0 + 3.0)
}

impl SoftBox {
    /// Radiance that it adds to what is seen along a unit direction.
    #[inline(always)]
    fn radiance<L: Lanes>(&self, l: L, d: V3<L>) -> V3<L> {
        let depth = d.dot(Vec3::splat(l, self.centre));
        let inverse = depth.at_least(1e-3).recip();
        let x = (d.dot(Vec3::splat(l, self.across)) * inverse).abs();
        let y = (d.dot(Vec3::splat(l, self.along)) * inverse).abs();
        // Signed distance to the rounded rectangle, negative inside.
        let qx = x - (self.half[0] - self.corner);
        let qy = y - (self.half[1] - self.corner);
        let (ox, oy) = (qx.at_least(0.0), qy.at_least(0.0));
        let distance = (ox * ox + oy * oy).sqrt() + qx.max(qy).at_most(0.0) - self.corner;
        let mask = smooth(distance * (-1.0 / self.edge) + 0.5);
        let (u, v) = (x * (1.0 / self.half[0]), y * (1.0 / self.half[1]));
        let gradient = (u * u + v * v) * (0.5 * (self.falloff - 1.0)) + 1.0;
        let light = depth.gt(l.splat(1e-3)).select(mask * gradient.at_least(0.0), l.zero());
        Vec3::splat(l, self.radiance) * light
    }
}

impl DistantRadiance for Studio {
    #[inline(always)]
    fn radiance<L: Lanes>(&self, l: L, direction: V3<L>) -> V3<L> {
        let d = direction.normalize();
        let y = d.y;
        // The room: walls that darken towards the ceiling, and a floor that gives back some of the light, most of it
        // near the model's feet and in front.
        let walls = smooth(y * 0.8 + 0.2).one_minus() * 0.13 + 0.07;
        let floor = smooth(y * -1.4 - 0.02) * (d.z * 0.08 + 0.26);
        let room = walls + floor;
        let mut sum = Vec3::splat(l, [1.0, 0.99, 0.975]) * room;
        for soft_box in &BOXES {
            sum += soft_box.radiance(l, d);
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use overcoat_core::math::lanes::Scalar;

    /// Levels for rough surfaces are those of the whole studio, which is read once others are looked up.
    #[test]
    fn rough_surfaces_read_its_rough_levels() {
        let (whole, rough) = (PrefilteredEnvironment::studio(), Levels::for_roughness(0.3, 1.0));
        assert!(Arc::ptr_eq(&whole, &PrefilteredEnvironment::studio_of(Levels::ALL)));
        let part = PrefilteredEnvironment::studio_of(rough);
        assert!(!part.misses_any_of(rough) && part.misses_any_of(Levels::for_roughness(0.1, 0.1)));
        for map in ROUGH..crate::light::chain::MAPS {
            assert!(part.chain.map(map) == whole.chain.map(map), "{map}");
        }
        let direction = |l| Vec3::splat(l, [0.3, 0.2, -0.7]);
        let lanes = Scalar;
        for roughness in [0.3, 0.1] {
            let [of_part, of_whole] = [&part, &whole]
                .map(|of| of.chain.radiance(lanes, direction(lanes), lanes.splat(roughness)).lane(0));
            assert_eq!(of_part == of_whole, roughness == 0.3);
        }
        assert!(Arc::ptr_eq(&whole, &PrefilteredEnvironment::studio_of(rough)));
    }

    #[test]
    fn the_file_is_what_the_generator_writes() {
        let made = Studio::prefilter(&Jobs::new(2), SimdLevel::best()).to_bytes();
        assert!(
            bytes().is_some_and(|file| file[..] == made[..]),
            "run: cargo run --release --example make-assets"
        );
        assert!(made.len() < 600_000, "{} bytes", made.len());
    }
}
