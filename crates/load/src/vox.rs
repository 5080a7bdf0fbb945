//! VOX, the voxels of MagicaVoxel (its documents `MagicaVoxel-file-format-vox.txt` and `-vox-extension.txt`, version 150 and 200).
//!
//! Faces of voxels that another one hides are left out, the others are squares in the colours of the palette. The scene graph's
//! transforms place the models, about the middles of their boxes; what is hidden in it is not drawn. Materials of the palette
//! (glass, metal, light) have no effect, with a warning. +Z is up.

use super::budget::Budget;
use super::mesh_formats::{add_placed, check_input, check_mesh, finish, white_material};
use super::text::integer;
use super::warnings::{Warnings, counted};
use super::{Context, LoadError, Loaded};
use overcoat_core::color::srgb::srgb8_to_linear;
use overcoat_core::limits::Limits;
use overcoat_scene::{MaterialId, Mesh, MeshData, MeshId, Scene, Transform};
use std::collections::BTreeMap;

const FORMAT: &str = "VOX";
/// Longest side of a model, in voxels: places have 8 bits.
const SIDE: u32 = 256;

/// Numbers and texts of a chunk, one after the other.
struct Chunk<'a> {
    rest: &'a [u8],
}

impl<'a> Chunk<'a> {
    fn word(&mut self) -> Option<u32> {
        let (word, rest) = self.rest.split_first_chunk()?;
        self.rest = rest;
        Some(u32::from_le_bytes(*word))
    }

    fn bytes(&mut self, count: u32) -> Option<&'a [u8]> {
        let (bytes, rest) = self.rest.split_at_checked(count as usize)?;
        self.rest = rest;
        Some(bytes)
    }

    /// Pairs of texts.
    fn dictionary(&mut self) -> Option<BTreeMap<&'a [u8], &'a [u8]>> {
        let count = self.word()?;
        let mut found = BTreeMap::new();
        for _ in 0..count {
            let size = self.word()?;
            let key = self.bytes(size)?;
            let size = self.word()?;
            found.insert(key, self.bytes(size)?);
        }
        Some(found)
    }
}

/// Voxels of a model: places, and numbers of colours.
struct Model<'a> {
    size: [u32; 3],
    voxels: &'a [[u8; 4]],
}

/// A node of the scene graph.
enum Node {
    Transform { transform: Transform, child: u32, hidden: bool, layer: u32 },
    Group(Vec<u32>),
    Shape(Vec<u32>),
}

#[derive(Default)]
struct File<'a> {
    models: Vec<Model<'a>>,
    nodes: BTreeMap<u32, Node>,
    palette: Option<[[u8; 4]; 256]>,
    hidden_layers: Vec<u32>,
    materials: bool,
}

/// Reads a file. What is complete when it ends is drawn, with a warning.
pub(crate) fn load(bytes: &[u8], context: &Context<'_>) -> Result<Loaded, LoadError> {
    check_input(context, bytes)?;
    let mut warnings = Warnings::default();
    let file = File::read(bytes, context, &mut warnings)?;
    let palette = file.palette.unwrap_or_else(default_palette);
    if file.materials {
        warnings
            .add(|| format!("{FORMAT}: glass, metal and light of the palette are drawn as plain colours"));
    }
    let mut scene = Scene::new();
    let material = scene.add_material(white_material()).map_err(LoadError::scene("VOX: material"))?;
    let mut builder = Builder {
        context,
        file: &file,
        palette,
        scene,
        material,
        meshes: BTreeMap::new(),
        budget: Budget::new(context.limits),
        totals: [0; 2],
        visits: 0,
        outside: 0,
        missing: 0,
    };
    if file.nodes.is_empty() {
        // Files of version 150 have models alone, each about the same place.
        for model in 0..file.models.len() as u32 {
            builder.place(model, &Transform::IDENTITY)?;
        }
    } else {
        builder.node(0, &Transform::IDENTITY, 0)?;
    }
    let Builder { scene, outside, missing, .. } = builder;
    if outside > 0 {
        let voxels = counted(outside, "voxel");
        warnings.add(|| format!("{FORMAT}: {voxels} outside of the model's size left out"));
    }
    if missing > 0 {
        let nodes = counted(missing, "node");
        warnings.add(|| format!("{FORMAT}: {nodes} or models that others refer to do not exist"));
    }
    Ok(finish(scene, warnings.finish()))
}

