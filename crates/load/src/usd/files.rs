//! Files of a scene: layers and pictures, found from the file that names them.

use super::layer::Layer;
use super::materialx::Documents;
use super::{FORMAT, crate_file, text};
use crate::budget::Budget;
use crate::nearby::{Nearby, folder_of};
use crate::shares::Shares;
use crate::text::{quoted, without_mark};
use crate::warnings::Warnings;
use crate::{Context, LoadError};
use overcoat_core::limits::Limits;
use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;

/// Sublayers in sublayers at most.
const DEPTH: usize = 64;
/// Layers of one stack at most.
const LAYERS: usize = 1024;

pub(super) struct Files<'c> {
    pub(super) context: &'c Context<'c>,
    pub(super) budget: Budget,
    pub(super) warnings: Warnings,
    pub(super) nearby: Nearby,
    said: BTreeSet<String>,
    /// By folder and name as it is written; `None` for those that cannot be read.
    known: BTreeMap<(String, String), Option<Rc<Layer>>>,
    /// By where they are.
    layers: BTreeMap<String, Rc<Layer>>,
    pub(super) documents: Documents,
}

/// Reads a layer of either syntax.
pub(super) fn read_layer(
    bytes: &[u8],
    context: &Context<'_>,
    budget: &mut Budget,
    warnings: &mut Warnings,
) -> Result<Layer, LoadError> {
    if bytes.starts_with(crate_file::MAGIC) {
        crate_file::read(bytes, context, budget)
    } else if without_mark(bytes).starts_with(b"#usda") || without_mark(bytes).starts_with(b"#sdf") {
        text::read(bytes, context, budget, warnings)
    } else {
        Err(LoadError::malformed(FORMAT, "it begins neither with #usda nor with PXR-USDC"))
    }
}

impl<'c> Files<'c> {
    pub(super) fn new(context: &'c Context<'c>, shares: &Shares) -> Self {
        Self {
            context,
            budget: Budget::shared(context.limits, shares),
            warnings: Warnings::default(),
            nearby: Nearby::default(),
            said: BTreeSet::new(),
            known: BTreeMap::new(),
            layers: BTreeMap::new(),
            documents: Documents::default(),
        }
    }

    /// Warns, of one thing once.
    pub(super) fn say(&mut self, message: impl FnOnce() -> String) {
        let message = message();
        if self.said.len() < LAYERS && self.said.insert(message.clone()) {
            self.warnings.add(|| message);
        }
    }

    /// Warns of a texture that is left out, once.
    pub(super) fn say_texture(&mut self, message: impl FnOnce() -> String) {
        let message = message();
        if self.said.len() < LAYERS && self.said.insert(message.clone()) {
            self.warnings.add_texture(|| message);
        }
    }

    /// The layer that a file in a folder refers to; none, with a warning, if it cannot be had.
    pub(super) fn layer(&mut self, folder: &str, asset: &str) -> Result<Option<Rc<Layer>>, LoadError> {
        let key = (folder.to_owned(), asset.to_owned());
        if let Some(known) = self.known.get(&key) {
            return Ok(known.clone());
        }
        let limit = self.context.limits.nodes;
        let count = (self.known.len() as u64).saturating_add(1);
        Limits::check(|| format!("{FORMAT}: the number of layers"), count, limit, "nodes")?;
        let layer = match self.read(folder, asset) {
            Ok(layer) => Some(layer),
            Err(error) if error.is_partial() => {
                let asset = quoted(asset.as_bytes());
                self.say(|| format!("{FORMAT}: layer {asset} is left out: {}", error.reason()));
                None
            }
            Err(error) => return Err(error),
        };
        self.known.insert(key, layer.clone());
        Ok(layer)
    }

    fn read(&mut self, folder: &str, asset: &str) -> Result<Rc<Layer>, LoadError> {
        let name = asset.split(":SDF_FORMAT_ARGS:").next().unwrap_or_default();
        if name.contains('[') || name.to_ascii_lowercase().ends_with(".usdz") {
            return Err(LoadError::unsupported(FORMAT, "packages in scenes stay closed"));
        }
        let found = self.nearby.read(self.context, folder, [name], self.context.limits.input_bytes)?;
        if let Some(known) = self.layers.get(&found.name) {
            return Ok(Rc::clone(known));
        }
        self.budget.charge(|| format!("{FORMAT}: layers"), found.bytes.len() as u64, 1)?;
        let mut layer = match self.document(&found.name, &found.bytes)? {
            Some(layer) => layer,
            None => read_layer(&found.bytes, self.context, &mut self.budget, &mut self.warnings)?,
        };
        layer.name = found.name;
        let layer = Rc::new(layer);
        self.layers.insert(layer.name.clone(), Rc::clone(&layer));
        Ok(layer)
    }

    /// A layer and its sublayers, strongest first. Sublayers that contain themselves end there.
    pub(super) fn with_sublayers(&mut self, layer: &Rc<Layer>) -> Result<Vec<Rc<Layer>>, LoadError> {
        let mut out = Vec::new();
        self.add_sublayers(layer, &mut out, &mut Vec::new())?;
        Ok(out)
    }

    fn add_sublayers(
        &mut self,
        layer: &Rc<Layer>,
        out: &mut Vec<Rc<Layer>>,
        above: &mut Vec<String>,
    ) -> Result<(), LoadError> {
        if above.contains(&layer.name) || above.len() >= DEPTH || out.len() >= LAYERS {
            let name = quoted(layer.name.as_bytes());
            self.say(|| {
                format!("{FORMAT}: sublayer {name} that contains itself, or is one too many, is left out")
            });
            return Ok(());
        }
        out.push(Rc::clone(layer));
        above.push(layer.name.clone());
        for asset in &layer.sublayers {
            if let Some(below) = self.layer(folder_of(&layer.name), asset)? {
                self.add_sublayers(&below, out, above)?;
            }
        }
        above.pop();
        Ok(())
    }
}
