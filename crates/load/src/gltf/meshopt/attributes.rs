//! Mode 0: elements as differences from the ones before, byte by byte, in groups of 16 with as few bits as do.

use super::{CUT_OFF, Damage, LEFT_OVER, take, take_array};
use std::num::NonZeroUsize;

/// Elements of a group.
const GROUP: usize = 16;
/// Most elements of a block.
const BLOCK: usize = 256;
/// Most bytes of a block.
const BLOCK_BYTES: usize = 8192;

/// Bits of a difference by the two bits of a group's header, in version 0.
const BITS: [u8; 4] = [0, 2, 4, 8];
/// The same in control mode 0 of version 1.
const FEW_BITS: [u8; 4] = [0, 1, 2, 4];
/// The same in control mode 1.
const MANY_BITS: [u8; 4] = [1, 2, 4, 8];

/// Four bytes of every element.
struct Channel {
    /// Value and mode of the element before.
    value: u32,
    mode: u8,
}

/// Fills `out` with elements of `stride` bytes, a multiple of 4 up to 256.
///
/// # Errors
/// What is wrong with the stream.
pub(super) fn decode(stream: &[u8], stride: NonZeroUsize, out: &mut [u8]) -> Result<(), Damage> {
    let (version, mut rest) = match stream.split_first() {
        Some((0xa0, rest)) => (0, rest),
        Some((0xa1, rest)) => (1, rest),
        Some(_) => return Err("its compressed data has no header of attributes"),
        None => return Err(CUT_OFF),
    };
    let (modes, least) = if version == 0 { (0, 32) } else { (stride.get() / 4, 24) };
    let modes = take_last(&mut rest, modes)?;
    let baseline = take_last(&mut rest, stride.get())?;
    let padding = usize::saturating_sub(least, baseline.len().saturating_add(modes.len()));
    take_last(&mut rest, padding)?;

    let modes_or_zeros = modes.iter().copied().chain(std::iter::repeat(0));
    let channel = |(value, mode): (&[u8; 4], u8)| Channel { value: u32::from_le_bytes(*value), mode };
    let mut channels: Vec<Channel> = baseline.as_chunks().0.iter().zip(modes_or_zeros).map(channel).collect();
    let most = (BLOCK_BYTES / stride / GROUP).saturating_mul(GROUP).clamp(GROUP, BLOCK);
    let mut planes = [[0; BLOCK]; 4];
    for block in out.chunks_mut(most.saturating_mul(stride.get())) {
        let count = block.len() / stride;
        let mut controls = take(&mut rest, modes.len())?.iter();
        let mut out = block;
        for channel in &mut channels {
            match controls.next() {
                None => {
                    for plane in &mut planes {
                        groups(&mut rest, BITS, count, plane)?;
                    }
                }
                Some(control) => {
                    let controls = [control & 3, control >> 2 & 3, control >> 4 & 3, control >> 6];
                    for (control, plane) in controls.into_iter().zip(&mut planes) {
                        match control {
                            0 => groups(&mut rest, FEW_BITS, count, plane)?,
                            1 => groups(&mut rest, MANY_BITS, count, plane)?,
                            2 => plane.fill(0),
                            _ => copy(take(&mut rest, count)?, plane),
                        }
                    }
                }
            }
            let Channel { value, mode } = channel;
            match (*mode & 15, *mode >> 4) {
                (0, 0) => undo(&planes, out, stride, value, add_bytes),
                (1, 0) => undo(&planes, out, stride, value, add_halves),
                (2, turn) => undo(&planes, out, stride, value, |value, difference| {
                    value ^ difference.rotate_right(turn.into())
                }),
                _ => return Err("its compressed data has an unknown channel mode"),
            }
            // The next channel's elements begin four bytes later.
            out = out.get_mut(4..).unwrap_or_default();
        }
    }
    if rest.is_empty() { Ok(()) } else { Err(LEFT_OVER) }
}

/// Takes bytes off the end.
fn take_last<'a>(rest: &mut &'a [u8], count: usize) -> Result<&'a [u8], Damage> {
    let place = rest.len().checked_sub(count);
    let (others, taken) = place.and_then(|place| rest.split_at_checked(place)).ok_or(CUT_OFF)?;
    *rest = others;
    Ok(taken)
}

fn copy(bytes: &[u8], out: &mut [u8]) {
    out.iter_mut().zip(bytes).for_each(|(out, byte)| *out = *byte);
}

