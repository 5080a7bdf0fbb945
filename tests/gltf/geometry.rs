//! Accessors and primitives.

use crate::common::files::model::{F32, I8, I16, Model, U8, U16, U32, messages, push};
use overcoat::limits::Limits;
use overcoat::scene::PrimitiveKind;
use serde_json::json;

/// The three vertices of the triangle in the form of a component type, at a stride of four bytes or more.
fn quantised(component: u32, normalized: bool, corners: &[[i32; 3]; 3]) -> Vec<[f32; 3]> {
    let mut model = Model::empty();
    let mut bytes = Vec::new();
    let stride = if matches!(component, I8 | U8) { 4 } else { 8 };
    for corner in corners {
        let start = bytes.len();
        for &v in corner {
            match component {
                I8 => bytes.extend((v as i8).to_le_bytes()),
                U8 => bytes.extend((v as u8).to_le_bytes()),
                I16 => bytes.extend((v as i16).to_le_bytes()),
                _ => bytes.extend((v as u16).to_le_bytes()),
            }
        }
        bytes.resize(start + stride, 0xee);
    }
    // The last element does not fill its stride.
    bytes.truncate(2 * stride + if stride == 4 { 3 } else { 6 });
    let position = model.accessor("VEC3", component, 3, &bytes);
    model.json["bufferViews"][0]["byteStride"] = stride.into();
    model.json["accessors"][position]["normalized"] = normalized.into();
    model.json["meshes"] = json!([{"primitives": [{"attributes": {"POSITION": position}}]}]);
    model.json["extensionsUsed"] = json!(["KHR_mesh_quantization"]);
    model.json["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
    let loaded = model.load().unwrap();
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    loaded.scene.meshes()[0].positions().to_vec()
}

#[test]
fn quantised_positions() {
    let corners = [[0, 0, 0], [127, 1, 2], [3, 100, 4]];
    let plain = corners.map(|c| c.map(|v| v as f32));
    for component in [I8, U8, I16, U16] {
        assert_eq!(quantised(component, false, &corners), plain, "{component}");
    }
    let scaled = |scale: f32| corners.map(|c| c.map(|v| v as f32 / scale));
    assert_eq!(quantised(I8, true, &corners), scaled(127.0));
    assert_eq!(quantised(U8, true, &corners), scaled(255.0));
    assert_eq!(quantised(I16, true, &corners), scaled(32767.0));
    assert_eq!(quantised(U16, true, &corners), scaled(65535.0));
    let negative = [[0, 0, 0], [-128, 0, 0], [0, -127, 0]];
    assert_eq!(quantised(I8, true, &negative), [[0.0; 3], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]]);
}

#[test]
fn every_index_type() {
    for (component, bytes) in
        [(U8, vec![2, 1, 0]), (U16, vec![2, 0, 1, 0, 0, 0]), (U32, vec![2, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0])]
    {
        let mut model = Model::triangle();
        let indices = model.accessor("SCALAR", component, 3, &bytes);
        model.primitive()["indices"] = indices.into();
        assert_eq!(model.load().unwrap().scene.meshes()[0].triangles(), [[2, 1, 0]], "{component}");
        // Only unsigned scalars are indices.
        model.json["accessors"][indices]["componentType"] =
            json!(if component == U32 { F32 } else { component - 1 });
        assert!(model.error().contains("does not hold indices"), "{}", model.error());
    }
}

