//! Objects of a file and what connects them.

use super::record::{FORMAT, File, Record};
use crate::LoadError;
use crate::budget::Budget;
use crate::names::name_of;
use overcoat_core::limits::Limits;
use std::collections::BTreeMap;

/// Kinds of objects that are drawn, or have to do with such.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Model,
    Geometry,
    Attribute,
    Material,
    Texture,
    Layered,
    Video,
    Deformer,
    Other,
}

/// Name of an object in connections: a number, or before version 7 its name.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Id<'r> {
    Number(i64),
    Name(&'r [u8]),
}

/// An object.
pub(super) struct Object<'r> {
    pub(super) kind: Kind,
    pub(super) record: &'r Record<'r>,
    pub(super) name: String,
    /// Kind of mesh, deformer and the like.
    pub(super) class: &'r [u8],
    pub(super) properties: Properties<'r>,
    /// Objects that are connected to this one, in the order of the file, with the property that they are connected to.
    pub(super) links: Vec<(usize, Option<&'r [u8]>)>,
}

/// Objects of a file.
pub(super) struct Document<'r> {
    pub(super) objects: Vec<Object<'r>>,
    pub(super) settings: Properties<'r>,
    /// Written by Blender, whose materials mean something else in two places.
    pub(super) is_blender: bool,
    /// Connections are part of the file: without them, it was cut short.
    pub(super) is_connected: bool,
}

/// Most properties of an object that are looked through.
const OWN: usize = 2048;
/// Most properties of a template, of which every object of a kind looks for its own.
const TEMPLATE: usize = 256;
/// Most connections of an object that many others share.
const SHARED: usize = 64;

/// Named properties of an object; where it lacks one, that of the template of its kind.
#[derive(Clone, Copy, Default)]
pub(super) struct Properties<'r> {
    own: Option<&'r Record<'r>>,
    template: Option<&'r Record<'r>>,
}

impl<'r> Properties<'r> {
    fn of(record: &'r Record<'r>) -> Option<&'r Record<'r>> {
        record.records.iter().find(|child| matches!(&*child.name, b"Properties70" | b"Properties60"))
    }

    /// Properties that the object has itself: their names, and the place of the first value in their records.
    pub(super) fn own(&self) -> impl Iterator<Item = (&'r [u8], &'r Record<'r>, usize)> + use<'r> {
        self.own.into_iter().flat_map(listed).take(OWN)
    }

    /// The record of a property, and the place of its first value.
    fn find(&self, name: &str) -> Option<(&'r Record<'r>, usize)> {
        let of = |list: Option<&'r Record<'r>>, most: usize| {
            let (_, record, place) = listed(list?).take(most).find(|(own, _, _)| *own == name.as_bytes())?;
            Some((record, place))
        };
        of(self.own, OWN).or_else(|| of(self.template, TEMPLATE))
    }

    pub(super) fn number(&self, name: &str) -> Option<f64> {
        let (record, place) = self.find(name)?;
        record.float(place)
    }

    pub(super) fn vector(&self, name: &str) -> Option<[f64; 3]> {
        let (record, place) = self.find(name)?;
        vector(record, place)
    }

    pub(super) fn text(&self, name: &str) -> Option<&'r [u8]> {
        let (record, place) = self.find(name)?;
        record.text(place)
    }
}

/// Three numbers of a record.
pub(super) fn vector(record: &Record<'_>, place: usize) -> Option<[f64; 3]> {
    let at = |k: usize| record.float(place.saturating_add(k));
    Some([at(0)?, at(1)?, at(2)?])
}

/// Names of properties, their records, and the place of the first value: `P: name, type, label, flags, values` or, before
/// version 7, `Property: name, type, flags, values`.
fn listed<'r>(list: &'r Record<'r>) -> impl Iterator<Item = (&'r [u8], &'r Record<'r>, usize)> {
    list.records.iter().filter_map(|record| {
        let place = match &*record.name {
            b"P" => 4,
            b"Property" => 3,
            _ => return None,
        };
        Some((record.text(0)?, record, place))
    })
}

/// The name of an object: `Name\0\x01Class` in binary files, `Class::Name` in texts.
fn plain_name(name: &[u8]) -> String {
    let end = name.windows(2).position(|window| window == b"\0\x01");
    let name = match end {
        Some(end) => name.get(..end).unwrap_or_default(),
        None => {
            let start = name.windows(2).position(|window| window == b"::");
            start.and_then(|start| name.get(start.saturating_add(2)..)).unwrap_or(name)
        }
    };
    name_of(name)
}