/// The differences of one byte of a block's elements.
fn groups(
    rest: &mut &[u8],
    [a, b, c, d]: [u8; 4],
    count: usize,
    plane: &mut [u8; BLOCK],
) -> Result<(), Damage> {
    let groups = count.div_ceil(GROUP);
    let headers = take(rest, groups.div_ceil(4))?;
    let (groups, _) = plane.as_chunks_mut::<GROUP>().0.split_at_mut_checked(groups).ok_or(CUT_OFF)?;
    for (groups, header) in groups.chunks_mut(4).zip(headers) {
        let codes = [header & 3, header >> 2 & 3, header >> 4 & 3, header >> 6];
        for (group, code) in groups.iter_mut().zip(codes) {
            let bits = match code {
                0 => a,
                1 => b,
                2 => c,
                _ => d,
            };
            match bits {
                0 => group.fill(0),
                1 => {
                    let marks = u16::from_le_bytes(*take_array(rest)?);
                    group.fill(0);
                    replace(rest, marks.into(), 0, group)?;
                }
                2 => {
                    let packed = take_array::<4>(rest)?;
                    for (four, packed) in group.as_chunks_mut::<4>().0.iter_mut().zip(packed) {
                        *four = [packed >> 6, packed >> 4 & 3, packed >> 2 & 3, packed & 3];
                    }
                    let packed = u32::from_be_bytes(*packed);
                    let marks = packed & packed >> 1 & 0x5555_5555;
                    replace(rest, marks.reverse_bits().into(), 1, group)?;
                }
                4 => {
                    let packed = take_array::<8>(rest)?;
                    for (two, packed) in group.as_chunks_mut::<2>().0.iter_mut().zip(packed) {
                        *two = [packed >> 4, packed & 15];
                    }
                    let packed = u64::from_be_bytes(*packed);
                    let pairs = packed & packed >> 1;
                    let marks = pairs & pairs >> 2 & 0x1111_1111_1111_1111;
                    replace(rest, marks.reverse_bits(), 2, group)?;
                }
                _ => *group = *take_array(rest)?,
            }
        }
    }
    Ok(())
}

/// Replaces those differences of a group that did not fit into its bits: the bits of `marks`, whose places are those
/// of the differences times two to the power of `shift`.
#[inline]
fn replace(rest: &mut &[u8], mut marks: u64, shift: u32, group: &mut [u8; GROUP]) -> Result<(), Damage> {
    for &large in take(rest, marks.count_ones() as usize)? {
        if let Some(byte) = group.get_mut((marks.trailing_zeros() >> shift) as usize) {
            *byte = large;
        }
        marks &= marks.wrapping_sub(1);
    }
    Ok(())
}

/// Adds up the differences of four bytes of each element, from the front of `out` on.
#[inline(always)]
fn undo(
    planes: &[[u8; BLOCK]; 4],
    out: &mut [u8],
    stride: NonZeroUsize,
    value: &mut u32,
    add: impl Fn(u32, u32) -> u32,
) {
    let [a, b, c, d] = planes;
    let differences = a.iter().zip(b).zip(c.iter().zip(d));
    let mut sum = *value;
    for (out, ((&a, &b), (&c, &d))) in out.chunks_mut(stride.get()).zip(differences) {
        sum = add(sum, u32::from_le_bytes([a, b, c, d]));
        if let Some(out) = out.first_chunk_mut() {
            *out = sum.to_le_bytes();
        }
    }
    *value = sum;
}

/// Adds zigzag differences to each of four bytes; sums do not carry.
fn add_bytes(value: u32, difference: u32) -> u32 {
    let difference = (difference >> 1 & 0x7f7f_7f7f) ^ (difference & 0x0101_0101).wrapping_mul(0xff);
    (value & 0x7f7f_7f7f).wrapping_add(difference & 0x7f7f_7f7f) ^ ((value ^ difference) & 0x8080_8080)
}

/// The same for two halves.
fn add_halves(value: u32, difference: u32) -> u32 {
    let difference = (difference >> 1 & 0x7fff_7fff) ^ (difference & 0x0001_0001).wrapping_mul(0xffff);
    (value & 0x7fff_7fff).wrapping_add(difference & 0x7fff_7fff) ^ ((value ^ difference) & 0x8000_8000)
}

#[cfg(test)]
mod tests {
    use super::super::encoder::{Random, attributes};
    use super::*;

    fn decode(stream: &[u8], stride: usize, out: &mut [u8]) -> Result<(), Damage> {
        super::decode(stream, NonZeroUsize::new(stride).unwrap(), out)
    }