#[test]
fn topologies() {
    let with_mode = |mode: u32| {
        let mut model = Model::triangle();
        let position = model.floats("VEC3", &(0..15).map(|k| (k * k % 7) as f32).collect::<Vec<_>>());
        model.primitive()["attributes"]["POSITION"] = position.into();
        let indices = model.accessor("SCALAR", U8, 5, &[0, 1, 2, 3, 4]);
        model.primitive()["indices"] = indices.into();
        model.primitive()["mode"] = mode.into();
        model
    };
    let triangles = |mode| with_mode(mode).load().unwrap().scene.meshes()[0].triangles().to_vec();
    assert_eq!(triangles(4), [[0, 1, 2]]);
    assert_eq!(triangles(5), [[0, 1, 2], [1, 3, 2], [2, 3, 4]]);
    assert_eq!(triangles(6), [[1, 2, 0], [2, 3, 0], [3, 4, 0]]);
    // In order, each of them a point: not listed.
    let points = with_mode(0).load().unwrap().scene.meshes()[0].clone();
    assert_eq!((points.primitive_count(), points.triangles().len()), (5, 0));
    assert_eq!(triangles(1), [[0, 1, 1], [2, 3, 3]]);
    assert_eq!(triangles(2)[4], [4, 0, 0]);
    assert_eq!(triangles(3)[3], [3, 4, 4]);
    assert_eq!(
        with_mode(1).warnings(),
        ["mesh 0, primitive 0: 5 vertices are no whole number of lines".to_owned()]
    );
    assert_eq!(with_mode(7).error(), "glTF: mesh 0, primitive 0: unknown mode 7");
    assert_eq!(
        with_mode(4).warnings(),
        ["mesh 0, primitive 0: 5 corners are no whole number of triangles".to_owned()]
    );
    // The same without indices.
    let mut model = with_mode(5);
    model.primitive().as_object_mut().unwrap().remove("indices");
    assert_eq!(model.load().unwrap().scene.meshes()[0].triangles(), [[0, 1, 2], [1, 3, 2], [2, 3, 4]]);
}

#[test]
fn sparse_and_zero_filled() {
    for with_base in [true, false] {
        for (component, indices) in
            [(U8, vec![1, 2]), (U16, vec![1, 0, 2, 0]), (U32, vec![1, 0, 0, 0, 2, 0, 0, 0])]
        {
            let mut model = Model::triangle();
            let indices = model.view(&indices);
            let values: Vec<u8> =
                [7.0_f32, 8.0, 9.0, -1.0, -2.0, -3.0].iter().flat_map(|v| v.to_le_bytes()).collect();
            let values = model.view(&values);
            model.json["accessors"][0]["sparse"] = json!({
                "count": 2,
                "indices": {"bufferView": indices, "componentType": component},
                "values": {"bufferView": values},
            });
            if !with_base {
                model.json["accessors"][0].as_object_mut().unwrap().remove("bufferView");
            }
            let loaded = model.load().unwrap();
            assert_eq!(
                loaded.scene.meshes()[0].positions(),
                [[0.0, 0.0, 0.0], [7.0, 8.0, 9.0], [-1.0, -2.0, -3.0]]
            );
        }
    }
    // Zeros alone, which need no bytes at all.
    let mut model = Model::triangle();
    model.json["accessors"][0].as_object_mut().unwrap().remove("bufferView");
    assert_eq!(model.load().unwrap().scene.meshes()[0].positions(), [[0.0; 3]; 3]);
}

#[test]
fn zero_filled_accessors_cost_no_more_than_the_limits() {
    let mut model = Model::triangle();
    model.json["accessors"][0].as_object_mut().unwrap().remove("bufferView");
    model.json["accessors"][0]["count"] = 4_000_000_000_u64.into();
    let error = model.error();
    assert!(
        error.starts_with("mesh 0, primitive 0: triangles: ") && error.contains("decoded_bytes"),
        "{error}"
    );
    // With indices, only what they refer to is made.
    let indices = model.accessor("SCALAR", U32, 3, &[0, 0, 0, 0, 255, 255, 255, 127, 1, 0, 0, 0]);
    model.primitive()["indices"] = indices.into();
    let loaded = model.load().unwrap();
    assert_eq!(loaded.scene.meshes()[0].positions(), [[0.0; 3]; 3]);
    assert_eq!(loaded.scene.meshes()[0].triangles(), [[0, 2, 1]]);
}

/// Exporters put all vertices of a file into one accessor; a mesh keeps those that it uses.
#[test]
fn shared_vertices_are_taken_apart() {
    let mut model = Model::empty();
    let position = model.floats("VEC3", &(0..300).map(|k| k as f32).collect::<Vec<_>>());
    let color = model.floats("VEC4", &(0..400).map(|k| k as f32).collect::<Vec<_>>());
    let run = model.accessor("SCALAR", U8, 3, &[41, 40, 42]);
    let scattered = model.accessor("SCALAR", U8, 3, &[99, 0, 50]);
    let primitive =
        |indices: usize| json!({"attributes": {"POSITION": position, "COLOR_0": color}, "indices": indices});
    model.json["meshes"] = json!([{"primitives": [primitive(run), primitive(scattered)]}]);
    let loaded = model.load().unwrap();
    let [run, scattered] = loaded.scene.meshes() else { panic!() };
    let vertex = |k: u16| std::array::from_fn(|a| f32::from(3 * k) + a as f32);
    assert_eq!(run.positions(), [vertex(40), vertex(41), vertex(42)]);
    assert_eq!(run.triangles(), [[1, 0, 2]]);
    assert_eq!(scattered.positions(), [vertex(0), vertex(50), vertex(99)]);
    assert_eq!(scattered.triangles(), [[2, 0, 1]]);
    assert_eq!(scattered.colors()[1], [200.0, 201.0, 202.0, 203.0]);
}

