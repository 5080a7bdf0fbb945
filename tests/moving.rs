//! Moving pictures by the program: `overcoat turntable`, `overcoat animate`, and poses of `overcoat render`.

use image::AnimationDecoder;
use serde_json::{Value, json};
use std::fs;
use std::io::Cursor;
use std::path::Path;
use std::process::{Command, Output};
use tempfile::TempDir;

fn overcoat(folder: &Path, args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_overcoat")).args(args).current_dir(folder).output().unwrap()
}

fn stderr(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

/// A triangle 1 m wide that walks 3 m along x within 2 s, then is called back at once: `walk.gltf`.
fn folder() -> TempDir {
    let floats = [
        [-0.5, 0.0, 0.0, 0.5, 0.0, 0.0, 0.0, 1.0, 0.0].as_slice(),
        &[0.0, 2.0],
        &[0.0, 0.0, 0.0, 3.0, 0.0, 0.0],
    ]
    .concat();
    let bytes: Vec<u8> = floats.iter().flat_map(|v: &f32| v.to_le_bytes()).collect();
    let hex: String = bytes.iter().map(|b| format!("%{b:02x}")).collect();
    let view = |at: usize, length: usize| json!({"buffer": 0, "byteOffset": at, "byteLength": length});
    let accessor = |view: usize, count: usize, kind: &str| json!({"bufferView": view, "componentType": 5126, "count": count, "type": kind});
    let model = json!({
        "asset": {"version": "2.0"},
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0}]}],
        "materials": [{"doubleSided": true, "pbrMetallicRoughness": {"metallicFactor": 0}}],
        "animations": [{
            "name": "walk",
            "channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}],
            "samplers": [{"input": 1, "output": 2}],
        }],
        "accessors": [accessor(0, 3, "VEC3"), accessor(1, 2, "SCALAR"), accessor(2, 2, "VEC3")],
        "bufferViews": [view(0, 36), view(36, 8), view(44, 24)],
        "buffers": [{"byteLength": bytes.len(), "uri": format!("data:,{hex}")}],
    });
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("walk.gltf"), model.to_string()).unwrap();
    folder
}

fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> =
        fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

/// Columns of the first and the last pixel that shows something.
fn columns(pixels: &[u8], width: usize) -> (usize, usize) {
    let seen = pixels.chunks(4).enumerate().filter(|(_, p)| p[3] > 0).map(|(k, _)| k % width);
    seen.fold((width, 0), |(low, high), x| (low.min(x), high.max(x)))
}

#[test]
fn an_animation_is_played_in_a_picture_that_stays() {
    let folder = folder();
    let args = [
        "animate",
        "walk.gltf",
        "-o",
        "walk.png",
        "--size",
        "64x32",
        "--fps",
        "4",
        "--view",
        "front",
        "--ground",
        "none",
    ];
    let done = overcoat(folder.path(), &[&args[..], &["--json"]].concat());
    assert_eq!((done.status.code(), stderr(&done).as_str()), (Some(0), ""));
    let report: Value = serde_json::from_slice(&done.stdout).unwrap();
    assert_eq!((&report["frames"], &report["width"]), (&json!(8), &json!(64)));
    let file = fs::read(folder.path().join("walk.png")).unwrap();
    let apng = image::codecs::png::PngDecoder::new(Cursor::new(file)).unwrap().apng().unwrap();
    let frames = apng.into_frames().collect_frames().unwrap();
    assert_eq!(frames.len(), 8);
    let mut last = None;
    for frame in &frames {
        assert_eq!(frame.delay().numer_denom_ms(), (250, 1));
        let (low, high) = columns(frame.buffer().as_raw(), 64);
        // It goes to the right, always as wide, and never leaves the picture.
        assert!((10..=20).contains(&(high - low)) && low > 0 && high < 63, "{low} to {high}");
        assert!(last.is_none_or(|last| low > last), "{low}");
        last = Some(low);
    }

    // The same frames as lossless WebP, and a part of them as numbered pictures.
    let mut other = args;
    other[3] = "walk.webp";
    assert_eq!(overcoat(folder.path(), &other).status.code(), Some(0));
    let file = fs::read(folder.path().join("walk.webp")).unwrap();
    let webp = image::codecs::webp::WebPDecoder::new(Cursor::new(file)).unwrap();
    let same = webp.into_frames().collect_frames().unwrap();
    assert!(same.iter().zip(&frames).all(|(a, b)| a.buffer() == b.buffer()) && same.len() == 8);
    other[3] = "walk-###.png";
    let part = overcoat(folder.path(), &[&other[..], &["--from", "0.5", "--to", "1"]].concat());
    assert_eq!((part.status.code(), stderr(&part).as_str()), (Some(0), ""));
    assert_eq!(names(folder.path()), ["walk-000.png", "walk-001.png", "walk.gltf", "walk.png", "walk.webp"]);
}

