//! Pictures drawn into memory of the caller, in parts, and asked what is seen in a pixel: all of it agrees with the picture.

use crate::common::Shot;
use overcoat::description::Machine;
use overcoat::frame::{Aov, DisplayImage, Frame, Meter, PixelFormat, Target};
use overcoat::jobs::Jobs;
use overcoat::limits::Limits;
use overcoat::render::{Cancellation, Ground, Quality, RenderError, RenderOptions, Renderer};
use overcoat::scene::{
    AlphaMode, Camera, Environment, EnvironmentSource, EquirectImage, Instance, Light, LightKind, Material,
    MaterialId, PrimitiveKind, Scene, Transform, primitives,
};
use std::sync::Arc;

/// Scenes that take every way through the passes: blended, masked, refracting, tinting, floor, mirror, splats, points, lines,
/// a metered exposure, the environment behind.
const SCENES: &[&str] = &[
    "blend",
    "mask",
    "odd-sizes",
    "gltf-glass",
    "transmission-layers",
    "transmission-before-color",
    "ground-color",
    "ground-reflection",
    "splats-and-surfaces",
    "point-clouds",
    "points-and-lines",
    "environment-rotation-90",
    "background-color",
    "near-plane",
    "lamp-kinds",
    "default-sports-car",
];

fn shots() -> Vec<(String, Shot)> {
    let goldens = crate::common::goldens().unwrap();
    let jobs = Jobs::new(2);
    let of = |name: &&str| {
        let golden = goldens.iter().find(|golden| golden.name() == *name).expect(name);
        ((*name).to_owned(), Shot::load(golden, Machine::default(), &jobs).expect(name))
    };
    SCENES.iter().map(of).collect()
}

/// Bytes of a pixel by the definition of its format, from linear light and from 8-bit sRGB.
fn expected(format: PixelFormat, linear: [f32; 4], [r, g, b, a]: [u8; 4]) -> Vec<u8> {
    let times = |v: u8| ((u32::from(v) * u32::from(a) * 2 + 255) / 510) as u8;
    match format {
        PixelFormat::Rgba8 => vec![r, g, b, a],
        PixelFormat::Rgba8Premultiplied => vec![times(r), times(g), times(b), a],
        PixelFormat::Bgra8 => vec![b, g, r, a],
        PixelFormat::Bgra8Premultiplied => vec![times(b), times(g), times(r), a],
        PixelFormat::Xrgb8 => (u32::from(r) << 16 | u32::from(g) << 8 | u32::from(b)).to_ne_bytes().to_vec(),
        PixelFormat::RgbaF32Premultiplied => linear.iter().flat_map(|v| v.to_ne_bytes()).collect(),
        PixelFormat::RgbaF32 => {
            let a = linear[3];
            let straight = if a > 0.0 { linear.map(|v| v / a) } else { [0.0; 4] };
            [straight[0], straight[1], straight[2], if a > 0.0 { a } else { 0.0 }]
                .iter()
                .flat_map(|v| v.to_ne_bytes())
                .collect()
        }
        other => panic!("a format that this test does not know: {other:?}"),
    }
}

/// Some parts of a picture: one pixel, one tile, across tiles, a strip, all.
fn regions(width: u32, height: u32) -> Vec<[u32; 4]> {
    vec![
        [0, 0, width, height],
        [width / 2, height / 3, 1, 1],
        [width / 3, height / 4, width / 2, height / 2],
        [0, height - 1, width, 1],
        [width - 7, 3, 7, height - 3],
    ]
}

fn check(
    format: PixelFormat,
    region: [u32; 4],
    frame: &Frame,
    image: &DisplayImage,
    bytes: &[u8],
    stride: usize,
) {
    let [left, top, width, height] = region;
    for y in 0..height {
        let row = &bytes[y as usize * stride..];
        for x in 0..width {
            let place = (left + x, top + y);
            let (linear, shown) =
                (frame.pixel(place.0, place.1).unwrap(), image.pixel(place.0, place.1).unwrap());
            let own = &row[x as usize * format.bytes()..][..format.bytes()];
            // -0 and +0 are one number.
            let plain = |bytes: &[u8]| -> Vec<u8> {
                if !format.is_linear() {
                    return bytes.to_vec();
                }
                bytes
                    .as_chunks::<4>()
                    .0
                    .iter()
                    .flat_map(|v| (f32::from_ne_bytes(*v) + 0.0).to_ne_bytes())
                    .collect()
            };
            assert_eq!(
                plain(own),
                plain(&expected(format, linear, shown)),
                "{format:?} at {place:?} of {region:?}"
            );
        }
    }
}

