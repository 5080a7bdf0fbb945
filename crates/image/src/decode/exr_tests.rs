//! Luminance and chroma, and B44, of files that are written here.

use super::exr_samples::ExrSamples;
use super::openexr::read;
use super::{DecodeError, exr_b44, exr_planes::read_exr_planes};
use exr::compression::Compression;
use exr::math::Vec2;
use exr::meta::attribute::{ChannelDescription, ChannelList, IntegerBounds, LineOrder, SampleType, Text};
use exr::meta::header::Header;
use overcoat_core::limits::Limits;

/// A channel: name, type, whether it is perceptually linear, pixels for each sample.
type Channel = (&'static str, SampleType, bool, [usize; 2]);

const CHROMA: [Channel; 3] = [
    ("BY", SampleType::F32, true, [2, 2]),
    ("RY", SampleType::F32, true, [2, 2]),
    ("Y", SampleType::F32, false, [1, 1]),
];

const HALVES: [Channel; 3] = [
    ("BY", SampleType::F16, true, [2, 2]),
    ("RY", SampleType::F16, true, [2, 2]),
    ("Y", SampleType::F16, false, [1, 1]),
];

/// A picture of channels whose sample at a pixel is `value(channel, [x, y])`.
struct Written<'a> {
    channels: &'a [Channel],
    size: [usize; 2],
    compression: Compression,
    value: &'a dyn Fn(usize, [usize; 2]) -> f32,
}

