//! Files that are written here, in both encodings, and read again.

mod file;

use super::transform::Placement;
use crate::hostile::{attack, limits, load, load_beside, warnings};
use crate::{Format, LoadError, Loaded, MemoryResolver};
use file::*;
use overcoat_core::color::srgb::srgb_to_linear;
use overcoat_scene::{AlphaMode, Axis, Workflow, Wrap};

fn read(records: &[R]) -> Loaded {
    load(&binary(records, 7400, false), Format::Fbx).unwrap()
}

/// Positions of the first corner of each instance.
fn places(loaded: &Loaded) -> Vec<[f64; 3]> {
    let scene = &loaded.scene;
    let place = |k: usize| {
        let instance = &scene.instances()[k];
        instance.transform.point(scene.meshes()[instance.mesh.index()].positions()[0].map(f64::from))
    };
    (0..scene.instances().len()).map(place).collect()
}

fn close(a: [f64; 3], b: [f64; 3]) {
    assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-6), "{a:?} is not {b:?}");
}

#[test]
fn a_square_is_the_same_in_every_encoding() {
    let records = plain();
    let files = [
        binary(&records, 7400, false),
        binary(&records, 7400, true),
        binary(&records, 7700, true),
        text(&records).into_bytes(),
    ];
    for bytes in &files {
        assert_eq!(Format::detect(bytes), Some(Format::Fbx));
        let loaded = load(bytes, Format::Fbx).unwrap();
        assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
        let (scene, mesh) = (&loaded.scene, &loaded.scene.meshes()[0]);
        assert_eq!(mesh.positions(), [[0.0; 3], [2.0, 0.0, 0.0], [2.0, 2.0, 0.0], [0.0, 2.0, 0.0]]);
        assert_eq!(mesh.triangles(), [[0, 1, 2], [0, 2, 3]]);
        assert_eq!(mesh.normals(), [[0.0, 0.0, 1.0]; 4]);
        assert_eq!(mesh.uvs(0), [[0.0, 1.0], [1.0, 1.0], [1.0, 0.75], [0.0, 1.0]]);
        assert_eq!(scene.materials()[0].base_color, [srgb_to_linear(0.5), 0.0, 0.0, 1.0]);
        assert_eq!((scene.materials()[0].name.as_str(), scene.orientation().up), ("red", Axis::PositiveY));
    }
}

#[test]
fn hostile_variants_end_in_a_scene_or_a_message() {
    let records = plain();
    attack(&binary(&records, 7400, false), Format::Fbx);
    attack(&binary(&records, 7700, true), Format::Fbx);
    attack(text(&records).as_bytes(), Format::Fbx);
    attack(&binary(&deformed(), 7400, true), Format::Fbx);
}

#[test]
fn files_of_version_6_have_meshes_in_models() {
    let text = "; FBX 6.1.0 project file\nFBXHeaderExtension:  {\n FBXVersion: 6100\n}\nObjects:  {\n\
        Model: \"Model::cube\", \"Mesh\" {\n Properties60:  {\n  Property: \"Lcl Translation\", \"Lcl Translation\", \
        \"A+\",4,0,0\n }\n Vertices: 0,0,0,2,0,0\n ,2,2,0,0,2,0\n PolygonVertexIndex: 0,1,2,-4\n \
        Edges: \n 0,1\n}\n\
        Material: \"Material::blue\", \"\" {\n Properties60:  {\n  Property: \"DiffuseColor\", \"ColorRGB\", \"\",0,0,1\n \
        }\n}\nGlobalSettings:  {\n Properties60:  {\n  Property: \"UpAxis\", \"int\", \"\",2\n Property: \"FrontAxis\", \
        \"int\", \"\",1\n Property: \"FrontAxisSign\", \"int\", \"\",-1\n }\n}\n}\n\
        Connections:  {\n Connect: \"OO\", \"Model::cube\", \"Model::Scene\"\n Connect: \"OO\", \"Material::blue\", \
        \"Model::cube\"\n}\nTakes:  {\n Take: \"a\" {\n  KeyCount: 1\n  Key: \n   1924,0.5,L\n }\n}\n";
    let loaded = load(text.as_bytes(), Format::Fbx).unwrap();
    assert_eq!(warnings(&loaded), ["FBX: animations have no effect"]);
    assert_eq!(loaded.scene.orientation().up, Axis::PositiveZ);
    assert_eq!(loaded.scene.materials()[0].base_color, [0.0, 0.0, 1.0, 1.0]);
    assert_eq!(loaded.scene.triangle_count(), 2);
    close(places(&loaded)[0], [0.04, 0.0, 0.0]);
    attack(text.as_bytes(), Format::Fbx);
}

