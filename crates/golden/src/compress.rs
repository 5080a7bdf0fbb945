//! PNG files as small as this crate can make them, without a change to any pixel.
//!
//! Colour types are reduced as far as the pixels allow (no alpha, grey, palette, fewer bits), every filter strategy is
//! tried on each, and the best is packed by zopfli, a deflate encoder that takes a hundred times as long as others for
//! the last few percent. Depth stays: 16 bits are never made 8, for a golden also says how exactly something is known.
//!
//! Chunks that say what the numbers mean stay (sRGB, gAMA, cHRM, iCCP, cICP, mDCV, cLLI, pHYs); texts, times and the like
//! go.

use super::GoldenError;
use overcoat_core::frame::DisplayImage;
use overcoat_core::limits::Limits;
use overcoat_image::decode::{DecodedPicture, SampleKind, read_png};
use overcoat_image::output::encode_png;
use std::collections::{BTreeMap, BTreeSet};
use std::num::NonZeroU64;

/// Effort of compression: the time that it may take.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Effort {
    /// Reductions and filters, packed by an ordinary encoder: milliseconds.
    Quick,
    /// The same, packed by zopfli: seconds for a megapixel.
    Strongest,
}

/// Chunks that are kept where they are present, all of which stand before the pixels.
const KEPT: [&[u8; 4]; 8] = [b"cICP", b"mDCV", b"cLLI", b"iCCP", b"sRGB", b"gAMA", b"cHRM", b"pHYs"];

/// A stored PNG may be larger by this factor than what the strongest compression makes of it.
const OVERSIZE: f64 = 1.1;
/// Files below this size are not worth a word.
const OVERSIZE_FROM: usize = 1024;

/// More than this many filtered bytes are packed by the ordinary encoder: zopfli would take minutes.
const MOST_FOR_ZOPFLI: usize = 32 << 20;

/// The smallest PNG file with the same pixels that is found. A file that is smaller already comes back as it is.
///
/// # Errors
/// [`GoldenError::Picture`] if the file cannot be read, [`GoldenError::Animated`] if it is an animation.
pub fn compress_png(bytes: &[u8], effort: Effort, limits: &Limits) -> Result<Vec<u8>, GoldenError> {
    let picture = read_png(bytes, limits)?;
    let chunks = chunks(bytes);
    if chunks.iter().any(|(name, _)| name == b"acTL") {
        return Err(GoldenError::Animated);
    }
    let has_profile = chunks.iter().any(|(name, _)| name == b"iCCP");
    // Colour type 0 and 4: a profile of such a file is one for grey, others are for colours.
    let was_grey = matches!(bytes.get(25), Some(0 | 4));
    let layouts = layouts(&picture.samples, picture.is_16_bit, has_profile.then_some(was_grey));
    let [width, height] = [picture.width, picture.height].map(|side| side as usize);

    let mut best: Option<(usize, Vec<u8>, &Layout)> = None;
    for layout in &layouts {
        let rows = layout.pack(width, height, &picture.samples);
        for strategy in Strategy::ALL {
            let filtered = strategy.apply(&rows, layout.bytes_between());
            let level = if effort == Effort::Quick { 6 } else { 9 };
            let size =
                miniz_oxide::deflate::compress_to_vec_zlib(&filtered, level).len() + layout.palette_bytes();
            if best.as_ref().is_none_or(|(least, ..)| size < *least) {
                best = Some((size, filtered, layout));
            }
        }
    }
    let Some((_, filtered, layout)) = best else { return Ok(bytes.to_vec()) };
    let mut packed = miniz_oxide::deflate::compress_to_vec_zlib(&filtered, 9);
    if effort == Effort::Strongest && filtered.len() <= MOST_FOR_ZOPFLI {
        packed = zopfli(&filtered).filter(|squeezed| squeezed.len() < packed.len()).unwrap_or(packed);
    }
    let out = layout.file(picture.width, picture.height, &chunks, &packed);
    Ok(if out.len() < bytes.len() { out } else { bytes.to_vec() })
}

