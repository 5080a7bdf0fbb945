//! Nodes of glTF files: copies, visibility, variants, lights, cameras, and the topologies of primitives.

use super::Entry;
use crate::common::files::document::document;
use crate::common::files::model::Model;
use crate::common::shapes::{letter, sphere, square};
use crate::common::stage::{Built, Stage, flat_view};
use overcoat::load::LoadOptions;
use overcoat::scene::{Environment, EnvironmentSource, MeshData, Scene, Transform};
use serde_json::{Value, json};
use std::error::Error;

pub const SCENES: &[Entry] = &[
    ("gltf-instancing", instancing),
    ("gltf-variants", variants),
    ("gltf-lights", lights),
    ("gltf-camera", camera),
    ("gltf-camera-orthographic", camera_orthographic),
    ("gltf-topologies", topologies),
];

fn unlit(color: [f32; 4]) -> Value {
    json!({"extensions": {"KHR_materials_unlit": {}}, "pbrMetallicRoughness": {"baseColorFactor": color}})
}

fn dull(color: [f32; 4]) -> Value {
    json!({"pbrMetallicRoughness": {"baseColorFactor": color, "metallicFactor": 0, "roughnessFactor": 0.6}})
}

/// Without what nothing here is shaded with.
fn bare(mut mesh: MeshData) -> MeshData {
    mesh.tangents.clear();
    mesh.uvs[0].clear();
    mesh
}

/// The scene of a document as it is, without an environment.
fn dark(mut scene: Scene) -> Result<Scene, Box<dyn Error>> {
    scene.set_environment(Environment::default().with(|e| e.source = EnvironmentSource::None))?;
    Ok(scene)
}

/// Left: copies of a letter, moved, to the right turned, upwards scaled, the uppermost mirrored. Right: six balls, of which
/// the second and the last are hidden and the fifth, which calls itself visible, is below a hidden node: three gaps.
fn instancing() -> Built {
    let mut model = document();
    let letter = model.shape(&bare(letter()));
    let ball = model.shape(&bare(sphere(16)));
    let (ochre, blue) =
        (model.material(dull([0.8, 0.5, 0.1, 1.0])), model.material(dull([0.1, 0.3, 0.8, 1.0])));
    let (mut places, mut turns, mut sizes) = (Vec::new(), Vec::new(), Vec::new());
    // Sines and cosines of half of 0, 60 and 120 degrees.
    let halves = [[0.0, 1.0], [0.5, 0.866_025_4], [0.866_025_4, 0.5]];
    for k in 0..9 {
        let (column, row) = (k % 3, k / 3);
        places.push([column as f32 - 1.0, row as f32 - 1.0, 0.0]);
        turns.push([0.0, 0.0, halves[column][0], halves[column][1]]);
        let size = [0.2, 0.3, 0.4][row];
        sizes.push([if row == 2 { -size } else { size }, size, size]);
    }
    let attributes = json!({
        "TRANSLATION": model.vectors(&places), "ROTATION": model.vectors(&turns), "SCALE": model.vectors(&sizes),
    });
    let node = model.show(&letter, ochre, [-1.0, 0.0, 0.0], 0.66);
    model.json["nodes"][node]["extensions"] = json!({"EXT_mesh_gpu_instancing": {"attributes": attributes}});
    let visible = |visible: bool| json!({"KHR_node_visibility": {"visible": visible}});
    let mut balls: Vec<usize> = (0..6)
        .map(|k| {
            model.show(&ball, blue, [0.4 + 0.6 * f64::from(k % 3), 0.4 - 0.8 * f64::from(k / 3), 0.0], 0.25)
        })
        .collect();
    for (k, shown) in [(1, false), (2, true), (4, true), (5, false)] {
        model.json["nodes"][balls[k]]["extensions"] = visible(shown);
    }
    // A hidden node above the fifth ball, whose own word does not count.
    let hidden = balls.remove(4);
    model.node(json!({"children": [hidden], "extensions": visible(false)}), true);
    if let Some(listed) = model.json["scenes"][0]["nodes"].as_array_mut() {
        listed.retain(|node| *node != json!(hidden));
    }
    let mut s = Stage::new()?;
    s.key_light(2.0)?;
    s.add(&model.finish(&LoadOptions::default())?, Transform::translation([0.0; 3])?)?;
    s.seen(flat_view())
}

