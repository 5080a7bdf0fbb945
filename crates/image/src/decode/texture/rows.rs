//! Sound pictures to rows of 8-bit RGBA, and rows to images.

use super::{DECODER_BYTES, Header, ImageError, damaged, decoder};
use ::image::{ColorType, ImageDecoder, ImageFormat};
use overcoat_core::color::srgb::linear_to_srgb8;
use overcoat_scene::Image;
use std::io::Cursor;

/// Gives the rows of a picture to `take`, from the top on, until it says false. PNG is decoded row by row; other pictures
/// first, into `raw`.
///
/// # Errors
/// [`ImageError::Damaged`] if it is not sound, whatever rows were given.
pub fn read(
    format: ImageFormat,
    bytes: &[u8],
    header: &Header,
    raw: &mut Vec<u8>,
    take: &mut dyn FnMut(&[[u8; 4]]) -> bool,
) -> Result<(), ImageError> {
    let width = usize::try_from(header.width).map_err(damaged)?;
    let mut row = vec![[0u8; 4]; width];
    if format == ImageFormat::Png
        && let Some(done) = read_png(bytes, header, raw, &mut row, take)?
    {
        return Ok(done);
    }
    let decoder = checked(format, bytes, header)?;
    let color_type = decoder.color_type();
    let bytes = usize::try_from(decoder.total_bytes()).map_err(damaged)?;
    if raw.capacity() < bytes {
        // Memory that the system gives is empty already.
        *raw = vec![0; bytes];
    } else {
        // Of what decoders leave out the last picture must not show.
        raw.clear();
        raw.resize(bytes, 0);
    }
    decoder.read_image(raw).map_err(damaged)?;
    let stride = width.saturating_mul(color_type.bytes_per_pixel().into());
    for packed in raw.chunks_exact(stride.max(1)) {
        expand(color_type, packed, &mut row)?;
        if !take(&row) {
            break;
        }
    }
    Ok(())
}

/// The rows of a PNG file, each as soon as it is there. `None` if they come interlaced.
fn read_png(
    bytes: &[u8],
    header: &Header,
    raw: &mut Vec<u8>,
    row: &mut [[u8; 4]],
    take: &mut dyn FnMut(&[[u8; 4]]) -> bool,
) -> Result<Option<()>, ImageError> {
    let limits = png::Limits { bytes: usize::try_from(max_bytes(header)).unwrap_or(usize::MAX) };
    let mut decoder = png::Decoder::new_with_limits(Cursor::new(bytes), limits);
    decoder.set_ignore_text_chunk(false);
    decoder.set_transformations(png::Transformations::EXPAND);
    let mut reader = decoder.read_info().map_err(damaged)?;
    let info = reader.info();
    if info.interlaced || (info.width, info.height) != (header.width, header.height) {
        return Ok(None);
    }
    let color_type = match reader.output_color_type() {
        (png::ColorType::Grayscale, png::BitDepth::Eight) => ColorType::L8,
        (png::ColorType::GrayscaleAlpha, png::BitDepth::Eight) => ColorType::La8,
        (png::ColorType::Rgb, png::BitDepth::Eight) => ColorType::Rgb8,
        (png::ColorType::Rgba, png::BitDepth::Eight) => ColorType::Rgba8,
        (png::ColorType::Grayscale, png::BitDepth::Sixteen) => ColorType::L16,
        (png::ColorType::GrayscaleAlpha, png::BitDepth::Sixteen) => ColorType::La16,
        (png::ColorType::Rgb, png::BitDepth::Sixteen) => ColorType::Rgb16,
        (png::ColorType::Rgba, png::BitDepth::Sixteen) => ColorType::Rgba16,
        _ => return Ok(None),
    };
    let is_wide = color_type.bytes_per_pixel() > color_type.channel_count();
    raw.clear();
    raw.resize(row.len().saturating_mul(color_type.bytes_per_pixel().into()), 0);
    for number in 1..=header.height {
        if reader.read_row(raw).map_err(damaged)?.is_none() {
            return Err(ImageError::Damaged("rows of it are missing".to_owned()));
        }
        if is_wide {
            for channel in raw.as_chunks_mut::<2>().0 {
                *channel = u16::from_be_bytes(*channel).to_ne_bytes();
            }
        }
        expand(color_type, raw, row)?;
        if !take(row) && number < header.height {
            return Ok(Some(()));
        }
    }
    // What comes after the rows has to be sound too: checksums.
    reader.finish().map_err(damaged)?;
    Ok(Some(()))
}

/// The image of a picture that is sound.
///
/// # Errors
/// [`ImageError::Damaged`].
pub fn image(format: ImageFormat, bytes: &[u8], header: &Header) -> Result<Image, ImageError> {
    if let Some(image) = jpeg_image(bytes, header) {
        return Ok(image);
    }
    let decoder = checked(format, bytes, header)?;
    let count = usize::try_from(header.texels()).map_err(damaged)?;
    let color_type = decoder.color_type();
    let mut texels = vec![[0u8; 4]; count];
    if color_type == ColorType::Rgba8 {
        decoder.read_image(texels.as_flattened_mut()).map_err(damaged)?;
    } else {
        let mut raw = vec![0u8; usize::try_from(decoder.total_bytes()).map_err(damaged)?];
        decoder.read_image(&mut raw).map_err(damaged)?;
        expand(color_type, &raw, &mut texels)?;
    }
    Image::new(header.width, header.height, texels).map_err(damaged)
}

