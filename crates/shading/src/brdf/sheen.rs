//! Distributions and visibility of cloth: Charlie and Neubelt.

use overcoat_core::math;
use overcoat_core::math::lanes::{Float, Lanes};
use std::f32::consts::FRAC_1_PI;

/// Least sin^2 of the half vector's angle that engines put into [`distribution_charlie`]: 2^-7, so that the power
/// does not underflow in half precision.
pub const LEAST_SINE_SQUARED: f32 = 0.007_812_5;

/// Charlie distribution, 1/sr: (2 + 1/alpha) sin^(1/alpha) / (2 pi), with sin^2 = 1 - (N.H)^2 at least
/// `least_sine_squared`.
///
/// Estevez and Kulla, "Production Friendly Microfacet Sheen BRDF" (2017). alpha above 0; without a floor
/// (0) the function is normalised and 0 at N.H = 1. Finite for alpha from 1e-38.
#[inline(always)]
pub fn distribution_charlie<L: Lanes>(l: L, n_dot_h: L::F, alpha: L::F, least_sine_squared: f32) -> L::F {
    let inverse_alpha = alpha.recip();
    let sine_squared = (n_dot_h * n_dot_h).one_minus().at_least(least_sine_squared);
    (inverse_alpha + 2.0) * math::pow(l, sine_squared, inverse_alpha * 0.5) * (0.5 * FRAC_1_PI)
}

/// Denominator of [`visibility_neubelt`]: 4 (N.L + N.V - N.L N.V).
#[inline(always)]
pub fn neubelt_denominator<L: Lanes>(_: L, n_dot_l: L::F, n_dot_v: L::F) -> L::F {
    (n_dot_l + n_dot_v - n_dot_l * n_dot_v) * 4.0
}

/// Neubelt's visibility: the reciprocal of [`neubelt_denominator`], which is kept from falling below `least` (0: no
/// guard, and infinity where both cosines are 0).
///
/// Neubelt and Pettineo, "Crafting a Next-Gen Material Pipeline for The Order: 1886" (2013). It has the place of
/// G / (4 N.L N.V) and is smooth where that grows without bound.
#[inline(always)]
pub fn visibility_neubelt<L: Lanes>(l: L, n_dot_l: L::F, n_dot_v: L::F, least: f32) -> L::F {
    neubelt_denominator(l, n_dot_l, n_dot_v).at_least(least).recip()
}

#[cfg(test)]
mod tests {
    use super::*;
    use overcoat_core::math::lanes::Scalar;

    /// The integral of D N.H over the hemisphere is 1 without a floor; the floor adds light.
    #[test]
    fn charlie_is_normalised() {
        let l = Scalar;
        let steps = 4000;
        for alpha in [1.0_f32, 0.5, 0.2, 0.05] {
            let integral = |floor: f32| -> f64 {
                (0..steps)
                    .map(|k| {
                        let cosine = ((k as f32 + 0.5) / steps as f32).sqrt();
                        let d = distribution_charlie(l, l.splat(cosine), l.splat(alpha), floor);
                        f64::from(d.to_array()[0]) * std::f64::consts::PI / f64::from(steps)
                    })
                    .sum()
            };
            assert!((integral(0.0) - 1.0).abs() < 1e-3, "{alpha}: {}", integral(0.0));
            let floored = integral(LEAST_SINE_SQUARED);
            assert!(floored >= integral(0.0) && floored < 1.005, "{alpha}: {floored}");
        }
    }

    #[test]
    fn neubelt_is_reciprocal_and_guarded() {
        let l = Scalar;
        let v =
            |nl: f32, nv: f32, least| visibility_neubelt(l, l.splat(nl), l.splat(nv), least).to_array()[0];
        assert_eq!(v(0.3, 0.7, 0.0), v(0.7, 0.3, 0.0));
        assert_eq!(v(1.0, 0.2, 0.0), 0.25);
        assert_eq!(v(0.0, 0.0, 0.125), 8.0);
        assert_eq!(v(0.0, 0.0, 0.0), f32::INFINITY);
    }
}
