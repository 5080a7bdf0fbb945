//! Builds small glTF files.

use overcoat::jobs::Jobs;
use overcoat::limits::Limits;
use overcoat::load::{Context, Format, LoadError, Loaded, MemoryResolver, NoResolver, load_bytes, load_file};
use serde_json::{Value, json};

/// Component types of accessors.
pub const I8: u32 = 5120;
pub const U8: u32 = 5121;
pub const I16: u32 = 5122;
pub const U16: u32 = 5123;
pub const U32: u32 = 5125;
pub const F32: u32 = 5126;

/// A document with its only buffer.
#[derive(Clone)]
pub struct Model {
    pub json: Value,
    pub bytes: Vec<u8>,
    /// Files beside it.
    pub files: MemoryResolver,
}

impl Model {
    /// A document with one node that shows mesh 0; no mesh yet.
    pub fn empty() -> Self {
        let json = json!({
            "asset": {"version": "2.0"},
            "scene": 0,
            "scenes": [{"nodes": [0]}],
            "nodes": [{"mesh": 0}],
            "meshes": [],
            "accessors": [],
            "bufferViews": [],
        });
        Self { json, bytes: Vec::new(), files: MemoryResolver::default() }
    }

    /// One triangle in the xy plane, without indices.
    pub fn triangle() -> Self {
        let mut model = Self::empty();
        let position = model.floats("VEC3", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
        model.json["meshes"] = json!([{"primitives": [{"attributes": {"POSITION": position}}]}]);
        model
    }

    /// The triangle with texture coordinates, a material and one 2 x 1 texture.
    pub fn textured() -> Self {
        let mut model = Self::triangle();
        let uv = model.floats("VEC2", &[0.0, 0.0, 1.0, 0.0, 0.0, 1.0]);
        let primitive = &mut model.json["meshes"][0]["primitives"][0];
        primitive["attributes"]["TEXCOORD_0"] = uv.into();
        primitive["material"] = 0.into();
        let png = picture(image::ImageFormat::Png);
        let view = model.view(&png);
        model.json["images"] = json!([{"name": "picture", "bufferView": view}]);
        model.json["textures"] = json!([{"source": 0}]);
        model.json["materials"] = json!([{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}]);
        model
    }

    /// The error, or all warnings of a file that is drawn in spite of them.
    pub fn complaint(&self) -> String {
        self.load().map_or_else(|error| error.to_string(), |loaded| messages(&loaded).join("; "))
    }

    /// Appends bytes as a view, at a multiple of four.
    pub fn view(&mut self, bytes: &[u8]) -> usize {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let view = json!({"buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len()});
        self.bytes.extend_from_slice(bytes);
        push(&mut self.json["bufferViews"], view)
    }

    /// Appends an accessor over a new view.
    pub fn accessor(&mut self, kind: &str, component: u32, count: usize, bytes: &[u8]) -> usize {
        let view = self.view(bytes);
        let accessor = json!({"bufferView": view, "componentType": component, "count": count, "type": kind});
        push(&mut self.json["accessors"], accessor)
    }

    /// Appends an accessor of floats.
    pub fn floats(&mut self, kind: &str, values: &[f32]) -> usize {
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        let components = match kind {
            "SCALAR" => 1,
            "VEC2" => 2,
            "VEC3" => 3,
            _ => 4,
        };
        self.accessor(kind, F32, values.len() / components, &bytes)
    }

    /// The first primitive.
    pub fn primitive(&mut self) -> &mut Value {
        &mut self.json["meshes"][0]["primitives"][0]
    }

    /// As a binary container.
    pub fn glb(&self) -> Vec<u8> {
        let mut json = self.json.clone();
        if !self.bytes.is_empty() && json.get("buffers").is_none() {
            json["buffers"] = json!([{"byteLength": self.bytes.len()}]);
        }
        let mut text = json.to_string().into_bytes();
        text.resize(text.len().next_multiple_of(4), b' ');
        let mut binary = self.bytes.clone();
        binary.resize(binary.len().next_multiple_of(4), 0);
        let length = 12 + 8 + text.len() + 8 + binary.len();
        let word = |v: usize| u32::try_from(v).unwrap().to_le_bytes();
        let mut file = b"glTF\x02\0\0\0".to_vec();
        file.extend(word(length));
        file.extend(word(text.len()));
        file.extend(b"JSON");
        file.extend(text);
        file.extend(word(binary.len()));
        file.extend(b"BIN\0");
        file.extend(binary);
        file
    }

    pub fn load(&self) -> Result<Loaded, LoadError> {
        self.load_within(&Limits::default())
    }

    pub fn load_within(&self, limits: &Limits) -> Result<Loaded, LoadError> {
        let jobs = Jobs::new(1);
        let bytes = self.glb();
        let loaded = load_bytes(&bytes, None, &Context { resolver: &self.files, limits, jobs: &jobs });
        if !self.json.to_string().contains("\"uri\"") {
            let from_file = load_in_parts(&bytes, limits);
            if let Some(from_file) = from_file {
                let (parts, memory) = (outcome(&from_file), outcome(&loaded));
                // Scenes may have megabytes of text.
                let shown = |text: &str| text.chars().take(300).collect::<String>();
                assert!(parts == memory, "in parts: {}\nfrom memory: {}", shown(&parts), shown(&memory));
            }
        }
        loaded
    }

    /// The message of the error that it must end in.
    pub fn error(&self) -> String {
        self.load().expect_err("this must not load").to_string()
    }

    /// The warnings of a file that must load.
    pub fn warnings(&self) -> Vec<String> {
        messages(&self.load().unwrap())
    }
}

/// Loads a container from a file that is large enough to be read in parts: what follows a container is no part of
/// it. `None` if the limits do not allow such files.
pub fn load_in_parts(bytes: &[u8], limits: &Limits) -> Option<Result<Loaded, LoadError>> {
    let size = bytes.len().max(3 << 20) as u64;
    if limits.input_bytes < size {
        return None;
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("model.glb");
    std::fs::write(&path, bytes).unwrap();
    std::fs::OpenOptions::new().write(true).open(&path).unwrap().set_len(size).unwrap();
    Some(load_file(&path, limits, &Jobs::new(2)))
}

/// Everything that can be seen of a loaded file.
pub fn outcome(loaded: &Result<Loaded, LoadError>) -> String {
    match loaded {
        Ok(loaded) => format!("{:?} {:?}", loaded.scene, loaded.warnings),
        Err(error) => error.to_string(),
    }
}

/// Loads JSON text.
pub fn load_text(text: &str, limits: &Limits) -> Result<Loaded, LoadError> {
    let jobs = Jobs::new(1);
    load_bytes(text.as_bytes(), Some(Format::Gltf), &Context { resolver: &NoResolver, limits, jobs: &jobs })
}

pub fn messages(loaded: &Loaded) -> Vec<String> {
    loaded.warnings.iter().map(|w| w.message.clone()).collect()
}

/// Appends to a list and gives the number of the element.
pub fn push(list: &mut Value, element: Value) -> usize {
    let list = list.as_array_mut().unwrap();
    list.push(element);
    list.len() - 1
}

/// A picture of 2 x 1 texels: half transparent red, opaque green.
pub fn picture(format: image::ImageFormat) -> Vec<u8> {
    let texels: Vec<u8> = vec![255, 0, 0, 128, 0, 255, 0, 255];
    let image = image::RgbaImage::from_raw(2, 1, texels).unwrap();
    let mut bytes = std::io::Cursor::new(Vec::new());
    image.write_to(&mut bytes, format).unwrap();
    bytes.into_inner()
}
