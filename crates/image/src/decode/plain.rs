//! Files with one still picture and nothing beside it: BMP, TGA, TIFF, Netpbm and QOI.

use super::texture::{self, ImageError, kind, kind::Kind};
use super::{DecodeError, DecodedPicture, SampleKind};
use ::image::{ColorType, DynamicImage, ImageDecoder, ImageFormat};
use overcoat_core::formats::{self, FileFormat};
use overcoat_core::limits::Limits;

/// Bytes of a pixel of a [`DecodedPicture`].
const PIXEL: u64 = 16;

/// Decodes a file without loss: codes of 8 or 16 bits, or floats of TIFF as linear light.
///
/// # Errors
/// [`DecodeError`] if it is none of these, is damaged, asks for more than the limits allow, or is a TIFF of several pages.
pub(super) fn read(bytes: &[u8], limits: &Limits) -> Result<DecodedPicture, DecodeError> {
    let found = kind::find(bytes, |_| None);
    let format = match found {
        Ok((Kind::Image(ImageFormat::Bmp), 0)) => (ImageFormat::Bmp, formats::BMP),
        Ok((Kind::Image(ImageFormat::Tga), 0)) => (ImageFormat::Tga, formats::TGA),
        Ok((Kind::Image(ImageFormat::Tiff), 0)) => (ImageFormat::Tiff, formats::TIFF),
        Ok((Kind::Image(ImageFormat::Pnm), 0)) => (ImageFormat::Pnm, formats::PNM),
        Ok((Kind::Image(ImageFormat::Qoi), 0)) => (ImageFormat::Qoi, formats::QOI),
        Ok(_) => return Err(unknown("")),
        Err(what) => return Err(unknown(&what)),
    };
    let (format, FileFormat { name, .. }) = format;
    if !texture::is_built(format) {
        return Err(DecodeError::unsupported(name, formats::LEFT_OUT));
    }
    if format == ImageFormat::Tiff && has_more_pages(bytes) {
        return Err(DecodeError::unsupported(name, "more than one page"));
    }
    let explain = |error| match error {
        ImageError::Damaged(message) => DecodeError::malformed(name, message),
        ImageError::Limit(error) => error.into(),
    };
    let decoder = texture::decoder(bytes, format, limits.decoded_bytes).map_err(explain)?;
    let (width, height) = decoder.dimensions();
    let color_type = decoder.color_type();
    // The decoder's own pixels and those as all four channels are in memory for a while.
    let channel =
        u64::from(color_type.bytes_per_pixel().checked_div(color_type.channel_count()).unwrap_or(4));
    let bytes_per_pixel = u64::from(color_type.bytes_per_pixel()).saturating_add(channel.saturating_mul(4));
    super::check_size(name, [width.into(), height.into()], bytes_per_pixel.saturating_add(PIXEL), 0, limits)?;
    let image =
        DynamicImage::from_decoder(decoder).map_err(|e| DecodeError::malformed(name, e.to_string()))?;
    let (kind, pixels) = samples(image, color_type);
    Ok(DecodedPicture::still([width, height], kind, pixels))
}

/// RGBA as it is stored, 0 to [`SampleKind::white`].
fn samples(image: DynamicImage, color_type: ColorType) -> (SampleKind, Vec<[f32; 4]>) {
    match color_type {
        ColorType::Rgb32F | ColorType::Rgba32F => {
            (SampleKind::Float, image.into_rgba32f().pixels().map(|p| p.0).collect())
        }
        ColorType::L16 | ColorType::La16 | ColorType::Rgb16 | ColorType::Rgba16 => {
            (SampleKind::Unsigned16, image.into_rgba16().pixels().map(|p| p.0.map(f32::from)).collect())
        }
        _ => (SampleKind::Unsigned8, image.into_rgba8().pixels().map(|p| p.0.map(f32::from)).collect()),
    }
}

fn unknown(what: &str) -> DecodeError {
    let names = "neither a PNG nor an OpenEXR nor a Radiance HDR, WebP, GIF, JPEG, BMP, TGA, TIFF, Netpbm or QOI file";
    let what = if what == texture::NOT_AN_IMAGE { "" } else { what };
    let colon = if what.is_empty() { "" } else { ": " };
    DecodeError::UnknownFormat(super::one_line(format!("{names} (by its first bytes){colon}{what}")))
}

