//! Velvet after Ashikhmin and Premoze, and the split of roughness for anisotropic highlights.
//!
//! Velvet is a dense field of fibres: the sides of fibres are seen, so that the distribution of normals has its peak
//! at the horizon and only a constant about the surface normal.

use super::sheen::neubelt_denominator;
use super::table::{Table, TexelGrid};
use overcoat_core::math;
use overcoat_core::math::lanes::{Float, LANES, Lanes, SimdLevel};
use overcoat_core::math::vec3::Vec3;
use std::f32::consts::{FRAC_1_PI, PI};
use std::sync::OnceLock;

/// Weight of the lobe against the constant part.
const LOBE_WEIGHT: f32 = 4.0;

/// Least sin^2 of the offline form. Below, the exponential is 0 for every roughness to 1 in any case; the floor keeps
/// the quotient 0 / 0 from appearing at the surface normal.
const LEAST_SINE_SQUARED_OFFLINE: f32 = 1e-6;

/// Least sin^2 of the real-time form, 2^-7.
pub const LEAST_SINE_SQUARED: f32 = super::sheen::LEAST_SINE_SQUARED;

/// Velvet distribution, 1/sr: (1 + 4 exp(-cot^2 / s^2) / sin^4) / (pi (1 + 4 s^2)) for the angle of the half vector and
/// a roughness s in (0, 1].
///
/// Ashikhmin and Premoze, "Distribution-based BRDFs" (2007), normalised. The integral of D cos over
/// the hemisphere is 1. Exponentials below e^-25 count as 0.
#[inline(always)]
pub fn distribution_velvet<L: Lanes>(l: L, n_dot_h: L::F, roughness: L::F) -> L::F {
    let s2 = roughness * roughness;
    let cos2 = n_dot_h * n_dot_h;
    let sin2 = cos2.one_minus().at_least(LEAST_SINE_SQUARED_OFFLINE);
    let lobe = math::exp_transmittance(l, -(cos2 / (s2 * sin2))) * LOBE_WEIGHT / (sin2 * sin2);
    (lobe + 1.0) * FRAC_1_PI / (s2 * LOBE_WEIGHT + 1.0)
}

/// [`distribution_velvet`] as it is used in real time: sin^2 at least 2^-7, (4 exp(-cos^2 / (s^2 sin^2)) + sin^4) /
/// (pi (1 + 4 s^2) sin^4). The same function up to rounding: where the floor acts, the exponential is e^-127 or less.
#[inline(always)]
pub fn distribution_velvet_real_time<L: Lanes>(l: L, n_dot_h: L::F, roughness: L::F) -> L::F {
    let s2 = roughness * roughness;
    let cos2 = n_dot_h * n_dot_h;
    let sin2 = cos2.one_minus().at_least(LEAST_SINE_SQUARED);
    let sin4 = sin2 * sin2;
    let lobe = math::exp_transmittance(l, -(cos2 / (s2 * sin2))) * LOBE_WEIGHT;
    (lobe + sin4) / ((s2 * LOBE_WEIGHT + 1.0) * sin4) * FRAC_1_PI
}

/// The velvet lobe, 1/sr: D / (4 (N.L + N.V - N.L N.V)), without Fresnel and shadowing terms, as the authors propose.
/// The denominator is kept from falling below `least` (0: infinity where both cosines are 0).
#[inline(always)]
pub fn velvet_lobe<L: Lanes>(l: L, distribution: L::F, n_dot_l: L::F, n_dot_v: L::F, least: f32) -> L::F {
    distribution / neubelt_denominator(l, n_dot_l, n_dot_v).at_least(least)
}

