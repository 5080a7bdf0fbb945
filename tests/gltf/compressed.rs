//! Compressed data: meshopt views and Draco primitives give the scenes of their uncompressed forms.

use crate::common::files::draco::stream as draco_stream;
use crate::common::files::encoder::{self, Random};
use crate::common::files::meshopt::Views;
use crate::common::files::model::{F32, Model, U16, U32, messages, outcome, push};
use overcoat::jobs::Jobs;
use overcoat::limits::Limits;
use overcoat::load::{Context, LoadError, Loaded, NoResolver, load_bytes};
use overcoat::scene::MeshData;
use serde_json::{Value, json};

/// A wavy sheet of n x n vertices: positions, normals, texture coordinates, and two triangles for each square.
fn sheet(n: u32) -> MeshData {
    let mut sheet = MeshData::default();
    for k in 0..n * n {
        let (x, y) = ((k % n) as f32, (k / n) as f32);
        sheet.positions.push([x, y, (x * 0.25 - y * 0.5).abs()]);
        sheet.normals.push([[0.0, 0.0, 1.0], [0.0, 0.6, 0.8], [-1.0, 0.0, 0.0]][(k % 3) as usize]);
        sheet.uvs[0].push([x / 64.0, y / 64.0]);
        if k % n + 1 < n && k / n + 1 < n {
            sheet.triangles.extend([[k, k + 1, k + n], [k + n, k + 1, k + n + 1]]);
        }
    }
    sheet
}

fn bytes<const N: usize>(values: &[[f32; N]]) -> Vec<u8> {
    values.as_flattened().iter().flat_map(|v| v.to_le_bytes()).collect()
}

fn words(values: &[u32]) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_le_bytes()).collect()
}

/// The sheet as it is.
fn plain(sheet: &MeshData) -> Model {
    let mut model = Model::empty();
    let count = sheet.positions.len();
    let position = model.accessor("VEC3", F32, count, &bytes(&sheet.positions));
    let normal = model.accessor("VEC3", F32, count, &bytes(&sheet.normals));
    let uv = model.accessor("VEC2", F32, count, &bytes(&sheet.uvs[0]));
    let indices =
        model.accessor("SCALAR", U32, 3 * sheet.triangles.len(), &words(sheet.triangles.as_flattened()));
    model.json["meshes"] = json!([{"primitives": [{
        "attributes": {"POSITION": position, "NORMAL": normal, "TEXCOORD_0": uv},
        "indices": indices,
    }]}]);
    model
}

/// The same with every view compressed, over a fallback buffer that does not exist.
fn meshopt(sheet: &MeshData, extension: &'static str, version: u8) -> Model {
    let mut model = Model::empty();
    let views = &mut Views::new(extension, version, 1);
    let corners = sheet.triangles.as_flattened();
    let count = sheet.positions.len();
    let accessors = [
        ("VEC3", F32, count, views.attributes(&mut model, &bytes(&sheet.positions), 12, "NONE")),
        ("VEC3", F32, count, views.attributes(&mut model, &bytes(&sheet.normals), 12, "NONE")),
        ("VEC2", F32, count, views.attributes(&mut model, &bytes(&sheet.uvs[0]), 8, "NONE")),
        ("SCALAR", U32, corners.len(), views.triangles(&mut model, corners)),
    ]
    .map(|(kind, component, count, view)| {
        let accessor = json!({"bufferView": view, "componentType": component, "count": count, "type": kind});
        push(&mut model.json["accessors"], accessor)
    });
    model.json["buffers"] = json!([{"byteLength": model.bytes.len()}, views.fallback()]);
    model.json["extensionsUsed"] = json!([extension]);
    model.json["extensionsRequired"] = json!([extension]);
    model.json["meshes"] = json!([{"primitives": [{
        "attributes": {"POSITION": accessors[0], "NORMAL": accessors[1], "TEXCOORD_0": accessors[2]},
        "indices": accessors[3],
    }]}]);
    model
}

#[test]
fn meshopt_views_give_the_scene_of_plain_ones() {
    let sheet = sheet(23);
    let expected = outcome(&plain(&sheet).load());
    for (extension, version) in
        [("EXT_meshopt_compression", 0), ("KHR_meshopt_compression", 0), ("KHR_meshopt_compression", 1)]
    {
        let model = meshopt(&sheet, extension, version);
        assert!(outcome(&model.load()) == expected, "{extension} {version}");
    }
    // A file for readers without it too: the fallback is not read, and so it does not matter that it is of zeros.
    let mut model = meshopt(&sheet, "EXT_meshopt_compression", 0);
    model.json.as_object_mut().unwrap().remove("extensionsRequired");
    model.json["buffers"][1]["uri"] = "data:,".into();
    assert!(outcome(&model.load()) == expected);
}

