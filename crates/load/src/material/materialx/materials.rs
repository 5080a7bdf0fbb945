//! The materials of a MaterialX document.

use super::document::Element;
use super::graph::Graph;
use super::read::{self, Readable, Surface};
use super::shaders::{SHADERS, Shader};

/// A document as material files.
pub(super) struct Read {
    /// One for each material, the first that is read before the others.
    pub(super) texts: Vec<String>,
    /// Parts without effect, in words.
    pub(super) notes: Vec<String>,
}

/// Most materials of a document that are read.
const MOST_MATERIALS: usize = 64;

/// Reads the materials of a document whose shaders are known.
///
/// # Errors
/// One line if there is none.
pub(super) fn read(document: &Element, readable: Readable<'_>) -> Result<Read, String> {
    let materials: Vec<(&Element, &Element)> = document
        .children
        .iter()
        .filter(|child| child.category == "surfacematerial")
        .filter_map(|material| Some((material, shader_of(document, material)?)))
        .collect();
    let shaders = document.children.iter().filter(|child| child.attribute("type") == "surfaceshader");
    let bare = shaders.map(|shader| (shader, shader));
    let all: Vec<_> = if materials.is_empty() { bare.collect() } else { materials };
    let mut found: Vec<(&Element, &Element, &'static Shader)> = Vec::new();
    for (material, surface) in &all {
        let is_new = found.iter().all(|(other, ..)| other.name() != material.name());
        if let Some(shader) = known(surface).filter(|_| is_new && found.len() < MOST_MATERIALS) {
            found.push((*material, *surface, shader));
        }
    }
    if found.is_empty() {
        let read: Vec<&str> = SHADERS.iter().map(|shader| shader.category).collect();
        let has = all.first().map_or("there is no surface shader".to_owned(), |(_, surface)| {
            format!("the surface shader {} is not read", surface.category)
        });
        return Err(format!("{has}; those that are: {}", read.join(", ")));
    }
    let mut result = Read { texts: Vec::new(), notes: about_several(&all, &found) };
    let mut pictures = Vec::new();
    for (material, surface, shader) in &found {
        let Surface { text, notes, .. } =
            read::surface(document, (material, surface, shader), &mut *readable, &mut pictures);
        result.texts.push(text);
        let of = if found.len() > 1 { format!("{}: ", material.name()) } else { String::new() };
        result.notes.extend(notes.into_iter().map(|note| format!("{of}{note}")));
    }
    Ok(result)
}

/// Reads the surface of one material of a document that another format holds or refers to.
///
/// # Errors
/// The category of its surface shader if that is not read, which is empty without one.
pub(crate) fn surface(document: &Element, material: &str, readable: Readable<'_>) -> Result<Surface, String> {
    let element = document.named(material).filter(|element| element.category == "surfacematerial");
    let found = element.and_then(|element| Some((element, shader_of(document, element)?)));
    let Some((element, surface)) = found else { return Err(String::new()) };
    let shader = known(surface).ok_or_else(|| surface.category.clone())?;
    Ok(read::surface(document, (element, surface, shader), readable, &mut Vec::new()))
}

/// The names of a document's materials.
pub(crate) fn materials(document: &Element) -> impl Iterator<Item = &str> {
    document.children.iter().filter(|child| child.category == "surfacematerial").map(Element::name)
}

/// The shader of an element, if it is one of those that are read.
fn known(surface: &Element) -> Option<&'static Shader> {
    SHADERS.iter().find(|shader| shader.category == surface.category)
}

/// Notes about a document with several materials: their names, and those that are not read.
fn about_several(
    all: &[(&Element, &Element)],
    found: &[(&Element, &Element, &'static Shader)],
) -> Vec<String> {
    let listed = |names: &[&str]| {
        let more = if names.len() > 8 { ", ..." } else { "" };
        names.iter().take(8).copied().collect::<Vec<_>>().join(", ") + more
    };
    let names: Vec<&str> = found.iter().map(|(material, ..)| material.name()).collect();
    let is_read = |material: &Element| found.iter().any(|(other, ..)| std::ptr::eq(*other, material));
    let left: Vec<&str> = all.iter().filter(|(m, _)| !is_read(m)).map(|(m, _)| m.name()).collect();
    let mut notes = Vec::new();
    if let [first, _, ..] = names[..] {
        notes.push(format!(
            "the file has the materials {}: each is drawn where the model has one of its name, and {first} where it has none of them",
            listed(&names)
        ));
    }
    if !left.is_empty() {
        notes.push(format!("these materials of the file are not read: {}", listed(&left)));
    }
    notes
}

/// The surface shader of a material.
fn shader_of<'a>(document: &'a Element, material: &'a Element) -> Option<&'a Element> {
    Graph::new(document).source(material.input("surfaceshader")?, document).map(|(shader, _)| shader)
}
