//! One layer, as either syntax has it: prims with properties, and how they refer to others.

use super::FORMAT;
use crate::LoadError;
use overcoat_core::limits::Limits;
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::rc::Rc;

/// Depth of prims, variants and values at most: readers call themselves. Scenes have about twenty.
pub(super) const DEPTH: u64 = 128;

/// Checks the depth of something in a file.
pub(super) fn check_depth(what: &str, depth: u64, limits: &Limits) -> Result<(), LoadError> {
    let limit = limits.depth.min(DEPTH);
    Limits::check(|| format!("{FORMAT}: the depth of {what}"), depth, limit, "depth")?;
    Ok(())
}

/// A value of an attribute: a scalar, a tuple, or an array of either, flat.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Value {
    /// Takes the place of weaker opinions, and is none.
    Block,
    Ints(Vec<i32>),
    Floats(Vec<f32>),
    Doubles(Vec<f64>),
    /// Tokens, strings and paths of files.
    Texts(Vec<String>),
}

impl Value {
    /// An empty value of a type by its name: `float3[]`, `matrix4d`, `token`.
    pub(super) fn of_type(name: &str) -> Self {
        match name.trim_end_matches("[]") {
            "bool" | "uchar" => Self::Ints(Vec::new()),
            name if name.starts_with("int") || name.starts_with("uint") => Self::Ints(Vec::new()),
            "token" | "string" | "asset" | "pathExpression" => Self::Texts(Vec::new()),
            name if name.starts_with("matrix") || name.contains("double") || name.ends_with('d') => {
                Self::Doubles(Vec::new())
            }
            _ => Self::Floats(Vec::new()),
        }
    }

    pub(super) fn push_number(&mut self, value: f64) {
        match self {
            // The conversion saturates.
            Self::Ints(list) => list.push(value as i32),
            Self::Floats(list) => list.push(value as f32),
            Self::Doubles(list) => list.push(value),
            Self::Block | Self::Texts(_) => {}
        }
    }

    pub(super) fn floats(&self) -> Cow<'_, [f32]> {
        match self {
            Self::Floats(list) => Cow::Borrowed(list),
            Self::Ints(list) => list.iter().map(|&v| v as f32).collect(),
            Self::Doubles(list) => list.iter().map(|&v| v as f32).collect(),
            Self::Block | Self::Texts(_) => Cow::Borrowed(&[]),
        }
    }

    pub(super) fn doubles(&self) -> Cow<'_, [f64]> {
        match self {
            Self::Doubles(list) => Cow::Borrowed(list),
            Self::Floats(list) => list.iter().map(|&v| v.into()).collect(),
            Self::Ints(list) => list.iter().map(|&v| v.into()).collect(),
            Self::Block | Self::Texts(_) => Cow::Borrowed(&[]),
        }
    }

    pub(super) fn ints(&self) -> &[i32] {
        if let Self::Ints(list) = self { list } else { &[] }
    }

    pub(super) fn texts(&self) -> &[String] {
        if let Self::Texts(list) = self { list } else { &[] }
    }

    pub(super) fn text(&self) -> Option<&str> {
        self.texts().first().map(String::as_str)
    }

    /// Elements of tuples of N numbers.
    pub(super) fn tuples<const N: usize>(&self) -> Vec<[f32; N]> {
        self.floats().as_chunks().0.to_vec()
    }

    /// The first tuple of N numbers.
    pub(super) fn tuple<const N: usize>(&self) -> Option<[f64; N]> {
        self.doubles().first_chunk().copied()
    }

    /// Bytes that it takes in memory.
    pub(super) fn size(&self) -> u64 {
        let (count, size) = match self {
            Self::Block => (0, 0),
            Self::Ints(list) => (list.len(), 4),
            Self::Floats(list) => (list.len(), 4),
            Self::Doubles(list) => (list.len(), 8),
            Self::Texts(list) => (list.iter().map(|text| text.len().saturating_add(24)).sum(), 1),
        };
        (count as u64).saturating_mul(size)
    }
}

/// Edits of a list, or a list.
#[derive(Clone, Debug)]
pub(super) struct ListOp<T> {
    pub(super) explicit: Option<Vec<T>>,
    pub(super) added: Vec<T>,
    pub(super) prepended: Vec<T>,
    pub(super) appended: Vec<T>,
    pub(super) deleted: Vec<T>,
}

impl<T> Default for ListOp<T> {
    fn default() -> Self {
        Self {
            explicit: None,
            added: Vec::new(),
            prepended: Vec::new(),
            appended: Vec::new(),
            deleted: Vec::new(),
        }
    }
}

impl<T: Clone + Ord> ListOp<T> {
    /// Says nothing.
    pub(super) fn is_empty(&self) -> bool {
        self.explicit.is_none()
            && [&self.added, &self.prepended, &self.appended, &self.deleted].iter().all(|l| l.is_empty())
    }

