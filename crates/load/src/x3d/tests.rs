//! Scenes in both syntaxes, and damaged ones.

use super::spine;
use crate::hostile::{attack, limits, load, load_beside, warnings};
use crate::{Format, Loaded, MemoryResolver};

use overcoat_scene::{AlphaMode, PrimitiveKind};

const SCENE: &str = "#VRML V2.0 utf8\n# a comment { \nPROTO Lamp [ field SFColor c 1 1 1 ] { Group { children [ ] } }\n\
    DEF Red Transform { translation 1 2, 3 scale 2 2 2 children [ Shape {\n\
      appearance DEF Look Appearance { material Material { diffuseColor 1 0 0 transparency 0.25 } }\n\
      geometry IndexedFaceSet { solid FALSE coord Coordinate { point [ 0 0 0, 1 0 0, 1 1 0, 0 1 0 ] }\n\
        coordIndex [ 0 1 2 3 -1 ] } } ] }\n\
    Transform { rotation 0 0 1 1.5707963 center 1 0 0 children USE Red }\n\
    Switch { whichChoice 1 choice [ Shape { geometry Sphere { } } Shape { geometry Box { size 2 4 6 } } ] }\n\
    Switch { choice Shape { geometry Cone { } } }\n\
    Lamp { c 0 0 1 }\n Group { children [ ROUTE A.b TO C.d ] }\n Viewpoint { position 0 0 5 }\n";

const XML: &str = "<?xml version='1.0'?><!DOCTYPE X3D PUBLIC 'ISO//Web3D//DTD X3D 3.3//EN' 'http://www.web3d.org/x3d.dtd'>\
    <X3D profile='Immersive'><head><meta name='a' content='b'/></head><Scene>\
    <ProtoDeclare name='Lamp'><ProtoBody><Group/></ProtoBody></ProtoDeclare>\
    <Transform DEF='Red' translation='1 2, 3' scale='2 2 2'><Shape><Appearance DEF='Look'>\
    <Material diffuseColor='1 0 0' transparency='0.25'/></Appearance>\
    <IndexedFaceSet solid='false' coordIndex='0 1 2 3 -1'><Coordinate point='0 0 0, 1 0 0, 1 1 0, 0 1 0'/></IndexedFaceSet>\
    </Shape></Transform><Transform rotation='0 0 1 1.5707963' center='1 0 0'><Transform USE='Red'/></Transform>\
    <Switch whichChoice='1'><Shape><Sphere/></Shape><Shape><Box size='2 4 6'/></Shape></Switch>\
    <Switch><Shape><Cone/></Shape></Switch><ProtoInstance name='Lamp'/></Scene></X3D>";

/// Positions of all instances in the scene.
pub(super) fn placed(loaded: &Loaded) -> Vec<Vec<[f64; 3]>> {
    let scene = &loaded.scene;
    let of = |instance: &overcoat_scene::Instance| {
        let mesh = &scene.meshes()[instance.mesh.index()];
        mesh.positions().iter().map(|p| instance.transform.point(p.map(f64::from))).collect()
    };
    scene.instances().iter().map(of).collect()
}

pub(super) fn near(a: [f64; 3], b: [f64; 3]) -> bool {
    a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-5)
}

fn vrml(body: &str) -> Loaded {
    load(format!("#VRML V2.0 utf8\n{body}").as_bytes(), Format::Vrml).unwrap()
}

#[test]
fn both_syntaxes_are_the_same_scene() {
    for (text, format) in [(SCENE, Format::Vrml), (XML, Format::X3d)] {
        assert_eq!(Format::detect(text.as_bytes()), Some(format));
        let loaded = load(text.as_bytes(), format).unwrap();
        let shapes = placed(&loaded);
        assert_eq!(shapes.len(), 3, "{format:?}");
        assert!(near(shapes[0][0], [1.0, 2.0, 3.0]) && near(shapes[0][2], [3.0, 4.0, 3.0]));
        // Turned about (1, 0, 0): (1, 2, 3) is two above it, and goes to its left.
        assert!(near(shapes[1][0], [-1.0, 0.0, 3.0]), "{:?}", shapes[1][0]);
        let bounds = shapes[2].iter().fold(0.0_f64, |most, p| most.max(p[2].abs()));
        assert!(bounds == 3.0 && shapes[2].len() == 24);
        let material = &loaded.scene.materials()[loaded.scene.instances()[0].material.index()];
        assert_eq!(material.base_color, [1.0, 0.0, 0.0, 0.75]);
        assert!(material.double_sided && material.alpha_mode == AlphaMode::Blend);
        assert!(loaded.warnings.is_empty(), "{format:?}: {:?}", loaded.warnings);
    }
}

