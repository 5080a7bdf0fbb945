//! Filtering an environment for specular reflection: one octahedral map for each roughness.
//!
//! What a level holds for the direction r is the radiance that a GGX surface of its roughness reflects when it is
//! looked at along its normal (N = V = R, Karis 2013, "Real shading in Unreal Engine 4", split sum):
//!
//! ```text
//!          integral L(l) D(h) (n.l) dl
//! level =  ---------------------------     with h halfway between n and l
//!            integral D(h) (n.l) dl
//! ```
//!
//! The integral is a sum over samples distributed by D(h), one fixed spiral for all texels, each of which reads a
//! reduced copy of the environment that covers as much of the sphere as the sample stands for (filtered importance
//! sampling, Krivanek and Colbert 2008). That makes a small bright sun a smooth lobe and not a spray of fireflies.

use super::DistantRadiance;
use super::chain::{Chain, IRRADIANCE, LEVELS, Levels, bilinear, seal};
use super::{harmonics, octahedral, texel};
use overcoat_core::dispatch;
use overcoat_core::jobs::Jobs;
use overcoat_core::math::lanes::{Float, Int, Lanes, SimdLevel};
use overcoat_core::math::vec3::{V3, Vec3};
use std::f64::consts::PI;

/// Samples of the filter at each roughness, and the solid angle of what a sample reads in units of the solid angle
/// that it stands for. The first level is not filtered. Sharp lobes need few samples, because a texel covers most of
/// them; wide lobes have few texels and can afford many, and many with overlap see a small sun evenly.
const SAMPLES: [(usize, f64); LEVELS] = [
    (0, 1.0),
    (64, 1.0),
    (96, 1.0),
    (192, 1.0),
    (256, 1.0),
    (256, 1.0),
    (512, 2.0),
    (512, 2.0),
    (512, 2.0),
    (512, 2.0),
    (2048, 4.0),
    (2048, 4.0),
    (2048, 4.0),
];

/// Radiance on an octahedral grid, as colour times solid angle and solid angle.
pub(crate) struct Grid {
    pub(crate) size: usize,
    pub(crate) values: Vec<[f32; 4]>,
}

impl Grid {
    /// Samples the radiance with `taps` x `taps` lookups a grid cell.
    pub(crate) fn paint(
        source: &(impl DistantRadiance + Sync),
        size: usize,
        taps: usize,
        jobs: &Jobs,
        level: SimdLevel,
    ) -> Self {
        let mut values = vec![[0.0; 4]; size * size];
        jobs.for_each_chunk_mut(&mut values, size * 4, |chunk, values| {
            if jobs.is_cancelled() {
                return;
            }
            dispatch!(level, l => paint_run(l, source, size, taps, chunk * size * 4, values));
        });
        seal(&mut values, size);
        Self { size, values }
    }

    /// Half the size: every second sample, each the mean of its 3 x 3 neighbours with the weights 1 2 1 and by
    /// solid angle, so that the mean over the sphere stays.
    fn reduced(&self, jobs: &Jobs) -> Self {
        let size = self.size / 2 + 1;
        let mut values = vec![[0.0; 4]; size * size];
        jobs.for_each_chunk_mut(&mut values, size, |row, values| {
            for (column, out) in values.iter_mut().enumerate() {
                for (dy, wy) in [(-1, 0.25), (0, 0.5), (1, 0.25)] {
                    for (dx, wx) in [(-1, 0.25), (0, 0.5), (1, 0.25)] {
                        let at = octahedral::wrap(self.size, 2 * column as isize + dx, 2 * row as isize + dy);
                        for c in 0..4 {
                            out[c] += wy * wx * self.values[at][c];
                        }
                    }
                }
            }
        });
        Self { size, values }
    }

    /// The colours, packed.
    fn texels(&self) -> impl Iterator<Item = u32> + '_ {
        self.values.iter().map(|v| texel::encode([v[0] / v[3], v[1] / v[3], v[2] / v[3]]))
    }
}

