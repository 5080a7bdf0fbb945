//! Points and lines: `p`, `l`, and files of nothing but vertices.
//!
//! Every `p` of an object and material is a point of one mesh, every `l` of them a part of another. Lines have no normals,
//! so they are drawn without light, as the specification of glTF has it; points are lit as the surface that they are
//! points of.

use super::assemble::colors;
use super::parse::{Corner, Obj};
use crate::mesh_formats::{add_object, check_mesh, drawable};
use crate::{Context, LoadError};
use overcoat_scene::{MaterialId, MeshData, PrimitiveKind, Scene};
use std::collections::BTreeMap;

/// Points or line segments from corner `first` of [`Obj::stroke_corners`] on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Stroke {
    pub(super) first: usize,
    pub(super) object: u32,
    /// Place in [`Obj::materials`].
    pub(super) material: Option<u32>,
    /// Two corners are a segment; else each is a point.
    pub(super) is_line: bool,
}

/// The strokes of each object and material, points apart from lines, in the order of the file.
#[derive(Default)]
pub(super) struct Strokes<'a> {
    /// Object and material of each mesh.
    pub(super) keys: Vec<(u32, Option<u32>)>,
    /// Its corners.
    parts: Vec<(bool, Vec<&'a [Corner]>)>,
}

impl<'a> Strokes<'a> {
    pub(super) fn new(obj: &'a Obj) -> Self {
        let mut numbers = BTreeMap::new();
        let mut out = Self::default();
        let ends = obj.strokes.iter().skip(1).map(|next| next.first).chain([obj.stroke_corners.len()]);
        for (stroke, end) in obj.strokes.iter().zip(ends) {
            let key = (stroke.object, stroke.material, stroke.is_line);
            let number = *numbers.entry(key).or_insert_with(|| {
                out.keys.push((stroke.object, stroke.material));
                out.parts.push((stroke.is_line, Vec::new()));
                out.parts.len().saturating_sub(1)
            });
            let corners = obj.stroke_corners.get(stroke.first..end).unwrap_or_default();
            if let Some((_, part)) = out.parts.get_mut(number) {
                part.push(corners);
            }
        }
        out
    }

    /// Adds the meshes, with the material of each. Returns how many points and segments were left out, for their
    /// positions are missing or cannot be drawn.
    pub(super) fn add_to(
        &self,
        scene: &mut Scene,
        obj: &Obj,
        materials: &[MaterialId],
        context: &Context<'_>,
    ) -> Result<u64, LoadError> {
        let mut lost = 0_u64;
        for (((is_line, parts), &(object, _)), &material) in self.parts.iter().zip(&self.keys).zip(materials)
        {
            let mut mesh = Builder::new(obj, *is_line);
            for corner in parts.iter().copied().flat_map(|part| part.chunks(if *is_line { 2 } else { 1 })) {
                if !mesh.add(corner) {
                    lost = lost.saturating_add(1);
                }
            }
            let Builder { mut data, vertices, .. } = mesh;
            data.colors = colors(obj, &vertices);
            check_mesh(context, data.triangles.len() as u64, data.positions.len() as u64)?;
            if data.positions.is_empty() {
                continue;
            }
            let material = if *is_line { without_light(scene, material)? } else { material };
            add_object(scene, &format!("OBJ: object {object}"), data, material, object)?;
        }
        Ok(lost)
    }
}

/// A mesh of points or lines while it is made.
struct Builder<'a> {
    obj: &'a Obj,
    data: MeshData,
    /// The corner of each vertex.
    vertices: Vec<Corner>,
}

impl<'a> Builder<'a> {
    fn new(obj: &'a Obj, is_line: bool) -> Self {
        let kind = if is_line { PrimitiveKind::Lines } else { PrimitiveKind::Points };
        Self { obj, data: MeshData::default().with(|d| d.kind = kind), vertices: Vec::new() }
    }

    /// Adds a point or a segment, unless a position of it cannot be drawn.
    fn add(&mut self, corners: &[Corner]) -> bool {
        let position = |c: &Corner| self.obj.positions.get(c.position as usize).copied();
        if !corners.iter().all(|c| position(c).is_some_and(drawable)) {
            return false;
        }
        match corners {
            [a, b] => {
                let (a, b) = (self.vertex(*a), self.vertex(*b));
                self.data.triangles.push([a, b, b]);
            }
            [point] => {
                self.vertex(*point);
            }
            _ => return false,
        }
        true
    }

    /// The number of the vertex of a corner: that of the last one, where segments meet.
    fn vertex(&mut self, corner: Corner) -> u32 {
        let count = self.data.positions.len() as u32;
        if self.data.kind == PrimitiveKind::Lines && self.vertices.last() == Some(&corner) {
            return count.saturating_sub(1);
        }
        self.vertices.push(corner);
        let place = corner.position as usize;
        self.data.positions.extend(self.obj.positions.get(place));
        if !self.obj.uvs.is_empty() {
            // v runs up in OBJ, down here.
            let uv = self.obj.uvs.get(corner.uv as usize).map_or([0.0; 2], |&[u, v]| [u, 1.0 - v]);
            self.data.uvs[0].push(uv);
        }
        if self.data.kind == PrimitiveKind::Points && self.obj.has_point_normals {
            let normal = self.obj.normals.get(corner.normal as usize).copied().unwrap_or([0.0; 3]);
            self.data.normals.push(normal);
        }
        count
    }
}

/// A material as it looks without light.
fn without_light(scene: &mut Scene, id: MaterialId) -> Result<MaterialId, LoadError> {
    let lit = scene.materials().get(id.index()).cloned().unwrap_or_default();
    scene.add_material(lit.with(|m| m.unlit = true)).map_err(LoadError::scene("OBJ: material of lines"))
}
