//! Compression of Crate files: blocks of LZ4 in chunks, and integers as differences of variable width.
//!
//! Sources: *LZ4 Block Format Description*; OpenUSD `pxr/base/tf/fastCompression.cpp` and `pxr/usd/sdf/integerCoding.cpp`.

/// Decompresses one or more chunks into at most `most` bytes. `None` for damaged ones.
pub(super) fn decompress(bytes: &[u8], most: usize) -> Option<Vec<u8>> {
    let (&chunks, mut rest) = bytes.split_first()?;
    let mut out = Vec::new();
    if chunks == 0 {
        block(rest, &mut out, most)?;
        return Some(out);
    }
    for _ in 0..chunks {
        let (size, after) = rest.split_first_chunk()?;
        let (chunk, after) = after.split_at_checked(usize::try_from(i32::from_le_bytes(*size)).ok()?)?;
        let before = std::mem::take(&mut out);
        let mut own = Vec::new();
        block(chunk, &mut own, most.checked_sub(before.len())?)?;
        out = before;
        out.extend(own);
        rest = after;
    }
    Some(out)
}

/// One block.
fn block(mut rest: &[u8], out: &mut Vec<u8>, most: usize) -> Option<()> {
    while let Some((&token, after)) = rest.split_first() {
        rest = after;
        let literals = length(token >> 4, &mut rest)?;
        let (copied, after) = rest.split_at_checked(literals)?;
        if out.len().checked_add(literals)? > most {
            return None;
        }
        out.extend_from_slice(copied);
        rest = after;
        // The last sequence has literals only.
        if rest.is_empty() {
            return Some(());
        }
        let (offset, after) = rest.split_first_chunk()?;
        rest = after;
        let offset = usize::from(u16::from_le_bytes(*offset));
        let count = length(token & 15, &mut rest)?.checked_add(4)?;
        let start = out.len().checked_sub(offset).filter(|_| offset > 0)?;
        let end = out.len().checked_add(count).filter(|&end| end <= most)?;
        // Matches may reach into what they write.
        while out.len() < end {
            let left = end.saturating_sub(out.len()).min(offset);
            let from = out.len().saturating_sub(offset).max(start);
            out.extend_from_within(from..from.checked_add(left)?);
        }
    }
    Some(())
}

fn length(nibble: u8, rest: &mut &[u8]) -> Option<usize> {
    let mut length = usize::from(nibble);
    if nibble == 15 {
        loop {
            let (&more, after) = rest.split_first()?;
            *rest = after;
            length = length.checked_add(more.into())?;
            if more != 255 {
                break;
            }
        }
    }
    Some(length)
}

/// Decodes `count` integers of 32 bits.
pub(super) fn integers(bytes: &[u8], count: usize) -> Option<Vec<i32>> {
    // Sums of 32 bits wrap as the lower half of those of 64 bits.
    Some(decoded::<4>(bytes, count)?.into_iter().map(|v| v as i32).collect())
}

/// Decodes `count` integers of 64 bits.
pub(super) fn long_integers(bytes: &[u8], count: usize) -> Option<Vec<i64>> {
    decoded::<8>(bytes, count)
}

/// Decodes `count` integers of `SIZE` bytes, 4 or 8: the most common difference, a code of two bits for each integer, and the
/// differences that are another one, in a quarter, half or all of the bytes.
fn decoded<const SIZE: usize>(bytes: &[u8], count: usize) -> Option<Vec<i64>> {
    let codes = count.checked_mul(2)?.checked_add(7)? / 8;
    let most = count.checked_mul(SIZE)?.checked_add(codes)?.checked_add(SIZE)?;
    let coded = decompress(bytes, most)?;
    if count == 0 {
        return Some(Vec::new());
    }
    let mut rest = coded.as_slice();
    let common = signed(&mut rest, SIZE)?;
    let (codes, mut values) = rest.split_at_checked(codes)?;
    let codes = codes.iter().flat_map(|&byte| [byte & 3, byte >> 2 & 3, byte >> 4 & 3, byte >> 6]);
    let mut out = Vec::with_capacity(count);
    let mut last = 0_i64;
    for code in codes.take(count) {
        let change = match code {
            0 => common,
            1 => signed(&mut values, SIZE / 4)?,
            2 => signed(&mut values, SIZE / 2)?,
            _ => signed(&mut values, SIZE)?,
        };
        last = last.wrapping_add(change);
        out.push(last);
    }
    Some(out)
}

/// A signed integer of 1, 2, 4 or 8 bytes.
fn signed(rest: &mut &[u8], size: usize) -> Option<i64> {
    Some(match size {
        1 => i8::from_le_bytes(take(rest)?).into(),
        2 => i16::from_le_bytes(take(rest)?).into(),
        4 => i32::from_le_bytes(take(rest)?).into(),
        _ => i64::from_le_bytes(take(rest)?),
    })
}

fn take<const N: usize>(rest: &mut &[u8]) -> Option<[u8; N]> {
    let (taken, after) = rest.split_first_chunk()?;
    *rest = after;
    Some(*taken)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn matches_reach_into_what_they_write() {
        // Two literals, a match of seven bytes two back, three literals.
        let bytes = [0, 0x23, b'a', b'b', 2, 0, 0x30, b'x', b'y', b'z'];
        assert_eq!(decompress(&bytes, 100).unwrap(), b"ababababaxyz");
        assert_eq!(decompress(&bytes, 11), None);
        for length in 0..bytes.len() {
            assert_ne!(decompress(&bytes[..length], 100).map(|out| out.len()), Some(12));
        }
        // Nothing lies before the beginning.
        assert_eq!(decompress(&[0, 0x13, b'a', 2, 0, 0x10, b'x'], 100), None);
        assert_eq!(decompress(&[0, 0x13, b'a', 0, 0, 0x10, b'x'], 100), None);
    }

    #[test]
    fn chunks_follow_each_other() {
        let bytes = [2, 2, 0, 0, 0, 0x10, b'a', 3, 0, 0, 0, 0x20, b'b', b'c'];
        assert_eq!(decompress(&bytes, 3).unwrap(), b"abc");
        assert_eq!(decompress(&bytes, 2), None);
    }

    #[test]
    fn integers_are_differences() {
        let mut plain = 1_i32.to_le_bytes().to_vec();
        // Codes of 123: small; 124 and 125: common; 100125: large; again: small; 100126: common; again: small.
        plain.extend([0b1100_0001, 0b0001_0001]);
        plain.push(123);
        plain.extend(100_000_i32.to_le_bytes());
        plain.extend([0, 0]);
        let mut bytes = vec![0, (plain.len() as u8) << 4];
        bytes.extend(&plain);
        assert_eq!(integers(&bytes, 7).unwrap(), [123, 124, 125, 100_125, 100_125, 100_126, 100_126]);
        assert_eq!(integers(&bytes, 9), None);
    }
}
