//! glTF seeds with features that need arrays: light through surfaces, points and lines, skins, morph targets, animation,
//! compressed data.

// The encoders of the decoder's own tests.
#[allow(dead_code, reason = "they make more than seeds need")]
#[path = "../../../crates/load/src/gltf/meshopt/encoder.rs"]
mod encoder;

use draco_core::{
    DataType, EncoderBuffer, EncoderOptions, FaceIndex, GeometryAttributeType, Mesh, MeshEncoder,
    PointAttribute, PointIndex,
};
use encoder::Random;
use serde_json::{Value, json};

const FLOAT: u32 = 5126;

/// A document and its binary part.
struct Model {
    json: Value,
    binary: Vec<u8>,
}

impl Model {
    fn new() -> Self {
        let json = json!({
            "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
            "accessors": [], "bufferViews": [],
        });
        Self { json, binary: Vec::new() }
    }

    fn push(&mut self, list: &str, value: Value) -> usize {
        let list = self.json[list].as_array_mut().expect("it is a list");
        list.push(value);
        list.len() - 1
    }

    fn view(&mut self, bytes: &[u8]) -> usize {
        self.binary.resize(self.binary.len().next_multiple_of(4), 0);
        let view = json!({"buffer": 0, "byteOffset": self.binary.len(), "byteLength": bytes.len()});
        self.binary.extend(bytes);
        self.push("bufferViews", view)
    }

    fn accessor(&mut self, kind: &str, component: u32, count: usize, bytes: &[u8]) -> usize {
        let view = self.view(bytes);
        self.push(
            "accessors",
            json!({"bufferView": view, "componentType": component, "count": count, "type": kind}),
        )
    }

    fn floats(&mut self, kind: &str, values: &[f32]) -> usize {
        let components = match kind {
            "SCALAR" => 1,
            "VEC2" => 2,
            "VEC3" => 3,
            "MAT4" => 16,
            _ => 4,
        };
        self.accessor(kind, FLOAT, values.len() / components, &super::floats(values))
    }

    /// JSON, a zero byte, binary data.
    fn file(mut self) -> Vec<u8> {
        if self.json.get("buffers").is_none() {
            self.json["buffers"] = json!([{"byteLength": self.binary.len()}]);
        }
        [self.json.to_string().as_bytes(), &[0], &self.binary].concat()
    }
}

/// Positions of a strip of quads along +Y.
const STRIP: [f32; 18] =
    [-0.5, 0.0, 0.0, 0.5, 0.0, 0.0, -0.5, 1.0, 0.0, 0.5, 1.0, 0.0, -0.5, 2.0, 0.0, 0.5, 2.0, 0.0];
const CORNERS: [u8; 12] = [0, 1, 3, 0, 3, 2, 2, 3, 5, 2, 5, 4];

/// Surfaces that let light through, of every extension about them, and two variants.
fn glass() -> Model {
    let mut model = Model::new();
    let positions = model.floats("VEC3", &STRIP);
    let indices = model.accessor("SCALAR", 5121, 12, &CORNERS);
    let primitive = |material: u32| {
        json!({"attributes": {"POSITION": positions}, "indices": indices, "material": material,
        "extensions": {"KHR_materials_variants": {"mappings": [{"material": 1, "variants": [0]}]}}})
    };
    model.json["meshes"] = json!([{"primitives": [primitive(0), primitive(1), primitive(2)]}]);
    model.json["extensions"] =
        json!({"KHR_materials_variants": {"variants": [{"name": "a"}, {"name": "b"}]}});
    model.json["materials"] = json!([
        {"extensions": {"KHR_materials_transmission": {"transmissionFactor": 1}, "KHR_materials_ior": {"ior": 1.3},
            "KHR_materials_volume": {"thicknessFactor": 0.3, "attenuationDistance": 0.5, "attenuationColor": [1, 0.5, 0]},
            "KHR_materials_dispersion": {"dispersion": 4}}},
        {"pbrMetallicRoughness": {"metallicFactor": 0, "roughnessFactor": 0.5},
            "extensions": {"KHR_materials_diffuse_transmission": {"diffuseTransmissionFactor": 0.7,
                "diffuseTransmissionColorFactor": [0.2, 1, 0.2]}, "KHR_materials_anisotropy": {"anisotropyStrength": 0.6},
                "KHR_materials_iridescence": {"iridescenceFactor": 1}}},
        {"alphaMode": "BLEND", "extensions": {"KHR_materials_transmission": {"transmissionFactor": 0.5},
            "KHR_materials_emissive_strength": {"emissiveStrength": 3}}},
    ]);
    model
}

