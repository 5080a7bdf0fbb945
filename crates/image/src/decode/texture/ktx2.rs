//! KTX2 textures: those of KHR_texture_basisu (ETC1S and UASTC), and uncompressed ones of 8 bits.
//!
//! Only the first level is read; the smaller ones are made anew like those of every picture. The container is read and
//! checked here; what decodes blocks gets slices of a size that has been checked. Its own reader of containers is not
//! used: it overflows on damaged files, and brings the tables of two dozen formats for graphics cards.

use super::{area, etc1s};
use basisu::basislz::etc1s::Etc1sTranscoder;
use basisu::uastc::unpack::unpack_uastc;
use ruzstd::decoding::StreamingDecoder;
use std::io::Read;

/// First bytes of every file.
pub const MAGIC: [u8; 12] = *b"\xabKTX 20\xbb\r\n\x1a\n";

/// Bytes that decoding ETC1S takes for each texel for a while, at most: two blocks, and their numbers, for sixteen.
pub const TRANSIENT: u64 = 2;

/// Largest window of supercompressed data, in bytes: as much as other decoders of pictures may use beside the picture.
const MAX_WINDOW: u64 = 64 << 20;

/// Most texels of a texture.
const MAX_TEXELS: u64 = 1 << 28;

/// Colour models of the Khronos data format specification.
const ETC1S: u8 = 163;
const UASTC: u8 = 166;

/// Channels of the same specification: the second slice of ETC1S is green; the alpha of UASTC is green.
const ETC1S_GREEN: u8 = 4;
const UASTC_GREEN_IN_ALPHA: u8 = 5;

/// Flag of a picture in ETC1S that is a difference from the one before.
const IS_DIFFERENCE: u32 = 2;

/// Storage of the texels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Storage {
    /// Blocks of 4 x 4 with shared tables; a second slice holds alpha, or green of those with two channels.
    Etc1s { second: Option<u8> },
    /// Blocks of 4 x 4 of 16 bytes; the channels by their number.
    Uastc { channels: u8 },
    /// Uncompressed texels of this many bytes each.
    Plain(usize),
}

/// A texture whose container has been checked.
#[derive(Debug)]
pub struct Ktx2<'a> {
    /// In texels, at least 1.
    pub width: u32,
    /// In texels, at least 1.
    pub height: u32,
    storage: Storage,
    /// The first level is compressed with Zstandard.
    zstd: bool,
    level: &'a [u8],
    /// The tables of ETC1S.
    global: &'a [u8],
    levels: u32,
}

