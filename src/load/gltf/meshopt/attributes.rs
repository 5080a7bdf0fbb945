//! Mode 0: elements as differences from the ones before, byte by byte, in groups of 16 with as few bits as do.

use super::{CUT_OFF, Damage, LEFT_OVER, take};

/// Elements of a group.
const GROUP: usize = 16;
/// Most elements of a block.
const BLOCK: usize = 256;
/// Most bytes of an element.
const STRIDE: usize = 256;

/// Bits of a difference by the two bits of a group's header: version 0, and control modes 0 and 1 of version 1.
const BITS: [[u8; 4]; 3] = [[0, 2, 4, 8], [0, 1, 2, 4], [1, 2, 4, 8]];

/// Fills `out` with elements of `stride` bytes, a multiple of 4 up to 256.
///
/// # Errors
/// What is wrong with the stream.
pub(super) fn decode(stream: &[u8], stride: usize, out: &mut [u8]) -> Result<(), Damage> {
    let (version, rest) = match stream.split_first() {
        Some((0xa0, rest)) => (0, rest),
        Some((0xa1, rest)) => (1, rest),
        Some(_) => return Err("its compressed data has no header of attributes"),
        None => return Err(CUT_OFF),
    };
    let modes = if version == 0 { 0 } else { stride / 4 };
    let padded = (stride + modes).max(if version == 0 { 32 } else { 24 });
    let (mut rest, tail) = rest.split_at_checked(rest.len().wrapping_sub(padded)).ok_or(CUT_OFF)?;
    let (baseline, modes) = tail[padded - stride - modes..].split_at(stride);

    let mut last = [0; STRIDE];
    last[..stride].copy_from_slice(baseline);
    let most = (8192 / stride / GROUP * GROUP).min(BLOCK);
    let mut planes = [[0; BLOCK]; 4];
    for block in out.chunks_mut(most * stride) {
        let count = block.len() / stride;
        let control = take(&mut rest, modes.len())?;
        for channel in 0..stride / 4 {
            for (k, plane) in planes.iter_mut().enumerate() {
                match control.get(channel).map(|control| control >> (2 * k) & 3) {
                    None => groups(&mut rest, &BITS[0], count, plane)?,
                    Some(2) => plane.fill(0),
                    Some(3) => plane[..count].copy_from_slice(take(&mut rest, count)?),
                    Some(control) => groups(&mut rest, &BITS[1 + usize::from(control)], count, plane)?,
                }
            }
            let mode = modes.get(channel).copied().unwrap_or(0);
            let place = channel * 4;
            let before = &mut last[place..place + 4];
            let value = u32::from_le_bytes([before[0], before[1], before[2], before[3]]);
            let sum = match (mode & 15, mode >> 4) {
                (0, 0) => undo(&planes, &mut block[place..], stride, value, add_bytes),
                (1, 0) => undo(&planes, &mut block[place..], stride, value, add_halves),
                (2, turn) => undo(&planes, &mut block[place..], stride, value, |value, difference| {
                    value ^ difference.rotate_right(turn.into())
                }),
                _ => return Err("its compressed data has an unknown channel mode"),
            };
            before.copy_from_slice(&sum.to_le_bytes());
        }
    }
    if rest.is_empty() { Ok(()) } else { Err(LEFT_OVER) }
}

