//! JPEG, 8 bits a channel, without transparency.

use super::{DisplayImage, OutputError, OutputFormat};
use image::ExtendedColorType;
use image::codecs::jpeg::JpegEncoder;

/// The quality where none is given.
pub const DEFAULT_JPEG_QUALITY: u8 = 90;

/// A JPEG file with colours at full resolution (4:4:4), quality 1 to 100. JPEG has no transparency: what is translucent lies
/// over white. Integer arithmetic and exactly rounded quotients: the bytes are the same on every machine.
///
/// # Errors
/// [`OutputError::Encode`] if a side is 0 or above 65535, or the quality is not 1 to 100.
pub fn encode_jpeg(image: &DisplayImage, quality: u8) -> Result<Vec<u8>, OutputError> {
    let wrong = |reason: String| OutputError::Encode { format: OutputFormat::Jpeg, reason };
    let DisplayImage { width, height, ref pixels } = *image;
    let fits = |side: u32| (1..=65535).contains(&side);
    if !fits(width) || !fits(height) || pixels.len() as u64 != u64::from(width) * u64::from(height) {
        return Err(wrong(format!("a picture of {width} x {height} pixels")));
    }
    if !(1..=100).contains(&quality) {
        return Err(wrong(format!("a quality of {quality}; it is 1 to 100")));
    }
    let rgb: Vec<u8> = pixels.iter().flat_map(|&p| over_white(p)).collect();
    let mut bytes = Vec::with_capacity(rgb.len() / 8 + 1024);
    JpegEncoder::new_with_quality(&mut bytes, quality)
        .encode(&rgb, width, height, ExtendedColorType::Rgb8)
        .map_err(|e| wrong(e.to_string()))?;
    Ok(bytes)
}

/// Straight alpha over white, in codes as browsers do.
pub(super) fn over_white([r, g, b, a]: [u8; 4]) -> [u8; 3] {
    let a = u32::from(a);
    [r, g, b].map(|v| ((u32::from(v) * a + 255 * (255 - a) + 127) / 255) as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_comes_back_is_near_and_lies_over_white() {
        let pixels = (0..48 * 40_u32)
            .map(|k| [(3 * (k % 48)) as u8, (k / 48) as u8, 90, if k % 48 < 24 { 255 } else { 0 }])
            .collect();
        let image = DisplayImage { width: 48, height: 40, pixels };
        let read = |bytes: &[u8]| {
            image::load_from_memory_with_format(bytes, image::ImageFormat::Jpeg).unwrap().to_rgb8()
        };
        let [good, poor] = [95, 20].map(|quality| encode_jpeg(&image, quality).unwrap());
        assert!(good.len() > poor.len());
        for (k, (found, pixel)) in read(&good).pixels().zip(&image.pixels).enumerate() {
            // The border between both halves rings.
            if !(16..32).contains(&(k % 48)) {
                let expected = over_white(*pixel);
                assert!(
                    found.0.iter().zip(expected).all(|(a, b)| a.abs_diff(b) < 8),
                    "{k}: {found:?} {expected:?}"
                );
            }
        }
        assert_eq!(encode_jpeg(&image, 95).unwrap(), good);
    }

    #[test]
    fn what_does_not_fit_is_refused() {
        let image =
            |width, height| DisplayImage { width, height, pixels: vec![[0; 4]; (width * height) as usize] };
        for (image, quality) in
            [(image(0, 3), 90), (image(65536, 1), 90), (image(2, 2), 0), (image(2, 2), 101)]
        {
            encode_jpeg(&image, quality).unwrap_err();
        }
    }
}
