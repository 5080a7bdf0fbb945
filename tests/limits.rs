//! Work is bounded by counting, not by a clock: a frame that costs more than allowed has less light or ends in an error, the same
//! for every number of threads.

use overcoat::limits::Limits;
use overcoat::render::{Ground, Quality, RenderError, RenderOptions, Rendered, Renderer, Visibility};
use overcoat::scene::{
    AlphaMode, Camera, Framing, Instance, Light, LightKind, Material, Mesh, MeshData, Projection, Scene,
    ShadingModel, Transform,
};

/// `count` triangles behind each other, each larger than the picture.
fn stack(count: u32, alpha_mode: AlphaMode) -> (Scene, Camera) {
    let mut data = MeshData::default();
    for k in 0..count {
        // The farthest comes first, so that none is hidden when it is drawn.
        let z = k as f32 / count as f32;
        data.triangles.push([3 * k, 3 * k + 1, 3 * k + 2]);
        data.positions.extend([[-4.0, -4.0, z], [12.0, -4.0, z], [-4.0, 12.0, z]]);
    }
    let mut scene = Scene::new();
    let material = Material::default().with(|m| {
        m.base_color = [0.5, 0.6, 0.7, 0.5];
        m.alpha_mode = alpha_mode;
    });
    let mesh = scene.add_mesh(Mesh::new(data).unwrap()).unwrap();
    let material = scene.add_material(material).unwrap();
    scene.add_instance(Instance::new(mesh, material, Transform::IDENTITY)).unwrap();
    let camera = Camera::new(
        [0.0, 0.0, 5.0],
        [0.0; 3],
        [0.0, 1.0, 0.0],
        Projection::Orthographic { height: 2.0 },
        0.01,
    );
    (scene, camera)
}

/// The field of the limit that stops a picture of 64 x 64 pixels, if one does.
fn stopped_by(scene: &Scene, camera: &Camera, limits: Limits, threads: usize) -> Option<&'static str> {
    let options = RenderOptions::draft(64, 64).with_samples(4).with_limits(limits);
    match Renderer::new(threads).render(scene, camera, &options) {
        Ok(_) => None,
        Err(RenderError::Limit(e)) => {
            assert!(e.asked.is_none_or(|asked| asked > e.limit), "{e}");
            Some(e.field)
        }
        Err(e) => panic!("{e}"),
    }
}

#[test]
fn the_rasterizer_stops_at_its_limit() {
    let (scene, camera) = stack(500, AlphaMode::Opaque);
    // 64 x 64 pixels are 16 x 16 blocks, and each triangle is drawn into all of them.
    let blocks = 500 * 16 * 16;
    for threads in [1, 3] {
        let limits = |blocks| Limits::default().with_blocks(blocks);
        assert_eq!(stopped_by(&scene, &camera, limits(blocks), threads), None);
        assert_eq!(stopped_by(&scene, &camera, limits(blocks - 1), threads), Some("blocks"));
        assert_eq!(stopped_by(&scene, &camera, limits(10), threads), Some("blocks"));
    }
}

#[test]
fn blending_stops_at_its_limit() {
    let (scene, camera) = stack(50, AlphaMode::Blend);
    let entries = 50 * 64 * 64;
    for threads in [1, 3] {
        let limits = |blend_entries| Limits::default().with_blend_entries(blend_entries);
        assert_eq!(stopped_by(&scene, &camera, limits(entries), threads), None);
        assert_eq!(stopped_by(&scene, &camera, limits(entries - 1), threads), Some("blend_entries"));
    }
}