/// Reads the container.
///
/// # Errors
/// One line that says what is wrong, or what is there that cannot be read.
pub fn open(bytes: &[u8]) -> Result<Ktx2<'_>, String> {
    let cut_off = || "the KTX2 texture is cut off".to_owned();
    let part = |start: u64, length: u64| {
        let range = usize::try_from(start).ok()?..usize::try_from(start.checked_add(length)?).ok()?;
        bytes.get(range)
    };
    let long = |at: u64| Some(u64::from_le_bytes(*part(at, 8)?.first_chunk()?));
    let word = |at: u64| Some(u32::from_le_bytes(*part(at, 4)?.first_chunk()?));
    if !bytes.starts_with(&MAGIC) {
        return Err("it is no KTX2 texture".to_owned());
    }
    let header = || {
        let words = [12, 20, 24, 28, 32, 36, 40, 44, 48, 52].map(word);
        let longs = [64, 72, 80, 88].map(long);
        Some((words.into_iter().collect::<Option<Vec<_>>>()?, longs.into_iter().collect::<Option<Vec<_>>>()?))
    };
    let (words, longs) = header().ok_or_else(cut_off)?;
    let (
        [format, width, height, depth, layers, faces, levels, scheme, dfd, dfd_length],
        [global, global_length, level, length],
    ) = (words.as_slice(), longs.as_slice())
    else {
        return Err(cut_off());
    };
    if *width == 0 || *height == 0 || *depth > 0 || *layers > 1 || *faces != 1 {
        return Err("the KTX2 texture is not one two-dimensional picture".to_owned());
    }
    // The transcoder counts in 32 bits.
    if area(*width, *height) > MAX_TEXELS {
        return Err(format!("a KTX2 texture of {width} x {height} texels cannot be read"));
    }
    let descriptor = part((*dfd).into(), (*dfd_length).into()).ok_or_else(cut_off)?;
    let level = part(*level, *length).ok_or_else(cut_off)?;
    // Byte 3 of a sample.
    let samples = descriptor.get(28..).unwrap_or_default();
    let channel = |sample: usize| Some(samples.chunks(16).nth(sample)?.get(3)? & 15);
    let storage = match (format, descriptor.get(12)) {
        (0, Some(&ETC1S)) if *scheme == 1 => Storage::Etc1s { second: channel(1) },
        (0, Some(&UASTC)) => Storage::Uastc { channels: channel(0).ok_or_else(cut_off)? },
        (37 | 43, _) => Storage::Plain(4),
        (23 | 29, _) => Storage::Plain(3),
        _ => return Err(format!("KTX2 textures of the format {format} cannot be read")),
    };
    let zstd = match (scheme, storage) {
        (0, _) | (1, Storage::Etc1s { .. }) => false,
        (2, Storage::Uastc { .. } | Storage::Plain(_)) => true,
        _ => return Err(format!("KTX2 textures with supercompression {scheme} cannot be read")),
    };
    let global = match storage {
        Storage::Etc1s { .. } => part(*global, *global_length).ok_or_else(cut_off)?,
        _ => &[],
    };
    Ok(Ktx2 { width: *width, height: *height, storage, zstd, level, global, levels: *levels })
}

