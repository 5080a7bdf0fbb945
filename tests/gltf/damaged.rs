//! Files that break the rules: each ends in a line that names the element, none in a panic; what is whole in them is
//! drawn.

use crate::common::files::model::{Model, U8, U16, load_in_parts, load_text, messages, outcome};
use overcoat::limits::Limits;
use overcoat::load::LoadError;
use proptest::prelude::*;
use serde_json::{Value, json};

/// A triangle with indices, normals and a texture.
fn whole() -> Model {
    let mut model = Model::textured();
    let normal = model.floats("VEC3", &[0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0]);
    let indices = model.accessor("SCALAR", U16, 3, &[0, 0, 1, 0, 2, 0]);
    model.primitive()["attributes"]["NORMAL"] = normal.into();
    model.primitive()["indices"] = indices.into();
    model
}

#[test]
fn every_fault_is_named_with_its_element() {
    assert!(whole().load().unwrap().warnings.is_empty());
    type Damage = fn(&mut Value);
    let cases: [(Damage, &str); 26] = [
        (
            |j| j["accessors"][3]["count"] = 7.into(),
            "mesh 0, primitive 0: accessor 3: 7 elements from byte 0 lie outside bufferView 4 of 6 bytes",
        ),
        (
            |j| j["accessors"][2]["count"] = 2.into(),
            "mesh 0, primitive 0: NORMAL is left out: NORMAL has 2 elements for 3 vertices",
        ),
        (
            |j| j["accessors"][2]["type"] = "VEC2".into(),
            "mesh 0, primitive 0: NORMAL is left out: NORMAL: accessor 2 has elements of the wrong type",
        ),
        (
            |j| j["accessors"][2]["type"] = "MAT3".into(),
            "mesh 0, primitive 0: NORMAL is left out: accessor 2: neither scalars nor vectors",
        ),
        (
            |j| j["accessors"][0]["componentType"] = 5130.into(),
            "mesh 0, primitive 0: accessor 0: unknown componentType 5130",
        ),
        (
            |j| j["accessors"][0]["byteOffset"] = 4.into(),
            "mesh 0, primitive 0: accessor 0: 3 elements from byte 4 lie outside bufferView 0 of 36 bytes",
        ),
        (
            |j| j["accessors"][0]["byteOffset"] = json!(u64::MAX),
            "mesh 0, primitive 0: accessor 0: 3 elements from byte 18446744073709551615 lie outside bufferView 0 of 36 bytes",
        ),
        (|j| j["accessors"][0]["bufferView"] = 50.into(), "mesh 0, primitive 0: there is no bufferView 50"),
        (
            |j| j["bufferViews"][0]["buffer"] = 3.into(),
            "mesh 0, primitive 0: bufferView 0: there is no buffer 3",
        ),
        (
            |j| drop(j["bufferViews"][0].as_object_mut().unwrap().remove("buffer")),
            "mesh 0, primitive 0: bufferView 0 names no buffer",
        ),
        (
            |j| j["bufferViews"][0]["byteOffset"] = 100_000.into(),
            "mesh 0, primitive 0: bufferView 0: 36 bytes from offset 100000 lie outside buffer 0 of 184 bytes",
        ),
        (
            |j| j["bufferViews"][0]["byteStride"] = 8.into(),
            "mesh 0, primitive 0: accessor 0: byteStride 8 of bufferView 0 is less than the 12 bytes of an element",
        ),
        (
            |j| j["bufferViews"][0]["byteStride"] = json!(u64::MAX),
            "mesh 0, primitive 0: accessor 0: 3 elements from byte 0 lie outside",
        ),
        (
            |j| j["meshes"][0]["primitives"][0]["indices"] = 44.into(),
            "mesh 0, primitive 0: there is no accessor 44",
        ),
        (
            |j| j["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = 44.into(),
            "mesh 0, primitive 0: TEXCOORD_0 is left out: there is no accessor 44",
        ),
        (
            |j| j["meshes"][0]["primitives"][0]["material"] = 5.into(),
            "mesh 0, primitive 0: there is no material 5; the default one is used",
        ),
        (|j| j["nodes"][0]["mesh"] = 8.into(), "node 0: there is no mesh 8"),
        (|j| j["scenes"][0]["nodes"] = json!([0, 12]), "the scene names node 12, which there is not"),
        (
            |j| j["accessors"][1]["byteOffset"] = (-4).into(),
            "accessor 1, byteOffset cannot be read and is left out: invalid value: integer `-4`, expected a whole number of \
             at least 0",
        ),
        (
            |j| j["accessors"][1]["count"] = json!(1.5),
            "accessor 1, count cannot be read and is left out: invalid value: floating point `1.5`",
        ),
        (
            |j| j["nodes"][0]["matrix"] = json!([1, 2, 3]),
            "node 0, matrix cannot be read and is left out: invalid length 3, expected an array of length 16",
        ),
        (
            |j| j["materials"][0]["pbrMetallicRoughness"]["metallicFactor"] = "shiny".into(),
            "material 0, pbrMetallicRoughness, metallicFactor cannot be read and is left out: invalid type: string",
        ),
        (
            |j| j["meshes"][0]["primitives"][0]["mode"] = json!({}),
            "mesh 0, primitives 0, mode cannot be read and is left out: invalid type: map",
        ),
        (
            |j| j["nodes"] = 5.into(),
            "invalid type: integer `5`, expected a list with elements of the kind node",
        ),
        (
            |j| j["buffers"] = json!([{"byteLength": 1_000_000_000_000_u64}]),
            "bytes where its byteLength says 1000000000000",
        ),
        (
            |j| j["buffers"] = json!([{"byteLength": 1, "uri": "gone.bin"}]),
            "'gone.bin' cannot be read: no such file",
        ),
    ];
    for (damage, expected) in cases {
        let mut model = whole();
        damage(&mut model.json);
        let complaint = model.complaint();
        assert!(complaint.contains(expected), "{complaint}\n{expected}");
    }
}

/// A second, whole primitive is drawn whatever is wrong with the first.
#[test]
fn what_is_whole_is_drawn() {
    type Damage = fn(&mut Value);
    let cases: [(Damage, &str); 7] = [
        (
            |p| p["attributes"]["POSITION"] = 77.into(),
            "mesh 0, primitive 0: there is no accessor 77; not drawn",
        ),
        (|p| p["mode"] = 9.into(), "mesh 0, primitive 0: unknown mode 9; not drawn"),
        (|p| p["indices"] = 77.into(), "mesh 0, primitive 0: there is no accessor 77; not drawn"),
        (|p| p["indices"] = 0.into(), "mesh 0, primitive 0: accessor 0 does not hold indices; not drawn"),
        (
            |p| p["attributes"]["POSITION"] = 1.into(),
            "mesh 0, primitive 0: POSITION: accessor 1 has elements of the wrong type; not drawn",
        ),
        (|p| p["extensions"] = json!({"KHR_draco_mesh_compression": {"bufferView": 0}}), "not drawn"),
        (|p| p["attributes"] = json!({}), "mesh 0, primitive 0 has no positions and is not drawn"),
    ];
    for (damage, expected) in cases {
        let mut model = whole();
        let mut second = model.primitive().clone();
        damage(&mut second);
        model.json["meshes"][0]["primitives"].as_array_mut().unwrap().insert(0, second);
        let loaded = model.load().unwrap();
        assert_eq!(loaded.scene.triangle_count(), 1, "{expected}");
        let warnings = messages(&loaded);
        assert!(warnings.len() == 1 && warnings[0].contains(expected), "{warnings:?}\n{expected}");
    }
    // A buffer that lacks its end has the rest.
    let mut model = whole();
    model.json["buffers"] = json!([{"byteLength": 500}]);
    let warning =
        format!("buffer 0 has {} bytes where its byteLength says 500", model.bytes.len().next_multiple_of(4));
    assert_eq!(model.complaint(), warning);
}

#[test]
fn indices_out_of_range() {
    let mut model = whole();
    let indices = model.accessor("SCALAR", U8, 9, &[0, 1, 2, 0, 9, 1, 2, 1, 0]);
    model.primitive()["indices"] = indices.into();
    let loaded = model.load().unwrap();
    assert_eq!(loaded.scene.triangle_count(), 2);
    assert_eq!(
        messages(&loaded),
        ["mesh 0, primitive 0: 1 triangles, lines or points left out: their vertices are out of range"]
    );
    let mut model = whole();
    model.json["meshes"][0]["name"] = "torn".into();
    let indices = model.accessor("SCALAR", U8, 3, &[0, 1, 3]);
    model.primitive()["indices"] = indices.into();
    assert_eq!(model.error(), "glTF: mesh 0 'torn', primitive 0: index 3 is out of range of 3 vertices");
    let sparse = model.view(&[9]);
    let values = model.view(&[0]);
    model.json["accessors"][indices]["sparse"] = json!({
        "count": 1, "indices": {"bufferView": sparse, "componentType": U8}, "values": {"bufferView": values},
    });
    assert!(model.error().ends_with("accessor 4: sparse index 9 of 3 elements"), "{}", model.error());
    model.json["accessors"][indices]["sparse"]["count"] = 4.into();
    assert!(model.error().ends_with("accessor 4: 4 sparse elements of 3"), "{}", model.error());
}

#[test]
fn positions_must_be_finite_and_in_range() {
    for (bad, expected) in [
        (f32::NAN, "mesh 0, primitive 0: position is not a finite number"),
        (f32::INFINITY, "mesh 0, primitive 0: position is not a finite number"),
        (3e38, "mesh 0, primitive 0: position is out of range (limit 1000000000000000)"),
    ] {
        let mut model = Model::triangle();
        model.bytes[4..8].copy_from_slice(&bad.to_le_bytes());
        assert_eq!(model.error(), expected);
    }
    // The other triangles are drawn, and the vertex is no part of the bounds.
    let mut model = Model::empty();
    let bad = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.5, f32::NAN, 2.0];
    let position = model.floats("VEC3", &bad);
    let indices = model.accessor("SCALAR", U8, 6, &[0, 1, 2, 0, 1, 3]);
    model.json["meshes"] =
        json!([{"primitives": [{"attributes": {"POSITION": position}, "indices": indices}]}]);
    let loaded = model.load().unwrap();
    assert_eq!(loaded.scene.triangle_count(), 1);
    assert_eq!(loaded.scene.bounds().max, [1.0, 1.0, 0.0]);
    assert_eq!(
        messages(&loaded),
        ["mesh 0, primitive 0: 1 triangles, lines or points left out: positions not finite or beyond 1e15"]
    );
}

