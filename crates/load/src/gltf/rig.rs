//! A file that has been read: everything that is needed to make its scene at any time of its animation.

use super::animation::{self, Animation};
use super::deform::{self, Wanted};
use super::far::Far;
use super::hierarchy::{Content, Places, Tree};
use super::mesh;
use super::model::Root;
use super::pose::Pose;
use super::shape::Shape;
use super::skin::{Matrix, Skin};
use super::{FORMAT, camera, light, surface, variant};
use crate::Warning;
use crate::warnings::Warnings;
use crate::{AnimationInfo, LoadError, Loaded};
use overcoat_core::jobs::Jobs;
use overcoat_scene::{
    Instance, Material, MaterialId, MeshId, Orientation, Scene, SplatCloud, SplatInstance, Transform,
};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// A primitive of a mesh that is in the scene: which geometry and which material, by their places in the lists.
#[derive(Clone, Copy)]
pub(super) struct Draw {
    pub geometry: usize,
    pub material: usize,
}

/// A node that draws something.
pub(super) struct Drawn {
    pub node: Content,
    /// The draws of its mesh.
    pub mesh: Arc<[Draw]>,
    /// The clouds of splats of its mesh.
    pub splats: Arc<[usize]>,
    /// Transforms relative to the node, of EXT_mesh_gpu_instancing.
    pub copies: Option<Vec<Transform>>,
    /// Number of its skin.
    pub skin: Option<usize>,
    /// Source of the weights of its morph targets.
    pub weights: Weights,
}

/// Source of the weights of morph targets.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Weights {
    /// From this mesh of the file.
    Mesh(usize),
    /// From this node of the file, which shows the mesh.
    Node(usize, usize),
}

/// Key of a posed mesh: geometry, skin, and source of the morph weights. Uses with equal keys share a mesh.
pub(super) type PoseKey = (usize, Option<usize>, Option<Weights>);

/// A file that has been read.
pub(crate) struct Rig {
    pub(super) root: Root,
    pub(super) tree: Tree,
    /// A scene with the textures and nothing else.
    pub(super) stage: Scene,
    /// With their numbers in the file.
    pub(super) materials: Vec<(Option<usize>, Material)>,
    pub(super) shapes: Vec<Shape>,
    pub(super) clouds: Vec<SplatCloud>,
    pub(super) skins: BTreeMap<usize, Skin>,
    /// In the order of the tree.
    pub(super) draws: Vec<Drawn>,
    /// Nodes that are or may become visible.
    pub(super) contents: Vec<Content>,
    /// The animation that is played, with its number.
    pub(super) animation: Option<(usize, Animation)>,
    /// The moment of it, in seconds, that stands for the pose of the file, in which nothing is visible.
    pub(super) stands_in: Option<f64>,
    /// Every animation of the file, if that was asked for.
    pub(super) animations: Vec<AnimationInfo>,
    /// Origins of the scene and of geometries that are far from zero.
    pub(super) far: Far,
    /// Axis that is up, and the front.
    pub(super) orientation: Orientation,
    /// Warnings of reading the file.
    pub(super) warnings: Warnings,
}

impl Rig {
    /// Adds to what is lost in reading the file.
    pub(crate) fn warn(&mut self, warning: Warning) {
        self.warnings.add(|| warning.message);
    }

    /// All animations of the file.
    pub(crate) fn animations(&self) -> &[AnimationInfo] {
        &self.animations
    }

    /// Names of all material variants of the file.
    pub(crate) fn variants(&self) -> impl Iterator<Item = &str> {
        variant::names(&self.root)
    }

    /// Seconds to the last key frame of the animation that is played.
    pub(crate) fn length(&self) -> Option<f64> {
        self.animation.as_ref().filter(|_| self.stands_in.is_none()).map(|(_, animation)| animation.length())
    }

