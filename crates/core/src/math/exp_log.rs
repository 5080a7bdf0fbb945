//! Exponentials, logarithms and powers.
//!
//! The polynomials are minimax fits of relative error (Remez exchange at 50 digits, coefficients rounded to
//! `f32`); argument reduction after Cody and Waite, the double-length arithmetic of the power after Dekker.

use super::real::Real;
use std::f32::consts::{LN_2, LOG2_E};

/// Adding and subtracting this rounds to the nearest integer, for magnitudes below 2^22: the sum has no room
/// for fraction bits. The low bits of the sum are the integer.
pub(super) const ROUNDER: f32 = 12_582_912.0;

/// ln 2 in two parts; the first has 12 bits, so that its product with an exponent is exact.
const LN2: [f32; 2] = [0.693_115_23, 3.194_618_3e-5];

/// The nearest integer, as a float and as an integer.
#[inline(always)]
pub(super) fn nearest<R: Real>(x: R) -> (R, R::I) {
    let sum = x + ROUNDER;
    (sum - ROUNDER, sum.bits() - ROUNDER.to_bits() as i32)
}

/// `p * 2^n` for n in -252 to 254 with one rounding at most: each half of the exponent is a normal number.
#[inline(always)]
fn scaled<R: Real>(p: R, n: R::I) -> R {
    let half = R::shr(n, 1);
    let power = |n: R::I| R::from_bits(R::shl(n + 127, 23));
    p * power(half) * power(n - half)
}

/// `exp(x) = p * 2^n` with p in [sqrt(1/2), sqrt(2)], for |x| < 2^12.
#[inline(always)]
fn exp_parts<R: Real>(x: R) -> (R, R::I) {
    let (n, exponent) = nearest(x * LOG2_E);
    let r = x - n * LN2[0] - n * LN2[1];
    // exp(r) = 1 + r + r^2 q(r), 2^-28.3 for |r| <= ln(2) / 2.
    let q = r.polynomial([0.499_999_94, 0.166_665_21, 0.041_668_389, 8.368_717e-3, 1.381_464e-3]);
    (r + r * r * q + 1.0, exponent)
}

#[inline(always)]
pub(super) fn exp<R: Real>(x: R) -> R {
    // Below -104 everything rounds to 0, above 89 to infinity.
    let (p, n) = exp_parts(x.limited(-104.0, 89.0));
    scaled(p, n)
}

#[inline(always)]
pub(super) fn exp_transmittance<R: Real>(x: R) -> R {
    let (p, n) = exp_parts(x.limited(-25.0, 87.0));
    // No result is subnormal, so the exponent can be set in one step.
    let y = p * R::from_bits(R::shl(n + 127, 23));
    R::select(x.lt(x.constant(-25.0)), x.constant(0.0), y)
}

/// `2^r` for |r| <= 1/2: 1 + r ln 2 + r^2 q(r), 2^-28.3, with an exact leading product.
#[inline(always)]
fn exp2_fraction<R: Real>(r: R) -> R {
    let high = r.high_half();
    let q = r.polynomial([0.240_226_48, 0.055_503_62, 9.618_526e-3, 1.339_017_3e-3, 1.532_118_3e-4]);
    let small = r * r * q + (r - high) * LN_2 + high * LN2[1];
    small + high * LN2[0] + 1.0
}

#[inline(always)]
pub(super) fn exp2<R: Real>(x: R) -> R {
    let x = x.limited(-151.0, 129.0);
    let (n, exponent) = nearest(x);
    scaled(exp2_fraction(x - n), exponent)
}

/// `x = m * 2^n` with m in [sqrt(1/2), sqrt(2)), for finite x > 0, subnormal ones included.
#[inline(always)]
fn split_exponent<R: Real>(x: R) -> (R, R) {
    const SQRT_HALF: i32 = 0x3f35_04f3;
    let subnormal = x.lt(x.constant(f32::MIN_POSITIVE));
    let bits = R::select(subnormal, x * 8_388_608.0, x).bits();
    let n = R::shr(bits - SQRT_HALF, 23);
    let m = R::from_bits(bits - R::shl(n, 23));
    let n = R::int_to_float(n);
    (m, R::select(subnormal, n - 23.0, n))
}

/// `ln(1 + f) - f + f^2/2` for 1 + f in [sqrt(1/2), sqrt(2)): f^3 p(f), 2^-27.3 of the logarithm.
#[inline(always)]
fn ln_cubic<R: Real>(f: R) -> R {
    let c = [
        0.333_333_3,
        -0.250_008_26,
        0.200_012_36,
        -0.166_231_45,
        0.142_013_74,
        -0.131_620_06,
        0.127_653_96,
        -0.076_343_477,
    ];
    f * f * f * f.polynomial(c)
}

