//! Runs the program as a user does: exit codes, messages, what is written and what is not.

#[path = "cli/cache.rs"]
mod cache;
#[path = "cli/conformance.rs"]
mod conformance;
#[path = "cli/converters.rs"]
mod converters;
#[path = "cli/diagnose.rs"]
mod diagnose;
#[path = "cli/diff.rs"]
mod diff;
#[path = "cli/error_format.rs"]
mod error_format;
#[path = "cli/guide.rs"]
mod guide;
#[path = "cli/install.rs"]
mod install;
#[path = "cli/lab.rs"]
mod lab;
#[path = "cli/thumbnail.rs"]
mod thumbnail;
#[path = "cli/translate.rs"]
mod translate;
#[path = "cli/views.rs"]
mod views;

use serde_json::{Value, json};
use std::fs;
use std::io::Write;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use tempfile::TempDir;

/// Runs the program in a folder.
fn overcoat(folder: &Path, args: &[&str]) -> Output {
    overcoat_with_input(folder, args, b"")
}

/// Runs the program in a folder with something on standard input.
fn overcoat_with_input(folder: &Path, args: &[&str], input: &[u8]) -> Output {
    let mut child = Command::new(env!("CARGO_BIN_EXE_overcoat"))
        .args(args)
        .current_dir(folder)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // A program that does not read its input closes the pipe; that is its right.
    let _ = child.stdin.take().unwrap().write_all(input);
    child.wait_with_output().unwrap()
}

fn stderr(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

/// A folder with a valid model, `quad.glb`.
fn folder() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("quad.glb"), glb(&quad(), &quad_buffer())).unwrap();
    folder
}

/// Names in a folder, sorted.
fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> =
        fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

const QUAD: [[f32; 3]; 4] = [[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]];

/// Positions, then indices.
fn quad_buffer() -> Vec<u8> {
    let mut bytes: Vec<u8> = QUAD.iter().flatten().flat_map(|v| v.to_le_bytes()).collect();
    bytes.extend([0_u16, 1, 2, 0, 2, 3].iter().flat_map(|v| v.to_le_bytes()));
    bytes
}

/// A red quad of two triangles that faces +Z, with one camera.
fn quad() -> Value {
    json!({
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0, 1]}],
        "nodes": [{"mesh": 0}, {"camera": 0, "translation": [0, 0, 4]}],
        "cameras": [{"name": "eye", "type": "perspective", "perspective": {"yfov": 0.8, "znear": 0.1}}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0}]}],
        "materials": [{"name": "paint", "pbrMetallicRoughness": {
            "baseColorFactor": [0.8, 0.0, 0.0, 1.0], "metallicFactor": 0.0, "roughnessFactor": 0.5}}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3",
             "min": [-1, -1, 0], "max": [1, 1, 0]},
            {"bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR"}
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": 48},
            {"buffer": 0, "byteOffset": 48, "byteLength": 12}
        ],
        "buffers": [{"byteLength": 60}]
    })
}

/// A binary glTF file.
fn glb(json: &Value, buffer: &[u8]) -> Vec<u8> {
    let mut text = json.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let mut binary = buffer.to_vec();
    binary.resize(binary.len().next_multiple_of(4), 0);
    let mut out = b"glTF".to_vec();
    let word = |out: &mut Vec<u8>, v: usize| out.extend((v as u32).to_le_bytes());
    word(&mut out, 2);
    word(&mut out, 12 + 8 + text.len() + 8 + binary.len());
    word(&mut out, text.len());
    out.extend(b"JSON");
    out.extend(text);
    word(&mut out, binary.len());
    out.extend(b"BIN\0");
    out.extend(binary);
    out
}

/// A PNG file that claims a size and has hardly any data.
fn png_header(width: u32, height: u32) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(png::ColorType::Rgba);
    encoder.write_header().unwrap().write_chunk(png::chunk::IDAT, &[0x78, 0x9c]).unwrap();
    bytes
}

/// Size and RGBA pixels of a PNG file.
fn read_png(bytes: &[u8]) -> (u32, u32, Vec<u8>) {
    let mut decoder = png::Decoder::new(std::io::Cursor::new(bytes));
    decoder.set_transformations(png::Transformations::ALPHA);
    let mut reader = decoder.read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut pixels).unwrap();
    (info.width, info.height, pixels)
}

