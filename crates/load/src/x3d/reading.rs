//! Nodes and their names, as both parsers fill them.

use super::FORMAT;
use super::external::Texts;
use super::node::{Node, Value};
use crate::budget::Budget;
use crate::nearby::Nearby;
use crate::text::quoted;
use crate::warnings::Warnings;
use crate::{Context, LoadError};
use overcoat_core::limits::Limits;
use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;

/// Nodes may nest this deep, whatever the limits say.
pub(super) const DEEPEST: u64 = 200;
/// Prototypes within prototypes.
const PROTOTYPES: usize = 32;
/// Bytes of prototypes' nodes that are read for all of their uses.
const WORK: usize = 1 << 26;
/// Bytes that a node takes beside the contents of its fields.
const NODE: u64 = 200;
/// The same for a field.
const VALUE: u64 = 100;

/// All nodes that have been read, of all files.
#[derive(Debug, Default)]
pub(super) struct Nodes {
    list: Vec<Rc<Node>>,
    /// Folders of the files, relative to the model.
    pub(super) folders: Vec<String>,
    pub(super) texts: Texts,
}

impl Nodes {
    pub(super) fn get(&self, node: usize) -> Option<Rc<Node>> {
        self.list.get(node).cloned()
    }

    /// Adds a node within the limits.
    pub(super) fn charged(
        &mut self,
        node: Node,
        limits: &Limits,
        budget: &mut Budget,
    ) -> Result<usize, LoadError> {
        let count = (self.list.len() as u64).saturating_add(1);
        Limits::check(|| format!("{FORMAT}: the number of nodes"), count, limits.nodes, "nodes")?;
        let values = (node.fields.len() as u64).saturating_add(node.children.len() as u64);
        let bytes = values.saturating_mul(VALUE).saturating_add(NODE);
        budget.charge(|| format!("{FORMAT}: a node"), bytes, 1)?;
        self.list.push(Rc::new(node));
        Ok(self.list.len().saturating_sub(1))
    }
}

/// Reading of one file.
pub(super) struct Reading<'a> {
    pub(super) nodes: &'a mut Nodes,
    pub(super) budget: &'a mut Budget,
    pub(super) warnings: &'a mut Warnings,
    pub(super) context: &'a Context<'a>,
    pub(super) nearby: &'a mut Nearby,
    /// Place of the file's folder in the list.
    pub(super) folder: usize,
    /// Nodes by their names; prototypes have names of their own.
    named: Vec<BTreeMap<String, usize>>,
    depth: u64,
}

impl<'a> Reading<'a> {
    pub(super) fn new(
        nodes: &'a mut Nodes,
        budget: &'a mut Budget,
        warnings: &'a mut Warnings,
        (context, nearby): (&'a Context<'a>, &'a mut Nearby),
        folder: String,
    ) -> Self {
        nodes.folders.push(folder);
        let folder = nodes.folders.len().saturating_sub(1);
        Self { nodes, budget, warnings, context, nearby, folder, named: vec![BTreeMap::new()], depth: 0 }
    }

    /// Begins nodes of a file in another folder, within those of this one.
    pub(super) fn begin(&mut self, folder: usize) -> (usize, u64, usize) {
        (std::mem::replace(&mut self.folder, folder), self.depth, self.named.len())
    }

    /// Ends them, also where they end early.
    pub(super) fn end(&mut self, (folder, depth, named): (usize, u64, usize)) {
        (self.folder, self.depth) = (folder, depth);
        self.named.truncate(named);
    }

    /// Begins a node within others.
    pub(super) fn enter(&mut self) -> Result<(), LoadError> {
        self.depth = self.depth.saturating_add(1);
        let limit = self.context.limits.depth.min(DEEPEST);
        Ok(Limits::check(|| format!("{FORMAT}: nodes within nodes"), self.depth, limit, "depth")?)
    }

    /// Ends a node, which gets a name if it has one. What is within a node cannot refer to it, so that none contains itself.
    pub(super) fn leave(&mut self, node: Node, name: Option<String>) -> Result<usize, LoadError> {
        self.depth = self.depth.saturating_sub(1);
        let number = self.add(node)?;
        self.name(number, name);
        Ok(number)
    }

    /// Adds a node of the file. Contents of fields are charged with the text that they are in.
    pub(super) fn add(&mut self, mut node: Node) -> Result<usize, LoadError> {
        node.folder = self.folder;
        self.nodes.charged(node, self.context.limits, self.budget)
    }

    /// Ends a use of a prototype, for which another node stands.
    pub(super) fn leave_use(&mut self, node: Option<usize>, name: Option<String>) {
        self.depth = self.depth.saturating_sub(1);
        node.into_iter().for_each(|node| self.name(node, name.clone()));
    }

    fn name(&mut self, node: usize, name: Option<String>) {
        if let (Some(name), Some(named)) = (name, self.named.last_mut()) {
            named.insert(name, node);
        }
    }

    /// A copy of a value, which takes memory again.
    pub(super) fn copied(&mut self, value: &Value) -> Result<Value, LoadError> {
        self.budget.charge(|| format!("{FORMAT}: a value of a prototype"), value.bytes(), 1)?;
        Ok(value.clone())
    }

    /// Gives a node the value of a field of the prototype that it is in.
    pub(super) fn connect(
        &mut self,
        scope: &Node,
        field: &str,
        node: &mut Node,
        name: &str,
    ) -> Result<(), LoadError> {
        if let Some(value) = scope.fields.get(field) {
            let value = self.copied(value)?;
            node.fields.insert(name.to_owned(), value);
        }
        let children = scope.children.iter().filter(|(known, _)| known == field);
        node.children.extend(children.map(|(_, child)| (name.to_owned(), *child)));
        Ok(())
    }

    /// Gives a use of a prototype the values that its fields have by default.
    pub(super) fn add_defaults(&mut self, defaults: &Node, own: &mut Node) -> Result<(), LoadError> {
        let given: BTreeSet<String> = own.children.iter().map(|(name, _)| name.clone()).collect();
        for (name, value) in &defaults.fields {
            if !own.fields.contains_key(name) && !given.contains(name) {
                let value = self.copied(value)?;
                own.fields.insert(name.clone(), value);
            }
        }
        own.children.extend(defaults.children.iter().filter(|(name, _)| !given.contains(name)).cloned());
        Ok(())
    }

    /// Begins a use of a prototype, unless there are too many in one another or have been read.
    pub(super) fn may_use(&mut self, prototype: &str, scopes: usize, work: usize) -> bool {
        let may = scopes < PROTOTYPES && work <= WORK;
        if !may {
            let name = quoted(prototype.as_bytes());
            self.warnings.add(|| format!("{FORMAT}: prototype {name} is used too often, and left out"));
        }
        may
    }

    /// Begins the nodes of a prototype.
    pub(super) fn open_names(&mut self) {
        self.named.push(BTreeMap::new());
    }

    /// Ends them.
    pub(super) fn close_names(&mut self) {
        self.named.pop();
    }

    /// The node of a name; without one there is a warning.
    pub(super) fn used(&mut self, name: &str) -> Option<usize> {
        let found = self.named.last().and_then(|named| named.get(name)).copied();
        if found.is_none() {
            let name = quoted(name.as_bytes());
            self.warnings.add(|| format!("{FORMAT}: node {name} is used and not defined before"));
        }
        found
    }
}
