//! Scenes of VRML 1.0: the state that nodes set, bindings, and damaged files.

use super::tests::{near, placed};
use crate::hostile::{attack, limits, load, load_beside, warnings};
use crate::{Format, Loaded, MemoryResolver};

use overcoat_scene::{AlphaMode, Material, PrimitiveKind};

const SCENE: &str = "#VRML V1.0 ascii\nSeparator { # a comment {\n\
    Info { string \"nothing\" } PerspectiveCamera { position 0 0 5 } PointLight { }\n\
    DEF Red Material { diffuseColor [ 1 0 0, 0 1 0 ] transparency 0.25 }\n\
    Separator { Translation { translation 5 0 0 } Scale { scaleFactor 2 2 2 } DEF Block Cube { height 4 } }\n\
    TransformSeparator { Rotation { rotation 0 0 1 1.5707963 } Material { diffuseColor 0 0 1 } }\n\
    Coordinate3 { point [ 0 0 0, 1 0 0, 1 1 0, 0 1 0, 0 0 1 ] }\n\
    Normal { vector [ 0 0 1, 0 0 -1 ] } NormalBinding { value PER_FACE }\n\
    ShapeHints { vertexOrdering CLOCKWISE shapeType SOLID creaseAngle 0 }\n\
    MatrixTransform { matrix 1 0 0 0  0 1 0 0  0 0 1 0  0 0 7 1 }\n\
    IndexedFaceSet { coordIndex [ 0, 1, 2, 3, -1, 0, 1, 4, -1 ] }\n\
    Switch { whichChild 1 Sphere { radius 9 } USE Block }\n Switch { Sphere { } }\n\
    LOD { range [ 1 2 ] center 0 0 0 Sphere { } Cone { } }\n AsciiText { string [ \"a\" ] justification LEFT }\n}\n";

fn first(body: &str) -> Loaded {
    load(format!("#VRML V1.0 ascii\n{body}").as_bytes(), Format::Vrml).unwrap()
}

fn material(loaded: &Loaded, instance: usize) -> &Material {
    &loaded.scene.materials()[loaded.scene.instances()[instance].material.index()]
}

/// Colours of vertices as letters of the largest component, in the order of triangles.
fn letters(loaded: &Loaded, mesh: usize) -> String {
    let mesh = &loaded.scene.meshes()[mesh];
    let letter = |c: [f32; 4]| match c {
        [1.0, 0.0, 0.0, _] => 'r',
        [0.0, 1.0, 0.0, _] => 'g',
        [0.0, 0.0, 1.0, _] => 'b',
        _ => '?',
    };
    mesh.triangles().iter().flatten().map(|&v| letter(mesh.colors()[v as usize])).collect()
}

#[test]
fn shapes_are_drawn_with_the_state_before_them() {
    assert_eq!(Format::detect(SCENE.as_bytes()), Some(Format::Vrml));
    let loaded = load(SCENE.as_bytes(), Format::Vrml).unwrap();
    let shapes = placed(&loaded);
    assert_eq!(shapes.len(), 4, "{:?}", warnings(&loaded));
    // The cube, moved and scaled in its separator alone; used again where the matrix has moved it.
    let most = |k: usize, axis: usize| shapes[k].iter().fold(f64::MIN, |most, p| most.max(p[axis]));
    assert_eq!([0, 1, 2].map(|axis| most(0, axis)), [7.0, 4.0, 2.0]);
    assert_eq!([0, 1, 2].map(|axis| most(2, axis)), [1.0, 2.0, 8.0]);
    assert_eq!(loaded.scene.instances()[0].mesh, loaded.scene.instances()[2].mesh);
    // Rotations end with their separator, materials do not.
    assert!(shapes[1].iter().any(|&p| near(p, [1.0, 1.0, 7.0])));
    assert_eq!(material(&loaded, 0).base_color, [1.0, 0.0, 0.0, 0.75]);
    assert_eq!(material(&loaded, 0).alpha_mode, AlphaMode::Blend);
    assert_eq!(material(&loaded, 1).base_color, [0.0, 0.0, 1.0, 1.0]);
    assert!(!material(&loaded, 1).double_sided);
    let faces = &loaded.scene.meshes()[1];
    assert_eq!(faces.triangles().len(), 3);
    let [a, b, c] = faces.triangles()[0].map(|v| faces.positions()[v as usize]);
    let turn = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    assert!(turn < 0.0, "clockwise faces are seen from behind");
    let normals: Vec<f32> = faces.triangles().iter().map(|t| faces.normals()[t[0] as usize][2]).collect();
    assert_eq!(normals, [1.0, 1.0, -1.0]);
    assert_eq!(warnings(&loaded), ["VRML: 'AsciiText' is left out"]);
}

