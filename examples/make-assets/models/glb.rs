//! Models as binary glTF 2.0.

use std::collections::BTreeMap;

use glam::DVec3;
use serde_json::{Value, json};

use super::mesh::Mesh;
use super::model::{Alpha, Image, Material, Model};

/// Array and element buffer targets, samplers and component types of the glTF specification.
const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;
const UNSIGNED_SHORT: u32 = 5123;
const UNSIGNED_INT: u32 = 5125;
const FLOAT: u32 = 5126;
const REPEAT: u32 = 10497;
const LINEAR: u32 = 9729;
const LINEAR_MIPMAP_LINEAR: u32 = 9987;

/// Extension of the clear coat (Khronos, draft of 2025-09-15).
const COAT_DARKENING: &str = "KHR_materials_clearcoat_darkening";

/// A file being written.
#[derive(Default)]
struct Writer {
    binary: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
    images: Vec<Value>,
    textures: BTreeMap<&'static str, usize>,
    extensions: BTreeMap<&'static str, ()>,
}

/// The bytes of a `.glb` file.
pub fn encode(model: &Model, images: &BTreeMap<&'static str, Image>) -> Vec<u8> {
    let mut writer = Writer::default();
    let materials: Vec<Value> = model.materials.iter().map(|m| writer.material(m, images)).collect();
    let meshes: Vec<Value> = model
        .meshes
        .iter()
        .map(|mesh| {
            let primitives: Vec<Value> = mesh
                .parts
                .iter()
                .map(|(material, part)| {
                    let textured = model.materials[*material].is_textured();
                    writer.primitive(part, *material, textured)
                })
                .collect();
            json!({"name": mesh.name, "primitives": primitives})
        })
        .collect();
    let nodes: Vec<Value> = model
        .nodes
        .iter()
        .map(|node| {
            let mut value = json!({"name": node.name, "mesh": node.mesh});
            if node.position != DVec3::ZERO {
                value["translation"] = json!(node.position.to_array().map(|v| v as f32));
            }
            if node.turned {
                value["rotation"] = json!([0, 1, 0, 0]);
            }
            value
        })
        .collect();
    let mut document = json!({
        "asset": {"version": "2.0", "generator": "overcoat examples/make-assets",
                  "copyright": "MIT OR Apache-2.0"},
        "scene": 0,
        "scenes": [{"name": model.name, "nodes": (0..nodes.len()).collect::<Vec<_>>()}],
        "nodes": nodes,
        "meshes": meshes,
        "materials": materials,
        "accessors": writer.accessors,
        "bufferViews": writer.views,
        "buffers": [{"byteLength": writer.binary.len()}],
    });
    if !writer.images.is_empty() {
        document["images"] = json!(writer.images);
        document["samplers"] = json!([{"magFilter": LINEAR, "minFilter": LINEAR_MIPMAP_LINEAR,
                                       "wrapS": REPEAT, "wrapT": REPEAT}]);
        let sources = (0..writer.images.len()).map(|i| json!({"sampler": 0, "source": i}));
        document["textures"] = json!(sources.collect::<Vec<_>>());
    }
    if !writer.extensions.is_empty() {
        document["extensionsUsed"] = json!(writer.extensions.keys().collect::<Vec<_>>());
    }
    container(&document, writer.binary)
}

/// Wraps the two chunks of a GLB file.
fn container(document: &Value, mut binary: Vec<u8>) -> Vec<u8> {
    let mut text = document.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    binary.resize(binary.len().next_multiple_of(4), 0);
    let mut bytes = Vec::new();
    bytes.extend(b"glTF");
    bytes.extend(2u32.to_le_bytes());
    bytes.extend((12 + 16 + text.len() as u32 + binary.len() as u32).to_le_bytes());
    for (kind, chunk) in [(b"JSON", text), (b"BIN\0", binary)] {
        bytes.extend((chunk.len() as u32).to_le_bytes());
        bytes.extend(kind);
        bytes.extend(chunk);
    }
    bytes
}

impl Writer {
    /// Appends aligned bytes as a buffer view and returns its index.
    fn view(&mut self, bytes: &[u8], target: Option<u32>) -> usize {
        self.binary.resize(self.binary.len().next_multiple_of(4), 0);
        let mut view = json!({"buffer": 0, "byteOffset": self.binary.len(), "byteLength": bytes.len()});
        if let Some(target) = target {
            view["target"] = json!(target);
        }
        self.binary.extend_from_slice(bytes);
        self.views.push(view);
        self.views.len() - 1
    }

    /// Appends an accessor and returns its index.
    fn accessor(&mut self, value: Value) -> usize {
        self.accessors.push(value);
        self.accessors.len() - 1
    }