    /// The bytes of the specification's example: 16 differences in 4 bits, two of them explicit.
    #[test]
    fn the_example_of_the_specification() {
        let example = [0x17, 0x5f, 0xf0, 0xbc, 0x77, 0xa9, 0x21, 0x00, 0x34, 0xb5];
        let differences = [-1, -4, -3, 26, -91, 0, -6, 6, -4, -4, 5, -5, 1, -1, 0, 0];
        // Version 0, one group: the header of the first byte says 4 bits, those of the others that nothing changes.
        let mut stream = vec![0xa0, 2];
        stream.extend(example);
        stream.extend([0, 0, 0]);
        stream.extend([0; 28]);
        stream.extend([100, 7, 8, 9]);
        let mut out = [0; 64];
        decode(&stream, 4, &mut out).unwrap();
        let mut sum = 100i32;
        for (element, difference) in out.as_chunks::<4>().0.iter().zip(differences) {
            sum += difference;
            assert_eq!(*element, [sum as u8, 7, 8, 9]);
        }
        // With 13 elements the last three differences are ignored.
        let mut few = [0; 52];
        decode(&stream, 4, &mut few).unwrap();
        assert_eq!(few, out[..52]);
        // 17 elements are two groups, and if the header says so, the second is not there.
        stream[1] = 0x0a;
        assert_eq!(decode(&stream, 4, &mut [0; 68]), Err(CUT_OFF));
        stream.insert(12, 0);
        assert_eq!(decode(&stream, 4, &mut out), Err(LEFT_OVER));
    }

    /// Version 1 by hand: control modes 3, 2, 0 and 1, and one bit for each difference.
    #[test]
    fn control_modes() {
        let stream = |mode: u8| {
            let mut stream = vec![0xa1, 0b01_00_10_11];
            // Byte 0, literal: two differences, zigzag +1 and -1. Byte 1: nothing.
            stream.extend([2, 1]);
            // Byte 2, control mode 0, header 1: one bit each; the second is explicit, zigzag +2.
            stream.extend([1, 0b10, 0, 4]);
            // Byte 3, control mode 1, header 3: eight bits each.
            stream.extend([3, 6, 8]);
            stream.extend([0; 14]);
            stream.extend([0; 24 - 5]);
            stream.extend([10, 20, 30, 40, mode]);
            stream
        };
        let read = |mode| {
            let mut out = [0; 8];
            decode(&stream(mode), 4, &mut out).map(|()| out)
        };
        assert_eq!(read(0), Ok([11, 20, 30, 43, 10, 20, 32, 47]));
        // Halves: differences 0x0002 and 0x0600, then 0x0001 and 0x0804, zigzag.
        let (first, second) = (40u16 * 256 + 30 + 0x300, 20u16 * 256 + 10 + 1);
        let next = (first + 0x402, second - 1);
        let bytes = |v: (u16, u16)| [v.1.to_le_bytes(), v.0.to_le_bytes()].concat();
        assert_eq!(read(1).unwrap().to_vec(), [bytes((first, second)), bytes(next)].concat());
        // Exclusive or, turned by 8 bits.
        let mut value = u32::from_le_bytes([10, 20, 30, 40]);
        let mut expected = Vec::new();
        for difference in [0x0600_0002u32, 0x0804_0001] {
            value ^= difference.rotate_right(8);
            expected.extend(value.to_le_bytes());
        }
        assert_eq!(read(0x82).unwrap().to_vec(), expected);
        for unknown in [3, 4, 15, 0x10, 0x11, 0xf3] {
            read(unknown).unwrap_err();
        }
    }

    #[test]
    fn differences_add_up_as_single_numbers_do() {
        let mut random = Random::new(3);
        for _ in 0..10_000 {
            let (value, difference) = (random.next(), random.next());
            let bytes: Vec<u8> = value
                .to_le_bytes()
                .iter()
                .zip(difference.to_le_bytes())
                .map(|(&v, d)| v.wrapping_add(if d & 1 == 1 { !(d >> 1) } else { d >> 1 }))
                .collect();
            assert_eq!(add_bytes(value, difference).to_le_bytes().to_vec(), bytes);
            let halves = |v: u32| [v as u16, (v >> 16) as u16];
            let sums: Vec<u16> = halves(value)
                .iter()
                .zip(halves(difference))
                .map(|(&v, d)| v.wrapping_add(if d & 1 == 1 { !(d >> 1) } else { d >> 1 }))
                .collect();
            assert_eq!(halves(add_halves(value, difference)).to_vec(), sums);
        }
    }

    #[test]
    fn what_was_encoded_comes_back() {
        let mut random = Random::new(5);
        for round in 0..300 {
            let (count, stride) = match round {
                0 => (0, 4),
                1 => (1, 256),
                2 => (1000, 256),
                3 => (513, 4),
                _ => (random.below(700), 4 * (1 + random.below(20))),
            };
            let elements = random.elements(count, stride);
            for version in [0, 1] {
                let stream = attributes(&elements, stride, version, &mut random);
                let mut out = vec![1; elements.len()];
                decode(&stream, stride, &mut out).unwrap();
                assert!(out == elements, "{count} elements of {stride} bytes, version {version}");
            }
        }
    }
}
