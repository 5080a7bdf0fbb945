//! Brightness of a picture: the metered exposure, and the clipped share.

use super::{DisplayImage, Frame};

/// Key of [`Frame::metered_exposure`]: luminance that one tenth of the object exceeds after metering. Below the onset
/// of compression of the tone curves.
const KEY: f32 = 0.7;

/// Largest magnitude of a metered exposure in stops.
const MOST_STOPS: f32 = 24.0;

/// Classes of the luminance histogram, 1/128 of an octave wide: the upper 16 bits of the numbers.
const CLASSES: usize = 1 << 15;

/// A pixel is white whose least channel is at least this of 255: overexposed colours keep a trace of their hue.
const WHITE: u8 = 240;

/// A pixel is black whose greatest channel is at most this of 255.
const BLACK: u8 = 3;

/// Alpha from which on a pixel counts as covered.
const COVERED: f32 = 0.99;

/// White and black pixels of a picture, by [`DisplayImage::clipping`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Clipping {
    /// Pixels that surfaces cover wholly; not those at edges, which show the background.
    pub covered: u64,
    /// Covered pixels that are white.
    pub white: u64,
    /// Covered pixels that are black.
    pub black: u64,
}

/// Occasion on which the exposure of a picture is metered ([`Frame::metered_exposure`]).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Meter {
    /// Never: the exposure is as it is set.
    #[default]
    Never,
    /// More than a third of the object is white at the exposure that is set ([`Clipping::is_overexposed`]), in a scene that
    /// brings light: then it is lowered. Renderers take it for [`Meter::Never`] in other scenes.
    Overexposed,
    /// Always.
    Always,
}

impl Clipping {
    /// True if more than a third of the covered pixels are white.
    #[must_use]
    pub fn is_overexposed(&self) -> bool {
        self.white.saturating_mul(3) > self.covered
    }

    /// Counts some pixels in, as they are in a frame and on a screen.
    pub fn count(&mut self, linear: &[[f32; 4]], display: &[[u8; 4]]) {
        let (mut covered, mut white, mut black) = (0_u32, 0_u32, 0_u32);
        // Rows of pictures are shorter than 2^32 pixels.
        for (light, &[r, g, b, _]) in linear.iter().zip(display) {
            let counts = u32::from(light[3] >= COVERED);
            covered += counts;
            white += counts & u32::from(r.min(g).min(b) >= WHITE);
            black += counts & u32::from(r.max(g).max(b) <= BLACK);
        }
        self.covered += u64::from(covered);
        self.white += u64::from(white);
        self.black += u64::from(black);
    }

    /// The pixels of both.
    #[must_use]
    pub fn plus(self, other: Self) -> Self {
        Self {
            covered: self.covered + other.covered,
            white: self.white + other.white,
            black: self.black + other.black,
        }
    }
}

impl DisplayImage {
    /// Count of the object's pixels that are white or black on the screen, where this is the picture of the frame
    /// `of`.
    #[must_use]
    pub fn clipping(&self, of: &Frame) -> Clipping {
        let mut clipping = Clipping::default();
        let width = (self.width as usize).max(1);
        for (linear, display) in of.pixels.chunks(width).zip(self.pixels.chunks(width)) {
            clipping.count(linear, display);
        }
        clipping
    }
}

impl Frame {
    /// The exposure in stops, for [`DisplayOptions::exposure`](super::DisplayOptions::exposure), at which one tenth of the
    /// object is brighter than 0.7: highlights keep their drawing, and neither a dark background nor black parts count.
    ///
    /// `log2(0.7 / L)`, within -24 to 24, where L is the 90th percentile of the luminance of the pixels that surfaces cover
    /// (Rec. 709, not premultiplied), each counted by its coverage in steps of 1/255, and rounded down to 1/128 of an octave.
    /// Counted in whole numbers, so that no order of summing changes it. 0 where nothing is covered, or L is 0.
    #[must_use]
    pub fn metered_exposure(&self) -> f32 {
        let mut counts = vec![0_u64; CLASSES];
        let mut all = 0;
        for [r, g, b, alpha] in &self.pixels {
            let weight = (alpha * 255.0 + 0.5) as u64;
            let luminance = (0.2126 * r + 0.7152 * g + 0.0722 * b) / alpha;
            // Neither NaN nor infinity counts.
            if weight > 0 && (0.0..=f32::MAX).contains(&luminance) {
                counts[(luminance.to_bits() >> 16) as usize] += weight;
                all += weight;
            }
        }
        let mut brighter = 0;
        let class = counts.iter().rposition(|count| {
            brighter += count;
            brighter * 10 > all
        });
        let luminance = f32::from_bits((class.unwrap_or(0) as u32) << 16);
        if luminance > 0.0 {
            crate::math::scalar::log2(KEY / luminance).clamp(-MOST_STOPS, MOST_STOPS)
        } else {
            0.0
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::DisplayOptions;

    fn frame(pixels: Vec<[f32; 4]>) -> Frame {
        Frame { width: pixels.len() as u32, height: 1, pixels, transmittance: Vec::new(), aovs: Vec::new() }
    }

    fn grey(value: f32, alpha: f32) -> [f32; 4] {
        [value * alpha, value * alpha, value * alpha, alpha]
    }

    #[test]
    fn the_brightest_tenth_is_left_out_and_so_is_what_is_empty() {
        let object = |value: f32| {
            let mut pixels = vec![grey(value, 1.0); 90];
            pixels.extend(vec![grey(1e6, 1.0); 9]);
            pixels.extend(vec![[0.0; 4]; 500]);
            frame(pixels).metered_exposure()
        };
        for stops in [-20.0_f32, -3.0, 0.0, 5.0] {
            let metered = object(KEY * crate::math::scalar::exp2(-stops));
            assert!((metered - stops).abs() < 0.02, "{metered} {stops}");
        }
        assert_eq!((object(1e-20), object(1e20)), (24.0, -24.0));
        // Coverage counts, and what it holds is not premultiplied.
        assert!((frame(vec![grey(0.35, 0.5); 4]).metered_exposure() - 1.0).abs() < 0.02);
        for nothing in [Vec::new(), vec![[0.0; 4]], vec![grey(0.0, 1.0)], vec![[f32::NAN; 4]]] {
            assert_eq!(frame(nothing).metered_exposure(), 0.0);
        }
    }

    #[test]
    fn white_and_black_are_counted_where_surfaces_are() {
        let white = DisplayOptions { background: Some([255; 3]), ..DisplayOptions::default() };
        let mut pixels = vec![grey(1e6, 1.0), grey(0.0, 1.0), grey(0.3, 1.0), grey(1e6, 0.9)];
        pixels.extend(vec![[0.0; 4]; 30]);
        let frame = frame(pixels);
        let clipping = DisplayImage::new(&frame, &white).clipping(&frame);
        assert_eq!(clipping, Clipping { covered: 3, white: 1, black: 1 });
        let plain = DisplayImage::new(&frame, &DisplayOptions::default()).clipping(&frame);
        assert_eq!(plain, clipping);
        assert_eq!(plain.plus(clipping).covered, 6);
    }
}
