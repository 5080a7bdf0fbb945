//! Animations of glTF files: each property that they change, each file at several times.

use super::Entry;
use crate::common::files::at_time;
use crate::common::files::document::document;
use crate::common::files::model::{F32, Model, U8, U16, push};
use crate::common::files::png;
use crate::common::images::letter_f;
use crate::common::shapes::{letter, square, surface};
use crate::common::stage::{Built, Stage, flat_view};
use overcoat::load::LoadOptions;
use overcoat::scene::{MeshData, Transform};
use overcoat_core::math::double;
use serde_json::{Value, json};
use std::error::Error;
use std::f64::consts::TAU;

pub const SCENES: &[Entry] = &[
    ("gltf-skin", skin),
    ("gltf-morph-targets", morph_targets),
    ("gltf-interpolation", interpolation),
    ("gltf-animation-pointer", animation_pointer),
];

/// A turn about an axis, as a quaternion.
fn turn(axis: [f64; 3], degrees: f64) -> [f32; 4] {
    let (sin, cos) = double::sin_cos(degrees.to_radians() * 0.5);
    [axis[0] * sin, axis[1] * sin, axis[2] * sin, cos].map(|v| v as f32)
}

const Y: [f64; 3] = [0.0, 1.0, 0.0];
const Z: [f64; 3] = [0.0, 0.0, 1.0];

/// One animation of channels (target, kind of the values, values, interpolation) with the same key frames.
fn animate(model: &mut Model, times: &[f32], channels: &[(Value, &str, Vec<f32>, &str)]) {
    let input = model.floats("SCALAR", times);
    let mut animation = json!({"channels": [], "samplers": []});
    for (target, kind, values, interpolation) in channels {
        let output = model.floats(kind, values);
        let sampler = json!({"input": input, "output": output, "interpolation": interpolation});
        let sampler = push(&mut animation["samplers"], sampler);
        push(&mut animation["channels"], json!({"sampler": sampler, "target": target}));
    }
    model.json["animations"] = json!([animation]);
}

/// Scales, then moves.
fn at(x: f64, y: f64, scale: f64) -> Result<Transform, Box<dyn Error>> {
    Ok(Transform::from_parts([x, y, 0.0], [0.0, 0.0, 0.0, 1.0], [scale; 3])?)
}

/// A tube along +Y, 0 to 3, with bands of colour; dark where its joints are.
fn tube() -> MeshData {
    const RINGS: u32 = 24;
    let mut mesh = surface(16, RINGS, |u, v| {
        let (sin, cos) = double::sin_cos(TAU * u);
        ([0.35 * sin, 3.0 - 3.0 * v, 0.35 * cos], [sin, 0.0, cos], [cos, 0.0, -sin])
    });
    mesh.tangents.clear();
    let colors = mesh.positions.iter().zip(&mesh.uvs[0]).map(|(p, uv)| {
        let joint = (p[1] - 1.0).abs() < 0.1 || (p[1] - 2.0).abs() < 0.1;
        let side = if uv[0] < 0.5 { [0.8, 0.25, 0.1, 1.0] } else { [0.15, 0.35, 0.8, 1.0] };
        if joint { [0.02, 0.02, 0.02, 1.0] } else { side }
    });
    mesh.colors = colors.collect();
    mesh.uvs[0].clear();
    mesh
}

