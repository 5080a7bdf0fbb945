//! Encoded pictures (PNG, JPEG, WebP, KTX2, and others that people have) to 8-bit RGBA, with their claims checked before
//! anything is allocated.
mod damaged;
#[cfg(feature = "textures")]
mod etc1s;
pub(super) mod kind;
#[cfg_attr(not(feature = "textures"), path = "without_ktx2.rs")]
mod ktx2;
mod rows;

use super::jpeg::Jpeg;
use ::image::{ImageDecoder, ImageFormat, ImageReader};
use kind::Kind;
use overcoat_core::formats::{self, FileFormat};
use overcoat_core::limits::{LimitExceeded, Limits};
use overcoat_scene::{Image, level_size};
use std::borrow::Cow;
use std::io::Cursor;
use std::ops::RangeInclusive;

/// Formats of textures. Which a file has, its content tells.
pub const FORMATS: &[FileFormat] = &[
    formats::PNG,
    formats::JPEG,
    formats::WEBP,
    formats::KTX2,
    formats::BMP,
    formats::TGA,
    formats::GIF,
    formats::TIFF,
    formats::PNM,
    formats::QOI,
    formats::HDR,
];

/// Names what bytes are that are no picture: "a Blender file". Files of all kinds are known elsewhere.
pub type Foreign = fn(&[u8]) -> Option<Cow<'static, str>>;

/// Bytes that a decoder may use beside the picture itself.
const DECODER_BYTES: u64 = 64 << 20;

/// Header of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Header {
    /// In texels.
    pub width: u32,
    /// In texels.
    pub height: u32,
    /// Bytes per texel while decoding.
    pub transient: u64,
    kind: Kind,
    /// Bytes before the picture.
    start: usize,
    /// A JPEG file that is read by rows; number of times that it can be read at half its size.
    jpeg: Option<u32>,
    /// Its kind of texels has no alpha.
    opaque: bool,
    /// Its format is decoded row by row, unless it is interlaced.
    by_rows: bool,
    /// Halvings after which it has no more texels than one picture may have.
    excess: u32,
}

/// Texels of a picture that is read by rows, which are not all kept, for each texel that a picture may have: reading takes time,
/// and no memory.
const BY_ROWS: u64 = 8;

impl Header {
    /// True if its kind of texels has no alpha.
    pub fn is_opaque(&self) -> bool {
        self.opaque
    }

    /// Number of texels.
    pub fn texels(&self) -> u64 {
        area(self.width, self.height)
    }

    /// True if its format is decoded row by row, unless it is interlaced.
    pub fn is_read_by_rows(&self) -> bool {
        self.by_rows || self.jpeg.is_some()
    }

    /// Number of times that it can be read at half its size ([`halved_rows`]).
    pub fn halvings(&self) -> u32 {
        self.jpeg.unwrap_or(0)
    }

    /// Bytes that decoding takes for a while besides its texels.
    pub fn transient_bytes(&self) -> u64 {
        let is_small = self.jpeg.is_some() || self.kind == Kind::Ktx2 && self.by_rows || self.excess > 0;
        if is_small { 0 } else { self.texels().saturating_mul(self.transient) }
    }

    /// Halvings after which it has no more texels than one picture may have ([`probe_large`]); it is read by [`rows`] alone then.
    pub fn excess(&self) -> u32 {
        self.excess
    }

    /// The kind of picture, if it is one that glTF does not have: "a GIF".
    pub fn unusual(&self) -> Option<&'static str> {
        self.kind.unusual()
    }
}

/// A decoded picture.
#[derive(Clone, Debug)]
pub struct Picture {
    /// Its texels.
    pub image: Image,
    /// Flaw of a picture that can be drawn all the same: one line.
    pub flaw: Option<String>,
}

/// Reason that a picture cannot be used.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ImageError {
    /// It is damaged, or no picture that is read: one line that says so.
    Damaged(String),
    /// It is larger than allowed.
    Limit(LimitExceeded),
}

/// Description of bytes of no known kind.
pub(super) const NOT_AN_IMAGE: &str = "it is neither PNG nor JPEG nor WebP nor another picture that is read";

impl ImageError {
    /// For formats that can do without the picture: one line that says why it is lost, or the limit.
    pub fn loss(self) -> Result<String, LimitExceeded> {
        match self {
            Self::Damaged(message) => Ok(message),
            Self::Limit(error) => Err(error),
        }
    }
}

fn damaged(error: impl std::fmt::Display) -> ImageError {
    let line: String = error.to_string().chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
    ImageError::Damaged(line)
}

