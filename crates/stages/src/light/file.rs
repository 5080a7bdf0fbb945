//! A prefiltered environment as bytes: small to store, quick to read.
//!
//! All numbers are little endian.
//!
//! | bytes | content |
//! |---|---|
//! | 8 | `OVRCTENV` |
//! | 4 | version, 2 |
//! | 4 | samples along a side of the mirror map, 2^k + 1 from 3 to 1025; it fixes the sizes of all maps |
//! | rest | the texels of all maps, row by row, packed as below: irradiance, then from the roughest reflections to the mirror, so that
//! who needs no smooth ones reads little |
//!
//! A texel (see [`texel`](super::texel)) is predicted from its neighbours left, above and above left: left + above -
//! above left in every mantissa if the three have one exponent, otherwise left. Where a map begins the missing
//! neighbours count as black; a row's first texel has the last texel of the row above at its left. What follows says
//! how the texel differs from the prediction, as in the QOI picture format:
//!
//! | first byte | more | meaning |
//! |---|---|---|
//! | `0nnnnnnn` | | the next n + 1 texels are as predicted |
//! | `10rrggbb` | | mantissas differ by -2 to 1 each |
//! | `110ggggg` | `rrrrbbbb` | green differs by g = -16 to 15, red and blue by g - 8 to g + 7 |
//! | `11100000` | 4 | the texel itself |
//!
//! Differences wrap at 9 bits; the exponent is the prediction's.

use super::PrefilteredEnvironment;
use super::chain::{Chain, Levels, MAPS, MAX_CELLS, MIN_CELLS};

const MAGIC: &[u8; 8] = b"OVRCTENV";
const VERSION: u32 = 2;
pub(super) const HEADER: usize = 16;
pub(super) const RAW: u8 = 0b1110_0000;

/// Error: bytes that are not a prefiltered environment.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum EnvironmentFileError {
    /// The first bytes are not the format's.
    #[error("not a prefiltered environment")]
    Magic,
    /// Another version of the format.
    #[error("prefiltered environment of version {0}; this program reads version {VERSION}")]
    Version(u32),
    /// A size that no environment has.
    #[error("prefiltered environment with a mirror map of {0} samples; possible are 2^k + 1 from 3 to 1025")]
    Size(u32),
    /// The bytes end before the last texel.
    #[error("prefiltered environment is cut short")]
    Truncated,
    /// There are bytes after the last texel, or a code that has no meaning.
    #[error("prefiltered environment is damaged")]
    Damaged,
}

impl PrefilteredEnvironment {
    /// The prefiltered maps as bytes; the original picture is not part of them.
    #[must_use]
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut out = Vec::new();
        out.extend_from_slice(MAGIC);
        out.extend_from_slice(&VERSION.to_le_bytes());
        out.extend_from_slice(&(self.chain.size(0) as u32).to_le_bytes());
        for map in (0..MAPS).rev() {
            pack(self.chain.map(map), self.chain.size(map), &mut out);
        }
        out
    }

    /// The same in fewer bytes, in seconds.
    #[cfg(feature = "pack")]
    #[must_use]
    pub fn to_packed_bytes(&self) -> Vec<u8> {
        // What was just written is whole.
        super::packed::pack(&self.to_bytes()).unwrap_or_default()
    }

    /// Reads what [`PrefilteredEnvironment::to_bytes`] wrote.
    ///
    /// # Errors
    /// [`EnvironmentFileError`] if the bytes are anything else. Allocates no more than the largest environment takes
    /// (5 MB), whatever they say.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, EnvironmentFileError> {
        Self::from_first_bytes(bytes, 0)
    }

    /// The same without the levels before the `sharpest`, whose bytes are not looked at.
    pub(super) fn from_first_bytes(bytes: &[u8], sharpest: usize) -> Result<Self, EnvironmentFileError> {
        let header = bytes.get(..HEADER).ok_or(EnvironmentFileError::Magic)?;
        if &header[..8] != MAGIC {
            return Err(EnvironmentFileError::Magic);
        }
        let word =
            |at: usize| u32::from_le_bytes([header[at], header[at + 1], header[at + 2], header[at + 3]]);
        if word(8) != VERSION {
            return Err(EnvironmentFileError::Version(word(8)));
        }
        let size = word(12);
        let cells = size.wrapping_sub(1) as usize;
        if !(MIN_CELLS..=MAX_CELLS).contains(&cells) || !cells.is_power_of_two() {
            return Err(EnvironmentFileError::Size(size));
        }
        let mut chain = Chain::dark(size as usize);
        let mut rest = &bytes[HEADER..];
        for map in (sharpest..MAPS).rev() {
            let size = chain.size(map);
            rest = unpack(rest, size, chain.map_mut(map))?;
        }
        if !rest.is_empty() && sharpest == 0 {
            return Err(EnvironmentFileError::Damaged);
        }
        chain.present = Levels::from_level(sharpest);
        Ok(Self::of_chain(chain))
    }
}

