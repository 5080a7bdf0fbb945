//! Differences of the numbers as they are stored.

use overcoat_image::decode::{DecodedPicture, ExrPlane, ExrSamples};

/// Difference between the stored numbers of two pictures of the same size. All channels count: alpha, colours below
/// alpha 0, and further channels of OpenEXR.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ExactDifference {
    /// Pixels with a channel that differs.
    pub pixels: u64,
    /// Largest difference of a channel: in codes of the expected picture (0 to 255 or 65535) or in linear light;
    /// infinite where a number stands against none (NaN).
    pub max_abs: f64,
    /// Pixels of the largest differences, counted by their size; see [`ExactDifference::pixels_above`].
    counts: Counts,
}

/// Differences by size. Codes have few sizes; of linear light, all that differ are kept.
#[derive(Clone, Debug, Default, PartialEq)]
struct Counts(Vec<(f64, u64)>);

impl ExactDifference {
    /// Compares two pictures of the same size.
    #[must_use]
    pub fn new(expected: &DecodedPicture, actual: &DecodedPicture) -> Self {
        // Different depths meet on the scale of the expected picture.
        let scale = f64::from(expected.kind.white()) / f64::from(actual.kind.white());
        let mut largest: Vec<f64> = expected
            .pixels
            .iter()
            .zip(&actual.pixels)
            .map(|(e, a)| (0..4).fold(0.0, |m, k| greater(m, difference(e[k], a[k], scale))))
            .collect();
        for plane in &expected.planes {
            if let Some(other) = actual.planes.iter().find(|other| other.name == plane.name) {
                add_plane(&mut largest, plane, other);
            }
        }
        largest.retain(|&d| d > 0.0);
        let pixels = largest.len() as u64;
        largest.sort_by(f64::total_cmp);
        let mut counts: Vec<(f64, u64)> = Vec::new();
        for d in largest {
            match counts.last_mut() {
                Some((last, count)) if *last == d => *count += 1,
                _ => counts.push((d, 1)),
            }
        }
        let max_abs = counts.last().map_or(0.0, |&(d, _)| d);
        Self { pixels, max_abs, counts: Counts(counts) }
    }

    /// Pixels with a channel that differs by more than this.
    #[must_use]
    pub fn pixels_above(&self, tolerance: f64) -> u64 {
        let Counts(counts) = &self.counts;
        let from = counts.partition_point(|&(d, _)| d <= tolerance);
        counts[from..].iter().map(|&(_, count)| count).sum()
    }

    /// The differing pixels in `bins` classes of equal width from 0 to [`Self::max_abs`], for a histogram.
    #[must_use]
    pub fn histogram(&self, bins: usize) -> Vec<u64> {
        let mut out = vec![0; bins.max(1)];
        for &(d, count) in &self.counts.0 {
            let place = if d.is_finite() && self.max_abs.is_finite() {
                (d / self.max_abs * out.len() as f64).ceil() as usize
            } else {
                out.len()
            };
            let last = out.len() - 1;
            out[place.saturating_sub(1).min(last)] += count;
        }
        out
    }
}

/// The names of planes that only one of two pictures has, expected ones first.
#[must_use]
pub fn unmatched_planes(expected: &DecodedPicture, actual: &DecodedPicture) -> (Vec<String>, Vec<String>) {
    let missing = |from: &DecodedPicture, of: &DecodedPicture| {
        let lacks = |plane: &&ExrPlane| !of.planes.iter().any(|p| p.name == plane.name);
        from.planes.iter().filter(lacks).map(|p| p.name.clone()).collect()
    };
    (missing(expected, actual), missing(actual, expected))
}

fn greater(a: f64, b: f64) -> f64 {
    if b > a { b } else { a }
}

/// Distance of two samples; two that are no numbers are alike, and so are 0 and -0.
fn difference(expected: f32, actual: f32, scale: f64) -> f64 {
    if expected == actual && scale == 1.0 || expected.is_nan() && actual.is_nan() {
        return 0.0;
    }
    let d = (f64::from(expected) - f64::from(actual) * scale).abs();
    if d.is_nan() { f64::INFINITY } else { d }
}

fn add_plane(largest: &mut [f64], expected: &ExrPlane, actual: &ExrPlane) {
    use ExrSamples::{Float, Half, Unsigned};
    let mut add = |k: usize, d: f64| {
        if let Some(sum) = largest.get_mut(k) {
            *sum = greater(*sum, d);
        }
    };
    match (&expected.samples, &actual.samples) {
        (Half(e) | Float(e), Half(a) | Float(a)) => {
            e.iter().zip(a).enumerate().for_each(|(k, (&e, &a))| add(k, difference(e, a, 1.0)));
        }
        (Unsigned(e), Unsigned(a)) => {
            e.iter().zip(a).enumerate().for_each(|(k, (&e, &a))| add(k, f64::from(e.abs_diff(a))));
        }
        (Unsigned(e), Half(a) | Float(a)) => {
            e.iter().zip(a).enumerate().for_each(|(k, (&e, &a))| add(k, (f64::from(e) - f64::from(a)).abs()));
        }
        (Half(e) | Float(e), Unsigned(a)) => {
            e.iter().zip(a).enumerate().for_each(|(k, (&e, &a))| add(k, (f64::from(e) - f64::from(a)).abs()));
        }
    }
}
