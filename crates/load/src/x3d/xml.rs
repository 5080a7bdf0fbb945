//! The XML syntax of X3D (ISO/IEC 19776-1): elements are nodes, attributes their fields.

use super::FORMAT;
use super::external::{self, Source};
use super::node::{Node, Value, strings_of};
use super::prototype::{self, Body};
use super::reading::Reading;
use crate::LoadError;
use crate::xml::{Tag, Xml};
use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::rc::Rc;

/// Reads a text: the outermost nodes of its scene.
pub(super) fn read(text: &str, reading: &mut Reading<'_>) -> Result<Vec<usize>, LoadError> {
    let mut roots = Vec::new();
    let mut work = 0;
    let mut parser = Parser::new(reading, (0, &mut work));
    // Files refer to a definition of their type; nothing of it is read.
    Xml::new(FORMAT, "", text).with_definitions().root(|xml, _| {
        xml.children(|xml, tag| match tag.name() {
            "Scene" | "scene" => xml.children(|xml, tag| {
                roots.extend(parser.node(xml, tag)?.map(|(_, node)| node));
                Ok(())
            }),
            _ => Ok(()),
        })
    })?;
    Ok(roots)
}

/// Reads the nodes of a prototype of a text, by its name or the first of all, for a use of it.
pub(super) fn instance_of(
    text: &str,
    name: &str,
    own: Node,
    reading: &mut Reading<'_>,
    uses: (usize, &mut usize),
) -> Result<Option<usize>, LoadError> {
    let mut parser = Parser::new(reading, uses);
    let mut first = None;
    Xml::new(FORMAT, "", text).with_definitions().root(|xml, _| {
        xml.children(|xml, tag| match tag.name() {
            "Scene" | "scene" => xml.children(|xml, tag| {
                if matches!(tag.name(), "ProtoDeclare" | "ExternProtoDeclare") {
                    first = first.take().or_else(|| tag.attribute("name"));
                    parser.node(xml, tag)?;
                }
                Ok(())
            }),
            _ => Ok(()),
        })
    })?;
    let found = if name.is_empty() { first.unwrap_or_default() } else { name.to_owned() };
    match parser.prototypes.get(&found).cloned() {
        Some(prototype) => parser.expand(&prototype, own),
        None => {
            external::missing(parser.reading, name);
            Ok(None)
        }
    }
}

/// A prototype with the text of the element that its nodes are in.
type Prototype<'a> = prototype::Prototype<&'a str>;

struct Parser<'a, 'r, 'n> {
    reading: &'r mut Reading<'n>,
    prototypes: BTreeMap<String, Rc<Prototype<'a>>>,
    /// Fields of the prototypes' uses that are read.
    scopes: Vec<Rc<Node>>,
    /// Uses of prototypes of other files around this one.
    around: usize,
    /// Bytes of prototypes that have been read again.
    work: &'r mut usize,
}

