//! Shadows of glass and of blended surfaces: the colour that light has behind them, and that their bits are the same everywhere.

use overcoat::render::{Ground, Quality, RenderOptions, Renderer, Visibility};
use overcoat::scene::{
    AlphaMode, Camera, Environment, EnvironmentSource, EquirectImage, Instance, Light, LightKind, Material,
    Mesh, Projection, Scene, ShadingModel, Transform, Workflow, primitives,
};
use overcoat_core::math::lanes::SimdLevel;
use std::sync::Arc;

const SIZE: u32 = 64;

fn matte() -> Material {
    Material::default().with(|m| {
        m.base_color = [0.8, 0.8, 0.8, 1.0];
        m.workflow = Workflow::MetallicRoughness { metallic: 0.0, roughness: 1.0, texture: None };
        m.specular = 0.0;
    })
}

/// Glass that reflects nothing and leaves a quarter of red and a half of green.
fn glass() -> Material {
    let mut material = matte().with(|m| {
        m.base_color = [0.25, 0.5, 1.0, 1.0];
        m.ior = 1.0;
    });
    material.lobes.transmission.factor.factor = 1.0;
    material
}

/// A veil that leaves a half.
fn veil() -> Material {
    matte().with(|m| {
        m.base_color = [1.0, 0.0, 0.0, 0.5];
        m.alpha_mode = AlphaMode::Blend;
    })
}

/// A sky of radiance 1.
fn white() -> EnvironmentSource {
    EnvironmentSource::Image(Arc::new(EquirectImage::new(4, 2, vec![[1.0; 3]; 8]).unwrap()))
}

fn put(scene: &mut Scene, mesh: Mesh, material: Material, place: [f64; 3]) {
    let mesh = scene.add_mesh(mesh).unwrap();
    let material = scene.add_material(material).unwrap();
    let transform = Transform::translation(place).unwrap();
    scene.add_instance(Instance::new(mesh, material, transform)).unwrap();
}

/// A floor, and a pane to the right of x = 0 over it.
fn pane_over_floor(pane: Material, environment: EnvironmentSource, lights: &[Light]) -> Scene {
    let mut scene = Scene::new();
    scene.set_environment(Environment::default().with(|e| e.source = environment)).unwrap();
    lights.iter().for_each(|light| scene.add_light(*light).unwrap());
    put(&mut scene, primitives::plane([8.0, 8.0]).unwrap(), matte(), [0.0; 3]);
    put(&mut scene, primitives::plane([8.0, 16.0]).unwrap(), pane, [4.0, 0.8, 0.0]);
    scene
}

/// From below the pane, so that the floor is seen and not the pane: x runs to the right, from -4 to 4.
fn below_pane() -> Camera {
    let eye = [0.0, 0.4, 0.0];
    Camera::new(eye, [0.0; 3], [0.0, 0.0, -1.0], Projection::Orthographic { height: 8.0 }, 0.01)
}

fn options(visibility: Visibility) -> RenderOptions {
    RenderOptions::draft(SIZE, SIZE)
        .with_samples(1)
        .with_shading(ShadingModel::Three)
        .with_visibility(visibility)
}

fn draw(scene: &Scene, visibility: Visibility) -> Vec<[f32; 4]> {
    Renderer::new(2).render(scene, &below_pane(), &options(visibility)).unwrap().frame.pixels
}

/// Share of each colour that arrives at a place of the floor.
fn arriving(scene: &Scene, visibility: Visibility, x: f32) -> [f32; 3] {
    let pixel = (SIZE / 2 * SIZE) as usize + ((x + 4.0) / 8.0 * SIZE as f32) as usize;
    let (open, seen) = (draw(scene, Visibility::NONE)[pixel], draw(scene, visibility)[pixel]);
    std::array::from_fn(|k| seen[k] / open[k])
}

#[track_caller]
fn assert_near(found: [f32; 3], expected: [f32; 3], tolerance: f32) {
    let near = found.iter().zip(expected).all(|(a, b)| (a - b).abs() <= tolerance);
    assert!(near, "{found:?} for {expected:?}");
}

fn tiers() -> impl Iterator<Item = Visibility> {
    // By maps alone, and by rays as well.
    [Quality::Fast, Quality::Good].into_iter().map(Quality::visibility)
}

fn every_lamp() -> [Light; 5] {
    let (half_width, half_height) = ([0.5, 0.0, 0.0], [0.0, 0.0, 0.5]);
    let spot = LightKind::Spot {
        position: [0.0, 6.0, 0.5],
        direction: [0.0, -1.0, 0.0],
        range: None,
        inner_cone_cosine: 0.7,
        outer_cone_cosine: 0.6,
    };
    let rect = LightKind::Rect { position: [0.0, 4.0, 0.0], half_width, half_height, two_sided: true };
    let tube = LightKind::Tube { ends: [[-0.5, 4.0, 0.0], [0.5, 4.0, 0.0]], radius: 0.02 };
    [
        Light::directional([-0.2, -1.0, 0.2], 3.0),
        Light::point([0.5, 3.0, -0.4], 30.0),
        Light::new(spot).with(|l| l.intensity = 100.0),
        Light::new(rect).with(|l| l.intensity = 20.0),
        Light::new(tube).with(|l| l.intensity = 100.0),
    ]
}

