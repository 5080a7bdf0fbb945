//! Formats beside glTF, Radiance HDR and OpenEXR as a user of the library meets them: one shape in every format, files that
//! lie, and, where `OVERCOAT_CORPUS` names a folder of models, every file of these formats in it.

#[path = "formats/far.rs"]
mod far;

use crate::common::files::package;
use overcoat::jobs::Jobs;
use overcoat::limits::Limits;
use overcoat::load::{
    Context, Format, LoadError, Loaded, MemoryResolver, load_bytes, load_environment, load_environment_file,
    load_file,
};
use overcoat::scene::Scene;
use proptest::prelude::*;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// Small bounds, so that a file that gets around one shows in the time and memory of the test.
fn limits() -> Limits {
    Limits::default()
        .with_triangles(1 << 22)
        .with_vertices(1 << 22)
        .with_texture_pixels(1 << 22)
        .with_decoded_bytes(1 << 28)
}

fn load(bytes: &[u8], format: Format) -> Result<Loaded, LoadError> {
    let resolver = MemoryResolver::default();
    load_bytes(bytes, Some(format), &Context { resolver: &resolver, limits: &limits(), jobs: &Jobs::new(1) })
}

/// An octahedron with a dent: vertices and triangles.
const VERTICES: [[f32; 3]; 6] = [
    [1.0, 0.0, 0.0],
    [-1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, -1.0, 0.0],
    [0.0, 0.0, 1.0],
    [0.0, 0.0, -0.25],
];
const TRIANGLES: [[usize; 3]; 8] =
    [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]];

fn obj() -> Vec<u8> {
    let mut text = String::new();
    VERTICES.iter().for_each(|[x, y, z]| writeln!(text, "v {x} {y} {z}").unwrap());
    TRIANGLES.iter().for_each(|[a, b, c]| writeln!(text, "f {} {} {}", a + 1, b + 1, c + 1).unwrap());
    text.into_bytes()
}

fn stl_text() -> Vec<u8> {
    let mut text = "solid dented\n".to_owned();
    for t in TRIANGLES {
        text += "facet normal 0 0 0\nouter loop\n";
        t.iter().map(|&v| VERTICES[v]).for_each(|[x, y, z]| writeln!(text, "vertex {x} {y} {z}").unwrap());
        text += "endloop\nendfacet\n";
    }
    (text + "endsolid dented\n").into_bytes()
}

fn stl_binary() -> Vec<u8> {
    let mut bytes = vec![b' '; 80];
    bytes.extend((TRIANGLES.len() as u32).to_le_bytes());
    for t in TRIANGLES {
        bytes.extend([0; 12]);
        bytes.extend(t.iter().flat_map(|&v| VERTICES[v]).flat_map(f32::to_le_bytes));
        bytes.extend([0; 2]);
    }
    bytes
}

fn ply_header(encoding: &str) -> String {
    format!(
        "ply\nformat {encoding} 1.0\nelement vertex 6\nproperty float x\nproperty float y\nproperty float z\n\
         element face 8\nproperty list uchar int vertex_indices\nend_header\n"
    )
}

fn ply_text() -> Vec<u8> {
    let mut text = ply_header("ascii");
    VERTICES.iter().for_each(|[x, y, z]| writeln!(text, "{x} {y} {z}").unwrap());
    TRIANGLES.iter().for_each(|[a, b, c]| writeln!(text, "3 {a} {b} {c}").unwrap());
    text.into_bytes()
}

fn ply_binary() -> Vec<u8> {
    let mut bytes = ply_header("binary_big_endian").into_bytes();
    bytes.extend(VERTICES.as_flattened().iter().flat_map(|v| v.to_be_bytes()));
    for t in TRIANGLES {
        bytes.push(3);
        bytes.extend(t.iter().flat_map(|&v| (v as i32).to_be_bytes()));
    }
    bytes
}

fn off() -> Vec<u8> {
    let mut text = "OFF\n6 8 0\n".to_owned();
    VERTICES.iter().for_each(|[x, y, z]| writeln!(text, "{x} {y} {z}").unwrap());
    TRIANGLES.iter().for_each(|[a, b, c]| writeln!(text, "3 {a} {b} {c}").unwrap());
    text.into_bytes()
}

