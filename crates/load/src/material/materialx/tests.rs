//! Documents of every shader, damaged ones, and those that were written here.

use super::super::{MaterialError, MaterialFile};
use crate::{Context, MemoryResolver, Resolver, Warning};
use overcoat_core::jobs::Jobs;
use overcoat_core::limits::Limits;
use overcoat_scene::parameters::{METALLIC, ROUGHNESS};
use overcoat_scene::{Material, Scene};

/// A picture of one texel.
fn png() -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, 1, 1);
    encoder.set_color(png::ColorType::Rgba);
    encoder.write_header().unwrap().write_image_data(&[200, 100, 50, 128]).unwrap();
    bytes
}

fn open(text: &str) -> Result<MaterialFile, MaterialError> {
    open_beside(text, &[])
}

/// Reads a document that lies beside these other texts.
fn open_beside(text: &str, beside: &[(&str, String)]) -> Result<MaterialFile, MaterialError> {
    let mut files = MemoryResolver::default();
    for name in ["a.png", "b.png", "maps/c.png"] {
        files.files.insert(name.to_owned(), png());
    }
    for (name, text) in beside {
        files.files.insert((*name).to_owned(), text.clone().into_bytes());
    }
    let resolver: &dyn Resolver = &files;
    let context = Context { resolver, limits: &Limits::default(), jobs: &Jobs::new(1) };
    MaterialFile::from_bytes(text.as_bytes(), &context)
}

/// A document with one material whose shader has these inputs.
fn document(shader: &str, inputs: &str, nodes: &str) -> String {
    format!(
        "<?xml version=\"1.0\"?>\n<!-- a paint -->\n<materialx version=\"1.39\" colorspace=\"lin_rec709\">{nodes}\
         <{shader} name=\"S\" type=\"surfaceshader\">{inputs}</{shader}><surfacematerial name=\"M\" type=\"material\">\
         <input name=\"surfaceshader\" type=\"surfaceshader\" nodename=\"S\"/></surfacematerial></materialx>"
    )
}

fn input(name: &str, value: &str) -> String {
    format!("<input name=\"{name}\" type=\"float\" value=\"{value}\"/>")
}

fn connected(name: &str, rest: &str) -> String {
    format!("<input name=\"{name}\" type=\"color3\" {rest}/>")
}

/// The material that a file makes, and its warnings.
fn material(file: &MaterialFile) -> (Material, Vec<String>) {
    let mut scene = Scene::default();
    let id = scene.add_material(Material::default()).unwrap();
    file.assign(&mut scene, None, &Limits::default()).unwrap();
    (scene.materials()[id.index()].clone(), file.warnings().map(|w: Warning| w.to_string()).collect())
}

fn roughness(material: &Material) -> f32 {
    ROUGHNESS.numbers(material)[0]
}

fn metallic(material: &Material) -> f32 {
    METALLIC.numbers(material)[0]
}

fn read(text: &str) -> (Material, Vec<String>) {
    material(&open(text).unwrap_or_else(|error| panic!("{error}\n{text}")))
}

#[test]
fn inputs_of_each_shader_are_those_of_the_material() {
    let coat = input("coat_weight", "0.5") + &input("coat_ior", "1.7") + &input("specular_roughness", "0.25");
    let (paint, warnings) =
        read(&document("open_pbr_surface", &(coat + &input("base_color", "0.5, 0.25, 1")), ""));
    assert_eq!((paint.coat, paint.lobes.coat.ior, roughness(&paint)), (0.5, 1.7, 0.25));
    assert_eq!(paint.base_color, [0.5, 0.25, 1.0, 1.0]);
    assert_eq!(paint.model.map(|model| model.name()), Some("openpbr"));
    assert!(warnings.is_empty(), "{warnings:?}");

    // The defaults of the shader, and not those of a material file.
    let (plain, _) = read(&document("open_pbr_surface", "", ""));
    assert_eq!((plain.base_color, roughness(&plain)), ([0.8, 0.8, 0.8, 1.0], 0.3));

    let rows = input("base", "0.5") + &input("base_color", "1, 0.5, 0") + &input("metalness", "1");
    let (metal, _) = read(&document("standard_surface", &(rows + &input("specular_rotation", "0.25")), ""));
    assert_eq!((metal.base_color, roughness(&metal)), ([0.5, 0.25, 0.0, 1.0], 0.2));
    assert_eq!(metal.lobes.anisotropy.rotation, 90_f32.to_radians());
    let (lacquer, _) = read(&document("standard_surface", &input("coat", "1"), ""));
    assert_eq!((lacquer.lobes.coat.darkening, lacquer.coat_roughness), (0.0, 0.1));

    let rows = input("alpha", "0.5") + &input("alpha_mode", "1") + &input("alpha_cutoff", "0.25");
    let (cut, _) = read(&document("gltf_pbr", &rows, ""));
    assert_eq!(cut.alpha_mode, overcoat_scene::AlphaMode::Mask { cutoff: 0.25 });

    let (glass, _) = read(&document("UsdPreviewSurface", &input("opacity", "0.25"), ""));
    assert_eq!((glass.lobes.transmission.factor.factor, glass.base_color[3]), (0.75, 1.0));
}

