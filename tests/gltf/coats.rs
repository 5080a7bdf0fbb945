//! The coats that glTF is getting: KHR_materials_coat, and what extends KHR_materials_clearcoat.

use crate::common::files::model::{Model, messages};
use overcoat::frame::Frame;
use overcoat::jobs::Jobs;
use overcoat::limits::Limits;
use overcoat::load::{AnimationChoice, Context, LoadOptions, load_bytes_with};
use overcoat::render::{RenderOptions, Renderer};
use overcoat::scene::{CoatMedium, ColorSpace, Framing, Material, Scene, ShadingModel};
use serde_json::{Value, json};

/// A scene with one material of these extensions, and its warnings.
fn scene(extensions: &Value) -> (Scene, Vec<String>) {
    let mut model = Model::textured();
    model.json["materials"] = json!([{
        "pbrMetallicRoughness": {"baseColorFactor": [0.8, 0.4, 0.2, 1], "metallicFactor": 0, "roughnessFactor": 0.5},
        "extensions": extensions,
    }]);
    let loaded = model.load().unwrap();
    let warnings = messages(&loaded);
    (loaded.scene, warnings)
}

/// The material of extensions that give no warning.
fn material(extensions: &Value) -> Material {
    let (scene, warnings) = scene(extensions);
    assert_eq!(warnings, [""; 0]);
    scene.materials()[0].clone()
}

/// KHR_materials_clearcoat with these of its own extensions.
fn clearcoat(factor: f64, extensions: &Value) -> Value {
    json!({"KHR_materials_clearcoat": {"clearcoatFactor": factor, "extensions": extensions}})
}

fn draw(scene: &Scene, model: ShadingModel) -> Frame {
    let options = RenderOptions::draft(24, 24).with_shading(model);
    let camera = Framing::default().camera(scene);
    Renderer::new(1).render(scene, &camera, &options).unwrap().frame
}

#[test]
fn every_number_of_a_coat_arrives() {
    let m = material(&json!({"KHR_materials_coat": {
        "coatFactor": 0.75, "coatRoughnessFactor": 0.125, "coatIor": 1.75, "coatColorFactor": [0.9, 0.5, 0.25],
        "coatDarkeningFactor": 0.5, "coatAnisotropyStrength": 0.25,
    }}));
    assert_eq!((m.coat, m.coat_roughness), (0.75, 0.125));
    let expected = CoatMedium::default().with(|c| {
        c.ior = 1.75;
        c.color = [0.9, 0.5, 0.25].into();
        c.darkening = 0.5;
        c.anisotropy = 0.25;
    });
    assert_eq!(m.lobes.coat, expected);
    let m = material(&json!({"KHR_materials_coat": {}}));
    assert_eq!((m.coat, m.coat_roughness, m.lobes.coat), (0.0, 0.0, CoatMedium::default()));
}

#[test]
fn textures_of_a_coat_have_their_colour_space() {
    let t = json!({"index": 0});
    let (scene, warnings) = scene(&json!({"KHR_materials_coat": {
        "coatFactor": 1, "coatTexture": t, "coatRoughnessTexture": t, "coatColorTexture": t,
        "coatNormalTexture": {"index": 0, "scale": 0.5},
    }}));
    assert_eq!(warnings, [""; 0]);
    let m = &scene.materials()[0];
    let space = |texture: Option<overcoat::scene::TextureRef>| {
        scene.textures()[texture.unwrap().texture.index()].color_space()
    };
    let normal = m.coat_normal_texture.unwrap();
    assert_eq!(normal.scale, 0.5);
    for data in [m.coat_texture, m.coat_roughness_texture, Some(normal.texture)] {
        assert_eq!(space(data), ColorSpace::Linear);
    }
    assert_eq!(space(m.lobes.coat.color.texture), ColorSpace::Srgb);
    let (scene, _) =
        self::scene(&clearcoat(1.0, &json!({"KHR_materials_clearcoat_color": {"clearcoatColorTexture": t}})));
    assert!(scene.materials()[0].lobes.coat.color.texture.is_some());
}

