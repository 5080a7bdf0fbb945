//! Pictures in memory that belongs to the caller: a window's buffer, an image of another library, a part of either.

use super::{Developer, DisplayImage, Frame};
use crate::math::lanes::Lanes;

/// Layout of a pixel in memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum PixelFormat {
    /// Bytes R, G, B, A: sRGB with straight alpha, as [`DisplayImage`] has them.
    Rgba8,
    /// The same with R, G and B multiplied by alpha as they are encoded, which is what canvases and compositors mix.
    Rgba8Premultiplied,
    /// Bytes B, G, R, A: sRGB with straight alpha.
    Bgra8,
    /// The same with B, G and R multiplied by alpha as they are encoded: `ARGB32` of Cairo and Qt on little-endian machines.
    Bgra8Premultiplied,
    /// A number of 32 bits in the machine's own order, 0x00RRGGBB, as windows take it. There is no alpha: without a
    /// [`background`](super::DisplayOptions::background) what is behind the picture is black.
    Xrgb8,
    /// Four floats in the machine's own order: linear light with straight alpha, colours 0 where alpha is 0. Exposure, tone curve
    /// and background of a screen do not apply.
    RgbaF32,
    /// The same with colours multiplied by alpha: the pixels of a [`Frame`].
    RgbaF32Premultiplied,
}

impl PixelFormat {
    /// All of them.
    pub const ALL: &'static [Self] = &[
        Self::Rgba8,
        Self::Rgba8Premultiplied,
        Self::Bgra8,
        Self::Bgra8Premultiplied,
        Self::Xrgb8,
        Self::RgbaF32,
        Self::RgbaF32Premultiplied,
    ];

    /// Its name, in small letters.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Rgba8 => "rgba8",
            Self::Rgba8Premultiplied => "rgba8-premultiplied",
            Self::Bgra8 => "bgra8",
            Self::Bgra8Premultiplied => "bgra8-premultiplied",
            Self::Xrgb8 => "xrgb8",
            Self::RgbaF32 => "rgba-f32",
            Self::RgbaF32Premultiplied => "rgba-f32-premultiplied",
        }
    }

    /// The one of that name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|format| format.name() == name)
    }

    /// Bytes of a pixel: 4 or 16.
    #[must_use]
    pub const fn bytes(self) -> usize {
        if self.is_linear() { 16 } else { 4 }
    }

    /// True if it holds linear light, not display light.
    #[must_use]
    pub const fn is_linear(self) -> bool {
        matches!(self, Self::RgbaF32 | Self::RgbaF32Premultiplied)
    }
}

/// Memory that a picture, or a part of one, is drawn into.
///
/// Rows lie `stride` bytes apart, from the top; bytes between them are left alone. It need not be aligned.
#[derive(Debug)]
pub struct Target<'a> {
    bytes: &'a mut [u8],
    stride: usize,
    format: PixelFormat,
    /// Left and top pixel of the part that it holds, and its width and height.
    region: Option<[u32; 4]>,
}

impl<'a> Target<'a> {
    /// Memory of a format whose rows lie `stride` bytes apart. Whether it is large enough is said when a picture is drawn.
    #[must_use]
    pub fn new(bytes: &'a mut [u8], stride: usize, format: PixelFormat) -> Self {
        Self { bytes, stride, format, region: None }
    }

    /// Holds a part of the picture alone: from column `left` and row `top` on, `width` times `height` pixels. The first byte is
    /// that of the part's first pixel. The pixels are those that the whole picture has there.
    #[must_use]
    pub fn with_region(self, left: u32, top: u32, width: u32, height: u32) -> Self {
        Self { region: Some([left, top, width, height]), ..self }
    }

    /// Layout of its pixels.
    #[must_use]
    pub fn format(&self) -> PixelFormat {
        self.format
    }

    /// The memory, and the bytes from one row to the next.
    pub fn memory(&mut self) -> (&mut [u8], usize) {
        (self.bytes, self.stride)
    }

    /// Pixel format and region: targets alike in both hold the same bytes of a picture.
    pub fn content(&self) -> (PixelFormat, Option<[u32; 4]>) {
        (self.format, self.region)
    }

