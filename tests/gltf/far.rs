//! Nodes and vertices far from zero, and nodes that cannot be seen.

use crate::common::files::model::Model;
use overcoat::load::Loaded;
use overcoat::render::{RenderOptions, Renderer};
use overcoat::scene::{Camera, Framing, Projection};
use serde_json::{Value, json};

/// A tetrahedron about zero with coordinates that are multiples of 1/32, moved by `at` in its vertices.
fn tetrahedron(at: [f32; 3]) -> Model {
    let corners = [[1.0, 1.0, 1.0], [-1.0, -1.0, 1.0], [-1.0, 1.0, -1.0], [1.0, -1.0, -1.0_f32]];
    let faces = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3_usize]];
    let positions: Vec<f32> =
        faces.iter().flatten().flat_map(|&v| (0..3).map(move |k| corners[v][k] * 0.96875 + at[k])).collect();
    let mut model = Model::empty();
    let position = model.floats("VEC3", &positions);
    model.json["meshes"] = json!([{"primitives": [{"attributes": {"POSITION": position}}]}]);
    model
}

/// The same with these nodes, the first of which is in the scene.
fn with_nodes(nodes: Value) -> Model {
    let mut model = tetrahedron([0.0; 3]);
    model.json["nodes"] = nodes;
    model
}

fn camera(loaded: &Loaded) -> Camera {
    Framing::default().camera(&loaded.scene)
}

fn picture(loaded: &Loaded) -> String {
    let options = RenderOptions::draft(48, 48).with_samples(4);
    let rendered = Renderer::new(1).render(&loaded.scene, &camera(loaded), &options).unwrap();
    assert!(rendered.stats.covered > 300, "{}", rendered.stats.covered);
    rendered.frame.frame_hash()
}

#[test]
fn nodes_far_away_make_the_picture_of_those_at_zero() {
    let far = [1_334_998.0, 4_137_462.3, 4_654_213.9];
    let small = json!({"mesh": 0, "translation": [2.1, 0.3, -0.7], "rotation": [0.1, 0.2, 0.3, 0.9], "scale": [0.3, 0.3, 0.3]});
    for (near, moved) in [
        (json!([{"mesh": 0}]), json!([{"mesh": 0, "translation": far}])),
        (
            json!([{"mesh": 0, "matrix": [1, 0, 0, 0, 0, 0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1]}]),
            json!([{"mesh": 0, "matrix": [1, 0, 0, 0, 0, 0, -1, 0, 0, 1, 0, 0, far[0], far[1], far[2], 1]}]),
        ),
        (
            json!([{"mesh": 0, "children": [1]}, small]),
            json!([{"mesh": 0, "children": [1], "translation": far}, small]),
        ),
        // The node that is far away holds nothing, and neither does the one above it.
        (
            json!([{"children": [1]}, {"children": [2]}, small]),
            json!([{"children": [1]}, {"children": [2], "translation": far}, small]),
        ),
    ] {
        let (near, moved) = (with_nodes(near).load().unwrap(), with_nodes(moved).load().unwrap());
        assert_eq!(moved.scene.origin(), far);
        assert!(moved.warnings.is_empty(), "{:?}", moved.warnings);
        assert_eq!(picture(&moved), picture(&near));
    }
}

#[test]
fn vertices_far_away_are_drawn_as_well_as_the_file_has_them() {
    let near = tetrahedron([0.0; 3]).load().unwrap();
    let far = tetrahedron([262_144.0, 0.0, -262_144.0]).load().unwrap();
    assert_eq!(picture(&far), picture(&near));
    assert_eq!(far.warnings.len(), 1);
    assert!(far.warnings[0].message.contains("single precision"), "{:?}", far.warnings);
    // Vertices and node cancel.
    let mut back = tetrahedron([262_144.0, 0.0, -262_144.0]);
    back.json["nodes"] = json!([{"mesh": 0, "translation": [-262_144, 0, 262_144]}]);
    let back = back.load().unwrap();
    assert_eq!((picture(&back), back.scene.origin()), (picture(&near), [0.0; 3]));
}

/// They stand where they do without the offset.
#[test]
fn cameras_and_lights_are_moved_too() {
    let of = |offset: [f64; 3]| {
        let mut model = with_nodes(json!([
            {"mesh": 0, "children": [1, 2], "translation": offset},
            {"camera": 0, "translation": [0.25, 0.5, 4.0]},
            {"translation": [1.0, 2.0, 3.0], "extensions": {"KHR_lights_punctual": {"light": 0}}}
        ]));
        model.json["cameras"] = json!([{"type": "perspective", "perspective": {"yfov": 0.5, "znear": 0.1}}]);
        model.json["extensionsUsed"] = json!(["KHR_lights_punctual"]);
        model.json["extensions"] = json!({"KHR_lights_punctual": {"lights": [{"type": "point"}]}});
        model.load().unwrap().scene
    };
    let (near, far) = (of([0.0; 3]), of([6_378_137.0, 0.0, 0.1]));
    assert_eq!(far.cameras(), near.cameras());
    assert_eq!(far.lights(), near.lights());
    assert!(matches!(far.cameras()[0].projection, Projection::Perspective { .. }));
}

#[test]
fn invisible_nodes_do_not_decide_the_frame() {
    let expected = camera(&with_nodes(json!([{"mesh": 0}])).load().unwrap());
    let clear = json!([{"alphaMode": "BLEND", "pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1, 0]}}]);
    for (hidden, materials) in [
        (json!({"mesh": 0, "translation": [5000, 0, 0], "scale": [0, 0, 0]}), json!([{}])),
        (json!({"mesh": 0, "translation": [5000, 0, 0], "scale": [0, 1, 0]}), json!([{}])),
        (json!({"mesh": 1, "translation": [5000, 0, 0]}), clear),
    ] {
        let mut model = with_nodes(json!([{"mesh": 0, "children": [1]}, hidden]));
        let mut other = model.json["meshes"][0].clone();
        other["primitives"][0]["material"] = 0.into();
        model.json["meshes"].as_array_mut().unwrap().push(other);
        model.json["materials"] = materials;
        assert_eq!(camera(&model.load().unwrap()), expected, "{}", model.json["nodes"]);
    }
}
