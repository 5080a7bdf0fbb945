//! The scene graph: its nodes in a list, parents before children, and where they are in a pose.

use super::FORMAT;
use super::model::{Index, Node, Root, label};
use super::pose::Pose;
use crate::limits::Limits;
use crate::load::LoadError;
use crate::scene::{SceneError, Transform};

/// No place in the list.
const NOWHERE: u32 = u32::MAX;
/// On the way from a joint to its root.
const ON_THE_WAY: u32 = u32::MAX - 1;

/// The nodes of the scene that is drawn: of the one that the file names, else of the first one, else all nodes that
/// are no one's child. Behind them joints that are in no scene, with their ancestors.
pub(super) struct Tree {
    /// Parents before children, in the order of the file.
    list: Vec<Reached>,
    /// Place of each node of the file in the list.
    places: Vec<u32>,
    /// First parent of each node of the file; empty until it is needed.
    parents: Vec<u32>,
}

struct Reached {
    node: u32,
    parent: Option<u32>,
    /// False for those that only move others.
    in_scene: bool,
}

/// Where the nodes of a [`Tree`] are, by place.
pub(super) struct Places {
    /// Node to world space; `None` where that overflows.
    transforms: Vec<Option<Transform>>,
    visible: Vec<bool>,
}

impl Tree {
    /// Finds the nodes of the scene, without recursion. Nodes form a tree: one that is reached twice, through a cycle
    /// or by two parents, is an error.
    ///
    /// # Errors
    /// [`LoadError`] naming the node.
    pub(super) fn new(root: &Root, limits: &Limits) -> Result<Self, LoadError> {
        let name = |k: usize| label::<Node>(k, root.nodes[k].name.as_deref());
        let mut open: Vec<(Index, u64, Option<u32>)> = Vec::new();
        let push = |open: &mut Vec<_>,
                    list: &[Index],
                    depth: u64,
                    parent: Option<u32>,
                    of: &dyn Fn() -> String| {
            if let Some(missing) = list.iter().find(|k| k.get() >= root.nodes.len()) {
                return Err(LoadError::malformed(FORMAT, format!("{}: there is no node {missing}", of())));
            }
            open.extend(list.iter().rev().map(|&k| (k, depth, parent)));
            Ok(())
        };
        match scene(root)? {
            Some((k, nodes)) => push(&mut open, nodes, 1, None, &|| format!("scene {k}"))?,
            None => push(&mut open, &parentless(root), 1, None, &String::new)?,
        }
        let mut list = Vec::new();
        let mut places = vec![NOWHERE; root.nodes.len()];
        while let Some((index, depth, parent)) = open.pop() {
            let k = index.get();
            let place = list.len() as u32;
            if std::mem::replace(&mut places[k], place) != NOWHERE {
                let message = format!("{} is reached twice: nodes must form a tree", name(k));
                return Err(LoadError::malformed(FORMAT, message));
            }
            Limits::check(|| format!("depth of {}", name(k)), depth, limits.depth, "depth")?;
            if root.nodes[k].matrix.as_deref().is_some_and(is_projective) {
                let message = format!("{}: its matrix is a projection, which no node can have", name(k));
                return Err(LoadError::malformed(FORMAT, message));
            }
            push(&mut open, &root.nodes[k].children, depth + 1, Some(place), &|| name(k))?;
            list.push(Reached { node: index.0, parent, in_scene: true });
        }
        Ok(Self { list, places, parents: Vec::new() })
    }

    /// The place of a joint. One that is not in the scene is taken in with its ancestors.
    ///
    /// # Errors
    /// [`LoadError`] naming the node.
    pub(super) fn reach(&mut self, root: &Root, joint: usize, limits: &Limits) -> Result<usize, LoadError> {
        let name = |k: usize| label::<Node>(k, root.nodes[k].name.as_deref());
        if self.parents.is_empty() {
            self.parents = vec![NOWHERE; root.nodes.len()];
            for (k, node) in root.nodes.iter().enumerate() {
                for child in &node.children {
                    if let Some(parent @ &mut NOWHERE) = self.parents.get_mut(child.get()) {
                        *parent = k as u32;
                    }
                }
            }
        }
        let mut chain = Vec::new();
        let mut at = joint;
        let mut parent = None;
        loop {
            match self.places[at] {
                NOWHERE => {}
                ON_THE_WAY => {
                    let message = format!("{} is its own ancestor: nodes must form a tree", name(at));
                    return Err(LoadError::malformed(FORMAT, message));
                }
                place => {
                    parent = Some(place);
                    break;
                }
            }
            self.places[at] = ON_THE_WAY;
            chain.push(at);
            Limits::check(|| format!("depth of {}", name(joint)), chain.len() as u64, limits.depth, "depth")?;
            match self.parents[at] {
                NOWHERE => break,
                next => at = next as usize,
            }
        }
        for node in chain.into_iter().rev() {
            let place = self.list.len() as u32;
            self.places[node] = place;
            self.list.push(Reached { node: node as u32, parent, in_scene: false });
            parent = Some(place);
        }
        Ok(self.places[joint] as usize)
    }

