//! The bundled models and textures: made again, byte for byte, and sound.

#[path = "../examples/make-assets/models/mod.rs"]
mod models;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde_json::Value;

fn assets() -> PathBuf {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")).join("assets")
}

/// Every file below a folder, in order.
fn files(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).expect("the folder exists") {
        let path = entry.expect("the folder can be read").path();
        if path.is_dir() {
            found.extend(files(&path));
        } else {
            found.push(path);
        }
    }
    found.sort();
    found
}

#[test]
fn generator_makes_the_committed_bytes() {
    let made = models::files();
    assert!(made.len() > 15);
    for (name, made) in &made {
        let committed = std::fs::read(assets().join(name)).unwrap_or_default();
        let place = committed.iter().zip(made).position(|(a, b)| a != b);
        assert!(committed == *made, "{name} differs, first at {place:?}: run make-assets");
    }
    let kept = [files(&assets().join("models")), files(&assets().join("materials/textures"))].concat();
    for committed in &kept {
        let name =
            committed.strip_prefix(assets()).expect("it lies in assets").to_str().expect("it is plain");
        assert!(made.contains_key(name), "{name} is made by nothing");
    }
}

#[test]
fn all_files_together_stay_small() {
    let size: u64 = files(&assets()).iter().map(|p| p.metadata().expect("it exists").len()).sum();
    // The studio is there twice: as it is read in two milliseconds, and in the fewest bytes (without the feature `fast-loading`).
    assert!(size < 8_500_000, "{size} bytes");
}

/// A GLB file taken apart.
struct Glb {
    document: Value,
    binary: Vec<u8>,
}

/// A primitive's data.
struct Primitive {
    positions: Vec<Vec<f32>>,
    normals: Vec<Vec<f32>>,
    uvs: Vec<Vec<f32>>,
    indices: Vec<usize>,
}

impl Glb {
    fn read(name: &str) -> Self {
        let bytes = std::fs::read(assets().join("models").join(name)).expect("the model exists");
        let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().expect("four bytes")) as usize;
        assert_eq!(word(8), bytes.len());
        let text = word(12);
        let document = serde_json::from_slice(&bytes[20..20 + text]).expect("the first chunk is JSON");
        Self { document, binary: bytes[20 + text + 8..].to_vec() }
    }

    fn list(&self, name: &str) -> &[Value] {
        self.document[name].as_array().map_or(&[], Vec::as_slice)
    }

    /// The bytes and the length of an accessor.
    fn accessor(&self, index: &Value) -> (&[u8], &Value) {
        let accessor = &self.list("accessors")[number(index)];
        let view = &self.list("bufferViews")[number(&accessor["bufferView"])];
        let start = number(&view["byteOffset"]);
        (&self.binary[start..start + number(&view["byteLength"])], accessor)
    }

    fn floats(&self, index: &Value, width: usize) -> Vec<Vec<f32>> {
        let (bytes, accessor) = self.accessor(index);
        let floats: Vec<f32> =
            bytes.chunks_exact(4).map(|b| f32::from_le_bytes(b.try_into().expect("four bytes"))).collect();
        assert_eq!(floats.len(), number(&accessor["count"]) * width);
        floats.chunks_exact(width).map(<[f32]>::to_vec).collect()
    }

    fn primitive(&self, primitive: &Value) -> Primitive {
        let attributes = &primitive["attributes"];
        let (bytes, accessor) = self.accessor(&primitive["indices"]);
        let indices = match number(&accessor["componentType"]) {
            5123 => bytes.chunks_exact(2).map(|b| usize::from(u16::from_le_bytes([b[0], b[1]]))).collect(),
            _ => bytes
                .chunks_exact(4)
                .map(|b| u32::from_le_bytes(b.try_into().expect("four bytes")) as usize)
                .collect(),
        };
        Primitive {
            positions: self.floats(&attributes["POSITION"], 3),
            normals: self.floats(&attributes["NORMAL"], 3),
            uvs: attributes.get("TEXCOORD_0").map(|i| self.floats(i, 2)).unwrap_or_default(),
            indices,
        }
    }

    fn primitives(&self, mesh: &Value) -> Vec<Primitive> {
        let list = mesh["primitives"].as_array().expect("a mesh has primitives");
        list.iter().map(|p| self.primitive(p)).collect()
    }

    /// Triangles drawn, with every instance.
    fn triangles(&self) -> usize {
        let count = |mesh: &Value| {
            self.primitives(&self.list("meshes")[number(mesh)])
                .iter()
                .map(|p| p.indices.len() / 3)
                .sum::<usize>()
        };
        self.list("nodes").iter().map(|node| count(&node["mesh"])).sum()
    }
}