/// A tile keeps 2^18 blended fragments: beyond that its parts are blended one after the other, down to single pixels.
#[test]
fn more_layers_than_a_tile_keeps_are_blended_all_the_same() {
    let draw = |scene: &Scene, camera: &Camera, [width, height]: [u32; 2], samples, tile_size| {
        let tile_size = Some(tile_size);
        let options = RenderOptions::draft(width, height).with_samples(samples).with_tile_size(tile_size);
        let rendered = Renderer::new(1).render(scene, camera, &options).unwrap();
        (rendered.frame.pixels, rendered.stats.fragments)
    };
    let (mut scene, camera) = stack(150, AlphaMode::Blend);
    let wall = scene.add_mesh(stack(1, AlphaMode::Opaque).0.meshes()[0].clone()).unwrap();
    let material = scene.add_material(Material::default().with(|m| m.unlit = true)).unwrap();
    // It covers the left half.
    let transform = Transform::from_parts([0.0, 0.0, -1.0], [0.0, 0.0, 1.0, 0.0], [1.0; 3]).unwrap();
    scene.add_instance(Instance::new(wall, material, transform).with_object(1)).unwrap();
    for samples in [1, 4] {
        // 150 layers of a tile of 16 x 16 are kept at once.
        let small = draw(&scene, &camera, [64, 64], samples, 16);
        assert!(small.1 >= 150 * 64 * 64);
        assert_eq!(draw(&scene, &camera, [64, 64], samples, 32), small);
        assert_eq!(draw(&scene, &camera, [64, 64], samples, 64), small);
    }
    for (layers, size) in [(60_000, [5, 1]), (300_000, [1, 2])] {
        let (scene, camera) = stack(layers, AlphaMode::Blend);
        let (pixels, fragments) = draw(&scene, &camera, size, 1, 16);
        assert_eq!(fragments, u64::from(layers * size[0] * size[1]));
        assert!(pixels.iter().all(|pixel| *pixel == pixels[0] && pixel[3] == 1.0), "{pixels:?}");
    }
}

#[test]
fn fragments_pixels_and_triangles_are_counted() {
    let (scene, camera) = stack(20, AlphaMode::Opaque);
    let default = Limits::default();
    let visible = 64 * 64;
    let cases = [
        (default.clone().with_fragments(visible), None),
        (default.clone().with_fragments(visible - 1), Some("fragments")),
        (default.clone().with_triangles(20), None),
        (default.clone().with_triangles(19), Some("triangles")),
        (default.clone().with_output_pixels(64 * 64), None),
        (default.clone().with_output_pixels(64 * 64 - 1), Some("output_pixels")),
        (default.clone().with_output_side(64), None),
        (default.with_output_side(63), Some("output_side")),
    ];
    for (limits, expected) in cases {
        assert_eq!(stopped_by(&scene, &camera, limits, 2), expected);
    }
}

/// Lamps in rows above the picture.
fn add_lamps(scene: &mut Scene, count: u32, range: Option<f32>) {
    for k in 0..count {
        let position = [(k % 16) as f32 / 8.0 - 0.9, (k / 16) as f32 / 8.0 - 0.9, 1.2];
        let lamp = Light::new(LightKind::Point { position, range }).with(|l| l.intensity = 0.1);
        scene.add_light(lamp).unwrap();
    }
}

