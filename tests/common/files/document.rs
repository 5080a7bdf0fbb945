//! Builder of whole glTF documents.

use super::load;
use super::model::{F32, Model, U16, U32, push};
use overcoat::load::{Format, LoadOptions};
use overcoat::scene::{MeshData, Scene};
use serde_json::{Map, Value, json};
use std::collections::BTreeSet;
use std::error::Error;

/// A document without anything in its scene.
pub fn document() -> Model {
    let mut model = Model::empty();
    for list in ["nodes", "meshes", "materials", "images", "textures"] {
        model.json[list] = json!([]);
    }
    model.json["scenes"] = json!([{"nodes": []}]);
    model
}

impl Model {
    /// Floats as an accessor.
    pub fn vectors<const N: usize>(&mut self, values: &[[f32; N]]) -> usize {
        let kind = ["SCALAR", "VEC2", "VEC3", "VEC4"][N - 1];
        self.floats(kind, values.as_flattened())
    }

    /// An accessor of vertices, padded so that each begins at a multiple of four bytes.
    pub fn packed<const N: usize>(
        &mut self,
        kind: &str,
        component: u32,
        normalized: bool,
        values: &[[u8; N]],
    ) -> usize {
        let stride = N.next_multiple_of(4);
        let mut bytes = Vec::new();
        for value in values {
            bytes.extend(value);
            bytes.resize(bytes.len().next_multiple_of(4), 0);
        }
        let accessor = self.accessor(kind, component, values.len(), &bytes);
        let view = self.json["bufferViews"].as_array().map_or(0, Vec::len) - 1;
        self.json["bufferViews"][view]["byteStride"] = stride.into();
        self.json["accessors"][accessor]["normalized"] = normalized.into();
        accessor
    }

    /// Indices of triangles.
    pub fn indices(&mut self, triangles: &[[u32; 3]]) -> usize {
        let corners = triangles.as_flattened();
        // Most meshes here are small, and so are their files.
        if corners.iter().all(|&v| v < 0xffff) {
            let bytes: Vec<u8> = corners.iter().flat_map(|&v| (v as u16).to_le_bytes()).collect();
            self.accessor("SCALAR", U16, corners.len(), &bytes)
        } else {
            let bytes: Vec<u8> = corners.iter().flat_map(|v| v.to_le_bytes()).collect();
            self.accessor("SCALAR", U32, corners.len(), &bytes)
        }
    }

    /// A primitive with everything that a mesh has.
    pub fn shape(&mut self, mesh: &MeshData) -> Value {
        let mut attributes = Map::new();
        attributes.insert("POSITION".into(), self.vectors(&mesh.positions).into());
        if !mesh.normals.is_empty() {
            attributes.insert("NORMAL".into(), self.vectors(&mesh.normals).into());
        }
        if !mesh.tangents.is_empty() {
            attributes.insert("TANGENT".into(), self.vectors(&mesh.tangents).into());
        }
        for (set, uvs) in mesh.uvs.iter().enumerate().filter(|(_, uvs)| !uvs.is_empty()) {
            attributes.insert(format!("TEXCOORD_{set}"), self.vectors(uvs).into());
        }
        if !mesh.colors.is_empty() {
            attributes.insert("COLOR_0".into(), self.vectors(&mesh.colors).into());
        }
        json!({"attributes": attributes, "indices": self.indices(&mesh.triangles)})
    }

    /// A mesh of one primitive.
    pub fn mesh(&mut self, primitive: Value) -> usize {
        push(&mut self.json["meshes"], json!({"primitives": [primitive]}))
    }

    pub fn material(&mut self, material: Value) -> usize {
        push(&mut self.json["materials"], material)
    }

    /// A node, and whether the scene lists it.
    pub fn node(&mut self, node: Value, listed: bool) -> usize {
        let number = push(&mut self.json["nodes"], node);
        if listed {
            push(&mut self.json["scenes"][0]["nodes"], number.into());
        }
        number
    }

    /// A node that shows a mesh of this primitive with this material.
    pub fn show(&mut self, primitive: &Value, material: usize, at: [f64; 3], scale: f64) -> usize {
        let mut primitive = primitive.clone();
        primitive["material"] = material.into();
        let mesh = self.mesh(primitive);
        self.node(json!({"mesh": mesh, "translation": at, "scale": [scale, scale, scale]}), true)
    }

    /// A texture of a picture's file, with the default sampler.
    pub fn texture(&mut self, file: &[u8]) -> usize {
        let view = self.view(file);
        let image = push(&mut self.json["images"], json!({"bufferView": view}));
        push(&mut self.json["textures"], json!({"source": image}))
    }

    /// A texture that only an extension names.
    pub fn texture_of(&mut self, extension: &str, file: &[u8]) -> usize {
        let view = self.view(file);
        let image = push(&mut self.json["images"], json!({"bufferView": view}));
        push(&mut self.json["textures"], json!({"extensions": {extension: {"source": image}}}))
    }

    /// The scene of the finished document.
    pub fn finish(&mut self, options: &LoadOptions) -> Result<Scene, Box<dyn Error>> {
        load(&self.file(), Format::Glb, &self.files, options)
    }

    /// The file of the finished document, all of whose extensions are required, so that none can be passed over.
    pub fn file(&mut self) -> Vec<u8> {
        let mut names = BTreeSet::new();
        collect_extensions(&self.json, &mut names);
        let known = self.json["extensionsRequired"].as_array().cloned().unwrap_or_default();
        names.extend(known.iter().filter_map(|name| name.as_str().map(str::to_owned)));
        if !names.is_empty() {
            self.json["extensionsUsed"] = json!(names);
            self.json["extensionsRequired"] = json!(names);
        }
        self.glb()
    }
}

/// Names of all objects in objects that are called `extensions`.
fn collect_extensions(value: &Value, names: &mut BTreeSet<String>) {
    match value {
        Value::Object(map) => {
            for (key, value) in map {
                if key == "extensions" {
                    names.extend(value.as_object().into_iter().flatten().map(|(name, _)| name.clone()));
                }
                collect_extensions(value, names);
            }
        }
        Value::Array(list) => list.iter().for_each(|value| collect_extensions(value, names)),
        _ => {}
    }
}

/// Bytes of floats.
pub fn bytes<const N: usize>(values: &[[f32; N]]) -> Vec<u8> {
    values.as_flattened().iter().flat_map(|v| v.to_le_bytes()).collect()
}

/// The type of an accessor of so many floats.
pub fn float_accessor(view: usize, components: usize, count: usize) -> Value {
    let kind = ["SCALAR", "VEC2", "VEC3", "VEC4"][components - 1];
    json!({"bufferView": view, "componentType": F32, "count": count, "type": kind})
}
