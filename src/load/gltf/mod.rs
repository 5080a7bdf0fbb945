//! glTF 2.0, as `.gltf` with its files beside it or embedded, and as `.glb`.
//!
//! The order is: container, JSON, extensions, scene graph, materials and primitives that are in the scene, and then,
//! in parallel, images and primitives. Compressed views are decompressed when all that are needed are known, compressed
//! primitives when their triangles are read. What is not in the default scene is never read. Serial steps find every byte
//! and charge every allocation in the order of the file, so that a limit is met at the same element whatever the
//! number of threads.
//!
//! What comes out of that is a [`Rig`]: it makes the scene in the pose of the file or at a time of one animation, with
//! vertices moved by morph targets and skins. Nothing is read or decoded again for another time.

// Whatever a file says, nothing here panics: there is no operation that could.
#![cfg_attr(
    not(test),
    deny(
        clippy::indexing_slicing,
        clippy::arithmetic_side_effects,
        clippy::unwrap_used,
        clippy::expect_used,
        clippy::panic,
        clippy::unreachable
    )
)]

mod accessor;
mod angle;
mod animation;
mod attributes;
mod buffers;
mod camera;
mod container;
mod deform;
mod draco;
mod extensions;
mod flat;
mod hierarchy;
mod instancing;
mod json;
mod light;
mod list;
mod material;
mod mesh;
mod meshopt;
mod model;
mod morph;
mod pointer;
mod pose;
mod rig;
mod sample;
mod shape;
mod skin;
mod source;
mod surface;
mod texture;
mod topology;
mod variant;

pub(super) use container::MAGIC;
pub(crate) use rig::Rig;
pub(super) use texture::transform_of;

use super::budget::Budget;
use super::tangents::tangent_set;
use super::warnings::Warnings;
use super::{AnimationInfo, Context, LoadError, LoadOptions};
use crate::limits::Limits;
use crate::scene::{Material, Scene, Texture, TextureId};
use accessor::Pick;
use animation::{Animation, Channels};
use buffers::Buffers;
use deform::Usage;
use hierarchy::{Content, Tree};
use list::Index;
use mesh::Geometry;
use model::Root;
use pointer::Target;
use rig::{Draw, Drawn, PoseKey, Weights};
use shape::{Shape, Topological};
use skin::Skin;
use source::{Shared, Source};
use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::sync::{Arc, Mutex};
use texture::{Encoded, Textures};

/// The format in messages.
const FORMAT: &str = "glTF";

/// Bytes charged for an instance: the scene's and what the renderer keeps for it.
const INSTANCE_BYTES: u64 = 256;

/// What is read of a file beside what its pictures need.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Purpose {
    /// Pictures only.
    Pictures,
    /// Also a list of all animations.
    Contents,
}

/// Reads a `.gltf` or `.glb` file.
///
/// # Errors
/// [`LoadError`] naming the element.
pub(crate) fn read(
    bytes: &[u8],
    options: &LoadOptions,
    purpose: Purpose,
    context: &Context<'_>,
) -> Result<Rig, LoadError> {
    let (text, binary) = container::split(bytes)?;
    read_parts(text, binary.map(Source::Memory), options, purpose, context)
}

/// Reads a `.glb` file of `size` bytes without reading all of it into memory first. `None` for every other file, and
/// for containers that are not as they should be.
///
/// # Errors
/// [`LoadError`] as [`read`], and [`LoadError::Io`].
pub(crate) fn read_file(
    file: &File,
    size: u64,
    options: &LoadOptions,
    purpose: Purpose,
    context: &Context<'_>,
) -> Result<Option<Rig>, LoadError> {
    let file = Shared::new(file);
    let Some((text, (start, length))) = container::locate(&file, size) else { return Ok(None) };
    let binary = Source::File(source::Part::new(&file, start, length));
    read_parts(&text, Some(binary), options, purpose, context).map(Some)
}

