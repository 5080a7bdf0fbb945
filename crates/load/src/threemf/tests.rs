//! Packages made here.

use super::*;
use crate::{Format, NoResolver};
use miniz_oxide::deflate::compress_to_vec;
use overcoat_core::jobs::Jobs;
use overcoat_scene::{AlphaMode, Filter, Workflow, Wrap};

/// An archive; `deflate` compresses its parts.
pub(crate) fn zip(parts: &[(&str, &[u8])], deflate: bool) -> Vec<u8> {
    let (mut out, mut directory) = (Vec::new(), Vec::new());
    for (name, content) in parts {
        let packed = if deflate { compress_to_vec(content, 6) } else { content.to_vec() };
        let mut fields = Vec::new();
        fields.extend([20, 0, 0, 0, if deflate { 8 } else { 0 }, 0, 0, 0, 0, 0]);
        fields.extend(rawzip::crc32(content).to_le_bytes());
        fields.extend((packed.len() as u32).to_le_bytes());
        fields.extend((content.len() as u32).to_le_bytes());
        fields.extend((name.len() as u16).to_le_bytes());
        fields.extend([0, 0]);
        directory.extend(b"PK\x01\x02\x14\x00");
        directory.extend(&fields);
        directory.extend([0; 10]);
        directory.extend((out.len() as u32).to_le_bytes());
        directory.extend(name.bytes());
        out.extend(b"PK\x03\x04");
        out.extend(fields);
        out.extend(name.bytes());
        out.extend(packed);
    }
    let start = out.len() as u32;
    let count = (parts.len() as u16).to_le_bytes();
    out.extend(&directory);
    out.extend(b"PK\x05\x06\0\0\0\0");
    out.extend([count, count].concat());
    out.extend((directory.len() as u32).to_le_bytes());
    out.extend(start.to_le_bytes());
    out.extend([0, 0]);
    out
}

const RELATIONS: &str = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
    <Relationships xmlns=\"http://schemas.openxmlformats.org/package/2006/relationships\">\
    <Relationship Target=\"/3D/a.model\" Id=\"r0\" \
    Type=\"http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel\"/></Relationships>";

pub(super) const HEAD: &str = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<model unit=\"millimeter\" \
    xmlns=\"http://schemas.microsoft.com/3dmanufacturing/core/2015/02\" \
    xmlns:m=\"http://schemas.microsoft.com/3dmanufacturing/material/2015/02\" \
    xmlns:p=\"http://schemas.microsoft.com/3dmanufacturing/production/2015/06\" \
    xmlns:s=\"http://schemas.microsoft.com/3dmanufacturing/slice/2015/07\" \
    xmlns:x=\"http://example.org/unknown\"";

/// Two triangles that meet at a right angle, one below the other.
const VERTICES: &str = "<vertices><vertex x=\"0\" y=\"0\" z=\"0\"/><vertex x=\"10\" y=\"0\" z=\"0\"/>\
    <vertex x=\"0\" y=\"0\" z=\"20\"/><vertex x=\"0\" y=\"30\" z=\"0\"/></vertices>";

fn mesh(triangles: &str) -> String {
    format!("<mesh>{VERTICES}<triangles>{triangles}</triangles></mesh>")
}

fn plain_mesh() -> String {
    mesh("<triangle v1=\"0\" v2=\"1\" v3=\"2\"/><triangle v1=\"0\" v2=\"3\" v3=\"1\"/>")
}

fn model(resources: &str, build: &str) -> String {
    format!("{HEAD}><resources>{resources}</resources><build>{build}</build></model>")
}

fn package(model: &str) -> Vec<u8> {
    zip(&[("_rels/.rels", RELATIONS.as_bytes()), ("3D/a.model", model.as_bytes())], true)
}

fn load_with(bytes: &[u8], limits: &Limits) -> Result<Loaded, LoadError> {
    let context = Context { resolver: &NoResolver, limits, jobs: &Jobs::new(1) };
    let mut loaded = load(bytes, &context, &LoadOptions::default(), &Shares::default())?;
    loaded.scene.stand_up(Format::ThreeMf.orientation());
    Ok(loaded)
}

fn load_model(model: &str) -> Result<Loaded, LoadError> {
    load_with(&package(model), &Limits::default())
}

fn messages(loaded: &Loaded) -> Vec<&str> {
    loaded.warnings.iter().map(|warning| warning.message.as_str()).collect()
}

/// World positions of the first instance's vertices, in millimetres.
fn placed(loaded: &Loaded, instance: usize) -> Vec<[f64; 3]> {
    let instance = &loaded.scene.instances()[instance];
    let positions = loaded.scene.meshes()[instance.mesh.index()].positions();
    let place = |p: &[f32; 3]| instance.transform.point(p.map(f64::from)).map(|v| (v * 1e6).round() / 1e3);
    positions.iter().map(place).collect()
}

