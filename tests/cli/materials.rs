//! Materials laid over models, listed and explained.

use super::*;

#[test]
fn materials_are_laid_over_models() {
    let folder = folder();
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    write("green.toml", "unlit = true\nbase_color = '#00ff00'");
    write("blue.toml", "over = true\nunlit = true\nbase_color = '#0000ff'");
    write("scene.toml", "model = 'quad.glb'\nmaterial = 'blue.toml'\n[materials]\npaint = 'green.toml'\n");
    write("scene.json", r#"{"model": "quad.glb", "material": "green.toml", "tone_mapping": "none"}"#);
    let picture = |args: &[&str]| {
        let mut all = vec!["render", "-o", "out.png", "--size", "16", "--tone-map", "none", "--samples", "1"];
        all.extend(args);
        let output = overcoat(folder.path(), &all);
        assert_eq!((output.status.code(), stderr(&output).as_str()), (Some(0), ""), "{args:?}");
        middle(folder.path(), "out.png")
    };
    assert_eq!(picture(&["quad.glb", "--material", "green.toml"]), [0, 255, 0]);
    assert_eq!(picture(&["quad.glb", "--material", "paint=blue.toml"]), [0, 0, 255]);
    // Later ones lie over earlier ones, and the command line over the scene file.
    let both = ["quad.glb", "--material", "paint=blue.toml", "--material", "green.toml"];
    assert_eq!(picture(&both), [0, 255, 0]);
    assert_eq!(picture(&["--scene", "scene.toml"]), [0, 255, 0]);
    assert_eq!(picture(&["--scene", "scene.json", "--material", "blue.toml"]), [0, 0, 255]);
    let [r, g, b] = picture(&["quad.glb", "--material", "candy-red"]);
    assert!(r > 2 * g && r > 2 * b, "{r} {g} {b}");
    for args in [
        &["sheet", "quad.glb", "-o", "sheet.png", "--size", "16", "--material", "green.toml"][..],
        &["bench", "quad.glb", "--frames", "1", "--size", "16", "--material", "green.toml"],
    ] {
        let output = overcoat(folder.path(), args);
        assert_eq!((output.status.code(), stderr(&output).as_str()), (Some(0), ""), "{args:?}");
    }
}

/// Before any work, one line that helps, and nothing written.
#[test]
fn mistakes_in_materials_are_explained() {
    let folder = folder();
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    write("key.toml", "\ncoat_roughnes = 1");
    write("range.toml", "coat = 2");
    write("texture.toml", "coat_texture = 'none.png'");
    write("outside.toml", "coat_texture = '../x.png'");
    write("broken.glb", "glTF");
    let cases: &[(&[&str], i32, &[&str])] = &[
        (&["quad.glb", "--material", "key.toml"], 1, &["key.toml: line 2", "did you mean 'coat_roughness'"]),
        (&["quad.glb", "--material", "range.toml"], 1, &["range.toml: line 1: coat: 2", "0 to 1"]),
        (&["quad.glb", "--material", "texture.toml"], 1, &["texture.toml: line 1: coat_texture", "none.png"]),
        (&["quad.glb", "--material", "outside.toml"], 1, &["outside.toml", "leads out"]),
        (&["quad.glb", "--material", "none.toml"], 1, &["none.toml: cannot be read"]),
        (&["quad.glb", "--material", "candy"], 2, &["--material", "candy-red", "velvet"]),
        (&["quad.glb", "--material", "velvit"], 2, &["did you mean 'velvet'?"]),
        (
            &["quad.glb", "--material", "pant=velvet"],
            1,
            &["quad.glb", "'pant'; did you mean 'paint'?", "it has 'paint'"],
        ),
        (&["quad.glb", "--material", "velvet", "--limit", "textures=0"], 0, &[]),
        (&["quad.glb", "--material", "pearl-blue", "--limit", "textures=0"], 3, &["pearl-blue", "textures"]),
        // The material is looked at before the model.
        (&["broken.glb", "--material", "texture.toml"], 1, &["texture.toml"]),
        (&["quad.glb", "--material", "out.toml/out.png"], 1, &["out.png"]),
        (&["quad.glb", "--shading", "stack-lit"], 2, &["did you mean 'stacklit'?"]),
    ];
    for (args, code, words) in cases {
        let mut all = vec!["render", "-o", "out.png", "--size", "8"];
        all.extend(*args);
        let output = overcoat(folder.path(), &all);
        let message = stderr(&output);
        assert_eq!(output.status.code(), Some(*code), "{args:?}: {message}");
        if *code != 0 {
            assert_eq!(message.lines().count(), 1, "{message}");
            assert!(!folder.path().join("out.png").exists(), "{args:?}");
        }
        let _ = fs::remove_file(folder.path().join("out.png"));
        for word in *words {
            assert!(message.contains(word), "{args:?}: {message} lacks {word}");
        }
    }
}

#[test]
fn built_in_materials_are_listed_printed_and_shown() {
    let folder = folder();
    let list = overcoat(folder.path(), &["materials"]);
    assert_eq!((list.status.code(), stderr(&list).as_str()), (Some(0), ""));
    let list = String::from_utf8(list.stdout).unwrap();
    assert!(list.lines().count() >= 16);
    let candy = list.lines().find(|line| line.starts_with("candy-red ")).unwrap();
    assert!(candy.contains("stacklit") && candy.contains("tinted clear coat"), "{candy}");
    let json: Value =
        serde_json::from_slice(&overcoat(folder.path(), &["materials", "--json"]).stdout).unwrap();
    assert_eq!(json["materials"].as_array().unwrap().len(), list.lines().count());

    let printed = overcoat(folder.path(), &["materials", "candy-red"]).stdout;
    let file =
        Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")).join("assets/materials/candy-red.toml");
    assert_eq!(printed, fs::read(file).unwrap());
    let unknown = overcoat(folder.path(), &["materials", "candyred"]);
    assert_eq!(unknown.status.code(), Some(2));
    assert!(stderr(&unknown).contains("did you mean 'candy-red'?"), "{}", stderr(&unknown));
    let keys = overcoat(folder.path(), &["materials", "--keys"]).stdout;
    assert!(
        String::from_utf8(keys).unwrap().contains("coat_roughness\n    Perceptual roughness of the coat.")
    );

    let sheet = ["materials", "-o", "sheet.png", "--size", "16", "--columns", "4", "--json"];
    let output = overcoat(folder.path(), &sheet);
    assert_eq!((output.status.code(), stderr(&output).as_str()), (Some(0), ""));
    let json: Value = serde_json::from_slice(&output.stdout).unwrap();
    let hashes: std::collections::BTreeSet<&str> =
        json["materials"].as_array().unwrap().iter().map(|m| m["frame_hash"].as_str().unwrap()).collect();
    assert!(hashes.len() >= 16, "some look alike");
    let (width, _, _) = read_png(&fs::read(folder.path().join("sheet.png")).unwrap());
    assert_eq!(width, 4 * (16 + 8) + 8);
}
