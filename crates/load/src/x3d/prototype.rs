//! Prototypes (PROTO, ProtoDeclare): what both encodings do alike around the nodes that are read for each use.

use super::external::{self, Source};
use super::node::Node;
use super::reading::Reading;
use crate::LoadError;
use std::ops::ControlFlow;
use std::rc::Rc;

/// A prototype: the values that its fields have by default, and its nodes.
pub(super) struct Prototype<Place> {
    pub(super) defaults: Node,
    pub(super) body: Body<Place>,
}

/// Nodes of a prototype.
pub(super) enum Body<Place> {
    /// Place in this file.
    Here(Place),
    /// Prototype of another file.
    There(Source),
}

impl<Place: Copy> Prototype<Place> {
    /// Begins a use with fields of its own, within `around` uses of other files: adds their values to the scopes and opens names.
    /// Returns the place of the nodes, after which [`end`] has to follow, or the node that stands for the use already: that of
    /// another file, or none.
    pub(super) fn begin(
        &self,
        mut own: Node,
        reading: &mut Reading<'_>,
        scopes: &mut Vec<Rc<Node>>,
        (around, work): (usize, &mut usize),
    ) -> Result<ControlFlow<Option<usize>, Place>, LoadError> {
        let around = around.saturating_add(scopes.len());
        let place = match &self.body {
            Body::Here(place) => *place,
            Body::There(source) => {
                return external::instance(reading, source, own, around, work).map(ControlFlow::Break);
            }
        };
        if !reading.may_use(&own.kind, around, *work) {
            return Ok(ControlFlow::Break(None));
        }
        reading.add_defaults(&self.defaults, &mut own)?;
        scopes.push(Rc::new(own));
        reading.open_names();
        Ok(ControlFlow::Continue(place))
    }
}

/// Ends a use whose nodes have been read.
pub(super) fn end(reading: &mut Reading<'_>, scopes: &mut Vec<Rc<Node>>) {
    reading.close_names();
    scopes.pop();
}
