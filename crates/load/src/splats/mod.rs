//! Files of Gaussian splats alone: `.splat`, SPZ, KSPLAT and SOG. (PLY is read where all of it is.)

pub(crate) mod ksplat;
pub(crate) mod sog;
pub(crate) mod splat;
pub(crate) mod spz;
#[cfg(test)]
mod tests;

use crate::LoadError;

/// A rotation, of which the three smallest numbers are stored, in the order x, y, z, w.
fn with_largest(small: [f32; 3], place: u32) -> [f32; 4] {
    let [a, b, c] = small;
    let rest = 1.0 - (a * a + b * b + c * c);
    let largest = if rest > 0.0 { rest.sqrt() } else { 0.0 };
    match place {
        0 => [largest, a, b, c],
        1 => [a, largest, b, c],
        2 => [a, b, largest, c],
        _ => [a, b, c, largest],
    }
}

/// Bytes of a file that are read one after the other.
struct Bytes<'a> {
    format: &'static str,
    rest: &'a [u8],
}

impl<'a> Bytes<'a> {
    /// The next so many bytes, which are called `what` in messages.
    fn take(&mut self, count: u64, what: &str) -> Result<&'a [u8], LoadError> {
        let parts = usize::try_from(count).ok().and_then(|count| self.rest.split_at_checked(count));
        let Some((taken, rest)) = parts else {
            let there = self.rest.len();
            let message = format!("the file ends within the {what}: {there} of {count} bytes are there");
            return Err(LoadError::malformed(self.format, message));
        };
        self.rest = rest;
        Ok(taken)
    }
}

/// The number at a place of a header; 0 beyond its end.
fn u32_at(bytes: &[u8], place: usize) -> u32 {
    let found = bytes.get(place..).and_then(|bytes| bytes.first_chunk());
    found.map_or(0, |bytes| u32::from_le_bytes(*bytes))
}

/// The same for numbers of 16 bits.
fn u16_at(bytes: &[u8], place: usize) -> u16 {
    let found = bytes.get(place..).and_then(|bytes| bytes.first_chunk());
    found.map_or(0, |bytes| u16::from_le_bytes(*bytes))
}

/// The same for floats.
fn f32_at(bytes: &[u8], place: usize) -> f32 {
    f32::from_bits(u32_at(bytes, place))
}
