//! The encoding as text: `Name: value, value { records }`.

use super::record::{FORMAT, File, Record, Value, is_animation, is_read};
use crate::budget::Budget;
use crate::text::{double, integer, without_mark};
use crate::{Context, LoadError};
use overcoat_core::limits::Limits;
use std::borrow::Cow;

/// Bytes in which a text says what it is.
const HEAD: usize = 4096;

/// True if a text begins with a comment that names the format, or with its first record.
pub(super) fn is_one(bytes: &[u8]) -> bool {
    let text = without_mark(bytes).trim_ascii_start();
    let head = text.get(..HEAD).unwrap_or(text);
    let has = |word: &[u8]| head.windows(word.len()).any(|window| window == word);
    text.starts_with(b"; FBX") || (has(b"FBXHeaderExtension") && has(b"{"))
}

/// Reads the records of a text.
pub(super) fn read<'a>(
    bytes: &'a [u8],
    context: &Context<'_>,
    budget: &mut Budget,
) -> Result<File<'a>, LoadError> {
    let mut reader = Reader {
        rest: without_mark(bytes),
        budget,
        depth: context.limits.depth,
        cut: false,
        animated: false,
    };
    let records = reader.records(1)?;
    let root = Record { records, ..Record::default() };
    let header = root.child("FBXHeaderExtension").and_then(|header| header.child("FBXVersion"));
    let version = header.and_then(|record| record.integer(0)).unwrap_or(0);
    Ok(File {
        version: u32::try_from(version).unwrap_or(0),
        root,
        cut: reader.cut,
        is_animated: reader.animated,
    })
}

struct Reader<'a, 'b> {
    rest: &'a [u8],
    budget: &'b mut Budget,
    depth: u64,
    cut: bool,
    animated: bool,
}

impl<'a> Reader<'a, '_> {
    /// Passes over white space and comments; of a line only if `in_line`.
    fn skip(&mut self, in_line: bool) {
        while let Some((&first, rest)) = self.rest.split_first() {
            match first {
                b'\n' | b'\r' if in_line => return,
                b';' => {
                    let end = self.rest.iter().position(|b| matches!(b, b'\n' | b'\r'));
                    self.rest = end.and_then(|end| self.rest.get(end..)).unwrap_or_default();
                }
                _ if first.is_ascii_whitespace() => self.rest = rest,
                _ => return,
            }
        }
    }

    /// Takes a character, if it is the next.
    fn accept(&mut self, character: u8) -> bool {
        match self.rest.split_first() {
            Some((&first, rest)) if first == character => {
                self.rest = rest;
                true
            }
            _ => false,
        }
    }

    fn until(&mut self, ends: impl Fn(u8) -> bool) -> &'a [u8] {
        let end = self.rest.iter().position(|&b| ends(b)).unwrap_or(self.rest.len());
        let (word, rest) = self.rest.split_at_checked(end).unwrap_or_default();
        self.rest = rest;
        word
    }

    /// Reads records up to the brace that ends their list, or the end of the text.
    fn records(&mut self, depth: u64) -> Result<Vec<Record<'a>>, LoadError> {
        Limits::check(|| format!("{FORMAT}: the depth of records"), depth, self.depth, "depth")?;
        let mut records = Vec::new();
        loop {
            self.skip(false);
            if self.accept(b'}') {
                self.cut |= depth == 1;
                break;
            }
            if self.rest.is_empty() {
                self.cut |= depth > 1;
                break;
            }
            let name = self.until(|b| matches!(b, b':' | b'\n' | b'\r' | b'{' | b'}'));
            if !self.accept(b':') {
                // A word that is no record.
                self.cut = true;
                if name.is_empty() {
                    self.rest = self.rest.get(1..).unwrap_or_default();
                }
                continue;
            }
            let record = self.record(name.trim_ascii(), depth)?;
            self.animated |= is_animation(&record.name);
            if is_read(&record.name, depth) {
                records.push(record);
            }
        }
        Ok(records)
    }

    fn record(&mut self, name: &'a [u8], depth: u64) -> Result<Record<'a>, LoadError> {
        let size = size_of::<Record<'_>>() as u64;
        self.budget.charge(|| format!("{FORMAT}: the list of records"), 1, size)?;
        let mut record = Record { name: Cow::Borrowed(name), ..Record::default() };
        let mut is_list = false;
        self.skip(true);
        let ends_line = matches!(self.rest.first(), Some(b'\n' | b'\r') | None);
        self.skip(false);
        // Values may begin on the next line, where a name would be of letters.
        let begins = |b: &u8| match b {
            b'{' | b'}' => false,
            _ => !ends_line || b.is_ascii_digit() || matches!(b, b'-' | b'+' | b'.' | b'"' | b',' | b'*'),
        };
        if self.rest.first().is_some_and(begins) {
            loop {
                self.skip(false);
                match self.rest.first() {
                    Some(b',') => {}
                    Some(b'*') => {
                        is_list = true;
                        self.word();
                    }
                    Some(b'"') => {
                        let text = self.string();
                        record.push(Value::Text(text), self.budget)?;
                    }
                    Some(b'{' | b'}') | None => break,
                    Some(_) => {
                        let value = value_of(self.word());
                        record.push(value, self.budget)?;
                    }
                }
                // Commas stand behind values, or before those of the next line; long texts go on without.
                self.skip(false);
                if !self.accept(b',') && self.rest.first() != Some(&b'"') {
                    break;
                }
            }
        }
        self.skip(false);
        if self.accept(b'{') {
            record.records = self.records(depth.saturating_add(1))?;
            if is_list && let Some(first) = record.records.first_mut() {
                record.values.append(&mut first.values);
                record.records = Vec::new();
            }
        }
        Ok(record)
    }

    fn word(&mut self) -> &'a [u8] {
        let word =
            self.until(|b| b.is_ascii_whitespace() || matches!(b, b',' | b'{' | b'}' | b';' | b':' | b'"'));
        if word.is_empty() {
            // Something that begins no value.
            self.rest = self.rest.get(1..).unwrap_or_default();
        }
        word
    }

    fn string(&mut self) -> Cow<'a, [u8]> {
        self.rest = self.rest.get(1..).unwrap_or_default();
        let text = self.until(|b| b == b'"');
        self.cut |= !self.accept(b'"');
        if !text.contains(&b'&') {
            return Cow::Borrowed(text);
        }
        // Only quotes are written in another way.
        let (mut out, mut rest) = (Vec::new(), text);
        while let Some((&first, after)) = rest.split_first() {
            if let Some(after) = rest.strip_prefix(b"&quot;") {
                out.push(b'"');
                rest = after;
            } else {
                out.push(first);
                rest = after;
            }
        }
        Cow::Owned(out)
    }
}

/// A number, or a letter: `Y` and `T` are true.
fn value_of(word: &[u8]) -> Value<'_> {
    match word {
        b"Y" | b"T" => Value::Integer(1),
        b"N" | b"F" => Value::Integer(0),
        _ => match integer(word).map(Value::Integer).or_else(|| double(word).map(Value::Float)) {
            Some(value) => value,
            None => Value::Text(Cow::Borrowed(word)),
        },
    }
}
