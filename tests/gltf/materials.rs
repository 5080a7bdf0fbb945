//! Materials, textures and extensions.

use crate::common::files::model::{Model, messages, picture, push};
use overcoat::limits::Limits;
use overcoat::load::LoadError;
use overcoat::scene::{
    AlphaMode, CoatMedium, ColorSpace, Filter, Lobes, Material, MipFilter, Sampler, ScalarParameter,
    Transmission, UvTransform, Workflow, Wrap,
};
use serde_json::{Value, json};

/// The scene's material for this one of the file, which must give no warning.
fn material(given: Value) -> Material {
    let mut model = Model::textured();
    model.json["materials"] = json!([given]);
    let loaded = model.load().unwrap();
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    loaded.scene.materials()[0].clone()
}

/// Coats of the specification do not darken.
fn plain_lobes() -> Lobes {
    Lobes::default().with(|l| l.coat = CoatMedium::default().with(|c| c.darkening = 0.0))
}

#[test]
fn defaults_are_those_of_the_specification() {
    let expected = Material::default().with(|m| {
        m.workflow = Workflow::MetallicRoughness { metallic: 1.0, roughness: 1.0, texture: None };
        m.lobes = plain_lobes();
    });
    assert_eq!(material(json!({})), expected);
    assert_eq!(material(json!({"pbrMetallicRoughness": {}})), expected);
    // A primitive without a material, in a file that has one for others.
    let mut model = Model::triangle();
    model.json["materials"] = json!([{"name": "of nothing"}]);
    assert_eq!(model.load().unwrap().scene.materials(), [expected]);
    assert_eq!(material(json!({"alphaMode": "MASK"})).alpha_mode, AlphaMode::Mask { cutoff: 0.5 });
    let coat = material(json!({"extensions": {"KHR_materials_clearcoat": {}}}));
    assert_eq!((coat.coat, coat.coat_roughness), (0.0, 0.0));
    let glossy = material(json!({"extensions": {"KHR_materials_pbrSpecularGlossiness": {}}}));
    let expected = Workflow::SpecularGlossiness { specular: [1.0; 3], glossiness: 1.0, texture: None };
    assert_eq!((glossy.workflow, glossy.base_color), (expected, [1.0; 4]));
}

/// Nobody who writes no material means a rough white metal.
#[test]
fn files_without_any_material_are_of_clay() {
    let clay = Model::triangle().load().unwrap().scene.materials().to_vec();
    let [Material { base_color, workflow: Workflow::MetallicRoughness { metallic, roughness, .. }, .. }] =
        clay[..]
    else {
        panic!("{clay:?}")
    };
    assert!(metallic == 0.0 && (0.4..0.8).contains(&roughness), "{clay:?}");
    assert!(base_color[..3].iter().all(|c| (0.3..0.6).contains(c)) && base_color[3] == 1.0, "{clay:?}");

    // Colours of vertices are not tinted by it.
    let mut model = Model::triangle();
    let colors = model.floats("VEC3", &[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]);
    let mut other = model.primitive().clone();
    model.primitive()["attributes"]["COLOR_0"] = colors.into();
    let list = model.json["meshes"][0]["primitives"].as_array_mut().unwrap();
    list.push(std::mem::take(&mut other));
    let scene = model.load().unwrap().scene;
    let found: Vec<[f32; 4]> =
        scene.instances().iter().map(|i| scene.materials()[i.material.index()].base_color).collect();
    assert_eq!(found, [[1.0; 4], base_color]);
}