#[test]
fn equal_primitives_share_a_mesh() {
    let mut model = Model::triangle();
    let primitive = model.primitive().clone();
    push(&mut model.json["meshes"], json!({"primitives": [primitive, primitive]}));
    model.json["nodes"] = json!([{"mesh": 0, "children": [1, 2]}, {"mesh": 1}, {"mesh": 0}]);
    let scene = model.load().unwrap().scene;
    assert_eq!((scene.meshes().len(), scene.instances().len(), scene.triangle_count()), (1, 4, 4));
    assert_eq!(scene.instances().iter().map(|i| i.object).collect::<Vec<_>>(), [0, 1, 1, 2]);
}

#[test]
fn vertex_colours_in_every_form() {
    let half = 128.0 / 255.0;
    let cases: [(&str, u32, Vec<u8>, [f32; 4]); 6] = [
        ("VEC4", U8, vec![255, 0, 128, 255], [1.0, 0.0, half, 1.0]),
        ("VEC3", U8, vec![255, 0, 128, 0], [1.0, 0.0, half, 1.0]),
        ("VEC4", U16, vec![255, 255, 0, 0, 0, 0, 255, 255], [1.0, 0.0, 0.0, 1.0]),
        ("VEC3", U16, vec![0, 0, 255, 255, 0, 0, 0, 0], [0.0, 1.0, 0.0, 1.0]),
        (
            "VEC3",
            F32,
            [0.25_f32, 0.5, 2.0].iter().flat_map(|v| v.to_le_bytes()).collect(),
            [0.25, 0.5, 2.0, 1.0],
        ),
        (
            "VEC4",
            F32,
            [f32::NAN, -1.0, 1e9, 0.5].iter().flat_map(|v| v.to_le_bytes()).collect(),
            [0.0, 0.0, 65504.0, 0.5],
        ),
    ];
    for (kind, component, element, expected) in cases {
        let mut model = Model::triangle();
        let stride = element.len();
        let color = model.accessor(kind, component, 3, &element.repeat(3));
        let view = model.json["accessors"][color]["bufferView"].as_u64().unwrap() as usize;
        model.json["bufferViews"][view]["byteStride"] = stride.into();
        model.primitive()["attributes"]["COLOR_0"] = color.into();
        assert_eq!(model.load().unwrap().scene.meshes()[0].colors(), [expected; 3], "{kind} {component}");
    }
}

#[test]
fn attributes_that_are_not_finite_are_repaired_and_named() {
    let mut model = Model::triangle();
    let bad = [f32::NAN, f32::INFINITY, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, f32::NEG_INFINITY, 0.0, 1.0];
    let normal = model.floats("VEC3", &bad[..9]);
    let tangent = model.floats("VEC4", &bad);
    let uv = model.floats("VEC2", &bad[..6]);
    model.json["meshes"][0]["name"] = "thing".into();
    model.primitive()["attributes"]["NORMAL"] = normal.into();
    model.primitive()["attributes"]["TANGENT"] = tangent.into();
    model.primitive()["attributes"]["TEXCOORD_1"] = uv.into();
    let loaded = model.load().unwrap();
    let mesh = &loaded.scene.meshes()[0];
    assert_eq!(mesh.normals()[0], [0.0, 0.0, 1.0]);
    assert_eq!(mesh.tangents()[2], [1.0, 0.0, 0.0, 1.0]);
    assert_eq!(mesh.uvs(1), [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]);
    assert_eq!(
        messages(&loaded),
        ["normals", "tangents", "texture coordinates"]
            .map(|what| format!("mesh 0 'thing', primitive 0: {what} that are not finite are taken as 0"))
    );
}

