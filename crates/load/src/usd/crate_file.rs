//! The binary syntax, usdc ("Crate"), versions 0.0.1 to 0.13: its sections, and the layer that they describe.
//!
//! Source: OpenUSD `pxr/usd/sdf/crateFile.cpp`. Strings, paths and fields are tables; a spec is a path with a set of fields. Values of
//! fields are read where they matter to a picture, each once however many specs share it.

use super::FORMAT;
use super::crate_values::{Bytes, Rep, kind};
use super::layer::{Layer, Prim, Property, Specifier, Value, check_depth};
use super::lz4;
use crate::budget::Budget;
use crate::text::quoted;
use crate::{Context, LoadError};
use overcoat_core::limits::Limits;
use std::collections::BTreeMap;
use std::rc::Rc;

/// First bytes of a file.
pub(super) const MAGIC: &[u8; 8] = b"PXR-USDC";

/// Fields of one spec that are looked at: files have about a dozen.
const FIELDS: usize = 256;
/// Most bytes of a path.
const LONGEST_PATH: usize = 1 << 16;
/// Ends a set of fields.
const END: u32 = u32::MAX;

/// Kinds of specs (`SdfSpecType`).
mod spec {
    pub(super) const ATTRIBUTE: i32 = 1;
    pub(super) const PRIM: i32 = 6;
    pub(super) const PSEUDO_ROOT: i32 = 7;
    pub(super) const RELATIONSHIP: i32 = 8;
    pub(super) const VARIANT: i32 = 10;
}

pub(super) fn damaged(what: &str) -> LoadError {
    LoadError::malformed(FORMAT, format!("{what} of the binary file is damaged or not complete"))
}

/// A path as an element of its parent's.
#[derive(Clone, Copy, Default)]
struct Place {
    parent: u32,
    token: u32,
    is_property: bool,
    /// Some element of the table of paths is this one.
    is_there: bool,
    depth: u32,
}

/// A file whose tables are read.
pub(super) struct File<'a, 'c> {
    pub(super) bytes: &'a [u8],
    pub(super) version: [u8; 3],
    tokens: Vec<String>,
    strings: Vec<u32>,
    /// Names and values of fields.
    fields: Vec<(u32, Rep)>,
    field_sets: Vec<u32>,
    paths: Vec<Place>,
    /// Kinds and first fields of specs, by their paths.
    specs: BTreeMap<u32, (i32, u32)>,
    values: BTreeMap<u64, Rc<Value>>,
    pub(super) context: &'c Context<'c>,
    pub(super) budget: &'c mut Budget,
}

/// Reads a layer.
pub(super) fn read(bytes: &[u8], context: &Context<'_>, budget: &mut Budget) -> Result<Layer, LoadError> {
    let version =
        bytes.get(8..11).and_then(|v| v.first_chunk()).copied().ok_or_else(|| damaged("the head"))?;
    if version[0] > 0 || version[1] > 13 {
        let [major, minor, patch] = version;
        return Err(LoadError::unsupported(
            FORMAT,
            format!("binary files of version {major}.{minor}.{patch} are not known"),
        ));
    }
    let mut file = File {
        bytes,
        version,
        tokens: Vec::new(),
        strings: Vec::new(),
        fields: Vec::new(),
        field_sets: Vec::new(),
        paths: Vec::new(),
        specs: BTreeMap::new(),
        values: BTreeMap::new(),
        context,
        budget,
    };
    file.sections()?;
    file.layer()
}