#[test]
fn a_model_becomes_a_picture() {
    let folder = folder();
    let output = overcoat(folder.path(), &["render", "quad.glb", "-o", "quad.png", "--size", "64x48"]);
    assert_eq!((output.status.code(), stderr(&output).as_str()), (Some(0), ""));
    assert!(output.stdout.is_empty());
    let (width, height, pixels) = read_png(&fs::read(folder.path().join("quad.png")).unwrap());
    assert_eq!((width, height), (64, 48));
    let center = &pixels[4 * (24 * 64 + 32)..][..4];
    assert!(center[0] > 60 && center[0] / 2 > center[1] && center[3] == 255, "{center:?}");
    assert_eq!(&pixels[..4], &[0; 4], "the corner is not transparent");
    assert_eq!(names(folder.path()), ["quad.glb", "quad.png"]);
}

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
fn pipes_carry_models_in_and_pictures_out() {
    let folder = folder();
    let model = fs::read(folder.path().join("quad.glb")).unwrap();
    let to_file = overcoat(folder.path(), &["render", "quad.glb", "-o", "out.png", "--size", "32"]);
    assert_eq!(to_file.status.code(), Some(0));
    let file = fs::read(folder.path().join("out.png")).unwrap();
    for format in [None, Some("glb")] {
        let mut args = vec!["render", "-", "-o", "-", "--size", "32"];
        args.extend(format.iter().flat_map(|f| ["--format", f]));
        let piped = overcoat_with_input(folder.path(), &args, &model);
        assert_eq!(piped.status.code(), Some(0), "{}", stderr(&piped));
        assert!(piped.stdout == file, "the pipe's picture differs from the file's");
    }
    let exr =
        overcoat(folder.path(), &["render", "quad.glb", "-o", "-", "--output-format", "exr", "--size", "8"]);
    assert_eq!(&exr.stdout[..4], &[0x76, 0x2f, 0x31, 0x01]);

    let empty = overcoat_with_input(folder.path(), &["render", "-", "-o", "-"], b"");
    assert_eq!(empty.status.code(), Some(1));
    assert!(stderr(&empty).contains("standard input") && empty.stdout.is_empty(), "{}", stderr(&empty));
    // A model read from a pipe has no folder to read more from.
    let mut outside = quad();
    outside["buffers"][0]["uri"] = json!("quad.bin");
    let text = outside.to_string();
    let refused = overcoat_with_input(folder.path(), &["render", "-", "-o", "-"], text.as_bytes());
    assert_eq!(refused.status.code(), Some(1));
    assert!(stderr(&refused).contains("quad.bin"), "{}", stderr(&refused));
    // Two things do not fit into one pipe.
    let both = overcoat(folder.path(), &["render", "quad.glb", "-o", "-", "--json"]);
    assert_eq!(both.status.code(), Some(2));
}

#[test]
fn json_has_what_it_promises() {
    let folder = folder();
    let args = [
        "render",
        "quad.glb",
        "-o",
        "out.png",
        "--size",
        "40x30",
        "--samples",
        "4",
        "--json",
        "--threads",
        "2",
    ];
    let output = overcoat(folder.path(), &args);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    let hash = report["frame_hash"].as_str().unwrap();
    assert!(hash.len() == 32 && hash.chars().all(|c| c.is_ascii_hexdigit()), "{hash}");
    assert_eq!(report["width"], 40);
    assert_eq!(report["height"], 30);
    assert_eq!(report["samples"], 4);
    assert_eq!(report["threads"], 2);
    assert_eq!(report["triangles"], 2);
    assert_eq!(report["shading"], "standard");
    // The defaults of a small picture, and what else may be asked for.
    assert_eq!(report["visibility"], json!({"maps": 48, "map_size": 96, "rays": 0}));
    assert_eq!(report["ground"], "shadow");
    let other = |options: &[&str]| -> Value {
        let output = overcoat(folder.path(), &[&args[..9], options].concat());
        serde_json::from_slice(&output.stdout).unwrap()
    };
    let named = other(&["--quality", "fast", "--ground", "shadow"]);
    assert_eq!(named["frame_hash"], report["frame_hash"]);
    let draft = other(&["--quality", "draft"]);
    assert_eq!((&draft["visibility"]["maps"], &draft["ground"]), (&json!(0), &json!("none")));
    assert_eq!(other(&["--quality", "draft", "--ground", "#0a141e"])["ground"], "#0a141e");
    assert!(report["fragments"].as_u64().unwrap() > 100);
    assert_eq!(report["warnings"], json!([]));
    assert_eq!(report["versions"]["overcoat"], env!("CARGO_PKG_VERSION"));
    let stages = report["stages_ms"].as_object().unwrap();
    assert!(stages.contains_key("load") && stages.contains_key("encode") && stages.len() > 4, "{stages:?}");
    assert!(stages.values().all(|ms| ms.as_f64().is_some_and(|ms| ms >= 0.0)), "{stages:?}");
    if cfg!(target_os = "linux") {
        assert!(report["peak_rss_bytes"].as_u64().unwrap() > 1 << 20);
    }

    // SIMD level of every processor of the architecture: like the other options it never changes the picture.
    fn baseline() -> &'static str {
        if cfg!(target_arch = "x86_64") {
            "sse2"
        } else if cfg!(target_arch = "aarch64") {
            "neon"
        } else {
            "scalar"
        }
    }
    for options in [["--threads", "1"], ["--tile", "16"], ["--simd", baseline()]] {
        let mut all = args.to_vec();
        all.truncate(9);
        all.extend(options);
        let other: Value = serde_json::from_slice(&overcoat(folder.path(), &all).stdout).unwrap();
        assert_eq!(other["frame_hash"], report["frame_hash"], "{options:?}");
    }
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