/// A tube of three joints that is straight at second 0, bent at second 1, bent the other way and twisted at second 2.
pub fn skinned() -> Model {
    let mut model = document();
    let mesh = tube();
    let mut primitive = model.shape(&mesh);
    let (mut joints, mut weights) = (Vec::new(), Vec::new());
    for p in &mesh.positions {
        // Each joint has the metre above it, half a metre to and fro.
        let place = (p[1] - 0.5).clamp(0.0, 2.0);
        let lower = place.floor().min(1.0);
        let upper = ((place - lower) * 65535.0) as u16;
        joints.push([lower as u8, lower as u8 + 1, 0, 0]);
        let both = [65535 - upper, upper, 0, 0].map(u16::to_le_bytes);
        weights.push([both[0], both[1], both[2], both[3]].as_flattened().try_into().unwrap_or([0_u8; 8]));
    }
    primitive["attributes"]["JOINTS_0"] = model.packed("VEC4", U8, false, &joints).into();
    primitive["attributes"]["WEIGHTS_0"] = model.packed("VEC4", U16, true, &weights).into();
    let paint =
        json!({"doubleSided": true, "pbrMetallicRoughness": {"metallicFactor": 0, "roughnessFactor": 0.4}});
    primitive["material"] = model.material(paint).into();
    let mesh = model.mesh(primitive);
    let inverse: Vec<f32> = (0..3)
        .flat_map(|k| {
            let mut matrix = [0.0_f32; 16];
            (0..4).for_each(|k| matrix[5 * k] = 1.0);
            matrix[13] = -(k as f32);
            matrix
        })
        .collect();
    let bytes: Vec<u8> = inverse.iter().flat_map(|v| v.to_le_bytes()).collect();
    let inverse = model.accessor("MAT4", F32, 3, &bytes);
    model.json["skins"] = json!([{"joints": [1, 2, 3], "inverseBindMatrices": inverse}]);
    // The node's own transform has no influence.
    model.node(json!({"mesh": mesh, "skin": 0, "translation": [9, 9, 9]}), true);
    model.node(json!({"children": [2]}), true);
    model.node(json!({"children": [3], "translation": [0, 1, 0]}), false);
    model.node(json!({"translation": [0, 1, 0]}), false);
    let bend = |degrees: [f64; 3]| degrees.iter().flat_map(|&d| turn(Z, d)).collect::<Vec<f32>>();
    let twist: Vec<f32> = [0.0, 0.0, 120.0].iter().flat_map(|&d| turn(Y, d)).collect();
    animate(
        &mut model,
        &[0.0, 1.0, 2.0],
        &[
            (json!({"node": 1, "path": "rotation"}), "VEC4", twist, "LINEAR"),
            (json!({"node": 2, "path": "rotation"}), "VEC4", bend([0.0, 70.0, -40.0]), "LINEAR"),
            (json!({"node": 3, "path": "rotation"}), "VEC4", bend([0.0, 80.0, -60.0]), "LINEAR"),
        ],
    );
    model
}

/// Seconds 0, 0.5, 1 and 2.
fn skin() -> Built {
    let mut model = skinned();
    let mut s = Stage::new()?;
    s.key_light(2.0)?;
    for (k, time) in [0.0, 0.5, 1.0, 2.0].into_iter().enumerate() {
        let x = [-1.75, -0.5, 0.75, 1.6][k];
        s.add(&model.finish(&at_time(time))?, at(x, -0.75, 0.5)?)?;
    }
    s.seen(flat_view())
}

