//! Textures that are decoded and environments that are filtered when pictures read them: the pictures are those of textures that
//! are decoded as a whole and of environments that are filtered at every roughness, what is wrong with images is told, and nothing
//! is decoded that no pixel asks for.

use crate::common::files::document::document;
use crate::common::files::model::{Model, push};
use crate::common::images::sky;
use crate::common::shapes::{noise, repeat_uv, sphere, square};
use image::{DynamicImage, ImageBuffer, ImageFormat};
use overcoat::frame::{Aov, DisplayOptions};
use overcoat::jobs::Jobs;
use overcoat::limits::Limits;
use overcoat::load::{Context, Format, LoadOptions, Loaded, MemoryResolver, TextureLoading, load_bytes_with};
use overcoat::render::{Background, Ground, Quality, RenderOptions, Renderer};
use overcoat::scene::{
    Camera, Environment, EnvironmentSource, Framing, Instance, Material, Mesh, MeshData, Scene, ShadingModel,
    Transform, Workflow,
};
use overcoat_core::math::lanes::SimdLevel;
use overcoat_stages::light::PrefilteredEnvironment;
use serde_json::{Value, json};
use std::io::Cursor;
use std::sync::Arc;

/// An image of some kind of texels.
fn picture(width: u32, height: u32, seed: u32, kind: Kind) -> DynamicImage {
    let channel = |x: u32, y: u32, c: u32| {
        let grain = noise((seed * 4 + c) * 1_000_003 + y * width + x);
        let slope = (x * (c + 2) + y * 3) as f32 / (width + height) as f32;
        (slope.fract() * 0.7 + grain * 0.3) * 255.0
    };
    let rgb = |x, y| [0, 1, 2].map(|c| channel(x, y, c) as u8);
    match kind {
        Kind::Rgb => ImageBuffer::from_fn(width, height, |x, y| image::Rgb(rgb(x, y))).into(),
        Kind::Grey => {
            ImageBuffer::from_fn(width, height, |x, y| image::Luma([channel(x, y, 0) as u8])).into()
        }
        Kind::Wide => ImageBuffer::from_fn(width, height, |x, y| {
            image::Rgb([0, 1, 2].map(|c| (channel(x, y, c) * 257.0) as u16))
        })
        .into(),
        Kind::Alpha => ImageBuffer::from_fn(width, height, |x, y| {
            let [r, g, b] = rgb(x, y);
            let hole = (x / 9 + y / 7).is_multiple_of(3);
            image::Rgba([r, g, b, if hole { 20 } else { channel(x, y, 3) as u8 | 128 }])
        })
        .into(),
        Kind::Normals | Kind::NormalsWithAlpha => {
            let alpha = if kind == Kind::Normals { 255 } else { 200 };
            ImageBuffer::from_fn(width, height, |x, y| {
                let [r, g, _] = rgb(x, y).map(|v| 96 + v / 4);
                image::Rgba([r, g, 220, if x == 5 { alpha } else { 255 }])
            })
            .into()
        }
    }
}

#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Rgb,
    Grey,
    Wide,
    Alpha,
    Normals,
    NormalsWithAlpha,
}

fn encoded(picture: &DynamicImage, format: ImageFormat) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    picture.write_to(&mut bytes, format).unwrap();
    bytes.into_inner()
}

fn png(width: u32, height: u32, seed: u32, kind: Kind) -> Vec<u8> {
    encoded(&picture(width, height, seed, kind), ImageFormat::Png)
}

/// A square all of whose corners have the same texture coordinates: one texel, of the finest level.
fn one_texel() -> MeshData {
    let mut mesh = square(1);
    mesh.tangents.clear();
    mesh.uvs[0].iter_mut().for_each(|uv| *uv = [0.31, 0.72]);
    mesh
}

