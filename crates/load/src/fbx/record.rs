//! Records: the nested lists of values that both encodings of the format are made of.

use crate::LoadError;
use crate::budget::Budget;
use flate2::read::ZlibDecoder;
use overcoat_core::limits::Limits;
use std::borrow::Cow;
use std::io::Read as _;

pub(super) const FORMAT: &str = "FBX";

/// A value of a record.
#[derive(Clone, Debug)]
pub(super) enum Value<'a> {
    Integer(i64),
    Float(f64),
    /// A string, or bytes.
    Text(Cow<'a, [u8]>),
    /// Numbers as a binary file has them.
    Array(Array<'a>),
    /// Numbers of a text, or of an old binary file, which has them one by one.
    Numbers(Vec<f64>),
}

/// An array property (A. Gessler, C. Barton, *FBX binary file format specification*): elements of one type, plain or packed by
/// zlib.
#[derive(Clone, Copy, Debug)]
pub(super) struct Array<'a> {
    /// Letter of the type: `f`, `d`, `l`, `i`, `b` or `c`.
    pub(super) kind: u8,
    pub(super) count: u32,
    pub(super) packed: bool,
    pub(super) data: &'a [u8],
}

/// A name with values, and records within.
#[derive(Clone, Debug, Default)]
pub(super) struct Record<'a> {
    pub(super) name: Cow<'a, [u8]>,
    pub(super) values: Vec<Value<'a>>,
    pub(super) records: Vec<Self>,
}

/// A number of an array.
pub(super) trait Number: Copy {
    fn of_float(v: f64) -> Self;
    fn of_integer(v: i64) -> Self;
}

impl Number for f32 {
    fn of_float(v: f64) -> Self {
        v as f32
    }
    fn of_integer(v: i64) -> Self {
        v as f32
    }
}

impl Number for f64 {
    fn of_float(v: f64) -> Self {
        v
    }
    fn of_integer(v: i64) -> Self {
        v as f64
    }
}

impl Number for i32 {
    fn of_float(v: f64) -> Self {
        v as i32
    }
    fn of_integer(v: i64) -> Self {
        Self::try_from(v).unwrap_or(Self::MIN)
    }
}

impl Array<'_> {
    fn size(&self) -> usize {
        match self.kind {
            b'd' | b'l' => 8,
            b'f' | b'i' => 4,
            _ => 1,
        }
    }

    /// The numbers, as many of them as there are.
    fn read<T: Number>(&self, budget: &mut Budget) -> Result<Vec<T>, LoadError> {
        let what = || format!("{FORMAT}: an array of {} numbers", self.count);
        let bytes = u64::from(self.count).saturating_mul(self.size() as u64);
        Limits::check(what, bytes, budget.left(), "decoded_bytes")?;
        let mut unpacked = Vec::new();
        let raw = if self.packed {
            // Damaged data end early, and what uses the numbers says so.
            _ = ZlibDecoder::new(self.data).take(bytes).read_to_end(&mut unpacked);
            unpacked.as_slice()
        } else {
            self.data.get(..usize::try_from(bytes).unwrap_or(usize::MAX)).unwrap_or(self.data)
        };
        let count = raw.len().checked_div(self.size()).unwrap_or(0);
        budget.charge(what, count as u64, size_of::<T>() as u64)?;
        Ok(match self.kind {
            b'd' => raw.as_chunks().0.iter().map(|v| T::of_float(f64::from_le_bytes(*v))).collect(),
            b'f' => raw.as_chunks().0.iter().map(|v| T::of_float(f32::from_le_bytes(*v).into())).collect(),
            b'l' => raw.as_chunks().0.iter().map(|v| T::of_integer(i64::from_le_bytes(*v))).collect(),
            b'i' => raw.as_chunks().0.iter().map(|v| T::of_integer(i32::from_le_bytes(*v).into())).collect(),
            _ => raw.iter().map(|v| T::of_integer((*v).into())).collect(),
        })
    }
}

impl<'a> Record<'a> {
    /// The first record of a name in this one.
    pub(super) fn child(&self, name: &str) -> Option<&Self> {
        self.records.iter().find(|record| *record.name == *name.as_bytes())
    }

    pub(super) fn children<'r>(&'r self, name: &'r str) -> impl Iterator<Item = &'r Self> {
        self.records.iter().filter(move |record| *record.name == *name.as_bytes())
    }

