//! Composition of layers into prims: sublayers, inherits, variants, references, payloads and specializes, each weaker than the
//! ones before (OpenUSD's documentation, "LIVERPS").
//!
//! A prim is the list of its sites, strongest first: places in layer stacks whose opinions it has. Arcs are followed once for each
//! prim; one that leads back to where it comes from is left out.

use super::FORMAT;
use super::files::Files;
use super::layer::{Layer, ListOp, Prim, Reference, Specifier, Value, check_depth, joined};
use crate::LoadError;
use crate::nearby::folder_of;
use crate::text::quoted;
use overcoat_core::limits::Limits;
use std::cell::OnceCell;
use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;

/// Arcs and variants that follow each other at most.
const ARCS: usize = 64;

/// Step of a path from one namespace to the next.
#[derive(Debug)]
struct Step {
    /// Layer stack and prim that an arc leads to.
    stack: usize,
    from: String,
    to: String,
    /// Arc within one layer stack: paths outside of the prim stay as they are.
    is_internal: bool,
}

/// Opinions of one layer stack on one prim.
#[derive(Clone, Debug)]
struct Site {
    stack: usize,
    path: Rc<str>,
    /// Strongest first, each with the file of its layer.
    specs: Vec<(Rc<str>, Rc<Prim>)>,
    /// Steps from here to the stage.
    steps: Vec<Rc<Step>>,
}

/// True if a path is a prim or in it.
fn is_within(path: &str, prim: &str) -> bool {
    prim == "/" || path.strip_prefix(prim).is_some_and(|rest| rest.is_empty() || rest.starts_with(['/', '.']))
}

impl Site {
    /// The path on the stage of one in this namespace.
    fn mapped(&self, path: &str) -> Option<String> {
        let mut path = path.to_owned();
        for step in &self.steps {
            if is_within(&path, &step.from) {
                path = format!("{}{}", step.to, path.strip_prefix(&step.from)?);
            } else if !step.is_internal {
                return None;
            }
        }
        Some(path)
    }
}

/// Prims in order, and their places by name.
type Children = (Vec<Rc<Composed>>, BTreeMap<String, usize>);

/// A prim of the stage.
#[derive(Debug)]
pub(super) struct Composed {
    pub(super) path: String,
    sites: Vec<Site>,
    children: OnceCell<Children>,
}

/// Opinion on a property.
#[derive(Clone, Debug, Default)]
pub(super) struct Found {
    pub(super) value: Option<Rc<Value>>,
    /// File of the layer that has the value.
    pub(super) file: Option<Rc<str>>,
    pub(super) is_animated: bool,
    /// Connections or targets, as paths of the stage.
    pub(super) targets: Vec<String>,
    pub(super) interpolation: Option<String>,
    pub(super) color_space: Option<String>,
}

impl Composed {
    fn specs(&self) -> impl DoubleEndedIterator<Item = &Rc<Prim>> {
        self.sites.iter().flat_map(|site| site.specs.iter().map(|(_, spec)| spec))
    }

    pub(super) fn name(&self) -> &str {
        self.path.rsplit('/').next().unwrap_or_default()
    }

    pub(super) fn type_name(&self) -> &str {
        self.specs().map(|spec| spec.type_name.as_str()).find(|name| !name.is_empty()).unwrap_or_default()
    }

    /// True if it is defined, active and no class.
    pub(super) fn is_drawn(&self) -> bool {
        let defining = self.specs().map(|spec| spec.specifier).find(|&s| s != Specifier::Over);
        let active = self.specs().find_map(|spec| spec.active).unwrap_or(true);
        active && defining == Some(Specifier::Def)
    }

    /// Tells prims with the same opinions: the places of these in memory.
    pub(super) fn identity(&self) -> Vec<usize> {
        self.specs()
            .filter(|spec| !spec.properties.is_empty())
            .map(|spec| std::ptr::from_ref(&**spec).addr())
            .collect()
    }

    /// Names of properties.
    pub(super) fn property_names(&self) -> BTreeSet<&str> {
        self.specs().flat_map(|spec| spec.properties.keys().map(String::as_str)).collect()
    }

