//! Byte indices of the permutations of AVX-512.

use super::LANES;

/// From two vectors of four bytes a lane to those bytes of both that are next to each other in a number: the first bytes of
/// all lanes in pairs, then the second bytes.
pub(super) const PAIRS: [[u8; 64]; 2] = {
    let mut index = [[0; 64]; 2];
    let mut k = 0;
    while k < 64 {
        let lane = k / 2 % LANES;
        let byte = 4 * lane + k / 32 + 64 * (k % 2);
        index[0][k] = byte as u8;
        // The third bytes of all lanes; nobody asks for the fourth.
        index[1][k] = (4 * lane + 2 + 64 * (k % 2)) as u8;
        k += 1;
    }
    index
};

/// From the pairs of lower and of upper bytes to numbers: of the first half, of the second half.
pub(super) const NUMBERS: [[u8; 64]; 2] = {
    let mut index = [[0; 64]; 2];
    let mut k = 0;
    while k < 64 {
        let byte = k / 4 * 2 + k % 2 + 64 * (k / 2 % 2);
        index[0][k] = byte as u8;
        index[1][k] = (byte + 32) as u8;
        k += 1;
    }
    index
};

/// From numbers of four bytes to places of bytes: the first byte of the number that each byte belongs to, within its
/// sixteen, and which byte of it that is.
pub(super) const SPREAD: [[u8; 64]; 2] = {
    let mut index = [[0; 64]; 2];
    let mut k = 0;
    while k < 64 {
        index[0][k] = (k % 16 / 4 * 4) as u8;
        index[1][k] = (k % 4) as u8;
        k += 1;
    }
    index
};
