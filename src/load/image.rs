//! Encoded pictures (PNG, JPEG, WebP, KTX2) to 8-bit RGBA, with their claims checked before anything is allocated.
use super::ktx2;
use crate::formats::{self, FileFormat};
use crate::limits::{LimitExceeded, Limits};
use crate::scene::Image;
use ::image::{ColorType, ImageDecoder, ImageFormat, ImageReader};
use std::io::Cursor;

/// Formats of textures. Which a file has, its content tells.
pub const FORMATS: [FileFormat; 4] = [formats::PNG, formats::JPEG, formats::WEBP, formats::KTX2];

/// Bytes that a decoder may use beside the picture itself.
const DECODER_BYTES: u64 = 64 << 20;

/// What the header of a picture says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Header {
    /// In texels.
    pub width: u32,
    /// In texels.
    pub height: u32,
    /// Bytes per texel while decoding.
    pub transient: u64,
}

impl Header {
    /// Number of texels.
    pub(crate) fn texels(&self) -> u64 {
        area(self.width, self.height)
    }
}

/// Why a picture cannot be used.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum ImageError {
    /// It is damaged or of an unknown kind: one line that says so.
    Damaged(String),
    /// It is no picture of any kind that the formats of models allow.
    NotAnImage,
    /// It is larger than allowed.
    Limit(LimitExceeded),
}

/// What is said of [`ImageError::NotAnImage`].
pub(crate) const NOT_AN_IMAGE: &str = "it is neither PNG nor JPEG nor WebP nor KTX2";

impl ImageError {
    /// For formats that can do without the picture: one line that says why it is lost, or the limit.
    pub(crate) fn loss(self) -> Result<String, LimitExceeded> {
        match self {
            Self::Damaged(message) => Ok(message),
            Self::NotAnImage => Ok(NOT_AN_IMAGE.to_owned()),
            Self::Limit(error) => Err(error),
        }
    }
}

fn damaged(error: impl std::fmt::Display) -> ImageError {
    let line: String = error.to_string().chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
    ImageError::Damaged(line)
}

/// The kind of a picture by its first bytes; what a file says about it is not trusted.
fn format(bytes: &[u8]) -> Result<ImageFormat, ImageError> {
    let known = match bytes {
        [0x89, b'P', b'N', b'G', ..] => ImageFormat::Png,
        [0xff, 0xd8, 0xff, ..] => ImageFormat::Jpeg,
        [b'R', b'I', b'F', b'F', _, _, _, _, b'W', b'E', b'B', b'P', ..] => ImageFormat::WebP,
        [] => return Err(ImageError::Damaged("it is empty".to_owned())),
        [0xab, b'K', b'T', b'X', ..] => {
            return Err(ImageError::Damaged("KTX textures before KTX2 cannot be read".to_owned()));
        }
        _ => return Err(ImageError::NotAnImage),
    };
    Ok(known)
}

fn decoder<'a>(bytes: &'a [u8], max_bytes: u64) -> Result<impl ImageDecoder + 'a, ImageError> {
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format(bytes)?);
    let mut limits = ::image::Limits::no_limits();
    limits.max_alloc = Some(max_bytes.saturating_add(DECODER_BYTES));
    reader.limits(limits);
    reader.into_decoder().map_err(damaged)
}

/// Reads the header only, and checks it against `limits.texture_pixels`. `what` names the picture in the limit's
/// message.
///
/// # Errors
/// [`ImageError`].
pub(crate) fn probe(what: &str, bytes: &[u8], limits: &Limits) -> Result<Header, ImageError> {
    let check = |width: u32, height: u32| {
        let texels = area(width, height);
        let what = || format!("{what} of {width} x {height} texels");
        Limits::check(what, texels, limits.texture_pixels, "texture_pixels").map_err(ImageError::Limit)
    };
    if let Some((width, height)) = png_size(bytes) {
        // The decoder has limits of its own, with other messages.
        check(width, height)?;
    }
    if bytes.starts_with(&ktx2::MAGIC) {
        let ktx2::Ktx2 { width, height, .. } = ktx2::open(bytes).map_err(ImageError::Damaged)?;
        check(width, height)?;
        return Ok(Header { width, height, transient: ktx2::TRANSIENT });
    }
    let decoder = decoder(bytes, limits.decoded_bytes)?;
    let (width, height) = decoder.dimensions();
    if width == 0 || height == 0 {
        return Err(ImageError::Damaged(format!("it has {width} x {height} texels")));
    }
    check(width, height)?;
    Ok(Header { width, height, transient: decoder.color_type().bytes_per_pixel().into() })
}