/// Reads the JSON text and the binary chunk of a file.
fn read_parts(
    text: &[u8],
    binary: Option<Source<'_>>,
    options: &LoadOptions,
    purpose: Purpose,
    context: &Context<'_>,
) -> Result<Rig, LoadError> {
    let mut budget = Budget::new(context.limits);
    let mut warnings = Warnings::default();
    let root = json::parse(text, &mut budget)?;
    check_counts(&root, context.limits)?;
    extensions::check(&root, &mut warnings)?;
    let variant = variant::chosen(&root, options.variant.as_deref())?;
    let mut tree = Tree::new(&root, context.limits)?;
    let chosen = match &options.animation {
        None => None,
        Some(choice) => {
            let index = animation::choose(&root, &choice.name)?;
            Some((index, animation::channels(&root, index, context.limits, &mut warnings)?))
        }
    };
    let channels = chosen.as_ref().map(|(_, channels)| channels);

    let mut loader = Loader {
        root: &root,
        context,
        variant,
        budget,
        warnings,
        buffers: Buffers::new(&root, binary),
        textures: Textures::default(),
        materials: Vec::new(),
        material_places: BTreeMap::new(),
        geometries: Vec::new(),
        sources: BTreeMap::new(),
        skins: BTreeMap::new(),
    };
    let (draws, contents) = loader.plan(&mut tree, channels)?;
    let (animation, animations) = loader.read_animations(channels, purpose)?;
    let (textures, shapes) = loader.read(&draws)?;
    let (stage, materials) = loader.dress(textures)?;
    let (skins, warnings) = (loader.skins, loader.warnings);
    let animation = chosen.as_ref().map(|(index, _)| *index).zip(animation);
    let rig =
        Rig { root, tree, stage, materials, shapes, skins, draws, contents, animation, animations, warnings };
    rig.check_joints()?;
    Ok(rig)
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
        ("skins", root.skins.len()),
        ("animations", root.animations.len()),
    ];
    for (name, count) in lists {
        Limits::check(|| name.to_owned(), count as u64, limits.nodes, "nodes")?;
    }
    Ok(())
}

struct Loader<'a> {
    root: &'a Root,
    context: &'a Context<'a>,
    /// The chosen material variant.
    variant: Option<Index>,
    budget: Budget,
    warnings: Warnings,
    buffers: Buffers<'a>,
    textures: Textures,
    /// Used materials in the order of first use, with their numbers in the file and provisional texture ids.
    materials: Vec<(Option<usize>, Material)>,
    /// Number in the file (`None`: the default material) to place.
    material_places: BTreeMap<(Option<usize>, bool), usize>,
    /// Used geometries in the order of first use.
    geometries: Vec<Geometry>,
    sources: BTreeMap<mesh::Source, usize>,
    /// Used skins by their numbers in the file.
    skins: BTreeMap<usize, Skin>,
}

