//! 3DS, the meshes of 3D Studio (release 3): chunks in chunks, each with a number and its length.
//!
//! Meshes are drawn where their vertices are; their own axes only say where the editor shows their pivot. Of materials there are
//! diffuse colour, texture, transparency, emission and sides. Smoothing groups decide which faces are smooth with each other
//! where they share an edge; faces of no group are flat. +Z is up. Cameras, lights and the animation of the keyframer have no effect.

use super::budget::Budget;
use super::mesh_formats::{
    add_object, check_input, check_mesh, default_material, drawable, finish, material_of, read_picture,
};
use super::names::name_of;
use super::normals::add_smooth_normals;
use super::shares::Shares;
use super::text::quoted;
use super::vertices::position_classes;
use super::warnings::{Warnings, counted};
use super::{Context, LoadError, Loaded, TextureLoading};
use overcoat_core::color::srgb::{srgb_to_linear, srgb8_to_linear};
use overcoat_core::limits::Limits;
use overcoat_core::math::double::atan2;
use overcoat_scene::{
    AlphaMode, AlphaUse, CREASE_ANGLE, ColorSpace, Material, MaterialId, MeshData, Sampler, Scene, TextureId,
    TextureRef, UvTransform,
};
use std::collections::BTreeMap;

const FORMAT: &str = "3DS";
/// Bytes of the head of a chunk.
const HEAD: usize = 6;

/// Numbers of chunks.
mod id {
    pub(super) const MAIN: u16 = 0x4d4d;
    pub(super) const EDITOR: u16 = 0x3d3d;
    pub(super) const SCALE: u16 = 0x0100;
    pub(super) const MATERIAL: u16 = 0xafff;
    pub(super) const NAME: u16 = 0xa000;
    pub(super) const DIFFUSE: u16 = 0xa020;
    pub(super) const TRANSPARENCY: u16 = 0xa050;
    pub(super) const EMISSION: u16 = 0xa084;
    pub(super) const TEXTURE: u16 = 0xa200;
    pub(super) const FILE: u16 = 0xa300;
    pub(super) const COLOR_FLOAT: u16 = 0x0010;
    pub(super) const COLOR: u16 = 0x0011;
    pub(super) const COLOR_LINEAR: u16 = 0x0012;
    pub(super) const FLOAT_LINEAR: u16 = 0x0013;
    pub(super) const PERCENT: u16 = 0x0030;
    pub(super) const PERCENT_FLOAT: u16 = 0x0031;
    pub(super) const OBJECT: u16 = 0x4000;
    pub(super) const MESH: u16 = 0x4100;
    pub(super) const VERTICES: u16 = 0x4110;
    pub(super) const FACES: u16 = 0x4120;
    pub(super) const FACE_MATERIAL: u16 = 0x4130;
    pub(super) const COORDINATES: u16 = 0x4140;
    pub(super) const SMOOTHING: u16 = 0x4150;
}

/// True if the first chunk has the whole of the file.
pub(crate) fn is_one(bytes: &[u8]) -> bool {
    let length = bytes.get(2..).and_then(|rest| rest.first_chunk());
    bytes.starts_with(b"MM")
        && length.is_some_and(|length| u32::from_le_bytes(*length) as usize == bytes.len())
}

/// A walk through the chunks in some bytes.
struct Chunks<'a> {
    rest: &'a [u8],
    /// Bytes that the last chunk should have had, and has not.
    missing: usize,
}

impl<'a> Chunks<'a> {
    fn new(rest: &'a [u8]) -> Self {
        Self { rest, missing: 0 }
    }
}