fn collada() -> Vec<u8> {
    let numbers: Vec<String> = VERTICES.as_flattened().iter().map(f32::to_string).collect();
    let indices: Vec<String> = TRIANGLES.as_flattened().iter().map(usize::to_string).collect();
    format!(
        "<?xml version=\"1.0\"?>\n<COLLADA version=\"1.4.1\"><library_geometries><geometry id=\"g\"><mesh>\
         <source id=\"p\"><float_array count=\"18\">{}</float_array><technique_common><accessor count=\"6\" \
         stride=\"3\"/></technique_common></source><vertices id=\"v\"><input semantic=\"POSITION\" source=\"#p\"/>\
         </vertices><triangles count=\"8\"><input semantic=\"VERTEX\" source=\"#v\" offset=\"0\"/><p>{}</p>\
         </triangles></mesh></geometry></library_geometries><library_visual_scenes><visual_scene id=\"s\"><node>\
         <instance_geometry url=\"#g\"/></node></visual_scene></library_visual_scenes></COLLADA>\n",
        numbers.join(" "),
        indices.join(" ")
    )
    .into_bytes()
}

fn amf() -> Vec<u8> {
    let mut text =
        "<?xml version=\"1.0\"?>\n<amf unit=\"meter\"><object id=\"1\"><mesh><vertices>\n".to_owned();
    for [x, y, z] in VERTICES {
        let numbers = format!("<x>{x}</x><y>{y}</y><z>{z}</z>");
        writeln!(text, "<vertex><coordinates>{numbers}</coordinates></vertex>").unwrap();
    }
    text += "</vertices><volume>\n";
    for [a, b, c] in TRIANGLES {
        writeln!(text, "<triangle><v1>{a}</v1><v2>{b}</v2><v3>{c}</v3></triangle>").unwrap();
    }
    (text + "</volume></mesh></object></amf>\n").into_bytes()
}

fn fbx() -> Vec<u8> {
    let points: Vec<String> = VERTICES.iter().flatten().map(ToString::to_string).collect();
    // The last corner of a polygon is written as its complement.
    let corners: Vec<String> = TRIANGLES.iter().map(|[a, b, c]| format!("{a},{b},-{}", c + 1)).collect();
    format!(
        "; FBX 7.4.0 project file\nFBXHeaderExtension: {{\n FBXVersion: 7400\n}}\nGlobalSettings: {{\n Properties70: {{\n  \
         P: \"UnitScaleFactor\", \"double\", \"Number\", \"\",100\n }}\n}}\nObjects: {{\n Geometry: 1, \"Geometry::\", \"Mesh\" \
         {{\n  Vertices: *{} {{\n   a: {}\n  }}\n  PolygonVertexIndex: *{} {{\n   a: {}\n  }}\n }}\n Model: 2, \"Model::m\", \
         \"Mesh\" {{\n }}\n}}\nConnections: {{\n C: \"OO\",2,0\n C: \"OO\",1,2\n}}\n",
        points.len(),
        points.join(","),
        3 * corners.len(),
        corners.join(",")
    )
    .into_bytes()
}

fn usd() -> Vec<u8> {
    let points: Vec<String> = VERTICES.iter().map(|[x, y, z]| format!("({x}, {y}, {z})")).collect();
    let indices: Vec<String> = TRIANGLES.as_flattened().iter().map(usize::to_string).collect();
    format!(
        "#usda 1.0\n(\n    metersPerUnit = 1\n)\ndef Mesh \"m\" {{\n    uniform token subdivisionScheme = \"none\"\n    \
         int[] faceVertexCounts = [{}]\n    int[] faceVertexIndices = [{}]\n    point3f[] points = [{}]\n}}\n",
        ["3"; 8].join(", "),
        indices.join(", "),
        points.join(", ")
    )
    .into_bytes()
}

/// Coordinates and faces as VRML and X3D have them.
fn nodes() -> (String, String) {
    let points: Vec<String> = VERTICES.iter().map(|[x, y, z]| format!("{x} {y} {z}")).collect();
    let faces: Vec<String> = TRIANGLES.iter().map(|[a, b, c]| format!("{a} {b} {c} -1")).collect();
    (points.join(", "), faces.join(" "))
}

