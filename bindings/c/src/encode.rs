//! Encoders: pixels in memory as files of every format that the program writes.

use crate::context::{Inner, overcoat, run};
use crate::raw::{self, Sized32};
use crate::status::{Failure, Status, overcoat_status};
use renderer::frame::{DisplayImage, Frame, PixelFormat};
use renderer::output::{
    DEFAULT_JPEG_QUALITY, ExrPrecision, MovieFormat, MovieFrame, OutputFormat, OutputOptions, durations,
    encode, encode_image, encode_movie, encode_png,
};
use std::ffi::c_char;

/// Pixels to be encoded, and how.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
#[allow(non_camel_case_types)]
pub struct overcoat_encoding {
    /// Size of this structure in bytes, see OVERCOAT_INIT.
    pub size: u32,
    /// The overcoat_pixel_format of the pixels: OVERCOAT_RGBA8 or OVERCOAT_BGRA8 for files of 8 bits, OVERCOAT_RGBA_F32_PREMULTIPLIED for
    /// those of linear light.
    pub pixel_format: u32,
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Bytes from one row to the next; 0: as many as a row takes.
    pub stride: usize,
    /// Name of the file format, as file name extensions have it: "png", "webp", "jpg" or "gif", of 8 bits; "exr" or "hdr", of linear light.
    /// Null: "png".
    pub format: *const c_char,
    /// Quality of JPEG, 1 to 100; 0: 90. JPEG has no transparency: the picture is laid over white.
    pub jpeg_quality: u32,
    /// Numbers of OpenEXR have 32 bits in place of 16. Default false.
    pub full_floats: bool,
}

// SAFETY: begins with its size, and zeros are numbers, `false` and null pointers.
unsafe impl Sized32 for overcoat_encoding {}

/// Pixels of a caller, and what is to be made of them.
struct Asked {
    own: overcoat_encoding,
    pixel_format: PixelFormat,
    row: usize,
    stride: usize,
    /// Bytes of all rows.
    length: usize,
}

impl Asked {
    fn new(own: overcoat_encoding, inner: &Inner) -> Result<Self, Failure> {
        let overcoat_encoding { width, height, .. } = own;
        let pixel_format = PixelFormat::ALL
            .get(own.pixel_format as usize)
            .copied()
            .ok_or_else(|| Failure::argument(format!("pixel_format: {} is not 0 to 6", own.pixel_format)))?;
        let row = width as usize * pixel_format.bytes();
        let stride = if own.stride == 0 { row } else { own.stride };
        let area = u64::from(width) * u64::from(height);
        let length = stride
            .checked_mul((height as usize).saturating_sub(1))
            .and_then(|before| before.checked_add(row))
            .filter(|_| area > 0 && stride >= row && area <= inner.limits.output_pixels);
        let length = length.ok_or_else(|| {
            Failure::argument(format!("{width} x {height} pixels in rows of {stride} bytes are no picture"))
        })?;
        Ok(Self { own, pixel_format, row, stride, length })
    }

    /// # Safety
    /// As in [`raw`].
    unsafe fn read(pointer: *const overcoat_encoding, inner: &Inner) -> Result<Self, Failure> {
        // SAFETY: of the caller.
        let own = unsafe { raw::structure(pointer) };
        Self::new(own.ok_or_else(|| Failure::argument("encoding: null, or its size is not set"))?, inner)
    }

    /// # Safety
    /// As in [`raw`].
    unsafe fn bytes<'a>(&self, pixels: *const u8) -> Result<&'a [u8], Failure> {
        // SAFETY: of the caller.
        let all = unsafe { raw::slice(pixels, self.length) };
        all.ok_or_else(|| Failure::argument("pixels: null, or too long"))
    }

    /// Name of the file format.
    ///
    /// # Safety
    /// As in [`raw`].
    unsafe fn format(&self) -> Result<&str, Failure> {
        if self.own.format.is_null() {
            return Ok("png");
        }
        // SAFETY: of the caller.
        unsafe { raw::text(self.own.format) }.ok_or_else(|| Failure::argument("format: no UTF-8"))
    }

