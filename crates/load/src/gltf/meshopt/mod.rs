//! Decoders of EXT_meshopt_compression and KHR_meshopt_compression, after the text of the latter (appendices A and B;
//! the former is the same without version 1 of attributes and without the colour filter).
//!
//! Every byte that is read is checked for, and the length of what comes out is known before.

mod attributes;
#[cfg(test)]
mod encoder;
mod filters;
mod indices;

use serde::Deserialize;
use std::num::NonZeroUsize;

/// Reason why a stream cannot be decoded.
type Damage = &'static str;

const CUT_OFF: Damage = "its compressed data ends too early";
const LEFT_OVER: Damage = "its compressed data goes on after the last element";

/// Kind of bitstream.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
pub(super) enum Mode {
    /// Elements of any kind.
    #[serde(rename = "ATTRIBUTES")]
    Attributes,
    /// Indices of a list of triangles.
    #[serde(rename = "TRIANGLES")]
    Triangles,
    /// Other indices.
    #[serde(rename = "INDICES")]
    Indices,
    /// Something that the extensions do not know.
    #[default]
    #[serde(other)]
    Unknown,
}

/// Filter that is applied to elements after decoding.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
pub(super) enum Filter {
    /// Nothing.
    #[default]
    #[serde(rename = "NONE")]
    None,
    /// Unit vectors from octahedral coordinates.
    #[serde(rename = "OCTAHEDRAL")]
    Octahedral,
    /// Unit quaternions from three components.
    #[serde(rename = "QUATERNION")]
    Quaternion,
    /// Floats from an exponent and a mantissa.
    #[serde(rename = "EXPONENTIAL")]
    Exponential,
    /// Colours from luma and chroma.
    #[serde(rename = "COLOR")]
    Color,
    /// Something that the extensions do not know.
    #[serde(other)]
    Unknown,
}

/// Layout of the decompressed contents of a view.
#[derive(Clone, Copy, Debug)]
pub(super) struct Layout {
    mode: Mode,
    filter: Filter,
    stride: NonZeroUsize,
    /// Number of elements.
    count: u64,
    /// Bytes of all of them.
    size: usize,
}

impl Layout {
    /// Checks the rules of section "JSON schema updates".
    ///
    /// # Errors
    /// The rule that is broken.
    pub(super) fn new(mode: Mode, filter: Filter, count: u64, stride: u64) -> Result<Self, Damage> {
        let stride = match (mode, stride) {
            (Mode::Attributes, 4..=256) if stride.is_multiple_of(4) => stride as usize,
            (Mode::Triangles | Mode::Indices, 2 | 4) => stride as usize,
            (Mode::Unknown, _) => return Err("its compression mode is not known"),
            _ => return Err("its compression mode does not allow this byteStride"),
        };
        match (filter, mode, stride) {
            (Filter::Unknown, ..) => return Err("its compression filter is not known"),
            (Filter::None, ..)
            | (Filter::Octahedral | Filter::Color, Mode::Attributes, 4 | 8)
            | (Filter::Quaternion, Mode::Attributes, 8)
            | (Filter::Exponential, Mode::Attributes, _) => {}
            _ => return Err("its compression filter does not allow this mode or byteStride"),
        }
        if mode == Mode::Triangles && !count.is_multiple_of(3) {
            return Err("its count is no whole number of triangles");
        }
        // No list is larger than `isize` tells.
        let size = usize::try_from(count).ok().and_then(|count| count.checked_mul(stride));
        let size = size.filter(|&size| isize::try_from(size).is_ok()).ok_or("it has too many elements")?;
        let stride =
            NonZeroUsize::new(stride).ok_or("its compression mode does not allow this byteStride")?;
        Ok(Self { mode, filter, stride, count, size })
    }

    /// Bytes that decoding gives.
    pub(super) fn decoded(&self) -> u64 {
        self.size as u64
    }

    /// No valid stream is longer than this.
    pub(super) fn longest(&self) -> u64 {
        let stride = self.stride.get() as u64;
        let (parts, each, once) = match self.mode {
            // In the worst case a group of 16 elements takes 24 bytes for each of their bytes, a quarter byte of header
            // and, once a block, a quarter byte of control.
            Mode::Attributes => (self.count.div_ceil(16), stride.saturating_mul(32), 321),
            // A code, a byte and three indices each.
            Mode::Triangles => (self.count / 3, 17, 17),
            Mode::Indices | Mode::Unknown => (self.count, 5, 5),
        };
        parts.saturating_mul(each).saturating_add(once)
    }

    /// The elements. Allocates [`Layout::decoded`] bytes.
    ///
    /// # Errors
    /// What is wrong with the stream.
    pub(super) fn decode(&self, stream: &[u8]) -> Result<Vec<u8>, Damage> {
        let mut out = vec![0; self.size];
        let stride = self.stride.get();
        match self.mode {
            Mode::Attributes => attributes::decode(stream, self.stride, &mut out)?,
            Mode::Triangles if stride == 2 => indices::triangles(stream, out.as_chunks_mut().0, narrow)?,
            Mode::Triangles => indices::triangles(stream, out.as_chunks_mut().0, u32::to_le_bytes)?,
            Mode::Indices if stride == 2 => indices::sequence(stream, out.as_chunks_mut().0, narrow)?,
            Mode::Indices | Mode::Unknown => {
                indices::sequence(stream, out.as_chunks_mut().0, u32::to_le_bytes)?;
            }
        }
        match (self.filter, stride) {
            (Filter::None | Filter::Unknown, _) => {}
            (Filter::Octahedral, 4) => filters::octahedral8(out.as_chunks_mut().0),
            (Filter::Octahedral, _) => filters::octahedral16(out.as_chunks_mut().0),
            (Filter::Quaternion, _) => filters::quaternion(out.as_chunks_mut().0),
            (Filter::Exponential, _) => filters::exponential(out.as_chunks_mut().0),
            (Filter::Color, 4) => filters::color8(out.as_chunks_mut().0),
            (Filter::Color, _) => filters::color16(out.as_chunks_mut().0),
        }
        Ok(out)
    }
}