/// Files within a size goal: pictures are as large as it allows.
#[test]
fn a_file_has_no_more_bytes_than_it_may_have() {
    let folder = folder();
    let turn = |name: &str, more: &[&str]| {
        let args = ["turntable", "walk.gltf", "-o", name, "--frames", "6", "--size", "96", "--view", "front"];
        overcoat(folder.path(), &[&args[..], more].concat())
    };
    let size = |name: &str| fs::metadata(folder.path().join(name)).unwrap().len();
    for name in ["turn.gif", "turn.webp", "turn.png"] {
        let done = turn(name, &["--quality", "draft"]);
        assert_eq!((done.status.code(), stderr(&done).as_str()), (Some(0), ""), "{name}");
        let all = size(name);
        // A goal above the size changes nothing.
        let same = turn(name, &["--quality", "draft", "--max-bytes", "1M"]);
        assert_eq!((same.status.code(), stderr(&same).as_str(), size(name)), (Some(0), "", all), "{name}");
        let most = all * 3 / 4;
        let done = turn(name, &["--quality", "draft", "--json", "--max-bytes", &most.to_string()]);
        let report: Value = serde_json::from_slice(&done.stdout).unwrap();
        let width = report["width"].as_u64().unwrap();
        assert!(size(name) <= most && (32..96).contains(&width), "{name}: {} of {most}, {width}", size(name));
        assert_eq!((&report["bytes"], &report["frames"]), (&json!(size(name)), &json!(6)));
        let expected =
            format!("{width} x {width} pixels in place of 96 x 96: the file may have {most} bytes");
        assert!(stderr(&done).contains(&expected), "{}", stderr(&done));
    }
    let file = fs::read(folder.path().join("turn.gif")).unwrap();
    let gif = image::codecs::gif::GifDecoder::new(Cursor::new(file)).unwrap();
    assert_eq!(gif.into_frames().collect_frames().unwrap().len(), 6);
    for (more, code, message) in [
        (&["--max-bytes", "300"][..], 1, "smaller ones show nothing"),
        (&["--max-bytes", "0"], 2, "expected at least 1"),
        (&["--output-format", "png"], 2, "the name says GIF, --output-format says png"),
    ] {
        let done = turn("no.gif", more);
        assert_eq!(done.status.code(), Some(code));
        assert!(stderr(&done).contains(message), "{}", stderr(&done));
    }
    assert!(stderr(&turn("no-#.png", &["--max-bytes", "1M"])).contains("for one file"));
    assert_eq!(names(folder.path()), ["turn.gif", "turn.png", "turn.webp", "walk.gltf"]);
}

