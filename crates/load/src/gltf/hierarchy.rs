//! The scene graph: its nodes in a list, parents before children, and where they are in a pose.

use super::FORMAT;
use super::list::{Index, List};
use super::model::{Node, Root, Scene};
use super::pose::Pose;
use crate::LoadError;
use crate::warnings::Warnings;
use overcoat_core::limits::Limits;
use overcoat_scene::{SceneError, Transform};

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

/// A node of the scene that holds something.
#[derive(Clone, Copy, Debug)]
pub(super) struct Content {
    /// Its place in the tree.
    pub place: usize,
    /// Its number in the file.
    pub node: usize,
}

/// World transforms and visibility of the nodes of a [`Tree`], in its order.
pub(super) struct Places {
    list: Vec<Placed>,
}

#[derive(Clone, Copy)]
struct Placed {
    /// Node to world space; `None` where that overflows.
    transform: Option<Transform>,
    visible: bool,
}

impl Tree {
    /// Finds the nodes of the scene, without recursion. Nodes form a tree: one that is reached twice, through a cycle
    /// or by two parents, is drawn once; it and nodes that do not exist are named in warnings.
    ///
    /// # Errors
    /// [`LoadError::Limit`] naming a node that is too deep.
    pub(super) fn new(root: &Root, limits: &Limits, warnings: &mut Warnings) -> Result<Self, LoadError> {
        let name = |k: usize| root.nodes.label(k);
        let mut open: Vec<(Index, u64, Option<u32>)> = Vec::new();
        let roots = roots(root, warnings);
        open.extend(roots.iter().rev().map(|&k| (k, 1, None)));
        let mut list = Vec::new();
        let mut places = vec![NOWHERE; root.nodes.len()];
        while let Some((index, depth, parent)) = open.pop() {
            let k = index.get();
            let place = list.len() as u32;
            let (Some(node), Some(known)) = (root.nodes.get(k), places.get_mut(k)) else {
                warnings.add(|| match parent.and_then(|parent| list.get(parent as usize)) {
                    Some(Reached { node, .. }) => format!("{}: there is no node {k}", name(*node as usize)),
                    None => format!("the scene names node {k}, which there is not"),
                });
                continue;
            };
            if *known != NOWHERE {
                warnings
                    .add(|| format!("{} is reached twice and drawn once: nodes must form a tree", name(k)));
                continue;
            }
            *known = place;
            Limits::check(|| format!("depth of {}", name(k)), depth, limits.depth, "depth")?;
            if node.matrix.as_deref().is_some_and(is_projective) {
                warnings.add(|| format!("{}: its matrix is a projection; its last row is left out", name(k)));
            }
            open.extend(node.children.iter().rev().map(|&k| (k, depth.saturating_add(1), Some(place))));
            list.push(Reached { node: index.0, parent, in_scene: true });
        }
        Ok(Self { list, places, parents: Vec::new() })
    }

    /// The place of a joint. One that is not in the scene is taken in with its ancestors.
    ///
    /// # Errors
    /// [`LoadError`] naming the node.
    pub(super) fn reach(&mut self, root: &Root, joint: usize, limits: &Limits) -> Result<usize, LoadError> {
        let name = |k: usize| root.nodes.label(k);
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
        while let (Some(place), Some(&above)) = (self.places.get_mut(at), self.parents.get(at)) {
            match *place {
                NOWHERE => *place = ON_THE_WAY,
                ON_THE_WAY => {
                    let message = format!("{} is its own ancestor: nodes must form a tree", name(at));
                    return Err(LoadError::malformed(FORMAT, message));
                }
                known => {
                    parent = Some(known);
                    break;
                }
            }
            chain.push(at);
            Limits::check(|| format!("depth of {}", name(joint)), chain.len() as u64, limits.depth, "depth")?;
            if above == NOWHERE {
                break;
            }
            at = above as usize;
        }
        for node in chain.into_iter().rev() {
            let place = self.list.len() as u32;
            self.places.get_mut(node).into_iter().for_each(|known| *known = place);
            self.list.push(Reached { node: node as u32, parent, in_scene: false });
            parent = Some(place);
        }
        // The last of the chain is the joint itself.
        let missing = || LoadError::malformed(FORMAT, format!("there is no node {joint}"));
        parent.map(|place| place as usize).ok_or_else(missing)
    }