/// A letter on a ball: as the primitives say, the first variant, and the second, which changes the ball only.
fn variants() -> Built {
    let mut model = document();
    let (mut ball, mut sign) = (model.shape(&bare(sphere(24))), model.shape(&bare(letter())));
    let colors = [
        [0.6, 0.6, 0.6, 1.0],
        [0.02, 0.02, 0.02, 1.0],
        [0.8, 0.1, 0.05, 1.0],
        [0.9, 0.8, 0.2, 1.0],
        [0.1, 0.3, 0.8, 1.0],
    ];
    for color in colors {
        model.material(dull(color));
    }
    let maps = |list: Value| json!({"KHR_materials_variants": {"mappings": list}});
    ball["extensions"] = maps(json!([{"material": 2, "variants": [0]}, {"material": 4, "variants": [1]}]));
    sign["extensions"] = maps(json!([{"material": 3, "variants": [0]}]));
    model.show(&ball, 0, [0.0; 3], 0.9);
    model.show(&sign, 1, [0.0, 0.0, 1.0], 0.5);
    model.json["extensions"] =
        json!({"KHR_materials_variants": {"variants": [{"name": "beach"}, {"name": "street"}]}});
    let mut s = Stage::new()?;
    s.key_light(2.0)?;
    for (k, variant) in [None, Some("beach"), Some("street")].into_iter().enumerate() {
        let options = LoadOptions::default().with_variant(variant.map(str::to_owned));
        s.add(&model.finish(&options)?, Transform::translation([2.0 * k as f64 - 2.0, 0.0, 0.0])?)?;
    }
    s.seen(flat_view())
}

/// A wall with two balls before it, in the light of a directional lamp (white, from the left), a point (red, lower right,
/// faded out at its range) and two cones (green with a soft rim, blue with a hard one) that point as their nodes are turned.
fn lit() -> Model {
    let mut model = document();
    let (wall, ball) = (model.shape(&bare(square(1))), model.shape(&bare(sphere(24))));
    let white = model.material(dull([0.8, 0.8, 0.8, 1.0]));
    model.show(&wall, white, [0.0, 0.0, -0.5], 2.0);
    model.show(&ball, white, [-0.5, 0.1, 0.0], 0.35);
    model.show(&ball, white, [0.5, -0.1, 0.0], 0.35);
    let lamps = [
        json!({"type": "directional", "color": [1, 1, 1], "intensity": 0.4}),
        json!({"type": "point", "color": [1, 0.1, 0.05], "intensity": 0.8, "range": 1.5}),
        json!({"type": "spot", "color": [0.1, 1, 0.1], "intensity": 3, "spot": {"outerConeAngle": 0.4}}),
        json!({
            "type": "spot", "color": [0.1, 0.2, 1], "intensity": 6,
            "spot": {"innerConeAngle": 0.24, "outerConeAngle": 0.25},
        }),
    ];
    model.json["extensions"] = json!({"KHR_lights_punctual": {"lights": lamps}});
    // Lamps shine along -Z of their nodes.
    let places = [
        json!({"rotation": [0, -0.5, 0, 0.866_025_4]}),
        json!({"translation": [0.9, -0.7, 0.3]}),
        json!({"translation": [-0.5, 0.6, 1.0], "rotation": [0, 0, 0, 1]}),
        json!({"translation": [0.2, 0.3, 1.0], "rotation": [0, -0.1, 0, 0.994_987_4]}),
    ];
    for (k, mut node) in places.into_iter().enumerate() {
        node["extensions"] = json!({"KHR_lights_punctual": {"light": k}});
        model.node(node, true);
    }
    model
}