/// Colour and darkening have changed their names since their first drafts.
#[test]
fn what_extends_a_clear_coat_arrives() {
    for prefix in ["KHR", "EXT"] {
        let (color, darkening) = (
            format!("{prefix}_materials_clearcoat_color"),
            format!("{prefix}_materials_clearcoat_darkening"),
        );
        let m = material(&clearcoat(
            0.5,
            &json!({
                "KHR_materials_clearcoat_ior": {"clearcoatIor": 1.25},
                color: {"clearcoatColorFactor": [0.4, 0.1, 0.2]},
                darkening.as_str(): {"clearcoatDarkeningFactor": 0.25},
            }),
        ));
        let expected = CoatMedium::default().with(|c| {
            c.ior = 1.25;
            c.color = [0.4, 0.1, 0.2].into();
            c.darkening = 0.25;
        });
        assert_eq!((m.coat, m.lobes.coat), (0.5, expected));
        // The first schema wanted a list of one.
        let m = material(&clearcoat(0.5, &json!({darkening: {"clearcoatDarkeningFactor": [0.25]}})));
        assert_eq!(m.lobes.coat.darkening, 0.25);
    }
    // The coat of the extension alone returns nothing to the base; the drafts' does unless they say otherwise.
    let plain = CoatMedium::default().with(|c| c.darkening = 0.0);
    assert_eq!(material(&clearcoat(1.0, &json!({}))).lobes.coat, plain);
    let given = clearcoat(1.0, &json!({"KHR_materials_clearcoat_darkening": {}}));
    assert_eq!(material(&given).lobes.coat, CoatMedium::default());
    assert_eq!(material(&json!({"KHR_materials_coat": {"coatFactor": 1}})).lobes.coat, CoatMedium::default());
}

/// KHR_materials_clearcoat is the substitute for those who do not know the other.
#[test]
fn a_coat_takes_the_place_of_a_clear_coat() {
    let t = json!({"index": 0});
    let m = material(&json!({
        "KHR_materials_clearcoat": {
            "clearcoatFactor": 1, "clearcoatRoughnessFactor": 0.5, "clearcoatTexture": t,
            "extensions": {"KHR_materials_clearcoat_ior": {"clearcoatIor": 2}},
        },
        "KHR_materials_coat": {"coatFactor": 0.5},
    }));
    assert_eq!((m.coat, m.coat_roughness, m.lobes.coat), (0.5, 0.0, CoatMedium::default()));
    assert_eq!(m.textures().count(), 0);
}

#[test]
fn numbers_out_of_range_and_what_is_not_read_are_named() {
    let t = json!({"index": 0});
    let cases = [
        (
            json!({"KHR_materials_coat": {"coatFactor": 2, "coatIor": 4, "coatDarkeningFactor": -1}}),
            vec![
                "coatFactor 2 is out of range, 1 is used",
                "coatIor 4 is out of range, 3 is used",
                "coatDarkeningFactor -1 is out of range, 0 is used",
            ],
        ),
        // 0 stands for a reflectance of 1, as in KHR_materials_ior.
        (
            clearcoat(1.0, &json!({"KHR_materials_clearcoat_ior": {"clearcoatIor": 0}})),
            vec!["clearcoatIor 0 is out of range, 3 is used"],
        ),
        (
            json!({"KHR_materials_coat": {"coatFactor": 1, "coatAnisotropyStrength": 0.5,
                "coatAnisotropyRotation": 1, "coatAnisotropyTexture": t}}),
            vec![
                "coatAnisotropyRotation is not read: the coat is stretched along the tangent of the base",
                "coatAnisotropyTexture is not read: the coat is stretched along the tangent of the base",
            ],
        ),
        // Nothing is lost of what is not there.
        (
            json!({"KHR_materials_coat": {"coatFactor": 1, "coatAnisotropyRotation": 1,
                "coatAnisotropyTexture": t}}),
            vec![],
        ),
        (
            clearcoat(1.0, &json!({"KHR_materials_clearcoat_darkening": {"clearcoatDarkeningTexture": t}})),
            vec!["clearcoatDarkeningTexture is not read: the factor alone holds"],
        ),
    ];
    for (extensions, expected) in cases {
        let expected: Vec<String> = expected.iter().map(|text| format!("material 0: {text}")).collect();
        assert_eq!(scene(&extensions).1, expected, "{extensions}");
    }
}

