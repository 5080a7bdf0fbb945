//! Filtering an environment for cloth: one octahedral map for each roughness of Charlie's distribution.
//!
//! What a level holds for the direction r is the radiance that cloth of its roughness reflects when it is looked at along its
//! normal, without what fibres shadow (N = V = R, as the Khronos glTF IBL Sampler filters its cubes for sheen): the half
//! vector of a direction at the cosine c lies at sin^2 = (1 - c) / 2, the distribution of Estevez and Kulla (2017) is
//! sin^(1 / alpha) there, so that
//!
//! ```text
//!          integral L(l) ((1 - c) / 2)^n c dl
//! level =  ----------------------------------     with c = r.l above 0 and n = 1 / (2 alpha)
//!             integral ((1 - c) / 2)^n c dl
//! ```
//!
//! The smoother the cloth, the nearer to the horizon is the ring that it sees. A lookup for GGX sees the middle instead: over
//! four photographed studios and skies, the error of the sheen of a sphere (beside the integral of the whole lobe, relative to
//! the mean radiance, at roughness 0.5) is 0.93 with GGX's map in the mirrored direction, 0.55 with this one there,
//! 0.48 with the irradiance of the normal, and 0.26 with this map at the normal.

use super::chain::{Chain, Levels, bilinear};
use super::{octahedral, texel};
use overcoat_core::math::lanes::{Float, LANES, Lanes, Mask};
use overcoat_core::math::log2;
use overcoat_core::math::vec3::{V3, Vec3};

/// Levels: n is 1/2, 1, 2, and so on, the perceptual roughness 1, 0.71, 0.5, 0.35, 0.25 and 0.18.
const LEVELS: usize = 6;

/// Samples along a side of a map.
const SIZE: usize = 33;

/// Samples along a side of what is filtered.
const SOURCE: usize = 65;

/// Perceptual roughness for which the chain is read there: lobes as wide as the samples are apart.
const SOURCE_ROUGHNESS: f32 = 0.15;

/// The levels that are read there.
pub const SHEEN: Levels = Levels::for_roughness(SOURCE_ROUGHNESS, SOURCE_ROUGHNESS);

/// Environment filtered with the sheen lobe, for cloth.
#[derive(Clone, Debug)]
pub(super) struct CharlieMaps {
    texels: Vec<u32>,
}

/// A direction, and the radiance from there times its solid angle.
struct Light {
    direction: [f32; 3],
    radiance: [f32; 3],
    solid_angle: f32,
}

impl CharlieMaps {
    /// Filters a prefiltered environment further. Takes some 15 ms of one processor.
    #[inline(never)]
    pub(super) fn new<L: Lanes>(l: L, chain: &Chain) -> Self {
        let mut texels = vec![0; LEVELS * SIZE * SIZE];
        l.run(
            #[inline(always)]
            || {
                let lights = lights(l, chain);
                for first in (0..SIZE * SIZE).step_by(LANES) {
                    let maps = filter(l, &lights, first);
                    for (level, rgb) in maps.iter().enumerate() {
                        let out = &mut texels[level * SIZE * SIZE..][first..(first + LANES).min(SIZE * SIZE)];
                        for (k, texel) in out.iter_mut().enumerate() {
                            *texel = texel::encode([rgb[0][k], rgb[1][k], rgb[2][k]]);
                        }
                    }
                }
            },
        );
        Self { texels }
    }

    /// Radiance for a direction of any length and a perceptual roughness, of which those below 0.18 count as that.
    #[inline(always)]
    pub(super) fn radiance<L: Lanes>(&self, l: L, direction: V3<L>, perceptual_roughness: L::F) -> V3<L> {
        const LAST: f32 = (LEVELS - 1) as f32;
        let roughness = perceptual_roughness.clamp_to(0.1, 1.0);
        let level = (log2(l, roughness) * -2.0).clamp_to(0.0, LAST);
        let floor = level.floor().at_most(LAST - 1.0);
        let place = octahedral::encode(l, direction);
        let size = l.splat_i(SIZE as i32);
        let start = floor.to_int() * l.splat_i((SIZE * SIZE) as i32);
        let rough = bilinear(l, &self.texels, start, size, place);
        let smooth = bilinear(l, &self.texels, start + (SIZE * SIZE) as i32, size, place);
        rough.lerp(smooth, level - floor)
    }
}

/// The environment as a few thousand lights.
#[inline(always)]
fn lights<L: Lanes>(l: L, chain: &Chain) -> Vec<Light> {
    let mut lights = Vec::with_capacity(SOURCE * SOURCE);
    for first in (0..SOURCE * SOURCE).step_by(LANES) {
        let (u, v) = octahedral::positions(l, SOURCE, first);
        let (direction, density) = octahedral::directions(l, u, v);
        let radiance = chain.radiance(l, direction, l.splat(SOURCE_ROUGHNESS)).to_arrays();
        let (directions, densities) = (direction.to_arrays(), density.to_array());
        for (k, index) in (first..SOURCE * SOURCE).take(LANES).enumerate() {
            let solid_angle = octahedral::cell_share(SOURCE, index % SOURCE, index / SOURCE) * densities[k];
            lights.push(Light {
                direction: directions.map(|c| c[k]),
                radiance: radiance.map(|c| c[k] * solid_angle),
                solid_angle,
            });
        }
    }
    lights
}

