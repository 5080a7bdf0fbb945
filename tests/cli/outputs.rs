//! Planes, masks and formats of pictures.

use super::*;

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