/// A bulge that comes with its normals, a colour, and below texture coordinates that move: weights of the nodes and,
/// last, of the mesh.
pub fn morphing() -> Result<Model, Box<dyn Error>> {
    let mut model = document();
    let mut mesh = square(12);
    mesh.tangents.clear();
    // A hill that rises from the plane without an edge: 0.9 (1 - r^2 / 0.9)^2.
    let inside = |p: &[f32; 3]| (1.0 - (p[0] * p[0] + p[1] * p[1]) / 0.9).max(0.0);
    let lift: Vec<[f32; 3]> =
        mesh.positions.iter().map(|p| [0.0, 0.0, 0.9 * inside(p) * inside(p)]).collect();
    let lean: Vec<[f32; 3]> = mesh
        .positions
        .iter()
        .map(|p| {
            let slope = 4.0 * inside(p);
            let normal = [slope * p[0], slope * p[1], 1.0];
            let length = normal.iter().map(|v| v * v).sum::<f32>().sqrt();
            [normal[0] / length, normal[1] / length, normal[2] / length - 1.0]
        })
        .collect();
    let blush: Vec<[f32; 3]> =
        mesh.positions.iter().map(|p| [0.0, -0.5 * (p[0] + 1.0) * 0.5, -0.7 * (p[1] + 1.0) * 0.5]).collect();
    let shift = vec![[0.25_f32, 0.5]; mesh.positions.len()];
    mesh.colors = vec![[0.7, 0.7, 0.7, 1.0]; mesh.positions.len()];
    let bulge = model.vectors(&lift);
    let normals = model.vectors(&lean);
    let colors = model.vectors(&blush);
    let uvs = model.vectors(&shift);
    let mut plain = model.shape(&mesh);
    plain["targets"] = json!([{"POSITION": bulge, "NORMAL": normals}, {"COLOR_0": colors}]);
    mesh.colors.clear();
    let mut textured = model.shape(&mesh);
    textured["targets"] = json!([{"TEXCOORD_0": uvs}, {"POSITION": bulge, "NORMAL": normals}]);
    let texture = model.texture(&png(&letter_f()?)?);
    let dull = json!({"metallicFactor": 0, "roughnessFactor": 0.6});
    plain["material"] = model.material(json!({"pbrMetallicRoughness": dull})).into();
    let mut picture = json!({"pbrMetallicRoughness": dull});
    picture["pbrMetallicRoughness"]["baseColorTexture"] = json!({"index": texture});
    textured["material"] = model.material(picture).into();
    for (row, primitive) in [plain, textured].into_iter().enumerate() {
        let mesh = model.mesh(primitive);
        model.json["meshes"][mesh]["weights"] = json!([1, 0.5]);
        let weights = [Some([0.0, 0.0]), Some([0.5, 0.0]), Some([1.0, 0.0]), Some([1.0, 1.0]), None];
        for (column, weights) in weights.into_iter().enumerate() {
            let place = [column as f64 - 2.0, 0.5 - row as f64, 0.0];
            let mut node = json!({"mesh": mesh, "translation": place, "scale": [0.45, 0.45, 0.45]});
            if let Some(weights) = weights {
                node["weights"] = json!(weights);
            }
            model.node(node, true);
        }
    }
    Ok(model)
}

fn morph_targets() -> Built {
    let mut s = Stage::new()?;
    s.key_light(2.0)?;
    s.add(&morphing()?.finish(&LoadOptions::default())?, at(0.0, 0.0, 1.0)?)?;
    s.seen(flat_view())
}

/// Columns: stepwise, linear, cubic splines, of three key frames at seconds 0, 1 and 2: a letter moves to the right and
/// turns by 90 degrees each.
pub fn interpolated() -> Model {
    let mut model = document();
    let primitive = model.shape(&letter());
    let material = model.material(json!({
        "extensions": {"KHR_materials_unlit": {}},
        "pbrMetallicRoughness": {"baseColorFactor": [0.8, 0.5, 0.1, 1]},
    }));
    let mut channels = Vec::new();
    for (column, how) in ["STEP", "LINEAR", "CUBICSPLINE"].into_iter().enumerate() {
        let node = model.show(&primitive, material, [0.0; 3], 0.25);
        let center = 1.5 * (column as f32 - 1.0);
        let mut places = vec![[center - 0.35, 0.0, 0.0], [center, 0.0, 0.0], [center + 0.35, 0.0, 0.0]];
        let mut turns = vec![turn(Z, 0.0), turn(Z, 90.0), turn(Z, 180.0)];
        let mut sizes = vec![[0.25; 3], [0.3; 3], [0.15; 3]];
        if how == "CUBICSPLINE" {
            // Up at the middle key frame, flat at the ends.
            let flat = [0.0; 3];
            let up = [0.35, 0.6, 0.0];
            places = vec![flat, places[0], flat, up, places[1], up, flat, places[2], flat];
            let still = [0.0; 4];
            turns = vec![still, turns[0], still, still, turns[1], still, still, turns[2], still];
            sizes = vec![flat, sizes[0], flat, flat, sizes[1], flat, flat, sizes[2], flat];
        }
        for (path, kind, values) in [
            ("translation", "VEC3", places.concat()),
            ("rotation", "VEC4", turns.concat()),
            ("scale", "VEC3", sizes.concat()),
        ] {
            channels.push((json!({"node": node, "path": path}), kind, values, how));
        }
    }
    animate(&mut model, &[0.0, 1.0, 2.0], &channels);
    model
}