#[test]
fn a_target_holds_the_bytes_of_the_picture_in_its_own_order() {
    for (name, mut shot) in shots() {
        shot.options = shot.options.with_stage_hashes(false);
        println!("{name}");
        let Shot { scene, camera, options, display } = &shot;
        let mut renderer = Renderer::new(2);
        let frame = renderer.render(scene, camera, options).unwrap().frame;
        let (width, height) = (options.width, options.height);
        for (number, &format) in PixelFormat::ALL.iter().enumerate() {
            let opaque = format == PixelFormat::Xrgb8 && display.background.is_none();
            let shown = if opaque { display.clone().with_background(Some([0; 3])) } else { display.clone() };
            let image = DisplayImage::new(&frame, &shown);
            // All parts of one format, one part of the others.
            let parts = regions(width, height);
            let parts = if number == 0 { parts } else { vec![parts[number % parts.len()]] };
            for region in parts {
                let [left, top, part_width, part_height] = region;
                let stride = part_width as usize * format.bytes() + 5;
                let mut bytes = vec![0xab; stride * part_height as usize];
                let mut target =
                    Target::new(&mut bytes, stride, format).with_region(left, top, part_width, part_height);
                renderer.render_into(scene, camera, options, display, &mut target).unwrap();
                check(format, region, &frame, &image, &bytes, stride);
                let between = bytes.chunks(stride).all(|row| row[stride - 5..] == [0xab; 5]);
                assert!(between, "bytes between rows are not the picture's");
            }
        }
        // A metered exposure is that of the whole picture.
        let metered = display.clone().with_meter(Meter::Always);
        let image = DisplayImage::new(&frame, &metered);
        let region = regions(width, height)[2];
        let mut bytes = vec![0; region[2] as usize * 4 * region[3] as usize];
        let stride = region[2] as usize * 4;
        let mut target = Target::new(&mut bytes, stride, PixelFormat::Rgba8)
            .with_region(region[0], region[1], region[2], region[3]);
        renderer.render_into(scene, camera, options, &metered, &mut target).unwrap();
        check(PixelFormat::Rgba8, region, &frame, &image, &bytes, stride);
    }
}

/// Pixels at which the planes of the G-buffer show something can be picked, and nearly always agree.
#[test]
fn what_is_picked_is_what_the_picture_shows_there() {
    for (name, shot) in shots() {
        println!("{name}");
        let Shot { scene, camera, options, .. } = &shot;
        let options =
            &options.clone().with_aovs(vec![Aov::Depth, Aov::ObjectId, Aov::MaterialId, Aov::Coverage]);
        let mut renderer = Renderer::new(2);
        let frame = renderer.render(scene, camera, options).unwrap().frame;
        let (mut hits, mut compared, mut blended) = (0, 0, 0);
        for y in (0..options.height).step_by(5) {
            for x in (0..options.width).step_by(5) {
                let hit = renderer.pick(scene, camera, options, [x, y]).unwrap();
                let plane = |aov| frame.plane_pixel(aov, x, y).unwrap()[0];
                let covered = plane(Aov::Coverage) > 0.0;
                let Some(hit) = hit else {
                    assert!(
                        !covered || !scene.splats().is_empty(),
                        "{name}: nothing at {x}, {y}, which is covered"
                    );
                    continue;
                };
                hits += 1;
                let instance = &scene.instances()[hit.instance];
                let mesh = &scene.meshes()[instance.mesh.index()];
                let sum: f32 = hit.barycentric.iter().sum();
                assert!(
                    (sum - 1.0).abs() < 1e-5 && hit.barycentric.iter().all(|w| (-1e-4..=1.0001).contains(w)),
                    "{hit:?}"
                );
                if mesh.kind() == PrimitiveKind::Triangles {
                    assert_eq!(mesh.triangles()[hit.primitive], hit.vertices);
                }
                // Along the view.
                let axes = camera.axes().unwrap();
                let from_eye: [f64; 3] = std::array::from_fn(|k| hit.position[k] - f64::from(camera.eye[k]));
                let along = -(0..3).map(|k| axes[2][k] * from_eye[k]).sum::<f64>();
                let near = |a: f64, b: f64, part: f64| (a - b).abs() <= part * a.abs().max(b.abs()).max(1e-6);
                if mesh.kind() == PrimitiveKind::Triangles {
                    assert!(near(along, f64::from(hit.depth), 2e-3), "{name}: {along} {hit:?}");
                }
                let material = &scene.materials()[instance.material.index()];
                blended += u32::from(material.alpha_mode == AlphaMode::Blend || material.is_transmissive());
                let alike = frame.id(Aov::ObjectId, x, y) == Some(instance.object + 1)
                    && frame.id(Aov::MaterialId, x, y) == Some(instance.material.index() as u32 + 1);
                let depth = f64::from(plane(Aov::Depth));
                compared += u32::from(alike && near(depth, f64::from(hit.depth), 0.02));
            }
        }
        // At the rims of surfaces the planes have the mean of several; blended ones are not in them.
        let opaque = hits - blended;
        assert!(compared * 10 >= opaque * 7, "{name}: {compared} of {opaque} hits are as the planes have it");
    }
}