/// Skins of another kind than linear ones are named.
#[test]
fn skins_of_dual_quaternions_are_named() {
    let text = "; FBX 7.4.0 project file\nFBXHeaderExtension:  {\n FBXVersion: 7400\n}\nObjects:  {\n\
        Geometry: 1, \"Geometry::\", \"Mesh\" {\n Vertices: *9 {\n a: 0,0,0,1,0,0,0,1,0\n }\n PolygonVertexIndex: *3 {\n \
        a: 0,1,-3\n }\n}\nModel: 2, \"Model::m\", \"Mesh\" {\n}\nDeformer: 3, \"Deformer::\", \"Skin\" {\n \
        SkinningType: \"DualQuaternion\"\n}\n}\nConnections:  {\n C: \"OO\",1,2\n C: \"OO\",2,0\n C: \"OO\",3,1\n}\n";
    let loaded = load(text.as_bytes(), Format::Fbx).unwrap();
    assert_eq!(warnings(&loaded), ["FBX: skins of dual quaternions drawn as linear ones: 1"]);
    assert_eq!(loaded.scene.triangle_count(), 1);
}

/// Position of the first corner of a square, in a model with these properties.
fn placed(list: Vec<R>) -> [f64; 3] {
    let objects = vec![square(1, vec![]), model(2, "thing", list)];
    places(&read(&file(vec![], objects, vec![connection(1, 2)])))[0]
}

#[test]
fn pivots_and_orders_place_a_model() {
    let turn = || p("Lcl Rotation", &[0.0, 0.0, 90.0]);
    close(placed(vec![p("Lcl Translation", &[1.0, 2.0, 3.0])]), [1.0, 2.0, 3.0]);
    // About (1, 0, 0), zero goes to (1, -1, 0).
    close(placed(vec![turn(), p("RotationPivot", &[1.0, 0.0, 0.0])]), [1.0, -1.0, 0.0]);
    close(
        placed(vec![turn(), p("RotationPivot", &[1.0, 0.0, 0.0]), p("RotationOffset", &[5.0, 0.0, 0.0])]),
        [6.0, -1.0, 0.0],
    );
    // Scaled about (1, 0, 0) by 3, zero goes to (-2, 0, 0).
    let scale = || p("Lcl Scaling", &[3.0, 3.0, 3.0]);
    close(placed(vec![scale(), p("ScalingPivot", &[1.0, 0.0, 0.0])]), [-2.0, 0.0, 0.0]);
    close(
        placed(vec![scale(), p("ScalingPivot", &[1.0, 0.0, 0.0]), p("ScalingOffset", &[0.0, 1.0, 0.0])]),
        [-2.0, 1.0, 0.0],
    );
    close(placed(vec![turn(), p("GeometricTranslation", &[1.0, 0.0, 0.0])]), [0.0, 1.0, 0.0]);
    // Half a turn of x by 90 and z by 90 about each other: by the order, +z goes to +x or to -y.
    let shifted = |list: Vec<R>| placed([vec![p("GeometricTranslation", &[0.0, 0.0, 1.0])], list].concat());
    let both = || p("Lcl Rotation", &[90.0, 0.0, 90.0]);
    close(shifted(vec![both()]), [1.0, 0.0, 0.0]);
    close(shifted(vec![both(), p("RotationOrder", &[5.0])]), [0.0, -1.0, 0.0]);
    close(shifted(vec![both(), p("RotationOrder", &[5.0]), p("RotationActive", &[0.0])]), [1.0, 0.0, 0.0]);
    // Rotations before and, as its inverse, after.
    close(shifted(vec![p("PreRotation", &[90.0, 0.0, 0.0])]), [0.0, -1.0, 0.0]);
    close(shifted(vec![p("PostRotation", &[90.0, 0.0, 0.0])]), [0.0, 1.0, 0.0]);
    close(
        shifted(vec![p("PreRotation", &[90.0, 0.0, 0.0]), p("RotationSpaceForLimitOnly", &[1.0])]),
        [0.0, 0.0, 1.0],
    );
}