impl<'a> File<'a> {
    fn read(bytes: &'a [u8], context: &Context<'_>, warnings: &mut Warnings) -> Result<Self, LoadError> {
        let malformed = |message: String| LoadError::malformed(FORMAT, message);
        let rest = bytes.strip_prefix(b"VOX ").and_then(|rest| rest.get(4..));
        let mut rest =
            Chunk { rest: rest.ok_or_else(|| malformed("it does not begin with VOX".to_owned()))? };
        let mut file = Self::default();
        let mut size = None;
        let mut chunks = 0_u64;
        while !rest.rest.is_empty() {
            chunks = chunks.saturating_add(1);
            let limit = context.limits.nodes;
            Limits::check(|| format!("{FORMAT}: the number of chunks"), chunks, limit, "nodes")?;
            let head = rest.bytes(4).and_then(|name| Some((name, rest.word()?, rest.word()?)));
            let Some((name, length, _)) = head else {
                warnings.add(|| format!("{FORMAT}: the file ends within the head of chunk {chunks}"));
                break;
            };
            let Some(content) = rest.bytes(length) else {
                warnings.add(|| format!("{FORMAT}: the file ends within chunk {chunks}"));
                break;
            };
            // Children of MAIN follow as if they were beside it.
            let mut chunk = Chunk { rest: content };
            let shown = || String::from_utf8_lossy(name).escape_debug().to_string();
            let damaged = || malformed(format!("chunk {chunks} ({}) ends early", shown()));
            match name {
                b"SIZE" => {
                    let sides = (chunk.word(), chunk.word(), chunk.word());
                    let (Some(x), Some(y), Some(z)) = sides else { return Err(damaged()) };
                    if [x, y, z].iter().any(|side| !(1..=SIDE).contains(side)) {
                        let message = format!(
                            "chunk {chunks}: a model of {x} x {y} x {z} voxels; 1 to {SIDE} are read"
                        );
                        return Err(malformed(message));
                    }
                    size = Some([x, y, z]);
                }
                b"XYZI" => {
                    let count = chunk.word().ok_or_else(damaged)?;
                    let voxels =
                        count.checked_mul(4).and_then(|bytes| chunk.bytes(bytes)).ok_or_else(damaged)?;
                    let Some(size) = size.take() else {
                        return Err(malformed(format!(
                            "chunk {chunks}: voxels without the size of their model"
                        )));
                    };
                    file.models.push(Model { size, voxels: voxels.as_chunks().0 });
                }
                b"RGBA" => {
                    let mut palette = [[0; 4]; 256];
                    let colors = chunk.bytes(1024).ok_or_else(damaged)?;
                    // The first is of number 1.
                    for (slot, color) in palette.iter_mut().skip(1).zip(colors.as_chunks().0) {
                        *slot = *color;
                    }
                    file.palette = Some(palette);
                }
                b"nTRN" | b"nGRP" | b"nSHP" => {
                    let (id, node) = node(name, &mut chunk).ok_or_else(damaged)?;
                    file.nodes.insert(id, node);
                }
                b"LAYR" => {
                    let layer = chunk.word().and_then(|id| Some((id, chunk.dictionary()?)));
                    let (id, attributes) = layer.ok_or_else(damaged)?;
                    if attributes.get(&b"_hidden"[..]) == Some(&&b"1"[..]) {
                        file.hidden_layers.push(id);
                    }
                }
                b"MATL" => {
                    let material = chunk.word().and_then(|_| chunk.dictionary()).ok_or_else(damaged)?;
                    let kind = material.get(&b"_type"[..]).copied().unwrap_or(b"_diffuse");
                    file.materials |= kind != b"_diffuse";
                }
                _ => {}
            }
        }
        if file.models.is_empty() {
            return Err(malformed("there is no model in it".to_owned()));
        }
        Ok(file)
    }
}