    fn misfit(&self, format: &str) -> Failure {
        let wanted = if matches!(format, "exr" | "hdr") {
            "OVERCOAT_RGBA_F32_PREMULTIPLIED"
        } else {
            "OVERCOAT_RGBA8 or OVERCOAT_BGRA8"
        };
        Failure::argument(format!("pixel_format: {} for {format}, expected {wanted}", self.own.pixel_format))
    }

    /// As a picture of 8 bits.
    fn image(&self, bytes: &[u8], format: &str) -> Result<DisplayImage, Failure> {
        let order: fn(&[u8; 4]) -> [u8; 4] = match self.pixel_format {
            PixelFormat::Rgba8 => |pixel| *pixel,
            PixelFormat::Bgra8 => |[b, g, r, a]| [*r, *g, *b, *a],
            _ => return Err(self.misfit(format)),
        };
        let rows = bytes.chunks(self.stride).flat_map(|row| row[..self.row].as_chunks::<4>().0);
        Ok(DisplayImage { width: self.own.width, height: self.own.height, pixels: rows.map(order).collect() })
    }

    /// As a picture of linear light.
    fn frame(&self, bytes: &[u8], format: &str) -> Result<Frame, Failure> {
        if self.pixel_format != PixelFormat::RgbaF32Premultiplied {
            return Err(self.misfit(format));
        }
        let rows = bytes.chunks(self.stride).flat_map(|row| row[..self.row].as_chunks::<16>().0);
        let pixels: Vec<[f32; 4]> = rows
            .map(|pixel| {
                let (words, _) = pixel.as_chunks::<4>();
                std::array::from_fn(|k| words.get(k).map_or(0.0, |word| f32::from_ne_bytes(*word)))
            })
            .collect();
        if !pixels.as_flattened().iter().all(|v| v.is_finite()) {
            return Err(Failure::new(Status::OVERCOAT_OUT_OF_RANGE, "pixels: a number is not finite"));
        }
        let (width, height) = (self.own.width, self.own.height);
        Ok(Frame { width, height, pixels, transmittance: Vec::new(), aovs: Vec::new() })
    }

    /// The bytes of a file.
    fn encoded(&self, bytes: &[u8], format: &str) -> Result<Vec<u8>, Failure> {
        let mut options = OutputOptions::default().with_jpeg_quality(match self.own.jpeg_quality {
            0 => DEFAULT_JPEG_QUALITY,
            quality @ 1..=100 => quality as u8,
            other => {
                let message = format!("jpeg_quality: {other} is not 0 to 100");
                return Err(Failure::new(Status::OVERCOAT_OUT_OF_RANGE, message));
            }
        });
        if self.own.full_floats {
            options = options.with_exr_precision(ExrPrecision::Float);
        }
        match OutputFormat::from_extension(format) {
            Some(linear) if linear.is_linear() => Ok(encode(&self.frame(bytes, format)?, linear, &options)?),
            Some(shown) => Ok(encode_image(&self.image(bytes, format)?, shown, &options)?),
            None if format.eq_ignore_ascii_case("gif") => {
                let frame = MovieFrame::new(&self.image(bytes, format)?, MovieFormat::Gif, false)?;
                Ok(encode_movie(&[frame], &[100])?)
            }
            None => Err(Failure::argument(format!(
                "format: '{format}' is not one of png, webp, jpg, gif, exr, hdr"
            ))),
        }
    }
}

/// Hands bytes out.
///
/// # Safety
/// As in [`raw`].
unsafe fn hand_out(
    encoded: impl FnOnce() -> Result<Vec<u8>, Failure>,
    bytes_out: *mut *mut u8,
    length_out: *mut usize,
) -> Result<(), Failure> {
    if bytes_out.is_null() || length_out.is_null() {
        return Err(Failure::argument("bytes_out or length_out: null"));
    }
    let encoded = encoded()?.into_boxed_slice();
    // SAFETY: of the caller.
    unsafe {
        raw::write(length_out, encoded.len());
        raw::write(bytes_out, raw::give(encoded));
    }
    Ok(())
}

