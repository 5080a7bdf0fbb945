//! Elementary functions in double precision, for cameras, tables and other set-up work that happens once.

use std::f64::consts::FRAC_2_PI;

/// pi / 2 in three parts; the first two have 33 bits, so that products with up to 2^20 are exact.
const HALF_PI: [f64; 3] = [1.570_796_326_734_125_6, 6.077_100_506_303_966e-11, 2.022_266_248_795_950_6e-21];

/// As [`super::exp_log::ROUNDER`], for f64.
const ROUNDER: f64 = 6_755_399_441_055_744.0;

/// Sine and cosine of an angle in radians, |x| <= 10^6. Error below 1 ULP; not finite beyond infinity and for
/// NaN.
#[must_use]
pub fn sin_cos(x: f64) -> (f64, f64) {
    let sum = x * FRAC_2_PI + ROUNDER;
    let n = sum - ROUNDER;
    let r = x - n * HALF_PI[0] - n * HALF_PI[1] - n * HALF_PI[2];
    let (s, c) = (sin_kernel(r), cos_kernel(r));
    match sum.to_bits() & 3 {
        0 => (s, c),
        1 => (c, -s),
        2 => (-s, -c),
        _ => (-c, s),
    }
}

/// Sine of an angle in radians, see [`sin_cos`].
#[must_use]
pub fn sin(x: f64) -> f64 {
    sin_cos(x).0
}

/// Cosine of an angle in radians, see [`sin_cos`].
#[must_use]
pub fn cos(x: f64) -> f64 {
    sin_cos(x).1
}

/// Tangent of an angle in radians, |x| <= 10^6. Error below 2.5 ULP.
#[must_use]
pub fn tan(x: f64) -> f64 {
    let (s, c) = sin_cos(x);
    s / c
}

/// The angle of the point (x, y), in -pi to pi, for finite arguments; 0 at the origin, and the sign is that
/// of y. Absolute error below 1e-15.
#[must_use]
pub fn atan2(y: f64, x: f64) -> f64 {
    let magnitude = if x.abs() > y.abs() { x.abs() } else { y.abs() };
    if magnitude == 0.0 {
        return y;
    }
    // The angle to 24 bits, then one correction by the small angle between the point and that direction.
    let (y, x) = (y / magnitude, x / magnitude);
    let coarse = f64::from(super::scalar::atan2(y as f32, x as f32));
    let (s, c) = sin_cos(coarse);
    let t = (y * c - x * s) / (x * c + y * s);
    coarse + (t - t * t * t / 3.0)
}

/// sin(r) for |r| <= pi / 4, 2^-58.
fn sin_kernel(r: f64) -> f64 {
    let z = r * r;
    let c = [
        -0.166_666_666_666_666_305,
        8.333_333_333_322_061_66e-3,
        -1.984_126_982_954_226_2e-4,
        2.755_731_360_441_969e-6,
        -2.505_074_502_232_83e-8,
        1.589_606_666_068_530_1e-10,
    ];
    r + r * z * c.iter().rev().fold(0.0, |sum, c| sum * z + c)
}

/// cos(r) for |r| <= pi / 4, 2^-64.
fn cos_kernel(r: f64) -> f64 {
    let z = r * r;
    let c = [
        0.041_666_666_666_666_592_5,
        -1.388_888_888_887_297_6e-3,
        2.480_158_728_879_978_6e-5,
        -2.755_731_416_393_286e-7,
        2.087_569_870_294_867_8e-9,
        -1.135_842_324_191_974_6e-11,
    ];
    let leading = 1.0 - 0.5 * z;
    let error = (1.0 - leading) - 0.5 * z;
    leading + (error + z * z * c.iter().rev().fold(0.0, |sum, c| sum * z + c))
}

/// ln 2 in two parts; the first has 32 bits, so that its product with an exponent is exact.
const LN2: [f64; 2] = [0.693_147_180_369_123_816_490, 1.908_214_929_270_587_700_02e-10];

/// e to the power x. 0 below -708 (where numbers become subnormal), infinity above 709.78. Relative error below
/// 2.5e-16.
#[must_use]
pub fn exp(x: f64) -> f64 {
    if x < -708.0 {
        return 0.0;
    }
    if x > 709.782_712_893_384 {
        return f64::INFINITY;
    }
    let sum = x * std::f64::consts::LOG2_E + ROUNDER;
    let n = sum - ROUNDER;
    let r = (x - n * LN2[0]) - n * LN2[1];
    // Taylor's series for |r| <= ln(2) / 2: the first term left out is 3e-18.
    let tail = (2..=14).rev().fold(0.0, |sum, k| (sum + 1.0) * r / f64::from(k));
    let exponent = (sum.to_bits() as i32) - (ROUNDER.to_bits() as i32);
    // In two steps, because 2^1024 is no number.
    let power = |n: i32| f64::from_bits(((n + 1023) as u64) << 52);
    (1.0 + (r + r * tail)) * power(exponent / 2) * power(exponent - exponent / 2)
}

/// Natural logarithm of a normal number; minus infinity at 0 and below it NaN. Absolute error below 2.5e-16 (1 +
/// |ln x|).
#[must_use]
pub fn ln(x: f64) -> f64 {
    if x <= 0.0 {
        return if x == 0.0 { f64::NEG_INFINITY } else { f64::NAN };
    }
    let bits = x.to_bits();
    // x = m 2^n with m in sqrt(1/2) to sqrt(2).
    const SQRT_HALF: u64 = 0x3fe6_a09e_667f_3bcd;
    let n = (bits.wrapping_sub(SQRT_HALF) as i64) >> 52;
    let m = f64::from_bits(bits.wrapping_sub((n << 52) as u64));
    let s = (m - 1.0) / (m + 1.0);
    let z = s * s;
    // 2 artanh(s), |s| <= 0.172: the first term left out is 1e-19.
    let tail = (1..=11).rev().fold(0.0, |sum, k| (sum + 1.0 / f64::from(2 * k + 1)) * z);
    let n = n as f64;
    n * LN2[0] + (2.0 * s + (2.0 * s * tail + n * LN2[1]))
}

/// x to the power y for x >= 0 and y > 0. Relative error below 3e-16 (1 + y (1 + |ln x|)).
#[must_use]
pub fn pow(x: f64, y: f64) -> f64 {
    exp(y * ln(x))
}

/// Natural logarithm of the gamma function for x >= 1. Absolute error below 1e-14 (1 + x ln x).
#[must_use]
pub fn ln_gamma(x: f64) -> f64 {
    // Stirling's series from 10 on: the first term left out is 3e-17. Below, by gamma(x + 1) = x gamma(x).
    let (mut x, mut product) = (x, 1.0);
    while x < 10.0 {
        product *= x;
        x += 1.0;
    }
    const HALF_LN_TAU: f64 = 0.918_938_533_204_672_741_78;
    let (r, z) = (1.0 / x, 1.0 / (x * x));
    let series = [
        1.0 / 12.0,
        -1.0 / 360.0,
        1.0 / 1260.0,
        -1.0 / 1680.0,
        1.0 / 1188.0,
        -691.0 / 360_360.0,
        1.0 / 156.0,
    ];
    let tail = r * series.iter().rev().fold(0.0, |sum, c| sum * z + c);
    (x - 0.5) * ln(x) - x + HALF_LN_TAU + tail - ln(product)
}
