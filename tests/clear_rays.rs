//! Rays past glass and blended surfaces: mirrors show what a look straight at the same things would.

use overcoat::frame::{DisplayOptions, PixelFormat, Target};
use overcoat::render::{Quality, RenderOptions, Renderer, Visibility};
use overcoat::scene::{
    AlphaMode, Camera, Environment, EnvironmentSource, EquirectImage, Instance, Material, Mesh, Scene,
    ShadingModel, Transform, Workflow, primitives,
};
use overcoat_core::math::lanes::SimdLevel;
use std::sync::Arc;

const SIZE: u32 = 64;

fn under(radiance: f32) -> Scene {
    let mut scene = Scene::new();
    let sky = EquirectImage::new(8, 4, vec![[radiance; 3]; 32]).unwrap();
    let source = EnvironmentSource::Image(Arc::new(sky));
    scene.set_environment(Environment::default().with(|e| e.source = source)).unwrap();
    scene
}

fn of_roughness(metallic: f32, roughness: f32) -> Material {
    Material::default().with(|m| {
        m.base_color = [1.0; 4];
        m.workflow = Workflow::MetallicRoughness { metallic, roughness, texture: None };
    })
}

/// Thin glass of a colour that reflects nothing.
fn pane(color: [f32; 3]) -> Material {
    let mut glass = of_roughness(0.0, 0.0).with(|m| {
        m.base_color = [color[0], color[1], color[2], 1.0];
        (m.ior, m.specular, m.double_sided) = (1.0, 0.0, true);
    });
    glass.lobes.transmission.factor.factor = 1.0;
    glass
}

/// A surface that shows its colour in any light.
fn veil(alpha: f32) -> Material {
    Material::default().with(|m| {
        m.base_color = [1.0, 0.25, 0.0, alpha];
        (m.alpha_mode, m.unlit, m.double_sided) = (AlphaMode::Blend, true, true);
    })
}

fn put(scene: &mut Scene, mesh: Mesh, material: Material, place: [f64; 3]) {
    let mesh = scene.add_mesh(mesh).unwrap();
    let material = scene.add_material(material).unwrap();
    let transform = Transform::translation(place).unwrap();
    scene.add_instance(Instance::new(mesh, material, transform)).unwrap();
}

/// A floor of metal under a sky. Panes lie to its right, at these heights: a look from the left meets none before the floor and
/// all of them behind, at 45 degrees.
fn floor_and_panes(sky: f32, floor: Material, panes: &[(Material, f64)]) -> Scene {
    let mut scene = under(sky);
    put(&mut scene, primitives::plane([8.0, 8.0]).unwrap(), floor, [0.0; 3]);
    for (material, height) in panes {
        put(&mut scene, primitives::plane([8.0, 8.0]).unwrap(), material.clone(), [4.2, *height, 0.0]);
    }
    scene
}

fn options(visibility: Visibility) -> RenderOptions {
    RenderOptions::draft(SIZE, SIZE)
        .with_samples(1)
        .with_shading(ShadingModel::Three)
        .with_visibility(visibility)
}

/// Mean of the middle of a picture from the left.
fn reflected(scene: &Scene, visibility: Visibility) -> [f32; 3] {
    let camera = Camera::look_at([-3.0, 3.0, 0.0], [0.0; 3], [0.0, 1.0, 0.0]).unwrap();
    let pixels = Renderer::new(2).render(scene, &camera, &options(visibility)).unwrap().frame.pixels;
    let middle = (0..64).map(|k| pixels[((SIZE / 2 - 4 + k / 8) * SIZE + SIZE / 2 - 4 + k % 8) as usize]);
    middle.fold([0.0; 3], |sum, pixel| std::array::from_fn(|k| sum[k] + pixel[k] / 64.0))
}

fn tiers() -> [Visibility; 2] {
    [Quality::Good, Quality::Best].map(Quality::visibility)
}

#[track_caller]
fn assert_near(found: [f32; 3], expected: [f32; 3], tolerance: f32) {
    let near = found.iter().zip(expected).all(|(a, b)| (a - b).abs() <= tolerance);
    assert!(near, "{found:?} for {expected:?}");
}

#[test]
fn each_pane_tints_and_only_so_many_are_followed() {
    let color = [0.5_f32, 0.7, 0.95];
    for visibility in tiers() {
        for count in [0, 1, 2, 3, 8, 11] {
            let panes: Vec<_> = (0..count).map(|k| (pane(color), 1.0 + 0.05 * f64::from(k))).collect();
            let scene = floor_and_panes(1.0, of_roughness(1.0, 0.0), &panes);
            assert_near(
                reflected(&scene, visibility),
                color.map(|c| (0..count.min(8)).fold(1.0, |product, _| product * c)),
                0.01,
            );
        }
    }
}

