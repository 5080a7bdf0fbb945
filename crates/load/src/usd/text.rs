//! The text syntax, usda: a tolerant parser of bounded depth.
//!
//! Source: *USDA File Format* (openusd.org) and OpenUSD `pxr/usd/sdf/textFileFormat`. Statements that mean nothing to a picture are
//! passed over; what cannot be read at all ends the file there, with a warning.

use super::FORMAT;
use super::layer::{Layer, Prim, Property, Reference, Specifier, Value, absolute, check_depth, joined};
use crate::budget::Budget;
use crate::text::{line_of, without_mark};
use crate::warnings::Warnings;
use crate::{Context, LoadError};
use std::rc::Rc;

/// Bytes that a prim or property takes beside its values.
const SPEC: u64 = 256;

/// Reads a layer.
pub(super) fn read(
    bytes: &[u8],
    context: &Context<'_>,
    budget: &mut Budget,
    warnings: &mut Warnings,
) -> Result<Layer, LoadError> {
    let bytes = without_mark(bytes);
    let mut parser = Parser { rest: bytes, context, budget };
    let mut layer = Layer::default();
    match parser.layer(&mut layer) {
        Ok(()) => {}
        Err(Stop::Error(error)) => return Err(error),
        Err(Stop::Syntax) => {
            let line = line_of(bytes, parser.rest);
            if layer.root.children.is_empty() {
                return Err(LoadError::malformed(FORMAT, format!("line {line} cannot be read")));
            }
            warnings
                .add(|| format!("{FORMAT}: line {line} cannot be read; what is complete before it is drawn"));
        }
    }
    Ok(layer)
}

/// Reasons to stop.
enum Stop {
    Syntax,
    Error(LoadError),
}

impl<E: Into<LoadError>> From<E> for Stop {
    fn from(error: E) -> Self {
        Self::Error(error.into())
    }
}

type Parsed<T> = Result<T, Stop>;

struct Parser<'a, 'c> {
    rest: &'a [u8],
    context: &'c Context<'c>,
    budget: &'c mut Budget,
}

/// True for a byte of a name, with its namespaces.
fn is_word(b: u8) -> bool {
    b.is_ascii_alphanumeric() || matches!(b, b'_' | b':' | b'.' | b'-' | b'+') || b >= 0x80
}