impl<'a, 'r, 'n> Parser<'a, 'r, 'n> {
    fn new(reading: &'r mut Reading<'n>, (around, work): (usize, &'r mut usize)) -> Self {
        Self { reading, prototypes: BTreeMap::new(), scopes: Vec::new(), around, work }
    }

    /// Reads an element, and the name of the field that it is in; none for elements that are no nodes.
    fn node(&mut self, xml: &mut Xml<'a>, tag: &Tag<'a>) -> Result<Option<(String, usize)>, LoadError> {
        match tag.name() {
            "ROUTE" | "IMPORT" | "EXPORT" | "IS" | "connect" | "field" | "fieldValue" => return Ok(None),
            "ProtoDeclare" => return self.declare(xml, tag).map(|()| None),
            "ExternProtoDeclare" => {
                let name = tag.attribute("name").unwrap_or_default();
                let urls = tag.attribute("url").map(|url| strings_of(&url)).unwrap_or_default();
                let (defaults, body) = (Node::default(), Body::There(Source { urls }));
                self.prototypes.insert(name, Rc::new(Prototype { defaults, body }));
                return Ok(None);
            }
            _ => {}
        }
        let mut node = Node::default();
        let (mut name, mut used, mut field) = (None, None, String::new());
        tag.attributes(|key, value| match key {
            "DEF" => name = Some(value.into_owned()),
            "USE" => used = Some(value.into_owned()),
            "containerField" => field = value.into_owned(),
            "class" | "id" | "style" => {}
            _ => _ = node.fields.insert(key.to_owned(), Value::Text(value.into_owned())),
        })
        .map_err(|error| xml.error(error))?;
        if let Some(used) = used {
            return Ok(self.reading.used(&used).map(|node| (field, node)));
        }
        tag.name().clone_into(&mut node.kind);
        let prototype = if node.kind == "ProtoInstance" {
            node.strings("name").pop().and_then(|name| self.prototypes.get(&name).cloned())
        } else {
            None
        };
        self.reading.enter()?;
        if let Some(prototype) = prototype {
            let found = self.instance(xml, &prototype, &node)?;
            self.reading.leave_use(found, name);
            return Ok(found.map(|node| (field, node)));
        }
        xml.children(|xml, tag| {
            if tag.name() == "IS" {
                return self.connect(xml, &mut node);
            }
            node.children.extend(self.node(xml, tag)?);
            Ok(())
        })?;
        self.reading.leave(node, name).map(|node| Some((field, node)))
    }

    /// Reads the fields of a prototype and finds its nodes.
    fn declare(&mut self, xml: &mut Xml<'a>, tag: &Tag<'a>) -> Result<(), LoadError> {
        let name = tag.attribute("name").unwrap_or_default();
        let (mut defaults, mut body) = (Node::default(), None);
        xml.children(|xml, tag| match tag.name() {
            "ProtoInterface" => self.fields(xml, "field", &mut defaults),
            "ProtoBody" => {
                body = Some(xml.skip()?);
                Ok(())
            }
            // Files of X3D 3.0 have fields without an interface around them.
            "field" => self.value(xml, tag, &mut defaults),
            _ => Ok(()),
        })?;
        if let Some(body) = body {
            self.prototypes.insert(name, Rc::new(Prototype { defaults, body: Body::Here(body) }));
        }
        Ok(())
    }

    /// Reads the elements of a name that are values of fields.
    fn fields(&mut self, xml: &mut Xml<'a>, name: &str, node: &mut Node) -> Result<(), LoadError> {
        xml.children(|xml, tag| if tag.name() == name { self.value(xml, tag, node) } else { Ok(()) })
    }

    /// Reads the value of a field: an attribute, or nodes.
    fn value(&mut self, xml: &mut Xml<'a>, tag: &Tag<'a>, node: &mut Node) -> Result<(), LoadError> {
        let name = tag.attribute("name").unwrap_or_default();
        if let Some(value) = tag.attribute("value") {
            node.fields.insert(name.clone(), Value::Text(value));
        }
        xml.children(|xml, tag| {
            node.children.extend(self.node(xml, tag)?.map(|(_, child)| (name.clone(), child)));
            Ok(())
        })
    }

    /// Reads the values that a node has from the prototype around it.
    fn connect(&mut self, xml: &mut Xml<'a>, node: &mut Node) -> Result<(), LoadError> {
        let scope = self.scopes.last().cloned();
        xml.children(|_, tag| {
            let names = tag.attribute("protoField").zip(tag.attribute("nodeField"));
            match names.zip(scope.as_ref()) {
                Some(((field, name), scope)) => self.reading.connect(scope, &field, node, &name),
                None => Ok(()),
            }
        })
    }

    /// Reads the nodes of a prototype for a use of it: the first of them stands for it.
    fn instance(
        &mut self,
        xml: &mut Xml<'a>,
        prototype: &Prototype<'a>,
        tag: &Node,
    ) -> Result<Option<usize>, LoadError> {
        let mut own = Node { kind: tag.strings("name").pop().unwrap_or_default(), ..Node::default() };
        self.fields(xml, "fieldValue", &mut own)?;
        self.expand(prototype, own)
    }

    fn expand(&mut self, prototype: &Prototype<'a>, own: Node) -> Result<Option<usize>, LoadError> {
        let begun = prototype.begin(own, self.reading, &mut self.scopes, (self.around, &mut *self.work))?;
        let body = match begun {
            ControlFlow::Continue(body) => body,
            ControlFlow::Break(node) => return Ok(node),
        };
        *self.work = self.work.saturating_add(body.len());
        let mut found = None;
        Xml::new(FORMAT, "", body).root(|xml, _| {
            xml.children(|xml, tag| {
                if found.is_none() {
                    found = self.node(xml, tag)?.map(|(_, node)| node);
                }
                Ok(())
            })
        })?;
        prototype::end(self.reading, &mut self.scopes);
        Ok(found)
    }
}