#[test]
fn arithmetic_of_constants_and_pictures_reduces() {
    let nodes = "<nodegraph name=\"N\" fileprefix=\"maps/\">\
         <input name=\"tint\" type=\"color3\" value=\"0.5, 1, 1\"/>\
         <texcoord name=\"uv\" type=\"vector2\"/>\
         <multiply name=\"tiles\" type=\"vector2\"><input name=\"in1\" nodename=\"uv\"/><input name=\"in2\" value=\"2, 4\"/></multiply>\
         <image name=\"i\" type=\"color3\"><input name=\"file\" type=\"filename\" value=\"c.png\" colorspace=\"srgb_texture\"/>\
         <input name=\"texcoord\" nodename=\"tiles\"/></image>\
         <multiply name=\"m\" type=\"color3\"><input name=\"in1\" nodename=\"i\"/><input name=\"in2\" interfacename=\"tint\"/></multiply>\
         <separate3 name=\"s\" type=\"multioutput\"><input name=\"in\" nodename=\"i\"/></separate3>\
         <normalmap name=\"n\" type=\"vector3\"><input name=\"in\" nodename=\"i\"/><input name=\"scale\" value=\"0.5\"/></normalmap>\
         <output name=\"color\" nodename=\"m\"/><output name=\"g\" nodename=\"s\" output=\"outg\"/><output name=\"normal\" nodename=\"n\"/>\
         </nodegraph>";
    let rows = connected("base_color", "nodegraph=\"N\" output=\"color\"")
        + &connected("specular_roughness", "nodegraph=\"N\" output=\"g\"")
        + &connected("geometry_normal", "nodegraph=\"N\" output=\"normal\"")
        + "<input name=\"coat_weight\" type=\"float\" nodename=\"sum\"/>";
    let sum = "<add name=\"sum\" type=\"float\"><input name=\"in1\" value=\"0.25\"/><input name=\"in2\" value=\"0.5\"/></add>";
    let file = open(&document("open_pbr_surface", &rows, &format!("{nodes}{sum}"))).unwrap();
    let (paint, warnings) = material(&file);
    assert!(warnings.is_empty(), "{warnings:?}");
    assert_eq!((paint.base_color, paint.coat), ([0.5, 1.0, 1.0, 1.0], 0.75));
    let texture = paint.base_color_texture.unwrap();
    assert_eq!(texture.transform.rows[0][0], 2.0);
    assert_eq!(texture.transform.rows[1][1], 4.0);
    assert_eq!(paint.normal_texture.unwrap().scale, 0.5);
    assert!(
        file.text().contains("roughness_texture = { channel = \"g\", file = \"maps/c.png\""),
        "{}",
        file.text()
    );
}

#[test]
fn parts_without_effect_are_named() {
    let noise = "<noise2d name=\"n\" type=\"float\"/><image name=\"o\" type=\"float\"><input name=\"file\" value=\"../x.png\"/></image>";
    let rows = connected("specular_roughness", "nodename=\"n\"")
        + &connected("coat_weight", "nodename=\"o\"")
        + &input("base_diffuse_roughness", "0.5")
        + &input("emission_luminance", "5000");
    let (paint, warnings) = read(&document("open_pbr_surface", &rows, noise));
    assert_eq!((roughness(&paint), paint.coat, paint.emissive), (0.3, 0.0, [1e3; 3]));
    let said = |what: &str| warnings.iter().filter(|warning| warning.contains(what)).count();
    for what in [
        "specular_roughness: the node noise2d",
        "coat_weight: the texture ../x.png",
        "base_diffuse_roughness: has no",
        "held at 1000",
    ] {
        assert_eq!(said(what), 1, "{what}: {warnings:?}");
    }
}

