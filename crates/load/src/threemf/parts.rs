//! The mesh of an object to meshes of the scene: one for each thing that it is made of.

use super::look::{Corner, Key, Look, look};
use super::model::{Mesh as Source, Model, NONE, Object};
use super::paint::Painter;
use super::slicer::{Settings, Volume};
use super::{Builder, Drawn};
use crate::LoadError;
use crate::mesh_formats::check_mesh;
use crate::normals::add_smooth_normals;
use crate::splitting::Variants;
use overcoat_scene::{CREASE_ANGLE, Mesh, MeshData};
use std::collections::BTreeMap;

/// Copies of a vertex (of other colours or places in a texture) that are searched for an equal one before another is
/// made: bounds the work.
const SEARCHED: usize = 65;

/// The volume of a slicer that a triangle belongs to, where their list is in the order of their triangles.
fn volume_of(volumes: &[Volume], triangle: usize) -> Option<&Volume> {
    let after = volumes.partition_point(|volume| volume.first as usize <= triangle);
    volumes.get(..after)?.last().filter(|volume| volume.last as usize >= triangle)
}

/// Sources of the appearance of an object's triangles.
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
    let mut lost = 0_u64;
    let (mut painted, mut start) = (source.painted.iter().peekable(), 0);
    let mut painter = Painter::new(mesh);
    for (k, &(t, _)) in drawn.iter().enumerate() {
        let Some(&triangle) = painter.mesh.triangles.get(k) else { break };
        let whole = [(triangle, 0)];
        let mut is_cut = false;
        while let Some(&&(number, end)) = painted.peek()
            && number <= t
        {
            let code = source.codes.get(start..end).unwrap_or_default();
            let plain = source.properties.get(t as usize).is_none_or(|properties| properties.group == NONE);
            if number == t {
                let known =
                    |&(_, e): &([u32; 3], u32)| e == 0 || looking.settings.filament(Some(e)).is_some();
                is_cut = plain && painter.paint(triangle, code) && painter.parts.iter().all(known);
                lost = lost.saturating_add(u64::from(!is_cut));
            }
            start = end;
            painted.next();
        }
        let parts = if is_cut { painter.parts.as_slice() } else { &whole };
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
        let of = self.package.models.get(model).map(|of| (of, of.objects.get(&object)));
        let Some((of, Some(Object { mesh: Some(source), .. }))) = of else { return Ok(Vec::new()) };
        // Slicers list the objects of the first part.
        let volumes = if model == 0 { self.settings.volumes(object) } else { &[] };
        let looking = Looking { model: of, source, volumes, settings: &self.settings, extruder };
        let is_drawn = |(t, triangle): (usize, &_)| looking.is_drawn(t).then_some(((t as u32, 0), *triangle));
        let (mut drawn, triangles): (Vec<(u32, u32)>, Vec<[u32; 3]>) =
            source.triangles.iter().enumerate().filter_map(is_drawn).unzip();
        let lost = source.triangles.len().saturating_sub(drawn.len());
        let mut whole = MeshData::new(source.positions.clone(), triangles);
        // Before it is cut: a surface may be smooth across a change of colour.
        add_smooth_normals(&mut whole, CREASE_ANGLE, self.context.jobs);
        let unpainted = paint(&mut whole, &mut drawn, &looking);

        let mut numbers: BTreeMap<Key, usize> = BTreeMap::new();
        let mut parts: Vec<(Key, Part)> = Vec::new();
        let (mut missing, mut approximate) = (0_u64, false);
        for (k, &(t, painted)) in drawn.iter().enumerate() {
            let look = looking.of(t as usize, painted);
            let number = *numbers.entry(look.key).or_insert(parts.len());
            if number == parts.len() {
                parts.push((look.key, Part::default()));
            }
            if let Some((_, part)) = parts.get_mut(number) {
                part.triangles.push([t, k as u32]);
                part.colored |= look.corners.iter().any(|corner| corner.color != [1.0; 4]);
            }
            missing = missing.saturating_add(look.missing.into());
            approximate |= look.approximate;
        }
        let mut cutter = Cutter::new(&whole);
        let mut cut = Vec::with_capacity(parts.len());
        for (key, part) in &parts {
            let textured = matches!(key, Key::Painted { texture: Some(_), .. });
            let corners = (part.triangles.len() as u64).saturating_mul(3);
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
    /// The vertices of the part at work: those of all with what they have of their own.
    own: Variants<Corner>,
}

impl<'a> Cutter<'a> {
    fn new(whole: &'a MeshData) -> Self {
        Self { whole, own: Variants::new(whole.positions.len(), SEARCHED) }
    }

    /// The triangles of a part over vertices of their own.
    fn cut(&mut self, part: &Part, textured: bool, corners: impl Fn(u32) -> [Corner; 3]) -> MeshData {
        self.own.clear();
        let mut out = MeshData::default();
        out.triangles.reserve_exact(part.triangles.len());
        let varied = textured || part.colored;
        for &[t, k] in &part.triangles {
            let looks = if varied { corners(t) } else { Look::of(Key::Plain).corners };
            let Some(&(mut triangle)) = self.whole.triangles.get(k as usize) else { break };
            for (vertex, corner) in triangle.iter_mut().zip(looks) {
                let v = *vertex as usize;
                let Some((number, is_new)) = self.own.number(v, corner) else { break };
                if is_new {
                    out.positions.extend(self.whole.positions.get(v));
                    out.normals.extend(self.whole.normals.get(v));
                }
                *vertex = number;
            }
            out.triangles.push(triangle);
        }
        if part.colored {
            out.colors = self.own.values().map(|corner| corner.color).collect();
        }
        if textured {
            out.uvs[0] = self.own.values().map(|corner| corner.uv).collect();
        }
        out
    }
}