/// Points and every kind of line.
fn strokes() -> Model {
    let mut model = Model::new();
    let positions = model.floats("VEC3", &STRIP);
    let primitives: Vec<Value> =
        (0..4).map(|mode| json!({"attributes": {"POSITION": positions}, "mode": mode})).collect();
    model.json["meshes"] = json!([{"primitives": primitives}]);
    model
}

/// A strip with a skin and two morph targets; animations of each interpolation, and of what pointers name.
fn motion() -> Model {
    let mut model = Model::new();
    let positions = model.floats("VEC3", &STRIP);
    let indices = model.accessor("SCALAR", 5121, 12, &CORNERS);
    let joints = model.accessor("VEC4", 5121, 6, &[0, 1, 0, 0].repeat(6));
    let weights: Vec<f32> =
        [0.0, 0.0, 0.5, 0.5, 1.0, 1.0].iter().flat_map(|w| [1.0 - w, *w, 0.0, 0.0]).collect();
    let weights = model.floats("VEC4", &weights);
    let mut matrices = [0.0; 32];
    (0..8).for_each(|k| matrices[k / 4 * 16 + k % 4 * 5] = 1.0);
    matrices[16 + 13] = -1.0;
    let inverse = model.floats("MAT4", &matrices);
    let lift = model.floats("VEC3", &[0.0, 0.0, 0.5].repeat(6));
    model.json["meshes"] = json!([{"weights": [0.5, 0], "primitives": [{
        "attributes": {"POSITION": positions, "JOINTS_0": joints, "WEIGHTS_0": weights}, "indices": indices, "material": 0,
        "targets": [{"POSITION": lift}, {"POSITION": positions}]}]}]);
    model.json["materials"] = json!([{}]);
    model.json["skins"] = json!([{"joints": [1, 2], "inverseBindMatrices": inverse}]);
    model.json["nodes"] = json!([{"mesh": 0, "skin": 0}, {"children": [2]}, {"translation": [0, 1, 0]},
        {"extensions": {"KHR_node_visibility": {"visible": false}}, "mesh": 0}]);
    model.json["scenes"] = json!([{"nodes": [0, 1, 3]}]);
    model.json["extensionsUsed"] = json!(["KHR_animation_pointer", "KHR_node_visibility"]);
    let times = model.floats("SCALAR", &[0.0, 0.5]);
    let turns = model.floats("VEC4", &[0.0, 0.0, 0.0, 1.0, 0.6, 0.0, 0.0, 0.8]);
    let shapes = model.floats("SCALAR", &[0.0, 1.0, 1.0, 0.0]);
    let spline = model.floats("VEC3", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0].repeat(3));
    let colors = model.floats("VEC4", &[1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0]);
    let seen = model.accessor("SCALAR", 5121, 2, &[0, 1]);
    let pointer =
        |path: &str| json!({"path": "pointer", "extensions": {"KHR_animation_pointer": {"pointer": path}}});
    let sampler = |output: usize, how: &str| json!({"input": times, "output": output, "interpolation": how});
    model.json["animations"] = json!([{"name": "all", "channels": [
        {"sampler": 0, "target": {"node": 2, "path": "rotation"}},
        {"sampler": 1, "target": {"node": 0, "path": "weights"}},
        {"sampler": 2, "target": {"node": 1, "path": "translation"}},
        {"sampler": 3, "target": pointer("/materials/0/pbrMetallicRoughness/baseColorFactor")},
        {"sampler": 4, "target": pointer("/nodes/3/extensions/KHR_node_visibility/visible")},
    ], "samplers": [sampler(turns, "LINEAR"), sampler(shapes, "STEP"), sampler(spline, "CUBICSPLINE"),
        sampler(colors, "LINEAR"), sampler(seen, "STEP")]}]);
    model
}

