//! Radiance pictures (`.hdr`, `.pic`) in RGBE: flat, or with either run-length encoding.
//!
//! Own decoder: the `image` crate's wants the exact signature `#?RADIANCE`, allocates what the header claims and
//! reports a damaged scanline without its number. Format: G. Ward, *Radiance file formats* (`filefmts.pdf`), and
//! `color.c` of Radiance.

use super::error::quoted;
use super::{DecodeError, check_size};
use overcoat_core::limits::Limits;

/// Name of the format in messages.
pub const FORMAT: &str = "Radiance HDR";

/// Widths that the newer run-length encoding can have.
const NEW_WIDTHS: std::ops::RangeInclusive<usize> = 8..=32767;

/// Width, height and linear pixels, row by row from the top.
pub fn read(bytes: &[u8], limits: &Limits) -> Result<(u32, u32, Vec<[f32; 3]>), DecodeError> {
    let header = Header::read(bytes)?;
    check_size(FORMAT, [header.width.into(), header.height.into()], 12, 0, limits)?;
    let (width, height) = (header.width as usize, header.height as usize);
    let mut rest = header.body;
    let mut scanline = vec![[0_u8; 4]; width];
    // Grows with what is really there: an incomplete file costs no more than its part.
    let mut pixels = Vec::new();
    for y in 0..height {
        let cut =
            || DecodeError::malformed(FORMAT, format!("scanline {y} of {height} is incomplete or damaged"));
        rest = read_scanline(rest, &mut scanline).ok_or_else(cut)?;
        let texels = scanline.iter().map(|&texel| radiance(texel));
        if header.right_to_left { pixels.extend(texels.rev()) } else { pixels.extend(texels) }
    }
    if header.bottom_to_top {
        // Rows have at least one pixel.
        let mut rows = pixels.chunks_mut(width.max(1));
        while let (Some(above), Some(below)) = (rows.next(), rows.next_back()) {
            above.swap_with_slice(below);
        }
    }
    Ok((header.width, header.height, pixels))
}

/// Mantissas times 2^(exponent - 136), exactly; exponent 0 is black. (Radiance itself adds half a step to the
/// mantissas; stb_image, three.js and others do not, and the pictures of those are what users compare with.)
fn radiance([r, g, b, e]: [u8; 4]) -> [f32; 3] {
    // 2^(e - 136) as bits; below 2^-126 it is 0, far below what a picture can show.
    let scale = f32::from_bits(u32::from(e).saturating_sub(9) << 23);
    [r, g, b].map(|m| f32::from(m) * scale)
}

struct Header<'a> {
    width: u32,
    height: u32,
    bottom_to_top: bool,
    right_to_left: bool,
    /// The scanlines.
    body: &'a [u8],
}

impl<'a> Header<'a> {
    fn read(bytes: &'a [u8]) -> Result<Self, DecodeError> {
        let mut rest = bytes;
        let mut blank = false;
        loop {
            // A header is text of reasonable size; in something else the search for line ends would never stop.
            let end = rest.iter().take(4096).position(|&b| b == b'\n');
            let Some((line, [_, after @ ..])) = end.and_then(|end| rest.split_at_checked(end)) else {
                return Err(DecodeError::malformed(FORMAT, "the header has no end"));
            };
            let line = line.trim_ascii();
            rest = after;
            if blank {
                return Self::resolution(line, rest);
            }
            if let Some(format) = line.strip_prefix(b"FORMAT=")
                && format.trim_ascii() != b"32-bit_rle_rgbe"
            {
                return Err(DecodeError::unsupported(FORMAT, format!("pixels in format {}", quoted(format))));
            }
            blank = line.is_empty();
        }
    }

