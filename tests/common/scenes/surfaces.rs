//! Materials and textures as the keys of glTF files describe them.

use super::Entry;
use crate::common::files::document::document;
use crate::common::files::model::{Model, U8, U16, push};
use crate::common::files::{encoded, png};
use crate::common::images::{bumps, checker, image, letter_f};
use crate::common::shapes::{sphere, square, surface};
use crate::common::stage::{Built, Stage, flat_view};
use overcoat::load::LoadOptions;
use overcoat::scene::{Light, LightKind, MeshData, Transform};
use serde_json::{Value, json};
use std::f32::consts::FRAC_PI_2;

pub const SCENES: &[Entry] = &[
    ("gltf-materials", materials),
    ("gltf-glass", glass),
    ("gltf-texture-channels", channels),
    ("gltf-texture-coordinates", coordinates),
];

/// A material of metallic-roughness numbers, and extensions.
fn material(color: [f32; 3], metallic: f32, roughness: f32, extensions: Value) -> Value {
    let [r, g, b] = color;
    json!({
        "pbrMetallicRoughness": {
            "baseColorFactor": [r, g, b, 1.0], "metallicFactor": metallic, "roughnessFactor": roughness,
        },
        "extensions": extensions,
    })
}

/// The scene of a document, lit.
fn shown(model: &mut Model) -> Built {
    let mut s = Stage::new()?;
    let sky = s.scene.environment().clone();
    s.scene = model.finish(&LoadOptions::default())?;
    s.scene.set_environment(sky)?;
    s.key_light(2.0)?;
    s.seen(flat_view())
}

/// Row by row: dielectric, metal, coat, rough coat, sheen; anisotropy, the same turned, iridescence on plastic and on metal,
/// specular 0; specular colour, index 2.4, index 1, emission of strength 4, unlit; specular-glossiness dull, shiny, as a
/// metal, with emission, and beside a metallic-roughness substitute that must not show.
fn materials() -> Built {
    let mut model = document();
    let mut ball = sphere(32);
    ball.uvs[0].clear();
    let ball = model.shape(&ball);
    let (red, blue, gold, dark) = ([0.6, 0.05, 0.03], [0.05, 0.1, 0.5], [0.9, 0.7, 0.35], [0.02, 0.02, 0.03]);
    let glossy = |diffuse: [f32; 3], specular: [f32; 3], glossiness: f32| {
        let [r, g, b] = diffuse;
        json!({"KHR_materials_pbrSpecularGlossiness": {
            "diffuseFactor": [r, g, b, 1.0], "specularFactor": specular, "glossinessFactor": glossiness,
        }})
    };
    let film = json!({"KHR_materials_iridescence": {
        "iridescenceFactor": 1, "iridescenceIor": 1.4,
        "iridescenceThicknessMinimum": 100, "iridescenceThicknessMaximum": 350,
    }});
    let mut list = vec![
        material(red, 0.0, 0.3, json!({})),
        material(gold, 1.0, 0.3, json!({})),
        material(red, 0.0, 0.9, json!({"KHR_materials_clearcoat": {"clearcoatFactor": 1}})),
        material(
            red,
            0.0,
            0.9,
            json!({"KHR_materials_clearcoat": {"clearcoatFactor": 1, "clearcoatRoughnessFactor": 0.5}}),
        ),
        material(
            dark,
            0.0,
            0.9,
            json!({"KHR_materials_sheen": {"sheenColorFactor": [0.2, 0.9, 0.4], "sheenRoughnessFactor": 0.4}}),
        ),
        material(gold, 1.0, 0.4, json!({"KHR_materials_anisotropy": {"anisotropyStrength": 0.8}})),
        material(
            gold,
            1.0,
            0.4,
            json!({"KHR_materials_anisotropy": {"anisotropyStrength": 0.8, "anisotropyRotation": FRAC_PI_2}}),
        ),
        material(dark, 0.0, 0.2, film.clone()),
        material([0.8; 3], 1.0, 0.2, film),
        material(blue, 0.0, 0.2, json!({"KHR_materials_specular": {"specularFactor": 0}})),
        material(dark, 0.0, 0.2, json!({"KHR_materials_specular": {"specularColorFactor": [8, 1, 0.2]}})),
        material(blue, 0.0, 0.2, json!({"KHR_materials_ior": {"ior": 2.4}})),
        material(blue, 0.0, 0.2, json!({"KHR_materials_ior": {"ior": 1}})),
        material(dark, 0.0, 0.5, json!({"KHR_materials_emissive_strength": {"emissiveStrength": 4}})),
        material([0.9, 0.3, 0.1], 0.0, 0.5, json!({"KHR_materials_unlit": {}})),
        material([1.0; 3], 1.0, 1.0, glossy(blue, [0.04; 3], 0.2)),
        material([1.0; 3], 1.0, 1.0, glossy(blue, [0.3; 3], 0.9)),
        material([1.0; 3], 1.0, 1.0, glossy([0.0; 3], gold, 0.8)),
        material([1.0; 3], 1.0, 1.0, glossy(dark, [0.04; 3], 0.5)),
        material([0.0, 1.0, 0.0], 0.0, 1.0, glossy(red, [0.04; 3], 0.7)),
    ];
    list[13]["emissiveFactor"] = json!([0.4, 0.1, 0.02]);
    list[18]["emissiveFactor"] = json!([0.05, 0.2, 0.3]);
    for (k, material) in list.into_iter().enumerate() {
        let material = model.material(material);
        model.show(&ball, material, [0.5 * (k % 5) as f64 - 1.0, 0.75 - 0.5 * (k / 5) as f64, 0.0], 0.235);
    }
    shown(&mut model)
}

