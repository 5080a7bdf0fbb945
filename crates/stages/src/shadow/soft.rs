//! Shadows of light that comes from around a direction.
//!
//! Percentage closer soft shadows (Fernando 2005): what blocks is looked for in the cone of the light, and how far away it is
//! says how wide the shadow's edge is; then so much of the map is averaged.

use super::DepthMaps;
use overcoat_core::math::lanes::{Float, Int, Lanes, Mask};

/// Places on a disc of radius 1, each for as much of it: sunflower seeds (Vogel 1979, "A better way to construct the sunflower
/// head"), at sqrt((k + 1/2) / n) and k times 137.5 degrees.
pub(super) const DISC: [[f32; 2]; 16] = [
    [0.176_777, 0.0],
    [-0.225_772, 0.206_826],
    [0.034_558, -0.393_771],
    [0.284_571, 0.371_173],
    [-0.522_223, -0.092_374],
    [0.494_695, -0.314_685],
    [-0.165_466, 0.615_525],
    [-0.315_561, -0.607_594],
    [0.684_642, 0.250_030],
    [-0.712_256, 0.294_009],
    [0.343_354, -0.733_729],
    [0.253_730, 0.808_932],
    [-0.764_746, -0.443_186],
    [0.897_134, -0.197_232],
    [-0.547_507, 0.778_772],
    [-0.126_487, -0.976_090],
];

/// Places in the disc at which occluders are looked for, and their distances from its middle: fewer than are averaged,
/// the first in the middle.
#[allow(clippy::approx_constant, reason = "places in a disc, which are no constants")]
pub(super) const SEARCH: [[f32; 3]; 9] = [
    [0.0, 0.0, 0.0],
    [-0.301_030, 0.275_768, 0.408_248],
    [0.046_077, -0.525_028, 0.527_046],
    [0.379_428, 0.494_897, 0.623_610],
    [-0.696_298, -0.123_165, 0.707_107],
    [0.659_594, -0.419_580, 0.781_736],
    [-0.220_621, 0.820_700, 0.849_837],
    [-0.420_749, -0.810_126, 0.912_871],
    [0.912_856, 0.333_374, 0.971_825],
];

/// Factor of the angle that light comes from: the shadows of neighbouring directions have to overlap, or a ball's has
/// spokes. On the floor below a ball, with 64 directions of an even sky, the opacity of the shadow is off by 0.008
/// (1.0), 0.007 (1.15), 0.007 (1.3) of 0.3 one radius from where it stands, and there too light by 0.11, 0.15 and 0.18
/// of 1.
pub(super) const OVERLAP: f32 = 1.15;

/// Part of the way to the edge of the cone below which an occluder counts as outside of it. Less than 1: few places
/// stand for all that is in it.
pub(super) const OUTSIDE: f32 = 0.5;

impl DepthMaps {
    /// Visibility of the light around a map's direction from points, 0 to 1. The points are in no map themselves, as
    /// those of a surface below everything; `spread` is the tangent of the half angle that the light comes from,
    /// `furthest` a distance within which all occluders of a point lie.
    ///
    /// Of several blockers the near ones count more (the mean distance is harmonic): a map knows where light enters a thing, not
    /// where it would leave it, so that beside the foot of a tall one its top is near.
    #[inline(always)]
    #[must_use]
    pub fn soft_visibility<L: Lanes>(
        &self,
        l: L,
        map: usize,
        position: &[L::F; 3],
        spread: f32,
        furthest: L::F,
    ) -> L::F {
        if self.is_empty() {
            return l.splat(1.0);
        }
        let spread = spread * OVERLAP;
        let [x, y, depth] = self.project(l, map, position);
        let reach = self.reach(depth);
        let around = furthest * (spread / self.texel());
        let (mut found, mut nearness) = (l.zero(), l.zero());
        for [across, down, off] in SEARCH {
            let outermost = self.depth_at(l, map, [x + around * across, y + around * down]);
            let distance = (outermost - reach).to_float();
            // What is so near there lies outside of the cone.
            let blocks = (distance * spread * self.steepness()).gt(around * (off * OUTSIDE));
            let blocks = blocks & distance.gt(l.zero());
            found = found + blocks.select(l.splat(1.0), l.zero());
            nearness = nearness + blocks.select(distance.at_least(1.0).recip(), l.zero());
        }
        let some = found.gt(l.zero());
        if !some.any() {
            return l.splat(1.0);
        }
        let distance = some.select(found, l.zero()) / some.select(nearness, l.splat(1.0));
        let width = distance * (spread * self.steepness());
        let mut open = l.zero();
        for [across, down] in DISC {
            open = open + self.open(l, map, [x + width * across, y + width * down], reach);
        }
        some.select(open * (1.0 / DISC.len() as f32), l.splat(1.0))
    }
}