/// Replaces the results for zero, infinity, negative numbers and NaN by those of a logarithm.
#[inline(always)]
fn ln_specials<R: Real>(x: R, y: R) -> R {
    let zero = x.constant(0.0);
    let infinity = x.constant(f32::INFINITY);
    let y = R::select(x.eq(zero), -infinity, y);
    let ordinary = x.lt(infinity) & !x.lt(zero);
    let beyond = R::select(x.eq(infinity), infinity, x.constant(f32::NAN));
    R::select(ordinary, y, beyond)
}

#[inline(always)]
pub(super) fn ln<R: Real>(x: R) -> R {
    let (m, n) = split_exponent(x);
    let f = m - 1.0;
    // n ln 2 + f - f^2/2 with exact products (the square as h^2 + (f + h)(f - h)); what the sums lose is
    // added back with the small terms.
    let exponent = n * LN2[0];
    let sum = exponent + f;
    let lost = (exponent - sum) + f;
    let h = f.high_half();
    let half_square = h * h * 0.5;
    let total = sum - half_square;
    let lost = ((sum - total) - half_square) + lost;
    let rest = (f + h) * (f - h) * 0.5;
    ln_specials(x, (ln_cubic(f) - rest + n * LN2[1] + lost) + total)
}

#[inline(always)]
pub(super) fn log2<R: Real>(x: R) -> R {
    /// log2(e) less [`LOG2_E_HIGH`].
    const LOG2_E_LOW: f32 = 3.122_284e-4;
    /// The first 12 bits of log2(e).
    const LOG2_E_HIGH: f32 = 1.442_382_8;
    let (m, n) = split_exponent(x);
    let f = m - 1.0;
    // f * log2(e) with an exact leading product.
    let high = f.high_half();
    let low = (f - high) + (ln_cubic(f) - f * f * 0.5);
    ln_specials(x, low * LOG2_E + high * LOG2_E_LOW + high * LOG2_E_HIGH + n)
}

/// `log2(x)` of a finite x > 0 as an unevaluated sum with an error of about 2^-33 of it. The first part has
/// 12 bits at most where the exponent of x is 0, and 24 otherwise.
///
/// With s = (m - 1) / (m + 1): log2(m) = 2 / ln(2) * (s + s^3/3 + ...). The quotient is computed to twice the
/// length: its first 12 bits, and the remainder of the division by the rest.
#[inline(always)]
fn log2_long<R: Real>(x: R) -> (R, R) {
    /// 2 / ln(2), first 12 bits and the rest.
    const C: [f32; 2] = [2.885_742_2, -3.521_057_1e-4];
    let (m, n) = split_exponent(x);
    let f = m - 1.0;
    let d = m + 1.0;
    let reciprocal = d.constant(1.0) / d;
    let s_high = (f * reciprocal).high_half();
    let d_high = d.high_half();
    // m + 1 does not always fit 24 bits; this is what the first 12 lack.
    let d_low = m - (d_high - 1.0);
    let s_low = (f - s_high * d_high - s_high * d_low) * reciprocal;
    let s = s_high + s_low;
    let z = s * s;
    // (log2(m) - C s) / s^3, 2^-30 of log2(m).
    let cubic = z * s * z.polynomial([0.961_798_3, 0.576_752_66, 0.430_997_07]);
    let low = cubic + s_low * (C[0] + C[1]) + s_high * C[1];
    let high = s_high * C[0];
    let sum = n + high;
    // |n| is 0 or larger than |high|, so this is the exact error of the sum.
    (sum, high - (sum - n) + low)
}

#[inline(always)]
pub(super) fn pow<R: Real>(x: R, y: R) -> R {
    let (zero, one, infinity) = (x.constant(0.0), x.constant(1.0), x.constant(f32::INFINITY));
    let (high, low) = log2_long(x);
    // The smallest |log2(x)| above 0 is 8.6e-8: beyond 2^32 an exponent changes nothing, but would overflow.
    let exponent = y.limited(-4_294_967_296.0, 4_294_967_296.0);
    let log_sum = high + low;
    let log_high = log_sum.high_half();
    let log_low = (high - log_high) + low;
    let y_high = exponent.high_half();
    let y_low = exponent - y_high;
    let product_high = y_high * log_high;
    let product_low = y_low * log_high + exponent * log_low;
    let product = product_high + product_low;
    let limited = product.limited(-151.0, 129.0);
    let (n, integer) = nearest(limited);
    let fraction = (product_high - n) + product_low;
    // Where the limit was reached, the power of the limit is 0 or infinity already.
    let fraction = R::select(product.eq(limited), fraction, zero);
    let power = scaled(exp2_fraction(fraction), integer);

    let swapped = R::select(y.lt(zero), one / x.abs(), x.abs());
    let of_zero_or_infinity = R::select(y.eq(zero), one, swapped);
    let ordinary = zero.lt(x) & x.lt(infinity);
    let power = R::select(ordinary, power, of_zero_or_infinity);
    let nan = x.lt(zero) | !x.eq(x) | !y.eq(y);
    R::select(nan, x.constant(f32::NAN), power)
}