fn vrml() -> Vec<u8> {
    let (points, faces) = nodes();
    format!(
        "#VRML V2.0 utf8\nShape {{ geometry IndexedFaceSet {{ creaseAngle 0.6981317 coord Coordinate {{ point [ {points} ] }}\n\
         coordIndex [ {faces} ] }} }}\n"
    )
    .into_bytes()
}

fn x3d() -> Vec<u8> {
    let (points, faces) = nodes();
    format!(
        "<?xml version=\"1.0\"?><X3D><Scene><Shape><IndexedFaceSet creaseAngle=\"0.6981317\" coordIndex=\"{faces}\">\
         <Coordinate point=\"{points}\"/></IndexedFaceSet></Shape></Scene></X3D>\n"
    )
    .into_bytes()
}

/// The model part of a 3MF file.
fn threemf_model() -> String {
    let mut text = "<?xml version=\"1.0\"?>\n<model unit=\"inch\" \
        xmlns=\"http://schemas.microsoft.com/3dmanufacturing/core/2015/02\" \
        xmlns:m=\"http://schemas.microsoft.com/3dmanufacturing/material/2015/02\"><resources>\
        <basematerials id=\"1\"><base name=\"red\" displaycolor=\"#FF0000\"/></basematerials>\
        <m:colorgroup id=\"2\"><m:color color=\"#00FF00\"/><m:color color=\"#0000FF\"/></m:colorgroup>\
        <object id=\"5\" pid=\"1\" pindex=\"0\"><mesh><vertices>\n"
        .to_owned();
    VERTICES.iter().for_each(|[x, y, z]| writeln!(text, "<vertex x=\"{x}\" y=\"{y}\" z=\"{z}\"/>").unwrap());
    text += "</vertices><triangles>\n";
    for [a, b, c] in TRIANGLES {
        writeln!(text, "<triangle v1=\"{a}\" v2=\"{b}\" v3=\"{c}\"/>").unwrap();
    }
    text + "</triangles></mesh></object><object id=\"6\"><components><component objectid=\"5\" \
        transform=\"1 0 0 0 1 0 0 0 1 5 0 0\"/></components></object></resources><build><item objectid=\"6\"/></build>\
        </model>\n"
}

/// An archive with one part, not compressed, so that a changed byte is one of the part.
fn threemf_of(model: &[u8]) -> Vec<u8> {
    package::stored_zip(&[("3D/3dmodel.model", model)])
}

fn hdr() -> Vec<u8> {
    let mut bytes = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 3 +X 9\n".to_vec();
    for y in 0..3 {
        bytes.extend([2, 2, 0, 9]);
        (0..4).for_each(|channel| bytes.extend([132, 100 + y, 5, 1, 2, 3, 4, 128 + channel]));
    }
    bytes
}

fn exr() -> Vec<u8> {
    use exr::prelude::{Image, SpecificChannels, WritableImage as _, f16};
    let mut bytes = Vec::new();
    let pixels =
        |p: exr::math::Vec2<usize>| (f16::from_f32(p.x() as f32), f16::from_f32(p.y() as f32), f16::ONE);
    Image::from_channels((16, 8), SpecificChannels::rgb(pixels))
        .write()
        .non_parallel()
        .to_buffered(std::io::Cursor::new(&mut bytes))
        .unwrap();
    bytes
}

/// Positions and normals of all triangle corners, sorted: what is left when order and sharing are taken away.
fn corners(scene: &Scene) -> Vec<Vec<u32>> {
    let mut all = Vec::new();
    for instance in scene.instances() {
        let mesh = &scene.meshes()[instance.mesh.index()];
        for t in mesh.triangles() {
            let corner = |&v: &u32| [mesh.positions()[v as usize], mesh.normals()[v as usize]];
            // Adding zero makes -0 equal to 0.
            all.push(t.iter().flat_map(corner).flatten().map(|v| (v + 0.0).to_bits()).collect());
        }
    }
    all.sort_unstable();
    all
}