/// Roughness along tangent and bitangent, alpha (1 + k) and alpha (1 - k), for alpha the square of the perceptual
/// roughness and k from -1 to 1; each at least `least` (0: none).
///
/// Kulla and Conty, "Revisiting Physically Based Shading at Imageworks" (2017), as Filament uses it; k above 0
/// stretches the highlight along the tangent.
#[inline(always)]
pub fn anisotropic_roughness<L: Lanes>(_: L, alpha: L::F, anisotropy: L::F, least: f32) -> [L::F; 2] {
    [(alpha * (anisotropy + 1.0)).at_least(least), (alpha * anisotropy.one_minus()).at_least(least)]
}

/// Least velvet roughness that [`VelvetAlbedo`] knows; smoother velvet is next to invisible.
pub const LEAST_ROUGHNESS: f32 = 0.05;

/// Least N.V of [`VelvetAlbedo`].
const LEAST_N_DOT_V: f32 = 1e-4;

/// Pre-integrated reflection of the velvet lobe, read at a cosine and a roughness of [`LEAST_ROUGHNESS`] to 1 with an
/// interpolation error below 0.005.
pub struct VelvetAlbedo {
    /// The directional albedo, 0.09 to 0.87. Parameters: sqrt(cosine), [`VelvetAlbedo::place`] of the roughness.
    albedo: Table<1>,
    /// x, y: mean direction of the reflected light's origin, towards the view's projection on the surface and along the
    /// normal. z: mean of the albedo over the cosine-weighted hemisphere, the same in all of a row.
    view: Table<3>,
}

impl VelvetAlbedo {
    /// Texels along each parameter.
    const SIZE: usize = 32;

    /// The tables, integrated when first asked for: some milliseconds.
    #[must_use]
    pub fn shared() -> &'static Self {
        static SHARED: OnceLock<VelvetAlbedo> = OnceLock::new();
        SHARED.get_or_init(Self::integrate)
    }

    /// Place of a roughness in the tables, 0 to 1.
    #[inline(always)]
    fn place<L: Lanes>(_: L, roughness: L::F) -> L::F {
        (roughness - LEAST_ROUGHNESS) / (1.0 - LEAST_ROUGHNESS)
    }

    /// The share of light from all sides that the lobe reflects towards a direction at this cosine, 0 to 1, and by
    /// reciprocity of light from that direction to all sides.
    #[inline(always)]
    pub fn albedo<L: Lanes>(&self, l: L, cosine: L::F, roughness: L::F) -> L::F {
        self.albedo.fetch(l, cosine.at_least(0.0).sqrt(), Self::place(l, roughness))[0]
    }

    /// Mean direction of the light that [`Self::albedo`] reflects, as components along the view's projection on the
    /// surface and along the normal (shorter than 1 by its spread: 0.4 to 0.7), and the mean of the albedo over the
    /// cosine-weighted hemisphere.
    #[inline(always)]
    pub fn view<L: Lanes>(&self, l: L, n_dot_v: L::F, roughness: L::F) -> ([L::F; 2], L::F) {
        let [x, z, mean] = self.view.fetch(l, n_dot_v.at_least(0.0).sqrt(), Self::place(l, roughness));
        ([x, z], mean)
    }

    fn integrate() -> Self {
        let last = (Self::SIZE - 1) as f32;
        let (mut albedo, mut view) = (Vec::new(), Vec::new());
        let light = LightSamples::new();
        for row in 0..Self::SIZE {
            let roughness = LEAST_ROUGHNESS + (1.0 - LEAST_ROUGHNESS) * (row as f32 / last);
            let texels: Vec<[f32; 3]> = (0..Self::SIZE)
                .map(|k| {
                    let root = k as f32 / last;
                    overcoat_core::dispatch!(SimdLevel::best(), l => moments(l, &light, root * root, roughness))
                })
                .collect();
            let row: Vec<f32> = texels.iter().map(|t| t[0]).collect();
            let mean = mean_albedo(&row);
            view.extend(texels.iter().map(|t| [t[1] / t[0], t[2] / t[0], mean]));
            albedo.extend(row.iter().map(|&a| [a]));
        }
        let (size, grid) = (Self::SIZE, TexelGrid::Corners);
        Self {
            albedo: Table::new(size, size, grid, &albedo).unwrap_or_else(|| Table::constant([0.0])),
            view: Table::new(size, size, grid, &view).unwrap_or_else(|| Table::constant([0.0; 3])),
        }
    }
}