    pub(super) fn text(&self, place: usize) -> Option<&[u8]> {
        match self.values.get(place)? {
            Value::Text(text) => Some(text),
            _ => None,
        }
    }

    pub(super) fn integer(&self, place: usize) -> Option<i64> {
        match self.values.get(place)? {
            Value::Integer(v) => Some(*v),
            Value::Float(v) => Some(*v as i64),
            _ => None,
        }
    }

    pub(super) fn float(&self, place: usize) -> Option<f64> {
        match self.values.get(place)? {
            Value::Integer(v) => Some(*v as f64),
            Value::Float(v) => Some(*v).filter(|v| v.is_finite()),
            _ => None,
        }
    }

    /// The text that a record of a name has first.
    pub(super) fn text_of(&self, name: &str) -> Option<&[u8]> {
        self.child(name)?.text(0)
    }

    /// All numbers of the record, be they in an array or one by one.
    pub(super) fn numbers<T: Number>(&self, budget: &mut Budget) -> Result<Vec<T>, LoadError> {
        let mut out = Vec::new();
        for value in &self.values {
            match value {
                Value::Array(array) => out.extend(array.read::<T>(budget)?),
                Value::Numbers(list) => {
                    let count = list.len() as u64;
                    budget.charge(|| format!("{FORMAT}: a list of numbers"), count, size_of::<T>() as u64)?;
                    out.extend(list.iter().map(|v| T::of_float(*v)));
                }
                Value::Integer(v) => out.push(T::of_integer(*v)),
                Value::Float(v) => out.push(T::of_float(*v)),
                Value::Text(_) => {}
            }
        }
        Ok(out)
    }

    /// The numbers of the first record of a name; none without it.
    pub(super) fn list<T: Number>(&self, name: &str, budget: &mut Budget) -> Result<Vec<T>, LoadError> {
        self.child(name).map_or(Ok(Vec::new()), |record| record.numbers(budget))
    }

    /// Adds a value. Many numbers become one list.
    pub(super) fn push(&mut self, value: Value<'a>, budget: &mut Budget) -> Result<(), LoadError> {
        let number = match value {
            Value::Integer(v) => Some(v as f64),
            Value::Float(v) => Some(v),
            _ => None,
        };
        if let (Some(number), Some(Value::Numbers(list))) = (number, self.values.last_mut()) {
            budget.charge(|| format!("{FORMAT}: a list of numbers"), 1, size_of::<f64>() as u64)?;
            list.push(number);
            return Ok(());
        }
        budget.charge(|| format!("{FORMAT}: a list of values"), 1, size_of::<Value<'_>>() as u64)?;
        self.values.push(value);
        if self.values.len() == ONE_BY_ONE && number.is_some() {
            let number = |value: &Value<'_>| match value {
                Value::Integer(v) => Some(*v as f64),
                Value::Float(v) => Some(*v),
                _ => None,
            };
            if let Some(list) = self.values.iter().map(number).collect() {
                self.values = vec![Value::Numbers(list)];
            }
        }
        Ok(())
    }
}

/// Numbers from which on a list has no place for numbers of records, which need all of their 64 bits.
const ONE_BY_ONE: usize = 16;

/// Records of the whole of a file.
pub(super) struct File<'a> {
    pub(super) version: u32,
    pub(super) root: Record<'a>,
    /// The file ends early, or has a record that does.
    pub(super) cut: bool,
    /// There are curves of animations, which are not read.
    pub(super) is_animated: bool,
}

/// True for records of a curve: from version 7 on, and before.
pub(super) fn is_animation(name: &[u8]) -> bool {
    matches!(name, b"AnimationCurve" | b"KeyCount")
}

/// Depth in the tree of the records within `Objects`.
const OBJECTS: u64 = 2;

/// False for records whose content has no effect: animation, above all, of which there may be much.
pub(super) fn is_read(name: &[u8], depth: u64) -> bool {
    match depth {
        1 => matches!(
            name,
            b"FBXHeaderExtension"
                | b"GlobalSettings"
                | b"Definitions"
                | b"Objects"
                | b"Connections"
                | b"Creator"
        ),
        OBJECTS => !matches!(
            name,
            b"AnimationCurve"
                | b"AnimationCurveNode"
                | b"AnimationLayer"
                | b"AnimationStack"
                | b"Pose"
                | b"Constraint"
        ),
        _ => true,
    }
}
