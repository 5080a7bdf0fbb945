//! Wavefront OBJ with its material libraries.
//!
//! The text is parsed here: `tobj`'s own parser refuses a file for one bad line, cuts concave polygons as fans, knows
//! no line continuations and takes numbers that are not finite. Material libraries do go through `tobj` (see
//! `mtl.rs`), by buffer: files are only read through the resolver.
//!
//! Every `o`, or `g` in files without, is an object; within it each material is a mesh. Smoothing groups do not
//! count, but `s off` does: where a file has no normals, they are smoothed over edges of up to 40 degrees.
mod assemble;
mod library;
mod maps;
mod material;
mod mtl;
mod parse;
mod strokes;
mod udim;

use super::grouped::Grouped;
use super::mesh_formats::{add_object, check_input, default_material, finish, white_material};
use super::origin::{Region, load_about, points_of_text};
use super::splitting::split;
use super::tangents::add_tangents;
use super::text::{quoted, without_mark};
use super::warnings::Warnings;
use super::warnings::counted;
use super::{Context, LoadError, Loaded, TextureLoading};
use assemble::Assembled;
use library::Library;
use overcoat_core::limits::Limits;
use overcoat_scene::{AlphaMode, Material, MaterialId, MeshData, Scene};
use parse::Obj;
use std::collections::{BTreeMap, BTreeSet};
use strokes::Strokes;

const FORMAT: &str = "OBJ";

/// Reads an OBJ file, the libraries that it names and the pictures that those name.
pub(crate) fn load(
    bytes: &[u8],
    context: &Context<'_>,
    loading: TextureLoading,
) -> Result<Loaded, LoadError> {
    check_input(context, bytes)?;
    load_about(|region| load_in(bytes, region, context, loading))
}

/// Reads a file, about an origin where its model is in a region far away.
fn load_in(
    bytes: &[u8],
    region: Option<&Region>,
    context: &Context<'_>,
    loading: TextureLoading,
) -> Result<Loaded, LoadError> {
    let origin = region.map(|region| region.origin(points_of_text(bytes, b"v")));
    let mut obj = parse::parse_about(without_mark(bytes), origin.as_ref(), context.limits)?;
    if !obj.recognised {
        return Err(LoadError::malformed(FORMAT, "no line of it is a statement of the format"));
    }
    let mut warnings = Warnings::default();
    for (what, tally) in &obj.tallies {
        let (count, line, word) = (tally.count, tally.line, &tally.word);
        warnings.add(|| format!("OBJ: {what}: {count} (first on line {line}: {word})"));
    }
    let points = obj.points_of_vertices();
    if points > 0 {
        warnings
            .add(|| format!("OBJ: there is nothing but vertices: {} drawn", counted(points as u64, "point")));
    }
    let assembled = assemble::assemble(&obj, context)?;
    let losses = &assembled.losses;
    if losses.polygons > 0 {
        let faces = counted(losses.polygons, "face");
        warnings.add(|| format!("OBJ: {faces} left out: positions missing, not finite or beyond 1e15"));
    }
    if losses.corners > 0 {
        let count = losses.corners;
        warnings
            .add(|| format!("OBJ: {count} references to texture coordinates or normals that do not exist"));
    }
    if losses.given_up > 0 {
        let count = counted(losses.given_up, "concave polygon");
        warnings.add(|| format!("OBJ: {count} with too many corners may be drawn wrongly"));
    }

    let mut library = Library::read((context, loading), &obj.libraries, &obj.materials, &mut warnings)?;
    if obj.materials.is_empty()
        && !obj.sections.is_empty()
        && let Some(name) = library.only_one()
    {
        let shown = quoted(name.as_bytes());
        warnings
            .add(|| format!("OBJ: no face names a material: {shown}, the only one of its library, is drawn"));
        obj.materials.push(name.to_owned());
        obj.sections.iter_mut().for_each(|section| section.material = Some(0));
    }
    let mut scene = Scene::new();
    scene.set_origin(origin.unwrap_or_default().0);
    let tiles = udim::tiles(&mut obj, &assembled, &library);
    let meshes = Meshes::new(&obj, &assembled, &tiles, context)?;
    let strokes = Strokes::new(&obj);
    let keys = [&meshes.keys[..], &strokes.keys].concat();
    let colors =
        if strokes.keys.is_empty() { Vec::new() } else { assemble::colors(&obj, &obj.stroke_corners) };
    let colors = if assembled.mesh.colors.is_empty() { &colors } else { &assembled.mesh.colors };
    let materials = add_materials(&mut scene, &mut library, &obj, &keys, colors, &mut warnings)?;
    let (of_meshes, of_strokes) = materials.split_at_checked(meshes.keys.len()).unwrap_or_default();
    meshes.add_to(&mut scene, assembled, of_meshes)?;
    let lost = strokes.add_to(&mut scene, &obj, of_strokes, context)?;
    obj.objects.iter().for_each(|(object, name)| scene.name_object(*object, name));
    if lost > 0 {
        let lost = counted(lost, "point or line");
        warnings.add(|| format!("OBJ: {lost} left out: positions missing, not finite or beyond 1e15"));
    }
    Ok(finish(scene, warnings.finish()))
}

