//! Geometry and textures in forms that are packed, beside the plain ones: all must look the same.

use super::Entry;
use crate::common::files::document::{bytes, document, float_accessor};
use crate::common::files::ktx2::{self, Storage};
use crate::common::files::meshopt::Views;
use crate::common::files::model::{F32, I8, I16, Model, U16, U32, push};
use crate::common::files::{draco, encoded, png};
use crate::common::images::{image, letter_f};
use crate::common::shapes::{square, torus};
use crate::common::stage::{Built, Stage, flat_view};
use overcoat::load::LoadOptions;
use overcoat::scene::{Image, MeshData, SceneError, Transform};
use serde_json::{Value, json};
use std::error::Error;

pub const SCENES: &[Entry] =
    &[("gltf-compressed-geometry", geometry), ("gltf-basis-textures", basis_textures)];

/// A ring of few triangles, so that its corners show.
fn ring() -> MeshData {
    let mut mesh = torus(0.45, 16);
    mesh.tangents.clear();
    mesh
}

/// Rings. Above: plain; EXT_meshopt_compression; KHR_meshopt_compression in its newer form, and with filters; a sequential
/// Draco stream with all bits. Below: an edgebreaker one of twelve bits; KHR_mesh_quantization; sparse over an array that is
/// half wrong, and over nothing; a copy whose place and size are compressed.
pub fn packed() -> Result<Model, Box<dyn Error>> {
    let mut model = document();
    let mesh = ring();
    let texture = model.texture(&png(&letter_f()?)?);
    let paint = |scale: [f64; 2]| {
        json!({"pbrMetallicRoughness": {
            "metallicFactor": 0, "roughnessFactor": 0.4,
            "baseColorTexture": {"index": texture, "extensions": {"KHR_texture_transform": {"scale": scale}}},
        }})
    };
    let material = model.material(paint([4.0, 2.0]));
    let old = &mut Views::new("EXT_meshopt_compression", 0, 1);
    let new = &mut Views::new("KHR_meshopt_compression", 1, 2);
    let plain = model.shape(&mesh);
    let primitives = [
        plain.clone(),
        meshopt(&mut model, &mesh, old),
        meshopt(&mut model, &mesh, new),
        filtered(&mut model, &mesh, new),
        with_draco(&mut model, &mesh, [0, 10, 0]),
        with_draco(&mut model, &mesh, [1, 3, 12]),
        quantized(&mut model, &mesh),
        sparse(&mut model, &mesh, &plain, true),
        sparse(&mut model, &mesh, &plain, false),
    ];
    let place = |k: usize| [(k % 5) as f64 - 2.0, 0.5 - (k / 5) as f64, 0.0];
    for (k, primitive) in primitives.iter().enumerate() {
        let node = model.show(primitive, material, place(k), 0.32);
        turn(&mut model, node);
    }
    // Quantized positions are a quarter of what they were.
    let node = &mut model.json["nodes"][6];
    node["scale"] = json!([1.28, 1.28, 1.28]);
    let node = model.show(&plain, material, [0.0; 3], 1.0);
    let (places, sizes) = (bytes(&[place(9).map(|v| v as f32)]), bytes(&[[0.32_f32; 3]]));
    let mut accessor = |model: &mut Model, data: &[u8]| {
        let view = old.attributes(model, data, 12, "NONE");
        push(&mut model.json["accessors"], float_accessor(view, 3, 1))
    };
    let (places, sizes) = (accessor(&mut model, &places), accessor(&mut model, &sizes));
    let turns = model.vectors(&[[0.422_618_26_f32, 0.0, 0.0, 0.906_307_8]]);
    let attributes = json!({"TRANSLATION": places, "SCALE": sizes, "ROTATION": turns});
    let instancing = json!({"EXT_mesh_gpu_instancing": {"attributes": attributes}});
    model.json["nodes"][node] = json!({"mesh": model.json["nodes"][node]["mesh"], "extensions": instancing});
    model.json["buffers"] = json!([{"byteLength": model.bytes.len()}, old.fallback(), new.fallback()]);
    model.json["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
    Ok(model)
}

fn geometry() -> Built {
    let mut s = Stage::new()?;
    s.key_light(2.0)?;
    s.add(&packed()?.finish(&LoadOptions::default())?, Transform::translation([0.0; 3])?)?;
    s.seen(flat_view())
}

/// By 50 degrees towards the eye.
fn turn(model: &mut Model, node: usize) {
    model.json["nodes"][node]["rotation"] = json!([0.422_618_26, 0.0, 0.0, 0.906_307_8]);
}

/// All views compressed.
fn meshopt(model: &mut Model, mesh: &MeshData, views: &mut Views) -> Value {
    let count = mesh.positions.len();
    let positions = views.attributes(model, &bytes(&mesh.positions), 12, "NONE");
    let normals = views.attributes(model, &bytes(&mesh.normals), 12, "NONE");
    let uvs = views.attributes(model, &bytes(&mesh.uvs[0]), 8, "NONE");
    let indices = views.triangles(model, mesh.triangles.as_flattened());
    let mut add = |accessor: Value| push(&mut model.json["accessors"], accessor);
    json!({
        "attributes": {
            "POSITION": add(float_accessor(positions, 3, count)),
            "NORMAL": add(float_accessor(normals, 3, count)),
            "TEXCOORD_0": add(float_accessor(uvs, 2, count)),
        },
        "indices": add(json!({
            "bufferView": indices, "componentType": U32, "count": 3 * mesh.triangles.len(), "type": "SCALAR",
        })),
    })
}

/// Positions as mantissas and exponents, normals as places on an octahedron.
fn filtered(model: &mut Model, mesh: &MeshData, views: &mut Views) -> Value {
    let count = mesh.positions.len();
    // 2^-16 times a whole number.
    let exponential = |v: &f32| ((-16_i32) << 24 | ((v * 65536.0) as i32 & 0xff_ffff)).to_le_bytes();
    let positions: Vec<u8> = mesh.positions.as_flattened().iter().flat_map(exponential).collect();
    let octahedral = |n: &[f32; 3]| {
        let sum = n[0].abs() + n[1].abs() + n[2].abs();
        let [x, y, z] = n.map(|v| v / sum);
        let away = |v: f32, other: f32| (1.0 - other.abs()) * if v < 0.0 { -1.0 } else { 1.0 };
        let [x, y] = if z < 0.0 { [away(x, y), away(y, x)] } else { [x, y] };
        let code = |v: f32| (v * 127.0 + if v < 0.0 { -0.5 } else { 0.5 }) as i8 as u8;
        [code(x), code(y), 127, 0]
    };
    let normals: Vec<u8> = mesh.normals.iter().flat_map(octahedral).collect();
    let positions = views.attributes(model, &positions, 12, "EXPONENTIAL");
    let normals = views.attributes(model, &normals, 4, "OCTAHEDRAL");
    let mut primitive = meshopt(model, mesh, views);
    let mut add = |accessor: Value| push(&mut model.json["accessors"], accessor);
    primitive["attributes"]["POSITION"] = add(float_accessor(positions, 3, count)).into();
    let normals = json!({
        "bufferView": normals, "componentType": I8, "normalized": true, "count": count, "type": "VEC3",
    });
    primitive["attributes"]["NORMAL"] = add(normals).into();
    primitive
}

/// Method, speed and bits of precision.
fn with_draco(model: &mut Model, mesh: &MeshData, [method, speed, bits]: [i32; 3]) -> Value {
    let view = model.view(&draco::stream(mesh, method, speed, bits));
    let count = mesh.positions.len();
    let mut add = |kind: &str, component: u32, count: usize| {
        push(&mut model.json["accessors"], json!({"componentType": component, "count": count, "type": kind}))
    };
    json!({
        "attributes": {
            "POSITION": add("VEC3", F32, count), "NORMAL": add("VEC3", F32, count),
            "TEXCOORD_0": add("VEC2", F32, count),
        },
        "indices": add("SCALAR", U16, 3 * mesh.triangles.len()),
        "extensions": {"KHR_draco_mesh_compression": {
            "bufferView": view, "attributes": {"POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2},
        }},
    })
}

/// Positions of 16 bits, a quarter of their size; normals of 8 bits, texture coordinates of 16.
fn quantized(model: &mut Model, mesh: &MeshData) -> Value {
    let short = |v: f32| ((v * 0.25 * 32767.0) as i16).to_le_bytes();
    let positions: Vec<[u8; 6]> = mesh
        .positions
        .iter()
        .map(|p| {
            let [[a, b], [c, d], [e, f]] = p.map(short);
            [a, b, c, d, e, f]
        })
        .collect();
    let normals: Vec<[u8; 3]> = mesh.normals.iter().map(|n| n.map(|v| (v * 127.0) as i8 as u8)).collect();
    let uvs: Vec<[u8; 4]> = mesh.uvs[0]
        .iter()
        .map(|uv| {
            let [[a, b], [c, d]] = uv.map(|v| ((v * 65535.0 + 0.5) as u16).to_le_bytes());
            [a, b, c, d]
        })
        .collect();
    json!({
        "attributes": {
            "POSITION": model.packed("VEC3", I16, true, &positions),
            "NORMAL": model.packed("VEC3", I8, true, &normals),
            "TEXCOORD_0": model.packed("VEC2", U16, true, &uvs),
        },
        "indices": model.indices(&mesh.triangles),
    })
}

/// Positions of an array that is half wrong, and a list of those that are right; or of zeros, and all of them.
fn sparse(model: &mut Model, mesh: &MeshData, plain: &Value, over_array: bool) -> Value {
    let count = mesh.positions.len();
    let listed: Vec<usize> = (0..count).filter(|k| !over_array || k % 2 == 1).collect();
    let base = mesh.positions.iter().enumerate().map(|(k, p)| if k % 2 == 1 { [9.0; 3] } else { *p });
    let base = bytes(&base.collect::<Vec<[f32; 3]>>());
    let values = bytes(&listed.iter().map(|&k| mesh.positions[k]).collect::<Vec<_>>());
    let indices: Vec<u8> = listed.iter().flat_map(|&k| (k as u16).to_le_bytes()).collect();
    let base = model.view(&base);
    let (indices, values) = (model.view(&indices), model.view(&values));
    let mut accessor = float_accessor(base, 3, count);
    if !over_array {
        accessor = json!({"componentType": F32, "count": count, "type": "VEC3"});
    }
    accessor["sparse"] = json!({
        "count": listed.len(),
        "indices": {"bufferView": indices, "componentType": U16},
        "values": {"bufferView": values},
    });
    let mut primitive = plain.clone();
    primitive["attributes"]["POSITION"] = push(&mut model.json["accessors"], accessor).into();
    primitive
}

/// 32 x 32 texels: a field of hues, one for each 8 x 8 texels, and a letter F in darker ones. `hole` makes the letter
/// transparent.
fn letter_of_blocks(hole: bool) -> Result<Image, SceneError> {
    image(32, 32, |x, y| {
        let (column, row) = ((x / 8) as u8, (y / 8) as u8);
        let light = [200 - 40 * row, 100 + 30 * column, 60 + 50 * row];
        let stem = (10..14).contains(&x) && (6..26).contains(&y);
        let bars = (14..24).contains(&x) && ((6..10).contains(&y) || (14..18).contains(&y));
        match stem || bars {
            true if hole => [light[0], light[1], light[2], 0],
            true => [light[0] - 60, light[1] - 60, light[2] - 60, 255],
            false => [light[0], light[1], light[2], 255],
        }
    })
}

/// Upper row, opaque: PNG, KTX2 of plain texels, the same in Zstandard, ETC1S, UASTC, UASTC in Zstandard. Middle row: the
/// same with a letter that is cut out. Lower row: WebP; then the upper row from the second on, small and often.
pub fn textured() -> Result<Model, Box<dyn Error>> {
    let mut model = document();
    let mut mesh = square(1);
    mesh.tangents.clear();
    let flat = model.shape(&mesh);
    let kinds = [
        (Storage::Plain, false),
        (Storage::Plain, true),
        (Storage::Etc1s, false),
        (Storage::Uastc, false),
        (Storage::Uastc, true),
    ];
    for (row, hole) in [(0, false), (1, true), (2, false)] {
        let picture = letter_of_blocks(hole)?;
        for column in 0..6 {
            let texture = match column {
                0 if row == 2 => {
                    let file = encoded(&picture, ::image::ImageFormat::WebP)?;
                    model.texture_of("EXT_texture_webp", &file)
                }
                0 => model.texture(&png(&picture)?),
                _ => {
                    let (storage, zstd) = kinds[column - 1];
                    model.texture_of("KHR_texture_basisu", &ktx2::texture(&picture, storage, zstd))
                }
            };
            let mut material = json!({
                "extensions": {"KHR_materials_unlit": {}},
                "pbrMetallicRoughness": {"baseColorTexture": {"index": texture}},
                "alphaMode": if hole { "MASK" } else { "OPAQUE" },
            });
            if row == 2 && column > 0 {
                material["pbrMetallicRoughness"]["baseColorTexture"]["extensions"] =
                    json!({"KHR_texture_transform": {"scale": [3, 3]}});
            }
            let material = model.material(material);
            model.show(&flat, material, [column as f64 - 2.5, 1.0 - f64::from(row), 0.0], 0.45);
        }
    }
    Ok(model)
}

fn basis_textures() -> Built {
    let mut s = Stage::dark()?;
    s.add(
        &textured()?.finish(&LoadOptions::default())?,
        Transform::from_parts([0.0; 3], [0.0, 0.0, 0.0, 1.0], [2.0 / 3.0; 3])?,
    )?;
    s.seen(flat_view())
}