#[test]
fn scale_is_inherited_in_three_ways() {
    // A parent of scale (2, 1, 1), and a child that is turned by 90 degrees about z and scaled by (1, 3, 1).
    let corner = |inherit: f64| {
        let child = vec![
            p("Lcl Rotation", &[0.0, 0.0, 90.0]),
            p("Lcl Scaling", &[1.0, 3.0, 1.0]),
            p("InheritType", &[inherit]),
        ];
        let objects = vec![
            square(1, vec![]),
            model(2, "parent", vec![p("Lcl Scaling", &[2.0, 1.0, 1.0])]),
            model(3, "child", child),
        ];
        let loaded = read(&file(vec![], objects, vec![connection(1, 3), connection(3, 2), connection(2, 0)]));
        loaded.scene.instances()[0].transform.point([1.0, 1.0, 0.0])
    };
    // The scale of the parent after the rotation, before it, and not at all.
    close(corner(1.0), [-6.0, 1.0, 0.0]);
    close(corner(0.0), [-3.0, 2.0, 0.0]);
    close(corner(2.0), [-3.0, 1.0, 0.0]);
    assert_eq!(Placement::ROOT.world, overcoat_scene::Transform::IDENTITY);
}

#[test]
fn axes_and_units_are_those_of_the_settings() {
    let of = |up: f64, front: (f64, f64), right: (f64, f64), unit: f64| {
        let settings = vec![
            p("UpAxis", &[up]),
            p("FrontAxis", &[front.0]),
            p("FrontAxisSign", &[front.1]),
            p("CoordAxis", &[right.0]),
            p("CoordAxisSign", &[right.1]),
            p("UnitScaleFactor", &[unit]),
        ];
        let mut records =
            file(settings, vec![square(1, vec![]), model(2, "m", vec![])], vec![connection(1, 2)]);
        // The last definition is the one that is looked for.
        records[1].2[0].2.remove(0);
        read(&records)
    };
    // A point in the file, in the scene.
    let point = |loaded: &Loaded| loaded.scene.instances()[0].transform.point([1.0, 2.0, 3.0]);
    let y = of(1.0, (2.0, 1.0), (0.0, 1.0), 100.0);
    assert_eq!((y.scene.orientation().up, y.warnings.len()), (Axis::PositiveY, 0));
    close(point(&y), [1.0, 2.0, 3.0]);
    let z = of(2.0, (1.0, -1.0), (0.0, 1.0), 2.54);
    assert_eq!(z.scene.orientation().up, Axis::PositiveZ);
    close(point(&z), [0.0254, 0.0762, -0.0508]);
    // Another front: +X is towards the viewer, +Y to the right.
    close(point(&of(2.0, (0.0, 1.0), (1.0, 1.0), 100.0)), [2.0, 3.0, 1.0]);
    // Left-handed axes mirror.
    close(point(&of(1.0, (2.0, 1.0), (0.0, -1.0), 100.0)), [-1.0, 2.0, 3.0]);
    let none = of(1.0, (1.0, 1.0), (0.0, 1.0), 100.0);
    assert_eq!(warnings(&none), ["FBX: the axes of the file are none: +Y is taken as up"]);
}