    pub(super) fn property(&self, name: &str) -> Option<Found> {
        let mut found = Found::default();
        let mut is_there = false;
        let mut edits: Vec<(&Site, &ListOp<String>)> = Vec::new();
        for site in &self.sites {
            for (file, spec) in &site.specs {
                let Some(property) = spec.properties.get(name) else { continue };
                is_there = true;
                if let (None, Some(value)) = (&found.value, &property.value) {
                    found.value = Some(Rc::clone(value));
                    found.file = Some(Rc::clone(file));
                    found.is_animated = property.samples > 1;
                }
                if found.interpolation.is_none() {
                    found.interpolation.clone_from(&property.interpolation);
                }
                if found.color_space.is_none() {
                    found.color_space.clone_from(&property.color_space);
                }
                if !property.targets.is_empty() {
                    edits.push((site, &property.targets));
                }
            }
        }
        for (site, edit) in edits.into_iter().rev() {
            edit.map(|path| site.mapped(path)).apply(&mut found.targets);
        }
        if found.value.as_deref() == Some(&Value::Block) {
            found.value = None;
        }
        is_there.then_some(found)
    }

    /// Value of an attribute.
    pub(super) fn value(&self, name: &str) -> Option<Rc<Value>> {
        let specs = || self.specs().filter_map(|spec| spec.properties.get(name)?.value.as_ref());
        specs().next().filter(|value| ***value != Value::Block).map(Rc::clone)
    }

    pub(super) fn number(&self, name: &str) -> Option<f64> {
        self.value(name)?.doubles().first().copied()
    }

    pub(super) fn text(&self, name: &str) -> Option<String> {
        self.value(name)?.text().map(str::to_owned)
    }
}

/// Layers and prims of a scene.
pub(super) struct Stage<'c> {
    pub(super) files: Files<'c>,
    /// Layers, strongest first.
    stacks: Vec<Vec<Rc<Layer>>>,
    /// By the file of the first layer.
    by_file: BTreeMap<String, usize>,
    /// Sites of prims within their own layer stack.
    known: BTreeMap<(usize, String), Rc<Vec<Site>>>,
    root: Rc<Composed>,
    prims: u64,
}

impl<'c> Stage<'c> {
    /// The stage of a layer and its sublayers.
    pub(super) fn new(mut files: Files<'c>, layer: Layer) -> Result<Self, LoadError> {
        let layers = files.with_sublayers(&Rc::new(layer))?;
        let root = Rc::new(Composed { path: "/".to_owned(), sites: Vec::new(), children: OnceCell::new() });
        let name = layers.first().map(|layer| layer.name.clone()).unwrap_or_default();
        let mut stage = Self {
            files,
            stacks: vec![layers],
            by_file: BTreeMap::from([(name, 0)]),
            known: BTreeMap::new(),
            root,
            prims: 0,
        };
        let sites = vec![stage.root_site(0)];
        stage.root = Rc::new(Composed { path: "/".to_owned(), sites, children: OnceCell::new() });
        Ok(stage)
    }

    pub(super) fn root(&self) -> Rc<Composed> {
        Rc::clone(&self.root)
    }

    /// Says what a layer of the root says about all.
    pub(super) fn setting<T>(&self, of: impl Fn(&Layer) -> Option<T>) -> Option<T> {
        // Settings of sublayers have no effect.
        self.stacks.first()?.first().and_then(|layer| of(layer))
    }

    fn root_site(&self, stack: usize) -> Site {
        let layers = self.stacks.get(stack).map(Vec::as_slice).unwrap_or_default();
        let specs = layers.iter().map(|layer| (layer.name.as_str().into(), Rc::clone(&layer.root)));
        Site { stack, path: "/".into(), specs: specs.collect(), steps: Vec::new() }
    }

    /// Children of sites by name, and their names in order.
    fn below(sites: &[Site]) -> (Vec<String>, BTreeMap<String, Vec<Site>>) {
        let mut all: BTreeMap<String, Vec<Site>> = BTreeMap::new();
        for site in sites {
            let mut own: BTreeMap<&str, Site> = BTreeMap::new();
            for (file, spec) in &site.specs {
                for child in &spec.children {
                    let entry = own.entry(&child.name).or_insert_with(|| Site {
                        stack: site.stack,
                        path: joined(&site.path, &child.name).into(),
                        specs: Vec::new(),
                        steps: site.steps.clone(),
                    });
                    entry.specs.push((Rc::clone(file), Rc::clone(child)));
                }
            }
            for (name, child) in own {
                all.entry(name.to_owned()).or_default().push(child);
            }
        }
        let mut order = Vec::new();
        let mut seen: BTreeSet<&str> = BTreeSet::new();
        for (_, spec) in sites.iter().rev().flat_map(|site| site.specs.iter().rev()) {
            let names = spec.children.iter().map(|child| child.name.as_str());
            order.extend(names.filter(|name| seen.insert(name)).map(str::to_owned));
        }
        (order, all)
    }