pub(super) fn decoder(
    bytes: &[u8],
    format: ImageFormat,
    max_bytes: u64,
) -> Result<Box<dyn ImageDecoder + '_>, ImageError> {
    let bytes = Cursor::new(bytes);
    let mut limits = ::image::Limits::no_limits();
    limits.max_alloc = Some(max_bytes.saturating_add(DECODER_BYTES));
    if !is_built(format) {
        return Err(damaged(format!("{format:?} pictures: {}", formats::LEFT_OUT)));
    }
    let mut reader = ImageReader::with_format(bytes, format);
    reader.limits(limits);
    Ok(Box::new(reader.into_decoder().map_err(damaged)?))
}

/// True if a format is compiled in. (Another package may have compiled its decoder in for itself.)
pub(super) fn is_built(format: ImageFormat) -> bool {
    let is_of_all = matches!(format, ImageFormat::Png | ImageFormat::Jpeg);
    let is_of_more = matches!(format, ImageFormat::Gif | ImageFormat::Qoi | ImageFormat::Tiff);
    is_of_all || is_of_more && cfg!(feature = "more-textures") || !is_of_more && cfg!(feature = "textures")
}

/// Reads the header only, and checks it against `limits.texture_pixels`. `what` names the picture in the limit's
/// message, `foreign` what is none.
///
/// # Errors
/// [`ImageError`].
pub fn probe(what: &str, bytes: &[u8], limits: &Limits, foreign: Foreign) -> Result<Header, ImageError> {
    let check = |width: u32, height: u32| {
        let texels = area(width, height);
        let what = || format!("{what} of {width} x {height} texels");
        Limits::check(what, texels, limits.texture_pixels, "texture_pixels").map_err(ImageError::Limit)
    };
    let (kind, start) = kind::find(bytes, foreign).map_err(ImageError::Damaged)?;
    let bytes = bytes.get(start..).unwrap_or_default();
    let header = |width, height, transient, opaque| {
        let by_rows = kind == Kind::Image(ImageFormat::Png);
        Header { width, height, transient, kind, start, jpeg: None, opaque, by_rows, excess: 0 }
    };
    let format = match kind {
        Kind::Ktx2 => {
            let texture = ktx2::open(bytes).map_err(ImageError::Damaged)?;
            check(texture.width, texture.height)?;
            let header = header(texture.width, texture.height, ktx2::TRANSIENT, false);
            return Ok(Header { by_rows: texture.is_read_by_rows() && start == 0, ..header });
        }
        Kind::Image(format) => format,
    };
    if let Some((width, height)) = png_size(bytes) {
        // The decoder has limits of its own, with other messages.
        check(width, height)?;
    }
    let decoder = match decoder(bytes, format, limits.decoded_bytes) {
        Ok(decoder) => decoder,
        Err(error) => {
            let size = match format {
                ImageFormat::Png => damaged::png_size(bytes, DECODER_BYTES),
                _ => None,
            };
            let (width, height) = size.ok_or(error)?;
            check(width, height)?;
            return Ok(header(width, height, 4, false));
        }
    };
    let (width, height) = decoder.dimensions();
    if width == 0 || height == 0 {
        return Err(ImageError::Damaged(format!("it has {width} x {height} texels")));
    }
    check(width, height)?;
    let color_type = decoder.color_type();
    let header = header(width, height, color_type.bytes_per_pixel().into(), !color_type.has_alpha());
    let jpeg = if format == ImageFormat::Jpeg && start == 0 { Jpeg::open(bytes) } else { None };
    let jpeg = jpeg.filter(|jpeg| jpeg.size() == [width, height]).map(|jpeg| jpeg.halvings());
    Ok(Header { jpeg, ..header })
}

/// [`probe`] of a picture of which the smaller mip levels will do: of one that is read by rows, up to eight times as many texels are
/// accepted, of which [`Header::excess`] tells.
///
/// # Errors
/// As there.
pub fn probe_large(
    what: &str,
    bytes: &[u8],
    limits: &Limits,
    foreign: Foreign,
) -> Result<Header, ImageError> {
    let refused = match probe(what, bytes, limits, foreign) {
        Err(ImageError::Limit(limit)) => ImageError::Limit(limit),
        probed => return probed,
    };
    let most = limits.texture_pixels;
    let more = limits.clone().with_texture_pixels(most.saturating_mul(BY_ROWS));
    let Ok(header) = probe(what, bytes, &more, foreign) else { return Err(refused) };
    let is_interlaced = header.jpeg.is_none() && header.kind != Kind::Ktx2 && bytes.get(28) != Some(&0);
    if !header.is_read_by_rows() || header.start > 0 || is_interlaced {
        return Err(refused);
    }
    let texels = |excess: u32| {
        let [width, height] = level_size([header.width, header.height], excess);
        area(width, height)
    };
    let excess = (1..u32::BITS).find(|&excess| texels(excess) <= most).ok_or(refused)?;
    Ok(Header { excess, ..header })
}