    /// The part of a picture of that size that it holds: first column and row, and the ends. An error names the
    /// quantity that does not fit, its value and the range allowed.
    pub fn fit(&self, size: [u32; 2]) -> Result<[u32; 4], (&'static str, String, &'static str)> {
        let [left, top, width, height] = self.region.unwrap_or([0, 0, size[0], size[1]]);
        let ends = [left.checked_add(width), top.checked_add(height)];
        let [Some(right), Some(bottom)] = ends else {
            return Err(("region", format!("{width} x {height} at {left}, {top}"), "within the picture"));
        };
        if width == 0 || height == 0 || right > size[0] || bottom > size[1] {
            let value = format!("{width} x {height} at {left}, {top} of {} x {}", size[0], size[1]);
            return Err(("region", value, "a part of the picture"));
        }
        let row = width as usize * self.format.bytes();
        if self.stride < row {
            let value = format!("{} bytes for rows of {row}", self.stride);
            return Err(("stride", value, "as long as a row"));
        }
        let needed = self.stride.checked_mul(height as usize - 1).and_then(|rows| rows.checked_add(row));
        if needed.is_none_or(|needed| needed > self.bytes.len()) {
            let value = format!("{} bytes for {height} rows of {}", self.bytes.len(), self.stride);
            return Err(("buffer", value, "large enough"));
        }
        Ok([left, top, right, bottom])
    }

    /// The memory of each row of a part that fits.
    pub fn rows(&mut self, [left, top, right, bottom]: [u32; 4]) -> impl Iterator<Item = &mut [u8]> {
        let row = (right - left) as usize * self.format.bytes();
        self.bytes
            .chunks_mut(self.stride.max(1))
            .take((bottom - top) as usize)
            .map(move |bytes| &mut bytes[..row])
    }

    /// Copies the part that it holds of a picture that is whole.
    pub fn copy_from(&mut self, region: [u32; 4], frame: &Frame, image: &DisplayImage) {
        let [left, top, right, _] = region.map(|v| v as usize);
        let format = self.format;
        let (width, columns) = (frame.width as usize, left..right);
        for (y, row) in self.rows(region).enumerate() {
            let first = (top + y) * width;
            let pixels = first + columns.start..first + columns.end;
            if format.is_linear() {
                write_linear(format, &frame.pixels[pixels], row);
            } else {
                row.copy_from_slice(image.pixels[pixels].as_flattened());
                arrange(format, row);
            }
        }
    }
}

/// Conversion of finished tiles to pixels of a target.
#[derive(Clone, Copy, Debug)]
pub struct TargetWriter {
    format: PixelFormat,
    developer: Developer,
}

impl TargetWriter {
    /// Writer for pixels of a format that a developer makes, or that are linear.
    pub fn new(format: PixelFormat, developer: Developer) -> Self {
        Self { format, developer }
    }

    /// Bytes of a pixel.
    pub fn bytes(&self) -> usize {
        self.format.bytes()
    }

    /// Writes pixels as they are in a [`Frame`], with the transmittance of each or none at all, to as many of the target.
    #[inline(always)]
    pub fn write<L: Lanes>(&self, l: L, linear: &[[f32; 4]], open: &[[f32; 3]], row: &mut [u8]) {
        if self.format.is_linear() {
            return write_linear(self.format, linear, row);
        }
        self.developer.develop(l, linear, open, bytemuck::cast_slice_mut(row));
        arrange(self.format, row);
    }

    /// Writes pixels that nothing covers.
    pub fn write_nothing(&self, row: &mut [u8]) {
        if self.format.is_linear() {
            return row.fill(0);
        }
        for pixel in row.as_chunks_mut::<4>().0 {
            *pixel = self.developer.nothing();
        }
        arrange(self.format, row);
    }
}

/// Linear pixels to bytes.
fn write_linear(format: PixelFormat, linear: &[[f32; 4]], row: &mut [u8]) {
    for (pixel, bytes) in linear.iter().zip(row.as_chunks_mut::<16>().0) {
        let [r, g, b, a] = *pixel;
        let of = match format {
            // Light without coverage has no straight colour.
            PixelFormat::RgbaF32 if a > 0.0 => [r / a, g / a, b / a, a],
            PixelFormat::RgbaF32 => [0.0; 4],
            _ => *pixel,
        };
        *bytes = bytemuck::cast(of.map(f32::to_ne_bytes));
    }
}