impl Ktx2<'_> {
    /// True if it is decoded one row of blocks at a time: all but ETC1S, whose blocks refer to those above.
    pub fn is_read_by_rows(&self) -> bool {
        !matches!(self.storage, Storage::Etc1s { .. })
    }

    /// Gives the rows of texels from the top on, until one is not taken. `raw` is room for stored data, or for all blocks of
    /// ETC1S.
    ///
    /// # Errors
    /// One line that says what is wrong, whatever rows were given.
    pub fn rows(&self, raw: &mut Vec<u8>, take: &mut dyn FnMut(&[[u8; 4]]) -> bool) -> Result<(), String> {
        let width = usize::try_from(self.width).map_err(|_| damaged())?;
        raw.clear();
        match self.storage {
            Storage::Etc1s { second } => {
                let columns = width.div_ceil(4).saturating_mul(etc1s::BLOCK);
                let rows = usize::try_from(self.height.div_ceil(4)).map_err(|_| damaged())?;
                let size = columns.checked_mul(rows).ok_or_else(damaged)?;
                raw.resize(if second.is_some() { size.checked_mul(2).ok_or_else(damaged)? } else { size }, 0);
                let (blocks, of_alpha) = raw.split_at_mut(size);
                self.etc1s(blocks, second.is_some().then_some(&mut *of_alpha)).ok_or_else(damaged)?;
                let mut of_alpha = of_alpha.chunks(columns);
                let mut texels = vec![[255; 4]; width.saturating_mul(4)];
                let mut left = usize::try_from(self.height).map_err(|_| damaged())?;
                for blocks in blocks.chunks(columns) {
                    etc1s::row_of_blocks(blocks, of_alpha.next(), width, &mut texels);
                    if second == Some(ETC1S_GREEN) {
                        texels.iter_mut().for_each(green_from_alpha);
                    }
                    if !texels.chunks(width).take(left.min(4)).all(&mut *take) {
                        break;
                    }
                    left = left.saturating_sub(4);
                }
                Ok(())
            }
            Storage::Plain(size) => {
                raw.resize(width.saturating_mul(size), 0);
                let mut row = vec![[255; 4]; width];
                self.stored_rows(self.height, raw, &mut |raw| {
                    for (texel, from) in row.iter_mut().zip(raw.chunks_exact(size)) {
                        texel.iter_mut().zip(from).for_each(|(to, from)| *to = *from);
                    }
                    Ok(take(&row))
                })
            }
            Storage::Uastc { channels } => {
                raw.resize(width.div_ceil(4).saturating_mul(16), 0);
                let mut texels = vec![[255; 4]; width.saturating_mul(4)];
                let mut left = usize::try_from(self.height).map_err(|_| damaged())?;
                self.stored_rows(self.height.div_ceil(4), raw, &mut |raw| {
                    row_of_blocks(raw, width, &mut texels).ok_or_else(damaged)?;
                    if channels == UASTC_GREEN_IN_ALPHA {
                        texels.iter_mut().for_each(green_from_alpha);
                    }
                    let rows = left.min(4);
                    left = left.saturating_sub(rows);
                    Ok(texels.chunks(width).take(rows).all(&mut *take))
                })
            }
        }
    }

    /// Reads `count` rows of stored data, of the length of `raw`, until `take` is done.
    fn stored_rows(
        &self,
        count: u32,
        raw: &mut [u8],
        take: &mut dyn FnMut(&[u8]) -> Result<bool, String>,
    ) -> Result<(), String> {
        let wrong = |what: &str| format!("the Zstandard data of the KTX2 texture {what}");
        if !self.zstd {
            let rows = self.level.chunks_exact(raw.len());
            if u64::from(count) > rows.len() as u64 {
                return Err("the KTX2 texture is cut off".to_owned());
            }
            for row in rows.take(usize::try_from(count).unwrap_or(usize::MAX)) {
                if !take(row)? {
                    break;
                }
            }
            return Ok(());
        }
        let mut decoder = StreamingDecoder::new_with_max_window_size(self.level, MAX_WINDOW)
            .map_err(|_| wrong("is damaged"))?;
        for number in 1..=count {
            decoder.read_exact(raw).map_err(|_| wrong("is damaged or too short"))?;
            if !take(raw)? && number < count {
                return Ok(());
            }
        }
        match decoder.read(&mut [0]) {
            Ok(0) => Ok(()),
            _ => Err(wrong("is damaged or too long")),
        }
    }

    /// Decodes the texels, which have been charged.
    ///
    /// # Errors
    /// One line that says what is wrong.
    pub fn decode(&self) -> Result<Vec<[u8; 4]>, String> {
        let count = usize::try_from(area(self.width, self.height)).map_err(|_| damaged())?;
        let mut texels = Vec::with_capacity(count);
        self.rows(&mut Vec::new(), &mut |row| {
            texels.extend_from_slice(row);
            true
        })?;
        Ok(texels)
    }

    /// Decodes one or two slices of ETC1S to blocks of ETC1. `None` where something is damaged, or where the picture
    /// is a difference to another one.
    fn etc1s(&self, first: &mut [u8], second: Option<&mut [u8]>) -> Option<()> {
        // The global data (KTX file format 2.0, section "BasisLZ"): counts, lengths, a description of 20 bytes for each
        // level, and the tables.
        let short = |at: usize| Some(u16::from_le_bytes(*self.global.get(at..)?.first_chunk()?));
        let word = |at: usize| Some(u32::from_le_bytes(*self.global.get(at..)?.first_chunk()?));
        let length = |at: usize| usize::try_from(word(at)?).ok();
        let levels = usize::try_from(self.levels.max(1)).ok()?;
        let tables = self.global.get(levels.checked_mul(20)?.checked_add(20)?..)?;
        let (endpoints, tables) = tables.split_at_checked(length(4)?)?;
        let (selectors, tables) = tables.split_at_checked(length(8)?)?;
        let tables = tables.get(..length(12)?)?;
        if word(20)? & IS_DIFFERENCE != 0 {
            return None;
        }
        let slice = |at: usize| self.level.get(length(at)?..)?.get(..length(at.checked_add(4)?)?);
        let mut decoder = Etc1sTranscoder::new();
        let read = decoder.decode_palettes(short(0)?.into(), endpoints, short(2)?.into(), selectors)
            && decoder.decode_tables(tables);
        if !read {
            return None;
        }
        let [columns, rows] = [self.width, self.height].map(|side| side.div_ceil(4));
        decoder.transcode_slice_etc1(slice(24)?, columns, rows, None, first)?;
        match second {
            Some(second) => decoder.transcode_slice_etc1(slice(32)?, columns, rows, None, second),
            None => Some(()),
        }
    }
}

