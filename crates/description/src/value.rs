//! Values of a scene file with the keys that they were given to, for messages that name line and key.

use super::tree::{Node, short};
use overcoat_load::Warning;
use std::cell::RefCell;
use std::fmt::Display;

/// A value with the key that it was given to.
pub(super) struct Value<'a> {
    /// With those of the tables around it: `camera.eye`. Empty for the file itself.
    key: String,
    pub(super) node: Node<'a>,
    pub(super) warnings: &'a RefCell<Vec<Warning>>,
}

impl<'a> Value<'a> {
    /// The whole file.
    pub(super) fn file(node: Node<'a>, warnings: &'a RefCell<Vec<Warning>>) -> Self {
        Self { key: String::new(), node, warnings }
    }

    /// The value of a key of this table.
    pub(super) fn within(&self, key: &str, node: Node<'a>) -> Self {
        let key = match self.key.as_str() {
            "" => short(key),
            outer => format!("{outer}.{}", short(key)),
        };
        Self { key, node, warnings: self.warnings }
    }

    /// Another value of the same key: an item of a list.
    pub(super) fn with(&self, node: Node<'a>) -> Self {
        Self { key: self.key.clone(), node, warnings: self.warnings }
    }

    /// A message about it.
    pub(super) fn message(&self, what: impl Display) -> String {
        match self.key.as_str() {
            "" => format!("line {}: {what}", self.node.line()),
            key => format!("line {}: {key}: {what}", self.node.line()),
        }
    }

    /// The message of a value that is not what it should be.
    pub(super) fn expected(&self, what: impl Display) -> String {
        self.message(format_args!("expected {what}, found {}", self.node.found()))
    }

    /// Calls `f` for each value of a list.
    pub(super) fn each(
        &self,
        expected: &str,
        mut f: impl FnMut(&Value<'a>) -> Result<(), String>,
    ) -> Result<(), String> {
        let list = self.node.list().ok_or_else(|| self.expected(expected))?;
        for (k, node) in list.into_iter().enumerate() {
            f(&Value { key: format!("{} {k}", self.key), node, warnings: self.warnings })?;
        }
        Ok(())
    }

    pub(super) fn text(&self, expected: &str) -> Result<String, String> {
        self.node.text().map(|text| text.into_owned()).ok_or_else(|| self.expected(expected))
    }

    /// Text that is spelt as an argument of the command line is.
    pub(super) fn parsed<T>(
        &self,
        expected: &str,
        parse: impl Fn(&str) -> Result<T, String>,
    ) -> Result<T, String> {
        let text = self.text(expected)?;
        parse(&text).map_err(|reason| self.message(format_args!("'{}': {reason}", short(&text))))
    }
}