#[test]
fn what_is_built_stands_upright_in_metres() {
    let text = model(
        &format!("<object id=\"1\">{}</object><object id=\"2\">{0}</object>", plain_mesh()),
        "<item objectid=\"1\"/><item objectid=\"1\" transform=\"0 1 0 -1 0 0 0 0 2 100 0 5\"/>",
    );
    for deflate in [false, true] {
        let bytes = zip(&[("_rels/.rels", RELATIONS.as_bytes()), ("3D/A.model", text.as_bytes())], deflate);
        let loaded = load_with(&bytes, &Limits::default()).unwrap();
        assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
        assert_eq!((loaded.scene.meshes().len(), loaded.scene.instances().len()), (1, 2));
        let at = placed(&loaded, 0);
        assert!(at.contains(&[0.0, 20.0, 0.0]) && at.contains(&[0.0, 0.0, -30.0]), "{at:?}");
        // Rows are the axes: (x, y, z) goes to (100 - y, x, 5 + 2 z), which is drawn upright.
        let at = placed(&loaded, 1);
        assert!(at.contains(&[100.0, 45.0, 0.0]) && at.contains(&[70.0, 5.0, 0.0]), "{at:?}");
        assert!(at.contains(&[100.0, 5.0, -10.0]), "{at:?}");
        assert_eq!(loaded.scene.instances()[1].object, 1);
    }
}

#[test]
fn units_and_encodings() {
    for (unit, metres) in [("inch", 0.0254), ("micron", 1e-6), ("foot", 0.3048), ("meter", 1.0)] {
        let text = model(&format!("<object id=\"1\">{}</object>", plain_mesh()), "<item objectid=\"1\"/>")
            .replace("millimeter", unit);
        let mut utf16 = vec![0xff, 0xfe];
        utf16.extend(text.encode_utf16().flat_map(u16::to_le_bytes));
        for bytes in [text.into_bytes(), utf16] {
            // Without relations the usual place counts.
            let loaded = load_with(&zip(&[("3D/3dmodel.model", &bytes)], true), &Limits::default()).unwrap();
            assert!((loaded.scene.bounds().max[1] - 20.0 * metres).abs() < 1e-9 * metres.max(1.0), "{unit}");
        }
    }
}

#[test]
fn the_model_may_have_another_extension() {
    let text = model(&format!("<object id=\"1\">{}</object>", plain_mesh()), "<item objectid=\"1\"/>");
    let types = "<Types><Default Extension=\"custom\" \
                 ContentType=\"application/vnd.ms-package.3dmanufacturing-3dmodel+xml\"/></Types>";
    let relations = RELATIONS.replace("/3D/a.model", "/3D/3dmodel.custom");
    let bytes = zip(
        &[
            ("[Content_Types].xml", types.as_bytes()),
            ("_rels/.rels", relations.as_bytes()),
            ("3D/3dmodel.custom", text.as_bytes()),
        ],
        true,
    );
    assert_eq!(Format::detect(&bytes), Some(Format::ThreeMf));
    let loaded = load_with(&bytes, &Limits::default()).unwrap();
    assert_eq!((loaded.scene.instances().len(), messages(&loaded).len()), (1, 0));
}

#[test]
fn components_are_placed_within_each_other() {
    let text = model(
        &format!(
            "<object id=\"1\" type=\"support\">{}</object>\
             <object id=\"2\" type=\"other\"><components><component objectid=\"1\" \
             transform=\"2 0 0 0 2 0 0 0 2 0 0 0\"/><component objectid=\"1\"/></components></object>\
             <object id=\"9\" type=\"other\">{0}</object><object id=\"3\"><components>\
             <component objectid=\"2\" transform=\"1 0 0 0 1 0 0 0 1 1 2 3\"/><component objectid=\"9\"/>\
             </components></object>",
            plain_mesh()
        ),
        "<item objectid=\"3\"/>",
    )
    .replace("<object id=\"2\" type=\"other\">", "<object id=\"2\">");
    let loaded = load_model(&text).unwrap();
    assert_eq!(loaded.scene.meshes().len(), 1);
    assert_eq!(loaded.scene.instances().len(), 2);
    // Scaled first, then moved; the first component first.
    assert!(placed(&loaded, 0).contains(&[21.0, 3.0, -2.0]));
    assert!(placed(&loaded, 1).contains(&[11.0, 3.0, -2.0]));
    assert_eq!(messages(&loaded), ["3MF: 1 object left out: of the type 'other', which is not built"]);
}