/// Fills consecutive samples from number `first` on.
#[inline(always)]
fn paint_run<L: Lanes>(
    l: L,
    source: &impl DistantRadiance,
    size: usize,
    taps: usize,
    first: usize,
    values: &mut [[f32; 4]],
) {
    let step = 2.0 / (size - 1) as f32;
    let share = 1.0 / (taps * taps) as f32;
    for (block, values) in values.chunks_mut(16).enumerate() {
        let (u, v) = octahedral::positions(l, size, first + block * 16);
        let mut sum = Vec3::zero(l);
        for tap in 0..taps * taps {
            let offset = |k: usize| ((k as f32 + 0.5) / taps as f32 - 0.5) * step;
            let (direction, _) = octahedral::directions(l, u + offset(tap % taps), v + offset(tap / taps));
            sum += source.radiance(l, direction);
        }
        let (_, solid_angle) = octahedral::directions(l, u, v);
        let weight = solid_angle * share;
        let rgb = (sum * weight).to_arrays();
        let solid_angle = solid_angle.to_array();
        for (k, value) in values.iter_mut().enumerate() {
            *value = [rgb[0][k], rgb[1][k], rgb[2][k], solid_angle[k]];
        }
    }
}

/// The reduced copies of an environment, each half the size of the one before: what rough levels are filtered from.
#[derive(Clone)]
pub(super) struct Pyramid {
    texels: Vec<u32>,
    /// Index of each copy's first texel, and its size.
    levels: Vec<(usize, usize)>,
}

/// One sample of the filter in the frame of the normal.
struct LobeSample {
    direction: [f32; 3],
    weight: f32,
    copy: usize,
}

/// The samples for a roughness, alpha = `perceptual_roughness`^2, and the sum of their weights.
///
/// The spiral of the golden angle, with the polar angle by the inverse of GGX's distribution of normals; only those
/// are generated whose reflection lies above the surface.
fn lobe(
    (count, footprint): (usize, f64),
    perceptual_roughness: f64,
    levels: &[(usize, usize)],
) -> (Vec<LobeSample>, f32) {
    let alpha2 = square(square(perceptual_roughness));
    // The share of the distribution whose reflections lie above the surface, cos^2 >= 1/2.
    let above = 1.0 / (1.0 + alpha2);
    // Cosine and sine of the golden angle, pi (3 - sqrt 5).
    let (turn_sin, turn_cos) = overcoat_core::math::double::sin_cos(PI * (3.0 - 5.0_f64.sqrt()));
    let (mut sin, mut cos) = (0.0_f64, 1.0_f64);
    let mut sum = 0.0;
    let samples = (0..count)
        .map(|k| {
            let u = (k as f64 + 0.5) / count as f64 * above;
            let cos2 = (1.0 - u) / (1.0 + (alpha2 - 1.0) * u);
            let n_dot_l = 2.0 * cos2 - 1.0;
            let across = 2.0 * (cos2 * (1.0 - cos2)).sqrt();
            let direction = [(across * cos) as f32, (across * sin) as f32, n_dot_l as f32];
            (cos, sin) = (cos * turn_cos - sin * turn_sin, sin * turn_cos + cos * turn_sin);
            let d = alpha2 / (PI * square(cos2 * (alpha2 - 1.0) + 1.0));
            let solid_angle = above / (count as f64 * d * 0.25);
            // The finest copy whose cells are no smaller than a sample's share, rounded in the logarithm.
            let copy = levels
                .iter()
                .position(|&(_, size)| {
                    let cell = 4.0 * PI / square((size - 1) as f64);
                    cell * 2.0 >= solid_angle * footprint
                })
                .unwrap_or(levels.len() - 1);
            let weight = n_dot_l as f32;
            sum += weight;
            LobeSample { direction, weight, copy }
        })
        .collect();
    (samples, sum)
}

/// `x * x`; the standard library's `powi` is not the same on every machine.
fn square(x: f64) -> f64 {
    x * x
}

/// Samples along a side of the reduced copy that irradiance is computed from. It sees degree 8 at most.
const IRRADIANCE_SOURCE: usize = 65;