/// Width and height by the first chunk of a PNG file.
fn png_size(bytes: &[u8]) -> Option<(u32, u32)> {
    let word = |at: usize| bytes.get(at..)?.first_chunk().map(|&word| u32::from_be_bytes(word));
    (bytes.get(12..16)? == b"IHDR").then(|| word(16).zip(word(20))).flatten()
}

/// Decodes a picture whose header has been accepted. 16-bit channels are rounded to 8 bits, grey becomes RGB, what
/// has no alpha is opaque. Colour profiles, gamma and orientation tags do not apply, as glTF demands.
///
/// # Errors
/// [`ImageError::Damaged`].
pub(crate) fn decode(bytes: &[u8], header: &Header) -> Result<Image, ImageError> {
    if bytes.starts_with(&ktx2::MAGIC) {
        let texture = ktx2::open(bytes).map_err(ImageError::Damaged)?;
        let texels = texture.decode().map_err(ImageError::Damaged)?;
        return Image::new(header.width, header.height, texels).map_err(damaged);
    }
    let decoder = decoder(bytes, header.texels().saturating_mul(header.transient.saturating_add(4)))?;
    if decoder.dimensions() != (header.width, header.height) {
        return Err(ImageError::Damaged("its header changed while it was read".to_owned()));
    }
    let count = usize::try_from(header.texels()).map_err(damaged)?;
    let color_type = decoder.color_type();
    let mut texels = vec![[0u8; 4]; count];
    if color_type == ColorType::Rgba8 {
        decoder.read_image(texels.as_flattened_mut()).map_err(damaged)?;
    } else {
        let mut raw = vec![0u8; usize::try_from(decoder.total_bytes()).map_err(damaged)?];
        decoder.read_image(&mut raw).map_err(damaged)?;
        match color_type {
            ColorType::L8 => expand(&raw, &mut texels, |[l]: [u8; 1]| [l, l, l, 255]),
            ColorType::La8 => expand(&raw, &mut texels, |[l, a]: [u8; 2]| [l, l, l, a]),
            ColorType::Rgb8 => expand(&raw, &mut texels, |[r, g, b]: [u8; 3]| [r, g, b, 255]),
            ColorType::L16 => expand(&raw, &mut texels, |[a, b]: [u8; 2]| {
                let l = narrow([a, b]);
                [l, l, l, 255]
            }),
            ColorType::La16 => expand(&raw, &mut texels, |[a, b, c, d]: [u8; 4]| {
                let l = narrow([a, b]);
                [l, l, l, narrow([c, d])]
            }),
            ColorType::Rgb16 => expand(&raw, &mut texels, |[a, b, c, d, e, f]: [u8; 6]| {
                [narrow([a, b]), narrow([c, d]), narrow([e, f]), 255]
            }),
            ColorType::Rgba16 => expand(&raw, &mut texels, |[a, b, c, d, e, f, g, h]: [u8; 8]| {
                [[a, b], [c, d], [e, f], [g, h]].map(narrow)
            }),
            other => return Err(ImageError::Damaged(format!("texels of the kind {other:?} are not known"))),
        }
    }
    Image::new(header.width, header.height, texels).map_err(damaged)
}

fn expand<const S: usize>(raw: &[u8], texels: &mut [[u8; 4]], convert: impl Fn([u8; S]) -> [u8; 4]) {
    for (texel, from) in texels.iter_mut().zip(raw.as_chunks::<S>().0) {
        *texel = convert(*from);
    }
}

/// A channel of 16 bits in this machine's byte order, rounded to 8 bits.
fn narrow(channel: [u8; 2]) -> u8 {
    let v = u32::from(u16::from_ne_bytes(channel));
    (v.saturating_mul(255).saturating_add(32767) / 65535) as u8
}

/// Texels of a picture. Two numbers of 32 bits have a product of 64: it does not saturate.
pub(super) fn area(width: u32, height: u32) -> u64 {
    u64::from(width).saturating_mul(height.into())
}