/// Before a wall: a thin wall of glass, rough glass, a solid ball, one that absorbs; tinted glass, strong dispersion, and
/// paper that lets light through without and with a colour, lit from behind.
fn glass() -> Built {
    let mut model = document();
    let mut ball = sphere(32);
    ball.tangents.clear();
    let ball = model.shape(&ball);
    let mut wall = square(1);
    wall.tangents.clear();
    let wall = model.shape(&wall);
    let squares = model.texture(&png(&checker(64, 16, [[235, 235, 225], [40, 60, 110]])?)?);
    let behind = model.material(json!({
        "extensions": {"KHR_materials_unlit": {}},
        "pbrMetallicRoughness": {"baseColorTexture": {"index": squares}},
    }));
    model.show(&wall, behind, [0.0, 0.0, -3.0], 2.5);
    let clear = json!({"transmissionFactor": 1});
    let solid = |thickness: f32| json!({"thicknessFactor": thickness});
    let white = [1.0; 3];
    let list = [
        material(white, 0.0, 0.0, json!({"KHR_materials_transmission": clear})),
        material(white, 0.0, 0.35, json!({"KHR_materials_transmission": clear})),
        material(
            white,
            0.0,
            0.0,
            json!({"KHR_materials_transmission": clear, "KHR_materials_volume": solid(1.5)}),
        ),
        material(
            white,
            0.0,
            0.0,
            json!({"KHR_materials_transmission": clear, "KHR_materials_volume": {
                "thicknessFactor": 1.5, "attenuationDistance": 0.5, "attenuationColor": [0.9, 0.4, 0.1],
            }}),
        ),
        material(
            [0.3, 0.9, 0.4],
            0.0,
            0.0,
            json!({"KHR_materials_transmission": {"transmissionFactor": 0.8}}),
        ),
        material(
            white,
            0.0,
            0.0,
            json!({
                "KHR_materials_transmission": clear, "KHR_materials_volume": solid(1.5),
                "KHR_materials_ior": {"ior": 1.4}, "KHR_materials_dispersion": {"dispersion": 8},
            }),
        ),
        material(
            [0.7; 3],
            0.0,
            0.9,
            json!({"KHR_materials_diffuse_transmission": {"diffuseTransmissionFactor": 0.8}}),
        ),
        material(
            [0.7; 3],
            0.0,
            0.9,
            json!({"KHR_materials_diffuse_transmission": {
                "diffuseTransmissionFactor": 0.8, "diffuseTransmissionColorFactor": [0.9, 0.2, 0.1],
            }}),
        ),
    ];
    for (k, material) in list.into_iter().enumerate() {
        let material = model.material(material);
        model.show(&ball, material, [(k % 4) as f64 - 1.5, 0.5 - (k / 4) as f64, 0.0], 0.45);
    }
    let (mut scene, camera) = shown(&mut model)?;
    scene.add_light(Light::new(LightKind::Directional { direction: [0.6, -0.35, 0.72] }).with(|l| {
        l.color = [1.0; 3];
        l.intensity = 1.0;
    }))?;
    Ok((scene, camera))
}