/// A veil's cover by its alpha and its passed light add up, before the sky and before a wall.
#[test]
fn mirrors_show_blended_surfaces_before_what_is_behind_them() {
    let wall = || Material::default().with(|m| (m.unlit, m.base_color) = (true, [0.1, 0.2, 0.8, 1.0]));
    for visibility in tiers() {
        for alpha in [0.25_f32, 0.5, 1.0] {
            let over = |behind: [f32; 3]| -> [f32; 3] {
                let own = [1.0, 0.25, 0.0];
                std::array::from_fn(|k| alpha * own[k] + (1.0 - alpha) * behind[k])
            };
            let mut scene = floor_and_panes(0.5, of_roughness(1.0, 0.0), &[(veil(alpha), 1.0)]);
            assert_near(reflected(&scene, visibility), over([0.5; 3]), 0.01);
            put(&mut scene, primitives::cuboid([0.2, 9.0, 8.0]).unwrap(), wall(), [4.0, 4.5, 0.0]);
            assert_near(reflected(&scene, visibility), over([0.1, 0.2, 0.8]), 0.01);
            // A second one before it.
            put(&mut scene, primitives::plane([8.0, 8.0]).unwrap(), veil(0.5), [4.2, 0.8, 0.0]);
            let behind = over([0.1, 0.2, 0.8]);
            let both = std::array::from_fn(|k| 0.5 * [1.0, 0.25, 0.0][k] + 0.5 * behind[k]);
            assert_near(reflected(&scene, visibility), both, 0.01);
        }
    }
}

/// Glass in a white furnace: what it reflects of the furnace is what it does not let through. Rough metal leaves the reflections
/// in glass out: it is never brighter, and darker by no more than these.
#[test]
fn a_furnace_behind_clear_glass_stays_white() {
    let mut clear = pane([1.0; 3]);
    (clear.ior, clear.specular) = (1.5, 1.0);
    for visibility in tiers() {
        for (roughness, least) in [(0.0, 0.98), (0.2, 0.97), (0.6, 0.85)] {
            let floor = of_roughness(1.0, roughness);
            let open = reflected(&floor_and_panes(1.0, floor.clone(), &[]), visibility)[0];
            let found = reflected(&floor_and_panes(1.0, floor, &[(clear.clone(), 1.0)]), visibility)[0];
            assert!(found / open > least, "{visibility:?} {roughness}: {found} for {open}");
            assert!(found / open < 1.01, "{visibility:?} {roughness}: {found} for {open}");
        }
    }
}

/// A body absorbs along the way through it, by Beer's law; behind thin glass with the same numbers there is no way.
#[test]
fn thick_glass_absorbs_along_the_way_through_it() {
    let color = [0.3_f32, 0.6, 0.9];
    // The color to the power of the way, which is the thickness times the square root of 2.
    for (thickness, expected) in
        [(0.0, [1.0; 3]), (0.5, [0.4268, 0.6968, 0.9282]), (1.0, [0.1822, 0.4856, 0.8616])]
    {
        let mut amber = pane([1.0; 3]);
        amber.double_sided = false;
        amber.lobes.transmission.thickness.factor = thickness;
        amber.lobes.transmission.attenuation_distance = 1.0;
        amber.lobes.transmission.attenuation_color = color;
        let mut scene = under(1.0);
        put(&mut scene, primitives::plane([8.0, 8.0]).unwrap(), of_roughness(1.0, 0.0), [0.0; 3]);
        let height = if thickness > 0.0 { thickness } else { 0.5 };
        let slab = primitives::cuboid([8.0, height, 8.0]).unwrap();
        put(&mut scene, slab, amber, [4.2, 1.0 + 0.5 * f64::from(height), 0.0]);
        // Something that is in the way of light elsewhere: rays are sent where light may be blocked.
        put(&mut scene, primitives::cuboid([0.2; 3]).unwrap(), of_roughness(1.0, 1.0), [0.0, 0.5, 1.5]);
        for visibility in tiers() {
            assert_near(reflected(&scene, visibility), expected, 0.03);
        }
    }
}

/// Rays that start within glass leave it without reflection on its inner sides, and are numbers.
#[test]
fn rays_that_start_within_glass_leave_it() {
    let mut scene = under(1.0);
    put(&mut scene, primitives::plane([4.0, 4.0]).unwrap(), of_roughness(1.0, 0.0), [0.0; 3]);
    let mut body = pane([0.5, 0.7, 0.9]);
    body.double_sided = false;
    body.lobes.transmission.thickness.factor = 1.0;
    // The eye is in it as well, so that it is not drawn before the floor.
    put(&mut scene, primitives::cuboid([12.0; 3]).unwrap(), body, [0.0; 3]);
    put(&mut scene, primitives::cuboid([0.2; 3]).unwrap(), of_roughness(1.0, 1.0), [0.0, 0.5, 1.5]);
    for visibility in tiers() {
        assert_near(reflected(&scene, visibility), [1.0; 3], 0.02);
    }
}

