//! LAZ, the points of LAS inside the compression of LASzip (M. Isenburg, *LASzip: lossless compression of LiDAR data*, 2013; LASzip
//! 3.4): point formats 0 to 3 (items of version 2) and 6 to 10 (versions 3 and 4, in layers).
//!
//! Chunks follow each other, so that their table, which a file may do without, is not needed but for chunks of different sizes
//! in formats 0 to 3: these are refused. Attributes that are not drawn are zero in what comes out.

mod arithmetic;
mod flat;
mod layered;
#[cfg(test)]
mod tests;

use super::las::{u16_at, u32_at};
use crate::{Context, LoadError};
use arithmetic::{Decoder, Models};
use flat::{Base, Colors, Times};
use overcoat_core::limits::Limits;

const FORMAT: &str = "LAZ";
/// Bytes before the record that describes the compression, in its list.
const RECORD_HEAD: usize = 54;
/// Name and number of that record.
const USER: &[u8] = b"laszip encoded";
const NUMBER: u16 = 22204;
/// Compressors: all points in one, in chunks, in chunks of layers.
const PLAIN: u16 = 1;
const CHUNKED: u16 = 2;
const LAYERED: u16 = 3;
/// Points of a chunk that say that their number is in the table.
const VARIABLE: u32 = u32::MAX;

/// Parts of a point, as the file lists them.
#[derive(Debug)]
struct Items {
    /// Bytes of a point.
    size: usize,
    /// Places of the time and the colour, and bytes at the end that nobody knows.
    time: Option<usize>,
    color: Option<usize>,
    extra: usize,
    /// Streams of a chunk of layers.
    layers: usize,
    version: u16,
}

/// Records of points, one after the other.
struct Records {
    bytes: Vec<u8>,
    count: u64,
}

impl Records {
    fn push(&mut self, record: &[u8]) {
        self.bytes.extend_from_slice(record);
        self.count = self.count.saturating_add(1);
    }
}

/// The part of the file that describes the compression.
fn description(bytes: &[u8], header: usize) -> Option<&[u8]> {
    let count = u32_at(bytes, 100)?;
    let mut rest = bytes.get(header..)?;
    for _ in 0..count {
        let (head, after) = rest.split_at_checked(RECORD_HEAD)?;
        let size = usize::from(u16_at(head, 20)?);
        let (content, after) = after.split_at_checked(size)?;
        if head.get(2..).is_some_and(|name| name.starts_with(USER)) && u16_at(head, 18) == Some(NUMBER) {
            return Some(content);
        }
        rest = after;
    }
    None
}

impl Items {
    /// Reads the list behind the description.
    fn read(description: &[u8], is_layered: bool) -> Result<Self, LoadError> {
        let unsupported = |message: String| LoadError::unsupported(FORMAT, message);
        let mut items = Self { size: 0, time: None, color: None, extra: 0, layers: 0, version: 0 };
        let count = u16_at(description, 32).unwrap_or(0);
        let list = description.get(34..).unwrap_or_default().as_chunks::<6>().0;
        for &[a, b, c, d, e, f] in list.iter().take(count.into()) {
            let [kind, size, version] = [[a, b], [c, d], [e, f]].map(u16::from_le_bytes);
            let place = items.size;
            let size = usize::from(size);
            // Numbers and sizes of kinds of items (LASzip, `laszip_api`).
            let (expected, layers) = match (kind, is_layered) {
                (6, false) => (20, 0),
                (7, false) => (8, 0),
                (8, false) => (6, 0),
                (0, false) | (14, true) => (size, size),
                (10, true) => (30, 9),
                (11, true) => (6, 1),
                (12, true) => (8, 2),
                (13, true) => (29, 1),
                _ => {
                    return Err(unsupported(format!(
                        "points have an item of kind {kind}, which is not read"
                    )));
                }
            };
            let is_first = matches!(kind, 6 | 10);
            if size != expected || is_first != (place == 0) || kind > 0 && kind < 14 && items.extra > 0 {
                let message = format!("item {kind} of points has {size} bytes, or is not where it should be");
                return Err(LoadError::malformed(FORMAT, message));
            }
            let known = if is_layered { 3..=4 } else { 2..=2 };
            if !known.contains(&version) {
                return Err(unsupported(format!("version {version} of item {kind} is not read")));
            }
            match kind {
                7 => items.time = Some(place),
                8 | 11 | 12 => items.color = Some(place),
                0 | 14 => items.extra = items.extra.saturating_add(size),
                _ => {}
            }
            items.size = items.size.saturating_add(size);
            items.layers = items.layers.saturating_add(layers);
            items.version = version;
        }
        Ok(items)
    }
}

