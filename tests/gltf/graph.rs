//! Nodes, instances, cameras and lights.

use crate::common::files::model::{F32, I8, Model, load_text, messages};
use overcoat::jobs::Jobs;
use overcoat::limits::Limits;
use overcoat::load::{Context, LoadError, load_bytes};
use overcoat::scene::{LightKind, Projection};
use serde_json::json;

/// Origins of the draws, in their order.
fn origins(model: &Model) -> Vec<[f64; 3]> {
    let scene = model.load().unwrap().scene;
    scene.instances().iter().map(|i| i.transform.point([0.0; 3])).collect()
}

#[test]
fn children_stand_in_their_parents() {
    let mut model = Model::triangle();
    // A quarter turn about +Y takes +X to -Z.
    let half = std::f64::consts::FRAC_1_SQRT_2;
    model.json["nodes"] = json!([
        {"mesh": 0, "translation": [0, 0, 1], "rotation": [0, half, 0, half], "scale": [2, 2, 2], "children": [2, 1]},
        {"mesh": 0, "translation": [0, 5, 0]},
        {"mesh": 0, "matrix": [1,0,0,0, 0,1,0,0, 0,0,1,0, 1,0,0,1]},
    ]);
    let found = origins(&model);
    let expected = [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0], [0.0, 10.0, 1.0]];
    for (a, b) in found.iter().flatten().zip(expected.iter().flatten()) {
        assert!((a - b).abs() < 1e-12, "{found:?}");
    }
}