impl Written<'_> {
    fn header(&self) -> Header {
        let channels = self.channels.iter().map(|&(name, sample_type, quantize_linearly, [across, down])| {
            let sampling = Vec2(across, down);
            ChannelDescription { name: Text::from(name), sample_type, quantize_linearly, sampling }
        });
        let mut list = ChannelList::new(channels.collect());
        let samples = self.channels.iter().map(|(_, kind, _, [a, d])| kind.bytes_per_sample() * 4 / (a * d));
        list.bytes_per_pixel = samples.sum::<usize>() / 4;
        let mut header = Header::new("".into(), Vec2(self.size[0], self.size[1]), list.list.clone());
        header.channels = list;
        header.with_encoding(self.compression, exr::meta::BlockDescription::ScanLines, LineOrder::Increasing)
    }

    /// Samples of some rows, in this machine's byte order.
    fn samples(&self, rows: std::ops::Range<usize>) -> Vec<u8> {
        let mut out = Vec::new();
        for y in rows {
            for (number, (_, kind, _, [across, down])) in self.channels.iter().enumerate() {
                for x in (0..self.size[0]).step_by(*across).filter(|_| y % down == 0) {
                    let value = (self.value)(number, [x, y]);
                    match kind {
                        SampleType::F16 => out.extend(half::f16::from_f32(value).to_ne_bytes()),
                        SampleType::F32 => out.extend(value.to_ne_bytes()),
                        SampleType::U32 => out.extend((value as u32).to_ne_bytes()),
                    }
                }
            }
        }
        out
    }

    /// Packed rows of each chunk, with the first of them.
    fn chunks(&self) -> Vec<(usize, usize, Vec<u8>)> {
        let (mut header, lines) = (self.header(), self.compression.scan_lines_per_block());
        let pack = |top: usize| {
            let height = lines.min(self.size[1] - top);
            if self.is_flat() {
                return (top, height, self.flat_blocks(top, height));
            }
            let samples = self.samples(top..top + height);
            header.channels.bytes_per_pixel = samples.len() / (self.size[0] * height);
            let place = IntegerBounds::new((0, top as i32), (self.size[0], height));
            (top, height, self.compression.compress_image_section_to_le(&header, samples, place).unwrap())
        };
        (0..self.size[1]).step_by(lines).map(pack).collect()
    }

    /// True for B44 with fewer samples than pixels, which the crate does not write.
    fn is_flat(&self) -> bool {
        matches!(self.compression, Compression::B44 | Compression::B44A)
            && self.channels.iter().any(|(.., sampling)| *sampling != [1, 1])
    }

    /// Blocks of three bytes, each of its first sample.
    fn flat_blocks(&self, top: usize, height: usize) -> Vec<u8> {
        let mut out = Vec::new();
        for (number, (.., [across, down])) in self.channels.iter().enumerate() {
            for y in (top..top + height).step_by(4 * down) {
                for x in (0..self.size[0]).step_by(4 * across) {
                    let bits = half::f16::from_f32((self.value)(number, [x, y])).to_bits();
                    let ordered = if bits & 0x8000 != 0 { !bits } else { bits | 0x8000 };
                    out.extend(ordered.to_be_bytes().into_iter().chain([0xfc]));
                }
            }
        }
        out
    }

    /// The whole file (*OpenEXR File Layout*).
    fn file(&self) -> Vec<u8> {
        let mut list = Vec::new();
        for (name, kind, linear, [across, down]) in self.channels {
            list.extend(name.bytes().chain([0]));
            let kind = match kind {
                SampleType::U32 => 0_u32,
                SampleType::F16 => 1,
                SampleType::F32 => 2,
            };
            list.extend(kind.to_le_bytes());
            list.extend([u8::from(*linear), 0, 0, 0]);
            list.extend([*across as u32, *down as u32].map(u32::to_le_bytes).as_flattened());
        }
        list.push(0);
        let window = [0, 0, self.size[0] as i32 - 1, self.size[1] as i32 - 1].map(i32::to_le_bytes);
        let compression = match self.compression {
            Compression::Uncompressed => 0,
            Compression::RLE => 1,
            Compression::ZIP1 => 2,
            Compression::ZIP16 => 3,
            Compression::PIZ => 4,
            Compression::PXR24 => 5,
            Compression::B44 => 6,
            Compression::B44A => 7,
            other => panic!("{other}"),
        };
        let mut bytes = vec![0x76, 0x2f, 0x31, 0x01, 2, 0, 0, 0];
        let attributes: [(&str, &str, &[u8]); 8] = [
            ("channels", "chlist", &list),
            ("compression", "compression", &[compression]),
            ("dataWindow", "box2i", window.as_flattened()),
            ("displayWindow", "box2i", window.as_flattened()),
            ("lineOrder", "lineOrder", &[0]),
            ("pixelAspectRatio", "float", &1.0_f32.to_le_bytes()),
            ("screenWindowCenter", "v2f", &[0; 8]),
            ("screenWindowWidth", "float", &1.0_f32.to_le_bytes()),
        ];
        for (name, kind, value) in attributes {
            bytes.extend(name.bytes().chain([0]).chain(kind.bytes()).chain([0]));
            bytes.extend((value.len() as u32).to_le_bytes());
            bytes.extend(value);
        }
        bytes.push(0);
        let chunks = self.chunks();
        let mut place = bytes.len() + 8 * chunks.len();
        for (_, _, packed) in &chunks {
            bytes.extend((place as u64).to_le_bytes());
            place += 8 + packed.len();
        }
        for (top, _, packed) in &chunks {
            bytes.extend((*top as u32).to_le_bytes());
            bytes.extend((packed.len() as u32).to_le_bytes());
            bytes.extend(packed);
        }
        bytes
    }
}

/// Chroma that changes evenly, so that means between samples are exact: BY, RY, and Y.
fn even(channel: usize, [x, y]: [usize; 2]) -> f32 {
    let (x, y) = (x as f32, y as f32);
    [0.25 - x / 64.0, -0.5 + y / 64.0, 1.0 + x / 8.0 + y / 4.0][channel]
}

const PACKED: [Compression; 5] =
    [Compression::Uncompressed, Compression::RLE, Compression::ZIP1, Compression::ZIP16, Compression::PIZ];