/// Reason that a stored file counts as larger than it must be. What this crate's own encoder makes of a picture is not:
/// a fresh render may be stored as it is.
pub(crate) fn oversize(stored: &[u8], picture: &DecodedPicture, limits: &Limits) -> Option<String> {
    if stored.len() < OVERSIZE_FROM || !stored.starts_with(b"\x89PNG") {
        return None;
    }
    if stored.len() <= fresh_size(picture).unwrap_or(0) {
        return None;
    }
    let small = |effort| compress_png(stored, effort, limits).ok().map(|bytes| bytes.len());
    let quick = small(Effort::Quick)?;
    let too_large = |best: usize| stored.len() as f64 > OVERSIZE * best as f64;
    // Zopfli takes seconds, and gains less than the margin: it is only asked about files that the quick search beats.
    let best = if too_large(quick) || stored.len() <= quick { quick } else { small(Effort::Strongest)? };
    too_large(best).then(|| {
        format!("{} bytes are stored, {best} would do: accept it again to compress it", stored.len())
    })
}

/// Bytes of the file that a renderer of this crate writes; `None` for what it does not write.
fn fresh_size(picture: &DecodedPicture) -> Option<usize> {
    if picture.kind != SampleKind::Unsigned8 || picture.motion.is_some() {
        return None;
    }
    let pixels = picture.pixels.iter().map(|p| p.map(|v| v as u8)).collect();
    let image = DisplayImage { width: picture.width, height: picture.height, pixels };
    encode_png(&image).ok().map(|bytes| bytes.len())
}

/// A zlib stream by zopfli; with fewer tries for more data. `None` if writing to memory fails, which it does not.
fn zopfli(data: &[u8]) -> Option<Vec<u8>> {
    let tries = if data.len() < 1 << 18 {
        15
    } else if data.len() < 1 << 21 {
        5
    } else {
        1
    };
    let options = zopfli::Options {
        iteration_count: NonZeroU64::new(tries).unwrap_or(NonZeroU64::MIN),
        ..Default::default()
    };
    let mut out = Vec::new();
    zopfli::compress(options, zopfli::Format::Zlib, data, &mut out).ok().map(|()| out)
}

/// The chunks before the pixels that are looked at or kept. The file has been decoded, so they lie within it.
fn chunks(bytes: &[u8]) -> Vec<([u8; 4], Vec<u8>)> {
    let mut out = Vec::new();
    let mut rest = bytes.get(8..).unwrap_or_default();
    while let Some((head, after)) = rest.split_at_checked(8) {
        let name = [head[4], head[5], head[6], head[7]];
        let length = u32::from_be_bytes([head[0], head[1], head[2], head[3]]) as usize;
        let Some(data) = after.get(..length) else { break };
        if &name == b"IDAT" {
            break;
        }
        if &name == b"acTL" || KEPT.contains(&&name) {
            out.push((name, data.to_vec()));
        }
        rest = after.get(length + 4..).unwrap_or_default();
    }
    out
}

/// Pixel layout of the file.
#[derive(Clone, Debug, PartialEq)]
enum Layout {
    /// Channels of the pixel that are stored, 8 or 16 bits each: 1 grey, 2 grey and alpha, 3 colours, 4 all.
    Direct { channels: usize, is_16_bit: bool },
    /// Grey of 1, 2 or 4 bits.
    ShallowGrey { bits: usize },
    /// Places in a palette, 1, 2, 4 or 8 bits each; translucent colours come first.
    Palette { bits: usize, colours: Vec<[u8; 4]> },
}