/// Memory of a mesh and its instance beside vertices and triangles.
const MESH_BYTES: u64 = 640;

/// The triangles of each pair of object and material.
struct Meshes {
    /// Object and material of each mesh, in the order of their first triangle.
    keys: Vec<(u32, Option<u32>)>,
    /// Mesh of each triangle.
    mesh_of: Vec<u32>,
}

impl Meshes {
    /// `tiles` has the material of each triangle where that is not the one of its section.
    fn new(
        obj: &Obj,
        assembled: &Assembled,
        tiles: &[Option<u32>],
        context: &Context<'_>,
    ) -> Result<Self, LoadError> {
        let mut numbers = BTreeMap::new();
        let mut keys = Vec::new();
        let mut mesh_of = Vec::with_capacity(assembled.section_of.len());
        let mut current = ((u32::MAX, None), 0);
        for (t, &section) in assembled.section_of.iter().enumerate() {
            let tile = tiles.get(t).copied();
            if current.0 != (section, tile)
                && let Some(s) = obj.sections.get(section as usize)
            {
                let key = (s.object, tile.unwrap_or(s.material));
                let number = *numbers.entry(key).or_insert(keys.len() as u32);
                if number as usize == keys.len() {
                    keys.push(key);
                }
                current = ((section, tile), number);
            }
            mesh_of.push(current.1);
        }
        let count = keys.len() as u64;
        Limits::check(|| "OBJ: the number of objects".to_owned(), count, context.limits.nodes, "nodes")?;
        let bytes = count.saturating_mul(MESH_BYTES);
        Limits::check(|| "OBJ: objects".to_owned(), bytes, context.limits.decoded_bytes, "decoded_bytes")?;
        Ok(Self { keys, mesh_of })
    }

    /// Splits the mesh of the whole file and adds the parts.
    fn add_to(
        &self,
        scene: &mut Scene,
        assembled: Assembled,
        materials: &[MaterialId],
    ) -> Result<(), LoadError> {
        let whole = assembled.mesh;
        if let (&[(object, _)], &[id]) = (self.keys.as_slice(), materials)
            && in_order_of_use(&whole)
        {
            return add_part(scene, whole, id, object);
        }
        // Triangles by mesh, in the order of the file.
        let by_mesh = Grouped::new(self.keys.len(), self.mesh_of.iter().map(|&mesh| mesh as usize));
        split(&whole, &by_mesh, self.keys.len(), |m, part| {
            let (Some(&(object, _)), Some(&material)) = (self.keys.get(m), materials.get(m)) else {
                return Ok(());
            };
            add_part(scene, part, material, object)
        })
    }
}

/// Adds the mesh of an object and material.
fn add_part(scene: &mut Scene, mut part: MeshData, id: MaterialId, object: u32) -> Result<(), LoadError> {
    if scene.materials().get(id.index()).is_some_and(Material::needs_tangents) {
        add_tangents(&mut part, 0);
    }
    add_object(scene, &format!("OBJ: object {object}"), part, id, object)
}

/// True if every vertex is used, the first time in the order of their numbers: a mesh of all triangles would then be
/// the same again.
fn in_order_of_use(mesh: &MeshData) -> bool {
    let mut next = 0_u32;
    let in_order = mesh.triangles.as_flattened().iter().all(|&v| {
        next = next.saturating_add(u32::from(v == next));
        v < next
    });
    in_order && next as usize == mesh.positions.len()
}