/// Textures in every role that is not like another, of every kind of texels and sampler, near and far.
fn everything() -> Vec<u8> {
    let mut model = document();
    model.json["samplers"] = json!([]);
    let mut near = square(2);
    near.tangents.clear();
    let near = model.shape(&near);
    let far = model.shape(&repeat_uv(square(2), 23.0));
    let (ball, spot) = (model.shape(&sphere(24)), model.shape(&one_texel()));

    let color = model.texture(&png(300, 211, 1, Kind::Rgb));
    let rough = model.texture(&encoded(&picture(256, 256, 2, Kind::Rgb), ImageFormat::Jpeg));
    let normal = model.texture(&png(256, 256, 3, Kind::Normals));
    let odd_normal = model.texture(&png(129, 200, 4, Kind::NormalsWithAlpha));
    let holes = model.texture(&png(160, 120, 5, Kind::Alpha));
    let grey = model.texture(&png(200, 64, 6, Kind::Grey));
    let wide = model.texture(&png(64, 300, 7, Kind::Wide));
    let webp = encoded(&picture(128, 96, 8, Kind::Alpha), ImageFormat::WebP);
    let webp = model.texture_of("EXT_texture_webp", &webp);
    let bmp = model.texture(&png(1, 1, 9, Kind::Rgb));
    for (number, sampler) in [
        json!({"magFilter": 9728, "minFilter": 9984, "wrapS": 33071, "wrapT": 33648}),
        json!({"magFilter": 9728, "minFilter": 9729, "wrapS": 33648}),
        json!({"magFilter": 9729, "minFilter": 9986, "wrapT": 33071}),
        json!({"magFilter": 9728, "minFilter": 9985}),
        json!({"minFilter": 9728}),
    ]
    .into_iter()
    .enumerate()
    {
        let sampler = push(&mut model.json["samplers"], sampler);
        // The image of another texture, and one of its own.
        let of = [0, 5][number % 2];
        push(&mut model.json["textures"], json!({"source": of, "sampler": sampler}));
    }
    let sampled = |k: usize| bmp + 1 + k;

    let plain = |texture: usize| json!({"pbrMetallicRoughness": {"baseColorTexture": {"index": texture}}});
    let mut materials = vec![
        json!({
            "pbrMetallicRoughness": {
                "baseColorTexture": {"index": color},
                "metallicRoughnessTexture": {"index": rough},
            },
            "normalTexture": {"index": normal},
            "occlusionTexture": {"index": rough},
            "emissiveTexture": {"index": grey},
            "emissiveFactor": [0.2, 0.1, 0.0],
        }),
        json!({
            "pbrMetallicRoughness": {"baseColorTexture": {"index": holes}, "roughnessFactor": 0.4},
            "normalTexture": {"index": odd_normal, "scale": 0.7},
            "alphaMode": "BLEND",
        }),
        json!({
            "pbrMetallicRoughness": {"baseColorTexture": {"index": holes}},
            "alphaMode": "MASK", "alphaCutoff": 0.5,
        }),
        json!({
            "pbrMetallicRoughness": {"baseColorTexture": {"index": color}, "metallicFactor": 0.0},
            "alphaMode": "MASK", "alphaCutoff": 0.5,
        }),
        json!({
            "pbrMetallicRoughness": {"baseColorTexture": {"index": wide}, "metallicFactor": 0.0},
            "extensions": {
                "KHR_materials_clearcoat": {
                    "clearcoatFactor": 1.0,
                    "clearcoatTexture": {"index": grey},
                    "clearcoatRoughnessFactor": 0.4,
                    "clearcoatRoughnessTexture": {"index": rough},
                    "clearcoatNormalTexture": {"index": odd_normal},
                },
                "KHR_materials_sheen": {
                    "sheenColorFactor": [1, 1, 1], "sheenColorTexture": {"index": color},
                    "sheenRoughnessFactor": 0.6, "sheenRoughnessTexture": {"index": webp},
                },
                "KHR_materials_specular": {
                    "specularTexture": {"index": holes}, "specularColorTexture": {"index": webp},
                },
            },
        }),
        json!({
            "pbrMetallicRoughness": {"baseColorTexture": {"index": webp}, "metallicFactor": 0.0},
            "extensions": {
                "KHR_materials_transmission": {
                    "transmissionFactor": 0.8, "transmissionTexture": {"index": grey},
                },
                "KHR_materials_volume": {"thicknessFactor": 0.2, "thicknessTexture": {"index": color}},
                "KHR_materials_iridescence": {
                    "iridescenceFactor": 1.0, "iridescenceThicknessTexture": {"index": rough},
                },
                "KHR_materials_anisotropy": {
                    "anisotropyStrength": 0.7, "anisotropyTexture": {"index": wide},
                },
            },
        }),
        plain(bmp),
    ];
    materials.extend((0..5).map(|k| plain(sampled(k))));
    let shapes: [&Value; 4] = [&near, &far, &ball, &spot];
    for (number, material) in materials.into_iter().enumerate() {
        let material = model.material(material);
        for (row, shape) in shapes.iter().enumerate() {
            let at = [number as f64 * 0.9 - 4.5, row as f64 * 0.9 - 1.3, (number % 3) as f64 * -0.4];
            model.show(shape, material, at, 0.42);
        }
    }
    model.file()
}

