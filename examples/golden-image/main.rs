//! A scene of one's own, drawn, and kept from changing by a golden picture.
//!
//! ```sh
//! cargo run --release --example golden-image -- gem.png   # draws it
//! cargo test --release --example golden-image             # holds it against golden/gem.png
//! ```
//!
//! Change a number in `gem` and run the test again: it fails, names `golden/gem.png` and what was drawn instead,
//! `golden/gem.new.png`, and `overcoat golden report examples/golden-image/golden examples/golden-image/golden -o
//! report.html` shows both. If the change was meant, `UPDATE_GOLDENS=1` with the same test, or `overcoat golden accept`,
//! records it.

use overcoat::frame::{DisplayImage, DisplayOptions};
use overcoat::output::encode_png;
use overcoat::scene::{
    Camera, Framing, Instance, Material, Mesh, MeshData, SceneError, ShadingModel, Transform, Workflow,
};
use overcoat::{RenderOptions, Renderer, Scene};
use std::error::Error;

/// An octahedron of red lacquer.
fn gem() -> Result<(Scene, Camera), SceneError> {
    let mut scene = Scene::new();
    let mesh = scene.add_mesh(Mesh::new(MeshData::default().with(|d| {
        d.positions = vec![
            [1.0, 0.0, 0.0],
            [-1.0, 0.0, 0.0],
            [0.0, 1.5, 0.0],
            [0.0, -1.5, 0.0],
            [0.0, 0.0, 1.0],
            [0.0, 0.0, -1.0],
        ];
        d.triangles =
            vec![[2, 4, 0], [2, 0, 5], [2, 5, 1], [2, 1, 4], [3, 0, 4], [3, 5, 0], [3, 1, 5], [3, 4, 1]];
    }))?)?;
    let lacquer = scene.add_material(Material::default().with(|m| {
        m.base_color = [0.6, 0.03, 0.05, 1.0];
        m.workflow = Workflow::MetallicRoughness { metallic: 0.0, roughness: 0.4, texture: None };
        m.coat = 1.0;
    }))?;
    scene.add_instance(Instance::new(mesh, lacquer, Transform::IDENTITY))?;
    let camera = Framing::default().camera(&scene);
    Ok((scene, camera))
}

/// The picture of a scene, 8 bits a channel with straight alpha.
fn draw(scene: &Scene, camera: &Camera) -> Result<DisplayImage, Box<dyn Error>> {
    // Named, so that another default changes nothing.
    let options = RenderOptions::draft(128, 128).with_shading(ShadingModel::Gltf);
    let rendered = Renderer::new(1).render(scene, camera, &options)?;
    Ok(DisplayImage::new(&rendered.frame, &DisplayOptions::default()))
}

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).unwrap_or_else(|| "gem.png".to_owned());
    let (scene, camera) = gem()?;
    std::fs::write(&path, encode_png(&draw(&scene, &camera)?)?)?;
    println!("{path}");
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use overcoat::golden::Golden;

    #[test]
    fn the_gem_looks_as_it_should() {
        let (scene, camera) = gem().unwrap();
        let goldens = Golden::new(concat!(env!("CARGO_MANIFEST_DIR"), "/examples/golden-image/golden"));
        goldens.assert("gem", &draw(&scene, &camera).unwrap());
    }
}
