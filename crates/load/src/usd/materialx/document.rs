//! Documents of MaterialX as layers: `/MaterialX/Materials` has their materials, as OpenUSD's own reader puts them.
//!
//! A material is one property that names it in its document, which is read as a document is. Opinions of other layers on what is in
//! it have no effect.

use super::super::compose::{Composed, Stage};
use super::super::files::Files;
use super::super::layer::{Layer, Prim, Property, Specifier, Value};
use super::super::{FORMAT, network};
use super::{Graph, Pictures};
use crate::LoadError;
use crate::material::{Element, Includes, materials};
use crate::nearby::folder_of;
use crate::text::{quoted, without_mark};
use std::collections::BTreeMap;
use std::rc::Rc;

/// Property that names the material: its value counts in layers that are documents only.
const NAME: &str = "info:mtlx:material";
/// Bytes of a document at most, with all that it includes.
const MOST_BYTES: u64 = 1 << 24;
/// Bytes that an element takes in memory, for each byte of its text.
const BYTES: u64 = 8;

/// Documents by the names of their layers.
pub(in super::super) type Documents = BTreeMap<String, Rc<Element>>;

impl Files<'_> {
    /// Reads a file as a layer if it is a document of MaterialX.
    pub(in super::super) fn document(
        &mut self,
        name: &str,
        bytes: &[u8],
    ) -> Result<Option<Layer>, LoadError> {
        if without_mark(bytes).trim_ascii_start().first() != Some(&b'<') {
            return Ok(None);
        }
        let bad = |why: String| LoadError::malformed(FORMAT, why);
        let text =
            std::str::from_utf8(without_mark(bytes)).map_err(|_| bad("it is not a text file".into()))?;
        let mut left = MOST_BYTES
            .checked_sub(text.len() as u64)
            .ok_or_else(|| bad(format!("it has more than {MOST_BYTES} bytes")))?;
        self.budget.charge(|| format!("{FORMAT}: documents of MaterialX"), text.len() as u64, BYTES)?;
        let (context, nearby, folder) = (self.context, &mut self.nearby, folder_of(name));
        let mut size = 0_u64;
        let mut included = |file: &str| {
            let found = nearby.read(context, folder, [file], left).map_err(|error| error.to_string())?;
            left = left.saturating_sub(found.bytes.len() as u64);
            size = size.saturating_add(found.bytes.len() as u64);
            String::from_utf8(found.bytes).map_err(|_| "it is not a text file".to_owned())
        };
        let mut includes = Includes::new(&mut included);
        let document = Element::document(text, &mut includes)?;
        let notes = includes.notes;
        self.budget.charge(|| format!("{FORMAT}: documents of MaterialX"), size, BYTES)?;
        for note in notes {
            self.say(|| format!("{FORMAT}: {}: {note}", quoted(name.as_bytes())));
        }
        let layer = layer_of(&document);
        self.documents.insert(name.to_owned(), Rc::new(document));
        Ok(Some(layer))
    }
}

/// The prims of a document.
fn layer_of(document: &Element) -> Layer {
    let prim = |name: &str, children: Vec<Rc<Prim>>| Prim {
        name: name.to_owned(),
        specifier: Specifier::Def,
        children,
        ..Prim::default()
    };
    let material = |name: &str| {
        let value = Some(Rc::new(Value::Texts(vec![name.to_owned()])));
        let property = Property { value, ..Property::default() };
        Rc::new(Prim {
            type_name: "Material".to_owned(),
            properties: BTreeMap::from([(NAME.to_owned(), property)]),
            ..prim(name, Vec::new())
        })
    };
    let mut all: BTreeMap<&str, Rc<Prim>> = BTreeMap::new();
    for name in materials(document) {
        all.entry(name).or_insert_with(|| material(name));
    }
    let inner = prim("Materials", all.into_values().collect());
    let outer = prim("MaterialX", vec![Rc::new(inner)]);
    let root = Rc::new(prim("", vec![Rc::new(outer)]));
    Layer { root, default_prim: Some("MaterialX".to_owned()), ..Layer::default() }
}

impl Stage<'_> {
    /// The graph of a material that comes from a document.
    pub(super) fn document_of(&mut self, material: &Composed) -> Option<Graph> {
        let found = material.property(NAME)?;
        let (name, file) = (found.value?.text()?.to_owned(), found.file?);
        let document = Rc::clone(self.files.documents.get(&*file)?);
        let is_changed = |name: &&str| name.starts_with("inputs:") || name.starts_with("outputs:");
        if material.property_names().iter().any(is_changed) {
            let path = quoted(material.path.as_bytes());
            self.files.say(|| {
                format!("{FORMAT}: material {path} is that of its document: what other layers say of it has no effect")
            });
        }
        let pictures = Pictures { known: BTreeMap::new(), folder: folder_of(&file).to_owned() };
        let sets = network::SETS.map(str::to_owned).to_vec();
        Some(Graph { document, material: name, pictures, sets, color: None })
    }
}
