//! Light within limits: meshes at several places, and rays that are too many.

use super::*;
use overcoat_core::limits::Limits;
use overcoat_scene::{AlphaMode, Instance, Light, LightKind, Material, Transform, primitives};
use overcoat_tiles::quality::Visibility;

/// Balls at many places, of one mesh or each of its own: more triangles than copies are made of for rays. Some are mirrored,
/// some have another material, and a plate stands once.
fn balls(is_shared: bool) -> Scene {
    let mut scene = Scene::new();
    let plain = Material::default().with(|m| m.base_color = [0.8, 0.3, 0.2, 1.0]);
    let both = Material::default().with(|m| {
        m.double_sided = true;
        m.base_color = [0.2, 0.5, 0.9, 1.0];
    });
    let bright = Material::default().with(|m| m.emissive = [3.0, 2.0, 1.0]);
    let holes = AlphaMode::Mask { cutoff: 0.5 };
    let holes = Material::default().with(|m| {
        m.alpha_mode = holes;
        m.base_color = [0.9, 0.9, 0.9, 0.7];
    });
    let materials = [plain, both, bright, holes].map(|material| scene.add_material(material).unwrap());
    let ball = primitives::sphere(0.45, 24).unwrap();
    let shared = scene.add_mesh(ball.clone()).unwrap();
    let plate = scene.add_mesh(primitives::cuboid([4.0, 0.1, 4.0]).unwrap()).unwrap();
    for k in 0..36 {
        if k == 20 {
            let below = Transform::translation([1.0, -0.6, 1.0]).unwrap();
            scene.add_instance(Instance::new(plate, materials[0], below)).unwrap();
        }
        let at = [f64::from(k % 6) * 0.7, f64::from(k / 18) * 0.8, f64::from(k / 6 % 3) * 0.7];
        let scale = [if k % 5 == 0 { -1.0 } else { 1.0 }, 0.8, 1.1];
        let place = Transform::from_parts(at, [0.1 * f64::from(k), 0.0, 0.3, 1.0], scale).unwrap();
        let mesh = if is_shared { shared } else { scene.add_mesh(ball.clone()).unwrap() };
        scene.add_instance(Instance::new(mesh, materials[k as usize % 4], place)).unwrap();
    }
    scene
}

fn camera() -> Camera {
    let projection = overcoat_scene::Projection::Perspective { fov_y: 0.6 };
    Camera::new([7.0, 5.0, 8.0], [1.5, 0.3, 0.7], [0.0, 1.0, 0.0], projection, 0.1)
}

fn options() -> RenderOptions {
    RenderOptions::draft(64, 48).with_samples(4).with_visibility(Visibility::new(16, 64, 4))
}

fn draw(scene: &Scene, options: &RenderOptions, threads: usize) -> Rendered {
    Renderer::new(threads).render(scene, &camera(), options).unwrap()
}

/// A picture has the bits that it has with a copy of the mesh for each place, whatever the threads and tiles.
#[test]
fn pictures_do_not_depend_on_which_meshes_are_kept_once() {
    let [copies, shared] = [false, true].map(|is_shared| {
        let mut scene = balls(is_shared);
        scene.add_light(Light::point([2.0, 4.0, 1.0], 20.0)).unwrap();
        scene
    });
    let expected = draw(&copies, &options(), 2);
    for (threads, tile) in [(1, None), (3, Some(16)), (2, Some(64))] {
        let found = draw(&shared, &options().with_tile_size(tile), threads);
        assert!(found.frame == expected.frame, "{threads} {tile:?}");
    }
    let without = options().with_visibility(Visibility::new(16, 64, 0));
    assert!(draw(&shared, &without, 2).frame == draw(&copies, &without, 2).frame);
    assert!(draw(&shared, &without, 2).frame != expected.frame);
}

/// Meshes that are kept once fit where their copies do not.
#[test]
fn meshes_at_several_places_take_little_memory() {
    let least = |scene: &Scene, options: &RenderOptions| {
        let (mut little, mut enough) = (0_u64, 1 << 26);
        while enough - little > 1 << 14 {
            let middle = u64::midpoint(little, enough);
            let options = options.clone().with_limits(Limits::default().with_frame_bytes(middle));
            match Renderer::new(2).render(scene, &camera(), &options) {
                Ok(Rendered { stats, .. }) if stats.reduced_light.is_none() => enough = middle,
                _ => little = middle,
            }
        }
        enough
    };
    let [copies, shared] = [false, true].map(|is_shared| least(&balls(is_shared), &options()));
    assert!(2 * shared < copies, "{shared} {copies}");
}

/// Rays become fewer where they would pass the limit of shading, the same whatever the threads and tiles and whatever was drawn
/// before, and as if so many had been asked for.
#[test]
fn rays_are_as_many_as_fit() {
    let scene = balls(true);
    let options = options().with_visibility(Visibility::new(16, 64, 64));
    let mut seen = Vec::new();
    let mut kept = Renderer::new(2);
    for shading in [1 << 13, 100, 60, 30, 15] {
        let limits = Limits::default().with_shading(shading);
        let options = options.clone().with_limits(limits.clone());
        let Rendered { frame, stats, .. } = draw(&scene, &options, 2);
        for (threads, tile) in [(1, Some(16)), (3, Some(64))] {
            let other = draw(&scene, &options.clone().with_tile_size(tile), threads);
            assert!(other.frame == frame && other.stats.reduced_light == stats.reduced_light, "{shading}");
        }
        for _ in 0..2 {
            let again = kept.render(&scene, &camera(), &options).unwrap();
            assert!(again.frame == frame && again.stats.reduced_light == stats.reduced_light, "{shading}");
        }
        let Some(light) = stats.reduced_light else {
            seen.push(64);
            continue;
        };
        assert_eq!((light.limit.field, light.limit.limit), ("shading", shading));
        seen.push(light.visibility.rays);
        let less = options.with_visibility(light.visibility).with_limits(Limits::default());
        let expected = draw(&scene, &less, 2);
        assert!(expected.frame == frame && expected.stats.reduced_light.is_none(), "{shading}");
    }
    assert!(seen[0] == 64 && seen.windows(2).all(|pair| pair[0] >= pair[1]), "{seen:?}");
    assert!(seen.iter().any(|rays| (1..64).contains(rays)), "{seen:?}");
}

/// The faintest of too many lights throw no shadow, and the picture has the others.
#[test]
fn many_lights_lose_their_faintest_shadows() {
    let mut scene = balls(true);
    for k in 0..40 {
        let position = [0.1 * k as f32, 3.0, 2.0];
        let light = Light::new(LightKind::Point { position, range: None })
            .with(|l| l.intensity = 0.1 + 0.01 * k as f32);
        scene.add_light(light).unwrap();
    }
    let options = options().with_visibility(Visibility::new(4, 32, 0));
    let all = draw(&scene, &options, 2).stats;
    assert_eq!((all.lights_without_shadow, all.reduced_light), (0, None));
    // Enough for the maps of the environment.
    let few = options.with_limits(Limits::default().with_blocks(100_000));
    let [one, other] = [1, 3].map(|threads| draw(&scene, &few, threads));
    assert!(one.frame == other.frame);
    let left_out = one.stats.lights_without_shadow;
    assert!((1..40).contains(&left_out), "{left_out} {:?}", one.stats.reduced_light);
}