/// The texel of a picture at the place of another one's texel: its column and row, and the width and height of that one.
pub(super) fn scaled_texel(image: &Image, [x, y]: [u32; 2], [width, height]: [u32; 2]) -> [u8; 4] {
    let place =
        |k: u32, of: u32, n: u32| area(k, n).checked_div(of.into()).and_then(|k| u32::try_from(k).ok());
    // Within the picture, since the other place is within the other one.
    let texel = || image.texel(place(x, width, image.width())?, place(y, height, image.height())?);
    texel().unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use ::image::{DynamicImage, ImageBuffer};

    fn png(image: DynamicImage) -> Vec<u8> {
        let mut bytes = Cursor::new(Vec::new());
        image.write_to(&mut bytes, ImageFormat::Png).unwrap();
        bytes.into_inner()
    }

    fn read(bytes: &[u8]) -> Image {
        let header = probe("image 0", bytes, &Limits::default()).unwrap();
        decode(bytes, &header).unwrap()
    }

    /// What is said to be read is read, and nothing is read that is not said.
    #[test]
    fn every_format_of_the_table_is_recognised() {
        for format in FORMATS {
            let mut bytes = Cursor::new(Vec::new());
            let image = DynamicImage::from(ImageBuffer::from_pixel(4, 4, ::image::Rgb([9u8, 8, 7])));
            let Some(kind) = ImageFormat::from_mime_type(format.mime_type) else {
                assert_eq!(format, formats::KTX2);
                continue;
            };
            image.write_to(&mut bytes, kind).unwrap();
            assert_eq!(read(&bytes.into_inner()).width(), 4, "{}", format.name);
        }
        let read: Vec<ImageFormat> = ImageFormat::all().filter(ImageFormat::reading_enabled).collect();
        for kind in read.into_iter().filter(|kind| *kind != ImageFormat::Hdr) {
            let said = FORMATS.iter().any(|format| format.mime_type == kind.to_mime_type());
            assert!(said, "{kind:?} is read and not said to be");
        }
    }

    #[test]
    fn every_kind_of_texel_becomes_rgba() {
        let cases: [(DynamicImage, [u8; 4]); 8] = [
            (ImageBuffer::from_pixel(2, 3, ::image::Luma([7u8])).into(), [7, 7, 7, 255]),
            (ImageBuffer::from_pixel(2, 3, ::image::LumaA([7u8, 9])).into(), [7, 7, 7, 9]),
            (ImageBuffer::from_pixel(2, 3, ::image::Rgb([1u8, 2, 3])).into(), [1, 2, 3, 255]),
            (ImageBuffer::from_pixel(2, 3, ::image::Rgba([1u8, 2, 3, 4])).into(), [1, 2, 3, 4]),
            (ImageBuffer::from_pixel(2, 3, ::image::Luma([257u16 * 5])).into(), [5, 5, 5, 255]),
            (ImageBuffer::from_pixel(2, 3, ::image::LumaA([65535u16, 128])).into(), [255, 255, 255, 0]),
            (ImageBuffer::from_pixel(2, 3, ::image::Rgb([0u16, 129, 65407])).into(), [0, 1, 255, 255]),
            (ImageBuffer::from_pixel(2, 3, ::image::Rgba([257u16, 514, 771, 1028])).into(), [1, 2, 3, 4]),
        ];
        for (image, expected) in cases {
            let kind = image.color();
            let image = read(&png(image));
            assert_eq!((image.width(), image.height()), (2, 3));
            assert_eq!(image.texels(), [expected; 6], "{kind:?}");
        }
    }

    #[test]
    fn what_is_no_picture_says_so() {
        let message = |bytes: &[u8]| match probe("image 0", bytes, &Limits::default()) {
            Err(ImageError::Damaged(message)) => message,
            other => panic!("{other:?}"),
        };
        assert_eq!(message(b""), "it is empty");
        assert!(matches!(probe("image 0", b"<svg></svg>", &Limits::default()), Err(ImageError::NotAnImage)));
        assert_eq!(message(b"\xabKTX 11\xbb"), "KTX textures before KTX2 cannot be read");
        let mut bytes = png(ImageBuffer::from_pixel(40, 40, ::image::Luma([7u8])).into());
        assert!(!message(&bytes[..20]).contains('\n'));
        let header = probe("image 0", &bytes, &Limits::default()).unwrap();
        bytes.truncate(bytes.len() - 30);
        assert!(matches!(decode(&bytes, &header), Err(ImageError::Damaged(_))));
    }

    #[test]
    fn claims_are_refused_before_they_cost_anything() {
        let bytes = png(ImageBuffer::from_pixel(20, 20, ::image::Luma([7u8])).into());
        let limits = Limits { texture_pixels: 399, ..Limits::default() };
        let Err(ImageError::Limit(error)) = probe("image 3 'x'", &bytes, &limits) else { panic!() };
        assert_eq!(
            error.to_string(),
            "image 3 'x' of 20 x 20 texels: 400 exceeds the limit of 399 (texture_pixels)"
        );
    }
}
