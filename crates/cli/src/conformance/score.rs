//! Score of a picture against the truth, by the rules of the pack. `pack/score.py` has them too, for everybody; a test
//! holds the two against each other.
//!
//! One test at three scales: pixels, blocks of 8 x 8 pixels and the whole picture, each channel for itself. At each,
//!
//! ```text
//! |sum of differences| <= z sqrt(sum of variances) + sum of footprints + sum of allowances
//! ```
//!
//! where z is the normal law's bound for all tests of a scale together, after Z. Šidák 1967, "Rectangular Confidence Regions for
//! the Means of Multivariate Normal Distributions". Noise falls with the scale, so that what no pixel shows, blocks do.

use super::pack::Planes32;
use overcoat_core::math::double::{exp, ln};
use overcoat_golden::metrics::MetricSettings;
use overcoat_golden::metrics::flip::LinearImage;
use overcoat_golden::metrics::flip_hdr::flip_hdr;
use serde::Serialize;
use std::f64::consts::{FRAC_1_PI, TAU};

/// Chance that noise alone is beyond the bound somewhere at a scale.
pub(super) const LEVEL: f64 = 0.001;

/// Share of a pixel, or of the mean of the picture where that is more, that is allowed for float precision, maps and triangles.
pub(super) const ALLOWANCE: f64 = 0.005;

/// Share of the values of pixels that may be beyond the bound: sums of walks have longer tails than the normal law.
pub(super) const OUTLIERS: f64 = 0.001;

/// Side of a block, and the fewest pixels of one that counts.
pub(super) const BLOCK: usize = 8;
pub(super) const BLOCK_PIXELS: usize = 16;

/// Scores of one picture. Shares, not percents.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(super) struct Score {
    /// True if all three scales are within their bounds.
    pub passes: bool,
    /// Sum of the differences over the sum of the truth.
    pub bias: f64,
    /// The same of differences without sign.
    pub error: f64,
    /// Part of that error that the variance of the truth alone explains.
    pub noise: f64,
    /// Root of the sum of their squares over that of the truth's.
    pub rmse: f64,
    /// Mean of HDR-FLIP.
    pub flip: f64,
    /// Mean of the differences in standard deviations, of which footprint and allowance are part.
    pub z_mean: f64,
    /// Mean of their squares: 1 or less of a renderer that is right.
    pub z_square: f64,
    /// Share of the values of pixels beyond their bound.
    pub pixels: f64,
    /// Share of the sums of blocks, one for each channel, beyond theirs.
    pub blocks: f64,
    /// The largest difference of the whole picture in its bound: beyond 1 it fails.
    pub whole: f64,
}

/// The normal law's two-sided bound for that many tests together.
pub(super) fn bound(tests: usize) -> f64 {
    // 1 - (1 - level)^(1/tests), without cancellation.
    let each = ln(1.0 - LEVEL) / tests.max(1) as f64;
    let chance = 0.5 * -(each + 0.5 * each * each);
    let (mut low, mut high) = (1.0, 20.0);
    for _ in 0..80 {
        let middle = 0.5 * (low + high);
        if tail(middle) > chance { low = middle } else { high = middle }
    }
    high
}

/// Chance of more than z, at least 1: Laplace's continued fraction of Mills' ratio.
fn tail(z: f64) -> f64 {
    let fraction = (1..=200).rev().fold(z, |below, k| z + f64::from(k) / below);
    exp(-0.5 * z * z) / (TAU.sqrt() * fraction)
}

/// Per-pixel tolerances.
pub(super) fn tolerance(truth: &Planes32) -> Vec<[f32; 3]> {
    let allowed = allowance(truth);
    let z = bound(3 * truth.scored());
    let of = |k: usize| {
        let bound = |c: usize| z * root(truth.variance[k][c]) + wide(truth.footprint[k][c]) + allowed(k, c);
        if truth.mask[k] { [0, 1, 2].map(|c| bound(c) as f32) } else { [0.0; 3] }
    };
    (0..truth.mask.len()).map(of).collect()
}

fn wide(x: f32) -> f64 {
    f64::from(x)
}

fn root(x: f32) -> f64 {
    wide(x).sqrt()
}

/// Allowance of a channel of a pixel.
fn allowance(truth: &Planes32) -> impl Fn(usize, usize) -> f64 {
    let count = truth.scored() as f64;
    let level = [0, 1, 2].map(|c| {
        let scored = truth.mean.iter().zip(&truth.mask).filter(|(_, mask)| **mask);
        scored.map(|(v, _)| wide(v[c])).sum::<f64>() / count
    });
    move |k, c| {
        let value = wide(truth.mean[k][c]);
        ALLOWANCE * if value > level[c] { value } else { level[c] }
    }
}