#[test]
fn mistakes_in_meshopt_views_name_the_view() {
    let whole = meshopt(&sheet(5), "EXT_meshopt_compression", 0);
    let length = whole.bytes.len();
    for (key, value, message) in [
        ("mode", json!("VERTICES"), "bufferView 0: its compression mode is not known"),
        ("mode", json!("TRIANGLES"), "bufferView 0: its compression mode does not allow this byteStride"),
        ("filter", json!("ZIGZAG"), "bufferView 0: its compression filter is not known"),
        (
            "filter",
            json!("QUATERNION"),
            "bufferView 0: its compression filter does not allow this mode or byteStride",
        ),
        ("byteStride", json!(13), "bufferView 0: its compression mode does not allow this byteStride"),
        ("count", json!(24), "bufferView 0: its 300 bytes are more than its compressed data holds"),
        ("count", json!(u64::MAX), "bufferView 0: it has too many elements"),
        ("buffer", json!(2), "bufferView 0: there is no such buffer with its compressed data"),
        ("buffer", json!(1), "buffer 1 has neither a URI nor a binary chunk"),
        (
            "byteLength",
            json!(1u64 << 40),
            "bufferView 0: its compressed data is longer than its elements can be",
        ),
        ("byteLength", json!(0), "bufferView 0: its compressed data ends too early"),
        ("byteOffset", json!(1), "bufferView 0: its compressed data has no header of attributes"),
        ("byteOffset", json!(length), "compressed bytes from offset"),
        ("byteOffset", json!(u64::MAX), "compressed bytes from offset"),
    ] {
        let mut model = whole.clone();
        model.json["bufferViews"][0]["extensions"]["EXT_meshopt_compression"][key] = value;
        let error = model.load().unwrap_err();
        assert!(matches!(error, LoadError::Malformed { .. }), "{error}");
        assert!(error.to_string().contains(message), "{error}");
    }
    // A few bytes that stand for many are refused before they are there.
    let mut model = whole;
    let compression = &mut model.json["bufferViews"][0]["extensions"]["EXT_meshopt_compression"];
    compression["count"] = json!(u64::from(u32::MAX) + 1);
    let error = model.load().unwrap_err().to_string();
    assert!(error.contains("bufferView 0: ") && error.ends_with("(decoded_bytes)"), "{error}");
}

/// Padded elements are read as they were compressed, whether their view says so or not, and not if it says otherwise.
#[test]
fn padded_elements_have_the_stride_of_their_compression() {
    let mut model = plain(&sheet(3));
    let stream = encoder::attributes(&[0, 0, 127, 0].repeat(9), 4, 0, &mut Random::new(1));
    let view = model.view(&stream);
    model.json["bufferViews"][view]["extensions"] = json!({"EXT_meshopt_compression": {
        "buffer": 0, "byteOffset": model.json["bufferViews"][view]["byteOffset"], "byteLength": stream.len(),
        "byteStride": 4, "count": 9, "mode": "ATTRIBUTES",
    }});
    model.json["bufferViews"][view]["byteLength"] = 36.into();
    let normal =
        json!({"bufferView": view, "componentType": 5120, "normalized": true, "count": 9, "type": "VEC3"});
    let normal = push(&mut model.json["accessors"], normal);
    model.json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = normal.into();
    model.bytes.resize(model.bytes.len() + 36, 0);
    for stride in [None, Some(0), Some(4)] {
        if let Some(stride) = stride {
            model.json["bufferViews"][view]["byteStride"] = stride.into();
        }
        let scene = model.load().unwrap().scene;
        assert_eq!(scene.meshes()[0].normals(), [[0.0, 0.0, 1.0]; 9], "{stride:?}");
    }
    model.json["bufferViews"][view]["byteStride"] = 8.into();
    let message = outcome(&model.load());
    assert!(message.contains("its byteStride is 8, that of its compressed data 4"), "{message}");
}

