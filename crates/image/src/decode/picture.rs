//! Picture files of any renderer, decoded without loss.

use super::exr_samples::{ExrPlane, ExrSamples};
#[cfg(any(feature = "textures", feature = "more-textures"))]
use super::motion::read_frames;
use super::motion::{Motion, read_apng};
use super::png::{BYTES_PER_PIXEL, read_png};
use super::{DecodeError, plain, radiance, read_exr_planes};
use image::ImageDecoder;
#[cfg(feature = "more-textures")]
use image::codecs::gif::GifDecoder;
use image::codecs::jpeg::JpegDecoder;
#[cfg(feature = "textures")]
use image::codecs::webp::WebPDecoder;
use overcoat_core::files::read_file;
use overcoat_core::formats::{self, FileFormat};
use overcoat_core::frame::DisplayImage;
use overcoat_core::limits::Limits;
use std::fmt;
use std::io::Cursor;
use std::path::Path;

/// Formats of the files that are compared. Which a file has, its content tells.
pub const FORMATS: &[FileFormat] = &[
    formats::PNG,
    formats::APNG,
    formats::WEBP,
    formats::GIF,
    formats::JPEG,
    formats::BMP,
    formats::TGA,
    formats::TIFF,
    formats::PNM,
    formats::QOI,
    formats::EXR,
    formats::HDR,
];

/// Extensions of the files that are compared, in lower case.
pub fn extensions() -> impl Iterator<Item = &'static str> {
    let all = FORMATS.iter().flat_map(|format| format.extensions).copied();
    // Moving pictures have those of still ones too.
    all.enumerate()
        .filter(|(k, e)| !FORMATS.iter().flat_map(|f| f.extensions).take(*k).any(|x| x == e))
        .map(|(_, e)| e)
}

/// Format of the samples of a picture, as stored in its file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum SampleKind {
    /// 8-bit codes of PNG (fewer bits are widened), WebP, GIF, JPEG, BMP, TGA, TIFF, Netpbm or QOI, taken as sRGB.
    Unsigned8,
    /// 16-bit codes of PNG, TIFF or Netpbm, taken as sRGB.
    Unsigned16,
    /// 16-bit floats of OpenEXR, linear.
    Half,
    /// 32-bit floats of OpenEXR or TIFF, linear.
    Float,
    /// Mantissas with a common exponent of Radiance files, linear.
    Rgbe,
}

impl SampleKind {
    /// The number that stands for white: 255, 65535, or 1 for linear light.
    #[must_use]
    pub fn white(self) -> f32 {
        match self {
            Self::Unsigned8 => 255.0,
            Self::Unsigned16 => 65535.0,
            Self::Half | Self::Float | Self::Rgbe => 1.0,
        }
    }

    /// True for linear light without an upper end; false for display codes.
    #[must_use]
    pub fn is_linear(self) -> bool {
        matches!(self, Self::Half | Self::Float | Self::Rgbe)
    }
}

impl fmt::Display for SampleKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Unsigned8 => "8 bits",
            Self::Unsigned16 => "16 bits",
            Self::Half => "half floats",
            Self::Float => "floats",
            Self::Rgbe => "RGBE",
        })
    }
}

/// A picture with all that its file stores.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct DecodedPicture {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Format of the stored samples.
    pub kind: SampleKind,
    /// RGBA row by row from the top, of moving pictures those of the first frame, 0 to [`SampleKind::white`] (colours of linear pictures have no upper end).
    /// Straight alpha in PNG, WebP and GIF, premultiplied in OpenEXR, always 1 in Radiance files.
    pub pixels: Vec<[f32; 4]>,
    /// Channels of OpenEXR that are not part of `pixels`, by name.
    pub planes: Vec<ExrPlane>,
    /// All frames, if it moves.
    pub motion: Option<Motion>,
}

impl From<&DisplayImage> for DecodedPicture {
    fn from(image: &DisplayImage) -> Self {
        let pixels = image.pixels.iter().map(|p| p.map(f32::from)).collect();
        Self::still([image.width, image.height], SampleKind::Unsigned8, pixels)
    }
}

