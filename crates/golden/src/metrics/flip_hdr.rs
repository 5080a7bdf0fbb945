//! FLIP for linear light without an upper end.
//!
//! P. Andersson, J. Nilsson, P. Shirley, T. Akenine-Möller: *Visualizing Errors in Rendered High Dynamic Range Images*,
//! Eurographics Short Papers (2021): the pictures are compared at several exposures, one stop apart or less, from the one
//! that shows the brightest pixel of the expected picture to the one that shows its median, and each pixel keeps its
//! largest difference. The tone curve is the authors' default, K. Narkowicz's approximation of ACES.

use super::MetricSettings;
use super::flip::{Exposed, Filters, LinearImage, map};
use overcoat_core::dispatch_available;
use overcoat_core::math::double::{exp, ln};
use overcoat_core::math::lanes::{Float, SimdLevel};

/// Coefficients of `(a x^2 + b x) / (c x^2 + d x + e)`, with the exposure of 0.6 that the curve is made for.
const ACES: [f64; 5] = [0.6 * 0.6 * 2.51, 0.6 * 0.03, 0.6 * 0.6 * 2.43, 0.6 * 0.59, 0.14];

/// The display value that the brightest and the median pixel are brought to.
const TARGET: f64 = 0.85;

/// Exposures that are looked at; a wider range has wider steps.
const MOST_EXPOSURES: usize = 64;

/// The tone curve.
#[inline(always)]
pub(super) fn tone_map<F: Float>(x: F) -> F {
    let [a, b, c, d, e] = [ACES[0] as f32, ACES[1] as f32, ACES[2] as f32, ACES[3] as f32, ACES[4] as f32];
    // The square of more would overflow; the curve is flat long before.
    let x = x.clamp_to(-1e15, 1e15);
    (x * x * a + x * b) / (x * x * c + x * d + e)
}

/// The tone curve for one number.
#[cfg(test)]
pub(super) fn tone_map_value(x: f64) -> f64 {
    let [a, b, c, d, e] = ACES;
    (x * x * a + x * b) / (x * x * c + x * d + e)
}

/// HDR-FLIP of every pixel, 0 to 1. Both pictures have the same size.
#[must_use]
pub fn flip_hdr(expected: &LinearImage, actual: &LinearImage, settings: &MetricSettings) -> Vec<f32> {
    let filters = Filters::new(settings.pixels_per_degree);
    let mut out = vec![0.0; expected.pixels.len()];
    for stops in exposures(expected, settings.start_exposure, settings.stop_exposure) {
        let exposure = exp(stops * std::f64::consts::LN_2) as f32;
        let images = [expected, actual];
        let flip =
            dispatch_available!(SimdLevel::best(), l => map(l, &filters, images, Exposed::Aces(exposure)));
        for (most, value) in out.iter_mut().zip(flip) {
            if value > *most {
                *most = value;
            }
        }
    }
    out
}

/// The exposures in stops, from the one for the brightest pixel to the one for the median.
///
/// Where the median is black, which the authors' program does not allow for, the median of the pixels that are not
/// black takes its place; a black picture has exposure 0.
#[must_use]
pub fn exposures(expected: &LinearImage, start: Option<f32>, stop: Option<f32>) -> Vec<f64> {
    let mut luminances: Vec<f32> =
        expected.pixels.iter().map(|&[r, g, b]| 0.2126 * r + 0.7152 * g + 0.0722 * b).collect();
    luminances.sort_by(f32::total_cmp);
    let brightest = luminances.last().copied().unwrap_or(0.0);
    let mut median = luminances.get(luminances.len() / 2).copied().unwrap_or(0.0);
    if median <= 0.0 {
        let lit = &luminances[luminances.partition_point(|&v| v <= 0.0)..];
        median = lit.get(lit.len() / 2).copied().unwrap_or(0.0);
    }
    // Where the curve reaches the target: the larger root of a quadratic equation.
    let [a, b, c, d, e] = ACES;
    let (a, b, c) = (a - TARGET * c, b - TARGET * d, -TARGET * e);
    let half = -0.5 * b / a;
    let value = half + (half * half - c / a).sqrt();
    let stops = |luminance: f32| {
        if luminance > 0.0 { ln(value / f64::from(luminance)) / std::f64::consts::LN_2 } else { 0.0 }
    };
    let start = start.map_or_else(|| stops(brightest), f64::from);
    let stop = stop.map_or_else(|| stops(median), f64::from);
    if stop <= start {
        return vec![start];
    }
    let count = ((stop - start).ceil() as usize).clamp(2, MOST_EXPOSURES);
    (0..count).map(|k| start + k as f64 * (stop - start) / (count - 1) as f64).collect()
}