/// Width and height by the first chunk of a PNG file.
fn png_size(bytes: &[u8]) -> Option<(u32, u32)> {
    let word = |at: usize| bytes.get(at..)?.first_chunk().map(|&word| u32::from_be_bytes(word));
    (bytes.get(12..16)? == b"IHDR").then(|| word(16).zip(word(20))).flatten()
}

/// Gives the rows of a sound picture whose header has been accepted, from the top on, until one is not `taken`; the texels are
/// those of [`decode`]. `raw` is room for what decoders write, whatever it holds. False if the picture is not sound, whatever
/// rows were given.
pub fn rows(
    bytes: &[u8],
    header: &Header,
    raw: &mut Vec<u8>,
    take: &mut dyn FnMut(&[[u8; 4]]) -> bool,
) -> bool {
    let format = match header.kind {
        _ if header.start > 0 => return false,
        Kind::Ktx2 => {
            let texture = ktx2::open(bytes).ok();
            let same = texture.filter(|ktx2| (ktx2.width, ktx2.height) == (header.width, header.height));
            return same.is_some_and(|texture| texture.rows(raw, take).is_ok());
        }
        Kind::Image(format) => format,
    };
    if header.jpeg.is_some() {
        return halved_rows(bytes, header, 0..=0, false, &mut |_, row| take(row));
    }
    if format == ImageFormat::Jpeg && damaged::is_cut_jpeg(bytes) {
        return false;
    }
    rows::read(format, bytes, header, raw, take).is_ok()
}

/// Gives rows as [`rows`] does, of the picture at its size halved as often as `halvings` says, which is
/// [`Header::halvings`] at most. Texels are the means of 2, 4 or 8 texels along each side, of `light` of sRGB codes or of codes. Where rows of several sizes end at the same place, that of the smallest comes first.
pub fn halved_rows(
    bytes: &[u8],
    header: &Header,
    halvings: RangeInclusive<u32>,
    light: bool,
    take: &mut dyn FnMut(u32, &[[u8; 4]]) -> bool,
) -> bool {
    let jpeg = header.jpeg.filter(|most| halvings.end() <= most).and_then(|_| Jpeg::open(bytes));
    let is_same = |jpeg: &Jpeg<'_>| jpeg.size() == [header.width, header.height];
    jpeg.filter(is_same).and_then(|jpeg| jpeg.rows(halvings, light, take)).is_some()
}

/// Decodes a picture whose header has been accepted. 16-bit channels are rounded to 8 bits, grey becomes RGB, what
/// has no alpha is opaque; numbers with a point are linear light, and become sRGB. Colour profiles, gamma and orientation tags
/// do not apply, as glTF demands. Of films the first picture is taken, of damaged PNG and JPEG files what is there.
///
/// # Errors
/// [`ImageError::Damaged`].
pub fn decode(bytes: &[u8], header: &Header) -> Result<Picture, ImageError> {
    if header.excess > 0 {
        let message = "it is damaged, and too large to be decoded as a whole (texture_pixels)";
        return Err(ImageError::Damaged(message.to_owned()));
    }
    let skipped = header.start;
    let bytes = bytes.get(skipped..).unwrap_or_default();
    let (image, mut flaw) = match header.kind {
        Kind::Ktx2 => {
            let texture = ktx2::open(bytes).map_err(ImageError::Damaged)?;
            let texels = texture.decode().map_err(ImageError::Damaged)?;
            (Image::new(header.width, header.height, texels).map_err(damaged)?, None)
        }
        Kind::Image(format) => match rows::image(format, bytes, header) {
            Ok(image) => {
                let cut = format == ImageFormat::Jpeg && damaged::is_cut_jpeg(bytes);
                (image, cut.then(|| "it ends early; the rest of it is made up".to_owned()))
            }
            Err(error) => {
                let memory = header.texels().saturating_mul(8).saturating_add(DECODER_BYTES);
                let there = match format {
                    ImageFormat::Png => damaged::png(bytes, header.width, header.height, memory),
                    _ => None,
                };
                there.map(|(image, flaw)| (image, Some(flaw))).ok_or(error)?
            }
        },
    };
    if skipped > 0 {
        let junk = format!("{skipped} bytes before its signature are passed over");
        flaw = Some(flaw.map_or_else(|| junk.clone(), |flaw| format!("{junk}; {flaw}")));
    }
    Ok(Picture { image, flaw })
}