/// Reads a still file of one of [`FORMATS`] as a picture for screens: 8 bits, straight alpha, taken as sRGB. 16 bits are
/// cut to 8.
///
/// # Errors
/// [`DecodeError`] as [`DecodedPicture::from_bytes`], and [`DecodeError::Unsupported`] if it moves or holds linear light.
pub fn read_display_image(bytes: &[u8], limits: &Limits) -> Result<DisplayImage, DecodeError> {
    let picture = DecodedPicture::from_bytes(bytes, limits)?;
    let format = "a picture for screens";
    if picture.motion.is_some() {
        return Err(DecodeError::unsupported(format, "an animation, where a still picture is wanted"));
    }
    if picture.kind.is_linear() {
        return Err(DecodeError::unsupported(format, "linear light, where display codes are wanted"));
    }
    let deep = picture.kind == SampleKind::Unsigned16;
    let code = |v: f32| if deep { (v as u16 >> 8) as u8 } else { v as u8 };
    let pixels = picture.pixels.iter().map(|p| p.map(code)).collect();
    Ok(DisplayImage { width: picture.width, height: picture.height, pixels })
}

impl DecodedPicture {
    /// Reads and decodes a file.
    ///
    /// # Errors
    /// [`DecodeError`] if that is not possible within the limits.
    pub fn open(path: &Path, limits: &Limits) -> Result<Self, DecodeError> {
        Self::from_bytes(&read_file(path, limits)?, limits)
    }

    /// Decodes a PNG, WebP, GIF (all animated or not), JPEG, BMP, TGA, TIFF, Netpbm, QOI, OpenEXR or Radiance file; its bytes say
    /// which it is.
    ///
    /// # Errors
    /// [`DecodeError`] if it is none of them, is damaged, or asks for more than the limits allow.
    pub fn from_bytes(bytes: &[u8], limits: &Limits) -> Result<Self, DecodeError> {
        if bytes.starts_with(b"\x89PNG") {
            match read_apng(bytes, limits)? {
                Some(moving) => Ok(moving),
                None => decode_png(bytes, limits),
            }
        } else if bytes.starts_with(b"\xff\xd8\xff") {
            decode_image(JpegDecoder::new(Cursor::new(bytes)).map_err(damaged("JPEG"))?, "JPEG", limits)
        } else if bytes.starts_with(b"RIFF") && bytes.get(8..12) == Some(b"WEBP") {
            decode_webp(bytes, limits)
        } else if bytes.starts_with(b"GIF8") {
            decode_gif(bytes, limits)
        } else if bytes.starts_with(&[0x76, 0x2f, 0x31, 0x01]) {
            let picture = read_exr_planes(bytes, limits)?;
            Ok(from_planes(picture.width, picture.height, picture.planes))
        } else if bytes.starts_with(b"#?") {
            let (width, height, pixels) = radiance::read(bytes, limits)?;
            let pixels = pixels.into_iter().map(|[r, g, b]| [r, g, b, 1.0]).collect();
            Ok(Self::still([width, height], SampleKind::Rgbe, pixels))
        } else {
            plain::read(bytes, limits)
        }
    }

    /// A picture of which nothing moves and that has no further channels.
    #[must_use]
    pub fn still([width, height]: [u32; 2], kind: SampleKind, pixels: Vec<[f32; 4]>) -> Self {
        Self { width, height, kind, pixels, planes: Vec::new(), motion: None }
    }

    /// True if some pixel is not opaque.
    #[must_use]
    pub fn is_translucent(&self) -> bool {
        let opaque = self.kind.white();
        self.pixels.iter().any(|pixel| pixel[3] != opaque)
    }
}

fn damaged(format: &'static str) -> impl Fn(image::ImageError) -> DecodeError {
    move |error| DecodeError::malformed(format, error.to_string())
}

