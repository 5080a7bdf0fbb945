//! Pictures like earlier ones take no new memory.
//!
//! Heap allocations of all threads are counted, so this file has one test: another one beside it would be counted too.

#[path = "common/shapes.rs"]
#[allow(dead_code, reason = "other tests use the rest")]
mod shapes;

use overcoat::frame::{DisplayOptions, PixelFormat, Target};
use overcoat::render::{Background, Quality, RenderOptions, Renderer, Visibility};
use overcoat::scene::{
    AlphaMode, AlphaUse, Camera, ColorSpace, Environment, EnvironmentSource, EquirectImage, Image, Instance,
    Light, LightKind, Material, Mesh, NormalTexture, Projection, Sampler, Scene, ShadingModel, Texture,
    TextureRef, Transform, UvTransform, Workflow,
};
use stats_alloc::{INSTRUMENTED_SYSTEM, Region, Stats, StatsAlloc};
use std::alloc::System;
use std::sync::Arc;

#[global_allocator]
static COUNTED: &StatsAlloc<System> = &INSTRUMENTED_SYSTEM;

/// Places in a block of the queue through which the pool of threads takes work, one for each picture.
const PLACES: usize = 63;
/// No block is larger: the next block's address and, for each place, a pointer, a function and a state.
const BLOCK_BYTES: usize = 8 + PLACES * 24;

/// Everything at once: meshes of several materials and models, opaque, masked, blended and clipped; textures, lights of
/// every kind, an environment from a picture.
fn scene() -> Scene {
    let mut scene = Scene::new();
    let texels = |f: fn(u32, u32) -> [u8; 4]| (0..64 * 64).map(|k| f(k % 64, k / 64)).collect();
    let texture = |scene: &mut Scene, space, texels: Vec<[u8; 4]>| {
        let image = Arc::new(Image::new(64, 64, texels).unwrap());
        let id = scene.add_texture(Texture::new(image, space, AlphaUse::Data, Sampler::default())).unwrap();
        TextureRef { texture: id, uv_set: 0, transform: UvTransform::IDENTITY }
    };
    let checks =
        texels(|x, y| if (x / 8 + y / 8) % 2 == 0 { [220, 40, 30, 255] } else { [240, 240, 240, 40] });
    let colors = texture(&mut scene, ColorSpace::Srgb, checks);
    let bumps = texels(|x, y| [(120 + x % 16) as u8, (120 + y % 16) as u8, 250, 255]);
    let bumps = NormalTexture { texture: texture(&mut scene, ColorSpace::Linear, bumps), scale: 1.0 };

    let rough = |roughness| Workflow::MetallicRoughness { metallic: 0.2, roughness, texture: None };
    let paint = Material::default().with(|m| {
        m.coat = 1.0;
        m.coat_roughness = 0.05;
        m.workflow = rough(0.5);
    });
    let materials = [
        paint.clone().with(|m| {
            m.base_color_texture = Some(colors);
            m.normal_texture = Some(bumps);
        }),
        paint.clone().with(|m| m.model = Some(ShadingModel::OpenPbr)),
        paint.clone().with(|m| m.model = Some(ShadingModel::Velvet)),
        paint.clone().with(|m| {
            m.alpha_mode = AlphaMode::Mask { cutoff: 0.5 };
            m.base_color_texture = Some(colors);
            m.double_sided = true;
        }),
        paint.with(|m| {
            m.alpha_mode = AlphaMode::Blend;
            m.base_color = [0.1, 0.3, 0.8, 0.4];
        }),
    ];
    let shapes = [shapes::torus(0.3, 40), shapes::sphere(40), shapes::cube(), shapes::square(4)];
    let meshes = shapes.map(|data| scene.add_mesh(Mesh::new(data).unwrap()).unwrap());
    for (number, material) in materials.into_iter().enumerate() {
        let material = scene.add_material(material).unwrap();
        for (k, mesh) in meshes.into_iter().enumerate() {
            let place = [k as f64 * 1.5 - 2.2, number as f64 * 0.9 - 1.8, number as f64 * 0.6 - 1.2];
            let transform = Transform::translation(place).unwrap();
            scene.add_instance(Instance::new(mesh, material, transform).with_object(number as u32)).unwrap();
        }
    }
    for kind in [
        LightKind::Directional { direction: [0.6, -0.64, -0.48] },
        LightKind::Point { position: [2.0, 3.0, 2.0], range: Some(20.0) },
        LightKind::Rect {
            position: [0.0, 4.0, 2.0],
            half_width: [1.0, 0.0, 0.0],
            half_height: [0.0, 0.0, 1.0],
            two_sided: true,
        },
        LightKind::Tube { ends: [[-2.0, 2.0, 3.0], [2.0, 2.0, 3.0]], radius: 0.05 },
    ] {
        scene.add_light(Light::new(kind).with(|l| l.intensity = 2.0)).unwrap();
    }
    let sky =
        (0..64 * 32).map(|k| [0.2 + (k % 64) as f32 / 64.0, 0.5, 0.3 + (k / 64) as f32 / 32.0]).collect();
    let source = EnvironmentSource::Image(Arc::new(EquirectImage::new(64, 32, sky).unwrap()));
    scene
        .set_environment(Environment::default().with(|e| {
            e.source = source;
            e.rotation_degrees = 30.0;
            e.intensity = 1.0;
        }))
        .unwrap();
    scene
}

