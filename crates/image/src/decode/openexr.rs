//! OpenEXR pictures: the first layer with colours, half, float or integer samples.
//!
//! The crate `exr` reads the header and unpacks the chunks. Where they go is decided here: its own image reader trusts
//! the coordinates in chunks, and ends in an assertion where they lie (1.74: a tile of another level).

use super::error::quoted;
use super::exr_samples::{ExrColors, Projection};
use super::{DecodeError, check_size};
use exr::block::UncompressedBlock;
use exr::block::chunk::{Chunk, CompressedBlock};
use exr::compression::Compression;
use exr::meta::MetaData;
use exr::meta::attribute::{Chromaticities, EnvironmentMap, SampleType};
use exr::meta::header::Header;
use overcoat_core::color::primaries::Primaries;
use overcoat_core::limits::Limits;
use std::io::Cursor;

/// Name of the format in messages.
pub const FORMAT: &str = "OpenEXR";

/// The picture, with what its file says of its colours and its directions.
pub fn read(bytes: &[u8], limits: &Limits) -> Result<ExrColors, DecodeError> {
    let meta = read_meta(bytes, limits)?;
    let layer = Layer::choose(&meta)?;
    check_compression(layer.header)?;
    let (width, height) = (layer.header.layer_size.width(), layer.header.layer_size.height());
    let mut pixels = vec![[0.0; 3]; layer.header.layer_size.area()];
    for_each_block(bytes, &meta, |index| index == layer.index, |_, block| layer.copy(block, &mut pixels))?;
    // Some programs write what is common to all layers into the first one alone.
    let first = meta.headers.first();
    let chromaticities = layer.header.shared_attributes.chromaticities;
    let chromaticities = chromaticities.or_else(|| first?.shared_attributes.chromaticities);
    let projection = layer.header.own_attributes.environment_map;
    Ok(ExrColors {
        width: side(width)?,
        height: side(height)?,
        pixels,
        primaries: chromaticities.map(primaries),
        projection: projection.or_else(|| first?.own_attributes.environment_map).map(|projection| {
            match projection {
                EnvironmentMap::LatitudeLongitude => Projection::LatitudeLongitude,
                EnvironmentMap::Cube => Projection::Cube,
            }
        }),
        warning: differs_between_machines(layer.header),
    })
}

/// The attribute `chromaticities`, whatever its numbers are.
fn primaries(attribute: Chromaticities) -> Primaries {
    let [red, green, blue, white] =
        [attribute.red, attribute.green, attribute.blue, attribute.white].map(|v| [v.x(), v.y()]);
    Primaries { red, green, blue, white }
}

/// The headers alone first: opening all allocates tables of the size that they claim.
pub(super) fn read_meta(bytes: &[u8], limits: &Limits) -> Result<MetaData, DecodeError> {
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(explain)?;
    for header in &meta.headers {
        check_layer(header, bytes.len(), limits)?;
    }
    Ok(meta)
}

/// B44 is rare, and the decoder (exr 1.74) overflows where a file is damaged, which ends debug builds.
pub(super) fn check_compression(header: &Header) -> Result<(), DecodeError> {
    match header.compression {
        Compression::B44 | Compression::B44A => Err(DecodeError::unsupported(FORMAT, "B44 compression")),
        _ => Ok(()),
    }
}

/// Warning for layers whose pixels differ between machines: the decoder of DWA (exr 1.74) has a transform for each
/// instruction set, "not bit-identical to each other", and a table by the platform's `powf`.
fn differs_between_machines(header: &Header) -> Option<String> {
    matches!(header.compression, Compression::DWAA(_) | Compression::DWAB(_)).then(|| {
        format!(
            "{FORMAT}: DWA compression is decoded with other last bits on other processors, so the picture may differ \
             there (ZIP and PIZ do not)"
        )
    })
}

/// Unpacks the blocks of the layers that are wanted, of their largest level, and hands each with the number of its
/// layer to `copy`, which returns `None` for a block that does not lie within the picture.
pub(super) fn for_each_block(
    bytes: &[u8],
    meta: &MetaData,
    wanted: impl Fn(usize) -> bool,
    mut copy: impl FnMut(usize, &UncompressedBlock) -> Option<()>,
) -> Result<(), DecodeError> {
    let reader = exr::block::read(Cursor::new(bytes), false).map_err(explain)?;
    let chunks = reader.all_chunks(false).map_err(explain)?;
    for (number, chunk) in chunks.enumerate() {
        let chunk = chunk.map_err(explain)?;
        // Smaller levels of the same picture have tiles of their own.
        let small = matches!(&chunk.compressed_block, CompressedBlock::Tile(t) if t.coordinates.level_index.0 != 0
            || t.coordinates.level_index.1 != 0);
        let index = chunk.layer_index;
        let Some(header) = meta.headers.get(index).filter(|_| wanted(index) && !small) else { continue };
        check_dwa_chunk(number, &chunk, header)?;
        let block = UncompressedBlock::decompress_chunk(chunk, meta, false).map_err(explain)?;
        copy(index, &block).ok_or_else(|| {
            DecodeError::malformed(FORMAT, format!("chunk {number} does not lie within the picture"))
        })?;
    }
    Ok(())
}

