//! A MaterialX document as a tree of elements.

use super::FORMAT;
use crate::LoadError;
use crate::text::float;
use crate::xml::{Tag, Xml};
use std::collections::BTreeMap;

/// Most elements of a document; nodes of the largest public materials are a few thousand.
const MOST_ELEMENTS: usize = 1 << 16;

/// An element with its attributes as they are written.
#[derive(Debug, Default)]
pub(super) struct Element {
    /// Category: `input`, `nodegraph`, `open_pbr_surface`.
    pub(super) category: String,
    attributes: BTreeMap<String, String>,
    pub(super) children: Vec<Element>,
    /// `fileprefix` of this element and of all around it.
    prefix: String,
    /// `colorspace` of this element or of the nearest around it.
    color_space: String,
}

impl Element {
    /// Reads a document.
    pub(super) fn document(text: &str) -> Result<Self, LoadError> {
        let mut xml = Xml::new(FORMAT, "", text);
        let mut root = Self::default();
        let mut count = 0;
        xml.root(|xml, tag| {
            if tag.name() != "materialx" {
                return Err(xml.error("the outermost element is not materialx"));
            }
            root = Self::read(xml, tag, &Self::default(), &mut count)?;
            Ok(())
        })?;
        Ok(root)
    }

    fn read<'a>(
        xml: &mut Xml<'a>,
        tag: &Tag<'a>,
        around: &Self,
        count: &mut usize,
    ) -> Result<Self, LoadError> {
        *count = count.saturating_add(1);
        if *count > MOST_ELEMENTS {
            return Err(xml.error(format!("more than {MOST_ELEMENTS} elements")));
        }
        let mut element = Self { category: tag.name().to_owned(), ..Self::default() };
        let mut names: Vec<String> = Vec::new();
        tag.raw_attributes(|name, _| names.push(name.to_owned())).map_err(|error| xml.error(error))?;
        for name in names {
            if let Some(value) = tag.attribute(&name) {
                element.attributes.entry(name).or_insert(value);
            }
        }
        element.prefix = around.prefix.clone() + element.attribute("fileprefix");
        element.color_space = match element.attribute("colorspace") {
            "" => around.color_space.clone(),
            own => own.to_owned(),
        };
        xml.children(|xml, tag| {
            let child = Self::read(xml, tag, &element, count)?;
            element.children.push(child);
            Ok(())
        })?;
        Ok(element)
    }

    /// An attribute; empty without.
    pub(super) fn attribute(&self, name: &str) -> &str {
        self.attributes.get(name).map_or("", String::as_str)
    }

    pub(super) fn name(&self) -> &str {
        self.attribute("name")
    }

    /// The child of that name.
    pub(super) fn named(&self, name: &str) -> Option<&Self> {
        self.children.iter().find(|child| child.name() == name && child.category != "input")
    }

    /// The input of that name.
    pub(super) fn input(&self, name: &str) -> Option<&Self> {
        self.children.iter().find(|child| child.category == "input" && child.name() == name)
    }

    /// Text that an input has as its value; empty without.
    pub(super) fn text(&self, input: &str) -> &str {
        self.input(input).map_or("", |input| input.attribute("value"))
    }

    /// The value of an input that names a file, with the prefixes around it.
    pub(super) fn file(&self, input: &str) -> String {
        let Some(input) = self.input(input) else { return String::new() };
        let value = input.attribute("value");
        if value.is_empty() { String::new() } else { format!("{}{value}", input.prefix).replace('\\', "/") }
    }

    /// Colour space that holds for an input's value.
    pub(super) fn color_space_of(&self, input: &str) -> &str {
        self.input(input).map_or("", |input| &input.color_space)
    }

    /// The numbers of the attribute `value`, at most four; none where one of them is no finite number.
    pub(super) fn numbers(&self) -> Option<Vec<f32>> {
        let value = self.attribute("value");
        let number = |text: &str| match text.trim() {
            "true" => Some(1.0),
            "false" => Some(0.0),
            text => float(text.as_bytes()).filter(|v| v.is_finite()),
        };
        let numbers: Option<Vec<f32>> = value.split(',').take(5).map(number).collect();
        numbers.filter(|numbers| (1..=4).contains(&numbers.len()))
    }
}