/// Rows: second 0.5, 1, 1.5, 1.75.
fn interpolation() -> Built {
    let mut model = interpolated();
    let mut s = Stage::dark()?;
    for (row, time) in [0.5, 1.0, 1.5, 1.75].into_iter().enumerate() {
        s.add(&model.finish(&at_time(time))?, at(0.0, 0.75 - 0.5 * row as f64, 0.65)?)?;
    }
    s.seen(flat_view())
}

/// Columns: base colour from red to blue, emission from none to green, a texture that moves and one that turns, roughness from
/// 0 to 1, a square that shows from second 1 on.
pub fn pointed() -> Result<Model, Box<dyn Error>> {
    let mut model = document();
    let mut mesh = square(1);
    mesh.tangents.clear();
    let flat = model.shape(&mesh);
    let mut ball = crate::common::shapes::sphere(16);
    ball.tangents.clear();
    let ball = model.shape(&ball);
    let texture = model.texture(&png(&letter_f()?)?);
    let picture = || {
        json!({
            "extensions": {"KHR_materials_unlit": {}},
            "pbrMetallicRoughness": {
                "baseColorTexture": {"index": texture, "extensions": {"KHR_texture_transform": {}}},
            },
        })
    };
    let dull = json!({"pbrMetallicRoughness": {"metallicFactor": 0, "baseColorFactor": [0.2, 0.2, 0.2, 1]}});
    let shiny = json!({"pbrMetallicRoughness": {
        "metallicFactor": 1, "roughnessFactor": 0, "baseColorFactor": [0.9, 0.7, 0.4, 1],
    }});
    let glowing = json!({
        "emissiveFactor": [0, 0, 0], "pbrMetallicRoughness": {"baseColorFactor": [0, 0, 0, 1]},
        "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 0.5}},
    });
    for (k, (primitive, material)) in
        [(&ball, dull), (&flat, glowing), (&flat, picture()), (&flat, picture()), (&ball, shiny)]
            .into_iter()
            .enumerate()
    {
        let material = model.material(material);
        model.show(primitive, material, [k as f64 - 2.5, 0.0, 0.0], 0.42);
    }
    let shown = model.show(&flat, 2, [2.5, 0.0, 0.0], 0.42);
    model.json["nodes"][shown]["extensions"] = json!({"KHR_node_visibility": {"visible": false}});
    let transform = |k: usize| {
        format!("/materials/{k}/pbrMetallicRoughness/baseColorTexture/extensions/KHR_texture_transform")
    };
    let changes: [(String, &str, Vec<f32>, &str); 6] = [
        (
            "/materials/0/pbrMetallicRoughness/baseColorFactor".into(),
            "VEC4",
            vec![0.9, 0.02, 0.02, 1.0, 0.02, 0.02, 0.9, 1.0],
            "LINEAR",
        ),
        ("/materials/1/emissiveFactor".into(), "VEC3", vec![0.0, 0.0, 0.0, 0.0, 1.0, 0.0], "LINEAR"),
        (transform(2) + "/offset", "VEC2", vec![0.0, 0.0, 0.5, 0.25], "LINEAR"),
        (transform(3) + "/rotation", "SCALAR", vec![0.0, std::f32::consts::FRAC_PI_2], "LINEAR"),
        ("/materials/4/pbrMetallicRoughness/roughnessFactor".into(), "SCALAR", vec![0.0, 1.0], "LINEAR"),
        (format!("/nodes/{shown}/extensions/KHR_node_visibility/visible"), "SCALAR", vec![0.0, 1.0], "STEP"),
    ];
    let channels = changes.map(|(pointer, kind, values, how)| {
        let extension = json!({"KHR_animation_pointer": {"pointer": pointer}});
        (json!({"path": "pointer", "extensions": extension}), kind, values, how)
    });
    animate(&mut model, &[0.0, 1.0], &channels);
    Ok(model)
}

/// Rows: seconds 0, 0.5 and 1.
fn animation_pointer() -> Built {
    let mut model = pointed()?;
    let mut s = Stage::new()?;
    for (row, time) in [0.0, 0.5, 1.0].into_iter().enumerate() {
        s.add(&model.finish(&at_time(time))?, at(0.0, 0.66 - 0.66 * row as f64, 0.66)?)?;
    }
    s.seen(flat_view())
}