/// Reads a node of the scene graph.
fn node(name: &[u8], chunk: &mut Chunk<'_>) -> Option<(u32, Node)> {
    let id = chunk.word()?;
    let attributes = chunk.dictionary()?;
    if name == b"nTRN" {
        let child = chunk.word()?;
        let (_, layer, frames) = (chunk.word()?, chunk.word()?, chunk.word()?);
        // The first frame of an animation.
        let frame = if frames > 0 { chunk.dictionary()? } else { BTreeMap::new() };
        let hidden = attributes.get(&b"_hidden"[..]) == Some(&&b"1"[..]);
        return Some((id, Node::Transform { transform: transform(&frame)?, child, hidden, layer }));
    }
    let count = chunk.word()?;
    let mut list = Vec::new();
    for _ in 0..count {
        list.push(chunk.word()?);
        if name == b"nSHP" {
            chunk.dictionary()?;
        }
    }
    Some((id, if name == b"nSHP" { Node::Shape(list) } else { Node::Group(list) }))
}

/// The transform of a frame: `_t` moves, `_r` exchanges axes.
///
/// Bits of `_r`: the columns of the ones in the first two rows, two bits each, and the signs of the three rows.
fn transform(frame: &BTreeMap<&[u8], &[u8]>) -> Option<Transform> {
    let code = match frame.get(&b"_r"[..]) {
        Some(text) => u32::try_from(integer(text)?).ok()?,
        None => 0b100,
    };
    let (first, second) = (code & 3, code >> 2 & 3);
    // A code that is no exchange of axes turns nothing.
    let valid = first < 3 && second < 3 && first != second;
    let (first, second, signs) = if valid { (first, second, code >> 4) } else { (0, 1, 0) };
    let columns = [first, second, 3_u32.saturating_sub(first.saturating_add(second))];
    let mut moved = [0.0; 3];
    if let Some(text) = frame.get(&b"_t"[..]) {
        let words = text.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
        for (slot, word) in moved.iter_mut().zip(words) {
            *slot = integer(word)? as f64;
        }
    }
    let mut rows = [[0.0; 4]; 3];
    for (k, ((row, column), moved)) in rows.iter_mut().zip(columns).zip(moved).enumerate() {
        let sign = if signs >> k & 1 == 1 { -1.0 } else { 1.0 };
        let [x, y, z, t] = row;
        match column {
            0 => *x = sign,
            1 => *y = sign,
            _ => *z = sign,
        }
        *t = moved;
    }
    Transform::from_rows(rows).ok()
}

/// The palette of files without one: a cube of six levels without black, and four ramps of ten.
fn default_palette() -> [[u8; 4]; 256] {
    const LEVELS: [u8; 6] = [0xff, 0xcc, 0x99, 0x66, 0x33, 0];
    const RAMP: [u8; 10] = [0xee, 0xdd, 0xbb, 0xaa, 0x88, 0x77, 0x55, 0x44, 0x22, 0x11];
    let cube =
        LEVELS.iter().flat_map(|&r| LEVELS.iter().flat_map(move |&g| LEVELS.iter().map(move |&b| [r, g, b])));
    let cube = cube.filter(|color| *color != [0; 3]);
    let ramps = [[1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1]]
        .into_iter()
        .flat_map(|mask: [u8; 3]| RAMP.iter().map(move |&v| mask.map(|on| if on == 1 { v } else { 0 })));
    let mut palette = [[0; 4]; 256];
    for (slot, [r, g, b]) in palette.iter_mut().skip(1).zip(cube.chain(ramps)) {
        *slot = [r, g, b, 255];
    }
    palette
}

struct Builder<'a> {
    context: &'a Context<'a>,
    file: &'a File<'a>,
    palette: [[u8; 4]; 256],
    scene: Scene,
    material: MaterialId,
    /// `None` for models without a voxel.
    meshes: BTreeMap<u32, Option<MeshId>>,
    budget: Budget,
    /// Triangles and vertices of all meshes.
    totals: [u64; 2],
    visits: u64,
    outside: u64,
    missing: u64,
}