#[test]
fn materials_are_bound_to_parts_faces_and_vertices() {
    let points = "Coordinate3 { point [ 0 0 0, 1 0 0, 1 1 0, 0 1 0 ] }";
    let colors = "Material { diffuseColor [ 1 0 0, 0 1 0, 0 0 1 ] }";
    let faces = |binding: &str, index: &str| {
        let loaded = first(&format!(
            "Separator {{ {points} {colors} MaterialBinding {{ value {binding} }} \
             IndexedFaceSet {{ coordIndex [ 0 1 2 -1 2 3 0 -1 0 1 3 -1 1 2 3 ] {index} }} }}"
        ));
        assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
        loaded
    };
    // Colours begin again when there are not enough.
    for (binding, index, expected) in [
        ("PER_FACE", "", "rrrgggbbbrrr"),
        ("PER_PART", "", "rrrgggbbbrrr"),
        ("PER_FACE_INDEXED", "materialIndex [ 2 2 1 4 ]", "bbbbbbgggggg"),
        ("PER_VERTEX", "", "rgbrgbrgbrgb"),
        ("PER_VERTEX_INDEXED", "materialIndex [ -1 ]", "rgbbrrrgrgbr"),
        ("PER_VERTEX_INDEXED", "materialIndex [ 0 0 1 -1 2 2 2 -1 1 1 1 -1 0 1 2 -1 ]", "rrgbbbgggrgb"),
    ] {
        assert_eq!(letters(&faces(binding, index), 0), expected, "{binding} {index}");
    }
    for binding in ["OVERALL", "DEFAULT"] {
        let loaded = faces(binding, "");
        assert!(loaded.scene.meshes()[0].colors().is_empty());
        assert_eq!(material(&loaded, 0).base_color, [1.0, 0.0, 0.0, 1.0]);
    }
    let lines = |binding: &str| {
        let loaded = first(&format!(
            "{points} {colors} MaterialBinding {{ value {binding} }} IndexedLineSet {{ coordIndex [ 0 1 2 -1 2 3 ] }}"
        ));
        assert_eq!(loaded.scene.meshes()[0].kind(), PrimitiveKind::Lines);
        letters(&loaded, 0)
    };
    assert_eq!(lines("PER_FACE"), "rrrrrrggg");
    assert_eq!(lines("PER_PART"), "rrrgggbbb");
    assert_eq!(lines("PER_VERTEX"), "rgggbbrgg");
    let loaded = first(&format!(
        "{points} Material {{ diffuseColor [ 1 0 0, 0 1 0, 0 0 1 ] }} MaterialBinding {{ value PER_VERTEX }}\
         PointSet {{ startIndex 1 numPoints 2 }} PointSet {{ numPoints 99 }}"
    ));
    let [some, all] = loaded.scene.meshes() else { panic!("{:?}", loaded.warnings) };
    assert_eq!((some.positions(), all.positions().len()), (&[[1.0, 0.0, 0.0], [1.0, 1.0, 0.0]][..], 4));
    assert_eq!(some.colors()[1], [0.0, 1.0, 0.0, 1.0]);
}

#[test]
fn solids_have_parts() {
    let bind = "Material { diffuseColor [ 1 0 0, 0 1 0 ] } MaterialBinding { value PER_PART }";
    let loaded = first(&format!(
        "{bind} Cylinder {{ parts (SIDES | TOP) }} Cone {{ parts BOTTOM }} Cube {{ }} Sphere {{ }}"
    ));
    let colors: Vec<_> =
        (0..loaded.scene.instances().len()).map(|k| material(&loaded, k).base_color[0]).collect();
    assert_eq!(
        colors,
        [1.0, 0.0, 0.0, 1.0, 0.0, 1.0, 0.0, 1.0, 0.0, 1.0],
        "sides, top, bottom, six faces, sphere"
    );
    let shapes = placed(&loaded);
    assert!(shapes[1].iter().all(|p| p[1] == 1.0) && shapes[2].iter().all(|p| p[1] == -1.0));
    assert!(shapes[3].iter().all(|p| p[2] == 1.0) && shapes[8].iter().all(|p| p[1] == -1.0));
    let loaded = first("Cylinder { parts SIDES height 4 }");
    assert!(placed(&loaded)[0].iter().all(|p| p[1].abs() == 2.0) && material(&loaded, 0).double_sided);
}

#[test]
fn light_that_was_computed_is_drawn_as_it_is() {
    let text = "Material { ambientColor [ ] diffuseColor [ ] specularColor [ ] emissiveColor [ 0 1 0, 1 0 0 ] }\n\
         MaterialBinding { value PER_VERTEX } Coordinate3 { point [ 0 0 0, 1 0 0, 1 1 0 ] }\n\
         IndexedFaceSet { coordIndex [ 0, 1, 2, -1 ] } MaterialBinding { } Cube { }";
    let loaded = first(text);
    assert!(material(&loaded, 0).unlit && material(&loaded, 1).unlit && loaded.warnings.is_empty());
    assert_eq!(letters(&loaded, 0), "grg");
    assert_eq!(material(&loaded, 1).base_color, [0.0, 1.0, 0.0, 1.0]);
    let glow = first(&text.replace("diffuseColor [ ]", "diffuseColor [ 1 0 0, 0 0 1 ]"));
    assert!(warnings(&glow)[0].contains("several values of emissiveColor"), "{:?}", warnings(&glow));
}