/// Refuses what would take more memory than the limits allow: numbers of 32 bits, and the decoder's own pixels.
fn check_size(kind: &str, [width, height]: [u32; 2], limits: &Limits) -> Result<(), DecodeError> {
    let what = || format!("{kind} of {width} x {height} pixels");
    let pixels = u64::from(width).saturating_mul(height.into());
    Limits::check(what, pixels, limits.texture_pixels, "texture_pixels")?;
    Ok(Limits::check(what, pixels.saturating_mul(BYTES_PER_PIXEL), limits.decoded_bytes, "decoded_bytes")?)
}

/// A still picture of 8 bits.
fn decode_image(
    decoder: impl ImageDecoder,
    kind: &'static str,
    limits: &Limits,
) -> Result<DecodedPicture, DecodeError> {
    let (width, height) = decoder.dimensions();
    check_size(kind, [width, height], limits)?;
    let image = image::DynamicImage::from_decoder(decoder).map_err(damaged(kind))?.into_rgba8();
    let pixels = image.pixels().map(|p| p.0.map(f32::from)).collect();
    Ok(DecodedPicture::still([width, height], SampleKind::Unsigned8, pixels))
}

#[cfg(not(feature = "more-textures"))]
fn decode_gif(_: &[u8], _: &Limits) -> Result<DecodedPicture, DecodeError> {
    Err(DecodeError::unsupported("GIF", formats::LEFT_OUT))
}

/// A GIF of one frame is a still picture: the format has no other.
#[cfg(feature = "more-textures")]
fn decode_gif(bytes: &[u8], limits: &Limits) -> Result<DecodedPicture, DecodeError> {
    let mut decoder = GifDecoder::new(Cursor::new(bytes)).map_err(damaged("GIF"))?;
    let (width, height) = decoder.dimensions();
    check_size("GIF", [width, height], limits)?;
    let mut memory = image::Limits::no_limits();
    memory.max_alloc = Some(limits.decoded_bytes);
    decoder.set_limits(memory).map_err(damaged("GIF"))?;
    let mut picture = read_frames("GIF", [width, height], decoder, limits)?;
    match &mut picture.motion {
        Some(motion) if motion.frames.len() > 1 => {
            // The decoder knows it only after the first frame.
            motion.plays = gif_plays(bytes);
            Ok(picture)
        }
        _ => Ok(picture.frame(0)),
    }
}

/// Number of times that a GIF plays, by the extension that says so: 0 for ever, once where it is not there.
#[cfg(feature = "more-textures")]
fn gif_plays(bytes: &[u8]) -> u32 {
    const EXTENSION: &[u8; 13] = b"NETSCAPE2.0\x03\x01";
    let found = bytes.windows(15).find(|window| window.starts_with(EXTENSION));
    match found {
        Some(&[.., low, high]) => u16::from_le_bytes([low, high]).into(),
        _ => 1,
    }
}

#[cfg(not(feature = "textures"))]
fn decode_webp(_: &[u8], _: &Limits) -> Result<DecodedPicture, DecodeError> {
    Err(DecodeError::unsupported("WebP", formats::LEFT_OUT))
}

#[cfg(feature = "textures")]
fn decode_webp(bytes: &[u8], limits: &Limits) -> Result<DecodedPicture, DecodeError> {
    let decoder = WebPDecoder::new(Cursor::new(bytes)).map_err(damaged("WebP"))?;
    let (width, height) = decoder.dimensions();
    check_size("WebP", [width, height], limits)?;
    if decoder.has_animation() {
        return read_frames("animated WebP", [width, height], decoder, limits);
    }
    decode_image(decoder, "WebP", limits)
}

fn decode_png(bytes: &[u8], limits: &Limits) -> Result<DecodedPicture, DecodeError> {
    let png = read_png(bytes, limits)?;
    let kind = if png.is_16_bit { SampleKind::Unsigned16 } else { SampleKind::Unsigned8 };
    let pixels = png.samples.iter().map(|p| p.map(f32::from)).collect();
    Ok(DecodedPicture::still([png.width, png.height], kind, pixels))
}