    /// The nodes of the scene that hold something and are visible in the file or in one of the given nodes' other
    /// states: `changes` says whether a node's visibility may change.
    ///
    /// # Errors
    /// [`LoadError::Malformed`] if there is no such node.
    pub(super) fn contents(
        &self,
        root: &Root,
        changes: impl Fn(usize) -> bool,
    ) -> Result<Vec<Content>, LoadError> {
        let mut seen: Vec<bool> = Vec::with_capacity(self.list.len());
        let mut out = Vec::new();
        for (place, reached) in self.list.iter().enumerate() {
            let k = reached.node as usize;
            let node = root.nodes.at(k)?;
            let above = reached.parent.is_none_or(|parent| seen.get(parent as usize) == Some(&true));
            let shown = above && reached.in_scene && (node.is_visible() || changes(k));
            let light = node.extensions.as_deref().is_some_and(|e| e.light.is_some());
            if shown && (node.mesh.is_some() || node.camera.is_some() || light) {
                out.push(Content { place, node: k });
            }
            seen.push(shown);
        }
        Ok(out)
    }

    /// A place and those of its ancestors, from the root on.
    pub(super) fn path(&self, place: usize) -> Vec<usize> {
        let parent = |&place: &usize| Some(self.list.get(place)?.parent? as usize);
        let mut path: Vec<usize> = std::iter::successors(Some(place), parent).collect();
        path.reverse();
        path
    }

    /// World transforms and visibility of all nodes in a pose, relative to `origin`.
    ///
    /// # Errors
    /// [`LoadError::Scene`] naming a visible node whose transform overflows.
    pub(super) fn places(&self, root: &Root, pose: &Pose, origin: [f64; 3]) -> Result<Places, LoadError> {
        // Minus zero, which that would be without an origin, would show in the signs of zeros.
        let from_origin = Transform::translation(origin.map(|v| 0.0 - v)).ok();
        let world = Placed { transform: from_origin, visible: true };
        let mut list: Vec<Placed> = Vec::with_capacity(self.list.len());
        for reached in &self.list {
            let k = reached.node as usize;
            let node = root.nodes.at(k)?;
            let above = reached.parent.map_or(Some(&world), |parent| list.get(parent as usize));
            let Some(above) = above else {
                let message = format!("{} comes before its parent", root.nodes.label(k));
                return Err(LoadError::malformed(FORMAT, message));
            };
            let shown = pose.visible(k).unwrap_or_else(|| node.is_visible());
            let visible = shown && reached.in_scene && above.visible;
            let own = pose.local(node, k).ok().zip(above.transform);
            let transform = own.and_then(|(own, above)| above.after(&own).ok());
            if visible && transform.is_none() {
                let name = root.nodes.label(k);
                return Err(LoadError::scene(name)(SceneError::NotFinite { what: "transform" }));
            }
            list.push(Placed { transform, visible });
        }
        Ok(Places { list })
    }
}

impl Places {
    /// Node to world space, of a node that is shown.
    pub(super) fn shown(&self, place: usize) -> Option<&Transform> {
        self.list.get(place).filter(|placed| placed.visible)?.transform.as_ref()
    }

    /// Node to world space, also where it is hidden; `None` if that overflows.
    pub(super) fn transform(&self, place: usize) -> Option<&Transform> {
        self.list.get(place)?.transform.as_ref()
    }
}