impl<'a> Iterator for Chunks<'a> {
    type Item = (u16, &'a [u8]);

    fn next(&mut self) -> Option<Self::Item> {
        let (&[a, b, c, d, e, f], content) = self.rest.split_first_chunk::<HEAD>()?;
        let length = (u32::from_le_bytes([c, d, e, f]) as usize).checked_sub(HEAD)?;
        let (content, rest) = content.split_at_checked(length).unwrap_or((content, &[]));
        self.missing = length.saturating_sub(content.len());
        self.rest = rest;
        Some((u16::from_le_bytes([a, b]), content))
    }
}

/// The text up to a zero, and what follows.
fn text(bytes: &[u8]) -> (&[u8], &[u8]) {
    let end = bytes.iter().position(|&b| b == 0).unwrap_or(bytes.len());
    let (text, rest) = bytes.split_at_checked(end).unwrap_or_default();
    (text, rest.get(1..).unwrap_or_default())
}

/// A count of 16 bits, and the items behind it that are there.
fn list<const N: usize>(bytes: &[u8]) -> (usize, &[[u8; N]], &[u8]) {
    let Some((count, rest)) = bytes.split_first_chunk() else { return (0, &[], &[]) };
    let count = usize::from(u16::from_le_bytes(*count));
    let size = count.saturating_mul(N);
    let (items, after) = rest.split_at_checked(size).unwrap_or((rest, &[]));
    (count, items.as_chunks().0, after)
}

fn floats<const N: usize>(bytes: &[u8]) -> Option<[f32; N]> {
    let mut out = [0.0; N];
    let chunks = bytes.as_chunks::<4>().0;
    chunks.get(N.checked_sub(1)?)?;
    for (slot, value) in out.iter_mut().zip(chunks) {
        *slot = f32::from_le_bytes(*value);
    }
    Some(out)
}

/// A material as it is in the file.
#[derive(Default)]
struct Surface {
    diffuse: Option<[f32; 3]>,
    transparency: f32,
    emission: f32,
    file: Option<String>,
}

/// Linear colour of a chunk with one; gamma-corrected numbers count for more than linear ones.
fn color(bytes: &[u8]) -> Option<[f32; 3]> {
    let mut found = None;
    for (kind, content) in Chunks::new(bytes) {
        let own = match (kind, content) {
            (id::COLOR_FLOAT, _) => floats(content).map(|rgb: [f32; 3]| rgb.map(|v| srgb_to_linear(unit(v)))),
            (id::COLOR, [r, g, b, ..]) => Some([*r, *g, *b].map(srgb8_to_linear)),
            (id::COLOR_LINEAR, [r, g, b, ..]) if found.is_none() => {
                Some([*r, *g, *b].map(|v| f32::from(v) / 255.0))
            }
            (id::FLOAT_LINEAR, _) if found.is_none() => floats(content).map(|rgb: [f32; 3]| rgb.map(unit)),
            _ => None,
        };
        found = own.or(found);
    }
    found
}

/// Part of a chunk with a percentage.
fn part(bytes: &[u8]) -> f32 {
    for (kind, content) in Chunks::new(bytes) {
        match (kind, content) {
            (id::PERCENT, [a, b, ..]) => return unit(f32::from(i16::from_le_bytes([*a, *b])) / 100.0),
            (id::PERCENT_FLOAT, _) => return floats(content).map_or(0.0, |[v]| unit(v)),
            _ => {}
        }
    }
    0.0
}

/// 0 to 1; NaN becomes 0.
fn unit(v: f32) -> f32 {
    if v > 0.0 { if v < 1.0 { v } else { 1.0 } } else { 0.0 }
}

/// A mesh as it is in the file.
#[derive(Default)]
struct Object<'a> {
    name: &'a [u8],
    positions: Vec<[f32; 3]>,
    uvs: Vec<[f32; 2]>,
    faces: Vec<[u16; 3]>,
    /// Groups of faces, as bits; empty without.
    groups: Vec<u32>,
    /// Materials, each with its faces.
    materials: Vec<(&'a [u8], Vec<u16>)>,
    cut: bool,
}

impl<'a> Object<'a> {
    fn read(name: &'a [u8], bytes: &'a [u8]) -> Self {
        let mut object = Self { name, ..Self::default() };
        let mut chunks = Chunks::new(bytes);
        for (kind, content) in chunks.by_ref() {
            match kind {
                id::VERTICES => {
                    let (count, items, _) = list::<12>(content);
                    object.cut |= items.len() < count;
                    object.positions = items.iter().filter_map(|item| floats(item)).collect();
                }
                id::COORDINATES => {
                    let (count, items, _) = list::<8>(content);
                    object.cut |= items.len() < count;
                    let uvs = items.iter().filter_map(|item| floats(item));
                    // v runs up in the file, down here.
                    object.uvs = uvs.map(|[u, v]: [f32; 2]| [u, 1.0 - v]).collect();
                }
                id::FACES => object.faces(content),
                _ => {}
            }
        }
        object.cut |= chunks.missing > 0;
        object
    }