#[test]
fn prototypes_are_read_for_each_use() {
    let loaded = vrml(
        "PROTO Leg [ field SFColor c 1 0 0 field SFVec3f size 1 1 1 eventIn SFBool on field MFNode more [] ] {\n\
           PROTO Inner [ field SFVec3f s 9 9 9 ] { Shape { geometry Box { size IS s } } }\n\
           Group { children [ Shape { appearance DEF A Appearance { material Material { diffuseColor IS c } }\n\
             geometry Box { size IS size } } Inner { s IS size } ] } Shape { geometry Cone { } }\n\
         }\n\
         PROTO Pair [ exposedField MFNode parts [ Leg { } ] ] { Transform { translation 5 0 0 children IS parts } }\n\
         DEF L Leg { c 0 0 1 size 2 4 6 }\n Pair { } Pair { parts [ USE L USE L ] }",
    );
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    let shapes = placed(&loaded);
    let size = |k: usize| shapes[k].iter().fold(0.0_f64, |most, p| most.max(p[1]));
    assert_eq!(shapes.len(), 8);
    assert_eq!([0, 1, 2, 3].map(size), [2.0, 2.0, 0.5, 0.5]);
    assert!(shapes[4].iter().all(|p| p[0] >= 4.0) && size(4) == 2.0);
    let color = |k: usize| loaded.scene.materials()[loaded.scene.instances()[k].material.index()].base_color;
    assert_eq!([color(0), color(2)], [[0.0, 0.0, 1.0, 1.0], [1.0, 0.0, 0.0, 1.0]]);
    // One that uses itself, and a billion uses.
    let loaded = vrml("PROTO A [ ] { Group { children [ Shape { geometry Box { } } A { } ] } } A { }");
    assert!(warnings(&loaded)[0].contains("prototype 'A' is used too often"), "{:?}", loaded.warnings);
    assert_eq!(loaded.scene.instances().len(), 32);
    let mut laughs = "#VRML V2.0 utf8\nPROTO a0 [ ] { Shape { geometry Box { } } }\n".to_owned();
    for k in 0..30 {
        laughs += &format!("PROTO a{} [ ] {{ Group {{ children [ a{k} {{ }} a{k} {{ }} ] }} }}\n", k + 1);
    }
    let error = load((laughs + "a30 { }").as_bytes(), Format::Vrml).unwrap_err().to_string();
    assert!(error.contains("the number of nodes"), "{error}");
}