#[test]
fn planes_go_beside_a_png_and_into_an_exr() {
    let folder = folder();
    let args = ["render", "quad.glb", "-o", "out.png", "--size", "16", "--aov", "depth,normal"];
    assert_eq!(overcoat(folder.path(), &args).status.code(), Some(0));
    assert_eq!(names(folder.path()), ["out.depth.png", "out.normal.png", "out.png", "quad.glb"]);
    let args = ["render", "quad.glb", "-o", "out.exr", "--size", "16", "--aov", "depth,uv"];
    assert_eq!(overcoat(folder.path(), &args).status.code(), Some(0));
    let exr = fs::read(folder.path().join("out.exr")).unwrap();
    let has = |name: &[u8]| exr.windows(name.len()).any(|w| w.eq_ignore_ascii_case(name));
    assert!(has(b"depth") && has(b"uv"));
}

/// Masks hold the numbers that the report names and counts.
#[test]
fn masks_are_numbers_and_reports_say_of_what() {
    let folder = tempfile::tempdir().unwrap();
    let square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 3 0 0\nv 4 0 0\nv 4 1 0\nv 3 1 0\n";
    fs::write(folder.path().join("two.obj"), format!("{square}o left\nf 1 2 3 4\no right\nf 5 6 7 8\n"))
        .unwrap();
    let draw = |more: &[&str]| {
        let args = [
            "render", "two.obj", "-o", "out.png", "--size", "40", "--up", "+y", "--view", "front", "--ortho",
            "--json",
        ];
        let output = overcoat(folder.path(), &[&args, more].concat());
        assert!(output.status.success(), "{}", stderr(&output));
        serde_json::from_slice::<Value>(&output.stdout).unwrap()
    };
    assert!(draw(&["--aov", "depth"]).get("ids").is_none());
    for sample in ["center", "nearest"] {
        let report = draw(&["--aov", "object-id", "--aov-sample", sample]);
        let bytes = fs::read(folder.path().join("out.object-id.png")).unwrap();
        let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().unwrap();
        let mut mask = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut mask).unwrap();
        assert_eq!((info.color_type, info.bit_depth), (png::ColorType::Grayscale, png::BitDepth::Sixteen));
        let ids = report["ids"]["object-id"].as_array().unwrap();
        assert_eq!(ids.iter().map(|of| of["name"].as_str().unwrap()).collect::<Vec<_>>(), ["left", "right"]);
        for (k, of) in ids.iter().enumerate() {
            let pixels = mask.chunks(2).filter(|pixel| **pixel == [0, k as u8 + 1]).count();
            assert!(pixels > 50, "{pixels}");
            assert_eq!(of["id"], k + 1);
            assert_eq!(of["px_count_visib"], pixels);
            assert_eq!(of["visib_fract"], 1.0);
            assert_eq!(of["bbox_visib"].as_array().map(Vec::len), Some(4));
            assert_eq!(of["bbox_obj"].as_array().map(Vec::len), Some(4));
        }
    }
}

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