fn load(bytes: &[u8], textures: TextureLoading) -> Loaded {
    let (limits, jobs) = (Limits::default(), Jobs::new(2));
    let context = Context { resolver: &MemoryResolver::default(), limits: &limits, jobs: &jobs };
    let options = LoadOptions::default().with_textures(textures);
    load_bytes_with(bytes, Some(Format::Glb), &options, &context).unwrap()
}

fn scene(bytes: &[u8], textures: TextureLoading) -> Scene {
    let loaded = load(bytes, textures);
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    loaded.scene
}

/// Views of a scene, from far to near and from all sides.
fn cameras(scene: &Scene) -> Vec<Camera> {
    let whole = Framing::automatic(scene).camera(scene);
    let [x, y, z] = whole.eye;
    let moved = |eye, target| Camera::new(eye, target, whole.up, whole.projection, whole.near);
    vec![
        whole,
        moved([x * 6.0, y * 6.0, z * 6.0], whole.target),
        moved([-3.9, -0.4, 0.9], [-4.2, -0.4, -0.2]),
        moved([0.3, 0.1, 1.2], [0.1, 0.6, -0.4]),
        moved([4.0, 2.0, -5.0], [0.0, 0.0, 0.0]),
        moved([-4.4, -1.35, 0.15], [-3.4, -1.2, -0.4]),
    ]
}

fn sized(width: u32, height: u32) -> RenderOptions {
    let mut options = RenderOptions::draft(512, 512);
    (options.width, options.height) = (width, height);
    options
}

/// Options that differ in what they read of textures.
fn options() -> Vec<RenderOptions> {
    let made = |change: fn(&mut RenderOptions)| {
        let mut options = sized(150, 90);
        change(&mut options);
        options
    };
    let mut list = vec![
        made(|_| {}),
        made(|_| {}),
        made(|o| (o.width, o.height, o.samples, o.anisotropy) = (41, 33, 1, 1)),
        made(|o| (o.width, o.height, o.samples, o.anisotropy) = (300, 180, 8, 16)),
        made(|o| (o.shading_rate, o.specular_antialiasing) = (4, true)),
        made(|o| (o.ground, o.background) = (Ground::Shadow, Background::Environment)),
        made(|o| (o.ground, o.ground_reflection, o.samples) = (Ground::Color([128; 3]), 0.6, 1)),
        made(|o| o.aovs = vec![Aov::BaseColor, Aov::Normal]),
        made(|o| (o.width, o.height, o.stage_hashes) = (60, 40, true)),
        sized(40, 30).with_quality(Quality::Best),
    ];
    for shading in [ShadingModel::StackLit, ShadingModel::UrpDesktop, ShadingModel::Filament] {
        let options = sized(150, 90).with_shading(Some(shading));
        list.push(options);
    }
    list
}