/// True if another page follows the first one of a TIFF file (TIFF 6.0, section 2; BigTIFF has wider fields), which the decoder
/// would not read. Damaged files are left to the decoder.
fn has_more_pages(bytes: &[u8]) -> bool {
    let is_big_endian = bytes.starts_with(b"MM");
    let number = |at: u64, length: usize| -> Option<u64> {
        let at = usize::try_from(at).ok()?;
        let field = bytes.get(at..at.checked_add(length)?)?;
        let add = |sum: u64, &byte: &u8| sum << 8 | u64::from(byte);
        Some(if is_big_endian { field.iter().fold(0, add) } else { field.iter().rev().fold(0, add) })
    };
    let next_page = || {
        let is_wide = number(2, 2)? == 43;
        let (count_bytes, entry_bytes, offset_bytes) = if is_wide { (8, 20, 8) } else { (2, 12, 4) };
        let first = number(if is_wide { 8 } else { 4 }, offset_bytes)?;
        let entries = number(first, count_bytes)?.checked_mul(entry_bytes)?;
        number(first.checked_add(count_bytes as u64)?.checked_add(entries)?, offset_bytes)
    };
    next_page().is_some_and(|at| at != 0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use ::image::ImageBuffer;
    use std::io::Cursor;

    fn encoded(image: &DynamicImage, format: ImageFormat) -> Vec<u8> {
        let mut bytes = Cursor::new(Vec::new());
        image.write_to(&mut bytes, format).unwrap();
        bytes.into_inner()
    }

    fn open(bytes: &[u8]) -> DecodedPicture {
        DecodedPicture::from_bytes(bytes, &Limits::default()).unwrap()
    }

    #[test]
    fn samples_are_as_they_are_stored() {
        use ImageFormat::{Bmp, Pnm, Qoi, Tga, Tiff};
        let codes = |x: u32, y: u32| [(x * 9) as u8, (y * 5) as u8, 7, 255];
        let opaque = ImageBuffer::from_fn(20, 12, |x, y| {
            let [r, g, b, _] = codes(x, y);
            ::image::Rgb([r, g, b])
        });
        let expected: Vec<[f32; 4]> = (0..240).map(|k| codes(k % 20, k / 20).map(f32::from)).collect();
        for format in [Bmp, Tga, Tiff, Pnm, Qoi] {
            let picture = open(&encoded(&opaque.clone().into(), format));
            assert_eq!((picture.width, picture.height, picture.kind), (20, 12, SampleKind::Unsigned8));
            assert_eq!(picture.pixels, expected, "{format:?}");
        }
        let translucent: DynamicImage = ImageBuffer::from_pixel(3, 2, ::image::Rgba([1u8, 2, 3, 4])).into();
        for format in [Bmp, Tga, Tiff, Qoi] {
            assert_eq!(open(&encoded(&translucent, format)).pixels, [[1.0, 2.0, 3.0, 4.0]; 6], "{format:?}");
        }
        let deep: DynamicImage = ImageBuffer::from_pixel(3, 2, ::image::Rgb([1u16, 300, 65535])).into();
        for format in [Tiff, Pnm] {
            let picture = open(&encoded(&deep, format));
            assert_eq!(picture.kind, SampleKind::Unsigned16);
            assert_eq!(picture.pixels, [[1.0, 300.0, 65535.0, 65535.0]; 6], "{format:?}");
        }
        let light: DynamicImage = ImageBuffer::from_pixel(3, 2, ::image::Rgb([0.25f32, 4.0, -1.0])).into();
        let picture = open(&encoded(&light, Tiff));
        assert_eq!((picture.kind, picture.pixels[5]), (SampleKind::Float, [0.25, 4.0, -1.0, 1.0]));
        // The greatest number of a file stands for white.
        assert_eq!(open(b"P2 2 1 15 0 15").pixels, [[0.0, 0.0, 0.0, 255.0], [255.0; 4]]);
    }

    #[test]
    fn what_would_be_read_in_part_is_refused() {
        let image: DynamicImage = ImageBuffer::from_pixel(3, 2, ::image::Rgb([1u8, 2, 3])).into();
        let page = encoded(&image, ImageFormat::Tiff);
        assert!(!has_more_pages(&page));
        // The table of the page says where the next one is: here it is the same table again.
        let mut two = page.clone();
        let first = u32::from_le_bytes(page[4..8].try_into().unwrap()) as usize;
        let count = usize::from(u16::from_le_bytes(page[first..first + 2].try_into().unwrap()));
        let at = first + 2 + 12 * count;
        two[at..at + 4].copy_from_slice(&page[4..8]);
        let error = DecodedPicture::from_bytes(&two, &Limits::default()).unwrap_err().to_string();
        assert_eq!(error, "TIFF: more than one page");
        for length in 0..page.len() {
            has_more_pages(&page[..length]);
        }
    }

    #[test]
    fn claims_are_checked_and_damage_is_an_error() {
        let image: DynamicImage = ImageBuffer::from_pixel(30, 20, ::image::Rgb([1u8, 2, 3])).into();
        for format in
            [ImageFormat::Bmp, ImageFormat::Tga, ImageFormat::Tiff, ImageFormat::Pnm, ImageFormat::Qoi]
        {
            let bytes = encoded(&image, format);
            let small = Limits::default().with_texture_pixels(599);
            assert!(
                matches!(DecodedPicture::from_bytes(&bytes, &small), Err(DecodeError::Limit(_))),
                "{format:?}"
            );
            for length in [0, 3, 10, 20, bytes.len() / 2] {
                let error = DecodedPicture::from_bytes(&bytes[..length], &Limits::default()).unwrap_err();
                assert!(!error.to_string().contains('\n'), "{format:?} {length}");
            }
        }
        let error = DecodedPicture::from_bytes(b"DDS |\0\0\0", &Limits::default()).unwrap_err().to_string();
        assert!(error.ends_with("(by its first bytes): it is a DDS texture"), "{error}");
    }
}
