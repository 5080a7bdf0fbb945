//! GIF (Graphics Interchange Format, version 89a, CompuServe 1990): a palette of its own for each frame, and no transparency.

use super::{MovieFormat, MovieFrame};
use crate::output::OutputError;
use crate::output::jpeg::over_white;
use crate::output::palette::Palette;
use overcoat_core::frame::DisplayImage;

/// Shortest time of a frame in hundredths of a second: browsers show frames of less for a tenth of a second.
const SHORTEST: u32 = 2;

/// Side of the matrix by which colours are dithered.
const SIDE: usize = 4;

/// Ordered dither matrix of Bayer (1973), each number below 16 once.
const BAYER: [[i32; SIDE]; SIDE] = [[0, 8, 2, 10], [12, 4, 14, 6], [3, 11, 1, 9], [15, 7, 13, 5]];

fn wrong(reason: &str) -> OutputError {
    OutputError::Movie { format: MovieFormat::Gif, reason: reason.to_owned() }
}

/// The image block of a frame: descriptor, palette and indices. Translucent pixels lie over white.
pub(super) fn encode_frame(image: &DisplayImage) -> Result<Vec<u8>, OutputError> {
    let size = |v: u32| u16::try_from(v).ok().filter(|&v| v > 0).map(u16::to_le_bytes);
    let Some((width, height)) = size(image.width).zip(size(image.height)) else {
        return Err(wrong("sides are 1 to 65535 pixels"));
    };
    let columns = image.width as usize;
    let pixels = image.pixels.iter().enumerate();
    let colors: Vec<[u8; 3]> =
        pixels.map(|(k, &pixel)| dithered(over_white(pixel), k % columns, k / columns)).collect();
    let palette = Palette::new(colors.iter().copied());
    // Codes begin with two bits at least.
    let bits = palette.registers.len().next_power_of_two().trailing_zeros().max(2);
    let indices: Vec<u8> = colors.iter().map(|&color| palette.register(color).unwrap_or_default()).collect();

    let mut out = vec![0x2c, 0, 0, 0, 0];
    out.extend(width);
    out.extend(height);
    // A palette of its own, of 2 to the power of `bits` colours.
    out.push(0x80 | (bits - 1) as u8);
    for k in 0..1 << bits {
        out.extend(palette.registers.get(k).unwrap_or(&[0; 3]));
    }
    out.push(bits as u8);
    for block in compressed(&indices, bits).chunks(255) {
        out.push(block.len() as u8);
        out.extend_from_slice(block);
    }
    out.push(0);
    Ok(out)
}

/// A colour in steps of 4 levels, which of two depending on the pixel: gradients that 256 colours cannot show become textures
/// of one level and not bands. White and black stay what they are.
fn dithered(color: [u8; 3], x: usize, y: usize) -> [u8; 3] {
    let threshold = BAYER[y % SIDE][x % SIDE] / 4;
    color.map(|v| match v {
        0 | 255 => v,
        _ => ((i32::from(v) + threshold) / 4 * 4).min(254) as u8,
    })
}

/// Codes of at most this many bits.
const LONGEST_CODE: u32 = 12;

/// Indices of so many bits as codes of variable length after Lempel, Ziv and Welch (appendix F), least significant bits first.
fn compressed(indices: &[u8], index_bits: u32) -> Vec<u8> {
    let clear = 1_u16 << index_bits;
    let end = clear + 1;
    let mut out = Bits::default();
    // Code of a known string followed by an index, by 256 times the code of the string and the index; 0 is none.
    let mut longer = vec![0_u16; 256 << LONGEST_CODE];
    let (mut next, mut bits) = (end + 1, index_bits + 1);
    out.put(clear, bits);
    let mut rest = indices.iter();
    let Some(&first) = rest.next() else {
        out.put(end, bits);
        return out.finish();
    };
    let mut known = u16::from(first);
    for &index in rest {
        let slot = usize::from(known) << 8 | usize::from(index);
        if longer[slot] != 0 {
            known = longer[slot];
            continue;
        }
        out.put(known, bits);
        if next == 1 << LONGEST_CODE {
            out.put(clear, bits);
            longer.fill(0);
            (next, bits) = (end + 1, index_bits + 1);
        } else {
            // The reader learns of a code one later.
            if u32::from(next) == 1 << bits {
                bits += 1;
            }
            longer[slot] = next;
            next += 1;
        }
        known = u16::from(index);
    }
    out.put(known, bits);
    if u32::from(next) == 1 << bits && bits < LONGEST_CODE {
        bits += 1;
    }
    out.put(end, bits);
    out.finish()
}

/// Codes packed into bytes.
#[derive(Default)]
struct Bits {
    bytes: Vec<u8>,
    pending: u32,
    count: u32,
}

impl Bits {
    fn put(&mut self, code: u16, bits: u32) {
        self.pending |= u32::from(code) << self.count;
        self.count += bits;
        while self.count >= 8 {
            self.bytes.push(self.pending as u8);
            self.pending >>= 8;
            self.count -= 8;
        }
    }

    fn finish(mut self) -> Vec<u8> {
        if self.count > 0 {
            self.bytes.push(self.pending as u8);
        }
        self.bytes
    }
}