#[test]
fn every_factor_arrives() {
    let m = material(json!({
        "name": "everything",
        "doubleSided": true,
        "alphaMode": "MASK",
        "alphaCutoff": 0.25,
        "pbrMetallicRoughness": {
            "baseColorFactor": [0.1, 0.2, 0.3, 0.4], "metallicFactor": 0.5, "roughnessFactor": 0.6,
        },
        "emissiveFactor": [0.5, 0.25, 1.0],
        "extensions": {
            "KHR_materials_clearcoat": {"clearcoatFactor": 0.7, "clearcoatRoughnessFactor": 0.8},
            "KHR_materials_ior": {"ior": 1.8},
            "KHR_materials_specular": {"specularFactor": 0.9, "specularColorFactor": [2.0, 0.5, 0.25]},
            "KHR_materials_emissive_strength": {"emissiveStrength": 8},
            "KHR_materials_unlit": {},
        },
    }));
    let expected = Material::default().with(|m| {
        m.name = "everything".to_owned();
        m.double_sided = true;
        m.alpha_mode = AlphaMode::Mask { cutoff: 0.25 };
        m.base_color = [0.1, 0.2, 0.3, 0.4];
        m.workflow = Workflow::MetallicRoughness { metallic: 0.5, roughness: 0.6, texture: None };
        m.emissive = [4.0, 2.0, 8.0];
        m.coat = 0.7;
        m.coat_roughness = 0.8;
        m.ior = 1.8;
        m.specular = 0.9;
        m.specular_color = [2.0, 0.5, 0.25];
        m.unlit = true;
        m.lobes = plain_lobes();
    });
    assert_eq!(m, expected);
    assert_eq!(material(json!({"extensions": {"KHR_materials_ior": {"ior": 0}}})).ior, 0.0);
}

/// Transmission and volume: defaults of the specification, factors, and channels of the textures.
#[test]
fn transmission_and_volume() {
    let through = |extensions: Value| material(json!({"extensions": extensions})).lobes.transmission;
    let none = Transmission::default();
    assert_eq!(
        through(json!({
            "KHR_materials_transmission": {}, "KHR_materials_volume": {}, "KHR_materials_dispersion": {},
            "KHR_materials_diffuse_transmission": {},
        })),
        none
    );
    let all = through(json!({
        "KHR_materials_transmission": {"transmissionFactor": 0.9},
        "KHR_materials_volume": {
            "thicknessFactor": 2.5, "attenuationDistance": 0.5, "attenuationColor": [0.1, 0.2, 0.3],
        },
        "KHR_materials_dispersion": {"dispersion": 0.4},
        "KHR_materials_diffuse_transmission": {
            "diffuseTransmissionFactor": 0.6, "diffuseTransmissionColorFactor": [0.5, 0.6, 0.7],
        },
    }));
    let scalar = |factor: f32, channel: u8| ScalarParameter { factor, texture: None, channel };
    let expected = Transmission::default().with(|t| {
        t.factor = scalar(0.9, 0);
        t.diffuse = scalar(0.6, 3);
        t.diffuse_color = [0.5, 0.6, 0.7].into();
        t.thickness = scalar(2.5, 1);
        t.attenuation_color = [0.1, 0.2, 0.3];
        t.attenuation_distance = 0.5;
        t.dispersion = 0.4;
    });
    assert_eq!(all, expected);
    let texture = json!({"index": 0});
    let textured = through(json!({
        "KHR_materials_transmission": {"transmissionTexture": texture},
        "KHR_materials_volume": {"thicknessTexture": texture},
        "KHR_materials_diffuse_transmission": {
            "diffuseTransmissionTexture": texture, "diffuseTransmissionColorTexture": texture,
        },
    }));
    assert!(textured.factor.texture.is_some() && textured.thickness.texture.is_some());
    assert!(textured.diffuse.texture.is_some() && textured.diffuse_color.texture.is_some());
    // Colours are sRGB, numbers are not.
    assert_ne!(textured.diffuse.texture.unwrap().texture, textured.diffuse_color.texture.unwrap().texture);
}

/// Both workflows in one material: the one of the extension is drawn.
#[test]
fn specular_glossiness() {
    let m = material(json!({
        "pbrMetallicRoughness": {"baseColorFactor": [1, 0, 0, 1], "baseColorTexture": {"index": 0}},
        "alphaMode": "BLEND",
        "extensions": {"KHR_materials_pbrSpecularGlossiness": {
            "diffuseFactor": [0.1, 0.2, 0.3, 0.4], "specularFactor": [0.5, 0.6, 0.7], "glossinessFactor": 0.25,
        }},
    }));
    assert_eq!((m.base_color, m.base_color_texture), ([0.1, 0.2, 0.3, 0.4], None));
    let expected =
        Workflow::SpecularGlossiness { specular: [0.5, 0.6, 0.7], glossiness: 0.25, texture: None };
    assert_eq!((m.workflow, m.alpha_mode), (expected, AlphaMode::Blend));
    // The substitute's texture is not even looked for.
    let mut model = Model::textured();
    model.json["images"][0] = json!({"uri": "gone.png"});
    model.json["materials"][0]["extensions"] = json!({"KHR_materials_pbrSpecularGlossiness": {}});
    assert!(model.warnings().is_empty());
}