/// Rough and smooth spheres, glass, a veil.
fn glassware() -> Scene {
    let mut scene = under(1.0);
    for (k, roughness) in [0.05, 0.3, 0.6, 1.0].into_iter().enumerate() {
        let metal = of_roughness(1.0, roughness);
        put(&mut scene, primitives::sphere(0.4, 24).unwrap(), metal, [k as f64 * 0.9 - 1.35, 0.4, 0.0]);
    }
    let mut body = pane([0.9, 0.6, 0.3]).with(|m| (m.ior, m.specular) = (1.5, 1.0));
    body.double_sided = false;
    body.lobes.transmission.thickness.factor = 0.4;
    body.lobes.transmission.attenuation_distance = 0.5;
    body.lobes.transmission.attenuation_color = [0.9, 0.7, 0.2];
    put(&mut scene, primitives::sphere(0.4, 24).unwrap(), body, [-0.9, 0.4, 0.8]);
    put(&mut scene, primitives::plane([1.0, 1.0]).unwrap(), veil(0.4), [0.6, 1.0, 0.2]);
    put(&mut scene, primitives::plane([5.0, 5.0]).unwrap(), of_roughness(0.0, 0.8), [0.0; 3]);
    scene
}

/// Blocks of two by two pixels are cut by the borders of pictures of odd sizes and of their parts, but not in two: threads, tiles,
/// instruction sets and parts of pictures leave no trace.
#[test]
fn bits_are_the_same_everywhere() {
    let (scene, [width, height]) = (glassware(), [61, 43]);
    let camera = Camera::look_at([0.5, 1.6, 3.0], [0.0, 0.3, 0.0], [0.0, 1.0, 0.0]).unwrap();
    for rays in [3, 16] {
        let visibility = Visibility::new(16, 32, rays);
        let options = RenderOptions::draft(width, height).with_samples(4).with_visibility(visibility);
        let pixels = |threads, options: &RenderOptions| {
            Renderer::new(threads).render(&scene, &camera, options).unwrap().frame
        };
        let whole = pixels(1, &options);
        for (threads, side) in [(1, 16), (2, 32), (3, 64)] {
            let found = pixels(threads, &options.clone().with_tile_size(Some(side)));
            assert_eq!(found.frame_hash(), whole.frame_hash(), "{rays} rays, tiles of {side}");
        }
        for level in SimdLevel::available() {
            let found = pixels(2, &options.clone().with_simd(level));
            assert_eq!(found.frame_hash(), whole.frame_hash(), "{rays} rays, {level}");
        }
        for [left, top, w, h] in [[17, 13, 7, 9], [31, 0, 1, 43], [0, 15, 61, 2]] {
            let stride = w as usize * 16;
            let mut bytes = vec![0; stride * h as usize];
            let mut target = Target::new(&mut bytes, stride, PixelFormat::RgbaF32Premultiplied)
                .with_region(left, top, w, h);
            let display = DisplayOptions::default();
            Renderer::new(2).render_into(&scene, &camera, &options, &display, &mut target).unwrap();
            for (number, found) in bytes.chunks(16).enumerate() {
                let [x, y] = [left + number as u32 % w, top + number as u32 / w];
                let expected = whole.pixels[(y * width + x) as usize].map(f32::to_ne_bytes);
                assert_eq!(found, expected.as_flattened(), "{rays} rays: {x} {y} of {left} {top}");
            }
        }
    }
}

/// With 31 rays those of wide lobes are sent once for four pixels, with 32 for each: a smooth floor beside a wall looks the same.
#[test]
fn a_smooth_surface_looks_as_if_every_pixel_sent_its_rays() {
    for floor in [of_roughness(0.0, 1.0), of_roughness(1.0, 0.5), of_roughness(1.0, 0.9)] {
        let mut scene = under(1.0);
        put(&mut scene, primitives::plane([4.0, 4.0]).unwrap(), floor, [0.0; 3]);
        let wall = of_roughness(0.0, 1.0).with(|m| m.base_color = [0.7, 0.1, 0.1, 1.0]);
        put(&mut scene, primitives::cuboid([0.2, 2.0, 4.0]).unwrap(), wall, [0.9, 1.0, 0.0]);
        let camera = Camera::look_at([-1.5, 1.5, 0.0], [0.2, 0.0, 0.0], [0.0, 1.0, 0.0]).unwrap();
        let [shared, own] = [31, 32].map(|rays| {
            let options = options(Visibility::new(64, 128, rays));
            Renderer::new(2).render(&scene, &camera, &options).unwrap().frame.pixels
        });
        let (mut sums, mut worst) = ([0.0_f32; 2], 0.0_f32);
        // Within the floor, away from its edges and the wall.
        for number in
            (0..SIZE * SIZE).filter(|k| (24..56).contains(&(k / SIZE)) && (16..48).contains(&(k % SIZE)))
        {
            let [a, b] = [&shared, &own].map(|pixels| pixels[number as usize][1]);
            sums = [sums[0] + a, sums[1] + b];
            worst = worst.max((a - b).abs());
        }
        assert!((sums[0] / sums[1] - 1.0).abs() < 0.02, "{sums:?}");
        assert!(worst < 0.05, "{worst}");
    }
}
