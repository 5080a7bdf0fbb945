//! AMF, the Additive Manufacturing File Format (ISO/ASTM 52915, version 1.2), plain or in a ZIP archive.
//!
//! Objects are drawn where constellations place them; those that are in none, where they are. Units become metres, and +Z is
//! up. A texture counts for more than the colour of its triangle, that for more than those of its vertices, then come those of
//! volume, object and material. Mixed materials, colours by formula and curved triangles are left out, with a warning.

mod document;
#[cfg(test)]
mod tests;
mod texture;

use super::budget::Budget;
use super::grouped::Grouped;
use super::mesh_formats::{
    add_placed, check_input, default_material, drawable, finish, material_of, white_material,
};
use super::normals::add_smooth_normals;
use super::origin::Origin;
use super::shares::Shares;
use super::splitting::{Copies, split};
use super::warnings::{Warnings, counted};
use super::xml::text_of;
use super::{Context, LoadError, Loaded};
use document::{Color, Document, Map, Object, Placed, Reader, Uvs, Volume};
use overcoat_core::limits::Limits;
use overcoat_scene::{
    AlphaMode, Bounds, CREASE_ANGLE, Material, MaterialId, Mesh, MeshData, MeshId, Scene, TextureRef,
    Transform, UvTransform,
};
use std::collections::{BTreeMap, BTreeSet};

const FORMAT: &str = "AMF";
/// Constellations may nest this deep, whatever the limits say.
const DEEPEST: u64 = 256;
/// Copies of a vertex that are searched for one of equal colour before another is made: bounds the work.
const SEARCHED: usize = 65;

/// True for the text of such a file.
pub(crate) fn is_one(text: &[u8]) -> bool {
    let head = text.get(..4096).unwrap_or(text);
    let mut places = head.windows(5).filter_map(|word| word.split_last());
    text.starts_with(b"<")
        && places.any(|(after, tag)| {
            tag.eq_ignore_ascii_case(b"<amf") && (after.is_ascii_whitespace() || *after == b'>')
        })
}

/// Reads a file.
pub(crate) fn load(bytes: &[u8], context: &Context<'_>, shares: &Shares) -> Result<Loaded, LoadError> {
    check_input(context, bytes)?;
    let mut budget = Budget::shared(context.limits, shares);
    let mut warnings = Warnings::default();
    let text = text_of(bytes, "", &mut budget)?;
    let document = Reader::new(context, &mut budget, &mut warnings).read(&text)?;
    drop(text);
    let mut builder = Builder {
        context,
        document: &document,
        budget,
        scene: Scene::new(),
        warnings,
        meshes: BTreeMap::new(),
        materials: BTreeMap::new(),
        open: BTreeSet::new(),
        visits: 0,
        triangles: 0,
    };
    builder.build()?;
    let Builder { mut scene, warnings, .. } = builder;
    let bounds = scene.bounds();
    if bounds.is_far() {
        scene.move_origin(bounds.round_center());
    }
    Ok(finish(scene, warnings.finish()))
}

/// Appearance of triangles that share a mesh of the scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Key<'a> {
    /// Without any colour.
    Plain,
    /// One colour, by its bits, and the name of its material.
    Uniform([u32; 4], &'a str),
    /// Colours of corners, some of which may be transparent.
    Painted { blended: bool },
    /// A picture of some textures.
    Mapped(Map),
}

/// Appearance of a triangle: its key, and the colours and coordinates of its corners.
type Look<'a> = (Key<'a>, [Color; 3], Uvs);

/// Coordinates of triangles without texture.
const NOWHERE: Uvs = [[0.0; 2]; 3];

/// An object in the scene: its meshes, and the point that they are relative to.
type Drawn = (Vec<(MeshId, MaterialId)>, Origin);

/// Puts a document into a scene.
struct Builder<'a> {
    context: &'a Context<'a>,
    document: &'a Document,
    budget: Budget,
    scene: Scene,
    warnings: Warnings,
    meshes: BTreeMap<u32, Drawn>,
    materials: BTreeMap<Key<'a>, MaterialId>,
    /// Constellations around the one that is being placed.
    open: BTreeSet<u32>,
    visits: u64,
    /// Every instance counted.
    triangles: u64,
}

