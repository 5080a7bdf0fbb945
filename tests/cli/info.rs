//! Facts about models: `info`, names of variants and cameras.

use super::*;

#[test]
fn info_strict_fails_where_something_is_dropped() {
    let folder = tempfile::tempdir().unwrap();
    let triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    fs::write(folder.path().join("sound.obj"), triangle).unwrap();
    fs::write(folder.path().join("lacks.obj"), format!("mtllib missing.mtl\n{triangle}")).unwrap();
    for (args, code) in [
        (&["info", "sound.obj", "--strict"][..], 0),
        (&["info", "lacks.obj"], 0),
        (&["info", "lacks.obj", "--strict"], 1),
        (&["info", "lacks.obj", "--strict", "--json"], 1),
    ] {
        let output = overcoat(folder.path(), args);
        assert_eq!(output.status.code(), Some(code), "{args:?}: {}", stderr(&output));
        assert_eq!(stderr(&output).contains("(--strict)"), code == 1, "{args:?}");
        assert!(!output.stdout.is_empty());
    }
}

#[test]
fn info_tells_what_is_inside() {
    let folder = folder();
    let text = overcoat(folder.path(), &["info", "quad.glb"]);
    let text = String::from_utf8(text.stdout).unwrap();
    for part in ["glb", "2 triangles", "'paint'", "camera 0 'eye'"] {
        assert!(text.contains(part), "'{part}' is missing: {text}");
    }
    let output = overcoat(folder.path(), &["info", "quad.glb", "--json"]);
    let contents: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(contents["triangles"], 2);
    assert_eq!(contents["format"], "glb");
    assert_eq!(contents["bounds"]["max"], json!([1.0, 1.0, 0.0]));
    assert_eq!(contents["materials"][0]["name"], "paint");
    assert_eq!(contents["cameras"][0]["name"], "eye");
    let model = fs::read(folder.path().join("quad.glb")).unwrap();
    let piped = overcoat_with_input(folder.path(), &["info", "-", "--json"], &model);
    let piped: Value = serde_json::from_slice(&piped.stdout).unwrap();
    assert_eq!((&piped["format"], &piped["triangles"]), (&json!("glb"), &json!(2)));
}

#[test]
fn variants_are_chosen_by_name_and_number() {
    let folder = folder();
    let mut model = quad();
    let paint = model["materials"][0].clone();
    let mut blue = paint.clone();
    blue["name"] = "blue".into();
    model["materials"] = json!([paint, blue]);
    model["extensions"] = json!({"KHR_materials_variants": {"variants": [{"name": "winter"}]}});
    model["meshes"][0]["primitives"][0]["extensions"] =
        json!({"KHR_materials_variants": {"mappings": [{"material": 1, "variants": [0]}]}});
    fs::write(folder.path().join("shoe.glb"), glb(&model, &quad_buffer())).unwrap();
    let info =
        |options: &[&str]| overcoat(folder.path(), &[&["info", "shoe.glb", "--json"], options].concat());
    for (options, name) in
        [(&[][..], "paint"), (&["--variant", "winter"], "blue"), (&["--variant", "0"], "blue")]
    {
        let contents: Value = serde_json::from_slice(&info(options).stdout).unwrap();
        assert_eq!(contents["materials"][0]["name"], name, "{options:?}");
    }
    let contents: Value = serde_json::from_slice(&info(&[]).stdout).unwrap();
    assert_eq!(contents["variants"], json!(["winter"]));
    let text = overcoat(folder.path(), &["info", "shoe.glb"]);
    assert!(String::from_utf8(text.stdout).unwrap().contains("\n  variant 0 'winter'\n"));
    let wrong = info(&["--variant", "summer"]);
    assert_eq!(wrong.status.code(), Some(1));
    assert!(stderr(&wrong).contains("there is no material variant 'summer'; the file has 'winter'"));
}

#[test]
fn cameras_are_chosen_by_name_number_and_view() {
    let folder = folder();
    let hash = |options: &[&str]| {
        let mut args = vec!["render", "quad.glb", "-o", "out.png", "--size", "32", "--json"];
        args.extend(options);
        let output = overcoat(folder.path(), &args);
        assert_eq!(output.status.code(), Some(0), "{options:?}: {}", stderr(&output));
        let report: Value = serde_json::from_slice(&output.stdout).unwrap();
        report["frame_hash"].as_str().unwrap().to_owned()
    };
    assert_eq!(hash(&["--camera", "eye"]), hash(&["--camera", "0"]));
    assert_ne!(hash(&["--camera", "eye"]), hash(&[]));
    assert_eq!(hash(&["--view", "front"]), hash(&["--view", "0,0,1"]));
    assert_ne!(hash(&["--view", "front"]), hash(&["--view", "front", "--ortho"]));
    assert_ne!(hash(&["--view", "front", "--ortho"]), hash(&["--view", "front", "--ortho=8"]));
}