#[test]
fn prototypes_of_xml_are_read_for_each_use() {
    let x3d = |body: &str| load(format!("<X3D><Scene>{body}</Scene></X3D>").as_bytes(), Format::X3d);
    let loaded = x3d(
        "<ProtoDeclare name='Leg'><ProtoInterface><field name='c' accessType='initializeOnly' value='1 0 0'/>\
         <field name='size' value='1 1 1'/><field name='more'><Shape><Cone/></Shape></field></ProtoInterface>\
         <ProtoBody><Group><Shape><Appearance><Material><IS><connect nodeField='diffuseColor' protoField='c'/></IS>\
         </Material></Appearance><Box><IS><connect nodeField='size' protoField='size'/></IS></Box></Shape>\
         <Group><IS><connect nodeField='children' protoField='more'/></IS></Group></Group><Shape><Sphere/></Shape></ProtoBody>\
         </ProtoDeclare><ProtoInstance name='Leg' DEF='L'><fieldValue name='size' value='2 4 6'/></ProtoInstance>\
         <ProtoInstance USE='L'/><ProtoInstance name='Leg'><fieldValue name='c' value='0 0 1'/>\
         <fieldValue name='more'><Shape><Box size='9 9 9'/></Shape></fieldValue></ProtoInstance><ProtoInstance name='None'/>",
    )
    .unwrap();
    let shapes = placed(&loaded);
    let size = |k: usize| shapes[k].iter().fold(0.0_f64, |most, p| most.max(p[1]));
    assert_eq!((0..shapes.len()).map(size).collect::<Vec<_>>(), [2.0, 1.0, 2.0, 1.0, 0.5, 4.5]);
    let color = |k: usize| loaded.scene.materials()[loaded.scene.instances()[k].material.index()].base_color;
    assert_eq!([color(0), color(4)], [[1.0, 0.0, 0.0, 1.0], [0.0, 0.0, 1.0, 1.0]]);
    assert_eq!(warnings(&loaded), ["VRML: 'ProtoInstance' is left out"]);
    let within = "<ProtoDeclare name='A'><ProtoBody><Group><Shape><Box/></Shape><ProtoInstance name='A'/></Group></ProtoBody>\
         </ProtoDeclare><ProtoInstance name='A'/>";
    let loaded = x3d(within).unwrap();
    assert!(warnings(&loaded)[0].contains("prototype 'A' is used too often"), "{:?}", loaded.warnings);
    assert_eq!(loaded.scene.instances().len(), 32);
    let mut laughs = "<ProtoDeclare name='a0'><ProtoBody><Group/></ProtoBody></ProtoDeclare>".to_owned();
    for k in 0..30 {
        let use_it = format!("<ProtoInstance name='a{k}'/>");
        laughs += &format!(
            "<ProtoDeclare name='a{}'><ProtoBody><Group>{use_it}{use_it}</Group></ProtoBody></ProtoDeclare>",
            k + 1
        );
    }
    let error = x3d(&(laughs + "<ProtoInstance name='a30'/>")).unwrap_err().to_string();
    assert!(error.contains("the number of nodes"), "{error}");
    attack(format!("<X3D><Scene>{within}</Scene></X3D>").as_bytes(), Format::X3d);
}

#[test]
fn prototypes_are_read_from_other_files() {
    let mut beside = MemoryResolver::default();
    let mut add = |name: &str, text: &str| _ = beside.files.insert(name.to_owned(), text.as_bytes().to_vec());
    add(
        "lib/legs.wrl",
        "#VRML V2.0 utf8\nPROTO Other [ ] { Shape { geometry Cone { } } } Shape { geometry Sphere { } }\n\
         EXTERNPROTO Tall [ ] \"tall.x3d\" PROTO Leg [ field SFVec3f size 1 1 1 ] { Group { children [ \
         Shape { geometry Box { size IS size } } Tall { } ] } }",
    );
    add(
        "lib/tall.x3d",
        "<X3D><Scene><Shape><Sphere/></Shape><ProtoDeclare name='Any'><ProtoBody><Shape><Box size='1 10 1'/></Shape>\
         </ProtoBody></ProtoDeclare></Scene></X3D>",
    );
    add("loop.wrl", "#VRML V2.0 utf8\nEXTERNPROTO L [ ] \"loop.wrl#L\"");
    add("broken.wrl", "#VRML V2.0 utf8\nPROTO L [ ] { Group { children [ Group { 5 } ] } }");
    let head =
        "#VRML V2.0 utf8\nEXTERNPROTO Leg [ field SFVec3f size ] [ \"urn:inet:x\" \"lib/legs.wrl#Leg\" ]\n";
    let text = format!("{head} Leg {{ size 2 4 6 }} Transform {{ translation 9 0 0 children Leg {{ }} }}");
    let loaded = load_beside(text.as_bytes(), Format::Vrml, &beside, &limits()).unwrap();
    let most = |shapes: &[Vec<[f64; 3]>], k: usize| {
        shapes.iter().map(|shape| shape.iter().fold(0.0_f64, |most, p| most.max(p[k]))).collect::<Vec<_>>()
    };
    let shapes = placed(&loaded);
    assert_eq!((most(&shapes, 1), most(&shapes, 0)), (vec![2.0, 5.0, 0.5, 5.0], vec![1.0, 0.5, 9.5, 9.5]));
    let text = "<X3D><Scene><ExternProtoDeclare name='L' url='\"lib/legs.wrl#Leg\"'/><ProtoInstance name='L'>\
         <fieldValue name='size' value='2 4 6'/></ProtoInstance></Scene></X3D>";
    let loaded = load_beside(text.as_bytes(), Format::X3d, &beside, &limits()).unwrap();
    assert_eq!(most(&placed(&loaded), 1), [2.0, 5.0]);
    for (url, message) in [
        ("none.wrl", "prototypes of file 'none.wrl' are left out"),
        ("../../etc/passwd", "prototypes of file '../../etc/passwd' are left out"),
        ("lib/legs.wrl#Arm", "prototype 'Arm' is not in the file"),
        ("loop.wrl#L", "prototype 'P' is used too often"),
        ("broken.wrl", "a prototype of file 'broken.wrl' is left out"),
    ] {
        let text = format!(
            "#VRML V2.0 utf8\nEXTERNPROTO P [ ] \"{url}\" P {{ }} P {{ }} Shape {{ geometry Box {{ }} }}"
        );
        let loaded = load_beside(text.as_bytes(), Format::Vrml, &beside, &limits()).unwrap();
        assert!(warnings(&loaded)[0].contains(message), "{:?}", warnings(&loaded));
        assert_eq!(loaded.scene.instances().len(), 1);
    }
}

