//! Shadows of lamps: where they begin and end, how soft they are, and that their bits are the same everywhere.

use overcoat::render::{Quality, RenderOptions, Renderer, Visibility};
use overcoat::scene::{
    Camera, Environment, EnvironmentSource, Instance, Light, LightKind, Material, Mesh, Projection, Scene,
    ShadingModel, Transform, Workflow, primitives,
};
use overcoat_core::math::lanes::SimdLevel;

const SIZE: u32 = 128;

fn matte() -> Material {
    Material::default().with(|m| {
        m.base_color = [0.8, 0.8, 0.8, 1.0];
        m.workflow = Workflow::MetallicRoughness { metallic: 0.0, roughness: 1.0, texture: None };
        m.specular = 0.0;
        m.double_sided = true;
    })
}

/// A dark scene with a lamp.
fn lit_by(light: Light) -> Scene {
    let mut scene = Scene::new();
    scene.set_environment(Environment::default().with(|e| e.source = EnvironmentSource::None)).unwrap();
    scene.add_light(light).unwrap();
    scene
}

fn put(scene: &mut Scene, mesh: Mesh, place: [f64; 3]) {
    let mesh = scene.add_mesh(mesh).unwrap();
    let material = scene.add_material(matte()).unwrap();
    let transform = Transform::translation(place).unwrap();
    scene.add_instance(Instance::new(mesh, material, transform)).unwrap();
}

fn floor(scene: &mut Scene) {
    put(scene, primitives::plane([4.0, 4.0]).unwrap(), [0.0; 3]);
}

/// From above: x runs to the right and z down, from -2 to 2.
fn above() -> Camera {
    Camera::new([0.0, 50.0, 0.0], [0.0; 3], [0.0, 0.0, -1.0], Projection::Orthographic { height: 4.0 }, 0.01)
}

fn options(visibility: Visibility) -> RenderOptions {
    RenderOptions::draft(SIZE, SIZE)
        .with_samples(1)
        .with_shading(ShadingModel::Three)
        .with_visibility(visibility)
}

fn draw(scene: &Scene, camera: &Camera, visibility: Visibility) -> Vec<[f32; 4]> {
    Renderer::new(2).render(scene, camera, &options(visibility)).unwrap().frame.pixels
}

fn tiers() -> impl Iterator<Item = Visibility> {
    // Without rays: what they bring is no shadow.
    Quality::ALL.iter().map(|quality| quality.visibility().with_rays(0)).filter(Visibility::is_on)
}

fn sun(direction: [f32; 3]) -> Light {
    Light::directional(direction, 3.0)
}

fn spot(position: [f32; 3], outer_cone_cosine: f32) -> Light {
    let direction = position.map(|c| -c);
    let (range, inner_cone_cosine) = (None, 0.5 + 0.5 * outer_cone_cosine);
    let kind = LightKind::Spot { position, direction, range, inner_cone_cosine, outer_cone_cosine };
    Light::new(kind).with(|l| l.intensity = 30.0)
}

/// A square over the floor that shines down.
fn square(height: f32, half: f32) -> Light {
    let (half_width, half_height) = ([half, 0.0, 0.0], [0.0, 0.0, half]);
    let position = [0.0, height, 0.0];
    Light::new(LightKind::Rect { position, half_width, half_height, two_sided: true })
        .with(|l| l.intensity = 5.0)
}

fn tube(height: f32, half: f32) -> Light {
    let ends = [[-half, height, 0.0], [half, height, 0.0]];
    Light::new(LightKind::Tube { ends, radius: 0.02 }).with(|l| l.intensity = 50.0)
}

fn every_lamp() -> [Light; 7] {
    [
        sun([-0.3, -1.0, 0.2]),
        sun([-1.0, -0.05, 0.3]),
        Light::point([0.5, 1.5, -0.4], 10.0),
        Light::point([0.5, 30.0, -0.4], 4000.0),
        spot([1.0, 3.0, 0.5], 0.9),
        square(2.0, 0.5),
        tube(1.5, 1.0),
    ]
}