/// Puts frames into one file that plays for ever.
pub(super) fn assemble(frames: &[MovieFrame], milliseconds: &[u16]) -> Result<Vec<u8>, OutputError> {
    let first = frames.first().ok_or_else(|| wrong("no frames"))?;
    let mut out = b"GIF89a".to_vec();
    for side in [first.width, first.height] {
        out.extend(u16::try_from(side).map_err(|_| wrong("it is too large"))?.to_le_bytes());
    }
    // No palette of all frames, square pixels.
    out.extend([0x70, 0, 0]);
    // Repeated without an end (Netscape 2.0).
    out.extend(b"\x21\xff\x0bNETSCAPE2.0\x03\x01\x00\x00\x00");
    // Each frame ends at the hundredth nearest to its end, so that rounding does not add up.
    let (mut end, mut shown) = (0_u32, 0);
    for (frame, &duration) in frames.iter().zip(milliseconds) {
        end += u32::from(duration);
        let delay = ((end + 5) / 10).saturating_sub(shown).max(SHORTEST);
        shown += delay;
        let [low, high] = (delay as u16).to_le_bytes();
        // Left where it is, for the next to cover.
        out.extend([0x21, 0xf9, 4, 1 << 2, low, high, 0, 0]);
        out.extend_from_slice(&frame.bytes);
    }
    out.push(0x3b);
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::super::{durations, encode_movie};
    use super::*;
    use image::AnimationDecoder;
    use image::codecs::gif::GifDecoder;
    use std::io::Cursor;

    fn picture(side: u32, pixel: impl Fn(u32, u32) -> [u8; 4]) -> DisplayImage {
        let pixels = (0..side * side).map(|k| pixel(k % side, k / side)).collect();
        DisplayImage { width: side, height: side, pixels }
    }

    /// Frames as another decoder sees them, and their times in milliseconds.
    fn decoded(pictures: &[DisplayImage], times: &[u16]) -> Vec<(Vec<u8>, u32)> {
        let frames: Vec<MovieFrame> =
            pictures.iter().map(|p| MovieFrame::new(p, MovieFormat::Gif, true).unwrap()).collect();
        let file = encode_movie(&frames, times).unwrap();
        let frames = GifDecoder::new(Cursor::new(&file)).unwrap().into_frames().collect_frames().unwrap();
        let one = |f: &image::Frame| (f.buffer().as_raw().clone(), f.delay().numer_denom_ms().0);
        frames.iter().map(one).collect()
    }

    /// Noise fills the table of codes again and again, flat pictures make it deep.
    #[test]
    fn another_decoder_finds_the_same_pixels() {
        let noise = |x: u32, y: u32| (x * 7919 + y * 104_729).wrapping_mul(2_654_435_761) >> 24;
        let pictures = [
            picture(200, |x, y| [(noise(x, y) & 0xf0) as u8, 0, 0, 255]),
            picture(200, |_, _| [255, 255, 255, 255]),
            picture(200, |x, _| [if x < 100 { 0 } else { 255 }, 255, 0, 255]),
        ];
        let found = decoded(&pictures, &[40, 40, 100]);
        assert_eq!(found.len(), 3);
        for (number, ((pixels, _), picture)) in found.iter().zip(&pictures).enumerate() {
            for (found, expected) in pixels.chunks(4).zip(&picture.pixels) {
                assert!(
                    found.iter().zip(expected).all(|(a, b)| a.abs_diff(*b) <= 3),
                    "{number}: {found:?} {expected:?}"
                );
            }
        }
        assert_eq!(found.iter().map(|frame| frame.1).collect::<Vec<_>>(), [40, 40, 100]);
    }

    #[test]
    fn what_is_translucent_lies_over_white() {
        let fading = picture(16, |x, _| [0, 0, 0, 255 - 17 * x as u8]);
        for (pixels, _) in decoded(&[fading], &[50]) {
            for (k, pixel) in pixels.chunks(4).enumerate() {
                assert!(pixel[0].abs_diff(17 * (k % 16) as u8) <= 3 && pixel[3] == 255, "{k}: {pixel:?}");
            }
        }
    }

    /// A palette alone shows bands of about 255 / 85 levels; the mean over a matrix is right within one level.
    #[test]
    fn gradients_are_dithered() {
        let gradient = picture(128, |x, y| [(x + 60) as u8, (y + 60) as u8, ((x + y) / 2 + 30) as u8, 255]);
        let (pixels, _) = &decoded(std::slice::from_ref(&gradient), &[100])[0];
        let mut error = [0_i32; 3];
        for (found, expected) in pixels.chunks(4).zip(&gradient.pixels) {
            for c in 0..3 {
                error[c] += i32::from(found[c]) - i32::from(expected[c]);
            }
        }
        assert!(error.iter().all(|e| e.abs() < 128 * 128), "{error:?}");
    }

    #[test]
    fn times_do_not_drift_and_none_is_too_short() {
        let still = picture(1, |_, _| [9, 9, 9, 255]);
        let of = |frames: usize, rate: f64| {
            decoded(&vec![still.clone(); frames], &durations(frames, rate))
                .iter()
                .map(|frame| frame.1)
                .collect::<Vec<_>>()
        };
        let film = of(48, 24.0);
        assert_eq!(film.iter().sum::<u32>(), 2000);
        assert!(film.iter().all(|&ms| ms == 40 || ms == 50), "{film:?}");
        assert_eq!(of(3, 1000.0), [20; 3]);
    }

    #[test]
    fn what_a_gif_cannot_hold_is_refused() {
        let wide = DisplayImage { width: 65_536, height: 1, pixels: vec![[0; 4]; 65_536] };
        let message = MovieFrame::new(&wide, MovieFormat::Gif, false).unwrap_err().to_string();
        assert_eq!(message, "cannot encode GIF: sides are 1 to 65535 pixels");
    }
}