#[test]
fn lamps_are_tinted_by_what_they_shine_through() {
    for light in every_lamp() {
        for (pane, left) in [(glass(), [0.25, 0.5, 1.0]), (veil(), [0.5; 3])] {
            let scene = pane_over_floor(pane, EnvironmentSource::None, &[light]);
            for visibility in tiers().map(|visibility| visibility.with_rays(0)) {
                // Right below the pane, and far enough aside that no ray through it arrives.
                assert_near(arriving(&scene, visibility, 2.5), left, 0.02);
                assert_near(arriving(&scene, visibility, -2.5), [1.0; 3], 0.005);
            }
        }
    }
}

/// Glass sends nothing of its own. A veil that leaves V sends back what the floor itself would, V + r V (1 - V) / (1 - r (1 - V))
/// in all for its reflectance r of .8.
#[test]
fn the_sky_is_tinted_by_what_it_is_seen_through() {
    for (pane, left) in [(glass(), [0.25, 0.5, 1.0]), (veil(), [0.5 + 0.8 * 0.25 / 0.6; 3])] {
        let scene = pane_over_floor(pane, white(), &[]);
        for visibility in tiers() {
            // A little of the sky is seen beside the pane.
            assert_near(arriving(&scene, visibility, 2.5), left, 0.03);
            assert_near(arriving(&scene, visibility, -3.5), [1.0; 3], 0.01);
        }
    }
}

/// The floor below a model has the colour that its glass leaves.
#[test]
fn the_floor_below_glass_is_tinted() {
    let mut scene = Scene::new();
    let environment = Environment::default().with(|e| e.source = white());
    scene.set_environment(environment).unwrap();
    put(&mut scene, primitives::cuboid([1.0; 3]).unwrap(), glass(), [0.0, 0.5, 0.0]);
    let camera = Camera::look_at([0.0, 2.0, 3.0], [0.0, 0.0, 0.6], [0.0, 1.0, 0.0]).unwrap();
    let options = options(Quality::Fast.visibility()).with_ground(Ground::Color([255; 3]));
    let picture = Renderer::new(2).render(&scene, &camera, &options).unwrap().frame.pixels;
    let bluest = picture.iter().filter(|p| p[3] > 0.99).map(|[r, _, b, _]| b - r).fold(0.0, f32::max);
    assert!(bluest > 0.1, "{bluest}");
    // Before the cube and not through it.
    let [red, green, blue, _] = picture[(SIZE * SIZE * 11 / 16 + SIZE / 2) as usize];
    assert!(blue > green && green > red && blue > red + 0.02, "{red} {green} {blue}");
}

/// Threads, instruction sets and tiles leave no trace, nor do pictures before.
#[test]
fn bits_are_the_same_everywhere() {
    let [sun, point, ..] = every_lamp();
    let mut scene = pane_over_floor(glass(), EnvironmentSource::Studio, &[sun, point]);
    let mut amber = glass();
    amber.base_color = [1.0, 0.6, 0.1, 1.0];
    amber.lobes.transmission.thickness.factor = 0.5;
    amber.lobes.transmission.attenuation_distance = 0.5;
    amber.lobes.transmission.attenuation_color = [0.9, 0.7, 0.2];
    put(&mut scene, primitives::sphere(0.6, 24).unwrap(), amber, [-1.5, 0.6, 0.0]);
    put(&mut scene, primitives::cuboid([0.5; 3]).unwrap(), veil(), [-1.0, 0.3, 1.5]);
    let camera = Camera::look_at([0.0, 5.0, 8.0], [0.0; 3], [0.0, 1.0, 0.0]).unwrap();
    for visibility in tiers().map(|visibility| visibility.with_rays(visibility.rays.min(2))) {
        let hashes = |threads: usize, options: &RenderOptions| {
            let mut renderer = Renderer::new(threads);
            let first = renderer.render(&scene, &camera, options).unwrap().stats.stage_hashes;
            assert_eq!(renderer.render(&scene, &camera, options).unwrap().stats.stage_hashes, first);
            first
        };
        let options = options(visibility).with_ground(Ground::Shadow).with_stage_hashes(true);
        let expected = hashes(1, &options);
        for level in SimdLevel::available() {
            assert_eq!(hashes(2, &options.clone().with_simd(level)), expected, "{visibility:?} {level}");
        }
        assert_eq!(hashes(3, &options.clone().with_tile_size(Some(16))), expected);
    }
}
