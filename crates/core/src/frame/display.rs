//! Linear radiance to 8-bit sRGB.

use super::{Frame, Meter, position, rows};
use crate::color::ToneCurve;
use crate::color::srgb::{SRGB8_TO_LINEAR, linear_to_srgb8_lanes};
use crate::dispatch_available;
use crate::each;
use crate::math::lanes::{Float, Int, LANES, Lanes, Mask, SimdLevel};
use std::slice::ChunksExact;

/// Conversion of linear light to a picture for a screen: exposure, tone mapping and background.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct DisplayOptions {
    /// Exposure compensation in stops (EV): light is multiplied by 2^exposure. A viewer's linear factor f is
    /// log2(f) stops. Not finite counts as 0, and the factor stays within 2^-64 to 2^64.
    pub exposure: f32,
    /// When [`Frame::metered_exposure`] is added to the exposure.
    pub meter: Meter,
    /// Tone curve.
    pub tone_curve: ToneCurve,
    /// Solid colour behind the picture, 8-bit sRGB. It is display light: exposure and tone curve leave it alone,
    /// and pixels without coverage have exactly this colour. Mixed in linear light, by [`Frame::transmittance`] where
    /// the frame has it: coloured glass tints it. `None` keeps alpha, which is the same for all colours.
    pub background: Option<[u8; 3]>,
    /// Instruction set. Never changes the picture.
    pub simd: SimdLevel,
}

impl Default for DisplayOptions {
    fn default() -> Self {
        Self {
            exposure: 0.0,
            meter: Meter::Never,
            tone_curve: ToneCurve::default(),
            background: None,
            simd: SimdLevel::best(),
        }
    }
}

impl DisplayOptions {
    /// The same with another [`DisplayOptions::exposure`].
    #[must_use]
    pub fn with_exposure(self, exposure: f32) -> Self {
        Self { exposure, ..self }
    }

    /// The same with another [`DisplayOptions::meter`].
    #[must_use]
    pub fn with_meter(self, meter: Meter) -> Self {
        Self { meter, ..self }
    }

    /// The same with another [`DisplayOptions::tone_curve`].
    #[must_use]
    pub fn with_tone_curve(self, tone_curve: ToneCurve) -> Self {
        Self { tone_curve, ..self }
    }

    /// The same with another [`DisplayOptions::background`].
    #[must_use]
    pub fn with_background(self, background: Option<[u8; 3]>) -> Self {
        Self { background, ..self }
    }

    /// The same with another [`DisplayOptions::simd`].
    #[must_use]
    pub fn with_simd(self, simd: SimdLevel) -> Self {
        Self { simd, ..self }
    }
}

impl DisplayOptions {
    /// The same with the metered exposure of a frame added, if [`DisplayOptions::meter`] says so, and never metered again.
    #[must_use]
    pub fn metered(&self, frame: &Frame) -> Self {
        let set = Self { meter: Meter::Never, ..self.clone() };
        let stops = match self.meter {
            Meter::Never => 0.0,
            Meter::Overexposed if DisplayImage::new(frame, &set).clipping(frame).is_overexposed() => {
                // From the exposure that is set, and never up.
                let stops = frame.metered_exposure() - self.exposure;
                if stops < 0.0 { stops } else { 0.0 }
            }
            Meter::Overexposed => 0.0,
            Meter::Always => frame.metered_exposure(),
        };
        Self { exposure: self.exposure + stops, ..set }
    }

    /// The same for pictures of a scene: only lights overexpose.
    #[must_use]
    pub fn for_lights(&self, has_lights: bool) -> Self {
        let spared = self.meter == Meter::Overexposed && !has_lights;
        Self { meter: if spared { Meter::Never } else { self.meter }, ..self.clone() }
    }
}

/// An 8-bit sRGB picture with straight alpha, row by row from the top. Where alpha is 0, so are the colours.
///
/// **Straight**: the colours are those of the surface, whatever part of the pixel it covers, as PNG and most decoders have
/// them; libraries that draw (Skia, Cairo, canvases) often want them multiplied by alpha. Alpha itself is linear: 128 of 255
/// is half of the pixel. With [`DisplayOptions::background`] all of it is 255.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DisplayImage {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// RGBA, `width * height` of them.
    pub pixels: Vec<[u8; 4]>,
}