#[test]
fn parts_refer_to_other_parts() {
    let root = format!(
        "{HEAD} requiredextensions=\"p m\"><resources><object id=\"1\"><components>\
         <component objectid=\"5\" p:path=\"/3D/Objects/o.model\"/></components></object></resources>\
         <build><item objectid=\"1\"/><item objectid=\"5\" p:path=\"/3D/Objects/o.model\"/></build></model>"
    );
    let other = model(&format!("<object id=\"5\">{}</object>", plain_mesh()), "<item objectid=\"5\"/>")
        .replace("millimeter", "centimeter");
    let parts: [(&str, &[u8]); 3] = [
        ("_rels/.rels", RELATIONS.as_bytes()),
        ("3D/a.model", root.as_bytes()),
        ("3D/Objects/o.model", other.as_bytes()),
    ];
    let loaded = load_with(&zip(&parts, true), &Limits::default()).unwrap();
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    assert_eq!((loaded.scene.meshes().len(), loaded.scene.instances().len()), (1, 2));
    // The other part has units of its own.
    assert!(placed(&loaded, 0).contains(&[0.0, 200.0, 0.0]));
    let error = load_with(&zip(&parts[..2], true), &Limits::default()).unwrap_err().to_string();
    assert_eq!(error, "3MF: part '/3D/Objects/o.model' does not exist");
}

pub(crate) fn png(texels: &[[u8; 4]], width: u32) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, texels.len() as u32 / width);
    encoder.set_color(png::ColorType::Rgba);
    encoder.write_header().unwrap().write_image_data(texels.as_flattened()).unwrap();
    bytes
}

const GROUPS: &str = "<basematerials id=\"10\" displaypropertiesid=\"30\">\
    <base name=\"Steel &amp; more\" displaycolor=\"#FF0000\"/><base name=\"glass\" displaycolor=\"#FFFFFF80\"/>\
    </basematerials><m:pbmetallicdisplayproperties id=\"30\"><m:pbmetallic name=\"a\" metallicness=\"1\" \
    roughness=\"0.25\"/><m:pbmetallic name=\"b\" metallicness=\"0\" roughness=\"0.5\"/>\
    </m:pbmetallicdisplayproperties><m:pbspeculardisplayproperties id=\"31\"><m:pbspecular name=\"c\" \
    specularcolor=\"#FFFFFF\" glossiness=\"0.75\"/></m:pbspeculardisplayproperties>\
    <m:colorgroup id=\"11\"><m:color color=\"#00FF00\"/><m:color color=\"#0000FF\"/><m:color color=\"#00FF0000\"/>\
    </m:colorgroup><m:texture2d id=\"20\" path=\"/3D/Textures/t.png\" contenttype=\"image/png\" \
    tilestyleu=\"mirror\" tilestylev=\"none\" filter=\"nearest\"/><m:texture2dgroup id=\"12\" texid=\"20\">\
    <m:tex2coord u=\"0\" v=\"0\"/><m:tex2coord u=\"1\" v=\"0.25\"/></m:texture2dgroup>\
    <m:compositematerials id=\"13\" matid=\"10\" matindices=\"0 1\" displaypropertiesid=\"31\"><m:composite values=\"3 0\"/>\
    <m:composite values=\"0.5 0.5\"/></m:compositematerials><m:multiproperties id=\"14\" pids=\"11 12\" \
    blendmethods=\"multiply\"><m:multi pindices=\"0 1\"/><m:multi pindices=\"1\"/></m:multiproperties>";

fn with_groups(object: &str, triangles: &str) -> Loaded {
    let text = model(
        &format!("{GROUPS}<object id=\"1\" {object}>{}</object>", mesh(triangles)),
        "<item objectid=\"1\"/>",
    );
    let picture = png(&[[255, 0, 0, 255], [0, 0, 255, 0]], 2);
    let parts: [(&str, &[u8]); 3] = [
        ("_rels/.rels", RELATIONS.as_bytes()),
        ("3D/a.model", text.as_bytes()),
        ("3D/Textures/t.png", &picture),
    ];
    load_with(&zip(&parts, true), &Limits::default()).unwrap()
}

#[test]
fn base_materials_have_names_colours_and_finishes() {
    let loaded = with_groups(
        "pid=\"10\" pindex=\"1\"",
        "<triangle v1=\"0\" v2=\"1\" v3=\"2\" p1=\"0\"/><triangle v1=\"0\" v2=\"3\" v3=\"1\"/>",
    );
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    let [steel, glass] = loaded.scene.materials() else { panic!() };
    assert_eq!((steel.name.as_str(), steel.base_color), ("Steel & more", [1.0, 0.0, 0.0, 1.0]));
    let metallic = Workflow::MetallicRoughness { metallic: 1.0, roughness: 0.25, texture: None };
    assert_eq!(steel.workflow, metallic);
    assert_eq!((glass.alpha_mode, glass.base_color[3]), (AlphaMode::Blend, 128.0 / 255.0));
    assert_eq!(loaded.scene.meshes().len(), 2);
    assert!(loaded.scene.meshes().iter().all(|m| m.triangles().len() == 1 && m.colors().is_empty()));
}

