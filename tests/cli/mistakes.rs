//! Bad input, bad outputs: one clear line, and nothing left behind.

use super::*;

/// One line on standard error that names the file and the reason, the exit code, and nothing written.
#[test]
fn bad_input_ends_in_one_clear_line() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    let valid = glb(&quad(), &quad_buffer());

    fs::write(at("empty.glb"), b"").unwrap();
    fs::write(at("truncated.glb"), &valid[..valid.len() - 30]).unwrap();
    fs::write(at("picture.glb"), b"\x89PNG\r\n\x1a\n....").unwrap();
    fs::write(at("notes.abc"), b"dear diary").unwrap();
    fs::write(at("syntax.gltf"), br#"{"asset": {"version": "2.0"}, "nodes": [}"#).unwrap();
    let mut index_out_of_range = quad();
    index_out_of_range["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = json!(7);
    fs::write(at("index.glb"), glb(&index_out_of_range, &quad_buffer())).unwrap();
    let mut buffer = quad_buffer();
    buffer[50] = 200;
    fs::write(at("vertex.glb"), glb(&quad(), &buffer)).unwrap();
    for (name, value) in [("nan.glb", f32::NAN), ("infinite.glb", f32::INFINITY)] {
        let mut buffer = quad_buffer();
        buffer[12..16].copy_from_slice(&value.to_le_bytes());
        fs::write(at(name), glb(&quad(), &buffer)).unwrap();
    }
    let mut outside = quad();
    outside["buffers"][0]["uri"] = json!("../secret.bin");
    fs::write(at("outside.gltf"), outside.to_string()).unwrap();
    fs::create_dir(at("folder.glb")).unwrap();
    fs::write(at("bad.hdr"), b"#?RADIANCE\n").unwrap();

    let output_side = "16384";
    let cases: &[(&[&str], i32, &[&str])] = &[
        (&["render", "missing.glb"], 1, &["missing.glb", "No such file"]),
        (&["render", "folder.glb"], 1, &["folder.glb", "folder"]),
        (&["render", "empty.glb"], 1, &["empty.glb", "empty"]),
        (&["render", "truncated.glb"], 1, &["truncated.glb"]),
        (&["render", "picture.glb"], 1, &["picture.glb"]),
        (&["render", "notes.abc"], 1, &["notes.abc", "format"]),
        (&["render", "syntax.gltf"], 1, &["syntax.gltf", "line 1"]),
        (&["render", "index.glb"], 1, &["index.glb", "7"]),
        (&["render", "outside.gltf"], 1, &["outside.gltf", "secret.bin"]),
        (&["render", "quad.glb", "--env", "missing.hdr"], 1, &["missing.hdr", "No such file"]),
        (&["render", "quad.glb", "--env", "bad.hdr"], 1, &["bad.hdr"]),
        (&["render", "quad.glb", "--camera", "3"], 1, &["quad.glb", "camera '3'", "eye"]),
        (&["render", "quad.glb", "--size", "0"], 2, &["quad.glb", "0x0"]),
        (&["render", "quad.glb", "--size", "64x0"], 2, &["quad.glb", "64x0"]),
        (&["render", "quad.glb", "--size", "1000000000"], 3, &["quad.glb", "1000000000", output_side]),
        (&["render", "quad.glb", "--size", "16384x16384"], 3, &["quad.glb", "output_pixels"]),
        (&["render", "quad.glb", "--size", "big"], 2, &["--size", "big"]),
        (&["render", "quad.glb", "--samples", "3"], 2, &["--samples", "1, 4, 8 or 16"]),
        (&["render", "quad.glb", "--tile", "17"], 2, &["--tile"]),
        (&["render", "quad.glb", "--simd", "mmx"], 2, &["--simd", "mmx"]),
        (&["render", "quad.glb", "--shading", "phong"], 2, &["--shading", "urp-desktop"]),
        (&["render", "quad.glb", "--eye", "0,0"], 2, &["--eye"]),
        (&["render", "quad.glb", "--eye", "0,0,0", "--target", "0,0,0"], 2, &["quad.glb", "camera"]),
        (&["render", "quad.glb", "--view", "front", "--eye", "0,0,1"], 2, &["--view", "--eye"]),
        (&["render", "quad.glb", "--env-intensity", "-1"], 2, &["intensity"]),
        (&["render", "quad.glb", "--env-rotation", "nan"], 2, &["--env-rotation"]),
        (&["render", "quad.glb", "--background", "whitish"], 2, &["--background"]),
        (&["render", "quad.glb", "--aov", "depth,smell"], 2, &["--aov", "smell"]),
        (&["render", "quad.glb", "--aov-sample", "mean"], 2, &["--aov-sample", "center, nearest"]),
        (
            &["render", "quad.glb", "--limit", "triangles=1"],
            3,
            &["quad.glb", "--limit triangles=N raises it"],
        ),
        (&["render", "quad.glb", "--limit", "input_bytes=100"], 3, &["quad.glb", "input_bytes"]),
        (&["render", "quad.glb", "--limit", "patience=1"], 2, &["--limit", "patience"]),
        (&["render", "quad.glb", "--format", "glb"], 2, &["--format"]),
        (
            &["render", "quad.glb", "--output-format", "jpg"],
            2,
            &["out.png", "--output-format jpg contradicts"],
        ),
        (&["render", "quad.glb", "--output-format", "jpgg"], 2, &["jpgg", "did you mean 'jpg'?"]),
        (&["render", "quad.glb", "--jpeg-quality", "80"], 2, &["--jpeg-quality is for .jpg"]),
        (&["render", "quad.glb", "--jpeg-quality", "101"], 2, &["--jpeg-quality", "expected 1 to 100"]),
        (&["turntable", "quad.glb", "-o", "x.png", "--output-format", "exr"], 2, &["x.png", "contradicts"]),
        (&["turntable", "quad.glb", "-o", "x.jpg"], 2, &["x.jpg", "JPEG does not move"]),
        (&["sheet", "quad.glb", "-o", "x.exr"], 2, &["x.exr", "a contact sheet is a .png, .webp or .jpg"]),
        (&["render", "quad.glb", "--view", "fornt"], 2, &["did you mean 'front'?"]),
        (&["render", "quad.glb", "--limit", "triangle=1"], 2, &["did you mean 'triangles'?"]),
        (&["render", "quad.glb", "--camera", "eya"], 1, &["there is no camera 'eya'", "did you mean 'eye'?"]),
        (&["render", "quad.glb", "--frobnicate"], 2, &["--frobnicate"]),
        (&["render", "quad.glb", "--sizes", "8"], 2, &["'--sizes'", "did you mean '--size'?"]),
        (&["render", "quad.glb", "--fov", "-10"], 2, &["'-10'", "--fov", "expected 0.1 to 179"]),
        (&["render", "quad.glb", "--samples", "-4"], 2, &["'-4'", "--samples", "1, 4, 8 or 16"]),
        (&["render", "quad.glb", "--shading-rate", "3"], 2, &["'3'", "--shading-rate", "1, 4, 8, 9 or 16"]),
        (
            &["render", "quad.glb", "--shading-rate", "8", "--samples", "4"],
            2,
            &["shading rate 8: a pixel with 4 samples is shaded at most 4 times"],
        ),
        (&["render", "quad.glb", "--anisotropy", "x"], 2, &["--anisotropy", "expected 1 to 16"]),
        (&["render", "quad.glb", "--merge-angle", "nan"], 2, &["--merge-angle", "expected 0 to 45"]),
        (&["render", "quad.glb", "--edges", "crease"], 2, &["--edges", "none, creases, boundary"]),
        (&["render", "quad.glb", "--edge-width", "0"], 2, &["--edge-width", "expected 0.1 to 64"]),
        (&["render", "quad.glb", "--line-width", "-1"], 2, &["--line-width", "expected 0.1 to 64"]),
        (&["render", "quad.glb", "--exposure", "100"], 2, &["--exposure", "expected -64 to 64"]),
        (&["render", "quad.glb", "--threads", "-1"], 2, &["--threads", "expected 0 to 256"]),
        (&["render", "quad.glb", "--time", "-1"], 2, &["--time", "at least 0"]),
        (&["render", "quad.glb", "--camera-up", "0,0,0"], 2, &["--camera-up", "direction"]),
        (&["render", "quad.glb", "--intrinsics", "9,9,9,9", "--fov", "9"], 2, &["--intrinsics", "--fov"]),
        (
            &["render", "quad.glb", "--pose", "1,0", "--pose-convention", "opencv"],
            2,
            &["--pose", "16 numbers", "found 2"],
        ),
        (
            &["render", "quad.glb", "--pose", "no.txt", "--pose-convention", "opencv"],
            2,
            &["--pose", "no.txt"],
        ),
        (&["render", "quad.glb", "--pose", "1,0"], 2, &["--pose"]),
        (&["render", "quad.glb", "--up", "0,0,1"], 2, &["--up", "+z", "--camera-up"]),
        (&["turntable", "quad.glb", "-o", "x.png", "--fps", "-1"], 2, &["--fps", "0.1 to 1000"]),
        (&["sheet", "quad.glb", "-o", "x.png", "--format", "glb"], 2, &["--format is for standard input"]),
        (&["sheet", "quad.glb", "-o", "x.png", "--columns", "0"], 2, &["--columns", "1 to 1000"]),
        (&["rendr"], 2, &["'rendr'", "did you mean 'render'?"]),
        (&["render"], 2, &["<IN>"]),
        (&["info", "missing.glb"], 1, &["missing.glb", "No such file"]),
    ];
    let before = names(folder.path());
    for (args, code, parts) in cases {
        let mut args = args.to_vec();
        if args[0] == "render" {
            args.extend(["-o", "out.png"]);
        }
        let output = overcoat(folder.path(), &args);
        let message = stderr(&output);
        assert_eq!(output.status.code(), Some(*code), "{args:?}: {message}");
        assert_eq!(message.lines().count(), 1, "{args:?}: {message}");
        assert!(message.starts_with("overcoat: "), "{args:?}: {message}");
        for part in *parts {
            assert!(message.contains(part), "{args:?}: '{part}' is missing: {message}");
        }
        assert!(output.stdout.is_empty(), "{args:?}");
        assert_eq!(names(folder.path()), before, "{args:?}");
    }
    // One of two triangles is whole.
    for (model, part) in
        [("vertex.glb", "out of range"), ("nan.glb", "not finite"), ("infinite.glb", "not finite")]
    {
        let output = overcoat(folder.path(), &["render", model, "-o", "half.png", "--size", "32"]);
        let message = stderr(&output);
        assert_eq!(output.status.code(), Some(0), "{model}: {message}");
        assert!(message.starts_with("warning: ") && message.contains(part), "{model}: {message}");
    }
}

#[test]
fn outputs_that_cannot_be_written_are_found_out_before_the_work() {
    let folder = folder();
    fs::create_dir(folder.path().join("folder.png")).unwrap();
    for (out, code, part) in [
        ("no-such-folder/out.png", 1, "no-such-folder"),
        ("folder.png", 1, "folder"),
        ("quad.glb/out.png", 1, "quad.glb"),
        ("out.gif", 2, ".exr"),
        ("out", 2, ".exr"),
    ] {
        // The model is missing too; that the output is the problem shows what is looked at first.
        let output = overcoat(folder.path(), &["render", "missing.glb", "-o", out]);
        let message = stderr(&output);
        assert_eq!(output.status.code(), Some(code), "{message}");
        assert!(message.contains(out) && message.contains(part) && message.lines().count() == 1, "{message}");
    }
    assert_eq!(names(folder.path()), ["folder.png", "quad.glb"]);
}

#[test]
fn textures_that_are_no_pictures_are_warned_about_or_refused() {
    let folder = folder();
    let textured = |image: &str| {
        let mut model = quad();
        model["images"] = json!([{ "uri": image }]);
        model["textures"] = json!([{"source": 0}]);
        model["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = json!({"index": 0});
        model
    };
    fs::write(folder.path().join("text.png"), "not a picture").unwrap();
    fs::write(folder.path().join("huge.png"), png_header(30_000, 30_000)).unwrap();
    fs::write(folder.path().join("secret.png"), png_header(4, 4)).unwrap();
    let models = folder.path().join("models");
    fs::create_dir(&models).unwrap();
    for (image, code, parts) in [
        ("../text.png", vec![0, 1], ["../text.png", ""]),
        ("text.png", vec![0, 1], ["text.png", ""]),
        ("huge.png", vec![0], ["huge.png", "texture_pixels"]),
        ("nothing.png", vec![0, 1], ["nothing.png", ""]),
    ] {
        for name in ["text.png", "huge.png"] {
            fs::copy(folder.path().join(name), models.join(name)).unwrap();
        }
        fs::write(models.join("model.glb"), glb(&textured(image), &quad_buffer())).unwrap();
        let output = overcoat(&models, &["render", "model.glb", "-o", "out.png", "--size", "16"]);
        let message = stderr(&output);
        let status = output.status.code().unwrap();
        assert!(code.contains(&status), "{image}: {status} {message}");
        assert!(!message.is_empty() && parts.iter().all(|part| message.contains(part)), "{image}: {message}");
        assert_eq!(models.join("out.png").exists(), status == 0, "{image}");
        let _ = fs::remove_file(models.join("out.png"));
    }
}

#[test]
fn a_failure_leaves_an_existing_file_as_it_is() {
    let folder = folder();
    let out = folder.path().join("out.png");
    fs::write(&out, "precious").unwrap();
    for (args, code) in
        [(["--limit", "fragments=1"], 3), (["--env", "missing.hdr"], 1), (["--camera", "nobody"], 1)]
    {
        let mut all = vec!["render", "quad.glb", "-o", "out.png"];
        all.extend(args);
        assert_eq!(overcoat(folder.path(), &all).status.code(), Some(code), "{args:?}");
        assert_eq!(fs::read(&out).unwrap(), b"precious");
    }
    // And an input is never an output.
    let copy = overcoat(folder.path(), &["render", "quad.glb", "-o", "./quad.glb", "--output-format", "png"]);
    assert_eq!(copy.status.code(), Some(2), "{}", stderr(&copy));
    assert!(fs::read(folder.path().join("quad.glb")).unwrap().starts_with(b"glTF"));
    assert_eq!(names(folder.path()), ["out.png", "quad.glb"]);
}

#[test]
fn what_a_file_asks_for_in_vain_is_a_warning() {
    let folder = folder();
    let mut model = quad();
    model["extensionsUsed"] = json!(["EXT_smell"]);
    model["animations"] = json!([{"channels": [], "samplers": []}]);
    fs::write(folder.path().join("asks.glb"), glb(&model, &quad_buffer())).unwrap();
    let output = overcoat(folder.path(), &["render", "asks.glb", "-o", "out.png", "--size", "16", "--json"]);
    assert_eq!(output.status.code(), Some(0));
    let message = stderr(&output);
    assert!(!message.is_empty() && message.lines().all(|line| line.starts_with("warning: ")), "{message}");
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    let warnings = report["warnings"].as_array().unwrap();
    assert_eq!(warnings.len(), message.lines().count());
    assert!(warnings.iter().any(|w| w.as_str().unwrap().contains("EXT_smell")), "{warnings:?}");
    let quiet = overcoat(folder.path(), &["render", "asks.glb", "-o", "out.png", "--size", "16", "--quiet"]);
    assert_eq!((quiet.status.code(), stderr(&quiet).as_str()), (Some(0), ""));
}