/// A few blended squares under many lights took minutes, and as long again before a limit on fragments said no.
#[test]
fn shading_stops_at_its_limit_before_anything_beyond_it_is_shaded() {
    let (mut scene, camera) = stack(120, AlphaMode::Blend);
    add_lamps(&mut scene, 256, None);
    // 120 x 64 x 64 fragments; each takes 52 units, 5 for each light, 90 to be blended.
    let whole = 120 * 64 * 64 * (52 + 256 * 5 + 90);
    let limited = |shading: u64| Limits::default().with_shading(shading);
    let draw = |limits: Limits, threads, tile_size| {
        let mut renderer = Renderer::new(threads);
        let simd = overcoat_core::math::lanes::SimdLevel::best();
        let options = RenderOptions::draft(64, 64)
            .with_samples(4)
            .with_limits(limits)
            .with_tile_size(tile_size)
            .with_shading(ShadingModel::Gltf)
            .with_simd(simd);
        let result = renderer.render(&scene, &camera, &options).map(|rendered| rendered.stats.shading);
        (result, renderer.work_done().shading)
    };
    // Counted for at least 2^18 pixels.
    let enough = u64::div_ceil(whole, 1 << 18);
    for (threads, tile_size) in [(1, None), (3, Some(16)), (2, Some(64))] {
        let (error, begun) = draw(limited(100), threads, tile_size);
        let message = error.unwrap_err().to_string();
        assert_eq!(message, "units of shading for each pixel: more than the limit of 100 (shading)");
        // Every thread counts the fragments that it keeps at most, and shades none of them.
        let overshoot = threads as u64 * (1 << 18) * (52 + 256 * 5 + 90);
        assert!(begun > 100 << 18 && begun <= (100 << 18) + overshoot, "{begun}");
        let (error, begun) = draw(limited(enough - 1), threads, tile_size);
        assert!(error.is_err() && begun <= whole, "{begun}");
    }
    assert_eq!(draw(limited(enough), 2, None), (Ok(whole), whole));
    // The error names the limit that a single thread passes first, and the cheapest of those that one tile passes.
    let several = limited(200).with_fragments(70_000).with_blend_entries(60_000);
    for (threads, tile_size) in [(1, None), (3, Some(16)), (3, Some(64)), (7, None)] {
        for _ in 0..3 {
            let message = draw(several.clone(), threads, tile_size).0.unwrap_err().to_string();
            assert_eq!(message, "blended fragments: more than the limit of 60000 (blend_entries)");
        }
    }
}

/// Memory that tiles keep decides which parts of them are blended one by one, and must not show in the counted work.
#[test]
fn work_does_not_depend_on_tiles() {
    let (mut scene, camera) = stack(150, AlphaMode::Blend);
    add_lamps(&mut scene, 40, Some(0.4));
    let wall = scene.add_mesh(stack(1, AlphaMode::Opaque).0.meshes()[0].clone()).unwrap();
    for (k, alpha_mode) in
        [AlphaMode::Mask { cutoff: 0.5 }, AlphaMode::Opaque, AlphaMode::Blend].into_iter().enumerate()
    {
        let coat = k as f32 * 0.5;
        let material = scene
            .add_material(Material::default().with(|m| {
                m.coat = coat;
                m.alpha_mode = alpha_mode;
            }))
            .unwrap();
        // Edges cross blocks and cells.
        let transform =
            Transform::from_parts([0.3 * f64::from(coat), 0.2, -1.0], [0.0, 0.0, 0.6, 0.8], [0.15; 3])
                .unwrap();
        scene.add_instance(Instance::new(wall, material, transform).with_object(1)).unwrap();
    }
    for samples in [1, 4] {
        let mut seen = Vec::new();
        for (threads, tile) in [(1, 64), (2, 32), (3, 16)] {
            let mut renderer = Renderer::new(threads);
            let options = RenderOptions::draft(100, 90).with_samples(samples).with_tile_size(Some(tile));
            renderer.render(&scene, &camera, &options).unwrap();
            seen.push(renderer.work_done());
        }
        assert!(seen[0].blend_entries > 150 * 90 * 90 && seen[0].shading > 0);
        assert!(seen.iter().all(|work| *work == seen[0]), "{seen:#?}");
    }
}

