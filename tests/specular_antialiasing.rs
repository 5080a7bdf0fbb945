//! Roughness that grows where normals vary within a pixel.

#[allow(dead_code, reason = "other tests use the rest")]
mod common;

use common::stage;
use overcoat::render::{RenderOptions, Renderer};
use overcoat::scene::{Camera, Mesh, MeshData, Scene, ShadingModel};

const SIDE: u32 = 40;

/// A shining body under a lamp, moved by a part of a pixel.
fn body(mesh: MeshData, shift: f64) -> (Scene, Camera) {
    let mut stage = stage::Stage::dark().unwrap();
    let mesh = stage.scene.add_mesh(Mesh::new(mesh).unwrap()).unwrap();
    let material = stage.material(stage::metal(0.9, 0.9, 0.9, 0.12)).unwrap();
    let pixel = 2.0 * 8.0 * 0.1 / f64::from(SIDE);
    stage.place(mesh, material, stage::at([shift * pixel, 0.0, 0.0], 0.25).unwrap()).unwrap();
    stage.key_light(8.0).unwrap();
    (stage.scene, stage::look([0.0, 0.0, 8.0], [0.0; 3], 11.4))
}

fn ball(shift: f64) -> (Scene, Camera) {
    body(common::shapes::sphere(64), shift)
}

/// Sum of the light in each of several pictures.
fn light(model: ShadingModel, antialiasing: bool) -> Vec<f64> {
    let mut renderer = Renderer::new(2);
    (0..8)
        .map(|k| {
            let (scene, camera) = ball(f64::from(k) / 8.0);
            let options =
                RenderOptions::new(SIDE, SIDE).with_shading(model).with_specular_antialiasing(antialiasing);
            let frame = renderer.render(&scene, &camera, &options).unwrap().frame;
            frame.pixels.iter().map(|p| f64::from(p[1])).sum()
        })
        .collect()
}

/// How far light strays from its mean, as a part of it.
fn flicker(light: &[f64]) -> f64 {
    let mean = light.iter().sum::<f64>() / light.len() as f64;
    let variance = light.iter().map(|l| (l - mean) * (l - mean)).sum::<f64>() / light.len() as f64;
    variance.sqrt() / mean
}

#[test]
fn highlights_of_moving_surfaces_flicker_less() {
    for model in [ShadingModel::Gltf, ShadingModel::Filament, ShadingModel::OpenPbr, ShadingModel::HdrpLit] {
        let [without, with] = [false, true].map(|on| flicker(&light(model, on)));
        assert!(with < 0.7 * without, "{model:?}: {without} became {with}");
    }
}

#[test]
fn models_of_three_have_their_own_whether_asked_or_not() {
    for model in [ShadingModel::Three, ShadingModel::ThreeLegacy] {
        assert_eq!(light(model, false), light(model, true), "{model:?}");
    }
}

#[test]
fn flat_surfaces_stay_as_they_are() {
    let (scene, camera) = body(common::shapes::square(1), 0.0);
    for &model in ShadingModel::ALL {
        let hash = |on| {
            let options = RenderOptions::new(SIDE, SIDE).with_shading(model).with_specular_antialiasing(on);
            Renderer::new(1).render(&scene, &camera, &options).unwrap().frame
        };
        let pixels = hash(false).pixels.into_iter().zip(hash(true).pixels);
        for (without, with) in pixels {
            for k in 0..4 {
                let off = (without[k] - with[k]).abs();
                assert!(off <= 1e-5 * without[k].abs(), "{model:?}: {without:?} became {with:?}");
            }
        }
    }
}