/// The low half of an index, as the extensions demand for indices of 16 bits.
fn narrow(index: u32) -> [u8; 2] {
    (index as u16).to_le_bytes()
}

/// Takes a byte off the front.
fn take_one(rest: &mut &[u8]) -> Result<u8, Damage> {
    let (taken, others) = rest.split_first().ok_or(CUT_OFF)?;
    *rest = others;
    Ok(*taken)
}

/// Takes as many bytes off the front as the caller has room for.
fn take_array<'a, const N: usize>(rest: &mut &'a [u8]) -> Result<&'a [u8; N], Damage> {
    let (taken, others) = rest.split_first_chunk().ok_or(CUT_OFF)?;
    *rest = others;
    Ok(taken)
}

/// Takes bytes off the front.
fn take<'a>(rest: &mut &'a [u8], count: usize) -> Result<&'a [u8], Damage> {
    let (taken, others) = rest.split_at_checked(count).ok_or(CUT_OFF)?;
    *rest = others;
    Ok(taken)
}

#[cfg(test)]
mod tests {
    use super::encoder::{Random, attributes, indices, triangles};
    use super::*;

    #[test]
    fn rules_of_the_layout() {
        let new = |mode, filter, count, stride| Layout::new(mode, filter, count, stride).map(|l| l.decoded());
        assert_eq!(new(Mode::Attributes, Filter::None, 148, 16), Ok(148 * 16));
        assert_eq!(new(Mode::Attributes, Filter::None, 0, 256), Ok(0));
        for stride in [0, 2, 3, 6, 257, 260, u64::MAX] {
            new(Mode::Attributes, Filter::None, 3, stride).unwrap_err();
        }
        for mode in [Mode::Triangles, Mode::Indices] {
            assert_eq!(new(mode, Filter::None, 6, 2), Ok(12));
            for stride in [0, 1, 3, 8] {
                new(mode, Filter::None, 6, stride).unwrap_err();
            }
            new(mode, Filter::Exponential, 6, 4).unwrap_err();
        }
        new(Mode::Triangles, Filter::None, 7, 4).unwrap_err();
        new(Mode::Indices, Filter::None, 7, 4).unwrap();
        new(Mode::Unknown, Filter::None, 3, 4).unwrap_err();
        new(Mode::Attributes, Filter::Unknown, 3, 4).unwrap_err();
        for (filter, good, bad) in [
            (Filter::Octahedral, &[4, 8][..], &[12][..]),
            (Filter::Color, &[4, 8], &[16]),
            (Filter::Quaternion, &[8], &[4]),
            (Filter::Exponential, &[4, 12, 256], &[]),
        ] {
            for &stride in good {
                new(Mode::Attributes, filter, 5, stride).unwrap();
            }
            for &stride in bad {
                new(Mode::Attributes, filter, 5, stride).unwrap_err();
            }
        }
        new(Mode::Attributes, Filter::None, u64::MAX, 256).unwrap_err();
    }

    /// A stream of each kind with its layout.
    fn streams(random: &mut Random) -> Vec<(Layout, Vec<u8>)> {
        let layout = |mode, count: usize, stride: usize| {
            Layout::new(mode, Filter::None, count as u64, stride as u64).unwrap()
        };
        let mut streams = Vec::new();
        for version in [0, 1] {
            let (count, stride) = (1 + random.below(300), 4 * (1 + random.below(6)));
            let elements = random.elements(count, stride);
            streams.push((
                layout(Mode::Attributes, count, stride),
                attributes(&elements, stride, version, random),
            ));
        }
        let count = 1 + random.below(60);
        let list = random.triangles(count);
        streams.push((layout(Mode::Triangles, list.len(), 4), triangles(&list, random)));
        streams.push((layout(Mode::Indices, list.len(), 2), indices(&list, random)));
        streams
    }

    #[test]
    fn no_stream_is_longer_than_the_longest() {
        let mut random = Random::new(7);
        for _ in 0..50 {
            for (layout, stream) in streams(&mut random) {
                assert!(stream.len() as u64 <= layout.longest(), "{layout:?} {}", stream.len());
            }
        }
    }

    #[test]
    fn every_truncation_is_an_error() {
        let mut random = Random::new(11);
        for _ in 0..3 {
            for (layout, stream) in streams(&mut random) {
                layout.decode(&stream).unwrap();
                for length in 0..stream.len() {
                    layout.decode(&stream[..length]).unwrap_err();
                }
            }
        }
    }

    #[test]
    fn damaged_streams_end_in_an_error_or_in_other_elements() {
        let mut random = Random::new(13);
        let mut refused = 0;
        for _ in 0..300 {
            for (layout, mut stream) in streams(&mut random) {
                for _ in 0..8 {
                    let at = random.below(stream.len());
                    stream[at] ^= 1 << random.below(8);
                    refused += usize::from(layout.decode(&stream).is_err());
                }
                let noise: Vec<u8> = (0..stream.len()).map(|_| random.next() as u8).collect();
                let _ = layout.decode(&noise);
            }
        }
        assert!(refused > 1000, "{refused}");
    }
}
