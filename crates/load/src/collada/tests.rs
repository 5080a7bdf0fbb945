//! Documents that are written here, and read again.

use crate::hostile::{attack, limits, load, load_beside, warnings};
use crate::{Format, LoadError, Loaded, MemoryResolver};
use overcoat_core::color::srgb::srgb_to_linear;
use overcoat_scene::{AlphaMode, Axis, PrimitiveKind, Workflow};

/// Positions, normals and texture coordinates of a square, and a primitive.
fn geometry(primitive: &str) -> String {
    format!(
        "<library_geometries><geometry id='g' name='square'><mesh>\
         <source id='p'><float_array id='pa' count='12'>0 0 0 2 0 0 2 2 0\n0 2 0</float_array><technique_common>\
         <accessor source='#pa' count='4' stride='3'/></technique_common></source>\
         <source id='n'><float_array id='na' count='3'>0 0 1</float_array><technique_common>\
         <accessor source='#na' count='1' stride='3'/></technique_common></source>\
         <source id='t'><float_array id='ta' count='8'>0 0 1 0 1 1 0 1</float_array><technique_common>\
         <accessor source='#ta' count='4' stride='2'/></technique_common></source>\
         <vertices id='v'><input semantic='POSITION' source='#p'/></vertices>{primitive}</mesh></geometry>\
         </library_geometries>"
    )
}

const INPUTS: &str = "<input semantic='VERTEX' source='#v' offset='0'/><input semantic='NORMAL' source='#n' \
                      offset='1'/><input semantic='TEXCOORD' source='#t' offset='2' set='0'/>";

fn polylist() -> String {
    format!(
        "<polylist material='m' count='1'>{INPUTS}<vcount>4</vcount><p>0 0 0 1 0 1 2 0 2 3 0 3</p></polylist>"
    )
}

/// A material with a technique.
fn material(technique: &str) -> String {
    format!(
        "<library_images><image id='i'><init_from>file:///C:/maps/my%20t.png</init_from></image></library_images>\
         <library_effects><effect id='e'><profile_COMMON>\
         <newparam sid='su'><surface type='2D'><init_from>i</init_from></surface></newparam>\
         <newparam sid='sa'><sampler2D><source>su</source></sampler2D></newparam>\
         <technique sid='c'>{technique}</technique></profile_COMMON></effect></library_effects>\
         <library_materials><material id='red'><instance_effect url='#e'/></material></library_materials>"
    )
}

const INSTANCE: &str = "<instance_geometry url='#g'><bind_material><technique_common>\
                        <instance_material symbol='m' target='#red'/></technique_common></bind_material>\
                        </instance_geometry>";

fn document(asset: &str, libraries: &str, nodes: &str) -> String {
    format!(
        "<?xml version='1.0'?>\n<COLLADA xmlns='http://www.collada.org/2005/11/COLLADASchema' version='1.4.1'>\
         <asset>{asset}</asset>{libraries}<library_visual_scenes><visual_scene id='s'>{nodes}</visual_scene>\
         </library_visual_scenes><scene><instance_visual_scene url='#s'/></scene></COLLADA>\n"
    )
}

fn read(text: &str) -> Loaded {
    load(text.as_bytes(), Format::Collada).unwrap()
}

const LAMBERT: &str = "<lambert><diffuse><color>0.5 0 0 1</color></diffuse></lambert>";

fn plain() -> String {
    let nodes = format!("<node id='a'>{INSTANCE}</node>");
    document("", &[geometry(&polylist()), material(LAMBERT)].concat(), &nodes)
}

#[test]
fn a_square_is_two_triangles_with_a_material() {
    let text = plain();
    assert_eq!(Format::detect(text.as_bytes()), Some(Format::Collada));
    let loaded = read(&text);
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    let (scene, mesh) = (&loaded.scene, &loaded.scene.meshes()[0]);
    assert_eq!(mesh.positions(), [[0.0; 3], [2.0, 0.0, 0.0], [2.0, 2.0, 0.0], [0.0, 2.0, 0.0]]);
    assert_eq!(mesh.triangles(), [[0, 1, 2], [0, 2, 3]]);
    assert_eq!(mesh.normals(), [[0.0, 0.0, 1.0]; 4]);
    assert_eq!(mesh.uvs(0), [[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]]);
    assert_eq!(scene.materials()[0].base_color, [srgb_to_linear(0.5), 0.0, 0.0, 1.0]);
    assert_eq!(scene.orientation().up, Axis::PositiveY);
    attack(text.as_bytes(), Format::Collada);
}

