//! Items of a file that is too large to be held as a whole, read in parts.

use super::header::Encoding;
use super::values::{Missing, Values};
use crate::text::Tokens;
use std::io::{Read, Result, Seek, SeekFrom};

/// Bytes that are read at once.
const PART: usize = 1 << 20;

/// Bytes of the largest item: a polygon of a million corners has fewer.
const LARGEST_ITEM: usize = 1 << 24;

/// A file, or one in memory.
pub(super) trait Source: Read + Seek {}

impl<T: Read + Seek> Source for T {}

/// The items behind a place of a source. Those of text stand on lines of their own.
pub(super) struct Stream<'a> {
    source: &'a mut dyn Source,
    encoding: Encoding,
    buffer: Vec<u8>,
    /// First byte of the buffer that has not been read.
    first: usize,
    has_ended: bool,
}

impl<'a> Stream<'a> {
    pub(super) fn new(source: &'a mut dyn Source, place: u64, encoding: Encoding) -> Result<Self> {
        source.seek(SeekFrom::Start(place))?;
        Ok(Self { source, encoding, buffer: Vec::new(), first: 0, has_ended: false })
    }

    /// Reads so many items. `read` is asked again for an item that went beyond the part: it must change nothing before it has all
    /// values. Returns the number of items that are whole, and the reason if there are no more.
    pub(super) fn each(
        &mut self,
        count: u64,
        mut read: impl FnMut(&mut Values<'_>) -> std::result::Result<(), Missing>,
    ) -> Result<(u64, Option<Missing>)> {
        let mut number = 0;
        while number < count {
            let rest = self.whole_part();
            let before = rest.len();
            let mut values = Values::new(self.encoding, rest);
            let mut left = values.clone();
            let reason = loop {
                if number == count {
                    break None;
                }
                match self.encoding {
                    Encoding::Ascii => match read_line(&mut values, &mut read) {
                        Ok(()) => {}
                        Err(None) => break Some(Missing::End),
                        Err(Some(missing)) => return Ok((number, Some(missing))),
                    },
                    _ => match read(&mut values) {
                        Ok(()) => {}
                        Err(Missing::End) => break Some(Missing::End),
                        Err(missing) => return Ok((number, Some(missing))),
                    },
                }
                number = number.saturating_add(1);
                left = values.clone();
            };
            self.first = self.first.saturating_add(before.saturating_sub(left.rest().len()));
            if let Some(reason) = reason
                && !self.refill()?
            {
                return Ok((number, Some(reason)));
            }
        }
        Ok((number, None))
    }

    /// Bytes in the buffer, of text those of whole lines.
    fn whole_part(&self) -> &[u8] {
        let rest = self.buffer.get(self.first..).unwrap_or_default();
        if self.encoding != Encoding::Ascii || self.has_ended {
            return rest;
        }
        let end = rest.iter().rposition(|b| matches!(b, b'\n' | b'\r'));
        end.and_then(|end| rest.get(..=end)).unwrap_or_default()
    }

    /// Reads on. False if the source has ended, or an item is too large.
    fn refill(&mut self) -> Result<bool> {
        if self.has_ended {
            return Ok(false);
        }
        self.buffer.drain(..self.first.min(self.buffer.len()));
        self.first = 0;
        let had = self.buffer.len();
        if had >= LARGEST_ITEM {
            return Ok(false);
        }
        (&mut *self.source).take(PART as u64).read_to_end(&mut self.buffer)?;
        self.has_ended = self.buffer.len() == had;
        // The last line of a text may have no end.
        Ok(!self.has_ended || self.encoding == Encoding::Ascii && had > 0)
    }
}

/// Reads the item of the next line that has one; `None` is the end of the text.
fn read_line(
    values: &mut Values<'_>,
    read: &mut impl FnMut(&mut Values<'_>) -> std::result::Result<(), Missing>,
) -> std::result::Result<(), Option<Missing>> {
    let mut tokens = Tokens::new(values.rest().trim_ascii_start());
    let line = tokens.rest_of_line();
    if line.is_empty() {
        return Err(None);
    }
    *values = Values::Ascii(tokens);
    read(&mut Values::new(Encoding::Ascii, line)).map_err(Some)
}