#[test]
fn colours_of_corners_do_not_cut_smooth_surfaces() {
    let flat = VERTICES.replace("z=\"20\"", "z=\"0\" ").replace("y=\"30\"", "y=\"-30\" ");
    let text = model(
        &format!(
            "{GROUPS}<object id=\"1\"><mesh>{flat}<triangles><triangle v1=\"0\" v2=\"1\" v3=\"3\" pid=\"11\" p1=\"0\" \
             p2=\"1\" p3=\"2\"/><triangle v1=\"0\" v2=\"3\" v3=\"1\" pid=\"11\" p1=\"1\"/></triangles></mesh></object>"
        ),
        "<item objectid=\"1\"/>",
    );
    let loaded = load_model(&text).unwrap();
    let [mesh] = loaded.scene.meshes() else { panic!() };
    let colors = |t: usize| mesh.triangles()[t].map(|v| mesh.colors()[v as usize]);
    let (green, blue) = ([0.0, 1.0, 0.0, 1.0], [0.0, 0.0, 1.0, 1.0]);
    // Alpha of a colour that is no layer does not count.
    assert_eq!((colors(0), colors(1)), ([green, blue, green], [blue; 3]));
    assert_eq!(loaded.scene.materials()[0].base_color, [1.0; 4]);
}

#[test]
fn textures_mixtures_and_layers() {
    let loaded = with_groups(
        "",
        "<triangle v1=\"0\" v2=\"1\" v3=\"2\" pid=\"12\" p1=\"0\" p2=\"1\" p3=\"1\"/>\
         <triangle v1=\"0\" v2=\"3\" v3=\"1\" pid=\"13\" p1=\"0\" p2=\"1\" p3=\"1\"/>\
         <triangle v1=\"0\" v2=\"2\" v3=\"3\" pid=\"14\" p1=\"0\" p2=\"1\" p3=\"0\"/>",
    );
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    // The texture alone and under a colour is one thing.
    let [textured, mixed] = loaded.scene.meshes() else { panic!() };
    assert_eq!((textured.triangles().len(), mixed.triangles().len()), (2, 1));
    let corners = |t: usize| {
        textured.triangles()[t].map(|v| (textured.uvs(0)[v as usize], textured.colors()[v as usize]))
    };
    assert_eq!(corners(0), [([0.0, 1.0], [1.0; 4]), ([1.0, 0.75], [1.0; 4]), ([1.0, 0.75], [1.0; 4])]);
    assert_eq!(corners(1)[..2], [([1.0, 0.75], [0.0, 1.0, 0.0, 1.0]), ([0.0, 1.0], [0.0, 0.0, 1.0, 1.0])]);
    assert_eq!(mixed.colors()[0], [1.0, 0.0, 0.0, 1.0]);
    assert_eq!(mixed.colors()[1][..3], [1.0, 0.5, 0.5]);
    let texture = &loaded.scene.textures()[0];
    assert_eq!(texture.image().texels()[0], [255, 0, 0, 255]);
    let sampler = texture.sampler();
    assert_eq!((sampler.wrap_u, sampler.wrap_v), (Wrap::MirroredRepeat, Wrap::ClampToEdge));
    assert_eq!(sampler.magnification, Filter::Nearest);
    let Workflow::SpecularGlossiness { specular, glossiness, .. } = loaded.scene.materials()[1].workflow
    else {
        panic!()
    };
    assert_eq!((specular, glossiness), ([1.0; 3], 0.75));
}

#[test]
fn what_is_missing_is_said() {
    let text = model(
        &format!(
            "<m:texture2d id=\"20\" path=\"/no.png\" contenttype=\"image/png\"/><m:texture2dgroup id=\"12\" texid=\"20\">\
             <m:tex2coord u=\"0\" v=\"0\"/></m:texture2dgroup><object id=\"1\" pid=\"77\" pindex=\"0\">{}</object>\
             <object id=\"2\" pid=\"12\" pindex=\"0\">{}</object>",
            plain_mesh(),
            plain_mesh()
                .replace("<triangles>", "<x:beamlattice/><triangles>")
                .replace("v3=\"2\"", "v3=\"2\" paint_color=\"4\"")
        ),
        "<item objectid=\"1\"/><item objectid=\"2\"/>",
    );
    let loaded = load_model(&text).unwrap();
    assert_eq!(
        messages(&loaded),
        [
            "3MF: of object 1 2 triangles have properties that do not exist",
            "3MF: of object 2 1 triangles are painted by a slicer, which is not drawn",
            "3MF: texture '/no.png' is left out: part '/no.png' does not exist",
        ]
    );
    let nothing = load_model(&model(&format!("<object id=\"1\">{}</object>", plain_mesh()), "")).unwrap();
    assert!(messages(&nothing)[0].contains("nothing is to be built: 1 object drawn where"));
    assert_eq!(nothing.scene.triangle_count(), 2);
}

