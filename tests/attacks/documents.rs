//! glTF as text and as a container, before any geometry is looked at; data URIs.

use super::attack::Attack;
use super::attack::Must::{Draw, Exceed, Fail, Warn};
use super::model::Model;
use serde_json::json;

/// A container with these lengths in its headers, whatever is there.
fn container(total: u32, chunks: &[(u32, &[u8; 4], &[u8])]) -> Vec<u8> {
    let mut file = b"glTF\x02\0\0\0".to_vec();
    file.extend(total.to_le_bytes());
    for (length, kind, bytes) in chunks {
        file.extend(length.to_le_bytes());
        file.extend(*kind);
        file.extend(*bytes);
    }
    file
}

fn triangle_with(change: impl FnOnce(&mut Model)) -> Vec<u8> {
    let mut model = Model::triangle();
    change(&mut model);
    model.glb()
}

pub fn attacks() -> Vec<Attack> {
    let gltf = |name, tries, text: String, must| Attack::model(name, tries, "x.gltf", text, must);
    let glb = |name, tries, bytes: Vec<u8>, must| Attack::model(name, tries, "x.glb", bytes, must);
    let json: &[u8] = br#"{"asset":{"version":"2.0"}} "#;
    let uri = |uri: String| {
        json!({"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}], "buffers": [{"byteLength": 36, "uri": uri}]})
        .to_string()
    };
    vec![
        gltf(
            "json-nesting",
            "a stack overflow by nested lists",
            format!("{{\"asset\":{}", "[".repeat(1 << 20)),
            Fail("nested more than 120 deep"),
        ),
        gltf(
            "json-nested-objects",
            "a stack overflow by nested objects",
            "{\"extras\":".repeat(1 << 18),
            Fail("nested more than 120 deep"),
        ),
        gltf(
            "json-nested-extras",
            "a stack overflow in what is skipped",
            format!(
                "{{\"asset\":{{\"version\":\"2.0\"}},\"extras\":{}{}}}",
                "[".repeat(100_000),
                "]".repeat(100_000)
            ),
            Fail("nested more than 120 deep"),
        ),
        gltf(
            "json-cut",
            "a read past the end of the text",
            "{\"asset\":{\"version\":\"2.0\"},\"nodes\":[{\"mesh\"".into(),
            Fail("EOF"),
        ),
        gltf(
            "json-nul",
            "a string that ends early",
            "{\"asset\":{\"version\":\"2.0\"}}\0{".into(),
            Fail("trailing characters"),
        ),
        gltf("json-not-utf8", "a string that is no text", String::new(), Fail("empty")),
        Attack::model(
            "json-bytes",
            "characters that are none",
            "x.gltf",
            b"{\"asset\":{\"version\":\"2.\xff\"}}".to_vec(),
            Warn("U+FFFD"),
        ),
        gltf(
            "json-surrogate",
            "half of a surrogate pair",
            r#"{"asset":{"version":"2.0"},"nodes":[{"name":"\ud800"}]}"#.into(),
            Warn("U+FFFD"),
        ),
        gltf(
            "json-huge-number",
            "an infinite number",
            r#"{"asset":{"version":"2.0"},"nodes":[{"translation":[1e999,0,0]}]}"#.into(),
            Fail("out of range"),
        ),
        gltf(
            "json-empty-lists",
            "memory by a million empty objects",
            format!("{{\"asset\":{{\"version\":\"2.0\"}},\"nodes\":[{}{{}}]}}", "{},".repeat(1_100_000)),
            Exceed("decoded_bytes"),
        ),
        gltf(
            "json-million-materials",
            "memory by a million materials",
            format!("{{\"asset\":{{\"version\":\"2.0\"}},\"materials\":[{}{{}}]}}", "{},".repeat(1_100_000)),
            Exceed("decoded_bytes"),
        ),
        gltf(
            "json-million-primitives",
            "memory by a million primitives",
            format!(
                "{{\"asset\":{{\"version\":\"2.0\"}},\"meshes\":[{{\"primitives\":[{}{{}}]}}]}}",
                "{},".repeat(1_100_000)
            ),
            Exceed("decoded_bytes"),
        ),
        gltf(
            "json-duplicate-keys",
            "two meanings of one file",
            r#"{"asset":{"version":"2.0"},"nodes":[],"nodes":[{}]}"#.into(),
            Warn("duplicate field"),
        ),
        gltf(
            "json-version-3",
            "a format that is not known",
            r#"{"asset":{"version":"3.0"}}"#.into(),
            Fail("only glTF 2.0"),
        ),
        gltf(
            "json-required-extension",
            "a plausible picture without what it needs",
            r#"{"asset":{"version":"2.0"},"extensionsRequired":["EVIL_ext"],"extensionsUsed":["EVIL_ext"]}"#
                .into(),
            Fail("EVIL_ext"),
        ),
        gltf(
            "json-control-characters",
            "terminal escapes in a message",
            r#"{"asset":{"version":"2.0"},"extensionsRequired":["\u001b[2J\u0007"]}"#.into(),
            Fail("the file requires"),
        ),
        gltf(
            "json-long-name",
            "a message of megabytes",
            format!(
                r#"{{"asset":{{"version":"2.0"}},"scenes":[{{"nodes":[0]}}],"nodes":[{{"name":"{}","mesh":7}}]}}"#,
                "x".repeat(1 << 20)
            ),
            Fail("there is no mesh 7"),
        ),
        glb(
            "glb-short-header",
            "a read past the header",
            b"glTF\x02\0\0".to_vec(),
            Fail("ends in its header"),
        ),
        glb(
            "glb-length-zero",
            "an underflow of the length",
            container(0, &[(28, b"JSON", json)]),
            Warn("the container says"),
        ),
        glb(
            "glb-length-maximum",
            "an allocation of the claimed length",
            container(u32::MAX, &[(28, b"JSON", json)]),
            Fail("cut off"),
        ),
        glb(
            "glb-chunk-maximum",
            "an overflow of the chunk's end",
            container(48, &[(u32::MAX, b"JSON", json)]),
            Fail("claims 4294967295 bytes"),
        ),
        glb(
            "glb-chunk-overlap",
            "a chunk that reaches into the next",
            container(48, &[(30, b"JSON", json)]),
            Fail("glTF"),
        ),
        glb(
            "glb-no-json",
            "a container without a document",
            container(20, &[(0, b"BIN\0", b"")]),
            Fail("not JSON"),
        ),
        glb(
            "glb-binary-maximum",
            "an allocation for the binary chunk",
            container(56, &[(28, b"JSON", json), (u32::MAX - 3, b"BIN\0", b"")]),
            Fail("BIN chunk claims"),
        ),
        glb(
            "glb-version-1",
            "another container of the same name",
            b"glTF\x01\0\0\0\x20\0\0\0\x0c\0\0\0\0\0\0\0{}          ".to_vec(),
            Fail("GLB version 1"),
        ),
        glb(
            "glb-trailing",
            "data hidden behind the container",
            {
                let mut file = Model::triangle().glb();
                file.extend([0xcc; 5000]);
                file
            },
            Draw,
        ),
        gltf(
            "data-uri-no-comma",
            "a split without a second half",
            uri("data:application/octet-stream;base64".into()),
            Fail("no comma"),
        ),
        gltf(
            "data-uri-not-base64",
            "digits that are none",
            uri(format!("data:;base64,{}", "*".repeat(48))),
            Fail("not base64"),
        ),
        gltf(
            "data-uri-short",
            "a buffer shorter than it says",
            uri("data:;base64,AAAA".into()),
            Fail("lie outside"),
        ),
        gltf(
            "data-uri-percent",
            "half an escape at the end",
            uri(format!("data:,{}%4", "%00".repeat(36))),
            Warn("nothing to see"),
        ),
        gltf(
            "data-uri-many",
            "the same long buffer decoded often",
            {
                let data = format!("data:;base64,{}", "A".repeat(1 << 20));
                let buffers: Vec<_> = (0..40).map(|_| json!({"byteLength": 36, "uri": data})).collect();
                let views: Vec<_> = (0..40).map(|k| json!({"buffer": k, "byteLength": 36})).collect();
                let accessors: Vec<_> = (0..40)
                    .map(|k| json!({"bufferView": k, "componentType": 5126, "count": 3, "type": "VEC3"}))
                    .collect();
                let primitives: Vec<_> = (0..40).map(|k| json!({"attributes": {"POSITION": k}})).collect();
                json!({"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
                "meshes": [{"primitives": primitives}], "accessors": accessors, "bufferViews": views, "buffers": buffers}).to_string()
            },
            Warn("nothing to see"),
        ),
        glb(
            "buffer-claims-terabytes",
            "an allocation of a buffer's claimed length",
            triangle_with(|m| m.json["buffers"] = json!([{"byteLength": 1_000_000_000_000_u64}])),
            Warn("byteLength says"),
        ),
        glb(
            "buffer-length-negative",
            "a length that wraps",
            triangle_with(|m| m.json["buffers"] = json!([{"byteLength": -1}])),
            Warn("at least 0"),
        ),
        glb(
            "camera-of-zero",
            "a division by the camera's numbers",
            triangle_with(|m| {
                m.json["cameras"] = json!([{"type": "perspective", "perspective": {"yfov": 0, "znear": 0}}]);
                m.json["nodes"][0]["camera"] = 0.into();
            }),
            Draw,
        ),
        glb(
            "light-of-infinity",
            "light without end",
            triangle_with(|m| {
                m.json["extensionsUsed"] = json!(["KHR_lights_punctual"]);
                m.json["extensions"] = json!({"KHR_lights_punctual": {"lights": [{"type": "point", "intensity": 1e38, "color": [1e38, 1e38, 1e38]}]}});
                m.json["nodes"][0]["extensions"] = json!({"KHR_lights_punctual": {"light": 0}});
            }),
            Warn("out of range, clamped"),
        ),
        glb(
            "texture-transform-huge",
            "texture coordinates out of range",
            {
                let mut m = Model::textured();
                m.json["extensionsUsed"] = json!(["KHR_texture_transform"]);
                m.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["extensions"] =
                    json!({"KHR_texture_transform": {"scale": [1e30, -1e30], "offset": [1e38, 0]}});
                m.glb()
            },
            Warn("texture transform out of range"),
        ),
        glb(
            "material-out-of-range",
            "factors that break the shading",
            triangle_with(|m| {
                m.json["materials"] = json!([{"pbrMetallicRoughness": {"baseColorFactor": [1e30, -5, 3, 9], "roughnessFactor": -7, "metallicFactor": 1e20}, "emissiveFactor": [1e30, 0, 0]}]);
                m.primitive()["material"] = 0.into();
            }),
            Warn("material 0"),
        ),
    ]
}