#[test]
fn layers_are_by_corner_point_polygon_or_mesh() {
    // Two triangles of a square.
    let mesh = |layers: Vec<R>| {
        let mut records =
            vec![floats("Vertices", &SQUARE), integers("PolygonVertexIndex", &[0, 1, !2, 0, 2, !3])];
        records.extend(layers);
        let objects = vec![object("Geometry", 1, "g", "Mesh", records), model(2, "m", vec![])];
        let loaded = read(&file(vec![], objects, vec![connection(1, 2)]));
        assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
        loaded
    };
    let colors = |mapping: &str, reference: &str, colors: &[f64], index: &[i32]| {
        let records = vec![floats("Colors", colors), integers("ColorIndex", index)];
        let loaded = mesh(vec![layer("LayerElementColor", mapping, reference, records)]);
        let mesh = &loaded.scene.meshes()[0];
        mesh.triangles().as_flattened().iter().map(|&v| mesh.colors()[v as usize][0]).collect::<Vec<_>>()
    };
    let list: Vec<f64> = (0..6).flat_map(|k| [f64::from(k % 2), 0.0, 0.0, 1.0]).collect();
    assert_eq!(colors("ByPolygonVertex", "Direct", &list, &[]), [0.0, 1.0, 0.0, 1.0, 0.0, 1.0]);
    assert_eq!(colors("ByVertice", "Direct", &list, &[]), [0.0, 1.0, 0.0, 0.0, 0.0, 1.0]);
    assert_eq!(colors("ByPolygon", "Direct", &list, &[]), [0.0, 0.0, 0.0, 1.0, 1.0, 1.0]);
    assert_eq!(colors("AllSame", "IndexToDirect", &list, &[1]), [1.0; 6]);
    assert_eq!(colors("ByVertice", "IndexToDirect", &list, &[1, 0, 0, 0]), [1.0, 0.0, 0.0, 1.0, 0.0, 0.0]);
    // Indices that do not exist are white.
    assert_eq!(colors("ByPolygon", "IndexToDirect", &list, &[-1, 99]), [1.0; 6]);
    let material = |index: &[i32]| {
        let loaded = mesh(vec![layer(
            "LayerElementMaterial",
            "ByPolygon",
            "IndexToDirect",
            vec![integers("Materials", index)],
        )]);
        loaded.scene.meshes().iter().map(|mesh| mesh.triangles().len()).collect::<Vec<_>>()
    };
    assert_eq!((material(&[0, 0]), material(&[0, 1])), (vec![2], vec![1, 1]));
}

#[test]
fn one_mesh_is_read_once_and_what_is_hidden_is_not_drawn() {
    let group = object("NodeAttribute", 9, "lod", "LodGroup", vec![]);
    let objects = vec![
        square(1, vec![]),
        group,
        model(2, "shown", vec![]),
        model(3, "moved", vec![p("Lcl Translation", &[5.0, 0.0, 0.0])]),
        model(4, "hidden", vec![p("Visibility", &[0.0])]),
        model(5, "below", vec![]),
        model(6, "levels", vec![]),
        model(7, "fine", vec![p("Lcl Translation", &[0.0, 7.0, 0.0])]),
        model(8, "coarse", vec![]),
    ];
    let mut connections: Vec<R> = [2, 3, 4, 5, 7, 8].map(|id| connection(1, id)).to_vec();
    connections.extend([connection(5, 4), connection(9, 6), connection(7, 6), connection(8, 6)]);
    let loaded = read(&file(vec![], objects, connections));
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    assert_eq!(loaded.scene.meshes().len(), 1);
    assert_eq!(places(&loaded), [[0.0; 3], [5.0, 0.0, 0.0], [0.0, 7.0, 0.0]]);
}

/// A square whose right edge hangs on a bone that is moved by 3, and whose first corner a shape moves by half of 4.
fn deformed() -> Vec<R> {
    let shape = vec![integers("Indexes", &[0]), floats("Vertices", &[0.0, 0.0, 4.0])];
    let identity = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0];
    let cluster = vec![
        integers("Indexes", &[1, 2]),
        floats("Weights", &[0.5, 1.0]),
        floats("Transform", &identity),
        floats("TransformLink", &identity),
    ];
    let objects = vec![
        square(1, normals_and_uvs()),
        model(2, "mesh", vec![p("Lcl Translation", &[0.0, 1.0, 0.0])]),
        object(
            "Model",
            3,
            "bone",
            "LimbNode",
            vec![properties(vec![p("Lcl Translation", &[0.0, 0.0, 3.0])])],
        ),
        object("Deformer", 4, "skin", "Skin", vec![]),
        object("Deformer", 5, "cluster", "Cluster", cluster),
        object("Deformer", 6, "blend", "BlendShape", vec![]),
        object(
            "Deformer",
            7,
            "channel",
            "BlendShapeChannel",
            vec![properties(vec![p("DeformPercent", &[50.0])])],
        ),
        object("Geometry", 8, "shape", "Shape", shape),
    ];
    let links = [(1, 2), (4, 1), (5, 4), (3, 5), (6, 1), (7, 6), (8, 7)];
    file(vec![], objects, links.map(|(from, to)| connection(from, to)).to_vec())
}

