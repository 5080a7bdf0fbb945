//! Lossless WebP.

use super::{DisplayImage, OutputError, OutputFormat};
#[cfg(feature = "textures")]
use image::{ExtendedColorType, codecs::webp::WebPEncoder};

/// A lossless WebP file: RGB if the picture is opaque everywhere, RGBA with straight alpha otherwise.
///
/// # Errors
/// [`OutputError::Encode`] if a side is 0 or above 16384.
pub fn encode_webp(image: &DisplayImage) -> Result<Vec<u8>, OutputError> {
    encode_webp_layout(image, !image.is_opaque())
        .map_err(|reason| OutputError::Encode { format: OutputFormat::WebP, reason })
}

#[cfg(not(feature = "textures"))]
pub(super) fn encode_webp_layout(_: &DisplayImage, _: bool) -> Result<Vec<u8>, String> {
    Err(overcoat_core::formats::LEFT_OUT.to_owned())
}

/// The same with an alpha channel or without, as it is asked for; or what is wrong.
#[cfg(feature = "textures")]
pub(super) fn encode_webp_layout(image: &DisplayImage, alpha: bool) -> Result<Vec<u8>, String> {
    let mut file = Vec::new();
    let encoder = WebPEncoder::new_lossless(&mut file);
    let pixels = image.pixels.as_flattened();
    if pixels.len() as u64 != u64::from(image.width) * u64::from(image.height) * 4 || pixels.is_empty() {
        return Err(format!("a picture of {} x {} pixels", image.width, image.height));
    }
    let done = if alpha {
        encoder.encode(pixels, image.width, image.height, ExtendedColorType::Rgba8)
    } else {
        let rgb: Vec<u8> = image.pixels.iter().flat_map(|&[r, g, b, _]| [r, g, b]).collect();
        encoder.encode(&rgb, image.width, image.height, ExtendedColorType::Rgb8)
    };
    done.map_err(|error| error.to_string())?;
    Ok(file)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_bit_survives() {
        for opaque in [true, false] {
            let pixels: Vec<[u8; 4]> = (0..31 * 17_u32)
                .map(|k| {
                    [k as u8, (k >> 3) as u8, (k * k) as u8, if opaque { 255 } else { (k * 7) as u8 | 1 }]
                })
                .collect();
            let image = DisplayImage { width: 31, height: 17, pixels };
            let bytes = encode_webp(&image).unwrap();
            let read = image::load_from_memory_with_format(&bytes, image::ImageFormat::WebP).unwrap();
            assert_eq!(read.color().has_alpha(), !opaque);
            assert!(read.to_rgba8().as_raw() == image.pixels.as_flattened());
        }
        encode_webp(&DisplayImage { width: 0, height: 1, pixels: Vec::new() }).unwrap_err();
    }
}
