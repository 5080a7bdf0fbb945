//! PNG files, every kind of them, as codes of 8 or 16 bits.

use super::DecodeError;
use overcoat_core::limits::Limits;
use std::io::Cursor;

/// Name of the format in messages.
const FORMAT: &str = "PNG";

/// Bytes that a PNG decoder may allocate for its own purposes beside the pixels: profiles and texts.
const PNG_OVERHEAD: u64 = 1 << 24;

/// Bytes that a pixel takes: in the decoder's buffer and in what is made of it.
pub(super) const BYTES_PER_PIXEL: u64 = 8 + 16;

/// A PNG file's samples, from the decoder's rows: colours and alpha, 8 or 16 bits, no palette.
pub struct PngSamples {
    pub width: u32,
    pub height: u32,
    pub is_16_bit: bool,
    /// RGBA, 4 numbers a pixel; 8-bit codes as they are.
    pub samples: Vec<[u16; 4]>,
}

pub(super) fn damaged_png(error: png::DecodingError) -> DecodeError {
    DecodeError::malformed(FORMAT, error.to_string())
}

/// A decoder whose rows have no palette and always alpha.
pub(super) fn png_decoder<'a>(bytes: &'a [u8], limits: &Limits) -> png::Decoder<Cursor<&'a [u8]>> {
    let memory = usize::try_from(limits.decoded_bytes.min(PNG_OVERHEAD)).unwrap_or(usize::MAX);
    let mut decoder = png::Decoder::new_with_limits(Cursor::new(bytes), png::Limits { bytes: memory });
    decoder.set_transformations(png::Transformations::EXPAND | png::Transformations::ALPHA);
    decoder
}

/// Bytes that one picture of the file takes as it is unpacked.
pub(super) fn buffer_size<R: std::io::BufRead + std::io::Seek>(
    reader: &png::Reader<R>,
) -> Result<usize, DecodeError> {
    reader.output_buffer_size().ok_or_else(|| DecodeError::malformed(FORMAT, "too large"))
}

/// RGBA codes of rows from [`png_decoder`].
pub(super) fn png_codes(
    data: &[u8],
    color: png::ColorType,
    depth: png::BitDepth,
) -> Result<Vec<[u16; 4]>, DecodeError> {
    let codes: Vec<u16> = if depth == png::BitDepth::Sixteen {
        data.as_chunks::<2>().0.iter().map(|&v| u16::from_be_bytes(v)).collect()
    } else {
        data.iter().map(|&v| u16::from(v)).collect()
    };
    match color {
        png::ColorType::GrayscaleAlpha => {
            Ok(codes.as_chunks::<2>().0.iter().map(|&[v, a]| [v, v, v, a]).collect())
        }
        png::ColorType::Rgba => Ok(codes.as_chunks::<4>().0.to_vec()),
        other => Err(DecodeError::malformed(FORMAT, format!("{other:?} was not expanded"))),
    }
}

/// Reads the pixels of a PNG file of any kind, of an animation those of its first picture.
pub fn read_png(bytes: &[u8], limits: &Limits) -> Result<PngSamples, DecodeError> {
    let mut decoder = png_decoder(bytes, limits);
    let info = decoder.read_header_info().map_err(damaged_png)?;
    let (width, height) = (info.width, info.height);
    let pixels = u64::from(width).saturating_mul(height.into());
    let what = || format!("PNG of {width} x {height} pixels");
    Limits::check(what, pixels, limits.texture_pixels, "texture_pixels")?;
    Limits::check(what, pixels.saturating_mul(BYTES_PER_PIXEL), limits.decoded_bytes, "decoded_bytes")?;
    let mut reader = decoder.read_info().map_err(damaged_png)?;
    let mut data = vec![0; buffer_size(&reader)?];
    let info = reader.next_frame(&mut data).map_err(damaged_png)?;
    // The whole file counts: what follows the pixels may be cut off.
    reader.finish().map_err(damaged_png)?;
    data.truncate(info.buffer_size());
    let is_16_bit = info.bit_depth == png::BitDepth::Sixteen;
    let samples = png_codes(&data, info.color_type, info.bit_depth)?;
    Ok(PngSamples { width: info.width, height: info.height, is_16_bit, samples })
}