#[test]
fn where_nothing_is_in_the_way_no_bit_changes() {
    for light in every_lamp() {
        let mut scene = lit_by(light);
        floor(&mut scene);
        let open = draw(&scene, &above(), Visibility::NONE);
        for visibility in tiers() {
            let seen = draw(&scene, &above(), visibility);
            let other = seen.iter().zip(&open).filter(|(seen, open)| seen != open).count();
            assert_eq!(other, 0, "{visibility:?} {:?}", light.kind);
        }
    }
}

/// A smooth ball of few faces has no dark ones where its shading is lit.
#[test]
fn smooth_surfaces_do_not_shade_themselves() {
    for light in [sun([-1.0, -0.4, -0.3]), Light::point([1.5, 1.0, 1.0], 10.0), square(2.5, 0.4)] {
        for faces in [12, 24, 96] {
            let mut scene = lit_by(light);
            put(&mut scene, primitives::sphere(1.0, faces).unwrap(), [0.0; 3]);
            let camera = Camera::look_at([2.0, 2.0, 2.5], [0.0; 3], [0.0, 1.0, 0.0]).unwrap();
            let open = draw(&scene, &camera, Visibility::NONE);
            for visibility in tiers() {
                let seen = draw(&scene, &camera, visibility);
                let brightest = open.iter().fold(0.0, |m: f32, p| if p[0] > m { p[0] } else { m });
                // At the terminator there is little to lose; at the outline normals are bent towards the viewer.
                let dark = seen.iter().zip(&open).filter(|(seen, open)| open[0] - seen[0] > brightest * 0.08);
                let dark = dark.count();
                assert!(dark <= 16, "{visibility:?} {:?} {faces}: {dark} pixels", light.kind);
            }
        }
    }
}

/// The floor's light, past what is in its way: at a place, 0 to 1.
fn arriving(scene: &Scene, visibility: Visibility) -> impl Fn(f32, f32) -> f32 {
    let open = draw(scene, &above(), Visibility::NONE);
    let seen = draw(scene, &above(), visibility);
    move |x: f32, z: f32| {
        let pixel = |v: f32| (((v + 2.0) / 4.0 * SIZE as f32) as usize).min(SIZE as usize - 1);
        let index = pixel(z) * SIZE as usize + pixel(x);
        seen[index][0] / open[index][0]
    }
}

/// The shadow of a slab over the floor is where geometry has it, as large as geometry has it.
#[test]
fn shadows_are_where_geometry_has_them() {
    // Shadow of a square of side 1 at a height of 1: its left and right end on the floor.
    for (light, left, right) in [
        (sun([0.0, -1.0, 0.0]), -0.5, 0.5),
        (sun([0.5, -1.0, 0.0]), 0.0, 1.0),
        (Light::point([0.0, 2.5, 0.0], 10.0), -0.833, 0.833),
        (Light::point([0.0, 25.0, 0.0], 1000.0), -0.521, 0.521),
        (spot([0.0, 2.5, 0.0], 0.6), -0.833, 0.833),
        (Light::point([0.5, 2.5, 0.0], 10.0), -1.167, 0.5),
    ] {
        let mut scene = lit_by(light);
        floor(&mut scene);
        put(&mut scene, primitives::cuboid([1.0, 0.02, 1.0]).unwrap(), [0.0, 1.0, 0.0]);
        for visibility in tiers() {
            let light_at = arriving(&scene, visibility);
            // The slab itself is seen over its own part of the floor.
            let hidden = |x: f32| x.abs() < 0.52;
            for k in 0..64 {
                let x = (k as f32 + 0.5) / 16.0 - 2.0;
                let z = 0.3;
                if hidden(x) {
                    continue;
                }
                let edge = (x - left).abs().min((x - right).abs());
                let expected = if x > left && x < right { 0.0 } else { 1.0 };
                if edge > 0.06 {
                    let found = light_at(x, z);
                    assert!(
                        (found - expected).abs() < 0.02,
                        "{visibility:?} {:?} at {x}: {found} for {expected}",
                        light.kind
                    );
                }
            }
        }
    }
}