impl Loader<'_> {
    /// Finds what the nodes draw, and makes sure that it is within the limits. Also gives all nodes that show something.
    fn plan(
        &mut self,
        tree: &mut Tree,
        channels: Option<&Channels>,
    ) -> Result<(Vec<Drawn>, Vec<Content>), LoadError> {
        let root = self.root;
        let targets: BTreeSet<Target> = channels.into_iter().flat_map(Channels::targets).collect();
        let contents = tree.contents(root, |node| targets.contains(&Target::Visible(node)))?;
        let usages = usages(root, &contents, &targets)?;
        let mut draws = Vec::new();
        // The draws of meshes, by their numbers in the file.
        let mut known: BTreeMap<usize, Arc<[Draw]>> = BTreeMap::new();
        let (mut triangles, mut instances) = (0u64, 0u64);
        for &content in &contents {
            let k = content.node;
            let node = root.nodes.at(k)?;
            let name = || root.nodes.label(k);
            if let Some((index, camera)) =
                node.camera.and_then(|k| Some((k.get(), root.cameras.get(k.get())?)))
            {
                camera::charge(camera, index, &mut self.budget)?;
            }
            let Some(mesh) = node.mesh else { continue };
            let mesh = mesh.get();
            let Some(usage) = usages.get(mesh) else {
                return Err(LoadError::malformed(FORMAT, format!("{}: there is no mesh {mesh}", name())));
            };
            let list = match known.get(&mesh) {
                Some(list) => Arc::clone(list),
                None => {
                    let list: Arc<[Draw]> = self.plan_mesh(mesh, usage)?.into();
                    known.insert(mesh, Arc::clone(&list));
                    list
                }
            };
            let mut copies = match node.extensions.as_deref().and_then(|e| e.instancing.as_ref()) {
                None => None,
                Some(given) => {
                    Some(instancing::read(root, k, given, &mut self.buffers, self.context, &mut self.budget)?)
                }
            };
            let mut skin = None;
            if let Some(index) = node.skin {
                let index = index.get();
                if index >= root.skins.len() {
                    return Err(LoadError::malformed(
                        FORMAT,
                        format!("{}: there is no skin {index}", name()),
                    ));
                }
                let mut geometries = list.iter().filter_map(|draw| self.geometries.get(draw.geometry));
                if geometries.any(Geometry::has_joints) {
                    skin = Some(index);
                    self.read_skin(index, tree)?;
                    if copies.as_ref().is_some_and(|copies| copies.len() > 1) {
                        self.warnings.add(|| format!("{}: a mesh with a skin is drawn once", name()));
                    }
                    copies = None;
                }
            }
            let own = !node.weights.is_empty() || targets.contains(&Target::Weights(k));
            let weights = if own { Weights::Node(k, mesh) } else { Weights::Mesh(mesh) };
            let count = copies.as_ref().map_or(1, |copies| copies.len() as u64);
            let geometries = list.iter().filter_map(|draw| self.geometries.get(draw.geometry));
            let each = geometries.map(|geometry| geometry.triangles).fold(0, u64::saturating_add);
            triangles = triangles.saturating_add(each.saturating_mul(count));
            instances = instances.saturating_add(count.saturating_mul(list.len() as u64));
            Limits::check(
                || format!("triangles up to {}", name()),
                triangles,
                self.context.limits.triangles,
                "triangles",
            )?;
            draws.push(Drawn { node: content, mesh: list, copies, skin, weights });
        }
        self.budget.charge(|| "instances".to_owned(), instances, INSTANCE_BYTES)?;
        Ok((draws, contents))
    }

    fn read_skin(&mut self, index: usize, tree: &mut Tree) -> Result<(), LoadError> {
        if !self.skins.contains_key(&index) {
            let skin = skin::read(self.root, index, tree, &mut self.buffers, self.context, &mut self.budget)?;
            self.skins.insert(index, skin);
        }
        Ok(())
    }

    /// The animation that is played, and a list of all if that is the purpose.
    fn read_animations(
        &mut self,
        channels: Option<&Channels>,
        purpose: Purpose,
    ) -> Result<(Option<Animation>, Vec<AnimationInfo>), LoadError> {
        let (buffers, budget) = (&mut self.buffers, &mut self.budget);
        let animation = channels
            .map(|channels| channels.read(self.root, buffers, self.context, budget, &mut self.warnings))
            .transpose()?;
        let animations = match purpose {
            Purpose::Pictures => Vec::new(),
            Purpose::Contents => animation::list(self.root, buffers, self.context, budget)?,
        };
        Ok((animation, animations))
    }

    fn plan_mesh(&mut self, mesh: usize, usage: &Usage) -> Result<Vec<Draw>, LoadError> {
        let root = self.root;
        let mut draws = Vec::new();
        for (k, primitive) in root.meshes.at(mesh)?.primitives.iter().enumerate() {
            let material = variant::material(primitive, self.variant).map(Index::get);
            if let Some(missing) = material.filter(|&m| m >= root.materials.len()) {
                let name = mesh::name(root, mesh, k);
                return Err(LoadError::malformed(FORMAT, format!("{name}: there is no material {missing}")));
            }
            let material = self.plan_material(material, mesh::is_unlit(primitive))?;
            let tangents_for = self.materials.get(material).and_then(|(_, material)| tangent_set(material));
            let planned = mesh::plan(
                root,
                (mesh, k),
                tangents_for,
                usage,
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
                    let place = self.geometries.len();
                    self.geometries.push(geometry);
                    self.sources.insert(source, place);
                    place
                }
            };
            draws.push(Draw { geometry, material });
        }
        Ok(draws)
    }

    /// The place of a material, or of the same one without light.
    fn plan_material(&mut self, index: Option<usize>, unlit: bool) -> Result<usize, LoadError> {
        if let Some(&place) = self.material_places.get(&(index, unlit)) {
            return Ok(place);
        }
        // Far larger than what the file says of it; twice, for a list that grows.
        self.budget.charge(|| "materials".to_owned(), 2, size_of::<Material>() as u64)?;
        let mut material = match index {
            None => material::default_material(),
            Some(index) => material::convert(self.root, index, &mut self.textures, &mut self.warnings)?,
        };
        material.unlit |= unlit;
        let place = self.materials.len();
        self.materials.push((index, material));
        self.material_places.insert((index, unlit), place);
        Ok(place)
    }

    /// Decodes images and reads primitives.
    #[allow(clippy::type_complexity)]
    fn read(&mut self, draws: &[Drawn]) -> Result<(Vec<Option<Texture>>, Vec<Shape>), LoadError> {
        let (root, jobs) = (self.root, self.context.jobs);
        let encoded = self.textures.fetch(
            root,
            &mut self.buffers,
            self.context,
            &mut self.budget,
            &mut self.warnings,
        )?;
        self.buffers.decompress(jobs)?;
        let (geometries, buffers) = (&self.geometries, &self.buffers);

        // As many at a time as what they take for a while fits into what is left.
        let mut connected = Vec::with_capacity(geometries.len());
        let mut rest = geometries.as_slice();
        while !rest.is_empty() {
            let mut transient = 0u64;
            let fits = rest.iter().take_while(|geometry| {
                transient = transient.saturating_add(geometry.transient_bytes());
                transient <= self.budget.left()
            });
            let (now, later) = rest.split_at_checked(fits.count().max(1)).unwrap_or((rest, &[]));
            connected.extend(jobs.map_each(now, |geometry| geometry.read_triangles(root, buffers)));
            rest = later;
        }
        let mut vertices = 0;
        let mut picks = Vec::with_capacity(geometries.len());
        for (geometry, topological) in geometries.iter().zip(connected) {
            let topological = topological?;
            let pick =
                geometry.pick(root, &topological, &mut vertices, self.context.limits, &mut self.budget)?;
            picks.push((topological, pick));
        }
        let mut posed: BTreeSet<PoseKey> = BTreeSet::new();
        for drawn in draws {
            for draw in drawn.mesh.iter() {
                let (Some(geometry), Some((_, pick))) =
                    (geometries.get(draw.geometry), picks.get(draw.geometry))
                else {
                    continue;
                };
                let skin = drawn.skin.filter(|_| geometry.has_joints());
                let weights = geometry.has_targets().then_some(drawn.weights);
                if (skin.is_some() || weights.is_some()) && posed.insert((draw.geometry, skin, weights)) {
                    geometry.charge_pose(root, pick, &mut vertices, self.context.limits, &mut self.budget)?;
                }
            }
        }
        // Images first: they take longest.
        let images = encoded.iter().map(Work::Image);
        let picked = geometries.iter().zip(picks);
        let meshes = picked.map(|(geometry, picked)| Work::Mesh(geometry, Mutex::new(Some(picked))));
        let work: Vec<Work<'_>> = images.chain(meshes).collect();
        let results = jobs.map_each(&work, |work| match work {
            Work::Image(encoded) => Part::Image(
                encoded
                    .decode(buffers)
                    .map_err(|message| format!("{}: {message}; drawn without it", encoded.what)),
            ),
            Work::Mesh(geometry, picked) => {
                let taken = picked.lock().map_or(None, |mut slot| slot.take());
                let mut repaired = Vec::new();
                let mesh = match taken {
                    Some((topological, pick)) => {
                        geometry.read(root, buffers, topological, &pick, &mut repaired)
                    }
                    None => Err(LoadError::malformed(FORMAT, "a primitive was read twice")),
                };
                Part::Mesh(Box::new(mesh), repaired)
            }
        });
        self.collect(results)
    }

    #[allow(clippy::type_complexity)]
    fn collect(&mut self, results: Vec<Part>) -> Result<(Vec<Option<Texture>>, Vec<Shape>), LoadError> {
        let mut textures: Vec<Option<Texture>> = (0..self.textures.count()).map(|_| None).collect();
        let mut meshes = Vec::with_capacity(self.geometries.len());
        for result in results {
            match result {
                Part::Image(Ok(list)) => {
                    for (id, texture) in list {
                        if let Some(place) = textures.get_mut(id as usize) {
                            *place = Some(texture);
                        }
                    }
                }
                Part::Image(Err(message)) => self.warnings.add(|| message),
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

    /// A scene with the textures, and the materials that use them, with their numbers in the file.
    #[allow(clippy::type_complexity)]
    fn dress(
        &mut self,
        textures: Vec<Option<Texture>>,
    ) -> Result<(Scene, Vec<(Option<usize>, Material)>), LoadError> {
        let mut scene = Scene::new();
        let mut ids: Vec<Option<TextureId>> = Vec::with_capacity(textures.len());
        for texture in textures {
            let id = texture.map(|texture| scene.add_texture(texture)).transpose();
            ids.push(id.map_err(LoadError::scene("textures"))?);
        }
        let mut materials = std::mem::take(&mut self.materials);
        materials.iter_mut().for_each(|(_, material)| material::settle_textures(material, &ids));
        Ok((scene, materials))
    }
}

/// How the nodes of the scene use each mesh.
fn usages(root: &Root, contents: &[Content], targets: &BTreeSet<Target>) -> Result<Vec<Usage>, LoadError> {
    /// Weights that many nodes share are looked at once.
    #[derive(Default)]
    struct Seen {
        usage: Usage,
        whole: bool,
        own: bool,
    }
    let mut all: Vec<Seen> = root.meshes.iter().map(|_| Seen::default()).collect();
    let nonzero = |weights: &[f64]| -> Vec<usize> {
        (0..weights.len()).filter(|&k| pose::stored(weights, k) != 0.0).collect()
    };
    for content in contents {
        let k = content.node;
        let node = root.nodes.at(k)?;
        let Some(mesh) = node.mesh.map(Index::get) else { continue };
        let (Some(given), Some(seen)) = (root.meshes.get(mesh), all.get_mut(mesh)) else { continue };
        seen.usage.skinned |= node.skin.is_some();
        let animated = targets.contains(&Target::Weights(k))
            || node.weights.is_empty() && targets.contains(&Target::MeshWeights(mesh));
        if animated {
            if !std::mem::replace(&mut seen.whole, true) {
                seen.usage.targets.extend(0..Target::MeshWeights(mesh).width(root));
            }
        } else if !node.weights.is_empty() {
            seen.usage.targets.extend(nonzero(&node.weights));
        } else if !std::mem::replace(&mut seen.own, true) {
            seen.usage.targets.extend(nonzero(&given.weights));
        }
    }
    Ok(all.into_iter().map(|seen| seen.usage).collect())
}

/// What one parallel job does.
enum Work<'a> {
    Image(&'a Encoded),
    /// Its triangles and vertices are taken out by the job that reads it.
    Mesh(&'a Geometry, Mutex<Option<(Topological, Pick)>>),
}

/// What one parallel job gives.
enum Part {
    /// Or a warning.
    Image(Result<Vec<(u32, Texture)>, String>),
    Mesh(Box<Result<Shape, LoadError>>, Vec<String>),
}
