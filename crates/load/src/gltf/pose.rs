//! Values that an animation gives at one time.

use super::model::{Node, Root};
use super::pointer::{Camera, Light, Surface};
use overcoat_scene::{SceneError, Transform};
use std::collections::BTreeMap;

/// Values that take the place of those in the file. Empty: the pose of the file.
#[derive(Clone, Debug, Default)]
pub(super) struct Pose {
    nodes: BTreeMap<usize, NodePose>,
    mesh_weights: BTreeMap<usize, Vec<f32>>,
    /// Properties of materials, in the order of the channels.
    pub surfaces: BTreeMap<usize, Vec<(Surface, Vec<f64>)>>,
    /// Properties of lights, in the order of the channels.
    pub lights: BTreeMap<usize, Vec<(Light, Vec<f64>)>>,
    /// Properties of cameras, in the order of the channels.
    pub cameras: BTreeMap<usize, Vec<(Camera, Vec<f64>)>>,
}

/// Animated values of a node, in place of its own; `None` where nothing is animated.
#[derive(Clone, Debug, Default)]
pub(super) struct NodePose {
    pub translation: Option<[f64; 3]>,
    pub rotation: Option<[f64; 4]>,
    pub scale: Option<[f64; 3]>,
    pub weights: Option<Vec<f32>>,
    pub visible: Option<bool>,
}

impl Pose {
    /// Values of a node, to be changed.
    pub(super) fn node_mut(&mut self, node: usize) -> &mut NodePose {
        self.nodes.entry(node).or_default()
    }

    /// Changes the weights that a mesh has where nodes give none.
    pub(super) fn set_mesh_weights(&mut self, mesh: usize, weights: Vec<f32>) {
        self.mesh_weights.insert(mesh, weights);
    }

    /// Visibility of a node and its children, if it is animated.
    pub(super) fn visible(&self, node: usize) -> Option<bool> {
        self.nodes.get(&node)?.visible
    }

    /// Node to parent.
    pub(super) fn local(&self, node: &Node, k: usize) -> Result<Transform, SceneError> {
        if let Some(matrix) = &node.matrix {
            return Transform::from_columns(**matrix);
        }
        let changed = self.nodes.get(&k);
        let translation = changed.and_then(|c| c.translation).or(node.translation.as_deref().copied());
        let rotation = changed.and_then(|c| c.rotation).or(node.rotation.as_deref().copied());
        let scale = changed.and_then(|c| c.scale).or(node.scale.as_deref().copied());
        Transform::from_parts(
            translation.unwrap_or([0.0; 3]),
            rotation.unwrap_or([0.0, 0.0, 0.0, 1.0]),
            scale.unwrap_or([1.0; 3]),
        )
    }

    /// The weight of a morph target of a mesh, or of the mesh that a node with weights of its own shows.
    pub(super) fn weight(&self, root: &Root, node: Option<usize>, mesh: usize, target: usize) -> f32 {
        let changed = match node {
            Some(node) => self.nodes.get(&node).and_then(|n| n.weights.as_ref()),
            None => None,
        };
        if let Some(weights) = changed {
            return weights.get(target).copied().unwrap_or(0.0);
        }
        let own = node.and_then(|node| root.nodes.get(node)).map(|node| &node.weights);
        let own = own.filter(|own| !own.is_empty());
        match (own, self.mesh_weights.get(&mesh)) {
            (Some(own), _) => stored(own, target),
            (None, Some(weights)) => weights.get(target).copied().unwrap_or(0.0),
            (None, None) => root.meshes.get(mesh).map_or(0.0, |mesh| stored(&mesh.weights, target)),
        }
    }
}

/// A weight of the file, as far as single precision reaches.
pub(super) fn stored(weights: &[f64], target: usize) -> f32 {
    let weight = weights.get(target).map_or(0.0, |&w| w as f32);
    if weight.is_finite() { weight } else { 0.0 }
}