#[test]
fn pictures_are_those_of_textures_that_are_decoded_as_a_whole() {
    let file = everything();
    let whole = scene(&file, TextureLoading::Whole);
    // Texels that some pictures have read are kept for those that follow.
    let kept = scene(&file, TextureLoading::ByNeed);
    let (mut first, mut second, mut third) = (Renderer::new(2), Renderer::new(2), Renderer::new(1));
    for (number, options) in options().into_iter().enumerate() {
        // As little as that is mostly decoded without asking.
        if number == 1 {
            second.always_feedback();
            third.always_feedback();
        }
        for (number, camera) in cameras(&whole).iter().enumerate() {
            let expected = first.render(&whole, camera, &options).unwrap();
            let fresh = scene(&file, TextureLoading::ByNeed);
            for (of, drawn) in [
                ("fresh", third.render(&fresh, camera, &options).unwrap()),
                ("kept", second.render(&kept, camera, &options).unwrap()),
            ] {
                let same = drawn.frame.frame_hash() == expected.frame.frame_hash();
                assert!(same, "{of} {number}: {options:?}");
                assert_eq!(drawn.frame.aovs, expected.frame.aovs, "{of} {number}");
                assert_eq!(drawn.stats.stage_hashes, expected.stats.stage_hashes, "{of} {number}");
                assert_eq!(
                    (drawn.stats.fragments, drawn.stats.shading),
                    (expected.stats.fragments, expected.stats.shading)
                );
            }
            assert_eq!(fresh.texture_losses(), [""; 0]);
            for pixel in [[20, 20], [75, 45], [33, 30]]
                .map(|p: [u32; 2]| [p[0] % options.width, p[1] % options.height])
            {
                let fresh = scene(&file, TextureLoading::ByNeed);
                let pick = |renderer: &mut Renderer, scene: &Scene| {
                    renderer
                        .pick(scene, camera, &options, pixel)
                        .unwrap()
                        .map(|hit| (hit.instance, hit.primitive))
                };
                assert_eq!(pick(&mut third, &fresh), pick(&mut first, &whole), "{number} {pixel:?}");
            }
        }
    }
}

/// A material with textures of these files on a near square, and one on its back that another square hides.
fn with_images(files: &[Vec<u8>], roles: &[&str]) -> Vec<u8> {
    let mut model: Model = document();
    let shape = model.shape(&square(1));
    let mut material =
        json!({"pbrMetallicRoughness": {"metallicFactor": 0.0}, "emissiveFactor": [0.3, 0.3, 0.3]});
    for (file, role) in files.iter().zip(roles) {
        let texture = model.texture(file);
        match *role {
            "baseColorTexture" | "metallicRoughnessTexture" => {
                material["pbrMetallicRoughness"][*role] = json!({"index": texture});
            }
            "blend" | "mask" => {
                material["pbrMetallicRoughness"]["baseColorTexture"] = json!({"index": texture});
                material["alphaMode"] = if *role == "mask" { json!("MASK") } else { json!("BLEND") };
            }
            _ => material[*role] = json!({"index": texture}),
        }
    }
    let material = model.material(material);
    model.show(&shape, material, [0.0; 3], 1.0);
    let plain = model.material(json!({"pbrMetallicRoughness": {"baseColorFactor": [0.2, 0.5, 0.8, 1.0]}}));
    model.show(&shape, plain, [1.5, 0.0, -0.5], 1.0);
    model.file()
}