impl Builder<'_> {
    fn node(&mut self, id: u32, parent: &Transform, depth: u64) -> Result<(), LoadError> {
        let limits = self.context.limits;
        self.visits = self.visits.saturating_add(1);
        Limits::check(|| format!("{FORMAT}: the depth of nodes"), depth, limits.depth, "depth")?;
        Limits::check(|| format!("{FORMAT}: the number of nodes"), self.visits, limits.nodes, "nodes")?;
        let file = self.file;
        match file.nodes.get(&id) {
            None => self.missing = self.missing.saturating_add(1),
            Some(Node::Transform { hidden: true, .. }) => {}
            Some(Node::Transform { layer, .. }) if file.hidden_layers.contains(layer) => {}
            Some(Node::Transform { transform, child, .. }) => {
                let placed = parent.after(transform).map_err(LoadError::scene("VOX: transform"))?;
                self.node(*child, &placed, depth.saturating_add(1))?;
            }
            Some(Node::Group(children)) => {
                for &child in children {
                    self.node(child, parent, depth.saturating_add(1))?;
                }
            }
            // The first model of an animation.
            Some(Node::Shape(models)) => match models.first() {
                Some(&model) => self.place(model, parent)?,
                None => self.missing = self.missing.saturating_add(1),
            },
        }
        Ok(())
    }

    fn place(&mut self, model: u32, transform: &Transform) -> Result<(), LoadError> {
        let mesh = match self.meshes.get(&model) {
            Some(known) => *known,
            None => {
                let made = self.mesh(model)?;
                self.meshes.insert(model, made);
                made
            }
        };
        let object = self.scene.instances().len() as u32;
        match mesh {
            Some(mesh) => {
                let element = format!("{FORMAT}: model {model}");
                add_placed(&mut self.scene, &element, mesh, self.material, *transform, object)
            }
            None => Ok(()),
        }
    }

    /// The visible faces of a model, about the middle of its box.
    fn mesh(&mut self, number: u32) -> Result<Option<MeshId>, LoadError> {
        let Some(model) = self.file.models.get(number as usize) else {
            self.missing = self.missing.saturating_add(1);
            return Ok(None);
        };
        let (grid, outside) = self.grid(model)?;
        self.outside = self.outside.saturating_add(outside);
        let mut faces = 0_u64;
        each_face(model, &grid, |_, _, _, _| faces = faces.saturating_add(1));
        let [triangles, vertices] = self.totals;
        self.totals = [
            triangles.saturating_add(faces.saturating_mul(2)),
            vertices.saturating_add(faces.saturating_mul(4)),
        ];
        check_mesh(self.context, self.totals[0], self.totals[1])?;
        self.budget.charge(|| format!("{FORMAT}: model {number}"), faces.saturating_mul(4), 40)?;
        let mut data = MeshData::default();
        let middle = model.size.map(|side| (side / 2) as f32);
        each_face(model, &grid, |place, axis, positive, color| {
            let first = data.positions.len() as u32;
            let [r, g, b, _] = self.palette.get(usize::from(color)).copied().unwrap_or([255; 4]);
            let linear = [srgb8_to_linear(r), srgb8_to_linear(g), srgb8_to_linear(b), 1.0];
            for (u, v) in [(0, 0), (1, 0), (1, 1), (0, 1)] {
                // The two other axes follow each other, so that the square runs counter-clockwise seen from +axis.
                let along = |a: usize| match (a.saturating_add(3).saturating_sub(axis)) % 3 {
                    0 => u32::from(positive),
                    1 => u,
                    _ => v,
                };
                let mut position = [0.0; 3];
                for (a, ((slot, place), middle)) in position.iter_mut().zip(place).zip(middle).enumerate() {
                    *slot = place.saturating_add(along(a)) as f32 - middle;
                }
                data.positions.push(position);
                let sign = if positive { 1.0 } else { -1.0 };
                data.normals.push([0, 1, 2].map(|a| if a == axis { sign } else { 0.0 }));
                data.colors.push(linear);
            }
            let corner = |k: u32| first.saturating_add(k);
            let [b, d] = if positive { [1, 3] } else { [3, 1] };
            data.triangles.push([corner(0), corner(b), corner(2)]);
            data.triangles.push([corner(0), corner(2), corner(d)]);
        });
        if data.triangles.is_empty() {
            return Ok(None);
        }
        let element = format!("{FORMAT}: model {number}");
        let mesh = Mesh::new(data).map_err(LoadError::scene(element.clone()))?;
        self.scene.add_mesh(mesh).map(Some).map_err(LoadError::scene(element))
    }

    /// Colours of the places of a model, 0 where there is no voxel, and how many voxels are outside of it.
    fn grid(&mut self, model: &Model<'_>) -> Result<(Vec<u8>, u64), LoadError> {
        let [x, y, z] = model.size.map(u64::from);
        // Sides of 8 bits have a product of 24.
        let places = x.saturating_mul(y).saturating_mul(z);
        self.budget.charge(|| format!("{FORMAT}: the places of a model"), places, 1)?;
        let mut grid = vec![0; places as usize];
        let mut outside = 0_u64;
        for &[x, y, z, color] in model.voxels {
            match place_of(model, [x.into(), y.into(), z.into()]).and_then(|place| grid.get_mut(place)) {
                Some(slot) => *slot = color,
                None => outside = outside.saturating_add(1),
            }
        }
        Ok((grid, outside))
    }
}