#[test]
fn one_shape_is_the_same_in_every_format() {
    let reference = corners(&load(&obj(), Format::Obj).unwrap().scene);
    assert_eq!(reference.len(), TRIANGLES.len());
    for (bytes, format) in [
        (stl_text(), Format::Stl),
        (stl_binary(), Format::Stl),
        (ply_text(), Format::Ply),
        (ply_binary(), Format::Ply),
        (threemf_of(threemf_model().as_bytes()), Format::ThreeMf),
        (off(), Format::Off),
        (collada(), Format::Collada),
        (fbx(), Format::Fbx),
        (usd(), Format::Usd),
        (amf(), Format::Amf),
        (vrml(), Format::Vrml),
        (x3d(), Format::X3d),
    ] {
        assert_eq!(Format::detect(&bytes), Some(format));
        let loaded = load(&bytes, format).unwrap();
        assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
        assert_eq!(corners(&loaded.scene), reference, "{format:?}");
    }
}

#[test]
fn loading_does_not_depend_on_threads() {
    for (bytes, format) in [
        (obj(), Format::Obj),
        (stl_binary(), Format::Stl),
        (ply_text(), Format::Ply),
        (threemf_of(threemf_model().as_bytes()), Format::ThreeMf),
    ] {
        let corners_with = |threads| {
            let resolver = MemoryResolver::default();
            let jobs = Jobs::new(threads);
            let context = Context { resolver: &resolver, limits: &limits(), jobs: &jobs };
            corners(&load_bytes(&bytes, Some(format), &context).unwrap().scene)
        };
        assert_eq!(corners_with(1), corners_with(3));
    }
}

#[test]
fn environments_are_told_by_their_content() {
    let jobs = Jobs::new(1);
    let limits = limits();
    let context = Context { resolver: &overcoat::load::NoResolver, limits: &limits, jobs: &jobs };
    let picture = load_environment(&hdr(), &context).unwrap().image;
    assert_eq!((picture.width(), picture.height()), (9, 3));
    let picture = load_environment(&exr(), &context).unwrap().image;
    assert_eq!(picture.pixels()[16 * 2 + 5], [5.0, 2.0, 1.0]);
    assert!(matches!(load_environment(b"GIF89a", &context), Err(LoadError::UnknownFormat(_))));
    assert!(matches!(
        load_environment_file(Path::new("/no/such/file.hdr"), &limits, &jobs),
        Err(LoadError::Io(_))
    ));
}

/// One line without control characters.
fn assert_presentable(message: &str) {
    assert!(!message.is_empty() && !message.chars().any(char::is_control), "{message:?}");
}

/// Whatever comes out of a damaged file is a scene or a message.
fn assert_survives(bytes: &[u8], format: Option<Format>) {
    let jobs = Jobs::new(1);
    let limits = limits();
    let context = Context { resolver: &overcoat::load::NoResolver, limits: &limits, jobs: &jobs };
    let outcome = match format {
        Some(format) => load_bytes(bytes, Some(format), &context).map(|loaded| loaded.warnings),
        None => load_environment(bytes, &context).map(|_| Vec::new()),
    };
    match outcome {
        Ok(warnings) => warnings.iter().for_each(|w| assert_presentable(&w.message)),
        Err(error) => assert_presentable(&error.to_string()),
    }
}

#[test]
fn files_cut_anywhere_end_in_a_scene_or_a_message() {
    for (bytes, format) in seeds() {
        for length in 0..bytes.len() {
            assert_survives(&bytes[..length], format);
        }
    }
}

fn seeds() -> Vec<(Vec<u8>, Option<Format>)> {
    let rich = b"mtllib a.mtl\no x\nv 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 1 1 0 0 0 1\nv 0 1 0.5 1 1 1\nvt 0 0\nvt 1 1\n\
                 vn 0 0 1\ns off\nusemtl m\nf 1/1/1 2/2/1 3//1 -1\ng y\nl 1 2\ns 1\nf 4 3 \\\n2 1 3\ncurv 0 1\n";
    vec![
        (obj(), Some(Format::Obj)),
        (rich.to_vec(), Some(Format::Obj)),
        (stl_text(), Some(Format::Stl)),
        (stl_binary(), Some(Format::Stl)),
        (ply_text(), Some(Format::Ply)),
        (ply_binary(), Some(Format::Ply)),
        (threemf_of(threemf_model().as_bytes()), Some(Format::ThreeMf)),
        (off(), Some(Format::Off)),
        (collada(), Some(Format::Collada)),
        (amf(), Some(Format::Amf)),
        (vrml(), Some(Format::Vrml)),
        (x3d(), Some(Format::X3d)),
        (fbx(), Some(Format::Fbx)),
        (usd(), Some(Format::Usd)),
        (hdr(), None),
        (exr(), None),
    ]
}