#[test]
fn files_without_triangles() {
    assert_eq!(
        messages(&load_text(r#"{"asset":{"version":"2.0"}}"#, &Limits::default()).unwrap()),
        ["no triangles"]
    );
    let mut model = Model::triangle();
    model.primitive()["attributes"] = json!({});
    assert_eq!(model.warnings(), ["mesh 0, primitive 0 has no positions and is not drawn", "no triangles"]);
    let mut model = Model::triangle();
    model.json["accessors"][0]["count"] = 0.into();
    assert_eq!(model.warnings(), ["no triangles"]);
}

/// A hostile file cannot flood whoever reads its warnings.
#[test]
fn warnings_are_bounded() {
    let mut model = Model::textured();
    let primitive = model.primitive().clone();
    model.json["materials"] = vec![json!({"name": "m\n".repeat(200), "alphaMode": "X"}); 5000].into();
    let primitives = (0..5000).map(|k| {
        let mut primitive = primitive.clone();
        primitive["material"] = k.into();
        primitive
    });
    model.json["meshes"] = json!([{"primitives": primitives.collect::<Vec<_>>()}]);
    let warnings = model.warnings();
    assert_eq!(warnings.len(), 101);
    assert!(warnings.iter().all(|w| w.len() < 200 && !w.contains('\n')));
    assert_eq!(warnings[100], "and 4900 more warnings");
}

/// Memory is granted before it is taken: a few hundred bytes of text cannot ask for gigabytes.
#[test]
fn shared_accessors_add_up() {
    let mut model = Model::triangle();
    model.json["accessors"][0].as_object_mut().unwrap().remove("bufferView");
    model.json["accessors"][0]["count"] = 3_000_000.into();
    // The same accessor as many different meshes.
    let primitives: Vec<Value> = (0..200)
        .map(|k| json!({"attributes": {"POSITION": 0, "NORMAL": 0}, "mode": 4 + k % 3, "material": k}))
        .chain((0..200).map(|k| json!({"attributes": {"POSITION": 0, "TEXCOORD_0": k}})))
        .collect();
    model.json["accessors"] = (0..200)
        .map(|k| json!({"componentType": 5126, "count": 3_000_000, "type": if k == 0 { "VEC3" } else { "VEC2" }}))
        .collect();
    model.json["materials"] = vec![json!({}); 200].into();
    model.json["meshes"] = json!([{"primitives": primitives}]);
    let error = model.load().unwrap_err();
    assert!(matches!(error, LoadError::Limit(_)), "{error}");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    /// Any few bytes of a file may be anything.
    #[test]
    fn flipped_bytes_do_not_panic(
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
        cut in prop::option::of(any::<prop::sample::Index>()),
    ) {
        let mut file = whole().glb();
        for (at, value) in changes {
            let at = at.index(file.len());
            file[at] = value;
        }
        if let Some(cut) = cut {
            file.truncate(cut.index(file.len()));
        }
        let limits = Limits::default().with_decoded_bytes(64 << 20).with_triangles(1 << 20);
        let jobs = overcoat::jobs::Jobs::new(1);
        let context = overcoat::load::Context { resolver: &overcoat::load::NoResolver, limits: &limits, jobs: &jobs };
        match overcoat::load::load_bytes(&file, None, &context) {
            Ok(loaded) => prop_assert!(loaded.warnings.iter().all(|w| !w.message.contains('\n'))),
            Err(error) => prop_assert!(!error.to_string().contains('\n'), "{}", error),
        }
        // The same file with zeros behind it, from memory and in parts.
        if file.starts_with(b"glTF") {
            let in_parts = load_in_parts(&file, &limits);
            file.resize(3 << 20, 0);
            let whole = overcoat::load::load_bytes(&file, None, &context);
            if let Some(in_parts) = in_parts && !String::from_utf8_lossy(&file[..4096]).contains("\"uri\"") {
                prop_assert_eq!(outcome(&in_parts), outcome(&whole));
            }
        }
    }

    /// Any number in the JSON may be any other.
    #[test]
    fn other_numbers_do_not_panic(which in any::<prop::sample::Index>(), with in prop_oneof![
        Just(json!(-1)), Just(json!(0)), Just(json!(1)), Just(json!(5)), Just(json!(u32::MAX)), Just(json!(u64::MAX)),
        Just(json!(1e300)), Just(json!("x")), Just(json!([])), Just(json!({})), Just(Value::Null),
    ]) {
        fn count(v: &Value) -> usize {
            match v {
                Value::Array(list) => list.iter().map(count).sum(),
                Value::Object(map) => map.values().map(count).sum(),
                Value::Number(_) => 1,
                _ => 0,
            }
        }
        fn replace(v: &mut Value, left: &mut usize, with: &Value) {
            match v {
                Value::Array(list) => list.iter_mut().for_each(|v| replace(v, left, with)),
                Value::Object(map) => map.values_mut().for_each(|v| replace(v, left, with)),
                Value::Number(_) => {
                    if *left == 0 {
                        *v = with.clone();
                    }
                    *left = left.wrapping_sub(1);
                }
                _ => {}
            }
        }
        let mut model = whole();
        let mut left = which.index(count(&model.json));
        replace(&mut model.json, &mut left, &with);
        if let Err(error) = model.load() {
            prop_assert!(!error.to_string().contains('\n'), "{}", error);
        }
    }
}