#[test]
fn surfaces_have_the_values_that_their_indices_say() {
    let loaded = vrml(
        "Shape { geometry IndexedFaceSet { convex FALSE ccw FALSE colorPerVertex FALSE creaseAngle 3.2\n\
         coord DEF C Coordinate { point [ 0 0 0 2 0 0 2 2 0 1 0.5 0 0 2 0 ] }\n\
         color Color { color [ 0 0 1 1 0 0 ] } colorIndex [ 1 ] texCoord TextureCoordinate { point [ 0 0 1 1 ] }\n\
         texCoordIndex [ 0 1 0 1 0 -1 ] coordIndex [ 0 1 2 3 4 -1 0 1 9 -1 ] } }\n\
         Shape { geometry IndexedTriangleStripSet { coord USE C index [ 0 1 2 4 ] } }\n\
         Shape { appearance Appearance { material Material { emissiveColor 0 1 0 } }\n\
           geometry IndexedLineSet { coord USE C coordIndex [ 0 1 2 -1 3 4 ] } }\n\
         Shape { geometry PointSet { coord USE C } }",
    );
    let [faces, strip, lines, points] = loaded.scene.meshes() else { panic!("{:?}", warnings(&loaded)) };
    assert_eq!(faces.triangles().len(), 3);
    assert!(faces.colors().iter().all(|c| *c == [1.0, 0.0, 0.0, 1.0]));
    assert!(faces.normals().iter().all(|n| n[2] < -0.99), "clockwise faces are seen from behind");
    let first = faces.positions().iter().position(|p| *p == [0.0; 3]).unwrap();
    assert_eq!(faces.uvs(0)[first], [0.0, 1.0]);
    assert_eq!(strip.triangles().len(), 2);
    assert_eq!((lines.kind(), lines.triangles().len()), (PrimitiveKind::Lines, 3));
    assert_eq!((points.kind(), points.positions().len()), (PrimitiveKind::Points, 5));
    let green = &loaded.scene.materials()[loaded.scene.instances()[2].material.index()];
    assert!(green.unlit && green.base_color == [0.0, 1.0, 0.0, 1.0]);
    assert!(warnings(&loaded)[0].contains("1 face left out"));
    let clay = &loaded.scene.materials()[loaded.scene.instances()[1].material.index()];
    assert!(!clay.double_sided);
}

