//! The text of a scene file, JSON or TOML, as values that know their lines.
//!
//! Only what is asked for is looked into, so that what is read over may be nested as deep as it likes.

use serde::Deserialize;
use serde::de::{Deserializer, MapAccess, Visitor};
use serde_json::value::RawValue;
use std::borrow::Cow;
use toml::de::DeValue;

/// A value of a scene file.
#[derive(Clone, Copy, Debug)]
pub(super) struct Node<'a> {
    file: &'a str,
    /// Byte offset of its beginning.
    at: usize,
    form: Form<'a>,
}

#[derive(Clone, Copy, Debug)]
enum Form<'a> {
    Json(&'a RawValue),
    Toml(&'a DeValue<'a>),
}

/// A key, and its value.
pub(super) type Entry<'a> = (Cow<'a, str>, Node<'a>);

impl<'a> Node<'a> {
    /// All of a JSON file.
    pub(super) fn json(file: &'a str) -> Result<Self, String> {
        let raw: &RawValue = serde_json::from_str(file).map_err(|e| e.to_string())?;
        Ok(Self::of_json(file, raw))
    }

    /// All of a TOML file.
    pub(super) fn toml(file: &'a str, table: &'a DeValue<'a>) -> Self {
        Self { file, at: 0, form: Form::Toml(table) }
    }

    fn of_json(file: &'a str, raw: &'a RawValue) -> Self {
        // It is a part of the file, whose place is the distance of both beginnings.
        let at = (raw.get().as_ptr() as usize).saturating_sub(file.as_ptr() as usize);
        Self { file, at, form: Form::Json(raw) }
    }

    /// The line that it begins on, from 1. Counted when it is asked for, which is for messages.
    pub(super) fn line(&self) -> usize {
        line(self.file, self.at)
    }

    /// True for JSON's `null`, which stands for a key that is not there.
    pub(super) fn is_null(&self) -> bool {
        matches!(self.form, Form::Json(raw) if raw.get() == "null")
    }

    /// The entries of a table, in the order of the file.
    pub(super) fn table(&self) -> Option<Vec<Entry<'a>>> {
        match self.form {
            Form::Json(raw) => {
                let Entries(entries) = serde_json::from_str(raw.get()).ok()?;
                let of =
                    |(key, raw): (String, &'a RawValue)| (Cow::Owned(key), Self::of_json(self.file, raw));
                Some(entries.into_iter().map(of).collect())
            }
            Form::Toml(value) => {
                let mut entries: Vec<_> = value.as_table()?.iter().collect();
                entries.sort_by_key(|(key, _)| key.span().start);
                let of = |(key, value): (&'a toml::Spanned<toml::de::DeString<'a>>, &'a toml::Spanned<_>)| {
                    let node =
                        Self { file: self.file, at: value.span().start, form: Form::Toml(value.get_ref()) };
                    (Cow::Borrowed(key.get_ref().as_ref()), node)
                };
                Some(entries.into_iter().map(of).collect())
            }
        }
    }

    /// The values of a list.
    pub(super) fn list(&self) -> Option<Vec<Self>> {
        match self.form {
            Form::Json(raw) => {
                let values: Vec<&'a RawValue> = serde_json::from_str(raw.get()).ok()?;
                Some(values.into_iter().map(|raw| Self::of_json(self.file, raw)).collect())
            }
            Form::Toml(value) => {
                let of = |value: &'a toml::Spanned<_>| Self {
                    file: self.file,
                    at: value.span().start,
                    form: Form::Toml(value.get_ref()),
                };
                Some(value.as_array()?.iter().map(of).collect())
            }
        }
    }

    /// Text.
    pub(super) fn text(&self) -> Option<Cow<'a, str>> {
        match self.form {
            Form::Json(raw) => serde_json::from_str(raw.get()).ok().map(Cow::Owned),
            Form::Toml(value) => value.as_str().map(Cow::Borrowed),
        }
    }

    /// True or false.
    pub(super) fn switch(&self) -> Option<bool> {
        match self.form {
            Form::Json(raw) => serde_json::from_str(raw.get()).ok(),
            Form::Toml(value) => value.as_bool(),
        }
    }

    /// A number that is finite.
    pub(super) fn number(&self) -> Option<f64> {
        let number = match self.form {
            Form::Json(raw) if raw.get().starts_with(|c: char| c == '-' || c.is_ascii_digit()) => {
                raw.get().parse().ok()
            }
            Form::Json(_) => None,
            Form::Toml(DeValue::Integer(v)) => {
                i64::from_str_radix(v.as_str(), v.radix()).ok().map(|v| v as f64)
            }
            Form::Toml(DeValue::Float(v)) => v.as_str().parse().ok(),
            Form::Toml(_) => None,
        };
        number.filter(|v: &f64| v.is_finite())
    }

    /// A whole number that is not negative.
    pub(super) fn whole(&self) -> Option<u64> {
        match self.form {
            Form::Json(raw) => raw.get().parse().ok(),
            Form::Toml(DeValue::Integer(v)) => u64::from_str_radix(v.as_str(), v.radix()).ok(),
            Form::Toml(_) => None,
        }
    }

    /// The value's text or type, for messages.
    pub(super) fn found(&self) -> String {
        if let Some(text) = self.text() {
            return format!("\"{}\"", short(&text));
        }
        match self.form {
            Form::Json(raw) => match self.list() {
                Some(list) => format!("a list of {}", list.len()),
                None if raw.get().starts_with('{') => "a table".to_owned(),
                None => short(raw.get()),
            },
            Form::Toml(DeValue::Integer(v)) => short(v.as_str()),
            Form::Toml(DeValue::Float(v)) => short(v.as_str()),
            Form::Toml(DeValue::Boolean(v)) => v.to_string(),
            Form::Toml(DeValue::Array(list)) => format!("a list of {}", list.len()),
            Form::Toml(DeValue::Table(_)) => "a table".to_owned(),
            Form::Toml(other) => format!("a {}", other.type_str()),
        }
    }
}

/// Excerpt of a file for messages: at most 80 characters.
pub(super) fn short(text: &str) -> String {
    let mut out: String = text.chars().take(80).map(|c| if c.is_control() { ' ' } else { c }).collect();
    if text.chars().nth(80).is_some() {
        out.push_str("...");
    }
    out
}

/// The line of a place, from 1.
pub(super) fn line(file: &str, at: usize) -> usize {
    1 + file.as_bytes().iter().take(at).filter(|&&b| b == b'\n').count()
}

/// Keys and values of a JSON object in their order, those that are given twice as well.
struct Entries<'a>(Vec<(String, &'a RawValue)>);

impl<'de> Deserialize<'de> for Entries<'de> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct InOrder;
        impl<'de> Visitor<'de> for InOrder {
            type Value = Entries<'de>;

            fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str("a table")
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Self::Value, A::Error> {
                let mut entries = Vec::new();
                while let Some(entry) = map.next_entry()? {
                    entries.push(entry);
                }
                Ok(Entries(entries))
            }
        }
        deserializer.deserialize_map(InOrder)
    }
}
