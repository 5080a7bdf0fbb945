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
pub(crate) struct Element {
    /// Category: `input`, `nodegraph`, `open_pbr_surface`.
    pub(crate) category: String,
    attributes: BTreeMap<String, String>,
    pub(crate) children: Vec<Element>,
    /// `fileprefix` of this element and of all around it.
    prefix: String,
    /// `colorspace` of this element or of the nearest around it.
    color_space: String,
}

impl Element {
    /// An element of a graph that another format holds.
    pub(crate) fn made(category: &str, attributes: &[(&str, &str)]) -> Self {
        let owned = |(name, value): &(&str, &str)| ((*name).to_owned(), (*value).to_owned());
        Self {
            category: category.to_owned(),
            attributes: attributes.iter().map(owned).collect(),
            ..Self::default()
        }
    }

    /// Gives the element the colour space of its value.
    pub(crate) fn in_color_space(self, color_space: &str) -> Self {
        Self { color_space: color_space.to_owned(), ..self }
    }

    /// Reads a document and what it includes.
    pub(crate) fn document(text: &str, includes: &mut Includes<'_>) -> Result<Self, LoadError> {
        let mut root = Self::root("", text, &Self::default(), &mut includes.elements)?;
        includes.fill(&mut root, "", 0);
        Ok(root)
    }

    /// Reads one file: the document itself, or one of this path that it includes.
    fn root(path: &str, text: &str, around: &Self, count: &mut usize) -> Result<Self, LoadError> {
        let mut xml = Xml::new(FORMAT, path, text);
        let mut root = Self::default();
        xml.root(|xml, tag| {
            if tag.name() != "materialx" {
                return Err(xml.error("the outermost element is not materialx"));
            }
            root = Self::read(xml, tag, around, count)?;
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

    pub(crate) fn name(&self) -> &str {
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

/// Files that a document may include, and how deep these may include others.
const MOST_INCLUDED: usize = 32;
const DEEPEST_INCLUDED: usize = 4;

/// Files that a document includes (`xi:include`): from its folder and the folders in it, each once.
pub(crate) struct Includes<'r> {
    /// Text of a file by its path from the document's folder; the reason if there is none.
    read: &'r mut dyn FnMut(&str) -> Result<String, String>,
    seen: Vec<String>,
    /// Elements so far.
    elements: usize,
    /// Files that are left out, in words.
    pub(crate) notes: Vec<String>,
}

impl<'r> Includes<'r> {
    pub(crate) fn new(read: &'r mut dyn FnMut(&str) -> Result<String, String>) -> Self {
        Self { read, seen: Vec::new(), elements: 0, notes: Vec::new() }
    }

    /// Puts the elements of files that a document of this folder includes after its own, which count where both have a name.
    fn fill(&mut self, root: &mut Element, folder: &str, depth: usize) {
        let (includes, own) =
            std::mem::take(&mut root.children).into_iter().partition(|child| child.category == "include");
        root.children = own;
        for include in includes {
            let include: Element = include;
            let href = include.attribute("href").replace('\\', "/");
            match self.file(&href, folder, depth) {
                Ok(Some(included)) => root.children.extend(included.children),
                Ok(None) => {}
                Err(why) if self.notes.len() < MOST_INCLUDED => {
                    self.notes.push(format!("the included file {href} is left out: {why}"));
                }
                Err(_) => {}
            }
        }
    }

    /// Reads one of them, unless that has been done.
    fn file(&mut self, href: &str, folder: &str, depth: usize) -> Result<Option<Element>, String> {
        let path = path_within(folder, href).ok_or("it is not in the document's folder")?;
        if self.seen.contains(&path) {
            return Ok(None);
        }
        if self.seen.len() >= MOST_INCLUDED || depth >= DEEPEST_INCLUDED {
            return Err(format!(
                "no more than {MOST_INCLUDED} files are included, and none deeper than {DEEPEST_INCLUDED}"
            ));
        }
        self.seen.push(path.clone());
        let text = (self.read)(&path)?;
        let inner = path.rsplit_once('/').map_or("", |(folder, _)| folder);
        // Pictures are named from the folder of the file that names them.
        let prefix = if inner.is_empty() { String::new() } else { format!("{inner}/") };
        let around = Element { prefix, ..Element::default() };
        let mut root =
            Element::root(&path, &text, &around, &mut self.elements).map_err(|error| error.to_string())?;
        self.fill(&mut root, inner, depth.saturating_add(1));
        Ok(Some(root))
    }
}

/// A path relative to a folder as one from the document's folder; none if it leads out of that.
fn path_within(folder: &str, href: &str) -> Option<String> {
    if href.is_empty() || href.starts_with('/') || href.contains(':') {
        return None;
    }
    let mut parts: Vec<&str> = Vec::new();
    for part in folder.split('/').chain(href.split('/')) {
        match part {
            "" | "." => {}
            ".." => {
                parts.pop()?;
            }
            part => parts.push(part),
        }
    }
    (!parts.is_empty()).then(|| parts.join("/"))
}
