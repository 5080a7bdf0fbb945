//! glTF files of recipes.

use super::files;
use super::recipe::{Alpha, GltfSlot, MaterialRecipe, Recipe, TextureUse};
use overcoat::scene::{Filter, MeshData, MipFilter, Wrap};
use serde_json::{Map, Value, json};

/// The JSON of a recipe, and its buffer, which the JSON calls by `uri` (or has as its own if there is none).
pub fn write(recipe: &Recipe, uri: Option<&str>) -> (Value, Vec<u8>) {
    let mut out = Writer::default();
    let attributes: Vec<(Map<String, Value>, usize)> = recipe.meshes.iter().map(|m| out.mesh(m)).collect();
    let materials: Vec<Value> =
        recipe.materials.iter().enumerate().map(|(k, m)| out.material(k, m)).collect();
    let meshes: Vec<Value> = recipe
        .instances
        .iter()
        .map(|instance| {
            let (attributes, indices) = &attributes[instance.mesh];
            json!({ "primitives": [{
                "attributes": attributes, "indices": indices, "material": instance.material
            }]})
        })
        .collect();
    let nodes: Vec<Value> = recipe
        .instances
        .iter()
        .enumerate()
        .map(|(k, i)| {
            json!({
                "mesh": k, "translation": i.translation, "rotation": i.rotation, "scale": i.scale
            })
        })
        .collect();
    let images: Vec<Value> =
        (0..recipe.textures.len()).map(|k| json!({ "uri": files::texture_path(recipe, k) })).collect();
    let mut buffer = json!({ "byteLength": out.buffer.len() });
    if let Some(uri) = uri {
        buffer["uri"] = json!(uri);
    }
    let mut root = json!({
        "asset": { "version": "2.0" },
        "buffers": [buffer],
        "bufferViews": out.views,
        "accessors": out.accessors,
        "meshes": meshes,
        "materials": materials,
        "nodes": nodes,
        "scenes": [{ "nodes": (0..recipe.instances.len()).collect::<Vec<_>>() }],
        "scene": 0,
    });
    for (name, list) in [("images", images), ("samplers", out.samplers), ("textures", out.textures)] {
        if !list.is_empty() {
            root[name] = Value::Array(list);
        }
    }
    if !out.extensions.is_empty() {
        out.extensions.sort_unstable();
        out.extensions.dedup();
        root["extensionsUsed"] = json!(out.extensions);
    }
    (root, out.buffer)
}

/// The binary form: JSON and buffer in one file.
pub fn glb(recipe: &Recipe) -> Vec<u8> {
    let (json, mut buffer) = write(recipe, None);
    let mut json = json.to_string().into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    buffer.resize(buffer.len().next_multiple_of(4), 0);
    let mut bytes = b"glTF".to_vec();
    let word = |bytes: &mut Vec<u8>, value: usize| bytes.extend((value as u32).to_le_bytes());
    word(&mut bytes, 2);
    word(&mut bytes, 12 + 8 + json.len() + 8 + buffer.len());
    for (kind, chunk) in [(b"JSON", &json), (b"BIN\0", &buffer)] {
        word(&mut bytes, chunk.len());
        bytes.extend(kind);
        bytes.extend(chunk);
    }
    bytes
}

#[derive(Default)]
struct Writer {
    buffer: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
    samplers: Vec<Value>,
    textures: Vec<Value>,
    extensions: Vec<&'static str>,
}

impl Writer {
    /// Numbers of the accessor of some floats.
    fn floats<const N: usize>(&mut self, kind: &str, values: &[[f32; N]]) -> usize {
        let bytes: Vec<u8> = values.as_flattened().iter().flat_map(|v| v.to_le_bytes()).collect();
        let mut accessor = json!({ "componentType": 5126, "count": values.len(), "type": kind });
        if N == 3 {
            let bound = |pick: fn(f32, f32) -> f32| -> [f32; N] {
                std::array::from_fn(|k| values.iter().map(|v| v[k]).reduce(pick).unwrap_or(0.0))
            };
            accessor["min"] = json!(bound(f32::min).as_slice());
            accessor["max"] = json!(bound(f32::max).as_slice());
        }
        self.accessor(accessor, bytes)
    }

