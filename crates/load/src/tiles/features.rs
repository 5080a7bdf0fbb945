//! Feature tables: values of a tile and of its points or instances, as JSON with a binary part.

use super::FORMAT;
use crate::budget::Budget;
use crate::text::quoted;
use crate::{Context, LoadError};
use overcoat_scene::MAX_COORDINATE;
use serde_json::{Map, Value};

/// Bytes that a value takes as it is kept, for each byte of its text.
const KEPT: u64 = 40;

/// A feature table.
pub(super) struct Features<'a> {
    values: Map<String, Value>,
    binary: &'a [u8],
}

impl<'a> Features<'a> {
    /// Reads a table; one without text has nothing in it.
    pub(super) fn read([text, binary]: [&'a [u8]; 2], context: &Context<'_>) -> Result<Self, LoadError> {
        // Tables are padded by blanks, and by zeros where writers are careless.
        let end = text.iter().rposition(|&b| b != 0).map_or(0, |last| last.saturating_add(1));
        let text = text.get(..end).unwrap_or_default();
        let mut values = Map::new();
        if !text.trim_ascii().is_empty() {
            Budget::new(context.limits).charge(
                || format!("{FORMAT}: the feature table"),
                text.len() as u64,
                KEPT,
            )?;
            values = serde_json::from_slice(text).map_err(|error| {
                LoadError::malformed(FORMAT, format!("the feature table is no JSON object: {error}"))
            })?;
        }
        Ok(Self { values, binary })
    }

    /// The value itself.
    pub(super) fn value(&self, name: &str) -> Option<&Value> {
        self.values.get(name)
    }

    /// The binary part.
    pub(super) fn binary(&self) -> &'a [u8] {
        self.binary
    }

    /// A whole number that must be there.
    pub(super) fn count(&self, name: &str) -> Result<usize, LoadError> {
        let number = match self.numbers::<1>(name)? {
            // In the binary part it is an integer.
            Some(_) if self.place(name)?.is_some() => self
                .rows(name, 4, 1)?
                .and_then(|rows| rows.first_chunk())
                .map(|bytes| u64::from(u32::from_le_bytes(*bytes))),
            _ => self.value(name).and_then(Value::as_u64),
        };
        let missing = || LoadError::malformed(FORMAT, format!("the feature table has no {name}"));
        number.and_then(|count| usize::try_from(count).ok()).ok_or_else(missing)
    }

    /// Numbers of the whole tile, from the text or from the binary part.
    pub(super) fn numbers<const N: usize>(&self, name: &str) -> Result<Option<[f64; N]>, LoadError> {
        let numbers: Vec<f64> = match self.value(name) {
            None => return Ok(None),
            Some(Value::Number(number)) => number.as_f64().into_iter().collect(),
            Some(Value::Array(list)) => list.iter().filter_map(Value::as_f64).collect(),
            Some(_) => {
                let size = N.saturating_mul(4);
                let bytes = self.rows(name, size, 1)?.unwrap_or_default();
                bytes.as_chunks().0.iter().map(|&bytes| f32::from_le_bytes(bytes).into()).collect()
            }
        };
        let is_usable = |numbers: &[f64; N]| numbers.iter().all(|v| v.abs() <= MAX_COORDINATE.into());
        match <&[f64; N]>::try_from(numbers.as_slice()).ok().filter(|numbers| is_usable(numbers)) {
            Some(numbers) => Ok(Some(*numbers)),
            None => {
                let name = quoted(name.as_bytes());
                Err(LoadError::malformed(FORMAT, format!("{name} is not of {N} numbers up to 1e15")))
            }
        }
    }

    /// Place of a value in the binary part; `None` if there is no such value.
    fn place(&self, name: &str) -> Result<Option<usize>, LoadError> {
        let Some(value) = self.value(name) else { return Ok(None) };
        let Some(offset) = value.get("byteOffset") else { return Ok(None) };
        let place = offset.as_u64().and_then(|offset| usize::try_from(offset).ok());
        let wrong = || LoadError::malformed(FORMAT, format!("{name} has a byteOffset that is none"));
        place.ok_or_else(wrong).map(Some)
    }

    /// Rows of so many bytes in the binary part; `None` if there is no such value.
    pub(super) fn rows(&self, name: &str, size: usize, count: usize) -> Result<Option<&'a [u8]>, LoadError> {
        let Some(place) = self.place(name)? else { return Ok(None) };
        let bytes = size.checked_mul(count).and_then(|length| self.binary.get(place..)?.get(..length));
        match bytes {
            Some(bytes) => Ok(Some(bytes)),
            None => {
                let message = format!("{name} of {count} rows is not within the feature table");
                Err(LoadError::malformed(FORMAT, message))
            }
        }
    }

    /// Rows of three floats.
    pub(super) fn triples(&self, name: &str, count: usize) -> Result<Option<Vec<[f32; 3]>>, LoadError> {
        let rows = self.rows(name, 12, count)?;
        Ok(rows.map(|rows| {
            let (rows, _) = rows.as_chunks::<12>();
            rows.iter().map(floats).collect()
        }))
    }

    /// Positions of rows: as they are, or as shares of a box.
    pub(super) fn positions(&self, count: usize) -> Result<Option<Vec<[f32; 3]>>, LoadError> {
        if let Some(positions) = self.triples("POSITION", count)? {
            return Ok(Some(positions));
        }
        let Some(rows) = self.rows("POSITION_QUANTIZED", 6, count)? else { return Ok(None) };
        let offset = self.numbers::<3>("QUANTIZED_VOLUME_OFFSET")?;
        let scale = self.numbers::<3>("QUANTIZED_VOLUME_SCALE")?;
        let (Some(offset), Some(scale)) = (offset, scale) else {
            let message = "POSITION_QUANTIZED without QUANTIZED_VOLUME_OFFSET and _SCALE";
            return Err(LoadError::malformed(FORMAT, message));
        };
        let (rows, _) = rows.as_chunks::<6>();
        let position = |row: &[u8; 6]| {
            let mut position = [0.0; 3];
            let parts = row.as_chunks().0.iter().zip(scale.iter().zip(&offset));
            for (slot, (&code, (scale, offset))) in position.iter_mut().zip(parts) {
                *slot = (f64::from(u16::from_le_bytes(code)) / 65535.0 * scale + offset) as f32;
            }
            position
        };
        Ok(Some(rows.iter().map(position).collect()))
    }
}

fn floats(row: &[u8; 12]) -> [f32; 3] {
    let mut values = [0.0; 3];
    for (slot, bytes) in values.iter_mut().zip(row.as_chunks().0) {
        *slot = f32::from_le_bytes(*bytes);
    }
    values
}

/// Unit vector of a place on an unfolded octahedron, from -1 to 1 (Q. Meyer et al., *On Floating-Point Normal Vectors*, 2010).
pub(super) fn unfolded([u, v]: [f32; 2]) -> [f32; 3] {
    let z = 1.0 - u.abs() - v.abs();
    let fold = |a: f32, b: f32| (1.0 - b.abs()) * if a < 0.0 { -1.0 } else { 1.0 };
    let [x, y] = if z < 0.0 { [fold(u, v), fold(v, u)] } else { [u, v] };
    let length = (x * x + y * y + z * z).sqrt();
    [x, y, z].map(|c| c / length)
}