    /// Children of a prim.
    pub(super) fn children(&mut self, prim: &Composed) -> Result<Vec<Rc<Composed>>, LoadError> {
        if let Some((children, _)) = prim.children.get() {
            return Ok(children.clone());
        }
        let (order, mut below) = Self::below(&prim.sites);
        let mut children = Vec::new();
        let mut places = BTreeMap::new();
        let depth = prim.path.matches('/').count() as u64;
        check_depth("prims", depth, self.files.context.limits)?;
        for name in order {
            let Some(sites) = below.remove(&name) else { continue };
            let path = joined(&prim.path, &name);
            self.prims = self.prims.saturating_add(1);
            let limit = self.files.context.limits.nodes;
            Limits::check(|| format!("{FORMAT}: the number of prims"), self.prims, limit, "nodes")?;
            let sites = self.expanded(sites, &mut Vec::new())?;
            places.insert(name, children.len());
            children.push(Rc::new(Composed { path, sites, children: OnceCell::new() }));
        }
        _ = prim.children.set((children.clone(), places));
        Ok(children)
    }

    /// The prim of a path.
    pub(super) fn at(&mut self, path: &str) -> Result<Option<Rc<Composed>>, LoadError> {
        let mut prim = self.root();
        let path = path.split('.').next().unwrap_or_default();
        for name in path.split('/').filter(|name| !name.is_empty()) {
            self.children(&prim)?;
            let next =
                prim.children.get().and_then(|(list, places)| list.get(*places.get(name)?)).map(Rc::clone);
            match next {
                Some(next) => prim = next,
                None => return Ok(None),
            }
        }
        Ok(Some(prim))
    }

    /// Sites, each followed by those that its arcs lead to.
    fn expanded(
        &mut self,
        sites: Vec<Site>,
        active: &mut Vec<(usize, String)>,
    ) -> Result<Vec<Site>, LoadError> {
        let mut out = Vec::new();
        let mut selections = BTreeMap::new();
        for site in sites {
            self.expand(site, &mut selections, &mut out, active)?;
        }
        Ok(out)
    }

    fn expand(
        &mut self,
        site: Site,
        selections: &mut BTreeMap<String, String>,
        out: &mut Vec<Site>,
        active: &mut Vec<(usize, String)>,
    ) -> Result<(), LoadError> {
        let size = (site.path.len() as u64).saturating_add(128).saturating_add(site.steps.len() as u64);
        self.files.budget.charge(|| format!("{FORMAT}: composed prims"), size, 1)?;
        for (set, chosen) in site.specs.iter().flat_map(|(_, spec)| &spec.selections) {
            selections.entry(set.clone()).or_insert_with(|| chosen.clone());
        }
        out.push(site.clone());
        for path in edited(&site, |spec| &spec.inherits) {
            self.arc(&site, site.stack, path, selections, out, active)?;
        }
        let sets: BTreeSet<&String> = site.specs.iter().flat_map(|(_, spec)| spec.variants.keys()).collect();
        for set in sets {
            let Some(chosen) = selections.get(set) else { continue };
            let own = |spec: &Rc<Prim>| spec.variants.get(set)?.get(chosen).map(Rc::clone);
            let specs = site.specs.iter().filter_map(|(file, spec)| Some((Rc::clone(file), own(spec)?)));
            let inner = Site { specs: specs.collect(), ..site.clone() };
            if !inner.specs.is_empty() && active.len() < ARCS {
                // No arc of its own, but a variant can have variants.
                active.push((usize::MAX, set.clone()));
                self.expand(inner, selections, out, active)?;
                active.pop();
            }
        }
        let references = placed(&site, |spec| &spec.references);
        let payloads = placed(&site, |spec| &spec.payloads);
        for (folder, Reference { asset, path }) in references.into_iter().chain(payloads) {
            let stack = if asset.is_empty() { Some(site.stack) } else { self.stack(&folder, &asset)? };
            if let Some(stack) = stack {
                self.arc(&site, stack, path, selections, out, active)?;
            }
        }
        for path in edited(&site, |spec| &spec.specializes) {
            self.arc(&site, site.stack, path, selections, out, active)?;
        }
        Ok(())
    }