#[test]
fn skins_and_shapes_have_the_pose_of_the_file() {
    let loaded = read(&deformed());
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    // Weights are made to sum to 1; what no bone holds stands where the model is.
    let expected = [[0.0, 1.0, 2.0], [2.0, 0.0, 3.0], [2.0, 2.0, 3.0], [0.0, 3.0, 0.0]];
    assert_eq!(loaded.scene.meshes()[0].positions(), expected);
    close(places(&loaded)[0], [0.0, 1.0, 2.0]);
}

/// The material of these properties, of the program that wrote it, with a texture `t.png` beside for a property.
fn material(creator: &str, list: Vec<R>, maps: &[&str]) -> (overcoat_scene::Material, Vec<String>) {
    let mut objects = vec![
        square(1, normals_and_uvs()),
        model(2, "m", vec![]),
        object("Material", 3, "mat", "", vec![one("ShadingModel", s("Phong")), properties(list)]),
    ];
    let mut connections = vec![connection(1, 2), connection(3, 2)];
    for (id, map) in (10..).zip(maps) {
        let wrap = properties(vec![p("WrapModeU", &[1.0]), p("Scaling", &[2.0, 4.0, 1.0])]);
        let name = one("RelativeFilename", s("C:\\work\\t.png"));
        objects.push(object("Texture", id, "t", "", vec![name, wrap]));
        connections.push(to_property(id, 3, map));
    }
    let mut records = file(vec![], objects, connections);
    records[0].2[1] = one("Creator", s(creator));
    let mut beside = MemoryResolver::default();
    beside.files.insert("t.png".to_owned(), png());
    let loaded = load_beside(&binary(&records, 7400, true), Format::Fbx, &beside, &limits()).unwrap();
    let messages = warnings(&loaded).into_iter().map(str::to_owned).collect();
    if let Some(texture) = &loaded.scene.materials()[0].base_color_texture {
        let sampler = loaded.scene.textures()[texture.texture.index()].sampler();
        assert_eq!((sampler.wrap_u, sampler.wrap_v), (Wrap::ClampToEdge, Wrap::Repeat));
        // (1, 1), which is (1, 0) with v up, is at (0.5, 0), and that is (0.5, 1) with v down.
        assert_eq!(texture.transform.rows.map(|r| r[0] + r[1] + r[2]), [0.5, 1.0]);
    }
    (loaded.scene.materials()[0].clone(), messages)
}

fn png() -> Vec<u8> {
    let mut png = Vec::new();
    let mut encoder = png::Encoder::new(&mut png, 1, 1);
    encoder.set_color(png::ColorType::Rgb);
    encoder.write_header().unwrap().write_image_data(&[255, 0, 0]).unwrap();
    png
}

fn roughness(material: &overcoat_scene::Material) -> [f32; 2] {
    match material.workflow {
        Workflow::MetallicRoughness { metallic, roughness, .. } => [metallic, roughness],
        Workflow::SpecularGlossiness { .. } => panic!(),
    }
}

#[test]
fn phong_has_colour_light_opacity_and_roughness() {
    let list = || {
        vec![
            p("DiffuseColor", &[0.5, 1.0, 0.0]),
            p("DiffuseFactor", &[0.5]),
            p("EmissiveColor", &[1.0, 0.0, 0.0]),
            p("EmissiveFactor", &[0.25]),
            p("SpecularColor", &[1.0, 1.0, 1.0]),
            p("ShininessExponent", &[30.0]),
            p("TransparentColor", &[1.0, 1.0, 1.0]),
            p("TransparencyFactor", &[0.25]),
        ]
    };
    let (material, messages) = material("Maya", list(), &[]);
    assert!(messages.is_empty(), "{messages:?}");
    assert_eq!(material.base_color, [srgb_to_linear(0.5) * 0.5, 0.5, 0.0, 0.75]);
    assert_eq!((material.emissive, material.alpha_mode), ([0.25, 0.0, 0.0], AlphaMode::Blend));
    assert_eq!(roughness(&material), [0.0, 0.5]);
    // Blender's are linear, and its exponent and reflection are those of its own material.
    let blender = vec![
        p("DiffuseColor", &[0.5, 1.0, 0.0]),
        p("ShininessExponent", &[25.0]),
        p("ReflectionFactor", &[0.75]),
    ];
    let (material, _) = self::material("Blender (stable FBX IO) - 4.2", blender, &[]);
    assert_eq!((material.base_color, roughness(&material)), ([0.5, 1.0, 0.0, 1.0], [0.75, 0.5]));
    let (material, messages) = self::material("Maya", vec![p("Opacity", &[0.0])], &[]);
    assert_eq!((material.base_color[3], material.alpha_mode), (1.0, AlphaMode::Opaque));
    assert_eq!(messages, ["FBX: material 'mat' is wholly transparent as written: drawn opaque"]);
}