impl<'a> Builder<'a> {
    fn build(&mut self) -> Result<(), LoadError> {
        let document = self.document;
        let unit = Transform::scaling(document.unit).map_err(LoadError::scene("AMF: unit"))?;
        let placed = || document.constellations.values().flatten();
        // Some programs number objects and constellations apart: an instance is one of the object, then.
        let inner: BTreeSet<u32> =
            placed().map(|p| p.id).filter(|id| !document.objects.contains_key(id)).collect();
        let outer: BTreeSet<u32> = placed().map(|p| p.id).collect();
        let roots = document.constellations.keys().filter(|id| !inner.contains(id));
        let mut found = false;
        for &id in roots {
            found = true;
            self.constellation(id, &unit, 0)?;
        }
        if !found && !document.constellations.is_empty() {
            let message = "every constellation is part of another: they contain themselves";
            return Err(LoadError::malformed(FORMAT, message));
        }
        for &id in document.objects.keys().filter(|id| !outer.contains(id)) {
            self.object(id, &unit)?;
        }
        Ok(())
    }

    /// Counts what is visited: constellations can place others as often as they like.
    fn visit(&mut self) -> Result<(), LoadError> {
        self.visits = self.visits.saturating_add(1);
        let what = || format!("{FORMAT}: the number of placed objects");
        Ok(Limits::check(what, self.visits, self.context.limits.nodes, "nodes")?)
    }

    fn constellation(&mut self, id: u32, parent: &Transform, depth: u64) -> Result<(), LoadError> {
        let limit = self.context.limits.depth.min(DEEPEST);
        Limits::check(|| format!("{FORMAT}: constellation {id}"), depth, limit, "depth")?;
        let document = self.document;
        if !self.open.insert(id) {
            return Err(LoadError::malformed(FORMAT, format!("constellation {id} contains itself")));
        }
        for placed in document.constellations.get(&id).into_iter().flatten() {
            self.visit()?;
            let moved = transform(placed).and_then(|own| parent.after(&own).ok());
            let Some(moved) = moved else {
                self.warnings
                    .add(|| format!("{FORMAT}: an instance of object {} is moved too far", placed.id));
                continue;
            };
            if document.objects.contains_key(&placed.id) {
                self.object(placed.id, &moved)?;
            } else if document.constellations.contains_key(&placed.id) {
                self.constellation(placed.id, &moved, depth.saturating_add(1))?;
            } else {
                let missing = placed.id;
                self.warnings.add(|| format!("{FORMAT}: object {missing} is referred to and does not exist"));
            }
        }
        self.open.remove(&id);
        Ok(())
    }

    fn object(&mut self, id: u32, transform: &Transform) -> Result<(), LoadError> {
        self.visit()?;
        let element = || format!("{FORMAT}: object {id}");
        let drawn = match self.meshes.get(&id) {
            Some(drawn) => drawn.clone(),
            None => {
                let drawn = self.meshes_of(id)?;
                self.meshes.insert(id, drawn.clone());
                drawn
            }
        };
        let (meshes, origin) = drawn;
        let moved = Transform::translation(origin.0).and_then(|origin| transform.after(&origin));
        let transform = moved.map_err(LoadError::scene(element()))?;
        let number = self.scene.instances().len() as u32;
        for (mesh, material) in meshes {
            let triangles = self.scene.meshes().get(mesh.index()).map_or(0, |mesh| mesh.triangles().len());
            self.triangles = self.triangles.saturating_add(triangles as u64);
            let what = || format!("{FORMAT}: the triangles of all placed objects");
            Limits::check(what, self.triangles, self.context.limits.triangles, "triangles")?;
            add_placed(&mut self.scene, &element(), mesh, material, transform, number)?;
        }
        Ok(())
    }