/// Instances read their accessors while the scene graph is looked at.
#[test]
fn instances_may_be_compressed() {
    let mut model = plain(&sheet(3));
    let offsets = [[0.0f32; 3], [5.0, 0.0, 0.0], [0.0, 7.0, 0.0]];
    let stream = encoder::attributes(&bytes(&offsets), 12, 0, &mut Random::new(1));
    let view = model.view(&stream);
    model.json["bufferViews"][view]["extensions"] = json!({"EXT_meshopt_compression": {
        "buffer": 0, "byteOffset": model.json["bufferViews"][view]["byteOffset"], "byteLength": stream.len(),
        "byteStride": 12, "count": 3, "mode": "ATTRIBUTES",
    }});
    model.json["bufferViews"][view]["byteLength"] = 36.into();
    let accessor = json!({"bufferView": view, "componentType": F32, "count": 3, "type": "VEC3"});
    let accessor = push(&mut model.json["accessors"], accessor);
    model.json["nodes"][0]["extensions"] =
        json!({"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": accessor}}});
    model.bytes.resize(model.bytes.len() + 36, 0);
    let scene = model.load().unwrap().scene;
    assert_eq!(scene.instances().len(), 3);
    assert_eq!(scene.bounds().max[..2], [7.0, 9.0]);
}