#[test]
fn a_picture_of_nothing_is_a_failure() {
    let folder = folder();
    fs::write(folder.path().join("flat.obj"), "v 0 0 0\nv 1 0 0\nf 1 1 2\n").unwrap();
    let mut clear = quad();
    clear["materials"][0]["alphaMode"] = "BLEND".into();
    clear["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"] = json!([1, 1, 1, 0]);
    fs::write(folder.path().join("clear.glb"), glb(&clear, &quad_buffer())).unwrap();
    let mut nothing = quad();
    nothing["nodes"] = json!([{}, {}]);
    nothing["meshes"] = json!([]);
    fs::write(folder.path().join("nothing.glb"), glb(&nothing, &quad_buffer())).unwrap();
    let before = names(folder.path());
    for (line, reason) in [
        ("render flat.obj", "have no area"),
        ("render clear.glb", "transparent all over"),
        ("render clear.glb --background env", "transparent all over"),
        ("render nothing.glb", "no triangles"),
        ("render quad.glb --eye 0,0,5 --target 0,0,9", "behind the camera; --view"),
        ("render quad.glb --eye 0,0,5 --target 9,0,5", "beside the picture; --view"),
        ("render quad.glb --eye 0,0,-5", "seen from behind; --view"),
        ("render quad.glb --eye 0,0,90000", "smaller than a pixel; --eye"),
        ("turntable clear.glb --frames 3", "transparent all over"),
        ("animate nothing.glb --animation 0", "no triangles"),
        ("compare-models clear.glb --models gltf,three", "transparent all over"),
        ("diff quad.glb clear.glb", "transparent all over"),
    ] {
        let mut args: Vec<&str> = line.split(' ').collect();
        let animated = args[0] == "animate";
        if animated {
            nothing["animations"] = json!([{"channels": [], "samplers": []}]);
            fs::write(folder.path().join("nothing.glb"), glb(&nothing, &quad_buffer())).unwrap();
        }
        args.extend(["-o", "out.png", "--size", "24"]);
        let output = overcoat(folder.path(), &args);
        let message = stderr(&output);
        let last = message.lines().last().unwrap_or_default();
        assert_eq!(output.status.code(), Some(1), "{line}: {message}");
        assert!(last.contains("nothing to see: ") && last.contains(reason), "{line}: {message}");
        assert_eq!(names(folder.path()), before, "{line}");
        args.push("--allow-empty");
        let output = overcoat(folder.path(), &args);
        let message = stderr(&output);
        assert_eq!(output.status.code(), Some(0), "{line}: {message}");
        assert!(message.contains("warning: nothing to see: "), "{line}: {message}");
        fs::remove_file(folder.path().join("out.png")).unwrap();
    }
    let bench = overcoat(folder.path(), &["bench", "clear.glb", "--frames", "1", "--size", "24"]);
    assert_eq!(bench.status.code(), Some(1), "{}", stderr(&bench));
    // Every cell of a sheet must have something to see.
    let sheet = ["sheet", "quad.glb", "flat.obj", "-o", "out.png", "--size", "24", "--json"];
    let output = overcoat(folder.path(), &sheet);
    assert_eq!(output.status.code(), Some(1));
    assert!(stderr(&output).contains("1 of 2"), "{}", stderr(&output));
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert!(report["cells"][1]["error"].as_str().unwrap().contains("nothing to see"), "{report}");
    let allowed = overcoat(folder.path(), &[&sheet[..], &["--allow-empty"]].concat());
    assert_eq!(allowed.status.code(), Some(0), "{}", stderr(&allowed));
}

#[test]
fn hardly_anything_to_see_is_a_warning_that_helps() {
    let folder = folder();
    let far = ["render", "quad.glb", "-o", "out.png", "--size", "64", "--eye", "0,0,200"];
    let message = stderr(&overcoat(folder.path(), &far));
    assert!(message.contains("hardly anything to see") && message.contains("--view"), "{message}");
    // A crowd of triangles, and a stray one.
    let mut text = String::new();
    for k in 0..400 {
        let [x, y, z] = [k % 8, k / 8 % 8, k / 64].map(|v| f64::from(v) * 0.25);
        text += &format!("v {x} {y} {z}\nv {} {y} {z}\nv {x} {} {z}\nf -3 -2 -1\n", x + 0.2, y + 0.2);
    }
    text += "v 70 0 0\nv 71 0 0\nv 70 1 0\nf -3 -2 -1\n";
    fs::write(folder.path().join("stray.obj"), text).unwrap();
    let draw = |more: &[&str]| {
        let args = [&["render", "stray.obj", "-o", "out.png", "--size", "128"], more].concat();
        let message = stderr(&overcoat(folder.path(), &args));
        let (_, _, pixels) = read_png(&fs::read(folder.path().join("out.png")).unwrap());
        (message, pixels.chunks(4).filter(|p| p[3] > 0).count())
    };
    // The crowd is framed, and the warning says from where all can be seen; from there, what helps.
    let (message, covered) = draw(&[]);
    assert!(message.contains("1 of 401 triangles are far from all others"), "{message}");
    assert!(covered > 128 * 128 / 8, "{covered} pixels");
    let place = |message: &str| -> [String; 4] {
        let words: Vec<&str> = message.split_whitespace().collect();
        let at = words.iter().position(|w| *w == "--eye").unwrap();
        std::array::from_fn(|k| words[at + k].to_owned())
    };
    let place_of_all = place(&message);
    let (message, covered) = draw(&place_of_all.each_ref().map(String::as_str));
    assert!(message.contains("all but 1 of 401 triangles are within"), "{message}");
    assert!(covered > 0 && covered < 128 * 128 / 50, "{covered} pixels");
    let closer = place(&message);
    let (message, covered) = draw(&closer.each_ref().map(String::as_str));
    assert_eq!(message, "");
    assert!(covered > 128 * 128 / 8, "{covered} pixels");
}

