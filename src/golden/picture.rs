//! The pictures of goldens.

use crate::frame::DisplayImage;
use std::io::Cursor;

/// An 8-bit sRGB picture with straight alpha, row by row from the top.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// RGBA, `width * height` of them.
    pub pixels: Vec<[u8; 4]>,
}

impl From<DisplayImage> for Picture {
    fn from(image: DisplayImage) -> Self {
        Self { width: image.width, height: image.height, pixels: image.pixels }
    }
}

impl Picture {
    /// The picture as a PNG file, RGBA, tagged as sRGB.
    ///
    /// # Errors
    /// What is wrong, if a side is 0 or the number of pixels does not fit.
    pub fn to_png(&self) -> Result<Vec<u8>, String> {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, self.width, self.height);
        encoder.set_color(png::ColorType::Rgba);
        encoder.set_depth(png::BitDepth::Eight);
        // Goldens live in a repository: smaller is better than faster.
        encoder.set_compression(png::Compression::High);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        let mut writer = encoder.write_header().map_err(|e| e.to_string())?;
        writer.write_image_data(self.pixels.as_flattened()).map_err(|e| e.to_string())?;
        writer.finish().map_err(|e| e.to_string())?;
        Ok(bytes)
    }

    /// Reads a PNG file of any 8-bit kind (16 bits are cut to 8).
    ///
    /// # Errors
    /// What is wrong with the file.
    pub fn from_png(bytes: &[u8]) -> Result<Self, String> {
        let mut decoder = png::Decoder::new(Cursor::new(bytes));
        decoder
            .set_transformations(png::Transformations::normalize_to_color8() | png::Transformations::ALPHA);
        let mut reader = decoder.read_info().map_err(|e| e.to_string())?;
        if reader.info().animation_control().is_some() {
            return Err("it is an animation, and a still picture is wanted".to_owned());
        }
        let size = reader.output_buffer_size().ok_or("too large")?;
        let mut data = vec![0; size];
        let info = reader.next_frame(&mut data).map_err(|e| e.to_string())?;
        let data = &data[..info.buffer_size()];
        let pixels = match info.color_type {
            png::ColorType::Rgba => data.as_chunks::<4>().0.to_vec(),
            png::ColorType::GrayscaleAlpha => {
                data.as_chunks::<2>().0.iter().map(|&[v, a]| [v, v, v, a]).collect()
            }
            png::ColorType::Rgb => data.as_chunks::<3>().0.iter().map(|&[r, g, b]| [r, g, b, 255]).collect(),
            png::ColorType::Grayscale => data.iter().map(|&v| [v, v, v, 255]).collect(),
            png::ColorType::Indexed => return Err("palette was not expanded".to_owned()),
        };
        Ok(Self { width: info.width, height: info.height, pixels })
    }

    /// The pixel in column x of row y; transparent black outside.
    #[must_use]
    pub fn pixel(&self, x: u32, y: u32) -> [u8; 4] {
        if x >= self.width {
            return [0; 4];
        }
        let at = y as usize * self.width as usize + x as usize;
        self.pixels.get(at).copied().unwrap_or([0; 4])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn png_round_trip() {
        let pixels =
            (0..13 * 7_u32).map(|k| [k as u8, (k * 3) as u8, 255 - k as u8, (k * 5) as u8]).collect();
        let picture = Picture { width: 13, height: 7, pixels };
        assert_eq!(Picture::from_png(&picture.to_png().unwrap()).unwrap(), picture);
        assert_eq!(picture.pixel(12, 6), picture.pixels[90]);
        assert_eq!((picture.pixel(13, 0), picture.pixel(0, 7)), ([0; 4], [0; 4]));
    }

    #[test]
    fn malformed_files_are_errors() {
        let bytes = Picture { width: 2, height: 2, pixels: vec![[7; 4]; 4] }.to_png().unwrap();
        for len in 0..bytes.len() - 12 {
            assert!(Picture::from_png(&bytes[..len]).is_err(), "{len} of {} bytes", bytes.len());
        }
        assert!(Picture { width: 0, height: 2, pixels: Vec::new() }.to_png().is_err());
    }
}
