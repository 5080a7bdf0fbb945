//! Fresnel reflectance and its change at the boundary to a clear coat.

use crate::math::lanes::{Float, Lanes};

/// `x^4` as the square of a square.
#[inline(always)]
pub fn pow4<L: Lanes>(_: L, x: L::F) -> L::F {
    (x * x) * (x * x)
}

/// F0 of a surface under a coat of index 1.5, from its F0 in air: the cubic fit of Unity's
/// `ConvertF0ForAirInterfaceToF0ForClearCoat15` (core/CommonMaterial), 0 to 1; within 0.0037 of the exact
/// value from 0.04 upwards.
#[inline(always)]
pub fn f0_under_coat<L: Lanes>(_: L, f0: L::F) -> L::F {
    (f0 * ((f0 * -0.283_835 + 0.978_946) * f0 + 0.326_846) + -0.025_686_8).saturate()
}

/// As [`f0_under_coat`], by the quadratic fit that Unity uses on mobile and in its newest version
/// (`ConvertF0ForAirInterfaceToF0ForClearCoat15Fast`); within 0.0091.
#[inline(always)]
pub fn f0_under_coat_fast<L: Lanes>(_: L, f0: L::F) -> L::F {
    (f0 * (f0 * 0.526_868 + 0.529_324) - 0.048_225_6).saturate()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::lanes::Scalar;

    /// The fits against the exact change of interface: F0 to index of refraction, and its F0 against 1.5.
    #[test]
    fn fits_follow_the_change_of_interface() {
        let mut worst = [0.0_f32; 2];
        // From the coat's own F0 upwards; below, the exact value rises again, and the fits stay at 0.
        for k in 40..=999 {
            let f0 = k as f32 / 1000.0;
            let ior = (1.0 + f0.sqrt()) / (1.0 - f0.sqrt());
            let exact = {
                let r = (ior - 1.5) / (ior + 1.5);
                r * r
            };
            let x = Scalar.splat(f0);
            for (fit, worst) in
                [f0_under_coat(Scalar, x), f0_under_coat_fast(Scalar, x)].iter().zip(&mut worst)
            {
                let error = (fit.to_array()[0] - exact).abs();
                *worst = if error > *worst { error } else { *worst };
            }
        }
        assert!(worst[0] < 0.0037 && worst[1] < 0.0091, "{worst:?}");
    }
}
