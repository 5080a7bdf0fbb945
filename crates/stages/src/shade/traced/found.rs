//! Light that rays have found, as sums.

use super::TracedLobe;
use crate::gbuffer::layout::SurfacePlanes;
use crate::shade::occlusion::share;
use crate::shade::record::{get, get_vector, put};
use overcoat_core::math::lanes::{Float, LANES, Lanes, Mask};
use overcoat_core::math::vec3::{V3, Vec3};
use overcoat_scene::Material;

/// Numbers of a lobe: what was sent back (3), the weight of what was hit, the weight of all, the environment's light (3) and
/// what of it was open (3); and one more, so that they are whole vectors. Of diffuse lobes, in place of the environment's light that
/// of lamps (3) and how many have looked for it (1).
const SUMS: usize = 12;

/// Sums of each lobe that come from rays into it.
const OF_RAYS: [std::ops::Range<usize>; TracedLobe::COUNT] = [0..5, 0..11, 0..11];

/// Sums of diffuse lobes that are of the light of lamps.
const OF_LAMPS: std::ops::Range<usize> = 5..9;

/// Sums over the rays of each lobe of a fragment. Those of fragments that are alike may be added.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Found {
    lobes: [[f32; SUMS]; TracedLobe::COUNT],
}

impl Found {
    /// Adds rays that were sent: their weight, the light of the environment from where they went, and what of it was open.
    #[inline(always)]
    pub(super) fn add_sent(&mut self, lobe: TracedLobe, weight: f32, all: [f32; 3], open: [f32; 3]) {
        let sums = &mut self.lobes[lobe as usize];
        sums[4] += weight;
        for k in 0..3 {
            sums[5 + k] += all[k];
            sums[8 + k] += open[k];
        }
    }

    /// Adds the light of lamps to diffuse light.
    #[inline(always)]
    pub(super) fn add_direct(&mut self, light: [f32; 3]) {
        let sums = &mut self.lobes[TracedLobe::Diffuse as usize];
        for k in 0..3 {
            sums[5 + k] += light[k];
        }
        sums[8] += 1.0;
    }

    /// Adds the light that a ray has hit, of a weight, and what of this counts as hit: nothing where the ray has gone on.
    #[inline(always)]
    pub(super) fn add_hit(&mut self, lobe: TracedLobe, (weight, hit): (f32, f32), radiance: [f32; 3]) {
        let sums = &mut self.lobes[lobe as usize];
        for k in 0..3 {
            sums[k] += radiance[k] * weight;
        }
        sums[3] += hit;
    }

    /// True if lamps were looked for.
    #[inline(always)]
    #[must_use]
    pub fn has_direct(&self) -> bool {
        self.lobes[TracedLobe::Diffuse as usize][8] > 0.0
    }

    /// The sums of what rays into a lobe have found.
    #[inline(always)]
    #[must_use]
    pub fn of_rays(&self, lobe: TracedLobe) -> &[f32] {
        &self.lobes[lobe as usize][OF_RAYS[lobe as usize].clone()]
    }

    /// The same, to be changed.
    #[inline(always)]
    #[must_use]
    pub fn of_rays_mut(&mut self, lobe: TracedLobe) -> &mut [f32] {
        &mut self.lobes[lobe as usize][OF_RAYS[lobe as usize].clone()]
    }

    /// The sums of the light of lamps.
    #[inline(always)]
    #[must_use]
    pub fn of_lamps(&self) -> &[f32] {
        &self.lobes[TracedLobe::Diffuse as usize][OF_LAMPS]
    }

    /// The same, to be changed.
    #[inline(always)]
    #[must_use]
    pub fn of_lamps_mut(&mut self) -> &mut [f32] {
        &mut self.lobes[TracedLobe::Diffuse as usize][OF_LAMPS]
    }

    /// Adds a share of what the rays of the same lobe of another fragment have found.
    #[inline(always)]
    pub fn add(&mut self, lobe: TracedLobe, other: &Self, share: f32) {
        for (sum, more) in self.lobes[lobe as usize].iter_mut().zip(&other.lobes[lobe as usize]) {
            *sum += share * more;
        }
    }