/// A light is left out where its range ends, by tiles: no bit of the picture knows.
#[test]
fn lights_out_of_reach_change_nothing() {
    for (alpha_mode, transmission) in
        [(AlphaMode::Opaque, 0.0), (AlphaMode::Blend, 0.0), (AlphaMode::Opaque, 0.5)]
    {
        let (mut scene, camera) = stack(2, alpha_mode);
        let mut layered = Material::default().with(|m| {
            m.alpha_mode = alpha_mode;
            m.coat = 0.7;
        });
        layered.lobes.sheen.color.factor = [0.2, 0.5, 0.1];
        layered.lobes.iridescence.mask.factor = 0.5;
        layered.lobes.transmission.factor.factor = transmission;
        layered.lobes.transmission.diffuse.factor = transmission * 0.5;
        let ball = scene.add_material(layered).unwrap();
        let transform = Transform::from_parts([-0.2, 0.1, 1.0], [0.3, 0.2, 0.1, 0.9], [0.2; 3]).unwrap();
        let mesh = scene.instances()[0].mesh;
        scene.add_instance(Instance::new(mesh, ball, transform).with_object(1)).unwrap();
        add_lamps(&mut scene, 24, Some(0.5));
        for &model in ShadingModel::ALL {
            let draw = |scene: &Scene, tile_size| {
                let options = RenderOptions::draft(96, 80)
                    .with_samples(1)
                    .with_tile_size(Some(tile_size))
                    .with_shading(model);
                let rendered = Renderer::new(1).render(scene, &camera, &options).unwrap();
                let bits = rendered.frame.pixels.iter().flatten().map(|v| v.to_bits()).collect::<Vec<_>>();
                (bits, rendered.stats.shading)
            };
            // Tiles of 64 ask lights that tiles of 16 leave out.
            let expected = draw(&scene, 16);
            assert!(draw(&scene, 64) == expected, "{}", model.name());
            let mut more = scene.clone();
            for position in [[9.0, 0.0, 0.0], [0.0, -7.0, 1.0], [3.0, 3.0, 3.0]] {
                let lamp = LightKind::Point { position, range: Some(0.9) };
                more.add_light(Light::new(lamp).with(|l| l.intensity = 1e6)).unwrap();
            }
            assert!(draw(&more, 64) == expected, "{}", model.name());
        }
    }
}

#[test]
fn memory_of_a_frame_does_not_depend_on_the_tiles_that_are_chosen() {
    let (scene, camera) = stack(300, AlphaMode::Opaque);
    let draw = |frame_bytes, tile_size| {
        let limits = Limits::default().with_frame_bytes(frame_bytes);
        let options =
            RenderOptions::draft(200, 200).with_samples(4).with_limits(limits).with_tile_size(tile_size);
        Renderer::new(2).render(&scene, &camera, &options).map(|_| ()).map_err(|error| error.to_string())
    };
    let (mut too_little, mut enough) = (0, 1 << 24);
    while enough - too_little > 1 {
        let middle = u64::midpoint(too_little, enough);
        if draw(middle, None).is_ok() { enough = middle } else { too_little = middle }
    }
    for tile_size in [16, 32, 64] {
        assert_eq!(draw(enough, Some(tile_size)), Ok(()), "{tile_size}");
        let message = format!("memory of one frame: more than the limit of {too_little} (frame_bytes)");
        assert_eq!(draw(too_little, Some(tile_size)), Err(message), "{tile_size}");
    }
}

/// Flat triangles one behind the other: each covers all depth maps that look from above.
fn pile(count: u32) -> (Scene, Camera) {
    let mut scene = Scene::new();
    let corners = |k: u32| {
        let height = k as f32 * 1e-3;
        [[-1.0, height, -1.0], [1.0, height, -1.0], [0.0, height, 1.0]]
    };
    let positions = (0..count).flat_map(corners).collect();
    let triangles = (0..count).map(|k| [3 * k, 3 * k + 2, 3 * k + 1]).collect();
    let mesh = scene.add_mesh(Mesh::new(MeshData::new(positions, triangles)).unwrap()).unwrap();
    let material = scene.add_material(Material::default()).unwrap();
    scene.add_instance(Instance::new(mesh, material, Transform::IDENTITY).with_object(1)).unwrap();
    let camera = Framing::default().camera(&scene);
    (scene, camera)
}