/// The differences of one byte of a block's elements.
fn groups(rest: &mut &[u8], bits: &[u8; 4], count: usize, plane: &mut [u8; BLOCK]) -> Result<(), Damage> {
    let groups = count.div_ceil(GROUP);
    let headers = take(rest, groups.div_ceil(4))?;
    for (k, group) in plane.as_chunks_mut::<GROUP>().0.iter_mut().take(groups).enumerate() {
        match bits[usize::from(headers[k / 4] >> (k % 4 * 2) & 3)] {
            0 => group.fill(0),
            1 => {
                let packed = take(rest, 2)?;
                let marks = u16::from_le_bytes([packed[0], packed[1]]);
                let mut large = Large::take(rest, marks.count_ones())?;
                for (k, byte) in group.iter_mut().enumerate() {
                    *byte = if marks >> k & 1 == 1 { large.next() } else { 0 };
                }
            }
            2 => {
                let packed = take(rest, 4)?;
                let packed = u32::from_be_bytes([packed[0], packed[1], packed[2], packed[3]]);
                let marks = packed & packed >> 1 & 0x5555_5555;
                for (k, byte) in group.iter_mut().enumerate() {
                    *byte = (packed >> (30 - 2 * k) & 3) as u8;
                }
                if marks != 0 {
                    Large::take(rest, marks.count_ones())?.replace(group, 3);
                }
            }
            4 => {
                let packed = take(rest, 8)?;
                let mut marks = 0;
                for (pair, &packed) in group.as_chunks_mut::<2>().0.iter_mut().zip(packed) {
                    *pair = [packed >> 4, packed & 15];
                    marks += u32::from(pair[0] == 15) + u32::from(pair[1] == 15);
                }
                if marks != 0 {
                    Large::take(rest, marks)?.replace(group, 15);
                }
            }
            _ => group.copy_from_slice(take(rest, GROUP)?),
        }
    }
    Ok(())
}

/// The differences of a group that do not fit into its bits.
struct Large {
    bytes: [u8; 32],
    at: usize,
}

impl Large {
    fn take(rest: &mut &[u8], count: u32) -> Result<Self, Damage> {
        let mut bytes = [0; 32];
        let given = take(rest, count as usize)?;
        bytes[..given.len()].copy_from_slice(given);
        Ok(Self { bytes, at: 0 })
    }

    fn next(&mut self) -> u8 {
        let byte = self.bytes[self.at % 32];
        self.at += 1;
        byte
    }

    fn replace(&mut self, group: &mut [u8; GROUP], mark: u8) {
        for byte in group {
            // Without a branch: which bytes are marked cannot be foreseen.
            let (marked, large) = (*byte == mark, self.bytes[self.at % 32]);
            *byte = if marked { large } else { *byte };
            self.at += usize::from(marked);
        }
    }
}

/// Adds up the differences of four bytes of each element; gives the last sum.
#[inline(always)]
fn undo(
    planes: &[[u8; BLOCK]; 4],
    out: &mut [u8],
    stride: usize,
    mut value: u32,
    add: impl Fn(u32, u32) -> u32,
) -> u32 {
    let [a, b, c, d] = planes;
    let differences = a.iter().zip(b).zip(c.iter().zip(d));
    for (out, ((&a, &b), (&c, &d))) in out.chunks_mut(stride).zip(differences) {
        value = add(value, u32::from_le_bytes([a, b, c, d]));
        if let Some(out) = out.first_chunk_mut() {
            *out = value.to_le_bytes();
        }
    }
    value
}

/// Adds zigzag differences to each of four bytes; sums do not carry.
fn add_bytes(value: u32, difference: u32) -> u32 {
    let difference = (difference >> 1 & 0x7f7f_7f7f) ^ (difference & 0x0101_0101).wrapping_mul(0xff);
    ((value & 0x7f7f_7f7f) + (difference & 0x7f7f_7f7f)) ^ ((value ^ difference) & 0x8080_8080)
}

/// The same for two halves.
fn add_halves(value: u32, difference: u32) -> u32 {
    let difference = (difference >> 1 & 0x7fff_7fff) ^ (difference & 0x0001_0001).wrapping_mul(0xffff);
    ((value & 0x7fff_7fff) + (difference & 0x7fff_7fff)) ^ ((value ^ difference) & 0x8000_8000)
}

#[cfg(test)]
mod tests {
    use super::super::encoder::{Random, attributes};
    use super::*;

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
        // Of 13 elements the last three differences are ignored.
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
