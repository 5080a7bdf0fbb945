//! Items of a file that is too large to be held as a whole, read in parts.

use super::header::Encoding;
use super::values::{Missing, Values};
use crate::text::{Tokens, length_before};
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
        match self.encoding {
            Encoding::Ascii => self.each_by(count, |text| read_line(text, &mut read)),
            encoding => self.each_in_bytes(count, |bytes| {
                let mut values = Values::new(encoding, bytes);
                read(&mut values)?;
                Ok(length_before(bytes, values.rest()))
            }),
        }
    }

    /// Reads so many binary items as [`Stream::each`], each from the bytes that begin with it. `read` returns their number.
    pub(super) fn each_in_bytes(
        &mut self,
        count: u64,
        mut read: impl FnMut(&[u8]) -> std::result::Result<usize, Missing>,
    ) -> Result<(u64, Option<Missing>)> {
        self.each_by(count, |bytes| {
            read(bytes).map_err(|missing| Some(missing).filter(|&m| m != Missing::End))
        })
    }

    /// Reads so many items. `read` returns the number of bytes that the first one takes; `None` if there are too few, or the reason
    /// why there can be no more items.
    fn each_by(
        &mut self,
        count: u64,
        mut read: impl FnMut(&[u8]) -> std::result::Result<usize, Option<Missing>>,
    ) -> Result<(u64, Option<Missing>)> {
        let mut number = 0;
        while number < count {
            let part = self.whole_part();
            let mut rest = part;
            let is_whole = loop {
                if number == count {
                    break true;
                }
                match read(rest) {
                    Ok(length) => rest = rest.get(length..).unwrap_or_default(),
                    Err(None) => break false,
                    Err(missing) => return Ok((number, missing)),
                }
                number = number.saturating_add(1);
            };
            self.first = self.first.saturating_add(length_before(part, rest));
            if !is_whole && !self.refill()? {
                return Ok((number, Some(Missing::End)));
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

/// Reads the item of the next line that has one, and returns the bytes up to its end; the error `None` is the end of the text.
fn read_line(
    text: &[u8],
    read: &mut impl FnMut(&mut Values<'_>) -> std::result::Result<(), Missing>,
) -> std::result::Result<usize, Option<Missing>> {
    let mut tokens = Tokens::new(text.trim_ascii_start());
    let line = tokens.rest_of_line();
    if line.is_empty() {
        return Err(None);
    }
    read(&mut Values::new(Encoding::Ascii, line))?;
    Ok(length_before(text, tokens.rest()))
}