/// All levels for sixteen directions from number `first` on.
#[inline(always)]
fn filter<L: Lanes>(l: L, lights: &[Light], first: usize) -> [[[f32; LANES]; 3]; LEVELS] {
    let (u, v) = octahedral::positions(l, SIZE, first);
    let (normal, _) = octahedral::directions(l, u, v);
    let mut sums = [Vec3::zero(l); LEVELS];
    let mut totals = [l.zero(); LEVELS];
    for light in lights {
        let cosine = normal.dot(Vec3::splat(l, light.direction)).at_least(0.0);
        if !cosine.gt(l.zero()).any() {
            continue;
        }
        let square = (cosine.one_minus() * 0.5).at_least(0.0);
        let radiance = Vec3::splat(l, light.radiance);
        let mut power = square.sqrt();
        for level in 0..LEVELS {
            // n is 1/2, then doubles.
            power = match level {
                0 => power,
                1 => square,
                _ => power * power,
            };
            let kernel = power * cosine;
            sums[level] += radiance * kernel;
            totals[level] = totals[level] + kernel * light.solid_angle;
        }
    }
    // Division by what white light gives makes a uniform environment exact.
    let mut maps = [[[0.0; LANES]; 3]; LEVELS];
    for (map, (sum, total)) in maps.iter_mut().zip(sums.into_iter().zip(totals)) {
        *map = (sum * total.recip()).to_arrays();
    }
    maps
}

#[cfg(test)]
mod tests {
    use crate::light::{DistantRadiance, EnvironmentLight, PrefilteredEnvironment};
    use overcoat_core::jobs::Jobs;
    use overcoat_core::math::lanes::{Lanes, SimdLevel};
    use overcoat_core::math::vec3::{V3, Vec3};

    /// One half everywhere, and as much more or less as a direction is up or down.
    struct Slope;

    impl DistantRadiance for Slope {
        fn radiance<L: Lanes>(&self, l: L, direction: V3<L>) -> V3<L> {
            let up = direction.y / direction.length();
            Vec3::new(l.splat(0.5), up * 0.5 + 0.5, up * -0.5 + 0.5)
        }
    }

    /// The mean cosine over the kernel of a level.
    fn mean_cosine(level: usize) -> f64 {
        let (mut sum, mut all) = (0.0, 0.0);
        for k in 0..20_000 {
            let c = (f64::from(k) + 0.5) / 20_000.0;
            let square = (1.0 - c) / 2.0;
            let power = (1..level).fold(if level == 0 { square.sqrt() } else { square }, |p, _| p * p);
            let kernel = power * c;
            sum += kernel * c;
            all += kernel;
        }
        sum / all
    }

    #[test]
    fn levels_are_means_over_the_lobe_of_their_roughness() {
        let jobs = Jobs::new(1);
        let environment = PrefilteredEnvironment::from_radiance(&Slope, 6, &jobs, SimdLevel::best());
        let light = EnvironmentLight::new(&environment, 0.0, 2.0);
        // Between them it is a straight line.
        let root = 0.5_f64.sqrt();
        for (level, roughness) in [1.0, root, 0.5, 0.5 * root].into_iter().enumerate() {
            for direction in [[0.0, 1.0, 0.0], [0.6, -0.8, 0.0], [0.0, 0.0, -3.0]] {
                let seen: [f32; 3] = overcoat_core::dispatch!(SimdLevel::best(), l => {
                    let direction = Vec3::splat(l, direction);
                    light.charlie_radiance(l, direction, l.splat(roughness as f32)).lane(3)
                });
                let length = direction.iter().map(|c| c * c).sum::<f32>().sqrt();
                let up = f64::from(direction[1] / length) * mean_cosine(level);
                for (found, expected) in seen.into_iter().zip([1.0, 1.0 + up, 1.0 - up]) {
                    let off = (f64::from(found) - expected).abs();
                    assert!(off < 0.02, "{roughness} {direction:?}: {found}, {expected}");
                }
            }
        }
    }

    #[test]
    fn every_instruction_set_makes_the_same_maps() {
        let mut found: Option<Vec<u32>> = None;
        for level in SimdLevel::available() {
            let environment = PrefilteredEnvironment::studio();
            let maps = overcoat_core::dispatch!(level, l => super::CharlieMaps::new(l, &environment.chain));
            assert!(*found.get_or_insert_with(|| maps.texels.clone()) == maps.texels, "{level}");
        }
    }
}