/// Every tier draws what draft draws: with less light where that passes a limit, the same whatever was drawn before,
/// the threads and the tiles, and as if the less had been asked for.
#[test]
fn no_tier_refuses_what_draft_draws() {
    let (scene, camera) = pile(600);
    let limits = |blocks| Limits::default().with_blocks(blocks);
    let mut seen = Vec::new();
    for &quality in Quality::ALL {
        for (blocks, frame_bytes) in
            [(1 << 27, 1 << 29), (400_000, 1 << 29), (30_000, 1 << 29), (1 << 27, 1 << 21)]
        {
            let options = RenderOptions::new(48, 48)
                .with_quality(quality)
                .with_limits(limits(blocks).with_frame_bytes(frame_bytes));
            let mut renderer = Renderer::new(2);
            let Rendered { frame, stats, .. } = renderer.render(&scene, &camera, &options).unwrap();
            let again = renderer.render(&scene, &camera, &options).unwrap();
            assert!(again.frame == frame && again.stats.reduced_light == stats.reduced_light);
            let other = options.clone().with_tile_size(Some(16));
            let other = Renderer::new(3).render(&scene, &camera, &other).unwrap();
            assert!(other.frame == frame && other.stats.reduced_light == stats.reduced_light);
            let visibility = stats.reduced_light.as_ref().map(|light| light.visibility);
            seen.push((quality, visibility));
            if let Some(visibility) = visibility {
                let ground = if visibility.is_on() { options.ground } else { Ground::None };
                let less = options.clone().with_visibility(visibility).with_ground(ground);
                let Rendered { frame: expected, stats, .. } =
                    Renderer::new(1).render(&scene, &camera, &less).unwrap();
                assert!(frame == expected && stats.reduced_light.is_none(), "{quality:?} {visibility:?}");
            }
        }
    }
    // Each way of doing less is met.
    let few = |visibility: Visibility| visibility.is_on() && visibility.maps <= 16;
    assert!(seen.iter().any(|(_, less)| less.is_some_and(few)), "{seen:?}");
    assert!(seen.iter().any(|(_, less)| *less == Some(Visibility::NONE)), "{seen:?}");
    assert!(seen.iter().any(|(quality, less)| *quality != Quality::Draft && less.is_none()), "{seen:?}");
}

/// A fan whose blades are thinner than a texel costs a line of texels each, not the box around it.
#[test]
fn a_fan_of_fifty_thousand_has_its_shadow() {
    let count = 50_000_u32;
    let mut positions = vec![[0.0, 0.3, 0.0]];
    positions.extend((0..count).map(|k| {
        let (sine, cosine) = overcoat_core::math::double::sin_cos(
            f64::from(k) / f64::from(count) * 2.0 * std::f64::consts::PI,
        );
        [cosine as f32, 0.0, sine as f32]
    }));
    let triangles = (0..count).map(|k| [0, 1 + (k + 1) % count, 1 + k]).collect();
    let mut scene = Scene::new();
    let mesh = scene.add_mesh(Mesh::new(MeshData::new(positions, triangles)).unwrap()).unwrap();
    let material = scene.add_material(Material::default()).unwrap();
    scene.add_instance(Instance::new(mesh, material, Transform::IDENTITY).with_object(1)).unwrap();
    let camera = Framing::automatic(&scene).camera(&scene);
    let stats = Renderer::new(2).render(&scene, &camera, &RenderOptions::new(64, 64)).unwrap().stats;
    assert_eq!(stats.reduced_light, None);
}

/// Every limit by its option, on files that need exactly so much: the least that is enough is known, one less is exit
/// code 3 with its name, and 10^18 overflows nothing.
mod by_option {
    use serde_json::{Value, json};
    use std::path::Path;
    use std::process::{Command, Output};

    fn render(folder: &Path, model: &str, limit: &str, more: &[&str]) -> Output {
        let command = if more.contains(&"--frames") { "turntable" } else { "render" };
        let mut args = vec![command, model, "-o", "p.png", "--limit", limit];
        if !more.contains(&"--env") {
            args.extend(["--env", "none"]);
        }
        if !more.contains(&"--size") {
            args.extend(["--size", "64"]);
        }
        args.extend(more);
        Command::new(env!("CARGO_BIN_EXE_overcoat")).args(args).current_dir(folder).output().unwrap()
    }

