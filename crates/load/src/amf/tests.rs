//! Files made here.

use crate::hostile::{attack, limits, load, load_beside, warnings};
use crate::threemf::zip;
use crate::{Format, LoadError, Loaded, MemoryResolver};
use overcoat_core::color::srgb::srgb_to_linear;
use overcoat_scene::{AlphaMode, Axis, Workflow};

const VERTICES: [[f32; 3]; 4] = [[0.0; 3], [10.0, 0.0, 0.0], [0.0, 20.0, 0.0], [0.0, 0.0, 30.0]];

fn vertex([x, y, z]: [f32; 3], more: &str) -> String {
    format!("<vertex><coordinates><x>{x}</x><y> {y}</y><z>{z}</z></coordinates>{more}</vertex>")
}

fn triangle([a, b, c]: [u32; 3], more: &str) -> String {
    format!("<triangle>{more}<v1>{a}</v1><v2>{b}</v2><v3>{c}</v3></triangle>")
}

fn color(r: f32, g: f32, b: f32, a: &str) -> String {
    format!("<color><r>{r}</r><g>{g}</g><b>{b}</b>{a}</color>")
}

fn object(id: u32, more: &str, volumes: &str) -> String {
    let vertices: String = VERTICES.iter().map(|&v| vertex(v, "")).collect();
    format!("<object id=\"{id}\">{more}<mesh><vertices>{vertices}</vertices>{volumes}</mesh></object>")
}

fn plain(id: u32) -> String {
    object(id, "", &format!("<volume>{}</volume>", triangle([0, 1, 2], "")))
}

fn file(content: &str) -> Vec<u8> {
    format!(
        "<?xml version=\"1.0\" encoding=\"utf-8\"?>\n<amf unit=\"millimeter\" version=\"1.1\">{content}</amf>"
    )
    .into_bytes()
}

fn read(content: &str) -> Loaded {
    load(&file(content), Format::Amf).unwrap()
}

fn refused(content: &str) -> String {
    load(&file(content), Format::Amf).unwrap_err().to_string()
}

/// Corners of all triangles where they stand, rounded to micrometres.
fn corners(loaded: &Loaded) -> Vec<[i64; 3]> {
    let mut all = Vec::new();
    for instance in loaded.scene.instances() {
        let mesh = &loaded.scene.meshes()[instance.mesh.index()];
        for &v in mesh.triangles().as_flattened() {
            let placed = instance.transform.point(mesh.positions()[v as usize].map(f64::from));
            all.push(placed.map(|v| (v * 1e6).round() as i64));
        }
    }
    all
}

#[test]
fn lengths_become_metres_with_z_up() {
    let loaded = read(&plain(7));
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    // Stood on +Y: z is up, and the front faces +Z.
    assert_eq!(corners(&loaded), [[0, 0, 0], [10_000, 0, 0], [0, 0, -20_000]]);
    assert_eq!(Format::Amf.orientation().up, Axis::PositiveZ);
    let inches = String::from_utf8(file(&plain(7))).unwrap().replace("millimeter", "inch");
    assert_eq!(corners(&load(inches.as_bytes(), Format::Amf).unwrap())[1], [254_000, 0, 0]);
    let furlongs = inches.replace("inch", "furlong");
    let loaded = load(furlongs.as_bytes(), Format::Amf).unwrap();
    assert_eq!(warnings(&loaded), ["AMF: the unit 'furlong' is unknown: taken as millimetres"]);
    assert_eq!(corners(&loaded)[1], [10_000, 0, 0]);
}

#[test]
fn content_and_archives_tell_the_format() {
    let bytes = file(&plain(1));
    assert_eq!(Format::detect(&bytes), Some(Format::Amf));
    assert_eq!(Format::detect(b"<!-- by hand --> <AMF>"), Some(Format::Amf));
    assert_eq!(Format::detect(b"<amfibious/>"), None);
    let resolver = MemoryResolver::default();
    for deflate in [false, true] {
        let packed = zip(&[("part.amf", &bytes)], deflate);
        let loaded = load_beside(&packed, Format::Amf, &resolver, &limits()).unwrap();
        assert_eq!(loaded.scene.triangle_count(), 1);
    }
}

