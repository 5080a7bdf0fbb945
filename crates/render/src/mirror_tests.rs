use super::*;
use overcoat_scene::{
    AlphaMode, Bounds, Environment, EnvironmentSource, Instance, Material, Projection, Transform, Workflow,
    primitives,
};

const SIDE: u32 = 96;
const BOX: [f32; 3] = [0.8, 0.2, 0.1];

/// Boxes of one unlit colour, whose floor is at -1.
fn boxes(places: &[[f64; 3]], scale: [f32; 3]) -> Scene {
    let mut scene = Scene::new();
    scene.set_environment(Environment::default().with(|e| e.source = EnvironmentSource::None)).unwrap();
    let [r, g, b] = BOX;
    let material = Material::default().with(|m| {
        m.unlit = true;
        m.base_color = [r, g, b, 1.0];
    });
    let material = scene.add_material(material).unwrap();
    let mesh = scene.add_mesh(primitives::cuboid([0.4, 0.5, 0.6]).unwrap()).unwrap();
    for &at in places {
        let scale = scale.map(f64::from);
        let transform = Transform::from_parts(at, [0.0, 0.0, 0.0, 1.0], scale).unwrap();
        scene.add_instance(Instance::new(mesh, material, transform)).unwrap();
    }
    scene
}

/// One box on the floor, and one that floats.
fn two() -> Scene {
    boxes(&[[0.0, -0.75, 0.0], [0.5, 0.1, -0.3]], [1.0; 3])
}

fn with_projection(mut camera: Camera, projection: Projection) -> Camera {
    camera.projection = projection;
    camera
}

/// From a height over the floor.
fn camera(height: f32) -> Camera {
    let projection = Projection::Perspective { fov_y: 0.5 };
    Camera::new([1.0, height - 1.0, 6.0], [0.2, -0.9, 0.0], [0.1, 1.0, 0.0], projection, 0.1)
}

fn options(ground: Ground, reflection: f32) -> RenderOptions {
    let few = Visibility::new(12, 32, 0);
    let options = RenderOptions::draft(SIDE, SIDE).with_samples(4).with_visibility(few);
    // A floor that ends far away.
    let under = Bounds { min: [-20.0, -1.0, -20.0], max: [20.0, 1.0, 20.0] };
    options.with_ground(ground).with_ground_under(Some(under)).with_ground_reflection(reflection)
}

fn draw(scene: &Scene, camera: &Camera, options: &RenderOptions) -> Rendered {
    Renderer::new(2).render(scene, camera, options).unwrap()
}

/// The mirror of a black floor shows what a second model would that hangs below the floor: in orthographic views, in perspective
/// ones, and where the camera is tilted.
#[test]
fn it_shows_the_model_upside_down_below_the_floor() {
    let both = boxes(&[[0.0, -0.75, 0.0], [0.5, 0.1, -0.3], [0.0, -1.25, 0.0], [0.5, -2.1, -0.3]], [1.0; 3]);
    let side = Projection::Orthographic { height: 3.0 };
    for camera in [camera(1.5), with_projection(camera(4.0), side)] {
        let expected = draw(&both, &camera, &options(Ground::None, 0.0)).frame;
        let found = draw(&two(), &camera, &options(Ground::Color([0; 3]), 1.0)).frame;
        let own = draw(&two(), &camera, &options(Ground::None, 0.0)).frame;
        let (mut mirrored, mut sums) = (0, [0.0; 2]);
        for y in 1..SIDE - 1 {
            for x in 1..SIDE - 1 {
                let at = |frame: &Frame, x: u32, y: u32| frame.pixels[(y * SIDE + x) as usize];
                let (wanted, got) = (at(&expected, x, y), at(&found, x, y));
                sums = [sums[0] + wanted[0], sums[1] + got[0]];
                if at(&own, x, y)[3] > 0.0 {
                    continue;
                }
                mirrored += u32::from(wanted[3] > 0.0);
                // Samples lie elsewhere in pixels that are upside down: edges are as smooth, and not the same.
                let mut around = (y - 1..=y + 1).flat_map(|v| (x - 1..=x + 1).map(move |u| (u, v)));
                if around.all(|(u, v)| at(&expected, u, v) == wanted) {
                    let far = (0..3).any(|c| (wanted[c] - got[c]).abs() > 1e-5);
                    assert!(!far, "{wanted:?} {got:?} at {x} {y}");
                }
            }
        }
        assert!(mirrored > 300, "{mirrored}");
        assert!((sums[0] / sums[1] - 1.0).abs() < 0.01, "{sums:?}");
    }
}