fn number(value: &Value) -> usize {
    value.as_u64().unwrap_or(0) as usize
}

const MODELS: [&str; 7] = [
    "material-ball.glb",
    "torus-knot.glb",
    "vase.glb",
    "draped-cloth.glb",
    "rounded-cube.glb",
    "text-plate.glb",
    "sports-car.glb",
];

#[test]
fn attributes_are_sound() {
    for name in MODELS {
        let glb = Glb::read(name);
        for mesh in glb.list("meshes") {
            for primitive in glb.primitives(mesh) {
                let count = primitive.positions.len();
                assert_eq!(primitive.normals.len(), count, "{name}");
                assert!(primitive.indices.iter().all(|i| *i < count), "{name}");
                assert!(primitive.positions.iter().flatten().all(|v| v.is_finite()), "{name}");
                assert!(primitive.uvs.iter().flatten().all(|v| v.is_finite()), "{name}");
                for normal in &primitive.normals {
                    let length = normal.iter().map(|c| c * c).sum::<f32>().sqrt();
                    assert!((length - 1.0).abs() < 1e-4, "{name}: a normal of length {length}");
                }
            }
        }
    }
}

#[test]
fn surfaces_are_closed() {
    for name in MODELS {
        let glb = Glb::read(name);
        for mesh in glb.list("meshes") {
            // Count of how often each edge between two points is walked forwards, less how often backwards.
            let mut edges: BTreeMap<([u32; 3], [u32; 3]), i32> = BTreeMap::new();
            for primitive in glb.primitives(mesh) {
                let point = |i: usize| -> [u32; 3] {
                    std::array::from_fn(|axis| {
                        (primitive.positions[primitive.indices[i]][axis] + 0.0).to_bits()
                    })
                };
                for triangle in 0..primitive.indices.len() / 3 {
                    for corner in 0..3 {
                        let (a, b) = (point(triangle * 3 + corner), point(triangle * 3 + (corner + 1) % 3));
                        if a < b {
                            *edges.entry((a, b)).or_default() += 1;
                        } else if b < a {
                            *edges.entry((b, a)).or_default() -= 1;
                        }
                    }
                }
            }
            let open: Vec<_> = edges.iter().filter(|(_, balance)| **balance != 0).collect();
            let shown: Vec<_> = open.iter().take(3).map(|((a, _), n)| (a.map(f32::from_bits), n)).collect();
            assert!(open.is_empty(), "{name} {}: {} open edges, {shown:?}", mesh["name"], open.len());
        }
    }
}

#[test]
fn normals_face_the_way_their_triangles_do() {
    for name in MODELS {
        let glb = Glb::read(name);
        for mesh in glb.list("meshes") {
            for primitive in glb.primitives(mesh) {
                let (mut good, mut all) = (0.0, 0.0);
                for corners in primitive.indices.chunks_exact(3) {
                    let [a, b, c] = [0, 1, 2].map(|i| &primitive.positions[corners[i]]);
                    let side = |from: &[f32], to: &[f32]| [0, 1, 2].map(|i| to[i] - from[i]);
                    let (u, v) = (side(a, b), side(a, c));
                    let face =
                        [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
                    let area = face.iter().map(|f| f * f).sum::<f32>().sqrt();
                    let normal = &primitive.normals[corners[0]];
                    let facing: f32 = (0..3).map(|i| face[i] * normal[i]).sum();
                    all += area;
                    good += if facing > 0.0 { area } else { 0.0 };
                }
                // Rounded rims lean over their edges, beyond the plane of a few narrow triangles.
                assert!(good > 0.96 * all, "{name} {}: {} of the area", mesh["name"], good / all);
            }
        }
    }
}

#[test]
fn the_car_is_as_rich_as_promised() {
    let glb = Glb::read("sports-car.glb");
    assert!(glb.list("materials").len() >= 8);
    let coated = glb
        .list("materials")
        .iter()
        .filter(|m| !m["extensions"]["KHR_materials_clearcoat"].is_null())
        .count();
    assert!(coated >= 4, "{coated} coated materials");
    let triangles = glb.triangles();
    assert!((30_000..=100_000).contains(&triangles), "{triangles} triangles");
}
