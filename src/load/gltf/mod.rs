//! glTF 2.0, as `.gltf` with its files beside it or embedded, and as `.glb`.
//!
//! The order is: container, JSON, extensions, scene graph, materials and primitives that are in the scene, and then,
//! in parallel, images and primitives. What is not in the default scene is never read. Serial steps find every byte
//! and charge every allocation in the order of the file, so that a limit is met at the same element whatever the
//! number of threads.
//!
//! Skins, morph targets and animations are not applied: the picture shows the bind pose.

mod accessor;
mod angle;
mod buffers;
mod camera;
mod container;
mod extensions;
mod hierarchy;
mod instancing;
mod json;
mod light;
mod material;
mod mesh;
mod model;
mod source;
mod texture;

pub(super) use container::MAGIC;
pub(super) use texture::transform_of;

use super::budget::Budget;
use super::tangents::tangent_set;
use super::warnings::Warnings;
use super::{Context, LoadError, Loaded};
use crate::limits::Limits;
use crate::scene::{Instance, Material, MaterialId, Mesh, MeshId, Scene, Texture, TextureId};
use buffers::Buffers;
use hierarchy::Placed;
use mesh::Geometry;
use model::{Index, Root};
use source::{Shared, Source};
use std::collections::BTreeMap;
use std::fs::File;
use std::sync::Mutex;
use texture::{Encoded, Textures};

/// The format in messages.
const FORMAT: &str = "glTF";

/// Bytes charged for an instance: the scene's and what the renderer keeps for it.
const INSTANCE_BYTES: u64 = 256;

/// Loads a `.gltf` or `.glb` file.
///
/// # Errors
/// [`LoadError`] naming the element.
pub(crate) fn load(bytes: &[u8], context: &Context<'_>) -> Result<Loaded, LoadError> {
    let (text, binary) = container::split(bytes)?;
    load_parts(text, binary.map(Source::Memory), context)
}

/// Loads a `.glb` file of `size` bytes without reading all of it into memory first. `None` for every other file, and
/// for containers that are not as they should be.
///
/// # Errors
/// [`LoadError`] as [`load`], and [`LoadError::Io`].
pub(crate) fn load_file(file: &File, size: u64, context: &Context<'_>) -> Result<Option<Loaded>, LoadError> {
    let file = Shared::new(file);
    let Some((text, (start, length))) = container::locate(&file, size) else { return Ok(None) };
    let binary = Source::File(source::Part::new(&file, start, length));
    load_parts(&text, Some(binary), context).map(Some)
}

/// Loads the JSON text and the binary chunk of a file.
fn load_parts(text: &[u8], binary: Option<Source<'_>>, context: &Context<'_>) -> Result<Loaded, LoadError> {
    let mut budget = Budget::new(context.limits);
    let mut warnings = Warnings::default();
    let root = json::parse(text, &mut budget)?;
    check_counts(&root, context.limits)?;
    extensions::check(&root, &mut warnings)?;
    let placed = hierarchy::flatten(&root, context.limits)?;

    let mut loader = Loader {
        root: &root,
        context,
        budget,
        warnings,
        buffers: Buffers::new(&root, binary),
        textures: Textures::default(),
        materials: Vec::new(),
        material_places: BTreeMap::new(),
        geometries: Vec::new(),
        sources: BTreeMap::new(),
    };
    let draws = loader.plan(&placed)?;
    let (textures, meshes) = loader.read()?;
    loader.assemble(&placed, draws, textures, meshes)
}

/// Every list of small objects against one limit.
fn check_counts(root: &Root, limits: &Limits) -> Result<(), LoadError> {
    let lists = [
        ("nodes", root.nodes.len()),
        ("scenes", root.scenes.len()),
        ("meshes", root.meshes.len()),
        ("materials", root.materials.len()),
        ("textures", root.textures.len()),
        ("images", root.images.len()),
        ("samplers", root.samplers.len()),
        ("cameras", root.cameras.len()),
        ("accessors", root.accessors.len()),
        ("bufferViews", root.buffer_views.len()),
        ("buffers", root.buffers.len()),
    ];
    for (name, count) in lists {
        Limits::check(|| name.to_owned(), count as u64, limits.nodes, "nodes")?;
    }
    Ok(())
}