/// The layouts that can hold these pixels, one of each kind, the smallest of it. `profile`: there is a colour profile, for
/// grey if true, to which the colour type must fit.
fn layouts(samples: &[[u16; 4]], is_16_bit: bool, profile: Option<bool>) -> Vec<Layout> {
    let opaque = if is_16_bit { u16::MAX } else { 255 };
    let has_alpha = samples.iter().any(|p| p[3] != opaque);
    let may_be_grey = profile != Some(false);
    let is_grey = may_be_grey && samples.iter().all(|p| p[0] == p[1] && p[1] == p[2]);
    let channels = match (is_grey, has_alpha) {
        (true, false) => 1,
        (true, true) => 2,
        (false, false) => 3,
        (false, true) => 4,
    };
    let mut out = vec![Layout::Direct { channels, is_16_bit }];
    if is_16_bit {
        return out;
    }
    if channels == 1 {
        // 1 bit holds multiples of 255, 2 bits of 85, 4 bits of 17.
        let bits = [(1, 255), (2, 85), (4, 17)];
        let fitting = bits.iter().find(|(_, step)| samples.iter().all(|p| p[0] % step == 0));
        out.extend(fitting.map(|&(bits, _)| Layout::ShallowGrey { bits }));
    }
    if profile != Some(true) {
        let mut colours: BTreeSet<[u16; 4]> = BTreeSet::new();
        for pixel in samples {
            colours.insert(*pixel);
            if colours.len() > 256 {
                return out;
            }
        }
        let mut colours: Vec<[u8; 4]> = colours.into_iter().map(|c| c.map(|v| v as u8)).collect();
        // Near colours get near places, which filters can make use of.
        colours.sort_by_key(|&[r, g, b, a]| {
            (a == 255, 299 * u32::from(r) + 587 * u32::from(g) + 114 * u32::from(b), a)
        });
        let bits = match colours.len() {
            0..=2 => 1,
            3..=4 => 2,
            5..=16 => 4,
            _ => 8,
        };
        out.push(Layout::Palette { bits, colours });
    }
    out
}

impl Layout {
    /// Bytes from a sample to the one of the same channel before it, which filters subtract.
    fn bytes_between(&self) -> usize {
        match self {
            Self::Direct { channels, is_16_bit } => channels << usize::from(*is_16_bit),
            Self::ShallowGrey { .. } | Self::Palette { .. } => 1,
        }
    }

    /// Rows as they are filtered.
    fn pack(&self, width: usize, height: usize, samples: &[[u16; 4]]) -> Vec<Vec<u8>> {
        let row = |y: usize| {
            let pixels = &samples[y * width..][..width];
            match self {
                Self::Direct { channels, is_16_bit } => {
                    let stored: &[usize] = match channels {
                        1 => &[0],
                        2 => &[0, 3],
                        3 => &[0, 1, 2],
                        _ => &[0, 1, 2, 3],
                    };
                    let codes = pixels.iter().flat_map(|p| stored.iter().map(|&k| p[k]));
                    if *is_16_bit {
                        codes.flat_map(u16::to_be_bytes).collect()
                    } else {
                        codes.map(|v| v as u8).collect()
                    }
                }
                Self::ShallowGrey { bits } => {
                    let step = 255 / ((1 << bits) - 1);
                    pack_bits(pixels.iter().map(|p| (p[0] / step) as u8), *bits)
                }
                Self::Palette { bits, colours } => {
                    let places: BTreeMap<[u8; 4], u8> = colours.iter().copied().zip(0..=255).collect();
                    let place = |p: &[u16; 4]| places.get(&p.map(|v| v as u8)).copied().unwrap_or(0);
                    pack_bits(pixels.iter().map(place), *bits)
                }
            }
        };
        (0..height).map(row).collect()
    }

    /// Bytes of the chunks PLTE and tRNS.
    fn palette_bytes(&self) -> usize {
        match self {
            Self::Palette { colours, .. } => 24 + 3 * colours.len() + translucent(colours),
            _ => 0,
        }
    }

