//! 3MF: the 3D Manufacturing Format (3MF Consortium, core specification 1.4, materials and properties extension 1.2,
//! production extension 1.2).
//!
//! Items that are built are drawn, each where it stands; units become metres. Z is up in such files, which is turned
//! where all formats are. Supports are drawn, objects of the type "other" are not; if nothing of a file would be built,
//! all its objects are drawn where they are, with a warning. Textures and colours are opaque unless they are layers;
//! colours vary linearly over a triangle, where the specification asks for a variation of their sRGB codes.
//!
//! The specification has no attribute `printable` of items, which PrusaSlicer and those made from it write. An item with
//! `printable="0"` is drawn like the others: it stands on the plate, and these programs draw it too in the pictures that
//! they put into such files.
//!
//! Slicers write what they print into files of their own beside the model: which parts only change the settings of
//! others, and the colours of the filaments (`slicer.rs`). They also paint triangles with them (`paint.rs`), and have
//! several plates in a file, a printer's width apart, which are drawn side by side (`plates.rs`).
mod beams;
mod look;
mod model;
mod paint;
mod parts;
mod plates;
mod property;
mod slicer;

use super::budget::Budget;
use super::mesh_formats::{add_placed, check_input, finish};
use super::origin::{Origin, load_about};
use super::shares::Shares;
use super::warnings::Warnings;
use super::warnings::counted;
use super::{Context, LoadError, LoadOptions, Loaded, TextureLoading};
use crate::archive::{Archive, part_name};
use crate::xml::{Xml, text_of};
use look::Looks;
use model::{Model, Purpose, Totals};
use overcoat_core::limits::Limits;
use overcoat_scene::{MaterialId, MeshId, Scene, Transform};
use slicer::{Part, Settings};
use std::collections::{BTreeMap, BTreeSet};

const FORMAT: &str = "3MF";
/// Relationship of a package to its root model part (core specification, C.2).
const START: &str = "/3dmanufacturing/2013/01/3dmodel";
/// Path of the root model part in nearly all files, related or not.
const USUAL_START: &str = "3D/3dmodel.model";
/// Reason why an object that is never built is not drawn.
const OTHER: &str = "of the type 'other', which is not built";
/// Objects may nest this deep, whatever the limits say.
const DEEPEST: u64 = 1024;

/// Reads a package: the model part that it begins with, and what that refers to.
pub(crate) fn load(
    bytes: &[u8],
    context: &Context<'_>,
    options: &LoadOptions,
    shares: &Shares,
) -> Result<Loaded, LoadError> {
    check_input(context, bytes)?;
    load_about(|region| load_in(bytes, region.is_some(), context, options, shares))
}

/// Reads a package, about an origin of its own if its model is far away.
fn load_in(
    bytes: &[u8],
    far: bool,
    context: &Context<'_>,
    options: &LoadOptions,
    shares: &Shares,
) -> Result<Loaded, LoadError> {
    let mut warnings = Warnings::default();
    let archive = Archive::open(FORMAT, bytes, context.limits, &mut warnings)?;
    let mut budget = Budget::shared(context.limits, shares);
    let start = start_part(&archive, &mut budget)?;
    let settings = Settings::read(&archive, &mut budget, &mut warnings);
    let mut package = Package {
        archive: &archive,
        far,
        models: Vec::new(),
        numbers: BTreeMap::new(),
        vertices: 0,
        triangles: 0,
        elements: 0,
    };
    package.model(&start, context, &mut budget, &mut warnings)?;
    let plates = settings.plates();
    if let (Some(number), Some(first)) = (options.plate, package.models.first_mut()) {
        plates::choose(number, &plates, &mut first.build, &settings)?;
    }
    let mut builder = Builder {
        context,
        loading: options.textures,
        package,
        settings,
        looks: Looks::default(),
        meshes: BTreeMap::new(),
        scene: Scene::new(),
        budget,
        warnings,
        visits: 0,
        triangles: 0,
        left_out: BTreeMap::new(),
        everything: false,
    };
    builder.build()?;
    if options.plate.is_none() {
        builder.put_plates_side_by_side()?;
    }
    let only_others = builder.left_out.keys().all(|&reason| reason == OTHER);
    if builder.scene.instances().is_empty() && only_others && options.plate.is_none() {
        builder.build_everything()?;
    }
    for (what, count) in std::mem::take(&mut builder.left_out) {
        let objects = counted(count, "object");
        builder.warnings.add(|| format!("3MF: {objects} left out: {what}"));
    }
    let bounds = builder.scene.bounds();
    if far && bounds.is_far() {
        builder.scene.move_origin(bounds.round_center());
    }
    Ok(Loaded { plates, ..finish(builder.scene, builder.warnings.finish()) })
}