/// Points are discs, which a frame does not cut, and a few of them far away do not make the others a speck.
#[test]
fn clouds_fill_the_picture_and_stay_within_it() {
    let folder = folder();
    let lattice: Vec<[f64; 3]> = (0..400).map(|k| [f64::from(k % 20), f64::from(k / 20), 0.0]).collect();
    let strays: Vec<[f64; 3]> =
        (0..3).map(f64::from).map(|k| [900.0 * k, 700.0 - 800.0 * k, 600.0]).collect();
    let ply = |points: &[[f64; 3]]| {
        let lines: String = points.iter().map(|[x, y, z]| format!("{x} {y} {z}\n")).collect();
        format!(
            "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n\
             end_header\n{lines}",
            points.len()
        )
    };
    fs::write(folder.path().join("cloud.ply"), ply(&lattice)).unwrap();
    fs::write(folder.path().join("strays.ply"), ply(&[&lattice[..], &strays].concat())).unwrap();
    let warning = "3 of 403 points are far from all others";
    for (file, warns) in [("cloud.ply", false), ("strays.ply", true)] {
        let output = overcoat(folder.path(), &["render", file, "-o", "out.png", "--size", "96"]);
        let message = stderr(&output);
        assert_eq!(message.matches(warning).count(), usize::from(warns), "{message}");
        let (width, height, pixels) = read_png(&fs::read(folder.path().join("out.png")).unwrap());
        let alpha = |x: u32, y: u32| pixels[(4 * (y * width + x) + 3) as usize];
        let border = (0..width).flat_map(|k| [[k, 0], [k, height - 1], [0, k], [width - 1, k]]);
        assert!(border.into_iter().all(|[x, y]| alpha(x, y) == 0), "{file}");
        let covered = pixels.chunks(4).filter(|p| p[3] > 0).count();
        assert!(covered > 96 * 96 / 2, "{file}: {covered} pixels");
    }
    let turn = ["turntable", "strays.ply", "-o", "turn.png", "--frames", "2", "--size", "32"];
    let message = stderr(&overcoat(folder.path(), &turn));
    assert_eq!(message.matches(warning).count(), 1, "{message}");
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

/// Coloured glass before nothing looks grey, which is said; before something it does not, and nothing is said.
#[test]
fn a_tint_that_a_background_cannot_carry_is_a_warning() {
    let folder = folder();
    let mut pane = quad();
    pane["materials"][0]["pbrMetallicRoughness"] =
        json!({"baseColorFactor": [1.0, 0.1, 0.1, 1.0], "metallicFactor": 0.0, "roughnessFactor": 0.0});
    pane["materials"][0]["extensions"] = json!({"KHR_materials_transmission": {"transmissionFactor": 1.0}});
    pane["extensionsUsed"] = json!(["KHR_materials_transmission"]);
    let write = |name: &str, model: &Value| {
        fs::write(folder.path().join(name), glb(model, &quad_buffer())).unwrap();
    };
    write("pane.glb", &pane);
    let mut gray = pane.clone();
    gray["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"] = json!([0.5, 0.5, 0.5, 1.0]);
    write("gray.glb", &gray);
    // Half as large, before a wall.
    let mut before = pane.clone();
    before["materials"].as_array_mut().unwrap().push(json!({"name": "wall"}));
    let mut wall = before["meshes"][0].clone();
    wall["primitives"][0]["material"] = json!(1);
    before["meshes"].as_array_mut().unwrap().push(wall);
    before["nodes"][0] = json!({"mesh": 0, "scale": [0.5, 0.5, 1.0], "translation": [0, 0, 0.1]});
    before["nodes"].as_array_mut().unwrap().push(json!({"mesh": 1}));
    before["scenes"][0]["nodes"] = json!([0, 1, 2]);
    write("before.glb", &before);

    let draw = |options: &[&str]| {
        let args = ["render", "-o", "out.png", "--size", "16", "--view", "front"];
        let output = overcoat(folder.path(), &[&args, options].concat());
        assert_eq!(output.status.code(), Some(0), "{options:?}: {}", stderr(&output));
        // With a report the picture is made of a frame, without one it is not.
        let bytes = fs::read(folder.path().join("out.png")).unwrap();
        let reported = overcoat(folder.path(), &[&args, options, &["--json"]].concat());
        assert_eq!(stderr(&reported), stderr(&output), "{options:?}");
        assert!(fs::read(folder.path().join("out.png")).unwrap() == bytes, "{options:?}");
        (stderr(&output), middle(folder.path(), "out.png"))
    };
    let (warnings, [r, g, b]) = draw(&["pane.glb", "--background", "transparent"]);
    assert!(warnings.starts_with("warning: glass") && warnings.lines().count() == 1, "{warnings}");
    assert!(warnings.contains("--background env"), "{warnings}");
    assert!(r.abs_diff(g) < 8 && r.abs_diff(b) < 8, "not grey: {r} {g} {b}");
    for model in ["gray.glb", "before.glb", "quad.glb"] {
        assert_eq!(draw(&[model, "--background", "transparent"]).0, "", "{model}");
    }
    let (warnings, [r, g, b]) = draw(&["pane.glb", "--background", "white"]);
    assert_eq!(warnings, "");
    assert!(r > 220 && g < 140 && b < 140, "not red: {r} {g} {b}");
    // A linear picture says it by colour.
    let linear = ["render", "pane.glb", "-o", "out.exr", "--size", "16", "--view", "front"];
    assert_eq!(stderr(&overcoat(folder.path(), &linear)), "");
    let (warnings, [r, g, b]) = draw(&["pane.glb", "--background", "env"]);
    assert!(warnings.is_empty() && r / 2 > g && r / 2 > b, "{warnings} {r} {g} {b}");
    let (_, [r, g, b]) = draw(&["before.glb"]);
    assert!(r / 2 > g && r / 2 > b, "{r} {g} {b}");
    // One line, however many frames.
    let turn = ["turntable", "pane.glb", "-o", "turn.png", "--frames", "3", "--size", "16"];
    let output = overcoat(folder.path(), &turn);
    assert_eq!((output.status.code(), stderr(&output).lines().count()), (Some(0), 1), "{}", stderr(&output));
    let bytes = fs::read(folder.path().join("turn.png")).unwrap();
    assert!(overcoat(folder.path(), &[&turn[..], &["--json"]].concat()).status.success());
    assert!(fs::read(folder.path().join("turn.png")).unwrap() == bytes);
}

#[test]
fn bench_reports_each_stage_and_a_hash() {
    let folder = folder();
    let args = ["bench", "quad.glb", "--frames", "3", "--size", "32", "--json"];
    let run = || -> Value {
        let output = overcoat(folder.path(), &args);
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        serde_json::from_slice(&output.stdout).unwrap()
    };
    let (a, b) = (run(), run());
    assert_eq!(a["frames"], 3);
    assert!(a["frames_hash"].is_string());
    assert_eq!(a["frames_hash"], b["frames_hash"]);
    assert!(a["frame_ms"]["median"].as_f64().unwrap() >= a["frame_ms"]["min"].as_f64().unwrap());
    assert!(a["stages_ms"].as_object().unwrap().len() >= 3);
}

/// Each frame is another file; the hashes are those of `overcoat render` of that quality, whatever was rendered before.
#[test]
fn bench_loads_a_model_each_frame() {
    let folder = folder();
    let mut blue = quad();
    blue["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"] = json!([0, 0, 1, 1]);
    fs::write(folder.path().join("blue.glb"), glb(&blue, &quad_buffer())).unwrap();
    let json = |args: &[&str]| -> Value {
        let output = overcoat(folder.path(), &[args, &["--size", "32", "--json"]].concat());
        assert_eq!((output.status.code(), stderr(&output).as_str()), (Some(0), ""), "{args:?}");
        serde_json::from_slice(&output.stdout).unwrap()
    };
    let bench = ["bench", "quad.glb", "blue.glb", "quad.glb", "--rounds", "2"];
    let report = json(&[&bench[..], &["--png"]].concat());
    assert_eq!((&report["frames"], &report["triangles"]), (&json!(6), &json!(2)));
    // Pictures of 8 bits have hashes of their own.
    let images = json(&[&bench[..], &["--image"]].concat());
    assert!(report["images_hash"].is_string() && report["frames_hash"].is_null());
    assert_eq!(report["images_hash"], images["images_hash"]);
    let image_hash = |k: usize| report["models"][k]["image_hash"].as_str().unwrap().to_owned();
    assert_eq!((image_hash(0), image_hash(0) == image_hash(1)), (image_hash(2), false));
    assert!(report["frame_ms"]["median"].as_f64().unwrap() >= report["frame_ms"]["min"].as_f64().unwrap());
    for stage in ["load", "prepare", "tiles", "encode", "release"] {
        assert!(report["stages_ms"][stage]["median"].is_number(), "{stage}");
    }
    let expected = ["quad.glb", "blue.glb", "quad.glb"].map(|name| {
        let rendered = json(&["render", name, "-o", "out.png", "--quality", "draft"]);
        (name.to_owned(), rendered["frame_hash"].as_str().unwrap().to_owned())
    });
    let report = json(&bench);
    let found: Vec<(String, String)> = report["models"]
        .as_array()
        .unwrap()
        .iter()
        .map(|m| (m["file"].as_str().unwrap().to_owned(), m["frame_hash"].as_str().unwrap().to_owned()))
        .collect();
    assert_eq!(found, expected);
    assert_ne!(found[0].1, found[1].1);

    let report = json(&["bench", "quad.glb", "blue.glb"]);
    assert_eq!((&report["frames"], &report["stages_ms"]["encode"]), (&json!(2), &Value::Null));
    // Nothing was written but what `render` wrote.
    assert_eq!(names(folder.path()), ["blue.glb", "out.png", "quad.glb"]);
    for (args, code, word) in [
        (&["bench", "quad.glb", "none.glb"][..], 1, "none.glb"),
        (&["bench", "quad.glb", "-"], 2, "standard input"),
        (&["bench", "quad.glb", "--rounds", "2", "--frames", "3"], 2, "--frames"),
    ] {
        let output = overcoat(folder.path(), args);
        assert_eq!(output.status.code(), Some(code), "{args:?}");
        assert!(stderr(&output).contains(word), "{args:?}: {}", stderr(&output));
    }
}

#[test]
fn help_has_examples_and_version_is_a_line() {
    let folder = tempfile::tempdir().unwrap();
    let help = overcoat(folder.path(), &["--help"]);
    assert_eq!(help.status.code(), Some(0));
    assert!(String::from_utf8(help.stdout).unwrap().contains("overcoat car.glb"));
    for command in ["render", "info", "sheet", "bench"] {
        let help = overcoat(folder.path(), &[command, "--help"]);
        assert_eq!(help.status.code(), Some(0));
        assert!(String::from_utf8(help.stdout).unwrap().contains("Example"), "{command}");
    }
    let version = overcoat(folder.path(), &["--version"]);
    assert_eq!(
        String::from_utf8(version.stdout).unwrap(),
        format!("overcoat {}\n", env!("CARGO_PKG_VERSION"))
    );
}

/// Red, green and blue of the pixel in the middle of a 16 x 16 picture.
fn middle(folder: &Path, name: &str) -> [u8; 3] {
    let (_, _, pixels) = read_png(&fs::read(folder.join(name)).unwrap());
    let at = 4 * (8 * 16 + 8);
    [pixels[at], pixels[at + 1], pixels[at + 2]]
}

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

/// A decoded picture file.
fn decode(path: &Path) -> overcoat::decode::DecodedPicture {
    overcoat::decode::DecodedPicture::open(path, &overcoat::Limits::default()).unwrap()
}

/// WebP holds the pixels of PNG; JPEG what they look like on white, and less of it for less quality.
#[test]
fn pictures_are_written_as_webp_and_jpeg() {
    let folder = folder();
    let run = |args: &[&str]| {
        let output = overcoat(folder.path(), &[args, &["--size", "48"]].concat());
        assert_eq!(output.status.code(), Some(0), "{args:?}: {}", stderr(&output));
        (output.stdout.clone(), stderr(&output))
    };
    let size = |name: &str| fs::metadata(folder.path().join(name)).unwrap().len();
    for name in ["a.png", "a.webp", "a.jpg", "a.JPEG"] {
        assert_eq!(run(&["render", "quad.glb", "-o", name]).1, "", "{name}");
    }
    let [png, webp, jpg] = ["a.png", "a.webp", "a.jpg"].map(|name| decode(&folder.path().join(name)));
    assert_eq!(png, webp);
    // JPEG's blocks ring where the quad ends.
    assert!(jpg.pixels[0][..3].iter().all(|&v| v > 240.0), "no white corner: {:?}", jpg.pixels[0]);
    assert_eq!(
        fs::read(folder.path().join("a.jpg")).unwrap(),
        fs::read(folder.path().join("a.JPEG")).unwrap()
    );
    run(&["render", "quad.glb", "-o", "poor.jpg", "--jpeg-quality", "20"]);
    assert!(size("poor.jpg") < size("a.jpg"));
    // Through a pipe, and with a report, in which case the picture is made of a frame.
    let (piped, _) = run(&["render", "quad.glb", "-o", "-", "--output-format", "webp"]);
    assert_eq!(piped, fs::read(folder.path().join("a.webp")).unwrap());
    run(&["render", "quad.glb", "-o", "b.jpg", "--json"]);
    assert_eq!(
        fs::read(folder.path().join("b.jpg")).unwrap(),
        fs::read(folder.path().join("a.jpg")).unwrap()
    );
    // White is said where something else was asked for.
    let (_, warning) = run(&["render", "quad.glb", "-o", "c.jpg", "--background", "transparent"]);
    assert_eq!(warning, "warning: JPEG has no transparency: white is behind the picture\n");
    let (_, warning) = run(&["render", "quad.glb", "-o", "c.jpg", "--background", "0000ff"]);
    let corner = decode(&folder.path().join("c.jpg")).pixels[0];
    assert!(warning.is_empty() && corner[2] > 240.0 && corner[0] < 16.0, "{warning} {corner:?}");

    for command in [
        &["sheet", "quad.glb"][..],
        &["compare-models", "quad.glb", "--models", "gltf"],
        &["diff", "quad.glb", "quad.glb"],
    ] {
        let [png, webp, jpg] = ["s.png", "s.webp", "s.jpg"].map(|name| {
            run(&[command, &["-o", name]].concat());
            decode(&folder.path().join(name))
        });
        assert_eq!(png, webp);
        assert_eq!([png.width, png.height], [jpg.width, jpg.height]);
    }
    run(&["turntable", "quad.glb", "-o", "t-#.jpg", "--frames", "2"]);
    run(&["turntable", "quad.glb", "-o", "t-#.webp", "--frames", "2"]);
    run(&["turntable", "quad.glb", "-o", "t-#.png", "--frames", "2"]);
    let at = |name: &str| decode(&folder.path().join(name));
    assert_eq!(at("t-1.png"), at("t-1.webp"));
    assert!(at("t-0.jpg").pixels[0][..3].iter().all(|&v| v > 240.0));
    let (movie, _) = run(&["turntable", "quad.glb", "-o", "-", "--frames", "2", "--output-format", "webp"]);
    assert!(movie.starts_with(b"RIFF"));
}

/// Every command that has results has them as JSON: names in snake_case, warnings, versions.
#[test]
fn json_is_alike_everywhere() {
    fn check(command: &str, value: &Value) {
        match value {
            Value::Object(entries) => {
                for (key, value) in entries {
                    let is_name =
                        key.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_');
                    assert!(is_name, "{command}: {key}");
                    check(command, value);
                }
            }
            Value::Array(values) => values.iter().for_each(|value| check(command, value)),
            _ => {}
        }
    }
    let folder = folder();
    for name in ["e", "a"] {
        fs::create_dir(folder.path().join(name)).unwrap();
        let args = ["render", "quad.glb", "--size", "8", "-o", &format!("{name}/x.png")];
        assert!(overcoat(folder.path(), &args).status.success());
    }
    for line in [
        "render quad.glb -o x.png --size 8",
        "render quad.glb -o x.png --size 8 --stage-hashes",
        "turntable quad.glb -o x.png --size 8 --frames 1",
        "info quad.glb",
        "diagnose quad.glb",
        "sheet quad.glb -o x.png --size 8",
        "bench quad.glb --size 8 --frames 1",
        "bench quad.glb quad.glb --size 8 --image",
        "compare-models quad.glb -o x.png --size 8 --models gltf",
        "diff quad.glb quad.glb -o x.png --size 8",
        "materials",
        "materials --keys",
        "materials velvet",
        "formats",
        "golden check e a",
        "golden report e a -o x.html",
        "golden accept e a x.png",
    ] {
        let args: Vec<&str> = line.split(' ').chain(["--json"]).collect();
        let output = overcoat(folder.path(), &args);
        assert_eq!(output.status.code(), Some(0), "{line}: {}", stderr(&output));
        let report: Value = serde_json::from_slice(&output.stdout).unwrap_or_else(|e| panic!("{line}: {e}"));
        check(line, &report);
        assert!(report["warnings"].is_array(), "{line} has no warnings");
        assert_eq!(report["versions"]["overcoat"], env!("CARGO_PKG_VERSION"), "{line}");
    }
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