impl<'a> Parser<'a, '_> {
    /// The next byte that is neither white space nor part of a comment.
    fn peek(&mut self) -> Option<u8> {
        loop {
            self.rest = self.rest.trim_ascii_start();
            match self.rest {
                [b'#', ..] => self.skip_line(),
                [b'/', b'*', after @ ..] => {
                    let end = after.windows(2).position(|two| two == b"*/")?;
                    self.rest = after.get(end.saturating_add(2)..)?;
                }
                [b'/', b'/', ..] => self.skip_line(),
                _ => return self.rest.first().copied(),
            }
        }
    }

    fn skip_line(&mut self) {
        let end = self.rest.iter().position(|&b| b == b'\n').unwrap_or(self.rest.len());
        self.rest = self.rest.get(end..).unwrap_or_default();
    }

    fn step(&mut self) {
        self.rest = self.rest.get(1..).unwrap_or_default();
    }

    /// Takes a byte, if it is next.
    fn take(&mut self, byte: u8) -> bool {
        let found = self.peek() == Some(byte);
        if found {
            self.step();
        }
        found
    }

    fn expect(&mut self, byte: u8) -> Parsed<()> {
        if self.take(byte) { Ok(()) } else { Err(Stop::Syntax) }
    }

    /// A run of letters, digits and what joins names; empty if there is none.
    fn word(&mut self) -> &'a str {
        _ = self.peek();
        let end = self.rest.iter().position(|&b| !is_word(b)).unwrap_or(self.rest.len());
        let (word, rest) = self.rest.split_at_checked(end).unwrap_or_default();
        self.rest = rest;
        std::str::from_utf8(word).unwrap_or_default()
    }

    /// Passes over what is left of a list of separators.
    fn separators(&mut self) {
        while matches!(self.peek(), Some(b';' | b',')) {
            self.step();
        }
    }

    /// Takes the bytes in front of an ending, and passes over that.
    fn until(&mut self, end: &[u8]) -> Parsed<&'a [u8]> {
        let at = self.rest.windows(end.len()).position(|window| window == end).ok_or(Stop::Syntax)?;
        let (text, rest) = self.rest.split_at_checked(at).ok_or(Stop::Syntax)?;
        self.rest = rest.get(end.len()..).unwrap_or_default();
        Ok(text)
    }

    /// A string in any of its quotes.
    fn string(&mut self) -> Parsed<String> {
        let quote = self.peek().filter(|b| matches!(b, b'"' | b'\'')).ok_or(Stop::Syntax)?;
        let long = [quote; 3];
        let (mut rest, end) = match self.rest.strip_prefix(&long) {
            Some(rest) => (rest, &long[..]),
            None => (self.rest.get(1..).unwrap_or_default(), &long[..1]),
        };
        let mut out = Vec::new();
        loop {
            if let Some(after) = rest.strip_prefix(end) {
                self.rest = after;
                break;
            }
            let (&byte, after) = rest.split_first().ok_or(Stop::Syntax)?;
            rest = after;
            match (byte, rest.split_first()) {
                (b'\\', Some((&escaped, after))) => {
                    rest = after;
                    out.push(match escaped {
                        b'n' => b'\n',
                        b't' => b'\t',
                        b'r' => b'\r',
                        other => other,
                    });
                }
                (b'\n', _) if end.len() == 1 => return Err(Stop::Syntax),
                (byte, _) => out.push(byte),
            }
        }
        self.budget.charge(|| format!("{FORMAT}: strings"), out.len() as u64, 1)?;
        Ok(String::from_utf8_lossy(&out).into_owned())
    }

    /// A path of a file between signs `@`.
    fn asset(&mut self) -> Parsed<String> {
        self.expect(b'@')?;
        let text = match self.rest.strip_prefix(b"@@") {
            Some(rest) => {
                self.rest = rest;
                self.until(b"@@@")?
            }
            None => self.until(b"@")?,
        };
        Ok(String::from_utf8_lossy(text).into_owned())
    }

    /// A path in angle brackets, as it is written.
    fn path(&mut self) -> Parsed<String> {
        self.expect(b'<')?;
        Ok(String::from_utf8_lossy(self.until(b">")?).trim().to_owned())
    }

    fn depth(&self, depth: u64) -> Parsed<()> {
        Ok(check_depth("prims or values", depth, self.context.limits)?)
    }

    /// Counts a prim or property.
    fn spec(&mut self, name: &str) -> Parsed<()> {
        let bytes = SPEC.saturating_add(name.len() as u64);
        self.budget.charge(|| format!("{FORMAT}: prims and properties"), bytes, 1)?;
        Ok(())
    }

    /// Reads a value into `out`: flat, whatever it is nested in.
    fn value(&mut self, out: &mut Value, depth: u64) -> Parsed<()> {
        self.depth(depth)?;
        match self.peek().ok_or(Stop::Syntax)? {
            open @ (b'(' | b'[') => {
                self.step();
                let close = if open == b'(' { b')' } else { b']' };
                while !self.take(close) {
                    self.value(out, depth.saturating_add(1))?;
                    self.separators();
                }
            }
            b'"' | b'\'' => {
                let text = self.string()?;
                self.text(out, text)?;
            }
            b'@' => {
                let text = self.asset()?;
                self.text(out, text)?;
            }
            b'<' => {
                let text = self.path()?;
                self.text(out, text)?;
            }
            b'{' => {
                self.step();
                self.dictionary(depth)?;
            }
            _ => self.scalar(out)?,
        }
        Ok(())
    }

    /// A number or a word.
    fn scalar(&mut self, out: &mut Value) -> Parsed<()> {
        let word = self.word();
        let number = match word {
            "" => return Err(Stop::Syntax),
            "None" => {
                *out = Value::Block;
                return Ok(());
            }
            "true" | "True" => 1.0,
            "false" | "False" => 0.0,
            word => match word.parse() {
                Ok(number) => number,
                Err(_) => return self.text(out, word.to_owned()),
            },
        };
        if matches!(out, Value::Ints(list) if list.len() == list.capacity())
            || matches!(out, Value::Floats(list) if list.len() == list.capacity())
            || matches!(out, Value::Doubles(list) if list.len() == list.capacity())
        {
            // Room is granted before the list grows.
            let size = out.size().max(32);
            self.budget.charge(|| format!("{FORMAT}: values"), size, 1)?;
        }
        out.push_number(number);
        Ok(())
    }

    fn text(&mut self, out: &mut Value, text: String) -> Parsed<()> {
        self.budget.charge(|| format!("{FORMAT}: values"), (text.len() as u64).saturating_add(24), 1)?;
        if let Value::Texts(list) = out {
            list.push(text);
        }
        Ok(())
    }

    /// Passes over a dictionary whose brace is read.
    fn dictionary(&mut self, depth: u64) -> Parsed<()> {
        while !self.take(b'}') {
            // Type and name, which may be a string.
            while !self.take(b'=') {
                match self.peek().ok_or(Stop::Syntax)? {
                    b'"' | b'\'' => drop(self.string()?),
                    b'[' | b']' => self.step(),
                    _ if self.word().is_empty() => return Err(Stop::Syntax),
                    _ => {}
                }
            }
            self.value(&mut Value::Block, depth.saturating_add(1))?;
            self.separators();
        }
        Ok(())
    }

    fn layer(&mut self, layer: &mut Layer) -> Parsed<()> {
        if self.rest.starts_with(b"#") {
            self.skip_line();
        }
        if self.take(b'(') {
            self.metadata(|parser, _, key| {
                match key {
                    "defaultPrim" => layer.default_prim = Some(parser.string()?),
                    "upAxis" => layer.up = Some(parser.string()?),
                    "metersPerUnit" => {
                        let mut value = Value::Doubles(Vec::new());
                        parser.value(&mut value, 0)?;
                        layer.meters_per_unit = value.doubles().first().copied();
                    }
                    "subLayers" => {
                        let found = parser.references("")?;
                        layer.sublayers = found.into_iter().map(|reference| reference.asset).collect();
                    }
                    _ => return Ok(false),
                }
                Ok(true)
            })?;
        }
        let mut root = Prim::default();
        let mut read = Ok(());
        while read.is_ok() && self.peek().is_some() {
            read = self.statement(&mut root, "", 0);
        }
        layer.root = Rc::new(root);
        read
    }

    /// Reads metadata whose parenthesis is read; `known` says whether it has read the value of a key.
    fn metadata(&mut self, mut known: impl FnMut(&mut Self, &str, &str) -> Parsed<bool>) -> Parsed<()> {
        loop {
            self.separators();
            match self.peek().ok_or(Stop::Syntax)? {
                b')' => {
                    self.step();
                    return Ok(());
                }
                b'"' | b'\'' => drop(self.string()?),
                _ => {
                    let mut keyword = "";
                    let mut key = self.word();
                    if matches!(key, "prepend" | "append" | "add" | "delete" | "reorder") {
                        (keyword, key) = (key, self.word());
                    }
                    self.expect(b'=')?;
                    if !known(self, keyword, key)? {
                        self.value(&mut Value::Block, 0)?;
                    }
                }
            }
        }
    }

    /// `@file@</path>` or either, or a list of them. Offsets in time have no effect.
    fn references(&mut self, prim: &str) -> Parsed<Vec<Reference>> {
        let mut out = Vec::new();
        let is_list = self.take(b'[');
        loop {
            match self.peek().ok_or(Stop::Syntax)? {
                b'@' | b'<' => {
                    let asset = if self.peek() == Some(b'@') { self.asset()? } else { String::new() };
                    let path = if self.peek() == Some(b'<') { self.path()? } else { String::new() };
                    let size = (asset.len().saturating_add(path.len()) as u64).saturating_add(64);
                    self.budget.charge(|| format!("{FORMAT}: references"), size, 1)?;
                    out.push(Reference { asset, path: absolute(prim, &path) });
                    if self.take(b'(') {
                        self.metadata(|_, _, _| Ok(false))?;
                    }
                }
                b']' if is_list => {
                    self.step();
                    break;
                }
                _ if self.word() == "None" => {}
                _ => return Err(Stop::Syntax),
            }
            if !is_list {
                break;
            }
            self.separators();
        }
        Ok(out)
    }

    fn paths(&mut self, prim: &str) -> Parsed<Vec<String>> {
        Ok(self.references(prim)?.into_iter().map(|reference| reference.path).collect())
    }

    /// A prim, a property or a set of variants in the body of a prim.
    fn statement(&mut self, prim: &mut Prim, path: &str, depth: u64) -> Parsed<()> {
        self.depth(depth)?;
        let before = self.rest;
        match self.word() {
            "def" => self.prim(prim, path, Specifier::Def, depth),
            "over" => self.prim(prim, path, Specifier::Over, depth),
            "class" => self.prim(prim, path, Specifier::Class, depth),
            "variantSet" => self.variants(prim, path, depth),
            "reorder" => {
                while !self.take(b'=') {
                    if self.word().is_empty() {
                        return Err(Stop::Syntax);
                    }
                }
                self.value(&mut Value::Block, depth)
            }
            "" if self.peek() == Some(b';') => {
                self.separators();
                Ok(())
            }
            "" => Err(Stop::Syntax),
            _ => {
                self.rest = before;
                self.property(prim, path, depth)
            }
        }
    }

    fn prim(&mut self, parent: &mut Prim, path: &str, specifier: Specifier, depth: u64) -> Parsed<()> {
        let type_name = self.word().to_owned();
        let name = self.string()?;
        self.spec(&name)?;
        let mut prim = Prim { specifier, type_name, ..Prim::default() };
        let path = joined(path, &name);
        prim.name = name;
        let read = self.inside(&mut prim, &path, depth);
        // Complete prims count where the rest cannot be read.
        if matches!(read, Ok(()) | Err(Stop::Syntax)) {
            parent.children.push(Rc::new(prim));
        }
        read
    }

    /// Metadata and body.
    fn inside(&mut self, prim: &mut Prim, path: &str, depth: u64) -> Parsed<()> {
        if self.take(b'(') {
            self.metadata(|parser, keyword, key| {
                match key {
                    "references" => prim.references.add(keyword, parser.references(path)?),
                    "payload" => prim.payloads.add(keyword, parser.references(path)?),
                    "inherits" => prim.inherits.add(keyword, parser.paths(path)?),
                    "specializes" => prim.specializes.add(keyword, parser.paths(path)?),
                    "active" => prim.active = Some(!matches!(parser.word(), "false" | "0")),
                    "variants" => {
                        parser.expect(b'{')?;
                        while !parser.take(b'}') {
                            _ = parser.word();
                            let set = match parser.peek() {
                                Some(b'"' | b'\'') => parser.string()?,
                                _ => parser.word().to_owned(),
                            };
                            parser.expect(b'=')?;
                            let chosen = parser.string()?;
                            prim.selections.insert(set, chosen);
                            parser.separators();
                        }
                    }
                    _ => return Ok(false),
                }
                Ok(true)
            })?;
        }
        self.expect(b'{')?;
        while !self.take(b'}') {
            self.statement(prim, path, depth.saturating_add(1))?;
        }
        Ok(())
    }

    fn variants(&mut self, prim: &mut Prim, path: &str, depth: u64) -> Parsed<()> {
        let set = self.string()?;
        self.expect(b'=')?;
        self.expect(b'{')?;
        while !self.take(b'}') {
            let name = self.string()?;
            self.spec(&name)?;
            let mut variant = Prim { name: name.clone(), ..Prim::default() };
            self.inside(&mut variant, path, depth.saturating_add(1))?;
            prim.variants.entry(set.clone()).or_default().insert(name, Rc::new(variant));
        }
        Ok(())
    }

    fn property(&mut self, prim: &mut Prim, path: &str, depth: u64) -> Parsed<()> {
        let mut keyword = "";
        let mut kind = self.word();
        while matches!(
            kind,
            "custom" | "uniform" | "varying" | "config" | "prepend" | "append" | "add" | "delete" | "reorder"
        ) {
            if !matches!(kind, "custom" | "uniform" | "varying" | "config") {
                keyword = kind;
            }
            kind = self.word();
        }
        if kind.is_empty() {
            return Err(Stop::Syntax);
        }
        if self.take(b'[') {
            self.expect(b']')?;
        }
        let full = self.word();
        let (name, suffix) = full.split_once('.').unwrap_or((full, ""));
        if name.is_empty() {
            return Err(Stop::Syntax);
        }
        self.spec(name)?;
        let property = prim.properties.entry(name.to_owned()).or_default();
        if self.take(b'=') {
            if kind == "rel" || suffix == "connect" {
                let targets = self.paths(path)?;
                property.targets.add(keyword, targets);
            } else if suffix == "timeSamples" {
                self.samples(property, kind, depth)?;
            } else if suffix.is_empty() {
                let mut value = Value::of_type(kind);
                self.value(&mut value, depth)?;
                real_part_last(kind, &mut value);
                if property.samples == 0 {
                    property.value = Some(Rc::new(value));
                }
            } else {
                self.value(&mut Value::Block, depth)?;
            }
        }
        if self.take(b'(') {
            self.metadata(|parser, _, key| {
                match key {
                    "interpolation" => property.interpolation = Some(parser.string()?),
                    "colorSpace" if matches!(parser.peek(), Some(b'"' | b'\'')) => {
                        property.color_space = Some(parser.string()?)
                    }
                    _ => return Ok(false),
                }
                Ok(true)
            })?;
        }
        Ok(())
    }

    /// Samples over time, the first of which is drawn.
    fn samples(&mut self, property: &mut Property, kind: &str, depth: u64) -> Parsed<()> {
        self.expect(b'{')?;
        while !self.take(b'}') {
            self.until(b":")?;
            let mut value = if property.samples == 0 { Value::of_type(kind) } else { Value::Block };
            self.value(&mut value, depth)?;
            real_part_last(kind, &mut value);
            if property.samples == 0 {
                property.value = Some(Rc::new(value));
            }
            property.samples = property.samples.saturating_add(1);
            self.separators();
        }
        Ok(())
    }
}

/// Quaternions have their real part first in texts, and last in binary files.
fn real_part_last(kind: &str, value: &mut Value) {
    if !kind.starts_with("quat") {
        return;
    }
    match value {
        Value::Floats(list) => list.as_chunks_mut::<4>().0.iter_mut().for_each(|quat| quat.rotate_left(1)),
        Value::Doubles(list) => list.as_chunks_mut::<4>().0.iter_mut().for_each(|quat| quat.rotate_left(1)),
        _ => {}
    }
}
