//! Radiance RGBE files: linear light with a shared exponent.
//!
//! Format: Greg Ward, "Real Pixels", Graphics Gems II (1991), and `color.c` of Radiance for the run lengths. The
//! exponent comes from the bits of the largest channel, not from a logarithm, so that every machine writes the same.

use super::{OutputError, OutputFormat, check_size};
use overcoat_core::frame::Frame;

/// Shortest run that is written as such.
const LEAST_RUN: usize = 4;

/// A Radiance file of the frame over black: colours are premultiplied, so leaving alpha out does that. Rounded to
/// 8 bits below the exponent of the largest channel; what is negative or NaN is written as 0, and light above 1e38
/// as that.
///
/// # Errors
/// [`OutputError::Encode`] if a side is 0.
pub fn encode_hdr(frame: &Frame) -> Result<Vec<u8>, OutputError> {
    check_size(frame, OutputFormat::Hdr)?;
    let mut bytes = Vec::with_capacity(frame.pixels.len() * 4 + 128);
    bytes.extend_from_slice(b"#?RADIANCE\nSOFTWARE=overcoat\nFORMAT=32-bit_rle_rgbe\n\n");
    bytes.extend_from_slice(format!("-Y {} +X {}\n", frame.height, frame.width).as_bytes());
    let width = frame.width as usize;
    let mut row = Vec::with_capacity(width);
    let mut channel = Vec::with_capacity(width);
    for linear in frame.pixels.chunks(width) {
        row.clear();
        row.extend(linear.iter().map(|&[r, g, b, _]| rgbe([r, g, b])));
        // The marker of run-length encoded rows holds 15 bits of width and is ambiguous below 8.
        if !(8..0x8000).contains(&width) {
            bytes.extend_from_slice(row.as_flattened());
            continue;
        }
        bytes.extend_from_slice(&[2, 2, (width >> 8) as u8, width as u8]);
        for c in 0..4 {
            channel.clear();
            channel.extend(row.iter().map(|pixel| pixel[c]));
            write_runs(&channel, &mut bytes);
        }
    }
    Ok(bytes)
}

/// Three mantissas and their exponent plus 128: `value = mantissa * 2^(e - 136)`.
fn rgbe(rgb: [f32; 3]) -> [u8; 4] {
    let rgb = rgb.map(|c| if c > 0.0 { if c < 1e38 { c } else { 1e38 } } else { 0.0 });
    let largest = rgb.iter().fold(0.0_f32, |m, &c| if c > m { c } else { m });
    if largest < 1e-32 {
        return [0; 4];
    }
    // largest = m * 2^exponent with m in [1/2, 1).
    let mut exponent = (largest.to_bits() >> 23) as i32 - 126;
    let mantissas = |exponent: i32| {
        let scale = f64::from_bits(((1023 + 8 - exponent) as u64) << 52);
        rgb.map(|c| (f64::from(c) * scale + 0.5) as u32)
    };
    let mut m = mantissas(exponent);
    if m.iter().any(|&v| v > 255) {
        exponent += 1;
        m = mantissas(exponent);
    }
    [m[0] as u8, m[1] as u8, m[2] as u8, (exponent + 128) as u8]
}

/// One channel of a row: (128 + n, value) for runs, (n, values...) for the rest, n up to 127 and 128.
fn write_runs(channel: &[u8], out: &mut Vec<u8>) {
    let mut at = 0;
    while let Some(&value) = channel.get(at) {
        let run = channel[at..].iter().take(127).take_while(|&&v| v == value).count();
        if run >= LEAST_RUN {
            out.extend_from_slice(&[128 + run as u8, value]);
            at += run;
            continue;
        }
        // Plain bytes up to the next run that is worth it.
        let rest = &channel[at..];
        let len =
            rest.windows(LEAST_RUN).position(|w| w.iter().all(|&v| v == w[0])).unwrap_or(rest.len()).min(128);
        out.push(len as u8);
        out.extend_from_slice(&rest[..len]);
        at += len;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn decode(bytes: &[u8]) -> (u32, u32, Vec<[f32; 3]>) {
        let decoder = image::codecs::hdr::HdrDecoder::new(std::io::Cursor::new(bytes)).unwrap();
        let meta = decoder.metadata();
        let image = image::DynamicImage::from_decoder(decoder).unwrap().into_rgb32f();
        (meta.width, meta.height, image.pixels().map(|p| p.0).collect())
    }

    /// Widths with and without run lengths; rows with long runs, short ones and noise.
    #[test]
    fn light_comes_back_within_the_rounding_of_the_format() {
        for width in [1_u32, 7, 8, 9, 130, 300] {
            let height = 5;
            let pixels: Vec<[f32; 4]> = (0..width * height)
                .map(|k| match k / width {
                    0 => [0.0, 0.0, 0.0, 1.0],
                    1 => [0.25, 4.0, 1000.0, 0.5],
                    2 => [(k % 7 / 3) as f32, 0.5, 0.001, 1.0],
                    _ => [(k * k % 977) as f32 * 0.01, (k * 31 % 89) as f32, (k % 5) as f32 * 1e-6, 0.0],
                })
                .collect();
            let frame =
                Frame { width, height, pixels: pixels.clone(), transmittance: Vec::new(), aovs: Vec::new() };
            let (w, h, decoded) = decode(&encode_hdr(&frame).unwrap());
            assert_eq!((w, h), (width, height));
            for (got, want) in decoded.iter().zip(&pixels) {
                let largest = want[..3].iter().copied().fold(0.0, f32::max);
                for c in 0..3 {
                    let error = (got[c] - want[c]).abs();
                    assert!(error <= largest / 256.0 + 1e-30, "{got:?} is not {want:?}");
                }
            }
        }
    }

    #[test]
    fn known_pixels() {
        assert_eq!(rgbe([1.0, 0.5, 0.25]), [128, 64, 32, 129]);
        assert_eq!(rgbe([0.0; 3]), [0; 4]);
        // 255.6 / 256 of the exponent rounds up into the next one.
        assert_eq!(rgbe([0.9985, 0.0, 0.0]), [128, 0, 0, 129]);
        assert_eq!(rgbe([f32::NAN, -1.0, 1.0]), [0, 0, 128, 129]);
        assert_eq!(rgbe([f32::INFINITY, 0.0, 0.0])[3], 255);
        assert_eq!(rgbe([1e-40, 0.0, 0.0]), [0; 4]);
    }
}