#[test]
fn a_turn_shows_a_flat_model_from_all_sides() {
    let folder = folder();
    for turn in ["model", "camera"] {
        let done = overcoat(
            folder.path(),
            &[
                "turntable",
                "walk.gltf",
                "-o",
                "turn-#.png",
                "--frames",
                "4",
                "--size",
                "32",
                "--view",
                "front",
                "--turn",
                turn,
                "--ground",
                "none",
            ],
        );
        assert_eq!((done.status.code(), stderr(&done).as_str()), (Some(0), ""));
        let widths: Vec<usize> = (0..4)
            .map(|k| {
                let file = fs::read(folder.path().join(format!("turn-{k}.png"))).unwrap();
                let picture = image::load_from_memory(&file).unwrap().to_rgba8();
                let (low, high) = columns(picture.as_raw(), 32);
                (high + 1).saturating_sub(low)
            })
            .collect();
        // From the front and from behind as wide, from the sides nothing.
        assert!(widths[0] > 20 && widths[0].abs_diff(widths[2]) <= 1, "{turn}: {widths:?}");
        assert!(widths[1] <= 1 && widths[3] <= 1, "{turn}: {widths:?}");
    }
}

#[test]
fn poses_of_still_pictures() {
    let folder = folder();
    fs::write(
        folder.path().join("scene.toml"),
        "model = 'walk.gltf'\nanimation = 'walk'\ntime = 3.0\nloop = true\n",
    )
    .unwrap();
    let bounds = ["--eye", "0,0.5,20", "--target", "0,0.5,0", "--size", "32", "--json", "-o", "out.png"];
    let hash = |args: &[&str]| {
        let done = overcoat(folder.path(), &[&["render"], args, &bounds[..]].concat());
        assert_eq!(done.status.code(), Some(0), "{}", stderr(&done));
        let report: Value = serde_json::from_slice(&done.stdout).unwrap();
        (report["frame_hash"].as_str().unwrap().to_owned(), stderr(&done))
    };
    let stored = hash(&["walk.gltf"]);
    let begin = hash(&["walk.gltf", "--animation", "0"]);
    let middle = hash(&["walk.gltf", "--animation", "walk", "--time", "1"]);
    let beyond = hash(&["walk.gltf", "--animation", "walk", "--time", "3"]);
    assert_eq!(stored, begin);
    assert_ne!(begin.0, middle.0);
    assert_eq!(hash(&["--scene", "scene.toml"]), middle);
    assert_eq!(beyond.1, "warning: animation 0 'walk' ends at 2 s: its last pose is drawn\n");
    let info = overcoat(folder.path(), &["info", "walk.gltf"]);
    assert!(String::from_utf8(info.stdout).unwrap().contains("animation 0 'walk': 2.000 s, 1 channels"));
}

#[test]
fn what_cannot_be_played_leaves_no_file() {
    let folder = folder();
    let cases: [(&[&str], i32, &str); 7] = [
        (&["animate", "walk.gltf", "-o", "a.png", "--animation", "run"], 1, "the file has 0 'walk'"),
        (&["animate", "walk.gltf", "-o", "a.bmp"], 2, "unknown format"),
        (&["animate", "walk.gltf", "-o", "a.png", "--from", "5"], 2, "nothing to play"),
        (&["animate", "walk.gltf", "-o", "a.png", "--to", "1000", "--fps", "100"], 3, "(frames)"),
        (&["animate", "walk.gltf", "-o", "walk.gltf"], 2, "unknown format"),
        (&["turntable", "walk.gltf", "-o", "a.png", "--frames", "9999"], 3, "(frames)"),
        // The frame that is too much comes after others.
        (
            &["turntable", "walk.gltf", "-o", "a#.png", "--frames", "9", "--limit", "decoded_bytes=24k"],
            3,
            "frames up to",
        ),
    ];
    for (args, code, part) in cases {
        let done = overcoat(folder.path(), args);
        assert_eq!(done.status.code(), Some(code), "{args:?}: {}", stderr(&done));
        assert!(stderr(&done).contains(part), "{args:?}: {}", stderr(&done));
        assert_eq!(names(folder.path()), ["walk.gltf"], "{args:?}");
    }
}