/// The points of a file of so many, each in `length` bytes: all that are there.
pub(super) fn unpack(
    bytes: &[u8],
    body: &[u8],
    (length, points): (usize, u64),
    context: &Context<'_>,
) -> Result<Vec<u8>, LoadError> {
    // All of them, though maybe not all are drawn.
    let asked = points.saturating_mul(length as u64);
    Limits::check(|| format!("{FORMAT}: the points"), asked, context.limits.decoded_bytes, "decoded_bytes")?;
    let malformed = |message: &str| LoadError::malformed(FORMAT, message);
    let header = usize::from(u16_at(bytes, 94).unwrap_or(0));
    let description = description(bytes, header)
        .ok_or_else(|| malformed("the description of the compression is missing"))?;
    let compressor = u16_at(description, 0).unwrap_or(0);
    if !(PLAIN..=LAYERED).contains(&compressor) || u16_at(description, 2) != Some(0) {
        return Err(LoadError::unsupported(FORMAT, format!("compressor {compressor} is not read")));
    }
    let items = Items::read(description, compressor == LAYERED)?;
    if items.size != length {
        let size = items.size;
        return Err(malformed(&format!("items of {size} bytes in points of {length}")));
    }
    let of_chunk = match (compressor, u32_at(description, 12).unwrap_or(0)) {
        (PLAIN | LAYERED, _) => u64::MAX,
        (_, VARIABLE) => {
            return Err(LoadError::unsupported(FORMAT, "chunks of different sizes are not read"));
        }
        (_, 0) => return Err(malformed("chunks have no points")),
        (_, size) => size.into(),
    };
    // The place of the table of chunks comes first.
    let mut rest = if compressor >= CHUNKED { body.get(8..).unwrap_or_default() } else { body };
    let mut records = Records { bytes: Vec::new(), count: 0 };
    while records.count < points {
        let left = points.saturating_sub(records.count);
        let next = if compressor == LAYERED {
            layered::chunk(rest, &items, left, &mut records)
        } else {
            flat_chunk(rest, &items, left.min(of_chunk), &mut records)
        };
        let Some(next) = next else { break };
        rest = next;
    }
    Ok(records.bytes)
}

/// Decodes one chunk of so many points, and returns what follows it; `None` where the file ends or is damaged.
fn flat_chunk<'a>(bytes: &'a [u8], items: &Items, count: u64, records: &mut Records) -> Option<&'a [u8]> {
    let (first, rest) = bytes.split_at_checked(items.size)?;
    let mut record = first.to_vec();
    let mut base = Base::new(first.first_chunk()?);
    let time = items.time.and_then(|place| first.get(place..)?.first_chunk());
    let mut times = time.map(Times::new);
    let mut colors = Colors::new();
    let extra = items.size.saturating_sub(items.extra);
    let mut others = Models::new(items.extra, 256);
    records.push(first);
    let mut decoder = Decoder::new(rest);
    for _ in 1..count {
        record.first_chunk_mut().into_iter().zip(base.next(&mut decoder)).for_each(|(to, from)| *to = *from);
        if let (Some(times), Some(place)) = (&mut times, items.time) {
            let time = times.next(&mut decoder)?;
            let slot = record.get_mut(place..).and_then(|rest| rest.first_chunk_mut());
            slot.into_iter().for_each(|slot| *slot = time);
        }
        if let Some(place) = items.color {
            let slots = record.get_mut(place..).unwrap_or_default().as_chunks_mut::<2>().0;
            let mut last = [0; 3];
            last.iter_mut().zip(slots.iter()).for_each(|(v, slot)| *v = u16::from_le_bytes(*slot));
            let color = colors.next(&mut decoder, last);
            slots.iter_mut().zip(color).for_each(|(slot, v)| *slot = v.to_le_bytes());
        }
        for (place, byte) in record.get_mut(extra..).unwrap_or_default().iter_mut().enumerate() {
            *byte = byte.wrapping_add(decoder.symbol_byte(&mut others, place));
        }
        if decoder.is_cut() {
            return None;
        }
        records.push(&record);
    }
    Some(decoder.rest())
}