#[test]
fn physically_based_materials_are_known_by_their_properties() {
    let stingray = vec![
        p("Maya|base_color", &[0.5, 0.25, 0.0]),
        p("Maya|metallic", &[0.75]),
        p("Maya|roughness", &[0.25]),
        p("Maya|use_color_map", &[0.0]),
        p("Maya|emissive", &[1.0, 0.5, 0.0]),
        p("Maya|emissive_intensity", &[2.0]),
    ];
    let (material, messages) = material("Maya", stingray, &["Maya|TEX_color_map"]);
    assert!(messages.is_empty(), "{messages:?}");
    assert_eq!((material.base_color, roughness(&material)), ([0.5, 0.25, 0.0, 1.0], [0.75, 0.25]));
    assert_eq!((material.emissive, material.base_color_texture), ([2.0, 1.0, 0.0], None));
    let physical = vec![
        p("3dsMax|Parameters|base_color", &[0.5, 0.25, 0.0, 1.0]),
        p("3dsMax|Parameters|base_weight", &[0.5]),
        p("3dsMax|Parameters|roughness", &[0.25]),
        p("3dsMax|Parameters|roughness_inv", &[1.0]),
        p("3dsMax|Parameters|coating", &[0.5]),
        p("3dsMax|Parameters|trans_ior", &[1.75]),
    ];
    let (material, _) = self::material("3ds Max", physical.clone(), &[]);
    assert_eq!((material.base_color, roughness(&material)), ([0.25, 0.125, 0.0, 1.0], [0.0, 0.75]));
    assert_eq!((material.coat, material.ior), (0.5, 1.75));
    let maps = ["base_color_map", "metalness_map", "bump_map", "sss_color_map"]
        .map(|name| format!("3dsMax|Parameters|{name}"));
    let (material, messages) = self::material("3ds Max", physical, &maps.each_ref().map(String::as_str));
    assert_eq!(
        messages,
        ["FBX: textures of material 'mat' have no effect: those for '3dsMax|Parameters|sss_color_map'"]
    );
    assert_eq!((material.base_color, roughness(&material)[0]), ([0.5, 0.5, 0.5, 1.0], 1.0));
    assert!(material.base_color_texture.is_some() && material.normal_texture.is_some());
    let arnold = vec![p("Maya|baseColor", &[0.5, 0.5, 0.5]), p("Maya|specularRoughness", &[0.125])];
    assert_eq!(roughness(&self::material("Maya", arnold, &[]).0), [0.0, 0.125]);
}

#[test]
fn pictures_are_in_the_file_or_beside_it() {
    let (material, messages) = material("Maya", vec![], &["DiffuseColor", "TransparentColor"]);
    assert!(messages.is_empty() && material.base_color_texture.is_some(), "{messages:?}");
    let video = |content: Vec<u8>| {
        let objects = vec![
            square(1, normals_and_uvs()),
            model(2, "m", vec![]),
            object("Material", 3, "mat", "", vec![]),
            object("Texture", 4, "t", "", vec![one("FileName", s("gone.png"))]),
            object("Video", 5, "v", "Clip", vec![one("Content", V::R(content))]),
        ];
        let links =
            vec![connection(1, 2), connection(3, 2), to_property(4, 3, "DiffuseColor"), connection(5, 4)];
        file(vec![], objects, links)
    };
    for bytes in [binary(&video(png()), 7400, false), text(&video(png())).into_bytes()] {
        let loaded = load(&bytes, Format::Fbx).unwrap();
        assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
        assert!(loaded.scene.materials()[0].base_color_texture.is_some());
    }
    // A text that is cut in two, without a comma.
    let mut cut = text(&video(png()));
    let place = cut.find("\"iVBO").unwrap() + 10;
    cut.insert_str(place, "\"\n\"");
    assert!(load(cut.as_bytes(), Format::Fbx).unwrap().warnings.is_empty());
    let loaded = read(&video(vec![]));
    assert!(warnings(&loaded)[0].starts_with("FBX: texture 'gone.png' is left out"), "{:?}", loaded.warnings);
    attack(&binary(&video(png()), 7500, false), Format::Fbx);
}

