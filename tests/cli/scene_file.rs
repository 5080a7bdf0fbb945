//! Scene files.

use super::*;

#[test]
fn a_scene_file_describes_a_whole_picture() {
    let folder = folder();
    let scenes = folder.path().join("scenes");
    fs::create_dir(&scenes).unwrap();
    let json = r##"{"name": "x", "model": "../quad.glb", "env": "none", "size": [24, 16], "background": "#00ff00",
        "camera": {"eye": [0, 0, 9], "target": [0, 0, 0], "up": [0, 1, 0], "fov_y_deg": 30, "near": 0.1, "far": 90},
        "tone_mapping": ["linear", "aces"], "samples": 4, "note": "why", "peers": [], "ground_truth": {}}"##;
    let toml = "model = '../quad.glb'\nenv = 'none'\nsize = [24, 16]\nbackground = '#00ff00'\n\
        tone_mapping = 'none'\nsamples = 4\n[camera]\neye = [0, 0, 9]\ntarget = [0, 0, 0]\nfov_y_deg = 30\nnear = 0.1\n";
    fs::write(scenes.join("scene.json"), json).unwrap();
    fs::write(scenes.join("scene.toml"), toml).unwrap();
    let render = |options: &[&str]| {
        let mut args = vec!["render", "-o", "out.png", "--json"];
        args.extend(options);
        let output = overcoat(folder.path(), &args);
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        let report: Value = serde_json::from_slice(&output.stdout).unwrap();
        (report, fs::read(folder.path().join("out.png")).unwrap())
    };
    let (report, picture) = render(&["--scene", "scenes/scene.json"]);
    assert_eq!(
        (&report["width"], &report["height"], &report["samples"]),
        (&json!(24), &json!(16), &json!(4))
    );
    assert_eq!(&read_png(&picture).2[..4], &[0, 255, 0, 255]);
    assert_eq!(render(&["--scene", "scenes/scene.toml"]).1, picture);
    let options = [
        "quad.glb",
        "--env",
        "none",
        "--size",
        "24x16",
        "--background",
        "lime",
        "--tone-map",
        "none",
        "--samples",
        "4",
        "--eye",
        "0,0,9",
        "--target",
        "0,0,0",
        "--fov",
        "30",
    ];
    assert_eq!(render(&options).1, picture);
    // Options win over the file.
    let (report, _) = render(&["--scene", "scenes/scene.json", "--size", "8"]);
    assert_eq!((&report["width"], &report["height"]), (&json!(8), &json!(8)));

    for (text, part) in [(r#"{"modle": "x"}"#, "modle"), ("{", "line 1"), (r#"{"size": [4, 4]}"#, "model")] {
        fs::write(scenes.join("bad.json"), text).unwrap();
        let output = overcoat(folder.path(), &["render", "--scene", "scenes/bad.json", "-o", "new.png"]);
        let message = stderr(&output);
        assert_eq!(output.status.code(), Some(1), "{message}");
        assert!(message.contains("bad.json") && message.contains(part), "{message}");
    }
    assert!(!folder.path().join("new.png").exists());
}

/// Each key in another spelling is read, with a warning that is also in the report.
#[test]
fn other_spellings_of_keys_are_warnings() {
    let folder = folder();
    fs::write(folder.path().join("scene.toml"), "model = 'quad.glb'\nenvIntensity = 0.5\nsize = 16\n")
        .unwrap();
    fs::write(folder.path().join("paint.toml"), "baseColor = '00ff00'\n").unwrap();
    let args = ["render", "--scene", "scene.toml", "--material", "paint.toml", "-o", "x.png", "--json"];
    let output = overcoat(folder.path(), &args);
    let expected = [
        "scene.toml: line 2: envIntensity: the key is spelt env_intensity",
        "paint.toml: line 1: baseColor: the key is spelt base_color",
    ];
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert_eq!(stderr(&output), expected.map(|w| format!("warning: {w}\n")).concat());
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(report["warnings"], json!(expected));
    fs::write(folder.path().join("paint.toml"), "base_color = '00ff00'\nbaseColor = '00ff00'\n").unwrap();
    let twice = overcoat(folder.path(), &args);
    assert!(stderr(&twice).contains("another spelling"), "{}", stderr(&twice));
}
