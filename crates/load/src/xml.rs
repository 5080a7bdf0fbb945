//! A walk through the elements of an XML file, or of a part of one in an archive.
//!
//! Nothing is expanded and nothing referred to: a document type definition, in which entities could be defined, is
//! refused, or skipped where a format has them. Elements that nobody asks for are skipped with all that is in them.

use crate::LoadError;
use crate::budget::Budget;
use crate::text::{float, line_of, quoted};
use quick_xml::XmlVersion;
use quick_xml::events::{BytesStart, Event};
use quick_xml::reader::Reader;
use std::borrow::Cow;

/// Elements may nest this deep: 3MF's own go to about ten.
const DEEPEST: usize = 256;

/// The text of a part: UTF-8 or, with a byte order mark, UTF-16 (ECMA-376 part 2, 9.1.4). What is neither is replaced.
pub(crate) fn text_of<'a>(
    bytes: &'a [u8],
    part: &str,
    budget: &mut Budget,
) -> Result<Cow<'a, str>, LoadError> {
    let what = || format!("part {}", quoted(part.as_bytes()));
    let (units, from): (_, fn([u8; 2]) -> u16) = match bytes {
        [0xff, 0xfe, units @ ..] => (units, u16::from_le_bytes),
        [0xfe, 0xff, units @ ..] => (units, u16::from_be_bytes),
        _ => {
            let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
            return match std::str::from_utf8(bytes) {
                Ok(text) => Ok(Cow::Borrowed(text)),
                Err(_) => {
                    budget.charge(what, bytes.len() as u64, 3)?;
                    Ok(String::from_utf8_lossy(bytes))
                }
            };
        }
    };
    budget.charge(what, bytes.len() as u64, 2)?;
    let units = units.as_chunks().0.iter().map(|&unit| from(unit));
    Ok(char::decode_utf16(units).map(|c| c.unwrap_or(char::REPLACEMENT_CHARACTER)).collect())
}

/// An opening tag.
pub(crate) struct Tag<'a> {
    start: BytesStart<'a>,
}

impl Tag<'_> {
    /// Its name without the prefix.
    #[inline]
    pub(crate) fn name(&self) -> &str {
        self.start.name().local_name().into_inner()
    }

    /// The prefix of its name; empty without.
    #[inline]
    pub(crate) fn prefix(&self) -> &str {
        self.start.name().prefix().map_or("", |prefix| prefix.into_inner())
    }

    /// Calls `f` with the name (as it is written) and the value (as it is written) of each attribute.
    #[inline]
    pub(crate) fn raw_attributes(&self, mut f: impl FnMut(&str, &str)) -> Result<(), String> {
        // The check for equal names would take a time that grows with the square of their number.
        for attribute in self.start.attributes().with_checks(false) {
            let attribute = attribute.map_err(|error| error.to_string())?;
            f(attribute.key.into_inner(), &attribute.value);
        }
        Ok(())
    }

    /// Calls `f` with the name (as it is written) and the value of each attribute, with character references replaced.
    pub(crate) fn attributes(&self, mut f: impl FnMut(&str, Cow<'_, str>)) -> Result<(), String> {
        for attribute in self.start.attributes().with_checks(false) {
            let attribute = attribute.map_err(|error| error.to_string())?;
            let value = attribute.normalized_value(XmlVersion::Implicit1_0);
            f(attribute.key.into_inner(), value.unwrap_or_else(|_| attribute.value.clone()));
        }
        Ok(())
    }

    /// The value of an attribute by its name without prefix, with character references replaced. Of two the first.
    pub(crate) fn attribute(&self, name: &str) -> Option<String> {
        let mut attributes = self.start.attributes();
        let found = attributes
            .with_checks(false)
            .flatten()
            .find(|attribute| attribute.key.local_name().into_inner() == name)?;
        let value = found.normalized_value(XmlVersion::Implicit1_0);
        Some(value.map_or_else(|_| found.value.clone().into_owned(), Cow::into_owned))
    }

    /// The value of an attribute as a number of a resource or its place in a group.
    pub(crate) fn number(&self, name: &str) -> Option<u32> {
        index(&self.attribute(name)?)
    }

    /// The value of an attribute as a finite number.
    pub(crate) fn float(&self, name: &str) -> Option<f32> {
        float(self.attribute(name)?.trim_ascii().as_bytes()).filter(|v| v.is_finite())
    }
}