#[test]
fn content_counts_for_more_than_what_is_said() {
    for (bytes, message) in [
        (&b"BLENDER-v300RENDH"[..], "it is a Blender file; models are read from glTF, OBJ, "),
        (b"ISO-10303-21;\n", "it is a STEP file; models are read from glTF, OBJ, "),
    ] {
        for &format in Format::ALL {
            match load(bytes, format) {
                Err(error @ LoadError::UnknownFormat(_)) => {
                    assert!(error.to_string().starts_with(message), "{error}")
                }
                other => panic!("{format:?}: {other:?}"),
            }
        }
    }
    // A name that lies does not matter.
    let folder = tempfile::tempdir().unwrap();
    for (bytes, triangles) in
        [(stl_binary(), 8), (ply_binary(), 8), (threemf_of(threemf_model().as_bytes()), 8)]
    {
        let path = folder.path().join("model.obj");
        std::fs::write(&path, bytes).unwrap();
        assert_eq!(load_file(&path, &limits(), &Jobs::new(1)).unwrap().scene.triangle_count(), triangles);
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn mutations_end_in_a_scene_or_a_message(
        seed in 0_usize..9,
        edits in prop::collection::vec((any::<prop::sample::Index>(), 0_u8..4, any::<u8>()), 1..8),
    ) {
        let (mut bytes, format) = seeds().swap_remove(seed);
        for (at, edit, value) in edits {
            if bytes.is_empty() {
                break;
            }
            let at = at.index(bytes.len());
            match edit {
                0 => bytes[at] = value,
                1 => bytes[at] ^= 1 << (value % 8),
                2 => bytes.insert(at, value),
                _ => _ = bytes.remove(at),
            }
        }
        assert_survives(&bytes, format);
    }
}

/// Words that a model part consists of, to be put in each other's place.
const WORDS: [&str; 30] = [
    "<vertex ",
    "<triangle ",
    "<object id=\"5\">",
    "</object>",
    "<component objectid=\"6\"/>",
    "<item objectid=\"5\"/>",
    "x=\"1e9\"",
    "v1=\"99\"",
    "pid=\"2\" p1=\"0\" p2=\"1\" p3=\"0\"",
    "p1=\"7\"",
    "/>",
    "<mesh>",
    "</mesh>",
    "<!DOCTYPE a>",
    "<!--",
    "-->",
    "&lt;",
    "&x;",
    "<![CDATA[",
    "]]>",
    "transform=\"0 0 0 0 0 0 0 0 0 0 0 0\"",
    "type=\"other\"",
    "id=\"5\"",
    "<m:multiproperties id=\"9\" pids=\"1 2\"><m:multi pindices=\"0 1\"/></m:multiproperties>",
    "unit=\"x\"",
    "requiredextensions=\"m\"",
    "\u{e9}",
    "\"",
    "<m:compositematerials id=\"8\" matid=\"1\" matindices=\"0 0\">",
    "pid=\"9\"",
];

proptest! {
    #![proptest_config(ProptestConfig { cases: 1500, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn models_of_mixed_up_words_end_in_a_scene_or_a_message(
        edits in prop::collection::vec((any::<prop::sample::Index>(), 0_usize..40, 0_usize..WORDS.len()), 1..6),
    ) {
        let mut text = threemf_model();
        for (at, cut, word) in edits {
            let boundary = |at: usize| (at..=text.len()).find(|&at| text.is_char_boundary(at)).unwrap();
            let at = boundary(at.index(text.len()));
            let end = boundary((at + cut).min(text.len()));
            text.replace_range(at..end, WORDS[word]);
        }
        assert_survives(&threemf_of(text.as_bytes()), Some(Format::ThreeMf));
    }
}

/// The folder of models, if one is given.
fn corpus() -> Option<PathBuf> {
    std::env::var_os("OVERCOAT_CORPUS").map(PathBuf::from)
}

fn files_below(folder: &Path, out: &mut Vec<PathBuf>) {
    let mut entries: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    entries.sort();
    for path in entries {
        if path.is_dir() { files_below(&path, out) } else { out.push(path) }
    }
}