#[test]
fn every_texture_slot_has_its_colour_space() {
    let t = json!({"index": 0});
    let mut model = Model::textured();
    model.json["materials"] = json!([{
        "pbrMetallicRoughness": {"baseColorTexture": t, "metallicRoughnessTexture": t},
        "normalTexture": {"index": 0, "scale": -0.5},
        "occlusionTexture": {"index": 0, "strength": 0.75},
        "emissiveTexture": t,
        "extensions": {
            "KHR_materials_clearcoat": {
                "clearcoatTexture": t, "clearcoatRoughnessTexture": t,
                "clearcoatNormalTexture": {"index": 0, "scale": 2},
            },
            "KHR_materials_specular": {"specularTexture": t, "specularColorTexture": t},
        },
    }]);
    let scene = model.load().unwrap().scene;
    let m = &scene.materials()[0];
    assert_eq!(m.textures().count(), 10);
    // One image in three forms: colours, numbers and normals.
    assert_eq!(scene.textures().len(), 3);
    let space = |t: &overcoat::scene::TextureRef| scene.textures()[t.texture.index()].color_space();
    let Workflow::MetallicRoughness { texture: Some(metallic_roughness), .. } = &m.workflow else { panic!() };
    for (slot, expected) in [
        (m.base_color_texture.as_ref(), ColorSpace::Srgb),
        (m.emissive_texture.as_ref(), ColorSpace::Srgb),
        (m.specular_color_texture.as_ref(), ColorSpace::Srgb),
        (Some(metallic_roughness), ColorSpace::Linear),
        (m.occlusion_texture.as_ref(), ColorSpace::Linear),
        (m.specular_texture.as_ref(), ColorSpace::Linear),
        (m.coat_texture.as_ref(), ColorSpace::Linear),
        (m.coat_roughness_texture.as_ref(), ColorSpace::Linear),
        (m.normal_texture.as_ref().map(|n| &n.texture), ColorSpace::Linear),
        (m.coat_normal_texture.as_ref().map(|n| &n.texture), ColorSpace::Linear),
    ] {
        assert_eq!(space(slot.unwrap()), expected);
    }
    assert_eq!((m.normal_texture.unwrap().scale, m.coat_normal_texture.unwrap().scale), (-0.5, 2.0));
    assert_eq!(m.occlusion_strength, 0.75);
    let texels: Vec<[u8; 4]> = scene.textures()[0].levels().next().unwrap().texels.to_vec();
    assert_eq!(texels, [[255, 0, 0, 128], [0, 255, 0, 255]]);
}

/// With alpha as coverage, the transparent red counts half in the average; elsewhere it counts whole.
#[test]
fn alpha_weighs_colours_where_it_is_coverage() {
    let smallest = |mode: &str| {
        let mut model = Model::textured();
        model.json["materials"][0]["alphaMode"] = mode.into();
        let scene = model.load().unwrap().scene;
        scene.textures()[0].levels().last().unwrap().texels[0]
    };
    let opaque = smallest("OPAQUE");
    assert_eq!(opaque[0], opaque[1]);
    for mode in ["MASK", "BLEND"] {
        let covered = smallest(mode);
        assert!(covered[1] > covered[0], "{covered:?}");
    }
}

#[test]
fn samplers() {
    let read = |sampler: Value| {
        let mut model = Model::textured();
        model.json["samplers"] = json!([sampler]);
        model.json["textures"] = json!([{"source": 0, "sampler": 0}]);
        let loaded = model.load().unwrap();
        (*loaded.scene.textures()[0].sampler(), messages(&loaded))
    };
    assert_eq!(read(json!({})), (Sampler::default(), vec![]));
    let (sampler, _) = read(json!({"wrapS": 33071, "wrapT": 33648, "magFilter": 9728, "minFilter": 9985}));
    let expected = Sampler {
        wrap_u: Wrap::ClampToEdge,
        wrap_v: Wrap::MirroredRepeat,
        magnification: Filter::Nearest,
        minification: Filter::Linear,
        mip: MipFilter::Nearest,
    };
    assert_eq!(sampler, expected);
    for (code, minification, mip) in [
        (9728, Filter::Nearest, MipFilter::None),
        (9729, Filter::Linear, MipFilter::None),
        (9984, Filter::Nearest, MipFilter::Nearest),
        (9985, Filter::Linear, MipFilter::Nearest),
        (9986, Filter::Nearest, MipFilter::Linear),
        (9987, Filter::Linear, MipFilter::Linear),
    ] {
        let (sampler, _) = read(json!({"minFilter": code}));
        assert_eq!((sampler.minification, sampler.mip), (minification, mip), "{code}");
    }
    let (sampler, warnings) = read(json!({"wrapS": 1, "magFilter": 2, "minFilter": 3}));
    assert_eq!(sampler, Sampler::default());
    assert_eq!(
        warnings,
        ["wrapS 1", "magFilter 2", "minFilter 3"]
            .map(|w| format!("sampler 0: unknown {w}, the default is used"))
    );
}