#[test]
fn slicers_mark_what_is_no_object() {
    let four = "<triangle v1=\"0\" v2=\"1\" v3=\"2\"/><triangle v1=\"0\" v2=\"3\" v3=\"1\"/>\
                <triangle v1=\"0\" v2=\"2\" v3=\"3\"/><triangle v1=\"3\" v2=\"2\" v3=\"1\"/>";
    let root =
        model(&format!("<object id=\"1\">{}</object>", mesh(four)), "<item objectid=\"1\" printable=\"0\"/>");
    let config = "<?xml version=\"1.0\"?><config><object id=\"1\" instances_count=\"1\"><metadata type=\"object\" \
        key=\"extruder\" value=\"2\"/><volume firstid=\"0\" lastid=\"0\"><metadata type=\"volume\" key=\"extruder\" \
        value=\"0\"/></volume><volume firstid=\"1\" lastid=\"2\"><metadata key=\"volume_type\" \
        value=\"ParameterModifier\"/></volume><volume firstid=\"3\" lastid=\"3\"><metadata key=\"extruder\" \
        value=\"1\"/></volume></object></config>";
    let colors = "; extruder_colour = \"\";\"\"\n; filament_colour = #FF0000;#0000FF\n";
    let mut parts: Vec<(&str, &[u8])> = vec![
        ("_rels/.rels", RELATIONS.as_bytes()),
        ("3D/a.model", root.as_bytes()),
        ("Metadata/Slic3r_PE_model.config", config.as_bytes()),
        ("Metadata/Slic3r_PE.config", colors.as_bytes()),
    ];
    let loaded = load_with(&zip(&parts, true), &Limits::default()).unwrap();
    assert_eq!(loaded.scene.triangle_count(), 2);
    let names: Vec<_> = loaded.scene.materials().iter().map(|m| (m.name.as_str(), m.base_color)).collect();
    assert_eq!(names, [("filament 2", [0.0, 0.0, 1.0, 1.0]), ("filament 1", [1.0, 0.0, 0.0, 1.0])]);
    assert_eq!(
        messages(&loaded),
        ["3MF: of object 1 2 triangles left out that only change how it is printed"]
    );
    // Settings that are damaged are as if they were not there, but not in silence.
    parts[2].1 = b"<config><object id=\"1\"";
    let loaded = load_with(&zip(&parts, true), &Limits::default()).unwrap();
    assert_eq!(loaded.scene.triangle_count(), 4);
    assert!(messages(&loaded)[0].contains("settings in Metadata/Slic3r_PE_model.config are ignored"));
}

#[test]
fn paint_cuts_triangles() {
    let text = model(
        &format!(
            "<object id=\"1\">{}</object>",
            mesh(
                "<triangle v1=\"0\" v2=\"1\" v3=\"2\" paint_color=\"40483\"/><triangle v1=\"0\" v2=\"3\" v3=\"1\"/>\
                  <triangle v1=\"0\" v2=\"2\" v3=\"3\" paint_color=\"8\"/><triangle v1=\"1\" v2=\"3\" v3=\"2\" \
                  paint_color=\"1C\"/>"
            )
        ),
        "<item objectid=\"1\"/>",
    );
    let config = "<config><object id=\"1\"><metadata key=\"extruder\" value=\"2\"/></object></config>";
    let colors = "{\"filament_colour\": [\"#FF0000\", \"#00FF00\"]}";
    let parts: [(&str, &[u8]); 3] = [
        ("3D/3dmodel.model", text.as_bytes()),
        ("Metadata/model_settings.config", config.as_bytes()),
        ("Metadata/project_settings.config", colors.as_bytes()),
    ];
    let loaded = load_with(&zip(&parts, true), &Limits::default()).unwrap();
    let count = |name: &str| -> usize {
        let of =
            |k: &usize| loaded.scene.materials()[loaded.scene.instances()[*k].material.index()].name == name;
        (0..loaded.scene.instances().len())
            .filter(of)
            .map(|k| loaded.scene.meshes()[k].triangles().len())
            .sum()
    };
    // Two of the four parts of the first triangle are the first extruder's; the fourth triangle's has no colour.
    assert_eq!((count("filament 1"), count("filament 2")), (2, 5));
    assert_eq!(
        messages(&loaded),
        ["3MF: of object 1 1 triangles are painted by a slicer, which is not drawn"]
    );
    // Without colours there is nothing to paint with.
    let plain = load_with(&zip(&parts[..1], true), &Limits::default()).unwrap();
    assert_eq!(plain.scene.triangle_count(), 4);
    assert!(messages(&plain)[0].contains("3 triangles are painted"));
}