#[test]
fn pictures_follow_their_transform() {
    let square = "Coordinate3 { point [ 0 0 0, 1 0 0, 1 1 0, 0 1 0 ] }\n\
         TextureCoordinate2 { point [ 0 0, 1 0, 1 1, 0 1 ] } IndexedFaceSet { coordIndex [ 0 1 2 3 -1 ] }";
    let loaded = first(&format!(
        "Separator {{ Texture2 {{ wrapS CLAMP image 2 1 4 0xff000080 255 }}\n\
         Texture2Transform {{ translation 0.5 0 }} Texture2Transform {{ scaleFactor 2 4 }} {square} }} {square}"
    ));
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    let used = material(&loaded, 0).base_color_texture.unwrap();
    // Scaled, then moved by the transform around: u is 2 u + 0.5, v is 4 v from below.
    assert_eq!(used.transform.rows, [[2.0, 0.0, 0.5], [0.0, 4.0, -3.0]]);
    assert!(material(&loaded, 1).base_color_texture.is_none());
    let none = first(&format!("Texture2 {{ filename \"../a.png\" }} {square} Texture2 {{ }} {square}"));
    assert!(warnings(&none)[0].contains("texture '../a.png' is left out"), "{:?}", warnings(&none));
}

#[test]
fn files_of_both_versions_name_each_other() {
    let mut beside = MemoryResolver::default();
    let text = |text: &str| text.as_bytes().to_vec();
    beside.files.insert(
        "a.wrl".to_owned(),
        text("#VRML V2.0 utf8\nShape { geometry Box { } } Inline { url \"b.wrl\" }"),
    );
    beside.files.insert(
        "b.wrl".to_owned(),
        text("#VRML V1.0 ascii\nSeparator { Cube { } WWWInline { name \"a.wrl\" } }"),
    );
    let root =
        "#VRML V1.0 ascii\nTranslation { translation 5 0 0 } WWWAnchor { WWWInline { name \"a.wrl\" } }";
    let loaded = load_beside(root.as_bytes(), Format::Vrml, &beside, &limits()).unwrap();
    let shapes = placed(&loaded);
    assert!(shapes.len() == 2 && shapes.iter().flatten().all(|p| p[0] >= 4.0));
    assert!(warnings(&loaded)[0].contains("contains itself"), "{:?}", warnings(&loaded));
}

#[test]
fn hostile_files_end_in_a_scene_or_a_message() {
    let mut laughs = "#VRML V1.0 ascii\nSeparator { DEF a0 Cube { }\n".to_owned();
    for k in 0..30 {
        laughs += &format!("DEF a{} Group {{ USE a{k} USE a{k} }}\n", k + 1);
    }
    let error = load(laughs.as_bytes(), Format::Vrml).unwrap_err().to_string();
    assert!(error.contains("the number of nodes with every use of them"), "{error}");
    for (text, message) in [
        ("Group { ".repeat(5000), "nodes within nodes"),
        ("Cube { width }".to_owned(), "line 2: } where a value should be"),
        ("Cone { parts (SIDES | }".to_owned(), "line 2: } where a closing parenthesis should be"),
        ("Separator".to_owned(), "the file ends where { of a node should be"),
    ] {
        let error =
            load(format!("#VRML V1.0 ascii\n{text}").as_bytes(), Format::Vrml).unwrap_err().to_string();
        assert!(error.contains(message), "{error}");
    }
    let inner = first("DEF a Group { USE a }");
    assert!(warnings(&inner)[0].contains("node 'a' is used"), "{:?}", warnings(&inner));
    // Fields of nodes that are no part of the language, and numbers where there are none.
    let odd = first(
        "Strange { fields [ SFString a, MFFloat b ] isA [ \"Cube\" ] a \"x\" b [ 1 2 ] Cube { } }\n\
         Material { diffuseColor [ 1 0 ] } MaterialBinding { value PER_VERTEX_INDEXED } PointSet { startIndex -5 }\n\
         Coordinate3 { point [ 0 0 0, 1 0 0 nan 0 ] } IndexedFaceSet { coordIndex [ 0 1 9 -1 -1 -1 1e30 ] } \
         MatrixTransform { matrix 1 2 } Scale { scaleFactor 1e300 1e300 1e300 } Scale { scaleFactor 1e300 1 1 }",
    );
    assert!(warnings(&odd).iter().any(|w| w.contains("'Strange' is left out")), "{:?}", warnings(&odd));
    attack(SCENE.as_bytes(), Format::Vrml);
}

#[test]
fn points_with_fewer_colors_are_drawn_without_and_say_so() {
    let points =
        "MaterialBinding { value PER_VERTEX } Coordinate3 { point [ 0 0 0, 1 0 0, 2 0 0 ] } PointSet { }";
    for (colors, is_enough) in [("1 0 0, 0 1 0, 0 0 1", true), ("1 0 0, 0 1 0", false)] {
        let loaded = first(&format!("Material {{ diffuseColor [ {colors} ] }} {points}"));
        let found = warnings(&loaded);
        assert_eq!(!found.iter().any(|warning| warning.contains("fewer colors")), is_enough, "{found:?}");
    }
}
