//! Energy of light through rough glass.

use super::ground_tests::{add, white};
use super::*;
use overcoat_scene::{Material, Projection, Workflow, primitives};

/// Light that the middle of a picture sends to the eye, of a white pane in even white light; where the picture is open, the
/// white light behind it is seen.
fn through(roughness: f32, thickness: f32, ior: f32, has_board: bool) -> f32 {
    let mut scene = white();
    let dielectric = |roughness| Workflow::MetallicRoughness { metallic: 0.0, roughness, texture: None };
    let glass = Material::default().with(|m| {
        m.ior = ior;
        m.workflow = dielectric(roughness);
        m.lobes.transmission.factor = 1.0.into();
        m.lobes.transmission.thickness = thickness.into();
    });
    add(&mut scene, primitives::cuboid([0.6, 0.6, 0.02]).unwrap(), glass, [0.0; 3]);
    if has_board {
        let board = Material::default().with(|m| m.workflow = dielectric(1.0));
        add(&mut scene, primitives::cuboid([1.0, 1.0, 0.02]).unwrap(), board, [0.0, 0.0, -0.3]);
    }
    let camera =
        Camera::new([0.0, 0.0, 3.0], [0.0; 3], [0.0, 1.0, 0.0], Projection::Perspective { fov_y: 0.8 }, 0.1);
    let options = RenderOptions::draft(96, 96).with_samples(1);
    let frame = Renderer::new(1).render(&scene, &camera, &options).unwrap().frame;
    let middle = 48 * 96 + 48;
    let [r, _, _, alpha] = frame.pixels[middle];
    let open = frame.transmittance.get(middle).map_or(1.0 - alpha, |open| open[0]);
    r + open
}

/// A white furnace: glass that absorbs nothing is as bright as the light around it, whatever its roughness, thickness and
/// index, before a white board that is small in the picture as before nothing.
#[test]
fn rough_glass_keeps_the_light_of_a_furnace() {
    for has_board in [false, true] {
        for thickness in [0.0, 0.02] {
            for ior in [1.0, 1.33, 1.5, 2.4] {
                let mut before = None;
                for step in 0..=20 {
                    let light = through(step as f32 * 0.05, thickness, ior, has_board);
                    let what = format!("board {has_board}, thickness {thickness}, index {ior}, step {step}");
                    assert!((0.9..1.1).contains(&light), "{what}: {light}");
                    let from = before.replace(light).unwrap_or(light);
                    assert!((light - from).abs() < 0.02, "{what}: {light} after {from}");
                }
            }
        }
    }
}