#[test]
fn the_scene_to_draw() {
    let mut model = Model::triangle();
    model.json["nodes"] = json!([
        {"mesh": 0, "translation": [1, 0, 0]},
        {"mesh": 0, "translation": [2, 0, 0], "children": [2]},
        {"mesh": 0, "translation": [3, 0, 0]},
    ]);
    model.json["scenes"] = json!([{"nodes": [0]}, {"nodes": [1]}]);
    model.json["scene"] = 1.into();
    assert_eq!(origins(&model), [[2.0, 0.0, 0.0], [5.0, 0.0, 0.0]]);
    // The first one if none is named.
    model.json.as_object_mut().unwrap().remove("scene");
    assert_eq!(origins(&model), [[1.0, 0.0, 0.0]]);
    // All that is there if there is none.
    model.json.as_object_mut().unwrap().remove("scenes");
    assert_eq!(origins(&model), [[1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [5.0, 0.0, 0.0]]);
    model.json["scene"] = 4.into();
    model.json["scenes"] = json!([{"nodes": [0]}]);
    assert_eq!(model.warnings(), ["there is no scene 4: all nodes are drawn"]);
    assert_eq!(origins(&model).len(), 3);
}

/// A scene without a mesh is not what anybody wants to see of a file that has some.
#[test]
fn scenes_that_show_nothing() {
    let mut model = Model::triangle();
    model.json["nodes"] = json!([{}, {"children": [2]}, {"mesh": 0, "translation": [3, 0, 0]}]);
    model.json["scenes"] = json!([{"nodes": [0]}, {}, {"nodes": [1]}]);
    assert_eq!(origins(&model), [[3.0, 0.0, 0.0]]);
    assert_eq!(model.warnings(), ["scene 0 shows no mesh: scene 2 is drawn"]);
    model.json["scenes"] = json!([{"nodes": [0]}]);
    assert_eq!(origins(&model), [[3.0, 0.0, 0.0]]);
    assert_eq!(model.warnings(), ["scene 0 shows no mesh: all nodes are drawn"]);
    // A library of meshes that other programs place.
    let document = model.json.as_object_mut().unwrap();
    for key in ["nodes", "scenes", "scene"] {
        document.remove(key);
    }
    assert_eq!(origins(&model), [[0.0; 3]]);
    assert_eq!(model.warnings(), ["no node shows a mesh: 1 meshes are drawn at the origin"]);
}

#[test]
fn hidden_nodes_hide_their_children() {
    let mut model = Model::triangle();
    model.json["nodes"] = json!([
        {"children": [1, 2]},
        {"mesh": 0, "extensions": {"KHR_node_visibility": {"visible": false}}, "children": [3]},
        {"mesh": 0, "extensions": {"KHR_node_visibility": {"visible": true}}, "translation": [1, 0, 0]},
        {"mesh": 0},
    ]);
    assert_eq!(origins(&model), [[1.0, 0.0, 0.0]]);
}

#[test]
fn nodes_form_a_tree() {
    let mut model = Model::triangle();
    for (nodes, at) in [
        (json!([{"mesh": 0, "children": [0]}]), "node 0"),
        (
            json!([{"mesh": 0, "children": [1]}, {"name": "b", "children": [2]}, {"children": [1]}]),
            "node 1 'b'",
        ),
        (json!([{"mesh": 0, "children": [1, 2]}, {"children": [3]}, {"children": [3]}, {}]), "node 3"),
        (json!([{"children": [1, 1]}, {"mesh": 0}]), "node 1"),
    ] {
        model.json["nodes"] = nodes;
        assert_eq!(
            model.warnings(),
            [format!("{at} is reached twice and drawn once: nodes must form a tree")]
        );
        assert_eq!(origins(&model).len(), 1);
    }
    model.json["nodes"] = json!([{"mesh": 0, "children": [9]}]);
    assert_eq!(model.warnings(), ["node 0: there is no node 9"]);
    // A root that is a child too stands where its parent puts it.
    model.json["nodes"] = json!([{"children": [1], "translation": [3, 0, 0]}, {"mesh": 0}]);
    model.json["scenes"] = json!([{"nodes": [1, 0]}]);
    assert_eq!(origins(&model), [[3.0, 0.0, 0.0]]);
    assert_eq!(model.warnings(), ["1 nodes are roots of the scene and children too, the first node 1"]);
}

/// A chain of 200,000 nodes: refused by the limit, and drawn without it; in neither case by recursion.
#[test]
fn deep_chains() {
    let count = 200_000;
    let chain: Vec<String> = (1..count).map(|k| format!("{{\"children\":[{k}]}}")).collect();
    let text = format!(
        "{{\"asset\":{{\"version\":\"2.0\"}},\"scenes\":[{{\"nodes\":[0]}}],\"nodes\":[{},{{}}]}}",
        chain.join(",")
    );
    let error = load_text(&text, &Limits::default()).unwrap_err();
    assert!(matches!(error, LoadError::Limit(_)));
    assert_eq!(error.to_string(), "depth of node 1024: 1025 exceeds the limit of 1024 (depth)");
    let limits = Limits::default().with_depth(count);
    assert_eq!(messages(&load_text(&text, &limits).unwrap()), ["no triangles"]);
    let limits = limits.with_nodes(count - 1);
    assert_eq!(
        load_text(&text, &limits).unwrap_err().to_string(),
        "nodes: 200000 exceeds the limit of 199999 (nodes)"
    );
}

#[test]
fn transforms_must_stay_finite() {
    let mut model = Model::triangle();
    model.json["nodes"] =
        json!([{"name": "big", "scale": [1e300, 1, 1], "children": [1]}, {"scale": [1e300, 1, 1]}]);
    assert_eq!(model.error(), "node 1: transform is not a finite number");
    model.json["nodes"] = json!([{"name": "far", "mesh": 0, "translation": [1e30, 0, 0]}]);
    // Its own place is where everything is measured from.
    assert_eq!(model.load().unwrap().scene.origin(), [1e30, 0.0, 0.0]);
}

#[test]
fn gpu_instancing() {
    let mut model = Model::triangle();
    let translation = model.floats("VEC3", &[1.0, 0.0, 0.0, 0.0, 2.0, 0.0]);
    let rotation = model.accessor("VEC4", I8, 2, &[0, 0, 0, 127, 0, 0, 127, 0]);
    model.json["accessors"][rotation]["normalized"] = true.into();
    let scale = model.floats("VEC3", &[1.0, 1.0, 1.0, 3.0, 3.0, 3.0]);
    let attributes = json!({"TRANSLATION": translation, "ROTATION": rotation, "SCALE": scale, "_ID": 0});
    let extension = json!({"EXT_mesh_gpu_instancing": {"attributes": attributes}});
    model.json["nodes"] = json!([{"mesh": 0, "translation": [10, 0, 0], "extensions": extension}]);
    let scene = model.load().unwrap().scene;
    let points = |p: [f64; 3]| scene.instances().iter().map(|i| i.transform.point(p)).collect::<Vec<_>>();
    assert_eq!(points([0.0; 3]), [[11.0, 0.0, 0.0], [10.0, 2.0, 0.0]]);
    // The second is turned by 180 degrees about z and three times as large.
    assert_eq!(points([1.0, 0.0, 0.0]), [[12.0, 0.0, 0.0], [7.0, 2.0, 0.0]]);
    assert_eq!(scene.triangle_count(), 2);

    model.json["accessors"][scale]["count"] = 1.into();
    let complaint = "node 0 is drawn once: node 0, EXT_mesh_gpu_instancing: its attributes differ in length";
    assert_eq!(model.warnings(), [complaint]);
    // A number that no bytes stand behind.
    for k in [translation, rotation, scale] {
        model.json["accessors"][k] =
            json!({"componentType": F32, "count": 4_000_000_000_u64, "type": "VEC3"});
    }
    assert!(model.error().contains("4000000000 instances") && model.error().contains("decoded_bytes"));
}

#[test]
fn cameras_in_world_space() {
    let mut model = Model::triangle();
    let half = std::f64::consts::FRAC_1_SQRT_2;
    model.json["cameras"] = json!([
        {"type": "perspective", "perspective": {"yfov": 0.5, "znear": 0.1, "zfar": 3.0}},
        {"name": "plan", "type": "orthographic", "orthographic": {"xmag": 2, "ymag": 3, "znear": 0, "zfar": 9}},
        {"type": "perspective"},
    ]);
    model.json["nodes"] = json!([
        {"mesh": 0, "children": [1, 2, 3]},
        // A quarter turn about +Y: looks to -X.
        {"camera": 0, "translation": [5, 1, 0], "rotation": [0, half, 0, half]},
        {"camera": 1, "scale": [2, 2, 2]},
        {"camera": 2},
    ]);
    let loaded = model.load().unwrap();
    let [a, b] = loaded.scene.cameras() else { panic!("{:?}", loaded.scene.cameras()) };
    assert_eq!((a.eye, a.near, a.projection), ([5.0, 1.0, 0.0], 0.1, Projection::Perspective { fov_y: 0.5 }));
    let back = a.axes().unwrap()[2];
    assert!((back[0] - 1.0).abs() < 1e-6 && back[1].abs() < 1e-6 && back[2].abs() < 1e-6, "{back:?}");
    assert_eq!(b.projection, Projection::Orthographic { height: 6.0 });
    assert_eq!(loaded.scene.camera_names(), ["", "plan"]);
    assert_eq!(messages(&loaded), ["camera 2 has no projection and is left out"]);
}

#[test]
fn lights_in_world_space() {
    let mut model = Model::triangle();
    model.json["extensionsUsed"] = json!(["KHR_lights_punctual"]);
    model.json["extensions"] = json!({"KHR_lights_punctual": {"lights": [
        {"type": "directional", "intensity": 3.5, "color": [1, 0.5, 0]},
        {"type": "point", "intensity": 40, "range": 7},
        {"type": "spot", "spot": {"innerConeAngle": 0, "outerConeAngle": 1.0471975511965976}},
        {"type": "spot"},
        {"type": "area", "name": "soft"},
        {"type": "point", "intensity": -1},
    ]}});
    let light = |k: u32| json!({"KHR_lights_punctual": {"light": k}});
    model.json["nodes"] = json!([
        {"mesh": 0, "translation": [1, 2, 3], "scale": [5, 5, 5], "children": [1, 2, 3, 4, 5, 6, 7],
         "extensions": light(0)},
        {"extensions": light(1)}, {"extensions": light(2)}, {"extensions": light(3)}, {"extensions": light(4)},
        {"extensions": light(5)}, {"extensions": light(77)}, {"extensions": light(0), "scale": [0, 0, 0]},
    ]);
    let loaded = model.load().unwrap();
    let lights = loaded.scene.lights();
    assert_eq!(lights.len(), 5);
    assert_eq!((lights[0].intensity, lights[0].color), (3.5, [1.0, 0.5, 0.0]));
    assert_eq!(lights[0].kind, LightKind::Directional { direction: [0.0, 0.0, -1.0] });
    assert_eq!(lights[1].kind, LightKind::Point { position: [1.0, 2.0, 3.0], range: Some(7.0) });
    let LightKind::Spot { position, direction, range, inner_cone_cosine, outer_cone_cosine } = lights[2].kind
    else {
        panic!()
    };
    assert_eq!((position, direction, range), ([1.0, 2.0, 3.0], [0.0, 0.0, -1.0], None));
    assert_eq!(inner_cone_cosine, 1.0);
    assert!((outer_cone_cosine - 0.5).abs() < 1e-6);
    let LightKind::Spot { outer_cone_cosine, .. } = lights[3].kind else { panic!() };
    assert!((outer_cone_cosine - std::f32::consts::FRAC_1_SQRT_2).abs() < 1e-6);
    assert_eq!(lights[4].intensity, 0.0);
    assert_eq!(
        messages(&loaded),
        [
            "light 4 'soft' of unknown type 'area' is left out",
            "light 5: intensity or colour out of range, clamped",
            "node 6: there is no light 77",
            "light 0 is scaled to nothing and is left out",
        ]
    );
}

/// The same scene and the same warnings for any number of threads.
#[test]
fn threads_do_not_show() {
    let mut model = Model::textured();
    let position = model.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"].clone();
    let bad = model.floats("VEC3", &[f32::NAN; 9]);
    let meshes: Vec<_> = (0..40)
        .map(|k| {
            let uv = model.floats("VEC2", &[k as f32; 6]);
            let attributes = json!({"POSITION": position, "NORMAL": bad, "TEXCOORD_0": uv});
            json!({"primitives": [{"attributes": attributes, "material": k % 3}]})
        })
        .collect();
    model.json["meshes"] = meshes.into();
    model.json["images"] = json!([{"bufferView": 2}, {"uri": "lost.png"}, {"uri": "none.png"}]);
    model.json["textures"] = json!([{"source": 0}, {"source": 1}, {"source": 2}]);
    let material = |k: u32| json!({"name": k.to_string(), "emissiveTexture": {"index": k}, "normalTexture": {"index": 0}});
    model.json["materials"] = json!([material(0), material(1), material(2)]);
    model.json["nodes"] = (0..40).map(|k| json!({"mesh": k})).collect();
    model.json["scenes"] = json!([{"nodes": (0..40).collect::<Vec<_>>()}]);
    let file = model.glb();
    let shown = |threads: usize| {
        let (limits, jobs) = (Limits::default(), Jobs::new(threads));
        let context = Context { resolver: &model.files, limits: &limits, jobs: &jobs };
        let loaded = load_bytes(&file, None, &context).unwrap();
        assert_eq!(loaded.scene.meshes().len(), 40);
        format!("{loaded:?}")
    };
    let one = shown(1);
    assert!(one.contains("none.png") && one.contains("not finite"));
    for threads in [2, 3, 7] {
        assert!(shown(threads) == one, "{threads} threads");
    }
}

/// Avatars of VRM 0 face -Z, those of VRM 1 face +Z as glTF does; whichever it is, they face +Z in the scene.
#[test]
fn avatars_of_vrm_0_are_turned() {
    let with = |extensions: &[&str], own: serde_json::Value| {
        let mut model = Model::triangle();
        model.json["nodes"] = json!([{"mesh": 0, "translation": [1, 2, 3], "camera": 0}]);
        model.json["cameras"] = json!([{"type": "perspective", "perspective": {"yfov": 0.5, "znear": 0.1}}]);
        model.json["extensionsUsed"] = json!(extensions);
        model.json["extensions"] = own;
        let scene = model.load().unwrap().scene;
        let eye = scene.cameras()[0].eye;
        (scene.orientation(), scene.instances()[0].transform.point([0.0; 3]), eye)
    };
    for (extensions, own, is_turned) in [
        (&["VRM"][..], json!({"VRM": {"specVersion": "0.0"}}), true),
        (&["VRM"], json!({}), true),
        (&[], json!({"VRM": {}}), true),
        (&["VRMC_vrm"], json!({"VRMC_vrm": {"specVersion": "1.0"}}), false),
        (&["VRM", "VRMC_vrm"], json!({"VRM": {}, "VRMC_vrm": {}}), false),
        (&[], json!({}), false),
    ] {
        let (orientation, place, eye) = with(extensions, own);
        assert_eq!(orientation.is_turned, is_turned, "{extensions:?}");
        assert_eq!(orientation.front().name(), if is_turned { "-z" } else { "+z" });
        let expected = if is_turned { [-1.0, 2.0, -3.0] } else { [1.0, 2.0, 3.0] };
        assert_eq!((place, eye.map(f64::from)), (expected, expected), "{extensions:?}");
    }
}
