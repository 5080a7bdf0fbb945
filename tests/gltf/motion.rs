//! Skins, morph targets and animations.

use crate::common::files::model::{F32, Model, U8, U16, U32, messages};
use overcoat::jobs::Jobs;
use overcoat::limits::Limits;
use overcoat::load::{
    AnimatedModel, AnimationChoice, Context, LoadError, LoadOptions, Loaded, load_bytes_with,
};
use overcoat::scene::{LightKind, Projection, Scene};
use serde_json::json;

const HALF: f64 = std::f64::consts::FRAC_1_SQRT_2;

fn options(animation: &str, time: f64, repeat: bool) -> LoadOptions {
    let animation = Some(AnimationChoice { name: animation.to_owned(), time, repeat });
    LoadOptions::default().with_animation(animation)
}

fn play(model: &Model, animation: &str, time: f64) -> Result<Loaded, LoadError> {
    let (limits, jobs) = (Limits::default(), Jobs::new(1));
    let context = Context { resolver: &model.files, limits: &limits, jobs: &jobs };
    load_bytes_with(&model.glb(), None, &options(animation, time, false), &context)
}

/// World-space positions of all vertices.
fn points(scene: &Scene) -> Vec<[f64; 3]> {
    let of = |i: &overcoat::scene::Instance| {
        let mesh = &scene.meshes()[i.mesh.index()];
        mesh.positions().iter().map(|p| i.transform.point(p.map(f64::from))).collect::<Vec<_>>()
    };
    scene.instances().iter().flat_map(of).collect()
}

#[track_caller]
fn assert_near(found: &[[f64; 3]], expected: &[[f64; 3]]) {
    assert_eq!(found.len(), expected.len());
    for (a, b) in found.as_flattened().iter().zip(expected.as_flattened()) {
        assert!((a - b).abs() < 1e-5, "{found:?} is not {expected:?}");
    }
}

/// A strip of two quads along +Y, 0 to 2. The lower joint stands at the origin, the upper one at y = 1; vertices at
/// y = 1 follow both. Bound where it stands.
fn strip() -> Model {
    let mut model = Model::empty();
    let positions: Vec<f32> = (0..3).flat_map(|k| [-0.5, k as f32, 0.0, 0.5, k as f32, 0.0]).collect();
    let position = model.floats("VEC3", &positions);
    let normal = model.floats("VEC3", &[0.0, 0.0, 1.0].repeat(6));
    let joints = model.accessor("VEC4", U8, 6, &[0, 1, 9, 9].repeat(6));
    let weights = [[1.0, 0.0, 0.0, 0.0], [0.5, 0.5, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0_f32]];
    let weights = model.floats("VEC4", &weights.iter().flat_map(|w| [*w, *w]).flatten().collect::<Vec<_>>());
    let indices = model.accessor("SCALAR", U8, 12, &[0, 1, 3, 0, 3, 2, 2, 3, 5, 2, 5, 4]);
    let mut inverse = [0.0_f32; 32];
    for k in 0..4 {
        inverse[5 * k] = 1.0;
        inverse[16 + 5 * k] = 1.0;
    }
    inverse[16 + 13] = -1.0;
    let bytes: Vec<u8> = inverse.iter().flat_map(|v| v.to_le_bytes()).collect();
    let inverse = model.accessor("MAT4", F32, 2, &bytes);
    let attributes =
        json!({"POSITION": position, "NORMAL": normal, "JOINTS_0": joints, "WEIGHTS_0": weights});
    model.json["meshes"] = json!([{"primitives": [{"attributes": attributes, "indices": indices}]}]);
    model.json["nodes"] = json!([
        // The node's own transform has no influence.
        {"mesh": 0, "skin": 0, "translation": [100, 0, 0], "scale": [3, 3, 3]},
        {"name": "lower", "children": [2]},
        {"name": "upper", "translation": [0, 1, 0]},
    ]);
    model.json["skins"] = json!([{"joints": [1, 2], "inverseBindMatrices": inverse}]);
    model.json["scenes"] = json!([{"nodes": [0, 1]}]);
    model
}