impl<'a> File<'a, '_> {
    pub(super) fn at(&self, offset: u64) -> Bytes<'a> {
        Bytes::new(self.bytes, offset)
    }

    pub(super) fn token(&self, index: u32) -> Option<&str> {
        self.tokens.get(index as usize).map(String::as_str)
    }

    pub(super) fn string(&self, index: u32) -> Option<&str> {
        self.token(*self.strings.get(index as usize)?)
    }

    /// Grants memory for a table.
    fn charge(&mut self, what: &str, count: u64, size: u64) -> Result<(), LoadError> {
        Ok(self.budget.charge(|| format!("{FORMAT}: {what}"), count, size)?)
    }

    fn sections(&mut self) -> Result<(), LoadError> {
        let error = || damaged("the table of contents");
        let mut at = self.at(16);
        let mut at = self.at(at.u64().ok_or_else(error)?);
        let count = at.u64().ok_or_else(error)?;
        let mut starts: BTreeMap<&[u8], u64> = BTreeMap::new();
        for _ in 0..count.min(64) {
            let name = at.take(16).ok_or_else(error)?;
            let start = at.u64().ok_or_else(error)?;
            _ = at.u64().ok_or_else(error)?;
            let end = name.iter().position(|&b| b == 0).unwrap_or(name.len());
            starts.insert(name.get(..end).unwrap_or_default(), start);
        }
        let start = |name: &str| starts.get(name.as_bytes()).map(|&start| Bytes::new(self.bytes, start));
        let [tokens, strings, fields, sets, paths, specs] =
            ["TOKENS", "STRINGS", "FIELDS", "FIELDSETS", "PATHS", "SPECS"].map(start);
        let section = |bytes: Option<Bytes<'a>>, what: &str| bytes.ok_or_else(|| damaged(what));
        self.read_tokens(section(tokens, "the table of tokens")?)?;
        self.strings = match strings {
            Some(bytes) => self.read_strings(bytes)?,
            None => Vec::new(),
        };
        self.read_fields(section(fields, "the table of fields")?)?;
        let mut sets = section(sets, "the table of field sets")?;
        self.field_sets = self.table(&mut sets, "the table of field sets")?;
        self.read_paths(section(paths, "the table of paths")?)?;
        self.read_specs(section(specs, "the table of specs")?)
    }

    /// True for files whose tables are compressed.
    fn is_compressed(&self) -> bool {
        self.version >= [0, 4, 0]
    }

    /// Integers of 32 bits with their number before them.
    fn table(&mut self, at: &mut Bytes<'a>, what: &str) -> Result<Vec<u32>, LoadError> {
        let count = at.u64().ok_or_else(|| damaged(what))?;
        if self.is_compressed() { self.integers(at, count, what) } else { self.plain(at, count, what) }
    }

    fn plain(&mut self, at: &mut Bytes<'a>, count: u64, what: &str) -> Result<Vec<u32>, LoadError> {
        let bytes = at.take(count.saturating_mul(4)).ok_or_else(|| damaged(what))?;
        self.charge(what, count, 4)?;
        Ok(bytes.as_chunks().0.iter().map(|&word| u32::from_le_bytes(word)).collect())
    }

    /// So many compressed integers.
    pub(super) fn integers(
        &mut self,
        at: &mut Bytes<'a>,
        count: u64,
        what: &str,
    ) -> Result<Vec<u32>, LoadError> {
        let size = at.u64().ok_or_else(|| damaged(what))?;
        let bytes = at.take(size).ok_or_else(|| damaged(what))?;
        self.charge(what, count, 16)?;
        let count = usize::try_from(count).map_err(|_| damaged(what))?;
        let found = lz4::integers(bytes, count).ok_or_else(|| damaged(what))?;
        Ok(found.into_iter().map(i32::cast_unsigned).collect())
    }

    fn read_tokens(&mut self, mut at: Bytes<'a>) -> Result<(), LoadError> {
        let error = || damaged("the table of tokens");
        let count = at.u64().ok_or_else(error)?;
        let size = at.u64().ok_or_else(error)?;
        self.charge("the table of tokens", size, 2)?;
        let text = if self.is_compressed() {
            let packed = at.u64().ok_or_else(error)?;
            let bytes = at.take(packed).ok_or_else(error)?;
            lz4::decompress(bytes, usize::try_from(size).map_err(|_| error())?).ok_or_else(error)?
        } else {
            at.take(size).ok_or_else(error)?.to_vec()
        };
        let limit = self.context.limits.nodes.saturating_mul(16);
        Limits::check(|| format!("{FORMAT}: the number of tokens"), count, limit, "nodes")?;
        self.charge("the table of tokens", (text.len() as u64).min(count), 24)?;
        let names = text.split(|&b| b == 0).take(usize::try_from(count).unwrap_or(usize::MAX));
        self.tokens = names.map(|name| String::from_utf8_lossy(name).into_owned()).collect();
        Ok(())
    }

    fn read_strings(&mut self, mut at: Bytes<'a>) -> Result<Vec<u32>, LoadError> {
        let what = "the table of strings";
        let count = at.u64().ok_or_else(|| damaged(what))?;
        self.plain(&mut at, count, what)
    }

    fn read_fields(&mut self, mut at: Bytes<'a>) -> Result<(), LoadError> {
        let what = "the table of fields";
        let error = || damaged(what);
        if !self.is_compressed() {
            let count = at.u64().ok_or_else(error)?;
            let bytes = at.take(count.saturating_mul(16)).ok_or_else(error)?;
            self.charge(what, count, 16)?;
            let field = |&[_, _, _, _, a, b, c, d, rep @ ..]: &[u8; 16]| {
                (u32::from_le_bytes([a, b, c, d]), Rep(u64::from_le_bytes(rep)))
            };
            self.fields = bytes.as_chunks().0.iter().map(field).collect();
            return Ok(());
        }
        let names = self.table(&mut at, what)?;
        let size = at.u64().ok_or_else(error)?;
        let bytes = at.take(size).ok_or_else(error)?;
        self.charge(what, names.len() as u64, 32)?;
        let reps = lz4::decompress(bytes, names.len().saturating_mul(8)).ok_or_else(error)?;
        let reps = reps.as_chunks().0.iter().map(|&rep| Rep(u64::from_le_bytes(rep)));
        self.fields = names.into_iter().zip(reps).collect();
        Ok(())
    }

    /// Fills the table of paths from their tree, written in depth first.
    fn read_paths(&mut self, mut at: Bytes<'a>) -> Result<(), LoadError> {
        let what = "the table of paths";
        let error = || damaged(what);
        let all = at.u64().ok_or_else(error)?;
        let limit = self.context.limits.nodes.saturating_mul(64);
        Limits::check(|| format!("{FORMAT}: the number of paths"), all, limit, "nodes")?;
        if !self.is_compressed() {
            return self.read_plain_paths(at, all);
        }
        let count = at.u64().ok_or_else(error)?;
        let indices = self.integers(&mut at, count, what)?;
        let names = self.integers(&mut at, count, what)?;
        let jumps = self.integers(&mut at, count, what)?;
        self.charge(what, all, size_of::<Place>() as u64)?;
        let all = usize::try_from(all).map_err(|_| error())?;
        self.paths = vec![Place::default(); all];
        // Places whose siblings follow later, with their parents.
        let mut later: Vec<(usize, u32)> = Vec::new();
        let (mut next, mut parent) = (0_usize, END);
        let elements = || indices.iter().zip(&names).zip(&jumps);
        let elements: Vec<_> =
            elements().map(|((&i, &n), &j)| (i, n.cast_signed(), j.cast_signed())).collect();
        // Each element once.
        for _ in 0..elements.len() {
            let Some(&(index, name, jump)) = elements.get(next) else { return Err(error()) };
            self.place(index, parent, name).ok_or_else(error)?;
            let (has_child, has_sibling) = (jump > 0 || jump == -1, jump >= 0);
            if has_child && has_sibling {
                let sibling =
                    next.checked_add(usize::try_from(jump).map_err(|_| error())?).ok_or_else(error)?;
                later.push((sibling, parent));
            }
            if has_child {
                parent = index;
            }
            next = next.saturating_add(1);
            if !has_child && !has_sibling {
                let Some(following) = later.pop() else { break };
                (next, parent) = following;
            }
        }
        Ok(())
    }

    /// Reads the tree of files before version 0.4.
    fn read_plain_paths(&mut self, mut at: Bytes<'a>, all: u64) -> Result<(), LoadError> {
        let what = "the table of paths";
        let error = || damaged(what);
        // Padding of version 0.0.1 lies in front of index, name and bits of an element.
        let padding = if self.version == [0, 0, 1] { 4 } else { 0 };
        self.charge(what, all, size_of::<Place>() as u64)?;
        self.paths = vec![Place::default(); usize::try_from(all).map_err(|_| error())?];
        let mut later: Vec<(u64, u32)> = Vec::new();
        let mut parent = END;
        for _ in 0..self.paths.len() {
            at.take(padding).ok_or_else(error)?;
            let (index, name) = (at.u32().ok_or_else(error)?, at.u32().ok_or_else(error)?);
            let bits = at.u8().ok_or_else(error)?;
            at.take(3).ok_or_else(error)?;
            let name = name.cast_signed();
            self.place(index, parent, if bits & 4 > 0 { name.wrapping_neg() } else { name })
                .ok_or_else(error)?;
            if bits & 3 == 3 {
                later.push((at.u64().ok_or_else(error)?, parent));
            }
            if bits & 1 > 0 {
                parent = index;
            }
            if bits & 3 == 0 {
                let Some((offset, after)) = later.pop() else { break };
                (at, parent) = (self.at(offset), after);
            }
        }
        Ok(())
    }

    fn place(&mut self, index: u32, parent: u32, name: i32) -> Option<()> {
        let depth = match parent {
            END => 0,
            parent => self.paths.get(parent as usize)?.depth.saturating_add(1),
        };
        let place = self.paths.get_mut(index as usize)?;
        // A second place would make a circle.
        if !place.is_there {
            *place =
                Place { parent, token: name.unsigned_abs(), is_property: name < 0, is_there: true, depth };
        }
        Some(())
    }

    fn read_specs(&mut self, mut at: Bytes<'a>) -> Result<(), LoadError> {
        let what = "the table of specs";
        let error = || damaged(what);
        let count = at.u64().ok_or_else(error)?;
        self.charge(what, count, 32)?;
        if !self.is_compressed() {
            let padding = if self.version == [0, 0, 1] { 4 } else { 0 };
            for _ in 0..count {
                at.take(padding).ok_or_else(error)?;
                let mut spec = Bytes::new(at.take(12).ok_or_else(error)?, 0);
                let [path, fields, kind] = [(); 3].map(|()| spec.u32().unwrap_or(END));
                self.specs.insert(path, (kind.cast_signed(), fields));
            }
            return Ok(());
        }
        let paths = self.integers(&mut at, count, what)?;
        let fields = self.integers(&mut at, count, what)?;
        let kinds = self.integers(&mut at, count, what)?;
        let specs = paths.iter().zip(kinds.iter().zip(&fields));
        self.specs = specs.map(|(&path, (kind, &fields))| (path, (kind.cast_signed(), fields))).collect();
        Ok(())
    }

    pub(super) fn is_path(&self, index: u32) -> bool {
        self.paths.get(index as usize).is_some_and(|place| place.is_there)
    }

    /// The path of an index as text.
    pub(super) fn path(&mut self, index: u32) -> Result<String, LoadError> {
        let mut parts: Vec<(&str, bool)> = Vec::new();
        let mut at = index;
        let mut size = 0_usize;
        while let Some(place) = self.paths.get(at as usize)
            && place.parent != END
        {
            let name = self.token(place.token).unwrap_or_default();
            size = size.saturating_add(name.len()).saturating_add(1);
            if size > LONGEST_PATH {
                return Err(damaged("a path"));
            }
            parts.push((name, place.is_property));
            at = place.parent;
        }
        let mut out = String::with_capacity(size);
        for (name, is_property) in parts.into_iter().rev() {
            // Variants and targets are elements without a separator.
            if !name.starts_with(['{', '[']) {
                out.push(if is_property { '.' } else { '/' });
            }
            out.push_str(name);
        }
        self.charge("paths", size as u64, 1)?;
        Ok(if out.is_empty() { "/".to_owned() } else { out })
    }

    /// Names and values of the fields of a spec.
    fn fields_of(&self, first: u32) -> Vec<(u32, Rep)> {
        let set = self.field_sets.get(first as usize..).unwrap_or_default();
        let own = set.iter().take_while(|&&field| field != END).take(FIELDS);
        own.filter_map(|&field| self.fields.get(field as usize).copied()).collect()
    }

    fn layer(&mut self) -> Result<Layer, LoadError> {
        let mut below: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        let mut root = None;
        for (index, place) in self.paths.iter().enumerate().filter(|(_, place)| place.is_there) {
            let index = index as u32;
            match place.parent {
                END => root = Some(index),
                parent => below.entry(parent).or_default().push(index),
            }
        }
        let root = root.ok_or_else(|| damaged("the table of paths"))?;
        let deepest = self.paths.iter().map(|place| place.depth).max().unwrap_or(0);
        check_depth("prims", deepest.into(), self.context.limits)?;
        let mut layer = Layer::default();
        if let Some(&(spec::PSEUDO_ROOT, fields)) = self.specs.get(&root) {
            for (name, rep) in self.fields_of(fields) {
                let name = self.token(name).unwrap_or_default().to_owned();
                match name.as_str() {
                    "defaultPrim" => layer.default_prim = self.text(rep)?,
                    "upAxis" => layer.up = self.text(rep)?,
                    "metersPerUnit" => layer.meters_per_unit = self.value(rep)?.doubles().first().copied(),
                    "subLayers" => layer.sublayers = self.value(rep)?.texts().to_vec(),
                    _ => {}
                }
            }
        }
        layer.root = Rc::new(self.prim(root, String::new(), &below)?);
        Ok(layer)
    }

    /// A prim with all that is in it.
    fn prim(&mut self, index: u32, name: String, below: &BTreeMap<u32, Vec<u32>>) -> Result<Prim, LoadError> {
        self.charge("prims and properties", 256, 1)?;
        let mut prim = Prim { name, ..Prim::default() };
        let mut order = Vec::new();
        if let Some(&(_, fields)) = self.specs.get(&index) {
            order = self.describe(&mut prim, fields)?;
        }
        for &child in below.get(&index).into_iter().flatten() {
            let Some(place) = self.paths.get(child as usize).copied() else { continue };
            let Some(&(kind, fields)) = self.specs.get(&child) else { continue };
            let Some(name) = self.token(place.token).map(str::to_owned) else { continue };
            match kind {
                spec::ATTRIBUTE | spec::RELATIONSHIP => {
                    if let Some(property) = self.property(&name, fields)? {
                        prim.properties.insert(name, property);
                    }
                }
                spec::PRIM => prim.children.push(Rc::new(self.prim(child, name, below)?)),
                spec::VARIANT => {
                    let inner = name.trim_start_matches('{').trim_end_matches('}');
                    let Some((set, variant)) = inner.split_once('=') else { continue };
                    let (set, variant) = (set.to_owned(), variant.to_owned());
                    let own = self.prim(child, variant.clone(), below)?;
                    prim.variants.entry(set).or_default().insert(variant, Rc::new(own));
                }
                _ => {}
            }
        }
        let place: BTreeMap<&str, usize> =
            order.iter().enumerate().map(|(k, name)| (name.as_str(), k)).collect();
        prim.children.sort_by_key(|child| place.get(child.name.as_str()).copied().unwrap_or(usize::MAX));
        Ok(prim)
    }

    /// Reads the fields of a prim; gives the order of its children.
    fn describe(&mut self, prim: &mut Prim, fields: u32) -> Result<Vec<String>, LoadError> {
        let mut order = Vec::new();
        for (name, rep) in self.fields_of(fields) {
            let name = self.token(name).unwrap_or_default().to_owned();
            match name.as_str() {
                "specifier" => {
                    prim.specifier = match rep.payload() {
                        0 => Specifier::Def,
                        2 => Specifier::Class,
                        _ => Specifier::Over,
                    };
                }
                "typeName" => prim.type_name = self.text(rep)?.unwrap_or_default(),
                "active" => prim.active = self.value(rep)?.ints().first().map(|&v| v != 0),
                "primChildren" => order = self.value(rep)?.texts().to_vec(),
                "references" => prim.references = self.references(rep)?,
                "payload" => prim.payloads = self.references(rep)?,
                "inheritPaths" => prim.inherits = self.paths_op(rep)?,
                "specializes" => prim.specializes = self.paths_op(rep)?,
                "variantSelection" => prim.selections = self.selections(rep)?,
                _ => {}
            }
        }
        Ok(order)
    }

    fn text(&mut self, rep: Rep) -> Result<Option<String>, LoadError> {
        Ok(self.value(rep)?.text().map(str::to_owned))
    }

    fn property(&mut self, name: &str, fields: u32) -> Result<Option<Property>, LoadError> {
        self.charge("prims and properties", (name.len() as u64).saturating_add(128), 1)?;
        // Animation and rigs, which are not drawn, are most of some files.
        if ["skel:", "primvars:skel:", "velocities", "accelerations"].iter().any(|own| name.starts_with(own))
        {
            return Ok((name == "skel:skeleton").then(Property::default));
        }
        let mut property = Property::default();
        let mut default = None;
        for (name, rep) in self.fields_of(fields) {
            match self.token(name).unwrap_or_default() {
                "default" => default = Some(self.value(rep)?),
                "timeSamples" if rep.kind() == kind::TIME_SAMPLES => {
                    if let Some((first, count)) = self.samples(rep) {
                        property.value = Some(self.value(first)?);
                        property.samples = count;
                    }
                }
                "interpolation" => property.interpolation = self.text(rep)?,
                "colorSpace" => property.color_space = self.text(rep)?,
                "connectionPaths" | "targetPaths" => property.targets = self.paths_op(rep)?,
                _ => {}
            }
        }
        property.value = property.value.or(default);
        Ok(Some(property))
    }

    /// The value of a field; each is read once.
    pub(super) fn value(&mut self, rep: Rep) -> Result<Rc<Value>, LoadError> {
        if let Some(known) = self.values.get(&rep.0) {
            return Ok(Rc::clone(known));
        }
        let value = Rc::new(self.read_value(rep)?);
        self.charge("values", 96, 1)?;
        self.values.insert(rep.0, Rc::clone(&value));
        Ok(value)
    }

    /// Says that a value is damaged.
    pub(super) fn bad_value(&self, rep: Rep) -> LoadError {
        let kind = rep.kind().to_string();
        damaged(&format!("a value of type {}", quoted(kind.as_bytes())))
    }
}