fn lights() -> Built {
    Ok((dark(lit().finish(&LoadOptions::default())?)?, flat_view()))
}

/// The same with two cameras of the file, which stand on nodes: one to the left and tilted, the other to the right.
fn seen_by(number: usize) -> Built {
    let mut model = lit();
    model.json["cameras"] = json!([
        {"type": "perspective", "perspective": {"yfov": 0.7, "znear": 0.1}},
        {"type": "orthographic", "orthographic": {"xmag": 1.5, "ymag": 1.2, "znear": 0.1, "zfar": 20}},
    ]);
    // Turned by about 37 degrees to the right, and tilted; turned by as much to the left.
    model.node(
        json!({"camera": 0, "translation": [-2.4, 0.0, 3.2], "rotation": [-0.03, -0.315, 0.1, 0.943]}),
        true,
    );
    model.node(
        json!({"camera": 1, "translation": [2.4, 0.0, 3.2], "rotation": [0, 0.316_227_77, 0, 0.948_683_3]}),
        true,
    );
    let scene = dark(model.finish(&LoadOptions::default())?)?;
    let camera = *scene.cameras().get(number).ok_or("the cameras are missing")?;
    Ok((scene, camera))
}

fn camera() -> Built {
    seen_by(0)
}

fn camera_orthographic() -> Built {
    seen_by(1)
}

/// Modes 0 to 6 of the same seven coloured vertices, without indices above and in another order below: points, lines, a
/// closed line, a line, triangles, a strip, a fan.
pub fn every_topology() -> Model {
    let mut model = document();
    let zigzag =
        [[-0.9, -0.6], [-0.7, 0.6], [-0.2, -0.6], [0.0, 0.6], [0.4, -0.6], [0.6, 0.6], [0.9, -0.2_f32]];
    let positions = model.vectors(&zigzag.map(|[x, y]| [x, y, 0.0]));
    let colors = [
        [1.0, 0.1, 0.1],
        [1.0, 0.6, 0.1],
        [0.9, 0.9, 0.1],
        [0.1, 0.8, 0.1],
        [0.1, 0.7, 0.9],
        [0.2, 0.2, 1.0],
        [0.8, 0.2, 0.9_f32],
    ];
    let colors = model.vectors(&colors);
    let order = model.accessor("SCALAR", crate::common::files::model::U8, 7, &[0, 2, 1, 4, 3, 6, 5]);
    let mut material = unlit([1.0; 4]);
    material["doubleSided"] = true.into();
    let material = model.material(material);
    for mode in 0..7 {
        for row in 0..2 {
            let mut primitive =
                json!({"attributes": {"POSITION": positions, "COLOR_0": colors}, "mode": mode});
            if row == 1 {
                primitive["indices"] = order.into();
            }
            // Whole numbers of lines and triangles: without the last vertex.
            if mode == 1 || mode == 4 {
                primitive = cut(&mut model, primitive);
            }
            model.show(&primitive, material, [f64::from(mode) - 3.0, 0.5 - f64::from(row), 0.0], 0.45);
        }
    }
    model
}

fn topologies() -> Built {
    let mut s = Stage::dark()?;
    s.add(&every_topology().finish(&LoadOptions::default())?, Transform::translation([0.0; 3])?)?;
    s.seen(flat_view())
}

/// A primitive of the first six vertices, or corners.
fn cut(model: &mut Model, mut primitive: Value) -> Value {
    let mut shorter = |accessor: &mut Value| {
        let number = accessor.as_u64().unwrap_or_default() as usize;
        let mut own = model.json["accessors"][number].clone();
        own["count"] = 6.into();
        *accessor = crate::common::files::model::push(&mut model.json["accessors"], own).into();
    };
    if primitive.get("indices").is_some() {
        shorter(&mut primitive["indices"]);
    } else {
        shorter(&mut primitive["attributes"]["POSITION"]);
        shorter(&mut primitive["attributes"]["COLOR_0"]);
    }
    primitive
}