    fn faces(&mut self, content: &'a [u8]) {
        let (count, items, rest) = list::<8>(content);
        self.cut |= items.len() < count;
        let corner = |a: u8, b: u8| u16::from_le_bytes([a, b]);
        self.faces = items
            .iter()
            .map(|&[a, b, c, d, e, f, _, _]| [corner(a, b), corner(c, d), corner(e, f)])
            .collect();
        for (kind, content) in Chunks::new(rest) {
            match kind {
                id::FACE_MATERIAL => {
                    let (name, rest) = text(content);
                    let (_, items, _) = list::<2>(rest);
                    let numbers = items.iter().map(|&number| u16::from_le_bytes(number)).collect();
                    self.materials.push((name, numbers));
                }
                id::SMOOTHING => {
                    let (words, _) = content.as_chunks();
                    self.groups = words.iter().map(|&word| u32::from_le_bytes(word)).collect();
                }
                _ => {}
            }
        }
    }
}

/// Reads a file, and the textures that it names. What is complete when it ends is drawn, with a warning.
pub(crate) fn load(
    bytes: &[u8],
    context: &Context<'_>,
    loading: TextureLoading,
    shares: &Shares,
) -> Result<Loaded, LoadError> {
    check_input(context, bytes)?;
    let mut main = Chunks::new(bytes);
    let Some((id::MAIN, content)) = main.next() else {
        return Err(LoadError::malformed(FORMAT, "it does not begin with the chunk 4D4D"));
    };
    let mut builder = Builder {
        context,
        loading,
        scene: Scene::new(),
        warnings: Warnings::default(),
        budget: Budget::shared(context.limits, shares),
        surfaces: BTreeMap::new(),
        materials: BTreeMap::new(),
        textures: BTreeMap::new(),
        totals: [0; 2],
        bad: 0,
        cut: main.missing > 0,
    };
    let editors: Vec<&[u8]> =
        Chunks::new(content).filter(|(kind, _)| *kind == id::EDITOR).map(|c| c.1).collect();
    // Materials may follow the meshes.
    for editor in &editors {
        for (kind, content) in Chunks::new(editor) {
            match kind {
                id::MATERIAL => builder.surface(content),
                id::SCALE if floats(content).is_some_and(|[scale]: [f32; 1]| scale != 1.0) => {
                    builder.warnings.add(|| format!("{FORMAT}: the scale of the file has no effect"));
                }
                _ => {}
            }
        }
    }
    let mut number = 0_u32;
    for (kind, content) in editors.iter().flat_map(|editor| Chunks::new(editor)) {
        if kind != id::OBJECT {
            continue;
        }
        let (name, rest) = text(content);
        for (_, content) in Chunks::new(rest).filter(|(kind, _)| *kind == id::MESH) {
            let limit = context.limits.nodes;
            Limits::check(|| format!("{FORMAT}: the number of meshes"), number.into(), limit, "nodes")?;
            builder.object(Object::read(name, content), number)?;
            number = number.saturating_add(1);
        }
    }
    if editors.is_empty() {
        return Err(LoadError::malformed(FORMAT, "there is no chunk 3D3D, in which the meshes are"));
    }
    let Builder { scene, mut warnings, bad, cut, .. } = builder;
    if bad > 0 {
        let faces = counted(bad, "face");
        warnings.add(|| format!("{FORMAT}: {faces} left out: vertices missing, not finite or beyond 1e15"));
    }
    if cut {
        warnings
            .add(|| format!("{FORMAT}: the file ends early or has lists that do; what is there is drawn"));
    }
    Ok(finish(scene, warnings.finish()))
}

/// Sets of groups around one position that are compared each with each: more of them are smooth within each alone.
const COMPARED: usize = 64;

/// Normals of corners, three for each face: the sum of those of all faces around the position that are in one of its groups,
/// weighted by area and angle as in `normals.rs`; zeros, which stand for the face's own, for faces in no group.
fn smooth(positions: &[[f32; 3]], groups: &[u32]) -> Vec<[f32; 3]> {
    let (classes, count) = position_classes(positions);
    let mut sums: Vec<BTreeMap<u32, [f64; 3]>> = vec![BTreeMap::new(); count];
    let faces = || positions.as_chunks::<3>().0.iter().zip(classes.as_chunks::<3>().0).zip(groups);
    for ((corners, own), &group) in faces() {
        let [a, b, c] = corners.map(|corner| corner.map(f64::from));
        let normal = cross(less(b, a), less(c, a));
        let length = dot(normal, normal).sqrt();
        let angles = [[a, b, c], [b, c, a], [c, a, b]].map(|[at, next, last]| {
            // The triangle is as large at each of its corners.
            atan2(length, dot(less(next, at), less(last, at)))
        });
        for (&class, angle) in own.iter().zip(angles) {
            if let Some(sums) = sums.get_mut(class as usize) {
                let sum = sums.entry(group).or_default();
                sum.iter_mut().zip(normal).for_each(|(sum, v)| *sum += v * angle);
            }
        }
    }
    let corner = |class: u32, group: u32| {
        let around = sums.get(class as usize)?;
        let few = around.len() <= COMPARED;
        let mut total = [0.0; 3];
        for (_, sum) in
            around.iter().filter(|(other, _)| if few { **other & group != 0 } else { **other == group })
        {
            total.iter_mut().zip(sum).for_each(|(total, v)| *total += v);
        }
        let [x, y, z] = total;
        let length = (x * x + y * y + z * z).sqrt();
        (length > 0.0 && length.is_finite()).then(|| total.map(|v| (v / length) as f32))
    };
    let of_face = |(own, &group): (&[u32; 3], &u32)| {
        own.map(|class| if group == 0 { [0.0; 3] } else { corner(class, group).unwrap_or_default() })
    };
    classes.as_chunks::<3>().0.iter().zip(groups).flat_map(of_face).collect()
}

fn less([a, b, c]: [f64; 3], [x, y, z]: [f64; 3]) -> [f64; 3] {
    [a - x, b - y, c - z]
}

fn dot([a, b, c]: [f64; 3], [x, y, z]: [f64; 3]) -> f64 {
    a * x + b * y + c * z
}

fn cross([a, b, c]: [f64; 3], [x, y, z]: [f64; 3]) -> [f64; 3] {
    [b * z - c * y, c * x - a * z, a * y - b * x]
}

struct Builder<'a> {
    context: &'a Context<'a>,
    loading: TextureLoading,
    scene: Scene,
    warnings: Warnings,
    budget: Budget,
    surfaces: BTreeMap<Vec<u8>, Surface>,
    /// By their names; `None` for surfaces without.
    materials: BTreeMap<Option<Vec<u8>>, MaterialId>,
    textures: BTreeMap<String, Option<TextureId>>,
    /// Triangles and vertices of all meshes.
    totals: [u64; 2],
    bad: u64,
    cut: bool,
}