#[test]
fn the_innermost_colour_counts() {
    let red = color(1.0, 0.0, 0.0, "");
    let green = color(0.0, 1.0, 0.0, "<a>0.5</a>");
    let grey = color(0.5, 0.5, 0.5, "");
    let triangles = [triangle([0, 1, 2], ""), triangle([0, 1, 3], &color(0.0, 0.0, 1.0, ""))].concat();
    let volumes = [
        format!("<volume materialid=\"2\">{}</volume>", triangles),
        format!("<volume materialid=\" 2 \">{green}{}</volume>", triangle([0, 2, 3], "")),
        format!("<volume materialid=\"0\">{}</volume>", triangle([1, 2, 3], "")),
    ];
    let material =
        format!("<material id=\"2\"><metadata type=\"Name\">Tin &amp; co</metadata>{red}</material>");
    let loaded = read(&[object(1, "", &volumes.concat()), material.clone()].concat());
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    let scene = &loaded.scene;
    let looks: Vec<_> = scene
        .instances()
        .iter()
        .map(|instance| {
            let material = &scene.materials()[instance.material.index()];
            let mesh = &scene.meshes()[instance.mesh.index()];
            (material.base_color, material.alpha_mode, mesh.colors().first().copied())
        })
        .collect();
    let clay = scene.materials()[scene.instances()[3].material.index()].base_color;
    assert_eq!(
        looks,
        [
            ([1.0, 0.0, 0.0, 1.0], AlphaMode::Opaque, None),
            ([1.0; 4], AlphaMode::Opaque, Some([0.0, 0.0, 1.0, 1.0])),
            ([0.0, 1.0, 0.0, 0.5], AlphaMode::Blend, None),
            (clay, AlphaMode::Opaque, None),
        ]
    );
    // An object's colour is below that of its volumes and above that of materials.
    let loaded = read(&[object(1, &grey, &volumes.concat()), material].concat());
    let colors: Vec<f32> = loaded.scene.materials().iter().map(|material| material.base_color[0]).collect();
    assert_eq!(colors, [srgb_to_linear(0.5), 1.0, 0.0, srgb_to_linear(0.5)]);
}

#[test]
fn colours_of_vertices_vary_over_their_triangles() {
    let vertices: String = [
        vertex(VERTICES[0], &color(1.0, 0.0, 0.0, "")),
        vertex(VERTICES[1], ""),
        vertex(VERTICES[2], &color(0.0, 0.0, 1.0, "<a>0.25</a>")),
    ]
    .concat();
    let volume = format!("<volume>{}{}</volume>", color(0.0, 1.0, 0.0, ""), triangle([2, 1, 0], ""));
    let mesh = format!("<object id=\"1\"><mesh><vertices>{vertices}</vertices>{volume}</mesh></object>");
    let loaded = read(&mesh);
    let (mesh, material) = (&loaded.scene.meshes()[0], &loaded.scene.materials()[0]);
    assert_eq!(mesh.colors(), [[0.0, 0.0, 1.0, 0.25], [0.0, 1.0, 0.0, 1.0], [1.0, 0.0, 0.0, 1.0]]);
    assert_eq!(material.alpha_mode, AlphaMode::Blend);
    assert!(matches!(material.workflow, Workflow::MetallicRoughness { metallic: 0.0, .. }));
}

fn instance(id: u32, content: &str) -> String {
    format!("<instance objectid=\"{id}\">{content}</instance>")
}

#[test]
fn constellations_place_objects_and_each_other() {
    let inner = instance(1, "<deltax>5</deltax><deltay>0</deltay><deltaz>0</deltaz><rz>90</rz>");
    let outer = [instance(3, "<deltaz>100</deltaz>"), instance(3, "<rx>90</rx><rz>90</rz>")].concat();
    let loaded = read(&format!(
        "{}<constellation id=\"3\">{inner}</constellation><constellation id=\"4\">{outer}</constellation>",
        plain(1)
    ));
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    // In the axes of the file (10, 0, 0) comes to (5, 10, 0), and that to (5, 10, 100) and, by x and then z, to (0, 5, 10).
    let found = corners(&loaded);
    assert_eq!(found[1], [5_000, 100_000, -10_000]);
    assert_eq!(found[4], [0, 10_000, -5_000]);
    assert_eq!((loaded.scene.instances().len(), loaded.scene.meshes().len()), (2, 1));
    // Objects beside constellations stand where they are; of two kinds with one number the object is meant.
    let loaded = read(&format!(
        "{}{}<constellation id=\"1\">{}</constellation>",
        plain(1),
        plain(2),
        instance(1, "<deltax>1</deltax>")
    ));
    assert_eq!([corners(&loaded)[0], corners(&loaded)[3]], [[1000, 0, 0], [0; 3]]);
}