/// Takes the colours out of the channels of an OpenEXR file.
fn from_planes(width: u32, height: u32, mut planes: Vec<ExrPlane>) -> DecodedPicture {
    let chosen = colour_planes(&planes);
    let count = (width as usize).saturating_mul(height as usize);
    let mut pixels = vec![[0.0, 0.0, 0.0, 1.0]; count];
    let mut kind = SampleKind::Half;
    for (channel, place) in chosen.iter().enumerate() {
        let Some(plane) = place.and_then(|place| planes.get(place)) else { continue };
        let targets = pixels.iter_mut().filter_map(|pixel| pixel.get_mut(channel));
        match &plane.samples {
            ExrSamples::Half(samples) => targets.zip(samples).for_each(|(to, &v)| *to = v),
            ExrSamples::Float(samples) => {
                kind = SampleKind::Float;
                targets.zip(samples).for_each(|(to, &v)| *to = v);
            }
            // Integers are compared exactly among the planes; here they are only looked at.
            ExrSamples::Unsigned(samples) => targets.zip(samples).for_each(|(to, &v)| *to = v as f32),
        }
    }
    let mut places = 0_usize..;
    planes.retain(|plane| {
        let place = places.next();
        let is_colour = place.is_some() && chosen.contains(&place);
        !is_colour || matches!(plane.samples, ExrSamples::Unsigned(_))
    });
    planes.sort_by(|a, b| a.name.cmp(&b.name));
    DecodedPicture { planes, ..DecodedPicture::still([width, height], kind, pixels) }
}