/// Sums over the pixels of a test.
#[derive(Clone, Copy, Default)]
struct Sums {
    pixels: usize,
    difference: [f64; 3],
    variance: [f64; 3],
    slack: [f64; 3],
}

impl Sums {
    fn add(&mut self, next: &Self) {
        self.pixels += next.pixels;
        for c in 0..3 {
            self.difference[c] += next.difference[c];
            self.variance[c] += next.variance[c];
            self.slack[c] += next.slack[c];
        }
    }

    /// Differences in their bounds.
    fn ratios(&self, z: f64) -> [f64; 3] {
        [0, 1, 2].map(|c| self.difference[c].abs() / (z * self.variance[c].sqrt() + self.slack[c]))
    }
}

/// Share of the values beyond their bound, and the largest of all.
fn beyond(tests: &[Sums]) -> [f64; 2] {
    let z = bound(3 * tests.len());
    let (mut count, mut worst) = (0, 0.0);
    for ratio in tests.iter().flat_map(|test| test.ratios(z)) {
        count += usize::from(ratio > 1.0);
        if ratio > worst {
            worst = ratio;
        }
    }
    [count as f64 / (3 * tests.len()).max(1) as f64, worst]
}

/// Scores a picture, of the size of the truth.
pub(super) fn score(truth: &Planes32, size: usize, picture: &[[f32; 3]]) -> Score {
    let allowed = allowance(truth);
    let across = size.div_ceil(BLOCK);
    let (mut pixels, mut blocks) = (Vec::new(), vec![Sums::default(); across * across]);
    let mut whole = Sums::default();
    let (mut shown, mut without_sign, mut noise, mut squares, mut energy) = (0.0, 0.0, 0.0, 0.0, 0.0);
    let (mut z_mean, mut z_square) = (0.0, 0.0);
    for k in (0..size * size).filter(|&k| truth.mask[k]) {
        let mut sums = Sums { pixels: 1, ..Sums::default() };
        for c in 0..3 {
            let value = wide(truth.mean[k][c]);
            let difference = wide(picture[k][c]) - value;
            let (footprint, free) = (wide(truth.footprint[k][c]), allowed(k, c));
            sums.difference[c] = difference;
            sums.variance[c] = wide(truth.variance[k][c]);
            sums.slack[c] = footprint + free;
            shown += value;
            without_sign += difference.abs();
            // The mean of what is normal, without its sign.
            noise += (sums.variance[c] * 2.0 * FRAC_1_PI).sqrt();
            squares += difference * difference;
            energy += value * value;
            let z = difference / (sums.variance[c] + footprint * footprint + free * free).sqrt();
            z_mean += z;
            z_square += z * z;
        }
        blocks[k / size / BLOCK * across + k % size / BLOCK].add(&sums);
        whole.add(&sums);
        pixels.push(sums);
    }
    blocks.retain(|block| block.pixels >= BLOCK_PIXELS);
    let values = (3 * pixels.len()) as f64;
    let ([pixels, _], [blocks, _], [_, whole_worst]) = (beyond(&pixels), beyond(&blocks), beyond(&[whole]));
    Score {
        passes: pixels <= OUTLIERS && blocks == 0.0 && whole_worst <= 1.0,
        bias: whole.difference.iter().sum::<f64>() / shown,
        error: without_sign / shown,
        noise: noise / shown,
        rmse: (squares / energy).sqrt(),
        flip: flip(truth, size, picture),
        z_mean: z_mean / values,
        z_square: z_square / values,
        pixels,
        blocks,
        whole: whole_worst,
    }
}

/// Mean over what is scored; elsewhere the picture is taken for right.
fn flip(truth: &Planes32, size: usize, picture: &[[f32; 3]]) -> f64 {
    let image = |pixels| LinearImage { width: size, height: size, pixels };
    let mixed = |k: usize| if truth.mask[k] { picture[k] } else { truth.mean[k] };
    let shown = image((0..size * size).map(mixed).collect());
    let map = flip_hdr(&image(truth.mean.clone()), &shown, &MetricSettings::default());
    let scored = map.iter().zip(&truth.mask).filter(|(_, mask)| **mask);
    scored.map(|(value, _)| wide(*value)).sum::<f64>() / truth.scored() as f64
}
