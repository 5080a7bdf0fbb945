//! Roughness that grows where normals vary within a pixel.

use crate::common::stage;
use overcoat::render::{RenderOptions, Renderer};
use overcoat::scene::{
    AlphaUse, Camera, ColorSpace, Image, Light, LightKind, Mesh, MeshData, NormalTexture, Sampler, Scene,
    ShadingModel,
};
use overcoat_core::math::double;
use std::f64::consts::TAU;

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
    body(crate::common::shapes::sphere(64), shift)
}

/// Sum of the light in each of several pictures.
fn light(model: ShadingModel, antialiasing: bool) -> Vec<f64> {
    let mut renderer = Renderer::new(2);
    (0..8)
        .map(|k| {
            let (scene, camera) = ball(f64::from(k) / 8.0);
            let options =
                RenderOptions::draft(SIDE, SIDE).with_shading(model).with_specular_antialiasing(antialiasing);
            let frame = renderer.render(&scene, &camera, &options).unwrap().frame;
            frame.pixels.iter().map(|p| f64::from(p[1])).sum()
        })
        .collect()
}

/// Standard deviation of light, relative to its mean.
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

/// A rod about a pixel thick that leans a little, with rounds of 48 corners.
fn rod() -> MeshData {
    let (lean_sin, lean_cos) = double::sin_cos(0.12);
    crate::common::shapes::surface(1, 48, |u, v| {
        let (sin, cos) = double::sin_cos(TAU * v);
        let (along, across) = (6.0 * u - 3.0, 0.1 * cos);
        let turned = |x: f64, y: f64| [x * lean_cos - y * lean_sin, x * lean_sin + y * lean_cos];
        let ([x, y], [nx, ny], [tx, ty]) = (turned(along, across), turned(0.0, cos), turned(1.0, 0.0));
        ([x, y, 0.1 * sin], [nx, ny, sin], [tx, ty, 0.0])
    })
}

/// A highlight along a thin rod is no row of dots: with the filter of edges, which pictures with shadows have, its columns are
/// more alike than with as many shadings without.
#[test]
fn highlights_along_thin_rods_are_even() {
    for model in [ShadingModel::Standard, ShadingModel::Gltf, ShadingModel::HdrpLit, ShadingModel::UrpDesktop]
    {
        let columns = |options: RenderOptions| {
            let (scene, camera) = body(rod(), 0.0);
            let options = options.with_shading(model);
            let frame = Renderer::new(1).render(&scene, &camera, &options).unwrap().frame;
            let column =
                |x: u32| (0..SIDE).map(|y| f64::from(frame.pixels[(y * SIDE + x) as usize][1])).sum();
            flicker(&(4..SIDE - 4).map(column).collect::<Vec<f64>>())
        };
        let with = columns(RenderOptions::new(SIDE, SIDE));
        let without = columns(RenderOptions::draft(SIDE, SIDE).with_shading_rate(4));
        assert!(with < 0.7 * without, "{model:?}: {without} became {with}");
    }
}

/// A polished plate with a map of facets whose slopes are evenly spread, sixteen texels along a side of a pixel of the small
/// picture; as base or as coat.
fn facets(coated: bool) -> Scene {
    const TEXELS: u32 = 256;
    let mut state = 1_u32;
    let mut slope = || {
        // The sum of four even numbers is nearly a Gauss's.
        let mut sum = -2.0;
        for _ in 0..4 {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            sum += f64::from(state >> 8) / f64::from(1 << 24);
        }
        0.4 * sum
    };
    let texels = (0..TEXELS * TEXELS).map(|_| {
        let (x, y) = (slope(), slope());
        let length = (x * x + y * y + 1.0).sqrt();
        let [x, y, z] = [x, y, 1.0].map(|c| ((c / length + 1.0) * 127.5).round() as u8);
        [x, y, z, 255]
    });
    let image = Image::new(TEXELS, TEXELS, texels.collect()).unwrap();
    let mut stage = stage::Stage::dark().unwrap();
    let texture = stage.texture(image, ColorSpace::Linear, AlphaUse::Normals, Sampler::default()).unwrap();
    let map = Some(NormalTexture { texture, scale: 1.0 });
    let mut material = stage::metal(0.9, 0.9, 0.9, 0.3);
    if coated {
        material = stage::plastic(0.0, 0.0, 0.0, 1.0);
        material.specular = 0.0;
        (material.coat, material.coat_roughness, material.coat_normal_texture) = (1.0, 0.3, map);
    } else {
        material.normal_texture = map;
    }
    let mesh = stage.scene.add_mesh(Mesh::new(crate::common::shapes::square(1)).unwrap()).unwrap();
    let material = stage.material(material).unwrap();
    stage.place(mesh, material, stage::at([0.0; 3], 1.0).unwrap()).unwrap();
    // Half vectors near one standard deviation of the slopes.
    let light = LightKind::Directional { direction: [0.42, 0.0, -0.907_524_1] };
    stage.scene.add_light(Light::new(light).with(|l| l.intensity = 3.0)).unwrap();
    stage.scene
}

/// A minified normal map shows what its texels show together: the light of a picture that has a pixel for each.
#[test]
fn what_normal_maps_lose_as_they_shrink_becomes_roughness() {
    for coated in [false, true] {
        let scene = facets(coated);
        let mean = |side, antialiasing| {
            let options = RenderOptions::draft(side, side)
                .with_samples(4)
                .with_shading(ShadingModel::Standard)
                .with_specular_antialiasing(antialiasing);
            let frame = Renderer::new(1).render(&scene, &stage::flat_view(), &options).unwrap().frame;
            frame.pixels.iter().map(|p| f64::from(p[1])).sum::<f64>() / frame.pixels.len() as f64
        };
        let truth = mean(256, false);
        let [without, with] = [false, true].map(|antialiasing| mean(16, antialiasing) / truth);
        assert!((with - 1.0).abs() < 0.2, "coated {coated}: {with} of the light");
        assert!((without - 1.0).abs() > 0.4, "coated {coated}: {without} of the light without");
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
    let (scene, camera) = body(crate::common::shapes::square(1), 0.0);
    for &model in ShadingModel::ALL {
        let hash = |on| {
            let options = RenderOptions::draft(SIDE, SIDE).with_shading(model).with_specular_antialiasing(on);
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