impl Builder<'_> {
    fn surface(&mut self, bytes: &[u8]) {
        let mut surface = Surface::default();
        let mut name = Vec::new();
        for (kind, content) in Chunks::new(bytes) {
            match kind {
                id::NAME => name = text(content).0.to_vec(),
                id::DIFFUSE => surface.diffuse = color(content),
                id::TRANSPARENCY => surface.transparency = part(content),
                id::EMISSION => surface.emission = part(content),
                id::TEXTURE => {
                    let file = Chunks::new(content).find(|(kind, _)| *kind == id::FILE);
                    surface.file = file.map(|(_, content)| name_of(text(content).0));
                }
                _ => {}
            }
        }
        self.surfaces.insert(name, surface);
    }

    /// Adds a mesh, by its materials.
    fn object(&mut self, object: Object<'_>, number: u32) -> Result<(), LoadError> {
        self.cut |= object.cut;
        let count = object.faces.len() as u64;
        let [triangles, vertices] = self.totals;
        self.totals = [triangles.saturating_add(count), vertices.saturating_add(count.saturating_mul(3))];
        check_mesh(self.context, self.totals[0], self.totals[1])?;
        let mut of_face: Vec<Option<&[u8]>> = vec![None; object.faces.len()];
        for (name, faces) in &object.materials {
            for &face in faces {
                if let Some(slot) = of_face.get_mut(usize::from(face)) {
                    *slot = Some(name);
                }
            }
        }
        let (whole, drawn) = self.mesh(&object);
        let mut parts: BTreeMap<Option<&[u8]>, MeshData> = BTreeMap::new();
        for (triangle, face) in whole.triangles.iter().zip(drawn) {
            let data = parts.entry(of_face.get(face).copied().flatten()).or_default();
            let first = data.positions.len() as u32;
            for &vertex in triangle {
                let vertex = vertex as usize;
                data.positions.extend(whole.positions.get(vertex));
                data.normals.extend(whole.normals.get(vertex));
                data.uvs[0].extend(whole.uvs[0].get(vertex));
            }
            data.triangles.push([first, first.saturating_add(1), first.saturating_add(2)]);
        }
        for (name, data) in parts {
            let material = self.material(name)?;
            let element = format!("{FORMAT}: object {}", quoted(object.name));
            add_object(&mut self.scene, &element, data, material, number)?;
        }
        self.scene.name_object(number, &name_of(object.name));
        Ok(())
    }

    /// The faces that can be drawn, with vertices and normals of their own, and their numbers.
    fn mesh(&mut self, object: &Object<'_>) -> (MeshData, Vec<usize>) {
        let with_uvs = object.uvs.len() == object.positions.len() && !object.uvs.is_empty();
        let (mut data, mut drawn) = (MeshData::default(), Vec::new());
        for (face, &corners) in object.faces.iter().enumerate() {
            let place = |corner: u16| object.positions.get(usize::from(corner)).copied();
            let [Some(a), Some(b), Some(c)] = corners.map(|corner| place(corner).filter(|&p| drawable(p)))
            else {
                self.bad = self.bad.saturating_add(1);
                continue;
            };
            let first = data.positions.len() as u32;
            data.positions.extend([a, b, c]);
            if with_uvs {
                let uv = |corner: u16| object.uvs.get(usize::from(corner)).copied().unwrap_or_default();
                let finite = |uv: [f32; 2]| if uv.iter().all(|v| v.abs() <= 1e9) { uv } else { [0.0; 2] };
                data.uvs[0].extend(corners.map(|corner| finite(uv(corner))));
            }
            data.triangles.push([first, first.saturating_add(1), first.saturating_add(2)]);
            drawn.push(face);
        }
        if object.groups.is_empty() {
            add_smooth_normals(&mut data, CREASE_ANGLE, self.context.jobs);
        } else {
            let groups: Vec<u32> =
                drawn.iter().map(|&face| object.groups.get(face).copied().unwrap_or(0)).collect();
            data.normals = smooth(&data.positions, &groups);
        }
        (data, drawn)
    }

    /// The material of a name; that of surfaces without for one that the file does not have.
    fn material(&mut self, name: Option<&[u8]>) -> Result<MaterialId, LoadError> {
        let key = name.filter(|name| self.surfaces.contains_key(*name)).map(<[u8]>::to_vec);
        if let Some(known) = self.materials.get(&key) {
            return Ok(*known);
        }
        let material = match key.as_ref().and_then(|key| self.surfaces.remove_entry(key)) {
            Some((name, surface)) => {
                let material = self.look(&name, &surface)?;
                self.surfaces.insert(name, surface);
                material
            }
            None => default_material(),
        };
        let added = self.scene.add_material(material).map_err(LoadError::scene("3DS: material"))?;
        self.materials.insert(key, added);
        Ok(added)
    }

    fn look(&mut self, name: &[u8], surface: &Surface) -> Result<Material, LoadError> {
        let [r, g, b] = surface.diffuse.unwrap_or([0.5; 3]);
        let mut opacity = 1.0 - surface.transparency;
        if opacity <= 0.0 {
            let name = quoted(name);
            self.warnings
                .add(|| format!("{FORMAT}: material {name} is wholly transparent as written: drawn opaque"));
            opacity = 1.0;
        }
        let mut material = material_of([r, g, b, opacity]).with(|m| m.name = name_of(name));
        if opacity < 1.0 {
            material.alpha_mode = AlphaMode::Blend;
        }
        material.emissive = [r, g, b].map(|v| v * surface.emission);
        if let Some(file) = &surface.file
            && let Some(texture) = self.texture(file)?
        {
            let transform = UvTransform::IDENTITY;
            material.base_color_texture = Some(TextureRef { texture, uv_set: 0, transform });
            material.base_color = [1.0, 1.0, 1.0, opacity];
        }
        Ok(material)
    }

    /// Texture of a file; none, with a warning, if it cannot be had.
    fn texture(&mut self, file: &str) -> Result<Option<TextureId>, LoadError> {
        if let Some(known) = self.textures.get(file) {
            return Ok(*known);
        }
        let count = (self.textures.len() as u64).saturating_add(1);
        let limit = self.context.limits.textures;
        Limits::check(|| format!("{FORMAT}: the number of textures"), count, limit, "textures")?;
        let texture = match read_picture(FORMAT, self.context, file, &mut self.budget)? {
            Ok(image) => {
                let form = (ColorSpace::Srgb, AlphaUse::Data, Sampler::default());
                image.texture(form, self.loading, &mut self.warnings)?
            }
            Err(why) => {
                self.warnings.add_texture(|| why);
                None
            }
        };
        let added = texture.map(|texture| self.scene.add_texture(texture)).transpose();
        let added = added.map_err(LoadError::scene("3DS: texture"))?;
        self.textures.insert(file.to_owned(), added);
        Ok(added)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Format;
    use crate::hostile::{attack, load, warnings};

    fn chunk(kind: u16, content: &[u8]) -> Vec<u8> {
        let length = (content.len() + HEAD) as u32;
        [&kind.to_le_bytes()[..], &length.to_le_bytes(), content].concat()
    }

    fn floats_of(list: &[f32]) -> Vec<u8> {
        list.iter().flat_map(|v| v.to_le_bytes()).collect()
    }

    fn shorts(list: &[u16]) -> Vec<u8> {
        list.iter().flat_map(|v| v.to_le_bytes()).collect()
    }

    /// A roof of two squares, the material of the first, and groups of its four faces.
    fn file(groups: Option<[u32; 4]>, material: &[u8]) -> Vec<u8> {
        let corners = [
            [0.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [1.0, 0.0, 1.0],
            [1.0, 1.0, 1.0],
            [2.0, 0.0, 0.0],
            [2.0, 1.0, 0.0],
        ];
        let vertices = [shorts(&[6]), floats_of(corners.as_flattened())].concat();
        let faces = [[0, 2, 3, 0], [0, 3, 1, 0], [2, 4, 5, 0], [2, 5, 3, 0]];
        let mut list = [shorts(&[4]), shorts(faces.as_flattened())].concat();
        list.extend(chunk(id::FACE_MATERIAL, &[b"red\0".to_vec(), shorts(&[2, 0, 1])].concat()));
        if let Some(groups) = groups {
            let words: Vec<u8> = groups.iter().flat_map(|v| v.to_le_bytes()).collect();
            list.extend(chunk(id::SMOOTHING, &words));
        }
        let uvs = [shorts(&[6]), floats_of(&[0.25; 12])].concat();
        let parts = [chunk(id::VERTICES, &vertices), chunk(id::COORDINATES, &uvs), chunk(id::FACES, &list)];
        let object = [b"roof\0".to_vec(), chunk(id::MESH, &parts.concat())].concat();
        let material = chunk(id::MATERIAL, &[chunk(id::NAME, b"red\0"), material.to_vec()].concat());
        chunk(id::MAIN, &chunk(id::EDITOR, &[material, chunk(id::OBJECT, &object)].concat()))
    }

    fn red() -> Vec<u8> {
        let diffuse = chunk(id::DIFFUSE, &chunk(id::COLOR, &[255, 0, 0]));
        let transparency = chunk(id::TRANSPARENCY, &chunk(id::PERCENT, &25_u16.to_le_bytes()));
        [diffuse, transparency].concat()
    }

    #[test]
    fn meshes_have_materials_by_face() {
        let bytes = file(None, &red());
        assert_eq!(Format::detect(&bytes), Some(Format::ThreeDs));
        let loaded = load(&bytes, Format::ThreeDs).unwrap();
        assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
        let scene = &loaded.scene;
        assert_eq!((scene.triangle_count(), scene.instances().len()), (4, 2));
        let of = |k: usize| &scene.materials()[scene.instances()[k].material.index()];
        assert_eq!(of(0).base_color, default_material().base_color);
        assert_eq!((of(1).base_color, of(1).alpha_mode), ([1.0, 0.0, 0.0, 0.75], AlphaMode::Blend));
        assert_eq!(scene.meshes()[0].uvs(0)[0], [0.25, 0.75]);
        attack(&bytes, Format::ThreeDs);
    }

    #[test]
    fn faces_that_share_a_group_are_smooth_over_materials() {
        // True for normals at the ridge that point up, and for those that are none.
        let ridge = |groups| {
            let loaded = load(&file(Some(groups), &red()), Format::ThreeDs).unwrap();
            let meshes = loaded.scene.meshes();
            assert_eq!(meshes.len(), 2);
            let all = meshes.iter().flat_map(|mesh| mesh.positions().iter().zip(mesh.normals()));
            let ridge: Vec<[f32; 3]> = all.filter(|(p, _)| p[0] == 1.0).map(|(_, n)| *n).collect();
            assert_eq!(ridge.len(), 6);
            ridge.iter().map(|n| (n[0].abs() < 1e-6 && n[2] > 0.99, n[2] == 0.0)).collect::<Vec<_>>()
        };
        assert!(ridge([1, 1, 1, 1]).iter().all(|(up, _)| *up));
        assert!(ridge([3, 3, 6, 6]).iter().all(|(up, _)| *up));
        assert!(ridge([1, 1, 2, 2]).iter().all(|(up, none)| !up && !none));
        // In no group: the normal of the face.
        assert!(ridge([0; 4]).iter().all(|(_, none)| *none));
    }

    #[test]
    fn damage_is_named() {
        let whole = file(None, &red());
        let loaded = load(&whole[..whole.len() - 1], Format::ThreeDs).unwrap();
        assert!(warnings(&loaded)[0].contains("the file ends early"), "{:?}", loaded.warnings);
        let mut bad = whole;
        let faces = shorts(&[0, 2, 3, 0]);
        let place = bad.windows(8).position(|w| w == faces).unwrap();
        bad[place] = 77;
        let expected = "3DS: 1 face left out: vertices missing, not finite or beyond 1e15";
        assert_eq!(warnings(&load(&bad, Format::ThreeDs).unwrap()), [expected]);
        let empty = chunk(id::MAIN, &[]);
        assert!(load(&empty, Format::ThreeDs).unwrap_err().to_string().contains("there is no chunk 3D3D"));
        let missing = chunk(id::TEXTURE, &chunk(id::FILE, b"WOOD.TGA\0"));
        let loaded = load(&file(None, &missing), Format::ThreeDs).unwrap();
        assert!(warnings(&loaded)[0].contains("WOOD.TGA"), "{:?}", loaded.warnings);
    }
}
