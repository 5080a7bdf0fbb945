//! Values of Crate files: in the eight bytes that stand for them, or where these point to.
//!
//! Source: OpenUSD `pxr/usd/sdf/crateFile.h` (`ValueRep`), `crateDataTypes.h`, and `crateFile.cpp` for compressed arrays.

use super::FORMAT;
use super::crate_file::File;
use super::layer::{ListOp, Reference, Value};
use super::lz4;
use crate::LoadError;
use overcoat_core::math::half::half_to_f32;
use std::collections::BTreeMap;

/// Numbers of types that are read.
pub(super) mod kind {
    pub(in crate::usd) const BOOL: u8 = 1;
    pub(in crate::usd) const UCHAR: u8 = 2;
    pub(in crate::usd) const INT: u8 = 3;
    pub(in crate::usd) const UINT: u8 = 4;
    pub(in crate::usd) const INT64: u8 = 5;
    pub(in crate::usd) const UINT64: u8 = 6;
    pub(in crate::usd) const HALF: u8 = 7;
    pub(in crate::usd) const FLOAT: u8 = 8;
    pub(in crate::usd) const DOUBLE: u8 = 9;
    pub(in crate::usd) const STRING: u8 = 10;
    pub(in crate::usd) const TOKEN: u8 = 11;
    pub(in crate::usd) const ASSET: u8 = 12;
    pub(in crate::usd) const PATH_LIST_OP: u8 = 34;
    pub(in crate::usd) const REFERENCE_LIST_OP: u8 = 35;
    pub(in crate::usd) const PATHS: u8 = 40;
    pub(in crate::usd) const TOKENS: u8 = 41;
    pub(in crate::usd) const SELECTIONS: u8 = 45;
    pub(in crate::usd) const TIME_SAMPLES: u8 = 46;
    pub(in crate::usd) const PAYLOAD: u8 = 47;
    pub(in crate::usd) const DOUBLES: u8 = 48;
    pub(in crate::usd) const STRINGS: u8 = 50;
    pub(in crate::usd) const BLOCK: u8 = 51;
    pub(in crate::usd) const PAYLOAD_LIST_OP: u8 = 55;
    pub(in crate::usd) const TIME_CODE: u8 = 56;
}

/// Arrays of fewer numbers are not compressed.
const COMPRESSED: u64 = 16;

/// A value in the table of fields.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rep(pub(super) u64);

impl Rep {
    pub(super) fn kind(self) -> u8 {
        (self.0 >> 48) as u8
    }

    pub(super) fn payload(self) -> u64 {
        self.0 & ((1 << 48) - 1)
    }

    fn is_array(self) -> bool {
        self.0 >> 63 & 1 == 1
    }

    fn is_inlined(self) -> bool {
        self.0 >> 62 & 1 == 1
    }

    fn is_compressed(self) -> bool {
        self.0 >> 61 & 1 == 1
    }
}

/// Bytes from a place in a file on.
#[derive(Clone, Copy)]
pub(super) struct Bytes<'a> {
    whole: &'a [u8],
    at: u64,
}

impl<'a> Bytes<'a> {
    pub(super) fn new(whole: &'a [u8], at: u64) -> Self {
        Self { whole, at }
    }

    pub(super) fn take(&mut self, count: u64) -> Option<&'a [u8]> {
        let end = self.at.checked_add(count)?;
        let taken = self.whole.get(usize::try_from(self.at).ok()?..usize::try_from(end).ok()?)?;
        self.at = end;
        Some(taken)
    }

    fn chunk<const N: usize>(&mut self) -> Option<[u8; N]> {
        self.take(N as u64)?.first_chunk().copied()
    }

    pub(super) fn u8(&mut self) -> Option<u8> {
        self.chunk().map(u8::from_le_bytes)
    }

    pub(super) fn u32(&mut self) -> Option<u32> {
        self.chunk().map(u32::from_le_bytes)
    }

    pub(super) fn u64(&mut self) -> Option<u64> {
        self.chunk().map(u64::from_le_bytes)
    }

    /// Goes to where an offset from here points.
    fn jump(&mut self) -> Option<()> {
        let start = self.at;
        let offset = self.u64()?.cast_signed();
        self.at = start.checked_add_signed(offset)?;
        Some(())
    }
}