    /// Follows an arc; an empty path is that of the default prim.
    fn arc(
        &mut self,
        site: &Site,
        stack: usize,
        path: String,
        selections: &mut BTreeMap<String, String>,
        out: &mut Vec<Site>,
        active: &mut Vec<(usize, String)>,
    ) -> Result<(), LoadError> {
        let path = if path.is_empty() || path == "/" {
            let first = self.stacks.get(stack).and_then(|layers| layers.first());
            let default = first.and_then(|layer| layer.default_prim.as_ref());
            let Some(name) = default else {
                self.files.say(|| format!("{FORMAT}: a layer that is referred to has no default prim"));
                return Ok(());
            };
            joined("/", name.trim_start_matches('/'))
        } else {
            path
        };
        let target = (stack, path);
        let is_circle = target.0 == site.stack && is_within(&site.path, &target.1)
            || site.steps.iter().any(|step| step.stack == target.0 && step.from == target.1)
            || active.contains(&target)
            || site.steps.len() >= ARCS
            || active.len() >= ARCS;
        if is_circle {
            let path = quoted(target.1.as_bytes());
            self.files
                .say(|| format!("{FORMAT}: a reference to {path} that leads back to itself is left out"));
            return Ok(());
        }
        active.push(target.clone());
        let found = self.sites_at(&target, active)?;
        if found.is_empty() {
            let path = quoted(target.1.as_bytes());
            self.files.say(|| format!("{FORMAT}: there is no prim {path} to refer to"));
        }
        let (stack, path) = target;
        let is_internal = stack == site.stack;
        let step = Rc::new(Step { stack, from: path, to: site.path.to_string(), is_internal });
        for inner in found.iter() {
            let mut inner = inner.clone();
            inner.steps.push(Rc::clone(&step));
            inner.steps.extend(site.steps.iter().map(Rc::clone));
            self.expand(inner, selections, out, active)?;
        }
        active.pop();
        Ok(())
    }

    /// Sites of a prim in its own layer stack, before its own arcs are followed.
    fn sites_at(
        &mut self,
        target: &(usize, String),
        active: &mut Vec<(usize, String)>,
    ) -> Result<Rc<Vec<Site>>, LoadError> {
        if let Some(known) = self.known.get(target) {
            return Ok(Rc::clone(known));
        }
        let mut sites = vec![self.root_site(target.0)];
        for (depth, name) in target.1.split('/').filter(|name| !name.is_empty()).enumerate() {
            if depth > 0 {
                sites = self.expanded(sites, active)?;
            }
            sites = Self::below(&sites).1.remove(name).unwrap_or_default();
        }
        let sites = Rc::new(sites);
        self.known.insert(target.clone(), Rc::clone(&sites));
        Ok(sites)
    }

    /// The layer stack of a file.
    fn stack(&mut self, folder: &str, asset: &str) -> Result<Option<usize>, LoadError> {
        let Some(layer) = self.files.layer(folder, asset)? else { return Ok(None) };
        if let Some(known) = self.by_file.get(&layer.name) {
            return Ok(Some(*known));
        }
        let layers = self.files.with_sublayers(&layer)?;
        let stack = self.stacks.len();
        self.stacks.push(layers);
        self.by_file.insert(layer.name.clone(), stack);
        Ok(Some(stack))
    }
}

/// The list that the specs of a site edit together.
fn edited<T: Clone + Ord>(site: &Site, list: impl Fn(&Prim) -> &ListOp<T>) -> Vec<T> {
    let mut out = Vec::new();
    for (_, spec) in site.specs.iter().rev() {
        list(spec).apply(&mut out);
    }
    out
}

/// References with the folders of the files that have them.
fn placed(site: &Site, list: impl Fn(&Prim) -> &ListOp<Reference>) -> Vec<(String, Reference)> {
    let mut out = Vec::new();
    for (file, spec) in site.specs.iter().rev() {
        list(spec).map(|reference| Some((folder_of(file).to_owned(), reference.clone()))).apply(&mut out);
    }
    out
}
