//! The mesh of an object to meshes of the scene: one for each thing that it is made of.

use super::look::{Corner, Key, Look, look};
use super::model::{Mesh as Source, Model, NONE};
use super::paint::Painter;
use super::slicer::{Settings, Volume};
use super::{Builder, Drawn};
use crate::load::LoadError;
use crate::load::normals::add_smooth_normals;
use crate::load::plain::{CREASE_ANGLE, check_mesh};
use crate::scene::{Mesh, MeshData};
use std::collections::BTreeMap;

/// Copies of a vertex (of other colours or places in a texture) that are searched for an equal one before another is
/// made: bounds the work.
const SEARCHED: usize = 64;

/// The volume of a slicer that a triangle belongs to, where their list is in the order of their triangles.
fn volume_of(volumes: &[Volume], triangle: usize) -> Option<&Volume> {
    let after = volumes.partition_point(|volume| volume.first as usize <= triangle);
    volumes[..after].last().filter(|volume| volume.last as usize >= triangle)
}

/// What the triangles of an object look like.
struct Looking<'a> {
    model: &'a Model,
    source: &'a Source,
    volumes: &'a [Volume],
    settings: &'a Settings,
    extruder: Option<u32>,
}

impl Looking<'_> {
    /// False for triangles of parts that only a slicer cares for.
    fn is_drawn(&self, triangle: usize) -> bool {
        volume_of(self.volumes, triangle).is_none_or(|volume| !volume.left_out)
    }

    fn of(&self, triangle: usize, painted: u32) -> Look {
        if painted > 0 {
            return Look::of(Key::Filament(painted));
        }
        if let Some(&properties) = self.source.properties.get(triangle)
            && properties.group != NONE
        {
            return look(self.model, properties);
        }
        let extruder = volume_of(self.volumes, triangle).and_then(|volume| volume.extruder).or(self.extruder);
        match extruder.filter(|&extruder| self.settings.filament(Some(extruder)).is_some()) {
            Some(extruder) => Look::of(Key::Filament(extruder)),
            None => Look::of(Key::Plain),
        }
    }
}

/// Cuts the triangles that a slicer has painted. `drawn` has, for each triangle of the mesh, its number in the file and
/// the extruder of its paint: none at first. What the slicer does not say the colours of, and what has properties of
/// its own, stays as it is: how much that is, is returned.
fn paint(mesh: &mut MeshData, drawn: &mut Vec<(u32, u32)>, looking: &Looking<'_>) -> u64 {
    let source = looking.source;
    if source.painted.is_empty() {
        return 0;
    }
    let (mut triangles, mut cut) = (Vec::new(), Vec::new());
    let mut lost = 0;
    let (mut next, mut start) = (0, 0);
    let mut painter = Painter::new(mesh);
    for (k, &(t, _)) in drawn.iter().enumerate() {
        let triangle = painter.mesh.triangles[k];
        let whole = [(triangle, 0)];
        let mut is_cut = false;
        while let Some(&(number, end)) = source.painted.get(next)
            && number <= t
        {
            let code = &source.codes[start..end];
            let plain = source.properties.get(t as usize).is_none_or(|properties| properties.group == NONE);
            if number == t {
                let known =
                    |&(_, e): &([u32; 3], u32)| e == 0 || looking.settings.filament(Some(e)).is_some();
                is_cut = plain && painter.paint(triangle, code) && painter.parts.iter().all(known);
                lost += u64::from(!is_cut);
            }
            (next, start) = (next + 1, end);
        }
        let parts = if is_cut { &painter.parts[..] } else { &whole };
        triangles.extend(parts.iter().map(|part| part.0));
        cut.extend(parts.iter().map(|part| (t, part.1)));
    }
    mesh.triangles = triangles;
    *drawn = cut;
    lost
}

/// Triangles with one look, over the vertices of all.
#[derive(Default)]
struct Part {
    /// Numbers in the object and in the mesh of those that are drawn.
    triangles: Vec<[u32; 2]>,
    /// Some corner has a colour.
    colored: bool,
}