    /// Adds items under the keyword of the text syntax; without one, they are the list.
    pub(super) fn add(&mut self, keyword: &str, items: Vec<T>) {
        match keyword {
            "prepend" => self.prepended.extend(items),
            "append" => self.appended.extend(items),
            "add" => self.added.extend(items),
            "delete" => self.deleted.extend(items),
            "reorder" => {}
            _ => self.explicit = Some(items),
        }
    }

    /// Puts other items in the place of these; `None` leaves one out.
    pub(super) fn map<U>(&self, item: impl Fn(&T) -> Option<U>) -> ListOp<U> {
        let map = |list: &Vec<T>| list.iter().filter_map(&item).collect();
        ListOp {
            explicit: self.explicit.as_ref().map(map),
            added: map(&self.added),
            prepended: map(&self.prepended),
            appended: map(&self.appended),
            deleted: map(&self.deleted),
        }
    }

    /// Edits the list of a weaker opinion (`SdfListOp::ApplyOperations`).
    pub(super) fn apply(&self, list: &mut Vec<T>) {
        if let Some(explicit) = &self.explicit {
            list.clone_from(explicit);
            return;
        }
        if self.is_empty() {
            return;
        }
        let mut moved: std::collections::BTreeSet<&T> = self.deleted.iter().collect();
        moved.extend(self.prepended.iter().chain(&self.appended));
        let known: std::collections::BTreeSet<T> = list.iter().cloned().collect();
        let kept = list.iter().filter(|item| !moved.contains(item)).cloned();
        let added = self.added.iter().filter(|item| !known.contains(item) && !moved.contains(item)).cloned();
        let all =
            self.prepended.iter().cloned().chain(kept).chain(added).chain(self.appended.iter().cloned());
        *list = all.collect();
    }
}

/// A prim of a layer: of another file, or of the same one where that is empty; its default prim where the path is empty.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Reference {
    pub(super) asset: String,
    pub(super) path: String,
}

/// An attribute or relationship of a prim.
#[derive(Clone, Debug, Default)]
pub(super) struct Property {
    /// The first sample, or the default value where there is none.
    pub(super) value: Option<Rc<Value>>,
    /// Samples over time.
    pub(super) samples: u64,
    /// Connections or targets.
    pub(super) targets: ListOp<String>,
    pub(super) interpolation: Option<String>,
    /// Space of a colour or picture: `srgb_texture`, `raw`.
    pub(super) color_space: Option<String>,
}

/// Kinds of prims in a layer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Specifier {
    Def,
    #[default]
    Over,
    Class,
}

/// A prim as one layer has it.
#[derive(Clone, Debug, Default)]
pub(super) struct Prim {
    pub(super) name: String,
    pub(super) specifier: Specifier,
    /// Name of its schema; empty: none.
    pub(super) type_name: String,
    pub(super) active: Option<bool>,
    pub(super) properties: BTreeMap<String, Property>,
    pub(super) children: Vec<Rc<Prim>>,
    pub(super) references: ListOp<Reference>,
    pub(super) payloads: ListOp<Reference>,
    pub(super) inherits: ListOp<String>,
    pub(super) specializes: ListOp<String>,
    /// Variants that are chosen, by their set.
    pub(super) selections: BTreeMap<String, String>,
    pub(super) variants: BTreeMap<String, BTreeMap<String, Rc<Prim>>>,
}

/// A layer.
#[derive(Clone, Debug, Default)]
pub(super) struct Layer {
    /// Path of its file relative to the model.
    pub(super) name: String,
    /// Pseudo-root: the parent of all others.
    pub(super) root: Rc<Prim>,
    pub(super) default_prim: Option<String>,
    pub(super) up: Option<String>,
    pub(super) meters_per_unit: Option<f64>,
    pub(super) sublayers: Vec<String>,
}

/// The path of a child.
pub(super) fn joined(parent: &str, name: &str) -> String {
    format!("{}/{name}", parent.trim_end_matches('/'))
}

/// The path that a relative one stands for in a prim.
pub(super) fn absolute(prim: &str, path: &str) -> String {
    if path.starts_with('/') || path.is_empty() {
        return path.to_owned();
    }
    if path.starts_with('.') && !path.starts_with("..") {
        return format!("{prim}{}", if path == "." { "" } else { path });
    }
    let mut at = prim;
    let mut rest = path;
    while let Some(after) = rest.strip_prefix("..") {
        at = at.rsplit_once('/').map_or("", |(parent, _)| parent);
        rest = after.strip_prefix('/').unwrap_or(after);
        if rest.starts_with('.') && !rest.starts_with("..") {
            return format!("{at}{rest}");
        }
    }
    if rest.is_empty() { at.to_owned() } else { joined(at, rest) }
}