/// Four places from which the scene is seen; the last is inside it, so that triangles are clipped.
fn cameras() -> [Camera; 4] {
    [[0.0, 1.0, 9.0], [7.0, 2.0, 5.0], [-5.0, 3.0, -6.0], [0.3, 0.2, 1.0]]
        .map(|eye| Camera::new(eye, [0.0; 3], [0.0, 1.0, 0.0], Projection::Perspective { fov_y: 0.7 }, 0.01))
}

/// Allocations of `frames` frames, after three turns through all cameras; of pictures for a screen if `display` is
/// given.
fn count(
    renderer: &mut Renderer,
    scene: &Scene,
    options: &RenderOptions,
    display: Option<&DisplayOptions>,
    frames: usize,
) -> Stats {
    let mut frame = |camera: &Camera| {
        let stats = match display {
            None => {
                let rendered = renderer.render(scene, camera, options).unwrap();
                renderer.recycle(rendered.frame);
                rendered.stats
            }
            Some(display) => {
                let rendered = renderer.render_image(scene, camera, options, display).unwrap();
                renderer.recycle_image(rendered.image);
                rendered.stats
            }
        };
        assert!(stats.fragments > 0);
    };
    let cameras = cameras();
    let first = Region::new(COUNTED);
    frame(&cameras[0]);
    assert!(first.change().bytes_allocated > 10_000, "the first frame makes its buffers");
    (0..3).flat_map(|_| &cameras).for_each(&mut frame);
    let region = Region::new(COUNTED);
    cameras.iter().cycle().take(frames).for_each(&mut frame);
    region.change()
}

/// Allocations of pictures of several sizes and regions drawn into one buffer, after each has been drawn before.
fn count_resized(renderer: &mut Renderer, scene: &Scene, frames: usize) -> Stats {
    let (cameras, display) = (cameras(), DisplayOptions::default());
    let sizes = [[160, 112], [80, 56], [33, 90], [160, 112], [16, 16]];
    let options = sizes.map(|[width, height]| RenderOptions::draft(width, height));
    let mut buffer = vec![0; 160 * 112 * 4];
    let mut frame = |number: usize| {
        let (options, camera) = (&options[number % 5], &cameras[number % 4]);
        let mut target = Target::new(&mut buffer, options.width as usize * 4, PixelFormat::Xrgb8);
        if number % 3 == 2 {
            target = target.with_region(5, 3, 9, 12);
        }
        renderer.render_into(scene, camera, options, &display, &mut target).unwrap();
    };
    (0..120).for_each(&mut frame);
    let region = Region::new(COUNTED);
    (0..frames).for_each(&mut frame);
    region.change()
}

#[test]
fn warm_frames_allocate_nothing() {
    let scene = scene();
    // Threads end some time after their renderer, and what they give back then would be counted for another one.
    let mut kept = Vec::new();
    for threads in [1, 2] {
        let display = DisplayOptions::default();
        // Few maps: a test of more than a minute is told of, which takes memory.
        let few = Visibility::new(16, Quality::Fast.visibility_of([80, 56]).map_size, 0);
        for (samples, rate, merge_angle, background, display, visibility) in [
            (1, 1, 0.0, Background::Transparent, None, Visibility::NONE),
            (8, 1, 0.0, Background::Environment, None, Visibility::NONE),
            (8, 1, 10.0, Background::Transparent, None, Visibility::NONE),
            (8, 4, 0.0, Background::Transparent, None, Visibility::NONE),
            (8, 1, 0.0, Background::Transparent, Some(&display), Visibility::NONE),
            (1, 1, 0.0, Background::Transparent, None, few),
            (4, 1, 0.0, Background::Environment, Some(&display), few),
        ] {
            // Several threads are counted over many frames, which would take long.
            if visibility.is_on() && threads > 1 {
                continue;
            }
            let options = RenderOptions::draft(80, 56)
                .with_visibility(visibility)
                .with_samples(samples)
                .with_shading_rate(rate)
                .with_merge_angle(merge_angle)
                .with_background(background);
            // One thread needs no queue. Several get each frame through one place of it, which nothing can avoid: the
            // pool has no other way in that takes borrowed work.
            let (frames, blocks) = if threads == 1 { (8, 0) } else { (PLACES, 1) };
            let mut renderer = Renderer::new(threads);
            let found = count(&mut renderer, &scene, &options, display, frames);
            kept.push(renderer);
            let what =
                format!("{threads} threads, {samples} samples, {visibility:?}, {frames} frames: {found:?}");
            assert!(found.allocations <= blocks && found.deallocations <= blocks, "{what}");
            assert!(found.bytes_allocated <= blocks * BLOCK_BYTES, "{what}");
            assert_eq!(found.reallocations, 0, "{what}");
        }
        let (frames, blocks) = if threads == 1 { (60, 0) } else { (PLACES, 1) };
        let mut renderer = Renderer::new(threads);
        let found = count_resized(&mut renderer, &scene, frames);
        kept.push(renderer);
        let what = format!("{threads} threads, {frames} frames of several sizes: {found:?}");
        assert!(found.allocations <= blocks && found.deallocations <= blocks, "{what}");
        assert_eq!(found.reallocations, 0, "{what}");
    }
}
