//! Sheets of several models.

use super::*;

#[test]
fn a_sheet_shows_failures_instead_of_stopping() {
    let folder = folder();
    let good = overcoat(
        folder.path(),
        &["sheet", "quad.glb", "quad.glb", "-o", "s.png", "--size", "64", "--columns", "2"],
    );
    assert_eq!((good.status.code(), stderr(&good).as_str()), (Some(0), ""));
    let (width, height, pixels) = read_png(&fs::read(folder.path().join("s.png")).unwrap());
    assert!(width > 128 && height > 64, "{width} x {height}");
    let red = pixels.chunks(4).filter(|p| p[0] > 60 && p[0] / 2 > p[1]).count();
    assert!(red > 1000, "{red} red pixels");

    fs::write(folder.path().join("bad.glb"), b"glTFnonsense").unwrap();
    let mixed =
        overcoat(folder.path(), &["sheet", "quad.glb", "bad.glb", "-o", "m.png", "--size", "64", "--json"]);
    assert_eq!(mixed.status.code(), Some(1));
    assert!(stderr(&mixed).contains("bad.glb") && stderr(&mixed).contains("1 of 2"), "{}", stderr(&mixed));
    let report: Value = serde_json::from_slice(&mixed.stdout).unwrap();
    assert!(report["cells"][0]["error"].is_null() && report["cells"][1]["error"].is_string(), "{report}");
    assert!(folder.path().join("m.png").exists());
}

/// Settings that all pictures of a sheet share may come from a scene file.
#[test]
fn a_sheet_takes_lights_and_options_from_a_scene_file() {
    let folder = folder();
    let scene = "model = 'none.glb'\nenv = 'none'\nsize = [24, 16]\ntone_mapping = 'none'\n\
                 [[light]]\ntype = 'directional'\ndirection = [0, 0, -1]\nintensity = 3\n";
    fs::write(folder.path().join("scene.toml"), scene).unwrap();
    let json = |args: &[&str]| -> Value {
        let output = overcoat(folder.path(), &[args, &["--json", "--scene", "scene.toml"]].concat());
        assert_eq!((output.status.code(), stderr(&output).as_str()), (Some(0), ""), "{args:?}");
        serde_json::from_slice(&output.stdout).unwrap()
    };
    let sheet = json(&["sheet", "quad.glb", "quad.glb", "-o", "sheet.png"]);
    let single = json(&["render", "quad.glb", "-o", "out.png"]);
    assert_eq!(sheet["cells"][1]["frame_hash"], single["frame_hash"]);
    let unlit = json(&["render", "quad.glb", "-o", "out.png", "--no-lights"]);
    assert_eq!(unlit["frame_hash"], single["frame_hash"], "--no-lights is about the model's lights");
    let dark = "env = 'none'\nsize = [24, 16]\n";
    fs::write(folder.path().join("scene.toml"), dark).unwrap();
    assert_ne!(json(&["render", "quad.glb", "-o", "out.png"])["frame_hash"], single["frame_hash"]);
}
