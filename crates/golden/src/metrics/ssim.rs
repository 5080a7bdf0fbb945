//! Structural similarity.
//!
//! Z. Wang, A. C. Bovik, H. R. Sheikh, E. P. Simoncelli: *Image quality assessment: from error visibility to structural
//! similarity*, IEEE Transactions on Image Processing 13 (2004): a Gaussian window of 11 x 11 pixels with a standard
//! deviation of 1.5, K1 = 0.01, K2 = 0.03. Computed for each colour channel and averaged, over the windows that lie within
//! the picture, as scikit-image's `structural_similarity` does with `gaussian_weights`. A picture that is narrower
//! than a window is continued beyond its edges by its edge pixels, and every pixel has a window.

use overcoat_core::math::double::exp;

const RADIUS: usize = 5;
const SIGMA: f64 = 1.5;
const C1: f64 = 0.01 * 0.01;
const C2: f64 = 0.03 * 0.03;

/// Mean structural similarity of two pictures of values 0 to 1, -1 to 1; 1 for equal ones.
#[must_use]
pub fn ssim(width: usize, height: usize, expected: &[[f32; 3]], actual: &[[f32; 3]]) -> f64 {
    let window = window();
    let mut sum = 0.0;
    for channel in 0..3 {
        let plane =
            |picture: &[[f32; 3]]| -> Vec<f64> { picture.iter().map(|p| f64::from(p[channel])).collect() };
        sum += channel_ssim(width, height, &plane(expected), &plane(actual), &window);
    }
    sum / 3.0
}

fn window() -> [f64; 2 * RADIUS + 1] {
    let mut weights = [0.0; 2 * RADIUS + 1];
    for (k, weight) in weights.iter_mut().enumerate() {
        let x = k as f64 - RADIUS as f64;
        *weight = exp(-x * x / (2.0 * SIGMA * SIGMA));
    }
    let sum: f64 = weights.iter().sum();
    weights.map(|w| w / sum)
}

fn channel_ssim(width: usize, height: usize, e: &[f64], a: &[f64], window: &[f64]) -> f64 {
    // Sums of e, a, e e, a a, e a in the window of every pixel: rows are blurred once and kept for the windows that
    // need them.
    let range = |side: usize| if side > 2 * RADIUS { RADIUS..side - RADIUS } else { 0..side };
    let (columns, rows) = (range(width), range(height));
    let blurred_row = |y: usize| -> Vec<[f64; 5]> {
        let (e, a) = (&e[y * width..][..width], &a[y * width..][..width]);
        let at = |x: usize| {
            let mut sums = [0.0; 5];
            for (k, weight) in window.iter().enumerate() {
                let x = (x + k).saturating_sub(RADIUS).min(width - 1);
                let (e, a) = (e[x], a[x]);
                let (we, wa) = (weight * e, weight * a);
                for (sum, value) in sums.iter_mut().zip([we, wa, we * e, wa * a, we * a]) {
                    *sum += value;
                }
            }
            sums
        };
        columns.clone().map(at).collect()
    };
    let mut cache: Vec<Option<Vec<[f64; 5]>>> = vec![None; height];
    let (mut total, mut count) = (0.0, 0_u64);
    for y in rows {
        let taps: Vec<usize> =
            (0..window.len()).map(|k| (y + k).saturating_sub(RADIUS).min(height - 1)).collect();
        for &tap in &taps {
            if cache[tap].is_none() {
                cache[tap] = Some(blurred_row(tap));
            }
        }
        if let Some(done) = taps[0].checked_sub(1) {
            cache[done] = None;
        }
        let rows: Vec<&[[f64; 5]]> = taps.iter().filter_map(|&tap| cache[tap].as_deref()).collect();
        for x in 0..columns.len() {
            let mut sums = [0.0; 5];
            for (row, weight) in rows.iter().zip(window) {
                for (sum, value) in sums.iter_mut().zip(row[x]) {
                    *sum += weight * value;
                }
            }
            let [me, ma, ee, aa, ea] = sums;
            let (var_e, var_a, covariance) = (ee - me * me, aa - ma * ma, ea - me * ma);
            total += (2.0 * me * ma + C1) * (2.0 * covariance + C2)
                / ((me * me + ma * ma + C1) * (var_e + var_a + C2));
            count += 1;
        }
    }
    total / count as f64
}