#[test]
fn corners_without_a_colour_are_white_and_named() {
    let loaded = vrml(
        "Shape { geometry IndexedFaceSet { coord Coordinate { point [ 0 0 0, 1 0 0, 1 1 0, 0 1 0 ] }\n\
         coordIndex [ 0 1 2 -1 0 2 3 -1 ] colorPerVertex FALSE colorIndex [ 0 ] color Color { color [ 1 0 0 ] } } }",
    );
    assert_eq!(warnings(&loaded), ["VRML: 3 corners without a colour, where others have one: drawn white"]);
    let colors = loaded.scene.meshes()[0].colors();
    assert_eq!(colors.iter().filter(|color| **color == [1.0; 4]).count(), 3);
    assert_eq!(colors.iter().filter(|color| **color == [1.0, 0.0, 0.0, 1.0]).count(), 3);
}

#[test]
fn shapes_face_outwards() {
    for shape in [
        "Box { }",
        "Sphere { }",
        "Cone { }",
        "Cylinder { }",
        "Extrusion { }",
        "Extrusion { spine [ 0 0 0 1 0 0 1 0 1 ] crossSection [ 0.1 0.1 0.1 -0.1 -0.1 -0.1 -0.1 0.1 0.1 0.1 ] }",
    ] {
        let loaded = vrml(&format!("Shape {{ geometry {shape} }}"));
        let mesh = &loaded.scene.meshes()[0];
        // The volume by the divergence theorem is positive where triangles are counter-clockwise from outside.
        let volume: f64 = (mesh.triangles().iter())
            .map(|t| {
                let [a, b, c] = t.map(|v| mesh.positions()[v as usize].map(f64::from));
                a[0] * (b[1] * c[2] - b[2] * c[1])
                    + a[1] * (b[2] * c[0] - b[0] * c[2])
                    + a[2] * (b[0] * c[1] - b[1] * c[0])
            })
            .sum();
        assert!(volume > 0.1, "{shape}: {volume}");
    }
    let loaded = vrml(
        "Shape { geometry ElevationGrid { xDimension 3 zDimension 2 height [ 0 0 0 1 1 1 ] creaseAngle 1 } }",
    );
    let mesh = &loaded.scene.meshes()[0];
    assert!(mesh.triangles().len() == 4 && mesh.normals().iter().all(|n| n[1] > 0.5 && n[2] < -0.5));
    let loaded =
        vrml("Shape { geometry ElevationGrid { xDimension 3000 zDimension 2000 height [ 0 0 0 1 1 1 ] } }");
    assert!(warnings(&loaded)[0].contains("an ElevationGrid of 3000 x 2000 with 6 heights is left out"));
}

#[test]
fn axes_follow_the_spine() {
    let straight = spine::axes(&[[0.0; 3], [0.0, 0.0, 2.0]]);
    for [x, y, z] in straight {
        assert!(
            near(y, [0.0, 0.0, 1.0]) && near(x, [1.0, 0.0, 0.0]) && near(z, [0.0, -1.0, 0.0]),
            "{x:?} {z:?}"
        );
    }
    let down = spine::axes(&[[0.0; 3], [0.0, -2.0, 0.0]]);
    assert!(near(down[0][0], [1.0, 0.0, 0.0]));
    assert!(near(
        spine::turned([1.0, 0.0, 0.0], [0.0, 0.0, 9.0, std::f64::consts::FRAC_PI_2]),
        [0.0, 1.0, 0.0]
    ));
}