/// Half as strong a mirror sends half; over a shadow it is as opaque as it sends back.
#[test]
fn its_strength_is_its_opacity() {
    let scene = two();
    let without = draw(&scene, &camera(1.5), &options(Ground::Shadow, 0.0)).frame;
    let half = draw(&scene, &camera(1.5), &options(Ground::Shadow, 0.5)).frame;
    let own = draw(&scene, &camera(1.5), &options(Ground::None, 0.0)).frame;
    let mut seen = 0;
    for ((without, half), own) in without.pixels.iter().zip(&half.pixels).zip(&own.pixels) {
        if own[3] == 1.0 {
            assert_eq!(own, half);
        }
        let part = half[0] / BOX[0];
        if own[3] == 0.0 && part > 0.0 {
            assert!(part <= 0.5 + 1e-5, "{part}");
            let expected = 1.0 - (1.0 - without[3]) * (1.0 - part);
            assert!((half[3] - expected).abs() < 1e-5, "{half:?} {expected}");
            assert!((half[1] - BOX[1] * part).abs() < 1e-6 && (half[2] - BOX[2] * part).abs() < 1e-6);
            seen += 1;
        }
    }
    assert!(seen > 300, "{seen}");
}

#[test]
fn nothing_is_mirrored_without_a_floor() {
    let scene = two();
    let below = camera(-0.5);
    for (ground, camera) in
        [(Ground::None, camera(1.5)), (Ground::Shadow, below), (Ground::Color([9; 3]), below)]
    {
        let [with, without] =
            [0.7, 0.0].map(|reflection| draw(&scene, &camera, &options(ground, reflection)).frame);
        assert!(with == without);
    }
    let nothing = draw(&Scene::new(), &camera(1.0), &options(Ground::Shadow, 1.0).with_ground_under(None));
    assert!(nothing.frame.pixels.iter().all(|pixel| *pixel == [0.0; 4]));
    for wrong in [-0.1, 1.1, f32::NAN] {
        assert!(matches!(
            Renderer::new(1).render(&scene, &camera(1.0), &options(Ground::Shadow, wrong)),
            Err(RenderError::Option { option: "ground reflection", .. })
        ));
    }
}

/// Everything that surfaces can be is in the mirror, and no picture is other for threads, tiles, instruction sets, or what was drawn
/// before it.
#[test]
fn its_bits_depend_on_no_machine() {
    let mut scene = two();
    let ball = scene.add_mesh(primitives::sphere(0.3, 24).unwrap()).unwrap();
    for (k, alpha_mode) in [AlphaMode::Opaque, AlphaMode::Blend].into_iter().enumerate() {
        let workflow = Workflow::MetallicRoughness { metallic: 1.0, roughness: 0.2, texture: None };
        let base_color = [0.9, 0.8, 0.5, 0.5];
        let material = scene.add_material(Material::default().with(|m| {
            m.workflow = workflow;
            m.alpha_mode = alpha_mode;
            m.base_color = base_color;
        }));
        let at = Transform::from_parts([-0.8, -0.4, 0.7 * k as f64], [0.0, 0.0, 0.0, 1.0], [1.0; 3]).unwrap();
        let instance = Instance::new(ball, material.unwrap(), at);
        scene.add_instance(instance).unwrap();
    }
    scene.set_environment(Environment::default()).unwrap();
    for (ground, rays) in [(Ground::Shadow, 0), (Ground::Color([90, 200, 120]), 2)] {
        let options =
            options(ground, 0.4).with_visibility(Visibility::new(12, 32, rays)).with_stage_hashes(true);
        let options = options.with_width(101).with_height(75);
        let expected = draw(&scene, &camera(1.0), &options);
        for (threads, tile) in [(1, 16), (3, 64)] {
            let options = options.clone().with_tile_size(Some(tile));
            let mut renderer = Renderer::new(threads);
            for height in [2.0, 1.0] {
                let found = renderer.render(&scene, &camera(height), &options).unwrap();
                if height == 1.0 {
                    assert!(found.frame == expected.frame, "{ground:?} {tile}");
                    assert!(found.stats.stage_hashes == expected.stats.stage_hashes);
                }
            }
        }
        let other = draw(&scene, &camera(1.0), &options.with_ground_reflection(0.0));
        assert_ne!(other.stats.stage_hashes.unwrap().ground, expected.stats.stage_hashes.unwrap().ground);
    }
}
