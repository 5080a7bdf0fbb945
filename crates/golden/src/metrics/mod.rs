//! Measures of the difference between two pictures.
//!
//! | measure | equal | what it sees |
//! |---|---|---|
//! | differing pixels, largest difference | 0 | every channel, also alpha, hidden colours and further EXR channels, as stored |
//! | [PSNR](psnr) | infinite | the mean squared error of what a display shows, in dB |
//! | [SSIM](ssim) | 1 | structure in windows of 11 x 11 pixels |
//! | [FLIP](flip) | 0 | what a person sees who flips between the pictures at a stated distance |
//!
//! The last three see pictures as a display does: translucent pixels are laid over an opaque background first, display
//! codes in codes as browsers do, linear light in linear light. PSNR and SSIM of linear pictures compare what a display
//! shows of them without a tone curve (0 to 1, encoded as sRGB); FLIP has its own way with them, see [`flip_hdr`].
//!
//! All numbers have the same bits on every machine.

pub mod exact;
pub mod flip;
pub mod flip_hdr;
pub mod psnr;
pub mod ssim;

use super::GoldenError;
use exact::ExactDifference;
use overcoat_core::color::srgb::{SRGB8_TO_LINEAR, linear_to_srgb, srgb_to_linear};
use overcoat_image::decode::DecodedPicture;

/// Settings of the measures.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct MetricSettings {
    /// Pixels in one degree of the observer's field of view, for FLIP; greater than 0, at most 1000.
    pub pixels_per_degree: f32,
    /// Colour behind translucent pixels, sRGB.
    pub background: [u8; 3],
    /// Exposures in stops between which HDR-FLIP looks; from the expected picture where `None`.
    pub start_exposure: Option<f32>,
    /// See `start_exposure`.
    pub stop_exposure: Option<f32>,
}

impl Default for MetricSettings {
    fn default() -> Self {
        Self {
            pixels_per_degree: flip::DEFAULT_PIXELS_PER_DEGREE,
            background: [128; 3],
            start_exposure: None,
            stop_exposure: None,
        }
    }
}

impl MetricSettings {
    /// The same with another [`MetricSettings::pixels_per_degree`].
    #[must_use]
    pub fn with_pixels_per_degree(self, pixels_per_degree: f32) -> Self {
        Self { pixels_per_degree, ..self }
    }

    /// The same with another [`MetricSettings::background`].
    #[must_use]
    pub fn with_background(self, background: [u8; 3]) -> Self {
        Self { background, ..self }
    }

    /// The same with another [`MetricSettings::start_exposure`].
    #[must_use]
    pub fn with_start_exposure(self, start_exposure: Option<f32>) -> Self {
        Self { start_exposure, ..self }
    }

    /// The same with another [`MetricSettings::stop_exposure`].
    #[must_use]
    pub fn with_stop_exposure(self, stop_exposure: Option<f32>) -> Self {
        Self { stop_exposure, ..self }
    }
}

/// All measures of one pair of pictures of the same size.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Metrics {
    /// Difference of the stored numbers.
    pub exact: ExactDifference,
    /// Peak signal-to-noise ratio in dB; infinite for equal pictures.
    pub psnr: f64,
    /// Structural similarity, -1 to 1.
    pub ssim: f64,
    /// Mean of the FLIP map, 0 to 1.
    pub flip_mean: f64,
    /// Largest value of the FLIP map, 0 to 1.
    pub flip_max: f64,
}

/// The measures and the map of FLIP that they come from.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Measured {
    /// The numbers.
    pub metrics: Metrics,
    /// FLIP of every pixel, 0 to 1; empty for pictures that look alike in every bit.
    pub flip: Vec<f32>,
}