/// A width or height as other pictures have it.
pub(super) fn side(pixels: usize) -> Result<u32, DecodeError> {
    u32::try_from(pixels).map_err(|_| DecodeError::malformed(FORMAT, "a side of 2^32 pixels"))
}

/// The layer that is read, and which of its channels are red, green and blue.
struct Layer<'a> {
    index: usize,
    header: &'a Header,
    rgb: [usize; 3],
}

impl<'a> Layer<'a> {
    fn choose(meta: &'a MetaData) -> Result<Self, DecodeError> {
        for (index, header) in meta.headers.iter().enumerate() {
            let channels = &header.channels.list;
            // Layers within a layer carry their names in the channels: `ViewLayer.Combined.R`.
            let find = |wanted: &str| {
                channels.iter().position(|c| {
                    c.name
                        .to_string()
                        .rsplit('.')
                        .next()
                        .is_some_and(|last| last.eq_ignore_ascii_case(wanted))
                })
            };
            let of = |wanted: &str| find(wanted).or_else(|| find("Y"));
            let whole = channels.iter().all(|c| c.sampling.0 == 1 && c.sampling.1 == 1);
            if let (Some(r), Some(g), Some(b), true, false) = (of("R"), of("G"), of("B"), whole, header.deep)
            {
                return Ok(Self { index, header, rgb: [r, g, b] });
            }
        }
        let names = meta.headers.iter().flat_map(|h| &h.channels.list).take(8).map(|c| c.name.to_string());
        let names = quoted(names.collect::<Vec<_>>().join(" ").as_bytes());
        Err(DecodeError::unsupported(
            FORMAT,
            format!("no full-size colour channels (R, G, B or Y) among {names}"),
        ))
    }

    /// Copies the samples of a block to their places. Rows follow each other, in each the channels one by one.
    fn copy(&self, block: &UncompressedBlock, pixels: &mut [[f32; 3]]) -> Option<()> {
        let (width, index) = (self.header.layer_size.width(), &block.index);
        let (x, columns) = (index.pixel_position.x(), index.pixel_size.width());
        let mut rest = &block.data[..];
        for y in 0..index.pixel_size.height() {
            let start = index.pixel_position.y().checked_add(y)?.checked_mul(width)?.checked_add(x)?;
            if x.checked_add(columns)? > width {
                return None;
            }
            let row = pixels.get_mut(start..start.checked_add(columns)?)?;
            for (number, channel) in self.header.channels.list.iter().enumerate() {
                let samples =
                    rest.split_off(..columns.checked_mul(channel.sample_type.bytes_per_sample())?)?;
                // One channel may stand for several: grey for all three.
                for k in self.rgb.iter().enumerate().filter(|(_, c)| **c == number).map(|(k, _)| k) {
                    let targets = row.iter_mut().filter_map(|pixel| pixel.get_mut(k));
                    // Blocks come in this machine's byte order.
                    match channel.sample_type {
                        SampleType::F16 => targets
                            .zip(samples.as_chunks().0)
                            .for_each(|(t, &v)| *t = half::f16::from_ne_bytes(v).to_f32()),
                        SampleType::F32 => {
                            targets.zip(samples.as_chunks().0).for_each(|(t, &v)| *t = f32::from_ne_bytes(v));
                        }
                        SampleType::U32 => targets
                            .zip(samples.as_chunks().0)
                            .for_each(|(t, &v)| *t = u32::from_ne_bytes(v) as f32),
                    }
                }
            }
        }
        Some(())
    }
}

/// Refuses sizes that the limits do not allow, or that this many bytes cannot hold, before they are allocated.
fn check_layer(header: &Header, file_bytes: usize, limits: &Limits) -> Result<(), DecodeError> {
    let (width, height) = (header.layer_size.width() as u64, header.layer_size.height() as u64);
    let channels = header.channels.list.len() as u64;
    let bytes_per_pixel = channels.saturating_add(3).saturating_mul(4);
    check_size(FORMAT, [width, height], bytes_per_pixel, bytes_of_a_chunk(header), limits)?;
    // Every chunk has at least its place in the offset table.
    if header.chunk_count as u64 > file_bytes as u64 / 8 {
        return Err(DecodeError::malformed(FORMAT, "the file ends before its table of chunks does"));
    }
    Ok(())
}