    /// Makes sure that vertices follow joints that there are: what does not is drawn without its skin, with a warning.
    ///
    /// # Errors
    /// [`LoadError::Malformed`] if a primitive has not been read.
    pub(super) fn check_joints(&mut self) -> Result<(), LoadError> {
        for k in 0..self.draws.len() {
            let Some(drawn) = self.draws.get(k) else { continue };
            let Some((skin, joints)) = drawn.skin.and_then(|k| Some((k, self.skins.get(&k)?.len()))) else {
                continue;
            };
            let mut torn = None;
            for draw in drawn.mesh.iter() {
                let shape = self.shape(draw.geometry)?;
                let last = shape.deform.as_ref().map_or(0, deform::Deform::last_joint);
                if last >= joints {
                    let name = mesh::name(&self.root, shape.of.0, shape.of.1);
                    let skin = self.root.skins.label(skin);
                    torn = Some(format!("{name}: joint {last} is out of range of {joints} joints of {skin}"));
                    break;
                }
            }
            let Some(reason) = torn else { continue };
            self.warnings.add(|| format!("{reason}; drawn without the skin"));
            self.draws.get_mut(k).into_iter().for_each(|drawn| drawn.skin = None);
        }
        Ok(())
    }

    fn shape(&self, geometry: usize) -> Result<&Shape, LoadError> {
        let missing = || LoadError::malformed(FORMAT, "a primitive has not been read");
        self.shapes.get(geometry).ok_or_else(missing)
    }

    /// The scene at a time of the animation; in the pose of the file if none is played. Time beyond the end is the end,
    /// with a warning, or goes on from the beginning if it is to `repeat`.
    ///
    /// # Errors
    /// [`LoadError::Scene`] naming what cannot be part of a scene.
    pub(crate) fn at(&self, time: f64, repeat: bool, jobs: &Jobs) -> Result<Loaded, LoadError> {
        let time = self.stands_in.unwrap_or(time);
        let mut warnings = self.warnings.clone();
        let pose = self.animation.as_ref().map_or_else(Pose::default, |(index, animation)| {
            let length = animation.length();
            let mut time = if time.is_finite() { time } else { 0.0 };
            if repeat && length > 0.0 {
                time -= (time / length).floor() * length;
            } else if time > length {
                let name = || animation::name(&self.root, *index);
                warnings.add(|| format!("{} ends at {length} s: its last pose is drawn", name()));
            }
            animation.pose(time)
        });
        let (origin, places) = self.places(&pose)?;
        let mut scene = self.stage.clone();
        scene.set_origin(origin);
        let materials = self.add_materials(&pose, &mut scene)?;
        self.add_meshes(&pose, &places, &materials, &mut scene, jobs)?;
        self.add_splats(&places, &mut scene)?;
        self.add_cameras_and_lights(&pose, &places, &mut scene, &mut warnings);
        scene.stand_up(self.orientation);
        if scene.triangle_count() == 0 && scene.splat_count() == 0 {
            warnings.add(|| "no triangles".to_owned());
        }
        Ok(Loaded { warnings: warnings.finish(), ..Loaded::from(scene) })
    }

    fn add_materials(&self, pose: &Pose, scene: &mut Scene) -> Result<Vec<MaterialId>, LoadError> {
        let mut ids = Vec::with_capacity(self.materials.len());
        for (index, material) in &self.materials {
            let mut material = material.clone();
            if let Some((index, changes)) = index.and_then(|k| Some((k, pose.surfaces.get(&k)?))) {
                surface::change(&mut material, self.root.materials.at(index)?, changes);
            }
            let name = material.name.escape_debug().take(64).collect::<String>();
            let id = scene.add_material(material);
            ids.push(id.map_err(LoadError::scene(format!("material '{name}'")))?);
        }
        Ok(ids)
    }