/// In Rec. 709, from the definition: R - Y = RY Y, B - Y = BY Y, and Y is the luminance.
#[test]
fn luminance_and_chroma_are_colours() {
    for compression in PACKED {
        for channels in [CHROMA, HALVES] {
            let written = Written { channels: &channels, size: [24, 34], compression, value: &even };
            let picture = read(&written.file(), &Limits::default()).unwrap();
            assert_eq!((picture.width, picture.height), (24, 34));
            for (k, pixel) in picture.pixels.iter().enumerate() {
                // Beyond the last sample, chroma stays.
                let [x, y] = [(k % 24).min(22), (k / 24).min(32)];
                let (by, ry, luminance) = (even(0, [x, y]), even(1, [x, y]), even(2, [k % 24, k / 24]));
                let (r, b) = ((ry + 1.0) * luminance, (by + 1.0) * luminance);
                let g = (luminance - 0.212_639 * r - 0.072_192 * b) / 0.715_169;
                for (found, expected) in pixel.iter().zip([r, g, b]) {
                    assert!(
                        (found - expected).abs() < 1e-5 * expected.abs().max(1.0),
                        "{compression} {k}: {pixel:?}"
                    );
                }
            }
        }
    }
}

/// Pictures are compared by all their channels, at full size.
#[test]
fn planes_of_chroma_have_means_between_samples() {
    let written = Written { channels: &CHROMA, size: [8, 6], compression: Compression::ZIP16, value: &even };
    let picture = read_exr_planes(&written.file(), &Limits::default()).unwrap();
    let names: Vec<&str> = picture.planes.iter().map(|plane| plane.name.as_str()).collect();
    assert_eq!(names, ["BY", "RY", "Y"]);
    for (channel, plane) in picture.planes.iter().enumerate() {
        let ExrSamples::Float(values) = &plane.samples else { panic!("{plane:?}") };
        let most = if channel == 2 { [7, 5] } else { [6, 4] };
        let expected: Vec<f32> =
            (0..48).map(|k| even(channel, [(k % 8).min(most[0]), (k / 8).min(most[1])])).collect();
        assert_eq!(*values, expected, "{}", plane.name);
    }
}

#[test]
fn other_samplings_are_named() {
    let refused = |channels: &[Channel], size, compression| {
        let written = Written { channels, size, compression: Compression::Uncompressed, value: &even };
        let mut bytes = written.file();
        let place = bytes.windows(12).position(|window| window == b"\0compression").unwrap();
        bytes[place + 12 + 13 + 4] = compression;
        read(&bytes, &Limits::default()).unwrap_err().to_string()
    };
    let quarter = [("Y", SampleType::F32, false, [1, 1]), ("Z", SampleType::F32, false, [4, 1])];
    assert!(refused(&quarter, [8, 8], 0).contains("channels with a sample for 4 x 1 pixels"));
    assert!(refused(&CHROMA, [7, 8], 0).contains("an odd side"));
    let error = refused(&CHROMA, [8, 8], 5);
    assert!(error.contains("subsampled channels with") && error.to_lowercase().contains("pxr24"), "{error}");
    // Luminance that has fewer samples than the picture has pixels is none.
    let halved = CHROMA.map(|(name, kind, linear, _)| (name, kind, linear, [2, 2]));
    assert!(refused(&halved, [8, 8], 0).contains("no full-size colour channels"));
}

#[test]
fn deep_data_is_named() {
    let written = Written { channels: &CHROMA, size: [8, 6], compression: Compression::ZIP1, value: &even };
    let mut bytes = written.file();
    bytes[5] |= 0x08;
    for error in [
        read(&bytes, &Limits::default()).unwrap_err(),
        read_exr_planes(&bytes, &Limits::default()).unwrap_err(),
    ] {
        assert!(
            matches!(error, DecodeError::Unsupported { .. }) && error.to_string().contains("deep data"),
            "{error}"
        );
    }
}

/// Bits that look random, finite or not.
fn noise(channel: usize, [x, y]: [usize; 2]) -> f32 {
    let bits = (x * 2_654_435 + y * 40_503 + channel * 977) ^ (x * y * 7919);
    half::f16::from_bits(bits as u16).to_f32()
}