/// The strip in compressed views, over a fallback that is not there.
fn meshopt() -> Model {
    let mut random = Random::new(42);
    let mut model = Model::new();
    let corners = CORNERS.map(u32::from);
    let streams = [
        ("VEC3", FLOAT, 6, 12, "ATTRIBUTES", encoder::attributes(&super::floats(&STRIP), 12, 0, &mut random)),
        ("VEC3", FLOAT, 6, 12, "ATTRIBUTES", encoder::attributes(&super::floats(&STRIP), 12, 1, &mut random)),
        ("SCALAR", 5125, 12, 4, "TRIANGLES", encoder::triangles(&corners, &mut random)),
        ("SCALAR", 5125, 12, 4, "INDICES", encoder::indices(&corners, &mut random)),
    ];
    let mut place = 0;
    for (kind, component, count, stride, mode, stream) in streams {
        let start = model.binary.len();
        model.binary.extend(&stream);
        let view = json!({"buffer": 1, "byteOffset": place, "byteLength": count * stride,
            "extensions": {"EXT_meshopt_compression": {"buffer": 0, "byteOffset": start, "byteLength": stream.len(),
                "byteStride": stride, "count": count, "mode": mode}}});
        place += count * stride;
        let view = model.push("bufferViews", view);
        model.push(
            "accessors",
            json!({"bufferView": view, "componentType": component, "count": count, "type": kind}),
        );
    }
    model.json["buffers"] = json!([{"byteLength": model.binary.len()},
        {"byteLength": place, "extensions": {"EXT_meshopt_compression": {"fallback": true}}}]);
    model.json["extensionsRequired"] = json!(["EXT_meshopt_compression"]);
    model.json["extensionsUsed"] = json!(["EXT_meshopt_compression"]);
    model.json["meshes"] = json!([{"primitives": [{"attributes": {"POSITION": 0}, "indices": 2},
        {"attributes": {"POSITION": 1}, "indices": 3}]}]);
    model
}

/// The strip as a stream of Draco, by an encoding (0: sequential, 1: edgebreaker).
pub fn draco_stream(method: i32) -> Vec<u8> {
    let mut mesh = Mesh::new();
    mesh.set_num_points(6);
    let mut attribute = PointAttribute::new();
    attribute.init(GeometryAttributeType::Position, 3, DataType::Float32, false, 6);
    attribute.buffer_mut().write(0, &super::floats(&STRIP));
    mesh.add_attribute(attribute);
    for (k, corners) in CORNERS.as_chunks::<3>().0.iter().enumerate() {
        mesh.set_face(FaceIndex(k as u32), corners.map(|corner| PointIndex(corner.into())));
    }
    let mut options = EncoderOptions::new();
    options.set_encoding_method(method);
    options.set_attribute_quantization(0, 11);
    let mut encoder = MeshEncoder::new();
    encoder.set_mesh(mesh);
    let mut stream = EncoderBuffer::new();
    encoder.encode(&options, &mut stream).expect("a strip can be encoded");
    stream.data().to_vec()
}

/// The strip as a primitive of such a stream.
fn draco(method: i32) -> Model {
    let mut model = Model::new();
    let view = model.view(&draco_stream(method));
    model.push("accessors", json!({"componentType": FLOAT, "count": 6, "type": "VEC3"}));
    model.push("accessors", json!({"componentType": 5123, "count": 12, "type": "SCALAR"}));
    model.json["extensionsUsed"] = json!(["KHR_draco_mesh_compression"]);
    model.json["extensionsRequired"] = json!(["KHR_draco_mesh_compression"]);
    model.json["meshes"] = json!([{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1,
        "extensions": {"KHR_draco_mesh_compression": {"bufferView": view, "attributes": {"POSITION": 0}}}}]}]);
    model
}

/// Names and files: JSON, a zero byte, binary data.
pub fn all() -> Vec<(&'static str, Vec<u8>)> {
    let models = [
        ("glass", glass()),
        ("strokes", strokes()),
        ("motion", motion()),
        ("meshopt", meshopt()),
        ("draco-sequential", draco(0)),
        ("draco-edgebreaker", draco(1)),
    ];
    models.map(|(name, model)| (name, model.file())).into()
}
