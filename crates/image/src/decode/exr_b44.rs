//! B44 and B44A compression of OpenEXR (`ImfB44Compressor.cpp` describes them): 16 samples of 16 bits in 14 bytes, or in 3 where they
//! are equal. A decoder of its own: that of the crate `exr` (1.74) overflows where a file is damaged.

use super::exr_sampling::bytes_of_rows;
use exr::meta::attribute::SampleType;
use exr::meta::header::Header;
use overcoat_core::math::double;

/// Samples along a side of a block.
const SIDE: usize = 4;

/// Unpacks rows `y` to `y + height` of a picture, to rows that follow each other, in each the channels one by one, in this machine's byte
/// order. `None` if there are too few bytes.
pub(super) fn unpack(
    packed: &[u8],
    header: &Header,
    y: usize,
    columns: usize,
    height: usize,
) -> Option<Vec<u8>> {
    let size = bytes_of_rows(header, y, height);
    // Samples that did not become smaller are stored as they are.
    let is_stored = packed.len() == size;
    let mut rest = packed;
    let mut channels = Vec::new();
    for channel in &header.channels.list {
        let [across, down] = [channel.sampling.x().max(1), channel.sampling.y().max(1)];
        let width = columns.checked_div(across)?;
        let rows = y.checked_add(height)?.div_ceil(down).checked_sub(y.div_ceil(down))?;
        let bytes = channel.sample_type.bytes_per_sample();
        let samples = match channel.sample_type {
            _ if is_stored => Vec::new(),
            SampleType::F16 => {
                let mut samples = halves(&mut rest, width, rows)?;
                if channel.quantize_linearly {
                    samples.iter_mut().for_each(|sample| *sample = logarithm(*sample));
                }
                samples.iter().flat_map(|sample| sample.to_ne_bytes()).collect()
            }
            SampleType::F32 | SampleType::U32 => {
                let stored = rest.split_off(..width.checked_mul(rows)?.checked_mul(bytes)?)?;
                words(stored).collect()
            }
        };
        channels.push((samples, down, width.checked_mul(bytes)?, bytes));
    }
    let mut out = Vec::with_capacity(size);
    let mut lines: Vec<std::slice::Chunks<'_, u8>> =
        channels.iter().map(|(samples, _, line, _)| samples.chunks((*line).max(1))).collect();
    for row in y..y.checked_add(height)? {
        for ((_, down, line, bytes), lines) in channels.iter().zip(&mut lines) {
            if !row.is_multiple_of(*down) {
                continue;
            }
            if !is_stored {
                out.extend_from_slice(lines.next()?);
            } else if *bytes == 2 {
                let halves = rest.split_off(..*line)?.as_chunks().0.iter();
                out.extend(halves.flat_map(|half| u16::from_le_bytes(*half).to_ne_bytes()));
            } else {
                out.extend(words(rest.split_off(..*line)?));
            }
        }
    }
    Some(out)
}

/// Words in this machine's byte order.
fn words(bytes: &[u8]) -> impl Iterator<Item = u8> {
    bytes.as_chunks().0.iter().flat_map(|word| u32::from_le_bytes(*word).to_ne_bytes())
}

/// Unpacks the samples of a channel, block by block.
fn halves(rest: &mut &[u8], width: usize, rows: usize) -> Option<Vec<u16>> {
    let mut samples = vec![0; width.checked_mul(rows)?];
    for top in (0..rows).step_by(SIDE) {
        for left in (0..width).step_by(SIDE) {
            let block = block(rest)?;
            // Blocks at the right and lower border hold more than there is.
            for (k, value) in block.into_iter().enumerate() {
                let (x, y) = (left.checked_add(k % SIDE)?, top.checked_add(k / SIDE)?);
                if x < width && y < rows {
                    *samples.get_mut(y.checked_mul(width)?.checked_add(x)?)? = value;
                }
            }
        }
    }
    Some(samples)
}

/// Least third byte of blocks of three: a shift of 13 and more does not occur in those of fourteen.
const FLAT: u8 = 13 << 2;

/// Takes a block: bits of halves in an order in which greater numbers are greater, as differences from their neighbours.
fn block(rest: &mut &[u8]) -> Option<[u16; 16]> {
    let [high, low, third] = *rest.first_chunk::<3>()?;
    let first = u16::from_be_bytes([high, low]);
    if third >= FLAT {
        *rest = rest.get(3..)?;
        return Some([half_of(first); 16]);
    }
    let bytes = *rest.first_chunk::<14>()?;
    *rest = rest.get(14..)?;
    let shift = third >> 2;
    // After the shift, fifteen differences of six bits each.
    let bits = bytes.iter().skip(2).fold(0_u128, |bits, byte| bits << 8 | u128::from(*byte));
    let difference = |number: u32| {
        let six = (bits >> (84_u32.saturating_sub(number.saturating_mul(6)))) as u16 & 0x3f;
        six.wrapping_shl(shift.into()).wrapping_sub(0x20_u16.wrapping_shl(shift.into()))
    };
    // Down the first column, then each of the other columns from the one before.
    let mut columns = [[first; SIDE]; SIDE];
    let [column, others @ ..] = &mut columns;
    let mut value = first;
    for (number, target) in (0..).zip(column.iter_mut().skip(1)) {
        value = value.wrapping_add(difference(number));
        *target = value;
    }
    let mut before = *column;
    for (first, target) in (3..).step_by(SIDE).zip(others) {
        for (number, (target, before)) in (first..).zip(target.iter_mut().zip(&before)) {
            *target = before.wrapping_add(difference(number));
        }
        before = *target;
    }
    let at = |k: usize| columns.get(k % SIDE).and_then(|column| column.get(k / SIDE)).copied().unwrap_or(0);
    Some(std::array::from_fn(|k| half_of(at(k))))
}

/// Bits of a half: those of negative numbers are inverted, those of others have the sign set.
fn half_of(ordered: u16) -> u16 {
    if ordered & 0x8000 != 0 { ordered & 0x7fff } else { !ordered }
}

/// Half of 8 ln x, by which channels are told that are "perceptually linear" (`b44ExpLogTable.cpp`): they are packed as e^(x / 8).
/// 0 for what is not finite or negative, negative infinity for 0.
fn logarithm(bits: u16) -> u16 {
    let x = f64::from(half::f16::from_bits(bits).to_f32());
    if !x.is_finite() || x < 0.0 {
        return 0;
    }
    if x == 0.0 {
        return half::f16::NEG_INFINITY.to_bits();
    }
    // Rounded twice, as the table is: to a float, and that to a half.
    half::f16::from_f32((8.0 * double::ln(x)) as f32).to_bits()
}