/// Intact chunks are what the crate's decoder makes of them, to the last bit.
#[test]
fn b44_is_unpacked_as_by_the_crate() {
    let channels = [
        ("A", SampleType::F16, true, [1, 1]),
        ("B", SampleType::F16, false, [1, 1]),
        ("D", SampleType::F32, false, [1, 1]),
        ("I", SampleType::U32, false, [1, 1]),
    ];
    for compression in [Compression::B44, Compression::B44A] {
        for size in [[16, 8], [13, 35], [1, 1], [5, 33]] {
            for value in [noise, |_, [x, y]: [usize; 2]| (x + y) as f32 / 8.0, |_, _| 0.25] {
                let written = Written { channels: &channels, size, compression, value: &value };
                let header = written.header();
                for (top, height, packed) in written.chunks() {
                    let place = IntegerBounds::new((0, top as i32), (size[0], height));
                    let own = exr_b44::unpack(&packed, &header, top, size[0], height).unwrap();
                    let crates = compression.decompress_image_section_from_le(&header, packed, place, false);
                    assert!(own == crates.unwrap(), "{compression} {size:?} {top}");
                }
            }
        }
    }
}

/// A block of three bytes for each of all halves, in a channel that is perceptually linear.
#[test]
fn logarithms_of_all_halves_are_those_of_the_table() {
    let channels = [("A", SampleType::F16, true, [1, 1])];
    let written =
        Written { channels: &channels, size: [1024, 32], compression: Compression::B44A, value: &even };
    let header = written.header();
    let place = IntegerBounds::new((0, 0), (1024, 32));
    for first in (0..=u16::MAX).step_by(2048) {
        let packed: Vec<u8> = (first..=first + 2047)
            .flat_map(|bits| {
                let ordered = if bits & 0x8000 != 0 { !bits } else { bits | 0x8000 };
                let [high, low] = ordered.to_be_bytes();
                [high, low, 0xfc]
            })
            .collect();
        let own = exr_b44::unpack(&packed, &header, 0, 1024, 32).unwrap();
        let crates =
            Compression::B44A.decompress_image_section_from_le(&header, packed, place, false).unwrap();
        let halves = |bytes: &[u8]| -> Vec<u16> {
            bytes.as_chunks().0.iter().map(|b| u16::from_ne_bytes(*b)).collect()
        };
        for (own, table) in halves(&own).into_iter().zip(halves(&crates)) {
            assert_eq!(own, table, "halves from {first:#x}");
        }
    }
}

/// Values that are equal over each block of 4 x 4 samples.
fn blocks(channel: usize, [x, y]: [usize; 2]) -> f32 {
    let side = if channel == 2 { 4 } else { 8 };
    even(channel, [x / side, y / side])
}

#[test]
fn chroma_in_b44_is_what_it_was() {
    let channels = HALVES.map(|(name, kind, _, sampling)| (name, kind, false, sampling));
    let written =
        Written { channels: &channels, size: [40, 36], compression: Compression::B44A, value: &blocks };
    let picture = read(&written.file(), &Limits::default()).unwrap();
    let plain = Written { compression: Compression::ZIP16, ..written };
    assert_eq!(picture.pixels, read(&plain.file(), &Limits::default()).unwrap().pixels);
}

/// Wherever a file ends and whatever bit is turned, there is a picture or an error of one line.
#[test]
fn damaged_files_end_in_a_picture_or_an_error() {
    let limits = Limits::default().with_texture_pixels(1 << 16).with_decoded_bytes(1 << 22);
    for compression in [Compression::B44, Compression::PIZ, Compression::RLE, Compression::Uncompressed] {
        let intact = Written { channels: &HALVES, size: [12, 10], compression, value: &even }.file();
        let check = |bytes: &[u8]| {
            for error in
                [read(bytes, &limits).err(), read_exr_planes(bytes, &limits).err()].into_iter().flatten()
            {
                assert!(!error.to_string().contains('\n'), "{error}");
            }
        };
        for len in 0..intact.len() {
            check(&intact[..len]);
            // Several parts are claimed, of which the last does not end.
            let mut parts = intact[..len].to_vec();
            parts.iter_mut().skip(5).take(1).for_each(|flags| *flags |= 0x10);
            check(&parts);
        }
        for bit in 0..intact.len() * 8 {
            let mut bytes = intact.clone();
            bytes[bit / 8] ^= 1 << (bit % 8);
            check(&bytes);
        }
    }
}