/// Texels of a picture. Two numbers of 32 bits have a product of 64: it does not saturate.
pub fn area(width: u32, height: u32) -> u64 {
    u64::from(width).saturating_mul(height.into())
}

/// The texel of a picture at the place of another one's texel: its column and row, and the width and height of that one.
pub fn scaled_texel(image: &Image, [x, y]: [u32; 2], [width, height]: [u32; 2]) -> [u8; 4] {
    let place =
        |k: u32, of: u32, n: u32| area(k, n).checked_div(of.into()).and_then(|k| u32::try_from(k).ok());
    // Within the picture, since the other place is within the other one.
    let texel = || image.texel(place(x, width, image.width())?, place(y, height, image.height())?);
    texel().unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::{FORMATS, Header, Image, ImageError, ImageFormat, Limits, decode, formats};
    use ::image::{DynamicImage, ImageBuffer};
    use std::io::Cursor;

    fn probe(what: &str, bytes: &[u8], limits: &Limits) -> Result<Header, ImageError> {
        super::probe(what, bytes, limits, |_| None)
    }

    fn png(image: DynamicImage) -> Vec<u8> {
        let mut bytes = Cursor::new(Vec::new());
        image.write_to(&mut bytes, ImageFormat::Png).unwrap();
        bytes.into_inner()
    }

    fn read(bytes: &[u8]) -> Image {
        let header = probe("image 0", bytes, &Limits::default()).unwrap();
        decode(bytes, &header).unwrap().image
    }

    fn encoded(image: &DynamicImage, format: ImageFormat) -> Vec<u8> {
        let mut bytes = Cursor::new(Vec::new());
        image.write_to(&mut bytes, format).unwrap();
        bytes.into_inner()
    }

    /// Colours that change from texel to texel.
    fn ramp(width: u32, height: u32) -> DynamicImage {
        ImageBuffer::from_fn(width, height, |x, y| {
            ::image::Rgb([(x * 3) as u8, (y * 5) as u8, (x + y) as u8])
        })
        .into()
    }

    /// Formats that are said to be read are read, and no others.
    #[test]
    fn every_format_of_the_table_is_recognised() {
        for &format in FORMATS {
            let image = DynamicImage::from(ImageBuffer::from_pixel(4, 4, ::image::Rgb([9u8, 8, 7])));
            let Some(kind) = ImageFormat::from_mime_type(format.mime_type) else {
                assert_eq!(format, formats::KTX2);
                continue;
            };
            let image = if kind == ImageFormat::Hdr { image.to_rgb32f().into() } else { image };
            assert_eq!(read(&encoded(&image, kind)).width(), 4, "{}", format.name);
        }
        for kind in ImageFormat::all().filter(ImageFormat::reading_enabled) {
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
        let mut bytes = png(ImageBuffer::from_pixel(40, 40, ::image::Luma([7u8])).into());
        assert!(!message(&bytes[..20]).contains('\n'));
        let header = probe("image 0", &bytes, &Limits::default()).unwrap();
        bytes.truncate(40);
        assert!(matches!(decode(&bytes, &header), Err(ImageError::Damaged(_))));
    }

    #[test]
    fn kinds_that_people_have_are_pictures_too() {
        let image = ramp(20, 12);
        let expected = read(&png(image.clone()));
        for format in
            [ImageFormat::Bmp, ImageFormat::Tga, ImageFormat::Tiff, ImageFormat::Pnm, ImageFormat::Qoi]
        {
            assert_eq!(read(&encoded(&image, format)).texels(), expected.texels(), "{format:?}");
        }
        let plain: DynamicImage = ImageBuffer::from_pixel(9, 7, ::image::Rgb([255u8, 0, 0])).into();
        assert_eq!(read(&encoded(&plain, ImageFormat::Gif)).texels(), [[255, 0, 0, 255]; 63]);
        let light: DynamicImage = ImageBuffer::from_pixel(9, 7, ::image::Rgb([4.0f32, 0.0, 0.25])).into();
        assert_eq!(read(&encoded(&light, ImageFormat::Hdr)).texels(), [[255, 0, 137, 255]; 63]);
    }

    #[test]
    fn what_is_there_of_damaged_pictures_is_drawn() {
        let flaw = |bytes: &[u8]| {
            let header = probe("image 0", bytes, &Limits::default()).unwrap();
            let picture = decode(bytes, &header).unwrap();
            (picture.image, picture.flaw.unwrap_or_default())
        };
        let noise: DynamicImage = ImageBuffer::from_fn(40, 30, |x, y| {
            ::image::Rgb([x, y, x ^ y].map(|v| (v.wrapping_mul(0x9e37_79b1) >> 13) as u8))
        })
        .into();
        let whole = png(noise.clone());
        let expected = read(&whole);
        let (image, message) = flaw(&whole[..whole.len() / 2]);
        assert!(message.starts_with("only ") && message.contains(" of its 30 rows"), "{message}");
        assert_eq!(image.texels()[..40 * 8], expected.texels()[..40 * 8]);
        assert!(image.texels()[40 * 29..].iter().all(|t| *t == image.texels()[40 * 29] && t[3] == 255));
        let mut checksum = whole.clone();
        // Of the header, and of the texels.
        checksum[30] ^= 1;
        let last = checksum.len() - 14;
        checksum[last] ^= 1;
        let (image, message) = flaw(&checksum);
        assert_eq!((image.texels(), message.as_str()), (expected.texels(), "its checksums are wrong"));
        let (image, message) = flaw(&[b"\0\0junk", &whole[..]].concat());
        assert_eq!(message, "6 bytes before its signature are passed over");
        assert_eq!(image.texels(), expected.texels());

        let jpeg = encoded(&ramp(64, 64), ImageFormat::Jpeg);
        let expected = read(&jpeg);
        assert!(flaw(&jpeg).1.is_empty());
        // Some programs append what is no picture.
        assert!(flaw(&[&jpeg[..], &[0; 99]].concat()).1.is_empty());
        let (image, message) = flaw(&[&[0; 5], &jpeg[..]].concat());
        // Such files are read by another decoder, which rounds in its own way.
        let is_near = |image: &Image, count: usize| {
            let channels = |image: &Image| image.texels()[..count].as_flattened().to_vec();
            channels(image).iter().zip(channels(&expected)).all(|(a, b)| a.abs_diff(b) <= 3)
        };
        assert!(is_near(&image, 64 * 64) && message.starts_with("5 bytes before"), "{message}");
        let (image, message) = flaw(&jpeg[..jpeg.len() * 3 / 4]);
        assert!(is_near(&image, 64 * 8));
        assert!(message.starts_with("it ends early"), "{message}");
    }

    proptest::proptest! {
        #![proptest_config(proptest::prelude::ProptestConfig { cases: 3000, failure_persistence: None, ..Default::default() })]

        /// Whatever is changed in a file: an error, or a picture of the size that was announced. Rows that are said to be
        /// those of a sound picture are its own.
        #[test]
        fn damaged_files_of_every_kind_end_in_a_picture_or_an_error(
            format in 0_usize..7,
            changes in proptest::collection::vec((0_usize..400, 0_u8..=255), 1..6),
            cut in 0_usize..2000,
        ) {
            let formats = [
                ImageFormat::Bmp, ImageFormat::Tga, ImageFormat::Tiff, ImageFormat::Pnm, ImageFormat::Qoi, ImageFormat::Gif,
                ImageFormat::Png,
            ];
            let mut bytes = encoded(&ramp(11, 7), formats[format]);
            for (place, value) in changes {
                // The end too, where TIFF has its tables.
                let place = if place % 2 == 0 { place / 2 } else { bytes.len().saturating_sub(1 + place / 2) };
                if let Some(byte) = bytes.get_mut(place) {
                    *byte = value;
                }
            }
            bytes.truncate(cut.max(4));
            let limits = Limits::default().with_texture_pixels(1 << 16).with_decoded_bytes(1 << 22);
            if let Ok(header) = probe("image 0", &bytes, &limits) {
                let mut texels = Vec::new();
                let sound = super::rows(&bytes, &header, &mut vec![7; 99], &mut |row| {
                    texels.extend_from_slice(row);
                    true
                });
                let picture = decode(&bytes, &header);
                if let Ok(picture) = &picture {
                    proptest::prop_assert_eq!((picture.image.width(), picture.image.height()), (header.width, header.height));
                }
                let whole = picture.ok().filter(|picture| picture.flaw.is_none());
                proptest::prop_assert!(!sound || whole.is_some_and(|whole| whole.image.texels() == texels));
            }
        }
    }

    #[test]
    fn claims_are_refused_before_they_cost_anything() {
        let bytes = png(ImageBuffer::from_pixel(20, 20, ::image::Luma([7u8])).into());
        let limits = Limits::default().with_texture_pixels(399);
        let Err(ImageError::Limit(error)) = probe("image 3 'x'", &bytes, &limits) else { panic!() };
        assert_eq!(
            error.to_string(),
            "image 3 'x' of 20 x 20 texels: 400 exceeds the limit of 399 (texture_pixels)"
        );
    }
}