/// Measures the difference between two pictures.
///
/// # Errors
/// [`GoldenError::Size`] and [`GoldenError::Transfer`] if that has no meaning.
pub fn measure(
    expected: &DecodedPicture,
    actual: &DecodedPicture,
    settings: &MetricSettings,
) -> Result<Measured, GoldenError> {
    let sizes = [[expected.width, expected.height], [actual.width, actual.height]];
    if sizes[0] != sizes[1] {
        return Err(GoldenError::Size { expected: sizes[0], actual: sizes[1] });
    }
    if expected.kind.is_linear() != actual.kind.is_linear() {
        return Err(GoldenError::Transfer);
    }
    let exact = ExactDifference::new(expected, actual);
    let is_linear = expected.kind.is_linear();
    let seen = [expected, actual].map(|picture| Seen::new(picture, settings.background));
    if seen[0] == seen[1] {
        let metrics = Metrics { exact, psnr: f64::INFINITY, ssim: 1.0, flip_mean: 0.0, flip_max: 0.0 };
        return Ok(Measured { metrics, flip: Vec::new() });
    }
    let [width, height] = sizes[0].map(|side| side as usize);
    let flip = {
        let linear = [&seen[0], &seen[1]].map(|picture| flip::LinearImage {
            width,
            height,
            pixels: picture.linear(is_linear),
        });
        if is_linear {
            flip_hdr::flip_hdr(&linear[0], &linear[1], settings)
        } else {
            flip::flip(&linear[0], &linear[1], settings.pixels_per_degree)
        }
    };
    let [e, a] = seen.map(|picture| picture.encoded(is_linear));
    let metrics = Metrics {
        exact,
        psnr: psnr::psnr(&e, &a),
        ssim: ssim::ssim(width, height, &e, &a),
        flip_mean: flip::mean(&flip),
        flip_max: f64::from(flip.iter().copied().fold(0.0, |a: f32, b| if b > a { b } else { a })),
    };
    Ok(Measured { metrics, flip })
}

/// A picture as it is seen: opaque, white is 1, finite.
#[derive(PartialEq)]
struct Seen(Vec<[f32; 3]>);

impl Seen {
    fn new(picture: &DecodedPicture, background: [u8; 3]) -> Self {
        let scale = 1.0 / picture.kind.white();
        let linear = picture.kind.is_linear();
        let behind = background
            .map(|code| if linear { SRGB8_TO_LINEAR[usize::from(code)] } else { f32::from(code) / 255.0 });
        let pixels = picture.pixels.iter().map(|&[r, g, b, a]| {
            let alpha = finite(a * scale);
            let rest = 1.0 - alpha;
            // Linear pictures are premultiplied.
            let weight = if linear { 1.0 } else { alpha };
            let colour = [r, g, b].map(|v| finite(if linear { v } else { v * scale }) * weight);
            if rest == 0.0 { colour } else { [0, 1, 2].map(|k| colour[k] + rest * behind[k]) }
        });
        Self(pixels.collect())
    }

    fn linear(&self, is_linear: bool) -> Vec<[f32; 3]> {
        if is_linear {
            return self.0.clone();
        }
        self.0.iter().map(|p| p.map(decode)).collect()
    }

    fn encoded(self, is_linear: bool) -> Vec<[f32; 3]> {
        if !is_linear {
            return self.0;
        }
        self.0.into_iter().map(|p| p.map(|v| linear_to_srgb(v.clamp(0.0, 1.0)))).collect()
    }
}

/// sRGB to linear; 8-bit codes come from the table, which holds the same numbers and is fast.
fn decode(encoded: f32) -> f32 {
    let code = encoded * 255.0;
    if (0.0..=255.0).contains(&code) && code == code.floor() {
        SRGB8_TO_LINEAR[code as usize]
    } else {
        srgb_to_linear(encoded)
    }
}

/// Finite stand-ins for numbers that are not finite: black for NaN, the largest half float of its sign for infinity.
fn finite(v: f32) -> f32 {
    const MOST: f32 = 65504.0;
    if v.is_nan() {
        0.0
    } else if v.is_infinite() {
        if v > 0.0 { MOST } else { -MOST }
    } else {
        v
    }
}

#[cfg(test)]
mod tests;