/// A coat of weight 0 has no effect, whatever its other parameters: by factor, and by texture texel by texel.
#[test]
fn a_coat_of_weight_0_changes_nothing() {
    let colored = json!({"coatFactor": 0, "coatIor": 2.5, "coatColorFactor": [1, 0, 0], "coatDarkeningFactor": 1,
        "coatAnisotropyStrength": 1, "coatRoughnessFactor": 1});
    let mut masked = colored.clone();
    masked["coatFactor"] = json!(1);
    // The picture's texels have no red on the left half.
    masked["coatTexture"] = json!({"index": 0});
    let (bare, _) = scene(&json!({}));
    let (off, _) = scene(&json!({"KHR_materials_coat": colored}));
    let tinted =
        clearcoat(0.0, &json!({"KHR_materials_clearcoat_color": {"clearcoatColorFactor": [1, 0, 0]}}));
    let (tinted, _) = scene(&tinted);
    let (on, _) = scene(&json!({"KHR_materials_coat": {"coatFactor": 1, "coatColorFactor": [1, 0, 0]}}));
    for &model in ShadingModel::ALL {
        let expected = draw(&bare, model).frame_hash();
        assert_eq!(draw(&off, model).frame_hash(), expected, "{}", model.name());
        assert_eq!(draw(&tinted, model).frame_hash(), expected, "{}", model.name());
    }
    for model in [ShadingModel::OpenPbr, ShadingModel::Babylon] {
        assert_ne!(draw(&on, model).frame_hash(), draw(&bare, model).frame_hash(), "{}", model.name());
    }
    let mut black = Model::textured();
    let png = black_png();
    let view = black.view(&png);
    black.json["images"] = json!([{"bufferView": view}]);
    black.json["materials"] = json!([{
        "pbrMetallicRoughness": {"baseColorFactor": [0.8, 0.4, 0.2, 1], "metallicFactor": 0, "roughnessFactor": 0.5},
        "extensions": {"KHR_materials_coat": masked},
    }]);
    let masked = black.load().unwrap().scene;
    for model in [ShadingModel::OpenPbr, ShadingModel::Babylon] {
        assert_eq!(draw(&masked, model).frame_hash(), draw(&bare, model).frame_hash(), "{}", model.name());
    }
}

/// A black pixel.
fn black_png() -> Vec<u8> {
    let mut out = std::io::Cursor::new(Vec::new());
    image::RgbImage::new(1, 1).write_to(&mut out, image::ImageFormat::Png).unwrap();
    out.into_inner()
}

#[test]
fn what_a_model_has_not_of_a_coat_is_named() {
    let (scene, _) = scene(&json!({"KHR_materials_coat": {
        "coatFactor": 1, "coatIor": 1.75, "coatColorFactor": [0.9, 0.5, 0.25], "coatDarkeningFactor": 0.5,
        "coatAnisotropyStrength": 0.25,
    }}));
    let missed = |model: ShadingModel| model.leaves_out(&scene.materials()[0]).collect::<Vec<_>>();
    let rest = ["coat darkening", "coat anisotropy"];
    assert_eq!(missed(ShadingModel::OpenPbr), [""; 0]);
    assert_eq!(missed(ShadingModel::Babylon), rest);
    assert_eq!(missed(ShadingModel::StackLit), [&["coat colour"], &rest[..]].concat());
    assert_eq!(
        missed(ShadingModel::Gltf),
        [&["coat colour", "coat index of refraction"], &rest[..]].concat()
    );
    assert_eq!(
        missed(ShadingModel::Velvet),
        [&["clear coat", "coat colour", "coat index of refraction"], &rest[..]].concat()
    );
    // Models without darkening do not darken.
    let (plain, _) = self::scene(&json!({"KHR_materials_coat": {"coatFactor": 1, "coatDarkeningFactor": 0}}));
    assert_eq!(ShadingModel::Gltf.leaves_out(&plain.materials()[0]).count(), 0);
}