/// A primitive of a mesh that is in the scene: which geometry and which material, by their places in the loader.
#[derive(Clone, Copy)]
struct Draw {
    geometry: usize,
    material: usize,
}

/// What a node draws.
struct Drawn {
    /// Place in the list of placed nodes.
    place: usize,
    /// Place in the list of the meshes' draws.
    mesh: usize,
    /// Transforms relative to the node, of EXT_mesh_gpu_instancing.
    copies: Option<Vec<crate::scene::Transform>>,
}

struct Draws {
    nodes: Vec<Drawn>,
    meshes: Vec<Vec<Draw>>,
}

struct Loader<'a> {
    root: &'a Root,
    context: &'a Context<'a>,
    budget: Budget,
    warnings: Warnings,
    buffers: Buffers<'a>,
    textures: Textures,
    /// Used materials in the order of first use, with provisional texture ids.
    materials: Vec<Material>,
    /// Number in the file (`None`: the default material) to place.
    material_places: BTreeMap<Option<usize>, usize>,
    /// Used geometries in the order of first use.
    geometries: Vec<Geometry>,
    sources: BTreeMap<mesh::Source, usize>,
}

impl Loader<'_> {
    /// Finds what the nodes draw, and makes sure that it is within the limits.
    fn plan(&mut self, placed: &[Placed]) -> Result<Draws, LoadError> {
        let mut draws = Draws { nodes: Vec::new(), meshes: Vec::new() };
        let mut known: Vec<Option<usize>> = vec![None; self.root.meshes.len()];
        let (mut triangles, mut instances) = (0u64, 0u64);
        let (mut skinned, mut morphed) = (false, false);
        for (place, at) in placed.iter().enumerate() {
            let node = &self.root.nodes[at.node];
            let Some(mesh) = node.mesh else { continue };
            let mesh = mesh.get();
            let Some(slot) = known.get(mesh) else {
                let name = model::label::<model::Node>(at.node, node.name.as_deref());
                return Err(LoadError::malformed(FORMAT, format!("{name}: there is no mesh {mesh}")));
            };
            let drawn = match slot {
                Some(drawn) => *drawn,
                None => {
                    let planned = self.plan_mesh(mesh)?;
                    draws.meshes.push(planned);
                    known[mesh] = Some(draws.meshes.len() - 1);
                    draws.meshes.len() - 1
                }
            };
            skinned |= node.skin.is_some();
            let weights =
                if node.weights.is_empty() { &self.root.meshes[mesh].weights } else { &node.weights };
            morphed |= weights.iter().any(|&w| w != 0.0)
                && self.root.meshes[mesh].primitives.iter().any(|p| !p.targets.is_empty());
            let copies = match node.extensions.as_deref().and_then(|e| e.instancing.as_ref()) {
                None => None,
                Some(given) => Some(instancing::read(
                    self.root,
                    at.node,
                    given,
                    &mut self.buffers,
                    self.context,
                    &mut self.budget,
                )?),
            };
            let count = copies.as_ref().map_or(1, |copies| copies.len() as u64);
            let list = &draws.meshes[drawn];
            let each: u64 = list.iter().map(|draw| self.geometries[draw.geometry].triangles).sum();
            triangles = triangles.saturating_add(each.saturating_mul(count));
            instances = instances.saturating_add(count.saturating_mul(list.len() as u64));
            let name = || model::label::<model::Node>(at.node, node.name.as_deref());
            Limits::check(
                || format!("triangles up to {}", name()),
                triangles,
                self.context.limits.triangles,
                "triangles",
            )?;
            draws.nodes.push(Drawn { place, mesh: drawn, copies });
        }
        self.budget.charge(|| "instances".to_owned(), instances, INSTANCE_BYTES)?;
        if skinned {
            self.warnings.add(|| "skins are not applied: the bind pose is drawn".to_owned());
        }
        if morphed {
            self.warnings.add(|| "morph targets are not applied: the base shape is drawn".to_owned());
        }
        if !self.root.animations.is_empty() {
            self.warnings.add(|| "animations are not played: the pose of the file is drawn".to_owned());
        }
        Ok(draws)
    }

    fn plan_mesh(&mut self, mesh: usize) -> Result<Vec<Draw>, LoadError> {
        let root = self.root;
        let mut draws = Vec::new();
        for (k, primitive) in root.meshes[mesh].primitives.iter().enumerate() {
            let material = primitive.material.map(Index::get);
            if let Some(missing) = material.filter(|&m| m >= root.materials.len()) {
                let name = mesh::name(root, mesh, k);
                return Err(LoadError::malformed(FORMAT, format!("{name}: there is no material {missing}")));
            }
            let material = self.plan_material(material)?;
            let tangents_for = tangent_set(&self.materials[material]);
            let planned = mesh::plan(
                root,
                (mesh, k),
                tangents_for,
                &mut self.buffers,
                self.context,
                &mut self.budget,
                &mut self.warnings,
            )?;
            let Some((source, geometry)) = planned else { continue };
            let geometry = match self.sources.get(&source) {
                Some(&known) => known,
                None => {
                    geometry.charge_triangles(root, &mut self.budget)?;
                    self.geometries.push(geometry);
                    self.sources.insert(source, self.geometries.len() - 1);
                    self.geometries.len() - 1
                }
            };
            draws.push(Draw { geometry, material });
        }
        Ok(draws)
    }

    fn plan_material(&mut self, index: Option<usize>) -> Result<usize, LoadError> {
        if let Some(&place) = self.material_places.get(&index) {
            return Ok(place);
        }
        // Far larger than what the file says of it; twice, for a list that grows.
        self.budget.charge(|| "materials".to_owned(), 2, size_of::<Material>() as u64)?;
        self.materials.push(match index {
            None => material::default_material(),
            Some(index) => material::convert(self.root, index, &mut self.textures, &mut self.warnings),
        });
        self.material_places.insert(index, self.materials.len() - 1);
        Ok(self.materials.len() - 1)
    }

    /// Decodes images and reads primitives.
    #[allow(clippy::type_complexity)]
    fn read(&mut self) -> Result<(Vec<Option<Texture>>, Vec<Mesh>), LoadError> {
        let (root, jobs) = (self.root, self.context.jobs);
        let encoded = self.textures.fetch(
            root,
            &mut self.buffers,
            self.context,
            &mut self.budget,
            &mut self.warnings,
        )?;
        let (geometries, buffers) = (&self.geometries, &self.buffers);

        let connected = jobs.map(geometries.len(), |k| geometries[k].read_triangles(root, buffers));
        let mut vertices = 0;
        let mut picked = Vec::with_capacity(geometries.len());
        for (geometry, topological) in geometries.iter().zip(connected) {
            let topological = topological?;
            let pick =
                geometry.pick(root, &topological, &mut vertices, self.context.limits, &mut self.budget)?;
            // Each is taken out by the one job that reads it.
            picked.push(Mutex::new(Some((topological, pick))));
        }

        // Images first: they take longest.
        let results = jobs.map(encoded.len() + geometries.len(), |k| match encoded.get(k) {
            Some(encoded) => Part::Image(encoded.decode(buffers)),
            None => {
                let k = k - encoded.len();
                let taken = picked[k].lock().map_or(None, |mut slot| slot.take());
                let mut repaired = Vec::new();
                let mesh = match taken {
                    Some((topological, pick)) => {
                        geometries[k].read(root, buffers, topological, &pick, &mut repaired)
                    }
                    None => Err(LoadError::malformed(FORMAT, "a primitive was read twice")),
                };
                Part::Mesh(Box::new(mesh), repaired)
            }
        });
        self.collect(&encoded, results)
    }

    #[allow(clippy::type_complexity)]
    fn collect(
        &mut self,
        encoded: &[Encoded],
        results: Vec<Part>,
    ) -> Result<(Vec<Option<Texture>>, Vec<Mesh>), LoadError> {
        let mut textures: Vec<Option<Texture>> = (0..self.textures.count()).map(|_| None).collect();
        let mut meshes = Vec::with_capacity(self.geometries.len());
        for (k, result) in results.into_iter().enumerate() {
            match result {
                Part::Image(Ok(list)) => {
                    for (id, texture) in list {
                        textures[id as usize] = Some(texture);
                    }
                }
                Part::Image(Err(message)) => {
                    self.warnings.add(|| format!("{}: {message}; drawn without it", encoded[k].what));
                }
                Part::Mesh(mesh, repaired) => {
                    meshes.push((*mesh)?);
                    for message in repaired {
                        self.warnings.add(|| message);
                    }
                }
            }
        }
        Ok((textures, meshes))
    }

    /// Puts the scene together.
    fn assemble(
        mut self,
        placed: &[Placed],
        draws: Draws,
        textures: Vec<Option<Texture>>,
        meshes: Vec<Mesh>,
    ) -> Result<Loaded, LoadError> {
        let root = self.root;
        let mut scene = Scene::new();
        let mut ids: Vec<Option<TextureId>> = Vec::with_capacity(textures.len());
        for texture in textures {
            let id = texture.map(|texture| scene.add_texture(texture)).transpose();
            ids.push(id.map_err(LoadError::scene("textures"))?);
        }
        let mut material_ids: Vec<MaterialId> = Vec::with_capacity(self.materials.len());
        for mut material in std::mem::take(&mut self.materials) {
            material::settle_textures(&mut material, &ids);
            let name = material.name.escape_debug().take(64).collect::<String>();
            let id = scene.add_material(material);
            material_ids.push(id.map_err(LoadError::scene(format!("material '{name}'")))?);
        }
        let mut mesh_ids: Vec<MeshId> = Vec::with_capacity(meshes.len());
        for mesh in meshes {
            mesh_ids.push(scene.add_mesh(mesh).map_err(LoadError::scene("meshes"))?);
        }
        for drawn in &draws.nodes {
            let at = &placed[drawn.place];
            let name = || model::label::<model::Node>(at.node, root.nodes[at.node].name.as_deref());
            let fail = |error| LoadError::scene(name())(error);
            let copies = drawn.copies.as_deref().unwrap_or(&[crate::scene::Transform::IDENTITY]);
            for copy in copies {
                let transform = at.transform.after(copy).map_err(fail)?;
                for draw in &draws.meshes[drawn.mesh] {
                    let instance = Instance {
                        mesh: mesh_ids[draw.geometry],
                        material: material_ids[draw.material],
                        transform,
                        object: at.node as u32,
                    };
                    scene.add_instance(instance).map_err(fail)?;
                }
            }
        }
        self.add_cameras_and_lights(placed, &mut scene)?;
        if scene.triangle_count() == 0 {
            self.warnings.add(|| "no triangles".to_owned());
        }
        Ok(Loaded { scene, warnings: self.warnings.finish() })
    }

    fn add_cameras_and_lights(&mut self, placed: &[Placed], scene: &mut Scene) -> Result<(), LoadError> {
        let root = self.root;
        let lights = root.extensions.lights.as_ref().map_or(&[][..], |l| &l.lights);
        for at in placed {
            let node = &root.nodes[at.node];
            let name = || model::label::<model::Node>(at.node, node.name.as_deref());
            if let Some(index) = node.camera {
                match root.cameras.get(index.get()) {
                    Some(given) => {
                        let (budget, warnings) = (&mut self.budget, &mut self.warnings);
                        camera::add(scene, given, index.get(), &at.transform, budget, warnings)?;
                    }
                    None => self.warnings.add(|| format!("{}: there is no camera {index}", name())),
                }
            }
            let light = node.extensions.as_deref().and_then(|e| e.light.as_ref()).and_then(|l| l.light);
            if let Some(index) = light {
                match lights.get(index.get()) {
                    Some(given) => light::add(scene, given, index.get(), &at.transform, &mut self.warnings),
                    None => self.warnings.add(|| format!("{}: there is no light {index}", name())),
                }
            }
        }
        Ok(())
    }
}

/// What one parallel job gives.
enum Part {
    Image(Result<Vec<(u32, Texture)>, String>),
    Mesh(Box<Result<Mesh, LoadError>>, Vec<String>),
}