#[test]
fn primitives_of_every_kind() {
    let square = [[0, 1, 2], [0, 2, 3]];
    for (primitive, triangles, kind) in [
        ("<triangles material='m'>I<p>0 0 0 1 0 1 2 0 2 0 0 0 2 0 2 3 0 3</p></triangles>", &square[..], 0),
        ("<polygons material='m'>I<p>0 0 0 1 0 1 2 0 2 3 0 3</p></polygons>", &square, 0),
        ("<trifans material='m'>I<p>0 0 0 1 0 1 2 0 2 3 0 3</p></trifans>", &square, 0),
        ("<tristrips material='m'>I<p>0 0 0 1 0 1 3 0 3 2 0 2</p></tristrips>", &[[0, 1, 2], [2, 1, 3]], 0),
        ("<lines material='m'>I<p>0 0 0 1 0 1</p></lines>", &[[0, 1, 1]], 1),
        ("<linestrips material='m'>I<p>0 0 0 1 0 1 2 0 2</p></linestrips>", &[[0, 1, 1], [1, 2, 2]], 1),
    ] {
        let text = plain().replace(&polylist(), &primitive.replace('I', INPUTS));
        let loaded = read(&text);
        let mesh = &loaded.scene.meshes()[0];
        assert_eq!(mesh.triangles(), triangles, "{primitive}");
        let kinds = [PrimitiveKind::Triangles, PrimitiveKind::Lines];
        assert_eq!(mesh.kind(), kinds[kind], "{primitive}");
        let warned: &[&str] = if kind == 0 { &[] } else { &["the model has no triangles"] };
        assert!(warnings(&loaded).is_empty() || warnings(&loaded) == warned, "{:?}", loaded.warnings);
    }
}

#[test]
fn units_axes_and_transforms_place_what_is_instanced() {
    let asset = "<unit name='inch' meter='0.5'/><up_axis>Z_UP</up_axis>";
    let nodes = format!(
        "<node id='a'><translate>1 0 0</translate><rotate>0 0 1 90</rotate><scale>2 2 2</scale>\
         <node id='b'><matrix>1 0 0 3 0 1 0 0 0 0 1 0 0 0 0 1</matrix>{INSTANCE}</node></node>\
         <node id='c'><instance_node url='#b'/></node>"
    );
    let text = document(asset, &[geometry(&polylist()), material(LAMBERT)].concat(), &nodes);
    let loaded = read(&text);
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    let scene = &loaded.scene;
    assert_eq!(
        (scene.orientation().up, scene.meshes().len(), scene.instances().len()),
        (Axis::PositiveZ, 1, 2)
    );
    // (0, 0, 0) + 3, times 2, turned, moved by 1, halved; then +Z becomes +Y.
    let [x, y, z] = scene.instances()[0].transform.point([0.0; 3]);
    assert!((x - 0.5).abs() < 1e-9 && y.abs() < 1e-9 && (z + 3.0).abs() < 1e-9, "{x} {y} {z}");
    assert_eq!(scene.instances()[1].transform.point([0.0; 3]), [1.5, 0.0, 0.0]);
    attack(text.as_bytes(), Format::Collada);
}