/// A model whose only primitive is a Draco stream.
fn draco(sheet: &MeshData, stream: &[u8]) -> Model {
    let mut model = Model::empty();
    let view = model.view(stream);
    let count = sheet.positions.len();
    model.json["accessors"] = json!([
        {"componentType": F32, "count": count, "type": "VEC3"},
        {"componentType": F32, "count": count, "type": "VEC3"},
        {"componentType": F32, "count": count, "type": "VEC2"},
        {"componentType": U16, "count": 3 * sheet.triangles.len(), "type": "SCALAR"},
    ]);
    model.json["extensionsUsed"] = json!(["KHR_draco_mesh_compression"]);
    model.json["extensionsRequired"] = json!(["KHR_draco_mesh_compression"]);
    model.json["meshes"] = json!([{"primitives": [{
        "attributes": {"POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2},
        "indices": 3,
        "extensions": {"KHR_draco_mesh_compression": {
            "bufferView": view,
            "attributes": {"POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2},
        }},
    }]}]);
    model
}

/// All triangles as positions and texture coordinates of their corners, in an order of their own.
fn corners(loaded: &Loaded, precision: f32) -> Vec<[[i64; 5]; 3]> {
    let mesh = &loaded.scene.meshes()[0];
    let mut triangles: Vec<[[i64; 5]; 3]> = mesh
        .triangles()
        .iter()
        .map(|t| {
            let mut corners = t.map(|v| {
                let ([x, y, z], [u, v]) = (mesh.positions()[v as usize], mesh.uvs(0)[v as usize]);
                [x, y, z, u * 64.0, v * 64.0].map(|v| (v / precision).round() as i64)
            });
            // From the smallest, with the winding kept.
            let first = (0..3).min_by_key(|&k| corners[k]).unwrap();
            corners.rotate_left(first);
            corners
        })
        .collect();
    triangles.sort_unstable();
    triangles
}

/// Sequential, edgebreaker and edgebreaker with valences; with and without quantisation.
#[test]
fn draco_streams_give_the_triangles_of_plain_arrays() {
    let sheet = sheet(17);
    let plain = plain(&sheet).load().unwrap();
    for (method, speed) in [(0, 10), (0, 5), (1, 9), (1, 5), (1, 3), (1, 0)] {
        for bits in [0, 14] {
            let stream = draco_stream(&sheet, method, speed, bits);
            let loaded = draco(&sheet, &stream).load().unwrap();
            assert_eq!(messages(&loaded), [""; 0]);
            assert_eq!(loaded.scene.triangle_count(), 2 * 16 * 16);
            assert!(
                corners(&loaded, 0.125) == corners(&plain, 0.125),
                "method {method}, speed {speed}, {bits} bits"
            );
            assert_eq!(loaded.scene.meshes()[0].normals().len(), loaded.scene.meshes()[0].positions().len());
        }
    }
}

/// Attributes that are not in the stream come from their accessors; what is in it goes before what is beside it.
#[test]
fn draco_primitives_may_have_other_attributes() {
    let sheet = sheet(4);
    let stream = draco_stream(&sheet, 0, 10, 0);
    let mut model = draco(&sheet, &stream);
    let color = model.accessor("VEC3", F32, 16, &bytes(&[[0.5f32, 0.25, 1.0]; 16]));
    model.primitive()["attributes"]["COLOR_0"] = color.into();
    let wrong = model.view(&[0; 192]);
    model.json["accessors"][0]["bufferView"] = wrong.into();
    let scene = model.load().unwrap().scene;
    assert_eq!(scene.meshes()[0].colors(), [[0.5, 0.25, 1.0, 1.0]; 16]);
    assert_eq!(scene.bounds().max[..2], [3.0, 3.0]);
}

#[test]
fn mistakes_in_draco_primitives_name_the_primitive() {
    let sheet = sheet(4);
    let whole = draco(&sheet, &draco_stream(&sheet, 1, 5, 11));
    type Damage = fn(&mut Value);
    let cases: [(Damage, &str); 7] = [
        (|p| drop(p.as_object_mut().unwrap().remove("indices")), "without a bufferView or indices"),
        (
            |p| p["extensions"]["KHR_draco_mesh_compression"]["bufferView"] = 9.into(),
            "there is no bufferView 9",
        ),
        (
            |p| p["extensions"]["KHR_draco_mesh_compression"]["attributes"]["NORMAL"] = 7.into(),
            "its Draco data has no attribute 7",
        ),
        (
            |p| p["extensions"]["KHR_draco_mesh_compression"]["attributes"]["NORMAL"] = 2.into(),
            "NORMAL: accessor 1 has elements of the wrong type",
        ),
        (|p| p["mode"] = 5.into(), "of anything but lists of triangles cannot be read"),
        // Three corners are one triangle.
        (|p| p["indices"] = 4.into(), "its Draco data holds more than its accessors say"),
        (|p| p["attributes"]["POSITION"] = 4.into(), "its Draco data holds more than its accessors say"),
    ];
    for (damage, message) in cases {
        let mut model = whole.clone();
        push(&mut model.json["accessors"], json!({"componentType": F32, "count": 3, "type": "SCALAR"}));
        damage(model.primitive());
        let complaint = model.complaint();
        assert!(complaint.contains("mesh 0, primitive 0") && complaint.contains(message), "{complaint}");
    }
    // Memory is asked for before it is used.
    let limits = Limits::default().with_decoded_bytes(20_000);
    let error = whole.load_within(&limits).unwrap_err();
    assert!(matches!(error, LoadError::Limit(_)), "{error}");
}

/// Each primitive reads its stream for itself, so a long one cannot be named by many.
#[test]
fn streams_that_many_primitives_name_add_up() {
    let sheet = sheet(4);
    let mut stream = draco_stream(&sheet, 1, 5, 11);
    stream.resize(1 << 20, 0);
    let mut model = draco(&sheet, &stream);
    let primitive = model.primitive().clone();
    model.json["meshes"][0]["primitives"] = vec![primitive; 100].into();
    assert_eq!(model.load().unwrap().scene.instances().len(), 100);
    let error = load(&model.glb()).unwrap_err();
    assert!(matches!(error, LoadError::Limit(_)), "{error}");
    assert!(error.to_string().starts_with("mesh 0, primitive 6"), "{error}");
}

fn load(file: &[u8]) -> Result<Loaded, LoadError> {
    let limits = Limits::default().with_decoded_bytes(64 << 20).with_triangles(1 << 20);
    let jobs = Jobs::new(1);
    load_bytes(file, None, &Context { resolver: &NoResolver, limits: &limits, jobs: &jobs })
}

/// Whatever is done to compressed bytes, there is a scene or one line.
#[test]
fn damaged_data_does_not_panic() {
    let sheet = sheet(6);
    let mut random = Random::new(99);
    let mut models =
        vec![meshopt(&sheet, "EXT_meshopt_compression", 0), meshopt(&sheet, "KHR_meshopt_compression", 1)];
    for (method, speed) in [(0, 10), (1, 9), (1, 5), (1, 0)] {
        models.push(draco(&sheet, &draco_stream(&sheet, method, speed, 11)));
    }
    let mut refused = 0;
    for model in models {
        let file = model.glb();
        load(&file).unwrap();
        let start = file.len() - model.bytes.len().next_multiple_of(4);
        for round in 0..1500 {
            let mut damaged = file.clone();
            for _ in 0..1 + random.below(4) {
                let at = start + random.below(file.len() - start);
                damaged[at] =
                    [random.next() as u8, damaged[at] ^ 1 << random.below(8), 0, 255][random.below(4)];
            }
            if round % 5 == 0 {
                let from = start + random.below(file.len() - start);
                damaged[from..].fill(0);
            }
            match load(&damaged) {
                Ok(loaded) => assert!(messages(&loaded).iter().all(|m| !m.contains('\n'))),
                Err(error) => {
                    refused += 1;
                    assert!(!error.to_string().contains('\n'), "{error}");
                }
            }
        }
    }
    assert!(refused > 1000, "{refused}");
}