/// The picture, and all that is said of the file once it is drawn.
fn outcome(bytes: &[u8], textures: TextureLoading) -> (String, Vec<String>) {
    let loaded = load(bytes, textures);
    let camera = Framing::automatic(&loaded.scene).camera(&loaded.scene);
    let options = sized(80, 60);
    let mut renderer = Renderer::new(2);
    renderer.always_feedback();
    let drawn = renderer.render(&loaded.scene, &camera, &options).unwrap();
    let mut said: Vec<String> = loaded.warnings.iter().map(ToString::to_string).collect();
    said.extend(loaded.scene.texture_losses());
    said.sort();
    // The second picture is the first, and a picture for a screen is it too.
    let again = renderer.render(&loaded.scene, &camera, &options).unwrap();
    assert_eq!(again.frame.frame_hash(), drawn.frame.frame_hash());
    let shown = renderer.render_image(&loaded.scene, &camera, &options, &DisplayOptions::default()).unwrap();
    let frame = overcoat::frame::DisplayImage::new(&drawn.frame, &DisplayOptions::default());
    assert_eq!(shown.image.pixels, frame.pixels);
    (drawn.frame.frame_hash(), said)
}

#[test]
fn damaged_images_are_drawn_and_told_as_if_they_were_read_at_once() {
    let sound = png(200, 150, 1, Kind::Rgb);
    let alpha = png(200, 150, 2, Kind::Alpha);
    let jpeg = encoded(&picture(200, 150, 3, Kind::Rgb), ImageFormat::Jpeg);
    let webp = encoded(&picture(200, 150, 4, Kind::Alpha), ImageFormat::WebP);
    let changed = |file: &[u8], places: &[usize]| {
        let mut file = file.to_vec();
        places.iter().for_each(|&at| file[at] ^= 0x55);
        file
    };
    let middle = sound.len() / 2;
    let files: Vec<Vec<u8>> = vec![
        sound[..middle].to_vec(),
        sound[..sound.len() - 14].to_vec(),
        sound[..sound.len() - 4].to_vec(),
        sound[..60].to_vec(),
        changed(&sound, &[30]),
        changed(&sound, &[sound.len() - 14]),
        changed(&sound, &[middle]),
        changed(&sound, &[45]),
        [b"junk", &sound[..]].concat(),
        [&sound[..], b"junk"].concat(),
        jpeg[..jpeg.len() / 2].to_vec(),
        changed(&jpeg, &[jpeg.len() / 2]),
        jpeg[..300].to_vec(),
        webp[..webp.len() / 2].to_vec(),
        changed(&webp, &[webp.len() / 2]),
        b"<svg></svg>".to_vec(),
        alpha[..alpha.len() / 3].to_vec(),
        changed(&alpha, &[alpha.len() - 14]),
    ];
    let mut told = 0;
    for (number, file) in files.iter().enumerate() {
        for roles in [
            &["baseColorTexture", "normalTexture"][..],
            &["blend", "occlusionTexture"],
            &["mask", "emissiveTexture"],
            &["emissiveTexture", "metallicRoughnessTexture"],
        ] {
            let bytes = with_images(&[file.clone(), sound.clone()], roles);
            let (whole, by_need) =
                (outcome(&bytes, TextureLoading::Whole), outcome(&bytes, TextureLoading::ByNeed));
            assert_eq!(by_need.1, whole.1, "file {number} as {roles:?}");
            assert_eq!(by_need.0, whole.0, "file {number} as {roles:?}");
            told += whole.1.len();
        }
    }
    assert!(told > files.len() * 3, "{told} lines for {} files", files.len());
}