    /// From the line that gives the size, usually `-Y 512 +X 1024`.
    fn resolution(line: &[u8], body: &'a [u8]) -> Result<Self, DecodeError> {
        let parts: Vec<&[u8]> = line.split(u8::is_ascii_whitespace).filter(|p| !p.is_empty()).collect();
        let side = |part: &[u8]| std::str::from_utf8(part).ok()?.parse::<u32>().ok();
        let (vertical, height, horizontal, width) = match parts[..] {
            [v, h, u, w] => (v, side(h), u, side(w)),
            _ => (&[][..], None, &[][..], None),
        };
        let (Some(height), Some(width)) = (height, width) else {
            return Err(DecodeError::malformed(FORMAT, format!("{} is not a size", quoted(line))));
        };
        let bottom_to_top = match vertical {
            b"-Y" => false,
            b"+Y" => true,
            _ => return Err(DecodeError::unsupported(FORMAT, format!("the orientation {}", quoted(line)))),
        };
        let right_to_left = match horizontal {
            b"+X" => false,
            b"-X" => true,
            _ => return Err(DecodeError::unsupported(FORMAT, format!("the orientation {}", quoted(line)))),
        };
        Ok(Self { width, height, bottom_to_top, right_to_left, body })
    }
}

/// Decodes one scanline and returns what follows it; `None` if bytes are missing or runs do not fit.
fn read_scanline<'a>(bytes: &'a [u8], scanline: &mut [[u8; 4]]) -> Option<&'a [u8]> {
    let width = scanline.len();
    match bytes {
        [2, 2, high, low, rest @ ..] if NEW_WIDTHS.contains(&width) && *high < 128 => {
            if usize::from(*high) << 8 | usize::from(*low) == width { new_runs(rest, scanline) } else { None }
        }
        _ => old_runs(bytes, scanline),
    }
}

/// Each channel by itself: a count above 128 repeats the next byte count - 128 times, another copies that many bytes.
fn new_runs<'a>(mut bytes: &'a [u8], scanline: &mut [[u8; 4]]) -> Option<&'a [u8]> {
    for channel in 0..4 {
        let mut texels = &mut *scanline;
        while !texels.is_empty() {
            let &count = bytes.split_off_first()?;
            if let Some(count @ 1..) = count.checked_sub(128) {
                let &value = bytes.split_off_first()?;
                let run = texels.split_off_mut(..count.into())?;
                run.iter_mut().flat_map(|texel| texel.get_mut(channel)).for_each(|v| *v = value);
            } else {
                let run = texels.split_off_mut(..count.into()).filter(|run| !run.is_empty())?;
                let values = bytes.split_off(..count.into())?;
                for (texel, &value) in run.iter_mut().zip(values) {
                    texel.get_mut(channel).into_iter().for_each(|v| *v = value);
                }
            }
        }
    }
    Some(bytes)
}