    /// Adds the meshes of an object: one for each thing that it is made of.
    fn meshes_of(&mut self, id: u32) -> Result<Drawn, LoadError> {
        let document = self.document;
        let Some(object) = document.objects.get(&id) else { return Ok(Drawn::default()) };
        let origin = origin_of(&object.positions);
        let positions: Vec<[f32; 3]> = object.positions.iter().map(|&p| origin.relative(p)).collect();
        let mut data = MeshData::new(positions, Vec::new());
        let (mut looks, mut bad, mut modifiers) = (Vec::new(), 0_u64, 0_u64);
        for volume in &object.volumes {
            if volume.is_modifier {
                modifiers = modifiers.saturating_add(1);
                continue;
            }
            let mut own = volume.colors.iter().peekable();
            let mut maps = volume.maps.iter().peekable();
            for (number, &triangle) in volume.triangles.iter().enumerate() {
                let color = own.next_if(|(of, _)| *of as usize == number).map(|(_, color)| *color);
                let map = maps.next_if(|(of, _, _)| *of as usize == number);
                let placed = |&v: &u32| data.positions.get(v as usize).is_some_and(|&p| drawable(p));
                if triangle.iter().all(placed) {
                    data.triangles.push(triangle);
                    looks.push(match map {
                        Some(&(_, map, uvs)) => (Key::Mapped(map), [[1.0; 4]; 3], uvs),
                        None => self.look(object, volume, triangle, color),
                    });
                } else {
                    bad = bad.saturating_add(1);
                }
            }
        }
        if bad > 0 {
            let bad = counted(bad, "triangle");
            let reason = "vertices that are missing, not finite or beyond 1e15";
            self.warnings.add(|| format!("{FORMAT}: {bad} of object {id} left out: {reason}"));
        }
        if modifiers > 0 {
            let volumes = counted(modifiers, "volume");
            let reason = "they only change how others are printed";
            self.warnings.add(|| format!("{FORMAT}: {volumes} of object {id} left out: {reason}"));
        }
        data.positions.iter_mut().filter(|p| !drawable(**p)).for_each(|p| *p = [0.0; 3]);
        // Before it is cut: a surface may be smooth across a change of colour.
        add_smooth_normals(&mut data, CREASE_ANGLE, self.context.jobs);
        Ok((self.cut(id, data, looks)?, origin))
    }

