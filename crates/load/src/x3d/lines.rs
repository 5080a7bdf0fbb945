//! Lines and points.

use super::FORMAT;
use super::faces::{Polygons, Values};
use super::node::Node;
use super::reading::Nodes;
use crate::mesh_formats::{check_mesh, drawable};
use crate::warnings::{Warnings, counted};
use crate::{Context, LoadError};
use overcoat_scene::{MeshData, PrimitiveKind};

/// The lines or points of a node; `None` for other nodes.
pub(super) fn read(
    node: &Node,
    nodes: &Nodes,
    context: &Context<'_>,
    warnings: &mut Warnings,
) -> Result<Option<MeshData>, LoadError> {
    let values = Values::read(node, nodes);
    let mut data = match node.kind.as_str() {
        "IndexedLineSet" => {
            let lists = Polygons::lists(&node.integers("coordIndex"));
            lines(node, &values, &lists, context)?
        }
        "LineSet" => {
            let mut lists = Polygons::default();
            let mut next = 0_u32;
            for count in node.integers("vertexCount") {
                let left = (values.positions.len() as u32).saturating_sub(next);
                let end = next.saturating_add(u32::try_from(count).unwrap_or(0).min(left));
                lists.corners.extend((next..end).map(|v| (v, v)));
                lists.sizes.push(end.saturating_sub(next));
                next = end;
            }
            lines(node, &values, &lists, context)?
        }
        "PointSet" => {
            check_mesh(context, 0, values.positions.len() as u64)?;
            let mut data = MeshData::new(values.positions, Vec::new());
            data.kind = PrimitiveKind::Points;
            if values.colors.len() >= data.positions.len() {
                data.colors = values.colors;
                data.colors.truncate(data.positions.len());
            } else if !values.colors.is_empty() {
                warnings.add(|| {
                    format!("{FORMAT}: a PointSet has fewer colors than points, and is drawn without")
                });
            }
            data
        }
        _ => return Ok(None),
    };
    // Lines refer to vertices that can be drawn.
    if data.kind == PrimitiveKind::Points {
        let keep: Vec<bool> = data.positions.iter().map(|&p| drawable(p)).collect();
        let bad = keep.iter().filter(|keep| !**keep).count();
        if bad > 0 {
            let points = counted(bad as u64, "point");
            warnings.add(|| format!("{FORMAT}: {points} left out: not finite or beyond 1e15"));
            let mut kept = keep.iter();
            data.positions.retain(|_| kept.next() == Some(&true));
            let mut kept = keep.iter();
            data.colors.retain(|_| kept.next() == Some(&true));
        }
    }
    Ok(Some(data))
}

fn lines(
    node: &Node,
    values: &Values,
    lists: &Polygons,
    context: &Context<'_>,
) -> Result<MeshData, LoadError> {
    let count = lists.corners.len() as u64;
    check_mesh(context, count, count)?;
    let per_vertex = node.flag("colorPerVertex", true);
    let indices = node.integers("colorIndex");
    let mut data = MeshData::default();
    data.kind = PrimitiveKind::Lines;
    for (list, line) in lists.iter().zip(0_u32..) {
        let mut before = None;
        for &(vertex, place) in list {
            let position = values.positions.get(vertex as usize).copied();
            let Some(position) = position.filter(|&p| drawable(p)) else {
                before = None;
                continue;
            };
            let own = data.positions.len() as u32;
            data.positions.push(position);
            if !values.colors.is_empty() {
                let (plain, listed) = if per_vertex { (vertex, place) } else { (line, line) };
                let color = match indices.get(listed as usize) {
                    Some(&index) => usize::try_from(index).unwrap_or(usize::MAX),
                    None => plain as usize,
                };
                data.colors.push(values.colors.get(color).copied().unwrap_or([1.0; 4]));
            }
            if let Some(before) = before {
                data.triangles.push([before, own, own]);
            }
            before = Some(own);
        }
    }
    Ok(data)
}