/// The image of a JPEG file that is read by rows. `None` for others, and if it is damaged.
fn jpeg_image(bytes: &[u8], header: &Header) -> Option<Image> {
    header.jpeg?;
    let mut texels = Vec::with_capacity(usize::try_from(header.texels()).ok()?);
    let sound = super::rows(bytes, header, &mut Vec::new(), &mut |row| {
        texels.extend_from_slice(row);
        true
    });
    Image::new(header.width, header.height, texels).ok().filter(|_| sound)
}

/// Bytes that decoding a picture may take.
fn max_bytes(header: &Header) -> u64 {
    header.texels().saturating_mul(header.transient.saturating_add(4)).saturating_add(DECODER_BYTES)
}

/// The decoder of a picture that has the size that its header had.
fn checked<'a>(
    format: ImageFormat,
    bytes: &'a [u8],
    header: &Header,
) -> Result<Box<dyn ImageDecoder + 'a>, ImageError> {
    let decoder = decoder(bytes, format, max_bytes(header).saturating_sub(DECODER_BYTES))?;
    if decoder.dimensions() != (header.width, header.height) {
        return Err(ImageError::Damaged("its header changed while it was read".to_owned()));
    }
    Ok(decoder)
}

/// Packed texels as RGBA of 8 bits; 16 bits are in this machine's byte order.
fn expand(color_type: ColorType, packed: &[u8], texels: &mut [[u8; 4]]) -> Result<(), ImageError> {
    match color_type {
        ColorType::Rgba8 => each(packed, texels, |texel: [u8; 4]| texel),
        ColorType::L8 => each(packed, texels, |[l]: [u8; 1]| [l, l, l, 255]),
        ColorType::La8 => each(packed, texels, |[l, a]: [u8; 2]| [l, l, l, a]),
        ColorType::Rgb8 => each(packed, texels, |[r, g, b]: [u8; 3]| [r, g, b, 255]),
        ColorType::L16 => each(packed, texels, |[a, b]: [u8; 2]| {
            let l = narrow([a, b]);
            [l, l, l, 255]
        }),
        ColorType::La16 => each(packed, texels, |[a, b, c, d]: [u8; 4]| {
            let l = narrow([a, b]);
            [l, l, l, narrow([c, d])]
        }),
        ColorType::Rgb16 => each(packed, texels, |[a, b, c, d, e, f]: [u8; 6]| {
            [narrow([a, b]), narrow([c, d]), narrow([e, f]), 255]
        }),
        ColorType::Rgba16 => each(packed, texels, |[a, b, c, d, e, f, g, h]: [u8; 8]| {
            [[a, b], [c, d], [e, f], [g, h]].map(narrow)
        }),
        ColorType::Rgb32F => each(packed, texels, |floats: [u8; 12]| {
            let [r, g, b] = light(&floats);
            [r, g, b, 255]
        }),
        ColorType::Rgba32F => each(packed, texels, |floats: [u8; 16]| {
            let [r, g, b, _] = light(&floats);
            let [_, _, _, a] = floats_of(&floats);
            [r, g, b, (saturate(a) * 255.0 + 0.5) as u8]
        }),
        other => return Err(ImageError::Damaged(format!("texels of the kind {other:?} are not known"))),
    }
    Ok(())
}

fn each<const S: usize>(packed: &[u8], texels: &mut [[u8; 4]], convert: impl Fn([u8; S]) -> [u8; 4]) {
    for (texel, from) in texels.iter_mut().zip(packed.as_chunks::<S>().0) {
        *texel = convert(*from);
    }
}

/// Numbers in this machine's byte order; zeros behind the last one.
fn floats_of<const N: usize>(raw: &[u8]) -> [f32; N] {
    let mut floats = [0.0; N];
    for (float, bytes) in floats.iter_mut().zip(raw.as_chunks::<4>().0) {
        *float = f32::from_ne_bytes(*bytes);
    }
    floats
}

/// Linear light as codes.
fn light<const N: usize>(raw: &[u8]) -> [u8; N] {
    floats_of(raw).map(|v| linear_to_srgb8(saturate(v)))
}

/// 0 to 1; NaN becomes 0.
fn saturate(v: f32) -> f32 {
    if v > 0.0 { if v < 1.0 { v } else { 1.0 } } else { 0.0 }
}

/// A channel of 16 bits in this machine's byte order, rounded to 8 bits.
fn narrow(channel: [u8; 2]) -> u8 {
    let v = u32::from(u16::from_ne_bytes(channel));
    (v.saturating_mul(255).saturating_add(32767) / 65535) as u8
}