#[test]
fn constellations_that_contain_themselves_are_refused() {
    let of =
        |id: u32, placed: u32| format!("<constellation id=\"{id}\">{}</constellation>", instance(placed, ""));
    let round = [plain(1), of(3, 4), of(4, 3)].concat();
    assert_eq!(refused(&round), "AMF: every constellation is part of another: they contain themselves");
    let entered = [plain(1), of(3, 4), of(4, 3), of(5, 3)].concat();
    assert_eq!(refused(&entered), "AMF: constellation 3 contains itself");
    // Doubled again and again: more objects than the limit.
    let mut bomb = plain(1);
    for id in 2..40 {
        bomb += &format!("<constellation id=\"{id}\">{}</constellation>", instance(id - 1, "").repeat(2));
    }
    assert_eq!(refused(&bomb), "AMF: the number of placed objects: 4097 exceeds the limit of 4096 (nodes)");
    let deep: String = (2..400).map(|id| of(id, id - 1)).collect();
    assert!(refused(&(plain(1) + &deep)).contains("exceeds the limit"));
}

#[test]
fn losses_are_named() {
    let texmap = "<texmap rtexid=\"1\"><utex1>0</utex1></texmap>";
    let formula = "<color><r>x*2</r><g>0</g><b>0</b></color>";
    let modifier = format!(
        "<volume><metadata type=\"slic3r.modifier\">1</metadata>{}</volume>",
        triangle([0, 1, 3], "")
    );
    let volume = format!(
        "<volume>{formula}{}{}<triangle><v1>0</v1></triangle></volume>",
        triangle([0, 1, 2], texmap),
        triangle([0, 1, 9], "")
    );
    let normal = vertex([1.0; 3], "<normal><nx>0</nx><ny>0</ny><nz>1</nz></normal>");
    let vertices: String = VERTICES.iter().map(|&v| vertex(v, "")).collect();
    let mesh = format!(
        "<object id=\"1\"><mesh><vertices>{vertices}{normal}<edge><v1>0</v1></edge></vertices>{volume}{modifier}\
         </mesh></object>"
    );
    let composite = "<material id=\"3\"><composite materialid=\"1\">0.5</composite></material>";
    let content = format!(
        "<texture id=\"1\" width=\"1\">AAAA</texture>{mesh}{}{composite}<constellation id=\"2\">{}</constellation>",
        plain(1),
        [instance(1, "<scale>2</scale>"), instance(8, "")].concat()
    );
    let loaded = read(&content);
    assert_eq!(
        warnings(&loaded),
        [
            "AMF: texture 1 is left out: it has no width or height",
            "AMF: curved triangles (normals of vertices) are drawn flat",
            "AMF: curved triangles (edges with tangents) are drawn flat",
            "AMF: colours that are formulas have no effect",
            "AMF: there are two objects 1: the first is drawn",
            "AMF: materials mixed of others are drawn in their own colour alone",
            "AMF: scales and mirrors of instances, which slicers add to the format, have no effect",
            "AMF: 2 triangles of object 1 left out: vertices that are missing, not finite or beyond 1e15",
            "AMF: 1 volume of object 1 left out: they only change how others are printed",
            "AMF: triangles refer to textures that do not exist",
            "AMF: object 8 is referred to and does not exist",
        ]
    );
    assert_eq!(loaded.scene.triangle_count(), 1);
    assert_eq!(warnings(&read("")), ["the model has no triangles"]);
    assert!(refused("<object><mesh/></object>").ends_with("an object has no id"));
}