    /// The node at a place.
    pub(super) fn node(&self, place: usize) -> usize {
        self.list[place].node as usize
    }

    /// Places of the nodes of the scene that hold something and are visible in the file or in one of the given nodes'
    /// other states: `changes` says whether a node's visibility may change.
    pub(super) fn contents(&self, root: &Root, changes: impl Fn(usize) -> bool) -> Vec<usize> {
        let mut seen = vec![false; self.list.len()];
        let mut out = Vec::new();
        for (place, reached) in self.list.iter().enumerate() {
            let k = reached.node as usize;
            let node = &root.nodes[k];
            let above = reached.parent.is_none_or(|parent| seen[parent as usize]);
            seen[place] = above && reached.in_scene && (node.is_visible() || changes(k));
            let light = node.extensions.as_deref().is_some_and(|e| e.light.is_some());
            if seen[place] && (node.mesh.is_some() || node.camera.is_some() || light) {
                out.push(place);
            }
        }
        out
    }

    /// Where every node is in a pose.
    ///
    /// # Errors
    /// [`LoadError::Scene`] naming a visible node whose transform overflows.
    pub(super) fn places(&self, root: &Root, pose: &Pose) -> Result<Places, LoadError> {
        let mut transforms: Vec<Option<Transform>> = Vec::with_capacity(self.list.len());
        let mut visible: Vec<bool> = Vec::with_capacity(self.list.len());
        for reached in &self.list {
            let k = reached.node as usize;
            let node = &root.nodes[k];
            let parent = reached.parent.map(|parent| parent as usize);
            let shown = pose.visible(k).unwrap_or_else(|| node.is_visible());
            let shown = shown && reached.in_scene && parent.is_none_or(|parent| visible[parent]);
            let above = parent.map_or(Some(Transform::IDENTITY), |parent| transforms[parent]);
            let transform =
                pose.local(node, k).ok().zip(above).and_then(|(own, above)| above.after(&own).ok());
            if shown && transform.is_none() {
                let name = label::<Node>(k, node.name.as_deref());
                return Err(LoadError::scene(name)(SceneError::NotFinite { what: "transform" }));
            }
            transforms.push(transform);
            visible.push(shown);
        }
        Ok(Places { transforms, visible })
    }
}

impl Places {
    /// Node to world space, of a node that is shown.
    pub(super) fn shown(&self, place: usize) -> Option<&Transform> {
        if self.visible[place] { self.transforms[place].as_ref() } else { None }
    }

    /// Node to world space, also where it is hidden; `None` if that overflows.
    pub(super) fn transform(&self, place: usize) -> Option<&Transform> {
        self.transforms[place].as_ref()
    }
}

/// Number and nodes of the scene to draw.
fn scene(root: &Root) -> Result<Option<(usize, &[Index])>, LoadError> {
    let chosen = root.scene.map_or(0, Index::get);
    match root.scenes.get(chosen) {
        Some(scene) => Ok(Some((chosen, &scene.nodes))),
        None if root.scenes.is_empty() => Ok(None),
        None => Err(LoadError::malformed(FORMAT, format!("there is no scene {chosen}"))),
    }
}

/// Nodes that are no one's child.
fn parentless(root: &Root) -> Vec<Index> {
    let mut child = vec![false; root.nodes.len()];
    for k in root.nodes.iter().flat_map(|node| &node.children) {
        if let Some(flag) = child.get_mut(k.get()) {
            *flag = true;
        }
    }
    // The number of nodes has been checked against the limits, which are far below 2^32.
    (0..u32::MAX).zip(child).filter(|(_, child)| !child).map(|(k, _)| Index(k)).collect()
}

/// True if the last row of a matrix, given by columns, is not that of an affine one: 0, 0, 0, 1 but for rounding.
fn is_projective(m: &[f64; 16]) -> bool {
    [m[3], m[7], m[11], m[15] - 1.0].into_iter().any(|v| v.abs() > 1e-3)
}
