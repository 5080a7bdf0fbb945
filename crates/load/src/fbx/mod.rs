//! FBX of Autodesk, versions 6 and 7, binary or as text: models with their meshes and materials, as they stand.
//!
//! Models stand where translation, rotation, scale and pivots of the file have them, skins in the pose of their bones, shapes by
//! their weights; animation, cameras and lights have no effect. Units become metres, and axes are those of the file's settings.

mod ascii;
mod binary;
mod deform;
mod document;
mod geometry;
mod hierarchy;
mod material;
mod record;
#[cfg(test)]
mod tests;
mod texture;
mod transform;

use super::budget::Budget;
use super::grouped::Grouped;
use super::mesh_formats::{add_placed, check_input, default_material, finish, white_material};
use super::normals::{add_missing_normals, add_smooth_normals};
use super::shares::Shares;
use super::splitting::split;
use super::tangents::{UvSet, add_tangents, tangent_set};
use super::text::quoted;
use super::warnings::{Warnings, counted};
use super::{Context, LoadError, Loaded, TextureLoading};
use document::{Document, Kind, Object};
use geometry::Geometry;
use hierarchy::Stand;
use overcoat_core::limits::Limits;
use overcoat_scene::{CREASE_ANGLE, MaterialId, Mesh, MeshData, MeshId, Scene, Transform};
use record::{FORMAT, File};
use std::collections::{BTreeMap, BTreeSet};
use texture::Textures;

/// Oldest version that is read.
const OLDEST: u32 = 6000;

/// True if a file is one of this format.
pub(crate) fn is_one(bytes: &[u8]) -> bool {
    bytes.starts_with(binary::MAGIC) || ascii::is_one(bytes)
}

/// Resources of reading a file.
struct Loading<'a> {
    context: &'a Context<'a>,
    textures: TextureLoading,
    budget: Budget,
    warnings: Warnings,
}

/// Reads a file, and the textures that it names.
pub(crate) fn load(
    bytes: &[u8],
    context: &Context<'_>,
    textures: TextureLoading,
    shares: &Shares,
) -> Result<Loaded, LoadError> {
    check_input(context, bytes)?;
    let mut budget = Budget::shared(context.limits, shares);
    let file = if bytes.starts_with(binary::MAGIC) {
        binary::read(bytes, context, &mut budget)?
    } else {
        ascii::read(bytes, context, &mut budget)?
    };
    check(&file)?;
    let document = Document::new(&file, context.limits.nodes, &mut budget)?;
    let mut loading = Loading { context, textures, budget, warnings: Warnings::default() };
    if !document.is_connected {
        return Err(LoadError::malformed(FORMAT, "it ends early: there is no list of connections"));
    }
    if file.cut {
        loading
            .warnings
            .add(|| format!("{FORMAT}: the file ends early or has records that do; what is there is drawn"));
    }
    let (up, axes) = transform::axes(&document.settings).unwrap_or_else(|| {
        loading.warnings.add(|| format!("{FORMAT}: the axes of the file are none: +Y is taken as up"));
        (overcoat_scene::Axis::PositiveY, Transform::IDENTITY)
    });
    // Units are those of centimetres.
    let unit = document.settings.number("UnitScaleFactor").filter(|unit| *unit > 0.0).unwrap_or(1.0) * 0.01;
    let root =
        Transform::scaling(unit).and_then(|unit| axes.after(&unit)).map_err(LoadError::scene("FBX: unit"))?;
    let mut builder = Builder {
        stands: hierarchy::stands(&document),
        traits: traits(&document),
        document: &document,
        root,
        loading,
        scene: Scene::new(),
        textures: Textures::default(),
        meshes: BTreeMap::new(),
        materials: BTreeMap::new(),
        used: [0; 2],
        bad: 0,
    };
    builder.build()?;
    let Builder { mut scene, mut loading, bad, .. } = builder;
    if bad > 0 {
        let bad = counted(bad, "polygon");
        loading
            .warnings
            .add(|| format!("{FORMAT}: {bad} left out: vertices missing, not finite or beyond 1e15"));
    }
    warn_of_the_rest(&document, &file, &mut loading.warnings);
    let bounds = scene.bounds();
    if bounds.is_far() {
        scene.move_origin(bounds.round_center());
    }
    Ok(Loaded { up: Some(up), ..finish(scene, loading.warnings.finish()) })
}