/// The exponent of a texel, its mantissas of red and blue, and that of green: sums of mantissas that are not neighbours do
/// not run into each other, so that all can be done at once.
const EXPONENT: u32 = 0xf800_0000;
const RED_AND_BLUE: u32 = 511 | 511 << 18;
const GREEN: u32 = 511 << 9;

/// Mantissas in 64 bits, red and blue as in a texel and green 32 bits above its place: sums run into no neighbour.
#[inline(always)]
const fn spread(texel: u32) -> u64 {
    (texel & RED_AND_BLUE) as u64 | ((texel & GREEN) as u64) << 32
}

/// All mantissas at their largest, spread.
const LARGEST: u64 = spread(u32::MAX);

/// The texel of an exponent and of mantissas that are spread, modulo 512.
#[inline(always)]
fn joined(exponent: u32, mantissas: u64) -> u32 {
    let mantissas = mantissas & LARGEST;
    (exponent & EXPONENT) | mantissas as u32 | (mantissas >> 32) as u32
}

/// By how much the prediction for a texel differs from the texel at its left: above - corner in each mantissa, modulo 512,
/// if all three have one exponent, otherwise nothing. Spread. Of `left` only the exponent counts.
#[inline(always)]
fn slope(left: u32, above: u32, corner: u32) -> u64 {
    let slope = spread(above) + minus(spread(corner));
    if (left ^ above | left ^ corner) & EXPONENT == 0 { slope } else { 0 }
}

/// 512 minus each of three mantissas, spread: what is subtracted without a difference that is negative.
#[inline(always)]
const fn minus(mantissas: u64) -> u64 {
    const ONE: u64 = spread(1 | 1 << 9 | 1 << 18);
    (LARGEST ^ mantissas) + ONE
}

/// The prediction for a texel from its neighbours. It has the exponent of the one at its left.
fn predict(left: u32, above: u32, corner: u32) -> u32 {
    joined(left, spread(left) + slope(left, above, corner))
}

/// The neighbours of texel `k` of a map: left, above, and above left. Those before the first are black.
fn neighbours(texels: &[u32], size: usize, k: usize) -> [u32; 3] {
    [1, size, size + 1].map(|distance| if k >= distance { texels[k - distance] } else { 0 })
}

/// Differences of red, green and blue as mantissas modulo 512.
#[inline(always)]
const fn differences(r: i32, g: i32, b: i32) -> u32 {
    (r & 511 | (g & 511) << 9 | (b & 511) << 18) as u32
}

/// Decoded differences by code, spread: those of the first byte, and for codes of two bytes what the second adds.
const FIRST: [u64; 256] = {
    let mut table = [0; 256];
    let mut code = 0x80;
    while code < 0xc0_i32 {
        table[code as usize] = spread(differences((code & 3) - 2, (code >> 2 & 3) - 2, (code >> 4 & 3) - 2));
        code += 1;
    }
    while code < RAW as i32 {
        let green = (code & 31) - 16;
        table[code as usize] = spread(differences(green - 8, green, green - 8));
        code += 1;
    }
    table
};
const SECOND: [u64; 256] = {
    let mut table = [0; 256];
    let mut code = 0;
    while code < 256 {
        table[code as usize] = spread(differences(code & 15, 0, code >> 4));
        code += 1;
    }
    table
};