/// A number of a resource, or a place in a list: 0 to 2^31 - 1.
#[inline]
pub(crate) fn index(text: &str) -> Option<u32> {
    let text = text.trim_ascii().as_bytes();
    if text.is_empty() || text.len() > 10 {
        return None;
    }
    let mut value = 0_u64;
    for b in text {
        let digit = b.wrapping_sub(b'0');
        if digit > 9 {
            return None;
        }
        value = value.checked_mul(10)?.checked_add(digit.into())?;
    }
    u32::try_from(value).ok().filter(|&v| v <= i32::MAX as u32)
}

/// A part that is read from its beginning to its end.
pub(crate) struct Xml<'a> {
    /// Name of the format, in messages.
    format: &'static str,
    part: &'a str,
    text: &'a str,
    reader: Reader<&'a [u8]>,
    /// Elements that are open.
    depth: usize,
    /// The last tag has no content: `<a/>`.
    empty: bool,
    /// Definitions of a document's type are skipped.
    with_definitions: bool,
}

impl<'a> Xml<'a> {
    /// A walk through a part; one without a name is the whole of a file.
    pub(crate) fn new(format: &'static str, part: &'a str, text: &'a str) -> Self {
        let mut reader = Reader::from_str(text);
        // Nothing of the text is used that could contain one.
        reader.config_mut().allow_dangling_amp = true;
        Self { format, part, text, reader, depth: 0, empty: false, with_definitions: false }
    }

    /// The same for a format whose files have a document type definition: it is skipped, and none of its entities are known.
    pub(crate) fn with_definitions(self) -> Self {
        Self { with_definitions: true, ..self }
    }

    /// An error at the place that has been reached.
    pub(crate) fn error(&self, message: impl std::fmt::Display) -> LoadError {
        let at = usize::try_from(self.reader.buffer_position()).unwrap_or(usize::MAX);
        let text = self.text.as_bytes();
        let line = line_of(text, text.get(at..).unwrap_or_default());
        let part = match self.part {
            "" => String::new(),
            part => format!("part {}, ", quoted(part.as_bytes())),
        };
        LoadError::malformed(self.format, format!("{part}line {line}: {message}"))
    }