impl DisplayImage {
    /// Un-premultiplies, exposes, applies the tone curve, puts the background behind, encodes as sRGB and rounds to
    /// 8 bits, in this order. A frame does not tell of lights: [`Meter::Overexposed`] is [`Meter::Never`] here, unless
    /// [`DisplayOptions::metered`] was asked.
    #[must_use]
    pub fn new(frame: &Frame, options: &DisplayOptions) -> Self {
        let mut pixels = vec![[0; 4]; frame.pixels.len()];
        let developer = Developer::new(&options.for_lights(false).metered(frame));
        // Whatever the level, the bits are the same.
        let level = if options.simd.is_available() { options.simd } else { SimdLevel::best() };
        dispatch_available!(level, l => developer.develop(l, &frame.pixels, &frame.transmittance, &mut pixels));
        Self { width: frame.width, height: frame.height, pixels }
    }

    /// The pixel in column x of row y, counted from the upper left corner: sRGB with straight alpha. `None` outside of the
    /// picture.
    #[must_use]
    pub fn pixel(&self, x: u32, y: u32) -> Option<[u8; 4]> {
        self.pixels.get(position(self.width, self.height, x, y)?).copied()
    }

    /// The rows from the top, `width` pixels each.
    pub fn rows(&self) -> ChunksExact<'_, [u8; 4]> {
        rows(&self.pixels, self.width)
    }

    /// All bytes, R G B A for each pixel, row by row from the top without gaps, as encoders and windows take them.
    #[must_use]
    pub fn as_bytes(&self) -> &[u8] {
        self.pixels.as_flattened()
    }

    /// True if no pixel lets anything through.
    #[must_use]
    pub fn is_opaque(&self) -> bool {
        self.pixels.iter().all(|p| p[3] == 255)
    }
}

/// Difference of two transmittances that is one step of 8 bits.
const LEAST_TINT: f32 = 1.0 / 255.0;

/// True if a transmittance is not that of grey glass.
pub fn is_tinted(&[r, g, b]: &[f32; 3]) -> bool {
    (r - g).abs() > LEAST_TINT || (g - b).abs() > LEAST_TINT || (b - r).abs() > LEAST_TINT
}

/// Per-pixel conversion of [`DisplayImage::new`], for pixels of any memory.
#[derive(Clone, Copy, Debug)]
pub struct Developer {
    /// Exposure as a linear factor.
    exposure: f32,
    tone_curve: ToneCurve,
    /// Linear.
    background: Option<[f32; 3]>,
    /// Output of pixels without coverage, 8-bit sRGB with straight alpha.
    nothing: [u8; 4],
}

impl Developer {
    /// The meter has been asked: [`DisplayOptions::metered`].
    pub fn new(options: &DisplayOptions) -> Self {
        let stops = if options.exposure.is_finite() { options.exposure.clamp(-64.0, 64.0) } else { 0.0 };
        Self {
            exposure: crate::math::scalar::exp2(stops),
            tone_curve: options.tone_curve,
            background: options.background.map(|c| c.map(|v| SRGB8_TO_LINEAR[usize::from(v)])),
            nothing: options.background.map_or([0; 4], |[r, g, b]| [r, g, b, 255]),
        }
    }

    /// Output of pixels without coverage, 8-bit sRGB with straight alpha.
    pub fn nothing(&self) -> [u8; 4] {
        self.nothing
    }

    /// Pixels as they are in a [`Frame`], with the transmittance of each or none at all, to as many of 8 bits. Their
    /// number is the smaller of the two.
    #[inline(never)]
    pub fn develop<L: Lanes>(
        &self,
        l: L,
        linear: &[[f32; 4]],
        transmittance: &[[f32; 3]],
        out: &mut [[u8; 4]],
    ) {
        l.run(
            #[inline(always)]
            || {
                let mut transmittance = transmittance.chunks(LANES);
                for (out, linear) in out.chunks_mut(LANES).zip(linear.chunks(LANES)) {
                    let behind = match (self.background, transmittance.next()) {
                        (None, _) => Behind::Nothing,
                        (Some(color), None) => Behind::Color(color),
                        (Some(color), Some(transmittance)) => Behind::Tinted(color, transmittance),
                    };
                    self.develop_lanes(l, behind, linear, out);
                }
            },
        );
    }

