//! Peak signal-to-noise ratio.

use overcoat_core::math::double::ln;

/// `10 log10(1 / mean squared error)` in dB over all channels of two pictures whose peak is 1; infinite for equal ones.
#[must_use]
pub fn psnr(expected: &[[f32; 3]], actual: &[[f32; 3]]) -> f64 {
    let (mut sum, mut count) = (0.0, 0_u64);
    for (e, a) in expected.iter().zip(actual) {
        for k in 0..3 {
            let d = f64::from(e[k]) - f64::from(a[k]);
            sum += d * d;
        }
        count += 3;
    }
    if sum == 0.0 { f64::INFINITY } else { 10.0 / std::f64::consts::LN_10 * ln(count as f64 / sum) }
}