/// The shadow of a long slab under a square lamp goes from dark to light over the width that geometry has.
#[test]
fn shadows_of_large_lamps_are_soft() {
    let half = 0.4;
    let mut scene = lit_by(square(2.0, half));
    floor(&mut scene);
    // Over half of the floor, half as high as the lamp.
    put(&mut scene, primitives::cuboid([2.0, 0.02, 4.0]).unwrap(), [-1.0, 1.0, 0.0]);
    for visibility in tiers() {
        let light_at = arriving(&scene, visibility);
        // A place sees the part of the lamp right of twice the edge less its own: a share of its width.
        for k in 1..12 {
            let x = k as f32 * 0.05;
            let expected = ((half + x) / (2.0 * half)).clamp(0.0, 1.0);
            let found = light_at(x, 0.1);
            assert!((found - expected).abs() < 0.13, "{visibility:?} at {x}: {found} for {expected}");
        }
    }
}

/// Nothing of a lamp in a closed box is seen outside, and its inside is as light as without shadows.
#[test]
fn a_lamp_in_a_box_stays_in_the_box() {
    for light in [Light::point([0.0, 0.4, 0.0], 2.0), tube(0.4, 0.2)] {
        let mut scene = lit_by(light);
        floor(&mut scene);
        put(&mut scene, primitives::cuboid([1.0, 1.0, 1.0]).unwrap(), [0.0, 0.45, 0.0]);
        for visibility in tiers() {
            let light_at = arriving(&scene, visibility);
            for (x, z) in [(0.56, 0.0), (0.7, 0.1), (1.5, 1.0), (-0.8, -0.8), (0.0, 1.0)] {
                assert_eq!(light_at(x, z), 0.0, "{visibility:?} {:?} at {x} {z}", light.kind);
            }
        }
    }
}

/// Light falls through the holes of alpha masks: here half of a checkered one.
#[test]
fn masks_let_light_through_where_they_are_cut_out() {
    use overcoat::scene::{
        AlphaMode, AlphaUse, ColorSpace, Image, Sampler, Texture, TextureRef, UvTransform,
    };
    for light in
        [sun([0.0, -1.0, 0.0]), Light::point([0.0, 30.0, 0.0], 4000.0), Light::point([0.0, 1.3, 0.0], 9.0)]
    {
        let mut scene = lit_by(light);
        floor(&mut scene);
        let texels = (0..4).map(|k| [255, 255, 255, if (k + k / 2) % 2 == 0 { 255 } else { 0 }]).collect();
        let image = std::sync::Arc::new(Image::new(2, 2, texels).unwrap());
        let texture = Texture::new(image, ColorSpace::Srgb, AlphaUse::mask(0.5), Sampler::default());
        let texture = scene.add_texture(texture).unwrap();
        let material = matte().with(|m| {
            m.alpha_mode = AlphaMode::Mask { cutoff: 0.5 };
            m.base_color_texture = Some(TextureRef { texture, uv_set: 0, transform: UvTransform::IDENTITY });
        });
        let material = scene.add_material(material).unwrap();
        let mesh = scene.add_mesh(primitives::plane([2.0, 2.0]).unwrap()).unwrap();
        let transform = Transform::translation([0.0, 0.65, 0.0]).unwrap();
        scene.add_instance(Instance::new(mesh, material, transform)).unwrap();
        for visibility in tiers() {
            let open = draw(&scene, &above(), Visibility::NONE);
            let seen = draw(&scene, &above(), visibility);
            let lit = |x: f32, z: f32| {
                let pixel = |v: f32| ((v + 2.0) / 4.0 * SIZE as f32) as usize;
                let index = pixel(z) * SIZE as usize + pixel(x);
                seen[index][0] / open[index][0]
            };
            // Under the holes of the plane the floor is seen, and the same light that falls on it.
            let corners = [(0.4, 0.4), (-0.4, 0.4), (0.4, -0.4), (-0.4, -0.4)].map(|(x, z)| lit(x, z));
            assert!(corners.iter().all(|lit| *lit > 0.98), "{visibility:?} {:?}: {corners:?}", light.kind);
        }
    }
}

fn crowd() -> (Scene, Camera) {
    let mut scene = lit_by(sun([-0.5, -1.0, -0.4]));
    for light in every_lamp() {
        scene.add_light(light.with(|l| l.intensity = light.intensity * 0.2)).unwrap();
    }
    floor(&mut scene);
    for (k, x) in [-0.8, 0.0, 0.8].into_iter().enumerate() {
        put(&mut scene, primitives::sphere(0.4, 24).unwrap(), [x, 0.4 + 0.2 * k as f64, 0.2]);
    }
    put(&mut scene, primitives::torus_knot([2, 3], 0.5, 0.15, [48, 8]).unwrap(), [0.0, 1.1, -0.3]);
    (scene, Camera::look_at([1.5, 2.0, 3.0], [0.0, 0.3, 0.0], [0.0, 1.0, 0.0]).unwrap())
}