#[test]
fn damage_is_named() {
    let mut records = plain();
    records[2].2[0].2[1] = integers("PolygonVertexIndex", &[0, 1, 2, !3, 0, 1, !9, 2]);
    let loaded = read(&records);
    assert_eq!(warnings(&loaded), ["FBX: 2 polygons left out: vertices missing, not finite or beyond 1e15"]);
    assert_eq!(loaded.scene.triangle_count(), 2);
    let whole = binary(&plain(), 7400, false);
    let message = |bytes: &[u8]| load(bytes, Format::Fbx).unwrap_err().to_string();
    assert_eq!(message(&whole[..700]), "FBX: it ends early: there is no list of connections");
    assert_eq!(message(&whole[..25]), "FBX: it ends within its head");
    let mut old = whole.clone();
    old[23..27].copy_from_slice(&5800_u32.to_le_bytes());
    assert_eq!(message(&old), "FBX: version 5800 is too old: versions from 6000 on are read");
    old[22] = 1;
    assert_eq!(message(&old), "FBX: the order of its bytes is big-endian");
    assert_eq!(message(b"; FBX\nObjects: {\n}\n"), "FBX: it does not say of which version it is");
}

/// Models that are below themselves, and records within records.
#[test]
fn cycles_and_depths_end() {
    let objects =
        vec![square(1, vec![]), model(2, "a", vec![]), model(3, "b", vec![]), model(4, "c", vec![])];
    let links = [(1, 2), (2, 3), (3, 2), (1, 4), (4, 4)];
    let loaded = read(&file(vec![], objects, links.map(|(from, to)| connection(from, to)).to_vec()));
    assert_eq!(warnings(&loaded)[0], "FBX: 3 models left out: below themselves, or moved too far");
    let mut deep = R("x", vec![], vec![]);
    for _ in 0..200 {
        deep = R("x", vec![], vec![deep, R("y", vec![V::I(1)], vec![])]);
    }
    for bytes in [binary(&[deep.clone()], 7400, false), text(&[deep.clone()]).into_bytes()] {
        // Records that are not read have no depth in a binary file.
        let records = R("Objects", vec![], vec![deep.clone()]);
        let bytes = if bytes.starts_with(b"K") { binary(&[records], 7400, false) } else { bytes };
        let result = load_beside(&bytes, Format::Fbx, &MemoryResolver::default(), &limits().with_depth(100));
        assert!(matches!(result, Err(LoadError::Limit(_))), "{result:?}");
    }
    // A texture of layers that are textures of layers has one layer at most.
    let objects = vec![
        square(1, vec![]),
        model(2, "m", vec![]),
        object("Material", 3, "mat", "", vec![]),
        object("LayeredTexture", 4, "l", "", vec![]),
    ];
    let links = vec![connection(1, 2), connection(3, 2), to_property(4, 3, "DiffuseColor"), connection(4, 4)];
    assert!(warnings(&read(&file(vec![], objects, links))).is_empty());
}

/// Arrays that unpack to more than the limits allow, and counts of what is not there.
#[test]
fn arrays_are_bounded() {
    let mut records = plain();
    records[2].2[0].2[0] = floats("Vertices", &vec![0.0; 1 << 22]);
    let bytes = binary(&records, 7400, true);
    assert!(bytes.len() < 1 << 20);
    assert!(matches!(load(&bytes, Format::Fbx), Err(LoadError::Limit(_))));
    let mut lying = binary(&plain(), 7400, false);
    let place = lying.windows(9).position(|window| window == b"Vertices\x64").unwrap() + 9;
    lying[place..place + 4].copy_from_slice(&u32::MAX.to_le_bytes());
    let loaded = load(&lying, Format::Fbx);
    assert!(loaded.is_ok_and(|loaded| warnings(&loaded)[0].contains("has records that do")));
}