fn two_cubes() -> (Scene, Camera, [MaterialId; 2]) {
    let mut scene = Scene::new();
    let mesh = scene.add_mesh(primitives::cuboid([1.0; 3]).unwrap()).unwrap();
    let front = scene.add_material(Material::default()).unwrap();
    let behind = scene.add_material(Material::default()).unwrap();
    for (object, (z, material)) in [(0.0, behind), (2.0, front)].into_iter().enumerate() {
        let transform = Transform::translation([0.0, 0.0, z]).unwrap();
        scene.add_instance(Instance::new(mesh, material, transform).with_object(object as u32)).unwrap();
    }
    let camera = Camera::look_at([0.0, 0.0, 6.0], [0.0; 3], [0.0, 1.0, 0.0]).unwrap();
    (scene, camera, [front, behind])
}

#[test]
fn picking_sees_changes_and_through_what_cannot_be_seen() {
    let (mut scene, camera, [front, _]) = two_cubes();
    let options = RenderOptions::draft(64, 64);
    let mut renderer = Renderer::new(1);
    // Without any picture before.
    let at = |renderer: &mut Renderer, scene: &Scene, pixel| {
        renderer.pick(scene, &camera, &options, pixel).unwrap()
    };
    let hit = at(&mut renderer, &scene, [32, 32]).unwrap();
    assert_eq!(hit.instance, 1);
    assert!(
        (hit.depth - 3.5).abs() < 1e-5 && (hit.position[2] - 2.5).abs() < 1e-6 && !hit.back_facing,
        "{hit:?}"
    );
    assert_eq!(at(&mut renderer, &scene, [1, 1]), None);
    // Glass is seen; what is transparent all over is not.
    let glass = |alpha| {
        Material::default().with(|m| {
            m.base_color = [1.0, 1.0, 1.0, alpha];
            m.alpha_mode = AlphaMode::Blend;
        })
    };
    scene.replace_material(front, glass(0.1)).unwrap();
    assert_eq!(at(&mut renderer, &scene, [32, 32]).unwrap().instance, 1);
    scene.replace_material(front, glass(0.0)).unwrap();
    renderer.render(&scene, &camera, &options).unwrap();
    assert_eq!(at(&mut renderer, &scene, [32, 32]).unwrap().instance, 0);
    scene.remove_instance(0).unwrap();
    assert_eq!(at(&mut renderer, &scene, [32, 32]), None);
    // After a part of the picture, beside it.
    let (scene, camera, _) = two_cubes();
    let mut bytes = [0; 16 * 16 * 4];
    let mut target = Target::new(&mut bytes, 64, PixelFormat::Rgba8).with_region(0, 0, 16, 16);
    renderer.render_into(&scene, &camera, &options, &Default::default(), &mut target).unwrap();
    assert_eq!(renderer.pick(&scene, &camera, &options, [32, 32]).unwrap().unwrap().instance, 1);
    assert!(matches!(
        renderer.pick(&scene, &camera, &options, [64, 0]),
        Err(RenderError::Option { option: "pixel", .. })
    ));
}

