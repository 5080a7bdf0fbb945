//! Nodes and their names, as both parsers fill them.

use super::FORMAT;
use super::node::Node;
use crate::LoadError;
use crate::budget::Budget;
use crate::text::quoted;
use crate::warnings::Warnings;
use overcoat_core::limits::Limits;
use std::collections::BTreeMap;
use std::rc::Rc;

/// Nodes may nest this deep, whatever the limits say.
pub(super) const DEEPEST: u64 = 200;
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
}

impl Nodes {
    pub(super) fn get(&self, node: usize) -> Option<Rc<Node>> {
        self.list.get(node).cloned()
    }

    fn add(&mut self, node: Node) -> usize {
        self.list.push(Rc::new(node));
        self.list.len().saturating_sub(1)
    }
}

/// Reading of one file.
pub(super) struct Reading<'a> {
    pub(super) nodes: &'a mut Nodes,
    pub(super) budget: &'a mut Budget,
    pub(super) warnings: &'a mut Warnings,
    pub(super) limits: &'a Limits,
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
        limits: &'a Limits,
        folder: String,
    ) -> Self {
        nodes.folders.push(folder);
        let folder = nodes.folders.len().saturating_sub(1);
        Self { nodes, budget, warnings, limits, folder, named: vec![BTreeMap::new()], depth: 0 }
    }

    /// Begins a node within others.
    pub(super) fn enter(&mut self) -> Result<(), LoadError> {
        self.depth = self.depth.saturating_add(1);
        let limit = self.limits.depth.min(DEEPEST);
        Ok(Limits::check(|| format!("{FORMAT}: nodes within nodes"), self.depth, limit, "depth")?)
    }

    /// Ends a node, which gets a name if it has one. What is within a node cannot refer to it, so that none contains itself.
    pub(super) fn leave(&mut self, mut node: Node, name: Option<String>) -> Result<usize, LoadError> {
        self.depth = self.depth.saturating_sub(1);
        let count = (self.nodes.list.len() as u64).saturating_add(1);
        Limits::check(|| format!("{FORMAT}: the number of nodes"), count, self.limits.nodes, "nodes")?;
        // Contents of fields are charged with the text that they are in.
        let values = (node.fields.len() as u64).saturating_add(node.children.len() as u64);
        let bytes = values.saturating_mul(VALUE).saturating_add(NODE);
        self.budget.charge(|| format!("{FORMAT}: a node"), bytes, 1)?;
        node.folder = self.folder;
        let number = self.nodes.add(node);
        self.name(number, name);
        Ok(number)
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