#[test]
fn bambu_studio_and_cura() {
    let root = model(
        "<object id=\"4\"><components><component objectid=\"1\" p:path=\"/3D/o.model\"/>\
         <component objectid=\"2\" p:path=\"/3D/o.model\"/></components></object>",
        "<item objectid=\"4\"/>",
    );
    let cura = "<metadatagroup><metadata name=\"cura:infill_mesh\" type=\"xs:string\">True</metadata></metadatagroup>";
    let other = model(
        &format!(
            "<object id=\"1\">{}</object><object id=\"2\">{0}</object><object id=\"3\">{cura}{0}</object>",
            plain_mesh()
        ),
        "",
    );
    let config = "<config><object id=\"4\"><metadata key=\"extruder\" value=\"1\"/><part id=\"1\" \
        subtype=\"normal_part\"><metadata key=\"extruder\" value=\"2\"/></part><part id=\"2\" \
        subtype=\"support_blocker\"/></object></config>";
    let colors = "{\"filament_colour\": [\"#FF0000\", \"#00FF00\"]}";
    let parts: [(&str, &[u8]); 5] = [
        ("_rels/.rels", RELATIONS.as_bytes()),
        ("3D/a.model", root.as_bytes()),
        ("3D/o.model", other.as_bytes()),
        ("Metadata/model_settings.config", config.as_bytes()),
        ("Metadata/project_settings.config", colors.as_bytes()),
    ];
    let loaded = load_with(&zip(&parts, true), &Limits::default()).unwrap();
    assert_eq!(messages(&loaded), ["3MF: 1 object left out: marks of a slicer for supports"]);
    assert_eq!(loaded.scene.materials()[0].base_color, [0.0, 1.0, 0.0, 1.0]);
    let only = zip(
        &[("3D/3dmodel.model", other.replace("<build>", "<build><item objectid=\"3\"/>").as_bytes())],
        true,
    );
    let loaded = load_with(&only, &Limits::default()).unwrap();
    assert!(messages(&loaded)[0].contains("they only change how others are printed"));
}

/// Cura before version 4 has settings in the object, with a namespace of their own.
#[test]
fn cura_before_version_4() {
    let space = "http://software.ultimaker.com/xml/cura/3mf/2015/10";
    for (key, value, drawn) in [
        ("infill_mesh", "True", 1),
        ("anti_overhang_mesh", "true", 1),
        ("cutting_mesh", " True ", 1),
        ("support_mesh", "True", 1),
        ("infill_mesh", "False", 2),
        ("infill_sparse_density", "True", 2),
    ] {
        for (prefix, declared) in [("", "xmlns"), ("cura:", "xmlns:cura")] {
            let settings = format!(
                "<{prefix}settings {declared}=\"{space}\"><{prefix}setting key=\"extruder_nr\">1</{prefix}setting>\
                 <{prefix}setting key=\"{key}\">{value}</{prefix}setting></{prefix}settings>"
            );
            let text = model(
                &format!("<object id=\"1\">{settings}{}</object><object id=\"2\">{0}</object>", plain_mesh()),
                "<item objectid=\"1\"/><item objectid=\"2\"/>",
            );
            let loaded = load_model(&text).unwrap();
            assert_eq!(loaded.scene.instances().len(), drawn, "{key} {value}");
            assert_eq!(messages(&loaded).len(), 2 - drawn, "{:?}", loaded.warnings);
        }
    }
}

#[test]
fn names_of_parts_are_compared_as_packages_have_it() {
    let object = format!("<object id=\"1\">{}</object>", plain_mesh());
    let other = model(&object, "");
    for (referred, stored) in [
        ("/3D/Objects/Teil%20A.model", "3D/Objects/Teil A.model"),
        ("/3D/Objects/Teil A.model", "3D/Objects/Teil%20A.model"),
        ("/3D/W%C3%BCrfel.model", "3D/Würfel.model"),
        ("/3D/Würfel.model", "3D/W%c3%bcrfel.model"),
        ("/3D/Würfel.model", "3d/WüRFEL.MODEL"),
        ("/3D/./Objects/../o.model", "3D/o.model"),
        ("/3D/100%.model", "3D/100%25.model"),
    ] {
        // The second reference is to the same part, which is read once.
        let root = model(
            "",
            &format!(
                "<item objectid=\"1\" p:path=\"{referred}\"/><item objectid=\"1\" p:path=\"{}\"/>",
                referred.to_ascii_uppercase()
            ),
        );
        let parts = [
            ("_rels/.rels", RELATIONS.as_bytes()),
            ("3D/a.model", root.as_bytes()),
            (stored, other.as_bytes()),
        ];
        let loaded = load_with(&zip(&parts, true), &Limits::default()).unwrap();
        assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
        assert_eq!((loaded.scene.meshes().len(), loaded.scene.instances().len()), (1, 2), "{referred}");
    }
    // The start of the model, from the root of the package.
    let start = RELATIONS.replace("/3D/a.model", "3D/a%20b.model");
    let text = model(&object, "<item objectid=\"1\"/>");
    let parts = [("_rels/.rels", start.as_bytes()), ("3D/A b.model", text.as_bytes())];
    assert_eq!(load_with(&zip(&parts, true), &Limits::default()).unwrap().scene.instances().len(), 1);
}