#[test]
fn tangents_without_normals_are_dropped() {
    let mut model = Model::triangle();
    let tangent = model.floats("VEC4", &[1.0; 12]);
    model.primitive()["attributes"]["TANGENT"] = tangent.into();
    let loaded = model.load().unwrap();
    assert!(loaded.scene.meshes()[0].tangents().is_empty() && loaded.scene.meshes()[0].normals().is_empty());
}

/// Flat and smooth meshes get tangents along u where a normal map needs them, and none elsewhere.
#[test]
fn tangents_are_made_for_normal_maps() {
    for smooth in [false, true] {
        let mut model = Model::textured();
        model.json["materials"] = json!([{"normalTexture": {"index": 0}}]);
        if smooth {
            let normal = model.floats("VEC3", &[0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0]);
            model.primitive()["attributes"]["NORMAL"] = normal.into();
        }
        let scene = model.load().unwrap().scene;
        let mesh = &scene.meshes()[0];
        assert_eq!(mesh.normals(), [[0.0, 0.0, 1.0]; 3]);
        // v points down in images, so the bitangent points against it.
        assert_eq!(mesh.tangents(), [[1.0, 0.0, 0.0, -1.0]; 3]);
        model.json["materials"] = json!([{}]);
        assert!(model.load().unwrap().scene.meshes()[0].tangents().is_empty());
        // Without the coordinates there is nothing to make them from.
        model.json["materials"] = json!([{"normalTexture": {"index": 0, "texCoord": 1}}]);
        assert!(model.load().unwrap().scene.meshes()[0].tangents().is_empty());
    }
}

#[test]
fn limits_name_the_primitive() {
    let model = Model::triangle();
    let with = |limits: Limits| model.load_within(&limits).map(|_| ()).map_err(|e| e.to_string());
    with(Limits::default().with_triangles(1).with_vertices(3)).unwrap();
    assert_eq!(
        with(Limits::default().with_triangles(0)).unwrap_err(),
        "triangles up to node 0: 1 exceeds the limit of 0 (triangles)"
    );
    assert_eq!(
        with(Limits::default().with_vertices(2)).unwrap_err(),
        "mesh 0, primitive 0: vertices: 3 exceeds the limit of 2 (vertices)"
    );
    let mut model = model;
    model.json["accessors"][0] = json!({"componentType": F32, "count": 300_000, "type": "VEC3"});
    let limits = |decoded_bytes| Limits::default().with_decoded_bytes(decoded_bytes);
    let error = model.load_within(&limits(1 << 20)).unwrap_err().to_string();
    assert!(
        error.starts_with("mesh 0, primitive 0: triangles: ") && error.contains("decoded_bytes"),
        "{error}"
    );
    let error = model.load_within(&limits(2 << 20)).unwrap_err().to_string();
    assert!(
        error.starts_with("mesh 0, primitive 0: vertices: ") && error.contains("decoded_bytes"),
        "{error}"
    );
    model.load_within(&limits(5 << 20)).unwrap();
}

#[test]
fn points_and_lines_are_drawn_without_light_unless_they_have_normals() {
    let vertices = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    let shape = |mode: u32, normals: bool| {
        let mut model = Model::triangle();
        if normals {
            let normals = model.floats("VEC3", &vertices);
            model.primitive()["attributes"]["NORMAL"] = normals.into();
        }
        model.primitive()["mode"] = mode.into();
        let loaded = model.load().unwrap();
        let mesh = loaded.scene.meshes().first().unwrap();
        let warned = loaded.warnings.len();
        (mesh.kind(), mesh.triangles().to_vec(), loaded.scene.materials()[0].unlit, warned)
    };
    use PrimitiveKind::{Lines, Points, Triangles};
    // Every vertex is a point.
    assert_eq!(shape(0, false), (Points, vec![], true, 0));
    // The third vertex has no other.
    assert_eq!(shape(1, false), (Lines, vec![[0, 1, 1]], true, 1));
    assert_eq!(shape(2, false), (Lines, vec![[0, 1, 1], [1, 2, 2], [2, 0, 0]], true, 0));
    assert_eq!(shape(3, true), (Lines, vec![[0, 1, 1], [1, 2, 2]], false, 0));
    assert_eq!(shape(4, false), (Triangles, vec![[0, 1, 2]], false, 0));
}
