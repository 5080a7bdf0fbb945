//! OpenEXR pictures: the first layer with colours, half, float or integer samples.
//!
//! The crate `exr` reads the header and unpacks the chunks. Where they go is decided here: its own image reader trusts
//! the coordinates in chunks, and ends in an assertion where they lie (1.74: a tile of another level).

use super::error::quoted;
use super::exr_b44;
use super::exr_chroma::{ChromaLayer, weights};
use super::exr_samples::{ExrColors, Projection};
use super::exr_sampling::{bytes_of_rows, is_subsampled, restore, without_sampling};
use super::{DecodeError, check_size};
use exr::block::chunk::{Chunk, CompressedBlock, CompressedScanLineBlock, CompressedTileBlock};
use exr::block::{BlockIndex, UncompressedBlock};
use exr::compression::Compression;
use exr::meta::MetaData;
use exr::meta::attribute::{Chromaticities, EnvironmentMap, SampleType};
use exr::meta::header::Header;
use overcoat_core::color::primaries::Primaries;
use overcoat_core::limits::Limits;
use std::borrow::Cow;
use std::io::Cursor;

/// Name of the format in messages.
pub const FORMAT: &str = "OpenEXR";

/// The picture, with what its file says of its colours and its directions.
pub fn read(bytes: &[u8], limits: &Limits) -> Result<ExrColors, DecodeError> {
    let file = File::open(bytes, limits)?;
    let layer = Colors::choose(&file.meta)?;
    let header = layer.header();
    let (width, height) = (header.layer_size.width(), header.layer_size.height());
    // Some programs write what is common to all layers into the first one alone.
    let first = file.meta.headers.first();
    let chromaticities = header.shared_attributes.chromaticities;
    let chromaticities = chromaticities.or_else(|| first?.shared_attributes.chromaticities);
    let primaries = chromaticities.map(primaries);
    let projection = header.own_attributes.environment_map;
    let pixels = match &layer {
        Colors::Rgb(layer) => layer.read(&file)?,
        Colors::Chroma(layer) => layer.read(&file, weights(primaries))?,
    };
    Ok(ExrColors {
        width: side(width)?,
        height: side(height)?,
        pixels,
        primaries,
        projection: projection.or_else(|| first?.own_attributes.environment_map).map(|projection| {
            match projection {
                EnvironmentMap::LatitudeLongitude => Projection::LatitudeLongitude,
                EnvironmentMap::Cube => Projection::Cube,
            }
        }),
        warning: differs_between_machines(header),
    })
}

/// The first layer with colours.
enum Colors<'a> {
    Rgb(Layer<'a>),
    Chroma(ChromaLayer<'a>),
}

impl<'a> Colors<'a> {
    fn choose(meta: &'a MetaData) -> Result<Self, DecodeError> {
        Layer::choose(meta)
            .map(Self::Rgb)
            .or_else(|error| ChromaLayer::choose(meta).map(Self::Chroma).ok_or(error))
    }

    fn header(&self) -> &'a Header {
        match self {
            Self::Rgb(layer) => layer.header,
            Self::Chroma(layer) => layer.header,
        }
    }
}

/// The attribute `chromaticities`, whatever its numbers are.
fn primaries(attribute: Chromaticities) -> Primaries {
    let [red, green, blue, white] =
        [attribute.red, attribute.green, attribute.blue, attribute.white].map(|v| [v.x(), v.y()]);
    Primaries { red, green, blue, white }
}

/// A file whose headers are read and held against the limits.
pub(super) struct File<'a> {
    /// Bytes of the file, with headers that the crate takes.
    bytes: Cow<'a, [u8]>,
    /// Headers as the file has them.
    pub meta: MetaData,
}