#[test]
fn texture_transforms_and_coordinate_sets() {
    let read = |info: Value| {
        let mut model = Model::textured();
        model.json["materials"] = json!([{"pbrMetallicRoughness": {"baseColorTexture": info}}]);
        let loaded = model.load().unwrap();
        (loaded.scene.materials()[0].base_color_texture, messages(&loaded))
    };
    let transform = |t: Value| json!({"index": 0, "texCoord": 1, "extensions": {"KHR_texture_transform": t}});
    let texture = read(json!({"index": 0, "texCoord": 1})).0.unwrap();
    assert_eq!((texture.uv_set, texture.transform), (1, UvTransform::IDENTITY));
    let texture = read(transform(json!({"offset": [0.5, 0.25], "scale": [2, 3]}))).0.unwrap();
    assert_eq!((texture.uv_set, texture.transform.rows), (1, [[2.0, 0.0, 0.5], [0.0, 3.0, 0.25]]));
    assert_eq!(read(transform(json!({"texCoord": 0}))).0.unwrap().uv_set, 0);
    let (texture, warnings) = read(transform(json!({"scale": [1e30, 1]})));
    assert_eq!(texture.unwrap().transform, UvTransform::IDENTITY);
    assert_eq!(warnings, ["material 0: baseColorTexture: texture transform out of range, ignored"]);
    let (texture, warnings) = read(json!({"index": 0, "texCoord": 2}));
    // Two of any number are read.
    assert_eq!((texture.unwrap().uv_set, warnings), (1, Vec::<String>::new()));
}

#[test]
fn image_formats_are_told_by_content() {
    use image::ImageFormat::{Jpeg, Png, WebP};
    for format in [Png, WebP] {
        let mut model = Model::textured();
        let view = model.view(&picture(format));
        model.json["images"] = json!([{"bufferView": view, "mimeType": "image/jpeg"}]);
        let loaded = model.load().unwrap();
        assert!(loaded.warnings.is_empty());
        let level = loaded.scene.textures()[0].levels().next().unwrap();
        assert_eq!((level.width, level.height, level.texels[1]), (2, 1, [0, 255, 0, 255]), "{format:?}");
    }
    let grey = image::GrayImage::from_pixel(16, 8, image::Luma([77]));
    let mut jpeg = std::io::Cursor::new(Vec::new());
    grey.write_to(&mut jpeg, Jpeg).unwrap();
    let mut model = Model::textured();
    let view = model.view(&jpeg.into_inner());
    model.json["images"] = json!([{"bufferView": view}]);
    let scene = model.load().unwrap().scene;
    let level = scene.textures()[0].levels().next().unwrap();
    let [r, g, b, a] = level.texels[50];
    assert!(r.abs_diff(77) <= 1 && r == g && g == b && a == 255);
}