/// The name of the part that the model begins with.
fn start_part(archive: &Archive<'_>, budget: &mut Budget) -> Result<String, LoadError> {
    let mut found = None;
    if archive.has("_rels/.rels") {
        let bytes = archive.read("_rels/.rels", budget)?;
        let text = text_of(&bytes, "_rels/.rels", budget)?;
        let mut xml = Xml::new(FORMAT, "_rels/.rels", &text);
        xml.root(|xml, _| {
            xml.children(|_, tag| {
                if found.is_none() && tag.attribute("Type").is_some_and(|kind| kind.ends_with(START)) {
                    found = tag.attribute("Target");
                }
                Ok(())
            })
        })?;
    }
    match found {
        Some(found) => Ok(found),
        None if archive.has(USUAL_START) => Ok(USUAL_START.to_owned()),
        None => match archive.find(".model") {
            Some(name) => Ok(name.to_owned()),
            None => Err(LoadError::malformed(FORMAT, "the archive has no 3D model in it")),
        },
    }
}

/// The model parts that have been read.
struct Package<'a> {
    archive: &'a Archive<'a>,
    /// Positions are read in double precision.
    far: bool,
    models: Vec<Model>,
    /// By part name, as names are compared.
    numbers: BTreeMap<String, usize>,
    vertices: u64,
    triangles: u64,
    elements: u64,
}

impl Package<'_> {
    /// The number of a model part, which is read if it has not been.
    fn model(
        &mut self,
        part: &str,
        context: &Context<'_>,
        budget: &mut Budget,
        warnings: &mut Warnings,
    ) -> Result<usize, LoadError> {
        let name = part_name(part);
        if let Some(&number) = self.numbers.get(&name) {
            return Ok(number);
        }
        let bytes = self.archive.read(part, budget)?;
        let text = text_of(&bytes, part, budget)?;
        let mut totals = Totals {
            context,
            far: self.far,
            budget,
            warnings,
            vertices: self.vertices,
            triangles: self.triangles,
            elements: self.elements,
        };
        let model = Model::read(part, &text, &mut totals)?;
        (self.vertices, self.triangles, self.elements) = (totals.vertices, totals.triangles, totals.elements);
        let number = self.models.len();
        self.models.push(model);
        self.numbers.insert(name, number);
        Ok(number)
    }
}

/// An object that is to be placed.
#[derive(Clone)]
struct Visit {
    model: usize,
    object: u32,
    /// From the object's units to the scene.
    transform: Transform,
    depth: u64,
    /// The item that it belongs to.
    item: u32,
    /// Settings of the slicer for it.
    part: Part,
}

/// The meshes of an object, and what they are made of.
type Drawn = Vec<(MeshId, MaterialId)>;

/// Puts what is built into a scene.
struct Builder<'a> {
    context: &'a Context<'a>,
    loading: TextureLoading,
    package: Package<'a>,
    settings: Settings,
    looks: Looks,
    /// By model part, object, and extruder where the slicer's settings colour it.
    meshes: BTreeMap<(usize, u32, Option<u32>), Drawn>,
    scene: Scene,
    budget: Budget,
    warnings: Warnings,
    visits: u64,
    /// Every instance counted.
    triangles: u64,
    /// Objects that are not drawn, by the reason.
    left_out: BTreeMap<&'static str, u64>,
    /// Also objects that are never built.
    everything: bool,
}