/// Storage of numbers.
#[derive(Clone, Copy, PartialEq)]
enum Store {
    Byte,
    Int,
    Long,
    Half,
    Float,
    Double,
}

impl Store {
    fn size(self) -> u64 {
        match self {
            Self::Byte => 1,
            Self::Half => 2,
            Self::Int | Self::Float => 4,
            Self::Long | Self::Double => 8,
        }
    }
}

/// Storage and count of the numbers of one element.
fn numbers_of(kind: u8) -> Option<(Store, u64)> {
    // Vectors of 2, 3 and 4 elements, each as double, float, half and int.
    let vector = |k: u8| match k % 4 {
        0 => Store::Double,
        1 => Store::Float,
        2 => Store::Half,
        _ => Store::Int,
    };
    Some(match kind {
        kind::BOOL | kind::UCHAR => (Store::Byte, 1),
        kind::INT | kind::UINT => (Store::Int, 1),
        kind::INT64 | kind::UINT64 => (Store::Long, 1),
        kind::HALF => (Store::Half, 1),
        kind::FLOAT => (Store::Float, 1),
        kind::DOUBLE | kind::TIME_CODE => (Store::Double, 1),
        13 => (Store::Double, 4),
        14 => (Store::Double, 9),
        15 => (Store::Double, 16),
        16 => (Store::Double, 4),
        17 => (Store::Float, 4),
        18 => (Store::Half, 4),
        19..=22 => (vector(kind.wrapping_sub(19)), 2),
        23..=26 => (vector(kind.wrapping_sub(23)), 3),
        27..=30 => (vector(kind.wrapping_sub(27)), 4),
        _ => return None,
    })
}

fn decode(store: Store, bytes: &[u8]) -> Value {
    // The narrowing saturates.
    let long = |&b: &[u8; 8]| i64::from_le_bytes(b).clamp(i32::MIN.into(), i32::MAX.into()) as i32;
    match store {
        Store::Byte => Value::Ints(bytes.iter().map(|&b| b.into()).collect()),
        Store::Int => Value::Ints(bytes.as_chunks().0.iter().map(|&b| i32::from_le_bytes(b)).collect()),
        Store::Long => Value::Ints(bytes.as_chunks().0.iter().map(long).collect()),
        Store::Half => {
            Value::Floats(bytes.as_chunks().0.iter().map(|&b| half_to_f32(u16::from_le_bytes(b))).collect())
        }
        Store::Float => Value::Floats(bytes.as_chunks().0.iter().map(|&b| f32::from_le_bytes(b)).collect()),
        Store::Double => Value::Doubles(bytes.as_chunks().0.iter().map(|&b| f64::from_le_bytes(b)).collect()),
    }
}

/// A value in the payload itself.
fn inlined(kind: u8, store: Store, count: u64, payload: u64) -> Value {
    let word = payload as u32;
    // Components of vectors and diagonals of matrices, where these are whole numbers of a byte.
    let byte = |k: u64| f64::from((payload >> k.saturating_mul(8)) as i8);
    let mut out = match store {
        Store::Byte | Store::Int | Store::Long => Value::Ints(Vec::new()),
        Store::Half | Store::Float => Value::Floats(Vec::new()),
        Store::Double => Value::Doubles(Vec::new()),
    };
    match (kind, count) {
        (13..=15, _) => {
            let side = if count == 4 {
                2
            } else if count == 9 {
                3
            } else {
                4
            };
            for (row, column) in (0..side).flat_map(|row| (0..side).map(move |column| (row, column))) {
                out.push_number(if row == column { byte(row) } else { 0.0 });
            }
        }
        (_, 1) => match store {
            Store::Half => out.push_number(half_to_f32(word as u16).into()),
            Store::Float | Store::Double => out.push_number(f32::from_bits(word).into()),
            Store::Byte => out.push_number((word as u8).into()),
            _ => out.push_number(word.cast_signed().into()),
        },
        _ => (0..count).for_each(|k| out.push_number(byte(k))),
    }
    out
}