    /// Adds what is drawn of meshes: as they are stored, and in poses of their own.
    fn add_meshes(
        &self,
        pose: &Pose,
        places: &Places,
        materials: &[MaterialId],
        scene: &mut Scene,
        jobs: &Jobs,
    ) -> Result<(), LoadError> {
        let mut stored: BTreeSet<usize> = BTreeSet::new();
        let mut weights: BTreeMap<(usize, Weights), Option<Vec<f32>>> = BTreeMap::new();
        let mut posed: BTreeMap<PoseKey, usize> = BTreeMap::new();
        let mut order: Vec<PoseKey> = Vec::new();
        let mut matrices: BTreeMap<usize, Vec<Matrix>> = BTreeMap::new();
        // For each draw of each node that is shown, its mesh in a pose, and whether that has a skin; or none.
        let mut keys: Vec<Option<(usize, bool)>> = Vec::new();
        for drawn in &self.draws {
            if places.shown(drawn.node.place).is_none() {
                continue;
            }
            for draw in drawn.mesh.iter() {
                let key = self.key(draw.geometry, drawn, pose, &mut weights);
                if key.1.is_none() && key.2.is_none() {
                    stored.insert(draw.geometry);
                    keys.push(None);
                    continue;
                }
                if let Some((k, skin)) = key.1.and_then(|k| Some((k, self.skins.get(&k)?)))
                    && !matrices.contains_key(&k)
                {
                    matrices.insert(k, skin.matrices(&self.root, places)?);
                }
                let next = order.len();
                let place = *posed.entry(key).or_insert(next);
                if place == next {
                    order.push(key);
                }
                keys.push(Some((place, key.1.is_some())));
            }
        }
        let mut wanted = Vec::with_capacity(order.len());
        for (geometry, skin, source) in &order {
            let shape = self.shape(*geometry)?;
            // Only what moves has a key.
            let Some(deform) = &shape.deform else { continue };
            let weights = source.and_then(|source| weights.get(&(*geometry, source)).cloned().flatten());
            wanted.push(Wanted {
                base: shape.mesh.data(),
                deform,
                weights: weights.unwrap_or_default(),
                matrices: skin.and_then(|k| matrices.get(&k)).map(Vec::as_slice),
            });
        }
        let meshes = deform::pose(&wanted, jobs);

        let mut stored_ids: BTreeMap<usize, MeshId> = BTreeMap::new();
        for geometry in stored {
            let mesh = self.shape(geometry)?.mesh.clone();
            stored_ids.insert(geometry, scene.add_mesh(mesh).map_err(LoadError::scene("meshes"))?);
        }
        let mut posed_ids: Vec<MeshId> = Vec::with_capacity(meshes.len());
        for (mesh, (geometry, _, _)) in meshes.into_iter().zip(&order) {
            let of = self.shape(*geometry)?.of;
            let name = || mesh::name(&self.root, of.0, of.1);
            let mesh = mesh.map_err(|e| LoadError::scene(name())(e))?;
            posed_ids.push(scene.add_mesh(mesh).map_err(LoadError::scene("meshes"))?);
        }

        let mut keys = keys.into_iter();
        for drawn in &self.draws {
            let Some(transform) = places.shown(drawn.node.place) else { continue };
            let node = drawn.node.node;
            let fail = |error| LoadError::scene(self.root.nodes.label(node))(error);
            let meshes: Vec<Option<(usize, bool)>> = keys.by_ref().take(drawn.mesh.len()).collect();
            let copies = drawn.copies.as_deref().unwrap_or(&[Transform::IDENTITY]);
            for copy in copies {
                let placed = transform.after(copy).map_err(fail)?;
                for (draw, posed) in drawn.mesh.iter().zip(&meshes) {
                    let (mesh, skinned) = match posed {
                        Some((k, skinned)) => (posed_ids.get(*k), *skinned),
                        None => (stored_ids.get(&draw.geometry), false),
                    };
                    let (Some(&mesh), Some(&material)) = (mesh, materials.get(draw.material)) else {
                        continue;
                    };
                    let transform = match self.far.way_back(draw.geometry) {
                        // Its vertices are in world space.
                        _ if skinned => Transform::IDENTITY,
                        Some(way_back) => placed.after(way_back).map_err(fail)?,
                        None => placed,
                    };
                    let instance = Instance::new(mesh, material, transform).with_object(node as u32);
                    scene.add_instance(instance).map_err(fail)?;
                    scene.name_object(node as u32, self.name_of(node));
                }
            }
        }
        Ok(())
    }