impl Builder<'_> {
    /// Adds the meshes of an object to the scene.
    pub(super) fn meshes_of(
        &mut self,
        model: usize,
        object: u32,
        extruder: Option<u32>,
    ) -> Result<Drawn, LoadError> {
        let of = &self.package.models[model];
        let Some(source) = of.objects.get(&object).and_then(|object| object.mesh.as_ref()) else {
            return Ok(Vec::new());
        };
        // Slicers list the objects of the first part.
        let volumes = if model == 0 { self.settings.volumes(object) } else { &[] };
        let looking = Looking { model: of, source, volumes, settings: &self.settings, extruder };
        let mut drawn: Vec<(u32, u32)> =
            (0..source.triangles.len()).filter(|&t| looking.is_drawn(t)).map(|t| (t as u32, 0)).collect();
        let lost = source.triangles.len() - drawn.len();
        let mut whole = MeshData {
            positions: source.positions.clone(),
            triangles: drawn.iter().map(|&(t, _)| source.triangles[t as usize]).collect(),
            ..MeshData::default()
        };
        // Before it is cut: a surface may be smooth across a change of colour.
        add_smooth_normals(&mut whole, CREASE_ANGLE, self.context.jobs);
        let unpainted = paint(&mut whole, &mut drawn, &looking);

        let mut numbers: BTreeMap<Key, usize> = BTreeMap::new();
        let mut parts: Vec<(Key, Part)> = Vec::new();
        let (mut missing, mut approximate) = (0_u64, false);
        for (k, &(t, painted)) in drawn.iter().enumerate() {
            let look = looking.of(t as usize, painted);
            let number = *numbers.entry(look.key).or_insert_with(|| {
                parts.push((look.key, Part::default()));
                parts.len() - 1
            });
            let part = &mut parts[number].1;
            part.triangles.push([t, k as u32]);
            part.colored |= look.corners.iter().any(|corner| corner.color != [1.0; 4]);
            missing += u64::from(look.missing);
            approximate |= look.approximate;
        }
        let mut cutter = Cutter::new(&whole);
        let mut cut = Vec::with_capacity(parts.len());
        for (key, part) in &parts {
            let textured = matches!(key, Key::Painted { texture: Some(_), .. });
            let corners = 3 * part.triangles.len() as u64;
            check_mesh(self.context, self.package.triangles, self.package.vertices)?;
            if textured || part.colored {
                self.budget.charge(|| format!("3MF: the colours of object {object}"), corners, 48)?;
            }
            cut.push((*key, cutter.cut(part, textured, |t| looking.of(t as usize, 0).corners)));
        }
        self.report(object, lost, missing, approximate, unpainted);

        let mut meshes = Vec::with_capacity(cut.len());
        for (key, data) in cut {
            let element = format!("3MF: object {object}");
            let material = self.material(model, key)?;
            let mesh = Mesh::new(data).map_err(LoadError::scene(element.clone()))?;
            meshes.push((self.scene.add_mesh(mesh).map_err(LoadError::scene(element))?, material));
        }
        Ok(meshes)
    }

    fn report(&mut self, object: u32, lost: usize, missing: u64, approximate: bool, unpainted: u64) {
        if lost > 0 {
            self.warnings.add(|| {
                format!(
                    "3MF: of object {object} {lost} triangles left out that only change how it is printed"
                )
            });
        }
        if missing > 0 {
            self.warnings.add(|| {
                format!("3MF: of object {object} {missing} triangles have properties that do not exist")
            });
        }
        if unpainted > 0 {
            self.warnings.add(|| {
                format!(
                    "3MF: of object {object} {unpainted} triangles are painted by a slicer, which is not drawn"
                )
            });
        }
        if approximate {
            self.say("layers of colours and textures are drawn approximately");
        }
    }
}

/// Cuts a mesh into parts.
struct Cutter<'a> {
    whole: &'a MeshData,
    /// For each vertex the part that used it last, and its first copy in that.
    owner: Vec<u32>,
    first: Vec<u32>,
    parts: u32,
}

impl<'a> Cutter<'a> {
    fn new(whole: &'a MeshData) -> Self {
        let vertices = whole.positions.len();
        Self { whole, owner: vec![NONE; vertices], first: vec![NONE; vertices], parts: 0 }
    }

    /// The triangles of a part over vertices of their own.
    fn cut(&mut self, part: &Part, textured: bool, corners: impl Fn(u32) -> [Corner; 3]) -> MeshData {
        let number = self.parts;
        self.parts += 1;
        let mut out = MeshData::default();
        out.triangles.reserve_exact(part.triangles.len());
        let varied = textured || part.colored;
        // Of each vertex of the part, what it has of its own, and the next copy of the same vertex.
        let mut own: Vec<(Corner, u32)> = Vec::new();
        for &[t, k] in &part.triangles {
            let looks = if varied { corners(t) } else { Look::of(Key::Plain).corners };
            let mut triangle = [0; 3];
            for ((out_vertex, &vertex), corner) in
                triangle.iter_mut().zip(&self.whole.triangles[k as usize]).zip(looks)
            {
                let v = vertex as usize;
                if self.owner[v] != number {
                    self.owner[v] = number;
                    self.first[v] = NONE;
                }
                let mut at = self.first[v];
                for _ in 0..SEARCHED {
                    if at == NONE || own[at as usize].0 == corner {
                        break;
                    }
                    at = own[at as usize].1;
                }
                if at == NONE || own[at as usize].0 != corner {
                    at = own.len() as u32;
                    own.push((corner, self.first[v]));
                    self.first[v] = at;
                    out.positions.push(self.whole.positions[v]);
                    out.normals.extend(self.whole.normals.get(v));
                }
                *out_vertex = at;
            }
            out.triangles.push(triangle);
        }
        if part.colored {
            out.colors = own.iter().map(|(corner, _)| corner.color).collect();
        }
        if textured {
            out.uvs[0] = own.iter().map(|(corner, _)| corner.uv).collect();
        }
        out
    }
}