/// Encodes pixels as a file of a format. `bytes_out` is to be given to overcoat_bytes_free().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn overcoat_encode(
    overcoat: *mut overcoat,
    pixels: *const std::ffi::c_void,
    encoding: *const overcoat_encoding,
    bytes_out: *mut *mut u8,
    length_out: *mut usize,
) -> overcoat_status {
    // SAFETY: of the caller.
    unsafe {
        run(overcoat, |inner, _| {
            let asked = Asked::read(encoding, inner)?;
            let (bytes, format) = (asked.bytes(pixels.cast())?, asked.format()?);
            hand_out(|| asked.encoded(bytes, format), bytes_out, length_out)
        })
    }
}

/// Encodes pictures of 8 bits and one size as a moving picture that begins again and again: "png" (animated), "webp" or "gif".
/// `pixels` points to the first pixel of each of `count` pictures, all as `encoding` says; each is shown for 1 / `frames_per_second` s.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn overcoat_encode_movie(
    overcoat: *mut overcoat,
    pixels: *const *const std::ffi::c_void,
    count: usize,
    encoding: *const overcoat_encoding,
    frames_per_second: f64,
    bytes_out: *mut *mut u8,
    length_out: *mut usize,
) -> overcoat_status {
    // SAFETY: of the caller.
    unsafe {
        run(overcoat, |inner, _| {
            let asked = Asked::read(encoding, inner)?;
            let name = asked.format()?;
            let format = MovieFormat::from_extension(name).ok_or_else(|| {
                Failure::argument(format!(
                    "format: '{name}' is not one of png, webp, gif, of which pictures move"
                ))
            })?;
            if !(0.01..=1000.0).contains(&frames_per_second) {
                let message = format!("frames_per_second: {frames_per_second} is not 0.01 to 1000");
                return Err(Failure::new(Status::OVERCOAT_OUT_OF_RANGE, message));
            }
            if count as u64 > inner.limits.frames {
                let message = format!("{count} pictures are more than {} frames", inner.limits.frames);
                return Err(Failure::new(Status::OVERCOAT_LIMIT, message));
            }
            let all = raw::slice(pixels, count).filter(|all| !all.is_empty());
            let all = all.ok_or_else(|| Failure::argument("pixels: null, or no pictures"))?;
            let mut images = Vec::with_capacity(count);
            for one in all {
                images.push(asked.image(asked.bytes(one.cast())?, name)?);
            }
            let is_clear = !images.iter().all(DisplayImage::is_opaque);
            let encoded = || {
                let frames: Vec<MovieFrame> = images
                    .iter()
                    .map(|image| MovieFrame::new(image, format, is_clear))
                    .collect::<Result<_, _>>()?;
                Ok(encode_movie(&frames, &durations(count, frames_per_second))?)
            };
            hand_out(encoded, bytes_out, length_out)
        })
    }
}

/// Encodes pixels in OVERCOAT_RGBA8 as PNG, for thumbnails in files. `bytes_out` is to be given to overcoat_bytes_free().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn overcoat_encode_png(
    overcoat: *mut overcoat,
    pixels: *const u8,
    width: u32,
    height: u32,
    stride: usize,
    bytes_out: *mut *mut u8,
    length_out: *mut usize,
) -> overcoat_status {
    // SAFETY: of the caller.
    unsafe {
        run(overcoat, |inner, _| {
            let encoding = overcoat_encoding { width, height, stride, ..Sized32::defaults() };
            let asked = Asked::new(encoding, inner)?;
            let bytes = asked.bytes(pixels)?;
            hand_out(|| Ok(encode_png(&asked.image(bytes, "png")?)?), bytes_out, length_out)
        })
    }
}

/// Frees what overcoat_encode(), overcoat_encode_movie() or overcoat_encode_png() has made, of the length that it said. Null is left alone.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn overcoat_bytes_free(bytes: *mut u8, length: usize) {
    // SAFETY: of the caller.
    unsafe { raw::take_back(bytes, length) }
}