    /// Up to sixteen pixels.
    #[inline(always)]
    fn develop_lanes<L: Lanes>(&self, l: L, behind: Behind<'_>, linear: &[[f32; 4]], out: &mut [[u8; 4]]) {
        // Thumbnails are mostly empty.
        if matches!(behind, Behind::Nothing) && linear.iter().all(|p| p[3] == 0.0) {
            out.fill([0; 4]);
            return;
        }
        let [red, green, blue, alpha] = match linear.first_chunk() {
            Some(sixteen) => l.load_quads(sixteen),
            None => {
                let mut padded = [[0.0; 4]; LANES];
                padded.iter_mut().zip(linear).for_each(|(to, pixel)| *to = *pixel);
                l.load_quads(&padded)
            }
        };
        let alpha = alpha.saturate();
        let visible = alpha.gt(l.zero());
        // Radiance of the surface itself. Nearly invisible pixels may overflow to infinity, which the curve cuts off.
        let scale = visible.select(l.splat(self.exposure) / alpha, l.zero());
        let mut rgb = self.tone_curve.apply(l, [red * scale, green * scale, blue * scale]);
        let mut opacity = l.splat(1.0);
        match behind {
            Behind::Nothing => opacity = alpha,
            Behind::Color(background) => {
                for (color, behind) in rgb.iter_mut().zip(background) {
                    *color = *color * alpha + alpha.one_minus() * behind;
                }
            }
            Behind::Tinted(background, transmittance) => {
                for (k, (color, behind)) in rgb.iter_mut().zip(background).enumerate() {
                    let mut open = [0.0; LANES];
                    open.iter_mut().zip(transmittance).for_each(|(to, open)| *to = open[k]);
                    *color = *color * alpha + l.load(&open).saturate() * behind;
                }
            }
        }
        let [r, g, b] = each!(c in rgb => linear_to_srgb8_lanes(l, c));
        let a = (opacity * 255.0 + 0.5).to_int();
        let packed = r | g.shl(8) | b.shl(16) | a.shl(24);
        let packed = a.eq(l.splat_i(0)).select_i(a, packed).to_array();
        for (pixel, packed) in out.iter_mut().zip(packed) {
            *pixel = packed.to_le_bytes();
        }
    }
}