#[test]
fn what_no_pixel_asks_for_is_not_decoded() {
    let sound = png(200, 150, 1, Kind::Rgb);
    // The header is whole: it is found to be damaged when it is decoded.
    let damaged = sound[..sound.len() / 2].to_vec();
    let bytes = with_images(&[damaged], &["baseColorTexture"]);
    let loaded = load(&bytes, TextureLoading::ByNeed);
    assert!(loaded.warnings.is_empty());
    let scene = &loaded.scene;
    let toward = |x: f32| {
        let mut camera = Framing::automatic(scene).camera(scene);
        (camera.eye, camera.target) = ([x, 0.0, 4.0], [x, 0.0, 0.0]);
        camera
    };
    let options = sized(40, 40);
    let mut renderer = Renderer::new(1);
    renderer.always_feedback();
    renderer.render(scene, &toward(40.0), &options).unwrap();
    assert_eq!(scene.texture_losses(), [""; 0]);
    renderer.render(scene, &toward(0.0), &options).unwrap();
    let losses = scene.texture_losses();
    assert_eq!(losses.len(), 1);
    assert!(losses[0].contains("image 0 (material 0: baseColorTexture): only "), "{losses:?}");
    // Whoever asks for the texels themselves gets them.
    assert_eq!(scene.textures()[0].image().width(), 200);
}

/// A sphere of one roughness, with what else asks for levels of its own.
fn sphere_under(environment: &Environment, number: usize) -> Scene {
    let mut material = Material::default().with(|m| m.base_color = [0.7, 0.6, 0.5, 1.0]);
    let roughness = [0.0, 0.07, 0.2, 0.45, 0.7, 1.0][number % 6];
    material.workflow = Workflow::MetallicRoughness { metallic: 0.5, roughness, texture: None };
    match number / 6 {
        0 => {}
        1 => (material.coat, material.coat_roughness) = (1.0, 0.3),
        2 => (material.lobes.sheen.color, material.lobes.sheen.roughness) = ([0.8; 3].into(), 0.4.into()),
        3 => material.lobes.anisotropy.strength = 0.9,
        _ => {
            (material.lobes.second.mix, material.lobes.second.roughness) = (0.4.into(), 0.9.into());
            (material.coat, material.coat_roughness, material.lobes.coat.ior) = (1.0, 0.5, 2.0);
        }
    }
    let mut scene = Scene::new();
    let mesh = scene.add_mesh(Mesh::new(sphere(24)).unwrap()).unwrap();
    let material = scene.add_material(material).unwrap();
    scene.add_instance(Instance::new(mesh, material, Transform::IDENTITY)).unwrap();
    scene.set_environment(environment.clone()).unwrap();
    scene
}

#[test]
fn pictures_are_those_of_environments_that_are_filtered_at_every_roughness() {
    let picture = Arc::new(sky().unwrap());
    let source = EnvironmentSource::Image(Arc::clone(&picture));
    let environment = Environment::default().with(|e| {
        e.source = source;
        e.rotation_degrees = 40.0;
        e.intensity = 1.5;
    });
    let (mut whole, mut kept) = (Renderer::new(2), Renderer::new(2));
    let filtered = PrefilteredEnvironment::new(&picture, whole.jobs(), SimdLevel::best());
    whole.use_environment(Some(Arc::new(filtered)));
    let models = ShadingModel::ALL.iter().filter(|model| model.is_built());
    for (round, &shading) in models.enumerate() {
        for number in 0..30 {
            let scene = sphere_under(&environment, number);
            let camera = Framing::automatic(&scene).camera(&scene);
            let mut options = sized(24, 24).with_shading(Some(shading));
            if (round + number) % 2 == 0 {
                options = options.with_quality(Quality::Draft);
            }
            options.specular_antialiasing = number % 5 == 4;
            let expected = whole.render(&scene, &camera, &options).unwrap().frame.frame_hash();
            let fresh = Renderer::new(1).render(&scene, &camera, &options).unwrap().frame.frame_hash();
            assert_eq!(fresh, expected, "{shading:?} {number}");
            // Lookups of some pictures are kept for those that follow.
            let kept = kept.render(&scene, &camera, &options).unwrap().frame.frame_hash();
            assert_eq!(kept, expected, "kept: {shading:?} {number}");
        }
    }
}