#[test]
fn damage_is_named_with_its_element() {
    let object = format!("<object id=\"1\">{}</object>", plain_mesh());
    let item = "<item objectid=\"1\"/>";
    let nested = |inner: &str| format!("<object id=\"1\"><components>{inner}</components></object>");
    for (text, message) in [
        (model(&nested("<component objectid=\"1\"/>"), item), "object 1 (or does it contain itself?)"),
        (model(&nested("<component objectid=\"1\"/><component objectid=\"1\"/>"), item), "contain itself"),
        (model(&object, item).replace("</build>", ""), "line 2: "),
        (format!("<!DOCTYPE x>{}", &model(&object, item)[39..]), "document type definitions"),
        ("<html/>".to_owned(), "'html' is not a model"),
    ] {
        let error = load_model(&text).unwrap_err().to_string();
        assert!(error.contains(message) && error.starts_with("3MF: "), "{message}: {error}");
    }
    // Intact parts are drawn.
    for (text, triangles, message) in [
        (
            model(&object, &format!("<item objectid=\"7\"/>{item}")),
            2,
            "object 7 is referred to and does not exist",
        ),
        (model(&object, &format!("<item/>{item}")), 2, "'item' has no objectid and is left out"),
        (model(&object, "<item objectid=\"1\" transform=\"1 0 0\"/>"), 2, "the transform '1 0 0' is not one"),
        (model(&object.repeat(2), item), 2, "there are two objects 1: the first is drawn"),
        (model(&object.replace("v3=\"2\"", "v3=\"4\""), item), 1, "1 triangle of object 1 left out"),
        (model(&object.replace("y=\"30\"", "y=\"nan\""), item), 1, "1 triangle of object 1 left out"),
        (model(&object.replace("y=\"30\"", ""), item), 1, "1 triangle of object 1 left out"),
        (
            model(&object, item).replace("millimeter", "league"),
            2,
            "the unit 'league' is unknown: taken as millimetres",
        ),
        (model(&object, ""), 2, "nothing is to be built: 1 object drawn where they are defined"),
        (
            model(&object.replace("id=\"1\"", "id=\"1\" type=\"other\""), item),
            2,
            "nothing is to be built: 1 object",
        ),
        (
            model(&object, item).replace("<model ", "<model requiredextensions=\"x\" "),
            2,
            "requires the extension 'http://example.org/unknown', which is not drawn",
        ),
        (model(&object, item).replace("<model ", "<model requiredextensions=\"q\" "), 2, "the extension 'q'"),
        (
            model(&object, item).replace("<model ", "<model requiredextensions=\"s\" "),
            2,
            "slices are not drawn: the meshes are",
        ),
    ] {
        let loaded = load_model(&text).unwrap();
        assert_eq!(loaded.scene.triangle_count(), triangles, "{message}");
        let found = messages(&loaded);
        assert!(found.len() == 1 && found[0].contains(message), "{message}: {found:?}");
    }
}

/// Two bars, one of which is nowhere.
#[test]
fn beams_are_prisms() {
    let beams = "<beamlattice radius=\"1\" minlength=\"0.1\"><beams><beam v1=\"0\" v2=\"1\"/>\
        <beam v1=\"0\" v2=\"9\" r1=\"2\"/></beams></beamlattice></mesh>";
    let object = format!("<object id=\"1\">{}</object>", mesh("").replace("</mesh>", beams));
    let loaded = load_model(&model(&object, "<item objectid=\"1\"/>")).unwrap();
    assert_eq!(loaded.scene.triangle_count(), 20);
    assert_eq!(
        messages(&loaded),
        [
            "3MF: 2 beams of object 1 drawn as prisms, without balls",
            "3MF: 1 beam of object 1 left out: no length or no radius",
        ]
    );
}

#[test]
fn something_may_stand_before_the_archive() {
    let good =
        package(&model(&format!("<object id=\"1\">{}</object>", plain_mesh()), "<item objectid=\"1\"/>"));
    let bytes = [b"#!/bin/unpack\n".as_slice(), &good].concat();
    assert_eq!(load_with(&bytes, &Limits::default()).unwrap().scene.triangle_count(), 2);
}

#[test]
fn archives_that_lie_cost_nothing() {
    let good =
        package(&model(&format!("<object id=\"1\">{}</object>", plain_mesh()), "<item objectid=\"1\"/>"));
    load_with(&good, &Limits::default()).unwrap();
    let error = |bytes: &[u8]| load_with(bytes, &Limits::default()).unwrap_err().to_string();
    let entry = good.windows(4).rposition(|w| w == b"PK\x01\x02").unwrap();
    let with = |at: usize, value: &[u8]| {
        let mut bytes = good.clone();
        bytes[at..at + value.len()].copy_from_slice(value);
        error(&bytes)
    };
    assert!(
        with(entry + 24, &[255, 255, 255, 127]).contains("claims to inflate"),
        "{}",
        with(entry + 24, &[255; 3])
    );
    assert!(with(entry + 24, &[1, 0, 0, 0]).contains("cannot be inflated"));
    assert!(with(entry + 16, &[1, 2, 3, 4]).contains("checksum does not fit"));
    assert!(with(entry + 8, &[1, 0]).contains("is encrypted"));
    assert!(with(entry + 10, &[12, 0]).contains("compressed by method 12"));
    assert!(with(entry + 42, &[255, 255, 255, 0]).contains("beyond the end"));
    assert!(
        with(good.len() - 12, &[255, 255]).contains("the archive's directory ends after 2 of 65535 parts")
    );
    assert!(with(good.len() - 6, &[255, 255, 255, 0]).contains("the archive's directory is beyond its end"));
    assert!(error(&good[..good.len() - 30]).contains("no directory"));
    assert!(error(&zip(&[("a.txt", b"x")], true)).contains("no 3D model in it"));
    // A bomb inflates to what it admits to, if that is granted.
    let bomb = package(&format!("{}{}", " ".repeat(1 << 20), model("", "")));
    let limits = Limits::default().with_decoded_bytes(1 << 20);
    assert!(matches!(load_with(&bomb, &limits), Err(LoadError::Limit(_))));
    let bomb = package(&" ".repeat(17 << 20));
    assert!(error(&bomb).contains("claims to inflate"));
}