#[test]
fn a_strip_bends_at_its_joint() {
    let mut model = strip();
    let still = model.load().unwrap();
    assert!(messages(&still).is_empty(), "{:?}", still.warnings);
    let straight: Vec<[f64; 3]> =
        (0..3).flat_map(|k| [[-0.5, f64::from(k), 0.0], [0.5, f64::from(k), 0.0]]).collect();
    assert_near(&points(&still.scene), &straight);
    // A quarter turn of the upper joint about +X takes +Y to +Z.
    model.json["nodes"][2]["rotation"] = json!([HALF, 0, 0, HALF]);
    let bent = model.load().unwrap().scene;
    let expected = [
        [-0.5, 0.0, 0.0],
        [0.5, 0.0, 0.0],
        [-0.5, 1.0, 0.0],
        [0.5, 1.0, 0.0],
        [-0.5, 1.0, 1.0],
        [0.5, 1.0, 1.0],
    ];
    assert_near(&points(&bent), &expected);
    // Normals: +Z below, -Y above, between them at the bend.
    let mesh = &bent.meshes()[0];
    let h = std::f32::consts::FRAC_1_SQRT_2;
    for (k, expected) in [(0, [0.0, 0.0, 1.0]), (2, [0.0, -h, h]), (4, [0.0, -1.0, 0.0])] {
        let found = mesh.normals()[k];
        assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-6), "{k}: {found:?}");
    }
    assert!(bent.bounds().within(2.0), "the picture is framed around what is drawn");
    // The strip follows the whole skeleton.
    model.json["nodes"][1]["translation"] = json!([0, 0, 5]);
    assert_near(&points(&model.load().unwrap().scene), &expected.map(|[x, y, z]| [x, y, z + 5.0]));
}

#[test]
fn joints_may_be_in_no_scene_and_matrices_may_be_missing() {
    let mut model = strip();
    model.json["scenes"] = json!([{"nodes": [0]}]);
    model.json["nodes"][1]["translation"] = json!([0, 0, 5]);
    assert_near(&points(&model.load().unwrap().scene)[4..5], &[[-0.5, 2.0, 5.0]]);
    // Without inverse bind matrices: identities, so the upper half stands one metre higher.
    model.json["skins"] = json!([{"joints": [1, 2]}]);
    let found = points(&model.load().unwrap().scene);
    assert_near(&[found[0], found[2], found[4]], &[[-0.5, 0.0, 5.0], [-0.5, 1.5, 5.0], [-0.5, 3.0, 5.0]]);
}

#[test]
fn mirrored_skeletons_show_their_outside() {
    let mut model = strip();
    model.json["nodes"][1]["scale"] = json!([-1, 1, 1]);
    let scene = model.load().unwrap().scene;
    let mesh = &scene.meshes()[0];
    for t in mesh.triangles() {
        let [a, b, c] = t.map(|v| mesh.positions()[v as usize]);
        let area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        assert!(area > 0.0, "{t:?} faces backwards");
    }
    assert!(mesh.normals().iter().all(|n| n[2] > 0.99));
}

/// Each skin, and each node with weights of its own, has its own mesh; nodes that share both share it.
#[test]
fn meshes_under_different_skins_are_different() {
    let mut model = strip();
    model.json["nodes"] = json!([
        {"mesh": 0, "skin": 0}, {"name": "lower", "children": [2]}, {"name": "upper", "translation": [0, 1, 0]},
        {"mesh": 0, "skin": 1}, {"mesh": 0, "skin": 0}, {"mesh": 0, "translation": [7, 0, 0]},
        {"translation": [0, 0, 9]},
    ]);
    let matrices = model.json["skins"][0]["inverseBindMatrices"].clone();
    model.json["skins"] = json!([{"joints": [1, 2], "inverseBindMatrices": matrices}, {"joints": [6, 6]}]);
    model.json["scenes"] = json!([{"nodes": [0, 1, 3, 4, 5, 6]}]);
    let scene = model.load().unwrap().scene;
    let meshes: Vec<usize> = scene.instances().iter().map(|i| i.mesh.index()).collect();
    // The one without a skin is the stored one.
    assert_eq!(meshes, [1, 2, 1, 0]);
    let all = points(&scene);
    assert_near(&[all[0], all[6], all[18]], &[[-0.5, 0.0, 0.0], [-0.5, 0.0, 9.0], [6.5, 0.0, 0.0]]);
}

#[test]
fn weights_may_be_integers_and_in_several_sets() {
    let mut model = strip();
    let joints = model.accessor("VEC4", U16, 6, &[1, 0].repeat(24));
    // A quarter for each of two slots: 1/4 + 1/4 of the second set; the first set has 1 in sum.
    let weights = model.accessor("VEC4", U8, 6, &[128, 127, 0, 0].repeat(6));
    let primitive = model.primitive();
    primitive["attributes"]["JOINTS_1"] = joints.into();
    primitive["attributes"]["WEIGHTS_1"] = weights.into();
    model.json["nodes"][2]["translation"] = json!([0, 1, 4]);
    // Half of everything follows the upper joint beside what it followed before: 4 m along z.
    let found = points(&model.load().unwrap().scene);
    assert_near(&[found[0], found[2], found[4]], &[[-0.5, 0.0, 2.0], [-0.5, 1.0, 3.0], [-0.5, 2.0, 4.0]]);
}