fn check(file: &File<'_>) -> Result<(), LoadError> {
    if file.version < OLDEST {
        let message = if file.version == 0 {
            "it does not say of which version it is".to_owned()
        } else {
            format!("version {} is too old: versions from {OLDEST} on are read", file.version)
        };
        return Err(LoadError::unsupported(FORMAT, message));
    }
    Ok(())
}

/// Names what has no effect.
fn warn_of_the_rest(document: &Document<'_>, file: &File<'_>, warnings: &mut Warnings) {
    let count = |wanted: &dyn Fn(&Object<'_>) -> bool| {
        document.objects.iter().filter(|object| wanted(object)).count() as u64
    };
    // Cameras of the editor's own views are in every old file.
    let of_class = |class: &'static [u8]| {
        count(&|object| {
            let is_node = object.kind == Kind::Attribute || file.version < 7000 && object.kind == Kind::Model;
            is_node && object.class == class && !object.name.starts_with("Producer ")
        })
    };
    let is_curve = |object: &Object<'_>| {
        object.kind == Kind::Geometry && matches!(object.class, b"NurbsCurve" | b"Line" | b"Boundary")
    };
    let is_surface = |object: &Object<'_>| {
        let is_other = !matches!(object.class, b"Mesh" | b"Shape");
        object.kind == Kind::Geometry && is_other && !is_curve(object)
    };
    let lost = [
        (of_class(b"Camera"), "camera"),
        (of_class(b"Light"), "light"),
        (count(&is_curve), "curve"),
        (count(&is_surface), "curved surface"),
    ];
    let lost: Vec<String> =
        lost.iter().filter(|(count, _)| *count > 0).map(|(count, what)| counted(*count, what)).collect();
    if !lost.is_empty() {
        warnings.add(|| format!("{FORMAT}: left out: {}", lost.join(", ")));
    }
    let smooth = count(&|object| {
        object.record.child("Smoothness").and_then(|record| record.integer(0)).is_some_and(|level| level > 0)
    });
    if smooth > 0 {
        warnings.add(|| format!("{FORMAT}: meshes drawn without subdivision: {smooth}"));
    }
    let twisted =
        count(&|object| matches!(object.record.text_of("SkinningType"), Some(b"DualQuaternion" | b"Blend")));
    if twisted > 0 {
        warnings.add(|| format!("{FORMAT}: skins of dual quaternions drawn as linear ones: {twisted}"));
    }
    if file.is_animated {
        warnings.add(|| format!("{FORMAT}: animations have no effect"));
    }
}

/// Key of a mesh: its object, and the coordinates that its tangents follow.
type MeshKey = (usize, Option<usize>);

/// Key of a material: its object, the second set of texture coordinates and the picture of the model.
type MaterialKey = (Option<usize>, Vec<u8>, Option<usize>);

/// Parts of a mesh by the numbers of their materials. True if they are in the world.
type Parts = (Vec<(u32, MeshId)>, bool);

/// Properties of an object that is a mesh, found once.
#[derive(Clone, Copy, Default)]
struct Traits<'r> {
    is_mesh: bool,
    has_colors: bool,
    /// Name of the second set of texture coordinates, if any texture uses one of that name.
    second: &'r [u8],
}

/// A model that is drawn.
struct Model {
    /// Its name in messages.
    element: String,
    stand: Stand,
    /// The transform of its geometry alone.
    shape: Transform,
    /// Materials in the order of their numbers.
    materials: Vec<usize>,
    picture: Option<usize>,
    /// Materials of the scene, by the second set of texture coordinates.
    looks: BTreeMap<Vec<u8>, Look>,
}

/// Materials of a model in the scene.
#[derive(Default)]
struct Look {
    materials: Vec<MaterialId>,
    /// Coordinates that their tangents follow.
    tangents: Option<usize>,
}

/// Known properties of each object as a mesh.
fn traits<'r>(document: &'r Document<'r>) -> Vec<Traits<'r>> {
    let textures = document.objects.iter().filter(|object| object.kind == Kind::Texture);
    let used: BTreeSet<&[u8]> = textures.filter_map(|texture| texture.properties.text("UVSet")).collect();
    let of = |object: &'r Object<'r>| {
        let second = geometry::uv_names(object.record).nth(1).filter(|name| used.contains(name));
        Traits {
            is_mesh: object.record.child("PolygonVertexIndex").is_some(),
            has_colors: object.record.child("LayerElementColor").is_some(),
            second: second.unwrap_or_default(),
        }
    };
    document.objects.iter().map(of).collect()
}