/// EXT_texture_webp and KHR_texture_basisu name another image beside, or instead of, the plain one.
#[test]
fn textures_by_extension() {
    let mut model = Model::textured();
    model.json["extensionsUsed"] = json!(["EXT_texture_webp", "KHR_texture_basisu"]);
    let webp = model.view(&picture(image::ImageFormat::WebP));
    push(&mut model.json["images"], json!({"bufferView": webp}));
    for (texture, drawn, warning) in [
        (json!({"source": 9, "extensions": {"EXT_texture_webp": {"source": 1}}}), true, None),
        (json!({"extensions": {"EXT_texture_webp": {"source": 1}}}), true, None),
        (json!({"source": 0, "extensions": {"KHR_texture_basisu": {"source": 9}}}), true, None),
        (
            json!({"extensions": {"KHR_texture_basisu": {"source": 9}}}),
            false,
            Some("texture 0: there is no image 9"),
        ),
        (json!({}), false, Some("texture 0 has no image that can be read")),
        (json!({"source": 7}), false, Some("texture 0: there is no image 7")),
    ] {
        model.json["textures"] = json!([texture]);
        let loaded = model.load().unwrap();
        assert_eq!(loaded.scene.materials()[0].base_color_texture.is_some(), drawn, "{texture}");
        let expected: Vec<String> = warning
            .map(|w| format!("material 0: baseColorTexture: {w}; drawn without the texture"))
            .into_iter()
            .collect();
        assert_eq!(messages(&loaded), expected);
    }
}

/// KTX2 textures, here one of 2 x 1 uncompressed texels.
#[test]
fn ktx2_textures() {
    let mut bytes = b"\xabKTX 20\xbb\r\n\x1a\n".to_vec();
    for word in [43u32, 1, 2, 1, 0, 0, 1, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 104, 0, 8, 0, 8, 0] {
        bytes.extend(word.to_le_bytes());
    }
    bytes.extend([10, 20, 30, 255, 40, 50, 60, 255]);
    let mut model = Model::textured();
    let plain = model.load().unwrap().scene.textures()[0].image().texels().to_vec();
    let view = model.view(&bytes);
    push(&mut model.json["images"], json!({"name": "k", "bufferView": view}));
    model.json["textures"] = json!([{"source": 0, "extensions": {"KHR_texture_basisu": {"source": 1}}}]);
    model.json["extensionsUsed"] = json!(["KHR_texture_basisu"]);
    model.json["extensionsRequired"] = json!(["KHR_texture_basisu"]);
    let loaded = model.load().unwrap();
    assert_eq!(messages(&loaded), [""; 0]);
    let level = loaded.scene.textures()[0].levels().next().unwrap();
    assert_eq!(level.texels[..], [[10, 20, 30, 255], [40, 50, 60, 255]]);
    // Its size is looked at before it is decoded, and damage is a loss with a name.
    let loaded = model.load_within(&Limits::default().with_texture_pixels(1)).unwrap();
    let told = messages(&loaded);
    let [message] = &told[..] else { panic!("{told:?}") };
    assert!(message.starts_with("image 1 'k' of 2 x 1 texels is drawn from 1 x 1"), "{message}");
    assert_eq!(loaded.scene.textures()[0].width(), 1);
    let place = model.json["bufferViews"][view]["byteOffset"].as_u64().unwrap() as usize;
    model.bytes[place + 88] = 4;
    let loaded = model.load().unwrap();
    assert_eq!(
        messages(&loaded),
        ["image 1 'k': the KTX2 texture is cut off; image 0 'picture' takes its place"]
    );
    assert_eq!(loaded.scene.textures()[0].image().texels()[..], plain[..]);
    // So may its head.
    model.bytes[place + 5] = b'1';
    let expected = "image 1 'k': it is a KTX texture of before KTX2; image 0 'picture' takes its place";
    assert_eq!(model.warnings(), [expected]);
    model.bytes[place + 5] = b'2';
    model.json["textures"][0].as_object_mut().unwrap().remove("source");
    assert_eq!(
        model.warnings(),
        ["image 1 'k' (material 0: baseColorTexture): the KTX2 texture is cut off; drawn without it"]
    );
    // The substitute may be damaged, too.
    model.json["textures"][0]["source"] = json!(2);
    push(&mut model.json["images"], json!({"name": "gone", "uri": "gone.png"}));
    let warnings = model.warnings();
    assert_eq!(warnings.len(), 2, "{warnings:?}");
    assert!(warnings[1].starts_with("image 2 'gone'") && warnings[1].ends_with("; drawn without it"));
}