/// A chain that has the mirror and the irradiance of the painted environment and no rough level, and what
/// [`Pyramid::filter_into`] filters those from.
pub(super) fn begin(mut grid: Grid, jobs: &Jobs, level: SimdLevel) -> (Chain, Pyramid) {
    let mut chain = Chain::dark(grid.size);
    let mut pyramid = Pyramid { texels: Vec::new(), levels: Vec::new() };
    let mut irradiance = None;
    loop {
        pyramid.levels.push((pyramid.texels.len(), grid.size));
        pyramid.texels.extend(grid.texels());
        if irradiance.is_none() && grid.size <= IRRADIANCE_SOURCE {
            irradiance = Some(harmonics::irradiance_over_pi(&grid, chain.size(IRRADIANCE), jobs, level));
        }
        if grid.size <= 3 {
            break;
        }
        grid = grid.reduced(jobs);
    }
    for (texel, rgb) in chain.map_mut(IRRADIANCE).iter_mut().zip(irradiance.into_iter().flatten()) {
        *texel = texel::encode(rgb);
    }
    let mirror = chain.map_mut(0);
    mirror.copy_from_slice(&pyramid.texels[..mirror.len()]);
    chain.present = Levels::of(0);
    (chain, pyramid)
}

impl Pyramid {
    /// Filters those levels of a chain that are not there yet. What is in a level does not depend on when.
    pub(super) fn filter_into(&self, chain: &mut Chain, levels: Levels, jobs: &Jobs, level: SimdLevel) {
        for k in levels.without(chain.present).iter() {
            let size = chain.size(k);
            let (samples, sum) = lobe(SAMPLES[k], Chain::perceptual_roughness(k), &self.levels);
            jobs.for_each_chunk_mut(chain.map_mut(k), 256, |chunk, texels| {
                if jobs.is_cancelled() {
                    return;
                }
                dispatch!(level, l => filter_run(l, self, &samples, sum, size, chunk * 256, texels));
            });
            seal(chain.map_mut(k), size);
        }
        chain.present = chain.present.with(levels);
    }
}

/// Filters consecutive texels from number `first` on.
#[inline(always)]
fn filter_run<L: Lanes>(
    l: L,
    pyramid: &Pyramid,
    samples: &[LobeSample],
    sum_of_weights: f32,
    size: usize,
    first: usize,
    texels: &mut [u32],
) {
    for (block, texels) in texels.chunks_mut(16).enumerate() {
        let (u, v) = octahedral::positions(l, size, first + block * 16);
        let (normal, _) = octahedral::directions(l, u, v);
        let (tangent, bitangent) = frame(l, normal);
        let mut sum = Vec3::zero(l);
        for sample in samples {
            let [x, y, z] = sample.direction;
            let direction = tangent * x + bitangent * y + normal * z;
            let (start, size) = pyramid.levels[sample.copy];
            let place = octahedral::encode(l, direction);
            let (start, size) = (l.splat_i(start as i32), l.splat_i(size as i32));
            let rgb = bilinear(l, &pyramid.texels, start, size, place);
            sum += rgb * sample.weight;
        }
        let rgb = (sum * (1.0 / sum_of_weights)).to_arrays();
        for (k, texel) in texels.iter_mut().enumerate() {
            *texel = texel::encode([rgb[0][k], rgb[1][k], rgb[2][k]]);
        }
    }
}

/// Two unit vectors that are orthogonal to a unit vector and to each other (Duff et al. 2017, "Building an
/// orthonormal basis, revisited").
#[inline(always)]
fn frame<L: Lanes>(l: L, n: V3<L>) -> (V3<L>, V3<L>) {
    let sign = (l.splat(1.0).bits() | (n.z.bits() & i32::MIN)).float_from_bits();
    let a = -(sign + n.z).recip();
    let b = n.x * n.y * a;
    (Vec3::new(sign * n.x * n.x * a + 1.0, sign * b, -(sign * n.x)), Vec3::new(b, sign + n.y * n.y * a, -n.y))
}