#[test]
fn animations_reach_coats() {
    let play = |extensions: Value, changes: &[(&str, &str, &[f32])]| {
        let mut model = Model::textured();
        model.json["extensionsUsed"] = json!(["KHR_animation_pointer"]);
        model.json["materials"] = json!([{"extensions": extensions}]);
        let input = model.floats("SCALAR", &[0.0]);
        let (mut channels, mut samplers) = (Vec::new(), Vec::new());
        for (k, (path, kind, values)) in changes.iter().enumerate() {
            let output = model.floats(kind, values);
            let pointer = json!({"pointer": format!("/materials/0/extensions/{path}")});
            let target = json!({"path": "pointer", "extensions": {"KHR_animation_pointer": pointer}});
            channels.push(json!({"sampler": k, "target": target}));
            samplers.push(json!({"input": input, "output": output}));
        }
        model.json["animations"] = json!([{"name": "all", "channels": channels, "samplers": samplers}]);
        let animation = AnimationChoice { name: "all".to_owned(), time: 0.0, repeat: false };
        let options = LoadOptions::default().with_animation(animation);
        let (limits, jobs) = (Limits::default(), Jobs::new(1));
        let context = Context { resolver: &model.files, limits: &limits, jobs: &jobs };
        let loaded = load_bytes_with(&model.glb(), None, &options, &context).unwrap();
        assert_eq!(messages(&loaded), [""; 0]);
        loaded.scene.materials()[0].clone()
    };
    let m = play(
        json!({"KHR_materials_coat": {"coatFactor": 0.5, "coatColorTexture": {"index": 0}}}),
        &[
            ("KHR_materials_coat/coatFactor", "SCALAR", &[1.0]),
            ("KHR_materials_coat/coatIor", "SCALAR", &[0.0]),
            ("KHR_materials_coat/coatColorFactor", "VEC3", &[0.5, 0.25, 2.0]),
            ("KHR_materials_coat/coatDarkeningFactor", "SCALAR", &[0.125]),
            ("KHR_materials_coat/coatAnisotropyStrength", "SCALAR", &[0.75]),
            (
                "KHR_materials_coat/coatColorTexture/extensions/KHR_texture_transform/offset",
                "VEC2",
                &[0.5, 0.25],
            ),
            // The substitute is not what is drawn.
            ("KHR_materials_clearcoat/clearcoatFactor", "SCALAR", &[0.0]),
        ],
    );
    assert_eq!((m.coat, m.lobes.coat.ior, m.lobes.coat.color.factor), (1.0, 3.0, [0.5, 0.25, 1.0]));
    assert_eq!((m.lobes.coat.darkening, m.lobes.coat.anisotropy), (0.125, 0.75));
    let offset = m.lobes.coat.color.texture.unwrap().transform.rows.map(|row| row[2]);
    assert_eq!(offset, [0.5, 0.25]);
    let m = play(
        clearcoat(1.0, &json!({})),
        &[
            ("KHR_materials_clearcoat/extensions/KHR_materials_clearcoat_ior/clearcoatIor", "SCALAR", &[2.0]),
            (
                "KHR_materials_clearcoat/extensions/KHR_materials_clearcoat_color/clearcoatColorFactor",
                "VEC3",
                &[0.5, 0.25, 0.0],
            ),
            (
                "KHR_materials_clearcoat/extensions/EXT_materials_clearcoat_darkening/clearcoatDarkeningFactor",
                "SCALAR",
                &[0.5],
            ),
        ],
    );
    let medium = m.lobes.coat;
    assert_eq!((medium.ior, medium.color.factor, medium.darkening), (2.0, [0.5, 0.25, 0.0], 0.5));
}