#[test]
fn damage_is_one_line_and_circles_end() {
    let circle = "<add name=\"a\" type=\"float\"><input name=\"in1\" nodename=\"b\"/><input name=\"in2\" nodename=\"b\"/></add>\
                  <add name=\"b\" type=\"float\"><input name=\"in1\" nodename=\"a\"/><input name=\"in2\" nodename=\"a\"/></add>";
    let (_, warnings) =
        read(&document("open_pbr_surface", &connected("coat_weight", "nodename=\"a\""), circle));
    assert!(warnings[0].contains("circle"), "{warnings:?}");
    let whole = document("disney_brdf", "", "");
    for (text, message) in [
        (whole.as_str(), "the surface shader disney_brdf is not read; those that are: open_pbr_surface"),
        ("<materialx/>", "there is no surface shader"),
        ("<svg/>", "the outermost element is not materialx"),
        (&whole[..whole.len() - 12], "ends within an element"),
        ("<!DOCTYPE a [<!ENTITY b \"c\">]><materialx/>", "document type definitions are not allowed"),
    ] {
        let error = open(text).unwrap_err().to_string();
        assert!(error.contains(message) && error.lines().count() == 1, "{error}");
    }
    for cut in 0..whole.len() {
        let _ = open(whole.get(..cut).unwrap_or_default());
    }
}

#[test]
fn a_document_that_is_written_reads_as_the_same_material() {
    let toml = "model = \"openpbr\"\nbase_color = [0.5, 0.25, 0.125, 0.75]\nalpha_mode = \"blend\"\nroughness = 0.5\n\
                base_color_texture = { file = \"a.png\", scale = [2.0, 3.0], offset = [0.25, 0.5], rotation = 20, wrap = \"mirror\" }\n\
                metallic = 0.5\nmetallic_roughness_texture = { file = \"b.png\", uv_set = 1, filter = \"nearest\" }\n\
                normal_texture = \"maps/c.png\"\nnormal_scale = 0.5\ncoat = 0.75\ncoat_color = [1.0, 0.5, 0.25]\n\
                coat_roughness = 0.125\ncoat_texture = { file = \"b.png\", channel = \"b\" }\nemissive = [0.5, 0.25, 0.0]\n\
                emissive_strength = 8.0\ncoat_ior = 1.75\ncoat_anisotropy = 0.5\nanisotropy = 0.25\n";
    let (written, warnings) = open(toml).unwrap().to_materialx();
    assert!(warnings.is_empty(), "{warnings:?}");
    let file = open(&written).unwrap_or_else(|error| panic!("{error}\n{written}"));
    let ((before, _), (after, warnings)) = (material(&open(toml).unwrap()), material(&file));
    assert!(warnings.is_empty(), "{warnings:?}\n{written}");
    let plain = |m: &Material| {
        let mut m = m.clone();
        (m.base_color_texture, m.coat_texture, m.normal_texture) = (None, None, None);
        m.workflow =
            overcoat_scene::Workflow::MetallicRoughness { metallic: 0.0, roughness: 0.0, texture: None };
        m
    };
    assert_eq!(plain(&before), plain(&after), "{written}");
    assert_eq!((metallic(&before), roughness(&before)), (metallic(&after), roughness(&after)));
    let [before, after] = [before, after].map(|m| m.base_color_texture.unwrap().transform.rows);
    let far = before.as_flattened().iter().zip(after.as_flattened()).map(|(a, b)| (a - b).abs());
    assert!(far.clone().fold(0.0, f32::max) < 1e-5, "{before:?} {after:?}\n{written}");

    let (_, warnings) = open("flakes = 0.5\nmodel = \"three\"\n").unwrap().to_materialx();
    let warnings: Vec<String> = warnings.iter().map(ToString::to_string).collect();
    assert!(warnings[0].contains("flakes has no place") && warnings[1].contains("three"), "{warnings:?}");
}

/// A material of this name and coat, with its shader.
fn coated(name: &str, coat: f32) -> String {
    format!(
        "<open_pbr_surface name=\"S_{name}\" type=\"surfaceshader\">{}</open_pbr_surface>\
         <surfacematerial name=\"{name}\" type=\"material\">\
         <input name=\"surfaceshader\" type=\"surfaceshader\" nodename=\"S_{name}\"/></surfacematerial>",
        input("coat_weight", &coat.to_string())
    )
}

fn whole(elements: &str) -> String {
    format!("<materialx version=\"1.39\">{elements}</materialx>")
}

/// Coats of materials of these names after a file has been laid over them, or over those of one name.
fn coats(file: &MaterialFile, names: &[&str], name: Option<&str>) -> Vec<f32> {
    let mut scene = Scene::default();
    for name in names {
        scene.add_material(Material::default().with(|m| m.name = (*name).to_owned())).unwrap();
    }
    file.assign(&mut scene, name, &Limits::default()).unwrap();
    scene.materials().iter().map(|material| material.coat).collect()
}