/// A square of two textures, of which the second is the half of the first's size.
fn textured() -> String {
    let map = |uvs: [[f32; 2]; 3]| {
        let parts = (1..).zip(uvs).map(|(k, [u, v])| format!("<utex{k}>{u}</utex{k}><vtex{k}>{v}</vtex{k}>"));
        format!("<texmap rtexid=\"1\" gtexid=\"2\">{}</texmap>", parts.collect::<String>())
    };
    let mapped = triangle([0, 1, 2], &map([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]));
    let volume = format!("<volume>{mapped}{}</volume>", triangle([0, 2, 3], &color(0.0, 0.0, 1.0, "")));
    // 0 85 170 255, and 255.
    let first =
        "<texture id=\"1\" width=\"2\" height=\"2\" depth=\"1\" tiled=\"true\"> AFWq\n/w== </texture>";
    let second = "<texture id=\"2\" width=\"1\" height=\"1\" type=\"grayscale\">/w==</texture>";
    format!("{first}{}{second}", object(1, "", &volume))
}

#[test]
fn textures_are_channels_of_pictures() {
    let loaded = read(&textured());
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    let [texture] = loaded.scene.textures() else { panic!() };
    let texels = texture.levels().next().unwrap().texels.to_vec();
    assert_eq!(texels, [[0, 255, 0, 255], [85, 255, 0, 255], [170, 255, 0, 255], [255, 255, 0, 255]]);
    let mapped = loaded.scene.meshes().iter().find(|mesh| !mesh.uvs(0).is_empty()).unwrap();
    let origin = mapped.positions().iter().position(|p| *p == [0.0; 3]).unwrap();
    assert_eq!(mapped.uvs(0)[origin], [0.0, 1.0]);
    assert_eq!(loaded.scene.meshes().len(), 2);
    for (text, message) in [
        ("<texture id=\"1\" width=\"2\" height=\"2\">AFWq</texture>", "it has 3 of 4 values"),
        ("<texture id=\"1\" width=\"1\" height=\"1\">?</texture>", "its values are not in base 64"),
        ("<texture id=\"1\" width=\"1\" height=\"1\" depth=\"2\">AFWq</texture>", "one of space"),
        (
            "<texture id=\"1\" width=\"2000000000\" height=\"2000000000\">AA==</texture>",
            "it has 1 of 4000000000000000000 values",
        ),
    ] {
        let loaded = read(&format!("{text}{}", plain(1)));
        assert!(warnings(&loaded)[0].contains(message), "{:?}", loaded.warnings);
    }
    attack(&file(&textured()), Format::Amf);
}

#[test]
fn models_far_away_keep_their_shape() {
    let far = |[x, y, z]: [f32; 3]| {
        format!(
            "<vertex><coordinates><x>{}</x><y>{y}</y><z>{z}</z></coordinates></vertex>",
            4.0e9 + f64::from(x)
        )
    };
    let vertices: String = VERTICES.iter().map(|&v| far(v)).collect();
    let loaded = read(&format!(
        "<object id=\"1\"><mesh><vertices>{vertices}</vertices><volume>{}</volume></mesh></object>",
        triangle([0, 1, 2], "")
    ));
    let found = corners(&loaded);
    assert_eq!(found[1][0] - found[0][0], 10_000);
}

#[test]
fn lists_are_within_the_limits() {
    let many: String = (0..1_u32 << 14).map(|_| triangle([0, 1, 2], "")).collect();
    let content = object(1, "", &format!("<volume>{many}</volume>"));
    let small = limits().with_triangles(1 << 13);
    let error = load_beside(&file(&content), Format::Amf, &MemoryResolver::default(), &small).unwrap_err();
    assert!(matches!(error, LoadError::Limit(_)), "{error}");
}

#[test]
fn hostile_files_end_in_a_scene_or_a_message() {
    let volume =
        format!("<volume materialid=\"2\">{}</volume>", triangle([0, 1, 2], &color(0.1, 0.2, 0.3, "")));
    let content = format!(
        "{}<material id=\"2\">{}</material><constellation id=\"3\">{}</constellation>",
        object(1, "", &volume),
        color(0.5, 0.5, 1.0, "<a>0.5</a>"),
        instance(1, "<deltax>1</deltax><ry>30</ry>")
    );
    attack(&file(&content), Format::Amf);
}