/// The material of each mesh.
fn add_materials(
    scene: &mut Scene,
    library: &mut Library<'_>,
    obj: &Obj,
    keys: &[(u32, Option<u32>)],
    colors: &[[f32; 4]],
    warnings: &mut Warnings,
) -> Result<Vec<MaterialId>, LoadError> {
    // Each name once, in the order of the meshes.
    let mut numbers: Vec<u32> = Vec::new();
    let mut known = BTreeSet::new();
    numbers.extend(keys.iter().filter_map(|key| key.1).filter(|&number| known.insert(number)));
    let name = |number: &u32| obj.materials.get(*number as usize).map_or("", String::as_str);
    let names: Vec<&str> = numbers.iter().map(name).collect();
    let ids = library.add(scene, &names, warnings)?;
    let ids: BTreeMap<u32, MaterialId> = numbers.into_iter().zip(ids).collect();
    let mut plain = None;
    let mut out = Vec::with_capacity(keys.len());
    for &(_, material) in keys {
        let named = material.and_then(|number| ids.get(&number).copied());
        let id = match (named, plain) {
            (Some(id), _) | (None, Some(id)) => id,
            (None, None) => {
                let mut material = if colors.is_empty() { default_material() } else { white_material() };
                if colors.iter().any(|color| color[3] < 1.0) {
                    material.alpha_mode = AlphaMode::Blend;
                }
                let id = scene.add_material(material).map_err(LoadError::scene("OBJ: default material"))?;
                *plain.insert(id)
            }
        };
        out.push(id);
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::MemoryResolver;
    use overcoat_core::jobs::Jobs;
    use overcoat_scene::{PrimitiveKind, Workflow};

    fn load_files(obj: &str, files: &[(&str, &[u8])]) -> Result<Loaded, LoadError> {
        let files = files.iter().map(|(name, bytes)| ((*name).to_owned(), bytes.to_vec())).collect();
        let resolver = MemoryResolver { files };
        load(
            obj.as_bytes(),
            &Context { resolver: &resolver, limits: &Limits::default(), jobs: &Jobs::new(1) },
            TextureLoading::Whole,
        )
    }

    #[test]
    fn the_only_material_of_a_library_is_that_of_faces_that_name_none() {
        let triangle = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
        let (red, blue) = ("newmtl red\nKd 1 0 0\n", "newmtl blue\nKd 0 0 1\n");
        let color = |text: &str, library: &str| {
            let loaded = load_files(text, &[("a.mtl", library.as_bytes())]).unwrap();
            let material = loaded.scene.instances()[0].material;
            (loaded.scene.materials()[material.index()].base_color, loaded.warnings)
        };
        let (found, warnings) = color(triangle, red);
        assert_eq!(found, [1.0, 0.0, 0.0, 1.0]);
        let message = "OBJ: no face names a material: 'red', the only one of its library, is drawn";
        assert_eq!(warnings.iter().map(|w| w.message.as_str()).collect::<Vec<_>>(), [message]);
        // Two materials are ambiguous; faces without one beside others mean none.
        let (clay, warnings) = color(triangle, &format!("{red}{blue}"));
        assert!(clay != found && warnings.is_empty());
        assert_eq!(color(&format!("{triangle}usemtl red\nf 1 2 3\n"), red).0, clay);
    }

    #[test]
    fn tiles_have_pictures_of_their_own() {
        // A triangle in the first tile, two in the second, one in that above the first.
        let square = |u: f32, v: f32| format!("vt {u} {v}\nvt {} {v}\nvt {u} {}\n", u + 0.5, v + 0.5);
        let text = format!(
            "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\n{}{}{}usemtl m\nf 1/1 2/2 3/3\nf 1/4 2/5 3/6\nf 1/7 2/8 3/9\nf 1/4 2/5 3/6\n",
            square(0.2, 0.2),
            square(1.2, 0.2),
            square(0.2, 1.2),
        );
        let pictures = [[255, 0, 0, 255], [0, 255, 0, 255], [0, 0, 255, 255]].map(|texel| png(&[texel], 1));
        let load = |map: &str, names: [&str; 3]| {
            let library = format!("newmtl m\nmap_Kd {map}\n");
            let files: Vec<(&str, &[u8])> =
                names.into_iter().zip(&pictures).map(|(name, bytes)| (name, bytes.as_slice())).collect();
            load_files(&text, &[&[("a.mtl", library.as_bytes())][..], &files].concat()).unwrap()
        };
        let found = |loaded: &Loaded| -> Vec<(usize, Option<[u8; 4]>)> {
            let scene = &loaded.scene;
            let of = |i: &overcoat_scene::Instance| {
                let texture = scene.materials()[i.material.index()].base_color_texture;
                let texel = texture.map(|t| scene.textures()[t.texture.index()].image().texels()[0]);
                (scene.meshes()[i.mesh.index()].triangles().len(), texel)
            };
            scene.instances().iter().map(of).collect()
        };
        let [red, green, blue] = [[255, 0, 0, 255], [0, 255, 0, 255], [0, 0, 255, 255]].map(Some);
        for map in ["t.<UDIM>.png", "-s 1 1 t.<udim>.png", "t.1001.png"] {
            let loaded = load(map, ["t.1001.png", "t.1002.png", "t.1011.png"]);
            assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
            assert_eq!(found(&loaded), [(1, red), (2, green), (1, blue)], "{map}");
        }
        // A tile that is not there; a picture that only is called like one.
        let loaded = load("t.<UDIM>.png", ["t.1001.png", "t.1002.png", "other"]);
        assert_eq!(found(&loaded), [(1, red), (2, green), (1, None)]);
        assert!(loaded.warnings.len() == 1 && loaded.warnings[0].message.contains("t.1011.png"));
        let loaded = load("t.1001.png", ["t.1001.png", "x", "y"]);
        assert_eq!(found(&loaded), [(1, red), (2, red), (1, red)]);
        assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    }

    fn png(texels: &[[u8; 4]], width: u32) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, width, texels.len() as u32 / width);
        encoder.set_color(png::ColorType::Rgba);
        encoder.write_header().unwrap().write_image_data(texels.as_flattened()).unwrap();
        bytes
    }

    const QUAD: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n";

    #[test]
    fn a_quad_without_anything_is_flat_grey_and_two_sided() {
        let loaded = load_files(&format!("{QUAD}f 1 2 3 4"), &[]).unwrap();
        assert!(loaded.warnings.is_empty());
        let mesh = &loaded.scene.meshes()[0];
        assert_eq!(mesh.triangles(), [[0, 1, 2], [0, 2, 3]]);
        assert_eq!(mesh.normals(), [[0.0, 0.0, 1.0]; 4]);
        assert!(mesh.uvs(0).is_empty());
        assert!(loaded.scene.materials()[0].double_sided);
    }

    #[test]
    fn coordinates_flip_and_colours_become_linear() {
        let text = "v 0 0 0 1 0.5 0\nv 1 0 0 1 1 1\nv 0 1 0 0 0 0\nvt 0.25 0.75\nf 1/1 2 3";
        let loaded = load_files(text, &[]).unwrap();
        let mesh = &loaded.scene.meshes()[0];
        assert_eq!(mesh.uvs(0), [[0.25, 0.25], [0.0, 0.0], [0.0, 0.0]]);
        assert!((mesh.colors()[0][1] - 0.214).abs() < 1e-3);
        assert_eq!(loaded.scene.materials()[0].base_color, [1.0; 4]);
    }

    #[test]
    fn colours_have_alpha_and_other_ranges() {
        let colors = |words: [&str; 3]| {
            let [a, b, c] = words;
            let text = format!("v 0 0 0 {a}\nv 1 0 0 {b}\nv 0 1 0 {c}\nf 1 2 3");
            let loaded = load_files(&text, &[]).unwrap();
            (loaded.scene.meshes()[0].colors().to_vec(), loaded.scene.materials()[0].alpha_mode)
        };
        let opaque = colors(["1 0 0", "0 1 0", "0 0 1"]);
        assert_eq!(colors(["1 0 0 1", "0 1 0 1", "0 0 1 1"]), opaque);
        assert_eq!(colors(["1 1 0 0 1", "1 0 1 0 1", "1 0 0 1 1"]), opaque);
        assert_eq!(colors(["255 0 0", "0 255 0", "0 0 255"]), opaque);
        assert_eq!(colors(["1 0 0 0", "0 1 0 0", "0 0 1 0"]), opaque);
        let (thin, mode) = colors(["1 0 0 0.5", "0 1 0 1", ""]);
        assert_eq!(
            (thin, mode),
            (vec![[1.0, 0.0, 0.0, 0.5], [0.0, 1.0, 0.0, 1.0], [1.0; 4]], AlphaMode::Blend)
        );
        assert_eq!(colors(["255 0 0", "0 255 0", ""]).0[2], [1.0; 4]);
        let text = "#MRGB ffff0000ff00ff00\n#MRGB ff0000ff\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3";
        assert_eq!(load_files(text, &[]).unwrap().scene.meshes()[0].colors(), opaque.0);
    }

    #[test]
    fn objects_and_materials_are_meshes_but_smooth_surfaces_stay_smooth() {
        // Two faces at 20 degrees, one object and material each.
        let text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 2 0 0.36\nv 2 1 0.36\n\
                    o a\nusemtl x\nf 1 2 3 4\no b\nusemtl y\nf 2 5 6 3\nusemtl x\nf 1 2 3";
        let loaded = load_files(text, &[]).unwrap();
        let objects: Vec<u32> = loaded.scene.instances().iter().map(|i| i.object).collect();
        assert_eq!(objects, [0, 1, 1]);
        assert_eq!([0, 1, 2].map(|object| loaded.scene.object_name(object)), [Some("a"), Some("b"), None]);
        let (a, b) = (&loaded.scene.meshes()[0], &loaded.scene.meshes()[1]);
        assert_eq!(a.normals()[1], b.normals()[0]);
        assert!(a.normals()[1][0] < -0.1 && a.normals()[0][0] > -1e-6);
    }

    #[test]
    fn normals_of_the_file_and_flat_faces_stay_beside_generated_ones() {
        let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nvn 0 1 0\nf 1//1 2//1 3//1\nf 2 4 3\ns off\nf 1 2 4";
        let loaded = load_files(text, &[]).unwrap();
        let mesh = &loaded.scene.meshes()[0];
        let normals = |t: usize| mesh.triangles()[t].map(|v| mesh.normals()[v as usize]);
        assert_eq!(normals(0), [[0.0, 1.0, 0.0]; 3]);
        assert_eq!(normals(1), [[0.0, 0.0, 1.0]; 3]);
        assert_eq!(normals(2), [[0.0; 3]; 3]);
    }

    #[test]
    fn phong_and_physical_materials() {
        let mtl = b"newmtl phong\nKd 0.5 0.5 0.5\nKs 1 1 1\nNs 98\nd 0.5\nNi 1.4\nnewmtl lambert\nKs 0 0 0\nNs 50\n\
                    newmtl paint\nKd 0.5 0.25 0.125\nPr 0.3\nPm 0.75\nPc 0.9\nPcr 0.05\nKe 2 0 0\naniso 0.5\nTr 0\n";
        let text = format!(
            "mtllib my materials.mtl\n{QUAD}usemtl phong\nf 1 2 3\nusemtl lambert\nf 1 2 3\nusemtl paint\nf 1 2 3\nusemtl lost\nf 1 2 3"
        );
        let loaded = load_files(&text, &[("my materials.mtl", mtl)]).unwrap();
        let [phong, lambert, paint, lost] = loaded.scene.materials() else { panic!() };
        let roughness = |m: &Material| match m.workflow {
            Workflow::MetallicRoughness { roughness, .. } => roughness,
            Workflow::SpecularGlossiness { .. } => panic!(),
        };
        assert!((phong.base_color[0] - 0.214).abs() < 1e-3 && phong.base_color[3] == 0.5);
        assert_eq!((phong.alpha_mode, phong.ior), (AlphaMode::Blend, 1.4));
        assert!((roughness(phong) - 0.02_f32.sqrt().sqrt()).abs() < 1e-7);
        assert_eq!(roughness(lambert), 1.0);
        assert_eq!(paint.base_color, [0.5, 0.25, 0.125, 1.0]);
        assert_eq!((paint.coat, paint.coat_roughness, paint.emissive), (0.9, 0.05, [2.0, 0.0, 0.0]));
        assert_eq!(lost, &default_material());
        let messages: Vec<String> = loaded.warnings.iter().map(ToString::to_string).collect();
        assert_eq!(
            messages,
            ["OBJ: material 'lost' is not defined", "OBJ: aniso of material 'paint' not drawn"]
                .iter()
                .rev()
                .cloned()
                .collect::<Vec<_>>()
        );
    }

    #[test]
    fn materials_that_nobody_could_see_are_opaque() {
        let files: [(&str, &[u8]); 1] = [("a.mtl", b"newmtl a\nKd 0.5 0 0\nd 0.000000\n")];
        let loaded = load_files(&format!("mtllib a.mtl\n{QUAD}usemtl a\nf 1 2 3 4"), &files).unwrap();
        let material = &loaded.scene.materials()[0];
        assert_eq!((material.base_color[3], material.alpha_mode), (1.0, AlphaMode::Opaque));
        let warnings: Vec<&str> = loaded.warnings.iter().map(|w| w.message.as_str()).collect();
        assert_eq!(warnings, ["OBJ: material 'a' is wholly transparent as written: drawn opaque"]);
    }

    #[test]
    fn maps_are_read_packed_and_turned() {
        let rough = png(&[[51, 0, 0, 255]], 1);
        let metal = png(&[[204, 0, 0, 255]; 4], 2);
        let color = png(&[[200, 100, 50, 255]; 4], 2);
        let mask = png(&[[255; 4], [0, 0, 0, 255], [255; 4], [255; 4]], 2);
        let height = png(&[[0, 0, 0, 255], [255; 4], [255; 4], [0, 0, 0, 255]], 2);
        let mtl = br"newmtl m
Kd 0 0 0
map_Kd -s 2 2 2 .\tex\color.png
map_d mask.png
map_Pr rough.png
map_Pm metal.png
map_Bump -bm 0.5 C:\work\height.png
map_Pc mask.png
map_Ke nothing.png
";
        let files: [(&str, &[u8]); 6] = [
            ("m.mtl", mtl),
            ("tex/color.png", &color),
            ("mask.png", &mask),
            ("rough.png", &rough),
            ("metal.png", &metal),
            ("height.png", &height),
        ];
        let text = format!("mtllib m.mtl\n{QUAD}usemtl m\nf 1/1 2/2 3/3 4/4");
        let folder = tempfile::tempdir().unwrap();
        for (name, bytes) in files {
            let path = folder.path().join(name);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, bytes).unwrap();
        }
        let resolver = crate::DirectoryResolver::new(folder.path());
        let context = Context { resolver: &resolver, limits: &Limits::default(), jobs: &Jobs::new(2) };
        let loaded = load(text.as_bytes(), &context, TextureLoading::Whole).unwrap();
        let material = &loaded.scene.materials()[0];
        let texels = |t: &overcoat_scene::TextureRef| {
            loaded.scene.textures()[t.texture.index()].image().texels().to_vec()
        };
        let base = material.base_color_texture.unwrap();
        assert_eq!(texels(&base)[..2], [[200, 100, 50, 255], [200, 100, 50, 0]]);
        assert_eq!(base.transform.rows, [[2.0, 0.0, 0.0], [0.0, 2.0, -1.0]]);
        assert_eq!(material.base_color, [1.0; 4]);
        assert_eq!(material.alpha_mode, AlphaMode::Mask { cutoff: 0.5 });
        let Workflow::MetallicRoughness { metallic, roughness, texture } = material.workflow else {
            panic!()
        };
        assert_eq!((metallic, roughness), (1.0, 1.0));
        assert_eq!(texels(&texture.unwrap()), [[255, 51, 204, 255]; 4]);
        assert_eq!(material.coat, 1.0);
        assert!(material.normal_texture.is_some());
        assert!(!loaded.scene.meshes()[0].tangents().is_empty());
        assert_eq!(loaded.warnings.len(), 1, "{:?}", loaded.warnings);
        assert!(loaded.warnings[0].message.contains("'nothing.png'"));
    }

    /// Loads a file of a folder with others in it.
    fn load_folder(model: &str, files: &[(&str, &[u8])]) -> Loaded {
        let folder = tempfile::tempdir().unwrap();
        for (name, bytes) in files {
            let path = folder.path().join(name);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, bytes).unwrap();
        }
        crate::load_file(&folder.path().join(model), &Limits::default(), &Jobs::new(1)).unwrap()
    }

    /// The colour of the only texel of the base colour of a material.
    fn texel(loaded: &Loaded, material: usize) -> Option<[u8; 4]> {
        let texture = loaded.scene.materials()[material].base_color_texture?;
        Some(loaded.scene.textures()[texture.texture.index()].image().texels()[0])
    }

    #[test]
    fn textures_are_where_they_can_be() {
        let red = png(&[[255, 0, 0, 255]], 1);
        let text = format!("mtllib mats/m.mtl\n{QUAD}usemtl m\nf 1/1 2/2 3/3");
        for (written, place, warnings) in [
            ("img/t.png", "mats/img/t.png", 0),
            (r"..\t.png", "t.png", 0),
            (r"img\t.png", "img/t.png", 0),
            ("textures/wood/t.png", "t.png", 0),
            ("textures/wood/t.png", "mats/t.png", 0),
            (r"C:\Users\me\textures\t.png", "mats/textures/t.png", 0),
            ("/home/me/t.png", "t.png", 0),
            ("\"my t.png\"  ", "my t.png", 0),
            ("T.PNG", "mats/t.png", 1),
            ("Img/T.png", "IMG/t.PNG", 1),
            ("-colorspace sRGB t.png", "t.png", 1),
            ("-unheard of my t.png", "my t.png", 1),
        ] {
            let mtl = format!("newmtl m\nmap_Kd {written}\n");
            let files: [(&str, &[u8]); 3] =
                [("x.obj", text.as_bytes()), ("mats/m.mtl", mtl.as_bytes()), (place, &red)];
            let loaded = load_folder("x.obj", &files);
            assert_eq!(texel(&loaded, 0), Some([255, 0, 0, 255]), "{written}: {:?}", loaded.warnings);
            assert_eq!(loaded.warnings.len(), warnings, "{written}: {:?}", loaded.warnings);
        }
        // Every kind of map.
        let maps = [
            "map_Kd", "map_d", "map_Ks", "map_Ke", "map_Pr", "map_Pm", "map_Pc", "map_Pcr", "norm",
            "map_Bump",
        ];
        let mtl = maps.map(|map| format!("{map} t.png\n")).concat();
        let files: [(&str, &[u8]); 3] = [
            ("x.obj", text.as_bytes()),
            ("m.mtl", &[b"newmtl m\n", mtl.as_bytes()].concat()),
            ("deep/t.png", &red),
        ];
        assert_eq!(load_folder("x.obj", &files).warnings.len(), 1);
        let files = [files[0], files[1], ("t.png", &red)];
        let loaded = load_folder("x.obj", &files);
        assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
        assert!(loaded.scene.materials()[0].emissive_texture.is_some());
    }

    #[test]
    fn a_library_that_was_renamed_with_its_model_is_found() {
        let mtl: &[u8] = b"newmtl m\nKd 1 0 0\n";
        for (head, name, red, warnings) in [
            ("", "car.mtl", true, 1),
            ("mtllib untitled.mtl\n", "car.mtl", true, 2),
            ("", "car.obj.mtl", true, 1),
            ("", "van.mtl", false, 0),
        ] {
            let text = format!("{head}{QUAD}usemtl m\nf 1 2 3");
            let loaded = load_folder("car.obj", &[("car.obj", text.as_bytes()), (name, mtl)]);
            assert_eq!(loaded.scene.materials()[0].base_color == [1.0, 0.0, 0.0, 1.0], red, "{head}{name}");
            assert_eq!(loaded.warnings.len(), warnings, "{head}{name}: {:?}", loaded.warnings);
        }
        // Without materials there is nothing to look for.
        let text = format!("{QUAD}f 1 2 3");
        let loaded = load_folder("car.obj", &[("car.obj", text.as_bytes()), ("car.mtl", mtl)]);
        assert!(loaded.warnings.is_empty());
    }

    #[test]
    fn names_that_are_not_utf8_differ_where_their_bytes_do() {
        let obj =
            [b"mtllib m.mtl\n", QUAD.as_bytes(), b"usemtl M\xe9\nf 1 2 3\nusemtl M\xe8\nf 1 3 4"].concat();
        let mtl: &[u8] = b"newmtl M\xe9\nKd 1 0 0\nnewmtl M\xe8\nKd 0 1 0\n";
        let loaded = load_folder("x.obj", &[("x.obj", &obj), ("m.mtl", mtl)]);
        let colors: Vec<_> = loaded.scene.materials().iter().map(|m| m.base_color).collect();
        assert_eq!(colors, [[1.0, 0.0, 0.0, 1.0], [0.0, 1.0, 0.0, 1.0]]);
        assert_eq!(loaded.scene.materials()[0].name, "M\u{fffd}");
        assert_eq!(loaded.warnings.len(), 1, "{:?}", loaded.warnings);
    }

    #[cfg(unix)]
    #[test]
    fn nothing_outside_of_the_folder_is_found_by_any_name() {
        let (outside, red) = (tempfile::tempdir().unwrap(), png(&[[255, 0, 0, 255]], 1));
        std::fs::write(outside.path().join("t.png"), &red).unwrap();
        let inside = tempfile::tempdir().unwrap();
        std::os::unix::fs::symlink(outside.path(), inside.path().join("link")).unwrap();
        let absolute = outside.path().join("t.png").to_string_lossy().into_owned();
        for name in ["link/t.png", "LINK/T.PNG", "link/T.PNG", "../t.png", &absolute] {
            std::fs::write(inside.path().join("m.mtl"), format!("newmtl m\nmap_Kd {name}\n")).unwrap();
            let path = inside.path().join("x.obj");
            std::fs::write(&path, format!("mtllib m.mtl\n{QUAD}usemtl m\nf 1/1 2/2 3/3")).unwrap();
            let loaded = crate::load_file(&path, &Limits::default(), &Jobs::new(1)).unwrap();
            assert_eq!(
                (texel(&loaded, 0), loaded.warnings.len()),
                (None, 1),
                "{name}: {:?}",
                loaded.warnings
            );
        }
    }

    #[test]
    fn textures_of_other_kinds_are_drawn() {
        // One texel of blue.
        let header = [0, 0, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 1, 0, 24, 0];
        let tga = [&header[..], &[255, 0, 0]].concat();
        let text = format!("mtllib m.mtl\n{QUAD}usemtl m\nf 1/1 2/2 3/3");
        let mtl: &[u8] = b"newmtl m\nmap_Kd t.tga\nmap_Ke lfs.png\nKe 1 1 1\n";
        let lfs: &[u8] = b"version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 1\n";
        let files: [(&str, &[u8]); 4] =
            [("x.obj", text.as_bytes()), ("m.mtl", mtl), ("t.tga", &tga), ("lfs.png", lfs)];
        let loaded = load_folder("x.obj", &files);
        assert_eq!(texel(&loaded, 0), Some([0, 0, 255, 255]));
        assert_eq!(loaded.warnings.len(), 1, "{:?}", loaded.warnings);
        assert!(loaded.warnings[0].message.contains("Git LFS"), "{:?}", loaded.warnings);
        assert_eq!(loaded.scene.materials()[0].emissive, [0.0; 3]);
    }

    #[test]
    fn references_that_lead_away_are_warnings() {
        let text = format!("mtllib ../../etc/passwd\nmtllib self.obj\n{QUAD}f 1 2 3");
        let loaded = load_files(&text, &[]).unwrap();
        assert_eq!(loaded.warnings.len(), 2);
        assert_eq!(loaded.scene.triangle_count(), 1);
    }

    #[test]
    fn bad_faces_cost_only_themselves() {
        let text = format!("v nan inf 0\n{QUAD}f 1 2 3\nf 2 3 99\nf 2 3 4\nf 2/9/9 3 4\nf x y z\ncurv 0 1");
        let loaded = load_files(&text, &[]).unwrap();
        assert_eq!(loaded.scene.triangle_count(), 2);
        assert_eq!(loaded.warnings.len(), 4, "{:?}", loaded.warnings);
        assert!(load_files("", &[]).is_err());
        assert!(load_files("hello\n\0\x01", &[]).unwrap_err().to_string().contains("no line"));
    }

    #[test]
    fn points_and_lines_are_meshes_of_their_own() {
        let mtl = b"newmtl m\nKd 1 0 0\n";
        let text = "mtllib m.mtl\nv 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 1 1 0 0 0 1\nv nan 0 0\np 1 3\nusemtl m\nl 1 2 3 4";
        let loaded = load_files(text, &[("m.mtl", mtl)]).unwrap();
        let [points, lines] = loaded.scene.meshes() else { panic!() };
        assert_eq!((points.kind(), points.primitive_count()), (PrimitiveKind::Points, 2));
        assert_eq!(points.positions(), [[0.0; 3], [1.0, 1.0, 0.0]]);
        assert_eq!(points.colors(), [[1.0, 0.0, 0.0, 1.0], [0.0, 0.0, 1.0, 1.0]]);
        assert_eq!((lines.kind(), lines.triangles()), (PrimitiveKind::Lines, &[[0, 1, 1], [1, 2, 2]][..]));
        let unlit: Vec<bool> = loaded
            .scene
            .instances()
            .iter()
            .map(|i| loaded.scene.materials()[i.material.index()].unlit)
            .collect();
        assert_eq!(unlit, [false, true]);
        assert_eq!(loaded.warnings.len(), 1, "{:?}", loaded.warnings);
        assert!(loaded.warnings[0].message.contains("1 point or line left out"));
    }

    #[test]
    fn vertices_alone_are_points() {
        let loaded = load_files("v 0 0 0\nv 1 0 0\nvn 0 1 0\nvn 0 0 1\n", &[]).unwrap();
        let mesh = &loaded.scene.meshes()[0];
        assert_eq!((mesh.kind(), mesh.primitive_count()), (PrimitiveKind::Points, 2));
        assert_eq!(mesh.normals(), [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
        assert!(loaded.warnings[0].message.contains("2 points drawn"), "{:?}", loaded.warnings);
        // Not those of faces that cannot be read, nor the control points of curves.
        for text in ["v 0 0 0\nf 1 x 2", "v 0 0 0\ncurv 0 1 1"] {
            assert!(load_files(text, &[]).unwrap().scene.meshes().is_empty());
        }
    }

    #[test]
    fn lists_are_bounded_while_they_are_read() {
        let vertices = Limits::default().with_vertices(9999);
        let bytes = Limits::default().with_decoded_bytes(99_999);
        for (limits, field) in [(vertices, "vertices"), (bytes, "decoded_bytes")] {
            let context = Context { resolver: &crate::NoResolver, limits: &limits, jobs: &Jobs::new(1) };
            let text = "v 0 0 0\n".repeat(1_000_000);
            let error = load(text.as_bytes(), &context, TextureLoading::Whole).unwrap_err();
            let LoadError::Limit(limit) = error else { panic!("{error}") };
            // Long before the end.
            assert!(limit.field == field && limit.asked.is_some_and(|asked| asked < 250_000), "{limit:?}");
        }
    }

    #[test]
    fn limits_hold() {
        let limits = Limits::default().with_triangles(1);
        let context = Context { resolver: &crate::NoResolver, limits: &limits, jobs: &Jobs::new(1) };
        let error = load(format!("{QUAD}f 1 2 3 4").as_bytes(), &context, TextureLoading::Whole).unwrap_err();
        assert!(matches!(error, LoadError::Limit(_)), "{error}");
    }

    #[test]
    fn a_byte_order_mark_is_no_statement() {
        let mtl = b"\xef\xbb\xbfnewmtl m\nPc 1\n";
        let text = format!("\u{feff}mtllib m.mtl\n{QUAD}usemtl m\nf 1 2 3");
        let loaded = load_files(&text, &[("m.mtl", mtl)]).unwrap();
        assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
        assert_eq!(loaded.scene.materials()[0].coat, 1.0);
    }
}
