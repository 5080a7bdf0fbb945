//! Tensor files of the RGL: named arrays of numbers.
//!
//! Twelve bytes `tensor_file\0`, two of the version, a 32-bit count of fields; of each field the length of its name in 16 bits, the
//! name, its rank in 16 bits, its type in 8, its offset and the length along each dimension in 64. Little endian, the last
//! dimension fastest (<https://github.com/rgl-epfl/brdf-loader>).

use super::MeasuredError;

const MAGIC: &[u8] = b"tensor_file\0";

/// Most fields of a file; measured BRDFs have nine to eleven.
const FIELDS: u64 = 64;

/// Highest rank; spectra have five.
const RANK: u64 = 8;

/// Types that are read, by their numbers.
const UINT8: u8 = 1;
const FLOAT32: u8 = 10;

/// Sizes of the types 1 to 11: integers without and with sign of 8, 16, 32 and 64 bits, floats of 16, 32 and 64.
const SIZES: [u64; 11] = [1, 1, 2, 2, 4, 4, 8, 8, 2, 4, 8];

pub(super) fn is_tensor_file(bytes: &[u8]) -> bool {
    bytes.starts_with(MAGIC)
}

/// A field in the bytes of its file.
pub(super) struct Field<'a> {
    name: String,
    kind: u8,
    pub(super) shape: Vec<u64>,
    bytes: &'a [u8],
}

/// The fields of a file, each within it.
pub(super) struct Tensors<'a>(Vec<Field<'a>>);

/// Reads from the front of the header.
struct Cursor<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Cursor<'a> {
    fn take(&mut self, count: usize, what: impl FnOnce() -> String) -> Result<&'a [u8], MeasuredError> {
        // Counts are of 16 bits, and positions within the file.
        let end = self.at + count;
        let taken = self.bytes.get(self.at..end).ok_or_else(|| MeasuredError::Cut {
            what: what(),
            end: end as u64,
            length: self.bytes.len() as u64,
        })?;
        self.at = end;
        Ok(taken)
    }

    /// An integer of that many bytes.
    fn number(&mut self, bytes: usize, what: impl FnOnce() -> String) -> Result<u64, MeasuredError> {
        let taken = self.take(bytes, what)?;
        Ok(taken.iter().rev().fold(0, |all, byte| all << 8 | u64::from(*byte)))
    }
}

impl<'a> Tensors<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Result<Self, MeasuredError> {
        let mut cursor = Cursor { bytes, at: MAGIC.len() };
        let version = cursor.take(2, || "version".to_owned())?;
        if version != [1, 0] {
            return Err(MeasuredError::Version { found: [version[0], version[1]] });
        }
        let count = cursor.number(4, || "number of fields".to_owned())?;
        at_most("fields", count, FIELDS)?;
        let mut fields: Vec<Field<'_>> = Vec::new();
        for k in 0..count {
            let field = field(&mut cursor, k)?;
            if fields.iter().any(|other| other.name == field.name) {
                return Err(MeasuredError::Twice { field: field.name });
            }
            fields.push(field);
        }
        Ok(Self(fields))
    }

    pub(super) fn has(&self, name: &str) -> bool {
        self.0.iter().any(|field| field.name == name)
    }

    /// A field of single-precision numbers, all of them finite.
    pub(super) fn floats(&self, name: &'static str) -> Result<(&Field<'a>, Vec<f32>), MeasuredError> {
        let field = self.of_kind(name, FLOAT32, "10 (float32)")?;
        let four = field.bytes.as_chunks().0;
        let numbers: Vec<f32> = four.iter().map(|four| f32::from_le_bytes(*four)).collect();
        if let Some(index) = numbers.iter().position(|number| !number.is_finite()) {
            let value = f64::from(numbers[index]);
            let expected = "a finite number";
            return Err(MeasuredError::Number { what: name, index: index as u64, value, expected });
        }
        Ok((field, numbers))
    }

    /// A field of bytes.
    pub(super) fn bytes(&self, name: &'static str) -> Result<&'a [u8], MeasuredError> {
        Ok(self.of_kind(name, UINT8, "1 (uint8)")?.bytes)
    }

    fn of_kind(
        &self,
        name: &'static str,
        kind: u8,
        expected: &'static str,
    ) -> Result<&Field<'a>, MeasuredError> {
        let found = self.0.iter().find(|field| field.name == name);
        let field = found.ok_or(MeasuredError::Missing { field: name })?;
        if field.kind != kind {
            return Err(MeasuredError::Type { field: name, found: field.kind, expected });
        }
        Ok(field)
    }
}

/// The field at the cursor, whose number counts from 0.
fn field<'a>(cursor: &mut Cursor<'a>, k: u64) -> Result<Field<'a>, MeasuredError> {
    let header = || format!("header of field {k}");
    let length = cursor.number(2, header)? as usize;
    let name = plain(cursor.take(length, header)?);
    let rank = cursor.number(2, header)?;
    let kind = cursor.number(1, header)? as u8;
    let offset = cursor.number(8, header)?;
    at_most(&format!("dimensions of field '{name}'"), rank, RANK)?;
    let shape = (0..rank).map(|_| cursor.number(8, header)).collect::<Result<Vec<_>, _>>()?;
    // A type that is not known is told about where the field is read.
    let size = SIZES.get(usize::from(kind).wrapping_sub(1)).copied().unwrap_or(0);
    let bytes = shape.iter().fold(size, |all, n| all.saturating_mul(*n));
    let end = offset.saturating_add(bytes);
    let within = usize::try_from(offset).ok().zip(usize::try_from(end).ok());
    let bytes = within.and_then(|(from, to)| cursor.bytes.get(from..to)).ok_or_else(|| {
        MeasuredError::Cut { what: format!("field '{name}'"), end, length: cursor.bytes.len() as u64 }
    })?;
    Ok(Field { name, kind, shape, bytes })
}

fn at_most(what: &str, found: u64, limit: u64) -> Result<(), MeasuredError> {
    if found <= limit { Ok(()) } else { Err(MeasuredError::TooMany { what: what.to_owned(), found, limit }) }
}

/// Text for a line of a message: without control characters, and of 200 characters at most.
pub(super) fn plain(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).chars().map(|c| if c.is_control() { ' ' } else { c }).take(200).collect()
}