/// A picture that cannot be read is named; the factor alone is drawn.
#[test]
fn broken_images_are_left_out() {
    let truncated = {
        let mut png = picture(image::ImageFormat::Png);
        png.truncate(50);
        png
    };
    for (bytes, reason) in [(vec![], "it is empty"), (truncated, "nexpected end")] {
        let mut model = Model::textured();
        let view = model.view(&bytes);
        model.json["images"][0]["bufferView"] = view.into();
        model.json["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"] = json!([0.5, 0.5, 0.5, 1.0]);
        let loaded = model.load().unwrap();
        let m = &loaded.scene.materials()[0];
        assert_eq!((m.base_color, m.base_color_texture), ([0.5, 0.5, 0.5, 1.0], None));
        let [warning] = &messages(&loaded)[..] else { panic!("{:?}", loaded.warnings) };
        assert!(warning.starts_with("image 0 'picture'") && warning.contains(reason), "{warning}");
        assert!(warning.ends_with("; drawn without it"));
        assert!(loaded.scene.textures().is_empty());
    }
    let mut model = Model::textured();
    for (image, expected) in [
        (
            json!({"uri": "gone.png"}),
            ": baseColorTexture): 'gone.png' cannot be read: no such file; drawn without it",
        ),
        (json!({}), "it has neither a URI nor a bufferView; drawn without it"),
        (json!({"bufferView": 99}), "there is no bufferView 99; drawn without it"),
        (json!({"uri": "data:image/png;base64,%%"}), "its data URI is not base64"),
    ] {
        model.json["images"] = json!([image]);
        let warnings = model.warnings();
        assert!(warnings.len() == 1 && warnings[0].contains(expected), "{warnings:?}");
    }
}

/// Files that are no images are called by their name in a warning, and left out of any slot.
#[test]
fn what_is_no_image_is_left_out() {
    let cases: [(&[u8], &str); 4] = [
        (b"<svg/>", "it is an SVG picture"),
        (
            b"version https://git-lfs.github.com/spec/v1\n",
            "it is a pointer of Git LFS: the picture itself was not fetched",
        ),
        (b"\0\0\0\x1cftypavif", "it is an AVIF picture"),
        (b"not found", "it is text: 'not found'"),
    ];
    for (bytes, expected) in cases {
        let mut model = Model::textured();
        let view = model.view(bytes);
        model.json["images"][0]["bufferView"] = view.into();
        model.json["materials"][0]["alphaMode"] = json!("BLEND");
        let slot = json!({"index": 0});
        model.json["materials"][0]["normalTexture"] = slot.clone();
        model.json["materials"][0]["emissiveTexture"] = slot;
        model.json["materials"][0]["emissiveFactor"] = json!([1, 1, 1]);
        let loaded = model.load().unwrap();
        let messages: Vec<String> = loaded.warnings.iter().map(ToString::to_string).collect();
        assert_eq!(messages.len(), 1, "{messages:?}");
        assert!(
            messages[0].contains(expected) && messages[0].contains("baseColorTexture, and 2 more"),
            "{messages:?}"
        );
        let material = &loaded.scene.materials()[0];
        assert!(material.base_color_texture.is_none() && material.normal_texture.is_none());
        // Its factor alone would make all of it glow.
        assert!(material.emissive_texture.is_none() && material.emissive == [0.0; 3]);
    }
}

/// Kinds that glTF does not have, and types that are wrong or missing.
#[test]
fn other_kinds_of_images_are_drawn() {
    // One texel of blue, in 24 bits.
    let header = [0, 0, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 1, 0, 24, 0];
    let tga = [&header[..], &[255, 0, 0]].concat();
    for (mime, warned) in [(json!("image/png"), 1), (json!(null), 1)] {
        let mut model = Model::textured();
        let view = model.view(&tga);
        model.json["images"][0] = json!({"bufferView": view, "mimeType": mime});
        let loaded = model.load().unwrap();
        assert_eq!(loaded.warnings.len(), warned, "{:?}", loaded.warnings);
        assert!(
            loaded.warnings[0].message.contains("it is a TGA, which glTF does not have"),
            "{:?}",
            loaded.warnings
        );
        let texture = loaded.scene.materials()[0].base_color_texture.unwrap();
        assert_eq!(loaded.scene.textures()[texture.texture.index()].image().texels(), [[0, 0, 255, 255]]);
    }
}