#[test]
fn threads_tiles_and_instruction_sets_do_not_show() {
    let (scene, camera) = crowd();
    for visibility in [Visibility::new(16, 128, 0), Visibility::new(16, 64, 2)] {
        let options = options(visibility).with_samples(4);
        let hash = |threads, options: &RenderOptions| {
            Renderer::new(threads).render(&scene, &camera, options).unwrap().frame.frame_hash()
        };
        let expected = hash(1, &options);
        for level in SimdLevel::available() {
            assert_eq!(hash(2, &options.clone().with_simd(level)), expected, "{visibility:?} {level}");
        }
        for side in [16, 32] {
            assert_eq!(hash(3, &options.clone().with_tile_size(Some(side))), expected, "tiles of {side}");
        }
    }
}

/// Neither the view before, nor the lamps before show.
#[test]
fn a_view_is_the_same_alone_and_after_others() {
    let (scene, camera) = crowd();
    let mut moved = crowd().0;
    moved.add_light(Light::point([0.0, 3.0, 1.0], 2.0)).unwrap();
    let visibility = Visibility::new(16, 64, 0);
    let mut kept = Renderer::new(2);
    let mut hash = |scene: &Scene, camera: &Camera, visibility| {
        kept.render(scene, camera, &options(visibility)).unwrap().frame.frame_hash()
    };
    let alone = hash(&scene, &camera, visibility);
    for (scene, camera, visibility) in [
        (&scene, &above(), visibility),
        (&moved, &camera, visibility),
        (&scene, &camera, Visibility::new(16, 32, 0)),
        (&scene, &camera, Visibility::NONE),
    ] {
        let between = hash(scene, camera, visibility);
        assert_ne!(between, alone);
        let again = hash(&crowd().0, &crowd().1, Visibility::new(16, 64, 0));
        assert_eq!(again, alone);
    }
}

#[test]
fn lamps_anywhere_have_a_picture() {
    for place in [[0.0; 3], [1e-20, 0.0, 0.0], [1e9, 1e9, 1e9], [0.0, 0.4, 0.4], [9e14, 0.0, 0.0]] {
        let mut scene = lit_by(Light::point(place, 1.0).with(|l| l.intensity = 1e9));
        scene.add_light(spot(if place == [0.0; 3] { [0.0, 1.0, 0.0] } else { place }, 0.99)).unwrap();
        scene.add_light(spot([0.0, 0.2, 0.0], -1.0)).unwrap();
        floor(&mut scene);
        put(&mut scene, primitives::sphere(0.4, 24).unwrap(), [0.0, 0.4, 0.0]);
        for visibility in tiers() {
            let pixels = draw(&scene, &above(), visibility);
            assert!(pixels.iter().flatten().all(|c| c.is_finite() && *c >= 0.0), "{visibility:?} {place:?}");
        }
    }
}

/// Many lamps among many triangles are work that limits count.
#[test]
fn maps_of_lamps_count_as_work() {
    let (mut scene, camera) = crowd();
    for k in 0..200 {
        scene.add_light(Light::point([k as f32 * 0.01 - 1.0, 0.5, 0.5], 0.1)).unwrap();
    }
    let options = options(Visibility::new(4, 32, 0));
    let limits = options.limits.clone();
    Renderer::new(2).render(&scene, &camera, &options).unwrap();
    let few = options.clone().with_limits(limits.clone().with_blocks(10_000));
    let stats = Renderer::new(2).render(&scene, &camera, &few).unwrap().stats;
    let light = stats.reduced_light.unwrap().to_string();
    assert_eq!(
        light,
        "depth maps of lamps: more than the limit of 10000 (blocks): drawn without shadows and floor"
    );
    let small = options.with_limits(limits.with_frame_bytes(400_000));
    match Renderer::new(2).render(&scene, &camera, &small) {
        Ok(rendered) => assert_eq!(rendered.stats.reduced_light.unwrap().limit.field, "frame_bytes"),
        Err(error) => assert!(error.to_string().contains("frame_bytes"), "{error}"),
    }
}
