//! Places of values in the items of binary files, which are known where no list shifts them.

use super::body::{SLOTS, Slots, store};
use super::header::{Element, Encoding, Kind, Scalar};
use super::values::{Missing, binary, binary_double};
use crate::text::length_before;
use std::ops::Range;

/// Values that stand at the same places in each item.
pub(super) struct Run {
    pub(super) size: usize,
    /// First byte, slot and type.
    values: Vec<(usize, usize, Scalar)>,
    is_big: bool,
}

impl Run {
    /// The values of some properties that are in one of these slots; `None` where a list or text shifts them.
    pub(super) fn new(
        element: &Element,
        encoding: Encoding,
        properties: Range<usize>,
        slots: &Slots,
        wanted: Range<usize>,
    ) -> Option<Self> {
        let is_big = match encoding {
            Encoding::Ascii => return None,
            Encoding::LittleEndian => false,
            Encoding::BigEndian => true,
        };
        let (mut size, mut values) = (0_usize, Vec::new());
        let slots = slots.0.get(properties.clone())?;
        for (property, slot) in element.properties.get(properties)?.iter().zip(slots) {
            let Kind::One(scalar) = property.kind else { return None };
            values.extend(slot.filter(|slot| wanted.contains(&slot.0)).map(|(slot, _)| (size, slot, scalar)));
            size = size.saturating_add(scalar.size());
        }
        Some(Self { size, values, is_big })
    }

    /// The bytes of the run, and those behind it.
    #[inline]
    pub(super) fn split<'a>(&self, bytes: &'a [u8]) -> Result<(&'a [u8], &'a [u8]), Missing> {
        bytes.split_at_checked(self.size).ok_or(Missing::End)
    }

    /// Stores the values of an item.
    #[inline]
    pub(super) fn read(&self, bytes: &[u8], item: &mut [f32; SLOTS]) -> Result<(), Missing> {
        for &(first, slot, scalar) in &self.values {
            let mut value = bytes.get(first..).ok_or(Missing::End)?;
            store(item, Some((slot, scalar)), binary(&mut value, scalar, self.is_big)?.0);
        }
        Ok(())
    }

    /// The first values, in double precision.
    #[inline]
    pub(super) fn position(&self, bytes: &[u8]) -> Result<[f64; 3], Missing> {
        let mut position = [f64::NAN; 3];
        for &(first, slot, scalar) in &self.values {
            let mut value = bytes.get(first..).ok_or(Missing::End)?;
            if let Some(v) = position.get_mut(slot) {
                *v = binary_double(&mut value, scalar, self.is_big)?;
            }
        }
        Ok(position)
    }
}

/// Faces of one list, that of their corners: all other values stand at the same places before and behind it.
pub(super) struct List {
    before: Run,
    count: Scalar,
    corner: Scalar,
    behind: Run,
}

impl List {
    /// Faces with the list at a place among their properties, and the values in some slots; `None` where there are other lists.
    pub(super) fn new(
        element: &Element,
        encoding: Encoding,
        at: usize,
        slots: &Slots,
        wanted: Range<usize>,
    ) -> Option<Self> {
        let Kind::List(count, corner) = element.properties.get(at)?.kind else { return None };
        let run = |properties| Run::new(element, encoding, properties, slots, wanted.clone());
        let behind = at.saturating_add(1)..element.properties.len();
        Some(Self { before: run(0..at)?, count, corner, behind: run(behind)? })
    }

    /// Reads the face that begins here. Returns its number of bytes.
    #[inline]
    pub(super) fn read(
        &self,
        bytes: &[u8],
        corners: &mut Vec<i64>,
        item: &mut [f32; SLOTS],
    ) -> Result<usize, Missing> {
        let (before, mut rest) = self.before.split(bytes)?;
        // A list of less than nothing has nothing.
        let count = usize::try_from(binary(&mut rest, self.count, self.before.is_big)?.1).unwrap_or(0);
        let size = count.saturating_mul(self.corner.size());
        let (list, rest) = rest.split_at_checked(size).ok_or(Missing::End)?;
        let (behind, rest) = self.behind.split(rest)?;
        self.read_corners(list, corners);
        self.before.read(before, item)?;
        self.behind.read(behind, item)?;
        Ok(length_before(bytes, rest))
    }

    #[inline]
    fn read_corners(&self, mut list: &[u8], corners: &mut Vec<i64>) {
        let is_big = self.before.is_big;
        let word =
            |&bytes: &[u8; 4]| if is_big { u32::from_be_bytes(bytes) } else { u32::from_le_bytes(bytes) };
        let words = list.as_chunks().0.iter().map(word);
        corners.clear();
        match self.corner {
            Scalar::I32 => corners.extend(words.map(|word| i64::from(word as i32))),
            Scalar::U32 => corners.extend(words.map(i64::from)),
            corner => corners.extend(std::iter::from_fn(|| Some(binary(&mut list, corner, is_big).ok()?.1))),
        }
    }
}