#[test]
fn broken_skins_are_named() {
    let good = strip();
    let complaint = |change: &dyn Fn(&mut Model)| {
        let mut model = good.clone();
        change(&mut model);
        model.complaint()
    };
    assert_eq!(
        complaint(&|m| m.json["nodes"][0]["skin"] = 7.into()),
        "node 0 is drawn without its skin: there is no skin 7"
    );
    assert_eq!(
        complaint(&|m| m.json["skins"][0]["joints"] = json!([])),
        "node 0 is drawn without its skin: skin 0: it has no joints"
    );
    assert_eq!(
        complaint(&|m| m.json["skins"][0]["joints"][1] = 9.into()),
        "node 0 is drawn without its skin: skin 0: there is no node 9"
    );
    assert_eq!(
        complaint(&|m| m.json["skins"][0]["joints"] = json!([1, 2, 1])),
        "node 0 is drawn without its skin: skin 0: 2 inverse bind matrices for 3 joints"
    );
    let one_joint = complaint(&|m| m.json["skins"] = json!([{"joints": [1]}]));
    assert_eq!(
        one_joint,
        "mesh 0, primitive 0: joint 1 is out of range of 1 joints of skin 0; drawn without the skin"
    );
    // Joints that are their own ancestors, beside the scene.
    let cycle = complaint(&|m| {
        m.json["scenes"] = json!([{"nodes": [0]}]);
        m.json["nodes"][2]["children"] = json!([1]);
    });
    assert!(cycle.contains("is its own ancestor"), "{cycle}");
    let far = complaint(&|m| m.json["nodes"][1]["translation"] = json!([1e300, 0, 0]));
    assert!(far.is_empty() || far.contains("not a finite number"), "{far}");
    let floats = complaint(&|m| {
        let weights = m.json["meshes"][0]["primitives"][0]["attributes"]["WEIGHTS_0"].clone();
        m.primitive()["attributes"]["JOINTS_0"] = weights;
    });
    assert!(floats.contains("does not hold indices"), "{floats}");
}

#[test]
fn weights_that_are_none_are_repaired() {
    let mut model = strip();
    let bad = [f32::NAN, 1.0, 0.0, 0.0].repeat(6);
    let weights = model.floats("VEC4", &bad);
    model.primitive()["attributes"]["WEIGHTS_0"] = weights.into();
    let warnings = model.warnings();
    assert_eq!(
        warnings,
        ["mesh 0, primitive 0: weights of joints that are negative or not finite are taken as 0"]
    );
    let weights = model.floats("VEC4", &[0.0; 24]);
    model.primitive()["attributes"]["WEIGHTS_0"] = weights.into();
    assert!(model.warnings()[0].ends_with("vertices without weights follow the first joint of their skin"));
    let attributes = model.primitive()["attributes"].as_object_mut().unwrap();
    attributes.remove("JOINTS_0");
    assert!(model.warnings()[0].ends_with("has no joints and does not follow its skin"));
}