/// Temporary memory for reading and unpacking the largest chunk, in bytes. The decoder (exr 1.74) believes its claimed
/// size up to that of a whole block, which a flat layer fills a 256th of; then there are its samples, twice, and with
/// DWA three blocks of 64 floats for every 8 x 8 pixels, however few of them there are.
fn bytes_of_a_chunk(header: &Header) -> u64 {
    let (block, layer) = (header.max_block_pixel_size(), header.layer_size);
    let bytes_per_pixel = header.channels.bytes_per_pixel as u64;
    let samples = |width: usize, height: usize| {
        (width as u64).saturating_mul(height as u64).saturating_mul(bytes_per_pixel)
    };
    let (width, height) = (block.width().min(layer.width()), block.height().min(layer.height()));
    let blocks = match header.compression {
        Compression::DWAA(_) | Compression::DWAB(_) => {
            (width.div_ceil(8) as u64).saturating_mul(height.div_ceil(8) as u64)
        }
        _ => 0,
    };
    samples(block.width(), block.height())
        .saturating_add(samples(width, height).saturating_mul(2))
        .saturating_add(blocks.saturating_mul(BYTES_PER_DWA_BLOCK))
}

/// Three times 64 floats and a flag.
const BYTES_PER_DWA_BLOCK: u64 = 3 * (64 * 4 + 1);

/// Refuses a DWA chunk that claims to unpack to more than its whole layer has. The decoder (exr 1.74) allocates what
/// such a chunk claims, up to 2^63 bytes, and a failed allocation ends the process.
fn check_dwa_chunk(number: usize, chunk: &Chunk, header: &Header) -> Result<(), DecodeError> {
    let data = match (&chunk.compressed_block, header.compression) {
        (CompressedBlock::ScanLine(block), Compression::DWAA(_) | Compression::DWAB(_)) => {
            &block.compressed_pixels_le
        }
        (CompressedBlock::Tile(block), Compression::DWAA(_) | Compression::DWAB(_)) => {
            &block.compressed_pixels_le
        }
        _ => return Ok(()),
    };
    // Small layers have blocks of 8 x 8 that are larger than they are.
    let layer = header.layer_size.area().saturating_mul(header.channels.list.len()).saturating_mul(4);
    let most = (layer as u64).saturating_add(4096);
    // Eleven counters: the version, sizes and counts, and the kind of coding.
    let (counters, _) = data.as_chunks::<8>();
    if counters.iter().take(11).any(|&c| u64::from_le_bytes(c) > most) {
        return Err(DecodeError::malformed(
            FORMAT,
            format!("chunk {number} claims to hold more than its layer"),
        ));
    }
    Ok(())
}

fn explain(error: exr::error::Error) -> DecodeError {
    match error {
        exr::error::Error::NotSupported(what) => DecodeError::unsupported(FORMAT, what.to_string()),
        exr::error::Error::Io(e) if e.kind() == std::io::ErrorKind::UnexpectedEof => {
            DecodeError::malformed(FORMAT, "the file ends too early")
        }
        other => DecodeError::malformed(FORMAT, other.to_string()),
    }
}

#[cfg(test)]
mod tests {
    use super::{Cursor, DecodeError, Limits, read};
    use exr::prelude::{
        Blocks, Compression, Encoding, Image, Layer, LayerAttributes, LineOrder, SpecificChannels, Vec2,
        WritableImage as _, f16,
    };

    fn encode(compression: Compression, half: bool) -> Vec<u8> {
        let mut bytes = Vec::new();
        let value = |p: Vec2<usize>| p.x() as f32 * 0.5 - p.y() as f32 * 0.25 + 1.0;
        let encoding = Encoding { compression, ..Encoding::FAST_LOSSLESS };
        let attributes = LayerAttributes::named("main");
        let to = Cursor::new(&mut bytes);
        if half {
            let at = |p| (f16::from_f32(value(p)), f16::from_f32(2.0), f16::from_f32(value(p)), f16::ONE);
            let layer = Layer::new((20, 10), attributes, encoding, SpecificChannels::rgba(at));
            Image::from_layer(layer).write().non_parallel().to_buffered(to).unwrap();
        } else {
            let at = |p| (value(p), 2.0_f32, value(p));
            let layer = Layer::new((20, 10), attributes, encoding, SpecificChannels::rgb(at));
            Image::from_layer(layer).write().non_parallel().to_buffered(to).unwrap();
        }
        bytes
    }

