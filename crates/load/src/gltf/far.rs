//! Scenes far from zero: nodes and vertices are measured from an origin among them.

use super::hierarchy::Places;
use super::mesh;
use super::pose::Pose;
use super::rig::Rig;
use crate::LoadError;
use crate::origin::{Origin, lost_steps, move_positions};
use overcoat_scene::{Bounds, Mesh, Transform};
use std::collections::BTreeMap;
use std::sync::OnceLock;

/// Origins: of the scene, and of the geometries whose vertices were moved towards zero.
#[derive(Default)]
pub(super) struct Far {
    /// Zero of the scene, in the coordinates of the file: the same in every pose.
    origin: OnceLock<[f64; 3]>,
    /// Geometries whose vertices have been moved, and the way back to where they are in the file.
    moved: BTreeMap<usize, Transform>,
}

impl Far {
    /// The way of a geometry's vertices to where they are in the file, if they have been moved.
    pub(super) fn way_back(&self, geometry: usize) -> Option<&Transform> {
        if self.moved.is_empty() { None } else { self.moved.get(&geometry) }
    }
}

impl Rig {
    /// Measures vertices that are far from zero in their own coordinates from an origin among them: one for all, where that
    /// is near enough, so that meshes which meet there still do. What skins move stays.
    ///
    /// # Errors
    /// [`LoadError::Scene`] naming the primitive.
    pub(super) fn bring_near(&mut self) -> Result<(), LoadError> {
        let mut far = Vec::new();
        let mut all = Bounds::EMPTY;
        for (k, shape) in self.shapes.iter().enumerate() {
            if shape.mesh.bounds().is_far() && !shape.deform.as_ref().is_some_and(|d| d.has_joints()) {
                far.push(k);
                all = all.union(shape.mesh.bounds());
            }
        }
        let common = all.is_far().then(|| all.round_center());
        let mut lost = None;
        for k in far {
            let Some(shape) = self.shapes.get_mut(k) else { continue };
            let name = mesh::name(&self.root, shape.of.0, shape.of.1);
            let own = *shape.mesh.bounds();
            if lost.is_none() {
                let of_what = if common.is_some() { &all } else { &own };
                lost = lost_steps(&format!("{name}: positions"), of_what);
            }
            let origin = Origin(common.unwrap_or_else(|| own.round_center()));
            let mut data = shape.mesh.data().clone();
            move_positions(&mut data, &origin);
            shape.mesh = Mesh::new(data).map_err(LoadError::scene(name.clone()))?;
            let way_back = Transform::translation(origin.0).map_err(LoadError::scene(name))?;
            self.far.moved.insert(k, way_back);
        }
        if let Some(message) = lost {
            self.warnings.add(|| message);
        }
        Ok(())
    }

    /// Zero of the scene, and where the nodes are in a pose, seen from there.
    ///
    /// # Errors
    /// [`LoadError::Scene`] naming a visible node whose transform overflows.
    pub(super) fn places(&self, pose: &Pose) -> Result<([f64; 3], Places), LoadError> {
        let root = &self.root;
        // Without an animation this is the pose already.
        let still = self.animation.is_none();
        if !still && let Some(&origin) = self.far.origin.get() {
            return Ok((origin, self.tree.places(root, pose, origin)?));
        }
        let at_rest = self.tree.places(root, &Pose::default(), [0.0; 3]);
        let found = at_rest.as_ref().map_or([0.0; 3], |places| self.find_origin(places));
        let origin = *self.far.origin.get_or_init(|| found);
        if still && origin == [0.0; 3] {
            return Ok((origin, at_rest?));
        }
        Ok((origin, self.tree.places(root, pose, origin)?))
    }

    /// Zero for the scene of nodes in these places: where it is, or, if everything is far away, a node's place, so that the
    /// scene is the one that it would be without that node's translation.
    fn find_origin(&self, places: &Places) -> [f64; 3] {
        let mut bounds = Bounds::EMPTY;
        let mut first = None;
        for drawn in &self.draws {
            let Some(place) = places.shown(drawn.node.place) else { continue };
            first.get_or_insert(drawn.node.place);
            for draw in drawn.mesh.iter() {
                let Some(shape) = self.shapes.get(draw.geometry) else { continue };
                let own = shape.mesh.bounds();
                let follows = shape.deform.as_ref().is_some_and(|deform| deform.has_joints());
                if let Some(skin) = drawn.skin.filter(|_| follows).and_then(|k| self.skins.get(&k)) {
                    bounds = bounds.union(&skin.reach(own, places));
                    continue;
                }
                for copy in drawn.copies.as_deref().unwrap_or(&[Transform::IDENTITY]) {
                    let mut placed = place.after(copy);
                    if let (Ok(before), Some(way_back)) = (&placed, self.far.way_back(draw.geometry)) {
                        placed = before.after(way_back);
                    }
                    if let Some(placed) = placed.ok().filter(Transform::keeps_surfaces) {
                        bounds = bounds.union(&own.transformed(&placed));
                    }
                }
            }
        }
        if !bounds.is_far() {
            return [0.0; 3];
        }
        // From there the scene is not far.
        let near = |&[x, y, z]: &[f64; 3]| {
            let less = |[a, b, c]: [f64; 3]| [a - x, b - y, c - z];
            !Bounds { min: less(bounds.min), max: less(bounds.max) }.is_far()
        };
        let path = first.map_or(Vec::new(), |place| self.tree.path(place));
        let of_nodes = path.into_iter().filter_map(|place| Some(places.transform(place)?.point([0.0; 3])));
        of_nodes.into_iter().find(near).unwrap_or_else(|| bounds.round_center())
    }
}