/// A square that bulges, so that every direction of the sky is mirrored somewhere.
fn dome() -> MeshData {
    surface(10, 10, |u, v| {
        let [x, y] = [2.0 * u - 1.0, 1.0 - 2.0 * v];
        let z = (2.6 - x * x - y * y).sqrt();
        let length = 2.6_f64.sqrt();
        let normal = [x / length, y / length, z / length];
        let along = (z * z + x * x).sqrt();
        ([x, y, z - 1.6], normal, [z / along, 0.0, -x / along])
    })
}

/// Every place for a texture. Textures of numbers have another pattern in each channel: red is the left half, green the
/// upper half, blue one of the diagonal halves, alpha a disc; so each place shows what it reads. Row by row: metallic and
/// roughness, occlusion, coat, roughness of the coat, normals of the coat; normals, colour and roughness of the sheen,
/// anisotropy, iridescence; thickness of its film, specular, its colour, transmission, thickness; diffuse transmission and
/// its colour, emission, diffuse and specular-glossiness.
fn channels() -> Built {
    let mut model = document();
    let dome = model.shape(&dome());
    let numbers = image(16, 16, |x, y| {
        let [dx, dy] = [x, y].map(|v| 2 * v as i32 - 15);
        let on = [x < 8, y < 8, x > y, dx * dx + dy * dy < 81];
        on.map(|on| if on { 255 } else { 40 })
    })?;
    let colors = image(16, 16, |x, y| match (x < 8, y < 8) {
        (true, true) => [255, 60, 40, 255],
        (false, true) => [60, 220, 60, 255],
        (true, false) => [50, 80, 255, 255],
        (false, false) => [250, 250, 250, 255],
    })?;
    // A direction in red and green that turns, a strength in blue that grows to the right.
    let directions = image(16, 16, |x, y| match y < 8 {
        true => [255, 128, (x * 17) as u8, 255],
        false => [128, 255, (x * 17) as u8, 255],
    })?;
    let mut info = |picture| -> Result<Value, Box<dyn std::error::Error>> {
        Ok(json!({"index": model.texture(&png(picture)?)}))
    };
    let (n, c, d) = (&info(&numbers)?, &info(&colors)?, &info(&directions)?);
    let b = &info(&bumps(32, 1)?)?;
    let (red, gold, dark, white) = ([0.6, 0.05, 0.03], [0.9, 0.7, 0.35], [0.02, 0.02, 0.03], [1.0; 3]);
    let coat = |key: &str, texture: &Value| {
        let roughness = match key {
            "clearcoatRoughnessTexture" => 1.0,
            // Highlights on bumps of a few pixels would be specks.
            "clearcoatNormalTexture" => 0.4,
            _ => 0.1,
        };
        let mut coat = json!({"clearcoatFactor": 1, "clearcoatRoughnessFactor": roughness});
        coat[key] = texture.clone();
        material(red, 0.0, 0.9, json!({"KHR_materials_clearcoat": coat}))
    };
    let film = |key: &str| {
        let mut film = json!({
            "iridescenceFactor": 1, "iridescenceThicknessMinimum": 200, "iridescenceThicknessMaximum": 500,
        });
        film[key] = n.clone();
        material([0.6; 3], 1.0, 0.2, json!({"KHR_materials_iridescence": film}))
    };
    let clear = |color: [f32; 3], transmission: Value, volume: Value| {
        material(
            color,
            0.0,
            0.0,
            json!({"KHR_materials_transmission": transmission, "KHR_materials_volume": volume}),
        )
    };
    let paper = |key: &str, texture: &Value| {
        let mut paper = json!({"diffuseTransmissionFactor": 1});
        paper[key] = texture.clone();
        material([0.1; 3], 0.0, 0.9, json!({"KHR_materials_diffuse_transmission": paper}))
    };
    let mut metal_and_rough = material(gold, 1.0, 1.0, json!({}));
    metal_and_rough["pbrMetallicRoughness"]["metallicRoughnessTexture"] = n.clone();
    let mut occluded = material(white, 0.0, 0.9, json!({}));
    occluded["occlusionTexture"] = n.clone();
    let mut bumpy = material(gold, 1.0, 0.5, json!({}));
    bumpy["normalTexture"] = b.clone();
    let mut glowing = material(dark, 0.0, 0.9, json!({}));
    glowing["emissiveTexture"] = c.clone();
    glowing["emissiveFactor"] = json!([0.6, 0.6, 0.6]);
    let list = [
        metal_and_rough,
        occluded,
        coat("clearcoatTexture", n),
        coat("clearcoatRoughnessTexture", n),
        coat("clearcoatNormalTexture", b),
        bumpy,
        material(
            dark,
            0.0,
            0.9,
            json!({"KHR_materials_sheen": {
                "sheenColorFactor": white, "sheenRoughnessFactor": 0.5, "sheenColorTexture": c,
            }}),
        ),
        material(
            dark,
            0.0,
            0.9,
            json!({"KHR_materials_sheen": {
                "sheenColorFactor": white, "sheenRoughnessFactor": 1, "sheenRoughnessTexture": n,
            }}),
        ),
        material(
            gold,
            1.0,
            0.4,
            json!({"KHR_materials_anisotropy": {"anisotropyStrength": 1, "anisotropyTexture": d}}),
        ),
        film("iridescenceTexture"),
        film("iridescenceThicknessTexture"),
        material(
            dark,
            0.0,
            0.1,
            json!({"KHR_materials_specular": {"specularTexture": n}, "KHR_materials_ior": {"ior": 2.2}}),
        ),
        material(
            dark,
            0.0,
            0.1,
            json!({"KHR_materials_specular": {"specularColorTexture": c}, "KHR_materials_ior": {"ior": 2.2}}),
        ),
        clear(red, json!({"transmissionFactor": 1, "transmissionTexture": n}), json!({})),
        clear(
            white,
            json!({"transmissionFactor": 1}),
            json!({
                "thicknessFactor": 1, "thicknessTexture": n,
                "attenuationDistance": 0.3, "attenuationColor": [0.2, 0.5, 0.9],
            }),
        ),
        paper("diffuseTransmissionTexture", n),
        paper("diffuseTransmissionColorTexture", c),
        glowing,
        material(
            dark,
            0.0,
            1.0,
            json!({"KHR_materials_pbrSpecularGlossiness": {
                "diffuseTexture": c, "specularFactor": [0.04, 0.04, 0.04], "glossinessFactor": 0.3,
            }}),
        ),
        material(
            dark,
            0.0,
            1.0,
            json!({"KHR_materials_pbrSpecularGlossiness": {
                "diffuseFactor": [0.02, 0.02, 0.02, 1], "specularGlossinessTexture": n,
            }}),
        ),
    ];
    let wall = square(1);
    let wall = model.shape(&wall.with(|d| d.tangents = Vec::new()));
    let behind = model.material(json!({
        "extensions": {"KHR_materials_unlit": {}},
        "pbrMetallicRoughness": {"baseColorFactor": [0.5, 0.5, 0.45, 1]},
    }));
    model.show(&wall, behind, [0.0, 0.0, -2.0], 2.0);
    for (k, material) in list.into_iter().enumerate() {
        let material = model.material(material);
        model.show(&dome, material, [0.5 * (k % 5) as f64 - 1.0, 0.75 - 0.5 * (k / 5) as f64, 0.0], 0.23);
    }
    let (mut scene, camera) = shown(&mut model)?;
    scene.add_light(Light::new(LightKind::Directional { direction: [0.1, -0.2, 0.97] }).with(|l| {
        l.color = [1.0; 3];
        l.intensity = 3.0;
    }))?;
    Ok((scene, camera))
}