impl Builder<'_> {
    fn build(&mut self) -> Result<(), LoadError> {
        let Some(first) = self.package.models.first() else { return Ok(()) };
        self.build_all(first.unit, first.build.clone())
    }

    fn put_plates_side_by_side(&mut self) -> Result<(), LoadError> {
        let Some(first) = self.package.models.first() else { return Ok(()) };
        let plates = plates::of_items(&first.build, &self.settings);
        if plates.is_empty() { Ok(()) } else { plates::arrange(&mut self.scene, &plates) }
    }

    /// Places every object that is no component of another, for want of anything that is to be built.
    fn build_everything(&mut self) -> Result<(), LoadError> {
        let Some(first) = self.package.models.first() else { return Ok(()) };
        let components = first.objects.values().flat_map(|object| &object.components);
        let below: BTreeSet<u32> = components.filter(|c| c.path.is_none()).map(|c| c.object).collect();
        let alone = first.objects.iter().filter(|(id, object)| {
            !below.contains(id) && object.purpose != Purpose::Modifier && object.is_something()
        });
        let transform = Transform::IDENTITY;
        let build: Vec<model::Reference> =
            alone.map(|(&object, _)| model::Reference { object, path: None, transform }).collect();
        if build.is_empty() {
            return Ok(());
        }
        let objects = counted(build.len() as u64, "object");
        self.warnings.add(|| format!("3MF: nothing is to be built: {objects} drawn where they are defined"));
        (self.everything, self.left_out) = (true, BTreeMap::new());
        self.build_all(first.unit, build)
    }

    fn build_all(&mut self, unit: f64, build: Vec<model::Reference>) -> Result<(), LoadError> {
        let metres = Transform::from_parts([0.0; 3], [0.0, 0.0, 0.0, 1.0], [unit; 3])
            .map_err(LoadError::scene("3MF: unit"))?;
        for (item, reference) in build.into_iter().enumerate() {
            let part = self.settings.object(reference.object);
            let visit = self.refer(&reference, 0, &metres, item as u32, 0, part)?;
            self.place(visit)?;
        }
        Ok(())
    }

    /// Visit of the object that a component or an item refers to.
    fn refer(
        &mut self,
        reference: &model::Reference,
        from: usize,
        parent: &Transform,
        item: u32,
        depth: u64,
        part: Part,
    ) -> Result<Visit, LoadError> {
        let element = || format!("3MF: object {}", reference.object);
        let mut model = from;
        let mut transform = parent.after(&reference.transform).map_err(LoadError::scene(element()))?;
        if let Some(path) = &reference.path {
            model = self.package.model(path, self.context, &mut self.budget, &mut self.warnings)?;
            let unit = |number: usize| self.package.models.get(number).map_or(1.0, |model| model.unit);
            let scale = unit(model) / unit(from);
            if scale != 1.0 {
                let scale = Transform::from_parts([0.0; 3], [0.0, 0.0, 0.0, 1.0], [scale; 3]);
                let scale = scale.map_err(LoadError::scene(element()))?;
                transform = transform.after(&scale).map_err(LoadError::scene(element()))?;
            }
        }
        self.visits = self.visits.saturating_add(1);
        let what = || "3MF: the number of placed objects".to_owned();
        Limits::check(what, self.visits, self.context.limits.nodes, "nodes")?;
        Ok(Visit { model, object: reference.object, transform, depth, item, part })
    }

    /// Places an object and its components, in the order of the file.
    fn place(&mut self, first: Visit) -> Result<(), LoadError> {
        let mut stack = vec![first];
        while let Some(visit) = stack.pop() {
            let model = self.package.models.get(visit.model);
            let Some(object) = model.and_then(|model| model.objects.get(&visit.object)) else {
                let object = visit.object;
                self.warnings.add(|| format!("3MF: object {object} is referred to and does not exist"));
                continue;
            };
            let reason = match object.purpose {
                Purpose::Made => visit.part.left_out,
                Purpose::Other if self.everything => None,
                Purpose::Other => Some(OTHER),
                Purpose::Modifier => Some("they only change how others are printed"),
            };
            if let Some(reason) = reason {
                let count = self.left_out.entry(reason).or_default();
                *count = count.saturating_add(1);
                continue;
            }
            let what = || format!("3MF: object {} (or does it contain itself?)", visit.object);
            Limits::check(what, visit.depth, self.context.limits.depth.min(DEEPEST), "depth")?;
            let extruder = object.extruder.or(visit.part.extruder);
            let components = object.components.clone();
            if object.mesh.is_some() {
                self.draw(&visit, extruder)?;
            }
            let mut below = Vec::with_capacity(components.len());
            for component in components {
                let part = self.settings.part(&visit.part, extruder, component.object);
                let depth = visit.depth.saturating_add(1);
                below.push(self.refer(&component, visit.model, &visit.transform, visit.item, depth, part)?);
            }
            stack.extend(below.into_iter().rev());
        }
        Ok(())
    }

    /// Adds the draws of an object with a mesh.
    fn draw(&mut self, visit: &Visit, extruder: Option<u32>) -> Result<(), LoadError> {
        let extruder = extruder.filter(|&e| self.settings.filament(Some(e)).is_some());
        let key = (visit.model, visit.object, extruder);
        if !self.meshes.contains_key(&key) {
            let drawn = self.meshes_of(visit.model, visit.object, extruder)?;
            self.meshes.insert(key, drawn);
        }
        let model = self.package.models.get(visit.model);
        let source = model.and_then(|model| model.objects.get(&visit.object)?.mesh.as_ref());
        let origin = source.map_or(Origin::default(), |mesh| mesh.origin);
        let mut transform = visit.transform;
        if origin != Origin::default() {
            let element = || format!("3MF: object {}", visit.object);
            let moved = Transform::translation(origin.0).and_then(|origin| transform.after(&origin));
            transform = moved.map_err(|e| LoadError::scene(element())(e))?;
        }
        for &(mesh, material) in self.meshes.get(&key).into_iter().flatten() {
            let triangles = self.scene.meshes().get(mesh.index()).map_or(0, |mesh| mesh.triangles().len());
            self.triangles = self.triangles.saturating_add(triangles as u64);
            let what = || "3MF: the triangles of all placed objects".to_owned();
            Limits::check(what, self.triangles, self.context.limits.triangles, "triangles")?;
            let element = format!("3MF: object {}", visit.object);
            add_placed(&mut self.scene, &element, mesh, material, transform, visit.item)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod plate_tests;
#[cfg(test)]
mod tests;
#[cfg(test)]
pub(crate) use tests::{png, zip};
