//! Pages of an E57 file: the last four bytes of each are the checksum of the others.
//!
//! Offsets of the file count all bytes (physical), lengths only those without checksums (logical).

/// Bytes of a checksum.
const CHECKSUM: usize = 4;
/// Castagnoli's polynomial, reflected (CRC-32C, RFC 3720 appendix B.4).
const POLYNOMIAL: u32 = 0x82f6_3b78;

/// A file in pages.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pages<'a> {
    bytes: &'a [u8],
    /// Bytes of a page, with the checksum.
    size: usize,
    /// Bytes of a page without it.
    payload: usize,
}

impl<'a> Pages<'a> {
    /// The pages of a file; `None` for a size that the format does not have.
    pub(super) fn new(bytes: &'a [u8], size: u64) -> Option<Self> {
        let size = usize::try_from(size).ok().filter(|size| (64..=1 << 24).contains(size))?;
        Some(Self { bytes, size, payload: size.checked_sub(CHECKSUM)? })
    }

    /// Bytes of the file.
    pub(super) fn length(&self) -> u64 {
        self.bytes.len() as u64
    }

    /// Logical place of a physical offset; `None` within a checksum.
    pub(super) fn logical(&self, physical: u64) -> Option<u64> {
        let page = physical.checked_div(self.size as u64)?;
        let place = physical.checked_rem(self.size as u64)?;
        (place < self.payload as u64).then_some(())?;
        page.checked_mul(self.payload as u64)?.checked_add(place)
    }

    /// Appends so many bytes from a logical place on; `None` where the file ends before.
    pub(super) fn read(&self, mut place: u64, mut count: usize, out: &mut Vec<u8>) -> Option<()> {
        while count > 0 {
            let page = usize::try_from(place.checked_div(self.payload as u64)?).ok()?;
            let within = place.checked_rem(self.payload as u64)? as usize;
            let part = count.min(self.payload.checked_sub(within)?);
            let start = page.checked_mul(self.size)?.checked_add(within)?;
            out.extend_from_slice(self.bytes.get(start..start.checked_add(part)?)?);
            place = place.checked_add(part as u64)?;
            count = count.checked_sub(part)?;
        }
        Some(())
    }

    /// Number of pages with another checksum than they say.
    pub(super) fn damaged(&self) -> u64 {
        let tables = tables();
        let is_damaged = |page: &&[u8]| {
            page.split_last_chunk::<CHECKSUM>()
                // The reference implementation writes them from the highest byte on.
                .is_some_and(|(content, said)| checksum(content, &tables) != u32::from_be_bytes(*said))
        };
        self.bytes.chunks_exact(self.size).filter(is_damaged).count() as u64
    }
}

/// Remainders of a byte with 0 to 7 bytes of zeros behind it.
type Tables = [[u32; 256]; 8];

fn tables() -> Tables {
    let mut tables = [[0; 256]; 8];
    let mut before = [0_u32; 256];
    for (value, slot) in (0_u32..).zip(&mut before) {
        *slot = (0..8).fold(value, |v, _| v >> 1 ^ if v & 1 == 1 { POLYNOMIAL } else { 0 });
    }
    let first = before;
    for table in &mut tables {
        *table = before;
        for slot in &mut before {
            *slot = *slot >> 8 ^ entry(&first, *slot);
        }
    }
    tables
}

/// Entry of the lowest byte.
fn entry(table: &[u32; 256], value: u32) -> u32 {
    table.get((value & 0xff) as usize).copied().unwrap_or(0)
}

/// CRC-32C, eight bytes at once (M. Kounavis and F. Berry, *A Systematic Approach to Building High Performance Software-Based
/// CRC Generators*, 2005).
fn checksum(content: &[u8], tables: &Tables) -> u32 {
    let [t0, t1, t2, t3, t4, t5, t6, t7] = tables;
    let (eights, rest) = content.as_chunks::<8>();
    let mut sum = !0_u32;
    for &[a, b, c, d, e, f, g, h] in eights {
        let (low, high) = (u32::from_le_bytes([a, b, c, d]) ^ sum, u32::from_le_bytes([e, f, g, h]));
        sum = entry(t7, low) ^ entry(t6, low >> 8) ^ entry(t5, low >> 16) ^ entry(t4, low >> 24);
        sum ^= entry(t3, high) ^ entry(t2, high >> 8) ^ entry(t1, high >> 16) ^ entry(t0, high >> 24);
    }
    for &byte in rest {
        sum = sum >> 8 ^ entry(t0, sum ^ u32::from(byte));
    }
    !sum
}

#[cfg(test)]
pub(super) fn checksum_of(content: &[u8]) -> u32 {
    checksum(content, &tables())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values of RFC 3720, appendix B.4.
    #[test]
    fn checksums_are_those_of_the_specification() {
        let up: Vec<u8> = (0..32).collect();
        for (content, expected) in
            [(vec![0; 32], 0x8a91_36aa_u32), (vec![0xff; 32], 0x62a8_ab43), (up, 0x46dd_794e)]
        {
            assert_eq!(checksum_of(&content), expected);
        }
        assert_eq!(checksum_of(b"123456789"), 0xe306_9283);
    }
}
