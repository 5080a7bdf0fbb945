//! Stands in for the reader of MaterialX in builds without material files.

use super::compose::Composed;
use super::files::Files;
use super::layer::Layer;
use super::look::{Look, Maker};
use crate::LoadError;
use std::rc::Rc;

/// Fate of a surface of MaterialX.
pub(super) enum Outcome {
    Absent,
    Read(Box<Look>),
    Lost(String),
}

/// No documents.
#[derive(Default)]
pub(super) struct Documents {}

impl Files<'_> {
    /// No file is read as a document.
    pub(super) fn document(&mut self, _: &str, _: &[u8]) -> Result<Option<Layer>, LoadError> {
        Ok(None)
    }
}

impl Maker<'_, '_> {
    /// No surface is read.
    pub(super) fn materialx(
        &mut self,
        _: &Composed,
        _: &[Rc<Composed>],
        _: bool,
    ) -> Result<Outcome, LoadError> {
        Ok(Outcome::Absent)
    }
}
