//! Sine, cosine, arc cosine and arc tangent. Polynomials as in `exp_log`.

use super::exp_log::nearest;
use super::real::Real;
use std::f32::consts::{FRAC_2_PI, FRAC_PI_2, FRAC_PI_4, PI};

/// pi / 2 in four parts; the first three have 11 bits, so that their products with a quadrant number below
/// 2^13 are exact.
const HALF_PI: [f32; 4] = [1.570_312_5, 4.837_513e-4, 7.549_533_6e-8, 2.563_344e-12];

/// pi / 4 in two parts; small multiples of the first are exact.
const QUARTER_PI: [f32; 2] = [0.78539753, 6.33795423e-07];

/// sin(r) for |r| <= pi / 4, 2^-28.
#[inline(always)]
fn sin_kernel<R: Real>(r: R) -> R {
    let z = r * r;
    r + r * z * z.polynomial([-0.166_666_55, 8.332_158e-3, -1.951_496e-4])
}

/// cos(r) for |r| <= pi / 4, 2^-33.
#[inline(always)]
fn cos_kernel<R: Real>(r: R) -> R {
    let z = r * r;
    // 1 - z / 2 is rounded; the second term of the sum takes its error back.
    let half = z * 0.5;
    let leading = half.constant(1.0) - half;
    let error = (half.constant(1.0) - leading) - half;
    leading + (error + z * z * z.polynomial([0.041_666_646, -1.388_731_3e-3, 2.443_278_6e-5]))
}

/// sin(x + quarter * pi / 2).
#[inline(always)]
fn sin_of_quadrant<R: Real>(x: R, quarter: i32) -> R {
    let (n, quadrant) = nearest(x * FRAC_2_PI);
    let r = x - n * HALF_PI[0] - n * HALF_PI[1] - n * HALF_PI[2] - n * HALF_PI[3];
    // Beyond the documented range the remainder means nothing; the result still lies in -1 to 1.
    let r = r.limited(-FRAC_PI_4 - 1e-3, FRAC_PI_4 + 1e-3);
    let quadrant = quadrant + quarter;
    let y = R::select(R::bit_set(quadrant, 0), cos_kernel(r), sin_kernel(r));
    R::select(R::bit_set(quadrant, 1), -y, y)
}

#[inline(always)]
pub(super) fn sin<R: Real>(x: R) -> R {
    sin_of_quadrant(x, 0)
}

#[inline(always)]
pub(super) fn cos<R: Real>(x: R) -> R {
    sin_of_quadrant(x, 1)
}

#[inline(always)]
pub(super) fn acos<R: Real>(x: R) -> R {
    /// Rounding error of pi / 2 as `f32`: the exact value less the rounded one.
    const HALF_PI_LOW: f32 = -4.371_139e-8;
    let magnitude = x.abs().limited(0.0, 1.0);
    let outer = x.constant(0.5).lt(magnitude);
    // acos(a) = 2 asin(sqrt((1 - a) / 2)) for a > 1/2, pi / 2 - asin(a) otherwise.
    let z = R::select(outer, (magnitude.constant(1.0) - magnitude) * 0.5, magnitude * magnitude);
    let s = R::select(outer, R::sqrt(z), magnitude);
    let tail = s * z * z.polynomial([0.166_667_52, 0.074_952_98, 0.045_470_346, 0.024_179_65, 0.042_166_09]);
    let negative = R::bit_set(x.bits(), 31);
    let half_pi = x.constant(FRAC_PI_2);
    // The tail adds the rounding error of the leading sum.
    let signed_s = R::select(negative, -s, s);
    let signed_tail = R::select(negative, -tail, tail);
    let leading = half_pi - signed_s;
    let lost = (half_pi - leading) - signed_s;
    let inner = leading + ((lost + HALF_PI_LOW) - signed_tail);
    let double = (s + tail) * 2.0;
    let outside = R::select(negative, (-double + HALF_PI_LOW * 2.0) + PI, double);
    R::select(outer, outside, inner)
}

#[inline(always)]
pub(super) fn atan2<R: Real>(y: R, x: R) -> R {
    let (zero, one) = (x.constant(0.0), x.constant(1.0));
    let (ax, ay) = (x.abs(), y.abs());
    let steep = ax.lt(ay);
    let short = R::select(steep, ax, ay);
    let long = R::select(steep, ay, ax);
    // Above 1/2, where the difference is exact: atan(q) = pi / 4 + atan((q - 1) / (q + 1)).
    let turned = (long * 0.5).lt(short);
    let numerator = R::select(turned, short - long, short);
    let denominator = R::select(turned, short + long, long);
    let q = numerator / R::select(long.eq(zero), one, denominator);
    let z = q * q;
    let c = [-0.333_333_28, 0.199_994_9, -0.142_720_7, 0.109_408_98, -0.079_837_255, 0.038_718_242];
    let tail = q * z * z.polynomial(c);
    // The angle is eighths * pi / 4 +- atan(q): the reflections at the diagonal and at the y axis in one sum.
    let eighths = R::select(turned, one, zero);
    let eighths = R::select(steep, eighths.constant(2.0) - eighths, eighths);
    let leftward = x.lt(zero);
    let eighths = R::select(leftward, eighths.constant(4.0) - eighths, eighths);
    let reflected = (steep & !leftward) | (leftward & !steep);
    let angle = q + tail;
    let angle = R::select(reflected, -angle, angle);
    (angle + eighths * QUARTER_PI[1] + eighths * QUARTER_PI[0]).with_sign_of(y)
}