fn pack(texels: &[u32], size: usize, out: &mut Vec<u8>) {
    let mut run = 0_u8;
    for (k, &texel) in texels.iter().enumerate() {
        let [left, above, corner] = neighbours(texels, size, k);
        let prediction = predict(left, above, corner);
        if texel == prediction {
            if run == 128 {
                out.push(127);
                run = 0;
            }
            run += 1;
            continue;
        }
        if run > 0 {
            out.push(run - 1);
            run = 0;
        }
        // Differences as signed numbers of 9 bits.
        let [r, g, b] = [0, 9, 18].map(|shift| {
            let difference = (texel >> shift).wrapping_sub(prediction >> shift) & 511;
            (difference as i32) << 23 >> 23
        });
        let same_exponent = (texel ^ prediction) >> 27 == 0;
        if same_exponent && [r, g, b].iter().all(|d| (-2..2).contains(d)) {
            out.push(0x80 | (r + 2) as u8 | ((g + 2) as u8) << 2 | ((b + 2) as u8) << 4);
        } else if same_exponent
            && (-16..16).contains(&g)
            && [r - g, b - g].iter().all(|d| (-8..8).contains(d))
        {
            out.push(0xc0 | (g + 16) as u8);
            out.push((r - g + 8) as u8 | ((b - g + 8) as u8) << 4);
        } else {
            out.push(RAW);
            out.extend_from_slice(&texel.to_le_bytes());
        }
    }
    if run > 0 {
        out.push(run - 1);
    }
}

/// Fills one map and returns the bytes after it.
fn unpack<'a>(bytes: &'a [u8], size: usize, texels: &mut [u32]) -> Result<&'a [u8], EnvironmentFileError> {
    static BLACK: [u32; MAX_CELLS + 1] = [0; MAX_CELLS + 1];
    let byte = |at: usize| bytes.get(at).copied().unwrap_or(0);
    let mut at = 0;
    // Texels of a run that are yet to come.
    let mut run = 0;
    let mut left = Left { exponent: 0, mantissas: 0, corner: 0, minus_corner: minus(spread(0)) };
    for row in 0..texels.len() / size {
        let (before, rest) = texels.split_at_mut(row * size);
        let above = before.rchunks(size).next().unwrap_or(&BLACK);
        for (texel, &above) in rest[..size].iter_mut().zip(above) {
            let mut differences = 0;
            if run > 0 {
                run -= 1;
            } else {
                let code = byte(at);
                if (1..0x80).contains(&code) {
                    run = code;
                    at += 1;
                } else if code < RAW {
                    // A run of one is no difference. Without a branch for each kind of code: which comes next nobody can
                    // predict.
                    let long = code >= 0xc0;
                    let second = if long { byte(at + 1) } else { 0 };
                    differences = FIRST[usize::from(code)] + SECOND[usize::from(second)];
                    at += 1 + usize::from(long);
                } else if code == RAW {
                    *texel = u32::from_le_bytes([byte(at + 1), byte(at + 2), byte(at + 3), byte(at + 4)]);
                    left.replace(*texel, above);
                    at += 5;
                    continue;
                } else {
                    return Err(EnvironmentFileError::Damaged);
                }
            }
            *texel = left.next(above, differences);
        }
        // Bytes beyond the end were read as zeros, and there are fewer of them than texels.
        if at > bytes.len() {
            return Err(EnvironmentFileError::Truncated);
        }
    }
    if run > 0 {
        return Err(EnvironmentFileError::Damaged);
    }
    Ok(&bytes[at..])
}

