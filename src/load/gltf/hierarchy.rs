//! The scene graph, flattened.

use super::FORMAT;
use super::model::{Index, Node, Root, label};
use crate::limits::Limits;
use crate::load::LoadError;
use crate::scene::Transform;

/// A node of the scene with its place in the world.
pub(super) struct Placed {
    /// Its number.
    pub node: usize,
    /// Node to world space.
    pub transform: Transform,
}

/// All visible nodes of the default scene that hold something, parents before children, in the order of the file:
/// of the scene that the file names, else of the first one, else all nodes that are no one's child.
///
/// Works without recursion. Nodes form a tree: one that is reached twice, through a cycle or by two parents, is an
/// error.
///
/// # Errors
/// [`LoadError`] naming the node.
pub(super) fn flatten(root: &Root, limits: &Limits) -> Result<Vec<Placed>, LoadError> {
    let name = |k: usize| label::<Node>(k, root.nodes[k].name.as_deref());
    let mut open: Vec<(Index, u64, Transform)> = Vec::new();
    let push =
        |open: &mut Vec<_>, list: &[Index], depth: u64, parent: &Transform, of: &dyn Fn() -> String| {
            if let Some(missing) = list.iter().find(|k| k.get() >= root.nodes.len()) {
                return Err(LoadError::malformed(FORMAT, format!("{}: there is no node {missing}", of())));
            }
            open.extend(list.iter().rev().map(|&k| (k, depth, *parent)));
            Ok(())
        };
    match scene(root)? {
        Some((k, nodes)) => push(&mut open, nodes, 1, &Transform::IDENTITY, &|| format!("scene {k}"))?,
        None => push(&mut open, &parentless(root), 1, &Transform::IDENTITY, &String::new)?,
    }

    let mut reached = vec![false; root.nodes.len()];
    let mut placed = Vec::new();
    while let Some((index, depth, parent)) = open.pop() {
        let k = index.get();
        if std::mem::replace(&mut reached[k], true) {
            let message = format!("{} is reached twice: nodes must form a tree", name(k));
            return Err(LoadError::malformed(FORMAT, message));
        }
        Limits::check(|| format!("depth of {}", name(k)), depth, limits.depth, "depth")?;
        let node = &root.nodes[k];
        let extensions = node.extensions.as_deref();
        if extensions.and_then(|e| e.visibility.as_ref()).is_some_and(|v| v.visible == Some(false)) {
            continue;
        }
        if node.matrix.as_deref().is_some_and(is_projective) {
            let message = format!("{}: its matrix is a projection, which no node can have", name(k));
            return Err(LoadError::malformed(FORMAT, message));
        }
        let transform =
            local(node).and_then(|t| parent.after(&t)).map_err(|e| LoadError::scene(name(k))(e))?;
        push(&mut open, &node.children, depth + 1, &transform, &|| name(k))?;
        if node.mesh.is_some() || node.camera.is_some() || extensions.is_some_and(|e| e.light.is_some()) {
            placed.push(Placed { node: k, transform });
        }
    }
    Ok(placed)
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

/// Node to parent.
fn local(node: &Node) -> Result<Transform, crate::scene::SceneError> {
    if let Some(matrix) = &node.matrix {
        return Transform::from_columns(**matrix);
    }
    Transform::from_parts(
        node.translation.as_deref().copied().unwrap_or([0.0; 3]),
        node.rotation.as_deref().copied().unwrap_or([0.0, 0.0, 0.0, 1.0]),
        node.scale.as_deref().copied().unwrap_or([1.0; 3]),
    )
}