#[test]
fn limits_hold() {
    let object = format!("<object id=\"1\">{}</object>", plain_mesh());
    let text = model(&object, &"<item objectid=\"1\"/>".repeat(3));
    let field = |limits: &Limits| match load_with(&package(&text), limits) {
        Err(LoadError::Limit(limit)) => limit.field,
        other => panic!("{other:?}"),
    };
    assert_eq!(field(&Limits::default().with_triangles(5)), "triangles");
    assert_eq!(field(&Limits::default().with_vertices(3)), "vertices");
    assert_eq!(field(&Limits::default().with_nodes(3)), "nodes");
    assert_eq!(field(&Limits::default().with_input_bytes(100)), "input_bytes");
    // A tree of components without any mesh is work too: 2^30 of them.
    let mut objects = "<object id=\"1\"/>".to_owned();
    for k in 2..32 {
        let of = format!("<component objectid=\"{}\"/>", k - 1);
        objects += &format!("<object id=\"{k}\"><components>{of}{of}</components></object>");
    }
    let error = load_model(&model(&objects, "<item objectid=\"31\"/>")).unwrap_err().to_string();
    assert!(error.contains("the number of placed objects"), "{error}");
}

/// Projects of Bambu Studio have plates, a printer's width apart.
#[test]
fn plates_of_a_project_are_side_by_side() {
    let item = |object: u32, x: f64, y: f64| {
        format!("<item objectid=\"{object}\" transform=\"1 0 0 0 1 0 0 0 1 {x} {y} 0\"/>")
    };
    let text = model(
        &format!("<object id=\"1\">{}</object><object id=\"2\">{0}</object>", plain_mesh()),
        &[item(1, 100.0, 90.0), item(1, 407.2, 95.0), item(2, 80.0, -217.2), item(2, 120.0, -217.2)].concat(),
    );
    let entry = |object: u32, instance: u32| {
        format!(
            "<model_instance><metadata key=\"object_id\" value=\"{object}\"/>\
             <metadata key=\"instance_id\" value=\"{instance}\"/></model_instance>"
        )
    };
    let plate = |number: u32, items: &[String]| {
        format!("<plate><metadata key=\"plater_id\" value=\"{number}\"/>{}</plate>", items.concat())
    };
    let three = [
        plate(2, &[entry(1, 1)]),
        plate(1, &[entry(1, 0)]),
        plate(3, &[entry(2, 0), entry(2, 1)]),
        plate(4, &[]),
    ];
    let places = |plates: &[String]| -> Vec<[f64; 3]> {
        let config = format!("<config>{}</config>", plates.concat());
        let parts =
            [("3D/3dmodel.model", text.as_bytes()), ("Metadata/model_settings.config", config.as_bytes())];
        let loaded = load_with(&zip(&parts, true), &Limits::default()).unwrap();
        assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
        let millimetres = |row: &[f64; 4]| 1000.0 * row[3];
        let instances = loaded.scene.instances().iter();
        // In the file's frame: Z is up.
        let place = |rows: &[[f64; 4]; 3]| {
            let [x, y, z] = [0, 1, 2].map(|k| millimetres(&rows[k]));
            [x, -z, y]
        };
        instances.map(|instance| place(instance.transform.rows())).collect()
    };
    let near = |a: [f64; 3], b: [f64; 3]| (0..3).all(|k| (a[k] - b[k]).abs() < 1e-6);
    let found = places(&three);
    // The third plate is 50 mm wide; plates are 5 mm apart, and the second row begins behind the first.
    let expected = [[100.0, 90.0, 0.0], [115.0, 90.0, 0.0], [100.0, 55.0, 0.0], [140.0, 55.0, 0.0]];
    for (found, expected) in found.iter().zip(expected) {
        assert!(near(*found, expected), "{found:?} {expected:?}");
    }
    // A single plate stays as it is, and so does a file that says nothing.
    let one = plate(1, &[entry(1, 0), entry(1, 1), entry(2, 0), entry(2, 1)]);
    for plates in [&[one][..], &[]] {
        assert!(near(places(plates)[3], [120.0, -217.2, 0.0]), "{plates:?}");
    }
    // Items on no plate form a group of their own.
    let found = places(&three[..2]);
    assert!(near(found[0], [100.0, 90.0, 0.0]) && found[2][1] > 0.0, "{found:?}");
}