    /// Three nodes below each other, two textures of 6 and 4 pixels, two lights, five vertices, three triangles that
    /// cover the picture.
    fn document() -> Value {
        let png = |width: u32, height: u32| {
            use base64::Engine;
            let mut bytes = Vec::new();
            let mut encoder = png::Encoder::new(&mut bytes, width, height);
            encoder.set_color(png::ColorType::Grayscale);
            let pixels = vec![200; (width * height) as usize];
            encoder.write_header().unwrap().write_image_data(&pixels).unwrap();
            let text = base64::engine::general_purpose::STANDARD.encode(&bytes);
            json!({"uri": format!("data:image/png;base64,{text}")})
        };
        let corners: [[f32; 3]; 5] =
            [[-9.0, -9.0, 0.0], [9.0, -9.0, 0.0], [9.0, 9.0, 0.0], [-9.0, 9.0, 0.0], [0.0, 30.0, 0.0]];
        let mut bytes: Vec<u8> = corners.iter().flatten().flat_map(|v| v.to_le_bytes()).collect();
        bytes.extend([0_u8, 1, 2, 0, 2, 3, 3, 2, 4, 0, 0, 0]);
        let data = {
            use base64::Engine;
            base64::engine::general_purpose::STANDARD.encode(&bytes)
        };
        json!({
            "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 3, 4]}],
            "nodes": [{"children": [1]}, {"children": [2]}, {"mesh": 0},
                {"extensions": {"KHR_lights_punctual": {"light": 0}}},
                {"extensions": {"KHR_lights_punctual": {"light": 0}}},
                {}, {}],
            "extensionsUsed": ["KHR_lights_punctual"],
            "extensions": {"KHR_lights_punctual": {"lights": [{"type": "directional"}]}},
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 2}, "indices": 1, "material": 0}]}],
            "materials": [{"alphaMode": "BLEND", "emissiveTexture": {"index": 0}, "emissiveFactor": [1, 1, 1],
                "occlusionTexture": {"index": 1},
                "pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1, 0.5]}}],
            "textures": [{"source": 0}, {"source": 1}],
            "images": [png(3, 2), png(2, 2)],
            "accessors": [{"bufferView": 0, "componentType": 5126, "count": 5, "type": "VEC3"},
                {"bufferView": 1, "componentType": 5121, "count": 9, "type": "SCALAR"},
                {"componentType": 5126, "count": 5, "type": "VEC2"}],
            "bufferViews": [{"buffer": 0, "byteLength": 60}, {"buffer": 0, "byteOffset": 60, "byteLength": 9}],
            "buffers": [{"byteLength": 72, "uri": format!("data:;base64,{data}")}]
        })
    }

    #[test]
    fn each_is_exact() {
        let folder = tempfile::tempdir().unwrap();
        let text = document().to_string();
        std::fs::write(folder.path().join("x.gltf"), &text).unwrap();
        let sky = [&b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 4\n"[..], &[128; 32]].concat();
        std::fs::write(folder.path().join("sky.hdr"), sky).unwrap();
        let mut tangled = document();
        tangled["materials"][0]["alphaMode"] = "OPAQUE".into();
        std::fs::write(folder.path().join("opaque.gltf"), tangled.to_string()).unwrap();
        let small = ["--eye", "0,0,5", "--target", "0,0,0", "--ortho=2", "--samples", "1"];
        let wide = ["--size", "80x20"];
        // With one sample a pixel is in one triangle.
        let pixels = 64 * 64;
        let cases: [(&str, &str, Option<u64>, &[&str]); 18] = [
            ("input_bytes", "x.gltf", Some(text.len() as u64), &[]),
            ("decoded_bytes", "x.gltf", None, &[]),
            ("triangles", "x.gltf", Some(3), &[]),
            ("vertices", "x.gltf", None, &[]),
            ("nodes", "x.gltf", Some(7), &[]),
            ("depth", "x.gltf", Some(3), &[]),
            ("textures", "x.gltf", Some(2), &[]),
            // Textures of models are drawn from smaller levels or left out; environments are whole.
            ("texture_pixels", "x.gltf", Some(8), &["--env", "sky.hdr"]),
            ("total_texture_pixels", "x.gltf", Some(10), &[]),
            ("lights", "x.gltf", Some(2), &[]),
            ("output_side", "x.gltf", Some(80), &wide),
            ("output_pixels", "x.gltf", Some(1600), &wide),
            ("fragments", "opaque.gltf", Some(pixels), &small),
            ("shading", "opaque.gltf", None, &small),
            ("blocks", "opaque.gltf", None, &small),
            ("blend_entries", "x.gltf", Some(pixels), &small),
            ("frame_bytes", "x.gltf", None, &small),
            ("frames", "x.gltf", Some(3), &["--frames", "3"]),
        ];
        assert_eq!(cases.map(|case| case.0), overcoat_cli::value_parsers::LIMIT_NAMES);
        for (name, model, expected, more) in cases {
            let code = |limit: u64| {
                let done = render(folder.path(), model, &format!("{name}={limit}"), more);
                let message = String::from_utf8(done.stderr).unwrap();
                match done.status.code() {
                    Some(0) => true,
                    Some(3) if message.ends_with(&format!("({name}); --limit {name}=N raises it\n")) => false,
                    code => panic!("{name}={limit}: {code:?} {message}"),
                }
            };
            // The least that is enough.
            let (mut too_little, mut enough) = (0, expected.map_or(1 << 20, |n| 2 * n));
            while enough - too_little > 1 {
                let middle = u64::midpoint(too_little, enough);
                if code(middle) { enough = middle } else { too_little = middle }
            }
            if let Some(expected) = expected {
                assert_eq!(enough, expected, "{name}");
            }
            assert!(code(enough) && !code(enough - 1) && !code(0), "{name}: {enough}");
            if name != "output_side" {
                assert!(code(1_000_000_000_000_000_000), "{name}");
            }
        }
    }

    /// Function that makes a claim, and a part of the message that has to follow.
    type Claim = (fn(&mut Value, u64), &'static str);

    /// Ten to the power of eighteen of everything that a few bytes can ask for.
    #[test]
    fn nothing_is_made_for_a_claim() {
        let folder = tempfile::tempdir().unwrap();
        let huge = 1_000_000_000_000_000_000_u64;
        let claims: [Claim; 5] = [
            (|d, n| d["accessors"][0]["count"] = n.into(), "accessor 0: a count of"),
            (
                |d, n| {
                    d["accessors"][0]["count"] = n.into();
                    d["accessors"][0].as_object_mut().unwrap().remove("bufferView");
                    d["meshes"][0]["primitives"][0]["attributes"]
                        .as_object_mut()
                        .unwrap()
                        .remove("TEXCOORD_0");
                },
                "accessor 0: a count of",
            ),
            (|d, n| d["buffers"][0]["byteLength"] = n.into(), "byteLength says"),
            (|d, n| d["bufferViews"][0]["byteLength"] = n.into(), "reaches beyond"),
            (
                |d, n| {
                    d["accessors"]
                        .as_array_mut()
                        .unwrap()
                        .push(json!({"componentType": 5126, "count": n, "type": "VEC3"}));
                    d["nodes"][2]["extensions"] =
                        json!({"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": 3}}});
                },
                "(decoded_bytes)",
            ),
        ];
        for (claim, expected) in claims {
            let mut document = document();
            claim(&mut document, huge);
            std::fs::write(folder.path().join("x.gltf"), document.to_string()).unwrap();
            let done = render(folder.path(), "x.gltf", "depth=1000", &["--json"]);
            let message = String::from_utf8(done.stderr).unwrap();
            assert!(message.contains(expected), "{message}");
            // A buffer or a view may have what is asked of it all the same.
            assert!(matches!(done.status.code(), Some(0 | 1 | 3)), "{message}");
        }
        let size = format!("{huge}x{huge}");
        std::fs::write(folder.path().join("x.gltf"), document().to_string()).unwrap();
        let done = render(folder.path(), "x.gltf", "depth=1000", &["--size", &size]);
        assert_eq!(done.status.code(), Some(3), "{}", String::from_utf8_lossy(&done.stderr));
    }
}