struct Builder<'r> {
    document: &'r Document<'r>,
    traits: Vec<Traits<'r>>,
    stands: Vec<Option<Stand>>,
    /// From the file's units and axes.
    root: Transform,
    loading: Loading<'r>,
    scene: Scene,
    textures: Textures,
    meshes: BTreeMap<MeshKey, Parts>,
    materials: BTreeMap<MaterialKey, MaterialId>,
    /// Triangles and vertices of all meshes.
    used: [u64; 2],
    bad: u64,
}

impl<'r> Builder<'r> {
    fn build(&mut self) -> Result<(), LoadError> {
        let mut lost = 0_u64;
        for (number, object) in self.document.objects.iter().enumerate() {
            if object.kind != Kind::Model {
                continue;
            }
            let Some(stand) = self.stands.get(number).copied().flatten() else {
                lost = lost.saturating_add(1);
                continue;
            };
            if stand.is_shown {
                self.model(number, object, &stand)?;
            }
        }
        if lost > 0 {
            let models = counted(lost, "model");
            self.loading
                .warnings
                .add(|| format!("{FORMAT}: {models} left out: below themselves, or moved too far"));
        }
        Ok(())
    }

    /// Draws the meshes of a model.
    fn model(&mut self, number: usize, object: &'r Object<'r>, stand: &Stand) -> Result<(), LoadError> {
        let document = self.document;
        let own = Some((number, object)).into_iter();
        let meshes: Vec<(usize, &Object<'_>)> = own
            .chain(document.linked(number, Kind::Geometry))
            .filter(|(number, _)| self.traits.get(*number).is_some_and(|traits| traits.is_mesh))
            .collect();
        if meshes.is_empty() {
            return Ok(());
        }
        let name = quoted(object.name.as_bytes());
        let mut model = Model {
            element: format!("{FORMAT}: model {name}"),
            stand: *stand,
            shape: transform::geometric(&object.properties).unwrap_or(Transform::IDENTITY),
            materials: document.linked(number, Kind::Material).map(|(number, _)| number).collect(),
            picture: document.linked(number, Kind::Texture).next().map(|(picture, _)| picture),
            looks: BTreeMap::new(),
        };
        meshes.into_iter().try_for_each(|mesh| self.mesh(&mut model, mesh))
    }

    fn mesh(&mut self, model: &mut Model, (number, mesh): (usize, &'r Object<'r>)) -> Result<(), LoadError> {
        let Some(Traits { second, has_colors, .. }) = self.traits.get(number).copied() else { return Ok(()) };
        // The need of tangents must be known before a mesh is read.
        if !model.looks.contains_key(second) {
            let look = self.look(model, second)?;
            model.looks.insert(second.to_vec(), look);
        }
        let Some(Look { materials, tangents }) = model.looks.get(second) else { return Ok(()) };
        let key = (number, *tangents);
        if !self.meshes.contains_key(&key) {
            let placed = [&model.stand.placement.world, &model.shape];
            let parts = self.read(&model.element, (number, mesh), placed, *tangents)?;
            self.meshes.insert(key, parts);
        }
        let Some((parts, in_world)) = self.meshes.get(&key).cloned() else { return Ok(()) };
        let element = &model.element;
        let placed = if in_world {
            Ok(self.root)
        } else {
            self.root.after(&model.stand.placement.world).and_then(|world| world.after(&model.shape))
        };
        let Ok(placed) = placed else {
            self.loading.warnings.add(|| format!("{element} is moved too far and left out"));
            return Ok(());
        };
        let first = self.scene.instances().len();
        let count = first.saturating_add(parts.len()) as u64;
        let limit = self.loading.context.limits.nodes;
        Limits::check(|| format!("{FORMAT}: the number of parts"), count, limit, "nodes")?;
        for (slot, mesh) in parts {
            let material = match materials.get(slot as usize) {
                Some(id) => *id,
                None => self.without_material(has_colors)?,
            };
            add_placed(&mut self.scene, element, mesh, material, placed, first as u32)?;
        }
        Ok(())
    }

    /// The materials of a model for meshes with such a second set of texture coordinates.
    fn look(&mut self, model: &Model, second: &[u8]) -> Result<Look, LoadError> {
        let mut look = Look::default();
        for &number in &model.materials {
            let id = self.material(number, second, model.picture)?;
            let set = self.scene.materials().get(id.index()).and_then(tangent_set);
            look.tangents = look.tangents.or(set.map(UvSet::index));
            look.materials.push(id);
        }
        Ok(look)
    }

    /// Reads a mesh, deforms it and cuts it by its materials.
    /// A skin stands where its bones are, whichever model has it.
    fn read(
        &mut self,
        element: &str,
        (number, object): (usize, &Object<'_>),
        placed: [&Transform; 2],
        tangents: Option<usize>,
    ) -> Result<Parts, LoadError> {
        let Loading { context, budget, .. } = &mut self.loading;
        let mut geometry = geometry::read(object.record, context.limits, &mut self.used, budget)?;
        self.bad = self.bad.saturating_add(geometry.bad);
        deform::shapes(self.document, number, &mut geometry, budget)?;
        let world = |bone: usize| Some(self.stands.get(bone)?.as_ref()?.placement.world);
        let in_world = deform::skin(self.document, number, &mut geometry, placed, world, budget)?;
        let data = &mut geometry.data;
        let missing: Vec<bool> = data.normals.iter().map(|n| n.iter().all(|&v| v == 0.0)).collect();
        if missing.iter().all(|&missing| missing) {
            add_smooth_normals(data, CREASE_ANGLE, context.jobs);
        } else if missing.contains(&true) {
            add_missing_normals(data, CREASE_ANGLE, |v| missing.get(v) == Some(&true), context.jobs);
        }
        let mut parts = Vec::new();
        by_material(geometry, |slot, mut data| {
            if let Some(set) = tangents {
                add_tangents(&mut data, set);
            }
            let mesh = Mesh::new(data).map_err(LoadError::scene(element))?;
            parts.push((slot, self.scene.add_mesh(mesh).map_err(LoadError::scene(element))?));
            Ok(())
        })?;
        Ok((parts, in_world))
    }

    fn material(
        &mut self,
        number: usize,
        second: &[u8],
        picture: Option<usize>,
    ) -> Result<MaterialId, LoadError> {
        let key = (Some(number), second.to_vec(), picture);
        if let Some(known) = self.materials.get(&key) {
            return Ok(*known);
        }
        let count = (self.materials.len() as u64).saturating_add(1);
        let limit = self.loading.context.limits.nodes;
        Limits::check(|| format!("{FORMAT}: the number of materials"), count, limit, "nodes")?;
        let made = material::material(
            &mut self.scene,
            self.document,
            number,
            (Some(second).filter(|second| !second.is_empty()), picture),
            &mut self.textures,
            &mut self.loading,
        )?;
        let added = self.scene.add_material(made).map_err(LoadError::scene("FBX: material"))?;
        self.materials.insert(key, added);
        Ok(added)
    }

    /// The material of surfaces without one.
    fn without_material(&mut self, has_colors: bool) -> Result<MaterialId, LoadError> {
        let key = (None, vec![u8::from(has_colors)], None);
        if let Some(known) = self.materials.get(&key) {
            return Ok(*known);
        }
        let material = if has_colors { white_material() } else { default_material() };
        let added = self.scene.add_material(material).map_err(LoadError::scene("FBX: material"))?;
        self.materials.insert(key, added);
        Ok(added)
    }
}

/// Calls `take` with the parts of a mesh and the numbers of their materials.
fn by_material(
    geometry: Geometry,
    mut take: impl FnMut(u32, MeshData) -> Result<(), LoadError>,
) -> Result<(), LoadError> {
    let Geometry { data: whole, slots, .. } = geometry;
    let Some(&first) = slots.first() else { return Ok(()) };
    if slots.iter().all(|slot| *slot == first) {
        return take(first, whole);
    }
    let mut numbers = BTreeMap::new();
    for &slot in &slots {
        let next = numbers.len();
        numbers.entry(slot).or_insert(next);
    }
    let group = |slot: &u32| numbers.get(slot).copied().unwrap_or(usize::MAX);
    let by_slot = Grouped::new(numbers.len(), slots.iter().map(group));
    let mut order: Vec<(usize, u32)> = numbers.into_iter().map(|(slot, group)| (group, slot)).collect();
    order.sort_unstable();
    split(&whole, &by_slot, order.len(), |group, part| {
        order.get(group).map_or(Ok(()), |&(_, slot)| take(slot, part))
    })
}