    fn accessor(&mut self, mut accessor: Value, bytes: Vec<u8>) -> usize {
        accessor["bufferView"] = json!(self.views.len());
        self.views.push(json!({ "buffer": 0, "byteOffset": self.buffer.len(), "byteLength": bytes.len() }));
        self.buffer.extend(bytes);
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    fn mesh(&mut self, mesh: &MeshData) -> (Map<String, Value>, usize) {
        let mut attributes = Map::new();
        let mut add = |name: &str, accessor: Option<usize>| {
            attributes.extend(accessor.map(|k| (name.to_owned(), json!(k))));
        };
        fn there<T>(list: &[T]) -> Option<&[T]> {
            (!list.is_empty()).then_some(list)
        }
        add("POSITION", Some(self.floats("VEC3", &mesh.positions)));
        add("NORMAL", there(&mesh.normals).map(|list| self.floats("VEC3", list)));
        add("TANGENT", there(&mesh.tangents).map(|list| self.floats("VEC4", list)));
        add("TEXCOORD_0", there(&mesh.uvs[0]).map(|list| self.floats("VEC2", list)));
        add("TEXCOORD_1", there(&mesh.uvs[1]).map(|list| self.floats("VEC2", list)));
        add("COLOR_0", there(&mesh.colors).map(|list| self.floats("VEC4", list)));
        let indices = mesh.triangles.as_flattened();
        let bytes = indices.iter().flat_map(|&v| v.to_le_bytes()).collect();
        let accessor = json!({ "componentType": 5125, "count": indices.len(), "type": "SCALAR" });
        (attributes, self.accessor(accessor, bytes))
    }

    /// The textureInfo of a use.
    fn texture(&mut self, used: &TextureUse) -> Value {
        let wrap = |wrap: Wrap| match wrap {
            Wrap::Repeat => 10497,
            Wrap::MirroredRepeat => 33648,
            Wrap::ClampToEdge => 33071,
        };
        let magnification = if used.magnification == Filter::Nearest { 9728 } else { 9729 };
        let minification = match (used.minification, used.mip) {
            (Filter::Nearest, MipFilter::None) => 9728,
            (Filter::Linear, MipFilter::None) => 9729,
            (Filter::Nearest, MipFilter::Nearest) => 9984,
            (Filter::Linear, MipFilter::Nearest) => 9985,
            (Filter::Nearest, MipFilter::Linear) => 9986,
            (Filter::Linear, MipFilter::Linear) => 9987,
        };
        self.textures.push(json!({ "source": used.texture, "sampler": self.samplers.len() }));
        self.samplers.push(json!({
            "wrapS": wrap(used.wrap[0]), "wrapT": wrap(used.wrap[1]),
            "magFilter": magnification, "minFilter": minification,
        }));
        self.extensions.push("KHR_texture_transform");
        json!({
            "index": self.textures.len() - 1,
            "texCoord": used.uv_set,
            "extensions": { "KHR_texture_transform": {
                "offset": used.offset, "scale": used.scale, "rotation": used.rotation.to_radians(),
            }},
        })
    }

    fn material(&mut self, number: usize, recipe: &MaterialRecipe) -> Value {
        let mut material = json!({
            "name": files::material_name(number),
            "doubleSided": recipe.double_sided,
            "pbrMetallicRoughness": {
                "baseColorFactor": recipe.base_color,
                "metallicFactor": recipe.metallic,
                "roughnessFactor": recipe.roughness,
            },
        });
        match recipe.alpha {
            Alpha::Opaque => {}
            Alpha::Mask(cutoff) => {
                material["alphaMode"] = json!("MASK");
                material["alphaCutoff"] = json!(cutoff);
            }
            Alpha::Blend => material["alphaMode"] = json!("BLEND"),
        }
        if recipe.unlit {
            self.extensions.push("KHR_materials_unlit");
            material["extensions"]["KHR_materials_unlit"] = json!({});
        }
        for (slot, used) in &recipe.textures {
            let info = self.texture(used);
            let mut coat = |name: &str, info: Value| {
                self.extensions.push("KHR_materials_clearcoat");
                let coat = &mut material["extensions"]["KHR_materials_clearcoat"];
                coat["clearcoatFactor"] = json!(0.8);
                coat["clearcoatRoughnessFactor"] = json!(0.4);
                coat[name] = info;
            };
            match slot {
                GltfSlot::BaseColor => material["pbrMetallicRoughness"]["baseColorTexture"] = info,
                GltfSlot::MetallicRoughness => {
                    material["pbrMetallicRoughness"]["metallicRoughnessTexture"] = info;
                }
                GltfSlot::Normal => material["normalTexture"] = info,
                GltfSlot::Occlusion => material["occlusionTexture"] = info,
                GltfSlot::Emissive => {
                    material["emissiveTexture"] = info;
                    material["emissiveFactor"] = json!([0.3, 0.2, 0.4]);
                }
                GltfSlot::Coat => coat("clearcoatTexture", info),
                GltfSlot::CoatRoughness => coat("clearcoatRoughnessTexture", info),
                GltfSlot::CoatNormal => coat("clearcoatNormalTexture", info),
            }
        }
        material
    }
}
