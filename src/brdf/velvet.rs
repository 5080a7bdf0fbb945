//! Velvet after Ashikhmin and Premoze, and the split of roughness for anisotropic highlights.
//!
//! Velvet is a dense field of fibres: what is seen are the sides of fibres, so that the distribution of normals has its
//! peak at the horizon and only a constant about the surface normal.

use super::sheen::neubelt_denominator;
use crate::math;
use crate::math::lanes::{Float, Lanes};
use std::f32::consts::FRAC_1_PI;

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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::lanes::Scalar;

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

    #[test]
    fn along_the_normal_only_the_constant_is_left() {
        let l = Scalar;
        for s in [1.0_f32, 0.5, 1e-3] {
            let expected = std::f32::consts::FRAC_1_PI / (1.0 + 4.0 * s * s);
            for d in [
                distribution_velvet(l, l.splat(1.0), l.splat(s)),
                distribution_velvet_real_time(l, l.splat(1.0), l.splat(s)),
            ] {
                assert!((d.to_array()[0] - expected).abs() < 1e-6, "{s}");
            }
        }
    }
}
