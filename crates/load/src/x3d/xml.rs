//! The XML syntax of X3D (ISO/IEC 19776-1): elements are nodes, attributes their fields.

use super::FORMAT;
use super::node::{Node, Value};
use super::reading::Reading;
use crate::LoadError;
use crate::text::quoted;
use crate::xml::{Tag, Xml};

/// Reads a text: the outermost nodes of its scene.
pub(super) fn read(text: &str, reading: &mut Reading<'_>) -> Result<Vec<usize>, LoadError> {
    let mut roots = Vec::new();
    // Files refer to a definition of their type; nothing of it is read.
    Xml::new(FORMAT, "", text).with_definitions().root(|xml, _| {
        xml.children(|xml, tag| match tag.name() {
            "Scene" | "scene" => xml.children(|xml, tag| {
                roots.extend(node(xml, tag, reading)?.map(|(_, node)| node));
                Ok(())
            }),
            _ => Ok(()),
        })
    })?;
    Ok(roots)
}

/// Reads an element, and the name of the field that it is in; none for elements that are no nodes.
fn node(
    xml: &mut Xml<'_>,
    tag: &Tag<'_>,
    reading: &mut Reading<'_>,
) -> Result<Option<(String, usize)>, LoadError> {
    match tag.name() {
        "ROUTE" | "IMPORT" | "EXPORT" | "IS" | "connect" | "field" | "fieldValue" => return Ok(None),
        "ProtoDeclare" | "ExternProtoDeclare" => {
            let name = quoted(tag.attribute("name").unwrap_or_default().as_bytes());
            reading.warnings.add(|| format!("{FORMAT}: prototype {name} ({}) is left out", tag.name()));
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
        return Ok(reading.used(&used).map(|node| (field, node)));
    }
    tag.name().clone_into(&mut node.kind);
    reading.enter()?;
    xml.children(|xml, tag| {
        node.children.extend(self::node(xml, tag, reading)?);
        Ok(())
    })?;
    reading.leave(node, name).map(|node| Some((field, node)))
}