    fn event(&mut self) -> Result<Event<'a>, LoadError> {
        match self.reader.read_event() {
            Ok(Event::DocType(_)) if !self.with_definitions => {
                Err(self.error("document type definitions are not allowed"))
            }
            Ok(Event::Start(tag)) => {
                self.depth = self.depth.saturating_add(1);
                self.empty = false;
                if self.depth > DEEPEST {
                    return Err(self.error(format!("elements nest deeper than {DEEPEST}")));
                }
                Ok(Event::Start(tag))
            }
            Ok(Event::Empty(tag)) => {
                self.empty = true;
                Ok(Event::Empty(tag))
            }
            Ok(Event::End(tag)) => {
                self.depth = self.depth.saturating_sub(1);
                Ok(Event::End(tag))
            }
            Ok(event) => Ok(event),
            Err(error) => Err(self.error(error)),
        }
    }

    /// Calls `f` with the outermost element. What follows it is not read.
    pub(crate) fn root(
        &mut self,
        f: impl FnOnce(&mut Self, &Tag<'a>) -> Result<(), LoadError>,
    ) -> Result<(), LoadError> {
        loop {
            match self.event()? {
                Event::Start(start) | Event::Empty(start) => return f(self, &Tag { start }),
                Event::Eof => return Err(self.error("there is no element")),
                _ => {}
            }
        }
    }

    /// Calls `f` with each element directly within the one whose tag was read last. It may call this in turn; what it
    /// does not look at is skipped.
    #[inline]
    pub(crate) fn children(
        &mut self,
        mut f: impl FnMut(&mut Self, &Tag<'a>) -> Result<(), LoadError>,
    ) -> Result<(), LoadError> {
        if self.empty {
            return Ok(());
        }
        let level = self.depth;
        loop {
            match self.event()? {
                Event::Start(start) => {
                    f(self, &Tag { start })?;
                    while self.depth > level {
                        if matches!(self.event()?, Event::Eof) {
                            return Err(self.ends_early());
                        }
                    }
                }
                Event::Empty(start) => f(self, &Tag { start })?,
                Event::End(_) => return Ok(()),
                Event::Eof => return Err(self.ends_early()),
                _ => {}
            }
        }
    }

    /// Skips the element whose tag was read last, and returns its text with its tags.
    pub(crate) fn skip(&mut self) -> Result<&'a str, LoadError> {
        let at = |xml: &Self| usize::try_from(xml.reader.buffer_position()).unwrap_or(usize::MAX);
        let text = self.text;
        let start = text.get(..at(self)).and_then(|before| before.rfind('<')).unwrap_or_default();
        self.children(|_, _| Ok(()))?;
        Ok(text.get(start..at(self)).unwrap_or_default())
    }

    /// The text directly within the element whose tag was read last, up to its first child.
    pub(crate) fn content(&mut self) -> Result<String, LoadError> {
        let mut content = String::new();
        if self.empty {
            return Ok(content);
        }
        loop {
            match self.event()? {
                Event::Text(text) => content.push_str(&text.into_inner()),
                Event::CData(text) => content.push_str(&text.into_inner()),
                Event::Start(_) | Event::End(_) | Event::Empty(_) => return Ok(content),
                Event::Eof => return Err(self.ends_early()),
                _ => {}
            }
        }
    }

    /// All text within the element whose tag was read last, that of the elements in it too.
    pub(crate) fn all_text(&mut self) -> Result<String, LoadError> {
        let mut content = String::new();
        if self.empty {
            return Ok(content);
        }
        let level = self.depth;
        while self.depth >= level {
            match self.event()? {
                Event::Text(text) => content.push_str(&text.into_inner()),
                Event::CData(text) => content.push_str(&text.into_inner()),
                Event::Eof => return Err(self.ends_early()),
                _ => {}
            }
        }
        Ok(content)
    }

    fn ends_early(&self) -> LoadError {
        self.error("the text ends within an element")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use overcoat_core::limits::Limits;

    fn names(text: &str) -> Result<Vec<String>, String> {
        let mut found = Vec::new();
        let mut xml = Xml::new("3MF", "a.xml", text);
        let walked = xml.root(|xml, root| {
            found.push(root.name().to_owned());
            xml.children(|xml, tag| {
                found.push(format!("{}|{}", tag.prefix(), tag.name()));
                if tag.name() == "in" {
                    xml.children(|_, tag| {
                        found.push(tag.attribute("k").unwrap_or_default());
                        Ok(())
                    })?;
                }
                Ok(())
            })
        });
        walked.map(|()| found).map_err(|error| error.to_string())
    }

    #[test]
    fn elements_are_walked_and_the_rest_is_skipped() {
        let text = "<?xml version='1.0'?><!-- <x> --><r xmlns='u'> text &amp; &other;<a><b><in/></b></a>\
                    <p:in q='1'><x n:k='a&lt;&#66;>'><deep/></x><y k=\"2\"/></p:in><in/><c/></r><after";
        assert_eq!(names(text).unwrap(), ["r", "|a", "p|in", "a<B>", "2", "|in", "|c"]);
    }

    #[test]
    fn damage_and_definitions_are_errors_with_a_line() {
        for (text, message) in [
            ("", "line 1: there is no element"),
            ("<r>\n<a>", "line 2: the text ends within an element"),
            ("<r>\n<a></b></r>", "line 2"),
            ("<!DOCTYPE r [<!ENTITY a \"aaaa\">]><r/>", "document type definitions are not allowed"),
        ] {
            let error = names(text).unwrap_err();
            assert!(error.contains(message) && error.starts_with("3MF: part 'a.xml'"), "{error}");
        }
        let deep = format!("<r>{}", "<a>".repeat(100_000));
        assert!(names(&deep).unwrap_err().contains("nest deeper than 256"));
    }

    #[test]
    fn text_is_of_two_encodings() {
        let mut budget = Budget::new(&Limits::default());
        let mut text = |bytes: &[u8]| text_of(bytes, "p", &mut budget).unwrap().into_owned();
        assert_eq!(text(b"\xef\xbb\xbf<a/>"), "<a/>");
        assert_eq!(text(b"\xff\xfe<\0a\0/\0>\0!"), "<a/>");
        assert_eq!(text(b"\xfe\xff\0<\0a\xd8\0\0>"), "<a\u{fffd}>");
        assert_eq!(text(b"a\xffb"), "a\u{fffd}b");
    }
}