    #[test]
    fn half_and_float_in_several_compressions() {
        use Compression::{PIZ, RLE, Uncompressed, ZIP1, ZIP16};
        for compression in [Uncompressed, RLE, ZIP1, ZIP16, PIZ] {
            for half in [false, true] {
                let picture = read(&encode(compression, half), &Limits::default()).unwrap();
                assert!(picture.warning.is_none() && picture.primaries.is_none());
                assert_eq!((picture.width, picture.height, picture.projection), (20, 10, None));
                for (k, p) in picture.pixels.iter().enumerate() {
                    let v = (k % 20) as f32 * 0.5 - (k / 20) as f32 * 0.25 + 1.0;
                    assert_eq!(*p, [v, 2.0, v], "pixel {k}");
                }
            }
        }
    }

    #[test]
    fn limits_and_damage_are_errors() {
        let bytes = encode(Compression::ZIP16, true);
        let b44 = read(&encode(Compression::B44, true), &Limits::default());
        assert!(matches!(b44, Err(DecodeError::Unsupported { .. })));
        for (compression, warned) in [(Compression::DWAA(None), true), (Compression::PIZ, false)] {
            let picture = read(&encode(compression, true), &Limits::default()).unwrap();
            assert_eq!(picture.warning.is_some(), warned, "{compression:?}");
        }
        let limits = Limits::default().with_texture_pixels(199);
        assert!(matches!(read(&bytes, &limits), Err(DecodeError::Limit(_))));
        for len in [0, 4, 8, 100, bytes.len() / 2, bytes.len() - 1] {
            let error = read(&bytes[..len], &Limits::default()).unwrap_err().to_string();
            assert!(!error.contains('\n'), "{error}");
        }
    }

    /// A layer of 4096 x 1 pixels takes 100 KB, a chunk of 256 lines for it six MB, and its DWA blocks 400 KB.
    #[test]
    fn what_a_chunk_takes_is_limited() {
        let encode = |compression| {
            let mut bytes = Vec::new();
            let (blocks, line_order) = (Blocks::ScanLines, LineOrder::Increasing);
            let encoding = Encoding { compression, blocks, line_order };
            let at = |_| (f16::ONE, f16::ONE, f16::ONE);
            let layer =
                Layer::new((4096, 1), LayerAttributes::named("a"), encoding, SpecificChannels::rgb(at));
            Image::from_layer(layer).write().non_parallel().to_buffered(Cursor::new(&mut bytes)).unwrap();
            bytes
        };
        let (zip, wide, tall) = (Compression::ZIP1, Compression::DWAA(None), Compression::DWAB(None));
        for (compression, least) in [(zip, 170_000), (wide, 1_300_000), (tall, 6_800_000)] {
            let bytes = encode(compression);
            let with = |decoded_bytes| read(&bytes, &Limits::default().with_decoded_bytes(decoded_bytes));
            assert!(matches!(with(least), Err(DecodeError::Limit(_))), "{compression}");
            assert!(with(least + least / 20).is_ok(), "{compression}");
        }
    }

    #[test]
    fn damaged_files_of_every_compression_end_in_a_picture_or_an_error() {
        use Compression::{DWAA, DWAB, PIZ, PXR24, RLE, Uncompressed, ZIP1, ZIP16};
        let limits = Limits::default().with_texture_pixels(1 << 16).with_decoded_bytes(1 << 22);
        let mut state = 1_u64;
        let mut next = |below: usize| {
            // Xorshift: G. Marsaglia, 2003.
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            (state % below as u64) as usize
        };
        for compression in [Uncompressed, RLE, ZIP1, ZIP16, PIZ, PXR24, DWAA(None), DWAB(None)] {
            for half in [false, true] {
                let intact = encode(compression, half);
                assert!(read(&intact, &limits).is_ok(), "{compression:?}");
                for _ in 0..300 {
                    let mut bytes = intact.clone();
                    for _ in 0..1 + next(6) {
                        let at = next(bytes.len());
                        match next(3) {
                            0 => bytes[at] = [0, 1, 127, 128, 255][next(5)],
                            1 => bytes[at] ^= 1 << next(8),
                            _ => bytes.truncate(at.max(8)),
                        }
                    }
                    if let Err(error) = read(&bytes, &limits) {
                        assert!(!error.to_string().contains('\n'));
                    }
                }
            }
        }
    }
}
