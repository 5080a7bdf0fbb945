//! EXT_mesh_gpu_instancing: many copies of one node's mesh.

use super::FORMAT;
use super::accessor::{self, Pick};
use super::buffers::Buffers;
use super::list::Index;
use super::model::{Instancing, Kind, Root};
use crate::budget::Budget;
use crate::{Context, LoadError};
use overcoat_scene::Transform;

/// The transforms of the copies relative to their node.
///
/// # Errors
/// [`LoadError`] naming the node.
pub(super) fn read(
    root: &Root,
    node: usize,
    given: &Instancing,
    buffers: &mut Buffers<'_>,
    context: &Context<'_>,
    budget: &mut Budget,
) -> Result<Vec<Transform>, LoadError> {
    let malformed = |message: String| {
        LoadError::malformed(FORMAT, format!("node {node}, EXT_mesh_gpu_instancing: {message}"))
    };
    let attributes = &given.attributes;
    let all = [attributes.translation, attributes.rotation, attributes.scale];
    let mut count = None;
    for index in all.into_iter().flatten() {
        accessor::require(root, index, buffers, context, budget)?;
        let own = accessor::get(root, index)?.count.0;
        if *count.get_or_insert(own) != own {
            return Err(malformed("its attributes differ in length".to_owned()));
        }
    }
    buffers.decompress(context.jobs)?;
    let count = count.unwrap_or(0);
    // Three attributes and the transform.
    budget.charge(|| format!("node {node}: {count} instances"), count, 40 + 96)?;
    let read3 =
        |index: Option<Index>, default: f32| attribute::<3>(root, buffers, index, Kind::Vec3, count, default);
    let translations = read3(attributes.translation, 0.0)?;
    let scales = read3(attributes.scale, 1.0)?;
    let mut rotations = attribute::<4>(root, buffers, attributes.rotation, Kind::Vec4, count, 0.0)?;
    if attributes.rotation.is_none() {
        rotations.iter_mut().for_each(|q| q[3] = 1.0);
    }
    translations
        .into_iter()
        .zip(rotations)
        .zip(scales)
        .map(|((t, r), s)| Transform::from_parts(t.map(f64::from), r.map(f64::from), s.map(f64::from)))
        .collect::<Result<_, _>>()
        .map_err(LoadError::scene(format!("node {node}, EXT_mesh_gpu_instancing")))
}

fn attribute<const N: usize>(
    root: &Root,
    buffers: &Buffers<'_>,
    index: Option<Index>,
    kind: Kind,
    count: u64,
    default: f32,
) -> Result<Vec<[f32; N]>, LoadError> {
    let count = usize::try_from(count).unwrap_or(0);
    let Some(index) = index else { return Ok(vec![[default; N]; count]) };
    let elements = accessor::resolve(root, buffers, index)?;
    if elements.kind != kind {
        let message = format!("accessor {index} has elements of the wrong type for instances");
        return Err(LoadError::malformed(FORMAT, message));
    }
    elements.floats(&Pick::Range(0..count))
}