    /// Name of a node; empty if it has none.
    fn name_of(&self, node: usize) -> &str {
        self.root.nodes.get(node).and_then(|node| node.name.as_deref()).unwrap_or_default()
    }

    /// Adds the clouds of splats.
    fn add_splats(&self, places: &Places, scene: &mut Scene) -> Result<(), LoadError> {
        let mut ids = Vec::with_capacity(self.clouds.len());
        for cloud in &self.clouds {
            ids.push(scene.add_splats(cloud.clone()).map_err(LoadError::scene("splats"))?);
        }
        for drawn in &self.draws {
            let Some(transform) = places.shown(drawn.node.place) else { continue };
            let node = drawn.node.node;
            let fail = |error| LoadError::scene(self.root.nodes.label(node))(error);
            for copy in drawn.copies.as_deref().unwrap_or(&[Transform::IDENTITY]) {
                let placed = transform.after(copy).map_err(fail)?;
                for &cloud in drawn.splats.iter().filter_map(|&k| ids.get(k)) {
                    let instance = SplatInstance::new(cloud, placed).with_object(node as u32);
                    scene.add_splat_instance(instance).map_err(fail)?;
                    scene.name_object(node as u32, self.name_of(node));
                }
            }
        }
        Ok(())
    }

    /// Key of the mesh that a node makes of a geometry. `known`: morph weights that have been looked up, `None` where
    /// all are 0.
    fn key(
        &self,
        geometry: usize,
        drawn: &Drawn,
        pose: &Pose,
        known: &mut BTreeMap<(usize, Weights), Option<Vec<f32>>>,
    ) -> PoseKey {
        let Some(deform) = self.shapes.get(geometry).and_then(|shape| shape.deform.as_ref()) else {
            return (geometry, None, None);
        };
        let skin = drawn.skin.filter(|k| deform.has_joints() && self.skins.contains_key(k));
        let weights = known.entry((geometry, drawn.weights)).or_insert_with(|| {
            let weight = |target| match drawn.weights {
                Weights::Mesh(mesh) => pose.weight(&self.root, None, mesh, target),
                Weights::Node(node, mesh) => pose.weight(&self.root, Some(node), mesh, target),
            };
            let list: Vec<f32> = deform.targets().map(weight).collect();
            list.iter().any(|&w| w != 0.0).then_some(list)
        });
        (geometry, skin, weights.is_some().then_some(drawn.weights))
    }

    fn add_cameras_and_lights(
        &self,
        pose: &Pose,
        places: &Places,
        scene: &mut Scene,
        warnings: &mut Warnings,
    ) {
        let root = &self.root;
        let lights = root.extensions.lights.as_ref().map_or(&[][..], |l| &l.lights);
        for &Content { place, node: k } in &self.contents {
            let (Some(transform), Some(node)) = (places.shown(place), root.nodes.get(k)) else { continue };
            let name = || root.nodes.label(k);
            if let Some(index) = node.camera {
                match (root.cameras.get(index.get()), pose.cameras.get(&index.get())) {
                    (Some(given), None) => camera::add(scene, given, index.get(), transform, warnings),
                    (Some(given), Some(changes)) => {
                        let changed = surface::changed_camera(given, changes);
                        camera::add(scene, &changed, index.get(), transform, warnings);
                    }
                    (None, _) => warnings.add(|| format!("{}: there is no camera {index}", name())),
                }
            }
            let light = node.extensions.as_deref().and_then(|e| e.light.as_ref()).and_then(|l| l.light);
            if let Some(index) = light {
                match (lights.get(index.get()), pose.lights.get(&index.get())) {
                    (Some(given), None) => light::add(scene, given, index.get(), transform, warnings),
                    (Some(given), Some(changes)) => {
                        let changed = surface::changed_light(given, changes);
                        light::add(scene, &changed, index.get(), transform, warnings);
                    }
                    (None, _) => warnings.add(|| format!("{}: there is no light {index}", name())),
                }
            }
        }
    }
}
