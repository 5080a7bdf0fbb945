//! Fresnel reflectance and its change at the boundary to a clear coat.

use crate::math::lanes::{Float, Lanes};

/// `x^4` as the square of a square.
#[inline(always)]
pub fn pow4<L: Lanes>(_: L, x: L::F) -> L::F {
    (x * x) * (x * x)
}

/// F0 of a surface under a coat of index 1.5, from its F0 in air: the cubic fit of Unity's
/// `ConvertF0ForAirInterfaceToF0ForClearCoat15` (core/CommonMaterial), 0 to 1.
#[inline(always)]
pub fn f0_under_coat<L: Lanes>(_: L, f0: L::F) -> L::F {
    (f0 * ((f0 * -0.283_835 + 0.978_946) * f0 + 0.326_846) + -0.025_686_8).saturate()
}

/// As [`f0_under_coat`], by the quadratic fit that Unity uses on mobile and in its newest version
/// (`ConvertF0ForAirInterfaceToF0ForClearCoat15Fast`).
#[inline(always)]
pub fn f0_under_coat_fast<L: Lanes>(_: L, f0: L::F) -> L::F {
    (f0 * (f0 * 0.526_868 + 0.529_324) - 0.048_225_6).saturate()
}