#[test]
fn materials_of_a_document_go_by_name() {
    let strange = "<disney_brdf name=\"D\" type=\"surfaceshader\"/><surfacematerial name=\"odd\" type=\"material\">\
                   <input name=\"surfaceshader\" type=\"surfaceshader\" nodename=\"D\"/></surfacematerial>";
    let rows = [coated("body", 0.25), coated("car_paint", 0.5), strange.to_owned(), coated("body", 0.75)];
    let file = open(&whole(&rows.concat())).unwrap();
    // Materials with none of the names stay; names of MaterialX have no spaces.
    assert_eq!(coats(&file, &["glass", "body", "car paint", "body"], None), [0.0, 0.25, 0.5, 0.25]);
    assert_eq!(coats(&file, &["glass", "tyre"], None), [0.25, 0.25]);
    assert_eq!(coats(&file, &["glass", "car_paint"], Some("car_paint")), [0.0, 0.5]);
    assert_eq!(coats(&file, &["glass", "car_paint"], Some("glass")), [0.25, 0.0]);
    let warnings: Vec<String> = file.warnings().map(|w| w.to_string()).collect();
    assert!(warnings[0].contains("the materials body, car_paint: each is drawn"), "{warnings:?}");
    assert!(warnings[1].contains("not read: odd, body") && warnings.len() == 2, "{warnings:?}");
    assert!(file.text().contains("coat = 0.25"), "{}", file.text());
    // One material is laid over everything, whatever its name.
    assert_eq!(coats(&open(&whole(&coated("body", 0.5))).unwrap(), &["glass", "body"], None), [0.5, 0.5]);
}

#[test]
fn documents_include_others_of_their_folder() {
    let include = |href: &str| format!("<xi:include href=\"{href}\"/>");
    let image = "<image name=\"i\" type=\"color3\"><input name=\"file\" value=\"c.png\"/></image>";
    let inner = connected("base_color", "nodename=\"i\"");
    let beside = [
        (
            "parts/body.mtlx",
            whole(&(include("deeper/../image.mtlx") + &include("../main.mtlx") + &coated("body", 0.5))),
        ),
        ("maps/image.mtlx", whole(image)),
        ("parts/image.mtlx", whole(&include("../maps/image.mtlx"))),
        ("main.mtlx", whole(&include("parts/body.mtlx"))),
        ("broken.mtlx", "<materialx><a>".to_owned()),
    ];
    let read = |elements: &str| {
        let file = open_beside(&whole(elements), &beside).unwrap();
        (file.text().to_owned(), file.warnings().map(|w| w.to_string()).collect::<Vec<_>>())
    };
    let (text, warnings) = read(&include("parts/body.mtlx"));
    assert!(text.contains("coat = 0.5") && warnings.is_empty(), "{text} {warnings:?}");
    // The document's own come first, and pictures are named from the folder of the file that names them.
    let own = format!("<open_pbr_surface name=\"S\" type=\"surfaceshader\">{inner}</open_pbr_surface>");
    let (text, warnings) = read(&(include("maps/image.mtlx") + &own));
    assert!(text.contains("file = \"maps/c.png\"") && warnings.is_empty(), "{text} {warnings:?}");
    for (href, why) in [
        ("none.mtlx", "none.mtlx is left out"),
        ("../main.mtlx", "not in the document's folder"),
        ("parts/../../main.mtlx", "not in the document's folder"),
        ("/etc/passwd", "not in the document's folder"),
        ("file:///etc/passwd", "not in the document's folder"),
        ("c:\\main.mtlx", "not in the document's folder"),
        ("broken.mtlx", "broken.mtlx is left out"),
        ("a.png", "a.png is left out"),
    ] {
        let (_, warnings) = read(&(include(href) + &own));
        assert!(warnings[0].contains(why), "{href}: {warnings:?}");
    }
    // As many files as may be, and not as deep as they go.
    let chain: Vec<(String, String)> =
        (0..9).map(|k| (format!("{k}.mtlx"), whole(&include(&format!("{}.mtlx", k + 1))))).collect();
    let chain: Vec<(&str, String)> = chain.iter().map(|(name, text)| (name.as_str(), text.clone())).collect();
    let file = open_beside(&whole(&(include("0.mtlx") + &own)), &chain).unwrap();
    assert!(file.warnings().any(|w| w.to_string().contains("4.mtlx is left out: no more than")));
}