/// A triangle with two morph targets: one lifts its first corner by z, the other, sparse, moves its last by x.
fn morphing() -> Model {
    let mut model = Model::triangle();
    let lift = model.floats("VEC3", &[0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    let index = model.view(&[2]);
    let value = model.view(&2.0_f32.to_le_bytes().into_iter().chain([0; 8]).collect::<Vec<u8>>());
    let sparse = json!({"componentType": F32, "count": 3, "type": "VEC3", "sparse": {"count": 1,
        "indices": {"bufferView": index, "componentType": U8}, "values": {"bufferView": value}}});
    let shift = crate::common::files::model::push(&mut model.json["accessors"], sparse);
    model.primitive()["targets"] = json!([{"POSITION": lift}, {"POSITION": shift}]);
    model
}

#[test]
fn morph_targets_by_the_weights_of_mesh_and_node() {
    let mut model = morphing();
    let base = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    assert_near(&points(&model.load().unwrap().scene), &base);
    model.json["meshes"][0]["weights"] = json!([0.5, -1.0]);
    let moved = [[0.0, 0.0, 0.5], [1.0, 0.0, 0.0], [-2.0, 1.0, 0.0]];
    assert_near(&points(&model.load().unwrap().scene), &moved);
    model.json["nodes"] = json!([
        {"mesh": 0, "translation": [0, 0, 3]}, {"mesh": 0}, {"mesh": 0, "weights": [0, 0]}, {"mesh": 0, "weights": [2]},
    ]);
    model.json["scenes"] = json!([{"nodes": [0, 1, 2, 3]}]);
    let scene = model.load().unwrap().scene;
    // Nodes without weights of their own share a mesh; weights of 0 are the stored mesh.
    let meshes: Vec<usize> = scene.instances().iter().map(|i| i.mesh.index()).collect();
    assert_eq!(meshes, [1, 1, 0, 2]);
    let all = points(&scene);
    assert_near(
        &[all[0], all[3], all[6], all[9]],
        &[[0.0, 0.0, 3.5], [0.0, 0.0, 0.5], [0.0, 0.0, 0.0], [0.0, 0.0, 2.0]],
    );
}

/// Normals, tangents, texture coordinates and colours move as well; a mesh without normals is flat in every pose.
#[test]
fn everything_of_a_vertex_is_displaced() {
    let mut model = Model::triangle();
    let up = model.floats("VEC3", &[0.0, 0.0, 1.0].repeat(3));
    let tangent = model.floats("VEC4", &[1.0, 0.0, 0.0, -1.0].repeat(3));
    let uv = model.floats("VEC2", &[0.0, 0.0, 1.0, 0.0, 0.0, 1.0]);
    let color = model.floats("VEC3", &[0.25; 9]);
    let normal_by = model.floats("VEC3", &[1.0, 0.0, 0.0].repeat(3));
    let tangent_by = model.floats("VEC3", &[0.0, 0.0, -1.0].repeat(3));
    let uv_by = model.floats("VEC2", &[0.5, 0.25].repeat(3));
    let color_by = model.floats("VEC3", &[0.5, 2.0, -1.0].repeat(3));
    let attributes = &mut model.primitive()["attributes"];
    attributes["NORMAL"] = up.into();
    attributes["TANGENT"] = tangent.into();
    attributes["TEXCOORD_0"] = uv.into();
    attributes["COLOR_0"] = color.into();
    model.primitive()["targets"] =
        json!([{"NORMAL": normal_by, "TANGENT": tangent_by, "TEXCOORD_0": uv_by, "COLOR_0": color_by}]);
    model.json["meshes"][0]["weights"] = json!([1]);
    let scene = model.load().unwrap().scene;
    let mesh = &scene.meshes()[0];
    let h = std::f32::consts::FRAC_1_SQRT_2;
    assert!(mesh.normals()[1].iter().zip([h, 0.0, h]).all(|(a, b)| (a - b).abs() < 1e-6));
    assert!(mesh.tangents()[1].iter().zip([h, 0.0, -h, -1.0]).all(|(a, b)| (a - b).abs() < 1e-6));
    assert_eq!(mesh.uvs(0)[1], [1.5, 0.25]);
    assert_eq!(mesh.colors()[1], [0.75, 1.0, 0.0, 1.0]);
    assert!(morphing().load().unwrap().scene.meshes()[0].normals().is_empty());
}

#[test]
fn broken_displacements() {
    let mut model = morphing();
    model.json["meshes"][0]["weights"] = json!([1, 0]);
    let bad = model.floats("VEC3", &[f32::NAN; 9]);
    model.primitive()["targets"][0]["POSITION"] = bad.into();
    let said = model.warnings();
    assert!(
        said[0].ends_with("displacements of morph targets that are not finite are taken as 0"),
        "{said:?}"
    );
    let short = model.floats("VEC3", &[0.0; 6]);
    model.primitive()["targets"][0]["POSITION"] = short.into();
    assert_eq!(
        model.warnings(),
        ["mesh 0, primitive 0: its vertices do not move: target 0, POSITION has 2 elements for 3 vertices"]
    );
    // A target that no weight makes visible is not looked at.
    model.json["meshes"][0]["weights"] = json!([0, 1]);
    assert!(model.warnings().is_empty());
}

/// Many nodes with weights of their own are as many meshes, and each target is work: both are within the limits.
#[test]
fn poses_are_within_the_limits() {
    let mut model = morphing();
    model.json["nodes"] = (0..100).map(|_| json!({"mesh": 0, "weights": [1, 1]})).collect();
    model.json["scenes"] = json!([{"nodes": (0..100).collect::<Vec<_>>()}]);
    let vertices = 3 + 100 * 3 * 3;
    model.load_within(&Limits::default().with_vertices(vertices)).unwrap();
    let error = model.load_within(&Limits::default().with_vertices(vertices - 1)).unwrap_err();
    assert!(
        matches!(error, LoadError::Limit(_)) && error.to_string().contains("vertices in poses"),
        "{error}"
    );
}

/// Adds an animation with one channel, with times and values as given.
fn animate(
    model: &mut Model,
    target: serde_json::Value,
    times: &[f32],
    kind: &str,
    values: &[f32],
    how: &str,
) {
    let input = model.floats("SCALAR", times);
    let output = model.floats(kind, values);
    let animation = json!({
        "name": "move",
        "channels": [{"sampler": 0, "target": target}],
        "samplers": [{"input": input, "output": output, "interpolation": how}],
    });
    match model.json.get_mut("animations") {
        Some(list) => list.as_array_mut().unwrap().push(animation),
        None => model.json["animations"] = json!([animation]),
    }
}

#[test]
fn a_bone_turns_over_time() {
    let mut model = strip();
    let quarter = [0.0, 0.0, 0.0, 1.0, HALF as f32, 0.0, 0.0, HALF as f32];
    animate(&mut model, json!({"node": 2, "path": "rotation"}), &[1.0, 3.0], "VEC4", &quarter, "LINEAR");
    let top = |time: f64| points(&play(&model, "move", time).unwrap().scene)[4];
    for (time, degrees) in [(0.0, 0.0), (1.0, 0.0), (2.0, 45.0), (2.5, 67.5), (3.0, 90.0)] {
        let (s, c) = overcoat_core::math::double::sin_cos(f64::to_radians(degrees));
        assert_near(&[top(time)], &[[-0.5, 1.0 + c, s]]);
    }
    // Without a choice nothing moves, and nothing is missed.
    let still = model.load().unwrap();
    assert_near(&points(&still.scene)[4..5], &[[-0.5, 2.0, 0.0]]);
    assert!(still.warnings.is_empty());
    let beyond = play(&model, "0", 99.0).unwrap();
    assert_eq!(messages(&beyond), ["animation 0 'move' ends at 3 s: its last pose is drawn"]);
    assert_near(&points(&beyond.scene)[4..5], &[top(3.0)]);
}

#[test]
fn a_model_is_read_once_for_all_times() {
    let mut model = strip();
    let values = [0.0, 1.0, 0.0, 0.0, 1.0, 4.0];
    animate(&mut model, json!({"node": 2, "path": "translation"}), &[0.0, 2.0], "VEC3", &values, "LINEAR");
    let (limits, jobs) = (Limits::default(), Jobs::new(2));
    let context = Context { resolver: &model.files, limits: &limits, jobs: &jobs };
    let bytes = model.glb();
    let open =
        |repeat| AnimatedModel::from_bytes(&bytes, None, &options("move", 0.0, repeat), &context).unwrap();
    let (once, repeated) = (open(false), open(true));
    assert_eq!((once.length(), once.animations().len()), (Some(2.0), 1));
    let info = &once.animations()[0];
    assert_eq!((info.name.as_str(), info.length, info.channels), ("move", Some(2.0), 1));
    let z = |model: &AnimatedModel, time: f64| points(&model.at(time, &jobs).unwrap().scene)[4][2];
    assert_eq!([0.0, 0.5, 2.0, 2.5].map(|t| z(&once, t)), [0.0, 1.0, 4.0, 4.0]);
    assert_eq!([0.0, 0.5, 2.5, 4.5].map(|t| z(&repeated, t)), [0.0, 1.0, 1.0, 1.0]);
    let loaded = play(&model, "move", 0.5).unwrap();
    assert_eq!(format!("{:?}", loaded), format!("{:?}", once.at(0.5, &jobs).unwrap()));
}

#[test]
fn weights_step_and_spline() {
    let mut model = morphing();
    // In-tangents, values, out-tangents of two weights: from 0 to 1 with flat ends, and constantly 0.
    let spline = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0];
    animate(&mut model, json!({"node": 0, "path": "weights"}), &[0.0, 1.0], "SCALAR", &spline, "CUBICSPLINE");
    animate(
        &mut model,
        json!({"node": 0, "path": "weights"}),
        &[0.0, 1.0],
        "SCALAR",
        &[0.25, 0.0, 1.0, 0.5],
        "STEP",
    );
    let z = |animation: &str, time: f64| points(&play(&model, animation, time).unwrap().scene)[0][2];
    // 3 u^2 - 2 u^3.
    for (time, expected) in [(0.0, 0.0), (0.25, 0.15625), (0.5, 0.5), (1.0, 1.0)] {
        assert!((z("0", time) - expected).abs() < 1e-6, "{time}");
    }
    assert_eq!([0.0, 0.999, 1.0].map(|t| z("1", t)), [0.25, 0.25, 1.0]);
}

/// KHR_animation_pointer: what is not of nodes.
#[test]
fn pointers_change_materials_lights_cameras_and_visibility() {
    let mut model = Model::textured();
    model.json["extensionsUsed"] =
        json!(["KHR_animation_pointer", "KHR_lights_punctual", "KHR_node_visibility"]);
    model.json["extensions"] =
        json!({"KHR_lights_punctual": {"lights": [{"type": "point", "intensity": 1}]}});
    model.json["cameras"] = json!([{"type": "perspective", "perspective": {"yfov": 0.5, "znear": 0.1}}]);
    model.json["nodes"] = json!([
        {"mesh": 0, "children": [1, 2, 3]},
        {"camera": 0}, {"extensions": {"KHR_lights_punctual": {"light": 0}}},
        {"mesh": 0, "extensions": {"KHR_node_visibility": {"visible": false}}},
    ]);
    let pointer =
        |path: &str| json!({"path": "pointer", "extensions": {"KHR_animation_pointer": {"pointer": path}}});
    let changes: [(&str, &str, &[f32]); 7] = [
        ("/materials/0/pbrMetallicRoughness/baseColorFactor", "VEC4", &[0.0, 0.5, 1.0, 1.0]),
        (
            "/materials/0/pbrMetallicRoughness/baseColorTexture/extensions/KHR_texture_transform/offset",
            "VEC2",
            &[0.5, 0.25],
        ),
        ("/materials/0/emissiveFactor", "VEC3", &[1.0, 0.0, 2.0]),
        ("/extensions/KHR_lights_punctual/lights/0/intensity", "SCALAR", &[7.0]),
        ("/cameras/0/perspective/yfov", "SCALAR", &[1.0]),
        ("/nodes/3/extensions/KHR_node_visibility/visible", "SCALAR", &[1.0]),
        ("/materials/0/extensions/KHR_materials_volume_scatter/transmissionFactor", "SCALAR", &[1.0]),
    ];
    let input = model.floats("SCALAR", &[0.0]);
    let (mut channels, mut samplers) = (Vec::new(), Vec::new());
    for (k, (path, kind, values)) in changes.into_iter().enumerate() {
        let output = model.floats(kind, values);
        channels.push(json!({"sampler": k, "target": pointer(path)}));
        samplers.push(json!({"input": input, "output": output}));
    }
    model.json["animations"] = json!([{"name": "all", "channels": channels, "samplers": samplers}]);
    let still = model.load().unwrap().scene;
    assert_eq!((still.instances().len(), still.materials()[0].base_color), (1, [1.0; 4]));
    let loaded = play(&model, "all", 0.0).unwrap();
    let scene = &loaded.scene;
    assert_eq!(scene.instances().len(), 2);
    let material = &scene.materials()[0];
    assert_eq!((material.base_color, material.emissive), ([0.0, 0.5, 1.0, 1.0], [1.0, 0.0, 1.0]));
    let offset = material.base_color_texture.unwrap().transform.rows.map(|row| row[2]);
    assert_eq!(offset, [0.5, 0.25]);
    assert_eq!(scene.lights()[0].intensity, 7.0);
    assert!(matches!(scene.lights()[0].kind, LightKind::Point { .. }));
    assert_eq!(scene.cameras()[0].projection, Projection::Perspective { fov_y: 1.0 });
    let said = messages(&loaded);
    assert_eq!(said.len(), 1, "{said:?}");
    assert!(said[0].contains("channel 6: the pointer '/materials/0/extensions/KHR_materials_volume_scatter"));
}

/// The triangle with a node at scale 0 that grows between second 1 and 2.
fn hidden() -> Model {
    let mut model = Model::triangle();
    model.json["nodes"][0]["scale"] = json!([0.0, 0.0, 0.0]);
    let scales = [0.0, 0.0, 0.0, 1.0, 1.0, 1.0];
    animate(&mut model, json!({"node": 0, "path": "scale"}), &[1.0, 2.0], "VEC3", &scales, "LINEAR");
    model
}

#[test]
fn where_the_rest_pose_shows_nothing_an_animation_does() {
    let model = hidden();
    let loaded = model.load().unwrap();
    assert_eq!(
        messages(&loaded),
        ["nothing is visible in the rest pose: animation 0 'move' at 2 s is drawn"]
    );
    assert_near(&points(&loaded.scene), &[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    // Whoever names a time gets it.
    let chosen = play(&model, "0", 1.5).unwrap();
    assert_near(&points(&chosen.scene), &[[0.0; 3], [0.5, 0.0, 0.0], [0.0, 0.5, 0.0]]);
    assert!(messages(&chosen).is_empty());

    // A file that is read for many times has no animation that was chosen.
    let (limits, jobs) = (Limits::default(), Jobs::new(1));
    let context = Context { resolver: &model.files, limits: &limits, jobs: &jobs };
    let read = AnimatedModel::from_bytes(&model.glb(), None, &LoadOptions::default(), &context).unwrap();
    assert_eq!((read.length(), read.animations().len()), (None, 1));
    assert_near(&points(&read.at(0.7, &jobs).unwrap().scene), &points(&loaded.scene));
}

#[test]
fn what_hides_the_rest_pose_may_be_visibility_weights_or_alpha() {
    let shown = |model: &Model, time: &str| {
        let loaded = model.load().unwrap();
        let expected =
            format!("nothing is visible in the rest pose: animation 0 'move' at {time} s is drawn");
        assert_eq!(messages(&loaded), [expected]);
    };
    let pointer =
        |path: &str| json!({"path": "pointer", "extensions": {"KHR_animation_pointer": {"pointer": path}}});
    let mut model = Model::triangle();
    model.json["nodes"][0]["extensions"] = json!({"KHR_node_visibility": {"visible": false}});
    let target = pointer("/nodes/0/extensions/KHR_node_visibility/visible");
    animate(&mut model, target, &[0.0, 1.0], "SCALAR", &[1.0, 0.0], "STEP");
    shown(&model, "0");

    let mut model = Model::triangle();
    model.primitive()["material"] = 0.into();
    model.json["materials"] =
        json!([{"alphaMode": "BLEND", "pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1, 0]}}]);
    let target = pointer("/materials/0/pbrMetallicRoughness/baseColorFactor");
    let colors = [1.0, 1.0, 1.0, 0.0, 1.0, 1.0, 1.0, 1.0];
    animate(&mut model, target, &[0.0, 0.5], "VEC4", &colors, "LINEAR");
    shown(&model, "0.5");

    // A rest pose that shows something is drawn, and so is that of a file that never shows anything.
    let mut model = hidden();
    model.json["nodes"] = json!([{"mesh": 0, "scale": [0, 0, 0]}, {"mesh": 0}]);
    model.json["scenes"][0]["nodes"] = json!([0, 1]);
    assert!(messages(&model.load().unwrap()).is_empty());
    let mut model = hidden();
    model.json["nodes"] = json!([{"children": [1]}, {"mesh": 0, "scale": [0, 0, 0]}]);
    assert!(messages(&model.load().unwrap()).is_empty());
}

#[test]
fn animations_that_there_are_not() {
    let mut model = strip();
    let error = |model: &Model, name: &str| play(model, name, 0.0).unwrap_err();
    assert_eq!(error(&model, "Walk").to_string(), "there is no animation 'Walk'; the file has none");
    animate(&mut model, json!({"node": 2, "path": "scale"}), &[0.0], "VEC3", &[1.0; 3], "LINEAR");
    animate(&mut model, json!({"node": 2, "path": "scale"}), &[0.0], "VEC3", &[1.0; 3], "LINEAR");
    model.json["animations"][1]["name"] = "a\nb".into();
    let found = error(&model, "2");
    assert!(matches!(found, LoadError::NoSuch(_)));
    assert_eq!(found.to_string(), "there is no animation '2'; the file has 0 'move', 1 'a?b'");
    // A name wins over a number.
    model.json["animations"][1]["name"] = "0".into();
    model.json["animations"][0]["channels"] = json!([]);
    assert!(messages(&play(&model, "0", 0.0).unwrap()).is_empty());
    assert_eq!(messages(&play(&model, "move", 0.0).unwrap()), ["animation 0 'move' changes nothing"]);
}

/// Animations that cannot be played are left out and named; nothing ends in a panic.
#[test]
fn hostile_animations() {
    let base = strip();
    let said = |change: &dyn Fn(&mut Model)| {
        let mut model = base.clone();
        animate(
            &mut model,
            json!({"node": 2, "path": "translation"}),
            &[0.0, 1.0, 2.0],
            "VEC3",
            &[0.0, 1.0, 0.0, 0.0, 2.0, 0.0, 0.0, 3.0, 0.0],
            "LINEAR",
        );
        change(&mut model);
        play(&model, "0", 1.0).map(|loaded| messages(&loaded).join("; "))
    };
    let sampler = |m: &mut Model, key: &str, value: serde_json::Value| {
        m.json["animations"][0]["samplers"][0][key] = value;
    };
    assert_eq!(said(&|_| {}).unwrap(), "");
    let unsorted = said(&|m| {
        let times = m.floats("SCALAR", &[1.0, 0.5, f32::NAN]);
        sampler(m, "input", times.into());
    });
    assert!(
        unsorted
            .unwrap()
            .starts_with("animation 0 'move', channel 0: 2 key frames whose times do not ascend")
    );
    let nan = said(&|m| {
        let values = m.floats("VEC3", &[f32::NAN; 9]);
        sampler(m, "output", values.into());
    });
    assert!(nan.unwrap().contains("a value is not a finite number; left out"));
    let lost = said(&|m| sampler(m, "output", 99.into())).unwrap();
    assert!(lost.contains("there is no accessor 99"), "{lost}");
    let few = said(&|m| {
        let values = m.floats("VEC3", &[0.0; 6]);
        sampler(m, "output", values.into());
    });
    assert!(few.unwrap().contains("6 numbers for 3 key frames of 3"));
    let none = said(&|m| {
        let (times, values) = (m.floats("SCALAR", &[]), m.floats("VEC3", &[]));
        sampler(m, "input", times.into());
        sampler(m, "output", values.into());
    });
    assert!(none.unwrap().contains("it has no key frames"));
    assert!(said(&|m| sampler(m, "interpolation", "BEZIER".into())).unwrap().contains("'BEZIER'"));
    for (key, value, expected) in [
        ("target", json!({"node": 77, "path": "translation"}), "there is no node 77"),
        ("target", json!({"node": 2, "path": "colour"}), "unknown path 'colour'"),
        ("target", json!({"node": 1, "path": "weights"}), "there are no morph targets"),
        ("target", json!({"path": "pointer"}), "the pointer '' cannot be played"),
        ("sampler", json!(5), "it has no sampler"),
    ] {
        let found = said(&|m| m.json["animations"][0]["channels"][0][key] = value.clone()).unwrap();
        assert!(found.contains(expected), "{found}");
    }
    let matrix = said(&|m| m.json["nodes"][2] = json!({"matrix": [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,1,0,1]}));
    assert!(matrix.unwrap().contains("node 2 has a matrix, which cannot be animated"));
    let twice = said(&|m| {
        let channel = m.json["animations"][0]["channels"][0].clone();
        m.json["animations"][0]["channels"] = json!([channel, channel]);
    });
    assert_eq!(twice.unwrap(), "animation 0 'move', channel 0: channel 1 changes the same; left out");
    // A billion key frames that no bytes stand behind.
    let many = said(&|m| {
        for (key, kind) in [("input", "SCALAR"), ("output", "VEC3")] {
            let accessor = json!({"componentType": F32, "count": 1_000_000_000, "type": kind});
            let index = crate::common::files::model::push(&mut m.json["accessors"], accessor);
            sampler(m, key, index.into());
        }
    });
    assert!(many.unwrap_err().to_string().contains("decoded_bytes"));
    // Times of whole numbers are read as such.
    let whole = said(&|m| {
        let times = m.accessor("SCALAR", U32, 3, &[0, 0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0]);
        sampler(m, "input", times.into());
    });
    assert_eq!(whole.unwrap(), "");
}

/// The same bits for any number of threads.
#[test]
fn threads_do_not_show_in_poses() {
    let mut model = morphing();
    model.json["nodes"] = (0..40).map(|k| json!({"mesh": 0, "weights": [k, 0.5]})).collect();
    model.json["scenes"] = json!([{"nodes": (0..40).collect::<Vec<_>>()}]);
    let file = model.glb();
    let shown = |threads: usize| {
        let (limits, jobs) = (Limits::default(), Jobs::new(threads));
        let context = Context { resolver: &model.files, limits: &limits, jobs: &jobs };
        format!("{:?}", load_bytes_with(&file, None, &LoadOptions::default(), &context).unwrap())
    };
    let one = shown(1);
    assert_eq!(shown(2), one);
    assert_eq!(shown(5), one);
}