#[test]
fn shaders_have_textures_opacity_and_emission() {
    let of = |technique: &str| {
        let libraries = [geometry(&polylist()), material(technique)].concat();
        let text = document("", &libraries, &format!("<node>{INSTANCE}</node>"));
        let mut beside = MemoryResolver::default();
        beside.files.insert("my t.png".to_owned(), pixel());
        let loaded = load_beside(text.as_bytes(), Format::Collada, &beside, &limits()).unwrap();
        let messages = warnings(&loaded).into_iter().map(str::to_owned).collect::<Vec<_>>();
        (loaded.scene.materials()[0].clone(), messages)
    };
    let (material, messages) = of("<phong><emission><color>1 0 0 1</color></emission><diffuse>\
        <texture texture='sa' texcoord='UV'/></diffuse><specular><color>1 1 1 1</color></specular><shininess>\
        <float>30</float></shininess><transparency><float>0.25</float></transparency></phong>");
    assert!(messages.is_empty(), "{messages:?}");
    assert!(material.base_color_texture.is_some());
    assert_eq!((material.base_color, material.emissive), ([1.0, 1.0, 1.0, 0.25], [1.0, 0.0, 0.0]));
    assert_eq!(material.alpha_mode, AlphaMode::Blend);
    assert_eq!(
        material.workflow,
        Workflow::MetallicRoughness { metallic: 0.0, roughness: 0.5, texture: None }
    );
    for (opaque, color, factor, expected) in [
        ("A_ONE", "1 1 1 0.5", "1", 0.5),
        ("A_ZERO", "1 1 1 0.25", "1", 0.75),
        ("RGB_ZERO", "0.5 0.5 0.5 1", "0.5", 0.75),
        ("RGB_ONE", "0.5 0.5 0.5 1", "1", 0.5),
    ] {
        let (material, _) = of(&format!(
            "<lambert><diffuse><color>1 1 1 1</color></diffuse><transparent \
            opaque='{opaque}'><color>{color}</color></transparent><transparency><float>{factor}</float>\
            </transparency></lambert>"
        ));
        assert!((material.base_color[3] - expected).abs() < 1e-5, "{opaque}: {:?}", material.base_color);
    }
    let (material, messages) = of("<lambert><transparency><float>0</float></transparency></lambert>");
    assert_eq!((material.base_color[3], material.alpha_mode), (1.0, AlphaMode::Opaque));
    assert!(messages[0].contains("material 'red' is wholly transparent"), "{messages:?}");
    let (material, _) = of("<constant><emission><color>0 1 0 1</color></emission></constant>");
    assert_eq!((material.unlit, material.base_color), (true, [0.0, 1.0, 0.0, 1.0]));
    // Without the file, and by the name of the image.
    let text = plain().replace(LAMBERT, "<lambert><diffuse><texture texture='i'/></diffuse></lambert>");
    let loaded = read(&text);
    assert!(warnings(&loaded)[0].contains("my t.png"), "{:?}", loaded.warnings);
}

/// A picture of one texel.
fn pixel() -> Vec<u8> {
    let mut png = Vec::new();
    let mut encoder = png::Encoder::new(&mut png, 1, 1);
    encoder.set_color(png::ColorType::Rgb);
    encoder.write_header().unwrap().write_image_data(&[255, 0, 0]).unwrap();
    png
}

#[test]
fn images_are_found_wherever_documents_have_them() {
    let technique = "<lambert><diffuse><texture texture='sa'/></diffuse></lambert>";
    let file = "<init_from>file:///C:/maps/my%20t.png</init_from>";
    let library = format!("<library_images><image id='i'>{file}</image></library_images>");
    let image = format!("<image id='i'>{file}</image>");
    for (from, to) in [
        // Version 1.5.
        (file, "<init_from><ref>my%20t.png</ref></init_from>".to_owned()),
        ("<sampler2D><source>su</source>", "<sampler2D><instance_image url=' #i '/>".to_owned()),
        // The sampler without the end of its name.
        ("texture='sa'", "texture='s'".to_owned()),
        // Images of the profile, the effect and the technique.
        ("<profile_COMMON>", format!("<profile_COMMON>{image}")),
        ("<profile_COMMON>", format!("{image}<profile_COMMON>")),
        ("<technique sid='c'>", format!("<technique sid='c'>{image}")),
    ] {
        let mut libraries = material(technique);
        if to.contains(&image) {
            libraries = libraries.replace(&library, "");
        }
        let libraries = [geometry(&polylist()), libraries.replace(from, &to)].concat();
        let text = document("", &libraries, &format!("<node>{INSTANCE}</node>"));
        let mut beside = MemoryResolver::default();
        beside.files.insert("my t.png".to_owned(), pixel());
        let loaded = load_beside(text.as_bytes(), Format::Collada, &beside, &limits()).unwrap();
        assert!(loaded.warnings.is_empty(), "{to}: {:?}", loaded.warnings);
        assert!(loaded.scene.materials()[0].base_color_texture.is_some(), "{to}");
    }
}