/// The texel at the left of the next one, and what is above it. Each texel waits for the one before: what it needs of that
/// is kept apart, so that it waits for two operations and not for [`predict`].
struct Left {
    exponent: u32,
    /// Spread.
    mantissas: u64,
    /// The texel above.
    corner: u32,
    /// Its mantissas as [`slope`] adds them.
    minus_corner: u64,
}

impl Left {
    /// The next texel, which differs from its prediction by so much, and becomes the one at the left.
    #[inline(always)]
    fn next(&mut self, above: u32, differences: u64) -> u32 {
        let above_mantissas = spread(above);
        let slope = above_mantissas + self.minus_corner;
        let is_one = (self.exponent ^ above | self.exponent ^ self.corner) & EXPONENT == 0;
        self.mantissas = (self.mantissas + (if is_one { slope } else { 0 } + differences)) & LARGEST;
        (self.corner, self.minus_corner) = (above, minus(above_mantissas));
        joined(self.exponent, self.mantissas)
    }

    /// The next texel is this one.
    fn replace(&mut self, texel: u32, above: u32) {
        (self.exponent, self.mantissas) = (texel & EXPONENT, spread(texel));
        (self.corner, self.minus_corner) = (above, minus(spread(above)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn packing_keeps_every_bit() {
        let size = 33;
        let mut state = 7_u32;
        let mut next = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            state >> 8
        };
        // Flat, a ramp in both directions, small noise, large noise and anything.
        for kind in 0..5 {
            let texels: Vec<u32> = (0..size * size)
                .map(|k| {
                    let ramp = (k % size * 3 + k / size * 2) as u32 & 511;
                    let base = 9 << 27;
                    match kind {
                        0 => base | 300 << 18 | 200 << 9 | 100,
                        1 => base | ramp << 18 | (511 - ramp) << 9 | 100,
                        2 => base | (200 + next() % 4) << 18 | (300 + next() % 4) << 9 | (next() % 4),
                        3 => base | (200 + next() % 30) << 18 | (300 + next() % 30) << 9 | (next() % 20),
                        _ => next() << 16 ^ next(),
                    }
                })
                .collect();
            let mut packed = Vec::new();
            pack(&texels, size as usize, &mut packed);
            let mut found = vec![0; texels.len()];
            assert_eq!(unpack(&packed, size as usize, &mut found), Ok(&[][..]));
            assert!(found == texels, "kind {kind}");
            if kind < 2 {
                assert!(packed.len() < texels.len(), "{} bytes of kind {kind}", packed.len());
            }
        }
    }

    #[test]
    fn damage_is_an_error_and_never_a_panic() {
        let bytes = PrefilteredEnvironment::black().to_bytes();
        assert!(PrefilteredEnvironment::from_bytes(&bytes).is_ok());
        for end in 0..bytes.len() {
            assert!(PrefilteredEnvironment::from_bytes(&bytes[..end]).is_err(), "{end} bytes");
        }
        let changed = |at: usize, value: u8| {
            let mut bytes = bytes.clone();
            bytes[at] = value;
            PrefilteredEnvironment::from_bytes(&bytes)
        };
        assert_eq!(changed(0, 0).unwrap_err(), EnvironmentFileError::Magic);
        assert_eq!(changed(8, 3).unwrap_err(), EnvironmentFileError::Version(3));
        assert_eq!(changed(12, 4).unwrap_err(), EnvironmentFileError::Size(4));
        assert_eq!(changed(15, 255).unwrap_err(), EnvironmentFileError::Size(0xff00_0003));
        assert_eq!(changed(HEADER, 0xff).unwrap_err(), EnvironmentFileError::Damaged);
        let mut longer = bytes.clone();
        longer.push(0);
        assert_eq!(PrefilteredEnvironment::from_bytes(&longer).unwrap_err(), EnvironmentFileError::Damaged);
        // Every value of every byte: whatever comes out, nothing panics.
        for at in 0..bytes.len() {
            for value in 0..=255 {
                let _ = changed(at, value);
            }
        }
    }
}