    /// A vertex attribute of `N` floats.
    fn attribute<const N: usize>(&mut self, kind: &str, values: &[[f32; N]], bounds: bool) -> usize {
        let bytes: Vec<u8> = values.iter().flatten().flat_map(|v| v.to_le_bytes()).collect();
        let view = self.view(&bytes, Some(ARRAY_BUFFER));
        let mut accessor =
            json!({"bufferView": view, "componentType": FLOAT, "count": values.len(), "type": kind});
        if bounds {
            let mut low = values[0];
            let mut high = values[0];
            for value in values {
                for i in 0..N {
                    low[i] = if value[i] < low[i] { value[i] } else { low[i] };
                    high[i] = if value[i] > high[i] { value[i] } else { high[i] };
                }
            }
            accessor["min"] = json!(low.to_vec());
            accessor["max"] = json!(high.to_vec());
        }
        self.accessor(accessor)
    }

    fn primitive(&mut self, mesh: &Mesh, material: usize, textured: bool) -> Value {
        let single = |v: DVec3| v.to_array().map(|c| c as f32 + 0.0);
        let positions: Vec<_> = mesh.vertices.iter().map(|v| single(v.position)).collect();
        let normals: Vec<_> = mesh.vertices.iter().map(|v| single(v.normal)).collect();
        let indices = mesh.triangles.iter().flatten();
        let (bytes, kind): (Vec<u8>, u32) = if mesh.vertices.len() < 0xffff {
            (indices.flat_map(|i| (*i as u16).to_le_bytes()).collect(), UNSIGNED_SHORT)
        } else {
            (indices.flat_map(|i| i.to_le_bytes()).collect(), UNSIGNED_INT)
        };
        let view = self.view(&bytes, Some(ELEMENT_ARRAY_BUFFER));
        let count = mesh.triangles.len() * 3;
        let indices = self
            .accessor(json!({"bufferView": view, "componentType": kind, "count": count, "type": "SCALAR"}));
        let mut attributes = json!({
            "POSITION": self.attribute("VEC3", &positions, true),
            "NORMAL": self.attribute("VEC3", &normals, false),
        });
        if textured {
            let uvs: Vec<_> = mesh.vertices.iter().map(|v| v.uv.to_array().map(|c| c as f32 + 0.0)).collect();
            attributes["TEXCOORD_0"] = json!(self.attribute("VEC2", &uvs, false));
        }
        json!({"attributes": attributes, "indices": indices, "material": material})
    }

    /// The index of a texture; its image is embedded at its first use.
    fn texture(&mut self, name: &'static str, images: &BTreeMap<&'static str, Image>) -> usize {
        if let Some(&index) = self.textures.get(name) {
            return index;
        }
        let view = self.view(&images[name].png(), None);
        self.images.push(json!({"name": name, "mimeType": "image/png", "bufferView": view}));
        self.textures.insert(name, self.images.len() - 1);
        self.images.len() - 1
    }

    fn material(&mut self, material: &Material, images: &BTreeMap<&'static str, Image>) -> Value {
        let mut texture = |name: &Option<&'static str>| name.map(|n| self.texture(n, images));
        let mut surface = json!({
            "baseColorFactor": material.color,
            "metallicFactor": material.metallic,
            "roughnessFactor": material.roughness,
        });
        if let Some(index) = texture(&material.color_map) {
            surface["baseColorTexture"] = json!({"index": index});
        }
        if let Some(index) = texture(&material.roughness_map) {
            surface["metallicRoughnessTexture"] = json!({"index": index});
        }
        let mut value = json!({"name": material.name, "pbrMetallicRoughness": surface});
        if let Some(index) = texture(&material.normal_map) {
            value["normalTexture"] = json!({"index": index, "scale": material.normal_scale});
        }
        let mut coat = json!({
            "clearcoatFactor": material.coat,
            "clearcoatRoughnessFactor": material.coat_roughness,
        });
        if let Some(index) = texture(&material.coat_normal_map) {
            coat["clearcoatNormalTexture"] = json!({"index": index});
        }
        if let Some(index) = texture(&material.coat_roughness_map) {
            coat["clearcoatRoughnessTexture"] = json!({"index": index});
        }
        if material.coat_darkens {
            self.extensions.insert(COAT_DARKENING, ());
            coat["extensions"][COAT_DARKENING] = json!({"clearcoatDarkeningFactor": 1});
        }
        if material.coat > 0.0 {
            self.extensions.insert("KHR_materials_clearcoat", ());
            value["extensions"]["KHR_materials_clearcoat"] = coat;
        }
        if material.specular != 1.0 {
            self.extensions.insert("KHR_materials_specular", ());
            value["extensions"]["KHR_materials_specular"] = json!({"specularFactor": material.specular});
        }
        if material.emissive != [0.0; 3] {
            value["emissiveFactor"] = json!(material.emissive);
        }
        if material.alpha == Alpha::Blend {
            value["alphaMode"] = json!("BLEND");
        }
        if material.double_sided {
            value["doubleSided"] = json!(true);
        }
        value
    }
}
