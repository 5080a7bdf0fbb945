//! glTF scene graphs and instances.

use super::attack::Must::{Draw, Exceed, Fail, Warn};
use super::attack::{Attack, Must};
use super::model::{Model, U8};
use serde_json::{Value, json};

fn attack(name: &'static str, tries: &'static str, change: impl FnOnce(&mut Model), must: Must) -> Attack {
    let mut model = Model::triangle();
    change(&mut model);
    Attack::model(name, tries, "x.glb", model.glb(), must)
}

fn chain(length: usize) -> Value {
    (0..length)
        .map(|k| if k + 1 < length { json!({"children": [k + 1]}) } else { json!({"mesh": 0}) })
        .collect()
}

/// Instances from accessors of zeros.
fn instances(model: &mut Model, count: u64) {
    model.json["extensionsUsed"] = json!(["EXT_mesh_gpu_instancing"]);
    let scale = super::model::push(
        &mut model.json["accessors"],
        json!({"componentType": 5126, "count": count, "type": "VEC3"}),
    );
    model.json["nodes"][0]["extensions"] =
        json!({"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": scale}}});
}

pub fn attacks() -> Vec<Attack> {
    vec![
        attack(
            "node-own-child",
            "an endless walk",
            |m| m.json["nodes"][0]["children"] = json!([0]),
            Warn("reached twice"),
        ),
        attack(
            "node-cycle",
            "an endless walk through three nodes",
            |m| m.json["nodes"] = json!([{"children": [1]}, {"children": [2]}, {"children": [0], "mesh": 0}]),
            Warn("reached twice"),
        ),
        attack(
            "node-two-parents",
            "two to the power of thirty copies",
            |m| {
                m.json["nodes"] = (0..30)
                    .map(|k| json!({"children": [k + 1, k + 1], "mesh": 0}))
                    .chain([json!({})])
                    .collect()
            },
            Warn("reached twice"),
        ),
        attack(
            "node-chain",
            "a stack overflow by depth",
            |m| m.json["nodes"] = chain(60_000),
            Exceed("depth"),
        ),
        attack(
            "node-no-root",
            "a graph without a beginning",
            |m| {
                m.json.as_object_mut().unwrap().remove("scenes");
                m.json.as_object_mut().unwrap().remove("scene");
                m.json["nodes"] = json!([{"children": [1]}, {"children": [0]}]);
            },
            Warn("no triangles"),
        ),
        attack(
            "node-child-missing",
            "a read past the nodes",
            |m| m.json["nodes"][0]["children"] = json!([4_294_967_295_u64]),
            Warn("there is no node"),
        ),
        attack(
            "scene-missing",
            "a read past the scenes",
            |m| m.json["scene"] = 77.into(),
            Warn("there is no scene 77"),
        ),
        attack(
            "matrix-not-finite",
            "infinity through a chain of scales",
            |m| {
                m.json["nodes"] = chain(60);
                for k in 0..60 {
                    m.json["nodes"][k]["scale"] = json!([1e30, 1e30, 1e30]);
                }
            },
            Fail("node"),
        ),
        attack(
            "matrix-singular",
            "a normal by a matrix without inverse",
            |m| m.json["nodes"][0]["matrix"] = json!([0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1]),
            Warn("nothing to see"),
        ),
        attack(
            "matrix-projective",
            "a division by w",
            |m| m.json["nodes"][0]["matrix"] = json!([1, 0, 0, 1, 0, 1, 0, 1, 0, 0, 1, 1, 0, 0, 0, 0]),
            Warn("node 0"),
        ),
        attack(
            "rotation-zero",
            "a rotation without a length",
            |m| m.json["nodes"][0]["rotation"] = json!([0, 0, 0, 0]),
            Draw,
        ),
        attack(
            "rotation-huge",
            "a rotation whose square is infinite",
            |m| m.json["nodes"][0]["rotation"] = json!([3e38, 3e38, 3e38, 3e38]),
            Draw,
        ),
        attack(
            "instances-billion",
            "memory for a billion copies",
            |m| instances(m, 1 << 30),
            Exceed("decoded_bytes"),
        ),
        attack(
            "instances-maximum",
            "an overflow of the number of copies",
            |m| instances(m, u64::MAX),
            Exceed("decoded_bytes"),
        ),
        attack(
            "instances-multiply",
            "copies times nodes",
            |m| {
                instances(m, 60_000);
                let node = m.json["nodes"][0].clone();
                m.json["nodes"] = vec![node; 60].into();
                m.json["scenes"][0]["nodes"] = (0..60).collect();
            },
            Exceed("decoded_bytes"),
        ),
        attack(
            "instances-of-strip",
            "copies times triangles",
            |m| {
                m.json["accessors"][0].as_object_mut().unwrap().remove("bufferView");
                m.json["accessors"][0]["count"] = 30_000.into();
                instances(m, 1000);
            },
            Exceed("triangles"),
        ),
        attack(
            "instances-differ",
            "attributes of different length",
            |m| {
                instances(m, 3);
                let other = super::model::push(
                    &mut m.json["accessors"],
                    json!({"componentType": 5126, "count": 2, "type": "VEC3"}),
                );
                m.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["SCALE"] =
                    other.into();
            },
            Warn("differ in length"),
        ),
        attack(
            "instances-of-bytes",
            "rotations that are no numbers",
            |m| {
                instances(m, 3);
                let other = m.accessor("VEC4", U8, 3, &[0; 12]);
                m.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["ROTATION"] =
                    other.into();
            },
            Draw,
        ),
        attack(
            "cover-everything",
            "a screen of triangles behind each other",
            |m| {
                // 3000 sheets, each larger than the picture, farthest first.
                let mut corners = Vec::new();
                for k in 0..3000 {
                    let z = k as f32 * 1e-3;
                    corners.extend([-9.0, -9.0, z, 20.0, -9.0, z, -9.0, 20.0, z]);
                }
                let position = m.floats("VEC3", &corners);
                m.primitive()["attributes"]["POSITION"] = position.into();
            },
            Exceed("blocks"),
        ),
        attack(
            "blend-everything",
            "memory for surfaces that show through",
            |m| {
                let mut corners = Vec::new();
                for k in 0..600 {
                    let z = k as f32 * 1e-3;
                    corners.extend([-9.0, -9.0, z, 20.0, -9.0, z, -9.0, 20.0, z]);
                }
                let position = m.floats("VEC3", &corners);
                m.primitive()["attributes"]["POSITION"] = position.into();
                m.json["materials"] = json!([{"alphaMode": "BLEND", "pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1, 0.5]}}]);
                m.primitive()["material"] = 0.into();
            },
            Exceed("blend_entries"),
        ),
        attack("zero-area", "triangles without a surface", |m| m.bytes.fill(0), Warn("nothing to see")),
        attack(
            "lights-by-the-thousand",
            "work for lights times pixels",
            |m| {
                m.json["extensionsUsed"] = json!(["KHR_lights_punctual"]);
                m.json["extensions"] = json!({"KHR_lights_punctual": {"lights": [{"type": "point"}]}});
                let light = json!({"extensions": {"KHR_lights_punctual": {"light": 0}}});
                m.json["nodes"] =
                    std::iter::once(json!({"mesh": 0})).chain(std::iter::repeat_n(light, 60_000)).collect();
                m.json["scenes"][0]["nodes"] = (0..60_001).collect();
            },
            Exceed("lights"),
        ),
        attack(
            "names-of-cameras",
            "a camera that is nowhere",
            |m| m.json["cameras"] = json!([{"type": "orthographic", "orthographic": {"xmag": 0, "ymag": 0, "zfar": 0, "znear": 0}}]),
            Draw,
        ),
    ]
}