impl<'a> File<'a, '_> {
    /// Grants memory for values.
    fn grant(&mut self, count: u64, size: u64) -> Result<(), LoadError> {
        Ok(self.budget.charge(|| format!("{FORMAT}: values"), count, size)?)
    }

    pub(super) fn read_value(&mut self, rep: Rep) -> Result<Value, LoadError> {
        let bad = || self.bad_value(rep);
        let payload = rep.payload();
        let kind = rep.kind();
        if let Some((store, count)) = numbers_of(kind) {
            if rep.is_array() {
                return self.array(rep, store, count);
            }
            if rep.is_inlined() {
                return Ok(inlined(kind, store, count, payload));
            }
            let size = count.saturating_mul(store.size());
            return Ok(decode(store, self.at(payload).take(size).ok_or_else(bad)?));
        }
        match kind {
            kind::BLOCK => Ok(Value::Block),
            kind::STRING | kind::TOKEN | kind::ASSET if rep.is_array() => self.texts(rep, false),
            kind::STRING | kind::TOKEN | kind::ASSET => {
                let word = payload as u32;
                let found = if kind == kind::STRING { self.string(word) } else { self.token(word) };
                let text = found.ok_or_else(bad)?.to_owned();
                self.grant(text.len() as u64, 1)?;
                Ok(Value::Texts(vec![text]))
            }
            kind::TOKENS | kind::STRINGS => self.texts(rep, true),
            kind::DOUBLES => {
                let mut at = self.at(payload);
                let count = at.u64().ok_or_else(bad)?;
                let bytes = at.take(count.saturating_mul(8)).ok_or_else(bad)?;
                self.grant(count, 8)?;
                Ok(decode(Store::Double, bytes))
            }
            // Types of no interest.
            _ => Ok(Value::Block),
        }
    }

    /// The count of an array, and where its elements are.
    fn count(&self, rep: Rep, is_vector: bool) -> Option<(u64, Bytes<'a>)> {
        let mut at = self.at(rep.payload());
        if is_vector {
            return Some((at.u64()?, at));
        }
        if self.version < [0, 5, 0] {
            // Number of dimensions.
            at.u32()?;
        }
        let count = if self.version < [0, 7, 0] { at.u32()?.into() } else { at.u64()? };
        Some((count, at))
    }

    fn texts(&mut self, rep: Rep, is_vector: bool) -> Result<Value, LoadError> {
        if rep.payload() == 0 && !is_vector {
            return Ok(Value::Texts(Vec::new()));
        }
        let (count, mut at) = self.count(rep, is_vector).ok_or_else(|| self.bad_value(rep))?;
        let bytes = at.take(count.saturating_mul(4)).ok_or_else(|| self.bad_value(rep))?;
        let mut out = Vec::new();
        let mut size = 0_u64;
        for &word in bytes.as_chunks().0 {
            let index = u32::from_le_bytes(word);
            let is_string = matches!(rep.kind(), kind::STRING | kind::STRINGS);
            let text = if is_string { self.string(index) } else { self.token(index) };
            let text = text.ok_or_else(|| self.bad_value(rep))?.to_owned();
            size = size.saturating_add(24).saturating_add(text.len() as u64);
            if size > 1 << 16 {
                self.grant(std::mem::take(&mut size), 1)?;
            }
            out.push(text);
        }
        self.grant(size, 1)?;
        Ok(Value::Texts(out))
    }

    /// An array of numbers, `width` of them in each element.
    fn array(&mut self, rep: Rep, store: Store, width: u64) -> Result<Value, LoadError> {
        if rep.payload() == 0 {
            return Ok(decode(store, &[]));
        }
        let bad = self.bad_value(rep);
        let Some((count, mut at)) = self.count(rep, false) else { return Err(bad) };
        let is_compressed = rep.is_compressed() && count >= COMPRESSED && width == 1;
        if !is_compressed {
            let size = count.saturating_mul(width).saturating_mul(store.size());
            let Some(bytes) = at.take(size) else { return Err(bad) };
            self.grant(count.saturating_mul(width), store.size().max(4))?;
            return Ok(decode(store, bytes));
        }
        let what = "an array";
        match store {
            Store::Int => {
                let ints = self.integers(&mut at, count, what)?;
                Ok(Value::Ints(ints.into_iter().map(u32::cast_signed).collect()))
            }
            Store::Long => {
                let Some(bytes) = at.u64().and_then(|size| at.take(size)) else { return Err(bad) };
                self.grant(count, 32)?;
                let count = usize::try_from(count).unwrap_or(usize::MAX);
                let Some(found) = lz4::long_integers(bytes, count) else { return Err(bad) };
                let narrow = |v: i64| v.clamp(i32::MIN.into(), i32::MAX.into()) as i32;
                Ok(Value::Ints(found.into_iter().map(narrow).collect()))
            }
            _ => self.packed_floats(at, rep, store, count),
        }
    }

    /// Whole numbers, or a table with indices.
    fn packed_floats(
        &mut self,
        mut at: Bytes<'a>,
        rep: Rep,
        store: Store,
        count: u64,
    ) -> Result<Value, LoadError> {
        let bad = self.bad_value(rep);
        let what = "an array";
        let mut out = decode(store, &[]);
        match at.u8() {
            Some(b'i') => {
                let ints = self.integers(&mut at, count, what)?;
                self.grant(count, store.size().max(4))?;
                ints.into_iter().for_each(|v| out.push_number(v.cast_signed().into()));
            }
            Some(b't') => {
                let Some(size) = at.u32() else { return Err(bad) };
                let Some(bytes) = at.take(u64::from(size).saturating_mul(store.size())) else {
                    return Err(bad);
                };
                self.grant(size.into(), 8)?;
                let table = decode(store, bytes);
                let table = table.doubles();
                let indices = self.integers(&mut at, count, what)?;
                self.grant(count, store.size().max(4))?;
                for index in indices {
                    let Some(&value) = table.get(index as usize) else { return Err(bad) };
                    out.push_number(value);
                }
            }
            _ => return Err(bad),
        }
        Ok(out)
    }

    /// The first of samples over time, and their number.
    pub(super) fn samples(&self, rep: Rep) -> Option<(Rep, u64)> {
        let mut at = self.at(rep.payload());
        // Times, and then values, lie where offsets in front of them point.
        at.jump()?;
        at.u64()?;
        at.jump()?;
        let count = at.u64()?;
        let first = Rep(at.u64()?);
        (count > 0 && first.kind() != kind::TIME_SAMPLES).then_some((first, count))
    }

    pub(super) fn selections(&mut self, rep: Rep) -> Result<BTreeMap<String, String>, LoadError> {
        let mut out = BTreeMap::new();
        if rep.kind() != kind::SELECTIONS {
            return Ok(out);
        }
        let mut at = self.at(rep.payload());
        let count = at.u64().ok_or_else(|| self.bad_value(rep))?;
        for _ in 0..count {
            let (Some(set), Some(chosen)) = (at.u32(), at.u32()) else { return Err(self.bad_value(rep)) };
            if let (Some(set), Some(chosen)) = (self.string(set), self.string(chosen)) {
                let (set, chosen) = (set.to_owned(), chosen.to_owned());
                self.grant((set.len().saturating_add(chosen.len()) as u64).saturating_add(64), 1)?;
                out.insert(set, chosen);
            }
        }
        Ok(out)
    }

    /// Lists of a list operation, each under its keyword.
    fn list_op<T: Clone + Ord>(
        &mut self,
        rep: Rep,
        mut item: impl FnMut(&mut Self, &mut Bytes<'a>) -> Result<T, LoadError>,
    ) -> Result<ListOp<T>, LoadError> {
        let mut at = self.at(rep.payload());
        let bits = at.u8().ok_or_else(|| self.bad_value(rep))?;
        let mut op = ListOp::default();
        if bits & 1 == 1 {
            op.explicit = Some(Vec::new());
        }
        for (bit, keyword) in
            [(1, ""), (2, "add"), (5, "prepend"), (6, "append"), (3, "delete"), (4, "reorder")]
        {
            if bits >> bit & 1 == 0 {
                continue;
            }
            let count = at.u64().ok_or_else(|| self.bad_value(rep))?;
            let mut items = Vec::new();
            for _ in 0..count {
                self.grant(64, 1)?;
                items.push(item(self, &mut at)?);
            }
            op.add(keyword, items);
        }
        Ok(op)
    }

    pub(super) fn paths_op(&mut self, rep: Rep) -> Result<ListOp<String>, LoadError> {
        let bad = self.bad_value(rep);
        let mut bad = Some(bad);
        let mut path = |file: &mut Self, at: &mut Bytes<'a>| match at.u32() {
            Some(index) => file.path(index),
            None => Err(bad.take().unwrap_or_else(|| super::crate_file::damaged("a list"))),
        };
        match rep.kind() {
            kind::PATH_LIST_OP => self.list_op(rep, path),
            kind::PATHS => {
                let mut at = self.at(rep.payload());
                let count = at.u64().ok_or_else(|| self.bad_value(rep))?;
                let mut items = Vec::new();
                for _ in 0..count {
                    items.push(path(self, &mut at)?);
                }
                Ok(ListOp { explicit: Some(items), ..ListOp::default() })
            }
            _ => Ok(ListOp::default()),
        }
    }

    /// References, or payloads, which have no dictionary and in old files no offset.
    pub(super) fn references(&mut self, rep: Rep) -> Result<ListOp<Reference>, LoadError> {
        match rep.kind() {
            kind::REFERENCE_LIST_OP => self.list_op(rep, |file, at| {
                let found = file.reference(rep, at, true)?;
                let entries = at.u64().ok_or_else(|| file.bad_value(rep))?;
                for _ in 0..entries {
                    let after = at.u32().and_then(|_| {
                        at.jump()?;
                        at.u64()
                    });
                    after.ok_or_else(|| file.bad_value(rep))?;
                }
                Ok(found)
            }),
            kind::PAYLOAD_LIST_OP => {
                let with_offset = self.version >= [0, 8, 0];
                self.list_op(rep, |file, at| file.reference(rep, at, with_offset))
            }
            kind::PAYLOAD => {
                let mut at = self.at(rep.payload());
                let found = self.reference(rep, &mut at, false)?;
                Ok(ListOp { explicit: Some(vec![found]), ..ListOp::default() })
            }
            _ => Ok(ListOp::default()),
        }
    }

    fn reference(&mut self, rep: Rep, at: &mut Bytes<'a>, with_offset: bool) -> Result<Reference, LoadError> {
        let (Some(asset), Some(path)) = (at.u32(), at.u32()) else { return Err(self.bad_value(rep)) };
        let asset = self.string(asset).unwrap_or_default().to_owned();
        self.grant(asset.len() as u64, 1)?;
        // No path stands for the default prim.
        let path = if self.is_path(path) { self.path(path)? } else { String::new() };
        if with_offset && at.take(16).is_none() {
            return Err(self.bad_value(rep));
        }
        Ok(Reference { asset, path })
    }
}