/// Texels one after the other, where (1, 1, 1, n) repeats the last one n times; directly repeated, the counts are
/// digits of base 256, lowest first.
fn old_runs<'a>(mut bytes: &'a [u8], scanline: &mut [[u8; 4]]) -> Option<&'a [u8]> {
    /// Place values of the digits of a count. More than three would be more texels than a line has.
    const DIGITS: [usize; 3] = [1, 1 << 8, 1 << 16];
    let mut texels = scanline;
    let mut last = None;
    let mut digits = DIGITS.iter();
    while !texels.is_empty() {
        let (&texel, rest) = bytes.split_first_chunk::<4>()?;
        bytes = rest;
        if let [1, 1, 1, count] = texel {
            let count = usize::from(count).checked_mul(*digits.next()?)?;
            texels.split_off_mut(..count)?.fill(last?);
        } else {
            *texels.split_off_first_mut()? = texel;
            last = Some(texel);
            digits = DIGITS.iter();
        }
    }
    Some(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(size: &str, data: &[u8]) -> Vec<u8> {
        let mut bytes = format!("#?RGBE\n# made for a test\nFORMAT=32-bit_rle_rgbe\n\n{size}\n").into_bytes();
        bytes.extend(data);
        bytes
    }

    fn pixels(size: &str, data: &[u8]) -> Result<Vec<[f32; 3]>, DecodeError> {
        read(&file(size, data), &Limits::default()).map(|(_, _, pixels)| pixels)
    }

    #[test]
    fn mantissa_and_exponent_are_exact() {
        assert_eq!(radiance([128, 64, 1, 129]), [1.0, 0.5, 1.0 / 128.0]);
        assert_eq!(radiance([255, 0, 255, 0]), [0.0; 3]);
        assert_eq!(radiance([1, 2, 3, 136]), [1.0, 2.0, 3.0]);
        assert_eq!(radiance([1, 0, 0, 10])[0], f32::MIN_POSITIVE);
        assert_eq!(radiance([255, 0, 0, 255])[0], 255.0 * 2.0_f32.powi_exact(119));
    }

    trait PowiExact {
        fn powi_exact(self, n: u32) -> f32;
    }
    impl PowiExact for f32 {
        fn powi_exact(self, n: u32) -> f32 {
            (0..n).fold(1.0, |p, _| p * self)
        }
    }

    #[test]
    fn all_encodings_give_the_same_picture() {
        let texel = |k: u8| [10 * k, 20, 200 - k, 136];
        let plain: Vec<u8> = [0, 0, 0, 1, 2, 3, 4, 4].iter().flat_map(|&k| texel(k)).collect();
        let expected: Vec<[f32; 3]> = [0, 0, 0, 1, 2, 3, 4, 4].iter().map(|&k| radiance(texel(k))).collect();
        let old: Vec<u8> =
            [texel(0), [1, 1, 1, 2], texel(1), texel(2), texel(3), texel(4), [1, 1, 1, 1]].concat();
        let mut new = vec![2, 2, 0, 8];
        new.extend([131, 0, 5, 10, 20, 30, 40, 40]);
        new.extend([136, 20]);
        new.extend([131, 200, 3, 199, 198, 197, 130, 196]);
        new.extend([136, 136]);
        for data in [&plain, &old, &new] {
            assert_eq!(pixels("-Y 1 +X 8", data).unwrap(), expected);
        }
        let reversed: Vec<_> = expected.iter().rev().copied().collect();
        assert_eq!(pixels("-Y 1 -X 8", &new).unwrap(), reversed);
        let both = [&plain[..], &old[..]].concat();
        assert_eq!(pixels("-Y 2 +X 8", &both).unwrap(), [&expected[..], &expected[..]].concat());
        let upside_down = [&[texel(9); 8].concat()[..], &plain[..]].concat();
        assert_eq!(pixels("+Y 2 +X 8", &upside_down).unwrap()[..8], expected);
    }

    #[test]
    fn a_long_old_run_has_several_digits() {
        let data = [[7, 7, 7, 136], [1, 1, 1, 44], [1, 1, 1, 1]].concat();
        assert_eq!(pixels("-Y 1 +X 301", &data).unwrap(), vec![[7.0; 3]; 301]);
    }

    #[test]
    fn damage_is_an_error_that_says_where() {
        for (size, data, message) in [
            ("-Y 2 +X 1", &[1, 2, 3, 136][..], "scanline 1 of 2 is incomplete"),
            ("-Y 1 +X 8", &[2, 2, 0, 8, 255, 1], "scanline 0 of 1"),
            ("-Y 1 +X 8", &[2, 2, 0, 8, 0], "scanline 0 of 1"),
            ("-Y 1 +X 8", &[2, 2, 0, 9, 0], "scanline 0 of 1"),
            ("-Y 1 +X 4", &[1, 1, 1, 4], "scanline 0 of 1"),
            ("-Y 0 +X 4", &[], "0 pixels"),
            ("-Y -1 +X 4", &[], "not a size"),
            ("Y 1 X 4", &[], "orientation"),
            ("+X 4 -Y 1", &[], "orientation"),
            ("-Y 1000000 +X 1000000", &[], "exceeds the limit"),
            ("-Y 99999999999999999999 +X 1", &[], "not a size"),
        ] {
            let error = pixels(size, data).unwrap_err().to_string();
            assert!(error.contains(message) && !error.contains('\n'), "{size}: {error}");
        }
        assert!(read(b"#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 1 +X 1\n", &Limits::default()).is_err());
        assert!(read(b"#?RADIANCE\n", &Limits::default()).is_err());
    }
}