/// Two channels whose second is kept where alpha is with others.
fn green_from_alpha(texel: &mut [u8; 4]) {
    let [red, .., alpha] = *texel;
    *texel = [red, alpha, 0, 255];
}

/// Decodes a row of blocks of UASTC to four rows of texels. `None` where one is damaged.
fn row_of_blocks(raw: &[u8], width: usize, texels: &mut [[u8; 4]]) -> Option<()> {
    for (x, block) in raw.as_chunks::<16>().0.iter().enumerate() {
        let colors = unpack_uastc(block, false)?;
        let (lines, _) = colors.as_chunks::<4>();
        for (line, texels) in lines.iter().zip(texels.chunks_mut(width)) {
            let texels = texels.chunks_mut(4).nth(x)?;
            texels.iter_mut().zip(line).for_each(|(texel, color)| *texel = color.c);
        }
    }
    Some(())
}

fn damaged() -> String {
    "the KTX2 texture is damaged".to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use ruzstd::encoding::{CompressionLevel, compress_to_vec};

    /// A container with one level, written field by field.
    fn file(
        format: u32,
        [width, height]: [u32; 2],
        scheme: u32,
        descriptor: &[u8],
        level: &[u8],
        whole: usize,
    ) -> Vec<u8> {
        let mut out = MAGIC.to_vec();
        let place = 104 + descriptor.len();
        for word in [format, 1, width, height, 0, 0, 1, 1, scheme, 104, descriptor.len() as u32, 0, 0] {
            out.extend(word.to_le_bytes());
        }
        for long in [0, 0, place, level.len(), whole] {
            out.extend((long as u64).to_le_bytes());
        }
        out.extend(descriptor);
        out.extend(level);
        out
    }

    /// The descriptor of a UASTC texture with alpha.
    fn uastc_descriptor() -> Vec<u8> {
        let mut descriptor = vec![0; 44];
        descriptor[0] = 44;
        descriptor[12] = UASTC;
        descriptor[31] = 3;
        descriptor
    }

    /// A block of one colour: mode 8, whose code is 10111, and four channels of 8 bits, from the lowest bit on.
    fn solid([r, g, b, a]: [u8; 4]) -> [u8; 16] {
        let bits = 23 | u128::from(u32::from_le_bytes([r, g, b, a])) << 5;
        bits.to_le_bytes()
    }

    fn read(bytes: &[u8]) -> Result<Vec<[u8; 4]>, String> {
        open(bytes)?.decode()
    }

    fn zstd(bytes: &[u8]) -> Vec<u8> {
        compress_to_vec(bytes, CompressionLevel::Fastest)
    }

    /// 7 x 5 texels in four blocks, and the texels that they stand for.
    fn blocks() -> (Vec<u8>, Vec<[u8; 4]>) {
        let colors = [[255, 0, 0, 255], [0, 255, 0, 128], [1, 2, 3, 4], [200, 100, 50, 0]];
        let texels = (0..35).map(|k| colors[k % 7 / 4 + k / 7 / 4 * 2]).collect();
        (colors.map(solid).concat(), texels)
    }

    #[test]
    fn blocks_of_one_colour() {
        let (level, texels) = blocks();
        let plain = file(0, [7, 5], 0, &uastc_descriptor(), &level, 64);
        assert_eq!(read(&plain).unwrap(), texels);
        let packed = file(0, [7, 5], 2, &uastc_descriptor(), &zstd(&level), 64);
        assert_eq!(read(&packed).unwrap(), texels);
        assert_eq!((open(&plain).unwrap().width, open(&plain).unwrap().height), (7, 5));
    }

    #[test]
    fn rows_come_one_by_one() {
        let (level, texels) = blocks();
        for (scheme, level) in [(0, level.clone()), (2, zstd(&level))] {
            let bytes = file(0, [7, 5], scheme, &uastc_descriptor(), &level, 64);
            let texture = open(&bytes).unwrap();
            assert!(texture.is_read_by_rows());
            for wanted in 1..=5 {
                // Room that held another picture.
                let (mut raw, mut rows) = (vec![9; 3], Vec::new());
                let take = &mut |row: &[[u8; 4]]| {
                    rows.push(row.to_vec());
                    rows.len() < wanted
                };
                texture.rows(&mut raw, take).unwrap();
                assert_eq!(rows.concat(), texels[..wanted * 7]);
                // One row of blocks.
                assert_eq!(raw.len(), 32);
            }
        }
        let bytes = etc1s();
        let texture = open(&bytes).unwrap();
        assert!(!texture.is_read_by_rows());
        let mut rows = Vec::new();
        texture
            .rows(&mut vec![9; 99], &mut |row| {
                rows.push(row.to_vec());
                rows.len() < 3
            })
            .unwrap();
        assert_eq!(rows.concat(), texture.decode().unwrap()[..12]);
    }

    /// Bits from the lowest of each byte on.
    #[derive(Default)]
    struct Bits(Vec<bool>);

    impl Bits {
        fn put(&mut self, value: u32, count: usize) {
            self.0.extend((0..count).map(|k| value >> k & 1 == 1));
        }

        /// A Huffman table of two symbols, `first` and the next: their codes are the bits 0 and 1.
        fn table(&mut self, first: usize) {
            self.put(first as u32 + 2, 14);
            // Lengths of codes are 0 or 1. Their own codes are one bit; in the order that is prescribed the length 0
            // has place 4 and the length 1 place 18.
            self.put(19, 5);
            (0..19).for_each(|place| self.put(u32::from(place == 4 || place == 18), 3));
            (0..first).for_each(|_| self.put(0, 1));
            self.put(0b11, 2);
        }

        fn bytes(&self) -> Vec<u8> {
            self.0
                .chunks(8)
                .map(|bits| bits.iter().rev().fold(0, |byte, &bit| byte << 1 | u8::from(bit)))
                .collect()
        }
    }

    /// One block of ETC1S (section "BasisLZ" of the KTX2 specification): one endpoint, grey 20 of 31 with the
    /// modifiers 3, and one selector whose rows go from the darkest to the brightest.
    fn etc1s() -> Vec<u8> {
        let mut endpoints = Bits::default();
        for first in [0, 4, 0, 3] {
            endpoints.table(first);
        }
        // Grey; the symbol 3 for the modifiers, the symbol 4 more than 16 for the colour.
        endpoints.put(1, 1);
        endpoints.put(0, 2);
        let mut selectors = Bits::default();
        // As they are.
        selectors.put(0b100, 3);
        (0..4).for_each(|_| selectors.put(0b11_10_01_00, 8));
        let mut tables = Bits::default();
        for first in [3, 0, 0, 0] {
            tables.table(first);
        }
        tables.put(1, 13);
        let parts = [endpoints, selectors, tables].map(|bits| bits.bytes());
        let mut global = vec![1, 0, 1, 0];
        for length in [parts[0].len(), parts[1].len(), parts[2].len(), 0, 0, 0, 1, 0, 0] {
            global.extend((length as u32).to_le_bytes());
        }
        global.extend(parts.concat());
        let mut descriptor = vec![0; 44];
        descriptor[12] = ETC1S;
        // The first symbols of the tables: the endpoint is none of a neighbour's but number 0, and so is the selector.
        let mut whole = file(0, [4, 4], 1, &descriptor, &[0], 0);
        let place = whole.len() as u64;
        whole[64..72].copy_from_slice(&place.to_le_bytes());
        whole[72..80].copy_from_slice(&(global.len() as u64).to_le_bytes());
        whole.extend(global);
        whole
    }

    #[test]
    fn a_block_of_shared_tables() {
        // 20 of 31 is 165 of 255; the modifiers are 42 and 13 to both sides.
        let row = [123, 152, 178, 207].map(|v| [v, v, v, 255]);
        assert_eq!(read(&etc1s()).unwrap(), [row; 4].concat());
    }

    #[test]
    fn bytes_for_each_channel() {
        let rgba = [1, 2, 3, 4, 5, 6, 7, 8];
        for format in [37, 43] {
            assert_eq!(read(&file(format, [2, 1], 0, &[], &rgba, 8)).unwrap(), [[1, 2, 3, 4], [5, 6, 7, 8]]);
            let packed = file(format, [2, 1], 2, &[], &zstd(&rgba), 8);
            assert_eq!(read(&packed).unwrap(), [[1, 2, 3, 4], [5, 6, 7, 8]]);
        }
        for format in [23, 29] {
            assert_eq!(
                read(&file(format, [1, 2], 0, &[], &rgba[..6], 6)).unwrap(),
                [[1, 2, 3, 255], [4, 5, 6, 255]]
            );
        }
    }

    #[test]
    fn what_cannot_be_read_says_so() {
        let message = |change: &dyn Fn(&mut Vec<u8>)| {
            let mut bytes = file(37, [2, 1], 0, &[], &[0; 8], 8);
            change(&mut bytes);
            read(&bytes).unwrap_err()
        };
        let shape = "the KTX2 texture is not one two-dimensional picture";
        for (place, value) in [(20, 0), (24, 0), (28, 1), (32, 2), (36, 6)] {
            assert_eq!(message(&|bytes| bytes[place] = value), shape);
        }
        assert_eq!(message(&|bytes| bytes[12] = 97), "KTX2 textures of the format 97 cannot be read");
        assert_eq!(message(&|bytes| bytes[44] = 3), "KTX2 textures with supercompression 3 cannot be read");
        assert_eq!(message(&|bytes| bytes[24] = 2), "the KTX2 texture is cut off");
        assert!(message(&|bytes| bytes[20..28].fill(255)).ends_with("texels cannot be read"));
        assert!(message(&|bytes| bytes[44] = 2).contains("Zstandard"));
        let long = file(37, [2, 1], 2, &[], &zstd(&[0; 9]), 8);
        assert_eq!(read(&long).unwrap_err(), "the Zstandard data of the KTX2 texture is damaged or too long");
        let short = file(37, [2, 1], 2, &[], &zstd(&[0; 7]), 8);
        assert_eq!(
            read(&short).unwrap_err(),
            "the Zstandard data of the KTX2 texture is damaged or too short"
        );
        // A frame that asks for a window of a gigabyte.
        let window = file(37, [2, 1], 2, &[], &[0x28, 0xb5, 0x2f, 0xfd, 0, 0xa0, 1, 0, 0], 8);
        assert_eq!(read(&window).unwrap_err(), "the Zstandard data of the KTX2 texture is damaged");
    }

    #[test]
    fn every_truncation_is_an_error_and_no_damage_a_panic() {
        let (level, _) = blocks();
        let mut seed = 5u64;
        let mut random = |below: usize| {
            seed ^= seed << 13;
            seed ^= seed >> 7;
            seed ^= seed << 17;
            (seed >> 20) as usize % below
        };
        for whole in [
            file(0, [7, 5], 0, &uastc_descriptor(), &level, 64),
            file(0, [7, 5], 2, &uastc_descriptor(), &zstd(&level), 64),
            file(37, [2, 1], 2, &[], &zstd(&[9; 8]), 8),
            etc1s(),
        ] {
            for length in 0..whole.len() {
                read(&whole[..length]).unwrap_err();
            }
            for _ in 0..5000 {
                let mut damaged = whole.clone();
                for _ in 0..1 + random(4) {
                    // Sizes stay small: who reads them looks at them before.
                    let at = if random(3) == 0 {
                        28 + random(damaged.len() - 28)
                    } else {
                        104 + random(damaged.len() - 104)
                    };
                    damaged[at] = random(256) as u8;
                }
                let _ = read(&damaged);
            }
        }
    }
}