/// The nodes that the scene begins with: those of the one that the file names, else of the first one. If no mesh is in it,
/// of the first scene that has one, else all nodes that are no one's child. Nodes that are another's child as well are
/// drawn as that.
fn roots(root: &Root, warnings: &mut Warnings) -> Vec<Index> {
    let children = children(root);
    let is_child = |k: &Index| children.get(k.get()) == Some(&true);
    let parentless = || {
        // The number of nodes has been checked against the limits, which are far below 2^32.
        let all = (0..u32::MAX).map(Index).take(root.nodes.len());
        all.filter(|k| !is_child(k)).collect::<Vec<Index>>()
    };
    let chosen = root.scene.map_or(0, Index::get);
    let Some(scene) = root.scenes.get(chosen) else {
        if !root.scenes.is_empty() {
            warnings.add(|| format!("there is no scene {chosen}: all nodes are drawn"));
        }
        return parentless();
    };
    let mut nodes = &scene.nodes;
    let mut reached = vec![false; root.nodes.len()];
    if !reaches_mesh(root, nodes, &mut reached) && root.nodes.iter().any(|node| node.mesh.is_some()) {
        // Nodes that scenes without a mesh reach are marked, and not visited again for the next ones.
        let other = root.scenes.iter().position(|Scene { nodes }| reaches_mesh(root, nodes, &mut reached));
        match other.and_then(|k| Some((k, root.scenes.get(k)?))) {
            Some((k, other)) => {
                warnings.add(|| format!("scene {chosen} shows no mesh: scene {k} is drawn"));
                nodes = &other.nodes;
            }
            None => {
                warnings.add(|| format!("scene {chosen} shows no mesh: all nodes are drawn"));
                return parentless();
            }
        }
    }
    let (twice, roots): (Vec<Index>, Vec<Index>) = nodes.iter().partition(|k| is_child(k));
    // In a cycle every node is a child.
    if twice.is_empty() || roots.is_empty() {
        return nodes.clone();
    }
    let mut reached = vec![false; root.nodes.len()];
    reaches_mesh(root, &roots, &mut reached);
    let (doubled, alone): (Vec<Index>, Vec<Index>) =
        twice.into_iter().partition(|k| reached.get(k.get()) == Some(&true));
    if let Some(first) = doubled.first() {
        let name = || root.nodes.label(first.get());
        warnings.add(|| {
            format!("{} nodes are roots of the scene and children too, the first {}", doubled.len(), name())
        });
    }
    roots.into_iter().chain(alone).collect()
}

/// Marks these nodes and all below them; true if one that was not marked before has a mesh.
fn reaches_mesh(root: &Root, nodes: &[Index], reached: &mut [bool]) -> bool {
    let mut found = false;
    let mut open = nodes.to_vec();
    while let Some(k) = open.pop() {
        let Some(reached @ &mut false) = reached.get_mut(k.get()) else { continue };
        *reached = true;
        if let Some(node) = root.nodes.get(k.get()) {
            found |= node.mesh.is_some();
            open.extend(&node.children);
        }
    }
    found
}

/// True for nodes that are the child of another.
fn children(root: &Root) -> Vec<bool> {
    let mut child = vec![false; root.nodes.len()];
    for k in root.nodes.iter().flat_map(|node| &node.children) {
        if let Some(flag) = child.get_mut(k.get()) {
            *flag = true;
        }
    }
    child
}

/// Meshes of a file without nodes are put at the origin: a library of them, which other programs place.
pub(super) fn place_loose_meshes(root: &mut Root, warnings: &mut Warnings) {
    if !root.nodes.is_empty() || root.meshes.is_empty() {
        return;
    }
    warnings.add(|| format!("no node shows a mesh: {} meshes are drawn at the origin", root.meshes.len()));
    // Their number has been checked against the limit on nodes, which is far below 2^32.
    let numbers = (0..u32::MAX).take(root.meshes.len());
    root.nodes = List(numbers.map(|k| Node { mesh: Some(Index(k)), ..Node::default() }).collect());
    root.scenes = List::default();
    root.scene = None;
}

/// True if the last row of a matrix, given by columns, is not that of an affine one: 0, 0, 0, 1 but for rounding.
fn is_projective(m: &[f64; 16]) -> bool {
    [m[3], m[7], m[11], m[15] - 1.0].into_iter().any(|v| v.abs() > 1e-3)
}
