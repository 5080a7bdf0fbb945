//! Plan of everything that a file needs to be drawn, before any data is read: serial, in the order of the file.

use super::animation::Channels;
use super::deform::Usage;
use super::hierarchy::{Content, Tree};
use super::list::Index;
use super::mesh::{self, Geometry};
use super::model::Root;
use super::pointer::Target;
use super::rig::{Draw, Drawn, Weights};
use super::{FORMAT, Loader, camera, instancing, material, pose, skin, splats, variant};
use crate::LoadError;
use crate::clay::{clay, white_clay};
use crate::tangents::tangent_set;
use overcoat_core::limits::Limits;
use overcoat_scene::Material;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// The draws of a mesh, and the clouds of splats among its primitives.
type Known = (Arc<[Draw]>, Arc<[usize]>);

/// Bytes charged for an instance: the scene's and what the renderer keeps for it.
const INSTANCE_BYTES: u64 = 256;

impl Loader<'_> {
    /// Finds what the nodes draw, and makes sure that it is within the limits. Also gives all nodes that show something.
    pub(super) fn plan(
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
        let mut known: BTreeMap<usize, Known> = BTreeMap::new();
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
                let missing = LoadError::malformed(FORMAT, format!("{}: there is no mesh {mesh}", name()));
                self.failures.add(missing, name, &mut self.warnings)?;
                continue;
            };
            let (list, splats) = match known.get(&mesh) {
                Some((list, splats)) => (Arc::clone(list), Arc::clone(splats)),
                None => {
                    let (list, splats) = self.plan_mesh(mesh, usage)?;
                    let (list, splats): Known = (list.into(), splats.into());
                    known.insert(mesh, (Arc::clone(&list), Arc::clone(&splats)));
                    (list, splats)
                }
            };
            let mut copies = match node.extensions.as_deref().and_then(|e| e.instancing.as_ref()) {
                None => None,
                Some(given) => {
                    match instancing::read(root, k, given, &mut self.buffers, self.context, &mut self.budget)
                    {
                        Err(error) if error.is_partial() => {
                            let reason = error.reason();
                            self.warnings.add(|| format!("{} is drawn once: {reason}", name()));
                            None
                        }
                        result => Some(result?),
                    }
                }
            };
            let mut skin = None;
            if let Some(index) = node.skin {
                let index = index.get();
                let mut geometries = list.iter().filter_map(|draw| self.geometries.get(draw.geometry));
                if geometries.any(Geometry::has_joints) {
                    match self.read_skin(index, tree) {
                        Err(error) if error.is_partial() => {
                            let reason = error.reason();
                            self.warnings.add(|| format!("{} is drawn without its skin: {reason}", name()));
                        }
                        result => skin = result.map(|()| Some(index))?,
                    }
                    if skin.is_some() && copies.as_ref().is_some_and(|copies| copies.len() > 1) {
                        self.warnings.add(|| format!("{}: a mesh with a skin is drawn once", name()));
                    }
                    copies = copies.filter(|_| skin.is_none());
                } else if index >= root.skins.len() {
                    self.warnings.add(|| format!("{}: there is no skin {index}", name()));
                }
            }
            let own = !node.weights.is_empty() || targets.contains(&Target::Weights(k));
            let weights = if own { Weights::Node(k, mesh) } else { Weights::Mesh(mesh) };
            let count = copies.as_ref().map_or(1, |copies| copies.len() as u64);
            let geometries = list.iter().filter_map(|draw| self.geometries.get(draw.geometry));
            let each = geometries.map(|geometry| geometry.triangles).fold(0, u64::saturating_add);
            triangles = triangles.saturating_add(each.saturating_mul(count));
            let placed = list.len().saturating_add(splats.len()) as u64;
            instances = instances.saturating_add(count.saturating_mul(placed));
            Limits::check(
                || format!("triangles up to {}", name()),
                triangles,
                self.context.limits.triangles,
                "triangles",
            )?;
            draws.push(Drawn { node: content, mesh: list, splats, copies, skin, weights });
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

    /// The draws of a mesh, and the clouds of splats among its primitives.
    fn plan_mesh(&mut self, mesh: usize, usage: &Usage) -> Result<(Vec<Draw>, Vec<usize>), LoadError> {
        let root = self.root;
        let (mut draws, mut clouds) = (Vec::new(), Vec::new());
        for (k, primitive) in root.meshes.at(mesh)?.primitives.iter().enumerate() {
            let splats = splats::plan(
                root,
                (mesh, k),
                primitive,
                &mut self.buffers,
                self.context,
                &mut self.budget,
                &mut self.warnings,
            );
            match splats {
                Ok(None) => {}
                Ok(Some(source)) => {
                    clouds.push(self.clouds.len());
                    self.clouds.push(source);
                    continue;
                }
                Err(error) => {
                    self.failures.add(error, || mesh::name(root, mesh, k), &mut self.warnings)?;
                    continue;
                }
            }
            let mut material = variant::material(primitive, self.variant).map(Index::get);
            if let Some(missing) = material.filter(|&m| m >= root.materials.len()) {
                let name = || mesh::name(root, mesh, k);
                self.warnings
                    .add(|| format!("{}: there is no material {missing}; the default one is used", name()));
                material = None;
            }
            let material = self.plan_material(
                material,
                mesh::is_unlit(primitive),
                primitive.attributes.color.is_some(),
            )?;
            let tangents_for = self.materials.get(material).and_then(|(_, material)| tangent_set(material));
            let wanted = mesh::Wanted {
                tangents_for,
                uv_sets: self.uv_sets.get(material).copied().unwrap_or([0, 1]),
                usage,
            };
            let planned = mesh::plan(
                root,
                (mesh, k),
                wanted,
                &mut self.buffers,
                self.context,
                &mut self.budget,
                &mut self.warnings,
            );
            let planned = match planned {
                Err(error) => {
                    self.failures.add(error, || mesh::name(root, mesh, k), &mut self.warnings)?;
                    None
                }
                Ok(planned) => planned,
            };
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
        Ok((draws, clouds))
    }

    /// The place of a material, or of the same one without light, for a primitive that may have colours of its own.
    fn plan_material(
        &mut self,
        index: Option<usize>,
        unlit: bool,
        colored: bool,
    ) -> Result<usize, LoadError> {
        // Only those that the file says nothing of depend on them.
        let colored = colored && index.is_none();
        let key = (index, unlit, colored);
        if let Some(&place) = self.material_places.get(&key) {
            return Ok(place);
        }
        // Far larger than what the file says of it; twice, for a list that grows.
        self.budget.charge(|| "materials".to_owned(), 2, size_of::<Material>() as u64)?;
        let (mut material, uv_sets) = match index {
            // A rough white metal is what a primitive among others is made of, and nobody's choice for a whole file.
            None if self.root.materials.is_empty() && colored => (white_clay(), [0, 1]),
            None if self.root.materials.is_empty() => (clay(), [0, 1]),
            None => (material::default_material(), [0, 1]),
            Some(index) => material::convert(self.root, index, &mut self.textures, &mut self.warnings)?,
        };
        material.unlit |= unlit;
        let place = self.materials.len();
        self.materials.push((index, material));
        self.uv_sets.push(uv_sets);
        self.material_places.insert(key, place);
        Ok(place)
    }
}

/// Deformation of each mesh by all nodes of the scene that use it.
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