#[test]
fn textures_are_in_the_file_or_beside_it() {
    let square = "geometry IndexedFaceSet { coord Coordinate { point [ 0 0 0 4 0 0 4 2 0 0 2 0 ] } coordIndex [ 0 1 2 3 ] }";
    let loaded = vrml(&format!(
        "Shape {{ appearance Appearance {{ material Material {{ diffuseColor 1 0 0 }} texture PixelTexture {{ repeatS FALSE\n\
         image 2 1 4 0xff000080 255 }} textureTransform TextureTransform {{ scale 2 2 translation 0.5 0 }} }} {square} }}"
    ));
    let material = &loaded.scene.materials()[0];
    let used = material.base_color_texture.unwrap();
    let texture = &loaded.scene.textures()[used.texture.index()];
    assert_eq!((texture.width(), texture.height()), (2, 1));
    assert_eq!((material.base_color, material.alpha_mode), ([1.0; 4], AlphaMode::Blend));
    assert_eq!(used.transform.rows, [[2.0, 0.0, 1.0], [0.0, 2.0, -1.0]]);
    // The longer side is the width.
    assert_eq!(loaded.scene.meshes()[0].uvs(0)[2], [1.0, 0.5]);
    let loaded = vrml(&format!(
        "Shape {{ appearance Appearance {{ texture ImageTexture {{ url [ \"../a.png\" \"b.png\" ] }} }} {square} }}"
    ));
    assert!(warnings(&loaded)[0].contains("texture '../a.png' is left out"), "{:?}", warnings(&loaded));
}

#[test]
fn other_files_are_drawn_where_they_are_named() {
    let mut beside = MemoryResolver::default();
    beside.files.insert(
        "parts/a.wrl".to_owned(),
        b"#VRML V2.0 utf8\nShape { geometry Box { } } Inline { url \"b.x3d\" }".to_vec(),
    );
    beside.files.insert(
        "parts/b.x3d".to_owned(),
        b"<X3D><Scene><Shape><Box/></Shape><Inline url='\"a.wrl\"'/></Scene></X3D>".to_vec(),
    );
    let text = "#VRML V2.0 utf8\nTransform { translation 5 0 0 children Inline { url [ \"parts/a.wrl\" ] } } \
                Inline { url \"parts/none.wrl\" } Inline { url \"../../etc/passwd\" }";
    let loaded = load_beside(text.as_bytes(), Format::Vrml, &beside, &limits()).unwrap();
    let shapes = placed(&loaded);
    assert!(shapes.len() == 2 && shapes.iter().all(|s| s.iter().all(|p| p[0] >= 4.0)));
    // Read once, however often it is named.
    let many = format!("#VRML V2.0 utf8\n{}", "Inline { url \"parts/none.wrl\" } ".repeat(2000));
    let none = load_beside(many.as_bytes(), Format::Vrml, &beside, &limits()).unwrap();
    assert_eq!(warnings(&none).len(), 2, "{:?}", warnings(&none));
    let found = warnings(&loaded);
    assert!(found.iter().any(|w| w.contains("file 'parts/a.wrl' contains itself")), "{found:?}");
    assert_eq!(found.len(), 3, "{found:?}");
}

#[test]
fn hostile_files_end_in_a_scene_or_a_message() {
    // Each is used twice by the next: a billion shapes.
    let mut laughs = "#VRML V2.0 utf8\nDEF a0 Shape { geometry Box { } }\n".to_owned();
    for k in 0..30 {
        laughs += &format!("DEF a{} Group {{ children [ USE a{k} USE a{k} ] }}\n", k + 1);
    }
    let error = load(laughs.as_bytes(), Format::Vrml).unwrap_err().to_string();
    assert!(error.contains("the number of nodes with every use of them"), "{error}");
    for (text, message) in [
        ("Group { children [ ".repeat(5000), "nodes within nodes"),
        (
            "Shape { geometry Extrusion { spine [".to_owned()
                + &"0 1 2 ".repeat(2000)
                + "] crossSection ["
                + &"0 1 ".repeat(2000)
                + "] } }",
            "the model's triangles",
        ),
        ("Group { 5 }".to_owned(), "line 2: } where a value should be"),
        ("Group".to_owned(), "the file ends where { of a node should be"),
    ] {
        let outcome = load(format!("#VRML V2.0 utf8\n{text}").as_bytes(), Format::Vrml);
        match outcome {
            Err(error) => assert!(error.to_string().contains(message), "{error}"),
            Ok(loaded) => assert!(message.contains("where"), "{message}: {:?}", warnings(&loaded)),
        }
    }
    assert!(
        warnings(&vrml("Group { children DEF a Group { children USE a } }"))[0].contains("node 'a' is used")
    );
    attack(SCENE.as_bytes(), Format::Vrml);
    attack(XML.as_bytes(), Format::X3d);
}