#[test]
fn what_does_not_fit_is_an_error_and_draws_nothing() {
    let (scene, camera, _) = two_cubes();
    let options = RenderOptions::draft(8, 8);
    let mut renderer = Renderer::new(1);
    let mut refused = |length: usize, stride, region: Option<[u32; 4]>| {
        let mut bytes = vec![7; length];
        let mut target = Target::new(&mut bytes, stride, PixelFormat::Bgra8);
        if let Some([left, top, width, height]) = region {
            target = target.with_region(left, top, width, height);
        }
        let error = renderer.render_into(&scene, &camera, &options, &Default::default(), &mut target);
        let Err(RenderError::Option { option, .. }) = error else { panic!("{error:?}") };
        assert!(bytes.iter().all(|byte| *byte == 7));
        option
    };
    assert_eq!(refused(255, 32, None), "buffer");
    assert_eq!(refused(0, 0, None), "stride");
    assert_eq!(refused(1000, 31, None), "stride");
    assert_eq!(refused(1000, 32, Some([4, 4, 5, 1])), "region");
}

#[test]
fn a_picture_can_be_stopped() {
    let (scene, camera, _) = two_cubes();
    let options = RenderOptions::draft(64, 64);
    let mut renderer = Renderer::new(2);
    let cancellation = Cancellation::new();
    renderer.cancel_by(Some(cancellation.clone()));
    let before = renderer.render(&scene, &camera, &options).unwrap().frame;
    cancellation.cancel();
    assert_eq!(renderer.render(&scene, &camera, &options).unwrap_err(), RenderError::Cancelled);
    renderer.cancel_by(Some(Cancellation::new()));
    assert_eq!(renderer.render(&scene, &camera, &options).unwrap().frame, before);
}

/// Wherever a limit stops a picture, the next one is as if nothing had been drawn before.
#[test]
fn a_picture_that_was_stopped_leaves_nothing_behind() {
    for (name, shot) in shots() {
        println!("{name}");
        let Shot { scene, camera, options, .. } = &shot;
        let options = options.clone().with_quality(Quality::Best).with_samples(4);
        let whole = Renderer::new(1).render(scene, camera, &options).unwrap();
        let mut renderer = Renderer::new(1);
        for part in 1..12_u64 {
            let mut limits = Limits::default();
            // A limit of one kind of work in turn, at growing parts of what the whole picture takes.
            match part % 4 {
                0 => limits.fragments = (whole.stats.fragments * part / 12).max(1),
                1 => limits.blocks = (renderer.work_done().blocks * part / 12).max(1),
                2 => limits.blend_entries = part * 20,
                _ => limits.shading = part / 4,
            }
            let stopped = renderer.render(scene, camera, &options.clone().with_limits(limits));
            assert!(matches!(stopped, Ok(_) | Err(RenderError::Limit(_))), "{stopped:?}");
            let after = renderer.render(scene, camera, &options).unwrap();
            assert_eq!(after.frame.frame_hash(), whole.frame.frame_hash(), "{name}, after part {part}");
        }
    }
}

/// A scene whose first picture takes every stage that can be stopped: an environment to filter, depth maps of it and of a lamp,
/// tinted glass, rays, a floor.
fn scene_of_many_stages() -> (Scene, Camera, RenderOptions) {
    let (mut scene, camera, _) = two_cubes();
    let sky = (0..128 * 64).map(|k| [(k % 7) as f32, 1.0, 0.5]).collect();
    let source = EnvironmentSource::Image(Arc::new(EquirectImage::new(128, 64, sky).unwrap()));
    scene.set_environment(Environment::default().with(|e| e.source = source)).unwrap();
    scene.add_light(Light::new(LightKind::Point { position: [0.0, 3.0, 1.0], range: None })).unwrap();
    let options = RenderOptions::new(96, 64).with_quality(Quality::Good).with_ground(Ground::Shadow);
    (scene, camera, options)
}

#[test]
fn a_picture_that_is_stopped_midway_leaves_nothing_behind() {
    let (scene, camera, options) = scene_of_many_stages();
    let mut first = Renderer::new(2);
    let start = std::time::Instant::now();
    let expected = first.render(&scene, &camera, &options).unwrap().frame;
    let whole = start.elapsed();
    for part in 0..32 {
        let mut renderer = Renderer::new(2);
        let cancellation = Cancellation::new();
        renderer.cancel_by(Some(cancellation.clone()));
        let drawn = std::thread::scope(|threads| {
            threads.spawn(|| {
                std::thread::sleep(whole * part / 32);
                cancellation.cancel();
            });
            renderer.render(&scene, &camera, &options)
        });
        match drawn {
            Ok(drawn) => assert_eq!(drawn.frame, expected),
            Err(error) => assert_eq!(error, RenderError::Cancelled),
        }
        renderer.cancel_by(None);
        assert_eq!(renderer.render(&scene, &camera, &options).unwrap().frame, expected, "stopped at {part}");
    }
}