/// Upper row: a letter as it is, moved by a quarter, turned by 30 degrees, doubled, all of these, in the second set of
/// coordinates. Middle row: the second set by the transform, whole numbers as coordinates, WebP, clamped, mirrored,
/// nearest texel. Lower row: vertex colours as floats, as bytes, with alpha, times a texture, times a factor, and none.
fn coordinates() -> Built {
    let mut model = document();
    let mut mesh = square(2);
    mesh.tangents.clear();
    let plain = model.shape(&mesh);
    mesh.uvs[1] = mesh.uvs[0].iter().map(|&[u, v]| [1.0 - u, 0.5 * v]).collect();
    let two_sets = model.shape(&mesh);
    let mut whole = plain.clone();
    let short: Vec<[u8; 4]> = mesh.uvs[0]
        .iter()
        .map(|uv| {
            let [[a, b], [c, d]] = uv.map(|v| ((v * 65535.0) as u16).to_le_bytes());
            [a, b, c, d]
        })
        .collect();
    whole["attributes"]["TEXCOORD_0"] = model.packed("VEC2", U16, true, &short).into();
    let letter = letter_f()?;
    let texture = model.texture(&png(&letter)?);
    let webp = model.texture_of("EXT_texture_webp", &encoded(&letter, ::image::ImageFormat::WebP)?);
    let mut sampled = |sampler: Value| {
        let sampler = match model.json.get_mut("samplers") {
            Some(list) => push(list, sampler),
            None => {
                model.json["samplers"] = json!([sampler]);
                0
            }
        };
        push(&mut model.json["textures"], json!({"source": 0, "sampler": sampler}))
    };
    let clamped = sampled(json!({"wrapS": 33071, "wrapT": 33071}));
    let mirrored = sampled(json!({"wrapS": 33648, "wrapT": 33648}));
    let nearest = sampled(json!({"magFilter": 9728, "minFilter": 9728}));
    let moved =
        |transform: Value| json!({"index": texture, "extensions": {"KHR_texture_transform": transform}});
    let beyond = json!({"KHR_texture_transform": {"scale": [2, 2], "offset": [-0.5, -0.5]}});
    let doubled = |index: usize| json!({"index": index, "extensions": beyond});
    let turn = std::f32::consts::FRAC_PI_6;
    let textured = [
        (&plain, json!({"index": texture})),
        (&plain, moved(json!({"offset": [0.25, 0.125]}))),
        (&plain, moved(json!({"rotation": turn}))),
        (&plain, moved(json!({"scale": [2, 2]}))),
        (&plain, moved(json!({"offset": [0.25, 0.125], "rotation": turn, "scale": [2, 1]}))),
        (&two_sets, json!({"index": texture, "texCoord": 1})),
        (&two_sets, moved(json!({"texCoord": 1, "offset": [0, 0.5]}))),
        (&whole, json!({"index": texture})),
        (&plain, json!({"index": webp})),
        (&plain, doubled(clamped)),
        (&plain, doubled(mirrored)),
        (&plain, json!({"index": nearest})),
    ];
    let unlit = |color: [f32; 4], texture: Option<Value>| {
        let factor = json!({"baseColorFactor": color});
        let mut material = json!({"extensions": {"KHR_materials_unlit": {}}, "pbrMetallicRoughness": factor});
        if let Some(texture) = texture {
            material["pbrMetallicRoughness"]["baseColorTexture"] = texture;
        }
        material
    };
    let mut tiles: Vec<(Value, Value)> = Vec::new();
    for (primitive, texture) in textured {
        tiles.push((primitive.clone(), unlit([1.0; 4], Some(texture))));
    }
    // Red to the right, green upwards, transparent at the left edge.
    let colors: Vec<[f32; 4]> = mesh
        .positions
        .iter()
        .map(|p| [(p[0] + 1.0) * 0.5, (p[1] + 1.0) * 0.5, 0.1, (p[0] + 1.0) * 0.5])
        .collect();
    let opaque: Vec<[f32; 3]> = colors.iter().map(|c| [c[0], c[1], c[2]]).collect();
    let three: Vec<[u8; 3]> = opaque.iter().map(|c| c.map(|v| (v * 255.0) as u8)).collect();
    let four: Vec<[u8; 4]> = colors.iter().map(|c| c.map(|v| (v * 255.0) as u8)).collect();
    let with = |accessor: usize| {
        let mut primitive = plain.clone();
        primitive["attributes"]["COLOR_0"] = accessor.into();
        primitive
    };
    let floats = model.vectors(&opaque);
    let bytes = model.packed("VEC3", U8, true, &three);
    let alpha = model.packed("VEC4", U8, true, &four);
    let mut blended = unlit([1.0; 4], None);
    blended["alphaMode"] = "BLEND".into();
    tiles.push((with(floats), unlit([1.0; 4], None)));
    tiles.push((with(bytes), unlit([1.0; 4], None)));
    tiles.push((with(alpha), blended));
    tiles.push((with(floats), unlit([1.0; 4], Some(json!({"index": texture})))));
    tiles.push((with(floats), unlit([0.2, 1.0, 1.0, 1.0], None)));
    tiles.push((plain.clone(), unlit([0.2, 0.5, 0.9, 1.0], None)));
    for (k, (primitive, material)) in tiles.into_iter().enumerate() {
        let material = model.material(material);
        model.show(&primitive, material, [(k % 6) as f64 - 2.5, 1.0 - (k / 6) as f64, 0.0], 0.45);
    }
    let mut s = Stage::dark()?;
    let place = Transform::from_parts([0.0; 3], [0.0, 0.0, 0.0, 1.0], [2.0 / 3.0; 3])?;
    s.add(&model.finish(&LoadOptions::default())?, place)?;
    s.seen(flat_view())
}