/// The other textures keep their places when one is missing.
#[test]
fn ids_settle_after_a_loss() {
    let mut model = Model::textured();
    push(&mut model.json["images"], json!({"uri": "gone.png"}));
    model.json["textures"] = json!([{"source": 1}, {"source": 0}]);
    model.json["materials"] = json!([{"emissiveTexture": {"index": 0}, "occlusionTexture": {"index": 1}}]);
    let scene = model.load().unwrap().scene;
    let m = &scene.materials()[0];
    assert_eq!(m.emissive_texture, None);
    assert_eq!(m.occlusion_texture.unwrap().texture.index(), 0);
    assert_eq!(scene.textures().len(), 1);
}

#[test]
fn claims_of_images_are_limited() {
    let model = Model::textured();
    model.load_within(&Limits::default().with_texture_pixels(2).with_textures(1)).unwrap();
    let limit = |limits: Limits| match model.load_within(&limits) {
        Err(LoadError::Limit(e)) => e.to_string(),
        other => panic!("{other:?}"),
    };
    // A smaller level is drawn, or none.
    let of = |pixels| model.load_within(&Limits::default().with_texture_pixels(pixels)).unwrap();
    let texel = of(1).scene.textures()[0].levels().next().unwrap().texels.to_vec();
    let whole = model.load().unwrap().scene.textures()[0].levels().nth(1).unwrap().texels.to_vec();
    assert_eq!(texel, whole);
    let none = of(0);
    assert!(none.scene.textures().is_empty());
    let message = &messages(&none)[0];
    assert!(
        message.starts_with("image 0 'picture' (")
            && message.ends_with(": 2 texels exceed the limit of 0 (texture_pixels); drawn without it"),
        "{message}"
    );
    assert_eq!(limit(Limits::default().with_textures(0)), "textures: 1 exceeds the limit of 0 (textures)");
}

#[test]
fn factors_out_of_range_are_clamped_and_named() {
    let mut model = Model::textured();
    model.json["materials"] = json!([{
        "name": "loud",
        "alphaMode": "GLASS",
        "pbrMetallicRoughness": {"metallicFactor": 2, "roughnessFactor": -1},
        "extensions": {"KHR_materials_ior": {"ior": 0.5}},
    }]);
    let loaded = model.load().unwrap();
    let m = &loaded.scene.materials()[0];
    assert_eq!(m.workflow, Workflow::MetallicRoughness { metallic: 1.0, roughness: 0.0, texture: None });
    assert_eq!((m.ior, m.alpha_mode), (1.0, AlphaMode::Opaque));
    assert_eq!(
        messages(&loaded),
        [
            "material 0 'loud': unknown alphaMode, drawn opaque",
            "material 0 'loud': metallicFactor 2 is out of range, 1 is used",
            "material 0 'loud': roughnessFactor -1 is out of range, 0 is used",
            "material 0 'loud': ior 0.5 is out of range, 1 is used",
        ]
    );
}

#[test]
fn extensions_are_named_once() {
    let mut model = Model::triangle();
    model.json["extensionsUsed"] =
        json!(["KHR_materials_sheen", "EXT_new", "EXT_new", "KHR_materials_unlit", "MSFT_texture_dds"]);
    assert_eq!(
        model.warnings(),
        [
            "EXT_new is not known and has no effect",
            "MSFT_texture_dds is not supported: the substitute images are used",
        ]
    );
}

#[test]
fn required_extensions() {
    let mut model = Model::triangle();
    // Extensions that only change the look are ignored, with a warning.
    model.json["extensionsRequired"] =
        json!(["EXT_lights_image_based", "KHR_texture_transform", "ABC_materials_wool"]);
    assert_eq!(
        model.warnings(),
        [
            "EXT_lights_image_based is not supported: the chosen environment is used instead",
            "ABC_materials_wool is not known and has no effect",
        ]
    );
    // Others may hold what is drawn: as much as there is without them.
    model.json["extensionsRequired"] = json!(["MSFT_texture_dds", "KHR_texture_transform", "EXT_new\n"]);
    assert_eq!(
        model.warnings(),
        [
            "MSFT_texture_dds is not supported: the substitute images are used",
            "the file requires EXT_new?, which is not known: drawn without what depends on it",
        ]
    );
    model.json["meshes"] = json!([]);
    model.json["nodes"] = json!([]);
    let error = model.load().unwrap_err();
    assert!(matches!(error, LoadError::Unsupported { .. }));
    assert_eq!(error.to_string(), "glTF: the file requires MSFT_texture_dds, EXT_new?, which cannot be read");
}