/// Directions of light over half the hemisphere (the other half is its mirror image): cosines in two vectors, denser
/// towards the horizon, azimuths one after the other.
struct LightSamples {
    cosine: [[f32; LANES]; 2],
    /// Measure of a sample, of the hemisphere's 2 pi.
    weight: [[f32; LANES]; 2],
    /// Cosine and sine of the azimuth from the view.
    azimuth: Vec<[f32; 2]>,
}

impl LightSamples {
    const AZIMUTHS: usize = 24;

    fn new() -> Self {
        let n = (2 * LANES) as f32;
        let t = |half: usize, lane: usize| ((half * LANES + lane) as f32 + 0.5) / n;
        let grid =
            |f: &dyn Fn(f32) -> f32| std::array::from_fn(|half| std::array::from_fn(|lane| f(t(half, lane))));
        let per_sample = 2.0 * PI / (n * Self::AZIMUTHS as f32);
        let azimuth = (0..Self::AZIMUTHS).map(|k| {
            let phi = (k as f32 + 0.5) * PI / Self::AZIMUTHS as f32;
            [math::scalar::cos(phi), math::scalar::sin(phi)]
        });
        Self { cosine: grid(&|t| t * t), weight: grid(&|t| 2.0 * t * per_sample), azimuth: azimuth.collect() }
    }
}

/// The integral over light of the lobe times N.L, and of that times the light's direction: along the view's projection
/// and along the normal.
#[inline(always)]
fn moments<L: Lanes>(l: L, light: &LightSamples, n_dot_v: f32, roughness: f32) -> [f32; 3] {
    let n_dot_v = if n_dot_v > LEAST_N_DOT_V { n_dot_v } else { LEAST_N_DOT_V };
    let view = Vec3::splat(l, [(1.0 - n_dot_v * n_dot_v).sqrt(), 0.0, n_dot_v]);
    let roughness = l.splat(roughness);
    let mut sums = [l.zero(); 3];
    for half in 0..2 {
        let (cosine, weight) = (l.load(&light.cosine[half]), l.load(&light.weight[half]));
        let sine = (cosine * cosine).one_minus().sqrt();
        for &[c, s] in &light.azimuth {
            let direction = Vec3::new(sine * c, sine * s, cosine);
            let n_dot_h = (direction + view).normalize().z;
            let d = distribution_velvet_real_time(l, n_dot_h, roughness);
            let reflected = velvet_lobe(l, d, cosine, view.z, 0.0) * cosine * weight;
            sums[0] = sums[0] + reflected;
            sums[1] = sums[1] + reflected * direction.x;
            sums[2] = sums[2] + reflected * cosine;
        }
    }
    let mut out = [0.0; 3];
    for (out, sum) in out.iter_mut().zip(sums) {
        let lanes = sum.to_array();
        for lane in lanes {
            *out += lane;
        }
    }
    out
}

/// The integral of 2 u E(u) from 0 to 1 for E given at u = x^2, x in equal steps, and linear in x between.
fn mean_albedo(row: &[f32]) -> f32 {
    let last = (row.len() - 1) as f64;
    let primitive = |x: f64, power: i32| (0..power).fold(1.0, |p, _| p * x) / f64::from(power);
    let mut sum = 0.0;
    for (k, pair) in row.windows(2).enumerate() {
        let (a, b) = (k as f64 / last, (k + 1) as f64 / last);
        let slope = (f64::from(pair[1]) - f64::from(pair[0])) / (b - a);
        let start = f64::from(pair[0]) - slope * a;
        // 2 u du = 4 x^3 dx.
        sum += 4.0 * start * (primitive(b, 4) - primitive(a, 4));
        sum += 4.0 * slope * (primitive(b, 5) - primitive(a, 5));
    }
    sum as f32
}