/// Expectation for a file: `kind` and, if known, its number of triangles.
struct Expected {
    file: String,
    kind: String,
    triangles: Option<u64>,
}

fn expectations(corpus: &Path) -> Vec<Expected> {
    let text = std::fs::read_to_string(corpus.join("EXPECT.tsv")).unwrap();
    let lines = text.lines().filter(|line| !line.starts_with('#'));
    let parse = |line: &str| {
        let mut columns = line.split('\t');
        let (file, kind) = (columns.next()?, columns.next()?);
        let triangles = columns.next().and_then(|c| c.split(' ').next()?.parse().ok());
        Some(Expected { file: file.to_owned(), kind: kind.to_owned(), triangles })
    };
    lines.filter_map(parse).collect()
}

#[test]
fn every_model_of_the_corpus_loads_as_expected() {
    let Some(corpus) = corpus() else { return };
    let jobs = Jobs::new(2);
    let mut seen = 0;
    for expected in expectations(&corpus) {
        if !["obj/", "stl/", "ply/", "3mf/"].iter().any(|folder| expected.file.starts_with(folder)) {
            continue;
        }
        seen += 1;
        let result = load_file(&corpus.join(&expected.file), &Limits::default(), &jobs);
        match &result {
            Ok(loaded) => println!(
                "{}: {} triangles {:?}",
                expected.file,
                loaded.scene.triangle_count(),
                loaded.warnings
            ),
            Err(error) => println!("{}: {error}", expected.file),
        }
        match (expected.kind.as_str(), result) {
            ("picture", Ok(loaded)) => {
                assert_eq!(Some(loaded.scene.triangle_count()), expected.triangles, "{}", expected.file);
                assert!(!loaded.scene.bounds().is_empty());
            }
            // Points and lines are drawn; else a message says why nothing is.
            ("warning" | "empty", Ok(loaded)) => {
                assert!(
                    loaded.scene.triangle_count() > 0 || !loaded.warnings.is_empty(),
                    "{}",
                    expected.file
                );
            }
            ("warning" | "empty", Err(error)) => assert_presentable(&error.to_string()),
            ("check", Ok(loaded)) => assert!(loaded.scene.triangle_count() > 0, "{}", expected.file),
            (kind, Ok(_)) => panic!("{}: unknown expectation {kind}", expected.file),
            (_, Err(error)) => panic!("{}: {error}", expected.file),
        }
    }
    assert!(seen > 0, "EXPECT.tsv names no file of these formats");
}

#[test]
fn every_environment_of_the_corpus_loads() {
    let Some(corpus) = corpus() else { return };
    let mut files = Vec::new();
    files_below(&corpus.join("hdr"), &mut files);
    for path in &files {
        let picture = load_environment_file(path, &Limits::default(), &Jobs::new(1)).unwrap().image;
        let mean: f64 = picture.pixels().as_flattened().iter().map(|&v| f64::from(v)).sum::<f64>()
            / (picture.pixels().len() * 3) as f64;
        println!("{}: {} x {}, mean {mean}", path.display(), picture.width(), picture.height());
        assert!(mean > 0.0 && mean < 1000.0, "{}: {mean}", path.display());
    }
    assert!(!files.is_empty());
}

#[test]
fn every_hostile_file_of_the_corpus_ends_in_a_scene_or_a_message() {
    let Some(corpus) = corpus() else { return };
    let mut files = Vec::new();
    files_below(&corpus.join("hostile"), &mut files);
    let jobs = Jobs::new(2);
    let mut seen = 0;
    for path in files {
        let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
        let outcome = match extension.as_str() {
            "obj" | "stl" | "ply" | "3mf" => load_file(&path, &Limits::default(), &jobs).map(|loaded| {
                loaded.warnings.iter().for_each(|w| assert_presentable(&w.message));
                format!("{} triangles {:?}", loaded.scene.triangle_count(), loaded.warnings)
            }),
            "hdr" | "exr" => {
                load_environment_file(&path, &Limits::default(), &jobs).map(|e| format!("{e:?}"))
            }
            _ => continue,
        };
        seen += 1;
        if let Err(error) = &outcome {
            assert_presentable(&error.to_string());
        }
        println!("{}: {}", path.display(), outcome.unwrap_or_else(|e| e.to_string()));
    }
    assert!(seen > 0);
}