impl<'a> File<'a> {
    /// Reads the headers alone first: opening all allocates tables of the size that they claim.
    pub fn open(bytes: &'a [u8], limits: &Limits) -> Result<Self, DecodeError> {
        // Bit 11 of the version field: *OpenEXR File Layout*, "Version Field".
        if bytes.get(5).is_some_and(|flags| flags & 0x08 != 0) {
            return Err(DecodeError::unsupported(FORMAT, "deep data, several samples a pixel"));
        }
        let (bytes, factors) = match without_sampling(bytes) {
            Some((changed, factors)) => (Cow::Owned(changed), factors),
            None => (Cow::Borrowed(bytes), Vec::new()),
        };
        let mut meta = MetaData::read_from_buffered(Cursor::new(&*bytes), false).map_err(explain)?;
        for (header, factors) in meta.headers.iter_mut().zip(&factors) {
            restore(header, factors)?;
        }
        for header in &meta.headers {
            check_layer(header, bytes.len(), limits)?;
        }
        Ok(Self { bytes, meta })
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
    file: &File<'_>,
    wanted: impl Fn(usize) -> bool,
    mut copy: impl FnMut(usize, &UncompressedBlock) -> Option<()>,
) -> Result<(), DecodeError> {
    let reader = exr::block::read(Cursor::new(&*file.bytes), false).map_err(explain)?;
    let chunks = reader.all_chunks(false).map_err(explain)?;
    let mut meta = file.meta.clone();
    for (number, chunk) in chunks.enumerate() {
        let chunk = chunk.map_err(explain)?;
        // Smaller levels of the same picture have tiles of their own.
        let small = matches!(&chunk.compressed_block, CompressedBlock::Tile(t) if t.coordinates.level_index.0 != 0
            || t.coordinates.level_index.1 != 0);
        let index = chunk.layer_index;
        let Some(header) = file.meta.headers.get(index).filter(|_| wanted(index) && !small) else { continue };
        check_dwa_chunk(number, &chunk, header)?;
        let block = unpacked(chunk, header, &mut meta)?
            .ok_or_else(|| DecodeError::malformed(FORMAT, format!("chunk {number} is damaged")))?;
        copy(index, &block).ok_or_else(|| {
            DecodeError::malformed(FORMAT, format!("chunk {number} does not lie within the picture"))
        })?;
    }
    Ok(())
}

/// Unpacks a chunk. `meta` is a copy of the headers of its file; `None` if the chunk is not what its header says.
fn unpacked(
    chunk: Chunk,
    header: &Header,
    meta: &mut MetaData,
) -> Result<Option<UncompressedBlock>, DecodeError> {
    let is_b44 = matches!(header.compression, Compression::B44 | Compression::B44A);
    if !is_b44 && !is_subsampled(header) {
        return UncompressedBlock::decompress_chunk(chunk, meta, false).map(Some).map_err(explain);
    }
    let tile = header.get_block_data_indices(&chunk.compressed_block).map_err(explain)?;
    let place = header.get_absolute_block_pixel_coordinates(tile).map_err(explain)?;
    place.validate(Some(header.layer_size)).map_err(explain)?;
    let position = place.position.to_usize("chunk").map_err(explain)?;
    let (size, y) = (place.size, position.y());
    if is_b44 {
        let (CompressedBlock::ScanLine(CompressedScanLineBlock { compressed_pixels_le: packed, .. })
        | CompressedBlock::Tile(CompressedTileBlock { compressed_pixels_le: packed, .. })) =
            &chunk.compressed_block
        else {
            return Ok(None);
        };
        let index = BlockIndex {
            layer: chunk.layer_index,
            pixel_position: position,
            pixel_size: size,
            level: tile.level_index,
        };
        let data = exr_b44::unpack(packed, header, y, size.width(), size.height());
        return Ok(data.map(|data| UncompressedBlock { index, data }));
    }
    // The decoder multiplies this number by that of the pixels: it is a whole one, as rows and columns go in pairs where samples do.
    let (bytes, pixels) = (bytes_of_rows(header, y, size.height()), size.area().max(1));
    let Some(copy) = meta.headers.get_mut(chunk.layer_index).filter(|_| bytes.is_multiple_of(pixels)) else {
        return Err(DecodeError::unsupported(
            FORMAT,
            "channels of these types with fewer samples than pixels",
        ));
    };
    copy.channels.bytes_per_pixel = bytes.checked_div(pixels).unwrap_or(0);
    UncompressedBlock::decompress_chunk(chunk, meta, false).map(Some).map_err(explain)
}

/// Hands the samples of a block on, row by row, in each channel by channel: with the number of the channel and the column and row of
/// the first. Channels with fewer samples have none in some rows. `None` if the block does not hold them, or `take` returns it.
pub(super) fn for_each_run(
    header: &Header,
    block: &UncompressedBlock,
    mut take: impl FnMut(usize, [usize; 2], &[u8]) -> Option<()>,
) -> Option<()> {
    let index = &block.index;
    let (x, columns) = (index.pixel_position.x(), index.pixel_size.width());
    if x.checked_add(columns)? > header.layer_size.width() {
        return None;
    }
    let mut rest = &block.data[..];
    for y in 0..index.pixel_size.height() {
        let y = index.pixel_position.y().checked_add(y)?;
        for (number, channel) in header.channels.list.iter().enumerate() {
            if y.checked_rem(channel.sampling.y())? != 0 {
                continue;
            }
            let samples = columns.checked_div(channel.sampling.x())?;
            let run = rest.split_off(..samples.checked_mul(channel.sample_type.bytes_per_sample())?)?;
            take(number, [x, y], run)?;
        }
    }
    Some(())
}

/// Writes samples, which are in this machine's byte order, as floats.
pub(super) fn floats<'t>(kind: SampleType, bytes: &[u8], targets: impl Iterator<Item = &'t mut f32>) {
    match kind {
        SampleType::F16 => {
            targets.zip(bytes.as_chunks().0).for_each(|(t, &v)| *t = half::f16::from_ne_bytes(v).to_f32());
        }
        SampleType::F32 => targets.zip(bytes.as_chunks().0).for_each(|(t, &v)| *t = f32::from_ne_bytes(v)),
        SampleType::U32 => {
            targets.zip(bytes.as_chunks().0).for_each(|(t, &v)| *t = u32::from_ne_bytes(v) as f32);
        }
    }
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
            // With chroma, luminance is no grey.
            let is_grey = find("RY").is_none() || find("BY").is_none();
            let of = |wanted: &str| find(wanted).or_else(|| find("Y").filter(|_| is_grey));
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

    /// Colours, row by row.
    fn read(&self, file: &File<'_>) -> Result<Vec<[f32; 3]>, DecodeError> {
        let (width, mut pixels) =
            (self.header.layer_size.width(), vec![[0.0; 3]; self.header.layer_size.area()]);
        for_each_block(
            file,
            |index| index == self.index,
            |_, block| {
                for_each_run(self.header, block, |channel, [x, y], bytes| {
                    let kind = self.header.channels.list.get(channel)?.sample_type;
                    let row = pixels.get_mut(y.checked_mul(width)?.checked_add(x)?..)?;
                    // One channel may stand for several: grey for all three.
                    for k in self.rgb.iter().enumerate().filter(|(_, c)| **c == channel).map(|(k, _)| k) {
                        floats(kind, bytes, row.iter_mut().filter_map(|pixel| pixel.get_mut(k)));
                    }
                    Some(())
                })
            },
        )?;
        Ok(pixels)
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
        use Compression::{B44, B44A, DWAA, DWAB, PIZ, PXR24, RLE, Uncompressed, ZIP1, ZIP16};
        let limits = Limits::default().with_texture_pixels(1 << 16).with_decoded_bytes(1 << 22);
        let mut state = 1_u64;
        let mut next = |below: usize| {
            // Xorshift: G. Marsaglia, 2003.
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            (state % below as u64) as usize
        };
        for compression in [Uncompressed, RLE, ZIP1, ZIP16, PIZ, PXR24, DWAA(None), DWAB(None), B44, B44A] {
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
