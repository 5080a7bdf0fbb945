//! The same models in older formats: OBJ with MTL, binary STL, binary and ascii PLY.

use std::fmt::Write;

use super::mesh::Mesh;
use super::model::{Alpha, Model};

/// Text of the `.obj` and `.mtl` files.
///
/// The MTL file holds the classic terms and the PBR extension (Pr, Pm, Pc, Pcr).
pub fn wavefront(model: &Model) -> (String, String) {
    let mut obj = format!("# {}, made by examples/make-assets\nmtllib {}.mtl\n", model.name, model.name);
    let mut first = 1;
    for (material, mesh) in model.flattened() {
        for vertex in &mesh.vertices {
            let [x, y, z] = vertex.position.to_array();
            line(&mut obj, format_args!("v {x:.5} {y:.5} {z:.5}"));
        }
        for vertex in &mesh.vertices {
            line(&mut obj, format_args!("vt {:.5} {:.5}", vertex.uv.x, 1.0 - vertex.uv.y));
        }
        for vertex in &mesh.vertices {
            let [x, y, z] = vertex.normal.to_array();
            line(&mut obj, format_args!("vn {x:.4} {y:.4} {z:.4}"));
        }
        line(&mut obj, format_args!("usemtl {}", model.materials[material].name));
        for triangle in &mesh.triangles {
            let [a, b, c] = triangle.map(|i| i + first);
            line(&mut obj, format_args!("f {a}/{a}/{a} {b}/{b}/{b} {c}/{c}/{c}"));
        }
        first += mesh.vertices.len() as u32;
    }
    (obj, materials(model))
}

fn materials(model: &Model) -> String {
    let mut mtl = String::new();
    for material in &model.materials {
        let [r, g, b, a] = material.color;
        // A metal has no diffuse colour in the classic terms.
        let diffuse = 1.0 - material.metallic;
        line(&mut mtl, format_args!("newmtl {}", material.name));
        line(&mut mtl, format_args!("Kd {r:.4} {g:.4} {b:.4}"));
        let specular = |c: f64| 0.04 * diffuse + c * material.metallic;
        line(&mut mtl, format_args!("Ks {:.4} {:.4} {:.4}", specular(r), specular(g), specular(b)));
        line(&mut mtl, format_args!("Pr {:.4}\nPm {:.4}", material.roughness, material.metallic));
        if material.coat > 0.0 {
            line(&mut mtl, format_args!("Pc {:.4}\nPcr {:.4}", material.coat, material.coat_roughness));
        }
        let [r, g, b] = material.emissive;
        if r + g + b > 0.0 {
            line(&mut mtl, format_args!("Ke {r:.4} {g:.4} {b:.4}"));
        }
        if material.alpha == Alpha::Blend {
            line(&mut mtl, format_args!("d {a:.4}"));
        }
        if let Some(map) = material.color_map {
            line(&mut mtl, format_args!("map_Kd textures/{map}.png"));
        }
        if let Some(map) = material.normal_map {
            line(&mut mtl, format_args!("norm textures/{map}.png"));
        }
    }
    mtl
}

fn line(text: &mut String, content: std::fmt::Arguments) {
    writeln!(text, "{content}").expect("writing to a string succeeds");
}

/// A binary STL file: facet normals and corners, nothing shared.
pub fn stl(mesh: &Mesh) -> Vec<u8> {
    let mut bytes = vec![b' '; 80];
    let title = b"made by examples/make-assets, MIT OR Apache-2.0";
    bytes[..title.len()].copy_from_slice(title);
    bytes.extend((mesh.triangles.len() as u32).to_le_bytes());
    for triangle in &mesh.triangles {
        let corners = triangle.map(|i| mesh.vertices[i as usize].position);
        let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize_or_zero();
        for vector in [normal, corners[0], corners[1], corners[2]] {
            bytes.extend(vector.to_array().iter().flat_map(|c| (*c as f32).to_le_bytes()));
        }
        bytes.extend([0, 0]);
    }
    bytes
}

/// A PLY file with normals and 8-bit vertex colours, binary (little endian) or ascii.
pub fn ply(mesh: &Mesh, colors: &[[u8; 3]], binary: bool) -> Vec<u8> {
    let format = if binary { "binary_little_endian" } else { "ascii" };
    let mut bytes = format!(
        "ply\nformat {format} 1.0\ncomment made by examples/make-assets, MIT OR Apache-2.0\n\
         element vertex {}\nproperty float x\nproperty float y\nproperty float z\n\
         property float nx\nproperty float ny\nproperty float nz\n\
         property uchar red\nproperty uchar green\nproperty uchar blue\n\
         element face {}\nproperty list uchar int vertex_indices\nend_header\n",
        mesh.vertices.len(),
        mesh.triangles.len()
    )
    .into_bytes();
    for (vertex, color) in mesh.vertices.iter().zip(colors) {
        let numbers = [vertex.position.to_array(), vertex.normal.to_array()].concat();
        if binary {
            bytes.extend(numbers.iter().flat_map(|c| (*c as f32).to_le_bytes()));
            bytes.extend(color);
        } else {
            let mut text = String::new();
            for number in numbers {
                write!(text, "{number:.5} ").expect("writing to a string succeeds");
            }
            line(&mut text, format_args!("{} {} {}", color[0], color[1], color[2]));
            bytes.extend(text.into_bytes());
        }
    }
    for triangle in &mesh.triangles {
        if binary {
            bytes.push(3);
            bytes.extend(triangle.iter().flat_map(|i| i.to_le_bytes()));
        } else {
            bytes.extend(format!("3 {} {} {}\n", triangle[0], triangle[1], triangle[2]).into_bytes());
        }
    }
    bytes
}
