//! Nodes of VRML and X3D as both syntaxes have them.

use crate::text::{double, float};
use std::borrow::Cow;
use std::collections::BTreeMap;

/// Value of a field that is no node.
#[derive(Clone, Debug)]
pub(super) enum Value {
    /// As the attribute of an element has it.
    Text(String),
    Numbers(Vec<f64>),
    Strings(Vec<String>),
    Flag(bool),
}

/// A node.
#[derive(Debug, Default)]
pub(super) struct Node {
    /// Name of its type.
    pub(super) kind: String,
    pub(super) fields: BTreeMap<String, Value>,
    /// Nodes in its fields, in their order, with the name of the field; empty where the syntax leaves it out.
    pub(super) children: Vec<(String, usize)>,
    /// Folder of its file, relative to the model, by its place in the list of folders.
    pub(super) folder: usize,
}

impl Value {
    /// Bytes that it takes.
    pub(super) fn bytes(&self) -> u64 {
        let bytes = match self {
            Self::Text(text) => text.len(),
            Self::Numbers(numbers) => numbers.len().saturating_mul(8),
            Self::Strings(strings) => strings.iter().map(|text| text.len().saturating_add(24)).sum(),
            Self::Flag(_) => 0,
        };
        (bytes as u64).saturating_add(64)
    }
}

/// Words of a text of numbers.
fn words(text: &str) -> impl Iterator<Item = &str> {
    text.split(|c: char| c.is_ascii_whitespace() || c == ',').filter(|word| !word.is_empty())
}

/// A number as VRML writes it, also in base 16.
pub(super) fn number(word: &str) -> Option<f64> {
    match word.strip_prefix("0x").or_else(|| word.strip_prefix("0X")) {
        Some(digits) => u32::from_str_radix(digits, 16).ok().map(f64::from),
        None => double(word.as_bytes()),
    }
}

impl Node {
    /// Numbers of a field; none without it. Words in their place are 0.
    pub(super) fn numbers(&self, name: &str) -> Cow<'_, [f64]> {
        match self.fields.get(name) {
            Some(Value::Numbers(numbers)) => Cow::Borrowed(numbers),
            Some(Value::Text(text)) => {
                Cow::Owned(words(text).map(|word| number(word).unwrap_or(0.0)).collect())
            }
            _ => Cow::Borrowed(&[]),
        }
    }

    /// Rows of numbers in single precision; those that are not complete are left out.
    pub(super) fn rows<const N: usize>(&self, name: &str) -> Vec<[f32; N]> {
        match self.fields.get(name) {
            Some(Value::Text(text)) => {
                let numbers: Vec<f32> =
                    words(text).map(|word| float(word.as_bytes()).unwrap_or(f32::NAN)).collect();
                numbers.as_chunks().0.to_vec()
            }
            _ => self.numbers(name).as_chunks().0.iter().map(|row| row.map(|v| v as f32)).collect(),
        }
    }

    /// Whole numbers of a field; -1 for what is none.
    pub(super) fn integers(&self, name: &str) -> Vec<i64> {
        let whole = |v: &f64| if v.abs() < 1e15 { *v as i64 } else { -1 };
        self.numbers(name).iter().map(whole).collect()
    }

    /// The numbers of a field that has so many; otherwise those that it has by default.
    pub(super) fn fixed<const N: usize>(&self, name: &str, otherwise: [f64; N]) -> [f64; N] {
        let numbers = self.numbers(name);
        match numbers.first_chunk::<N>() {
            Some(found) if found.iter().all(|v| v.is_finite()) => *found,
            _ => otherwise,
        }
    }

    /// The one number of a field.
    pub(super) fn number(&self, name: &str, otherwise: f64) -> f64 {
        let [number] = self.fixed(name, [otherwise]);
        number
    }

    /// A field that is true or false.
    pub(super) fn flag(&self, name: &str, otherwise: bool) -> bool {
        match self.fields.get(name) {
            Some(Value::Flag(flag)) => *flag,
            Some(Value::Text(text)) => match text.trim() {
                text if text.eq_ignore_ascii_case("true") => true,
                text if text.eq_ignore_ascii_case("false") => false,
                _ => otherwise,
            },
            _ => otherwise,
        }
    }

    /// Texts of a field.
    pub(super) fn strings(&self, name: &str) -> Vec<String> {
        match self.fields.get(name) {
            Some(Value::Strings(strings)) => strings.clone(),
            Some(Value::Text(text)) => strings_of(text),
            _ => Vec::new(),
        }
    }

    /// Nodes of a field with one of these names, or in none by name.
    pub(super) fn within<'a>(&'a self, names: &'a [&str]) -> impl Iterator<Item = usize> + 'a {
        let is_one = |name: &str| name.is_empty() || names.contains(&name);
        self.children.iter().filter(move |(name, _)| is_one(name)).map(|(_, node)| *node)
    }
}

/// Texts of an attribute: in quotes, or a single one without.
pub(super) fn strings_of(text: &str) -> Vec<String> {
    let text = text.trim();
    if !text.starts_with('"') {
        return if text.is_empty() { Vec::new() } else { vec![text.to_owned()] };
    }
    let (mut found, mut current, mut escaped) = (Vec::new(), None::<String>, false);
    for c in text.chars() {
        match (&mut current, c) {
            (Some(word), _) if escaped => {
                word.push(c);
                escaped = false;
            }
            (Some(_), '\\') => escaped = true,
            (Some(_), '"') => found.extend(current.take()),
            (Some(word), _) => word.push(c),
            (None, '"') => current = Some(String::new()),
            (None, _) => {}
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_of_attributes_are_in_quotes_or_alone() {
        assert_eq!(strings_of("\"a b.png\" \"c\\\"d\""), ["a b.png", "c\"d"]);
        assert_eq!(strings_of(" a.png "), ["a.png"]);
        assert!(strings_of("").is_empty());
        assert_eq!(number("0xff"), Some(255.0));
    }
}