    /// The file around packed pixels.
    fn file(&self, width: u32, height: u32, kept: &[([u8; 4], Vec<u8>)], packed: &[u8]) -> Vec<u8> {
        let (depth, colour_type) = match self {
            Self::Direct { channels, is_16_bit } => {
                (if *is_16_bit { 16 } else { 8 }, [0, 4, 2, 6][channels - 1])
            }
            Self::ShallowGrey { bits } => (*bits as u8, 0),
            Self::Palette { bits, .. } => (*bits as u8, 3),
        };
        let mut header = Vec::new();
        header.extend(width.to_be_bytes());
        header.extend(height.to_be_bytes());
        header.extend([depth, colour_type, 0, 0, 0]);
        let mut out = b"\x89PNG\r\n\x1a\n".to_vec();
        push_chunk(&mut out, b"IHDR", &header);
        for (name, data) in kept {
            push_chunk(&mut out, name, data);
        }
        if let Self::Palette { colours, .. } = self {
            let rgb: Vec<u8> = colours.iter().flat_map(|c| [c[0], c[1], c[2]]).collect();
            push_chunk(&mut out, b"PLTE", &rgb);
            let alphas: Vec<u8> = colours[..translucent(colours)].iter().map(|c| c[3]).collect();
            if !alphas.is_empty() {
                push_chunk(&mut out, b"tRNS", &alphas);
            }
        }
        push_chunk(&mut out, b"IDAT", packed);
        push_chunk(&mut out, b"IEND", &[]);
        out
    }
}

/// Number of colours that are not opaque, which stand first.
fn translucent(colours: &[[u8; 4]]) -> usize {
    colours.iter().take_while(|c| c[3] != 255).count()
}

/// Codes of a few bits each, the first in the highest bits.
fn pack_bits(codes: impl Iterator<Item = u8>, bits: usize) -> Vec<u8> {
    let mut out = Vec::new();
    let mut used = 8;
    for code in codes {
        if used == 8 {
            out.push(0);
            used = 0;
        }
        used += bits;
        if let Some(last) = out.last_mut() {
            *last |= code << (8 - used);
        }
    }
    out
}

fn push_chunk(out: &mut Vec<u8>, name: &[u8; 4], data: &[u8]) {
    out.extend((data.len() as u32).to_be_bytes());
    let start = out.len();
    out.extend(name);
    out.extend(data);
    let checksum = crc32fast::hash(&out[start..]);
    out.extend(checksum.to_be_bytes());
}

/// Strategy that chooses the filter of each row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Strategy {
    /// One filter for all rows: 0 none, 1 left, 2 above, 3 average, 4 Paeth.
    All(u8),
    /// Each row by the least sum of distances from 0 (the specification's heuristic).
    LeastSum,
    /// Each row by the fewest different pairs of neighbouring bytes (B. Jansen's heuristic in oxipng).
    FewestPairs,
}

impl Strategy {
    const ALL: [Self; 7] = [
        Self::All(0),
        Self::All(1),
        Self::All(2),
        Self::All(3),
        Self::All(4),
        Self::LeastSum,
        Self::FewestPairs,
    ];

    /// Filtered rows, each behind the number of its filter.
    fn apply(self, rows: &[Vec<u8>], between: usize) -> Vec<u8> {
        let mut out = Vec::new();
        let mut pairs = PairSet::default();
        let empty = vec![0; rows.first().map_or(0, Vec::len)];
        for (y, row) in rows.iter().enumerate() {
            let above = if y == 0 { &empty } else { &rows[y - 1] };
            let filtered = |filter: u8| filter_row(filter, row, above, between);
            let (filter, bytes) = match self {
                Self::All(filter) => (filter, filtered(filter)),
                Self::LeastSum => {
                    let sum = |bytes: &[u8]| {
                        bytes.iter().map(|&v| u64::from((v as i8).unsigned_abs())).sum::<u64>()
                    };
                    least(filtered, |bytes| sum(bytes))
                }
                Self::FewestPairs => least(filtered, |bytes| pairs.count(bytes)),
            };
            out.push(filter);
            out.extend(bytes);
        }
        out
    }
}

/// The filter whose row costs least; the first of several.
fn least(filtered: impl Fn(u8) -> Vec<u8>, mut cost: impl FnMut(&[u8]) -> u64) -> (u8, Vec<u8>) {
    let mut best = (0, filtered(0));
    let mut least = cost(&best.1);
    for filter in 1..5 {
        let bytes = filtered(filter);
        let cost = cost(&bytes);
        if cost < least {
            (best, least) = ((filter, bytes), cost);
        }
    }
    best
}