/// Background of pixels, in linear light.
#[derive(Clone, Copy)]
enum Behind<'a> {
    Nothing,
    Color([f32; 3]),
    /// A colour that pixels transmit in their own share of red, green and blue.
    Tinted([f32; 3], &'a [[f32; 3]]),
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(pixels: Vec<[f32; 4]>) -> Frame {
        Frame { width: pixels.len() as u32, height: 1, pixels, transmittance: Vec::new(), aovs: Vec::new() }
    }
    fn develop_one(pixel: [f32; 4], options: &DisplayOptions) -> [u8; 4] {
        DisplayImage::new(&frame(vec![pixel]), options).pixels[0]
    }
    fn plain() -> DisplayOptions {
        DisplayOptions { tone_curve: ToneCurve::None, ..DisplayOptions::default() }
    }

    #[test]
    fn pixels_are_found_where_they_are_and_nowhere_else() {
        let image = DisplayImage { width: 2, height: 2, pixels: (0..4).map(|k| [k; 4]).collect() };
        assert_eq!((image.pixel(1, 0), image.pixel(0, 1)), (Some([1; 4]), Some([2; 4])));
        assert_eq!((image.pixel(2, 0), image.pixel(0, 2)), (None, None));
        assert_eq!(image.rows().map(|row| row[1][0]).collect::<Vec<_>>(), [1, 3]);
        assert_eq!(image.as_bytes()[4..8], [1; 4]);
    }

    /// Every 8-bit value survives the way to linear light and back, opaque and half covered.
    #[test]
    fn all_8_bit_colours_come_back() {
        for v in 0..=255_u8 {
            let x = SRGB8_TO_LINEAR[usize::from(v)];
            assert_eq!(develop_one([x, x, x, 1.0], &plain()), [v, v, v, 255]);
            assert_eq!(develop_one([x * 0.5, x * 0.5, x * 0.5, 0.5], &plain()), [v, v, v, 128]);
        }
    }

    #[test]
    fn alpha_zero_writes_nothing() {
        // Light without coverage (a glow) cannot be shown with straight alpha, nor can coverage below 1/510.
        for pixel in [[0.0; 4], [1.0, 2.0, 3.0, 0.0], [1e-4, 1e-4, 1e-4, 1e-3], [-0.0; 4]] {
            assert_eq!(develop_one(pixel, &plain()), [0; 4]);
        }
        assert_eq!(develop_one([0.002, 0.0, 0.0, 0.002], &plain()), [255, 0, 0, 1]);
    }

    #[test]
    fn exposure_is_in_stops() {
        let x = SRGB8_TO_LINEAR[100];
        for stops in [-3.0, 1.0, 2.5] {
            let dimmed = x / crate::math::scalar::exp2(stops);
            let options = DisplayOptions { exposure: stops, ..plain() };
            assert_eq!(develop_one([dimmed, dimmed, dimmed, 1.0], &options), [100, 100, 100, 255]);
        }
    }

    #[test]
    fn a_background_keeps_its_colour_under_any_curve_and_exposure() {
        for &curve in ToneCurve::ALL {
            for background in [[255, 255, 255], [18, 52, 86], [0, 0, 0]] {
                let options = DisplayOptions {
                    exposure: 3.0,
                    meter: Meter::Never,
                    tone_curve: curve,
                    background: Some(background),
                    simd: SimdLevel::best(),
                };
                let [r, g, b] = background;
                assert_eq!(develop_one([0.0; 4], &options), [r, g, b, 255], "{curve}");
            }
        }
    }

    #[test]
    fn a_half_covered_pixel_mixes_light_not_bytes() {
        let options = DisplayOptions { background: Some([0, 0, 0]), ..plain() };
        // Half of white light is sRGB 188.
        assert_eq!(develop_one([0.5, 0.5, 0.5, 0.5], &options), [188, 188, 188, 255]);
    }

    #[test]
    fn coloured_glass_tints_the_background_and_nothing_else() {
        let red_glass =
            Frame { transmittance: vec![[1.0, 0.25, 0.0]], ..frame(vec![[0.1, 0.1, 0.1, 1.75 / 3.0]]) };
        let of =
            |background| DisplayImage::new(&red_glass, &DisplayOptions { background, ..plain() }).pixels[0];
        let code = |linear: f32| {
            (0..=255).min_by_key(|&v: &u8| ((SRGB8_TO_LINEAR[usize::from(v)] - linear).abs() * 1e6) as u32)
        };
        let white = of(Some([255; 3]));
        assert_eq!([Some(255), code(0.35), code(0.1)], [Some(white[0]), Some(white[1]), Some(white[2])]);
        assert_eq!(of(Some([0; 3]))[..3], [code(0.1).unwrap(); 3]);
        // Alone it is as opaque as it is dark.
        assert_eq!(of(None)[3], 149);
    }

    #[test]
    fn any_bits_give_a_picture() {
        let odd = [f32::NAN, f32::INFINITY, -1.0, 1e-40, 1e30];
        let all: Vec<[f32; 4]> = odd.iter().flat_map(|&a| odd.iter().map(move |&b| [a, b, a, b])).collect();
        for &curve in ToneCurve::ALL {
            let options = DisplayOptions { tone_curve: curve, ..plain() };
            let image = DisplayImage::new(&frame(all.clone()), &options);
            assert!(image.pixels.iter().all(|p| p[3] != 0 || *p == [0; 4]));
        }
    }

    #[test]
    fn the_instruction_set_and_the_length_of_the_row_change_nothing() {
        let pixels: Vec<[f32; 4]> = (0..203_u32)
            .map(|k| {
                let a = (k % 11) as f32 / 10.0;
                [k as f32 * 0.013 * a, (k * k % 97) as f32 * 0.02 * a, 0.3 * a, a]
            })
            .collect();
        for background in [None, Some([10, 200, 30])] {
            let develop = |pixels: &[[f32; 4]]| {
                let options = DisplayOptions { background, ..DisplayOptions::default() };
                let open = |(k, p): (usize, &[f32; 4])| [1.0 - p[3], (k % 7) as f32 / 6.0, 1.0];
                let mut frame = frame(pixels.to_vec());
                let plain = DisplayImage::new(&frame, &options).pixels;
                frame.transmittance = pixels.iter().enumerate().map(open).collect();
                [plain, DisplayImage::new(&frame, &options).pixels]
            };
            let expected = develop(&pixels);
            let short = develop(&pixels[..37]);
            assert!(short.iter().zip(&expected).all(|(short, long)| *short == long[..37]));
        }
    }
}
