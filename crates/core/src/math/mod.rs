//! Arithmetic that gives the same bits everywhere: lanes, transcendental functions, small vectors.
//!
//! **Invariant:** no function here or anywhere in the crate calls a float function of the platform other than
//! `+ - * / sqrt floor abs` and conversions, which IEEE 754 rounds exactly; and, in set-up code, `min`, `max` and `clamp`
//! against constants of numbers that are neither NaN nor a zero whose sign counts.
//!
//! Every transcendental function exists over sixteen lanes, `exp(l, x)`, and for one `f32` in [`scalar`],
//! with the same operations and therefore the same bits; a NaN argument gives NaN. The errors stated bound
//! those found in comparison with double precision, in units in the last place (ULP) of the rounded result,
//! subnormal ones included: exponentials over every `f32`, logarithms and `acos` over every significand,
//! `sin` and `cos` over every 29th argument. The test that always runs takes every 1021st;
//! `errors_over_every_f32` takes all. [`double`] has what cameras need in `f64`, [`vec3`] vectors of three
//! lane numbers.

#[cfg(all(target_arch = "x86", not(target_feature = "sse2")))]
compile_error!("the x87 unit rounds twice, so pictures would differ from other machines: compile with SSE2");

pub mod double;
mod exp_log;
pub mod half;
pub mod lanes;
mod real;
mod trigonometry;
pub mod triple;
pub mod vec3;

#[cfg(test)]
mod tests;

use lanes::Lanes;

/// False if this thread's processor state flushes subnormal results or operands to zero, or rounds otherwise than to the
/// nearest number.
pub fn arithmetic_is_default() -> bool {
    let smallest = std::hint::black_box(f32::MIN_POSITIVE);
    let half = std::hint::black_box(smallest * 0.5);
    let one = std::hint::black_box(1.0_f32);
    let quarter_step = std::hint::black_box(f32::EPSILON * 0.25);
    // Upwards, the sum would be more than 1; downwards or towards zero, the difference would be less.
    let to_nearest = one + quarter_step == 1.0 && one - quarter_step == 1.0 && -one - quarter_step == -1.0;
    half > 0.0 && half * 2.0 == smallest && to_nearest
}

macro_rules! twins {
    ($($(#[$doc:meta])* $module:ident::$name:ident($($arg:ident),+);)*) => {
        $(
            $(#[$doc])*
            #[inline(always)]
            pub fn $name<L: Lanes>(_: L, $($arg: L::F),+) -> L::F {
                $module::$name($($arg),+)
            }
        )*

        /// The same functions for one number, with the bits of the lane functions.
        pub mod scalar {
            use super::*;
            $(
                $(#[$doc])*
                #[must_use]
                pub fn $name($($arg: f32),+) -> f32 {
                    $module::$name($($arg),+)
                }
            )*
        }
    };
}

twins! {
    /// e to the power x, all of f32: infinity above 88.73, subnormal results down to 0 below -103.97. Error
    /// below 0.98 ULP.
    exp_log::exp(x);
    /// e to the power x as transmittance and the tails of lobes need it: exactly 0 for x < -25, otherwise the
    /// bits of [`exp`] up to x = 87, where it stops to grow. Subnormal numbers, which cost more than the
    /// instruction set, never appear.
    exp_log::exp_transmittance(x);
    /// 2 to the power x, all of f32; exact for integers. Error below 0.85 ULP.
    exp_log::exp2(x);
    /// Natural logarithm. Minus infinity at 0, NaN below. Error below 0.72 ULP.
    exp_log::ln(x);
    /// Logarithm to base 2. Minus infinity at 0, NaN below. Exact for powers of two. Error below 1.35 ULP.
    exp_log::log2(x);
    /// x to the power y for x >= 0; NaN for x < 0. `pow(x, 0)` is 1 and `pow(1, y)` is 1; 0 and infinity are
    /// treated as the limits from inside, and -0 as 0. Error below 1.1 ULP in transfer functions (x in 0 to
    /// 1, y in 1/3 to 4), below 3 ULP anywhere (four million random arguments).
    exp_log::pow(x, y);
    /// Sine of x radians, |x| <= 8192. Beyond, some number in -1 to 1; NaN at infinity. Error below 2.25
    /// ULP.
    trigonometry::sin(x);
    /// Cosine of x radians, |x| <= 8192. Beyond, some number in -1 to 1; NaN at infinity. Error below 2.25
    /// ULP.
    trigonometry::cos(x);
    /// Arc cosine, 0 to pi. Arguments beyond -1 or 1, which rounding makes of cosines, count as -1 or 1.
    /// Error below 1.15 ULP.
    trigonometry::acos(x);
    /// Angle of the point (x, y), -pi to pi: 0 at the origin, with the sign of y; x = -0 counts as 0. NaN
    /// where both are infinite. Coordinates above 10^38 may overflow. Error below 1.8 ULP (four million
    /// random points).
    trigonometry::atan2(y, x);
}

/// Tangent of half an angle given in radians, as cameras use it of a field of view.
pub fn tan_half(angle: f64) -> f64 {
    double::tan(0.5 * angle)
}
