//! A scene that no file holds: a ball of red lacquer, a brass knot and a box on a floor, under the built-in studio and a sun.
//!
//! ```sh
//! cargo run --release --example scene-by-hand -- still-life.png
//! ```

use overcoat::frame::Aov;
use overcoat::output::{OutputFormat, OutputOptions, encode, write_atomically};
use overcoat::render::Rendered;
use overcoat::scene::{
    Camera, Instance, Light, Material, MaterialId, Mesh, SceneError, Transform, Workflow, primitives,
};
use overcoat::{RenderOptions, Renderer, Scene};
use std::error::Error;
use std::path::Path;

/// Numbers of the objects, as the plane of [`Aov::ObjectId`] has them plus 1.
const FLOOR: u32 = 0;
const BALL: u32 = 1;
const KNOT: u32 = 2;
const BOX: u32 = 3;

fn place(
    scene: &mut Scene,
    object: u32,
    mesh: Mesh,
    material: MaterialId,
    transform: Transform,
) -> Result<(), SceneError> {
    let mesh = scene.add_mesh(mesh)?;
    scene.add_instance(Instance::new(mesh, material, transform).with_object(object))
}

/// Metres, +Y up; colours are linear.
fn still_life() -> Result<(Scene, Camera), SceneError> {
    let rough = |metallic, roughness| Workflow::MetallicRoughness { metallic, roughness, texture: None };
    let mut scene = Scene::new();
    let lacquer = scene.add_material(Material::default().with(|m| {
        m.base_color = [0.6, 0.03, 0.05, 1.0];
        m.workflow = rough(0.0, 0.4);
        m.coat = 1.0;
    }))?;
    let brass = scene.add_material(Material::default().with(|m| {
        m.base_color = [0.88, 0.68, 0.3, 1.0];
        m.workflow = rough(1.0, 0.25);
    }))?;
    let chalk = scene.add_material(Material::default().with(|m| {
        m.base_color = [0.5, 0.5, 0.5, 1.0];
        m.workflow = rough(0.0, 0.9);
    }))?;

    place(&mut scene, FLOOR, primitives::plane([4.0, 3.0])?, chalk, Transform::IDENTITY)?;
    let ball = Transform::translation([-0.7, 0.5, 0.2])?;
    place(&mut scene, BALL, primitives::sphere(0.5, 96)?, lacquer, ball)?;
    let knot = Transform::translation([0.55, 0.55, 0.35])?;
    place(&mut scene, KNOT, primitives::torus_knot([2, 3], 0.3, 0.09, [256, 32])?, brass, knot)?;
    let turned = Transform::translation([0.5, 0.6, -0.7])?
        .after(&Transform::rotation([0.0, 1.0, 0.0], 30_f64.to_radians())?)?;
    place(&mut scene, BOX, primitives::cuboid([0.9, 1.2, 0.5])?, chalk, turned)?;

    // From the left, above and behind the viewer; directions may have any length.
    scene.add_light(Light::directional([1.0, -2.0, -1.0], 2.0))?;
    let camera = Camera::look_at([0.6, 1.3, 4.2], [0.0, 0.5, 0.0], [0.0, 1.0, 0.0])?;
    Ok((scene, camera.perspective(32_f32.to_radians())?))
}

fn draw(width: u32, height: u32) -> Result<Rendered, Box<dyn Error>> {
    let (scene, camera) = still_life()?;
    let options = RenderOptions::new(width, height).with_aovs(vec![Aov::ObjectId]);
    Ok(Renderer::builder().build()?.render(&scene, &camera, &options)?)
}

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).unwrap_or_else(|| "still-life.png".to_owned());
    let frame = draw(768, 512)?.frame;
    let bytes = encode(&frame, OutputFormat::Png, &OutputOptions::default())?;
    write_atomically(Path::new(&path), &bytes)?;
    // The same on every machine.
    println!("{path} {}", frame.frame_hash());
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn everything_is_where_it_was_put() {
        let frame = draw(96, 64).unwrap().frame;
        let plane = frame.plane(Aov::ObjectId).unwrap();
        for object in [FLOOR, BALL, KNOT, BOX] {
            let pixels = plane.ids.iter().filter(|&&id| id == object + 1).count();
            assert!(pixels > 100, "object {object} has {pixels} pixels");
        }
        // The ball is left of the middle, and red.
        let (x, y) = (33, 32);
        assert_eq!(frame.id(Aov::ObjectId, x, y), Some(BALL + 1));
        let [red, green, ..] = frame.pixel(x, y).unwrap();
        assert!(red > 2.0 * green, "{red} {green}");
    }
}
