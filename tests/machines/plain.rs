//! OBJ, STL, PLY and 3MF files of recipes: triangles in their places, for OBJ texture coordinates, and for OBJ and 3MF the
//! names of materials.

use super::files;
use super::package::stored_zip;
use super::recipe::{InstanceRecipe, Recipe};
use std::fmt::Write as _;

/// Position of a mesh's point by the transform of an instance.
fn place(instance: &InstanceRecipe, point: [f32; 3]) -> [f32; 3] {
    let p: [f32; 3] = std::array::from_fn(|k| point[k] * instance.scale[k]);
    let [x, y, z, w] = instance.rotation.map(|c| c as f32);
    // v + 2 w (q x v) + 2 q x (q x v)
    let cross = |a: [f32; 3], b: [f32; 3]| {
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    };
    let once = cross([x, y, z], p);
    let twice = cross([x, y, z], once);
    std::array::from_fn(|k| p[k] + 2.0 * (w * once[k] + twice[k]) + instance.translation[k])
}

/// Corners of all triangles.
fn triangles(recipe: &Recipe) -> impl Iterator<Item = [[f32; 3]; 3]> {
    recipe.instances.iter().flat_map(|instance| {
        let mesh = &recipe.meshes[instance.mesh];
        mesh.triangles.iter().map(|t| t.map(|v| place(instance, mesh.positions[v as usize])))
    })
}

/// Wavefront OBJ and its MTL.
pub fn obj(recipe: &Recipe) -> (String, String) {
    let mut text = "mtllib model.mtl\n".to_owned();
    let (mut first, mut first_uv) = (1, 1);
    for instance in &recipe.instances {
        let mesh = &recipe.meshes[instance.mesh];
        for &point in &mesh.positions {
            let [x, y, z] = place(instance, point);
            let _ = writeln!(text, "v {x:?} {y:?} {z:?}");
        }
        for [u, v] in &mesh.uvs[0] {
            let _ = writeln!(text, "vt {u:?} {v:?}");
        }
        let _ = writeln!(text, "usemtl {}", files::material_name(instance.material));
        for t in &mesh.triangles {
            let corner = |v: u32| match mesh.uvs[0].is_empty() {
                true => format!("{}", first + v),
                false => format!("{}/{}", first + v, first_uv + v),
            };
            let _ = writeln!(text, "f {} {} {}", corner(t[0]), corner(t[1]), corner(t[2]));
        }
        first += mesh.positions.len() as u32;
        first_uv += mesh.uvs[0].len() as u32;
    }
    let mut library = String::new();
    for (k, material) in recipe.materials.iter().enumerate() {
        let [r, g, b, a] = material.base_color;
        let _ = writeln!(library, "newmtl {}\nKd {r:?} {g:?} {b:?}\nd {a:?}", files::material_name(k));
    }
    (text, library)
}

/// Binary STL.
pub fn stl(recipe: &Recipe) -> Vec<u8> {
    let mut bytes = vec![b' '; 80];
    bytes.extend((triangles(recipe).count() as u32).to_le_bytes());
    for corners in triangles(recipe) {
        bytes.extend([0; 12]);
        bytes.extend(corners.as_flattened().iter().flat_map(|v| v.to_le_bytes()));
        bytes.extend([0; 2]);
    }
    bytes
}

/// Big-endian PLY.
pub fn ply(recipe: &Recipe) -> Vec<u8> {
    let count = triangles(recipe).count();
    let mut bytes = format!(
        "ply\nformat binary_big_endian 1.0\nelement vertex {}\nproperty float x\nproperty float y\n\
         property float z\nelement face {count}\nproperty list uchar int vertex_indices\nend_header\n",
        3 * count,
    )
    .into_bytes();
    for corners in triangles(recipe) {
        bytes.extend(corners.as_flattened().iter().flat_map(|v| v.to_be_bytes()));
    }
    for k in 0..count as u32 {
        bytes.push(3);
        bytes.extend((0..3).flat_map(|j| (3 * k + j).to_be_bytes()));
    }
    bytes
}

/// A 3MF package of one part that is not compressed.
pub fn three_mf(recipe: &Recipe) -> Vec<u8> {
    let mut text = "<?xml version=\"1.0\"?><model unit=\"meter\" \
                    xmlns=\"http://schemas.microsoft.com/3dmanufacturing/core/2015/02\"><resources><basematerials id=\"1\">"
        .to_owned();
    for (k, material) in recipe.materials.iter().enumerate() {
        let [r, g, b, a] = material.base_color.map(|v| (v.clamp(0.0, 1.0) * 255.0) as u8);
        let name = files::material_name(k);
        let _ = write!(text, "<base name=\"{name}\" displaycolor=\"#{r:02x}{g:02x}{b:02x}{a:02x}\"/>");
    }
    text += "</basematerials>";
    for (k, instance) in recipe.instances.iter().enumerate() {
        let mesh = &recipe.meshes[instance.mesh];
        let (id, index) = (k + 2, instance.material);
        let _ = write!(text, "<object id=\"{id}\" pid=\"1\" pindex=\"{index}\"><mesh><vertices>");
        for &point in &mesh.positions {
            let [x, y, z] = place(instance, point);
            let _ = write!(text, "<vertex x=\"{x:?}\" y=\"{y:?}\" z=\"{z:?}\"/>");
        }
        text += "</vertices><triangles>";
        for [a, b, c] in &mesh.triangles {
            let _ = write!(text, "<triangle v1=\"{a}\" v2=\"{b}\" v3=\"{c}\"/>");
        }
        text += "</triangles></mesh></object>";
    }
    text += "</resources><build>";
    for k in 0..recipe.instances.len() {
        let _ = write!(text, "<item objectid=\"{}\"/>", k + 2);
    }
    text += "</build></model>";
    stored_zip(&[("3D/3dmodel.model", text.as_bytes())])
}