fn kind_of(name: &[u8]) -> Kind {
    match name {
        b"Model" => Kind::Model,
        b"Geometry" => Kind::Geometry,
        b"NodeAttribute" => Kind::Attribute,
        b"Material" => Kind::Material,
        b"Texture" => Kind::Texture,
        b"LayeredTexture" => Kind::Layered,
        b"Video" => Kind::Video,
        b"Deformer" => Kind::Deformer,
        _ => Kind::Other,
    }
}

impl<'r> Document<'r> {
    /// Objects of the records of a file.
    pub(super) fn new(file: &'r File<'r>, most: u64, budget: &mut Budget) -> Result<Self, LoadError> {
        let root = &file.root;
        let is_old = file.version < 7000;
        let mut templates: BTreeMap<&[u8], &Record<'_>> = BTreeMap::new();
        for kind in root.children("Definitions").flat_map(|record| record.children("ObjectType")) {
            if let (Some(name), Some(template)) = (kind.text(0), kind.child("PropertyTemplate")) {
                templates.extend(Properties::of(template).map(|template| (name, template)));
            }
        }
        let mut settings = root.child("GlobalSettings").and_then(Properties::of);
        let (mut objects, mut numbers) = (Vec::new(), BTreeMap::new());
        for record in root.children("Objects").flat_map(|objects| &objects.records) {
            if *record.name == *b"GlobalSettings" {
                settings = settings.or_else(|| Properties::of(record));
                continue;
            }
            let [id, name, class] = if is_old { [0, 0, 1] } else { [0, 1, 2] };
            let name = record.text(name).unwrap_or_default();
            let id = match record.integer(id) {
                Some(number) => Id::Number(number),
                None if is_old => Id::Name(name),
                None => continue,
            };
            let count = (objects.len() as u64).saturating_add(1);
            Limits::check(|| format!("{FORMAT}: the number of objects"), count, most, "nodes")?;
            numbers.entry(id).or_insert(objects.len());
            let template = templates.get(&*record.name).copied();
            objects.push(Object {
                kind: kind_of(&record.name),
                record,
                name: plain_name(name),
                class: record.text(class).unwrap_or_default(),
                properties: Properties { own: Properties::of(record), template },
                links: Vec::new(),
            });
        }
        let mut document = Self {
            objects,
            settings: Properties { own: settings, template: None },
            is_blender: is_blender(root),
            is_connected: root.child("Connections").is_some(),
        };
        document.connect(root, &numbers, budget)?;
        Ok(document)
    }

    fn connect(
        &mut self,
        root: &'r Record<'r>,
        numbers: &BTreeMap<Id<'r>, usize>,
        budget: &mut Budget,
    ) -> Result<(), LoadError> {
        for record in root.children("Connections").flat_map(|list| &list.records) {
            if !matches!(&*record.name, b"C" | b"Connect") || !matches!(record.text(0), Some(b"OO" | b"OP")) {
                continue;
            }
            let of = |place: usize| {
                let id = record.integer(place).map(Id::Number);
                id.or_else(|| record.text(place).map(Id::Name)).and_then(|id| numbers.get(&id).copied())
            };
            // Connections to the root, and to objects that the file does not have, have no effect.
            let (Some(from), Some(to)) = (of(1), of(2)) else { continue };
            budget.charge(|| format!("{FORMAT}: the list of connections"), 1, 32)?;
            if let Some(object) = self.objects.get_mut(to) {
                object.links.push((from, record.text(3)));
            }
        }
        Ok(())
    }

    /// Objects of a kind that are connected to one, with their numbers.
    pub(super) fn linked(&self, number: usize, kind: Kind) -> impl Iterator<Item = (usize, &Object<'r>)> {
        self.linked_within(number, kind, usize::MAX)
    }

    /// [`Self::linked`] for an object that others share: a file of many of both is not looked through many times.
    pub(super) fn linked_few(&self, number: usize, kind: Kind) -> impl Iterator<Item = (usize, &Object<'r>)> {
        self.linked_within(number, kind, SHARED)
    }

    fn linked_within(
        &self,
        number: usize,
        kind: Kind,
        most: usize,
    ) -> impl Iterator<Item = (usize, &Object<'r>)> {
        let links = self.objects.get(number).map(|object| object.links.as_slice()).unwrap_or_default();
        let links = links.get(..most).unwrap_or(links);
        let object = |&(from, _): &(usize, Option<&[u8]>)| Some((from, self.objects.get(from)?));
        links.iter().filter_map(object).filter(move |(_, object)| object.kind == kind)
    }
}

fn is_blender(root: &Record<'_>) -> bool {
    let header = root.child("FBXHeaderExtension");
    let creators =
        header.and_then(|header| header.text_of("Creator")).into_iter().chain(root.text_of("Creator"));
    creators.into_iter().any(|creator| creator.starts_with(b"Blender"))
}
