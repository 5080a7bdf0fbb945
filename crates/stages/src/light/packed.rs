//! A prefiltered environment (`file.rs`) in fewer bytes, for programs that want to be small: deflated, after its codes were
//! parted from what follows them, since each kind repeats itself in its own way. Two thirds of what deflating alone leaves, or
//! three fifths of the file.
//!
//! A zlib stream of: the file's header of 16 bytes; the numbers of first bytes and of second bytes of its codes (32 bits, little
//! endian); all first bytes; all second bytes; all texels that stand for themselves.

use super::file::{HEADER, RAW};
use miniz_oxide::inflate::decompress_to_vec_zlib_with_limit;
#[cfg(any(test, feature = "pack"))]
use std::num::NonZeroU64;

/// First bytes from here on have a second.
const LONG: u8 = 0xc0;

/// The largest file that there is no need to expect.
const LIMIT: usize = 1 << 24;

/// Packs what [`to_bytes`](super::PrefilteredEnvironment::to_bytes) made. `None` if the bytes are something else.
#[cfg(any(test, feature = "pack"))]
pub(super) fn pack(file: &[u8]) -> Option<Vec<u8>> {
    let (header, mut rest) = file.split_at_checked(HEADER)?;
    let [mut codes, mut seconds, mut texels] = [const { Vec::new() }; 3];
    while let Some((&code, after)) = rest.split_first() {
        codes.push(code);
        let (to, count) = match code {
            RAW.. => (&mut texels, 4),
            LONG.. => (&mut seconds, 1),
            _ => (&mut texels, 0),
        };
        let (bytes, after) = after.split_at_checked(count)?;
        to.extend_from_slice(bytes);
        rest = after;
    }
    let counts = [codes.len(), seconds.len()].map(|count| (count as u32).to_le_bytes());
    let parted = [header, counts.as_flattened(), &codes, &seconds, &texels].concat();
    let options = zopfli::Options {
        iteration_count: NonZeroU64::new(15).unwrap_or(NonZeroU64::MIN),
        ..Default::default()
    };
    let mut out = Vec::new();
    zopfli::compress(options, zopfli::Format::Zlib, &parted[..], &mut out).ok().map(|()| out)
}

/// The file that was packed; `None` if the bytes are something else.
#[cfg_attr(feature = "fast-loading", allow(dead_code))]
pub(super) fn unpack(packed: &[u8]) -> Option<Vec<u8>> {
    let parted = decompress_to_vec_zlib_with_limit(packed, LIMIT).ok()?;
    let (header, rest) = parted.split_at_checked(HEADER)?;
    let (counts, rest) = rest.split_at_checked(8)?;
    let count = |at: usize| Some(u32::from_le_bytes(*counts.get(at..)?.first_chunk()?) as usize);
    let (codes, rest) = rest.split_at_checked(count(0)?)?;
    let (mut seconds, mut texels) = rest.split_at_checked(count(4)?)?;
    let mut file = Vec::with_capacity(parted.len());
    file.extend_from_slice(header);
    for &code in codes {
        file.push(code);
        let (from, count) = match code {
            RAW.. => (&mut texels, 4),
            LONG.. => (&mut seconds, 1),
            _ => continue,
        };
        let (bytes, after) = from.split_at_checked(count)?;
        file.extend_from_slice(bytes);
        *from = after;
    }
    Some(file)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::light::PrefilteredEnvironment;

    #[test]
    fn packing_keeps_every_byte() {
        let file = PrefilteredEnvironment::black().to_bytes();
        assert_eq!(unpack(&pack(&file).unwrap()), Some(file));
    }

    #[test]
    fn the_packed_studio_is_the_studio() {
        let file = overcoat_assets::environment::STUDIO;
        let packed = overcoat_assets::environment::STUDIO_PACKED;
        assert!(unpack(packed).is_some_and(|unpacked| unpacked == file));
        assert!(packed.len() * 5 < file.len() * 3 + file.len() / 10, "{} bytes", packed.len());
    }

    #[test]
    fn damage_is_no_panic() {
        let packed = pack(&PrefilteredEnvironment::black().to_bytes()).unwrap();
        for end in 0..packed.len() {
            assert_eq!(unpack(&packed[..end]), None, "{end} bytes");
        }
    }
}