    /// Appearance of a triangle.
    fn look(&self, object: &Object, volume: &Volume, triangle: [u32; 3], own: Option<Color>) -> Look<'a> {
        let document = self.document;
        let material = volume.material.as_ref().and_then(|id| document.materials.get(id));
        let of_material = material.and_then(|material| material.color);
        let below = volume.color.or(object.color).or(of_material);
        let of_vertex = |v: u32| object.colors.get(v as usize).copied().flatten();
        let of_vertices = triangle.map(of_vertex);
        let corners = match own {
            Some(color) => Some([color; 3]),
            None if of_vertices.iter().any(Option::is_some) => {
                Some(of_vertices.map(|color| color.or(below).unwrap_or([1.0; 4])))
            }
            None => None,
        };
        match (corners, below) {
            (Some(corners), _) => {
                let blended = corners.iter().any(|color| color[3] < 1.0);
                (Key::Painted { blended }, corners, NOWHERE)
            }
            (None, Some(color)) => {
                let name = material.map(|material| material.name.as_str()).unwrap_or_default();
                (Key::Uniform(color.map(f32::to_bits), name), [[1.0; 4]; 3], NOWHERE)
            }
            (None, None) => (Key::Plain, [[1.0; 4]; 3], NOWHERE),
        }
    }

    /// Cuts the mesh of an object into those of the scene, by the looks of its triangles.
    fn cut(
        &mut self,
        id: u32,
        mut data: MeshData,
        looks: Vec<Look<'a>>,
    ) -> Result<Vec<(MeshId, MaterialId)>, LoadError> {
        let mut numbers: BTreeMap<Key<'a>, usize> = BTreeMap::new();
        let mut keys = Vec::new();
        let mut groups = Vec::with_capacity(looks.len());
        let mut copies = Copies::new(data.positions.len(), ([-1.0; 4], [0.0; 2]), SEARCHED);
        for (t, (key, corners, uvs)) in looks.into_iter().enumerate() {
            let Some(&(mut triangle)) = data.triangles.get(t) else { break };
            for (vertex, value) in triangle.iter_mut().zip(corners.into_iter().zip(uvs)) {
                if let Some((copy, _)) = copies.vertex(&mut data, *vertex, value) {
                    *vertex = copy;
                }
            }
            data.triangles.get_mut(t).into_iter().for_each(|own| *own = triangle);
            groups.push(*numbers.entry(key).or_insert_with(|| {
                keys.push(key);
                keys.len().saturating_sub(1)
            }));
        }
        (data.colors, data.uvs[0]) = copies.into_values().into_iter().unzip();
        let groups = Grouped::new(keys.len(), groups.iter().copied());
        let element = format!("{FORMAT}: object {id}");
        let mut drawn = Vec::new();
        split(&data, &groups, keys.len(), |number, mut part| {
            let Some(&key) = keys.get(number) else { return Ok(()) };
            if !matches!(key, Key::Painted { .. }) {
                part.colors = Vec::new();
            }
            if !matches!(key, Key::Mapped(_)) {
                part.uvs = [Vec::new(), Vec::new()];
            }
            let material = self.material(key)?;
            let mesh = Mesh::new(part).map_err(LoadError::scene(element.clone()))?;
            let mesh = self.scene.add_mesh(mesh).map_err(LoadError::scene(element.clone()))?;
            drawn.push((mesh, material));
            Ok::<(), LoadError>(())
        })?;
        Ok(drawn)
    }

    fn material(&mut self, key: Key<'a>) -> Result<MaterialId, LoadError> {
        if let Some(&known) = self.materials.get(&key) {
            return Ok(known);
        }
        let count = (self.materials.len() as u64).saturating_add(1);
        let limit = self.context.limits.nodes;
        Limits::check(|| format!("{FORMAT}: the number of materials"), count, limit, "nodes")?;
        let material = match key {
            Key::Plain => default_material(),
            Key::Mapped(map) => self.mapped(&map)?,
            Key::Uniform(bits, name) => self.uniform(bits.map(f32::from_bits), name),
            Key::Painted { blended } => {
                let mut material = white_material();
                if blended {
                    material.alpha_mode = AlphaMode::Blend;
                }
                material
            }
        };
        let added = self.scene.add_material(material).map_err(LoadError::scene("AMF: material"))?;
        self.materials.insert(key, added);
        Ok(added)
    }

    fn mapped(&mut self, map: &Map) -> Result<Material, LoadError> {
        let count = (self.scene.textures().len() as u64).saturating_add(1);
        let limit = self.context.limits.textures;
        Limits::check(|| format!("{FORMAT}: the number of textures"), count, limit, "textures")?;
        let picture = texture::picture(
            self.document,
            map,
            (self.context.limits, &mut self.budget),
            &mut self.warnings,
        )?;
        let Some((texture, is_blended)) = picture else { return Ok(default_material()) };
        let texture = self.scene.add_texture(texture).map_err(LoadError::scene("AMF: texture"))?;
        let mut material = material_of([1.0; 4]);
        let transform = UvTransform::IDENTITY;
        material.base_color_texture = Some(TextureRef { texture, uv_set: 0, transform });
        if is_blended {
            material.alpha_mode = AlphaMode::Blend;
        }
        Ok(material)
    }

    fn uniform(&mut self, mut color: Color, name: &str) -> Material {
        if color[3] == 0.0 {
            color[3] = 1.0;
            self.warnings.add(|| format!("{FORMAT}: colours that are wholly transparent are drawn opaque"));
        }
        let mut material = material_of(color);
        if !name.is_empty() {
            material.name = name.to_owned();
        }
        if color[3] < 1.0 {
            material.alpha_mode = AlphaMode::Blend;
        }
        material
    }
}

/// The point that positions become relative to: zero, unless they are far from it.
fn origin_of(positions: &[[f64; 3]]) -> Origin {
    let placed = positions.iter().filter(|p| drawable(p.map(|v| v as f32)));
    let one = |&p: &[f64; 3]| Bounds { min: p, max: p };
    let bounds = placed.map(one).fold(Bounds::EMPTY, |all, one| all.union(&one));
    if bounds.is_far() { Origin(bounds.round_center()) } else { Origin::default() }
}

/// Rotation about x, then y, then z, and then the translation (ISO/ASTM 52915, "constellation").
fn transform(placed: &Placed) -> Option<Transform> {
    let [x, y, z] = placed.turns.map(f64::to_radians);
    let about = |axis: [f64; 3], angle: f64| Transform::rotation(axis, angle).ok();
    let first = about([0.0, 1.0, 0.0], y)?.after(&about([1.0, 0.0, 0.0], x)?).ok()?;
    let turned = about([0.0, 0.0, 1.0], z)?.after(&first).ok()?;
    Transform::translation(placed.offset).ok()?.after(&turned).ok()
}