/// Bytes R, G, B, A with straight alpha to those of a format of 8 bits, where they are.
fn arrange(format: PixelFormat, row: &mut [u8]) {
    let pixels = row.as_chunks_mut::<4>().0;
    let times = |value: u8, alpha: u8| ((u32::from(value) * u32::from(alpha) + 127) / 255) as u8;
    match format {
        PixelFormat::Rgba8 | PixelFormat::RgbaF32 | PixelFormat::RgbaF32Premultiplied => {}
        PixelFormat::Rgba8Premultiplied => {
            for [r, g, b, a] in pixels {
                (*r, *g, *b) = (times(*r, *a), times(*g, *a), times(*b, *a));
            }
        }
        PixelFormat::Bgra8 => pixels.iter_mut().for_each(|[r, _, b, _]| std::mem::swap(r, b)),
        PixelFormat::Bgra8Premultiplied => {
            for [r, g, b, a] in pixels {
                (*r, *g, *b) = (times(*b, *a), times(*g, *a), times(*r, *a));
            }
        }
        PixelFormat::Xrgb8 => {
            for pixel in pixels {
                let [r, g, b, _] = *pixel;
                *pixel = u32::from_be_bytes([0, r, g, b]).to_ne_bytes();
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn arranged(format: PixelFormat, pixel: [u8; 4]) -> [u8; 4] {
        let mut bytes = pixel;
        arrange(format, &mut bytes);
        bytes
    }

    #[test]
    fn bytes_lie_where_the_format_says() {
        let pixel = [200, 100, 50, 128];
        assert_eq!(arranged(PixelFormat::Rgba8, pixel), pixel);
        assert_eq!(arranged(PixelFormat::Bgra8, pixel), [50, 100, 200, 128]);
        assert_eq!(arranged(PixelFormat::Rgba8Premultiplied, pixel), [100, 50, 25, 128]);
        assert_eq!(arranged(PixelFormat::Bgra8Premultiplied, pixel), [25, 50, 100, 128]);
        assert_eq!(u32::from_ne_bytes(arranged(PixelFormat::Xrgb8, pixel)), 0x00c8_6432);
        for alpha in [0, 255] {
            let kept = if alpha == 0 { [0, 0, 0, 0] } else { [200, 100, 50, 255] };
            assert_eq!(arranged(PixelFormat::Rgba8Premultiplied, [200, 100, 50, alpha]), kept);
        }
    }

    #[test]
    fn linear_light_is_written_with_and_without_alpha_in_it() {
        let pixels = [[0.25, 0.5, 0.0, 0.5], [0.1, 0.0, 0.0, 0.0]];
        let written = |format| {
            let mut row = [0_u8; 32];
            write_linear(format, &pixels, &mut row);
            bytemuck::cast::<_, [[[u8; 4]; 4]; 2]>(row).map(|pixel| pixel.map(f32::from_ne_bytes))
        };
        assert_eq!(written(PixelFormat::RgbaF32Premultiplied), pixels);
        assert_eq!(written(PixelFormat::RgbaF32), [[0.5, 1.0, 0.0, 0.5], [0.0; 4]]);
    }

    #[test]
    fn what_does_not_fit_is_named() {
        let mut bytes = [0; 64];
        let mut what = |stride, region: Option<[u32; 4]>, size| {
            let mut target = Target::new(&mut bytes, stride, PixelFormat::Rgba8);
            target.region = region;
            target.fit(size).map_err(|(what, ..)| what)
        };
        assert_eq!(what(16, None, [4, 4]), Ok([0, 0, 4, 4]));
        // The last row needs no more than its pixels.
        assert_eq!(what(20, None, [4, 3]), Ok([0, 0, 4, 3]));
        assert_eq!(what(20, None, [4, 4]), Err("buffer"));
        assert_eq!(what(15, None, [4, 4]), Err("stride"));
        assert_eq!(what(usize::MAX, None, [4, 4]), Err("buffer"));
        assert_eq!(what(16, Some([1, 2, 3, 2]), [4, 4]), Ok([1, 2, 4, 4]));
        for outside in [[1, 0, 4, 4], [0, 0, 0, 1], [0, 4, 1, 1], [u32::MAX, 0, 2, 1]] {
            assert_eq!(what(16, Some(outside), [4, 4]), Err("region"), "{outside:?}");
        }
    }

    #[test]
    fn names_lead_back() {
        for &format in PixelFormat::ALL {
            assert_eq!(PixelFormat::from_name(format.name()), Some(format));
        }
    }
}