    /// Fills the planes of up to sixteen fragments of a material with what rays have found, where they were sent; what the maps
    /// know is in them.
    #[inline(never)]
    pub fn store<L: Lanes>(l: L, material: &Material, found: &[Self; LANES], planes: &mut SurfacePlanes) {
        for &lobe in TracedLobe::of(material) {
            l.run(
                #[inline(always)]
                || store(l, lobe, &transposed(l, lobe, found), planes),
            );
        }
    }
}

/// The rays of one lobe of sixteen fragments.
struct Sums<L: Lanes> {
    sent: V3<L>,
    hit: L::F,
    weight: L::F,
    all: V3<L>,
    open: V3<L>,
}

#[inline(always)]
fn transposed<L: Lanes>(l: L, lobe: TracedLobe, found: &[Found; LANES]) -> Sums<L> {
    let mut rows = [[0.0; LANES]; SUMS];
    for (lane, found) in found.iter().enumerate() {
        for (row, sum) in rows.iter_mut().zip(&found.lobes[lobe as usize]) {
            row[lane] = *sum;
        }
    }
    let vector =
        |first: usize| Vec3::new(l.load(&rows[first]), l.load(&rows[first + 1]), l.load(&rows[first + 2]));
    Sums { sent: vector(0), hit: l.load(&rows[3]), weight: l.load(&rows[4]), all: vector(5), open: vector(8) }
}

/// Number of rays that the estimate of the maps counts for beside those that hit something.
const PRIOR: f32 = 0.25;

/// Alpha from which on the maps have a say about a lobe, for each ray that it has, and the span of alpha over which it
/// becomes all.
const SHARP: [f32; 2] = [0.02, 0.3];

/// Least number of rays that a lobe counts as: one alone is right in a mirror.
const FEWEST: f32 = 4.0;

/// Writes what the rays of a lobe have found.
#[inline(always)]
fn store<L: Lanes>(l: L, lobe: TracedLobe, sums: &Sums<L>, planes: &mut SurfacePlanes) {
    let [seen_plane, bounce_plane] = lobe.planes();
    // How much of a wide lobe is open the maps know better than few rays, and of diffuse light they always say: what is open and
    // what is sent back in the place of the rest then add up.
    let wide = if lobe == TracedLobe::Diffuse {
        l.splat(1.0)
    } else {
        let [roughness] = get::<L, 1>(l, planes, lobe.shape()[1]);
        ((roughness.squared() - sums.weight.at_least(FEWEST) * SHARP[0]) * (1.0 / SHARP[1])).saturate()
    };
    // The open share by the maps, and from what is blocked the mean of what rays have met there.
    let (estimate, blocked) = (get_vector(l, planes, bounce_plane), lobe.sky(l, planes).one_minus());
    let mean = (sums.sent * blocked + estimate * PRIOR) / (sums.hit + PRIOR);
    // Where none has met anything though some should have, less is blocked. Of diffuse light the maps say how much.
    let expected = (sums.weight * blocked + 1.0).recip();
    let none = !sums.hit.gt(l.zero());
    let mean = if lobe == TracedLobe::Diffuse { mean } else { mean * none.select(expected, l.splat(1.0)) };
    // By the rays alone.
    let direct = sums.sent / sums.weight.at_least(1e-6);
    let traced = sums.weight.gt(l.zero());
    let mut bounce = Vec3::select(traced, direct.lerp(mean, wide), estimate);
    if lobe == TracedLobe::Diffuse {
        bounce += sums.all / sums.open.x.at_least(1e-6);
    }
    put(planes, bounce_plane, bounce.to_array());
    if lobe != TracedLobe::Diffuse {
        let (direct, known) = (share(l, sums.open, sums.all), get_vector(l, planes, seen_plane));
        let seen = Vec3::select(traced, direct.lerp(known, wide), known);
        put(planes, seen_plane, seen.to_array());
    }
}