#[cfg(test)]
mod tests {
    use super::*;
    use overcoat_core::math::lanes::Scalar;

    fn integral(distribution: impl Fn(f32) -> f32) -> f64 {
        let steps = 20_000;
        let sum: f64 =
            (0..steps).map(|k| f64::from(distribution(((k as f32 + 0.5) / steps as f32).sqrt()))).sum();
        sum * std::f64::consts::PI / f64::from(steps)
    }

    #[test]
    fn both_forms_are_normalised() {
        let l = Scalar;
        for s in [1.0_f32, 0.7, 0.3, 0.1, 0.03] {
            let offline = integral(|c| distribution_velvet(l, l.splat(c), l.splat(s)).to_array()[0]);
            let real_time =
                integral(|c| distribution_velvet_real_time(l, l.splat(c), l.splat(s)).to_array()[0]);
            assert!((offline - 1.0).abs() < 2e-3, "{s}: {offline}");
            assert!((real_time - 1.0).abs() < 2e-3, "{s}: {real_time}");
        }
    }

    /// Against many more samples: the tables hold what they promise, also between their texels.
    #[test]
    fn albedo_is_that_of_the_lobe() {
        let l = Scalar;
        let tables = VelvetAlbedo::shared();
        let (rings, sectors) = (400, 200);
        for s in [0.05_f32, 0.17, 0.33, 0.6, 1.0] {
            for cosine in [1e-4_f32, 0.013, 0.07, 0.31, 0.77, 1.0] {
                let view = [(1.0 - cosine * cosine).sqrt(), 0.0, cosine];
                let mut sum = 0.0;
                for ring in 0..rings / LANES {
                    let t: [f32; LANES] =
                        std::array::from_fn(|k| ((ring * LANES + k) as f32 + 0.5) / rings as f32);
                    for sector in 0..sectors {
                        let phi = (sector as f32 + 0.5) * PI / sectors as f32;
                        let nl = l.load(&t.map(|t| t * t));
                        let sine = (nl * nl).one_minus().sqrt();
                        let light =
                            Vec3::new(sine * math::scalar::cos(phi), sine * math::scalar::sin(phi), nl);
                        let half = (light + Vec3::splat(l, view)).normalize();
                        let d = distribution_velvet(l, half.z, l.splat(s));
                        let f = velvet_lobe(l, d, nl, l.splat(cosine), 0.0) * nl;
                        let weight = f64::from(4.0 * PI) / (rings * sectors) as f64;
                        let terms = f.to_array().into_iter().zip(t);
                        sum += terms.map(|(f, t)| f64::from(f * t)).sum::<f64>() * weight;
                    }
                }
                let found = f64::from(tables.albedo(l, l.splat(cosine), l.splat(s)).to_array()[0]);
                assert!((found - sum).abs() < 0.005, "{s} {cosine}: {found} not {sum}");
                assert!((0.09..0.87).contains(&found));
            }
        }
    }

    #[test]
    fn mean_albedo_integrates_lines_exactly() {
        assert!((mean_albedo(&[0.5; 8]) - 0.5).abs() < 1e-7);
        // E = x, x = sqrt(u): 4 / 5.
        let line: Vec<f32> = (0..9).map(|k| k as f32 / 8.0).collect();
        assert!((mean_albedo(&line) - 0.8).abs() < 1e-7);
    }

    #[test]
    fn along_the_normal_only_the_constant_is_left() {
        let l = Scalar;
        for s in [1.0_f32, 0.5, 1e-3] {
            let expected = FRAC_1_PI / (1.0 + 4.0 * s * s);
            for d in [
                distribution_velvet(l, l.splat(1.0), l.splat(s)),
                distribution_velvet_real_time(l, l.splat(1.0), l.splat(s)),
            ] {
                assert!((d.to_array()[0] - expected).abs() < 1e-6, "{s}");
            }
        }
    }
}
