//! Roughness that grows where normals vary within a pixel.

use crate::common::stage;
use overcoat::description::{Description, Machine};
use overcoat::jobs::Jobs;
use overcoat::limits::Limits;
use overcoat::render::{RenderOptions, Renderer};
use overcoat::scene::{
    AlphaUse, Camera, ColorSpace, Image, Light, LightKind, Mesh, MeshData, NormalTexture, Sampler, Scene,
    ShadingModel,
};
use overcoat_core::color::srgb::{linear_to_srgb, srgb_to_linear};

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

/// A picture of the sports car over white by the defaults, as codes of sRGB, 0 to 1.
fn car(side: u32) -> Vec<[f64; 3]> {
    let mut description = Description::default();
    let model = concat!(env!("CARGO_MANIFEST_DIR"), "/../../assets/models/sports-car.glb");
    (description.model, description.size) = (Some(model.into()), Some([side.into(), side.into()]));
    let jobs = Jobs::new(2);
    let picture = description.picture(Machine::default(), &Limits::default(), &jobs).unwrap();
    let display = picture.display.with_background(Some([255; 3]));
    let drawn = Renderer::new(2).render_image(&picture.scene, &picture.camera, &picture.options, &display);
    let codes = drawn.unwrap().image.pixels;
    codes.iter().map(|pixel| [0, 1, 2].map(|k| f64::from(pixel[k]) / 255.0)).collect()
}

/// A picture as it is when a larger one is shrunk: means of light.
fn shrunk(large: &[[f64; 3]], side: usize, times: usize) -> Vec<[f64; 3]> {
    let light = |code: f64| f64::from(srgb_to_linear(code as f32));
    let at = |x: usize, y: usize, k: usize| {
        let own = (0..times * times).map(|n| (y * times + n / times) * side * times + x * times + n % times);
        linear_to_srgb((own.map(|n| light(large[n][k])).sum::<f64>() / (times * times) as f64) as f32)
    };
    (0..side * side).map(|n| [0, 1, 2].map(|k| f64::from(at(n % side, n / side, k)))).collect()
}

/// Gaps between panels, frames and sills are lines and no rows of dots: what a small picture differs by from a large one that is
/// shrunk hardly changes from pixel to pixel. Without the filter of edges it does by .0178 (root mean square).
#[test]
fn gaps_and_frames_are_lines_and_no_rows_of_dots() {
    const SIDE: usize = 256;
    let (small, large) = (car(SIDE as u32), car(4 * SIDE as u32));
    let off: Vec<[f64; 3]> =
        (small.iter().zip(shrunk(&large, SIDE, 4))).map(|(a, b)| [0, 1, 2].map(|k| a[k] - b[k])).collect();
    let mut squares = 0.0;
    for n in (1..SIDE - 1).flat_map(|y| (1..SIDE - 1).map(move |x| y * SIDE + x)) {
        for k in 0..3 {
            let around = off[n - 1][k] + off[n + 1][k] + off[n - SIDE][k] + off[n + SIDE][k];
            let change = off[n][k] - 0.25 * around;
            squares += change * change;
        }
    }
    let change = (squares / (3 * (SIDE - 2).pow(2)) as f64).sqrt();
    assert!(change < 0.0167, "{change}");
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
