//! glTF accessors and buffer views: arithmetic on numbers of a file.

use super::attack::Must::{Exceed, Fail, Warn};
use super::attack::{Attack, Must};
use super::model::{Model, U8, U16, U32};
use serde_json::{Value, json};

/// A triangle with indices.
fn whole() -> Model {
    let mut model = Model::triangle();
    let indices = model.accessor("SCALAR", U16, 3, &[0, 0, 1, 0, 2, 0]);
    model.primitive()["indices"] = indices.into();
    model
}

fn attack(name: &'static str, tries: &'static str, change: impl FnOnce(&mut Model), must: Must) -> Attack {
    let mut model = whole();
    change(&mut model);
    Attack::model(name, tries, "x.glb", model.glb(), must)
}

/// Sets a number of accessor 0 or of its view.
fn set(model: &mut Model, list: &str, key: &str, value: impl Into<Value>) {
    model.json[list][0][key] = value.into();
}

/// An accessor of many zeros, that needs no bytes in the file.
fn zeros(model: &mut Model, count: u64) {
    let accessor = &mut model.json["accessors"][0];
    accessor.as_object_mut().unwrap().remove("bufferView");
    accessor["count"] = count.into();
    model.primitive().as_object_mut().unwrap().remove("indices");
}

pub fn attacks() -> Vec<Attack> {
    vec![
        attack(
            "count-beyond-view",
            "a read past the view",
            |m| set(m, "accessors", "count", 4),
            Fail("lie outside bufferView 0"),
        ),
        attack(
            "count-maximum",
            "an overflow of count times size",
            |m| set(m, "accessors", "count", u64::MAX),
            Fail("a count of 18446744073709551615"),
        ),
        attack(
            "count-negative",
            "a count that wraps",
            |m| set(m, "accessors", "count", -1),
            Fail("out of range of 0 vertices"),
        ),
        attack(
            "offset-maximum",
            "an overflow of the offset",
            |m| set(m, "accessors", "byteOffset", u64::MAX),
            Fail("lie outside bufferView 0"),
        ),
        attack(
            "offset-wraps-32",
            "an offset that wraps in 32 bits",
            |m| set(m, "accessors", "byteOffset", 1_u64 << 32),
            Fail("lie outside bufferView 0"),
        ),
        attack(
            "stride-zero",
            "the same element for ever",
            |m| set(m, "bufferViews", "byteStride", 0),
            Must::Draw,
        ),
        attack(
            "stride-one",
            "elements that overlap",
            |m| set(m, "bufferViews", "byteStride", 1),
            Fail("byteStride 1"),
        ),
        attack(
            "stride-maximum",
            "an overflow of stride times count",
            |m| set(m, "bufferViews", "byteStride", u64::MAX),
            Fail("lie outside bufferView 0"),
        ),
        attack(
            "view-offset-maximum",
            "an overflow of the view's end",
            |m| set(m, "bufferViews", "byteOffset", u64::MAX),
            Fail("lie outside buffer 0"),
        ),
        attack(
            "view-length-maximum",
            "a view of everything",
            |m| set(m, "bufferViews", "byteLength", u64::MAX),
            Warn("reaches beyond"),
        ),
        attack(
            "view-of-nothing",
            "a list with a gap",
            |m| set(m, "accessors", "bufferView", 99),
            Fail("there is no bufferView 99"),
        ),
        attack(
            "component-type-unknown",
            "a size of no type",
            |m| set(m, "accessors", "componentType", 5124),
            Fail("unknown componentType"),
        ),
        attack(
            "positions-of-bytes",
            "another size than is read",
            |m| set(m, "accessors", "componentType", U8),
            Warn("nothing to see"),
        ),
        attack(
            "matrix-accessor",
            "an element with padding",
            |m| set(m, "accessors", "type", "MAT4"),
            Fail("accessor 0"),
        ),
        attack(
            "index-out-of-range",
            "a read past the vertices",
            |m| {
                let at = m.bytes.len() - 2;
                m.bytes[at] = 3;
            },
            Fail("index 3 is out of range of 3 vertices"),
        ),
        attack(
            "index-maximum",
            "an index that wraps",
            |m| {
                let indices = m.accessor("SCALAR", U32, 3, &[0, 0, 0, 0, 1, 0, 0, 0, 255, 255, 255, 255]);
                m.primitive()["indices"] = indices.into();
            },
            Fail("out of range of 3 vertices"),
        ),
        attack(
            "index-restart",
            "primitive restart, which is not allowed",
            |m| {
                let indices = m.accessor("SCALAR", U16, 3, &[0, 0, 1, 0, 255, 255]);
                m.primitive()["indices"] = indices.into();
            },
            Fail("out of range of 3 vertices"),
        ),
        attack(
            "zeros-by-the-billion",
            "memory for an accessor without bytes",
            |m| zeros(m, 1 << 40),
            Exceed("decoded_bytes"),
        ),
        attack(
            "zeros-within-vertices",
            "a million triangles from 200 bytes",
            |m| zeros(m, 1 << 22),
            Exceed("triangles"),
        ),
        attack(
            "zeros-shared",
            "the same accessor as many meshes",
            |m| {
                zeros(m, 60_000);
                let primitives: Vec<Value> = (0..500).map(|k| json!({"attributes": {"POSITION": 0, "NORMAL": 0}, "mode": 4 + k % 3, "material": k})).collect();
                m.json["materials"] = vec![json!({}); 500].into();
                m.json["meshes"] = json!([{"primitives": primitives}]);
            },
            Exceed("triangles"),
        ),
        attack(
            "positions-not-finite",
            "not-a-number in the bounds",
            |m| m.bytes[..4].copy_from_slice(&f32::NAN.to_le_bytes()),
            Fail("not a finite number"),
        ),
        attack(
            "positions-infinite",
            "infinite bounds",
            |m| m.bytes[..4].copy_from_slice(&f32::INFINITY.to_le_bytes()),
            Fail("not a finite number"),
        ),
        attack(
            "positions-huge",
            "an overflow in the camera",
            |m| m.bytes[..4].copy_from_slice(&3e38_f32.to_le_bytes()),
            Fail("out of range"),
        ),
        attack(
            "positions-subnormal",
            "a division by a tiny size",
            |m| {
                for k in 0..9 {
                    let v = f32::from_le_bytes(m.bytes[4 * k..4 * k + 4].try_into().unwrap());
                    m.bytes[4 * k..4 * k + 4].copy_from_slice(&(v * 1e-42).to_le_bytes());
                }
            },
            Warn("nothing to see"),
        ),
        attack(
            "bounds-that-lie",
            "trust in the accessor's own bounds",
            |m| {
                set(m, "accessors", "min", json!([1e30, 1e30, 1e30]));
                set(m, "accessors", "max", json!([-1e30, 0, "x"]));
            },
            Must::Draw,
        ),
        attack(
            "normals-of-another-length",
            "a read past the shorter list",
            |m| {
                let normals = m.floats("VEC3", &[0.0, 0.0, 1.0, 0.0, 0.0, 1.0]);
                m.primitive()["attributes"]["NORMAL"] = normals.into();
            },
            Warn("NORMAL has 2 elements for 3 vertices"),
        ),
        attack(
            "normals-zero",
            "a division by the length",
            |m| {
                let normals = m.floats("VEC3", &[0.0; 9]);
                m.primitive()["attributes"]["NORMAL"] = normals.into();
            },
            Must::Draw,
        ),
        attack(
            "sparse-more-than-all",
            "more replacements than elements",
            |m| sparse(m, 4, &[0; 4]),
            Fail("4 sparse elements of 3"),
        ),
        attack(
            "sparse-maximum",
            "an overflow of the sparse count",
            |m| sparse(m, u64::MAX, &[0; 4]),
            Fail("sparse elements of 3"),
        ),
        attack(
            "sparse-out-of-range",
            "a write past the elements",
            |m| sparse(m, 1, &[9]),
            Fail("sparse index 9 of 3 elements"),
        ),
        attack(
            "sparse-descending",
            "replacements in the wrong order",
            |m| sparse(m, 2, &[2, 1]),
            Warn("nothing to see"),
        ),
        attack(
            "sparse-view-short",
            "a read past the values",
            |m| {
                sparse(m, 3, &[0, 1, 2]);
                let last = m.json["bufferViews"].as_array().unwrap().len() - 1;
                m.json["bufferViews"][last]["byteLength"] = 8.into();
            },
            Fail("accessor 0"),
        ),
        attack(
            "sparse-without-values",
            "a part that is not there",
            |m| m.json["accessors"][0]["sparse"] = json!({"count": 1}),
            Fail("accessor 0"),
        ),
        attack(
            "mode-unknown",
            "a kind of primitive that is none",
            |m| m.primitive()["mode"] = 99.into(),
            Fail("mode"),
        ),
        attack(
            "strip-of-millions",
            "triangles from shared zeros",
            |m| {
                zeros(m, 900_000);
                m.primitive()["mode"] = 5.into();
                m.json["nodes"] = json!([{"mesh": 0}, {"mesh": 0}, {"mesh": 0}]);
                m.json["scenes"][0]["nodes"] = json!([0, 1, 2]);
            },
            Exceed("triangles"),
        ),
        attack(
            "uv-set-huge",
            "a texture coordinate set that is not there",
            |m| {
                m.json["materials"] = json!([{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0, "texCoord": 4_000_000_000_u64}}}]);
                m.json["textures"] = json!([{"source": 0}]);
                m.json["images"] = json!([{"uri": "data:image/png;base64,iVBORw0KGgo="}]);
                m.primitive()["material"] = 0.into();
            },
            Warn("Texture"),
        ),
    ]
}

/// Makes the positions sparse, with these indices.
fn sparse(model: &mut Model, count: u64, indices: &[u8]) {
    let at = model.view(indices);
    let values = model.view(&[0; 36]);
    model.json["accessors"][0]["sparse"] = json!({
        "count": count, "indices": {"bufferView": at, "componentType": U8}, "values": {"bufferView": values},
    });
}
