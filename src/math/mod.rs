//! Arithmetic that gives the same bits everywhere: lanes, transcendental functions, small vectors.
//!
//! **Invariant:** no function here or anywhere in the crate calls a float function of the platform other than
//! `+ - * / sqrt floor abs` and conversions, which IEEE 754 rounds exactly.

pub mod lanes;

/// Tangent of half an angle given in radians, for 0 to pi.
pub(crate) fn tan_half(angle: f64) -> f64 {
    libm_free_tan(angle * 0.5)
}

/// A Taylor-free tangent by the continued fraction of Lambert, exact to about 1e-15 for 0 to pi / 2.
fn libm_free_tan(x: f64) -> f64 {
    let square = x * x;
    let mut tail = 0.0;
    for k in (1..=20).rev() {
        tail = square / (f64::from(2 * k + 1) - tail);
    }
    x / (1.0 - tail)
}