/// Place of a voxel in the list; `None` outside of the model.
fn place_of(model: &Model<'_>, [x, y, z]: [u32; 3]) -> Option<usize> {
    let [width, depth, height] = model.size;
    if x >= width || y >= depth || z >= height {
        return None;
    }
    Some(z.checked_mul(depth)?.checked_add(y)?.checked_mul(width)?.checked_add(x)? as usize)
}

/// Calls `f` with place, axis, direction and colour of each face that no voxel hides.
fn each_face(model: &Model<'_>, grid: &[u8], mut f: impl FnMut([u32; 3], usize, bool, u8)) {
    let at = |place: [u32; 3]| place_of(model, place).and_then(|k| grid.get(k)).copied().unwrap_or(0);
    let [width, depth, height] = model.size;
    for z in 0..height {
        for y in 0..depth {
            for x in 0..width {
                let color = at([x, y, z]);
                if color == 0 {
                    continue;
                }
                for axis in 0..3 {
                    for positive in [false, true] {
                        let step = |a: usize, v: u32| match (a == axis, positive) {
                            (false, _) => v,
                            (true, true) => v.saturating_add(1),
                            // Below zero there is nothing.
                            (true, false) => v.wrapping_sub(1),
                        };
                        if at([step(0, x), step(1, y), step(2, z)]) == 0 {
                            f([x, y, z], axis, positive, color);
                        }
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Format;
    use crate::hostile::{attack, load, warnings};

    fn chunk(name: &[u8; 4], content: &[u8]) -> Vec<u8> {
        let size = (content.len() as u32).to_le_bytes();
        [&name[..], &size, &[0; 4], content].concat()
    }

    fn words(list: &[u32]) -> Vec<u8> {
        list.iter().flat_map(|v| v.to_le_bytes()).collect()
    }

    fn dictionary(pairs: &[(&str, &str)]) -> Vec<u8> {
        let mut bytes = words(&[pairs.len() as u32]);
        for text in pairs.iter().flat_map(|(key, value)| [key, value]) {
            bytes.extend(words(&[text.len() as u32]));
            bytes.extend(text.bytes());
        }
        bytes
    }

    fn model(size: [u32; 3], voxels: &[[u8; 4]]) -> Vec<u8> {
        let places = [words(&[voxels.len() as u32]), voxels.as_flattened().to_vec()].concat();
        [chunk(b"SIZE", &words(&size)), chunk(b"XYZI", &places)].concat()
    }

    fn file(chunks: &[Vec<u8>]) -> Vec<u8> {
        let children = chunks.concat();
        let main = [&b"MAIN\0\0\0\0"[..], &(children.len() as u32).to_le_bytes()].concat();
        [b"VOX \x96\0\0\0".to_vec(), main, children].concat()
    }

    fn moved(id: u32, child: u32, attributes: &[(&str, &str)], frame: &[(&str, &str)]) -> Vec<u8> {
        let content =
            [words(&[id]), dictionary(attributes), words(&[child, u32::MAX, 0, 1]), dictionary(frame)];
        chunk(b"nTRN", &content.concat())
    }

    fn shape(id: u32, model: u32) -> Vec<u8> {
        chunk(b"nSHP", &[words(&[id]), dictionary(&[]), words(&[1, model]), dictionary(&[])].concat())
    }

    #[test]
    fn hidden_faces_are_left_out_and_others_look_outwards() {
        let bytes = file(&[model([2, 1, 1], &[[0, 0, 0, 1], [1, 0, 0, 216]])]);
        assert_eq!(Format::detect(&bytes), Some(Format::Vox));
        let loaded = load(&bytes, Format::Vox).unwrap();
        assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
        let mesh = &loaded.scene.meshes()[0];
        // Ten faces: the two between the voxels are hidden.
        assert_eq!(mesh.triangles().len(), 20);
        for t in mesh.triangles() {
            let [a, b, c] = t.map(|v| mesh.positions()[v as usize].map(f64::from));
            let (u, v): (Vec<f64>, Vec<f64>) = (0..3).map(|k| (b[k] - a[k], c[k] - a[k])).unzip();
            let normal = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
            assert_eq!(normal.map(|v| v as f32), mesh.normals()[t[0] as usize]);
        }
        let bounds = mesh.bounds();
        assert_eq!((bounds.min, bounds.max), ([-1.0, 0.0, 0.0], [1.0, 1.0, 1.0]));
        // White, and the first of the red ramp.
        let ramp = [srgb8_to_linear(0xee), 0.0, 0.0, 1.0];
        assert!(mesh.colors().contains(&[1.0; 4]) && mesh.colors().contains(&ramp));
        attack(&bytes, Format::Vox);
    }

    #[test]
    fn the_scene_graph_places_models() {
        let voxel = model([1, 1, 2], &[[0, 0, 0, 1], [0, 0, 1, 1]]);
        let group = chunk(b"nGRP", &[words(&[1]), dictionary(&[]), words(&[3, 2, 4, 6])].concat());
        let mut palette = vec![0; 1024];
        palette[..4].copy_from_slice(&[255, 0, 0, 255]);
        let bytes = file(&[
            voxel,
            moved(0, 1, &[], &[]),
            group,
            moved(2, 3, &[], &[("_t", "10 0 -1")]),
            shape(3, 0),
            // Rows: z, y, -x.
            moved(4, 5, &[], &[("_r", "70"), ("_t", "0 5 0")]),
            shape(5, 0),
            moved(6, 3, &[("_hidden", "1")], &[]),
            chunk(b"RGBA", &palette),
            chunk(b"MATL", &[words(&[1]), dictionary(&[("_type", "_glass")])].concat()),
        ]);
        let loaded = load(&bytes, Format::Vox).unwrap();
        let expected = "VOX: glass, metal and light of the palette are drawn as plain colours";
        assert_eq!(warnings(&loaded), [expected]);
        let scene = &loaded.scene;
        assert_eq!((scene.meshes().len(), scene.instances().len()), (1, 2));
        assert_eq!(scene.meshes()[0].colors()[0], [1.0, 0.0, 0.0, 1.0]);
        // Upright: +Z of the file is +Y.
        assert_eq!(scene.instances()[0].transform.point([0.0; 3]), [10.0, -1.0, 0.0]);
        assert_eq!(scene.instances()[1].transform.point([0.0, 0.0, 1.0]), [1.0, 0.0, -5.0]);
        attack(&bytes, Format::Vox);
    }

    #[test]
    fn damage_is_named() {
        let whole = file(&[model([1, 1, 1], &[[0, 0, 0, 1]]), model([1, 1, 1], &[[0, 0, 0, 1]])]);
        let loaded = load(&whole[..whole.len() - 1], Format::Vox).unwrap();
        assert_eq!(warnings(&loaded), ["VOX: the file ends within chunk 5"]);
        let loaded = load(&file(&[model([1, 1, 1], &[[0, 0, 0, 1], [1, 0, 0, 1]])]), Format::Vox).unwrap();
        assert_eq!(warnings(&loaded), ["VOX: 1 voxel outside of the model's size left out"]);
        for (bytes, message) in [
            (file(&[model([1, 257, 1], &[])]), "a model of 1 x 257 x 1 voxels"),
            (file(&[]), "there is no model in it"),
            (file(&[chunk(b"XYZI", &words(&[0]))]), "voxels without the size of their model"),
            (file(&[chunk(b"SIZE", &[0; 4])]), "chunk 2 (SIZE) ends early"),
        ] {
            let error = load(&bytes, Format::Vox).unwrap_err().to_string();
            assert!(error.contains(message), "{error}");
        }
        // A node that contains itself.
        let cycle = file(&[model([1, 1, 1], &[]), moved(0, 0, &[], &[])]);
        assert!(matches!(load(&cycle, Format::Vox), Err(LoadError::Limit(_))));
    }
}