/// Counts different pairs of bytes. What was seen is marked by the number of the row, so that nothing is cleared.
#[derive(Default)]
struct PairSet {
    seen: Vec<u32>,
    round: u32,
}

impl PairSet {
    fn count(&mut self, bytes: &[u8]) -> u64 {
        self.seen.resize(1 << 16, 0);
        self.round += 1;
        let mut count = 0;
        for pair in bytes.windows(2) {
            let mark = &mut self.seen[usize::from(pair[0]) << 8 | usize::from(pair[1])];
            if *mark != self.round {
                *mark = self.round;
                count += 1;
            }
        }
        count
    }
}

/// The filters of PNG (specification, section 9).
fn filter_row(filter: u8, row: &[u8], above: &[u8], between: usize) -> Vec<u8> {
    let left = |bytes: &[u8], k: usize| if k < between { 0 } else { bytes[k - between] };
    let predicted = |k: usize| match filter {
        1 => left(row, k),
        2 => above[k],
        3 => ((u16::from(left(row, k)) + u16::from(above[k])) / 2) as u8,
        4 => paeth(left(row, k), above[k], left(above, k)),
        _ => 0,
    };
    (0..row.len()).map(|k| row[k].wrapping_sub(predicted(k))).collect()
}

/// Whichever neighbour is nearest to left + above - diagonal.
fn paeth(left: u8, above: u8, diagonal: u8) -> u8 {
    let [a, b, c] = [left, above, diagonal].map(i16::from);
    let (to_a, to_b, to_c) = ((b - c).abs(), (a - c).abs(), (a + b - 2 * c).abs());
    if to_a <= to_b && to_a <= to_c {
        left
    } else if to_b <= to_c {
        above
    } else {
        diagonal
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use png::{BitDepth, ColorType};

    fn encode(width: u32, height: u32, color: ColorType, depth: BitDepth, data: &[u8]) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, width, height);
        encoder.set_color(color);
        encoder.set_depth(depth);
        encoder.set_compression(png::Compression::Fast);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        encoder.add_text_chunk("Comment".to_owned(), "made by a test".repeat(20)).unwrap();
        encoder.write_header().unwrap().write_image_data(data).unwrap();
        bytes
    }

    /// Codes of a simple generator (D. Knuth's MMIX), in the high bits.
    fn noise(count: usize) -> impl Iterator<Item = u8> {
        let mut state = 1_u64;
        (0..count).map(move |_| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 56) as u8
        })
    }

    /// The header's depth and colour type.
    fn kind(bytes: &[u8]) -> (u8, u8) {
        (bytes[24], bytes[25])
    }

    #[test]
    fn pixels_stay_and_colour_types_shrink() {
        let (w, h) = (37_u32, 23_u32);
        let count = (w * h) as usize;
        type Case = (&'static str, ColorType, BitDepth, Vec<u8>, (u8, u8));
        let cases: [Case; 10] = [
            ("translucent noise", ColorType::Rgba, BitDepth::Eight, noise(4 * count).collect(), (8, 6)),
            (
                "opaque",
                ColorType::Rgba,
                BitDepth::Eight,
                noise(4 * count).enumerate().map(|(k, v)| if k % 4 == 3 { 255 } else { v }).collect(),
                (8, 2),
            ),
            (
                "hidden colours",
                ColorType::Rgba,
                BitDepth::Eight,
                noise(4 * count).enumerate().map(|(k, v)| if k % 4 == 3 { v & 1 } else { v }).collect(),
                (8, 6),
            ),
            (
                "grey and alpha",
                ColorType::Rgba,
                BitDepth::Eight,
                noise(2 * count)
                    .collect::<Vec<_>>()
                    .chunks(2)
                    .flat_map(|p| [p[0], p[0], p[0], p[1]])
                    .collect(),
                (8, 4),
            ),
            ("grey", ColorType::Rgb, BitDepth::Eight, noise(count).flat_map(|v| [v, v, v]).collect(), (8, 0)),
            (
                "two greys",
                ColorType::Rgb,
                BitDepth::Eight,
                noise(count).flat_map(|v| [255 * (v >> 7); 3]).collect(),
                (1, 0),
            ),
            (
                "five colours",
                ColorType::Rgba,
                BitDepth::Eight,
                noise(count).flat_map(|v| [v % 5, 7, 9, 40 * (v % 5) + 95]).collect(),
                (4, 3),
            ),
            ("16 bits", ColorType::Rgb, BitDepth::Sixteen, noise(6 * count).collect(), (16, 2)),
            (
                "16 bits that 8 would hold",
                ColorType::Rgba,
                BitDepth::Sixteen,
                noise(count).flat_map(|v| [v, v, v, v, v, v, 255, 255]).collect(),
                (16, 0),
            ),
            (
                "16 bits with alpha",
                ColorType::GrayscaleAlpha,
                BitDepth::Sixteen,
                noise(4 * count).collect(),
                (16, 4),
            ),
        ];
        for (what, color, depth, data, expected) in cases {
            let original = encode(w, h, color, depth, &data);
            let before = DecodedPicture::from_bytes(&original, &Limits::default()).unwrap();
            for effort in [Effort::Quick, Effort::Strongest] {
                let small = compress_png(&original, effort, &Limits::default()).unwrap();
                assert!(small.len() < original.len(), "{what}: {} of {}", small.len(), original.len());
                assert_eq!(kind(&small), expected, "{what}");
                assert_eq!(DecodedPicture::from_bytes(&small, &Limits::default()).unwrap(), before, "{what}");
                let reader = png::Decoder::new(std::io::Cursor::new(&small)).read_info().unwrap();
                assert!(reader.info().srgb.is_some() && reader.info().uncompressed_latin1_text.is_empty());
                // What cannot be made smaller stays as it is.
                assert_eq!(compress_png(&small, effort, &Limits::default()).unwrap(), small);
            }
        }
    }

    #[test]
    fn gamma_and_profiles_stay_and_decide_about_grey() {
        let grey: Vec<u8> = noise(32 * 32).flat_map(|v| [v, v, v]).collect();
        let plain = encode(32, 32, ColorType::Rgb, BitDepth::Eight, &grey);
        for (name, data, expected) in [(b"gAMA", vec![0, 0, 0xb1, 0x8f], 0), (b"iCCP", vec![b'x', 0, 0], 3)] {
            // Behind the header, before all others.
            let mut with_chunk = plain[..33].to_vec();
            push_chunk(&mut with_chunk, name, &data);
            with_chunk.extend(&plain[33..]);
            let small = compress_png(&with_chunk, Effort::Quick, &Limits::default()).unwrap();
            assert!(small.windows(4).any(|w| w == name), "{name:?}");
            // A palette may stand in for colours, for which the profile is; grey may not.
            assert_eq!(kind(&small).1, expected, "{name:?}");
        }
    }

    #[test]
    fn every_filter_can_be_undone() {
        let rows: Vec<Vec<u8>> = noise(5 * 30).collect::<Vec<_>>().chunks(30).map(<[u8]>::to_vec).collect();
        for filter in 0..5 {
            for y in 1..5 {
                let filtered = filter_row(filter, &rows[y], &rows[y - 1], 3);
                let mut row: Vec<u8> = Vec::new();
                for k in 0..30 {
                    let left = if k < 3 { 0 } else { row[k - 3] };
                    let diagonal = if k < 3 { 0 } else { rows[y - 1][k - 3] };
                    let above = rows[y - 1][k];
                    let predicted = match filter {
                        0 => 0,
                        1 => left,
                        2 => above,
                        3 => ((u16::from(left) + u16::from(above)) / 2) as u8,
                        _ => paeth(left, above, diagonal),
                    };
                    row.push(filtered[k].wrapping_add(predicted));
                }
                assert_eq!(row, rows[y], "filter {filter}");
            }
        }
    }

    #[test]
    fn checksums_are_those_of_the_standard() {
        assert_eq!(crc32fast::hash(b"123456789"), 0xcbf4_3926);
        assert_eq!(crc32fast::hash(b"IEND"), 0xae42_6082);
    }
}
