//! The models and textures of `assets/`.

mod angle;
mod car;
mod cloth;
mod cut;
mod exchange;
mod glb;
mod letters;
mod material_textures;
mod mesh;
mod model;
mod outline;
mod random;
mod readme;
mod revolve;
mod shapes;
mod solid;
mod subdivide;
mod sweep;
mod textures;

use std::collections::BTreeMap;

use model::Model;

/// The bytes of every file in `models/` and `materials/textures/`, by its path below `assets/`. A model may refer to files below its
/// own folder only, so the textures lie there.
pub fn files() -> BTreeMap<String, Vec<u8>> {
    let mut files = BTreeMap::new();
    let textures = textures::all();
    for (name, image) in &textures {
        files.insert(format!("models/textures/{name}.png"), image.png());
    }
    let of_materials = material_textures::all();
    for (name, image) in &of_materials {
        files.insert(format!("materials/textures/{name}.png"), image.png());
    }
    let models = models();
    let names: Vec<&str> = textures.keys().copied().collect();
    let material_names: Vec<&str> = of_materials.keys().copied().collect();
    files.insert("README.md".into(), readme::text(&models, &names, &material_names).into_bytes());
    for model in models {
        files.insert(format!("models/{}.glb", model.name), glb::encode(&model, &textures));
        match model.name {
            "torus-knot" => {
                let (obj, mtl) = exchange::wavefront(&model);
                files.insert(format!("models/{}.obj", model.name), obj.into_bytes());
                files.insert(format!("models/{}.mtl", model.name), mtl.into_bytes());
            }
            "rounded-cube" => {
                files.insert("models/rounded-cube.stl".into(), exchange::stl(&joined(&model).0));
            }
            "vase" => {
                let (mesh, colors) = joined(&model);
                files.insert("models/vase.ply".into(), exchange::ply(&mesh, &colors, true));
            }
            _ => {}
        }
    }
    files
}

/// Every model.
fn models() -> Vec<Model> {
    vec![
        shapes::material_ball(),
        shapes::torus_knot(),
        shapes::vase(),
        shapes::cloth(),
        shapes::rounded_cube(),
        shapes::text_plate(),
        car::sports_car(),
    ]
}

/// A model as one mesh with a colour per vertex, sRGB approximated by a square root.
fn joined(model: &Model) -> (mesh::Mesh, Vec<[u8; 3]>) {
    let mut whole = mesh::Mesh::default();
    let mut colors = Vec::new();
    for (material, part) in model.flattened() {
        let [r, g, b, _] = model.materials[material].color;
        let color = [r, g, b].map(|c| (c.sqrt() * 255.0 + 0.5).floor() as u8);
        colors.extend(part.vertices.iter().map(|_| color));
        whole.append(&part);
    }
    (whole, colors)
}