/// Indices of the red, green, blue and alpha planes: those of the first layer that has colours, of the unnamed layer
/// before others; else its luminance; else the first plane of all.
fn colour_planes(planes: &[ExrPlane]) -> [Option<usize>; 4] {
    let parts = |plane: &'_ ExrPlane| -> (String, String) {
        let (layer, channel) = plane.name.rsplit_once('.').unwrap_or(("", &plane.name));
        (layer.to_owned(), channel.to_ascii_uppercase())
    };
    let mut layers: Vec<String> = vec![String::new()];
    layers.extend(planes.iter().map(|p| parts(p).0));
    layers.dedup();
    for wanted in [["R", "G", "B", "A"], ["Y", "Y", "Y", "A"]] {
        for layer in &layers {
            let find = |channel: &str| {
                planes.iter().position(|plane| {
                    let (l, c) = parts(plane);
                    l == *layer && c == channel
                })
            };
            let found = wanted.map(find);
            if let [Some(_), Some(_), Some(_), _] = found {
                return found;
            }
        }
    }
    let first = (!planes.is_empty()).then_some(0);
    [first, first, first, None]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::{ExrPrecision, encode_exr, encode_hdr, encode_png};
    use overcoat_core::frame::{Aov, AovPlane, Frame};

    fn png(color: png::ColorType, depth: png::BitDepth, data: &[u8]) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, 2, 1);
        encoder.set_color(color);
        encoder.set_depth(depth);
        encoder.write_header().unwrap().write_image_data(data).unwrap();
        bytes
    }

    #[test]
    fn png_of_8_and_16_bits() {
        use png::{BitDepth, ColorType};
        let read = |bytes: &[u8]| DecodedPicture::from_bytes(bytes, &Limits::default()).unwrap();
        let grey = read(&png(ColorType::Grayscale, BitDepth::Eight, &[7, 255]));
        assert_eq!(grey.pixels, [[7.0, 7.0, 7.0, 255.0], [255.0; 4]]);
        assert!(!grey.is_translucent());
        let deep = [0x12, 0x34, 0, 1, 0xff, 0xff, 0x80, 0, 0, 0, 0, 0, 0, 0, 0xff, 0xff];
        let deep = read(&png(ColorType::Rgba, BitDepth::Sixteen, &deep));
        assert_eq!(deep.kind, SampleKind::Unsigned16);
        assert_eq!(deep.pixels[0], [4660.0, 1.0, 65535.0, 32768.0]);
        assert!(deep.is_translucent());
    }

    #[test]
    fn pictures_for_screens_come_back_and_nothing_else_does() {
        let limits = Limits::default();
        let pixels =
            (0..13 * 7_u32).map(|k| [k as u8, (k * 3) as u8, 255 - k as u8, (k * 5) as u8]).collect();
        let image = DisplayImage { width: 13, height: 7, pixels };
        let bytes = encode_png(&image).unwrap();
        assert_eq!(read_display_image(&bytes, &limits).unwrap(), image);
        assert_eq!(DecodedPicture::from(&image), DecodedPicture::from_bytes(&bytes, &limits).unwrap());
        for length in 0..bytes.len() - 12 {
            assert!(
                read_display_image(&bytes[..length], &limits).is_err(),
                "{length} of {} bytes",
                bytes.len()
            );
        }
        for limits in [limits.clone().with_texture_pixels(90), limits.clone().with_decoded_bytes(91 * 24 - 1)]
        {
            assert!(matches!(read_display_image(&bytes, &limits), Err(DecodeError::Limit(_))));
        }
        let deep = [0x12, 0x34, 0, 255, 0xff, 0xff, 0x80, 0, 0, 0, 0, 0, 0, 0, 0xff, 0xff];
        let deep = png(png::ColorType::Rgba, png::BitDepth::Sixteen, &deep);
        assert_eq!(read_display_image(&deep, &limits).unwrap().pixels[0], [0x12, 0, 255, 128]);
        let frame = Frame {
            width: 1,
            height: 1,
            pixels: vec![[1.0; 4]],
            transmittance: Vec::new(),
            aovs: Vec::new(),
        };
        let linear = encode_hdr(&frame).unwrap();
        assert!(matches!(read_display_image(&linear, &limits), Err(DecodeError::Unsupported { .. })));
    }

    #[test]
    fn linear_pictures_with_their_other_channels() {
        let pixels = vec![[0.25, 3.0, -1.0, 0.5]; 4];
        let aovs = vec![AovPlane { aov: Aov::Depth, data: vec![1.0, 2.0, 3.0, 4.0], ids: Vec::new() }];
        let frame = Frame { width: 2, height: 2, pixels, transmittance: Vec::new(), aovs };
        for (precision, kind) in
            [(ExrPrecision::Half, SampleKind::Half), (ExrPrecision::Float, SampleKind::Float)]
        {
            let bytes = encode_exr(&frame, precision).unwrap();
            let picture = DecodedPicture::from_bytes(&bytes, &Limits::default()).unwrap();
            assert_eq!((picture.kind, picture.pixels[3]), (kind, [0.25, 3.0, -1.0, 0.5]));
            assert_eq!(picture.planes.len(), 1);
            assert_eq!(picture.planes[0].samples, ExrSamples::Float(vec![1.0, 2.0, 3.0, 4.0]));
        }
        let picture = DecodedPicture::from_bytes(&encode_hdr(&frame).unwrap(), &Limits::default()).unwrap();
        assert_eq!((picture.kind, picture.pixels[0][3]), (SampleKind::Rgbe, 1.0));
    }

    #[test]
    fn what_a_header_claims_costs_nothing() {
        let mut bytes = png(png::ColorType::Grayscale, png::BitDepth::Eight, &[0, 0]);
        bytes[16..24].copy_from_slice(&[0x7f, 0xff, 0xff, 0xff, 0x7f, 0xff, 0xff, 0xff]);
        // The header's checksum must fit, or it is not believed in the first place.
        let checksum = crc32(&bytes[12..29]);
        bytes[29..33].copy_from_slice(&checksum.to_be_bytes());
        let error = DecodedPicture::from_bytes(&bytes, &Limits::default()).unwrap_err();
        assert!(matches!(error, DecodeError::Limit(_)), "{error}");
        for bytes in [&b""[..], b"\x89PNG", b"#?", b"GIF89a", &[0x76, 0x2f, 0x31, 0x01]] {
            assert!(DecodedPicture::from_bytes(bytes, &Limits::default()).is_err());
        }
    }

    fn crc32(bytes: &[u8]) -> u32 {
        !bytes.iter().fold(u32::MAX, |crc, &byte| {
            (0..8).fold(crc ^ u32::from(byte), |c, _| if c & 1 == 1 { c >> 1 ^ 0xedb8_8320 } else { c >> 1 })
        })
    }
}
