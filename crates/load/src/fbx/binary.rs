//! The binary encoding (A. Gessler, C. Barton, *FBX binary file format specification*): records with the place where they end.

use super::record::{Array, FORMAT, File, Record, Value, is_animation, is_read};
use crate::budget::Budget;
use crate::{Context, LoadError};
use overcoat_core::limits::Limits;
use std::borrow::Cow;

/// Begins every binary file.
pub(super) const MAGIC: &[u8] = b"Kaydara FBX Binary";
/// Magic with two spaces and a zero, two more bytes and the version.
const HEAD: usize = 27;
/// Version from which on places and counts have 64 bits.
const WIDE: u32 = 7500;

/// Reads the records of a file.
pub(super) fn read<'a>(
    bytes: &'a [u8],
    context: &Context<'_>,
    budget: &mut Budget,
) -> Result<File<'a>, LoadError> {
    let Some((head, _)) = bytes.split_first_chunk::<HEAD>() else {
        return Err(LoadError::malformed(FORMAT, "it ends within its head"));
    };
    let [.., big, a, b, c, d] = *head;
    if big == 1 {
        return Err(LoadError::unsupported(FORMAT, "the order of its bytes is big-endian"));
    }
    let version = u32::from_le_bytes([a, b, c, d]);
    let mut reader = Reader {
        bytes,
        at: HEAD,
        wide: version >= WIDE,
        budget,
        depth: context.limits.depth,
        cut: false,
        animated: false,
    };
    let records = reader.records(bytes.len(), 1)?;
    Ok(File {
        version,
        cut: reader.cut,
        is_animated: reader.animated,
        root: Record { records, ..Record::default() },
    })
}

struct Reader<'a, 'b> {
    bytes: &'a [u8],
    at: usize,
    wide: bool,
    budget: &'b mut Budget,
    depth: u64,
    cut: bool,
    animated: bool,
}

/// Head of a record.
struct Head<'a> {
    /// Place behind the record; 0 for one that ends a list.
    end: usize,
    values: u64,
    /// Bytes of the values.
    length: usize,
    name: &'a [u8],
}

impl<'a> Reader<'a, '_> {
    fn take<const N: usize>(&mut self) -> Option<[u8; N]> {
        let chunk = *self.bytes.get(self.at..)?.first_chunk::<N>()?;
        self.at = self.at.checked_add(N)?;
        Some(chunk)
    }

    fn slice(&mut self, length: usize) -> Option<&'a [u8]> {
        let end = self.at.checked_add(length)?;
        let slice = self.bytes.get(self.at..end)?;
        self.at = end;
        Some(slice)
    }

    fn number(&mut self) -> Option<u64> {
        if self.wide { self.take().map(u64::from_le_bytes) } else { self.u32().map(u64::from) }
    }

    fn u32(&mut self) -> Option<u32> {
        self.take().map(u32::from_le_bytes)
    }

    fn head(&mut self) -> Option<Head<'a>> {
        let (end, values, length) = (self.number()?, self.number()?, self.number()?);
        let [name] = self.take()?;
        let name = self.slice(name.into())?;
        let place = |v: u64| usize::try_from(v).unwrap_or(usize::MAX);
        Some(Head { end: place(end), values, length: place(length), name })
    }

    /// Reads the records up to a place, or to the one that ends their list.
    fn records(&mut self, end: usize, depth: u64) -> Result<Vec<Record<'a>>, LoadError> {
        Limits::check(|| format!("{FORMAT}: the depth of records"), depth, self.depth, "depth")?;
        let mut records = Vec::new();
        // Behind the last record of a file there is a footer.
        while self.at < end {
            let Some(head) = self.head() else {
                self.cut = true;
                break;
            };
            if head.end == 0 {
                break;
            }
            if head.end > end || head.end < self.at {
                self.cut = true;
                if head.end < self.at {
                    break;
                }
            }
            let own_end = head.end.min(end);
            if is_read(head.name, depth) {
                records.push(self.record(&head, own_end, depth)?);
            }
            self.animated |= is_animation(head.name);
            self.at = own_end;
        }
        Ok(records)
    }

    fn record(&mut self, head: &Head<'a>, end: usize, depth: u64) -> Result<Record<'a>, LoadError> {
        let size = size_of::<Record<'_>>() as u64;
        self.budget.charge(|| format!("{FORMAT}: the list of records"), 1, size)?;
        let mut record = Record { name: Cow::Borrowed(head.name), ..Record::default() };
        let within = self.at.saturating_add(head.length);
        for _ in 0..head.values {
            let value = if self.at < within { self.value() } else { None };
            let Some(value) = value else {
                self.cut = true;
                break;
            };
            record.push(value, self.budget)?;
        }
        self.at = within;
        if self.at < end {
            record.records = self.records(end, depth.saturating_add(1))?;
        }
        Ok(record)
    }

    fn value(&mut self) -> Option<Value<'a>> {
        let [kind] = self.take()?;
        Some(match kind {
            b'C' | b'B' | b'Z' => {
                let [v] = self.take()?;
                Value::Integer((v as i8).into())
            }
            b'Y' => Value::Integer(i16::from_le_bytes(self.take()?).into()),
            b'I' => Value::Integer(i32::from_le_bytes(self.take()?).into()),
            b'L' => Value::Integer(i64::from_le_bytes(self.take()?)),
            b'F' => Value::Float(f32::from_le_bytes(self.take()?).into()),
            b'D' => Value::Float(f64::from_le_bytes(self.take()?)),
            b'S' | b'R' => {
                let length = self.u32()? as usize;
                Value::Text(Cow::Borrowed(self.slice(length)?))
            }
            b'f' | b'd' | b'l' | b'i' | b'b' | b'c' => {
                let (count, encoding, length) = (self.u32()?, self.u32()?, self.u32()? as usize);
                // Lengths of plain arrays are not always written.
                let size = match kind {
                    b'd' | b'l' => 8,
                    b'f' | b'i' => 4,
                    _ => 1,
                };
                let packed = encoding == 1;
                let length = if packed { length } else { (count as usize).checked_mul(size)? };
                Value::Array(Array { kind, count, packed, data: self.slice(length)? })
            }
            _ => return None,
        })
    }
}