#[test]
fn effects_of_other_profiles_are_drawn_plain() {
    let loaded = read(&plain().replace("profile_COMMON", "profile_CG"));
    assert_eq!(
        warnings(&loaded),
        ["COLLADA: material 'red' has no shader of the common profile: drawn plain"]
    );
    assert!(loaded.scene.materials()[0].base_color[0] > 0.3, "it is black");
}

#[test]
fn numbers_of_parameters_without_a_name_are_skipped() {
    let accessor = "<accessor source='#pa' count='4' stride='3'/>";
    let parameters =
        ["", " name='X'", " name='Y'", " name='Z'"].map(|name| format!("<param{name}/>")).concat();
    let text = plain().replace("0 0 0 2 0 0 2 2 0\n0 2 0", "9 0 0 0 9 2 0 0 9 2 2 0 9 0 2 0");
    let text = text
        .replace(accessor, &format!("<accessor source='#pa' count='4' stride='4'>{parameters}</accessor>"));
    assert_eq!(read(&text).scene.meshes()[0].positions(), read(&plain()).scene.meshes()[0].positions());
}

#[test]
fn skins_are_drawn_in_their_bind_pose() {
    let controllers = "<library_controllers><controller id='k'><skin source='#g'><bind_shape_matrix>1 0 0 5 0 1 0 0 \
                       0 0 1 0 0 0 0 1</bind_shape_matrix></skin></controller></library_controllers>";
    let nodes = "<node><instance_controller url='#k'/></node>";
    let loaded = read(&document("", &[geometry(&polylist()), controllers.to_owned()].concat(), nodes));
    assert_eq!(warnings(&loaded), ["COLLADA: skins are drawn in their bind pose, morphs as their base mesh"]);
    assert_eq!(loaded.scene.instances()[0].transform.point([0.0; 3]), [5.0, 0.0, 0.0]);
}

#[test]
fn damage_is_named() {
    for (from, to, message) in [
        ("3 0 3</p>", "9 0 3</p>", "COLLADA: 1 primitive of geometry 'square' left out"),
        ("url='#g'", "url='#h'", "COLLADA: there is no geometry 'h' to instance"),
        ("<vcount>4", "<vcount>4000000000", "COLLADA: 1 primitive of geometry 'square' left out"),
    ] {
        let loaded = read(&plain().replace(from, to));
        assert!(warnings(&loaded)[0].starts_with(message), "{:?}", loaded.warnings);
    }
    for (from, to, message) in [
        ("</COLLADA>", "", "COLLADA: line 3: the text ends within an element"),
        ("<COLLADA", "<!DOCTYPE x [<!ENTITY a 'b'>]><COLLADA", "document type definitions are not allowed"),
        ("<node id='a'>", "<node id='a'><matrix>1 2</matrix>", "<matrix> is not of as many finite numbers"),
    ] {
        let error = load(plain().replace(from, to).as_bytes(), Format::Collada).unwrap_err().to_string();
        assert!(error.contains(message), "{error}");
    }
}

/// Nodes that contain each other, and nodes that contain two of the next, thirty deep.
#[test]
fn instances_end() {
    let libraries = geometry(&polylist());
    let cycle = "<node id='a'><instance_node url='#b'/></node><node id='b'><instance_node url='#a'/></node>";
    let result = load(document("", &libraries, cycle).as_bytes(), Format::Collada);
    assert!(matches!(result, Err(LoadError::Limit(_))), "{result:?}");
    let two = |k: u32| {
        format!("<node id='n{k}'>{}</node>", format!("<instance_node url='#n{}'/>", k + 1).repeat(2))
    };
    let tree: String = (0..30).map(two).collect();
    let result = load(document("", &libraries, &tree).as_bytes(), Format::Collada);
    assert!(matches!(result, Err(LoadError::Limit(_))));
    let deep = format!("{}{}", "<node>".repeat(200), "</node>".repeat(200));
    let result = load_beside(
        document("", &libraries, &deep).as_bytes(),
        Format::Collada,
        &MemoryResolver::default(),
        &limits().with_depth(100),
    );
    assert!(matches!(result, Err(LoadError::Limit(_))));
}
