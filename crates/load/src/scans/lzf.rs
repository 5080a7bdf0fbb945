//! LZF, the compression of PCD files (M. Lehmann, liblzf): runs of bytes, and references to bytes before.

/// The content, which has exactly so many bytes; `None` if the data are damaged.
///
/// A control byte below 32 is followed by one more bytes than it says. Others have the length in their highest three bits (7:
/// plus the next byte) and with the byte after that a distance of 13 bits.
pub(super) fn unpack(mut data: &[u8], size: usize) -> Option<Vec<u8>> {
    let mut out: Vec<u8> = Vec::new();
    while let Some((&control, rest)) = data.split_first() {
        data = rest;
        if control < 32 {
            let (run, rest) = data.split_at_checked(usize::from(control).saturating_add(1))?;
            data = rest;
            out.extend_from_slice(run);
        } else {
            let mut length = usize::from(control >> 5);
            if length == 7 {
                let (&more, rest) = data.split_first()?;
                length = length.saturating_add(more.into());
                data = rest;
            }
            let (&low, rest) = data.split_first()?;
            data = rest;
            let distance = (usize::from(control & 31) << 8 | usize::from(low)).saturating_add(1);
            let mut from = out.len().checked_sub(distance)?;
            // Byte for byte: what is copied may be what was just written.
            for _ in 0..length.saturating_add(2) {
                out.push(*out.get(from)?);
                from = from.saturating_add(1);
            }
        }
        if out.len() > size {
            return None;
        }
    }
    (out.len() == size).then_some(out)
}

#[cfg(test)]
mod tests {
    use super::unpack;

    #[test]
    fn runs_and_references() {
        assert_eq!(unpack(&[2, b'a', b'b', b'c', 0x20, 2], 6).unwrap(), b"abcabc");
        // Overlapping: one byte, nine times more.
        assert_eq!(unpack(&[0, b'x', 0xe0, 0, 0], 10).unwrap(), b"xxxxxxxxxx");
        assert_eq!(unpack(&[], 0).unwrap(), b"");
        for damaged in [&[3, b'a'][..], &[0x20, 0], &[0, b'a', 0x20], &[0, b'a', 0x20, 1], &[0xe0]] {
            assert_eq!(unpack(damaged, 3), None, "{damaged:?}");
        }
        assert_eq!(unpack(&[2, 1, 2, 3], 2), None);
    }
}
